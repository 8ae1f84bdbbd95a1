//! The page of a run, attacked: nothing that one browser does holds up the others or grows the program.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Stdio};
use std::time::Duration;

use crate::program::{Folder, unique, wait_until};

/// A run at the pace of the clock and the page of it.
struct Page {
    folder: Folder,
    name: String,
    run: Child,
    watcher: Child,
    address: String,
}

impl Page {
    fn open(name: &str) -> Self {
        let (folder, name) = (Folder::new(), unique(name));
        let text = folder.run(&["validate", "uav", "--set", "metrics=", "--print"]).stdout();
        folder.write("run.toml", &text.replace("name = \"uav\"", &format!("name = \"{name}\"")));
        let run = folder.start(&["run", "run.toml", "--duration", "600", "--realtime", "-q", "--no-log"]);
        let mut watcher = folder.phalanx(&["watch", &name, "--web"]);
        let mut watcher = watcher.stdin(Stdio::null()).stdout(Stdio::piped()).spawn().expect("the program starts");
        let mut line = String::new();
        BufReader::new(watcher.stdout.take().expect("stdout")).read_line(&mut line).expect("the address");
        let address = line.trim().rsplit("http://").next().expect("an address").trim_end_matches('/').to_string();
        let page = Self { folder, name, run, watcher, address };
        wait_until("the page has data", || page.ask("GET / HTTP/1.1", "").contains("id=\"runs\">"));
        page
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(&self.address).expect("a connection");
        stream.set_read_timeout(Some(Duration::from_secs(60))).expect("a time-out");
        stream
    }

    /// Sends a request and leaves the answer where it is.
    fn send(&self, line: &str, fields: &str) -> TcpStream {
        let mut stream = self.connect();
        write!(stream, "{line}\r\nHost: {}\r\n{fields}\r\n", self.address).expect("a request");
        stream
    }

    /// Sends a request and returns the whole answer.
    fn ask(&self, line: &str, fields: &str) -> String {
        let mut answer = String::new();
        let _ = self.send(line, fields).read_to_string(&mut answer);
        answer
    }

    /// The status of a stream of frames, and the stream.
    fn stream(&self) -> (String, BufReader<TcpStream>) {
        let mut answer = BufReader::new(self.send("GET /events HTTP/1.1", ""));
        let mut status = String::new();
        answer.read_line(&mut status).expect("a status");
        (status, answer)
    }

    /// Memory of the program that serves the page, KB.
    fn memory(&self) -> u64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.watcher.id())).expect("its status");
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).expect("its memory");
        line.split_whitespace().next().and_then(|number| number.parse().ok()).expect("a number")
    }

    /// Both pages come, and come in time.
    fn serves(&self) {
        assert!(self.ask("GET / HTTP/1.1", "").contains("id=\"runs\">"));
        let (status, mut stream) = self.stream();
        assert!(status.starts_with("HTTP/1.1 200"), "{status}");
        let mut line = String::new();
        while !line.starts_with("event: frame") {
            line.clear();
            assert!(stream.read_line(&mut line).expect("a frame") > 0, "the stream ended");
        }
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        let _ = self.folder.run(&["ctl", "stop", &self.name]);
        let _ = self.watcher.kill();
        let _ = self.watcher.wait();
        let _ = self.run.wait();
    }
}

#[test]
fn browsers_that_do_not_read_hold_up_nobody() {
    let page = Page::open("slow");
    let before = page.memory();
    let slow: Vec<TcpStream> = (0..100).map(|_| page.send("GET / HTTP/1.1", "")).collect();
    let streams: Vec<TcpStream> = (0..20).map(|_| page.send("GET /events HTTP/1.1", "")).collect();
    page.serves();
    std::thread::sleep(Duration::from_secs(3));
    page.serves();
    let grown = page.memory().saturating_sub(before);
    assert!(grown < 100_000, "{grown} KB more than before");
    drop((slow, streams));
}

#[test]
fn half_requests_and_announced_bodies_hold_up_nobody() {
    let page = Page::open("half");
    let before = page.memory();
    let mut half: Vec<TcpStream> = (0..300).map(|_| page.connect()).collect();
    half.iter_mut().for_each(|stream| drop(stream.write_all(b"GET / HTTP/1.1\r\nHost: ")));
    let bodies: Vec<TcpStream> =
        (0..20).map(|_| page.send("POST / HTTP/1.1", "Content-Length: 1000000000\r\n")).collect();
    page.serves();
    assert!(page.ask("POST / HTTP/1.1", "Content-Length: 10\r\n").starts_with("HTTP/1.1 413"));
    // A request that does not arrive is given up in any case.
    let mut last = half.pop().expect("a connection");
    let mut rest = Vec::new();
    let _ = last.read_to_end(&mut rest);
    assert!(rest.is_empty(), "{}", String::from_utf8_lossy(&rest));
    let grown = page.memory().saturating_sub(before);
    assert!(grown < 50_000, "{grown} KB more than before");
    drop(bodies);
}

#[test]
fn heads_without_an_end_are_refused() {
    let page = Page::open("endless");
    let before = page.memory();
    let mut endless = page.connect();
    write!(endless, "GET / HTTP/1.1\r\nHost: {}\r\n", page.address).expect("a request");
    let sent = (0..1_000_000u32).take_while(|number| write!(endless, "X-{number}: {number}\r\n").is_ok()).count();
    assert!(sent < 1_000_000, "all was taken");
    let endless = page.ask("GET / HTTP/1.1", &format!("X: {}\r\n", "x".repeat(20_000)));
    assert!(endless.is_empty() || endless.starts_with("HTTP/1.1 431"), "{endless}");
    page.serves();
    let grown = page.memory().saturating_sub(before);
    assert!(grown < 50_000, "{grown} KB more than before");
}

#[test]
fn more_streams_than_there_may_be_are_refused_and_the_page_is_served() {
    let page = Page::open("crowd");
    let streams: Vec<(String, BufReader<TcpStream>)> = (0..200).map(|_| page.stream()).collect();
    let refused = streams.iter().filter(|(status, _)| status.starts_with("HTTP/1.1 503")).count();
    let accepted = streams.iter().filter(|(status, _)| status.starts_with("HTTP/1.1 200")).count();
    assert_eq!((refused, accepted), (168, 32));
    assert!(page.ask("GET / HTTP/1.1", "").contains("id=\"runs\">"));
    drop(streams);
    wait_until("there is room again", || page.stream().0.starts_with("HTTP/1.1 200"));
}

#[test]
fn pages_of_other_sites_read_nothing() {
    let page = Page::open("foreign");
    for (line, fields, status) in [
        ("GET / HTTP/1.1", "Origin: http://elsewhere.example\r\n", "403"),
        ("GET /events HTTP/1.1", "Origin: null\r\n", "403"),
        ("GET /other HTTP/1.1", "", "404"),
        ("DELETE / HTTP/1.1", "", "405"),
        ("GET / HTTP/9", "", "400"),
    ] {
        let answer = page.ask(line, fields);
        assert!(answer.starts_with(&format!("HTTP/1.1 {status}")), "{line} {fields}: {answer}");
        assert!(!answer.to_lowercase().contains("access-control"), "{answer}");
    }
}
