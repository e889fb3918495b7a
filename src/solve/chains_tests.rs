//! Fast chains, in which neighbouring motions part: is their error as large as it is said to be?

use crate::number::Number;
use crate::{ConnectorFrame, Energies, Method, NodeFrame, Options, Solution, estimate, solve};
use pintle_kinematics::scalar::Wide;
use pintle_scene::Scene;
use std::fmt::Write;

/// Numbers that look random (Knuth's MMIX).
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / 16_777_216.0
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn direction(&mut self) -> [f64; 3] {
        loop {
            let v = [0; 3].map(|_| self.within(-1.0, 1.0));
            let size = v.iter().map(|x| x * x).sum::<f64>().sqrt();
            if (0.2..1.0).contains(&size) {
                return v.map(|x| x / size);
            }
        }
    }
}

/// A chain of two to four bars under gravity, in the plane or in space, that sets out at 10 to 40 rad/s.
fn chain(seed: u64) -> String {
    let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 7);
    for _ in 0..8 {
        let _ = random.unit();
    }
    let is_planar = seed.is_multiple_of(3);
    let count = if is_planar { 2 + seed as usize / 3 % 2 } else { 2 + seed as usize / 2 % 3 };
    let fast = [40.0, 25.0, 12.0][count - 2];
    let (mut nodes, mut rest, mut given) =
        (String::from("*NODE\n1, 0., 0., 0.\n"), String::new(), String::new());
    let mut at = [0.0; 3];
    let mut before = 1;
    for i in 0..count {
        let along = match is_planar {
            true => {
                let angle = random.within(0.0, std::f64::consts::TAU);
                [angle.cos(), angle.sin(), 0.0]
            }
            false => random.direction(),
        };
        let length = random.within(0.3, 0.7);
        let place = |part: f64| -> String {
            let all: Vec<String> =
                (0..3).map(|k| format!("{:.4}", at[k] + part * length * along[k])).collect();
            all.join(", ")
        };
        let first = 2 + 3 * i;
        for (n, part) in [0.0, 0.5, 1.0].into_iter().enumerate() {
            let _ = writeln!(nodes, "{}, {}", first + n, place(part));
        }
        let kind = match is_planar {
            true => "HINGE",
            false => ["JOIN", "JOIN", "HINGE", "UJOINT"][(random.unit() * 4.0) as usize],
        };
        let [x, y] = match is_planar {
            true => [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]],
            false => [random.direction(), random.direction()],
        };
        let axes: Vec<String> = x.iter().chain(&y).map(|x| format!("{x:.4}")).collect();
        let orientation = if kind == "JOIN" { String::new() } else { format!("A{i},\n") };
        let _ = write!(
            rest,
            "*ELEMENT, TYPE=CONN3D2, ELSET=E{i}\n{}, {before}, {first}\n*ORIENTATION, NAME=A{i}\n{}\n\
             *CONNECTOR SECTION, ELSET=E{i}\n{kind},\n{orientation}*MPC\nBEAM, {first}, {}\nBEAM, {}, {}\n\
             *ELEMENT, TYPE=MASS, ELSET=M\n{}, {}\n*ELEMENT, TYPE=ROTARYI, ELSET=I{i}\n{}, {}\n\
             *ROTARY INERTIA, ELSET=I{i}\n{:.4}, {:.4}, {:.4}\n",
            101 + i,
            axes.join(", "),
            first + 1,
            first + 2,
            first + 1,
            201 + i,
            first + 1,
            301 + i,
            first + 1,
            random.within(0.04, 0.06),
            random.within(0.05, 0.07),
            random.within(0.06, 0.08),
        );
        for k in 0..3 {
            let turns = if is_planar { k == 2 } else { kind == "JOIN" || i == 0 && k == seed as usize % 3 };
            if turns {
                let _ = writeln!(given, "{}, {}, {:.2}", first + 1, 4 + k, random.within(-fast, fast));
            }
        }
        (0..3).for_each(|k| at[k] += length * along[k]);
        before = first + 2;
    }
    format!(
        "{nodes}{rest}*MASS, ELSET=M\n1.\n*INITIAL CONDITIONS, TYPE=VELOCITY\n{given}*BOUNDARY\n1, 1, 6\n\
         *STEP\n*DYNAMIC\n0.01, 10.\n*DLOAD\nM, GRAV, 9.81, 0., -1., 0.\n*END STEP\n"
    )
}

/// A solution on doubles with the numbers of another one on 237 bits.
fn rounded(like: &Solution<f64>, exact: &Solution<Wide>) -> Solution<f64> {
    let mut found = like.clone();
    for (frame, exact) in found.frames.iter_mut().zip(&exact.frames) {
        let Energies { kinetic, external, dissipated, stored, balance } = exact.energies;
        let [kinetic, external, dissipated, stored, balance] =
            [kinetic, external, dissipated, stored, balance].map(Number::to_f64);
        frame.energies = Energies { kinetic, external, dissipated, stored, balance };
        for (node, exact) in frame.nodes.iter_mut().zip(&exact.nodes) {
            *node = NodeFrame {
                displacement: exact.displacement.map(Number::to_f64),
                rotation: exact.rotation.map(Number::to_f64),
                velocity: exact.velocity.map(Number::to_f64),
                acceleration: exact.acceleration.map(Number::to_f64),
                flow: exact.flow.map(Number::to_f64),
                reaction: exact.reaction.map(Number::to_f64),
                held: exact.held,
            };
        }
        for (of, exact) in frame.connectors.iter_mut().zip(&exact.connectors) {
            *of = ConnectorFrame { total: exact.total.map(Number::to_f64), ..of.clone() };
        }
    }
    found
}

/// No error is larger than it is said to be, of each kind. PINTLE_CHAINS asks for more chains than one, PINTLE_FIRST for later ones, PINTLE_UNTIL for longer times.
#[test]
fn errors_of_fast_chains_are_as_large_as_is_said() {
    let asked = |name: &str| std::env::var(name).ok().and_then(|text| text.parse::<f64>().ok());
    let (count, until) = (asked("PINTLE_CHAINS").unwrap_or(1.0) as u64, asked("PINTLE_UNTIL").unwrap_or(0.6));
    let first = asked("PINTLE_FIRST").unwrap_or(0.0) as u64;
    let (mut grown, mut wrong) = (0, Vec::new());
    for seed in first..first + count {
        let scene = Scene::parse("chain.inp", &chain(seed)).unwrap();
        let options = Options { until: Some(until), times: vec![until / 2.0], ..Options::default() };
        let witness = Options { method: Method::Collocation, ..options.clone() };
        let [one, other] = [&options, &witness].map(|of| solve::<f64>(&scene, of).unwrap());
        let apart = one.difference(&other);
        let said = estimate(&scene, &options, (&one, apart.clone()));
        let exact = solve::<Wide>(&scene, &Options { digits: 16, ..options.clone() }).unwrap();
        let truth = one.difference(&rounded(&one, &exact));
        println!(
            "chain {seed}: {} steps; two methods {:.1e}, said {:.1e}, true {:.1e}, {} runs",
            one.steps,
            apart.largest(),
            said.largest(),
            truth.largest(),
            said.runs
        );
        grown += usize::from(said.runs == 4);
        if truth.largest() > said.largest().max(3e-14) {
            wrong.push((seed, truth, said));
        }
    }
    assert!(wrong.is_empty() && grown > 0, "{grown} of {count} grow; {wrong:?}");
}
