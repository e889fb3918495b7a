//! Python on JAX arrays.

use crate::graph::{Node, Number};
use crate::input::{Input, Shape};
use crate::print::c::{coefficient, double, number, quotient};
use crate::print::{Language, Text, call};

/// Expressions in Python on JAX arrays.
pub struct Jax;

/// The entry of an input in Python.
pub(super) fn indexed(input: &Input, place: usize) -> Text {
    Text::atom(match input.shape {
        Shape::Scalar => input.name.clone(),
        Shape::List(_) => format!("{}[{place}]", input.name),
        Shape::Matrix => format!("{}[{}, {}]", input.name, place / 3, place % 3),
    })
}

impl Language for Jax {
    fn number(&self, of: Number) -> Text {
        number(of)
    }

    fn pi(&self) -> Text {
        double(std::f64::consts::PI)
    }

    fn input(&self, input: &Input, place: usize) -> Text {
        indexed(input, place)
    }

    fn function(&self, node: &Node, of: &[Text]) -> Text {
        let name = match node {
            Node::Divide(..) => return quotient(of),
            Node::Select { .. } => {
                let [less, than, yes, no] = of else { return Text::atom("0") };
                return Text::atom(format!(
                    "jnp.where({} < {}, {}, {})",
                    less.text, than.text, yes.text, no.text
                ));
            }
            Node::CosineOfRoot(n, _) => return coefficient("_root_coefficient", &format!("{n}, 1"), of),
            Node::SineOfRoot(n, _) => return coefficient("0.5 * _root_coefficient", &format!("{n}, 3"), of),
            Node::Logarithm(n, _) => return coefficient("_log_coefficient", &n.to_string(), of),
            Node::Norm(_) => "_norm",
            Node::Reciprocal(_) => "_reciprocal",
            Node::SquareRoot(_) => "jnp.sqrt",
            Node::Magnitude(_) => "jnp.abs",
            Node::Sign(_) => "jnp.sign",
            Node::Sine(_) => "jnp.sin",
            Node::Cosine(_) => "jnp.cos",
            Node::Exponential(_) => "jnp.exp",
            Node::ExponentialMinusOne(_) => "jnp.expm1",
            Node::Power(..) => "jnp.power",
            Node::Arctangent(..) => "jnp.arctan2",
            _ => "_nearest_integer",
        };
        call(name, of)
    }

    fn unsigned(&self, x: &Text) -> Text {
        call("_unsigned", std::slice::from_ref(x))
    }

    fn quaternion(&self, name: &str, of: &[Text]) -> String {
        format!("{name} = {}", call("_quaternion", of).text)
    }

    fn part(&self, name: &str, part: u8) -> Text {
        Text::atom(format!("{name}[{part}]"))
    }

    fn assign(&self, name: &str, value: &str) -> String {
        format!("{name} = {value}")
    }
}
