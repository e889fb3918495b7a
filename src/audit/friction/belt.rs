//! Friction of a belt around a ring: |T2 − T1| ≤ min(T1, T2) (exp(μ α) − 1), with derivatives by the tensions and the angle of wrap,
//! and what an increment does.
//!
//! The force is typed here a second time, in closed form where μ does not depend on the slip rate.

use crate::case::failing::{BeltCase, Failing};
use crate::case::quantity::Quantity;
use crate::friction::criterion::{Parts, Pressed, parts};
use crate::friction::increment::{branch_of, exact_state, forced};
use crate::friction::solve::{Unsolved, root};
use crate::friction::{Judged, checks, reach};
use crate::judge::outcome::Check;
use crate::judge::slopes::{Argument, Held, Output, Slopes};
use crate::judge::table::{Entry, ResultTable};
use crate::mutants::mutant::{Mistake, Mutant};
use crate::oracles::differences::FIRST_STEP;
use crate::oracles::oracle::Oracle;
use crate::settings::Settings;
use pintle_kinematics::scalar::elementary::exp;
use pintle_kinematics::scalar::{Real, Scalar, Wide};
use pintle_model::behavior::friction::{
    BeltInput, BeltTangent, Branch, Derivatives, FLOW, FrictionOutcome, Frictional, State, Status,
    StickStiffness,
};

/// What an increment of a belt depends on.
pub(super) const INPUTS: [&str; 5] = ["Δu2", "T1", "T2", "α", "Δt"];

/// T1, T2, α.
pub(super) const POINT: [&str; 3] = ["T1", "T2", "α"];

/// What an increment gives.
pub(super) const RESULTS: [&str; 5] = ["CSF2", "Δγ", "CNF", "limit", "CASU"];

fn results<R: Copy>(outcome: &FrictionOutcome<R>) -> Vec<R> {
    vec![outcome.force[FLOW], outcome.slip_increment, outcome.normal, outcome.limit, outcome.accumulated_slip]
}

fn flat<R: Copy>(tangent: &BeltTangent<R>) -> Vec<Vec<R>> {
    let [first, second] = tangent.tension;
    vec![vec![tangent.flow, first, second, tangent.angle, tangent.duration]]
}

/// A belt with a coefficient.
struct AtCoefficient<'a> {
    case: &'a BeltCase,
    coefficient: f64,
}

impl AtCoefficient<'_> {
    fn tensions<R: Real>(&self, moved: &[(usize, R)]) -> ([R; 2], R, R) {
        let mut point = self.case.point().map(R::from_f64);
        moved.iter().for_each(|(k, h)| point[*k] = point[*k] + *h);
        let [first, second, angle] = point;
        ([first, second], angle, R::from_f64(self.coefficient))
    }
}

/// min(T1, T2) (exp(μ α) − 1) is of the size of the tensions.
impl Pressed for AtCoefficient<'_> {
    fn parts<R: Frictional>(&self, moved: &[(usize, R)]) -> [R; 4] {
        let (tension, angle, coefficient) = self.tensions(moved);
        parts(self.case.belt.at(tension, angle, coefficient).0)
    }

    fn differentiated<R: Frictional>(&self, moved: &[(usize, R)]) -> [Derivatives<R>; 4] {
        let (tension, angle, coefficient) = self.tensions(moved);
        parts(self.case.belt.derivatives(tension, angle, coefficient).0)
    }
}

impl BeltCase {
    /// All checks at this state.
    pub(crate) fn judged(&self, settings: &Settings, wide: bool, proves: bool) -> Vec<Check> {
        let mut found = checks(self.all_tables(settings, wide), settings, &self.name, proves);
        found.iter_mut().for_each(|check| check.fails_at(|| Failing::Belt(Box::new(self.clone()))));
        found
    }

    /// The numbers at this state, and what they must be by differences on 237 bits.
    pub(crate) fn tables(&self) -> Vec<ResultTable> {
        let tables = self.all_tables(&crate::friction::by_differences(), true);
        tables.into_iter().map(|(_, table)| table).collect()
    }

    fn all_tables(&self, settings: &Settings, wide: bool) -> Vec<Judged> {
        let (outcome, tangent) = self.belt.tangent(&self.before, &self.input(0, 0.0), Branch::Decided);
        let mut tables = self.criterion_tables(settings, wide, outcome.coefficient);
        tables.extend(self.increment_tables(settings, wide, &outcome, &tangent));
        tables
    }

    fn sizes(&self) -> [f64; 3] {
        let tension = self.tension[0].abs().max(self.tension[1].abs());
        let tension = if tension > 0.0 { tension } else { 1.0 };
        [tension, tension, self.angle.abs().max(1.0)]
    }

    /// T1, T2 and α.
    const fn point(&self) -> [f64; 3] {
        [self.tension[0], self.tension[1], self.angle]
    }

    fn criterion_tables(&self, settings: &Settings, wide: bool, coefficient: f64) -> Vec<Judged> {
        let sizes = self.sizes();
        let parts = Parts {
            of: &AtCoefficient { case: self, coefficient },
            title: "",
            inputs: Argument::list(&POINT, &sizes, &reach(&self.point(), &sizes), |_| 0.0),
            of_a_unit: 2,
            shift: 0.0,
            clear: 1.0,
            demanded: Vec::new(),
            mistaken: Vec::new(),
        };
        parts.tables(settings, wide)
    }

    fn input<R: Real>(&self, j: usize, h: R) -> BeltInput<'_, R> {
        let mut input = BeltInput {
            flow: R::from_f64(self.flow),
            tension: self.tension.map(R::from_f64),
            angle: R::from_f64(self.angle),
            duration: self.duration.map(R::from_f64),
            conditions: &self.conditions,
        };
        match j {
            0 => input.flow = input.flow + h,
            1 | 2 => input.tension[j - 1] = input.tension[j - 1] + h,
            3 => input.angle = input.angle + h,
            _ => input.duration = input.duration.map(|duration| duration + h),
        }
        input
    }

    fn increment_tables(
        &self,
        settings: &Settings,
        wide: bool,
        outcome: &FrictionOutcome<f64>,
        tangent: &BeltTangent<f64>,
    ) -> Vec<Judged> {
        const LEAST: f64 = 1e-9;
        let (belt, before) = (&self.belt, exact_state::<Wide>(&self.before));
        let (on, steady) = (branch_of(outcome), forced(outcome));
        let [first, second, angle] = self.sizes();
        let slip = outcome.stick_stiffness.map_or(0.0, |stiffness| (outcome.limit / stiffness).abs());
        let flow = (self.flow.abs() + slip).max(LEAST * self.length);
        let sizes = vec![flow, first, second, angle, self.duration.unwrap_or(1.0)];
        let mut reaches = sizes.clone();
        reaches[1..4].copy_from_slice(&reach(&self.point(), &self.sizes()));
        let mut got = flat(tangent);
        settings.planted.into_iter().for_each(|planted| planted.spoil_friction(&mut got));
        let force = |outcome: &FrictionOutcome<f64>| vec![outcome.force[FLOW]];
        let other = if outcome.status == Status::Slip { Branch::Stick } else { Branch::Slip };
        let wrong = flat(&belt.tangent(&self.before, &self.input(0, 0.0), other).1);
        let still = belt.update(&self.before, &self.input(0, -self.flow), Branch::Decided);
        let secant = (outcome.force[FLOW] - still.force[FLOW]) / self.flow;
        let mut secants = flat(tangent);
        for slope in secants.iter_mut().filter_map(|row| row.first_mut()).filter(|_| secant.is_finite()) {
            *slope = secant;
        }
        let slopes = Slopes {
            quantity: Quantity::FrictionTangent,
            outputs: Output::list([(RESULTS[0], outcome.force[FLOW].abs(), 0)]),
            inputs: Argument::list(&INPUTS, &sizes, &reaches, |_| 0.0),
            matrices: None,
            demanded: Vec::new(),
            class: &|_, j| (0, [0, 1, 1, 2, 3][j], 0),
            got,
            step: FIRST_STEP,
            wide: Box::new(|j, h| vec![belt.update(&before, &self.input(j, h), on).force[FLOW]]),
            narrow: Box::new(|j, h| force(&belt.update(&self.before, &self.input(j, h), steady))),
            slopes: Box::new(|j, h| flat(&belt.tangent(&self.before, &self.input(j, h), steady).1)),
            dual: Box::new(|| flat(&belt.tangent(&before, &self.input(0, Wide::zero()), on).1)),
            mistaken: vec![(Mistake::StickForSlip, wrong), (Mistake::SecantForTangent, secants)],
            // The tensions press; the angle of wrap changes the limit however they are held.
            held: Some(Held { known: Box::new(|_, j| (1..3).contains(&j).then_some(0.0)), wide: None }),
        };
        let scale = slopes.value_scales()[0];
        let mut tables = slopes.tables(settings, wide);
        if !wide {
            return tables;
        }
        let limit = outcome.limit.abs().max(scale);
        let scales = [scale, flow, first, limit, flow + outcome.accumulated_slip.abs()];
        let update = belt.update(&before, &self.input(0, Wide::zero()), on);
        let wrong = results(&belt.update(&self.before, &self.input(0, 0.0), other));
        for oracle in [Oracle::WideDifferences, Oracle::WideDual] {
            if !settings.oracles.contains(&oracle) {
                continue;
            }
            let found = match oracle {
                Oracle::WideDual => Ok(results(&update)),
                _ => self.closed(&before, outcome, on),
            };
            let want = match found {
                Ok(want) => want,
                Err(why) => {
                    tables.push((oracle, ResultTable::unanswered(Quantity::FrictionForce, why.reason())));
                    continue;
                }
            };
            let got = results(outcome);
            let class = |i: usize| ([0, 1, 0, 0, 1][i], 0, 0);
            let entry = |i: usize| Entry::new(RESULTS[i].to_string(), got[i], want[i], scales[i], class(i));
            let mut table = ResultTable::new(Quantity::FrictionForce);
            table.rows = RESULTS.map(String::from).to_vec();
            table.entries = (0..RESULTS.len()).map(entry).collect();
            let changes = wrong.iter().enumerate().map(|(i, x)| (i, 0, *x));
            table.mistakes = vec![Mutant::many(Mistake::StickForSlip, changes)];
            tables.push((oracle, table));
        }
        tables
    }

    /// CSF2, Δγ, the tension that holds, the limit and CASU; or why there is no such solution.
    fn closed(
        &self,
        before: &State<Wide>,
        outcome: &FrictionOutcome<f64>,
        on: Branch,
    ) -> Result<Vec<Wide>, Unsolved> {
        if let Some(why) = Unsolved::of(&outcome.flags) {
            return Err(why);
        }
        let (zero, one) = (Wide::zero(), Wide::integer(1));
        let [first, second, angle] = self.point().map(Wide::from_f64);
        let duration = self.duration.filter(|duration| *duration > 0.0).map(Wide::from_f64);
        let limit = |held: Wide, slip: Wide| {
            let rate = duration.map_or(zero, |duration| slip / duration);
            let coefficient = self.belt.coefficient.at(rate, held, &self.conditions);
            let limit = held * (exp(coefficient * angle) - one);
            let most = self.belt.maximum.map(Wide::from_f64);
            most.filter(|most| *most < limit).unwrap_or(limit)
        };
        let flow = Wide::from_f64(self.flow);
        let kept = match (self.belt.stick_stiffness, before.stick_stiffness) {
            (StickStiffness::Given(stiffness), _) => Some(Wide::from_f64(stiffness)),
            (StickStiffness::ElasticSlip(_), kept) => kept,
        };
        let drawn = before.force[FLOW] + kept.unwrap_or(one) * flow;
        let tension = if drawn < zero { second } else { first };
        let held = if tension > zero { tension } else { zero };
        let at_rest = limit(held, zero);
        let end = |force: Wide, slip: Wide| {
            vec![force, slip, held, limit(held, slip), before.accumulated_slip + slip]
        };
        let holds = at_rest > zero;
        let stiffness = match (kept, self.belt.stick_stiffness) {
            (Some(kept), _) => Some(kept),
            (None, StickStiffness::ElasticSlip(slip)) => holds.then(|| at_rest / Wide::from_f64(slip)),
            (None, StickStiffness::Given(stiffness)) => Some(Wide::from_f64(stiffness)),
        };
        let trial = before.force[FLOW] + stiffness.unwrap_or(zero) * flow;
        if on != Branch::Stick && !holds {
            // All of the flow, and what stick had stored, is slip.
            let slip = stiffness.map_or_else(|| flow.abs(), |stiffness| trial.abs() / stiffness);
            return Ok(end(zero, slip));
        }
        let stiffness = stiffness.ok_or(Unsolved::Singular)?;
        let slips = match on {
            Branch::Stick => false,
            Branch::Slip => true,
            Branch::Decided => trial.abs() > at_rest,
        };
        if !slips {
            return Ok(end(trial, zero));
        }
        let left = |slip: Wide| trial.abs() - stiffness * slip - limit(held, slip);
        let slip = root(Wide::from_f64(outcome.slip_increment), trial.abs() / stiffness, left)?;
        let sign = if drawn < zero { -one } else { one };
        Ok(end(limit(held, slip) * sign, slip))
    }
}
