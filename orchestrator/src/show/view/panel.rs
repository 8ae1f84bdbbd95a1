//! Plots as data: what the report and the figures draw, each in its own way.

/// How the curves of a panel are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Values over time.
    Lines,
    /// A row per curve, filled while its value is not 0.
    Bands,
}

/// Plots of one run matter, one of which is shown at a time.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// Short name for files and links, `tracking-errors`.
    pub id: &'static str,
    /// Heading.
    pub title: &'static str,
    /// How it is drawn.
    pub kind: Kind,
    /// The plots; the first one is shown first.
    pub views: Vec<View>,
}

/// One plot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct View {
    /// What it shows, within its panel.
    pub name: String,
    /// What stands at the vertical axis.
    pub axis: String,
    /// Unit of its values; empty if they have none.
    pub unit: String,
    /// Whether its values are norms, which are best seen on a logarithmic scale.
    pub logarithmic: bool,
    /// The curves.
    pub curves: Vec<Curve>,
    /// Values that mean something by themselves.
    pub limits: Vec<Limit>,
}

/// One line of a plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// What it is, without the agent.
    pub label: String,
    /// Place of its agent in the list of agents; `None` if it belongs to all.
    pub agent: Option<usize>,
    /// Whether it stands beside another curve of the same agent, as an estimate stands beside the truth.
    pub second: bool,
    /// One value for each point of the grid.
    pub values: Vec<f64>,
}

/// A horizontal line.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    /// What it means.
    pub label: String,
    /// Where it is.
    pub value: f64,
}
