//! From the ids of nodes to the numbers of agents.

use std::collections::BTreeMap;
use std::ops::Range;

use super::Wrong;
use crate::config::brief;

/// The nodes of a file in the order in which they appear.
#[derive(Default)]
pub(super) struct Nodes<'a> {
    places: BTreeMap<&'a str, usize>,
    order: Vec<(&'a str, Range<usize>)>,
}

impl<'a> Nodes<'a> {
    /// The place of a node, from 0; it is added if it is new.
    pub(super) fn place(&mut self, id: &'a str, span: Range<usize>) -> usize {
        let next = self.order.len();
        let place = *self.places.entry(id).or_insert(next);
        if place == next {
            self.order.push((id, span));
        }
        place
    }

    /// The place of a node that was added before.
    pub(super) fn find(&self, id: &str) -> Option<usize> {
        self.places.get(id).copied()
    }

    /// The ids in order.
    pub(super) fn ids(&self) -> impl Iterator<Item = &'a str> {
        self.order.iter().map(|(id, _)| *id)
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.order.len()
    }

    /// The number of the agent of each node, where all nodes are listed: the id itself if the ids are 1 to n, the id plus 1 if they are
    /// 0 to n - 1, else the place in the list.
    pub(super) fn listed_numbers(&self) -> Vec<u64> {
        let count = self.len() as u64;
        let ids: Option<Vec<u64>> = self.ids().map(|id| id.parse().ok()).collect();
        match ids {
            // Ids differ, so those within 1 to n are all of these.
            Some(ids) if ids.iter().all(|id| (1..=count).contains(id)) => ids,
            Some(ids) if ids.iter().all(|id| *id < count) => ids.into_iter().map(|id| id + 1).collect(),
            _ => (1..=count).collect(),
        }
    }

    /// The number of the agent of each node, where only nodes with links are listed: whole numbers are the numbers of agents, or those
    /// less 1 if 0 is among them; names are numbered in the order in which they appear, and `None` is the number of nodes otherwise.
    pub(super) fn linked_numbers(&self) -> Result<(Vec<u64>, Option<usize>), Wrong> {
        let is_number = |id: &str| id.parse::<f64>().is_ok();
        let (numbers, names): (Vec<_>, Vec<_>) = self.order.iter().partition(|(id, _)| is_number(id));
        if numbers.is_empty() {
            return Ok(((1..=self.len() as u64).collect(), Some(self.len())));
        }
        if let Some((name, span)) = names.first() {
            let message = format!("expected the number of an agent, as elsewhere in the file, found `{}`", brief(name));
            return Err(Wrong::new(span.clone(), message));
        }
        let mut found = Vec::with_capacity(self.len());
        for (id, span) in &self.order {
            let number = id.parse::<u64>();
            let message = || format!("expected the number of an agent, found `{}`", brief(id));
            found.push(number.map_err(|_| Wrong::new(span.clone(), message()))?);
        }
        let shift = u64::from(found.contains(&0));
        Ok((found.into_iter().map(|number| number.saturating_add(shift)).collect(), None))
    }
}
