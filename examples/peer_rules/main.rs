//! What the default rules of other derivative checkers notice, on the same mutants of the same Jacobians.
//!
//! `rules.rs` has each rule, written from its source: PyTorch's `gradcheck` (slow and fast), Ceres' gradient checker,
//! DifferentiationInterfaceTest and JAX's `check_grads`. All see the same function of the nodal degrees of freedom, displacements as they
//! are and finite rotations exp(δθ^) C from the present triads on, and a Jacobian, right or with one mistake in it.
//!
//! `cargo run --example peer_rules` prints a table in Markdown; `scripts/peer_rules.py` writes it into the docs.

#[path = "../../benches/hand/commit.rs"]
mod commit;
mod rules;
mod subject;

use pintle_audit::judge::verdict::Wanted;
use pintle_audit::mutants::mutant::{Mistake, Scene, mutants};
use pintle_audit::oracles::oracle::Narrow;
use pintle_audit::oracles::truth::Truth;
use pintle_audit::sampling::{Region, draw_case};
use pintle_audit::singular::atlas;
use pintle_audit::{Bound, Case, Entries, Quantity, product};
use pintle_kinematics::draw::Draw;
use rules::{Jacobian, NAMES, Peers, Problem, exceeds};
use std::collections::BTreeMap;
use subject::{Subject, functions};

/// Whether each rule calls the Jacobian wrong.
struct Judges<'a> {
    subject: &'a Subject,
    bound: &'a Bound,
    truth: Entries<Wanted>,
    right: Jacobian,
    peers: Peers,
}

impl<'a> Judges<'a> {
    fn of(case: &Case, subject: &'a Subject, bound: &'a Bound) -> Option<Self> {
        let truth = Truth::of(case)?.first().map(|_, _, x| Wanted::from(x));
        let right = subject.jacobian(|k, j| truth.get(k, j).map(Wanted::to_f64));
        let values = |x: &[f64]| subject.values(x);
        let peers = Peers::of(&Problem { at: subject.parameters(), values: &values });
        Some(Self { subject, bound, truth, right, peers })
    }

    fn wrong(&self, rows: &Entries<f64>) -> [bool; 6] {
        let ours = rows.iter().any(|(k, i, x)| {
            let Some(want) = self.truth.get(k, i) else { return false };
            exceeds(want.error(x), self.bound.tolerance(Quantity::FirstDerivatives, k, i))
        });
        let found = self.subject.jacobian(|k, j| rows.get(k, j));
        let [slow, fast, ceres, interface, jax] = self.peers.wrong(&found, &self.right);
        [ours, slow, fast, ceres, interface, jax]
    }
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
        let (Some(numbers), Some(narrow), Some(step)) = (product(case), Narrow::of(case), case.last()) else {
            continue;
        };
        let rows = numbers.entries(Quantity::FirstDerivatives);
        let Some(subject) = Subject::of(case, rows) else { continue };
        let bound = Bound::new(&numbers, &step.state, case.length, narrow.nearness());
        let Some(judges) = Judges::of(case, &subject, &bound) else { continue };
        let quantity = Quantity::FirstDerivatives;
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
            // A checker has no column for what is no degree of freedom of the connector.
            let seen = mutant.changes.iter().all(|(_, i, x)| *x == 0.0 || subject.columns.contains(i));
            if !beyond || !shown || !seen {
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
    println!("| | pintle | {} | mutants |", NAMES.join(" | "));
    println!("|---|{}", "---|".repeat(NAMES.len() + 2));
    for (mistake, counts) in &found.noticed {
        let total = counts[6];
        let cells: Vec<String> =
            counts[..6].iter().map(|n| format!("{:.1} %", 100.0 * *n as f64 / total as f64)).collect();
        println!("| {mistake} | {} | {total} |", cells.join(" | "));
    }
    let alarms: Vec<String> = found.false_alarms.iter().map(|n| format!("{n} of {}", found.states)).collect();
    println!("| *false alarms* | {} | |", alarms.join(" | "));
}

fn main() {
    if commit::is_told() {
        return;
    }
    rules::tried();
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
