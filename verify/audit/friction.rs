//! Friction of scenes: predefined, defined by users, of belts; at given forces along a history of states, and at drawn ones.

use crate::behavior::belts::{ALPHA, STIFFNESS, deck as belt, sliding, state as pulled};
use crate::commands::reports::text;
use crate::tolerance::BELT_SLOPE;
use pintle_audit::{
    Against, Check, Invariant, Oracle, Planted, Quantity, Report, Settings, Target, Verdict, audit_scenes,
};
use pintle_kinematics::draw::Draw;
use pintle_model::behavior::Conditions;
use pintle_model::behavior::friction::Status;
use pintle_model::evaluate::{Model, Plan, Selection, Sequence, request};
use pintle_report as report;
use pintle_report::audit::Supplement;
use pintle_scene::{ElementForces, Label, NodeMotion, Rotation, Scene, State};
use std::collections::BTreeSet;

/// A guide with the predefined friction of its type, a plate that slips in two directions along a potential, and a rod with two
/// frictions, pressed by springs and by itself.
pub(crate) const DECK: &str = "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n3, 1., 0., 0.\n4, 2., 0., 0.\n5, 0., 1., 0.\n6, 0., 1., 0.\n\
    *ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n\
    *ELEMENT, TYPE=CONN3D2, ELSET=GUIDE\n101, 1, 2\n*ELEMENT, TYPE=CONN3D2, ELSET=ROD\n102, 3, 4\n\
    *ELEMENT, TYPE=CONN3D2, ELSET=PLATE\n103, 5, 6\n\
    *CONNECTOR SECTION, ELSET=GUIDE, BEHAVIOR=BG\nTRANSLATOR\nO,\n\
    *CONNECTOR SECTION, ELSET=ROD, BEHAVIOR=BR\nCARTESIAN, CARDAN\nO,\n\
    *CONNECTOR SECTION, ELSET=PLATE, BEHAVIOR=BP\nSLIDE-PLANE\nO,\n\
    *CONNECTOR BEHAVIOR, NAME=BG\n*CONNECTOR FRICTION, PREDEFINED, STICK STIFFNESS=1.E3\n0.05, 0.1, 10.\n*FRICTION\n0.1\n\
    *CONNECTOR BEHAVIOR, NAME=BR\n*CONNECTOR ELASTICITY, COMPONENT=2\n150.,\n*CONNECTOR ELASTICITY, COMPONENT=3\n50.,\n\
    *CONNECTOR DAMPING, COMPONENT=2\n3.,\n\
    *CONNECTOR DERIVED COMPONENT, NAME=N\n2, 3\n1., 2.\n\
    *CONNECTOR FRICTION, COMPONENT=1, CONTACT FORCE=N, STICK STIFFNESS=1.E3\n, 0.5\n*FRICTION\n0.3\n\
    *CONNECTOR FRICTION, COMPONENT=4, STICK STIFFNESS=1.E2\n, 10., 0.\n, 20., 0.5\n*FRICTION\n0.1\n\
    *CONNECTOR BEHAVIOR, NAME=BP\n*CONNECTOR ELASTICITY, COMPONENT=2\n100.,\n\
    *CONNECTOR FRICTION, CONTACT FORCE=1, STICK STIFFNESS=500.\n, 2.\n\
    *CONNECTOR POTENTIAL, EXPONENT=3.\n2, 1.\n3, 0.5\n*FRICTION, EXPONENTIAL DECAY\n0.5, 0.2, 3.\n";

fn compiled(scene: &Scene) -> Model {
    Model::compile(scene).unwrap_or_else(|error| panic!("{}", error.render(100, false)))
}

fn model(deck: &str) -> Model {
    compiled(&Scene::parse("deck.inp", deck).unwrap_or_else(|error| panic!("{}", error.render(100, false))))
}

/// A walk to and fro: long steps that slip, short ones that stick, under forces that change.
pub(crate) fn path() -> Vec<State> {
    let draw = &mut Draw::new("frictions");
    let mut at = [[0.0; 3]; 3];
    let mut turned = 0.0;
    let step = |i: u32, draw: &mut Draw| draw.between(-1.0, 1.0) * [0.3, 1e-3, 1e-4][i as usize % 3];
    (1..=12)
        .map(|i| {
            let mut state = State { time: Some(0.1 * f64::from(i)), ..State::default() };
            turned += step(i, draw);
            for (place, node, free) in [(0, 2_u64, 0..1), (1, 4, 0..3), (2, 6, 1..3)] {
                free.for_each(|axis| at[place][axis] += step(i, draw));
                let rotation = if node == 4 { [turned, 0.0, 0.0] } else { [0.0; 3] };
                let velocity = if node == 4 { [0.0, draw.between(-1.0, 1.0), 0.0] } else { [0.0; 3] };
                let motion = NodeMotion {
                    displacement: at[place],
                    rotation: Rotation::Vector(rotation),
                    velocity,
                    ..NodeMotion::default()
                };
                state.nodes.insert(node.into(), motion);
            }
            for (element, scale) in [(101_u64, 2.0), (103, 20.0)] {
                let total = [(); 6].map(|()| Some(draw.between(-1.0, 1.0) * scale));
                // SLIDE-PLANE has forces 1, 2, 3 only.
                let kept = if element == 103 { 3 } else { 6 };
                let total = [0, 1, 2, 3, 4, 5].map(|k| total[k].filter(|_| k < kept));
                state.forces.insert(element.into(), ElementForces { total, ..ElementForces::default() });
            }
            state
        })
        .collect()
}

fn audited(model: &Model, states: &[State], settings: &Settings) -> Report {
    let plan = Plan::compile(model, &Selection::All, request(["CP"], 0).unwrap()).unwrap();
    audit_scenes(settings, &[Target { name: "frictions", model, plan: &plan, states }], &|_| {})
}

fn brief() -> Settings {
    let oracles = [Oracle::WideDifferences, Oracle::WideDual, Oracle::Differences].into();
    Settings { wide_states: 4, oracles, ..Settings::default() }
}

const OF_FRICTION: [Quantity; 6] = [
    Quantity::FrictionCriterion,
    Quantity::FrictionGradient,
    Quantity::FrictionHessian,
    Quantity::FrictionForce,
    Quantity::FrictionTangent,
    Quantity::ConsistentTangent,
];

/// The report in every form.
fn pages(report: &Report) -> Vec<String> {
    vec![
        human(report),
        text(report::audit::json, report),
        text(report::audit::junit, report),
        text(report::audit::markdown, report),
        text(|out, report| report::audit::html(out, report, &Supplement::default()), report),
    ]
}

/// The elements of which something is undecided.
fn undecided(report: &Report) -> Vec<&str> {
    let open = report.subjects.iter().filter(|subject| {
        [subject.derivative, subject.formula, subject.declaration].contains(&Verdict::Undecided)
    });
    open.filter_map(|subject| subject.name.split_whitespace().last()).collect()
}

fn frictions(report: &Report) -> impl Iterator<Item = (&str, &Check)> {
    let of = |check: &&Check| {
        check.against == Against::Law(Invariant::Carried)
            || check.quantity.is_some_and(|quantity| OF_FRICTION.contains(&quantity))
    };
    report
        .subjects
        .iter()
        .flat_map(move |subject| subject.checks.iter().filter(of).map(|check| (subject.name.as_str(), check)))
}

fn human(report: &Report) -> String {
    let mut text = Vec::new();
    report::audit::human(&mut text, report, 120, true).unwrap();
    String::from_utf8(text).unwrap()
}

/// Every friction of every connector, in stick and in slip, with every quantity, every oracle, and mutants that are noticed.
#[test]
fn frictions_of_a_scene_are_judged_along_its_history() {
    let (model, states) = (model(DECK), path());
    let plan = Plan::compile(&model, &Selection::All, request(["CSF"], 0).unwrap()).unwrap();
    let mut walk = Sequence::new(&model, &plan);
    let mut seen: BTreeSet<(usize, String)> = BTreeSet::new();
    for state in &states {
        for result in walk.step(state).connectors {
            for slip in &result.behavior.as_ref().unwrap().slips {
                seen.insert((result.index, format!("{:?}", slip.outcome.as_ref().unwrap().status)));
            }
        }
    }
    for index in 0..3 {
        for status in [Status::Stick, Status::Slip] {
            assert!(seen.contains(&(index, format!("{status:?}"))), "{index} {status:?}: {seen:?}");
        }
    }
    let report = audited(&model, &states, &brief());
    let page = human(&report);
    // The formulas of what presses through a derived component are typed in no second language.
    assert_eq!((report.mismatches(), report.survivors(), undecided(&report)), (0, 0, vec!["102"]), "{page}");
    for (name, check) in frictions(&report) {
        assert_eq!(check.verdict.headline(), Verdict::Pass, "{name}: {check:?}");
        assert!(check.score.killed > 20, "{name}: {check:?}");
        assert!(!check.worst_state.as_deref().unwrap_or_default().contains("drawn"), "{name}: {check:?}");
        let is_wide = matches!(check.against, Against::Oracle(Oracle::WideDifferences | Oracle::WideDual));
        let (frictions, wide) = if name.contains("102") { (2, 4) } else { (1, 4) };
        let states = if is_wide { wide } else { 12 };
        let times = match check.quantity {
            Some(Quantity::ConsistentTangent) | None => 1,
            _ => frictions,
        };
        assert_eq!(check.states.values().sum::<u64>(), states * times, "{name}: {check:?}");
    }
    for subject in &report.subjects {
        for quantity in OF_FRICTION {
            let sharp = Against::Oracle(Oracle::WideDifferences);
            let is_it = |check: &&Check| check.quantity == Some(quantity) && check.against == sharp;
            assert!(subject.checks.iter().any(|check| is_it(&check)), "{} {quantity:?}", subject.name);
        }
    }
}

/// A slope that is wrong by 1e-6 is named, in every format; where nothing is planted, and of a neighbour without friction, nothing is said.
#[test]
fn an_error_in_a_friction_is_named() {
    let (model, states) = (model(DECK), path());
    let settings = Settings { planted: Some(Planted::WrongFriction), ..brief() };
    let report = audited(&model, &states, &settings);
    assert_eq!(report.mismatches(), 3);
    for (name, check) in frictions(&report) {
        let told = check.worst.as_ref().map_or("", |worst| worst.entry.as_str());
        if check.quantity == Some(Quantity::FrictionTangent) {
            assert_eq!(check.verdict, Verdict::Wrong, "{name}: {check:?}");
            assert!(told.starts_with("∂f") || told.starts_with("∂m"), "{told}");
        } else {
            assert_ne!(check.verdict, Verdict::Wrong, "{name}: {check:?}");
        }
    }
    let guide = report.subjects.iter().find(|subject| subject.name.contains("101")).unwrap();
    let sharp = Against::Oracle(Oracle::WideDifferences);
    let of = |check: &&Check| check.quantity == Some(Quantity::FrictionTangent) && check.against == sharp;
    let entry = &guide.checks.iter().find(of).unwrap().worst.as_ref().unwrap().entry;
    assert!(entry.starts_with("∂f1/∂"), "{entry}");
    for page in pages(&report) {
        assert!(page.contains(entry.as_str()), "{entry}: {page}");
    }
    // Neighbours: the planted fault is one of friction.
    let bare = DECK.split("*CONNECTOR BEHAVIOR, NAME=BG").next().unwrap().replace(", BEHAVIOR=BG", "");
    let bare = bare.replace(", BEHAVIOR=BR", "").replace(", BEHAVIOR=BP", "");
    let report = audited(&crate::audit::friction::model(&bare), &states, &settings);
    assert_eq!((report.mismatches(), frictions(&report).count()), (0, 0));
}

/// Where forces that press are not given, and where no states are, frictions are judged at drawn ones, which is said.
#[test]
fn frictions_without_forces_are_judged_at_drawn_ones() {
    let model = model(DECK);
    let mut states = path();
    states.iter_mut().for_each(|state| state.forces.clear());
    for states in [states.as_slice(), &[]] {
        let report = audited(&model, states, &brief());
        let page = human(&report);
        assert_eq!(
            (report.mismatches(), report.survivors(), undecided(&report)),
            (0, 0, vec!["102"]),
            "{page}"
        );
        for (name, check) in frictions(&report).filter(|(name, _)| !name.contains("102")) {
            assert!(
                check.worst_state.as_deref().unwrap_or_default().ends_with("drawn forces"),
                "{name}: {check:?}"
            );
        }
        assert!(frictions(&report).count() > 30, "{page}");
    }
    // What depends on a temperature that nobody gives is undecided.
    let text = DECK.replace("*FRICTION\n0.3\n", "*FRICTION\n0.3, , , 20.\n0.2, , , 80.\n");
    let report = audited(&crate::audit::friction::model(&text), &path(), &brief());
    assert_eq!((report.mismatches(), undecided(&report)), (0, vec!["102"]));
    let rod = report.subjects.iter().find(|subject| subject.name.contains("102")).unwrap();
    assert_eq!(rod.derivative.headline(), Verdict::Undecided, "{}", human(&report));
    let conditions = Conditions { temperature: Some(35.0), fields: Vec::new() };
    let report = audited(&crate::audit::friction::model(&text), &path(), &Settings { conditions, ..brief() });
    let page = human(&report);
    assert_eq!((report.mismatches(), report.survivors()), (0, 0), "{page}");
    let rod = report.subjects.iter().find(|subject| subject.name.contains("102")).unwrap();
    assert_eq!(rod.derivative.headline(), Verdict::Pass, "{page}");
}

/// A component that has failed slides no more, and the friction that it shares with another goes on without it.
#[test]
fn a_friction_that_lost_a_component_is_judged() {
    let failing = DECK.replace(
        "*CONNECTOR BEHAVIOR, NAME=BP\n",
        "*CONNECTOR BEHAVIOR, NAME=BP\n*CONNECTOR FAILURE, COMPONENT=3, RELEASE=3\n-0.05, 0.05\n",
    );
    let (model, states) = (model(&failing), path());
    let plan = Plan::compile(&model, &Selection::All, request(["CSF"], 0).unwrap()).unwrap();
    let mut walk = Sequence::new(&model, &plan);
    let last = states.iter().map(|state| walk.step(state)).last().unwrap();
    assert!(last.connectors[2].behavior.as_ref().unwrap().failed[2]);
    let report = audited(&model, &states, &Settings { wide_states: 6, ..brief() });
    let page = human(&report);
    assert_eq!((report.mismatches(), report.survivors(), undecided(&report)), (0, 0, vec!["102"]), "{page}");
}

/// A potential whose shift is far larger than the forces: what it is formed from is rounded, and no more is asked.
#[test]
fn a_shift_larger_than_the_forces_is_no_mismatch() {
    for shift in ["1000.", "-1000."] {
        let shifted = format!("EXPONENT=3.\n2, 1., , ABS, {shift}\n3, 0.5\n");
        let model = model(&DECK.replace("EXPONENT=3.\n2, 1.\n3, 0.5\n", &shifted));
        let report = audited(&model, &path(), &Settings { wide_states: 12, ..brief() });
        assert_eq!((report.mismatches(), report.survivors()), (0, 0), "{shift}: {}", human(&report));
    }
}

/// At rest, where nothing slides and a traction has no direction, both derivatives are told, and none is called wrong.
#[test]
fn a_traction_of_zero_is_a_kink() {
    let model = model(DECK);
    let mut states = path();
    states.truncate(1);
    for motion in states[0].nodes.values_mut() {
        *motion = NodeMotion::default();
    }
    let report = audited(&model, &states, &brief());
    assert_eq!((report.mismatches(), report.survivors()), (0, 0), "{}", human(&report));
    let sharp = Against::Oracle(Oracle::WideDifferences);
    let (_, check) = frictions(&report)
        .find(|(name, check)| {
            name.contains("101")
                && check.quantity == Some(Quantity::FrictionGradient)
                && check.against == sharp
        })
        .unwrap();
    assert_eq!(check.verdict, Verdict::Kink, "{check:?}");
    let worst = check.worst.as_ref().unwrap();
    assert_eq!((worst.entry.as_str(), worst.one_sided), ("∂P/∂f1", Some([-1.0, 1.0])));
}

/// Where F_C takes away all but a trillionth of F_C^int, Φ is far smaller than what it is rounded by: that an error of a billionth in one
/// of its slopes is lost there is no failure of the audit.
#[test]
fn a_contact_force_that_vanishes_asks_for_no_more_than_rounding_leaves() {
    const DECK: &str = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n\
        *ELEMENT, TYPE=CONN3D2, ELSET=E\n101, 1, 2\n*CONNECTOR SECTION, ELSET=E, BEHAVIOR=B\nBUSHING\nO\n\
        *CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR FRICTION, COMPONENT=4, CONTACT FORCE=1, STICK STIFFNESS=1.E-3\n, 0.001\n\
        *FRICTION, EXPONENTIAL DECAY\n0.5, 0.2, 3.\n*CONNECTOR ELASTICITY, COMPONENT=1\n0.001\n\
        *CONNECTOR ELASTICITY, COMPONENT=4, NONLINEAR\n-0.001, -1.\n0., 0.\n0.003, 1.\n";
    let mut state = State { time: Some(1.0), ..State::default() };
    for (node, u1, turned) in [(1_u64, 1e-9, 0.0), (2, -1.0, std::f64::consts::PI)] {
        let motion = NodeMotion {
            displacement: [u1, 0.0, 0.0],
            rotation: Rotation::Vector([turned, 0.0, 0.0]),
            ..NodeMotion::default()
        };
        state.nodes.insert(node.into(), motion);
    }
    let total = [0.003, 1e-15, 0.004, -0.002, -0.002, -0.002].map(Some);
    state.forces.insert(101_u64.into(), ElementForces { total, ..ElementForces::default() });
    // The default stiffness is made of the same F_N as the limit, of which the slip then knows nothing.
    for deck in [DECK.to_string(), DECK.replace(", STICK STIFFNESS=1.E-3", "")] {
        let report = audited(&model(&deck), std::slice::from_ref(&state), &brief());
        assert_eq!((report.mismatches(), report.survivors()), (0, 0), "{deck}: {}", human(&report));
    }
}

/// A traction that a power below 2 holds at zero: its second derivatives are nobody's, its tangent is right.
#[test]
fn a_power_below_two_at_zero_is_no_mismatch() {
    for exponents in ["EXPONENT=1.5\n2, 1.\n3, 1.\n", "EXPONENT=1.25\n2, 1., 1.5\n3, 1., 1.5\n"] {
        let model = model(&DECK.replace("EXPONENT=3.\n2, 1.\n3, 0.5\n", exponents));
        let mut states = path();
        for state in &mut states {
            for (node, motion) in &mut state.nodes {
                if *node == Label::from(6_u64) {
                    motion.displacement[1] = 0.0;
                }
            }
        }
        let report = audited(&model, &states, &Settings { wide_states: 12, ..brief() });
        assert_eq!((report.mismatches(), report.survivors()), (0, 0), "{exponents}: {}", human(&report));
    }
}

/// The belt of the gallery with its friction, pulled and let go: with the angle given, and measured between the segments.
#[test]
fn belts_are_judged_along_their_history() {
    let flows =
        [[0.0, 0.0], [0.01, 0.011], [0.012, 0.0115], [0.012, 0.011_500_1], [0.011, 0.006], [0.0, 0.0]];
    let pulls = [0.0, 0.03, 0.03, 0.03, 0.03, 0.02];
    let mut states: Vec<State> = (0..6).map(|i| pulled(1.0 + i as f64, pulls[i], flows[i])).collect();
    states.push(pulled(8.0, 0.1, sliding(0.1)));
    let mut explicit = belt(&format!(", STICK STIFFNESS={STIFFNESS}"), "0.06");
    explicit.solver = Some(pintle_scene::Solver::Explicit);
    for scene in
        [belt(&format!(", STICK STIFFNESS={STIFFNESS}"), "0.06, 1.5707963"), belt("", "0.06, 1.25"), explicit]
    {
        let model = compiled(&scene);
        let report = audited(&model, &states, &brief());
        let page = human(&report);
        assert_eq!((report.mismatches(), report.survivors()), (0, 0), "{page}");
        for subject in &report.subjects {
            // Where the tensions are equal gradients have two sides, and second derivatives none.
            let headline = subject.derivative.headline();
            assert!(matches!(headline, Verdict::Pass | Verdict::Kink | Verdict::Singular), "{page}");
        }
        let of_first = || frictions(&report).filter(|(name, _)| name.contains("103"));
        assert!(of_first().count() >= 14, "{page}");
        for (name, check) in
            of_first().filter(|(_, check)| check.quantity == Some(Quantity::ConsistentTangent))
        {
            assert!(check.compared > 0, "{name}");
        }
        let settings = Settings { planted: Some(Planted::WrongFriction), ..brief() };
        let report = audited(&model, &states, &settings);
        assert_eq!(report.mismatches(), 1);
        let wrong = frictions(&report).find(|(_, check)| check.verdict == Verdict::Wrong).unwrap();
        assert!(wrong.0.contains("103"), "{}", wrong.0);
        let entry = &wrong.1.worst.as_ref().unwrap().entry;
        assert!(entry.starts_with("∂CSF2/∂"), "{entry}");
    }
}

/// CNF of a belt is the smaller tension, and in slip CSF2 = min(T1, T2) (e^(μα) − 1) of it, T2 = T1 e^(μα) in the known solution.
#[test]
fn the_normal_force_of_a_belt_is_the_tension_that_holds() {
    const FIRST: Label = Label::of(None, 103);
    let model = compiled(&belt(&format!(", STICK STIFFNESS={STIFFNESS}"), "0.06, 1.5707963"));
    let plan = Plan::compile(&model, &Selection::All, request(["CSF", "CNF", "CTF"], 0).unwrap()).unwrap();
    let mut walk = Sequence::new(&model, &plan);
    let growth = (0.2_f64 * ALPHA).exp_m1();
    for i in 0..=10 {
        let pull = 0.01 * f64::from(i);
        let results = walk.step(&pulled(pull, pull, sliding(pull))).connectors;
        let tension = |label: u64| {
            let of = |result: &&pintle_model::evaluate::ConnectorResult| {
                model.connectors[result.index].label == label
            };
            results.iter().find(of).unwrap().behavior.as_ref().unwrap().total.value[0].unwrap()
        };
        let [first, second] = [tension(103), tension(104)];
        let is_first =
            |result: &&pintle_model::evaluate::ConnectorResult| model.connectors[result.index].label == FIRST;
        let result = results.iter().find(is_first).unwrap();
        let slip = result.behavior.as_ref().unwrap().slips[0].outcome.as_ref().unwrap();
        assert_eq!(slip.normal, first.min(second).max(0.0), "{slip:?}");
        let limit = slip.normal * growth;
        assert!((slip.limit - limit).abs() <= BELT_SLOPE * first, "{slip:?}");
        if i > 0 {
            assert_eq!(slip.status, Status::Slip);
            assert!((slip.force[1] - limit).abs() <= BELT_SLOPE * first, "{slip:?} {limit}");
        }
    }
}

/// Where tensions vanish a belt's criterion has kinks: no second derivative is judged there, whatever oracle is asked, and a stiff
/// belt has the same verdict as a soft one.
#[test]
fn a_belt_at_rest_is_no_mismatch() {
    let gallery = include_str!("../../decks/seat_belt.inp");
    for stiffness in ["1e3", "1e9"] {
        let deck = gallery
            .replace(
                "** *CONNECTOR FRICTION, PREDEFINED",
                &format!("*CONNECTOR FRICTION, PREDEFINED, STICK STIFFNESS={stiffness}"),
            )
            .replace("** *FRICTION", "*FRICTION")
            .replace("** 0.2", "0.2");
        assert!(deck.contains("\n*FRICTION\n0.2"), "the deck has its friction in comments");
        let deck = crate::commands::cli::file(&format!("belt-at-rest-{stiffness}.inp"), &deck);
        for more in [&[][..], &["--oracles", "differences"][..]] {
            let arguments = [&["audit", &deck][..], more].concat();
            let page =
                crate::commands::cli::stdout(&crate::commands::cli::pintle(&arguments).assert().code(0));
            assert!(!page.contains(": wrong"), "{stiffness} {more:?}: {page}");
            assert_eq!(page.contains(": kink ("), more.is_empty(), "{stiffness} {more:?}: {page}");
        }
    }
}

/// What presses is held, made of the right slopes: a belt that sticks has none by what presses, and an error in its other slopes is no
/// contact force that is held.
#[test]
fn a_held_contact_force_does_not_explain_other_errors() {
    const HELD: &str = "diagnosis::contact-force-held";
    let states = [[0.0, 0.0], [1e-6, 1e-6], [2e-6, 2e-6]];
    let states: Vec<State> = (0..3).map(|i| pulled(1.0 + i as f64, 0.03, states[i])).collect();
    let model = compiled(&belt(&format!(", STICK STIFFNESS={STIFFNESS}"), "0.06, 1.5707963"));
    let settings = Settings { planted: Some(Planted::WrongFriction), ..brief() };
    let report = audited(&model, &states, &settings);
    let mut diagnosed = 0;
    for (name, check) in frictions(&report).filter(|(_, check)| check.verdict == Verdict::Wrong) {
        let diagnosis = check.diagnosis.as_ref().unwrap_or_else(|| panic!("{name}: {check:?}"));
        for cause in &diagnosis.causes {
            assert_eq!(cause.code.as_str(), "diagnosis::scaled", "{name}: {}", cause.sentence);
            assert!(cause.also.iter().all(|code| code.as_str() != HELD), "{name}: {}", cause.sentence);
            diagnosed += 1;
        }
    }
    assert!(diagnosed >= 2, "{}", human(&report));
}

/// A force that springs press, through displacements and velocities only, is coupled too: that it is held is noticed.
#[test]
fn a_contact_force_of_springs_that_is_held_is_noticed() {
    let (model, states) = (model(DECK), path());
    let report = audited(&model, &states, &brief());
    let rod = report.subjects.iter().find(|subject| subject.name.contains("102")).unwrap();
    for oracle in [Oracle::WideDifferences, Oracle::WideDual] {
        let of = |check: &&Check| {
            check.quantity == Some(Quantity::ConsistentTangent) && check.against == Against::Oracle(oracle)
        };
        let check = rod.checks.iter().find(of).unwrap();
        let held =
            check.score.by_mistake.iter().find(|(cause, _)| cause.code().as_str().ends_with("force-held"));
        let (_, fared) = held.unwrap_or_else(|| panic!("never tried: {check:?}"));
        assert!(fared.killed > 0 && fared.survived == 0, "{fared:?}");
    }
}

/// An increment of which the equations of slip have no solution is undecided, and that is said with its reason.
#[test]
fn a_friction_without_a_witness_is_undecided_with_a_reason() {
    // Shifted so far to both sides that no traction is admissible.
    let shifted = "EXPONENT=3.\n2, 1., , ABS, 1000.\n2, 1., , ABS, -1000.\n3, 0.5\n";
    let unstable = DECK.replace("EXPONENT=3.\n2, 1.\n3, 0.5\n", shifted);
    assert_ne!(unstable, DECK);
    let (model, states) = (model(&unstable), path());
    let settings = Settings { wide_states: 12, ..brief() };
    let report = audited(&model, &states, &settings);
    let page = human(&report);
    let sharp = Against::Oracle(Oracle::WideDifferences);
    let (_, check) = frictions(&report)
        .find(|(name, check)| {
            name.contains("103") && check.quantity == Some(Quantity::FrictionForce) && check.against == sharp
        })
        .unwrap();
    assert_eq!((report.mismatches(), check.verdict), (0, Verdict::Undecided), "{page}");
    let states: u64 = check.undecided.values().sum();
    assert_eq!(check.states.get(&Verdict::Undecided), Some(&states), "{check:?}");
    assert_eq!(check.states.values().sum::<u64>(), 12, "every state is accounted for: {check:?}");
    for page in pages(&report) {
        assert!(page.contains("the equations of slip define no solution"), "{page}");
    }
}
