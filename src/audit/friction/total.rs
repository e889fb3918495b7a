//! The slopes of all forces of a connector together (TANGENT). CTF is typed here a second time and differentiated on 237 bits. It
//! is a function of displacements, velocities, reactions, the tension and the angle of wrap at a ring, and the time step.
//!
//! What friction makes of a reaction, ∂CSF/∂λ, has no counterpart ∂CRF/∂u: the tangent is not symmetric.

use crate::case::quantity::Quantity;
use crate::friction::increment::{branch_of, exact_state, forced};
use crate::friction::{Judged, group_sizes, reach};
use crate::judge::slopes::{Argument, Held, Output, Slopes};
use crate::mutants::mutant::Mistake;
use crate::oracles::differences::FIRST_STEP;
use crate::settings::Settings;
use pintle_kinematics::catalog::{COMPONENT, FORCE};
use pintle_kinematics::scalar::{Real, Scalar, Wide};
use pintle_model::behavior::friction::{self, BeltInput, Branch, Context, FLOW, Frictional, Input};
use pintle_model::behavior::state::{Behavior, Outcome};
use pintle_model::behavior::{Beyond, Conditions, Motion, Slip, Tangent, Wrap};

/// u, v and λ of six components each, T2, α, Δt.
const INPUTS: usize = 21;
const VELOCITY: usize = 6;
const REACTION: usize = 12;
const BEYOND: usize = 18;
const ANGLE: usize = 19;
const TIME: usize = 20;

/// The forces of a connector at a state, after its history.
pub(super) struct Total<'a> {
    pub(super) behavior: &'a Behavior,
    pub(super) outcome: &'a Outcome,
    pub(super) tangent: &'a Tangent<f64>,
    pub(super) conditions: &'a Conditions,
    pub(super) length: f64,
}

/// A component that slides, with the slopes of its friction force by Δu, what presses, Δt, T2 and α.
type SlidingSlopes<R> = (usize, [R; 6], [R; 6], R, R, R);

/// Which branch an increment takes.
type OnBranch = fn(&friction::FrictionOutcome<f64>) -> Branch;

fn other(outcome: &friction::FrictionOutcome<f64>) -> Branch {
    if forced(outcome) == Branch::Slip { Branch::Stick } else { Branch::Slip }
}

impl Total<'_> {
    fn motion<R: Real>(&self, j: usize, h: R) -> Motion<R> {
        let Motion { position, constitutive, velocity } = self.outcome.motion;
        let all = |x: [f64; 6]| x.map(R::from_f64);
        let mut motion =
            Motion { position: all(position), constitutive: all(constitutive), velocity: all(velocity) };
        match j {
            0..VELOCITY => {
                motion.position[j] = motion.position[j] + h;
                motion.constitutive[j] = motion.constitutive[j] + h;
            }
            VELOCITY..REACTION => {
                let rate = &mut motion.velocity[j - VELOCITY];
                *rate = *rate + h;
            }
            _ => {}
        }
        motion
    }

    /// CEF + CVF of what has not failed.
    fn laws<R: Real>(&self, motion: &Motion<R>) -> [R; 6] {
        let forces = self.behavior.forces(motion, self.conditions);
        [0, 1, 2, 3, 4, 5].map(|k| if self.outcome.failed[k] { R::ZERO } else { forces[k] })
    }

    /// The frictions whose increment is known, in the order of the behaviour, then that of a belt.
    fn slips(
        &self,
    ) -> impl Iterator<Item = (usize, &Slip, &friction::State<f64>, &friction::FrictionOutcome<f64>)> {
        let known = self.outcome.slips.iter().enumerate();
        known.filter_map(|(i, slip)| Some((i, slip, slip.before.as_ref()?, slip.outcome.as_ref().ok()?)))
    }

    fn duration<R: Real>(&self, j: usize, h: R) -> Option<R> {
        let duration = self.outcome.duration.map(R::from_f64);
        duration.map(|duration| if j == TIME { duration + h } else { duration })
    }

    /// The forces that press on a friction: as they are, with what laws and reactions change.
    fn pressing<R: Real>(&self, slip: &Slip, j: usize, h: R) -> [R; 6] {
        let still = self.laws(&self.motion(0, R::ZERO));
        let laws = self.laws(&self.motion(j, h));
        [0, 1, 2, 3, 4, 5].map(|p| {
            let by = laws[p] - still[p];
            let reaction = if j == REACTION + p && self.tangent.reacting[p] { h } else { R::ZERO };
            let change = if self.outcome.failed[p] { R::ZERO } else { by + reaction };
            R::from_f64(slip.forces[p]) + change
        })
    }

    fn displacement<R: Real>(&self, slip: &Slip, j: usize, h: R) -> [R; 6] {
        let mut displacement = slip.displacement.map(R::from_f64);
        if j < VELOCITY && slip.components[j] && !self.outcome.failed[j] {
            displacement[j] = displacement[j] + h;
        }
        displacement
    }

    fn input<R: Real>(&self, slip: &Slip, before: &friction::State<f64>, j: usize, h: R) -> Input<'_, R> {
        let motion = self.motion(j, h);
        Input {
            displacement: self.displacement(slip, j, h),
            forces: self.pressing(slip, j, h),
            duration: self.duration(j, h),
            context: Context {
                position: motion.position,
                motion: motion.constitutive,
                accumulated_slip: R::from_f64(before.accumulated_slip),
                conditions: self.conditions,
            },
        }
    }

    fn belt_input<R: Real>(&self, slip: &Slip, beyond: &Beyond, j: usize, h: R) -> BeltInput<'_, R> {
        let zero = R::ZERO;
        let moves = matches!(beyond.wrap, Wrap::Measured(_));
        let by = |place: usize| if j == place { h } else { zero };
        let angle = if moves { by(ANGLE) } else { zero };
        BeltInput {
            flow: self.displacement(slip, j, h)[FLOW],
            tension: [self.pressing(slip, j, h)[0], R::from_f64(beyond.tension.unwrap_or(0.0)) + by(BEYOND)],
            angle: R::from_f64(beyond.angle) + angle,
            duration: self.duration(j, h),
            conditions: self.conditions,
        }
    }

    /// CTF after input j has moved.
    fn forces<R: Frictional>(&self, j: usize, h: R, on: OnBranch) -> [R; 6] {
        self.forces_while(j, h, on, false)
    }

    /// CTF after input j has moved, where what presses on frictions moves with it or `holds`.
    fn forces_while<R: Frictional>(&self, j: usize, h: R, on: OnBranch, holds: bool) -> [R; 6] {
        let mut forces = self.laws(&self.motion(j, h));
        if let Some(k) = j.checked_sub(REACTION).filter(|k| *k < 6 && self.tangent.reacting[*k]) {
            forces[k] = forces[k] + h;
        }
        for (i, slip, before, outcome) in self.slips() {
            let state = exact_state(before);
            let still = R::ZERO;
            let moved = match (self.behavior.friction.frictions.get(i), &self.behavior.friction.belt) {
                (Some(friction), _) => {
                    let mut input = self.input(slip, before, j, h);
                    if holds {
                        input.forces = self.pressing(slip, 0, still);
                    }
                    friction.update(&state, &input, on(outcome))
                }
                (None, Some(belt)) => {
                    let Some(beyond) = &slip.beyond else { continue };
                    let mut input = self.belt_input(slip, beyond, j, h);
                    if holds {
                        input.tension = self.belt_input(slip, beyond, 0, still).tension;
                    }
                    belt.update(&state, &input, on(outcome))
                }
                (None, None) => continue,
            };
            for k in (0..6).filter(|k| slip.components[*k]) {
                forces[k] = forces[k] + moved.force[k];
            }
        }
        forces
    }

    /// The slopes after input j has moved, by the chain rule.
    fn slopes<R: Frictional>(&self, j: usize, h: R, on: OnBranch) -> Vec<Vec<R>> {
        let zero = R::ZERO;
        let mut found = vec![vec![zero; INPUTS]; 6];
        let laws = self.behavior.tangent(&self.motion(j, h), self.conditions, None, self.outcome.failed);
        for k in 0..6 {
            found[k][..VELOCITY].copy_from_slice(&laws.displacement[k]);
            found[k][VELOCITY..REACTION].copy_from_slice(&laws.velocity[k]);
            if self.tangent.reacting[k] {
                found[k][REACTION + k] = R::integer(1);
            }
        }
        for (i, slip, before, outcome) in self.slips() {
            let state = exact_state(before);
            let frictions = &self.behavior.friction;
            let mut rows: Vec<SlidingSlopes<R>> = Vec::new();
            if let Some(friction) = frictions.frictions.get(i) {
                let input = self.input(slip, before, j, h);
                let tangent = friction.tangent_while(&state, &input, on(outcome), self.outcome.failed).1;
                for k in (0..6).filter(|k| slip.components[*k]) {
                    let of = tangent.force[k];
                    rows.push((k, of.displacement, of.forces, of.duration, zero, zero));
                }
            } else if let (Some(belt), Some(beyond)) = (&frictions.belt, &slip.beyond) {
                let tangent = belt.tangent(&state, &self.belt_input(slip, beyond, j, h), on(outcome)).1;
                let mut by_flow = [zero; 6];
                by_flow[FLOW] = tangent.flow;
                let mut by_force = [zero; 6];
                by_force[0] = tangent.tension[0];
                let moves = matches!(beyond.wrap, Wrap::Measured(_));
                let angle = if moves { tangent.angle } else { zero };
                rows.push((FLOW, by_flow, by_force, tangent.duration, tangent.tension[1], angle));
            }
            for (k, by_motion, by_force, by_time, by_tension, by_angle) in rows {
                let row = &mut found[k];
                for l in 0..6 {
                    row[l] = row[l] + by_motion[l];
                }
                for p in (0..6).filter(|p| !self.outcome.failed[*p]) {
                    for l in 0..6 {
                        row[l] = row[l] + by_force[p] * laws.displacement[p][l];
                        row[VELOCITY + l] = row[VELOCITY + l] + by_force[p] * laws.velocity[p][l];
                    }
                    if self.tangent.reacting[p] {
                        row[REACTION + p] = row[REACTION + p] + by_force[p];
                    }
                }
                row[BEYOND] = row[BEYOND] + by_tension;
                row[ANGLE] = row[ANGLE] + by_angle;
                row[TIME] = row[TIME] + by_time;
            }
        }
        found
    }

    /// What an input is measured by, and how far it may go on doubles.
    fn sizes(&self) -> (Vec<f64>, Vec<f64>) {
        const LEAST: f64 = 1e-9;
        let mut slipping = [0.0_f64; 6];
        let mut presses = [0.0_f64; 6];
        let (mut beyond, mut angle) = (0.0_f64, 1.0_f64);
        for (_, slip, _, outcome) in self.slips() {
            let elastic = outcome.stick_stiffness.map_or(0.0, |stiffness| (outcome.limit / stiffness).abs());
            for k in 0..6 {
                if slip.components[k] {
                    slipping[k] = slipping[k].max(slip.displacement[k].abs() + elastic);
                }
                presses[k] = presses[k].max(slip.forces[k].abs());
            }
            if let Some(Beyond { tension: Ok(tension), angle: wrap, .. }) = slip.beyond {
                (beyond, angle) = (beyond.max(tension.abs()), angle.max(wrap.abs()));
            }
        }
        let mut chosen = [false; 6];
        for friction in &self.behavior.friction.frictions {
            let own = friction.criterion.pressing_components();
            (0..6).for_each(|k| chosen[k] |= own[k]);
        }
        chosen[0] |= self.behavior.friction.belt.is_some();
        let forces = group_sizes(&presses, chosen, self.length);
        let unit = |k: usize| if k < 3 { self.length } else { 1.0 };
        let mut sizes = Vec::with_capacity(INPUTS);
        for k in 0..6 {
            let slides = self.outcome.slips.iter().any(|slip| slip.components[k]);
            let size = if slides { slipping[k].max(LEAST * unit(k)) } else { unit(k) };
            sizes.push(if size.is_finite() { size } else { unit(k) });
        }
        let velocity = self.outcome.motion.velocity;
        sizes.extend((0..6).map(|k| velocity[k].abs().max(unit(k))));
        sizes.extend(forces);
        sizes.extend([if beyond > 0.0 { beyond } else { forces[0] }, angle]);
        sizes.push(self.outcome.duration.unwrap_or(1.0));
        let mut reaches = sizes.clone();
        reaches[REACTION..BEYOND].copy_from_slice(&reach(&presses, &forces));
        (sizes, reaches)
    }

    /// The tables of TANGENT: of the forces whose slopes are known.
    pub(super) fn tables(&self, settings: &Settings, wide: bool) -> Vec<Judged> {
        let rows: Vec<usize> = (0..6)
            .filter(|k| self.tangent.unknown[*k].is_none() && !self.outcome.failed[*k])
            .filter(|k| self.behavior.available()[*k] || self.tangent.reacting[*k])
            .collect();
        let of_rows = |all: &[Vec<f64>]| -> Vec<Vec<f64>> { rows.iter().map(|k| all[*k].clone()).collect() };
        let given: Vec<Vec<f64>> = (0..6)
            .map(|k| {
                let Tangent { displacement, velocity, reaction, beyond, angle, time, .. } = self.tangent;
                let by = displacement[k].iter().chain(&velocity[k]).chain(&reaction[k]);
                by.chain([&beyond[k], &angle[k], &time[k]]).copied().collect()
            })
            .collect();
        let got = of_rows(&given);
        let named = |mark: &'static str| COMPONENT.iter().map(move |name| format!("{mark}({name})"));
        let reactions = FORCE.iter().map(|name| format!("CR{}", name.to_uppercase()));
        let inputs = named("u").chain(named("v")).chain(reactions);
        let inputs = inputs.chain(["T2", "α", "Δt"].map(String::from));
        let inputs: Vec<String> = inputs.collect();
        let (sizes, reach) = self.sizes();
        let still = self.forces(0, 0.0, forced);
        let pick = |all: [Wide; 6]| rows.iter().map(|k| all[*k]).collect();
        // Reactions and the tension beyond a ring only press; displacements and velocities do so through springs and dampers.
        let only_presses = |i: usize, j: usize| match j {
            REACTION..BEYOND => {
                let is_own = j - REACTION == rows[i] && self.tangent.reacting[rows[i]];
                Some(if is_own { 1.0 } else { 0.0 })
            }
            BEYOND => Some(0.0),
            _ => None,
        };
        let slopes = Slopes {
            quantity: Quantity::ConsistentTangent,
            outputs: Output::list(rows.iter().map(|k| (FORCE[*k], still[*k].abs(), k / 3))),
            inputs: Argument::list(&inputs, &sizes, &reach, |_| 0.0),
            matrices: None,
            demanded: Vec::new(),
            class: &|i, j| (i, j / 3, 0),
            got,
            step: FIRST_STEP,
            wide: Box::new(|j, h| pick(self.forces(j, h, branch_of))),
            narrow: Box::new(|j, h| {
                let all = self.forces(j, h, forced);
                rows.iter().map(|k| all[*k]).collect()
            }),
            slopes: Box::new(|j, h| of_rows(&self.slopes(j, h, forced))),
            dual: Box::new(|| {
                let all = self.slopes(0, Wide::zero(), branch_of);
                rows.iter().map(|k| all[*k].clone()).collect()
            }),
            mistaken: vec![(Mistake::StickForSlip, of_rows(&self.slopes(0, 0.0, other)))],
            held: Some(Held {
                known: Box::new(only_presses),
                wide: Some(Box::new(|j, h| pick(self.forces_while(j, h, branch_of, true)))),
            }),
        };
        slopes.tables(settings, wide)
    }
}
