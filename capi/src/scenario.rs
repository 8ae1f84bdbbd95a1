//! What a participant asks about the scenario: numbers, texts, the graph, the disturbance.

use std::ffi::{c_char, c_int};

use formation::scenario::{AgentNumber, Graph};
use formation::wiring::{Interface, Refusal};

use crate::participant::{Participant, c_text};

/// Which part of the disturbance is meant.
#[derive(Clone, Copy)]
pub(crate) enum Part {
    /// What is added where the input acts.
    Matched,
    /// What is added to the velocity.
    Mismatched,
}

impl Participant {
    /// Whether the scenario has a value called `name`.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.seat().is_some_and(|interface| interface.has(name))
    }

    /// The number called `name` as it is in force; a boolean is 1 or 0.
    pub(crate) fn number(&self, name: &str) -> Result<f64, String> {
        self.interface()?.number(name).map_err(words)
    }

    /// The text called `name`, to be kept as long as the participant.
    pub(crate) fn text(&mut self, name: &str) -> Result<*const c_char, String> {
        let text = self.interface()?.text(name).map_err(words)?.to_string();
        Ok(self.keep_text(&text))
    }

    fn keep_text(&mut self, text: &str) -> *const c_char {
        let text = c_text(text);
        if let Some(known) = self.texts.iter().find(|known| **known == text) {
            return known.as_ptr();
        }
        let pointer = text.as_ptr();
        self.texts.push(text);
        pointer
    }

    /// The dotted name of a parameter of the program; agent 0: that of its own agent, if it serves one.
    pub(crate) fn parameter(&mut self, agent: c_int, name: &str) -> Result<*const c_char, String> {
        let agent = if agent == 0 { None } else { Some(self.agent(agent)?) };
        let path = self.interface()?.parameter(agent, name).map_err(words)?;
        Ok(self.keep_text(&path))
    }

    /// A text that is a path, meant from the folder of the scenario file.
    pub(crate) fn path(&mut self, name: &str) -> Result<*const c_char, String> {
        let path = self.interface()?.path(name).map_err(words)?;
        let path = path.to_str().ok_or_else(|| format!("{}: it is no UTF-8 text", path.display()))?;
        Ok(self.keep_text(path))
    }

    /// The number of elements of the list called `name`.
    pub(crate) fn length(&self, name: &str) -> Result<usize, String> {
        self.interface()?.length(name).map_err(words)
    }

    /// A number of the nominal model of an agent's vehicle.
    pub(crate) fn model(&self, agent: c_int, name: &str) -> Result<f64, String> {
        self.interface()?.model(self.agent(agent)?, name).map_err(words)
    }

    /// Weight of the static link over which `i` receives from `j`.
    pub(crate) fn weight(&self, i: c_int, j: c_int) -> Result<f64, String> {
        let (i, j) = (self.agent(i)?, self.agent(j)?);
        Ok(self.graph()?.weight(i, j))
    }

    /// The same if both are so many metres apart.
    pub(crate) fn weight_at(&self, i: c_int, j: c_int, distance: f64) -> Result<f64, String> {
        let (i, j) = (self.agent(i)?, self.agent(j)?);
        Ok(self.graph()?.weight_at(i, j, distance))
    }

    /// Weight of the reference link of an agent.
    pub(crate) fn reference_weight(&self, agent: c_int) -> Result<f64, String> {
        let agent = self.agent(agent)?;
        Ok(self.graph()?.b(agent))
    }

    /// The agents that an agent receives from over static links.
    pub(crate) fn neighbours(&self, agent: c_int) -> Result<impl Iterator<Item = AgentNumber>, String> {
        let agent = self.agent(agent)?;
        Ok(self.graph()?.neighbours(agent))
    }

    /// Number of coordinates of an agent's vehicle.
    pub(crate) fn coordinates(&self, agent: c_int) -> Result<usize, String> {
        let agent = self.agent(agent)?;
        Ok(self.interface()?.context().agents[agent.index()].vehicle.coordinates())
    }

    /// Writes what disturbs an agent at time `t`, coordinates `x` and velocities `v`.
    pub(crate) fn disturbance(
        &self,
        part: Part,
        agent: c_int,
        t: f64,
        [x, v]: [&[f64]; 2],
        out: &mut [f64],
    ) -> Result<(), String> {
        let agent = self.agent(agent)?;
        let disturbance = &self.interface()?.context().disturbance[agent.index()];
        match part {
            Part::Matched => disturbance.matched_at(t, x, v, out),
            Part::Mismatched => disturbance.mismatched_at(t, x, v, out),
        }
        Ok(())
    }

    /// The agent that the caller means; 0 is the participant's own.
    pub(crate) fn agent(&self, number: c_int) -> Result<AgentNumber, String> {
        let interface = self.interface()?;
        match usize::try_from(number) {
            Ok(0) => interface.agent().map_err(words),
            Ok(number) => interface.agent_called(number).map_err(words),
            Err(_) => Err(format!("there is no agent {number}; agents count from 1")),
        }
    }

    /// The graph of the step in progress; that of step 0 before.
    fn graph(&self) -> Result<&Graph, String> {
        let graph = self.graphs.iter().rev().find(|(start, _)| *start <= self.step.index);
        graph.map(|(_, graph)| graph).ok_or_else(|| "there is no graph outside a run".into())
    }

    pub(crate) fn interface(&self) -> Result<&Interface, String> {
        self.seat().ok_or_else(|| "there is no scenario outside a run".into())
    }
}

fn words(refusal: Refusal) -> String {
    refusal.0
}
