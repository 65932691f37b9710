//! Boolean expressions over objects.
//!
//! Operators as for Python's sets, from the tightest: `~` or `!` complement, `-` difference, `&` intersection, `^`
//! symmetric difference, `|` union; binary ones from left to right; parentheses. Blanks mean nothing.

use std::fmt;

use crate::error::{Error, Result};

/// The most objects in an expression: one bit each.
pub const MAX_OBJECTS: usize = 64;

/// The deepest nesting of parentheses.
pub const MAX_NESTING: usize = 256;

/// Binary operators from the loosest.
const BINARY: [(char, Operation); 4] = [
    ('|', Operation::Or),
    ('^', Operation::ExclusiveOr),
    ('&', Operation::And),
    ('-', Operation::Without),
];

/// An expression, as a program for a stack machine. Two are equal if they are written with the same names and
/// operations in the same structure.
///
/// ```
/// use fragloom::effect::csg::Expression;
///
/// let expression = Expression::parse("(a | b) - c")?;
/// assert!(expression.evaluate(0b001) && !expression.evaluate(0b101));
/// let error = Expression::parse("(a | b").unwrap_err();
/// assert_eq!(error.problem(), "csg: column 7: expected an operator (| ^ & -) or ')', found the end");
/// # Ok::<(), fragloom::error::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Expression {
    program: Vec<Operation>,
    names: Vec<Name>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Operation {
    /// Push the bit of a name.
    Object(u8),
    Not,
    Or,
    ExclusiveOr,
    And,
    Without,
}

/// A name at its first occurrence.
#[derive(Clone, Debug)]
struct Name {
    text: String,
    column: usize,
}

impl PartialEq for Expression {
    fn eq(&self, other: &Self) -> bool {
        self.program == other.program && self.names().eq(other.names())
    }
}

impl Expression {
    /// Read an expression.
    ///
    /// # Errors
    /// The column, counted in characters from 1, what was expected there and what was found; more than [`MAX_OBJECTS`]
    /// names, or parentheses nested deeper than [`MAX_NESTING`].
    pub fn parse(text: &str) -> Result<Self> {
        let characters = text.chars().collect();
        let (program, names) = (Vec::new(), Vec::new());
        let mut parser =
            Parser { characters, at: 0, nesting: 0, expression: Self { program, names } };
        parser.binary(0)?;
        parser.blanks();
        if parser.at < parser.characters.len() {
            return Err(parser.expected("an operator (| ^ & -) or the end"));
        }
        Ok(parser.expression)
    }

    /// The objects, in the order of their first occurrence: bit i of [`Expression::evaluate`] is the i-th.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(|name| name.text.as_str())
    }

    /// The value at a point inside of the objects whose bits are set.
    #[must_use]
    pub fn evaluate(&self, inside: u64) -> bool {
        self.evaluate_on(inside, &mut Vec::new())
    }

    /// As [`Expression::evaluate`], with reused memory.
    pub(super) fn evaluate_on(&self, inside: u64, stack: &mut Vec<bool>) -> bool {
        stack.clear();
        // A parsed program never finds too few values on the stack.
        let pop = |stack: &mut Vec<bool>| stack.pop().unwrap_or_default();
        for &operation in &self.program {
            let value = match operation {
                Operation::Object(bit) => inside >> bit & 1 == 1,
                Operation::Not => !pop(stack),
                _ => {
                    let (right, left) = (pop(stack), pop(stack));
                    match operation {
                        Operation::Or => left | right,
                        Operation::ExclusiveOr => left ^ right,
                        Operation::And => left & right,
                        _ => left & !right,
                    }
                }
            };
            stack.push(value);
        }
        pop(stack)
    }

    /// The index of every name among `objects`.
    ///
    /// # Errors
    /// A name that is not there, with its column and the names that are.
    pub fn bind(&self, objects: &[String]) -> Result<Vec<usize>> {
        let place = |name: &Name| {
            objects.iter().position(|object| *object == name.text).ok_or_else(|| {
                let Name { text, column } = name;
                let known = match objects {
                    [] => "no objects at all".to_owned(),
                    [some @ .., last] if some.len() > 15 => {
                        format!("{}, ..., {last}", some[..15].join(", "))
                    }
                    all => all.join(", "),
                };
                wrong(
                    *column,
                    &format!("there is no object {text:?} in the scene; there are {known}"),
                )
            })
        };
        self.names.iter().map(place).collect()
    }
}

fn wrong(column: usize, problem: &str) -> Error {
    Error::new("--effect", format!("csg: column {column}: {problem}"))
}

/// Recursive descent: a call per level of precedence and parenthesis; nesting is limited.
struct Parser {
    characters: Vec<char>,
    at: usize,
    nesting: usize,
    expression: Expression,
}

impl Parser {
    fn binary(&mut self, level: usize) -> Result<()> {
        let Some(&(sign, operation)) = BINARY.get(level) else { return self.unary() };
        self.binary(level + 1)?;
        while self.take(|c| c == sign) {
            self.binary(level + 1)?;
            self.expression.program.push(operation);
        }
        Ok(())
    }

    fn unary(&mut self) -> Result<()> {
        let mut complements = 0;
        while self.take(|c| c == '~' || c == '!') {
            complements += 1;
        }
        if self.take(|c| c == '(') {
            self.nesting += 1;
            if self.nesting > MAX_NESTING {
                return Err(wrong(self.at, &format!("more than {MAX_NESTING} nested parentheses")));
            }
            self.binary(0)?;
            if !self.take(|c| c == ')') {
                return Err(self.expected("an operator (| ^ & -) or ')'"));
            }
            self.nesting -= 1;
        } else {
            self.name()?;
        }
        self.expression.program.extend(std::iter::repeat_n(Operation::Not, complements));
        Ok(())
    }

    fn name(&mut self) -> Result<()> {
        self.blanks();
        let start = self.at;
        let rest = &self.characters[start..];
        let letter = |c: &&char| c.is_ascii_alphanumeric() || **c == '_';
        let text: String = rest.iter().take_while(letter).collect();
        if text.is_empty() || text.starts_with(|c: char| c.is_ascii_digit()) {
            return Err(self.expected("an object's name, ~ or ("));
        }
        self.at += text.len();
        let names = &mut self.expression.names;
        let place = names.iter().position(|name| name.text == text).unwrap_or(names.len());
        if place == MAX_OBJECTS {
            let problem = format!("{text:?} is one more than {MAX_OBJECTS} objects");
            return Err(wrong(start + 1, &problem));
        }
        if place == names.len() {
            names.push(Name { text, column: start + 1 });
        }
        self.expression.program.push(Operation::Object(place as u8));
        Ok(())
    }

    /// Pass the next character that is not blank, if it is one of these.
    fn take(&mut self, wanted: impl Fn(char) -> bool) -> bool {
        self.blanks();
        let found = self.characters.get(self.at).is_some_and(|&c| wanted(c));
        self.at += usize::from(found);
        found
    }

    fn blanks(&mut self) {
        while self.characters.get(self.at).is_some_and(|c| c.is_whitespace()) {
            self.at += 1;
        }
    }

    fn expected(&self, what: &str) -> Error {
        let found = match self.characters.get(self.at) {
            Some(c) => format!("{c:?}"),
            None => "the end".to_owned(),
        };
        wrong(self.at + 1, &format!("expected {what}, found {found}"))
    }
}

/// With the fewest parentheses that keep the structure.
impl fmt::Display for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const UNARY: usize = BINARY.len();
        let mut stack: Vec<(String, usize)> = Vec::new();
        let enclose = |(text, level): (String, usize), least: usize| {
            if level < least { format!("({text})") } else { text }
        };
        for operation in &self.program {
            let last = stack.pop();
            let both = (last, BINARY.iter().position(|(_, known)| known == operation));
            match (operation, both) {
                (Operation::Object(bit), (last, _)) => {
                    stack.extend(last);
                    stack.push((self.names[usize::from(*bit)].text.clone(), UNARY));
                }
                (_, (Some(right), Some(level))) => {
                    let (mut text, left) = stack.pop().unwrap_or_default();
                    if left < level {
                        text = format!("({text})");
                    }
                    let right = enclose(right, level + 1);
                    text.extend([" ", &BINARY[level].0.to_string(), " ", &right]);
                    stack.push((text, level));
                }
                (_, (Some(inner), None)) => {
                    stack.push((format!("~{}", enclose(inner, UNARY)), UNARY));
                }
                _ => {}
            }
        }
        stack.into_iter().try_for_each(|(text, _)| f.write_str(&text))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(text: &str) -> String {
        Expression::parse(text).unwrap().to_string()
    }

    fn problem(text: &str) -> String {
        Expression::parse(text).unwrap_err().problem().to_owned()
    }

    #[test]
    fn precedence_and_association() {
        assert_eq!(shown("a|b^c&d-~e"), "a | b ^ c & d - ~e");
        assert_eq!(shown("((a-b)-c)"), "a - b - c");
        assert_eq!(shown("a-(b-c)"), "a - (b - c)");
        assert_eq!(shown("!(a|b)&(c)"), "~(a | b) & c");
        assert_eq!(shown("~~a"), "~~a");
        let value = |text: &str, bits| Expression::parse(text).unwrap().evaluate(bits);
        assert!(value("a | b - c", 0b001) && value("a | b - c", 0b101));
        assert!(!value("(a | b) - c", 0b101));
        assert!(value("a ^ b", 0b01) && !value("a ^ b", 0b11) && value("~a", 0));
    }

    #[test]
    fn what_is_wrong_is_told_with_its_column() {
        assert!(problem("").starts_with("csg: column 1: expected an object's name"));
        assert!(
            problem("a |").ends_with("column 4: expected an object's name, ~ or (, found the end")
        );
        assert!(
            problem("a b")
                .ends_with("column 3: expected an operator (| ^ & -) or the end, found 'b'")
        );
        assert!(problem("ü").contains("column 1:") && problem("a+b").contains("column 2:"));
        assert!(problem("(a))").contains("column 4:") && problem("1a").contains("column 1:"));
        let objects = ["a".to_owned(), "b".to_owned()];
        let unknown = Expression::parse("a - x1").unwrap().bind(&objects).unwrap_err().to_string();
        let right =
            "--effect: csg: column 5: there is no object \"x1\" in the scene; there are a, b";
        assert_eq!(unknown, right);
    }

    #[test]
    fn limits() {
        let nested = |n: usize| format!("{}a{}", "(".repeat(n), ")".repeat(n));
        assert!(Expression::parse(&nested(MAX_NESTING)).is_ok());
        assert!(problem(&nested(MAX_NESTING + 1)).contains("column 257: more than 256"));
        assert!(problem(&"(".repeat(1 << 20)).contains("nested parentheses"));
        let many = |n: usize| (0..n).map(|i| format!("x{i}")).collect::<Vec<_>>().join("|");
        assert!(Expression::parse(&many(64)).unwrap().evaluate(1 << 63));
        assert!(problem(&many(65)).contains("one more than 64 objects"));
        let long = format!("{}a", "a-".repeat(100_000));
        assert!(!Expression::parse(&long).unwrap().evaluate(1));
        assert!(Expression::parse(&format!("{}a", "~".repeat(100_000))).unwrap().evaluate(1));
    }
}
