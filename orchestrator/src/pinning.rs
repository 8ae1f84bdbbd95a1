//! Which cores the processes of a run use.

use std::time::Duration;

use lockstep::{CoreSlot, Plan, Snapshot, allowed_cores, keep_off_core, wake_up_time};

use crate::failure::Failure;

/// Steps after which `auto` knows what participants compute.
pub const MEASURED_STEPS: u64 = 200;
/// Wake-ups across cores per phase of a step, as far as they cannot hide behind each other. Measured on two cores: with 19
/// processes in 4 phases, spreading cost 1.5 wake-ups per phase.
const WAKE_UPS_PER_PHASE: f64 = 1.5;
/// The gain must exceed the cost by this factor, since both are measured in a short time.
const MARGIN: f64 = 1.2;

/// What the command line asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pin {
    /// One core, or several if the participants compute so much that it pays; measured.
    #[default]
    Auto,
    /// The operating system decides.
    None,
    /// This core.
    Core(usize),
}

impl Pin {
    /// Reads `auto`, `none` or the number of a core.
    ///
    /// # Errors
    /// [`Failure::Usage`] if it is none of them, or the core is not allowed.
    pub fn parse(text: &str) -> Result<Self, Failure> {
        match text {
            "auto" => return Ok(Self::Auto),
            "none" => return Ok(Self::None),
            _ => {}
        }
        let cores = allowed_cores().map_err(Failure::system("ask for the cores of this machine"))?;
        match text.parse() {
            Ok(core) if cores.contains(&core) => Ok(Self::Core(core)),
            _ => {
                let list: Vec<String> = cores.iter().map(usize::to_string).collect();
                let cores = list.join(", ");
                Err(Failure::Usage(format!("--pin {text}: expected auto, none or one of the cores {cores}")))
            }
        }
    }

    /// Chooses the core that all processes start on, if any, and keeps the calling thread off it until the run starts.
    ///
    /// # Errors
    /// [`Failure::System`] if the operating system does not tell its cores.
    pub fn take(self) -> Result<Home, Failure> {
        let slot = match self {
            Self::Auto => Some(CoreSlot::take().map_err(Failure::system("take a core"))?),
            Self::None | Self::Core(_) => None,
        };
        let core = match self {
            Self::Core(core) => Some(core),
            _ => slot.as_ref().map(|slot| slot.core),
        };
        if let Some(core) = core {
            keep_off_core(core).map_err(Failure::system("leave a core to the run"))?;
        }
        Ok(Home { core, slot })
    }
}

/// Where a run lives.
#[derive(Debug, Default)]
pub struct Home {
    /// The core that all processes start on; `None`: the operating system decides.
    pub core: Option<usize>,
    /// The same, if it was chosen and taken from other runs.
    pub slot: Option<CoreSlot>,
}

/// How processes may be spread, and what it would bring per step.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// The core of every worker.
    pub cores: Vec<usize>,
    /// Computing time that is saved, s.
    pub gain: f64,
    /// What the wake-ups across cores cost, s.
    pub cost: f64,
}

impl Spread {
    /// Measures this machine, and weighs what the participants have computed so far on `core`, one of `cores`.
    ///
    /// # Errors
    /// [`Failure::System`] if the machine cannot be measured.
    pub fn measure(plan: &Plan, snapshot: &Snapshot, core: usize, cores: &[usize]) -> Result<Self, Failure> {
        let failed = || Failure::system("measure the wake-ups of this machine");
        let others: Vec<usize> = cores.iter().copied().filter(|&other| other != core).collect();
        let Some(&other) = others.first() else {
            return Ok(Self { cores: vec![core; plan.workers.len()], gain: 0.0, cost: 0.0 });
        };
        let near = wake_up_time(core, core).map_err(failed())?;
        let far = wake_up_time(core, other).map_err(failed())?;
        let compute =
            snapshot.workers.iter().map(|usage| usage.compute.as_secs_f64() / snapshot.completed.max(1) as f64);
        let order: Vec<usize> = std::iter::once(core).chain(others).collect();
        Ok(Self::plan(plan, &compute.collect::<Vec<_>>(), &order, far.saturating_sub(near)))
    }

    /// Spreads workers that compute so many seconds per step over `cores`; a wake-up across them takes `dearer` more.
    fn plan(plan: &Plan, compute: &[f64], cores: &[usize], dearer: Duration) -> Self {
        let mut chosen = vec![cores[0]; compute.len()];
        let mut gain = 0.0;
        for phase in 0..plan.phase_count() {
            let mut members = plan.members(phase);
            // The longest first, each to the core that has least to do.
            members.sort_by(|&a, &b| compute[b].total_cmp(&compute[a]));
            let mut loads = vec![0.0; cores.len()];
            for worker in members {
                let least = (0..cores.len()).min_by(|&a, &b| f64::total_cmp(&loads[a], &loads[b])).unwrap_or(0);
                loads[least] += compute[worker];
                chosen[worker] = cores[least];
            }
            gain += loads.iter().sum::<f64>() - loads.iter().copied().fold(0.0, f64::max);
        }
        let cost = WAKE_UPS_PER_PHASE * plan.phase_count() as f64 * dearer.as_secs_f64();
        Self { cores: chosen, gain, cost }
    }

    /// Whether spreading pays.
    pub fn pays(&self) -> bool {
        self.gain > MARGIN * self.cost && self.cores.iter().any(|core| *core != self.cores[0])
    }
}

#[cfg(test)]
mod tests {
    use lockstep::{Channel, ChannelId, Input, Layout, Network, Node, Timing, WorkerPlan};

    use super::*;

    /// One worker that six others wait for.
    fn plan() -> Plan {
        let channel = |index| Channel { topic: format!("/c{index}"), agent: 0, layout: Layout::default() };
        let node = |index: usize| Node {
            name: format!("n{index}"),
            inputs: (index > 0)
                .then_some(Input { channel: ChannelId(0), timing: Timing::SameStep })
                .into_iter()
                .collect(),
            outputs: vec![ChannelId(index)],
            every: 1,
            offset: 0,
        };
        let network = Network { channels: (0..7).map(channel).collect(), nodes: (0..7).map(node).collect() };
        let workers = (0..7).map(|index| WorkerPlan { name: format!("w{index}"), nodes: vec![index] });
        Plan::new("spread", network, 1000, 1, workers.collect()).unwrap()
    }

    #[test]
    fn much_work_is_spread_and_little_is_not() {
        let dearer = Duration::from_micros(20);
        let heavy = Spread::plan(&plan(), &[100e-6; 7], &[4, 2], dearer);
        assert!(heavy.pays());
        assert!((heavy.gain - 300e-6).abs() < 1e-12 && (heavy.cost - 60e-6).abs() < 1e-12, "{heavy:?}");
        assert_eq!(heavy.cores.iter().filter(|core| **core == 4).count(), 4);
        assert!(!Spread::plan(&plan(), &[1e-6; 7], &[4, 2], dearer).pays());
        assert!(!Spread::plan(&plan(), &[1.0; 7], &[4], dearer).pays());
    }

    #[test]
    fn a_core_that_is_not_there_is_refused() {
        assert_eq!(Pin::parse("none").unwrap(), Pin::None);
        assert!(Pin::parse("4000").unwrap_err().to_string().contains("expected auto, none or one of the cores"));
    }
}
