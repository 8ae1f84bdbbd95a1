//! One signal of a log over all its steps.

use super::numbers::{Arena, Numbers};

/// The values of a field, one row per step; a view into the log.
#[derive(Clone, Copy, Debug)]
pub struct Series<'a> {
    /// Samples of the whole channel, one after the other.
    data: &'a [f64],
    /// Where they are, if not in memory.
    arena: Option<&'a Arena>,
    /// Numbers of one sample.
    stride: usize,
    /// Place of the field in it.
    offset: usize,
    width: usize,
}

impl<'a> Series<'a> {
    pub(super) fn of(numbers: &'a Numbers, stride: usize, offset: usize, width: usize) -> Self {
        Self { data: numbers, arena: numbers.arena(), stride, offset, width }
    }

    fn use_page(arena: Option<&Arena>) {
        if let Some(arena) = arena {
            arena.use_page();
        }
    }

    /// Values per row: 1 for a scalar, n for a vector of n.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows: recorded steps.
    pub fn len(&self) -> usize {
        self.data.len() / self.stride
    }

    /// Whether no step was recorded.
    pub fn is_empty(&self) -> bool {
        self.data.is_empty()
    }

    /// The values of the `index`-th recorded step. Like a slice, panics if there are not that many.
    pub fn row(&self, index: usize) -> &'a [f64] {
        Self::use_page(self.arena);
        let start = index * self.stride + self.offset;
        &self.data[start..start + self.width]
    }

    /// All rows in order.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &'a [f64]> + use<'a> {
        let (arena, offset, width) = (self.arena, self.offset, self.width);
        self.data.chunks_exact(self.stride).map(move |sample| {
            Self::use_page(arena);
            &sample[offset..offset + width]
        })
    }

    /// The `component`-th value of every row, from 0. Panics if a row is shorter.
    pub fn component(&self, component: usize) -> impl ExactSizeIterator<Item = f64> + use<'a> {
        self.rows().map(move |row| row[component])
    }
}
