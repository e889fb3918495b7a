//! What the connectors must give along the motion that files tell, beside what the files say of them.

use crate::cause::{Alternatives, explain};
use crate::column::{Map, Motion, Rotations};
use crate::judge::{Comparison, KEPT, Point, Series, Unjudged};
use crate::printed::Printed;
use crate::read::{Frame, Results};
use pintle_check::Angle;
use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::connector::{Output, Request};
use pintle_kinematics::measure::Unit;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Matrix, identity, product};
use pintle_model::behavior::state::Velocities;
use pintle_model::evaluate::{Item, Model, Plan, Selection, Sequence};
use pintle_report::{Block, Value};
use pintle_scene::{Label, NodeMotion, Rotation, Scene, State};
use std::collections::BTreeMap;
use std::convert::Infallible;

/// What is evaluated.
const OUTPUTS: [Output; 13] = [
    Output::CP,
    Output::CU,
    Output::CCU,
    Output::CV,
    Output::CA,
    Output::CTF,
    Output::CEF,
    Output::CVF,
    Output::CSF,
    Output::CRF,
    Output::CCF,
    Output::CNF,
    Output::CASU,
];

/// Roundings that a program may spend on a number, relative to the largest number of its kind at the state.
const ROUNDINGS: f64 = 1e-13;

/// How many states beyond which a series that is wrong is taken to be so, without another look at the digits of the motion.
const SURE: u64 = 3;

/// The numbers of one connector at one state.
#[derive(Clone, Debug, Default)]
struct Numbers {
    type_name: String,
    units: [Option<Unit>; 6],
    values: BTreeMap<(Output, usize), f64>,
}

/// The states of a run, as scenes have them.
struct Motions {
    labels: BTreeMap<String, Label>,
    map: Map,
    /// Total rotations, where the file has increments.
    turned: BTreeMap<Label, Matrix<f64>>,
}

impl Motions {
    fn new(scene: &Scene, map: &Map) -> Self {
        let labels =
            scene.nodes.keys().map(|label| (label.to_string().to_ascii_uppercase(), *label)).collect();
        Self { labels, map: map.clone(), turned: BTreeMap::new() }
    }

    /// The state of a frame.
    fn state(&mut self, frame: &Frame) -> Result<State, String> {
        let mut state = State { number: frame.number, time: frame.time, ..State::default() };
        for (node, motions) in &frame.nodes {
            // A file holds more nodes than a scene needs.
            let Some(label) = self.labels.get(node) else { continue };
            let mut motion = of_node(motions)?;
            if self.map.rotations == Rotations::Incremental {
                let by = match motion.rotation {
                    Rotation::Vector(vector) => so3::turn(vector),
                    Rotation::Quaternion(quaternion) => so3::matrix(quaternion),
                };
                let before = self.turned.get(label).copied().unwrap_or_else(identity);
                let now = product(&by, &before);
                self.turned.insert(*label, now);
                motion.rotation = Rotation::Quaternion(so3::quaternion(&now));
            }
            state.nodes.insert(*label, motion);
        }
        Ok(state)
    }
}

/// The motion of a node from what a file says of it.
fn of_node(motions: &[(Motion, Printed)]) -> Result<NodeMotion, String> {
    let mut found = NodeMotion::default();
    let (mut vector, mut quaternion) = ([0.0; 3], None);
    for (motion, number) in motions {
        let x = number.x;
        match motion {
            Motion::Displacement(i) => found.displacement[*i] = x,
            Motion::Rotation(i) => vector[*i] = x,
            Motion::Quaternion(i) => quaternion.get_or_insert([0.0; 4])[*i] = x,
            Motion::Velocity(i) => found.velocity[*i] = x,
            Motion::AngularVelocity(i) => found.angular_velocity[*i] = x,
            Motion::Acceleration(i) => found.acceleration[*i] = x,
            Motion::AngularAcceleration(i) => found.angular_acceleration[*i] = x,
            Motion::Flow => found.flow = x,
        }
    }
    found.rotation = match quaternion {
        None => Rotation::Vector(vector),
        Some(q) => {
            let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
            if (norm - 1.0).abs() > 1e-3 {
                return Err(format!("a quaternion of norm {norm}: is it q0, q1, q2, q3, the scalar first?"));
            }
            // Printed digits leave the norm a little off.
            Rotation::Quaternion(q.map(|x| x / norm))
        }
    };
    Ok(found)
}

/// The states that files tell, for whoever reads states.
///
/// # Errors
/// What cannot be read, with file and line.
pub fn states(scene: &Scene, results: &Results) -> Result<Vec<State>, String> {
    let mut motions = Motions::new(scene, &results.map);
    let mut found = Vec::new();
    results.each(|frame| {
        if !frame.nodes.is_empty() {
            let mut state = motions.state(frame)?;
            state.number = Some(found.len() as u64);
            found.push(state);
        }
        Ok(())
    })?;
    Ok(found)
}

/// What files hold.
#[derive(Debug, Default)]
struct Survey {
    has_rates: bool,
    has_rotations: bool,
    has_motion: bool,
    elements: u64,
}

/// Compares what files say of the connectors of a scene with what these give along the motion that the files tell.
///
/// Each number may differ by half a unit of its last digit, by what half a unit of the digits of the motion changes, and by rounding.
///
/// # Errors
/// What cannot be read, with file and line, or that there is nothing to compare.
pub fn compare(scene: &Scene, model: &Model, results: &Results) -> Result<Comparison, String> {
    let mut survey = Survey::default();
    results.each(|frame| {
        let mut motions = frame.nodes.values().flatten();
        survey.has_motion |= !frame.nodes.is_empty();
        survey.has_rates |= motions.clone().any(|(of, _)| {
            !matches!(
                of,
                Motion::Displacement(_) | Motion::Rotation(_) | Motion::Quaternion(_) | Motion::Flow
            )
        });
        survey.has_rotations |=
            motions.any(|(of, _)| matches!(of, Motion::Rotation(_) | Motion::Quaternion(_)));
        survey.elements += frame.elements.len() as u64;
        Ok(())
    })?;
    if !survey.has_motion {
        return Err("no file has a motion of nodes (U1, UR1 …): connectors cannot be evaluated; print it with *NODE PRINT or *NODE OUTPUT: U, UR".into());
    }
    if survey.elements == 0 {
        return Err("no file has an output of connectors (CU1, CP1, CTF1 …): there is nothing to compare; print it with *EL PRINT: CU, CTF".into());
    }
    let (mut comparison, alternatives) = run(scene, model, results, &survey)?;
    comparison.gaps = gaps(model, &survey, &comparison);
    comparison.gaps.extend(results.unread().into_iter().map(|(file, headings)| {
        format!("{file} has columns of no known meaning: {headings}; a map says what they are, or \"ignore\"")
    }));
    if comparison.wrong() == 0 {
        return Ok(comparison);
    }
    for (changed, words) in other_maps(&results.map, &survey) {
        let mut other = results.clone();
        other.map = changed;
        let Ok((tried, _)) = run(scene, model, &other, &survey) else { continue };
        if tried.compared() > 0 && tried.wrong() == 0 {
            comparison.cause = Some(words);
            return Ok(comparison);
        }
    }
    for n in 0..comparison.series.len() {
        if comparison.series[n].wrong > 0 {
            comparison.series[n].cause = explain(&comparison.series[n], &alternatives);
        }
    }
    Ok(comparison)
}

/// Other meanings of the motion, which explain everything at once.
fn other_maps(map: &Map, survey: &Survey) -> Vec<(Map, String)> {
    let mut found = Vec::new();
    if survey.has_rotations && map.rotation_angles == Angle::Radian {
        let changed = Map { rotation_angles: Angle::Degree, ..map.clone() };
        found.push((
            changed,
            "the rotations of nodes are in degrees: rotation_angles = \"deg\" in the map".to_string(),
        ));
    }
    if survey.has_rotations && map.rotations == Rotations::Total {
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
fn gaps(model: &Model, survey: &Survey, comparison: &Comparison) -> Vec<String> {
    let mut found = Vec::new();
    if !survey.has_rotations
        && model.connectors.iter().any(|element| element.nodes.iter().flatten().count() > 0)
    {
        found.push(
            "no rotation of a node: nodes are taken not to turn; add UR to *NODE PRINT or *NODE OUTPUT"
                .to_string(),
        );
    }
    let of_rates = |series: &Series| {
        series.name.starts_with("CV") || series.name.starts_with("CA") && !series.name.starts_with("CASU")
    };
    if !survey.has_rates && comparison.series.iter().any(of_rates) {
        found.push("no velocity of a node: CV, CA and viscous forces follow from differences of states; add V, VR to *NODE PRINT".to_string());
    }
    found
}

/// One pass through all frames.
fn run(
    scene: &Scene,
    model: &Model,
    results: &Results,
    survey: &Survey,
) -> Result<(Comparison, Alternatives), String> {
    let request = Request::new(&OUTPUTS, [true; 6], 0);
    let plan = Plan::compile(model, &Selection::All, request.clone()).map_err(|error| error.to_string())?;
    if model.connectors.is_empty() {
        return Err(format!("{} has no connector", scene.name));
    }
    let mut sequence = Sequence::new(model, &plan);
    if !survey.has_rates {
        sequence.set_velocities(Velocities::Increments);
    }
    let ends: BTreeMap<String, [Option<Label>; 2]> = model
        .connectors
        .iter()
        .map(|element| (element.label.to_string().to_ascii_uppercase(), element.nodes))
        .collect();
    let mut motions = Motions::new(scene, &results.map);
    let mut series: BTreeMap<(String, Output, usize), Series> = BTreeMap::new();
    let mut unjudged: BTreeMap<(String, String), Unjudged> = BTreeMap::new();
    let mut alternatives = Alternatives::default();
    let mut comparison = Comparison::default();
    let mut last: Option<BTreeMap<String, Numbers>> = None;
    let mut before = sequence.clone();
    results.each(|frame| {
        comparison.frames += 1;
        let mut state = None;
        if !frame.nodes.is_empty() {
            comparison.moved += 1;
            before.clone_from(&sequence);
            let now = motions.state(frame)?;
            last = Some(evaluate(&mut sequence, model, &request, &now));
            state = Some(now);
        }
        if frame.elements.is_empty() {
            return Ok(());
        }
        let at = frame.time.or(frame.number.map(|n| n as f64)).unwrap_or(comparison.frames as f64 - 1.0);
        let mut suspects: Vec<((String, Output, usize), Point)> = Vec::new();
        for (element, outputs) in &frame.elements {
            let of_scene = last.as_ref().and_then(|all| all.get(element));
            for (output, k, printed) in outputs {
                let name = name_of(*output, *k);
                let mut not_judged = |why: &str| {
                    let entry = unjudged.entry((element.clone(), name.clone()));
                    let entry = entry.or_insert_with(|| Unjudged {
                        element: element.clone(),
                        name: name.clone(),
                        count: 0,
                        why: why.to_string(),
                    });
                    entry.count += 1;
                };
                if !ends.contains_key(element) {
                    not_judged("the scene has no such connector");
                    continue;
                }
                if state.is_none() {
                    not_judged("the files have no motion of nodes at these times");
                    continue;
                }
                let Some(numbers) = of_scene else {
                    not_judged("the connector has no output");
                    continue;
                };
                let printed = printed.times(unit_of(&results.map, *output, numbers.units[*k]));
                let Some(want) = numbers.values.get(&(*output, *k)) else {
                    not_judged(if output.is_force() {
                        "the motion leaves it open: a reaction, or nothing acts there"
                    } else {
                        "the connection type has no such component"
                    });
                    continue;
                };
                let largest = numbers
                    .values
                    .iter()
                    .filter(|((other, _), _)| *other == *output)
                    .map(|(_, x)| x.abs())
                    .fold(printed.x.abs(), f64::max);
                let point = Point {
                    at,
                    got: printed.x,
                    want: *want,
                    allowed: printed.half + ROUNDINGS * largest.max(1e-3),
                };
                let key = (element.clone(), *output, *k);
                let of = series.entry(key.clone()).or_insert_with(|| {
                    Series::new(element.clone(), numbers.type_name.clone(), name.clone(), *k)
                });
                if point.is_wrong() && (of.wrong < SURE || point.units() < 100.0) {
                    suspects.push((key, point));
                } else {
                    of.add(point);
                }
            }
        }
        if let (Some(now), Some(right)) = (&state, &last) {
            let digits = digits_of_motion(now, frame, &motions.labels, &suspects, &ends);
            let uncertain = uncertain(&before, model, &request, (now, right), &digits, &suspects);
            for ((key, point), more) in suspects.into_iter().zip(uncertain) {
                let point = Point { allowed: point.allowed + more, ..point };
                series.entry(key).and_modify(|of| of.add(point));
            }
            if alternatives.len() < KEPT {
                let of_files = right.iter().filter(|(element, _)| frame.elements.contains_key(*element));
                alternatives
                    .add(at, of_files.map(|(element, numbers)| (element.clone(), numbers.values.clone())));
            }
        }
        Ok(())
    })?;
    comparison.series = series.into_values().collect();
    comparison.unjudged = unjudged.into_values().collect();
    Ok((comparison, alternatives))
}

/// The numbers of every connector at the next state.
fn evaluate(
    sequence: &mut Sequence<'_>,
    model: &Model,
    request: &Request,
    state: &State,
) -> BTreeMap<String, Numbers> {
    let mut found = BTreeMap::new();
    let Ok(()) = sequence.visit(state, |item| -> Result<(), Infallible> {
        if let Item::Connector(result) = item {
            let block = Block::of_connector(model, request, result);
            let mut numbers = Numbers { type_name: block.type_name.to_string(), ..Numbers::default() };
            for row in &block.rows {
                let Some(k) = COMPONENT.iter().position(|name| *name == row.name) else { continue };
                numbers.units[k] = Some(row.unit);
                for (output, value) in Output::ALL.into_iter().zip(row.values) {
                    if let Some(Value::Number(x)) = value {
                        numbers.values.insert((output, k), x);
                    }
                }
            }
            found.insert(block.label.to_ascii_uppercase(), numbers);
        }
        Ok(())
    });
    found
}

/// The motions whose digits count for what is suspected: node, which of its numbers, half a unit.
fn digits_of_motion(
    state: &State,
    frame: &Frame,
    labels: &BTreeMap<String, Label>,
    suspects: &[((String, Output, usize), Point)],
    ends: &BTreeMap<String, [Option<Label>; 2]>,
) -> Vec<(Label, Motion, f64)> {
    let counts = |label: &Label| {
        suspects.iter().any(|((element, ..), _)| {
            ends.get(element).is_some_and(|ends| ends.iter().flatten().any(|end| end == label))
        })
    };
    let mut found = Vec::new();
    for (node, motions) in &frame.nodes {
        let Some(label) = labels.get(node).filter(|label| counts(label) && state.nodes.contains_key(*label))
        else {
            continue;
        };
        found.extend(
            motions.iter().filter(|(_, of)| of.half > 0.0).map(|(motion, of)| (*label, *motion, of.half)),
        );
    }
    found
}

/// By how much each suspected number changes, as the motion changes by what its digits leave open.
fn uncertain(
    before: &Sequence<'_>,
    model: &Model,
    request: &Request,
    (state, right): (&State, &BTreeMap<String, Numbers>),
    digits: &[(Label, Motion, f64)],
    suspects: &[((String, Output, usize), Point)],
) -> Vec<f64> {
    let mut found = vec![0.0; suspects.len()];
    let mut again = before.clone();
    for (label, motion, half) in digits {
        let mut moved = state.clone();
        let Some(node) = moved.nodes.get_mut(label) else { continue };
        shift(node, *motion, *half);
        again.clone_from(before);
        let all = evaluate(&mut again, model, request, &moved);
        for (found, ((element, output, k), _)) in found.iter_mut().zip(suspects) {
            let value = |of: &BTreeMap<String, Numbers>| {
                of.get(element).and_then(|numbers| numbers.values.get(&(*output, *k)).copied())
            };
            if let (Some(one), Some(other)) = (value(right), value(&all)) {
                *found += (one - other).abs();
            }
        }
    }
    found
}

/// Moves a node a little.
fn shift(node: &mut NodeMotion, motion: Motion, by: f64) {
    match (motion, &mut node.rotation) {
        (Motion::Displacement(i), _) => node.displacement[i] += by,
        (Motion::Rotation(i), Rotation::Vector(vector)) => vector[i] += by,
        (Motion::Rotation(i), Rotation::Quaternion(quaternion)) => {
            let mut turn = [0.0; 3];
            turn[i] = by;
            let turned = product(&so3::turn(turn), &so3::matrix(*quaternion));
            *quaternion = so3::quaternion(&turned);
        }
        (Motion::Quaternion(i), Rotation::Quaternion(quaternion)) => {
            quaternion[i] += by;
            let norm = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
            *quaternion = quaternion.map(|x| x / norm);
        }
        (Motion::Quaternion(_), Rotation::Vector(_)) => {}
        (Motion::Velocity(i), _) => node.velocity[i] += by,
        (Motion::AngularVelocity(i), _) => node.angular_velocity[i] += by,
        (Motion::Acceleration(i), _) => node.acceleration[i] += by,
        (Motion::AngularAcceleration(i), _) => node.angular_acceleration[i] += by,
        (Motion::Flow, _) => node.flow += by,
    }
}

/// The unit of an output of the file, in the scene's.
fn unit_of(map: &Map, output: Output, unit: Option<Unit>) -> f64 {
    let of_component = match unit {
        Some(Unit::Angle) => map.angles.size(),
        Some(Unit::Length) => map.length,
        _ => 1.0,
    };
    if !output.is_force() {
        return of_component;
    }
    // A force on a rotation is a moment.
    if unit == Some(Unit::Angle) { map.force * map.length } else { map.force }
}

/// The name of an output of a component, as headings have it: CU1, CUR1, CTF1, CTM1.
pub(crate) fn name_of(output: Output, k: usize) -> String {
    let name = output.name();
    match (k, output.is_force()) {
        (0..=2, _) => format!("{name}{}", k + 1),
        (_, true) => format!("{}M{}", name.trim_end_matches('F'), k - 2),
        (_, false) if output.is_kinematic() => format!("{name}R{}", k - 2),
        _ => format!("{name}{}", k + 1),
    }
}
