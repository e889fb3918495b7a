//! Who else can say what a number must be, and what each shares with the product.

use crate::case::quantity::{Entries, Numbers, Quantity};
use crate::case::{AtEnd, Case, moved};
use crate::judge::bound::{Bound, C};
use crate::judge::verdict::Wanted;
use crate::oracles::truth::Truth;
use pintle_kinematics::Differentiable;
use pintle_kinematics::connector::{Branch, Components, Connector, Increment, Output, Request, State, Tally};
use pintle_kinematics::measure::{LOCK, Margin, Unit};
use pintle_kinematics::node::{DOFS, Pair, dof_size};
use pintle_kinematics::scalar::{U, Wide};
use pintle_kinematics::vector::sub;
use pintle_symbolic::{Model, nodal_inputs};
use serde::{Deserialize, Serialize};
use std::convert::Infallible;

/// What an oracle shares with the product: an error in a shared part is invisible to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Shares {
    /// The source text of the kinematics: a wrong formula.
    pub kinematics: bool,
    /// The elementary functions on doubles: a wrong atan2, norm, log.
    pub elementary: bool,
    /// How derivatives come about: dual numbers and the maps to nodal degrees of freedom.
    pub mechanism: bool,
}

/// A source of reference numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Oracle {
    /// Central differences on 237-bit numbers.
    WideDifferences,
    /// The product's dual numbers over 237-bit numbers: tells rounding from a wrong derivative.
    WideDual,
    /// The remainder f(q + hv) − f(q) − h ∂f·v on 237-bit numbers, which must vanish like h².
    Taylor,
    /// Dual numbers in the fourteen nodal degrees of freedom: no relative pair, no nodal map.
    NodalDual,
    /// Second derivatives along two random directions by hyper-dual numbers in the nodal degrees of freedom.
    HyperDual,
    /// Dual numbers nested in dual numbers, in the nodal degrees of freedom: nothing of second order, no nodal map.
    NestedDual,
    /// Central differences on doubles with an estimate of their own error.
    Differences,
    /// Derivatives of the traced formulas, evaluated on 237-bit numbers: no dual numbers, no steps.
    WideSymbolic,
    /// The same on doubles.
    Symbolic,
    /// What JAX computed by formulas of its own in another language, at states of its own.
    Jax,
}

impl Oracle {
    /// Every oracle, the sharpest first.
    pub const ALL: [Self; 10] = [
        Self::WideDifferences,
        Self::WideSymbolic,
        Self::WideDual,
        Self::Taylor,
        Self::NodalDual,
        Self::HyperDual,
        Self::NestedDual,
        Self::Symbolic,
        Self::Differences,
        Self::Jax,
    ];

    /// The name, as the command line has it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::WideDifferences => "wide-differences",
            Self::WideDual => "wide-dual",
            Self::Taylor => "taylor",
            Self::NodalDual => "nodal-dual",
            Self::HyperDual => "hyper-dual",
            Self::NestedDual => "nested-dual",
            Self::Differences => "differences",
            Self::WideSymbolic => "wide-symbolic",
            Self::Symbolic => "symbolic",
            Self::Jax => "jax",
        }
    }

    /// One line on what it does.
    pub const fn meaning(self) -> &'static str {
        match self {
            Self::WideDifferences => {
                "central differences on 237-bit numbers, 45 digits for first derivatives"
            }
            Self::WideDual => {
                "the product's dual numbers over 237-bit numbers: rounding apart from derivative"
            }
            Self::Taylor => "order of the Taylor remainder along random directions, on 237-bit numbers",
            Self::NodalDual => "dual numbers in the nodal degrees of freedom, without the relative pair",
            Self::HyperDual => "hyper-dual numbers along random directions of the nodes",
            Self::NestedDual => "dual numbers in dual numbers, in the nodal degrees of freedom",
            Self::Differences => "central differences on doubles, with an estimate of their error",
            Self::WideSymbolic => "derivatives of the traced formulas, on 237-bit numbers",
            Self::Symbolic => "derivatives of the traced formulas, on doubles",
            Self::Jax => "formulas and differentiation of another language, at states of its own",
        }
    }

    /// What it has in common with the product.
    pub const fn shares(self) -> Shares {
        let (elementary, mechanism) = match self {
            Self::WideDifferences | Self::Taylor | Self::WideSymbolic => (false, false),
            Self::WideDual => (false, true),
            Self::NodalDual | Self::HyperDual | Self::NestedDual => (true, true),
            Self::Differences | Self::Symbolic => (true, false),
            Self::Jax => (false, false),
        };
        Shares { kinematics: !matches!(self, Self::Jax), elementary, mechanism }
    }

    /// Whether it works on 237-bit numbers, which takes a thousand times as long.
    pub const fn is_wide(self) -> bool {
        matches!(self, Self::WideDifferences | Self::WideSymbolic | Self::WideDual | Self::Taylor)
    }

    /// Whether its word alone decides on a derivative: another mechanism, and other elementary functions.
    pub const fn is_independent(self) -> bool {
        let shares = self.shares();
        !shares.mechanism && !shares.elementary
    }

    /// Whether it can answer for a quantity at any state, entry by entry.
    pub const fn answers(self, quantity: Quantity) -> bool {
        match self {
            Self::WideDifferences | Self::WideDual => true,
            Self::NodalDual | Self::Differences => matches!(quantity, Quantity::FirstDerivatives),
            Self::WideSymbolic | Self::Symbolic | Self::NestedDual => {
                matches!(quantity, Quantity::FirstDerivatives | Quantity::SecondDerivatives)
            }
            Self::Taylor | Self::HyperDual | Self::Jax => false,
        }
    }
}

/// What an oracle says: numbers, and how far they may be off by themselves.
#[derive(Clone, Debug)]
pub struct Answer {
    /// Who says it.
    pub oracle: Oracle,
    /// What the entries must be.
    pub numbers: Entries<Wanted>,
    /// The oracle's own error, entry by entry; none where it is far below any tolerance.
    pub error: Entries<f64>,
}

impl Answer {
    /// Doubles that are taken for exact.
    pub fn of(oracle: Oracle, numbers: &Entries<f64>) -> Self {
        Self { oracle, numbers: numbers.map(|_, _, x| Wanted::exactly(x)), error: Entries::default() }
    }

    /// Doubles as exact as the product's.
    pub fn rounded(oracle: Oracle, quantity: Quantity, numbers: &Entries<f64>, bound: &Bound) -> Self {
        let error = numbers.map(|k, i, _| bound.tolerance(quantity, k, i));
        Self { error, ..Self::of(oracle, numbers) }
    }

    /// The same of a straight-line program of traced formulas, which does not go around what cancels near singular sets: its own error is
    /// larger by the distance to them, and on one it has no answer.
    pub fn traced(quantity: Quantity, numbers: &Entries<f64>, bound: &Bound, nearness: &[f64; 6]) -> Self {
        let mut answer = Self::rounded(Oracle::Symbolic, quantity, numbers, bound);
        answer.error = answer.error.map(|k, _, error| error / nearness[k]);
        for k in (0..6).filter(|k| nearness[*k] == 0.0) {
            (answer.numbers.0[k], answer.error.0[k]) = (None, None);
        }
        answer
    }

    /// 45 digits or more, against a tolerance of 16.
    pub fn sharp(oracle: Oracle, numbers: &Entries<Wide>) -> Self {
        Self { oracle, numbers: numbers.map(|_, _, x| x.into()), error: Entries::default() }
    }

    /// The same with the error that differences on 237 bits have of their own.
    pub fn with_error_of(mut self, truth: &Truth, quantity: Quantity, bound: &Bound) -> Self {
        self.error = truth.own_error(quantity, bound);
        self
    }

    /// How far an entry may be from what it must be: the tolerance, and the oracle's own error.
    pub fn allowed(&self, bound: &Bound, quantity: Quantity, k: usize, i: usize) -> f64 {
        bound.tolerance(quantity, k, i) + self.error.get(k, i).unwrap_or(0.0)
    }
}

/// The wide oracles' numbers at one state, each computed once.
pub struct WideAnswers {
    /// By dual numbers.
    pub dual: Numbers<Wide>,
    /// By differences.
    pub differences: Numbers<Wide>,
    /// By derivatives of the traced formulas.
    pub symbolic: Numbers<Wide>,
}

impl WideAnswers {
    /// At the end of a case.
    pub fn of(truth: &Truth) -> Self {
        let mut answers = Self::with(truth, true);
        answers.differences.set(Quantity::NodalForces, truth.force_rows());
        answers
    }

    /// At the end of a case, without forces by differences.
    pub fn of_kinematics(truth: &Truth) -> Self {
        Self::with(truth, false)
    }

    fn with(truth: &Truth, forces: bool) -> Self {
        let mut differences = Numbers::default();
        differences.set(Quantity::Value, truth.value());
        differences.set(Quantity::FirstDerivatives, truth.first());
        let [second, changes] = truth.second(forces);
        differences.set(Quantity::SecondDerivatives, second);
        differences.set(Quantity::GeometricStiffness, changes);
        let [rate, acceleration] = truth.rates();
        differences.set(Quantity::Rate, rate);
        differences.set(Quantity::Acceleration, acceleration);
        Self { dual: truth.dual(), differences, symbolic: truth.symbolic() }
    }

    /// What the bound rests on: the differences of the components that are not on a singular set, where these are derivatives; of
    /// the others what dual numbers say.
    pub fn trusted(&self, is_smooth: &[bool; 6]) -> Numbers<f64> {
        let mut trusted = Numbers::default();
        for quantity in Quantity::ALL {
            let rows = std::array::from_fn(|k| {
                let from = if is_smooth[k] { &self.differences } else { &self.dual };
                from.entries(quantity).0[k].as_ref().map(|row| row.iter().map(|x| x.to_f64()).collect())
            });
            trusted.set(quantity, Entries(rows));
        }
        trusted
    }

    /// What one of them says of a quantity.
    pub fn answer(&self, oracle: Oracle, quantity: Quantity) -> Option<Answer> {
        let numbers = match oracle {
            Oracle::WideDifferences => &self.differences,
            Oracle::WideDual => &self.dual,
            Oracle::WideSymbolic => &self.symbolic,
            _ => return None,
        };
        Some(Answer::sharp(oracle, numbers.entries(quantity)))
    }
}

/// A case at its end, on doubles, for oracles that move its nodes.
pub struct Narrow {
    connector: Connector<f64>,
    state: State<f64>,
    branch: Branch<f64>,
    length: f64,
}

impl Narrow {
    /// The end of a case; `None` for an empty path.
    pub fn of(case: &Case) -> Option<Self> {
        Some(Self::at(&case.at_end()?))
    }

    /// The same where the end is at hand.
    pub fn at(end: &AtEnd<'_>) -> Self {
        // Only the difference of the displacements counts: far from the origin a step would be lost in either of them.
        let mut state = end.step.state;
        state.pair.b.displacement = sub(state.pair.b.displacement, state.pair.a.displacement);
        state.pair.a.displacement = [0.0; 3];
        Self { state, branch: end.after, length: end.case.length, connector: end.connector.clone() }
    }

    /// The values after the nodes moved by finite amounts from the end of the case.
    pub fn values(&self, by: &[f64; DOFS]) -> Components<f64> {
        let mut state = self.state;
        state.pair = moved(&self.state.pair, by);
        let asked = Request::new(&[Output::CU, Output::RES], [true; 6], 0);
        let mut tally = Tally::default();
        let evaluation =
            self.connector.evaluate(&state, &Increment::none(), &self.branch, &asked, &mut tally);
        std::array::from_fn(|k| evaluation.residual[k].or(evaluation.displacement[k]))
    }

    /// First derivatives by dual numbers in the nodal degrees of freedom. Their own error is a few roundings more than the
    /// product's: exp and the product of two rotations come on top.
    pub fn nodal_dual(&self, bound: &Bound) -> Answer {
        let rows = self.connector.nodal_rows(&self.state, &self.branch);
        let rows = Entries(rows.map(|row| row.map(|row| row.to_vec())));
        Answer::rounded(Oracle::NodalDual, Quantity::FirstDerivatives, &rows, bound)
    }

    /// First and second derivatives of the traced formulas. Their own error is that of a straight-line program: a few roundings
    /// of the same scale.
    pub fn symbolic(&self) -> Numbers<f64> {
        derivatives(&self.connector, &self.state.pair, &self.branch)
    }

    /// First and second derivatives by nested dual numbers in the nodal degrees of freedom. Their own error is as that of
    /// [`Narrow::nodal_dual`].
    pub fn nested_dual(&self) -> Numbers<f64> {
        let (mut first, mut second) = (Entries::default(), Entries::default());
        for (k, found) in self.connector.nested(&self.state, &self.branch).into_iter().enumerate() {
            let Some((row, matrix)) = found else { continue };
            first.0[k] = Some(row.to_vec());
            second.0[k] = Some(matrix.as_flattened().to_vec());
        }
        let mut numbers = Numbers::default();
        numbers.set(Quantity::FirstDerivatives, first);
        numbers.set(Quantity::SecondDerivatives, second);
        numbers
    }

    /// First derivatives by central differences on doubles: the best of a ladder of steps, none of which leads over a singular
    /// set.
    pub fn differences(&self, bound: &Bound) -> Answer {
        // A component on its singular set has no step.
        let nearness = self.nearness_of_components();
        let near = nearness.into_iter().filter(|near| *near > 0.0).fold(1.0, f64::min);
        let has_function = |k: usize| {
            nearness[k] > 0.0 && self.connector.differentiated(k).is_some_and(|m| !m.is_one_form())
        };
        let size = |j: usize| dof_size(j, self.length) * near;
        let components = std::array::from_fn(has_function);
        let values = |all: &[[f64; DOFS]]| Ok(all.iter().map(|by| self.values(by)).collect());
        let Ok(answer) =
            central_differences::<Infallible>(values, components, &size, self.connector.active(), bound);
        answer
    }

    /// Σ_jk v_j w_k ∂²f/∂q_j∂q_k of every component, by hyper-dual numbers in the nodal degrees of freedom.
    pub fn hyper_dual(&self, v: &[f64; DOFS], w: &[f64; DOFS]) -> Components<f64> {
        self.connector.nodal_second(&self.state, &self.branch, v, w)
    }

    /// Whether the angles of each component are so close to a lock that rounding decides them.
    pub(super) fn locks(&self) -> [bool; 6] {
        crate::oracles::truth::locks(&self.connector, &self.state.pair)
    }

    /// min(1, distance to the nearest singular set, in radians and lengths of the connector).
    pub fn nearness(&self) -> f64 {
        self.nearness_of_components().into_iter().fold(1.0, f64::min)
    }

    /// The same of each component by itself; 1 where it has no singular set.
    pub fn nearness_of_components(&self) -> [f64; 6] {
        self.margins().map(|margin| nearness(margin, self.length))
    }

    /// The distance of each component to its singular sets.
    pub fn margins(&self) -> Components<Margin> {
        self.connector.margins(&self.state, &self.branch, [true; 6])
    }

    /// The nodal degrees of freedom that the connector has.
    pub fn active(&self) -> &[bool; DOFS] {
        self.connector.active()
    }
}

/// min(1, distance to a singular set, in radians and lengths of the connector); 1 where there is none. An angle, or a radius, that only rounding holds
/// off a set is on it.
pub fn nearness(margin: Option<Margin>, length: f64) -> f64 {
    let Some(Margin { distance, set }) = margin else { return 1.0 };
    match set.unit {
        Unit::Length => (distance / length).min(1.0),
        Unit::Angle | Unit::None if distance < LOCK => 0.0,
        Unit::Angle | Unit::None => distance.min(1.0),
    }
}

/// The derivatives of a connector's traced formulas at a state; none where a formula cannot be traced.
pub(super) fn derivatives<R: Differentiable<Mask = bool>>(
    connector: &Connector<R>,
    pair: &Pair<R>,
    branch: &Branch<R>,
) -> Numbers<R> {
    let mut found = Numbers::default();
    let Some(model) = Model::shared(connector.connection()) else { return found };
    let inputs = nodal_inputs(pair, connector.section(), &branch.history());
    let (mut first, mut second) = (Entries::default(), Entries::default());
    for (function, derivatives) in model.functions.iter().zip(model.evaluate(&inputs)) {
        let k = function.component;
        if connector.differentiated(k) != Some(function.measure) {
            continue;
        }
        let active = |i: usize| connector.active()[i % DOFS] && connector.active()[i / DOFS % DOFS];
        let masked = |i: usize, x: R| if active(i) { x } else { R::ZERO };
        let row = derivatives.first.into_iter().enumerate();
        first.0[k] = Some(row.map(|(i, x)| masked(i * DOFS + i, x)).collect());
        let matrix = derivatives.second.into_iter().enumerate();
        second.0[k] = Some(matrix.map(|(i, x)| masked(i, x)).collect());
    }
    found.set(Quantity::FirstDerivatives, first);
    found.set(Quantity::SecondDerivatives, second);
    found
}

/// Central differences of a function of the nodal degrees of freedom on doubles: the best of a ladder of steps h·`size`(j), the
/// error estimated from its neighbours and from the rounding of the values. The function is asked for all places at once.
///
/// # Errors
/// Those of the function.
pub fn central_differences<E>(
    values: impl FnOnce(&[[f64; DOFS]]) -> Result<Vec<Components<f64>>, E>,
    components: [bool; 6],
    size: &dyn Fn(usize) -> f64,
    active: &[bool; DOFS],
    bound: &Bound,
) -> Result<Answer, E> {
    const LADDER: [f64; 4] = [1e-3, 1e-4, 1e-5, 1e-6];
    let mut places = Vec::new();
    for j in (0..DOFS).filter(|j| active[*j]) {
        for h in LADDER {
            for sign in [1.0, -1.0] {
                let mut by = [0.0; DOFS];
                by[j] = sign * h * size(j);
                places.push(by);
            }
        }
    }
    let mut values = values(&places)?.into_iter();
    let mut numbers: Components<Vec<Wanted>> =
        components.map(|is| is.then(|| vec![Wanted::exactly(0.0); DOFS]));
    let mut errors: Components<Vec<f64>> = components.map(|is| is.then(|| vec![0.0; DOFS]));
    for j in (0..DOFS).filter(|j| active[*j]) {
        let estimates = LADDER.map(|h| {
            let mut next = || values.next().unwrap_or([None; 6]);
            let (plus, minus) = (next(), next());
            std::array::from_fn::<_, 6, _>(|k| Some((plus[k]? - minus[k]?) / (2.0 * h * size(j))))
        });
        for k in 0..6 {
            let (Some(numbers), Some(errors)) = (&mut numbers[k], &mut errors[k]) else { continue };
            let scale =
                bound.scale(Quantity::Value, k, 0) + bound.scale(Quantity::FirstDerivatives, k, j) * size(j);
            let mut best = (f64::NAN, f64::INFINITY);
            for (i, pair) in estimates.windows(2).enumerate() {
                let (Some(coarse), Some(fine)) = (pair[0][k], pair[1][k]) else { continue };
                // The finer truncates a hundredth of what the coarser does; what is left of the difference is rounding.
                let rounding = 16.0 * U * scale / (LADDER[i + 1] * size(j));
                let error = (coarse - fine).abs() + rounding;
                if error < best.1 {
                    best = (fine, error);
                }
            }
            numbers[j] = Wanted::exactly(best.0);
            errors[j] = best.1;
        }
    }
    Ok(Answer { oracle: Oracle::Differences, numbers: Entries(numbers), error: Entries(errors) })
}

/// The order at which the remainder f(q + hv) − f(q) − h ∂f·v vanishes, for a row that is to be judged.
///
/// It must be 2 or more. The remainder over h may be the sum of:
/// - what rounding of the row allows;
/// - h times the sum of the magnitudes of the second derivatives along v;
/// - what all higher derivatives make of it, by Cauchy's estimate on a ball that reaches halfway to the singular set, δ away.
///
/// That estimate is `(n−1)! G (2/δ)^(n−1)` along v, G being the size of the first derivatives there: `4/3 (h/δ)² G` of the third.
/// Near a singular set, at a symmetric state, second derivatives along v may vanish while the third do not. What is larger at some
/// step falls more slowly than that, or jumps between two steps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Remainder {
    /// The component (0-based).
    pub component: usize,
    /// The estimated order, from the two finest steps that stand clear of the noise, or from the step at which the remainder is too
    /// large and the one before. It is `None` where the remainder is below the noise throughout, as for a linear function.
    pub order: Option<f64>,
    /// The remainder over h at the finest step, which is the error of ∂f·v: what it must be less what it is.
    pub off: f64,
    /// What rounding of the row alone allows it to be.
    pub allowed: f64,
    /// The remainder over h at the step where it is largest in units of what is allowed there, and what that is.
    pub largest: [f64; 2],
}

impl Remainder {
    /// How large it is at the worst step in units of what is allowed there; infinite where it is not a number.
    pub fn units(&self) -> f64 {
        let [found, allowed] = self.largest;
        let units = if found == 0.0 { 0.0 } else { found / allowed };
        if units.is_nan() { f64::INFINITY } else { units }
    }

    /// In words.
    pub fn told(&self) -> String {
        self.order.map_or("linear to rounding".into(), |order| format!("order {order:.2}"))
    }
}

/// From the values of a component after steps along a direction: `over_h` is the remainder over the step at each.
///
/// `allowed` is what rounding of the row makes of it, C u times its conditioned scale, in which the second derivatives along the
/// direction are contained, and `nearness` is δ.
pub fn remainder_of(component: usize, over_h: &[(f64, f64)], allowed: f64, nearness: f64) -> Remainder {
    /// Above ½ of the second derivatives, and above 4/3 of the higher ones, to leave room for what bends them between two steps and how
    /// they grow on the way to the singular set.
    const ROOM: f64 = 10.0;
    let smooth = |h: f64| allowed + ROOM * (h + (h / nearness).powi(2)) * (allowed / (C * U));
    let units = |&(h, r): &(f64, f64)| if r == 0.0 { 0.0 } else { r.abs() / smooth(h) };
    let exceeds = |x: f64, y: f64| x > y || x.is_nan();
    let mut worst = 0;
    for (n, found) in over_h.iter().enumerate() {
        let most = over_h.get(worst).map_or(0.0, units);
        if exceeds(units(found), most) {
            worst = n;
        }
    }
    // The order, from steps whose remainder stands clear of what rounding of the row allows.
    let is_clear = |n: &usize| over_h.get(*n).is_some_and(|(_, r)| r.abs() > 10.0 * allowed);
    let between = |from: usize, to: usize| {
        let [(h, r), (finer, rest)] = [*over_h.get(from)?, *over_h.get(to)?];
        Some(1.0 + (r.abs().ln() - rest.abs().ln()) / (h.ln() - finer.ln()))
    };
    let clear: Vec<usize> = (0..over_h.len()).filter(is_clear).collect();
    let is_too_large = over_h.get(worst).is_some_and(|found| units(found) > 1.0);
    let order = match clear.as_slice() {
        _ if is_too_large && is_clear(&worst) => between(worst.saturating_sub(1), worst.max(1)),
        [.., from, to] => between(*from, *to),
        _ => None,
    };
    let off = over_h.last().map_or(f64::NAN, |(_, r)| *r);
    let largest = over_h.get(worst).map_or([f64::NAN; 2], |(h, r)| [r.abs(), smooth(*h)]);
    Remainder { component, order, off, allowed, largest }
}

/// Taylor's test of a row: 237-bit values along a direction v, on a ladder of steps. Where the row is right the remainder over
/// h falls like h until the rounding of the row itself shows, which is the error reported; that it falls so is judged at every step. A component on a singular set, of
/// `nearness` 0, has no row to be tested.
pub fn remainders(
    truth: &Truth,
    rows: &Entries<f64>,
    bound: &Bound,
    v: &[f64; DOFS],
    nearness: &[f64; 6],
) -> Vec<Remainder> {
    const LADDER: [f64; 5] = [1e-4, 1e-8, 1e-12, 1e-16, 1e-20];
    let still = truth.displaced(&[0.0; DOFS], 0.0);
    let near = nearness.iter().copied().filter(|near| *near > 0.0).fold(1.0, f64::min);
    let steps = LADDER.map(|h| h * near);
    let moved = steps.map(|h| truth.displaced(v, h));
    let mut found = Vec::new();
    for k in (0..6).filter(|k| nearness[*k] > 0.0) {
        let (Some(row), Some(still)) = (&rows.0[k], still[k]) else { continue };
        let slope = row
            .iter()
            .zip(v)
            .fold(Wide::from_f64(0.0), |sum, (r, v)| sum + Wide::from_f64(*r) * Wide::from_f64(*v));
        let allowed: f64 =
            (0..DOFS).map(|j| bound.tolerance(Quantity::FirstDerivatives, k, j) * v[j].abs()).sum();
        let over_h: Vec<(f64, f64)> = steps
            .iter()
            .zip(&moved)
            .filter_map(|(h, moved)| {
                Some((*h, (((moved[k]? - still) / Wide::from_f64(*h)) - slope).to_f64()))
            })
            .collect();
        found.push(remainder_of(k, &over_h, allowed, nearness[k]));
    }
    found
}
