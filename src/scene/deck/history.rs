//! Steps and what happens in them: procedures, motions, loads, boundary conditions, output requests.

use crate::choice::Choice;
use crate::deck::errors::is_fatal;
use crate::deck::lookup::target;
use crate::deck::mesh::{any_degree_of_freedom, is_mechanical};
use crate::deck::{Deck, misplaced, unread};
use crate::diagnostic::{Code, Diagnostic, Result, nearest, suggest};
use crate::label::normal;
use crate::lexer::{Item, Keyword, begun};
use crate::model::{
    Amplitude, AmplitudeDefinition, Application, Boundary, ConcentratedLoad, ConditionKind, ConnectorLoad,
    ConnectorMotion, DistributedLoad, InitialVelocity, MotionType, Operation, OutputRequest, Procedure,
    Solver, Step, Target, Times,
};
use crate::span::Spanned;
use indexmap::IndexMap;

/// How a keyword applies its conditions. OP=NEW is noted for the step, for a keyword without data lines is how all of a kind are removed.
fn application(deck: &mut Deck<'_>, keyword: &Keyword, kind: ConditionKind) -> Result<Application> {
    let applied = Application {
        amplitude: keyword.name_of("AMPLITUDE")?,
        operation: keyword.choice("OP")?.unwrap_or_default(),
        fixed: keyword.has("FIXED"),
        user: keyword.has("USER"),
        follower: keyword.has("FOLLOWER")
            && keyword.get("FOLLOWER").is_none_or(|value| normal(value.text()) == "YES"),
        imaginary: keyword.has("IMAGINARY"),
        load_case: keyword.get("LOAD CASE").map(|value| value.integer("LOAD CASE")).transpose()?,
    };
    if let Some(step) = deck.step.as_mut().filter(|_| applied.operation == Operation::New) {
        step.removed.insert(kind);
    }
    Ok(applied)
}

fn motion_type(keyword: &Keyword) -> Result<MotionType> {
    Ok(keyword.choice("TYPE")?.unwrap_or_default())
}

/// The step that is being read; the stage of the keyword has been checked.
fn step_of<'a>(step: &'a mut Option<Step>, keyword: &Keyword) -> Result<&'a mut Step> {
    step.as_mut().ok_or_else(|| misplaced(keyword, ["*STEP"; 2]))
}

pub(super) fn connector_motion(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let kind = motion_type(keyword)?;
    let applied = application(deck, keyword, ConditionKind::ConnectorMotion)?;
    let mut warning = None;
    while let Some(line) = deck.lexer.row()? {
        let mut items = line.items();
        let target = target(&items.need("the element or element set")?, "the element number")?;
        let component = items.need("the component")?.component()?;
        let magnitude = items.maybe();
        if let Some(item) = magnitude.filter(|_| deck.step.is_none())
            && item.number()? != 0.0
        {
            warning = Some(nonzero(item));
        }
        let magnitude = magnitude.map(|item| item.number()).transpose()?;
        items.end("an element or element set, a component and a magnitude")?;
        let motion = ConnectorMotion { target, component, magnitude, kind, applied: applied.clone() };
        match &mut deck.step {
            Some(step) => step.connector_motions.push(motion),
            None => deck.scene.connector_motions.push(motion),
        }
    }
    warning.into_iter().for_each(|warning| deck.warn(warning));
    Ok(())
}

fn nonzero(item: Item<'_>) -> Diagnostic {
    let message = "a magnitude other than zero before the first step";
    Diagnostic::warning(
        Code::NonzeroModelBoundary,
        item.span,
        message,
        "an analysis takes it as zero or refuses it",
    )
    .help("move it into a step, or write 0")
}

pub(super) fn connector_load(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let applied = application(deck, keyword, ConditionKind::ConnectorLoad)?;
    while let Some(line) = deck.lexer.row()? {
        let mut items = line.items();
        let target = target(&items.need("the element or element set")?, "the element number")?;
        let component = items.need("the component")?.component()?;
        let magnitude = items.need("the magnitude")?.number()?;
        items.end("an element or element set, a component and a magnitude")?;
        let load = ConnectorLoad { target, component, magnitude, applied: applied.clone() };
        step_of(&mut deck.step, keyword)?.connector_loads.push(load);
    }
    Ok(())
}

/// Named boundary conditions and the degrees of freedom that they hold.
pub(super) const NAMED: &[(&str, &[u8])] = &[
    ("PINNED", &[1, 2, 3]),
    ("ENCASTRE", &[1, 2, 3, 4, 5, 6]),
    ("XSYMM", &[1, 5, 6]),
    ("YSYMM", &[2, 4, 6]),
    ("ZSYMM", &[3, 4, 5]),
    ("XASYMM", &[2, 3, 4]),
    ("YASYMM", &[1, 3, 5]),
    ("ZASYMM", &[1, 2, 6]),
];

/// Conditions of the sections of pipes and elbows, which hold no node.
const OF_SECTIONS: [&str; 3] = ["NOWARP", "NOOVAL", "NODEFORM"];

pub(super) fn boundary(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    // The imaginary part of a perturbation about the state.
    if keyword.has("IMAGINARY") {
        let lines = deck.lexer.skip()?;
        deck.count_skipped(keyword, lines);
        return Ok(());
    }
    let mut moved = None;
    let read = boundaries(deck, keyword, &mut moved);
    moved.into_iter().for_each(|(targets, warning)| deck.unread.warn_of(targets, warning));
    read
}

/// The lines of `*BOUNDARY`, and what they move before the first step, with a warning.
fn boundaries(
    deck: &mut Deck<'_>,
    keyword: &Keyword,
    moved: &mut Option<(Vec<Spanned<Target>>, Diagnostic)>,
) -> Result<()> {
    let kind = motion_type(keyword)?;
    let applied = application(deck, keyword, ConditionKind::Boundary)?;
    while let Some(line) = deck.lexer.row()? {
        let mut items = line.items();
        let target = target(&items.need("the node or node set")?, "the node number")?;
        let first = items.need("the first degree of freedom")?;
        let named = first.text.starts_with(|letter: char| letter.is_ascii_alphabetic());
        let mut magnitude = 0.0;
        let degrees_of_freedom = if named {
            let name = normal(first.text);
            if OF_SECTIONS.contains(&name.as_str()) {
                deck.scene.skipped.count(format!("*BOUNDARY {name}"), line.span.line());
                continue;
            }
            let known = NAMED.iter().find(|(known, _)| *known == name);
            let Some((_, held)) = known else {
                let remedy = suggest(&name, NAMED.iter().map(|(name, _)| *name), || {
                    "write a degree of freedom, PINNED or ENCASTRE".to_owned()
                });
                let message = format!("there is no boundary condition {name}");
                return Err(Diagnostic::error(
                    Code::BadValue,
                    first.span,
                    message,
                    "not one of those allowed",
                )
                .help(remedy));
            };
            items.end("a node or node set and the name of a boundary condition")?;
            held.to_vec()
        } else {
            let from = any_degree_of_freedom(&first)?;
            let last = items.maybe();
            let to = last.map_or(Ok(from), |item| any_degree_of_freedom(&item))?;
            if to < from {
                let span = last.map_or(line.span, |item| item.span);
                let message = format!("the last degree of freedom {to} is smaller than the first {from}");
                return Err(Diagnostic::error(Code::BadDegreeOfFreedom, span, message, "too small")
                    .help("write: node, first, last degree of freedom, magnitude"));
            }
            let value = items.maybe();
            magnitude = value.map_or(Ok(0.0), |value| value.number())?;
            items.end("a node or node set, the first and last degree of freedom and a magnitude")?;
            let (held, others): (Vec<u8>, Vec<u8>) = (from..=to).partition(|dof| is_mechanical(*dof));
            let others = match others[..] {
                [] => None,
                [one] => Some(format!("degree of freedom {one}")),
                [first, .., last] => Some(format!("degrees of freedom {first} to {last}")),
            };
            if let Some(others) = others {
                deck.scene.skipped.count(format!("*BOUNDARY of {others}"), line.span.line());
            }
            if held.is_empty() {
                continue;
            }
            if let Some(value) = value.filter(|_| magnitude != 0.0 && deck.step.is_none()) {
                let (targets, _) = moved.get_or_insert_with(|| (Vec::new(), nonzero(value)));
                targets.push(target.clone());
            }
            held
        };
        let boundary = Boundary { target, degrees_of_freedom, magnitude, kind, applied: applied.clone() };
        match &mut deck.step {
            Some(step) => step.boundaries.push(boundary),
            None => deck.scene.boundaries.push(boundary),
        }
    }
    Ok(())
}

/// Velocities; initial conditions of other types are skipped.
pub(super) fn initial_conditions(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let of_type = keyword.get("TYPE").map(|value| normal(value.text()));
    let is_velocity = of_type.is_some_and(|of_type| begun(&of_type, &["VELOCITY"]).is_some());
    if !is_velocity {
        let lines = deck.lexer.skip()?;
        deck.count_skipped(keyword, lines);
        return Ok(());
    }
    while let Some(line) = deck.lexer.row()? {
        let mut items = line.items();
        let target = target(&items.need("the node or node set")?, "the node number")?;
        let degree_of_freedom = items.need("the degree of freedom")?.component()?;
        let magnitude = items.number()?.unwrap_or(0.0);
        items.end("a node or node set, a degree of freedom and a velocity")?;
        deck.scene.initial_velocities.push(InitialVelocity { target, degree_of_freedom, magnitude });
    }
    Ok(())
}

pub(super) fn concentrated_load(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let applied = application(deck, keyword, ConditionKind::ConcentratedLoad)?;
    while let Some(line) = deck.lexer.row()? {
        let mut items = line.items();
        let target = target(&items.need("the node or node set")?, "the node number")?;
        let degree_of_freedom = any_degree_of_freedom(&items.need("the degree of freedom")?)?;
        let magnitude = items.number()?.unwrap_or(0.0);
        items.end("a node or node set, a degree of freedom and a magnitude")?;
        if !is_mechanical(degree_of_freedom) {
            deck.scene
                .skipped
                .count(format!("*CLOAD of degree of freedom {degree_of_freedom}"), line.span.line());
            continue;
        }
        step_of(&mut deck.step, keyword)?.concentrated_loads.push(ConcentratedLoad {
            target,
            degree_of_freedom,
            magnitude,
            applied: applied.clone(),
        });
    }
    Ok(())
}

pub(super) fn distributed_load(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let applied = application(deck, keyword, ConditionKind::DistributedLoad)?;
    while let Some(line) = deck.lexer.row()? {
        let mut items = line.items();
        let target = items.maybe().map(|item| target(&item, "the element number")).transpose()?;
        let label = items.need("the label of the load")?.name()?.value;
        let mut values = Vec::new();
        for item in items {
            values.push(if item.text.is_empty() { None } else { Some(item.number()?) });
        }
        if label == "GRAV" {
            let direction = values.get(1..).unwrap_or_default();
            let is_given = values.first().is_some_and(Option::is_some) && values.len() <= 4;
            if !is_given || direction.iter().all(Option::is_none) {
                let message = "GRAV takes a magnitude and a direction";
                return Err(Diagnostic::error(
                    Code::MissingData,
                    line.span,
                    message,
                    "needs three or four numbers",
                )
                .help(["write: set, GRAV, g, x, y, z", "write values = [g, x, y, z]"]));
            }
            // In a plane there is no z, and a blank is zero.
            values.resize(4, None);
            values.iter_mut().for_each(|value| *value = value.or(Some(0.0)));
        }
        let load = DistributedLoad { target, label, values, applied: applied.clone() };
        step_of(&mut deck.step, keyword)?.distributed_loads.push(load);
    }
    Ok(())
}

/// Why the values of an amplitude are not in the deck, if they are not: a subroutine or the solution gives them, or a file that is not there.
fn not_in_deck(deck: &mut Deck<'_>, keyword: &Keyword) -> Option<String> {
    if keyword.has("USER") {
        return Some("USER".to_owned());
    }
    let definition = keyword.get("DEFINITION").map(|value| normal(value.text()));
    let known = AmplitudeDefinition::SPELLINGS;
    let other = definition
        .filter(|word| begun(word, known).is_none() && nearest(word, known.iter().copied()).is_none());
    if let Some(word) = other {
        return Some(format!("DEFINITION={word}"));
    }
    let input = keyword.get("INPUT")?;
    deck.lexer.include(input).err().map(|_| format!("INPUT={}", input.text()))
}

pub(super) fn amplitude(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let name = keyword.need_name("NAME")?;
    if let Some(first) = deck.scene.amplitudes.get(&name.value) {
        return Err(keyword.duplicate(&name, first.span));
    }
    if let Some(why) = not_in_deck(deck, keyword) {
        return unread::amplitude(deck, keyword, &why);
    }
    match amplitude_of(deck, keyword, &name.value) {
        Ok(amplitude) => drop(deck.scene.amplitudes.insert(name.value, amplitude)),
        Err(error) if is_fatal(error.code()) => return Err(error),
        Err(error) => {
            deck.lexer.skip()?;
            unread::faulty_amplitude(deck, name.value, keyword.span, error);
        }
    }
    Ok(())
}

/// The amplitude of the lines that follow.
fn amplitude_of(deck: &mut Deck<'_>, keyword: &Keyword, name: &str) -> Result<Amplitude> {
    let definition = keyword.choice("DEFINITION")?.unwrap_or(AmplitudeDefinition::Tabular);
    let pairs = definition.has_pairs();
    let mut data = Vec::new();
    let mut place = keyword.span;
    let mut before: Option<f64> = None;
    while let Some(line) = deck.lexer.row()? {
        place = line.span;
        let mut items = line.items();
        for item in items.by_ref().take(8) {
            let value = if item.text.is_empty() { None } else { Some(item.number()?) };
            if pairs && data.len() % 2 == 0 {
                if let (Some(before), Some(now)) = (before, value)
                    && now < before
                {
                    let message = format!("time goes back from {before} to {now}");
                    return Err(Diagnostic::error(Code::TableOrder, item.span, message, "must not decrease")
                        .help("order the pairs so that time increases"));
                }
                before = value;
            }
            data.push(value);
        }
        items.end("at most eight numbers")?;
        // N, ω, t0 and A0 have a line of their own, whose last numbers may be blank.
        if definition == AmplitudeDefinition::Periodic {
            data.resize(data.len().max(4), None);
        }
    }
    if pairs && (data.is_empty() || data.len() % 2 == 1 || data.iter().any(Option::is_none)) {
        let message = format!("amplitude {name} needs pairs of time and value");
        return Err(Diagnostic::error(Code::MissingData, place, message, "a number is missing")
            .help("write time, value, time, value …"));
    }
    Ok(Amplitude {
        definition,
        time: keyword.choice("TIME")?,
        value: keyword.choice("VALUE")?,
        smooth: keyword.number("SMOOTH")?,
        fixed_interval: keyword.number("FIXED INTERVAL")?,
        begin: keyword.number("BEGIN")?,
        data,
        span: keyword.span,
    })
}

pub(super) fn step(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    if let Some(open) = &deck.step {
        let message = format!("a step begins within the step of line {}", open.span.line());
        return Err(Diagnostic::error(Code::UnfinishedStep, keyword.span, message, "the next step")
            .help("close the step before by *END STEP"));
    }
    let nlgeom = keyword
        .has("NLGEOM")
        .then(|| keyword.get("NLGEOM").is_none_or(|value| normal(value.text()) == "YES"));
    let step = Step {
        name: keyword.name_of("NAME")?.map(|name| name.value),
        nlgeom,
        perturbation: keyword.has("PERTURBATION"),
        default_amplitude: keyword.choice("AMPLITUDE")?,
        increments: keyword.get("INC").map(|value| value.integer("INC")).transpose()?,
        span: keyword.span,
        ..Step::default()
    };
    while deck.lexer.text()?.is_some() {
        deck.scene.skipped.count("text below *STEP".to_owned(), keyword.span.line());
    }
    (deck.step, deck.stepped) = (Some(step), true);
    Ok(())
}

pub(super) fn end_step(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let Some(step) = deck.step.take() else {
        return Err(Diagnostic::error(
            Code::HistoryOutsideStep,
            keyword.span,
            "no step is open",
            "closes nothing",
        )
        .help("remove it, or begin the step by *STEP"));
    };
    deck.scene.steps.push(step);
    Ok(())
}

/// Notes what a step does; a second procedure is an error.
pub(super) fn set_procedure(step: &mut Step, procedure: Procedure, keyword: &Keyword) -> Result<()> {
    if step.procedure.is_some() {
        return Err(Diagnostic::error(
            Code::TwoProcedures,
            keyword.span,
            "a step has two procedures",
            "the second one",
        )
        .help(["close the step by *END STEP and begin another one", "make two steps of it"]));
    }
    step.procedure = Some(procedure);
    Ok(())
}

fn times(deck: &mut Deck<'_>) -> Result<Times> {
    let Some(line) = deck.lexer.data()? else { return Ok(Times::default()) };
    let mut items = line.items();
    let mut values = [None; 4];
    let mut unread = None;
    for value in &mut values {
        let Some(item) = items.maybe() else { continue };
        // No connector depends on how long a step is.
        match item.number() {
            Err(error) if item.is_parameter() => unread = Some(error),
            number => *value = Some(number?),
        }
    }
    // Of *STATIC, RIKS the largest load factor, and a node or set whose displacement ends the step.
    let further = items.filter(|item| !item.text.is_empty()).count();
    let [initial, total, minimum, maximum] = values;
    let line = line.span;
    if let Some(negative) = [initial, total, minimum, maximum].into_iter().flatten().find(|time| *time < 0.0)
    {
        let message = format!("a time is negative: {negative}");
        return Err(Diagnostic::error(Code::NumberOutOfRange, line, message, "must not be negative")
            .help("write: initial, total, minimum, maximum time"));
    }
    if let Some(error) = unread {
        deck.unread.fault(unread::Bears::Nothing, error);
    }
    for _ in 0..further {
        deck.scene.skipped.count("further numbers of a procedure".to_owned(), line.line());
    }
    Ok(Times { initial, total, minimum, maximum })
}

fn set_solver(deck: &mut Deck<'_>, solver: Solver, keyword: &Keyword) -> Result<()> {
    if deck.scene.solver.is_some_and(|before| before != solver) {
        let message = ["deck", "scene"]
            .map(|deck| format!("one {deck} cannot have explicit dynamics and other procedures"));
        return Err(Diagnostic::error(
            Code::MixedSolvers,
            keyword.span,
            message,
            "differs from the steps before",
        )
        .help(["make two decks of it", "make two scenes of it"]));
    }
    deck.scene.solver = Some(solver);
    Ok(())
}

pub(super) fn static_procedure(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let times = times(deck)?;
    set_procedure(step_of(&mut deck.step, keyword)?, Procedure::Static(times), keyword)?;
    set_solver(deck, Solver::Standard, keyword)
}

pub(super) fn dynamic(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let explicit = keyword.has("EXPLICIT");
    let times = times(deck)?;
    set_procedure(step_of(&mut deck.step, keyword)?, Procedure::Dynamic { explicit, times }, keyword)?;
    set_solver(deck, if explicit { Solver::Explicit } else { Solver::Standard }, keyword)
}

pub(super) fn output(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let mut parameters = IndexMap::new();
    for parameter in
        keyword.parameters.iter().filter(|given| !["ELSET", "NSET"].contains(&given.name.as_str()))
    {
        parameters
            .insert(parameter.name.clone(), parameter.value.as_ref().map(|value| value.text().to_owned()));
    }
    let mut variables = Vec::new();
    while let Some(line) = deck.lexer.row()? {
        variables.extend(line.items().filter(|item| !item.text.is_empty()).map(|item| normal(item.text)));
    }
    let request = OutputRequest {
        keyword: keyword.name.clone(),
        parameters,
        element_set: keyword.name_of("ELSET")?,
        node_set: keyword.name_of("NSET")?,
        variables,
        span: keyword.span,
    };
    step_of(&mut deck.step, keyword)?.outputs.push(request);
    Ok(())
}
