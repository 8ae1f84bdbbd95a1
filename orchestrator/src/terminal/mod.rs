//! The terminal: which job has it, its size, tables, and printing that survives a closed terminal.

#[macro_use]
pub(crate) mod printing;
pub(crate) mod table;

pub(crate) use printing::plain;

use std::os::fd::AsFd;
use std::path::Path;
use std::sync::OnceLock;

use rustix::io::Errno;
use rustix::process::getpgrp;
use rustix::termios::{tcgetpgrp, tcgetwinsize};

/// How the program was called, without its folder.
static PROGRAM: OnceLock<String> = OnceLock::new();

/// Remembers how the program was called: programs with catalogs of their own have names of their own.
pub(crate) fn name_program() {
    let called = std::env::args_os().next();
    let name = called.as_deref().and_then(|path| Path::new(path).file_name()?.to_str());
    if let Some(name) = name {
        let _ = PROGRAM.set(name.to_string());
    }
}

/// What advice to the user calls the program.
pub(crate) fn program() -> &'static str {
    PROGRAM.get().map_or("phalanx", String::as_str)
}

/// A message to the user with commands to type, `` `phalanx list` ``, as this program is called.
pub(crate) fn in_own_name(message: &str) -> String {
    message.replace("`phalanx ", &format!("`{} ", program()))
}

/// Columns and rows of a terminal; `None` if it is not one or does not know its size.
pub(crate) fn size_of(terminal: impl AsFd) -> Option<(usize, usize)> {
    let size = tcgetwinsize(terminal).ok()?;
    (size.ws_col > 0 && size.ws_row > 0).then_some((size.ws_col.into(), size.ws_row.into()))
}

/// Columns of the terminal that stdout is; `None` if stdout is not a terminal, so that lines may be as long as they are.
pub(crate) fn columns() -> Option<usize> {
    size_of(std::io::stdout()).map(|(columns, _)| columns)
}

/// The same for stderr, where messages go.
pub(crate) fn message_columns() -> Option<usize> {
    size_of(std::io::stderr()).map(|(columns, _)| columns)
}

/// Whether a terminal is this process's to use: that of the foreground job, or one that has no jobs.
pub(crate) fn is_ours(terminal: impl AsFd) -> bool {
    match tcgetpgrp(terminal) {
        Ok(group) => group == getpgrp(),
        // Not the controlling terminal of this process, so that no shell gives it to others.
        Err(error) => error == Errno::NOTTY,
    }
}

/// A word as a shell reads it, in quotes if need be.
pub(crate) fn quoted(text: &str) -> String {
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "/._-+=:,@%".contains(letter);
    match !text.is_empty() && text.chars().all(is_plain) {
        true => text.into(),
        false => format!("'{}'", text.replace('\'', "'\\''")),
    }
}

/// Text in lines that are not longer than `columns`, as far as its words are not; what continues is indented, more than its line. Its
/// own lines stay, and so does a command in backticks, which one can copy then.
pub(crate) fn wrapped(text: &str, columns: Option<usize>) -> String {
    const INDENT: &str = "  ";
    let Some(columns) = columns else { return text.to_string() };
    let mut lines: Vec<String> = Vec::new();
    for line in text.lines() {
        let own = &line[..line.len() - line.trim_start().len()];
        let mut current = String::new();
        for word in words(line) {
            let length = current.chars().count() + word.trim_end().chars().count();
            if length > columns && !current.trim().is_empty() {
                lines.push(current.trim_end().to_string());
                current = format!("{own}{INDENT}");
            }
            current.push_str(word);
        }
        lines.push(current);
    }
    lines.join("\n")
}

/// The words of a line, each with the spaces behind it; what stands in backticks is one word.
fn words(line: &str) -> impl Iterator<Item = &str> {
    let mut quoted = false;
    line.split_inclusive(move |letter: char| {
        quoted ^= letter == '`';
        letter == ' ' && !quoted
    })
}

/// A number of things: `1 process`, `3 processes`.
pub(crate) fn counted(count: usize, thing: &str) -> String {
    match (count, thing.ends_with('s')) {
        (1, _) => format!("1 {thing}"),
        (_, true) => format!("{count} {thing}es"),
        (_, false) => format!("{count} {thing}s"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_reads_a_word_again() {
        assert_eq!(quoted("runs/uav-TSC+plant.mcap"), "runs/uav-TSC+plant.mcap");
        assert_eq!(quoted("my runs/größe.mcap"), "'my runs/größe.mcap'");
        assert_eq!(quoted("it's.mcap"), "'it'\\''s.mcap'");
    }

    #[test]
    fn lines_break_between_words() {
        assert_eq!(wrapped("one two three\nfour", Some(8)), "one two\n  three\nfour");
        assert_eq!(wrapped("incomprehensibilities are long", Some(8)), "incomprehensibilities\n  are\n  long");
        assert_eq!(wrapped("one two three", None), "one two three");
        assert_eq!(wrapped("  one two three", Some(9)), "  one two\n    three");
        assert_eq!(wrapped("see `a command` there", Some(8)), "see\n  `a command`\n  there");
    }

    #[test]
    fn one_thing_is_singular() {
        let texts = [(1, "process"), (2, "process"), (0, "step"), (1, "step")].map(|(n, thing)| counted(n, thing));
        assert_eq!(texts, ["1 process", "2 processes", "0 steps", "1 step"]);
    }
}
