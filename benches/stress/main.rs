//! How errors grow under stress, beside nalgebra and num-dual used as they come: `cargo bench --bench stress`.
//!
//! The picture is drawn into the folder of what is built, and where to is told; `-- --picture docs/explanation/stress.svg` draws that of the documents, as
//! `scripts/measure.py stress` does. Every error is against 237 bits. Ours are asserted to stay where they are promised to be, so that this is a
//! test that draws; the others are what anyone would write first.

#[path = "../hand/commit.rs"]
mod commit;
mod peer;
mod picture;
#[path = "../hand/picture_file.rs"]
mod picture_file;
mod walk;

use picture::{Curve, Panel, draw};
use pintle_audit::case::exact_branch;
use pintle_bench::{Environment, worse};
use pintle_kinematics::connector::Flag;
use pintle_kinematics::draw::Draw;
use pintle_kinematics::node::DOFS;
use pintle_kinematics::scalar::{Real, Wide};
use pintle_kinematics::so3;
use pintle_kinematics::vector;
use pintle_kinematics::vector::Vector;
use pintle_model::evaluate::Sequence;
use rayon::prelude::*;
use std::error::Error;
use std::f64::consts::{FRAC_PI_2, PI};
use walk::{Motion, Rotations, Sample, Stressed, Winding, half_spacing, turned};

/// u, the unit of rounding.
const U: f64 = 1.0 / 9_007_199_254_740_992.0;

type Result<T> = std::result::Result<T, Box<dyn Error + Send + Sync>>;

/// What nalgebra gives to those who add up.
const SUMS: [&str; 2] = ["nalgebra: sum of scaled_axis, HINGE", "nalgebra: sum of scaled_axis, ROTATION"];
const OURS: [&str; 2] = ["pintle, HINGE", "pintle, ROTATION"];
const WINDING: [Winding; 2] = [Winding::Hinge, Winding::Rotation];
const LIMIT: &str = "half the spacing of doubles";

/// The axis of a HINGE is e1, that of a ROTATION may be any.
fn axis(winding: Winding, draw: &mut Draw) -> Vector<f64> {
    if winding == Winding::Hinge { [1.0, 0.0, 0.0] } else { draw.direction() }
}

/// Walks side by side: the samples of each, in their order.
fn walk_all(motions: &[Motion], is_looked_at: impl Fn(u64) -> bool + Sync) -> Result<Vec<Vec<Sample>>> {
    motions.par_iter().map(|motion| motion.walk(&is_looked_at)).collect()
}

/// What is asserted of every sample.
fn judge(motion: &Motion, found: &Sample) {
    let Sample { step, ours, bound, .. } = found;
    assert!(ours <= bound, "{}, step {step}: {ours:e} > {bound:e}", motion.seed);
}

/// Large increments: each is recognised by itself, and beyond 0.9 π it is said not to be certain.
fn increments() -> Result<Panel> {
    let draw = &mut Draw::new("increments");
    let (mut ours, mut others) = (OURS.map(Curve::new), SUMS.map(Curve::new));
    let mut motions = Vec::new();
    for fraction in (1..=99).step_by(2).map(|percent| f64::from(percent) / 100.0) {
        motions.extend(WINDING.map(|winding| Motion {
            seed: format!("{fraction} π, {winding:?}"),
            winding,
            axis: axis(winding, draw),
            step: fraction * PI,
            carried: 0.3,
            steps: 1000,
            turns: 0.0,
        }));
    }
    for (motion, samples) in motions.iter().zip(walk_all(&motions, |_| true)?) {
        let (fraction, at) = (motion.step / PI, motion.winding as usize);
        let told = samples.last().ok_or("there are increments")?.told;
        assert_eq!(told, fraction > 0.9, "{}", motion.seed);
        // Beyond, a ROTATION can lose turns near whole ones, where the sheet is that of the state before: as has been told.
        for found in samples.iter().filter(|_| !told || motion.winding == Winding::Hinge) {
            judge(motion, found);
        }
        let worst = |of: fn(&Sample) -> f64| samples.iter().map(of).fold(0.0, worse);
        ours[at].add(fraction, worst(|found| found.ours));
        others[at].add(fraction, worst(|found| found.summed));
    }
    Ok(Panel {
        title: "a thousand increments of a part of half a turn, nodes turning about any axis",
        swept: "increment / π; beyond 0.9 it is flagged",
        unit: "rad",
        ours: ours.into(),
        others: others.into(),
        limit: None,
    })
}

/// The reported angle after up to a billion turns, continued from saved branches by a thousand increments.
fn turns() -> Result<Panel> {
    const STEPS: u64 = 1000;
    let draw = &mut Draw::new("turns");
    let (mut ours, mut others) = (OURS.map(Curve::new), SUMS.map(Curve::new));
    let mut limit = Curve::new(LIMIT);
    let mut motions = Vec::new();
    for turns in (0..=36).map(|k| 10_f64.powf(f64::from(k) / 4.0).round()) {
        motions.extend(WINDING.map(|winding| Motion {
            seed: format!("{turns} turns, {winding:?}"),
            winding,
            axis: axis(winding, draw),
            step: 0.4,
            carried: 0.3,
            steps: STEPS,
            turns,
        }));
    }
    for (motion, samples) in motions.iter().zip(walk_all(&motions, |step| step == STEPS)?) {
        for found in samples {
            judge(motion, &found);
            ours[motion.winding as usize].add(motion.turns, found.ours);
            others[motion.winding as usize].add(motion.turns, found.summed);
            if motion.winding == Winding::Hinge {
                limit.add(motion.turns, half_spacing(found.angle));
            }
        }
    }
    Ok(Panel {
        title: "CU after many turns: saved branches, then a thousand increments of 0.4 rad",
        swept: "turns before",
        unit: "rad",
        ours: ours.into(),
        others: others.into(),
        limit: Some(limit),
    })
}

/// A million increments, composed as a solver does.
fn drift() -> Result<Panel> {
    const STEPS: u64 = 1_000_000;
    let draw = &mut Draw::new("drift");
    let mut looked_at = vec![1];
    while let Some(last) = looked_at.last().copied().filter(|last| *last < STEPS) {
        looked_at.push((last * 5).div_ceil(3).min(STEPS));
    }
    let (mut ours, mut others) = (OURS.map(Curve::new), SUMS.map(Curve::new));
    let mut limit = Curve::new(LIMIT);
    let motions = WINDING.map(|winding| Motion {
        seed: format!("drift of {winding:?}"),
        winding,
        axis: axis(winding, draw),
        step: 0.7,
        carried: 1.0,
        steps: STEPS,
        turns: 0.0,
    });
    for (motion, samples) in motions.iter().zip(walk_all(&motions, |step| looked_at.contains(&step))?) {
        for found in samples {
            assert!(!found.told, "0.7 rad are no large increment");
            judge(motion, &found);
            ours[motion.winding as usize].add(found.step as f64, found.ours);
            others[motion.winding as usize].add(found.step as f64, found.summed);
            if motion.winding == Winding::Hinge {
                limit.add(found.step as f64, half_spacing(found.angle));
            }
        }
    }
    Ok(Panel {
        title: "a million increments of 0.7 rad, both nodes turning about any axis",
        swept: "increments",
        unit: "rad",
        ours: ours.into(),
        others: others.into(),
        limit: Some(limit),
    })
}

/// Far from the origin: by the coordinates of the nodes, or by how far both have moved, read from a deck and a file of states.
fn origin() -> Result<Panel> {
    let draw = &mut Draw::new("origin");
    let mut ours = ["pintle, CU", "pintle, ∂CU"].map(Curve::new);
    let mut others = ["nalgebra, current positions: CU", "num-dual, current positions: ∂CU"].map(Curve::new);
    for far in (0..=36).map(|k| 10_f64.powf(f64::from(k) / 4.0)) {
        let mut worst = [0.0_f64; 4];
        for parts in [[1.0, 0.0], [0.0, 1.0]] {
            let away = vector::scale(draw.direction(), far);
            let mut near = |part| vector::add(vector::scale(away, part), draw.vector(1.0));
            let [initial, displacements] = parts.map(|part| [near(part), near(part)]);
            // CARTESIAN gives node b no rotation.
            let rotations = [so3::exp_quaternion(draw.rotation(0.1, 3.0)), [1.0, 0.0, 0.0, 0.0]];
            for (worst, error) in worst.iter_mut().zip(far_away(initial, displacements, rotations)?) {
                *worst = worse(*worst, error);
            }
        }
        // Roundings of the separation, of the triad and of the products; lengths are of some units.
        assert!(worst[0] <= 32.0 * U && worst[1] <= 32.0 * U, "{far}: {worst:?}");
        // The same quantity: what is drawn is distance, and no other formula.
        assert!(far > 1.0 || (worst[2] <= 64.0 * U && worst[3] <= 64.0 * U), "{worst:?}");
        for (curve, error) in ours.iter_mut().chain(&mut others).zip(worst) {
            curve.add(far, error);
        }
    }
    Ok(Panel {
        title: "a CARTESIAN that is or has moved far from the origin, read from files",
        swept: "distance from the origin / length",
        unit: "length, length/rad",
        ours: ours.into(),
        others: others.into(),
        limit: None,
    })
}

/// The largest errors of u1 to u3 and of their rows: ours, and those from current positions.
fn far_away(
    initial: [Vector<f64>; 2],
    displacements: [Vector<f64>; 2],
    rotations: Rotations,
) -> Result<[f64; 4]> {
    let joined = |numbers: &[f64]| {
        let numbers: Vec<String> = numbers.iter().map(|x| format!("{x:?}")).collect();
        numbers.join(",")
    };
    let [of_a, of_b] = displacements.map(|displacement| joined(&displacement));
    let csv =
        format!("state,node,u1,u2,u3,q0,q1,q2,q3\n0,1,{of_a},{}\n0,2,{of_b},,,,\n", joined(&rotations[0]));
    let stressed = Stressed::new("CARTESIAN", initial, 1)?;
    let mut sequence = Sequence::new(&stressed.model, &stressed.plan);
    let found = stressed.step(&mut sequence, &stressed.read(&csv)?)?.evaluation;
    let (values, rows) = cartesian(&initial, &displacements, &rotations);
    let current = [0, 1].map(|node| vector::add(initial[node], displacements[node]));
    let (their_values, their_rows) = peer::rows(rotations, current, peer::cartesian(initial));
    let error = |got: f64, want: Wide| (Wide::from_f64(got) - want).abs().to_f64();
    let mut worst = [0.0_f64; 4];
    for k in 0..3 {
        let value = found.displacement[k].ok_or("a CARTESIAN has u1 to u3")?;
        let row = found.jacobian[k].ok_or("they have rows")?;
        worst[0] = worse(worst[0], error(value, values[k]));
        worst[2] = worse(worst[2], error(their_values[k], values[k]));
        for j in 0..DOFS {
            worst[1] = worse(worst[1], error(row[j], rows[k][j]));
            worst[3] = worse(worst[3], error(their_rows[k][j], rows[k][j]));
        }
    }
    Ok(worst)
}

/// u_k = e_k·D − e_k⁰·D⁰ and its rows, on 237 bits: ∂u_k/∂x_b = e_k, ∂u_k/∂θ_a = e_k × D.
fn cartesian(
    initial: &[Vector<f64>; 2],
    displacements: &[Vector<f64>; 2],
    rotations: &Rotations,
) -> (Vector<Wide>, [[Wide; DOFS]; 3]) {
    let across = |of: &[Vector<f64>; 2]| vector::sub(vector::exact(of[1]), vector::exact(of[0]));
    let reference: Vector<Wide> = across(initial);
    let separation = vector::add(reference, across(displacements));
    let axes = vector::transpose(&so3::matrix(so3::normalize(rotations[0].map(Wide::from_f64))));
    let zero = Wide::ZERO;
    let row = |e: &Vector<Wide>| {
        let [x, y, z] = *e;
        let [r, s, t] = vector::cross(*e, separation);
        [-x, -y, -z, r, s, t, zero, x, y, z, zero, zero, zero, zero]
    };
    let value = |k: usize| vector::dot(axes[k], separation) - reference[k];
    ([value(0), value(1), value(2)], axes.each_ref().map(row))
}

/// Towards a lock of successive rotations, where the second angle β makes the axes of the first and third one line.
fn lock(of: &Lock) -> Result<Panel> {
    let draw = &mut Draw::new(of.name);
    let stressed = Stressed::new(of.name, [[0.0; 3]; 2], 1)?;
    let [mut outer, mut middle] = ["pintle, rows of α and γ", "pintle, row of β"].map(Curve::new);
    let [mut their_outer, mut their_middle] = of.others.map(Curve::new);
    for distance in (2..=60).map(|k| 10_f64.powf(-f64::from(k) / 4.0)) {
        let a = so3::exp_quaternion(draw.rotation(0.1, 3.0));
        let [alpha, beta, gamma] = (of.rotations)(distance).map(so3::exp_quaternion);
        let b = so3::compose(a, so3::compose(alpha, so3::compose(beta, gamma)));
        let rotations = [a, b];
        let mut sequence = Sequence::new(&stressed.model, &stressed.plan);
        let result = stressed.step(&mut sequence, &turned(&rotations))?;
        let truth = stressed.truth(&rotations, &exact_branch(&result.before), 1);
        // How near the doubles are, of which the last bits are comparable with the distance.
        let near = (of.distance)(truth.displacement[4].ok_or("ur2 has a value")?).abs().to_f64();
        let is_told = result
            .flags
            .iter()
            .any(|flag| matches!(flag, Flag::IllConditioned { .. } | Flag::Singular { .. }));
        let is_at_the_edge = (near - 1e-8).abs() < 1e-12;
        assert!(is_told == (near < 1e-8) || is_at_the_edge, "{}, {near:e}: {:?}", of.name, result.flags);
        let (_, theirs) = peer::rows(rotations, [[0.0; 3]; 2], of.peer);
        let mut worst = [0.0_f64; 4];
        for k in 0..3 {
            let got = result.evaluation.jacobian[3 + k].ok_or("an angle has a row")?;
            let want = truth.jacobian[3 + k].ok_or("an angle has a row")?;
            let size = want.iter().fold(0.0_f64, |size, x| size.max(x.abs().to_f64()));
            let error = |row: &[f64; DOFS]| {
                let pairs = row.iter().zip(&want);
                let errors = pairs.map(|(got, want)| (Wide::from_f64(*got) - *want).abs().to_f64() / size);
                errors.fold(0.0, worse)
            };
            let at = usize::from(k == 1);
            worst[at] = worse(worst[at], error(&got));
            worst[2 + at] = worse(worst[2 + at], error(&theirs[k]));
        }
        // Of quaternions with roundings, the direction of the locking line is known to u/distance.
        let bound = 8.0 * U * (1.0 + 1.0 / near);
        assert!(worst[0] <= bound && worst[1] <= bound, "{}, {near:e}: {worst:?} > {bound:e}", of.name);
        // The same rows: what is drawn is nearness, and no other convention.
        assert!(distance < 0.1 || (worst[2] <= 1e-13 && worst[3] <= 1e-13), "{}: {worst:?}", of.name);
        for (curve, error) in
            [&mut outer, &mut middle, &mut their_outer, &mut their_middle].into_iter().zip(worst)
        {
            curve.add(near, error);
        }
    }
    for curve in [&mut outer, &mut middle, &mut their_outer, &mut their_middle] {
        curve.points.sort_by(|(x, _), (y, _)| x.total_cmp(y));
    }
    Ok(Panel {
        title: of.title,
        swept: "distance to the lock (rad); below 1e-8 it is flagged",
        unit: "of the row",
        ours: vec![outer, middle],
        others: vec![their_outer, their_middle],
        limit: None,
    })
}

/// A lock of successive rotations.
struct Lock {
    name: &'static str,
    title: &'static str,
    /// The three rotations, at a distance.
    rotations: fn(f64) -> [Vector<f64>; 3],
    /// The distance, from β.
    distance: fn(Wide) -> Wide,
    others: [&'static str; 2],
    peer: fn([peer::Triad; 2], [peer::Position; 2]) -> [peer::Dual; 3],
}

const CARDAN: Lock = Lock {
    name: "CARDAN",
    title: "rows of a CARDAN towards its lock, β = π/2",
    rotations: |distance| [[0.3, 0.0, 0.0], [0.0, FRAC_PI_2 - distance, 0.0], [0.0, 0.0, 0.2]],
    distance: |beta| beta - Wide::pi() / Wide::integer(2),
    others: ["nalgebra's euler_angles on num-dual: α and γ", "nalgebra's euler_angles on num-dual: β"],
    peer: peer::cardan,
};

const CARDAN_BACK: Lock = Lock {
    title: "rows of a CARDAN towards its other lock, β = −π/2",
    rotations: |distance| [[0.3, 0.0, 0.0], [0.0, distance - FRAC_PI_2, 0.0], [0.0, 0.0, 0.2]],
    distance: |beta| beta + Wide::pi() / Wide::integer(2),
    ..CARDAN
};

const EULER: Lock = Lock {
    name: "EULER",
    title: "rows of an EULER towards its lock, β = 0",
    rotations: |distance| [[0.0, 0.0, 0.3], [distance, 0.0, 0.0], [0.0, 0.0, 0.2]],
    distance: |beta| beta,
    others: ["num-dual: α and γ by atan2 of entries", "num-dual: β by acos of an entry"],
    peer: peer::euler,
};

const EULER_BACK: Lock = Lock {
    title: "rows of an EULER towards its other lock, β = π",
    rotations: |distance| [[0.0, 0.0, 0.3], [PI - distance, 0.0, 0.0], [0.0, 0.0, 0.2]],
    distance: |beta| beta - Wide::pi(),
    ..EULER
};

fn main() -> Result<()> {
    if commit::is_told() {
        return Ok(());
    }
    let picture = picture_file::picture_file("stress.svg")?;
    // What is done soonest first.
    let [cardan, cardan_back, euler, euler_back] = [&CARDAN, &CARDAN_BACK, &EULER, &EULER_BACK].map(lock);
    let locks = [cardan?, cardan_back?, euler?, euler_back?];
    let origin = origin()?;
    let panels: Vec<Panel> = [increments()?, turns()?, origin, drift()?].into_iter().chain(locks).collect();
    for Panel { title, ours, others, unit, .. } in &panels {
        println!("{title}; largest errors ({unit}):");
        for curve in ours.iter().chain(others) {
            println!("  {:<46} {:.1e}", curve.of, curve.worst());
        }
    }
    let told = format!("errors against 237 bits; {}", Environment::here().short());
    draw(&panels, &told, &picture)?;
    eprintln!("drawn into {}", picture.display());
    Ok(())
}
