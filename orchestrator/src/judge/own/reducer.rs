//! What becomes of a signal over time, and of the numbers of several agents.

use lockstep::ChannelId;

use crate::judge::assertions::AgentSignal;

/// What a reducer takes of a signal over time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reducer {
    Max,
    Min,
    Mean,
    Rms,
    Final,
    Integral,
    Variation,
    Share,
    Settle,
}

impl Reducer {
    pub(super) const ALL: [(&str, Self); 9] = [
        ("max", Self::Max),
        ("min", Self::Min),
        ("mean", Self::Mean),
        ("rms", Self::Rms),
        ("final", Self::Final),
        ("integral", Self::Integral),
        ("variation", Self::Variation),
        ("share", Self::Share),
        ("settle", Self::Settle),
    ];
}

/// How the numbers of several agents become one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Across {
    Max,
    Mean,
    Sum,
    Min,
}

impl Across {
    pub(super) const ALL: [(&str, Self); 4] =
        [("max", Self::Max), ("mean", Self::Mean), ("sum", Self::Sum), ("min", Self::Min)];

    /// One number of those of all agents; NaN if one of them is.
    fn of(self, values: &[f64]) -> f64 {
        if values.iter().any(|value| value.is_nan()) {
            return f64::NAN;
        }
        let sum = || values.iter().sum::<f64>();
        match self {
            Self::Max => values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            Self::Min => values.iter().copied().fold(f64::INFINITY, f64::min),
            Self::Sum => sum(),
            Self::Mean => sum() / values.len() as f64,
        }
    }
}

/// Below which value a signal has settled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Threshold {
    /// This one.
    Below(f64),
    /// This share of its first value.
    Within(f64),
}

/// A reducer with its signal, for every agent.
#[derive(Clone, Debug)]
pub(super) struct Reduction {
    pub(super) reducer: Reducer,
    pub(super) across: Across,
    /// First and last step that count.
    pub(super) steps: (u64, u64),
    /// For [`Reducer::Settle`].
    pub(super) threshold: Threshold,
    pub(super) subjects: Vec<Subject>,
}

/// The signal of one agent, and what has been seen of it.
#[derive(Clone, Debug)]
pub(super) struct Subject {
    pub(super) signal: AgentSignal,
    seen: Seen,
}

/// What a reducer remembers of a signal.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    count: u64,
    sum: f64,
    first: f64,
    last: f64,
    largest: f64,
    smallest: f64,
    /// When it settled, if it has.
    since: Option<f64>,
}

impl Subject {
    pub(super) fn new(signal: AgentSignal) -> Self {
        Self { signal, seen: Seen::default() }
    }
}

impl Reduction {
    /// Takes the samples of a step.
    pub(super) fn step<'s>(
        &mut self,
        step: u64,
        dt: f64,
        sample: &impl Fn(ChannelId) -> &'s [f64],
        slots: &mut Vec<f64>,
    ) {
        if step < self.steps.0 || step > self.steps.1 {
            return;
        }
        let time = step as f64 * dt;
        for Subject { signal, seen } in &mut self.subjects {
            let value = signal.value(time, sample, slots);
            seen.take(value, time, dt, self.reducer, self.threshold);
        }
    }

    /// The number that results; NaN if there is none.
    pub(super) fn result(&self) -> f64 {
        let values: Vec<f64> = self.subjects.iter().map(|subject| subject.seen.result(self.reducer)).collect();
        if values.is_empty() { f64::NAN } else { self.across.of(&values) }
    }
}

impl Seen {
    fn take(&mut self, value: f64, time: f64, dt: f64, reducer: Reducer, threshold: Threshold) {
        let before = self.last;
        if self.count == 0 {
            (self.first, self.largest, self.smallest) = (value, value, value);
        }
        self.sum += match reducer {
            Reducer::Rms => value * value,
            // The trapezoidal rule.
            Reducer::Integral if self.count > 0 => 0.5 * dt * (before + value),
            Reducer::Variation if self.count > 0 => (value - before).abs(),
            Reducer::Integral | Reducer::Variation => 0.0,
            _ => value,
        };
        // A value that is not a number makes all of these not a number.
        let is_nan = value.is_nan() || self.largest.is_nan();
        (self.largest, self.smallest) = match is_nan {
            true => (f64::NAN, f64::NAN),
            false => (self.largest.max(value), self.smallest.min(value)),
        };
        let limit = match threshold {
            Threshold::Below(limit) => limit,
            Threshold::Within(share) => share * self.first,
        };
        self.since = if value <= limit { self.since.or(Some(time)) } else { None };
        self.last = value;
        self.count += 1;
    }

    fn result(&self, reducer: Reducer) -> f64 {
        if self.count == 0 {
            return f64::NAN;
        }
        let mean = self.sum / self.count as f64;
        match reducer {
            Reducer::Max => self.largest,
            Reducer::Min => self.smallest,
            Reducer::Mean | Reducer::Share => mean,
            Reducer::Rms => mean.sqrt(),
            Reducer::Final => self.last,
            Reducer::Integral | Reducer::Variation => self.sum,
            Reducer::Settle => self.since.unwrap_or(f64::NAN),
        }
    }
}
