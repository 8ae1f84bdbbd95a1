//! Files that people write, read as far as they may be long.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::Duration;

use super::parse::SIZE_LIMIT;

/// How every log begins.
const LOG: &[u8] = b"\x89MCAP0\r\n";
/// Data may be longer than what people write by hand.
const DATA_LIMIT: usize = 64 << 20;
/// How long a pipe may be without a program that writes into it.
const PATIENCE: Duration = Duration::from_secs(5);

/// Why a file cannot be read as a text.
#[derive(Debug, thiserror::Error)]
pub enum TextError {
    /// The operating system refuses it.
    #[error("{0}")]
    System(#[from] io::Error),
    /// It is longer than such a file may be.
    #[error("it is longer than 4 MB; a scenario or the description of a robot has at most 4 MB")]
    TooLong,
    /// It is longer than a file of data may be.
    #[error("it is longer than 64 MB; a file of data has at most 64 MB")]
    DataTooLong,
    /// It is a recording.
    #[error("this is an MCAP log; give it to `phalanx report`, `phalanx info` or `phalanx replay`")]
    Log,
    /// It is no text.
    #[error("it is not a text: byte {0} is not valid UTF-8")]
    NotText(usize),
    /// It is a pipe that no program writes into.
    #[error("it is a pipe, and no program has opened it for writing within {} s", PATIENCE.as_secs())]
    NoWriter,
}

/// Reads a file that people write: a scenario, the description of a robot. No more than 4 MB of it are read, whatever it is.
///
/// # Errors
/// [`TextError`] if it is longer, a log, not a text, or cannot be read.
pub fn read_text(path: &Path) -> Result<String, TextError> {
    read_within(path, PATIENCE, SIZE_LIMIT, TextError::TooLong)
}

/// Reads the first bytes of a file, one more than the limit.
pub(crate) fn read_bytes(path: &Path, limit: usize) -> Result<Vec<u8>, TextError> {
    let mut bytes = Vec::new();
    open(path, PATIENCE)?.take(limit as u64 + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Reads a file of data that a scenario names. No more than 64 MB of it are read.
///
/// # Errors
/// [`TextError`] as for [`read_text`].
pub fn read_data(path: &Path) -> Result<String, TextError> {
    read_within(path, PATIENCE, DATA_LIMIT, TextError::DataTooLong)
}

fn read_within(path: &Path, patience: Duration, limit: usize, too_long: TextError) -> Result<String, TextError> {
    let bytes = limited(open(path, patience)?, limit)?;
    if bytes.starts_with(LOG) {
        return Err(TextError::Log);
    }
    if bytes.len() > limit {
        return Err(too_long);
    }
    String::from_utf8(bytes).map_err(|error| TextError::NotText(error.utf8_error().valid_up_to()))
}

/// The first bytes of the file, one more than a text may have.
fn limited(file: File, limit: usize) -> io::Result<Vec<u8>> {
    let mut file = file.take(limit as u64 + 1);
    let mut bytes = vec![0; LOG.len()];
    let mut length = 0;
    // A log is known by its start, and may be long.
    while length < LOG.len() {
        match file.read(&mut bytes[length..])? {
            0 => break,
            count => length += count,
        }
    }
    bytes.truncate(length);
    if bytes != LOG {
        file.read_to_end(&mut bytes)?;
    }
    Ok(bytes)
}

/// Whether it is a pipe with a name.
#[cfg(unix)]
fn is_pipe(path: &Path) -> io::Result<bool> {
    Ok(std::os::unix::fs::FileTypeExt::is_fifo(&std::fs::metadata(path)?.file_type()))
}

#[cfg(not(unix))]
fn is_pipe(_: &Path) -> io::Result<bool> {
    Ok(false)
}

/// Opens the file. Opening a pipe waits until a program writes into it, so a separate thread does it.
fn open(path: &Path, patience: Duration) -> Result<File, TextError> {
    if !is_pipe(path)? {
        return Ok(File::open(path)?);
    }
    let (sender, receiver) = mpsc::channel();
    let path = PathBuf::from(path);
    std::thread::Builder::new().spawn(move || {
        // After the time-out there is no receiver.
        let _ = sender.send(File::open(path));
    })?;
    receiver.recv_timeout(patience).map_err(|_| TextError::NoWriter)?.map_err(TextError::System)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(path: &str) -> String {
        read_within(Path::new(path), Duration::from_millis(1), SIZE_LIMIT, TextError::TooLong).unwrap_err().to_string()
    }

    #[test]
    fn what_has_no_end_is_refused_after_four_megabytes() {
        assert!(refusal("/dev/zero").contains("at most 4 MB"));
        assert!(refusal("/dev/urandom").contains("at most 4 MB"));
        assert_eq!(read_text(Path::new("/dev/null")).unwrap(), "");
        assert!(refusal("/nowhere/s.toml").contains("No such file"));
        assert!(refusal("/").contains("directory"));
    }

    #[test]
    fn a_log_is_known_by_its_start() {
        let path = std::env::temp_dir().join(format!("phalanx-text-{}", std::process::id()));
        let file = File::create(&path).unwrap();
        std::fs::write(&path, LOG).unwrap();
        // A sparse file: none of it takes room on the disk, all of it would take memory.
        file.set_len(1 << 40).unwrap();
        let found = read_text(&path).unwrap_err().to_string();
        std::fs::write(&path, b"a = 1\n\xff").unwrap();
        let other = read_text(&path).unwrap_err().to_string();
        std::fs::remove_file(&path).unwrap();
        assert!(found.contains("this is an MCAP log"), "{found}");
        assert!(other.contains("byte 6"), "{other}");
    }
}
