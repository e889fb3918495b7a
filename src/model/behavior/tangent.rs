//! Slopes of component forces, exact: the consistent tangent of a behaviour.
//!
//! `CTF_i = CEF_i + CVF_i + CSF_i + CRF_i − CCF_i` is a function of the displacements u, the velocities v, and the reactions λ =
//! CRF of the components that have one. Where friction or increments of velocity make it so, it is one of the time step Δt too. A
//! stop that is reached, a lock, a prescribed motion and a rigid elasticity hold their component as a constraint does. What that
//! takes is an unknown of its own beside the row u_k = ū, not a stiffness. Friction depends on what presses, CEF + CVF + λ, so that
//! ∂CSF/∂λ ≠ 0 (the part −μ ∂F_N/∂λ of Φ) makes the tangent unsymmetric. Applied loads do not change with the motion.

use crate::behavior::friction::{Branch, FLOW};
use crate::behavior::law::{ForceKink, Law};
use crate::behavior::slide::{Beyond, Slip, Wrap};
use crate::behavior::state::{Behavior, History, Outcome};
use crate::behavior::{Conditions, Motion, Unknown};
use pintle_kinematics::Differentiable;
use pintle_kinematics::connector::{Components, Mask, StopStatus};
use pintle_kinematics::scalar::{Real, Scalar, Seeded};
use pintle_kinematics::vector::Vector;

/// The slopes of component forces: ∂F_i/∂x_j, i and j from u1, u2, u3, ur1, ur2, ur3.
#[derive(Clone, Debug, PartialEq)]
pub struct Tangent<R> {
    /// ∂F_i/∂u_j at constant velocities and reactions.
    pub displacement: [[R; 6]; 6],
    /// ∂F_i/∂v_j.
    pub velocity: [[R; 6]; 6],
    /// ∂F_i/∂λ_j by the reactions (CRF) of the components in `reacting`: 1 for its own force, and what friction makes of it.
    pub reaction: [[R; 6]; 6],
    /// ∂F_i/∂T2 by the tension of the belt on the other side of the ring at b.
    pub beyond: [R; 6],
    /// ∂F_i/∂α by the angle of wrap of a belt at the ring at b, where that is measured between the segments.
    pub angle: [R; 6],
    /// ∂α/∂x of that angle: of the node where the first segment begins, the ring, and the node where the second one ends; global
    /// components.
    pub wrap: Option<[Vector<R>; 3]>,
    /// The components that have a reaction: constrained, or held by a stop, a lock, a prescribed motion or a rigid elasticity.
    pub reacting: Mask,
    /// The time step, where velocities are increments over it: then dF_i/du_j = ∂F_i/∂u_j + ∂F_i/∂v_j/Δt.
    pub time_step: Option<R>,
    /// ∂F_i/∂Δt at constant displacements: −Σ ∂F_i/∂v_j v_j/Δt of velocities that are increments, and that of friction whose
    /// coefficient depends on the slip rate.
    pub time: [R; 6],
    /// Why the slopes of a force are not known; they are zero then.
    pub unknown: Components<Unknown>,
}

impl<R: Differentiable> Tangent<R> {
    fn none(time_step: Option<R>) -> Self {
        let zero = R::ZERO;
        let matrix = [[zero; 6]; 6];
        Self {
            displacement: matrix,
            velocity: matrix,
            reaction: matrix,
            beyond: [zero; 6],
            angle: [zero; 6],
            wrap: None,
            reacting: [false; 6],
            time_step,
            time: [zero; 6],
            unknown: [None; 6],
        }
    }

    /// dF_i/du_j: with the velocity as a function of the displacement where it is an increment over a time step.
    pub fn total(&self) -> [[R; 6]; 6] {
        let inverse = self.time_step.map_or(R::ZERO, |step| R::integer(1) / step);
        let mut total = self.displacement;
        for (line, rates) in total.iter_mut().zip(&self.velocity) {
            for (entry, rate) in line.iter_mut().zip(rates) {
                *entry = *entry + *rate * inverse;
            }
        }
        total
    }

    /// Leaves out the row of a force.
    fn clear(&mut self, k: usize) {
        let zero = R::ZERO;
        for matrix in [&mut self.displacement, &mut self.velocity, &mut self.reaction] {
            matrix[k] = [zero; 6];
        }
        (self.beyond[k], self.angle[k], self.time[k]) = (zero, zero, zero);
    }
}

impl Behavior {
    /// CEF + CVF on any scalar. Unknown parts are left out.
    pub fn forces<S: Scalar>(&self, motion: &Motion<S>, conditions: &Conditions) -> [S; 6] {
        let elastic = self.elasticity.forces(motion, conditions).value;
        let viscous = self.damping.forces(motion, conditions).value;
        [0, 1, 2, 3, 4, 5].map(|k| elastic[k].unwrap_or(S::zero()) + viscous[k].unwrap_or(S::zero()))
    }

    /// The slopes of CEF + CVF alone, of the components that have not failed. `time_step` is that of velocities that are
    /// increments.
    pub fn tangent<R: Differentiable>(
        &self,
        motion: &Motion<R>,
        conditions: &Conditions,
        time_step: Option<R>,
        failed: Mask,
    ) -> Tangent<R> {
        let seeded = |values: &[R; 6], first: usize| {
            let seed = |k: usize| R::Gradient::<12>::seed(values[k], first + k);
            [seed(0), seed(1), seed(2), seed(3), seed(4), seed(5)]
        };
        let moving = Motion {
            position: seeded(&motion.position, 0),
            constitutive: seeded(&motion.constitutive, 0),
            velocity: seeded(&motion.velocity, 6),
        };
        let zero = R::ZERO;
        let mut tangent = Tangent::none(time_step);
        for (k, force) in
            self.forces(&moving, conditions).into_iter().enumerate().filter(|(k, _)| !failed[*k])
        {
            let slopes = force.gradient();
            tangent.displacement[k].copy_from_slice(&slopes[..6]);
            tangent.velocity[k].copy_from_slice(&slopes[6..]);
            if let Some(step) = time_step {
                let pairs = tangent.velocity[k].iter().zip(&motion.velocity);
                tangent.time[k] = -(pairs.fold(zero, |sum, (slope, v)| sum + *slope * *v) / step);
            }
        }
        tangent
    }

    /// The slopes of CTF at a state that followed `history`: springs, dampers, friction with its exact consistent tangent along
    /// the increment, and reactions.
    pub fn consistent_tangent(
        &self,
        outcome: &Outcome,
        conditions: &Conditions,
        history: &History,
    ) -> Tangent<f64> {
        let laws = self.tangent(&outcome.motion, conditions, outcome.time_step, history.failed);
        let mut tangent = laws.clone();
        let rigid = self.elasticity.rigid();
        tangent.reacting = [0, 1, 2, 3, 4, 5].map(|k| {
            let is_held = !matches!(outcome.held[k], None | Some(StopStatus::Free))
                || outcome.locked[k]
                || rigid[k]
                || outcome.prescribed[k].is_some();
            !outcome.failed[k] && (self.constrained[k] || (self.available[k] && is_held))
        });
        for k in (0..6).filter(|k| tangent.reacting[*k]) {
            tangent.reaction[k][k] = 1.0;
        }
        for (i, slip) in outcome.slips.iter().enumerate() {
            let slopes = self.slopes_of(i, slip, outcome, (conditions, history));
            for (k, slopes) in slopes.into_iter().enumerate() {
                let Some(slopes) = slopes else { continue };
                let Slopes { displacement, forces, duration, beyond, angle, wrap, unknown: missing } = slopes;
                tangent.angle[k] += angle;
                tangent.wrap = tangent.wrap.or(wrap);
                tangent.time[k] += duration;
                tangent.beyond[k] += beyond;
                for j in 0..6 {
                    tangent.displacement[k][j] += displacement[j];
                }
                // What presses is CEF + CVF + λ; a slope that it has, and that is not known, leaves this one unknown.
                let laws_of = [&outcome.elastic, &outcome.viscous];
                let unknown = |p: usize| {
                    laws_of.iter().find_map(|law| law.unknown[p].filter(|why| *why != Unknown::Rigid))
                };
                let lacking = (0..6).filter(|p| forces[*p] != 0.0 && !history.failed[*p]).find_map(unknown);
                tangent.unknown[k] = tangent.unknown[k].or(missing).or(lacking);
                for (p, force) in forces.into_iter().enumerate().filter(|(p, _)| !history.failed[*p]) {
                    if tangent.reacting[p] {
                        tangent.reaction[k][p] += force;
                    }
                    for j in 0..6 {
                        tangent.displacement[k][j] += force * laws.displacement[p][j];
                        tangent.velocity[k][j] += force * laws.velocity[p][j];
                    }
                    tangent.time[k] += force * laws.time[p];
                }
            }
        }
        for k in 0..6 {
            let parts = [&outcome.elastic, &outcome.viscous, &outcome.friction];
            let own = parts.iter().find_map(|part| part.unknown[k].filter(|why| *why != Unknown::Rigid));
            tangent.unknown[k] = own.or(tangent.unknown[k]);
            if outcome.failed[k] || tangent.unknown[k].is_some() {
                tangent.clear(k);
            }
        }
        tangent
    }

    /// The slopes of the forces of a friction, of the components that slide.
    fn slopes_of(
        &self,
        i: usize,
        slip: &Slip,
        outcome: &Outcome,
        (conditions, history): (&Conditions, &History),
    ) -> Components<Slopes> {
        let mut found = [None; 6];
        let (Some(state), Ok(_)) = (&slip.before, &slip.outcome) else { return found };
        if let Some(friction) = self.friction.frictions.get(i) {
            let input = slip.input(state, outcome.duration, &outcome.motion, conditions);
            let (_, tangent) = friction.tangent_while(state, &input, Branch::Decided, history.failed);
            for k in (0..6).filter(|k| slip.components[*k]) {
                let of = tangent.force[k];
                found[k] = Some(Slopes {
                    displacement: of.displacement,
                    forces: of.forces,
                    duration: of.duration,
                    beyond: 0.0,
                    angle: 0.0,
                    wrap: None,
                    unknown: None,
                });
            }
        } else if let (Some(belt), Some(Beyond { tension: Ok(tension), angle, wrap })) =
            (&self.friction.belt, slip.beyond)
        {
            let input = slip.belt_input((tension, angle), outcome.duration, conditions);
            let (outcome, tangent) = belt.tangent(state, &input, Branch::Decided);
            let mut slopes = Slopes {
                displacement: [0.0; 6],
                forces: [0.0; 6],
                duration: tangent.duration,
                beyond: tangent.tension[1],
                angle: if matches!(wrap, Wrap::Measured(_)) { tangent.angle } else { 0.0 },
                wrap: match wrap {
                    Wrap::Measured(gradient) => Some(gradient),
                    Wrap::Given | Wrap::Kink => None,
                },
                // In line nothing holds, and to all sides it would: that is no slope of zero.
                unknown: (wrap == Wrap::Kink && outcome.normal > 0.0).then_some(Unknown::WrapAngle),
            };
            (slopes.displacement[FLOW], slopes.forces[0]) = (tangent.flow, tangent.tension[0]);
            found[FLOW] = Some(slopes);
        }
        found
    }
}

/// The slopes of one friction force.
#[derive(Clone, Copy)]
struct Slopes {
    displacement: [f64; 6],
    /// By what presses.
    forces: [f64; 6],
    duration: f64,
    /// By the tension on the other side of the ring.
    beyond: f64,
    /// By the angle of wrap, where it is measured, and how that changes as nodes move.
    angle: f64,
    wrap: Option<[Vector<f64>; 3]>,
    /// Why they are not all that there are.
    unknown: Option<Unknown>,
}

impl Behavior {
    /// The laws of springs and dampers.
    fn laws(&self) -> impl Iterator<Item = &Law> {
        self.elasticity.laws().iter().chain(self.damping.laws())
    }

    /// The kinks of springs and dampers at which the motion lies.
    pub fn kinks<R: Real>(
        &self,
        motion: &Motion<R>,
        conditions: &Conditions,
    ) -> impl Iterator<Item = ForceKink<R>> {
        self.laws().flat_map(|law| law.kinks(motion, conditions))
    }

    /// What the rounding of each slope of springs and dampers is measured by: of ∂F_i/∂u_j, then of ∂F_i/∂v_j.
    pub fn slope_scales(&self, motion: &Motion<f64>, conditions: &Conditions) -> [[[f64; 6]; 6]; 2] {
        let mut scales = [[[0.0; 6]; 6]; 2];
        self.laws().for_each(|law| law.add_slope_scales(motion, conditions, &mut scales));
        scales
    }
}
