//! The references of C and C++, from the comments and declarations of the headers.

use std::fmt::Write;

use crate::repository;

fn header(name: &str) -> String {
    std::fs::read_to_string(repository("capi/include").join(name)).expect("a header")
}

/// The reference of `phalanx.h`: its introduction, then every section with its functions.
pub fn page() -> String {
    let text = header("phalanx.h");
    let (introduction, rest) = text.split_once("*/").expect("a comment at the top");
    let introduction =
        introduction.trim_start_matches("/*").lines().map(|line| line.trim_start().trim_start_matches('*'));
    let introduction = introduction.map(|line| line.strip_prefix(' ').unwrap_or(line));
    // The command below the example is code as well.
    let introduction = introduction.map(|line| line.replacen("and then: ", "and then\n\n    ", 1));
    let mut page = introduction.collect::<Vec<_>>().join("\n");
    page.push_str("\n\n## The library and the place in the run\n");
    let (mut comment, mut declaration) = (String::new(), String::new());
    let mut in_comment = false;
    for line in rest.lines().map(str::trim) {
        if in_comment || line.starts_with("/*") {
            let words = line.trim_start_matches("/*").trim_end_matches("*/").trim_start_matches('*').trim();
            if line.starts_with("/*") {
                comment.clear();
            }
            comment.push_str(words);
            comment.push(' ');
            in_comment = !line.ends_with("*/");
            if let Some(title) = comment.trim().strip_prefix("----").and_then(|title| title.strip_suffix("----")) {
                write!(page, "\n## {}\n", title.trim().trim_end_matches('.')).expect("a text grows");
                comment.clear();
            }
        } else if line.is_empty() || line.starts_with("#if") || line.starts_with("#endif") || line.starts_with("extern")
        {
            comment.clear();
        } else if line.starts_with("#define") && !comment.is_empty() {
            let name = line.split_whitespace().nth(1).expect("a name");
            entry(&mut page, name, "c", line, &comment);
        } else if !line.starts_with('#') && line != "}" {
            declaration.push_str(line);
            if declaration.ends_with(';') {
                entry(&mut page, declared(&declaration), "c", &declaration, &comment);
                declaration.clear();
            } else {
                declaration.push('\n');
            }
        }
    }
    page
}

/// The reference of `phalanx.hpp`: what stands below a comment in the public parts of its classes, and `serve`.
pub fn cpp_page() -> String {
    let text = header("phalanx.hpp");
    let (_, body) = text.split_once("namespace phalanx {").expect("the namespace");
    let mut page = String::new();
    let (mut comment, mut is_private) = (String::new(), false);
    for line in body.lines() {
        let is_top = !line.starts_with(' ');
        let line = line.trim();
        if is_top && line.ends_with("};") {
            is_private = false;
        }
        match line {
            "private:" => is_private = true,
            "public:" => is_private = false,
            _ => {}
        }
        if let Some(words) = line.strip_prefix("//") {
            comment.push_str(words.trim());
            comment.push(' ');
        } else if !comment.is_empty() {
            if !is_private {
                let code = line.split(" {").next().expect("a part").split(" : ").next().expect("a part");
                let is_class = code.contains("class ") && is_top && !code.contains('(');
                let code = code.trim_end_matches(';');
                if is_class {
                    let name = code.rsplit("class ").next().expect("a name");
                    write!(page, "\n## `{name}`\n\n{}\n", comment.trim()).expect("a text grows");
                } else {
                    entry(&mut page, declared(code), "cpp", code, &comment);
                }
            }
            comment.clear();
        }
    }
    page
}

/// The name that a declaration declares.
fn declared(declaration: &str) -> &str {
    let head = declaration.split('(').next().expect("a part").trim_end_matches(';');
    let head = head.rsplit([' ', '*', '&']).next().expect("a name");
    head.trim()
}

fn entry(page: &mut String, name: &str, language: &str, declaration: &str, comment: &str) {
    write!(page, "\n### `{name}`\n\n```{language}\n{declaration}\n```\n").expect("a text grows");
    if !comment.is_empty() {
        write!(page, "\n{}\n", comment.trim()).expect("a text grows");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_function_of_the_header_has_an_entry() {
        let (page, header) = (page(), header("phalanx.h"));
        let declared: Vec<&str> =
            header.lines().filter(|line| line.contains('(') && line.ends_with(");")).map(declared).collect();
        assert!(declared.len() > 40, "{declared:?}");
        for name in declared.iter().filter(|name| name.starts_with("phalanx_")) {
            assert!(page.contains(&format!("\n### `{name}`\n")), "{name} is missing:\n{page}");
        }
        assert!(page.contains("Fails with NULL if there is no such text."), "{page}");
    }

    #[test]
    fn the_classes_of_cpp_have_their_public_members() {
        let page = cpp_page();
        for part in ["## `Participant`", "### `neighbours`", "### `serve`", "bool has(const std::string &name) const"] {
            assert!(page.contains(part), "{part} is missing:\n{page}");
        }
        assert!(!page.contains("check_version"), "{page}");
    }
}
