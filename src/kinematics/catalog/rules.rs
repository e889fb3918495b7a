//! What a connector section may not do, by the documented rules of its type.

use crate::catalog::{
    Availability, COMPONENT, Class, ConnectionType, Evidence, Orientation, PLANE, Slot, list,
};
use crate::measure::Measure;
use serde::Serialize;

/// The solver that a scene is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Procedure {
    /// Implicit.
    Standard,
    /// Explicit dynamics.
    Explicit,
}

/// What is known of one connector when its type's rules are checked.
#[derive(Clone, Debug, Default)]
pub struct Facts {
    /// Whether an orientation is given at a and at b.
    pub orientation: [bool; 2],
    /// Whether the element is two-dimensional (CONN2D2).
    pub planar: bool,
    /// The solver, where the scene says.
    pub procedure: Option<Procedure>,
    /// The components (0-based) with a stop.
    pub stops: Vec<usize>,
    /// The components (0-based) with a constitutive reference.
    pub references: Vec<usize>,
    /// The components (0-based) that a behaviour, motion or load acts on.
    pub actions: Vec<usize>,
    /// Whether predefined friction is asked for, and with how many numbers.
    pub predefined_friction: Option<usize>,
    /// The number of items on the section's data line.
    pub section_data: usize,
    /// Whether the nodes coincide initially.
    pub coincident: bool,
    /// Whether an orientation with SYSTEM=Z RECTANGULAR is named.
    pub z_rectangular: bool,
    /// Whether section controls are named.
    pub controls: bool,
    /// Whether the section says ELIMINATION.
    pub elimination: bool,
    /// Whether the behaviour says INTEGRATION.
    pub integration: bool,
    /// Whether elasticity or damping depends on frequency.
    pub frequency: bool,
    /// Whether elasticity or damping is UNSYMM.
    pub unsymmetric: bool,
    /// Whether damping is structural.
    pub structural_damping: bool,
    /// The component (0-based) that triggers each failure, and the one that it releases; all where none is named.
    pub failures: Vec<(usize, Option<usize>)>,
    /// The component (0-based) that triggers each lock, and the one that it locks; all where none is named.
    pub locks: Vec<(usize, Option<usize>)>,
    /// Whether the section data give a contact angle.
    pub contact_angle: bool,
    /// Which numbers of predefined friction are given and are not zero.
    pub friction_numbers: Vec<bool>,
    /// Whether a lock has an item after its four limits.
    pub lock_temperature: bool,
}

/// A rule of a connection type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// An orientation is missing where the type requires one.
    OrientationRequired,
    /// An orientation is given where the type does not use one.
    OrientationIgnored,
    /// The type has no two-dimensional form.
    NotInTwoDimensions,
    /// The type is not available for the solver.
    NotInProcedure,
    /// A stop on a component that cannot have one.
    StopNotAvailable,
    /// A reference for a component that cannot have one.
    ReferenceNotAvailable,
    /// A behaviour, motion or load on a component that is not available.
    ActionNotAvailable,
    /// Predefined friction for a type that has none.
    FrictionNotPredefined,
    /// More or fewer friction parameters than the type takes.
    FrictionParameters,
    /// Section data for a type that takes none.
    SectionDataUnused,
    /// A length or direction is needed, and the nodes coincide.
    CoincidentNodes,
    /// SYSTEM=Z RECTANGULAR in an Explicit analysis.
    ZRectangularNotInExplicit,
    /// An orientation that would direct a connector between coincident nodes, in an Explicit analysis.
    DirectionNotInExplicit,
    /// CONTROLS on a section in an Explicit analysis.
    ControlsNotInExplicit,
    /// ELIMINATION on a section in a Standard analysis.
    EliminationNotInStandard,
    /// INTEGRATION on a behaviour in a Standard analysis.
    IntegrationNotInStandard,
    /// A dependence on frequency in an Explicit analysis.
    FrequencyNotInExplicit,
    /// An unsymmetric matrix in an Explicit analysis.
    UnsymmetricNotInExplicit,
    /// Structural damping in an Explicit analysis.
    StructuralDampingNotInExplicit,
    /// A failure triggered by, or releasing, a component that cannot be.
    FailureNotAvailable,
    /// A lock triggered by, or locking, a component that cannot be.
    LockNotAvailable,
    /// Friction of a belt whose contact angle is the default of Standard, zero.
    ContactAngleDefault,
    /// A number of predefined friction on which nothing depends in our reading.
    FrictionParameterUnused,
    /// Items after the limits of a lock in an Explicit analysis, which may be meant as velocities.
    LockVelocity,
}

/// What only one of the solvers has.
struct ProcedureRule {
    rule: Rule,
    /// The solver that has it.
    only: Procedure,
    /// Whether a connector asks for it.
    asks: fn(&ConnectionType, &Facts) -> bool,
    /// In the words of decks, and of documents.
    what: [&'static str; 2],
    remedy: [&'static str; 2],
    source: &'static str,
    evidence: Evidence,
    harmless: bool,
}

/// A step of Abaqus/Explicit, in the words of decks and of documents.
pub const EXPLICIT_STEP: [&str; 2] =
    ["a *DYNAMIC, EXPLICIT step", "a step with procedure = \"dynamic_explicit\""];

/// What decks and documents say in the same words.
fn both(text: String) -> [String; 2] {
    [text.clone(), text]
}

const PROCEDURE_RULES: &[ProcedureRule] = &[
    ProcedureRule {
        rule: Rule::ZRectangularNotInExplicit,
        only: Procedure::Standard,
        asks: |_, facts| facts.z_rectangular,
        what: ["an orientation with SYSTEM=Z RECTANGULAR", "an orientation with system = Z RECTANGULAR"],
        remedy: [
            "give the same directions by SYSTEM=RECTANGULAR",
            "give the same directions by system = RECTANGULAR",
        ],
        source: "keyword *ORIENTATION",
        evidence: Evidence::D,
        harmless: false,
    },
    ProcedureRule {
        rule: Rule::DirectionNotInExplicit,
        only: Procedure::Standard,
        asks: |connection, facts| {
            connection.is_directed_by_orientation() && facts.orientation.contains(&true) && facts.coincident
        },
        what: ["the direction that an orientation gives to a connector whose nodes coincide"; 2],
        remedy: ["move the nodes apart, or use CARTESIAN; without a direction the force is zero until they separate";
            2],
        source: "connection type AXIAL, Description",
        evidence: Evidence::D,
        harmless: true,
    },
    ProcedureRule {
        rule: Rule::ControlsNotInExplicit,
        only: Procedure::Standard,
        asks: |_, facts| facts.controls,
        what: ["CONTROLS on *CONNECTOR SECTION", "CONTROLS on connector_sections"],
        remedy: ["remove CONTROLS; it has no effect"; 2],
        source: "keyword *CONNECTOR SECTION",
        evidence: Evidence::D,
        harmless: true,
    },
    ProcedureRule {
        rule: Rule::EliminationNotInStandard,
        only: Procedure::Explicit,
        asks: |_, facts| facts.elimination,
        what: ["ELIMINATION on *CONNECTOR SECTION", "ELIMINATION on connector_sections"],
        remedy: ["remove ELIMINATION; it has no effect"; 2],
        source: "keyword *CONNECTOR SECTION",
        evidence: Evidence::D,
        harmless: true,
    },
    ProcedureRule {
        rule: Rule::IntegrationNotInStandard,
        only: Procedure::Explicit,
        asks: |_, facts| facts.integration,
        what: ["INTEGRATION on *CONNECTOR BEHAVIOR", "INTEGRATION on behaviors"],
        remedy: ["remove INTEGRATION; it has no effect"; 2],
        source: "keyword *CONNECTOR BEHAVIOR",
        evidence: Evidence::D,
        harmless: true,
    },
    ProcedureRule {
        rule: Rule::FrequencyNotInExplicit,
        only: Procedure::Standard,
        asks: |_, facts| facts.frequency,
        what: ["elasticity or damping that depends on frequency"; 2],
        remedy: ["leave the frequency blank"; 2],
        source: "keywords *CONNECTOR ELASTICITY and *CONNECTOR DAMPING",
        evidence: Evidence::D,
        harmless: false,
    },
    ProcedureRule {
        rule: Rule::UnsymmetricNotInExplicit,
        only: Procedure::Standard,
        asks: |_, facts| facts.unsymmetric,
        what: ["UNSYMM elasticity or damping"; 2],
        remedy: ["give the 21 terms of a symmetric matrix"; 2],
        source: "connector elastic behaviour",
        evidence: Evidence::D,
        harmless: false,
    },
    ProcedureRule {
        rule: Rule::StructuralDampingNotInExplicit,
        only: Procedure::Standard,
        asks: |_, facts| facts.structural_damping,
        what: ["structural damping"; 2],
        remedy: ["use TYPE=VISCOUS; structural damping acts in frequency domain procedures"; 2],
        source: "connector damping behaviour",
        evidence: Evidence::P,
        harmless: false,
    },
    ProcedureRule {
        rule: Rule::ContactAngleDefault,
        only: Procedure::Explicit,
        asks: |connection, facts| {
            connection.is_belt() && facts.predefined_friction.is_some() && !facts.contact_angle
        },
        what: ["a contact angle from the positions of the nodes"; 2],
        remedy: ["give the contact angle in radians as item 2 of the section data; the default of Standard is 0, and then there is no friction";
            2],
        source: "connection type SLIPRING, Friction (our reading)",
        evidence: Evidence::P,
        harmless: true,
    },
    ProcedureRule {
        rule: Rule::LockVelocity,
        only: Procedure::Standard,
        asks: |_, facts| facts.lock_temperature,
        what: ["a lock whose fifth item is a temperature"; 2],
        remedy: ["limits of velocity are not evaluated, and the fifth item is read as a temperature: leave it out, or give the lock by position and force alone";
            2],
        source: "connector lock behaviour",
        evidence: Evidence::P,
        harmless: true,
    },
];

impl Procedure {
    /// The name of the solver.
    const fn name(self) -> &'static str {
        match self {
            Self::Standard => "Standard",
            Self::Explicit => "Explicit",
        }
    }
}

/// A broken rule: what is wrong, why, and what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Breach {
    /// The rule.
    pub rule: Rule,
    /// What is wrong, in the words of decks and of documents.
    pub message: [String; 2],
    /// What to do, in these words.
    pub remedy: [String; 2],
    /// Where the rule is documented.
    pub source: String,
    /// How well it is documented: only [`Evidence::S`] and [`Evidence::D`] refuse.
    pub evidence: Evidence,
    /// Whether the scene can be evaluated all the same: what is given is not used.
    pub harmless: bool,
    /// What it is about, if it is about one: a component (0-based). Of an orientation it is the node, 0 for a and 1 for b; of a
    /// failure or lock, its place in [`Facts::failures`] or [`Facts::locks`].
    pub item: Option<usize>,
}

impl Breach {
    /// Whether the scene is refused, rather than warned about.
    pub const fn refuses(&self) -> bool {
        matches!(self.evidence, Evidence::S | Evidence::D) && !self.harmless
    }
}

/// The place of the manual that a source names, without the note that it is our reading.
fn page(source: &str) -> &str {
    let note = source.rsplit_once(" (").filter(|(_, note)| note.contains("our reading"));
    note.map_or(source, |(page, _)| page)
}

impl ConnectionType {
    /// The places of the manual that declare the type.
    pub fn pages(&self) -> String {
        let pages: Vec<&str> = self.source.iter().filter(|s| !s.is_empty()).map(|s| page(s)).collect();
        pages.join("; ")
    }

    /// The documented rules that a connector of this type breaks.
    pub fn breaches(&self, facts: &Facts) -> Vec<Breach> {
        let mut found = Vec::new();
        let source = self.pages();
        let mut about = |item, rule, message: String, remedy: [String; 2], evidence, harmless| {
            let (message, source) = (both(message), source.clone());
            found.push(Breach { rule, message, remedy, source, evidence, harmless, item });
        };
        let mut breach = |rule, message, remedy, evidence, harmless| {
            about(None, rule, message, remedy, evidence, harmless)
        };
        for (at, node) in ["a", "b"].into_iter().enumerate() {
            let rule = self.orientation[at];
            if rule.orientation == Orientation::Required && !facts.orientation[at] {
                breach(
                    Rule::OrientationRequired,
                    format!("{} requires an orientation at node {node}", self.name),
                    [
                        format!("name an *ORIENTATION as item {} of the line after the type", at + 1),
                        format!("give orientation_{node}"),
                    ],
                    rule.evidence,
                    false,
                );
            }
        }
        let unused: Vec<usize> = (0..2)
            .filter(|at| self.orientation[*at].orientation == Orientation::Ignored && facts.orientation[*at])
            .collect();
        if let [first, rest @ ..] = unused.as_slice() {
            let (nodes, them) = if rest.is_empty() {
                (if *first == 0 { "node a" } else { "node b" }, "it")
            } else {
                ("either node", "them")
            };
            about(
                Some(*first),
                Rule::OrientationIgnored,
                format!("{} does not use an orientation at {nodes}", self.name),
                both(format!("leave {them} out; there is no effect")),
                self.orientation[*first].evidence,
                true,
            );
        }
        let mut breach = |rule, message, remedy, evidence, harmless| {
            about(None, rule, message, remedy, evidence, harmless)
        };
        if facts.planar && self.planar == Availability::Never {
            breach(
                Rule::NotInTwoDimensions,
                format!("{} cannot be used in two-dimensional or axisymmetric analysis", self.name),
                ["TYPE=CONN3D2", "dimension = CONN3D2"]
                    .map(|dimension| format!("use {dimension}, or a type that has a two-dimensional form")),
                Evidence::D,
                false,
            );
        }
        let availability = if facts.planar { self.planar } else { self.availability };
        let unavailable = match (availability, facts.procedure) {
            (Availability::ExplicitOnly, Some(Procedure::Standard)) => Some("Explicit"),
            (Availability::StandardOnly, Some(Procedure::Explicit)) => Some("Standard"),
            _ => None,
        };
        if let Some(only) = unavailable {
            breach(
                Rule::NotInProcedure,
                format!("{} is available only in Abaqus/{only}", self.name),
                match only {
                    "Explicit" => EXPLICIT_STEP.map(|step| format!("use {step}, or another type")),
                    _ => both("use an implicit step, or another type".into()),
                },
                Evidence::D,
                false,
            );
        }
        // In two dimensions u3, ur1 and ur2 are zero whatever the type.
        let exists = |k: usize| !facts.planar || PLANE[k];
        let is_available = |k: usize| self.slots[k].is_available() && exists(k);
        let available = list((0..6).filter(|k| is_available(*k)).map(|k| COMPONENT[k]));
        for k in &facts.stops {
            if !self.stops || !is_available(*k) {
                about(
                    Some(*k),
                    Rule::StopNotAvailable,
                    format!("{} takes no stop on component {} ({})", self.name, k + 1, COMPONENT[*k]),
                    both(format!("stops apply to available components; here: {available}")),
                    Evidence::D,
                    false,
                );
            }
        }
        for k in &facts.references {
            let has_reference = self.stops || matches!(self.slots[*k].position(), Some(Measure::Strain));
            if !has_reference || !is_available(*k) {
                about(
                    Some(*k),
                    Rule::ReferenceNotAvailable,
                    format!(
                        "{} has no constitutive reference for component {} ({})",
                        self.name,
                        k + 1,
                        COMPONENT[*k]
                    ),
                    both(format!("references apply to available components; here: {available}")),
                    Evidence::D,
                    false,
                );
            }
        }
        for k in &facts.actions {
            if !is_available(*k) {
                about(
                    Some(*k),
                    Rule::ActionNotAvailable,
                    format!("component {} ({}) of {} is not available", k + 1, COMPONENT[*k], self.name),
                    both(format!(
                        "behaviour, motion and load act on available components; here: {available}"
                    )),
                    Evidence::D,
                    false,
                );
            }
        }
        let mut breach = |rule, message, remedy, evidence, harmless| {
            about(None, rule, message, remedy, evidence, harmless)
        };
        if let Some(count) = facts.predefined_friction {
            match (&self.friction, self.halves) {
                (Some(friction), _) => {
                    let least = friction.parameters.iter().filter(|p| p.required).count();
                    let most = friction.parameters.len();
                    if count < least || count > most {
                        let symbols: Vec<&str> = friction.parameters.iter().map(|p| p.symbol).collect();
                        breach(
                            Rule::FrictionParameters,
                            format!(
                                "predefined friction of {} takes {least} to {most} numbers, not {count}",
                                self.name
                            ),
                            both(format!("give {} in this order", symbols.join(", "))),
                            friction.evidence,
                            false,
                        );
                    }
                    let symbols = friction.parameters.iter().map(|parameter| parameter.symbol);
                    let given: Vec<&str> = symbols
                        .zip(&facts.friction_numbers)
                        .filter_map(|(symbol, given)| given.then_some(symbol))
                        .collect();
                    for symbol in friction.unused_parameters().filter(|symbol| given.contains(symbol)) {
                        breach(
                            Rule::FrictionParameterUnused,
                            format!("{symbol} of the friction of {} is read, and nothing depends on it", self.name),
                            both("write 0: where the manual's formula has it could not be read, and ours does not hold it".into()),
                            friction.evidence,
                            true,
                        );
                    }
                }
                (None, [None, None]) => {}
                (None, _) => breach(
                    Rule::FrictionNotPredefined,
                    format!("{} has no predefined friction", self.name),
                    [
                        "define the friction with COMPONENT= or *CONNECTOR POTENTIAL, or remove PREDEFINED",
                        "describe the friction with component or potential instead of predefined",
                    ]
                    .map(String::from),
                    Evidence::D,
                    false,
                ),
            }
        }
        let takes_data = match self.class {
            Class::Complex => 2,
            _ => usize::from(self.flow[1]),
        };
        if facts.section_data > takes_data {
            breach(
                Rule::SectionDataUnused,
                format!(
                    "{} takes {takes_data} numbers on its data line, not {}",
                    self.name, facts.section_data
                ),
                both("remove the extra numbers".into()),
                Evidence::D,
                false,
            );
        }
        let needs_length = self
            .components(Slot::is_constrained)
            .any(|k| self.slots[k].position() == Some(Measure::Distance))
            || self.slots[0].position() == Some(Measure::Strain);
        if needs_length && facts.coincident {
            breach(
                Rule::CoincidentNodes,
                format!("{} needs two nodes apart, and they coincide initially", self.name),
                both("move a node, or use JOIN to keep nodes together".into()),
                Evidence::D,
                false,
            );
        }
        let is_there = |k: usize| exists(k) && !matches!(self.slots[k], Slot::Absent);
        for (rule, word, verb, laws) in [
            (Rule::FailureNotAvailable, "failure", "release", &facts.failures),
            (Rule::LockNotAvailable, "lock", "lock", &facts.locks),
        ] {
            for (place, (trigger, affected)) in laws.iter().enumerate() {
                let trigger = Some(*trigger).filter(|k| *affected != Some(*k));
                for (k, is_trigger) in
                    trigger.map(|k| (k, true)).into_iter().chain(affected.map(|k| (k, false)))
                {
                    let is_absent = !is_there(k);
                    let is_held = match rule {
                        // Standard fails by what is available; a lock that holds what is held has no effect in either.
                        Rule::FailureNotAvailable => {
                            facts.procedure == Some(Procedure::Standard) && !is_available(k)
                        }
                        _ => !is_trigger && !is_available(k),
                    };
                    if !is_absent && !is_held {
                        continue;
                    }
                    let only = if rule == Rule::FailureNotAvailable && !is_absent {
                        " in Abaqus/Standard"
                    } else {
                        ""
                    };
                    about(
                        Some(place),
                        rule,
                        format!(
                            "component {} ({}) of {} takes no {word}{only}",
                            k + 1,
                            COMPONENT[k],
                            self.name
                        ),
                        both(format!("trigger by and {verb} available components; here: {available}")),
                        Evidence::D,
                        rule == Rule::LockNotAvailable && !is_absent,
                    );
                }
            }
        }
        for rule in PROCEDURE_RULES {
            let asked = (rule.asks)(self, facts);
            if !asked || facts.procedure.is_none_or(|procedure| procedure == rule.only) {
                continue;
            }
            found.push(Breach {
                rule: rule.rule,
                message: rule.what.map(|what| {
                    format!("{}: {what} is available only in Abaqus/{}", self.name, rule.only.name())
                }),
                remedy: rule.remedy.map(String::from),
                source: page(rule.source).into(),
                evidence: rule.evidence,
                harmless: rule.harmless,
                item: None,
            });
        }
        found
    }

    /// Whether an orientation stands in for the line of the nodes while they coincide (AXIAL in a Standard analysis).
    pub fn is_directed_by_orientation(&self) -> bool {
        self.slots[0].position() == Some(Measure::Distance)
            && self.orientation.iter().any(|rule| rule.orientation != Orientation::Ignored)
    }

    /// Whether the connector is a belt segment, of which at most two can share a node (SLIPRING).
    pub fn is_belt(&self) -> bool {
        self.slots[0].position() == Some(Measure::Strain)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A CARTESIAN has a third component in space, and none in the plane.
    #[test]
    fn components_out_of_the_plane_are_not_available() {
        let cartesian = ConnectionType::named("CARTESIAN", None).unwrap();
        let facts = |planar| Facts {
            planar,
            stops: vec![0, 2],
            references: vec![0, 2],
            actions: vec![0, 2],
            ..Facts::default()
        };
        assert_eq!(cartesian.breaches(&facts(false)), []);
        let planar = cartesian.breaches(&facts(true));
        let rules: Vec<Rule> = planar.iter().map(|breach| breach.rule).collect();
        assert_eq!(rules, [Rule::StopNotAvailable, Rule::ReferenceNotAvailable, Rule::ActionNotAvailable]);
        assert!(planar.iter().all(|breach| breach.remedy[0].ends_with("here: u1, u2")));
    }
}
