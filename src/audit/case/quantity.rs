//! What is judged: the numbers of one evaluation, each with a name.

use pintle_kinematics::catalog::{COMPONENT, FORCE};
use pintle_kinematics::connector::{Components, Evaluation, Mask, Output, Request};
use pintle_kinematics::node::{DOF, DOFS, dof_size};
use serde::{Deserialize, Serialize};

/// A kind of number that a connector gives for each component.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// The residual of a constrained component, the displacement of any other.
    Value,
    /// Its row of first derivatives.
    FirstDerivatives,
    /// Its second derivatives; of a one-form, how its row changes.
    SecondDerivatives,
    /// Its rate.
    Rate,
    /// Its acceleration.
    Acceleration,
    /// The nodal forces of a unit force of the component, residual-side.
    NodalForces,
    /// Their derivatives: geometric stiffness per unit force.
    GeometricStiffness,
    /// P, F_C, F_N and Φ of a friction.
    FrictionCriterion,
    /// Their derivatives by the forces.
    FrictionGradient,
    /// Their second derivatives.
    FrictionHessian,
    /// What friction does in an increment: its forces, the slip, what presses.
    FrictionForce,
    /// The consistent tangent of an increment with friction.
    FrictionTangent,
    /// The slopes of elastic and viscous forces.
    BehaviorTangent,
    /// The slopes of all forces of a connector together: springs, dampers, reactions, and friction that they press.
    ConsistentTangent,
    /// The nodal forces of an element of springs.
    ElementForces,
    /// Their derivatives.
    ElementStiffness,
}

/// How many quantities there are.
const COUNT: usize = Quantity::ElementStiffness as usize + 1;

impl Quantity {
    /// Every quantity of a connector's components, in the order of reports.
    pub const ALL: [Self; 7] = [
        Self::Value,
        Self::FirstDerivatives,
        Self::SecondDerivatives,
        Self::Rate,
        Self::Acceleration,
        Self::NodalForces,
        Self::GeometricStiffness,
    ];

    /// Every quantity of behaviour and friction, in the order of reports.
    pub const OF_BEHAVIOR: [Self; 9] = [
        Self::FrictionCriterion,
        Self::FrictionGradient,
        Self::FrictionHessian,
        Self::FrictionForce,
        Self::FrictionTangent,
        Self::BehaviorTangent,
        Self::ConsistentTangent,
        Self::ElementForces,
        Self::ElementStiffness,
    ];

    /// In words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Value => "values",
            Self::FirstDerivatives => "first derivatives",
            Self::SecondDerivatives => "second derivatives",
            Self::Rate => "rates",
            Self::Acceleration => "accelerations",
            Self::NodalForces => "nodal forces",
            Self::GeometricStiffness => "geometric stiffness",
            Self::FrictionCriterion => "friction criteria",
            Self::FrictionGradient => "friction gradients",
            Self::FrictionHessian => "friction Hessians",
            Self::FrictionTangent => "friction tangents",
            Self::BehaviorTangent => "tangents of elastic and viscous forces",
            Self::FrictionForce => "friction forces and slip",
            Self::ConsistentTangent => "consistent tangents",
            Self::ElementForces => "element forces",
            Self::ElementStiffness => "element stiffness",
        }
    }

    /// The symbol, as headings of tables have it.
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::Value => "f",
            Self::FirstDerivatives => "∂f",
            Self::SecondDerivatives => "∂²f",
            Self::Rate => "ḟ",
            Self::Acceleration => "f̈",
            Self::NodalForces => "G",
            Self::GeometricStiffness => "∂G",
            Self::FrictionCriterion => "Φ",
            Self::FrictionGradient => "∂Φ",
            Self::FrictionHessian => "∂²Φ",
            Self::FrictionTangent => "∂F_f",
            Self::BehaviorTangent => "∂F",
            Self::FrictionForce => "F_f",
            Self::ConsistentTangent => "∂CTF",
            Self::ElementForces => "p",
            Self::ElementStiffness => "∂p",
        }
    }

    /// The number of entries per component; 0 for what is not by components.
    pub const fn entries(self) -> usize {
        match self {
            Self::Value | Self::Rate | Self::Acceleration => 1,
            Self::FirstDerivatives | Self::NodalForces => DOFS,
            Self::SecondDerivatives | Self::GeometricStiffness => DOFS * DOFS,
            _ => 0,
        }
    }

    /// The size of the degrees of freedom of entry `i`: s_j, or s_j s_k.
    pub fn entry_size(self, i: usize, length: f64) -> f64 {
        match self {
            Self::FirstDerivatives | Self::NodalForces => dof_size(i, length),
            Self::SecondDerivatives | Self::GeometricStiffness => {
                dof_size(i / DOFS, length) * dof_size(i % DOFS, length)
            }
            _ => 1.0,
        }
    }

    /// The name of entry `i` of component `k` (0-based): `ur1`, `∂ur1/∂θb3`, `∂²u2/∂xa1∂θa3`, `u̇1` as `d ur1/dt`.
    pub fn entry_name(self, k: usize, i: usize) -> String {
        let component = COMPONENT[k];
        match self {
            Self::Value => component.to_string(),
            Self::FirstDerivatives => format!("∂{component}/∂{}", DOF[i % DOFS]),
            Self::SecondDerivatives => {
                format!("∂²{component}/∂{}∂{}", DOF[i / DOFS % DOFS], DOF[i % DOFS])
            }
            Self::Rate => format!("d{component}/dt"),
            Self::Acceleration => format!("d²{component}/dt²"),
            Self::NodalForces => format!("{} on {}", FORCE[k], DOF[i % DOFS]),
            Self::GeometricStiffness => {
                format!("∂({} on {})/∂{}", FORCE[k], DOF[i / DOFS % DOFS], DOF[i % DOFS])
            }
            _ => format!("{} {component} {i}", self.symbol()),
        }
    }
}

/// A list that mostly holds one thing, and then needs no memory of its own.
#[derive(Clone, Debug)]
pub enum OneOrMany<T> {
    /// One.
    One([T; 1]),
    /// Any number.
    Many(Vec<T>),
}

impl<T> std::ops::Deref for OneOrMany<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        match self {
            Self::One(one) => one,
            Self::Many(many) => many,
        }
    }
}

impl<T> std::ops::DerefMut for OneOrMany<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        match self {
            Self::One(one) => one,
            Self::Many(many) => many,
        }
    }
}

impl<T> From<Vec<T>> for OneOrMany<T> {
    fn from(many: Vec<T>) -> Self {
        Self::Many(many)
    }
}

/// The entries of one quantity, component by component.
#[derive(Clone, Debug, PartialEq)]
pub struct Entries<T>(pub Components<Vec<T>>);

impl<T> Default for Entries<T> {
    fn default() -> Self {
        Self([const { None }; 6])
    }
}

impl<T: Copy> Entries<T> {
    /// Every entry with its component (0-based) and its place.
    pub fn iter(&self) -> impl Iterator<Item = (usize, usize, T)> + '_ {
        self.0.iter().enumerate().flat_map(|(k, entries)| {
            entries.iter().flatten().enumerate().map(move |(i, entry)| (k, i, *entry))
        })
    }

    /// One entry.
    pub fn get(&self, k: usize, i: usize) -> Option<T> {
        self.0.get(k)?.as_ref()?.get(i).copied()
    }

    /// The same entries, changed one by one.
    pub fn map<U>(&self, mut change: impl FnMut(usize, usize, T) -> U) -> Entries<U> {
        let mut found = Entries::default();
        for (k, entries) in self.0.iter().enumerate() {
            found.0[k] =
                entries.as_ref().map(|all| all.iter().enumerate().map(|(i, x)| change(k, i, *x)).collect());
        }
        found
    }

    /// The number of entries.
    pub fn len(&self) -> usize {
        self.0.iter().flatten().map(Vec::len).sum()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Everything that an audit judges of one evaluation.
#[derive(Clone, Debug, PartialEq)]
pub struct Numbers<T>([Entries<T>; COUNT]);

impl<T> Default for Numbers<T> {
    fn default() -> Self {
        Self(std::array::from_fn(|_| Entries::default()))
    }
}

impl<T: Copy> Numbers<T> {
    /// Of one evaluation, without forces. Rates are those of the residual where there is one.
    pub fn of(evaluation: &Evaluation<T>) -> Self {
        let one = |x: Option<T>| x.map(|x| vec![x]);
        let both = |first: &Components<T>, second: &Components<T>| {
            Entries(std::array::from_fn(|k| one(first[k].or(second[k]))))
        };
        let mut numbers = Self(std::array::from_fn(|_| Entries::default()));
        let row = |k: usize| evaluation.jacobian[k].map(|row| row.to_vec());
        let matrix = |k: usize| evaluation.hessian[k].as_ref().map(|h| h.as_flattened().to_vec());
        for (quantity, entries) in [
            (Quantity::Value, both(&evaluation.residual, &evaluation.displacement)),
            (Quantity::FirstDerivatives, Entries(std::array::from_fn(row))),
            (Quantity::SecondDerivatives, Entries(std::array::from_fn(matrix))),
            (Quantity::Rate, both(&evaluation.residual_rate, &evaluation.velocity)),
            (Quantity::Acceleration, both(&evaluation.residual_acceleration, &evaluation.acceleration)),
        ] {
            numbers.set(quantity, entries);
        }
        numbers
    }

    /// The entries of one quantity.
    pub const fn entries(&self, quantity: Quantity) -> &Entries<T> {
        &self.0[quantity as usize]
    }

    /// The same, to be changed.
    pub const fn entries_mut(&mut self, quantity: Quantity) -> &mut Entries<T> {
        &mut self.0[quantity as usize]
    }

    /// Replaces the entries of one quantity.
    pub fn set(&mut self, quantity: Quantity, entries: Entries<T>) {
        self.0[quantity as usize] = entries;
    }
}

/// What is asked of a connector for [`Numbers`].
pub fn request() -> Request {
    request_of([true; 6])
}

/// The same of some components.
pub fn request_of(components: Mask) -> Request {
    Request::new(
        &[Output::CU, Output::CV, Output::CA, Output::RES, Output::RESV, Output::RESA],
        components,
        2,
    )
}
