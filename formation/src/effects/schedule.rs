//! Instants at a period of their own.

/// Sampling instants `phase + n*period`, at the first step at or behind each; without a period, every step from the phase on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Schedule {
    period: Option<f64>,
    phase: f64,
    /// The step, s.
    dt: f64,
    /// The next instant, s.
    next: f64,
}

/// How far before an instant a step may lie that counts as it, in steps: 3*0.1/0.1 is not exactly 3.
const TOLERANCE: f64 = 1e-9;

impl Schedule {
    /// Instants at `phase + n*period`, s, of a run with steps of `dt`.
    pub fn new(period: Option<f64>, phase: f64, dt: f64) -> Self {
        Self { period, phase, dt, next: phase }
    }

    /// Instants per second, at most one in every step.
    pub fn rate(&self) -> f64 {
        1.0 / self.period.map_or(self.dt, |period| period.max(self.dt))
    }

    /// Whether there is an instant at the step at time `t`; to be asked once at every step.
    pub fn is_due(&mut self, t: f64) -> bool {
        if t < self.next - TOLERANCE * self.dt {
            return false;
        }
        if let Some(period) = self.period {
            let past = ((t - self.phase + TOLERANCE * self.dt) / period).floor();
            self.next = self.phase + (past + 1.0) * period;
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn due(period: Option<f64>, phase: f64) -> Vec<usize> {
        let mut schedule = Schedule::new(period, phase, 0.1);
        (0..12).filter(|step| schedule.is_due(0.1 * *step as f64)).collect()
    }

    #[test]
    fn instants_are_those_of_the_period() {
        assert_eq!(due(None, 0.0).len(), 12);
        assert_eq!(due(Some(0.3), 0.0), [0, 3, 6, 9]);
        assert_eq!(due(Some(0.3), 0.2), [2, 5, 8, 11]);
        assert_eq!(due(Some(0.25), 0.0), [0, 3, 5, 8, 10]);
        // A period below the step is the step.
        assert_eq!(due(Some(0.05), 0.9), [9, 10, 11]);
    }
}
