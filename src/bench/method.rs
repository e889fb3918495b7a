//! Ways to get a value, a Jacobian or a Hessian.

use crate::batch::Batched;
use crate::bound::Cause;
use crate::subject::{Element, Order, Subject};
use pintle_kinematics::connector::{Connector, Linear, Mask, Request, Tally};
use pintle_kinematics::measure::Measure;
use pintle_kinematics::node::{DOFS, Pair};
use pintle_kinematics::so3;
use pintle_kinematics::vector::product;
use std::f64::consts::{PI, TAU};
use std::hint::black_box;

/// A way to get numbers of one order, ready to be timed: what it reads and where it writes are its own.
pub trait Prepared {
    /// Computes the numbers of each of [`Prepared::states`].
    fn run(&mut self);

    /// How many states a run goes through: those of the subject once or, where it takes a batch, over and over.
    fn states(&self) -> usize;

    /// What a run computes: state by state, row by row, in the order of [`pintle_kinematics::node::DOF`].
    fn numbers(&mut self) -> Vec<f64>;
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

    /// The vector unit that it runs on, of a way that has several states in its lanes.
    fn vector_unit(&self) -> Option<&'static str> {
        None
    }

    /// What its errors come from, which tells how large they may be for it to be timed.
    fn cause(&self) -> Cause;

    /// The same for the elements of a subject.
    ///
    /// # Errors
    /// Why there is no such way.
    fn prepare<'s>(&self, subject: &'s Subject) -> Result<Box<dyn Prepared + 's>, &'static str>;
}

/// The ways that the library has for every type.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Way {
    /// pintle, one connector at a time: [`Connector::values`], [`Connector::linearize`], [`Connector::evaluate_on`].
    Pintle(Order),
    /// pintle, four states at a time ([`pintle_kinematics::batch`]): values with rows or, as the Hessian, with second derivatives besides; there is no batch
    /// of values alone. States and rows are in tiles of four.
    Batch(Order),
    /// (f(q + h) − f(q))/h, for each degree of freedom.
    Forward(f64),
    /// (f(q + h) − f(q − h))/2h.
    Central(f64),
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
        all.extend([Order::Jacobian, Order::Hessian].map(Self::Batch));
        all.push(Self::NodalDual);
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
            Self::Batch(_) => "pintle, batch",
            Self::Forward(_) => "forward differences",
            Self::Central(_) | Self::SecondCentral(_) => "central differences",
            Self::NodalDual => "num-dual by node",
            Self::NestedDual => "nested num-dual by node",
        }
    }

    fn order(&self) -> Order {
        match self {
            Self::Pintle(order) | Self::Batch(order) => *order,
            Self::SecondCentral(_) | Self::NestedDual => Order::Hessian,
            _ => Order::Jacobian,
        }
    }

    fn step(&self) -> Option<f64> {
        match self {
            Self::Forward(h) | Self::Central(h) | Self::SecondCentral(h) => Some(*h),
            _ => None,
        }
    }

    fn vector_unit(&self) -> Option<&'static str> {
        if matches!(self, Self::Batch(_)) { pintle_kinematics::batch::vector_unit() } else { None }
    }

    fn cause(&self) -> Cause {
        match self {
            Self::Pintle(_) | Self::Batch(_) => Cause::Ours,
            Self::NodalDual | Self::NestedDual => Cause::Rounding,
            Self::Forward(_) => Cause::ForwardDifference,
            Self::Central(_) => Cause::CentralDifference,
            Self::SecondCentral(_) => Cause::SecondDifference,
        }
    }

    fn prepare<'s>(&self, subject: &'s Subject) -> Result<Box<dyn Prepared + 's>, &'static str> {
        if let Self::Batch(order) = self {
            return Ok(Box::new(Batched::new(*order, subject)?));
        }
        let connector = subject.elements.first().ok_or("there is no state")?.connector.clone();
        // All that there are, unless one-forms are left out.
        let is_all = (0..6).all(|k| connector.differentiated(k).is_none() || subject.components.contains(&k));
        let wanted = [0, 1, 2, 3, 4, 5].map(|k| is_all || subject.components.contains(&k));
        let request = Request::new(&[], wanted, 2);
        let (rows, out) = ([Linear::default(); 6], vec![0.0; subject.rows() * self.order().width()]);
        Ok(Box::new(Run { way: *self, subject, wanted, request, rows, out }))
    }
}

/// One state after the other, into the same memory.
struct Run<'s> {
    way: Way,
    subject: &'s Subject,
    wanted: Mask,
    request: Request,
    /// Of [`Connector::linearize`], which needs no other.
    rows: [Linear<f64>; 6],
    out: Vec<f64>,
}

impl Run<'_> {
    #[inline(always)]
    fn one(&mut self, i: usize) {
        let Self { way, subject, wanted, request, rows, out } = self;
        let Some(element) = subject.elements.get(i) else { return };
        let at = AtElement { subject, element, wanted: *wanted };
        match *way {
            Way::Pintle(Order::Value) => at.values(&element.state.pair, out),
            Way::Pintle(Order::Jacobian) => at.rows(rows),
            Way::Pintle(Order::Hessian) => at.second(request, out),
            // Prepared as a run of its own.
            Way::Batch(_) => {}
            Way::Forward(h) => at.forward(h, out),
            Way::Central(h) => at.central(h, out),
            Way::NodalDual => at.nodal_dual(out),
            Way::SecondCentral(h) => at.second_central(h, out),
            Way::NestedDual => at.nested_dual(out),
        }
    }
}

impl Run<'_> {
    /// The rows of all states. Those of a SLIDE-PLANE take so little time that to ask for the way at each state would be a seventh of it.
    fn linearize(&mut self) {
        let Self { subject, wanted, rows, .. } = self;
        for element in &subject.elements {
            AtElement { subject, element, wanted: *wanted }.rows(rows);
            black_box(&mut *rows);
        }
    }
}

impl Prepared for Run<'_> {
    fn run(&mut self) {
        if self.way == Way::Pintle(Order::Jacobian) {
            return self.linearize();
        }
        for i in 0..self.subject.elements.len() {
            self.one(i);
            black_box((&mut self.rows, &mut self.out));
        }
    }

    fn states(&self) -> usize {
        self.subject.elements.len()
    }

    fn numbers(&mut self) -> Vec<f64> {
        let mut all = Vec::new();
        for i in 0..self.subject.elements.len() {
            self.one(i);
            match self.way {
                Way::Pintle(Order::Jacobian) => {
                    all.extend(self.rows.iter().take(self.subject.rows()).flat_map(|row| row.row));
                }
                _ => all.extend(&self.out),
            }
        }
        all
    }
}

/// One element.
struct AtElement<'a> {
    subject: &'a Subject,
    element: &'a Element,
    wanted: Mask,
}

impl AtElement<'_> {
    fn connector(&self) -> &Connector<f64> {
        &self.element.connector
    }

    /// The degrees of freedom that there are.
    fn active(&self) -> impl Iterator<Item = usize> + use<> {
        let active = *self.connector().active();
        (0..DOFS).filter(move |j| active[*j])
    }

    #[inline(always)]
    fn rows(&self, out: &mut [Linear<f64>; 6]) {
        let Element { connector, state, branch } = self.element;
        connector.linearize(&state.pair, branch, self.wanted, out);
    }

    fn values(&self, pair: &Pair<f64>, out: &mut [f64]) {
        let found = self.connector().values(pair, &self.element.branch, self.wanted);
        for (out, k) in out.iter_mut().zip(&self.subject.components) {
            *out = found[*k].unwrap_or(f64::NAN);
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
                node.triad = product(&so3::matrix(so3::exp_quaternion(rotation)), &node.triad);
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
