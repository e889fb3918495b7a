//! What needs care at a state: stops reached, singular sets and how near they are, turns and paths that are not certain.

use crate::connector::{Branch, Components, Connector, Increment, Mask, Row, State};
use crate::measure::{Margin, Measure, SingularClass, Unit};
use crate::node::{DOFS, Pair};
use crate::scalar::elementary::norm;
use crate::scalar::{Duals, Real};
use crate::so3;
use crate::vector;
use crate::vector::{Matrix, column, dot, scale, sub};
use serde::{Deserialize, Serialize};
use std::cell::LazyCell;
use std::mem::{self, Discriminant};
use std::sync::Arc;

/// A stop: min ≤ position ≤ max, in the units of the position (angles in radians).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stop {
    /// The lower limit, if any.
    pub lower: Option<f64>,
    /// The upper limit, if any.
    pub upper: Option<f64>,
}

/// Whether a stop is reached, or a lock closed (output CSLST).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StopStatus {
    /// Between the limits: 0.
    Free,
    /// At or below the lower limit: 1.
    AtLower,
    /// At or above the upper limit: 1.
    AtUpper,
    /// Held by a lock: 1.
    Locked,
}

impl StopStatus {
    /// Whether a position is at a stop.
    pub fn at(stop: &Stop, position: f64) -> Self {
        match *stop {
            Stop { lower: Some(lower), .. } if position <= lower => Self::AtLower,
            Stop { upper: Some(upper), .. } if position >= upper => Self::AtUpper,
            _ => Self::Free,
        }
    }

    /// The value of CSLST: 1 at a limit, else 0.
    pub const fn flag(self) -> u8 {
        match self {
            Self::Free => 0,
            Self::AtLower | Self::AtUpper | Self::Locked => 1,
        }
    }
}

/// What turned by so much that its turns cannot be counted with certainty.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Turned {
    /// The component, which is an angle.
    Component,
    /// The torsion, which directions midway between a and b follow, and so the component.
    Torsion,
    /// The rotation vector of which the component is one.
    RotationVector,
    /// Node a, along whose turn the component is accumulated.
    NodeA,
    /// Node b, likewise.
    NodeB,
}

/// What a component is held by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Holding {
    /// Its type constrains it.
    Constraint,
    /// A connector motion drives it.
    Motion,
    /// A lock, or a stop.
    Limit,
}

/// A state at which a value needs care.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "flag", rename_all = "kebab-case")]
pub enum Flag {
    /// The state lies on a singular set: derivatives named there do not exist, and are reported as zero or along the
    /// direction kept; at a true singularity the value is not determined either.
    Singular {
        /// The component.
        component: &'static str,
        /// The set.
        at: &'static str,
        /// What happens there.
        class: SingularClass,
    },
    /// The state is so close to a singular set that derivatives, and at a true singularity the value too, lose digits. The relative
    /// error grows like u divided by the distance, a length in units of the largest length it is formed from.
    IllConditioned {
        /// The component.
        component: &'static str,
        /// The set.
        at: &'static str,
        /// What happens there.
        class: SingularClass,
        /// The distance to it.
        distance: f64,
    },
    /// The initial position of the component lay so close to a singular set that rounding decided it: every displacement counts from an
    /// arbitrary origin. Derivatives are not affected.
    UndeterminedOrigin {
        /// The component.
        component: &'static str,
        /// The set.
        at: &'static str,
    },
    /// A number is infinite or not a number: the state lies beyond what the formula can be evaluated at.
    NotFinite {
        /// The component.
        component: &'static str,
        /// The output, or `derivative`.
        quantity: &'static str,
    },
    /// An angle moved by more than 0.9 π since the previous state besides the whole turns of the nodes, or these were not about
    /// its axis: its turns cannot be counted with certainty.
    LargeIncrement {
        /// The component.
        component: &'static str,
        /// What turned: the component, or what it is made of.
        of: Turned,
        /// The change of the angle (rad); of a rotation vector, the angle of the rotation between the two, which is not negative.
        change: f64,
    },
    /// The rotation vectors of a node at this state and the one before fit two turns, and neither is unlikely.
    AmbiguousTurn {
        /// `all`: every component that follows how the node turns.
        component: &'static str,
        /// The node: `a` or `b`, `S` or `M`.
        node: &'static str,
        /// The angle of the turn that was taken (rad).
        taken: f64,
        /// The angle of the other, which has the same end (rad).
        other: f64,
    },
    /// A one-form was accumulated over an increment in which its direction turned: what lies between the two states
    /// decides, and they do not say.
    PathDependent {
        /// The component.
        component: &'static str,
        /// How far the midpoint rule, which is reported, is from nodes that turn at constant rates (rad).
        difference: f64,
    },
    /// The state is not one that what holds the component allows, by more than rounding of the coordinates explains.
    OffConstraint {
        /// The component.
        component: &'static str,
        /// What holds it.
        by: Holding,
        /// RES: how far off it is (rad, or in the unit of length).
        residual: f64,
    },
    /// A two-dimensional connector whose nodes were moved or turned out of the global 1-2 plane: what is reported is not that
    /// of a plane motion.
    OutOfPlane {
        /// `u3`, `ur1` or `ur2`, by what moved.
        component: &'static str,
    },
    /// A force is asked for and not known.
    NotKnown {
        /// The component.
        component: &'static str,
        /// The output.
        quantity: &'static str,
        /// Why, in words.
        why: &'static str,
    },
    /// A force whose slope jumps here: at a row of a table, or where it starts to act.
    ForceKink {
        /// The component.
        component: &'static str,
        /// Where the slopes meet.
        at: f64,
        /// The slope below.
        left: f64,
        /// The slope above.
        right: f64,
    },
    /// A position lies beyond its stop.
    BeyondStop {
        /// The component.
        component: &'static str,
        /// How far.
        by: f64,
    },
    /// The reaction at a stop pulls: nothing holds the component there.
    StopPulls {
        /// The component.
        component: &'static str,
        /// CRF.
        reaction: f64,
    },
    /// A limit was passed, and a lock closed.
    Locked {
        /// The component whose limit it is.
        component: &'static str,
        /// The limit.
        limit: &'static str,
    },
    /// A limit was passed, and a failure released components.
    Failed {
        /// The component whose limit it is.
        component: &'static str,
        /// The limit.
        limit: &'static str,
    },
    /// A lock or failure has a limit that could not be checked.
    Undecided {
        /// The component whose limit it is.
        component: &'static str,
        /// `lock` or `failure`.
        criterion: &'static str,
        /// Why, in words.
        why: &'static str,
    },
    /// An increment of friction needs care.
    Friction {
        /// A component that slides, or `C` for a friction that several share.
        component: &'static str,
        /// What, by the name of the flag of the friction law.
        what: &'static str,
    },
    /// The total force given for a component that nothing holds differs from the sum of its parts.
    OutOfBalance {
        /// The component.
        component: &'static str,
        /// Given minus sum.
        by: f64,
    },
    /// The forces that the state gives are not those of the connector or constraint, and none of them is taken.
    ForcesRefused {
        /// `all`.
        component: &'static str,
        /// The code of the error.
        code: &'static str,
    },
}

impl Flag {
    /// That the forces of a state are refused with this code of a diagnostic.
    pub const fn refused(code: &'static str) -> Self {
        Self::ForcesRefused { component: "all", code }
    }

    /// A residual, where it is more than rounding makes of coordinates of that size: 2e-6 of it.
    pub fn off(component: &'static str, by: Holding, residual: f64, size: f64) -> Option<Self> {
        let is_off = residual.is_finite() && residual.abs() > CERTAIN_RESIDUAL * size;
        is_off.then_some(Self::OffConstraint { component, by, residual })
    }

    /// The name, as JSON has it.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Singular { .. } => "singular",
            Self::IllConditioned { .. } => "ill-conditioned",
            Self::UndeterminedOrigin { .. } => "undetermined-origin",
            Self::NotFinite { .. } => "not-finite",
            Self::LargeIncrement { .. } => "large-increment",
            Self::AmbiguousTurn { .. } => "ambiguous-turn",
            Self::PathDependent { .. } => "path-dependent",
            Self::OffConstraint { .. } => "off-constraint",
            Self::OutOfPlane { .. } => "out-of-plane",
            Self::NotKnown { .. } => "not-known",
            Self::ForceKink { .. } => "force-kink",
            Self::BeyondStop { .. } => "beyond-stop",
            Self::StopPulls { .. } => "stop-pulls",
            Self::Locked { .. } => "locked",
            Self::Failed { .. } => "failed",
            Self::Undecided { .. } => "undecided",
            Self::Friction { .. } => "friction",
            Self::OutOfBalance { .. } => "out-of-balance",
            Self::ForcesRefused { .. } => "forces-refused",
        }
    }

    /// The component that it is about.
    pub const fn component(&self) -> &'static str {
        match self {
            Self::Singular { component, .. }
            | Self::IllConditioned { component, .. }
            | Self::UndeterminedOrigin { component, .. }
            | Self::NotFinite { component, .. }
            | Self::LargeIncrement { component, .. }
            | Self::AmbiguousTurn { component, .. }
            | Self::PathDependent { component, .. }
            | Self::OffConstraint { component, .. }
            | Self::OutOfPlane { component }
            | Self::NotKnown { component, .. }
            | Self::ForceKink { component, .. }
            | Self::BeyondStop { component, .. }
            | Self::StopPulls { component, .. }
            | Self::Locked { component, .. }
            | Self::Failed { component, .. }
            | Self::Undecided { component, .. }
            | Self::Friction { component, .. }
            | Self::OutOfBalance { component, .. }
            | Self::ForcesRefused { component, .. } => component,
        }
    }
}

/// The distance to a singular set below which a state is flagged: half the digits of a second derivative are gone.
pub const ILL_CONDITIONED: f64 = 1e-8;

/// The change of an angle, as a fraction of π, beyond which its turns are flagged.
pub const CERTAIN_INCREMENT: f64 = 0.9;

/// How far, as a fraction of π, the change of an angle may be from what the nodes' own increments tell, to be certain although it
/// exceeds [`CERTAIN_INCREMENT`].
pub const CERTAIN_TOLD: f64 = 0.1;

/// The residual, of the largest coordinate or rad, beyond which a state is flagged: what single precision and six printed digits leave.
const CERTAIN_RESIDUAL: f64 = 2e-6;

/// The difference of two rules of integration (rad) beyond which a one-form is flagged: that of 10 000 such increments is still
/// below 1e-5 rad.
const CERTAIN_PATH: f64 = 1e-9;

/// How far the advance of an angle by whole turns of the nodes may be from whole turns of its own, in turns, to be counted with
/// certainty.
pub const CERTAIN_TURNS: f64 = 0.1;

impl<R: Duals> Connector<R> {
    /// The singular sets next to which the initial positions lay, so that rounding decided them.
    pub fn undetermined_origins(&self) -> &[Option<&'static str>; 6] {
        &self.kind.undetermined_origins
    }

    /// The same connector with the initial position of a component as it was found on other numbers.
    #[must_use]
    pub fn counting_from(mut self, k: usize, initial: R) -> Self {
        if let Some(start) = self.initial.get_mut(k) {
            *start = initial;
        }
        self
    }

    /// The same connector with the initial orientation of b relative to a as it was found on other numbers.
    #[must_use]
    pub fn oriented_from(mut self, initial: Matrix<R>) -> Self {
        Arc::make_mut(&mut self.kind).section.initial_orientation = initial;
        self
    }

    /// The initial position of a component.
    pub fn counts_from(&self, k: usize) -> Option<R> {
        self.initial.get(k).copied()
    }

    /// What the residual of a constrained component, and the displacement of any other, counts from; `None` where there is no component.
    pub fn origin(&self, k: usize) -> Option<R> {
        self.kind.rows.get(k)?.as_ref().map(|row| self.offset(k, row))
    }
}

/// The most kinds of measure that the rows of a connector can have: positions and what is differentiated.
const KINDS: usize = 12;

/// The place of each component's distances among those that a connector has, of what is differentiated and of the position. The
/// measures of one kind share their singular set. `None` where there is no such set, or the two are one measure.
#[derive(Clone, Copy, Debug)]
pub(super) struct Singular([[Option<u8>; 2]; 6]);

impl Singular {
    pub(super) fn new(rows: &Components<Row>) -> Self {
        let mut kinds: Vec<Discriminant<Measure>> = Vec::new();
        let mut place = |measure: Measure| {
            measure.singular_set()?;
            let kind = mem::discriminant(&measure);
            let known = kinds.iter().position(|known| *known == kind);
            let place = known.unwrap_or_else(|| {
                kinds.push(kind);
                kinds.len() - 1
            });
            u8::try_from(place).ok()
        };
        Self(rows.map(|row| {
            let Some(Row { position, differentiated, .. }) = row else { return [None; 2] };
            let of_differentiated = place(differentiated);
            [of_differentiated, if position == differentiated { None } else { place(position) }]
        }))
    }
}

impl Connector<f64> {
    /// Which residuals are beyond rounding of the coordinates: 2e-6 of the largest of them, or 2e-6 rad. `driven` says which components a
    /// connector motion drives. Nodes at the origin are as far off as rounding of a model of that `length` makes them: 2e-12 of it.
    pub fn off_constraint(
        &self,
        pair: &Pair<f64>,
        residual: &Components<f64>,
        driven: Mask,
        length: f64,
    ) -> impl Iterator<Item = Flag> {
        const OF_MODEL: f64 = 1e-6;
        let size = move |measure: Measure| match measure.unit() {
            Unit::Length => extent(pair).max(OF_MODEL * length),
            _ => 1.0,
        };
        (0..6).filter_map(move |k| {
            let (residual, measure) = (residual[k]?, self.differentiated(k)?);
            let by = match () {
                () if driven[k] => Holding::Motion,
                () if self.is_constrained(k) => Holding::Constraint,
                () => Holding::Limit,
            };
            Flag::off(crate::catalog::COMPONENT[k], by, residual, size(measure))
        })
    }

    /// Whether stops are reached at the given positions.
    pub fn stop_status(&self, position: &Components<f64>) -> Components<StopStatus> {
        [0, 1, 2, 3, 4, 5].map(|k| Some(StopStatus::at(&self.kind.stops[k]?, position[k]?)))
    }

    /// Whether it is two-dimensional.
    pub fn is_planar(&self) -> bool {
        self.kind.is_planar
    }

    /// The stops.
    pub fn stops(&self) -> &Components<Stop> {
        &self.kind.stops
    }

    /// The distance of each component wanted, in what is differentiated and in its position, to the nearest singular set.
    pub fn margins(&self, state: &State<f64>, branch: &Branch<f64>, wanted: Mask) -> Components<Margin> {
        let mut margins = [None; 6];
        if wanted == [false; 6] {
            return margins;
        }
        let history = branch.history();
        let relative = LazyCell::new(|| state.pair.relative());
        let mut known = [None; KINDS];
        let mut of = |place: Option<u8>, measure: Measure| {
            let known = known.get_mut(usize::from(place?))?;
            if let Some(distance) = *known {
                return Some(Margin { distance, set: measure.singular_set()? });
            }
            let margin = measure.margin(&relative, &self.kind.section, &history)?;
            *known = Some(margin.distance);
            Some(margin)
        };
        for (k, [differentiated, position]) in self.kind.singular.0.into_iter().enumerate() {
            let (true, Some(row)) = (wanted[k], &self.kind.rows[k]) else { continue };
            margins[k] = match (of(differentiated, row.differentiated), of(position, row.position)) {
                (Some(x), Some(y)) => Some(if x.distance <= y.distance { x } else { y }),
                (x, y) => x.or(y),
            };
        }
        margins
    }

    /// What needs care at a state: singular sets, ill-conditioned neighbourhoods, increments too large to unwrap.
    pub fn flags(
        &self,
        margins: &Components<Margin>,
        increment: &Increment<f64>,
        state: &State<f64>,
        before: &Branch<f64>,
        after: &Branch<f64>,
    ) -> Vec<Flag> {
        self.flags_of([true; 6], margins, increment, state, [before, after])
    }

    /// The same, of turns and paths of the components in `followed` only: those that [`Connector::follow`] was asked for.
    pub fn flags_of(
        &self,
        followed: Mask,
        margins: &Components<Margin>,
        increment: &Increment<f64>,
        state: &State<f64>,
        [before, after]: [&Branch<f64>; 2],
    ) -> Vec<Flag> {
        let mut flags = Vec::new();
        let rows = || (0..6).filter(|k| followed[*k]).filter_map(|k| Some((k, self.kind.rows[k].as_ref()?)));
        let scale_of = |unit| if unit == Unit::Length { extent(&state.pair) } else { 1.0 };
        let is_vector = |k: usize| {
            let of = self.kind.rows[k].as_ref().map(|row| row.position);
            matches!(of, Some(Measure::RotationVector(_) | Measure::RotationVectorAtB(_)))
        };
        // Near a whole turn the sheet stays what it was, and the direction of the vector loses the digits that the distance has lost.
        let keeps_sheet = || so3::keeps_sheet(after.rotation_vector);
        for (k, margin) in margins.iter().enumerate() {
            let component = crate::catalog::COMPONENT[k];
            let Some(Margin { distance, set }) = *margin else { continue };
            if distance == 0.0 {
                flags.push(Flag::Singular { component, at: set.at, class: set.class });
            } else if distance < ILL_CONDITIONED * scale_of(set.unit) || (is_vector(k) && keeps_sheet()) {
                flags.push(Flag::IllConditioned { component, at: set.at, class: set.class, distance });
            }
            if let Some(at) = self.kind.undetermined_origins[k] {
                flags.push(Flag::UndeterminedOrigin { component, at });
            }
        }
        let whole = sub(increment.whole_turns[1], increment.whole_turns[0]);
        let all = sub(increment.rotation[1], increment.rotation[0]);
        let turns_are_told = increment.whole_turns.as_flattened().iter().any(|turns| *turns != 0.0);
        // What lies midway between a and b follows the torsion, whether or not that is a component.
        let counted = rows().filter_map(|(k, row)| match row.position {
            measure if measure.winds() => {
                Some((k, (Turned::Component, measure), [before.turns[k], after.turns[k]]))
            }
            measure if measure.counts_torsion() => {
                Some((k, (Turned::Torsion, Measure::Torsion), [before.torsion, after.torsion]))
            }
            _ => None,
        });
        for (k, (of, measure), [old, new]) in counted {
            let axis = measure.winding_axis(&state.pair);
            let along = |v| axis.map_or(0.0, |axis| dot(axis, v));
            let change = f64::with_turns(new.principal - old.principal, new.turns - old.turns);
            let by_whole = along(whole);
            let told = by_whole / std::f64::consts::TAU;
            let is_large = (change - by_whole).abs() > CERTAIN_INCREMENT * std::f64::consts::PI;
            let is_told = turns_are_told && (change - along(all)).abs() < CERTAIN_TOLD * std::f64::consts::PI;
            if (is_large && !is_told) || (told - told.round()).abs() > CERTAIN_TURNS {
                flags.push(Flag::LargeIncrement { component: crate::catalog::COMPONENT[k], of, change });
            }
        }
        for (k, _) in rows().filter(|(_, row)| row.position.is_one_form()) {
            let component = crate::catalog::COMPONENT[k];
            let difference = (self.accumulation(&state.pair, increment)
                - self.steady_accumulation(&state.pair, increment))
            .abs();
            if difference > CERTAIN_PATH {
                flags.push(Flag::PathDependent { component, difference });
            }
            for (end, of) in [Turned::NodeA, Turned::NodeB].into_iter().enumerate() {
                let change = norm(sub(increment.rotation[end], increment.whole_turns[end]));
                if change > CERTAIN_INCREMENT * std::f64::consts::PI && !turns_are_told {
                    flags.push(Flag::LargeIncrement { component, of, change });
                }
            }
        }
        flags.extend(self.out_of_plane(state));
        let turned = LazyCell::new(|| {
            let [old, new] = [before, after].map(|branch| so3::exp_quaternion(branch.rotation_vector));
            norm(so3::log_quaternion(so3::compose(new, so3::conjugate(old))))
        });
        for (k, _) in rows().filter(|(k, _)| is_vector(*k)) {
            if *turned > CERTAIN_INCREMENT * std::f64::consts::PI {
                let (component, of) = (crate::catalog::COMPONENT[k], Turned::RotationVector);
                flags.push(Flag::LargeIncrement { component, of, change: *turned });
            }
        }
        flags
    }
}

impl Connector<f64> {
    /// The one-form over the increment, for nodes that turn at constant rates between the two states. The mean direction ∫₀¹
    /// exp(−s Δθ_a^) e3a ds = e3a − ½ Δθ_a × e3a + … stands in place of the midpoint's.
    fn steady_accumulation(&self, pair: &Pair<f64>, increment: &Increment<f64>) -> f64 {
        let [of_a, of_b] = increment.rotation;
        // Five Gauss points: an increment of one turn is integrated to 1e-4, and one of a tenth of a turn to rounding.
        const POINTS: [(f64, f64); 5] = [
            (0.046_910_077_030_668, 0.118_463_442_528_094_54),
            (0.230_765_344_947_158_45, 0.239_314_335_249_683_24),
            (0.5, 0.284_444_444_444_444_4),
            (0.769_234_655_052_841_5, 0.239_314_335_249_683_24),
            (0.953_089_922_969_332, 0.118_463_442_528_094_54),
        ];
        let mut sum = -self.kind.section.flow_scale * increment.flow[1];
        for (s, weight) in POINTS {
            let back = so3::matrix(so3::exp_quaternion(scale(of_a, -s)));
            let direction = column(&vector::product(&back, &pair.a.triad), 2);
            sum += weight * dot(direction, sub(of_a, of_b));
        }
        sum
    }

    /// What a two-dimensional connector's nodes do out of its plane.
    fn out_of_plane(&self, state: &State<f64>) -> Vec<Flag> {
        if !self.kind.is_planar {
            return Vec::new();
        }
        /// Direction cosines of exact rotations about the global 3-axis carry a few roundings.
        const ROUNDING: f64 = 1e-12;
        let Pair { a, b, .. } = &state.pair;
        let rates = |i: usize| {
            [&state.velocity, &state.acceleration]
                .iter()
                .any(|rate| rate[i] != 0.0 || rate[DOFS / 2 + i] != 0.0)
        };
        let tilted = |i: usize| [a, b].iter().any(|node| node.triad[i][2].abs() > ROUNDING);
        let moved = [
            (a.displacement[2] != 0.0 || b.displacement[2] != 0.0 || rates(2), "u3"),
            (tilted(1) || rates(3), "ur1"),
            (tilted(0) || rates(4), "ur2"),
        ];
        moved.into_iter().filter(|(is, _)| *is).map(|(_, component)| Flag::OutOfPlane { component }).collect()
    }
}

/// The largest of the lengths from which x_b − x_a is formed: its rounding scales with it, so that a distance is small or not
/// regardless of the unit of length.
fn extent(pair: &Pair<f64>) -> f64 {
    let lengths = [pair.reference, pair.a.displacement, pair.b.displacement];
    lengths.as_flattened().iter().fold(0.0, |most, length| most.max(length.abs()))
}
