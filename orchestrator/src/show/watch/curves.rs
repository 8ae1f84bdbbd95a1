//! Tracking errors over the whole time that was seen, thinned out.

use super::Errors;
use super::sparkline::sparkline;

/// Points that are kept.
const MOST_POINTS: usize = 4000;

/// A curve per agent.
#[derive(Clone, Debug, Default)]
pub(super) struct Curves {
    errors: Errors,
    /// Least time between two points, s.
    spacing: f64,
}

impl Curves {
    /// Adds points. One that is too close to the one before is merged with it: the larger value stays.
    pub(super) fn extend(&mut self, more: &Errors) {
        self.errors.values.resize(more.values.len(), vec![f64::NAN; self.errors.times.len()]);
        self.errors.unit.clone_from(&more.unit);
        for (point, &time) in more.times.iter().enumerate() {
            let at = |agent: usize| more.values[agent][point];
            if self.errors.times.last().is_some_and(|last| time - last < self.spacing) {
                self.merge(at);
            } else {
                self.errors.times.push(time);
                self.errors.values.iter_mut().enumerate().for_each(|(agent, list)| list.push(at(agent)));
            }
            if self.errors.times.len() >= MOST_POINTS {
                self.halve();
            }
        }
    }

    fn merge(&mut self, at: impl Fn(usize) -> f64) {
        for (agent, list) in self.errors.values.iter_mut().enumerate() {
            if let Some(last) = list.last_mut() {
                *last = last.max(at(agent));
            }
        }
    }

    fn halve(&mut self) {
        let largest = |pair: &[f64]| pair.iter().copied().fold(f64::NAN, f64::max);
        for list in &mut self.errors.values {
            *list = list.chunks(2).map(largest).collect();
        }
        self.errors.times = self.errors.times.iter().copied().step_by(2).collect();
        let span = self.end() - self.start();
        self.spacing = span / self.errors.times.len() as f64;
    }

    /// Number of agents.
    pub(super) fn agents(&self) -> usize {
        self.errors.values.len()
    }

    /// All values.
    pub(super) fn values(&self) -> impl Iterator<Item = &[f64]> {
        self.errors.values.iter().map(Vec::as_slice)
    }

    /// Unit of the values.
    pub(super) fn unit(&self) -> &str {
        &self.errors.unit
    }

    /// The first time, s; 0 before the first point.
    pub(super) fn start(&self) -> f64 {
        self.errors.times.first().copied().unwrap_or(0.0)
    }

    fn end(&self) -> f64 {
        self.errors.times.last().copied().unwrap_or(0.0)
    }

    /// The curve of an agent over the whole time, in `width` characters.
    pub(super) fn line(&self, agent: usize, width: usize, limits: [f64; 2], blocks: bool) -> String {
        let (start, span) = (self.start(), self.end() - self.start());
        let mut columns = vec![f64::NAN; width.min(self.errors.times.len())];
        let last = columns.len().saturating_sub(1);
        for (time, &value) in self.errors.times.iter().zip(&self.errors.values[agent]) {
            let share = if span > 0.0 { (time - start) / span } else { 0.0 };
            let column = ((share * columns.len() as f64) as usize).min(last);
            columns[column] = columns[column].max(value);
        }
        // A column in which no sample falls shows the one before.
        for column in 1..columns.len() {
            if columns[column].is_nan() {
                columns[column] = columns[column - 1];
            }
        }
        sparkline(&columns, columns.len(), limits, blocks)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn errors(times: impl Iterator<Item = f64> + Clone, value: impl Fn(f64) -> f64) -> Errors {
        Errors { values: vec![times.clone().map(value).collect()], times: times.collect(), unit: "m".into() }
    }

    #[test]
    fn time_passes_evenly_however_often_it_was_looked() {
        let mut curves = Curves::default();
        // A thousand points of the first half, two of the second.
        curves.extend(&errors((0..1000).map(|k| f64::from(k) / 1000.0), |_| 1.0));
        curves.extend(&errors([1.1, 2.0].into_iter(), |_| 100.0));
        assert_eq!(curves.line(0, 8, [1.0, 100.0], false), "....@@@@");
        assert_eq!((curves.start(), curves.agents()), (0.0, 1));
    }

    #[test]
    fn no_peak_is_lost_in_a_long_run() {
        let mut curves = Curves::default();
        for k in 0..100_000 {
            let value = if k == 77 { 9.0 } else { 1.0 };
            curves.extend(&errors(std::iter::once(f64::from(k)), |_| value));
        }
        assert!(curves.errors.times.len() < MOST_POINTS);
        assert!(curves.line(0, 10, [1.0, 9.0], false).starts_with('@'));
        assert_eq!(curves.line(0, 10, [1.0, 9.0], false).matches('@').count(), 1);
    }
}
