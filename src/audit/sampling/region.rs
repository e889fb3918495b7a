//! Regions of configuration space, and a case drawn from each.

use crate::case::quantity::Quantity;
use crate::case::{Case, Step};
use crate::oracles::oracle::Narrow;
use crate::sampling::domain::{
    Turning, aligned, angle_at_start, is_in_table, misaligned, needs_length, needs_tilt, spin_axis, turning,
    turns_shafts_over,
};
use pintle_kinematics::catalog::{COMPONENT, ConnectionType};
use pintle_kinematics::connector::{Definition, Output, Request};
use pintle_kinematics::draw::Draw;
use pintle_kinematics::measure::Measure;
use pintle_kinematics::node::{DOFS, Node, Pair, THETA_B};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3::{self, exp};
use pintle_kinematics::vector::{self, Matrix, Vector, add, product, scale, transpose};
use std::f64::consts::PI;

/// How far from every singular set, in radians or lengths of the connector, a regular state is.
const CLEAR: f64 = 0.15;

/// How often a case is drawn anew until it is clear.
const ATTEMPTS: usize = 400;

/// A region of configuration space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Region {
    /// Both nodes turned and moved, the printed constraints met initially.
    Aligned,
    /// As `Aligned`, with axes misaligned initially: the angles are frozen.
    Misaligned,
    /// b turned against a by 1.4 rad.
    Wide,
    /// b turned against a by this little (rad).
    Turned(f64),
    /// The connector is this long.
    Long(f64),
    /// b turned against a to half a turn less this (rad).
    HalfTurn(f64),
    /// b turned against a through this angle (rad) in small steps.
    ManyTurns(f64),
    /// b turned against a through β = 0, so that the Euler angles go on with sin β < 0.
    ThroughLock,
    /// 1e9 lengths from the origin.
    Far,
    /// Nodes in one place.
    Coincident,
    /// Exact right angles: one of the 24 orientations of a cube.
    Cube(usize),
}

impl Region {
    /// In words.
    pub fn name(self) -> String {
        match self {
            Self::Aligned => "random aligned".into(),
            Self::Misaligned => "random misaligned".into(),
            Self::Wide => "random wide".into(),
            Self::Turned(angle) => format!("turned by {angle}"),
            Self::Long(length) if length < 1.0 => "millimetres".into(),
            Self::Long(_) => "kilometres".into(),
            Self::HalfTurn(gap) => format!("half a turn less {gap}"),
            Self::ManyTurns(angle) => format!("through {angle} rad"),
            Self::ThroughLock => "through the lock".into(),
            Self::Far => "1e9 lengths away".into(),
            Self::Coincident => "coincident".into(),
            Self::Cube(i) => format!("cube {i}"),
        }
    }

    /// The regions in which a type has regular states.
    pub fn of(connection: &ConnectionType, extent: Extent) -> Vec<Self> {
        let mut found = vec![Self::Aligned, Self::Misaligned];
        if extent == Extent::Brief {
            return found;
        }
        found.push(Self::Wide);
        found.extend([0.0, 1e-12, 1e-8, 1e-5, 1e-3].map(Self::Turned));
        found.extend([1e-3, 1e3].map(Self::Long));
        if !turns_shafts_over(connection) {
            found.extend([1e-3, 1e-6, -1e-6, -1e-2].map(Self::HalfTurn));
            found.extend([7.0, 20.0].map(Self::ManyTurns));
        }
        found.push(Self::Far);
        if !needs_length(connection) {
            found.push(Self::Coincident);
        }
        if turning(connection) == Turning::Euler {
            found.push(Self::ThroughLock);
        }
        found.extend((0..24).map(Self::Cube));
        found
    }
}

/// How thoroughly a type is tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// Every kind of state.
    Full,
    /// One random state, one aligned: for pairs, which equal their halves.
    Brief,
}

/// Table entries fully, free pairs briefly: a pair equals its halves exactly, which is a law of its own.
pub fn extent(connection: &ConnectionType) -> Extent {
    if is_in_table(connection) { Extent::Full } else { Extent::Brief }
}

/// What a motion is made of: A = exp(common^) A₀, B = exp(common^) exp(spin^) B₀, in equal steps.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// The rotation of both nodes (rad).
    pub common: Vector<f64>,
    /// The rotation of b before it (rad).
    pub spin: Vector<f64>,
    /// U_a and U_b at the end (length).
    pub displacement: [Vector<f64>; 2],
    /// Ψ_a and Ψ_b at the end (length).
    pub flow: [f64; 2],
    /// The number of equal steps.
    pub steps: usize,
}

impl Motion {
    /// Both nodes turned and moved at random, b besides by `spin`.
    pub fn random(draw: &mut Draw, length: f64, spin: Vector<f64>) -> Self {
        Self {
            common: draw.rotation(0.3, 1.2),
            spin,
            displacement: [draw.vector(0.2 * length), draw.vector(0.2 * length)],
            flow: [draw.between(-0.2, 0.2) * length, draw.between(-0.2, 0.2) * length],
            steps: 1,
        }
    }

    /// The pair after the fraction `t` of the motion.
    pub fn at(&self, initial: &Pair<f64>, t: f64) -> Pair<f64> {
        let common = exp(scale(self.common, t));
        let spin = exp(scale(self.spin, t));
        let node = |from: &Node<f64>, end: usize, triad: Matrix<f64>| Node {
            displacement: add(from.displacement, scale(self.displacement[end], t)),
            triad,
            flow: from.flow + self.flow[end] * t,
        };
        Pair {
            reference: initial.reference,
            a: node(&initial.a, 0, product(&common, &initial.a.triad)),
            b: node(&initial.b, 1, product(&product(&common, &spin), &initial.b.triad)),
        }
    }

    /// The states on the way, from the first step to the end.
    pub fn path(&self, initial: &Pair<f64>) -> Vec<Step> {
        let mut before = *initial;
        let mut path = Vec::with_capacity(self.steps);
        for i in 1..=self.steps {
            let after = self.at(initial, i as f64 / self.steps as f64);
            path.push(Step::between(&before, after));
            before = after;
        }
        path
    }
}

/// Two nodes at rest, X_b − X_a = `reference`, triads A₀ and A₀Q₀.
pub fn pair(reference: Vector<f64>, a0: Matrix<f64>, q0: &Matrix<f64>) -> Pair<f64> {
    let node = |triad| Node { displacement: [0.0; 3], triad, flow: 0.0 };
    Pair { reference, a: node(a0), b: node(product(&a0, q0)) }
}

/// A definition with nothing optional in it; β_s = 1.7/length.
pub fn definition(connection: &ConnectionType, initial: Pair<f64>, length: f64) -> Definition {
    Definition { flow_scale: 1.7 / length, ..Definition::new(connection.clone(), initial) }
}

/// The 24 orientations of a cube: entries exactly 0 and ±1.
pub fn cube_orientations() -> Vec<Matrix<f64>> {
    let mut found = Vec::new();
    for (i, j) in [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)] {
        for signs in 0..4 {
            let mut first = [0.0; 3];
            let mut second = [0.0; 3];
            first[i] = if signs & 1 == 0 { 1.0 } else { -1.0 };
            second[j] = if signs & 2 == 0 { 1.0 } else { -1.0 };
            found.push(transpose(&[first, second, vector::cross(first, second)]));
        }
    }
    found
}

impl Case {
    fn new(region: Region, definition: Definition, motion: &Motion, length: f64, draw: &mut Draw) -> Self {
        let mut path = motion.path(&definition.initial);
        if let Some(end) = path.last_mut() {
            end.state.velocity = draw.rates(length);
            end.state.acceleration = draw.rates(2.0 * length);
        }
        let name = format!("{} {}", definition.connection.name, region.name());
        Self { name, definition, start: None, path, length }
    }
}

/// Draws until a case is clear of the singular sets, initially by [`CLEAR`] and at the end by `end`.
fn clear(end: f64, mut make: impl FnMut() -> Case) -> Option<Case> {
    (0..ATTEMPTS).map(|_| make()).find(|case| case.is_clear(CLEAR, end))
}

/// The cases of a type, one from each of its regions, always the same.
pub fn cases(connection: &ConnectionType, extent: Extent) -> Vec<Case> {
    cases_drawn(connection, extent, &mut Draw::new(&connection.name))
}

/// A case from each region of a type.
pub fn cases_drawn(connection: &ConnectionType, extent: Extent, draw: &mut Draw) -> Vec<Case> {
    let regions = Region::of(connection, extent);
    regions.into_iter().filter_map(|region| draw_case(connection, region, draw)).collect()
}

/// The same of all regions, and how many of them come before those of right angles, which are alike.
pub(crate) fn regions_drawn(connection: &ConnectionType, draw: &mut Draw) -> (usize, Vec<Case>) {
    let (mut distinct, mut drawn) = (0, Vec::new());
    for region in Region::of(connection, Extent::Full) {
        let case = draw_case(connection, region, draw);
        distinct += usize::from(case.is_some() && !matches!(region, Region::Cube(_)));
        drawn.extend(case);
    }
    (distinct, drawn)
}

/// A case from a random region.
pub fn random_case(connection: &ConnectionType, draw: &mut Draw) -> Option<Case> {
    let regions = Region::of(connection, Extent::Full);
    (0..ATTEMPTS).find_map(|_| draw_case(connection, regions[draw.below(regions.len())], draw))
}

/// A case from a region; `None` where the type is singular there.
pub fn draw_case(connection: &ConnectionType, region: Region, draw: &mut Draw) -> Option<Case> {
    // Shafts all but parallel, where directions midway must be regular.
    let straight = turning(connection) == Turning::Torsion && !needs_tilt(connection);
    match region {
        Region::Aligned => moderate(connection, region, 1.0, None, 0.8, draw),
        Region::Misaligned => {
            let q0 = misaligned(connection, draw);
            moderate(connection, region, 1.0, Some(q0), 0.6, draw)
        }
        Region::Wide => moderate(connection, region, 1.0, None, 1.4, draw),
        Region::Turned(angle) => {
            moderate(connection, region, 1.0, straight.then(vector::identity), angle, draw)
        }
        Region::Long(length) => moderate(connection, region, length, None, 0.7, draw),
        Region::HalfTurn(gap) => half_turn(connection, region, gap, draw),
        Region::ManyTurns(size) => many_turns(connection, region, size, draw),
        Region::ThroughLock => through_lock(connection, region, draw),
        Region::Far => far(connection, region, draw),
        Region::Coincident => coincident(connection, region, draw),
        Region::Cube(i) => cube(connection, region, i, draw),
    }
}

/// b turned against a by `spin`, from Q₀ or an aligned one.
fn moderate(
    connection: &ConnectionType,
    region: Region,
    length: f64,
    q0: Option<Matrix<f64>>,
    spin: f64,
    draw: &mut Draw,
) -> Option<Case> {
    clear(CLEAR, || {
        let q0 = q0.unwrap_or_else(|| aligned(connection, draw));
        let reference = scale(draw.direction(), length * draw.between(0.7, 1.4));
        let definition = definition(connection, pair(reference, draw.triad(), &q0), length);
        let spin = scale(draw.direction(), spin);
        let motion = Motion::random(draw, length, spin);
        Case::new(region, definition, &motion, length, draw)
    })
}

/// Q₀ from which turns about [`spin_axis`] are counted.
fn start_of_turns(connection: &ConnectionType, draw: &mut Draw) -> Matrix<f64> {
    match turning(connection) {
        Turning::RotationVector => vector::identity(),
        _ => aligned(connection, draw),
    }
}

fn half_turn(connection: &ConnectionType, region: Region, gap: f64, draw: &mut Draw) -> Option<Case> {
    // The misalignment is a principal log: past half a turn it is another branch.
    let holds = turning(connection) == Turning::Align;
    let gap = if holds { gap.abs() } else { gap };
    clear(if holds { 0.0 } else { CLEAR }, || {
        let q0 = start_of_turns(connection, draw);
        let a0 = draw.triad();
        let axis = spin_axis(connection, &a0, draw);
        let reference = draw.direction();
        let definition = definition(connection, pair(reference, a0, &q0), 1.0);
        let spin = scale(axis, PI - gap - angle_at_start(connection, &q0));
        let motion = Motion { steps: 8, ..Motion::random(draw, 1.0, spin) };
        Case::new(region, definition, &motion, 1.0, draw)
    })
}

/// In steps below 0.7 rad; a type that holds all rotations turns as a whole.
fn many_turns(connection: &ConnectionType, region: Region, size: f64, draw: &mut Draw) -> Option<Case> {
    let whole = turning(connection) == Turning::Align;
    clear(CLEAR, || {
        let q0 = start_of_turns(connection, draw);
        let a0 = draw.triad();
        let axis = spin_axis(connection, &a0, draw);
        let definition = definition(connection, pair(draw.direction(), a0, &q0), 1.0);
        let steps = (size / 0.35) as usize;
        let turned = scale(axis, size);
        let motion = if whole {
            let little = [0.3 * axis[1], -0.2 * axis[2], 0.25 * axis[0]];
            Motion { common: turned, steps, ..Motion::random(draw, 1.0, little) }
        } else {
            Motion { steps, ..Motion::random(draw, 1.0, turned) }
        };
        Case::new(region, definition, &motion, 1.0, draw)
    })
}

/// b turned about the line of nodes until β = −0.6, which leaves α and γ as they are.
fn through_lock(connection: &ConnectionType, region: Region, draw: &mut Draw) -> Option<Case> {
    clear(CLEAR, || {
        let q0 = aligned(connection, draw);
        let a0 = draw.triad();
        let [alpha, beta] = [1, 2].map(|i| so3::euler_angle(&q0, 1.0, i));
        let nodes = vector::apply(&a0, [alpha.cos(), alpha.sin(), 0.0]);
        let definition = definition(connection, pair(draw.direction(), a0, &q0), 1.0);
        let spin = scale(nodes, -beta - 0.6);
        let motion = Motion { steps: 8, ..Motion::random(draw, 1.0, spin) };
        Case::new(region, definition, &motion, 1.0, draw)
    })
}

/// Displacements of 2³⁰ (about 1e9) lengths, on a grid so coarse that their difference is exact.
fn far(connection: &ConnectionType, region: Region, draw: &mut Draw) -> Option<Case> {
    clear(CLEAR, || {
        let q0 = aligned(connection, draw);
        let grid = |v: Vector<f64>| v.map(|x| (x * 1024.0).round() / 1024.0);
        let definition = definition(connection, pair(grid(draw.direction()), draw.triad(), &q0), 1.0);
        let spin = draw.rotation(0.3, 0.7);
        let mut motion = Motion::random(draw, 1.0, spin);
        let away = [1_073_741_824.0, -536_870_912.0, 1_073_741_824.5];
        motion.displacement = motion.displacement.map(|u| add(away, grid(u)));
        Case::new(region, definition, &motion, 1.0, draw)
    })
}

/// Nodes in one place, initially and now.
fn coincident(connection: &ConnectionType, region: Region, draw: &mut Draw) -> Option<Case> {
    clear(CLEAR, || {
        let q0 = aligned(connection, draw);
        let definition = definition(connection, pair([0.0; 3], draw.triad(), &q0), 1.0);
        let spin = draw.rotation(0.3, 0.7);
        let mut motion = Motion::random(draw, 1.0, spin);
        motion.displacement[1] = motion.displacement[0];
        Case::new(region, definition, &motion, 1.0, draw)
    })
}

/// a in one of the 24 orientations of a cube, b in each of them, as far as the type is regular there; the initial orientations
/// as well.
fn cube(connection: &ConnectionType, region: Region, i: usize, draw: &mut Draw) -> Option<Case> {
    let all = cube_orientations();
    let q = all.get(i)?;
    let a0 = all[(7 * i + 3) % 24];
    // The initial orientation itself is a right angle in every second case; always where a half turn in one increment would
    // leave two sheets equally near.
    let still = i % 2 == 1 || matches!(turning(connection), Turning::Euler | Turning::Torsion);
    let q0 = if still { *q } else { vector::identity() };
    let definition = definition(connection, pair([2.0, -1.0, 0.5], a0, &q0), 2.0);
    let mut after = pair([2.0, -1.0, 0.5], a0, q);
    after.a.displacement = [0.25, 0.0, -0.5];
    after.b.displacement = [0.0, 0.75, 0.5];
    after.a.triad = all[(5 * i + 1) % 24];
    after.b.triad = product(&after.a.triad, q);
    let mut end = Step::between(&definition.initial, after);
    end.state.velocity = draw.rates(2.0);
    end.state.acceleration = draw.rates(4.0);
    let name = format!("{} {}", connection.name, region.name());
    Some(Case { name, definition, start: None, path: vec![end], length: 2.0 })
        .filter(|case| case.is_clear(CLEAR, CLEAR))
}

/// State `i` about the initial one of a connector: that itself, then random motions of the nodes that can move, clear of singular
/// sets. Node b turns against a by up to 1.2 rad, every fourth time up to 3 rad; a two-dimensional connector stays in the plane.
/// `None` where no clear state was found.
pub fn about_initial(
    definition: &Definition,
    i: usize,
    length: f64,
    name: String,
    draw: &mut Draw,
) -> Option<Case> {
    about_initial_by(definition, i, (length, 1.0), name, draw)
}

/// The same with motions so many times as large: displacements, flows and rates, and rotations where they are smaller.
pub(crate) fn about_initial_by(
    definition: &Definition,
    i: usize,
    (length, times): (f64, f64),
    name: String,
    draw: &mut Draw,
) -> Option<Case> {
    const CLEAR: f64 = 0.01;
    let reach = times * length;
    let turning = |draw: &mut Draw, most: f64| {
        let size = draw.between(0.0, most * times.min(1.0));
        let turn = scale(draw.direction(), size);
        if definition.planar { [0.0, 0.0, turn[2]] } else { turn }
    };
    for _ in 0..ATTEMPTS {
        let still = [0.0; 3];
        // Beyond a right angle the arctangent of a quotient and the arcsine are other functions than the angle.
        let most = if i % 4 == 3 { 3.0 } else { 1.2 };
        let [mut common, spin] = if i == 0 { [still; 2] } else { [turning(draw, 3.0), turning(draw, most)] };
        let mut motion = Motion::random(draw, reach, spin);
        if i == 0 {
            (motion.displacement, motion.flow) = ([still; 2], [0.0; 2]);
        }
        for (end, moves) in definition.moves.into_iter().enumerate() {
            if definition.planar {
                motion.displacement[end][2] = 0.0;
            }
            if !moves {
                (motion.displacement[end], motion.flow[end]) = (still, 0.0);
            }
        }
        // Neither the ground turns, nor an end without rotations: a is turned by one of them, b by both.
        let turns = [0, 1].map(|end| definition.moves[end] && definition.rotates[end]);
        if !turns[0] {
            common = still;
        }
        if !turns[1] {
            if turns[0] {
                common = scale(spin, -1.0);
            } else {
                motion.spin = still;
            }
        }
        let mut path = Motion { common, ..motion }.path(&definition.initial);
        if let Some(end) = path.last_mut() {
            end.state.velocity = rates(definition, reach, draw);
            end.state.acceleration = rates(definition, reach, draw);
        }
        let case = Case { name: name.clone(), definition: definition.clone(), start: None, path, length };
        if i == 0 || case.is_clear(0.0, CLEAR) {
            return Some(case);
        }
    }
    None
}

/// How many states of [`special_initial`] there are.
pub const SPECIAL: usize = 4 + BESIDE.len() + 24;

/// How far some of them are from right angles (rad).
const BESIDE: [f64; 8] = [1e-5, 1e-4, 1e-6, 1e-3, 1e-7, 1e-2, 1e-8, 1e-9];

/// A state of special values, clear of the singular sets; `None` where the nodes cannot be brought there.
///
/// | n | state |
/// |---|---|
/// | 0 | both nodes turned alike |
/// | 1 | b moved alone |
/// | 2, 3 | b turned to the axes of a; both along global axes |
/// | 4, 6 … 18 | 1e-2 to 1e-9 from such axes, where arccosines and arcsines lose digits: parallel, or half a turn about e1a, if the type allows |
/// | 5, 7 … 19, from 20 on | the axes of b at right angles to those of a |
pub fn special_initial(
    definition: &Definition,
    n: usize,
    length: f64,
    name: &str,
    draw: &mut Draw,
) -> Option<Case> {
    /// How often axes are drawn beside which a state is to be.
    const OFTEN: usize = 12;
    let attempts = if angle_beside(n).is_some() { OFTEN } else { 1 };
    (0..attempts).find_map(|attempt| {
        // No turn, and half of one about the first axis.
        let cube = (attempt == 0).then_some(if n.is_multiple_of(4) { 0 } else { 2 });
        special(definition, (n, cube), length, name, draw)
    })
}

/// How far state n is from right angles (rad), if it is beside them.
fn angle_beside(n: usize) -> Option<f64> {
    let n = n.checked_sub(4).filter(|n| n.is_multiple_of(2))?;
    BESIDE.get(n / 2).copied()
}

/// The same, once; what is next to right angles is next to those of that cube, or of any.
fn special(
    definition: &Definition,
    (n, cube): (usize, Option<usize>),
    length: f64,
    name: &str,
    draw: &mut Draw,
) -> Option<Case> {
    const CLEAR: f64 = 0.01;
    let initial = &definition.initial;
    let turns = [0, 1].map(|end| definition.moves[end] && definition.rotates[end]);
    let mut after = *initial;
    let spin = if definition.planar { [0.0, 0.0, 0.7] } else { draw.rotation(0.3, 1.2) };
    let cubes = cube_orientations();
    let axis = if definition.planar { [0.0, 0.0, 1.0] } else { scale(spin, 1.0 / norm(spin)) };
    let relative = match n {
        0 => {
            let common = exp(spin);
            after.a.triad = product(&common, &initial.a.triad);
            after.b.triad = product(&common, &initial.b.triad);
            None
        }
        1 => {
            let by = scale(draw.direction(), 0.3 * length);
            after.b.displacement = if definition.planar { [by[0], by[1], 0.0] } else { by };
            None
        }
        2 => Some(vector::identity()),
        3 => {
            after.a.triad = vector::identity();
            Some(vector::identity())
        }
        _ => Some(match angle_beside(n) {
            Some(angle) => {
                let cube = cube.unwrap_or_else(|| draw.below(cubes.len()));
                product(cubes.get(cube)?, &exp(scale(axis, angle)))
            }
            // Those that are beside right angles come in between.
            None => *cubes.get(n - 4 - (n - 4).div_ceil(2).min(BESIDE.len()))?,
        }),
    };
    if let Some(relative) = relative {
        after.b.triad = product(&after.a.triad, &relative);
    }
    let can =
        |end: usize| [&initial.a, &initial.b][end].triad == [&after.a, &after.b][end].triad || turns[end];
    let in_plane = |end: usize| {
        let [now, first] = [[&after.a, &after.b][end], [&initial.a, &initial.b][end]];
        !definition.planar || (0..3).all(|i| now.triad[i][2] == first.triad[i][2])
    };
    let moves = after.b.displacement == initial.b.displacement || definition.moves[1];
    if !(can(0) && can(1) && in_plane(0) && in_plane(1) && moves) {
        return None;
    }
    let mut step = Step::between(initial, after);
    step.state.velocity = rates(definition, length, draw);
    step.state.acceleration = rates(definition, length, draw);
    let name = format!("{name}, special {n}");
    let case = Case { name, definition: definition.clone(), start: None, path: vec![step], length };
    // Next to half a turn an angle may go on one way or the other.
    let (found, _) = case.evaluation(&Request::new(&[Output::CP, Output::CU, Output::RES], [true; 6], 0))?;
    let is_principal = [found.position, found.displacement, found.residual]
        .iter()
        .all(|of| norm([of[3], of[4], of[5]].map(Option::unwrap_or_default)) < 3.0);
    (is_principal && case.is_clear(CLEAR, CLEAR)).then_some(case)
}

/// The end of a history of a connector, in increments of at most 0.6 rad.
///
/// b turns against a by 3.3 to 20 rad, or by 0.35 rad for each of so many states, about an axis about which it may turn without end.
/// Both turn about other axes and move besides. A type that holds all rotations turns as a whole. `None` where an end does not turn, or where a
/// singular set is in the way.
pub fn along_initial(
    definition: &Definition,
    length: f64,
    name: &str,
    states: Option<usize>,
    draw: &mut Draw,
) -> Option<Case> {
    const CLEAR: f64 = 0.01;
    let turns = [0, 1].map(|end| definition.moves[end] && definition.rotates[end]);
    let connection = &definition.connection;
    if turns != [true, true] || turns_shafts_over(connection) {
        return None;
    }
    let whole = turning(connection) == Turning::Align;
    (0..ATTEMPTS).find_map(|_| {
        let axis = spin_axis(connection, &definition.initial.a.triad, draw);
        let axis = if definition.planar { [0.0, 0.0, 1.0] } else { axis };
        let size = states.map_or_else(|| draw.between(3.3, 20.0), |states| 0.35 * states as f64);
        let turned = scale(axis, if draw.unit() < 0.5 { -size } else { size });
        let mut motion = Motion::random(draw, length, turned);
        motion.common = scale(motion.common, 0.5);
        if whole {
            (motion.common, motion.spin) = (turned, scale(draw.direction(), draw.between(0.0, 0.3)));
        }
        if definition.planar {
            for end in &mut motion.displacement {
                end[2] = 0.0;
            }
            (motion.common, motion.spin) = ([0.0, 0.0, motion.common[2]], [0.0, 0.0, motion.spin[2]]);
        }
        motion.steps = states.unwrap_or((size / 0.35).ceil() as usize);
        // Both nodes turn about a second axis meanwhile: increments of rotations about changing axes do not add up.
        let second = if definition.planar { [0.0; 3] } else { draw.rotation(0.3, 1.2) };
        let mut before = definition.initial;
        let on_the_way = |i: usize| {
            let t = i as f64 / motion.steps as f64;
            let mut after = motion.at(&definition.initial, t);
            let by = exp(scale(second, t));
            for node in [&mut after.a, &mut after.b] {
                node.triad = product(&by, &node.triad);
            }
            let step = Step::between(&before, after);
            before = after;
            step
        };
        let mut path: Vec<Step> = (1..=motion.steps).map(on_the_way).collect();
        let end = path.last_mut()?;
        end.state.velocity = rates(definition, length, draw);
        end.state.acceleration = rates(definition, length, draw);
        let name = format!("{name}, through {size:.1} rad");
        let case = Case { name, definition: definition.clone(), start: None, path, length };
        case.is_clear(0.0, CLEAR).then_some(case)
    })
}

/// The same history, b turned on until an angle is so far from an odd number of half turns (rad, below or beyond): where principal angles
/// change their sign. The angles take turns by `place`. `None` where no angle can be brought there.
pub fn beside_half_turn(case: &Case, place: usize, distance: f64) -> Option<Case> {
    /// How far b turns in an increment.
    const INCREMENT: f64 = 0.5;
    let definition = &case.definition;
    if definition.planar || !(definition.moves[1] && definition.rotates[1]) {
        return None;
    }
    let connector = case.connector();
    let measure_of = |k: usize| connector.position_measure(k).filter(|_| !connector.is_constrained(k));
    // A flexion of half a turn is a singular set.
    let has_half_turn = |of: &Measure| of.winds() || matches!(of, Measure::RotationVector(_));
    let angles: Vec<(usize, Measure)> =
        [3, 4, 5].into_iter().filter_map(|k| Some((k, measure_of(k).filter(has_half_turn)?))).collect();
    let (k, measure) = *angles.get(place.checked_rem(angles.len())?)?;
    let is_vector = matches!(measure, Measure::RotationVector(_));
    let mut landed = case.clone();
    // Newton's method: the angle is a function of how far b turns along its gradient.
    for _ in 0..8 {
        let position = landed.positions();
        let step = *landed.last()?;
        let (x, gradient) = if is_vector {
            let [Some(x), Some(y), Some(z)] = [3, 4, 5].map(|k| position[k]) else { return None };
            let length = norm([x, y, z]);
            (length, vector::apply(&step.state.pair.a.triad, scale([x, y, z], 1.0 / length)))
        } else {
            let row = Narrow::of(&landed)?.nested_dual();
            let row = row.entries(Quantity::FirstDerivatives).0[k].clone()?;
            (position[k]?, [row[THETA_B], row[THETA_B + 1], row[THETA_B + 2]])
        };
        let goal = PI * (2.0 * ((x / PI - 1.0) / 2.0).round() + 1.0) + distance;
        let square: f64 = gradient.iter().map(|g| g * g).sum();
        let by = scale(gradient, (goal - x) / square);
        let size = norm(by);
        if !size.is_finite() || size > 2.0 * PI {
            return None;
        }
        if (goal - x).abs() < 1e-3 * distance.abs() {
            landed.name = format!("{}, {distance:e} rad from half a turn of {}", case.name, COMPONENT[k]);
            return landed.is_clear(0.0, distance.abs() / 2.0).then_some(landed);
        }
        let parts = (size / INCREMENT).ceil().max(1.0);
        let mut before = step.state.pair;
        for part in 1..=parts as usize {
            let mut after = step.state.pair;
            after.b.triad = product(&exp(scale(by, part as f64 / parts)), &after.b.triad);
            let mut made = Step::between(&before, after);
            (made.state.velocity, made.state.acceleration) = (step.state.velocity, step.state.acceleration);
            landed.path.push(made);
            before = after;
        }
    }
    None
}

/// Random rates of the degrees of freedom that there are.
pub(crate) fn rates(definition: &Definition, length: f64, draw: &mut Draw) -> [f64; DOFS] {
    let mut rates = draw.rates(length);
    for (j, rate) in rates.iter_mut().enumerate() {
        let in_plane = matches!(j % 7, 0 | 1 | 5 | 6);
        let is_held = matches!(j % 7, 3..=5) && !definition.rotates[j / 7];
        if !definition.moves[j / 7] || is_held || definition.planar && !in_plane {
            *rate = 0.0;
        }
    }
    rates
}
