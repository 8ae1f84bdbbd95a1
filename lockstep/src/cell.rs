//! Samples in iceoryx2 blackboards: a few sizes of cell, because a service needs types and layouts are data.

use std::mem::MaybeUninit;

use iceoryx2::port::reader::{EntryHandle, EntryHandleError, Reader};
use iceoryx2::port::writer::{EntryHandleMut, EntryHandleMutError, Writer};
use iceoryx2::prelude::ZeroCopySend;
use iceoryx2::service::builder::blackboard::Creator;
use iceoryx2::service::ipc;

use crate::Header;

/// Largest number of words of a sample.
pub const MAX_WORDS: usize = 512;

/// The sample of one step of one channel in shared memory; what is behind the channel's last word is never read.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
struct Cell<const W: usize> {
    header: Header,
    words: [MaybeUninit<f64>; W],
}

impl<const W: usize> Cell<W> {
    fn empty() -> Self {
        Self { header: Header::default(), words: [MaybeUninit::new(0.0); W] }
    }
}

/// Writes one cell.
pub(crate) trait WriteCell {
    /// Publishes a sample. `words` must not be longer than the cell.
    fn write(&mut self, header: &Header, words: &[f64]);
}

/// Reads one cell.
pub(crate) trait ReadCell {
    /// Copies the words of the cell's sample and returns its header. `words` must not be longer than the cell.
    fn read(&self, words: &mut [f64]) -> Header;
}

/// A size of cell.
pub(crate) trait SizeClass: Sync {
    /// How many words fit.
    fn words(&self) -> usize;
    /// Bytes of a cell.
    fn bytes(&self) -> usize;
    /// Adds an empty cell to a service that is about to be created.
    fn add(&self, creator: Creator<u64, ipc::Service>, key: u64) -> Creator<u64, ipc::Service>;
    /// Opens a cell for reading.
    fn reader(&self, port: &Reader<ipc::Service, u64>, key: u64) -> Result<Box<dyn ReadCell>, EntryHandleError>;
    /// Opens a cell for writing.
    fn writer(&self, port: &Writer<ipc::Service, u64>, key: u64) -> Result<Box<dyn WriteCell>, EntryHandleMutError>;
}

struct Class<const W: usize>;

impl<const W: usize> SizeClass for Class<W>
where
    Cell<W>: ZeroCopySend,
{
    fn words(&self) -> usize {
        W
    }

    fn bytes(&self) -> usize {
        size_of::<Cell<W>>()
    }

    fn add(&self, creator: Creator<u64, ipc::Service>, key: u64) -> Creator<u64, ipc::Service> {
        creator.add(key, Cell::<W>::empty())
    }

    fn reader(&self, port: &Reader<ipc::Service, u64>, key: u64) -> Result<Box<dyn ReadCell>, EntryHandleError> {
        Ok(Box::new(port.entry::<Cell<W>>(&key)?))
    }

    fn writer(&self, port: &Writer<ipc::Service, u64>, key: u64) -> Result<Box<dyn WriteCell>, EntryHandleMutError> {
        Ok(Box::new(Writing { entry: Some(port.entry::<Cell<W>>(&key)?) }))
    }
}

impl<const W: usize> ReadCell for EntryHandle<ipc::Service, u64, Cell<W>>
where
    Cell<W>: ZeroCopySend,
{
    fn read(&self, words: &mut [f64]) -> Header {
        let cell = *self.get();
        // SAFETY: the first `words.len()` words were written by `empty` or by `WriteCell::write`, whose callers publish
        // samples of the same layout; the pointer is that of an array of f64 of which the slice is a part.
        let written = unsafe { std::slice::from_raw_parts(cell.words[..words.len()].as_ptr().cast(), words.len()) };
        words.copy_from_slice(written);
        cell.header
    }
}

/// A loan consumes the entry and an update gives it back; in between the place is empty.
struct Writing<const W: usize> {
    entry: Option<EntryHandleMut<ipc::Service, u64, Cell<W>>>,
}

impl<const W: usize> WriteCell for Writing<W>
where
    Cell<W>: ZeroCopySend,
{
    fn write(&mut self, header: &Header, words: &[f64]) {
        let Some(entry) = self.entry.take() else { return };
        let mut loan = entry.loan_uninit();
        let cell = loan.value_mut().as_mut_ptr();
        // SAFETY: the loan is a cell of shared memory that nobody reads until the update. The header is written whole;
        // the words may stay unwritten where the sample ends, since their type allows for it.
        self.entry = Some(unsafe {
            (&raw mut (*cell).header).write(*header);
            let place = &mut (&mut (*cell).words)[..words.len()];
            std::ptr::copy_nonoverlapping(words.as_ptr(), place.as_mut_ptr().cast(), words.len());
            loan.assume_init_and_update()
        });
    }
}

/// Implements the type names and lists the classes, smallest first.
macro_rules! size_classes {
    ($($words:literal)*) => {
        $(
            // SAFETY: a plain repr(C) struct of numbers without pointers or padding.
            unsafe impl ZeroCopySend for Cell<$words> {
                unsafe fn type_name() -> &'static str {
                    concat!("PhalanxCell", $words)
                }
            }
        )*
        static CLASSES: &[&dyn SizeClass] = &[$(&Class::<$words>),*];
    };
}

size_classes!(4 8 16 32 64 128 256 512);

/// The smallest class that holds `words`; `None` beyond [`MAX_WORDS`].
pub(crate) fn class_for(words: usize) -> Option<&'static dyn SizeClass> {
    CLASSES.iter().copied().find(|class| class.words() >= words)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_cell_that_fits_is_taken() {
        let size = |words| class_for(words).map(|class| class.words());
        assert_eq!([size(0), size(4), size(5), size(MAX_WORDS)], [Some(4), Some(4), Some(8), Some(512)]);
        assert_eq!(size(MAX_WORDS + 1), None);
        assert_eq!(size_of::<Cell<16>>(), crate::HEADER_BYTES + 16 * 8);
    }
}
