//! A curve in one line of text.

/// Characters from low to high, for terminals that have them and for those that do not.
const BLOCKS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
const PLAIN: [char; 8] = ['.', ':', '-', '=', '+', '*', '#', '@'];

/// `values` as `width` characters on a logarithmic scale from `low` to `high`; each stands for the largest of its share.
pub(super) fn sparkline(values: &[f64], width: usize, [low, high]: [f64; 2], blocks: bool) -> String {
    let ramp = if blocks { BLOCKS } else { PLAIN };
    let columns = width.min(values.len());
    let span = (high / low).ln();
    let level = |value: f64| {
        let share = if span > 0.0 { (value / low).ln() / span } else { 0.5 };
        (share * ramp.len() as f64).floor().clamp(0.0, ramp.len() as f64 - 1.0) as usize
    };
    (0..columns)
        .map(|column| {
            let (from, to) = (column * values.len() / columns, (column + 1) * values.len() / columns);
            let largest = values[from..to].iter().copied().filter(|value| value.is_finite()).fold(f64::NAN, f64::max);
            if largest.is_nan() { ' ' } else { ramp[level(largest)] }
        })
        .collect()
}

/// Smallest and largest value > 0 of all lists.
pub(super) fn range<'a>(lists: impl IntoIterator<Item = &'a [f64]>) -> [f64; 2] {
    let values = lists.into_iter().flatten().copied().filter(|value| value.is_finite() && *value > 0.0);
    let [low, high] = values.fold([f64::INFINITY, 0.0], |[low, high], value| [low.min(value), high.max(value)]);
    if low <= high { [low, high] } else { [1.0, 1.0] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_decade_is_as_high_as_any_other() {
        let values = [1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6, 1e7];
        let limits = range([&values[..]]);
        assert_eq!(limits, [1.0, 1e7]);
        assert_eq!(sparkline(&values, 8, limits, true), "▁▂▃▄▅▆▇█");
        assert_eq!(sparkline(&values, 8, limits, false), ".:-=+*#@");
        assert_eq!(sparkline(&values, 2, limits, true), "▄█");
        assert_eq!(sparkline(&[0.0, f64::NAN, 1.0], 3, limits, true), "▁ ▁");
        assert_eq!(sparkline(&[], 8, range([]), true), "");
    }
}
