//! The reader of Abaqus-style decks: one pass over the lines, then the references between the parts.
//!
//! [`keywords`] lists what is understood, with stages and parameters; each family of keywords has its file;
//! [`resolve`] checks every reference once the whole deck is known, so that forward references are allowed.

mod assembly;
mod behavior;
mod connector;
mod constraint;
mod errors;
mod faces;
mod generate;
mod history;
mod keywords;
mod lookup;
mod mesh;
mod resolve;
mod sets;
mod table;
mod unread;
pub(crate) mod write;

use crate::behavior::Behavior;
use crate::choice::Choice;
use crate::diagnostic::{Code, Diagnostic, Result, Severity, nearest};
use crate::document;
use crate::document::Format;
use crate::document::form::Document;
use crate::freedom::element_dimension;
use crate::include::{Disk, Files, Named, NoFiles};
use crate::label::labelled::LabelSet;
use crate::lexer::{Keyword, Lexer, Value, not_utf8};
use crate::model::{Dimension, MAX_WARNINGS, Scene, SkippedConstraint, Step, Target};
use crate::span::{Span, Spanned};
use crate::wording::keyword;
use errors::Errors;
use faces::OtherElements;
use indexmap::IndexMap;
use keywords::beginnings::{Begun, begun};
use keywords::{Family, Rule, Stage, Strange};
use sets::SetBuilder;
use std::collections::HashMap;
use std::fs;
use std::io::BufRead;
use std::path::{Path, PathBuf};

pub use sets::MAX_MEMBERS;

/// The decks in a directory, in the order of their names.
fn decks_of(directory: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(directory).into_iter().flatten().flatten();
    let mut decks: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(|path| path.is_file()).collect();
    decks.retain(|path| path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("inp")));
    decks.sort();
    decks
}

/// What to type in the place of a directory that has these decks.
fn some_of(decks: &[PathBuf]) -> String {
    const SHOWN: usize = 4;
    let names =
        decks.iter().take(SHOWN).map(|deck| deck.display().to_string()).collect::<Vec<_>>().join(", ");
    match decks.len() {
        0 => "name a deck (.inp); there is none in it".to_string(),
        1..=SHOWN => format!("name one of its decks: {names}"),
        all => format!("name one of its {all} decks: {names} …"),
    }
}

impl Scene {
    /// Reads a scene from a file: TOML or JSON if its name ends in `.toml` or `.json`, otherwise a deck, with the files that
    /// it includes, each relative to the one that includes it. A directory with one deck stands for it.
    ///
    /// # Errors
    /// What is wrong with it, with places and remedies: the first error, which carries the others ([`Diagnostic::further`]).
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let (scene, error) = Self::examine(path);
        error.map_or(Ok(scene), Err)
    }

    /// As much of a file as could be read, and what is wrong with it; nothing of it where so much is missing that nothing can be judged.
    pub fn examine(path: impl AsRef<Path>) -> (Self, Option<Diagnostic>) {
        let path = path.as_ref();
        let name = path.display().to_string();
        let unreadable = |message: String, remedy: &str| {
            Diagnostic::error(Code::Unreadable, Span::default(), message, "").help(remedy).in_file(&name)
        };
        let format = Format::of_path(path);
        let nothing = |error| (Self::default(), Some(error));
        if path.is_dir() {
            return match decks_of(path).as_slice() {
                [deck] => Self::examine(deck),
                decks => {
                    let remedy = some_of(decks);
                    nothing(unreadable("a directory, not a deck".to_string(), &remedy))
                }
            };
        }
        if format != Format::Deck {
            return document::read(path, format).map_or_else(nothing, |scene| (scene, None));
        }
        match Disk.open(&name) {
            Ok(input) => finish(read(&name, input, &Disk), &Named { root: &name, text: None, files: &Disk }),
            Err(error) => nothing(unreadable(
                format!("cannot be opened: {error}"),
                "check the path and its permissions",
            )),
        }
    }

    /// Reads a deck from memory. `name` stands for the file in messages. It includes nothing.
    ///
    /// # Errors
    /// What is wrong with it, with places and remedies: the first error, which carries the others ([`Diagnostic::further`]).
    pub fn parse(name: &str, text: &str) -> Result<Self> {
        Self::parse_bytes(name, text.as_bytes())
    }

    /// Like [`parse`](Self::parse), for bytes that need not be UTF-8 where they are skipped.
    ///
    /// # Errors
    /// What is wrong with it, with places and remedies: the first error, which carries the others ([`Diagnostic::further`]).
    pub fn parse_bytes(name: &str, bytes: &[u8]) -> Result<Self> {
        Self::parse_with(name, bytes, &NoFiles)
    }

    /// Like [`parse_bytes`](Self::parse_bytes), including what `files` has.
    ///
    /// ```
    /// use pintle_scene::{Label, Scene};
    /// use std::collections::BTreeMap;
    ///
    /// let files = BTreeMap::from([("mesh.inp".to_string(), "1, 0., 0., 0.\n2, 1., 0., 0.\n")]);
    /// let scene = Scene::parse_with("deck.inp", b"*NODE\n*INCLUDE, INPUT=mesh.inp\n", &files)?;
    /// assert_eq!(scene.nodes[&Label::from(2)].coordinates, [1.0, 0.0, 0.0]);
    /// # Ok::<(), pintle_scene::Diagnostic>(())
    /// ```
    ///
    /// # Errors
    /// What is wrong with it, with places and remedies: the first error, which carries the others ([`Diagnostic::further`]).
    pub fn parse_with(name: &str, bytes: &[u8], files: &dyn Files) -> Result<Self> {
        let (scene, error) =
            finish(read(name, Box::new(bytes), files), &Named { root: name, text: Some(bytes), files });
        error.map_or(Ok(scene), Err)
    }
}

/// As much of a scene as was read, what is wrong with it, and the names of all files.
pub(super) type Outcome = (Scene, Option<Diagnostic>, Vec<String>);

pub(super) fn finish((mut scene, error, names): Outcome, source: &Named<'_>) -> (Scene, Option<Diagnostic>) {
    source.root.clone_into(&mut scene.name);
    source.attach(&mut scene.warnings, &names);
    let error = error.map(|error| {
        let (mut errors, unsaid) = error.apart();
        source.attach(&mut errors, &names);
        Diagnostic::joined(errors).map(|first| first.with_unsaid(unsaid)).unwrap_or_else(lost)
    });
    scene.files = names;
    (scene, error)
}

fn read(name: &str, input: Box<dyn BufRead + '_>, files: &dyn Files) -> Outcome {
    scene(Lexer::new(name, input, files))
}

/// The scene of a document that stands for a deck, and the names of its files.
pub(super) fn of_document(name: &str, document: &Document) -> Outcome {
    match write::deck(document) {
        Ok(deck) => scene(Lexer::new(name, Box::new(deck.text.as_bytes()), &NoFiles).placed(&deck.places)),
        Err(error) => (Scene::default(), Some(error), vec![name.to_owned()]),
    }
}

fn scene(lexer: Lexer<'_>) -> Outcome {
    let mut deck = Deck {
        lexer,
        scene: Scene::default(),
        node_sets: IndexMap::new(),
        element_sets: IndexMap::new(),
        other_elements: OtherElements::default(),
        other_rotations: LabelSet::default(),
        rotation_targets: Vec::new(),
        any_rotates: false,
        mpcs: Vec::new(),
        constraints: constraint::Raw::default(),
        assembly: assembly::Assembly::default(),
        generated: 0,
        system: None,
        unread: unread::Unread::default(),
        within_joint: false,
        warnings: Vec::new(),
        warned: HashMap::new(),
        errors: Errors::default(),
        behavior_open: false,
        host: Host::None,
        step: None,
        stepped: false,
        has_keywords: false,
    };
    if let Err(error) = deck.read() {
        deck.errors.add(error);
    }
    let is_judged = deck.errors.leaves_references() || deck.may_excuse();
    if is_judged {
        resolve::resolve(&mut deck);
    }
    // Without a connector or a constraint no error bears on one.
    if deck.may_excuse()
        && let Some(first) = std::mem::take(&mut deck.errors).into_first()
    {
        let (mut errors, unsaid) = first.apart();
        if let Some(last) = errors.pop() {
            errors.push(last.with_unsaid(unsaid));
        }
        errors.into_iter().for_each(|error| deck.excuse(error));
    }
    let is_judged = is_judged && deck.errors.leaves_references();
    let Deck { lexer, mut scene, warnings, errors, .. } = deck;
    let types = scene.skipped.element_types.keys();
    scene.axisymmetric = types.clone().any(|name| name.contains("AX"));
    let unread = types.filter_map(|name| element_dimension(name));
    let mut all = scene.connectors.values().map(|element| element.dimension).chain(unread).peekable();
    scene.two_dimensional = all.peek().is_some() && all.all(|dimension| dimension == Dimension::Two);
    scene.skipped.comments = lexer.comments;
    // A keyword that looks misspelt may be the cause, or what a set lacks.
    let causes = [Code::MisspeltKeyword, Code::UnknownNode, Code::UnknownElement];
    let causes = warnings.iter().filter(|warning| causes.contains(&warning.code()));
    let error = errors.into_first().map(|first| causes.cloned().fold(first, Diagnostic::and));
    let scene = if is_judged { scene } else { Scene::default() };
    (Scene { warnings, ..scene }, error, lexer.into_names())
}

/// What has been read so far.
struct Deck<'a> {
    lexer: Lexer<'a>,
    scene: Scene,
    node_sets: IndexMap<String, SetBuilder>,
    element_sets: IndexMap<String, SetBuilder>,
    other_elements: OtherElements,
    /// The nodes of elements that are not read and have rotations.
    other_rotations: LabelSet,
    /// The reference nodes of constraints that are not read.
    rotation_targets: Vec<Target>,
    /// Elements that are not read were generated, so that any node may be one of theirs.
    any_rotates: bool,
    mpcs: Vec<connector::RawMpc>,
    constraints: constraint::Raw,
    assembly: assembly::Assembly,
    /// Nodes and elements that were generated.
    generated: u64,
    /// The axes that nodes are given in, by `*SYSTEM`.
    system: Option<mesh::Axes>,
    /// What bears on a connector only if one uses it.
    unread: unread::Unread,
    /// `*SPRING` and `*DASHPOT` belong to the `*JOINT` or `*ITS` above.
    within_joint: bool,
    warnings: Vec<Diagnostic>,
    /// Of each code the place of its first warning, and their number.
    warned: HashMap<Code, (usize, usize)>,
    errors: Errors,
    /// Connector suboptions belong to the last behaviour.
    behavior_open: bool,
    /// What a potential or another suboption of a suboption belongs to.
    host: Host,
    /// The step that is being read.
    step: Option<Step>,
    /// There has been a step.
    stepped: bool,
    /// There has been a keyword.
    has_keywords: bool,
}

/// The suboption that takes suboptions of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Host {
    None,
    Friction,
    Plasticity,
    Damage,
}

impl Deck<'_> {
    /// Reads the lines. Errors after which it can go on are added.
    ///
    /// # Errors
    /// One after which it cannot.
    fn read(&mut self) -> Result<()> {
        let mut empty = true;
        loop {
            match self.lexer.keyword() {
                Ok(None) => break,
                Ok(Some(mut keyword)) => {
                    (empty, self.has_keywords) = (false, true);
                    if keywords::find(&keyword.name).is_none()
                        && let Begun::One(whole) = begun(&keyword.name)
                    {
                        whole.clone_into(&mut keyword.name);
                    }
                    let name = keyword.name.clone();
                    if let Err(error) = self.take(keyword) {
                        self.fault(error, &name)?;
                    }
                }
                Err(error) => {
                    empty = false;
                    self.fault(error, "")?;
                }
            }
        }
        if empty {
            return Err(Diagnostic::error(Code::MissingKeywords, Span::default(), "the deck is empty", "")
                .help("a deck begins with a keyword such as *HEADING or *NODE"));
        }
        if let Some(step) = self.step.take() {
            let message = "a step ends with the file";
            let warning = Diagnostic::warning(Code::UnfinishedStep, step.span, message, "begins here");
            self.warn(warning.help("close the step by *END STEP; is the file complete?"));
            self.scene.steps.push(step);
        }
        self.check_closed()
    }

    /// Notes an error, and goes to the next keyword.
    ///
    /// # Errors
    /// The same error, where nothing can be read after it.
    fn fault(&mut self, error: Diagnostic, keyword: &str) -> Result<()> {
        if errors::is_fatal(error.code()) {
            return Err(error);
        }
        self.errors.add(error);
        self.errors.spoil(keyword);
        self.lexer.skip().map(drop)
    }

    /// Whether no error can bear on a connector or a constraint, for there is none.
    fn may_excuse(&self) -> bool {
        self.has_keywords && !self.unread.any_bears && self.errors.are_excusable()
    }

    /// Warns of an error that refuses nothing.
    fn excuse(&mut self, error: Diagnostic) {
        self.warn(error.of_severity(Severity::Warning));
    }

    fn warn(&mut self, diagnostic: Diagnostic) {
        let code = diagnostic.code();
        let known = self.warned.entry(code).or_insert((self.warnings.len(), 0));
        known.1 += 1;
        if known.1 <= MAX_WARNINGS {
            self.warnings.push(diagnostic);
        } else if let Some(first) = self.warnings.get_mut(known.0) {
            first.count_another();
        }
    }

    fn take(&mut self, mut keyword: Keyword) -> Result<()> {
        let Some(rule) = keywords::find(&keyword.name).filter(|rule| !self.is_of_another(rule)) else {
            self.within_joint &= ["SPRING", "DASHPOT", "FRICTION"].contains(&keyword.name.as_str());
            return self.pass_over(&keyword);
        };
        self.within_joint = false;
        if rule.family != Family::Suboption {
            (self.behavior_open, self.host) = (false, Host::None);
        }
        self.unread.any_bears |= rule.bears();
        if let Some(comma) = keyword.dangling.filter(|_| rule.strange != Strange::Skipped) {
            return Err(comma.error());
        }
        if let Err(error) = self.check_stage(rule, &keyword) {
            if !(keywords::is_output(rule.name) || rule.name == "DLOAD") {
                return Err(error);
            }
            // It bears on no connector: it is skipped.
            self.excuse(error);
            let lines = self.lexer.skip()?;
            self.count_skipped(&keyword, lines);
            return Ok(());
        }
        let strange = rule.check_parameters(&mut keyword)?;
        if let Some(place) = keyword.not_utf8 {
            return Err(not_utf8(place));
        }
        self.check_level(&keyword, rule.name)?;
        for parameter in rule.passed_over(&keyword).map(str::to_owned).chain(strange.iter().cloned()) {
            self.scene.skipped.count(format!("*{}, {parameter}", rule.name), keyword.span.line());
        }
        let meant = strange.iter().filter_map(|given| Some((given, rule.meant(given)?)));
        for (given, near) in meant.filter(|(given, near)| given != near) {
            let message = format!("{given} of *{} is skipped", rule.name);
            let label = "not a parameter that is read";
            let warning = Diagnostic::warning(Code::MisspeltKeyword, keyword.span, message, label);
            self.warn(warning.help(format!("did you mean {near}?")));
        }
        if let Some(parameter) = strange.first().filter(|_| rule.strange == Strange::ByNodes) {
            return unread::lines_on_nodes(self, &keyword, parameter);
        }
        if let Some(input) = keyword.get("INPUT").filter(|_| rule.takes_input()) {
            self.lexer.include(input)?;
        }
        self.read_lines(rule, &keyword)?;
        match self.lexer.row()? {
            None => Ok(()),
            Some(line) => {
                let message = keyword.words().map(|keyword| format!("{keyword} takes no such data line"));
                Err(Diagnostic::error(Code::UnexpectedData, line.span, message, "not expected")
                    .help(format!("remove the line, or a keyword is missing before it; {}", rule.data)))
            }
        }
    }

    /// Reads the data lines of a keyword. Where each stands for itself, it goes on after a faulty one.
    fn read_lines(&mut self, rule: &Rule, keyword: &Keyword) -> Result<()> {
        loop {
            let before = self.lexer.place_of_line();
            let Err(error) = (rule.read)(self, keyword) else { return Ok(()) };
            let is_fatal = errors::is_fatal(error.code());
            let is_last = is_fatal || self.lexer.place_of_line() == before;
            let goes_on = !is_last && keywords::reads_by_line(rule.name);
            let bears = if is_fatal { None } else { unread::bears(self, rule.name, keyword, &error) };
            match bears {
                Some(bears) => unread::note(self, bears, error),
                None if goes_on => {
                    self.errors.add(error);
                    self.errors.spoil(rule.name);
                }
                None => return Err(error),
            }
            if !goes_on {
                return self.lexer.skip().map(drop);
            }
        }
    }

    /// `*FRICTION` belongs to contact unless a connector behaviour is being read; `*SPRING` and `*DASHPOT` may belong to `*JOINT` or `*ITS`.
    fn is_of_another(&self, rule: &Rule) -> bool {
        let is_of_joint = self.within_joint && ["SPRING", "DASHPOT"].contains(&rule.name);
        is_of_joint || (rule.name == "FRICTION" && !self.behavior_open)
    }

    fn check_stage(&self, rule: &Rule, keyword: &Keyword) -> Result<()> {
        let name = &keyword.name;
        let error = |code, message: String, label: &str, remedy: &str| {
            Err(Diagnostic::error(code, keyword.span, message, label).help(remedy))
        };
        match rule.stage {
            Stage::Model if self.stepped => error(
                Code::ModelDataInStep,
                format!("*{name} defines the model but stands after the first *STEP"),
                "model data",
                "move it before the first *STEP",
            ),
            Stage::History if self.step.is_none() => error(
                Code::HistoryOutsideStep,
                format!("*{name} stands outside every step"),
                "belongs to a step",
                "move it between *STEP and *END STEP",
            ),
            Stage::Both if self.stepped && self.step.is_none() => error(
                Code::HistoryOutsideStep,
                format!("*{name} stands between two steps"),
                "belongs to a step, or before all steps",
                "move it between *STEP and *END STEP",
            ),
            _ if rule.family == Family::Suboption && !self.behavior_open => error(
                Code::MisplacedKeyword,
                format!("*{name} stands outside every connector behaviour"),
                "a suboption",
                "put it below *CONNECTOR BEHAVIOR, NAME=…, before any other keyword",
            ),
            _ => Ok(()),
        }
    }

    /// Warns of a keyword that looks like one that is read. Where that would hold or move nodes, the model is not what was read.
    fn ask_what_is_meant(&mut self, keyword: &Keyword) {
        let name = keyword.name.as_str();
        let names = || keywords::RULES.iter().map(|rule| rule.name);
        let meant = match begun(name) {
            Begun::Several(all) => all,
            _ if keywords::is_unrelated(name) => return,
            _ => {
                let near = nearest(name, names()).filter(|near| *near != name);
                near.or_else(|| keywords::shortened(name)).into_iter().collect()
            }
        };
        if meant.is_empty() {
            return;
        }
        let message = format!("*{name} is skipped");
        let warning =
            Diagnostic::warning(Code::MisspeltKeyword, keyword.span, message, "not a keyword that is read");
        let shown: Vec<String> = meant.iter().take(3).map(|name| format!("*{name}")).collect();
        self.warn(warning.help(format!("did you mean {}?", shown.join(" or "))));
        let holds = |name: &&&str| match **name {
            "BOUNDARY" | "ELEMENT" | "CONNECTOR SECTION" | "CONNECTOR MOTION" => true,
            "CONNECTOR ELASTICITY" => keyword.has("RIGID"),
            // Other laws, and loads, hold nothing.
            name => !name.starts_with("CONNECTOR ") && keywords::find(name).is_some_and(Rule::bears),
        };
        if let Some(name) = meant.iter().find(holds) {
            self.scene.skipped.constraints.push(SkippedConstraint { keyword: name, span: keyword.span });
        }
    }

    /// Skips a keyword that is not understood.
    fn pass_over(&mut self, keyword: &Keyword) -> Result<()> {
        self.within_joint |= ["JOINT", "ITS"].contains(&keyword.name.as_str());
        self.unread.any_bears |=
            keyword.name.starts_with("CONNECTOR") || keywords::constraint(&keyword.name).is_some();
        self.ask_what_is_meant(keyword);
        if !keyword.name.starts_with("CONNECTOR ") && !keywords::is_curve(&keyword.name) {
            (self.behavior_open, self.host) = (false, Host::None);
        }
        if let Some(step) = self.step.as_mut().filter(|_| keywords::is_procedure(&keyword.name)) {
            history::set_procedure(step, crate::model::Procedure::Other(keyword.name.clone()), keyword)?;
        }
        for parameter in ["REF NODE", "TIE NSET"] {
            // A value that is neither a node nor a set names nothing that is kept.
            let named = keyword.get(parameter).and_then(|value| constraint::named(value).ok());
            self.rotation_targets.extend(named.map(|named| named.value));
        }
        if let Some(name) = keywords::constraint(&keyword.name) {
            self.scene.skipped.constraints.push(SkippedConstraint { keyword: name, span: keyword.span });
        }
        let read = match keyword.name.as_str() {
            "PARAMETER" => return unread::parameter(self, keyword),
            "MODEL CHANGE" => unread::model_change(self, keyword)?,
            "IMPERFECTION" => unread::imperfection(self, keyword)?,
            "CONNECTOR UNIAXIAL BEHAVIOR" => {
                let component = keyword.get("COMPONENT").and_then(|value| value.component().ok());
                if let Ok(behavior) = self.behavior(keyword) {
                    behavior.uniaxial.extend(component);
                }
                0
            }
            "FASTENER" => {
                unread::fastener(self, keyword)?;
                0
            }
            "RESTART" | "IMPORT" => {
                unread::elsewhere(self, keyword);
                0
            }
            _ => 0,
        };
        let rest = self.lexer.skip()?;
        self.count_skipped(keyword, read + rest);
        Ok(())
    }

    fn count_skipped(&mut self, keyword: &Keyword, data_lines: u64) {
        // The longest name that is shown whole, in letters.
        const LONGEST: usize = 80;
        let name = match keyword.name.char_indices().nth(LONGEST) {
            Some((end, _)) => format!("{}…", &keyword.name[..end]),
            None => keyword.name.clone(),
        };
        let skipped = self.scene.skipped.keywords.entry(name).or_default();
        if skipped.count == 0 {
            skipped.first_line = keyword.span.line();
        }
        skipped.count += 1;
        skipped.data_lines += data_lines;
    }

    /// The behaviour that is being read.
    fn behavior(&mut self, keyword: &Keyword) -> Result<&mut Behavior> {
        match self.scene.behaviors.last_mut().filter(|_| self.behavior_open) {
            Some((_, behavior)) => Ok(behavior),
            None => Err(misplaced(keyword, ["*CONNECTOR BEHAVIOR"; 2])),
        }
    }
}

/// What cannot be: errors that were there are not any more.
pub(super) fn lost() -> Diagnostic {
    Diagnostic::error(Code::Unreadable, Span::default(), "an error was lost", "")
}

fn misplaced(keyword: &Keyword, host: [&str; 2]) -> Diagnostic {
    let [deck, field] = keyword.words();
    let message =
        [format!("{deck} does not follow {}", host[0]), format!("{field} does not follow {}", host[1])];
    let label = host.map(|host| format!("belongs to {host}"));
    Diagnostic::error(Code::MisplacedKeyword, keyword.span, message, label)
        .help(host.map(|host| format!("put it directly below {host}")))
}

impl Keyword {
    /// What it is called.
    fn words(&self) -> [String; 2] {
        keyword(&self.name)
    }

    /// Gives every parameter that is written by a beginning of exactly one of `names`, or without its blanks, that name.
    fn complete(&mut self, names: &[&str]) {
        for given in &mut self.parameters {
            let is_name = names.contains(&given.name.as_str());
            let joined = |name: &&&str| name.bytes().filter(|byte| *byte != b' ').eq(given.name.bytes());
            if let (false, Some(name)) = (is_name, names.iter().find(joined)) {
                (*name).clone_into(&mut given.name);
                continue;
            }
            let mut begun = names.iter().filter(|name| name.starts_with(given.name.as_str()));
            if let (false, Some(name), None) =
                (names.contains(&given.name.as_str()), begun.next(), begun.next())
                && !given.name.is_empty()
            {
                (*name).clone_into(&mut given.name);
            }
        }
    }

    /// The value of a parameter.
    fn get(&self, name: &str) -> Option<&Value> {
        self.parameters.iter().find(|parameter| parameter.name == name)?.value.as_ref()
    }

    /// Is the parameter there, with a value or without?
    fn has(&self, name: &str) -> bool {
        self.parameters.iter().any(|parameter| parameter.name == name)
    }

    fn name_of(&self, parameter: &str) -> Result<Option<Spanned<String>>> {
        self.get(parameter).map(Value::name).transpose()
    }

    fn need_name(&self, parameter: &str) -> Result<Spanned<String>> {
        match self.get(parameter) {
            Some(value) => value.name(),
            None => Err(self.missing(parameter)),
        }
    }

    fn missing(&self, parameter: &str) -> Diagnostic {
        let message = self.words().map(|keyword| format!("{keyword} needs the parameter {parameter}"));
        let [deck, field] = self.words();
        let remedy =
            [format!("write {deck}, {parameter}=…"), format!("write {field}, {}", parameter.to_lowercase())];
        Diagnostic::error(Code::MissingParameter, self.span, message, format!("{parameter} is missing"))
            .help(remedy)
    }

    fn number(&self, parameter: &str) -> Result<Option<f64>> {
        self.get(parameter).map(Value::number).transpose()
    }

    fn component(&self, parameter: &str) -> Result<Option<u8>> {
        self.get(parameter).map(Value::component).transpose()
    }

    fn need_component(&self) -> Result<u8> {
        self.component("COMPONENT")?.ok_or_else(|| self.missing("COMPONENT"))
    }

    fn word(&self, parameter: &str, words: &[&'static str]) -> Result<Option<&'static str>> {
        self.get(parameter).map(|value| value.word(parameter, words)).transpose()
    }

    fn choice<C: Choice>(&self, parameter: &str) -> Result<Option<C>> {
        Ok(self.word(parameter, C::SPELLINGS)?.and_then(C::of_spelling))
    }

    /// ON or OFF.
    fn switch(&self, parameter: &str) -> Result<Option<bool>> {
        Ok(self.word(parameter, &["ON", "OFF"])?.map(|word| word == "ON"))
    }

    /// `DEPENDENCIES=`: the number of field variables in a table.
    fn dependencies(&self) -> Result<usize> {
        let Some(value) = self.get("DEPENDENCIES") else { return Ok(0) };
        let count = value.integer("DEPENDENCIES")?;
        usize::try_from(count).ok().filter(|&count| count <= MAX_DEPENDENCIES).ok_or_else(|| {
            let message = format!("{count} field variables are too many");
            Diagnostic::error(Code::NumberOutOfRange, value.span, message, "too large")
                .help(format!("use at most {MAX_DEPENDENCIES}"))
        })
    }

    /// Two definitions called `name`.
    fn duplicate(&self, name: &Spanned<String>, first: Span) -> Diagnostic {
        let message = self.words().map(|keyword| format!("{keyword} {} is defined twice", name.value));
        let label = format!("first defined on line {}", first.line());
        Diagnostic::error(Code::DuplicateName, name.span, message, label)
            .beside(first)
            .help("rename or remove one of the two")
    }
}

/// The largest number of field variables in a table.
const MAX_DEPENDENCIES: usize = 100;
