//! `pintle check --fit-convention`.

use super::states::deck;
use super::subject::Subject;
use super::{Failure, page_width};
use pintle_check::fit::{Found, fit, generic_states};
use pintle_kinematics::connector::{Definition, State};
use pintle_kinematics::node::{DOFS, Node, Pair};
use pintle_kinematics::so3;
use pintle_kinematics::vector::product;
use pintle_report::wrap;
use pintle_scene::{NodeMotion, Rotation, Scene, StateFile};
use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::Path;

/// The most wrong entries that are shown.
const SHOWN: usize = 8;

/// The conventions of rows that a harness computed at the states of a file.
pub(crate) fn of_files(
    subject: &Subject,
    scene: Option<&Scene>,
    at: &Path,
    answers: &Path,
) -> Result<Found, Failure> {
    let definition = &subject.definition;
    let of_type = match scene {
        Some(_) => None,
        None => Some(Scene::parse("type.inp", &deck(definition))?),
    };
    let scene = scene.or(of_type.as_ref()).ok_or_else(|| Failure::Usage("there is no scene".into()))?;
    let states: Vec<State<f64>> =
        StateFile::read(at, scene)?.states.iter().map(|state| state_of(subject, state)).collect();
    let named = |why: String| Failure::Input(format!("{}: {why}", answers.display()));
    let text = std::fs::read_to_string(answers).map_err(|error| named(error.to_string()))?;
    let given = pintle_check::answers_of_file(&text, states.len()).map_err(named)?;
    fit(definition, &states, &given).map_err(|why| Failure::Input(format!("{}: {why}", answers.display())))
}

/// The pair of a connector at a state of a file.
fn state_of(subject: &Subject, state: &pintle_scene::State) -> State<f64> {
    let Definition { initial, .. } = &subject.definition;
    let mut rates = [[0.0; DOFS]; 2];
    let [a, b] = [(0, initial.a), (1, initial.b)].map(|(end, first): (usize, Node<f64>)| {
        let motion =
            subject.nodes[end].and_then(|label| state.nodes.get(&label)).copied().unwrap_or_default();
        let NodeMotion { displacement, rotation, flow, .. } = motion;
        let turned = match rotation {
            Rotation::Vector(vector) => so3::turn(vector),
            Rotation::Quaternion(quaternion) => so3::matrix(quaternion),
        };
        for i in 0..3 {
            let at = 7 * end + i;
            [rates[0][at], rates[0][at + 3]] = [motion.velocity[i], motion.angular_velocity[i]];
            [rates[1][at], rates[1][at + 3]] = [motion.acceleration[i], motion.angular_acceleration[i]];
        }
        [rates[0][7 * end + 6], rates[1][7 * end + 6]] = [motion.flow_velocity, motion.flow_acceleration];
        Node { displacement, triad: product(&turned, &first.triad), flow }
    });
    let [velocity, acceleration] = rates;
    State { pair: Pair { a, b, ..*initial }, velocity, acceleration }
}

/// Says what was found: the convention in words and as TOML, what is left open, what is wrong under it.
pub(crate) fn tell(found: &Found, definition: &Definition) -> Result<(), Failure> {
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
        let others = generic_states(definition, "separating", 4);
        match found.separating(definition, &others) {
            Some(best) => {
                text.push_str("\nA state that tells them apart (as pintle states --format csv writes it):\n");
                text.push_str(&separating(definition, &others[best]));
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

/// One state as a table.
fn separating(definition: &Definition, state: &State<f64>) -> String {
    let mut text = "state,node,u1,u2,u3,q0,q1,q2,q3\n".to_string();
    let ends = [(&state.pair.a, &definition.initial.a), (&state.pair.b, &definition.initial.b)];
    for (n, (now, first)) in ends.into_iter().enumerate() {
        let transposed = pintle_kinematics::vector::transpose(&first.triad);
        let quaternion = so3::quaternion(&product(&now.triad, &transposed));
        let _ = write!(text, "0,{}", n + 1);
        for x in now.displacement.into_iter().chain(quaternion) {
            let _ = write!(text, ",{x:?}");
        }
        text.push('\n');
    }
    text
}
