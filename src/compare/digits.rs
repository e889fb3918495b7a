//! How many digits a run has, of a reference.

use crate::column::Motion;
use crate::evaluate::Of;
use crate::motion::in_files;
use crate::read::Results;
use pintle_kinematics::connector::Output;
use pintle_report::{table, wrap};
use pintle_scene::Label;
use pintle_solve::{Frame, Number, Solution};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::Path;

/// The most digits that are counted: those of a double.
const MOST: f64 = 16.0;

/// Relative to the largest of its kind, a quantity below this is zero.
const NOTHING: f64 = 1e-12;

/// One quantity of a run beside the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Quantity {
    /// The node or connector.
    pub of: String,
    /// As headings name it.
    pub name: String,
    /// How many numbers were compared.
    pub compared: usize,
    /// −log10 of the largest difference, relative to the largest value of the reference.
    pub digits: f64,
    /// The same of the middle one of all differences.
    pub typical: f64,
    /// The largest difference.
    pub worst: f64,
    /// When.
    pub at: f64,
}

/// The speed of what sticks in the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Creep {
    /// The connector.
    pub of: String,
    /// The component.
    pub name: String,
    /// The largest, in units of the scene.
    pub speed: f64,
    /// In how many frames.
    pub frames: usize,
}

/// Events of a run beside those of the reference.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Events {
    /// How many the reference has.
    pub wanted: usize,
    /// How many the run has.
    pub given: usize,
    /// How many are the same, in their order.
    pub same: usize,
    /// −log10 of the largest difference of their times, relative to the duration.
    pub digits: f64,
    /// The largest difference.
    pub worst: f64,
}

/// What a run has of a reference.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Digits {
    /// Quantities.
    pub quantities: Vec<Quantity>,
    /// What creeps.
    pub creep: Vec<Creep>,
    /// Events, where the run has a list of them.
    pub events: Option<Events>,
    /// Times of the run that the reference does not have.
    pub outside: usize,
    /// What of the run has no counterpart, in words.
    pub left_out: Vec<String>,
}

/// A number of the file: of which node or element, what, how much.
type Entry = (Key, f64);

/// A quantity.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Key {
    Node(String, Motion),
    Connector(String, Output, usize),
}

/// A run, by its times.
#[derive(Clone, Debug, Default)]
pub struct Run {
    frames: Vec<(f64, Vec<Entry>)>,
}

impl Run {
    /// Reads one.
    ///
    /// # Errors
    /// What cannot be read, with file and line; that there are no times.
    pub fn read(results: &Results) -> Result<Self, String> {
        let mut run = Self::default();
        results.each(|frame| {
            let Some(time) = frame.time else {
                return Err(
                    "the run has no times: name a column time, or say in a map which it is".to_string()
                );
            };
            let mut entries = Vec::new();
            for (node, motions) in &frame.nodes {
                entries.extend(motions.iter().map(|(motion, x)| (Key::Node(node.clone(), *motion), x.x)));
            }
            for (element, outputs) in &frame.elements {
                let of = |(output, k, x): &(Output, usize, crate::Printed)| {
                    (Key::Connector(element.clone(), *output, *k), x.x)
                };
                entries.extend(outputs.iter().map(of));
            }
            run.frames.push((time, entries));
            Ok(())
        })?;
        Ok(run)
    }

    /// Its times within a span: when the reference is asked for.
    pub fn times(&self, [from, to]: [f64; 2]) -> Vec<f64> {
        let all = self.frames.iter().map(|(time, _)| *time);
        all.filter(|time| (from..=to).contains(time)).collect()
    }
}

/// An event of a run: when, which connector, what happens.
#[derive(Clone, Debug, PartialEq)]
pub struct Given {
    time: f64,
    connector: String,
    what: String,
}

/// The events of a file: a table with the headings time, connector and event.
///
/// # Errors
/// What cannot be read, with file and line.
pub fn given(path: &Path) -> Result<Vec<Given>, String> {
    let file = path.display();
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_path(path)
        .map_err(|error| format!("{file}: {error}"))?;
    let headings = reader.headers().map_err(|error| format!("{file}: {error}"))?.clone();
    let place = |name: &str| {
        let found = headings.iter().position(|heading| heading.eq_ignore_ascii_case(name));
        found.ok_or_else(|| format!("{file}: no heading {name}; there must be time, connector and event"))
    };
    let [time, connector, event] = ["time", "connector", "event"].map(place);
    let (time, connector, event) = (time?, connector?, event?);
    let mut all = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| format!("{file}: {error}"))?;
        let line = record.position().map_or(0, csv::Position::line);
        let cell = |place: usize| record.get(place).unwrap_or_default();
        let text = cell(time);
        let time = text.parse::<f64>().ok().filter(|time| time.is_finite());
        let time = time.ok_or_else(|| format!("{file}:{line}: the time is {text:?}, not a number"))?;
        all.push(Given {
            time,
            connector: cell(connector).to_ascii_uppercase(),
            what: cell(event).to_ascii_lowercase(),
        });
    }
    Ok(all)
}

/// −log10 of a relative difference, as far as doubles go.
fn count(difference: f64, scale: f64) -> f64 {
    let relative = difference / scale.max(f64::MIN_POSITIVE);
    if relative.is_nan() { 0.0 } else { (-relative.log10()).clamp(0.0, MOST) }
}

/// What a run has of a solution at its times.
pub fn digits<R: Number>(solution: &Solution<R>, run: &Run, events: Option<&[Given]>) -> Digits {
    let mut found = Digits::default();
    let places = Places::of(solution);
    // What is asked for has a frame of its own time; what an event has is not meant.
    let frames: Vec<(f64, &Frame<R>)> =
        solution.frames.iter().map(|frame| (frame.time.to_f64(), frame)).collect();
    let mut pairs: BTreeMap<Key, Vec<[f64; 3]>> = BTreeMap::new();
    let mut creep: BTreeMap<(String, usize), (f64, usize)> = BTreeMap::new();
    let mut left_out: BTreeMap<String, usize> = BTreeMap::new();
    for (time, entries) in &run.frames {
        let first = frames.partition_point(|(at, _)| at < time);
        let here = || frames.iter().skip(first).take_while(|(at, _)| at == time);
        let Some((_, frame)) = here().find(|(_, frame)| !frame.is_event).or_else(|| here().next()) else {
            found.outside += 1;
            continue;
        };
        for (key, got) in entries {
            let Some(want) = places.wanted(frame, key) else {
                *left_out.entry(key.to_string()).or_default() += 1;
                continue;
            };
            pairs.entry(key.clone()).or_default().push([*time, *got, want]);
            if let Key::Connector(label, Output::CV, k) = key
                && places.is_held(frame, label, *k)
            {
                let most = creep.entry((label.clone(), *k)).or_default();
                *most = (most.0.max(got.abs()), most.1 + 1);
            }
        }
    }
    // A quantity that the reference holds at zero counts in units of its kind.
    let mut largest: BTreeMap<String, f64> = BTreeMap::new();
    for (key, all) in &pairs {
        let most = all.iter().map(|[_, _, want]| want.abs()).fold(0.0, f64::max);
        let known = largest.entry(key.kind()).or_default();
        *known = known.max(most);
    }
    for (key, all) in pairs {
        let own = all.iter().map(|[_, _, want]| want.abs()).fold(0.0, f64::max);
        let of_kind = largest.get(&key.kind()).copied().unwrap_or(0.0);
        let scale = if own > NOTHING * of_kind { own } else { of_kind };
        let scale = if scale > 0.0 { scale } else { 1.0 };
        let mut apart: Vec<(f64, f64)> =
            all.iter().map(|[time, got, want]| ((got - want).abs(), *time)).collect();
        apart.sort_by(|one, two| one.0.total_cmp(&two.0));
        let (worst, at) = apart.last().copied().unwrap_or_default();
        let middle = apart.get(apart.len() / 2).map_or(0.0, |(apart, _)| *apart);
        let (of, name) = key.named(solution);
        found.quantities.push(Quantity {
            of,
            name,
            compared: apart.len(),
            digits: count(worst, scale),
            typical: count(middle, scale),
            worst,
            at,
        });
    }
    for ((label, k), (speed, frames)) in creep {
        let (of, name) = Key::Connector(label, Output::CV, k).named(solution);
        found.creep.push(Creep { of, name, speed, frames });
    }
    found.left_out = left_out.into_iter().map(|(key, count)| format!("{key} ({count} numbers)")).collect();
    found.events = events.map(|events| of_events(solution, events));
    found
}

/// Events in their order: the same connector, the same word.
fn of_events<R: Number>(solution: &Solution<R>, given: &[Given]) -> Events {
    let duration = solution.frames.last().map_or(1.0, |frame| frame.time.to_f64());
    let mut found =
        Events { wanted: solution.events.len(), given: given.len(), digits: MOST, ..Events::default() };
    let mut left: Vec<&Given> = given.iter().collect();
    left.sort_by(|one, two| one.time.total_cmp(&two.time));
    for event in &solution.events {
        let label =
            solution.connectors.get(event.connector).map(|(label, _)| label.to_string().to_ascii_uppercase());
        let word = event.what.name();
        let is_same = |given: &&Given| {
            let title = label.as_ref().is_some_and(|label| {
                given.connector == *label || given.connector.ends_with(&format!(" {label}"))
            });
            title && (given.what == word || word.strip_prefix("stop ") == Some(given.what.as_str()))
        };
        let Some(place) = left.iter().position(is_same) else { continue };
        let apart = (left.remove(place).time - event.time.to_f64()).abs();
        found.same += 1;
        found.worst = found.worst.max(apart);
    }
    found.digits = if found.same == 0 { 0.0 } else { count(found.worst, duration) };
    found
}

impl Key {
    /// What has one size.
    fn kind(&self) -> String {
        match self {
            Self::Node(_, motion) => format!("{:?}", std::mem::discriminant(motion)),
            Self::Connector(_, output, k) => format!("{}{}", output.name(), *k >= 3),
        }
    }

    fn named<R: Number>(&self, solution: &Solution<R>) -> (String, String) {
        match self {
            Self::Node(label, motion) => (format!("node {label}"), name(*motion)),
            Self::Connector(label, output, k) => {
                let mut all = solution.connectors.iter();
                let title = all.find(|(known, _)| known.to_string().eq_ignore_ascii_case(label));
                (
                    title.map_or_else(|| label.clone(), |(_, title)| title.clone()),
                    Of::Output(*output, *k).name(),
                )
            }
        }
    }
}

impl std::fmt::Display for Key {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Node(label, motion) => write!(f, "{} of node {label}", name(*motion)),
            Self::Connector(label, output, k) => {
                write!(f, "{} of connector {label}", Of::Output(*output, *k).name())
            }
        }
    }
}

/// A motion as headings name it.
fn name(motion: Motion) -> String {
    match motion {
        Motion::Displacement(k) => format!("U{}", k + 1),
        Motion::Rotation(k) => format!("UR{}", k + 1),
        Motion::Quaternion(k) => format!("q{k}"),
        Motion::Velocity(k) => format!("V{}", k + 1),
        Motion::AngularVelocity(k) => format!("VR{}", k + 1),
        Motion::Acceleration(k) => format!("A{}", k + 1),
        Motion::AngularAcceleration(k) => format!("AR{}", k + 1),
        Motion::Flow => "FLOW".to_string(),
        Motion::FlowVelocity => "FLOW_VELOCITY".to_string(),
        Motion::FlowAcceleration => "FLOW_ACCELERATION".to_string(),
    }
}

/// The places of nodes and connectors in frames, by the names that files have.
struct Places {
    nodes: BTreeMap<String, usize>,
    connectors: BTreeMap<String, usize>,
}

impl Places {
    fn of<R>(solution: &Solution<R>) -> Self {
        let named = |labels: &mut dyn Iterator<Item = &Label>| {
            labels.enumerate().map(|(place, label)| (in_files(label), place)).collect()
        };
        Self {
            nodes: named(&mut solution.nodes.iter()),
            connectors: named(&mut solution.connectors.iter().map(|(label, _)| label)),
        }
    }

    /// The number of the reference.
    fn wanted<R: Number>(&self, frame: &Frame<R>, key: &Key) -> Option<f64> {
        let found = match key {
            Key::Node(label, motion) => {
                let of = &frame.nodes[*self.nodes.get(label)?];
                match *motion {
                    Motion::Displacement(k) => of.displacement[k],
                    Motion::Rotation(k) => of.rotation[k],
                    Motion::Velocity(k) => of.velocity[k],
                    Motion::AngularVelocity(k) => of.velocity[3 + k],
                    Motion::Acceleration(k) => of.acceleration[k],
                    Motion::AngularAcceleration(k) => of.acceleration[3 + k],
                    Motion::Quaternion(_)
                    | Motion::Flow
                    | Motion::FlowVelocity
                    | Motion::FlowAcceleration => return None,
                }
            }
            Key::Connector(label, output, k) => {
                let of = &frame.connectors[*self.connectors.get(label)?];
                if !of.wanted[*k] && !of.free[*k] {
                    return None;
                }
                match output {
                    Output::CP => of.position[*k],
                    Output::CU => of.displacement[*k],
                    Output::CV => of.velocity[*k],
                    Output::CTF if of.open[*k] => return None,
                    Output::CTF => of.total[*k],
                    Output::CSF if of.open_friction[*k] => return None,
                    Output::CSF => of.friction[*k],
                    _ => return None,
                }
            }
        };
        Some(found.to_f64())
    }

    /// Whether component k sticks: it rests where all frictions of its connector stick.
    fn is_held<R: Number>(&self, frame: &Frame<R>, label: &str, k: usize) -> bool {
        self.connectors.get(label).map(|place| &frame.connectors[*place]).is_some_and(|of| {
            let sticks = !of.sticks.is_empty() && of.sticks.iter().all(|sticks| *sticks);
            sticks && of.friction[k].to_f64() != 0.0
        })
    }
}

impl Digits {
    /// The fewest digits of any quantity.
    pub fn fewest(&self) -> Option<&Quantity> {
        self.quantities.iter().min_by(|one, two| one.digits.total_cmp(&two.digits))
    }

    /// Writes them as text.
    ///
    /// # Errors
    /// Those of the stream.
    pub fn write_human(&self, out: &mut dyn Write, width: usize) -> io::Result<()> {
        let rows: Vec<Vec<String>> = self
            .quantities
            .iter()
            .map(|of| {
                vec![
                    of.of.clone(),
                    of.name.clone(),
                    format!("{:.1}", of.digits),
                    format!("{:.1}", of.typical),
                    format!("{:.1e}", of.worst),
                    format!("{}", of.at),
                    of.compared.to_string(),
                ]
            })
            .collect();
        if !rows.is_empty() {
            let headings = ["", "output", "digits", "typical", "largest difference", "at", "numbers"];
            write!(out, "{}", table(&headings, &rows))?;
        }
        let mut say = |text: &str| -> io::Result<()> {
            wrap(text, width).iter().try_for_each(|line| writeln!(out, "{line}"))
        };
        if let Some(events) = &self.events {
            say(&format!(
                "events: {} of {} are there ({} given), and their times have {:.1} digits: {:.1e} at most",
                events.same, events.wanted, events.given, events.digits, events.worst
            ))?;
        }
        for creep in &self.creep {
            say(&format!(
                "while stuck: {} {} moves with {:.1e} at most, in {} frames",
                creep.of, creep.name, creep.speed, creep.frames
            ))?;
        }
        if self.outside > 0 {
            say(&format!("not compared: {} times outside of the reference", self.outside))?;
        }
        for left in &self.left_out {
            say(&format!("not compared: {left}, which the reference does not have"))?;
        }
        Ok(())
    }
}
