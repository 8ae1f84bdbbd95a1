//! The columns of a topic.

use crate::show::view::Signal;
use recording::{Log, LogChannel, Series};

/// A field of a topic with its values.
pub(crate) struct Column<'a> {
    /// Name of the field.
    pub(crate) name: String,
    /// Components that are wanted, from 0.
    pub(crate) components: Vec<usize>,
    /// Whether it is a vector, whose components are numbered.
    pub(crate) vector: bool,
    /// Its values.
    pub(crate) series: Series<'a>,
}

/// A topic with its fields.
pub(crate) struct Table<'a> {
    /// `agent_1_state`: the topic as a name for files and variables.
    pub(crate) name: String,
    /// The fields in order.
    pub(crate) columns: Vec<Column<'a>>,
}

impl<'a> Table<'a> {
    /// All fields of a channel.
    pub(crate) fn of(log: &'a Log, channel: &LogChannel) -> Self {
        let fields = channel.layout.iter().flat_map(|layout| layout.fields());
        let columns = fields.filter_map(|field| {
            let series = log.signal(&channel.topic, &field.name)?;
            let vector = field.shape != lockstep::Shape::Scalar;
            Some(Column { name: field.name.clone(), components: (0..series.width()).collect(), vector, series })
        });
        let name = channel.topic.trim_matches('/').replace(|c: char| !c.is_ascii_alphanumeric(), "_");
        Self { name, columns: columns.collect() }
    }

    /// Forgets what is not among `signals`.
    pub(crate) fn keep(&mut self, signals: &[Signal]) {
        self.columns.retain_mut(|column| {
            let Some(signal) = signals.iter().find(|signal| signal.field == column.name) else { return false };
            if let Some(component) = signal.component {
                column.components = vec![component];
            }
            true
        });
    }
}
