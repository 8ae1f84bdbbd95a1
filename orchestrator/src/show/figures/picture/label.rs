//! Texts with formulas, in the part of TeX that labels of axes need: `$\|\bar{δ}x_i\|$ [m]`.
//!
//! Between two `$`, letters are variables and slanted; `_` and `^` make scripts of the next letter or group; `\bar`, `\hat` and
//! `\tilde` put an accent on it; `\mathrm` leaves it upright. Greek letters are written as they are or as `\delta`.

/// A text, as it was written and as it is read.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Label {
    source: String,
    pub(super) nodes: Vec<Node>,
}

/// A part of a text.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Node {
    /// Upright letters.
    Upright(String),
    /// Variables.
    Italic(String),
    /// A gap, in sizes of the font.
    Space(f64),
    /// An accent above what follows.
    Accent(Accent, Vec<Node>),
    /// Scripts behind what came before: below, and above.
    Scripts(Vec<Node>, Vec<Node>),
}

/// What stands above a letter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Accent {
    Bar,
    Hat,
    Tilde,
}

/// Names of letters and signs.
const NAMED: [(&str, char); 29] = [
    ("alpha", 'α'),
    ("beta", 'β'),
    ("gamma", 'γ'),
    ("delta", 'δ'),
    ("epsilon", 'ε'),
    ("zeta", 'ζ'),
    ("eta", 'η'),
    ("theta", 'θ'),
    ("kappa", 'κ'),
    ("lambda", 'λ'),
    ("mu", 'μ'),
    ("nu", 'ν'),
    ("xi", 'ξ'),
    ("pi", 'π'),
    ("rho", 'ρ'),
    ("sigma", 'σ'),
    ("tau", 'τ'),
    ("phi", 'φ'),
    ("chi", 'χ'),
    ("psi", 'ψ'),
    ("omega", 'ω'),
    ("Gamma", 'Γ'),
    ("Delta", 'Δ'),
    ("Theta", 'Θ'),
    ("Sigma", 'Σ'),
    ("Phi", 'Φ'),
    ("Omega", 'Ω'),
    ("cdot", '·'),
    ("times", '×'),
];

impl Label {
    /// A text without formulas, whatever signs it has.
    pub(crate) fn plain(text: &str) -> Self {
        let nodes = if text.is_empty() { Vec::new() } else { vec![Node::Upright(text.into())] };
        Self { source: text.replace('$', r"\$"), nodes }
    }

    /// A text with formulas between `$`.
    ///
    /// # Errors
    /// In words, what cannot be read.
    pub(crate) fn tex(text: &str) -> Result<Self, String> {
        let mut nodes = Vec::new();
        for (index, part) in text.split('$').enumerate() {
            match index % 2 {
                _ if part.is_empty() => {}
                0 => nodes.push(Node::Upright(part.into())),
                _ => {
                    let mut reader = Reader { letters: part.chars().collect(), place: 0 };
                    nodes.extend(reader.until_end().map_err(|why| format!("`{text}`: {why}"))?);
                }
            }
        }
        if text.matches('$').count() % 2 == 1 {
            return Err(format!("`{text}`: a formula has no end"));
        }
        Ok(Self { source: text.into(), nodes })
    }

    /// A power of ten.
    pub(crate) fn power_of_ten(exponent: i32) -> Self {
        Self::tex(&format!("$10^{{{exponent}}}$")).expect("a formula that can be read")
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// As TeX, for programs that read it.
    pub(crate) fn source(&self) -> &str {
        &self.source
    }

    /// Its letters alone.
    pub(crate) fn letters(&self) -> String {
        letters(&self.nodes)
    }
}

fn letters(nodes: &[Node]) -> String {
    let of = |node: &Node| match node {
        Node::Upright(text) | Node::Italic(text) => text.clone(),
        Node::Space(width) => {
            if *width > 0.1 {
                " ".into()
            } else {
                String::new()
            }
        }
        Node::Accent(_, body) => letters(body),
        Node::Scripts(below, above) => letters(below) + &letters(above),
    };
    nodes.iter().map(of).collect()
}

struct Reader {
    letters: Vec<char>,
    place: usize,
}

impl Reader {
    fn next(&mut self) -> Option<char> {
        let letter = self.letters.get(self.place).copied();
        self.place += 1;
        letter
    }

    fn peek(&self) -> Option<char> {
        self.letters.get(self.place).copied()
    }

    fn until_end(&mut self) -> Result<Vec<Node>, String> {
        let nodes = self.nodes()?;
        if self.place < self.letters.len() { Err("a `}` that nothing opened".into()) } else { Ok(nodes) }
    }

    /// Everything up to the end or the `}` of this group.
    fn nodes(&mut self) -> Result<Vec<Node>, String> {
        let mut nodes: Vec<Node> = Vec::new();
        while let Some(letter) = self.peek().filter(|letter| *letter != '}') {
            match letter {
                '_' | '^' => {
                    self.place += 1;
                    let script = self.argument()?;
                    let (below, above) = if letter == '_' { (script, Vec::new()) } else { (Vec::new(), script) };
                    match nodes.last_mut() {
                        Some(Node::Scripts(below_before, above_before)) => {
                            below_before.extend(below);
                            above_before.extend(above);
                        }
                        _ => nodes.push(Node::Scripts(below, above)),
                    }
                }
                _ => {
                    // A sign between two things has air; before the first one it is that of a number.
                    let between = !nodes.is_empty();
                    for node in self.one()? {
                        match node {
                            Node::Upright(sign) if between && ["+", "−"].contains(&sign.as_str()) => {
                                nodes.extend([Node::Space(0.22), Node::Upright(sign), Node::Space(0.22)]);
                            }
                            node => nodes.push(node),
                        }
                    }
                }
            }
        }
        Ok(nodes)
    }

    /// A group in braces, or the next thing.
    fn argument(&mut self) -> Result<Vec<Node>, String> {
        match self.peek() {
            None | Some('}') => Err("there is nothing behind the last sign".into()),
            Some(_) => self.one(),
        }
    }

    fn one(&mut self) -> Result<Vec<Node>, String> {
        Ok(match self.next() {
            Some('{') => {
                let nodes = self.nodes()?;
                if self.next() != Some('}') {
                    return Err("a `{` is not closed".into());
                }
                nodes
            }
            Some('\\') => return self.command(),
            Some('-') => vec![Node::Upright("−".into())],
            Some(' ') => Vec::new(),
            Some(letter) if is_variable(letter) => vec![Node::Italic(letter.into())],
            Some(letter) => vec![Node::Upright(letter.into())],
            None => Vec::new(),
        })
    }

    fn command(&mut self) -> Result<Vec<Node>, String> {
        let mut name = String::new();
        while let Some(letter) = self.peek().filter(char::is_ascii_alphabetic) {
            name.push(letter);
            self.place += 1;
        }
        if name.is_empty() {
            return match self.next() {
                Some('|') => Ok(vec![Node::Upright("‖".into())]),
                Some(',') => Ok(vec![Node::Space(0.17)]),
                other => Err(format!("`\\{}` is not known", other.map(String::from).unwrap_or_default())),
            };
        }
        let accent = |accent, body| Ok(vec![Node::Accent(accent, body)]);
        match name.as_str() {
            "bar" => accent(Accent::Bar, self.argument()?),
            "hat" => accent(Accent::Hat, self.argument()?),
            "tilde" => accent(Accent::Tilde, self.argument()?),
            "mathrm" => Ok(vec![Node::Upright(letters(&self.argument()?))]),
            _ => match NAMED.iter().find(|(known, _)| *known == name) {
                Some((_, letter)) if is_variable(*letter) => Ok(vec![Node::Italic((*letter).into())]),
                Some((_, letter)) => Ok(vec![Node::Upright((*letter).into())]),
                None => Err(format!("`\\{name}` is not known")),
            },
        }
    }
}

/// Latin and small Greek letters; large Greek ones are upright.
fn is_variable(letter: char) -> bool {
    letter.is_ascii_alphabetic() || ('α'..='ω').contains(&letter)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Vec<Node> {
        Label::tex(text).expect("a label").nodes
    }

    #[test]
    fn formulas_have_scripts_and_accents() {
        let italic = |text: &str| Node::Italic(text.into());
        let upright = |text: &str| Node::Upright(text.into());
        let expected = [
            upright("‖"),
            Node::Accent(Accent::Bar, vec![italic("δ")]),
            italic("x"),
            Node::Scripts(vec![italic("i")], vec![upright("2")]),
            upright("‖"),
            upright(" [m]"),
        ];
        assert_eq!(read(r"$\|\bar{δ}x_i^2\|$ [m]"), expected);
        assert_eq!(read(r"$‖\bar\delta x_i^2‖$ [m]"), expected);
        assert_eq!(Label::tex(r"$\|x_{p} - \hat{x}_p\|$").unwrap().letters(), "‖xp − xp‖");
        assert_eq!(Label::power_of_ten(-3).letters(), "10−3");
    }

    #[test]
    fn what_cannot_be_read_is_said() {
        for (text, why) in [
            ("$x", "has no end"),
            ("$x_$", "nothing behind"),
            (r"$\foo$", r"`\foo` is not known"),
            ("${x$", "is not closed"),
            ("$x}$", "nothing opened"),
        ] {
            assert!(Label::tex(text).is_err_and(|error| error.contains(why)), "{text}");
        }
    }

    #[test]
    fn a_plain_text_stays_as_it_is() {
        let label = Label::plain("a$b_c");
        assert_eq!((label.letters().as_str(), label.source()), ("a$b_c", r"a\$b_c"));
        assert!(Label::plain("").is_empty());
    }
}
