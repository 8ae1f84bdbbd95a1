//! What the headers of samples have to say: the step, the time and the agent that they stand for.

use lockstep::{Header, Status};

/// The headers of one topic, one after the other.
#[derive(Clone, Debug, Default)]
pub(super) struct Headers {
    /// The agent that the name of the topic says, or the first header.
    agent: Option<u32>,
    /// Step and stamp (ns) of the last one.
    last: Option<(u64, i64)>,
}

impl Headers {
    /// Those of the topic `/agent_3/state`, or of any other.
    pub(super) fn of(topic: &str) -> Self {
        let number = topic.strip_prefix("/agent_").and_then(|rest| rest.split_once('/'));
        Self { agent: number.and_then(|(number, _)| number.parse().ok()), last: None }
    }

    /// Checks the header of the sample that stands at `step`, at `time_ns`: a fresh sample is one of its step; any other may be one
    /// that stood there before.
    ///
    /// # Errors
    /// Says what is wrong.
    pub(super) fn check(&mut self, header: &Header, step: u64, time_ns: u64) -> Result<(), String> {
        let stamp = i64::from(header.sec) * 1_000_000_000 + i64::from(header.nanosec);
        let found = (header.step, stamp);
        let is_now = header.step == step && i128::from(stamp) == i128::from(time_ns);
        let is_fresh = header.status == Status::Fresh as u32;
        // What was held when the log began is known to be older only.
        let was_before = match self.last {
            Some(last) => last == found,
            None => header.step < step && i128::from(stamp) < i128::from(time_ns),
        };
        let last = self.last.replace(found);
        if header.status > Status::Stale as u32 {
            return Err(format!("the sample of step {step} has the status {}, there are 0, 1 and 2", header.status));
        }
        if !is_now && (is_fresh || !was_before) {
            let (said, nanoseconds) = found;
            let before = last.map_or(String::new(), |(step, _)| format!(", and the one before that of step {step}"));
            return Err(format!(
                "the sample of step {step} ({time_ns} ns) says that it is that of step {said} ({nanoseconds} ns){before}"
            ));
        }
        let agent = *self.agent.get_or_insert(header.agent);
        if agent != header.agent {
            return Err(format!("the sample of step {step} says that it is of agent {}, not of {agent}", header.agent));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: u64 = 1_000;

    fn header(step: u64, status: Status) -> Header {
        Header::new(step, PERIOD, 2, status)
    }

    #[test]
    fn a_sample_is_of_its_step_or_stands_from_before() {
        let mut headers = Headers::of("/agent_2/state");
        for (step, header) in [
            (3, header(1, Status::Held)),
            (4, header(4, Status::Fresh)),
            (5, header(4, Status::Held)),
            (6, header(4, Status::Stale)),
            (7, header(7, Status::Held)),
        ] {
            assert_eq!(headers.check(&header, step, step * PERIOD), Ok(()), "{step}");
        }
    }

    #[test]
    fn what_contradicts_the_record_is_said() {
        let check = |header: Header, step: u64, time: u64| {
            let mut headers = Headers::of("/agent_2/state");
            headers.check(&Header::new(3, PERIOD, 2, Status::Fresh), 3, 3 * PERIOD).unwrap();
            headers.check(&header, step, time).unwrap_err()
        };
        let fresh = header(4, Status::Fresh);
        assert!(check(Header { step: 1 << 63, ..fresh }, 4, 4_000).contains("9223372036854775808"));
        assert!(check(Header { step: 3, ..fresh }, 4, 4_000).contains("step 3"));
        assert!(check(Header { nanosec: 4_001, ..fresh }, 4, 4_000).contains("4001 ns"));
        assert!(check(Header { sec: -1, ..fresh }, 4, 4_000).contains("-999996000 ns"));
        assert!(check(header(2, Status::Held), 4, 4_000).contains("step 2"));
        assert!(check(Header { agent: 1, ..fresh }, 4, 4_000).contains("agent 1"));
        assert!(check(Header { status: 3, ..fresh }, 4, 4_000).contains("status 3"));
    }

    #[test]
    fn any_topic_is_of_one_agent() {
        let mut headers = Headers::of("/phalanx/pace");
        headers.check(&Header::new(0, PERIOD, 0, Status::Fresh), 0, 0).unwrap();
        assert!(headers.check(&Header::new(1, PERIOD, 1, Status::Fresh), 1, PERIOD).is_err());
    }
}
