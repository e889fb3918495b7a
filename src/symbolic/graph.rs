//! The arena: expressions as nodes, each once.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

/// A node of a [`Graph`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Id(pub(super) u32);

impl Id {
    pub(super) const fn place(self) -> usize {
        self.0 as usize
    }
}

/// A constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Number {
    /// p / q in lowest terms, q > 0.
    Ratio(i64, i64),
    /// A double by its bits.
    Double(u64),
}

impl Number {
    /// The ratio in lowest terms; `None` where q = 0 or a part does not fit.
    pub(super) fn ratio(p: i128, q: i128) -> Option<Self> {
        if q == 0 {
            return None;
        }
        let (mut a, mut b) = (p.unsigned_abs(), q.unsigned_abs());
        while b != 0 {
            (a, b) = (b, a % b);
        }
        let divisor = i128::try_from(a).ok()?.max(1) * q.signum();
        Some(Self::Ratio(i64::try_from(p / divisor).ok()?, i64::try_from(q / divisor).ok()?))
    }

    /// A double, as a ratio where that is short.
    pub(super) fn double(x: f64) -> Self {
        const DENOMINATOR: f64 = 1_048_576.0;
        let scaled = x * DENOMINATOR;
        // Powers of two scale exactly; 2⁵³ is where every double is an integer.
        if scaled.trunc() == scaled
            && scaled.abs() < 9_007_199_254_740_992.0
            && (x != 0.0 || x.is_sign_positive())
        {
            return Self::ratio(scaled as i128, DENOMINATOR as i128).unwrap_or(Self::Double(x.to_bits()));
        }
        Self::Double(x.to_bits())
    }

    const fn is(self, n: i64) -> bool {
        matches!(self, Self::Ratio(p, 1) if p == n)
    }

    /// The nearest double.
    pub fn to_f64(self) -> f64 {
        match self {
            Self::Ratio(p, q) => p as f64 / q as f64,
            Self::Double(bits) => f64::from_bits(bits),
        }
    }
}

/// An expression: an operation, or an atom whose derivatives are known.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Node {
    /// A constant.
    Constant(Number),
    /// π.
    Pi,
    /// An input, by its number.
    Input(u32),
    /// x + y.
    Add(Id, Id),
    /// x y.
    Multiply(Id, Id),
    /// x / y.
    Divide(Id, Id),
    /// −x.
    Negate(Id),
    /// 0 + x, which is never −0: half a turn is then +π. Kept where an angle is taken of it, else x.
    Unsigned(Id),
    /// 1 / x, and 0 at x = 0.
    Reciprocal(Id),
    /// √x.
    SquareRoot(Id),
    /// |x|.
    Magnitude(Id),
    /// −1, 0 or 1: the derivative of |x|, of least norm at x = 0.
    Sign(Id),
    /// sin x.
    Sine(Id),
    /// cos x.
    Cosine(Id),
    /// eˣ.
    Exponential(Id),
    /// eˣ − 1.
    ExponentialMinusOne(Id),
    /// xᵖ.
    Power(Id, Id),
    /// The angle of the point (x, y), y first.
    Arctangent(Id, Id),
    /// The nearest integer, halves away from zero.
    NearestInteger(Id),
    /// |v|.
    Norm(Arc<[Id]>),
    /// A part (0 is the scalar part, never negative) of the unit quaternion of a rotation matrix, given by rows.
    Quaternion(Arc<[Id; 9]>, u8),
    /// The n-th Taylor coefficient of cos(√s / 2) at s.
    CosineOfRoot(u32, Id),
    /// The n-th Taylor coefficient of sin(√s / 2) / √s at s: the quaternion of the rotation vector φ is (cos, sin · φ), s = |φ|².
    SineOfRoot(u32, Id),
    /// The n-th Taylor coefficient of K(c) = 2 acos(c) / √(1 − c²) at c: the rotation vector of the quaternion (w, v) is K(w) v.
    Logarithm(u32, Id),
    /// `yes` where `less` < `than`, else `no`.
    Select {
        /// The smaller side of the condition.
        less: Id,
        /// The larger side of the condition.
        than: Id,
        /// Where the condition holds.
        yes: Id,
        /// Elsewhere.
        no: Id,
    },
}

impl Node {
    /// What it is formed from.
    pub fn operands(&self) -> Vec<Id> {
        match self {
            Self::Constant(_) | Self::Pi | Self::Input(_) => Vec::new(),
            Self::Negate(x)
            | Self::Unsigned(x)
            | Self::Reciprocal(x)
            | Self::SquareRoot(x)
            | Self::Magnitude(x)
            | Self::Sign(x)
            | Self::Sine(x)
            | Self::Cosine(x)
            | Self::Exponential(x)
            | Self::ExponentialMinusOne(x)
            | Self::NearestInteger(x)
            | Self::CosineOfRoot(_, x)
            | Self::SineOfRoot(_, x)
            | Self::Logarithm(_, x) => vec![*x],
            Self::Add(x, y)
            | Self::Multiply(x, y)
            | Self::Divide(x, y)
            | Self::Power(x, y)
            | Self::Arctangent(x, y) => vec![*x, *y],
            Self::Norm(v) => v.to_vec(),
            Self::Quaternion(r, _) => r.to_vec(),
            Self::Select { less, than, yes, no } => vec![*less, *than, *yes, *no],
        }
    }
}

/// Expressions, each node once: equal expressions have equal [`Id`]s.
///
/// Building a node simplifies lightly and safely: constants, 0 and 1, signs. Everything more is a computer algebra system's.
#[derive(Clone, Debug)]
pub struct Graph {
    nodes: Vec<Node>,
    known: HashMap<Node, Id>,
}

impl Default for Graph {
    /// A graph that holds 0.
    fn default() -> Self {
        let mut graph = Self { nodes: Vec::new(), known: HashMap::new() };
        graph.integer(0);
        graph
    }
}

impl Graph {
    /// The number 0.
    pub const ZERO: Id = Id(0);

    /// The node of an id. An id of another graph may name another node or none, which reads as zero.
    pub fn node(&self, id: Id) -> &Node {
        const ZERO: &Node = &Node::Constant(Number::Ratio(0, 1));
        self.nodes.get(id.place()).unwrap_or(ZERO)
    }

    /// The number of nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether there is none but 0.
    pub fn is_empty(&self) -> bool {
        self.nodes.len() < 2
    }

    pub(super) fn intern(&mut self, node: Node) -> Id {
        if let Some(id) = self.known.get(&node) {
            return *id;
        }
        let id = Id(self.nodes.len() as u32);
        self.nodes.push(node.clone());
        self.known.insert(node, id);
        id
    }

    /// A constant.
    pub fn constant(&mut self, number: Number) -> Id {
        self.intern(Node::Constant(number))
    }

    /// The integer n.
    pub fn integer(&mut self, n: i64) -> Id {
        self.constant(Number::Ratio(n, 1))
    }

    /// p / q; q ≠ 0.
    pub fn ratio(&mut self, p: i64, q: i64) -> Id {
        let number = Number::ratio(p.into(), q.into()).unwrap_or(Number::Double(f64::NAN.to_bits()));
        self.constant(number)
    }

    /// The input of a number.
    pub fn input(&mut self, number: u32) -> Id {
        self.intern(Node::Input(number))
    }

    fn number(&self, id: Id) -> Option<Number> {
        if let Node::Constant(number) = self.node(id) { Some(*number) } else { None }
    }

    /// Whether it is the constant n.
    pub fn is(&self, id: Id, n: i64) -> bool {
        self.number(id).is_some_and(|number| number.is(n))
    }

    /// 0 + x, which is never −0.
    pub fn unsigned(&mut self, x: Id) -> Id {
        if self.is_not_negative(x) || self.number(x).is_some() { x } else { self.intern(Node::Unsigned(x)) }
    }

    /// Without a zero in front, where the sign of zero does not matter.
    fn plain(&self, id: Id) -> Id {
        if let Node::Unsigned(x) = self.node(id) { *x } else { id }
    }

    /// x + y.
    pub fn add(&mut self, x: Id, y: Id) -> Id {
        let (x, y) = (self.plain(x), self.plain(y));
        if self.is(x, 0) {
            return y;
        }
        if self.is(y, 0) {
            return x;
        }
        if let (Some(Number::Ratio(p, q)), Some(Number::Ratio(r, s))) = (self.number(x), self.number(y)) {
            let [p, q, r, s] = [p, q, r, s].map(i128::from);
            if let Some(sum) = Number::ratio(p * s + r * q, q * s) {
                return self.constant(sum);
            }
        }
        match (self.node(x).clone(), self.node(y).clone()) {
            (Node::Negate(u), Node::Negate(v)) => {
                let sum = self.add(u, v);
                self.negate(sum)
            }
            (Node::Negate(u), _) if u == y => self.integer(0),
            (_, Node::Negate(v)) if v == x => self.integer(0),
            _ if x == y => {
                let two = self.integer(2);
                self.multiply(two, x)
            }
            _ => self.intern(Node::Add(x.min(y), x.max(y))),
        }
    }

    /// x − y.
    pub fn subtract(&mut self, x: Id, y: Id) -> Id {
        let minus = self.negate(y);
        self.add(x, minus)
    }

    /// −x.
    pub fn negate(&mut self, x: Id) -> Id {
        let x = self.plain(x);
        match *self.node(x) {
            Node::Negate(u) => u,
            Node::Constant(Number::Ratio(p, q)) if p != i64::MIN => self.constant(Number::Ratio(-p, q)),
            Node::Constant(Number::Double(bits)) => {
                self.constant(Number::Double((-f64::from_bits(bits)).to_bits()))
            }
            _ => self.intern(Node::Negate(x)),
        }
    }

    /// x y.
    pub fn multiply(&mut self, x: Id, y: Id) -> Id {
        let (x, y) = (self.plain(x), self.plain(y));
        if self.is(x, 0) || self.is(y, 0) {
            return self.integer(0);
        }
        if self.is(x, 1) {
            return y;
        }
        if self.is(y, 1) {
            return x;
        }
        if self.is(x, -1) {
            return self.negate(y);
        }
        if self.is(y, -1) {
            return self.negate(x);
        }
        if let (Some(Number::Ratio(p, q)), Some(Number::Ratio(r, s))) = (self.number(x), self.number(y)) {
            let [p, q, r, s] = [p, q, r, s].map(i128::from);
            if let Some(product) = Number::ratio(p * r, q * s) {
                return self.constant(product);
            }
        }
        match (self.node(x).clone(), self.node(y).clone()) {
            (Node::Negate(u), Node::Negate(v)) => self.multiply(u, v),
            (Node::Negate(u), _) => {
                let product = self.multiply(u, y);
                self.negate(product)
            }
            (_, Node::Negate(v)) => {
                let product = self.multiply(x, v);
                self.negate(product)
            }
            // Constants in front, and one of them.
            (Node::Constant(Number::Ratio(..)), Node::Multiply(u, v)) if self.is_ratio(u) => {
                let factor = self.multiply(x, u);
                self.multiply(factor, v)
            }
            (Node::Multiply(u, v), Node::Constant(Number::Ratio(..))) if self.is_ratio(u) => {
                let factor = self.multiply(y, u);
                self.multiply(factor, v)
            }
            (_, Node::Constant(_)) => self.intern(Node::Multiply(y, x)),
            (Node::Constant(_), _) => self.intern(Node::Multiply(x, y)),
            _ => self.intern(Node::Multiply(x.min(y), x.max(y))),
        }
    }

    fn is_ratio(&self, id: Id) -> bool {
        matches!(self.number(id), Some(Number::Ratio(..)))
    }

    /// x / y.
    pub fn divide(&mut self, x: Id, y: Id) -> Id {
        let (x, y) = (self.plain(x), self.plain(y));
        if self.is(y, 1) || (self.is(x, 0) && self.number(y).is_none()) {
            return x;
        }
        if self.is(y, -1) {
            return self.negate(x);
        }
        if let (Some(Number::Ratio(p, q)), Some(Number::Ratio(r, s))) = (self.number(x), self.number(y)) {
            let [p, q, r, s] = [p, q, r, s].map(i128::from);
            if let Some(quotient) = Number::ratio(p * s, q * r) {
                return self.constant(quotient);
            }
        }
        match (self.node(x).clone(), self.node(y).clone()) {
            (Node::Negate(u), Node::Negate(v)) => self.divide(u, v),
            (Node::Negate(u), _) => {
                let quotient = self.divide(u, y);
                self.negate(quotient)
            }
            (_, Node::Negate(v)) => {
                let quotient = self.divide(x, v);
                self.negate(quotient)
            }
            _ => self.intern(Node::Divide(x, y)),
        }
    }

    /// 1 / x, and 0 at x = 0.
    pub fn reciprocal(&mut self, x: Id) -> Id {
        let x = self.plain(x);
        match *self.node(x) {
            Node::Constant(Number::Ratio(0, _)) => x,
            Node::Constant(Number::Ratio(p, q)) => {
                let number = Number::ratio(q.into(), p.into());
                match number {
                    Some(number) => self.constant(number),
                    None => self.intern(Node::Reciprocal(x)),
                }
            }
            Node::Negate(u) => {
                let inverse = self.reciprocal(u);
                self.negate(inverse)
            }
            _ => self.intern(Node::Reciprocal(x)),
        }
    }

    /// |v|: zeros and signs drop out.
    pub fn norm(&mut self, v: &[Id]) -> Id {
        let mut kept: Vec<Id> = Vec::new();
        for component in v {
            let component = &self.plain(*component);
            let magnitude = match *self.node(*component) {
                Node::Negate(u) => u,
                Node::Constant(Number::Ratio(p, q)) if p != i64::MIN => {
                    self.constant(Number::Ratio(p.abs(), q))
                }
                _ => *component,
            };
            if !self.is(magnitude, 0) {
                kept.push(magnitude);
            }
        }
        match kept[..] {
            [] => self.integer(0),
            [one] => self.magnitude(one),
            _ => self.intern(Node::Norm(kept.into())),
        }
    }

    /// |x|.
    pub fn magnitude(&mut self, x: Id) -> Id {
        let x = self.plain(x);
        match *self.node(x) {
            Node::Negate(u) => self.magnitude(u),
            _ if self.is_not_negative(x) => x,
            Node::Constant(_) => self.negate(x),
            _ => self.intern(Node::Magnitude(x)),
        }
    }

    /// Whether it can be seen to be ≥ 0.
    pub(super) fn is_not_negative(&self, id: Id) -> bool {
        match self.node(id) {
            Node::Constant(number) => number.to_f64() >= 0.0,
            Node::Pi | Node::SquareRoot(_) | Node::Magnitude(_) | Node::Norm(_) | Node::Quaternion(_, 0) => {
                true
            }
            Node::Add(x, y) => self.is_not_negative(*x) && self.is_not_negative(*y),
            Node::Multiply(x, y) => x == y || (self.is_not_negative(*x) && self.is_not_negative(*y)),
            Node::Divide(x, y) => self.is_not_negative(*x) && self.is_not_negative(*y),
            Node::Reciprocal(x) => self.is_not_negative(*x),
            _ => false,
        }
    }

    /// Whether x < y, where that can be seen.
    pub(super) fn known_less(&self, x: Id, y: Id) -> Option<bool> {
        if x == y {
            return Some(false);
        }
        if let (Some(x), Some(y)) = (self.number(x), self.number(y)) {
            return Some(x.to_f64() < y.to_f64());
        }
        let is_zero_or_less = self.number(y).is_some_and(|y| y.to_f64() <= 0.0);
        (is_zero_or_less && self.is_not_negative(x)).then_some(false)
    }

    /// `yes` where x < y, else `no`.
    pub fn select(&mut self, less: Id, than: Id, yes: Id, no: Id) -> Id {
        if yes == no {
            return yes;
        }
        match self.known_less(less, than) {
            Some(true) => yes,
            Some(false) => no,
            None => self.intern(Node::Select { less, than, yes, no }),
        }
    }

    /// √x.
    pub fn square_root(&mut self, x: Id) -> Id {
        if self.is(x, 0) || self.is(x, 1) { x } else { self.intern(Node::SquareRoot(x)) }
    }

    /// Any other node, with the constants that are worth knowing.
    pub fn function(&mut self, node: Node) -> Id {
        match node {
            Node::Sine(x) | Node::ExponentialMinusOne(x) | Node::NearestInteger(x) if self.is(x, 0) => x,
            Node::Cosine(x) | Node::Exponential(x) if self.is(x, 0) => self.integer(1),
            Node::Power(x, p) if self.is(p, 1) => x,
            Node::Power(_, p) if self.is(p, 0) => self.integer(1),
            Node::NearestInteger(x) if matches!(self.number(x), Some(Number::Ratio(_, 1))) => x,
            _ => self.intern(node),
        }
    }

    /// Every node that `roots` are formed from, operands first.
    pub fn reachable(&self, roots: &[Id]) -> Vec<Id> {
        let mut found = BTreeSet::new();
        let mut left: Vec<Id> = roots.to_vec();
        while let Some(id) = left.pop() {
            if found.insert(id) {
                left.extend(self.node(id).operands());
            }
        }
        // Operands are older than what is formed from them.
        found.into_iter().collect()
    }
}
