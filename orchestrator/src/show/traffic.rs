//! What links did in a run, beside what the scenario asks of them.

use formation::wiring::AskedLink;
use recording::Log;
use serde_json::{Value, json};

/// A link in a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Traffic {
    /// What was asked.
    pub asked: AskedLink,
    /// Messages that were sent and lost.
    pub sent: u64,
    /// See above.
    pub lost: u64,
    /// Mean time on the way of the messages that arrived, s; NaN if none did.
    pub delay: f64,
    /// Mean and largest age of what the receiver had, s.
    pub mean_age: f64,
    /// See above.
    pub largest_age: f64,
    /// Mean and least time between two messages, s; NaN if there are fewer than two.
    pub interval: f64,
    /// See above.
    pub least_interval: f64,
    /// The length of the run, s.
    pub duration: f64,
}

impl Traffic {
    /// The share of messages that were lost; NaN if none was sent.
    pub fn loss(&self) -> f64 {
        self.lost as f64 / self.sent as f64
    }

    /// Messages per second: of the period of a link that has one, or in the mean over the run.
    pub fn rate(&self) -> f64 {
        if self.asked.rate.is_some() && self.sent > 1 { 1.0 / self.interval } else { self.sent as f64 / self.duration }
    }

    /// Bytes that were sent, lost ones included.
    pub fn bytes(&self) -> f64 {
        self.sent as f64 * self.asked.bits / 8.0
    }

    /// For programs; what is not known is null.
    pub fn to_json(&self) -> Value {
        let [from, to] = self.asked.agents;
        json!({
            "from": from, "to": to, "topic": self.asked.topic, "sent": self.sent, "lost": self.lost, "bytes": self.bytes(),
            "loss": { "asked": self.asked.loss, "measured": self.loss() },
            "delay_s": { "asked": self.asked.delay, "measured": self.delay },
            "rate_hz": { "asked": self.asked.rate, "measured": self.rate() },
            "age_s": { "mean": self.mean_age, "largest": self.largest_age },
            "interval_s": { "mean": self.interval, "least": self.least_interval },
        })
    }
}

/// All links of a log.
pub fn traffic(log: &Log, asked: &[AskedLink]) -> Vec<Traffic> {
    asked.iter().filter_map(|link| of_link(log, link)).collect()
}

fn of_link(log: &Log, asked: &AskedLink) -> Option<Traffic> {
    let signal = |field: &str| log.signal(&asked.topic, field);
    let (age, sequence) = (signal("link_age")?, signal("link_sequence")?);
    let (sent, lost) = (signal("link_sent")?, signal("link_lost")?);
    let times = log.times();
    let time = |row: usize| times[row] as f64 / 1e9;
    let (mut delay, mut arrived) = (0.0, 0_u64);
    let (mut total, mut largest_age) = (0.0, 0.0_f64);
    let (mut first, mut last, mut least_interval): (Option<f64>, Option<f64>, f64) = (None, None, f64::NAN);
    for row in 0..age.len() {
        let value = |series: &recording::Series, row: usize| series.row(row)[0];
        let before = |series: &recording::Series| if row == 0 { 0.0 } else { value(series, row - 1) };
        total += value(&age, row);
        largest_age = largest_age.max(value(&age, row));
        if value(&sequence, row) > before(&sequence) {
            delay += value(&age, row);
            arrived += 1;
        }
        if value(&sent, row) > before(&sent) {
            if let Some(last) = last {
                least_interval = least_interval.min(time(row) - last);
            }
            first = first.or(Some(time(row)));
            last = Some(time(row));
        }
    }
    let end = age.len().checked_sub(1)?;
    let (sent, lost) = (sent.row(end)[0], lost.row(end)[0]);
    let between = first.zip(last).map_or(f64::NAN, |(first, last)| (last - first) / (sent - 1.0));
    Some(Traffic {
        asked: asked.clone(),
        sent: sent as u64,
        lost: lost as u64,
        delay: delay / arrived as f64,
        mean_age: total / age.len() as f64,
        largest_age,
        interval: if sent > 1.0 { between } else { f64::NAN },
        least_interval,
        duration: time(end) - time(0),
    })
}
