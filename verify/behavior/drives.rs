//! What motions and loads prescribe, step by step: a table of decks, worked out by hand from the rules of the manual's pages.

use num_dual::Dual64;
use pintle_model::behavior::Unknown;
use pintle_model::behavior::drive::{ANGLE, Drives, Prescribed, Schedule, drives, on_angles};
use pintle_scene::{MotionType, Scene};

const MODEL: &str = "*NODE\n1, 0., 0., 0.\n2, 1., 2., 3.\n\
    *ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*CONNECTOR SECTION, ELSET=C\nCARTESIAN\n\
    *AMPLITUDE, NAME=WAVE\n0., 0., 1., 2., 3., -2.\n\
    *AMPLITUDE, NAME=TOTAL, TIME=TOTAL TIME\n0., 0., 10., 10.\n\
    *AMPLITUDE, NAME=ABSOLUTE, VALUE=ABSOLUTE\n0., 0., 1., 2., 3., -2.\n\
    *AMPLITUDE, NAME=USER, DEFINITION=USER\n1.\n";

fn parsed(steps: &str) -> Scene {
    let deck = format!("{MODEL}{steps}");
    Scene::parse("deck.inp", &deck).unwrap_or_else(|error| panic!("{}\n{deck}", error.render(100, false)))
}

/// What a deck with these steps prescribes, and its schedule.
fn prescribed(steps: &str) -> (Drives, Schedule) {
    let scene = parsed(steps);
    let schedule = Schedule::new(&scene);
    let mut all = drives(&scene, &schedule, |_| vec![7]).unwrap();
    (all.remove(&7).unwrap_or_default(), schedule)
}

const STATIC: &str = "*STEP\n*STATIC\n0.1, 2.\n";
const RAMPED: &str = "*STEP, AMPLITUDE=RAMP\n*DYNAMIC\n0.1, 2.\n";
const DYNAMIC: &str = "*STEP\n*DYNAMIC\n0.1, 2.\n";
const EXPLICIT: &str = "*STEP\n*DYNAMIC, EXPLICIT\n, 2.\n";
const END: &str = "\n*END STEP\n";

fn motion(options: &str, magnitude: f64) -> String {
    format!("*CONNECTOR MOTION{options}\n7, 1, {magnitude:?}{END}")
}

/// Value and rate of the motion of component 1 at a time, the component being at 0.25 when a step begins.
fn moved(steps: &str, time: f64) -> Option<(MotionType, Result<[f64; 2], Unknown>)> {
    let (drives, schedule) = prescribed(steps);
    let at = drives.motions[0].as_ref()?.at(&schedule, Some(Dual64::new(time, 1.0)), |_| Some(0.25))?;
    Some(match at {
        Prescribed::Displacement(x) => (MotionType::Displacement, Ok([x.re, x.eps])),
        Prescribed::Velocity(x) => (MotionType::Velocity, Ok([x.re, x.eps])),
        Prescribed::Acceleration(x) => (MotionType::Acceleration, Ok([x.re, x.eps])),
        Prescribed::Unknown(kind, unknown) => (kind, Err(unknown)),
    })
}

fn loaded(steps: &str, time: f64) -> Result<[f64; 2], Unknown> {
    let (drives, schedule) = prescribed(steps);
    let Some(drive) = &drives.loads[0] else { return Ok([0.0; 2]) };
    drive.load(&schedule, Some(Dual64::new(time, 1.0))).map(|x| [x.re, x.eps])
}

#[test]
fn motions_by_kind_and_procedure() {
    use MotionType::{Acceleration, Displacement, Velocity};
    let of = |step: &str, options: &str| format!("{step}{}", motion(options, 5.0));
    for (step, options, kind, [half, one]) in [
        // Displacements are ramped in Standard, whatever the step's AMPLITUDE; at once in Explicit.
        (STATIC, "", Displacement, [[1.25, 2.5], [2.5, 2.5]]),
        (DYNAMIC, "", Displacement, [[1.25, 2.5], [2.5, 2.5]]),
        (EXPLICIT, "", Displacement, [[5.0, 0.0], [5.0, 0.0]]),
        // Velocities come at once but where a dynamic step of Standard ramps.
        (STATIC, ", TYPE=VELOCITY", Velocity, [[5.0, 0.0], [5.0, 0.0]]),
        (DYNAMIC, ", TYPE=VELOCITY", Velocity, [[5.0, 0.0], [5.0, 0.0]]),
        (RAMPED, ", TYPE=VELOCITY", Velocity, [[1.25, 2.5], [2.5, 2.5]]),
        (EXPLICIT, ", TYPE=VELOCITY", Velocity, [[5.0, 0.0], [5.0, 0.0]]),
        // Accelerations follow the step.
        (STATIC, ", TYPE=ACCELERATION", Acceleration, [[1.25, 2.5], [2.5, 2.5]]),
        (DYNAMIC, ", TYPE=ACCELERATION", Acceleration, [[5.0, 0.0], [5.0, 0.0]]),
        (RAMPED, ", TYPE=ACCELERATION", Acceleration, [[1.25, 2.5], [2.5, 2.5]]),
        // WAVE is 2t until 1; what counts in dynamics is smoothed within a quarter of the shorter interval, by −4 0.25/4 at the corner.
        (STATIC, ", AMPLITUDE=WAVE", Displacement, [[5.0, 10.0], [10.0, 10.0]]),
        (DYNAMIC, ", AMPLITUDE=WAVE", Displacement, [[5.0, 10.0], [8.75, 0.0]]),
        (DYNAMIC, ", AMPLITUDE=WAVE, TYPE=VELOCITY", Velocity, [[5.0, 10.0], [8.75, 0.0]]),
        (DYNAMIC, ", AMPLITUDE=WAVE, TYPE=ACCELERATION", Acceleration, [[5.0, 10.0], [10.0, 10.0]]),
        (EXPLICIT, ", AMPLITUDE=WAVE", Displacement, [[5.0, 10.0], [10.0, 10.0]]),
        (STATIC, ", AMPLITUDE=ABSOLUTE", Displacement, [[1.0, 2.0], [2.0, 2.0]]),
    ] {
        let deck = of(step, options);
        assert_eq!(moved(&deck, 0.5), Some((kind, Ok(half))), "{deck}");
        assert_eq!(moved(&deck, 1.0), Some((kind, Ok(one))), "{deck}");
        assert_eq!(moved(&deck, 2.5), Some((kind, Err(Unknown::AfterSteps))), "{deck}");
    }
    let user = of(STATIC, ", AMPLITUDE=USER");
    assert_eq!(moved(&user, 0.5), Some((Displacement, Err(Unknown::External))));
    let user = of(STATIC, ", USER");
    assert_eq!(moved(&user, 0.5), Some((Displacement, Err(Unknown::External))));
}

#[test]
fn motions_from_step_to_step() {
    use MotionType::{Acceleration, Displacement, Velocity};
    let two = |first: &str, then: &str| format!("{first}{then}");
    let ramped = |options: &str, magnitude| format!("{RAMPED}{}", motion(options, magnitude));
    let quiet = format!("{STATIC}{}", &END[1..]);
    for (deck, time, expected) in [
        // A ramp begins at the last value of the same kind, or at zero; a displacement where the component is.
        (two(&ramped(", TYPE=VELOCITY", 4.0), &ramped(", TYPE=VELOCITY", 10.0)), 3.0, (Velocity, [7.0, 3.0])),
        (
            two(&ramped(", TYPE=VELOCITY", 4.0), &ramped(", TYPE=ACCELERATION", 10.0)),
            3.0,
            (Acceleration, [5.0, 5.0]),
        ),
        (two(&ramped(", TYPE=VELOCITY", 4.0), &ramped("", 1.0)), 3.0, (Displacement, [0.625, 0.375])),
        (two(&ramped("", 4.0), &ramped("", 1.0)), 3.0, (Displacement, [2.5, -1.5])),
        // Not given again: it stays.
        (two(&ramped("", 4.0), &quiet), 3.0, (Displacement, [4.0, 0.0])),
        (two(&ramped(", TYPE=VELOCITY", 4.0), &quiet), 3.0, (Velocity, [4.0, 0.0])),
        // An amplitude of the step ends with it, at −1 · 2 here; one of total time goes on.
        (
            two(&format!("{STATIC}{}", motion(", AMPLITUDE=WAVE", 2.0)), &quiet),
            2.5,
            (Displacement, [0.0, 0.0]),
        ),
        (
            two(&format!("{STATIC}{}", motion(", AMPLITUDE=TOTAL", 2.0)), &quiet),
            2.5,
            (Displacement, [5.0, 2.0]),
        ),
        // An amplitude of the second step counts from its beginning; total time does not.
        (
            two(&quiet, &format!("{STATIC}{}", motion(", AMPLITUDE=WAVE", 2.0))),
            2.5,
            (Displacement, [2.0, 4.0]),
        ),
        (
            two(&quiet, &format!("{STATIC}{}", motion(", AMPLITUDE=TOTAL", 2.0))),
            2.5,
            (Displacement, [5.0, 2.0]),
        ),
        // A perturbation takes no time. A static step without times lasts 1.
        (
            two("*STEP, PERTURBATION\n*STATIC\n0.1, 7.\n*END STEP\n", &ramped("", 4.0)),
            1.0,
            (Displacement, [2.0, 2.0]),
        ),
        (two("*STEP\n*STATIC\n*END STEP\n", &ramped("", 4.25)), 2.0, (Displacement, [2.25, 2.0])),
        // The common time of two steps belongs to the first.
        (two(&ramped("", 4.0), &ramped("", 1.0)), 2.0, (Displacement, [4.0, 2.0])),
    ] {
        let (kind, numbers) = expected;
        assert_eq!(moved(&deck, time), Some((kind, Ok(numbers))), "{deck} at {time}");
    }
    // OP=NEW ends what is not given again.
    let ended = two(&ramped("", 4.0), &format!("{STATIC}*CONNECTOR MOTION, OP=NEW\n7, 2, 1.{END}"));
    assert_eq!(moved(&ended, 3.0), None);
    let all = two(&ramped("", 4.0), "*STEP\n*STATIC\n0.1, 2.\n*CONNECTOR MOTION, OP=NEW\n*END STEP\n");
    assert_eq!(moved(&all, 3.0), None);
    // A step whose length is not known: nothing is known in it and after it.
    let open = two(&ramped("", 4.0), "*STEP\n*FREQUENCY\n5\n*END STEP\n");
    assert_eq!(moved(&open, 1.0), Some((Displacement, Ok([2.0, 2.0]))));
    assert_eq!(moved(&open, 3.0), Some((Displacement, Err(Unknown::AfterSteps))));
}

#[test]
fn loads_by_procedure_and_from_step_to_step() {
    let load =
        |step: &str, options: &str, lines: &str| format!("{step}*CONNECTOR LOAD{options}\n{lines}{END}");
    let first = load(STATIC, "", "7, 1, 4.");
    let quiet = |step: &str| format!("{step}{}", &END[1..]);
    let renewed = |step: &str| load(step, ", OP=NEW", "7, 2, 1.");
    for (deck, time, expected) in [
        (first.clone(), 1.0, [2.0, 2.0]),
        (load(DYNAMIC, "", "7, 1, 4."), 1.0, [4.0, 0.0]),
        (load(RAMPED, "", "7, 1, 4."), 1.0, [2.0, 2.0]),
        (load(EXPLICIT, "", "7, 1, 4."), 1.0, [4.0, 0.0]),
        // Loads are not smoothed.
        (load(DYNAMIC, ", AMPLITUDE=WAVE", "7, 1, 4."), 1.0, [8.0, 8.0]),
        // Several of one component add up.
        (load(STATIC, "", "7, 1, 4.\n7, 1, 2."), 1.0, [3.0, 3.0]),
        (load(DYNAMIC, "", "7, 1, 4.\n7, 1, 2."), 1.0, [6.0, 0.0]),
        // From step to step: it stays; it is ramped from what it was, once; OP=NEW ramps it down, or ends it.
        (format!("{first}{}", quiet(STATIC)), 3.0, [4.0, 0.0]),
        (format!("{first}{}", load(STATIC, "", "7, 1, 10.")), 3.0, [7.0, 3.0]),
        (format!("{first}{}", load(STATIC, "", "7, 1, 10.\n7, 1, 2.")), 3.0, [8.0, 4.0]),
        (format!("{first}{}", renewed(STATIC)), 3.0, [2.0, -2.0]),
        (format!("{first}{}", renewed(DYNAMIC)), 3.0, [0.0, 0.0]),
        (format!("{first}{}{}", renewed(STATIC), renewed(STATIC)), 5.0, [0.0, 0.0]),
        // Without data lines all of them end.
        (format!("{first}{DYNAMIC}*CONNECTOR LOAD, OP=NEW{END}"), 3.0, [0.0, 0.0]),
    ] {
        assert_eq!(loaded(&deck, time), Ok(expected), "{deck} at {time}");
    }
    assert_eq!(loaded(&load(STATIC, ", AMPLITUDE=USER", "7, 1, 4."), 1.0), Err(Unknown::External));
    assert_eq!(loaded(&first, 3.0), Err(Unknown::AfterSteps));
}

/// Without a time only what is the same at all times is known.
#[test]
fn what_holds_at_any_time() {
    let at = |steps: &str| {
        let (drives, schedule) = prescribed(steps);
        drives.motions[0].as_ref().unwrap().at::<f64>(&schedule, None, |_| None)
    };
    // No steps: what the model data give is held, at any time and without one.
    let held = "*CONNECTOR MOTION\n7, 1\n";
    assert_eq!(at(held), Some(Prescribed::Displacement(0.0)));
    assert_eq!(moved(held, 3.0), Some((MotionType::Displacement, Ok([0.0, 0.0]))));
    // It is held through the steps as well.
    assert_eq!(at(&format!("{held}{STATIC}{}", &END[1..])), Some(Prescribed::Displacement(0.0)));
    let fixed = format!("{EXPLICIT}{}", motion("", 5.0));
    assert_eq!(at(&fixed), Some(Prescribed::Displacement(5.0)));
    let unknown = Some(Prescribed::Unknown(MotionType::Displacement, Unknown::Time));
    assert_eq!(at(&format!("{STATIC}{}", motion("", 5.0))), unknown, "a ramp");
    assert_eq!(at(&format!("{fixed}{EXPLICIT}{}", motion("", 6.0))), unknown, "two values");
    assert_eq!(at(&format!("{fixed}*STEP\n*FREQUENCY\n5\n*END STEP\n")), unknown, "a step of unknown length");
}

#[test]
fn two_motions_of_one_component_are_refused() {
    let scene = parsed(&format!("{STATIC}*CONNECTOR MOTION\n7, 1, 1.\n7, 1, 2.{END}"));
    let fault = drives(&scene, &Schedule::new(&scene), |_| vec![7]).unwrap_err().render(100, false);
    assert!(fault.contains("component 1 has two motions in one step"), "{fault}");
}

/// Degree of freedom 6 of nodes: the angle of a hinge. The later of two boundary conditions counts; moments add up.
#[test]
fn angles_are_driven_by_the_rotation_about_3() {
    let at = |steps: &str, time: f64| {
        let scene = parsed(steps);
        let schedule = Schedule::new(&scene);
        let mut all = on_angles(&scene, &schedule, |_| vec![2]).unwrap();
        let drives = all.remove(&2).unwrap_or_default();
        let motion =
            drives.motions[ANGLE].as_ref().and_then(|drive| drive.at(&schedule, Some(time), |_| None));
        let load = drives.loads[ANGLE].as_ref().map(|drive| drive.load(&schedule, Some(time)).unwrap());
        (motion, load)
    };
    let angle = |x: f64| Some(Prescribed::Displacement(x));
    for (steps, expected) in [
        (format!("{STATIC}*BOUNDARY\n2, 6, 6, 3.{END}"), (angle(1.5), None)),
        (format!("{STATIC}*BOUNDARY\n2, 4, 6, 3.{END}"), (angle(1.5), None)),
        (format!("{STATIC}*BOUNDARY\n2, 4, 5, 3.{END}"), (None, None)),
        (format!("{STATIC}*BOUNDARY\n2, 6, 6, 3.\n2, 6, 6, 5.{END}"), (angle(2.5), None)),
        (format!("{STATIC}*CLOAD\n2, 6, 8.\n2, 6, 2.{END}"), (None, Some(5.0))),
        (format!("{STATIC}*CLOAD\n2, 5, 8.{END}"), (None, None)),
        (format!("*BOUNDARY\n2, 6, 6\n{STATIC}{}", &END[1..]), (angle(0.0), None)),
    ] {
        assert_eq!(at(&steps, 1.0), expected, "{steps}");
    }
    let renewed = format!(
        "{STATIC}*BOUNDARY\n2, 6, 6, 3.\n*CLOAD\n2, 6, 8.{END}{DYNAMIC}*BOUNDARY, OP=NEW\n2, 1, 1\n*CLOAD, OP=NEW\n2, 1, 1.{END}"
    );
    assert_eq!(at(&renewed, 2.0), (angle(3.0), Some(8.0)));
    assert_eq!(at(&renewed, 3.0), (None, Some(0.0)));
}

/// A schedule knows its steps, and a component what is prescribed.
#[test]
fn schedules_and_drives_are_empty_or_not() {
    for (steps, length, is_empty) in [
        (String::new(), 0, true),
        (format!("{STATIC}{}", &END[1..]), 1, true),
        (format!("{STATIC}{}{STATIC}{}", motion("", 5.0), &END[1..]), 2, false),
        (format!("{STATIC}*CONNECTOR LOAD\n7, 1, 5.{END}"), 1, false),
    ] {
        let (drives, schedule) = prescribed(&steps);
        let found = (schedule.len(), schedule.is_empty(), drives.is_empty());
        assert_eq!(found, (length, length == 0, is_empty), "{steps}");
    }
}

/// Ramps meet both ends bit for bit, and are exact near them, however different they are.
#[test]
fn ramps_meet_their_ends() {
    for (from, to) in [(0.1, 0.7), (0.3, -1.1), (1.3, 1e-3), (1e-3, 1e10), (1e10, 1e-3)] {
        let steps = format!("{STATIC}{}{STATIC}{}", motion("", from), motion("", to));
        let value = |time: f64| match moved(&steps, time) {
            Some((_, Ok([value, _]))) => value,
            other => panic!("{other:?}"),
        };
        assert_eq!((value(2.0), value(4.0)), (from, to));
        // A hair after the beginning and before the end of the second step, of length 2.
        let hair = 2f64.powi(-50);
        for (time, exact) in
            [(2.0 + hair, from + (to - from) * hair / 2.0), (4.0 - hair, to - (to - from) * hair / 2.0)]
        {
            assert!(
                (value(time) - exact).abs() <= 4.0 * f64::EPSILON * exact.abs(),
                "{from} {to}: {}",
                value(time)
            );
        }
    }
}
