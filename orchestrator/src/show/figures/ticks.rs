//! Where the ticks of an axis are and what stands beside them.

use super::picture::Label;

/// The ticks of an axis.
#[derive(Clone, Debug, Default)]
pub(super) struct Ticks {
    /// Values with a name.
    pub(super) named: Vec<(f64, Label)>,
    /// Values without one.
    pub(super) minor: Vec<f64>,
    /// A power of ten that all names are to be multiplied by.
    pub(super) factor: Option<Label>,
}

impl Ticks {
    /// Multiples of 1, 2 or 5 times a power of ten within `range`, in at most `most` steps, with equally many decimals.
    pub(super) fn linear([low, high]: [f64; 2], most: usize) -> Self {
        let step = step(high - low, most.max(2));
        let slack = 1e-9 * (high - low);
        let first = ((low - slack) / step).ceil() as i64;
        let values: Vec<f64> =
            (first..).map(|k| k as f64 * step).take_while(|value| *value <= high + slack).take(most + 2).collect();
        let largest = values.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        let exponent = if largest >= 1e4 || (step < 1e-3 && largest > 0.0) { exponent(largest) } else { 0 };
        let unit = 10_f64.powi(exponent);
        let decimals = (-f64::from(self::exponent(step / unit))).max(0.0) as usize;
        let named = values.iter().map(|value| (*value, Label::plain(&plain(value / unit, decimals)))).collect();
        let factor = (exponent != 0).then(|| Label::tex(&format!("$×10^{{{exponent}}}$")).unwrap_or_default());
        Self { named, minor: Vec::new(), factor }
    }

    /// All decades within `range`, whose ends are decades; every second, third, ... has a name if more than `most` would have one.
    pub(super) fn decades([low, high]: [f64; 2], most: usize) -> Self {
        const STEPS: i32 = 6;
        let [first, last] = [low, high].map(|end| end.log10().round() as i32);
        let stride = ((last - first) as f64 / most.max(2) as f64).ceil().max(1.0) as i32;
        let (mut named, mut minor) = (Vec::new(), Vec::new());
        for exponent in first..=last {
            let decade = 10_f64.powi(exponent);
            match exponent.rem_euclid(stride) {
                0 => named.push((decade, Label::power_of_ten(exponent))),
                _ => minor.push(decade),
            }
            if exponent < last && last - first <= STEPS {
                minor.extend((2..10).map(|k| f64::from(k) * decade));
            }
        }
        Self { named, minor, factor: None }
    }

    /// A row for each of these numbers, the first one at the height -1, the next at -2, ...
    pub(super) fn rows(numbers: &[u32]) -> Self {
        let row = |(index, number): (usize, &u32)| (-(index as f64) - 1.0, Label::plain(&number.to_string()));
        Self { named: numbers.iter().enumerate().map(row).collect(), ..Self::default() }
    }
}

/// The exponent of the first digit.
fn exponent(value: f64) -> i32 {
    (value.log10() + 1e-9).floor() as i32
}

/// The smallest of 1, 2, 5, 10, ... times a power of ten of which at most `most` fit into `length`.
fn step(length: f64, most: usize) -> f64 {
    let least = length / most as f64;
    let unit = 10_f64.powi(exponent(least));
    let fitting = [1.0, 2.0, 5.0].into_iter().find(|digit| digit * unit >= least * (1.0 - 1e-9));
    fitting.unwrap_or(10.0) * unit
}

/// A number with a true minus sign, and none before 0.
fn plain(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let digits = text.trim_start_matches('-');
    let is_zero = digits.chars().all(|c| c == '0' || c == '.');
    if text.starts_with('-') && !is_zero { format!("−{digits}") } else { digits.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(ticks: &Ticks) -> Vec<String> {
        ticks.named.iter().map(|(_, name)| name.letters()).collect()
    }

    #[test]
    fn numbers_of_an_axis_have_equally_many_decimals() {
        assert_eq!(names(&Ticks::linear([0.0, 80.0], 5)), ["0", "20", "40", "60", "80"]);
        assert_eq!(names(&Ticks::linear([-1.1, 1.2], 5)), ["−1.0", "−0.5", "0.0", "0.5", "1.0"]);
        assert_eq!(names(&Ticks::linear([0.1, 0.3], 4)), ["0.10", "0.15", "0.20", "0.25", "0.30"]);
        let large = Ticks::linear([0.0, 25_000.0], 3);
        assert_eq!(
            (names(&large), large.factor.map(|f| f.letters())),
            (vec!["0".into(), "1".into(), "2".into()], Some("×104".into()))
        );
        let small = Ticks::linear([0.0, 0.0009], 4);
        assert_eq!((names(&small).len(), small.factor.is_some()), (2, true));
    }

    #[test]
    fn decades_are_powers() {
        let ticks = Ticks::decades([1e-2, 10.0], 6);
        assert_eq!(names(&ticks), ["10−2", "10−1", "100", "101"]);
        assert_eq!(ticks.minor.len(), 3 * 8);
        let many = Ticks::decades([1e-12, 1.0], 5);
        assert_eq!(names(&many), ["10−12", "10−9", "10−6", "10−3", "100"]);
        assert_eq!(many.minor.len(), 8);
    }
}
