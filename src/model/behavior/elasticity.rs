//! `*CONNECTOR ELASTICITY`: forces over constitutive displacements.
//!
//! Linear, `F_i = D_ii u_i` or `F_i = Σ D_ij u_j` over the available components, with u the displacement from the constitutive
//! reference (CCU). Or a table over the component's own displacement, or over positions or constitutive displacements of several
//! components. A table need not pass through zero.
//!
//! *Several.* Elasticities of one component add, coupled ones and others.
//!
//! *Frequency.* Coefficients that depend on the frequency are taken at zero frequency, as in every procedure that is not a harmonic
//! response.
//!
//! *RIGID.* The solver chooses a stiff spring, of a stiffness that is not documented. Here the component is kept at its
//! reference: its residual is CCU, and its elastic force is what a given total force leaves for it; motions alone do not tell it.

use crate::behavior::law::{self, Driver, Law, merged};
use crate::behavior::{Conditions, Forces, Motion};
use pintle_kinematics::connector::Mask;
use pintle_kinematics::scalar::Scalar;
use pintle_scene as scene;
use pintle_scene::{Diagnostic, TableOptions};

/// All elasticities of a behaviour.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Elasticity {
    laws: Vec<Law>,
}

impl Elasticity {
    /// The elasticities that a deck gives, for a type with these available components.
    ///
    /// # Errors
    /// Tables out of order or incomplete; a component that is not available.
    pub fn new(
        given: &[scene::Elasticity],
        available: Mask,
        defaults: &TableOptions,
    ) -> Result<Self, Diagnostic> {
        let mut laws = Vec::with_capacity(given.len());
        for elasticity in given {
            let options = [&elasticity.table, defaults];
            let law = Law::new(&elasticity.law, Driver::Displacement, available, options, elasticity.span)?;
            laws.push(law);
        }
        Ok(Self { laws })
    }

    /// The components that have an elastic force.
    pub fn components(&self) -> Mask {
        merged(self.laws.iter().map(Law::components))
    }

    /// The components that are kept at their reference.
    pub fn rigid(&self) -> Mask {
        merged(self.laws.iter().filter(|law| law.is_rigid()).map(Law::components))
    }

    /// CEF.
    pub fn forces<S: Scalar>(&self, motion: &Motion<S>, conditions: &Conditions) -> Forces<S> {
        let mut forces = Forces::none();
        self.laws.iter().for_each(|law| law.add(motion, conditions, &mut forces));
        forces
    }

    /// The elastic energy W taken up from the reference, ∂W/∂u_k = CEF_k. `None` where the forces have no potential: an unsymmetric
    /// matrix, or a force over the motion of another component.
    pub fn energy<S: Scalar>(&self, motion: &Motion<S>, conditions: &Conditions) -> Option<S> {
        let energies = self.laws.iter().map(|law| law.potential(motion, conditions));
        energies.into_iter().try_fold(S::zero(), |sum, energy| Some(sum + energy?))
    }

    /// The components whose force is a table over their own displacement, with the rows where its slope jumps.
    pub fn rows(&self) -> Vec<(usize, Vec<f64>)> {
        law::rows(&self.laws)
    }

    /// The laws, each by itself.
    pub(super) fn laws(&self) -> &[Law] {
        &self.laws
    }
}
