//! Time derivatives of formulas: against closed forms and against finite differences.

use std::f64::consts::PI;

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
const SMOOTH: [&str; 39] = [
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
    "hypot(sin(t), t^2)",
    "hypot(1 - 3*t, 2)",
    "mod(3*t^2, 0.4)",
    "mod(-sin(t), 0.2 + t)",
    "wrap(20*t)*t",
    "floor(7.5*t)*t - ceil(-3*t^2)*t^3",
    "t*step(t - 0.4) + t^2*pulse(t, 0.4, 0.2)",
    "clip(t^2, 0.1, 0.4) + clamp(-t, -0.6, 0)",
    "noise(3, t, 0.4)*t^2",
    "if(t < 0.4 or t > 0.6, sin(t), t^3)",
    "if(0.2 < t^2 < 0.3, if(t > 0, cos(t), 1/0), ln(1 + t))",
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
        ("if(t < 1, 7*t, t^2)", 1.0, jet(1.0, 2.0, 2.0, 0.0)),
        ("if(t <= 1, 7*t, t^2)", 1.0, jet(7.0, 2.0, 2.0, 0.0)),
        ("if(1 < t, t^2, 7*t)", 1.0, jet(7.0, 2.0, 2.0, 0.0)),
        ("if(not 1 >= t, t^2, 7*t)", 1.0, jet(7.0, 2.0, 2.0, 0.0)),
        ("if(t^2 <= 2*t - 1, 1/0, t)", 2.0, jet(2.0, 1.0, 0.0, 0.0)),
        // The parabola is above its tangent, which shows in the second derivative.
        ("if(t^2 <= 2*t - 1, t, 7*t)", 1.0, jet(1.0, 7.0, 0.0, 0.0)),
        ("if(t >= 1 and t <= 2, t^2, 0*t)", 2.0, jet(4.0, 0.0, 0.0, 0.0)),
        ("if(not_finite(1/t), 0, 1/t)", 2.0, jet(0.5, -0.25, 0.25, -0.375)),
        ("floor(t)*t", 3.0, jet(9.0, 3.0, 0.0, 0.0)),
        ("floor(-t)*t", 3.0, jet(-9.0, -4.0, 0.0, 0.0)),
        ("ceil(t)*t", 3.0, jet(9.0, 4.0, 0.0, 0.0)),
        ("ceil(-t)*t", 3.0, jet(-9.0, -3.0, 0.0, 0.0)),
        ("mod(t, 3)*t", 6.0, jet(0.0, 6.0, 2.0, 0.0)),
        ("mod(-t, 3)*t", 6.0, jet(0.0, -3.0, -2.0, 0.0)),
        ("mod(7, t)", 7.0, jet(0.0, 0.0, 0.0, 0.0)),
        ("step(t - 1)*t^2", 1.0, jet(1.0, 2.0, 2.0, 0.0)),
        ("step(1 - t)*t^2", 1.0, jet(1.0, 0.0, 0.0, 0.0)),
        ("pulse(t, 1, 2)*t", 1.0, jet(1.0, 1.0, 0.0, 0.0)),
        ("pulse(t, 1, 2)*t", 3.0, jet(0.0, 0.0, 0.0, 0.0)),
        ("hypot(3*t - 3, 4 - 4*t)", 1.0, jet(0.0, 5.0, 0.0, 0.0)),
        ("hypot((t - 1)^2, 0)", 1.0, jet(0.0, 0.0, 2.0, 0.0)),
        ("hypot(0*t, (1 - t)^3)", 1.0, jet(0.0, 0.0, 0.0, 6.0)),
        ("clip(3*t, 0, 3)", 1.0, jet(3.0, 0.0, 0.0, 0.0)),
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
        "if(t < 2, t, 4 - t)",
        "if(1 <= t < 3 and not t < 2 or t >= 4, t, -t)",
        "if(floor(t) <= 1, mod(t, 2), 2*mod(-t, 3))",
        "ceil(t)*(t - 1) + floor(2 - t)*t",
        "pulse(t, 1, 2)*t - step(t - 2)*(t + 1)",
        "clip(2*t, 2, 6) + hypot(3*(t - 2), 4*(t - 2))",
        "if(step(t - 2) > 0, 1, mod(t, 1))",
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
fn an_angle_goes_on_at_half_a_turn() {
    let found = at("wrap(t)", PI);
    assert_eq!(found, jet(PI, 1.0, 0.0, 0.0));
    let found = at("wrap(t)*t", PI);
    assert_eq!((found.value, found.rate), (PI * PI, 0.0));
    let found = at("wrap(-t)*t", PI);
    assert_eq!((found.value, found.rate), (PI * PI, 0.0), "-pi is pi, and goes down from there");
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

    /// Polynomials in the branches, and everything that may choose between them: the derivatives are those of the polynomial
    /// that holds just after the instant.
    #[test]
    fn branches_have_their_own_derivatives(from in -3..3_i32, to in -3..3_i32, quarter in -16..16_i32, choice in 0..6_usize) {
        let condition = [
            format!("t < {from}"),
            format!("{from} <= t < {to}"),
            format!("t <= {from} or not t <= {to}"),
            format!("mod(t, 3) > {from} and floor(t) <= {to}"),
            format!("ceil(t) < {from} or wrap(t) >= 0"),
            format!("abs(t - {from}) > abs(t - {to}) or step({to} - t) > 0 and pulse(t, {from}, 2) < 1"),
        ];
        let condition = &condition[choice];
        let t = f64::from(quarter) / 4.0;
        let holds = |t: f64| formula(&format!("if({condition}, 1, 0)"), &["t"]).evaluate(&[t]) == 1.0;
        let branch = |holds: bool| at(if holds { "t^3 - t" } else { "2 - 3*t^2" }, t);
        let found = at(&format!("if({condition}, t^3 - t, 2 - 3*t^2)"), t);
        prop_assert_eq!(found, Jet { value: branch(holds(t)).value, ..branch(holds(t + 1e-9)) }, "{} at {}", condition, t);
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
