//! Thinning out: fewer points that still show every peak.

/// Which samples stand for a run of `samples` samples.
///
/// A run with more samples than points is cut into intervals of nearly equal length, two points for each. A curve shows the
/// smallest and the largest value of an interval, in the order in which they occur, so that no peak and no band of chatter
/// is lost; a scene shows the samples at the points themselves.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Grid {
    samples: usize,
    points: Vec<usize>,
}

impl Grid {
    /// A grid of at most `points` points (at least 2) over `samples` samples.
    pub fn new(samples: usize, points: usize) -> Self {
        let intervals = (points / 2).max(1);
        if samples <= 2 * intervals {
            return Self { samples, points: (0..samples).collect() };
        }
        let start = |interval: usize| interval * samples / intervals;
        let mut places: Vec<usize> = (0..intervals)
            .flat_map(|interval| [start(interval), (start(interval) + start(interval + 1)) / 2])
            .collect();
        // The end of a run is what one asks for first.
        places[2 * intervals - 1] = samples - 1;
        Self { samples, points: places }
    }

    /// The sample of every point, ascending.
    pub fn points(&self) -> &[usize] {
        &self.points
    }

    /// The largest number of samples that one interval stands for; 1 if nothing was left out.
    pub fn interval(&self) -> usize {
        if self.points.len() == self.samples { 1 } else { self.samples.div_ceil(self.points.len() / 2) }
    }

    /// The curve of `value(sample)`, one value per point. Values that are no numbers count only where there is nothing else.
    pub fn curve(&self, mut value: impl FnMut(usize) -> f64) -> Vec<f64> {
        if self.points.len() == self.samples {
            return (0..self.samples).map(value).collect();
        }
        let intervals = self.points.len() / 2;
        let mut curve = Vec::with_capacity(self.points.len());
        for interval in 0..intervals {
            let samples = interval * self.samples / intervals..(interval + 1) * self.samples / intervals;
            let (mut least, mut most) = ((f64::NAN, 0), (f64::NAN, 0));
            for sample in samples {
                let value = value(sample);
                if least.0.is_nan() || value < least.0 {
                    least = (value, sample);
                }
                if most.0.is_nan() || value > most.0 {
                    most = (value, sample);
                }
            }
            curve.extend(if least.1 <= most.1 { [least.0, most.0] } else { [most.0, least.0] });
        }
        curve
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_run_is_shown_as_it_is() {
        let grid = Grid::new(5, 10);
        assert_eq!((grid.points(), grid.interval()), (&[0, 1, 2, 3, 4][..], 1));
        assert_eq!(grid.curve(|k| k as f64), [0.0, 1.0, 2.0, 3.0, 4.0]);
        assert!(Grid::new(0, 10).curve(|_| 1.0).is_empty());
    }

    #[test]
    fn no_peak_is_lost() {
        let grid = Grid::new(8001, 2000);
        assert_eq!((grid.points().len(), grid.points()[0], grid.points()[1999], grid.interval()), (2000, 0, 8000, 9));
        assert!(grid.points().windows(2).all(|pair| pair[0] < pair[1]));
        for peak in [0, 1, 4003, 7999, 8000] {
            let curve = grid.curve(|k| if k == peak { 7.0 } else { (k % 2) as f64 });
            assert_eq!(curve.iter().filter(|value| **value == 7.0).count(), 1, "peak at {peak}");
            assert_eq!(curve.iter().copied().fold(f64::NAN, f64::min), 0.0);
        }
    }

    #[test]
    fn what_is_no_number_hides_nothing() {
        let grid = Grid::new(100, 10);
        let curve = grid.curve(|k| if k % 20 == 3 { 2.0 } else { f64::NAN });
        assert_eq!(curve, [2.0; 10]);
        assert!(grid.curve(|_| f64::NAN).iter().all(|value| value.is_nan()));
    }
}
