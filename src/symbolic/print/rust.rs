//! Rust.

use crate::graph::{Node, Number};
use crate::input::{Input, Shape};
use crate::print::c::{coefficient, double, number, quotient, unsigned};
use crate::print::{Language, Text, call};

/// Expressions in Rust.
pub struct Rust;

impl Language for Rust {
    fn number(&self, of: Number) -> Text {
        number(of)
    }

    fn pi(&self) -> Text {
        double(std::f64::consts::PI)
    }

    fn input(&self, input: &Input, place: usize) -> Text {
        let name = input.name.to_lowercase();
        Text::atom(match input.shape {
            Shape::Scalar => name,
            Shape::List(_) => format!("{name}[{place}]"),
            Shape::Matrix => format!("{name}[{}][{}]", place / 3, place % 3),
        })
    }

    fn function(&self, node: &Node, of: &[Text]) -> Text {
        let name = match node {
            Node::Divide(..) => return quotient(of),
            Node::Select { .. } => {
                let [less, than, yes, no] = of else { return Text::atom("0") };
                let [less, than, yes, no] = [less, than, yes, no].map(|text| &text.text);
                return Text::atom(format!("select({less} < {than}, {yes}, {no})"));
            }
            Node::Norm(_) => {
                let of: Vec<&str> = of.iter().map(|text| text.text.as_str()).collect();
                return Text::atom(format!("norm(&[{}])", of.join(", ")));
            }
            Node::CosineOfRoot(n, _) => return coefficient("root_coefficient", &format!("{n}, 1"), of),
            Node::SineOfRoot(n, _) => return coefficient("0.5 * root_coefficient", &format!("{n}, 3"), of),
            Node::Logarithm(n, _) => return coefficient("log_coefficient", &n.to_string(), of),
            Node::Reciprocal(_) => "reciprocal",
            Node::SquareRoot(_) => "f64::sqrt",
            Node::Magnitude(_) => "f64::abs",
            Node::Sign(_) => "sign",
            Node::Sine(_) => "f64::sin",
            Node::Cosine(_) => "f64::cos",
            Node::Exponential(_) => "f64::exp",
            Node::ExponentialMinusOne(_) => "f64::exp_m1",
            Node::Power(..) => "f64::powf",
            Node::Arctangent(..) => "f64::atan2",
            _ => "f64::round",
        };
        call(name, of)
    }

    fn unsigned(&self, x: &Text) -> Text {
        unsigned(x)
    }

    fn quaternion(&self, name: &str, of: &[Text]) -> String {
        let of: Vec<&str> = of.iter().map(|text| text.text.as_str()).collect();
        format!("let {name} = quaternion(&[{}]);", of.join(", "))
    }

    fn part(&self, name: &str, part: u8) -> Text {
        Text::atom(format!("{name}[{part}]"))
    }

    fn assign(&self, name: &str, value: &str) -> String {
        format!("let {name} = {value};")
    }
}
