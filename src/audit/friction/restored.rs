//! Saved and restored: what a friction remembers, written and read again in the form in which a walk is saved, leads to the same forces
//! and slopes, bit for bit, as the walk that was not interrupted.
//!
//! Of a type the predefined friction goes on by a second increment. The frictions of a scene go on from three of its states, after the
//! first of these from what was restored before.

use crate::case::failing::FrictionCase;
use crate::case::quantity::Quantity;
use crate::friction::increment::{output, partials, results};
use crate::judge::outcome::{Against, Check};
use crate::judge::table::{Entry, ResultTable};
use crate::judge::verdict::Score;
use crate::laws::Invariant;
use crate::scene::Target;
use crate::settings::Settings;
use pintle_kinematics::catalog::{COMPONENT, FORCE};
use pintle_kinematics::scalar::Wide;
use pintle_model::behavior::Tangent;
use pintle_model::behavior::friction::{Branch, State};
use pintle_model::behavior::state::{History, Outcome};
use pintle_model::evaluate::{Branches, Item, Plan, Sequence};
use pintle_scene::State as SceneState;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::convert::Infallible;

/// What is written and read again, as a file has it; `None` where that is not the same kind of thing.
fn through_text<T: Serialize + DeserializeOwned>(saved: &T) -> Option<T> {
    serde_json::to_string(saved).ok().and_then(|text| serde_json::from_str(&text).ok())
}

/// Numbers with their names.
type NamedNumbers = Vec<(String, f64)>;

/// Whether numbers after a restored history are those without an interruption; with mutants where it `proves`.
fn check(restored: &NamedNumbers, whole: &NamedNumbers, name: &str, proves: bool) -> Check {
    let mut table = ResultTable::new(Quantity::FrictionForce);
    // One number too many, or too few, moves all that follow: then none is where it must be.
    let has_all = restored.iter().map(|(title, _)| title).eq(whole.iter().map(|(title, _)| title));
    for (i, (title, want)) in whole.iter().enumerate() {
        let got = restored.get(i).filter(|_| has_all).map(|(_, got)| *got);
        let is_same = got.is_some_and(|got| got.to_bits() == want.to_bits());
        if is_same && !want.is_finite() {
            continue;
        }
        // What has no distance to what it must be and is not that bit for bit, as −0 and 0, is as good as missing.
        let is_far = got.is_some_and(|got| got != *want && want.is_finite());
        let got = got.filter(|_| is_same || is_far).unwrap_or(f64::NAN);
        let title = format!("{title} after a restored history");
        table.rows.push(title.clone());
        table.entries.push(Entry::new(title, got, Wide::from_f64(*want), 0.0, (0, 0, 0)));
    }
    let judgement = table.judge();
    let proves = proves && !judgement.verdict.is_mismatch();
    let score = if proves { table.try_mistakes(&table.all_mistakes()) } else { Score::default() };
    let mut check = Check::new(None, Against::Law(Invariant::Restored));
    check.add_at(judgement, score, name, None);
    check
}

impl FrictionCase {
    /// A second increment like the first, after a restored history.
    pub(crate) fn restored(&self, proves: bool) -> Check {
        self.restored_by(proves, &through_text)
    }

    fn restored_by(&self, proves: bool, save: &dyn Fn(&History) -> Option<History>) -> Check {
        let input = self.input(0, 0.0);
        let go_on = |before: &State<f64>| -> NamedNumbers {
            let (outcome, tangent) = self.friction.tangent(before, &input, Branch::Decided);
            let numbers = results(&outcome).into_iter().chain([outcome.accumulated_slip]);
            let slopes = partials(&tangent).concat();
            let title =
                |(i, x): (usize, f64)| (format!("result {} of the increment{}", i + 1, self.title), x);
            numbers.chain(slopes).enumerate().map(title).collect()
        };
        let (first, _) = self.friction.tangent(&self.before, &input, Branch::Decided);
        let history = History { friction: Some(vec![Some(first.state())]), ..History::default() };
        let restored = save(&history).and_then(|history| *history.friction?.first()?);
        let restored = restored.map_or_else(Vec::new, |state| go_on(&state));
        check(&restored, &go_on(&first.state()), &self.name, proves)
    }
}

/// What a connector with friction gives at a state: forces of friction, slips, and the slopes of all forces.
fn numbers(outcome: &Outcome, tangent: Option<&Tangent<f64>>) -> NamedNumbers {
    let mut found = Vec::new();
    for (k, force) in outcome.friction.value.iter().enumerate() {
        found.extend(force.map(|force| (output(k), force)));
    }
    for (i, slip) in outcome.slips.iter().enumerate() {
        if let Ok(done) = &slip.outcome {
            found.push((format!("Δγ of friction {}", i + 1), done.slip_increment));
            found.push((format!("CASU of friction {}", i + 1), done.accumulated_slip));
        }
    }
    for (by, slopes) in tangent.into_iter().flat_map(|tangent| {
        [("u", tangent.displacement), ("v", tangent.velocity), ("reaction", tangent.reaction)]
    }) {
        for (k, row) in slopes.iter().enumerate() {
            for (j, slope) in row.iter().enumerate() {
                let force = FORCE[k].to_uppercase();
                found.push((format!("∂CT{force}/∂({by} of {})", COMPONENT[j]), *slope));
            }
        }
    }
    found
}

/// The law of the frictions of a scene, by the place of the connector in the plan; `follows` is a plan that asks for forces of friction and
/// their slopes.
pub(crate) fn restored(target: &Target<'_>, follows: &Plan, settings: &Settings) -> BTreeMap<usize, Check> {
    restored_by(target, follows, settings, &through_text)
}

fn restored_by(
    target: &Target<'_>,
    follows: &Plan,
    settings: &Settings,
    save: &dyn Fn(&Branches) -> Option<Branches>,
) -> BTreeMap<usize, Check> {
    let Target { model, states, .. } = *target;
    let mut found: BTreeMap<usize, Check> = BTreeMap::new();
    let Some(last) = states.len().checked_sub(1).filter(|last| *last > 0) else { return found };
    let stops = [1, 1 + last / 3, 1 + 2 * last / 3];
    let begin = |branches: Branches| {
        let mut walk = Sequence::resume(model, follows, branches);
        walk.follow_everything();
        walk.set_conditions(settings.conditions.clone());
        walk
    };
    let visit = |walk: &mut Sequence<'_>, state: &SceneState| {
        let (mut all, mut place) = (BTreeMap::new(), 0);
        let Ok(()) = walk.visit(state, |placed| -> Result<(), Infallible> {
            if let Item::Connector(placed) = placed
                && let Some(element) = model.connectors.get(placed.index)
                && element.behavior.behavior.slips_at_all()
                && let Some(outcome) = &placed.behavior
            {
                all.insert(place, (element.title(), numbers(outcome, placed.tangent.as_deref())));
            }
            place += 1;
            Ok(())
        });
        all
    };
    let (mut whole, mut interrupted) = (begin(Branches::default()), begin(Branches::default()));
    for (index, state) in states.iter().enumerate() {
        if stops.contains(&index) {
            interrupted = begin(save(&interrupted.branches()).unwrap_or_default());
        }
        let (want, got) = (visit(&mut whole, state), visit(&mut interrupted, state));
        let number = state.number.unwrap_or(index as u64);
        // Before the first stop both are the same walk.
        for (place, (title, want)) in want.into_iter().filter(|_| index > 0) {
            let nothing = Vec::new();
            let got = got.get(&place).map_or(&nothing, |(_, got)| got);
            let at = check(got, &want, &format!("{title} at state {number}"), index == last);
            match found.get_mut(&place) {
                Some(known) => known.merge(at),
                None => _ = found.insert(place, at),
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::friction_cases;
    use crate::judge::verdict::Verdict;
    use pintle_kinematics::catalog::TABLE;
    use pintle_kinematics::connector::{Output, Request};
    use pintle_model::evaluate::{Model, Selection};
    use pintle_scene::{NodeMotion, Rotation, Scene};

    /// Every predefined friction goes on from what is read again as from what it remembers; and what loses the force, the slip or all of it does
    /// not, wherever these tell.
    #[test]
    fn predefined_frictions_go_on() {
        let (mut tried, mut lost) = (0, 0);
        for case in TABLE.iter().flat_map(|connection| friction_cases(connection, &Settings::default(), 3)) {
            let whole = case.restored(true);
            assert_eq!(whole.verdict, Verdict::Pass, "{}: {:?}", case.name, whole.worst);
            assert!(whole.score.killed > 20 && whole.score.survived == 0, "{}: {:?}", case.name, whole.score);
            tried += 1;
            let forgets = |history: &History| {
                let state = State { accumulated_slip: 0.0, ..State::default() };
                Some(History { friction: Some(vec![Some(state)]), ..history.clone() })
            };
            lost += usize::from(case.restored_by(false, &forgets).verdict.is_mismatch());
            let nothing = case.restored_by(false, &|_: &History| Some(History::default()));
            assert!(nothing.verdict.is_mismatch(), "{}", case.name);
        }
        assert!(tried > 20 && lost > tried / 2, "{lost} of {tried}");
    }

    const DECK: &str = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n\
        *ELEMENT, TYPE=CONN3D2, ELSET=ROD\n101, 1, 2\n*CONNECTOR SECTION, ELSET=ROD, BEHAVIOR=B\nCARTESIAN, CARDAN\nO,\n\
        *CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR ELASTICITY, COMPONENT=2\n150.,\n\
        *CONNECTOR FRICTION, COMPONENT=1, CONTACT FORCE=2, STICK STIFFNESS=1.E3\n, 0.5\n*FRICTION\n0.3\n";

    /// A rod that sticks and slips to and fro goes on from what was saved; where the saved form loses what its friction remembers it does not.
    #[test]
    fn frictions_of_a_scene_go_on() {
        let scene = Scene::parse("rod.inp", DECK).unwrap();
        let model = Model::compile(&scene).unwrap();
        let request = Request::new(&[Output::CSF, Output::TANGENT], [true; 6], 0);
        let plan = Plan::compile(&model, &Selection::All, request).unwrap();
        let state = |i: u32| {
            let slide = 0.01 * (0.9 * f64::from(i)).sin();
            let motion = NodeMotion {
                displacement: [slide, 0.02 + 0.001 * f64::from(i), 0.0],
                rotation: Rotation::Vector([0.0; 3]),
                ..NodeMotion::default()
            };
            let mut state = SceneState { time: Some(f64::from(i)), ..SceneState::default() };
            state.nodes.insert(2_u64.into(), motion);
            state
        };
        let states: Vec<SceneState> = (0..9).map(state).collect();
        let target = Target { name: "rod", model: &model, plan: &plan, states: &states };
        let settings = Settings::default();
        let found = restored(&target, &plan, &settings);
        let check = found.get(&0).unwrap();
        assert_eq!((found.len(), check.verdict), (1, Verdict::Pass), "{:?}", check.worst);
        assert!(
            check.compared > 8 * 100 && check.score.killed > 10 && check.score.survived == 0,
            "{check:?}"
        );
        let spoiled = |spoil: &dyn Fn(String) -> String| {
            let save = |branches: &Branches| {
                serde_json::from_str(&spoil(serde_json::to_string(branches).ok()?)).ok()
            };
            restored_by(&target, &plan, &settings, &save).remove(&0).map(|check| check.verdict)
        };
        assert_eq!(spoiled(&|text| text), Some(Verdict::Pass));
        let lose = |field: &'static str| {
            spoiled(&move |text| {
                let mut saved: serde_json::Value = serde_json::from_str(&text).unwrap();
                let history = saved.pointer_mut("/connectors/101/behavior/1").unwrap();
                *history.pointer_mut(field).unwrap() = serde_json::json!(0.0);
                saved.to_string()
            })
        };
        for field in ["/friction/0/accumulated_slip", "/friction/0/force/0", "/displacement/0"] {
            let verdict = lose(field).unwrap();
            assert!(verdict.is_mismatch(), "{field}: {verdict:?}");
        }
    }
}
