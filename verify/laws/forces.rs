//! Nodal forces are the transposed rows times component forces: equilibrium, power, stiffness, rigid motion, and the ways back.

use super::Check;
use crate::states::{
    Case, Ends, carried, cases, cube_orientations, dof_size, exact_branch, exact_state, exp, extent, moved,
    types,
};
use crate::tolerance::WIDE;
use pintle_kinematics::Differentiable;
use pintle_kinematics::catalog::{ConnectionType, TABLE};
use pintle_kinematics::connector::{
    Branch, Components, Connector, Definition, Evaluation, Flag, Increment, NodalRow, Request, State, Tally,
};
use pintle_kinematics::force::{ForceRows, Want};
use pintle_kinematics::measure::Measure;
use pintle_kinematics::node::{DOFS, Node, Pair};
use pintle_kinematics::scalar::{Real, Scalar, Wide};
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Matrix, Vector, add, apply, column, cross, dot, identity, sub};

const ALL: [bool; 6] = [true; 6];
const EVERYTHING: Want = Want { stiffness: true, multipliers: true, motions: [false; 6] };

/// A connector at a state on some number, with component forces on all its components that have one.
struct Loaded<R: Differentiable> {
    connector: Connector<R>,
    state: State<R>,
    branch: Branch<R>,
    forces: Components<R>,
}

impl<R: Differentiable> Loaded<R> {
    fn of(case: &Case, seed: i32) -> Self {
        let narrow = case.connector();
        let end = case.end();
        let after = narrow.advance(&end.state, &end.increment, &case.branch_before(&narrow));
        let connector = Connector::<R>::new(&case.definition);
        // Odd sizes and both signs; exact in every number.
        let size = |k: i32| R::ratio((37 * (k + 1) + 11 * seed) % 17 - 8, 4);
        let forces = [0, 1, 2, 3, 4, 5]
            .map(|k| connector.has_force(k).then(|| size(i32::try_from(k).expect("small"))));
        let mut state = exact_state(&end.state);
        // Directions of doubles are perpendicular to doubles' rounding; identities rest on more.
        for node in [&mut state.pair.a, &mut state.pair.b] {
            node.triad = so3::matrix(so3::quaternion(&node.triad));
        }
        Self { connector, state, branch: exact_branch(&after), forces }
    }

    fn rows_at(&self, state: &State<R>, want: Want) -> ForceRows<R> {
        let branch = self.connector.advance(state, &Increment::none(), &self.branch);
        self.connector.force_rows(state, &branch, ALL, want, &mut Tally::default())
    }

    fn rows(&self, want: Want) -> ForceRows<R> {
        self.rows_at(&self.state, want)
    }

    fn evaluate(&self) -> Evaluation<R> {
        let request = Request::everything(1);
        self.connector.evaluate(
            &self.state,
            &Increment::none(),
            &self.branch,
            &request,
            &mut Tally::default(),
        )
    }
}

fn part<R: Copy>(row: &NodalRow<R>, at: usize) -> Vector<R> {
    [row[at], row[at + 1], row[at + 2]]
}

/// The size of each nodal force: Σ_k |f_k| (Σ_j |G_kj| s_j + Σ_ij |∂G_ki/∂q_j| s_i s_j)/s_i.
fn sizes(case: &Case) -> NodalRow<f64> {
    let loaded = Loaded::<f64>::of(case, 1);
    let rows = loaded.rows(EVERYTHING);
    let size: NodalRow<f64> = std::array::from_fn(|j| dof_size(j, case.length));
    let mut all = 0.0;
    for k in 0..6 {
        let (Some(force), Some(row)) = (loaded.forces[k], rows.row(k)) else { continue };
        let change = row.change.as_ref().expect("changes were wanted");
        for i in 0..DOFS {
            all += force.abs() * row.row[i].abs() * size[i];
            for j in 0..DOFS {
                all += force.abs() * change[i][j].abs() * size[i] * size[j];
            }
        }
    }
    size.map(|size| all / size)
}

fn all_cases() -> Vec<Case> {
    types().iter().flat_map(|connection| cases(connection, extent(connection))).collect()
}

/// On 237-bit numbers: equal to rounding.
fn assert_equal(place: impl Fn() -> String, got: Wide, want: Wide, scale: f64) {
    let error = (got - want).abs().to_f64();
    assert!(error <= WIDE * scale, "{}: {:e} is not {:e}", place(), got.to_f64(), want.to_f64());
}

/// Forces balance, and so do moments about any point; on doubles as they are, on 237 bits to rounding.
#[test]
fn nodal_forces_are_in_equilibrium() {
    let mut check = Check::of("equilibrium");
    for case in all_cases() {
        let scale = sizes(&case);
        let (narrow, wide) = (Loaded::<f64>::of(&case, 1), Loaded::<Wide>::of(&case, 1));
        let nodal = narrow.rows(Want::default()).nodal(&narrow.forces);
        let exact = wide.rows(Want::default()).nodal(&wide.forces);
        for i in 0..3 {
            check.against(|| format!("{} force {i}", case.name), nodal[i], -nodal[7 + i], scale[i]);
            assert_equal(|| format!("{} force {i}", case.name), exact[i], -exact[7 + i], scale[i]);
        }
        let arm = narrow.state.pair.separation();
        let exact_arm = wide.state.pair.separation();
        let lengths = dot(arm, arm).sqrt().max(case.length);
        for point in [[0.0; 3], [1.5, -0.75, 2.25], [-0.5, 8.0, 0.125]] {
            // About a point p beyond a: M_a + M_b + (x_a − p) × F_a + (x_b − p) × F_b, x_a = 0.
            let away = point.map(|p| p * case.length);
            let moments = add(part(&nodal, 3), part(&nodal, 10));
            let forces =
                add(cross(sub([0.0; 3], away), part(&nodal, 0)), cross(sub(arm, away), part(&nodal, 7)));
            let from = away.map(Wide::from_f64);
            let exact_moments = add(part(&exact, 3), part(&exact, 10));
            let exact_forces = add(
                cross(sub([Wide::zero(); 3], from), part(&exact, 0)),
                cross(sub(exact_arm, from), part(&exact, 7)),
            );
            let reach = 1.0 + 10.0 * lengths / case.length;
            for i in 0..3 {
                let place = || format!("{} moment {i} about {point:?}", case.name);
                check.against(place, moments[i], -forces[i], scale[3 + i] * reach);
                assert_equal(place, exact_moments[i], -exact_forces[i], scale[3 + i] * reach);
            }
        }
    }
    check.finish();
}

/// Nodal forces on doubles are those on 237 bits.
#[test]
fn nodal_forces_are_exact_to_rounding() {
    let mut check = Check::of("nodal forces");
    for case in all_cases() {
        let scale = sizes(&case);
        let (narrow, wide) = (Loaded::<f64>::of(&case, 1), Loaded::<Wide>::of(&case, 1));
        let nodal = narrow.rows(Want::default()).nodal(&narrow.forces);
        let exact = wide.rows(Want::default()).nodal(&wide.forces);
        for j in 0..DOFS {
            check.compare(|| format!("{} force {j}", case.name), nodal[j], exact[j], scale[j]);
        }
    }
    check.finish();
}

/// Whether the equations enforced are dependent at a state that is far from satisfying them, so that there are no multipliers: shafts
/// of a REVOLUTE at a right angle, and nothing else.
fn are_dependent(wide: &Loaded<Wide>, multipliers: &Components<Wide>) -> bool {
    let printed = |k: usize, m| wide.connector.differentiated(k) == Some(m);
    let [a, b] = [wide.state.pair.a, wide.state.pair.b].map(|node| column(&node.triad, 0));
    if printed(4, Measure::Cosine(1, 3))
        && printed(5, Measure::Cosine(1, 2))
        && dot(a, b).to_f64().abs() < 1e-12
    {
        return true;
    }
    let missing = (0..6).any(|k| wide.connector.is_constrained(k) && multipliers[k].is_none());
    assert!(!missing, "{multipliers:?}");
    false
}

/// F·q̇ = Σ f_k u̇_k over available components + Σ λ_k (res_k)˙ over constrained ones, for any motion, also one that violates the
/// constraints. The rates come from time derivatives of the measures, not from rows; the tension of a SLIPRING works on
/// |d|˙ − Ψ̇_a + Ψ̇_b.
#[test]
fn power_is_conserved() {
    let mut count = 0;
    for case in all_cases() {
        let wide = Loaded::<Wide>::of(&case, 1);
        let rows = wide.rows(EVERYTHING);
        let multipliers = rows.multipliers(&wide.forces);
        if are_dependent(&wide, &multipliers) {
            continue;
        }
        let evaluation = wide.evaluate();
        let mut power = Wide::zero();
        for k in 0..6 {
            let Some(force) = wide.forces[k] else { continue };
            power += if wide.connector.is_constrained(k) {
                multipliers[k].expect("a multiplier") * evaluation.residual_rate[k].expect("a rate")
            } else if wide.connector.position_measure(k) == Some(Measure::Strain) {
                let d = wide.state.pair.separation();
                let v = sub(part(&wide.state.velocity, 7), part(&wide.state.velocity, 0));
                let stretching = dot(d, v) / dot(d, d).square_root();
                force * (stretching - wide.state.velocity[6] + wide.state.velocity[13])
            } else {
                force * evaluation.velocity[k].expect("a rate")
            };
            count += 1;
        }
        let nodal = rows.nodal(&wide.forces);
        let nodal_power = super::times(&nodal, &wide.state.velocity);
        let scale: f64 = (0..DOFS).map(|j| sizes(&case)[j] * wide.state.velocity[j].to_f64().abs()).sum();
        assert_equal(|| format!("{} power", case.name), nodal_power, power, scale.max(1e-300));
    }
    assert!(count > 500, "only {count} forces");
}

/// ∂F_i/∂q_j against central differences of nodal forces on 237 bits; the geometric stiffness is its symmetric part where every row
/// is a gradient.
#[test]
fn stiffness_is_the_difference_of_nodal_forces() {
    let mut check = Check::of("stiffness");
    for case in all_cases() {
        let scale = sizes(&case);
        let (narrow, wide) = (Loaded::<f64>::of(&case, 2), Loaded::<Wide>::of(&case, 2));
        let rows = narrow.rows(EVERYTHING);
        let (got, geometric) = (rows.derivative(&narrow.forces), rows.geometric_stiffness(&narrow.forces));
        let reach = narrow.rows(Want::default());
        let of_gradients = (0..6).all(|k| reach.row(k).is_none_or(|row| row.is_gradient));
        for j in 0..DOFS {
            let h = Wide::from_f64(1e-25 * dof_size(j, case.length));
            let at = |h: Wide| {
                let mut by = [Wide::zero(); DOFS];
                by[j] = h;
                let mut state = wide.state;
                state.pair = moved(&wide.state.pair, &by);
                wide.rows_at(&state, Want::default()).nodal(&wide.forces)
            };
            let (plus, minus) = (at(h), at(-h));
            for i in 0..DOFS {
                let mut want = (plus[i] - minus[i]) / (h + h);
                if !narrow.connector.active()[j] {
                    want = Wide::from_f64(got[i][j]); // degrees of freedom that the type does not have
                }
                let size = scale[i] / dof_size(j, case.length);
                check.compare(|| format!("{} ∂F{i}/∂q{j}", case.name), got[i][j], want, size);
                if of_gradients {
                    let symmetric = 0.5 * (got[i][j] + got[j][i]);
                    let place = || format!("{} symmetric {i} {j}", case.name);
                    check.against(place, geometric[i][j], symmetric, size);
                }
            }
        }
    }
    check.finish();
}

/// Twice the forces give twice the nodal forces, and sums give sums: exactly, for powers of two.
#[test]
fn nodal_forces_are_linear() {
    for case in all_cases() {
        let one = Loaded::<Wide>::of(&case, 1);
        let other = Loaded::<Wide>::of(&case, 5);
        let rows = one.rows(Want::default());
        let sum: Components<Wide> =
            std::array::from_fn(|k| Some(one.forces[k]? + one.forces[k]? + other.forces[k]?));
        let (first, second, both) = (rows.nodal(&one.forces), rows.nodal(&other.forces), rows.nodal(&sum));
        let scale = sizes(&case);
        for j in 0..DOFS {
            let want = first[j] + first[j] + second[j];
            assert_equal(|| format!("{} {j}", case.name), both[j], want, 8.0 * scale[j]);
        }
    }
}

/// A rigid motion of space carries nodal forces along.
#[test]
fn rigid_motion_turns_nodal_forces() {
    let mut check = Check::of("carried forces");
    for case in all_cases() {
        let narrow = Loaded::<f64>::of(&case, 1);
        let before = narrow.rows(Want::default()).nodal(&narrow.forces);
        let rotation = exp([0.3, -0.7, 0.5]);
        let mut state = narrow.state;
        state.pair = carried(&narrow.state.pair, &rotation, [0.5, -2.0, 1.0].map(|x| x * case.length));
        let after = narrow.rows_at(&state, Want::default()).nodal(&narrow.forces);
        let scale = sizes(&case);
        let far = state.pair.a.displacement.iter().chain(&narrow.state.pair.a.displacement);
        let far = far.fold(case.length, |most: f64, x| most.max(x.abs())) / case.length;
        for at in [0, 3, 7, 10] {
            let want = apply(&rotation, part(&before, at));
            for i in 0..3 {
                let place = || format!("{} {}", case.name, at + i);
                check.against(place, after[at + i], want[i], scale[at + i] * far);
            }
        }
        for at in [6, 13] {
            check.against(|| format!("{} {at}", case.name), after[at], before[at], scale[at]);
        }
    }
    check.finish();
}

/// Reported forces, multipliers and nodal forces are three accounts of the same: Σ λ_k ∂res_k = Σ f_k G_k over the constrained
/// components, and the printed formula gives the moment of what it prints.
#[test]
fn reported_forces_and_multipliers_agree() {
    for case in all_cases() {
        let wide = Loaded::<Wide>::of(&case, 1);
        let rows = wide.rows(EVERYTHING);
        let scale = sizes(&case);
        let constrained: Components<Wide> =
            std::array::from_fn(|k| wide.forces[k].filter(|_| wide.connector.is_constrained(k)));
        let multipliers = rows.multipliers(&wide.forces);
        if are_dependent(&wide, &multipliers) {
            continue;
        }
        let evaluation = wide.evaluate();
        let nodal = rows.nodal(&constrained);
        let mut by_multipliers = [Wide::zero(); DOFS];
        for k in 0..6 {
            let (Some(multiplier), Some(row)) = (multipliers[k], evaluation.jacobian[k]) else { continue };
            for j in 0..DOFS {
                by_multipliers[j] += multiplier * row[j];
            }
        }
        for j in 0..DOFS {
            let place = || format!("{} multipliers, {j}", case.name);
            assert_equal(place, by_multipliers[j], nodal[j], scale[j]);
        }
        // The printed formula gives the moment of the components.
        let printed = rows.printed(&wide.forces);
        let zero = Wide::zero();
        if let Some(vector) = rows.of_printed([3, 4, 5].map(|k| printed[k].unwrap_or(zero))) {
            let moment = rows.moment(&wide.forces);
            for i in 0..3 {
                let place = || format!("{} printed {i}", case.name);
                assert_equal(place, vector[i], moment[i], 100.0 * scale[3]);
            }
        }
    }
}

/// A connector at rest whose b is turned and moved from a, and the flags of all its components.
fn special(name: &str, q: Matrix<f64>, d: Vector<f64>) -> (ForceRows<f64>, Components<f64>, Vec<Flag>) {
    let node = |triad, displacement| Node { displacement, triad, flow: 0.0 };
    let initial = Pair { reference: [0.0; 3], a: node(identity(), [0.0; 3]), b: node(q, d) };
    let connection = ConnectionType::named(name, None).expect("a type of the table");
    let connector = Connector::<f64>::new(&Definition::new(connection, initial));
    let state = State { pair: initial, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
    let branch = connector.initial_branch();
    let rows = connector.force_rows(&state, &branch, ALL, EVERYTHING, &mut Tally::default());
    let forces = [0, 1, 2, 3, 4, 5].map(|k| connector.has_force(k).then_some(1.0 + k as f64));
    let margins = connector.margins(&state, &branch, ALL);
    (rows, forces, connector.flags(&margins, &Increment::none(), &state, &branch, &branch))
}

/// At exact right angles, half turns, locks, coincident nodes and on axes, nodal forces and stiffness are finite, in equilibrium, and
/// what does not exist there is flagged by name.
#[test]
fn singular_states_are_finite_and_named() {
    let mut flagged = 0;
    for connection in TABLE {
        for q in cube_orientations() {
            for d in [[0.0; 3], [0.0, 0.0, 2.0], [1.0, 0.0, 0.0]] {
                let (rows, forces, flags) = special(&connection.name, q, d);
                flagged += flags.iter().filter(|flag| matches!(flag, Flag::Singular { .. })).count();
                let nodal = rows.nodal(&forces);
                let change = rows.derivative(&forces);
                let all = nodal.iter().chain(change.as_flattened());
                let worst = all.fold(0.0, |worst: f64, entry| worst.max(entry.abs()));
                let place = || format!("{} {q:?} {d:?}: {nodal:?}", connection.name);
                let finite = nodal.iter().chain(change.as_flattened()).all(|entry| entry.is_finite());
                assert!(finite, "{}", place());
                assert!(worst < 1e8 || !flags.is_empty(), "{} is large and not flagged", place());
                for i in 0..3 {
                    let size = worst.max(1.0) * 1e-14;
                    assert!((nodal[i] + nodal[7 + i]).abs() <= size, "{}", place());
                }
            }
        }
    }
    assert!(flagged > 100, "only {flagged} singular components");
}

/// Forces and lengths of 1e±300: nodal forces scale with them, and nothing overflows that need not.
#[test]
fn extreme_sizes_scale() {
    let mut compared = 0;
    for connection in TABLE.iter().filter(|entry| (0..6).any(|k| entry.loading(k).is_some())) {
        let q = exp([0.4, -0.3, 0.5]);
        let (rows, forces, _) = special(&connection.name, q, [1.0, 2.0, -0.5]);
        let nodal = rows.nodal(&forces);
        for size in [1e300, 1e-300] {
            let scaled = rows.nodal(&forces.map(|force| force.map(|force| force * size)));
            for j in 0..DOFS {
                let gap = (scaled[j] / size - nodal[j]).abs();
                assert!(
                    gap <= 1e-7 * nodal[j].abs() + 1e-14,
                    "{} {j}: {} {}",
                    connection.name,
                    scaled[j],
                    nodal[j]
                );
            }
            let (far, _, _) = special(&connection.name, q, [1.0, 2.0, -0.5].map(|x| x * size));
            let forces_alone = far.nodal(&forces);
            for j in [0, 1, 2, 7, 8, 9] {
                let gap = (forces_alone[j] - nodal[j]).abs();
                assert!(
                    gap <= 1e-13 * (1.0 + nodal[j].abs()),
                    "{} {j} at {size}: {forces_alone:?}",
                    connection.name
                );
                compared += usize::from(nodal[j] != 0.0);
            }
        }
    }
    assert!(compared > 200, "{compared}");
}
