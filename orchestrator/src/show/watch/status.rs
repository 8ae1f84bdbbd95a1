//! The state of a run, from the answers of its control socket.

use crate::run::control::{Status, WorkerStatus};

/// The state of a run and its speed, from two answers.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct LiveStatus {
    /// Name of the run.
    pub(crate) run: String,
    /// Scenario and variant.
    pub(crate) title: String,
    /// Completed steps.
    pub(crate) steps: u64,
    /// Steps of the whole run.
    pub(crate) of: u64,
    /// Simulated time, s.
    pub(crate) time: f64,
    /// Length of the run, s.
    pub(crate) duration: f64,
    /// Number of processes.
    pub(crate) processes: u64,
    /// Whether it is paused.
    pub(crate) paused: bool,
    /// Steps per second between the two answers.
    pub(crate) rate: f64,
    /// Simulated seconds per second between the two answers.
    pub(crate) speed: f64,
    /// The processes that the others wait for now.
    pub(crate) awaited: Vec<String>,
    /// Processes with the share of steps between the two answers in which they completed their phase last, the largest first.
    pub(crate) last: Vec<(String, f64)>,
}

impl LiveStatus {
    /// From the answer before, if there was one, and the one now.
    pub(crate) fn of(before: Option<&Status>, now: &Status) -> Self {
        let start = Status::default();
        let before = before.unwrap_or(&start);
        let wall = (now.wall_s - before.wall_s).max(1e-9);
        let share = |(index, worker): (usize, &WorkerStatus)| {
            let (last, runs) = before.workers.get(index).map_or((0, 0), |old| (old.last, old.runs));
            let runs = worker.runs.saturating_sub(runs).max(1);
            (worker.name.clone(), worker.last.saturating_sub(last) as f64 / runs as f64)
        };
        let mut last: Vec<(String, f64)> = now.workers.iter().enumerate().map(share).collect();
        last.retain(|(_, share)| *share > 0.0);
        last.sort_by(|a, b| b.1.total_cmp(&a.1));
        Self {
            run: now.run.clone(),
            title: format!("{} {}", now.scenario, now.variant).trim().to_string(),
            steps: now.steps,
            of: now.of,
            time: now.time,
            duration: now.of.saturating_sub(1) as f64 * now.dt,
            processes: now.processes,
            paused: now.paused,
            rate: now.steps.saturating_sub(before.steps) as f64 / wall,
            speed: (now.time - before.time) / wall,
            awaited: now.awaited.clone(),
            last,
        }
    }

    /// Share of the run that is done, from 0 to 1.
    pub(crate) fn share(&self) -> f64 {
        self.steps as f64 / self.of.max(1) as f64
    }

    /// Progress and speed, in one line.
    pub(crate) fn sentence(&self) -> String {
        let (time, duration) = (self.time.min(self.duration), self.duration);
        let far = format!("t = {time:.2} of {duration} s ({:.0} %)", 100.0 * self.share());
        if self.paused {
            return format!("{far}, paused");
        }
        let left = (self.of.saturating_sub(self.steps)) as f64 / self.rate.max(1e-9);
        let left = if left < 1e6 { format!(", {left:.0} s left") } else { String::new() };
        format!("{far}, {:.0} steps/s, {:.1} x real time{left}", self.rate, self.speed)
    }

    /// The processes that finish last and make the others wait, in one line; empty if there are none.
    pub(crate) fn waiting(&self) -> String {
        if self.paused {
            return "no process computes: the run is paused".into();
        }
        let percent = |share: f64| format!("{:.0} %", 100.0 * share);
        let mut slowest = self.last.iter().take(4);
        let Some((name, share)) = slowest.next() else { return String::new() };
        let first = format!("slowest participants: {name} (last in {} of its steps)", percent(*share));
        slowest.fold(first, |text, (name, share)| format!("{text}, {name} ({})", percent(*share)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speed_and_laggards_are_those_between_two_answers() {
        let worker = |name: &str, runs, last| WorkerStatus { name: name.into(), runs, last, ..WorkerStatus::default() };
        let status = |steps: u64, wall_s: f64, last: [u64; 2]| Status {
            run: "uav-2".into(),
            scenario: "uav".into(),
            variant: "TSC".into(),
            steps,
            of: 8001,
            dt: 0.01,
            time: steps as f64 * 0.01,
            wall_s,
            processes: 15,
            awaited: vec!["b".into()],
            workers: vec![worker("a", steps, last[0]), worker("b", steps, last[1])],
            ..Status::default()
        };
        let status = LiveStatus::of(Some(&status(1000, 1.0, [900, 100])), &status(3000, 2.0, [1000, 2000]));
        assert_eq!((status.rate, status.speed, status.duration), (2000.0, 20.0, 80.0));
        assert_eq!(status.last, [("b".to_string(), 0.95), ("a".to_string(), 0.05)]);
        assert_eq!(status.sentence(), "t = 30.00 of 80 s (37 %), 2000 steps/s, 20.0 x real time, 3 s left");
        assert_eq!(status.waiting(), "slowest participants: b (last in 95 % of its steps), a (5 %)");
        assert_eq!(status.title, "uav TSC");
    }
}
