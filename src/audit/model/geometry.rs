//! Are the directions of a scene what they look like? Orientations that are not at right angles, or lost in rounding; directions that
//! nobody gave; axes that are not aligned.

use crate::model::finding::{About, Finding};
use crate::model::gather::Gathered;
use crate::model::levels::Levels;
use crate::model::still::{Bodies, Still, may_fail};
use pintle_kinematics::catalog::{COMPONENT, Condition, Orientation as Given, Slot};
use pintle_kinematics::connector::{Increment, Output, Request, State, Tally};
use pintle_kinematics::measure::{Measure, Unit};
use pintle_kinematics::node::DOFS;
use pintle_kinematics::scalar::U;
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::vector::{Vector, cross, dot, sub};
use pintle_model::evaluate::{ConnectorElement, Model};
use pintle_scene::grammar::count;
use pintle_scene::grammar::number as short;
use pintle_scene::{Code, Diagnostic, Label, Orientation, Scene, Severity, Span, System};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::f64::consts::FRAC_PI_2;

/// How far from right angles (rad) two directions are taken for orthogonal: as a deck of seven digits has them.
const ORTHOGONAL: f64 = 1e-6;
/// How far from right angles (rad) they may be and look like an error.
const NEARLY: f64 = 10.0 * std::f64::consts::PI / 180.0;
/// By how much (rad) rounding may turn directions.
const CERTAIN: f64 = 1e-8;
/// Angles that count as zero initially: those of aligned axes carry a few roundings.
const ALIGNED: f64 = 1e-12;

/// What is found of coordinates, orientations and axes.
pub(super) fn findings(scene: &Scene, model: &Model, levels: &Levels) -> Vec<Finding> {
    let mut found: Vec<Finding> = overflow(scene, model).into_iter().collect();
    found.extend(orientations(scene, model));
    let mut gathered = Gathered::new(levels);
    for element in &model.connectors {
        let Some(given) = scene.connectors.get(&element.label) else { continue };
        let section = scene.section(given);
        let place = section.map_or(given.span, |section| section.span);
        let found =
            [missing(scene, element, place), misaligned(scene, element, place), close(scene, element)];
        for finding in found.into_iter().flatten() {
            gathered.add((given.section, None), element.label, finding, |new, old| new.value > old.value);
        }
    }
    found.extend(gathered.findings());
    found
}

/// Nodes of connectors and constraints whose coordinates are so large that the squares of distances between them may overflow.
fn overflow(scene: &Scene, model: &Model) -> Option<Finding> {
    // Three squares of differences of two coordinates: 3 (2 x)².
    let limit = (f64::MAX / 12.0).sqrt();
    let of_connectors = model.connectors.iter().flat_map(|element| element.nodes.into_iter().flatten());
    let used: BTreeSet<Label> = of_connectors
        .chain(model.mpcs.iter().flat_map(|mpc| mpc.nodes.iter().copied()))
        .chain(model.relations.iter().flat_map(|relation| relation.nodes.iter().copied()))
        .collect();
    let largest = |label: &Label| {
        let node = scene.nodes.get(label)?;
        let most = node.coordinates.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        (most > limit).then_some((*label, most, node.span))
    };
    let nodes: Vec<(Label, f64, Span)> = used.iter().filter_map(largest).collect();
    let (first, most, place) = nodes.iter().copied().max_by(|x, y| x.1.total_cmp(&y.1))?;
    let others = match nodes.len() - 1 {
        0 => String::new(),
        more => format!(" (and those of {})", count(more, "other node")),
    };
    let message = format!(
        "the coordinates of node {first} are as large as {most}{others}: squares of distances overflow",
        most = short(most, 2)
    );
    let reason = format!(
        "beyond {limit} the square of a distance has no finite number in 64 bits; what overflows is undecided",
        limit = short(limit, 2)
    );
    let remedy = "check the coordinates; choose another unit of length";
    let finding = Finding::new(scene, Code::ModelStateNotFinite, place, message, reason, remedy);
    let nodes = nodes.iter().map(|(label, ..)| *label).take(100).collect();
    Some(finding.about(About { nodes, value: Some(most), ..About::default() }))
}

/// The orientations that connectors use, each once: where its points are worst.
fn orientations(scene: &Scene, model: &Model) -> Vec<Finding> {
    let mut worst: HashMap<&str, (f64, Finding)> = HashMap::new();
    let mut order: Vec<&str> = Vec::new();
    for element in &model.connectors {
        let Some(given) = scene.connectors.get(&element.label) else { continue };
        let Some(section) = scene.section(given) else { continue };
        let ends = [pintle_scene::End::A, pintle_scene::End::B];
        for ((name, end), rule) in [&section.orientation_a, &section.orientation_b]
            .into_iter()
            .zip(ends)
            .zip(element.connector.connection().orientation)
        {
            let Some(name) = name.as_ref().filter(|_| rule.orientation != Given::Ignored) else { continue };
            let Some(orientation) = scene.orientations.get(name.value.as_str()) else { continue };
            let point = scene.position(given, end).unwrap_or_default();
            // One that is the same everywhere is looked at once.
            if worst.contains_key(name.value.as_str()) && !orientation.depends_on_point() {
                continue;
            }
            let Some((size, finding)) = orientation_at(scene, &name.value, orientation, point, element)
            else {
                continue;
            };
            match worst.get(name.value.as_str()) {
                Some((known, _)) if *known >= size => {}
                known => {
                    if known.is_none() {
                        order.push(&name.value);
                    }
                    worst.insert(&name.value, (size, finding));
                }
            }
        }
    }
    order.into_iter().filter_map(|name| worst.remove(name)).map(|(_, finding)| finding).collect()
}

/// The angle between the two directions by which an orientation is given at a point, and by how much the rounding of their points turns them
/// (rad).
fn sides(
    scene: &Scene,
    name: &str,
    orientation: &Orientation,
    point: Vector<f64>,
    element: &ConnectorElement,
) -> Option<(f64, f64)> {
    let nodes =
        scene.connectors.get(&element.label).map(|given| scene.element_nodes(given)).unwrap_or_default();
    let [a, b, c] = orientation.points(name, scene, &nodes).ok()?;
    let is_rectangular = matches!(orientation.system, System::Rectangular | System::ZRectangular);
    let (origin, first, second) = if is_rectangular { (c, a, b) } else { (a, b, point) };
    let [u, v] = [sub(first, origin), sub(second, origin)];
    let angle = norm(cross(u, v)).atan2(dot(u, v));
    // Each coordinate is a rounded number: the ends of a direction are uncertain by u·√3 times the largest.
    let largest = |p: Vector<f64>| p.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let uncertain = |p| U * 3.0_f64.sqrt() * (largest(p) + largest(origin));
    let turned = [uncertain(first) / norm(u), uncertain(second) / (norm(v) * angle.sin())];
    Some((angle, turned[0].max(turned[1])))
}

/// By how much (rad) the rounding of the points of its orientations turns the initial directions of a connector at a and b; those of b are
/// those of a where it has none of its own.
pub(super) fn uncertain_directions(scene: &Scene, element: &ConnectorElement) -> [f64; 2] {
    let Some(given) = scene.connectors.get(&element.label) else { return [0.0; 2] };
    let Some(section) = scene.section(given) else { return [0.0; 2] };
    let rules = element.connector.connection().orientation;
    let at = |end: usize, name: &Option<pintle_scene::Spanned<String>>, node| {
        let name = name.as_ref().filter(|_| rules[end].orientation != Given::Ignored)?;
        let orientation = scene.orientations.get(name.value.as_str())?;
        let point = scene.position(given, node).unwrap_or_default();
        sides(scene, &name.value, orientation, point, element).map(|(_, turned)| turned)
    };
    let of_a = at(0, &section.orientation_a, pintle_scene::End::A).unwrap_or(0.0);
    [of_a, at(1, &section.orientation_b, pintle_scene::End::B).unwrap_or(of_a)]
}

/// What is found of an orientation at a point, and how bad it is (rad).
fn orientation_at(
    scene: &Scene,
    name: &str,
    orientation: &Orientation,
    point: Vector<f64>,
    element: &ConnectorElement,
) -> Option<(f64, Finding)> {
    let is_rectangular = matches!(orientation.system, System::Rectangular | System::ZRectangular);
    let (angle, worst) = sides(scene, name, orientation, point, element)?;
    let about = |value| About { elements: vec![element.label], value: Some(value), ..About::default() };
    if worst > CERTAIN {
        let message = format!(
            "orientation {name} is uncertain by {worst} rad: its points lie close together, or nearly in a line, for coordinates of this size",
            worst = short(worst, 2)
        );
        let reason = "the rounding of the coordinates, over the distances of the points";
        let remedy = "give points farther apart, near the origin: an orientation knows directions only";
        let finding = Finding::new(
            scene,
            Code::ModelOrientationIllConditioned,
            orientation.span,
            message,
            reason,
            remedy,
        );
        return Some((worst, finding.about(about(worst))));
    }
    let off = (angle - FRAC_PI_2).abs();
    if !is_rectangular || off < ORTHOGONAL {
        return None;
    }
    let is_doubtful = off < NEARLY;
    let message =
        format!("the directions of orientation {name} are {:.6}° apart, not 90°", angle.to_degrees());
    let (kept, turned) = if orientation.system == System::Rectangular { ("e1", "e2") } else { ("e3", "e1") };
    let reason =
        format!("{kept} is taken along a; {turned} is turned by {} within the plane of both", degrees(off));
    let remedy =
        "give b at right angles to a; where only the plane of both is meant, this is as it should be";
    let finding =
        Finding::new(scene, Code::ModelOrientationNotOrthogonal, orientation.span, message, reason, remedy)
            .of_severity(if is_doubtful { Severity::Warning } else { Severity::Note });
    Some((if is_doubtful { off } else { 0.0 }, finding.about(about(off))))
}

/// Directions of an end that components are measured along, and that no orientation gives.
fn missing(scene: &Scene, element: &ConnectorElement, place: Span) -> Option<Finding> {
    let connection = element.connector.connection();
    let section = scene.section(scene.connectors.get(&element.label)?)?;
    let depends = |k: usize| {
        let slot = connection.slots[k];
        let is_directed = slot.position().is_some_and(|m| m.turns_with_a() && !element.is_planar());
        !slot.is_constrained() && is_directed
    };
    if section.orientation_a.is_some() || connection.orientation[0].orientation != Given::Optional {
        return None;
    }
    let components: Vec<String> = (0..6).filter(|k| depends(*k)).map(|k| COMPONENT[k].to_string()).collect();
    if components.is_empty() {
        return None;
    }
    let message = format!(
        "element {}: {} has no orientation, so that {} are along the global directions initially",
        element.label,
        connection.name,
        components.join(", ")
    );
    let reason = format!("by {}", connection.pages());
    let remedy = ["name an *ORIENTATION on the line after the type", "give orientation_a"]
        .map(|name| format!("{name}, or leave it out if the global directions are meant"));
    let finding = Finding::new(scene, Code::ModelOrientationDefault, place, message, reason, remedy);
    Some(finding.about(About { elements: vec![element.label], components, ..About::default() }))
}

/// The initial state of a connector.
pub(super) fn at_start(element: &ConnectorElement) -> State<f64> {
    State { pair: element.initial(), velocity: [0.0; DOFS], acceleration: [0.0; DOFS] }
}

/// CP at the initial state.
pub(super) fn initial_positions(element: &ConnectorElement) -> pintle_kinematics::connector::Components<f64> {
    let connector = &element.connector;
    let request = Request::new(&[Output::CP], [true; 6], 0);
    let (branch, mut tally) = (connector.initial_branch(), Tally::default());
    connector.evaluate(&at_start(element), &Increment::none(), &branch, &request, &mut tally).position
}

/// An angle (rad) in degrees: with six decimals, or, where these would leave little of it, with four digits.
fn degrees(angle: f64) -> String {
    let degrees = angle.to_degrees();
    if degrees != 0.0 && degrees.abs() < 1e-3 {
        format!("{degrees}°", degrees = short(degrees, 4))
    } else {
        format!("{degrees:.6}°")
    }
}

/// Rotations that are held, and are not zero initially.
fn misaligned(scene: &Scene, element: &ConnectorElement, place: Span) -> Option<Finding> {
    let connector = &element.connector;
    let connection = connector.connection();
    let holds = |k: usize| {
        connector.position_measure(k).is_some_and(|m| m.unit() == Unit::Angle && !m.is_one_form())
            && connector.is_constrained(k)
    };
    if !(0..6).any(holds) {
        return None;
    }
    let positions = initial_positions(element);
    let frozen = |k: &usize| {
        let is_frozen = match connection.slots[*k] {
            Slot::Constrained(_, Condition::ZeroOrHeld(_)) => !connector.is_printed_constraint(*k),
            _ => positions[*k].is_some_and(|angle| angle.abs() > ALIGNED),
        };
        holds(*k) && is_frozen
    };
    let components: Vec<usize> = (0..6).filter(frozen).collect();
    let largest = components.iter().filter_map(|k| positions[*k]).fold(0.0_f64, |most, x| most.max(x.abs()));
    if components.is_empty() {
        return None;
    }
    let angles: Vec<String> = components
        .iter()
        .filter_map(|k| Some(format!("{} at {}", COMPONENT[*k], degrees(positions[*k]?))))
        .collect();
    let message = format!(
        "element {}: the directions of a and b of {} are not aligned initially; frozen are {}",
        element.label,
        connection.name,
        angles.join(", ")
    );
    let reason = format!("by {}: what is held is held where it is initially", connection.pages());
    let remedy =
        "give b the orientation of a, or leave that of b out; if the angles are meant, allow this code";
    let about = About {
        elements: vec![element.label],
        components: components.iter().map(|k| COMPONENT[*k].to_string()).collect(),
        value: Some(largest),
        ..About::default()
    };
    Some(Finding::new(scene, Code::ModelMisalignedAxes, place, message, reason, remedy).about(about))
}

/// A connector that leaves one rotation free and holds the line about which it turns.
struct Hinge<'a> {
    element: &'a ConnectorElement,
    point: Vector<f64>,
    axis: Vector<f64>,
}

impl<'a> Hinge<'a> {
    fn of(scene: &Scene, element: &'a ConnectorElement) -> Option<Self> {
        let connector = &element.connector;
        let is_held = |k: usize| connector.is_constrained(k);
        let turns = !is_held(3)
            && [1, 2, 4, 5].into_iter().all(is_held)
            && !element.is_planar()
            && !may_fail(element);
        let point = scene.position(scene.connectors.get(&element.label)?, pintle_scene::End::B)?;
        turns.then(|| Self { element, point, axis: element.triads()[0].map(|row| row[0]) })
    }

    /// The sine of the angle between two axes, and how far the other's point is from this line.
    fn apart(&self, other: &Self) -> [f64; 2] {
        [norm(cross(self.axis, other.axis)), norm(cross(self.axis, sub(other.point, self.point)))]
    }

    /// Whether two axes are nearly parallel and not one line, by more than a deck's digits or the rounding of coordinates explain.
    fn is_off(&self, other: &Self, [sine, distance]: [f64; 2], length: f64) -> bool {
        let points = [self.point, other.point];
        let largest = points.as_flattened().iter().fold(length, |most, x| most.max(x.abs()));
        let explained = (ORTHOGONAL * norm(sub(other.point, self.point))).max(16.0 * U * largest);
        sine <= NEARLY.sin() && (sine > ORTHOGONAL || distance > explained)
    }

    fn name(&self) -> String {
        format!("{} {}", self.element.connector.connection().name, self.element.label)
    }
}

/// Hinges between the same two bodies about nearly parallel axes that are not one line: together they let nothing turn.
pub(super) fn axes_apart(scene: &Scene, model: &Model) -> Result<Vec<Finding>, Diagnostic> {
    let hinges: Vec<Hinge<'_>> =
        model.connectors.iter().filter_map(|element| Hinge::of(scene, element)).collect();
    if hinges.len() < 2 {
        return Ok(Vec::new());
    }
    let bodies = Bodies::of(model, &Still::of(scene, model)?);
    let mut between: BTreeMap<_, Vec<&Hinge<'_>>> = BTreeMap::new();
    for hinge in &hinges {
        let mut ends = hinge.element.nodes.map(|node| bodies.body(node));
        ends.sort_unstable();
        if ends[0] != ends[1] {
            between.entry(ends).or_default().push(hinge);
        }
    }
    Ok(between.values().filter_map(|group| widest_apart((scene, model.length), group)).collect())
}

/// The two hinges of a group that are farthest from one line, and how many others are off it.
fn widest_apart((scene, length): (&Scene, f64), group: &[&Hinge<'_>]) -> Option<Finding> {
    // Each beside each of the first ones: of a strip of very many, pairs would be too many.
    const BESIDE: usize = 20;
    let pairs = group
        .iter()
        .take(BESIDE)
        .enumerate()
        .flat_map(|(n, one)| group.iter().skip(n + 1).map(move |other| (*one, *other, one.apart(other))));
    let off: Vec<(&Hinge<'_>, &Hinge<'_>, [f64; 2])> =
        pairs.filter(|(one, other, apart)| one.is_off(other, *apart, length)).collect();
    let size = |[sine, distance]: [f64; 2]| sine.max(distance);
    let (one, other, [sine, distance]) =
        off.iter().copied().max_by(|x, y| size(x.2).total_cmp(&size(y.2)))?;
    let elements: BTreeSet<Label> =
        off.iter().flat_map(|(one, other, _)| [one.element.label, other.element.label]).collect();
    let more = match elements.len() - 2 {
        0 => String::new(),
        1 => " (so does 1 other connector)".into(),
        more => format!(" (so do {more} other connectors)"),
    };
    let angle =
        if sine > ALIGNED { format!("{} from parallel", degrees(sine.asin())) } else { "parallel".into() };
    let message = format!(
        "{} and {} join the same two bodies about axes that are not one line: {angle}, {} apart{more}: together they let nothing turn",
        one.name(),
        other.name(),
        short(distance, 4)
    );
    let reason = "two bodies that turn against each other about two lines do not turn";
    let remedy = "put the nodes of both on one line along the axis, and give both one orientation; where nothing is to turn, one \
                  WELD or BEAM says so";
    let about = About {
        elements: elements.into_iter().collect(),
        value: Some(distance.max(sine)),
        ..About::default()
    };
    let place = scene.connectors.get(&other.element.label).map_or_else(Span::default, |given| given.span);
    Some(Finding::new(scene, Code::ModelAxesApart, place, message, reason, remedy).about(about))
}

/// Nodes so close together that the direction of their line is lost in the rounding of their coordinates.
fn close(scene: &Scene, element: &ConnectorElement) -> Option<Finding> {
    let given = scene.connectors.get(&element.label)?;
    let needs_direction =
        |k| matches!(element.connector.position_measure(k), Some(Measure::Distance | Measure::Strain));
    let length = norm(element.reference);
    let coordinates = scene.element_nodes(given);
    let largest = coordinates.as_flattened().iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let uncertain = 2.0 * U * 3.0_f64.sqrt() * largest / length;
    if !needs_direction(0) || length == 0.0 || uncertain <= CERTAIN {
        return None;
    }
    let message = format!(
        "element {}: the nodes are {length} apart, for coordinates up to {largest}: the direction is uncertain by {uncertain} rad",
        element.label,
        length = short(length, 4),
        largest = short(largest, 4),
        uncertain = short(uncertain, 2)
    );
    let reason = "the rounding of the coordinates, over the distance of the nodes";
    let remedy = "move the nodes apart, or use JOIN to keep nodes together";
    let finding = Finding::new(scene, Code::ModelNearlyCoincident, given.span, message, reason, remedy);
    let about = About {
        elements: vec![element.label],
        components: vec![COMPONENT[0].to_string()],
        value: Some(uncertain),
        ..About::default()
    };
    Some(finding.about(about))
}
