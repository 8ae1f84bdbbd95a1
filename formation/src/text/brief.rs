//! Long texts and long numbers, as messages show them.

/// Most characters of a name, a formula or an argument that a message shows.
const SHOWN: usize = 80;
/// Most characters of a word in a message: the path of a file may be long, and is wanted whole.
const WORD: usize = 300;
/// Most characters of a word in a message about a scenario, whose names are short.
const NAME: usize = 160;
/// Most characters of a line: a list of all participants of a large formation is not read.
const LINE: usize = 1200;
/// More digits in a row than a number needs to say which it is.
const DIGITS: usize = 24;

/// At most 80 characters of a text: its start and its end.
///
/// ```
/// use formation::config::brief;
/// assert_eq!(brief("controller.c_p=3"), "controller.c_p=3");
/// assert_eq!(brief(&"t+".repeat(1000)).chars().count(), 80);
/// ```
pub fn brief(text: &str) -> String {
    shortened(text, SHOWN)
}

/// At most 80 characters of a text around byte `place`.
pub(crate) fn around(text: &str, place: usize) -> String {
    let before = text.char_indices().take_while(|(offset, _)| *offset < place).count();
    let count = text.chars().count();
    if count <= SHOWN {
        return text.into();
    }
    let first = before.saturating_sub(SHOWN / 2).min(count - SHOWN);
    let part: String = text.chars().skip(first).take(SHOWN).collect();
    let [start, end] = [first > 0, first + SHOWN < count].map(|cut| if cut { "…" } else { "" });
    format!("{start}{part}{end}")
}

/// A message without numbers of hundreds of digits, endless words and endless lines.
pub fn readable(message: &str) -> String {
    within(message, WORD)
}

/// The same for a message about a scenario.
pub(crate) fn readable_problem(message: &str) -> String {
    within(message, NAME)
}

fn within(message: &str, longest: usize) -> String {
    let lines = message.split('\n').map(|line| {
        let words = line.split(' ').map(|word| shortened(&rounded(word), longest));
        shortened(&words.collect::<Vec<_>>().join(" "), LINE)
    });
    lines.collect::<Vec<_>>().join("\n")
}

fn shortened(text: &str, most: usize) -> String {
    let count = text.chars().count();
    if count <= most {
        return text.into();
    }
    let end = most / 4;
    let start: String = text.chars().take(most - end - 1).collect();
    start + "…" + &text.chars().skip(count - end).collect::<String>()
}

/// The word with numbers of very many digits, as `f64` prints 1e300, in the form `1e300`.
fn rounded(word: &str) -> String {
    let is_digit = |byte: &u8| byte.is_ascii_digit();
    if word.bytes().filter(|byte| is_digit(byte)).count() <= DIGITS || word.contains('…') {
        return word.into();
    }
    let mut text = String::new();
    let mut rest = word;
    while !rest.is_empty() {
        let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
        let point = usize::from(digits > 0 && rest.as_bytes().get(digits) == Some(&b'.'));
        let behind = rest[digits + point..].bytes().take_while(|byte| point == 1 && is_digit(byte)).count();
        let length = if behind > 0 { digits + point + behind } else { digits };
        let (number, after) = rest.split_at(length);
        let value = number.parse::<f64>().unwrap_or(f64::INFINITY);
        // What has an exponent already, and names with digits, stay as they are.
        let is_part = text.ends_with(|c: char| c.is_ascii_alphanumeric() || c == '_') || after.starts_with(['e', 'E']);
        let is_long = digits > DIGITS || behind > 2 * DIGITS;
        match value.is_finite() && is_long && !is_part {
            true => text.push_str(&format!("{value:e}")),
            false => text.push_str(number),
        }
        let next = after.chars().next().map_or(0, char::len_utf8);
        text.push_str(&after[..next]);
        rest = &after[next..];
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_many_digits_have_an_exponent() {
        let message = |value: f64| readable(&format!("expected a number > 0, found {value}; x_2"));
        for (value, text) in [(-3.0, "-3"), (-1e15, "-1000000000000000"), (-1e308, "-1e308"), (1.5e300, "1.5e300")] {
            assert_eq!(message(value), format!("expected a number > 0, found {text}; x_2"));
        }
        assert_eq!(message(-f64::MIN_POSITIVE), "expected a number > 0, found -2.2250738585072014e-308; x_2");
        for kept in ["0.1000000000000000055", "runs/20260101000000000000000.mcap", "1e-300", "ab12345678901234567890"] {
            assert!(readable(kept) == kept || kept.starts_with("runs"), "{kept}");
        }
    }

    #[test]
    fn long_words_and_lines_are_cut() {
        let formula = "t+".repeat(100_000);
        assert_eq!(readable(&format!("in {formula}: no")).chars().count(), "in  no".len() + 300);
        let spaced = "t + ".repeat(50_000);
        assert_eq!(readable(&format!("{spaced}\nnext")).chars().count(), 1200 + "\nnext".len());
        assert_eq!(brief(&formula).chars().count(), 80);
        assert_eq!(around("sin(t)", 3), "sin(t)");
        let found = around(&format!("{formula}Ω + {formula}"), formula.len());
        assert!(found.contains('Ω') && found.starts_with('…') && found.ends_with('…'), "{found}");
        assert_eq!(found.chars().count(), 82);
    }
}
