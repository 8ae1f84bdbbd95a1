//! Differences between the outputs of a participant and the recorded ones.

use lockstep::{ChannelId, Network};

use recording::ulps;

/// The first number that differs.
#[derive(Clone, Debug, PartialEq)]
pub struct FirstDeparture {
    /// Number of the step.
    pub step: u64,
    /// Simulated time of it, s.
    pub time: f64,
    /// The channel.
    pub topic: String,
    /// The number, `input[2]`.
    pub field: String,
    /// What was recorded.
    pub recorded: f64,
    /// What the participant says now.
    pub now: f64,
}

impl FirstDeparture {
    /// What the participant says now, less what was recorded.
    pub fn difference(&self) -> f64 {
        self.now - self.recorded
    }

    /// How many doubles lie between the two, plus one.
    pub fn ulps(&self) -> u64 {
        ulps(self.recorded, self.now)
    }
}

/// How much one field departs in all steps together.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldDeparture {
    /// The channel.
    pub topic: String,
    /// The field, all of its numbers.
    pub field: String,
    /// How many of its numbers differ.
    pub differing: u64,
    /// The largest difference, without its sign.
    pub largest: f64,
    /// The step of the largest difference.
    pub step: u64,
}

/// What one participant published, beside what was recorded of it.
#[derive(Clone, Debug)]
pub struct Departures {
    tolerance: f64,
    dt: f64,
    /// Steps that were compared.
    pub steps: u64,
    /// Samples that were compared: one per step and channel.
    pub samples: u64,
    /// Samples of which a number differs.
    pub differing_samples: u64,
    /// Numbers that were compared.
    pub numbers: u64,
    /// Numbers that differ.
    pub differing: u64,
    /// The first of them.
    pub first: Option<FirstDeparture>,
    /// By channel, by field.
    fields: Vec<Vec<FieldDeparture>>,
    /// By channel, by word: the number of the field.
    field_of: Vec<Vec<usize>>,
}

impl Departures {
    /// Nothing compared yet. Numbers differ if their bits do and they are further apart than `tolerance` times the larger of 1
    /// and the recorded number; `dt` is the step in s.
    pub fn new(network: &Network, tolerance: f64, dt: f64) -> Self {
        let mut fields = Vec::new();
        let mut field_of = Vec::new();
        for channel in &network.channels {
            let layout = channel.layout.fields();
            let none = |name: &String| FieldDeparture {
                topic: channel.topic.clone(),
                field: name.clone(),
                differing: 0,
                largest: 0.0,
                step: 0,
            };
            fields.push(layout.iter().map(|field| none(&field.name)).collect());
            let words = layout.iter().enumerate();
            field_of.push(words.flat_map(|(index, field)| vec![index; field.shape.words()]).collect());
        }
        let (steps, samples, differing_samples, numbers, differing) = (0, 0, 0, 0, 0);
        Self { tolerance, dt, steps, samples, differing_samples, numbers, differing, first: None, fields, field_of }
    }

    /// Compares the samples of the next channel of a step.
    pub fn compare(&mut self, network: &Network, channel: ChannelId, step: u64, recorded: &[f64], now: &[f64]) {
        let before = self.differing;
        for (word, (&old, &new)) in recorded.iter().zip(now).enumerate() {
            self.numbers += 1;
            let allowed = self.tolerance * old.abs().max(1.0);
            // A comparison with NaN is false, so that NaN differs.
            if old.to_bits() == new.to_bits() || (self.tolerance > 0.0 && (new - old).abs() <= allowed) {
                continue;
            }
            self.differing += 1;
            let field = &mut self.fields[channel.0][self.field_of[channel.0][word]];
            field.differing += 1;
            if (new - old).abs() > field.largest || field.differing == 1 {
                (field.largest, field.step) = ((new - old).abs(), step);
            }
            self.first.get_or_insert_with(|| FirstDeparture {
                step,
                time: step as f64 * self.dt,
                topic: network.channels[channel.0].topic.clone(),
                field: network.channels[channel.0].layout.label(word),
                recorded: old,
                now: new,
            });
        }
        self.samples += 1;
        self.differing_samples += u64::from(self.differing > before);
        self.steps = self.steps.max(step + 1);
    }

    /// Whether nothing differs.
    pub fn is_equal(&self) -> bool {
        self.differing == 0
    }

    /// The fields that differ, in order of the channels.
    pub fn fields(&self) -> impl Iterator<Item = &FieldDeparture> {
        self.fields.iter().flatten().filter(|field| field.differing > 0)
    }
}

#[cfg(test)]
mod tests {
    use lockstep::{Channel, Field, Layout};

    use super::*;

    fn compared(tolerance: f64, samples: &[([f64; 3], [f64; 3])]) -> Departures {
        let layout = Layout::new([Field::vector("input", 2, "N"), Field::scalar("flag", "")]);
        let channels = vec![Channel { topic: "/agent_1/command".into(), agent: 1, layout, initial: Vec::new() }];
        let network = Network { channels, nodes: Vec::new() };
        let mut departures = Departures::new(&network, tolerance, 0.5);
        for (step, (recorded, now)) in samples.iter().enumerate() {
            departures.compare(&network, ChannelId(0), step as u64, recorded, now);
        }
        departures
    }

    #[test]
    fn the_first_and_the_largest_are_found() {
        let next = f64::from_bits(2.0_f64.to_bits() + 3);
        let samples = [
            ([1.0, 2.0, 0.0], [1.0, 2.0, 0.0]),
            ([1.0, 2.0, 0.0], [1.0, next, 0.0]),
            ([1.0, 2.0, 5.0], [4.0, 2.0, 5.0]),
        ];
        let found = compared(0.0, &samples);
        let first = found.first.clone().unwrap();
        assert_eq!((first.step, first.time, first.field.as_str(), first.ulps()), (1, 0.5, "input[1]", 3));
        assert_eq!((found.samples, found.differing_samples, found.numbers, found.differing), (3, 2, 9, 2));
        let fields: Vec<_> = found.fields().map(|field| (field.field.as_str(), field.largest, field.step)).collect();
        assert_eq!(fields, [("input", 3.0, 2)]);
    }

    #[test]
    fn a_tolerance_is_relative_above_one() {
        assert!(compared(1e-3, &[([100.0, 0.0, 0.0], [100.09, 9e-4, 0.0])]).is_equal());
        assert!(!compared(1e-3, &[([100.0, 0.0, 0.0], [100.11, 0.0, 0.0])]).is_equal());
        assert!(!compared(1e-3, &[([0.0, 0.0, 0.0], [f64::NAN, 0.0, 0.0])]).is_equal());
        assert!(!compared(0.0, &[([0.0, 0.0, 0.0], [-0.0, 0.0, 0.0])]).is_equal(), "the zeros are two");
    }
}
