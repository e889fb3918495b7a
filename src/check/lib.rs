//! Somebody's element routine in a process of its own: asked line by line, judged by the audit.
//!
//! | module | question |
//! |---|---|
//! | `protocol` | what is sent, and what must come back? |
//! | `convention` | in which order, unit and frame does the routine answer? |
//! | [`fit`] | and if it does not say so: which conventions fit its numbers? |
//! | `exchange` | which messages are exchanged? |
//! | `payload` | and as bytes, where a routine announces it? |
//! | `session` | what is asked of a connector, and what was answered? |
//! | `constraint` | the same of a multi-point constraint |
//! | `friction` | the same of a friction |
//! | `process` | does the process behave? |
//! | `kin` | what has it started? |
//! | `python` | how is a Python function asked? |
//!
//! The audit judges; nothing here does.

mod constraint;
mod convention;
mod exchange;
pub mod fit;
mod friction;
mod kin;
mod payload;
mod process;
mod protocol;
mod python;
mod session;

pub use convention::{
    Angle, Axes, Convention, Forces, Frame, Positions, Quaternions, Sense, Stiffness, Storage, Triads, Turns,
    Variation, Variations, is_vector,
};
pub use process::{Door, Misbehaviour, Patience, Process};
pub use protocol::{OFFERS, PROTOCOL, answers_of_file};
pub use python::{DRIVER, command as python_command};
pub use session::Session;

use pintle_audit::{
    Candidate, Case, Domain, FrictionSubject, MpcCase, Quantity, Question, Report, Settings, Step,
};
use pintle_kinematics::connector::{Definition, State};
use pintle_kinematics::mpc::Constraint;

/// What a routine is to be.
#[derive(Clone, Debug)]
pub enum Subject {
    /// A connector, and the states at which it is asked; none for drawn ones.
    Connector(Box<Definition>, Vec<Case>),
    /// A multi-point constraint, and such states.
    Constraint(Box<Constraint<f64>>, Vec<MpcCase>),
    /// A friction.
    Friction(Box<FrictionSubject>),
}

impl From<&Definition> for Subject {
    fn from(definition: &Definition) -> Self {
        Self::Connector(Box::new(definition.clone()), Vec::new())
    }
}

impl From<&Constraint<f64>> for Subject {
    fn from(constraint: &Constraint<f64>) -> Self {
        Self::Constraint(Box::new(*constraint), Vec::new())
    }
}

impl From<FrictionSubject> for Subject {
    fn from(friction: FrictionSubject) -> Self {
        Self::Friction(Box::new(friction))
    }
}

impl Subject {
    /// Its type.
    pub fn name(&self) -> String {
        match self {
            Self::Connector(definition, _) => definition.connection.name.to_string(),
            Self::Constraint(constraint, _) => format!("MPC {}", constraint.kind().name()),
            Self::Friction(friction) => format!("FRICTION {}", friction.name),
        }
    }
}

/// A report, and what it rests on.
#[derive(Debug)]
#[non_exhaustive]
pub struct Checked {
    /// What the audit found.
    pub report: Report,
    /// How many states were asked for.
    pub states: u64,
    /// At how many of them the routine said that it does not cover them.
    pub outside: u64,
    /// How many of the states that were drawn the domain left out.
    pub left_out: u64,
    /// At how many it continued angles on another sheet.
    pub elsewhere: u64,
    /// What it does not offer: values, rows, components of the connector.
    pub not_offered: Vec<&'static str>,
    /// At how many states it failed, and what it said at the first.
    pub failed: Option<String>,
    /// Whether it gives forces of springs that nobody gave.
    pub lacks_springs: bool,
    /// How many requests it got, for differences of its own values and all.
    pub asked: u64,
}

/// What is asked of a routine besides a connector.
#[derive(Clone, Debug)]
pub struct Asked {
    /// The states, and who judges.
    pub settings: Settings,
    /// How many of the states about the initial one end a history, where angles go on.
    pub histories: usize,
    /// In place of the conventions of its hello.
    pub convention: Option<Convention>,
    /// The stiffness D_k of each component of an element of springs.
    pub springs: [Option<f64>; 6],
    /// Where states are drawn, in place of the domain of its hello.
    pub domain: Option<Domain>,
    /// Whether to look for the simplest state at which the routine is wrong ([`pintle_audit::Check::simplest`]).
    pub simplest: bool,
    /// Which of several that are asked for this is: a part of its name in the report.
    pub among: Option<String>,
}

impl Asked {
    /// The name of a routine in the report.
    fn title(&self, name: &str) -> String {
        self.among.as_ref().map_or_else(|| name.to_string(), |among| format!("{name} for {among}"))
    }
}

impl Checked {
    /// Of what has neither domain nor turns: a constraint, a friction.
    fn without_history(
        report: Report,
        (states, outside): (u64, u64),
        not_offered: Vec<&'static str>,
        asked: u64,
    ) -> Self {
        Self {
            report,
            states,
            outside,
            left_out: 0,
            elsewhere: 0,
            not_offered,
            failed: None,
            lacks_springs: false,
            asked,
        }
    }

    /// What was not judged, a sentence each.
    pub fn notes(&self) -> Vec<String> {
        let mut notes: Vec<String> = self.failed.iter().cloned().collect();
        if !self.not_offered.is_empty() {
            notes.push(format!("not offered, and not judged: {}", self.not_offered.join(", ")));
        }
        if self.lacks_springs {
            notes.push(
                "element_forces and element_stiffness are not judged: give the springs, --springs D1,…,D6"
                    .into(),
            );
        }
        if self.outside > 0 {
            let (outside, states) = (self.outside, self.states);
            notes.push(format!("{outside} of {states} states are outside the domain of the routine"));
        }
        if self.left_out > 0 {
            let (left_out, drawn) = (self.left_out, self.left_out + self.states);
            notes.push(format!(
                "{left_out} of {drawn} states that were drawn are not asked for: the connector cannot be brought from them into the domain, \
                 or they stay near a singular set outside of it"
            ));
        }
        if self.elsewhere > 0 {
            let (elsewhere, states) = (self.elsewhere, self.states);
            notes.push(format!(
                "at {elsewhere} of {states} states angles go on otherwise, and no farther from the state before: these are not judged"
            ));
        }
        notes
    }
}

/// Asks a routine behind a door to be a subject, and checks what it answers.
///
/// # Errors
/// [`Misbehaviour`]: what the routine did that the protocol does not allow.
pub fn check<D: Door>(door: D, subject: &Subject, asked: Asked) -> Result<Checked, Misbehaviour> {
    match subject {
        Subject::Connector(definition, at) => check_connector(door, definition, at, asked),
        Subject::Constraint(constraint, at) => constraint::check(door, constraint, at, asked),
        Subject::Friction(friction) => friction::check(door, friction, asked),
    }
}

fn check_connector<D: Door>(
    door: D,
    definition: &Definition,
    at: &[Case],
    asked: Asked,
) -> Result<Checked, Misbehaviour> {
    let mut session = Session::open(door, definition, asked.convention.as_ref(), &asked.springs)?;
    let name = asked.title(session.name());
    let Asked { settings, histories, springs, domain, simplest, .. } = asked;
    let (mut states, mut outside) = (0, 0);
    let is_principal = session.is_principal();
    let domain = domain.unwrap_or_else(|| session.domain().clone());
    let candidate = Candidate::new(&name, definition)
        .settings(settings)
        .within(domain)
        .histories(if is_principal { 0 } else { histories })
        .principal_angles(is_principal)
        .springs(springs, session.tangent())
        .offers(session.offers(), session.components());
    let led = if session.has_memory() { led(at) } else { at.to_vec() };
    let candidate = if led.is_empty() { candidate } else { candidate.at(&led) };
    let left_out = candidate.left_out() as u64;
    let (mut report, elsewhere) = candidate.try_check_on_sheets(|asked: &[Question<'_>]| {
        let given = session.ask(asked)?;
        for (_, given) in asked.iter().zip(&given).filter(|(asked, _)| asked.is_drawn) {
            states += 1;
            outside += u64::from(given.is_none());
        }
        Ok(given)
    })?;
    // Several oracles judge a quantity: its simplest state is looked for once.
    let mut known: Vec<(Option<Quantity>, Option<String>)> = Vec::new();
    for check in report.subjects.iter_mut().flat_map(|subject| &mut subject.checks) {
        // Whose own states are asked is asked for no others.
        if simplest && at.is_empty() && check.verdict.is_mismatch() {
            let told = known.iter().find(|(of, _)| *of == check.quantity).map(|(_, told)| told.clone());
            check.simplest = match told {
                Some(told) => told,
                None => candidate.simplest(check, &mut |asked| session.ask(asked))?,
            };
            known.push((check.quantity, check.simplest.clone()));
        }
        // A counter-example would ask pintle again, not the routine.
        check.failing = None;
    }
    let (not_offered, lacks_springs) = (session.not_offered(), session.lacks_springs());
    let (failures, failed) = session.failures();
    let failed = failed.map(|(number, why)| {
        format!(
            "the routine failed at {failures} of {states} states, first at state {number} of the check: {why}"
        )
    });
    session.ask_again()?;
    let asked = session.asked();
    session.close()?;
    let elsewhere = elsewhere as u64;
    Ok(Checked { report, states, outside, left_out, elsewhere, not_offered, failed, lacks_springs, asked })
}

/// States of a history, each with the whole way to it: a routine with a memory is led along.
fn led(at: &[Case]) -> Vec<Case> {
    let mut way: Vec<Step> = Vec::new();
    let mut whole = at.to_vec();
    for case in &mut whole {
        let follows = case.path.len() > 1;
        if !follows {
            way.clear();
        }
        way.extend(case.last().copied());
        if let (true, Some(first)) = (follows, at.first()) {
            (case.start, case.path) = (first.start, way.clone());
        }
    }
    whole
}

/// Asks a routine behind a door for rows at general states, of a domain or of that of its hello, and finds the conventions under which they
/// are right.
///
/// # Errors
/// [`Misbehaviour`]; what it gives may be no rows at all.
pub fn fit_convention<D: Door>(
    door: D,
    subject: &Subject,
    seed: &str,
    domain: Option<&Domain>,
) -> Result<fit::Found, Misbehaviour> {
    match subject {
        Subject::Connector(definition, _) => fit_connector(door, definition, seed, domain),
        Subject::Constraint(constraint, _) => constraint::fit_convention(door, constraint, seed),
        Subject::Friction(_) => Err(Misbehaviour::NoConvention(
            "a friction has no rows: conventions are found of connectors and constraints".into(),
        )),
    }
}

fn fit_connector<D: Door>(
    door: D,
    definition: &Definition,
    seed: &str,
    domain: Option<&Domain>,
) -> Result<fit::Found, Misbehaviour> {
    /// One tells most; a second and a third what one leaves open by chance. One more is asked where they leave something open.
    const STATES: usize = 3;
    let plain = Convention::default();
    let mut session = Session::open(door, definition, Some(&plain), &[None; 6])?;
    let domain = domain.unwrap_or_else(|| session.domain()).clone();
    let offers = session.offers();
    if !offers.contains(&Quantity::FirstDerivatives) {
        return Err(Misbehaviour::BadHello("it offers no rows, by which conventions are found".into()));
    }
    let useful = [
        Quantity::Value,
        Quantity::FirstDerivatives,
        Quantity::Rate,
        Quantity::SecondDerivatives,
        Quantity::NodalForces,
    ];
    let wants: Vec<Quantity> = useful.into_iter().filter(|quantity| offers.contains(quantity)).collect();
    // At the initial state displacements and residuals are zero.
    let connector = pintle_kinematics::connector::Connector::<f64>::new(definition);
    let values_before = std::array::from_fn(|k| connector.differentiated(k).map(|_| 0.0));
    let mut ask = |states: &[State<f64>], first: usize| {
        let step =
            |state: &State<f64>| Step { state: *state, ..Step::between(&definition.initial, state.pair) };
        let steps: Vec<Step> = states.iter().map(step).collect();
        let question = |(n, step)| Question {
            number: first + n,
            step,
            path: &[],
            values_before,
            wants: &wants,
            is_drawn: true,
        };
        session.ask_as_it_is(&steps.iter().enumerate().map(question).collect::<Vec<_>>())
    };
    let mut states = fit::generic_states(definition, seed, STATES, &domain);
    if states.is_empty() {
        let why = format!("the connector has no state in the domain {domain}; --within gives another one");
        return Err(Misbehaviour::NoConvention(why));
    }
    let mut given = ask(&states, 0)?;
    let mut found = fit::fit(definition, &states, &given).map_err(Misbehaviour::NoConvention)?;
    // What they leave open is asked where it makes a difference.
    let others = fit::generic_states(definition, &format!("{seed}, others"), STATES + 1, &domain);
    if let Some(n) = found.separating(definition, &others) {
        given.extend(ask(&others[n..=n], states.len())?);
        states.push(others[n]);
        found = fit::fit(definition, &states, &given).map_err(Misbehaviour::NoConvention)?;
    }
    session.close()?;
    Ok(found)
}
