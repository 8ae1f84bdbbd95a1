//! What is a formula and what is not.

use proptest::prelude::*;

use super::formula;
use crate::formula::{Expression, Formula, FormulaError, Operand};

fn constant(text: &str) -> f64 {
    Expression::parse(text).and_then(|expression| expression.constant()).unwrap_or_else(|e| panic!("{text}: {e}"))
}

fn refused(text: &str) -> FormulaError {
    Expression::parse(text).expect_err(text)
}

#[test]
fn precedence_is_that_of_mathematics() {
    for (text, value) in [
        ("1 + 2*3", 7.0),
        ("(1 + 2)*3", 9.0),
        ("8 - 3 - 2", 3.0),
        ("8/4/2", 1.0),
        ("8/4*2", 4.0),
        ("2^3^2", 512.0),
        ("(2^3)^2", 64.0),
        ("-3^2", -9.0),
        ("(-3)^2", 9.0),
        ("2^-1", 0.5),
        ("2^-3^2", 2.0_f64.powi(-9)),
        ("2*-3", -6.0),
        ("2 - -3", 5.0),
        ("--3", 3.0),
        ("-2*3", -6.0),
        ("2*3^2", 18.0),
        ("1e-3", 0.001),
        ("2.5E+2", 250.0),
        ("007", 7.0),
        ("\t1\n + 1 ", 2.0),
        ("max(1, min(5, 2 + 1))", 3.0),
        ("cos(pi)", -1.0),
    ] {
        assert_eq!(constant(text), value, "{text}");
    }
}

#[test]
fn names_come_once_each_in_order() {
    let expression = Expression::parse("((Jy-Jz)/Jx)*v5*v6 + sin(v5)*pi - _a").unwrap();
    assert_eq!(expression.names(), ["Jy", "Jz", "Jx", "v5", "v6", "_a"]);
    assert_eq!(expression.text(), "((Jy-Jz)/Jx)*v5*v6 + sin(v5)*pi - _a");
    let mut asked = Vec::new();
    expression
        .compile(|name| {
            asked.push(name.to_string());
            Some(Operand::Slot(0))
        })
        .unwrap();
    assert_eq!(asked, expression.names());
}

#[test]
fn every_refusal_says_where_what_and_what_instead() {
    let operand = "expected a number, a name or '('";
    let operator = "expected an operator or the end of the formula";
    for (text, offset, message) in [
        ("", 0, "expected a formula, found an empty text"),
        ("  ", 0, "expected a formula, found an empty text"),
        ("1 +", 3, &format!("{operand}, found the end of the formula")),
        ("+1", 0, &format!("{operand}, found '+'")),
        ("2**3", 2, &format!("{operand}, found '*'")),
        ("()", 1, &format!("{operand}, found ')'")),
        ("sin()", 4, &format!("{operand}, found ')'")),
        ("1)", 1, &format!("{operator}, found ')'")),
        ("1, 2", 1, &format!("{operator}, found ','")),
        ("2 x", 2, &format!("{operator}, found 'x'; a product is written with '*'")),
        ("1e", 1, &format!("{operator}, found 'e'; a product is written with '*'")),
        ("(1)(2)", 3, &format!("{operator}, found '('; a product is written with '*'")),
        (
            "1 + (2",
            6,
            "expected an operator or ')' to end what the '(' in column 5 begins, found the end of the formula",
        ),
        (
            "min(1, 2",
            8,
            "expected an operator, ',' or ')' to end what the '(' in column 4 begins, found the end of the formula",
        ),
        ("sin + 1", 4, "expected '(' behind the function 'sin', found '+'"),
        ("1 + sin(1, 2)", 4, "expected 1 argument of the function 'sin', found 2"),
        ("atan2(1)", 0, "expected 2 arguments of the function 'atan2', found 1"),
        ("floor(1, 2)", 0, "expected 1 argument of the function 'floor', found 2"),
        ("mod(1)", 0, "expected 2 arguments of the function 'mod', found 1"),
        ("pulse(1, 2)", 0, "expected 3 arguments of the function 'pulse', found 2"),
        ("clip(1, 2, 3, 4)", 0, "expected 3 arguments of the function 'clip', found 4"),
        ("noise(1)", 0, "expected 3 arguments of the function 'noise', found 1"),
        ("1 + if(1 < 2, 3)", 4, "expected 3 arguments of the function 'if', found 2"),
        ("if(1 < 2)", 0, "expected 3 arguments of the function 'if', found 1"),
        ("if(1, 2, 3)", 3, "expected a comparison such as a < b, found just a number"),
        ("if 1 < 2", 3, "expected '(' behind the function 'if', found '1'"),
        (
            "1 + (2 < 3)",
            4,
            "expected a number, found a comparison, which holds or does not; if(a < b, 1, 0) is a number",
        ),
        ("1 + not 2", 4, &format!("{operand}, found 'not'")),
        ("1.", 2, "expected a digit behind the point: write 1.0, not 1."),
        (".5", 0, "expected a digit in front of the point: write 0.5, not .5"),
        ("1e999", 0, "expected a number below 1.8e308, found '1e999'"),
        ("2 × 3", 2, "expected a number, a name, an operator or a parenthesis, found the character '×'"),
    ] {
        let error = refused(text);
        assert_eq!((error.offset, error.to_string().as_str()), (offset, message), "{text}");
    }
    let error = refused("1 + cosine(2)");
    assert_eq!(error.offset, 4);
    assert!(error.message.contains("sin, cos, tan") && error.message.contains("'cosine('"), "{error}");
    assert!(refused("flor(2)").message.contains("found 'flor('; did you mean `floor`?"));
    assert!(refused("iff(1 < 2, 3, 4)").message.contains("; did you mean `if`?"));
}

#[test]
fn free_names_need_a_meaning() {
    let error = Expression::parse("a + bb").unwrap().compile(|name| (name == "a").then_some(Operand::Slot(0)));
    let error = error.unwrap_err();
    assert_eq!((error.offset, error.message.as_str()), (4, "expected a known name, found 'bb'"));
    let error = Expression::parse("2*bb").unwrap().constant().unwrap_err();
    assert_eq!((error.offset, error.message.as_str()), (2, "expected a constant, found the name 'bb'"));
}

#[test]
fn length_and_nesting_are_bounded() {
    let sum = |terms: usize| vec!["x"; terms].join("+");
    assert!(Expression::parse(&sum(2048)).is_ok());
    assert!(refused(&sum(2049)).message.contains("at most 4096 bytes, found one of 4097"));

    let nested = |open: &str, depth: usize, close: &str| format!("{}1{}", open.repeat(depth), close.repeat(depth));
    for (open, close) in
        [("(", ")"), ("-", ""), ("2^", ""), ("sin(", ")"), ("min(1,", ")"), ("min(", ",1)"), ("if(1<2,", ",1)")]
    {
        assert!(Expression::parse(&nested(open, 64, close)).is_ok(), "{open}");
        let error = refused(&nested(open, 65, close));
        assert!(error.message.starts_with("expected at most 64 parentheses"), "{open}: {error}");
        assert_eq!(refused(&nested(open, 400, close)), error, "{open}");
    }
}

#[test]
fn intermediate_results_are_bounded() {
    let right = |depth: usize| format!("{}x{}", "x+(".repeat(depth), ")".repeat(depth));
    assert_eq!(formula(&right(31), &["x"]).evaluate(&[1.0]), 32.0);
    let error = Expression::parse(&right(32)).unwrap().compile(|_| Some(Operand::Slot(0))).unwrap_err();
    assert_eq!(error.offset, 1);
    assert!(error.message.starts_with("expected at most 32 intermediate results at a time, found 33"), "{error}");
    // The other way round one waits at a time, and constants fold to one.
    let left = format!("{}x{}", "(".repeat(60), "+x)".repeat(60));
    assert_eq!(formula(&left, &["x"]).evaluate(&[1.0]), 61.0);
    assert_eq!(constant(&right(60).replace('x', "1")), 61.0);
    // A formula put into another one counts with its depth.
    let inner = formula(&right(31), &["x"]);
    let put = |text: &str| {
        let resolve = |name: &str| Some(if name == "f" { Operand::Formula(inner.clone()) } else { Operand::Slot(0) });
        Expression::parse(text).unwrap().compile(resolve)
    };
    assert_eq!(put("f + x").unwrap().evaluate(&[1.0]), 33.0);
    assert!(put("x + f").is_err());
}

#[test]
fn branches_wait_for_nothing() {
    let row = |length: usize| format!("{}x{}", "if(x < 2, x, ".repeat(length), ")".repeat(length));
    assert_eq!(formula(&row(60), &["x"]).evaluate(&[7.0]), 7.0);
    // What stands between two relations is compared twice, also within itself.
    let nested = (0..40).fold("x".to_string(), |inner, _| format!("if(0 < {inner} < 9, x, 1)"));
    let error = refused(&nested);
    assert!(error.message.starts_with("expected at most 4096 operations"), "{error}");
}

#[test]
fn formulas_in_formulas_do_not_grow_without_bound() {
    let double =
        |inner: &Formula| Expression::parse("f + f").unwrap().compile(|_| Some(Operand::Formula(inner.clone())));
    let mut inner = formula("x", &["x"]);
    for _ in 0..11 {
        inner = double(&inner).unwrap();
    }
    assert_eq!(inner.evaluate(&[1.0]), 2048.0);
    let error = double(&inner).unwrap_err();
    assert!(error.message.starts_with("expected at most 4096 operations, named parts included"), "{error}");
}

proptest! {
    #[test]
    fn nothing_panics(text in prop_oneof![
        any::<String>(),
        "[-+*/^(),.0-9a-e_ ×π]{0,60}",
        "((sin|sig|min|atan2|pi|x|y|1|2e3|0.5|,|\\(|\\)|\\+|-|\\*|/|\\^| ){0,30})",
        "((if\\(|mod\\(|not |<|>=| and | or |x|y|1|,|\\)|\\(|\\+){0,30})",
    ]) {
        match Expression::parse(&text) {
            Ok(expression) => {
                if let Ok(formula) = expression.compile(|_| Some(Operand::Slot(0))) {
                    formula.evaluate(&[0.7]);
                }
            }
            Err(error) => {
                prop_assert!(text.is_char_boundary(error.offset), "{error}");
                prop_assert!(error.message.starts_with("expected "), "{error}");
            }
        }
    }
}
