//! What readers see of a log that is being written.

use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::thread;
use std::time::{Duration, Instant};

use super::*;

/// Long enough for any machine; a test that waits so long has failed.
const PATIENCE: Duration = Duration::from_secs(20);

/// Waits until the log holds so many steps.
fn await_steps(path: &Path, steps: u64) -> Log {
    let start = Instant::now();
    loop {
        let log = Log::open(path);
        match log {
            Ok(log) if log.steps().end >= steps => return log,
            _ if start.elapsed() > PATIENCE => panic!("{steps} steps are not there: {:?}", log.map(|log| log.steps())),
            _ => thread::sleep(Duration::from_millis(2)),
        }
    }
}

#[test]
fn recorded_steps_reach_the_file_whatever_the_run_does_then() {
    let scratch = Scratch::new("hang");
    let path = scratch.file("run.mcap");
    let run = Run { flush_every: 1 << 40, ..Run::new(2, 3) };
    let mut recorder = Recorder::create(&path, &run.info()).unwrap();
    run.drive(&mut recorder, 0..7).unwrap();
    // The run does nothing more, as when a participant hangs.
    let log = await_steps(&path, 7);
    run.check(&log, 7);
    assert_eq!(log.unfinished(), Some(Unfinished::Growing));
    run.drive(&mut recorder, 7..9).unwrap();
    run.check(&await_steps(&path, 9), 9);
    recorder.finish().unwrap().unwrap();
    let log = Log::open(&path).unwrap();
    run.check(&log, 9);
    assert_eq!(log.unfinished(), None);
}

#[test]
fn what_was_shown_changes_no_byte_of_the_log() {
    let scratch = Scratch::new("slow");
    let run = Run::new(2, 3);
    let quick = run.record(&scratch.file("quick.mcap"), 64);
    let path = scratch.file("slow.mcap");
    let mut recorder = Recorder::create(&path, &run.info()).unwrap();
    for step in 0..64 {
        run.drive(&mut recorder, step..step + 1).unwrap();
        if step % 16 == 7 {
            await_steps(&path, step + 1);
        }
    }
    assert_eq!(recorder.finish().unwrap().unwrap().sha256, quick.sha256);
}

#[test]
fn a_reader_can_look_at_any_moment() {
    let scratch = Scratch::new("reader");
    let path = scratch.file("run.mcap");
    let run = Run { flush_every: 20, ..Run::new(3, 40) };
    run.record(&path, 1);
    let done = AtomicBool::new(false);
    thread::scope(|scope| {
        let reader = scope.spawn(|| {
            let (mut most, mut looks) = (0, 0_u64);
            while !done.load(SeqCst) {
                let log = Log::open(&path).unwrap_or_else(|error| panic!("after {looks} looks: {error}"));
                // At the moment when a chunk takes the place of what was shown of it, those steps may be missing for a moment.
                assert!(log.steps().end + 20 >= most, "{} after {most}", log.steps().end);
                (most, looks) = (most.max(log.steps().end), looks + 1);
            }
            (most, looks)
        });
        let mut recorder = Recorder::create(&path, &run.info()).unwrap();
        for step in 0..600 {
            run.drive(&mut recorder, step..step + 1).unwrap();
            thread::sleep(Duration::from_millis(1));
            if step % 20 == 18 {
                thread::sleep(Duration::from_millis(60));
            }
        }
        recorder.finish().unwrap();
        await_steps(&path, 600);
        done.store(true, SeqCst);
        let (most, looks) = reader.join().unwrap();
        assert!(most >= 500 && looks > 50, "{most} steps in {looks} looks");
    });
}

#[test]
fn an_earlier_log_stays_until_the_first_step_is_recorded() {
    let scratch = Scratch::new("earlier");
    let path = scratch.file("run.mcap");
    let run = Run::new(1, 2);
    let earlier = run.record(&path, 30);
    let bytes = || fs::read(&path).unwrap();
    let before = bytes();
    let recorder = Recorder::create(&path, &run.info()).unwrap();
    assert!(bytes() == before);
    assert_eq!(recorder.finish().unwrap(), None, "no step was recorded");
    assert_eq!((bytes() == before, fs::read_dir(&scratch.0).unwrap().count()), (true, 1));
    let mut recorder = Recorder::create(&path, &run.info()).unwrap();
    assert!(bytes() == before);
    run.drive(&mut recorder, 0..30).unwrap();
    let log = await_steps(&path, 1);
    assert!(log.steps().end <= 30);
    assert_eq!(recorder.finish().unwrap().unwrap(), earlier);
}
