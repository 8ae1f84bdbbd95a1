//! Published figures, drawn again from logs, by their numbers.

mod catalog;
mod changes;
mod curves;

#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use super::file::store;
use super::picture::Label;
use super::sheet::{Line, Plot, Sheet};
use super::style::{self, Entry, Style};
use super::{FigureOptions, POINTS, trajectories};
use crate::catalog::Catalog;
use crate::failure::Failure;
use crate::show::view::{Grid, LoggedRun};
use catalog::{Figure, Kind, Quantity, figures};
use changes::Changes;
use curves::{histories, integrated};
use formation::wiring::Assembly;

/// A figure that cannot be drawn, as a run of a variant is not there.
pub(crate) struct Missing {
    /// Number of the figure.
    pub(crate) number: String,
    /// The scenario.
    pub(crate) scenario: String,
    /// The variants of which there is no log.
    pub(crate) variants: Vec<String>,
}

/// Writes the published figures for which there are logs into `folder`; their files, and the figures for which logs of other
/// variants are missing. A figure of a run that is not the published one is marked, in its name and above its plots.
///
/// # Errors
/// [`Failure::System`] if a file cannot be written, [`Failure::Usage`] if a log does not hold what a figure shows.
pub(crate) fn write(
    catalog: &Catalog,
    runs: &[LoggedRun],
    folder: &Path,
    options: &FigureOptions,
) -> Result<(Vec<PathBuf>, Vec<Missing>), Failure> {
    let (mut written, mut missing) = (Vec::new(), Vec::new());
    for figure in &figures(catalog).map_err(Failure::Usage)? {
        let of = |variant: &String| runs.iter().find(|run| is(run, &figure.scenario, variant));
        let found: Vec<Option<&LoggedRun>> = figure.variants.iter().map(of).collect();
        let runs: Vec<&LoggedRun> = found.iter().copied().flatten().collect();
        if runs.is_empty() {
            continue;
        }
        if runs.len() < found.len() {
            let absent = figure.variants.iter().zip(&found).filter(|(_, run)| run.is_none());
            missing.push(Missing {
                number: figure.number.clone(),
                scenario: figure.scenario.clone(),
                variants: absent.map(|(variant, _)| variant.clone()).collect(),
            });
            continue;
        }
        let mut sheet = draw(catalog, figure, &runs)
            .map_err(|why| Failure::Usage(format!("figure {} cannot be drawn: {why}", figure.number)))?;
        let changes = Changes::of(catalog, &runs);
        sheet.note = changes.note();
        written.push(store(folder, &format!("{}{}", figure.file_name(), changes.mark()), &sheet, options)?);
    }
    Ok((written, missing))
}

/// Whether this is a run of the variant of the scenario.
fn is(run: &LoggedRun, scenario: &str, variant: &str) -> bool {
    run.scenario.as_ref().is_some_and(|own| own.name == scenario && own.variant == variant)
}

fn draw(catalog: &Catalog, figure: &Figure, runs: &[&LoggedRun]) -> Result<Sheet, String> {
    match figure.kind {
        Kind::Trajectories => trajectories::sheet(runs[0]).ok_or("there are no positions".into()),
        Kind::Lines | Kind::Bands => Drawing::new(catalog, figure, runs)?.draw(),
    }
}

/// A run with what its signals mean.
struct Source<'a> {
    run: &'a LoggedRun,
    assembly: Assembly,
    variant: &'a str,
    grid: Grid,
    /// Samples that the figure shows.
    samples: usize,
}

struct Drawing<'a> {
    catalog: &'a Catalog,
    figure: &'a Figure,
    sources: Vec<Source<'a>>,
    span: [f64; 2],
}

impl<'a> Drawing<'a> {
    fn new(catalog: &'a Catalog, figure: &'a Figure, runs: &[&'a LoggedRun]) -> Result<Self, String> {
        let source = |(run, variant): (&&'a LoggedRun, &'a String)| {
            let scenario = run.scenario.clone().ok_or("the log holds no scenario")?;
            let assembly =
                Assembly::new(scenario, &catalog.roles).map_err(|_| "the scenario of the log is not valid")?;
            let shown = |sample: &usize| figure.until.is_none_or(|end| run.time(*sample) <= end + 1e-9);
            let samples = (0..run.samples()).take_while(shown).count();
            Ok::<_, String>(Source { run, assembly, variant, grid: Grid::new(samples, POINTS), samples })
        };
        let sources = runs.iter().zip(&figure.variants).map(source).collect::<Result<Vec<_>, _>>()?;
        let ends = sources.iter().map(|source| source.run.time(source.samples - 1));
        let span = [0.0, ends.fold(0.0, f64::max)];
        Ok(Self { catalog, figure, sources, span })
    }

    fn draw(&self) -> Result<Sheet, String> {
        if self.figure.kind == Kind::Bands {
            return Ok(Sheet::over_time(vec![vec![self.bands()?]], self.span, Vec::new()));
        }
        // Agents that are compared one by one take a row each.
        let apart = self.compares() && self.figure.plots.iter().all(|plot| plot.is_of_agents());
        let rows = if apart {
            let row = |place| self.figure.plots.iter().map(|plot| self.of_agent(plot, place)).collect();
            (0..self.sources[0].run.agents.len()).map(row).collect::<Result<Vec<_>, String>>()?
        } else {
            let rows = self.figure.plots.iter().map(|plot| Ok(vec![self.of_all(plot)?]));
            rows.collect::<Result<Vec<_>, String>>()?
        };
        Ok(Sheet::over_time(rows, self.span, self.legend()))
    }

    fn legend(&self) -> Vec<Entry> {
        let plots = &self.figure.plots;
        let mut legend = if self.compares() {
            let entry = |(index, source): (usize, &Source)| Entry::curve(source.variant, Style::at(index));
            self.sources.iter().enumerate().map(entry).collect()
        } else if plots.iter().all(Quantity::is_of_all_agents) {
            style::agents(self.sources[0].run)
        } else {
            Vec::new()
        };
        if plots.iter().any(|plot| plot.pair.is_some()) {
            legend.push(Entry::curve("contact", Style::LIMIT));
        } else if plots.iter().any(|plot| !self.limits(plot).is_empty()) {
            legend.push(Entry::curve("limit", Style::LIMIT));
        }
        legend
    }

    fn compares(&self) -> bool {
        self.sources.len() > 1
    }

    fn line(&self, source: &Source, values: &[f64], style: Style) -> Line {
        let times = source.grid.points().iter().map(|&sample| source.run.time(sample));
        let points = times.zip(source.grid.curve(|sample| values[sample])).collect();
        Line { points, style, cut_off: false, ends: false }
    }

    /// What a plot shows of a run: one history, or one for each agent.
    fn values(&self, plot: &Quantity, source: &Source) -> Result<Vec<(usize, Vec<f64>)>, String> {
        let mut all = histories(self.catalog, plot, source.variant, &source.assembly, &source.run.log)?;
        if plot.integral {
            let dt = source.assembly.scenario.context.timing.dt;
            all.iter_mut().for_each(|(_, values)| integrated(values, dt));
        }
        Ok(all)
    }

    fn limits(&self, plot: &Quantity) -> Vec<f64> {
        let context = &self.sources[0].assembly.scenario.context;
        match (context.input_limit.filter(|_| plot.limit), plot.pair) {
            (Some(limit), _) => vec![limit, -limit],
            (None, Some(pair)) => {
                vec![pair.map(|number| self.sources[0].run.radius(number - 1).unwrap_or(0.0)).iter().sum()]
            }
            (None, None) => Vec::new(),
        }
    }

    /// All agents, or what they are together.
    fn of_all(&self, plot: &Quantity) -> Result<Plot, String> {
        let mut lines = Vec::new();
        for (index, source) in self.sources.iter().enumerate() {
            if plot.without.iter().any(|variant| variant == source.variant) {
                continue;
            }
            for (agent, values) in self.values(plot, source)? {
                let style = match (self.compares(), plot.is_of_all_agents()) {
                    (true, _) => Style::at(index),
                    (false, true) => Style::at(agent),
                    (false, false) => Style::BLACK,
                };
                lines.push(self.line(source, &values, style));
            }
        }
        Ok(Plot { lines, ..self.empty(plot, "i")? })
    }

    /// A plot without curves; the index of the agent in its label is called `index`.
    fn empty(&self, plot: &Quantity, index: &str) -> Result<Plot, String> {
        let y_label = Label::tex(&plot.label.replace('#', index))?;
        let title = Label::plain(&plot.title);
        Ok(Plot { title, y_label, logarithmic: plot.log, limits: self.limits(plot), ..Plot::default() })
    }

    /// One agent in all runs.
    fn of_agent(&self, plot: &Quantity, place: usize) -> Result<Plot, String> {
        let mut lines = Vec::new();
        for (index, source) in self.sources.iter().enumerate() {
            let all = self.values(plot, source)?;
            let own = all.into_iter().filter(|(agent, _)| *agent == place);
            lines.extend(own.map(|(_, values)| self.line(source, &values, Style::at(index))));
        }
        Ok(Plot { lines, ..self.empty(plot, &self.sources[0].run.agents[place].to_string())? })
    }

    /// A row for every agent, thick while its value is not 0.
    fn bands(&self) -> Result<Plot, String> {
        let source = &self.sources[0];
        let mut lines = Vec::new();
        for plot in &self.figure.plots {
            for (agent, values) in self.values(plot, source)? {
                // The lower an agent's number, the higher its row; up is on.
                let base = -(agent as f64 + 1.0);
                let raised: Vec<f64> =
                    values.iter().map(|value| base + if *value == 0.0 { 0.0 } else { 0.7 }).collect();
                lines.push(self.line(source, &raised, Style::BLACK));
            }
        }
        Ok(Plot { y_label: Label::plain("agent"), rows: source.run.agents.clone(), lines, ..Plot::default() })
    }
}
