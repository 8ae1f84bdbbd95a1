//! Saturation, rounding, and checks of parameters.

/// `value` between the limits that there are; the upper one wins.
pub(super) fn saturated(value: f64, min: Option<f64>, max: Option<f64>) -> f64 {
    match (min, max) {
        (_, Some(max)) if value > max => max,
        (Some(min), _) if value < min => min,
        _ => value,
    }
}

/// The multiple of `quantum` that is next to `value`; halves go away from zero. A `quantum` of 0 changes nothing.
pub(super) fn quantised(value: f64, quantum: f64) -> f64 {
    let rounded = quantum * (value / quantum).round();
    if quantum > 0.0 && rounded.is_finite() { rounded } else { value }
}

/// What is wrong with parameters: field and message.
pub(super) type Findings = Vec<(&'static str, String)>;

pub(super) fn check_finite(findings: &mut Findings, fields: impl IntoIterator<Item = (&'static str, f64)>) {
    for (field, value) in fields {
        if !value.is_finite() {
            findings.push((field, format!("expected a finite number, found {value}")));
        }
    }
}

pub(super) fn check_not_negative(findings: &mut Findings, fields: impl IntoIterator<Item = (&'static str, f64)>) {
    for (field, value) in fields {
        if !(value.is_finite() && value >= 0.0) {
            findings.push((field, format!("expected a number >= 0, found {value}")));
        }
    }
}

pub(super) fn check_positive(findings: &mut Findings, field: &'static str, value: Option<f64>) {
    if let Some(value) = value
        && !(value.is_finite() && value > 0.0)
    {
        findings.push((field, format!("expected a number > 0, found {value}")));
    }
}

pub(super) fn check_limits(findings: &mut Findings, min: Option<f64>, max: Option<f64>) {
    check_finite(findings, [("min", min), ("max", max)].into_iter().filter_map(|(field, value)| Some((field, value?))));
    if let (Some(min), Some(max)) = (min, max)
        && min >= max
    {
        findings.push(("min", format!("expected a number < max = {max}, found {min}")));
    }
}
