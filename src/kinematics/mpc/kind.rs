//! Which multi-point constraints there are: the data.

use crate::measure::{SingularClass, SingularSet, Unit};
use crate::mpc::{DOFS, PSI_M, PSI_S, ROWS, THETA_M, THETA_S, XM, XS};
use serde::Serialize;

/// The type of a multi-point constraint (keyword *MPC).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, serde::Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum MpcType {
    /// A rigid beam.
    Beam,
    /// A pinned rigid link: a constant distance.
    Link,
    /// A pinned joint: equal displacements.
    Pin,
    /// A revolute joint: one hinge.
    Revolute,
    /// All degrees of freedom equal.
    Tie,
    /// A universal joint: two hinges.
    Universal,
}

/// What a constraint says about the translations of S and M.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Translation {
    /// Nothing.
    Free,
    /// u_S = u_M.
    Equal,
    /// |x_S − x_M| = |X_S − X_M|.
    Distance,
    /// x_S − x_M = C_M (X_S − X_M).
    Carried,
}

/// What is known of a kind. Everything else about a constraint follows from `translation`, `hinges` and `ties_flow`.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// The kind.
    pub kind: MpcType,
    /// The name, as a deck writes it.
    pub name: &'static str,
    /// Its nodes by role, in the order of the deck; the first is the dependent one.
    pub nodes: &'static [&'static str],
    /// Translations.
    pub translation: Translation,
    /// Rotations: tied but for this number of hinges between M and S, or free.
    pub hinges: Option<usize>,
    /// Whether material flow (degree of freedom 10) is tied where both nodes have it.
    pub ties_flow: bool,
    /// The names of the angles of its hinges: degree of freedom 6 of the third and fourth node (rad).
    pub angles: &'static [&'static str],
    /// Whether Abaqus/Explicit does not have it.
    pub standard_only: bool,
    /// What it is, fact by fact, with the evidence for each.
    pub facts: &'static [(&'static str, &'static str)],
    /// What the rows are where the constraint holds.
    pub rows: &'static str,
    /// What one should know besides.
    pub remarks: &'static [&'static str],
    /// Where it is from.
    pub sources: &'static [&'static str],
}

const THEORY: &str = "Theory Guide, rotation of rigid joints: revolute and universal MPC";
const GUIDE: &str = "Analysis Guide, General multi-point constraints";
const IMPLIED: &str = "In the residual and its rows, φ is degree of freedom 6 of its node where the states give it, and otherwise the \
     angle that the rotations of S and M imply; its rates in those of the residual are always those of its node. The outputs CP, \
     CU, CV and CA of φ are always those of the implied angle.";
const NO_TRANSLATIONS: &str = "Translations are not tied: add a PIN.";
const TURNS: &str = "Rotations are equal as rotations: φS and φM may differ by whole turns.";

/// Every kind, by name.
pub const TABLE: [Entry; 6] = [
    Entry {
        kind: MpcType::Beam,
        name: "BEAM",
        nodes: &["S", "M"],
        translation: Translation::Carried,
        hinges: Some(0),
        ties_flow: false,
        angles: &[],
        standard_only: false,
        facts: &[
            ("Nodes", "S (the first, dependent), M (the second) [D]"),
            ("Constraint", "a rigid beam between S and M: xS − xM = C(φM) (XS − XM), C(φS) = C(φM) [D]"),
            ("Number of constraints", "6"),
            ("Angular velocity", "ωS = ωM, vS = vM + ωM × (xS − xM)"),
            ("Eliminated", "degrees of freedom 1–6 of S [D]"),
            ("Forces", "FM = −FS, MM = −MS − (xS − xM) × FS [R]"),
            ("Abaqus/Standard, Abaqus/Explicit", "both [D]"),
        ],
        rows: "δ = δxS − δxM − δθM × (xS − xM), δρ = δθS − δθM.",
        remarks: &[TURNS],
        sources: &[GUIDE],
    },
    Entry {
        kind: MpcType::Link,
        name: "LINK",
        nodes: &["S", "M"],
        translation: Translation::Distance,
        hinges: None,
        ties_flow: false,
        angles: &[],
        standard_only: false,
        facts: &[
            ("Nodes", "S (the first, dependent), M (the second) [D]"),
            ("Constraint", "|xS − xM| = |XS − XM|, a pinned rigid link [D]"),
            ("Number of constraints", "1"),
            ("Eliminated", "one displacement of S [D]: that along which the link points most [R]"),
            ("Forces", "FM = −FS, along the link [R]"),
            ("Abaqus/Standard, Abaqus/Explicit", "both [D]"),
        ],
        rows: "δ(δl) = q·(δxS − δxM), q = (xS − xM)/|xS − xM|.",
        remarks: &["Rotations, where the nodes have any, are not involved."],
        sources: &[GUIDE],
    },
    Entry {
        kind: MpcType::Pin,
        name: "PIN",
        nodes: &["S", "M"],
        translation: Translation::Equal,
        hinges: None,
        ties_flow: false,
        angles: &[],
        standard_only: false,
        facts: &[
            ("Nodes", "S (the first, dependent), M (the second) [D]"),
            ("Constraint", "uS = uM: equal global displacements [D]"),
            ("Number of constraints", "3"),
            ("Eliminated", "degrees of freedom 1–3 of S [D]"),
            ("Forces", "FM = −FS [R]"),
            ("Abaqus/Standard, Abaqus/Explicit", "both [D]"),
        ],
        rows: "δ = δxS − δxM, with no second derivatives.",
        remarks: &[
            "Displacements are equal, not positions: nodes that are apart initially stay apart by XS − XM, which does not turn \
             with any node. Forces at such a distance balance and their moments do not.",
            "A connector JOIN holds XS − XM in the directions of its first node instead; for coincident nodes the two agree.",
        ],
        sources: &[GUIDE],
    },
    Entry {
        kind: MpcType::Revolute,
        name: "REVOLUTE",
        nodes: &["S", "M", "J"],
        translation: Translation::Free,
        hinges: Some(1),
        ties_flow: false,
        angles: &["φJ"],
        standard_only: true,
        facts: &[
            ("Nodes", "S (the first, dependent), M (the second), J (the third)"),
            ("Constraint", "C(φS) = C(φJ a) C(φM) [S]"),
            ("Axis", "a = C(φM) a0 [S]; a0 from M to J initially, global z if they coincide [D]"),
            ("Additional degree of freedom", "φJ, the relative rotation: degree of freedom 6 of J [S]"),
            ("Number of constraints", "3 with one more unknown: 2 net, 3 if φJ is prescribed [S]"),
            ("Angular velocity", "ωS = ωM + φ̇J a [S]"),
            ("Eliminated", "degrees of freedom 4–6 of S [S]"),
            ("Moments", "MS = −MM, MJ = −MS·a = MM·a [S]"),
            ("Abaqus/Standard, Abaqus/Explicit", "Standard [D]"),
        ],
        rows: "δρ = δθS − δθM − a δφJ.",
        remarks: &[IMPLIED, NO_TRANSLATIONS, "C(φJ a) C(φM) = C(φM) C(φJ a0), which is what is computed."],
        sources: &[
            "MPC REVOLUTE, Revolute joint, Eq. 1 and the text around it",
            "keyword *MPC, type REVOLUTE (initial axis, solver)",
        ],
    },
    Entry {
        kind: MpcType::Tie,
        name: "TIE",
        nodes: &["S", "M"],
        translation: Translation::Equal,
        hinges: Some(0),
        ties_flow: true,
        angles: &[],
        standard_only: false,
        facts: &[
            ("Nodes", "S (the first, dependent), M (the second) [D]"),
            ("Constraint", "uS = uM, C(φS) = C(φM), ΨS = ΨM: all active degrees of freedom equal [D]"),
            ("Number of constraints", "6, and 1 for material flow where both nodes have it"),
            ("Angular velocity", "ωS = ωM, vS = vM"),
            ("Eliminated", "degrees of freedom 1–6 of S, and 10 where both nodes have it [D]"),
            ("Forces", "FM = −FS, MM = −MS [R]"),
            ("Abaqus/Standard, Abaqus/Explicit", "both [D]"),
        ],
        rows: "δ = δxS − δxM, δρ = δθS − δθM, δ(δΨ) = δΨS − δΨM.",
        remarks: &[
            "Displacements are equal, not positions: nodes that are apart initially stay apart by XS − XM, which does not turn \
             with them. For a rigid connection over a distance use BEAM.",
            "Equal rotation vectors φS = φM are read as equal rotations [R]: the two may differ by whole turns.",
        ],
        sources: &[GUIDE],
    },
    Entry {
        kind: MpcType::Universal,
        name: "UNIVERSAL",
        nodes: &["S", "M", "J1", "J2"],
        translation: Translation::Free,
        hinges: Some(2),
        ties_flow: false,
        angles: &["φ1", "φ2"],
        standard_only: true,
        facts: &[
            ("Nodes", "S (the first, dependent), M (the second), J1 (the third), J2 (the fourth)"),
            ("Constraint", "C(φS) = C(φ2 a2) C(φ1 a1) C(φM) [D]"),
            ("First axis", "a1 = C(φM) a10 [D]; a10 from M to J1 initially, global z if they coincide [R]"),
            (
                "Second axis",
                "a2 = C(φ1 a1) C(φM) a20 [D]; a20 from M to J2 initially, global x if they coincide [R]; orthogonal to a10 [D]",
            ),
            (
                "Additional degrees of freedom",
                "φ1 and φ2, the relative rotations: degree of freedom 6 of J1 and of J2 [D]",
            ),
            (
                "Number of constraints",
                "3 with two more unknowns: 1 net, up to 3 if φ1 and φ2 are prescribed [D]",
            ),
            ("Angular velocity", "ωS = ωM + φ̇1 a1 + φ̇2 a2 [D]"),
            ("Eliminated", "degrees of freedom 4–6 of S [D]"),
            ("Moments", "MS = −MM, MJ1 = −MS·a1, MJ2 = −MS·a2 [D]"),
            ("Abaqus/Standard, Abaqus/Explicit", "Standard [P]"),
        ],
        rows: "δρ = δθS − δθM − a1 δφ1 − a2 δφ2.",
        remarks: &[
            IMPLIED,
            NO_TRANSLATIONS,
            "C(φ2 a2) C(φ1 a1) C(φM) = C(φM) C(φ1 a10) C(φ2 a20), which is what is computed.",
            "Axes that are not orthogonal are taken as they are, with a warning; the composition above holds for them too. Parallel \
             axes leave only the sum or difference of φ1 and φ2 determined.",
        ],
        sources: &[THEORY, GUIDE],
    },
];

impl MpcType {
    /// Every kind, in the order of [`TABLE`].
    pub const ALL: [Self; TABLE.len()] =
        [Self::Beam, Self::Link, Self::Pin, Self::Revolute, Self::Tie, Self::Universal];

    /// What is known of it.
    pub const fn entry(self) -> &'static Entry {
        match self {
            Self::Beam => &TABLE[0],
            Self::Link => &TABLE[1],
            Self::Pin => &TABLE[2],
            Self::Revolute => &TABLE[3],
            Self::Tie => &TABLE[4],
            Self::Universal => &TABLE[5],
        }
    }

    /// The kind of a name, in any case.
    ///
    /// ```
    /// use pintle_kinematics::mpc::MpcType;
    /// assert_eq!(MpcType::named("revolute"), Some(MpcType::Revolute));
    /// assert_eq!(MpcType::named("HINGE"), None);
    /// ```
    pub fn named(name: &str) -> Option<Self> {
        TABLE.iter().find(|entry| entry.name.eq_ignore_ascii_case(name)).map(|entry| entry.kind)
    }

    /// The name, as a deck writes it.
    pub const fn name(self) -> &'static str {
        self.entry().name
    }

    /// The equations that it has, material flow counted where `flow` says that both nodes have it.
    pub fn rows(self, flow: bool) -> [bool; ROWS] {
        let entry = self.entry();
        let translations = match entry.translation {
            Translation::Free => 0,
            Translation::Distance => 1,
            Translation::Equal | Translation::Carried => 3,
        };
        std::array::from_fn(|row| match row {
            0..3 => row < translations,
            3..6 => entry.hinges.is_some(),
            _ => entry.ties_flow && flow,
        })
    }

    /// The name of an equation: δ1 … δ3 (length), δl (length), ρ1 … ρ3 (rad), δΨ (length).
    pub fn row_name(self, row: usize) -> &'static str {
        match (self.entry().translation, row) {
            (Translation::Distance, 0) => "δl",
            _ => ["δ1", "δ2", "δ3", "ρ1", "ρ2", "ρ3", "δΨ"].get(row).copied().unwrap_or_default(),
        }
    }

    /// The unit of an equation.
    pub const fn row_unit(row: usize) -> Unit {
        if row >= 3 && row < 6 { Unit::Angle } else { Unit::Length }
    }

    /// The equation by whose name flags tell of an equation's singular set: the three of rotation share theirs.
    pub const fn flagged_row(row: usize) -> usize {
        match Self::row_unit(row) {
            Unit::Angle => crate::mpc::RHO,
            _ => row,
        }
    }

    /// The degrees of freedom that enter it.
    pub fn columns(self, flow: bool) -> [bool; DOFS] {
        let entry = self.entry();
        let translates = entry.translation != Translation::Free;
        let turns = entry.hinges.is_some();
        std::array::from_fn(|j| match j {
            XS..THETA_S | XM..THETA_M => translates,
            THETA_S..PSI_S => turns,
            THETA_M..PSI_M => turns,
            PSI_S | PSI_M => entry.ties_flow && flow,
            _ => j - crate::mpc::PHI < entry.angles.len(),
        })
    }

    /// The name of a degree of freedom: xS1 … θS3, ΨS, xM1 … θM3, ΨM, φJ or φ1 and φ2.
    pub fn column_name(self, j: usize) -> &'static str {
        const NAMES: [&str; crate::mpc::PHI] =
            ["xS1", "xS2", "xS3", "θS1", "θS2", "θS3", "ΨS", "xM1", "xM2", "xM3", "θM1", "θM2", "θM3", "ΨM"];
        match NAMES.get(j) {
            Some(name) => name,
            None => self.entry().angles.get(j - crate::mpc::PHI).copied().unwrap_or_default(),
        }
    }

    /// The place of the node of a degree of freedom in [`Entry::nodes`], and the number of the degree of freedom there.
    pub const fn column_dof(j: usize) -> (usize, u8) {
        const NUMBERS: [u8; 7] = [1, 2, 3, 4, 5, 6, 10];
        if j < crate::mpc::PHI { (j / 7, NUMBERS[j % 7]) } else { (2 + j - crate::mpc::PHI, 6) }
    }

    /// Where the angles of the hinges, or derivatives of them, do not exist.
    pub const fn angle_set(self) -> Option<SingularSet> {
        let (at, distance) = match self {
            Self::Revolute => ("S turned by π from M about a direction across the axis", "|(w, v·a0)|"),
            Self::Universal => ("the second axis, carried by S, parallel to the first", "|a1 × C(φS) a20|"),
            Self::Pin | Self::Link | Self::Beam | Self::Tie => return None,
        };
        Some(SingularSet { at, class: SingularClass::TrueSingularity, distance, unit: Unit::None })
    }

    /// Where an equation, or derivatives of it, do not exist.
    pub fn row_set(self, row: usize) -> Option<SingularSet> {
        match (self.entry().translation, row) {
            (Translation::Distance, 0) => crate::measure::Measure::Distance.singular_set(),
            (_, 3..6) => Some(SingularSet {
                at: "S turned by π from where the constraint has it",
                class: SingularClass::BranchCut,
                distance: "π − |ρ|",
                unit: Unit::Angle,
            }),
            _ => None,
        }
    }
}
