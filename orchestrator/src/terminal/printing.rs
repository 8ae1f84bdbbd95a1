//! What this program prints: `println!`, `print!` and `eprintln!` that, unlike those of the standard library, do not panic when the
//! terminal or the pipe is closed: a run has to end in order then, too.

use std::borrow::Cow;
use std::fmt::Arguments;
use std::io::{self, Write};
use std::sync::OnceLock;
use std::time::Duration;

use processes::console;

use super::{message_columns, wrapped};

/// 128 and the number of SIGPIPE, as a shell reports it of a program that does not ignore that signal.
const READER_GONE: i32 = 141;

/// The first error of what was printed.
static UNWRITTEN: OnceLock<io::Error> = OnceLock::new();

/// How long stderr may take no byte at all before it counts as not read.
const PATIENCE: Duration = Duration::from_millis(300);

macro_rules! print {
    ($($text:tt)*) => { $crate::terminal::printing::print(format_args!($($text)*), "") };
}

macro_rules! println {
    () => { $crate::terminal::printing::print(format_args!(""), "\n") };
    ($($text:tt)*) => { $crate::terminal::printing::print(format_args!($($text)*), "\n") };
}

macro_rules! eprintln {
    () => { $crate::terminal::printing::complain(format_args!("")) };
    ($($text:tt)*) => { $crate::terminal::printing::complain(format_args!($($text)*)) };
}

/// Prints control sequences of our making, as they are. What comes from a file does not belong in here, except through [`plain`].
macro_rules! draw {
    ($($text:tt)*) => { $crate::terminal::printing::draw(format_args!($($text)*)) };
}

/// Prints a result. If the reader has closed the pipe, as `head` does, the program ends without a message, like other programs.
pub(crate) fn print(text: Arguments, end: &str) {
    // What was said before it stands before it.
    settle();
    let mut out = io::stdout().lock();
    let text = readable(&text.to_string()).into_owned();
    let printed = out.write_all(text.as_bytes()).and_then(|()| out.write_all(end.as_bytes()));
    note(printed);
}

/// Ends the program when the reader of what it prints has gone; remembers any other error.
fn note(printed: io::Result<()>) {
    match printed {
        Ok(()) => {}
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => std::process::exit(READER_GONE),
        Err(error) => drop(UNWRITTEN.set(error)),
    }
}

/// Writes all that was printed; why something could not be.
pub(crate) fn finish() -> Option<&'static io::Error> {
    note(io::stdout().flush());
    settle();
    UNWRITTEN.get()
}

/// Prints a message on stderr, in lines that fit if that is a terminal. If stderr is closed, the message is lost and the program
/// continues.
pub(crate) fn complain(text: Arguments) {
    let text = text.to_string();
    console::say(format!("{}\n", wrapped(&readable(&text), message_columns())).as_bytes());
}

/// Waits until all messages stand on stderr, unless nothing reads them.
pub(crate) fn settle() {
    console::flush(PATIENCE);
}

/// What [`draw!`] does.
pub(crate) fn draw(text: Arguments) {
    let mut out = io::stdout().lock();
    note(out.write_fmt(text));
}

/// Text from a log, a scenario or elsewhere, as one line that cannot move the cursor, change colours or turn the direction of
/// letters: characters that are not seen are written as JSON writes them, `\u001b`.
pub(crate) fn plain(text: &str) -> Cow<'_, str> {
    escaped(text, |_, _| false)
}

/// The same for text of several lines and columns.
fn readable(text: &str) -> Cow<'_, str> {
    escaped(text, |letter, next| matches!((letter, next), ('\n' | '\t', _) | ('\r', Some('\n'))))
}

fn escaped(text: &str, may_stay: impl Fn(char, Option<char>) -> bool) -> Cow<'_, str> {
    if !text.chars().any(is_unseen) {
        return text.into();
    }
    let mut result = String::with_capacity(text.len() + 16);
    let mut letters = text.chars().peekable();
    while let Some(letter) = letters.next() {
        match is_unseen(letter) && !may_stay(letter, letters.peek().copied()) {
            true => result.push_str(&format!("\\u{:04x}", u32::from(letter))),
            false => result.push(letter),
        }
    }
    result.into()
}

/// Control characters, line separators, and marks that change the direction of what follows.
fn is_unseen(letter: char) -> bool {
    let turns =
        matches!(letter, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    letter.is_control() || turns || matches!(letter, '\u{2028}' | '\u{2029}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_commands_a_terminal_is_spelled_out() {
        assert_eq!(plain("agent 1, größer"), "agent 1, größer");
        assert_eq!(
            plain("\u{1b}[2J\u{9b}31m\u{7f}\r\n\tx\u{202e}"),
            "\\u001b[2J\\u009b31m\\u007f\\u000d\\u000a\\u0009x\\u202e"
        );
        assert_eq!(readable("a\n\tb\r\nc\rd\u{1b}"), "a\n\tb\r\nc\\u000dd\\u001b");
        let json = serde_json::json!({ "name": "\u{9b}\u{7f}" });
        let again: serde_json::Value = serde_json::from_str(&readable(&json.to_string())).unwrap();
        assert_eq!(again, json, "JSON stays what it was");
    }
}
