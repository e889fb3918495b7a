//! Derivatives of expressions, of any order.

use crate::graph::{Graph, Id, Node};
use std::collections::HashMap;

/// A derivation: how each input changes along one direction. What is not named does not change.
///
/// It is linear and obeys the product rule; what it does to the inputs decides what it means. Along δR = δθ^ R, for example, the
/// entries of R change by those of δθ^ R: the spatial variation of a rotation.
#[derive(Clone, Debug, Default)]
pub struct Derivation {
    inputs: HashMap<u32, Id>,
    known: HashMap<Id, Id>,
}

impl Derivation {
    /// Along changes of the inputs, by their numbers.
    pub fn along(inputs: impl IntoIterator<Item = (u32, Id)>) -> Self {
        Self { inputs: inputs.into_iter().collect(), known: HashMap::new() }
    }

    /// The derivative of an expression.
    pub fn of(&mut self, graph: &mut Graph, root: Id) -> Id {
        for id in graph.reachable(&[root]) {
            if !self.known.contains_key(&id) {
                let derivative = self.rule(graph, id);
                self.known.insert(id, derivative);
            }
        }
        self.known(graph, root)
    }

    fn known(&self, graph: &mut Graph, id: Id) -> Id {
        self.known.get(&id).copied().unwrap_or_else(|| graph.integer(0))
    }

    fn rule(&self, graph: &mut Graph, id: Id) -> Id {
        let node = graph.node(id).clone();
        match node {
            Node::Constant(_) | Node::Pi | Node::NearestInteger(_) | Node::Sign(_) => graph.integer(0),
            Node::Input(number) => match self.inputs.get(&number) {
                Some(change) => *change,
                None => graph.integer(0),
            },
            Node::Add(x, y) => {
                let (dx, dy) = (self.known(graph, x), self.known(graph, y));
                graph.add(dx, dy)
            }
            Node::Multiply(x, y) => {
                let (dx, dy) = (self.known(graph, x), self.known(graph, y));
                let (left, right) = (graph.multiply(dx, y), graph.multiply(x, dy));
                graph.add(left, right)
            }
            Node::Divide(x, y) => {
                let (dx, dy) = (self.known(graph, x), self.known(graph, y));
                let change = graph.multiply(id, dy);
                let rest = graph.subtract(dx, change);
                graph.divide(rest, y)
            }
            Node::Unsigned(x) => self.known(graph, x),
            Node::Negate(x) => {
                let dx = self.known(graph, x);
                graph.negate(dx)
            }
            Node::Norm(v) => {
                let inverse = graph.reciprocal(id);
                let mut sum = graph.integer(0);
                for component in v.iter() {
                    let change = self.known(graph, *component);
                    let along = graph.multiply(*component, inverse);
                    let term = graph.multiply(along, change);
                    sum = graph.add(sum, term);
                }
                sum
            }
            Node::Arctangent(y, x) => {
                let (dy, dx) = (self.known(graph, y), self.known(graph, x));
                if graph.is(dy, 0) && graph.is(dx, 0) {
                    return dy;
                }
                let radius = graph.norm(&[y, x]);
                let inverse = graph.reciprocal(radius);
                let (cosine, sine) = (graph.multiply(x, inverse), graph.multiply(y, inverse));
                let (forth, back) = (graph.multiply(cosine, dy), graph.multiply(sine, dx));
                let across = graph.subtract(forth, back);
                graph.multiply(across, inverse)
            }
            Node::Quaternion(ref r, part) => self.quaternion(graph, r, part),
            Node::Select { less, than, yes, no } => {
                let (dyes, dno) = (self.known(graph, yes), self.known(graph, no));
                graph.select(less, than, dyes, dno)
            }
            Node::Power(x, p) => {
                let one = graph.integer(1);
                let less = graph.subtract(p, one);
                let power = graph.function(Node::Power(x, less));
                let slope = graph.multiply(p, power);
                self.chain(graph, x, slope)
            }
            Node::Reciprocal(x) => {
                let square = graph.multiply(id, id);
                let slope = graph.negate(square);
                self.chain(graph, x, slope)
            }
            Node::SquareRoot(x) => {
                let half = graph.ratio(1, 2);
                let inverse = graph.reciprocal(id);
                let slope = graph.multiply(half, inverse);
                self.chain(graph, x, slope)
            }
            Node::Magnitude(x) => {
                let sign = graph.function(Node::Sign(x));
                self.chain(graph, x, sign)
            }
            Node::Sine(x) => {
                let slope = graph.function(Node::Cosine(x));
                self.chain(graph, x, slope)
            }
            Node::Cosine(x) => {
                let sine = graph.function(Node::Sine(x));
                let slope = graph.negate(sine);
                self.chain(graph, x, slope)
            }
            Node::Exponential(x) => self.chain(graph, x, id),
            Node::ExponentialMinusOne(x) => {
                let slope = graph.function(Node::Exponential(x));
                self.chain(graph, x, slope)
            }
            Node::CosineOfRoot(n, x) => self.coefficient(graph, n, x, Node::CosineOfRoot),
            Node::SineOfRoot(n, x) => self.coefficient(graph, n, x, Node::SineOfRoot),
            Node::Logarithm(n, x) => self.coefficient(graph, n, x, Node::Logarithm),
        }
    }

    /// slope · dx.
    fn chain(&self, graph: &mut Graph, x: Id, slope: Id) -> Id {
        let dx = self.known(graph, x);
        graph.multiply(slope, dx)
    }

    /// The derivative (n + 1) c_(n+1) of the n-th Taylor coefficient.
    fn coefficient(&self, graph: &mut Graph, n: u32, x: Id, family: fn(u32, Id) -> Node) -> Id {
        let next = graph.function(family(n + 1, x));
        let factor = graph.integer(i64::from(n) + 1);
        let slope = graph.multiply(factor, next);
        self.chain(graph, x, slope)
    }

    /// dq = ¼ E(dR) q, where E(R) = 4 q qᵀ is linear in R but for a constant: it holds along every path of rotations, and so do its
    /// own derivatives.
    fn quaternion(&self, graph: &mut Graph, r: &std::sync::Arc<[Id; 9]>, part: u8) -> Id {
        let d = r.map(|entry| self.known(graph, entry));
        if d.iter().all(|entry| graph.is(*entry, 0)) {
            return graph.integer(0);
        }
        // Entries of R by rows: 11 12 13 21 22 23 31 32 33.
        let mut signed = |plus: &[usize], minus: &[usize]| {
            let mut sum = graph.integer(0);
            for place in plus {
                sum = graph.add(sum, d[*place]);
            }
            for place in minus {
                sum = graph.subtract(sum, d[*place]);
            }
            sum
        };
        let row = match part {
            0 => [signed(&[0, 4, 8], &[]), signed(&[7], &[5]), signed(&[2], &[6]), signed(&[3], &[1])],
            1 => [signed(&[7], &[5]), signed(&[0], &[4, 8]), signed(&[1, 3], &[]), signed(&[2, 6], &[])],
            2 => [signed(&[2], &[6]), signed(&[1, 3], &[]), signed(&[4], &[0, 8]), signed(&[5, 7], &[])],
            _ => [signed(&[3], &[1]), signed(&[2, 6], &[]), signed(&[5, 7], &[]), signed(&[8], &[0, 4])],
        };
        let quarter = graph.ratio(1, 4);
        let mut sum = graph.integer(0);
        for (i, entry) in row.into_iter().enumerate() {
            let q = graph.function(Node::Quaternion(std::sync::Arc::clone(r), i as u8));
            let term = graph.multiply(entry, q);
            sum = graph.add(sum, term);
        }
        graph.multiply(quarter, sum)
    }
}
