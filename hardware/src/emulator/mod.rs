//! The emulator: a robot and the cameras above it at the other end of real sockets. It knows the true pose; what it sends is
//! what cameras would see.

mod body;
mod session;

use std::fs::File;
use std::io;
use std::net::{SocketAddr, TcpListener, UdpSocket};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use formation::scenario::Context;
use plant::Laboratory;
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::link::{Link, TcpLink};
use crate::message::{Clock, Message};
use body::Body;
use session::Session;

/// How the emulator is to behave besides its laboratory.
#[derive(Clone, Debug)]
pub struct Options {
    /// Number of the robot.
    pub body: u32,
    /// Where it listens for its controller.
    pub listen: SocketAddr,
    /// Where it sends poses to; `None`: to the port that the controller names, at the controller's address.
    pub poses: Option<SocketAddr>,
    /// After so long without a command the robot halts by itself, s.
    pub watchdog: f64,
    /// Where the true poses go, as CSV, a line per tick: for evaluation, out of reach of all controllers.
    pub record: Option<PathBuf>,
    /// Whether connections and halts are told.
    pub verbose: bool,
}

/// How long nothing happens at most, when nothing is to be done.
const IDLE: Duration = Duration::from_millis(100);

/// Plays the robot of `agent` (from 0) until the program ends. `on_ready` is told where it listens.
///
/// # Errors
/// What the operating system says about the sockets or the file.
pub fn serve(
    options: &Options,
    laboratory: &Laboratory,
    context: &Context,
    agent: usize,
    on_ready: impl FnOnce(SocketAddr),
) -> io::Result<()> {
    let listener = TcpListener::bind(options.listen)?;
    listener.set_nonblocking(true)?;
    // Sends only; bound to the same network as the listener.
    let cameras = UdpSocket::bind(SocketAddr::new(options.listen.ip(), 0))?;
    let record = options.record.as_ref().map(File::create).transpose()?;
    let body = Body::new(options, laboratory, context, agent, cameras, record)?;
    on_ready(listener.local_addr()?);
    Server { listener, body, session: None, verbose: options.verbose }.run()
}

struct Server {
    listener: TcpListener,
    body: Body,
    session: Option<Session>,
    verbose: bool,
}

impl Server {
    fn run(mut self) -> io::Result<()> {
        loop {
            self.wait(self.body.due_in().unwrap_or(IDLE).min(IDLE))?;
            self.accept();
            self.hear();
            if self.body.pass_time() {
                self.say("no command for too long: halted");
            }
        }
    }

    /// Waits until a controller or time wants something.
    fn wait(&self, patience: Duration) -> io::Result<()> {
        let timeout = Timespec { tv_sec: patience.as_secs() as i64, tv_nsec: i64::from(patience.subsec_nanos()) };
        let listener = PollFd::new(&self.listener, PollFlags::IN);
        let result = match &self.session {
            Some(session) => poll(&mut [listener, PollFd::new(session.link.stream(), PollFlags::IN)], Some(&timeout)),
            None => poll(&mut [listener], Some(&timeout)),
        };
        match result {
            Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    /// Lets a controller in, if there is none; refuses a second one.
    fn accept(&mut self) {
        let Ok((stream, peer)) = self.listener.accept() else { return };
        let Ok(mut link) = TcpLink::new(stream) else { return };
        if let Some(session) = &self.session {
            let reason = format!("another controller has it, from {}", session.peer);
            self.say(&format!("refused {peer}: {reason}"));
            // It is gone, or reads it.
            let _ = link.send(&Message::Refused { reason }.frame(0, 0));
            return;
        }
        self.session = Some(Session::new(link, peer));
    }

    /// Does what the controller says.
    fn hear(&mut self) {
        let Some(session) = &mut self.session else { return };
        let was_open = session.is_open();
        let result = session.hear(&mut self.body);
        let (peer, is_open) = (session.peer, session.is_open());
        if is_open && !was_open {
            self.say(&format!("{peer} has control"));
        }
        if let Err(reason) = result {
            self.session = None;
            self.body.halt();
            self.say(&format!("{peer} is gone: {reason}; halted"));
        }
    }

    fn say(&self, text: &str) {
        if self.verbose {
            eprintln!("robot {}: {text}", self.body.number());
        }
    }
}

/// A clock that may be the one on the wall.
fn since(origin: Instant) -> u64 {
    origin.elapsed().as_nanos() as u64
}

/// What a controller asks for.
#[derive(Clone, Copy, Debug)]
struct Terms {
    clock: Clock,
    /// Time between two commands, ns.
    period: u64,
    /// Where poses go.
    poses: Option<SocketAddr>,
    /// Simulated time of the first command in lockstep, ns.
    start: u64,
}
