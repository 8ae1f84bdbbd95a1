//! Repulsive potential fields around discs. (3.12), (4.9)

use nalgebra::Vector2;

/// A field between an inner boundary, where it becomes infinite, and an outer one, where it ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PotentialField {
    /// α, strength.
    pub strength: f64,
    /// Inner boundary, m: the distance that must not be reached.
    pub inner: f64,
    /// Outer boundary, m.
    pub outer: f64,
}

impl PotentialField {
    /// The field of two discs whose radii add up to `radii`, with the boundaries `eps1 radii` and `eps2 radii`.
    pub fn of_discs(strength: f64, radii: f64, eps1: f64, eps2: f64) -> Self {
        Self { strength, inner: eps1 * radii, outer: eps2 * radii }
    }

    /// The force on a body at `offset` (m) from the centre of the field. As printed, it is 0 inside the inner boundary too.
    pub fn force(&self, offset: &Vector2<f64>) -> Vector2<f64> {
        let distance = offset.norm();
        if self.inner < distance && distance <= self.outer {
            let gap = distance - self.inner;
            self.strength * (self.outer - distance) / (gap * gap) * (offset / distance)
        } else {
            Vector2::zeros()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn repels_and_weakens_with_the_distance(near in 1.01..1.9f64, step in 0.001..0.1f64, angle in 0.0..6.2f64) {
            let field = PotentialField { strength: 0.05, inner: 1.0, outer: 2.0 };
            let direction = Vector2::new(libm::cos(angle), libm::sin(angle));
            let force = field.force(&(near * direction));
            prop_assert!(force.dot(&direction) > 0.0);
            prop_assert!(field.force(&((near + step) * direction)).norm() <= force.norm());
        }
    }

    #[test]
    fn ends_at_the_outer_boundary_without_a_jump() {
        let field = PotentialField::of_discs(2.0, 0.5, 1.1, 2.0);
        assert!(field.force(&Vector2::new(1.0 - 1e-9, 0.0)).norm() < 1e-7);
        assert_eq!(field.force(&Vector2::new(1.0 + 1e-9, 0.0)), Vector2::zeros());
    }

    #[test]
    fn the_force_is_that_of_the_equation_at_known_distances() {
        let field = PotentialField { strength: 2.0, inner: 1.0, outer: 3.0 };
        for (distance, force) in [(1.25, 56.0), (1.5, 12.0), (2.0, 2.0), (2.5, 4.0 / 9.0)] {
            assert!((field.force(&Vector2::new(0.0, -distance)) - Vector2::new(0.0, -force)).norm() < 1e-12);
        }
    }
}
