//! What a bridge tells of its robot at the end of every step, for the log: how the link and the cameras are.

use lockstep::{Field, Layout};

use crate::contact::Contact;
use crate::tracker::{PoseCounts, seconds};

/// Last part of the topic, `/agent_2/hardware`.
pub const CHANNEL: &str = "hardware";

/// Name and unit of every number, in order. Those without a unit are flags and counts.
const FIELDS: [(&str, &str); 20] = [
    ("connected", ""),
    ("obeys", ""),
    ("age", "s"),
    ("round_trip", "s"),
    ("commands", ""),
    ("acknowledged", ""),
    ("unsent", ""),
    ("late", ""),
    ("reconnections", ""),
    ("watchdog", ""),
    ("poses", ""),
    ("not_seen", ""),
    ("duplicates", ""),
    ("out_of_order", ""),
    ("jumps", ""),
    ("foreign", ""),
    ("missing", ""),
    ("malformed", ""),
    ("too_many", ""),
    ("too_soon", ""),
];

/// The fields of a sample.
pub fn layout() -> Layout {
    Layout::new(FIELDS.map(|(name, unit)| Field::scalar(name, unit)))
}

/// The numbers of a sample, of now.
pub(crate) fn sample(contact: &Contact) -> [f64; FIELDS.len()] {
    let age = contact.tracker.age(seconds(contact.now()), contact.settings.mocap_latency);
    let PoseCounts { taken, not_seen, duplicates, out_of_order, jumps, foreign, missing, malformed, too_many } =
        contact.tracker.counts;
    let counts = &contact.counts;
    let flag = |flag: bool| f64::from(u8::from(flag));
    let count = |count: u64| count as f64;
    [
        flag(contact.is_connected()),
        flag(contact.obeys()),
        age.unwrap_or(0.0),
        contact.round_trip(),
        count(counts.commands),
        count(counts.acknowledged),
        count(counts.unsent),
        count(counts.late),
        count(counts.reconnections),
        count(counts.watchdog),
        count(taken),
        count(not_seen),
        count(duplicates),
        count(out_of_order),
        count(jumps),
        count(foreign),
        count(missing),
        count(malformed),
        count(too_many),
        count(counts.too_soon),
    ]
}
