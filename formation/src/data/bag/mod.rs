//! Topics of MCAP files: logs of Phalanx, recordings of ROS 2 (rosbag2 with MCAP storage), JSON messages.
//!
//! A column is a topic, `.` and the path of a field that is a number, such as `/cmd_vel.linear.x`, `/agent_1/state.position[0]`
//! or `/path.poses[2].pose.position.x`. Its rows are the messages of the topic. The first column is the time (s) at which they
//! were logged, from the first message of the file on.

mod path;
mod records;
mod ros_message;

#[cfg(test)]
mod tests;

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

use mcap::records::op;

use self::path::Part;
use self::records::{block, number, text};
use self::ros_message::Plan;
use crate::formula::DataError;
use crate::text::{brief, did_you_mean};

/// Most messages of a topic.
const MOST_MESSAGES: usize = 1_000_000;

/// Whether these bytes are an MCAP file.
pub(super) fn is_mcap(bytes: &[u8]) -> bool {
    bytes.starts_with(mcap::MAGIC)
}

/// The times (s) of the messages of a topic, which increase, and the values of a field of it, which are finite. There are at
/// least two. Of messages with equal times, the last counts. A recording that was cut off is read as far as it goes.
///
/// # Errors
/// Says what is wrong with the file, or with the column. Errors do not name the file.
pub(super) fn series(bytes: &[u8], column: &str) -> Result<(Vec<f64>, Vec<f64>), DataError> {
    let mut bag = Bag { column, ..Bag::default() };
    let read = records::for_each(bytes, &mut |opcode, body| bag.record(opcode, body));
    read.map_err(DataError::File)?;
    bag.series()
}

/// What is known of a file so far.
#[derive(Default)]
struct Bag<'c> {
    column: &'c str,
    schemas: BTreeMap<u16, Schema>,
    channels: BTreeMap<u16, Channel>,
    /// The smallest time of a message, ns.
    start: Option<u64>,
    /// The longest topic that stands before a `.` of the column.
    topic: Option<String>,
    /// Messages on it.
    count: usize,
    /// Their times, ns, and values.
    samples: Vec<(u64, f64)>,
    /// The first reason why there are no more samples.
    problem: Option<Problem>,
}

#[derive(PartialEq)]
struct Schema {
    name: String,
    encoding: String,
    text: Vec<u8>,
}

struct Channel {
    schema: u16,
    topic: String,
    encoding: String,
    /// How to read the field, if the column is of this topic.
    getter: Option<Getter>,
}

enum Getter {
    Cdr(Plan),
    Json(Vec<Part>),
}

enum Problem {
    /// Of the topic.
    Topic(DataError),
    /// Of a message with this number and time.
    Message(usize, u64, DataError),
    /// The value at this time.
    NotFinite(u64, f64),
}

impl Bag<'_> {
    /// # Errors
    /// Says what is wrong with the record itself; what is wrong with a message waits for the end of the file.
    fn record(&mut self, opcode: u8, body: &[u8]) -> Result<(), String> {
        match opcode {
            op::SCHEMA => self.schema(body),
            op::CHANNEL => self.channel(body),
            op::MESSAGE => self.message(body),
            _ => Ok(()),
        }
    }

    fn schema(&mut self, mut body: &[u8]) -> Result<(), String> {
        let (id, schema) = read_schema(&mut body).ok_or("the schema is incomplete")?;
        match self.schemas.entry(id) {
            Entry::Occupied(known) if *known.get() != schema => Err(format!("schema {id} is another one than before")),
            Entry::Occupied(_) => Ok(()),
            Entry::Vacant(place) => {
                place.insert(schema);
                Ok(())
            }
        }
    }

    fn channel(&mut self, mut body: &[u8]) -> Result<(), String> {
        let (id, mut channel) = read_channel(&mut body).ok_or("the channel is incomplete")?;
        if let Some(known) = self.channels.get(&id) {
            let [known, found] = [known, &channel].map(|channel| (channel.schema, &channel.topic, &channel.encoding));
            return if known == found { Ok(()) } else { Err(format!("channel {id} is another one than before")) };
        }
        if let Some(path) = self.column.strip_prefix(&channel.topic).and_then(|rest| rest.strip_prefix('.')) {
            let longest = self.topic.as_ref().map_or(0, String::len);
            if self.topic.is_none() || channel.topic.len() > longest {
                self.topic = Some(channel.topic.clone());
                self.channels.values_mut().for_each(|other| other.getter = None);
                (self.count, self.problem) = (0, None);
                self.samples.clear();
            }
            if channel.topic.len() >= longest {
                match path::parse(path).map_err(DataError::Column).and_then(|path| self.getter(&channel, path)) {
                    Ok(getter) => channel.getter = Some(getter),
                    Err(error) => _ = self.problem.get_or_insert(Problem::Topic(error)),
                }
            }
        }
        self.channels.insert(id, channel);
        Ok(())
    }

    /// How to read a field of a channel.
    fn getter(&self, channel: &Channel, path: Vec<Part>) -> Result<Getter, DataError> {
        let topic = brief(&channel.topic);
        let found = |what: &str, encoding: &str, expected: &str| {
            Err(DataError::Column(format!("`{topic}` has {what} `{}`, expected {expected}", brief(encoding))))
        };
        match channel.encoding.as_str() {
            "json" => Ok(Getter::Json(path)),
            "cdr" => match self.schemas.get(&channel.schema) {
                Some(schema) if schema.encoding == "ros2msg" => {
                    let text = String::from_utf8_lossy(&schema.text);
                    Ok(Getter::Cdr(Plan::new(&channel.topic, &schema.name, &text, &path)?))
                }
                Some(schema) => found("a schema in the encoding", &schema.encoding, "`ros2msg`"),
                None => {
                    Err(DataError::Column(format!("`{topic}` has no schema, expected one in the encoding `ros2msg`")))
                }
            },
            other => found("messages in the encoding", other, "`cdr` (ROS 2) or `json`"),
        }
    }

    fn message(&mut self, mut body: &[u8]) -> Result<(), String> {
        let (id, time) = read_message(&mut body).ok_or("the message is incomplete")?;
        let channel = self.channels.get(&id).ok_or_else(|| format!("the message is of an unknown channel, {id}"))?;
        self.start = Some(self.start.map_or(time, |start| start.min(time)));
        let Some(getter) = &channel.getter else { return Ok(()) };
        self.count += 1;
        if self.problem.is_some() {
            return Ok(());
        }
        let value = match getter {
            Getter::Cdr(plan) => plan.number(body),
            Getter::Json(path) => path::json_number(body, &channel.topic, path),
        };
        match value {
            _ if self.count > MOST_MESSAGES => {
                let topic = brief(&channel.topic);
                let message = format!("expected at most {MOST_MESSAGES} messages on `{topic}`, found more");
                self.problem = Some(Problem::Topic(DataError::File(message)));
            }
            Ok(value) if value.is_finite() => self.samples.push((time, value)),
            Ok(value) => self.problem = Some(Problem::NotFinite(time, value)),
            Err(error) => self.problem = Some(Problem::Message(self.count, time, error)),
        }
        Ok(())
    }

    /// The samples, after the last record.
    fn series(mut self) -> Result<(Vec<f64>, Vec<f64>), DataError> {
        let start = self.start.unwrap_or(0);
        let seconds = |time: u64| (time - start) as f64 / 1e9;
        let Some(topic) = &self.topic else { return Err(self.no_topic()) };
        let topic = brief(topic);
        match self.problem {
            None => {}
            Some(Problem::Topic(error)) => return Err(error),
            Some(Problem::Message(number, time, error)) => {
                let named = |what| format!("message {number} of `{topic}`, at {} s: {what}", seconds(time));
                return Err(error.map(named));
            }
            Some(Problem::NotFinite(time, value)) => {
                let (column, time) = (brief(self.column), seconds(time));
                let message = format!("`{column}`: expected a finite number at {time} s, found {value}");
                return Err(DataError::File(message));
            }
        }
        // A stable order: of equal times, the last stays the last.
        self.samples.sort_by_key(|(time, _)| *time);
        let (mut times, mut values) = (Vec::with_capacity(self.samples.len()), Vec::with_capacity(self.samples.len()));
        for (time, value) in self.samples {
            let time = seconds(time);
            if times.last() == Some(&time) {
                values.pop();
            } else {
                times.push(time);
            }
            values.push(value);
        }
        match (times.len(), self.count) {
            (2.., _) => Ok((times, values)),
            (_, count @ 0..2) => {
                Err(DataError::Column(format!("expected at least 2 messages on `{topic}`, found {count}")))
            }
            (_, count) => {
                let message =
                    format!("expected at least 2 messages on `{topic}` at different times, found {count} at one");
                Err(DataError::Column(message))
            }
        }
    }

    /// Why the column has no topic.
    fn no_topic(&self) -> DataError {
        let column = brief(self.column);
        if let Some(channel) = self.channels.values().find(|channel| channel.topic == self.column) {
            let general = || DataError::Column(format!("expected a field behind the topic, such as `{column}.x`"));
            return self.getter(channel, Vec::new()).err().unwrap_or_else(general);
        }
        let topics: BTreeSet<&str> = self.channels.values().map(|channel| channel.topic.as_str()).collect();
        if topics.is_empty() {
            return DataError::Column(format!("no topic stands before a `.` of `{column}`: the file has none"));
        }
        let hint = did_you_mean(self.column.split('.').next().unwrap_or_default(), topics.iter().copied());
        let all = brief(&topics.into_iter().collect::<Vec<_>>().join(", "));
        DataError::Column(format!("no topic stands before a `.` of `{column}`, expected one of {all}{hint}"))
    }
}

fn read_schema(body: &mut &[u8]) -> Option<(u16, Schema)> {
    let id = u16::from_le_bytes(number(body)?);
    Some((id, Schema { name: text(body)?, encoding: text(body)?, text: block(body)?.to_vec() }))
}

fn read_channel(body: &mut &[u8]) -> Option<(u16, Channel)> {
    let [id, schema] = [number(body)?, number(body)?].map(u16::from_le_bytes);
    Some((id, Channel { schema, topic: text(body)?, encoding: text(body)?, getter: None }))
}

/// Channel and time of a message; its data remain.
fn read_message(body: &mut &[u8]) -> Option<(u16, u64)> {
    let channel = u16::from_le_bytes(number(body)?);
    let _sequence: [u8; 4] = number(body)?;
    let logged = u64::from_le_bytes(number(body)?);
    let _published: [u8; 8] = number(body)?;
    Some((channel, logged))
}
