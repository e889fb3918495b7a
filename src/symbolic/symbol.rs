//! The traced scalar: a handle into the arena of this thread, and the branches that are taken while it records.

use crate::graph::{Graph, Id, Node, Number};
use pintle_kinematics::scalar::{MAX_ORDER, Real, Scalar, Select, Series};
use std::cell::RefCell;
use std::collections::HashMap;
use std::fmt;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// The most paths through the branches of one trace.
const MOST_PATHS: usize = 4096;

/// The most branches along one path.
const MOST_BRANCHES: usize = 200;

/// A number that records what is done to it: a handle into the expression arena of the thread that traces.
///
/// It means something within [`trace`] only; outside, and in another thread, it reads as another expression or as zero.
#[derive(Clone, Copy)]
pub struct Symbol(pub(super) Id);

/// Why a trace did not come to an end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TraceError {
    /// A formula branches more often than can be followed.
    #[error(
        "the formula has more than {MOST_PATHS} paths, or more than {MOST_BRANCHES} branches on one of them"
    )]
    Branches,
}

/// A condition x < y that a path has met, and how it went.
#[derive(Clone, Copy)]
struct Decision {
    less: Id,
    than: Id,
    holds: bool,
}

/// Paths through the branches of one [`joined`] formula: the decisions to repeat, and how many of them were.
#[derive(Default)]
struct Explorer {
    path: Vec<Decision>,
    met: usize,
}

#[derive(Default)]
struct Tracer {
    graph: Graph,
    explorers: Vec<Explorer>,
    stand_ins: HashMap<u64, Id>,
    is_overrun: bool,
}

thread_local! {
    static TRACER: RefCell<Tracer> = RefCell::default();
}

fn with<T>(f: impl FnOnce(&mut Tracer) -> T) -> T {
    TRACER.with_borrow_mut(f)
}

/// Puts the tracer of an outer trace back, however the inner one ends.
struct Restore(Option<Tracer>);

impl Drop for Restore {
    fn drop(&mut self) {
        if let Some(outer) = self.0.take() {
            TRACER.set(outer);
        }
    }
}

/// The expressions that `formula` forms, every branch of it taken and joined, in a graph of their own.
///
/// # Errors
/// [`TraceError`] where the formula branches too often.
///
/// ```
/// use pintle_kinematics::scalar::elementary::norm;
/// use pintle_symbolic::{Symbol, trace};
/// let (graph, [length]) = trace(|| [norm([Symbol::input(0), Symbol::input(1)])])?;
/// assert_eq!(graph.evaluate(&[length], &[3.0, 4.0]), [5.0]);
/// # Ok::<(), pintle_symbolic::TraceError>(())
/// ```
pub fn trace<const N: usize>(formula: impl Fn() -> [Symbol; N]) -> Result<(Graph, [Id; N]), TraceError> {
    extend(Graph::default(), &[], formula)
}

/// As [`trace`], into an existing graph. `stand_ins` are doubles that stand for expressions: where the formula takes its data
/// as doubles, these give them names.
pub(super) fn extend<const N: usize>(
    graph: Graph,
    stand_ins: &[(f64, Id)],
    formula: impl Fn() -> [Symbol; N],
) -> Result<(Graph, [Id; N]), TraceError> {
    let stand_ins = stand_ins.iter().map(|(x, id)| (x.to_bits(), *id)).collect();
    let fresh = Tracer { graph, stand_ins, ..Tracer::default() };
    let mut restore = Restore(Some(TRACER.replace(fresh)));
    let found = joined(formula);
    let traced = TRACER.replace(restore.0.take().unwrap_or_default());
    if traced.is_overrun {
        Err(TraceError::Branches)
    } else {
        Ok((traced.graph, found.map(|symbol| symbol.0)))
    }
}

/// Takes every path through the branches of `formula`, and joins what they give by selections.
fn joined<const N: usize>(formula: impl Fn() -> [Symbol; N]) -> [Symbol; N] {
    with(|tracer| tracer.explorers.push(Explorer::default()));
    let mut paths: Vec<(Vec<Decision>, [Symbol; N])> = Vec::new();
    loop {
        let found = formula();
        let goes_on = with(|tracer| {
            let overrun = tracer.is_overrun || paths.len() >= MOST_PATHS;
            tracer.is_overrun = overrun;
            let Some(explorer) = tracer.explorers.last_mut() else { return false };
            paths.push((explorer.path.clone(), found));
            explorer.met = 0;
            // The last branch not yet taken both ways.
            while explorer.path.last().is_some_and(|decision| !decision.holds) {
                explorer.path.pop();
            }
            match explorer.path.last_mut() {
                Some(decision) => {
                    decision.holds = false;
                    !overrun
                }
                None => false,
            }
        });
        if !goes_on {
            break;
        }
    }
    with(|tracer| {
        tracer.explorers.pop();
        merge(&mut tracer.graph, &paths, 0)
    })
}

/// The selection among paths that agree in their first `depth` decisions.
fn merge<const N: usize>(
    graph: &mut Graph,
    paths: &[(Vec<Decision>, [Symbol; N])],
    depth: usize,
) -> [Symbol; N] {
    let Some((path, found)) = paths.first() else { return [Symbol(graph.integer(0)); N] };
    let Some(decision) = path.get(depth) else { return *found };
    let turn = paths.iter().take_while(|(path, _)| path.get(depth).is_some_and(|d| d.holds)).count();
    let (yes, no) = paths.split_at(turn);
    let (yes, no) = (merge(graph, yes, depth + 1), merge(graph, no, depth + 1));
    let mut both = yes;
    for (both, no) in both.iter_mut().zip(no) {
        both.0 = graph.select(decision.less, decision.than, both.0, no.0);
    }
    both
}

impl Symbol {
    /// The input of a number.
    pub fn input(number: u32) -> Self {
        Self(with(|tracer| tracer.graph.input(number)))
    }

    fn build(f: impl FnOnce(&mut Graph) -> Id) -> Self {
        Self(with(|tracer| f(&mut tracer.graph)))
    }

    fn function(node: Node) -> Self {
        Self::build(|graph| graph.function(node))
    }
}

impl fmt::Debug for Symbol {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Symbol({})", self.0.0)
    }
}

macro_rules! operators {
    ($($operator:ident $method:ident $build:ident),*) => { $(
        impl $operator for Symbol {
            type Output = Self;

            fn $method(self, other: Self) -> Self {
                Self::build(|graph| graph.$build(self.0, other.0))
            }
        }
    )* };
}

operators!(Mul mul multiply, Div div divide);

impl Add for Symbol {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self::build(
            |graph| {
                if graph.is(self.0, 0) { graph.unsigned(other.0) } else { graph.add(self.0, other.0) }
            },
        )
    }
}

impl Sub for Symbol {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self::build(|graph| {
            let minus = graph.negate(other.0);
            if graph.is(self.0, 0) { graph.unsigned(minus) } else { graph.add(self.0, minus) }
        })
    }
}

impl Neg for Symbol {
    type Output = Self;

    fn neg(self) -> Self {
        Self::build(|graph| graph.negate(self.0))
    }
}

impl Scalar for Symbol {
    type Real = Self;
    const ORDER: usize = 0;

    fn from_real(value: Self) -> Self {
        value
    }

    fn real(self) -> Self {
        self
    }

    fn nilpotent(self) -> Self {
        Self::ZERO
    }

    fn with_real(self, value: Self) -> Self {
        value
    }

    fn scale(self, factor: Self) -> Self {
        self * factor
    }

    fn joined<const N: usize>(f: impl Fn() -> [Self; N]) -> [Self; N] {
        joined(f)
    }
}

impl Real for Symbol {
    const ZERO: Self = Self(Graph::ZERO);

    fn integer(n: i32) -> Self {
        Self::build(|graph| graph.integer(n.into()))
    }

    fn from_f64(x: f64) -> Self {
        let known = with(|tracer| tracer.stand_ins.get(&x.to_bits()).copied());
        known.map_or_else(|| Self::build(|graph| graph.constant(Number::double(x))), Self)
    }

    fn pi() -> Self {
        Self::build(|graph| graph.intern(Node::Pi))
    }

    fn with_turns(principal: Self, n: Self) -> Self {
        Self::integer(2) * Self::pi() * n + principal
    }

    fn nearest_integer(self) -> Self {
        Self::function(Node::NearestInteger(self.0))
    }

    fn square_root(self) -> Self {
        Self::build(|graph| graph.square_root(self.0))
    }

    fn magnitude(self) -> Self {
        Self::build(|graph| graph.magnitude(self.0))
    }

    fn with_sign_of(self, sign: Self) -> Self {
        let magnitude = self.magnitude();
        Self::choose(sign.less(Self::ZERO), || -magnitude, || magnitude)
    }

    fn reciprocal_or_zero(self) -> Self {
        Self::build(|graph| graph.reciprocal(self.0))
    }

    fn exponential_minus_one(self) -> Self {
        Self::function(Node::ExponentialMinusOne(self.0))
    }

    fn power(self, exponent: Self) -> Self {
        Self::function(Node::Power(self.0, exponent.0))
    }

    type Mask = bool;

    fn less(self, other: Self) -> bool {
        with(|tracer| tracer.decide(self.0, other.0))
    }

    fn holds(mask: bool) -> bool {
        mask
    }

    fn shortcut(_test: impl FnOnce() -> bool) -> bool {
        false
    }

    fn more_exact<T: Select<Self>>(_mask: bool, _yes: impl FnOnce() -> T, no: impl FnOnce() -> T) -> T {
        no()
    }

    fn quaternion_of(r: &[[Self; 3]; 3]) -> [Self; 4] {
        let [a, b, c] = r.map(|row| row.map(|entry| entry.0));
        let [a1, a2, a3] = a;
        let [b1, b2, b3] = b;
        let [c1, c2, c3] = c;
        let r = std::sync::Arc::new([a1, a2, a3, b1, b2, b3, c1, c2, c3]);
        [0, 1, 2, 3].map(|part| Self::function(Node::Quaternion(std::sync::Arc::clone(&r), part)))
    }

    fn sine_cosine(self) -> (Self, Self) {
        (Self::function(Node::Sine(self.0)), Self::function(Node::Cosine(self.0)))
    }

    fn exponential(self) -> Self {
        Self::function(Node::Exponential(self.0))
    }

    fn arctangent(self, x: Self) -> Self {
        Self::function(Node::Arctangent(self.0, x.0))
    }

    fn direction_and_norm<const N: usize>(v: [Self; N]) -> ([Self; N], Self) {
        let norm = Self::build(|graph| graph.norm(&v.map(|component| component.0)));
        let inverse = norm.reciprocal_or_zero();
        (v.map(|component| component * inverse), norm)
    }

    fn exp_series(s: Self, order: usize) -> (Series<Self>, Series<Self>) {
        let series = |node: fn(u32, Id) -> Node| {
            let mut series = [Self::ZERO; MAX_ORDER + 1];
            for (n, coefficient) in series.iter_mut().enumerate().take(order + 1) {
                *coefficient = Self::function(node(n as u32, s.0));
            }
            series
        };
        (series(Node::CosineOfRoot), series(Node::SineOfRoot))
    }

    fn log_series(c: Self, order: usize) -> Series<Self> {
        let mut series = [Self::ZERO; MAX_ORDER + 1];
        for (n, coefficient) in series.iter_mut().enumerate().take(order + 1) {
            *coefficient = Self::function(Node::Logarithm(n as u32, c.0));
        }
        series
    }
}

impl Tracer {
    /// How x < y goes on the path that is being taken.
    fn decide(&mut self, less: Id, than: Id) -> bool {
        if let Some(known) = self.graph.known_less(less, than) {
            return known;
        }
        for explorer in &self.explorers {
            for decision in explorer.path.iter().take(explorer.met) {
                if (decision.less, decision.than) == (less, than) {
                    return decision.holds;
                }
                // x < y excludes y < x.
                if (decision.less, decision.than) == (than, less) && decision.holds {
                    return false;
                }
            }
        }
        let Some(explorer) = self.explorers.last_mut() else { return false };
        if explorer.met >= MOST_BRANCHES {
            self.is_overrun = true;
            return false;
        }
        if explorer.met == explorer.path.len() {
            explorer.path.push(Decision { less, than, holds: true });
        }
        explorer.met += 1;
        explorer.path.get(explorer.met - 1).is_some_and(|decision| decision.holds)
    }
}
