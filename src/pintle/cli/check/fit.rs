//! `pintle check --fit-convention`.

use crate::cli::compare::any_states;
use crate::cli::states::deck;
use crate::cli::subject::Subject;
use crate::cli::{Failure, page_width};
use pintle_audit::Domain;
use pintle_check::fit::{Found, fit, generic_cases, generic_states};
use pintle_kinematics::connector::{Definition, State};
use pintle_kinematics::mpc::Constraint;
use pintle_kinematics::node::{DOFS, Node, Pair};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Matrix, Vector, cross, product, transpose};
use pintle_report::wrap;
use pintle_scene::{Label, NodeMotion, Scene};
use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::Path;

/// The most wrong entries that are shown.
const SHOWN: usize = 8;

/// What rows are of.
#[derive(Clone, Copy)]
pub(crate) enum Of<'a> {
    /// A connector, between nodes of a scene, in a domain.
    Connector(&'a Definition, [Option<Label>; 2], Option<&'a Domain>),
    /// A multi-point constraint.
    Constraint(&'a Constraint<f64>),
}

/// The conventions of rows that a harness computed at the states of a file.
pub(crate) fn of_files(
    subject: &Subject,
    scene: Option<&Scene>,
    at: &Path,
    answers: &Path,
) -> Result<(Found, Vec<String>), Failure> {
    let definition = &subject.definition;
    let of_type = match scene {
        Some(_) => None,
        None => Some(Scene::parse("type.inp", &deck(definition))?),
    };
    let scene = scene.or(of_type.as_ref()).ok_or_else(|| Failure::Usage("there is no scene".into()))?;
    let states: Vec<State<f64>> =
        any_states(at, scene)?.iter().map(|state| state_of(subject, state)).collect();
    let named = |why: String| Failure::Input(format!("{}: {why}", answers.display()));
    let text = std::fs::read_to_string(answers).map_err(|error| named(error.to_string()))?;
    let given = pintle_check::answers_of_file(&text, states.len()).map_err(named)?;
    let found = fit(definition, &states, &given)
        .map_err(|why| Failure::Input(format!("{}: {why}", answers.display())))?;
    let gaps = if found.count > 1 { gaps(subject, &states) } else { Vec::new() };
    Ok((found, gaps))
}

/// What states cannot tell, and what to print to close it.
fn gaps(subject: &Subject, states: &[State<f64>]) -> Vec<String> {
    let initial = &subject.definition.initial;
    let mut found = Vec::new();
    let mut vectors: Vec<Vector<f64>> = Vec::new();
    for (end, first) in
        [initial.a, initial.b].iter().enumerate().filter(|(end, _)| subject.nodes[*end].is_some())
    {
        let of = |state: &State<f64>| if end == 0 { state.pair.a } else { state.pair.b };
        let turned: Vec<Vector<f64>> = states
            .iter()
            .map(|state| so3::log(&product(&of(state).triad, &transpose(&first.triad))))
            .collect();
        if turned.iter().all(|vector| norm(*vector) == 0.0) {
            let node = subject.nodes[end].map_or_else(String::new, |label| label.to_string());
            found.push(format!(
                "The states have no rotation of node {node}, which tells frames and variations apart. Abaqus prints it by:\n    *NODE PRINT\n    U, UR"
            ));
        }
        vectors.extend(turned.into_iter().filter(|vector| norm(*vector) > 0.0));
    }
    let is_parallel =
        |vector: &Vector<f64>| norm(cross(*vector, vectors[0])) <= 1e-9 * norm(*vector) * norm(vectors[0]);
    if !vectors.is_empty() && vectors.iter().all(is_parallel) {
        found.push(
            "Every node turns about one axis, as in the plane: no output tells variations of rotations apart there. Take a motion in space."
                .into(),
        );
    }
    found
}

/// The pair of a connector at a state of a file.
fn state_of(subject: &Subject, state: &pintle_scene::State) -> State<f64> {
    let Definition { initial, .. } = &subject.definition;
    let mut rates = [[0.0; DOFS]; 2];
    let [a, b] = [(0, initial.a), (1, initial.b)].map(|(end, first): (usize, Node<f64>)| {
        let motion =
            subject.nodes[end].and_then(|label| state.nodes.get(&label)).copied().unwrap_or_default();
        let NodeMotion { displacement, rotation, flow, .. } = motion;
        for i in 0..3 {
            let at = 7 * end + i;
            [rates[0][at], rates[0][at + 3]] = [motion.velocity[i], motion.angular_velocity[i]];
            [rates[1][at], rates[1][at + 3]] = [motion.acceleration[i], motion.angular_acceleration[i]];
        }
        [rates[0][7 * end + 6], rates[1][7 * end + 6]] = [motion.flow_velocity, motion.flow_acceleration];
        Node { displacement, triad: product(&rotation.matrix(), &first.triad), flow }
    });
    let [velocity, acceleration] = rates;
    State { pair: Pair { a, b, ..*initial }, velocity, acceleration }
}

/// Says what was found: the convention in words and as TOML, what is left open, what is wrong under it.
pub(crate) fn tell(found: &Found, of: Of<'_>, gaps: &[String]) -> Result<(), Failure> {
    let width = page_width(&io::stdout());
    let mut text = String::new();
    let line = |text: &mut String, words: &str| {
        for line in wrap(words, width) {
            text.push_str(&line);
            text.push('\n');
        }
    };
    let plural = |count: usize, one: &str, many: &str| {
        if count == 1 { format!("1 {one}") } else { format!("{count} {many}") }
    };
    let head = match (found.count, found.is_cut) {
        (0, _) => {
            let wrong = plural(found.wrong.len(), "number is wrong", "numbers are wrong");
            format!("Under no convention is every number right. Under the nearest, {wrong}.")
        }
        (1, _) => "One convention makes every number right.".to_string(),
        (count, false) => {
            format!("{count} conventions make every number right: the states do not tell them apart.")
        }
        (count, true) => {
            format!("More than {count} conventions make every number right: the states tell little.")
        }
    };
    line(&mut text, &head);
    line(&mut text, &found.sentence());
    let toml = found.convention.to_toml();
    if !toml.is_empty() {
        text.push_str("\n# convention.toml, for --convention\n");
        text.push_str(&toml);
    }
    for wrong in found.wrong.iter().take(SHOWN) {
        let _ = writeln!(text, "\nwrong: {} at state {}", wrong.name, wrong.state);
        let _ =
            writeln!(text, "  got {:?}, want {:?} in the conventions of the routine", wrong.got, wrong.want);
        if let Some(cause) = cause(wrong.got, wrong.want) {
            let _ = writeln!(text, "  {cause}");
        }
    }
    if found.wrong.len() > SHOWN {
        let _ = writeln!(text, "\n… and {} more", found.wrong.len() - SHOWN);
    }
    if !found.open.is_empty() {
        text.push('\n');
        line(&mut text, "Left open, with every answer that fits:");
        for (question, answers) in &found.open {
            line(&mut text, &format!("  {question}: {}", answers.join(" | ")));
        }
        for gap in gaps {
            let mut lines = gap.lines();
            lines.by_ref().take(1).for_each(|words| line(&mut text, words));
            lines.for_each(|literal| text.push_str(&format!("{literal}\n")));
        }
        match separating(found, of) {
            Some(state) => {
                text.push_str("\nA state that tells them apart (as pintle states --format csv writes it):\n");
                text.push_str(&state);
            }
            None => {
                line(&mut text, "No state that was tried tells them apart: for this connector they are one.")
            }
        }
    }
    Ok(anstream::stdout().lock().write_all(text.as_bytes())?)
}

/// What is wrong with one number, where it is simple.
fn cause(got: f64, want: f64) -> Option<String> {
    if got == 0.0 {
        return Some("the entry is missing".to_string());
    }
    if want == 0.0 {
        return Some("the entry must be zero".to_string());
    }
    let ratio = got / want;
    if (ratio + 1.0).abs() < 1e-9 {
        return Some("the entry has the opposite sign".to_string());
    }
    Some(format!("the entry is {ratio:.6} times what it must be"))
}

/// A state that tells most conventions apart, as a table.
fn separating(found: &Found, of: Of<'_>) -> Option<String> {
    const TRIED: usize = 4;
    let mut text = "state,node,u1,u2,u3,q0,q1,q2,q3\n".to_string();
    let mut line = |node: &str, displacement: Vector<f64>, rotation: &Matrix<f64>| {
        let _ = write!(text, "0,{node}");
        for x in displacement.into_iter().chain(so3::quaternion(rotation)) {
            let _ = write!(text, ",{x:?}");
        }
        text.push('\n');
    };
    match of {
        Of::Connector(definition, nodes, domain) => {
            let domain = domain.cloned().unwrap_or_default();
            let others = generic_states(definition, "separating", TRIED, &domain);
            let state = &others[found.separating(definition, &others)?];
            let initial = &definition.initial;
            let ends = [(&state.pair.a, &initial.a), (&state.pair.b, &initial.b)];
            for ((now, first), label) in ends.into_iter().zip(nodes) {
                // What is on the ground does not move.
                if let Some(label) = label {
                    line(
                        &label.to_string(),
                        now.displacement,
                        &product(&now.triad, &transpose(&first.triad)),
                    );
                }
            }
        }
        Of::Constraint(constraint) => {
            let others = generic_cases(constraint, "separating", TRIED);
            let state = &others[found.separating_case(&others)?].state;
            for (name, body) in [("S", &state.slave), ("M", &state.master)] {
                line(name, body.displacement, &body.rotation);
            }
            for (n, angle) in
                state.angles.iter().flatten().take(constraint.kind().entry().angles.len()).enumerate()
            {
                let _ = writeln!(text, "# degree of freedom 6 of the node of hinge {}: {angle:?}", n + 1);
            }
        }
    }
    Some(text)
}
