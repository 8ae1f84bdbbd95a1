use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::net::UnixStream;
use std::sync::atomic::AtomicU32;

use super::*;

/// A server in a folder of its own.
struct Bench {
    server: Option<Server>,
    stop: RunControl,
    folder: PathBuf,
}

impl Bench {
    fn new() -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let name = format!("phalanx-control-{}-{}", std::process::id(), COUNT.fetch_add(1, SeqCst));
        let folder = std::env::temp_dir().join(name);
        fs::create_dir(&folder).unwrap();
        let about = About {
            run: "test".into(),
            scenario: "uav".into(),
            variant: "TSC".into(),
            dt: 0.01,
            periods: 100,
            processes: 2,
            log: None,
            participants: vec!["plant".into()],
        };
        let stop = RunControl::new();
        let server = Server::start(&folder, about, stop.clone()).unwrap();
        Self { server: Some(server), stop, folder }
    }

    fn connect(&self) -> UnixStream {
        let stream = UnixStream::connect(self.folder.join(SOCKET)).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
        stream
    }

    fn ask(&self, line: &str) -> Answer {
        let mut stream = self.connect();
        stream.write_all(line.as_bytes()).unwrap();
        answer(stream)
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        self.server = None;
        fs::remove_dir_all(&self.folder).unwrap();
    }
}

fn answer(stream: UnixStream) -> Answer {
    let mut line = String::new();
    BufReader::new(stream).read_line(&mut line).unwrap();
    serde_json::from_str(&line).unwrap()
}

fn status(answer: Answer) -> Status {
    match answer {
        Answer::Status(status) => *status,
        Answer::Error { error } => panic!("{error}"),
    }
}

fn error(answer: Answer) -> String {
    match answer {
        Answer::Error { error } => error,
        Answer::Status(status) => panic!("{status:?}"),
    }
}

#[test]
fn requests_are_carried_out_and_answered() {
    let bench = Bench::new();
    assert_eq!(status(bench.ask("status\n")).state, State::Starting);
    assert!(status(bench.ask("pause\n")).paused && bench.stop.is_paused());
    assert!(error(bench.ask("halt\n")).contains("expected pause"));
    assert!(error(bench.ask("swap controler.3=x\n")).contains("no such participant"));
    // A line without its end is complete when its sender has said all.
    let mut stream = bench.connect();
    stream.write_all(b"estop").unwrap();
    stream.shutdown(std::net::Shutdown::Write).unwrap();
    assert_eq!(status(answer(stream)).state, State::Stopping);
    assert!(bench.stop.is_emergency());
}

#[test]
fn an_emergency_stop_passes_all_who_keep_the_server_waiting() {
    let bench = Bench::new();
    let mut idle: Vec<UnixStream> = (0..3 * MOST_CLIENTS).map(|_| bench.connect()).collect();
    // Some have begun to say something.
    idle.iter_mut().step_by(2).for_each(|stream| drop(stream.write_all(b"st")));
    let mut waiting: Vec<UnixStream> = (0..2 * MOST_CLIENTS).map(|_| bench.connect()).collect();
    waiting.iter_mut().for_each(|stream| drop(stream.write_all(b"swap plant=./mine\n")));
    let start = Instant::now();
    assert!(status(bench.ask("estop\n")).stopping);
    // They would have kept a server that waits for each of them for minutes.
    assert!(start.elapsed() < PATIENCE / 2, "{:?}", start.elapsed());
}

#[test]
fn a_request_without_an_end_is_refused() {
    let bench = Bench::new();
    let mut stream = bench.connect();
    let sender = stream.try_clone().unwrap();
    let sending = thread::spawn(move || (&sender).write_all(&vec![b'x'; 4 << 20]));
    let mut text = String::new();
    // The connection may be reset behind the answer, since not all was read.
    let _ = stream.read_to_string(&mut text);
    assert!(text.is_empty() || text.contains("expected pause"), "{text}");
    assert!(sending.join().unwrap().is_err(), "the server took in four megabytes");
    assert_eq!(status(bench.ask("status\n")).run, "test");
}

#[test]
fn a_client_that_keeps_silent_is_sent_away() {
    let bench = Bench::new();
    let mut stream = bench.connect();
    stream.write_all(b"sta").unwrap();
    let start = Instant::now();
    assert_eq!(stream.read(&mut [0]).unwrap(), 0);
    assert!(start.elapsed() >= PATIENCE - Duration::from_millis(100));
}

#[test]
fn the_end_of_the_server_answers_those_who_wait_for_a_swap() {
    let mut bench = Bench::new();
    let mut stream = bench.connect();
    stream.write_all(b"swap plant=./mine\n").unwrap();
    let request = loop {
        match bench.stop.next_swap() {
            Some(request) => break request,
            None => thread::yield_now(),
        }
    };
    let mut second = bench.connect();
    second.write_all(b"swap plant=./other\n").unwrap();
    while !bench.stop.wants_attention() {
        thread::yield_now();
    }
    assert_eq!(bench.stop.steps_done(), 0);
    request.answer(Ok(7));
    bench.server = None;
    assert_eq!(status(answer(stream)).swapped_at, Some(7));
    assert!(error(answer(second)).contains("the run ended before"));
}
