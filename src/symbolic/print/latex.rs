//! Formulas in LaTeX.

use crate::graph::{Node, Number};
use crate::input::{Input, Shape};
use crate::print::text::PART;
use crate::print::{Language, Level, Text};

/// Expressions in LaTeX.
pub struct Latex;

impl Latex {
    /// A symbol of the sources: `R_r`, `F_C^int`, `M_C1^int`, `α`, `Ψa`, `f1`.
    pub fn symbol(symbol: &str) -> String {
        let (front, exponent) = symbol.split_once('^').map_or((symbol, None), |(f, e)| (f, Some(e)));
        let (base, index) = front.split_once('_').map_or_else(
            || {
                let mut letters = front.chars();
                let base = letters.next().map(String::from).unwrap_or_default();
                (base, letters.collect::<String>())
            },
            |(base, index)| (base.to_string(), index.to_string()),
        );
        let greek = |letter: &str| {
            Some(match letter {
                "α" => "\\alpha",
                "β" => "\\beta",
                "γ" => "\\gamma",
                "κ" => "\\kappa",
                "μ" => "\\mu",
                "φ" => "\\varphi",
                "Φ" => "\\Phi",
                "Ψ" => "\\Psi",
                "δ" => "\\delta",
                "ρ" => "\\rho",
                "θ" => "\\theta",
                _ => return None,
            })
        };
        let base = greek(&base).map_or(base.clone(), String::from);
        let word = |text: &str| {
            if text.chars().count() > 1 && text.chars().all(char::is_alphabetic) {
                format!("\\mathrm{{{text}}}")
            } else {
                text.to_string()
            }
        };
        let mut text = base;
        if !index.is_empty() {
            text.push_str(&format!("_{{{}}}", word(&index)));
        }
        if let Some(exponent) = exponent {
            text.push_str(&format!("^{{{}}}", word(exponent)));
        }
        text
    }
}

impl Language for Latex {
    fn number(&self, of: Number) -> Text {
        match of {
            Number::Ratio(p, 1) if p < 0 => Text::new(p.to_string(), Level::Sum),
            Number::Ratio(p, 1) => Text::atom(p.to_string()),
            Number::Ratio(p, q) if p < 0 => {
                Text::new(format!("-\\tfrac{{{}}}{{{q}}}", p.unsigned_abs()), Level::Sum)
            }
            Number::Ratio(p, q) => Text::atom(format!("\\tfrac{{{p}}}{{{q}}}")),
            Number::Double(bits) => {
                let text = format!("{:?}", f64::from_bits(bits));
                Text::atom(match text.split_once('e') {
                    Some((digits, exponent)) => format!("({digits}\\cdot 10^{{{exponent}}})"),
                    None => format!("({text})"),
                })
            }
        }
    }

    fn pi(&self) -> Text {
        Text::atom("\\pi")
    }

    fn input(&self, input: &Input, place: usize) -> Text {
        let symbol = Self::symbol(&input.symbol);
        Text::atom(match (input.shape, input.symbol.as_str()) {
            (Shape::List(3), "d") => format!("(\\mathbf{{e}}_{}^{{a}}\\cdot\\mathbf{{d}})", place + 1),
            (Shape::Matrix, "Q") => {
                format!("(\\mathbf{{e}}_{}^{{a}}\\cdot\\mathbf{{e}}_{}^{{b}})", place / 3 + 1, place % 3 + 1)
            }
            (Shape::Scalar, _) => symbol,
            (Shape::List(_), list) if list.contains(' ') => {
                Self::symbol(list.split(' ').nth(place).unwrap_or(list))
            }
            (Shape::List(_), _) => format!("{{{symbol}}}_{{,{}}}", place + 1),
            (Shape::Matrix, _) => format!("{{{symbol}}}_{{,{}{}}}", place / 3 + 1, place % 3 + 1),
        })
    }

    fn function(&self, node: &Node, of: &[Text]) -> Text {
        let first = of.first().map_or("", |text| text.text.as_str());
        let all = || of.iter().map(|text| text.text.as_str()).collect::<Vec<_>>().join(", ");
        let applied = |name: &str| Text::atom(format!("{name}\\left({}\\right)", all()));
        match node {
            Node::Divide(..) => {
                let [x, y] = of else { return Text::atom("0") };
                Text::atom(format!("\\frac{{{}}}{{{}}}", x.text, y.text))
            }
            Node::Reciprocal(_) => Text::atom(format!("\\frac{{1}}{{{first}}}")),
            Node::Select { .. } => {
                let [less, than, yes, no] = of else { return Text::atom("0") };
                let [less, than, yes, no] = [less, than, yes, no].map(|text| &text.text);
                Text::atom(format!(
                    "\\begin{{cases}}{yes} & {less} < {than}\\\\{no} & \\text{{otherwise}}\\end{{cases}}"
                ))
            }
            Node::Norm(_) => Text::atom(format!("\\left|\\left({}\\right)\\right|", all())),
            Node::Magnitude(_) => Text::atom(format!("\\left|{first}\\right|")),
            Node::Sign(_) => applied("\\operatorname{sgn}"),
            Node::SquareRoot(_) => Text::atom(format!("\\sqrt{{{first}}}")),
            Node::Sine(_) => applied("\\sin"),
            Node::Cosine(_) => applied("\\cos"),
            Node::Exponential(_) => Text::atom(format!("e^{{{first}}}")),
            Node::ExponentialMinusOne(_) => Text::new(format!("e^{{{first}}} - 1"), Level::Sum),
            Node::Power(..) => {
                let [x, p] = of else { return Text::atom("0") };
                Text::atom(format!("\\left({}\\right)^{{{}}}", x.text, p.text))
            }
            Node::Arctangent(..) => applied("\\operatorname{atan2}"),
            Node::CosineOfRoot(n, _) => applied(&coefficient("W", *n)),
            Node::SineOfRoot(n, _) => applied(&coefficient("k", *n)),
            Node::Logarithm(n, _) => applied(&coefficient("K", *n)),
            _ => applied("\\operatorname{round}"),
        }
    }

    fn quaternion(&self, name: &str, of: &[Text]) -> String {
        let entries: Vec<&str> = of.iter().map(|text| text.text.as_str()).collect();
        let is_q =
            entries.first().is_some_and(|entry| entry.starts_with("(\\mathbf{e}_1^{a}\\cdot\\mathbf{e}_1"));
        let of = if is_q { "\\mathbf{Q}".to_string() } else { entries.join(", ") };
        format!("{name} &= \\operatorname{{quaternion}}\\left({of}\\right),\\quad {{{name}}}_{{,w}} \\ge 0")
    }

    fn part(&self, name: &str, part: u8) -> Text {
        Text::atom(format!("{{{name}}}_{{,{}}}", PART[usize::from(part) % 4]))
    }

    fn assign(&self, name: &str, value: &str) -> String {
        format!("{name} &= {value}")
    }

    fn times(&self) -> &'static str {
        "\\,"
    }

    fn minus(&self) -> [&'static str; 2] {
        ["-", " - "]
    }

    fn temporary(&self, n: usize) -> String {
        format!("t_{{{n}}}")
    }

    fn longest(&self) -> usize {
        300
    }
}

/// The n-th Taylor coefficient of a function.
fn coefficient(name: &str, n: u32) -> String {
    match n {
        0 => name.into(),
        1 => format!("{name}'"),
        2 => format!("\\tfrac{{1}}{{2}}{name}''"),
        _ => format!("\\tfrac{{1}}{{{n}!}}{name}^{{({n})}}"),
    }
}
