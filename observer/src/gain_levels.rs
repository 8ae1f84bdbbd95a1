//! Learning rate and leakage of a network by the size of its error: the smaller the error, the larger the gains. (4.22)

/// A table of gains over decades of the error.
#[derive(Clone, Debug, PartialEq)]
pub struct GainLevels {
    /// Least error of every level but the last, descending.
    thresholds: Vec<f64>,
    gains: Vec<Gains>,
}

/// A pair of gains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// η1, learning rate.
    pub learning: f64,
    /// η2, leakage per unit of error.
    pub leakage: f64,
}

impl GainLevels {
    /// The table whose first level holds from an error of `10^(cv - 1)` on, the second from a tenth of that, and so on.
    pub fn new(cv: f64, learning: &[f64], leakage: &[f64]) -> Self {
        let gains: Vec<Gains> =
            learning.iter().zip(leakage).map(|(&learning, &leakage)| Gains { learning, leakage }).collect();
        let thresholds = (1..gains.len()).map(|level| libm::pow(10.0, cv - level as f64)).collect();
        Self { thresholds, gains }
    }

    /// The same gains whatever the error.
    pub fn constant(gains: Gains) -> Self {
        Self { thresholds: Vec::new(), gains: vec![gains] }
    }

    /// The level (from 1) of an error, and its gains.
    pub fn at(&self, error: f64) -> (usize, Gains) {
        let index = self.thresholds.iter().position(|threshold| error >= *threshold).unwrap_or(self.thresholds.len());
        (index + 1, self.gains[index])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_decade_each_and_the_last_for_all_the_rest() {
        let levels = GainLevels::new(1.0, &[1.0, 5.0, 50.0, 200.0, 10000.0], &[0.05, 0.25, 5.0, 20.0, 100.0]);
        let level = |error| levels.at(error).0;
        assert_eq!([level(30.0), level(1.0), level(0.99), level(0.1), level(0.099)], [1, 1, 2, 2, 3]);
        assert_eq!([level(0.01), level(0.0011), level(0.0009), level(0.0)], [3, 4, 5, 5]);
        assert_eq!(levels.at(0.0).1, Gains { learning: 10000.0, leakage: 100.0 });
        assert_eq!(levels.at(2.0).1, Gains { learning: 1.0, leakage: 0.05 });
    }

    #[test]
    fn another_first_decade_shifts_all() {
        let levels = GainLevels::new(0.0, &[1.0, 2.0], &[3.0, 4.0]);
        assert_eq!([levels.at(0.1).0, levels.at(0.09).0], [1, 2]);
        assert_eq!(GainLevels::constant(Gains { learning: 7.0, leakage: 8.0 }).at(0.5).0, 1);
    }
}
