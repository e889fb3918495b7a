//! C99.

use crate::graph::{Node, Number};
use crate::input::{Input, Shape};
use crate::print::{Language, Level, Text, call};

/// Expressions in C99.
pub struct C;

/// A double in C, Rust and Python.
pub(super) fn double(x: f64) -> Text {
    let text = format!("{:?}", x.abs());
    if x < 0.0 || (x == 0.0 && x.is_sign_negative()) {
        Text::new(format!("-{text}"), Level::Sum)
    } else {
        Text::atom(text)
    }
}

/// A constant as a double, or as a quotient of doubles.
pub(super) fn number(number: Number) -> Text {
    match number {
        Number::Ratio(p, 1) => double(p as f64),
        Number::Ratio(p, q) if p < 0 => {
            Text::new(format!("-{} / {}", double(-p as f64).text, double(q as f64).text), Level::Sum)
        }
        Number::Ratio(p, q) => {
            Text::new(format!("{} / {}", double(p as f64).text, double(q as f64).text), Level::Product)
        }
        Number::Double(bits) => double(f64::from_bits(bits)),
    }
}

/// 0 + x, which compilers may not fold.
pub(super) fn unsigned(x: &Text) -> Text {
    let text = x.text.strip_prefix('-').map_or_else(|| format!("0.0 + {}", x.text), |y| format!("0.0 - {y}"));
    let is_whole = x.text.starts_with('-') && x.text.contains([' ', '(']);
    Text::new(if is_whole { format!("0.0 + ({})", x.text) } else { text }, Level::Sum)
}

/// x / y.
pub(super) fn quotient(of: &[Text]) -> Text {
    let [x, y] = of else { return Text::atom("0") };
    let below = if y.level == Level::Atom { y.text.clone() } else { format!("({})", y.text) };
    Text::new(format!("{} / {below}", x.at(Level::Product)), Level::Product)
}

/// The entry of an input in an array of one dimension.
pub(super) fn flat(input: &Input, place: usize) -> Text {
    Text::atom(match input.shape {
        Shape::Scalar => input.name.clone(),
        _ => format!("{}[{place}]", input.name),
    })
}

impl Language for C {
    fn number(&self, of: Number) -> Text {
        number(of)
    }

    fn pi(&self) -> Text {
        double(std::f64::consts::PI)
    }

    fn input(&self, input: &Input, place: usize) -> Text {
        flat(input, place)
    }

    fn function(&self, node: &Node, of: &[Text]) -> Text {
        let name = match node {
            Node::Divide(..) => return quotient(of),
            Node::Select { .. } => {
                let [less, than, yes, no] = of else { return Text::atom("0") };
                return Text::atom(format!("({} < {} ? {} : {})", less.text, than.text, yes.text, no.text));
            }
            Node::Norm(v) => {
                let of: Vec<&str> = of.iter().map(|text| text.text.as_str()).collect();
                return Text::atom(format!(
                    "pintle_norm({}, (const double[]){{{}}})",
                    v.len(),
                    of.join(", ")
                ));
            }
            Node::CosineOfRoot(n, _) => {
                return coefficient("pintle_root_coefficient", &format!("{n}, 1"), of);
            }
            Node::SineOfRoot(n, _) => {
                return coefficient("0.5 * pintle_root_coefficient", &format!("{n}, 3"), of);
            }
            Node::Logarithm(n, _) => return coefficient("pintle_log_coefficient", &n.to_string(), of),
            Node::Reciprocal(_) => "pintle_reciprocal",
            Node::SquareRoot(_) => "sqrt",
            Node::Magnitude(_) => "fabs",
            Node::Sign(_) => "pintle_sign",
            Node::Sine(_) => "sin",
            Node::Cosine(_) => "cos",
            Node::Exponential(_) => "exp",
            Node::ExponentialMinusOne(_) => "expm1",
            Node::Power(..) => "pow",
            Node::Arctangent(..) => "atan2",
            _ => "round",
        };
        call(name, of)
    }

    fn unsigned(&self, x: &Text) -> Text {
        unsigned(x)
    }

    fn quaternion(&self, name: &str, of: &[Text]) -> String {
        let of: Vec<&str> = of.iter().map(|text| text.text.as_str()).collect();
        format!("double {name}[4];\n    pintle_quaternion((const double[]){{{}}}, {name});", of.join(", "))
    }

    fn part(&self, name: &str, part: u8) -> Text {
        Text::atom(format!("{name}[{part}]"))
    }

    fn assign(&self, name: &str, value: &str) -> String {
        format!("const double {name} = {value};")
    }
}

/// f(n, x), where the name may have a factor in front.
pub(super) fn coefficient(name: &str, order: &str, of: &[Text]) -> Text {
    let of: Vec<&str> = of.iter().map(|text| text.text.as_str()).collect();
    let level = if name.contains('*') { Level::Product } else { Level::Atom };
    Text::new(format!("{name}({order}, {})", of.join(", ")), level)
}
