//! The way to a robot. A serial line or a field bus is one more implementation of two traits: [`Connector`] and [`Link`].

use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::os::fd::AsFd;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use thiserror::Error;

use crate::frame::{Decoder, Frame, FrameError, MAX_FRAME};

/// Why nothing can come over a link any more.
#[derive(Debug, Error)]
pub enum LinkError {
    /// The other end closed it.
    #[error("the other end closed the connection")]
    Closed,
    /// What came is not a frame.
    #[error("what came is no frame: {0}")]
    Frame(#[from] FrameError),
    /// Commands go in, and no answer comes out.
    #[error("no command was acknowledged for {0} s")]
    Silent(f64),
    /// The operating system says so.
    #[error(transparent)]
    System(#[from] io::Error),
}

/// An open way for frames, in both directions and in order.
pub trait Link: Send {
    /// Sends a frame, without waiting: the steps of all participants would wait, too.
    ///
    /// # Errors
    /// [`LinkError`], also if the other end does not take what it is sent; the link is of no use then.
    fn send(&mut self, frame: &Frame) -> Result<(), LinkError>;

    /// The next frame that arrives within `patience`; `None` if there is none. No patience: only what is there already.
    ///
    /// # Errors
    /// [`LinkError`]; the link is of no use then.
    fn receive(&mut self, patience: Duration) -> Result<Option<Frame>, LinkError>;
}

/// Opens the link to a robot, at the start and after each loss.
pub trait Connector: Send {
    /// Opens it within `patience`.
    ///
    /// # Errors
    /// What the operating system says.
    fn connect(&mut self, patience: Duration) -> io::Result<Box<dyn Link>>;

    /// Where it leads to, for messages.
    fn target(&self) -> String;
}

/// The link over TCP.
pub struct TcpLink {
    stream: TcpStream,
    decoder: Decoder,
}

impl TcpLink {
    /// Takes over a connected stream.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn new(stream: TcpStream) -> io::Result<Self> {
        stream.set_nodelay(true)?;
        stream.set_nonblocking(true)?;
        Ok(Self { stream, decoder: Decoder::default() })
    }

    /// The stream, to wait for.
    pub fn stream(&self) -> &TcpStream {
        &self.stream
    }
}

impl Link for TcpLink {
    fn send(&mut self, frame: &Frame) -> Result<(), LinkError> {
        self.stream.write_all(&frame.encode())?;
        Ok(())
    }

    fn receive(&mut self, patience: Duration) -> Result<Option<Frame>, LinkError> {
        let start = std::time::Instant::now();
        loop {
            if let Some(frame) = self.decoder.pop()? {
                return Ok(Some(frame));
            }
            if !wait_readable(&self.stream, patience.saturating_sub(start.elapsed()))? {
                return Ok(None);
            }
            let mut bytes = [0; 4 * MAX_FRAME];
            match self.stream.read(&mut bytes) {
                Ok(0) => return Err(LinkError::Closed),
                Ok(count) => self.decoder.push(&bytes[..count]),
                Err(error) if matches!(error.kind(), ErrorKind::Interrupted | ErrorKind::WouldBlock) => {}
                Err(error) => return Err(error.into()),
            }
        }
    }
}

/// Waits until there is something to read; `false` if nothing came within `patience`.
pub(crate) fn wait_readable(file: &impl AsFd, patience: Duration) -> io::Result<bool> {
    let timeout = Timespec { tv_sec: patience.as_secs() as i64, tv_nsec: i64::from(patience.subsec_nanos()) };
    match poll(&mut [PollFd::new(file, PollFlags::IN)], Some(&timeout)) {
        Ok(count) => Ok(count > 0),
        Err(rustix::io::Errno::INTR) => Ok(false),
        Err(error) => Err(error.into()),
    }
}

/// Opens links over TCP to one address.
#[derive(Clone, Debug)]
pub struct TcpConnector(pub SocketAddr);

impl Connector for TcpConnector {
    fn connect(&mut self, patience: Duration) -> io::Result<Box<dyn Link>> {
        let stream = TcpStream::connect_timeout(&self.0, patience)?;
        Ok(Box::new(TcpLink::new(stream)?))
    }

    fn target(&self) -> String {
        self.0.to_string()
    }
}
