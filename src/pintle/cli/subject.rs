//! What a routine is to be, as the command line names it, and the states at which it is asked.

use super::compare::any_states;
use super::eval::{read, source};
use super::states::deck;
use super::{Failure, connection};
use pintle_audit::sampling::{Turning, aligned, definition, pair, turning};
use pintle_audit::{FrictionSubject, connector_at, constraint_at};
use pintle_kinematics::catalog::ConnectionType;
use pintle_kinematics::connector::{Definition, Request};
use pintle_kinematics::draw::Draw;
use pintle_kinematics::mpc::{Constraint, MpcType};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3;
use pintle_model::evaluate::{Model, Plan, Selection};
use pintle_scene::{Label, Scene, State};
use std::path::Path;

/// A connector that is named on the command line.
pub(crate) struct Subject {
    pub(crate) definition: Definition,
    /// Its nodes; of a type 1 and 2.
    pub(crate) nodes: [Option<Label>; 2],
    pub(crate) is_of_scene: bool,
}

/// States of one's own.
#[derive(Clone, Copy, Debug)]
pub struct At<'a> {
    /// A file with motions of nodes: 1 (a) and 2 (b) of a type, those of the scene otherwise.
    pub file: &'a Path,
    /// Whether each state follows the initial one, in place of the state before.
    pub independent: bool,
}

/// The scene and the name of what is meant in it. The last colon: a gallery scene has one of its own.
pub(crate) fn in_scene(name: &str) -> Option<(&str, &str)> {
    name.rsplit_once(':').filter(|(scene, _)| *scene != "gallery")
}

/// A connection type, or two basic ones: `CARTESIAN, CARDAN`, `CARTESIAN + CARDAN` or `CARTESIAN CARDAN`.
pub(crate) fn type_of(name: &str) -> Result<ConnectionType, Failure> {
    let name = name.trim();
    let apart = name.split_once([',', '+']).map(|(one, other)| (one.trim(), other.trim()));
    if let Some((one, other)) = apart {
        return connection(one, Some(other));
    }
    // A name may have a space of its own.
    let spaces = name.match_indices(' ').map(|(at, _)| (name[..at].trim(), name[at..].trim()));
    let of_two = || spaces.into_iter().find_map(|(one, other)| connection(one, Some(other)).ok());
    connection(name, None).or_else(|failure| of_two().ok_or(failure))
}

/// What a report says of a TYPE whose misaligned axes are another branch of its formulas: it is drawn without them.
pub(crate) fn drawn_aligned(word: &str) -> Option<String> {
    let connection = in_scene(word).map_or_else(|| type_of(word).ok(), |_| None)?;
    let holds = matches!(turning(&connection), Turning::Align | Turning::Revolute | Turning::Universal);
    let name = &connection.name;
    holds.then(|| {
        format!("misaligned initial axes are another branch of {name}, and are not asked: a connector of a scene may have them")
    })
}

/// The connector of a TYPE: both triads are oblique, and satisfy what the type constrains.
fn of_type(connection: &ConnectionType) -> Definition {
    let draw = &mut Draw::new("the connector of a check");
    let a = so3::exp([0.4, -0.3, 0.7]);
    let relative = aligned(connection, draw);
    definition(connection, pair([0.7, -0.4, 0.9], a, &relative), 1.2)
}

/// The connector of a TYPE, or of SCENE:ELEMENT.
pub(crate) fn named(name: &str) -> Result<Subject, Failure> {
    if let Some((scene, element)) = in_scene(name) {
        let source = source(scene)?;
        let (scene, _) = read(source, None)?;
        let model = Model::compile(&scene).map_err(|error| source.quoted(error))?;
        let element = &model.connectors[one_connector(&model, element)?];
        return Ok(Subject { definition: element.definition(), nodes: element.nodes, is_of_scene: true });
    }
    let definition = of_type(&type_of(name)?);
    Ok(Subject { definition, nodes: [1, 2].map(|node| Some(Label::of(None, node))), is_of_scene: false })
}

/// All connectors of a scene, compiled once, and the states of a file at which they are asked.
pub(crate) struct Connectors {
    scene: String,
    model: Model,
    at: Option<(Vec<State>, bool)>,
}

impl Connectors {
    /// As `SCENE:ELEMENT` names each.
    pub(crate) fn names(&self) -> Vec<String> {
        self.model.connectors.iter().map(|element| format!("{}:{}", self.scene, element.label)).collect()
    }

    /// What a routine is to be, of each, with its name.
    pub(crate) fn subjects(&self) -> impl Iterator<Item = (String, pintle_check::Subject)> {
        self.names().into_iter().zip(&self.model.connectors).enumerate().map(|(place, (name, element))| {
            let at = self.at.as_ref();
            let cases =
                at.map(|(states, independent)| connector_at(&self.model, place, states, *independent));
            (
                name,
                pintle_check::Subject::Connector(Box::new(element.definition()), cases.unwrap_or_default()),
            )
        })
    }
}

/// A bare scene with connectors, and the states of a file; `None` where the name is no scene.
pub(crate) fn model_of_scene(name: &str, at: Option<&Path>) -> Result<Option<(Model, Vec<State>)>, Failure> {
    let is_gallery = name.strip_prefix("gallery:").is_some_and(|rest| !rest.contains(':'));
    if !is_gallery && !Path::new(name).is_file() {
        return Ok(None);
    }
    let source = source(name)?;
    let (scene, states) = read(source, at)?;
    let model = Model::compile(&scene).map_err(|error| source.quoted(error))?;
    if model.connectors.is_empty() {
        return Err(Failure::Input(format!("{name} has no connector; \"MPC SCENE:S-M\" names a constraint")));
    }
    if let (Some(at), true) = (at, states.is_empty()) {
        return Err(Failure::Input(format!("{} has no states", at.display())));
    }
    Ok(Some((model, states)))
}

/// The connectors of a bare scene; `None` where the name is no scene.
pub(crate) fn of_scene(name: &str, at: Option<At<'_>>) -> Result<Option<Connectors>, Failure> {
    let found = model_of_scene(name, at.map(|at| at.file))?;
    Ok(found.map(|(model, states)| Connectors {
        scene: name.to_string(),
        model,
        at: at.map(|at| (states, at.independent)),
    }))
}

/// A connector with the states of a file.
fn connector_with(name: &str, at: At<'_>) -> Result<pintle_check::Subject, Failure> {
    let (model, element, states) = match in_scene(name) {
        Some((scene, element)) => {
            let source = source(scene)?;
            let (scene, states) = read(source, Some(at.file))?;
            let model = Model::compile(&scene).map_err(|error| source.quoted(error))?;
            let element = one_connector(&model, element)?;
            (model, element, states)
        }
        None => {
            let scene = Scene::parse("type.inp", &deck(&of_type(&type_of(name)?)))?;
            let states = any_states(at.file, &scene)?;
            (Model::compile(&scene)?, 0, states)
        }
    };
    let cases = connector_at(&model, element, &states, at.independent);
    let Some(connector) = model.connectors.get(element).filter(|_| !cases.is_empty()) else {
        return Err(Failure::Input(format!("{} has no states", at.file.display())));
    };
    Ok(pintle_check::Subject::Connector(Box::new(connector.definition()), cases))
}

/// The multi-point constraint of a kind, its nodes apart along no global axis and axes of hinges at a right angle; or that of a
/// scene, by its nodes.
fn constraint(name: &str, at: Option<At<'_>>) -> Result<pintle_check::Subject, Failure> {
    let Some((scene, nodes)) = in_scene(name) else {
        if at.is_some() {
            return Err(Failure::Usage(
                "states of your own need the nodes of a scene: \"MPC SCENE:S-M\"".into(),
            ));
        }
        let kind = MpcType::named(name).ok_or_else(|| {
            let kinds: Vec<&str> = MpcType::ALL.into_iter().map(MpcType::name).collect();
            Failure::Usage(format!(
                "there is no MPC {name}; there are {}, and SCENE:S-M by nodes",
                kinds.join(", ")
            ))
        })?;
        let hinges = [[1.0, -2.0, 2.0], [2.0, 2.0, 1.0]];
        return Ok((&Constraint::new(kind, [0.7, -0.4, 0.9], [0.0; 3], hinges)).into());
    };
    let source = source(scene)?;
    let (scene, states) = read(source, at.map(|at| at.file))?;
    let model = Model::compile(&scene).map_err(|error| source.quoted(error))?;
    // By its nodes, or where several have the same, by its kind and nodes.
    let is_named = |index: &usize| {
        let mpc = &model.mpcs[*index];
        let kind_and_nodes = format!("{} {}", mpc.constraint.kind().name(), mpc.label());
        mpc.label() == nodes || kind_and_nodes.eq_ignore_ascii_case(nodes)
    };
    let named: Vec<usize> = (0..model.mpcs.len()).filter(is_named).collect();
    let [index] = named.as_slice() else {
        let all: Vec<String> = model.mpcs.iter().take(8).map(|mpc| mpc.label()).collect();
        let known = if all.is_empty() { "none".into() } else { all.join(", ") };
        let message = match named.len() {
            0 => format!("the scene has no MPC of the nodes {nodes}; there are {known}"),
            count => {
                format!("the scene has {count} MPCs of the nodes {nodes}: put the kind of one before them")
            }
        };
        return Err(Failure::Usage(message));
    };
    let cases = at.map(|at| constraint_at(&model, *index, &states, at.independent)).unwrap_or_default();
    if let (Some(at), true) = (at, cases.is_empty()) {
        return Err(Failure::Input(format!("{} has no states", at.file.display())));
    }
    Ok(pintle_check::Subject::Constraint(Box::new(model.mpcs[*index].constraint), cases))
}

/// What a routine is to be, as the command line names it, and where it is asked.
pub(crate) fn found(name: &str, at: Option<At<'_>>) -> Result<pintle_check::Subject, Failure> {
    match (name.trim().split_once(char::is_whitespace), at) {
        (Some((word, of)), _) if word.eq_ignore_ascii_case("MPC") => constraint(of.trim(), at),
        (Some((word, of)), None) if word.eq_ignore_ascii_case("FRICTION") => Ok(friction(of.trim())?.into()),
        (Some((word, _)), Some(_)) if word.eq_ignore_ascii_case("FRICTION") => {
            Err(Failure::Usage("a friction is asked at forces that are drawn, not at states of nodes".into()))
        }
        (_, Some(at)) => connector_with(name, at),
        (_, None) => Ok((&named(name)?.definition).into()),
    }
}

/// The friction of a connector of a scene, or the predefined one of a type; a number in front is that of one of several, from 1 on.
fn friction(name: &str) -> Result<FrictionSubject, Failure> {
    let numbered = name.split_once(char::is_whitespace);
    let numbered = numbered.and_then(|(number, of)| Some((number.parse::<usize>().ok()?, of.trim())));
    let (number, of) = numbered.map_or((None, name), |(number, of)| (Some(number), of));
    let Some((scene, element)) = in_scene(of) else {
        let connection = type_of(of)?;
        let found = FrictionSubject::predefined(&connection, number.unwrap_or(1).saturating_sub(1));
        let lacks = || match number {
            Some(number) => format!("{of} has no predefined friction {number} of a criterion Φ = P − μ F_N"),
            None => format!("{of} has no predefined friction of a criterion Φ = P − μ F_N"),
        };
        return found.ok_or_else(|| Failure::Usage(lacks()));
    };
    let source = source(scene)?;
    let (scene, _) = read(source, None)?;
    let model = Model::compile(&scene).map_err(|error| source.quoted(error))?;
    let element = one_connector(&model, element)?;
    let connector = &model.connectors[element];
    let frictions = &connector.behavior.behavior.friction.frictions;
    let friction = match (number, frictions.as_slice()) {
        (None, [one]) => one,
        (Some(number), all) if number > 0 && number <= all.len() => &all[number - 1],
        (_, []) => return Err(Failure::Usage(format!("{of} has no friction of a criterion Φ = P − μ F_N"))),
        (_, all) => {
            return Err(Failure::Usage(format!(
                "{of} has {} frictions: name one, as \"FRICTION 1 {of}\"",
                all.len()
            )));
        }
    };
    let definition = connector.definition();
    let length = Some(norm(definition.initial.reference)).filter(|length| *length > 0.0).unwrap_or(1.0);
    FrictionSubject::new(of.to_string(), (*definition.connection).clone(), friction.clone(), length)
        .map_err(Failure::Usage)
}

/// The place of the one connector that an element names.
fn one_connector(model: &Model, element: &str) -> Result<usize, Failure> {
    let plan = Plan::compile(model, &Selection::Named(vec![element.to_string()]), Request::nothing(0))
        .map_err(|error| Failure::Usage(error.to_string()))?;
    match plan.connectors.as_slice() {
        [one] => Ok(*one),
        all => Err(Failure::Usage(format!(
            "{element} names {} connectors: name one by its element number",
            all.len()
        ))),
    }
}

/// What a routine is to be, and the states at which it is asked, where none are to be drawn.
///
/// | name | what |
/// |---|---|
/// | `TYPE`, `TYPE TYPE` | a connection type at two oblique triads |
/// | `SCENE:ELEMENT` | a connector of a scene |
/// | `MPC KIND`, `MPC SCENE:S-M` | a multi-point constraint |
/// | `FRICTION TYPE`, `FRICTION SCENE:ELEMENT` | a friction |
///
/// # Errors
/// In words, where there is none of that name.
pub fn subject(name: &str, at: Option<At<'_>>) -> Result<pintle_check::Subject, String> {
    found(name, at).map_err(|failure| failure.to_string())
}
