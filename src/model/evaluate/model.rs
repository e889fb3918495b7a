//! A scene with its connection types, triads and constraints resolved.

use crate::behavior::drive::{Drives, Schedule, drives};
use crate::behavior::state::Behavior;
use crate::evaluate::belt;
use crate::evaluate::belt::Ring;
use crate::evaluate::mpc::MpcElement;
use crate::evaluate::relation::{RelationElement, relations};
use crate::evaluate::{mpc, plane, rules, shared};
use pintle_kinematics::catalog::{ConnectionType, EXPLICIT_STEP, NameError, Orientation, Rule};
use pintle_kinematics::connector::{Connector, Definition, Stop};
use pintle_kinematics::measure::Measure;
use pintle_kinematics::node::{Node, PSI_A, PSI_B, Pair};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::vector;
use pintle_kinematics::vector::{Matrix, column, identity, sub};
use pintle_scene as scene;
use pintle_scene::{Code, Diagnostic, End, Label, LabelMap, LabelSet, NodeFreedom, Scene, Solver, Span};
use std::cell::OnceCell;
use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::sync::Arc;

/// A connector element, ready to be evaluated.
#[derive(Clone, Debug)]
pub struct ConnectorElement {
    /// The element number.
    pub label: Label,
    /// The nodes a and b; `None` is the ground.
    pub nodes: [Option<Label>; 2],
    /// X_b − X_a.
    pub reference: [f64; 3],
    /// The connector.
    pub connector: Connector<f64>,
    /// What defines it, but for X_b − X_a: kept once for all connectors that agree in it.
    common: Arc<Definition>,
    /// Its behaviour, and its motions and loads.
    pub behavior: Arc<ElementBehavior>,
}

/// The behaviour of a connector, and what is prescribed for it.
#[derive(Clone, Debug, Default)]
pub struct ElementBehavior {
    /// Springs, dampers, locks …, shared by all connectors of a section.
    pub behavior: Arc<Behavior>,
    /// Motions and loads.
    pub drives: Drives,
    /// A number that tells this behaviour from others: saved histories belong to it.
    pub identity: u64,
}

/// What connectors agree in that are kept once: section, whether they are two-dimensional, whether their ends move and rotate, and the
/// bits of both triads.
type Agreeing = (usize, bool, [bool; 4], [u64; 18]);

/// What the connectors of a scene share while they are resolved.
struct Shared {
    /// The connection type of each section, and the warning that it is another one in a Standard analysis.
    types: HashMap<usize, (Arc<ConnectionType>, Option<usize>)>,
    actions: LabelMap<Vec<(usize, Span)>>,
    drives: BTreeMap<Label, Drives>,
    behaviors: HashMap<(usize, bool, u64), Arc<ElementBehavior>>,
    /// [`mean_length`], once it was asked for.
    mean_length: OnceCell<Option<f64>>,
    /// What connectors have in common, and one of them.
    common: HashMap<Agreeing, (Arc<Definition>, Connector<f64>)>,
    /// The last of all, with the same: mostly the next one agrees with it.
    last: Option<(Agreeing, Arc<Definition>, Connector<f64>)>,
    /// The warnings of each rule that a section breaks.
    warned: HashMap<(usize, Broken), Range<usize>>,
    /// What refuses the last connector.
    refused: Vec<Refusal>,
    freedom: NodeFreedom,
}

impl Shared {
    fn of(scene: &Scene) -> Self {
        Self {
            types: HashMap::new(),
            actions: rules::actions(scene),
            drives: BTreeMap::new(),
            behaviors: HashMap::new(),
            mean_length: OnceCell::new(),
            common: HashMap::new(),
            last: None,
            warned: HashMap::new(),
            refused: Vec::new(),
            freedom: NodeFreedom::of(scene),
        }
    }
}

/// What is broken, whichever element breaks it: it tells a refusal from others of its code at the same place.
#[derive(PartialEq, Eq, Hash)]
enum Broken {
    /// A rule of connection types, with what is wrong: others of it may be warned of at the same place.
    Rule(Rule, [String; 2]),
    /// A law, with what is wrong.
    Law(String),
    /// All that is refused with that code at the place.
    Other,
}

/// What refuses a scene.
struct Refusal {
    diagnostic: Diagnostic,
    broken: Broken,
}

impl From<Diagnostic> for Refusal {
    fn from(diagnostic: Diagnostic) -> Self {
        Self { diagnostic, broken: Broken::Other }
    }
}

/// A scene, resolved.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// Connectors in the order of the scene.
    pub connectors: Vec<ConnectorElement>,
    /// The rings of belts with friction, by the index of the SLIPRING that ends there.
    pub rings: BTreeMap<usize, Ring>,
    /// Multi-point constraints in the order of the scene.
    pub mpcs: Vec<MpcElement>,
    /// Equations, rigid bodies, couplings and ties.
    pub relations: Vec<RelationElement>,
    /// The springs and dashpots to ground that act on the angles of their hinges, by element number.
    pub grounded: LabelSet,
    /// The MPCs that are kept and not evaluated, by type, with their number.
    pub other_mpcs: BTreeMap<String, usize>,
    /// The connectors that constrain what another one between the same nodes constrains already.
    pub repeated: LabelSet,
    /// The steps in time.
    pub schedule: Schedule,
    /// Element sets: the connectors in each, by index.
    pub sets: BTreeMap<String, Vec<usize>>,
    /// The size of lengths in the model: the mean length of its connectors whose nodes are apart, else the diagonal of the box
    /// that holds its nodes, else 1.
    pub length: f64,
    /// The same, where the model has a size: its nodes do not all coincide.
    pub extent: Option<f64>,
    /// Rules broken that warn instead of refusing.
    pub warnings: Vec<Diagnostic>,
}

impl Model {
    /// Resolves a scene.
    ///
    /// # Errors
    /// The first documented rule that is broken, with the element, the rule and its source; an unknown connection type; an
    /// orientation that defines no directions.
    pub fn compile(scene: &Scene) -> Result<Self, Diagnostic> {
        let mut first = None;
        let model = Self::resolve(scene, &mut Shared::of(scene), &mut |error| {
            first = Some(error.diagnostic);
            false
        });
        first.map_or(Ok(model), Err)
    }

    /// Resolves a scene as far as it goes, with every error: a connector that breaks a rule is left out. What several connectors of
    /// one type break alike at one place is told once, of the first, with all of them ([`Diagnostic::elements`]).
    pub fn examine(scene: &Scene) -> (Self, Vec<Diagnostic>) {
        let mut errors: Vec<Diagnostic> = Vec::new();
        // What is broken, with its place among the errors.
        let mut seen: HashMap<(Code, Span), Vec<(Broken, usize)>> = HashMap::new();
        let mut shared = Shared::of(scene);
        let mut model = Self::resolve(scene, &mut shared, &mut |Refusal { diagnostic, broken }| {
            let at_place = seen.entry((diagnostic.code(), diagnostic.span())).or_default();
            let known = at_place.iter().find(|(known, _)| *known == broken).map(|(_, index)| *index);
            match known.and_then(|index| errors.get_mut(index)) {
                Some(error) => error.concern(diagnostic.elements()),
                None => {
                    at_place.push((broken, errors.len()));
                    errors.push(diagnostic);
                }
            }
            true
        });
        // What refuses a scene is not a warning besides.
        let warned = shared.warned.iter();
        let warned: HashMap<usize, &Broken> = warned
            .flat_map(|((_, broken), places)| places.clone().map(move |place| (place, broken)))
            .collect();
        let mut place = 0..;
        model.warnings.retain(|warning| {
            let broken = place.next().and_then(|place| warned.get(&place));
            let refused = seen.get(&(warning.code(), warning.span()));
            let is_it = |(known, _): &(Broken, usize)| {
                !matches!(known, Broken::Rule(..)) || broken.is_some_and(|broken| *broken == known)
            };
            !refused.is_some_and(|all| all.iter().any(is_it))
        });
        (model, errors)
    }

    /// Resolves a scene. Each error is told, which says whether to go on.
    fn resolve(scene: &Scene, shared: &mut Shared, tell: &mut dyn FnMut(Refusal) -> bool) -> Self {
        let extent = extent(scene);
        let mut model =
            Self { schedule: Schedule::new(scene), length: extent.unwrap_or(1.0), extent, ..Self::default() };
        let drives = drives(scene, &model.schedule, |target| rules::labels(scene, target).to_vec())
            .map_err(|error| error.in_file(&scene.name));
        match drives {
            Ok(drives) => shared.drives = drives,
            Err(error) => {
                if !tell(error.into()) {
                    return model;
                }
            }
        }
        for error in scene.orientation_errors() {
            if !tell(error.into()) {
                return model;
            }
        }
        model.connectors.reserve_exact(scene.connectors.len());
        let position = scene.positions();
        for (label, element) in &scene.connectors {
            let ends = [End::A, End::B].map(|end| position(element, end).unwrap_or_default());
            let broken = model.connector(scene, (*label, element), ends, shared).err().map(Refusal::from);
            for mut error in shared.refused.drain(..).chain(broken) {
                error.diagnostic.concern(&[*label]);
                if !tell(error) {
                    return model;
                }
            }
        }
        // Of sections that no element has, the type alone can be judged.
        let unused = scene.connector_sections.iter().enumerate();
        for (_, section) in unused.filter(|(place, _)| !shared.types.contains_key(place)) {
            if let Err(error) = resolve(section).map_err(|error| error.in_scene(scene))
                && !tell(error.into())
            {
                return model;
            }
        }
        for error in shared::check(scene, &mut model) {
            if !tell(error.into()) {
                return model;
            }
        }
        model.rings = belt::rings(scene, &mut model);
        rules::boundaries(scene, &shared.freedom, &mut model.warnings);
        plane::terms(scene, &mut model.warnings);
        rules::stiffnesses(scene, &mut model.warnings);
        for error in rules::constraints(scene) {
            if !tell(error.into()) {
                return model;
            }
        }
        if let Err(error) = model.join(scene, &shared.freedom, tell) {
            tell(error.into());
        }
        model.collect_sets(scene);
        model
    }

    /// Resolves one connector, whose ends are initially there; it is left out where a rule that it breaks leaves nothing to evaluate: all are told,
    /// in [`Shared::refused`].
    ///
    /// # Errors
    /// A connection type that does not exist.
    fn connector(
        &mut self,
        scene: &Scene,
        (label, element): (Label, &scene::ConnectorElement),
        ends: [[f64; 3]; 2],
        shared: &mut Shared,
    ) -> Result<(), Diagnostic> {
        let Shared {
            types,
            actions,
            drives,
            behaviors,
            mean_length: mean,
            common,
            last,
            warned,
            refused,
            freedom,
        } = shared;
        let Some(section) = scene.section(element) else { return Ok(()) };
        let (connection, converted) = match types.get(&element.section) {
            Some(known) => known,
            None => {
                let mut converted = None;
                let mut resolved = resolve(section).map_err(|error| error.in_scene(scene))?;
                if let (Some(Solver::Standard), Some(other)) = (scene.solver, resolved.in_standard()) {
                    let (name, becomes) = (&resolved.name, &other.name);
                    let message = format!("element {label}: {name} is {becomes} in a Standard analysis");
                    let here = format!("by {}", resolved.pages());
                    let place = section.type_names.first().map_or(section.span, |name| name.span);
                    let warning = Diagnostic::warning(Code::ConvertedInStandard, place, message, here)
                        .help(EXPLICIT_STEP.map(|step| format!("write {becomes}, or use {step}")));
                    converted = Some(self.warnings.len());
                    self.warnings.push(warning.in_scene(scene));
                    resolved = other;
                }
                types.entry(element.section).or_insert((Arc::new(resolved), converted))
            }
        };
        if let Some(warning) = converted.and_then(|index| self.warnings.get_mut(index)) {
            warning.concern(&[label]);
        }
        let moving = [element.a, element.b];
        let reference = sub(ends[1], ends[0]);
        let behavior = scene.behavior(section);

        let mut references = [None; 6];
        let mut stops = [None; 6];
        let acting = actions.get(&label).map(Vec::as_slice).unwrap_or_default();
        let facts = rules::facts(scene, (section, element), behavior, acting, reference == [0.0; 3]);
        if let Some(behavior) = behavior {
            references = behavior.constitutive_reference;
            stops =
                behavior.limits_of_stops().map(|limits| limits.map(|[lower, upper]| Stop { lower, upper }));
        }
        let mut is_left_out = false;
        for breach in connection.breaches(&facts) {
            let places = rules::places(scene, &breach, behavior, acting, (section, element));
            let told = places.into_iter().map(|place| rules::diagnose(&breach, label, place, scene));
            if breach.refuses() {
                for diagnostic in told {
                    is_left_out |= !diagnostic.code().leaves_numbers();
                    let broken = Broken::Rule(breach.rule, breach.message.clone());
                    refused.push(Refusal { diagnostic, broken });
                }
                continue;
            }
            // Once for all elements of a section.
            let first = self.warnings.len();
            let broken = Broken::Rule(breach.rule, breach.message.clone());
            let known = warned.entry((element.section, broken)).or_insert_with(|| {
                self.warnings.extend(told);
                first..self.warnings.len()
            });
            let warnings = self.warnings.get_mut(known.clone()).into_iter().flatten();
            warnings.for_each(|warning| warning.concern(&[label]));
        }
        let mut refuse = |errors: Vec<Diagnostic>| {
            is_left_out |= !errors.is_empty();
            refused.extend(errors.into_iter().map(Refusal::from));
        };
        refuse(plane::nodes(scene, label, element));

        let nodes: Vec<[f64; 3]> = ends.to_vec();
        let triad = |end: usize| -> Result<Option<Matrix<f64>>, Diagnostic> {
            let name = if end == 0 { &section.orientation_a } else { &section.orientation_b };
            if connection.orientation[end].orientation == Orientation::Ignored {
                return Ok(None);
            }
            let Some(name) = name else { return Ok(None) };
            let Some(orientation) = scene.orientations.get(name.value.as_str()) else { return Ok(None) };
            let directions = orientation
                .triad(&name.value, scene, ends[end], &nodes)
                .map_err(|error| error.in_scene(scene))?;
            Ok(Some(vector::transpose(&directions)))
        };
        let given = [0, 1].map(|end| {
            triad(end).unwrap_or_else(|error| {
                refuse(vec![error]);
                None
            })
        });
        if facts.planar {
            refuse(plane::orientations(scene, label, section, &given));
        }
        let [given_a, given_b] = given;
        let triad_a = given_a.unwrap_or_else(identity);
        let triad_b = given_b.unwrap_or(triad_a);
        let uses_direction = connection.slots[0].position() == Some(Measure::Distance)
            && scene.solver != Some(Solver::Explicit);
        let fixed_direction = match given_a.or(given_b) {
            Some(triad) if uses_direction => column(&triad, 0),
            _ => [0.0; 3],
        };
        let node = |triad| Node { displacement: [0.0; 3], triad, flow: 0.0 };
        let definition = Definition {
            connection: Arc::clone(connection),
            initial: Pair { reference, a: node(triad_a), b: node(triad_b) },
            flow_scale: section.section_data.first().copied().flatten().unwrap_or(1.0),
            fixed_direction,
            references,
            stops,
            planar: facts.planar,
            moves: moving.map(|node| node.is_some()),
            rotates: moving.map(|node| node.is_some_and(|node| freedom.rotates(node))),
        };
        let has_friction = behavior.is_some_and(|behavior| !behavior.friction.is_empty());
        // The default stick stiffness follows the length of the connector.
        let own_length = norm(reference);
        let length = match (has_friction, own_length > 0.0) {
            (false, _) => 1.0,
            (true, true) => own_length,
            (true, false) => mean.get_or_init(|| mean_length(scene)).unwrap_or(1.0),
        };
        let shared = match behaviors.entry((element.section, facts.planar, length.to_bits())) {
            Entry::Occupied(known) => Arc::clone(known.get()),
            Entry::Vacant(place) => {
                let is_explicit = scene.solver == Some(Solver::Explicit);
                let build = |given: &scene::Behavior| {
                    Behavior::new(given, connection, facts.planar, is_explicit, length)
                };
                let law = match behavior.map(|given| (given, build(given))) {
                    Some((_, Ok(law))) => law,
                    Some((given, Err(error))) => {
                        let errors = each_wrong_law(given, error, build).into_iter();
                        let errors = errors.map(|error| error.in_file(&scene.name));
                        // What is refused already may be what makes a law wrong.
                        let is_new = |error: &Diagnostic| {
                            refused.iter().all(|known| known.diagnostic.span() != error.span())
                        };
                        let errors: Vec<Diagnostic> = errors.filter(is_new).collect();
                        refused.extend(errors.into_iter().map(|diagnostic| {
                            let broken = Broken::Law(diagnostic.message().to_string());
                            Refusal { diagnostic, broken }
                        }));
                        return Ok(());
                    }
                    None => Behavior::none(connection, facts.planar),
                };
                let behavior = Arc::new(law);
                let identity = scene.behavior(section).map_or(0, fingerprint);
                Arc::clone(place.insert(Arc::new(ElementBehavior {
                    behavior,
                    identity,
                    ..Default::default()
                })))
            }
        };
        if is_left_out {
            return Ok(());
        }
        let behavior = match drives.remove(&label) {
            Some(drives) => Arc::new(ElementBehavior { drives, ..(*shared).clone() }),
            None => shared,
        };
        let mut connector = Connector::new(&definition);
        let mut triads = [0; 18];
        for (bits, entry) in triads.iter_mut().zip([triad_a, triad_b].as_flattened().as_flattened()) {
            *bits = entry.to_bits();
        }
        let [[a, b], [of_a, of_b]] = [definition.moves, definition.rotates];
        let agreeing = (element.section, facts.planar, [a, b, of_a, of_b], triads);
        let common = match last.as_ref().filter(|(known, ..)| *known == agreeing) {
            Some((_, common, alike)) => {
                connector.share(alike);
                Arc::clone(common)
            }
            None => match common.entry(agreeing) {
                Entry::Occupied(known) => {
                    let (common, alike) = known.get();
                    connector.share(alike);
                    Arc::clone(common)
                }
                Entry::Vacant(place) => {
                    let initial = Pair { reference: [0.0; 3], ..definition.initial };
                    let common = Arc::new(Definition { initial, ..definition });
                    place.insert((Arc::clone(&common), connector.clone()));
                    common
                }
            },
        };
        *last = Some((agreeing, Arc::clone(&common), connector.clone()));
        self.connectors.push(ConnectorElement {
            behavior,
            label,
            nodes: moving,
            reference,
            connector,
            common,
        });
        Ok(())
    }

    /// Makes the constraints. What leaves them all the same is told, and the rest is done where that says to go on.
    fn join(
        &mut self,
        scene: &Scene,
        freedom: &NodeFreedom,
        tell: &mut dyn FnMut(Refusal) -> bool,
    ) -> Result<(), Diagnostic> {
        let flows: LabelSet = self.connectors.iter().flat_map(ConnectorElement::flowing).collect();
        let mut joined = Vec::new();
        for mpc in &scene.mpcs {
            match mpc.kind.evaluated() {
                Some(kind) => {
                    let element = MpcElement::new(kind, mpc, scene, |node| flows.contains(&node));
                    joined.push((element, mpc.span));
                }
                None => *self.other_mpcs.entry(mpc.kind.name().to_string()).or_default() += 1,
            }
        }
        let [errors, warnings] = mpc::check(scene, &joined);
        self.warnings.extend(warnings);
        for error in errors {
            if !tell(error.into()) {
                return Ok(());
            }
        }
        self.grounded = mpc::ground(scene, &mut joined)?;
        mpc::drive(scene, &self.schedule, &mut joined)?;
        self.mpcs = joined.into_iter().map(|(element, _)| element).collect();
        self.relations = relations(scene, freedom, &self.mpcs).map_err(|error| error.in_scene(scene))?;
        Ok(())
    }

    fn collect_sets(&mut self, scene: &Scene) {
        let index: LabelMap<usize> =
            self.connectors.iter().enumerate().map(|(i, connector)| (connector.label, i)).collect();
        for (name, set) in &scene.element_sets {
            let members: Vec<usize> =
                set.labels.iter().filter_map(|label| index.get(label).copied()).collect();
            if !members.is_empty() {
                self.sets.insert(name.clone(), members);
            }
        }
    }
}

/// What is wrong with a behaviour that is: of each law that is wrong by itself, or where none is, of all together.
fn each_wrong_law<T>(
    given: &scene::Behavior,
    of_all: Diagnostic,
    build: impl Fn(&scene::Behavior) -> Result<T, Diagnostic>,
) -> Vec<Diagnostic> {
    let empty = scene::Behavior {
        elasticity: Vec::new(),
        damping: Vec::new(),
        friction: Vec::new(),
        locks: Vec::new(),
        failures: Vec::new(),
        ..given.clone()
    };
    let one = |put: &dyn Fn(&mut scene::Behavior)| {
        let mut alone = empty.clone();
        put(&mut alone);
        build(&alone).err()
    };
    let frictions = given.friction.iter().filter_map(|law| one(&|alone| alone.friction.push(law.clone())));
    let elasticities =
        given.elasticity.iter().filter_map(|law| one(&|alone| alone.elasticity.push(law.clone())));
    let dampings = given.damping.iter().filter_map(|law| one(&|alone| alone.damping.push(law.clone())));
    let locks = given.locks.iter().filter_map(|law| one(&|alone| alone.locks.push(law.clone())));
    let failures = given.failures.iter().filter_map(|law| one(&|alone| alone.failures.push(law.clone())));
    let found: Vec<Diagnostic> =
        frictions.chain(elasticities).chain(dampings).chain(locks).chain(failures).collect();
    if found.is_empty() { vec![of_all] } else { found }
}

/// The connection type that a section names.
fn resolve(section: &scene::ConnectorSection) -> Result<ConnectionType, Diagnostic> {
    let [first, rest @ ..] = section.type_names.as_slice() else {
        let message = "a connector section without a connection type";
        return Err(Diagnostic::error(Code::UnknownConnectionType, section.span, message, "no type follows")
            .help("name one type, or a basic translational and a basic rotational type, on the next line"));
    };
    let second = rest.first();
    ConnectionType::named(&first.value, second.map(|name| name.value.as_str())).map_err(|error| {
        let (span, remedy) = match &error {
            NameError::Unknown { name, nearest } => {
                let second_is_wrong = second.is_some_and(|other| other.value.eq_ignore_ascii_case(name));
                let span = second.filter(|_| second_is_wrong).map_or(first.span, |other| other.span);
                let remedy = match (two_types(name), nearest) {
                    (Some([one, two]), _) => format!("write {one}, {two}: a comma separates two types"),
                    (None, Some(nearest)) => format!("write {nearest}, or see `pintle list`"),
                    (None, None) => "`pintle list` shows the types there are".to_string(),
                };
                (span, remedy)
            }
            NameError::Pair { .. } => {
                (first.span, "use several connector elements on the same nodes for anything else".to_string())
            }
        };
        Diagnostic::error(Code::UnknownConnectionType, span, error.to_string(), "this type").help(remedy)
    })
}

/// The two types that a name without a comma was meant to be: `JOIN REVOLUTE`.
fn two_types(name: &str) -> Option<[&str; 2]> {
    let breaks = name.match_indices([' ', '+', '-', '/', ';']);
    let halves = breaks.map(|(place, sign)| [&name[..place], &name[place + sign.len()..]].map(str::trim));
    halves.into_iter().find(|[one, two]| ConnectionType::named(one, Some(two)).is_ok())
}

/// The mean length of the connectors of a scene whose nodes are apart; `None` where there is none.
fn mean_length(scene: &Scene) -> Option<f64> {
    let position = scene.positions();
    let length = |element: &scene::ConnectorElement| {
        let at = |end| position(element, end).unwrap_or_default();
        norm(sub(at(End::B), at(End::A)))
    };
    let lengths: Vec<f64> = scene.connectors.values().map(length).filter(|length| *length > 0.0).collect();
    (!lengths.is_empty()).then(|| lengths.iter().sum::<f64>() / lengths.len() as f64)
}

/// See [`Model::extent`].
fn extent(scene: &Scene) -> Option<f64> {
    let diagonal = || {
        let mut corners: Option<[[f64; 3]; 2]> = None;
        for node in scene.nodes.values() {
            let x = node.coordinates;
            let [low, high] = corners.unwrap_or([x; 2]);
            corners = Some([[0, 1, 2].map(|i| low[i].min(x[i])), [0, 1, 2].map(|i| high[i].max(x[i]))]);
        }
        corners.map_or(0.0, |[low, high]| norm(sub(high, low)))
    };
    let found = mean_length(scene).unwrap_or_else(diagonal);
    (found > 0.0 && found.is_finite()).then_some(found)
}

/// A number that tells a behaviour from others: FNV-1a over what the deck says.
fn fingerprint(behavior: &scene::Behavior) -> u64 {
    let text = serde_json::to_string(behavior).unwrap_or_default();
    let step = |hash: u64, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    text.bytes().fold(0xcbf2_9ce4_8422_2325, step)
}

impl ConnectorElement {
    /// What defines it.
    pub fn definition(&self) -> Definition {
        Definition { initial: self.initial(), ..(*self.common).clone() }
    }

    /// Its initial state.
    pub fn initial(&self) -> Pair<f64> {
        Pair { reference: self.reference, ..self.common.initial }
    }

    /// The initial triads of a and b.
    pub fn triads(&self) -> [&Matrix<f64>; 2] {
        let Pair { a, b, .. } = &self.common.initial;
        [&a.triad, &b.triad]
    }

    /// Whether it is two-dimensional.
    pub fn is_planar(&self) -> bool {
        self.common.planar
    }

    /// Its nodes whose material flow enters it.
    fn flowing(&self) -> impl Iterator<Item = Label> + '_ {
        let active = self.connector.active();
        self.nodes.into_iter().zip([PSI_A, PSI_B]).filter_map(move |(node, j)| node.filter(|_| active[j]))
    }

    /// Its type and number: `HINGE 101`.
    pub fn title(&self) -> String {
        format!("{} {}", self.connector.connection().name, self.label)
    }
}
