//! Connection types as data: the only place that knows them.
//!
//! A connection type is six [`Slot`]s, one for each component of relative motion u1, u2, u3, ur1, ur2, ur3. With them
//! go the fields of the manual's summary table that no formula implies: orientation rules, where it is available,
//! predefined friction. Values, derivatives, validation, listing and tests iterate over [`table::TABLE`].
//!
//! To add a type: write its half or its slots in `table.rs` (and a new [`Measure`] if none fits), then its double entries:
//! a row in `verify/numbers/manual.rs` and one in `scripts/reference/reference.py`. A test fails while either is missing.

mod friction;
mod rules;
mod table;

pub use friction::{
    Contact, ContactTerm, CrossAxis, Factor, Friction, FrictionConstant, FrictionCriterion,
    FrictionParameter, Load, PLANE, Quantity, SPATIAL, Traction, in_plane,
};
pub use rules::{Breach, EXPLICIT_STEP, Facts, Procedure, Rule};
pub use table::TABLE;

use crate::measure::{Measure, Unit};
use serde::Serialize;
use std::borrow::Cow;

/// The names of the components of relative motion, in order.
pub const COMPONENT: [&str; 6] = ["u1", "u2", "u3", "ur1", "ur2", "ur3"];

/// The place in [`COMPONENT`] of a component by its number in decks, 1 to 6; none has another number.
pub fn component_index(number: u8) -> Option<usize> {
    (1..=6).position(|known| known == number)
}

/// The names of the conjugate forces and moments, in order.
pub const FORCE: [&str; 6] = ["f1", "f2", "f3", "m1", "m2", "m3"];

/// How well a fact is documented, best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub enum Evidence {
    /// Printed in a seed document.
    S,
    /// Read in a documentation page.
    D,
    /// Read in part; the continuation is ours.
    P,
    /// Reconstructed: a decision of ours.
    R,
}

impl Evidence {
    /// The tag in words.
    pub const fn meaning(self) -> &'static str {
        match self {
            Self::S => "printed in a source document",
            Self::D => "read in a documentation page",
            Self::P => "read in part, continued by us",
            Self::R => "our reconstruction",
        }
    }
}

/// One component of relative motion of a connection type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// No such component.
    Absent,
    /// Free: behaviour, motion and load can be attached to it.
    Available(Measure),
    /// Enforced by the connection. The measure is its position; [`Condition`] says what is enforced.
    Constrained(Measure, Condition),
    /// Output only: neither available nor constrained.
    Measured(Measure),
}

/// What a constrained component enforces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Condition {
    /// position − initial position = 0.
    Held,
    /// The printed function = 0 when it is zero initially; otherwise the position is held, as for REVOLUTE with misaligned axes.
    ZeroOrHeld(Measure),
    /// The function = 0; it is zero initially by its definition.
    Zero(Measure),
}

impl Slot {
    /// The measure of the component's position, if it has one.
    pub const fn position(self) -> Option<Measure> {
        match self {
            Self::Absent => None,
            Self::Available(measure) | Self::Constrained(measure, _) | Self::Measured(measure) => {
                Some(measure)
            }
        }
    }

    /// The function that a constraint is printed as, where that is not its position.
    pub const fn printed(self) -> Option<Measure> {
        match self {
            Self::Constrained(_, Condition::ZeroOrHeld(printed) | Condition::Zero(printed)) => Some(printed),
            _ => None,
        }
    }

    /// Whether the component is available.
    pub const fn is_available(self) -> bool {
        matches!(self, Self::Available(_))
    }

    /// Whether the component is constrained.
    pub const fn is_constrained(self) -> bool {
        matches!(self, Self::Constrained(..))
    }
}

/// How the force of a component loads the nodes: the row of virtual displacements that it does work on.
///
/// The reported force of an available component is conjugate to it. That of a constrained component is what the manual prints as its
/// constraint force or moment, which need not be the multiplier of the equation enforced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loading {
    /// Conjugate to the position: its gradient, or the one-form that it accumulates.
    Conjugate,
    /// A moment along e_i^a on b, and its opposite on a: m2 and m3 of REVOLUTE. For every frozen angle these span the moments
    /// that do no work on the free rotation about e1a.
    AlongA(usize),
    /// A moment on b whose component along the i-th axis of the Cardan angles frozen initially is the reported one, and the others
    /// zero: ALIGN. These components are m_i = M·(e1a, cos α₀ e2a + sin α₀ e3a, e3b). The moment is along e_i^a where the directions
    /// coincide initially.
    FrozenAxis(usize),
    /// A tension along d, with the flow forces −f1 at a and +f1 at b: f1 (δ|d| − δΨ_a + δΨ_b). SLIPRING, whose u1 is a strain.
    Tension,
}

/// The moment that a page prints, where it is written in other directions than those conjugate to the components: its components
/// are those by which the printed formula gives the exact moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PrintedMoment {
    /// M = m1 e1a + m2 e2a + m3 e3a, or m_i = M·e_i^a.
    AlongA,
    /// M = m1 e1a + m2 (cos α e2a + sin α e3a) + m3 e3b, along the axes of the Cardan angles.
    CardanAxes,
    /// M = m1 e1 + m2 e2 + m3 e3, along the directions midway between a and b.
    Midway,
}

impl PrintedMoment {
    /// The formula, in the manual's symbols.
    pub const fn formula(self) -> &'static str {
        match self {
            Self::AlongA => "m = m1 e1a + m2 e2a + m3 e3a",
            Self::CardanAxes => "m = m1 e1a + m2 (cos α e2a + sin α e3a) + m3 e3b",
            Self::Midway => "m = m1 e1 + m2 e2 + m3 e3",
        }
    }
}

/// Whether an orientation must, may or will not be used at a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Orientation {
    /// Read and not used.
    Ignored,
    /// Absent at a: the global directions. Absent at b: the directions of a.
    Optional,
    /// An error if absent.
    Required,
}

/// A rule about the orientation at a node, and how well it is documented.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct OrientationRule {
    /// The rule.
    pub orientation: Orientation,
    /// Its evidence; a rule tagged [`Evidence::P`] or [`Evidence::R`] warns instead of refusing.
    pub evidence: Evidence,
}

/// The manual's classes of connection types.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Class {
    /// Relative position of the nodes.
    BasicTranslational,
    /// Relative rotation of the nodes.
    BasicRotational,
    /// A rotational half with a degree of freedom of its own.
    SpecialisedRotational,
    /// Two basic halves under one name.
    Assembled,
    /// A type that stands alone.
    Complex,
}

/// Where a type can be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Availability {
    /// Everywhere.
    Always,
    /// Only in an Explicit analysis.
    ExplicitOnly,
    /// Not at all.
    Never,
    /// Everywhere but in an Explicit analysis.
    StandardOnly,
}

/// A basic translational or rotational type: half of a connector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Half {
    /// The manual's name.
    pub name: &'static str,
    /// Translational or rotational.
    pub class: Class,
    /// Components 1–3 or 4–6.
    pub slots: [Slot; 3],
    /// How their forces or moments load the nodes.
    pub loading: [Loading; 3],
    /// The moment that the page prints, and how well it is documented, where it is not that of the conjugate components.
    pub printed: Option<(PrintedMoment, Evidence)>,
    /// The rules at a and at b.
    pub orientation: [OrientationRule; 2],
    /// Whether it can be used in two-dimensional and axisymmetric analysis (CONN2D2), where components u1, u2 and ur3 remain.
    pub planar: Availability,
    /// Where it can be used in three dimensions.
    pub availability: Availability,
    /// What it becomes in a Standard analysis, where that is another type.
    pub in_standard: Option<&'static Half>,
    /// The forces or moments in words, with the manual's symbols.
    pub forces: &'static str,
    /// Predefined friction when used by itself.
    pub friction: Option<Friction>,
    /// Whether the type gives rotational degrees of freedom to the nodes at which it permits an orientation.
    pub activates_rotations: bool,
    /// Whether the components are lengths and angles against which stops and references can be given.
    pub stops: bool,
    /// Where the facts come from.
    pub source: &'static str,
    /// A remark that a user of the type should read.
    pub note: &'static str,
}

/// A connection type, or a free pair of two basic ones.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConnectionType {
    /// The manual's name, or `CARTESIAN + CARDAN` for a free pair.
    pub name: Cow<'static, str>,
    /// The manual's class.
    pub class: Class,
    /// The translational and rotational half it is made of; a complex type has none.
    pub halves: [Option<&'static Half>; 2],
    /// u1, u2, u3, ur1, ur2, ur3.
    pub slots: [Slot; 6],
    /// How their forces and moments load the nodes.
    pub loading: [Loading; 6],
    /// The moment that the pages print, and how well it is documented, where it is not that of the conjugate components.
    pub printed: Option<(PrintedMoment, Evidence)>,
    /// The rules at a and at b.
    pub orientation: [OrientationRule; 2],
    /// Two-dimensional and axisymmetric use.
    pub planar: Availability,
    /// Three-dimensional use.
    pub availability: Availability,
    /// Forces and moments in words.
    pub forces: [&'static str; 2],
    /// Predefined friction.
    pub friction: Option<Friction>,
    /// Whether stops and constitutive references can be given.
    pub stops: bool,
    /// Whether degree of freedom 10 is active at a and at b.
    pub flow: [bool; 2],
    /// Whether the type gives rotational degrees of freedom to a and to b: it does where it permits an orientation, but for JOIN,
    /// AXIAL and LINK. Without them from elsewhere, a node's directions stay fixed and no moment acts on it.
    pub rotations: [bool; 2],
    /// Where the facts come from.
    pub source: [&'static str; 2],
    /// Remarks.
    pub notes: [&'static str; 2],
}

impl ConnectionType {
    /// What the components measure as positions, in their order.
    pub fn positions(&self) -> impl Iterator<Item = Measure> + '_ {
        self.slots.iter().filter_map(|slot| slot.position())
    }

    /// Those of [`ConnectionType::positions`] that have a singular set.
    pub fn singular_measures(&self) -> impl Iterator<Item = Measure> + '_ {
        self.positions().filter(|measure| measure.singular_set().is_some())
    }

    /// A basic type by itself.
    pub const fn basic(half: &'static Half) -> Self {
        let [s1, s2, s3] = half.slots;
        let absent = Slot::Absent;
        let [l1, l2, l3] = half.loading;
        let none = Loading::Conjugate;
        let translational = matches!(half.class, Class::BasicTranslational);
        let (slots, loading, halves, forces) = if translational {
            let slots = [s1, s2, s3, absent, absent, absent];
            (slots, [l1, l2, l3, none, none, none], [Some(half), None], [half.forces, ""])
        } else {
            let slots = [absent, absent, absent, s1, s2, s3];
            (slots, [none, none, none, l1, l2, l3], [None, Some(half)], ["", half.forces])
        };
        Self {
            name: Cow::Borrowed(half.name),
            class: half.class,
            halves,
            slots,
            loading,
            printed: half.printed,
            orientation: half.orientation,
            planar: half.planar,
            availability: half.availability,
            forces,
            friction: half.friction,
            stops: half.stops,
            flow: flow_of(&slots),
            rotations: rotations_of(half),
            source: [half.source, ""],
            notes: [half.note, ""],
        }
    }

    /// An assembled type: the slots of its halves, at each node the stricter of their orientation rules, available where both
    /// are.
    pub const fn assembled(
        name: &'static str,
        translational: &'static Half,
        rotational: &'static Half,
        friction: Option<Friction>,
        source: &'static str,
    ) -> Self {
        Self::joined(Cow::Borrowed(name), translational, rotational, friction, [source, ""])
    }

    const fn joined(
        name: Cow<'static, str>,
        t: &'static Half,
        r: &'static Half,
        friction: Option<Friction>,
        source: [&'static str; 2],
    ) -> Self {
        let slots = [t.slots[0], t.slots[1], t.slots[2], r.slots[0], r.slots[1], r.slots[2]];
        Self {
            name,
            class: Class::Assembled,
            halves: [Some(t), Some(r)],
            slots,
            loading: [t.loading[0], t.loading[1], t.loading[2], r.loading[0], r.loading[1], r.loading[2]],
            printed: r.printed,
            orientation: [
                stricter(t.orientation[0], r.orientation[0]),
                stricter(t.orientation[1], r.orientation[1]),
            ],
            planar: both(t.planar, r.planar),
            availability: both(t.availability, r.availability),
            forces: [t.forces, r.forces],
            friction,
            stops: t.stops || r.stops,
            flow: flow_of(&slots),
            rotations: [rotations_of(t)[0] || rotations_of(r)[0], rotations_of(t)[1] || rotations_of(r)[1]],
            source,
            notes: [t.note, r.note],
        }
    }

    /// The type of a connector section that names `first` and, optionally, `second` (either order), ignoring case.
    ///
    /// A basic pair that equals an assembled type *is* that type, including its predefined friction.
    ///
    /// # Errors
    /// [`NameError`] says which name or which combination there is not.
    ///
    /// ```
    /// use pintle_kinematics::catalog::ConnectionType;
    /// assert_eq!(ConnectionType::named("Revolute", Some("JOIN")).unwrap().name, "HINGE");
    /// assert_eq!(ConnectionType::named("cartesian", Some("cardan")).unwrap().name, "CARTESIAN + CARDAN");
    /// assert!(ConnectionType::named("HINGE", Some("JOIN")).is_err());
    /// ```
    pub fn named(first: &str, second: Option<&str>) -> Result<Self, NameError> {
        let one = Self::find(first)?;
        let Some(second) = second else { return Ok(one.clone()) };
        let other = Self::find(second)?;
        let (translational, rotational) = match (one.halves, other.halves) {
            ([Some(t), None], [None, Some(r)]) | ([None, Some(r)], [Some(t), None]) => (t, r),
            _ => return Err(NameError::Pair { first: one.name.to_string(), second: other.name.to_string() }),
        };
        Ok(Self::pair(translational, rotational))
    }

    /// The type that a basic pair makes: the assembled type of the same halves, if there is one.
    fn pair(translational: &'static Half, rotational: &'static Half) -> Self {
        let equal = TABLE.iter().find(|entry| entry.halves == [Some(translational), Some(rotational)]);
        equal.cloned().unwrap_or_else(|| {
            let name = Cow::Owned(format!("{} + {}", translational.name, rotational.name));
            Self::joined(name, translational, rotational, None, [translational.source, rotational.source])
        })
    }

    /// What the type becomes in a Standard analysis, where that is another one: ACCELEROMETER becomes CARTESIAN.
    ///
    /// ```
    /// use pintle_kinematics::catalog::ConnectionType;
    /// let accelerometer = ConnectionType::named("ACCELEROMETER", None).unwrap();
    /// assert_eq!(accelerometer.in_standard().unwrap().name, "CARTESIAN");
    /// ```
    pub fn in_standard(&self) -> Option<Self> {
        let [translational, rotational] = self.halves;
        let becomes = translational?.in_standard?;
        Some(match rotational {
            Some(rotational) => Self::pair(becomes, rotational),
            None => Self::basic(becomes),
        })
    }

    /// The two-dimensional form: u3, ur1 and ur2 do not exist. Of a SLIPRING the flow at a, its component 3, is then read at the
    /// node, as degree of freedom 10.
    ///
    /// ```
    /// use pintle_kinematics::catalog::{ConnectionType, Slot};
    /// let slot = ConnectionType::named("SLOT", None).unwrap().in_plane();
    /// assert_eq!(slot.component_list(Slot::is_constrained), "u2");
    /// ```
    pub fn in_plane(&self) -> Self {
        let mut form = self.clone();
        for (k, slot) in form.slots.iter_mut().enumerate() {
            if !PLANE[k] {
                *slot = Slot::Absent;
            }
        }
        form
    }

    fn find(name: &str) -> Result<&'static Self, NameError> {
        let name = name.trim();
        TABLE
            .iter()
            .find(|entry| entry.name.eq_ignore_ascii_case(name))
            .ok_or_else(|| NameError::Unknown { name: name.to_string(), nearest: nearest(name) })
    }

    /// How the force of component k (0-based) loads the nodes; `None` where there is no such force: an absent component, or one
    /// for output only.
    pub const fn loading(&self, k: usize) -> Option<Loading> {
        match self.slots[k] {
            Slot::Absent | Slot::Measured(_) => None,
            Slot::Available(_) | Slot::Constrained(..) => Some(self.loading[k]),
        }
    }

    /// The indices (0-based) of the components that satisfy a condition.
    pub fn components(&self, condition: impl Fn(Slot) -> bool) -> impl Iterator<Item = usize> {
        (0..6).filter(move |k| condition(self.slots[*k]))
    }

    /// The forces and moments, in the manual's symbols, of the components that satisfy a condition: `f2, f3, m1`, or `none`.
    pub fn force_list(&self, condition: impl Fn(Slot) -> bool) -> String {
        list(self.components(condition).map(|k| FORCE[k]))
    }

    /// The components, in the manual's symbols, that satisfy a condition: `u2, u3`, or `none`.
    pub fn component_list(&self, condition: impl Fn(Slot) -> bool) -> String {
        list(self.components(condition).map(|k| COMPONENT[k]))
    }

    /// The kinematic constraints as the summary table prints them: the formulas of a basic type, `SLOT + ALIGN` of an
    /// assembled one, or `none`.
    pub fn constraint_list(&self) -> String {
        if let [Some(t), Some(r)] = self.halves {
            return format!("{} + {}", t.name, r.name);
        }
        let conditions = self.components(Slot::is_constrained).filter_map(|k| self.constraint(k));
        let conditions: Vec<String> = conditions.collect();
        if conditions.is_empty() { "none".into() } else { conditions.join(", ") }
    }

    /// What component k (0-based) enforces, as an equation; `None` where it is not constrained.
    pub fn constraint(&self, k: usize) -> Option<String> {
        let Slot::Constrained(position, condition) = self.slots[k] else { return None };
        Some(match condition {
            Condition::Held => format!("{} = {}0", position.formula(), self.symbol(k, position)),
            Condition::ZeroOrHeld(printed) | Condition::Zero(printed) => format!("{} = 0", printed.formula()),
        })
    }

    /// The connector stops, `θ1min ≤ α ≤ θ1max`, or `none`.
    pub fn stop_list(&self) -> String {
        list(self.limits().map(|(k, measure)| {
            let limit = limit_symbol(k, measure);
            format!("{limit}min ≤ {} ≤ {limit}max", self.symbol(k, measure))
        }))
    }

    /// The constitutive reference lengths, angles and strains, `l1ref`, `θ1ref`, `ε1ref`, or `none`.
    pub fn reference_list(&self) -> String {
        let strains = (0..6).filter_map(|k| match self.slots[k] {
            Slot::Available(measure @ Measure::Strain) => Some((k, measure)),
            _ => None,
        });
        list(self.limits().chain(strains).map(|(k, measure)| format!("{}ref", limit_symbol(k, measure))))
    }

    /// The manual's symbol of the position of component k (0-based): that of its measure, but l along a slot and along the
    /// axis from which a radius is measured.
    fn symbol(&self, k: usize, position: Measure) -> &'static str {
        let slot = k == 0 && self.slots[0].is_available() && self.slots[1].is_constrained();
        let axis = k == 2 && self.slots[0].position() == Some(Measure::RadialDistance);
        if slot || axis { Measure::Distance.symbol() } else { position.symbol() }
    }

    fn limits(&self) -> impl Iterator<Item = (usize, Measure)> + '_ {
        (0..6).filter_map(|k| match self.slots[k] {
            Slot::Available(measure) if self.stops => Some((k, measure)),
            _ => None,
        })
    }
}

/// `l1`, `θ3`: the symbol of a limit or reference of component k (0-based).
fn limit_symbol(k: usize, measure: Measure) -> String {
    match measure.unit() {
        Unit::Angle => format!("θ{}", k % 3 + 1),
        Unit::Length => format!("l{}", k % 3 + 1),
        Unit::None => format!("ε{}", k % 3 + 1),
    }
}

fn list<T: ToString>(items: impl Iterator<Item = T>) -> String {
    let items: Vec<String> = items.map(|item| item.to_string()).collect();
    if items.is_empty() { "none".into() } else { items.join(", ") }
}

/// The name in the table closest to `name`, for the remedy of an error.
fn nearest(name: &str) -> Option<&'static str> {
    let upper = name.to_ascii_uppercase();
    TABLE
        .iter()
        .map(|entry| (strsim::damerau_levenshtein(&entry.name, &upper), entry))
        .filter(|(distance, entry)| *distance <= entry.name.len() / 3)
        .min_by_key(|(distance, _)| *distance)
        .and_then(|(_, entry)| match &entry.name {
            Cow::Borrowed(name) => Some(*name),
            Cow::Owned(_) => None,
        })
}

/// The stricter of two rules; of two equally strict ones the first, unless only the second has been read.
const fn stricter(x: OrientationRule, y: OrientationRule) -> OrientationRule {
    let (of_x, of_y) = (x.orientation as u8, y.orientation as u8);
    let only_y_is_read =
        matches!(x.evidence, Evidence::P | Evidence::R) && matches!(y.evidence, Evidence::S | Evidence::D);
    if of_x > of_y || (of_x == of_y && !only_y_is_read) { x } else { y }
}

const fn both(x: Availability, y: Availability) -> Availability {
    match (x, y) {
        (Availability::Always, other) | (other, Availability::Always) => other,
        (Availability::ExplicitOnly, Availability::ExplicitOnly) => Availability::ExplicitOnly,
        (Availability::StandardOnly, Availability::StandardOnly) => Availability::StandardOnly,
        _ => Availability::Never,
    }
}

/// The nodes that a half gives rotations.
const fn rotations_of(half: &Half) -> [bool; 2] {
    let [a, b] = half.orientation;
    let permitted =
        [!matches!(a.orientation, Orientation::Ignored), !matches!(b.orientation, Orientation::Ignored)];
    [half.activates_rotations && permitted[0], half.activates_rotations && permitted[1]]
}

const fn flow_of(slots: &[Slot; 6]) -> [bool; 2] {
    let mut flow = [false; 2];
    let mut k = 0;
    while k < 6 {
        match slots[k].position() {
            Some(Measure::Strain | Measure::Flow(_)) => flow = [true, true],
            Some(Measure::FlowConversion) => flow[1] = true,
            _ => {}
        }
        k += 1;
    }
    flow
}

/// A name, or a pair of names, that is no connection type.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NameError {
    /// No type of that name.
    #[error("there is no connection type {name:?}{}", nearest.map(|n| format!("; did you mean {n}?")).unwrap_or_default())]
    Unknown {
        /// What was asked for.
        name: String,
        /// The most similar type.
        nearest: Option<&'static str>,
    },
    /// Two types that do not pair.
    #[error(
        "{first} and {second} do not pair: a connector takes one basic translational and one basic rotational type, \
         or one assembled or complex type alone"
    )]
    Pair {
        /// The first name.
        first: String,
        /// The second name.
        second: String,
    },
}
