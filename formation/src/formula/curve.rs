//! Curves through data: polynomials in a row.

/// A function that is one polynomial from each knot to the next. In front of the first knot it has the value that it has there, and
/// from the last one on the value of its end, with derivatives 0.
#[derive(Debug)]
pub struct Curve {
    /// Where the polynomials begin, and where the last one ends; at least two, increasing.
    knots: Vec<f64>,
    /// Coefficients of each polynomial.
    width: usize,
    /// Those of all, each by increasing power of the distance from its knot.
    coefficients: Vec<f64>,
    end: f64,
}

impl Curve {
    /// The curve with these knots; `coefficients` has `width` numbers for each knot but the last, by increasing power of the distance
    /// from it.
    ///
    /// # Panics
    /// If there are fewer than two knots, or not that many coefficients.
    pub fn new(knots: Vec<f64>, width: usize, coefficients: Vec<f64>, end: f64) -> Self {
        assert!(knots.len() > 1 && width > 0 && coefficients.len() == width * (knots.len() - 1), "one polynomial each");
        Self { knots, width, coefficients, end }
    }

    /// The value at `x`; at a knot, that of the polynomial that begins there.
    pub(super) fn value(&self, x: f64) -> f64 {
        match self.place(x, false) {
            Place::Polynomial(coefficients, distance) => polynomial(coefficients, distance),
            Place::Outside(value) => value,
        }
    }

    /// The value at `x` and the first three derivatives; at a knot, those of the polynomial that ends there, if `from_below`.
    pub(super) fn derivatives(&self, x: f64, from_below: bool) -> [f64; 4] {
        match self.place(x, from_below) {
            Place::Polynomial(coefficients, distance) => {
                let mut all = [polynomial(coefficients, distance), 0.0, 0.0, 0.0];
                for (order, derivative) in all.iter_mut().enumerate().skip(1) {
                    let factor = |power: usize| (power - order + 1..=power).fold(1.0, |product, k| product * k as f64);
                    let terms = coefficients.iter().enumerate().skip(order).rev();
                    *derivative = terms.fold(0.0, |sum, (power, c)| sum * distance + factor(power) * c);
                }
                all
            }
            Place::Outside(value) => [value, 0.0, 0.0, 0.0],
        }
    }

    fn place(&self, x: f64, from_below: bool) -> Place<'_> {
        if x.is_nan() {
            return Place::Outside(x);
        }
        let begun = self.knots.partition_point(|knot| if from_below { *knot < x } else { *knot <= x });
        match begun {
            0 => Place::Outside(self.coefficients[0]),
            begun if begun == self.knots.len() => Place::Outside(self.end),
            begun => {
                let first = (begun - 1) * self.width;
                Place::Polynomial(&self.coefficients[first..first + self.width], x - self.knots[begun - 1])
            }
        }
    }
}

enum Place<'a> {
    /// These coefficients, and the distance from their knot.
    Polynomial(&'a [f64], f64),
    /// The value of an end, or NaN.
    Outside(f64),
}

fn polynomial(coefficients: &[f64], distance: f64) -> f64 {
    let (highest, lower) = coefficients.split_last().expect("at least one");
    lower.iter().rev().fold(*highest, |sum, coefficient| sum * distance + coefficient)
}
