//! Violations in the log of the run: messages that every viewer of ROS 2 logs shows.

use super::{Finding, Severity, Violation};
use recording::Cdr;
use recording::definitions::{Definition, JOURNAL};

/// Where they are written.
pub(crate) const TOPIC: &str = "/phalanx/assertions";
/// Their type, and its definition.
pub(crate) const DEFINITION: &[Definition] = JOURNAL;

const WARN: u8 = 30;
const ERROR: u8 = 40;

/// A violation as CDR, with its encapsulation. `time_ns` is the simulated time, ns.
pub(crate) fn encode(finding: &Finding, violation: &Violation, time_ns: u64) -> Cdr {
    let level = if finding.severity == Severity::Fail { ERROR } else { WARN };
    let text = format!("{}: {}", finding.name, violation.text(&finding.signal));
    let mut cdr = Cdr::new();
    let head = cdr.stamp(time_ns).u8(level).text("phalanx.assertions");
    head.text(&text).text("scenario.toml").text(&finding.name).u32(0);
    cdr
}
