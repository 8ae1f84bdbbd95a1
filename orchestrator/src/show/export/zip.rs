//! Zip archives without compression, which is what NumPy itself writes.

use std::io::{self, Write};

const LOCAL: u32 = 0x0403_4b50;
const CENTRAL: u32 = 0x0201_4b50;
const END: u32 = 0x0605_4b50;
/// Version 2.0 of the format: plain files.
const VERSION: u16 = 20;
/// The first of January 1980: a fixed date keeps equal content equal.
const DATE: u16 = 0x21;

/// An archive while it is written.
pub(super) struct Archive<W> {
    out: W,
    /// What the directory at the end says about every member.
    directory: Vec<u8>,
    members: u16,
    offset: u32,
}

/// Content that can be produced twice: once for its checksum, once for the file.
pub(super) type Content<'a> = dyn Fn(&mut dyn Write) -> io::Result<()> + 'a;

/// Counts and sums up what is written to it.
struct Meter {
    length: u64,
    checksum: crc32fast::Hasher,
}

impl Write for Meter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.length += bytes.len() as u64;
        self.checksum.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl<W: Write> Archive<W> {
    pub(super) fn new(out: W) -> Self {
        Self { out, directory: Vec::new(), members: 0, offset: 0 }
    }

    /// Appends a member.
    ///
    /// # Errors
    /// What the operating system says; [`io::ErrorKind::FileTooLarge`] if the archive would exceed 4 GB.
    pub(super) fn add(&mut self, name: &str, content: &Content) -> io::Result<()> {
        let mut meter = Meter { length: 0, checksum: crc32fast::Hasher::new() };
        content(&mut meter)?;
        let checksum = meter.checksum.finalize();
        let length = u32::try_from(meter.length).map_err(|_| too_large())?;
        let start = self.offset;
        let mut common = Vec::new();
        // Version, flags (names are ASCII), method (stored), time, date.
        for word in [VERSION, 0, 0, 0, DATE] {
            common.extend_from_slice(&word.to_le_bytes());
        }
        for word in [checksum, length, length, name.len() as u32] {
            common.extend_from_slice(&word.to_le_bytes());
        }
        let local = [&LOCAL.to_le_bytes()[..], &common, name.as_bytes()].concat();
        self.out.write_all(&local)?;
        content(&mut self.out)?;
        let next = u64::from(start) + local.len() as u64 + u64::from(length);
        self.offset = u32::try_from(next).map_err(|_| too_large())?;
        self.members = self.members.checked_add(1).ok_or_else(too_large)?;
        self.directory.extend_from_slice(&CENTRAL.to_le_bytes());
        self.directory.extend_from_slice(&VERSION.to_le_bytes());
        self.directory.extend_from_slice(&common);
        // Comment, disk, attributes: none.
        self.directory.extend_from_slice(&[0; 10]);
        self.directory.extend_from_slice(&start.to_le_bytes());
        self.directory.extend_from_slice(name.as_bytes());
        Ok(())
    }

    /// Writes the directory.
    pub(super) fn finish(mut self) -> io::Result<W> {
        self.out.write_all(&self.directory)?;
        self.out.write_all(&END.to_le_bytes())?;
        self.out.write_all(&[0; 4])?;
        self.out.write_all(&self.members.to_le_bytes())?;
        self.out.write_all(&self.members.to_le_bytes())?;
        self.out.write_all(&(self.directory.len() as u32).to_le_bytes())?;
        self.out.write_all(&self.offset.to_le_bytes())?;
        self.out.write_all(&[0; 2])?;
        Ok(self.out)
    }
}

fn too_large() -> io::Error {
    io::Error::new(
        io::ErrorKind::FileTooLarge,
        "the archive would exceed the 4 GB of its format; use --every or --topics",
    )
}
