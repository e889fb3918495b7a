//! `pintle solve`: events, the last state with its digits, energies, and how far two methods are apart; the motion as a page.

mod motion;
mod page;
mod plot;

pub use page::{html, picture};

use crate::layout;
use pintle_kinematics::catalog::COMPONENT;
use pintle_solve::{Difference, Event, Frame, Number, Solution};
use serde_json::{Value, json};
use std::io::{self, Write};

/// The version of the JSON form.
pub const SCHEMA: &str = "pintle-solution/1";

/// Errors from this on leave no digit.
pub const NO_DIGIT: f64 = 0.1;

/// What is told of a solution besides itself.
#[derive(Clone, Copy, Debug)]
pub struct Facts<'a> {
    /// The scene.
    pub scene: &'a str,
    /// The digits asked for.
    pub digits: usize,
    /// How far the witness is from it, where there is one.
    pub difference: Option<&'a Difference>,
    /// How far rigid stick is from it, where its stick is elastic.
    pub rigid: Option<&'a Difference>,
    /// Why it ended early.
    pub ended: Option<&'a str>,
    /// Why the witness ended early, where it alone did.
    pub witness_ended: Option<&'a str>,
}

impl Facts<'_> {
    /// Why no digit is certain.
    fn doubt(&self) -> String {
        match self.witness_ended {
            Some(why) => format!("collocation ended early {why}"),
            None => format!("extrapolation and collocation find other events{}", self.others_from()),
        }
    }

    /// From when on events are others, where that is known.
    fn others_from(&self) -> String {
        let when = self.difference.and_then(|of| of.others_from);
        when.map_or_else(String::new, |when| format!(" from time {when:.6} on"))
    }

    /// The digits that the error leaves.
    fn digits<R: Number>(&self) -> usize {
        let most = if R::ROUNDING < f64::EPSILON / 4.0 { self.digits } else { self.digits.min(16) };
        let Some(difference) = self.difference else { return most.min(6) };
        // Two methods that agree share roundings: of doubles so many, and a digit besides. Errors of doubles have half of that digit already.
        const SHARED: f64 = 3e-14;
        const SURE: f64 = 10.0;
        const SURE_OF_DOUBLES: f64 = SURE / 3.0;
        let error = difference.largest();
        if error.is_nan() || error >= NO_DIGIT {
            return 1;
        }
        let error = if R::ROUNDING < f64::EPSILON / 4.0 {
            SURE * error
        } else {
            (SURE_OF_DOUBLES * error).max(SHARED)
        };
        if error <= 0.0 { most } else { most.min((-error.log10()).floor().max(1.0) as usize) }
    }

    /// How the error is known.
    const fn level<R: Number>(&self) -> &'static str {
        match (self.difference.is_some(), R::ROUNDING < f64::EPSILON / 4.0) {
            (false, _) => "not estimated",
            (true, false) => "estimated",
            (true, true) => "reproduced",
        }
    }
}

fn slides(event: &Event<impl Number>) -> String {
    let names: Vec<&str> = event.components.iter().map(|k| COMPONENT[*k]).collect();
    names.join(" ")
}

/// The margin of an event as text: what is no tie does not read as one.
fn margin(event: &Event<impl Number>) -> String {
    /// Below this three digits after the point would be zeros.
    const SMALL: f64 = 5e-4;
    /// From this on they say nothing.
    const LARGE: f64 = 1e6;
    match event.margin {
        None => "–".to_string(),
        Some(margin) if margin != 0.0 && margin.abs() < SMALL || margin.abs() >= LARGE => {
            format!("{margin:.0e}")
        }
        Some(margin) => format!("{margin:.3}"),
    }
}

/// Writes a solution as text.
///
/// # Errors
/// Those of the stream.
pub fn human<R: Number>(
    out: &mut dyn Write,
    solution: &Solution<R>,
    facts: Facts<'_>,
    width: usize,
) -> io::Result<()> {
    let digits = facts.digits::<R>();
    let number = |x: R| x.digits(digits);
    let first = solution.frames.first().map_or(0.0, |frame| frame.time.to_f64());
    let last = solution.frames.last();
    let until = last.map_or(first, |frame| frame.time.to_f64());
    let kind = if R::ROUNDING < f64::EPSILON / 4.0 { "237 bits" } else { "doubles" };
    writeln!(
        out,
        "{}: solved from {first} to {until}, on {kind}, in {} steps",
        layout::styled(layout::BOLD, facts.scene),
        solution.steps
    )?;
    let mut say = |label: &str, text: &str| write!(out, "{}", layout::labelled(label, 2, 10, text, width));
    match facts.difference {
        None => say("error", "not estimated: one method alone")?,
        Some(difference) if difference.same_events => say(
            "error",
            &format!(
                "{:.0e}, {}: {}, in {} numbers and {} events",
                difference.largest(),
                facts.level::<R>(),
                match difference.runs {
                    0..=2 if R::ROUNDING < f64::EPSILON / 4.0 => {
                        "extrapolation and collocation differ by no more".to_string()
                    }
                    0..=2 => "extrapolation and collocation differ by a third of that at most".to_string(),
                    runs =>
                        format!("rounding grows; {runs} runs that round otherwise differ by a part of that"),
                },
                difference.compared,
                solution.events.len()
            ),
        )?,
        Some(_) => say("error", &format!("unknown: {}", facts.doubt()))?,
    }
    if solution.connectors.is_empty()
        || last.is_none_or(|last| last.connectors.iter().all(|of| of.sticks.is_empty()))
    {
        say("unique", "yes: nothing rubs")?;
    } else if solution.lipschitz < 1.0 {
        let sticks =
            solution.frames.iter().any(|frame| frame.connectors.iter().any(|of| of.sticks.contains(&true)));
        let kappa = format!("κ = {:.3} < 1", solution.lipschitz);
        let told = match sticks {
            true => format!(
                "where something slips, for {kappa}; while it sticks, slip is looked for at events alone"
            ),
            false => format!("yes: {kappa}, so friction forces are the only ones that fit"),
        };
        say("unique", &told)?;
    } else {
        say("unique", &format!("not certain: κ = {:.3} is not below 1", solution.lipschitz))?;
    }
    if solution.changed > 0.0 {
        say(
            "start",
            &format!(
                "the velocities given were changed by {:.0e} of the largest, to fit the constraints",
                solution.changed
            ),
        )?;
    }
    say("rows", &format!("violated by {:.0e} at most", solution.violation))?;
    let open: usize = last
        .iter()
        .flat_map(|last| &last.connectors)
        .map(|of| of.open.iter().filter(|is| **is).count())
        .sum();
    if open > 0 {
        say(
            "open",
            &format!(
                "{open} CTF: {}, so that many forces fit",
                match last
                    .iter()
                    .any(|last| last.connectors.iter().any(|of| of.open_friction.contains(&true)))
                {
                    true => "more frictions stand than hold",
                    false => "constraints repeat each other (pintle audit names them)",
                }
            ),
        )?;
    }
    if let Some((time, connector)) = solution.ties.first() {
        let title = solution.connectors.get(*connector).map_or("", |(_, title)| title.as_str());
        let more = match solution.ties.len() - 1 {
            0 => String::new(),
            more => format!(" ({more} more)"),
        };
        say(
            "tie",
            &format!("at {time} {title} sticks, though its load is what friction holds, to rounding{more}"),
        )?;
    }
    if let Some(rigid) = facts.rigid {
        let events = match rigid.same_events {
            true => format!("{:.0e} in the times of events", rigid.event),
            false => "and has other events".to_string(),
        };
        let Difference { displacement, velocity, force, .. } = rigid;
        say(
            "rigid",
            &format!(
                "rigid stick differs by {displacement:.0e} in displacement, {velocity:.0e} in velocity, {force:.0e} in force, {events}"
            ),
        )?;
    }
    if !solution.events.is_empty() {
        const MOST: usize = 40;
        let rows: Vec<Vec<String>> = solution
            .events
            .iter()
            .take(MOST)
            .map(|event| {
                let title = solution.connectors.get(event.connector).map_or("", |(_, title)| title.as_str());
                vec![
                    number(event.time),
                    format!("{title} {}", slides(event)),
                    event.what.name().to_string(),
                    margin(event),
                    format!("{:.3}", event.lipschitz),
                ]
            })
            .collect();
        writeln!(out)?;
        write!(out, "{}", layout::table(&["time", "event", "", "margin", "κ"], &rows))?;
        if solution.events.len() > MOST {
            writeln!(out, "… {} more: --format json has them all", solution.events.len() - MOST)?;
        }
    }
    if let Some(last) = last {
        writeln!(out)?;
        state(out, solution, last, (&number, digits))?;
    }
    if let Some(why) = facts.ended {
        writeln!(out)?;
        writeln!(out, "{} {why}", layout::styled(layout::CARE, "ended early:"))?;
    }
    Ok(())
}

fn state<R: Number>(
    out: &mut dyn Write,
    solution: &Solution<R>,
    frame: &Frame<R>,
    (number, digits): (&dyn Fn(R) -> String, usize),
) -> io::Result<()> {
    let scales = solution.scales();
    // A number is known to the last digit of the largest of its kind.
    let known = |x: R, scale: f64| {
        let beyond = (x.to_f64().abs() / scale).log10().ceil().min(0.0);
        let known = digits as f64 + beyond;
        if known < 1.0 { "0".to_string() } else { x.digits(known as usize) }
    };
    let mut rows = Vec::new();
    for ((_, title), of) in solution.connectors.iter().zip(&frame.connectors) {
        for k in (0..6).filter(|k| of.wanted[*k] || of.free[*k]) {
            let moves = of.displacement[k].to_f64() != 0.0 || of.velocity[k].to_f64() != 0.0;
            let is_zero = !moves && !of.open[k] && of.total[k].to_f64() == 0.0;
            if is_zero {
                continue;
            }
            rows.push(vec![
                format!("{title} {}", COMPONENT[k]),
                known(of.displacement[k], if k < 3 { solution.length } else { 1.0 }),
                known(of.velocity[k], scales.velocity[k / 3]),
                if of.open[k] { "open".to_string() } else { known(of.total[k], scales.force[k / 3]) },
                match of.open_friction[k] {
                    true => "open".to_string(),
                    false => known(of.friction[k], scales.force[k / 3]),
                },
            ]);
        }
    }
    writeln!(out, "at {}", number(frame.time))?;
    write!(out, "{}", layout::table(&["component", "CU", "CV", "CTF", "CSF"], &rows))?;
    let energies = &frame.energies;
    writeln!(
        out,
        "energies: kinetic {}, stored {}, dissipated {}, external work {}; balance {:.0e}",
        known(energies.kinetic, scales.energy),
        match solution.stored_is_open {
            true => "open".to_string(),
            false => known(energies.stored, scales.energy),
        },
        known(energies.dissipated, scales.energy),
        known(energies.external, scales.energy),
        energies.balance.to_f64()
    )
}

/// Writes a solution as one JSON document: numbers of 237 bits are texts.
///
/// # Errors
/// Those of the stream.
pub fn json<R: Number>(out: &mut dyn Write, solution: &Solution<R>, facts: Facts<'_>) -> io::Result<()> {
    let is_wide = R::ROUNDING < f64::EPSILON / 4.0;
    let digits = facts.digits::<R>();
    let number = |x: R| if is_wide { Value::from(x.digits(digits)) } else { Value::from(x.to_f64()) };
    let list = |all: &[R]| Value::from(all.iter().map(|x| number(*x)).collect::<Vec<_>>());
    let label = |index: usize| solution.connectors.get(index).map(|(label, _)| label.to_string());
    let events: Vec<Value> = solution
        .events
        .iter()
        .map(|event| {
            json!({
                "time": number(event.time),
                "connector": label(event.connector),
                "components": event.components.iter().map(|k| COMPONENT[*k]).collect::<Vec<_>>(),
                "event": event.what,
                "margin": event.margin,
                "lipschitz": event.lipschitz,
            })
        })
        .collect();
    let frames: Vec<Value> = solution
        .frames
        .iter()
        .map(|frame| {
            let nodes: serde_json::Map<String, Value> = solution
                .nodes
                .iter()
                .zip(&frame.nodes)
                .map(|(label, node)| {
                    let reaction =
                        |k: usize| if node.held[k] { number(node.reaction[k]) } else { Value::Null };
                    let reactions: Vec<Value> = (0..6).map(reaction).collect();
                    let value = json!({
                        "displacement": list(&node.displacement),
                        "rotation": list(&node.rotation),
                        "velocity": list(&node.velocity[..3]),
                        "angular_velocity": list(&node.velocity[3..]),
                        "acceleration": list(&node.acceleration[..3]),
                        "angular_acceleration": list(&node.acceleration[3..]),
                        "RF": reactions[..3],
                        "RM": reactions[3..],
                    });
                    (label.to_string(), value)
                })
                .collect();
            let connectors: serde_json::Map<String, Value> = solution
                .connectors
                .iter()
                .zip(&frame.connectors)
                .map(|((label, _), of)| {
                    let force = |k: usize| if of.open[k] { Value::Null } else { number(of.total[k]) };
                    let forces: Vec<Value> = (0..6).map(force).collect();
                    let rubs =
                        |k: usize| if of.open_friction[k] { Value::Null } else { number(of.friction[k]) };
                    let rubbing: Vec<Value> = (0..6).map(rubs).collect();
                    let value = json!({
                        "CU": list(&of.displacement),
                        "CV": list(&of.velocity),
                        "CTF": forces,
                        "CSF": rubbing,
                        "sticks": of.sticks,
                        "CSLST": of.held,
                        "CFAILST": of.failed,
                    });
                    (label.to_string(), value)
                })
                .collect();
            let energies = &frame.energies;
            json!({
                "time": number(frame.time),
                "event": frame.is_event,
                "nodes": nodes,
                "connectors": connectors,
                "energies": {
                    "kinetic": number(energies.kinetic),
                    "stored": if solution.stored_is_open { Value::Null } else { number(energies.stored) },
                    "dissipated": number(energies.dissipated),
                    "external": number(energies.external),
                    "balance": number(energies.balance),
                },
            })
        })
        .collect();
    let document = json!({
        "schema": SCHEMA,
        "version": pintle_kinematics::VERSION,
        "scene": facts.scene,
        "digits": digits,
        "error": facts.difference,
        "error_is": facts.level::<R>(),
        "lipschitz": solution.lipschitz,
        "violation": solution.violation,
        "velocities_changed": solution.changed,
        "ties": solution.ties.iter().map(|(time, of)| json!({"time": time, "connector": label(*of)})).collect::<Vec<_>>(),
        "rigid_stick": facts.rigid,
        "steps": solution.steps,
        "evaluations": solution.evaluations,
        "ended_early": facts.ended,
        "events": events,
        "frames": frames,
    });
    serde_json::to_writer_pretty(&mut *out, &document)?;
    writeln!(out)
}
