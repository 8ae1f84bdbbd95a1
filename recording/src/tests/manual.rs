//! What a person starts by hand: a log for other readers, and the speed of this one.

use std::time::Instant;

use super::*;

/// Writes a log to the path in `PHALANX_LOG`, for a try with other readers.
#[test]
#[ignore = "writes to the path in PHALANX_LOG"]
fn write_a_log() {
    let path = std::env::var_os("PHALANX_LOG").expect("PHALANX_LOG names the file to write");
    let run = Run::new(3, 5);
    let mut recorder = Recorder::create(Path::new(&path), &run.info()).unwrap();
    let extra = recorder.add_channel("/note", "std_msgs/msg/UInt8", "uint8 data\n", Durability::Volatile).unwrap();
    run.drive(&mut recorder, 0..500).unwrap();
    recorder.write(extra, 499, &[0, 1, 0, 0, 7]).unwrap();
    println!("{:?}", recorder.finish().unwrap());
}

/// 120,000 steps of 24 channels, about 30 words each in the larger ones.
#[test]
#[ignore = "takes seconds and 700 MB; run it alone, with --release"]
fn speed() {
    let scratch = Scratch::new("speed");
    let path = scratch.file("run.mcap");
    let run = Run { flush_every: DEFAULT_FLUSH_EVERY, ..Run::new(12, 52) };
    let (steps, mut store) = (120_000, run.store());
    for step in 0..2 {
        run.compute(&mut store, step);
    }
    let begin = Instant::now();
    let mut recorder = Recorder::create(&path, &run.info()).unwrap();
    let (mut slowest, mut recording) = (0.0_f64, 0.0);
    for step in 0..steps {
        for channel in 0..run.network.channels.len() {
            // Numbers with full mantissas, which compress as badly as those of a simulation.
            for (word, place) in store.write(ChannelId(channel), step).iter_mut().enumerate() {
                *place += 1e-3 / (word + channel + 1) as f64;
            }
        }
        let start = Instant::now();
        recorder.record(step, &store, |channel| run.header(step, channel)).unwrap();
        slowest = slowest.max(start.elapsed().as_secs_f64());
        recording += start.elapsed().as_secs_f64();
    }
    let summary = recorder.finish().unwrap().unwrap();
    let writing = begin.elapsed().as_secs_f64();
    let begin = Instant::now();
    let log = Log::open(&path).unwrap();
    let reading = begin.elapsed().as_secs_f64();
    let megabytes =
        log.channels().iter().map(|c| c.messages as usize * c.layout.as_ref().unwrap().bytes()).sum::<usize>()
            / 1_000_000;
    println!("{} messages, {megabytes} MB of samples, file {} MB", summary.messages, summary.bytes / 1_000_000);
    println!("steps {recording:.2} s, slowest {:.1} ms; written {writing:.2} s; read {reading:.2} s", slowest * 1e3);
    assert_eq!(log.steps(), 0..steps);
}
