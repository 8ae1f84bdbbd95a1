//! Which of the poses that the cameras send are believed.

use crate::message::Pose;
use crate::settings::Gate;

/// After so many poses in a row that are older than the newest one, the cameras must have been started again.
const RESTARTED: u32 = 20;
/// How much faster or slower the clock of the cameras may run.
const DRIFT: f64 = 1e-4;

/// What became of a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It is the newest that is known.
    Taken,
    /// The cameras did not see the body.
    NotSeen,
    /// Its number was there before.
    Duplicate,
    /// A newer one was there before.
    OutOfOrder,
    /// It is too far from the one before.
    Jump,
    /// It is of another body.
    Foreign,
}

/// How many poses had which fate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PoseCounts {
    /// Taken.
    pub taken: u64,
    /// The body was not seen.
    pub not_seen: u64,
    /// Were there before.
    pub duplicates: u64,
    /// Came after a newer one.
    pub out_of_order: u64,
    /// Beyond the gate.
    pub jumps: u64,
    /// Of other bodies.
    pub foreign: u64,
    /// Numbers that never came.
    pub missing: u64,
    /// No frames, or not of poses.
    pub malformed: u64,
    /// Dropped because too many came.
    pub too_many: u64,
}

impl std::fmt::Display for PoseCounts {
    fn fmt(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(formatter, "{} poses taken", self.taken)?;
        let rest = [
            (self.not_seen, "not seen"),
            (self.duplicates, "duplicated"),
            (self.out_of_order, "out of order"),
            (self.jumps, "beyond the gate"),
            (self.foreign, "of other bodies"),
            (self.missing, "missing"),
            (self.malformed, "malformed"),
            (self.too_many, "too many"),
        ];
        rest.iter().filter(|(count, _)| *count > 0).try_for_each(|(count, what)| write!(formatter, ", {count} {what}"))
    }
}

/// A pose that was taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// x, y, z in m, then roll, pitch, yaw in rad; angles are continuous.
    pub pose: [f64; 6],
    /// Number of its frame.
    pub number: u32,
    /// When it was captured, ns, by the clock of the cameras.
    pub stamp: u64,
}

/// Follows one body.
#[derive(Clone, Debug)]
pub struct Tracker {
    body: u32,
    gate: Option<Gate>,
    /// Number of the newest frame, seen or not.
    newest: Option<u32>,
    late_in_a_row: u32,
    last: Option<Seen>,
    /// Since when all poses are beyond the gate, s.
    beyond_since: Option<f64>,
    /// Least difference so far between the clock of this machine and that of the cameras, s, and when it was last looked at.
    offset: Option<(f64, f64)>,
    /// What became of the poses so far.
    pub counts: PoseCounts,
}

impl Tracker {
    /// Follows this body.
    pub fn new(body: u32, gate: Option<Gate>) -> Self {
        let counts = PoseCounts::default();
        Self { body, gate, newest: None, late_in_a_row: 0, last: None, beyond_since: None, offset: None, counts }
    }

    /// The newest pose that was taken.
    pub fn last(&self) -> Option<&Seen> {
        self.last.as_ref()
    }

    /// Number of the newest frame, whatever became of it.
    pub fn newest(&self) -> Option<u32> {
        self.newest
    }

    /// The cameras count from anew.
    pub fn restart(&mut self) {
        (self.newest, self.late_in_a_row, self.offset) = (None, 0, None);
    }

    /// Takes in a pose that arrived at `arrival` s by the clock of this machine, and was captured at `stamp` ns by that of the
    /// cameras.
    pub fn take(&mut self, number: u32, stamp: u64, pose: &Pose, arrival: f64) -> Verdict {
        let verdict = self.judge(number, stamp, pose);
        let counts = &mut self.counts;
        match verdict {
            Verdict::Taken => counts.taken += 1,
            Verdict::NotSeen => counts.not_seen += 1,
            Verdict::Duplicate => counts.duplicates += 1,
            Verdict::OutOfOrder => counts.out_of_order += 1,
            Verdict::Jump => counts.jumps += 1,
            Verdict::Foreign => counts.foreign += 1,
        }
        if !matches!(verdict, Verdict::Foreign | Verdict::Duplicate | Verdict::OutOfOrder) {
            self.compare_clocks(arrival, seconds(stamp));
        }
        verdict
    }

    fn judge(&mut self, number: u32, stamp: u64, pose: &Pose) -> Verdict {
        if pose.body != self.body {
            return Verdict::Foreign;
        }
        if let Some(newest) = self.newest {
            // Numbers start again at 0 after 2^32 frames.
            let ahead = number.wrapping_sub(newest) as i32;
            if ahead <= 0 {
                self.late_in_a_row += 1;
                if self.late_in_a_row < RESTARTED {
                    return if ahead == 0 { Verdict::Duplicate } else { Verdict::OutOfOrder };
                }
                self.restart();
            } else {
                self.counts.missing += ahead as u64 - 1;
            }
        }
        (self.newest, self.late_in_a_row) = (Some(number), 0);
        if !pose.valid {
            return Verdict::NotSeen;
        }
        let [x, y, z] = pose.position;
        let [roll, pitch, yaw] = pose.orientation;
        let mut values = [x, y, z, roll, pitch, yaw];
        if let Some(last) = self.last {
            for (angle, before) in values[3..].iter_mut().zip(&last.pose[3..]) {
                *angle = continued(*angle, *before);
            }
            if self.is_beyond(&values, &last.pose, seconds(stamp)) {
                return Verdict::Jump;
            }
        }
        self.beyond_since = None;
        self.last = Some(Seen { pose: values, number, stamp });
        Verdict::Taken
    }

    fn is_beyond(&mut self, pose: &[f64; 6], last: &[f64; 6], captured: f64) -> bool {
        let Some(gate) = self.gate else { return false };
        let square = |range: std::ops::Range<usize>| range.map(|j| (pose[j] - last[j]).powi(2)).sum::<f64>();
        let turn = (3..6).map(|j| (pose[j] - last[j]).abs()).fold(0.0, f64::max);
        if square(0..3).sqrt() <= gate.position && turn <= gate.angle {
            return false;
        }
        let since = *self.beyond_since.get_or_insert(captured);
        captured - since < gate.patience
    }

    /// The pose that took least on its way tells best how far the clocks are apart.
    fn compare_clocks(&mut self, arrival: f64, captured: f64) {
        let now = arrival - captured;
        self.offset = Some(match self.offset {
            Some((offset, at)) => (now.min(offset + DRIFT * (arrival - at)), arrival),
            None => (now, arrival),
        });
    }

    /// How long ago the newest pose was captured, s, at `now` s by the clock of this machine, if the fastest took `latency` s.
    pub fn age(&self, now: f64, latency: f64) -> Option<f64> {
        let (offset, _) = self.offset?;
        Some((now - offset - seconds(self.last?.stamp)).max(0.0) + latency)
    }
}

/// A time in ns as s: the number nearest to what people would write.
pub(crate) fn seconds(nanoseconds: u64) -> f64 {
    nanoseconds as f64 / 1e9
}

/// The angle that is closest to `before`, whole turns aside. One that is less than half a turn away is not touched.
fn continued(angle: f64, before: f64) -> f64 {
    let turns = ((before - angle) / std::f64::consts::TAU).round();
    if turns == 0.0 { angle } else { angle + turns * std::f64::consts::TAU }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(x: f64, yaw: f64) -> Pose {
        Pose { body: 2, valid: true, position: [x, 0.0, 0.0], orientation: [0.0, 0.0, yaw] }
    }

    fn tracker(gate: Option<Gate>) -> Tracker {
        Tracker::new(2, gate)
    }

    const MS: u64 = 1_000_000;

    #[test]
    fn only_newer_poses_of_the_body_are_taken() {
        let mut tracker = tracker(None);
        assert_eq!(tracker.take(5, 50 * MS, &pose(1.0, 0.0), 0.1), Verdict::Taken);
        assert_eq!(tracker.take(5, 50 * MS, &pose(1.0, 0.0), 0.1), Verdict::Duplicate);
        assert_eq!(tracker.take(4, 40 * MS, &pose(9.0, 0.0), 0.1), Verdict::OutOfOrder);
        assert_eq!(tracker.take(6, 60 * MS, &Pose { body: 3, ..pose(9.0, 0.0) }, 0.1), Verdict::Foreign);
        assert_eq!(tracker.take(6, 60 * MS, &Pose { valid: false, ..pose(9.0, 0.0) }, 0.1), Verdict::NotSeen);
        assert_eq!(tracker.last().map(|seen| (seen.number, seen.pose[0])), Some((5, 1.0)));
        assert_eq!(tracker.take(9, 90 * MS, &pose(1.1, 0.0), 0.1), Verdict::Taken);
        let counts = PoseCounts {
            taken: 2,
            not_seen: 1,
            duplicates: 1,
            out_of_order: 1,
            foreign: 1,
            missing: 2,
            ..PoseCounts::default()
        };
        assert_eq!(tracker.counts, counts);
    }

    #[test]
    fn numbers_start_again_after_the_last_and_after_a_restart() {
        let mut tracker = tracker(None);
        tracker.take(u32::MAX, 0, &pose(0.0, 0.0), 0.0);
        assert_eq!(tracker.take(0, 0, &pose(0.0, 0.0), 0.0), Verdict::Taken);
        tracker.take(1000, 0, &pose(0.0, 0.0), 0.0);
        let verdicts: Vec<Verdict> = (0..20).map(|number| tracker.take(number, 0, &pose(3.0, 0.0), 0.0)).collect();
        assert_eq!((verdicts[18], verdicts[19]), (Verdict::OutOfOrder, Verdict::Taken));
    }

    #[test]
    fn a_jump_is_believed_when_it_stays() {
        let mut tracker = tracker(Some(Gate { position: 0.1, angle: 0.5, patience: 0.05 }));
        tracker.take(0, 0, &pose(0.0, 0.0), 0.0);
        assert_eq!(tracker.take(1, 10 * MS, &pose(0.09, 0.4), 0.0), Verdict::Taken);
        assert_eq!(tracker.take(2, 20 * MS, &pose(0.3, 0.4), 0.0), Verdict::Jump);
        assert_eq!(tracker.take(3, 30 * MS, &pose(0.1, 1.0), 0.0), Verdict::Jump);
        assert_eq!(tracker.take(4, 40 * MS, &pose(0.1, 0.4), 0.0), Verdict::Taken);
        let verdicts: Vec<Verdict> =
            (5..11).map(|number| tracker.take(number, u64::from(number) * 10 * MS, &pose(0.5, 0.4), 0.0)).collect();
        assert_eq!(verdicts.iter().filter(|verdict| **verdict == Verdict::Jump).count(), 5);
        assert_eq!(verdicts[5], Verdict::Taken);
    }

    #[test]
    fn angles_go_on_beyond_half_a_turn() {
        let mut tracker = tracker(None);
        tracker.take(0, 0, &pose(0.0, 3.1), 0.0);
        tracker.take(1, 10 * MS, &pose(0.0, -3.1), 0.0);
        let yaw = tracker.last().unwrap().pose[5];
        assert!((yaw - (std::f64::consts::TAU - 3.1)).abs() < 1e-12, "{yaw}");
    }

    #[test]
    fn ages_are_those_of_the_capture_whatever_the_clocks_say() {
        let mut tracker = tracker(None);
        tracker.take(0, 500_000 * MS, &pose(0.0, 0.0), 10.0);
        tracker.take(1, 500_010 * MS, &pose(0.0, 0.0), 10.017);
        let age = tracker.age(10.017, 0.004).unwrap();
        assert!((age - (0.007 + 0.004)).abs() < 1e-5, "{age}");
    }
}
