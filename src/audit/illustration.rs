//! One state of a connector for looking at: its Jacobian beside what it must be, and how approximations of it depend on the step.

use crate::case::failing::MpcCase;
use crate::case::quantity::{Entries, Quantity};
use crate::case::{AtEnd, Case};
use crate::judge::bound::Bound;
use crate::judge::comparison::Comparison;
use crate::judge::outcome::Report;
use crate::judge::verdict::Verdict;
use crate::oracles::force::product_at;
use crate::oracles::oracle::{Narrow, WideAnswers};
use crate::oracles::truth::Truth;
use crate::sampling::{Extent, cases};
use crate::scene::{self, Target};
use crate::settings::Planted;
use pintle_kinematics::catalog::{ConnectionType, TABLE};
use pintle_kinematics::connector::Components;
use pintle_kinematics::draw::Draw;
use pintle_kinematics::node::{DOFS, dof_size};
use pintle_kinematics::scalar::Wide;
use pintle_model::evaluate::ConnectorElement;
use rayon::prelude::*;
use std::collections::HashSet;

/// Errors of ∂f·v along one direction v of all nodes (1 rad, one length) against the step h, in units of the tolerance of ∂f·v:
/// the largest of all components.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Steps {
    /// (h, |f(q + hv) − f(q) − h ∂f·v|/h) on 237 bits, with the rows judged: falls like h down to the rounding of the rows.
    pub remainder: Vec<[f64; 2]>,
    /// (h, |(f(q + hv) − f(q − hv))/2h − ∂f·v|) on doubles: what a difference quotient would have to
    /// be compared within. None where there is no function, only a one-form.
    pub differences: Vec<[f64; 2]>,
}

/// One state of a connector or a constraint for looking at.
#[derive(Clone, Debug)]
pub struct Illustration {
    /// The scene that it is of.
    pub scene: Option<String>,
    /// The connector or type, after its scene.
    pub subject: String,
    /// The state.
    pub state: String,
    /// Its Jacobian.
    pub comparison: Comparison,
    /// How approximations depend on the step; empty of a constraint.
    pub steps: Steps,
}

/// One state of every type of the catalogue: both nodes turned and moved, axes aligned initially; with the fault that was planted in what a
/// report judged.
pub fn illustrate_catalogue(report: &Report) -> Vec<Illustration> {
    let of = |connection: &ConnectionType| {
        let mut tried = cases(connection, Extent::Brief).into_iter();
        tried.find_map(|case| Illustration::of(None, &connection.name, &case, report.settings.planted))
    };
    TABLE.par_iter().filter_map(of).collect()
}

/// The last state of the connectors and constraints of a scene, of each at most so many. Connectors that did not pass in a report come first.
/// Where a scene has no states, one is drawn about the initial one.
pub fn illustrate_scene(target: &Target<'_>, report: &Report, most: usize) -> Vec<Illustration> {
    let passed: HashSet<&str> = report
        .subjects
        .iter()
        .filter(|subject| subject.scene.as_deref() == Some(target.name))
        .filter(|subject| subject.derivative.headline() == Verdict::Pass)
        .map(|subject| subject.name.as_str())
        .collect();
    // Of a sample nothing is shown that was not judged.
    let share = report.sampled.iter().find(|share| share.scene == target.name);
    let mut connectors = share.map_or(&target.plan.connectors, |share| &share.judged).clone();
    let title = |at: &usize| target.model.connectors.get(*at).map(ConnectorElement::title);
    connectors.sort_by_cached_key(|at| title(at).is_none_or(|title| passed.contains(title.as_str())));
    connectors.truncate(most);
    connectors.sort_unstable();
    let cases = scene::last_cases(target, &connectors);
    let mut shown: Vec<Illustration> = cases
        .into_par_iter()
        .filter_map(|(title, case)| {
            Illustration::of(Some(target.name), &title, &case, report.settings.planted)
        })
        .collect();
    let mut constraints = scene::last_constraints(target);
    constraints.truncate(most);
    let of = |(title, case): (String, MpcCase)| {
        Illustration::of_constraint(target.name, &title, &case, report.settings.planted)
    };
    shown.extend(constraints.into_par_iter().filter_map(of).collect::<Vec<_>>());
    shown
}

/// The steps on 237 bits, by powers of ten.
const WIDE_STEPS: std::ops::RangeInclusive<i32> = -24..=-1;

/// The steps on doubles.
const STEPS: std::ops::RangeInclusive<i32> = -14..=-1;

impl Illustration {
    /// Of a constraint of a scene; `None` for one without equations.
    fn of_constraint(scene: &str, title: &str, case: &MpcCase, planted: Option<Planted>) -> Option<Self> {
        let mut tables = case.tables().into_iter();
        let mut rows = tables.find(|table| table.quantity == Quantity::FirstDerivatives)?;
        planted.into_iter().for_each(|planted| planted.spoil_table(&mut rows));
        Some(Self {
            scene: Some(scene.to_string()),
            subject: format!("{scene}: {title}"),
            state: case.name.clone(),
            comparison: rows.comparison(),
            steps: Steps::default(),
        })
    }

    /// Of the product at the end of a case, with the fault that is planted in it; `None` for an empty path, or on a singular set.
    fn of(scene: Option<&str>, name: &str, case: &Case, planted: Option<Planted>) -> Option<Self> {
        let end = case.at_end()?;
        let truth = Truth::at(&end);
        let nearness = truth.nearness();
        if nearness == 0.0 {
            return None;
        }
        let mut numbers = product_at(&end);
        planted.into_iter().for_each(|planted| planted.spoil(&mut numbers));
        let answers = WideAnswers::of(&truth);
        let trusted = crate::singular::atlas::truth_to_f64(&answers.differences);
        let bound = Bound::new(&trusted, &end.step.state, case.length, nearness);
        let rows = numbers.entries(Quantity::FirstDerivatives);
        let want = answers.differences.entries(Quantity::FirstDerivatives).map(|_, _, x| x.into());
        Some(Self {
            scene: scene.map(String::from),
            subject: scene.map_or_else(|| name.to_string(), |scene| format!("{scene}: {name}")),
            state: case.name.clone(),
            comparison: Comparison::new(rows, &want, |k, j| {
                bound.tolerance(Quantity::FirstDerivatives, k, j)
            }),
            steps: steps(&end, rows, &truth, &bound),
        })
    }
}

fn steps(end: &AtEnd<'_>, rows: &Entries<f64>, truth: &Truth, bound: &Bound) -> Steps {
    let AtEnd { case, connector, .. } = end;
    let narrow = Narrow::at(end);
    let draw = &mut Draw::new(&case.name);
    let drawn = draw.rates(1.0);
    let v: [f64; DOFS] = std::array::from_fn(|j| {
        let size = dof_size(j, case.length) * truth.nearness();
        if narrow.active()[j] { drawn[j] * size } else { 0.0 }
    });
    let slope = |k: usize| -> Option<Wide> {
        let row = rows.0[k].as_ref()?;
        Some(
            row.iter()
                .zip(&v)
                .fold(Wide::from_f64(0.0), |sum, (r, v)| sum + Wide::from_f64(*r) * Wide::from_f64(*v)),
        )
    };
    let slopes: Components<Wide> = std::array::from_fn(slope);
    let allowed: [f64; 6] = std::array::from_fn(|k| {
        (0..DOFS).map(|j| bound.tolerance(Quantity::FirstDerivatives, k, j) * v[j].abs()).sum()
    });
    let in_units = |error: f64, k: usize| if error == 0.0 { 0.0 } else { error / allowed[k] };
    let mut found = Steps::default();
    let still = truth.displaced(&[0.0; DOFS], 0.0);
    for exponent in WIDE_STEPS {
        let h = 10.0_f64.powi(exponent);
        let moved = truth.displaced(&v, h);
        let errors = (0..6).filter_map(|k| {
            let quotient = (moved[k]? - still[k]?) / Wide::from_f64(h);
            Some(in_units((quotient - slopes[k]?).abs().to_f64(), k))
        });
        found.remainder.push([h, errors.fold(0.0, f64::max)]);
    }
    for exponent in STEPS {
        let h = 10.0_f64.powi(exponent);
        let [plus, minus] = [h, -h].map(|h| narrow.values(&v.map(|v| v * h)));
        let errors = (0..6).filter_map(|k| {
            if connector.differentiated(k).is_none_or(|measure| measure.is_one_form()) {
                return None;
            }
            let quotient = (plus[k]? - minus[k]?) / (2.0 * h);
            Some(in_units((Wide::from_f64(quotient) - slopes[k]?).abs().to_f64(), k))
        });
        let largest = errors.fold(None, |most: Option<f64>, x| Some(most.map_or(x, |most| most.max(x))));
        found.differences.extend(largest.map(|error| [h, error]));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is shown is what was judged: the entry that is planted.
    #[test]
    fn a_planted_fault_is_shown() {
        let case = cases(&TABLE[0], Extent::Brief).swap_remove(0);
        let worst = |planted| {
            Illustration::of(None, "it", &case, planted).map_or(0.0, |shown| shown.comparison.worst())
        };
        assert!(worst(None) <= 1.0 && worst(Some(Planted::WrongEntry)) > 1e6);
    }

    /// The rows are right at every type, Taylor's remainder falls to the rounding of the row, and a difference quotient on
    /// doubles never gets there.
    #[test]
    fn curves_say_what_they_must() {
        for connection in TABLE {
            let case = cases(connection, Extent::Brief).swap_remove(0);
            let shown = Illustration::of(None, &connection.name, &case, None).unwrap();
            assert!(shown.comparison.worst() <= 1.0, "{}", connection.name);
            let last = shown.steps.remainder[0][1];
            assert!(last <= 1.0, "{}: {last}", connection.name);
            let nonlinear = shown.steps.remainder.last().unwrap()[1] > 1e3;
            let best = shown.steps.differences.iter().fold(f64::INFINITY, |least, p| least.min(p[1]));
            assert!(
                !nonlinear || best > 10.0 || shown.steps.differences.iter().all(|p| p[1] == 0.0),
                "{} {best}",
                connection.name
            );
        }
    }
}
