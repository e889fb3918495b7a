//! `pintle solve`.

use super::states::csv;
use super::{Failure, Files, eval, tell};
use clap::{Args, ValueEnum};
use pintle_kinematics::scalar::Wide;
use pintle_report::solve as report;
use pintle_scene::{ElementForces, NodeMotion, Rotation, Scene, State, StateFile};
use pintle_solve::{Difference, Ended, Frame, Method, Number, Options, Refusal, Solution, solve};
use std::io::{self, BufWriter, Write};
use std::path::PathBuf;

const HELP: &str = "\
Solves the *DYNAMIC steps of a scene: rigid bodies from *MASS and *ROTARY INERTIA,
joined by its connectors and constraints, under gravity (*DLOAD, GRAV), *CLOAD,
*BOUNDARY with amplitudes, springs, dampers, connector motions and loads. Friction
acts on the connector's own reaction, and sticks rigidly: what sticks does not
creep. It is a reference for small mechanisms, no simulator: no contact search.

Two methods of high order solve it side by side, extrapolation and Gauss
collocation. What they differ by is the error, and digits beyond it are not
printed. --digits 15 computes on doubles, more digits on 237 bits.

The events are listed with their margins: of stick, by how much friction holds
more than it has to, relative; 0 is a tie. κ < 1 proves that the friction forces
are the only ones that fit.

States go to a file that pintle eval, audit and solve --from read.

Examples:
  pintle solve drawer.inp
  pintle solve drawer.inp --every 0.01 -o run.csv
  pintle solve drawer.inp --digits 30 --until 0.5
  pintle solve drawer.inp --from run.csv";

#[derive(Debug, Args)]
#[command(after_long_help = HELP)]
pub(crate) struct Solve {
    /// A scene (.inp, .toml, .json) or gallery:NAME
    #[arg(value_name = "SCENE")]
    scene: String,
    /// When to end [default: the end of the last step]
    #[arg(long, value_name = "TIME", value_parser = super::finite)]
    until: Option<f64>,
    /// Times to record, besides the first, the last and events
    #[arg(long, value_name = "TIME", value_delimiter = ',', value_parser = super::finite)]
    times: Vec<f64>,
    /// Record as often as that
    #[arg(long, value_name = "INTERVAL", value_parser = super::finite)]
    every: Option<f64>,
    /// How many digits to compute: up to 15 on doubles, beyond on 237 bits
    #[arg(long, value_name = "COUNT", default_value_t = 15, value_parser = clap::value_parser!(u8).range(3..=60))]
    digits: u8,
    /// Which method, or both for their difference
    #[arg(long, value_enum, default_value_t)]
    method: Which,
    /// Begin at the last state of this file (.csv or .json)
    #[arg(long, value_name = "FILE")]
    from: Option<PathBuf>,
    /// A file for the states: .csv, or .json with the forces
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// How to write the results
    #[arg(long, value_enum, default_value_t)]
    format: super::PageFormat,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Which {
    /// Extrapolation, with collocation as its witness
    #[default]
    Both,
    /// Extrapolation of the midpoint rule alone
    Extrapolation,
    /// Gauss collocation alone
    Collocation,
}

/// The most times that are recorded.
const MOST_TIMES: f64 = 1e6;

/// Solves a scene and writes the results.
pub(crate) fn run(arguments: &Solve, files: Files) -> Result<(), Failure> {
    files.check(&arguments.output)?;
    let source = eval::source(&arguments.scene)?;
    let (scene, _) = eval::read(source, None)?;
    let from = match &arguments.from {
        None => None,
        Some(file) => StateFile::read(file, &scene)?.states.pop(),
    };
    let digits = usize::from(arguments.digits);
    let mut options = Options {
        until: arguments.until,
        times: arguments.times.clone(),
        from,
        method: match arguments.method {
            Which::Both | Which::Extrapolation => Method::Extrapolation,
            Which::Collocation => Method::Collocation,
        },
        ..Options::default()
    };
    if let Some(every) = arguments.every {
        let end = arguments.until.unwrap_or_else(|| length(&scene));
        if !(every > 0.0 && end / every <= MOST_TIMES) {
            let message = format!("--every {every} is not positive, or gives more than {MOST_TIMES:e} times");
            return Err(Failure::Usage(message));
        }
        options.times.extend((1..=(end / every) as usize).map(|i| i as f64 * every));
    }
    if digits <= 15 {
        options.digits = digits.min(14);
        solved::<f64>(arguments, files, &scene, &options)
    } else {
        options.digits = digits + 3;
        solved::<Wide>(arguments, files, &scene, &options)
    }
}

/// The time at which the steps of a scene end, as far as it is known.
fn length(scene: &Scene) -> f64 {
    let schedule = pintle_model::behavior::drive::Schedule::new(scene);
    let last = schedule.len().checked_sub(1).and_then(|last| schedule.span(last));
    last.map_or(0.0, |([_, end], _)| end)
}

fn solved<R: Number>(
    arguments: &Solve,
    files: Files,
    scene: &Scene,
    options: &Options,
) -> Result<(), Failure> {
    let witness = Options { method: Method::Collocation, ..options.clone() };
    let (one, other) = match arguments.method {
        Which::Both => {
            let (one, other) = rayon::join(|| solve::<R>(scene, options), || solve::<R>(scene, &witness));
            (one, Some(other))
        }
        Which::Extrapolation | Which::Collocation => (solve::<R>(scene, options), None),
    };
    let (solution, ended) = match one {
        Ok(solution) => (solution, None),
        Err(ended) => {
            let Ended { solution, time, why } = *ended;
            if solution.frames.is_empty() {
                return Err(match why {
                    Refusal::Scene(diagnostic) => Failure::Scene(diagnostic),
                    Refusal::Of { .. } => Failure::Input(told(&why)),
                });
            }
            (solution, Some((time, told(&why))))
        }
    };
    let length = size(scene);
    let difference: Option<Difference> = other.map(|other| {
        let other = other.unwrap_or_else(|ended| ended.solution);
        solution.difference(&other, length)
    });
    let why = ended.as_ref().map(|(time, why)| format!("at {time}: {why}"));
    let facts = report::Facts {
        scene: &scene.name,
        digits: usize::from(arguments.digits),
        difference: difference.as_ref(),
        ended: why.as_deref(),
    };
    match arguments.format {
        super::PageFormat::Human => {
            let mut out = BufWriter::new(anstream::stdout().lock());
            report::human(&mut out, &solution, facts, super::page_width(&io::stdout()))?;
            out.flush()?;
        }
        super::PageFormat::Json => {
            let mut out = BufWriter::new(io::stdout().lock());
            report::json(&mut out, &solution, facts)?;
            out.flush()?;
        }
    }
    if let Some(file) = &arguments.output {
        let states: Vec<State> =
            solution.frames.iter().enumerate().map(|(n, frame)| state(n, frame, &solution)).collect();
        let is_json = file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("json"));
        let text = if is_json {
            StateFile { states }.to_json().map_err(io::Error::from)? + "\n"
        } else {
            csv(&states)
        };
        files.text(file, text)?;
    }
    if let Some(difference) = &difference
        && !difference.same_events
    {
        tell::complain("warning", "the two methods find other events: none of the digits is certain");
        return Err(Failure::Undecided);
    }
    match why {
        None => Ok(()),
        Some(_) => Err(Failure::Undecided),
    }
}

fn told(why: &Refusal) -> String {
    match why {
        Refusal::Scene(diagnostic) => diagnostic.to_string(),
        Refusal::Of { what, why, remedy } => format!("{what}: {why}\n  help: {remedy}"),
    }
}

/// The size of lengths.
fn size(scene: &Scene) -> f64 {
    pintle_model::evaluate::Model::compile(scene).map_or(1.0, |model| model.length)
}

/// A frame as a state.
fn state<R: Number>(number: usize, frame: &Frame<R>, solution: &Solution<R>) -> State {
    let three = |all: &[R]| -> [f64; 3] {
        let mut found = [0.0; 3];
        found.iter_mut().zip(all).for_each(|(x, from)| *x = from.to_f64());
        found
    };
    let nodes = solution.nodes.iter().zip(&frame.nodes).map(|(label, node)| {
        let motion = NodeMotion {
            displacement: three(&node.displacement),
            rotation: Rotation::Vector(three(&node.rotation)),
            velocity: three(&node.velocity[..3]),
            angular_velocity: three(&node.velocity[3..]),
            acceleration: three(&node.acceleration[..3]),
            angular_acceleration: three(&node.acceleration[3..]),
            ..NodeMotion::default()
        };
        (*label, motion)
    });
    let forces = solution.connectors.iter().zip(&frame.connectors).map(|((label, _), of)| {
        let mut forces = ElementForces::default();
        for k in (0..6).filter(|k| of.wanted[*k]) {
            forces.total[k] = Some(of.total[k].to_f64());
        }
        (*label, forces)
    });
    State {
        number: Some(number as u64),
        time: Some(frame.time.to_f64()),
        nodes: nodes.collect(),
        forces: forces.collect(),
        ..State::default()
    }
}
