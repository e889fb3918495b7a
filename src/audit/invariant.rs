//! What holds without any reference: laws that relate the numbers of one connector to each other, or to its own numbers at a
//! state that is the same thing seen from elsewhere.
//!
//! Every law here is a list of [`Demand`]s, each linear in the numbers judged: Σ c·x = want. So the same list judges the
//! numbers and every mutant of them.

use super::bound::{Bound, U};
use super::case::{Case, carried, turn};
use super::force::add_forces;
use super::mutant::Mutant;
use super::quantity::{Numbers, OneOrMany, Quantity, request};
use super::sample::{Draw, Motion, Turning, aligned, definition, pair, spin_axis, turning};
use super::verdict::Score;
use crate::catalog::ConnectionType;
use crate::connector::{Branch, Connector, Increment, NodalRow, Output, Request, State, Tally};
use crate::measure::Measure;
use crate::node::{self, DOFS, Pair};
use crate::vector::{self, Vector, apply_transposed, column, cross, scale};
use serde::Serialize;
use std::fmt::{self, Display, Formatter};

/// A law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Invariant {
    /// The six rigid modes are in the kernel of every row.
    RigidModes,
    /// Axes turned with everything change no value, and turn the rows.
    Frame,
    /// The nodal forces of each component are in equilibrium, moments about any point included.
    Equilibrium,
    /// Rates are J q̇, accelerations J q̈ + q̇ᵀ H q̇: the power of nodal forces is that of the component forces.
    Power,
    /// Second derivatives are symmetric.
    Symmetry,
    /// Derivatives that the declaration says are zero are zero.
    Sparsity,
    /// Exchanged nodes give the same length, the opposite rotation vector.
    NodeSwap,
    /// An assembled type gives what its halves give, bit for bit.
    Halves,
    /// A history saved and restored gives the same, bit for bit.
    Restored,
    /// A part of the request gives that part of the whole, bit for bit.
    Restricted,
    /// At the initial state nothing has moved.
    Start,
    /// Turns are counted through ±π and 2πk, either way.
    Turns,
    /// e1a·e2b = 0 and its family: a turn about the free axis, however far, leaves the printed constraints met.
    FreeAxis,
    /// What a friction remembers at a state is what it left at the state before, and its increment is what lies between the two.
    Carried,
}

impl Invariant {
    /// Every law.
    pub const ALL: [Self; 14] = [
        Self::RigidModes,
        Self::Frame,
        Self::Equilibrium,
        Self::Power,
        Self::Symmetry,
        Self::Sparsity,
        Self::NodeSwap,
        Self::Halves,
        Self::Restored,
        Self::Restricted,
        Self::Start,
        Self::Turns,
        Self::FreeAxis,
        Self::Carried,
    ];

    /// In words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::RigidModes => "rigid modes in the kernel",
            Self::Frame => "frame equivariance",
            Self::Equilibrium => "equilibrium of nodal forces",
            Self::Power => "power identity",
            Self::Symmetry => "symmetry of second derivatives",
            Self::Sparsity => "declared sparsity",
            Self::NodeSwap => "exchanged nodes",
            Self::Halves => "assembly equals its halves",
            Self::Restored => "restored history",
            Self::Restricted => "restricted request",
            Self::Start => "zero at the start",
            Self::Turns => "turns through ±π and 2πk",
            Self::FreeAxis => "turns about the free axis",
            Self::Carried => "friction from state to state",
        }
    }
}

/// Σ c·x = want, for numbers x of one evaluation.
#[derive(Clone, Debug)]
pub struct Demand {
    /// (quantity, component, entry, coefficient c).
    pub terms: OneOrMany<(Quantity, usize, usize, f64)>,
    /// A number that is judged besides and is not among those of the evaluation.
    pub offset: f64,
    /// What the sum must be.
    pub want: f64,
    /// How far it may be from that.
    pub allowed: f64,
    /// What is demanded, in words.
    pub what: What,
}

/// What is demanded, written when somebody reads it.
#[derive(Clone, Debug)]
pub enum What {
    /// A sentence.
    Said(String),
    /// An entry of a component (0-based), with what is said before and after its name.
    Entry(&'static str, Quantity, usize, usize, &'static str),
}

impl Display for What {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Said(sentence) => f.write_str(sentence),
            Self::Entry(before, quantity, k, i, after) => {
                write!(f, "{before}{}{after}", quantity.entry_name(*k, *i))
            }
        }
    }
}

impl Demand {
    /// The sum, with numbers by quantity, component and entry.
    pub fn sum(&self, number: impl Fn(Quantity, usize, usize) -> Option<f64>) -> f64 {
        self.terms.iter().fold(self.offset, |sum, (quantity, k, i, c)| {
            sum + c * number(*quantity, *k, *i).unwrap_or(f64::NAN)
        })
    }

    /// How far a sum is from what it must be, in units of what is allowed.
    fn units_of(&self, sum: f64) -> f64 {
        let error = (sum - self.want).abs();
        if error == 0.0 {
            return 0.0;
        }
        let units = error / self.allowed;
        if units.is_nan() { f64::INFINITY } else { units }
    }

    /// How far numbers are from it, in units of what is allowed.
    pub fn units(&self, numbers: &Numbers<f64>) -> f64 {
        self.units_of(self.sum(|quantity, k, i| numbers.entries(quantity).get(k, i)))
    }
}

/// A state with what laws need to know of it.
pub struct Context<'a> {
    case: &'a Case,
    connector: Connector<f64>,
    before: Branch<f64>,
    after: Branch<f64>,
    numbers: &'a Numbers<f64>,
    bound: &'a Bound,
    state: State<f64>,
    increment: Increment<f64>,
}

impl<'a> Context<'a> {
    /// The end of a case; `None` for an empty path.
    pub fn new(case: &'a Case, numbers: &'a Numbers<f64>, bound: &'a Bound) -> Option<Self> {
        let connector = case.connector();
        let before = case.branch_before(&connector);
        let step = *case.last()?;
        let after = connector.advance(&step.state, &step.increment, &before);
        Some(Self {
            case,
            connector,
            before,
            after,
            numbers,
            bound,
            state: step.state,
            increment: step.increment,
        })
    }

    fn measure(&self, k: usize) -> Option<Measure> {
        self.connector.differentiated(k)
    }

    fn components(&self) -> impl Iterator<Item = (usize, Measure)> + '_ {
        (0..6).filter_map(|k| Some((k, self.measure(k)?)))
    }

    fn tolerance(&self, quantity: Quantity, k: usize, i: usize) -> f64 {
        self.bound.tolerance(quantity, k, i)
    }

    /// A sum of entries that must be `want`, allowed what its terms are allowed and a rounding each.
    fn sum(
        &self,
        terms: impl Into<OneOrMany<(Quantity, usize, usize, f64)>>,
        want: f64,
        what: What,
    ) -> Demand {
        let terms = terms.into();
        let allowed = terms
            .iter()
            .map(|(q, k, i, c)| {
                let x = self.numbers.entries(*q).get(*k, *i).unwrap_or(0.0);
                c.abs() * (self.tolerance(*q, *k, *i) + 4.0 * U * x.abs())
            })
            .sum();
        Demand { terms, offset: 0.0, want, allowed, what }
    }

    /// What a law demands of the numbers; nothing where it has nothing to say of this connector.
    pub fn demands(&self, invariant: Invariant) -> Vec<Demand> {
        match invariant {
            Invariant::RigidModes => self.rigid_modes(),
            Invariant::Frame => self.frame(),
            Invariant::Equilibrium => self.equilibrium(),
            Invariant::Power => self.power(),
            Invariant::Symmetry => self.symmetry(),
            Invariant::Sparsity => self.sparsity(),
            Invariant::NodeSwap => self.node_swap(),
            Invariant::Halves => self.halves(),
            Invariant::Restored => self.restored(),
            Invariant::Restricted => self.restricted(),
            Invariant::Start | Invariant::Turns | Invariant::FreeAxis | Invariant::Carried => Vec::new(),
        }
    }

    /// Whether a rigid motion can change the component: the direction of a coincident AXIAL is fixed in space.
    fn is_fixed_in_space(&self, measure: Measure) -> bool {
        matches!(measure, Measure::Distance) && self.state.pair.separation() == [0.0; 3]
    }

    /// The degrees of freedom that the connector would have if its nodes had all of theirs.
    fn of_free_nodes(&self) -> [bool; DOFS] {
        let mut definition = self.case.definition.clone();
        (definition.moves, definition.rotates) = ([true; 2], [true; 2]);
        *Connector::<f64>::new(&definition).active()
    }

    /// Nothing of its rows is left out: those of a grounded node, of one without rotations, out of the plane.
    fn is_free(&self) -> bool {
        !self.case.definition.planar && self.of_free_nodes() == *self.connector.active()
    }

    fn rigid_modes(&self) -> Vec<Demand> {
        let mut found = Vec::new();
        if !self.is_free() {
            return found;
        }
        let separation = self.state.pair.separation();
        for (k, measure) in self.components() {
            if self.is_fixed_in_space(measure) {
                continue;
            }
            for i in 0..3 {
                let first = Quantity::FirstDerivatives;
                let terms = vec![(first, k, node::XA + i, 1.0), (first, k, node::XB + i, 1.0)];
                found.push(self.sum(
                    terms,
                    0.0,
                    What::Said(format!("∂{} along a translation", crate::catalog::COMPONENT[k])),
                ));
                let mut axis = [0.0; 3];
                axis[i] = 1.0;
                let arm = cross(axis, separation);
                let mut terms = vec![(first, k, node::THETA_A + i, 1.0), (first, k, node::THETA_B + i, 1.0)];
                terms.extend((0..3).map(|j| (first, k, node::XB + j, arm[j])));
                found.push(self.sum(
                    terms,
                    0.0,
                    What::Said(format!("∂{} along a rotation", crate::catalog::COMPONENT[k])),
                ));
            }
        }
        found
    }

    /// Forces sum to zero, and so do moments about a: M_a + M_b + d × F_b.
    fn equilibrium(&self) -> Vec<Demand> {
        let mut found = Vec::new();
        let reach = self.connector.reach();
        if self.case.definition.planar || (0..DOFS).any(|j| j % 7 != 6 && !reach[j]) {
            return found;
        }
        let separation = self.state.pair.separation();
        let quantity = Quantity::NodalForces;
        for k in (0..6).filter(|k| self.numbers.entries(quantity).0[*k].is_some()) {
            if self.connector.position_measure(k).is_some_and(|measure| self.is_fixed_in_space(measure)) {
                continue;
            }
            let name = crate::catalog::FORCE[k];
            for i in 0..3 {
                let terms = vec![(quantity, k, node::XA + i, 1.0), (quantity, k, node::XB + i, 1.0)];
                found.push(self.sum(terms, 0.0, What::Said(format!("nodal forces of {name}"))));
                let mut axis = [0.0; 3];
                axis[i] = 1.0;
                let arm = cross(axis, separation);
                let mut terms =
                    vec![(quantity, k, node::THETA_A + i, 1.0), (quantity, k, node::THETA_B + i, 1.0)];
                terms.extend((0..3).map(|j| (quantity, k, node::XB + j, arm[j])));
                found.push(self.sum(terms, 0.0, What::Said(format!("nodal moments of {name}"))));
            }
        }
        found
    }

    /// The numbers of another connector or state, asked the same.
    fn evaluate(&self, connector: &Connector<f64>, state: &State<f64>, branch: &Branch<f64>) -> Numbers<f64> {
        asked(connector, state, &Increment::none(), branch)
    }

    fn frame(&self) -> Vec<Demand> {
        // A rotation that is far from every special one.
        let rotation = turn([0.9, -1.3, 0.4]);
        let mut state = self.state;
        state.pair = carried(&self.state.pair, &rotation, [0.0; 3]);
        let twin = self.evaluate(&self.connector, &state, &self.after);
        let mut found = Vec::new();
        for (k, measure) in self.components() {
            if self.is_fixed_in_space(measure) || self.case.definition.planar {
                continue;
            }
            // The turned inputs are rounded: three roundings in each direction.
            let wider = |mut demand: Demand| {
                demand.allowed *= 4.0;
                demand
            };
            if let (Some(want), false) = (twin.entries(Quantity::Value).get(k, 0), measure.is_one_form()) {
                let terms = OneOrMany::One([(Quantity::Value, k, 0, 1.0)]);
                found.push(wider(self.sum(
                    terms,
                    want,
                    What::Entry("", Quantity::Value, k, 0, " in turned axes"),
                )));
            }
            let vectors = [Quantity::FirstDerivatives, Quantity::NodalForces]
                .into_iter()
                .flat_map(|q| [node::XA, node::THETA_A, node::XB, node::THETA_B].map(|at| (q, at)));
            for (quantity, at) in vectors {
                let Some(row) = &twin.entries(quantity).0[k] else { continue };
                let back = apply_transposed(&rotation, [row[at], row[at + 1], row[at + 2]]);
                for (i, want) in back.into_iter().enumerate() {
                    let terms = OneOrMany::One([(quantity, k, at + i, 1.0)]);
                    let what = What::Entry("", quantity, k, at + i, " in turned axes");
                    let mut demand = wider(self.sum(terms, want, what));
                    // A component of a vector is as uncertain as the vector.
                    demand.allowed = (0..3)
                        .map(|j| 4.0 * self.tolerance(quantity, k, at + j))
                        .sum::<f64>()
                        .max(demand.allowed);
                    found.push(demand);
                }
            }
        }
        if self.is_free() { found } else { Vec::new() }
    }

    fn power(&self) -> Vec<Demand> {
        let mut found = Vec::new();
        let (v, a) = (&self.state.velocity, &self.state.acceleration);
        // A node that is given rates and has no columns for them is not told of by rows.
        let (active, free) = (self.connector.active(), self.of_free_nodes());
        if (0..DOFS).any(|j| free[j] && !active[j] && (v[j] != 0.0 || a[j] != 0.0)) {
            return found;
        }
        for (k, measure) in self.components() {
            if measure.has_nodal_rates() {
                continue;
            }
            let name = crate::catalog::COMPONENT[k];
            let row = |rates: &NodalRow<f64>| {
                let rates = *rates;
                (0..DOFS)
                    .map(move |j| (Quantity::FirstDerivatives, k, j, -rates[j]))
                    .filter(|term| term.3 != 0.0)
            };
            let mut terms = vec![(Quantity::Rate, k, 0, 1.0)];
            terms.extend(row(v));
            found.push(self.sum(terms, 0.0, What::Said(format!("d{name}/dt is J q̇"))));
            let mut terms = vec![(Quantity::Acceleration, k, 0, 1.0)];
            terms.extend(row(a));
            for j in 0..DOFS {
                for l in 0..DOFS {
                    if v[j] * v[l] != 0.0 {
                        terms.push((Quantity::SecondDerivatives, k, j * DOFS + l, -v[j] * v[l]));
                    }
                }
            }
            found.push(self.sum(terms, 0.0, What::Said(format!("d²{name}/dt² is J q̈ + q̇ᵀ H q̇"))));
        }
        found
    }

    fn symmetry(&self) -> Vec<Demand> {
        let mut found = Vec::new();
        for (k, measure) in self.components().filter(|(_, measure)| !measure.is_one_form()) {
            let _ = measure;
            for j in 0..DOFS {
                for l in 0..j {
                    let second = Quantity::SecondDerivatives;
                    let terms = vec![(second, k, j * DOFS + l, 1.0), (second, k, l * DOFS + j, -1.0)];
                    let what = What::Entry("symmetry of ", second, k, j * DOFS + l, "");
                    found.push(self.sum(terms, 0.0, what));
                }
            }
        }
        found
    }

    fn sparsity(&self) -> Vec<Demand> {
        let mut found = Vec::new();
        let active = self.connector.active();
        for (k, measure) in self.components() {
            let on = measure.dependence();
            let reach = self.connector.reach();
            for (j, active) in active.iter().enumerate() {
                let may = match j % 7 {
                    0..=2 => on.translation,
                    3..=5 => on.rotation || (j < 7 && on.translation && measure.turns_with_a()),
                    _ => on.flow,
                };
                if !may || !active {
                    found.push(Demand {
                        terms: OneOrMany::One([(Quantity::FirstDerivatives, k, j, 1.0)]),
                        offset: 0.0,
                        want: 0.0,
                        allowed: 0.0,
                        what: What::Entry("", Quantity::FirstDerivatives, k, j, " is declared zero"),
                    });
                }
                if !reach[j] && self.numbers.entries(Quantity::NodalForces).get(k, j).is_some() {
                    found.push(Demand {
                        terms: OneOrMany::One([(Quantity::NodalForces, k, j, 1.0)]),
                        offset: 0.0,
                        want: 0.0,
                        allowed: 0.0,
                        what: What::Entry("", Quantity::NodalForces, k, j, " is declared zero"),
                    });
                }
            }
        }
        found
    }

    fn node_swap(&self) -> Vec<Demand> {
        let mut found = Vec::new();
        let simple = |measure: Measure| match measure {
            Measure::Distance => Some(1.0),
            Measure::RotationVector(_) => Some(-1.0),
            _ => None,
        };
        if !self.is_free() || !self.components().any(|(_, measure)| simple(measure).is_some()) {
            return found;
        }
        let swap = |pair: &Pair<f64>| Pair { reference: scale(pair.reference, -1.0), a: pair.b, b: pair.a };
        let rows = |x: &NodalRow<f64>| -> NodalRow<f64> { std::array::from_fn(|j| x[(j + DOFS / 2) % DOFS]) };
        let mut definition = self.case.definition.clone();
        definition.initial = swap(&definition.initial);
        let state = State {
            pair: swap(&self.state.pair),
            velocity: rows(&self.state.velocity),
            acceleration: rows(&self.state.acceleration),
        };
        let mut branch = self.after;
        branch.rotation_vector = scale(branch.rotation_vector, -1.0);
        let twin = self.evaluate(&Connector::new(&definition), &state, &branch);
        for (k, measure) in self.components() {
            let Some(sign) = simple(measure) else { continue };
            let Some(row) = &twin.entries(Quantity::FirstDerivatives).0[k] else { continue };
            for j in 0..DOFS {
                let terms = OneOrMany::One([(Quantity::FirstDerivatives, k, j, 1.0)]);
                let what = What::Entry("", Quantity::FirstDerivatives, k, j, " with exchanged nodes");
                let mut demand = self.sum(terms, sign * row[(j + DOFS / 2) % DOFS], what);
                // The rotation vector's components are taken along a's directions before and b's after.
                let block = j - j % 7 % 3;
                let vector: f64 = (0..3)
                    .filter(|i| block + i < DOFS)
                    .map(|i| self.tolerance(Quantity::FirstDerivatives, k, block + i))
                    .sum();
                demand.allowed = 2.0 * demand.allowed.max(vector);
                found.push(demand);
            }
        }
        found
    }

    /// Every number that `twin` has for `components` must be the same, bit for bit.
    fn same(
        &self,
        twin: &Numbers<f64>,
        components: std::ops::Range<usize>,
        what: &'static str,
    ) -> Vec<Demand> {
        let mut found = Vec::new();
        for quantity in Quantity::ALL {
            for (k, i, want) in twin.entries(quantity).iter() {
                if components.contains(&k) && want.is_finite() {
                    found.push(Demand {
                        terms: OneOrMany::One([(quantity, k, i, 1.0)]),
                        offset: 0.0,
                        want,
                        allowed: 0.0,
                        what: What::Entry("", quantity, k, i, what),
                    });
                }
            }
        }
        found
    }

    fn halves(&self) -> Vec<Demand> {
        let [Some(translational), Some(rotational)] = self.case.definition.connection.halves else {
            return Vec::new();
        };
        let half = |half, range: std::ops::Range<usize>| {
            let connection = ConnectionType::basic(half);
            let mut definition = self.case.definition.clone();
            definition.connection = connection.into();
            let connector = Connector::<f64>::new(&definition);
            let start = Case { definition, ..self.case.clone() }.branch_before(&connector);
            self.same(&asked(&connector, &self.state, &self.increment, &start), range, " of its half")
        };
        let mut found = half(translational, 0..3);
        found.extend(half(rotational, 3..6));
        found
    }

    fn restored(&self) -> Vec<Demand> {
        let saved = serde_json::to_string(&self.before).ok();
        let restored: Option<Branch<f64>> = saved.and_then(|text| serde_json::from_str(&text).ok());
        let branch = restored.unwrap_or_else(|| self.connector.initial_branch());
        let again = asked(&self.connector, &self.state, &self.increment, &branch);
        self.same(&again, 0..6, " after a restored history")
    }

    fn restricted(&self) -> Vec<Demand> {
        let mut found = Vec::new();
        for (k, _) in self.components() {
            let mut only = [false; 6];
            only[k] = true;
            let asked = Request::new(&[Output::CU, Output::RES], only, 1);
            let mut tally = Tally::default();
            let part =
                self.connector.evaluate(&self.state, &self.increment, &self.before, &asked, &mut tally);
            found.extend(self.same(&Numbers::of(&part), k..k + 1, " asked for alone"));
        }
        found
    }
}

/// The numbers of a connector at a state, with forces.
fn asked(
    connector: &Connector<f64>,
    state: &State<f64>,
    increment: &Increment<f64>,
    branch: &Branch<f64>,
) -> Numbers<f64> {
    let evaluation = connector.evaluate(state, increment, branch, &request(), &mut Tally::default());
    let mut numbers = Numbers::of(&evaluation);
    add_forces(&mut numbers, connector, state, &evaluation.branch);
    numbers
}

/// What a type must give at its initial state, and after turns about the axis about which it may turn without end. The numbers
/// judged are in the demands themselves.
pub fn of_type(connection: &ConnectionType, invariant: Invariant) -> Vec<Demand> {
    match invariant {
        Invariant::Start => start(connection),
        Invariant::Turns => turns(connection, false),
        Invariant::FreeAxis => turns(connection, true),
        _ => Vec::new(),
    }
}

fn start(connection: &ConnectionType) -> Vec<Demand> {
    let draw = &mut Draw::new(&connection.name);
    let mut found = Vec::new();
    for _ in 0..4 {
        let q0 = aligned(connection, draw);
        let definition = definition(connection, pair(draw.direction(), draw.triad(), &q0), 1.0);
        let connector = Connector::<f64>::new(&definition);
        let state = State { pair: definition.initial, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
        let asked = Request::new(&[Output::CU, Output::RES], [true; 6], 0);
        let mut tally = Tally::default();
        let evaluation =
            connector.evaluate(&state, &Increment::none(), &connector.initial_branch(), &asked, &mut tally);
        for k in 0..6 {
            let name = crate::catalog::COMPONENT[k];
            if let Some(offset) = evaluation.displacement[k] {
                let what = What::Said(format!("displacement {name} at the start"));
                found.push(Demand { terms: Vec::new().into(), offset, want: 0.0, allowed: 0.0, what });
            }
            if let Some(offset) = evaluation.residual[k] {
                // A printed cosine is as far from zero as the directions given are.
                let what = What::Said(format!("residual {name} at the start"));
                found.push(Demand { terms: Vec::new().into(), offset, want: 0.0, allowed: 8.0 * U, what });
            }
        }
    }
    found
}

/// After turns about the free axis: what the angles must be, or that the printed constraints of axes are met.
fn turns(connection: &ConnectionType, constraints: bool) -> Vec<Demand> {
    const SIZES: [f64; 6] = [3.0, 3.3, 6.2, 6.4, 20.0, 100.0];
    let draw = &mut Draw::new(&connection.name);
    let mut found = Vec::new();
    for size in SIZES.into_iter().flat_map(|size| [size, -size]) {
        let q0 = match turning(connection) {
            Turning::RotationVector => vector::identity(),
            _ => aligned(connection, draw),
        };
        let a0 = draw.triad();
        let axis = spin_axis(connection, &a0, draw);
        let definition = definition(connection, pair(draw.direction(), a0, &q0), 1.0);
        let steps = (size.abs() / 0.35) as usize;
        let motion = Motion { steps, ..Motion::random(draw, 1.0, scale(axis, size)) };
        let path = motion.path(&definition.initial);
        let case = Case { name: String::new(), definition, start: None, path, length: 1.0 };
        let asked = Request::new(&[Output::CU, Output::RES], [true; 6], 0);
        let Some((evaluation, _)) = case.evaluation(&asked) else { continue };
        if constraints {
            let is_met = matches!(turning(connection), Turning::Universal | Turning::Revolute);
            for k in (3..6).filter(|_| is_met) {
                let Some(offset) = evaluation.residual[k] else { continue };
                let what = What::Said(format!("residual {} after {size} rad", crate::catalog::COMPONENT[k]));
                // Each step turns the triads once more, and each time they are rounded.
                let allowed = 8.0 * U * (1.0 + steps as f64);
                found.push(Demand { terms: Vec::new().into(), offset, want: 0.0, allowed, what });
            }
            continue;
        }
        let along: Vector<f64> = [0, 1, 2].map(|i| {
            let direction = column(&a0, i);
            (0..3).map(|j| direction[j] * axis[j]).sum()
        });
        for k in 3..6 {
            let position = connection.slots[k].position();
            let want = match (turning(connection), position) {
                (Turning::Cardan | Turning::Universal | Turning::Revolute, Some(Measure::Cardan(1)))
                | (Turning::Euler, Some(Measure::Euler(1)))
                | (_, Some(Measure::Torsion)) => size,
                (_, Some(Measure::RotationVector(i))) => size * along[i - 1],
                _ => continue,
            };
            // CONSTANT VELOCITY measures torsion about shafts that stay; elsewhere the axis is that of the angle.
            let Some(offset) = evaluation.displacement[k] else { continue };
            let what = What::Said(format!("{} after {size} rad", crate::catalog::COMPONENT[k]));
            let allowed = 64.0 * U * (1.0 + size.abs());
            found.push(Demand { terms: Vec::new().into(), offset, want, allowed, what });
        }
    }
    found
}

/// Judges a list of demands: the worst, in units of what is allowed.
pub fn worst<'a>(numbers: &Numbers<f64>, demands: &'a [Demand]) -> Option<(&'a Demand, f64)> {
    demands.iter().map(|demand| (demand, demand.units(numbers))).max_by(|x, y| x.1.total_cmp(&y.1))
}

/// Which mutants of a quantity a law notices. A law need not notice them all: the oracles do; it must notice some.
pub fn try_mutants(
    quantity: Quantity,
    numbers: &Numbers<f64>,
    demands: &[Demand],
    mutants: &[Mutant],
) -> Score {
    let width = quantity.entries();
    let place = |k: usize, i: usize| k * width + i;
    // The demands in which each entry occurs.
    let mut touched: Vec<Vec<usize>> = vec![Vec::new(); 6 * width];
    for (n, demand) in demands.iter().enumerate() {
        for (_, k, i, _) in demand.terms.iter().filter(|(q, ..)| *q == quantity) {
            if let Some(of_entry) = touched.get_mut(place(*k, *i)) {
                of_entry.push(n);
            }
        }
    }
    let mut changed: Vec<Option<f64>> = vec![None; 6 * width];
    let mut score = Score::default();
    for mutant in mutants {
        for (k, i, x) in mutant.changes.iter() {
            if let Some(entry) = changed.get_mut(place(*k, *i)) {
                *entry = Some(*x);
            }
        }
        let number = |q: Quantity, k: usize, i: usize| {
            let new = if q == quantity { changed.get(place(k, i)).copied().flatten() } else { None };
            new.or_else(|| numbers.entries(q).get(k, i))
        };
        let mut asked: Vec<usize> = mutant
            .changes
            .iter()
            .filter_map(|(k, i, _)| touched.get(place(*k, *i)))
            .flatten()
            .copied()
            .collect();
        asked.sort_unstable();
        asked.dedup();
        let of = |n: &usize| demands.get(*n).is_some_and(|demand| demand.units_of(demand.sum(number)) > 1.0);
        // What a law does not notice counts as nothing.
        score.count(mutant.mistake, asked.iter().any(of), || 0.0, String::new);
        for (k, i, _) in mutant.changes.iter() {
            if let Some(entry) = changed.get_mut(place(*k, *i)) {
                *entry = None;
            }
        }
    }
    score
}
