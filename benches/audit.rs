//! Throughput of the audit: states per second of each oracle, of the product, and of all checks of a state, on one core.
//!
//! `taskset -c 3 cargo bench --bench audit` prints a table, `python3 scripts/measure.py audit` writes it into docs/explanation/audit.md. Times are
//! the least of rounds that take turns; that each oracle answers, and that all checks pass, is asserted. The command's own time is that
//! of `pintle audit`.
#![expect(clippy::unwrap_used, reason = "a benchmark fails by panicking")]

#[path = "hand/commit.rs"]
mod commit;

use pintle_audit::oracles::oracle::{Narrow, Oracle, remainders};
use pintle_audit::oracles::truth::Truth;
use pintle_audit::sampling::{Region, draw_case};
use pintle_audit::{Bound, Case, Entries, Quantity, Settings, audit_case, product};
use pintle_kinematics::catalog::TABLE;
use pintle_kinematics::draw::Draw;
use std::hint::black_box;
use std::time::Instant;

/// A type with few components, one with many, one of rotations only, one with a one-form.
const TYPES: [&str; 4] = ["AXIAL", "TRANSLATOR", "ROTATION", "RETRACTOR"];

const ROUNDS: usize = 7;
const STATES: usize = 8;

/// A case with what oracles are given.
struct Given {
    case: Case,
    narrow: Narrow,
    truth: Truth,
    rows: Entries<f64>,
    bound: Bound,
}

impl Given {
    fn of(case: Case) -> Option<Self> {
        let numbers = product(&case)?;
        let (narrow, truth, state) = (Narrow::of(&case)?, Truth::of(&case)?, case.last()?.state);
        let bound = Bound::new(&numbers, &state, case.length, narrow.nearness());
        Some(Self { narrow, truth, rows: numbers.entries(Quantity::FirstDerivatives).clone(), bound, case })
    }

    /// How many numbers an oracle gives.
    fn ask(&self, oracle: Oracle) -> usize {
        let Self { case, narrow, rows, bound, .. } = self;
        let v = Draw::new("direction").rates(case.length);
        let derivatives = [Quantity::FirstDerivatives, Quantity::SecondDerivatives];
        match oracle {
            Oracle::WideDifferences => {
                // Afresh, for the places that are differenced are kept.
                let truth = Truth::of(case).unwrap();
                let [rate, acceleration] = truth.rates();
                let [second, changes] = truth.second(true);
                let forces = [truth.force_rows(), changes];
                let of_state = [truth.value(), truth.first(), second, rate, acceleration];
                of_state.iter().chain(&forces).map(Entries::len).sum()
            }
            Oracle::WideSymbolic => {
                let found = self.truth.symbolic();
                sum(derivatives.map(|q| found.entries(q).len()))
            }
            Oracle::WideDual => {
                let found = self.truth.dual();
                sum(Quantity::ALL.map(|q| found.entries(q).len()))
            }
            Oracle::Taylor => remainders(&self.truth, rows, bound, &v, &[1.0; 6]).len(),
            Oracle::NodalDual => narrow.nodal_dual(bound).numbers.len(),
            Oracle::HyperDual => narrow.hyper_dual(&v, &v).iter().flatten().count(),
            Oracle::NestedDual => {
                let found = narrow.nested_dual();
                sum(derivatives.map(|q| found.entries(q).len()))
            }
            Oracle::Symbolic => {
                let found = narrow.symbolic();
                sum(derivatives.map(|q| found.entries(q).len()))
            }
            Oracle::Differences => narrow.differences(bound).numbers.len(),
            Oracle::Jax => 0,
        }
    }
}

fn sum<const N: usize>(counts: [usize; N]) -> usize {
    counts.iter().sum()
}

/// What is timed, and on the states of which type.
struct Row<'a> {
    name: &'static str,
    run: Box<dyn Fn(&Given) -> usize + 'a>,
    /// Seconds per state, by type.
    least: [f64; TYPES.len()],
}

fn main() {
    if commit::is_told() {
        return;
    }
    let given = TYPES.map(|name| {
        let connection = TABLE.iter().find(|entry| entry.name == name).unwrap();
        let draw = &mut Draw::new("bench");
        let cases = (0..STATES).filter_map(|_| draw_case(connection, Region::Aligned, draw));
        cases.filter_map(Given::of).collect::<Vec<_>>()
    });
    assert!(given.iter().all(|states| states.len() == STATES));
    let settings = Settings::default();
    let checks = |wide: bool, index: usize| {
        let settings = &settings;
        move |given: &Given| {
            let checks = audit_case(&given.case, settings, wide, index);
            assert!(checks.iter().all(|check| !check.verdict.is_mismatch() && check.score.survived == 0));
            checks.iter().map(|check| check.compared as usize).sum::<usize>()
        }
    };
    let row = |name, run| Row { name, run, least: [f64::INFINITY; TYPES.len()] };
    let mut rows = vec![row("product", Box::new(|given: &Given| product(&given.case).map_or(0, |_| 1)))];
    rows.extend(
        // JAX answered at its own states, long before.
        Oracle::ALL
            .into_iter()
            .filter(|oracle| *oracle != Oracle::Jax)
            .map(|oracle| row(oracle.name(), Box::new(move |given: &Given| given.ask(oracle)))),
    );
    // The index decides whether laws and mutants are tried: not with 1.
    rows.push(row("all on doubles", Box::new(checks(false, 1))));
    rows.push(row("… with laws and mutants", Box::new(checks(false, 0))));
    rows.push(row("all, on 237 bits too", Box::new(checks(true, 0))));
    for _ in 0..ROUNDS {
        for row in &mut rows {
            for (states, least) in given.iter().zip(&mut row.least) {
                let start = Instant::now();
                for given in states {
                    assert!(black_box((row.run)(given)) > 0, "{} gives nothing", row.name);
                }
                *least = least.min(start.elapsed().as_secs_f64() / states.len() as f64);
            }
        }
    }
    println!("{:24}{}", "states per second", TYPES.map(|name| format!("{name:>12}")).concat());
    for row in &rows {
        let rates = row.least.map(|seconds| {
            let digits = 10.0_f64.powf((1.0 / seconds).log10().floor() - 1.0);
            format!("{:>12.0}", (1.0 / seconds / digits).round() * digits)
        });
        println!("{:24}{}", row.name, rates.concat());
    }
}
