//! Samples in iceoryx2 blackboards: a few sizes of cell, because a service needs types and layouts are data.
//!
//! A channel is a ring of cells. Its handles stand in one piece and not behind a pointer each: where hundreds of processes take
//! turns on a core, every page and every line of memory that a step touches has to be fetched anew.

use std::mem::MaybeUninit;

use iceoryx2::port::reader::{EntryHandle, EntryHandleError, Reader};
use iceoryx2::port::writer::{EntryHandleMut, EntryHandleMutError, Writer};
use iceoryx2::prelude::ZeroCopySend;
use iceoryx2::service::builder::blackboard::Creator;
use iceoryx2::service::ipc;

use lockstep::Header;

/// Cells of a channel: the sample of step k is replaced by that of step k + `RING`.
pub(crate) const RING: u64 = 8;

/// The sample of one step of one channel in shared memory; what is behind the channel's last word is never read.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct Cell<const W: usize> {
    header: Header,
    /// See [`crate::seal`]; 0 before anything is written.
    seal: u64,
    words: [MaybeUninit<f64>; W],
}

impl<const W: usize> Cell<W> {
    fn empty() -> Self {
        Self { header: Header::default(), seal: 0, words: [MaybeUninit::new(f64::NAN); W] }
    }
}

/// The key of a cell within a service: `place` in the ring of channel number `number` of the service.
fn key(number: usize, place: u64) -> u64 {
    RING * number as u64 + place
}

type Reads<const W: usize> = [EntryHandle<ipc::Service, u64, Cell<W>>; RING as usize];
/// A loan consumes the entry and an update gives it back; in between the place is empty.
type Writes<const W: usize> = [Option<EntryHandleMut<ipc::Service, u64, Cell<W>>>; RING as usize];

fn add<const W: usize>(creator: Creator<u64, ipc::Service>, number: usize) -> Creator<u64, ipc::Service>
where
    Cell<W>: ZeroCopySend,
{
    (0..RING).fold(creator, |creator, place| creator.add(key(number, place), Cell::<W>::empty()))
}

fn reads<const W: usize>(port: &Reader<ipc::Service, u64>, number: usize) -> Result<Reads<W>, EntryHandleError>
where
    Cell<W>: ZeroCopySend,
{
    let entries = (0..RING).map(|place| port.entry(&key(number, place)));
    Ok(whole(entries.collect::<Result<_, _>>()?))
}

fn writes<const W: usize>(port: &Writer<ipc::Service, u64>, number: usize) -> Result<Writes<W>, EntryHandleMutError>
where
    Cell<W>: ZeroCopySend,
{
    let entries = (0..RING).map(|place| port.entry(&key(number, place)).map(Some));
    Ok(whole(entries.collect::<Result<_, _>>()?))
}

/// A ring has `RING` entries by its making.
fn whole<T>(entries: Vec<T>) -> [T; RING as usize] {
    entries.try_into().unwrap_or_else(|_| unreachable!("an entry for every place"))
}

fn read<const W: usize>(ring: &Reads<W>, place: usize, words: &mut [f64]) -> (Header, u64)
where
    Cell<W>: ZeroCopySend,
{
    let cell = ring[place].get();
    // SAFETY: the first `words.len()` words were written by `empty` or by `write`, whose callers publish samples of the same
    // layout; the pointer is that of an array of f64 of which the slice is a part.
    let written = unsafe { std::slice::from_raw_parts(cell.words[..words.len()].as_ptr().cast(), words.len()) };
    words.copy_from_slice(written);
    (cell.header, cell.seal)
}

fn write<const W: usize>(ring: &mut Writes<W>, place: usize, (header, seal): (&Header, u64), words: &[f64])
where
    Cell<W>: ZeroCopySend,
{
    let Some(entry) = ring[place].take() else { return };
    let mut loan = entry.loan_uninit();
    let cell = loan.value_mut().as_mut_ptr();
    // SAFETY: the loan is a cell of shared memory that no process reads until the update. The header is written whole; the words
    // may stay unwritten where the sample ends, since their type allows for it.
    ring[place] = Some(unsafe {
        (&raw mut (*cell).header).write(*header);
        (&raw mut (*cell).seal).write(seal);
        let place = &mut (&mut (*cell).words)[..words.len()];
        std::ptr::copy_nonoverlapping(words.as_ptr(), place.as_mut_ptr().cast(), words.len());
        loan.assume_init_and_update()
    });
}

/// Implements the type names, lists the classes, smallest first, and makes a ring of each.
macro_rules! size_classes {
    ($($class:ident $words:literal)*) => {
        $(
            // SAFETY: a plain repr(C) struct of numbers without pointers or padding.
            unsafe impl ZeroCopySend for Cell<$words> {
                unsafe fn type_name() -> &'static str {
                    concat!("PhalanxCell", $words)
                }
            }
        )*

        /// A size of cell.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Class {
            $($class = $words,)*
        }

        const CLASSES: &[Class] = &[$(Class::$class),*];

        impl Class {
            /// Bytes of a cell.
            pub(crate) fn bytes(self) -> usize {
                match self {
                    $(Self::$class => size_of::<Cell<$words>>(),)*
                }
            }

            /// Adds the empty cells of channel number `number` to a service that is about to be created.
            pub(crate) fn add(
                self,
                creator: Creator<u64, ipc::Service>,
                number: usize,
            ) -> Creator<u64, ipc::Service> {
                match self {
                    $(Self::$class => add::<$words>(creator, number),)*
                }
            }

            /// Opens the cells of a channel for reading.
            pub(crate) fn reader(
                self,
                port: &Reader<ipc::Service, u64>,
                number: usize,
            ) -> Result<ReadRing, EntryHandleError> {
                Ok(match self {
                    $(Self::$class => ReadRing::$class(reads(port, number)?),)*
                })
            }

            /// Opens the cells of a channel for writing.
            pub(crate) fn writer(
                self,
                port: &Writer<ipc::Service, u64>,
                number: usize,
            ) -> Result<WriteRing, EntryHandleMutError> {
                Ok(match self {
                    $(Self::$class => WriteRing::$class(writes(port, number)?),)*
                })
            }
        }

        /// The cells of a channel, to read.
        pub(crate) enum ReadRing {
            $($class(Reads<$words>),)*
        }

        impl ReadRing {
            /// Copies the words of the sample in the cell of `step` and returns its header and its seal. `words` must not be
            /// longer than the cell.
            #[unsafe(link_section = "lockstep_step")]
            pub(crate) fn read(&self, step: u64, words: &mut [f64]) -> (Header, u64) {
                let place = (step % RING) as usize;
                match self {
                    $(Self::$class(ring) => read(ring, place, words),)*
                }
            }
        }

        /// The cells of a channel, to write.
        pub(crate) enum WriteRing {
            $($class(Writes<$words>),)*
        }

        impl WriteRing {
            /// Publishes the sample of `step` with its seal. `words` must not be longer than the cell.
            #[unsafe(link_section = "lockstep_step")]
            pub(crate) fn write(&mut self, step: u64, header: (&Header, u64), words: &[f64]) {
                let place = (step % RING) as usize;
                match self {
                    $(Self::$class(ring) => write(ring, place, header, words),)*
                }
            }
        }
    };
}

size_classes!(W4 4 W8 8 W16 16 W32 32 W64 64 W128 128 W256 256 W512 512);

/// The smallest class that holds `words`; `None` beyond [`MAX_WORDS`].
pub(crate) fn class_for(words: usize) -> Option<Class> {
    CLASSES.iter().copied().find(|&class| class as usize >= words)
}

#[cfg(test)]
mod tests {
    use lockstep::MAX_WORDS;

    use super::*;

    #[test]
    fn the_smallest_cell_that_fits_is_taken() {
        let size = |words| class_for(words).map(|class| class as usize);
        assert_eq!([size(0), size(4), size(5), size(MAX_WORDS)], [Some(4), Some(4), Some(8), Some(512)]);
        assert_eq!(size(MAX_WORDS + 1), None);
        assert_eq!(size_of::<Cell<16>>(), lockstep::HEADER_BYTES + 8 + 16 * 8);
    }
}
