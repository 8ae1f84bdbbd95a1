//! Comparisons and how they are joined.

use proptest::prelude::*;

use crate::formula::{Condition, Cursor, Expression, FormulaError, Operand, Operands};

/// `x`, `y` and `z` are slots.
fn condition(text: &str) -> Condition {
    let slot = |name: &str| ["x", "y", "z"].iter().position(|known| *known == name).map(Operand::Slot);
    Condition::parse(text, &mut (), slot).unwrap_or_else(|error| panic!("{text}: {error}"))
}

#[track_caller]
fn refused(text: &str, offset: usize, part: &str) {
    let error = Condition::parse(text, &mut (), |_| Some(Operand::Slot(0))).expect_err(text);
    assert!(error.offset == offset && error.message.contains(part), "{text}: {} {error}", error.offset);
}

#[test]
fn relations_are_those_of_numbers() {
    for (text, holds) in [
        ("x < y", true),
        ("x < 1", false),
        ("x <= 1", true),
        ("x > 1", false),
        ("x >= 1", true),
        ("x < y < 3", true),
        ("x < y < 2", false),
        ("2 < y < 3", false),
        ("2*x + 1 > y^2 - 2", true),
        ("z < 1", false),
        ("z >= 1", false),
        ("min(z, 1) < 2 or max(1, z) > 0", false),
        ("not_finite(z) and not_finite(1/0)", true),
        ("not_finite(x)", false),
    ] {
        assert_eq!(condition(text).holds(&[1.0, 2.0, f64::NAN]), holds, "{text}");
    }
}

#[test]
fn and_binds_more_tightly_than_or() {
    for (text, holds) in [
        ("1 < 2 or 1 < 2 and 2 < 1", true),
        ("(1 < 2 or 1 < 2) and 2 < 1", false),
        ("((x)) < (3) and (x + 1) * 2 < 7", true),
        ("not 2 < 1 and 1 < 2", true),
        ("not (1 < 2 or 2 < 1)", false),
        ("not not x < 3", true),
        ("not 0 < x < 1", true),
        ("not x < 1/0 - 1/0 or not x >= 1/0 - 1/0", false),
        ("not not_finite(x) and not (not_finite(1/0) and 1 > 2)", true),
        ("if(x > 0.5, 2, 3) < 2.5 and x < 3", true),
    ] {
        assert_eq!(condition(text).holds(&[1.0]), holds, "{text}");
    }
}

#[test]
fn margins_are_distances_to_the_other_verdict() {
    let margin = |text: &str| condition(text).margin(&[1.0, 3.0, f64::NAN]);
    assert_eq!(margin("x < y"), 2.0);
    assert_eq!(margin("x > y"), -2.0);
    assert_eq!(margin("0 < x < 1.5"), 0.5);
    assert_eq!(margin("x < 0 or y < 7"), 4.0);
    assert_eq!(margin("x < z"), f64::NEG_INFINITY);
    assert_eq!(margin("1/0 <= 1/0"), 0.0);
    assert_eq!(margin("not_finite(z)"), f64::INFINITY);
    assert_eq!(margin("not (x < y and x > 0)"), -1.0);
    assert_eq!(margin("not x < z"), f64::NEG_INFINITY);
    assert_eq!((margin("x < 1"), condition("x < 1").holds(&[1.0])), (0.0, false));
}

#[test]
fn comparisons_are_told_as_written() {
    let condition = condition("1 < x  and (y >= 100 * x or not_finite(x))");
    let comparisons = condition.comparisons(&[2.0, 6.0]);
    let [first, second, third] = comparisons.as_slice() else { panic!("{comparisons:?}") };
    assert_eq!((first.left.value, first.relation, first.holds), (1.0, "<", true));
    let right = second.right.as_ref().expect("a right side");
    assert_eq!((second.left.text.as_str(), second.left.value), ("y", 6.0));
    assert_eq!((right.text.as_str(), right.value, second.holds), ("100 * x", 200.0, false));
    assert_eq!((third.relation, &third.right, third.holds), ("is not finite", &None, false));
    let denied = self::condition("not (x < if(0 < y < 9, 1, 2) or not_finite(y))");
    let comparisons = denied.comparisons(&[2.0, 6.0]);
    let [first, second] = comparisons.as_slice() else { panic!("{comparisons:?}") };
    let right = first.right.as_ref().expect("a right side");
    assert_eq!((first.relation, right.text.as_str(), right.value), (">=", "if(0 < y < 9, 1, 2)", 1.0));
    assert_eq!((second.relation, second.left.text.as_str(), second.holds), ("is finite", "y", true));
}

#[test]
fn numbers_and_conditions_are_not_confused() {
    refused("x", 0, "expected a comparison such as a < b, found just a number");
    refused("1 < 2 and x", 10, "found just a number");
    refused("x and 1 < 2", 0, "found just a number");
    refused("1 + (1 < 2) < 3", 4, "expected a number, found a comparison");
    refused("(1 < 2)^2 < 3", 0, "expected a number, found a comparison");
    refused("-(1 < 2) < 3", 1, "expected a number, found a comparison");
    refused("not_finite(1 < 2)", 13, "expected an operator or ')'");
    refused("not_finite < 2", 11, "expected '(' behind the function 'not_finite', found '<'");
    refused("x = 3", 2, "numbers are not compared for equality");
    refused("1 < 2 and", 9, "found the end of the formula");
    refused("1 < or 2", 4, "found 'or'");
    refused("x < 3 y", 6, "found 'y'");
    let error = Expression::parse("2*x < 3").expect_err("a condition");
    assert_eq!((error.offset, error.message.starts_with("expected a number, found a comparison")), (0, true));
}

/// `a.b` is slot 7.
struct Dotted;

impl Operands for Dotted {
    fn read(&mut self, name: &str, _: usize, text: &mut Cursor) -> Result<Option<usize>, FormulaError> {
        if name != "a" {
            return Ok(None);
        }
        if !text.take('.') {
            return Err(text.unexpected("'.' behind 'a'"));
        }
        Ok((text.take_name() == "b").then_some(7))
    }
}

#[test]
fn operands_of_the_caller_stand_where_numbers_do() {
    let condition = Condition::parse("2*a.b^2 < x and a.b>0", &mut Dotted, |_| Some(Operand::Slot(0))).unwrap();
    let slots = [10.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0];
    assert!(condition.holds(&slots));
    assert_eq!(condition.comparisons(&slots)[1].left.text, "a.b");
    let refuse = |text: &str| Expression::parse_with(text, &mut Dotted).expect_err(text);
    assert_eq!(
        refuse("1 + a").within("1 + a"),
        "expected '.' behind 'a', found the end of the formula (column 6 of \"1 + a\")"
    );
    // What the caller does not take is read as if it had not looked.
    assert_eq!(refuse("a.c").message, "expected a digit in front of the point: write 0.5, not .5");
}

#[test]
fn names_in_backticks_are_never_functions() {
    let expression = Expression::parse("`b_ξ` + `sin` + t_δ + `pi`").unwrap();
    assert_eq!(expression.names(), ["b_ξ", "sin", "t_δ", "pi"]);
    refused("`x < 3", 0, "second backtick");
    refused("1 < ``", 4, "found none");
}

proptest! {
    /// Words of the language in any order: most are refused, and what is read can be evaluated.
    #[test]
    fn words_in_any_order(words in proptest::collection::vec(
        prop_oneof![
            Just("x"), Just("`a b`"), Just("1"), Just("2.5e-1"), Just("<"), Just(">="), Just("and"), Just("or"), Just("("),
            Just(")"), Just("+"), Just("-"), Just("*"), Just("/"), Just("abs("), Just("min("), Just(","),
            Just("not_finite("), Just("`"), Just("é"), Just("not"), Just("if("),
        ],
        0..12,
    )) {
        let text = words.join(" ");
        match Condition::parse(&text, &mut (), |_| Some(Operand::Slot(0))) {
            Ok(condition) => {
                let margin = condition.margin(&[1.0]);
                let agrees = if condition.holds(&[1.0]) { margin >= 0.0 } else { margin <= 0.0 };
                prop_assert!(agrees, "{text}: {margin}");
                prop_assert!(!condition.comparisons(&[1.0]).is_empty());
            }
            Err(error) => prop_assert!(text.is_char_boundary(error.offset), "{error}"),
        }
    }

    /// A comparison of two numbers is what it is in Rust.
    #[test]
    fn numbers_compare_as_numbers(a in -1e3..1e3f64, b in -1e3..1e3f64) {
        let condition = condition(&format!("{a:e} < {b:e} or {a} >= {b}"));
        prop_assert!(condition.holds(&[]));
        let comparisons = condition.comparisons(&[]);
        prop_assert_eq!((comparisons[0].holds, comparisons[1].holds), (a < b, a >= b));
    }
}
