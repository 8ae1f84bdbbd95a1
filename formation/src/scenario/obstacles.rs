//! Round obstacles that every agent has to keep clear of.

use nalgebra::Vector2;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::config::{Node, Problems, read};

/// `[obstacles]`: resting discs, known to planners and controllers alike.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Obstacles {
    /// Centres (x, y), m.
    #[serde(rename = "p_obs")]
    pub centres: Vec<[f64; 2]>,
    /// Radii, m.
    #[serde(rename = "r_obs")]
    pub radii: Vec<f64>,
    /// ε1: the inner boundary, in sums of the radii of agent and obstacle.
    pub eps1: f64,
    /// ε2: the outer boundary, in the same unit.
    pub eps2: f64,
}

/// The two circles around an obstacle that one agent respects. (Definition 3.2)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Boundary {
    /// Centre of the obstacle, m.
    pub centre: Vector2<f64>,
    /// r_in, m: the distance of centres that must never be reached.
    pub inner: f64,
    /// r_out, m: the distance within which the agent pays attention to the obstacle.
    pub outer: f64,
}

impl Obstacles {
    /// The section of the scenario, if it has one; without an obstacle where something is wrong with it, which is reported.
    pub(super) fn read(root: &Node, problems: &mut Problems) -> Option<Self> {
        let node = root.at("obstacles")?;
        let nothing = Self { centres: Vec::new(), radii: Vec::new(), eps1: 1.0, eps2: 2.0 };
        let obstacles = read::<Self>(node, "obstacles", problems).unwrap_or(nothing);
        for (field, message) in obstacles.findings() {
            problems.at(root, &format!("obstacles.{field}"), message);
        }
        Some(obstacles)
    }

    /// The circles that an agent of this radius, in m, respects; one per obstacle, in order.
    pub fn boundaries(&self, radius: f64) -> Vec<Boundary> {
        let discs = self.centres.iter().zip(&self.radii);
        discs
            .map(|(&centre, obstacle)| Boundary {
                centre: centre.into(),
                inner: self.eps1 * (radius + obstacle),
                outer: self.eps2 * (radius + obstacle),
            })
            .collect()
    }

    /// What is wrong with these numbers: field and message.
    pub(super) fn findings(&self) -> Vec<(&'static str, String)> {
        let mut findings = Vec::new();
        let mut require = |admissible: bool, field, message: String| {
            if !admissible {
                findings.push((field, message));
            }
        };
        for (k, centre) in self.centres.iter().enumerate() {
            let finite = centre.iter().all(|value| value.is_finite());
            require(finite, "p_obs", format!("expected finite coordinates, found {centre:?} for obstacle {}", k + 1));
        }
        let (centres, radii) = (self.centres.len(), self.radii.len());
        let message = format!("expected one radius per centre in `p_obs`, that is {centres}, found {radii}");
        require(centres == radii, "r_obs", message);
        for radius in &self.radii {
            require(radius.is_finite() && *radius > 0.0, "r_obs", format!("expected radii > 0 m, found {radius}"));
        }
        let Self { eps1, eps2, .. } = *self;
        require(eps1.is_finite() && eps1 > 0.0, "eps1", format!("expected a number > 0, found {eps1}"));
        let ordered = eps2.is_finite() && eps2 > eps1;
        require(ordered, "eps2", format!("expected a number > eps1 = {eps1}, found {eps2}"));
        findings
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two() -> Obstacles {
        Obstacles { centres: vec![[2.9, 2.0], [1.8, -1.6]], radii: vec![0.3, 0.25], eps1: 1.1, eps2: 2.0 }
    }

    #[test]
    fn boundaries_scale_the_sum_of_the_radii() {
        let second = two().boundaries(0.25)[1];
        assert_eq!(second.centre, Vector2::new(1.8, -1.6));
        assert!((second.inner - 0.55).abs() < 1e-15 && (second.outer - 1.0).abs() < 1e-15, "{second:?}");
    }

    #[test]
    fn what_does_not_describe_discs_is_refused_at_its_field() {
        assert!(two().findings().is_empty());
        let field = |obstacles: Obstacles| obstacles.findings().first().map(|finding| finding.0);
        assert_eq!(field(Obstacles { radii: vec![0.3], ..two() }), Some("r_obs"));
        assert_eq!(field(Obstacles { radii: vec![0.3, 0.0], ..two() }), Some("r_obs"));
        assert_eq!(field(Obstacles { centres: vec![[f64::NAN, 0.0], [1.0, 1.0]], ..two() }), Some("p_obs"));
        assert_eq!(field(Obstacles { eps1: -1.0, ..two() }), Some("eps1"));
        assert_eq!(field(Obstacles { eps2: 1.1, ..two() }), Some("eps2"));
    }
}
