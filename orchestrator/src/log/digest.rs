//! What a log says, in 64 digits.

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
        digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}
