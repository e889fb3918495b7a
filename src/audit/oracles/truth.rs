//! A case on 237-bit numbers, with textbook formulas for the elementary functions, and derivatives of it as
//! differences whose step is so small that nothing is left to tune.
//!
//! First derivatives: h = s·1e-25, error of the difference about 1e-50, of rounding 1e-45. Second derivatives of values: see `second`;
//! accelerations: h = s·1e-18·√δ, δ the distance to the nearest singular set. s is the size of the degree of freedom, or the
//! distance where that is less. Values alone are differenced: no dual number enters, and no map from relative to nodal degrees of
//! freedom. What is left of rounding is told with the answer (`Truth::own_error`).

use crate::case::quantity::{Entries, Numbers, Quantity, request};
use crate::case::{AtEnd, Case, exact_branch, exact_state, moved};
use crate::judge::bound::Bound;
use crate::oracles::differences::{self, FIRST_STEP, NOISE};
use crate::oracles::oracle::Narrow;
use pintle_kinematics::Differentiable;
use pintle_kinematics::connector::{
    Branch, Components, Connector, Evaluation, Increment, Mask, NodalRow, Output, Request, State, Tally,
};
use pintle_kinematics::measure::{Margin, Measure, SingularClass};
use pintle_kinematics::node::{self, DOFS, Dependence, Pair, dof_size};
use pintle_kinematics::scalar::{Real, Scalar, Wide};
use pintle_kinematics::vector::{
    Matrix, Vector, apply_transposed, product, sub, transpose, transposed_product,
};
use std::sync::OnceLock;

/// A case on 237-bit numbers, from the same doubles.
pub struct Truth {
    /// The connector and the state as they are given, which values are of.
    given: (Connector<Wide>, State<Wide>),
    /// The same with triads that are rotations to the last of 237 bits, initially and now, which derivatives are of. What leaves the group by the rounding of
    /// 53 bits is evaluated on one way or another, between which a step may change: at right angles values would jump by 1e-32.
    connector: Connector<Wide>,
    state: State<Wide>,
    /// The branch that the end of the case leaves: what moves from there stays on its sheet, even at an exact half turn, which
    /// is equally far from two sheets of the state before.
    branch: Branch<Wide>,
    length: f64,
    /// min(1, distance to the nearest singular set, in radians and lengths of the connector).
    nearness: f64,
    /// The same of each component by itself.
    of_components: [f64; 6],
    /// The components that are at a lock.
    locked: Locked,
    /// The positions whose opposites are as good at the state ([`SingularClass::Reversal`]): what moves from there keeps their signs.
    reversible: Components<Wide>,
    /// The components of a rotation vector without history that is exactly half a turn, where it is the opposite of the product's. Either is right,
    /// and what moves from there is judged from the side of the product.
    opposite: Option<[usize; 3]>,
    /// The directions along which constraint moments that are printed about one act, components along e_i^a.
    pub(super) moment_axes: Components<Vector<Wide>>,
    /// Where the case ends.
    still: OnceLock<Displaced>,
    /// What first derivatives are differenced from, ahead and behind in each degree of freedom, with the values there.
    places: [OnceLock<Around>; DOFS],
    /// Second differences as they are taken on a singular set.
    pub(super) on_a_set: OnceLock<[Entries<Wide>; 2]>,
}

/// The components of which something is not determined: at a lock of successive angles the first of them keeps the value that it had before,
/// and the third takes what is known of both.
#[derive(Clone, Copy, Debug, Default)]
pub struct Locked {
    /// Those whose rows are no gradients: along the lock they have derivatives, across it what rounding makes of them.
    pub rows: [bool; 6],
    /// Those of which rounding decides whether they are locked: on 237 bits their values may be others.
    pub values: [bool; 6],
    /// Those of which nothing is determined: at a true singularity, or so close to where a value changes its sign that rounding decides.
    pub everything: [bool; 6],
    /// Those of which rounding decides on which side of a singular set the state is: values are what they are, of derivatives nobody knows which are meant.
    pub sides: [bool; 6],
}

impl Locked {
    /// As it is on doubles, and with 237 bits at the triads given and at rotations.
    fn of(found: [[bool; 6]; 3]) -> Self {
        let all = [0, 1, 2, 3, 4, 5];
        let rows = all.map(|k| found.iter().any(|locks| locks[k]));
        let values = all.map(|k| rows[k] && !found.iter().all(|locks| locks[k]));
        Self { rows, values, everything: [false; 6], sides: [false; 6] }
    }
}

/// Whether the angles of each component are so close to a lock that rounding decides them.
pub(super) fn locks<R: Differentiable<Mask = bool>>(connector: &Connector<R>, pair: &Pair<R>) -> [bool; 6] {
    let measures = [0, 1, 2, 3, 4, 5].map(|k| connector.position_measure(k));
    if !measures.iter().flatten().any(|measure| measure.locks()) {
        return [false; 6];
    }
    let q = transposed_product(&pair.a.triad, &pair.b.triad);
    measures.map(|measure| measure.is_some_and(|measure| measure.is_locked(&q)))
}

/// The rotation nearest to a triad of doubles, to the last of 237 bits: Newton's method on C^T C = 1.
pub fn rotation(mut triad: Matrix<Wide>) -> Matrix<Wide> {
    /// Each squares the error: 1e-16, 1e-32, 1e-64, 1e-71.
    const STEPS: usize = 4;
    for _ in 0..STEPS {
        let square = product(&transpose(&triad), &triad);
        let half = |i: usize, j: usize| {
            let three = Wide::integer(if i == j { 3 } else { 0 });
            (three - square[i][j]) / Wide::integer(2)
        };
        let correction = [0, 1, 2].map(|i| [0, 1, 2].map(|j| half(i, j)));
        triad = product(&triad, &correction);
    }
    triad
}

/// The positions of a state.
fn positions(connector: &Connector<Wide>, state: &State<Wide>, branch: Branch<Wide>) -> Components<Wide> {
    let asked = Request::new(&[Output::CP], [true; 6], 0);
    connector.evaluate_on(state, branch, &asked, &mut Tally::default()).position
}

/// A step, and the values after it and before it.
type Moved = (Wide, [Components<Wide>; 2]);

/// Places ahead and behind along a degree of freedom, with the values there.
type Around = [(Displaced, Components<Wide>); 2];

/// Where the nodes have moved along one degree of freedom.
pub struct Displaced {
    pub(super) by: NodalRow<Wide>,
    pub(super) state: State<Wide>,
    /// What moved through half a torsion goes on, as it does where positions are evaluated.
    pub(super) branch: Branch<Wide>,
}

impl Truth {
    /// The end of a case; `None` for an empty path.
    pub fn of(case: &Case) -> Option<Self> {
        Some(Self::at(&case.at_end()?))
    }

    /// The same where the end is at hand.
    pub fn at(end: &AtEnd<'_>) -> Self {
        let AtEnd { case, connector: narrow, step, after, .. } = end;
        let at_end = Narrow::at(end);
        let mut of_components = at_end.nearness_of_components();
        let mut state = exact_state(&step.state);
        if step.state.pair.separation() == [0.0; 3] {
            // Nodes that coincide on doubles, and not to their last digits: that they coincide is what is meant.
            state.pair.b.displacement = sub(state.pair.a.displacement, state.pair.reference);
        }
        let connector = Connector::new(&case.definition);
        let margins = at_end.margins();
        let given = state;
        for node in [&mut state.pair.a, &mut state.pair.b] {
            node.triad = rotation(node.triad);
        }
        let initial = rotation(connector.section().initial_orientation);
        // A distance of zero on doubles is one of rounding where the triads are rotations to rounding.
        let are_rotations = state.pair.a.triad == given.pair.a.triad
            && state.pair.b.triad == given.pair.b.triad
            && initial == connector.section().initial_orientation;
        let mut locked =
            Locked::of([at_end.locks(), locks(&connector, &given.pair), locks(&connector, &state.pair)]);
        // On the axis of b's radius by rounding alone: on which side of it nobody can say.
        let is_off_axis = |k: usize| {
            let [x, y, _] = apply_transposed(&state.pair.a.triad, state.pair.separation());
            let is_radius = connector.differentiated(k) == Some(Measure::RadialDistance);
            is_radius && (x != Wide::zero() || y != Wide::zero())
        };
        locked.everything = [0, 1, 2, 3, 4, 5].map(|k| {
            let is_undetermined = |Margin { distance, set }: Margin| match set.class {
                SingularClass::TrueSingularity => true,
                SingularClass::BranchCut | SingularClass::Reversal => distance > 0.0 || !are_rotations,
                SingularClass::Kink | SingularClass::Removable => false,
            };
            of_components[k] == 0.0 && margins[k].is_some_and(is_undetermined)
        });
        locked.sides = [0, 1, 2, 3, 4, 5].map(|k| of_components[k] == 0.0 && is_off_axis(k));
        for (near, locks) in of_components.iter_mut().zip(locked.rows) {
            *near = if locks { 0.0 } else { *near };
        }
        let mut connector = connector;
        for (k, origin) in end.undetermined_origins().into_iter().enumerate() {
            // What rounding decided is taken as it is: what has happened since is judged.
            if let Some(origin) = origin {
                connector = connector.counting_from(k, Wide::from_f64(origin));
            }
        }
        let given = (connector.clone(), given);
        let connector = connector.oriented_from(initial);
        // Rounding may have put an angle of half a turn on the other side of it.
        let branch = connector.advance(&state, &Increment::none(), &exact_branch(after));
        let is_reversible = |k: usize| {
            let on_set = margins[k].filter(|margin| margin.set.class == SingularClass::Reversal);
            on_set.is_some_and(|margin| margin.distance == 0.0) && !locked.everything[k]
        };
        let mut reversible = [None; 6];
        if (0..6).any(is_reversible) {
            let here = positions(&connector, &state, branch);
            reversible = [0, 1, 2, 3, 4, 5].map(|k| here[k].filter(|_| is_reversible(k)));
        }
        let mut truth = Self {
            given,
            opposite: None,
            moment_axes: std::array::from_fn(|k| connector.carried_moment_axis(k)),
            connector,
            state,
            branch,
            reversible,
            length: case.length,
            nearness: of_components.into_iter().fold(1.0, f64::min),
            of_components,
            locked,
            still: OnceLock::new(),
            places: Default::default(),
            on_a_set: OnceLock::new(),
        };
        let is_at_half_a_turn = |k: usize| {
            let margin = margins[k].filter(|margin| margin.set.class == SingularClass::BranchCut);
            margin.is_some_and(|margin| margin.distance == 0.0)
        };
        let misaligned = truth.misaligned().filter(|places| places.iter().all(|k| is_at_half_a_turn(*k)));
        truth.opposite = misaligned.filter(|places| {
            let asked = Request::new(&[Output::RES], [true; 6], 0);
            let got = narrow.evaluate_on(&step.state, *after, &asked, &mut Tally::default()).residual;
            let here = truth.values(truth.at_rest());
            let parts = places.iter().filter_map(|k| Some(Wide::from_f64(got[*k]?) * here[*k]?));
            parts.fold(Wide::zero(), |sum, part| sum + part) < Wide::zero()
        });
        truth
    }

    /// The places of a rotation vector without history.
    pub fn misaligned(&self) -> Option<[usize; 3]> {
        let place =
            |i: usize| (0..6).find(|k| self.connector.differentiated(*k) == Some(Measure::Misalignment(i)));
        Some([place(1)?, place(2)?, place(3)?])
    }

    /// The values with a rotation vector of the opposite sheet, ρ − 2π ρ/|ρ|.
    fn on_the_opposite(&self, places: [usize; 3], mut values: Components<Wide>) -> Components<Wide> {
        let [Some(x), Some(y), Some(z)] = places.map(|k| values[k]) else { return values };
        let (direction, angle) = Wide::direction_and_norm([x, y, z]);
        let beyond = angle - Wide::integer(2) * Wide::pi();
        for (k, along) in places.into_iter().zip(direction) {
            values[k] = Some(along * beyond);
        }
        values
    }

    /// min(1, distance to the nearest singular set): 0 on one, where no two-sided derivative exists.
    pub const fn nearness(&self) -> f64 {
        self.nearness
    }

    /// The same of each component by itself.
    pub const fn nearness_of_components(&self) -> [f64; 6] {
        self.of_components
    }

    /// The components that are at a lock.
    pub const fn locked(&self) -> Locked {
        self.locked
    }

    /// The connector's own length.
    pub const fn length(&self) -> f64 {
        self.length
    }

    fn clear(&self) -> f64 {
        if self.nearness > 0.0 { self.nearness } else { 1.0 }
    }

    fn step(&self, j: usize, size: f64) -> Wide {
        Wide::from_f64(size * self.clear()) * Wide::from_f64(dof_size(j, self.length))
    }

    /// A step of so many sizes of a degree of freedom.
    pub fn sized(&self, j: usize, step: f64) -> Wide {
        Wide::from_f64(step) * Wide::from_f64(dof_size(j, self.length))
    }

    pub(crate) const fn connector(&self) -> &Connector<Wide> {
        &self.connector
    }

    pub(crate) const fn state(&self) -> &State<Wide> {
        &self.state
    }

    /// The places at h and −h along a degree of freedom with the values there, and 2h.
    fn around(&self, j: usize) -> (&Around, Wide) {
        let step = self.step(j, FIRST_STEP);
        let places = self.places[j].get_or_init(|| {
            [step, -step].map(|h| {
                let at = self.place(Self::along(j, h));
                let values = self.values(&at);
                (at, values)
            })
        });
        (places, step + step)
    }

    pub(crate) fn place(&self, by: NodalRow<Wide>) -> Displaced {
        self.place_of(by, moved(&self.state.pair, &by))
    }

    /// The same where the nodes that have moved so far are known. The branch is taken anew wherever the nodes have turned, however little: it
    /// holds principal angles, and the sign of half a torsion, which changes where no singular set is declared.
    fn place_of(&self, by: NodalRow<Wide>, pair: Pair<Wide>) -> Displaced {
        let has_turned = pair.a.triad != self.state.pair.a.triad || pair.b.triad != self.state.pair.b.triad;
        if !has_turned && !self.is_reversible() {
            return self.place_on(by, pair, self.at_rest().branch);
        }
        self.place_anew(by, pair)
    }

    /// The same, whatever has turned.
    pub(super) fn place_anew(&self, by: NodalRow<Wide>, pair: Pair<Wide>) -> Displaced {
        let state = State { pair, ..self.state };
        let branch = self.connector.advance(&state, &Increment::none(), &self.branch);
        Displaced { by, state, branch: self.on_the_sheet(&state, branch) }
    }

    /// The same where the branch is known too: nothing is decided by [`Truth::is_reversible`], and the nodes are turned as they are
    /// elsewhere.
    pub(super) const fn place_on(
        &self,
        by: NodalRow<Wide>,
        pair: Pair<Wide>,
        branch: Branch<Wide>,
    ) -> Displaced {
        Displaced { by, state: State { pair, ..self.state }, branch }
    }

    /// Whether the places of the nodes decide between opposites too.
    pub(super) fn is_reversible(&self) -> bool {
        self.reversible.iter().any(Option::is_some)
    }

    /// The components that depend on more than how the nodes are turned.
    pub(super) fn depends_on_places(&self) -> Mask {
        let of = |measure: Measure| {
            let Dependence { translation, flow, .. } = measure.dependence();
            translation || flow
        };
        [0, 1, 2, 3, 4, 5].map(|k| {
            let measures = [self.connector.differentiated(k), self.connector.position_measure(k)];
            measures.into_iter().flatten().any(of)
        })
    }

    /// The branch on which what is reversible has the signs that it has at the state itself. A jump to the opposite is no derivative; what
    /// lies on one sheet has one from each side.
    fn on_the_sheet(&self, state: &State<Wide>, branch: Branch<Wide>) -> Branch<Wide> {
        if !self.is_reversible() {
            return branch;
        }
        let there = positions(&self.connector, state, branch);
        let pairs = self.reversible.iter().zip(there).filter_map(|(still, moved)| Some(((*still)?, moved?)));
        let along = pairs.fold(Wide::zero(), |sum, (still, moved)| sum + still * moved);
        let mut kept = branch;
        if along < Wide::zero() {
            // The directions midway between a and b turn by half of each turn of torsion.
            kept.torsion.turns += Wide::integer(1);
        }
        kept
    }

    /// The degrees of freedom that the connector loads, those of the ground among them.
    pub fn reach(&self) -> impl Iterator<Item = usize> + use<> {
        let reach = *self.connector.reach();
        (0..DOFS).filter(move |j| reach[*j])
    }

    pub(super) fn evaluate(&self, at: &Displaced, request: &Request) -> Evaluation<Wide> {
        self.connector.evaluate_on(&at.state, at.branch, request, &mut Tally::default())
    }

    /// The value of a one-form from the end of the case on, along an increment.
    pub(super) fn accumulated(&self, by: &NodalRow<Wide>) -> Wide {
        self.accumulated_from(&self.state.pair, by)
    }

    /// The same from other places of the nodes on.
    pub(super) fn accumulated_from(&self, pair: &Pair<Wide>, by: &NodalRow<Wide>) -> Wide {
        let mut state = self.state;
        state.pair = moved(pair, by);
        let part = |at: usize| [by[at], by[at + 1], by[at + 2]];
        let increment = Increment {
            rotation: [part(node::THETA_A), part(node::THETA_B)],
            whole_turns: [[Wide::zero(); 3]; 2],
            flow: [by[node::PSI_A], by[node::PSI_B]],
        };
        let forms =
            [0, 1, 2, 3, 4, 5].map(|k| self.connector.position_measure(k).is_some_and(Measure::is_one_form));
        let after = self.connector.follow(&state, &increment, &self.branch, forms, &mut Tally::default());
        (after.accumulated - self.branch.accumulated)
            + (after.accumulated_rest - self.branch.accumulated_rest)
    }

    pub(crate) fn along(j: usize, h: Wide) -> NodalRow<Wide> {
        let mut by = [Wide::zero(); DOFS];
        by[j] = h;
        by
    }

    pub(crate) fn values(&self, at: &Displaced) -> Components<Wide> {
        self.values_of(at, [true; 6])
    }

    /// The same of some components.
    pub(super) fn values_of(&self, at: &Displaced, components: Mask) -> Components<Wide> {
        let asked = Request::new(&[Output::CU, Output::RES], components, 0);
        let evaluation = self.evaluate(at, &asked);
        let values = std::array::from_fn(|k| {
            if self.connector.differentiated(k)?.is_one_form() && components[k] {
                return Some(self.accumulated(&at.by));
            }
            evaluation.residual[k].or(evaluation.displacement[k])
        });
        self.opposite.map_or(values, |places| self.on_the_opposite(places, values))
    }

    /// Where the case ends, on rotations.
    pub fn at_rest(&self) -> &Displaced {
        self.still.get_or_init(|| self.place_anew([Wide::zero(); DOFS], self.state.pair))
    }

    /// Everything by dual numbers over 237 bits: the product's own source, without its rounding.
    pub fn dual(&self) -> Numbers<Wide> {
        let mut numbers = Numbers::of(&self.evaluate(self.at_rest(), &request()));
        numbers.set(Quantity::Value, self.value());
        crate::oracles::force::add_forces(&mut numbers, &self.connector, &self.state, &self.branch);
        numbers
    }

    /// Of the same values and their first and second derivatives alone: neither rates nor forces.
    pub fn dual_functions(&self) -> Numbers<Wide> {
        let asked = Request::new(&[Output::CU, Output::RES], [true; 6], 2);
        let mut numbers = Numbers::of(&self.evaluate(self.at_rest(), &asked));
        numbers.set(Quantity::Value, self.value());
        numbers
    }

    /// First and second derivatives of the traced formulas.
    pub fn symbolic(&self) -> Numbers<Wide> {
        crate::oracles::oracle::derivatives(&self.connector, &self.state.pair, &self.branch)
    }

    /// The values.
    pub fn value(&self) -> Entries<Wide> {
        let asked = Request::new(&[Output::CU, Output::RES], [true; 6], 0);
        let (connector, state) = &self.given;
        let branch = connector.advance(state, &Increment::none(), &self.branch);
        let still = connector.evaluate_on(state, branch, &asked, &mut Tally::default());
        Numbers::of(&still).entries(Quantity::Value).clone()
    }

    /// (f(q + h) − f(q − h))/2h for each degree of freedom that the connector has; zero for the others.
    pub fn first(&self) -> Entries<Wide> {
        self.differenced(self.empty(DOFS), self.active(), |_, values| *values)
    }

    /// The same of what is formed of the places and the values there.
    pub(super) fn differenced(
        &self,
        mut found: Components<Vec<Wide>>,
        columns: impl Iterator<Item = usize>,
        of: impl Fn(&Displaced, &Components<Wide>) -> Components<Wide>,
    ) -> Entries<Wide> {
        for j in columns {
            let (places, width) = self.around(j);
            let [plus, minus] = places.each_ref().map(|(at, values)| of(at, values));
            for (k, entries) in found.iter_mut().enumerate() {
                if let (Some(entries), Some(plus), Some(minus)) = (entries, plus[k], minus[k]) {
                    entries[j] = (plus - minus) / width;
                }
            }
        }
        Entries(found)
    }

    /// How far the nodes are from each other and from where they were, in lengths of the connector.
    pub(super) fn far(&self) -> f64 {
        let Pair { reference, a, b } = &self.state.pair;
        differences::far([reference, &a.displacement, &b.displacement], self.length)
    }

    /// How far differences are off by rounding on 237 bits: what is differenced over the step. Next to nothing but very close to singular
    /// sets, far from the origin, and where a tolerance is zero.
    pub fn own_error(&self, quantity: Quantity, bound: &Bound) -> Entries<f64> {
        let noise = NOISE * self.far().max(1.0);
        let speed = self.speed();
        let of = |k: usize, i: usize| {
            let scale = bound.scale(quantity, k, i);
            let value = bound.scale(Quantity::Value, k, 0);
            let [first, second] = self.times(k, speed);
            match quantity {
                Quantity::Value => noise * scale,
                Quantity::FirstDerivatives | Quantity::NodalForces => {
                    noise * scale / (FIRST_STEP * self.clear())
                }
                Quantity::SecondDerivatives | Quantity::GeometricStiffness => {
                    scale * differences::second_error(self.nearness, self.far())
                }
                Quantity::Rate => noise * value / first,
                Quantity::Acceleration => 4.0 * noise * value / second / second,
                _ => 0.0,
            }
        };
        let rows = |k: usize| (0..quantity.entries()).map(|i| of(k, i)).collect();
        Entries(std::array::from_fn(|k| Some(rows(k))))
    }

    /// The speed of the fastest degree of freedom, in its sizes.
    pub fn speed(&self) -> f64 {
        differences::speed(&self.state.velocity, &self.state.acceleration, |j| dof_size(j, self.length))
    }

    /// How far the degrees of freedom move in a time: q̇ t + q̈ t²/2.
    pub fn carried_on(&self, t: Wide) -> NodalRow<Wide> {
        differences::carried_on(&self.state.velocity, &self.state.acceleration, t)
    }

    /// The steps in time of first and second differences of a component: 1e-25 δ, and 1e-18 √δ.
    fn times(&self, k: usize, speed: f64) -> [f64; 2] {
        differences::times(self.of_components[k], speed)
    }

    /// Rate and acceleration: values at ±h along q(t) = q̇ t + q̈ t²/2, which turns the nodes by exp(q_θ(t)^), differenced. Each
    /// component has the step of its own singular sets: one that is too short for it loses the digits of an acceleration.
    pub fn rates(&self) -> [Entries<Wide>; 2] {
        let speed = self.speed();
        let at = |t: Wide| self.carried_on(t);
        let still = self.values(self.at_rest());
        let both = |h: Wide| [h, -h].map(|h| self.values(&self.place(at(h))));
        // The values after both steps, ahead and behind, by nearness.
        let mut moved: Vec<(f64, [Moved; 2])> = Vec::new();
        let mut rate: Components<Vec<Wide>> = self.empty(1);
        let mut acceleration: Components<Vec<Wide>> = self.empty(1);
        for k in 0..6 {
            if self.connector.differentiated(k).is_some_and(|m| m.has_nodal_rates()) {
                let [v, a] = self.resolved_in_b(k);
                rate[k] = Some(vec![v]);
                acceleration[k] = Some(vec![a]);
                continue;
            }
            let near = if self.of_components[k] > 0.0 { self.of_components[k] } else { 1.0 };
            let known = moved.iter().find(|(of, ..)| *of == near).copied();
            let (_, [(first_step, [near, behind]), (second_step, [far, far_behind])]) =
                known.unwrap_or_else(|| {
                    let after = |step: f64| {
                        let step = Wide::from_f64(step);
                        (step, both(step))
                    };
                    let found = (near, self.times(k, speed).map(after));
                    moved.push(found);
                    found
                });
            if let (Some(plus), Some(minus)) = (near[k], behind[k]) {
                rate[k] = Some(vec![(plus - minus) / (first_step + first_step)]);
            }
            if let (Some(plus), Some(minus), Some(middle)) = (far[k], far_behind[k], still[k]) {
                acceleration[k] = Some(vec![differences::acceleration([minus, middle, plus], second_step)]);
            }
        }
        [Entries(rate), Entries(acceleration)]
    }

    /// (v_b − v_a)·e_i^b, or (ω_b − ω_a)·e_i^b, and likewise the accelerations: rates that are declared so, not derivatives.
    pub(super) fn resolved_in_b(&self, k: usize) -> [Wide; 2] {
        let (at, i) = if k < 3 { (node::XA, k) } else { (node::THETA_A, k - 3) };
        let triad = &self.state.pair.b.triad;
        [&self.state.velocity, &self.state.acceleration].map(|rates| {
            (0..3).fold(Wide::zero(), |sum, j| sum + (rates[at + DOFS / 2 + j] - rates[at + j]) * triad[j][i])
        })
    }

    /// The values after the nodes have moved by `by`, in 237 bits.
    pub fn displaced(&self, by: &[f64; DOFS], factor: f64) -> Components<Wide> {
        let factor = Wide::from_f64(factor);
        self.values(&self.place(by.map(|x| Wide::from_f64(x) * factor)))
    }

    /// The degrees of freedom that the connector has.
    pub fn active(&self) -> impl Iterator<Item = usize> + use<> {
        let active = *self.connector.active();
        (0..DOFS).filter(move |j| active[*j])
    }

    pub(super) fn empty(&self, entries: usize) -> Components<Vec<Wide>> {
        std::array::from_fn(|k| self.connector.differentiated(k).map(|_| vec![Wide::zero(); entries]))
    }
}
