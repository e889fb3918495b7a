//! The frictions of a connector at one state: what presses, and what sticks or slips under it.

use crate::behavior::friction;
use crate::behavior::friction::{BeltInput, FLOW, Frictions, wrap_angle};
use crate::behavior::state::{Behavior, History, Kinematics};
use crate::behavior::{Conditions, Forces, Motion, Unknown};
use pintle_kinematics::connector::{Components, Mask};
use pintle_kinematics::scalar::Duals;
use pintle_kinematics::scalar::{Scalar, Seeded};
use pintle_kinematics::vector::{Vector, add};

/// A friction at a state.
#[derive(Clone, Debug)]
pub struct Slip {
    /// The components that slide.
    pub components: Mask,
    /// What it remembered; `None` where that is not known.
    pub before: Option<friction::State<f64>>,
    /// Δu of the sliding components since the last state; zero for the others.
    pub displacement: [f64; 6],
    /// The forces from which F_C is formed; of a belt the tension of the segment, in u1.
    pub forces: [f64; 6],
    /// The belt on the other side of the ring, for the friction of a belt.
    pub beyond: Option<Beyond>,
    /// What it does, or why that is not known.
    pub outcome: Result<friction::FrictionOutcome<f64>, Unknown>,
}

/// A belt on the other side of the ring at b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beyond {
    /// Its tension T2, or why that is not known.
    pub tension: Result<f64, Unknown>,
    /// The angle of wrap α (rad).
    pub angle: f64,
    /// How that changes as the nodes move.
    pub wrap: Wrap,
}

/// How an angle of wrap changes as the nodes of both segments move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wrap {
    /// Not at all: the section data give the angle.
    Given,
    /// By ∂α/∂x of the node where the first segment begins, the ring, and the node where the second one ends; global components.
    Measured([Vector<f64>; 3]),
    /// The segments are in line, or folded back: it has no derivative there.
    Kink,
}

impl Wrap {
    /// The angle between two segments that are given by their directions (the angle of wrap a decision of ours), with how it changes.
    pub(crate) fn measured(first: Vector<f64>, second: Vector<f64>) -> (f64, Self) {
        type Moving = <f64 as Duals>::Gradient<6>;
        let seeded = |of: Vector<f64>, at: usize| [0, 1, 2].map(|i| Moving::seed(of[i], at + i));
        let (first, second) = (seeded(first, 0), seeded(second, 3));
        let zero = [0.0; 3].map(Moving::from_real);
        let (angle, flags) = wrap_angle(zero, first, add(first, second));
        let [g1, g2, g3, h1, h2, h3] = angle.gradient();
        let (before, after) = ([-g1, -g2, -g3], [h1, h2, h3]);
        let ring = [g1 - h1, g2 - h2, g3 - h3];
        let wrap = if flags.is_empty() { Self::Measured([before, ring, after]) } else { Self::Kink };
        (angle.real(), wrap)
    }
}

/// The components that slide.
pub(super) fn sliding(frictions: &Frictions, available: Mask) -> Mask {
    let mut mask = [false; 6];
    for friction in &frictions.frictions {
        friction.criterion.tangential.components().into_iter().for_each(|k| mask[k] = true);
    }
    mask[FLOW] |= frictions.belt.is_some() && available[FLOW];
    mask
}

impl Behavior {
    /// The forces from which contact forces are formed, as far as they are known: the given ones of constrained components, and
    /// those without friction, CTF + CCF − CSF, of available ones. What holds an available component is part of its force, and
    /// known only from a total force that is given.
    pub(super) fn pressing(
        &self,
        held: Mask,
        total: &Components<f64>,
        laws: [&Forces<f64>; 2],
        load: &Forces<f64>,
        history: &History,
    ) -> Components<f64> {
        [0, 1, 2, 3, 4, 5].map(|k| {
            if history.failed[k] {
                return Some(0.0);
            }
            if self.constrained[k] {
                return total[k];
            }
            let is_told = !held[k] && laws.iter().all(|law| law.unknown[k].is_none());
            if is_told {
                return Some(laws.iter().filter_map(|law| law.value[k]).sum());
            }
            let is_load_known = load.unknown[k].is_none();
            total[k].filter(|_| !self.slips[k] && is_load_known).map(|sum| sum + load.value[k].unwrap_or(0.0))
        })
    }

    /// CSF: every friction that is known, after its history.
    pub(super) fn slide(
        &self,
        now: &Kinematics<'_>,
        pressing: &Components<f64>,
        duration: Option<f64>,
        motion: &Motion<f64>,
        conditions: &Conditions,
        history: &History,
    ) -> (Forces<f64>, Vec<Slip>) {
        let mut slips = Vec::with_capacity(self.friction.frictions.len());
        let remembered = |i: usize| {
            let mut state = match &history.friction {
                None => Some(friction::State::default()),
                Some(states) => states.get(i).copied().flatten(),
            };
            // A component that has failed carries nothing and slides no more.
            if let Some(state) = &mut state {
                (0..6).filter(|k| history.failed[*k]).for_each(|k| state.force[k] = 0.0);
            }
            state
        };
        let change = |k: usize| {
            let now = now.displacement[k].filter(|_| !history.failed[k])?;
            Some(now - history.displacement[k].unwrap_or(0.0))
        };
        for (i, friction) in self.friction.frictions.iter().enumerate() {
            let sliding = friction.criterion.tangential.components();
            let components = [0, 1, 2, 3, 4, 5].map(|k| sliding.contains(&k));
            let presses = friction.criterion.pressing_components();
            let mut slip = Slip {
                components,
                before: remembered(i),
                displacement: [0, 1, 2, 3, 4, 5].map(|k| change(k).filter(|_| components[k]).unwrap_or(0.0)),
                forces: pressing.map(|force| force.unwrap_or(0.0)),
                beyond: None,
                outcome: Err(Unknown::FrictionHistory),
            };
            slip.outcome = match &slip.before {
                _ if (0..6).any(|k| presses[k] && pressing[k].is_none()) => Err(Unknown::ContactForce),
                None => Err(Unknown::FrictionHistory),
                Some(state) => {
                    let input = slip.input(state, duration, motion, conditions);
                    decided(friction.update(state, &input, friction::Branch::Decided))
                }
            };
            slips.push(slip);
        }
        if let Some(belt) = &self.friction.belt {
            let mut slip = Slip {
                components: [0, 1, 2, 3, 4, 5].map(|k| k == FLOW),
                before: remembered(slips.len()),
                displacement: [0, 1, 2, 3, 4, 5].map(|k| change(k).filter(|_| k == FLOW).unwrap_or(0.0)),
                forces: pressing.map(|force| force.unwrap_or(0.0)),
                beyond: now.beyond,
                outcome: Err(Unknown::FrictionHistory),
            };
            slip.outcome = match (&slip.before, now.beyond) {
                // No belt goes on beyond b: nothing slides there.
                (Some(state), None) => Ok(friction::FrictionOutcome::idle(state)),
                (None, _) => Err(Unknown::FrictionHistory),
                (Some(_), Some(_)) if pressing[0].is_none() => Err(Unknown::ContactForce),
                (Some(_), Some(Beyond { tension: Err(why), .. })) => Err(why),
                (Some(state), Some(Beyond { tension: Ok(tension), angle, .. })) => {
                    let input = slip.belt_input((tension, angle), duration, conditions);
                    decided(belt.update(state, &input, friction::Branch::Decided))
                }
            };
            slips.push(slip);
        }
        let mut forces = Forces::none();
        for slip in &slips {
            for k in (0..6).filter(|k| slip.components[*k] && !history.failed[*k]) {
                match &slip.outcome {
                    Ok(outcome) => forces.value[k] = Some(outcome.force[k]),
                    Err(why) => forces.unknown[k] = Some(*why),
                }
            }
        }
        (forces, slips)
    }
}

impl Slip {
    /// The increment of a friction with Φ = P − μ F_N.
    pub(super) fn input<'a>(
        &self,
        state: &friction::State<f64>,
        duration: Option<f64>,
        motion: &Motion<f64>,
        conditions: &'a Conditions,
    ) -> friction::Input<'a, f64> {
        friction::Input {
            displacement: self.displacement,
            forces: self.forces,
            duration,
            context: friction::Context {
                position: motion.position,
                motion: motion.constitutive,
                accumulated_slip: state.accumulated_slip,
                conditions,
            },
        }
    }

    /// The increment of a belt, with T2 and α.
    pub(super) const fn belt_input<'a>(
        &self,
        (tension, angle): (f64, f64),
        duration: Option<f64>,
        conditions: &'a Conditions,
    ) -> BeltInput<'a, f64> {
        BeltInput {
            flow: self.displacement[FLOW],
            tension: [self.forces[0], tension],
            angle,
            duration,
            conditions,
        }
    }
}

/// What a friction does, unless something that it depends on is not given.
fn decided(outcome: friction::FrictionOutcome<f64>) -> Result<friction::FrictionOutcome<f64>, Unknown> {
    let lacks = outcome.flags.iter().find_map(|flag| match flag {
        friction::Flag::NotGiven { what } => Some(*what),
        _ => None,
    });
    lacks.map_or(Ok(outcome), Err)
}
