//! What the default rules of other derivative checkers notice, on the same mutants of the same Jacobians.
//!
//! Each rule is written here from its documented defaults, on doubles: PyTorch's `gradcheck` (slow and fast), Ceres'
//! `check_gradients`, DifferentiationInterfaceTest and JAX's `check_grads`. They see the function of the nodal degrees of
//! freedom (finite rotations exp(δθ^) C) and the Jacobian, right or with one mistake in it.
//!
//! `cargo run --release --example peer_rules` prints a table in Markdown; `scripts/peer_rules.py` writes it into the docs.

use pintle::audit::case::{dof_size, moved};
use pintle::audit::mutant::{Mistake, Scene, mutants};
use pintle::audit::oracle::Narrow;

use pintle::audit::sample::{Draw, Region, draw_case};
use pintle::audit::truth::Truth;
use pintle::audit::verdict::Wanted;
use pintle::audit::{Bound, Case, Entries, Quantity, atlas, product};
use pintle::catalog::{ConnectionType, TABLE};
use pintle::connector::{Branch, Components, Connector, Increment, Output, Request, State, Tally};
use pintle::node::DOFS;
use pintle::vector::sub;
use std::collections::BTreeMap;

/// A function with its Jacobian at a point, as a checker sees it.
struct Subject {
    connector: Connector<f64>,
    branch: Branch<f64>,
    state: State<f64>,
}

impl Subject {
    fn of(case: &Case) -> Option<Self> {
        let connector = case.connector();
        let end = case.last()?;
        let branch = connector.advance(&end.state, &end.increment, &case.branch_before(&connector));
        let mut state = end.state;
        state.pair.b.displacement = sub(state.pair.b.displacement, state.pair.a.displacement);
        state.pair.a.displacement = [0.0; 3];
        Some(Self { connector, branch, state })
    }

    fn values(&self, by: &[f64; DOFS]) -> Components<f64> {
        let mut state = self.state;
        state.pair = moved(&state.pair, by);
        let asked = Request::new(&[Output::CU, Output::RES], [true; 6], 0);
        let found =
            self.connector.evaluate(&state, &Increment::none(), &self.branch, &asked, &mut Tally::default());
        std::array::from_fn(|k| found.residual[k].or(found.displacement[k]))
    }

    /// Central differences with a fixed step.
    fn numeric(&self, step: f64) -> Vec<[f64; DOFS]> {
        let mut rows = vec![[f64::NAN; DOFS]; 6];
        for j in 0..DOFS {
            let at = |h: f64| {
                let mut by = [0.0; DOFS];
                by[j] = h;
                self.values(&by)
            };
            let (plus, minus) = (at(step), at(-step));
            for (k, row) in rows.iter_mut().enumerate() {
                if let (Some(plus), Some(minus)) = (plus[k], minus[k]) {
                    row[j] = if self.connector.active()[j] { (plus - minus) / (2.0 * step) } else { 0.0 };
                }
            }
        }
        rows
    }
}

/// Whether an error is beyond what is allowed, or not a number.
fn exceeds(error: f64, allowed: f64) -> bool {
    error > allowed || error.is_nan()
}

const RULES: [&str; 6] = [
    "pintle",
    "gradcheck, slow",
    "gradcheck, fast",
    "Ceres",
    "DifferentiationInterfaceTest",
    "JAX check_grads",
];

/// Whether each rule calls the Jacobian wrong.
struct Judges<'a> {
    subject: &'a Subject,
    truth: Entries<Wanted>,
    bound: &'a Bound,
    slow: Vec<[f64; DOFS]>,
    relative: Vec<[f64; DOFS]>,
    coarse: Vec<[f64; DOFS]>,
    directions: [[f64; DOFS]; 2],
    weights: [f64; 6],
}

impl Judges<'_> {
    fn wrong(&self, rows: &Entries<f64>) -> [bool; 6] {
        let quantity = Quantity::FirstDerivatives;
        let entries: Vec<(usize, usize, f64)> = rows.iter().collect();
        let ours = entries.iter().any(|(k, i, x)| {
            let Some(want) = self.truth.get(*k, *i) else { return false };
            exceeds(want.error(*x), self.bound.tolerance(quantity, *k, *i))
        });
        // torch.autograd.gradcheck: eps 1e-6, |a − n| > atol + rtol |n| with atol 1e-5, rtol 1e-3, entry by entry.
        let slow = entries.iter().any(|(k, i, x)| {
            let n = self.slow[*k][*i];
            exceeds((x - n).abs(), 1e-5 + 1e-3 * n.abs())
        });
        // fast_mode: wᵀ J v for one random v in the inputs and w in the outputs, atol scaled by both.
        let [v, _] = &self.directions;
        let along = |of: &dyn Fn(usize, usize) -> f64| -> f64 {
            (0..6)
                .filter(|k| rows.0[*k].is_some())
                .map(|k| self.weights[k] * (0..DOFS).map(|j| of(k, j) * v[j]).sum::<f64>())
                .sum()
        };
        let analytic = along(&|k, j| rows.get(k, j).unwrap_or(0.0));
        let numeric = along(&|k, j| self.slow[k][j]);
        let sums = v.iter().sum::<f64>().abs() * self.weights.iter().sum::<f64>().abs();
        let fast = exceeds((analytic - numeric).abs(), 1e-5 * sums.max(1.0) + 1e-3 * numeric.abs());
        // ceres::Solver::Options: gradient_check_relative_precision 1e-8, relative step 1e-6.
        let ceres = entries.iter().any(|(k, i, x)| {
            let n = self.relative[*k][*i];
            let most = x.abs().max(n.abs());
            most > f64::EPSILON && exceeds((x - n).abs(), 1e-8 * most)
        });
        // isapprox(J, J_ref; atol = 0, rtol = 1e-3) in the Frobenius norm against forward-mode duals.
        let [mut error, mut size] = [0.0; 2];
        for (k, i, x) in &entries {
            let want = self.truth.get(*k, *i).map_or(0.0, |w| w.to_f64());
            error += (x - want) * (x - want);
            size += (want * want).max(0.0);
        }
        let interface = exceeds(error.sqrt(), 1e-3 * size.sqrt());
        // jax.test_util.check_grads: one random tangent, eps 1/2048, atol = rtol = 1e-5 on doubles.
        let w = &self.directions[1];
        let jax = (0..6).filter(|k| rows.0[*k].is_some()).any(|k| {
            let a: f64 = (0..DOFS).map(|j| rows.get(k, j).unwrap_or(0.0) * w[j]).sum();
            let n: f64 = (0..DOFS).map(|j| self.coarse[k][j] * w[j]).sum();
            exceeds((a - n).abs(), 1e-5 + 1e-5 * n.abs())
        });
        [ours, slow, fast, ceres, interface, jax]
    }
}

fn judges<'a>(case: &Case, subject: &'a Subject, bound: &'a Bound, draw: &mut Draw) -> Option<Judges<'a>> {
    let truth = Truth::of(case)?;
    let numbers = truth.first().map(|_, _, x| Wanted::from(x));
    let mut unit = || {
        let mut v: [f64; DOFS] = std::array::from_fn(|_| draw.between(-1.0, 1.0));
        let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        v = v.map(|x| x / norm);
        v
    };
    let directions = [unit(), unit()];
    let weights = std::array::from_fn(|_| draw.between(0.0, 1.0));
    let scale = dof_size(0, case.length).max(1e-12);
    Some(Judges {
        slow: subject.numeric(1e-6),
        relative: subject.numeric(1e-6 * scale),
        coarse: subject.numeric(1.0 / 2048.0),
        truth: numbers,
        subject,
        bound,
        directions,
        weights,
    })
}

/// Mutants noticed and tried, by mistake, and false alarms, of one set of states.
#[derive(Default)]
struct Tallies {
    noticed: BTreeMap<String, [u64; 7]>,
    false_alarms: [u64; 6],
    states: u64,
}

fn run(cases: &[Case]) -> Tallies {
    let mut found = Tallies::default();
    for case in cases {
        let draw = &mut Draw::new(&case.name);
        let (Some(numbers), Some(subject), Some(narrow), Some(step)) =
            (product(case), Subject::of(case), Narrow::of(case), case.last())
        else {
            continue;
        };
        let bound = Bound::new(
            &numbers,
            &step.state.velocity,
            &step.state.acceleration,
            case.length,
            narrow.nearness(),
        );
        let Some(judges) = judges(case, &subject, &bound, draw) else { continue };
        let quantity = Quantity::FirstDerivatives;
        let rows = numbers.entries(quantity);
        found.states += 1;
        for (count, wrong) in found.false_alarms.iter_mut().zip(judges.wrong(rows)) {
            *count += u64::from(wrong);
        }
        let scale = |k: usize, i: usize| bound.scale(quantity, k, i);
        let units = std::array::from_fn(|k| judges.subject.connector.differentiated(k).map(|m| m.unit()));
        let scene = Scene { numbers: &numbers, case, units, turns: [0.0; 6], scale: &scale };
        for mutant in mutants(quantity, &scene) {
            let beyond = mutant.changes.iter().any(|(k, i, x)| {
                let was = rows.get(*k, *i).unwrap_or(0.0);
                (x - was).abs() > 2.0 * bound.tolerance(quantity, *k, *i)
            });
            let shown = match mutant.mistake {
                Mistake::Scaled(delta) => [1e-2, 1e-4, 1e-6, 1e-9].contains(&delta),
                _ => true,
            };
            if !beyond || !shown {
                continue;
            }
            let tally = found.noticed.entry(mutant.mistake.name()).or_default();
            tally[6] += 1;
            for (count, wrong) in tally.iter_mut().zip(judges.wrong(&mutant.applied(rows))) {
                *count += u64::from(wrong);
            }
        }
    }
    found
}

fn print(title: &str, found: &Tallies) {
    println!("\n**{title}** ({} states)\n", found.states);
    println!("| | {} | mutants |", RULES.join(" | "));
    println!("|---|{}", "---|".repeat(RULES.len() + 1));
    for (mistake, counts) in &found.noticed {
        let total = counts[6];
        let cells: Vec<String> =
            counts[..6].iter().map(|n| format!("{:.1} %", 100.0 * *n as f64 / total as f64)).collect();
        println!("| {mistake} | {} | {total} |", cells.join(" | "));
    }
    let alarms: Vec<String> = found.false_alarms.iter().map(|n| format!("{n} of {}", found.states)).collect();
    println!("| *false alarms* | {} | |", alarms.join(" | "));
}

/// Types whose components are functions: a one-form, whose row is given, has no values to be differenced.
fn functions() -> impl Iterator<Item = &'static ConnectionType> {
    TABLE.iter().filter(|connection| {
        let mut positions = connection.slots.iter().filter_map(|slot| slot.position());
        !positions.any(|measure| measure.is_one_form())
    })
}

fn main() {
    let draw = &mut Draw::new("peer rules");
    let mut of = |region: Region| -> Vec<Case> {
        functions()
            .flat_map(|connection| {
                (0..3).filter_map(|_| draw_case(connection, region, draw)).collect::<Vec<_>>()
            })
            .collect()
    };
    print("Both nodes turned and moved, lengths of 1", &run(&of(Region::Aligned)));
    print("The same in millimetres (lengths of 1000)", &run(&of(Region::Long(1e3))));
    let draw = &mut Draw::new("peer rules, near");
    let near: Vec<Case> = functions()
        .flat_map(|c| (0..3).filter_map(|_| atlas::random_near(c, draw)).collect::<Vec<_>>())
        .collect();
    print("1e-1 to 1e-12 from a singular set", &run(&near));
}
