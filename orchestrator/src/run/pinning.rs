//! Which cores the processes of a run use.

use std::time::Duration;

use processes::{CoreFindings, CoreSlot, allowed_cores, keep_off_core};

use crate::failure::Failure;

/// What the command line asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pin {
    /// One core, or several if steps are shorter there; tried while the run goes on.
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
    /// [`Failure::Usage`] for another text, or a core that is not allowed.
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
    pub fn take(self) -> Result<Affinity, Failure> {
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
        Ok(Affinity { core, slot })
    }
}

/// Where a run lives.
#[derive(Debug, Default)]
pub struct Affinity {
    /// The core that all processes start on; `None`: the operating system decides.
    pub core: Option<usize>,
    /// The same, if it was chosen and taken from other runs.
    pub slot: Option<CoreSlot>,
}

/// What the search for the best number of cores has come to, for people; `None` if nothing was tried.
pub(crate) fn describe(found: &CoreFindings, is_shared: bool) -> Option<String> {
    let micros = |time: Duration| format!("{:.0} us", time.as_secs_f64() * 1e6);
    let cores: Vec<String> = found.cores.iter().map(usize::to_string).collect();
    let shared = if is_shared { ", which it shares with another run" } else { "" };
    Some(match (found.alone?, found.tried, cores.as_slice()) {
        (alone, Some((count, time)), [core]) => format!(
            "all processes on core {core}{shared}: a step took {} there and {} on {count} cores",
            micros(alone),
            micros(time)
        ),
        (alone, Some((count, time)), cores) => format!(
            "processes on cores {}: a step took {} on {count} cores and {} on one",
            cores.join(" and "),
            micros(time),
            micros(alone)
        ),
        (alone, None, [core]) => format!("all processes on core {core}{shared}: a step took {} there", micros(alone)),
        (_, None, _) => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_choice_is_told_with_its_reason() {
        let (alone, tried) = (Some(Duration::from_micros(940)), Some((2, Duration::from_micros(500))));
        let told = describe(&CoreFindings { cores: vec![1, 0], alone, tried }, false).unwrap();
        assert_eq!(told, "processes on cores 1 and 0: a step took 500 us on 2 cores and 940 us on one");
        let told = describe(&CoreFindings { cores: vec![1], alone, tried }, true).unwrap();
        assert!(
            told.starts_with("all processes on core 1, which it shares with another run: a step took 940 us"),
            "{told}"
        );
        assert_eq!(describe(&CoreFindings { cores: vec![1], alone: None, tried: None }, false), None);
    }

    #[test]
    fn a_core_that_is_not_there_is_refused() {
        assert_eq!(Pin::parse("none").unwrap(), Pin::None);
        assert!(Pin::parse("4000").unwrap_err().to_string().contains("expected auto, none or one of the cores"));
    }
}
