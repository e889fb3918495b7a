//! Slopes of elastic and viscous forces of a scene's connector, against differences of the forces on 237-bit numbers.

use super::case::Case;
use super::engine::Settings;
use super::oracle::Oracle;
use super::outcome::{Against, Check};
use super::quantity::Quantity;
use super::sheet::{Entry, Sheet};
use super::verdict::{Judgement, Score, Verdict};
use crate::behavior::state::Behavior;
use crate::behavior::{Conditions, Motion, Unknown};
use crate::catalog::{COMPONENT, FORCE};
use crate::connector::{Output, Request};
use crate::scalar::Wide;

/// The step of differences, in sizes of the motion.
const STEP: f64 = 1e-25;

/// The slopes at the end of a case; `None` where nothing acts or all of it is rigid, or on a kink of a table, where there are two
/// slopes. Undecided where a force depends on what is not given.
pub(super) fn audit_behavior(
    case: &Case,
    behavior: &Behavior,
    settings: &Settings,
    proves: bool,
) -> Option<Check> {
    let acts =
        [behavior.elasticity.components(), behavior.damping.components()].as_flattened().contains(&true);
    if !acts || !settings.oracles.contains(&Oracle::WideDifferences) {
        return None;
    }
    let asked = Request::new(&[Output::CP, Output::CCU, Output::CV], [true; 6], 0);
    let (evaluation, _) = case.evaluation(&asked)?;
    let value = |of: [Option<f64>; 6]| of.map(Option::unwrap_or_default);
    let motion = Motion {
        position: value(evaluation.position),
        constitutive: value(evaluation.constitutive),
        velocity: value(evaluation.velocity),
    };
    let conditions = Conditions::default();
    let on_kink = !behavior.elasticity.kinks(&motion, &conditions).is_empty()
        || !behavior.damping.kinks(&motion, &conditions).is_empty();
    if on_kink {
        return None;
    }
    // Without temperature and fields some forces are not known: their slopes are not judged, and that is said.
    let laws =
        [behavior.elasticity.forces(&motion, &conditions), behavior.damping.forces(&motion, &conditions)];
    let is_known = |i: usize| laws.iter().all(|law| law.unknown[i].is_none());
    let lacks =
        |law: &crate::behavior::Forces<f64>| law.unknown.iter().flatten().any(|why| *why != Unknown::Rigid);
    let tangent = behavior.tangent(&motion, &conditions, None, [false; 6]);
    let size = |k: usize, x: f64| x.abs().max(if k < 3 { case.length } else { 1.0 });
    let forces = |of_velocity: bool, j: usize, h: Wide| -> [Wide; 6] {
        let wide = |x: [f64; 6]| x.map(Wide::from_f64);
        let mut moved = Motion {
            position: wide(motion.position),
            constitutive: wide(motion.constitutive),
            velocity: wide(motion.velocity),
        };
        if of_velocity {
            moved.velocity[j] += h;
        } else {
            moved.position[j] += h;
            moved.constitutive[j] += h;
        }
        behavior.forces(&moved, &conditions)
    };
    let still = forces(false, 0, Wide::from_f64(0.0));
    let mut entries = Vec::new();
    for (of_velocity, slopes) in [(false, &tangent.displacement), (true, &tangent.velocity)] {
        for j in 0..6 {
            let x = if of_velocity { motion.velocity[j] } else { motion.constitutive[j] };
            let size = size(j, x);
            let h = Wide::from_f64(STEP * size);
            let (plus, minus) = (forces(of_velocity, j, h), forces(of_velocity, j, -h));
            for i in (0..6).filter(|i| is_known(*i)) {
                let want = (plus[i] - minus[i]) / (h + h);
                let variable = if of_velocity { "v" } else { "u" };
                entries.push(Entry::new(
                    format!("∂{}/∂{variable}({})", FORCE[i], COMPONENT[j]),
                    slopes[i][j],
                    want,
                    still[i].to_f64().abs() / size + want.to_f64().abs(),
                ));
            }
        }
    }
    let sheet = Sheet { quantity: Quantity::BehaviorTangent, entries };
    let score = if proves { sheet.try_mistakes(&sheet.mistakes()) } else { Score::default() };
    let mut check = Check::new(Some(Quantity::BehaviorTangent), Against::Oracle(Oracle::WideDifferences));
    if !sheet.entries.is_empty() {
        check.add_at(sheet.judge(1.0), score, &case.name, Some(case));
    }
    if laws.iter().any(lacks) {
        let undecided = Judgement { verdict: Verdict::Undecided, worst: None, compared: 0 };
        check.add_at(undecided, Score::default(), &case.name, Some(case));
    }
    (!check.states.is_empty()).then_some(check)
}
