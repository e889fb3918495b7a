//! What a routine is asked, and what it may give.

use crate::candidate::sheet;
use crate::case::quantity::{Entries, Numbers, Quantity};
use crate::case::{Case, Step};
use pintle_kinematics::connector::{Components, NodalMatrix, NodalRow, State};
use pintle_kinematics::node::DOFS;

/// What a routine gives at a state: numbers of each component, `None` where the connector has no such component, or the routine none.
///
/// Columns are the fourteen degrees of freedom of the nodes, x, θ and Ψ of a, then of b; rotations vary spatially, δC = δθ^ C.
/// A pair of values and rows is one, too.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Given(pub(crate) Numbers<f64>, pub(super) Element);

/// What an element of springs gives as a whole.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Element {
    /// p.
    pub(super) forces: Option<NodalRow<f64>>,
    /// Its derivatives, row by row.
    pub(super) stiffness: Option<NodalMatrix<f64>>,
}

/// What the stiffness of an element is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tangent {
    /// ∂p_i/∂q_j along spatial rotations, as Newton's method takes it: not symmetric where moments act.
    #[default]
    OfForces,
    /// The symmetric second derivatives of the energy along exp(δθ^) C.
    OfEnergy,
}

impl From<(Components<f64>, Components<NodalRow<f64>>)> for Given {
    fn from((values, rows): (Components<f64>, Components<NodalRow<f64>>)) -> Self {
        Self::default().values(values).rows(rows)
    }
}

impl From<Numbers<f64>> for Given {
    fn from(numbers: Numbers<f64>) -> Self {
        Self(numbers, Element::default())
    }
}

impl Given {
    /// No number where there should be some: what a routine gives at a state at which it failed.
    pub fn nothing(wants: &[Quantity], components: [bool; 6]) -> Self {
        let mut given = Self::default();
        for quantity in wants {
            match quantity {
                Quantity::ElementForces => given.1.forces = Some([f64::NAN; DOFS]),
                Quantity::ElementStiffness => given.1.stiffness = Some(Box::new([[f64::NAN; DOFS]; DOFS])),
                _ => {
                    let of = |has: bool| has.then(|| vec![f64::NAN; quantity.entries()]);
                    given.0.set(*quantity, Entries(components.map(of)));
                }
            }
        }
        given
    }

    fn scalars(mut self, quantity: Quantity, of: Components<f64>) -> Self {
        self.0.set(quantity, Entries(of.map(|x| x.map(|x| vec![x]))));
        self
    }

    fn lines(mut self, quantity: Quantity, of: Components<NodalRow<f64>>) -> Self {
        self.0.set(quantity, Entries(of.map(|row| row.map(|row| row.to_vec()))));
        self
    }

    fn matrices(mut self, quantity: Quantity, of: Components<NodalMatrix<f64>>) -> Self {
        self.0.set(quantity, Entries(of.map(|matrix| matrix.map(|matrix| matrix.as_flattened().to_vec()))));
        self
    }

    /// The residual of each constrained component, the displacement of any other (length, or rad).
    ///
    /// A one-form, as of FLOW-CONVERTER and RETRACTOR, has a row that is the derivative of no function of the state. What it sums up
    /// follows from the path, and its value may be `None`.
    #[must_use]
    pub fn values(self, values: Components<f64>) -> Self {
        self.scalars(Quantity::Value, values)
    }

    /// ∂c_k/∂q_j.
    #[must_use]
    pub fn rows(self, rows: Components<NodalRow<f64>>) -> Self {
        self.lines(Quantity::FirstDerivatives, rows)
    }

    /// ∂²c_k/∂q_i∂q_j, symmetric: along exp(δθ^) C.
    #[must_use]
    pub fn second_derivatives(self, matrices: Components<NodalMatrix<f64>>) -> Self {
        self.matrices(Quantity::SecondDerivatives, matrices)
    }

    /// ċ_k at the velocities of the state.
    #[must_use]
    pub fn rates(self, rates: Components<f64>) -> Self {
        self.scalars(Quantity::Rate, rates)
    }

    /// c̈_k at the velocities and accelerations of the state.
    #[must_use]
    pub fn accelerations(self, accelerations: Components<f64>) -> Self {
        self.scalars(Quantity::Acceleration, accelerations)
    }

    /// The nodal forces and moments of a unit force of each component: F_k = 1 does the work F_k δu_k = G_k·δq.
    #[must_use]
    pub fn nodal_forces(self, rows: Components<NodalRow<f64>>) -> Self {
        self.lines(Quantity::NodalForces, rows)
    }

    /// How these change at a constant force: ∂G_ki/∂q_j along exp(δθ^) C, symmetric where G_k is the gradient of a displacement.
    #[must_use]
    pub fn geometric_stiffness(self, matrices: Components<NodalMatrix<f64>>) -> Self {
        self.matrices(Quantity::GeometricStiffness, matrices)
    }

    /// p_j = Σ_k D_k c_k ∂c_k/∂q_j: the nodal forces and moments of springs D_k ([`super::Candidate::springs`]) along the values c_k.
    #[must_use]
    pub fn element_forces(mut self, forces: NodalRow<f64>) -> Self {
        self.1.forces = Some(forces);
        self
    }

    /// How these change: by row the force, by column the degree of freedom ([`Tangent`] says along what).
    #[must_use]
    pub fn element_stiffness(mut self, stiffness: NodalMatrix<f64>) -> Self {
        self.1.stiffness = Some(stiffness);
        self
    }

    /// Values, rows and all else but what an element of springs gives as a whole.
    pub const fn numbers(&self) -> &Numbers<f64> {
        &self.0
    }

    /// As they are compared where whole turns of angles are no error: angles on the sheet of the right ones, columns of the ground zero.
    #[must_use]
    pub fn on_sheet_of(mut self, case: &Case) -> Self {
        self.without_ground(case.definition.moves);
        self.continue_angles(case);
        self
    }

    /// Whether its angles are others of the same rotation, by more than whole turns of each.
    pub fn is_on_another_sheet(&self, case: &Case) -> bool {
        sheet::is_another(case, self, None)
    }

    /// Without columns of the ground, which a routine need not know of.
    pub(super) fn without_ground(&mut self, moves: [bool; 2]) {
        let is_ground = |j: usize| !moves[usize::from(j >= DOFS / 2)];
        if moves == [true; 2] {
            return;
        }
        for (quantity, is_matrix) in [
            (Quantity::FirstDerivatives, false),
            (Quantity::NodalForces, false),
            (Quantity::SecondDerivatives, true),
            (Quantity::GeometricStiffness, true),
        ] {
            for entries in self.0.entries_mut(quantity).0.iter_mut().flatten() {
                for (i, entry) in entries.iter_mut().enumerate() {
                    let of_ground = is_ground(i % DOFS) || (is_matrix && is_ground(i / DOFS % DOFS));
                    if of_ground && entry.is_finite() {
                        *entry = 0.0;
                    }
                }
            }
        }
    }

    /// Without the components, and without what is not wanted.
    #[must_use]
    pub fn only(mut self, wants: &[Quantity], components: [bool; 6]) -> Self {
        for quantity in Quantity::ALL {
            let mut entries = std::mem::take(self.0.entries_mut(quantity));
            for (k, of) in entries.0.iter_mut().enumerate() {
                if !components[k] || !wants.contains(&quantity) {
                    *of = None;
                }
            }
            self.0.set(quantity, entries);
        }
        self.1.forces = self.1.forces.filter(|_| wants.contains(&Quantity::ElementForces));
        self.1.stiffness = self.1.stiffness.filter(|_| wants.contains(&Quantity::ElementStiffness));
        self
    }
}

/// What a routine is asked.
#[derive(Clone, Copy, Debug)]
pub struct Question<'a> {
    /// Where in the order of states: those beside a drawn state, for differences, have its number.
    pub number: usize,
    /// The state, and the increment that leads to it.
    pub step: &'a Step,
    /// The states from the initial one up to the one before.
    pub path: &'a [Step],
    /// What is right at the one before: residuals of constrained components, displacements of others. Angles go on from there.
    pub values_before: Components<f64>,
    /// What is wanted, of what the routine offers.
    pub wants: &'a [Quantity],
    /// Whether it was drawn, and is not one beside such a state, for differences.
    pub is_drawn: bool,
}

impl Question<'_> {
    /// The state.
    pub const fn state(&self) -> &State<f64> {
        &self.step.state
    }

    /// The state before it; `None` where that is the initial one.
    pub fn before(&self) -> Option<&State<f64>> {
        self.path.last().map(|step| &step.state)
    }
}
