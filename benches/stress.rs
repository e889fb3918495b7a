//! How errors grow under stress, beside nalgebra and num-dual used as they come: `cargo bench --bench stress`.
//!
//! Writes docs/stress.svg. Every error is against 237 bits. Ours are asserted to stay where they are promised to be, so that this is a
//! test that draws; the others are what anyone would write first.
#![expect(clippy::disallowed_methods, reason = "what is drawn beside ours is what these give")]

use nalgebra::{Matrix3, Rotation3, Vector3};
use num_dual::{Dual64, DualNum};
use pintle::catalog::ConnectionType;
use pintle::connector::{
    Branch, Connector, Definition, Evaluation, Flag, Increment, Output, Request, State, Tally,
};
use pintle::node::{DOFS, Node, Pair};
use pintle::scalar::{Real, Wide};
use pintle::so3;
use pintle::vector::{self, Matrix, identity};
use plotters::prelude::*;
use std::error::Error;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// u, the unit of rounding.
const U: f64 = 1.0 / 9_007_199_254_740_992.0;

/// What was swept, and the errors found.
struct Curve {
    of: &'static str,
    points: Vec<(f64, f64)>,
}

impl Curve {
    const fn new(of: &'static str) -> Self {
        Self { of, points: Vec::new() }
    }

    fn add(&mut self, swept: f64, error: f64) {
        self.points.push((swept, error));
    }

    fn worst(&self) -> f64 {
        let worse = |worst: f64, error: f64| if error.is_nan() { f64::INFINITY } else { worst.max(error) };
        self.points.iter().fold(0.0, |worst, (_, error)| worse(worst, *error))
    }
}

/// A picture: what is swept, the errors of ours and of others.
struct Panel {
    title: &'static str,
    swept: &'static str,
    unit: &'static str,
    ours: Vec<Curve>,
    others: Vec<Curve>,
}

/// What nalgebra gives to those who add up.
const SUM: &str = "nalgebra: sum of scaled_axis of increments";

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn connector(name: &str, reference: [f64; 3]) -> Result<(Connector<f64>, Definition)> {
    let node = Node { displacement: [0.0; 3], triad: identity(), flow: 0.0 };
    let definition =
        Definition::new(ConnectionType::named(name, None)?, Pair { reference, a: node, b: node });
    Ok((Connector::new(&definition), definition))
}

/// Node b of a connector turned and moved.
fn at(definition: &Definition, triad: Matrix<f64>, displacement: [f64; 3]) -> State<f64> {
    let b = Node { displacement, triad, flow: 0.0 };
    let pair = Pair { b, ..definition.initial };
    State { pair, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] }
}

fn evaluate(
    connector: &Connector<f64>,
    state: &State<f64>,
    branch: &Branch<f64>,
    order: u8,
) -> Evaluation<f64> {
    let request = Request::new(&[Output::CP, Output::CU], [true; 6], order);
    connector.evaluate(state, &Increment::none(), branch, &request, &mut Tally::default())
}

/// An angle as whole turns and the double nearest to the rest.
fn principal(angle: Wide) -> (f64, f64) {
    let turn = Wide::pi() + Wide::pi();
    let turns = (angle / turn).nearest_integer();
    (turns.to_f64(), (angle - turns * turn).to_f64())
}

/// principal + 2π turns.
fn total(turns: f64, principal: f64) -> Wide {
    Wide::from_f64(principal) + Wide::from_f64(turns) * (Wide::pi() + Wide::pi())
}

fn error(got: f64, want: Wide) -> f64 {
    (Wide::from_f64(got) - want).abs().to_f64()
}

fn about_x(angle: f64) -> Matrix<f64> {
    so3::matrix(so3::exp([angle, 0.0, 0.0]))
}

fn of_nalgebra(matrix: &Matrix<f64>) -> Rotation3<f64> {
    Rotation3::from_matrix_unchecked(Matrix3::from_fn(|i, j| matrix[i][j]))
}

/// A million increments of one HINGE: its turns are counted, sums of relative rotations drift.
fn drift() -> Result<Panel> {
    const STEPS: u64 = 1_000_000;
    const STEP: f64 = 0.7;
    let (connector, definition) = connector("HINGE", [0.0; 3])?;
    let mut branch = connector.initial_branch();
    let (mut before, mut sum) = (Rotation3::identity(), 0.0);
    let (mut ours, mut summed) = (Curve::new("pintle"), Curve::new(SUM));
    let mut next = 1;
    for step in 1..=STEPS {
        let (turns, rest) = principal(Wide::from_f64(STEP) * Wide::from_f64(step as f64));
        let state = at(&definition, about_x(rest), [0.0; 3]);
        let result = evaluate(&connector, &state, &branch, 0);
        branch = result.branch;
        let now = of_nalgebra(&state.pair.b.triad);
        sum += (now * before.inverse()).scaled_axis().x;
        before = now;
        if step == next || step == STEPS {
            next = (next * 5).div_ceil(3);
            let want = total(turns, rest);
            let got = result.displacement[3].ok_or("a HINGE has ur1")?;
            let of_ours = error(got, want);
            // One rounding of the angle, and those of the triad.
            assert!(of_ours <= U * (want.to_f64() + 8.0), "{step}: {of_ours}");
            ours.add(step as f64, of_ours);
            summed.add(step as f64, error(sum, want));
        }
    }
    let title = "a million increments of 0.7 rad, of a HINGE";
    Ok(Panel { title, swept: "increments", unit: "rad", ours: vec![ours], others: vec![summed] })
}

/// A billion turns, continued from a saved branch: the angle within its turn keeps all its digits.
fn turns() -> Result<Panel> {
    let (connector, definition) = connector("HINGE", [0.0; 3])?;
    let (first, second) = (2.5, 2.9);
    let (mut ours, mut one_double) = (Curve::new("pintle"), Curve::new("one double for the angle"));
    for turns in (0..=36).map(|k| 10_f64.powf(f64::from(k) / 4.0).round()) {
        let mut branch =
            evaluate(&connector, &at(&definition, about_x(first), [0.0; 3]), &connector.initial_branch(), 0)
                .branch;
        branch.turns[3].turns = turns;
        let saved: Branch<f64> = serde_json::from_str(&serde_json::to_string(&branch)?)?;
        let result = evaluate(&connector, &at(&definition, about_x(second), [0.0; 3]), &saved, 1);
        let after = result.branch.turns[3];
        assert_eq!(after.turns, turns);
        let want = Wide::from_f64(second - first);
        let of_ours = error(after.principal - saved.turns[3].principal, want);
        assert!(of_ours <= 8.0 * U, "{turns}: {of_ours}");
        let value = result.displacement[3].ok_or("a HINGE has ur1")?;
        assert!(error(value, total(turns, second)) <= U * (value.abs() + 8.0));
        let row = result.jacobian[3].ok_or("a HINGE has a row of ur1")?;
        assert!((row[10] - 1.0).abs() <= 4.0 * U, "{row:?}");
        ours.add(turns, of_ours);
        let one = |angle: f64| angle + TAU * turns;
        one_double.add(turns, error(one(second) - one(first), want));
    }
    let title = "0.4 rad of a HINGE after many turns, from a saved branch";
    Ok(Panel { title, swept: "turns before", unit: "rad", ours: vec![ours], others: vec![one_double] })
}

/// Far from the origin: initial positions and displacements are kept apart.
fn origin() -> Result<Panel> {
    let (mut ours, mut by_positions) = (Curve::new("pintle"), Curve::new("nalgebra: current positions"));
    let moved = 0.012_345_678_9;
    for far in (0..=36).map(|k| 10_f64.powf(f64::from(k) / 4.0)) {
        // Coordinates as a deck has them.
        let (connector, definition) = connector("CARTESIAN", [(far + 0.1) - far, 0.2, 0.3])?;
        let mut state = at(&definition, identity(), [moved + far, 0.0, 0.0]);
        state.pair.a.displacement = [far, 0.0, 0.0];
        // Displacements as large as that are given as doubles: what they are is known exactly.
        let want = Wide::from_f64(moved + far) - Wide::from_f64(far);
        let by_place = {
            let at_rest = at(&definition, identity(), [moved, 0.0, 0.0]);
            evaluate(&connector, &at_rest, &connector.initial_branch(), 0).displacement[0]
        };
        let of_ours = error(by_place.ok_or("a CARTESIAN has u1")?, Wide::from_f64(moved));
        assert!(of_ours <= 2.0 * U, "{far}: {of_ours}");
        let by_displacement = evaluate(&connector, &state, &connector.initial_branch(), 0).displacement[0];
        assert!(error(by_displacement.ok_or("a CARTESIAN has u1")?, want) <= 2.0 * U);
        ours.add(far, of_ours);
        let [a, b] = [Vector3::new(far, 0.0, 0.0), Vector3::new(far + 0.1, 0.2, 0.3)];
        let now = b + Vector3::new(moved, 0.0, 0.0);
        by_positions.add(far, error((now - a).x - (b - a).x, Wide::from_f64(moved)));
    }
    let title = "displacement of a CARTESIAN far from the origin";
    let swept = "distance from the origin / length";
    Ok(Panel { title, swept, unit: "length", ours: vec![ours], others: vec![by_positions] })
}

/// Towards a lock of successive rotations, where the second angle β makes the axes of the first and third one line: ∂β by the turn of b
/// about the global axis of β.
fn lock(of: Lock) -> Result<Panel> {
    let Lock { name, title, rotations, axis, other_is, by_entry } = of;
    let (connector, definition) = connector(name, [0.0; 3])?;
    let wide = Connector::<Wide>::new(&definition);
    let (mut ours, mut other) = (Curve::new("pintle"), Curve::new(other_is));
    for distance in (4..=44).map(|k| 10_f64.powf(-f64::from(k) / 4.0)) {
        let [first, second] = rotations(distance).map(|angles| so3::matrix(so3::exp(angles)));
        let turned = vector::product(&first, &second);
        let state = at(&definition, turned, [0.0; 3]);
        let found = evaluate(&connector, &state, &connector.initial_branch(), 1);
        let exact = |node: &Node<f64>| Node {
            displacement: vector::exact(node.displacement),
            triad: vector::exact_matrix(&node.triad),
            flow: Wide::from_f64(node.flow),
        };
        let still = [Wide::integer(0); DOFS];
        let pair = Pair {
            reference: vector::exact(state.pair.reference),
            a: exact(&state.pair.a),
            b: exact(&state.pair.b),
        };
        let truth = wide.evaluate(
            &State { pair, velocity: still, acceleration: still },
            &Increment::none(),
            &wide.initial_branch(),
            &Request::new(&[], [true; 6], 1),
            &mut Tally::default(),
        );
        let [row, want] = [
            found.jacobian[4].ok_or("ur2 has a row")?[axis],
            truth.jacobian[4].ok_or("ur2 has a row")?[axis].to_f64(),
        ];
        let of_ours = (row - want).abs();
        // One rounding of the triad turns the row by u/distance.
        assert!(of_ours <= 8.0 * U, "{name}, {distance}: {of_ours}");
        ours.add(distance, of_ours);
        other.add(distance, (by_entry(&turned) - want).abs());
    }
    let swept = "distance to the lock (rad)";
    Ok(Panel { title, swept, unit: "rad/rad", ours: vec![ours], others: vec![other] })
}

/// A lock of successive rotations.
struct Lock {
    name: &'static str,
    title: &'static str,
    /// The first and the second rotation, at a distance.
    rotations: fn(f64) -> [[f64; 3]; 2],
    /// The nodal degree of freedom that turns b about the axis of β, when the first rotation is left out.
    axis: usize,
    other_is: &'static str,
    /// The same derivative by the one entry that β is a function of.
    by_entry: fn(&Matrix<f64>) -> f64,
}

/// sin β = e1a·e3b: near ±1 the arcsine loses what is left.
const CARDAN: Lock = Lock {
    name: "CARDAN",
    title: "∂β/∂θ of a CARDAN towards its lock, α = 0.3",
    rotations: |distance| [[0.3, 0.0, 0.0], [0.0, FRAC_PI_2 - distance, 0.0]],
    axis: 11,
    other_is: "num-dual: asin of the entry (at the top: no number)",
    by_entry: |turned| Dual64::new(turned[0][2], turned[2][2]).asin().eps,
};

/// cos β = e3a·e3b: likewise the arccosine.
const EULER: Lock = Lock {
    name: "EULER",
    title: "∂β/∂θ of an EULER towards its lock, α = 0.3",
    rotations: |distance| [[0.0, 0.0, 0.3], [distance, 0.0, 0.0]],
    axis: 10,
    other_is: "num-dual: acos of the entry (at the top: no number)",
    by_entry: |turned| Dual64::new(turned[2][2], turned[1][2]).acos().eps,
};

/// Large increments of a ROTATION and a HINGE: each is recognised by itself, and beyond 0.9 π it is said not to be certain.
fn increments() -> Result<Panel> {
    const STEPS: u32 = 1000;
    let (rotation, definition) = connector("ROTATION", [0.0; 3])?;
    let (hinge, of_hinge) = connector("HINGE", [0.0; 3])?;
    let [mut of_rotation, mut counted] = ["pintle, ROTATION", "pintle, HINGE"].map(Curve::new);
    let mut summed = Curve::new(SUM);
    for fraction in (1..=99).step_by(2).map(|percent| f64::from(percent) / 100.0) {
        let [mut branch, mut hinged] = [rotation.initial_branch(), hinge.initial_branch()];
        let [mut worst, mut worst_counted, mut worst_sum] = [0.0_f64; 3];
        let (mut before, mut sum) = (Rotation3::identity(), 0.0);
        let mut turned_before = 0.0;
        for step in 1..=STEPS {
            let (turns, rest) = principal(Wide::from_f64(fraction * PI) * Wide::from_f64(f64::from(step)));
            let state = at(&definition, about_x(rest), [0.0; 3]);
            let want = total(turns, rest);
            let increment = Increment {
                rotation: [[0.0; 3], [want.to_f64() - turned_before, 0.0, 0.0]],
                ..Increment::none()
            };
            turned_before = want.to_f64();
            let request = Request::new(&[Output::CU], [true; 6], 0);
            let result = rotation.evaluate(&state, &increment, &branch, &request, &mut Tally::default());
            let flags = rotation.flags(&[None; 6], &increment, &state, &branch, &result.branch);
            let is_told = flags.iter().any(|flag| matches!(flag, Flag::LargeIncrement { .. }));
            // Near whole turns, to 0.1 rad, increments are measured from these.
            assert!(
                is_told == (fraction > 0.9) || (fraction - 0.9).abs() * PI < 0.1,
                "{fraction}: {flags:?}"
            );
            branch = result.branch;
            let got = result.displacement[3].ok_or("a ROTATION has ur1")?;
            worst = worst.max(error(got, want));
            let turned = evaluate(&hinge, &at(&of_hinge, state.pair.b.triad, [0.0; 3]), &hinged, 0);
            hinged = turned.branch;
            worst_counted = worst_counted.max(error(turned.displacement[3].ok_or("a HINGE has ur1")?, want));
            let now = of_nalgebra(&state.pair.b.triad);
            sum += (now * before.inverse()).scaled_axis().x;
            before = now;
            worst_sum = worst_sum.max(error(sum, want));
        }
        // The gate of the continued log, 4 u of the whole angle. Beyond 0.97 π turns can be lost near whole turns, where the
        // sheet is that of the state before: as has been told.
        let bound = 4.0 * U * f64::from(STEPS) * PI * fraction;
        assert!(worst <= bound || fraction > 0.97, "{fraction}: {worst}");
        assert!(worst_counted <= bound, "{fraction}: {worst_counted}");
        of_rotation.add(fraction, worst);
        counted.add(fraction, worst_counted);
        summed.add(fraction, worst_sum);
    }
    let title = "a thousand increments of a part of half a turn";
    let swept = "increment / π; beyond 0.9 it is flagged";
    Ok(Panel { title, swept, unit: "rad", ours: vec![of_rotation, counted], others: vec![summed] })
}

/// The common logarithm at which no error is drawn.
const EXACT: f64 = -18.0;

/// Beyond this, errors are not told apart, and what is no number is drawn here.
const HOPELESS: f64 = 3.0;

fn logarithm(error: f64) -> f64 {
    if error.is_nan() { HOPELESS } else { error.log10().clamp(EXACT, HOPELESS) }
}

/// 10 to a whole power; nothing for what is none.
fn power_of_ten(exponent: f64) -> String {
    if exponent.fract() != 0.0 {
        return String::new();
    }
    let digit = |c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4'..='9' | '0' => char::from_u32(0x2070 + c as u32 - '0' as u32).unwrap_or(c),
        other => other,
    };
    format!("10{}", format!("{exponent:.0}").chars().map(digit).collect::<String>())
}

const OF_OURS: [RGBColor; 2] = [RGBColor(0, 70, 200), RGBColor(0, 150, 130)];
const OF_OTHERS: RGBColor = RGBColor(205, 40, 40);

fn draw(panels: &[Panel], path: &str) -> Result<()> {
    let area = SVGBackend::new(path, (1240, 380 * panels.len().div_ceil(2) as u32)).into_drawing_area();
    area.fill(&WHITE)?;
    for (panel, area) in panels.iter().zip(area.split_evenly((panels.len().div_ceil(2), 2))) {
        let curves = || panel.ours.iter().chain(&panel.others);
        let swept = || curves().flat_map(|curve| &curve.points).map(|(x, _)| *x);
        let [low, high] = [swept().fold(f64::INFINITY, f64::min), swept().fold(0.0, f64::max)];
        // A part of one is swept evenly.
        let is_even = low > 1e-3 && high < 1.0 && panel.ours.len() > 1;
        let across = |x: f64| if is_even { x } else { x.log10() };
        let top = curves().fold(EXACT, |top, curve| top.max(logarithm(curve.worst()))).ceil();
        let mut builder = ChartBuilder::on(&area);
        builder
            .caption(panel.title, ("sans-serif", 17))
            .margin(14)
            .x_label_area_size(44)
            .y_label_area_size(70);
        // The legend is on the other side of the largest error, and there is room for it above the curves.
        let points = || curves().flat_map(|curve| &curve.points).map(|(x, y)| (across(*x), logarithm(*y)));
        let largest =
            points().fold((0.0, EXACT), |worst, point| if point.1 > worst.1 { point } else { worst });
        let room = 0.2 * (top - EXACT);
        let from = if is_even { 0.0 } else { across(low) };
        let to = if is_even { 1.0 } else { across(high) };
        let mut chart = builder.build_cartesian_2d(from..to, EXACT..top + room)?;
        chart
            .configure_mesh()
            .x_desc(panel.swept)
            .y_desc(format!("absolute error ({})", panel.unit))
            .axis_desc_style(("sans-serif", 14))
            .label_style(("sans-serif", 13))
            .x_labels(11)
            .y_labels(12)
            .x_label_formatter(&|x| if is_even { format!("{x:.1}") } else { power_of_ten(*x) })
            .y_label_formatter(&|y| if *y == EXACT { "0".to_string() } else { power_of_ten(*y) })
            .light_line_style(WHITE)
            .bold_line_style(RGBColor(225, 225, 225))
            .draw()?;
        let colours =
            panel.ours.iter().zip(OF_OURS).chain(panel.others.iter().map(|other| (other, OF_OTHERS)));
        for (Curve { of, points }, colour) in colours {
            let points: Vec<_> = points.iter().map(|(x, y)| (across(*x), logarithm(*y))).collect();
            chart
                .draw_series(LineSeries::new(points, colour.stroke_width(2)))?
                .label(*of)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2)));
        }
        chart
            .configure_series_labels()
            .position(if largest.0 < 0.5 * (from + to) {
                SeriesLabelPosition::UpperRight
            } else {
                SeriesLabelPosition::UpperLeft
            })
            .label_font(("sans-serif", 13))
            .background_style(WHITE.mix(0.9))
            .border_style(RGBColor(150, 150, 150))
            .draw()?;
    }
    area.present()?;
    Ok(())
}

fn main() -> Result<()> {
    let panels = [increments()?, turns()?, origin()?, drift()?, lock(CARDAN)?, lock(EULER)?];
    for Panel { title, ours, others, unit, .. } in &panels {
        let worst = |curve: &Curve| format!("{} {:.1e} {unit}", curve.of, curve.worst());
        let all: Vec<String> = ours.iter().chain(others).map(worst).collect();
        println!("{title}: worst of {}", all.join("; of "));
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/stress.svg");
    draw(&panels, path)?;
    println!("drawn in {path}");
    Ok(())
}
