//! What a run did before it was watched: read from its log, as far as that is there.

use std::path::Path;
use std::time::{Duration, Instant};

use lockstep::{Header, Network};
use recording::{Log, LogError, Stream, is_being_written};

/// How long reading may take; the run continues meanwhile.
const PATIENCE: Duration = Duration::from_secs(5);
/// Steps between two looks at the clock.
const LOOK: u64 = 1000;

/// Why nothing is known of the time before.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NoPast {
    /// There is no log.
    #[error("the run is not recorded")]
    Unrecorded,
    /// The file is missing, or belongs to another run.
    #[error("its log cannot be read yet")]
    Unwritten,
    /// The file cannot be read.
    #[error("its log cannot be read: {0}")]
    Log(#[from] LogError),
    /// It is too long to be read before the first picture.
    #[error("its log takes too long to read")]
    TooLong,
}

/// Which steps are kept of a run: as many as there is room for, evenly spread over its time.
#[derive(Clone, Debug)]
pub(super) struct KeptSteps {
    /// Steps that may be kept.
    limit: usize,
    /// The first step and the one that was kept last.
    ends: Option<(u64, u64)>,
    /// Least distance between two steps that are kept.
    spacing: u64,
}

impl KeptSteps {
    pub(super) fn of(limit: usize) -> Self {
        Self { limit, ends: None, spacing: 1 }
    }

    /// Adds a step to `log` if it is due; `step` is after all that came before.
    pub(super) fn take<'a>(
        &mut self,
        log: &mut Log,
        step: u64,
        time_ns: u64,
        samples: impl Iterator<Item = (&'a Header, &'a [f64])>,
    ) {
        let (first, last) = self.ends.unwrap_or((step, step));
        if self.ends.is_some() && step < last + self.spacing {
            return;
        }
        if log.times().len() >= self.limit {
            log.thin();
            self.spacing = ((last - first) / (self.limit as u64 / 2)).max(1);
        }
        log.push(time_ns, samples);
        self.ends = Some((first, step));
    }

    /// The step that was kept last.
    pub(super) fn last(&self) -> Option<u64> {
        self.ends.map(|(_, last)| last)
    }
}

/// Reads what the log of a run holds already into `history`.
///
/// # Errors
/// [`NoPast`]; `history` is empty then.
pub(super) fn read_past(
    path: Option<&Path>,
    network: &Network,
    kept_steps: &mut KeptSteps,
    history: &mut Log,
) -> Result<(), NoPast> {
    let path = path.ok_or(NoPast::Unrecorded)?;
    // Before the first step, the file of an earlier run stands there.
    if !is_being_written(path) {
        return Err(NoPast::Unwritten);
    }
    let start = Instant::now();
    let mut trial = kept_steps.clone();
    let result = follow(path, network, &mut trial, history, start);
    match result {
        Ok(()) => *kept_steps = trial,
        Err(_) => history.clear(),
    }
    result
}

fn follow(
    path: &Path,
    network: &Network,
    kept_steps: &mut KeptSteps,
    history: &mut Log,
    start: Instant,
) -> Result<(), NoPast> {
    let channels = network.channels.iter();
    let topics: Vec<_> = channels.map(|channel| (channel.topic.clone(), channel.layout.clone())).collect();
    let mut stream = Stream::open(path, &topics)?;
    loop {
        match stream.advance() {
            Ok(true) => {}
            Ok(false) => return Ok(()),
            // The end of a file that is being written may change while it is read.
            Err(_) if kept_steps.last().is_some() => return Ok(()),
            Err(error) => return Err(error.into()),
        }
        let step = stream.step().unwrap_or_default();
        if step % LOOK == 0 && start.elapsed() > PATIENCE {
            return Err(NoPast::TooLong);
        }
        let headers: Vec<Header> = (0..topics.len()).map(|topic| stream.header(topic)).collect();
        let samples = headers.iter().enumerate().map(|(topic, header)| (header, stream.words(topic)));
        kept_steps.take(history, step, stream.time_ns(), samples);
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use lockstep::{Channel, Field, Layout, Status};

    use super::*;

    #[test]
    fn steps_that_are_kept_are_spread_evenly() {
        let layout = Layout::new([Field::vector("x", 1, "m")]);
        let channels = vec![Channel { topic: "/agent_1/state".into(), agent: 1, layout, initial: Vec::new() }];
        let mut log =
            Log::live("run", &Network { channels, nodes: Vec::new() }, String::new(), BTreeMap::new(), BTreeMap::new());
        let mut kept_steps = KeptSteps::of(100);
        for step in 0..100_000_u64 {
            let header = Header::new(step, 1, 1, Status::Fresh);
            kept_steps.take(&mut log, step, step, std::iter::once((&header, &[0.0][..])));
        }
        let times = log.times();
        assert!((50..=100).contains(&times.len()), "{}", times.len());
        let gaps: Vec<u64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let (least, most) = (gaps.iter().min().unwrap(), gaps.iter().max().unwrap());
        assert!(*most <= 4 * least, "{least} ... {most}");
        assert!(times[0] < 4000 && times[times.len() - 1] > 96_000, "{times:?}");
    }

    #[test]
    fn a_run_without_a_log_has_no_past() {
        let network = Network { channels: Vec::new(), nodes: Vec::new() };
        let mut log = Log::live("run", &network, String::new(), BTreeMap::new(), BTreeMap::new());
        let mut kept_steps = KeptSteps::of(100);
        let mut read = |path: Option<&str>| read_past(path.map(Path::new), &network, &mut kept_steps, &mut log);
        assert!(matches!(read(None), Err(NoPast::Unrecorded)));
        assert!(matches!(read(Some("/nowhere/run.mcap")), Err(NoPast::Unwritten)));
    }
}
