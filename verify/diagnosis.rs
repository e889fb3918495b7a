//! Why a matrix is wrong: every mistake of the catalogue is named as what it is, conventions too, and noise is not named at all.

pub(crate) mod candidates;
pub(crate) mod constraints;
pub(crate) mod corpus;
pub(crate) mod frictions;
pub(crate) mod offers;
mod tables;

use crate::audit::{judged, named, spoiled};
use pintle_audit::mutants::diagnosis::{Cause, Diagnosis, Symptoms, diagnose};
use pintle_audit::mutants::mutant::{Mistake, Scene, mutants};
use pintle_audit::sampling::{Region, draw_case, extent};
use pintle_audit::{Bound, Case, Entries, Numbers, Quantity};
use pintle_kinematics::catalog::{ConnectionType, TABLE};
use pintle_kinematics::connector::NodalRow;
use pintle_kinematics::draw::Draw;
use pintle_kinematics::measure::Unit;
use pintle_kinematics::node::DOFS;
use pintle_kinematics::vector::{apply_transposed, cross};
use pintle_scene::Code;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// A state at which both nodes are turned and moved, with its numbers and tolerances.
fn drawn(connection: &ConnectionType, region: Region) -> (Case, Numbers<f64>, Bound) {
    let case = draw_case(connection, region, &mut Draw::new(&connection.name)).unwrap();
    let (numbers, bound, _) = judged(&case);
    (case, numbers, bound)
}

fn said(diagnosis: &Diagnosis) -> String {
    let lines = diagnosis.lines().into_iter().map(|(sentence, code)| format!("{sentence} [{code}]"));
    lines.collect::<Vec<_>>().join("\n")
}

/// Every mutant of every quantity of a type in a region is diagnosed as what it is, or as what makes the same numbers: how many of each mistake.
fn each_is_diagnosed(connection: &ConnectionType, region: Region) -> BTreeMap<String, usize> {
    let mut tried = BTreeMap::new();
    let (case, want, bound) = drawn(connection, region);
    let connector = case.connector();
    let units: [Option<Unit>; 6] =
        std::array::from_fn(|k| connector.differentiated(k).map(|measure| measure.unit()));
    let step = case.last().unwrap();
    let branch = connector.advance(&step.state, &step.increment, &case.branch_before(&connector));
    let turns = branch.turns.map(|turns| turns.turns);
    for quantity in Quantity::ALL {
        let scale = |k: usize, i: usize| bound.scale(quantity, k, i);
        let scene = Scene { numbers: &want, case: &case, units, turns, scale: &scale };
        for (n, mutant) in mutants(quantity, &scene).into_iter().enumerate() {
            let single = mutant.changes.len() == 1;
            let skipped = match mutant.mistake {
                Mistake::Scaled(delta) => delta != 1e-1 && delta != 1e-6,
                _ => false,
            };
            // Of the 196 entries of a matrix of second derivatives, some.
            if skipped || (single && quantity.entries() > DOFS && n % 101 != 0) {
                continue;
            }
            let units = |(k, i, x): &(usize, usize, f64)| {
                (x - want.entries(quantity).get(*k, *i).unwrap()).abs() / bound.tolerance(quantity, *k, *i)
            };
            // What changes less than that cannot be told from chance.
            let largest = mutant.changes.iter().map(units).fold(0.0, f64::max);
            if largest < 1e6 {
                continue;
            }
            let got = mutant.applied(want.entries(quantity));
            let rows = want.entries(Quantity::FirstDerivatives);
            let symptoms = Symptoms { quantity, got: &got, rows, want: &want, case: &case, bound: &bound };
            let found = diagnose(&symptoms);
            let name = mutant.mistake.name();
            let found = found.unwrap_or_else(|| panic!("{}: {name}: nothing wrong", case.name));
            let cause = Cause::of(mutant.mistake);
            let what = format!("{} {}, {name}:\n{}", case.name, quantity.name(), said(&found));
            assert_eq!((found.causes.len(), found.unexplained), (1, 0), "{what}");
            let codes: Vec<Code> =
                found.causes.iter().flat_map(|one| one.also.iter().copied().chain([one.code])).collect();
            assert!(codes.contains(&cause.code()), "{what}");
            *tried.entry(name).or_default() += 1;
        }
    }
    tried
}

#[test]
fn every_mutant_is_diagnosed_as_itself() {
    let regions = [Region::Misaligned, Region::ManyTurns(7.0)];
    let of = |connection: &'static ConnectionType| {
        let possible = Region::of(connection, extent(connection));
        let regions = regions.into_iter().filter(|region| possible.contains(region));
        regions.map(|region| (connection, region)).collect::<Vec<_>>()
    };
    let found: Vec<_> =
        TABLE.par_iter().flat_map_iter(of).map(|(of, region)| each_is_diagnosed(of, region)).collect();
    let mut tried = BTreeMap::<String, usize>::new();
    for (name, count) in found.into_iter().flatten() {
        *tried.entry(name).or_default() += count;
    }
    // All mistakes were made, each in many places.
    for (name, count) in &tried {
        assert!(*count >= 10, "{name}: {count}");
    }
    assert!(tried.len() >= 18, "{tried:?}");
}

/// First derivatives of a type, changed; the lines of the diagnosis.
fn of_changed(name: &str, change: impl Fn(&Case, &mut Entries<f64>)) -> String {
    let (case, want, bound) = drawn(named(name), Region::Misaligned);
    let mut got = want.entries(Quantity::FirstDerivatives).clone();
    change(&case, &mut got);
    let quantity = Quantity::FirstDerivatives;
    let symptoms = Symptoms { quantity, got: &got, rows: &got, want: &want, case: &case, bound: &bound };
    diagnose(&symptoms).map_or_else(|| "nothing wrong".into(), |found| said(&found))
}

fn each_row(entries: &mut Entries<f64>, mut change: impl FnMut(&mut [f64])) {
    entries.0.iter_mut().flatten().for_each(|row| change(row));
}

fn local(row: &mut [f64], at: usize, triad: &[[f64; 3]; 3]) {
    let block = apply_transposed(triad, [row[at], row[at + 1], row[at + 2]]);
    row[at..at + 3].copy_from_slice(&block);
}

/// A convention changed throughout the matrix is one sentence.
#[test]
fn conventions_are_named_in_one_sentence() {
    let both = of_changed("CARDAN", |case, entries| {
        let pair = case.last().unwrap().state.pair;
        each_row(entries, |row| {
            local(row, 3, &pair.a.triad);
            local(row, 10, &pair.b.triad);
        });
    });
    assert_eq!(
        both,
        "∂ur1/∂θa1..3 and ∂θb1..3, ∂ur2/∂θa1..3 and ∂θb1..3, ∂ur3/∂θa1..3 and ∂θb1..3 equal Aᵀ and Bᵀ × expected: \
         rotation degrees of freedom taken as local [diagnosis::rotation-as-local]"
    );
    let one = of_changed("REVOLUTE", |case, entries| {
        let triad = case.last().unwrap().state.pair.a.triad;
        local(entries.0[3].as_mut().unwrap(), 3, &triad);
    });
    assert_eq!(
        one,
        "∂ur1/∂θa1..3 equals Aᵀ × expected: rotation degrees of freedom taken as local \
         [diagnosis::rotation-as-local]"
    );
    let lever = of_changed("CARTESIAN", |case, entries| {
        let d = case.last().unwrap().state.pair.separation();
        each_row(entries, |row| {
            let lever = cross([row[7], row[8], row[9]], d);
            (0..3).for_each(|i| row[3 + i] -= 2.0 * lever[i]);
        });
    });
    assert!(lever.ends_with("[diagnosis::geometric-term-reversed]"), "{lever}");
    let reversed =
        of_changed("AXIAL", |_, entries| each_row(entries, |row| row.iter_mut().for_each(|x| *x = -*x)));
    assert!(reversed.contains("[diagnosis::") && reversed.contains("diagnosis::sign"), "{reversed}");
}

/// Two mistakes are two sentences.
#[test]
fn two_mistakes_are_told_apart() {
    let two = of_changed("CARTESIAN", |case, entries| {
        let triad = case.last().unwrap().state.pair.a.triad;
        local(entries.0[0].as_mut().unwrap(), 3, &triad);
        entries.0[1].as_mut().unwrap().iter_mut().for_each(|x| *x = -*x);
    });
    let lines: Vec<&str> = two.lines().collect();
    assert_eq!(lines.len(), 2, "{two}");
    assert!(two.contains("rotation-as-local") && two.contains("diagnosis::"), "{two}");
}

/// A mistake is named although digits are lost besides, as by differences on doubles.
#[test]
fn lost_digits_do_not_hide_a_mistake() {
    let found = of_changed("CARDAN", |case, entries| {
        let triad = case.last().unwrap().state.pair.a.triad;
        each_row(entries, |row| {
            local(row, 3, &triad);
            let draw = &mut Draw::new("lost digits");
            row.iter_mut().for_each(|x| *x *= 1.0 + draw.between(-1e-11, 1e-11));
        });
    });
    assert!(found.contains("rotation-as-local"), "{found}");
}

/// Noise, and a matrix of something else, are not explained by anything.
#[test]
fn nothing_matches_noise() {
    for connection in TABLE {
        for seed in 0..20 {
            let found = of_changed(&connection.name, |_, entries| {
                let draw = &mut Draw::new(&format!("noise {seed}"));
                each_row(entries, |row| row.iter_mut().for_each(|x| *x += draw.between(-1.0, 1.0)));
            });
            assert!(found.starts_with("no known mistake explains"), "{}: {found}", connection.name);
            assert!(found.ends_with("[diagnosis::unknown]"), "{found}");
        }
    }
}

/// A candidate's report says why, in every form.
#[test]
fn a_wrong_candidate_is_told_why() {
    let turn = |state: &pintle_kinematics::connector::State<f64>, rows: &mut [Option<NodalRow<f64>>; 6]| {
        for row in rows.iter_mut().flatten() {
            local(row, 3, &state.pair.a.triad);
        }
    };
    let report = spoiled("UNIVERSAL", turn);
    let sentence = "equal Aᵀ × expected: rotation degrees of freedom taken as local";
    let mut human = Vec::new();
    pintle_report::audit::human(&mut human, &report, 300, false).unwrap();
    let human = anstream_free(&String::from_utf8(human).unwrap());
    assert!(human.contains(sentence) && human.contains("diagnosis::rotation-as-local"), "{human}");
    for write in [
        pintle_report::audit::json
            as fn(&mut dyn std::io::Write, &pintle_audit::Report) -> std::io::Result<()>,
        pintle_report::audit::junit,
        pintle_report::audit::markdown,
        |out, report| pintle_report::audit::html(out, report, &Default::default()),
    ] {
        let mut page = Vec::new();
        write(&mut page, &report).unwrap();
        let page = String::from_utf8(page).unwrap();
        assert!(page.contains(sentence) && page.contains("diagnosis::rotation-as-local"), "{page}");
    }
    assert_eq!(DOFS, 14);
}

/// A row that is zero at some states, and right at others, is not zero throughout; and what is wrong at hardly any state says so.
#[test]
fn causes_say_where_nothing_is_wrong() {
    type Rows = [Option<NodalRow<f64>>; 6];
    type State = pintle_kinematics::connector::State<f64>;
    let sentences = |spoil: &dyn Fn(&State, &mut Rows)| -> Vec<String> {
        let report = spoiled("CARTESIAN", spoil);
        let checks = report.subjects.iter().flat_map(|subject| &subject.checks);
        let found = checks.filter_map(|check| check.diagnosis.as_ref()).flat_map(|found| &found.causes);
        found.map(|cause| cause.sentence.clone()).collect()
    };
    let any = |said: &[String], words: &str| said.iter().any(|sentence| sentence.contains(words));
    let zero = |rows: &mut Rows| rows[0] = Some([0.0; DOFS]);
    let always = sentences(&|_, rows| zero(rows));
    assert!(any(&always, "∂u1 equals zero throughout: not computed, at "), "{always:?}");
    let some = sentences(&|state, rows| {
        if state.pair.b.displacement[1] > 0.0 {
            zero(rows);
        }
    });
    assert!(
        any(&some, "∂u1 equals zero: not computed there, at ") && any(&some, ", and right at "),
        "{some:?}"
    );
    assert!(!any(&some, "throughout"), "{some:?}");
    // Few states have such a displacement, in one of these ranges no more than one in twenty.
    let rare: Vec<String> = (0..16)
        .flat_map(|n| {
            let from = 0.06 * f64::from(n);
            sentences(&|state, rows| {
                let u = state.pair.b.displacement[1];
                if let (true, Some(row)) = (from < u && u < from + 0.06, &mut rows[0]) {
                    row[7..10].fill(0.0);
                }
            })
        })
        .collect();
    assert!(any(&rare, "; nothing is wrong at "), "{rare:?}");
    assert!(!any(&always, "nothing is wrong") && !any(&some, "nothing is wrong"), "{always:?} {some:?}");
}

/// A text without the codes of terminals.
fn anstream_free(text: &str) -> String {
    let mut shown = String::new();
    let mut letters = text.chars();
    while let Some(c) = letters.next() {
        if c == '\u{1b}' {
            letters.by_ref().find(|c| *c == 'm');
        } else {
            shown.push(c);
        }
    }
    shown
}
