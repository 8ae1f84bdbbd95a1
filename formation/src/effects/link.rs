//! A link: what one agent receives of another.

use super::limits::quantised;
use super::{Delay, Loss, Schedule, Trigger};
use crate::math::RandomStream;

/// The fields that follow the numbers of a message in what is received, with their units: the age of the numbers, the number of the
/// message that they came with (from 1; 0 before the first has arrived), and how many messages were sent and lost so far.
pub const LINK_FIELDS: [(&str, &str); 4] =
    [("link_age", "s"), ("link_sequence", "1"), ("link_sent", "1"), ("link_lost", "1")];

/// What the receiver sees when a message does not arrive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Missing {
    /// The numbers that arrived last.
    #[default]
    Hold,
    /// Zeros, from when the message would have arrived until the next one arrives.
    Zero,
    /// The straight line through the last two messages, at the present time; this also makes up for the delay.
    Linear,
}

/// The parameters of a link.
#[derive(Clone, Debug)]
pub struct LinkModel {
    /// When there is an opportunity to send.
    pub schedule: Schedule,
    /// Sends only if it holds, and the first message.
    pub trigger: Option<Trigger>,
    /// The time until the next message, s, as a formula over the fields of [`LinkModel::trigger`]'s kind: self-triggered sending.
    pub interval: Option<Trigger>,
    /// How long a message is on its way.
    pub delay: Option<Delay>,
    /// Whether a message may overtake an earlier one. The one that comes behind a newer one is not taken.
    pub reordering: bool,
    /// Which messages are lost.
    pub loss: Option<Loss>,
    /// Times `[from, until)`, s, in which all messages are lost.
    pub outages: Vec<(f64, f64)>,
    /// Distance beyond which all messages are lost, m.
    pub range: Option<f64>,
    /// What is seen when a message does not arrive.
    pub missing: Missing,
    /// Standard deviation of the noise on each number; empty if there is none.
    pub noise: Vec<f64>,
    /// Step of the quantiser of each number, 0 if it has none; empty if none has.
    pub quantum: Vec<f64>,
    /// Bits of a message.
    pub bits: f64,
    /// Bits per second that a sender may send; messages wait for each other.
    pub bandwidth: Option<f64>,
    /// Most messages on their way; a further one is lost.
    pub limit: usize,
}

/// The instant of an update.
#[derive(Clone, Copy, Debug)]
pub struct Instant {
    /// Number of the step.
    pub step: u64,
    /// Its time, s.
    pub t: f64,
    /// The distance between sender and receiver, m; NaN if it is not known.
    pub distance: f64,
}

/// A message on its way.
#[derive(Clone, Copy, Debug, Default)]
struct Message {
    /// Number of the message, from 1.
    sequence: u64,
    /// When it was sent, s.
    sent: f64,
    /// The step at which it arrives.
    arrival: u64,
    /// The receiver finds that it is missing.
    is_lost: bool,
    has_arrived: bool,
}

/// A link from one agent to another, for one kind of messages.
#[derive(Clone, Debug)]
pub struct Link {
    model: LinkModel,
    stream: RandomStream,
    /// The step, s.
    dt: f64,
    /// Numbers of a message.
    width: usize,
    /// The messages on their way, a ring, and their numbers.
    ring: Vec<Message>,
    numbers: Vec<f64>,
    first: usize,
    length: usize,
    /// The message that arrived last and the one before, and their numbers.
    last: Message,
    before: Message,
    held: Vec<f64>,
    earlier: Vec<f64>,
    /// Whether the message that should have arrived last did not.
    is_missing: bool,
    started: bool,
    sent: u64,
    lost: u64,
    is_bad: bool,
    latest_arrival: u64,
    next_by_interval: f64,
    /// The steps of a delay that is the same for all messages, as long as nothing else adds to it.
    fixed_steps: Option<u64>,
}

/// The first place of the noise in the [`RandomStream`].
const NOISE: u32 = 1024;
/// How close to a step, in steps, an arrival counts as this step.
const TOLERANCE: f64 = 1e-9;

impl Link {
    /// A link for messages of `width` numbers in a run with steps of `dt` seconds.
    pub fn new(model: LinkModel, width: usize, dt: f64, stream: RandomStream) -> Self {
        let limit = model.limit.max(1);
        let fixed_steps = match (&model.delay, model.bandwidth) {
            (None, None) => Some(0),
            (Some(Delay::Fixed(delay)), None) => Some(steps_of(*delay, dt)),
            _ => None,
        };
        Self {
            fixed_steps,
            ring: vec![Message::default(); limit],
            numbers: vec![0.0; limit * width],
            held: vec![0.0; width],
            earlier: vec![0.0; width],
            first: 0,
            length: 0,
            last: Message::default(),
            before: Message::default(),
            is_missing: false,
            started: false,
            sent: 0,
            lost: 0,
            is_bad: false,
            latest_arrival: 0,
            next_by_interval: f64::NEG_INFINITY,
            model,
            stream,
            dt,
            width,
        }
    }

    /// What the receiver has before the first message: by default zeros.
    pub fn begin(&mut self, numbers: &[f64]) {
        self.held.copy_from_slice(numbers);
        self.started = true;
    }

    /// Whether [`Link::begin`] was called.
    pub fn has_begun(&self) -> bool {
        self.started
    }

    /// Takes what the sender has at this instant, to be called once at every step. `others` are signals of the sender that only its
    /// trigger reads. `busy` is the time, s, until which the sender's channel is taken by earlier messages.
    pub fn update(&mut self, now: &Instant, source: &[f64], others: &[f64], busy: &mut f64) {
        if self.wants_to_send(now, source, others) {
            self.send(now, source, busy);
        }
        self.receive(now.step);
    }

    fn wants_to_send(&mut self, now: &Instant, source: &[f64], others: &[f64]) -> bool {
        if !self.model.schedule.is_due(now.t) || now.t < self.next_by_interval - TOLERANCE * self.dt {
            return false;
        }
        let sends = match &mut self.model.trigger {
            Some(trigger) => trigger.value(now.t, source, others) != 0.0 || self.sent == 0,
            None => true,
        };
        if !sends {
            return false;
        }
        if let Some(trigger) = &mut self.model.trigger {
            trigger.sent(now.t, source);
        }
        if let Some(interval) = &mut self.model.interval {
            interval.sent(now.t, source);
            self.next_by_interval = now.t + interval.value(now.t, source, others).max(0.0);
        }
        true
    }

    fn send(&mut self, now: &Instant, source: &[f64], busy: &mut f64) {
        let (model, stream, count) = (&self.model, &self.stream, self.sent);
        self.sent += 1;
        let slots = [now.t, now.distance];
        let mut is_lost = model.outages.iter().any(|(from, until)| (*from..*until).contains(&now.t));
        is_lost |= model.range.is_some_and(|range| now.distance > range);
        if let Some(loss) = &model.loss {
            // Always drawn, so that one cause of loss does not move the numbers of another.
            is_lost |= loss.draw(stream, now.step, count, &slots, &mut self.is_bad);
        }
        let steps = self.fixed_steps.unwrap_or_else(|| {
            let mut delay = model.delay.as_ref().map_or(0.0, |delay| delay.draw(stream, now.step, count, &slots));
            if let Some(bandwidth) = model.bandwidth {
                *busy = busy.max(now.t) + model.bits / bandwidth;
                delay += *busy - now.t;
            }
            steps_of(delay, self.dt)
        });
        let mut arrival = now.step + steps;
        if !model.reordering {
            arrival = arrival.max(self.latest_arrival);
            self.latest_arrival = arrival;
        }
        if self.length == self.ring.len() {
            self.lost += 1;
            return;
        }
        self.lost += u64::from(is_lost);
        let place = self.place(self.length);
        self.length += 1;
        self.ring[place] = Message { sequence: self.sent, sent: now.t, arrival, is_lost, has_arrived: false };
        if is_lost {
            return;
        }
        let numbers = &mut self.numbers[place * self.width..(place + 1) * self.width];
        numbers.copy_from_slice(source);
        for (place, (number, deviation)) in (NOISE..).zip(numbers.iter_mut().zip(&model.noise)) {
            if *deviation > 0.0 {
                *number += deviation * stream.normal(now.step, place);
            }
        }
        for (number, quantum) in numbers.iter_mut().zip(&model.quantum) {
            *number = quantised(*number, *quantum);
        }
    }

    /// Where the message is that so many others precede on their way. A division would take longer than all the rest.
    fn place(&self, at: usize) -> usize {
        let place = self.first + at;
        if place < self.ring.len() { place } else { place - self.ring.len() }
    }

    fn receive(&mut self, step: u64) {
        for at in 0..self.length {
            let place = self.place(at);
            let message = self.ring[place];
            if message.arrival > step {
                if self.model.reordering {
                    continue;
                }
                break;
            }
            if message.has_arrived {
                continue;
            }
            self.ring[place].has_arrived = true;
            if message.sequence < self.last.sequence {
                continue;
            }
            self.is_missing = message.is_lost;
            if !message.is_lost {
                self.before = std::mem::replace(&mut self.last, message);
                std::mem::swap(&mut self.held, &mut self.earlier);
                self.held.copy_from_slice(&self.numbers[place * self.width..(place + 1) * self.width]);
            }
        }
        while self.length > 0 && self.ring[self.first].has_arrived {
            self.first = self.place(1);
            self.length -= 1;
        }
    }

    /// Writes what the receiver has at time `t`, s: the numbers, and behind them those of [`LINK_FIELDS`].
    pub fn write(&self, t: f64, out: &mut [f64]) {
        let (numbers, about) = out.split_at_mut(self.width);
        match self.model.missing {
            Missing::Zero if self.is_missing => numbers.fill(0.0),
            Missing::Linear if self.before.sequence > 0 => {
                let ahead = (t - self.last.sent) / (self.last.sent - self.before.sent);
                for ((number, held), earlier) in numbers.iter_mut().zip(&self.held).zip(&self.earlier) {
                    *number = held + (held - earlier) * ahead;
                }
            }
            _ => numbers.copy_from_slice(&self.held),
        }
        let values = [t - self.last.sent, self.last.sequence as f64, self.sent as f64, self.lost as f64];
        about.copy_from_slice(&values);
    }
}

/// The smallest number of steps that are at least a delay, s.
fn steps_of(delay: f64, dt: f64) -> u64 {
    (delay / dt - TOLERANCE).ceil().clamp(0.0, 1e15) as u64
}

impl LinkModel {
    /// A link that does nothing.
    pub fn ideal(dt: f64) -> Self {
        Self {
            schedule: Schedule::new(None, 0.0, dt),
            trigger: None,
            interval: None,
            delay: None,
            reordering: false,
            loss: None,
            outages: Vec::new(),
            range: None,
            missing: Missing::Hold,
            noise: Vec::new(),
            quantum: Vec::new(),
            bits: 0.0,
            bandwidth: None,
            limit: 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f64 = 0.1;

    /// What is received, with the numbers of [`LINK_FIELDS`], of a sender whose number is that of the step, plus 1.
    fn received(model: LinkModel, steps: u64) -> Vec<[f64; 5]> {
        let mut link = Link::new(model, 1, DT, RandomStream::new(1, "a link"));
        let mut busy = 0.0;
        (0..steps)
            .map(|step| {
                let now = Instant { step, t: DT * step as f64, distance: 0.0 };
                link.update(&now, &[step as f64 + 1.0], &[], &mut busy);
                let mut out = [0.0; 5];
                link.write(now.t, &mut out);
                out
            })
            .collect()
    }

    fn numbers(model: LinkModel, steps: u64) -> Vec<f64> {
        received(model, steps).iter().map(|row| row[0]).collect()
    }

    fn ideal() -> LinkModel {
        LinkModel::ideal(DT)
    }

    #[test]
    fn an_ideal_link_changes_nothing() {
        assert_eq!(numbers(ideal(), 3), [1.0, 2.0, 3.0]);
    }

    #[test]
    fn a_delay_is_rounded_up_to_steps() {
        for (delay, steps) in [(0.2, 2), (0.3, 3), (0.21, 3), (0.0, 0)] {
            let model = LinkModel { delay: Some(Delay::Fixed(delay)), limit: 8, ..ideal() };
            let rows = received(model, 8);
            let expected = |step: usize| if step < steps { 0.0 } else { (step - steps) as f64 + 1.0 };
            for (step, row) in rows.iter().enumerate() {
                assert_eq!(row[0], expected(step), "{delay}");
            }
            // Age, number, sent, lost.
            let [_, age, sequence, sent, lost] = rows[7];
            assert!((age - steps as f64 * DT).abs() < 1e-12, "{age}");
            assert_eq!([sequence, sent, lost], [8.0 - steps as f64, 8.0, 0.0]);
        }
    }

    #[test]
    fn messages_overtake_only_if_they_may() {
        let delays = Delay::Trace(vec![0.3, 0.0, 0.0, 0.0]);
        let model = |reordering| LinkModel { delay: Some(delays.clone()), limit: 8, reordering, ..ideal() };
        assert_eq!(numbers(model(false), 6), [0.0, 0.0, 0.0, 4.0, 4.0, 4.0]);
        assert_eq!(numbers(model(true), 6), [0.0, 2.0, 3.0, 4.0, 4.0, 6.0]);
        // The first message arrives alone, behind the third, and is not taken.
        let delays = Delay::Trace(vec![0.3, 0.0, 0.0, 0.3]);
        let model = |reordering| LinkModel { delay: Some(delays.clone()), limit: 8, reordering, ..ideal() };
        assert_eq!(numbers(model(false), 6), [0.0, 0.0, 0.0, 3.0, 3.0, 3.0]);
        assert_eq!(numbers(model(true), 6), [0.0, 2.0, 3.0, 3.0, 3.0, 6.0]);
    }

    #[test]
    fn what_is_seen_without_a_message() {
        let model = |missing| LinkModel { loss: Some(Loss::Trace(vec![0.0, 0.0, 1.0, 1.0])), missing, ..ideal() };
        assert_eq!(numbers(model(Missing::Hold), 6), [1.0, 2.0, 2.0, 2.0, 5.0, 6.0]);
        assert_eq!(numbers(model(Missing::Zero), 6), [1.0, 2.0, 0.0, 0.0, 5.0, 6.0]);
        let linear = numbers(model(Missing::Linear), 6);
        assert!(linear.iter().zip(1..).all(|(found, number)| (found - f64::from(number)).abs() < 1e-12), "{linear:?}");
        assert_eq!(received(model(Missing::Hold), 6)[5][3..], [6.0, 2.0]);
    }

    #[test]
    fn outages_ranges_rates_and_bandwidth() {
        let model = LinkModel { outages: vec![(0.1, 0.3)], ..ideal() };
        assert_eq!(numbers(model, 5), [1.0, 1.0, 1.0, 4.0, 5.0]);
        let model = LinkModel { schedule: Schedule::new(Some(0.2), 0.1, DT), ..ideal() };
        assert_eq!(numbers(model, 6), [0.0, 2.0, 2.0, 4.0, 4.0, 6.0]);
        // Each message takes 0.2 s, so that the queue grows; it has two places.
        let model = LinkModel { bits: 20.0, bandwidth: Some(100.0), limit: 2, ..ideal() };
        let rows = received(model, 8);
        assert_eq!(rows.iter().map(|row| row[0]).collect::<Vec<_>>()[..5], [0.0, 0.0, 1.0, 1.0, 2.0]);
        assert!(rows[7][4] > 0.0);
        let mut link = Link::new(LinkModel { range: Some(5.0), ..ideal() }, 1, DT, RandomStream::new(1, "a"));
        for (step, distance, expected) in [(0, 4.0, 1.0), (1, 6.0, 1.0), (2, 5.0, 3.0)] {
            let now = Instant { step, t: DT * step as f64, distance };
            link.update(&now, &[step as f64 + 1.0], &[], &mut 0.0);
            let mut out = [0.0; 5];
            link.write(now.t, &mut out);
            assert_eq!(out[0], expected);
        }
    }

    #[test]
    fn noise_and_quantiser_act_on_each_number_by_itself() {
        let model = LinkModel { noise: vec![0.5, 0.0], quantum: vec![0.0, 0.25], ..ideal() };
        let mut link = Link::new(model, 2, DT, RandomStream::new(9, "a link"));
        let (mut sum, mut square) = (0.0, 0.0);
        for step in 0..10_000 {
            link.update(&Instant { step, t: 0.0, distance: 0.0 }, &[1.0, 0.6], &[], &mut 0.0);
            let mut out = [0.0; 6];
            link.write(0.0, &mut out);
            assert_eq!(out[1], 0.5);
            (sum, square) = (sum + out[0] - 1.0, square + (out[0] - 1.0).powi(2));
        }
        assert!((sum / 1e4).abs() < 0.02 && ((square / 1e4).sqrt() - 0.5).abs() < 0.02);
    }
}
