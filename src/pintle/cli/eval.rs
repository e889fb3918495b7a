//! `pintle eval`.

use super::compare::any_states;
use super::history::{Assigned, Forces, Given, History, Survey};
use super::output::npz::{Array, Growing, Items, npz_growing};
use super::tell::{Once, complain, show_diagnostic};
use super::{Eval, EvalFormat, Failure, Files, Show, Sign, page_width};
use pintle_kinematics::connector::{Flag, Output, Request};
use pintle_kinematics::node::DOFS;
use pintle_model::behavior::state::Velocities;
use pintle_model::evaluate::{
    Branches, ElementBehavior, Fixed, ForceCheck, Item, Jacobian, Model, Motions, Numbers, Plan, Selection,
    Sequence, request,
};
use pintle_report as report;
use pintle_report::{ArrayEvaluation, Block, BlockKind, Format, Subject};
use pintle_scene::{
    Code, Diagnostic, Example, ForceSign, GALLERY, Scene, Severity, State, StateForces, StateIndex,
};
use serde::{Deserialize, Serialize};
use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter, Cursor, IsTerminal, Write};
use std::path::Path;
use std::time::{Duration, Instant};

/// The version of the file of branches.
const BRANCHES: &str = "pintle-branches/1";

/// Where a scene comes from.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Source<'a> {
    Gallery(&'static Example),
    File(&'a str),
}

/// A scene, read and resolved, with its states.
struct Loaded {
    scene: Scene,
    /// Those of the gallery, or of the scene itself; the scene may have none.
    states: Vec<State>,
    model: Model,
}

/// A scene that is to be evaluated.
struct Run {
    scene: Scene,
    history: History,
    survey: Survey,
    forces: Option<Forces>,
    model: Model,
}

/// A connector or MPC at one state, worked into what is written and told of it; the next takes its room.
struct Rendered {
    kind: BlockKind,
    has_numbers: bool,
    text: Vec<u8>,
    title: String,
    flags: Vec<Flag>,
    failed: Option<io::Error>,
}

impl Default for Rendered {
    fn default() -> Self {
        Self {
            kind: BlockKind::Connector,
            has_numbers: false,
            text: Vec::new(),
            title: String::new(),
            flags: Vec::new(),
            failed: None,
        }
    }
}

/// What was seen that needs care, for one line on stderr.
#[derive(Default)]
struct Care {
    count: u64,
    first: Option<String>,
}

/// Evaluates scenes and writes the results.
pub(crate) fn run(arguments: &Eval, files: Files) -> Result<(), Failure> {
    files.check(arguments.save_branches.iter().chain(&arguments.jacobian))?;
    let sources = sources(arguments)?;
    let runs = sources
        .iter()
        .map(|source| of_arguments(*source, arguments))
        .collect::<Result<Vec<Run>, Failure>>()?;
    let request = wanted(arguments, &runs)?;
    if matches!(arguments.format, EvalFormat::Human) {
        let mut out = BufWriter::new(anstream::stdout().lock());
        let width = page_width(&io::stdout());
        let style =
            report::human::Style { width, digits: usize::from(arguments.digits), verbose: arguments.verbose };
        walk((arguments, files), &runs, &request, &mut report::human::Human::new(&mut out, style))
    } else {
        let mut out = BufWriter::new(io::stdout().lock());
        match arguments.format {
            EvalFormat::Csv => {
                let outputs = request.outputs().collect();
                let has_slopes = request.outputs().any(|output| output == Output::TANGENT);
                let order = request.order.max(u8::from(has_slopes));
                let mut format = report::csv::Csv::new(&mut out, outputs, order);
                walk((arguments, files), &runs, &request, &mut format)?;
                drop(format);
                Ok(out.flush()?)
            }
            EvalFormat::Npz => arrays(arguments, &runs, &request, &mut out),
            EvalFormat::Json | EvalFormat::Human => {
                walk((arguments, files), &runs, &request, &mut report::json::Json::new(&mut out))
            }
        }
    }
}

/// How many numbers of arrays, and of the states that they are of, are held at a time.
const HELD: usize = 4_000_000;

/// How many numbers the motion of a node takes.
const NUMBERS_OF_NODE: usize = 32;

/// Writes numbers of components as arrays, of some states at a time.
fn arrays(arguments: &Eval, runs: &[Run], request: &Request, out: &mut dyn Write) -> Result<(), Failure> {
    let [run] = runs else {
        return Err(Failure::Usage("--format npz is of one scene: name it".to_string()));
    };
    let others = [
        ("--independent", arguments.independent),
        ("--forces", arguments.forces.is_some()),
        ("--show", arguments.show.is_some()),
        ("--resume", arguments.resume.is_some()),
        ("--save-branches", arguments.save_branches.is_some()),
        ("--jacobian", arguments.jacobian.is_some()),
    ];
    if let Some((option, _)) = others.into_iter().find(|(_, is_given)| *is_given) {
        return Err(Failure::Usage(format!("{option} is not for --format npz: use --format json or csv")));
    }
    if let Some(output) = request.outputs().find(|one| one.is_nodal() || *one == Output::TANGENT) {
        let name = output.name();
        let message = format!("{name} is no number of a component: --format json or csv has it");
        return Err(Failure::Usage(message));
    }
    let Run { scene, history, survey, model, .. } = run;
    assign(run, 0, None, arguments)?;
    let selection = selected(&arguments.connector);
    let plan = Plan::compile(model, &selection, request.clone())
        .map_err(|error| Failure::Usage(error.to_string()))?;
    if plan.connectors.is_empty() {
        return Err(nothing(scene));
    }
    let (states, connectors) = (survey.marks.len(), plan.connectors.len());
    let elements = plan.connectors.iter().map(|index| model.connectors[*index].label.to_string());
    let mut whole = vec![
        Array { name: "state", shape: vec![states], items: Items::Counts(survey.numbers(0)) },
        Array::words("element", elements.collect()),
    ];
    if survey.marks.iter().any(|mark| mark.time.is_some()) {
        let times = survey.marks.iter().map(|mark| mark.time.unwrap_or(f64::NAN)).collect();
        whole.push(Array::numbers("time", vec![states], times));
    }
    let shape = [states, connectors, 6, DOFS, DOFS];
    let named = request.outputs().map(|output| (output.name(), 3));
    let derivatives = [("jacobian", 4), ("hessian", 5)].into_iter().take(usize::from(request.order));
    let growing: Vec<Growing> = named
        .chain(derivatives)
        .map(|(name, axes)| Growing { name, shape: shape[..axes].to_vec() })
        .collect();
    let conditions = (&arguments.conditions).into();
    let mut evaluation = ArrayEvaluation::new(model, &plan, &conditions, survey.moves);
    let each: Vec<usize> = growing.iter().map(|of| of.shape[1..].iter().product()).collect();
    // So many states that they and their numbers fill some megabytes.
    let of_state = each.iter().sum::<usize>() + NUMBERS_OF_NODE * scene.nodes.len();
    let at_once = (HELD / of_state.max(1)).max(1);
    npz_growing(out, &whole, &growing, |put| {
        let (mut held, mut room) = (Vec::with_capacity(at_once.min(states)), Vec::new());
        let mut evaluate = |held: &mut Vec<State>| -> Result<(), Failure> {
            let lengths = each.iter().map(|each| each * held.len());
            room.resize_with(each.len(), Vec::new);
            room.iter_mut().zip(lengths).for_each(|(of, length): (&mut Vec<f64>, _)| of.resize(length, 0.0));
            let mut slices = room.iter_mut().map(Vec::as_mut_slice);
            let numbers = Numbers {
                values: request.outputs().zip(slices.by_ref()).collect(),
                jacobian: slices.next(),
                hessian: slices.next(),
            };
            let done = evaluation.advance(Motions::States(held), numbers);
            done.map_err(|error| Failure::Input(error.to_string()))?;
            held.clear();
            Ok(put(&room.iter().map(Vec::as_slice).collect::<Vec<_>>())?)
        };
        history.each(scene, |state| {
            held.push(state.clone());
            if held.len() < at_once { Ok(()) } else { evaluate(&mut held) }
        })?;
        evaluate(&mut held)
    })?;
    out.flush()?;
    complain("note", "arrays do not say which values need care: --format json does");
    Ok(())
}

/// The scenes that are asked for.
fn sources(arguments: &Eval) -> Result<Vec<Source<'_>>, Failure> {
    match &arguments.scene {
        None => Ok(GALLERY.iter().map(Source::Gallery).collect()),
        Some(name) => source(name).map(|source| vec![source]),
    }
}

/// The scene of that name.
pub(crate) fn source(name: &str) -> Result<Source<'_>, Failure> {
    if name == "-" {
        let message =
            "a deck is not read from standard input; give the path of a file (./- if that is its name)";
        return Err(Failure::Usage(message.to_string()));
    }
    let Some(example) = name.strip_prefix("gallery:") else { return Ok(Source::File(name)) };
    let found = GALLERY.iter().find(|known| known.name.eq_ignore_ascii_case(example));
    found.map(Source::Gallery).ok_or_else(|| {
        let names: Vec<&str> = GALLERY.iter().map(|known| known.name).collect();
        let near = names
            .iter()
            .map(|known| (strsim::damerau_levenshtein(known, example), known))
            .filter(|(distance, known)| *distance <= known.len() / 3)
            .min_by_key(|(distance, _)| *distance);
        let remedy = near.map(|(_, near)| format!("; did you mean {near}?")).unwrap_or_default();
        Failure::Usage(format!("the gallery has no scene {example:?}{remedy} (it has {})", names.join(", ")))
    })
}

/// A scene with its states, or the initial one, and its forces.
fn of_arguments(source: Source<'_>, arguments: &Eval) -> Result<Run, Failure> {
    let sign = arguments.force_sign.into();
    let Loaded { scene, mut states, model } = load(source)?;
    let forces = arguments.forces.as_deref().map(|file| Forces::open(file, &scene, sign)).transpose()?;
    let history = match &arguments.states {
        Some(file) => History::open(file, &scene)?,
        None => {
            if states.is_empty() {
                states.push(State::default());
            }
            History::Held(states)
        }
    };
    let survey = history.survey(&scene)?;
    let file =
        arguments.states.as_ref().map_or_else(|| scene.name.clone(), |file| file.display().to_string());
    let warnings = survey.vanishing.warning().into_iter().chain(survey.degrees.warning());
    warnings.for_each(|warning| show_diagnostic(&warning.in_file(&file)));
    Ok(Run { scene, history, survey, forces, model })
}

/// Reads a scene and its states: those of a file, or its own.
pub(crate) fn read(source: Source<'_>, states: Option<&Path>) -> Result<(Scene, Vec<State>), Failure> {
    let scene = match source {
        Source::Gallery(example) => example.scene()?,
        Source::File(path) => {
            let (scene, error) = Scene::examine(path);
            match error {
                None => scene,
                Some(error) => return Err(source.with_rules(&scene, error).into()),
            }
        }
    };
    let states = match (states, source) {
        (Some(file), _) => any_states(file, &scene)?,
        (None, Source::Gallery(example)) => example.states(&scene)?.states,
        (None, Source::File(_)) => scene.states.clone(),
    };
    Ok((scene, states))
}

/// The scene of a file, or `gallery:NAME`, with its own states.
///
/// # Errors
/// In words: the file, the line, what is wrong there.
pub fn scene(name: &str) -> Result<(Scene, Vec<State>), String> {
    source(name).and_then(|source| read(source, None)).map_err(|failure| failure.to_string())
}

impl Source<'_> {
    /// A diagnostic with the lines of this scene that it is about.
    pub(crate) fn quoted(self, diagnostic: Diagnostic) -> Diagnostic {
        match self {
            Self::Gallery(example) => diagnostic.with_source(Cursor::new(example.deck)),
            Self::File(_) => match File::open(diagnostic.file()) {
                Ok(file) => diagnostic.with_source(BufReader::new(file)),
                Err(_) => diagnostic,
            },
        }
    }

    /// What is wrong with a deck, and which rules it breaks besides, of those that its other faults cannot touch.
    fn with_rules(self, scene: &Scene, error: Diagnostic) -> Diagnostic {
        let independent = [
            Code::UnknownConnectionType,
            Code::OrientationRequired,
            Code::ActionNotAvailable,
            Code::StopNotAvailable,
            Code::ReferenceNotAvailable,
        ];
        let (_, broken) = Model::examine(scene);
        let broken = broken.into_iter().filter(|rule| independent.contains(&rule.code()));
        broken.map(|rule| self.quoted(rule)).fold(error, Diagnostic::and)
    }

    /// Says what of a scene deserves a look, as bad as `taken` takes it to be; what is `None` is not shown.
    pub(crate) fn warn(
        self,
        scene: &Scene,
        of_model: &[Diagnostic],
        taken: impl Fn(&Diagnostic) -> Option<Severity>,
    ) {
        let of_scene = scene.warnings.iter().map(|warning| (warning.clone(), false));
        let of_model = of_model.iter().map(|warning| (warning.clone(), true));
        let mut once = Once::default();
        for (warning, is_of_model) in of_scene.chain(of_model) {
            let Some(severity) = taken(&warning) else { continue };
            let show = |warning| if is_of_model { self.quoted(warning) } else { warning };
            once.show(warning.of_severity(severity), show);
        }
        once.count();
    }
}

/// That there is nothing to evaluate, and which constraints were not read.
pub(crate) fn nothing(scene: &Scene) -> Failure {
    let unread = scene.unread_constraints();
    let unread = unread.iter().map(|(what, places)| match places[..] {
        [one] => format!("{what} (line {})", one.line()),
        [first, ..] => format!("{what} ({} times, the first in line {})", places.len(), first.line()),
        [] => what.clone(),
    });
    let unread: Vec<String> = unread.collect();
    let unread = if unread.is_empty() { String::new() } else { format!("; not read: {}", unread.join(", ")) };
    Failure::Nothing(format!(
        "{} has no connector element and no constraint that is evaluated{unread}",
        scene.name
    ))
}

/// Reads and resolves a scene, and says what deserves a look.
fn load(source: Source<'_>) -> Result<Loaded, Failure> {
    let (scene, states) = read(source, None)?;
    let (model, errors) = Model::examine(&scene);
    if let Some(error) = Diagnostic::joined(errors.into_iter().map(|error| source.quoted(error))) {
        return Err(error.into());
    }
    source.warn(&scene, &model.warnings, |warning| Some(warning.severity()));
    Ok(Loaded { scene, states, model })
}

impl From<Sign> for ForceSign {
    fn from(sign: Sign) -> Self {
        match sign {
            Sign::Internal => Self::Internal,
            Sign::ConstraintsOnB => Self::ConstraintsOnB,
        }
    }
}

/// The request: the outputs named, or what the scenes suggest.
fn wanted(arguments: &Eval, runs: &[Run]) -> Result<Request, Failure> {
    let order = arguments.order.unwrap_or(u8::from(arguments.outputs.is_empty()));
    if !arguments.outputs.is_empty() {
        let names = arguments.outputs.iter().map(String::as_str);
        return request(names, order).map_err(|error| Failure::Usage(error.to_string()));
    }
    let mut outputs = vec![Output::CP, Output::CU, Output::RES];
    if runs.iter().any(|run| run.survey.moves) {
        outputs.extend([Output::CV, Output::CA]);
    }
    let stops = |run: &Run| {
        run.model.connectors.iter().any(|element| element.connector.stops().iter().any(Option::is_some))
    };
    let elements = || runs.iter().flat_map(|run| &run.model.connectors);
    let acts = |what: fn(&ElementBehavior) -> bool| elements().any(|one| what(&one.behavior));
    let hinges = || runs.iter().flat_map(|run| &run.model.mpcs).flat_map(|mpc| &mpc.drives);
    let is_loaded = hinges().any(|drives| drives.loads.iter().any(Option::is_some));
    let is_driven = hinges().any(|drives| drives.motions.iter().any(Option::is_some));
    if runs.iter().any(stops) || acts(|one| !one.behavior.locks.is_empty()) {
        outputs.push(Output::CSLST);
    }
    let has_forces = |run: &Run| run.forces.is_some() || run.survey.has_forces();
    // What presses are mostly constraint forces.
    let slides = acts(|one| one.behavior.tells_friction())
        || runs.iter().any(has_forces) && acts(|one| !one.behavior.friction.frictions.is_empty());
    for (output, is_there) in [
        (Output::CEF, acts(|one| one.behavior.elasticity.components().contains(&true))),
        (Output::CVF, acts(|one| one.behavior.damping.components().contains(&true))),
        (Output::CSF, slides),
        (Output::CNF, slides),
        (Output::CASU, slides),
        (Output::CCF, is_loaded || acts(|one| one.drives.loads.iter().any(Option::is_some))),
        (Output::CFAILST, acts(|one| !one.behavior.failures.is_empty())),
        (Output::DRIVEN, is_driven || acts(|one| one.drives.motions.iter().any(Option::is_some))),
    ] {
        outputs.extend(is_there.then_some(output));
    }
    if runs.iter().any(has_forces) {
        outputs.push(Output::CTF);
        outputs.extend(
            elements().any(|element| element.connector.connection().printed.is_some()).then_some(Output::PM),
        );
        outputs.push(Output::NF);
    }
    // Arrays have numbers of components only.
    outputs.retain(|output| !matches!(arguments.format, EvalFormat::Npz) || !output.is_nodal());
    Ok(Request::new(&outputs, [true; 6], order))
}

/// Finds the states, the first of which has the number `first`, that the forces of a file belong to, and checks all forces.
fn assign(
    run: &Run,
    first: u64,
    states: Option<&StateIndex<'_>>,
    arguments: &Eval,
) -> Result<Assigned, Failure> {
    let Run { scene, history, survey, forces, model } = run;
    let (check, numbers) = (ForceCheck::new(model), survey.numbers(first));
    let number = |place: usize| numbers.get(place).copied().unwrap_or_default();
    let of = |place: usize, forces: Given<'_>, file: &Path| {
        let name = file.display().to_string();
        check.check(forces, number(place), &name).map_err(|error| match File::open(file) {
            Ok(text) => error.with_source(BufReader::new(text)),
            Err(_) => error,
        })
    };
    let assigned = match (forces, states) {
        (Some(forces), Some(states)) => {
            let file = arguments.forces.as_deref().unwrap_or(Path::new(""));
            forces.assign(scene, states, |place, forces| of(place, forces, file))?
        }
        _ => Assigned::default(),
    };
    if survey.has_forces() {
        let file = arguments.states.as_deref().or(arguments.scene.as_deref().map(Path::new));
        let (mut place, mut wrong) = (0, None::<Diagnostic>);
        history.each(scene, |state| {
            let given = (&state.forces, &state.mpc_forces);
            let error = of(place, given, file.unwrap_or(Path::new(""))).err();
            wrong = Diagnostic::joined(wrong.take().into_iter().chain(error));
            place += 1;
            Ok(())
        })?;
        wrong.map_or(Ok(()), Err)?;
    }
    Ok(assigned)
}

/// The connectors named; all where none is.
pub(super) fn selected(names: &[String]) -> Selection {
    if names.is_empty() { Selection::All } else { Selection::Named(names.to_vec()) }
}

/// Walks through the states of every scene, writing as it goes.
fn walk(
    (arguments, files): (&Eval, Files),
    runs: &[Run],
    request: &Request,
    format: &mut dyn Format,
) -> Result<(), Failure> {
    let selection = selected(&arguments.connector);
    let is_overview = arguments.scene.is_none() && matches!(arguments.format, EvalFormat::Human);
    let default = if is_overview { Show::overview() } else { Show::all() };
    let show = arguments.show.as_ref().unwrap_or(&default);
    let mut care = Care::default();
    let mut evaluated = 0;
    // What cannot be is said before anything is written.
    let mut walks = Vec::new();
    for run in runs {
        let Run { scene, survey, forces, model, .. } = run;
        let plan = Plan::compile(model, &selection, request.clone())
            .map_err(|error| Failure::Usage(error.to_string()))?;
        if plan.is_empty() && arguments.scene.is_some() {
            return Err(nothing(scene));
        }
        let branches = match &arguments.resume {
            Some(file) => resume(file, model, &plan)?,
            None => Branches::default(),
        };
        let states = forces.as_ref().map(|_| StateIndex::new(&survey.marks, branches.states));
        let assigned = assign(run, branches.states, states.as_ref(), arguments)?;
        let numbers = survey.numbers(branches.states);
        let shown = show.among(&numbers).map_err(Failure::Usage)?;
        walks.push((plan, branches, shown, numbers, states, assigned));
    }
    format.begin()?;
    let mut progress = Progress::new();
    for (run, (plan, branches, shown, numbers, states, assigned)) in runs.iter().zip(&walks) {
        let Run { scene, history, survey, forces, model } = run;
        let mut sequence = Sequence::resume(model, plan, branches.clone());
        if arguments.save_branches.is_some() || arguments.jacobian.is_some() {
            sequence.follow_everything();
        }
        let is_shown = |index: &u64| shown.iter().any(|range| range.contains(index));
        let last_shown = numbers.iter().copied().rfind(is_shown);
        if !survey.moves {
            sequence.set_velocities(Velocities::Increments);
        }
        sequence.set_conditions((&arguments.conditions).into());
        let start = arguments.independent.then(|| sequence.clone());
        let [first, last] =
            [numbers.first(), numbers.last()].map(|number| number.copied().unwrap_or_default());
        format.scene(&Subject { scene, model, plan, states: numbers.len(), shown, first, last })?;
        let mut done = 0;
        let mut rooms: Vec<Rendered> = Vec::new();
        assigned.with(forces.as_ref().zip(states.as_ref()), scene, |mut feed| {
            history.each(scene, |given| {
                let with_forces = feed.at(done)?.map(|StateForces { elements, mpcs }| {
                    Box::new(State { forces: elements, mpc_forces: mpcs, ..given.clone() })
                });
                let state = with_forces.as_deref().unwrap_or(given);
                let index = numbers.get(done).copied().unwrap_or_default();
                progress.tick(&scene.name, done, numbers.len());
                done += 1;
                if let Some(start) = &start {
                    sequence.clone_from(start);
                }
                if is_shown(&index) {
                    if let Some(file) = arguments.jacobian.as_ref().filter(|_| last_shown == Some(index)) {
                        let told = save_jacobian(
                            (file, files),
                            (scene, model, plan),
                            sequence.clone(),
                            (index, state),
                        )?;
                        // Whatever else needs care is told by the evaluation.
                        for (title, flag) in &told {
                            if matches!(flag, Flag::NotFinite { .. }) {
                                care.see(index, title, std::slice::from_ref(flag));
                            }
                        }
                    }
                    format.state(index, state.time)?;
                    let render = format.renderer();
                    let digest = |item: Item<'_>, to: &mut Rendered| {
                        let block = match item {
                            Item::Connector(result) => Block::of_connector(model, request, result),
                            Item::Mpc(result) => Block::of_mpc(model, request, result),
                            Item::Relation(result) => Block::of_relation(model, request, result),
                        };
                        (to.kind, to.has_numbers) = (block.kind, block.has_numbers());
                        to.text.clear();
                        to.failed = render(&block, &mut to.text).err();
                        to.title = if block.flags.is_empty() { String::new() } else { title(model, item) };
                        to.flags = block.flags;
                    };
                    sequence.visit_digested(state, &mut rooms, digest, |rendered| {
                        if let Some(error) = rendered.failed.take() {
                            return Err(error);
                        }
                        evaluated += u64::from(rendered.has_numbers);
                        care.see(index, &rendered.title, &rendered.flags);
                        format.rendered(rendered.kind, &rendered.text)
                    })?;
                    format.end_state()?;
                } else {
                    sequence.pass(state, |item| -> Result<(), Failure> {
                        let flags = match item {
                            Item::Connector(result) => &result.flags,
                            Item::Mpc(result) => &result.flags,
                            Item::Relation(result) => &result.flags,
                        };
                        if !flags.is_empty() {
                            care.see(index, &title(model, item), flags);
                        }
                        Ok(())
                    })?;
                }
                Ok(())
            })
        })?;
        format.end_scene(sequence.tally())?;
        if let Some(file) = &arguments.save_branches {
            save((file, files), &scene.name, &sequence.branches())?;
        }
    }
    progress.clear();
    format.end()?;
    care.tell();
    if evaluated == 0 {
        return Err(Failure::Nothing("no connector has an output of those asked for".into()));
    }
    Ok(())
}

/// What a result is of: `HINGE 101`, `MPC REVOLUTE 10-20-30`.
fn title(model: &Model, item: Item<'_>) -> String {
    match item {
        Item::Connector(result) => model.connectors[result.index].title(),
        Item::Mpc(result) => model.mpcs[result.index].title(),
        Item::Relation(result) => model.relations[result.index].title(),
    }
}

impl Care {
    fn see(&mut self, index: u64, title: &str, flags: &[Flag]) {
        self.count += flags.len() as u64;
        if let (None, Some(flag)) = (&self.first, flags.first()) {
            self.first = Some(format!("state {index}, {title}: {}", report::flag_in_words(flag)));
        }
    }

    fn tell(&self) {
        let Some(first) = &self.first else { return };
        let text = match self.count {
            1 => format!("one value needs care: {first}"),
            count => format!("{count} values need care; the first: {first}"),
        };
        complain("note", &text);
    }
}

/// Branches in a file.
#[derive(Serialize, Deserialize)]
struct BranchFile<B> {
    schema: String,
    version: String,
    scene: String,
    branches: B,
}

fn save((path, files): (&Path, Files), scene: &str, branches: &Branches) -> Result<(), Failure> {
    let file = BranchFile {
        schema: BRANCHES.to_string(),
        version: crate::VERSION.to_string(),
        scene: scene.to_string(),
        branches,
    };
    let text = serde_json::to_string(&file).map_err(|error| Failure::Input(error.to_string()))?;
    files.text(path, text + "\n")
}

/// Writes the constraint Jacobian at a state, which `sequence` has before it, and gives what of it needs care.
fn save_jacobian(
    (path, files): (&Path, Files),
    (scene, model, plan): (&Scene, &Model, &Plan),
    mut sequence: Sequence<'_>,
    (number, state): (u64, &State),
) -> Result<Vec<(String, Flag)>, Failure> {
    let jacobian = Jacobian::of_constraints(model, plan, &Fixed::of(scene)?);
    let mut values = Vec::new();
    let assembled = sequence.assemble(state, &jacobian, &mut values);
    let care = assembled.map_err(|error| Failure::Usage(error.to_string()))?;
    let of = format!("{} at state {number}", scene.name);
    files.write(path, |out| report::matrix_market::write(out, &of, model, &jacobian, &values))?;
    Ok(care)
}

fn resume(path: &Path, model: &Model, plan: &Plan) -> Result<Branches, Failure> {
    let name = path.display();
    let text =
        fs::read_to_string(path).map_err(|error| Failure::Input(format!("cannot read {name}: {error}")))?;
    let file: BranchFile<Branches> = serde_json::from_str(&text).map_err(|error| {
        Failure::Input(format!("{name} is no file of branches, as --save-branches writes it: {error}"))
    })?;
    if file.schema != BRANCHES {
        return Err(Failure::Input(format!("{name} has schema {:?}, not {BRANCHES:?}", file.schema)));
    }
    file.branches.check(model, plan).map_err(|reason| {
        Failure::Input(format!("{name}, saved for {}, cannot be continued: {reason}", file.scene))
    })?;
    Ok(file.branches)
}

/// A line on a terminal that says how far a long run is.
struct Progress {
    begun: Instant,
    told: Option<Instant>,
    visible: bool,
}

impl Progress {
    fn new() -> Self {
        Self {
            begun: Instant::now(),
            told: None,
            visible: io::stderr().is_terminal() && !io::stdout().is_terminal(),
        }
    }

    fn tick(&mut self, scene: &str, done: usize, states: usize) {
        let last = self.told.unwrap_or(self.begun);
        if self.visible && last.elapsed() > Duration::from_secs(1) {
            self.told = Some(Instant::now());
            _ = write!(io::stderr(), "\r{scene}: state {done} of {states} ");
        }
    }

    fn clear(&self) {
        if self.told.is_some() {
            _ = write!(io::stderr(), "\r\x1b[K");
        }
    }
}
