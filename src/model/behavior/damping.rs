//! `*CONNECTOR DAMPING`: forces over velocities.
//!
//! Linear, F_i = C_ii v_i or F_i = Σ C_ij v_j over the available components. Or a table over the component's own velocity and,
//! besides, positions or constitutive displacements of several components.
//!
//! Dampings of one component add, coupled ones and others.
//!
//! `TYPE=STRUCTURAL` is damping proportional to the displacement in a harmonic response, a complex stiffness D (1 + i s). It gives no
//! force in time, and none here; [`Damping::structural`] says that there is one.

use crate::behavior::law::{self, Driver, Law, merged};
use crate::behavior::{Conditions, Forces, Motion};
use pintle_kinematics::connector::Mask;
use pintle_kinematics::scalar::Scalar;
use pintle_scene as scene;
use pintle_scene::{DampingKind, Diagnostic, TableOptions};

/// All dampings of a behaviour.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Damping {
    laws: Vec<Law>,
    structural: usize,
}

impl Damping {
    /// The dampings that a deck gives, for a type with these available components.
    ///
    /// # Errors
    /// Tables out of order or incomplete; a component that is not available.
    pub fn new(
        given: &[scene::Damping],
        available: Mask,
        defaults: &TableOptions,
    ) -> Result<Self, Diagnostic> {
        let mut laws = Vec::new();
        let mut structural = 0;
        for damping in given {
            let options = [&damping.table, defaults];
            let law = Law::new(&damping.law, Driver::Velocity, available, options, damping.span)?;
            match damping.kind {
                DampingKind::Viscous => laws.push(law),
                DampingKind::Structural => structural += 1,
            }
        }
        Ok(Self { laws, structural })
    }

    /// The components that have a viscous force.
    pub fn components(&self) -> Mask {
        merged(self.laws.iter().map(Law::components))
    }

    /// The number of structural dampings.
    pub const fn structural(&self) -> usize {
        self.structural
    }

    /// CVF.
    pub fn forces<S: Scalar>(&self, motion: &Motion<S>, conditions: &Conditions) -> Forces<S> {
        let mut forces = Forces::none();
        self.laws.iter().for_each(|law| law.add(motion, conditions, &mut forces));
        forces
    }

    /// The power Σ CVF_k v_k that damping takes up.
    pub fn power<S: Scalar>(&self, motion: &Motion<S>, conditions: &Conditions) -> S {
        let forces = self.forces(motion, conditions).value;
        let pairs = forces.iter().zip(motion.velocity);
        pairs.fold(S::zero(), |sum, (force, v)| sum + v * force.unwrap_or(S::zero()))
    }

    /// The components whose force is a table over their own velocity, with the rows where its slope jumps.
    pub fn rows(&self) -> Vec<(usize, Vec<f64>)> {
        law::rows(&self.laws)
    }

    /// The laws, each by itself.
    pub(super) fn laws(&self) -> &[Law] {
        &self.laws
    }
}
