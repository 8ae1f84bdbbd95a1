//! Text on the terminal: how much room there is for it, and printing that survives a closed terminal.

#[macro_use]
pub(crate) mod printing;

pub(crate) use printing::plain;

use std::io::IsTerminal;

/// Columns of the terminal that stdout is; `None` if it is none, where lines may be as long as they are.
pub(crate) fn columns() -> Option<usize> {
    let known = || terminal_size::terminal_size_of(std::io::stdout()).map(|(width, _)| usize::from(width.0));
    std::io::stdout().is_terminal().then(known).flatten().filter(|columns| *columns > 0)
}

/// Text in lines that are not longer than `columns`, as far as its words are not; what goes on is indented. Its own lines stay.
pub(crate) fn wrapped(text: &str, columns: Option<usize>) -> String {
    const INDENT: &str = "  ";
    let Some(columns) = columns else { return text.to_string() };
    let mut lines: Vec<String> = Vec::new();
    for line in text.lines() {
        let mut current = String::new();
        for word in line.split_inclusive(' ') {
            let length = current.chars().count() + word.trim_end().chars().count();
            if length > columns && !current.trim().is_empty() {
                lines.push(current.trim_end().to_string());
                current = INDENT.into();
            }
            current.push_str(word);
        }
        lines.push(current);
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_break_between_words() {
        assert_eq!(wrapped("one two three\nfour", Some(8)), "one two\n  three\nfour");
        assert_eq!(wrapped("incomprehensibilities are long", Some(8)), "incomprehensibilities\n  are\n  long");
        assert_eq!(wrapped("one two three", None), "one two three");
    }
}
