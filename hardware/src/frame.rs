//! The frame: what crosses a wire, between the host and a robot, and from the cameras. All numbers are little-endian.
//!
//! | bytes        | what                                                     |
//! |--------------|----------------------------------------------------------|
//! | 0 to 3       | `PHLX`                                                   |
//! | 4            | version, 1                                               |
//! | 5            | kind                                                     |
//! | 6, 7         | 0                                                        |
//! | 8 to 11      | sequence number, `u32`                                   |
//! | 12 to 19     | time stamp in ns, `u64`                                  |
//! | 20 to 23     | n, bytes of the payload, `u32`, at most 256              |
//! | 24 to 23 + n | payload                                                  |
//! | the last 4   | CRC-32 (IEEE, as of zlib) of all bytes before, `u32`     |

use thiserror::Error;

/// The first four bytes.
pub const MAGIC: [u8; 4] = *b"PHLX";
/// The version of the format.
pub const VERSION: u8 = 1;
/// Bytes before the payload.
pub const HEADER: usize = 24;
/// Bytes behind the payload.
pub const TRAILER: usize = 4;
/// Most bytes of a payload.
pub const MAX_PAYLOAD: usize = 256;
/// Most bytes of a frame.
pub const MAX_FRAME: usize = HEADER + MAX_PAYLOAD + TRAILER;

/// What a frame is about. The layouts of the payloads are in [`message`](crate::message).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// Host to robot: asks for control.
    Hello = 1,
    /// Robot to host: grants it.
    Welcome = 2,
    /// Robot to host: refuses it.
    Refused = 3,
    /// Host to robot: the input from now on.
    Command = 4,
    /// Robot to host: the command arrived.
    Acknowledge = 5,
    /// Host to robot: stop now.
    Halt = 6,
    /// Cameras to host: where a body is.
    Pose = 7,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Kind; 7] =
        [Kind::Hello, Kind::Welcome, Kind::Refused, Kind::Command, Kind::Acknowledge, Kind::Halt, Kind::Pose];

    fn of(byte: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| *kind as u8 == byte)
    }
}

/// An invalid frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum FrameError {
    /// It does not begin as a frame does.
    #[error("the first bytes are not PHLX")]
    Magic,
    /// It is of another version.
    #[error("version {0}, expected {VERSION}")]
    Version(u8),
    /// There is no such kind.
    #[error("no kind of frame has the number {0}")]
    Kind(u8),
    /// The two bytes that have to be 0 are not.
    #[error("bytes 6 and 7 are not 0")]
    Reserved,
    /// The payload is too long, or not as long as its kind demands, or the datagram is not as long as its header says.
    #[error("a length of {0} bytes, which cannot be")]
    Length(usize),
    /// Some bits were changed on the way.
    #[error("the checksum does not fit")]
    Checksum,
    /// A field of the payload holds what it must not.
    #[error("{0}")]
    Content(&'static str),
}

/// A frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// What it is about.
    pub kind: Kind,
    /// Its number; one more than that of the frame before.
    pub sequence: u32,
    /// When, in ns, by the clock of the sender; in lockstep: simulated time.
    pub stamp: u64,
    /// What it says.
    pub payload: Vec<u8>,
}

impl Frame {
    /// The frame as bytes.
    pub fn encode(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(HEADER + self.payload.len() + TRAILER);
        bytes.extend(MAGIC);
        bytes.extend([VERSION, self.kind as u8, 0, 0]);
        bytes.extend(self.sequence.to_le_bytes());
        bytes.extend(self.stamp.to_le_bytes());
        bytes.extend((self.payload.len() as u32).to_le_bytes());
        bytes.extend(&self.payload);
        let checksum = crc32fast::hash(&bytes);
        bytes.extend(checksum.to_le_bytes());
        bytes
    }

    /// The frame in a datagram, which must hold nothing else.
    ///
    /// # Errors
    /// [`FrameError`] says what is wrong with it.
    pub fn decode(datagram: &[u8]) -> Result<Self, FrameError> {
        match Self::parse(datagram)? {
            Some((frame, length)) if length == datagram.len() => Ok(frame),
            _ => Err(FrameError::Length(datagram.len())),
        }
    }

    /// The frame at the start of `bytes` and its length; `None` if it is not complete yet.
    fn parse(bytes: &[u8]) -> Result<Option<(Self, usize)>, FrameError> {
        let known = bytes.len().min(MAGIC.len());
        if bytes[..known] != MAGIC[..known] {
            return Err(FrameError::Magic);
        }
        let Some(header) = bytes.first_chunk::<HEADER>() else { return Ok(None) };
        if header[4] != VERSION {
            return Err(FrameError::Version(header[4]));
        }
        let kind = Kind::of(header[5]).ok_or(FrameError::Kind(header[5]))?;
        if header[6..8] != [0, 0] {
            return Err(FrameError::Reserved);
        }
        let sequence = number::<4>(header, 8) as u32;
        let stamp = number::<8>(header, 12);
        let payload = number::<4>(header, 20) as usize;
        if payload > MAX_PAYLOAD {
            return Err(FrameError::Length(payload));
        }
        let length = HEADER + payload + TRAILER;
        if bytes.len() < length {
            return Ok(None);
        }
        let (content, checksum) = bytes[..length].split_at(length - TRAILER);
        if number::<4>(checksum, 0) as u32 != crc32fast::hash(content) {
            return Err(FrameError::Checksum);
        }
        Ok(Some((Self { kind, sequence, stamp, payload: content[HEADER..].to_vec() }, length)))
    }
}

/// The little-endian number of `N` bytes at `at`.
fn number<const N: usize>(bytes: &[u8], at: usize) -> u64 {
    bytes[at..at + N].iter().rev().fold(0, |sum, byte| sum << 8 | u64::from(*byte))
}

/// Cuts a stream of bytes into frames.
#[derive(Clone, Debug, Default)]
pub struct Decoder {
    bytes: Vec<u8>,
}

impl Decoder {
    /// Takes in what has arrived.
    pub fn push(&mut self, bytes: &[u8]) {
        self.bytes.extend(bytes);
    }

    /// The next complete frame; `None` if more bytes have to come.
    ///
    /// # Errors
    /// [`FrameError`]: the stream is broken, since where the next frame begins cannot be known. Close the connection.
    pub fn pop(&mut self) -> Result<Option<Frame>, FrameError> {
        let Some((frame, length)) = Frame::parse(&self.bytes)? else { return Ok(None) };
        self.bytes.drain(..length);
        Ok(Some(frame))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn frames() -> impl Strategy<Value = Frame> {
        let kind = prop::sample::select(Kind::ALL.to_vec());
        let payload = prop::collection::vec(any::<u8>(), 0..=MAX_PAYLOAD);
        (kind, any::<u32>(), any::<u64>(), payload).prop_map(|(kind, sequence, stamp, payload)| Frame {
            kind,
            sequence,
            stamp,
            payload,
        })
    }

    proptest! {
        #[test]
        fn random_bytes_are_refused_without_a_panic(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
            prop_assert!(Frame::decode(&bytes).is_err());
            let mut decoder = Decoder::default();
            decoder.push(&bytes);
            prop_assert!(!matches!(decoder.pop(), Ok(Some(_))));
        }

        /// Random bytes hardly ever get beyond the first four; these do.
        #[test]
        fn random_bytes_behind_a_good_start_are_refused(
            start in 0usize..=24,
            frame in frames(),
            bytes in prop::collection::vec(any::<u8>(), 0..600),
        ) {
            let mut broken = frame.encode()[..start].to_vec();
            broken.extend(bytes);
            prop_assert!(Frame::decode(&broken).is_err());
        }

        #[test]
        fn a_flipped_bit_is_refused(frame in frames(), at in any::<prop::sample::Index>()) {
            let mut bytes = frame.encode();
            let bit = at.index(bytes.len() * 8);
            bytes[bit / 8] ^= 1 << (bit % 8);
            prop_assert!(Frame::decode(&bytes).is_err());
        }

        #[test]
        fn a_cut_is_refused(frame in frames(), at in any::<prop::sample::Index>()) {
            let bytes = frame.encode();
            prop_assert!(Frame::decode(&bytes[..at.index(bytes.len())]).is_err());
        }

        #[test]
        fn a_stream_gives_the_same_frames_in_any_pieces(
            sent in prop::collection::vec(frames(), 0..6),
            piece in 1usize..90,
        ) {
            let stream: Vec<u8> = sent.iter().flat_map(Frame::encode).collect();
            let (mut decoder, mut received) = (Decoder::default(), Vec::new());
            for piece in stream.chunks(piece) {
                decoder.push(piece);
                while let Some(frame) = decoder.pop().unwrap() {
                    received.push(frame);
                }
            }
            prop_assert_eq!(received, sent);
        }
    }

    /// Any other program must come to the same bytes; these were written down by hand, the checksum by zlib.
    #[test]
    fn the_bytes_of_a_frame() {
        let frame = Frame { kind: Kind::Halt, sequence: 0x0102, stamp: 3, payload: vec![0xAB] };
        let mut expected = b"PHLX\x01\x06\0\0\x02\x01\0\0\x03\0\0\0\0\0\0\0\x01\0\0\0\xAB".to_vec();
        expected.extend(0x81F2_E013u32.to_le_bytes());
        assert_eq!(frame.encode(), expected);
    }
}
