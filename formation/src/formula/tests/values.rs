//! What formulas evaluate to.

use std::f64::consts::PI;

use proptest::prelude::*;

use super::{components, formula, jet, same_bits};
use crate::formula::{Expression, Jet, Operand};

const NAMES: [&str; 4] = ["a", "b", "c", "d"];

type Closure = fn([f64; 4]) -> f64;

/// Formulas and what they must give, bit for bit.
const CLOSURES: [(&str, Closure); 19] = [
    ("3*cos(0.08*a + (b-1)*pi/3)", |[a, b, ..]| 3.0 * libm::cos(0.08 * a + (b - 1.0) * PI / 3.0)),
    ("0.5*sin(a) + tanh(a) - 1.4*exp(-abs(b) - 1)", |[a, b, ..]| {
        0.5 * libm::sin(a) + libm::tanh(a) - 1.4 * libm::exp(-b.abs() - 1.0)
    }),
    ("((a-b)/c)*d*a", |[a, b, c, d]| ((a - b) / c) * d * a),
    ("a - b - c + d", |[a, b, c, d]| a - b - c + d),
    ("a/b/c*d", |[a, b, c, d]| a / b / c * d),
    ("-a^2 + b^3", |[a, b, ..]| -(a * a) + b * b * b),
    ("a^8 - a^9", |[a, ..]| a * a * a * a * a * a * a * a - libm::pow(a, 9.0)),
    ("abs(a)^0.5 + b^-2", |[a, b, ..]| libm::pow(a.abs(), 0.5) + libm::pow(b, -2.0)),
    ("sig(a, 0.5) + sig(b, 3)", |[a, b, ..]| {
        a.signum() * libm::pow(a.abs(), 0.5) + b.signum() * (b.abs() * b.abs() * b.abs())
    }),
    ("atan2(a, b) + atan(c)", |[a, b, c, _]| libm::atan2(a, b) + libm::atan(c)),
    ("asin(a/3) - acos(b/3)*tan(c)", |[a, b, c, _]| libm::asin(a / 3.0) - libm::acos(b / 3.0) * libm::tan(c)),
    ("sinh(a) + cosh(b)", |[a, b, ..]| libm::sinh(a) + libm::cosh(b)),
    ("sqrt(abs(a)) + ln(abs(b))", |[a, b, ..]| a.abs().sqrt() + libm::log(b.abs())),
    ("hypot(a, b) + floor(c) - ceil(d)", |[a, b, c, d]| libm::hypot(a, b) + c.floor() - d.ceil()),
    ("clip(a, b, c) + clamp(d, 0, 1)", |[a, b, c, d]| a.max(b).min(c) + d.clamp(0.0, 1.0)),
    ("if(a < b, c, d) - if(a < b or c <= d, a, if(c > 1, 2, 3))", |[a, b, c, d]| {
        (if a < b { c } else { d })
            - if a < b || c <= d {
                a
            } else if c > 1.0 {
                2.0
            } else {
                3.0
            }
    }),
    ("if(not (a < b < c and d > 0), 5, a)", |[a, b, c, d]| if a < b && b < c && d > 0.0 { a } else { 5.0 }),
    ("step(a)*pulse(b, c, d)", |[a, b, c, d]| {
        f64::from(u8::from(a >= 0.0)) * f64::from(u8::from(0.0 <= b - c && b - c < d))
    }),
    ("min(a, b)*max(c, d) + sign(a)", |[a, b, c, d]| a.min(b) * c.max(d) + a.signum()),
];

/// Formulas of the four names, without numbers, so that nothing folds while all four are slots.
fn any_formula() -> impl Strategy<Value = String> {
    let unary = "(-|sin|cos|tan|asin|acos|atan|sinh|cosh|tanh|exp|ln|sqrt|abs|sign|floor|ceil|wrap|step)";
    "[abcd]".prop_recursive(6, 40, 2, move |inner| {
        prop_oneof![
            (inner.clone(), "[-+*/^]", inner.clone())
                .prop_map(|(left, operator, right)| format!("({left}{operator}{right})")),
            (unary, inner.clone()).prop_map(|(name, argument)| format!("{name}({argument})")),
            ("(atan2|min|max|sig|mod|hypot)", inner.clone(), inner.clone())
                .prop_map(|(name, first, second)| format!("{name}({first}, {second})")),
            ("(clip|pulse|noise)", inner.clone(), inner.clone(), inner.clone())
                .prop_map(|(name, first, second, third)| format!("{name}({first}, {second}, {third})")),
            ("(<|<=|>|>=)", inner.clone(), "[abcd]", inner.clone(), inner).prop_map(
                |(relation, left, right, yes, no)| {
                    format!("if({left} {relation} {right} or not_finite({right}), {yes}, {no})")
                }
            ),
        ]
    })
}

fn any_values() -> impl Strategy<Value = [f64; 4]> {
    let special = prop::sample::select(vec![0.0, -0.0, 1.0, 2.0, 3.0, -1.0, 1e300, f64::INFINITY, f64::NAN]);
    prop::array::uniform4(prop_oneof![3 => -3.0..3.0, 1 => special])
}

#[test]
fn sign_and_sig_vanish_at_zero() {
    let value = |text: &str, x: f64| formula(text, &["x"]).evaluate(&[x]);
    for zero in [0.0, -0.0] {
        for text in ["sign(x)", "sig(x, 0.5)", "sig(x, 0)", "sig(x, -1)", "sig(x, 2)", "sig(x, x)"] {
            assert_eq!(value(text, zero).to_bits(), 0.0_f64.to_bits(), "{text} at {zero}");
        }
    }
    assert_eq!((value("sign(x)", -0.1), value("sign(x)", 7.0)), (-1.0, 1.0));
    assert_eq!((value("sig(x, 2)", -3.0), value("sig(x, 0.5)", -4.0)), (-9.0, -2.0));
}

#[test]
fn nothing_hides_what_is_not_a_number() {
    for text in [
        "min(x, 1)",
        "min(1, x)",
        "max(x, 1)",
        "max(1, x)",
        "sign(x)",
        "abs(x)",
        "sig(x, 2)",
        "floor(x)",
        "ceil(x)",
        "mod(x, 1)",
        "mod(1, x)",
        "wrap(x)",
        "step(x)",
        "pulse(x, 0, 1)",
        "pulse(0, x, 1)",
        "pulse(0, 0, x)",
        "clip(x, 0, 1)",
        "clip(0, x, 1)",
        "clip(0, 1, x)",
        "hypot(x, 1)",
        "noise(x, 0, 1)",
        "noise(0, x, 1)",
        "noise(0, 1, x)",
        "if(1 < 2, x, 0)",
    ] {
        assert!(formula(text, &["x"]).evaluate(&[f64::NAN]).is_nan(), "{text}");
    }
    // It does not come out of the branch that is not taken, and no comparison holds with it.
    for text in [
        "if(x < 1, x, 3)",
        "if(not x < 1, x, 3)",
        "if(not_finite(x), 3, x)",
        "if(1 < 2, 3, x)",
        "if(not not_finite(x), x, 3)",
    ] {
        let jet = formula(text, &["x"]).evaluate_jet(&[Jet::time(f64::NAN)]);
        assert_eq!((formula(text, &["x"]).evaluate(&[f64::NAN]), jet), (3.0, Jet::constant(3.0)), "{text}");
    }
}

#[test]
fn remainders_have_the_sign_of_the_divisor() {
    let value = |text: &str| Expression::parse(text).unwrap().constant().unwrap();
    for (text, expected) in [
        ("mod(7, 3)", 1.0),
        ("mod(-7, 3)", 2.0),
        ("mod(7, -3)", -2.0),
        ("mod(-7, -3)", -1.0),
        ("mod(5.5, 2)", 1.5),
        ("mod(6, 3)", 0.0),
        ("floor(-0.5)", -1.0),
        ("ceil(0.5)", 1.0),
        ("wrap(pi)", PI),
        ("wrap(-pi)", PI),
        ("wrap(1.5*pi)", -0.5 * PI),
        ("wrap(-1.5*pi)", 0.5 * PI),
        ("wrap(0.25)", 0.25),
        ("step(0)", 1.0),
        ("step(-1e-300)", 0.0),
        ("pulse(2, 2, 1)", 1.0),
        ("pulse(3, 2, 1)", 0.0),
        ("pulse(2, 2, -1)", 0.0),
        ("clip(5, 0, 1)", 1.0),
        ("hypot(3, 4)", 5.0),
    ] {
        assert_eq!(value(text), expected, "{text}");
    }
    assert!(value("mod(1, 0)").is_nan());
    assert!((value("hypot(3e200, 4e200)") / 5e200 - 1.0).abs() < 1e-15, "squares would overflow");
}

#[test]
fn noise_is_held_over_its_period() {
    let noise = formula("noise(k, t, 0.1)", &["k", "t"]);
    // Times of steps and decimal numbers belong to the interval that is meant.
    for interval in 0..1000 {
        let value = noise.evaluate(&[1.0, f64::from(interval) / 10.0]);
        for t in [f64::from(interval) * 0.1, 0.1 * f64::from(interval) + 0.05, 0.1 * f64::from(interval) + 0.0999] {
            assert_eq!(noise.evaluate(&[1.0, t]).to_bits(), value.to_bits(), "{t}");
        }
        assert_eq!(
            noise.evaluate_jet(&[Jet::constant(1.0), Jet::time(f64::from(interval) * 0.1)]),
            Jet::constant(value)
        );
        assert_ne!(noise.evaluate(&[2.0, f64::from(interval) / 10.0]), value);
        assert_ne!(noise.evaluate(&[1.0, f64::from(interval + 1) / 10.0]), value);
    }
}

#[test]
fn a_branch_that_constants_choose_is_all_there_is() {
    let expression = Expression::parse("if(i < 2, x, y*x)").unwrap();
    let compiled = |i: f64| {
        expression.compile(|name| {
            Some(if name == "i" { Operand::Constant(i) } else { Operand::Slot(usize::from(name == "y")) })
        })
    };
    assert!(!compiled(1.0).unwrap().uses_slot(1) && compiled(2.0).unwrap().uses_slot(1));
    assert_eq!(compiled(2.0).unwrap().evaluate(&[3.0, 4.0]), 12.0);
    let whole = "if(t < 1, sin(t), if(x < sin(t), cos(t) + 1, x*exp(t)))";
    let (rest, parts) = formula(whole, &["t", "x"]).extract(0, 2);
    assert_eq!(parts.len(), 5, "the condition, the branch, three parts of the other");
    assert!(!rest.uses_slot(0));
}

#[test]
fn constants_and_slots_can_be_asked_for() {
    let expression = Expression::parse("2*gain + 1").unwrap();
    let folded = expression.compile(|_| Some(Operand::Constant(3.0))).unwrap();
    assert_eq!((folded.as_constant(), folded.uses_slot(0)), (Some(7.0), false));
    let open = expression.compile(|_| Some(Operand::Slot(5))).unwrap();
    assert_eq!((open.as_constant(), open.uses_slot(5), open.uses_slot(4)), (None, true, false));
    // A sub-expression that is constant folds on.
    let outer = Expression::parse("f^2").unwrap().compile(|_| Some(Operand::Formula(folded.clone()))).unwrap();
    assert_eq!(outer.as_constant(), Some(49.0));
}

#[test]
fn what_depends_on_time_alone_is_taken_out() {
    let (rest, parts) = formula("0.6*sin(0.3*a + 1) - 2*b + a*b*(a + 1)", &NAMES).extract(0, 4);
    assert_eq!(parts.len(), 2);
    assert!(!parts.iter().any(|part| part.uses_slot(1)) && [0, 1, 4, 5].iter().all(|slot| rest.uses_slot(*slot)));
    let (rest, parts) = formula("a + b", &NAMES).extract(0, 4);
    assert!(parts.is_empty() && rest.uses_slot(0), "a mere slot is no part");
    let (rest, parts) = formula("cos(a)", &NAMES).extract(0, 4);
    assert!(parts.len() == 1 && rest.uses_slot(4) && !rest.uses_slot(0));
}

proptest! {
    #[test]
    fn taking_parts_out_changes_no_bit(text in any_formula(), values in any_values()) {
        let whole = formula(&text, &NAMES);
        let (rest, parts) = whole.extract(0, 4);
        let mut slots = values.to_vec();
        slots.extend(parts.iter().map(|part| part.evaluate(&values[..1])));
        prop_assert!(same_bits(whole.evaluate(&values), rest.evaluate(&slots)));
    }

    #[test]
    fn sine_and_cosine_have_the_same_bits_together_and_alone(angle in -1e4..1e4, small in any::<f64>()) {
        for x in [angle, small] {
            let (sine, cosine) = libm::sincos(x);
            prop_assert!(same_bits(sine, libm::sin(x)) && same_bits(cosine, libm::cos(x)), "{x:e}");
        }
    }

    #[test]
    fn formulas_are_what_a_programmer_would_write(values in prop::array::uniform4(-3.0..3.0)) {
        for (text, closure) in CLOSURES {
            let (found, expected) = (formula(text, &NAMES).evaluate(&values), closure(values));
            prop_assert!(same_bits(found, expected), "{text}: {found:e}, not {expected:e}");
        }
    }

    #[test]
    fn folding_changes_no_bit(text in any_formula(), values in any_values(), folded in any::<[bool; 4]>()) {
        let plain = formula(&text, &NAMES);
        let resolve = |name: &str| {
            let index = NAMES.iter().position(|known| *known == name)?;
            Some(if folded[index] { Operand::Constant(values[index]) } else { Operand::Slot(index) })
        };
        let partly = Expression::parse(&text).unwrap().compile(resolve).unwrap();
        prop_assert!(same_bits(plain.evaluate(&values), partly.evaluate(&values)));
        let slots: [Jet; 4] = std::array::from_fn(|index| match folded[index] {
            true => Jet::constant(values[index]),
            false => jet(values[index], 1.5, -0.5, 0.25),
        });
        let pairs = components(plain.evaluate_jet(&slots)).into_iter().zip(components(partly.evaluate_jet(&slots)));
        for (first, second) in pairs {
            prop_assert!(same_bits(first, second), "{first:e} and {second:e}");
        }
    }

    #[test]
    fn jets_have_the_value_of_numbers(text in any_formula(), values in any_values()) {
        let formula = formula(&text, &NAMES);
        let jets = values.map(|value| jet(value, 1.0, 2.0, 3.0));
        let (number, value) = (formula.evaluate(&values), formula.evaluate_jet(&jets).value);
        prop_assert!(same_bits(number, value), "{number:e} and {value:e}");
    }

    #[test]
    fn a_named_part_is_as_good_as_its_value(outer in any_formula(), inner in any_formula(), values in any_values()) {
        let part = formula(&inner, &NAMES);
        let resolve = |name: &str| match name {
            "a" => Some(Operand::Formula(part.clone())),
            _ => NAMES.iter().position(|known| *known == name).map(Operand::Slot),
        };
        let found = Expression::parse(&outer).unwrap().compile(resolve).unwrap().evaluate(&values);
        let expected = formula(&outer, &NAMES).evaluate(&[part.evaluate(&values), values[1], values[2], values[3]]);
        prop_assert!(same_bits(found, expected), "{found:e}, not {expected:e}");
    }
}
