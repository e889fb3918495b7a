//! `*CONNECTOR BEHAVIOR` and its suboptions, as a deck gives them.
//!
//! Components are 1 to 6 (u1, u2, u3, ur1, ur2, ur3). Angles are radians, except in
//! [`Behavior::constitutive_reference`].

use crate::choice::choices;
use crate::span::{Span, Spanned};
use indexmap::IndexMap;
use serde::Serialize;

/// A connector behaviour.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Behavior {
    /// What holds beyond the ends of tables.
    pub table: TableOptions,
    /// `INTEGRATION=`.
    pub integration: Option<Integration>,
    /// Reference lengths of components 1 to 3 and reference angles, **in degrees**, of 4 to 6.
    /// None: the initial geometry.
    pub constitutive_reference: [Option<f64>; 6],
    /// The data line of `*CONNECTOR CONSTITUTIVE REFERENCE`.
    #[serde(skip)]
    pub constitutive_reference_span: Span,
    /// `*CONNECTOR ELASTICITY`.
    pub elasticity: Vec<Elasticity>,
    /// `*CONNECTOR DAMPING`.
    pub damping: Vec<Damping>,
    /// `*CONNECTOR FRICTION`.
    pub friction: Vec<Friction>,
    /// Derived components by name, each a sum of terms.
    pub derived_components: IndexMap<String, Vec<DerivedTerm>>,
    /// `*CONNECTOR PLASTICITY`.
    pub plasticity: Vec<Plasticity>,
    /// `*CONNECTOR DAMAGE INITIATION`.
    pub damage: Vec<Damage>,
    /// The components (1 to 6) of `*CONNECTOR UNIAXIAL BEHAVIOR`, whose curves are not read.
    #[serde(skip)]
    pub uniaxial: Vec<u8>,
    /// `*CONNECTOR STOP`.
    pub stops: Vec<Stop>,
    /// `*CONNECTOR LOCK`.
    pub locks: Vec<Lock>,
    /// `*CONNECTOR FAILURE`.
    pub failures: Vec<Failure>,
    /// The keyword.
    #[serde(skip)]
    pub span: Span,
}

impl Behavior {
    /// The keywords of its suboptions, as a deck writes them without the asterisk, with the number of each; those that are not
    /// there are left out.
    pub fn suboptions(&self) -> impl Iterator<Item = (&'static str, usize)> {
        let potentials = |damage: &Damage| {
            usize::from(damage.potential.is_some())
                + usize::from(
                    damage.evolution.as_ref().is_some_and(|evolution| evolution.potential.is_some()),
                )
        };
        let of_friction = |friction: &Friction| {
            usize::from(matches!(&friction.kind, FrictionKind::User { potential: Some(_), .. }))
        };
        let in_potentials = self.friction.iter().map(of_friction).sum::<usize>()
            + self.plasticity.iter().filter(|plasticity| plasticity.potential.is_some()).count()
            + self.damage.iter().map(potentials).sum::<usize>();
        let reference = usize::from(self.constitutive_reference.iter().any(Option::is_some));
        [
            ("CONNECTOR CONSTITUTIVE REFERENCE", reference),
            ("CONNECTOR ELASTICITY", self.elasticity.len()),
            ("CONNECTOR DAMPING", self.damping.len()),
            ("CONNECTOR FRICTION", self.friction.len()),
            ("CONNECTOR DERIVED COMPONENT", self.derived_components.values().map(Vec::len).sum()),
            ("CONNECTOR POTENTIAL", in_potentials),
            ("CONNECTOR PLASTICITY", self.plasticity.len()),
            (
                "CONNECTOR HARDENING",
                self.plasticity.iter().map(|plasticity| plasticity.hardening.len()).sum(),
            ),
            ("CONNECTOR DAMAGE INITIATION", self.damage.len()),
            (
                "CONNECTOR DAMAGE EVOLUTION",
                self.damage.iter().filter(|damage| damage.evolution.is_some()).count(),
            ),
            ("CONNECTOR STOP", self.stops.len()),
            ("CONNECTOR LOCK", self.locks.len()),
            ("CONNECTOR FAILURE", self.failures.len()),
        ]
        .into_iter()
        .filter(|(_, count)| *count > 0)
    }

    /// Lower and upper limit of each component's position (CP): of several stops the tighter ones. `None` where there is no stop.
    #[must_use]
    pub fn limits_of_stops(&self) -> [Option<[Option<f64>; 2]>; 6] {
        let mut all = [None; 6];
        for stop in &self.stops {
            let Some(limits) = all.get_mut(usize::from(stop.component).wrapping_sub(1)) else { continue };
            let [lower, upper] = limits.unwrap_or([None; 2]);
            let tighter = |known: Option<f64>, new: Option<f64>, of: fn(f64, f64) -> f64| {
                known.map_or(new, |known| Some(new.map_or(known, |new| of(known, new))))
            };
            *limits = Some([tighter(lower, stop.lower, f64::max), tighter(upper, stop.upper, f64::min)]);
        }
        all
    }

    /// The number of items under `*CONNECTOR FRICTION, PREDEFINED`, without empty ones at the end; none if the behaviour has
    /// no predefined friction.
    #[must_use]
    pub fn predefined_friction_parameters(&self) -> Option<usize> {
        self.friction.iter().find_map(|friction| match &friction.kind {
            FrictionKind::Predefined { constants } => {
                Some(constants.iter().rposition(Option::is_some).map_or(0, |last| last + 1))
            }
            FrictionKind::User { .. } => None,
        })
    }

    /// The components, 1 to 6, to which elasticity, damping, friction, plasticity and damage are attached. Not among them:
    /// coupled tables, whose entries for constrained components are ignored; locks and failures, whose triggers may be
    /// constrained components.
    pub fn acts_on(&self) -> impl Iterator<Item = u8> + '_ {
        let laws = self.elasticity.iter().map(|e| &e.law).chain(self.damping.iter().map(|d| &d.law));
        let slips = self.friction.iter().filter_map(|friction| match &friction.kind {
            FrictionKind::User { component, .. } => *component,
            FrictionKind::Predefined { .. } => None,
        });
        let plastic = self.plasticity.iter().filter_map(|plasticity| plasticity.component);
        let damaged = self.damage.iter().filter_map(|damage| damage.component);
        laws.flat_map(Law::components).copied().chain(slips).chain(plastic).chain(damaged)
    }

    /// Where those of [`Behavior::acts_on`] that act on a component (1 to 6) were read.
    pub fn places_of_action(&self, component: u8) -> impl Iterator<Item = Span> + '_ {
        let laws = self.elasticity.iter().map(|e| (&e.law, e.span));
        let laws = laws.chain(self.damping.iter().map(|d| (&d.law, d.span)));
        let laws = laws.filter(move |(law, _)| law.components().contains(&component)).map(|(_, span)| span);
        let slips = self.friction.iter().filter(
            move |friction| matches!(friction.kind, FrictionKind::User { component: Some(of), .. } if of == component),
        );
        let plastic =
            self.plasticity.iter().filter(move |plasticity| plasticity.component == Some(component));
        let damaged = self.damage.iter().filter(move |damage| damage.component == Some(component));
        let rest =
            slips.map(|friction| friction.span).chain(plastic.map(|p| p.span)).chain(damaged.map(|d| d.span));
        laws.chain(rest)
    }

    /// Where the predefined friction was read.
    #[must_use]
    pub fn place_of_predefined_friction(&self) -> Option<Span> {
        let mut all = self.friction.iter();
        all.find(|friction| matches!(friction.kind, FrictionKind::Predefined { .. }))
            .map(|friction| friction.span)
    }

    /// Where each elasticity and damping was read whose law satisfies a condition.
    pub fn places_of_law(&self, condition: impl Fn(&Law) -> bool) -> impl Iterator<Item = Span> {
        let laws = self.elasticity.iter().map(|e| (&e.law, e.span));
        let laws = laws.chain(self.damping.iter().map(|d| (&d.law, d.span)));
        laws.filter(move |(law, _)| condition(law)).map(|(_, span)| span)
    }
}

impl Law {
    /// The components that it gives forces, one by one; none for a coupled law.
    pub fn components(&self) -> &[u8] {
        match self {
            Self::Linear { component, .. } | Self::Nonlinear { component, .. } => {
                std::slice::from_ref(component)
            }
            Self::Rigid { components } => components,
            Self::Coupled { .. } => &[],
        }
    }

    /// Whether it depends on frequency.
    #[must_use]
    pub fn depends_on_frequency(&self) -> bool {
        match self {
            Self::Linear { rows, .. } => rows.iter().any(|row| matches!(row.values.get(1), Some(Some(_)))),
            Self::Coupled { frequency, .. } => *frequency,
            Self::Nonlinear { .. } | Self::Rigid { .. } => false,
        }
    }

    /// Whether its matrix is unsymmetric.
    #[must_use]
    pub fn is_unsymmetric(&self) -> bool {
        matches!(self, Self::Coupled { unsymmetric: true, .. })
    }
}

choices! {
    /// How a behaviour is integrated in Abaqus/Explicit.
    pub enum Integration {
        /// Implicitly.
        Implicit = "IMPLICIT",
        /// Explicitly.
        Explicit = "EXPLICIT",
    }

    /// What a table gives beyond its first and last row.
    pub enum Extrapolation {
        /// The value at the end.
        Constant = "CONSTANT",
        /// The line through the two rows at the end.
        Linear = "LINEAR",
    }

    /// What of the independent components a table depends on.
    #[derive(Default)]
    pub enum Basis {
        /// Their positions (CP).
        #[default]
        Position = "POSITION",
        /// Their displacements from the constitutive reference (CCU).
        ConstitutiveMotion = "CONSTITUTIVE MOTION",
    }

    /// What a damping is proportional to.
    pub enum DampingKind {
        /// The velocity.
        Viscous = "VISCOUS",
        /// The elastic force, in a harmonic response.
        Structural = "STRUCTURAL",
    }

    /// How a term of a derived component combines the components x_i with the scale factors s_i.
    pub enum Operator {
        /// √(Σ (s_i x_i)²).
        Norm = "NORM",
        /// Σ s_i x_i.
        Sum = "SUM",
        /// Σ ⟨s_i x_i⟩ with ⟨x⟩ = max(x, 0).
        MacauleySum = "MACAULEY SUM",
    }

    /// How a potential combines its contributions P_i.
    pub enum PotentialOperator {
        /// (Σ P_i)^(1/β).
        Sum = "SUM",
        /// (max P_i)^(1/β).
        Max = "MAX",
    }

    /// The function H of a contribution to a potential.
    pub enum PotentialFunction {
        /// |x|.
        Abs = "ABS",
        /// max(x, 0).
        Macauley = "MACAULEY",
        /// x.
        None = "NONE",
    }

    /// What grows with plastic motion.
    #[derive(Default)]
    pub enum HardeningKind {
        /// The size of the elastic range.
        #[default]
        Isotropic = "ISOTROPIC",
        /// The backforce: the middle of the elastic range.
        Kinematic = "KINEMATIC",
    }

    /// How a hardening is given.
    pub enum HardeningDefinition {
        /// Isotropic: yield force over equivalent plastic motion, and its rate.
        Tabular = "TABULAR",
        /// Isotropic: F0 + Q∞ (1 − exp(−b·plastic motion)).
        ExponentialLaw = "EXPONENTIAL LAW",
        /// Kinematic: force over plastic motion of half a cycle.
        HalfCycle = "HALF CYCLE",
        /// Kinematic: force over plastic motion of a stabilised cycle, for a range of motion.
        Stabilized = "STABILIZED",
        /// Kinematic: F0, C, γ.
        Parameters = "PARAMETERS",
    }

    /// How the rate of a table is interpolated.
    pub enum RateInterpolation {
        /// Linearly.
        Linear = "LINEAR",
        /// In the logarithm of the rate.
        Logarithmic = "LOGARITHMIC",
    }

    /// What begins damage.
    pub enum DamageCriterion {
        /// A force.
        Force = "FORCE",
        /// A displacement.
        Motion = "MOTION",
        /// An equivalent plastic motion.
        PlasticMotion = "PLASTIC MOTION",
    }

    /// What a damage evolution is measured by.
    pub enum DamageEvolutionKind {
        /// Motion after the beginning of damage.
        Motion = "MOTION",
        /// The energy dissipated by it.
        Energy = "ENERGY",
    }

    /// How damage grows with motion.
    pub enum Softening {
        /// Linearly, to 1.
        Linear = "LINEAR",
        /// Exponentially, to 1.
        Exponential = "EXPONENTIAL",
        /// By a table of damage over motion.
        Tabular = "TABULAR",
    }

    /// How several damages of one component combine.
    pub enum Degradation {
        /// The largest counts.
        Maximum = "MAXIMUM",
        /// They multiply.
        Multiplicative = "MULTIPLICATIVE",
    }
}

impl HardeningKind {
    /// The definition that is meant when none is given.
    #[must_use]
    pub const fn definition(self) -> HardeningDefinition {
        match self {
            Self::Isotropic => HardeningDefinition::Tabular,
            Self::Kinematic => HardeningDefinition::HalfCycle,
        }
    }
}

impl HardeningDefinition {
    /// The names of the columns of its table.
    #[must_use]
    pub fn columns(self) -> &'static [&'static str] {
        match self {
            Self::Tabular => &["force", "plastic motion", "rate"],
            Self::ExponentialLaw => &["F0", "Q_inf", "b"],
            Self::HalfCycle => &["force", "plastic motion"],
            Self::Stabilized => &["force", "plastic motion", "motion range"],
            Self::Parameters => &["F0", "C", "gamma"],
        }
    }

    /// How many of the columns may not be empty.
    #[must_use]
    pub fn needed_columns(self) -> usize {
        if self == Self::ExponentialLaw { 3 } else { 2 }
    }

    /// The kind of hardening that it gives.
    #[must_use]
    pub fn kind(self) -> HardeningKind {
        match self {
            Self::Tabular | Self::ExponentialLaw => HardeningKind::Isotropic,
            Self::HalfCycle | Self::Stabilized | Self::Parameters => HardeningKind::Kinematic,
        }
    }
}

/// What a table does between and beyond its rows.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct TableOptions {
    /// `EXTRAPOLATION=`; none is that of the behaviour, and there constant.
    pub extrapolation: Option<Extrapolation>,
    /// `REGULARIZE=` ON or OFF.
    pub regularize: Option<bool>,
    /// `RTOL=`.
    pub rtol: Option<f64>,
}

/// One row of a table: the columns that its owner names, then temperature and field variables.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct TableRow {
    /// The columns; none where the deck leaves an item empty.
    pub values: Vec<Option<f64>>,
    /// The temperature, if the row depends on it.
    pub temperature: Option<f64>,
    /// Field variables, as many as `DEPENDENCIES=` says.
    pub fields: Vec<Option<f64>>,
    /// The first data line.
    #[serde(skip)]
    pub span: Span,
}

/// `INDEPENDENT COMPONENTS=` and the components listed under it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Independent {
    /// What of the components counts.
    pub basis: Basis,
    /// The components.
    pub components: Vec<u8>,
}

/// How a force depends on its component.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Law {
    /// One component. Columns: coefficient, frequency.
    Linear {
        /// The component.
        component: u8,
        /// The table.
        rows: Vec<TableRow>,
    },
    /// All components. Columns: the matrix, then the frequency if there is one. A symmetric matrix has 21
    /// terms, D11, D12, D22, D13, D23, D33 … (columns of the upper triangle); an unsymmetric one 36.
    Coupled {
        /// Are there 36 terms?
        unsymmetric: bool,
        /// `FREQUENCY DEPENDENCE`: a column more.
        frequency: bool,
        /// The table.
        rows: Vec<TableRow>,
    },
    /// One component. Columns of an elasticity: force, then displacement, or one column per independent component; of a
    /// damping: force, velocity, then one column per independent component.
    Nonlinear {
        /// The component.
        component: u8,
        /// The components on which the force depends, if not on its own.
        independent: Option<Independent>,
        /// The table.
        rows: Vec<TableRow>,
    },
    /// No motion at all.
    Rigid {
        /// The components; all available ones when there is none.
        components: Vec<u8>,
    },
}

/// `*CONNECTOR ELASTICITY`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Elasticity {
    /// Force over constitutive displacement.
    pub law: Law,
    /// Between and beyond the rows.
    pub table: TableOptions,
    /// The keyword.
    #[serde(skip)]
    pub span: Span,
}

/// `*CONNECTOR DAMPING`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Damping {
    /// `TYPE=`.
    pub kind: DampingKind,
    /// Force over velocity.
    pub law: Law,
    /// Between and beyond the rows.
    pub table: TableOptions,
    /// The keyword.
    #[serde(skip)]
    pub span: Span,
}

/// What presses, or what slips.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// A component.
    Component(u8),
    /// A derived component of the same behaviour.
    Derived(String),
}

/// `*CONNECTOR FRICTION` with its `*FRICTION`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Friction {
    /// `STICK STIFFNESS=`.
    pub stick_stiffness: Option<f64>,
    /// Predefined for the connection type, or by the user.
    pub kind: FrictionKind,
    /// The friction coefficient.
    pub coefficient: Option<FrictionCoefficient>,
    /// Between and beyond the rows.
    pub table: TableOptions,
    /// The keyword.
    #[serde(skip)]
    pub span: Span,
}

/// Who says what rubs on what.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FrictionKind {
    /// The connection type: geometric constants in its order, then internal contact forces.
    Predefined {
        /// The items of the data line.
        constants: Vec<Option<f64>>,
    },
    /// The deck.
    User {
        /// The component that slips; none when a potential says it.
        component: Option<u8>,
        /// The direction of slip.
        potential: Option<Potential>,
        /// The normal force.
        contact_force: Option<Spanned<Source>>,
        /// The components on which the internal contact force depends.
        independent: Option<Independent>,
        /// Effective radius if translations and rotations mix, internal contact force, independent motions,
        /// accumulated slip, temperature, field variables: as written, for which is there depends on the type.
        rows: Vec<Vec<Option<f64>>>,
    },
}

/// `*FRICTION` under `*CONNECTOR FRICTION`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FrictionCoefficient {
    /// How μ is given.
    pub law: FrictionLaw,
    /// `TAUMAX=`: the largest friction force.
    pub maximum: Option<f64>,
    /// `SLIP TOLERANCE=`.
    pub slip_tolerance: Option<f64>,
    /// `ELASTIC SLIP=`: the elastic slip allowed, in the unit of the slip; in place of the tolerance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub elastic_slip: Option<f64>,
    /// The keyword.
    #[serde(skip)]
    pub span: Span,
}

/// How a friction coefficient is given.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FrictionLaw {
    /// Columns: μ, slip rate, contact force.
    Table(Vec<TableRow>),
    /// μ = μ_k + (μ_s − μ_k) exp(−d_c·slip rate).
    Exponential {
        /// μ_s.
        static_coefficient: f64,
        /// μ_k.
        kinetic_coefficient: f64,
        /// d_c.
        decay: f64,
    },
    /// `TEST DATA`: the items as written.
    TestData(Vec<Vec<Option<f64>>>),
}

/// One term of a derived component.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DerivedTerm {
    /// How the components are combined.
    pub operator: Operator,
    /// +1 or −1.
    pub sign: f64,
    /// The components.
    pub components: Vec<u8>,
    /// The components on which the scale factors depend.
    pub independent: Option<Independent>,
    /// Columns: one scale factor per component, then one value per independent component. No row: factors 1.
    pub rows: Vec<TableRow>,
    /// Between and beyond the rows.
    pub table: TableOptions,
    /// The keyword.
    #[serde(skip)]
    pub span: Span,
}

/// `*CONNECTOR POTENTIAL`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Potential {
    /// How the contributions are combined.
    pub operator: PotentialOperator,
    /// β, 2 by default.
    pub exponent: f64,
    /// The contributions.
    pub terms: Vec<PotentialTerm>,
    /// The keyword.
    #[serde(skip)]
    pub span: Span,
}

/// A contribution sign·H(X/R − a)^α to a potential.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PotentialTerm {
    /// X.
    pub source: Spanned<Source>,
    /// R, 1 by default.
    pub scale: f64,
    /// α; none is β.
    pub exponent: Option<f64>,
    /// H.
    pub function: PotentialFunction,
    /// a, 0 by default.
    pub shift: f64,
    /// +1 or −1.
    pub sign: f64,
}

/// `*CONNECTOR PLASTICITY`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Plasticity {
    /// The component; none is coupled, with a potential.
    pub component: Option<u8>,
    /// The yield function.
    pub potential: Option<Potential>,
    /// `*CONNECTOR HARDENING`.
    pub hardening: Vec<Hardening>,
    /// The keyword.
    #[serde(skip)]
    pub span: Span,
}

/// `*CONNECTOR HARDENING`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Hardening {
    /// `TYPE=`.
    pub kind: HardeningKind,
    /// `DEFINITION=`: what the columns are.
    pub definition: HardeningDefinition,
    /// `RATE FILTER FACTOR=`.
    pub rate_filter: Option<f64>,
    /// `RATE INTERPOLATION=`.
    pub rate_interpolation: Option<RateInterpolation>,
    /// The table, with the columns of [`HardeningDefinition::columns`].
    pub rows: Vec<TableRow>,
    /// Between and beyond the rows.
    pub table: TableOptions,
}

/// `*CONNECTOR DAMAGE INITIATION` with its evolution.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Damage {
    /// What is compared with the limits.
    pub criterion: DamageCriterion,
    /// The component; none is coupled, with a potential.
    pub component: Option<u8>,
    /// What is compared with the limits of a coupled criterion.
    pub potential: Option<Potential>,
    /// FORCE, MOTION: lower and upper limit. PLASTIC MOTION: motion, mode mix, rate. Then temperature, fields: as written.
    pub rows: Vec<Vec<Option<f64>>>,
    /// `RATE FILTER FACTOR=`.
    pub rate_filter: Option<f64>,
    /// `RATE INTERPOLATION=`.
    pub rate_interpolation: Option<RateInterpolation>,
    /// `*CONNECTOR DAMAGE EVOLUTION`.
    pub evolution: Option<DamageEvolution>,
    /// Between and beyond the rows.
    pub table: TableOptions,
    /// The keyword.
    #[serde(skip)]
    pub span: Span,
}

/// `*CONNECTOR DAMAGE EVOLUTION`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DamageEvolution {
    /// `TYPE=`.
    pub kind: DamageEvolutionKind,
    /// `SOFTENING=`.
    pub softening: Softening,
    /// `DEGRADATION=`.
    pub degradation: Degradation,
    /// The components that are damaged; none is those of the initiation.
    pub affected: Vec<u8>,
    /// The motion of a coupled evolution.
    pub potential: Option<Potential>,
    /// LINEAR: u_f. EXPONENTIAL: u_f, exponent. TABULAR: d, u. ENERGY: E. Then mode mix, temperature, fields: as written.
    pub rows: Vec<Vec<Option<f64>>>,
    /// Between and beyond the rows.
    pub table: TableOptions,
}

/// `*CONNECTOR STOP`: lower ≤ position ≤ upper.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Stop {
    /// The component.
    pub component: u8,
    /// The lower limit of the position (CP); none is unbounded.
    pub lower: Option<f64>,
    /// The upper limit.
    pub upper: Option<f64>,
    /// The data line.
    #[serde(skip)]
    pub span: Span,
}

/// Everything, or one component.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Affected {
    /// All components.
    All,
    /// One.
    Component(u8),
}

/// Limits that trigger a lock or a failure; none is no limit.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Limits {
    /// Lower position.
    pub lower_position: Option<f64>,
    /// Upper position.
    pub upper_position: Option<f64>,
    /// Lower force or moment.
    pub lower_force: Option<f64>,
    /// Upper force or moment.
    pub upper_force: Option<f64>,
    /// The temperature, if the limits depend on it.
    pub temperature: Option<f64>,
    /// Field variables.
    pub fields: Vec<Option<f64>>,
}

/// `*CONNECTOR LOCK`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Lock {
    /// The component that triggers.
    pub component: u8,
    /// What is locked.
    pub locked: Affected,
    /// When.
    pub limits: Vec<Limits>,
    /// Between and beyond the rows.
    pub table: TableOptions,
    /// The keyword.
    #[serde(skip)]
    pub span: Span,
}

/// `*CONNECTOR FAILURE`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Failure {
    /// The component that triggers.
    pub component: u8,
    /// What is released.
    pub released: Affected,
    /// When.
    pub limits: Vec<Limits>,
    /// The keyword.
    #[serde(skip)]
    pub span: Span,
}
