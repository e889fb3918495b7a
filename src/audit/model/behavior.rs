//! Does what is attached to components act as it looks? Stops that are passed, initially, by a motion or at a state; locks that are passed
//! initially or never met; entries that are ignored, frictions that vanish, behaviours that nothing names.

use crate::model::certainty::{Certainty, Open};
use crate::model::finding::{About, Finding};
use crate::model::gather::Gathered;
use crate::model::geometry::{at_start, initial_positions};
use crate::model::levels::Levels;
use crate::model::pressing::nothing_presses;
use pintle_kinematics::catalog::{
    COMPONENT, Contact, FrictionCriterion, Load, PLANE, Quantity, SPATIAL, Traction, component_index,
};
use pintle_kinematics::connector::{Components, State};
use pintle_kinematics::scalar::U;
use pintle_model::behavior::drive::{Prescribed, Schedule};
use pintle_model::behavior::entry;
use pintle_model::behavior::friction::Coefficient;
use pintle_model::evaluate::{ConnectorElement, Model};
use pintle_scene as scene;
use pintle_scene::grammar::agree;
use pintle_scene::grammar::number as short;
use pintle_scene::{
    Behavior, Code, Digits, Extrapolation, FrictionKind, FrictionLaw, Law, Limits, Scene, Severity, Span,
    TableRow,
};
use std::collections::HashSet;

/// What is found of the behaviours of connectors.
pub(super) fn findings(scene: &Scene, model: &Model, levels: &Levels) -> Vec<Finding> {
    let (mut gathered, mut by_motions) = (Gathered::new(levels), Gathered::new(levels));
    let certainty = Certainty::of(scene);
    for element in &model.connectors {
        let Some(given) = scene.connectors.get(&element.label) else { continue };
        let Some(behavior) = scene.section(given).and_then(|section| scene.behavior(section)) else {
            continue;
        };
        let needs_positions =
            !behavior.stops.is_empty() || !behavior.locks.is_empty() || !behavior.failures.is_empty();
        let positions = if needs_positions { initial_positions(element) } else { [None; 6] };
        let at = Placed { scene, element, positions: &positions, state: &at_start(element), number: None };
        // Which of its laws each is of.
        let mut found: Vec<(Option<usize>, Finding)> = Vec::new();
        for (place, stop) in behavior.stops.iter().enumerate() {
            let beyond = beyond_stop(&at, stop, &certainty);
            found.extend(beyond.map(|beyond| (Some(place), violated(&at, stop, &beyond))));
            let led = led_beyond(&at, stop, &model.schedule, &certainty);
            if let Some(finding) = led {
                by_motions.add((given.section, Some(place)), element.label, finding, |new, old| {
                    new.value > old.value
                });
            }
        }
        for (place, law) in limited(behavior).enumerate() {
            found.extend(passed_or_idle(&at, &law, &certainty).map(|finding| (Some(place), finding)));
        }
        found.extend(ignored(scene, element, behavior).map(|finding| (None, finding)));
        for (place, friction) in behavior.friction.iter().enumerate() {
            let lost = vanishing(scene, element, behavior, friction);
            found.extend(lost.into_iter().map(|finding| (Some(place), finding)));
        }
        for (law, finding) in found {
            let of = (given.section, law);
            gathered.add(of, element.label, finding, |new, old| new.value > old.value);
        }
    }
    gathered.findings().chain(by_motions.findings()).chain(unused(scene)).collect()
}

/// Behaviours that no section names, each once for all instances of its part.
fn unused(scene: &Scene) -> impl Iterator<Item = Finding> {
    let names = scene.connector_sections.iter().filter_map(|section| section.behavior.as_ref());
    let named: HashSet<&str> = names.map(|name| name.value.as_str()).collect();
    let mut told = HashSet::new();
    let unused = scene.behaviors.iter().filter(move |(name, behavior)| {
        !named.contains(name.as_str()) && (told.insert(behavior.span) || !behavior.span.is_known())
    });
    unused.map(|(name, behavior)| {
        let message = format!("no section names the behaviour {name}: it acts on no connector");
        let reason = "a behaviour acts on the connectors of the sections that name it";
        let remedy = ["BEHAVIOR= of a *CONNECTOR SECTION", "behavior of one of connector_sections"]
            .map(|place| format!("name it by {place}, or remove it"));
        Finding::new(scene, Code::ModelUnusedBehavior, behavior.span, message, reason, remedy)
    })
}

fn about(element: &ConnectorElement, component: usize, value: f64) -> About {
    let components = vec![COMPONENT[component].to_string()];
    About { elements: vec![element.label], components, value: Some(value), ..About::default() }
}

/// A connector at the initial state, or at one that is given, of this number.
pub(super) struct Placed<'a> {
    pub(super) scene: &'a Scene,
    pub(super) element: &'a ConnectorElement,
    pub(super) positions: &'a Components<f64>,
    pub(super) state: &'a State<f64>,
    pub(super) number: Option<u64>,
}

/// Stops that a state passes by more than the solver of that state may leave (`slack`), each with its place among those of the behaviour. Those
/// that are passed initially already, as far, on the same side and as certainly, are left out.
pub(super) fn violated_at_state(
    at: &Placed<'_>,
    certainty: &Certainty<'_>,
    slack: impl Fn(usize) -> f64,
) -> Vec<(usize, Finding)> {
    let Placed { scene, element, .. } = *at;
    let section = scene.connectors.get(&element.label).and_then(|given| scene.section(given));
    let Some(behavior) = section.and_then(|section| scene.behavior(section)) else { return Vec::new() };
    let new = |(place, stop): (usize, &scene::Stop)| {
        let beyond = beyond_stop(at, stop, certainty).filter(|beyond| beyond.by > slack(beyond.component))?;
        let positions = initial_positions(element);
        let initially =
            Placed { scene, element, positions: &positions, state: &at_start(element), number: None };
        let is_known =
            beyond_stop(&initially, stop, certainty).is_some_and(|initial| !beyond.is_worse_than(&initial));
        (!is_known).then(|| (place, violated(at, stop, &beyond)))
    };
    behavior.stops.iter().enumerate().filter_map(new).collect()
}

/// A stop beyond which a connector motion leads, farther than the component lies initially: at the worst of the times at which the motion is not smooth.
fn led_beyond(
    at: &Placed<'_>,
    stop: &scene::Stop,
    schedule: &Schedule,
    certainty: &Certainty<'_>,
) -> Option<Finding> {
    let Placed { scene, element, .. } = *at;
    let k = component_index(stop.component)?;
    let (start, drive) = (at.positions[k]?, element.behavior.drives.motions[k].as_ref()?);
    let in_step = |step: usize| {
        let [begin, end] = schedule.span(step).map_or([0.0; 2], |(span, _)| span);
        let within = drive.breaks(step).into_iter().filter(move |time| begin < *time && *time < end);
        within.chain([end]).map(move |time| (step, time))
    };
    let led = (0..schedule.len()).flat_map(in_step).filter_map(|(step, time)| {
        let Some(Prescribed::Displacement(by)) = drive.within::<f64>(schedule, step, time, |_| None) else {
            return None;
        };
        let beyond = Beyond::of(at, (k, start + by), [stop.lower, stop.upper], certainty)?;
        (beyond.by > Digits::of_number(by)).then_some((beyond, time))
    });
    let (worst, time) = led.max_by(|(one, _), (other, _)| one.by.total_cmp(&other.by))?;
    if beyond_stop(at, stop, certainty).is_some_and(|initial| !worst.is_worse_than(&initial)) {
        return None;
    }
    let Beyond { position, by, side, limit, .. } = worst;
    let message = format!(
        "element {}: a connector motion leads {} to {position} at time {time}, {by} {side} its stop at {limit}{}",
        element.label,
        COMPONENT[k],
        worst.in_words(None),
        by = short(by, 4),
        position = short(position, 7),
        time = short(time, 7)
    );
    let reason = "a motion gives the displacement from the initial position (CU); stops limit the position (CP); angles in rad";
    let remedy = "move the stop, or end the motion before it";
    let finding = Finding::new(scene, Code::ModelStopViolated, stop.span, message, reason, remedy);
    Some(worst.judged(finding).about(about(element, k, by)))
}

/// A limit that a position lies beyond, by more than rounding can make it.
struct Beyond {
    /// The component (0-based).
    component: usize,
    position: f64,
    by: f64,
    side: &'static str,
    limit: f64,
    /// How much of it rounding may be.
    rounding: f64,
    /// Whether the digits of the numbers that are given leave open that it does not.
    is_open: bool,
}

impl Beyond {
    /// Of component k, at a position between limits.
    fn of(
        at: &Placed<'_>,
        (k, position): (usize, f64),
        [lower, upper]: [Option<f64>; 2],
        certainty: &Certainty<'_>,
    ) -> Option<Self> {
        let below = lower.filter(|lower| position < *lower).map(|lower| (lower - position, "below", lower));
        let above = upper.filter(|upper| position > *upper).map(|upper| (position - upper, "above", upper));
        let (by, side, limit) = below.or(above)?;
        let Open { rounding, digits } = certainty.open(at.element, at.state, (k, position, limit));
        let is_open = by <= rounding + digits;
        (by > rounding).then_some(Self { component: k, position, by, side, limit, rounding, is_open })
    }

    /// Whether it is farther beyond than at another position, on another side, or certain where that is open.
    fn is_worse_than(&self, other: &Self) -> bool {
        let is_farther = self.by - other.by > self.rounding + other.rounding;
        is_farther || self.side != other.side || (other.is_open && !self.is_open)
    }

    /// What a message ends with, where it is open.
    const fn in_words(&self, state: Option<u64>) -> &'static str {
        match (self.is_open, state) {
            (false, _) => "",
            (true, None) => ": no more than the digits of the coordinates and of the limit leave open",
            (true, Some(_)) => {
                ": no more than the digits of the coordinates, of the state and of the limit leave open"
            }
        }
    }

    /// A finding, which is a note where it is open.
    fn judged(&self, finding: Finding) -> Finding {
        if self.is_open { finding.of_severity(Severity::Note) } else { finding }
    }
}

/// How far the position lies beyond a stop.
fn beyond_stop(at: &Placed<'_>, stop: &scene::Stop, certainty: &Certainty<'_>) -> Option<Beyond> {
    let k = component_index(stop.component)?;
    Beyond::of(at, (k, at.positions[k]?), [stop.lower, stop.upper], certainty)
}

/// A stop that the position lies beyond.
fn violated(at: &Placed<'_>, stop: &scene::Stop, beyond: &Beyond) -> Finding {
    let Placed { scene, element, number, .. } = *at;
    let Beyond { component: k, position, by, side, limit, .. } = *beyond;
    let when = match number {
        None => "initially".to_string(),
        Some(state) => format!("at state {state}"),
    };
    let message = format!(
        "element {}: {} is {position} {when}, {by} {side} its stop at {limit}{}",
        element.label,
        COMPONENT[k],
        beyond.in_words(number),
        by = short(by, 4),
        position = short(position, 7)
    );
    let reason = "stops limit the position (CP), not the displacement from the initial one; angles in rad";
    let remedy = match number {
        None => "move the stop or the nodes, so that the initial position lies within",
        Some(_) => "move the stop, or check that the states are those of this model, and their units",
    };
    let finding = Finding::new(scene, Code::ModelStopViolated, stop.span, message, reason, remedy);
    beyond.judged(finding).about(About { state: number, ..about(element, k, by) })
}

/// A lock or failure, by what triggers it.
struct Limited<'a> {
    what: &'static str,
    component: u8,
    rows: &'a [Limits],
    /// What limits are beyond the rows.
    extrapolation: Option<Extrapolation>,
    span: Span,
}

impl Limited<'_> {
    /// Whether limits go on beyond the rows.
    fn is_linear(&self) -> bool {
        self.extrapolation == Some(Extrapolation::Linear)
    }
}

/// The locks of a behaviour, then its failures.
fn limited(behavior: &Behavior) -> impl Iterator<Item = Limited<'_>> {
    let of_behavior = behavior.table.extrapolation;
    let locks = behavior.locks.iter().map(move |lock| Limited {
        what: "lock",
        component: lock.component,
        rows: &lock.limits,
        extrapolation: lock.table.extrapolation.or(of_behavior),
        span: lock.span,
    });
    let failures = behavior.failures.iter().map(move |failure| Limited {
        what: "failure",
        component: failure.component,
        rows: &failure.limits,
        extrapolation: of_behavior,
        span: failure.span,
    });
    locks.chain(failures)
}

/// A lock or failure of which a limit of position is passed initially, or none ever.
fn passed_or_idle(at: &Placed<'_>, law: &Limited<'_>, certainty: &Certainty<'_>) -> Option<Finding> {
    let k = component_index(law.component)?;
    let position = at.positions[k]?;
    let beyond =
        |row: &Limits| Beyond::of(at, (k, position), [row.lower_position, row.upper_position], certainty);
    let rows: Vec<Option<Beyond>> = law.rows.iter().map(beyond).collect();
    let told = law.rows.iter().zip(&rows).filter_map(|(row, beyond)| Some((row, beyond.as_ref()?)));
    let farther = |one: &(&Limits, &Beyond), other: &(&Limits, &Beyond)| one.1.by.total_cmp(&other.1.by);
    let Some((row, most)) = told.clone().max_by(farther) else {
        return idle(at, law, (k, position));
    };
    // Between rows limits lie between theirs.
    let is_alike = |one: &Beyond| one.side == most.side && (!law.is_linear() || one.limit == most.limit);
    let is_always = rows.iter().all(|one| one.as_ref().is_some_and(is_alike));
    if is_always {
        let (_, least) = told.min_by(farther)?;
        return Some(passed(at, law, least, ""));
    }
    let finding = passed(at, law, most, &conditions(row));
    Some(finding.of_severity(Severity::Note))
}

/// The temperature and field variables of a row.
fn conditions(row: &Limits) -> String {
    let temperature = row.temperature.map(|value| format!("temperature {value}"));
    let fields = row.fields.iter().enumerate();
    let fields =
        fields.filter_map(|(i, value)| value.map(|value| format!("field variable {} of {value}", i + 1)));
    let all: Vec<String> = temperature.into_iter().chain(fields).collect();
    format!(" at {}, but not always", all.join(" and "))
}

/// A lock or failure of which a limit of position is passed initially, under conditions.
fn passed(at: &Placed<'_>, law: &Limited<'_>, beyond: &Beyond, conditions: &str) -> Finding {
    let Placed { scene, element, .. } = *at;
    let Beyond { component: k, position, by, limit, .. } = *beyond;
    let what = law.what;
    let message = format!(
        "element {}: {} is {position} initially, {by} beyond the limit {limit} of a {what}, which acts from the start{conditions}{}",
        element.label,
        COMPONENT[k],
        beyond.in_words(None),
        by = short(by, 4),
        position = short(position, 7)
    );
    let reason =
        "limits are those of the position (CP), not of the displacement from the initial one; angles in rad";
    let remedy = "move the limit or the nodes, so that the initial position lies within";
    let finding = Finding::new(scene, Code::ModelLockMet, law.span, message, reason, remedy);
    beyond.judged(finding).about(about(element, k, by))
}

/// A lock or failure of which all limits are of the position of a component that is constrained and stays within them, whatever the temperature and field
/// variables.
fn idle(at: &Placed<'_>, law: &Limited<'_>, (k, position): (usize, f64)) -> Option<Finding> {
    let Placed { scene, element, .. } = *at;
    let of_force = |row: &Limits| row.lower_force.is_some() || row.upper_force.is_some();
    let of_position = |row: &Limits| row.lower_position.is_some() || row.upper_position.is_some();
    let limits = |row: &Limits| [row.lower_position, row.upper_position];
    let varies = law.rows.windows(2).any(|pair| limits(&pair[0]) != limits(&pair[1]));
    let may_act =
        (law.is_linear() && varies) || law.rows.iter().any(of_force) || !law.rows.iter().any(of_position);
    if may_act || !element.connector.is_constrained(k) {
        return None;
    }
    let (name, what) = (COMPONENT[k], law.what);
    let message = format!(
        "element {}: a {what} is triggered by the position of {name} alone, which {} constrains: it stays at {position}, within the limits",
        element.label,
        element.connector.connection().name,
        position = short(position, 7)
    );
    let reason = "what is constrained does not move, so that its position passes no limit";
    let remedy = "limit the force of the component, or the position of one that is available";
    let finding = Finding::new(scene, Code::ModelLimitUnreachable, law.span, message, reason, remedy);
    let about =
        About { elements: vec![element.label], components: vec![name.to_string()], ..About::default() };
    Some(finding.about(about))
}

/// Entries of coupled tables, not zero, for components that are not available: they are ignored.
fn ignored(scene: &Scene, element: &ConnectorElement, behavior: &Behavior) -> Option<Finding> {
    /// The entries that a message names.
    const NAMED: usize = 8;
    let present = if element.is_planar() { PLANE } else { SPATIAL };
    let connection = element.connector.connection();
    let is_available = |k: usize| connection.slots[k].is_available() && present[k];
    let elasticities = behavior.elasticity.iter().map(|law| ("elasticity", "D", &law.law, law.span));
    let dampings = behavior.damping.iter().map(|law| ("damping", "C", &law.law, law.span));
    let (mut told, mut place, mut count) = (Vec::new(), None, 0);
    for (what, letter, law, span) in elasticities.chain(dampings) {
        let Law::Coupled { unsymmetric, rows, .. } = law else { continue };
        let is_given = |at: usize| {
            rows.iter().any(|row| row.values.get(at).copied().flatten().is_some_and(|value| value != 0.0))
        };
        let pairs = (0..6).flat_map(|j| (0..6).map(move |i| (i, j)));
        let names: Vec<String> = pairs
            .filter(|(i, j)| *unsymmetric || i <= j)
            .filter(|(i, j)| !(is_available(*i) && is_available(*j)) && is_given(entry(*unsymmetric, *i, *j)))
            .map(|(i, j)| format!("{letter}{}{}", i + 1, j + 1))
            .collect();
        if names.is_empty() {
            continue;
        }
        count += names.len();
        place = place.or(Some(span));
        let more = match names.len().saturating_sub(NAMED) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        told.push(format!("{} of its coupled {what}{more}", names[..names.len().min(NAMED)].join(", ")));
    }
    let unavailable = (0..6).filter(|k| !is_available(*k)).map(|k| COMPONENT[k].to_string()).collect();
    let message = format!(
        "element {}: {} {} ignored, for {} does not leave all of their components available",
        element.label,
        told.join(", and "),
        agree(count, ["is", "are"]),
        connection.name
    );
    let reason = "a coupled matrix acts between available components only; entries of others are left out, whatever they are";
    let remedy = "write 0 for them, or choose a type that leaves the components available";
    let finding = Finding::new(scene, Code::ModelEntriesIgnored, place?, message, reason, remedy);
    let about = About {
        elements: vec![element.label],
        components: unavailable,
        value: Some(f64::from(u32::try_from(count).unwrap_or(u32::MAX))),
        ..About::default()
    };
    Some(finding.about(about))
}

/// Where a friction coefficient is zero: by the symbol of the number that makes it so.
#[derive(Default)]
struct Gone {
    always: bool,
    at_rest: Option<&'static str>,
    in_fast_slip: Option<&'static str>,
    /// What is left of the coefficient where it is zero at rest, and where in fast slip.
    formulas: [&'static str; 2],
}

impl Gone {
    fn of(law: &FrictionLaw) -> Self {
        let decays = |[first, last]: [f64; 2], decay: f64, symbols: [&'static str; 2], formulas| {
            // What test data give at their end is computed.
            let is_zero = |x: f64| x.abs() <= 4.0 * U * first.abs().max(last.abs());
            let at_rest = is_zero(first).then_some(symbols[0]);
            let in_fast_slip = if decay == 0.0 { at_rest } else { is_zero(last).then_some(symbols[1]) };
            Self { always: at_rest.is_some() && in_fast_slip.is_some(), at_rest, in_fast_slip, formulas }
        };
        match law {
            FrictionLaw::Table(rows) => Self::of_table(rows),
            FrictionLaw::Exponential { static_coefficient, kinetic_coefficient, decay } => {
                let formulas = [
                    "μ = μ_k (1 − exp(−d_c·slip rate)), without the term of μ_s",
                    "μ = μ_s exp(−d_c·slip rate), without the term of μ_k",
                ];
                decays([*static_coefficient, *kinetic_coefficient], *decay, ["μ_s", "μ_k"], formulas)
            }
            FrictionLaw::TestData(rows) => {
                let item = |row: usize, column: usize| rows.get(row)?.get(column).copied().flatten();
                let (Some(first), Some(second), Some(rate)) = (item(0, 0), item(1, 0), item(1, 1)) else {
                    return Self::default();
                };
                match Coefficient::test_data(first, (second, rate), item(2, 0)) {
                    Ok(Coefficient::Exponential { at_rest, kinetic, decay }) => {
                        let formulas = [
                            "μ = μ_∞ (1 − exp(−d_c·slip rate)), without the term of μ_1",
                            "μ = μ_1 exp(−d_c·slip rate), without the term of μ_∞",
                        ];
                        decays([at_rest, kinetic], decay, ["μ_1", "μ_∞"], formulas)
                    }
                    // What is no law is refused where it is read.
                    _ => Self::default(),
                }
            }
        }
    }

    /// Of a table, whose columns are μ, the slip rate and the contact force: beyond its rows the coefficient is that of the nearest. What vanishes at rest or in
    /// fast slip does so at every contact force, temperature and field variable.
    fn of_table(rows: &[TableRow]) -> Self {
        let of = |row: &TableRow, column: usize| row.values.get(column).copied().flatten().unwrap_or(0.0);
        let others = |row: &TableRow| (of(row, 2), row.temperature, row.fields.clone());
        let is_alike = |one: &TableRow, other: &TableRow| others(one) == others(other);
        // Slip rates increase within each, for they run fastest.
        let curves = || rows.chunk_by(is_alike);
        let is_gone = |row: Option<&TableRow>| row.is_none_or(|row| of(row, 0) == 0.0);
        Self {
            always: !rows.is_empty() && rows.iter().all(|row| of(row, 0) == 0.0),
            at_rest: (!rows.is_empty() && curves().all(|curve| is_gone(curve.first()))).then_some("μ(0)"),
            in_fast_slip: (!rows.is_empty() && curves().all(|curve| is_gone(curve.last()))).then_some("μ(∞)"),
            formulas: [
                "μ of the rows of the least slip rate holds below it",
                "μ of the rows of the largest slip rate holds beyond it",
            ],
        }
    }
}

/// What of a friction vanishes.
fn vanishing(
    scene: &Scene,
    element: &ConnectorElement,
    behavior: &Behavior,
    friction: &scene::Friction,
) -> Vec<Finding> {
    let mut found = Vec::new();
    // Frictions of several components are told each by itself.
    let slides = match &friction.kind {
        FrictionKind::User { component: Some(component), .. } => component_index(*component),
        _ => None,
    };
    let mut tell = |what: String, reason: &str, remedy: &str, component: String| {
        let message = format!("element {}: {what}", element.label);
        let finding =
            Finding::new(scene, Code::ModelFrictionVanishes, friction.span, message, reason, remedy);
        let mut components = vec![component];
        components.extend(slides.map(|k| COMPONENT[k].to_string()));
        found.push(finding.about(About { elements: vec![element.label], components, ..About::default() }));
    };
    if let Some(coefficient) = &friction.coefficient {
        let gone = Gone::of(&coefficient.law);
        if gone.always {
            tell(
                "the friction coefficient is zero: there is no friction".into(),
                "μ = 0",
                "give μ, or remove the friction",
                "μ".into(),
            );
        }
        if let Some(symbol) = gone.in_fast_slip.filter(|_| !gone.always) {
            tell(
                "the kinetic friction coefficient is zero: friction vanishes the faster it slips".into(),
                gone.formulas[1],
                &format!("give {symbol}, unless friction is meant to vanish in fast slip"),
                symbol.into(),
            );
        }
        if let Some(symbol) = gone.at_rest.filter(|_| !gone.always) {
            tell(
                "the static friction coefficient is zero: there is no friction at rest, nothing sticks"
                    .into(),
                gone.formulas[0],
                &format!("give {symbol}, unless friction is meant to begin with slip"),
                symbol.into(),
            );
        }
        if !gone.always && coefficient.maximum == Some(0.0) {
            tell(
                "TAUMAX is zero: there is no friction".into(),
                "τ ≤ τ_max",
                "leave TAUMAX out, or give it",
                "τ_max".into(),
            );
        }
    }
    match &friction.kind {
        FrictionKind::Predefined { constants } => {
            let Some(of_type) = element.connector.connection().friction else { return found };
            let section = scene.connectors.get(&element.label).and_then(|given| scene.section(given));
            let angle = section.and_then(|section| section.section_data.get(1).copied().flatten());
            if element.connector.connection().is_belt() && angle == Some(0.0) {
                tell(
                    "the contact angle of the section is zero: the belt goes straight on at node b, and there is no friction".into(),
                    "F_C (exp(μ α) − 1) with α = 0",
                    "give the angle of wrap (rad) as the second number of the section, or remove the friction",
                    "α".into(),
                );
            }
            let present = if element.is_planar() { PLANE } else { SPATIAL };
            for (i, parameter) in of_type.parameters.iter().enumerate() {
                if constants.get(i).copied().flatten().unwrap_or(0.0) != 0.0 {
                    continue;
                }
                let lost: Vec<String> =
                    of_type.criteria.iter().flat_map(|criterion| lost(criterion, i, present)).collect();
                if lost.is_empty() {
                    continue;
                }
                let what = format!(
                    "{} of the predefined friction is {}: {}",
                    parameter.symbol,
                    if constants.get(i).copied().flatten().is_some() { "zero" } else { "left out, so zero" },
                    lost.join("; ")
                );
                let reason =
                    "a term that is multiplied by a parameter that is zero, or divided by one, is left out";
                tell(
                    what,
                    reason,
                    "give the parameter, unless the term is meant to vanish",
                    parameter.symbol.into(),
                );
            }
        }
        FrictionKind::User { contact_force: None, rows, .. } => {
            let is_zero = rows.iter().flatten().all(|value| value.unwrap_or(0.0) == 0.0);
            if is_zero {
                let what =
                    "neither a contact force nor an internal one is given: nothing presses".to_string();
                tell(
                    what,
                    "F_N = |F_C + F_C^int| = 0",
                    "name CONTACT FORCE, or give the internal contact force",
                    "F_N".into(),
                );
            }
        }
        FrictionKind::User { contact_force: Some(source), rows, .. } => {
            if let Some(why) = nothing_presses(element, behavior, &source.value) {
                // Items: radius, internal contact force …
                let is_internal =
                    rows.iter().any(|row| row.get(1).copied().flatten().is_some_and(|value| value != 0.0));
                let rest =
                    if is_internal { "only the internal contact force presses" } else { "nothing presses" };
                tell(
                    format!("the contact force is always zero, for {why}: {rest}"),
                    "F_N = |F_C + F_C^int| with F_C = 0",
                    "give the derived component factors that are not zero, of components that have a force, or name another contact force",
                    "F_C".into(),
                );
            }
        }
    }
    found
}

/// What of a criterion vanishes where parameter `i` is zero.
fn lost(criterion: &FrictionCriterion, i: usize, present: [bool; 6]) -> Vec<String> {
    let is = |quantity: &Quantity| *quantity == Quantity::Parameter(i);
    let feels = |load: &Load| Some(format!("the contact force does not feel {}", load.formula(present)?));
    let mut lost = Vec::new();
    if let Contact::Sum { arm, terms } = criterion.contact {
        if arm.iter().any(is) {
            lost.push("nothing but an internal contact force presses".to_string());
        } else {
            let gone =
                terms.iter().filter(|term| term.factor.over == Some(i) || term.factor.times.iter().any(is));
            lost.extend(gone.filter_map(|term| feels(&term.load)));
        }
    }
    let of_radius = |traction: &&Traction| traction.radius == Some(i) && present[traction.component];
    lost.extend(
        criterion
            .traction
            .iter()
            .filter(of_radius)
            .map(|traction| format!("{} meets no friction", COMPONENT[traction.component])),
    );
    lost
}
