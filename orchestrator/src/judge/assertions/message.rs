//! Violations in the log of the run: messages that every viewer of ROS 2 logs shows.

use super::{Finding, Severity, Violation};

/// Where they are written.
pub(crate) const TOPIC: &str = "/phalanx/assertions";
/// Their type.
pub(crate) const SCHEMA_NAME: &str = "rcl_interfaces/msg/Log";
/// Its definition.
pub(crate) const SCHEMA_TEXT: &str = "\
byte DEBUG=10
byte INFO=20
byte WARN=30
byte ERROR=40
byte FATAL=50
builtin_interfaces/Time stamp
uint8 level
string name
string msg
string file
string function
uint32 line
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";

const WARN: u8 = 30;
const ERROR: u8 = 40;

/// A violation as CDR, little-endian, with its encapsulation. `time_ns` is the simulated time, ns.
pub(crate) fn encode(finding: &Finding, violation: &Violation, time_ns: u64) -> Vec<u8> {
    let mut cdr = Cdr(vec![0, 1, 0, 0]);
    cdr.u32((time_ns / 1_000_000_000) as u32);
    cdr.u32((time_ns % 1_000_000_000) as u32);
    cdr.0.push(if finding.severity == Severity::Fail { ERROR } else { WARN });
    cdr.text("phalanx.assertions");
    cdr.text(&format!("{}: {}", finding.name, violation.text(&finding.signal)));
    cdr.text("scenario.toml");
    cdr.text(&finding.name);
    cdr.u32(0);
    cdr.0
}

struct Cdr(Vec<u8>);

impl Cdr {
    fn u32(&mut self, value: u32) {
        // The four bytes of encapsulation do not change the alignment.
        self.0.resize(self.0.len().next_multiple_of(4), 0);
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        self.u32(text.len() as u32 + 1);
        self.0.extend_from_slice(text.as_bytes());
        self.0.push(0);
    }
}
