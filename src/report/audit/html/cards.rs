//! Which figures are shown: matrices, steps, singular points, the smallest errors noticed.

use crate::audit::html::figure::{Curve, LogPlot, Medium};
use crate::audit::html::{Supplement, figure};
use crate::audit::model as of_assembly;
use crate::audit::summary::is_sharp;
use pintle_audit::model::Nearest;
use pintle_audit::{Approach, Check, Quantity, Report, Subject};
use pintle_kinematics::scalar::U;

pub(super) struct Card {
    pub(super) name: String,
    pub(super) caption: String,
    pub(super) heat: String,
}

pub(super) struct StepCard {
    pub(super) name: String,
    pub(super) svg: String,
}

pub(super) struct ApproachCard {
    pub(super) name: String,
    pub(super) at: &'static str,
    pub(super) class: String,
    pub(super) class_name: String,
    pub(super) svg: String,
    /// How near a scene came.
    pub(super) came: String,
}

pub(super) fn cards(supplement: &Supplement<'_>) -> Vec<Card> {
    let card = |shown: &pintle_audit::Illustration| Card {
        name: shown.subject.clone(),
        caption: format!("{}; worst {:.2} tolerances", shown.state, shown.comparison.worst()),
        heat: figure::heat(&shown.subject, &shown.comparison, Medium::Page),
    };
    supplement.illustrations.iter().map(card).collect()
}

pub(super) fn omitted(report: &Report, supplement: &Supplement<'_>) -> String {
    let (all, shown) = (report.subjects.len(), supplement.illustrations.len());
    if shown < all { format!("Shown are {shown} of {all}.") } else { String::new() }
}

pub(super) fn step_cards(supplement: &Supplement<'_>) -> Vec<StepCard> {
    let has_curves = |shown: &&pintle_audit::Illustration| !shown.steps.remainder.is_empty();
    let card = |shown: &pintle_audit::Illustration| StepCard {
        name: shown.subject.clone(),
        svg: figure::steps(shown, Medium::Page),
    };
    supplement.illustrations.iter().filter(has_curves).map(card).collect()
}

/// A curve of a singular set.
pub(super) struct ApproachCurve {
    /// Its name in a figure.
    name: &'static str,
    /// 1, 2, 3 …: colour and dashes.
    pub(super) colour: u8,
    /// What it is, below the figures of a page.
    pub(super) said: &'static str,
    of: fn(&pintle_audit::singular::atlas::Rung) -> f64,
}

/// The curves of a singular set.
pub(super) const APPROACH: [ApproachCurve; 4] = [
    ApproachCurve {
        name: "error, of the conditioned scale",
        colour: 1,
        said: "error of a derivative, in roundings of its conditioned scale",
        of: |rung| rung.first_error,
    },
    ApproachCurve {
        name: "error, of the largest derivative",
        colour: 2,
        said: "the same relative to the largest of its row, in roundings",
        of: |rung| rung.first_relative / U,
    },
    ApproachCurve {
        name: "largest derivative",
        colour: 3,
        said: "largest derivative",
        of: |rung| rung.steepness,
    },
    ApproachCurve {
        name: "error of the largest derivative that is noticed",
        colour: 4,
        said: "error of the largest derivative that is noticed",
        of: |rung| rung.detectable / U,
    },
];

/// The figure of a singular set.
pub(super) fn approach(found: &Approach, place: Medium) -> String {
    let curve = |ApproachCurve { name, colour, of, .. }| Curve {
        name,
        is_main: false,
        colour,
        points: found.rungs.iter().map(|rung| [rung.distance, of(rung)]).collect(),
    };
    let plot = LogPlot {
        title: &format!("{} {}: {}", found.connection, found.component, found.at),
        heading: Vec::new(),
        x_name: "distance to the singular set",
        y_name: "roundings; size",
        curves: APPROACH.map(curve).into(),
        levels: vec![(pintle_audit::C, "tolerance")],
        has_legend: false,
    };
    plot.svg(place)
}

/// The singular sets of the catalogue that was audited, or of the types of the scenes.
pub(super) fn approaches<'a>(
    report: &'a Report,
    supplement: &'a Supplement<'_>,
) -> impl Iterator<Item = &'a Approach> {
    report.atlas.iter().chain(&supplement.approaches)
}

pub(super) fn approach_card(found: &Approach, report: &Report, supplement: &Supplement<'_>) -> ApproachCard {
    let (class, class_name) = if found.is_confirmed() {
        let (name, _) = crate::words::singular_class(found.declared);
        ("pass", format!("{name}, confirmed"))
    } else {
        ("wrong", found.told())
    };
    ApproachCard {
        name: format!("{} {}", found.connection, found.component),
        at: found.at,
        class: class.into(),
        class_name,
        svg: approach(found, Medium::Page),
        came: came(found, report, supplement),
    }
}

/// How near the states of a scene came to a singular set, where it is the nearest of the scene: told once of a set that is approached at
/// both its ends.
pub(super) fn came(found: &Approach, report: &Report, supplement: &Supplement<'_>) -> String {
    let is_same = |other: &&Approach| {
        (&other.connection, other.component, other.set) == (&found.connection, found.component, found.set)
    };
    if !approaches(report, supplement).find(is_same).is_some_and(|first| std::ptr::eq(first, found)) {
        return String::new();
    }
    let is_of = |(scene, nearest): &(&crate::audit::html::Audited<'_>, &Nearest)| {
        let element = scene.model.connectors.iter().find(|element| element.label == nearest.element);
        let is_type = element.is_some_and(|element| element.definition().connection.name == found.connection);
        is_type && nearest.component == found.component && nearest.at == found.set
    };
    let of_scene = |scene: &'_ crate::audit::html::Audited<'_>| {
        report.models.iter().find(|model| model.scene == scene.scene.name)?.nearest.as_ref()
    };
    let all = supplement.scenes.iter().filter_map(|scene| Some((scene, of_scene(scene)?)));
    let lines = all
        .filter(is_of)
        .map(|(scene, nearest)| format!("{}: {}", scene.name, of_assembly::nearest(nearest)));
    lines.collect::<Vec<_>>().join("; ")
}

pub(super) fn confirmed(report: &Report, supplement: &Supplement<'_>) -> String {
    let all = approaches(report, supplement).count();
    let confirmed = approaches(report, supplement).filter(|approach| approach.is_confirmed()).count();
    let whose = if supplement.approaches.is_empty() {
        ""
    } else {
        " They are of the types that the scenes use, approached from states drawn about their initial one, not from those of the scenes."
    };
    format!("{confirmed} of {all} are confirmed.{whose}")
}

/// The smallest error that is noticed, by connector: a plot against the rank.
pub(super) fn strip(report: &Report, place: Medium) -> String {
    let sharp = |subject: &Subject| {
        let is_it = |check: &&Check| check.quantity == Some(Quantity::FirstDerivatives) && is_sharp(check);
        let scores = || subject.checks.iter().filter(is_it).map(|check| &check.score);
        let most = |of: fn(&pintle_audit::Score) -> Option<f64>| scores().filter_map(of).fold(0.0, f64::max);
        [most(|score| score.detectable_median), most(|score| score.detectable)]
    };
    let mut all: Vec<(&Subject, [f64; 2])> =
        report.subjects.iter().map(|subject| (subject, sharp(subject))).filter(|x| x.1[0] > 0.0).collect();
    if all.len() < 2 {
        return String::new();
    }
    all.sort_by(|x, y| x.1[0].total_cmp(&y.1[0]).then(x.1[1].total_cmp(&y.1[1])));
    figure::strip("The smallest relative error that is noticed on every significant entry", &all, place)
}
