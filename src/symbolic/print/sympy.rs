//! Python on SymPy expressions.

use crate::graph::{Node, Number};
use crate::input::Input;
use crate::print::c::{coefficient, quotient};
use crate::print::jax::indexed;
use crate::print::{Language, Level, Text, call};

/// Expressions in Python on SymPy expressions.
pub struct Sympy;

impl Language for Sympy {
    fn number(&self, of: Number) -> Text {
        match of {
            Number::Ratio(p, 1) if p < 0 => Text::new(p.to_string(), Level::Sum),
            Number::Ratio(p, 1) => Text::atom(p.to_string()),
            Number::Ratio(p, q) => Text::atom(format!("Rational({p}, {q})")),
            // The exact ratio of the double.
            Number::Double(bits) => Text::atom(format!("Rational({:?})", f64::from_bits(bits))),
        }
    }

    fn pi(&self) -> Text {
        Text::atom("pi")
    }

    fn input(&self, input: &Input, place: usize) -> Text {
        indexed(input, place)
    }

    fn function(&self, node: &Node, of: &[Text]) -> Text {
        let name = match node {
            Node::Divide(..) => return quotient(of),
            Node::Power(..) => {
                let [x, p] = of else { return Text::atom("0") };
                return Text::atom(format!("({})**({})", x.text, p.text));
            }
            Node::ExponentialMinusOne(_) => {
                return Text::new(format!("{} - 1", call("exp", of).text), Level::Sum);
            }
            Node::CosineOfRoot(n, _) => return coefficient("root_coefficient", &format!("{n}, 1"), of),
            Node::SineOfRoot(n, _) => {
                return coefficient("Rational(1, 2) * root_coefficient", &format!("{n}, 3"), of);
            }
            Node::Logarithm(n, _) => return coefficient("log_coefficient", &n.to_string(), of),
            Node::Select { .. } => "select",
            Node::Norm(_) => "norm",
            Node::Reciprocal(_) => "reciprocal",
            Node::SquareRoot(_) => "sqrt",
            Node::Magnitude(_) => "Abs",
            Node::Sign(_) => "sign",
            Node::Sine(_) => "sin",
            Node::Cosine(_) => "cos",
            Node::Exponential(_) => "exp",
            Node::Arctangent(..) => "atan2",
            _ => "nearest_integer",
        };
        call(name, of)
    }

    fn quaternion(&self, name: &str, of: &[Text]) -> String {
        format!("{name} = {}", call("quaternion", of).text)
    }

    fn part(&self, name: &str, part: u8) -> Text {
        Text::atom(format!("{name}[{part}]"))
    }

    fn assign(&self, name: &str, value: &str) -> String {
        format!("{name} = {value}")
    }
}
