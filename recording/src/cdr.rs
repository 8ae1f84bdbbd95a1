//! The encoding of ROS 2 messages: CDR, little-endian, every number at a multiple of its size.

use super::ENCAPSULATION;

/// A message while it is written. It is used for one message after the other, so that a warm run allocates nothing.
///
/// ```
/// let mut message = recording::Cdr::new();
/// message.stamp(1_500_000_000).text("agent_1").f64s(&[1.0, 2.0]);
/// // Encapsulation; two numbers and the length of the text, 4 bytes each; the text with its zero; padding; two float64.
/// assert_eq!(message.bytes().len(), 4 + 3 * 4 + 8 + 4 + 16);
/// ```
#[derive(Debug)]
pub struct Cdr {
    bytes: Vec<u8>,
}

impl Cdr {
    /// An empty message: its encapsulation.
    pub fn new() -> Self {
        Self { bytes: ENCAPSULATION.into() }
    }

    /// Starts the next message.
    pub fn restart(&mut self) -> &mut Self {
        self.bytes.truncate(ENCAPSULATION.len());
        self
    }

    /// The message so far, with its encapsulation.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Offsets count from behind the encapsulation.
    fn align(&mut self, size: usize) {
        let written = self.bytes.len() - ENCAPSULATION.len();
        self.bytes.resize(ENCAPSULATION.len() + written.next_multiple_of(size), 0);
    }

    /// A `uint8`.
    pub fn u8(&mut self, value: u8) -> &mut Self {
        self.bytes.push(value);
        self
    }

    /// A `bool`.
    pub fn bool(&mut self, value: bool) -> &mut Self {
        self.u8(value.into())
    }

    /// A `uint64`.
    pub fn u64(&mut self, value: u64) -> &mut Self {
        self.align(8);
        self.bytes.extend_from_slice(&value.to_le_bytes());
        self
    }

    /// `builtin_interfaces/Time` of a simulated time, ns.
    pub fn stamp(&mut self, time_ns: u64) -> &mut Self {
        self.i32((time_ns / 1_000_000_000) as i32).u32((time_ns % 1_000_000_000) as u32)
    }

    /// A `uint32`.
    pub fn u32(&mut self, value: u32) -> &mut Self {
        self.align(4);
        self.bytes.extend_from_slice(&value.to_le_bytes());
        self
    }

    /// An `int32`.
    pub fn i32(&mut self, value: i32) -> &mut Self {
        self.u32(value as u32)
    }

    /// A `float32`.
    pub fn f32(&mut self, value: f32) -> &mut Self {
        self.u32(value.to_bits())
    }

    /// The elements of `float64` fields or of an array, without a length before them.
    pub fn f64s(&mut self, values: &[f64]) -> &mut Self {
        for value in values {
            self.align(8);
            self.bytes.extend_from_slice(&value.to_le_bytes());
        }
        self
    }

    /// A text: its length with the closing zero, its bytes, the zero.
    pub fn text(&mut self, value: &str) -> &mut Self {
        self.length(value.len() + 1);
        self.bytes.extend_from_slice(value.as_bytes());
        self.u8(0)
    }

    /// The number of elements that follow.
    pub fn length(&mut self, count: usize) -> &mut Self {
        self.u32(count as u32)
    }
}

impl Default for Cdr {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_at_multiples_of_their_size() {
        let mut cdr = Cdr::new();
        cdr.u8(9).f64s(&[1.0]).bool(true).u32(7).text("ab").i32(-1);
        let expected: &[&[u8]] = &[
            &[0, 1, 0, 0],
            &[9, 0, 0, 0, 0, 0, 0, 0],
            &1.0_f64.to_le_bytes(),
            &[1, 0, 0, 0],
            &[7, 0, 0, 0],
            &[3, 0, 0, 0, b'a', b'b', 0, 0],
            &[255; 4],
        ];
        assert_eq!(cdr.bytes(), expected.concat());
        assert_eq!(cdr.restart().f32(0.5).bytes(), [&ENCAPSULATION[..], &0.5_f32.to_le_bytes()].concat());
    }

    #[test]
    fn an_empty_sequence_is_its_length() {
        let mut cdr = Cdr::new();
        cdr.length(0).u32(1).length(0).f64s(&[]).u32(2);
        assert_eq!(cdr.bytes().len(), 4 + 16);
    }
}
