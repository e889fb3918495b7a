//! Where laws are tried: connectors of every type at seeded states, each with the path that leads there.
//!
//! A type brings its own domain: initial orientations that satisfy its printed constraints or do not, the axis about which it
//! may turn without end, and states clear of its singular sets. The paths are made from so few ingredients (the initial
//! relative orientation, a rotation common to both nodes, a rotation of b against a) that what an angle must be is known.

use pintle::catalog::{Class, Condition, ConnectionType, Slot, TABLE};
use pintle::connector::{Branch, Connector, Definition, Evaluation, Increment, Request, State, Tally};
use pintle::measure::{Measure, Unit};
use pintle::node::{DOFS, Node, Pair};
use pintle::scalar::{Differentiable, Real};
use pintle::so3;
use pintle::vector::{self, Matrix, Vector, add, apply, column, product, scale, sub, transpose};
use std::f64::consts::PI;

/// A reproducible stream of numbers (splitmix64), seeded by a name.
pub(crate) struct Draw(u64);

impl Draw {
    pub(crate) fn new(seed: &str) -> Self {
        Self(
            seed.bytes()
                .fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3)),
        )
    }

    /// Uniform in [0, 1).
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Each component uniform in ±size.
    pub(crate) fn vector(&mut self, size: f64) -> Vector<f64> {
        [0; 3].map(|_| self.between(-size, size))
    }

    /// A unit vector, uniform on the sphere.
    pub(crate) fn direction(&mut self) -> Vector<f64> {
        loop {
            let v = self.vector(1.0);
            let (u, n) = f64::direction_and_norm(v);
            if (0.1..=1.0).contains(&n) {
                return u;
            }
        }
    }

    /// A rotation vector whose length is in [low, high].
    pub(crate) fn rotation(&mut self, low: f64, high: f64) -> Vector<f64> {
        let size = self.between(low, high);
        scale(self.direction(), size)
    }

    /// A triad in any orientation.
    pub(crate) fn triad(&mut self) -> Matrix<f64> {
        turn(self.rotation(0.0, PI))
    }

    /// Nodal rates: translations and flows of size `length`, rotations of size 1.
    pub(crate) fn rates(&mut self, length: f64) -> [f64; DOFS] {
        let mut rates = [0.0; DOFS];
        for (j, rate) in rates.iter_mut().enumerate() {
            *rate = self.between(-1.0, 1.0) * dof_size(j, length);
        }
        rates
    }
}

/// The size of a nodal degree of freedom: 1 rad, or the connector's length.
pub(crate) fn dof_size(j: usize, length: f64) -> f64 {
    if matches!(j % 7, 3..=5) { 1.0 } else { length }
}

/// The rotation matrix of a rotation vector.
pub(crate) fn turn<R: Real>(rotation: Vector<R>) -> Matrix<R> {
    so3::matrix(so3::exp(rotation))
}

/// The 24 orientations of a cube: entries exactly 0 and ±1.
pub(crate) fn cube_orientations() -> Vec<Matrix<f64>> {
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

/// Every entry of the table and every free pair of a translational and a rotational type.
pub(crate) fn types() -> Vec<ConnectionType> {
    let mut found = TABLE.to_vec();
    let of = |wanted: fn(Class) -> bool| TABLE.iter().filter(move |entry| wanted(entry.class));
    for t in of(|class| class == Class::BasicTranslational) {
        for r in of(|class| matches!(class, Class::BasicRotational | Class::SpecialisedRotational)) {
            let pair = ConnectionType::named(&t.name, Some(&r.name)).expect("basic halves pair");
            if !TABLE.iter().any(|entry| entry.name == pair.name) {
                found.push(pair);
            }
        }
    }
    found
}

/// The rotational measure of a type, which decides its domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Turning {
    /// Angles of Rx Ry Rz, none held.
    Cardan,
    /// As `Cardan`, with e1a·e3b = 0.
    Universal,
    /// As `Cardan`, with e1a = e1b.
    Revolute,
    /// No rotation at all.
    Align,
    Euler,
    RotationVector,
    /// Angles of Rz Ry Rz: flexion, torsion and sweep, or the directions midway between a and b.
    Torsion,
    Flow,
    None,
}

pub(crate) fn turning(connection: &ConnectionType) -> Turning {
    let printed = |wanted: Measure| {
        connection.slots.iter().any(|slot| match slot {
            Slot::Constrained(_, Condition::Zero(m) | Condition::ZeroOrHeld(m)) => *m == wanted,
            _ => false,
        })
    };
    let position =
        |wanted: fn(Measure) -> bool| connection.slots.iter().any(|slot| slot.position().is_some_and(wanted));
    if printed(Measure::Misalignment(1)) {
        Turning::Align
    } else if printed(Measure::Cosine(1, 2)) {
        Turning::Revolute
    } else if printed(Measure::Cosine(1, 3)) {
        Turning::Universal
    } else if position(|m| matches!(m, Measure::Cardan(_))) {
        Turning::Cardan
    } else if position(|m| matches!(m, Measure::Euler(_))) {
        Turning::Euler
    } else if position(|m| matches!(m, Measure::RotationVector(_) | Measure::RotationVectorAtB(_))) {
        Turning::RotationVector
    } else if position(|m| m == Measure::Torsion || m.counts_torsion()) {
        Turning::Torsion
    } else if position(Measure::is_one_form) {
        Turning::Flow
    } else {
        Turning::None
    }
}

/// Whether the type measures a length that has no derivative where the nodes coincide, and so needs nodes apart.
pub(crate) fn needs_length(connection: &ConnectionType) -> bool {
    let mut positions = connection.slots.iter().filter_map(|slot| slot.position());
    positions.any(|m| m.singular_set().is_some_and(|set| set.unit == Unit::Length))
}

/// Whether turning b far against a, in the way that the type's rotations ask for, leads through e3b = −e3a, where its directions
/// midway between a and b do not exist: PROJECTION CARTESIAN beside a joint that does not turn about e3.
fn turns_shafts_over(connection: &ConnectionType) -> bool {
    let mut positions = connection.slots.iter().filter_map(|slot| slot.position());
    positions.any(Measure::counts_torsion)
        && !matches!(turning(connection), Turning::Torsion | Turning::Euler | Turning::Flow)
}

/// Whether the type measures an angle that does not exist, or has no derivative, where e3a and e3b are parallel.
fn needs_tilt(connection: &ConnectionType) -> bool {
    let mut positions = connection.slots.iter().filter_map(|slot| slot.position());
    positions.any(|m| matches!(m, Measure::Euler(_) | Measure::Flexion | Measure::Sweep))
}

pub(crate) fn about_1(angle: f64) -> Matrix<f64> {
    turn([angle, 0.0, 0.0])
}

pub(crate) fn about_3(angle: f64) -> Matrix<f64> {
    turn([0.0, 0.0, angle])
}

/// An initial Q₀ at which the printed constraints of the type hold.
fn aligned(connection: &ConnectionType, draw: &mut Draw) -> Matrix<f64> {
    let (x, y) = (draw.between(-0.7, 0.7), draw.between(-0.7, 0.7));
    match turning(connection) {
        Turning::Align => vector::identity(),
        Turning::Revolute => about_1(x),
        Turning::Universal => product(&about_1(x), &about_3(y)),
        Turning::Euler | Turning::Torsion if needs_tilt(connection) => {
            let tilt = about_1(draw.between(0.7, 1.4));
            product(&product(&about_3(x), &tilt), &about_3(y))
        }
        _ => turn(draw.rotation(0.1, 0.6)),
    }
}

/// The axis, in the initial global frame, about which b can turn against a without meeting a singular set on the way.
pub(crate) fn spin_axis(connection: &ConnectionType, a0: &Matrix<f64>, draw: &mut Draw) -> Vector<f64> {
    match turning(connection) {
        Turning::Cardan | Turning::Universal | Turning::Revolute => column(a0, 0),
        Turning::Euler | Turning::Torsion | Turning::Flow => column(a0, 2),
        Turning::Align | Turning::RotationVector | Turning::None => draw.direction(),
    }
}

/// One state of a path, and the increment that leads to it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    pub(crate) state: State<f64>,
    pub(crate) increment: Increment<f64>,
}

impl Step {
    /// From one pair to the next, by less than half a turn of each node.
    pub(crate) fn between(before: &Pair<f64>, after: Pair<f64>) -> Self {
        let turned =
            |old: &Node<f64>, new: &Node<f64>| so3::log(&product(&new.triad, &transpose(&old.triad)));
        let increment = Increment {
            rotation: [turned(&before.a, &after.a), turned(&before.b, &after.b)],
            whole_turns: [[0.0; 3]; 2],
            flow: [after.a.flow - before.a.flow, after.b.flow - before.b.flow],
        };
        Self { state: State { pair: after, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] }, increment }
    }
}

/// A connector and a path of it; derivatives are judged at the end.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) definition: Definition,
    pub(crate) path: Vec<Step>,
    /// The connector's own length.
    pub(crate) length: f64,
}

/// What a motion is made of: A = exp(common^) A₀, B = exp(common^) exp(spin^) B₀, in equal steps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion {
    pub(crate) common: Vector<f64>,
    pub(crate) spin: Vector<f64>,
    pub(crate) displacement: [Vector<f64>; 2],
    pub(crate) flow: [f64; 2],
    pub(crate) steps: usize,
}

impl Motion {
    pub(crate) fn random(draw: &mut Draw, length: f64, spin: Vector<f64>) -> Self {
        Self {
            common: draw.rotation(0.3, 1.2),
            spin,
            displacement: [draw.vector(0.2 * length), draw.vector(0.2 * length)],
            flow: [draw.between(-0.2, 0.2) * length, draw.between(-0.2, 0.2) * length],
            steps: 1,
        }
    }

    /// The pair after the fraction `t` of the motion.
    pub(crate) fn at(&self, initial: &Pair<f64>, t: f64) -> Pair<f64> {
        let common = turn(scale(self.common, t));
        let spin = turn(scale(self.spin, t));
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

    pub(crate) fn path(&self, initial: &Pair<f64>) -> Vec<Step> {
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
pub(crate) fn pair(reference: Vector<f64>, a0: Matrix<f64>, q0: &Matrix<f64>) -> Pair<f64> {
    let node = |triad| Node { displacement: [0.0; 3], triad, flow: 0.0 };
    Pair { reference, a: node(a0), b: node(product(&a0, q0)) }
}

/// A definition with nothing optional in it.
pub(crate) fn definition(connection: &ConnectionType, initial: Pair<f64>, length: f64) -> Definition {
    Definition { flow_scale: 1.7 / length, ..Definition::new(connection.clone(), initial) }
}

impl Case {
    fn new(name: &str, definition: Definition, motion: &Motion, length: f64, draw: &mut Draw) -> Self {
        let mut path = motion.path(&definition.initial);
        let end = &mut path.last_mut().expect("a path has an end").state;
        end.velocity = draw.rates(length);
        end.acceleration = draw.rates(2.0 * length);
        Self { name: format!("{} {name}", definition.connection.name), definition, path, length }
    }

    pub(crate) fn connector(&self) -> Connector<f64> {
        Connector::new(&self.definition)
    }

    /// The state judged, and the increment that leads to it.
    pub(crate) fn end(&self) -> &Step {
        self.path.last().expect("a path has an end")
    }

    /// The branch that the states before the end leave.
    pub(crate) fn branch_before(&self, connector: &Connector<f64>) -> Branch<f64> {
        let mut branch = connector.initial_branch();
        for step in &self.path[..self.path.len() - 1] {
            branch = connector.advance(&step.state, &step.increment, &branch);
        }
        branch
    }

    /// The evaluation at the end.
    pub(crate) fn evaluate(&self, request: &Request) -> (Evaluation<f64>, Tally) {
        let connector = self.connector();
        let branch = self.branch_before(&connector);
        let mut tally = Tally::default();
        let step = self.end();
        (connector.evaluate(&step.state, &step.increment, &branch, request, &mut tally), tally)
    }

    /// Whether every state of the path is clear of the singular sets by 0.15 rad or 0.15 lengths, or at the end by `end`.
    fn is_regular(&self, end: f64) -> bool {
        let connector = self.connector();
        let mut branch = connector.initial_branch();
        let initial =
            State { pair: self.definition.initial, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
        let clear = |state: &State<f64>, branch: &Branch<f64>, least: f64| {
            connector.margins(state, branch, [true; 6]).iter().flatten().all(|margin| {
                let unit = if margin.set.unit == Unit::Length { self.length } else { 1.0 };
                margin.distance >= least * unit
            })
        };
        if !clear(&initial, &branch, 0.15) {
            return false;
        }
        let last = self.path.len() - 1;
        self.path.iter().enumerate().all(|(i, step)| {
            branch = connector.advance(&step.state, &step.increment, &branch);
            clear(&step.state, &branch, if i == last { end } else { 0.0 })
        })
    }
}

/// Draws until a case is regular.
fn regular(end: f64, mut make: impl FnMut() -> Case) -> Case {
    for _ in 0..400 {
        let case = make();
        if case.is_regular(end) {
            return case;
        }
    }
    panic!("no regular state found: {}", make().name);
}

/// The angle that winds, or is principal, at Q₀ about [`spin_axis`].
fn angle_at_start(connection: &ConnectionType, q0: &Matrix<f64>) -> f64 {
    match turning(connection) {
        Turning::Cardan | Turning::Universal | Turning::Revolute => so3::cardan_first(q0),
        Turning::Euler => so3::euler_angle(q0, 1.0, 1),
        Turning::Torsion => so3::torsion(q0),
        _ => 0.0,
    }
}

/// How thoroughly a type is tried.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Extent {
    /// Every kind of state.
    Full,
    /// One random state, one aligned: for pairs, which equal their halves.
    Brief,
}

/// Table entries fully, free pairs briefly: a pair equals its halves exactly, which is a law of its own.
pub(crate) fn extent(connection: &ConnectionType) -> Extent {
    if TABLE.iter().any(|entry| entry.name == connection.name) { Extent::Full } else { Extent::Brief }
}

/// The cases of a type.
pub(crate) fn cases(connection: &ConnectionType, extent: Extent) -> Vec<Case> {
    let draw = &mut Draw::new(&connection.name);
    let mut found = Vec::new();
    let sample = |name: &str, length: f64, q0: Option<Matrix<f64>>, spin: f64, draw: &mut Draw| {
        regular(0.15, || {
            let q0 = q0.unwrap_or_else(|| aligned(connection, draw));
            let reference = scale(draw.direction(), length * draw.between(0.7, 1.4));
            let definition = definition(connection, pair(reference, draw.triad(), &q0), length);
            let spin = scale(draw.direction(), spin);
            let motion = Motion::random(draw, length, spin);
            Case::new(name, definition, &motion, length, draw)
        })
    };
    found.push(sample("random aligned", 1.0, None, 0.8, draw));
    let misaligned = misaligned(connection, draw);
    found.push(sample("random misaligned", 1.0, Some(misaligned), 0.6, draw));
    if extent == Extent::Brief {
        return found;
    }
    found.push(sample("random wide", 1.0, None, 1.4, draw));
    for tiny in [0.0, 1e-12, 1e-8, 1e-5, 1e-3] {
        // Shafts all but parallel, where directions midway must be regular.
        let straight = turning(connection) == Turning::Torsion && !needs_tilt(connection);
        let q0 = straight.then(vector::identity);
        found.push(sample(&format!("turned by {tiny}"), 1.0, q0, tiny, draw));
    }
    found.push(sample("millimetres", 1e-3, None, 0.7, draw));
    found.push(sample("kilometres", 1e3, None, 0.7, draw));
    if !turns_shafts_over(connection) {
        for gap in [1e-3, 1e-6, -1e-6, -1e-2] {
            found.push(half_turn(connection, gap, draw));
        }
        for size in [7.0, 20.0] {
            found.push(many_turns(connection, size, draw));
        }
    }
    found.push(far(connection, draw));
    if !needs_length(connection) {
        found.push(coincident(connection, draw));
    }
    found.extend(cubes(connection, draw));
    found
}

/// An initial Q₀ at which the printed constraints do not hold.
fn misaligned(connection: &ConnectionType, draw: &mut Draw) -> Matrix<f64> {
    let start = aligned(connection, draw);
    product(&turn(draw.rotation(0.2, 0.4)), &start)
}

/// b turned against a to half a turn less `gap`.
fn half_turn(connection: &ConnectionType, gap: f64, draw: &mut Draw) -> Case {
    // The misalignment is a principal log: past half a turn it is another branch.
    let gap = if turning(connection) == Turning::Align { gap.abs() } else { gap };
    let least = if turning(connection) == Turning::Align { 0.0 } else { 0.15 };
    regular(least, || {
        let q0 = match turning(connection) {
            Turning::RotationVector => vector::identity(),
            _ => aligned(connection, draw),
        };
        let a0 = draw.triad();
        let axis = spin_axis(connection, &a0, draw);
        let reference = draw.direction();
        let definition = definition(connection, pair(reference, a0, &q0), 1.0);
        let spin = scale(axis, PI - gap - angle_at_start(connection, &q0));
        let motion = Motion { steps: 8, ..Motion::random(draw, 1.0, spin) };
        Case::new(&format!("half a turn less {gap}"), definition, &motion, 1.0, draw)
    })
}

/// b turned against a by `size` rad, in steps below 0.7 rad; a type that holds all rotations turns as a whole.
fn many_turns(connection: &ConnectionType, size: f64, draw: &mut Draw) -> Case {
    let whole = turning(connection) == Turning::Align;
    regular(0.15, || {
        let q0 = match turning(connection) {
            Turning::RotationVector => vector::identity(),
            _ => aligned(connection, draw),
        };
        let a0 = draw.triad();
        let axis = spin_axis(connection, &a0, draw);
        let definition = definition(connection, pair(draw.direction(), a0, &q0), 1.0);
        let steps = (size / 0.35) as usize;
        let turned = scale(axis, size);
        let motion = if whole {
            Motion { common: turned, steps, ..Motion::random(draw, 1.0, draw_small(axis)) }
        } else {
            Motion { steps, ..Motion::random(draw, 1.0, turned) }
        };
        Case::new(&format!("through {size} rad"), definition, &motion, 1.0, draw)
    })
}

fn draw_small(axis: Vector<f64>) -> Vector<f64> {
    [0.3 * axis[1], -0.2 * axis[2], 0.25 * axis[0]]
}

/// Displacements of 2³⁰ (about 1e9) lengths, on a grid so coarse that their difference is exact.
fn far(connection: &ConnectionType, draw: &mut Draw) -> Case {
    regular(0.15, || {
        let q0 = aligned(connection, draw);
        let grid = |v: Vector<f64>| v.map(|x| (x * 1024.0).round() / 1024.0);
        let definition = definition(connection, pair(grid(draw.direction()), draw.triad(), &q0), 1.0);
        let spin = draw.rotation(0.3, 0.7);
        let mut motion = Motion::random(draw, 1.0, spin);
        let away = [1_073_741_824.0, -536_870_912.0, 1_073_741_824.5];
        motion.displacement = motion.displacement.map(|u| add(away, grid(u)));
        Case::new("1e9 lengths away", definition, &motion, 1.0, draw)
    })
}

/// Nodes in one place, initially and now.
fn coincident(connection: &ConnectionType, draw: &mut Draw) -> Case {
    regular(0.15, || {
        let q0 = aligned(connection, draw);
        let definition = definition(connection, pair([0.0; 3], draw.triad(), &q0), 1.0);
        let spin = draw.rotation(0.3, 0.7);
        let mut motion = Motion::random(draw, 1.0, spin);
        motion.displacement[1] = motion.displacement[0];
        Case::new("coincident", definition, &motion, 1.0, draw)
    })
}

/// Exact right angles: a in one of the 24 orientations of a cube, b in each of them, as far as the type is regular there; the
/// initial orientations as well.
fn cubes(connection: &ConnectionType, draw: &mut Draw) -> Vec<Case> {
    let all = cube_orientations();
    let mut found = Vec::new();
    for (i, q) in all.iter().enumerate() {
        let a0 = all[(7 * i + 3) % 24];
        // The initial orientation itself is a right angle in every second case; always where a half turn in one increment
        // would leave two sheets equally near.
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
        let name = format!("{} cube {i}", connection.name);
        let case = Case { name, definition, path: vec![end], length: 2.0 };
        if case.is_regular(0.15) {
            found.push(case);
        }
    }
    assert!(found.len() >= 4, "{}: only {} cube orientations are regular", connection.name, found.len());
    found
}

/// The same pair on another real number.
pub(crate) fn exact_pair<R: Real>(pair: &Pair<f64>) -> Pair<R> {
    let node = |node: &Node<f64>| Node {
        displacement: vector::exact(node.displacement),
        triad: vector::exact_matrix(&node.triad),
        flow: R::from_f64(node.flow),
    };
    Pair { reference: vector::exact(pair.reference), a: node(&pair.a), b: node(&pair.b) }
}

/// The same state on another real number.
pub(crate) fn exact_state<R: Real>(state: &State<f64>) -> State<R> {
    State {
        pair: exact_pair(&state.pair),
        velocity: state.velocity.map(R::from_f64),
        acceleration: state.acceleration.map(R::from_f64),
    }
}

/// The same branch on another real number.
pub(crate) fn exact_branch<R: Real>(branch: &Branch<f64>) -> Branch<R> {
    let exact = |t: pintle::connector::Turns<f64>| pintle::connector::Turns {
        turns: R::from_f64(t.turns),
        principal: R::from_f64(t.principal),
    };
    Branch {
        turns: branch.turns.map(exact),
        torsion: exact(branch.torsion),
        rotation_vector: vector::exact(branch.rotation_vector),
        euler_sign: R::from_f64(branch.euler_sign),
        accumulated: R::from_f64(branch.accumulated),
        accumulated_rest: R::from_f64(branch.accumulated_rest),
    }
}

/// The pair with its degrees of freedom moved by finite amounts: U + δx, exp(δθ^) C, Ψ + δΨ. Written apart from
/// `Pair::moved`, and used on numbers without derivatives.
pub(crate) fn moved<R: Differentiable>(pair: &Pair<R>, by: &[R; DOFS]) -> Pair<R> {
    let node = |node: &Node<R>, at: usize| Node {
        displacement: add(node.displacement, [by[at], by[at + 1], by[at + 2]]),
        triad: product(&turn([by[at + 3], by[at + 4], by[at + 5]]), &node.triad),
        flow: node.flow + by[at + 6],
    };
    Pair { reference: pair.reference, a: node(&pair.a, 0), b: node(&pair.b, 7) }
}

/// The pair after the rigid motion of space that turns it by R and gives node a the displacement `translation`.
pub(crate) fn carried(pair: &Pair<f64>, rotation: &Matrix<f64>, translation: Vector<f64>) -> Pair<f64> {
    // U_b' − U_a' must give R D = R (X_b − X_a + U_b − U_a) with the same X_b − X_a.
    let carried = apply(rotation, pair.separation());
    let mut moved = *pair;
    moved.a.displacement = translation;
    moved.b.displacement = add(translation, sub(carried, pair.reference));
    moved.a.triad = product(rotation, &pair.a.triad);
    moved.b.triad = product(rotation, &pair.b.triad);
    moved
}
