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

/// A picture: what is swept, and the errors of ours and of the other.
struct Panel {
    title: &'static str,
    swept: &'static str,
    ours: Vec<(f64, f64)>,
    other: Vec<(f64, f64)>,
    other_is: &'static str,
}

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
    let mut panel = Panel {
        title: "a million increments of 0.7 rad",
        swept: "increments",
        ours: Vec::new(),
        other: Vec::new(),
        other_is: "nalgebra: sum of scaled_axis of increments",
    };
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
            panel.ours.push((step as f64, of_ours));
            panel.other.push((step as f64, error(sum, want)));
        }
    }
    Ok(panel)
}

/// A billion turns, continued from a saved branch: the angle within its turn keeps all its digits.
fn turns() -> Result<Panel> {
    let (connector, definition) = connector("HINGE", [0.0; 3])?;
    let (first, second) = (2.5, 2.9);
    let mut panel = Panel {
        title: "a tenth of a turn after 10^k turns, from a saved branch",
        swept: "turns",
        ours: Vec::new(),
        other: Vec::new(),
        other_is: "one double for the angle",
    };
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
        panel.ours.push((turns, of_ours));
        let one = |angle: f64| angle + TAU * turns;
        panel.other.push((turns, error(one(second) - one(first), want)));
    }
    Ok(panel)
}

/// Far from the origin: initial positions and displacements are kept apart.
fn origin() -> Result<Panel> {
    let mut panel = Panel {
        title: "displacement of a CARTESIAN, 10^k from the origin",
        swept: "distance / length",
        ours: Vec::new(),
        other: Vec::new(),
        other_is: "nalgebra: current positions",
    };
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
        panel.ours.push((far, of_ours));
        let [a, b] = [Vector3::new(far, 0.0, 0.0), Vector3::new(far + 0.1, 0.2, 0.3)];
        let now = b + Vector3::new(moved, 0.0, 0.0);
        panel.other.push((far, error((now - a).x - (b - a).x, Wide::from_f64(moved))));
    }
    Ok(panel)
}

/// Towards the Cardan lock: ∂ur2 by the turn about the global 2-axis.
fn lock() -> Result<Panel> {
    let (connector, definition) = connector("CARDAN", [0.0; 3])?;
    let wide = Connector::<Wide>::new(&definition);
    let mut panel = Panel {
        title: "∂β/∂θ of a CARDAN, 10^-k from its lock, α = 0.3",
        swept: "distance to the lock (rad)",
        ours: Vec::new(),
        other: Vec::new(),
        other_is: "num-dual: asin of the entry",
    };
    for distance in (4..=44).map(|k| 10_f64.powf(-f64::from(k) / 4.0)) {
        let turned = vector::product(
            &so3::matrix(so3::exp([0.3, 0.0, 0.0])),
            &so3::matrix(so3::exp([0.0, FRAC_PI_2 - distance, 0.0])),
        );
        let state = at(&definition, turned, [0.0; 3]);
        let ours = evaluate(&connector, &state, &connector.initial_branch(), 1);
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
            ours.jacobian[4].ok_or("ur2 has a row")?[11],
            truth.jacobian[4].ok_or("ur2 has a row")?[11].to_f64(),
        ];
        let of_ours = (row - want).abs();
        // One rounding of the triad turns the row by u/distance.
        assert!(of_ours <= 8.0 * U, "{distance}: {of_ours}");
        panel.ours.push((distance, of_ours));
        // The entry e1a·e3b and how it changes as b turns about the global 2-axis.
        let entry = Dual64::new(turned[0][2], turned[2][2]);
        let beta = entry.asin();
        panel.other.push((distance, (beta.eps - want).abs().min(1e3)));
    }
    Ok(panel)
}

/// Large increments of a ROTATION: each is recognised by itself, and beyond 0.9 π it is said not to be certain.
fn increments() -> Result<Panel> {
    const STEPS: u32 = 1000;
    let (connector, definition) = connector("ROTATION", [0.0; 3])?;
    let mut panel = Panel {
        title: "a thousand increments of f π of a ROTATION",
        swept: "f",
        ours: Vec::new(),
        other: Vec::new(),
        other_is: "nalgebra: scaled_axis",
    };
    for fraction in (1..=99).step_by(2).map(|percent| f64::from(percent) / 100.0) {
        let mut branch = connector.initial_branch();
        let (mut worst, mut worst_other) = (0.0_f64, 0.0_f64);
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
            let result = connector.evaluate(&state, &increment, &branch, &request, &mut Tally::default());
            let flags = connector.flags(&[None; 6], &increment, &state, &branch, &result.branch);
            let is_told = flags.iter().any(|flag| matches!(flag, Flag::LargeIncrement { .. }));
            // Near whole turns, to 0.1 rad, increments are measured from these.
            assert!(
                is_told == (fraction > 0.9) || (fraction - 0.9).abs() * PI < 0.1,
                "{fraction}: {flags:?}"
            );
            branch = result.branch;
            let got = result.displacement[3].ok_or("a ROTATION has ur1")?;
            worst = worst.max(error(got, want));
            worst_other = worst_other.max(error(of_nalgebra(&state.pair.b.triad).scaled_axis().x, want));
        }
        // The gate of the continued log, 4 u of the whole angle. Beyond 0.97 π turns can be lost near whole turns, where the
        // sheet is that of the state before: as has been told.
        let bound = 4.0 * U * f64::from(STEPS) * PI * fraction;
        assert!(worst <= bound || fraction > 0.97, "{fraction}: {worst}");
        panel.ours.push((fraction, worst));
        panel.other.push((fraction, worst_other));
    }
    Ok(panel)
}

/// Below this, errors are drawn on the axis.
const FLOOR: f64 = 1e-18;

fn draw(panels: &[Panel], path: &str) -> Result<()> {
    let area = SVGBackend::new(path, (1200, 360 * panels.len().div_ceil(2) as u32)).into_drawing_area();
    area.fill(&WHITE)?;
    for (panel, area) in panels.iter().zip(area.split_evenly((panels.len().div_ceil(2), 2))) {
        let all = || panel.ours.iter().chain(&panel.other);
        let low = all().fold(f64::INFINITY, |low, (x, _)| low.min(*x));
        let high = all().fold(0.0_f64, |high, (x, _)| high.max(*x));
        let top = all().fold(FLOOR, |top, (_, y)| top.max(*y)) * 10.0;
        let mut builder = ChartBuilder::on(&area);
        builder
            .caption(panel.title, ("sans-serif", 18))
            .margin(12)
            .x_label_area_size(36)
            .y_label_area_size(64);
        let mut chart = builder.build_cartesian_2d((low..high).log_scale(), (FLOOR..top).log_scale())?;
        let format = |value: &f64| format!("{value:.0e}");
        chart
            .configure_mesh()
            .x_desc(panel.swept)
            .y_desc("absolute error")
            .x_label_formatter(&|value| {
                if low < 1e-2 || high > 1e2 { format(value) } else { format!("{value:.2}") }
            })
            .y_label_formatter(&format)
            .light_line_style(WHITE)
            .draw()?;
        for (points, colour, label) in [(&panel.other, RED, panel.other_is), (&panel.ours, BLUE, "pintle")] {
            let points: Vec<_> = points.iter().map(|(x, y)| (*x, y.max(FLOOR))).collect();
            chart
                .draw_series(LineSeries::new(points, colour.stroke_width(2)))?
                .label(label)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2)));
        }
        chart.configure_series_labels().background_style(WHITE.mix(0.8)).border_style(BLACK).draw()?;
    }
    area.present()?;
    Ok(())
}

fn main() -> Result<()> {
    let panels = [increments()?, turns()?, origin()?, lock()?, drift()?];
    let worst = |points: &[(f64, f64)]| points.iter().fold(0.0_f64, |worst, (_, error)| worst.max(*error));
    for Panel { title, ours, other, other_is, .. } in &panels {
        println!("{title}: worst {:.1e}; {other_is}: worst {:.1e}", worst(ours), worst(other));
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/stress.svg");
    draw(&panels, path)?;
    println!("drawn in {path}");
    Ok(())
}
