//! Reading a tree into a type, all mistakes at once.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;

use serde::de::{self, DeserializeOwned, DeserializeSeed};

use super::reader::Reader;
use super::stand_in::StandIn;
use super::{Node, Origin, Problem, Problems, Sort, brief, did_you_mean};

/// Reads `node`, found at `path` in its file, as a `T`. All mistakes are added to `problems`; if there were any, there
/// is no value.
///
/// Beyond what serde defines:
/// - Unknown fields are mistakes, with or without `deny_unknown_fields`.
/// - An `f64` may be an integer, or a string with a formula of constants such as `"pi/4"`.
/// - An enum with data may be a table whose `kind` names the variant and whose other keys are its fields:
///   `{ kind = "circle", radius = 3 }` is `Circle { radius: 3.0 }` or `Circle(Parameters { radius: 3.0 })`.
///
/// Types with `#[serde(flatten)]`, `#[serde(untagged)]` or `#[serde(tag = "...")]` pass through a buffer of serde's own.
/// They work, but messages about their inside point to the whole value, and formulas in there are just strings.
///
/// ```
/// use std::sync::Arc;
/// use formation::config::{Node, Problems, Source, read};
///
/// #[derive(serde::Deserialize)]
/// struct Gains {
///     c_p: f64,
///     k_p: f64,
/// }
///
/// let source = Source { name: "gains.toml".into(), text: "c_p = \"pi/2\"\nk_q = 1\n".into() };
/// let node = Node::parse(Arc::new(source)).unwrap();
/// let mut problems = Problems::default();
/// assert!(read::<Gains>(&node, "", &mut problems).is_none());
/// assert_eq!(
///     problems.to_string(),
///     "gains.toml: missing field `k_p`\n\
///      \n\
///      gains.toml:2:1: k_q: unknown field\n   \
///         |\n \
///       2 | k_q = 1\n   \
///         | ^^^\n   \
///         = expected one of c_p, k_p; did you mean `k_p`?"
/// );
/// ```
pub fn read<T: DeserializeOwned>(node: &Node, path: &str, problems: &mut Problems) -> Option<T> {
    let state = RefCell::new(State::default());
    let round = || descend(PhantomData::<T>, Some(node), &node.origin, path.into(), &state);
    // A round that only placed a mistake is followed by another one; any other result is final.
    let last = (0..ROUND_LIMIT).map(|_| round()).find(|result| !matches!(result, Err(Failure::Placed)));
    let State { unknown, mut found, .. } = state.into_inner();
    let clean = unknown.is_empty() && found.is_empty();
    found.extend(unknown.into_values());
    found.sort_by(|a, b| a.origin.as_ref().map(Origin::order).cmp(&b.origin.as_ref().map(Origin::order)));
    problems.extend(found);
    if last.is_none() {
        problems.push(Problem::of(&node.origin, path, "too many mistakes, further ones are not listed"));
    }
    last.and_then(Result::ok).filter(|_| clean)
}

/// Reading gives up looking for further mistakes after so many rounds; each finds one or tries a stand-in for one.
const ROUND_LIMIT: usize = 200;

/// What is known about the mistakes of a tree while it is read.
///
/// A derived visitor stops at the first error, because it has no value to go on with. So the tree is read in rounds: a
/// place with a mistake is noted, and in the next round gets a stand-in of whatever type is wanted there.
#[derive(Default)]
pub(super) struct State {
    /// Unknown fields by path. They stop nothing.
    unknown: BTreeMap<String, Problem>,
    /// The other problems.
    found: Vec<Problem>,
    /// Places that get a stand-in, with the number of the one to try: a type with conditions may not like the first.
    stand_ins: BTreeMap<String, usize>,
}

impl State {
    /// Records a problem and puts a stand-in in the place of the value at `path`.
    pub(super) fn refuse(&mut self, problem: Problem, path: &str) -> Failure {
        self.found.push(problem);
        self.stand_ins.insert(path.into(), 0);
        Failure::Placed
    }

    /// Records an unknown field.
    pub(super) fn unknown(&mut self, origin: &Origin, path: String, expected: &[&str], key: &str) {
        let help = match expected {
            [] => "no fields are expected here".into(),
            _ => expectation(expected, key),
        };
        let problem = Problem::of(origin, &path, "unknown field").with_help(help).sorted(Sort::Unknown);
        self.unknown.insert(path, problem);
    }

    /// Whether there is a stand-in at `path`.
    pub(super) fn stands_in(&self, path: &str) -> bool {
        self.stand_ins.contains_key(path)
    }

    /// Gives a failure of the value at `path` its place.
    fn place(&mut self, failure: Failure, origin: &Origin, path: &str) -> Failure {
        match failure {
            Failure::Placed => Failure::Placed,
            // Only stand-ins fail without a mistake of their own, and a condition on a value made of stand-ins says
            // nothing about what the user wrote.
            Failure::Hopeless => {
                self.stand_ins.insert(path.into(), 0);
                Failure::Placed
            }
            Failure::Mistake { .. } if self.stands_in_below(path) => {
                self.stand_ins.insert(path.into(), 0);
                Failure::Placed
            }
            Failure::Mistake { message, help } => {
                self.refuse(Problem { help, ..Problem::of(origin, path, message) }, path)
            }
            Failure::MissingField(field) => {
                self.refuse(Problem::of(origin, path, missing(field)).sorted(Sort::Missing), path)
            }
        }
    }

    fn stands_in_below(&self, path: &str) -> bool {
        let is_below =
            |place: &String| place.strip_prefix(path).is_some_and(|rest| path.is_empty() || rest.starts_with('.'));
        self.stand_ins
            .range(path.to_string()..)
            .take_while(|(place, _)| place.starts_with(path))
            .any(|(p, _)| is_below(p))
    }
}

/// The message for a table without `field`.
pub(super) fn missing(field: &str) -> String {
    format!("missing field `{field}`")
}

/// Names that would be right.
pub(super) fn expectation(expected: &[&str], found: &str) -> String {
    let list = match expected {
        [only] => format!("expected {only}"),
        _ => format!("expected one of {}", expected.join(", ")),
    };
    list + &did_you_mean(found, expected.iter().copied())
}

/// Reads the value at `path`, or the stand-in for it if there is one; every error gets its place here. `node` may only
/// be absent if there is a stand-in.
pub(super) fn descend<'de, S: DeserializeSeed<'de>>(
    seed: S,
    node: Option<&Node>,
    origin: &Origin,
    path: String,
    state: &RefCell<State>,
) -> Result<S::Value, Failure> {
    let attempt = state.borrow().stand_ins.get(&path).copied();
    match (attempt, node) {
        (None, Some(node)) => seed
            .deserialize(Reader::new(node, path.clone(), state))
            .map_err(|failure| state.borrow_mut().place(failure, origin, &path)),
        (attempt, _) => seed.deserialize(StandIn::new(attempt.unwrap_or(0))).map_err(|_| {
            let next = attempt.unwrap_or(0) + 1;
            state.borrow_mut().stand_ins.insert(path, next);
            if next < StandIn::ATTEMPTS { Failure::Placed } else { Failure::Hopeless }
        }),
    }
}

/// Why a value could not be delivered.
#[derive(Debug)]
pub(super) enum Failure {
    /// A mistake that has been recorded.
    Placed,
    /// No stand-in satisfies the type, so the value around it needs one.
    Hopeless,
    /// A mistake that no one has given a place yet.
    Mistake {
        /// What is wrong.
        message: String,
        /// What would be right.
        help: Option<String>,
    },
    /// A table lacks this field.
    MissingField(&'static str),
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Failure::Placed | Failure::Hopeless => f.write_str("reported elsewhere"),
            Failure::Mistake { message, .. } => f.write_str(message),
            Failure::MissingField(field) => f.write_str(&missing(field)),
        }
    }
}

impl std::error::Error for Failure {}

impl de::Error for Failure {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Failure::Mistake { message: message.to_string(), help: None }
    }

    fn invalid_type(found: de::Unexpected, expected: &dyn de::Expected) -> Self {
        Self::custom(format!("expected {expected}, found {found}"))
    }

    fn invalid_value(found: de::Unexpected, expected: &dyn de::Expected) -> Self {
        Self::invalid_type(found, expected)
    }

    fn invalid_length(found: usize, expected: &dyn de::Expected) -> Self {
        Self::custom(format!("expected {expected}, found {found} values"))
    }

    fn unknown_variant(found: &str, expected: &'static [&'static str]) -> Self {
        Failure::Mistake {
            message: format!("unknown name {:?}", brief(found)),
            help: Some(expectation(expected, found)),
        }
    }

    fn unknown_field(found: &str, expected: &'static [&'static str]) -> Self {
        Failure::Mistake {
            message: format!("unknown field {:?}", brief(found)),
            help: Some(expectation(expected, found)),
        }
    }

    fn missing_field(field: &'static str) -> Self {
        Failure::MissingField(field)
    }

    fn duplicate_field(field: &'static str) -> Self {
        Self::custom(format!("the field `{field}` is given twice, under two names"))
    }
}
