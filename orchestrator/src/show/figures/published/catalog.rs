//! What published figures show: the catalogues of figures of a [`Catalog`].

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::catalog::Catalog;
pub(super) use crate::judge::assertions::Across;

/// All figures of a catalog, in their order.
///
/// # Errors
/// In words, if a catalogue of figures is not valid.
pub(super) fn figures(catalog: &Catalog) -> Result<Vec<Figure>, String> {
    let mut figures = Vec::new();
    for text in &catalog.figures {
        let file: File =
            toml::from_str(text).map_err(|error| format!("the catalogue of figures is not valid: {error}"))?;
        figures.extend(file.figures);
    }
    Ok(figures)
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(rename = "figure")]
    figures: Vec<Figure>,
}

/// How a figure is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Kind {
    /// Values over time.
    #[default]
    Lines,
    /// What is on and off.
    Bands,
    /// Where the agents went.
    Trajectories,
}

/// A figure.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Figure {
    /// `7.10`.
    pub(super) number: String,
    /// What it is about, for the name of its file.
    pub(super) name: String,
    #[serde(default)]
    pub(super) kind: Kind,
    pub(super) scenario: String,
    /// The variants that it compares, or the one that it shows.
    pub(super) variants: Vec<String>,
    /// Where it ends, s; at the end of the run if it does not say.
    pub(super) until: Option<f64>,
    #[serde(default, rename = "plot")]
    pub(super) plots: Vec<Quantity>,
}

/// What one of its plots shows.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Quantity {
    #[serde(default)]
    pub(super) title: String,
    /// At the vertical axis, in TeX; `#` stands for the number of the agent.
    #[serde(default)]
    pub(super) label: String,
    /// A signal in the language of assertions.
    pub(super) signal: Option<String>,
    /// The signal of a variant that calls it otherwise.
    #[serde(default)]
    pub(super) instead: BTreeMap<String, String>,
    /// A quantity that no participant publishes.
    pub(super) derived: Option<String>,
    /// Numbers of two agents whose distance it shows.
    pub(super) pair: Option<[usize; 2]>,
    /// Numbers of the agents that it shows, if not all.
    pub(super) agents: Option<Vec<usize>>,
    #[serde(default)]
    pub(super) across: Across,
    /// Variants that do not have it.
    #[serde(default)]
    pub(super) without: Vec<String>,
    /// A logarithmic scale.
    #[serde(default)]
    pub(super) log: bool,
    /// Whether the limit of the inputs is drawn.
    #[serde(default)]
    pub(super) limit: bool,
    /// Whether it is summed up over time.
    #[serde(default)]
    pub(super) integral: bool,
}

impl Figure {
    /// `fig-7-03-high-level-tracking-errors`: sorted as the thesis is, and without a dot that LaTeX would stumble over.
    pub(super) fn file_name(&self) -> String {
        let (chapter, figure) = self.number.split_once('.').unwrap_or((&self.number, ""));
        format!("fig-{chapter}-{figure:0>2}-{}", self.name)
    }
}

impl Quantity {
    /// Whether it has a value for every agent.
    pub(super) fn is_of_agents(&self) -> bool {
        self.across == Across::Each && self.pair.is_none()
    }

    /// Whether it has one for all of them.
    pub(super) fn is_of_all_agents(&self) -> bool {
        self.is_of_agents() && self.agents.is_none()
    }
}
