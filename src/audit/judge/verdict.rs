//! What is said of numbers: verdicts, findings, and how mutants fared.

use crate::case::quantity::Quantity;
use crate::laws::demanded::Demanded;
use crate::mutants::cause::Cause;
use crate::mutants::mutant::Mistake;
use pintle_kinematics::scalar::Wide;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

pintle_kinematics::named! {
    /// What is said of a quantity at a state, the mildest first.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
    #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
    #[serde(rename_all = "kebab-case")]
    pub enum Verdict {
        /// Every entry is right to rounding.
        Pass = "pass",
        /// Every entry is as right as the state allows, which is not much: the point is ill-conditioned.
        IllConditioned = "ill-conditioned point",
        /// There is no derivative here, and one from each side, which differ.
        Kink = "kink",
        /// There is no derivative here that could be judged, and not one from each side either: a true singularity, a jump, or second
        /// derivatives on a kink. [`Finding::lack`] says which.
        Singular = "singular point",
        /// No independent oracle could answer.
        Undecided = "undecided",
        /// The formula is right and loses digits on doubles.
        UnstableFormula = "unstable formula",
        /// An entry is wrong.
        Wrong = "wrong",
        /// A number is infinite or not a number.
        Invalid = "invalid",
    }
}

impl Verdict {
    /// The verdict as a headline: a state that is ill-conditioned passes.
    pub const fn headline(self) -> Self {
        if matches!(self, Self::IllConditioned) { Self::Pass } else { self }
    }

    /// Whether it is a verified mismatch.
    pub const fn is_mismatch(self) -> bool {
        matches!(self, Self::UnstableFormula | Self::Wrong | Self::Invalid)
    }
}

/// A number of a connector, and by what it is multiplied where numbers are added up.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Summand {
    /// The kind of number.
    pub quantity: Quantity,
    /// The component (0-based).
    pub component: usize,
    /// The place within it.
    pub entry: usize,
    /// The factor.
    #[serde(with = "crate::case::hex")]
    pub by: f64,
}

/// One entry, what it is and what it must be.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Finding {
    /// The entry by name: `∂ur1/∂θb3`.
    pub entry: String,
    /// The component (0-based) and the place within it, where it is one entry of a connector's.
    #[serde(skip)]
    pub at: Option<(usize, usize)>,
    /// Where it is what a law demands of one state: which demand.
    #[serde(skip)]
    pub demanded: Option<Demanded>,
    /// Where it is a sum of numbers of a connector, as along a direction: which.
    #[serde(skip)]
    pub sum: Vec<Summand>,
    /// What was given.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub got: f64,
    /// What it must be.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub want: f64,
    /// How far apart they may be.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub tolerance: f64,
    /// |got − want| in units of the tolerance.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub units: f64,
    /// Where there is no derivative: those from below and from above, not a number from a side that has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(with = "Option<[Option<f64>; 2]>"))]
    pub one_sided: Option<[f64; 2]>,
    /// At a singular point that is no kink: what there is no derivative for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lack: Option<&'static str>,
}

impl Finding {
    /// Of an entry by its name alone, with what was given and what it must be.
    pub fn new(entry: String, [got, want]: [f64; 2], tolerance: f64, units: f64) -> Self {
        let (at, demanded, sum, one_sided, lack) = (None, None, Vec::new(), None, None);
        Self { entry, at, demanded, sum, got, want, tolerance, units, one_sided, lack }
    }
}

/// The outcome of one comparison.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Judgement {
    /// The verdict.
    pub verdict: Verdict,
    /// The entry that decided it, or that came nearest to its tolerance.
    pub worst: Option<Finding>,
    /// How many entries were compared.
    pub compared: usize,
}

/// What a number must be, as the sum of two doubles: 106 bits, with which the error of a double is right to its own last digits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    nearest: f64,
    rest: f64,
}

impl Wanted {
    /// A double that is taken for exact.
    pub const fn exactly(x: f64) -> Self {
        Self { nearest: x, rest: 0.0 }
    }

    /// The double that is nearest.
    pub const fn to_f64(self) -> f64 {
        self.nearest
    }

    /// The number with the other sign.
    pub const fn opposite(self) -> Self {
        Self { nearest: -self.nearest, rest: -self.rest }
    }

    /// |got − want|. Where the two are near each other got − nearest has no rounding; elsewhere the rest does not matter.
    pub fn error(self, got: f64) -> f64 {
        ((got - self.nearest) - self.rest).abs()
    }

    /// |got − want| in units of what is allowed; infinite where it is not a number.
    pub fn units(self, got: f64, allowed: f64) -> f64 {
        let error = self.error(got);
        if error == 0.0 {
            return 0.0;
        }
        let units = error / allowed;
        if units.is_nan() { f64::INFINITY } else { units }
    }
}

impl From<Wide> for Wanted {
    fn from(want: Wide) -> Self {
        let (nearest, rest) = want.split();
        Self { nearest, rest }
    }
}

/// |got − want| in units of what is allowed; infinite where it is not a number.
pub fn units(got: f64, want: Wide, allowed: f64) -> f64 {
    Wanted::from(want).units(got, allowed)
}

/// How mutants with one kind of mistake fared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Fared {
    /// Noticed.
    pub killed: u64,
    /// Changed nothing.
    pub equivalent: u64,
    /// Changed less than twice what is allowed.
    pub below_resolution: u64,
    /// Not noticed, though the change exceeds twice what is allowed.
    pub survived: u64,
}

impl Fared {
    /// Adds others.
    pub const fn add(&mut self, other: Self) {
        self.killed += other.killed;
        self.equivalent += other.equivalent;
        self.below_resolution += other.below_resolution;
        self.survived += other.survived;
    }

    /// Mutants that had to be noticed.
    pub const fn decisive(self) -> u64 {
        self.killed + self.survived
    }
}

/// How mutants of the same numbers fared.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Score {
    /// Noticed.
    pub killed: u64,
    /// Changed nothing.
    pub equivalent: u64,
    /// Changed less than twice what is allowed.
    pub below_resolution: u64,
    /// Not noticed, though the change exceeds twice what is allowed.
    pub survived: u64,
    /// By kind of mistake, by the code that explains it.
    #[cfg_attr(feature = "schema", schemars(with = "BTreeMap<String, Fared>"))]
    pub by_mistake: BTreeMap<Cause, Fared>,
    /// The mistakes that survived, with an entry each.
    pub survivors: BTreeMap<String, String>,
    /// The smallest δ for which every significant entry × (1 + δ) was noticed: the worst of all states; none where no entry was
    /// judged by itself.
    pub detectable: Option<f64>,
    /// The same at the median state.
    pub detectable_median: Option<f64>,
    /// The smallest δ at each state.
    #[serde(skip)]
    pub detectable_at: Vec<f64>,
}

impl Score {
    /// Counts a mutant that changes a number by `change` tolerances, in an entry of that name.
    pub fn count(
        &mut self,
        mistake: Mistake,
        noticed: bool,
        change: impl FnOnce() -> f64,
        entry: impl FnOnce() -> String,
    ) {
        let of_kind = self.by_mistake.entry(Cause::of(mistake)).or_default();
        let change = if noticed { f64::INFINITY } else { change() };
        let (all, kind) = if noticed {
            (&mut self.killed, &mut of_kind.killed)
        } else if change == 0.0 {
            (&mut self.equivalent, &mut of_kind.equivalent)
        } else if change < 2.0 {
            (&mut self.below_resolution, &mut of_kind.below_resolution)
        } else {
            self.survivors.insert(mistake.name(), entry());
            (&mut self.survived, &mut of_kind.survived)
        };
        (*all, *kind) = (*all + 1, *kind + 1);
    }

    /// Adds another score.
    pub fn merge(&mut self, other: Self) {
        self.killed += other.killed;
        self.equivalent += other.equivalent;
        self.below_resolution += other.below_resolution;
        self.survived += other.survived;
        for (cause, fared) in other.by_mistake {
            self.by_mistake.entry(cause).or_default().add(fared);
        }
        for (mistake, entry) in other.survivors {
            self.survivors.entry(mistake).or_insert(entry);
        }
        self.detectable_at.extend(other.detectable_at);
    }

    /// Settles the figures over all states.
    pub fn finish(&mut self) {
        self.detectable_at.sort_by(f64::total_cmp);
        self.detectable = self.detectable_at.last().copied();
        self.detectable_median = self.detectable_at.get(self.detectable_at.len() / 2).copied();
    }

    /// Mutants that had to be noticed.
    pub const fn decisive(&self) -> u64 {
        self.killed + self.survived
    }
}
