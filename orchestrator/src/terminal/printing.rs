//! What this program prints: `println!`, `print!` and `eprintln!` that do not panic, as those of the standard library do, when the
//! terminal was closed or nobody reads any more. A run has to end in order then, too.

use std::fmt::Arguments;
use std::io::{self, Write};

/// 128 and the number of SIGPIPE, as a shell reports it of a program that does not ignore that signal.
const READER_GONE: i32 = 141;

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

/// Prints what was asked for. When whoever reads it has gone, as `head` does, the program ends without a word, like any other.
pub(crate) fn print(text: Arguments, end: &str) {
    let mut out = io::stdout().lock();
    let printed = out.write_fmt(text).and_then(|()| out.write_all(end.as_bytes()));
    if printed.is_err_and(|error| error.kind() == io::ErrorKind::BrokenPipe) {
        std::process::exit(READER_GONE);
    }
}

/// Prints a message on stderr. If that is closed, nobody can be told, and nothing else changes.
pub(crate) fn complain(text: Arguments) {
    let mut out = io::stderr().lock();
    let _ = out.write_fmt(text).and_then(|()| out.write_all(b"\n"));
}
