//! Time derivatives of formulas: against closed forms and against finite differences.

use proptest::prelude::*;

use super::{components, formula, jet};
use crate::formula::Jet;

/// The jet of a formula of t.
fn at(text: &str, t: f64) -> Jet {
    formula(text, &["t"]).evaluate_jet(&[Jet::time(t)])
}

fn assert_close(found: Jet, expected: [f64; 4], tolerance: f64, what: &str) {
    for (found, expected) in components(found).into_iter().zip(expected) {
        let error = (found - expected).abs();
        assert!(error <= tolerance * (1.0 + expected.abs()), "{what}: {found:e}, not {expected:e}");
    }
}

/// Smooth on [0.2, 0.8], every function and operator among them.
const SMOOTH: [&str; 28] = [
    "t + 2*t - 3/t",
    "sin(2*t)/(1 + t^2)",
    "cos(3*t)*exp(-t)",
    "tan(t)",
    "asin(t^2)",
    "acos(0.8*t)",
    "atan(3*t)",
    "atan2(sin(t), 0.3 + t^2)",
    "atan2(1, t)",
    "atan2(t, 2)",
    "sinh(2*t)",
    "cosh(2*t)",
    "tanh(2*t)",
    "exp(sin(3*t))",
    "ln(1 + t^2)",
    "sqrt(t + t^3)",
    "abs(t - 2)*abs(t + 1)",
    "sign(t)*t^2",
    "min(t^2, t)",
    "max(sin(t), exp(t))",
    "sig(t, 1.5)",
    "sig(-t, 0.5)",
    "sig(t - 2, 2)",
    "sig(t - 2, 1 + t)",
    "(1 + t)^-2.5",
    "(1 + t)^t",
    "2^(t^2)",
    "-(t - 3)^5 + (t - 3)^9",
];

#[test]
fn derivatives_agree_with_central_differences() {
    // Of eighth order: the error is below 1e-21 times the ninth derivative.
    let (step, weights) = (0.004, [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0]);
    for text in SMOOTH {
        for t in [0.3, 0.5, 0.75] {
            let mut slopes = [0.0; 4];
            for (index, weight) in weights.into_iter().enumerate() {
                let distance = (index + 1) as f64 * step;
                let (after, before) = (components(at(text, t + distance)), components(at(text, t - distance)));
                for (slope, (after, before)) in slopes.iter_mut().zip(after.into_iter().zip(before)) {
                    *slope += weight * (after - before) / step;
                }
            }
            let found = at(text, t);
            let expected = [formula(text, &["t"]).evaluate(&[t]), slopes[0], slopes[1], slopes[2]];
            assert_close(found, expected, 1e-8, &format!("{text} at {t}"));
        }
    }
}

#[test]
fn polynomials_are_exact() {
    assert_eq!(at("t^3 - 2*t^2 + 5", 2.0), jet(5.0, 4.0, 8.0, 6.0));
    assert_eq!(at("t*t*t", 0.0), jet(0.0, 0.0, 0.0, 6.0));
    assert_eq!(at("t^2", 0.0), jet(0.0, 0.0, 2.0, 0.0));
    assert_eq!(at("1/t", 1.0), jet(1.0, -1.0, 2.0, -6.0));
    assert_eq!(at("(-t)^3", 1.0), jet(-1.0, -3.0, -6.0, -6.0));
}

#[test]
fn the_active_branch_counts() {
    assert_eq!(at("abs(t)", -2.0), jet(2.0, -1.0, 0.0, 0.0));
    assert_eq!(at("sign(t)", -2.0), Jet::constant(-1.0));
    assert_eq!(at("min(t, t^2)", 0.5), jet(0.25, 1.0, 2.0, 0.0));
    assert_eq!(at("max(t, t^2)", 0.5), Jet::time(0.5));
    assert_eq!(at("sig(t, 2)", -1.0), jet(-1.0, 2.0, -2.0, 0.0));
    assert_eq!(at("sig(t, 1)", 0.0), Jet::time(0.0));
    assert_eq!(at("sig(t, 3)", 0.0), jet(0.0, 0.0, 0.0, 6.0));
}

#[test]
fn at_a_switch_derivatives_are_those_to_the_right() {
    for (text, t, expected) in [
        ("0.5*min(t, 2) + 0.5*max(t - 2, 0)", 2.0, jet(1.0, 0.5, 0.0, 0.0)),
        ("max(t, 1) + min(t, 1)", 1.0, jet(2.0, 1.0, 0.0, 0.0)),
        ("min(1, t) + max(1, t)", 1.0, jet(2.0, 1.0, 0.0, 0.0)),
        ("abs(t - 1)", 1.0, jet(0.0, 1.0, 0.0, 0.0)),
        ("abs(1 - t)", 1.0, jet(0.0, 1.0, 0.0, 0.0)),
        ("-abs(t - 1)", 1.0, jet(-0.0, -1.0, 0.0, 0.0)),
        ("sign(t - 1)*(t - 1)", 1.0, jet(0.0, 1.0, 0.0, 0.0)),
        ("(1 + sign(t - 1))/2*(t + 3)", 1.0, jet(2.0, 1.0, 0.0, 0.0)),
        ("sig(t, 2)", 0.0, jet(0.0, 0.0, 2.0, 0.0)),
        ("sig(-t, 2)", 0.0, jet(-0.0, -0.0, -2.0, -0.0)),
        // The values and the slopes are equal, and what decides is the second, or the third derivative.
        ("max(t^2, 2*t - 1)", 1.0, jet(1.0, 2.0, 2.0, 0.0)),
        ("min(t^2, 2*t - 1)", 1.0, jet(1.0, 2.0, 0.0, 0.0)),
        ("max((t - 1)^3, 0)", 1.0, jet(0.0, 0.0, 0.0, 6.0)),
        ("min((t - 1)^3, 0)", 1.0, jet(0.0, 0.0, 0.0, 0.0)),
        ("abs((t - 1)^2*(2 - t))", 2.0, jet(0.0, 1.0, 4.0, 6.0)),
        ("min(sin(t), t)", 0.0, jet(0.0, 1.0, 0.0, -1.0)),
        // Both operands are the same, and nothing switches.
        ("max(2*t, t + t) + min(t, t)", 1.0, jet(3.0, 3.0, 0.0, 0.0)),
        ("sign(0*t)", 1.0, jet(0.0, 0.0, 0.0, 0.0)),
    ] {
        assert_eq!(at(text, t), expected, "{text} at {t}");
        assert_eq!(at(text, t).value.to_bits(), formula(text, &["t"]).evaluate(&[t]).to_bits(), "{text} at {t}");
    }
}

#[test]
fn nested_switches_have_the_slope_to_the_right() {
    // Linear between the whole numbers, so that the slope to the right can be read off two points there.
    for text in [
        "min(max(t, 1), 3) - abs(t - 2)",
        "abs(abs(t - 2) - 1)",
        "max(min(t, 2*t - 2), min(4 - t, 2))",
        "sign(t - 1)*min(t, 2) + sign(t - 2)*max(t, 3)",
        "abs(max(t - 1, 0) - max(t - 3, 0))*(1 - sign(2 - t))/2",
        "min(min(t, 1), min(t - 1, 3 - t))",
        "sig(t - 2, 1) + sig(max(t - 1, 0), 1)",
        "min(t, 1)*sign(max(t - 2, 0))",
    ] {
        for whole in 0..5 {
            let (t, found) = (f64::from(whole), at(text, f64::from(whole)));
            let value = |t: f64| formula(text, &["t"]).evaluate(&[t]);
            let slope = (value(t + 0.75) - value(t + 0.25)) / 0.5;
            assert_eq!((found.rate, found.acceleration, found.jerk), (slope, 0.0, 0.0), "{text} at {t}");
            assert_eq!(found.value, value(t), "{text} at {t}");
        }
    }
}

#[test]
fn constants_have_no_derivatives_even_where_slopes_are_infinite() {
    let of_zero = |text: &str| formula(text, &["x", "t"]).evaluate_jet(&[Jet::constant(0.0), Jet::time(1.5)]);
    for text in ["sqrt(x)", "sig(x, 0.5)", "abs(x)^0.5", "asin(x + 1)", "exp(-1/x)", "sig(x, t)", "x^t"] {
        let found = of_zero(text);
        assert_eq!(found, Jet::constant(found.value), "{text}");
    }
    assert_eq!(of_zero("t + sqrt(x)"), Jet::time(1.5));
    assert_eq!(at("sqrt(t)", 0.0).rate, f64::INFINITY);
}

proptest! {
    #[test]
    fn a_circle_has_its_closed_form(w in -5.0..5.0, c in -3.2..3.2, t in 0.0..20.0) {
        let slots = [Jet::constant(w), Jet::constant(c), Jet::time(t)];
        let found = formula("3*cos(w*t + c)", &["w", "c", "t"]).evaluate_jet(&slots);
        let (sine, cosine) = (libm::sin(w * t + c), libm::cos(w * t + c));
        let expected = [3.0 * cosine, -3.0 * w * sine, -3.0 * w * w * cosine, 3.0 * w * w * w * sine];
        assert_close(found, expected, 1e-14, "circle");
    }

    #[test]
    fn inverse_functions_cancel(value in 0.1..0.9, rate in -2.0..2.0, acceleration in -2.0..2.0, jerk in -2.0..2.0) {
        let x = jet(value, rate, acceleration, jerk);
        for text in [
            "sin(asin(x))", "cos(acos(x))", "tan(atan(x))", "exp(ln(x))", "sqrt(x)^2", "sqrt(x^2)", "1/(1/x)",
            "(x^0.3)^(1/0.3)", "sig(sig(x, 0.3), 1/0.3)", "tan(atan2(x, 1))", "atan2(sin(x), cos(x))",
            "sinh(x)/cosh(x) - tanh(x) + x", "sin(x)^2 + cos(x)^2 + x - 1", "cosh(x)^2 - sinh(x)^2 + x - 1",
            "exp(0.5*ln(x)) - x^0.5 + x", "exp(x*ln(x)) - x^x + x", "-sig(-x, x) - x^x + x",
        ] {
            assert_close(formula(text, &["x"]).evaluate_jet(&[x]), components(x), 1e-8, text);
        }
    }
}
