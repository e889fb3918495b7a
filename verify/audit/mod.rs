//! The audit: it finds nothing wrong with the catalogue, and everything wrong with what is made wrong on purpose.

pub(crate) mod candidate; // routines of one's own: one-forms, components that are too many, what is undecided
pub(crate) mod command; // the audit and replay through the command line: exit codes, formats, counter-examples
pub(crate) mod counterexample; // counter-examples of constraints, frictions and slopes
pub(crate) mod edges; // states within rounding of a singular set, routines near one, files made by hand
pub(crate) mod evidence; // whether nothing passes without evidence, and nothing hides behind a kink
pub(crate) mod friction; // whether friction of scenes is audited, along its history
pub(crate) mod jax; // JAX as an oracle of the audit
pub(crate) mod laws; // whether the laws are asked of every connector, and speak
pub(crate) mod model; // whether findings are told of the right thing, and as bad as they are taken to be
pub(crate) mod relations; // constraints beside connectors: right numbers pass everywhere, mutants and what is planted are noticed
pub(crate) mod sample; // whether large scenes are judged by an even share, which the report says
pub(crate) mod structured; // states as models have them: one axis turns, shafts are aligned, forces are exactly zero
pub(crate) mod units; // whether units and axes change a verdict
pub(crate) mod verdict; // verdicts that differ by little: nearly right formulas, singular sets

use crate::numbers::manual;
use crate::{golden, golden_mpc, golden_relation};
use pintle_audit::mutants::mutant::{Mistake, Scene, mutants};
use pintle_audit::oracles::certificate::{Certificate, certificates};
use pintle_audit::replay::shrink::shrink;
use pintle_audit::sampling::{Extent, Region, cases, draw_case};
use pintle_audit::singular::atlas;
use pintle_audit::{
    Against, Bound, Candidate, Case, Check, CounterExample, Entries, Hex, Numbers, Oracle, Quantity, Report,
    Settings, Target, Verdict, audit_case, audit_cases, audit_catalogue, audit_scenes, friction_cases,
    laws as invariant, product,
};
use pintle_kinematics::catalog::{ConnectionType, TABLE};
use pintle_kinematics::connector::{Connector, Definition, Increment, NodalRow, Request, State, Tally};
use pintle_kinematics::draw::Draw;
use pintle_kinematics::measure::Measure;
use pintle_kinematics::node::{DOFS, Node, Pair};
use pintle_kinematics::vector::identity;
use pintle_model::evaluate::{Model, Plan, Selection};
use pintle_report::audit::AssertOk;
use pintle_scene as scene;
use pintle_scene::GALLERY;
use std::collections::BTreeMap;

/// Every kind of check, at few states: the program's default has twenty times as many.
fn brief() -> Settings {
    Settings { states: 40, near_singular_states: 20, wide_states: 4, ..Settings::default() }
}

fn silent(_: &str) {}

pub(crate) fn named(name: &str) -> &'static ConnectionType {
    TABLE.iter().find(|entry| entry.name == name).unwrap()
}

/// Nothing is wrong, nothing survives, every singular set is what it is declared to be, and every quantity of every type was
/// compared with an independent oracle.
#[test]
fn the_catalogue_passes() {
    let report = audit_catalogue(&brief(), &silent);
    let mut text = Vec::new();
    pintle_report::audit::human(&mut text, &report, 120, false).unwrap();
    let text = String::from_utf8(text).unwrap();
    assert_eq!((report.mismatches(), report.survivors()), (0, 0), "{text}");
    assert!(report.atlas.iter().all(pintle_audit::Approach::is_confirmed), "{text}");
    assert!(report.atlas.len() > 40);
    for subject in &report.subjects {
        assert_eq!(subject.derivative.headline(), Verdict::Pass, "{text}");
        assert_eq!(subject.formula, Verdict::Pass, "{text}");
        let connector = cases(named(&subject.name), Extent::Brief)[0].connector();
        let has_forces = (0..6).any(|k| connector.has_force(k));
        for quantity in Quantity::ALL {
            if !has_forces && matches!(quantity, Quantity::NodalForces | Quantity::GeometricStiffness) {
                continue;
            }
            let sharp = Against::Oracle(Oracle::WideDifferences);
            let check = subject.checks.iter().find(|c| c.quantity == Some(quantity) && c.against == sharp);
            let check = check.unwrap_or_else(|| panic!("{}: {} unchecked", subject.name, quantity.name()));
            assert!(check.compared > 0 && check.score.killed > 0, "{}: {check:?}", subject.name);
        }
    }
}

/// Every connector and MPC of the gallery, at its states, and of a deck without states, at drawn ones.
#[test]
fn scenes_pass() {
    let loaded: Vec<(String, Model, Vec<scene::State>)> = GALLERY
        .iter()
        .map(|example| {
            let scene = example.scene().unwrap();
            let states = example.states(&scene).unwrap().states;
            (example.name.to_string(), Model::compile(&scene).unwrap(), states)
        })
        .collect();
    let mut loaded = loaded;
    let bare = loaded[1].1.clone();
    loaded.push(("no states".into(), bare, Vec::new()));
    let plan = |model: &Model| Plan::compile(model, &Selection::All, Request::nothing(0)).unwrap();
    let plans: Vec<Plan> = loaded.iter().map(|(_, model, _)| plan(model)).collect();
    let targets: Vec<Target<'_>> = loaded
        .iter()
        .zip(&plans)
        .map(|((name, model, states), plan)| Target { name, model, plan, states })
        .collect();
    let report = audit_scenes(&brief(), &targets, &|_| {});
    let mut text = Vec::new();
    pintle_report::audit::human(&mut text, &report, 120, false).unwrap();
    let text = String::from_utf8(text).unwrap();
    assert_eq!((report.mismatches(), report.survivors()), (0, 0), "{text}");
    let planned: usize = plans.iter().map(|plan| plan.connectors.len() + plan.mpcs.len()).sum();
    assert_eq!(report.subjects.len(), planned);
    for subject in &report.subjects {
        // A spring at rest on a row of its table has two slopes.
        let springs = subject.checks.iter().filter(|check| check.quantity == Some(Quantity::BehaviorTangent));
        let verdicts = springs.map(|check| check.verdict);
        let expected = verdicts.max().filter(|verdict| *verdict == Verdict::Kink).unwrap_or(Verdict::Pass);
        assert_eq!(subject.derivative.headline(), expected, "{text}");
        assert_eq!(subject.formula, Verdict::Pass, "{}", subject.name);
        let scene = subject.scene.as_deref().unwrap();
        let states = loaded.iter().find(|(name, ..)| name == scene).unwrap().2.len();
        let want = if states == 0 { brief().drawn_states } else { states };
        assert_eq!(subject.cases, want as u64, "{} of {scene}", subject.name);
        let sharp = Against::Oracle(Oracle::WideDifferences);
        for quantity in [Quantity::Value, Quantity::FirstDerivatives, Quantity::Acceleration] {
            let check = subject.checks.iter().find(|c| c.quantity == Some(quantity) && c.against == sharp);
            assert!(check.is_some_and(|check| check.score.killed > 0), "{}", subject.name);
        }
    }
}

/// The same audit on one thread and on three is the same, number by number.
#[test]
fn threads_do_not_matter() {
    let settings =
        Settings { states: 20, near_singular_states: 5, wide_states: 1, atlas: false, ..Settings::default() };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let report = pool.install(|| audit_catalogue(&settings, &silent));
        let mut text = Vec::new();
        pintle_report::audit::json(&mut text, &report).unwrap();
        text
    };
    assert!(on(1) == on(3));
}

/// The certificates in the source are what the golden values and the transcribed tables say.
#[test]
fn certificates_follow_from_the_tests() {
    let mut states = golden::states_by_type();
    states.extend(golden_mpc::states_by_kind());
    states.extend(golden_relation::states_by_kind());
    let mut behavior = crate::friction::golden::states_by_kind();
    behavior.insert("BEHAVIOR springs and dampers".into(), crate::behavior::states_of_jax());
    let of_behavior = behavior.into_iter().map(|(name, jax_states)| {
        let page = "no summary table".to_string();
        (name, Certificate { jax_states, manual_page: page, unread: None })
    });
    let want: BTreeMap<String, Certificate> = manual::pages()
        .map(|(name, page)| (name.to_string(), page))
        .chain(manual::mpc_pages())
        .chain(manual::relation_pages())
        .map(|(name, page)| {
            let jax_states = states.get(&name).copied().unwrap_or(0);
            let told = page.strip_suffix(" unread").and_then(|told| told.rsplit_once("; "));
            let (page, unread) = told.map_or((page, None), |(page, unread)| (page, Some(unread.to_string())));
            (name, Certificate { jax_states, manual_page: page.to_string(), unread })
        })
        .chain(of_behavior)
        .collect();
    let text = serde_json::to_string_pretty(&want).unwrap() + "\n";
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/audit/oracles/certificates.json");
    if std::env::var_os("PINTLE_WRITE_CERTIFICATES").is_some() {
        std::fs::write(path, &text).unwrap();
        return;
    }
    assert!(
        *certificates() == want,
        "src/audit/oracles/certificates.json is not current: PINTLE_WRITE_CERTIFICATES=1 cargo test certificates_follow"
    );
}

pub(crate) fn at_rest(name: &str) -> Definition {
    let node = Node { displacement: [0.0; 3], triad: identity(), flow: 0.0 };
    Definition::new(named(name).clone(), Pair { reference: [0.7, -0.4, 0.9], a: node, b: node })
}

/// The product as somebody's routine, with a mistake in one row.
pub(crate) fn spoiled(name: &str, spoil: impl Fn(&State<f64>, &mut [Option<NodalRow<f64>>; 6])) -> Report {
    let definition = at_rest(name);
    let connector = Connector::<f64>::new(&definition);
    Candidate::new("candidate", &definition).check(|state| {
        let branch = connector.advance(state, &Increment::none(), &connector.initial_branch());
        let asked = Request::everything(1);
        let found = connector.evaluate(state, &Increment::none(), &branch, &asked, &mut Tally::default());
        let values = std::array::from_fn(|k| found.residual[k].or(found.displacement[k]));
        let mut rows = found.jacobian;
        spoil(state, &mut rows);
        (values, rows)
    })
}

/// A suite that saw only the neighbourhood of the initial state is told so, and one that saw more is not.
#[test]
fn a_suite_is_told_what_it_did_not_see() {
    let definition = at_rest("CARDAN");
    let connector = Connector::<f64>::new(&definition);
    let report = |states: usize| {
        let settings = Settings { states, wide_states: 1, near_singular_states: 0, ..Settings::default() };
        Candidate::new("mine", &definition).settings(settings).check(|state| {
            let asked = Request::everything(1);
            let branch = connector.initial_branch();
            let found = connector.evaluate(state, &Increment::none(), &branch, &asked, &mut Tally::default());
            (std::array::from_fn(|k| found.residual[k].or(found.displacement[k])), found.jacobian)
        })
    };
    // The first state is the initial one.
    let alone = report(1);
    let found: Vec<_> = alone.models.iter().flat_map(|model| &model.findings).collect();
    assert_eq!(found.len(), 1);
    assert_eq!((found[0].code().as_str(), found[0].file()), ("coverage::identity", "mine"));
    assert!(found[0].message().contains("1 state saw only the neighbourhood"), "{}", found[0].message());
    let mut text = Vec::new();
    pintle_report::audit::human(&mut text, &alone, 100, false).unwrap();
    assert!(String::from_utf8(text).unwrap().contains("coverage::identity"));
    assert!(report(30).models.is_empty());
}

/// The entry that the report names as wrong.
fn wrong_entry(report: &Report) -> String {
    let wrong = report.subjects[0].checks.iter().find(|check| check.verdict == Verdict::Wrong);
    wrong.map_or_else(|| "none".to_string(), |check| check.worst.as_ref().unwrap().entry.clone())
}

#[test]
fn a_right_candidate_passes_and_a_wrong_one_is_named() {
    for name in ["REVOLUTE", "CARTESIAN", "TRANSLATOR", "AXIAL", "UJOINT", "ROTATION"] {
        spoiled(name, |_, _| {}).assert_ok();
    }
    let dropped = spoiled("REVOLUTE", |_, rows| {
        rows[3].as_mut().unwrap()[10] = 0.0;
    });
    assert_eq!(wrong_entry(&dropped), "∂ur1/∂θb1");
    let tiny = spoiled("CARTESIAN", |_, rows| {
        rows[1].as_mut().unwrap()[8] *= 1.0 + 1e-9;
    });
    assert_eq!(wrong_entry(&tiny), "∂u2/∂xb2");
    let lever = spoiled("CARTESIAN", |state, rows| {
        let d = state.pair.separation();
        let row = rows[0].as_mut().unwrap();
        let g = [row[7], row[8], row[9]];
        let lever = pintle_kinematics::vector::cross(g, d);
        for i in 0..3 {
            row[3 + i] -= lever[i];
        }
    });
    assert!(wrong_entry(&lever).starts_with("∂u1/∂θa"), "{}", wrong_entry(&lever));
    let missing = spoiled("CARTESIAN", |_, rows| rows[2] = None);
    assert!(wrong_entry(&missing).contains("is missing"), "{}", wrong_entry(&missing));
    let infinite = spoiled("CARTESIAN", |_, rows| rows[2].as_mut().unwrap()[0] = f64::NAN);
    let verdicts: Vec<Verdict> = infinite.subjects[0].checks.iter().map(|check| check.verdict).collect();
    assert!(verdicts.contains(&Verdict::Invalid), "{verdicts:?}");
}

#[test]
#[should_panic(expected = "∂ur1/∂θb1")]
fn assert_ok_names_the_entry() {
    spoiled("REVOLUTE", |_, rows| rows[3].as_mut().unwrap()[10] = 0.0).assert_ok();
}

/// Mutants of a routine's numbers are tried too; of wrong numbers they do not count, for one of them is right.
#[test]
fn a_mutant_of_what_is_wrong_is_no_survivor() {
    let derivatives = |report: &Report| {
        let check = report.subjects[0].checks.iter().find(|check| {
            check.quantity == Some(Quantity::FirstDerivatives)
                && check.against == Against::Oracle(Oracle::WideDifferences)
        });
        check.unwrap().clone()
    };
    let right = derivatives(&spoiled("REVOLUTE", |_, _| {}));
    assert!(right.score.killed > 1000 && right.score.survived == 0, "{:?}", right.score);
    let reversed = spoiled("REVOLUTE", |_, rows| rows[3].as_mut().unwrap()[10] *= -1.0);
    assert_eq!((reversed.mismatches(), reversed.survivors()), (1, 0));
    assert_eq!(derivatives(&reversed).score.decisive(), 0);
    assert!(std::panic::catch_unwind(|| reversed.assert_ok()).is_err());
}

/// Bound, numbers and truth of a case.
pub(crate) fn judged(case: &Case) -> (Numbers<f64>, Bound, f64) {
    let numbers = product(case).unwrap();
    let step = case.last().unwrap();
    let narrow = pintle_audit::oracles::oracle::Narrow::of(case).unwrap();
    let nearness = narrow.nearness();
    let bound = Bound::new(&numbers, &step.state, case.length, nearness);
    (numbers, bound, nearness)
}

/// At well-conditioned states every mistake of δ ≥ 1e-9 exceeds the tolerance, in every quantity of every type.
#[test]
fn mistakes_are_beyond_the_tolerance() {
    let mut compared = 0;
    for connection in TABLE {
        let draw = &mut Draw::new(&connection.name);
        for region in [Region::Aligned, Region::Misaligned] {
            let case = draw_case(connection, region, draw).unwrap();
            let (numbers, bound, _) = judged(&case);
            for quantity in Quantity::ALL {
                let entries = numbers.entries(quantity);
                let scale = |k: usize, i: usize| bound.scale(quantity, k, i);
                let scene = Scene {
                    numbers: &numbers,
                    case: &case,
                    units: [None; 6],
                    turns: [0.0; 6],
                    scale: &scale,
                };
                let largest: Vec<f64> = (0..6)
                    .map(|k| entries.0[k].iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs())))
                    .collect();
                for mutant in mutants(quantity, &scene) {
                    let Mistake::Scaled(delta) = mutant.mistake else { continue };
                    let (k, i, x) = mutant.changes[0];
                    let was = entries.get(k, i).unwrap();
                    if delta >= 1e-9 && was.abs() > 1e-3 * largest[k] {
                        let tolerance = bound.tolerance(quantity, k, i);
                        assert!(
                            (x - was).abs() > 2.0 * tolerance,
                            "{} {} × (1 + {delta:e}): {:e} of {tolerance:e}",
                            case.name,
                            quantity.entry_name(k, i),
                            x - was
                        );
                        compared += 1;
                    }
                }
            }
        }
    }
    assert!(compared > 150_000, "{compared}");
}

/// At lengths from 1e-300 to 1e300, and where they overflow doubles, nothing is wrong or invalid in any type, and no mutant survives: what
/// is beyond the range of doubles is undecided, and says so.
#[test]
fn lengths_at_the_ends_of_the_range_are_no_mismatch() {
    let states = |name: &str, connection: &ConnectionType, unit: f64| {
        let draw = &mut Draw::new(&format!("{name} {unit:e}"));
        let case = draw_case(connection, Region::Misaligned, draw).unwrap();
        let mut case = units::scaled(&case, 1.0 / unit);
        case.name = format!("{name} in units of {unit:e}");
        (case.name.clone(), vec![case])
    };
    let units = [2.0_f64.powi(1000), 2.0_f64.powi(-1000), 2.0_f64.powi(-1022)];
    let all: Vec<_> = TABLE.iter().flat_map(|of| units.map(|unit| states(&of.name, of, unit))).collect();
    let report = audit_cases(&Settings { atlas: false, ..Settings::default() }, &all, &|_| {});
    let page = || {
        crate::commands::reports::text(
            |out, report| pintle_report::audit::human(out, report, 120, false),
            &report,
        )
    };
    assert_eq!((report.mismatches(), report.survivors()), (0, 0), "{}", page());
    let checks = || report.subjects.iter().flat_map(|subject| &subject.checks);
    let sharp = Against::Oracle(Oracle::WideDifferences);
    let is_right = |check: &&Check| {
        check.against == sharp
            && check.quantity == Some(Quantity::FirstDerivatives)
            && check.verdict.headline() == Verdict::Pass
    };
    assert!(checks().filter(is_right).count() > TABLE.len());
    for check in checks().filter(|check| check.verdict == Verdict::Undecided) {
        assert!(!check.undecided.is_empty(), "{:?} {:?}", check.quantity, check.worst);
    }
}

/// Values, not seeds: a counter-example is read back bit for bit, and a shrunk one is still one.
#[test]
fn counter_examples_are_values() {
    for connection in TABLE {
        let case = &cases(connection, Extent::Brief)[0];
        let record = CounterExample::record(case, Against::Own);
        let text = serde_json::to_string(&record).unwrap();
        let again: CounterExample = serde_json::from_str(&text).unwrap();
        assert_eq!(again, record);
        let replayed = again.case().unwrap();
        let [was, is] = [product(case).unwrap(), product(&replayed).unwrap()];
        for quantity in Quantity::ALL {
            let bits = |x: &Entries<f64>| x.iter().map(|(_, _, x)| x.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(was.entries(quantity)), bits(is.entries(quantity)), "{}", connection.name);
        }
    }
    for x in [0.0, -0.0, 1.5, -5e-324, f64::MAX, f64::MIN_POSITIVE, 0.1, -1e300, f64::INFINITY] {
        assert_eq!(Hex(x).to_string().parse::<Hex>().unwrap().0.to_bits(), x.to_bits());
    }
    for text in ["0x", "0x1.8", "0x2p+0", "0x1.00000000000001p+0", "0x1p+1024", "x", ""] {
        assert!(text.parse::<Hex>().is_err(), "{text}");
    }
    let other = CounterExample { schema: "pintle-eval/1".into(), ..record_of("AXIAL") };
    assert!(other.case().unwrap_err().to_string().contains("pintle-counterexample/2"));
}

fn record_of(name: &str) -> CounterExample {
    CounterExample::record(&cases(named(name), Extent::Brief)[0], Against::Own)
}

#[test]
fn a_counter_example_is_shrunk_while_it_fails() {
    let case = cases(named("CARTESIAN"), Extent::Full).swap_remove(0);
    // What fails is a lever on θ_a2: it needs a length across, and nothing else.
    let fails = |case: &Case| {
        let row = product(case).unwrap().entries(Quantity::FirstDerivatives).get(0, 4).unwrap();
        row.abs() > 0.1
    };
    let small = shrink(&case, &fails);
    assert!(fails(&small));
    assert_eq!(small.last().unwrap().state.pair.b.triad, identity::<f64>());
    let simple = |x: &f64| [0.0, 1.0, -1.0, 0.5, -0.5].contains(x);
    assert!(
        small.definition.initial.reference.iter().all(simple),
        "{:?}",
        small.definition.initial.reference
    );
    assert!(small.last().unwrap().state.velocity.iter().all(|x| *x == 0.0));
}

/// A check that compares nothing is no pass, and a law whose numbers are wrong speaks.
#[test]
fn nothing_compared_is_undecided() {
    let settings =
        Settings { oracles: [Oracle::NodalDual].into(), states: 5, near_singular_states: 0, ..brief() };
    let report = audit_catalogue(&settings, &silent);
    assert_eq!(report.undecided(), report.subjects.len());
    let case = cases(named("BEAM"), Extent::Brief).swap_remove(0);
    let (mut numbers, bound, _) = judged(&case);
    let mut rows = numbers.entries(Quantity::FirstDerivatives).clone();
    rows.0[4].as_mut().unwrap()[11] += 1e-9;
    numbers.set(Quantity::FirstDerivatives, rows);
    let context = invariant::Context::new(&case, &numbers, &bound).unwrap();
    for law in [pintle_audit::Invariant::RigidModes, pintle_audit::Invariant::Halves] {
        let demands = context.demands(law);
        let (demand, units) = invariant::worst(&numbers, &demands).unwrap();
        assert!(units > 1.0, "{law:?}");
        assert!(demand.what.to_string().contains("ur2"), "{}", demand.what);
    }
}

/// Steepness and errors of the atlas: a true singularity grows, a kink does not, and near each the value keeps its digits.
#[test]
fn the_atlas_tells_classes_apart() {
    let of = |name: &str| atlas::atlas(named(name));
    let lock = &of("CARDAN")[0];
    assert!(lock.rungs[5].steepness > 1e5 && lock.is_confirmed());
    let kink = &of("AXIAL")[0];
    assert!(kink.rungs.iter().all(|rung| rung.steepness < 1.1) && kink.is_confirmed());
    for approach in TABLE.iter().flat_map(atlas::atlas) {
        assert!(approach.is_confirmed(), "{approach:?}");
        // 1e-15 from a lock rounding decides the angles.
        for rung in approach.rungs.iter().filter(|rung| rung.distance > 2e-15) {
            assert!(rung.value_error < 4.0, "{} {}: {rung:?}", approach.connection, approach.component);
            assert!(rung.first_error < 4.0, "{} {}: {rung:?}", approach.connection, approach.component);
            // Far from the point next to nothing is missed, and nearer no more than the scale of the tolerance grows.
            let most = if rung.distance > 0.05 { 1e-11 } else { 1.0 };
            assert!(rung.detectable > 0.0 && rung.detectable <= most, "{} {rung:?}", approach.connection);
        }
    }
    assert_eq!(DOFS, 14);
}

/// Where only a formula fails, value, first and second derivatives continue, and are so at the point itself.
///
/// The turns of a rotation vector, either end of a lock and both sets of a belt are approached one by one, constraints as positions are.
#[test]
fn removable_points_are_confirmed() {
    use pintle_kinematics::measure::SingularClass::{BranchCut, Kink, Removable, TrueSingularity};
    let found: Vec<_> = TABLE.iter().flat_map(atlas::atlas).collect();
    for (name, component, at, class) in [
        ("ROTATION", "ur1", "φ = 0", Removable),
        ("ROTATION", "ur2", "|φ| = π", Removable),
        ("ROTATION", "ur3", "|φ| = 2π", TrueSingularity),
        ("ROTATION", "ur3", "|φ| = 4π", TrueSingularity),
        ("ALIGN", "ur1", "b in its initial orientation, ρ = 0", Removable),
        ("WELD", "ur3", "b turned by π from its initial orientation", BranchCut),
        ("PROJECTION CARTESIAN", "u2", "e3b = e3a, α = 0", Removable),
        ("PROJECTION FLEXION-TORSION", "ur1", "e3b = e3a, α = 0", Removable),
        ("FLEXION-TORSION", "ur2", "e3b = e3a, α = 0", Removable),
        ("FLEXION-TORSION", "ur1", "e3b = e3a, α = 0", Kink),
        ("FLEXION-TORSION", "ur1", "e3b = −e3a, α = π", Kink),
        ("FLEXION-TORSION", "ur3", "e3b = −e3a, α = π", TrueSingularity),
        ("CARDAN", "ur1", "β = −π/2 (lock)", TrueSingularity),
        ("CARDAN", "ur2", "β = −π/2 (lock)", Kink),
        ("EULER", "ur2", "e3b = −e3a, β = π (lock)", Kink),
        ("EULER", "ur3", "e3b = −e3a, β = π (lock)", TrueSingularity),
        ("SLIPRING", "u1", "no material left, l0 + Ψa − Ψb ≤ 0", TrueSingularity),
        ("SLIPRING", "u1", "coincident nodes, d = 0", Kink),
    ] {
        let is_it =
            |a: &&pintle_audit::Approach| (&*a.connection, a.component, a.at) == (name, component, at);
        let approach = found.iter().find(is_it).unwrap_or_else(|| panic!("{name} {component} at {at}"));
        assert_eq!((approach.declared, approach.seen), (class, Some(class)), "{name} {component} at {at}");
        assert!(approach.is_confirmed() && approach.rungs.len() == atlas::LADDER.len());
        if class == Removable {
            assert!(approach.rungs.iter().all(|rung| rung.steepness < 2.0), "{name} {component} at {at}");
        }
    }
    // Numbers that are off confirm nothing, whatever the class.
    let inexact = pintle_audit::Approach { exact: false, ..found[0].clone() };
    assert!(!inexact.is_confirmed() && inexact.told().contains("beyond rounding"));
}

/// States beside every point are among those drawn near singular ones.
#[test]
fn states_are_drawn_near_removable_points_too() {
    let draw = &mut Draw::new("near");
    let drawn: Vec<String> =
        (0..200).map(|_| atlas::random_near(named("ROTATION"), draw).unwrap().name).collect();
    for at in ["|φ| = 2π", "|φ| = 4π", "φ = 0", "|φ| = π"] {
        assert!(drawn.iter().filter(|name| name.ends_with(at)).count() > 20, "{at}");
    }
}

/// What is not finite is invalid, and the report names the stage from which on it is so; but for numbers beyond the range of doubles, which
/// are undecided.
#[test]
fn invalid_has_a_stage() {
    let checks = |change: &dyn Fn(&mut State<f64>)| {
        let mut case = cases(named("CARTESIAN"), Extent::Brief)[0].clone();
        change(&mut case.path.last_mut().unwrap().state);
        audit_case(&case, &Settings::default(), true, 0)
    };
    let with = |change: &dyn Fn(&mut State<f64>)| -> Vec<Option<&'static str>> {
        let checks = checks(change);
        checks.iter().filter(|check| check.verdict == Verdict::Invalid).map(|check| check.stage).collect()
    };
    assert_eq!(with(&|_| ()), []);
    for (stage, found) in [
        ("state", with(&|state| state.pair.b.displacement[1] = f64::NAN)),
        ("state", with(&|state| state.velocity[9] = f64::INFINITY)),
    ] {
        assert!(!found.is_empty() && found.iter().all(|found| *found == Some(stage)), "{stage}: {found:?}");
    }
    let far = |state: &mut State<f64>| {
        state.pair.a.displacement = [-1.7e308; 3];
        state.pair.b.displacement = [1.7e308; 3];
    };
    for change in
        [&far as &dyn Fn(&mut State<f64>), &|state| (7..10).for_each(|j| state.velocity[j] = 1.7e308)]
    {
        let checks = checks(change);
        assert!(checks.iter().all(|check| !check.verdict.is_mismatch()), "{checks:?}");
        let told = |check: &&Check| check.undecided.keys().any(|why| why.contains("overflow"));
        assert!(checks.iter().filter(told).count() > 0);
    }
    let spoiled = spoiled("CARTESIAN", |_, rows| rows[2].as_mut().unwrap()[0] = f64::NAN);
    let invalid = spoiled.subjects[0].checks.iter().find(|check| check.stage.is_some()).unwrap();
    assert_eq!((invalid.verdict, invalid.stage), (Verdict::Invalid, Some("first derivatives")));
    let mut text = Vec::new();
    pintle_report::audit::human(&mut text, &spoiled, 100, false).unwrap();
    let text = String::from_utf8(text).unwrap();
    assert!(text.contains("not finite from this on: first derivatives"), "{text}");
}

/// The verdict on formulas is that on springs and frictions too: a derived component that presses has no certificate.
#[test]
fn formulas_of_behaviour_need_certificates() {
    use pintle_audit::oracles::certificate::{certifies_predefined, certifies_springs};
    assert!(certifies_springs());
    for connection in TABLE {
        assert!(certifies_predefined(connection), "{}", connection.name);
    }
    let formula = |contact: &str| {
        let deck = format!(
            "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n\
            *ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*CONNECTOR SECTION, ELSET=C, BEHAVIOR=B\nSLOT,\nO,\n\
            *CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR ELASTICITY, COMPONENT=1\n150.,\n\
            *CONNECTOR DERIVED COMPONENT, NAME=N\n2, 3\n1., 1.\n\
            *CONNECTOR FRICTION, COMPONENT=1, CONTACT FORCE={contact}\n\n*FRICTION\n0.2,\n"
        );
        let scene = scene::Scene::parse("friction.inp", &deck).unwrap();
        let model = Model::compile(&scene).unwrap();
        let plan = Plan::compile(&model, &Selection::All, Request::nothing(0)).unwrap();
        let target = Target { name: "friction", model: &model, plan: &plan, states: &[] };
        let report = audit_scenes(&brief(), &[target], &|_| {});
        assert_eq!((report.mismatches(), report.survivors()), (0, 0));
        // What is undecided is no pass.
        let passes = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| report.assert_ok())).is_ok();
        assert_eq!(passes, report.subjects[0].formula == Verdict::Pass, "{contact}");
        report.subjects[0].formula
    };
    assert_eq!(formula("2"), Verdict::Pass);
    assert_eq!(formula("N"), Verdict::Undecided);
}

/// Second differences are of values alone: they agree with dual numbers to 20 digits and more, and not to the last, as what is computed alike
/// would.
#[test]
fn second_differences_share_no_mechanism() {
    use pintle_audit::oracles::oracle::WideAnswers;
    use pintle_audit::oracles::truth::Truth;
    let mut apart = 0;
    let mut compared = 0;
    for connection in TABLE {
        let all = cases(connection, Extent::Full);
        for case in all.iter().filter(|case| case.name.contains(" cube ")).take(2) {
            let truth = Truth::of(case).unwrap();
            if truth.nearness() == 0.0 {
                continue;
            }
            let answers = WideAnswers::of(&truth);
            for quantity in [Quantity::SecondDerivatives, Quantity::GeometricStiffness] {
                let [values, rows] =
                    [&answers.differences, &answers.dual].map(|numbers| numbers.entries(quantity));
                assert_eq!(values.len(), rows.len());
                for (k, i, want) in rows.iter() {
                    let error = (values.get(k, i).unwrap() - want).to_f64().abs();
                    assert!(error < 1e-20, "{} {}: {error:e}", case.name, quantity.entry_name(k, i));
                    compared += 1;
                    apart += usize::from(error > 0.0);
                }
            }
        }
    }
    assert!(compared > 10_000 && apart > 1000, "{compared} {apart}");
}

/// The distance to a singular set is that at which a state was placed, of every measure that has one, on either side.
#[test]
fn margins_are_the_distances_to_singular_sets() {
    let mut tried = 0;
    let mut margin_of = |connection: &ConnectionType, measure: Measure, case: &Case| {
        let connector = case.connector();
        let (got, _) = case.evaluation(&Request::everything(0)).unwrap();
        let margins = connector.margins(&case.last().unwrap().state, &got.branch, [true; 6]);
        tried += 1;
        let k = connection.slots.iter().position(|slot| slot.position() == Some(measure)).unwrap();
        margins[k].unwrap()
    };
    for connection in TABLE {
        let measures = connection.slots.iter().filter_map(|slot| slot.position());
        for measure in measures.filter(|measure| measure.singular_set().is_some()) {
            for distance in [0.3_f64, -0.3, 1e-3, -1e-3, 1e-7] {
                // A strain has no other side.
                let distance = if measure == Measure::Strain { distance.abs() } else { distance };
                let draw = &mut Draw::new("margins");
                let case = atlas::near(connection, measure, distance, 0.4, draw).unwrap();
                let margin = margin_of(connection, measure, &case);
                assert!(
                    (margin.distance - distance.abs()).abs() < 1e-12,
                    "{} {measure:?}: {} for {distance}",
                    connection.name,
                    margin.distance
                );
            }
        }
    }
    // Of a belt the nearer of two sets: no material left, l0 + Ψa − Ψb = 0, or no length.
    let belt = named("SLIPRING");
    for ([at_a, at_b], expected, at) in [
        ([0.25, 0.5], 0.75, "no material left"),
        ([0.5, 0.125], 1.0, "coincident nodes"),
        ([-0.5, 0.25], 0.25, "no material left"),
    ] {
        let draw = &mut Draw::new("margins");
        let mut case = atlas::near(belt, Measure::Strain, 0.5, 0.4, draw).unwrap();
        let pair = &mut case.path.last_mut().unwrap().state.pair;
        (pair.a.flow, pair.b.flow) = (at_a, at_b);
        let margin = margin_of(belt, Measure::Strain, &case);
        assert!((margin.distance - expected).abs() < 1e-12, "{at_a} {at_b}: {}", margin.distance);
        assert!(margin.set.at.starts_with(at), "{at_a} {at_b}: {}", margin.set.at);
    }
    assert!(tried > 100, "{tried}");
}

/// Friction is judged with every quantity, in stick and in slip, and a factor that is wrong is noticed.
#[test]
fn friction_passes_and_its_mistakes_are_noticed() {
    let settings = Settings::default();
    let mut found = BTreeMap::<Quantity, (u64, u64)>::new();
    for connection in TABLE {
        let cases = friction_cases(connection, &settings, 12);
        for case in &cases {
            for check in case.audit(&settings) {
                assert_eq!(check.verdict.headline(), Verdict::Pass, "{}: {check:?}", connection.name);
                assert_eq!(check.score.survived, 0, "{}: {check:?}", connection.name);
                let counted = found.entry(check.quantity.unwrap()).or_default();
                counted.0 += check.compared;
                counted.1 += check.score.killed;
            }
        }
    }
    println!("{found:?}");
    for quantity in [
        Quantity::FrictionCriterion,
        Quantity::FrictionGradient,
        Quantity::FrictionHessian,
        Quantity::FrictionTangent,
    ] {
        let (compared, killed) = found[&quantity];
        assert!(compared > 100 && killed > 1000, "{quantity:?}: {compared} {killed}");
    }
}

/// Where nodes of an AXIAL coincide the length has a kink: no two-sided derivative exists, and both one-sided ones are shown.
#[test]
fn a_kink_is_told_with_both_derivatives() {
    let mut case = atlas::near(named("AXIAL"), Measure::Distance, 0.5, 0.0, &mut Draw::new("kink")).unwrap();
    let step = case.path.last_mut().unwrap();
    let (reference, pair) = (case.definition.initial.reference, &mut step.state.pair);
    pair.b.displacement = [0, 1, 2].map(|i| pair.a.displacement[i] - reference[i]);
    assert_eq!(pair.separation(), [0.0; 3]);
    let checks = audit_case(&case, &Settings::default(), true, 0);
    let sharp = Against::Oracle(Oracle::WideDifferences);
    let check = checks
        .iter()
        .find(|check| check.quantity == Some(Quantity::FirstDerivatives) && check.against == sharp)
        .unwrap();
    assert_eq!(check.verdict, Verdict::Kink, "{check:?}");
    let [below, above] = check.worst.as_ref().unwrap().one_sided.unwrap();
    assert!((above - 1.0).abs() < 1e-15 && (below + 1.0).abs() < 1e-15, "{below} {above}");
    let report = audit_cases(&Settings::default(), &[("kink".into(), vec![case])], &silent);
    let mut text = Vec::new();
    pintle_report::audit::human(&mut text, &report, 120, false).unwrap();
    let text = String::from_utf8(text).unwrap();
    assert!(text.contains("from below -1, from above 1"), "{text}");
}

/// The slopes of springs and dampers of a scene are judged, and mistakes in them noticed.
#[test]
fn behaviour_of_a_scene_is_judged() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 1., 0.5, 0.25\n\
        *ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n\
        *ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n\
        *CONNECTOR SECTION, ELSET=C, BEHAVIOR=B\nCARTESIAN, CARDAN\nO,\n\
        *CONNECTOR BEHAVIOR, NAME=B\n\
        *CONNECTOR ELASTICITY, COMPONENT=1\n150.,\n\
        *CONNECTOR ELASTICITY, COMPONENT=2, NONLINEAR\n-30., -2.\n0., 0.\n10., 2.\n\
        *CONNECTOR DAMPING, COMPONENT=4\n3.,\n";
    let scene = scene::Scene::parse("spring.inp", deck).unwrap();
    let model = Model::compile(&scene).unwrap();
    let plan = Plan::compile(&model, &Selection::All, Request::nothing(0)).unwrap();
    let target = Target { name: "spring", model: &model, plan: &plan, states: &[] };
    let report = audit_scenes(&brief(), &[target], &|_| {});
    report.assert_ok();
    let checks = &report.subjects[0].checks;
    let check = checks.iter().find(|check| check.quantity == Some(Quantity::BehaviorTangent)).unwrap();
    // The initial state lies on a row of the table, where two slopes meet.
    assert_eq!(check.verdict, Verdict::Kink);
    assert!(check.states[&Verdict::Kink] == 1 && check.states[&Verdict::Pass] > 5, "{check:?}");
    assert!(check.compared >= 72 && check.score.killed > 20, "{check:?}");
}

/// At the exact orientations of a cube, half a turn of torsion among them, nothing is wrong on 237 bits either: what follows half the
/// torsion continues there.
#[test]
fn exact_orientations_pass() {
    let settings = Settings { oracles: [Oracle::WideDifferences].into(), ..Settings::default() };
    for name in ["PROJECTION CARTESIAN", "PROJECTION FLEXION-TORSION", "BUSHING"] {
        let all = cases(named(name), Extent::Full);
        let cubes: Vec<_> = all.iter().filter(|case| case.name.contains(" cube ")).collect();
        assert!(cubes.len() > 3, "{name}");
        for case in cubes {
            for check in audit_case(case, &settings, true, 0) {
                assert!(!matches!(check.verdict, Verdict::Wrong | Verdict::Invalid), "{check:?}");
            }
        }
    }
}
