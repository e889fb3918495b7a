//! The mathematics: scalar functions of the two nodes, each written once, generic over the scalar.
//!
//! A [`Measure`] is a function of the relative pair ([`Relative`]): e1a·d, a length, an angle. It knows its formula, unit,
//! what it depends on, its period, and how far a state is from the points where it or its derivatives do not exist. One
//! exception is a *one-form* ([`Measure::FlowConversion`]): its rate is given, its value is what the rate accumulates.

pub(crate) mod formula;
#[cfg(test)]
mod tests;

use crate::node;
use crate::node::{DOFS, Dependence, NodalRates, Pair, Relative};
use crate::scalar::elementary::{norm, ratio};
use crate::scalar::{Real, Scalar, each, unrolled};
use crate::so3;
use crate::vector;
use crate::vector::{Matrix, Vector, add, column, dot, scale, sub};
use serde::Serialize;

/// A scalar measure of two nodes. Indices are 1-based, as the manual's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Measure {
    /// e_i^a · d, the coordinate of b in the frame carried by a (length). CARTESIAN, JOIN, SLOT, SLIDE-PLANE.
    Position(usize),
    /// |d| (length). AXIAL, LINK.
    Distance,
    /// e_i^a · d (length); its rates are the nodal ones resolved in b. ACCELEROMETER.
    PositionAtB(usize),
    /// e_i · d with the directions e_i halfway between those of a and b ([`so3::mid_frame`]) (length). PROJECTION CARTESIAN.
    ProjectedPosition(usize),
    /// √((e1a·d)² + (e2a·d)²), the distance from the axis e3a (length). RADIAL-THRUST.
    RadialDistance,
    /// |d| / (l₀ + Ψ_a − Ψ_b) − 1, the strain of a belt segment whose material is l₀ long at first (–). SLIPRING.
    Strain,
    /// Ψ_a (1) or Ψ_b (2), the material flow at a node (length). SLIPRING.
    Flow(usize),
    /// e_i^a · e_j^b (–). The printed constraints of REVOLUTE and UNIVERSAL.
    Cosine(usize, usize),
    /// The Cardan angle α (1), β (2) or γ (3) of Q = Rx(α) Ry(β) Rz(γ) (rad).
    Cardan(usize),
    /// The Euler angle α (1), β (2) or γ (3) of Q = Rz(α) Rx(β) Rz(γ) (rad).
    Euler(usize),
    /// α, the angle between e3a and e3b (rad), in [0, π]. FLEXION-TORSION.
    Flexion,
    /// β, the angle by which b is twisted about the shaft e3 (rad) ([`so3::torsion`]). FLEXION-TORSION, CONSTANT VELOCITY.
    Torsion,
    /// θ, the direction in the plane e1a, e2a of the axis about which the shaft is bent (rad). FLEXION-TORSION.
    Sweep,
    /// α_i = α q·e_i, the flexion α about q resolved in the mid directions e1, e2 (rad). PROJECTION FLEXION-TORSION.
    ComponentFlexion(usize),
    /// φ_i, the component along e_i^a of the rotation vector that turns a's directions into b's (rad). ROTATION.
    RotationVector(usize),
    /// e_i^b · φ (rad), equal to e_i^a · φ; its rates are the nodal ones resolved in b. ROTATION-ACCELEROMETER.
    RotationVectorAtB(usize),
    /// The component along e_i^a of the rotation vector of Q Q₀ᵀ, Q₀ the initial Q (rad): zero while b keeps its orientation
    /// relative to a. The constraint of ALIGN, regular at any frozen angles.
    Misalignment(usize),
    /// The accumulated e3a·(δθ_a − δθ_b) − β_s δΨ_b (rad): a one-form, in general not integrable. FLOW-CONVERTER.
    FlowConversion,
}

/// The distance from a lock (rad) within which rounding decides the angles, a few roundings of the entries of Q. Nothing of the direction across
/// the axes is left, and a state counts as locked (`Measure::unlocked`). Of a radius the same part of the distance of the nodes.
pub const LOCK: f64 = 2e-15;

/// The unit of a measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Unit {
    /// A length, in the unit of the scene.
    Length,
    /// Radians.
    Angle,
    /// A pure number.
    None,
}

/// What happens to a measure at the points where it, or a derivative, does not exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum SingularClass {
    /// The value continues, the first derivatives jump with the direction of approach.
    Kink,
    /// Derivatives grow without bound as the point is approached.
    TrueSingularity,
    /// A principal value jumps by a period; the continued value does not.
    BranchCut,
    /// The value jumps to its opposite, and with either sign the first derivatives jump with the direction of approach.
    Reversal,
    /// A formula is 0/0 there, or a principal value jumps that is continued: value and derivatives have limits, and are these.
    Removable,
}

/// A set of points where a measure, or a derivative of it, does not exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct SingularSet {
    /// The set, as a condition on the state.
    pub at: &'static str,
    /// What happens there.
    pub class: SingularClass,
    /// What the distance to it is measured in.
    pub distance: &'static str,
    /// The unit of that distance.
    pub unit: Unit,
}

/// The distance of a state to the nearest singular point of a measure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Margin {
    /// The distance, in [`SingularSet::unit`]; 0 on the set.
    pub distance: f64,
    /// The set.
    pub set: SingularSet,
}

/// What a component is when the nodes are exchanged ([`Measure::exchanged`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exchanged {
    /// A sum of measures of the same connector with these factors, but for a constant.
    Sum([Option<(Measure, f64)>; 2]),
    /// That component (1-based) of −Q₀ᵀ times the vector of which the measures are components, Q₀ the initial orientation of b relative
    /// to a.
    Frozen(usize),
    /// Nothing that the components of the connector tell, and why.
    None(&'static str),
}

/// The data of one connector that measures refer to.
#[derive(Clone, Copy, Debug)]
pub struct Section<R> {
    /// Q₀, the initial orientation of b relative to a.
    pub initial_orientation: Matrix<R>,
    /// |X_b − X_a|, the initial length of a belt segment.
    pub initial_length: R,
    /// The direction, global components and fixed in space, that stands in for (x_b − x_a)/|x_b − x_a| while the nodes of an
    /// AXIAL coincide. Zero where none was given.
    pub fixed_direction: Vector<R>,
    /// β_s, the factor of material flow at b in FLOW-CONVERTER (rad/length): 1/radius of the drum.
    pub flow_scale: R,
}

/// What several measures of one connector share at one state, each part computed at most once.
pub struct Shared<'a, S: Scalar> {
    relative: &'a Relative<S>,
    section: &'a Section<S::Real>,
    history: &'a History<S::Real>,
    /// The triad of a, for directions fixed in space.
    triad_a: &'a Matrix<S::Real>,
    rotation_vector: Option<Vector<S>>,
    /// How clearly the rotation vector is principal, where it is taken to be ([`Shared::principal`]).
    nearness: Option<S::Real>,
    takes_principal: bool,
    misalignment: Option<Vector<S>>,
    mid_frame: Option<Matrix<S>>,
    component_flexions: Option<[S; 2]>,
}

/// What the past decides about the present value of a measure.
#[derive(Clone, Copy, Debug)]
pub struct History<R> {
    /// The last well-conditioned rotation vector ([`so3::continuous_log`]).
    pub rotation_vector: Vector<R>,
    /// The sign s = ±1 of sin β on the sheet of the Euler angles.
    pub euler_sign: R,
    /// The whole turns of torsion, an integer.
    pub torsion_turns: R,
}

impl<'a, S: Scalar> Shared<'a, S> {
    /// Nothing computed yet of a relative motion; `triad_a` has the axes of node a as columns.
    #[inline(always)]
    pub fn new(
        relative: &'a Relative<S>,
        triad_a: &'a Matrix<S::Real>,
        section: &'a Section<S::Real>,
        history: &'a History<S::Real>,
    ) -> Self {
        Shared {
            relative,
            section,
            history,
            triad_a,
            rotation_vector: None,
            nearness: None,
            takes_principal: false,
            misalignment: None,
            mid_frame: None,
            component_flexions: None,
        }
    }

    /// The same with the principal rotation vector, as a first attempt: [`Shared::is_continued`] tells whether that holds.
    #[inline(always)]
    pub(crate) fn principal(mut self) -> Self {
        self.takes_principal = true;
        self
    }

    /// Whether the rotation vector, if it has been asked for, is on the sheet that continues the history.
    #[inline(always)]
    pub(crate) fn is_continued(&self) -> bool {
        self.nearness.is_none_or(|nearness| S::Real::shortcut_where_positive(|| nearness))
    }

    #[inline(always)]
    fn rotation_vector(&mut self) -> Vector<S> {
        if let Some(known) = self.rotation_vector {
            return known;
        }
        let Relative { q, spin, .. } = self.relative;
        if self.takes_principal {
            let (phi, nearness) = so3::principal_log_along(q, *spin, self.history.rotation_vector);
            (self.rotation_vector, self.nearness) = (Some(phi), Some(nearness));
            return phi;
        }
        let phi = so3::continuous_log_along(q, *spin, self.history.rotation_vector).phi;
        self.rotation_vector = Some(phi);
        phi
    }

    #[inline(always)]
    fn misalignment(&mut self) -> Vector<S> {
        if let Some(known) = self.misalignment {
            return known;
        }
        let mut frozen = [[S::zero(); 3]; 3];
        each!(S, i < 3, {
            each!(S, j < 3, {
                let row = self.section.initial_orientation[j];
                frozen[i][j] = vector::dot_real(row, self.relative.q[i]);
            })
        });
        let phi = so3::log_along(&frozen, self.relative.spin);
        self.misalignment = Some(phi);
        phi
    }

    #[inline(always)]
    fn mid_frame(&mut self) -> Matrix<S> {
        if let Some(known) = self.mid_frame {
            return known;
        }
        let Relative { q, spin, .. } = self.relative;
        let frame = so3::mid_frame(q, *spin, self.history.torsion_turns);
        self.mid_frame = Some(frame);
        frame
    }
}

/// The entry i (1-based) of three. By cases: what is indexed by a number that is not known must lie in memory, whole.
#[inline(always)]
fn picked<T>([first, second, third]: [T; 3], i: usize) -> T {
    match i {
        1 => first,
        2 => second,
        _ => third,
    }
}

/// |d|, or where that is zero the component of d along a fixed direction. Lanes come here where one of them may be: a function of its
/// own keeps the rest of theirs in vectors.
#[cold]
#[inline(never)]
fn length_or_along<S: Scalar>(length: S, fixed: Vector<S::Real>, d: Vector<S>) -> S {
    let has_length = || S::Real::ZERO.less(length.real());
    let [distance] = S::joined(|| [S::Real::choose(has_length(), || length, || vector::dot_real(fixed, d))]);
    distance
}

/// The formulas: principal values on any scalar.
impl<S: Scalar> Shared<'_, S> {
    /// [`Measure::Position`].
    #[inline(always)]
    pub(crate) fn coordinate(&mut self, i: usize) -> S {
        picked(self.relative.d, i)
    }

    /// [`Measure::ProjectedPosition`].
    #[inline(always)]
    pub(crate) fn projected(&mut self, i: usize) -> S {
        dot(column(&self.mid_frame(), i - 1), self.relative.d)
    }

    /// [`Measure::RadialDistance`].
    #[inline(always)]
    pub(crate) fn radius(&mut self) -> S {
        norm([self.relative.d[0], self.relative.d[1]])
    }

    /// [`Measure::Flexion`].
    #[inline(always)]
    pub(crate) fn flexion(&mut self) -> S {
        so3::flexion(&self.relative.q)
    }

    /// [`Measure::Torsion`].
    #[inline(always)]
    pub(crate) fn torsion(&mut self) -> S {
        so3::torsion_along(&self.relative.q, self.relative.spin)
    }

    /// [`Measure::Sweep`].
    #[inline(always)]
    pub(crate) fn sweep(&mut self) -> S {
        so3::sweep(&self.relative.q)
    }

    /// [`Measure::ComponentFlexion`].
    #[inline(always)]
    pub(crate) fn component_flexion(&mut self, i: usize) -> S {
        let Relative { q, spin, .. } = self.relative;
        let both = match self.component_flexions {
            Some(known) => known,
            None => so3::component_flexions(q, *spin, self.history.torsion_turns),
        };
        self.component_flexions = Some(both);
        both[i - 1]
    }

    /// [`Measure::Distance`].
    #[inline(always)]
    pub(crate) fn distance(&mut self) -> S {
        let d = self.relative.d;
        let length = norm(d);
        if S::Real::shortcut_where_positive(|| length.real() - S::Real::from_f64(f64::MIN_POSITIVE)) {
            return length;
        }
        length_or_along(length, vector::apply_transposed(self.triad_a, self.section.fixed_direction), d)
    }

    /// [`Measure::Strain`].
    #[inline(always)]
    pub(crate) fn strain(&mut self) -> S {
        let Relative { d, flow, .. } = *self.relative;
        let material = S::from_real(self.section.initial_length) + flow[0] - flow[1];
        ratio(norm(d), material) - S::one()
    }

    /// [`Measure::Flow`].
    #[inline(always)]
    pub(crate) fn flow(&mut self, i: usize) -> S {
        self.relative.flow[i - 1]
    }

    /// [`Measure::Cosine`].
    #[inline(always)]
    pub(crate) fn cosine(&mut self, i: usize, j: usize) -> S {
        picked(picked(self.relative.q, i), j)
    }

    /// [`Measure::Cardan`].
    #[inline(always)]
    pub(crate) fn cardan(&mut self, i: usize) -> S {
        let q = &self.relative.q;
        match i {
            1 => so3::cardan_first(q),
            2 => so3::cardan_second(q),
            _ => so3::cardan_third(q),
        }
    }

    /// [`Measure::Euler`].
    #[inline(always)]
    pub(crate) fn euler(&mut self, i: usize) -> S {
        so3::euler_angle(&self.relative.q, self.history.euler_sign, i)
    }

    /// [`Measure::RotationVector`].
    #[inline(always)]
    pub(crate) fn rotation(&mut self, i: usize) -> S {
        picked(self.rotation_vector(), i)
    }

    /// [`Measure::Misalignment`].
    #[inline(always)]
    pub(crate) fn misaligned(&mut self, i: usize) -> S {
        picked(self.misalignment(), i)
    }
}

impl Measure {
    /// The formula, in the manual's symbols with d = x_b − x_a.
    pub const fn formula(self) -> &'static str {
        match self {
            Self::Position(1) => "e1a·d",
            Self::Position(2) => "e2a·d",
            Self::Position(_) => "e3a·d",
            Self::PositionAtB(1) => "e1a·d",
            Self::PositionAtB(2) => "e2a·d",
            Self::PositionAtB(_) => "e3a·d",
            Self::ProjectedPosition(1) => "e1·d, ei midway between eia and eib",
            Self::ProjectedPosition(2) => "e2·d, ei midway between eia and eib",
            Self::ProjectedPosition(_) => "e3·d, ei midway between eia and eib",
            Self::RadialDistance => "√((e1a·d)² + (e2a·d)²)",
            Self::Flexion => "α = atan2(|e3a × e3b|, e3a·e3b)",
            Self::Torsion => "β = atan2(e2a·e1b − e1a·e2b, e1a·e1b + e2a·e2b)",
            Self::Sweep => "θ = atan2(e1a·e3b, −e2a·e3b)",
            Self::ComponentFlexion(1) => "α1 = α q·e1, q = e3a × e3b/|e3a × e3b|",
            Self::ComponentFlexion(_) => "α2 = α q·e2, q = e3a × e3b/|e3a × e3b|",
            Self::Distance => "|d|",
            Self::Strain => "|d|/(l0 + Ψa − Ψb) − 1",
            Self::Flow(1) => "Ψa",
            Self::Flow(_) => "Ψb",
            Self::Cosine(1, 2) => "e1a·e2b",
            Self::Cosine(1, 3) => "e1a·e3b",
            Self::Cosine(..) => "eia·ejb",
            Self::Cardan(1) => "α = atan2(−e2a·e3b, e3a·e3b)",
            Self::Cardan(2) => "β = atan2(e1a·e3b, |(e2a·e3b, e3a·e3b)|)",
            Self::Cardan(_) => "γ = atan2(−e1a·e2b, e1a·e1b)",
            Self::Euler(1) => "α = atan2(s e1a·e3b, −s e2a·e3b), s = ±1 the sign of sin β, which continues",
            Self::Euler(2) => "β = s atan2(|(e1a·e3b, e2a·e3b)|, e3a·e3b)",
            Self::Euler(_) => "γ = atan2(s e3a·e1b, s e3a·e2b)",
            Self::RotationVector(1) => "φ1 = e1a·φ, eib = exp(φ^) eia",
            Self::RotationVector(2) => "φ2 = e2a·φ, eib = exp(φ^) eia",
            Self::RotationVector(_) => "φ3 = e3a·φ, eib = exp(φ^) eia",
            Self::RotationVectorAtB(1) => "φ1 = e1b·φ, eib = exp(φ^) eia",
            Self::RotationVectorAtB(2) => "φ2 = e2b·φ, eib = exp(φ^) eia",
            Self::RotationVectorAtB(_) => "φ3 = e3b·φ, eib = exp(φ^) eia",
            Self::Misalignment(1) => "e1a·log(Q Q0ᵀ)",
            Self::Misalignment(2) => "e2a·log(Q Q0ᵀ)",
            Self::Misalignment(_) => "e3a·log(Q Q0ᵀ)",
            Self::FlowConversion => "∫ e3a·(δθa − δθb) − βs δΨb",
        }
    }

    /// A formula of the same number (rad) that keeps its digits where [`Self::formula`] loses them, next to its singular set. Of the quaternion
    /// of Q = AᵀB it holds that Q21 − Q12 = 4 q0 q3 and Q11 + Q22 = 2 (q0² − q3²).
    pub const fn stable_formula(self) -> Option<&'static str> {
        match self {
            Self::Torsion => Some("β = 2 atan2(q3, q0), (q0, q1, q2, q3) the quaternion of Q"),
            _ => None,
        }
    }

    /// The manual's symbol of the position, as used in stops: l, x, α, φ1 …
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::Position(1) | Self::PositionAtB(1) | Self::ProjectedPosition(1) => "x",
            Self::Position(2) | Self::PositionAtB(2) | Self::ProjectedPosition(2) => "y",
            Self::Position(_) | Self::PositionAtB(_) | Self::ProjectedPosition(_) => "z",
            Self::RadialDistance => "r",
            Self::Flexion => "α",
            Self::Torsion => "β",
            Self::Sweep => "θ",
            Self::ComponentFlexion(1) => "α1",
            Self::ComponentFlexion(_) => "α2",
            Self::Distance => "l",
            Self::Strain => "λ − 1",
            Self::Flow(1) => "Ψa",
            Self::Flow(_) => "Ψb",
            Self::Cosine(..) => "cos",
            Self::Cardan(1) | Self::Euler(1) => "α",
            Self::Cardan(2) | Self::Euler(2) => "β",
            Self::Cardan(_) | Self::Euler(_) => "γ",
            Self::RotationVector(1) | Self::RotationVectorAtB(1) => "φ1",
            Self::RotationVector(2) | Self::RotationVectorAtB(2) => "φ2",
            Self::RotationVector(_) | Self::RotationVectorAtB(_) => "φ3",
            Self::Misalignment(_) => "ρ",
            Self::FlowConversion => "ur3",
        }
    }

    /// The unit of the value.
    pub const fn unit(self) -> Unit {
        match self {
            Self::Position(_)
            | Self::PositionAtB(_)
            | Self::ProjectedPosition(_)
            | Self::RadialDistance
            | Self::Distance
            | Self::Flow(_) => Unit::Length,
            Self::Strain | Self::Cosine(..) => Unit::None,
            _ => Unit::Angle,
        }
    }

    /// What the measure depends on. Derivatives with respect to the rest are exactly zero, and are not computed.
    pub const fn dependence(self) -> Dependence {
        let (translation, rotation, flow) = match self {
            Self::Position(_) | Self::PositionAtB(_) | Self::RadialDistance | Self::Distance => {
                (true, false, false)
            }
            Self::ProjectedPosition(_) => (true, true, false),
            Self::Strain => (true, false, true),
            Self::Flow(_) => (false, false, true),
            Self::FlowConversion => (false, true, true),
            _ => (false, true, false),
        };
        Dependence { translation, rotation, flow }
    }

    /// The measure with the same value whose name says nothing of its rates.
    pub(crate) const fn as_function(self) -> Self {
        match self {
            Self::PositionAtB(i) => Self::Position(i),
            Self::RotationVectorAtB(i) => Self::RotationVector(i),
            other => other,
        }
    }

    /// Whether a turn of a alone changes the value: not that of a length, nor of a position along the direction fixed in space of
    /// an AXIAL whose nodes coincide. Derivatives along such a turn are exactly zero.
    #[inline]
    pub const fn turns_with_a(self) -> bool {
        !matches!(self, Self::Distance | Self::Strain | Self::Flow(_))
    }

    /// Whether the value is linear in d, and depends on nothing else: its second derivatives are those of the nodal map.
    #[inline]
    pub(crate) const fn is_linear(self) -> bool {
        matches!(self, Self::Position(_) | Self::PositionAtB(_))
    }

    /// The period by which the principal value jumps and the continued value does not: 2π for an angle that winds.
    pub const fn winds(self) -> bool {
        matches!(self, Self::Cardan(1 | 3) | Self::Euler(_) | Self::Torsion | Self::Sweep)
    }

    /// Whether this is one of two angles of which a lock leaves only the sum or the difference.
    pub const fn locks(self) -> bool {
        matches!(self, Self::Cardan(1 | 3) | Self::Euler(1 | 3))
    }

    /// Whether the value depends on the whole turns of torsion.
    pub const fn counts_torsion(self) -> bool {
        matches!(self, Self::ProjectedPosition(_) | Self::ComponentFlexion(_))
    }

    /// Whether the value depends on earlier states: on the turns, the sheet or what has accumulated up to now.
    pub(crate) const fn has_history(self) -> bool {
        self.winds()
            || self.counts_torsion()
            || self.is_one_form()
            || matches!(self, Self::RotationVector(_) | Self::RotationVectorAtB(_))
    }

    /// Whether this is a one-form, judged by its rates: its row is given, its value is what the row accumulates.
    pub const fn is_one_form(self) -> bool {
        matches!(self, Self::FlowConversion)
    }

    /// Whether the value is linear in d and in the flow, so that second derivatives by two of these are exactly zero.
    pub const fn is_straight(self) -> bool {
        matches!(self, Self::Position(_) | Self::PositionAtB(_) | Self::ProjectedPosition(_) | Self::Flow(_))
    }

    /// What the measure becomes when a and b are exchanged: d → −Qᵀd, Q → Qᵀ, Ψ_a ↔ Ψ_b.
    ///
    /// With Q = Rz(φ) Ry(α) Rz(ψ), Qᵀ = Rz(π − ψ) Ry(α) Rz(−π − φ). So the flexion α is the same, torsion φ + ψ the opposite, and the
    /// sweep, φ but for a constant, becomes −ψ. Euler angles likewise: α → −γ, β → β, γ → −α but for half turns.
    pub const fn exchanged(self) -> Exchanged {
        const fn one(measure: Measure, factor: f64) -> Exchanged {
            Exchanged::Sum([Some((measure, factor)), None])
        }
        match self {
            Self::Distance | Self::Flexion | Self::Euler(2) => one(self, 1.0),
            Self::Cosine(i, j) if i == j => one(self, 1.0),
            Self::Torsion
            | Self::ComponentFlexion(_)
            | Self::ProjectedPosition(_)
            | Self::RotationVector(_)
            | Self::RotationVectorAtB(_) => one(self, -1.0),
            Self::Euler(i) => one(Self::Euler(4 - i), -1.0),
            Self::Flow(i) => one(Self::Flow(3 - i), 1.0),
            Self::Sweep => Exchanged::Sum([Some((Self::Sweep, 1.0)), Some((Self::Torsion, -1.0))]),
            Self::Misalignment(i) => Exchanged::Frozen(i),
            Self::Position(_) | Self::PositionAtB(_) | Self::RadialDistance => {
                Exchanged::None("it is taken along the directions of a; those of b turn against them")
            }
            Self::Strain => {
                Exchanged::None("what flows out of a segment at one end flows into it at the other")
            }
            Self::Cosine(..) => Exchanged::None("the cosine of the other two directions is another measure"),
            Self::Cardan(_) => {
                Exchanged::None("Qᵀ is Rz(−γ) Ry(−β) Rx(−α), whose angles of Rx Ry Rz are others")
            }
            Self::FlowConversion => Exchanged::None("its direction is carried by a"),
        }
    }

    /// Whether velocity and acceleration are the nodal ones resolved in b, rather than time derivatives of the value.
    pub const fn has_nodal_rates(self) -> bool {
        matches!(self, Self::RotationVectorAtB(_) | Self::PositionAtB(_))
    }

    /// Where the nodes coincide: a length, and the strain of a belt segment, have a kink.
    pub const COINCIDENT: SingularSet = SingularSet {
        at: "coincident nodes, d = 0",
        class: SingularClass::Kink,
        distance: "|d|",
        unit: Unit::Length,
    };

    /// Every set of points where the measure, or a derivative of it, does not exist: a belt segment has two.
    pub fn singular_sets(self) -> impl Iterator<Item = SingularSet> {
        let second = matches!(self, Self::Strain).then_some(Self::COINCIDENT);
        self.singular_set().into_iter().chain(second)
    }

    /// The points where the measure, or a derivative of it, does not exist; of a belt segment those without material, beside which
    /// [`Measure::singular_sets`] has its coincident nodes.
    pub const fn singular_set(self) -> Option<SingularSet> {
        let (at, class, distance, unit) = match self {
            Self::Distance => return Some(Self::COINCIDENT),
            Self::Strain => (
                "no material left, l0 + Ψa − Ψb ≤ 0",
                SingularClass::TrueSingularity,
                "l0 + Ψa − Ψb",
                Unit::Length,
            ),
            Self::Cardan(1 | 3) => {
                ("β = ±π/2 (lock)", SingularClass::TrueSingularity, "π/2 − |β|", Unit::Angle)
            }
            Self::Cardan(_) => ("β = ±π/2 (lock)", SingularClass::Kink, "π/2 − |β|", Unit::Angle),
            Self::Euler(2) => {
                ("e3a ∥ e3b (lock)", SingularClass::Kink, "angle of e3a, e3b to 0 or π", Unit::Angle)
            }
            Self::Euler(_) => (
                "e3a ∥ e3b (lock)",
                SingularClass::TrueSingularity,
                "angle of e3a, e3b to 0 or π",
                Unit::Angle,
            ),
            Self::RotationVector(_) | Self::RotationVectorAtB(_) => {
                ("|φ| = 2πk, k ≠ 0", SingularClass::TrueSingularity, "||φ| − 2πk|", Unit::Angle)
            }
            Self::Misalignment(_) => (
                "b turned by π from its initial orientation",
                SingularClass::BranchCut,
                "π − |ρ|",
                Unit::Angle,
            ),
            Self::RadialDistance => ("b on the axis e3a, r = 0", SingularClass::Kink, "r", Unit::Length),
            Self::Flexion => ("e3a ∥ e3b, α = 0 or π", SingularClass::Kink, "min(α, π − α)", Unit::Angle),
            Self::Sweep => {
                ("e3a ∥ e3b, α = 0 or π", SingularClass::TrueSingularity, "min(α, π − α)", Unit::Angle)
            }
            Self::Torsion | Self::ProjectedPosition(_) => {
                ("e3b = −e3a, α = π", SingularClass::TrueSingularity, "π − α", Unit::Angle)
            }
            // α q, resolved in directions that are known there but for their sign: (α1, α2) jumps to its opposite. With either
            // sign it is (π − 2|(w, z)| + …) times the axis, which has no gradient at w = z = 0 (so3::component_flexions).
            Self::ComponentFlexion(_) => ("e3b = −e3a, α = π", SingularClass::Reversal, "π − α", Unit::Angle),
            Self::Position(_)
            | Self::PositionAtB(_)
            | Self::Flow(_)
            | Self::Cosine(..)
            | Self::FlowConversion => {
                return None;
            }
        };
        Some(SingularSet { at, class, distance, unit })
    }

    /// The points where only a formula fails: series or another formula take over there, and nothing is lost. No margin counts
    /// the distance to them.
    pub const fn removable_sets(self) -> &'static [SingularSet] {
        const fn at(at: &'static str, distance: &'static str) -> SingularSet {
            SingularSet { at, class: SingularClass::Removable, distance, unit: Unit::Angle }
        }
        const REST: SingularSet = at("φ = 0", "|φ|");
        const HALF_TURN: SingularSet = at("|φ| = π", "||φ| − π|");
        const ALIGNED: SingularSet = at("b in its initial orientation, ρ = 0", "|ρ|");
        const STRAIGHT: SingularSet = at("e3b = e3a, α = 0", "α");
        match self {
            Self::RotationVector(_) | Self::RotationVectorAtB(_) => &[REST, HALF_TURN],
            Self::Misalignment(_) => &[ALIGNED],
            Self::Torsion | Self::ComponentFlexion(_) | Self::ProjectedPosition(_) => &[STRAIGHT],
            _ => &[],
        }
    }

    /// The distance of a state to the nearest point of [`Measure::singular_sets`], `None` where there is no such point. It is 0 where rounding decides: at a
    /// lock within 2e-15 rad, of a radius within 2e-15 of |d|.
    pub fn margin(
        self,
        relative: &Relative<f64>,
        section: &Section<f64>,
        history: &History<f64>,
    ) -> Option<Margin> {
        let mut set = self.singular_set()?;
        let q = &relative.q;
        let distance = match self {
            Self::Distance => norm(relative.d),
            Self::Strain => {
                let (length, material) = (
                    norm(relative.d),
                    (section.initial_length + relative.flow[0] - relative.flow[1]).max(0.0),
                );
                if length < material {
                    set = Self::COINCIDENT;
                }
                length.min(material)
            }
            // Where rounding decides the angles a state counts as locked.
            Self::Cardan(_) | Self::Euler(_) if self.is_locked(q) => 0.0,
            Self::Cardan(_) => norm([q[1][2], q[2][2]]).atan2(q[0][2].abs()),
            Self::Euler(_) | Self::Flexion | Self::Sweep => norm([q[0][2], q[1][2]]).atan2(q[2][2].abs()),
            Self::RotationVector(_) | Self::RotationVectorAtB(_) => {
                let log = so3::continuous_log(q, history.rotation_vector);
                let (angle, turn) = (norm(log.phi), std::f64::consts::TAU);
                // Beside whole turns the angle has lost the digits that the sine of its half still has.
                let beside = || 2.0 * log.lateral.atan2((1.0 - log.lateral * log.lateral).max(0.0).sqrt());
                if angle < 0.5 * turn { turn - angle } else { beside() }
            }
            Self::Misalignment(_) => {
                let frozen = vector::product(q, &vector::transpose(&section.initial_orientation));
                (std::f64::consts::PI - norm(so3::log(&frozen))).max(0.0)
            }
            // Where rounding decides on which side of the axis b is, it counts as on it.
            Self::RadialDistance => {
                let radius = norm([relative.d[0], relative.d[1]]);
                if radius < LOCK * norm(relative.d) { 0.0 } else { radius }
            }
            Self::Torsion | Self::ComponentFlexion(_) | Self::ProjectedPosition(_) => {
                norm([q[0][2], q[1][2]]).atan2(-q[2][2])
            }
            Self::Position(_)
            | Self::PositionAtB(_)
            | Self::Flow(_)
            | Self::Cosine(..)
            | Self::FlowConversion => {
                return None;
            }
        };
        Some(Margin { distance, set })
    }

    /// The principal value on any scalar. Angles that wind are in (−π, π]; a one-form, which has no function, gives 0.
    pub fn evaluate<S: Scalar>(self, shared: &mut Shared<'_, S>) -> S {
        match self {
            Self::Position(i) | Self::PositionAtB(i) => shared.coordinate(i),
            Self::ProjectedPosition(i) => shared.projected(i),
            Self::RadialDistance => shared.radius(),
            Self::Flexion => shared.flexion(),
            Self::Torsion => shared.torsion(),
            Self::Sweep => shared.sweep(),
            Self::ComponentFlexion(i) => shared.component_flexion(i),
            Self::Distance => shared.distance(),
            Self::Strain => shared.strain(),
            Self::Flow(i) => shared.flow(i),
            Self::Cosine(i, j) => shared.cosine(i, j),
            Self::Cardan(i) => shared.cardan(i),
            Self::Euler(i) => shared.euler(i),
            Self::RotationVector(i) | Self::RotationVectorAtB(i) => shared.rotation(i),
            Self::Misalignment(i) => shared.misaligned(i),
            Self::FlowConversion => S::zero(),
        }
    }

    /// The row of the one-form, in the order of [`node::DOF`]: e3a on θ_a, −e3a on θ_b, −β_s on Ψ_b. Zero for a function.
    pub fn one_form<S: Scalar>(self, triad_a: &Matrix<S>, section: &Section<S::Real>) -> [S; DOFS] {
        match self {
            Self::FlowConversion => node::flow_conversion_row(column(triad_a, 2), section.flow_scale),
            _ => [S::zero(); DOFS],
        }
    }

    /// Velocity and acceleration by nodal rates resolved in b: vr_i = (ω_b − ω_a)·e_i^b, ar_i = (α_b − α_a)·e_i^b (seed
    /// ROTATION-ACCELEROMETER), and likewise v_i, a_i (ACCELEROMETER). Neither is the time derivative of the value, nor the
    /// second that of the first.
    pub(crate) fn nodal_rates<R: Real>(
        self,
        pair: &Pair<R>,
        velocity: &NodalRates<R>,
        acceleration: &NodalRates<R>,
    ) -> Option<[R; 2]> {
        let (i, relative) = match self {
            Self::RotationVectorAtB(i) => (i, node::relative_spin(velocity, acceleration)),
            Self::PositionAtB(i) => (i, node::relative_translation(velocity, acceleration)),
            _ => return None,
        };
        let direction = column(&pair.b.triad, i - 1);
        Some(relative.map(|rate| dot(rate, direction)))
    }

    /// The principal value of an angle that winds, as evaluated. So close to a lock that rounding decides it, the first angle keeps
    /// its value (`first`, where the state before left it). The third gets what is known of the two, their sum or difference.
    /// Together they still compose to Q.
    ///
    /// Cardan, β = ±π/2: γ ± α = atan2(Q₂₁, Q₂₂); Euler, β = 0 and π: α ± γ = atan2(Q₂₁, Q₁₁).
    pub(crate) fn unlocked<R: Real>(self, q: &Matrix<R>, evaluated: R, first: R) -> R {
        let zero = R::ZERO;
        let (beyond, sum, which) = match self {
            Self::Cardan(i @ (1 | 3)) => (q[0][2], [q[1][0], q[1][1]], i),
            Self::Euler(i @ (1 | 3)) => (q[2][2], [q[1][0], q[0][0]], i),
            _ => return evaluated,
        };
        let third = || {
            let known = sum[0].arctangent(sum[1]);
            // Where the lock is the other one, Cardan knows γ − α and Euler α − γ.
            let angle = R::choose(
                beyond.less(zero),
                || if matches!(self, Self::Cardan(_)) { known + first } else { first - known },
                || known - first,
            );
            let (sine, cosine) = angle.sine_cosine();
            sine.arctangent(cosine)
        };
        R::choose(self.locks_at(q), || if which == 1 { first } else { third() }, || evaluated)
    }

    /// Whether successive angles are so close to a lock that rounding decides them.
    fn locks_at<R: Real>(self, q: &Matrix<R>) -> R::Mask {
        let across = match self {
            Self::Euler(_) => [q[0][2], q[1][2]],
            _ => [q[1][2], q[2][2]],
        };
        norm(across).less(R::from_f64(LOCK))
    }

    /// The same of successive angles on one real number; false of any other measure.
    pub fn is_locked<R: Real<Mask = bool>>(self, q: &Matrix<R>) -> bool {
        matches!(self, Self::Cardan(_) | Self::Euler(_)) && self.locks_at(q)
    }

    /// The gradient of this angle with respect to the relative rotation of the nodes, global components. Its product with
    /// whole turns of the nodes is how far they advance the angle. `None` for measures that do not wind.
    ///
    /// The angle is counted about the direction u while b turns about u. It does not move while b turns about w, the axis of the
    /// other angle that winds: (u − (u·w) w)/(1 − (u·w)²). Close to the lock u ∥ w only the sum or the difference of the
    /// two is known; the first takes all. The sweep θ is the first of the angles of Rz(φ) Ry(α) Rz(ψ) but for a constant, with
    /// w = e3b. Torsion is the sum of first and third, (e3a + e3b)/(1 + e3a·e3b).
    pub(crate) fn winding_axis<R: Real>(self, pair: &Pair<R>) -> Option<Vector<R>> {
        // The square of the sine of the angle between the axes.
        const LOCK: (i32, i32) = (1, 1_000_000);
        let lock = R::ratio(LOCK.0, LOCK.1);
        let (first_axis, third_axis, is_first) = match self {
            Self::Cardan(i @ (1 | 3)) => (column(&pair.a.triad, 0), column(&pair.b.triad, 2), i == 1),
            Self::Euler(i @ (1 | 3)) => (column(&pair.a.triad, 2), column(&pair.b.triad, 2), i == 1),
            Self::Sweep => (column(&pair.a.triad, 2), column(&pair.b.triad, 2), true),
            Self::Torsion => {
                let (shaft_a, shaft_b) = (column(&pair.a.triad, 2), column(&pair.b.triad, 2));
                let rest = R::integer(1) + dot(shaft_a, shaft_b);
                let both = add(shaft_a, shaft_b);
                let shared = || scale(both, R::integer(1) / rest);
                return Some(R::choose(lock.less(rest), shared, || shaft_a));
            }
            _ => return None,
        };
        let (own, other) = if is_first { (first_axis, third_axis) } else { (third_axis, first_axis) };
        let across = sub(own, scale(other, dot(own, other)));
        let square = dot(across, across);
        let locked = if is_first { own } else { [R::ZERO; 3] };
        let one = R::integer(1);
        Some(R::choose(lock.less(square), || scale(across, one / square), || locked))
    }
}
