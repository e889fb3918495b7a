//! The two-dimensional forms (CONN2D2), and constraints of two-dimensional models.
//!
//! - The manual's 2D entries are transcribed.
//! - Values, rows, second derivatives and rates have formulas of the plane, with sines and cosines of plane angles and no rotation matrix.
//! - A connector in the plane equals that in space; constraints have their own formulas of the plane.

use crate::laws::{Check, Scales, functions};
use crate::states::{Draw, definition, pair, types};
use pintle_assembly::analyse;
use pintle_kinematics::catalog::{Availability, ConnectionType, PLANE, Slot, TABLE};
use pintle_kinematics::connector::{
    Branch, Components, Connector, Definition, Evaluation, Increment, Request, State, Tally,
};
use pintle_kinematics::node::{DOF_NUMBER, DOFS};
use pintle_kinematics::scalar::Duals;
use pintle_kinematics::scalar::elementary::{recip, sin_cos, sqrt};
use pintle_kinematics::scalar::{Scalar, Seeded};
use pintle_kinematics::vector::Matrix;
use pintle_model::evaluate::{Fixed, Jacobian, Model, Plan, Selection, Sequence};
use pintle_scene::{Format, Label, NodeMotion, Rotation, Scene, State as SceneState};
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

/// The manual's 2D entry of a type: name; constrained; available; number of constraints; solver; page.
type Row = (&'static str, &'static str, &'static str, usize, &'static str, &'static str);

/// Components u3, ur1 and ur2 do not exist in the plane, their forces and moments are zero.
const MANUAL: &[Row] = &[
    ("ALIGN", "ur3", "none", 1, "both", "connectiontypedesc-align: m1 = m2 = 0"),
    ("AXIAL", "none", "u1", 0, "both", "connectiontypedesc-axial"),
    (
        "BEAM",
        "u1, u2, ur3",
        "none",
        3,
        "both",
        "connectiontypedesc-beam; 2D up to 3 multipliers, connectorelem",
    ),
    ("CARTESIAN", "none", "u1, u2", 0, "both", "connectiontypedesc-cartesian: z = u3 = f3 = 0"),
    ("FLOW-CONVERTER", "ur3", "none", 1, "Standard", "connectiontypedesc-flowconverter"),
    ("JOIN", "u1, u2", "none", 2, "both", "connectiontypedesc-join: f3 = 0"),
    ("LINK", "u1", "none", 1, "both", "connectiontypecomponents, one line; the rest unread"),
    (
        "PROJECTION CARTESIAN",
        "none",
        "u1, u2",
        0,
        "both",
        "connectiontypedesc-projectioncartesian: z = u3 = f3 = 0",
    ),
    ("RETRACTOR", "u1, u2, ur3", "none", 3, "Standard", "seed RETRACTOR, Summary"),
    ("ROTATION", "none", "ur3", 0, "both", "seed ROTATION: ur1 = ur2 = 0, m1 = m2 = 0"),
    // Component 3 of a SLIPRING is Ψ_a, output only; CONN2D2 has components 1, 2 and 6.
    ("SLIPRING", "none", "u1, u2", 0, "Standard", "connectiontypedesc-slipring"),
    ("SLOT", "u2", "u1", 1, "both", "connectiontypedesc-slot: F_C = |f2|"),
    ("TRANSLATOR", "u2, ur3", "u1", 2, "both", "seed TRANSLATOR"),
    ("WELD", "u1, u2, ur3", "none", 3, "both", "connectiontypeassembledconnections"),
];

#[test]
fn the_plane_is_the_manuals() {
    let planar = TABLE.iter().filter(|entry| entry.planar != Availability::Never);
    let mut names: Vec<&str> = planar.clone().map(|entry| entry.name.as_ref()).collect();
    names.sort_unstable();
    let transcribed: Vec<&str> = MANUAL.iter().map(|row| row.0).collect();
    assert_eq!(names, transcribed, "the types with a two-dimensional form");
    for (name, constrained, available, count, solver, page) in MANUAL {
        let entry = ConnectionType::named(name, None).unwrap();
        let form = entry.in_plane();
        assert_eq!(form.component_list(Slot::is_constrained), *constrained, "{name}: {page}");
        assert_eq!(form.component_list(Slot::is_available), *available, "{name}: {page}");
        assert_eq!(form.components(Slot::is_constrained).count(), *count, "{name}: {page}");
        let solvers = match entry.planar {
            Availability::Always => "both",
            Availability::StandardOnly => "Standard",
            Availability::ExplicitOnly => "Explicit",
            Availability::Never => "none",
        };
        assert_eq!(solvers, *solver, "{name}: {page}");
    }
}

/// The degrees of freedom of the plane, in their order: x, y, θ and Ψ of a, then of b.
const FREEDOMS: [usize; 8] = [0, 1, 5, 6, 7, 8, 12, 13];

/// A connector in the plane, and where it goes.
struct Case {
    name: String,
    definition: Definition,
    connection: ConnectionType,
    /// The angles of e1a and e1b from the global 1 at first, and the sign of e3 = ±z.
    start: [f64; 2],
    sense: f64,
    reference: [f64; 2],
    /// x, y, θ, Ψ of a and b at the end.
    end: [f64; 8],
    steps: usize,
}

fn triad(angle: f64, sense: f64) -> Matrix<f64> {
    let (sin, cos) = angle.sin_cos();
    [[cos, -sense * sin, 0.0], [sin, sense * cos, 0.0], [0.0, 0.0, sense]]
}

impl Case {
    fn new(connection: &ConnectionType, draw: &mut Draw, sense: f64, turns: f64) -> Self {
        let start = [draw.between(-3.0, 3.0), draw.between(-3.0, 3.0)];
        let [x, y, _] = draw.direction();
        let reference = [1.2 + 0.3 * x, 0.5 * y];
        let initial = pair(
            [reference[0], reference[1], 0.0],
            triad(start[0], sense),
            &[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        );
        let mut initial = initial;
        initial.b.triad = triad(start[1], sense);
        let definition = Definition { planar: true, ..definition(connection, initial, 1.0) };
        let mut end = [0.0; 8].map(|_: f64| draw.between(-0.3, 0.3));
        let common = draw.between(-2.0, 2.0) + turns * 1.3;
        end[2] = common;
        // What is aligned turns together but for a misfit below half a turn.
        end[6] = common
            + if aligns(connection) { draw.between(-2.0, 2.0) } else { turns + draw.between(-1.0, 1.0) };
        let name = format!("{}, e3 = {sense} z, {turns} rad", connection.name);
        Self { name, definition, connection: connection.clone(), start, sense, reference, end, steps: 24 }
    }

    fn at(&self, t: f64) -> State<f64> {
        let [xa, ya, a, psi_a, xb, yb, b, psi_b] = self.end.map(|q| q * t);
        let mut pair = self.definition.initial;
        (pair.a.displacement, pair.b.displacement) = ([xa, ya, 0.0], [xb, yb, 0.0]);
        pair.a.triad = triad(self.start[0] + a, self.sense);
        pair.b.triad = triad(self.start[1] + b, self.sense);
        (pair.a.flow, pair.b.flow) = (psi_a, psi_b);
        State { pair, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] }
    }

    /// The evaluation at the end, after a history of equal steps.
    fn evaluate(&self, definition: &Definition, rates: &[[f64; DOFS]; 2]) -> Evaluation<f64> {
        let connector = Connector::<f64>::new(definition);
        let step = self.end.map(|q| q / self.steps as f64);
        let increment = Increment {
            rotation: [[0.0, 0.0, step[2]], [0.0, 0.0, step[6]]],
            whole_turns: [[0.0; 3]; 2],
            flow: [step[3], step[7]],
        };
        let mut branch: Branch<f64> = connector.initial_branch();
        for i in 1..self.steps {
            let state = self.at(i as f64 / self.steps as f64);
            branch = connector.advance(&state, &increment, &branch);
        }
        let mut last = self.at(1.0);
        [last.velocity, last.acceleration] = *rates;
        connector.evaluate(&last, &increment, &branch, &Request::everything(2), &mut Tally::default())
    }

    /// Position of each component, on any scalar, from x, y, θ and Ψ of both nodes.
    fn positions<S: Scalar<Real = f64>>(&self, q: [S; 8]) -> Components<S> {
        let [xa, ya, a, psi_a, xb, yb, b, psi_b] = q;
        let real = S::from_real;
        let (dx, dy) = (real(self.reference[0]) + xb - xa, real(self.reference[1]) + yb - ya);
        let resolve = |angle: S| {
            let (sin, cos) = sin_cos(angle);
            [cos * dx + sin * dy, (cos * dy - sin * dx).scale(self.sense)]
        };
        let length = || sqrt(dx * dx + dy * dy);
        // ur3, positive about e3 = ±z, counted on from its principal value at first.
        let between = self.sense * (self.start[1] - self.start[0]);
        let first = between - TAU * (between / TAU).round();
        let turned = real(first) + (b - a).scale(self.sense);
        let of_a = real(self.start[0]) + a;
        let [t, r] = self.connection.halves.map(|half| half.map(|half| half.name));
        let [u1, u2] = match t {
            Some("AXIAL" | "LINK") => [Some(length()), None],
            Some("CARTESIAN" | "JOIN" | "SLOT") => resolve(of_a).map(Some),
            // The half-angle bisector, which goes on turning past ±π.
            Some("PROJECTION CARTESIAN") => resolve(of_a + turned.scale(0.5 * self.sense)).map(Some),
            None if r.is_some() => [None, None],
            None => {
                let l0 = self.reference[0].hypot(self.reference[1]);
                [Some(length() * recip(real(l0) + psi_a - psi_b) - S::one()), Some(psi_b)]
            }
            Some(other) => panic!("{other} has no formula in the plane"),
        };
        let ur3 = match r {
            Some("ALIGN" | "ROTATION") => Some(turned),
            Some("FLOW-CONVERTER") => {
                Some((a - b).scale(self.sense) - psi_b.scale(self.definition.flow_scale))
            }
            None => None,
            Some(other) => panic!("{other} has no formula in the plane"),
        };
        [u1, u2, None, None, None, ur3]
    }
}

fn aligns(connection: &ConnectionType) -> bool {
    connection.halves[1].is_some_and(|half| half.name == "ALIGN")
}

fn planar_types() -> impl Iterator<Item = ConnectionType> {
    types().into_iter().filter(|entry| entry.planar != Availability::Never)
}

/// Every two-dimensional type and pair, with either sense of e3, and turned up to several times.
fn everywhere(mut judge: impl FnMut(&Case, &mut Draw)) {
    for connection in planar_types() {
        let draw = &mut Draw::new(&format!("plane, {}", connection.name));
        for sense in [1.0, -1.0] {
            for turns in [0.0, 0.9 * PI, 1.1 * PI, -3.0 * PI, 17.0] {
                judge(&Case::new(&connection, draw, sense, turns), draw);
            }
        }
    }
}

fn plane_rates(draw: &mut Draw) -> [[f64; DOFS]; 2] {
    [(); 2]
        .map(|()| std::array::from_fn(|j| if FREEDOMS.contains(&j) { draw.between(-1.0, 1.0) } else { 0.0 }))
}

/// Values, rows, second derivatives and rates are those of the formulas of the plane.
#[test]
fn the_plane_by_its_own_formulas() {
    type Dual = <f64 as Duals>::Hessian<8>;
    let [mut values, mut rows] = ["plane, values", "plane, rows"].map(Check::of);
    let [mut second, mut rate] = ["plane, second derivatives", "plane, rates"].map(Check::of);
    everywhere(|case, draw| {
        let rates = plane_rates(draw);
        let got = case.evaluate(&case.definition, &rates);
        let positions = case.positions(case.end);
        let initial = case.positions([0.0; 8]);
        let seeds: [Dual; 8] = std::array::from_fn(|i| Dual::seed(case.end[i], i));
        let duals = case.positions(seeds);
        let found = functions(&got);
        for k in 0..6 {
            let (Some(position), Some(dual)) = (positions[k], duals[k]) else {
                assert!(
                    got.position[k].is_none() && got.jacobian[k].is_none(),
                    "{}, component {}",
                    case.name,
                    k + 1
                );
                continue;
            };
            let place = || format!("{}, component {}", case.name, k + 1);
            let (gradient, hessian) = (dual.gradient(), dual.hessian());
            let mut row = [0.0; DOFS];
            let mut square = [[0.0; DOFS]; DOFS];
            for (i, j) in FREEDOMS.into_iter().enumerate() {
                row[j] = gradient[i];
                for (n, m) in FREEDOMS.into_iter().enumerate() {
                    square[j][m] = hessian[i][n];
                }
            }
            // Angles are recovered from direction cosines, in which those of the nodes are rounded.
            let turned = case.end[2].abs() + case.end[6].abs();
            let scales = Scales::new(position.abs() + initial[k].unwrap().abs() + turned, &row, &square, 1.0);
            let moved = found[k].expect("what is differentiated");
            values.against(place, moved, position - initial[k].unwrap(), scales.value);
            let at = got.position[k].expect("a position");
            values.against(place, at, position, scales.value);
            let (line, matrix) =
                (got.jacobian[k].expect("a row"), got.hessian[k].as_ref().expect("second derivatives"));
            for j in 0..DOFS {
                rows.against(|| format!("{}, ∂{j}", place()), line[j], row[j], scales.first[j]);
                for m in 0..DOFS {
                    second.against(
                        || format!("{}, ∂{j}∂{m}", place()),
                        matrix[j][m],
                        square[j][m],
                        scales.second(j, m),
                    );
                }
            }
            let along = |of: &[f64; DOFS]| (0..DOFS).map(|j| row[j] * of[j]).sum::<f64>();
            let curved: f64 = (0..DOFS)
                .flat_map(|j| (0..DOFS).map(move |m| (j, m)))
                .map(|(j, m)| square[j][m] * rates[0][j] * rates[0][m])
                .sum();
            let size = scales.value + (0..DOFS).map(|j| scales.first[j]).sum::<f64>() * 2.0;
            let velocity = got.residual_rate[k].or(got.velocity[k]).expect("a velocity");
            let acceleration = got.residual_acceleration[k].or(got.acceleration[k]).expect("an acceleration");
            rate.against(place, velocity, along(&rates[0]), size);
            rate.against(place, acceleration, along(&rates[1]) + curved, size);
        }
    });
    for check in [values, rows, second, rate] {
        check.finish();
    }
}

/// The connector in the plane is the connector in space without components and degrees of freedom 3, 4 and 5. Values, rows, second derivatives
/// and rates are the same to the last bit.
#[test]
fn the_plane_is_part_of_space() {
    let compared = std::cell::Cell::new(0);
    let same = |place: String, got: Option<f64>, want: Option<f64>| {
        assert!(got.map(|x| x + 0.0) == want.map(|x| x + 0.0), "{place}: {got:?}, not {want:?}");
        compared.set(compared.get() + usize::from(want.is_some_and(|x| x != 0.0)));
    };
    everywhere(|case, draw| {
        let rates = plane_rates(draw);
        let plane = case.evaluate(&case.definition, &rates);
        let space = case.evaluate(&Definition { planar: false, ..case.definition.clone() }, &rates);
        for k in 0..6 {
            let place = format!("{}, component {}", case.name, k + 1);
            let kept = PLANE[k];
            let outputs = |e: &Evaluation<f64>| {
                [
                    e.position[k],
                    e.displacement[k],
                    e.constitutive[k],
                    e.velocity[k],
                    e.acceleration[k],
                    e.residual[k],
                    e.residual_rate[k],
                    e.residual_bias[k],
                    e.residual_acceleration[k],
                    e.turns[k].map(|turns| turns.turns),
                ]
            };
            for (got, want) in outputs(&plane).into_iter().zip(outputs(&space)) {
                same(place.clone(), got, want.filter(|_| kept));
            }
            let (Some(row), true) = (plane.jacobian[k], kept) else {
                assert!(plane.jacobian[k].is_none(), "{place}");
                continue;
            };
            let (all, matrix) = (space.jacobian[k].unwrap(), plane.hessian[k].as_ref().unwrap());
            let whole = space.hessian[k].as_ref().unwrap();
            let remains = |j: usize| matches!(DOF_NUMBER[j], 1 | 2 | 6 | 10);
            for j in 0..DOFS {
                same(format!("{place}, ∂{j}"), Some(row[j]), Some(if remains(j) { all[j] } else { 0.0 }));
                assert!(remains(j) || all[j] == 0.0, "{place}: ∂{j} leads out of the plane");
                for m in 0..DOFS {
                    let want = if remains(j) && remains(m) { whole[j][m] } else { 0.0 };
                    same(format!("{place}, ∂{j}∂{m}"), Some(matrix[j][m]), Some(want));
                }
            }
        }
    });
    assert!(compared.get() > 10_000, "{}", compared.get());
}

/// A plane model: an element of two dimensions that is not read, and what stands below it.
fn flat(constraints: &str) -> (Scene, Model) {
    let text = format!(
        "*NODE\n1, 0., 0.\n2, 1., 0.\n3, 1.2, 1.\n4, -0.1, 0.8\n5, 0.3, 2.\n6, 0.3, 2.\n*ELEMENT, TYPE=B21\n50, 5, 6\n\
         *NSET, NSET=CLOUD\n1, 2, 3\n*NSET, NSET=LINE\n1, 2\n*SURFACE, TYPE=NODE, NAME=S\nCLOUD,\n*SURFACE, TYPE=NODE, NAME=L\nLINE,\n\
         *SURFACE, TYPE=NODE, NAME=ONE\n6,\n*SURFACE, TYPE=NODE, NAME=TWO\n5,\n*ORIENTATION, NAME=TURNED\n0.6, 0.8, 0., -0.8, 0.6, 0.\n{constraints}"
    );
    let scene = Scene::parse("flat.inp", &text)
        .unwrap_or_else(|error| panic!("{text}\n{}", error.render(110, false)));
    let model = Model::compile(&scene).unwrap_or_else(|error| panic!("{text}\n{}", error.render(110, false)));
    (scene, model)
}

/// Each constraint of a deck in a model of two dimensions: its equations, and its degrees of freedom, which are none of 3, 4 and 5.
const FLAT: [(&str, &[&str]); 11] = [
    ("*MPC\nBEAM, 5, 4\n", &["δ1", "δ2", "ρ3"]),
    ("*MPC\nPIN, 6, 5\n", &["δ1", "δ2"]),
    ("*MPC\nTIE, 5, 6\n", &["δ1", "δ2", "ρ3"]),
    ("*MPC\nLINK, 3, 4\n", &["δl"]),
    ("*RIGID BODY, REF NODE=5, TIE NSET=CLOUD\n", &["δ1", "δ2", "ρ3", "δ1", "δ2", "ρ3", "δ1", "δ2", "ρ3"]),
    ("*RIGID BODY, REF NODE=5, PIN NSET=LINE\n", &["δ1", "δ2", "δ1", "δ2"]),
    (
        "*COUPLING, CONSTRAINT NAME=C, REF NODE=5, SURFACE=L, ORIENTATION=TURNED\n*KINEMATIC\n1, 1\n",
        &["δ1", "δ1"],
    ),
    ("*COUPLING, CONSTRAINT NAME=C, REF NODE=5, SURFACE=ONE\n*KINEMATIC\n1, 2\n6, 6\n", &["δ1", "δ2", "ρ3"]),
    ("*COUPLING, CONSTRAINT NAME=C, REF NODE=5, SURFACE=S\n*DISTRIBUTING\n", &["δ1", "δ2", "ρ3"]),
    ("*COUPLING, CONSTRAINT NAME=C, REF NODE=5, SURFACE=L\n*DISTRIBUTING\n", &["δ1", "δ2", "ρ3"]),
    ("*TIE, NAME=T\nONE, TWO\n", &["g", "g", "ρ3"]),
];

/// Constraints in the plane: equations, degrees of freedom, the residual of a rigid motion, and rows as differences of residuals.
#[test]
fn constraints_are_those_of_the_plane() {
    let mut compared = 0;
    for (text, names) in FLAT {
        let (scene, model) = flat(text);
        let plan = Plan::compile(&model, &Selection::All, Request::everything(1)).unwrap();
        let jacobian = Jacobian::of_constraints(&model, &plan, &Fixed::of(&scene).unwrap());
        let titles: Vec<String> =
            jacobian.equations().iter().map(|equation| equation.title(&model)).collect();
        let ends: Vec<&str> = titles.iter().map(|title| title.rsplit(' ').next().unwrap()).collect();
        assert_eq!(ends, names, "{text}");
        assert!(jacobian.freedoms().iter().all(|freedom| matches!(freedom.number, 1 | 2 | 6)), "{text}");
        // u, θ of each node, first as one body moves.
        let angle: f64 = 0.7;
        let turned = |x: [f64; 3]| {
            let (sine, cosine) = angle.sin_cos();
            [cosine * x[0] - sine * x[1] - x[0] + 0.4, sine * x[0] + cosine * x[1] - x[1] - 0.3, angle]
        };
        let rigid: BTreeMap<Label, [f64; 3]> =
            scene.nodes.iter().map(|(label, node)| (*label, turned(node.coordinates))).collect();
        let residuals = |moved: &BTreeMap<Label, [f64; 3]>| -> Vec<f64> {
            let state = SceneState {
                nodes: moved.iter().map(|(label, u)| (*label, plane_motion(*u))).collect(),
                ..SceneState::default()
            };
            let result = Sequence::new(&model, &plan).step(&state);
            let mpcs = result.mpcs.iter().flat_map(|of| of.evaluation.residual.into_iter().flatten());
            mpcs.chain(result.relations.iter().flat_map(|of| of.rows.iter().map(|row| row.residual)))
                .collect()
        };
        let at_rigid = residuals(&rigid);
        assert_eq!(at_rigid.len(), names.len(), "{text}");
        // An equation of displacements that a tie makes is met, for its nodes are at one place.
        assert!(at_rigid.iter().all(|residual| residual.abs() < 1e-14), "{text}: {at_rigid:?}");
        // Elsewhere rows are differences of residuals.
        let off: BTreeMap<Label, [f64; 3]> = rigid
            .iter()
            .enumerate()
            .map(|(n, (label, u))| {
                (*label, [u[0] + 0.01 * n as f64, u[1] - 0.02 * n as f64, u[2] + 0.03 * n as f64])
            })
            .collect();
        let state = SceneState {
            nodes: off.iter().map(|(label, u)| (*label, plane_motion(*u))).collect(),
            ..SceneState::default()
        };
        let mut values = Vec::new();
        Sequence::new(&model, &plan).assemble(&state, &jacobian, &mut values).unwrap();
        let mut entries = values.iter();
        for row in 0..jacobian.rows() {
            for column in jacobian.row(row) {
                let freedom = jacobian.freedoms()[*column as usize];
                let at = if freedom.number == 6 { 2 } else { usize::from(freedom.number) - 1 };
                let step = 1e-5;
                let [more, less] = [step, -step].map(|by| {
                    let mut moved = off.clone();
                    if let Some(u) = moved.get_mut(&freedom.node) {
                        u[at] += by;
                    }
                    residuals(&moved)[row]
                });
                let (got, want) = (*entries.next().unwrap(), (more - less) / (2.0 * step));
                assert!(
                    (got - want).abs() < 1e-9,
                    "{text}, {} by {freedom:?}: {got}, not {want}",
                    titles[row]
                );
                compared += 1;
            }
        }
        assert!(entries.next().is_none(), "{text}");
    }
    assert!(compared > 100, "{compared}");
}

/// Residuals by sines and cosines: δ of a BEAM along global axes, else along those that M carries; ρ3 an angle, of a mean that of a cloud.
#[test]
fn constraints_of_the_plane_in_closed_form() {
    type At<'a> = &'a dyn Fn(u64) -> ([f64; 2], [f64; 2], f64);
    type Equations<'e> = dyn Fn(At<'_>) -> Vec<f64> + 'e;
    /// x turned by an angle.
    fn turned(angle: f64, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sine, cosine) = angle.sin_cos();
        [cosine * x - sine * y, sine * x + cosine * y]
    }
    let minus = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
    let beam = |at: At<'_>| {
        let ((xs, x0s, turn_s), (xm, x0m, turn_m)) = (at(5), at(4));
        let delta = minus(minus(xs, xm), turned(turn_m, minus(x0s, x0m)));
        vec![delta[0], delta[1], turn_s - turn_m]
    };
    let body = |at: At<'_>| {
        let (xm, x0m, turn_m) = at(5);
        let of = |slave: u64| {
            let (xs, x0s, turn_s) = at(slave);
            let delta = minus(turned(-turn_m, minus(xs, xm)), minus(x0s, x0m));
            [delta[0], delta[1], turn_s - turn_m]
        };
        [1, 2, 3].into_iter().flat_map(of).collect()
    };
    let mean = |at: At<'_>| {
        let ((xm, x0m, turn_m), one, two) = (at(5), at(1), at(2));
        let middle = |a: [f64; 2], b: [f64; 2]| [(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0];
        let (now, then) = (middle(one.0, two.0), middle(one.1, two.1));
        let delta = minus(turned(-turn_m, minus(xm, now)), minus(x0m, then));
        let [mut lag, mut square] = [0.0; 2];
        for (x, x0, _) in [one, two] {
            let (seen, arm) = (turned(-turn_m, minus(x, now)), minus(x0, then));
            lag += seen[0] * arm[1] - seen[1] * arm[0];
            square += arm[0] * arm[0] + arm[1] * arm[1];
        }
        vec![delta[0], delta[1], lag / square]
    };
    let cases: [(&str, &Equations<'_>); 3] = [
        ("*MPC\nBEAM, 5, 4\n", &beam),
        ("*RIGID BODY, REF NODE=5, TIE NSET=CLOUD\n", &body),
        ("*COUPLING, CONSTRAINT NAME=C, REF NODE=5, SURFACE=L\n*DISTRIBUTING\n", &mean),
    ];
    let mut compared = 0;
    for (text, wanted) in cases {
        let (scene, model) = flat(text);
        let plan = Plan::compile(&model, &Selection::All, Request::everything(0)).unwrap();
        let mut draw = Draw::new(text);
        for _ in 0..20 {
            let moved: BTreeMap<Label, [f64; 3]> = scene
                .nodes
                .keys()
                .map(|label| {
                    (*label, [draw.between(-1.0, 1.0), draw.between(-1.0, 1.0), draw.between(-1.5, 1.5)])
                })
                .collect();
            let state = SceneState {
                nodes: moved.iter().map(|(label, u)| (*label, plane_motion(*u))).collect(),
                ..SceneState::default()
            };
            let result = Sequence::new(&model, &plan).step(&state);
            let mpcs = result.mpcs.iter().flat_map(|of| of.evaluation.residual.into_iter().flatten());
            let relations = result.relations.iter().flat_map(|of| of.rows.iter().map(|row| row.residual));
            let got: Vec<f64> = mpcs.chain(relations).collect();
            let want = wanted(&|label| {
                let label = Label::from(label);
                let [x, y, _] = scene.nodes[&label].coordinates;
                let u = moved[&label];
                ([x + u[0], y + u[1]], [x, y], u[2])
            });
            assert_eq!(got.len(), want.len(), "{text}");
            for (got, want) in got.iter().zip(&want) {
                assert!((got - want).abs() < 1e-14, "{text}: {got}, not {want}");
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 20 * (3 + 9 + 3));
}

/// The motion of a node in the plane.
fn plane_motion([x, y, angle]: [f64; 3]) -> NodeMotion {
    let rotation = Rotation::Vector([0.0, 0.0, angle]);
    NodeMotion { displacement: [x, y, 0.0], rotation, ..NodeMotion::default() }
}

/// Mobility and redundancy are those of the plane, whatever holds a bar rigid; beside an element of three dimensions they are those of space.
#[test]
fn mobility_is_that_of_the_plane() {
    let bars = "*NODE\n1, 0., 0.\n2, 0., 1.\n3, 2., 1.5\n4, 2., 0.\n*NSET, NSET=B\n3\n*SURFACE, TYPE=NODE, NAME=S\n3,\n\
                *ELEMENT, TYPE=CONN2D2, ELSET=L\n10, 1, 2\n11, 3, 4\n*CONNECTOR SECTION, ELSET=L\nLINK\n*BOUNDARY\n1, 1, 2\n4, 1, 2\n";
    let mobility = |text: &str| {
        let scene = Scene::parse("bars.inp", &format!("{bars}{text}")).unwrap();
        let found = analyse(&scene, &Model::compile(&scene).unwrap(), &[], 1).unwrap();
        (found.positions.first().unwrap().mobility, found.redundant.len())
    };
    let link = "*ELEMENT, TYPE=CONN2D2, ELSET=L\n12, 2, 3\n";
    let coupling = "*COUPLING, CONSTRAINT NAME=C, REF NODE=2, SURFACE=S\n*KINEMATIC\n1, 2\n";
    for coupler in [link, "*MPC\nLINK, 3, 2\n"] {
        assert_eq!(mobility(coupler), (Some(1), 0), "{coupler}");
    }
    // A node that carries another has a rotation of its own, and is a bar with it.
    for coupler in [coupling, "*RIGID BODY, REF NODE=2, PIN NSET=B\n", "*MPC\nBEAM, 3, 2\n"] {
        assert_eq!(mobility(coupler), (Some(1), 0), "{coupler}");
    }
    // The same with a solid in the deck: nodes may leave the plane.
    let solid = "*ELEMENT, TYPE=C3D4\n90, 1, 2, 3, 4\n";
    assert_ne!(mobility(&format!("{coupling}{solid}")).0, Some(1));
}

/// Terms in degrees of freedom that the plane has not are dropped with a warning; an orientation out of the plane is an error.
#[test]
fn what_is_not_of_the_plane_is_said() {
    let (_, model) = flat("*EQUATION\n3\n2, 1, 1., 3, 3, 2., 4, 1, -1.\n");
    assert_eq!(model.relations.len(), 1);
    assert_eq!(model.relations[0].relation.columns().len(), 2);
    assert!(model.warnings.iter().any(|warning| warning.message().contains("degree of freedom 3 of node 3")));
    let text = "*NODE\n1, 0., 0.\n2, 1., 0.\n*ELEMENT, TYPE=B21\n5, 1, 2\n*ORIENTATION, NAME=O\n0., 1., 0., 0., 0., 1.\n\
                *SURFACE, TYPE=NODE, NAME=S\n2,\n*COUPLING, CONSTRAINT NAME=C, REF NODE=1, SURFACE=S, ORIENTATION=O\n*KINEMATIC\n1, 1\n";
    let error = Model::compile(&Scene::parse("tilted.inp", text).unwrap()).unwrap_err();
    assert!(error.message().contains("do not lie in the 1-2 plane"), "{}", error.message());
    // What is written of a scene keeps its dimensions.
    let (scene, _) = flat("*MPC\nBEAM, 5, 4\n");
    assert!(scene.two_dimensional);
    let toml = scene.write(Format::Toml).unwrap().text;
    assert!(Scene::parse_toml("flat.toml", &toml).unwrap().two_dimensional, "{toml}");
    let deck = scene.write(Format::Deck).unwrap();
    assert!(deck.dropped.iter().any(|what| what.contains("two dimensions")), "{:?}", deck.dropped);
}
