//! What a log says, in 64 digits.

use std::fs::File;
use std::io;
use std::path::Path;

use sha2::{Digest, Sha256};

use super::Log;

impl Log {
    /// SHA-256 of all samples: topics, fields, steps, status and the bits of all numbers; not of what stands beside them, such
    /// as titles, bands or versions. 64 lower-case hexadecimal digits.
    pub fn digest(&self) -> String {
        let mut digest = Sha256::new();
        for time in self.times() {
            digest.update(time.to_le_bytes());
        }
        for channel in self.channels() {
            let Some(layout) = &channel.layout else { continue };
            digest.update(channel.topic.as_bytes());
            digest.update(layout.ros2msg().as_bytes());
            for number in channel.numbers() {
                digest.update(number.to_bits().to_le_bytes());
            }
        }
        text_of(digest)
    }
}

/// SHA-256 of a file, in hexadecimal digits.
///
/// # Errors
/// What the operating system says.
pub fn file_digest(path: &Path) -> io::Result<String> {
    let mut file = File::open(path)?;
    let mut digest = Sha256::new();
    io::copy(&mut file, &mut digest)?;
    Ok(text_of(digest))
}

/// SHA-256 of some bytes, in hexadecimal digits.
pub(super) fn hex(bytes: &[u8]) -> String {
    text_of(Sha256::new_with_prefix(bytes))
}

fn text_of(digest: Sha256) -> String {
    digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}
