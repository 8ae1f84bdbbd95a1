//! Two logs side by side, bit by bit.

use std::fmt;

use super::{Log, LogChannel, LogError, Stream};

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub enum Comparison {
    /// All samples are equal, bit by bit.
    Equal {
        /// How many numbers were compared.
        numbers: u64,
    },
    /// The logs do not hold the same steps of the same signals.
    Unlike(String),
    /// Some numbers differ.
    Different(Difference),
}

/// Where two logs differ first, and how much.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// The first step at which anything differs.
    pub step: u64,
    /// Simulated time of it, ns.
    pub time_ns: u64,
    /// The first channel of the log that differs at this step.
    pub topic: String,
    /// Its first number that differs, `position[2]`.
    pub field: String,
    /// The number in both logs.
    pub values: [f64; 2],
    /// How many numbers of all differ.
    pub differing: u64,
    /// How many numbers were compared.
    pub numbers: u64,
}

impl Difference {
    /// How many doubles lie between the two values, plus one; 0 only between zeros of different sign.
    pub fn ulps(&self) -> u64 {
        ulps(self.values[0], self.values[1])
    }
}

/// How many doubles lie between two numbers, plus one; 0 if they are equal.
pub fn ulps(a: f64, b: f64) -> u64 {
    place(a).abs_diff(place(b))
}

/// The place of a double among all doubles in ascending order, both zeros at 0.
fn place(value: f64) -> i64 {
    let bits = value.to_bits() as i64;
    if bits >= 0 { bits } else { i64::MIN - bits }
}

impl fmt::Display for Difference {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let [a, b] = self.values;
        write!(
            formatter,
            "they differ first at step {} (t = {} s), {} {}: {a:e} and {b:e}, {} ulp apart; {} of {} numbers differ",
            self.step,
            self.time_ns as f64 / 1e9,
            self.topic,
            self.field,
            self.ulps(),
            self.differing,
            self.numbers
        )
    }
}

/// The channels with samples; a scene for viewers is beside the point, it follows from them.
fn signals(log: &Log) -> impl Iterator<Item = &LogChannel> {
    log.channels().iter().filter(|channel| channel.layout.is_some())
}

/// Compares all samples of two logs, of which `a` and `b` are outlines at least; the samples are read step by step.
///
/// # Errors
/// [`LogError`] if a file cannot be read, or is another one by now.
pub fn compare(a: &Log, b: &Log) -> Result<Comparison, LogError> {
    if let Some(reason) = unlike(a, b) {
        return Ok(Comparison::Unlike(reason));
    }
    let open = |log: &Log| {
        let topics = signals(log).filter_map(|channel| Some((channel.topic.clone(), channel.layout.clone()?)));
        Stream::open(log.path(), &topics.collect::<Vec<_>>())
    };
    let (mut ours, mut theirs) = (open(a)?, open(b)?);
    let channels: Vec<_> = signals(a).collect();
    let (mut numbers, mut differing, mut first) = (0, 0, None);
    for (row, step) in a.steps().enumerate() {
        for stream in [&mut ours, &mut theirs] {
            if !stream.advance()? || stream.step() != Some(step) {
                let what = "it was written while it was read".into();
                return Err(LogError::Topic { path: stream.path().into(), topic: channels[0].topic.clone(), what });
            }
        }
        for (index, channel) in channels.iter().enumerate() {
            let pairs = sample(&ours, index).zip(sample(&theirs, index)).enumerate();
            for (number, (x, y)) in pairs {
                numbers += 1;
                if x.to_bits() != y.to_bits() {
                    differing += 1;
                    first.get_or_insert_with(|| Place {
                        row,
                        topic: &channel.topic,
                        field: channel.label(number),
                        values: [x, y],
                    });
                }
            }
        }
    }
    let Some(Place { row, topic, field, values }) = first else { return Ok(Comparison::Equal { numbers }) };
    let (step, time_ns) = (a.steps().start + row as u64, a.times()[row]);
    Ok(Comparison::Different(Difference { step, time_ns, topic: topic.clone(), field, values, differing, numbers }))
}

/// Where the first difference is.
struct Place<'a> {
    row: usize,
    topic: &'a String,
    field: String,
    values: [f64; 2],
}

/// Step, status and words of a sample.
fn sample(stream: &Stream, topic: usize) -> impl Iterator<Item = f64> {
    let header = stream.header(topic);
    [header.step as f64, f64::from(header.status)].into_iter().chain(stream.words(topic).iter().copied())
}

/// Why the samples of two logs cannot be compared one by one.
fn unlike(a: &Log, b: &Log) -> Option<String> {
    let topics = |log: &Log| signals(log).map(|channel| channel.topic.clone()).collect::<Vec<_>>();
    let (ours, theirs) = (topics(a), topics(b));
    for (one, other, which) in [(&ours, &theirs, "second"), (&theirs, &ours, "first")] {
        if let Some(topic) = one.iter().find(|topic| !other.contains(topic)) {
            return Some(format!("the {which} log has no topic {topic}"));
        }
    }
    if ours != theirs {
        return Some("their topics are in a different order".into());
    }
    let mut channels = signals(a).zip(signals(b));
    if let Some((channel, _)) = channels.find(|(ours, theirs)| ours.layout != theirs.layout) {
        return Some(format!("samples of {} have other fields in the second log", channel.topic));
    }
    if a.steps() != b.steps() {
        let [ours, theirs] = [a.steps(), b.steps()];
        let text = format!("the first log holds steps {} to {}", ours.start, ours.end.saturating_sub(1));
        return Some(format!("{text}, the second {} to {}", theirs.start, theirs.end.saturating_sub(1)));
    }
    let row = a.times().iter().zip(b.times()).position(|(ours, theirs)| ours != theirs)?;
    Some(format!("step {} is at {} ns and at {} ns", a.steps().start + row as u64, a.times()[row], b.times()[row]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn doubles_are_counted_through_zero() {
        let difference = |a: f64, b: f64| {
            let (topic, field) = (String::new(), String::new());
            Difference { step: 0, time_ns: 0, topic, field, values: [a, b], differing: 1, numbers: 1 }.ulps()
        };
        assert_eq!(difference(1.0, 1.0 + f64::EPSILON), 1);
        assert_eq!(difference(0.0, -0.0), 0);
        assert_eq!(difference(f64::from_bits(1), -f64::from_bits(1)), 2);
        assert_eq!(difference(-1.0, -1.0 - f64::EPSILON), 1);
    }
}
