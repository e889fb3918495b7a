//! Whether what is found in models is told once, of the right thing, and as bad as it was said to be taken.

use pintle_audit::model::{Finding, Level, Levels, ModelReport, audit_model};
use pintle_scene::{Code, Scene, Severity, StateFile};
use std::fmt::Write;
use std::path::Path;

fn scene(name: &str, text: &str) -> Scene {
    let path = crate::commands::cli::file(name, text);
    Scene::read(Path::new(&path)).unwrap_or_else(|error| panic!("{}", error.render(110, false)))
}

/// What is found in a deck of this text, at the states of a table, which may be empty.
fn audited(name: &str, deck: &str, states: &str, levels: &[(&str, Level)]) -> ModelReport {
    let scene = scene(&format!("audit-model-{name}.inp"), deck);
    let states = if states.is_empty() {
        Vec::new()
    } else {
        let path = crate::commands::cli::file(&format!("audit-model-{name}.csv"), states);
        StateFile::read(Path::new(&path), &scene).unwrap().states
    };
    let mut set = Levels::default();
    levels.iter().for_each(|(name, level)| set.set(name, *level).unwrap());
    audit_model(&scene, &states, &set)
}

fn of(report: &ModelReport, code: Code) -> Vec<&Finding> {
    report.findings.iter().filter(|finding| finding.code() == code).collect()
}

/// `pairs` of BEAMs that are there twice, and a chain of two LINKs that is stretched between nodes that are held.
fn doubled(pairs: usize) -> String {
    let mut text = String::from("*NODE\n1,0,0,0\n");
    for pair in 0..pairs {
        _ = writeln!(text, "{},{pair},1,0", pair + 2);
    }
    text.push_str("900,0,0,5\n901,1,0,5\n902,2,0,5\n*ELEMENT,TYPE=CONN3D2,ELSET=B\n");
    for pair in 0..pairs {
        _ = writeln!(text, "{},1,{node}\n{},1,{node}", 2 * pair + 1, 2 * pair + 2, node = pair + 2);
    }
    text + "*ELEMENT,TYPE=CONN3D2,ELSET=L\n901,900,901\n902,901,902\n*CONNECTOR SECTION,ELSET=B\nBEAM\n\
            *CONNECTOR SECTION,ELSET=L\nLINK\n*BOUNDARY\n1,1,6\n900,1,3\n902,1,3\n"
}

/// A finding is about every connector that it holds for, whatever its instance is called and however few are shown.
#[test]
fn a_finding_names_every_connector_in_what_it_is_about() {
    let deck = "*PART,NAME=P\n*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,1,1,0\n*ELEMENT,TYPE=CONN3D2,ELSET=S\n101,1,2\n102,3,4\n\
                *ORIENTATION,NAME=O\n1,0,0,0,1,0\n*CONNECTOR SECTION,ELSET=S,CONTROLS=C\nSLOT\nO,\n*END PART\n*ASSEMBLY,NAME=A\n\
                *INSTANCE,NAME=\"My part\",PART=P\n*END INSTANCE\n*END ASSEMBLY\n*SECTION CONTROLS,NAME=C\n";
    let labels = |finding: &Finding| -> Vec<String> {
        finding.about.elements.iter().map(ToString::to_string).collect()
    };
    let both = ["\"My part\".101", "\"My part\".102"];
    let explicit = format!("{deck}*STEP\n*DYNAMIC,EXPLICIT\n,1.\n*END STEP\n");
    let warned = audited("named-warning", &explicit, "", &[]);
    let [controls] = of(&warned, Code::ControlsNotInExplicit)[..] else { panic!("{:?}", warned.findings) };
    assert_eq!(labels(controls), both);
    assert!(
        controls.message().ends_with("(and so on for 1 other element: \"My part\".102)"),
        "{}",
        controls.message()
    );
    let refused = deck.replace("SLOT\nO,", "SLOT");
    let refused = audited("named-error", &refused, "", &[]);
    let [orientation] = of(&refused, Code::OrientationRequired)[..] else { panic!("{:?}", refused.findings) };
    assert_eq!(labels(orientation), both);
    // Half of the BEAMs are redundant, and 50 of them are told one by one.
    let report = audited("named-redundant", &doubled(70), "", &[]);
    let redundant = of(&report, Code::AssemblyRedundant);
    let mut all: Vec<String> = redundant.iter().flat_map(|finding| labels(finding)).collect();
    all.sort();
    all.dedup();
    assert_eq!((redundant.len(), all.len()), (50, 70));
}

/// However many redundancies hold throughout, one that holds at this state only is told, and may be denied: only what is shown of a code is shortened.
#[test]
fn many_of_one_code_hide_none_of_another() {
    let report = audited("many", &doubled(51), "", &[("assembly::redundant-here", Level::Deny)]);
    let throughout = of(&report, Code::AssemblyRedundant);
    assert_eq!(throughout.len(), 50);
    assert!(
        throughout[49].message().contains("1 more connector or constraint has"),
        "{}",
        throughout[49].message()
    );
    assert_eq!(of(&report, Code::AssemblyRedundantHere).len(), 1);
    assert!(report.fails());
}

/// Of a rotation vector that turns too far its angle is told, once, and not that each of its components moves by as much.
#[test]
fn a_rotation_vector_turns_as_a_whole() {
    const NODES: &str = "*NODE\n1,0,0,0\n2,0,0,0\n*ORIENTATION,NAME=O\n1,0,0,0,1,0\n*ELEMENT,TYPE=CONN3D2,ELSET=E\n1,1,2\n\
                         *CONNECTOR SECTION,ELSET=E\n";
    let told = |name: &str, turn: &str| -> Vec<(String, Vec<String>)> {
        let states = format!("state,time,node,{turn}\n0,0,2,0\n1,1,2,3.0\n");
        let report = audited(
            &format!("turned-{}", name.replace(' ', "-")),
            &format!("{NODES}{name}\nO,\n"),
            &states,
            &[],
        );
        let found = of(&report, Code::ModelLargeIncrement);
        found.iter().map(|one| (one.message().to_string(), one.about.components.clone())).collect()
    };
    let names = |of: &[&str]| -> Vec<String> { of.iter().map(ToString::to_string).collect() };
    let vector = "element 1: its rotation vector turns by 3.0000 rad since the state before at state 1";
    assert_eq!(told("ROTATION", "ur1"), [(vector.to_string(), names(&["ur1", "ur2", "ur3"]))]);
    let angle = "element 1: ur1 moves by 3.0000 rad since the state before at state 1";
    assert_eq!(told("CARDAN", "ur1"), [(angle.to_string(), names(&["ur1"]))]);
    let bushing = told("BUSHING", "ur3");
    assert!(!bushing.is_empty());
    for (message, components) in bushing {
        let is_torsion = message.contains(": its torsion turns by");
        assert!(is_torsion || message.contains(": ur"), "{message}");
        assert_eq!(is_torsion, components.contains(&"u1".to_string()), "{message}");
    }
}

/// A diagnosis names the cause of a wrong number: no level applies to it, and `explain` says so.
#[test]
fn levels_do_not_apply_to_diagnoses() {
    let page = |code: &str| {
        crate::commands::cli::stdout(&crate::commands::cli::pintle(&["explain", code]).assert().success())
    };
    for code in Code::ALL.iter().filter(|code| code.is_finding()) {
        let said = page(code.as_str()).split_whitespace().collect::<Vec<_>>().join(" ");
        let applies = said.contains("pintle audit takes it for what --allow");
        let is_cause = said.contains("--deny do not apply to it") && !said.contains("A warning.");
        assert_eq!((applies, is_cause), (code.group() != "diagnosis", code.group() == "diagnosis"), "{said}");
    }
}

/// A level can be set of every code of which it says something, as `explain` has it; of any other it is refused with the reason.
#[test]
fn levels_are_taken_or_refused_of_every_code() {
    let page = |code: &str| {
        crate::commands::cli::stdout(&crate::commands::cli::pintle(&["explain", code]).assert().success())
    };
    let mut refused = 0;
    for code in Code::ALL {
        let said = page(code.as_str()).split_whitespace().collect::<Vec<_>>().join(" ");
        for level in [Level::Allow, Level::Note, Level::Warn, Level::Deny] {
            let set = Levels::default().set(code.as_str(), level);
            assert_eq!(set.is_ok(), code.takes_level(), "{code}");
            let Err(why) = set else { continue };
            let is_said = said.contains("do not apply to it") || said.contains("no level that --allow");
            assert!(why.contains("leave it out") && is_said, "{why}: {said}");
            refused += 1;
        }
        if code.takes_level() {
            let levels = ["for what --allow", "goes on where --allow", "whatever --allow"];
            assert!(levels.iter().any(|words| said.contains(words)), "{code}: {said}");
        }
    }
    assert!(refused > 4 * 100, "{refused}");
    // So of groups: those in which there is nothing else.
    for (group, is_taken) in [("diagnosis", false), ("states", false), ("deck", true), ("rule::*", true)] {
        assert_eq!(Levels::default().set(group, Level::Deny).is_ok(), is_taken, "{group}");
    }
}

/// What is said of a redundancy is what was judged: that nothing moves, or that second order excludes what moves to first order, through which
/// nobody can drive; and `explain` tells these apart.
#[test]
fn what_a_redundancy_rests_on_is_told() {
    let report = audited("rests", &doubled(1), "", &[]);
    let one = |code: Code| match of(&report, code).as_slice() {
        [one] => (one.message().to_string(), one.remedy().to_string()),
        others => panic!("{code}: {} findings", others.len()),
    };
    let (message, remedy) = one(Code::AssemblyRedundant);
    assert!(message.contains("it holds throughout (what belongs to it cannot move)"), "{message}");
    assert!(remedy.contains("remove one of the two"), "{remedy}");
    for code in [Code::AssemblyRedundantHere, Code::AssemblyMechanism] {
        let (message, remedy) = one(code);
        assert!(message.contains("at this singular position") || message.contains("second order excludes"));
        assert!(remedy.starts_with("move a node") && !remedy.contains("drive through"), "{remedy}");
    }
    let page = |code: Code| {
        let said = crate::commands::cli::stdout(
            &crate::commands::cli::pintle(&["explain", code.as_str()]).assert().success(),
        );
        said.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    for (code, words) in [
        (Code::AssemblyRedundant, "at every state that the assembly can come to"),
        (Code::AssemblyRedundantHere, "second order excludes these motions"),
        (Code::AssemblyRedundantHere, "to leave it out makes another assembly"),
        (Code::AssemblyRedundantUnjudged, "its rank is not certain"),
        (Code::AssemblyUndecided, "moves what boundary conditions hold"),
        (Code::AssemblyMechanism, "Springs, friction, stops and other elements are not looked at"),
    ] {
        assert!(page(code).contains(words), "{}", page(code));
    }
}

/// What cannot turn, or move, because boundary conditions hold it, directly or through connectors and constraints that fix all
/// that it can do, is not asked for.
#[test]
fn coverage_asks_for_nothing_that_is_held() {
    let deck = |between: &str, held: &str| {
        format!(
            "*NODE\n1,0,0,0\n2,1,0,0\n3,2,0,0\n4,3,0,0\n*ORIENTATION,NAME=O\n0,0,1,1,0,0\n{between}\
             *ELEMENT,TYPE=CONN3D2,ELSET=E\n9,3,4\n*CONNECTOR SECTION,ELSET=E\nREVOLUTE\nO,\n*BOUNDARY\n{held}\n"
        )
    };
    let connector = |number: u8, nodes: &str, what: &str| {
        format!(
            "*ELEMENT,TYPE=CONN3D2,ELSET=E{number}\n{number},{nodes}\n*CONNECTOR SECTION,ELSET=E{number}\n{what}\n"
        )
    };
    let turned = "state,node,u1,ur3\n1,4,0,1.0\n";
    let still = "state,node,u1,ur3\n1,4,0,1e-3\n";
    let told = |name: &str, deck: &str, states: &str| -> Vec<&'static str> {
        let report = audited(&format!("held-{name}"), deck, states, &[]);
        let coverage = report.findings.iter().filter(|finding| finding.code().group() == "coverage");
        coverage.map(|finding| finding.code().as_str()).collect()
    };
    let one = Code::CoverageOneNode.as_str();
    let beam = connector(1, "1,2", "BEAM");
    let welds = beam.clone() + &connector(2, "2,3", "WELD\nO,");
    let ties = "*MPC\nBEAM,2,1\nTIE,3,2\n";
    let slides = beam.clone() + &connector(2, "3,2", "TRANSLATOR\nO,");
    let hinge = beam + &connector(2, "2,3", "HINGE\nO,");
    // A failure may release what held the node.
    let fails = connector(2, "2,3", "HINGE\nO,")
        .replace("*CONNECTOR SECTION,ELSET=E2", "*CONNECTOR SECTION,ELSET=E2,BEHAVIOR=B");
    let failure = "*CONNECTOR BEHAVIOR,NAME=B\n*CONNECTOR FAILURE,COMPONENT=1,RELEASE=ALL\n,,,5.\n";
    let fails = connector(1, "1,2", "BEAM") + &fails + failure;
    for (name, between, held, wanted) in [
        ("may-fail", format!("{fails}*CONNECTOR MOTION\n2,4\n").as_str(), "1,1,6", &[one][..]),
        ("free", welds.as_str(), "1,1,3", &[one]),
        ("beams", &welds, "1,1,6", &[]),
        ("rotations", &welds, "1,4,6", &[]),
        ("two-of-three", &welds, "1,5,6", &[one]),
        ("ties", ties, "1,1,6", &[]),
        ("slides", &slides, "1,1,6", &[]),
        ("pin", "*MPC\nPIN,3,1\n", "1,1,6", &[one]),
        ("turns", &hinge, "1,1,6", &[one]),
        ("held-hinge", &format!("{hinge}*CONNECTOR MOTION\n2,4\n"), "1,1,6", &[]),
        ("driven-hinge", &format!("{hinge}*CONNECTOR MOTION\n2,4,0.5\n"), "1,1,6", &[one]),
        ("other", "", "3,1,6", &[]),
        (
            "later",
            "",
            "3,1,6\n*STEP\n*STATIC\n*END STEP\n*STEP\n*STATIC\n*BOUNDARY, OP=NEW\n3,1,3\n*END STEP",
            &[one],
        ),
    ] {
        let found = told(name, &deck(between, held), turned);
        let of_revolute: Vec<&str> = found.into_iter().filter(|code| *code == one).collect();
        assert_eq!(of_revolute, wanted, "{name}");
    }
    // Between nodes that stand still nothing moves, and nothing is asked for; one of them free, it is.
    let held = deck("", "3,1,6\n4,1,6");
    let rest = "state,node,u1,ur3\n1,4,0,0\n";
    assert!(told("both", &held, rest).is_empty());
    assert_eq!(told("one", &deck("", "3,1,6\n4,1,5"), still), [Code::CoverageIdentity.as_str()]);
    // In the plane a node has fewer degrees of freedom, and a connector fewer components.
    let planar = |what: &str, held: &str| {
        format!(
            "*NODE\n1,0,0\n2,1,0\n3,2,0\n*ELEMENT,TYPE=CONN2D2,ELSET=E\n1,1,2\n*CONNECTOR SECTION,ELSET=E\n{what}\n\
             *ELEMENT,TYPE=CONN2D2,ELSET=F\n2,2,3\n*CONNECTOR SECTION,ELSET=F\nJOIN,ROTATION\n*BOUNDARY\n{held}\n"
        )
    };
    for (what, held, is_told) in
        [("WELD", "1,1,2\n1,6", false), ("WELD", "1,1,2", true), ("JOIN,ROTATION", "1,1,2\n1,6", true)]
    {
        let found = told("planar", &planar(what, held), "state,node,ur3\n1,3,1.0\n");
        assert_eq!(found.contains(&one), is_told, "{what} {held}: {found:?}");
    }
    // A node without rotations stands still where its displacements are held: beside one that may turn, if the two coincide.
    let joined = |x: u8, rest: &str| {
        format!(
            "*NODE\n1,0,0,0\n2,{x},0,0\n3,0,0,0\n4,1,0,0\n*ORIENTATION,NAME=O\n1,0,0,0,1,0\n*ELEMENT,TYPE=CONN3D2,ELSET=J\n1,1,2\n\
             *CONNECTOR SECTION,ELSET=J\nJOIN\n*ELEMENT,TYPE=CONN3D2,ELSET=L\n2,2,4\n*CONNECTOR SECTION,ELSET=L\nLINK\n{rest}\
             *BOUNDARY\n1,1,3\n4,1,3\n"
        )
    };
    let hinge = "*ELEMENT,TYPE=CONN3D2,ELSET=H\n3,3,1\n*CONNECTOR SECTION,ELSET=H\nHINGE\nO,\n";
    let rest_of_1 = "state,node,u1\n1,1,0\n";
    for (name, deck, standing) in [
        ("joined", joined(0, ""), 2),
        ("apart", joined(3, ""), 2),
        ("beside-a-hinge", joined(0, hinge), 1),
        ("beside-a-hinge-apart", joined(3, hinge), 0),
        ("slot", joined(0, "").replace("JOIN", "SLOT\nO,"), 0),
        // Node 1 of the SLOT has rotations, and may turn.
        ("held-slot", joined(0, "").replace("JOIN", "SLOT\nO,") + "*CONNECTOR MOTION\n1,1\n", 1),
        ("pin", joined(0, "*MPC\nPIN,2,3\n").replace("JOIN", "SLOT\nO,") + "3,1,3\n", 1),
        ("free-pin", joined(0, "*MPC\nPIN,2,3\n").replace("JOIN", "SLOT\nO,"), 0),
    ] {
        let report = audited(&format!("held-{name}"), &deck, rest_of_1, &[]);
        let count = report.coverage.exercise.standing;
        assert_eq!(count, standing, "{name}: {:?}", report.coverage);
    }
    // States that move what is held all the same are there to exercise the connector.
    assert_eq!(told("moved", &held, still), [Code::CoverageIdentity.as_str()]);
    assert!(told("turned", &held, turned).is_empty());
    // A planar linkage is asked for nothing that it cannot do.
    let gallery =
        pintle_scene::GALLERY.iter().find(|example| example.name.starts_with("slider_crank")).unwrap();
    let scene = gallery.scene().unwrap();
    let report = audit_model(&scene, &gallery.states(&scene).unwrap().states, &Levels::default());
    assert!(of(&report, Code::CoverageOneNode).is_empty());
}

/// A warning is told once, among the findings; one that is allowed nowhere.
#[test]
fn allowed_warnings_are_not_shown() {
    let deck = "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n*ELEMENT,TYPE=CONN3D2,ELSET=E\n1,1,2\n2,2,3\n\
                *CONNECTOR SECTION,ELSET=E,BEHAVIOR=B\nSLIPRING\n\n0.06,\n*CONNECTOR BEHAVIOR,NAME=B\n\
                *CONNECTOR FRICTION, PREDEFINED\n*FRICTION\n0.2\n*STEP\n*STATIC\n*END STEP\n";
    let path = crate::commands::cli::file("audit-model-allowed.inp", deck);
    let told = |levels: &[&str]| {
        let arguments = [&["audit", path.as_str(), "--model-only"], levels].concat();
        let assert = crate::commands::cli::pintle(&arguments).assert();
        (crate::commands::cli::stdout(&assert), crate::commands::cli::stderr(&assert))
    };
    let name = "rule::contact-angle-default";
    let (shown, said) = told(&[]);
    // Once, by the report.
    assert!(shown.contains(name) && !said.contains(name), "{shown} {said}");
    let (shown, said) = told(&["--allow", "rule"]);
    assert!(!shown.contains(name) && !said.contains(name), "{shown} {said}");
}

/// A stop that a state lies beyond is told once, with the number of the worst state; one that is passed initially already, not again. A later state is computed,
/// and may lie beyond by what a solver leaves.
#[test]
fn stops_passed_at_a_state_are_told() {
    let told = |name: &str, lower: &str, states: &str| -> Vec<String> {
        let deck = format!(
            "*NODE\n1,0,0,0\n2,0,0,0\n*ORIENTATION,NAME=O\n1,0,0,0,1,0\n*ELEMENT,TYPE=CONN3D2,ELSET=E\n1,1,2\n\
             *CONNECTOR SECTION,ELSET=E,BEHAVIOR=B\nCARTESIAN\nO,\n*CONNECTOR BEHAVIOR,NAME=B\n*CONNECTOR STOP,COMPONENT=1\n{lower}, 0.1\n"
        );
        let report = audited(&format!("first-{name}"), &deck, &format!("state,time,node,u1\n{states}"), &[]);
        let found = of(&report, Code::ModelStopViolated);
        found.iter().map(|finding| finding.message().to_string()).collect()
    };
    let at = "element 1: u1 is 0.6 at state 7, 0.5 above its stop at 0.1";
    assert_eq!(told("passed", "-0.5", "7,0,2,0.6\n8,1,2,0.5\n"), [at]);
    let later = "element 1: u1 is 0.6 at state 8, 0.5 above its stop at 0.1";
    assert_eq!(told("later", "-0.5", "7,0,2,0.05\n8,1,2,0.6\n"), [later]);
    assert_eq!(told("worst", "-0.5", "7,0,2,0.5\n8,1,2,0.6\n9,2,2,0.4\n"), [later]);
    assert_eq!(told("solver", "-0.5", "7,0,2,0.05\n8,1,2,0.1001234\n"), Vec::<String>::new());
    let initially = "element 1: u1 is 0 initially, 0.05 below its stop at 0.05";
    assert_eq!(told("initially", "0.05", "7,0,2,0.\n8,1,2,0.\n"), [initially]);
    assert_eq!(told("both", "0.05", "7,0,2,0.\n8,1,2,0.6\n"), [initially, later]);
    // What is told of the initial position hides no more than the same: not less of it, nor what is farther beyond or on another side.
    assert_eq!(told("less", "0.05", "7,0,2,0.01\n"), [initially]);
    let farther = "element 1: u1 is -0.25 at state 7, 0.3 below its stop at 0.05";
    assert_eq!(told("farther", "0.05", "7,0,2,-0.25\n"), [initially, farther]);
    let above = "element 1: u1 is 0.12 at state 7, 0.02 above its stop at 0.1";
    assert_eq!(told("above", "0.05", "7,0,2,0.12\n"), [initially, above]);
    // Nor what is certain: the initial position is beyond by no more than four digits leave open.
    let deck = "*NODE\n1,0.1234,0.5678,0.\n2,0.8306,1.2749,0.\n*ELEMENT,TYPE=CONN3D2,ELSET=E\n1,1,2\n\
                *CONNECTOR SECTION,ELSET=E,BEHAVIOR=B\nAXIAL\n*CONNECTOR BEHAVIOR,NAME=B\n*CONNECTOR STOP,COMPONENT=1\n0.,1.\n";
    let report = audited("first-open", deck, "state,time,node,u1,u2\n7,0,2,0.4,0.4\n", &[]);
    let found: Vec<(Severity, Option<u64>)> = of(&report, Code::ModelStopViolated)
        .iter()
        .map(|finding| (finding.severity(), finding.about.state))
        .collect();
    assert_eq!(found, [(Severity::Note, None), (Severity::Warning, Some(7))]);
}

/// A connector motion that leads beyond a stop is told without any state, at its worst time; one that ends before the stop is not.
#[test]
fn motions_that_lead_beyond_a_stop_are_told() {
    let told = |name: &str, amplitude: &str, motion: &str| -> Vec<(String, Option<u32>)> {
        let deck = format!(
            "*NODE\n1,0,0,0\n2,0,0,0\n*ORIENTATION,NAME=O\n0,0,1,1,0,0\n*ELEMENT,TYPE=CONN3D2,ELSET=E\n1,1,2\n\
             *CONNECTOR SECTION,ELSET=E,BEHAVIOR=B\nHINGE\nO,\n*CONNECTOR BEHAVIOR,NAME=B\n*CONNECTOR STOP,COMPONENT=4\n-0.5,0.5\n\
             *BOUNDARY\n1,1,6\n{amplitude}*STEP\n*STATIC\n1.,2.\n*CONNECTOR MOTION{motion}\n*END STEP\n"
        );
        let report = audited(&format!("led-{name}"), &deck, "", &[]);
        let found = of(&report, Code::ModelStopViolated);
        found.iter().map(|finding| (finding.message().to_string(), finding.line())).collect()
    };
    let ramp = "element 1: a connector motion leads ur1 to 1.5 at time 2, 1 above its stop at 0.5";
    assert_eq!(told("ramp", "", "\nE,4,1.5"), [(ramp.to_string(), Some(13))]);
    assert!(told("within", "", "\nE,4,0.5").is_empty());
    let table = "*AMPLITUDE,NAME=A\n0.,0.,1.,-2.,2.,0.\n";
    let there = "element 1: a connector motion leads ur1 to -0.8 at time 1, 0.3 below its stop at -0.5";
    assert_eq!(told("there-and-back", table, ",AMPLITUDE=A\nE,4,0.4"), [(there.to_string(), Some(13))]);
    assert!(told("velocity", "", ",TYPE=VELOCITY\nE,4,9.").is_empty());
}

/// Frictions without effect: a belt that wraps no angle, a contact force of a spring of stiffness zero, a kinetic coefficient of zero.
#[test]
fn frictions_without_effect_are_told() {
    let told = |name: &str, deck: &str| -> Vec<String> {
        let report = audited(&format!("friction-{name}"), deck, "", &[]);
        let found = of(&report, Code::ModelFrictionVanishes);
        found.iter().map(|finding| finding.message().to_string()).collect()
    };
    let belt = |angle: &str| {
        format!(
            "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n*ELEMENT,TYPE=CONN3D2,ELSET=E\n1,1,2\n2,2,3\n\
             *CONNECTOR SECTION,ELSET=E,BEHAVIOR=B\nSLIPRING\n\n0.06, {angle}\n*CONNECTOR BEHAVIOR,NAME=B\n\
             *CONNECTOR ELASTICITY,COMPONENT=1\n100.\n*CONNECTOR FRICTION, PREDEFINED\n*FRICTION\n0.2\n*STEP\n*STATIC\n*END STEP\n"
        )
    };
    let straight = told("straight", &belt("0."));
    assert_eq!(straight.len(), 1);
    assert!(straight[0].contains("the contact angle of the section is zero"), "{straight:?}");
    assert_eq!(told("wrapped", &belt("1.57")), Vec::<String>::new());
    let pressed = |laws: &str| {
        format!(
            "*NODE\n1,0,0,0\n2,0.8,0,0\n*ORIENTATION,NAME=O\n1,0,0,0,1,0\n*ELEMENT,TYPE=CONN3D2,ELSET=E\n1,1,2\n\
             *CONNECTOR SECTION,ELSET=E,BEHAVIOR=B\nCARTESIAN\nO,\n*CONNECTOR BEHAVIOR,NAME=B\n{laws}\
             *CONNECTOR FRICTION,COMPONENT=1,CONTACT FORCE=2\n*FRICTION\n0.1\n"
        )
    };
    let spring = |stiffness: &str| format!("*CONNECTOR ELASTICITY,COMPONENT=2\n{stiffness}\n");
    let unpressed = told("unpressed", &pressed(&spring("0.")));
    assert_eq!(
        unpressed,
        [
            "element 1: the contact force is always zero, for the force of u2 is zero by its table: nothing presses"
        ]
    );
    assert_eq!(told("pressed", &pressed(&spring("1."))), Vec::<String>::new());
    let damper = format!("{}*CONNECTOR DAMPING,COMPONENT=2\n5.\n", spring("0."));
    assert_eq!(told("damped", &pressed(&damper)), Vec::<String>::new());
    let nonlinear = "*CONNECTOR ELASTICITY,COMPONENT=2,NONLINEAR\n0.,-1.\n0.,1.\n";
    assert_eq!(told("flat", &pressed(nonlinear)), unpressed);
    let hinge = |law: &str| {
        format!(
            "*NODE\n1,0,0,0\n2,0,0,0\n*ORIENTATION,NAME=O\n1,0,0,0,1,0\n*ELEMENT,TYPE=CONN3D2,ELSET=E\n1,1,2\n\
             *CONNECTOR SECTION,ELSET=E,BEHAVIOR=B\nHINGE\nO,\n*CONNECTOR BEHAVIOR,NAME=B\n\
             *CONNECTOR FRICTION, PREDEFINED\n0.02, 0.1, 0.2, 0.1\n*FRICTION,EXPONENTIAL DECAY\n{law}\n"
        )
    };
    let decays = told("decays", &hinge("0.3, 0., 1."));
    assert_eq!(decays.len(), 1);
    assert!(decays[0].contains("the kinetic friction coefficient is zero"), "{decays:?}");
    assert_eq!(told("stays", &hinge("0.3, 0.2, 1.")), Vec::<String>::new());
    assert_eq!(told("never-decays", &hinge("0.3, 0., 0.")), Vec::<String>::new());
}

/// Nodes that are as far apart as rounding makes them: a LINK has no direction there, so that its rank is not certain; a WELD or JOIN, whose
/// directions are given, constrains as it does elsewhere.
#[test]
fn nodes_apart_by_rounding() {
    let codes = |name: &str, kind: &str, x: f64| {
        let deck = format!(
            "*NODE\n1,0,0,0\n2,0.3,0.5,0\n3,{x:?},0.5,0\n4,1,1,0.3\n*ELEMENT,TYPE=CONN3D2,ELSET=E\n1,1,2\n3,3,4\n\
             *ELEMENT,TYPE=CONN3D2,ELSET=W\n2,2,3\n*CONNECTOR SECTION,ELSET=E\nBEAM\n*CONNECTOR SECTION,ELSET=W\n{kind}\n"
        );
        let report = audited(&format!("apart-{name}"), &deck, "", &[]);
        let rank = report.assembly.as_ref().and_then(|assembly| assembly.positions[0].rank);
        let redundant =
            [Code::AssemblyRedundant, Code::AssemblyRedundantHere, Code::AssemblyRedundantUnjudged]
                .into_iter()
                .any(|code| !of(&report, code).is_empty());
        (rank, redundant, !of(&report, Code::AssemblyUndecided).is_empty())
    };
    let sum = 0.1 + 0.2;
    assert_eq!(codes("weld", "WELD", sum), (Some(18), false, false));
    assert_eq!(codes("beam", "BEAM", sum), (Some(18), false, false));
    assert_eq!(codes("join", "JOIN", sum), (Some(15), false, false));
    assert_eq!(codes("weld-off", "WELD", 0.300_000_000_000_1), (Some(18), false, false));
    let (_, redundant, undecided) = codes("link", "LINK", sum);
    assert!(!redundant && undecided);
    let link = |x: f64| {
        let deck = format!(
            "*NODE\n1,0,0.5,0.5\n2,{x:e},0.5,0.5\n*ELEMENT,TYPE=CONN3D2,ELSET=E\n1,1,2\n*CONNECTOR SECTION,ELSET=E\nLINK\n"
        );
        let report = audited(&format!("link-{x:e}"), &deck, "", &[]);
        (!of(&report, Code::AssemblyRedundant).is_empty(), !of(&report, Code::AssemblyUndecided).is_empty())
    };
    assert_eq!([1e-17, 1e-16, 1e-15].map(link), [(false, true); 3]);
    assert_eq!(link(1e-3), (false, false));
}

/// What is said fits: the form of the scene, the type, the size of an angle; and a rule that refuses a scene warns not besides.
#[test]
fn words_fit_what_they_are_about() {
    let path = crate::commands::cli::file(
        "audit-model-two.toml",
        "nodes = { 1 = [0, 0, 0], 2 = [1, 0, 0] }\nconnectors.101 = { a = 1, b = 2 }\nelement_sets.Q = [101]\n\
         [[connector_sections]]\nelement_set = \"Q\"\ntype = \"CARTESIAN\"\n",
    );
    let report = audit_model(&Scene::read(Path::new(&path)).unwrap(), &[], &Levels::default());
    let remedy = of(&report, Code::ModelOrientationDefault)[0].remedy().to_string();
    assert_eq!(remedy, "give orientation_a, or leave it out if the global directions are meant");
    let deck = |kind: &str, more: &str| {
        format!(
            "*NODE\n1,0,0,0\n2,1,0.2,0.3\n*ORIENTATION,NAME=O\n1,0,0,0,1,0\n*ORIENTATION,NAME=B\n1,1e-9,0,-1e-9,1,0\n\
             *ELEMENT,TYPE=CONN3D2,ELSET=E\n1,1,2\n2,1,2\n*CONNECTOR SECTION,ELSET=E{more}"
        )
        .replace("KIND", kind)
    };
    let report = audited("axial", &deck("AXIAL", "\nKIND\n"), "", &[]);
    let message = of(&report, Code::ModelDuplicateConnector)[0].message().to_string();
    assert_eq!(message, "element 2 joins the nodes of element 1, and is an AXIAL as well");
    let report = audited("frozen", &deck("HINGE", "\nKIND\nO,B\n"), "", &[]);
    let message = of(&report, Code::ModelMisalignedAxes)[0].message().to_string();
    assert!(message.contains("5.73e-8°") && !message.contains("0.000000°"), "{message}");
    let friction = ",BEHAVIOR=F\nKIND\nO,\n*CONNECTOR BEHAVIOR,NAME=F\n*CONNECTOR FRICTION,PREDEFINED\n1.,1.,1.,0.,3.\n*FRICTION\n0.1\n";
    let report = audited("numbers", &deck("HINGE", friction), "", &[]);
    assert_eq!(of(&report, Code::FrictionParameters).len(), 1);
}

/// A door on two connectors, from node 1 on the ground to 2 and from 3 to 4; what ties 2 and 4 to one body, and where the second stands.
fn door(types: [&str; 2], at: &str, axis: &str, tied: &str) -> ModelReport {
    let [first, second] = types;
    let deck = format!(
        "*NODE\n1,0,0,0\n2,0,0,0\n3,{at}\n4,{at}\n*ORIENTATION,NAME=O\n0,0,1,1,0,0\n*ORIENTATION,NAME=T\n{axis}\n\
         *ELEMENT,TYPE=CONN3D2,ELSET=A\n1,1,2\n*ELEMENT,TYPE=CONN3D2,ELSET=B\n2,3,4\n\
         *CONNECTOR SECTION,ELSET=A\n{first}\nO,\n*CONNECTOR SECTION,ELSET=B\n{second}\nT,\n{tied}*BOUNDARY\n1,1,6\n3,1,6\n"
    );
    audited("door", &deck, "", &[])
}

/// Two hinges of one door whose axes are not one line let nothing turn: the audit says so, how far apart they are, and of which.
#[test]
fn axes_of_one_door_are_one_line() {
    const BODY: &str = "*NSET,NSET=D\n4\n*RIGID BODY,REF NODE=2,TIE NSET=D\n";
    const BEAM: &str = "*ELEMENT,TYPE=CONN3D2,ELSET=C\n3,2,4\n*CONNECTOR SECTION,ELSET=C\nBEAM\n";
    const FAILING: &str = "*ELEMENT,TYPE=CONN3D2,ELSET=C\n3,2,4\n*CONNECTOR SECTION,ELSET=C,BEHAVIOR=F\nBEAM\n\
                           *CONNECTOR BEHAVIOR,NAME=F\n*CONNECTOR FAILURE,COMPONENT=1,RELEASE=ALL\n,,-1.,1.\n";
    const UP: &str = "0,0,1,1,0,0";
    for (types, at, axis, tied, said) in [
        (
            ["HINGE"; 2],
            "0.1,0,2",
            UP,
            BODY,
            Some(
                "HINGE 1 and HINGE 2 join the same two bodies about axes that are not one line: parallel, 0.1 apart",
            ),
        ),
        (["HINGE"; 2], "0.1,0,2", UP, BEAM, Some("parallel, 0.1 apart")),
        (["HINGE"; 2], "0.1,0,2", UP, "*MPC\nBEAM,4,2\n", Some("parallel, 0.1 apart")),
        (["HINGE", "CYLINDRICAL"], "0,1e-3,2", UP, BODY, Some("HINGE 1 and CYLINDRICAL 2 join")),
        // At the same height, and by e1 the other way round.
        (["HINGE"; 2], "0.1,0,0", "0,0,-1,1,0,0", BODY, Some("parallel, 0.1 apart")),
        (["HINGE"; 2], "0,0,2", "0.1,0,1,1,0,-0.1", BODY, Some("5.710593° from parallel, 0 apart")),
        (["HINGE"; 2], "0,0,2", UP, BODY, None),
        (["HINGE"; 2], "0,0,2", "0,0,-1,1,0,0", BODY, None),
        (["HINGE"; 2], "0.1,0,2", UP, "", None),
        (["HINGE"; 2], "0.1,0,2", "1,0,0,0,1,0", BODY, None),
        (["HINGE", "JOIN"], "0.1,0,2", UP, BODY, None),
        // What is tied and apart does not move as one body; what may fail holds nothing for good; rounding is no distance.
        (["HINGE"; 2], "0.1,0,2", UP, "*MPC\nTIE,4,2\n", None),
        (["HINGE"; 2], "0.1,0,2", UP, FAILING, None),
        (["HINGE"; 2], "1e-17,0,2", UP, BODY, None),
    ] {
        let report = door(types, at, axis, tied);
        let found = of(&report, Code::ModelAxesApart);
        let told: Vec<&str> = found.iter().map(|finding| finding.message()).collect();
        match said {
            None => assert!(told.is_empty(), "{types:?} {at} {axis} {tied}: {told:?}"),
            Some(said) => {
                let [message] = told[..] else { panic!("{types:?} {at} {axis} {tied}: {told:?}") };
                assert!(message.contains(said), "{message}");
                assert_eq!(found[0].about.elements.len(), 2);
                let assembly = report.assembly.as_ref().unwrap();
                assert_eq!(assembly.positions[0].mobility.unwrap_or(0), 0, "{message}");
            }
        }
    }
}

/// A comment in Markdown says what to do about a finding.
#[test]
fn markdown_has_remedies() {
    let path = crate::commands::cli::file(
        "audit-model-markdown.inp",
        "*NODE\n1,0,0,0\n2,1,0,0\n*ELEMENT,TYPE=CONN3D2,ELSET=E\n1,1,2\n2,1,2\n*CONNECTOR SECTION,ELSET=E\nAXIAL\n",
    );
    let assert = crate::commands::cli::pintle(&["audit", &path, "--model-only", "--format", "markdown"])
        .assert()
        .success();
    let page = crate::commands::cli::stdout(&assert);
    assert!(page.contains("; *help:* remove one of the two; if both are meant, allow this code"), "{page}");
}

/// Of a deck without states the coverage is that of the states at which it was audited, and said to be drawn.
#[test]
fn drawn_states_are_covered() {
    let path = crate::commands::cli::file(
        "audit-model-drawn.inp",
        "*NODE\n1,0,0,0\n2,1,0,0\n*ELEMENT,TYPE=CONN3D2,ELSET=E\n1,1,2\n*CONNECTOR SECTION,ELSET=E\nAXIAL\n",
    );
    let told = |more: &[&str]| {
        let arguments = [&["audit", &path, "--drawn-states", "7", "--wide-states", "1"], more].concat();
        crate::commands::cli::stdout(&crate::commands::cli::pintle(&arguments).assert().success())
    };
    let words = |text: String| text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        words(told(&[])).contains("coverage: 7 connector states, drawn about the initial one;"),
        "{}",
        told(&[])
    );
    let document: serde_json::Value = serde_json::from_str(&told(&["--format", "json"])).unwrap();
    let model = &document["models"][0];
    assert_eq!((&model["coverage"]["samples"], &model["drawn"]), (&7.into(), &true.into()));
    let page = words(told(&["--format", "html"]));
    assert!(
        page.contains("id=\"coverage\"")
            && page.contains("drawn about the initial one, for the scene gives none")
    );
    let alone: serde_json::Value =
        serde_json::from_str(&told(&["--model-only", "--format", "json"])).unwrap();
    let model = &alone["models"][0];
    assert_eq!((&model["coverage"]["samples"], &model["drawn"]), (&0.into(), &false.into()));
}

/// Where each error is, and the element that it names.
fn errors(report: &ModelReport) -> Vec<(&'static str, u32, String)> {
    let errors = report.findings.iter().filter(|finding| finding.severity() == Severity::Error);
    let one = |finding: &Finding| {
        let message = finding.message().to_string();
        (finding.code().as_str(), finding.line().unwrap_or_default(), message)
    };
    errors.map(one).collect()
}

/// A connector has as many errors as there are places where it breaks a rule: one does not hide the others, nor does one type those of another.
#[test]
fn every_error_of_a_connector_is_told() {
    let head = "*NODE\n1,0,0,0\n2,1,0,0\n3,2,0,0\n*ORIENTATION,NAME=O\n1,0,0,0,1,0\n\
                *ELEMENT,TYPE=CONN3D2,ELSET=E1\n1,1,2\n*ELEMENT,TYPE=CONN3D2,ELSET=E2\n2,2,3\n3,2,3\n\
                *CONNECTOR SECTION,ELSET=E1,BEHAVIOR=B\nTRANSLATOR\nO,\n*CONNECTOR SECTION,ELSET=E2,BEHAVIOR=B\nSLOT\nO,\n";
    let lines = head.lines().count() as u32;
    let places = |name: &str, rest: &str| -> Vec<(&'static str, u32, String)> {
        let found = errors(&audited(&format!("errors-{name}"), &format!("{head}{rest}"), "", &[]));
        let of = |(code, line, message): (&'static str, u32, String)| {
            let element = message.split([' ', ':']).nth(1).unwrap_or_default().to_string();
            (code, line.saturating_sub(lines), element)
        };
        let mut found: Vec<_> = found.into_iter().map(of).collect();
        found.sort();
        found
    };
    let told = |all: &[(&'static str, u32, &str)]| -> Vec<(&'static str, u32, String)> {
        let mut all: Vec<_> =
            all.iter().map(|(code, line, element)| (*code, *line, (*element).to_string())).collect();
        all.sort();
        all
    };
    let [action, stop, parameters] =
        ["rule::action-not-available", "rule::stop-not-available", "rule::friction-parameters"];
    // Two stops, a damping, an elasticity of the same component, and a friction that lacks a number.
    let behavior = "*CONNECTOR BEHAVIOR,NAME=B\n*CONNECTOR STOP,COMPONENT=2\n-1,1\n*CONNECTOR STOP,COMPONENT=3\n-1,1\n\
                    *CONNECTOR DAMPING,COMPONENT=5\n1.\n*CONNECTOR ELASTICITY,COMPONENT=5\n1.\n*CONNECTOR FRICTION,PREDEFINED\n1,2,3,4\n\
                    *FRICTION\n0.1\n";
    let of = |element: &'static str| {
        vec![
            (stop, 3, element),
            (stop, 5, element),
            (action, 6, element),
            (action, 8, element),
            (parameters, 10, element),
        ]
    };
    // SLOT takes two numbers, and is told once for both of its elements.
    assert_eq!(places("behavior", behavior), told(&[of("1"), of("2")].concat()));
    // Motions and loads, of one component and of others.
    let driven = "*CONNECTOR BEHAVIOR,NAME=B\n*STEP\n*STATIC\n*CONNECTOR MOTION\n1,2,0.5\n2,4,0.5\n*CONNECTOR LOAD\n1,3,0.5\n2,4,0.5\n*END STEP\n";
    assert_eq!(
        places("driven", driven),
        told(&[(action, 5, "1"), (action, 6, "2"), (action, 8, "1"), (action, 9, "2")])
    );
    // Of failures and locks each by itself, and both components of one.
    let failing = "*CONNECTOR BEHAVIOR,NAME=B\n*CONNECTOR LOCK,COMPONENT=1,LOCK=1\n-9,9\n*CONNECTOR FAILURE,COMPONENT=2,RELEASE=3\n-1,1\n\
                   *CONNECTOR FAILURE,COMPONENT=1,RELEASE=1\n-1,1\n*CONNECTOR FAILURE,COMPONENT=2,RELEASE=1\n-1,1\n*STEP\n*STATIC\n*END STEP\n";
    let failure = "rule::failure-not-available";
    let of =
        |element: &'static str| vec![(failure, 4, element), (failure, 4, element), (failure, 8, element)];
    assert_eq!(places("failing", failing), told(&[of("1"), of("2")].concat()));
}

/// So has a behaviour whose laws are wrong by themselves: two frictions through whose data no decay goes.
#[test]
fn every_law_that_is_wrong_is_told() {
    let friction = |component: u8| {
        format!(
            "*CONNECTOR FRICTION,COMPONENT={component}\n,5.\n*FRICTION,EXPONENTIAL DECAY,TEST DATA\n0.1,0.\n0.3,1.\n0.2,10.\n"
        )
    };
    let deck = format!(
        "*NODE\n1,0,0,0\n2,1,0,0\n*ORIENTATION,NAME=O\n1,0,0,0,1,0\n*ELEMENT,TYPE=CONN3D2,ELSET=E\n1,1,2\n\
         *CONNECTOR SECTION,ELSET=E,BEHAVIOR=B\nCYLINDRICAL\nO,\n*CONNECTOR BEHAVIOR,NAME=B\n{}{}",
        friction(1),
        friction(4)
    );
    let found = errors(&audited("errors-laws", &deck, "", &[]));
    let places: Vec<(&str, u32)> = found.iter().map(|(code, line, _)| (*code, *line)).collect();
    assert_eq!(places, [("deck::number-out-of-range", 12), ("deck::number-out-of-range", 18)]);
}

/// Nodes out of the plane are told each by itself, constraints that a solver does not have too.
#[test]
fn every_error_beside_the_behaviour_is_told() {
    let deck =
        "*NODE\n1,0,0,1\n2,1,0,2\n*ELEMENT,TYPE=CONN2D2,ELSET=E\n1,1,2\n*CONNECTOR SECTION,ELSET=E\nHINGE\n";
    let found = errors(&audited("errors-plane", deck, "", &[]));
    let of = |code: &str| {
        found.iter().filter(|(of, ..)| *of == code).map(|(_, line, _)| *line).collect::<Vec<_>>()
    };
    assert_eq!(of("rule::out-of-plane"), [2, 3], "{found:?}");
    assert_eq!(
        of("rule::not-in-two-dimensions").len() + of("rule::orientation-required").len(),
        found.len() - 2
    );
    let deck = "*NODE\n1,0,0,0\n2,1,0,0\n3,1,0,0\n4,5,0,0\n5,6,0,0\n6,6,0,0\n*MPC\nREVOLUTE,1,2,3\nREVOLUTE,4,5,6\n\
                *STEP\n*DYNAMIC,EXPLICIT\n,1.\n*END STEP\n";
    let found = errors(&audited("errors-explicit", deck, "", &[]));
    let lines: Vec<u32> = found.iter().map(|(_, line, _)| *line).collect();
    assert_eq!(lines, [9, 10], "{found:?}");
}

/// A friction may vanish at rest, and test data may end in no friction.
#[test]
fn frictions_that_begin_or_end_with_none_are_told() {
    let deck = |law: &str| {
        format!(
            "*NODE\n1,0,0,0\n2,1,0,0\n*ORIENTATION,NAME=O\n1,0,0,0,1,0\n*ELEMENT,TYPE=CONN3D2,ELSET=E\n1,1,2\n\
             *CONNECTOR SECTION,ELSET=E,BEHAVIOR=B\nTRANSLATOR\nO,\n*CONNECTOR BEHAVIOR,NAME=B\n\
             *CONNECTOR FRICTION,PREDEFINED\n0.05,0.1,1.\n{law}"
        )
    };
    let told = |name: &str, law: &str| -> Vec<String> {
        let report = audited(&format!("vanishing-{name}"), &deck(law), "", &[]);
        of(&report, Code::ModelFrictionVanishes).iter().map(|finding| finding.message().to_string()).collect()
    };
    let [rest, fast, never] =
        ["no friction at rest", "vanishes the faster it slips", "is zero: there is no friction"];
    for (name, law, words) in [
        ("rest", "*FRICTION,EXPONENTIAL DECAY\n0.,0.2,3.\n", vec![rest]),
        ("rest-undecayed", "*FRICTION,EXPONENTIAL DECAY\n0.,0.2,0.\n", vec![never]),
        ("fast", "*FRICTION,EXPONENTIAL DECAY\n0.2,0.,3.\n", vec![fast]),
        ("fast-undecayed", "*FRICTION,EXPONENTIAL DECAY\n0.2,0.,0.\n", vec![]),
        ("both", "*FRICTION,EXPONENTIAL DECAY\n0.,0.,3.\n", vec![never]),
        ("data-fast", "*FRICTION,EXPONENTIAL DECAY,TEST DATA\n0.3,0.\n0.1,1.\n0.,100.\n", vec![fast]),
        ("data-rest", "*FRICTION,EXPONENTIAL DECAY,TEST DATA\n0.,0.\n0.1,1.\n0.3,100.\n", vec![rest]),
        ("data", "*FRICTION,EXPONENTIAL DECAY,TEST DATA\n0.3,0.\n0.2,1.\n0.1,100.\n", vec![]),
        // 95 % of the fall at the second point: to nothing.
        ("data-open", "*FRICTION,EXPONENTIAL DECAY,TEST DATA\n0.3,0.\n0.015,1.\n", vec![fast]),
        ("table", "*FRICTION\n0.,0.\n0.2,1.\n0.,2.\n", vec![fast, rest]),
        ("table-rest", "*FRICTION\n0.,0.\n0.2,1.\n", vec![rest]),
        ("table-plain", "*FRICTION\n0.1,0.\n0.,1.\n0.2,2.\n", vec![]),
        ("table-zero", "*FRICTION\n0.,0.\n0.,1.\n", vec![never]),
        // What vanishes at one temperature, or contact force, need not at another.
        ("cold-rest", "*FRICTION\n0.,0.,,0.\n0.3,1.,,0.\n0.2,0.5,,100.\n0.4,1.,,100.\n", vec![]),
        ("all-rest", "*FRICTION\n0.,0.,,0.\n0.3,1.,,0.\n0.,0.5,,100.\n0.4,1.,,100.\n", vec![rest]),
        ("hot-fast", "*FRICTION\n0.3,0.,,0.\n0.1,1.,,0.\n0.2,0.,,100.\n0.,2.,,100.\n", vec![]),
        ("all-fast", "*FRICTION\n0.3,0.,,0.\n0.,1.,,0.\n0.2,0.,,100.\n0.,2.,,100.\n", vec![fast]),
        ("light-rest", "*FRICTION\n0.,0.,1.\n0.3,1.,1.\n0.2,0.5,5.\n0.4,1.,5.\n", vec![]),
    ] {
        let found = told(name, law);
        assert!(
            found.len() == words.len()
                && found.iter().zip(&words).all(|(found, words)| found.contains(words)),
            "{name}: {found:?}, not {words:?}"
        );
    }
}

/// Of two frictions of a behaviour each is told.
#[test]
fn each_friction_without_effect_is_told() {
    let friction = |component: u8| format!("*CONNECTOR FRICTION,COMPONENT={component}\n,5.\n*FRICTION\n0.\n");
    let deck = format!(
        "*NODE\n1,0,0,0\n2,1,0,0\n*ORIENTATION,NAME=O\n1,0,0,0,1,0\n*ELEMENT,TYPE=CONN3D2,ELSET=E\n1,1,2\n\
         *CONNECTOR SECTION,ELSET=E,BEHAVIOR=B\nCYLINDRICAL\nO,\n*CONNECTOR BEHAVIOR,NAME=B\n{}{}",
        friction(1),
        friction(4)
    );
    let report = audited("each-friction", &deck, "", &[]);
    let lines: Vec<_> =
        of(&report, Code::ModelFrictionVanishes).iter().map(|finding| finding.line()).collect();
    assert_eq!(lines, [Some(12), Some(16)]);
}

/// A SLOT of length 1 along u1, on which a behaviour with these laws acts; its first law stands at line 12.
fn slot(laws: &str) -> String {
    slots(1, laws)
}

/// The same of several, each farther from the first: `elements` from 1 to 2 long.
fn slots(elements: usize, laws: &str) -> String {
    let mut deck = String::from("*NODE\n1,0,0,0\n");
    for element in 1..=elements {
        _ = writeln!(deck, "{},{},0,0", element + 1, 1.0 + (element as f64 - 1.0) / elements as f64);
    }
    deck.push_str("*ORIENTATION,NAME=O\n1,0,0,0,1,0\n*ELEMENT,TYPE=CONN3D2,ELSET=E\n");
    for element in 1..=elements {
        _ = writeln!(deck, "{element},1,{}", element + 1);
    }
    deck + "*CONNECTOR SECTION,ELSET=E,BEHAVIOR=B\nSLOT\nO,\n*CONNECTOR BEHAVIOR,NAME=B\n" + laws
}

/// Two laws of one component are two findings, and one law of many elements is one that has them all.
#[test]
fn each_law_is_told_once_for_all_elements() {
    let laws = "*CONNECTOR LOCK,COMPONENT=1,LOCK=ALL\n0.,0.6\n*CONNECTOR FAILURE,COMPONENT=1,RELEASE=ALL\n0.,0.7\n\
                *CONNECTOR LOCK,COMPONENT=1,LOCK=1\n0.,0.8\n*CONNECTOR LOCK,COMPONENT=2,LOCK=ALL\n-1.,1.\n\
                *CONNECTOR LOCK,COMPONENT=2,LOCK=1\n-1.,1.\n";
    for elements in [1, 1000] {
        let report = audited(&format!("laws-{elements}"), &slots(elements, laws), "", &[]);
        let lines = |code: Code| -> Vec<usize> {
            let found = of(&report, code);
            let named = |finding: &&Finding| finding.about.elements.len() == elements;
            assert!(found.iter().all(named), "{code} {elements}: {found:?}");
            found.iter().map(|finding| finding.line().unwrap() as usize).collect()
        };
        let first = 12 + 2 * (elements - 1);
        // Locks come before failures.
        assert_eq!(lines(Code::ModelLockMet), [first, first + 4, first + 2], "{elements}");
        assert_eq!(lines(Code::ModelLimitUnreachable), [first + 6, first + 8], "{elements}");
    }
    let friction = |component: u8| {
        format!("*CONNECTOR FRICTION,CONTACT FORCE=1\n*CONNECTOR POTENTIAL\n{component}\n*FRICTION\n0.\n")
    };
    let deck = slot(&(friction(2) + &friction(3))).replace("SLOT", "SLIDE-PLANE");
    let report = audited("laws-friction", &deck, "", &[]);
    let lines: Vec<_> =
        of(&report, Code::ModelFrictionVanishes).iter().map(|finding| finding.line()).collect();
    assert_eq!(lines, [Some(12), Some(17)]);
}

/// Limits that depend on the temperature are passed, or never reached, at every temperature, or this is said of those at which they are.
#[test]
fn limits_are_looked_at_in_every_row() {
    let told = |name: &str, law: &str| -> Vec<(Code, Severity, String)> {
        let report = audited(&format!("rows-{name}"), &slot(law), "", &[]);
        let found = report.findings.iter();
        let found =
            found.filter(|one| [Code::ModelLockMet, Code::ModelLimitUnreachable].contains(&one.code()));
        found.map(|one| (one.code(), one.severity(), one.message().to_string())).collect()
    };
    let [met, unreachable] = [Code::ModelLockMet, Code::ModelLimitUnreachable];
    let of_temperature = "0.5 beyond the limit 0.5 of a lock, which acts from the start at temperature 100";
    let of_field = "2 beyond the limit 2 of a lock, which acts from the start at temperature 100 and field variable 1 of 3, but";
    for (name, law, wanted) in [
        (
            "idle",
            "COMPONENT=2\n-1.,1.,,,0.\n-0.5,1.,,,100.\n",
            Some((unreachable, Severity::Warning, "within")),
        ),
        // Beyond the rows limits go on: 0 is beyond them at a temperature of 200.
        ("far", "COMPONENT=2,EXTRAPOLATION=LINEAR\n-1.,1.,,,0.\n-0.5,1.,,,100.\n", None),
        (
            "equal",
            "COMPONENT=2,EXTRAPOLATION=LINEAR\n-1.,1.,,,0.\n-1.,1.,,,100.\n",
            Some((unreachable, Severity::Warning, "within")),
        ),
        ("hot", "COMPONENT=2\n-1.,1.,,,0.\n0.5,1.,,,100.\n", Some((met, Severity::Note, of_temperature))),
        ("free", "COMPONENT=1\n0.,3.,,,0.\n0.,0.5,,,100.\n", Some((met, Severity::Note, of_temperature))),
        ("none", "COMPONENT=1\n0.,3.,,,0.\n0.,1.5,,,100.\n", None),
        (
            "field",
            "COMPONENT=2,DEPENDENCIES=1\n-1.,1.,,,0.,3.\n2.,3.,,,100.,3.\n",
            Some((met, Severity::Note, of_field)),
        ),
        (
            "always",
            "COMPONENT=1\n0.,0.5,,,0.\n0.,0.75,,,100.\n",
            Some((met, Severity::Warning, "0.25 beyond the limit 0.75 of a lock, which acts from the start")),
        ),
        // Between 0 and 100 the position lies within.
        (
            "sides",
            "COMPONENT=1\n0.,0.5,,,0.\n2.,3.,,,100.\n",
            Some((
                met,
                Severity::Note,
                "1 beyond the limit 2 of a lock, which acts from the start at temperature 100",
            )),
        ),
    ] {
        let found = told(name, &format!("*CONNECTOR LOCK,{law}"));
        let is_wanted = match (found.as_slice(), wanted) {
            ([], None) => true,
            ([(code, severity, said)], Some((of, bad, words))) => {
                let is_conditional = said.contains("but not always");
                (*code, *severity) == (of, bad)
                    && said.contains(words)
                    && is_conditional == (bad == Severity::Note)
            }
            _ => false,
        };
        assert!(is_wanted, "{name}: {found:?}, not {wanted:?}");
    }
}

/// A rule points at the lock that has a temperature, and at the orientation of the system that it does not have.
#[test]
fn rules_point_at_what_breaks_them() {
    let steps = "*STEP\n*DYNAMIC,EXPLICIT\n,1.\n*END STEP\n";
    let locks = "*CONNECTOR LOCK,COMPONENT=1\n0.,3.\n*CONNECTOR LOCK,COMPONENT=1,LOCK=1\n0.,3.,,,20.\n";
    let report = audited("rule-lock", &slot(&format!("{locks}{steps}")), "", &[]);
    let lines: Vec<_> = of(&report, Code::LockVelocity).iter().map(|finding| finding.line()).collect();
    assert_eq!(lines, [Some(14)]);
    for (names, wanted) in
        [("O,Z", vec!["Z"]), ("Z,O", vec!["Z"]), ("Z,Y", vec!["Z", "Y"]), ("O,O", Vec::new())]
    {
        let deck = format!(
            "*NODE\n1,0,0,0\n2,1,0,0\n*ORIENTATION,NAME=O\n1,0,0,0,1,0\n*ORIENTATION,NAME=Z,SYSTEM=Z RECTANGULAR\n0,0,1,1,0,0\n\
             *ORIENTATION,NAME=Y,SYSTEM=Z RECTANGULAR\n0,0,1,1,0,0\n*ELEMENT,TYPE=CONN3D2,ELSET=E\n1,1,2\n\
             *CONNECTOR SECTION,ELSET=E\nCARTESIAN,CARDAN\n{names}\n{steps}"
        );
        let report = audited(&format!("rule-{}", names.replace(',', "-")), &deck, "", &[]);
        let found = of(&report, Code::ZRectangularNotInExplicit);
        let said: Vec<&str> = found.iter().map(|finding| finding.message()).collect();
        assert_eq!(said.len(), wanted.len(), "{names}: {said:?}");
        for ((finding, said), name) in found.iter().zip(said).zip(wanted) {
            assert!(said.ends_with(&format!("(orientation {name})")), "{names}: {said}");
            assert_eq!(finding.line(), Some(14), "{names}");
        }
    }
}

/// What is placed on its stop does not lie beyond it for rounding, in any frame and at any distance from the origin. What lies beyond by less
/// than the digits of the numbers is a note.
#[test]
fn what_lies_on_its_stop_is_not_beyond() {
    let deck = |a: &str, b: &str, orientation: &str, limits: &str| {
        format!(
            "*NODE\n1,{a}\n2,{b}\n*ORIENTATION,NAME=O\n{orientation}\n*ELEMENT,TYPE=CONN3D2,ELSET=E\n1,1,2\n\
             *CONNECTOR SECTION,ELSET=E,BEHAVIOR=B\nSLOT\nO,\n*CONNECTOR BEHAVIOR,NAME=B\n*CONNECTOR STOP,COMPONENT=1\n{limits}\n\
             *CONNECTOR LOCK,COMPONENT=1,LOCK=1\n{limits}\n"
        )
    };
    let along = "1,0,0,0,1,0";
    let oblique = "1,1,0,-1,1,0";
    for (name, deck, severity) in [
        ("rounded", deck("0.5,0,0", "0.6,0,0", along, "0.1,0.1"), None),
        ("far", deck("1000000.1,0,0", "1000000.4,0,0", along, "0.3,0.3"), None),
        ("minus", deck("0.7,0,0", "0.4,0,0", along, "-0.3,-0.3"), None),
        // 8.9e-16 beyond is 8 roundings: of no coordinate.
        ("beyond", deck("0,0,0", "0.5,0,0", along, "0.1,0.499999999999999"), Some(Severity::Warning)),
        (
            "beyond-far",
            deck("1000000.1,0,0", "1000000.4,0,0", along, "0.1,0.2999999"),
            Some(Severity::Warning),
        ),
        // √½ to six decimals, along the diagonal; and to 16.
        (
            "digits",
            deck("0.353553,0.353553,0", "0.707107,0.707107,0", oblique, "0.2,0.5"),
            Some(Severity::Note),
        ),
        (
            "exact",
            deck(
                "0.35355339059327379,0.35355339059327379,0",
                "0.70710678118654757,0.70710678118654757,0",
                oblique,
                "0.5,0.5",
            ),
            None,
        ),
        // The limit is written with as many digits as it has.
        ("limit", deck("0,0,0", "0.66666666666666663,0,0", along, "0.66667,0.9"), Some(Severity::Note)),
        ("nominal", deck("0,0,0", "0.51,0,0", along, "0.1,0.5"), Some(Severity::Warning)),
    ] {
        let report = audited(&format!("stop-{name}"), &deck, "", &[]);
        for code in [Code::ModelStopViolated, Code::ModelLockMet] {
            let found: Vec<Severity> = of(&report, code).iter().map(|finding| finding.severity()).collect();
            assert_eq!(found, Vec::from_iter(severity), "{name} {code}");
        }
        let said = |finding: &&Finding| finding.message().contains("digits of the coordinates");
        let is_open = of(&report, Code::ModelStopViolated).iter().any(said);
        assert_eq!(is_open, severity == Some(Severity::Note), "{name}");
    }
    // A state that carries it to the stop.
    let states = "state,node,u1\n0,1,0.1\n0,2,0.3\n";
    let at = |limits: &str| {
        let report = audited("stop-state", &deck("0,0,0", "0.1,0,0", along, limits), states, &[]);
        of(&report, Code::ModelStopViolated).len()
    };
    assert_eq!([at("0,0.3"), at("0,0.299999999")], [0, 1]);
}

/// A stop is told at its own data line, whatever else the behaviour has, and each of several.
#[test]
fn stops_are_told_at_their_own_lines() {
    let deck = "*NODE\n1,0,0,0\n2,1,2,0\n*ELEMENT,TYPE=CONN3D2,ELSET=E\n1,1,2\n*CONNECTOR SECTION,ELSET=E,BEHAVIOR=B\nCARTESIAN\n\
                *CONNECTOR BEHAVIOR,NAME=B\n*CONNECTOR ELASTICITY,COMPONENT=1\n5.\n*CONNECTOR STOP,COMPONENT=1\n-0.5,0.5\n\
                *CONNECTOR DAMPING,COMPONENT=1\n1.\n** a comment\n*CONNECTOR STOP,COMPONENT=2\n** another\n-1,1\n*BOUNDARY\n1,1,6\n";
    let report = audited("stop-lines", deck, "", &[]);
    let lines: Vec<Option<u32>> =
        of(&report, Code::ModelStopViolated).iter().map(|finding| finding.line()).collect();
    assert_eq!(lines, [Some(12), Some(18)]);
}

/// What states move of what boundary conditions of their step hold is told once for the step, of the worst.
#[test]
fn held_nodes_that_move_are_told() {
    let deck = "*NODE,NSET=ALL\n1,0,0,0\n2,0,0,0\n3,1,0,0\n4,1,0,0\n*ORIENTATION,NAME=O\n0,0,1,1,0,0\n*ELEMENT,TYPE=CONN3D2,ELSET=E\n1,1,2\n2,3,4\n\
                *CONNECTOR SECTION,ELSET=E\nHINGE\nO,\n*NSET,NSET=H\n1,3\n*BOUNDARY\nH,1,6\n*STEP\n*STATIC\n1.,1.\n*END STEP\n\
                *STEP\n*STATIC\n1.,1.\n*BOUNDARY,OP=NEW\n1,1,6\n*END STEP\n";
    let told = |name: &str, states: &str| -> Vec<(Option<u32>, String)> {
        let report = audited(&format!("moves-{name}"), deck, states, &[]);
        let one = |finding: &&Finding| (finding.line(), finding.message().to_string());
        of(&report, Code::ModelHeldNodeMoves).iter().map(one).collect()
    };
    let found =
        told("both", "state,time,node,u1,ur3\n0,0,1,0.5,0\n0,0,3,0,0.25\n1,0.5,1,0.75,0\n1,0.5,2,9,0\n");
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(found[0].0, Some(17));
    assert!(
        found[0].1.starts_with(
            "state 1 moves node 1 by 0.75 in degree of freedom 1, which a boundary condition holds"
        ) && found[0].1.ends_with("(and so on for 1 other node and 1 other state)"),
        "{found:?}"
    );
    let found = told("turned", "state,time,node,u1,ur3\n0,0,3,0,0.25\n");
    assert!(
        found.len() == 1 && found[0].1.contains("turns node 3 by 0.25 rad in degree of freedom 6"),
        "{found:?}"
    );
    // In the second step node 3 is free, and node 1 is held by another line.
    assert_eq!(told("free", "state,time,node,u1,ur3\n0,1.5,3,0.25,0\n"), []);
    assert_eq!(told("again", "state,time,node,u1,ur3\n0,1.5,1,0.25,0\n")[0].0, Some(26));
    // What solvers leave is none.
    assert_eq!(told("left", "state,time,node,u1,ur3\n0,0,1,1e-5,0\n0,0,3,0,1e-5\n"), []);
}

/// The messages of what boundary conditions hold and states move, and how much is undecided of the assembly.
fn moved_of(name: &str, deck: &str, states: &str) -> (Vec<String>, usize) {
    let report = audited(&format!("moved-{name}"), deck, states, &[]);
    let found = of(&report, Code::ModelHeldNodeMoves);
    let messages = found.iter().map(|finding| finding.message().to_string()).collect();
    (messages, of(&report, Code::AssemblyUndecided).len())
}

/// A degree of freedom is held at zero only where it never was elsewhere.
#[test]
fn what_was_moved_is_not_held_at_zero() {
    let deck = |first: &str, second: &str, procedure: &str| {
        format!(
            "*NODE\n1,0,0,0\n2,1,0,0\n*ORIENTATION,NAME=O\n1,0,0,0,1,0\n*AMPLITUDE,NAME=F\n0,0,1,1\n\
             *AMPLITUDE,NAME=V,VALUE=ABSOLUTE\n0,0,1,0.5\n*ELEMENT,TYPE=CONN3D2,ELSET=E\n1,1,2\n\
             *CONNECTOR SECTION,ELSET=E\nSLOT\nO,\n*BOUNDARY\n1,1,6\n*STEP\n{procedure}\n0.1,1.\n{first}*END STEP\n\
             *STEP\n{procedure}\n0.1,1.\n{second}*END STEP\n"
        )
    };
    let zero = "*BOUNDARY\n2,1,1\n";
    let away = "*BOUNDARY\n2,1,1,0.5\n";
    let fixed = "*BOUNDARY,FIXED\n2,1,1\n";
    let [renewed, freed] = ["*BOUNDARY,OP=NEW\n1,1,6\n2,1,1\n", "*BOUNDARY,OP=NEW\n1,1,6\n"];
    let factor = "*BOUNDARY,AMPLITUDE=F\n2,1,1\n";
    let absolute = "*BOUNDARY,AMPLITUDE=V\n2,1,1\n";
    let user = "*BOUNDARY,USER\n2,1,1\n";
    let second = "state,time,node,u1\n0,1.5,2,0.25\n";
    let unknown = "state,node,u1\n0,2,0.25\n";
    for (name, first, then, states, is_held) in [
        ("back", away, zero, second, false),
        ("fixed-away", away, fixed, second, false),
        ("renewed-away", away, renewed, second, false),
        ("free", "", zero, second, false),
        ("free-fixed", "", fixed, second, false),
        ("absolute", absolute, "", second, false),
        ("user", user, "", second, false),
        ("freed", zero, freed, second, false),
        ("later", zero, away, second, false),
        ("later-unknown", zero, away, unknown, false),
        ("zero", zero, "", second, true),
        ("unknown", zero, "", unknown, true),
        ("again", zero, zero, second, true),
        ("fixed", zero, fixed, second, true),
        ("fixed-first", fixed, "", second, true),
        ("renewed", zero, renewed, second, true),
        ("factor", factor, "", second, true),
    ] {
        let (messages, undecided) = moved_of(name, &deck(first, then, "*STATIC"), states);
        let wanted = usize::from(is_held);
        assert_eq!((messages.len(), undecided), (wanted, wanted), "{name}: {messages:?}");
    }
    // The same of connector motions: the component is not zero before the step ends.
    let motion = |text: &str| format!("*CONNECTOR MOTION{text}\n");
    for (name, first, then, is_held) in [
        ("motion-back", motion("\n1,1,0.5"), motion("\n1,1,0"), false),
        ("motion-fixed-away", motion("\n1,1,0.5"), motion(",FIXED\n1,1"), false),
        ("motion-zero", motion("\n1,1,0"), motion("\n1,1,0"), true),
    ] {
        let (messages, undecided) = moved_of(name, &deck(&first, &then, "*STATIC"), second);
        assert_eq!((messages.len(), undecided), (0, usize::from(is_held)), "{name}: {messages:?}");
    }
    // In Explicit velocities and accelerations of zero hold too, from rest.
    let of = |kind: &str, magnitude: f64| format!("*BOUNDARY,TYPE={kind}\n2,1,1,{magnitude}\n");
    let explicit = "*DYNAMIC,EXPLICIT";
    let timeless = deck("", "", explicit).replace("0.1,1.", ",1.");
    let of_explicit = |first: &str, then: &str| {
        let (before, after) = timeless.split_once("*END STEP\n*STEP").unwrap();
        let after = after.replace("*END STEP", &format!("{then}*END STEP"));
        format!("{before}{first}*END STEP\n*STEP{after}")
    };
    let launched =
        |deck: String| deck.replacen("*STEP", "*INITIAL CONDITIONS,TYPE=VELOCITY\n2,1,3.\n*STEP", 1);
    let at_rest = of("VELOCITY", 0.0);
    for (name, deck, is_held) in [
        ("velocity", of_explicit(&at_rest, ""), true),
        ("acceleration", of_explicit(&of("ACCELERATION", 0.0), ""), true),
        ("stopped", of_explicit(&of("VELOCITY", 0.25), &at_rest), false),
        ("launched", launched(of_explicit(&of("ACCELERATION", 0.0), "")), false),
        ("launched-held", launched(of_explicit(&at_rest, "")), true),
    ] {
        let (messages, undecided) = moved_of(name, &deck, second);
        let wanted = usize::from(is_held);
        assert_eq!((messages.len(), undecided), (wanted, wanted), "{name}: {messages:?}");
    }
}

/// A rotation of which one component is held is told where the node turns about that axis alone.
#[test]
fn a_turn_about_a_held_axis_is_told() {
    let spatial = |transform: &str, held: &str| {
        format!(
            "*NODE,NSET=ALL\n1,0,0,0\n2,1,0,0\n*ORIENTATION,NAME=O\n1,0,0,0,1,0\n{transform}*ELEMENT,TYPE=CONN3D2,ELSET=E\n1,1,2\n\
             *CONNECTOR SECTION,ELSET=E\nCARTESIAN,CARDAN\nO,\n*BOUNDARY\n1,1,6\n{held}\n"
        )
    };
    let planar = "*NODE\n1,0,0\n2,1,0\n*ELEMENT,TYPE=CONN2D2,ELSET=E\n1,1,2\n*CONNECTOR SECTION,ELSET=E\nCARTESIAN,ROTATION\n\
                  *BOUNDARY\n1,1,2\n1,6\n2,6\n";
    let states = |turn: &str| format!("state,node,ur1,ur2,ur3\n0,2,{turn}\n");
    // The axis 1 of node 2 lies along the diagonal, to six digits.
    let diagonal = "*TRANSFORM,NSET=ALL\n1,1,0,-1,1,0\n";
    for (name, deck, turn, told) in [
        ("plane", planar.to_string(), "0,0,0.3", Some("turns node 2 by 0.3 rad in degree of freedom 6")),
        ("axis", spatial("", "2,4"), "0.5,0,0", Some("turns node 2 by 0.5 rad in degree of freedom 4")),
        (
            "transform",
            spatial(diagonal, "2,4"),
            "0.353553,0.353553,0",
            Some("turns node 2 by 0.5 rad in degree of freedom 4"),
        ),
        ("two", spatial("", "2,4,5"), "0.5,0,0.1", Some("turns node 2 by 0.5 rad in degree of freedom 4")),
        ("others", spatial("", "2,4"), "0.5,0.1,0", None),
        ("other", spatial("", "2,4"), "0,0.5,0", None),
        ("transform-others", spatial(diagonal, "2,4"), "0.5,0,0", None),
    ] {
        let (messages, _) = moved_of(name, &deck, &states(turn));
        assert_eq!(messages.len(), usize::from(told.is_some()), "{name}: {messages:?}");
        assert!(told.is_none_or(|told| messages[0].contains(told)), "{name}: {messages:?}");
    }
}

/// A deck of one connector with a stop: its nodes, what else stands beside them, its type with orientations, and the component and limit of the stop. The nodes
/// are those of a part, where an instance is given.
fn stopped(nodes: &str, beside: &str, of: &str, stop: &str, instance: Option<&str>) -> String {
    let (component, limit) = stop.split_once(' ').unwrap();
    let level = format!(
        "{nodes}\n{beside}*ELEMENT,TYPE=CONN3D2,ELSET=E\n101,1,2\n*CONNECTOR SECTION,ELSET=E,BEHAVIOR=B\n{of}\n"
    );
    let level = match instance {
        None => level,
        Some(placed) => format!(
            "*PART,NAME=P\n{level}*END PART\n*ASSEMBLY,NAME=A\n*INSTANCE,NAME=I,PART=P\n{placed}*END INSTANCE\n*END ASSEMBLY\n"
        ),
    };
    level + &format!("*CONNECTOR BEHAVIOR,NAME=B\n*CONNECTOR STOP,COMPONENT={component}\n0,{limit}\n")
}

/// The severities of what is found of the stop of such a deck.
fn of_stop(name: &str, deck: &str, states: &str) -> Vec<Severity> {
    let report = audited(&format!("written-{name}"), deck, states, &[]);
    of(&report, Code::ModelStopViolated).iter().map(|finding| finding.severity()).collect()
}

/// Coordinates are as exact as the numbers that they were read as, by rounding and by digits, wherever an instance puts them, whatever their system.
#[test]
fn coordinates_are_as_exact_as_they_are_written() {
    const NOTHING: &[Severity] = &[];
    const NOTE: &[Severity] = &[Severity::Note];
    const WARNING: &[Severity] = &[Severity::Warning];
    let turn = "0,0,0\n0,0,0,0,0,1,30.\n";
    let far = "*NODE\n1,1000.,0,0\n2,1001.1,0,0";
    // As far from the origin as it was in its part, 2.3e-14 is rounding; and no more than that.
    for (name, instance, limit, want) in [
        ("back", "-1000.,0,0\n", "1 1.1", NOTHING),
        ("back-beyond", "-1000.,0,0\n", "1 1.0999999", WARNING),
        ("back-turned", "-1000.,0,0\n0,0,0,0,0,1,30.\n", "1 1.1", NOTHING),
        ("about", "0,0,0\n1000.,0,0,1000.,0,1,30.\n", "1 1.1", NOTHING),
    ] {
        assert_eq!(of_stop(name, &stopped(far, "", "AXIAL", limit, Some(instance)), ""), want, "{name}");
    }
    let near = "*NODE\n1,0.1,0,0\n2,1.2000000000001,0,0";
    assert_eq!(of_stop("near", &stopped(near, "", "AXIAL", "1 1.1", Some("5,0,0\n")), ""), NOTE);
    let short = "*NODE\n1,0.1234,0.5678,0\n2,0.8306,1.2749,0";
    let long = "*NODE\n1,0.1234000000000001,0.5678000000000001,0\n2,0.8306000000000001,1.2749000000000001,0";
    let polar = "*NODE,SYSTEM=C\n1,0.5000,33.12,0\n2,0.5001,213.12,0\n3,0.4444,11.11,0.1111";
    let whole = "*NODE,SYSTEM=C\n1,1,30,0\n2,1,120,0";
    for (name, nodes, instance, limit, want) in [
        ("short", short, None, "1 1.", NOTE),
        ("short-moved", short, Some("0.1,0,0\n"), "1 1.", NOTE),
        ("short-turned", short, Some(turn), "1 1.", NOTE),
        ("short-turned-beyond", short, Some(turn), "1 0.9998", WARNING),
        ("long-turned", long, Some(turn), "1 1.", WARNING),
        ("polar", polar, None, "1 1.", NOTE),
        ("polar-beyond", polar, None, "1 0.9996", WARNING),
        ("polar-turned", polar, Some(turn), "1 1.", NOTE),
        ("polar-whole", whole, None, "1 1.4", WARNING),
        ("polar-whole-root", whole, None, "1 1.4142135623730951", NOTHING),
    ] {
        assert_eq!(of_stop(name, &stopped(nodes, "", "AXIAL", limit, instance), ""), want, "{name}");
    }
}

/// Directions are as exact as the numbers behind them: of the nodes that an orientation names, of its points in the part of an instance, of its additional rotation.
#[test]
fn directions_are_as_exact_as_they_are_written() {
    let nodes = "*NODE\n1,0,0,0\n2,0,0,0\n11,1.,0,0\n12,0,1.,0\n13,0,0.8660,0.5001";
    let exact = "*NODE\n1,0,0,0\n2,0,0,0\n11,1.,0,0\n12,0,1.,0\n13,0,0.8660000000000001,0.5001000000000001";
    let by_nodes =
        "*ORIENTATION,NAME=OA,DEFINITION=NODES\n11,12,1\n*ORIENTATION,NAME=OB,DEFINITION=NODES\n11,13,1\n";
    let by_origin =
        "*ORIENTATION,NAME=OA,DEFINITION=NODES\n11,12\n*ORIENTATION,NAME=OB,DEFINITION=NODES\n11,13\n";
    let by_points = "*ORIENTATION,NAME=OA\n1.,0,0,0,1.,0\n*ORIENTATION,NAME=OB\n1.,0,0,0,0.8660,0.5001\n";
    let by_angle = "*ORIENTATION,NAME=OA\n1,0,0,0,1,0\n*ORIENTATION,NAME=OB\n1,0,0,0,1,0\n1,33.33\n";
    let by_whole = "*ORIENTATION,NAME=OA\n1,0,0,0,1,0\n*ORIENTATION,NAME=OB\n1,0,0,0,1,0\n1,30.\n";
    let turn = Some("0,0,0\n1,2,3,2,2,4,30.\n");
    let (note, warning) = (Severity::Note, Severity::Warning);
    for (name, nodes, beside, instance, limit, want) in [
        ("points", nodes, by_points, None, "4 0.5235988", note),
        ("points-turned", nodes, by_points, turn, "4 0.5235988", note),
        ("nodes", nodes, by_nodes, None, "4 0.5235988", note),
        ("nodes-beyond", nodes, by_nodes, None, "4 0.52", warning),
        ("nodes-turned", nodes, by_nodes, turn, "4 0.5235988", note),
        ("nodes-exact", exact, by_nodes, None, "4 0.5235988", warning),
        ("origin", nodes, by_origin, None, "4 0.5235988", note),
        ("origin-turned", nodes, by_origin, turn, "4 0.5235988", note),
        ("angle", nodes, by_angle, None, "4 0.58168", note),
        ("angle-beyond", nodes, by_angle, None, "4 0.58", warning),
        ("angle-whole", nodes, by_whole, None, "4 0.5235", warning),
    ] {
        let deck = stopped(nodes, beside, "HINGE\nOA,OB", limit, instance);
        assert_eq!(of_stop(&format!("directions-{name}"), &deck, ""), [want], "{name}");
    }
}

/// A state of seven digits is one of single precision: its last digit is no finding.
#[test]
fn states_are_as_exact_as_they_are_written() {
    let orientation = "*ORIENTATION,NAME=O\n1,0,0,0,1,0\n";
    let slot = stopped("*NODE\n1,0,0,0\n2,0,0,0", orientation, "SLOT\nO,", "1 0.3", None);
    let hinge = stopped("*NODE\n1,0,0,0\n2,0,0,0", orientation, "HINGE\nO,", "4 0.3", None);
    let turned = |q: &str| format!("node,q0,q1,q2,q3\n2,{q},0,0\n");
    for (name, deck, states, want) in [
        ("seven", &slot, "node,u1\n2,0.3000001\n".to_owned(), Severity::Note),
        ("seven-beyond", &slot, "node,u1\n2,0.3000002\n".to_owned(), Severity::Warning),
        ("six", &slot, "node,u1\n2,0.300001\n".to_owned(), Severity::Warning),
        ("few", &slot, "node,u1\n2,0.301\n".to_owned(), Severity::Warning),
        (
            "all",
            &slot,
            "node,u1\n2,0.30000010000000001\n3,0.1234567890123456\n".to_owned(),
            Severity::Warning,
        ),
        ("angle", &hinge, "node,ur1\n2,0.3000001\n".to_owned(), Severity::Note),
        ("angle-beyond", &hinge, "node,ur1\n2,0.3000002\n".to_owned(), Severity::Warning),
        // sin 0.15 = 0.14943813247…
        ("quaternion", &hinge, turned("0.9887711,0.1494382"), Severity::Note),
        ("quaternion-beyond", &hinge, turned("0.9887710,0.1494387"), Severity::Warning),
    ] {
        let nodes =
            if name == "all" { deck.replace("\n2,0,0,0", "\n2,0,0,0\n3,0,0,0") } else { deck.clone() };
        assert_eq!(of_stop(&format!("state-{name}"), &nodes, &states), [want], "{name}");
    }
}

/// A connector motion of zero holds where nothing moved the component before: of a velocity in Explicit; what any earlier step drove is driven back.
#[test]
fn what_a_connector_motion_holds_and_what_it_drives() {
    const SLOT: &str = "*NODE\n1,0,0,0\n2,1,0,0\n*ORIENTATION,NAME=O\n1,0,0,0,1,0\n*ELEMENT,TYPE=CONN3D2,ELSET=S\n101,1,2\n\
                        *CONNECTOR SECTION,ELSET=S\nSLOT\nO,\n*BOUNDARY\n1,1,6\n";
    let step = |procedure: &str, motion: &str| format!("*STEP\n*{procedure}\n,1.\n{motion}*END STEP\n");
    let motion = |options: &str, by: f64| format!("*CONNECTOR MOTION{options}\n101,1,{by}\n");
    // Constraints and drives of the first step, and of each that prescribes something else.
    let told = |name: &str, steps: &[String]| -> Vec<[usize; 2]> {
        let report = audited(name, &(SLOT.to_owned() + &steps.concat()), "", &[]);
        report
            .assembly
            .iter()
            .chain(&report.later_steps)
            .map(|step| [step.constraints, step.drives])
            .collect()
    };
    let velocity = |by: f64| motion(",TYPE=VELOCITY", by);
    assert_eq!(told("motion-explicit", &[step("DYNAMIC,EXPLICIT", &velocity(0.0))]), [[3, 0]]);
    assert_eq!(told("motion-fast", &[step("DYNAMIC,EXPLICIT", &velocity(0.5))]), [[2, 1]]);
    assert_eq!(told("motion-static", &[step("STATIC", &motion("", 0.0))]), [[3, 0]]);
    let back = [
        step("STATIC", &motion("", 0.5)),
        step("STATIC", "*CONNECTOR MOTION,OP=NEW\n"),
        step("STATIC", &motion("", 0.0)),
    ];
    assert_eq!(told("motion-back", &back), [[2, 1], [2, 0], [2, 1]]);
}

/// A warning of the boundary condition of a node names the connector, in what it is about too.
#[test]
fn a_rotation_that_a_node_lacks_is_of_its_connector() {
    let deck = "*NODE\n1,0,0,0\n2,1,0,0\n*ELEMENT,TYPE=CONN3D2,ELSET=S\n101,1,2\n*CONNECTOR SECTION,ELSET=S\nLINK\n*BOUNDARY\n1,1,3\n*STEP\n*STATIC\n*BOUNDARY\n2,4,4,0.5\n*END STEP\n";
    let report = audited("no-rotation", deck, "", &[]);
    let [finding] = of(&report, Code::NoRotation)[..] else { panic!("{:?}", report.findings) };
    assert_eq!(finding.about.elements, [101]);
}

/// A spin of 2.5 rad a state passes 30 rad, which is no degree: rates prove it, and without them it hides nothing else.
#[test]
fn round_numbers_of_radians_hide_nothing() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ORIENTATION, NAME=O\n0., 0., 1., 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=H\n10, 1, 2\n\
                *CONNECTOR SECTION, ELSET=H\nHINGE\nO,\n";
    let table = |rate: &str, off: usize| {
        let mut text = String::from("state,time,node,u1,ur3,vr3\n");
        for i in 0..40 {
            let shifted = if i == off { 0.5 } else { 0.0 };
            let _ = writeln!(text, "{i},{},2,{shifted},{},{rate}", 0.1 * i as f64, 2.5 * i as f64);
        }
        text
    };
    let found = |name: &str, states: &str, levels: &[(&str, Level)]| {
        let report = audited(name, deck, states, levels);
        [Code::ModelDegrees, Code::ModelConstraintViolated].map(|code| of(&report, code).len())
    };
    assert_eq!(found("spin", &table("25.", 20), &[]), [0, 1]);
    assert_eq!(found("spin-unknown", &table("0.", 20), &[]), [1, 1]);
    let degrees = "state,node,u1,ur3\n0,2,0.,0.\n1,2,0.5,30.\n2,2,0.,60.\n3,2,0.,90.\n";
    assert_eq!(found("degrees", degrees, &[]), [1, 0]);
    assert_eq!(found("degrees-allowed", degrees, &[("model::degrees", Level::Allow)]), [0, 1]);
}

/// What is driven too much is told where it is driven.
#[test]
fn a_motion_too_many_has_its_line() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=H\n10, 1, 2\n\
                *ELEMENT, TYPE=CONN3D2, ELSET=K\n11, 1, 2\n*CONNECTOR SECTION, ELSET=H\nTRANSLATOR\nO,\n*CONNECTOR SECTION, ELSET=K\nAXIAL\n\
                *STEP\n*STATIC\n*BOUNDARY\n1, 1, 6\n*CONNECTOR MOTION\n10, 1, 0.5\n11, 1, 0.2\n*END STEP\n";
    let report = audited("overdriven", deck, "", &[]);
    let lines: Vec<_> = of(&report, Code::AssemblyOverdriven).iter().map(|finding| finding.line()).collect();
    assert!(matches!(lines[..], [Some(20 | 21)]), "{lines:?}");
}
