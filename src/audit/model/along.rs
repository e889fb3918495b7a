//! What happens along the given states: singular points on the way or near it, angles that move too far to count their turns,
//! constraints that do not hold, stops that are passed.

use crate::model::behavior::{Placed, violated_at_state};
use crate::model::certainty::Certainty;
use crate::model::finding::{About, Finding};
use crate::model::gather::Gathered;
use crate::model::levels::Levels;
use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::connector::{Flag, Mask, Output, Request, Turned};
use pintle_kinematics::measure::{Margin, Measure, Unit};
use pintle_kinematics::scalar::elementary::norm;
use pintle_model::evaluate::{
    ConnectorElement, ConnectorResult, Item, Model, MpcResult, Plan, RelationResult, Sequence,
};
use pintle_scene::grammar::number as short;
use pintle_scene::{Code, ConnectorMotion, Label, Scene, Severity, Span, State, Target};
use serde::Serialize;
use std::convert::Infallible;

/// The distance to a singular set (rad; of a length, in units of the connector's own) below which the way is noted.
const NEAR: f64 = 0.05;
/// The residual (rad; of a length, in units of the connector's own) beyond which a state does not satisfy a constraint: well above
/// what single precision and the tolerances of solvers leave.
const VIOLATED: f64 = 1e-3;
/// Every component.
const ALL: Mask = [true; 6];

/// How near a connector comes to a singular set, at the initial state or one of those given.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Nearest {
    /// The connector.
    pub element: Label,
    /// The component of relative motion, `u1` … `ur3`.
    pub component: &'static str,
    /// The set.
    pub at: &'static str,
    /// The distance to it: an angle (rad), or a length in the unit of the scene.
    pub distance: f64,
    /// Of which of the two.
    pub unit: Unit,
    /// The number of the state; none for the initial one.
    pub state: Option<u64>,
}

/// What is found at the initial state and along those given, and the least distance to a singular set on the way. Angles in rad and
/// lengths in units of the connector's own are compared as they are. `seen` is handed every connector at every given state.
pub(super) fn findings(
    scene: &Scene,
    model: &Model,
    states: &[State],
    levels: &Levels,
    seen: &mut dyn FnMut(&ConnectorResult),
) -> (Vec<Finding>, Option<Nearest>) {
    let evaluated = scene.mpcs.iter().filter(|mpc| mpc.kind.evaluated().is_some());
    let spans = evaluated.map(|mpc| mpc.span).collect();
    let gathered = Gathered::new(levels);
    let mut walk = Walk {
        scene,
        model,
        lengths: lengths(model),
        spans,
        gathered,
        certainty: Certainty::of(scene),
        nearest: None,
        state: None,
        is_first: false,
    };
    let request = Request::new(&[Output::CP, Output::CU, Output::RES], ALL, 0);
    let plan = Plan::everything(model, request);
    let mut sequence = Sequence::new(model, &plan);
    let Ok(()) = sequence.visit(&State::default(), |item| -> Result<(), Infallible> {
        walk.look(item);
        Ok(())
    });
    let mut sequence = Sequence::new(model, &plan);
    for (index, state) in states.iter().enumerate() {
        walk.state = Some(state.number.unwrap_or(index as u64));
        walk.is_first = index == 0;
        walk.certainty.at(state);
        let Ok(()) = sequence.visit(state, |item| -> Result<(), Infallible> {
            walk.look(item);
            if let Item::Connector(result) = item {
                seen(result);
            }
            Ok(())
        });
    }
    (walk.gathered.findings().collect(), walk.nearest.map(|(_, nearest)| nearest))
}

/// The length that tells near from far, for each connector: its own, or the mean of the model where its nodes coincide.
fn lengths(model: &Model) -> Vec<f64> {
    let own: Vec<f64> = model.connectors.iter().map(|element| norm(element.reference)).collect();
    let apart: Vec<f64> = own.iter().copied().filter(|length| *length > 0.0).collect();
    let mean = if apart.is_empty() { 1.0 } else { apart.iter().sum::<f64>() / apart.len() as f64 };
    own.into_iter().map(|length| if length > 0.0 { length } else { mean }).collect()
}

/// Whether component k (0-based) is a length.
fn is_of_length(element: &ConnectorElement, k: usize) -> bool {
    element.connector.differentiated(k).is_some_and(|measure| measure.unit() == Unit::Length)
}

struct Walk<'a> {
    scene: &'a Scene,
    model: &'a Model,
    lengths: Vec<f64>,
    /// Where each constraint of the model was read.
    spans: Vec<Span>,
    gathered: Gathered<'a>,
    certainty: Certainty<'a>,
    /// The least distance to a singular set so far, in units of the connector's length where it is one, and where.
    nearest: Option<(f64, Nearest)>,
    /// The number of the state; none for the initial one.
    state: Option<u64>,
    /// Whether that is the first one given.
    is_first: bool,
}

/// What is found, before it is a finding.
struct Found {
    code: Code,
    what: String,
    reason: String,
    remedy: &'static str,
    components: Vec<String>,
    /// How much: smaller is worse for distances, larger for the others.
    value: f64,
}

impl Walk<'_> {
    fn look(&mut self, item: Item<'_>) {
        match item {
            Item::Connector(result) => self.connector(result),
            Item::Mpc(result) => self.constraint(result),
            Item::Relation(result) => self.relation(result),
        }
    }

    fn when(&self) -> String {
        self.state.map_or_else(|| "initially".to_string(), |state| format!("at state {state}"))
    }

    fn connector(&mut self, result: &ConnectorResult) {
        let Some(element) = self.model.connectors.get(result.index) else { return };
        let Some(given) = self.scene.connectors.get(&element.label) else { return };
        let length = self.lengths.get(result.index).copied().unwrap_or(1.0);
        let mut found: Vec<Found> = Vec::new();
        for flag in &result.flags {
            let Some(one) = self.flag(element, flag) else { continue };
            // What several components are made of turns once.
            match found.iter_mut().find(|told| told.code == one.code && told.what == one.what) {
                Some(told) => told.components.extend(one.components),
                None => found.push(one),
            }
        }
        for (k, margin) in result.margins.iter().enumerate() {
            let Some(Margin { distance, set }) = *margin else { continue };
            let size = if set.unit == Unit::Length { length } else { 1.0 };
            if self.is_directed(element, k) {
                continue;
            }
            if self.nearest.as_ref().is_none_or(|(least, _)| distance / size < *least) {
                let (component, at, unit) = (COMPONENT[k], set.at, set.unit);
                let nearest =
                    Nearest { element: element.label, component, at, distance, unit, state: self.state };
                self.nearest = Some((distance / size, nearest));
            }
            let is_told = found.iter().any(|told| told.components.iter().any(|name| name == COMPONENT[k]));
            // A distance that is no number is told of as the position that it is of.
            let is_near = distance < NEAR * size;
            if !is_near || is_told {
                continue;
            }
            found.push(Found {
                code: Code::ModelNearSingular,
                what: format!("{} is {distance}{} from {} ({})", COMPONENT[k], unit(set.unit), set.at, class(set.class), distance = short(distance, 4)),
                reason: format!("distance: {}", set.distance),
                remedy: "keep clear of it, or choose a type that is regular there (`pintle explain` names the singular points)",
                components: vec![COMPONENT[k].to_string()],
                value: distance,
            });
        }
        let [position, displacement, residual] =
            [result.evaluation.position, result.evaluation.displacement, result.evaluation.residual];
        for (quantity, values) in
            [("the position", position), ("the displacement", displacement), ("the residual", residual)]
        {
            for k in (0..6).filter(|k| values[*k].is_some_and(|value| !value.is_finite())) {
                found.extend(flagged(&Flag::NotFinite { component: COMPONENT[k], quantity }, false));
            }
        }
        for (k, residual) in residual.into_iter().enumerate() {
            let Some(residual) = residual else { continue };
            let of_length = is_of_length(element, k);
            let size = if of_length { length } else { 1.0 };
            // What is no finite number is told above.
            if residual.is_finite() && residual.abs() > VIOLATED * size {
                let is_driven = element.behavior.drives.motions[k].is_some();
                let held = match () {
                    () if is_driven => DRIVEN,
                    () if element.connector.is_constrained(k) => CONSTRAINED,
                    () => LIMITED,
                };
                let found = violated((COMPONENT[k], held), residual, of_length);
                let motion = is_driven.then(|| self.motion(element.label, k)).flatten();
                let place = motion.unwrap_or(given.span);
                self.add((given.section, element.label, place), None, found);
            }
        }
        for found in found {
            self.add((given.section, element.label, given.span), None, found);
        }
        if let Some(number) = self.state {
            let (scene, state) = (self.scene, &result.state);
            let at = Placed { scene, element, positions: &position, state, number: Some(number) };
            // Where a history begins is given; what follows is computed.
            let slack = |k: usize| {
                if self.is_first {
                    0.0
                } else {
                    VIOLATED * if is_of_length(element, k) { length } else { 1.0 }
                }
            };
            for (stop, finding) in violated_at_state(&at, &self.certainty, slack) {
                let of = (given.section, Some(stop));
                self.gathered.add(of, element.label, finding, |new, old| new.value > old.value);
            }
        }
    }

    fn constraint(&mut self, result: &MpcResult) {
        let Some(element) = self.model.mpcs.get(result.index) else { return };
        let span = self.spans.get(result.index).copied().unwrap_or_default();
        let title = element.title();
        let arm = norm(element.constraint.arm());
        let mut found: Vec<Found> = result.flags.iter().filter_map(|flag| flagged(flag, false)).collect();
        for (row, residual) in result.evaluation.residual.iter().enumerate() {
            let Some(residual) = *residual else { continue };
            let of_length = !(pintle_kinematics::mpc::RHO..pintle_kinematics::mpc::FLOW).contains(&row);
            let size = if of_length && arm > 0.0 { arm } else { 1.0 };
            let component = element.constraint.kind().row_name(row);
            if !residual.is_finite() {
                found.extend(flagged(&Flag::NotFinite { component, quantity: "the residual" }, false));
            } else if residual.abs() > VIOLATED * size {
                found.push(violated((component, CONSTRAINED), residual, of_length));
            }
        }
        for found in found {
            // Constraints have no section; each is told by itself.
            let section = usize::MAX - result.index;
            let Some(first) = element.nodes.first().copied() else { return };
            self.add((section, first, span), Some(title.clone()), found);
        }
    }

    fn relation(&mut self, result: &RelationResult) {
        let Some(element) = self.model.relations.get(result.index) else { return };
        let length = element.length();
        let mut found: Vec<Found> = result.flags.iter().filter_map(|flag| flagged(flag, false)).collect();
        for ((component, unit), row) in element.relation.rows().into_iter().zip(&result.rows) {
            let of_length = unit == Unit::Length;
            let size = if of_length && length > 0.0 { length } else { 1.0 };
            if row.residual.is_finite() && row.residual.abs() > VIOLATED * size {
                found.push(violated((component, CONSTRAINED), row.residual, of_length));
            }
        }
        let section = usize::MAX - self.model.mpcs.len() - result.index;
        for found in found {
            let Some(first) = element.nodes.first().copied() else { return };
            self.add((section, first, element.span), Some(element.title()), found);
        }
    }

    /// Of a connector, or of the constraint of that title.
    fn add(
        &mut self,
        (section, label, place): (usize, Label, Span),
        constraint: Option<String>,
        found: Found,
    ) {
        let of = constraint.clone().unwrap_or_else(|| format!("element {label}"));
        let message = format!("{of}: {} {}", found.what, self.when());
        let mut about = About {
            components: found.components,
            state: self.state,
            value: Some(found.value),
            ..About::default()
        };
        match constraint {
            Some(title) => about.mpcs = vec![title],
            None => about.elements = vec![label],
        }
        let nearer_is_worse = matches!(
            found.code,
            Code::ModelNearSingular
                | Code::ModelIllConditioned
                | Code::ModelNearlyCoincident
                | Code::ModelSingular
        );
        let finding = Finding::new(self.scene, found.code, place, message, found.reason, found.remedy)
            .of_severity(found.code.severity().min(Severity::Warning))
            .about(about);
        self.gathered.add((section, None), label, finding, |new, old| match (new.value, old.value) {
            (Some(new), Some(old)) if nearer_is_worse => new < old,
            (Some(new), Some(old)) => new.abs() > old.abs(),
            _ => false,
        });
    }

    /// Where a motion that drives a component (0-based) was read: the first that does.
    fn motion(&self, element: Label, k: usize) -> Option<Span> {
        let steps = self.scene.steps.iter().flat_map(|step| &step.connector_motions);
        let mut all = self.scene.connector_motions.iter().chain(steps);
        let names = |motion: &&ConnectorMotion| {
            usize::from(motion.component) == k + 1
                && match &motion.target.value {
                    Target::Label(label) => *label == element,
                    Target::Set(name) => {
                        let set = self.scene.element_sets.get(name.as_str());
                        set.is_some_and(|set| set.labels.contains(&element))
                    }
                }
        };
        all.find(names).map(|motion| motion.target.span)
    }

    /// Whether an orientation stands in for the line of the nodes where they coincide.
    fn is_directed(&self, element: &ConnectorElement, k: usize) -> bool {
        element.connector.position_measure(k) == Some(Measure::Distance)
            && element.connector.section().fixed_direction != [0.0; 3]
    }

    fn flag(&self, element: &ConnectorElement, flag: &Flag) -> Option<Found> {
        if matches!(flag, Flag::AmbiguousTurn { .. }) {
            return flagged(flag, false);
        }
        let k = COMPONENT.iter().position(|name| *name == flag.component())?;
        let measure = element.connector.position_measure(k)?;
        let is_length = matches!(measure, Measure::Distance | Measure::Strain);
        if self.is_directed(element, k) && matches!(flag, Flag::Singular { .. } | Flag::IllConditioned { .. })
        {
            return None;
        }
        flagged(flag, is_length && self.state.is_none())
    }
}

/// What a flag says, as a finding; `is_length`: of the distance of two nodes, initially.
fn flagged(flag: &Flag, is_length: bool) -> Option<Found> {
    let components = vec![flag.component().to_string()];
    let found = match flag {
        Flag::Singular { component: name, at, class: of } => Found {
            // Where a rule does not refuse it.
            code: if is_length { Code::CoincidentNodes } else { Code::ModelSingular },
            what: format!("{name} is singular ({at}; {})", class(*of)),
            reason: "derivatives do not exist there, and are reported as zero or along the direction kept"
                .into(),
            remedy: if is_length {
                "move a node, or name an orientation that stands in for the direction where the type takes one"
            } else {
                "choose another initial orientation, or a type that is regular there (`pintle explain` names the singular points)"
            },
            components,
            value: 0.0,
        },
        Flag::IllConditioned { component: name, at, class: of, distance } => Found {
            code: if is_length { Code::ModelNearlyCoincident } else { Code::ModelIllConditioned },
            what: format!("{name} is {distance} from {at} ({})", class(*of), distance = short(*distance, 4)),
            reason: "the relative error of derivatives grows like the rounding unit over the distance".into(),
            remedy: "move the nodes apart or together, or choose a type that is regular there",
            components,
            value: *distance,
        },
        Flag::LargeIncrement { component: name, of, change } => Found {
            code: Code::ModelLargeIncrement,
            what: match of {
                Turned::Component => format!("{name} moves by {change:.4} rad since the state before"),
                Turned::Torsion => format!("its torsion turns by {change:.4} rad since the state before"),
                Turned::RotationVector => {
                    format!("its rotation vector turns by {change:.4} rad since the state before")
                }
                Turned::NodeA => format!("node a turns by {change:.4} rad since the state before"),
                Turned::NodeB => format!("node b turns by {change:.4} rad since the state before"),
            },
            reason: "beyond 0.9 π the number of turns is a guess".into(),
            remedy: "give more states, or rotation vectors beyond half a turn, which tell the turns",
            components,
            value: *change,
        },
        Flag::AmbiguousTurn { node, taken, other, .. } => Found {
            code: Code::ModelAmbiguousTurn,
            what: format!(
                "node {node} turns by {taken:.4} rad since the state before, or by {other:.4} rad the other way"
            ),
            reason: "its two rotation vectors fit both turns".into(),
            remedy: "give more states, or quaternions, which always turn the shorter way",
            components,
            value: *taken,
        },
        Flag::PathDependent { component: name, difference } => Found {
            code: Code::ModelPathDependent,
            what: format!(
                "{name} depends on the path by {difference} rad since the state before",
                difference = short(*difference, 2)
            ),
            reason: "a one-form is accumulated along the path, which the two states do not tell".into(),
            remedy: "give more states",
            components,
            value: *difference,
        },
        Flag::NotFinite { component: name, quantity } => Found {
            code: Code::ModelStateNotFinite,
            what: format!("{quantity} of {name} is not a finite number"),
            reason: "the state lies beyond what the formula can be evaluated at".into(),
            remedy: "look at the displacements and rotations of this state",
            components,
            value: 0.0,
        },
        _ => return None,
    };
    Some(found)
}

/// What holds a component.
const CONSTRAINED: &str = "is constrained";
const DRIVEN: &str = "is driven by a connector motion";
const LIMITED: &str = "is held by a lock or stop";

fn violated((component, held): (&str, &str), residual: f64, of_length: bool) -> Found {
    let unit = if of_length { "" } else { " rad" };
    Found {
        code: Code::ModelConstraintViolated,
        what: format!("{component} {held}, and is {residual}{unit} off", residual = short(residual, 4)),
        reason: "a residual beyond a thousandth of a radian, or of the length of the connector".into(),
        remedy: "check that the states are those of this model, and their units; rotations are rotation vectors in rad",
        components: vec![component.to_string()],
        value: residual,
    }
}

fn class(class: pintle_kinematics::measure::SingularClass) -> &'static str {
    use pintle_kinematics::measure::SingularClass::{BranchCut, Kink, Removable, Reversal, TrueSingularity};
    match class {
        Kink => "the first derivatives jump",
        TrueSingularity => "derivatives grow without bound",
        BranchCut => "the principal value jumps by a period",
        Reversal => "the value jumps to its opposite, and the first derivatives jump",
        Removable => "value and derivatives continue",
    }
}

const fn unit(unit: Unit) -> &'static str {
    match unit {
        Unit::Angle => " rad",
        Unit::Length | Unit::None => "",
    }
}
