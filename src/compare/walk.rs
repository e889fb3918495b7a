//! What the connectors must give along the motion that files tell, beside what the files say of them.

use crate::cause::{Alternatives, explain};
use crate::column::{Map, Motion, Nodal, Rotations};
use crate::entries::compare_matrices;
use crate::evaluate::{Evaluator, Key, Known, Of, Why, unit_of};
use crate::judge::{Comparison, Gap, Point, ROUNDINGS, Series, Unjudged};
use crate::motion::Motions;
use crate::read::{Frame, Results};
use pintle_check::Angle;
use pintle_kinematics::connector::Output;
use pintle_model::behavior::state::Velocities;
use pintle_model::evaluate::{Model, Plan, Selection, Sequence};
use pintle_scene::{Scene, State};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;

/// The part of the largest number of an output that may be wrong unseen, without a word.
const COARSE: f64 = 5e-3;

/// How many states beyond which a series that is wrong is taken to be so, without another look at the digits of the motion.
const SURE: u64 = 3;

/// What files hold.
#[derive(Debug, Default)]
struct Survey {
    /// Velocities, accelerations.
    has_rates: [bool; 2],
    has_motion: bool,
    /// The nodes that are told to move, and those that are told to turn.
    moved: BTreeSet<String>,
    turned: BTreeSet<String>,
    has_outputs: bool,
    has_forces: bool,
    /// The most numbers of one frame.
    numbers: usize,
}

impl Survey {
    fn of(results: &Results) -> Result<Self, String> {
        let mut survey = Self::default();
        results.each(|frame| {
            for (node, motions) in &frame.nodes {
                let is = |kinds: fn(&Motion) -> bool| motions.iter().any(|(of, _)| kinds(of));
                if !survey.moved.contains(node) {
                    survey.moved.insert(node.clone());
                }
                let turns = is(|of| matches!(of, Motion::Rotation(_) | Motion::Quaternion(_)));
                if turns && !survey.turned.contains(node) {
                    survey.turned.insert(node.clone());
                }
                survey.has_rates[0] |= is(|of| {
                    matches!(of, Motion::Velocity(_) | Motion::AngularVelocity(_) | Motion::FlowVelocity)
                });
                survey.has_rates[1] |= is(|of| {
                    matches!(
                        of,
                        Motion::Acceleration(_) | Motion::AngularAcceleration(_) | Motion::FlowAcceleration
                    )
                });
            }
            survey.has_motion |= frame.moves;
            survey.has_outputs |= !frame.elements.is_empty();
            survey.has_forces |= !frame.forces.is_empty();
            let numbers = frame.elements.values().map(Vec::len).chain(frame.forces.values().map(Vec::len));
            survey.numbers = survey.numbers.max(numbers.sum());
            Ok(())
        })?;
        Ok(survey)
    }

    /// How many points of a series are kept, so that all take no more than some hundred megabytes.
    fn kept(&self) -> usize {
        (2_000_000 / self.numbers.max(1)).clamp(40, 4_000)
    }
}

/// Compares what files say of the connectors of a scene with what these give along the motion that the files tell.
///
/// Each number may differ by half a unit of its last digit, by what half a unit of the digits of the motion changes, and by rounding.
///
/// # Errors
/// What cannot be read, with file and line, or that there is nothing to compare.
pub fn compare(scene: &Scene, model: &Model, results: &Results) -> Result<Comparison, String> {
    let survey = Survey::of(results)?;
    let matrices = results.matrices();
    if !survey.has_motion {
        return Err("no file has a motion of nodes (U1, UR1 …): connectors cannot be evaluated; print it with *NODE PRINT or *NODE OUTPUT: U, UR".into());
    }
    if !survey.has_outputs && !survey.has_forces && matrices.is_empty() {
        return Err("no file has an output of connectors (CU1, CP1, CTF1 …), a force at nodes (RF1 …) or a matrix: there is nothing to compare; print it with *EL PRINT: CU, CTF".into());
    }
    let (mut comparison, single) = judge(scene, model, results, (&survey, Depth::All))?;
    if comparison.wrong() > 0 {
        comparison.cause = other_maps(&results.map, &survey).into_iter().find_map(|(changed, words)| {
            let mut other = results.clone();
            other.map = changed;
            let (tried, _) = judge(scene, model, &other, (&survey, Depth::FirstWrong)).ok()?;
            (tried.compared() > 0 && tried.wrong() == 0).then_some(words)
        });
        if comparison.cause.is_none() && single {
            comparison.cause =
                Some("numbers went through single precision: single = true in the map".to_string());
        }
        if comparison.cause.is_none() {
            let alternatives = alternatives(scene, model, results, (&survey, &comparison.series))?;
            explain_all(&mut comparison.series, &alternatives);
        }
    }
    if !matrices.is_empty() {
        comparison.series.extend(compare_matrices(scene, model, results, &matrices, survey.has_rates[0])?);
    }
    comparison.gaps = gaps(model, &survey, &comparison);
    let unread = results.unread();
    comparison.gaps.extend(unread.iter().map(|(file, headings)| Gap {
        what: format!(
            "{file} has columns of no known meaning: {}{}; a map says what they are, or \"ignore\"",
            headings.iter().take(12).map(String::as_str).collect::<Vec<_>>().join(", "),
            if headings.len() > 12 { ", …" } else { "" }
        ),
        request: Vec::new(),
    }));
    comparison.unread = unread.into_iter().flat_map(|(_, headings)| headings).collect();
    Ok(comparison)
}

fn explain_all(all: &mut [Series], alternatives: &Alternatives) {
    for n in 0..all.len() {
        let series = &all[n];
        let Some(of) = series.of.filter(|_| series.wrong > 0) else { continue };
        let (_, first) = of.place();
        let sibling = |i: usize| {
            all.iter().find(|other| other.element == series.element && other.of == Some(of.with(first + i)))
        };
        let cause = explain(series, [sibling(0), sibling(1), sibling(2)], alternatives);
        all[n].cause = cause;
    }
}

/// Other meanings of the motion, which explain everything at once. Most are refuted at the first states.
fn other_maps(map: &Map, survey: &Survey) -> Vec<(Map, String)> {
    let mut found = Vec::new();
    if !survey.turned.is_empty() && map.rotation_angles == Angle::Radian {
        let changed = Map { rotation_angles: Angle::Degree, ..map.clone() };
        found.push((
            changed,
            "the rotations of nodes are in degrees: rotation_angles = \"deg\" in the map".to_string(),
        ));
    }
    if !survey.turned.is_empty() && map.rotations == Rotations::Total {
        let changed = Map { rotations: Rotations::Incremental, ..map.clone() };
        found.push((
            changed,
            "the rotations of nodes are those since the frame before: rotations = \"incremental\" in the map"
                .to_string(),
        ));
    }
    for (length, words) in
        [(1e-3, "mm of a scene in m"), (1e3, "m of a scene in mm"), (0.0254, "inches of a scene in m")]
    {
        let changed = Map { length: map.length * length, ..map.clone() };
        found.push((changed, format!("lengths are in {words}: length = {length} in the map")));
    }
    found
}

/// What a file cannot tell.
fn gaps(model: &Model, survey: &Survey, comparison: &Comparison) -> Vec<Gap> {
    let mut found = Vec::new();
    let lines = |first: &str, second: &str| vec![first.to_string(), second.to_string()];
    let mut still: BTreeSet<String> = BTreeSet::new();
    for element in &model.connectors {
        for (end, node) in element.nodes.iter().enumerate().filter_map(|(end, node)| Some((end, (*node)?))) {
            let active = element.connector.active();
            let node = node.to_string().to_ascii_uppercase();
            let turns = active[7 * end + 3..7 * end + 6].contains(&true);
            if turns && survey.moved.contains(&node) && !survey.turned.contains(&node) {
                still.insert(node);
            }
        }
    }
    if !still.is_empty() {
        const SHOWN: usize = 8;
        let nodes: Vec<&str> = still.iter().take(SHOWN).map(String::as_str).collect();
        let more = if still.len() > SHOWN { ", …" } else { "" };
        found.push(Gap {
            what: format!(
                "no rotation of nodes {}{more}: they are taken not to turn, so it distinguishes neither frames of components nor variations of rotations",
                nodes.join(", ")
            ),
            request: lines("*NODE PRINT", "U, UR"),
        });
    }
    if comparison.unjudged.iter().any(|of| of.why == Why::NoRates) {
        found.push(Gap {
            what: "the rates of nodes, of which CV, CA and viscous forces are made".into(),
            request: lines("*NODE PRINT", "U, UR, V, VR, A, AR"),
        });
    }
    if comparison.unjudged.iter().any(|of| matches!(of.why, Why::NoForce(..))) {
        found.push(Gap {
            what: "forces at nodes need those of every component, and reactions do not follow from a motion"
                .into(),
            request: lines("*EL PRINT", "CTF"),
        });
    }
    if comparison.unjudged.iter().any(|of| of.why == Why::NoMotion) {
        found.push(Gap {
            what: "some states have outputs and no motion: --interpolate takes it between those before and after".into(),
            request: lines("*NODE PRINT, FREQUENCY=1", "U, UR"),
        });
    }
    let coarse = comparison.series.iter().filter(|series| series.wrong == 0 && series.unseen() > COARSE);
    if let Some(worst) = coarse.max_by(|one, other| one.unseen().total_cmp(&other.unseen())) {
        found.push(Gap {
            what: format!(
                "errors below {:.1} % of {} of {}: its digits leave them open; print more of them",
                100.0 * worst.unseen(),
                worst.name,
                worst.element
            ),
            request: Vec::new(),
        });
    }
    if survey.has_forces && comparison.between > 0 {
        found.push(Gap {
            what: "forces at states between two of the motion are those of that motion".into(),
            request: Vec::new(),
        });
    }
    found
}

/// A number of a file that is to be compared: what it is called, and what it must be.
struct Judging<'a> {
    evaluator: &'a Evaluator<'a>,
    series: BTreeMap<Key, Series>,
    unjudged: BTreeMap<(String, String), Unjudged>,
    kept: usize,
    has_rates: [bool; 2],
}

impl Judging<'_> {
    fn refuse(&mut self, (owner, of): &Key, why: impl Into<Why>) {
        let name = of.name();
        let entry = self.unjudged.entry((owner.clone(), name.clone())).or_insert_with(|| Unjudged {
            element: owner.clone(),
            name,
            count: 0,
            why: why.into(),
        });
        entry.count += 1;
    }

    fn add(&mut self, key: &Key, type_name: &str, point: Point) {
        let kept = self.kept;
        let new = || Series::new(key, type_name.to_string());
        self.series.entry(key.clone()).or_insert_with(new).add(point, kept);
    }

    /// The points of a frame.
    fn points(
        &mut self,
        frame: &Frame,
        at: f64,
        known: Option<(&Known, &State)>,
    ) -> Vec<(Key, String, Point)> {
        let mut found = Vec::new();
        let evaluator = self.evaluator;
        for (element, outputs) in &frame.elements {
            for (output, k, printed) in outputs {
                let key = (element.clone(), Of::Output(*output, *k));
                if !evaluator.ends.contains_key(element) {
                    self.refuse(&key, "the scene has no such connector");
                    continue;
                }
                let Some((known, _)) = known else {
                    self.refuse(&key, Why::NoMotion);
                    continue;
                };
                let is_told = match output {
                    Output::CV => self.has_rates[0],
                    Output::CA => self.has_rates == [true; 2],
                    _ => true,
                };
                if !is_told {
                    self.refuse(&key, Why::NoRates);
                    continue;
                }
                let Some(numbers) = known.elements.get(element) else {
                    self.refuse(&key, "the connector has no output");
                    continue;
                };
                let printed = printed.times(unit_of(evaluator.map, *output, numbers.units[*k]));
                let Some(want) = numbers.values.get(&(*output, *k)) else {
                    self.refuse(
                        &key,
                        if output.is_force() {
                            "the motion leaves it open: a reaction, or nothing acts there"
                        } else {
                            "the connection type has no such component"
                        },
                    );
                    continue;
                };
                let of_kind = numbers.values.iter().filter(|((other, _), _)| *other == *output);
                let largest = of_kind.map(|(_, x)| x.abs()).fold(printed.x.abs(), f64::max);
                let allowed = printed.half + ROUNDINGS * largest.max(1e-3);
                found.push((
                    key,
                    numbers.type_name.clone(),
                    Point { at, got: printed.x, want: *want, allowed },
                ));
            }
        }
        for (node, forces) in &frame.forces {
            for (nodal, i, printed) in forces {
                let key = (node.clone(), Of::Nodal(*nodal, *i));
                let Some((known, state)) = known else {
                    self.refuse(&key, Why::NoMotion);
                    continue;
                };
                match evaluator.at_node(known, (node, (*nodal, *i)), state) {
                    Err(why) => self.refuse(&key, why),
                    Ok(want) => {
                        let of_kind = forces.iter().filter(|(of, ..)| of == nodal);
                        let largest = of_kind.map(|(.., x)| x.x.abs()).fold(want.x.abs(), f64::max);
                        let allowed = printed.half + want.half + ROUNDINGS * largest.max(1e-3);
                        let type_name = if *nodal == Nodal::Reaction { "reaction at" } else { "force at" };
                        found.push((
                            key,
                            type_name.into(),
                            Point { at, got: printed.x, want: want.x, allowed },
                        ));
                    }
                }
            }
        }
        found
    }
}

/// How far a pass goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Depth {
    All,
    /// To the first number that is wrong.
    FirstWrong,
}

/// A scene along the motion of files.
struct Walk<'a> {
    evaluator: &'a Evaluator<'a>,
    sequence: Sequence<'a>,
    motions: Motions,
    frames: u64,
}

impl Walk<'_> {
    /// What a frame is known by.
    fn at(&mut self, frame: &Frame) -> f64 {
        self.frames += 1;
        frame.time.or(frame.number.map(|n| n as f64)).unwrap_or(self.frames as f64 - 1.0)
    }
}

/// Makes a walk, and does something with it.
fn walk<T>(
    scene: &Scene,
    model: &Model,
    (results, survey): (&Results, &Survey),
    with: impl FnOnce(Walk<'_>) -> Result<T, String>,
) -> Result<T, String> {
    if model.connectors.is_empty() {
        return Err(format!("{} has no connector", scene.name));
    }
    let evaluator = Evaluator::new(scene, model, &results.map)?;
    let plan =
        Plan::compile(model, &Selection::All, evaluator.request()).map_err(|error| error.to_string())?;
    let mut sequence = Sequence::new(model, &plan);
    if !survey.has_rates[0] {
        sequence.set_velocities(Velocities::Increments);
    }
    let motions = Motions::new(scene, &results.map);
    with(Walk { evaluator: &evaluator, sequence, motions, frames: 0 })
}

/// One pass through the frames; with whether single precision explains all that is wrong.
fn judge(
    scene: &Scene,
    model: &Model,
    results: &Results,
    (survey, depth): (&Survey, Depth),
) -> Result<(Comparison, bool), String> {
    walk(scene, model, (results, survey), |mut walk| {
        let evaluator = walk.evaluator;
        let judging = || Judging {
            evaluator,
            series: BTreeMap::new(),
            unjudged: BTreeMap::new(),
            kept: survey.kept(),
            has_rates: survey.has_rates,
        };
        let (mut judging, mut aside) = (judging(), judging());
        let mut comparison = Comparison::default();
        let mut before = walk.sequence.clone();
        // Viscous forces at the state before.
        let mut rates: BTreeMap<Key, f64> = BTreeMap::new();
        let mut is_single = depth == Depth::All && !results.map.single;
        results.each_until(|frame| {
            comparison.frames += 1;
            comparison.between += u64::from(frame.is_between);
            let at = walk.at(frame);
            if !frame.moves {
                judging.points(frame, at, None);
                return Ok(ControlFlow::Continue(()));
            }
            comparison.moved += 1;
            before.clone_from(&walk.sequence);
            let state = walk.motions.state(frame)?;
            let known = evaluator.at(&mut walk.sequence, &state, (frame, false));
            let mut suspects: Vec<(Key, String, Point)> = Vec::new();
            let mut wrong_here: Vec<Key> = Vec::new();
            let mut add = |judging: &mut Judging<'_>, (key, type_name, point): (Key, String, Point)| {
                if point.is_wrong() {
                    wrong_here.push(key.clone());
                }
                judging.add(&key, &type_name, point);
            };
            for (key, type_name, mut point) in judging.points(frame, at, Some((&known, &state))) {
                if let Some(viscous) = evaluator.viscous(&known, &key).filter(|_| !survey.has_rates[0]) {
                    // A rate from two states is that of some time between: by as much as it changes from increment to increment.
                    let before = rates
                        .insert(key.clone(), viscous)
                        .map_or(f64::INFINITY, |last| (viscous - last).abs());
                    if !before.is_finite() {
                        judging.refuse(&key, Why::NoRates);
                        continue;
                    }
                    point.allowed += before;
                }
                let wrong = judging.series.get(&key).map_or(0, |of| of.wrong);
                if point.is_wrong() && (wrong < SURE || point.units() < 100.0) {
                    suspects.push((key, type_name, point));
                } else {
                    add(&mut judging, (key, type_name, point));
                }
            }
            let keys: Vec<Key> = suspects.iter().map(|(key, ..)| key.clone()).collect();
            let more = evaluator.uncertain(&before, (&state, frame, &known), &walk.motions, &keys);
            for ((key, type_name, point), more) in suspects.into_iter().zip(more) {
                add(&mut judging, (key, type_name, Point { allowed: point.allowed + more, ..point }));
            }
            if is_single && !wrong_here.is_empty() {
                // Single precision changes no number, but what it stands for.
                let frame = &frame.single();
                let known = evaluator.at(&mut before.clone(), &state, (frame, false));
                let more = evaluator.uncertain(&before, (&state, frame, &known), &walk.motions, &wrong_here);
                let points = aside.points(frame, at, Some((&known, &state)));
                is_single = wrong_here.iter().zip(more).all(|(key, more)| {
                    points.iter().any(|(of, _, point)| {
                        of == key && !Point { allowed: point.allowed + more, ..*point }.is_wrong()
                    })
                });
            }
            let is_enough = depth == Depth::FirstWrong && !wrong_here.is_empty();
            Ok(if is_enough { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
        })?;
        comparison.series = judging.series.into_values().collect();
        comparison.unjudged = judging.unjudged.into_values().collect();
        Ok((comparison, is_single))
    })
}

/// What the numbers may be besides, at the states that the wrong series have kept: one pass, to the last of them.
fn alternatives(
    scene: &Scene,
    model: &Model,
    results: &Results,
    (survey, series): (&Survey, &[Series]),
) -> Result<Alternatives, String> {
    let kept = series.iter().filter(|series| series.wrong > 0).flat_map(|series| &series.points);
    let last = kept.clone().fold(f64::NEG_INFINITY, |last, point| last.max(point.at));
    let wanted: BTreeSet<u64> = kept.map(|point| point.at.to_bits()).collect();
    walk(scene, model, (results, survey), |mut walk| {
        let mut found = Alternatives::default();
        results.each_until(|frame| {
            let at = walk.at(frame);
            if at > last {
                return Ok(ControlFlow::Break(()));
            }
            if !frame.moves {
                return Ok(ControlFlow::Continue(()));
            }
            let tells = frame.tells() && wanted.contains(&at.to_bits());
            let state = walk.motions.state(frame)?;
            let known = walk.evaluator.at(&mut walk.sequence, &state, (frame, tells));
            if tells {
                found.add(at, known, |element| frame.elements.contains_key(element));
            }
            Ok(ControlFlow::Continue(()))
        })?;
        Ok(found)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_output_is_named_as_files_have_it() {
        for (of, name) in [
            (Of::Output(Output::CU, 3), "CUR1"),
            (Of::Output(Output::CTF, 5), "CTM3"),
            (Of::Output(Output::CRF, 0), "CRF1"),
            (Of::Nodal(Nodal::Reaction, 4), "RM2"),
            (Of::Nodal(Nodal::Force, 0), "NF1"),
        ] {
            assert_eq!(of.name(), name);
        }
        let scene = Scene::parse("none.inp", "*NODE\n1, 0., 0., 0.\n").unwrap();
        let model = Model::compile(&scene).unwrap();
        let results = Results::new(Vec::new(), Map::default());
        assert!(judge(&scene, &model, &results, (&Survey::default(), Depth::All)).is_err());
    }
}
