//! What one browser, and all of them together, may take of the server.

use std::time::Duration;

/// Bytes of the head of a request.
pub(super) const MOST_HEAD: usize = 8 << 10;
/// Fields of the head of a request.
pub(super) const MOST_HEADERS: usize = 64;
/// Connections whose request is not complete, or whose answer is told but for a farewell; the oldest makes room.
pub(super) const MOST_WAITING: usize = 64;
/// Answers that are being sent; the oldest makes room.
pub(super) const MOST_ANSWERS: usize = 16;
/// Streams of frames; one more is refused.
pub(super) const MOST_STREAMS: usize = 32;
/// Messages that wait for one browser; beyond, only the newest is kept.
pub(super) const BACKLOG: usize = 8;
/// How long a request may take to come.
pub(super) const REQUEST: Duration = Duration::from_secs(5);
/// How long an answer may take in all.
pub(super) const ANSWER: Duration = Duration::from_secs(30);
/// How long a browser may take nothing of what is sent to it.
pub(super) const STALL: Duration = Duration::from_secs(5);
/// How long a browser may take to close a connection that is done.
pub(super) const LINGER: Duration = Duration::from_secs(1);
/// Silence on a stream after which a comment is sent, to find out whether there still is a browser.
pub(super) const PULSE: Duration = Duration::from_secs(5);
/// A page that is younger is sent again instead of a new one.
pub(super) const FRESH: Duration = Duration::from_millis(200);
/// Time between two looks at these limits.
pub(super) const TICK: Duration = Duration::from_millis(250);
