//! From the fields of a link to its model.

use lockstep::Layout;

use super::table::{DelayTable, LinkTable, LossTable, MissingName};
use super::{Links, SECTION};
use crate::config::{FormulaText, Node, Problem, Problems, did_you_mean, read};
use crate::data::DataCurves;
use crate::effects::{Delay, LinkModel, Loss, Missing, Schedule, Trigger, TriggerFields};
use crate::formula::{Cursor, Curve, DataCall, DataError, Expression, Formula, FormulaError, Operand, Operands};
use crate::scenario::Context;

/// Most messages that may be on their way on a link.
const MOST_ON_THE_WAY: f64 = 100_000.0;
/// The same where a delay has no bound, if the scenario says nothing.
const USUAL_LIMIT: usize = 1000;

/// A link for the messages of one kind.
pub(crate) struct LinkPlace<'a> {
    /// The agents by their place, from 0.
    pub(crate) sender: usize,
    pub(crate) receiver: usize,
    /// The message.
    pub(crate) layout: &'a Layout,
    /// Signals of the sender that only its trigger reads, such as `command.input`, with their lengths.
    pub(crate) others: &'a [(String, usize)],
}

/// The model of a link, and what it needs.
#[derive(Clone, Debug)]
pub(crate) struct CompiledLink {
    pub(crate) model: LinkModel,
    /// Whether it depends on the distance of both agents.
    pub(crate) by_distance: bool,
    /// Whether both directions have the same random numbers.
    pub(crate) is_symmetric: bool,
}

impl Links {
    /// The model of a link.
    ///
    /// # Errors
    /// Everything that is wrong with its parameters.
    pub(crate) fn model(&self, context: &Context, link: &LinkPlace) -> Result<CompiledLink, Vec<Problem>> {
        let id = |agent: usize| context.agents[agent].id;
        let (sender, receiver) = (id(link.sender), id(link.receiver));
        let node = self.table(sender, receiver).map_err(|problem| vec![problem])?;
        let mut problems = Problems::default();
        let model = Compiler { context, link, node: &node, problems: &mut problems }.compile();
        match model {
            Some(mut link) if problems.is_empty() => {
                link.model.outages = self.outages(sender, receiver);
                Ok(link)
            }
            _ => Err(problems.into_vec()),
        }
    }
}

struct Compiler<'a> {
    context: &'a Context,
    link: &'a LinkPlace<'a>,
    node: &'a Node,
    problems: &'a mut Problems,
}

impl Compiler<'_> {
    fn compile(&mut self) -> Option<CompiledLink> {
        let table = read::<LinkTable>(self.node, SECTION, self.problems)?;
        let dt = self.context.timing.dt;
        self.demand("rate_hz", table.rate_hz, "a rate > 0 Hz", |rate| rate > 0.0);
        self.demand("phase", Some(table.phase), "a time >= 0 s", |phase| phase >= 0.0);
        self.demand("range", table.range, "a distance > 0 m", |range| range > 0.0);
        self.demand("bandwidth", table.bandwidth, "a rate > 0 bit/s", |bandwidth| bandwidth > 0.0);
        self.demand("bits", Some(table.bits), "a number of bits > 0", |bits| bits > 0.0);
        let delay = self.delay();
        let loss = self.loss();
        let fields = self.fields();
        let trigger = table.trigger.as_ref().and_then(|text| self.trigger("trigger", text, &fields));
        let interval = table.interval.as_ref().and_then(|text| self.trigger("interval", text, &fields));
        let (noise, quantum) = (self.by_signal("noise"), self.by_signal("quantum"));
        let limit = self.limit(&table, delay.as_ref());
        let depends = |formula: &Formula| formula.evaluate(&[0.0, f64::NAN]).is_nan();
        let by_distance = table.range.is_some()
            || matches!(&delay, Some(Delay::Formula(formula)) if depends(formula))
            || matches!(&loss, Some(Loss::Formula(formula)) if depends(formula));
        let missing = match table.missing {
            MissingName::Hold => Missing::Hold,
            MissingName::Zero => Missing::Zero,
            MissingName::Linear => Missing::Linear,
        };
        let model = LinkModel {
            schedule: Schedule::new(table.rate_hz.map(|rate| 1.0 / rate), table.phase, dt),
            trigger,
            interval,
            delay,
            reordering: table.reordering,
            loss,
            outages: Vec::new(),
            range: table.range,
            missing,
            noise,
            quantum,
            bits: table.bits * self.link.layout.words() as f64,
            bandwidth: table.bandwidth,
            limit,
        };
        Some(CompiledLink { model, by_distance, is_symmetric: table.symmetric })
    }

    fn report(&mut self, field: &str, message: impl Into<String>) {
        let mut found = Problems::default();
        found.at(self.node, field, message);
        let placed =
            found.into_vec().into_iter().map(|problem| Problem { path: format!("{SECTION}.{field}"), ..problem });
        self.problems.extend(placed);
    }

    fn demand(&mut self, field: &str, value: Option<f64>, expected: &str, is_right: impl Fn(f64) -> bool) {
        if let Some(value) = value.filter(|value| !(value.is_finite() && is_right(*value))) {
            self.report(field, format!("expected {expected}, found {value}"));
        }
    }

    /// How many messages may be on their way.
    fn limit(&mut self, table: &LinkTable, delay: Option<&Delay>) -> usize {
        if let Some(limit) = table.limit {
            self.demand("limit", Some(limit as f64), "1 to 100000 messages", |limit| {
                (1.0..=MOST_ON_THE_WAY).contains(&limit)
            });
            return limit;
        }
        let dt = self.context.timing.dt;
        let period = table.rate_hz.map_or(dt, |rate| (1.0 / rate).max(dt));
        match delay.map_or(Some(0.0), Delay::longest) {
            _ if table.bandwidth.is_some() => USUAL_LIMIT,
            None => USUAL_LIMIT,
            Some(longest) => {
                let messages = (longest / period).ceil() + 2.0;
                if messages > MOST_ON_THE_WAY {
                    let most = MOST_ON_THE_WAY * period;
                    self.report(
                        "delay",
                        format!("expected at most {most} s, 100000 messages on their way, found {longest} s"),
                    );
                    return 1;
                }
                messages as usize
            }
        }
    }

    fn delay(&mut self) -> Option<Delay> {
        const FIELD: &str = "delay";
        let node = self.node.at(FIELD)?;
        if node.as_table().is_none() {
            let formula = self.formula(FIELD, "a time >= 0 s, a formula, or a distribution")?;
            return Some(match formula {
                Amount::Number(delay) => {
                    self.demand(FIELD, Some(delay), "a time >= 0 s", |delay| delay >= 0.0);
                    Delay::Fixed(delay)
                }
                Amount::Formula(formula) => Delay::Formula(formula),
            });
        }
        let table = read::<DelayTable>(node, &format!("{SECTION}.{FIELD}"), self.problems)?;
        let mut demand = |field: &str, value: f64, expected: &str, is_right: bool| {
            if !(value.is_finite() && is_right) {
                self.report(&format!("{FIELD}.{field}"), format!("expected {expected}, found {value}"));
            }
        };
        match table {
            DelayTable::Uniform { low, high } => {
                demand("low", low, "a time >= 0 s", low >= 0.0);
                demand("high", high, &format!("a time >= {low} s"), high >= low);
                Some(Delay::Uniform { low, high })
            }
            DelayTable::Normal { mean, standard_deviation, low, high } => {
                let high = high.unwrap_or(mean + 6.0 * standard_deviation);
                demand("mean", mean, "a time >= 0 s", mean >= 0.0);
                demand("standard_deviation", standard_deviation, "a time >= 0 s", standard_deviation >= 0.0);
                demand("low", low, "a time >= 0 s", low >= 0.0);
                demand("high", high, &format!("a time >= {low} s"), high >= low);
                Some(Delay::Normal { mean, deviation: standard_deviation, low, high })
            }
            DelayTable::Gamma { shape, scale, shift } => {
                demand("shape", shape, "a number > 0", shape > 0.0);
                demand("scale", scale, "a time >= 0 s", scale >= 0.0);
                demand("shift", shift, "a time >= 0 s", shift >= 0.0);
                Some(Delay::Gamma { shape, scale, shift })
            }
            DelayTable::Trace { file, column, factor } => {
                demand("factor", factor, "a factor > 0", factor > 0.0);
                let delays = self.column(FIELD, &file, &column)?;
                let delays: Vec<f64> = delays.into_iter().map(|delay| delay * factor).collect();
                if let Some(delay) = delays.iter().find(|delay| **delay < 0.0) {
                    self.report(&format!("{FIELD}.column"), format!("expected times >= 0 s, found {delay}"));
                }
                Some(Delay::Trace(delays))
            }
        }
    }

    fn loss(&mut self) -> Option<Loss> {
        const FIELD: &str = "loss";
        let node = self.node.at(FIELD)?;
        let is_probability = |number: f64| (0.0..=1.0).contains(&number);
        if node.as_table().is_none() {
            let formula = self.formula(FIELD, "a probability from 0 to 1, a formula, or a model")?;
            return Some(match formula {
                Amount::Number(loss) => {
                    self.demand(FIELD, Some(loss), "a probability from 0 to 1", is_probability);
                    Loss::Probability(loss)
                }
                Amount::Formula(formula) => Loss::Formula(formula),
            });
        }
        match read::<LossTable>(node, &format!("{SECTION}.{FIELD}"), self.problems)? {
            LossTable::GilbertElliott { p, r, good, bad } => {
                for (name, value) in [("p", p), ("r", r), ("good", good), ("bad", bad)] {
                    self.demand(&format!("{FIELD}.{name}"), Some(value), "a probability from 0 to 1", is_probability);
                }
                Some(Loss::Bursts { p, r, good, bad })
            }
            LossTable::Trace { file, column } => {
                let lost = self.column(FIELD, &file, &column)?;
                if let Some(number) = lost.iter().find(|number| !is_probability(**number)) {
                    self.report(&format!("{FIELD}.column"), format!("expected 0 or 1, found {number}"));
                }
                Some(Loss::Trace(lost))
            }
        }
    }

    fn column(&mut self, field: &str, file: &str, column: &str) -> Option<Vec<f64>> {
        match self.context.curves.column(file, column) {
            Ok(column) => Some(column),
            Err(DataError::File(message)) => {
                self.report(&format!("{field}.file"), message);
                None
            }
            Err(DataError::Column(message)) => {
                self.report(&format!("{field}.column"), message);
                None
            }
        }
    }

    /// A number, or a formula over the slots t and distance.
    fn formula(&mut self, field: &str, expected: &str) -> Option<Amount> {
        let node = self.node.at(field)?;
        if let Some(number) = node.as_f64() {
            return Some(Amount::Number(number));
        }
        let Some(text) = node.as_str() else {
            self.report(field, format!("expected {expected}, found {}", node.describe()));
            return None;
        };
        let compiled = Expression::parse_with(text, &mut Files(&self.context.curves)).and_then(|expression| {
            expression.compile(|name| match name {
                "t" => Some(Operand::Slot(0)),
                "distance" => Some(Operand::Slot(1)),
                _ => self.constant(name).map(Operand::Constant),
            })
        });
        match compiled {
            Ok(formula) => {
                let value = formula.evaluate(&[0.0, 1.0]);
                if !value.is_finite() {
                    self.report(field, format!("its value at t = 0 and distance = 1 is {value}"));
                }
                Some(Amount::Formula(formula))
            }
            Err(error) => {
                self.wrong(field, text, error, &["t", "distance"]);
                None
            }
        }
    }

    fn wrong(&mut self, field: &str, text: &str, error: FormulaError, names: &[&str]) {
        let parameters = self.context.parameters.keys().map(String::as_str);
        let names = names.iter().copied().chain(["i", "j", "N", "dt", "pi", "seed"]).chain(parameters);
        self.report(field, error.with_hint(text, names).within(text));
    }

    fn constant(&self, name: &str) -> Option<f64> {
        let agents = &self.context.agents;
        match name {
            "j" => Some(f64::from(agents[self.link.sender].id)),
            "dt" => Some(self.context.timing.dt),
            _ => self.context.constant(&agents[self.link.receiver], name),
        }
    }

    fn fields(&self) -> TriggerFields {
        let layout = self.link.layout;
        let message = layout.fields().iter().filter_map(|field| {
            let (first, length) = layout.find(&field.name)?;
            Some((field.name.clone(), first, length))
        });
        TriggerFields { message: message.collect(), others: self.link.others.to_vec() }
    }

    fn trigger(&mut self, field: &str, text: &FormulaText, fields: &TriggerFields) -> Option<Trigger> {
        let read = if field == "trigger" { Trigger::condition } else { Trigger::formula };
        let trigger = read(&text.0, fields, &|name| self.constant(name));
        match trigger {
            Ok(trigger) => Some(trigger),
            Err(error) => {
                let names: Vec<&str> = fields.message.iter().map(|(name, ..)| name.as_str()).collect();
                let names: Vec<&str> = names.into_iter().chain(["t", "since", "norm", "sent"]).collect();
                self.wrong(field, &text.0, error, &names);
                None
            }
        }
    }

    /// A number for each word of the message, given as one for all or by signal; empty if there is none.
    fn by_signal(&mut self, field: &str) -> Vec<f64> {
        let Some(node) = self.node.at(field) else { return Vec::new() };
        let layout = self.link.layout;
        if let Some(number) = node.as_f64() {
            self.demand(field, Some(number), "a number >= 0", |number| number >= 0.0);
            return vec![number; layout.words()];
        }
        let Some(table) = node.as_table() else {
            self.report(
                field,
                format!("expected a number >= 0, or a table of numbers by signal, found {}", node.describe()),
            );
            return Vec::new();
        };
        let mut numbers = vec![0.0; layout.words()];
        let mut is_of_message = false;
        for (signal, node) in table.iter() {
            let path = format!("{field}.{signal}");
            let Some(number) = node.as_f64() else {
                self.report(&path, format!("expected a number >= 0, found {}", node.describe()));
                continue;
            };
            self.demand(&path, Some(number), "a number >= 0", |number| number >= 0.0);
            // Other kinds of messages have other signals.
            if let Some((first, length)) = layout.find(signal) {
                numbers[first..first + length].fill(number);
                is_of_message = true;
            } else if !self.is_known(signal) {
                let names = layout.fields().iter().map(|field| field.name.as_str());
                let hint = did_you_mean(signal, names.clone());
                let known = names.collect::<Vec<_>>().join(", ");
                self.report(&path, format!("no signal is called `{signal}`, expected one of {known}{hint}"));
            }
        }
        if is_of_message { numbers } else { Vec::new() }
    }

    /// Whether another kind of message may have a signal of this name.
    fn is_known(&self, signal: &str) -> bool {
        self.link.others.iter().any(|(name, _)| name.ends_with(&format!(".{signal}")))
    }
}

/// A number, or a formula.
enum Amount {
    Number(f64),
    Formula(Formula),
}

/// Formulas may read data files.
struct Files<'a>(&'a DataCurves);

impl Operands for Files<'_> {
    fn read(&mut self, _: &str, _: usize, _: &mut Cursor) -> Result<Option<usize>, FormulaError> {
        Ok(None)
    }

    fn curve(&mut self, call: &DataCall) -> Result<std::sync::Arc<Curve>, DataError> {
        self.0.curve(call)
    }
}
