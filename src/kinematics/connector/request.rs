//! What to compute, and how much was computed.

use serde::Serialize;

crate::named! {
    /// A quantity that can be asked for.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
    pub enum Output {
        /// Position: e·d, l, α … from which stops are counted.
        CP = "CP",
        /// Displacement: position − initial position.
        CU = "CU",
        /// Constitutive displacement: position − reference.
        CCU = "CCU",
        /// Velocity.
        CV = "CV",
        /// Acceleration.
        CA = "CA",
        /// What each constrained component enforces to be zero.
        RES = "RES",
        /// The rate of the residual, J q̇.
        RESV = "RESV",
        /// The part of the residual's acceleration that is quadratic in the rates, J̇ q̇.
        RESB = "RESB",
        /// The acceleration of the residual, J q̈ + J̇ q̇.
        RESA = "RESA",
        /// Stop status.
        CSLST = "CSLST",
        /// Turn counts and principal angles.
        TURNS = "TURNS",
        /// Distance to the nearest singular point.
        MARGIN = "MARGIN",
        /// Total force.
        CTF = "CTF",
        /// Elastic force.
        CEF = "CEF",
        /// Viscous force.
        CVF = "CVF",
        /// Friction force.
        CSF = "CSF",
        /// Reaction of a constraint, stop, lock, prescribed motion.
        CRF = "CRF",
        /// Applied load.
        CCF = "CCF",
        /// Contact force of friction.
        CNF = "CNF",
        /// Accumulated slip.
        CASU = "CASU",
        /// Slip rate.
        CIVC = "CIVC",
        /// Whether friction sticks or slips.
        SLIP = "SLIP",
        /// Failure status.
        CFAILST = "CFAILST",
        /// What a connector motion prescribes.
        DRIVEN = "DRIVEN",
        /// Slopes of forces.
        TANGENT = "TANGENT",
        /// Moments as the manual prints them.
        PM = "PM",
        /// Multipliers of the equations enforced.
        LM = "LM",
        /// Nodal forces.
        NF = "NF",
        /// Geometric stiffness.
        KG = "KG",
        /// Derivative of the nodal forces.
        DNF = "DNF",
        /// Tangent of the nodal forces by displacements.
        KT = "KT",
        /// Tangent of the nodal forces by velocities.
        CT = "CT",
        /// Tangent of the nodal forces by reactions.
        KR = "KR",
    }
}

impl Output {
    /// Its bit in a set of outputs.
    #[inline(always)]
    const fn bit(self) -> u64 {
        const { assert!(Self::ALL.len() <= 64, "more outputs than bits") }
        1 << self as u64
    }

    /// Whether it is a number that an evaluation holds for each component: a position, a residual, a rate.
    pub const fn is_of_motion(self) -> bool {
        matches!(
            self,
            Self::CP
                | Self::CU
                | Self::CCU
                | Self::CV
                | Self::CA
                | Self::RES
                | Self::RESV
                | Self::RESB
                | Self::RESA
        )
    }

    /// Whether it is one of the manual's outputs of relative motion, which has a name of its own for rotations: CP and CPR.
    pub const fn is_kinematic(self) -> bool {
        matches!(self, Self::CP | Self::CU | Self::CCU | Self::CV | Self::CA | Self::CASU)
    }

    /// Whether it is a force or moment of a component, whose moments have a name of their own: CTF and CTM.
    pub const fn is_force(self) -> bool {
        matches!(self, Self::CTF | Self::CEF | Self::CVF | Self::CSF | Self::CRF | Self::CCF | Self::CNF)
    }

    /// Whether it follows from behaviour, motions and loads rather than from kinematics.
    pub const fn is_of_behavior(self) -> bool {
        self.is_force()
            || matches!(self, Self::CASU | Self::CIVC | Self::SLIP)
            || matches!(self, Self::CFAILST | Self::DRIVEN | Self::TANGENT)
    }

    /// Whether it follows from component forces.
    pub const fn is_of_forces(self) -> bool {
        matches!(self, Self::CTF | Self::PM | Self::LM) || self.is_nodal()
    }

    /// Whether it belongs to nodal degrees of freedom, rather than to components: asked for of a component, it is the part of that
    /// component's force.
    pub const fn is_nodal(self) -> bool {
        matches!(self, Self::NF | Self::KG | Self::DNF) || self.is_nodal_tangent()
    }

    /// Whether it is a part of the tangent of the nodal forces.
    pub const fn is_nodal_tangent(self) -> bool {
        matches!(self, Self::KT | Self::CT | Self::KR)
    }
}

/// The outputs that follow from component forces, a bit for each.
const OF_FORCES: u64 = {
    let (mut bits, mut i) = (0, 0);
    while i < Output::ALL.len() {
        if Output::ALL[i].is_of_forces() {
            bits |= Output::ALL[i].bit();
        }
        i += 1;
    }
    bits
};

/// A set of components, of u1, u2, u3, ur1, ur2, ur3.
pub type Mask = [bool; 6];

/// What to compute: outputs, each of some components, and derivatives.
///
/// ```
/// use pintle_kinematics::connector::{Output, Request};
/// let mut request = Request::nothing(1);
/// request.add(Output::CU, [true, false, false, false, false, false]);
/// request.add(Output::CP, [false, false, false, false, false, true]);
/// assert!(request.wants(Output::CU, 0) && !request.wants(Output::CU, 5));
/// assert_eq!(request.components(), [true, false, false, false, false, true]);
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Request {
    /// The outputs wanted of each component: a bit for each, in the order of [`Output::ALL`].
    wanted: [u64; 6],
    /// The components that are wanted at all: those of any output, and those whose rows of derivatives are wanted.
    components: Mask,
    /// The components whose rows of derivatives are wanted, from order 1 on.
    rows: Mask,
    /// 0: values; 1: also the Jacobian; 2: also second derivatives.
    pub order: u8,
}

impl Request {
    /// No output of any component.
    pub const fn nothing(order: u8) -> Self {
        Self { wanted: [0; 6], components: [false; 6], rows: [false; 6], order }
    }

    /// The same components of every output listed, with derivatives up to `order`. Without outputs, derivatives only.
    pub fn new(outputs: &[Output], components: Mask, order: u8) -> Self {
        let mut request = Self::nothing(order);
        request.add_rows(components);
        for output in outputs {
            request.add(*output, components);
        }
        request
    }

    /// Every output of every component, with derivatives up to `order`.
    pub fn everything(order: u8) -> Self {
        Self::new(&Output::ALL, [true; 6], order)
    }

    /// Adds components of an output, and their rows of derivatives.
    pub fn add(&mut self, output: Output, components: Mask) {
        for (k, wanted) in components.into_iter().enumerate() {
            self.wanted[k] |= u64::from(wanted) * output.bit();
        }
        self.add_rows(components);
    }

    /// Adds components of an output, without their rows of derivatives.
    pub fn add_values(&mut self, output: Output, components: Mask) {
        for (k, wanted) in components.into_iter().enumerate() {
            self.wanted[k] |= u64::from(wanted) * output.bit();
            self.components[k] |= wanted;
        }
    }

    /// Adds rows of derivatives of components, without any output.
    pub fn add_rows(&mut self, components: Mask) {
        for (k, wanted) in components.into_iter().enumerate() {
            self.components[k] |= wanted;
            self.rows[k] |= wanted;
        }
    }

    /// The components whose rows of derivatives are wanted, from order 1 on.
    pub const fn rows(&self) -> Mask {
        self.rows
    }

    /// The components that are wanted in any way.
    pub const fn components(&self) -> Mask {
        self.components
    }

    /// The outputs wanted of at least one component, in the order of [`Output::ALL`].
    pub fn outputs(&self) -> impl Iterator<Item = Output> + '_ {
        let wanted = self.wanted.iter().fold(0, |all, of| all | of);
        Output::ALL.into_iter().filter(move |output| wanted & output.bit() != 0)
    }

    /// Whether an output of component k (0-based) is wanted.
    pub const fn wants(&self, output: Output, k: usize) -> bool {
        self.wanted[k] & output.bit() != 0
    }

    /// Whether an output is wanted, of any component, that follows from component forces ([`Output::is_of_forces`]).
    pub fn wants_of_forces(&self) -> bool {
        self.wanted.iter().any(|wanted| wanted & OF_FORCES != 0)
    }

    #[inline(always)]
    pub(super) fn wants_any<const N: usize>(&self, outputs: [Output; N], k: usize) -> bool {
        self.wanted[k] & outputs.iter().fold(0, |bits, output| bits | output.bit()) != 0
    }
}

/// How often anything was computed: the proof that nothing else was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Tally {
    /// Measures evaluated for their value.
    pub values: u64,
    /// Measures evaluated with first derivatives.
    pub gradients: u64,
    /// Measures evaluated with second derivatives.
    pub hessians: u64,
    /// Measures evaluated along time.
    pub rates: u64,
    /// Histories followed: angles unwound, rotation vectors continued, one-forms accumulated.
    pub histories: u64,
    /// Components whose distance to singular sets was looked at.
    pub margins: u64,
    /// Rotations of nodes worked out.
    pub rotations: u64,
    /// Behaviours of connectors evaluated: springs, friction, stops, motions …
    pub behaviors: u64,
}

impl std::ops::AddAssign for Tally {
    fn add_assign(&mut self, more: Self) {
        let Self { values, gradients, hessians, rates, histories, margins, rotations, behaviors } = more;
        self.values += values;
        self.gradients += gradients;
        self.hessians += hessians;
        self.rates += rates;
        self.histories += histories;
        self.margins += margins;
        self.rotations += rotations;
        self.behaviors += behaviors;
    }
}
