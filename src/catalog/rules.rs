//! What a connector section may not do, by the documented rules of its type.

use super::{Availability, COMPONENT, Class, ConnectionType, Evidence, Orientation, Slot, list};
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
}

/// A broken rule: what is wrong, why, and what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Breach {
    /// The rule.
    pub rule: Rule,
    /// What is wrong.
    pub message: String,
    /// What to do.
    pub remedy: String,
    /// Where the rule is documented.
    pub source: String,
    /// How well it is documented: only [`Evidence::S`] and [`Evidence::D`] refuse.
    pub evidence: Evidence,
    /// Whether the scene can be evaluated all the same: what is given is not used.
    pub harmless: bool,
}

impl Breach {
    /// Whether the scene is refused, rather than warned about.
    pub const fn refuses(&self) -> bool {
        matches!(self.evidence, Evidence::S | Evidence::D) && !self.harmless
    }
}

impl ConnectionType {
    /// The documented rules that a connector of this type breaks.
    pub fn breaches(&self, facts: &Facts) -> Vec<Breach> {
        let mut found = Vec::new();
        let mut breach = |rule, message: String, remedy: String, evidence, harmless| {
            let source = self.source.iter().filter(|s| !s.is_empty()).copied().collect::<Vec<_>>().join("; ");
            found.push(Breach { rule, message, remedy, source, evidence, harmless });
        };
        for (at, node) in ["a", "b"].into_iter().enumerate() {
            let rule = self.orientation[at];
            if rule.orientation == Orientation::Required && !facts.orientation[at] {
                breach(
                    Rule::OrientationRequired,
                    format!("{} requires an orientation at node {node}", self.name),
                    format!("name an *ORIENTATION as item {} of the line after the type", at + 1),
                    rule.evidence,
                    false,
                );
            }
            if rule.orientation == Orientation::Ignored && facts.orientation[at] {
                breach(
                    Rule::OrientationIgnored,
                    format!("{} does not use an orientation at node {node}", self.name),
                    "leave it out; it has no effect".into(),
                    rule.evidence,
                    true,
                );
            }
        }
        if facts.planar && self.planar == Availability::Never {
            breach(
                Rule::NotInTwoDimensions,
                format!("{} cannot be used in two-dimensional or axisymmetric analysis", self.name),
                "use TYPE=CONN3D2, or a type that has a two-dimensional form".into(),
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
                    "Explicit" => "use a *DYNAMIC, EXPLICIT step, or another type".into(),
                    _ => "use an implicit step, or another type".into(),
                },
                Evidence::D,
                false,
            );
        }
        // In two dimensions u3, ur1 and ur2 are zero whatever the type.
        let exists = |k: usize| !facts.planar || matches!(k, 0 | 1 | 5);
        let is_available = |k: usize| self.slots[k].is_available() && exists(k);
        let available = list((0..6).filter(|k| is_available(*k)).map(|k| COMPONENT[k]));
        for k in &facts.stops {
            if !self.stops || !is_available(*k) {
                breach(
                    Rule::StopNotAvailable,
                    format!("{} takes no stop on component {} ({})", self.name, k + 1, COMPONENT[*k]),
                    format!("stops apply to available components; here: {available}"),
                    Evidence::D,
                    false,
                );
            }
        }
        for k in &facts.references {
            let has_reference = self.stops || matches!(self.slots[*k].position(), Some(Measure::Strain));
            if !has_reference || !is_available(*k) {
                breach(
                    Rule::ReferenceNotAvailable,
                    format!(
                        "{} has no constitutive reference for component {} ({})",
                        self.name,
                        k + 1,
                        COMPONENT[*k]
                    ),
                    format!("references apply to available components; here: {available}"),
                    Evidence::D,
                    false,
                );
            }
        }
        for k in &facts.actions {
            if !is_available(*k) {
                breach(
                    Rule::ActionNotAvailable,
                    format!("component {} ({}) of {} is not available", k + 1, COMPONENT[*k], self.name),
                    format!("behaviour, motion and load act on available components; here: {available}"),
                    Evidence::D,
                    false,
                );
            }
        }
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
                            format!("give {} in this order", symbols.join(", ")),
                            friction.evidence,
                            false,
                        );
                    }
                }
                (None, [None, None]) => {}
                (None, _) => breach(
                    Rule::FrictionNotPredefined,
                    format!("{} has no predefined friction", self.name),
                    "define the friction with COMPONENT= or *CONNECTOR POTENTIAL, or remove PREDEFINED"
                        .into(),
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
                "remove the extra numbers".into(),
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
                "move a node, or use JOIN to keep nodes together".into(),
                Evidence::D,
                false,
            );
        }
        found
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
        assert!(planar.iter().all(|breach| breach.remedy.ends_with("here: u1, u2")));
    }
}
