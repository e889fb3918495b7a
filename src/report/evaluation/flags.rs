//! What flags say, in words.

use pintle_kinematics::connector::{CERTAIN_INCREMENT, Flag, Holding, Turned};
use pintle_kinematics::measure::SingularClass;
use pintle_scene::grammar::number;
use std::f64::consts::PI;

/// What a flag says.
pub fn flag_in_words(flag: &Flag) -> String {
    in_words(flag, std::slice::from_ref(flag))
}

/// What the flags of one connector say: a line for each, and one for all components that are on, or near, the same singular
/// set, or of which the same is not finite.
pub fn flags_in_words(flags: &[Flag]) -> Vec<String> {
    let mut groups: Vec<Vec<Flag>> = Vec::new();
    for flag in flags {
        match groups.iter_mut().find(|group| group.iter().all(|other| differ_in_component(other, flag))) {
            Some(group) => group.push(*flag),
            None => groups.push(vec![*flag]),
        }
    }
    groups.iter().filter_map(|group| group.first().map(|flag| in_words(flag, group))).collect()
}

/// Whether two flags are alike but for their components, and distances.
fn differ_in_component(one: &Flag, other: &Flag) -> bool {
    let is_alike = match (one, other) {
        (Flag::Singular { at, class, .. }, Flag::Singular { at: other_at, class: other_class, .. })
        | (
            Flag::IllConditioned { at, class, .. },
            Flag::IllConditioned { at: other_at, class: other_class, .. },
        ) => (at, class) == (other_at, other_class),
        (Flag::NotFinite { quantity, .. }, Flag::NotFinite { quantity: other, .. }) => quantity == other,
        (Flag::NotKnown { quantity, why, .. }, Flag::NotKnown { quantity: other, why: other_why, .. }) => {
            (quantity, why) == (other, other_why)
        }
        (
            Flag::LargeIncrement { of, change, .. },
            Flag::LargeIncrement { of: other, change: other_change, .. },
        ) => *of != Turned::Component && of == other && change.to_bits() == other_change.to_bits(),
        _ => false,
    };
    is_alike && one.component() != other.component()
}

/// The distances to a singular set, as one, or as the least and the greatest.
fn distances(group: &[Flag]) -> String {
    let all = || {
        group.iter().filter_map(|flag| match flag {
            Flag::IllConditioned { distance, .. } => Some(*distance),
            _ => None,
        })
    };
    let least = number(all().fold(f64::INFINITY, f64::min), 4);
    let greatest = number(all().fold(0.0, f64::max), 4);
    if least == greatest { least } else { format!("{least} to {greatest}") }
}

/// What `flag` says of all components in a group that has it.
fn in_words(flag: &Flag, group: &[Flag]) -> String {
    let components = group.iter().map(Flag::component).collect::<Vec<_>>().join(", ");
    let (are, its) = if group.len() == 1 { ("is", "its") } else { ("are", "each") };
    match flag {
        Flag::Singular { at, class, .. } => {
            let consequence = match class {
                SingularClass::Kink => {
                    "derivatives do not exist there; zero, or the direction kept, stands for them".to_string()
                }
                SingularClass::TrueSingularity => {
                    "neither value nor derivatives are determined there".to_string()
                }
                SingularClass::BranchCut => format!("the sign of {its} value is not determined there"),
                SingularClass::Reversal => format!(
                    "the sign of {its} value is not determined there, and derivatives do not exist; zero, or the direction kept, stands for them"
                ),
                SingularClass::Removable => "value and derivatives exist there".to_string(),
            };
            format!("{components} {are} singular, at {at}: {consequence}")
        }
        Flag::IllConditioned { at, class, .. } => {
            let consequence = match class {
                SingularClass::Kink => "derivatives lose digits in proportion to 1/distance".to_string(),
                SingularClass::TrueSingularity => {
                    "value and derivatives lose digits in proportion to 1/distance".to_string()
                }
                SingularClass::BranchCut => format!("rounding may decide the sign of {its} value"),
                SingularClass::Reversal => format!(
                    "rounding may decide the sign of {its} value, and derivatives lose digits in proportion to 1/distance"
                ),
                SingularClass::Removable => "nothing is lost".to_string(),
            };
            format!("{components} {are} ill-conditioned, {} from {at}: {consequence}", distances(group))
        }
        Flag::UndeterminedOrigin { at, .. } => format!(
            "displacements of {components} count from an arbitrary origin: initially {components} {are} at {at} but for rounding"
        ),
        Flag::NotFinite { quantity, .. } => {
            format!(
                "{quantity} of {components} is not finite: the state lies beyond what its formula can be evaluated at"
            )
        }
        Flag::PathDependent { component, difference } => format!(
            "{component} depends on what lies between this state and the last: {} rad from nodes that turn at constant rates",
            number(*difference, 4)
        ),
        Flag::OffConstraint { component, by, residual } => {
            let held = match by {
                Holding::Constraint => "constrained",
                Holding::Motion => "driven by a connector motion",
                Holding::Limit => "held by a lock or stop",
            };
            format!(
                "{component} is {held}, and is {} off: more than coordinates are rounded",
                number(*residual, 4)
            )
        }
        Flag::OutOfPlane { component } => {
            format!(
                "a node moves out of the plane of this two-dimensional connector, as {component}: that part is not its own"
            )
        }
        Flag::NotKnown { quantity, why, .. } => format!("{quantity} of {components} is not known: {why}"),
        Flag::ForceKink { component, at, left, right } => format!(
            "the slope of the force of {component} jumps from {left:?} to {right:?} at {at:?}: the one of smaller magnitude is used, \
             or 0 between opposite signs"
        ),
        Flag::BeyondStop { component, by } => {
            format!(
                "{component} lies {} beyond its stop: a motion that a stop does not allow",
                number(*by, 4)
            )
        }
        Flag::StopPulls { component, reaction } => format!(
            "the forces given leave {component} a reaction of {} at its stop, which pulls: a stop only pushes",
            number(*reaction, 7)
        ),
        Flag::Locked { component, limit } => {
            format!("the {limit} limit of {component} is passed: a lock closes")
        }
        Flag::Failed { component, limit } => {
            format!("the {limit} limit of {component} is passed: the connector fails")
        }
        Flag::Undecided { component, criterion, why } => {
            format!("whether the {criterion} of {component} acts is not decided: {why}")
        }
        Flag::Friction { component: "C", what } => format!("the friction that components share: {what}"),
        Flag::Friction { component, what } => format!("the friction of {component}: {what}"),
        Flag::OutOfBalance { component, by } => format!(
            "the force given for {component} is {} more than its parts, and nothing holds the component that could take it",
            number(*by, 7)
        ),
        Flag::ForcesRefused { code, .. } => format!(
            "the forces that the state gives are not its own, and none of them is taken: pintle explain {code}"
        ),
        Flag::AmbiguousTurn { node, taken, other, .. } => format!(
            "the rotation vectors of node {node} fit a turn of {taken:.6} rad since the previous state, which is taken, and one of {other:.6} rad: give more states, or quaternions"
        ),
        Flag::LargeIncrement { change, .. } if change.abs() <= CERTAIN_INCREMENT * PI => format!(
            "whole turns of the nodes since the previous state were not about the axis of {components}: its turns are not certain"
        ),
        Flag::LargeIncrement { of, change, .. } => {
            let follow = if group.len() == 1 { "follows" } else { "follow" };
            let turned = match of {
                Turned::Component => format!("{components} moved"),
                Turned::Torsion => format!("the torsion, which {components} {follow}, turned"),
                Turned::RotationVector => format!("the rotation vector of {components} turned"),
                Turned::NodeA => format!("node a, whose turn {components} {follow}, turned"),
                Turned::NodeB => format!("node b, whose turn {components} {follow}, turned"),
            };
            format!(
                "{turned} by {change:.6} rad since the previous state, more than 0.9 π: its turns are not certain"
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use super::flag_in_words;
    use pintle_kinematics::connector::{Flag, Turned};

    /// An angle that hardly moved did not move by more than 0.9 π.
    #[test]
    fn a_large_increment_says_which_of_two_it_is() {
        let told =
            |change| flag_in_words(&Flag::LargeIncrement { component: "ur3", of: Turned::Component, change });
        assert!(told(-3.1).contains("ur3 moved by -3.100000 rad since the previous state, more than 0.9 π"));
        assert!(told(-1e-17).contains("were not about the axis of ur3"), "{}", told(-1e-17));
    }
}
