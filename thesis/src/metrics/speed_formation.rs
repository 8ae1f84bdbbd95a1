//! What the metrics of chapter 5 have in common: robots with speed-controlled wheels, their errors and uncertainties.

use formation::math::clip;
use formation::vehicle::{MAX_COORDINATES, MAX_INPUTS, Vehicle};
use formation::wiring::Role;

use orchestrator::judge::metrics::{
    Metric, MetricError, Run, first_below_for_good, maximum, square_sum, total_variation,
};
use recording::Series;

/// The channels of a planar robot, as metrics call them.
const CHANNELS: [&str; 3] = ["x", "y", "θ"];

/// The signals of all agents.
pub(super) struct SpeedFormation<'a> {
    run: &'a Run<'a>,
    position: Vec<Series<'a>>,
    disturbance: Vec<Series<'a>>,
    reference: Vec<Series<'a>>,
    estimate: Vec<Series<'a>>,
    /// u, wheel speeds.
    pub(super) input: Vec<Series<'a>>,
    /// e, local errors.
    pub(super) error: Vec<Series<'a>>,
}

/// ‖E_i - Ê_i‖ of every agent at every sample.
pub(super) fn uncertainty_error(run: &Run) -> Result<Vec<Vec<f64>>, MetricError> {
    let observed = run.offers(Role::Observer, 0, "disturbance");
    let (role, name) = if observed { (Role::Observer, "disturbance") } else { (Role::Controller, "network") };
    let formation = SpeedFormation::read(run, role, name)?;
    Ok((0..run.agents()).map(|i| run.history(|k| formation.uncertainty_error(i, k))).collect())
}

impl<'a> SpeedFormation<'a> {
    /// The signals of a run whose uncertainty is estimated in `estimate`, a signal of `estimator`.
    pub(super) fn read(run: &'a Run<'a>, estimator: Role, estimate: &str) -> Result<Self, MetricError> {
        Ok(Self {
            position: run.signals(Role::Plant, "position")?,
            disturbance: run.signals(Role::Plant, "disturbance")?,
            reference: run.signals(Role::Planner, "position")?,
            estimate: run.signals(estimator, estimate)?,
            input: run.signals(Role::Controller, "input")?,
            error: run.signals(Role::Controller, "error")?,
            run,
        })
    }

    /// ‖E_i - Ê_i‖ of agent `i` at sample `k`, with `E_i = (T_f(θ_i, R_i) - T_f(θ_i, R̂_i)) S(u_i) + w_i`.
    pub(super) fn uncertainty_error(&self, i: usize, k: usize) -> f64 {
        let context = &self.run.scenario.context;
        let mut input = [0.0; MAX_INPUTS];
        let commanded = self.input[i].row(k);
        for (value, command) in input.iter_mut().zip(commanded) {
            *value = context.input_limit.map_or(*command, |limit| clip(*command, limit));
        }
        let effect = |vehicle: &Vehicle| {
            let mut effect = [0.0; MAX_COORDINATES];
            vehicle.effect(self.position[i].row(k), &input[..commanded.len()], &mut effect);
            effect
        };
        let (real, known) = (effect(&context.agents[i].vehicle), effect(&context.agents[i].nominal));
        let (disturbance, estimate) = (self.disturbance[i].row(k), self.estimate[i].row(k));
        let difference = |j: usize| real[j] - known[j] + disturbance[j] - estimate[j];
        (0..estimate.len()).map(|j| difference(j).powi(2)).sum::<f64>().sqrt()
    }

    /// Ẽ of all agents as one vector: its norm.
    pub(super) fn stacked_uncertainty_error(&self) -> Vec<f64> {
        self.stacked(|i, k| self.uncertainty_error(i, k).powi(2))
    }

    /// ‖e‖ of all agents as one vector.
    pub(super) fn stacked_error(&self) -> Vec<f64> {
        self.stacked(|i, k| square_sum(self.error[i].row(k)))
    }

    /// ‖u‖ of all agents as one vector.
    pub(super) fn stacked_input(&self) -> Vec<f64> {
        self.stacked(|i, k| square_sum(self.input[i].row(k)))
    }

    /// ‖δ‖ of all agents as one vector.
    pub(super) fn stacked_tracking_error(&self) -> Vec<f64> {
        self.stacked(|i, k| {
            let pairs = self.position[i].row(k).iter().zip(self.reference[i].row(k));
            pairs.map(|(position, reference)| (position - reference).powi(2)).sum()
        })
    }

    fn stacked(&self, square: impl Fn(usize, usize) -> f64) -> Vec<f64> {
        self.run.history(|k| (0..self.run.agents()).map(|i| square(i, k)).sum::<f64>().sqrt())
    }

    /// Oscillation of the local error of agent `i` in a channel until `end` s: total variation less the net change.
    fn oscillation(&self, i: usize, channel: usize, end: f64) -> f64 {
        let last = self.run.sample_at(end).min(self.run.samples() - 1);
        let values = || self.error[i].component(channel).take(last + 1);
        let net = self.error[i].row(last)[channel] - self.error[i].row(0)[channel];
        total_variation(values()) - net.abs()
    }

    /// `V_x`, `V_y`, `V_θ`, summed over the agents, then `V_x_1`, ... of each agent, until `end` s.
    pub(super) fn oscillations(&self, end: f64) -> Vec<Metric> {
        let agents = self.run.agents();
        let each: Vec<[f64; 3]> =
            (0..agents).map(|i| std::array::from_fn(|channel| self.oscillation(i, channel, end))).collect();
        let sums = CHANNELS
            .iter()
            .enumerate()
            .map(|(channel, name)| Metric::new(format!("V_{name}"), each.iter().map(|of| of[channel]).sum()));
        let of_agents = CHANNELS.iter().enumerate().flat_map(|(channel, name)| {
            each.iter().zip(1..).map(move |(of, number)| Metric::new(format!("V_{name}_{number}"), of[channel]))
        });
        sums.chain(of_agents).collect()
    }

    /// Largest magnitude of any input, from the start to the end.
    pub(super) fn largest_input(&self) -> f64 {
        maximum(self.input.iter().flat_map(|series| series.rows()).flatten().map(|input| input.abs()))
    }

    /// The instant from which on `history` never exceeds `level` again, s.
    pub(super) fn settled(&self, history: &[f64], level: f64) -> f64 {
        first_below_for_good(history, level).map_or(f64::NAN, |k| self.run.time(k))
    }
}
