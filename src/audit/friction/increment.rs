//! What an increment does: forces that satisfy the equations of stick and slip, and their slopes.
//!
//! The equations are typed here a second time: `f_k = f_tr,k − K_k Δγ ∂P/∂f_k` and `P(f) = L(Δγ)`. Newton's method solves them on
//! 237 bits from the product's solution on, with differences for all derivatives. Of the product they share P, F_N and L.

use crate::case::failing::FrictionCase;
use crate::case::quantity::Quantity;
use crate::friction::solve::{STEPS, Unsolved, is_converged, linear, root};
use crate::friction::{Judged, force_sizes, group_sizes, kind, reach};
use crate::judge::bound::C;
use crate::judge::slopes::{Argument, Held, Output, Slopes};
use crate::judge::table::{Entry, ResultTable};
use crate::mutants::mutant::{Mistake, Mutant};
use crate::oracles::differences::FIRST_STEP;
use crate::oracles::oracle::Oracle;
use crate::settings::Settings;
use pintle_kinematics::catalog::{COMPONENT, FORCE};
use pintle_kinematics::scalar::elementary::sqrt;
use pintle_kinematics::scalar::{Real, Scalar, U, Wide};
use pintle_model::behavior::friction::{
    Branch, Context, Flag, Friction, FrictionOutcome, Input, Partial, State, Status, StickStiffness, Tangent,
    Tangential,
};

/// Six forces, Δγ, F_N, the limit.
const RESULTS: usize = 9;
/// Six Δu, six forces that press, Δt.
const INPUTS: usize = 13;

/// The state of a friction on another real number, exactly.
pub(super) fn exact_state<R: Real>(state: &State<f64>) -> State<R> {
    State {
        force: state.force.map(R::from_f64),
        accumulated_slip: R::from_f64(state.accumulated_slip),
        stick_stiffness: state.stick_stiffness.map(R::from_f64),
    }
}

/// The branch on which an increment is differentiated on 237 bits: the one that its criterion tells, unless rounding decides.
pub(super) fn branch_of(outcome: &FrictionOutcome<f64>) -> Branch {
    if outcome.flags.contains(&Flag::Threshold) { forced(outcome) } else { Branch::Decided }
}

/// The branch that was taken, for steps that may lead over the threshold.
pub(super) const fn forced(outcome: &FrictionOutcome<f64>) -> Branch {
    match outcome.status {
        Status::Stick => Branch::Stick,
        Status::Slip => Branch::Slip,
        Status::Free => Branch::Decided,
    }
}

pub(super) fn results<R: Copy>(outcome: &FrictionOutcome<R>) -> [R; RESULTS] {
    let [f1, f2, f3, m1, m2, m3] = outcome.force;
    [f1, f2, f3, m1, m2, m3, outcome.slip_increment, outcome.normal, outcome.limit]
}

pub(super) fn partials<R: Copy>(tangent: &Tangent<R>) -> Vec<Vec<R>> {
    let flat = |of: &Partial<R>| {
        of.displacement.iter().chain(&of.forces).chain([&of.duration]).copied().collect::<Vec<_>>()
    };
    let rest = [&tangent.slip_increment, &tangent.normal, &tangent.limit];
    tangent.force.iter().chain(rest).map(flat).collect()
}

/// CSF1 … CSM3.
pub(super) fn output(k: usize) -> String {
    format!("CS{}", FORCE[k].to_uppercase())
}

/// The names of what has slopes, in the order of [`results`].
pub(super) fn result_name(k: usize) -> &'static str {
    match k {
        0..6 => FORCE[k],
        6 => "Δγ",
        7 => "F_N",
        _ => "limit",
    }
}

/// The names of what slopes are by.
pub(super) fn input_names() -> Vec<String> {
    let inputs = COMPONENT.iter().map(|name| format!("Δ{name}"));
    inputs.chain(FORCE.map(String::from)).chain(["Δt".to_string()]).collect()
}

impl FrictionCase {
    pub(crate) fn input<R: Real>(&self, j: usize, h: R) -> Input<'_, R> {
        let all = |x: [f64; 6]| x.map(R::from_f64);
        let mut input = Input {
            displacement: all(self.displacement),
            forces: all(self.forces),
            duration: self.duration.map(R::from_f64),
            context: self.context(),
        };
        match j {
            // A displacement moves its position and motion too.
            0..6 => {
                for of in [&mut input.displacement, &mut input.context.position, &mut input.context.motion] {
                    of[j] = of[j] + h;
                }
            }
            6..12 => input.forces[j - 6] = input.forces[j - 6] + h,
            _ => input.duration = input.duration.map(|duration| duration + h),
        }
        input
    }

    /// Sizes of the inputs of an increment: Δu in slips that reach the limit, forces, Δt.
    fn input_sizes(&self, outcome: &FrictionOutcome<f64>) -> [f64; INPUTS] {
        /// An increment that has no size of its own: a part of the connector's length, or of a radian.
        const LEAST: f64 = 1e-9;
        let presses = self.friction.criterion.pressing_components();
        let forces = group_sizes(&self.forces, presses, self.length);
        let slip = outcome.stick_stiffness.map_or(0.0, |stiffness| (outcome.limit / stiffness).abs());
        std::array::from_fn(|j| match j {
            0..6 => {
                let unit = if j < 3 { self.length } else { 1.0 };
                let size = self.displacement[j].abs() + slip;
                if size.is_finite() { size.max(LEAST * unit) } else { unit }
            }
            6..12 => forces[j - 6],
            _ => self.duration.unwrap_or(1.0),
        })
    }

    /// How the limit changes with slip, about: for the scale of rounding.
    fn limit_slope(&self, outcome: &FrictionOutcome<f64>) -> f64 {
        const STEP: f64 = 1e-6;
        let slip = outcome.slip_increment;
        let limit = |slip: f64| self.friction.limit_after(&self.before, &self.input(0, 0.0), slip)[1];
        if slip > 0.0 { (limit(slip * (1.0 + STEP)) - limit(slip)) / (slip * STEP) } else { 0.0 }
    }

    /// The magnitudes of what results are formed from: themselves, and of forces and slip the shift of a potential.
    fn magnitudes(&self, outcome: &FrictionOutcome<f64>) -> Vec<f64> {
        let shift = self.shift();
        let mut found = results(outcome).map(f64::abs);
        for (k, radius) in self.friction.radii() {
            found[k] += shift * radius;
        }
        let flexibility = outcome.stick_stiffness.map_or(0.0, |stiffness| stiffness.recip());
        if shift > 0.0 && flexibility.is_finite() {
            found[6] += shift * flexibility;
            found[8] += self.limit_slope(outcome).abs() * shift * flexibility;
        }
        found.to_vec()
    }

    /// The tractions at the end are formed beside the shift of a potential, and rounded as it is: as if each displacement were rounded by
    /// what makes a traction as large as that. Of a slip that returns from P to a limit L, displacements move the tractions by L/P of
    /// what stick would make of them.
    fn beside(&self, outcome: &FrictionOutcome<f64>) -> Vec<f64> {
        let mut found = vec![0.0; INPUTS];
        let (shift, Some(stiffness)) = (self.shift(), outcome.stick_stiffness) else { return found };
        let radii = self.friction.radii();
        let mut trial = self.before.force;
        for (k, radius) in &radii {
            trial[*k] += stiffness * radius * radius * self.displacement[*k];
        }
        let tangential = self.friction.criterion.at(&trial, 0.0, None, &self.context()).0.tangential;
        let returned =
            if outcome.status == Status::Slip { (tangential / outcome.limit).max(1.0) } else { 1.0 };
        for (k, radius) in radii {
            let slip = shift * returned / (stiffness * radius);
            found[k] = if slip.is_finite() { slip } else { 0.0 };
        }
        found
    }

    pub(super) fn increment_tables(&self, settings: &Settings, wide: bool) -> Vec<Judged> {
        let friction = &self.friction;
        let still = self.input(0, 0.0);
        let (outcome, tangent) = friction.tangent(&self.before, &still, Branch::Decided);
        let on = branch_of(&outcome);
        let steady = forced(&outcome);
        let before: State<Wide> = exact_state(&self.before);
        let sizes = self.input_sizes(&outcome);
        let mut reaches = sizes;
        reaches[6..12].copy_from_slice(&reach(&self.forces, &sizes[6..12]));
        let mut got = partials(&tangent);
        settings.planted.into_iter().for_each(|planted| planted.spoil_friction(&mut got));
        let inputs = input_names();
        let update = |j: usize, h: Wide| friction.update(&before, &self.input(j, h), on);
        let (magnitudes, beside) = (self.magnitudes(&outcome), self.beside(&outcome));
        let slopes = Slopes {
            quantity: Quantity::FrictionTangent,
            // The forces share what they are returned from: each is as uncertain as the largest of its kind.
            outputs: Output::list(
                (0..RESULTS).map(|i| (format!("{}{}", result_name(i), self.title), magnitudes[i], kind(i))),
            ),
            inputs: Argument::list(&inputs, &sizes, &reaches, |j| beside[j]),
            matrices: None,
            demanded: Vec::new(),
            class: &|i, j| (kind(i), j / 3, 0),
            got,
            step: FIRST_STEP,
            wide: Box::new(|j, h| results(&update(j, h)).to_vec()),
            narrow: Box::new(|j, h| {
                results(&friction.update(&self.before, &self.input(j, h), steady)).to_vec()
            }),
            slopes: Box::new(|j, h| partials(&friction.tangent(&self.before, &self.input(j, h), steady).1)),
            dual: Box::new(|| partials(&friction.tangent(&before, &self.input(0, Wide::zero()), on).1)),
            mistaken: self.mistaken(&outcome),
            held: Some(Held { known: Box::new(|_, j| (6..12).contains(&j).then_some(0.0)), wide: None }),
        };
        let scales = slopes.value_scales();
        let mut tables = slopes.tables(settings, wide);
        if wide {
            tables.extend(self.force_tables(settings, &outcome, on, &scales));
        }
        tables
    }

    /// A number that the increment leads to, by the name that it has beside JAX's or beside those on 237 bits; whether or not these have an
    /// answer.
    pub(crate) fn result(&self, name: &str) -> Option<f64> {
        let name = name.strip_suffix(self.title.as_str())?;
        let (outcome, _) = self.friction.tangent(&self.before, &self.input(0, 0.0), Branch::Decided);
        match name {
            "Δγ" => Some(outcome.slip_increment),
            "F_N" | "CNF" => Some(outcome.normal),
            "limit" => Some(outcome.limit),
            "CASU" => Some(outcome.accumulated_slip),
            _ => {
                let k = (0..FORCE.len()).find(|k| name == FORCE[*k] || name == output(*k))?;
                outcome.force.get(k).copied()
            }
        }
    }

    /// The same numbers with mistakes in them.
    fn mistaken(&self, outcome: &FrictionOutcome<f64>) -> Vec<(Mistake, Vec<Vec<f64>>)> {
        let (friction, input) = (&self.friction, &self.input(0, 0.0));
        let other = if outcome.status == Status::Slip { Branch::Stick } else { Branch::Slip };
        let mut found = vec![
            (Mistake::StickForSlip, partials_of(friction, &self.before, input, other)),
            (Mistake::SecantForTangent, self.secants(outcome)),
        ];
        for (mistake, criterion) in friction.criterion.factor_mistakes() {
            let wrong = Friction { criterion, ..friction.clone() };
            found.push((Mistake::from(mistake), partials_of(&wrong, &self.before, input, Branch::Decided)));
        }
        found
    }

    /// The slopes where each displacement is taken back as a whole, and what that changes divided by it; those by what presses as they are.
    fn secants(&self, outcome: &FrictionOutcome<f64>) -> Vec<Vec<f64>> {
        let after = results(outcome);
        let mut found = partials_of(&self.friction, &self.before, &self.input(0, 0.0), Branch::Decided);
        for (j, by) in self.displacement.iter().enumerate() {
            let before = self.friction.update(&self.before, &self.input(j, -by), Branch::Decided);
            for ((row, after), before) in found.iter_mut().zip(after).zip(results(&before)) {
                let secant = (after - before) / by;
                if let Some(slope) = row.get_mut(j).filter(|_| secant.is_finite()) {
                    *slope = secant;
                }
            }
        }
        found
    }

    /// CSF, Δγ, CNF, the limit and CASU.
    fn force_tables(
        &self,
        settings: &Settings,
        outcome: &FrictionOutcome<f64>,
        on: Branch,
        scales: &[f64],
    ) -> Vec<Judged> {
        let before: State<Wide> = exact_state(&self.before);
        let input = self.input(0, Wide::zero());
        let on_wide = self.friction.update(&before, &input, on);
        let sliding = self.friction.criterion.tangential.components();
        let listed = |outcome: &FrictionOutcome<f64>| {
            let mut all: Vec<f64> = sliding.iter().map(|k| outcome.force[*k]).collect();
            all.extend([outcome.slip_increment, outcome.normal, outcome.limit, outcome.accumulated_slip]);
            all
        };
        let mut names: Vec<String> = sliding.iter().map(|k| output(*k)).collect();
        names.extend(["Δγ", "CNF", "limit", "CASU"].map(String::from));
        let got = listed(outcome);
        let mut allowed: Vec<f64> = sliding.iter().map(|k| scales[*k]).collect();
        allowed.extend([scales[6], scales[7], scales[8], scales[6] + outcome.accumulated_slip.abs()]);
        let branch = if outcome.status == Status::Slip { Branch::Stick } else { Branch::Slip };
        let other = listed(&self.friction.update(&self.before, &self.input(0, 0.0), branch));
        let tolerances =
            Allowed { forces: std::array::from_fn(|k| C * U * scales[k]), slip: C * U * scales[6] };
        let solved = || Equations::new(self, &before, &input, outcome).solved(on, &tolerances);
        let of_wide = |force: [Wide; 6], [slip, normal, limit]: [Wide; 3]| {
            let mut all: Vec<Wide> = sliding.iter().map(|k| force[*k]).collect();
            all.extend([slip, normal, limit, before.accumulated_slip + slip]);
            all
        };
        let mut tables = Vec::new();
        for oracle in [Oracle::WideDifferences, Oracle::WideDual] {
            if !settings.oracles.contains(&oracle) {
                continue;
            }
            if let Some(why) = Unsolved::of(&outcome.flags) {
                tables.push((oracle, ResultTable::unanswered(Quantity::FrictionForce, why.reason())));
                continue;
            }
            let want = if oracle == Oracle::WideDual {
                let FrictionOutcome { slip_increment, normal, limit, .. } = on_wide;
                of_wide(on_wide.force, [slip_increment, normal, limit])
            } else {
                match solved() {
                    Ok((force, rest)) => of_wide(force, rest),
                    Err(why) => {
                        tables.push((oracle, ResultTable::unanswered(Quantity::FrictionForce, why.reason())));
                        continue;
                    }
                }
            };
            let label = |i: usize| format!("{}{}", names[i], self.title);
            // Forces and moments, slips, what presses.
            let unit = |i: usize| sliding.get(i).map_or_else(|| 2 + i - sliding.len(), |k| k / 3);
            let entry = |i: usize| Entry::new(label(i), got[i], want[i], allowed[i], (unit(i), 0, 0));
            let mut table = ResultTable::new(Quantity::FrictionForce);
            table.rows = (0..got.len()).map(label).collect();
            table.entries = (0..got.len()).map(entry).collect();
            let changes = other.iter().enumerate().map(|(i, x)| (i, 0, *x));
            table.mistakes = vec![Mutant::many(Mistake::StickForSlip, changes)];
            tables.push((oracle, table));
        }
        tables
    }
}

fn partials_of(
    friction: &Friction,
    before: &State<f64>,
    input: &Input<'_, f64>,
    on: Branch,
) -> Vec<Vec<f64>> {
    partials(&friction.tangent(before, input, on).1)
}

/// The equations of stick and slip on 237 bits.
struct Equations<'a> {
    case: &'a FrictionCase,
    before: &'a State<Wide>,
    input: &'a Input<'a, Wide>,
    outcome: &'a FrictionOutcome<f64>,
    /// K_k of the sliding components.
    stiffness: Vec<(usize, Wide)>,
    /// K_s.
    of_slip: Option<Wide>,
    trial: [Wide; 6],
    sizes: [f64; 6],
}

impl<'a> Equations<'a> {
    fn new(
        case: &'a FrictionCase,
        before: &'a State<Wide>,
        input: &'a Input<'a, Wide>,
        outcome: &'a FrictionOutcome<f64>,
    ) -> Self {
        let friction = &case.friction;
        let [_, at_rest] = friction.limit_after(before, input, Wide::zero());
        let of_slip = match (friction.stick_stiffness, before.stick_stiffness) {
            (StickStiffness::Given(stiffness), _) => Some(Wide::from_f64(stiffness)),
            (StickStiffness::ElasticSlip(_), Some(kept)) => Some(kept),
            (StickStiffness::ElasticSlip(slip), None) if at_rest > Wide::zero() => {
                Some(at_rest / Wide::from_f64(slip))
            }
            (StickStiffness::ElasticSlip(_), None) => None,
        };
        let squares = friction.radii().into_iter().map(|(k, radius)| {
            let radius = Wide::from_f64(radius);
            (k, of_slip.unwrap_or_else(Wide::zero) * radius * radius)
        });
        let stiffness: Vec<(usize, Wide)> = squares.collect();
        let mut trial = [Wide::zero(); 6];
        for (k, stiffness) in &stiffness {
            trial[*k] = before.force[*k] + *stiffness * input.displacement[*k];
        }
        // Of the solution: what is returned from may be larger by many decades, and steps of its size lead over a force that is not zero.
        let tractions = if outcome.force == [0.0; 6] { trial.map(|x| x.to_f64()) } else { outcome.force };
        let sizes = reach(&tractions, &force_sizes(&tractions, case.length));
        let sizes = std::array::from_fn(|k| sizes[k]);
        Self { case, before, input, outcome, stiffness, of_slip, trial, sizes }
    }

    /// P after some slip: its scale factors may move with what surrounds it.
    fn potential(&self, force: &[Wide; 6], slip: Wide) -> Wide {
        let accumulated_slip = self.before.accumulated_slip + slip;
        let context = Context { accumulated_slip, ..self.input.context.clone() };
        self.case.friction.criterion.at(force, Wide::zero(), None, &context).0.tangential
    }

    fn limit(&self, slip: Wide) -> [Wide; 2] {
        self.case.friction.limit_after(self.before, self.input, slip)
    }

    /// Forces, and Δγ, F_N and the limit; or why an increment has no such solution.
    fn solved(&self, on: Branch, allowed: &Allowed) -> Result<([Wide; 6], [Wide; 3]), Unsolved> {
        let zero = Wide::zero();
        let end = |(force, slip): ([Wide; 6], Wide)| {
            let [normal, limit] = self.limit(slip);
            (force, [slip, normal, limit])
        };
        if let Some(why) = Unsolved::of(&self.outcome.flags) {
            return Err(why);
        }
        let [_, at_rest] = self.limit(zero);
        if on != Branch::Stick && at_rest <= zero {
            return Ok(end(([zero; 6], self.freed())));
        }
        let magnitude = self.potential(&self.trial, zero);
        let slips = match on {
            Branch::Stick => false,
            Branch::Slip => true,
            Branch::Decided => magnitude > at_rest,
        };
        let found = if !slips {
            (self.trial, zero)
        } else if self.outcome.flags.contains(&Flag::ReturnedAlongTraction) {
            self.along_traction(magnitude, allowed)?
        } else {
            self.against_gradient(allowed)?
        };
        Ok(end(found))
    }

    /// Δγ where nothing holds: all of the motion, and what stick had stored, f_n,k/K_k, is slip; R_k measures a rotation.
    fn freed(&self) -> Wide {
        let radii = self.case.friction.radii();
        let part = |((k, stiffness), (_, radius)): (&(usize, Wide), &(usize, f64))| {
            let stored =
                if *stiffness == Wide::zero() { Wide::zero() } else { self.before.force[*k] / *stiffness };
            let slip = (self.input.displacement[*k] + stored) * Wide::from_f64(*radius);
            slip * slip
        };
        sqrt(self.stiffness.iter().zip(&radii).map(part).fold(Wide::zero(), |sum, part| sum + part))
    }

    /// ∂P/∂f_k by differences.
    fn gradient(&self, force: &[Wide; 6], slip: Wide) -> Vec<Wide> {
        let along = |k: usize, h: Wide| {
            let mut moved = *force;
            moved[k] += h;
            self.potential(&moved, slip)
        };
        let of = |(k, _): &(usize, Wide)| {
            let h = Wide::from_f64(FIRST_STEP * self.sizes[*k]);
            (along(*k, h) - along(*k, -h)) / (h + h)
        };
        self.stiffness.iter().map(of).collect()
    }

    /// What of the equations is left: of the flow, then P − L.
    fn left(&self, force: &[Wide; 6], slip: Wide) -> Vec<Wide> {
        let gradient = self.gradient(force, slip);
        let flow =
            |((k, stiffness), g): (&(usize, Wide), Wide)| force[*k] - self.trial[*k] + *stiffness * slip * g;
        let mut left: Vec<Wide> = self.stiffness.iter().zip(gradient).map(flow).collect();
        left.push(self.potential(force, slip) - self.limit(slip)[1]);
        left
    }

    /// Newton's method from the product's solution, measured by that: what it is returned from may be larger by many decades.
    fn against_gradient(&self, allowed: &Allowed) -> Result<([Wide; 6], Wide), Unsolved> {
        let stiffness = self.of_slip.ok_or(Unsolved::Singular)?;
        let mut force = [Wide::zero(); 6];
        for (k, _) in &self.stiffness {
            force[*k] = Wide::from_f64(self.outcome.force[*k]);
        }
        let mut slip = Wide::from_f64(self.outcome.slip_increment);
        let slip_size = if slip > Wide::zero() {
            slip
        } else {
            let largest = self.sizes.iter().fold(0.0_f64, |most, size| most.max(*size));
            Wide::from_f64(largest) / stiffness
        };
        let sizes = self.stiffness.iter().map(|(k, _)| Wide::from_f64(self.sizes[*k])).chain([slip_size]);
        let sizes: Vec<Wide> = sizes.collect();
        let given = (force, slip);
        let mut is_solution = false;
        for n in 0..STEPS {
            let (left, columns) = self.linearised(&force, slip, &sizes);
            if n == 0 {
                is_solution = self.is_met(&left, &columns, allowed);
            }
            let step = linear(&columns, &left).ok_or(Unsolved::Singular)?;
            for ((k, _), by) in self.stiffness.iter().zip(&step) {
                force[*k] -= *by;
            }
            slip -= *step.last().ok_or(Unsolved::Singular)?;
            if is_converged(step.into_iter().zip(sizes.iter().copied())) {
                let is_near = |x: Wide, y: Wide, allowed: f64| (x - y).abs() <= Wide::from_f64(allowed);
                let mut forces = self.stiffness.iter();
                let stays = forces.all(|(k, _)| is_near(force[*k], given.0[*k], allowed.forces[*k]))
                    && is_near(slip, given.1, allowed.slip);
                return match (stays, is_solution) {
                    (false, true) => Err(Unsolved::Another),
                    _ if slip < Wide::zero() => Err(Unsolved::NotConverged),
                    _ => self.first((force, slip)),
                };
            }
        }
        Err(Unsolved::NotConverged)
    }

    /// What of the equations is left, and its derivatives by each unknown.
    fn linearised(&self, force: &[Wide; 6], slip: Wide, sizes: &[Wide]) -> (Vec<Wide>, Vec<Vec<Wide>>) {
        /// Differences of gradients that are differences: steps between those of both.
        const STEP: f64 = 1e-15;
        let left = self.left(force, slip);
        let column = |(j, size): (usize, &Wide)| -> Vec<Wide> {
            let (mut moved, mut slid) = (*force, slip);
            let h = Wide::from_f64(STEP) * *size;
            match self.stiffness.get(j) {
                Some((k, _)) => moved[*k] += h,
                None => slid += h,
            }
            let there = self.left(&moved, slid);
            there.iter().zip(&left).map(|(a, b)| (*a - *b) / h).collect()
        };
        let columns = sizes.iter().enumerate().map(column).collect();
        (left, columns)
    }

    /// Whether what is left of every equation is no more than what the tolerances of the unknowns make of it.
    fn is_met(&self, left: &[Wide], columns: &[Vec<Wide>], allowed: &Allowed) -> bool {
        let of = |j: usize| self.stiffness.get(j).map_or(allowed.slip, |(k, _)| allowed.forces[*k]);
        left.iter().enumerate().all(|(i, left)| {
            let column = |(j, column): (usize, &Vec<Wide>)| column[i].abs() * Wide::from_f64(of(j));
            left.abs() <= columns.iter().enumerate().map(column).fold(Wide::zero(), |sum, x| sum + x)
        })
    }

    /// A solution, unless a smaller slip is one. Of a norm P falls by K Δγ, whatever the direction: with a limit that slip does not change
    /// there is only one, and with any other the excess is looked at on the way. Of a potential that is not known.
    fn first(&self, found: ([Wide; 6], Wide)) -> Result<([Wide; 6], Wide), Unsolved> {
        /// Places on the way.
        const PLACES: i32 = 32;
        let (_, slip) = found;
        let (Tangential::Norm(_), Some(stiffness)) = (&self.case.friction.criterion.tangential, self.of_slip)
        else {
            return Ok(found);
        };
        let magnitude = self.potential(&self.trial, Wide::zero());
        let is_met = |n: i32| {
            let before = slip * Wide::ratio(n, PLACES);
            magnitude - stiffness * before <= self.limit(before)[1]
        };
        if (1..PLACES).any(is_met) { Err(Unsolved::NotFirst) } else { Ok(found) }
    }

    /// f = s f_tr with P(f) = L, and the slip that this takes, by Newton's method from the product's solution.
    fn along_traction(&self, magnitude: Wide, allowed: &Allowed) -> Result<([Wide; 6], Wide), Unsolved> {
        self.of_slip.ok_or(Unsolved::Singular)?;
        let whole = self.stiffness.iter().fold(Wide::zero(), |sum, (k, stiffness)| {
            sum + self.trial[*k] * self.trial[*k] / (*stiffness * magnitude)
        });
        let forces = |share: Wide| self.trial.map(|x| x * share);
        let slip = |share: Wide| (Wide::integer(1) - share) * whole;
        let left = |share: Wide| self.potential(&forces(share), slip(share)) - self.limit(slip(share))[1];
        let moves = |(k, _): &&(usize, Wide)| self.trial[*k] != Wide::zero();
        let (k, _) = self.stiffness.iter().find(moves).ok_or(Unsolved::Singular)?;
        let given = Wide::from_f64(self.outcome.force[*k]) / self.trial[*k];
        let size = if given == Wide::zero() { Wide::integer(1) } else { given.abs() };
        let share = root(given, size, left)?;
        let allowed = Wide::from_f64(allowed.forces[*k]) / self.trial[*k].abs();
        let h = Wide::from_f64(FIRST_STEP) * size;
        let slope = (left(given + h) - left(given - h)) / (h + h);
        if (share - given).abs() > allowed && left(given).abs() <= slope.abs() * allowed {
            return Err(Unsolved::Another);
        }
        Ok((forces(share), slip(share)))
    }
}

/// What forces and slip may be off.
struct Allowed {
    forces: [f64; 6],
    slip: f64,
}
