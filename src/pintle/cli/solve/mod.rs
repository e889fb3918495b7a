//! `pintle solve`.

mod arrays;
mod kept;

use self::kept::Book;
use super::output::npz::npz;
use super::reference::{length, reference, told};
use super::states::csv;
use super::{Failure, Files, eval, tell};
use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use pintle_kinematics::scalar::Wide;
use pintle_model::evaluate::Model;
use pintle_report::solve as report;
use pintle_scene::{ElementForces, NodeMotion, Rotation, Scene, State, StateFile};
use pintle_solve::{
    Difference, Ended, Frame, Method, Number, Options, Refusal, Solution, Solvable, Stick, estimate, solve,
    solve_keeping,
};
use std::io::{self, BufWriter, IsTerminal, Write};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

const HELP: &str = "\
Solves the *DYNAMIC and *STATIC steps of a scene: rigid bodies from *MASS and *ROTARY INERTIA,
joined by its connectors and constraints, under gravity (*DLOAD, GRAV), *CLOAD,
*BOUNDARY with amplitudes, springs, dampers, connector motions and loads, from
*INITIAL CONDITIONS, TYPE=VELOCITY. Friction acts on the connector's own reaction,
and sticks rigidly: what sticks does not creep. Stops and locks are rigid, and what
runs into them loses its velocity there (a plastic impact). It is a reference for small mechanisms, no simulator: no contact search.

Two methods of high order solve it side by side, extrapolation and Gauss
collocation. What they differ by is the error, on doubles three times that, and
digits beyond it are not printed. --digits 15 computes on doubles, more digits on 237 bits.

The events are listed with their margins: of stick, by how much friction holds
more than it has to, relative; 0 is a tie. Where something passes a limit in its
course, a limit off by a part ε moves the event by ε/margin of the duration.
κ < 1 proves that the friction forces are the only ones that fit.

States go to a file that pintle eval, audit and solve --from read.

A run of --keep FILE writes where it is to FILE, twice a second. What was killed
goes on with --resume FILE and the same options, to the same digits.

Examples:
  pintle solve gallery:drawer
  pintle solve drawer.inp --every 0.01 -o run.csv
  pintle solve drawer.inp --digits 30 --until 0.5
  pintle solve drawer.inp --from run.csv
  pintle solve drawer.inp --html drawer.html
  pintle solve drawer.inp --digits 60 --keep drawer.run";

#[derive(Debug, Args)]
#[command(after_long_help = HELP)]
pub(crate) struct Solve {
    /// A scene (.inp, .toml, .json), gallery:NAME, or references/NAME
    #[arg(value_name = "SCENE")]
    scene: String,
    /// When to end [default: the end of the last step]
    #[arg(long, value_name = "TIME", value_parser = super::finite)]
    until: Option<f64>,
    /// End with this step, from 1
    #[arg(long, value_name = "STEP", conflicts_with = "until", value_parser = clap::value_parser!(u32).range(1..))]
    step: Option<u32>,
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
    /// What stick is: rigid, or a spring of the stick stiffness
    #[arg(long, value_enum, default_value_t)]
    stick: How,
    /// Begin at the last state of this file (.csv or .json)
    #[arg(long, value_name = "FILE")]
    from: Option<PathBuf>,
    /// A file for the states: .csv, .json with the forces, or .npz with all arrays
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// A page with the motion, forces, energies and events; 240 times are recorded for it, unless others are given
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Keep the run in this file as it goes
    #[arg(long, value_name = "FILE", conflicts_with = "resume")]
    keep: Option<PathBuf>,
    /// Go on with the run that this file keeps, and keep it there
    #[arg(long, value_name = "FILE", conflicts_with = "from")]
    resume: Option<PathBuf>,
    /// How to write the results
    #[arg(long, value_enum, default_value_t)]
    format: super::PageFormat,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum How {
    /// What sticks stands still
    #[default]
    Rigid,
    /// A spring holds it, as in finite-element programs
    Elastic,
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
    files.check(arguments.output.iter().chain(&arguments.html).chain(&arguments.keep))?;
    let scene = scene(&arguments.scene)?;
    let from = match &arguments.from {
        None => None,
        Some(file) => StateFile::read(file, &scene)?.states.pop(),
    };
    let digits = usize::from(arguments.digits);
    let until = match arguments.step {
        None => arguments.until,
        Some(step) => Some(end_of_step(&scene, step)?),
    };
    let mut options = Options {
        until,
        times: arguments.times.clone(),
        from,
        stick: match arguments.stick {
            How::Rigid => Stick::Rigid,
            How::Elastic => Stick::Elastic,
        },
        method: match arguments.method {
            Which::Both | Which::Extrapolation => Method::Extrapolation,
            Which::Collocation => Method::Collocation,
        },
        ..Options::default()
    };
    let end = until.unwrap_or_else(|| length(&scene));
    if arguments.html.is_some() && arguments.every.is_none() && arguments.times.is_empty() {
        const FRAMES: u32 = 240;
        options.times.extend((1..FRAMES).map(|i| end * f64::from(i) / f64::from(FRAMES)));
    }
    if let Some(every) = arguments.every {
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

/// When a step ends, by its number from 1.
fn end_of_step(scene: &Scene, step: u32) -> Result<f64, Failure> {
    let schedule = pintle_model::behavior::drive::Schedule::new(scene);
    let span = schedule.span(step as usize - 1);
    span.map(|([_, end], _)| end).ok_or_else(|| {
        Failure::Usage(format!(
            "there is no step {step}: {} has {} with a known length",
            scene.name,
            schedule.len()
        ))
    })
}

/// The scene of a file, of the gallery, or of `references/`.
fn scene(name: &str) -> Result<Scene, Failure> {
    match reference(name) {
        Some(scene) => scene,
        None => Ok(eval::read(eval::source(name)?, None)?.0),
    }
}

/// A bar that shows the time reached, on a terminal, until it is dropped.
struct Bar {
    is_done: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Bar {
    fn new(scene: &str, reached: Arc<AtomicU64>, end: f64) -> Self {
        let is_done = Arc::new(AtomicBool::new(false));
        let (scene, done) = (scene.to_string(), Arc::clone(&is_done));
        let draw = move || {
            // Nothing is drawn for what takes less than a second.
            let mut waits = 10;
            let mut bar: Option<ProgressBar> = None;
            while !done.load(Ordering::Relaxed) {
                std::thread::sleep(Duration::from_millis(100));
                waits -= 1;
                let time = f64::from_bits(reached.load(Ordering::Relaxed));
                if waits <= 0 && end > 0.0 {
                    let bar = bar.get_or_insert_with(|| {
                        let bar = ProgressBar::new(1000);
                        if let Ok(style) =
                            ProgressStyle::with_template("{prefix} {bar:30} t = {msg} {elapsed}")
                        {
                            bar.set_style(style);
                        }
                        bar.set_prefix(scene.clone());
                        bar
                    });
                    bar.set_position((1000.0 * time / end) as u64);
                    bar.set_message(format!("{time:.6} of {end}"));
                }
            }
            if let Some(bar) = bar {
                bar.finish_and_clear();
            }
        };
        let thread = io::stderr().is_terminal().then(|| std::thread::spawn(draw));
        Self { is_done, thread }
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.is_done.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            _ = thread.join();
        }
    }
}

fn solved<R: Solvable>(
    arguments: &Solve,
    files: Files,
    scene: &Scene,
    options: &Options,
) -> Result<(), Failure> {
    let reached = Arc::new(AtomicU64::new(0));
    let options = &Options { reached: Some(Arc::clone(&reached)), ..options.clone() };
    let bar = Bar::new(&scene.name, reached, options.until.unwrap_or_else(|| length(scene)));
    let witness = Options { method: Method::Collocation, ..options.clone() };
    let path = arguments.keep.as_ref().or(arguments.resume.as_ref());
    let is_there = arguments.resume.is_some();
    let book = path.map(|path| Book::open(path, is_there, scene, options)).transpose()?;
    let from = |method: usize| book.as_ref().map_or(Ok(None), |book| book.from(method));
    let (first, second) = (from(0)?, from(1)?);
    let run = |options: &Options, from, method| {
        solve_keeping::<R>(scene, options, from, book.as_ref().map(|book| book.keeping(method)))
    };
    let (one, other) = match arguments.method {
        Which::Both => {
            let (one, other) = rayon::join(|| run(options, first, 0), || run(&witness, second, 1));
            (one, Some(other))
        }
        Which::Extrapolation | Which::Collocation => (run(options, first, 0), None),
    };
    drop(bar);
    book.map_or(Ok(()), Book::close)?;
    let (solution, ended) = match one {
        Ok(solution) => (solution, None),
        Err(ended) => {
            let Ended { solution, time, why } = *ended;
            if solution.frames.is_empty() {
                return Err(match why {
                    Refusal::Scene(diagnostic) => Failure::Scene(diagnostic),
                    Refusal::Of { .. } => Failure::Input(format!("{}: {}", scene.name, told(&why))),
                });
            }
            (solution, Some((time, told(&why))))
        }
    };
    let mut witness_ended = None;
    let difference: Option<Difference> = other.map(|other| {
        let other = other.unwrap_or_else(|other| {
            let Ended { solution, time, why } = *other;
            witness_ended = ended.is_none().then(|| format!("at {time}: {}", told(&why)));
            solution
        });
        let difference = solution.difference(&other);
        match ended.is_some() || witness_ended.is_some() {
            true => difference,
            false => estimate(scene, options, (&solution, difference)),
        }
    });
    // What a spring in the place of stick changes.
    let rigid = (options.stick == Stick::Elastic && ended.is_none())
        .then(|| solve::<R>(scene, &Options { stick: Stick::Rigid, ..options.clone() }).ok())
        .flatten()
        .map(|rigid| rigid.difference(&solution));
    let why = ended.as_ref().map(|(time, why)| format!("at {time}: {why}"));
    let facts = report::Facts {
        scene: &scene.name,
        digits: usize::from(arguments.digits),
        difference: difference.as_ref(),
        rigid: rigid.as_ref(),
        ended: why.as_deref(),
        witness_ended: witness_ended.as_deref(),
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
        let ends_in = |word| file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(word));
        if ends_in("npz") {
            let arrays = arrays::arrays(&solution);
            files.write(file, |out| npz(out, &arrays))?;
        } else if ends_in("json") {
            files.text(file, StateFile { states }.to_json().map_err(io::Error::from)? + "\n")?;
        } else {
            files.text(file, csv(&states))?;
        }
    }
    if let Some(file) = &arguments.html {
        let model = Model::compile(scene)?;
        files.write(file, |out| report::html(out, &solution, (scene, &model), facts))?;
    }
    if let Some(difference) = &difference
        && difference.largest() >= report::NO_DIGIT
    {
        let how = match &witness_ended {
            Some(why) => format!("collocation ended early {why}"),
            None if difference.same_events => "the two methods find events at other times".to_string(),
            None => {
                let when = difference.others_from.map(|when| format!(" from time {when:.6} on"));
                format!("the two methods find other events{}", when.unwrap_or_default())
            }
        };
        tell::complain("warning", &format!("{how}: none of the digits is certain"));
        return Err(Failure::Undecided);
    }
    match why {
        None => Ok(()),
        Some(_) => Err(Failure::Undecided),
    }
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
            flow: node.flow[0].to_f64(),
            flow_velocity: node.flow[1].to_f64(),
            flow_acceleration: node.flow[2].to_f64(),
        };
        (*label, motion)
    });
    let forces = solution.connectors.iter().zip(&frame.connectors).map(|((label, _), of)| {
        let mut forces = ElementForces::default();
        for k in (0..6).filter(|k| of.wanted[*k] && !of.open[*k]) {
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
