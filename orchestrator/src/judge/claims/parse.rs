//! Tokens of a claim to its tree, by recursive descent.

use super::condition::{Condition, Extreme, Need, Number, Relation, Term};
use super::token::{Kind, Mistake, Token, Tokens};

/// Longest claim in bytes.
const LONGEST: usize = 4096;

/// Deepest nesting of parentheses, calls and signs. Bounds the recursion.
const DEEPEST: usize = 64;

/// A claim that has been read.
#[derive(Clone, Debug)]
pub(super) struct Parsed {
    pub(super) condition: Condition,
    /// The metrics it is about, each once, with the place of the variant's name where it first appears.
    pub(super) needs: Vec<(usize, Need)>,
}

/// Parses a whole claim.
pub(super) fn parse(text: &str) -> Result<Parsed, Mistake> {
    if text.len() > LONGEST {
        return Err(Mistake::new(0, format!("expected a claim of at most {LONGEST} bytes, found {}", text.len())));
    }
    let mut tokens = Tokens::new(text);
    let token = tokens.next()?;
    if token.kind == Kind::End {
        return Err(Mistake::new(0, "expected a claim such as dx(A) < dx(B), found an empty text"));
    }
    let mut parser = Parser { tokens, token, end: 0, depth: 0, needs: Vec::new() };
    let whole = parser.either()?;
    if parser.token.kind != Kind::End {
        return Err(parser.unexpected("an operator, `and`, `or` or the end of the claim"));
    }
    let condition = whole.condition(0)?;
    Ok(Parsed { condition, needs: parser.needs })
}

/// Parentheses stand around numbers and around conditions, so what a part is shows only when it is read.
enum Part {
    Number(Number),
    Condition(Condition),
}

impl Part {
    fn number(self, offset: usize) -> Result<Number, Mistake> {
        match self {
            Part::Number(number) => Ok(number),
            Part::Condition(_) => Err(Mistake::new(offset, "expected a number, found something that holds or not")),
        }
    }

    fn condition(self, offset: usize) -> Result<Condition, Mistake> {
        match self {
            Part::Condition(condition) => Ok(condition),
            Part::Number(_) => {
                Err(Mistake::new(offset, "expected a comparison such as dx(A) < dx(B), found just a number"))
            }
        }
    }
}

struct Parser<'a> {
    tokens: Tokens<'a>,
    /// The token that is to be consumed next.
    token: Token<'a>,
    /// Where the token before it ended.
    end: usize,
    depth: usize,
    needs: Vec<(usize, Need)>,
}

impl<'a> Parser<'a> {
    fn either(&mut self) -> Result<Part, Mistake> {
        self.combination("or", Self::both, Condition::Or)
    }

    fn both(&mut self) -> Result<Part, Mistake> {
        self.combination("and", Self::comparison, Condition::And)
    }

    fn combination(
        &mut self,
        keyword: &str,
        part: impl Fn(&mut Self) -> Result<Part, Mistake>,
        combine: impl Fn(Box<Condition>, Box<Condition>) -> Condition,
    ) -> Result<Part, Mistake> {
        let start = self.token.start;
        let mut all = part(self)?;
        while self.token.kind == Kind::Name(keyword) {
            self.advance()?;
            let place = self.token.start;
            let next = part(self)?.condition(place)?;
            all = Part::Condition(combine(Box::new(all.condition(start)?), Box::new(next)));
        }
        Ok(all)
    }

    /// `a < b`, or several in a row, each of which has to hold.
    fn comparison(&mut self) -> Result<Part, Mistake> {
        let start = self.token.start;
        let first = self.sum()?;
        let Kind::Relation(relation) = self.token.kind else { return Ok(first) };
        let mut left = self.term(first, start)?;
        let mut all = self.compare(&mut left, relation)?;
        while let Kind::Relation(relation) = self.token.kind {
            let next = self.compare(&mut left, relation)?;
            all = Condition::And(Box::new(all), Box::new(next));
        }
        Ok(Part::Condition(all))
    }

    /// Compares `left` with what follows, which is the left side of a comparison behind it.
    fn compare(&mut self, left: &mut Term, relation: Relation) -> Result<Condition, Mistake> {
        self.advance()?;
        let start = self.token.start;
        let part = self.sum()?;
        let right = self.term(part, start)?;
        Ok(Condition::Compare(std::mem::replace(left, right.clone()), relation, right))
    }

    fn term(&self, part: Part, start: usize) -> Result<Term, Mistake> {
        Ok(Term { number: part.number(start)?, text: self.tokens.text(start, self.end).into() })
    }

    fn sum(&mut self) -> Result<Part, Mistake> {
        self.chain(&['+', '-'], Self::product)
    }

    fn product(&mut self) -> Result<Part, Mistake> {
        self.chain(&['*', '/'], Self::signed)
    }

    fn chain(
        &mut self,
        operators: &[char],
        operand: impl Fn(&mut Self) -> Result<Part, Mistake>,
    ) -> Result<Part, Mistake> {
        let start = self.token.start;
        let mut all = operand(self)?;
        while let Kind::Symbol(operator) = self.token.kind
            && operators.contains(&operator)
        {
            self.advance()?;
            let place = self.token.start;
            let right = operand(self)?.number(place)?;
            all = Part::Number(Number::Binary(operator, Box::new(all.number(start)?), Box::new(right)));
        }
        Ok(all)
    }

    fn signed(&mut self) -> Result<Part, Mistake> {
        if self.token.kind != Kind::Symbol('-') {
            return self.primary();
        }
        self.advance()?;
        let place = self.token.start;
        let number = self.nested(Self::signed)?.number(place)?;
        Ok(Part::Number(Number::Negate(Box::new(number))))
    }

    fn primary(&mut self) -> Result<Part, Mistake> {
        match self.token.kind {
            Kind::Number(value) => {
                self.advance()?;
                Ok(Part::Number(Number::Constant(value)))
            }
            Kind::Symbol('(') => {
                self.advance()?;
                let inner = self.nested(Self::either)?;
                self.close()?;
                Ok(inner)
            }
            Kind::Name(name @ ("abs" | "min" | "max" | "not_finite")) => {
                self.advance()?;
                self.function(name)
            }
            Kind::Name("and" | "or") | Kind::Relation(_) | Kind::Symbol(_) | Kind::End => {
                Err(self.unexpected("a metric, a number or '('"))
            }
            Kind::Name(metric) | Kind::Quoted(metric) => {
                self.advance()?;
                self.metric(metric)
            }
        }
    }

    /// The arguments behind the name of a function.
    fn function(&mut self, name: &str) -> Result<Part, Mistake> {
        if self.token.kind != Kind::Symbol('(') {
            return Err(self.unexpected(&format!("'(' behind the function '{name}'")));
        }
        self.advance()?;
        let place = self.token.start;
        let mut arguments = vec![self.argument()?];
        while self.token.kind == Kind::Symbol(',') {
            self.advance()?;
            arguments.push(self.argument()?);
        }
        self.close()?;
        let extreme = |extreme, arguments: Vec<Term>| {
            Part::Number(Number::Extreme(extreme, arguments.into_iter().map(|term| term.number).collect()))
        };
        match (name, arguments.len()) {
            ("min", _) => Ok(extreme(Extreme::Least, arguments)),
            ("max", _) => Ok(extreme(Extreme::Largest, arguments)),
            ("abs", 1) => Ok(Part::Number(Number::Absolute(Box::new(arguments.remove(0).number)))),
            (_, 1) => Ok(Part::Condition(Condition::NotFinite(arguments.remove(0)))),
            (_, found) => Err(Mistake::new(place, format!("expected one argument of '{name}', found {found}"))),
        }
    }

    fn argument(&mut self) -> Result<Term, Mistake> {
        let start = self.token.start;
        let part = self.nested(Self::sum)?;
        self.term(part, start)
    }

    /// The variant behind the id of a metric. The parenthesis is the current token, so the tokens stand behind it.
    fn metric(&mut self, metric: &str) -> Result<Part, Mistake> {
        if self.token.kind != Kind::Symbol('(') {
            return Err(self.unexpected(&format!("the variant behind the metric '{metric}', as in {metric}(VARIANT)")));
        }
        let (offset, variant) = self.tokens.variant()?;
        self.advance()?;
        self.close()?;
        let need = Need { variant: variant.into(), metric: metric.into() };
        let known = self.needs.iter().position(|(_, other)| *other == need);
        let index = known.unwrap_or_else(|| {
            self.needs.push((offset, need));
            self.needs.len() - 1
        });
        Ok(Part::Number(Number::Metric(index)))
    }

    fn close(&mut self) -> Result<(), Mistake> {
        if self.token.kind == Kind::Symbol(')') { self.advance() } else { Err(self.unexpected("an operator or ')'")) }
    }

    fn nested<T>(&mut self, inner: impl Fn(&mut Self) -> Result<T, Mistake>) -> Result<T, Mistake> {
        if self.depth == DEEPEST {
            let message =
                format!("expected at most {DEEPEST} parentheses, calls and signs within each other, found more");
            return Err(Mistake::new(self.token.start, message));
        }
        self.depth += 1;
        let result = inner(self)?;
        self.depth -= 1;
        Ok(result)
    }

    fn advance(&mut self) -> Result<(), Mistake> {
        self.end = self.token.end;
        self.token = self.tokens.next()?;
        Ok(())
    }

    fn unexpected(&self, expected: &str) -> Mistake {
        Mistake::new(self.token.start, format!("expected {expected}, found {}", self.token.describe()))
    }
}
