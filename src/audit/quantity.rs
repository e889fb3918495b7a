//! What is judged: the numbers of one evaluation, each with a name.

use super::case::{Case, dof_size};
use crate::catalog::COMPONENT;
use crate::connector::{Components, Evaluation, Output, Request};
use crate::node::{DOF, DOFS};
use serde::{Deserialize, Serialize};

/// A kind of number that a connector gives for each component.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
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
}

impl Quantity {
    /// Every quantity, in the order of reports.
    pub const ALL: [Self; 5] =
        [Self::Value, Self::FirstDerivatives, Self::SecondDerivatives, Self::Rate, Self::Acceleration];

    /// In words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Value => "values",
            Self::FirstDerivatives => "first derivatives",
            Self::SecondDerivatives => "second derivatives",
            Self::Rate => "rates",
            Self::Acceleration => "accelerations",
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
        }
    }

    /// The number of entries per component.
    pub const fn entries(self) -> usize {
        match self {
            Self::Value | Self::Rate | Self::Acceleration => 1,
            Self::FirstDerivatives => DOFS,
            Self::SecondDerivatives => DOFS * DOFS,
        }
    }

    /// The size of the degrees of freedom of entry `i`: s_j, or s_j s_k.
    pub fn entry_size(self, i: usize, length: f64) -> f64 {
        match self {
            Self::FirstDerivatives => dof_size(i, length),
            Self::SecondDerivatives => dof_size(i / DOFS, length) * dof_size(i % DOFS, length),
            Self::Value | Self::Rate | Self::Acceleration => 1.0,
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
        }
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
#[derive(Clone, Debug)]
pub struct Numbers<T>([Entries<T>; Quantity::ALL.len()]);

impl<T> Default for Numbers<T> {
    fn default() -> Self {
        Self(std::array::from_fn(|_| Entries::default()))
    }
}

impl<T: Copy> Numbers<T> {
    /// Of one evaluation. Rates are those of the residual where there is one.
    pub fn of(evaluation: &Evaluation<T>) -> Self {
        let one = |x: Option<T>| x.map(|x| vec![x]);
        let both = |first: &Components<T>, second: &Components<T>| {
            Entries(std::array::from_fn(|k| one(first[k].or(second[k]))))
        };
        Self([
            both(&evaluation.residual, &evaluation.displacement),
            Entries(std::array::from_fn(|k| evaluation.jacobian[k].map(|row| row.to_vec()))),
            Entries(std::array::from_fn(|k| {
                evaluation.hessian[k].as_ref().map(|h| h.as_flattened().to_vec())
            })),
            both(&evaluation.residual_rate, &evaluation.velocity),
            both(&evaluation.residual_acceleration, &evaluation.acceleration),
        ])
    }

    /// The entries of one quantity.
    pub const fn entries(&self, quantity: Quantity) -> &Entries<T> {
        &self.0[quantity as usize]
    }

    /// Replaces the entries of one quantity.
    pub fn set(&mut self, quantity: Quantity, entries: Entries<T>) {
        self.0[quantity as usize] = entries;
    }
}

/// What is asked of a connector for [`Numbers`].
pub fn request() -> Request {
    Request::new(&[Output::CU, Output::CV, Output::CA, Output::RES, Output::RESV, Output::RESA], [true; 6], 2)
}

/// What the product gives at the end of a case; `None` for an empty path.
pub fn product(case: &Case) -> Option<Numbers<f64>> {
    case.evaluation(&request()).map(|(evaluation, _)| Numbers::of(&evaluation))
}
