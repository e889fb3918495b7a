//! The multi-point constraints of a scene: resolved once, evaluated at a state.

pub(super) mod forces;

use crate::behavior::drive::{Drives, Schedule, on_angles};
use crate::behavior::ground::Ground;
use crate::behavior::{Conditions, Unknown};
use crate::evaluate::mpc::forces::{
    Hinge, MpcForces, MpcSlopes, NOT_GIVEN, given_forces, on_first_node, on_hinges, order,
};
use crate::evaluate::sequence::nodes::{Moved, ambiguous_turns};
use pintle_kinematics::catalog::FORCE;
use pintle_kinematics::connector::{Flag, Output, Request, Tally, Turns};
use pintle_kinematics::mpc::{
    Body, Constraint, DOFS, Dofs, Evaluation, Margins, MpcType, PHI, State, Turning,
};
use pintle_kinematics::scalar::Real;
use pintle_kinematics::vector::sub;
use pintle_scene::{
    Code, Diagnostic, Label, LabelSet, Mpc, PointKind, Scene, Solver, Span, State as SceneState, Target,
};
use std::collections::HashMap;

/// A multi-point constraint, ready to be evaluated.
#[derive(Clone, Debug)]
pub struct MpcElement {
    /// Its nodes, in the order of [`pintle_kinematics::mpc::Entry::nodes`].
    pub nodes: Vec<Label>,
    /// The constraint.
    pub constraint: Constraint<f64>,
    /// The springs and dashpots to ground on the angles of its hinges (SPRING1, DASHPOT1 in degree of freedom 6).
    pub ground: [Ground; 2],
    /// What is prescribed for the angles of its hinges: boundary conditions and concentrated moments in degree of freedom 6.
    pub drives: [Drives; 2],
}

/// What springs and dashpots to ground do to the angle of a hinge: internal moments, positive resists growth of the angle.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct HingeMoments {
    /// Of the springs.
    pub spring: f64,
    /// How that changes with the angle (moment/rad).
    pub stiffness: f64,
    /// The energy in the springs.
    pub energy: f64,
    /// Of the dashpots, where the rate of the angle is known: given, or asked for (output CV).
    pub dashpot: Option<f64>,
    /// How that changes with the rate (moment·time/rad).
    pub damping: Option<f64>,
    /// Whether there are dashpots.
    #[serde(skip)]
    pub has_dashpot: bool,
}

/// One multi-point constraint at one state.
#[derive(Clone, Debug)]
pub struct MpcResult {
    /// Its index in the model.
    pub index: usize,
    /// Its nodes.
    pub state: State<f64>,
    /// How the first turned against the second since the previous state.
    pub turning: Turning<f64>,
    /// The angles of its hinges that the previous state left.
    pub before: [Turns<f64>; 2],
    /// The numbers.
    pub evaluation: Evaluation<f64>,
    /// The angles of its hinges as the state gives them, where it does (rad).
    pub given: [Option<f64>; 2],
    /// How far the relative rotation is from what the hinges allow (rad), where there are any.
    pub misalignment: Option<f64>,
    /// What acts on the angles of its hinges, where there are springs or dashpots; or why it is not known.
    pub moments: [Option<Result<HingeMoments, Unknown>>; 2],
    /// What else acts on them, and what the constraint puts there; `None` for hinges that there are not.
    pub hinges: [Option<Hinge>; 2],
    /// What it transmits, where forces on its first node are given and it is asked for.
    pub forces: Option<Box<MpcForces>>,
    /// What springs and dashpots on its angles do, where that is asked for and no forces are given.
    pub slopes: Option<Box<MpcSlopes>>,
    /// The distances to singular points.
    pub margins: Margins,
    /// What needs care.
    pub flags: Vec<Flag>,
}

/// The moments of springs and dashpots, with their derivatives.
fn moments(ground: &Ground, angle: f64, rate: Option<f64>) -> Result<HingeMoments, Unknown> {
    let conditions = Conditions::default();
    let along = |value| num_dual::Dual64::new(value, 1.0);
    let spring = ground.spring(along(angle), &conditions)?;
    let dashpot = rate
        .filter(|_| ground.has_dashpots())
        .map(|rate| ground.dashpot(along(rate), &conditions))
        .transpose()?;
    Ok(HingeMoments {
        spring: spring.re,
        stiffness: spring.eps,
        energy: ground.energy(angle, &conditions)?,
        dashpot: dashpot.map(|moment| moment.re),
        damping: dashpot.map(|moment| moment.eps),
        has_dashpot: ground.has_dashpots(),
    })
}

/// Puts the springs and dashpots to ground in degree of freedom 6 on the hinges of which that is the angle, and gives the elements
/// that found one. One with an orientation or a complex stiffness finds none.
///
/// # Errors
/// A table out of order or incomplete.
pub(super) fn ground(scene: &Scene, elements: &mut [(MpcElement, Span)]) -> Result<LabelSet, Diagnostic> {
    let mut found = LabelSet::default();
    let mut hinges: HashMap<Label, Vec<(usize, usize)>> = HashMap::new();
    for (index, (element, _)) in elements.iter().enumerate() {
        let angles = element.constraint.kind().entry().angles.len();
        for (place, node) in element.nodes.iter().skip(2).take(angles).enumerate() {
            hinges.entry(*node).or_default().push((index, place));
        }
    }
    if hinges.is_empty() {
        return Ok(found);
    }
    let springs = scene.springs.iter().map(|given| (PointKind::Spring1, given));
    let dashpots = scene.dashpots.iter().map(|given| (PointKind::Dashpot1, given));
    for (kind, given) in springs.chain(dashpots) {
        if given.degrees_of_freedom != [6] || given.orientation.is_some() || given.complex {
            continue;
        }
        let Some(set) = scene.element_sets.get(given.element_set.value.as_str()) else { continue };
        for label in &set.labels {
            let Some(element) = scene.point_elements.get(label).filter(|of| of.kind == kind) else {
                continue;
            };
            for (index, place) in hinges.get(&element.node).into_iter().flatten() {
                let Some((of, _)) = elements.get_mut(*index) else { continue };
                let ground = &mut of.ground[*place];
                let added = match kind {
                    PointKind::Spring1 => ground.add_spring(given),
                    _ => ground.add_dashpot(given),
                };
                added.map_err(|error| error.in_file(&scene.name))?;
                found.insert(*label);
            }
        }
    }
    Ok(found)
}

/// Which degrees of freedom constraints have made dependent, and by which of them.
#[derive(Default)]
struct Eliminated<'a> {
    by: HashMap<(Label, u8), &'a MpcElement>,
    /// LINKs, each of which takes one displacement of the node.
    links: HashMap<Label, Vec<&'a MpcElement>>,
}

/// What speaks against a deck's use of a degree of freedom that a constraint has eliminated.
const ELIMINATION: &str =
    "by the rules for multi-point constraints: dependent degrees of freedom are eliminated";

impl<'a> Eliminated<'a> {
    /// Takes the degrees of freedom that a constraint makes dependent.
    ///
    /// # Errors
    /// In words, one that is dependent already.
    fn take(&mut self, element: &'a MpcElement) -> Result<(), String> {
        let Some(node) = element.nodes.first().copied() else { return Ok(()) };
        if element.constraint.kind() == MpcType::Link {
            let links = self.links.entry(node).or_default();
            links.push(element);
        } else {
            let columns = element.constraint.columns();
            for (place, dof) in (0..DOFS).filter(|j| columns[*j]).map(MpcType::column_dof) {
                if place > 0 {
                    continue;
                }
                if let Some(other) = self.by.insert((node, dof), element) {
                    return Err(format!(
                        "{} makes degree of freedom {dof} of node {node} dependent, and so does {}",
                        element.title(),
                        other.title()
                    ));
                }
            }
        }
        let links = self.links.get(&node).map_or(&[][..], Vec::as_slice);
        let held = self.by.get(&(node, 1)).copied().into_iter().chain(links.iter().copied());
        let many = links.len() > if self.by.contains_key(&(node, 1)) { 0 } else { 3 };
        if many {
            let names: Vec<String> = held.map(MpcElement::title).collect();
            return Err(format!(
                "node {node} has three displacements, and more are made dependent by {}",
                names.join(", ")
            ));
        }
        Ok(())
    }
}

/// What is wrong with the constraints of a scene: errors, a degree of freedom that is dependent twice, or, but in Explicit, dependent and
/// prescribed; and warnings, axes and links that have no use.
pub(super) fn check(scene: &Scene, elements: &[(MpcElement, Span)]) -> [Vec<Diagnostic>; 2] {
    let (mut errors, mut warnings) = (Vec::new(), Vec::new());
    let mut eliminated = Eliminated::default();
    for (element, span) in elements {
        errors.extend(eliminated.take(element).err().map(|message| {
            Diagnostic::error(Code::DofEliminated, *span, message, ELIMINATION)
                .help("remove one of the constraints, or make another of its nodes the first, dependent one")
                .in_file(&scene.name)
        }));
        warnings.extend(doubts(element).map(|(code, message, label, remedy)| {
            Diagnostic::warning(code, *span, message, label).help(remedy).in_file(&scene.name)
        }));
    }
    let mut prescribed: HashMap<Label, [bool; 3]> = HashMap::new();
    let boundaries = scene.boundaries.iter().chain(scene.steps.iter().flat_map(|step| &step.boundaries));
    for boundary in boundaries {
        let nodes: &[Label] = match &boundary.target.value {
            Target::Label(label) => std::slice::from_ref(label),
            Target::Set(name) => scene.node_sets.get(name.as_str()).map_or(&[], |set| set.labels.as_slice()),
        };
        for node in nodes {
            for dof in boundary.degrees_of_freedom.iter().copied() {
                if let Some(displacement) = [1, 2, 3].iter().position(|d| *d == dof) {
                    prescribed.entry(*node).or_default()[displacement] = true;
                }
                let of_links = eliminated.links.get(node).filter(|links| {
                    let held = prescribed.get(node).map_or(0, |held| held.iter().filter(|is| **is).count());
                    dof <= 3 && links.len() + held > 3
                });
                let by = eliminated.by.get(&(*node, dof)).or_else(|| of_links?.last());
                let Some(element) = by else { continue };
                let message = format!(
                    "degree of freedom {dof} of node {node} is prescribed, and {} makes it dependent",
                    element.title()
                );
                let is_explicit = scene.solver == Some(Solver::Explicit);
                let build = if is_explicit { Diagnostic::warning } else { Diagnostic::error };
                let remedy = "prescribe it at the second node of the constraint, or remove one of the two";
                let diagnostic = build(Code::DofEliminated, boundary.target.span, message, ELIMINATION)
                    .help(remedy)
                    .in_file(&scene.name);
                if is_explicit { &mut warnings } else { &mut errors }.push(diagnostic);
            }
        }
    }
    [errors, warnings]
}

/// The cosine of the angle between the axes of a universal joint beyond which they are not taken for orthogonal.
const ORTHOGONAL: f64 = 1e-6;
/// The angle to 0 or π (rad) below which axes are taken for parallel.
const PARALLEL: f64 = 1e-8;

/// What a constraint may not have been meant to be.
fn doubts(element: &MpcElement) -> Option<(Code, String, &'static str, &'static str)> {
    let title = element.title();
    if element.constraint.kind() == MpcType::Link {
        let is_point = element.constraint.arm() == [0.0; 3];
        return is_point.then(|| {
            let message = format!("{title} has no length: its nodes coincide initially");
            (Code::CoincidentNodes, message, "by keyword *MPC, type LINK", "move a node, or use PIN")
        });
    }
    let angle = element.constraint.axes_angle()?;
    let label =
        "by the Theory Guide, universal joint (orthogonal axes); how the nodes give the axes is our reading";
    let (what, remedy) = if angle.min(std::f64::consts::PI - angle) < PARALLEL {
        (
            "are parallel: only the sum or difference of its angles is determined",
            "move the third or fourth node, off the other axis",
        )
    } else if angle.cos().abs() > ORTHOGONAL {
        (
            "are not orthogonal; they are taken as they are",
            "move the fourth node, so that the two lines from the second node are",
        )
    } else {
        return None;
    };
    let degrees = angle.to_degrees();
    Some((Code::MpcAxes, format!("the axes of {title}, at {degrees:.6}°, {what}"), label, remedy))
}

/// The angles that a walk begins with.
pub(super) const START: [Turns<f64>; 2] = [Turns { turns: 0.0, principal: 0.0 }; 2];

impl MpcElement {
    /// The constraint of a scene.
    pub(super) fn new(kind: MpcType, mpc: &Mpc, scene: &Scene, flows: impl Fn(Label) -> bool) -> Self {
        let at = |place: usize| {
            let node = mpc.nodes.get(place).and_then(|label| scene.nodes.get(label));
            node.map_or([0.0; 3], |node| node.coordinates)
        };
        let constraint = Constraint::new(kind, at(0), at(1), [at(2), at(3)]);
        let both_flow = mpc.nodes.iter().take(2).all(|label| flows(*label));
        let constraint = if both_flow { constraint.with_flow() } else { constraint };
        let constraint = if scene.two_dimensional { constraint.in_plane() } else { constraint };
        Self { nodes: mpc.nodes.clone(), constraint, ground: Default::default(), drives: Default::default() }
    }

    /// Its nodes as one word: `10-20-30`.
    pub fn label(&self) -> String {
        self.nodes.iter().map(ToString::to_string).collect::<Vec<_>>().join("-")
    }

    /// Its kind and nodes: `MPC REVOLUTE 10-20-30`.
    pub fn title(&self) -> String {
        format!("MPC {} {}", self.constraint.kind().name(), self.label())
    }

    /// What saved branches call it: its place among the constraints, its kind and nodes.
    pub(super) fn key(&self, index: usize) -> String {
        format!("{index}:{}:{}", self.constraint.kind().name(), self.label())
    }

    /// The state of a constraint whose nodes, in their order, are there, and how the first turned against the second.
    pub(super) fn place(nodes: &[Moved]) -> (State<f64>, Turning<f64>) {
        let still = Moved::still();
        let node = |place: usize| nodes.get(place).unwrap_or(&still);
        let (slave, master) = (node(0), node(1));
        let hinges = [node(2), node(3)];
        let body =
            |node: &Moved| Body { displacement: node.displacement, rotation: node.rotation, flow: node.flow };
        let combined = |of: fn(&Moved) -> &[f64; 7]| -> Dofs<f64> {
            let mut combined = [0.0; DOFS];
            combined[..7].copy_from_slice(of(slave));
            combined[7..PHI].copy_from_slice(of(master));
            for (entry, hinge) in combined[PHI..].iter_mut().zip(hinges) {
                *entry = of(hinge)[5];
            }
            combined
        };
        let state = State {
            slave: body(slave),
            master: body(master),
            angles: hinges.map(|hinge| hinge.sixth),
            velocity: combined(|node| &node.rates),
            acceleration: combined(|node| &node.accelerations),
        };
        let whole = sub(slave.whole_turns, master.whole_turns);
        let turning = Turning { whole, rest: sub(sub(slave.change, master.change), whole) };
        (state, turning)
    }

    /// Evaluates it with its nodes, in their order, where they are, after angles of hinges that were `before`.
    pub(super) fn evaluate(
        &self,
        index: usize,
        nodes: &[Moved],
        before: &[Turns<f64>; 2],
        (request, schedule, scene_state): (&Request, &Schedule, &SceneState),
        tally: &mut Tally,
    ) -> MpcResult {
        let (state, turning) = Self::place(nodes);
        let constraint = &self.constraint;
        let given = if scene_state.mpc_forces.is_empty() {
            None
        } else {
            scene_state.mpc_forces.get(&self.label()).map(|given| given_forces(self, given))
        };
        let (given, refused) = match given {
            Some(Err((code, ..))) => (None, Some(Flag::refused(code.as_str()))),
            Some(Ok(given)) => (Some(given), None),
            None => (None, None),
        };
        let of_forces: Vec<Output> = request.outputs().filter(|output| asks_for_forces(*output)).collect();
        let given = given.filter(|_| !of_forces.is_empty());
        // Whatever is asked of forces takes all of them.
        let missing = given.into_iter().flat_map(|given| (0..6).filter(move |k| given[*k].is_none()));
        let of_forces = &of_forces;
        let unknown = missing.flat_map(|k| {
            let flag = move |output: &Output| Flag::NotKnown {
                component: FORCE[k],
                quantity: output.name(),
                why: NOT_GIVEN,
            };
            of_forces.iter().map(flag)
        });
        let given = given.and_then(on_first_node);
        let needed = given.map(|_| {
            let mut needed = request.clone();
            needed.order = request.order.max(order(request));
            needed
        });
        let mut evaluation =
            constraint.evaluate(&state, before, &turning, needed.as_ref().unwrap_or(request), tally);
        let mut flags = constraint.flags(&state, before, &turning, &evaluation);
        if let [slave, master, ..] = nodes
            && self.nodes.len() > 2
        {
            flags.extend(ambiguous_turns([("S", slave), ("M", master)]));
        }
        flags.extend(refused.into_iter().chain(unknown));
        let margins = constraint.margins(&state, &evaluation);
        let misalignment = constraint.misalignment(&state);
        let moments = [0, 1].map(|i| {
            let turns = evaluation.angles[i];
            let angle = state.angles[i].unwrap_or_else(|| f64::with_turns(turns.principal, turns.turns));
            let implied = evaluation.angle_rates.map(|rates| rates[i][0]);
            let rate = state.angles[i].map(|_| state.velocity[PHI + i]).or(implied);
            (!self.ground[i].is_empty()).then(|| moments(&self.ground[i], angle, rate))
        });
        let forces = given
            .map(|given| MpcForces::of(self, (&state, &evaluation), &given, &moments, request, &mut flags));
        let (slopes, lacks) = if forces.is_some() { (None, None) } else { MpcSlopes::of(&moments, request) };
        flags.extend(lacks);
        let transmitted = on_hinges(forces.as_ref());
        let kind = constraint.kind();
        let hinges = [0, 1].map(|i| {
            let name = kind.entry().angles.get(i)?;
            let turns = evaluation.angles[i];
            let position = state.angles[i].unwrap_or_else(|| f64::with_turns(turns.principal, turns.turns));
            let implied = evaluation.angle_rates.map(|rates| rates[i]);
            let [rate, second] = [&state.velocity, &state.acceleration].map(|of| of[PHI + i]);
            let rates = state.angles[i].map_or(implied, |_| Some([rate, second]));
            let angle = [Some(position), rates.map(|rates| rates[0]), rates.map(|rates| rates[1])];
            let at = (schedule, scene_state.time);
            let hinge = Hinge::at(&self.drives[i], at, angle, moments[i], transmitted[i]);
            let by = hinge.out_of_balance(moments[i]);
            flags.extend(by.map(|by| Flag::OutOfBalance { component: name, by }));
            Some(hinge)
        });
        if request.order < 2 {
            evaluation.hessian = Default::default();
        }
        if request.order < 1 {
            evaluation.jacobian = Default::default();
        }
        MpcResult {
            index,
            state,
            turning,
            before: *before,
            given: state.angles,
            evaluation,
            misalignment,
            moments,
            hinges,
            forces: forces.map(Box::new),
            slopes: slopes.map(Box::new),
            margins,
            flags,
        }
    }
}

/// Whether an output tells what a constraint transmits.
const fn asks_for_forces(output: Output) -> bool {
    output.is_nodal() || matches!(output, Output::LM | Output::CTF | Output::CRF)
}

/// Puts what is prescribed for degree of freedom 6 on the hinges of which that is the angle, and gives the nodes of those hinges.
///
/// # Errors
/// An amplitude that cannot be read.
pub(super) fn drive(
    scene: &Scene,
    schedule: &Schedule,
    elements: &mut [(MpcElement, Span)],
) -> Result<(), Diagnostic> {
    let angles = |element: &MpcElement| element.constraint.kind().entry().angles.len();
    let hinged: LabelSet = elements
        .iter()
        .flat_map(|(element, _)| element.nodes.iter().skip(2).take(angles(element)))
        .copied()
        .collect();
    if hinged.is_empty() {
        return Ok(());
    }
    let named = |target: &Target| -> Vec<Label> {
        let nodes: &[Label] = match target {
            Target::Label(label) => std::slice::from_ref(label),
            Target::Set(name) => scene.node_sets.get(name.as_str()).map_or(&[], |set| set.labels.as_slice()),
        };
        nodes.iter().copied().filter(|node| hinged.contains(node)).collect()
    };
    let drives = on_angles(scene, schedule, named).map_err(|error| error.in_file(&scene.name))?;
    for (element, _) in elements {
        let count = angles(element);
        for place in 0..count {
            let found = element.nodes.get(2 + place).and_then(|node| drives.get(node));
            if let (Some(found), Some(own)) = (found, element.drives.get_mut(place)) {
                own.clone_from(found);
            }
        }
    }
    Ok(())
}
