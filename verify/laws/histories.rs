//! Paths: angles continue through half and whole turns, turns are counted, a saved branch continues bit for bit.

use super::{Check, assert_bits, functions};
use crate::states::{
    Case, Draw, Ends, Extent, Motion, about_1, about_3, cases, definition, exp, pair, types,
};
use pintle_kinematics::catalog::{ConnectionType, TABLE};
use pintle_kinematics::connector::{
    Branch, Connector, Definition, Evaluation, Increment, Output, Request, State, Tally,
};
use pintle_kinematics::measure::Measure;
use pintle_kinematics::node::{DOFS, Pair};
use pintle_kinematics::scalar::{Real, Scalar, Wide};
use pintle_kinematics::so3;
use pintle_kinematics::vector::{
    Vector, apply, apply_transposed, column, identity, product, scale, transpose,
};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn entry(name: &str) -> &'static ConnectionType {
    TABLE.iter().find(|entry| entry.name == name).expect(name)
}

fn at(pair: Pair<f64>) -> State<f64> {
    State { pair, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] }
}

/// A walk of one connector that commits the branch after every state.
struct Walk {
    connector: Connector<f64>,
    branch: Branch<f64>,
    last: Pair<f64>,
}

impl Walk {
    fn new(definition: &Definition) -> Self {
        let connector = Connector::new(definition);
        Self { branch: connector.initial_branch(), connector, last: definition.initial }
    }

    fn to(&mut self, pair: Pair<f64>, increment: &Increment<f64>) -> Evaluation<f64> {
        let outputs = [Output::CP, Output::CU, Output::RES, Output::TURNS];
        let request = Request::new(&outputs, [true; 6], 0);
        let tally = &mut Tally::default();
        let got = self.connector.evaluate(&at(pair), increment, &self.branch, &request, tally);
        self.branch = got.branch;
        self.last = pair;
        got
    }

    /// With the increments that less than half a turn of each node implies.
    fn short(&mut self, pair: Pair<f64>) -> Evaluation<f64> {
        let step = crate::states::Step::between(&self.last, pair);
        self.to(pair, &step.increment)
    }

    /// With no word on the increments: the poses alone.
    fn told_nothing(&mut self, pair: Pair<f64>) -> Evaluation<f64> {
        self.to(pair, &Increment::none())
    }
}

/// b with Q = A₀ᵀB as given, a at rest.
fn posed(initial: &Pair<f64>, q: &pintle_kinematics::vector::Matrix<f64>) -> Pair<f64> {
    let mut pair = *initial;
    pair.b.triad = product(&pair.a.triad, q);
    pair
}

/// Q = Rx(α) of a hinge, through 1000 turns forward and on to 1000 backward, in steps just short of half a turn.
#[test]
fn a_hinge_counts_its_turns() {
    let mut check = Check::of("angles along paths");
    for name in ["REVOLUTE", "HINGE", "CYLINDRICAL", "PLANAR", "UNIVERSAL", "UJOINT"] {
        let start = 0.3;
        let a0 = Draw::new(name).triad();
        let definition = definition(entry(name), pair([0.2, -0.1, 0.4], a0, &about_1(start)), 1.0);
        let mut walk = Walk::new(&definition);
        let mut angle: f64 = 0.0;
        for i in 0..7000 {
            angle += if i < 2500 { 2.6 } else { -2.9 };
            let got = walk.told_nothing(posed(&definition.initial, &about_1(start + angle)));
            let place = || format!("{name} at {angle} rad");
            // The argument of the sine is rounded before the turn is taken out of it.
            check.against(place, got.displacement[3].unwrap(), angle, 1.0 + angle.abs());
            let turns = got.turns[3].unwrap();
            let expected = ((start + angle - turns.principal) / TAU).round();
            assert_eq!(turns.turns, expected, "{}", place());
            assert!(turns.principal.abs() <= PI, "{}: principal {}", place(), turns.principal);
        }
        assert!(walk.branch.turns[3].turns < -1000.0, "{name}: {:?}", walk.branch.turns[3]);
    }
    check.finish();
}

/// Increments of several turns at once are counted from the whole turns that the nodes are said to make.
#[test]
fn whole_turns_of_the_nodes_are_counted() {
    let mut check = Check::of("angles along paths");
    for (name, axis, q0, c) in [
        ("REVOLUTE", 0, about_1(0.3), 3),
        ("CARDAN", 0, about_1(0.3), 3),
        ("EULER", 2, product(&about_3(0.3), &about_1(1.0)), 3),
        ("ROTATION", 1, identity(), 4),
        ("FLEXION-TORSION", 2, product(&about_3(0.3), &about_1(0.7)), 4),
        ("FLEXION-TORSION", 2, product(&about_3(0.3), &about_1(0.7)), 5),
        ("PROJECTION FLEXION-TORSION", 2, product(&about_3(0.3), &about_1(0.7)), 5),
        ("CONSTANT VELOCITY", 2, product(&about_3(0.3), &about_1(0.7)), 4),
    ] {
        for carrier in [0, 1] {
            let a0 = Draw::new(name).triad();
            let definition = definition(entry(name), pair([1.0, 0.0, 0.0], a0, &q0), 1.0);
            let mut walk = Walk::new(&definition);
            let direction = column(&a0, axis);
            let mut angle = 0.0;
            for step in [5.0 * TAU + 0.3, -12.0 * TAU + 1.0, 0.5, 3.0 * TAU - 0.2, 100.0 * TAU + 0.4] {
                angle += step;
                let mut next = definition.initial;
                let signed = if carrier == 0 { -angle } else { angle };
                let node = if carrier == 0 { &mut next.a } else { &mut next.b };
                node.triad = product(&exp(scale(direction, signed)), &node.triad);
                let mut increment = Increment::none();
                let told = if carrier == 0 { -step } else { step };
                increment.rotation[carrier] = scale(direction, told);
                increment.whole_turns[carrier] = scale(direction, TAU * (told / TAU).round());
                let got = walk.to(next, &increment);
                let place = || format!("{name}, node {carrier}, {angle} rad");
                check.against(place, got.displacement[c].unwrap(), angle, 1.0 + 4.0 * angle.abs());
            }
        }
    }
    check.finish();
}

/// Q = Rx(α) Ry(β) Rz(γ): α and γ wind independently, thousands of radians each, while β swings close to the lock.
#[test]
fn cardan_angles_wind() {
    let mut check = Check::of("angles along paths");
    let definition =
        definition(entry("CARDAN"), pair([1.0, 0.0, 0.0], Draw::new("C").triad(), &identity()), 1.0);
    let mut walk = Walk::new(&definition);
    for i in 1..=3000 {
        let t = f64::from(i);
        let (alpha, beta, gamma) = (0.9 * t, 1.4 * (0.11 * t).sin(), -1.3 * t + (0.3 * t).sin());
        let q = product(&product(&about_1(alpha), &exp([0.0, beta, 0.0])), &about_3(gamma));
        let got = walk.told_nothing(posed(&definition.initial, &q));
        for (c, want) in [(3, alpha), (4, beta), (5, gamma)] {
            let scale = 4.0 * (1.0 + alpha.abs() + gamma.abs()) / beta.cos();
            check.against(
                || format!("CARDAN at {t}, component {}", c + 1),
                got.displacement[c].unwrap(),
                want,
                scale,
            );
        }
    }
    check.finish();
}

/// At the locks of CARDAN and EULER, exactly, of Q only the sum or the difference of first and third angle is left: the first is
/// held where the path left it, and the third takes what is known of the two.
#[test]
fn at_an_exact_lock_the_first_angle_is_held() {
    let mut check = Check::of("angles along paths");
    let (first, known) = (0.7_f64, 1.1_f64);
    let (sin, cos) = known.sin_cos();
    // γ + α, γ − α of CARDAN; α + γ, α − γ of EULER.
    let cases = [
        ("CARDAN", FRAC_PI_2, [[0.0, 0.0, 1.0], [sin, cos, 0.0], [-cos, sin, 0.0]], known - first),
        ("CARDAN", -FRAC_PI_2, [[0.0, 0.0, -1.0], [sin, cos, 0.0], [cos, -sin, 0.0]], known + first),
        ("EULER", 0.0, about_3(known), known - first),
        ("EULER", PI, [[cos, sin, 0.0], [sin, -cos, 0.0], [0.0, 0.0, -1.0]], first - known),
    ];
    for (name, lock, exact, third) in cases {
        let before = |beta: f64, third: f64| match name {
            "CARDAN" => product(&product(&about_1(first), &exp([0.0, beta, 0.0])), &about_3(third)),
            _ => product(&product(&about_3(first), &about_1(beta)), &about_3(third)),
        };
        let near = if lock > 0.0 { lock - 0.1 } else { lock + 0.1 };
        let start = pair([1.0, 0.0, 0.0], identity(), &before(near, third - 0.2));
        let definition = definition(entry(name), start, 1.0);
        let mut walk = Walk::new(&definition);
        let got = walk.told_nothing(posed(&definition.initial, &exact)).position;
        for (c, want) in [(3, first), (4, lock), (5, third)] {
            let place = || format!("{name} at β = {lock}, component {}", c + 1);
            check.against(place, got[c].unwrap(), want, 4.0);
        }
    }
    check.finish();
}

/// Q = Rz(α) Rx(β) Rz(γ): β passes through 0, π, 2π … and comes back, α and γ wind meanwhile; nothing jumps.
#[test]
fn euler_angles_continue_through_the_lock() {
    let mut check = Check::of("angles along paths");
    let start = [0.4, 0.9, -0.2];
    let posed_by =
        |[alpha, beta, gamma]: [f64; 3]| product(&product(&about_3(alpha), &about_1(beta)), &about_3(gamma));
    let initial = pair([1.0, 0.0, 0.0], Draw::new("E").triad(), &posed_by(start));
    let definition = definition(entry("EULER"), initial, 1.0);
    let mut walk = Walk::new(&definition);
    let mut angles = start;
    let mut flips = 0;
    let mut sign = 1.0;
    for i in 1..=2000 {
        // Steps of 0.37 never land on a lock: β/0.37 is irrational to π.
        let forward = if i <= 1200 { 1.0 } else { -1.0 };
        angles[0] += 0.21;
        angles[1] += 0.37 * forward;
        angles[2] -= 0.33;
        let got = walk.told_nothing(posed(&definition.initial, &posed_by(angles)));
        flips += usize::from(walk.branch.euler_sign != sign);
        sign = walk.branch.euler_sign;
        let total: f64 = angles.iter().map(|x| x.abs()).sum();
        for c in 0..3 {
            let scale = 4.0 * (1.0 + total) / angles[1].sin().abs();
            let place = || format!("EULER at step {i}, component {}", c + 4);
            check.against(place, got.displacement[3 + c].unwrap(), angles[c] - start[c], scale);
        }
    }
    assert!(flips > 200, "β changed sheets only {flips} times");
    check.finish();
}

/// Q = Rz(φ) Ry(α) Rz(ψ): the torsion β = φ + ψ winds thousands of radians either way while the flexion α swings and the sweep
/// φ + π/2 winds. The component flexions are α (−sin χ, cos χ), χ = (φ − ψ)/2, and the directions midway are those of
/// Rz(φ) Ry(α/2) Rz((ψ − φ)/2) throughout: nothing jumps at |β| = π, 2π …, though the poses return after one turn, they after two.
#[test]
fn torsion_winds() {
    let mut check = Check::of("angles along paths");
    let ry = |angle: f64| exp([0.0, angle, 0.0]);
    let posed_by =
        |phi: f64, alpha: f64, psi: f64| product(&product(&about_3(phi), &ry(alpha)), &about_3(psi));
    let path = |i: i32| {
        let t = f64::from(i);
        let forward = if i <= 1800 { t } else { 3600.0 - t };
        (0.8 * forward, 1.5 + 1.2 * (0.11 * t).cos(), 1.1 * forward - 0.3 * (0.2 * t).sin())
    };
    let (phi_0, alpha_0, psi_0) = path(0);
    let reference = [0.7, -0.4, 1.1];
    let flexions = |phi: f64, alpha: f64, psi: f64| {
        let (sin, cos) = (0.5 * (phi - psi)).sin_cos();
        [-alpha * sin, alpha * cos]
    };
    for name in
        ["FLEXION-TORSION", "PROJECTION FLEXION-TORSION", "BUSHING", "PROJECTION CARTESIAN", "CVJOINT"]
    {
        let a0 = Draw::new(name).triad();
        let start = pair(apply(&a0, reference), a0, &posed_by(phi_0, alpha_0, psi_0));
        let definition = definition(entry(name), start, 1.0);
        let connection = entry(name);
        let mut walk = Walk::new(&definition);
        for i in 1..=3900 {
            let (phi, alpha, psi) = path(i);
            let got = walk.told_nothing(posed(&definition.initial, &posed_by(phi, alpha, psi)));
            let [now, then] = [flexions(phi, alpha, psi), flexions(phi_0, alpha_0, psi_0)];
            // How the angles move with the third directions; their arguments are rounded besides.
            let scale = 4.0 * (1.0 + phi.abs() + psi.abs()) / (alpha.sin().abs() * (0.5 * alpha).cos());
            let middle = [(phi, alpha, psi), (phi_0, alpha_0, psi_0)]
                .map(|(phi, alpha, psi)| posed_by(phi, 0.5 * alpha, 0.5 * (psi - phi)))
                .map(|frame| apply_transposed(&frame, reference));
            for c in 0..6 {
                let Some(measure) = connection.slots[c].position() else { continue };
                let want = match measure {
                    Measure::Flexion => alpha - alpha_0,
                    Measure::Torsion => phi + psi - phi_0 - psi_0,
                    Measure::Sweep => phi - phi_0,
                    Measure::ComponentFlexion(k) => now[k - 1] - then[k - 1],
                    Measure::ProjectedPosition(k) => middle[0][k - 1] - middle[1][k - 1],
                    _ => continue,
                };
                let place = || format!("{name} at step {i}, component {}", c + 1);
                check.against(place, functions(&got)[c].unwrap(), want, scale);
            }
        }
        let turns = walk.branch.torsion.turns;
        assert!(matches!(name, "FLEXION-TORSION" | "CVJOINT") || turns < -50.0, "{name}: {turns} turns");
    }
    check.finish();
}

/// A rotation vector grows through 2πk along a fixed axis, and keeps its direction; coming back it returns to zero.
#[test]
fn rotation_vectors_continue_through_whole_turns() {
    let mut check = Check::of("angles along paths");
    for name in ["ROTATION", "ROTATION-ACCELEROMETER"] {
        let draw = &mut Draw::new(name);
        let initial = pair([1.0, 0.0, 0.0], draw.triad(), &identity());
        let definition = definition(entry(name), initial, 1.0);
        let axis = draw.direction();
        let mut walk = Walk::new(&definition);
        let mut angle: f64 = 0.0;
        for i in 1..=400 {
            angle += if i <= 220 { 0.5 } else { -0.67 };
            let mut next = definition.initial;
            next.b.triad = product(&exp(scale(axis, angle)), &next.b.triad);
            let got = walk.short(next);
            let local = apply_transposed(&definition.initial.a.triad, axis);
            for c in 0..3 {
                // Near a whole turn the direction is known to u/|sin(φ/2)| only; at zero turns the log is regular.
                let lateral = if angle.abs() < PI { 1.0 } else { (0.5 * angle).sin().abs() };
                let scale = 2.0 * (1.0 + angle.abs()) / lateral;
                let place = || format!("{name} at {angle} rad, component {}", c + 4);
                check.against(place, got.displacement[3 + c].unwrap(), angle * local[c], scale);
            }
        }
        assert!(angle < -PI, "{name}: the path comes back through zero to {angle}");
    }
    check.finish();
}

/// A drum turned by thousands of turns takes in as much belt as its circumference says: ur3 stays what it must be.
#[test]
fn a_drum_winds_thousands_of_turns() {
    let mut check = Check::of("accumulated turns");
    for name in ["FLOW-CONVERTER", "RETRACTOR"] {
        let a0 = Draw::new(name).triad();
        let mut definition = definition(entry(name), pair([0.0; 3], a0, &identity()), 1.0);
        definition.flow_scale = 4.0;
        let axis = column(&a0, 2);
        let mut walk = Walk::new(&definition);
        let (mut angle, mut flow) = (Wide::zero(), Wide::zero());
        let steps = 6000;
        for i in 1..=steps {
            let (turned, taken) = (2.5, if i % 3 == 0 { 1.9 } else { 0.6 });
            angle += turned;
            flow += taken;
            let mut next = definition.initial;
            next.a.triad = product(&exp(scale(axis, angle.to_f64())), &a0);
            next.b.flow = flow.to_f64();
            let mut increment = Increment::none();
            increment.rotation[0] = scale(axis, turned);
            increment.flow[1] = taken;
            let got = walk.to(next, &increment);
            // The sum itself loses nothing; the rotation vectors of the steps are rounded, all alike.
            let scale = (angle + flow * 4.0).to_f64();
            let want = angle - flow * 4.0;
            check.compare(|| format!("{name} after {i} steps"), got.residual[5].unwrap(), want, scale);
        }
        assert!(angle > 2000.0 * TAU, "only {angle} rad");
    }
    check.finish();
}

/// The constraint of a drum is a one-form, not a function of the pose: e3a carried round an octant by rotations about axes
/// across itself accumulates nothing, and returns turned by a right angle about itself.
#[test]
fn a_drum_has_no_potential() {
    let definition = definition(entry("FLOW-CONVERTER"), pair([0.0; 3], identity(), &identity()), 1.0);
    let mut walk = Walk::new(&definition);
    let mut pose = definition.initial;
    let quarter = PI / 2.0;
    let mut accumulated = f64::NAN;
    // e3 → e1 about e2, e1 → e2 about e3, e2 → e3 about e1: each across the direction that it carries.
    for axis in [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]] {
        let step = scale(axis, quarter);
        pose.a.triad = product(&exp(step), &pose.a.triad);
        let mut increment = Increment::none();
        increment.rotation[0] = step;
        accumulated = walk.to(pose, &increment).residual[5].unwrap();
    }
    assert!(accumulated.abs() < 1e-15, "accumulated {accumulated}");
    let returned = so3::log(&product(&pose.a.triad, &transpose(&definition.initial.a.triad)));
    let (_, angle) = f64::direction_and_norm(returned);
    assert!((angle - quarter).abs() < 1e-14, "the drum returned turned by {angle}");
    assert!((pose.a.triad[2][2] - 1.0).abs() < 1e-15, "e3a is not back");
}

/// Saved as JSON and read back anywhere along a path, the branch has the same bits and leads to the same bits.
#[test]
fn a_saved_branch_continues_bit_for_bit() {
    for connection in types() {
        for case in cases(&connection, Extent::Full) {
            if case.path.len() < 2 {
                continue;
            }
            saved_on_the_way(&case);
        }
    }
}

fn saved_on_the_way(case: &Case) {
    let connector = case.connector();
    let mut branch = connector.initial_branch();
    let mut restored = branch;
    let request = Request::everything(1);
    for (i, step) in case.path.iter().enumerate() {
        let evaluate = |branch: &Branch<f64>| {
            let tally = &mut Tally::default();
            connector.evaluate(&step.state, &step.increment, branch, &request, tally)
        };
        let (one, other) = (evaluate(&branch), evaluate(&restored));
        for c in 0..6 {
            let [x, y] = [&one, &other].map(|e| (functions(e)[c], e.jacobian[c]));
            let place = format!("{}, step {i}, component {}", case.name, c + 1);
            if let (Some(x), Some(y)) = (x.0, y.0) {
                assert_bits(&place, y, x);
            }
            if let (Some(x), Some(y)) = (x.1, y.1) {
                (0..DOFS).for_each(|j| assert_bits(&place, y[j], x[j]));
            }
        }
        branch = one.branch;
        let text = serde_json::to_string(&other.branch).expect("a branch can be written");
        restored = serde_json::from_str(&text).expect("a branch can be read");
        for (x, y) in bits(&branch).into_iter().zip(bits(&restored)) {
            assert_eq!(x, y, "{}, step {i}: the branch came back changed: {text}", case.name);
        }
    }
}

fn bits(branch: &Branch<f64>) -> Vec<u64> {
    let mut numbers: Vec<f64> = branch.turns.iter().flat_map(|t| [t.turns, t.principal]).collect();
    numbers.extend(branch.rotation_vector);
    numbers.extend([branch.torsion.turns, branch.torsion.principal]);
    numbers.extend([branch.euler_sign, branch.accumulated, branch.accumulated_rest]);
    numbers.into_iter().map(f64::to_bits).collect()
}

/// A path in small steps and the same path in steps eight times larger end on the same sheets.
#[test]
fn the_end_of_a_path_does_not_depend_on_its_steps() {
    let mut check = Check::of("angles along paths");
    for connection in types() {
        let full = cases(&connection, Extent::Full);
        for case in full.iter().filter(|case| case.name.contains("through")) {
            let connector = case.connector();
            if connector.differentiated(5).is_some_and(|m| m.is_one_form()) {
                continue; // a sum over steps
            }
            let coarse = case.evaluate(&Request::everything(0)).0;
            let mut walk = Walk::new(&case.definition);
            let mut last = None;
            let motion = refit(case);
            for i in 1..=8 * case.path.len() {
                last = Some(
                    walk.short(motion.at(&case.definition.initial, i as f64 / (8 * case.path.len()) as f64)),
                );
            }
            let fine = last.expect("a path has an end");
            for c in 0..6 {
                let (Some(x), Some(y)) = (functions(&coarse)[c], functions(&fine)[c]) else { continue };
                check.against(|| format!("{}, component {}", case.name, c + 1), y, x, 64.0 * (1.0 + x.abs()));
            }
        }
    }
    check.finish();
}

/// The motion that a case was built from, read off its first step.
fn refit(case: &Case) -> Motion {
    let steps = case.path.len();
    let n = steps as f64;
    let first = &case.path[0];
    let [of_a, of_b] = first.increment.rotation;
    // exp(Δ_b) = exp(common/n) exp(spin/n) for the first step.
    let spin = so3::log(&product(&exp(scale(of_a, -1.0)), &exp(of_b)));
    let whole = |v: Vector<f64>| scale(v, n);
    let pair = &first.state.pair;
    Motion {
        common: whole(of_a),
        spin: whole(spin),
        displacement: [whole(pair.a.displacement), whole(pair.b.displacement)],
        flow: [pair.a.flow * n, pair.b.flow * n],
        steps,
    }
}

/// Increments of more than half π, some of which end near whole turns, where the direction of the rotation vector says nothing: no turn is
/// lost, and none is doubted.
#[test]
fn large_increments_of_a_rotation_keep_their_turns() {
    use pintle_kinematics::connector::{Connector, Definition, Increment, Output, Request, State, Tally};
    use pintle_kinematics::node::{DOFS, Node, Pair};
    use std::f64::consts::{PI, TAU};
    let node = |triad| Node { displacement: [0.0; 3], triad, flow: 0.0 };
    let identity = identity();
    let initial = Pair { reference: [0.0; 3], a: node(identity), b: node(identity) };
    let connection = ConnectionType::named("ROTATION", None).unwrap();
    let connector = Connector::<f64>::new(&Definition::new(connection, initial));
    let request = Request::new(&[Output::CU], [true; 6], 0);
    for fraction in (45..90).map(|percent| f64::from(percent) / 100.0) {
        let mut branch = connector.initial_branch();
        let mut near = 0;
        for step in 1..=400 {
            let angle = fraction * PI * f64::from(step);
            let rest = angle - TAU * (angle / TAU).round();
            near += usize::from(rest.abs() < 0.1);
            let turned = so3::matrix(so3::exp_quaternion([rest, 0.0, 0.0]));
            let state = State {
                pair: Pair { b: node(turned), ..initial },
                velocity: [0.0; DOFS],
                acceleration: [0.0; DOFS],
            };
            let increment = Increment::none();
            let result = connector.evaluate(&state, &increment, &branch, &request, &mut Tally::default());
            let flags = connector.flags(&[None; 6], &increment, &state, &branch, &result.branch);
            assert!(flags.is_empty(), "{fraction} π, step {step}: {flags:?}");
            let error = (result.displacement[3].unwrap() - angle).abs();
            assert!(error < 1e-12 * (1.0 + angle), "{fraction} π, step {step}: off by {error}");
            branch = result.branch;
        }
        assert!(near > 0, "{fraction} π never comes near a whole turn");
    }
}
