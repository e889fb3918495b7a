//! `pintle states`.

use super::eval::{read, source};
use super::output::npz::{Array, Items, npz};
use super::subject::{Subject, named};
use super::{Failure, Files, compare};
use clap::{Args, ValueEnum};
use pintle_audit::{Candidate, Case, Domain, Settings};
use pintle_kinematics::catalog::Orientation;
use pintle_kinematics::connector::{Definition, State};
use pintle_kinematics::node::Node;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Matrix, product, transpose};
use pintle_scene::{Label, NodeMotion, Rotation, StateFile};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::io::{self, BufWriter, Write};
use std::path::PathBuf;

const HELP: &str = "\
States for a harness of your own: those at which pintle check asks. The first is the
initial one; then come special values, states about the initial one, and as many
as --near says (50 without a number) 1e-1 to 1e-12 from the singular sets of the connector. Each of them
follows the initial state: pintle eval --independent reads them so.

--history gives one history instead, in increments of at most 0.6 rad, through half
a turn and whole ones. pintle eval reads it as it is.

Of a TYPE the nodes are 1 (a) and 2 (b), and --deck writes the deck that goes with
them. Of a connector of a scene they are its nodes.

Examples:
  pintle states REVOLUTE --count 100 --deck revolute.inp > states.csv
  pintle eval revolute.inp --states states.csv --independent --format csv
  pintle states model.inp --from model.dat -o states.csv
  pintle states model.inp:106 --count 500 --history --format json -o history.json
  pintle states REVOLUTE --near 50 --format npz -o states.npz";

#[derive(Debug, Args)]
#[command(after_long_help = HELP)]
pub(crate) struct States {
    /// A connection type, or two basic ones in quotes; or a connector of a scene, SCENE:ELEMENT
    #[arg(value_name = "TYPE|SCENE:ELEMENT")]
    of: String,
    /// The states of a result that another program has written (.dat, or a table with its headings); TYPE is a scene then
    #[arg(long, value_name = "FILE", conflicts_with_all = ["count", "near", "history", "deck"])]
    from: Option<PathBuf>,
    /// How many states
    #[arg(long, value_name = "COUNT", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    count: u32,
    /// How many near the singular sets of the connector, besides
    #[arg(long, value_name = "COUNT", num_args = 0..=1, default_value_t = 0, default_missing_value = "50", conflicts_with = "history")]
    near: u32,
    /// One history, whose states follow one another
    #[arg(long, alias = "histories")]
    history: bool,
    /// Ranges: x1, x2, x3 of b seen from a, along the axes of a; r1, r2, r3 of the rotation of b against a since the initial state (rad)
    #[arg(long, value_name = "x1=LOW:HIGH,…", conflicts_with_all = ["from", "history"], allow_hyphen_values = true)]
    within: Option<Domain>,
    /// What random states are drawn from
    #[arg(long, value_name = "WORD", default_value = "pintle")]
    seed: String,
    /// How to write it
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// A file for the states, in place of the standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// A file for the deck of a TYPE
    #[arg(long, value_name = "FILE")]
    deck: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Format {
    /// A line for each node at each state
    #[default]
    Csv,
    /// One JSON document
    Json,
    /// Arrays of NumPy, by state and node
    Npz,
}

/// Draws states and writes them.
pub(crate) fn run(arguments: &States, files: Files) -> Result<(), Failure> {
    files.check(arguments.output.iter().chain(&arguments.deck))?;
    if let Some(from) = &arguments.from {
        let (scene, _) = read(source(&arguments.of)?, None)?;
        return write(arguments, files, compare::states(from, &scene)?);
    }
    let Subject { definition, nodes, is_of_scene } = named(&arguments.of)?;
    let settings = Settings {
        states: arguments.count as usize,
        near_singular_states: arguments.near as usize,
        seed: arguments.seed.clone(),
        ..Settings::default()
    };
    let domain = arguments.within.clone().unwrap_or_default();
    let candidate =
        Candidate::new(&definition.connection.name, &definition).settings(settings).within(domain);
    let states: Vec<pintle_scene::State> = if arguments.history {
        let Some(case) = candidate.history(arguments.count as usize) else {
            let message = format!(
                "{} has no ends that both turn, or none within --within: there is no history of turns",
                arguments.of
            );
            return Err(Failure::Usage(message));
        };
        let last = case.path.len().saturating_sub(1);
        let rest = case.last().map(|step| step.state);
        let on_the_way = case.path.iter().enumerate().map(|(n, step)| {
            // Rates are drawn for the end alone.
            let state = if n == last { rest.unwrap_or(step.state) } else { step.state };
            written(n, &definition, &nodes, &state)
        });
        on_the_way.collect()
    } else {
        let ends = candidate.drawn();
        let ends = ends.iter().filter_map(Case::last).enumerate();
        ends.map(|(n, step)| written(n, &definition, &nodes, &step.state)).collect()
    };
    if let Some(file) = &arguments.deck {
        if is_of_scene {
            return Err(Failure::Usage("--deck writes the deck of a TYPE; a scene has its own".to_string()));
        }
        files.text(file, deck(&definition))?;
    }
    write(arguments, files, states)
}

/// Writes states where they are wanted.
fn write(arguments: &States, files: Files, states: Vec<pintle_scene::State>) -> Result<(), Failure> {
    let bytes = match arguments.format {
        Format::Csv => csv(&states).into_bytes(),
        Format::Json => (StateFile { states }.to_json().map_err(io::Error::from)? + "\n").into_bytes(),
        Format::Npz => {
            let mut bytes = Vec::new();
            npz(&mut bytes, &arrays(&states))?;
            bytes
        }
    };
    match &arguments.output {
        Some(file) => files.text(file, bytes),
        None => {
            let mut out = BufWriter::new(io::stdout().lock());
            out.write_all(&bytes)?;
            Ok(out.flush()?)
        }
    }
}

/// States as arrays of NumPy: `state`, `time` where there are some, the labels `node`, and of each state and node `u`, `quaternion` (or
/// `rotation_vector`, which keeps its turns), `flow` and their rates.
fn arrays(states: &[pintle_scene::State]) -> Vec<Array> {
    let nodes: BTreeSet<Label> = states.iter().flat_map(|state| state.nodes.keys().copied()).collect();
    let is_vector = holds_vectors(states);
    let motions: Vec<NodeMotion> = states
        .iter()
        .flat_map(|state| nodes.iter().map(|node| state.nodes.get(node).copied().unwrap_or_default()))
        .collect();
    let count = states.len();
    let numbers = states.iter().map(|state| state.number.unwrap_or_default()).collect();
    let mut arrays = vec![Array { name: "state", shape: vec![count], items: Items::Counts(numbers) }];
    if states.iter().any(|state| state.time.is_some()) {
        let times = states.iter().map(|state| state.time.unwrap_or_default()).collect();
        arrays.push(Array::numbers("time", vec![count], times));
    }
    arrays.push(Array::words("node", nodes.iter().map(ToString::to_string).collect()));
    let of = |name, width: usize, part: &dyn Fn(&NodeMotion) -> Vec<f64>| {
        let shape = [count, nodes.len(), width];
        let shape = if width == 1 { &shape[..2] } else { &shape };
        Array::numbers(name, shape.to_vec(), motions.iter().flat_map(part).collect())
    };
    let (name, width) = if is_vector { ("rotation_vector", 3) } else { ("quaternion", 4) };
    arrays.extend([
        of("u", 3, &|motion| motion.displacement.to_vec()),
        of(name, width, &|motion| rotation_of(motion, is_vector)),
        of("flow", 1, &|motion| vec![motion.flow]),
        of("velocity", 3, &|motion| motion.velocity.to_vec()),
        of("angular_velocity", 3, &|motion| motion.angular_velocity.to_vec()),
        of("flow_velocity", 1, &|motion| vec![motion.flow_velocity]),
        of("acceleration", 3, &|motion| motion.acceleration.to_vec()),
        of("angular_acceleration", 3, &|motion| motion.angular_acceleration.to_vec()),
        of("flow_acceleration", 1, &|motion| vec![motion.flow_acceleration]),
    ]);
    arrays
}

/// Whether all rotations are vectors, which keep their turns.
fn holds_vectors(states: &[pintle_scene::State]) -> bool {
    let motions = || states.iter().flat_map(|state| state.nodes.values());
    motions().all(|motion| matches!(motion.rotation, Rotation::Vector(_)))
}

/// The rotation of a node, as a vector where all are.
fn rotation_of(motion: &NodeMotion, is_vector: bool) -> Vec<f64> {
    match motion.rotation {
        Rotation::Quaternion(quaternion) => quaternion.to_vec(),
        Rotation::Vector(vector) if is_vector => vector.to_vec(),
        Rotation::Vector(vector) => so3::exp_quaternion(vector).to_vec(),
    }
}

/// A state as scenes have it: motions of both nodes, those of the ground left out.
fn written(
    number: usize,
    definition: &Definition,
    nodes: &[Option<Label>; 2],
    state: &State<f64>,
) -> pintle_scene::State {
    let initial = &definition.initial;
    let motion = |now: &Node<f64>, first: &Node<f64>, end: usize| {
        let of = |rates: &[f64; 14], at: usize| [0, 1, 2].map(|i| rates[7 * end + at + i]);
        let turned: Matrix<f64> = product(&now.triad, &transpose(&first.triad));
        NodeMotion {
            displacement: now.displacement,
            rotation: Rotation::Quaternion(so3::quaternion(&turned)),
            velocity: of(&state.velocity, 0),
            angular_velocity: of(&state.velocity, 3),
            acceleration: of(&state.acceleration, 0),
            angular_acceleration: of(&state.acceleration, 3),
            flow: now.flow,
            flow_velocity: state.velocity[7 * end + 6],
            flow_acceleration: state.acceleration[7 * end + 6],
        }
    };
    let motions = [motion(&state.pair.a, &initial.a, 0), motion(&state.pair.b, &initial.b, 1)];
    let nodes = nodes.iter().zip(motions).filter_map(|(label, motion)| Some(((*label)?, motion)));
    pintle_scene::State { number: Some(number as u64), nodes: nodes.collect(), ..Default::default() }
}

/// States as a table, with their times where they have some.
pub(crate) fn csv(states: &[pintle_scene::State]) -> String {
    let timed = states.iter().any(|state| state.time.is_some());
    let mut text = String::from(if timed { "state,time," } else { "state," });
    let is_vector = holds_vectors(states);
    text.push_str(if is_vector { "node,u1,u2,u3,ur1,ur2,ur3" } else { "node,u1,u2,u3,q0,q1,q2,q3" });
    text.push_str(",flow,v1,v2,v3,vr1,vr2,vr3,flow_v,a1,a2,a3,ar1,ar2,ar3,flow_a\n");
    for state in states {
        for (node, motion) in &state.nodes {
            let NodeMotion { displacement, velocity, angular_velocity, .. } = motion;
            let NodeMotion {
                acceleration, angular_acceleration, flow, flow_velocity, flow_acceleration, ..
            } = motion;
            let rotation = rotation_of(motion, is_vector);
            let _ = write!(text, "{},", state.number.unwrap_or_default());
            if timed {
                let _ = write!(text, "{:?},", state.time.unwrap_or_default());
            }
            let _ = write!(text, "{node}");
            let columns = displacement.iter().chain(&rotation).chain([flow]);
            let columns = columns.chain(velocity).chain(angular_velocity).chain([flow_velocity]);
            let columns = columns.chain(acceleration).chain(angular_acceleration).chain([flow_acceleration]);
            for x in columns {
                let _ = write!(text, ",{x:?}");
            }
            text.push('\n');
        }
    }
    text
}

/// The deck of one connector: node 1 at the origin, node 2 where the definition has it.
pub(crate) fn deck(definition: &Definition) -> String {
    let Definition { connection, initial, flow_scale, .. } = definition;
    let listed = |numbers: &[f64]| numbers.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(", ");
    // Two points on the first and in the plane of the first two axes.
    let axes = |node: &Node<f64>| {
        let axis = |j: usize| [0, 1, 2].map(|i| node.triad[i][j]);
        listed(&[axis(0), axis(1)].concat())
    };
    let name = connection.name.replace(" + ", ", ");
    let mut text = format!("*HEADING\n {name}: node 1 is a, node 2 is b\n*NODE\n");
    let _ = write!(text, "1, 0., 0., 0.\n2, {}\n", listed(&initial.reference));
    let _ = write!(
        text,
        "*ORIENTATION, NAME=OA\n{}\n*ORIENTATION, NAME=OB\n{}\n",
        axes(&initial.a),
        axes(&initial.b)
    );
    let named = |end: usize, name| match connection.orientation[end].orientation {
        Orientation::Ignored => "",
        _ => name,
    };
    let _ = write!(
        text,
        "*ELEMENT, TYPE=CONN3D2, ELSET=ONE\n1, 1, 2\n*CONNECTOR SECTION, ELSET=ONE\n{name}\n{}, {}\n",
        named(0, "OA"),
        named(1, "OB")
    );
    if connection.positions().any(|measure| measure.is_one_form()) {
        let _ = writeln!(text, "{flow_scale:?}");
    }
    // Both nodes turn, whatever the type.
    text + "*ELEMENT, TYPE=ROTARYI, ELSET=INERTIA\n2, 1\n3, 2\n*ROTARY INERTIA, ELSET=INERTIA\n1., 1., 1.\n"
}
