//! Hostile input: the corpus of the fuzzer and seeded mutations of it, fed to what the fuzzer feeds.
//!
//! `PHALANX_MUTATIONS` sets how many mutations of every kind of input are tried (default 400).

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use tests::hostile::TARGETS;

/// Most memory that all of this may take: far more than the inputs, far less than what they claim. KB.
const MOST_MEMORY: u64 = 3 << 20;

/// The same numbers in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit.max(1) as u64) as usize
    }
}

/// Pieces that parsers trip over.
const PIECES: [&[u8]; 14] = [
    b"1e999",
    b"-0.0",
    b"nan",
    b"99999999999999999999",
    b"((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((",
    b"[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[",
    b"\"",
    b"../../../etc/passwd",
    b"\xff\xfe\x00",
    "\u{202e}\u{0}ä".as_bytes(),
    b"\xff\xff\xff\xff\xff\xff\xff\x7f",
    b"\x00\x00\x00\x80\x02\x00\x00\x00",
    b"= { kind = 1 }",
    b"state.position[18446744073709551615:0]",
];

fn mutate(inputs: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let mut bytes = inputs[random.below(inputs.len())].clone();
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len());
        match random.below(7) {
            0 => bytes.truncate(at),
            1 if !bytes.is_empty() => bytes[at] ^= 1 << random.below(8),
            2 => {
                let piece = PIECES[random.below(PIECES.len())];
                bytes.splice(at..at, piece.iter().copied());
            }
            3 => {
                let end = (at + random.below(64)).min(bytes.len());
                bytes.drain(at..end);
            }
            4 => {
                let end = (at + random.below(256)).min(bytes.len());
                let copy = bytes[at..end].to_vec();
                let to = random.below(bytes.len());
                bytes.splice(to..to, copy);
            }
            5 => {
                // A length of 10 GB, or another number that claims much.
                let claim = [10_u64 << 30, u64::MAX, 1 << 31, 255][random.below(4)].to_le_bytes();
                let end = (at + 8).min(bytes.len());
                bytes.splice(at..end, claim);
            }
            _ => {
                let other = &inputs[random.below(inputs.len())];
                let from = random.below(other.len());
                bytes.truncate(at);
                bytes.extend_from_slice(&other[from..]);
            }
        }
    }
    bytes
}

fn corpus(name: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus").join(name);
    let mut paths: Vec<_> = fs::read_dir(&folder).expect("a corpus").flatten().map(|entry| entry.path()).collect();
    paths.sort();
    assert!(!paths.is_empty(), "{} is empty", folder.display());
    let mut inputs: Vec<Vec<u8>> = paths.iter().map(|path| fs::read(path).expect("a file of the corpus")).collect();
    if name == "scenario" {
        inputs.extend(schemes::SCENARIOS.iter().map(|shipped| shipped.text.as_bytes().to_vec()));
    }
    inputs
}

fn feed(name: &str) {
    let (_, target) = TARGETS.into_iter().find(|(known, _)| *known == name).expect("a target");
    let inputs = corpus(name);
    let mutations = std::env::var("PHALANX_MUTATIONS").ok().and_then(|text| text.parse().ok()).unwrap_or(400);
    let mut random = Random(1);
    let mutated = (0..mutations).map(|_| mutate(&inputs, &mut random));
    for (number, input) in inputs.iter().cloned().chain(mutated).enumerate() {
        if catch_unwind(AssertUnwindSafe(|| target(&input))).is_err() {
            let path = std::env::temp_dir().join(format!("phalanx-{name}-{number}"));
            fs::write(&path, &input).expect("the input is kept");
            panic!("{name}: input {number} is to blame; it is in {}", path.display());
        }
    }
    let status = fs::read_to_string("/proc/self/status").expect("/proc");
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).expect("a peak");
    let peak: u64 = peak.trim().trim_end_matches(" kB").parse().expect("kilobytes");
    assert!(peak < MOST_MEMORY, "{name}: {peak} KB");
}

#[test]
fn scenarios() {
    feed("scenario");
}

#[test]
fn command_lines() {
    feed("command");
}

#[test]
fn logs() {
    feed("log");
}

#[test]
fn plans() {
    feed("plan");
}

#[test]
fn the_plan_of_the_corpus_is_one_of_today() {
    // Mutations of another one would come no further than to the check of its format.
    let folder = std::env::temp_dir().join(format!("phalanx-plan-{}", std::process::id()));
    fs::create_dir_all(&folder).expect("a folder");
    for plan in corpus("plan") {
        fs::write(folder.join("plan.json"), plan).expect("a file");
        lockstep::Plan::read(&folder).expect("a plan; copy a new plan.json from the directory of a run of `mixed`");
    }
    fs::remove_dir_all(folder).expect("the folder is removed");
}
