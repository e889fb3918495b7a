//! What laws demand: which law, what it claims of which entry, and in which words.

use crate::case::quantity::Quantity;
use pintle_kinematics::catalog::{COMPONENT, FORCE};
use pintle_kinematics::node::DOFS;
use serde::{Deserialize, Serialize};
use std::fmt::{self, Display, Formatter};

pintle_kinematics::named! {
    /// A law.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
    #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
    #[serde(rename_all = "kebab-case")]
    pub enum Invariant {
        /// The six rigid modes are in the kernel of every row, at every state: second derivatives along them are those of the motion alone.
        RigidModes = "rigid modes in the kernel",
        /// Axes turned with everything change no value and no rate, and turn rows and second derivatives.
        Frame = "frame equivariance",
        /// The nodal forces of each component are in equilibrium, moments about any point included.
        Equilibrium = "equilibrium of nodal forces",
        /// Rates are J q̇, accelerations J q̈ + q̇ᵀ H q̇; and the power of the nodal forces is that of the component forces, each with
        /// the rate that it is conjugate to.
        Power = "power identity",
        /// Second derivatives are symmetric.
        Symmetry = "symmetry of second derivatives",
        /// Derivatives that the declaration says are zero are zero.
        Sparsity = "declared sparsity",
        /// Exchanged nodes give what the declaration of each measure says (`Measure::exchanged`).
        NodeSwap = "exchanged nodes",
        /// An assembled type gives what its halves give, bit for bit.
        Halves = "assembly equals its halves",
        /// A history saved and restored gives the same, bit for bit.
        Restored = "restored history",
        /// A part of the request gives that part of the whole, bit for bit.
        Restricted = "restricted request",
        /// At the initial state nothing has moved.
        Start = "zero at the start",
        /// Turns are counted through ±π and 2πk, either way.
        Turns = "turns through ±π and 2πk",
        /// e1a·e2b = 0 and its family: a turn about the free axis, however far, leaves the printed constraints met.
        FreeAxis = "turns about the free axis",
        /// What a friction remembers at a state is what it left at the state before, and its increment is what lies between the two.
        Carried = "friction from state to state",
    }
}

/// What is demanded, written when somebody reads it.
#[derive(Clone, Debug)]
pub enum What {
    /// A sentence: of a law of types, or of a constraint.
    Said(String),
    /// Of the numbers of a connector at one state.
    Of(Demanded),
}

/// Which demand of a law at one state it is, whatever words it is told in: what is claimed of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Demanded {
    /// What is claimed.
    pub claim: Claim,
    /// The kind of number.
    pub quantity: Quantity,
    /// The component (0-based).
    pub component: usize,
    /// The place within it; of rigid motions the axis, of second derivatives along them the axis in the row.
    pub entry: usize,
}

/// What a law claims of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Claim {
    /// A row vanishes along a translation of everything.
    Translation,
    /// A row vanishes along a rotation of everything.
    Rotation,
    /// A rate, or an acceleration, is that along the rows.
    AlongRows,
    /// Nodal forces have the power of the component force.
    Power,
    /// Turned axes give the same, turned.
    TurnedAxes,
    /// ∂²/∂q_j∂q_k is ∂²/∂q_k∂q_j.
    Symmetry,
    /// It is declared zero.
    DeclaredZero,
    /// Exchanged nodes give the same, but for a sign.
    ExchangedNodes,
    /// The half of an assembled type gives the same.
    Half,
    /// A restored history gives the same.
    RestoredHistory,
    /// The component asked for alone gives the same.
    Alone,
    /// Values and first derivatives asked for alone are the same.
    WithoutRates,
}

impl Display for What {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Said(sentence) => f.write_str(sentence),
            Self::Of(demanded) => demanded.fmt(f),
        }
    }
}

impl Display for Demanded {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { claim, quantity, component: k, entry } = *self;
        let name = quantity.entry_name(k, entry);
        let is_of_forces = quantity == Quantity::NodalForces;
        match claim {
            Claim::Translation | Claim::Rotation if quantity == Quantity::SecondDerivatives => {
                let row = Quantity::FirstDerivatives.entry_name(k, entry / DOFS);
                let motion = if claim == Claim::Translation { "translation" } else { "rotation" };
                write!(f, "∂({row}) along a {motion}")
            }
            Claim::Translation if is_of_forces => write!(f, "nodal forces of {}", FORCE[k]),
            Claim::Translation => write!(f, "∂{} along a translation", COMPONENT[k]),
            Claim::Rotation if is_of_forces => write!(f, "nodal moments of {}", FORCE[k]),
            Claim::Rotation => write!(f, "∂{} along a rotation", COMPONENT[k]),
            Claim::AlongRows if quantity == Quantity::Rate => write!(f, "{name} is J q̇"),
            Claim::AlongRows => write!(f, "{name} is J q̈ + q̇ᵀ H q̇"),
            Claim::Power => write!(f, "power of the nodal forces of {}", FORCE[k]),
            Claim::TurnedAxes => write!(f, "{name} in turned axes"),
            Claim::Symmetry => write!(f, "symmetry of {name}"),
            Claim::DeclaredZero => write!(f, "{name} is declared zero"),
            Claim::ExchangedNodes => write!(f, "{name} with exchanged nodes"),
            Claim::Half => write!(f, "{name} of its half"),
            Claim::RestoredHistory => write!(f, "{name} after a restored history"),
            Claim::Alone => write!(f, "{name} asked for alone"),
            Claim::WithoutRates => write!(f, "{name} asked for without rates"),
        }
    }
}

impl What {
    /// A claim on an entry of a component (0-based).
    pub(crate) const fn of(claim: Claim, quantity: Quantity, component: usize, entry: usize) -> Self {
        Self::Of(Demanded { claim, quantity, component, entry })
    }

    /// What is demanded of one state, as data.
    pub const fn demanded(&self) -> Option<Demanded> {
        match self {
            Self::Said(_) => None,
            Self::Of(demanded) => Some(*demanded),
        }
    }
}
