use crate::generator::{Generator, Stream};
use crate::plan::Subject;
use crate::sobol::DIMENSIONS;
use crate::states::{Drawn, Place, Source};
use crate::sweep::Planted;
use crate::{Folder, OfSubject, Plan, Ranges, Routine, Routines, Summary, Sweep};
use pintle_audit::{Given, Quantity, Question};
use pintle_kinematics::connector::{Components, Connector, Definition, NodalRow, Output, Request, Tally};
use pintle_kinematics::vector::{product, transpose};
use rayon::prelude::*;
use std::f64::consts::TAU;

fn sweep(share: f64) -> Sweep {
    sweep_by(Generator::Philox, share)
}

fn sweep_by(generator: Generator, share: f64) -> Sweep {
    let plan = Plan::new(generator, "pintle", share, Subject::catalogue(), None).unwrap();
    Sweep::new(&plan.text().unwrap()).unwrap()
}

fn run(sweep: &Sweep, first: u64, count: u64) -> Summary {
    sweep.run(first, count, &|_| {}).unwrap()
}

/// Nothing is called wrong, at many states of every type, and the worst is what another computation of that state gives.
#[test]
fn nothing_is_wrong() {
    let sweep = sweep(0.02);
    let found = run(&sweep, 0, 40_000);
    assert_eq!(found.states.count(), 40_000);
    let judged: u64 = found.subjects.iter().map(|of| of.judged).sum();
    assert!(judged > 500, "{judged}");
    let (mut laws, mut framed) = (0, 0);
    for of in &found.subjects {
        assert_eq!(of.wrong, 0, "{of:?}");
        assert!(of.states() > 1000 && of.judged > 5 && of.numbers > 1000, "{of:?}");
        let has_flow = ["SLIPRING", "FLOW-CONVERTER", "RETRACTOR"].contains(&of.name.as_str());
        assert_eq!(of.rigid.states, of.states(), "{}", of.name);
        assert!(!has_flow || of.frame.states == 0, "{}", of.name);
        framed += usize::from(of.frame.states > 0);
        for law in [|of: &OfSubject| of.rigid.largest, |of: &OfSubject| of.frame.largest] {
            let Some(largest) = law(of) else { continue };
            let again = run(&sweep, largest.index, 1);
            let [again] = again.subjects.iter().filter_map(law).collect::<Vec<_>>()[..] else {
                panic!("one state is of one subject");
            };
            assert_eq!(again, largest, "{}", of.name);
            laws += 1;
        }
        println!(
            "{} rigid {:?} frame {:?} of {}",
            of.name, of.rigid.largest, of.frame.largest, of.frame.states
        );
    }
    // One block of 16 is turned, and a type has 40 of them: with bad luck none.
    assert!(laws > 50 && framed > 24, "{laws} {framed}");
}

/// A FLEXION-TORSION at half a turn, exactly: rounding decides the sign of a zero, and so between π and −π, otherwise in a batch than in the history.
#[test]
fn half_a_turn_has_one_side() {
    let found = run(&sweep(1.0), 24_028_648, 8);
    let of = found.subjects.iter().find(|of| of.name == "FLEXION-TORSION").unwrap();
    assert_eq!(
        (of.judged, of.places.get(&Place::RightAngles)),
        (8, Some(&1)),
        "another state is needed: {of:?}"
    );
    assert_eq!(of.wrong, 0, "{:?}", of.value.worst);
}

/// Each check fails where it should: a column 16 roundings off, a number that is none, an entry that is judged, axes exchanged.
#[test]
fn what_is_wrong_is_found() {
    let of = |name: &str| Subject::catalogue().into_iter().find(|subject| subject.name == name).unwrap();
    let found = |name: &str, planted: Option<Planted>| {
        let plan = Plan::new(Generator::Philox, "pintle", 0.01, vec![of(name)], None).unwrap();
        let sweep = Sweep::new(&plan.text().unwrap()).unwrap().planting(planted);
        run(&sweep, 0, 3200).subjects.swap_remove(0)
    };
    for name in ["CARTESIAN", "CARDAN", "HINGE", "UJOINT"] {
        assert_eq!(found(name, None).wrong, 0);
        let none = found(name, Some(Planted::NotANumber));
        assert_eq!((none.wrong, none.not_finite, none.first_not_finite), (100, 100, Some(0)), "{name}");
        let judged = found(name, Some(Planted::Judged));
        // Next to a lock the bound is larger than what was planted.
        assert!(judged.wrong <= judged.judged && judged.wrong * 10 > judged.judged * 8, "{name}: {judged:?}");
        assert_eq!(judged.rigid.beyond + judged.frame.beyond, 0, "{name}");
    }
    let column = found("CARTESIAN", Some(Planted::Column));
    assert!(column.wrong == column.rigid.beyond && column.wrong > 90, "{column:?}");
    let axes = found("CARDAN", Some(Planted::Axes));
    assert!(axes.rigid.beyond == 0 && axes.frame.beyond > 150 && axes.frame.beyond <= axes.wrong, "{axes:?}");
    // Twice wrong is wrong once.
    assert!(axes.wrong < axes.frame.beyond + axes.judged * 2 && axes.wrong >= axes.judged, "{axes:?}");
}

/// What was not asked does not read as perfect: a grounded connector with material flow has no whole rows, a grounded one without has.
#[test]
fn a_law_that_is_not_asked_has_no_result() {
    for (name, is_asked) in [("SLIPRING", false), ("HINGE", true)] {
        let subject = Subject::catalogue().into_iter().find(|subject| subject.name == name).unwrap();
        let mut definition = subject.connectors(true).unwrap().swap_remove(0);
        definition.moves[0] = false;
        let plan =
            Plan::new(Generator::Philox, "pintle", 0.0, vec![Subject::of("it".into(), definition)], None)
                .unwrap();
        let found = run(&Sweep::new(&plan.text().unwrap()).unwrap(), 0, 640).subjects.swap_remove(0);
        assert_eq!((found.states(), found.rigid.states), (640, if is_asked { 640 } else { 0 }), "{name}");
        assert_eq!(found.rigid.largest.is_some(), is_asked, "{name}");
        assert_eq!(found.frame.largest.is_some(), is_asked, "{name}");
    }
}

/// Any partition, order and number of threads: one summary.
#[test]
fn any_partition_gives_the_same_digest() {
    for generator in Generator::ALL {
        partitions_agree(&sweep_by(generator, 0.005));
    }
}

fn partitions_agree(sweep: &Sweep) {
    const STATES: u64 = 30_000;
    let whole = run(sweep, 0, STATES);
    let digest = whole.digest().unwrap();
    // Ends that lie within tiles, blocks and pieces.
    let ends = [0, 1, 2, 5, 31, 32, 33, 4095, 4097, 9_999, 20_001, 29_999, STATES];
    let chunks: Vec<(u64, u64)> = ends.windows(2).map(|pair| (pair[0], pair[1] - pair[0])).collect();
    let parts: Vec<Summary> = chunks.par_iter().map(|(first, count)| run(sweep, *first, *count)).collect();
    for threads in [1, 2, 8] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(pool.install(|| run(sweep, 0, STATES)), whole, "{threads} threads");
    }
    let merged = |order: &[usize]| {
        let mut all = sweep.empty();
        order.iter().for_each(|i| all.merge(&parts[*i]).unwrap());
        all.digest().unwrap()
    };
    let mut order: Vec<usize> = (0..parts.len()).collect();
    for turn in 0..6 {
        assert_eq!(merged(&order), digest, "{order:?}");
        order.rotate_left(5);
        order.swap(0, 2 + turn);
    }
    // Pairs first: the merge is associative.
    let mut all = sweep.empty();
    for pair in parts.chunks(2).rev() {
        let mut two = pair.last().unwrap().clone();
        pair.iter().rev().skip(1).for_each(|one| two.merge(one).unwrap());
        all.merge(&two).unwrap();
    }
    assert_eq!(all, whole);
    // And what is kept as text is the same.
    assert_eq!(serde_json::from_str::<Summary>(&whole.text().unwrap()).unwrap(), whole);
    assert!(all.merge(&parts[3]).is_err(), "a state cannot count twice");
}

/// The states of another generator are other ones: their summaries do not merge.
#[test]
fn generators_do_not_mix() {
    let [random, sobol] = Generator::ALL.map(|generator| run(&sweep_by(generator, 0.0), 0, 992));
    assert_ne!(random.fingerprint, sobol.fingerprint);
    let refused = random.clone().merge(&sobol).unwrap_err().to_string();
    assert!(refused.contains("different plans"), "{refused}");
}

/// Of 2¹³ states of a Sobol sequence each place has its share to the last one, and each part of a coordinate nearly so; random ones do not.
#[test]
fn states_of_a_sobol_sequence_lie_evenly() {
    const STATES: u64 = 1 << 13;
    let hinge = Subject::catalogue().into_iter().find(|subject| subject.name == "HINGE").unwrap();
    let definition = hinge.connectors(true).unwrap().swap_remove(0);
    let source = Source::new(&definition, &Connector::<f64>::new(&definition));
    let [random, sobol] = Generator::ALL.map(|generator| {
        let (mut places, mut parts) = ([0_u64; 5], [[0_u64; 64]; 3]);
        for index in 0..STATES {
            let Drawn { pair, place, .. } = source.state(generator, 3, index);
            places[Place::ALL.iter().position(|one| *one == place).unwrap()] += 1;
            if place == Place::Anywhere {
                let at = pair.b.displacement.map(|x| 32.0 * (x / source.length + 1.0));
                parts.iter_mut().zip(at).for_each(|(parts, at)| parts[at as usize] += 1);
            }
        }
        let mean = places[0] as f64 / 64.0;
        let off: f64 = parts.iter().flatten().map(|count| (*count as f64 - mean).powi(2) / mean).sum();
        (places, off)
    });
    let shares = [204, 16, 16, 16, 4].map(|of_256| of_256 * STATES / 256);
    assert!(sobol.0 == shares && random.0 != shares, "{sobol:?} {random:?}");
    // Of random ones 189 are expected, by 63 degrees of freedom of each coordinate.
    assert!((120.0..280.0).contains(&random.1) && sobol.1 < 20.0, "{sobol:?} {random:?}");
}

/// Each connector has its own points one after the other: of 256 of its states each place has its share, whatever states of others lie between.
#[test]
fn every_connector_has_a_sequence_of_its_own() {
    let sweep = sweep_by(Generator::Sobol, 0.0);
    let connectors = 8 * Subject::catalogue().len() as u64;
    let found = run(&sweep, 0, 256 * connectors);
    for of in &found.subjects {
        let counts = [Place::Little, Place::Turns, Place::RightAngles].map(|place| of.places[&place]);
        assert_eq!((of.states(), counts), (2048, [128, 128, 32]), "{}", of.name);
        assert_eq!(of.wrong, 0, "{of:?}");
    }
}

/// No state takes more numbers than a point of the Sobol sequence has.
#[test]
fn no_state_takes_more_numbers_than_there_are() {
    let mut most = 0;
    for subject in Subject::catalogue() {
        let definition = subject.connectors(true).unwrap().swap_remove(0);
        let source = Source::new(&definition, &Connector::<f64>::new(&definition));
        for index in 0..512 {
            let stream = &mut Stream::new(Generator::Sobol, 1, index);
            source.next(stream);
            most = most.max(stream.taken());
        }
    }
    assert!((18..=DIMENSIONS).contains(&most), "{most}");
}

/// A digest that could not change would prove nothing: another seed, share or number of states has another one.
#[test]
fn what_differs_has_another_digest() {
    let of = |seed: &str, share: f64, count: u64| {
        let plan = Plan::new(Generator::Philox, seed, share, vec![Subject::catalogue().swap_remove(0)], None)
            .unwrap();
        let found = run(&Sweep::new(&plan.text().unwrap()).unwrap(), 0, count);
        (found.fingerprint, found.digest().unwrap())
    };
    let [one, seed, share, count] = [("a", 0.01, 900), ("b", 0.01, 900), ("a", 0.2, 900), ("a", 0.01, 901)]
        .map(|(seed, share, count)| of(seed, share, count));
    assert_eq!(one, of("a", 0.01, 900));
    assert!(one.0 != seed.0 && one.0 != count.0 && one.0 == share.0, "the numbers are those of the states");
    assert!(one.1 != seed.1 && one.1 != share.1 && one.1 != count.1);
}

/// What is there is not computed again, what is not is; a file of another plan is refused by name.
#[test]
fn a_folder_knows_what_is_left() {
    let path = std::env::temp_dir().join(format!("pintle-sweep-{}", std::process::id()));
    _ = std::fs::remove_dir_all(&path);
    let sweep = sweep(0.001);
    let text = sweep.plan().text().unwrap();
    let folder = Folder::open(&path, &text).unwrap();
    let all = Ranges::of(0, 3000);
    let left =
        |folder: &Folder| -> Vec<(u64, u64)> { all.without(&folder.done().unwrap()).chunks(1000).collect() };
    let chunks = left(&folder);
    assert_eq!(chunks, [(0, 1000), (1000, 1000), (2000, 1000)]);
    for (first, count) in [chunks[2], chunks[0]] {
        folder.keep(&run(&sweep, first, count)).unwrap();
    }
    // What a killed worker leaves.
    std::fs::write(path.join(".chunk-000000000001000-1000.json.7.part"), "{\"sch").unwrap();
    let folder = Folder::open(&path, &text).unwrap();
    assert_eq!(left(&folder), [chunks[1]]);
    folder.keep(&run(&sweep, 1000, 1000)).unwrap();
    let merged = || folder.merged(sweep.empty());
    let digest = merged().unwrap().digest().unwrap();
    assert_eq!(digest, run(&sweep, 0, 3000).digest().unwrap());

    // Chunks of another size that are in others change nothing, whichever are larger; those that are partly in others are refused.
    for (first, count) in [(300, 700), (500, 2000), (0, 3000)] {
        folder.keep(&run(&sweep, first, count)).unwrap();
        // Until a file holds all of them, states 500 to 999 are partly in two.
        let is_same = merged().is_ok_and(|merged| merged.digest().unwrap() == digest);
        assert_eq!(is_same, first != 500, "{first}");
    }
    let partly = path.join("chunk-000000000002500-1000.json");
    folder.keep(&run(&sweep, 2500, 1000)).unwrap();
    let refused = merged().unwrap_err().to_string();
    assert!(
        refused.contains("chunk-000000000002500-1000.json") && refused.contains("delete it"),
        "{refused}"
    );
    std::fs::remove_file(&partly).unwrap();

    // What reads as a summary and is none: another name, other states, other counts.
    let kept = path.join("chunk-000000000000000-3000.json");
    let text_of = std::fs::read_to_string(&kept).unwrap();
    let named = path.join("chunk-000000000000000-4000.json");
    std::fs::write(&named, &text_of).unwrap();
    let refused = merged().unwrap_err().to_string();
    assert!(refused.contains("of other states than its name says"), "{refused}");
    std::fs::remove_file(&named).unwrap();
    let damaged = text_of.replacen("\"anywhere\":", "\"anywhere\":1", 1);
    assert_ne!(damaged, text_of);
    std::fs::write(&kept, damaged).unwrap();
    let refused = merged().unwrap_err().to_string();
    assert!(refused.contains("of other states than its name says"), "{refused}");
    for file in [kept, path.join("chunk-000000000000500-2000.json")] {
        std::fs::remove_file(file).unwrap();
    }

    let plan = |seed: &str, share: f64, at: usize| {
        Plan::new(Generator::Philox, seed, share, vec![Subject::catalogue().swap_remove(at)], None)
            .unwrap()
            .text()
            .unwrap()
    };
    let other = path.join("other");
    Folder::open(&other, &plan("a", 0.1, 1)).unwrap();
    assert_eq!(std::fs::read_to_string(other.join("plan.json")).unwrap(), plan("a", 0.1, 1));
    let sobol = Plan::new(Generator::Sobol, "a", 0.1, vec![Subject::catalogue().swap_remove(1)], None);
    for (text, told) in [
        (sobol.unwrap().text().unwrap(), "the generator sobol in place of philox"),
        (plan("b", 0.1, 1), "the seed \"b\" in place of \"a\""),
        (plan("a", 0.2, 1), "the share 0.2 in place of 0.1"),
        (plan("a", 0.1, 2), "other connectors"),
        (plan("a", 0.1, 1).replace(pintle_kinematics::VERSION, "9.9"), "pintle 9.9 in place of"),
    ] {
        let refused = Folder::open(&other, &text).unwrap_err().to_string();
        assert!(refused.contains("plan.json") && refused.contains(told), "{refused}");
    }
    std::fs::write(path.join("chunk-000000000009000-10.json"), "{").unwrap();
    let refused = merged().unwrap_err().to_string();
    assert!(refused.contains("chunk-000000000009000-10.json") && refused.contains("delete it"), "{refused}");
    std::fs::remove_dir_all(&path).unwrap();
}

/// A plan that was made where functions round otherwise draws other connectors: refused. So are summaries of another arithmetic.
#[test]
fn machines_that_round_otherwise_are_refused() {
    let sweep = sweep(0.0);
    let mut plan = sweep.plan().clone();
    plan.definitions.replace_range(..4, "0000");
    let refused = Sweep::new(&plan.text().unwrap()).unwrap_err().to_string();
    assert!(refused.contains("round otherwise"), "{refused}");
    let mut other = run(&sweep, 0, 32);
    other.arithmetic.push('0');
    let refused = sweep.empty().merge(&other).unwrap_err().to_string();
    assert!(refused.contains("round otherwise"), "{refused}");
}

/// A state lies where its label says, also in a plane and beside the ground; little turns are of all sizes.
#[test]
fn labels_of_states_are_true() {
    let catalogue = Subject::catalogue();
    let hinge = catalogue.iter().find(|subject| subject.name == "HINGE").unwrap();
    let full = hinge.connectors(true).unwrap().swap_remove(0);
    let mut planar = full.clone();
    planar.planar = true;
    planar.initial.a.triad = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    planar.initial.b.triad = planar.initial.a.triad;
    planar.initial.reference[2] = 0.0;
    let mut grounded = full.clone();
    grounded.rotates[1] = false;
    let mut looked = 0;
    for (definition, turns, angles) in
        [(&full, true, true), (&planar, true, false), (&grounded, false, false)]
    {
        let source = Source::new(definition, &Connector::<f64>::new(definition));
        let (mut least, mut most) = (f64::MAX, 0.0_f64);
        for index in 0..20_000 {
            let drawn = source.state(Generator::ALL[index as usize / 10_000], 1, index);
            let Drawn { pair, place, increment } = drawn;
            looked += 1;
            assert!(turns || !matches!(place, Place::Little | Place::Turns), "{place:?}");
            assert!(angles || place != Place::RightAngles);
            let (a, b) = (&pair.a.triad, &pair.b.triad);
            match place {
                Place::Little => {
                    let turned = |now, then| product(now, &transpose(then));
                    let (a, b) =
                        (turned(a, &definition.initial.a.triad), turned(b, &definition.initial.b.triad));
                    let apart: f64 = (0..9).map(|i| (a[i / 3][i % 3] - b[i / 3][i % 3]).powi(2)).sum();
                    // ‖A − B‖² = 8 sin²(θ/2).
                    let angle = 2.0 * (apart / 8.0).sqrt().asin();
                    (least, most) = (least.min(angle), most.max(angle));
                    assert!(!definition.planar || (a[2][2] - 1.0).abs() < 1e-15);
                }
                Place::RightAngles => {
                    assert!(
                        [a, b].iter().all(|c| c.iter().flatten().all(|x| x.abs() * (1.0 - x.abs()) == 0.0))
                    );
                }
                Place::Turns => assert_ne!(increment.whole_turns[1], [0.0; 3]),
                Place::Anywhere | Place::Near => {}
            }
        }
        if turns {
            assert!((2.0_f64.powi(-40) * 0.99..2.0_f64.powi(-38)).contains(&least), "{least:e}");
            assert!((0.9..1.0).contains(&most), "{most}");
        }
    }
    assert_eq!(looked, 60_000);
}

/// Changes what is answered at a state.
type Change = fn(&Question<'_>, &Connector<f64>, &mut [Option<f64>; 6], &mut Components<NodalRow<f64>>);

/// A routine: our own numbers one by one, as they are or changed.
struct Mine<'a> {
    definition: &'a Definition,
    change: Change,
}

impl Routine for Mine<'_> {
    fn ask(&mut self, asked: &[Question<'_>]) -> Result<Vec<Option<Given>>, String> {
        let connector = Connector::<f64>::new(self.definition);
        let request = Request::new(&[Output::CU, Output::RES], [true; 6], 1);
        let answer = |question: &Question<'_>| {
            let (step, branch) = (question.step, connector.initial_branch());
            let tally = &mut Tally::default();
            let found = connector.evaluate(&step.state, &step.increment, &branch, &request, tally);
            let mut values = std::array::from_fn(|k| found.residual[k].or(found.displacement[k]));
            let mut rows = found.jacobian;
            (self.change)(question, &connector, &mut values, &mut rows);
            Some(Given::from((values, rows)))
        };
        Ok(asked.iter().map(answer).collect())
    }

    fn offers(&self) -> &[Quantity] {
        &[Quantity::Value, Quantity::FirstDerivatives]
    }

    fn components(&self) -> [bool; 6] {
        [true; 6]
    }
}

/// What a plan says is a routine's is never computed by ourselves.
#[test]
fn the_numbers_of_a_routine_are_not_our_own() {
    let subject = vec![Subject::catalogue().swap_remove(0)];
    let plan = Plan::new(Generator::Philox, "pintle", 0.0, subject, Some("mine".into())).unwrap();
    let refused = Sweep::new(&plan.text().unwrap()).unwrap().run(0, 32, &|_| {}).unwrap_err();
    assert!(refused.to_string().contains("none was started"), "{refused}");
}

/// A right routine of every type is right at every state, with principal angles too; and a few wrong entries are found without any share.
#[test]
fn routines_are_judged() {
    let swept = |share: f64, change: Change| {
        let plan =
            Plan::new(Generator::Philox, "pintle", share, Subject::catalogue(), Some("mine".into())).unwrap();
        let sweep = Sweep::new(&plan.text().unwrap()).unwrap();
        let opens = |definition| Ok(Box::new(Mine { definition, change }) as Box<dyn Routine>);
        Routines::new(&sweep, opens).run(0, 62_000, &|_| {}).unwrap()
    };
    let right = swept(0.002, |_, _, _, _| {});
    let principal = swept(0.0, |_, connector, values, _| {
        for (k, value) in values.iter_mut().enumerate() {
            let winds = connector.differentiated(k).is_some_and(|measure| measure.winds());
            *value = value.map(|x| if winds { x - TAU * (x / TAU).round() } else { x });
        }
    });
    for of in right.subjects.iter().chain(&principal.subjects) {
        assert!(of.wrong == 0 && of.states() > 500, "{of:?}");
        assert!(
            of.outside == 0 && 4 * of.elsewhere < of.states() && 20 * of.undefined < of.states(),
            "{of:?}"
        );
    }
    let judged: u64 = right.subjects.iter().map(|of| of.judged).sum();
    // One state in eight, and there one entry.
    let few = swept(0.0, |question, _, _, rows| {
        let is_chosen = question.state().pair.a.displacement[0].to_bits() >> 20 & 7 == 0;
        let entries = rows.iter_mut().flatten().flat_map(|row| row.iter_mut());
        if let Some(entry) = entries.filter(|x| x.abs() > 0.1).last().filter(|_| is_chosen) {
            *entry *= 1.0 + 1e-9;
        }
    });
    let mut found = 0;
    for (of, right) in few.subjects.iter().zip(&right.subjects) {
        // Of types with material flow only the share is judged.
        if !["SLIPRING", "FLOW-CONVERTER", "RETRACTOR"].contains(&of.name.as_str()) {
            let part = of.wrong as f64 / (of.states() - of.elsewhere) as f64;
            assert!((0.05..0.2).contains(&part) && of.first_wrong.is_some(), "{part} {of:?}");
            found += of.wrong;
        }
        assert_eq!(of.states(), right.states());
    }
    assert!(judged > 100 && found > 5000, "{judged} judged, {found} found");
}
