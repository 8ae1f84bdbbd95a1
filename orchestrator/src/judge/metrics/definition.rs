//! What a metric means.

use std::borrow::Cow;

/// The meaning of a metric, for tables, reports and the glossary.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Definition {
    /// Its name, or the pattern of several: a name in braces stands for a number, `E_err_bound_{i}` or `t_u({level})`.
    pub id: Cow<'static, str>,
    /// Its formula in the symbols of the specification.
    pub symbol: Cow<'static, str>,
    /// Its unit; empty for a pure number.
    pub unit: Cow<'static, str>,
    /// One sentence: of what, over which agents, in which time.
    pub text: Cow<'static, str>,
}

impl Definition {
    /// A definition; see the fields.
    pub const fn new(id: &'static str, symbol: &'static str, unit: &'static str, text: &'static str) -> Self {
        Self {
            id: Cow::Borrowed(id),
            symbol: Cow::Borrowed(symbol),
            unit: Cow::Borrowed(unit),
            text: Cow::Borrowed(text),
        }
    }

    /// That of a metric which a scenario defines.
    pub(crate) fn own(id: &str, symbol: &str, unit: &str, text: String) -> Self {
        let owned = |text: &str| Cow::Owned(text.to_string());
        Self { id: owned(id), symbol: owned(symbol), unit: owned(unit), text: Cow::Owned(text) }
    }

    /// Whether it is the one of the metric `id`.
    ///
    /// ```
    /// use orchestrator::judge::metrics::Definition;
    /// let settled = Definition::new("t_u({level})", "t", "s", "The time from which on ‖u‖ stays below a level.");
    /// assert!(settled.defines("t_u(1.5e-3)") && !settled.defines("t_u()"));
    /// ```
    pub fn defines(&self, id: &str) -> bool {
        matches(&self.id, id)
    }

    /// The symbol for the metric `id`: a place holder of the pattern becomes the number, as in `‖E_2‖`.
    pub fn symbol_of(&self, id: &str) -> Cow<'_, str> {
        let numbered = placeholder(&self.id).and_then(|(head, name, tail)| {
            let number = id.strip_prefix(head)?.strip_suffix(tail)?;
            Some(self.symbol.replace(&format!("{{{name}}}"), number))
        });
        numbered.map_or(Cow::Borrowed(&*self.symbol), Cow::Owned)
    }
}

/// What is before, in and behind the first place holder of a pattern.
fn placeholder(pattern: &str) -> Option<(&str, &str, &str)> {
    let (head, rest) = pattern.split_once('{')?;
    let (name, tail) = rest.split_once('}')?;
    Some((head, name, tail))
}

fn matches(pattern: &str, id: &str) -> bool {
    let Some((head, _, tail)) = placeholder(pattern) else { return pattern == id };
    let number = id.strip_prefix(head).and_then(|rest| rest.strip_suffix(tail));
    number.is_some_and(|number| {
        !number.is_empty() && number.chars().all(|c| c.is_ascii_digit() || matches!(c, '.' | 'e' | '-' | '_'))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_holder_stands_for_a_number() {
        let each = Definition::new("gap_min_{i}", "d_{i}", "m", "");
        assert!(each.defines("gap_min_12") && each.defines("gap_min_1_10"));
        assert!(!each.defines("gap_min") && !each.defines("gap_min_") && !each.defines("gap_min_all"));
        assert_eq!(each.symbol_of("gap_min_12"), "d_12");
        let plain = Definition::new("x_til", "‖x − x̂‖", "m", "");
        assert!(plain.defines("x_til") && !plain.defines("x_til_1"));
        assert_eq!(plain.symbol_of("x_til"), "‖x − x̂‖");
    }
}
