//! Expressions as text: straight-line programs in several languages, and formulas for reading.

mod c;
mod graphviz;
mod jax;
mod latex;
pub mod runtime;
mod rust;
mod sympy;
mod text;

pub use c::C;
pub use jax::Jax;
pub use latex::Latex;
pub use rust::Rust;
pub use sympy::Sympy;
pub use text::Unicode;

use crate::graph::{Graph, Id, Node, Number};
use crate::input::{Input, Inputs};
use std::collections::{BTreeSet, HashMap};

pub use graphviz::graphviz;

/// How tightly a text binds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Level {
    /// A sum, or anything with a sign in front.
    Sum,
    /// A product or a quotient.
    Product,
    /// A name, a call, something in brackets.
    Atom,
}

/// A printed expression.
#[derive(Clone, Debug)]
pub struct Text {
    /// The expression as written.
    pub text: String,
    pub(crate) level: Level,
}

impl Text {
    pub(crate) fn atom(text: impl Into<String>) -> Self {
        Self { text: text.into(), level: Level::Atom }
    }

    pub(crate) fn new(text: impl Into<String>, level: Level) -> Self {
        Self { text: text.into(), level }
    }

    /// In brackets, unless it binds at least so tightly.
    pub(crate) fn at(&self, least: Level) -> String {
        if self.level < least { format!("({})", self.text) } else { self.text.clone() }
    }
}

/// A language, or a notation.
pub trait Language {
    /// A constant.
    fn number(&self, number: Number) -> Text;

    /// π.
    fn pi(&self) -> Text;

    /// An entry of an input.
    fn input(&self, input: &Input, place: usize) -> Text;

    /// Any operation but sums, differences, products and those of quaternions; `of` are its operands.
    fn function(&self, node: &Node, of: &[Text]) -> Text;

    /// The statement that forms the quaternion `name` of nine entries.
    fn quaternion(&self, name: &str, of: &[Text]) -> String;

    /// A part of that quaternion.
    fn part(&self, name: &str, part: u8) -> Text;

    /// The statement that gives an expression a name.
    fn assign(&self, name: &str, value: &str) -> String;

    /// 0 + x, where the language has a −0: by default it has none.
    fn unsigned(&self, x: &Text) -> Text {
        x.clone()
    }

    /// What stands between factors.
    fn times(&self) -> &'static str {
        " * "
    }

    /// Minus, and what stands around it in a difference.
    fn minus(&self) -> [&'static str; 2] {
        ["-", " - "]
    }

    /// A factor of a product.
    fn factor(&self, text: &Text) -> String {
        text.at(Level::Product)
    }

    /// The n-th name for what occurs more than once.
    fn temporary(&self, n: usize) -> String {
        format!("t{n}")
    }

    /// How long an expression may be before its parts get names.
    fn longest(&self) -> usize {
        72
    }
}

/// A straight-line program: statements in order, and the text of each result.
#[derive(Debug)]
pub struct Listing {
    /// The assignments, in order: each uses those before it.
    pub statements: Vec<String>,
    /// The expression of each result.
    pub results: Vec<Text>,
    /// The functions called, by the name of their node.
    pub called: BTreeSet<&'static str>,
}

/// The name by which the runtime knows what a node calls; none for what every language has.
const fn called(node: &Node) -> Option<&'static str> {
    Some(match node {
        Node::Reciprocal(_) => "reciprocal",
        Node::Norm(_) => "norm",
        Node::Quaternion(..) => "quaternion",
        Node::Logarithm(..) => "log_coefficient",
        Node::CosineOfRoot(..) | Node::SineOfRoot(..) => "root_coefficient",
        Node::Unsigned(_) => "unsigned",
        Node::NearestInteger(_) => "nearest_integer",
        Node::Sign(_) => "sign",
        Node::Select { .. } => "select",
        _ => return None,
    })
}

/// Prints `results` as a straight-line program: every expression that occurs twice is formed once.
pub fn listing(graph: &Graph, inputs: &Inputs, results: &[Id], language: &dyn Language) -> Listing {
    named_listing(graph, inputs, results, &HashMap::new(), language)
}

/// As [`listing`]; what occurs more than once and has a name already keeps it.
pub fn named_listing(
    graph: &Graph,
    inputs: &Inputs,
    results: &[Id],
    known_names: &HashMap<Id, String>,
    language: &dyn Language,
) -> Listing {
    let needed = graph.reachable(results);
    let mut uses: HashMap<Id, usize> = HashMap::new();
    for id in &needed {
        for operand in graph.node(*id).operands() {
            *uses.entry(operand).or_default() += 1;
        }
    }
    for id in results.iter().collect::<BTreeSet<_>>() {
        *uses.entry(*id).or_default() += 1;
    }
    let mut texts: HashMap<Id, Text> = HashMap::new();
    let mut quaternions: HashMap<Vec<Id>, String> = HashMap::new();
    let mut found = Listing { statements: Vec::new(), results: Vec::new(), called: BTreeSet::new() };
    let mut names = 0;
    let mut name = || {
        names += 1;
        language.temporary(names)
    };
    for id in &needed {
        let node = graph.node(*id);
        found.called.extend(called(node));
        let of = |x: Id| texts.get(&x).cloned().unwrap_or_else(|| Text::atom("0"));
        if let Node::Quaternion(r, part) = node {
            let known = quaternions.entry(r.to_vec()).or_insert_with(|| {
                let name = name();
                let entries: Vec<Text> = r.iter().map(|entry| of(*entry)).collect();
                found.statements.push(language.quaternion(&name, &entries));
                name
            });
            let text = language.part(known, *part);
            texts.insert(*id, text);
            continue;
        }
        let text = print(graph, inputs, node, language, &of);
        let is_plain = node.operands().is_empty();
        let is_sign = matches!(node, Node::Negate(_) | Node::Unsigned(_));
        let is_shared = uses.get(id).is_some_and(|count| *count > 1);
        let text = if !is_plain && !is_sign && (is_shared || text.text.chars().count() > language.longest()) {
            let name = known_names.get(id).cloned().unwrap_or_else(&mut name);
            found.statements.push(language.assign(&name, &text.text));
            Text::atom(name)
        } else {
            text
        };
        texts.insert(*id, text);
    }
    found.results =
        results.iter().map(|id| texts.get(id).cloned().unwrap_or_else(|| Text::atom("0"))).collect();
    found
}

fn print(
    graph: &Graph,
    inputs: &Inputs,
    node: &Node,
    language: &dyn Language,
    of: &dyn Fn(Id) -> Text,
) -> Text {
    let [minus, less] = language.minus();
    match node {
        Node::Constant(number) => language.number(*number),
        Node::Pi => language.pi(),
        Node::Input(number) => match inputs.find(*number) {
            Some((input, place)) => language.input(input, place),
            None => Text::atom(format!("x{number}")),
        },
        Node::Negate(x) => Text::new(format!("{minus}{}", of(*x).at(Level::Product)), Level::Sum),
        Node::Unsigned(x) => language.unsigned(&of(*x)),
        Node::Add(x, y) => {
            let (front, back) = match (graph.node(*x), graph.node(*y)) {
                (_, Node::Negate(v)) => (*x, Err(*v)),
                (Node::Negate(u), _) => (*y, Err(*u)),
                _ => (*x, Ok(*y)),
            };
            let text = match back {
                Err(v) => format!("{}{less}{}", of(front).text, of(v).at(Level::Product)),
                Ok(y) => match (graph.node(y), of(y).text) {
                    (Node::Constant(_), y) if y.starts_with(minus) => {
                        format!("{}{less}{}", of(front).text, y.trim_start_matches(minus))
                    }
                    (_, y) if y.starts_with(minus) => format!("{} + ({y})", of(front).text),
                    (_, y) => format!("{} + {y}", of(front).text),
                },
            };
            Text::new(text, Level::Sum)
        }
        Node::Multiply(x, y) => {
            let (x, y) = (of(*x), of(*y));
            // a (b / c) is not a b / c to the last bit.
            let back = if y.level == Level::Product { format!("({})", y.text) } else { language.factor(&y) };
            Text::new(format!("{}{}{back}", language.factor(&x), language.times()), Level::Product)
        }
        other => {
            let of: Vec<Text> = other.operands().into_iter().map(of).collect();
            language.function(other, &of)
        }
    }
}

/// f(x, y).
pub(crate) fn call(name: &str, of: &[Text]) -> Text {
    let of: Vec<&str> = of.iter().map(|text| text.text.as_str()).collect();
    Text::atom(format!("{name}({})", of.join(", ")))
}
