//! Ways to get a value, a Jacobian or a Hessian.

use super::complex::Complex;
use super::subject::{Element, Order, Subject};
use crate::connector::{Connector, Linear, Mask, Request, Tally};
use crate::measure::Measure;
use crate::node::{DOFS, Node, Pair};
use crate::scalar::Scalar;
use crate::so3;
use crate::vector::product;
use std::f64::consts::{PI, TAU};

/// A way to get numbers of one order, ready to be timed: what it reads and where it writes are its own.
pub trait Prepared {
    /// Computes the numbers of every element.
    fn run(&mut self);

    /// What the last run computed: element by element, row by row, in the order of [`crate::node::DOF`].
    fn numbers(&self) -> Vec<f64>;
}

/// A way to get numbers of one order.
pub trait Method: Sync {
    /// Its name in reports.
    fn name(&self) -> &'static str;

    /// What it gives.
    fn order(&self) -> Order;

    /// The step, of a way that has one. Ways that differ in their steps alone take the same time.
    fn step(&self) -> Option<f64> {
        None
    }

    /// Whether it is pintle's own, which must be right to be timed.
    fn is_ours(&self) -> bool {
        false
    }

    /// The same for the elements of a subject; `None` where there is no such way.
    fn prepare<'s>(&self, subject: &'s Subject) -> Option<Box<dyn Prepared + 's>>;
}

/// The ways that the library has for every type.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Way {
    /// pintle, one connector at a time: [`Connector::values`], [`Connector::linearize`], [`Connector::evaluate_on`].
    Pintle(Order),
    /// (f(q + h) − f(q))/h, for each degree of freedom.
    Forward(f64),
    /// (f(q + h) − f(q − h))/2h.
    Central(f64),
    /// Im f(q + ih)/h.
    ComplexStep(f64),
    /// num-dual's dual number with a direction for every degree of freedom of the nodes.
    NodalDual,
    /// Second derivatives by four values each, (f(q + h_j + h_k) − f(q + h_j − h_k) − f(q − h_j + h_k) + f(q − h_j − h_k))/4h².
    SecondCentral(f64),
    /// num-dual's dual numbers in the degrees of freedom of the nodes, nested in dual numbers.
    NestedDual,
}

/// 10^−k.
fn powers(of: impl Iterator<Item = i32>) -> impl Iterator<Item = f64> {
    of.map(|k| 10.0_f64.powi(-k))
}

impl Way {
    /// All, with the steps of the sweeps.
    pub fn all() -> Vec<Self> {
        let mut all: Vec<Self> = Order::ALL.map(Self::Pintle).to_vec();
        all.push(Self::NodalDual);
        all.extend(powers([1, 2, 4, 6, 8, 12, 20, 100].into_iter()).map(Self::ComplexStep));
        all.extend(powers(1..=13).map(Self::Central));
        all.extend(powers(1..=13).map(Self::Forward));
        all.push(Self::NestedDual);
        all.extend(powers(1..=8).map(Self::SecondCentral));
        all
    }
}

impl Method for Way {
    fn name(&self) -> &'static str {
        match self {
            Self::Pintle(_) => "pintle",
            Self::Forward(_) => "forward differences",
            Self::Central(_) | Self::SecondCentral(_) => "central differences",
            Self::ComplexStep(_) => "complex step",
            Self::NodalDual => "num-dual by node",
            Self::NestedDual => "nested num-dual by node",
        }
    }

    fn order(&self) -> Order {
        match self {
            Self::Pintle(order) => *order,
            Self::SecondCentral(_) | Self::NestedDual => Order::Hessian,
            _ => Order::Jacobian,
        }
    }

    fn step(&self) -> Option<f64> {
        match self {
            Self::Forward(h) | Self::Central(h) | Self::ComplexStep(h) | Self::SecondCentral(h) => Some(*h),
            _ => None,
        }
    }

    fn is_ours(&self) -> bool {
        matches!(self, Self::Pintle(_))
    }

    fn prepare<'s>(&self, subject: &'s Subject) -> Option<Box<dyn Prepared + 's>> {
        let mut wanted = [false; 6];
        subject.components.iter().for_each(|k| wanted[*k] = true);
        let numbers = vec![0.0; subject.elements.len() * subject.rows() * self.order().width()];
        let request = Request::new(&[], wanted, 2);
        Some(Box::new(Run { way: *self, subject, wanted, request, numbers }))
    }
}

struct Run<'s> {
    way: Way,
    subject: &'s Subject,
    wanted: Mask,
    request: Request,
    numbers: Vec<f64>,
}

impl Prepared for Run<'_> {
    fn run(&mut self) {
        let Self { way, subject, wanted, request, numbers } = self;
        let width = subject.rows() * way.order().width();
        for (element, out) in subject.elements.iter().zip(numbers.chunks_exact_mut(width)) {
            let at = Place { subject, element, wanted: *wanted };
            match *way {
                Way::Pintle(Order::Value) => at.values(&element.state.pair, out),
                Way::Pintle(Order::Jacobian) => at.rows(out),
                Way::Pintle(Order::Hessian) => at.second(request, out),
                Way::Forward(h) => at.forward(h, out),
                Way::Central(h) => at.central(h, out),
                Way::ComplexStep(h) => at.complex_step(h, out),
                Way::NodalDual => at.nodal_dual(out),
                Way::SecondCentral(h) => at.second_central(h, out),
                Way::NestedDual => at.nested_dual(out),
            }
        }
    }

    fn numbers(&self) -> Vec<f64> {
        self.numbers.clone()
    }
}

/// One element.
struct Place<'a> {
    subject: &'a Subject,
    element: &'a Element,
    wanted: Mask,
}

impl Place<'_> {
    fn connector(&self) -> &Connector<f64> {
        &self.element.connector
    }

    /// The degrees of freedom that there are.
    fn active(&self) -> impl Iterator<Item = usize> + use<> {
        let active = *self.connector().active();
        (0..DOFS).filter(move |j| active[*j])
    }

    fn values(&self, pair: &Pair<f64>, out: &mut [f64]) {
        let found = self.connector().values(pair, &self.element.branch, self.wanted);
        for (out, k) in out.iter_mut().zip(&self.subject.components) {
            *out = found[*k].unwrap_or(f64::NAN);
        }
    }

    fn rows(&self, out: &mut [f64]) {
        let mut rows = [Linear::default(); 6];
        let pair = &self.element.state.pair;
        self.connector().linearize(pair, &self.element.branch, self.wanted, &mut rows);
        for (out, row) in out.chunks_exact_mut(DOFS).zip(&rows) {
            out.copy_from_slice(&row.row);
        }
    }

    fn second(&self, request: &Request, out: &mut [f64]) {
        let Element { connector, state, branch } = self.element;
        let found = connector.evaluate_on(state, *branch, request, &mut Tally::default());
        for (out, k) in out.chunks_exact_mut(DOFS * DOFS).zip(&self.subject.components) {
            match &found.hessian[*k] {
                Some(matrix) => out.copy_from_slice(matrix.as_flattened()),
                None => out.fill(f64::NAN),
            }
        }
    }

    /// The values after the degrees of freedom j have moved by h.
    fn values_after(&self, moved: &[(usize, f64)]) -> [f64; 6] {
        let mut pair = self.element.state.pair;
        let mut turned = [None; 2];
        for (dof, h) in moved.iter().copied() {
            let end = dof / (DOFS / 2);
            let node = if end == 0 { &mut pair.a } else { &mut pair.b };
            match dof % (DOFS / 2) {
                i @ 0..3 => node.displacement[i] += h,
                i @ 3..6 => turned[end].get_or_insert([0.0; 3])[i - 3] += h,
                _ => node.flow += h,
            }
        }
        for (node, turned) in [&mut pair.a, &mut pair.b].into_iter().zip(turned) {
            if let Some(rotation) = turned {
                node.triad = product(&so3::matrix(so3::exp(rotation)), &node.triad);
            }
        }
        let mut values = [0.0; 6];
        self.values(&pair, &mut values[..self.subject.rows()]);
        values
    }

    /// The difference of two values of row r, not across the cut of an angle.
    fn difference(&self, r: usize, [to, from]: [f64; 2]) -> f64 {
        let difference = to - from;
        let winds = self.subject.measures.get(r).is_some_and(|measure| Measure::winds(*measure));
        if winds && difference.abs() > PI { difference - TAU.copysign(difference) } else { difference }
    }

    fn forward(&self, h: f64, out: &mut [f64]) {
        let here = self.values_after(&[]);
        for j in self.active() {
            let there = self.values_after(&[(j, h)]);
            for (r, row) in out.chunks_exact_mut(DOFS).enumerate() {
                row[j] = self.difference(r, [there[r], here[r]]) / h;
            }
        }
    }

    fn central(&self, h: f64, out: &mut [f64]) {
        for j in self.active() {
            let [ahead, behind] = [h, -h].map(|h| self.values_after(&[(j, h)]));
            for (r, row) in out.chunks_exact_mut(DOFS).enumerate() {
                row[j] = self.difference(r, [ahead[r], behind[r]]) / (2.0 * h);
            }
        }
    }

    fn second_central(&self, h: f64, out: &mut [f64]) {
        for j in self.active() {
            for k in self.active().take_while(|k| *k <= j) {
                let at = |s: f64, t: f64| self.values_after(&[(j, s * h), (k, t * h)]);
                let corners = [at(1.0, 1.0), at(1.0, -1.0), at(-1.0, 1.0), at(-1.0, -1.0)];
                for (r, matrix) in out.chunks_exact_mut(DOFS * DOFS).enumerate() {
                    let [a, b, c, d] = corners.map(|corner| corner[r]);
                    let rest = self.difference(r, [a, b]) - self.difference(r, [c, d]);
                    let entry = rest / (4.0 * h * h);
                    (matrix[j * DOFS + k], matrix[k * DOFS + j]) = (entry, entry);
                }
            }
        }
    }

    fn complex_step(&self, h: f64, out: &mut [f64]) {
        let Element { connector, state, branch } = self.element;
        for j in self.active() {
            let values = connector.on_nodes(&stepped(&state.pair, j, h), &state.pair.a.triad, branch);
            for (row, k) in out.chunks_exact_mut(DOFS).zip(&self.subject.components) {
                row[j] = values[*k].map_or(f64::NAN, |value| value.im / h);
            }
        }
    }

    fn nodal_dual(&self, out: &mut [f64]) {
        let Element { connector, state, branch } = self.element;
        let rows = connector.nodal_rows(state, branch);
        for (out, k) in out.chunks_exact_mut(DOFS).zip(&self.subject.components) {
            out.copy_from_slice(&rows[*k].unwrap_or([f64::NAN; DOFS]));
        }
    }

    fn nested_dual(&self, out: &mut [f64]) {
        let Element { connector, state, branch } = self.element;
        let found = connector.nested(state, branch);
        for (out, k) in out.chunks_exact_mut(DOFS * DOFS).zip(&self.subject.components) {
            match &found[*k] {
                Some((_, matrix)) => out.copy_from_slice(matrix.as_flattened()),
                None => out.fill(f64::NAN),
            }
        }
    }
}

/// The pair with a degree of freedom moved by ih: a rotation about a global axis e turns a triad C to C + ih e × C.
fn stepped(pair: &Pair<f64>, dof: usize, h: f64) -> Pair<Complex> {
    let end = |node: &Node<f64>, dof: Option<usize>| {
        let mut moved = Node {
            displacement: node.displacement.map(Complex::from_real),
            triad: node.triad.map(|row| row.map(Complex::from_real)),
            flow: Complex::from_real(node.flow),
        };
        match dof {
            Some(i @ 0..3) => moved.displacement[i].im = h,
            Some(i @ 3..6) => {
                let (j, k) = ((i - 2) % 3, (i - 1) % 3);
                for column in 0..3 {
                    moved.triad[j][column].im = -h * node.triad[k][column];
                    moved.triad[k][column].im = h * node.triad[j][column];
                }
            }
            Some(_) => moved.flow.im = h,
            None => {}
        }
        moved
    };
    let (own, of_b) = (dof % (DOFS / 2), dof >= DOFS / 2);
    let (a, b) = (end(&pair.a, (!of_b).then_some(own)), end(&pair.b, of_b.then_some(own)));
    Pair { reference: pair.reference, a, b }
}
