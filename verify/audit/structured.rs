//! Structured states, as models have them: one axis turns, shafts are aligned, forces are exactly zero. What is right there is not called
//! wrong, what is wrong is found, and what nobody can say is said to be so.

use crate::commands::cli::{pintle, stdout};
use pintle_audit::Settings;
use std::fs;
use std::path::PathBuf;

/// A deck with one element between two nodes, and states of it, as files.
fn files(name: &str, section: &str, states: &str) -> [String; 2] {
    let deck = format!(
        "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n\
         *ELEMENT, TYPE=CONN3D2, ELSET=E\n101, 1, 2\n*CONNECTOR SECTION, ELSET=E{section}"
    );
    written(name, &deck, states)
}

fn written(name: &str, deck: &str, states: &str) -> [String; 2] {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    let of = |ending: &str, text: &str| {
        let path = folder.join(format!("structured-{name}.{ending}"));
        fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_string()
    };
    [of("inp", deck), of("csv", states)]
}

/// The report of an audit that ends with this code.
fn report([deck, states]: &[String; 2], more: &[&str], code: i32) -> String {
    stdout(&pintle(&[&["audit", deck, "--at", states], more].concat()).assert().code(code))
}

/// The same as JSON, of one subject.
fn subject(given: &[String; 2], more: &[&str], code: i32) -> serde_json::Value {
    let text = report(given, &[more, &["--format", "json"]].concat(), code);
    let found: serde_json::Value = serde_json::from_str(&text).unwrap();
    found["subjects"][0].clone()
}

/// The check of a quantity against an oracle.
fn check<'a>(subject: &'a serde_json::Value, quantity: &str, oracle: &str) -> &'a serde_json::Value {
    let all = subject["checks"].as_array().unwrap();
    let is_it = |check: &&serde_json::Value| {
        check["quantity"] == quantity && check["against"].to_string().contains(oracle)
    };
    all.iter().find(is_it).unwrap_or_else(|| panic!("{quantity} against {oracle}"))
}

/// States of node 2 turned about one axis by these angles, one after the other.
fn turned(axis: usize, angles: &[f64]) -> String {
    let mut text = String::from("state,time,node,ur1,ur2,ur3\n");
    for (i, angle) in angles.iter().enumerate() {
        let mut turn = [0.0; 3];
        turn[axis] = *angle;
        text += &format!("{i},{i},2,{:?},{:?},{:?}\n", turn[0], turn[1], turn[2]);
    }
    text
}

/// Nodes that turn alike stand to each other as before: where shafts are aligned a flexion is zero but for what rounding leaves of the triads.
#[test]
fn a_turn_of_everything_is_no_mistake() {
    let mut text = String::from("state,time,node,ur1,ur2,ur3\n");
    for i in 0..60 {
        let [x, y, z] = [0.37, 0.59, 0.83].map(|step| 2.9 * (f64::from(i) * step).sin());
        for node in [1, 2] {
            text += &format!("{i},{i},{node},{x:?},{y:?},{z:?}\n");
        }
    }
    for section in
        ["FLEXION-TORSION", "RADIAL-THRUST, FLEXION-TORSION", "PROJECTION FLEXION-TORSION", "EULER"]
    {
        let given = files("together", &format!("\n{section}\nO, O\n"), &text);
        report(&given, &["--wide-states", "60"], 0);
    }
    report(&files("together-wrong", "\nFLEXION-TORSION\nO, O\n", &text), &["--plant", "lost-component"], 1);
}

/// b on the axis of a RADIAL-THRUST but for rounding, as a half turn about a diagonal leaves it, is on the axis.
#[test]
fn rounding_does_not_hold_a_node_off_its_axis() {
    let half = std::f64::consts::PI / 2.0_f64.sqrt();
    let states = format!("state,time,node,ur1,ur2,ur3\n0,0.,1,{half:?},0.,{half:?}\n");
    let given = files("axis", "\nRADIAL-THRUST\nO, O\n", &states);
    let found = subject(&given, &[], 0);
    assert_eq!(check(&found, "first-derivatives", "wide-differences")["verdict"], "singular");
    // Its radius is known all the same.
    assert_eq!(check(&found, "value", "wide-differences")["verdict"], "pass");
}

/// On a singular set, too, what is formed of lengths whose powers leave the range of doubles is undecided.
#[test]
fn overflow_on_a_singular_set_is_undecided() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 1e300, 3e299, 2e299\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n\
                *ELEMENT, TYPE=CONN3D2, ELSET=E\n101, 1, 2\n*CONNECTOR SECTION, ELSET=E\nPROJECTION CARTESIAN\nO, O\n";
    let given = written("overflow-on-a-set", deck, &turned(0, &[std::f64::consts::PI; 2]));
    let page = report(&given, &[], 0);
    assert!(page.contains("undecided") && !page.contains("invalid"), "{page}");
    report(&given, &["--strict"], 3);
}

/// The distance to whole turns is not lost in the angle: beside them a ROTATION is at a singular point, and what it gives is judged by nobody.
#[test]
fn beside_whole_turns_a_rotation_is_singular() {
    use std::f64::consts::TAU;
    let angles = [0.0, TAU / 4.0, 0.4997 * TAU, 0.75 * TAU, TAU];
    let given = files("whole-turn", "\nROTATION\nO, O\n", &turned(2, &angles));
    let found = subject(&given, &[], 0);
    let states = &check(&found, "first-derivatives", "wide-differences")["states"];
    assert_eq!(states["singular"], 1, "{states}");
}

/// b turned once round: to the whole turn itself, and next to it, where oracles on doubles lose the digits that the product keeps. They
/// do not decide by themselves; and where no independent oracle was asked, they do.
#[test]
fn oracles_on_doubles_do_not_decide_near_whole_turns() {
    use std::f64::consts::TAU;
    let quarter = [0.0, TAU / 4.0, 0.4997 * TAU, 0.75 * TAU];
    for (i, end) in [TAU, TAU - 1e-4, TAU + 5e-5, TAU - 3e-6, TAU - 1e-7].into_iter().enumerate() {
        let states = turned(0, &[&quarter[..], &[end]].concat());
        let given = files(&format!("turn{i}"), "\nROTATION\nO, O\n", &states);
        let found = subject(&given, &[], 0);
        assert_ne!(found["derivative"], "undecided", "{end}");
        assert_eq!(
            check(&found, "first-derivatives", "wide-differences")["states"]["wrong"],
            serde_json::Value::Null
        );
        // At the only state of its own that is not chosen for 237 bits an alarm on doubles is put before these.
        report(&given, &["--wide-states", "1"], 0);
    }
    // What is wrong is still found on doubles where nobody else was asked, and where others are.
    let given = files("turn-wrong", "\nROTATION\nO, O\n", &turned(0, &quarter));
    for oracles in ["symbolic", "differences", "symbolic,wide-differences"] {
        report(&given, &["--plant", "wrong-entry", "--oracles", oracles, "--wide-states", "1"], 1);
    }
}

/// Accelerations close to a half turn, with velocities or none: of connectors and of constraints.
#[test]
fn accelerations_keep_their_digits_near_half_turns() {
    use std::f64::consts::PI;
    let states = |distance: f64, v: f64| {
        let rates = format!("{v:?},0,0,1,0.5,0.25");
        format!(
            "state,time,node,ur1,ur2,ur3,vr1,vr2,vr3,ar1,ar2,ar3\n0,0,2,1,0,0,{rates}\n1,1,2,2,0,0,{rates}\n2,2,2,{:?},0,0,{rates}\n",
            PI - distance
        )
    };
    for (i, distance) in [1e-9, 1e-11, 1e-12, 1e-13].into_iter().enumerate() {
        for (j, v) in [0.0, 1e-5, 1.0].into_iter().enumerate() {
            let name = format!("acceleration{i}{j}");
            report(&files(&name, "\nBEAM\nO\n", &states(distance, v)), &[], 0);
            let deck = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*MPC\nBEAM, 2, 1\n";
            report(&written(&format!("{name}m"), deck, &states(distance, v)), &[], 0);
        }
    }
}

/// A tolerance that overflows decides nothing, neither way: the report says so.
#[test]
fn overflow_is_undecided() {
    let section = "\nCARTESIAN\nO\n";
    let given = files("overflow", section, "state,time,node,u1,u2,v1\n0,0,2,0.1,0.2,1e160\n");
    let found = subject(&given, &[], 0);
    let acceleration = check(&found, "acceleration", "wide-differences");
    assert_eq!(acceleration["verdict"], "undecided", "{acceleration}");
    assert_eq!(found["derivative"], "undecided");
    report(&given, &["--strict"], 3);
    for length in ["1e156", "1e200", "1e-160"] {
        let deck = format!(
            "*NODE\n1, 0., 0., 0.\n2, {length}, 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=E\n101, 1, 2\n\
             *CONNECTOR SECTION, ELSET=E\nAXIAL\n"
        );
        let states = format!("state,time,node,u1,u2\n0,0,2,0,{length}\n");
        report(&written(&format!("overflow{length}"), &deck, &states), &[], 0);
    }
}

/// A mutant that changes what is less than the least normal double changes nothing.
#[test]
fn mutants_of_denormal_numbers_are_equivalent() {
    report(
        &files("denormal", "\nCARTESIAN\nO\n", "state,time,node,u1,u2,a1\n0,0,2,0.1,0.2,1e-320\n"),
        &[],
        0,
    );
}

/// Aligned shafts and locks, as initial states have them, exactly or within rounding: nothing is called wrong, then or later.
#[test]
fn aligned_initial_states_are_no_mismatch() {
    let aligned = |kind: &str, a: &str| {
        format!(
            "*NODE\n1, 0., 0., 0.\n2, 1., 0.3, 0.2\n*ORIENTATION, NAME=O\n{a}\n*ELEMENT, TYPE=CONN3D2, ELSET=E\n\
             101, 1, 2\n*CONNECTOR SECTION, ELSET=E\n{kind}\nO, O\n"
        )
    };
    let skew = "0.3, 0.8, 0.1, -0.5, 0.2, 0.9";
    let states = "state,time,node,u1,u2,u3,ur1,ur2,ur3\n0,0,2,0,0,0,0,0,0\n1,1,2,0,0.1,0,0.5,0.2,-0.1\n";
    for (i, axes) in ["0.8660254038, 0.5, 0., 0., 0., 1.", "0.9659258, 0.258819, 0., 0., 0., 1.", skew]
        .into_iter()
        .enumerate()
    {
        for kind in ["FLEXION-TORSION", "EULER", "PROJECTION FLEXION-TORSION", "CARDAN"] {
            let name = format!("aligned{i}{}", kind.replace(' ', "-"));
            report(&written(&name, &aligned(kind, axes), states), &[], 0);
            // Nothing moves.
            let still = "state,time,node,u1\n0,0,2,0\n";
            report(&written(&format!("{name}s"), &aligned(kind, axes), still), &[], 0);
        }
    }
    use std::f64::consts::{FRAC_PI_2, PI};
    for kind in ["HINGE", "REVOLUTE", "CARDAN", "UNIVERSAL", "UJOINT"] {
        let given =
            files(&format!("lock-{kind}"), &format!("\n{kind}\nO, O\n"), &turned(1, &[0.5, 1.0, FRAC_PI_2]));
        report(&given, &[], 0);
    }
    let given = files("lock-EULER", "\nEULER\nO, O\n", &turned(2, &[0.5, 1.0]));
    report(&given, &[], 0);
    for end in [PI, PI - 5e-8, PI - 1.6e-3] {
        let given = files(
            "half-turn",
            "\nPROJECTION CARTESIAN\nO, O\n",
            &turned(1, &[PI / 3.0, 2.0 * PI / 3.0, end]),
        );
        report(&given, &[], 0);
    }
    // A displacement that counts from an arbitrary origin is flagged at every state, and its derivatives are judged all the same.
    let given = written("origin", &aligned("FLEXION-TORSION", skew), states);
    let [deck, at] = &given;
    let page = stdout(&pintle(&["eval", deck, "--states", at, "--outputs", "CU"]).assert().code(0));
    assert_eq!(page.matches("arbitrary origin").count(), 2, "{page}");
    let found = subject(&given, &[], 0);
    assert_eq!(check(&found, "value", "wide-differences")["verdict"], "ill-conditioned");
    report(&given, &["--plant", "wrong-entry"], 1);
}

/// A spring tabulated over another component: where the slopes of neighbouring rows cancel, what is left is as uncertain as they are; and
/// on a row of a table it has two slopes, which are judged and told.
#[test]
fn slopes_of_tables_are_judged() {
    let spring = "CARTESIAN\nO\n*CONNECTOR BEHAVIOR, NAME=B\n";
    let table = format!(
        ", BEHAVIOR=B\n{spring}*CONNECTOR ELASTICITY, COMPONENT=1, NONLINEAR, INDEPENDENT COMPONENTS=CONSTITUTIVE MOTION\n\
         1, 2\n1., -1., 0.1\n-1., 1., 0.1\n-1., -1., 0.7\n1., 1., 0.7\n"
    );
    let mut states = String::from("state,time,node,u1,u2\n");
    for (i, u2) in [0.38, 0.4, 0.39999999999999997, 0.3999999999999999, 0.4000000000001, 0.400000001]
        .into_iter()
        .enumerate()
    {
        states += &format!("{i},{i},2,0.6,{u2:?}\n");
    }
    let given = files("table", &table, &states);
    let found = subject(&given, &[], 0);
    assert_eq!(check(&found, "behavior-tangent", "wide-differences")["cases"], serde_json::Value::Null);
    report(&given, &["--plant", "wrong-entry"], 1);

    let curve = format!(
        ", BEHAVIOR=B\n{spring}*CONNECTOR ELASTICITY, COMPONENT=1, NONLINEAR\n-1., -1.\n0., 0.\n100., 1.\n"
    );
    let given = files("curve", &curve, "state,time,node,u1,u2\n0,0,2,0,0\n1,1,2,0,0.1\n");
    let found = subject(&given, &[], 0);
    let slopes = check(&found, "behavior-tangent", "wide-differences");
    assert_eq!(slopes["verdict"], "kink", "{slopes}");
    assert_eq!(slopes["worst"]["one_sided"], serde_json::json!([1.0, 100.0]), "{slopes}");
    // A slope outside both sides is wrong.
    report(&given, &["--plant", "wrong-sign"], 1);
}

/// Forces of which some are exactly zero and others numerical noise: |f| has a kink at zero, whatever the others are, and elsewhere none.
#[test]
fn frictions_among_noise_are_no_mismatch() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n\
                *ELEMENT, TYPE=CONN3D2, ELSET=E\n101, 1, 2\n*CONNECTOR SECTION, ELSET=E, BEHAVIOR=B\nHINGE\nO\n\
                *CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR FRICTION, PREDEFINED, STICK STIFFNESS=1000.\n0.02, 0.03, 0.5, 0.1\n\
                *FRICTION\n0.1\n";
    let states = "state,time,node,ur1,vr1\n0,0.1,2,0.1,1\n1,0.2,2,0.2,1\n";
    let audited = |name: &str, forces: &str, more: &[&str], code: i32| {
        let given = written(name, deck, states);
        let forces = format!("state,element,f1,f2,f3,m1,m2,m3\n0,101,{forces}\n1,101,{forces}\n");
        let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("structured-{name}-forces.csv"));
        fs::write(&path, forces).unwrap();
        subject(&given, &[&["--forces", path.to_str().unwrap()], more].concat(), code)
    };
    let cases = [
        "0,100,20,0,3,4",
        "0,0,1e-10,0,3,4",
        "0,1e-15,100,0,3,4",
        "0,1e-13,100,0,3,4",
        "0,1e-12,100,0,3,4",
        "1e-13,1e-12,100,0,3,4",
    ];
    for (i, forces) in cases.into_iter().enumerate() {
        let found = audited(&format!("noise{i}"), forces, &[], 0);
        let gradient = check(&found, "friction-gradient", "wide-differences");
        let tolerance = gradient["worst"]["tolerance"].as_f64().unwrap();
        assert!(tolerance < 1e-4, "{forces}: {gradient}");
        if forces.starts_with("0,") {
            // Both slopes are told, also where what F_C is formed of besides is far larger.
            assert!(
                ["kink", "ill-conditioned"].contains(&gradient["verdict"].as_str().unwrap()),
                "{forces}: {gradient}"
            );
            let sides = gradient["worst"]["one_sided"].as_array().unwrap();
            assert!(
                sides[0].as_f64().unwrap() < -0.01 && sides[1].as_f64().unwrap() > 0.01,
                "{forces}: {gradient}"
            );
        } else {
            assert_ne!(gradient["verdict"], "kink", "{forces}: {gradient}");
        }
        audited(&format!("noise{i}"), forces, &["--plant", "wrong-entry"], 1);
    }
}

/// Near a half turn about an axis a formula that loses digits is not explained by a mistake: it comes near to many things.
#[test]
fn lost_digits_are_not_explained_by_mistakes() {
    use pintle_audit::Candidate;
    let mut definition = crate::audit::at_rest("CARTESIAN");
    definition.initial.b.displacement = [0.0; 3];
    let connector = pintle_kinematics::connector::Connector::<f64>::new(&definition);
    let settings =
        Settings { states: 20, wide_states: 5, near_singular_states: 0, atlas: false, ..Settings::default() };
    let report = Candidate::new("noisy", &definition).settings(settings).check(|state| {
        use pintle_kinematics::connector::{Increment, Request, Tally};
        let branch = connector.initial_branch();
        let asked = Request::everything(1);
        let found = connector.evaluate(state, &Increment::none(), &branch, &asked, &mut Tally::default());
        // Every derivative loses its last digits, each in its own way.
        let spoiled = found.jacobian.map(|row| {
            row.map(|row| {
                std::array::from_fn(|j| {
                    row[j] + 1e-9 * (1.0 + (j as f64 * 7.3).sin()) * f64::from(row[j] != 0.0)
                })
            })
        });
        (found.displacement, spoiled)
    });
    let check = report.subjects[0].checks.iter().find(|check| check.verdict.is_mismatch()).unwrap();
    let causes = check.diagnosis.iter().flat_map(|found| &found.causes);
    let told: Vec<&str> = causes.map(|cause| cause.code.as_str()).collect();
    // That digits are lost, and nothing else.
    assert_eq!(told, ["diagnosis::differences"], "{check:?}");
}

/// Stick so stiff that what it is returned from is 1e10 to 1e35 times the limit: steps of that size lead over a traction that is not zero,
/// to what is no solution.
#[test]
fn stiff_stick_has_one_solution() {
    let states = "state,time,node,u1,ur1\n0,0.1,2,-0.9,0.4\n1,0.2,2,0.3,1.1\n2,0.3,2,0.7,-0.2\n";
    for (i, (friction, stiffness)) in [(2e-10, 8e15), (0.3, 1e12), (1e-3, 1e20)].into_iter().enumerate() {
        for (sliding, components) in [("COMPONENT=1", ""), ("", "*CONNECTOR POTENTIAL\n1,\n4, 2.\n")] {
            // Forces and moments of a potential need an effective radius.
            let radius = if sliding.is_empty() { "1." } else { "" };
            let comma = if sliding.is_empty() { "" } else { ", " };
            let section = format!(
                ", BEHAVIOR=B\nCARTESIAN, ROTATION\nO\n*CONNECTOR BEHAVIOR, NAME=B\n\
                 *CONNECTOR FRICTION{comma}{sliding}, STICK STIFFNESS={stiffness:e}\n{radius}, 3e-9\n{components}*FRICTION\n{friction:e}\n"
            );
            let given = files(&format!("stiff{i}{}", sliding.len()), &section, states);
            let found = subject(&given, &[], 0);
            let forces = check(&found, "friction-force", "wide-differences");
            assert_eq!(forces["verdict"], "pass", "{friction} {stiffness} {sliding}: {forces}");
        }
    }
}

/// Right angles, half and whole turns in a frame at 45°: triads are rotations to 53 bits, two ways to take their rotation are equally near,
/// and differences on 237 bits step from one to the other.
#[test]
fn right_angles_in_oblique_frames_are_no_mismatch() {
    use std::f64::consts::{FRAC_PI_2, PI};
    let types =
        ["BUSHING", "CVJOINT", "ALIGN", "TRANSLATOR", "PROJECTION CARTESIAN", "FLEXION-TORSION", "ROTATION"];
    let mut deck =
        String::from("*ORIENTATION, NAME=O\n0.7071067811865476, 0., 0.7071067811865476, 0., 1., 0.\n");
    let mut states = String::from("state,time,node,ur1,ur2,ur3\n");
    for (i, name) in types.into_iter().enumerate() {
        let [a, b] = [2 * i + 1, 2 * i + 2];
        deck += &format!(
            "*NODE\n{a}, {i}., 0., 0.\n{b}, {i}., 1., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=E{i}\n{a}0, {a}, {b}\n\
             *CONNECTOR SECTION, ELSET=E{i}\n{name}\nO, O\n"
        );
    }
    let turns = [0, 1, 2]
        .into_iter()
        .flat_map(|axis| [FRAC_PI_2, -FRAC_PI_2, PI - 1e-6, 1.0, -3.0 * PI].map(|angle| (axis, angle)));
    for (state, (axis, angle)) in turns.enumerate() {
        let mut turn = [0.0; 3];
        turn[axis] = angle;
        for i in 0..types.len() {
            states += &format!("{state},{state},{},{:?},{:?},{:?}\n", 2 * i + 2, turn[0], turn[1], turn[2]);
        }
    }
    let given = written("oblique", &deck, &states);
    report(&given, &[], 0);
    report(&given, &["--plant", "wrong-entry"], 1);
}

/// |f|^(3/2) has no second derivative at f = 0: what a Hessian says there is judged by nobody, and is not called wrong; elsewhere it is judged.
#[test]
fn hessians_without_end_are_singular() {
    let section = ", BEHAVIOR=B\nCARTESIAN\nO\n*CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR FRICTION, STICK STIFFNESS=1000.\n, 2.\n\
                   *CONNECTOR POTENTIAL, EXPONENT=1.5\n1, 1.\n2, 1.\n*FRICTION\n0.5\n";
    let states = "state,time,node,u1,u2\n0,0.1,2,0.1,0\n1,0.2,2,0.2,0\n";
    let given = files("power", section, states);
    // What follows from it, as a consistent tangent, is judged by itself.
    let [deck, at] = &given;
    let text = stdout(&pintle(&["audit", deck, "--at", at, "--format", "json"]).assert());
    let found: serde_json::Value = serde_json::from_str(&text).unwrap();
    let hessians = check(&found["subjects"][0], "friction-hessian", "wide-differences");
    assert_eq!(hessians["verdict"], "singular", "{hessians}");
    assert!(hessians["worst"]["lack"].as_str().unwrap().contains("do not settle"), "{hessians}");
    let beside = "state,time,node,u1,u2\n0,0.1,2,0.1,0.05\n1,0.2,2,0.2,0.02\n";
    let given = files("power-beside", section, beside);
    assert_eq!(check(&subject(&given, &[], 0), "friction-hessian", "wide-differences")["verdict"], "pass");
}

/// A shaft turned about its own axis: every entry is 0, ±1 or half an angle, and the rows round as angles of many turns do.
#[test]
fn a_shaft_of_many_turns_rounds_as_its_angle_does() {
    let angles: Vec<f64> = (0..120).map(|i| 0.237 * f64::from(i)).collect();
    let given = files("shaft", "\nROTATION\nO,\n", &turned(0, &angles));
    let text = report(&given, &["--wide-states", "60"], 0);
    assert!(text.contains("no mismatch"), "{text}");
    report(&given, &["--plant", "wrong-entry"], 1);
}

/// Where all is released, or nothing is known of what presses, there is no tangent to judge.
#[test]
fn frictions_without_a_tangent_are_audited() {
    let friction = "*CONNECTOR FRICTION, COMPONENT=1, STICK STIFFNESS=10.\n, 1.0\n*FRICTION\n0.1\n";
    let failing = format!(
        ", BEHAVIOR=B\nCARTESIAN\nO,\n*CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR FAILURE, COMPONENT=1, RELEASE=ALL\n-0.5, 0.5\n{friction}"
    );
    let states = "state,time,node,u1\n0,0,2,0.6\n1,1,2,0.6\n";
    report(&files("released", &failing, states), &[], 0);
    let stopped = ", BEHAVIOR=B\nAXIAL\n*CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR STOP, COMPONENT=1\n-0.1, 0.1\n\
                   *CONNECTOR FRICTION, COMPONENT=1, CONTACT FORCE=1\n, 0.0\n*FRICTION\n0.1\n";
    report(&files("stopped", stopped, states), &[], 0);
}
