//! Formulas in Unicode, for a terminal.

use crate::graph::{Node, Number};
use crate::input::{Input, Shape};
use crate::print::{Language, Level, Text};

/// Expressions in Unicode, for a terminal.
pub struct Unicode;

/// The names of the parts of a quaternion.
pub(super) const PART: [&str; 4] = ["w", "x", "y", "z"];

impl Language for Unicode {
    fn number(&self, of: Number) -> Text {
        match of {
            Number::Ratio(p, 1) if p < 0 => Text::new(format!("−{}", p.unsigned_abs()), Level::Sum),
            Number::Ratio(p, 1) => Text::atom(p.to_string()),
            Number::Ratio(p, q) if p < 0 => Text::new(format!("−{}/{q}", p.unsigned_abs()), Level::Sum),
            Number::Ratio(p, q) => Text::new(format!("{p}/{q}"), Level::Product),
            Number::Double(bits) => Text::atom(format!("{:?}", f64::from_bits(bits)).replace('-', "−")),
        }
    }

    fn pi(&self) -> Text {
        Text::atom("π")
    }

    fn input(&self, input: &Input, place: usize) -> Text {
        let symbol = &input.symbol;
        match (input.shape, symbol.as_str()) {
            (Shape::List(3), "d") => Text::atom(format!("e{}a·d", place + 1)),
            (Shape::Matrix, "Q") => Text::atom(format!("e{}a·e{}b", place / 3 + 1, place % 3 + 1)),
            (Shape::Scalar, _) => Text::atom(symbol.clone()),
            (Shape::List(_), list) if list.contains(' ') => {
                Text::atom(list.split(' ').nth(place).unwrap_or(list))
            }
            (Shape::List(_), _) => Text::atom(format!("{symbol}{}", place + 1)),
            (Shape::Matrix, _) => Text::atom(format!("{symbol}[{},{}]", place / 3 + 1, place % 3 + 1)),
        }
    }

    fn function(&self, node: &Node, of: &[Text]) -> Text {
        let first = of.first().map_or("", |text| text.text.as_str());
        let all = || of.iter().map(|text| text.text.as_str()).collect::<Vec<_>>().join(", ");
        let tight = |text: &Text| {
            if text.text.contains('·') || text.level < Level::Atom {
                format!("({})", text.text)
            } else {
                text.text.clone()
            }
        };
        match node {
            Node::Divide(..) => {
                let [x, y] = of else { return Text::atom("0") };
                Text::new(format!("{}/{}", tight(x), tight(y)), Level::Product)
            }
            Node::Reciprocal(_) => {
                Text::new(format!("1/{}", of.first().map_or(String::new(), tight)), Level::Product)
            }
            Node::Select { .. } => {
                let [less, than, yes, no] = of else { return Text::atom("0") };
                let [less, than, yes, no] = [less, than, yes, no].map(|text| &text.text);
                Text::atom(format!("{{{yes} where {less} < {than}, else {no}}}"))
            }
            Node::Norm(_) => Text::atom(format!("|({})|", all())),
            Node::Magnitude(_) => Text::atom(format!("|{first}|")),
            Node::Sign(_) => Text::atom(format!("sgn({first})")),
            Node::SquareRoot(_) => Text::atom(format!("√({first})")),
            Node::Sine(_) => Text::atom(format!("sin({first})")),
            Node::Cosine(_) => Text::atom(format!("cos({first})")),
            Node::Exponential(_) => Text::atom(format!("exp({first})")),
            Node::ExponentialMinusOne(_) => Text::new(format!("exp({first}) − 1"), Level::Sum),
            Node::Power(..) => {
                let [x, p] = of else { return Text::atom("0") };
                Text::atom(format!("({})^({})", x.text, p.text))
            }
            Node::Arctangent(..) => Text::atom(format!("atan2({})", all())),
            Node::CosineOfRoot(n, _) => Text::atom(format!("{}({first})", primed("W", *n))),
            Node::SineOfRoot(n, _) => Text::atom(format!("{}({first})", primed("k", *n))),
            Node::Logarithm(n, _) => Text::atom(format!("{}({first})", primed("K", *n))),
            _ => Text::atom(format!("round({first})")),
        }
    }

    fn quaternion(&self, name: &str, of: &[Text]) -> String {
        let entries: Vec<&str> = of.iter().map(|text| text.text.as_str()).collect();
        let is_q = entries.first() == Some(&"e1a·e1b") && entries.last() == Some(&"e3a·e3b");
        let of = if is_q { "Q".to_string() } else { format!("[{}]", entries.join(", ")) };
        format!("{name} = unit quaternion (w, x, y, z) of {of}, w ≥ 0")
    }

    fn part(&self, name: &str, part: u8) -> Text {
        Text::atom(format!("{name}.{}", PART[usize::from(part) % 4]))
    }

    fn assign(&self, name: &str, value: &str) -> String {
        format!("{name} = {value}")
    }

    fn times(&self) -> &'static str {
        " "
    }

    fn minus(&self) -> [&'static str; 2] {
        ["−", " − "]
    }

    fn factor(&self, text: &Text) -> String {
        let is_dotted = text.level == Level::Atom && text.text.starts_with('e') && text.text.contains('·');
        if is_dotted { format!("({})", text.text) } else { text.at(Level::Product) }
    }

    fn longest(&self) -> usize {
        160
    }
}

/// The n-th Taylor coefficient of a function, by primes: K, K′, K″/2.
fn primed(name: &str, n: u32) -> String {
    match n {
        0 => name.into(),
        1 => format!("{name}′"),
        2 => format!("½{name}″"),
        _ => format!("{name}⁽{n}⁾/{n}! "),
    }
}
