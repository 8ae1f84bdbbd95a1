//! What the program says about itself while it works: one stream on stderr, and a file for every process if asked for.
//!
//! Participants inherit the filter and print to the pipe that the orchestrator reads; it passes their lines on with their
//! names. Nothing is said in the hot path of a step.

use std::fs::{DirBuilder, File};
use std::io::{self, IsTerminal, Write};
use std::os::unix::fs::DirBuilderExt;
use std::path::Path;
use std::sync::OnceLock;

use processes::console;
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::fmt::{MakeWriter, layer};
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::registry;
use tracing_subscriber::util::SubscriberInitExt;

use crate::failure::Failure;
use crate::terminal::{message_columns, wrapped};

/// Environment variable with the filter, which participants inherit.
pub const FILTER: &str = "PHALANX_LOG";
/// The orchestrator's own file in the folder of `--log-dir`.
const OWN_FILE: &str = "phalanx.log";

/// Letters of a sequence that starts or ends a colour.
const COLOUR_LETTERS: usize = 4;

/// What was chosen, for the processes that are started.
static CHOSEN: OnceLock<String> = OnceLock::new();

/// What the command line says about messages.
#[derive(Clone, Copy, Debug, Default)]
pub struct Choice<'a> {
    /// How often `-v` was given.
    pub verbose: u8,
    /// How often `-q` was given.
    pub quiet: u8,
    /// A filter by level and module.
    pub filter: Option<&'a str>,
    /// Folder of a file per process.
    pub directory: Option<&'a Path>,
}

impl Choice<'_> {
    /// The filter: of the command line, of the environment, or what the number of `-v` and `-q` stands for.
    fn filter(&self) -> String {
        let environment = || std::env::var(FILTER).ok().filter(|filter| !filter.is_empty());
        let level = match (self.quiet, self.verbose) {
            (2.., _) => "error",
            (_, 0) => "warn",
            (_, 1) => "info",
            (_, 2) => "debug",
            _ => "trace",
        };
        let explicit = self.filter.map(String::from);
        let environment = || if self.verbose + self.quiet == 0 { environment() } else { None };
        explicit.or_else(environment).unwrap_or_else(|| level.into())
    }
}

/// Starts the stream of the program.
///
/// # Errors
/// [`Failure::Usage`] for an invalid filter, [`Failure::System`] if the folder cannot be written.
pub fn start(choice: &Choice) -> Result<(), Failure> {
    let text = choice.filter();
    let filter = text.parse::<Targets>().map_err(|error| {
        Failure::Usage(format!(
            "--log-filter {text}: {error}; expected LEVEL or MODULE=LEVEL, such as orchestrator=debug"
        ))
    })?;
    let colour = coloured();
    let stderr = layer().without_time().with_ansi(colour).with_target(false).with_writer(Named { colour });
    // Else it would complain, and panic, on a terminal that was closed.
    let stderr = stderr.log_internal_errors(false);
    let file = choice.directory.map(own_file).transpose()?;
    let file = file.map(|file| layer().with_ansi(false).with_writer(std::sync::Mutex::new(file)));
    // A program that embeds this one may have set its own stream already; then that is the one.
    let _ = registry().with(filter).with(stderr).with(file).try_init();
    let _ = CHOSEN.set(text);
    Ok(())
}

/// Starts the stream of a participant, whose lines the orchestrator gathers.
pub(crate) fn start_participant() {
    let filter = std::env::var(FILTER).ok().and_then(|text| text.parse().ok());
    let filter = filter.unwrap_or_else(|| Targets::new().with_default(LevelFilter::WARN));
    let stderr = layer().without_time().with_ansi(false).with_target(false).with_writer(io::stderr);
    // As above.
    let _ = registry().with(filter).with(stderr).try_init();
}

/// The filter that processes of a run inherit.
pub(crate) fn chosen() -> &'static str {
    CHOSEN.get().map_or("warn", String::as_str)
}

/// Whether lines have colours: on a terminal, unless NO_COLOR asks for none.
fn coloured() -> bool {
    io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}

fn own_file(directory: &Path) -> Result<File, Failure> {
    let failed = || Failure::system(format!("write into the folder {}", directory.display()));
    DirBuilder::new().recursive(true).mode(0o700).create(directory).map_err(failed())?;
    console::new_file(&directory.join(OWN_FILE)).map_err(failed())
}

/// Stderr with the name of the orchestrator in front of every message, as participants have theirs.
struct Named {
    colour: bool,
}

impl<'a> MakeWriter<'a> for Named {
    type Writer = NamedLine;

    fn make_writer(&'a self) -> NamedLine {
        NamedLine { colour: self.colour }
    }
}

/// Writes one message, which comes in one piece.
struct NamedLine {
    colour: bool,
}

impl Write for NamedLine {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let name = if self.colour { "\u{1b}[1m[phalanx]\u{1b}[0m" } else { "[phalanx]" };
        let text = format!("{name} {}", String::from_utf8_lossy(bytes));
        // Sequences for colours take no columns.
        let room = message_columns().map(|columns| columns + text.matches('\u{1b}').count() * COLOUR_LETTERS);
        console::say(format!("{}\n", wrapped(text.trim_end(), room)).as_bytes());
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
