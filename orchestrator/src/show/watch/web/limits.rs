//! Limits of one connection, and of all of them together.

use std::time::Duration;

/// Bytes of the head of a request.
pub(super) const MAX_HEAD_BYTES: usize = 8 << 10;
/// Fields of the head of a request.
pub(super) const MAX_HEADERS: usize = 64;
/// Connections that send a request, or whose answer is sent completely; the oldest is closed for a new one.
pub(super) const MAX_WAITING: usize = 64;
/// Answers that are being sent; the oldest is closed for a new one.
pub(super) const MAX_ANSWERS: usize = 16;
/// Streams of frames; one more is refused.
pub(super) const MAX_STREAMS: usize = 32;
/// Messages that wait for one browser; beyond that, only the newest is kept.
pub(super) const MAX_BACKLOG: usize = 8;
/// How long the head of a request may take.
pub(super) const REQUEST_TIMEOUT: Duration = Duration::from_secs(5);
/// How long an answer may take in all.
pub(super) const ANSWER_TIMEOUT: Duration = Duration::from_secs(30);
/// How long a browser may accept no byte of what is sent to it.
pub(super) const STALL_TIMEOUT: Duration = Duration::from_secs(5);
/// How long a browser may take to close a completed connection.
pub(super) const LINGER_TIMEOUT: Duration = Duration::from_secs(1);
/// Silence on a stream after which a comment is sent, so that a closed connection is noticed.
pub(super) const KEEP_ALIVE: Duration = Duration::from_secs(5);
/// How long a page is reused.
pub(super) const PAGE_LIFETIME: Duration = Duration::from_millis(200);
/// Time between two checks of these limits.
pub(super) const CHECK_INTERVAL: Duration = Duration::from_millis(250);
