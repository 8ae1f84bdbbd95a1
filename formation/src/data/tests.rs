//! Data files as formulas read them.

use std::collections::BTreeMap;

use proptest::prelude::*;

use super::{DataSource, Library};
use crate::formula::{Expression, Formula, FormulaError, Jet, Operand};

/// Formulas of t over these files.
fn library(files: &[(&str, &str)]) -> Library {
    let bytes = files.iter().map(|(path, text)| (path.to_string(), text.as_bytes().into())).collect();
    Library::new(DataSource::Bytes(bytes), BTreeMap::new())
}

fn compiled(text: &str, library: &mut Library) -> Result<Formula, FormulaError> {
    Expression::parse_with(text, library)?.compile(|name| (name == "t").then_some(Operand::Slot(0)))
}

/// A formula of t over the file `d.csv`.
fn formula(text: &str, file: &str) -> Formula {
    compiled(text, &mut library(&[("d.csv", file)])).unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn at(formula: &Formula, t: f64) -> [f64; 4] {
    let jet = formula.evaluate_jet(&[Jet::time(t)]);
    assert_eq!(jet.value.to_bits(), formula.evaluate(&[t]).to_bits(), "the value at {t}");
    [jet.value, jet.rate, jet.acceleration, jet.jerk]
}

const STEPS: &str = "t,x,y\n0,1,5\n1,3,5\n3,-1,6\n";

#[test]
fn tables_hold_or_join_their_points() {
    let linear = formula(r#"table("d.csv", "x", t)"#, STEPS);
    for (t, expected) in [
        (-1.0, [1.0, 0.0, 0.0, 0.0]),
        (0.0, [1.0, 2.0, 0.0, 0.0]),
        (0.5, [2.0, 2.0, 0.0, 0.0]),
        (1.0, [3.0, -2.0, 0.0, 0.0]),
        (2.5, [0.0, -2.0, 0.0, 0.0]),
        (3.0, [-1.0, 0.0, 0.0, 0.0]),
        (9.0, [-1.0, 0.0, 0.0, 0.0]),
    ] {
        assert_eq!(at(&linear, t), expected, "at {t}");
    }
    let held = formula("table('d.csv', 'x', t, 'hold')", STEPS);
    for (t, value) in [(-1.0, 1.0), (0.0, 1.0), (0.9, 1.0), (1.0, 3.0), (2.9, 3.0), (3.0, -1.0), (4.0, -1.0)] {
        assert_eq!(at(&held, t), [value, 0.0, 0.0, 0.0], "at {t}");
    }
    // Backwards, the slope right of the instant is the one before it, and a held value jumps.
    assert_eq!(at(&formula("table('d.csv', 'x', 2 - t)", STEPS), 1.0), [3.0, -2.0, 0.0, 0.0]);
    assert_eq!(at(&formula("t*table('d.csv', 'x', 2 - t, 'hold')", STEPS), 1.0), [3.0, 1.0, 0.0, 0.0]);
    assert_eq!(at(&formula("table('d.csv', 't', t^2)", STEPS), 0.5), [0.25, 1.0, 2.0, 0.0]);
    assert!(linear.evaluate(&[f64::NAN]).is_nan());
    // What does not depend on time is a number.
    assert_eq!(formula("table('d.csv', 'x', 0.5) + 1", STEPS).evaluate(&[]), 3.0);
}

#[test]
fn cubic_splines_repeat_cubic_polynomials() {
    let polynomial = |t: f64| t * t * t - 2.0 * t * t + 3.0;
    let knots = [-1.0, 0.0, 0.25, 1.0, 3.0, 3.5];
    for count in 4..=knots.len() {
        let rows: String = knots[..count].iter().map(|t| format!("{t},{}\n", polynomial(*t))).collect();
        let spline = formula("table('d.csv', 'x', t, 'cubic')", &format!("t,x\n{rows}"));
        for t in [-1.0, -0.4, 0.0, 0.1, 0.25, 0.6, 0.99] {
            let expected = [polynomial(t), 3.0 * t * t - 4.0 * t, 6.0 * t - 4.0, 6.0];
            for (found, expected) in at(&spline, t).into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-12, "{count} points, at {t}: {found}, not {expected}");
            }
        }
    }
    let parabola = formula("table('d.csv', 'x', t, 'cubic')", "t,x\n0,0\n1,1\n3,9\n");
    assert_eq!(at(&parabola, 2.0), [4.0, 4.0, 2.0, 0.0]);
    assert_eq!(at(&formula("table('d.csv', 'x', t, 'cubic')", "t,x\n0,0\n2,1\n"), 1.0), [0.5, 0.5, 0.0, 0.0]);
}

/// A function of t whose knots are whole numbers, its derivatives compared with differences in between, and its derivatives up to
/// `order` on both sides of the knots.
fn check_curve(curve: &Formula, last: usize, order: usize) {
    for k in 0..=last {
        let [before, after] = [-1e-7, 0.0].map(|shift| at(curve, k as f64 + shift));
        for j in 0..=order {
            let tolerance = 1e-4 * (1.0 + after[j].abs());
            assert!((before[j] - after[j]).abs() < tolerance, "derivative {j} at {k}: {} and {}", before[j], after[j]);
        }
        let (t, h) = (k as f64 + 0.37, 1e-4);
        let [before, here, after] = [t - h, t, t + h].map(|t| at(curve, t));
        for j in 0..3 {
            let slope = (after[j] - before[j]) / (2.0 * h);
            let tolerance = 1e-4 * (1.0 + slope.abs());
            assert!((slope - here[j + 1]).abs() < tolerance, "derivative {j} at {t}: {slope}, not {}", here[j + 1]);
        }
    }
}

proptest! {
    #[test]
    fn curves_pass_their_points_smoothly(y in proptest::collection::vec(-3.0..3.0f64, 2..9)) {
        let rows: String = y.iter().enumerate().map(|(k, y)| format!("{k},{y}\n")).collect();
        let file = format!("t,x\n{rows}");
        let last = y.len() - 1;
        let spline = formula("table('d.csv', 'x', t, 'cubic')", &file);
        let path = formula("trajectory('d.csv', 'x', t)", &file);
        for (k, y) in y.iter().enumerate() {
            prop_assert_eq!(spline.evaluate(&[k as f64]), *y);
            prop_assert_eq!(path.evaluate(&[k as f64]), *y);
        }
        check_curve(&path, last, 2);
        for k in 1..last {
            let [before, after] = [-1e-7, 0.0].map(|shift| at(&spline, k as f64 + shift));
            prop_assert!((0..3).all(|j| (before[j] - after[j]).abs() < 1e-4), "{before:?} {after:?}");
        }
        for end in [0.0, last as f64] {
            let [_, rate, acceleration, _] = at(&path, end);
            prop_assert!(rate.abs() < 1e-9 && acceleration.abs() < 1e-9);
        }
    }
}

#[test]
fn a_move_between_two_points_is_that_of_minimum_jerk() {
    let path = formula("trajectory('d.csv', 'x', t)", "t,x\n1,2\n3,6\n");
    for t in [1.0, 1.3, 2.0, 2.9, 3.0] {
        let s: f64 = (t - 1.0) / 2.0;
        let expected = 2.0 + 4.0 * (10.0 * s * s * s - 15.0 * s * s * s * s + 6.0 * s * s * s * s * s);
        assert!((at(&path, t)[0] - expected).abs() < 1e-12, "at {t}");
    }
    // Of three points, the third and fourth derivatives are continuous too.
    let path = formula("trajectory('d.csv', 'x', t)", "t,x\n0,0\n1,1\n3,-2\n");
    let [before, after] = [1.0 - 1e-9, 1.0].map(|t| at(&path, t)[3]);
    assert!((before - after).abs() < 1e-5, "{before} {after}");
    let fourth = |t: f64| (at(&path, t + 1e-4)[3] - at(&path, t)[3]) / 1e-4;
    assert!((fourth(1.0 - 1.01e-4) - fourth(1.0)).abs() < 0.1, "{} {}", fourth(1.0 - 1.01e-4), fourth(1.0));
}

/// A piece of the file that Crazyswarm ships, and a second one of half the length.
const PIECES: &str = "duration,x^0,x^1,x^2,x^3,x^4,x^5,x^6,x^7,yaw^0,yaw^1,yaw^2,yaw^3,yaw^4,yaw^5,yaw^6,yaw^7,\n\
    2,0,0,0,1,0,0,0,0,1,0,0,0,0,0,0,0,\n\
    1,8,12,6,1,0,0,0,-1,1,0,0,0,0,0,0,0,\n";

#[test]
fn pieces_of_crazyswarm_are_evaluated_as_they_are() {
    let path = formula("trajectory('d.csv', 'x', t)", PIECES);
    assert_eq!(at(&path, -1.0), [0.0; 4]);
    assert_eq!(at(&path, 1.0), [1.0, 3.0, 6.0, 6.0]);
    assert_eq!(at(&path, 2.0), [8.0, 12.0, 12.0, 6.0]);
    assert_eq!(at(&path, 3.0), [26.0, 0.0, 0.0, 0.0]);
    assert_eq!(at(&path, 99.0), [26.0, 0.0, 0.0, 0.0]);
    assert_eq!(at(&formula("trajectory('d.csv', 'yaw', t)", PIECES), 1.0), [1.0, 0.0, 0.0, 0.0]);
}

#[test]
fn files_may_look_as_other_programs_write_them() {
    for file in [
        "\u{feff}t; x\r\n0; 1\r\n1; 3\r\n",
        "# t x\n",
        "t\tx\n\n0\t1\n1\t3\n\n",
        "\"t\",\"x\"\n0,\"1\"\n1e0,3.0\n",
        "#t,x\n0,1\n1,3",
    ] {
        if file.lines().count() > 1 {
            assert_eq!(at(&formula("table('d.csv', 'x', t)", file), 0.5)[0], 2.0, "{file:?}");
        }
    }
}

#[test]
fn every_mistake_has_its_place() {
    let refusal = |text: &str, file: &str| {
        let error = compiled(text, &mut library(&[("d.csv", file)])).expect_err(text);
        assert!(text.is_char_boundary(error.offset));
        (error.offset, error.message)
    };
    let x = "1 + table('d.csv', 'x', t)";
    for (text, file, offset, message) in [
        (x, "", 10, "d.csv: expected a line with the names of the columns, found an empty file"),
        (x, "0,1\n1,2\n", 10, "d.csv: line 1: expected the names of the columns, found \"0,1\""),
        (x, "t,xx,y\n0,1,2\n", 19, "d.csv: no column is called `x`, expected one of t, xx, y; did you mean `xx`?"),
        (x, "t,x\n0,1\n1,a\n", 10, "d.csv: line 3, column `x`: expected a finite number, found \"a\""),
        (x, "t,x\n0,1\n\n1,\n", 10, "d.csv: line 4, column `x`: expected a finite number, found nothing"),
        (x, "t,x\n0,1\n1\n", 10, "d.csv: line 3, column `x`: expected a finite number, found nothing"),
        (x, "t,x\n0,1\n1,nan\n", 10, "d.csv: line 3, column `x`: expected a finite number, found \"nan\""),
        (
            x,
            "t,x\n0,1\n2,1\n2,3\n",
            10,
            "d.csv: line 4, column `t`: expected a number above 2 of the line before, found 2",
        ),
        (x, "t,x\n0,1\n", 10, "d.csv: expected at least 2 rows of numbers, found 1"),
        (x, "t,x\n\u{fffd}\n", 10, "d.csv: line 2, column `t`: expected a finite number, found \"\u{fffd}\""),
        ("table('e.csv', 'x', t)", STEPS, 6, "e.csv: the file is not among the data of the log"),
        (
            "table('d.csv', 'x')",
            STEPS,
            18,
            "expected ',' and where to read the column, as in table(\"wind.csv\", \"vx\", t), found ')'",
        ),
        (
            "table('d.csv', x, t)",
            STEPS,
            15,
            "expected a column in quotes, as in table(\"wind.csv\", \"vx\", t), found 'x'",
        ),
        ("table(t)", STEPS, 6, "expected a file in quotes, as in table(\"wind.csv\", \"vx\", t), found 't'"),
        (
            "table('d.csv', 'x', t, 'cubik')",
            STEPS,
            23,
            "expected \"hold\", \"linear\" or \"cubic\", found 'cubik'; did you mean `cubic`?",
        ),
        ("table('d.csv', 'x', t, 2)", STEPS, 23, "expected \"hold\", \"linear\" or \"cubic\", found '2'"),
        (
            "trajectory('d.csv', 'x', t, 'hold')",
            STEPS,
            26,
            "expected an operator or ')' to end what the '(' in column 11 begins, found ','",
        ),
        ("trajectory('d.csv', 'z', t)", PIECES, 20, "d.csv: no column is called `z^0`, expected one of duration"),
        ("'d.csv' + 1", STEPS, 0, "expected a number, a name or '(', found ''d.csv''"),
        ("table('d.csv", STEPS, 6, "expected a second ' to end the text that this one begins"),
        ("tabel('d.csv', 'x', t)", STEPS, 0, "expected one of the functions"),
    ] {
        let (found, what) = refusal(text, file);
        assert!(found == offset && what.starts_with(message), "{text}, {file:?}: {found} {what}");
    }
    let (_, what) = refusal("trajectory('d.csv', 'x', t)", &PIECES.replace("\n1,8", "\n0,8"));
    assert_eq!(what, "d.csv: line 3: expected a duration > 0, found 0");
    assert!(refusal("tabel('d.csv', 'x', t)", STEPS).1.contains("did you mean `table`?"));
    let error = Expression::parse("1 + table('d.csv', 'x', 2)").unwrap_err();
    assert_eq!(
        (error.offset, error.message.as_str()),
        (10, "there are no data files here: formulas of references, disturbances, vehicles and laws read them")
    );
}

#[test]
fn a_file_is_read_once_and_must_be_the_one_that_is_meant() {
    let mut library = library(&[("d.csv", STEPS), ("other.csv", STEPS)]);
    for _ in 0..3 {
        compiled("table('d.csv', 'x', t) + table('d.csv', 'y', t)", &mut library).unwrap();
    }
    let files = library.files();
    assert_eq!(files.len(), 1, "the other one is not used");
    assert_eq!((files[0].path.as_str(), &*files[0].bytes, files[0].digest.len()), ("d.csv", STEPS.as_bytes(), 64));

    let source = DataSource::Bytes(BTreeMap::from([("d.csv".to_string(), STEPS.as_bytes().into())]));
    let expected = |digest: &str| BTreeMap::from([("d.csv".to_string(), digest.to_string())]);
    let mut same = Library::new(source.clone(), expected(&files[0].digest));
    assert!(compiled("table('d.csv', 'x', t)", &mut same).is_ok());
    let mut other = Library::new(source, expected(&"0".repeat(64)));
    let error = compiled("table('d.csv', 'x', t)", &mut other).unwrap_err();
    assert!(error.message.starts_with("d.csv: the file is another one than [data] of the scenario says"), "{error}");
}

#[test]
fn sizes_are_bounded() {
    let rows = "0,0\n".repeat(1_000_001);
    let error = compiled("table('d.csv', 'x', t)", &mut library(&[("d.csv", &format!("t,x\n{rows}"))])).unwrap_err();
    assert_eq!(error.message, "d.csv: expected at most 1000000 rows, found 1000001");
    let mut endless = Library::new(DataSource::Folder("/dev".into()), BTreeMap::new());
    let error = compiled("table('zero', 'x', t)", &mut endless).unwrap_err();
    assert_eq!(error.message, "zero: expected at most 64 MiB of data, found more");
}
