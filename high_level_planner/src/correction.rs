//! The reference correction algorithm: a reference hidden behind an obstacle is replaced by one beside it. (Algorithm 1)

use formation::nalgebra::{Vector2, Vector3};
use formation::scenario::Boundary;

use crate::TrajectorySample;

/// Moves the references that one agent cannot reach in a straight line onto a tangent of the obstacle in its way.
///
/// Without it, an agent that goes around an obstacle has a large tracking error, which its neighbours see and follow.
#[derive(Clone, Debug, PartialEq)]
pub struct Correction {
    boundaries: Vec<Boundary>,
}

/// The tangent that is to be followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tangent {
    /// Number of the obstacle, from 1.
    pub obstacle: usize,
    /// Unit vector from the agent to the point of contact with the inner boundary.
    pub direction: Vector2<f64>,
}

impl Correction {
    /// For an agent that respects these boundaries.
    pub fn new(boundaries: Vec<Boundary>) -> Self {
        Self { boundaries }
    }

    /// The tangent to follow from `position` when `target` is out of reach; `None` if the way is free.
    ///
    /// Only the obstacle with the nearest centre counts, and only between its two boundaries.
    pub fn tangent(&self, position: &Vector2<f64>, target: &Vector2<f64>) -> Option<Tangent> {
        let (number, boundary) = self.nearest(position)?;
        let to_centre = boundary.centre - position;
        let to_target = target - position;
        let (distance, length) = (to_centre.norm(), to_target.norm());
        if !(boundary.inner < distance && distance <= boundary.outer) || length == 0.0 {
            return None;
        }
        // The line of sight passes the inner circle, or the obstacle lies behind the agent.
        if to_centre.perp(&to_target).abs() / length > boundary.inner || to_centre.dot(&to_target) < 0.0 {
            return None;
        }
        let contact = (distance * distance - boundary.inner * boundary.inner).sqrt();
        let inside = (target - boundary.centre).norm() <= boundary.inner;
        if !(contact <= length || inside) {
            return None; // in front of the obstacle
        }
        let ahead = to_centre / distance;
        let (sine, cosine) = (boundary.inner / distance, contact / distance);
        let turned = |sine: f64| Vector2::new(cosine * ahead.x - sine * ahead.y, sine * ahead.x + cosine * ahead.y);
        let (left, right) = (turned(sine), turned(-sine));
        let off = |direction: &Vector2<f64>| direction.perp(&to_target).abs();
        let direction = if off(&left) <= off(&right) { left } else { right };
        Some(Tangent { obstacle: number, direction })
    }

    /// Corrects `reference` for an agent at `position` (x, y) and returns the number of the obstacle in the way, from 1, or 0 if
    /// there is none. The foot of the perpendicular on the tangent becomes the reference; its derivatives keep their parts along
    /// the tangent. The third coordinate stays as it is.
    pub fn correct(&self, position: &Vector2<f64>, reference: &mut TrajectorySample) -> usize {
        let Some(tangent) = self.tangent(position, &reference.position.xy()) else { return 0 };
        let along = |vector: Vector2<f64>| vector.dot(&tangent.direction) * tangent.direction;
        let foot = position + along(reference.position.xy() - position);
        set_planar(&mut reference.position, foot);
        for derivative in [&mut reference.velocity, &mut reference.acceleration, &mut reference.jerk] {
            set_planar(derivative, along(derivative.xy()));
        }
        tangent.obstacle
    }

    /// The obstacle whose centre is nearest, the first of several; with its number.
    fn nearest(&self, position: &Vector2<f64>) -> Option<(usize, &Boundary)> {
        let distance = |boundary: &Boundary| (boundary.centre - position).norm();
        (1..).zip(&self.boundaries).reduce(|best, next| if distance(next.1) < distance(best.1) { next } else { best })
    }
}

fn set_planar(vector: &mut Vector3<f64>, planar: Vector2<f64>) {
    vector.x = planar.x;
    vector.y = planar.y;
}

#[cfg(test)]
mod tests {
    use formation::nalgebra::Rotation2;
    use proptest::prelude::*;

    use super::*;

    const INNER: f64 = 0.5;
    const OUTER: f64 = 1.0;

    fn around(centre: [f64; 2]) -> Boundary {
        Boundary { centre: centre.into(), inner: INNER, outer: OUTER }
    }

    fn one() -> Correction {
        Correction::new(vec![around([0.0, 0.0])])
    }

    fn sample(x: f64, y: f64) -> TrajectorySample {
        TrajectorySample {
            position: Vector3::new(x, y, 0.3),
            velocity: Vector3::new(1.0, -2.0, 0.1),
            acceleration: Vector3::new(0.5, 0.25, 0.2),
            jerk: Vector3::new(-0.5, 0.1, 0.4),
        }
    }

    fn polar(radius: f64, angle: f64) -> Vector2<f64> {
        radius * Vector2::new(libm::cos(angle), libm::sin(angle))
    }

    proptest! {
        /// An agent that goes straight to the corrected reference touches the inner circle at most, and gets closer to the given one.
        #[test]
        fn the_way_to_the_corrected_reference_is_free(distance in 0.51..1.0f64, angle in 0.0..6.2f64, range in 0.0..4.0f64, bearing in 0.0..6.2f64) {
            let position = polar(distance, angle);
            let target = polar(range, bearing);
            let mut reference = sample(target.x, target.y);
            if one().correct(&position, &mut reference) == 1 {
                let way = reference.position.xy() - position;
                for part in 0..=100 {
                    let place = position + f64::from(part) / 100.0 * way;
                    prop_assert!(place.norm() >= INNER - 1e-9, "{place}");
                }
                prop_assert!(way.dot(&(target - position)) >= 0.0);
                prop_assert!(way.norm() <= (target - position).norm() + 1e-12);
                let rate = reference.velocity.xy();
                prop_assert!(rate.perp(&way).abs() < 1e-9 && rate.norm() <= 5f64.sqrt() + 1e-12);
            } else {
                prop_assert_eq!(reference, sample(target.x, target.y));
            }
        }

        /// Turning the whole plane turns the tangent.
        #[test]
        fn no_direction_is_special(distance in 0.51..1.0f64, range in 0.6..4.0f64, bearing in 2.0..4.2f64, turn in 0.0..6.2f64) {
            prop_assume!((bearing - std::f64::consts::PI).abs() > 1e-6); // both tangents are equally good there
            let (position, target) = (polar(distance, 0.0), polar(range, bearing));
            let rotation = Rotation2::new(turn);
            let plain = one().tangent(&position, &target);
            let turned = one().tangent(&(rotation * position), &(rotation * target));
            match (plain, turned) {
                (Some(plain), Some(turned)) => prop_assert!((rotation * plain.direction - turned.direction).norm() < 1e-9),
                (plain, turned) => prop_assert_eq!(plain.is_some(), turned.is_some()),
            }
        }

        /// Every hidden target is found out, by another way: a straight way that enters the inner circle.
        #[test]
        fn whatever_is_behind_or_inside_is_out_of_reach(distance in 0.51..1.0f64, angle in 0.0..6.2f64, range in 0.0..4.0f64, bearing in 0.0..6.2f64) {
            let (position, target) = (polar(distance, angle), polar(range, bearing));
            let enters = (0..=2000).any(|part| (position + f64::from(part) / 2000.0 * (target - position)).norm() < INNER - 1e-6);
            prop_assert!(!enters || one().tangent(&position, &target).is_some());
        }
    }

    #[test]
    fn a_target_right_behind_goes_to_the_tangent_on_its_side() {
        let mut reference = sample(-2.0, 0.1);
        assert_eq!(one().correct(&Vector2::new(1.0, 0.0), &mut reference), 1);
        // The tangent from (1, 0) to a circle of radius 1/2 is 30 degrees off the line to its centre.
        let direction = Vector2::new(-3f64.sqrt() / 2.0, 0.5);
        let expected = Vector2::new(1.0, 0.0) + Vector2::new(-3.0, 0.1).dot(&direction) * direction;
        assert!((reference.position.xy() - expected).norm() < 1e-12, "{reference:?}");
        let along = |x: f64, y: f64| Vector2::new(x, y).dot(&direction) * direction;
        assert!((reference.velocity.xy() - along(1.0, -2.0)).norm() < 1e-12);
        assert!((reference.acceleration.xy() - along(0.5, 0.25)).norm() < 1e-12);
        assert!((reference.jerk.xy() - along(-0.5, 0.1)).norm() < 1e-12);
        let third = [reference.position.z, reference.velocity.z, reference.acceleration.z, reference.jerk.z];
        assert_eq!(third, [0.3, 0.1, 0.2, 0.4]);
    }

    #[test]
    fn what_is_in_reach_stays() {
        let from = |position: [f64; 2], target: [f64; 2]| one().tangent(&position.into(), &target.into());
        assert_eq!(from([1.0, 0.0], [0.6, 0.0]), None, "in front of the obstacle");
        assert_eq!(from([1.0, 0.0], [3.0, 0.0]), None, "on the other side of the agent");
        assert_eq!(from([1.0, 0.0], [-1.0, 2.0]), None, "beside the obstacle");
        assert_eq!(from([1.0, 0.0], [1.0, 0.0]), None, "where the agent is");
        assert_eq!(from([1.1, 0.0], [-2.0, 0.0]), None, "too far away to matter");
        assert_eq!(from([0.5, 0.0], [-2.0, 0.0]), None, "on the inner boundary there is no tangent");
        assert!(from([1.0, 0.0], [0.4, 0.0]).is_some(), "inside the inner boundary");
        assert!(from([1.0, 0.0], [-2.0, 0.0]).is_some(), "behind the obstacle");
    }

    #[test]
    fn the_nearest_obstacle_counts_and_the_first_of_equals() {
        let two = Correction::new(vec![around([2.0, 0.0]), around([0.0, 0.0])]);
        assert_eq!(two.tangent(&Vector2::new(0.9, 0.0), &Vector2::new(-2.0, 0.0)).map(|t| t.obstacle), Some(2));
        assert_eq!(two.tangent(&Vector2::new(1.0, 0.0), &Vector2::new(-2.0, 0.0)), None);
        assert_eq!(two.tangent(&Vector2::new(1.0, 0.0), &Vector2::new(4.0, 0.0)).map(|t| t.obstacle), Some(1));
        assert_eq!(Correction::new(Vec::new()).tangent(&Vector2::zeros(), &Vector2::x()), None);
    }
}
