//! Operations on the history of a number over a run.

/// Sum of the squares of `values`.
pub fn square_sum(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum()
}

/// Euclidean norm.
pub fn norm(values: &[f64]) -> f64 {
    square_sum(values).sqrt()
}

/// Euclidean norm of `a - b`, over the shorter length.
pub fn norm_between(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// Sum of the absolute values of `a - b`, over the shorter length.
pub fn one_norm_between(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum()
}

/// Largest value; NaN if any value is NaN or there are none.
pub fn maximum(values: impl IntoIterator<Item = f64>) -> f64 {
    let larger = |a: f64, b: f64| if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) };
    values.into_iter().reduce(larger).unwrap_or(f64::NAN)
}

/// Largest value from sample `first` on.
pub fn maximum_from(history: &[f64], first: usize) -> f64 {
    maximum(history.iter().skip(first).copied())
}

/// The first sample from which on the history never exceeds `level`; `None` if the last one does.
pub fn first_below_for_good(history: &[f64], level: f64) -> Option<usize> {
    let above = history.iter().rposition(|value| value.is_nan() || *value > level);
    let first = above.map_or(0, |last| last + 1);
    (first < history.len()).then_some(first)
}

/// Middle value; the mean of the two middle ones if there is an even number. NaN if there are none.
pub fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let half = sorted.len() / 2;
    match sorted.len() {
        0 => f64::NAN,
        length if length % 2 == 1 => sorted[half],
        _ => 0.5 * (sorted[half - 1] + sorted[half]),
    }
}

/// Sum of the absolute changes between successive values.
pub fn total_variation(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values = values.into_iter();
    let Some(mut before) = values.next() else { return 0.0 };
    let mut sum = 0.0;
    for value in values {
        sum += (value - before).abs();
        before = value;
    }
    sum
}

/// Number of changes between successive states.
pub fn edges(states: impl IntoIterator<Item = bool>) -> usize {
    let mut states = states.into_iter();
    let Some(mut before) = states.next() else { return 0 };
    states.filter(|state| std::mem::replace(&mut before, *state) != *state).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settling_is_for_good() {
        assert_eq!(first_below_for_good(&[3.0, 0.5, 2.0, 0.5, 0.4], 1.0), Some(3));
        assert_eq!(first_below_for_good(&[0.1, 0.2], 1.0), Some(0));
        assert_eq!(first_below_for_good(&[0.1, 2.0], 1.0), None);
        assert_eq!(first_below_for_good(&[0.1, f64::NAN], 1.0), None);
    }

    #[test]
    fn middle_largest_and_variation() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), 2.5);
        assert!(maximum([1.0, f64::NAN, 3.0]).is_nan());
        assert_eq!(maximum_from(&[9.0, 1.0, 2.0], 1), 2.0);
        assert_eq!(total_variation([1.0, 3.0, 2.5]), 2.5);
        assert_eq!(one_norm_between(&[1.0, -2.0], &[0.5, 1.0]), 3.5);
        assert_eq!(edges([false, true, true, false, true]), 3);
        assert_eq!(edges([]), 0);
    }
}
