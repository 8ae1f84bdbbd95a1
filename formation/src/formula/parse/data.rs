//! Calls that read data files: `table("wind.csv", "vx", t, "cubic")`, `trajectory("way.csv", "x", t)`.

use super::super::function::Term;
use super::super::token::Kind;
use super::super::{DataCall, DataError, DataFunction, FormulaError, Interpolation};
use super::{Parser, Value};
use crate::text::did_you_mean;

impl Parser<'_, '_> {
    pub(super) fn table(&mut self) -> Result<Value, FormulaError> {
        self.data("table", "table(\"wind.csv\", \"vx\", t)", |parser| {
            let is_given = parser.token.kind == Kind::Symbol(',');
            let interpolation = if is_given { parser.interpolation()? } else { Interpolation::default() };
            Ok(DataFunction::Table(interpolation))
        })
    }

    pub(super) fn trajectory(&mut self) -> Result<Value, FormulaError> {
        self.data("trajectory", "trajectory(\"way.csv\", \"x\", t)", |_| Ok(DataFunction::Trajectory))
    }

    /// File and column, where to read the curve, and what `rest` reads behind that.
    fn data(
        &mut self,
        name: &str,
        example: &str,
        rest: impl Fn(&mut Self) -> Result<DataFunction, FormulaError>,
    ) -> Result<Value, FormulaError> {
        let token = self.advance()?;
        let parenthesis = self.open(name)?;
        let (file_offset, file) = self.text(&format!("a file in quotes, as in {example}"))?;
        self.comma(&format!("',' and a column in quotes, as in {example}"))?;
        let (column_offset, column) = self.text(&format!("a column in quotes, as in {example}"))?;
        self.comma(&format!("',' and where to read the column, as in {example}"))?;
        self.nested(|parser| parser.number(Self::sum))?;
        let function = rest(self)?;
        self.close(parenthesis, "an operator or ')'")?;
        let curve = self.operands.curve(&DataCall { function, file, column }).map_err(|error| match error {
            DataError::File(message) => FormulaError::new(file_offset, message),
            DataError::Column(message) => FormulaError::new(column_offset, message),
        })?;
        self.parsed.curves.push(curve);
        self.emit(token.offset, Term::Curve(self.parsed.curves.len() - 1));
        Ok(Value::Number)
    }

    fn interpolation(&mut self) -> Result<Interpolation, FormulaError> {
        let expected = "\"hold\", \"linear\" or \"cubic\"";
        self.advance()?;
        let (offset, name) = self.text(expected)?;
        let known = Interpolation::ALL.into_iter().find(|(known, _)| *known == name);
        known.map(|(_, interpolation)| interpolation).ok_or_else(|| {
            let hint = did_you_mean(name, Interpolation::ALL.map(|(known, _)| known));
            FormulaError::new(offset, format!("expected {expected}, found '{name}'{hint}"))
        })
    }
}

impl<'a> Parser<'a, '_> {
    fn text(&mut self, expected: &str) -> Result<(usize, &'a str), FormulaError> {
        let Kind::Text(text) = self.token.kind else { return Err(self.unexpected(expected)) };
        Ok((self.advance()?.offset, text))
    }

    fn comma(&mut self, expected: &str) -> Result<(), FormulaError> {
        match self.token.kind {
            Kind::Symbol(',') => self.advance().map(|_| ()),
            _ => Err(self.unexpected(expected)),
        }
    }
}
