//! What was found in models: findings, the assembly as a whole, and which states were covered.

use crate::audit::groups;
use crate::audit::html::figure;
use crate::audit::html::figure::{Bin, Map};
use crate::audit::html::prose::{grouped, grouped_signed, sentence};
use crate::audit::model as of_assembly;
use pintle_assembly::Assembly;
use pintle_audit::Report;
use pintle_audit::model::ModelReport;
use pintle_audit::sampling::coverage::Histogram;
use pintle_scene::grammar::count;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

pub(super) struct FindingRow {
    pub(super) class: String,
    pub(super) severity: String,
    pub(super) code: &'static str,
    pub(super) place: String,
    pub(super) message: String,
    pub(super) others: String,
    pub(super) reason: String,
    pub(super) remedy: String,
}

pub(super) struct CoverageSection {
    pub(super) scene: String,
    pub(super) summary: String,
    pub(super) maps: Vec<Map>,
}

/// The assembly as a whole, in one step.
pub(super) struct AssemblySection {
    /// Which step; nothing where there is but one.
    pub(super) step: String,
    /// Figure by figure, initially.
    pub(super) figures: Vec<(&'static str, String)>,
    /// What is not as initially at the states given, and what was not looked at.
    pub(super) more: Vec<String>,
}

pub(super) struct ModelSection {
    pub(super) scene: String,
    pub(super) summary: String,
    pub(super) assemblies: Vec<AssemblySection>,
    pub(super) findings: Vec<FindingRow>,
}

pub(super) fn model(found: &ModelReport) -> ModelSection {
    let states = match found.states {
        0 => "at the initial state".to_string(),
        n => format!("at the initial state and {}", count(n, "state")),
    };
    ModelSection {
        scene: found.scene.clone(),
        summary: match found.findings.len() {
            0 => format!("Nothing was found {states}."),
            n => format!("{}, {states}.", count(n, "finding")),
        },
        assemblies: found
            .assembly
            .iter()
            .chain(&found.later_steps)
            .map(|of_step| assembly(of_step, !found.later_steps.is_empty()))
            .collect(),
        findings: groups::findings(&found.findings)
            .iter()
            .map(|group| {
                let finding = group.first;
                let severity = format!("{:?}", finding.severity()).to_lowercase();
                let line = finding.line().map_or_else(String::new, |line| format!(":{line}"));
                FindingRow {
                    class: severity.clone(),
                    severity,
                    code: finding.code().as_str(),
                    place: format!("{}{line}", finding.file()),
                    message: sentence(finding.message()),
                    others: if group.others().is_empty() { String::new() } else { sentence(&group.others()) },
                    reason: if finding.reason().is_empty() {
                        String::new()
                    } else {
                        sentence(finding.reason())
                    },
                    remedy: finding.remedy().to_string(),
                }
            })
            .collect(),
    }
}

pub(super) fn assembly(found: &Assembly, is_of_many: bool) -> AssemblySection {
    let mut figures = vec![
        ("degrees of freedom", grouped(found.degrees_of_freedom as u64)),
        ("held by boundary conditions", grouped(found.held as u64)),
        ("constraints", grouped(found.constraints as u64)),
        ("drives", grouped(found.drives as u64)),
        ("mobility by Grübler", grouped_signed(found.gruebler)),
    ];
    let known =
        |number: Option<usize>| number.map_or_else(|| "not known".into(), |number| grouped(number as u64));
    if let Some(initial) = found.positions.first() {
        let certainty = if initial.decided { "" } else { ", undecided" };
        figures.extend([
            ("rank of the constraints", known(initial.rank) + certainty),
            ("redundant", known(initial.redundant)),
            ("mobility", known(initial.mobility)),
            ("not driven", known(initial.undriven)),
        ]);
    }
    if !found.unread.is_empty() {
        let kinds: Vec<&str> = found.unread.iter().map(|kind| kind.what.as_str()).collect();
        figures.push(("constraints not read", kinds.join(", ")));
    }
    let step = match (is_of_many, found.step) {
        (false, _) => String::new(),
        (true, 0) => "Before the first step".to_string(),
        (true, step) => format!("Step {step}"),
    };
    AssemblySection {
        step,
        figures,
        more: of_assembly::besides(found).iter().map(|line| sentence(line)).collect(),
    }
}

/// Which region of configuration space the states of a scene exercised; nothing where there were no samples.
pub(super) fn coverage(found: &ModelReport) -> Option<CoverageSection> {
    let coverage = &found.coverage;
    if coverage.exercise.is_empty() {
        return None;
    }
    let all = [
        &coverage.rotation_a,
        &coverage.rotation_b,
        &coverage.relative_rotation,
        &coverage.stretch,
        &coverage.margin,
    ];
    let of = |n: u64, all: u64| format!("{} of {}", grouped(n), grouped(all));
    Some(CoverageSection {
        scene: found.scene.clone(),
        summary: format!(
            "{}, every connector at each state{}: both nodes turned by more than 0.1 rad in {}, free components moved in {}, \
             away from the initial state in {}.{}{}",
            count(coverage.exercise.samples, "sample"),
            if found.drawn { ", drawn about the initial one, for the scene gives none" } else { "" },
            of(coverage.exercise.both_turned, coverage.exercise.could_turn_both),
            of(coverage.exercise.deformed, coverage.exercise.could_deform),
            of(coverage.exercise.away, coverage.exercise.samples),
            match coverage.exercise.standing {
                0 => String::new(),
                standing => format!(" Besides, {} of connectors whose nodes stand still.", grouped(standing)),
            },
            found
                .nearest
                .as_ref()
                .map_or_else(String::new, |nearest| format!(" The {}.", of_assembly::nearest(nearest)))
        ),
        maps: all.into_iter().filter(|histogram| histogram.samples() > 0).map(map).collect(),
    })
}

/// The lower edge of a bin, short enough to stand below it.
pub(super) fn edge_name(edge: f64) -> String {
    /// Edges that are so near to 1 are told by what they are away from it.
    const NEAR: f64 = 1e-3;
    let plain = |x: f64| if x == 0.0 || (1e-3..1e3).contains(&x) { format!("{x}") } else { format!("{x:e}") };
    /// An angle of π is written so, and what lets its rounding be in the bin before.
    const ROUNDED: f64 = 1e-8;
    match edge {
        x if (x - PI).abs() < ROUNDED => "π".to_string(),
        FRAC_PI_2 => "π/2".to_string(),
        TAU => "2π".to_string(),
        x if x != 1.0 && (x - 1.0).abs() < NEAR => {
            let sign = if x < 1.0 { '−' } else { '+' };
            format!("1{sign}{:.0e}", (x - 1.0).abs())
        }
        x => plain(x),
    }
}

pub(super) fn map(histogram: &Histogram) -> Map {
    let samples = histogram.samples();
    let bins = histogram.edges.iter().zip(&histogram.counts).map(|(edge, count)| {
        let share = *count as f64 / samples.max(1) as f64;
        let depth = match share {
            0.0 => 0,
            x if x < 0.01 => 1,
            x if x < 0.1 => 2,
            x if x < 0.5 => 3,
            _ => 4,
        };
        Bin { depth, from: edge_name(*edge), count: if *count == 0 { "–".into() } else { grouped(*count) } }
    });
    let unit = if histogram.unit.is_empty() { String::new() } else { format!(", {}", histogram.unit) };
    Map {
        name: format!("{}{unit}", histogram.quantity),
        bins: bins.collect(),
        largest: format!("{:.3}", histogram.largest),
    }
}

/// The histograms of coverage of the scenes, each as a file's text, by name.
pub(super) fn coverage_figures(report: &Report) -> Vec<(String, String)> {
    let of = |section: CoverageSection| {
        let title = format!("{}: where the samples of its states lie", section.scene);
        let figure = figure::coverage(&title, &section.maps);
        (section.scene, figure)
    };
    report.models.iter().filter_map(coverage).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::edge_name;
    use std::f64::consts::{FRAC_PI_2, PI};

    #[test]
    fn edges_are_short() {
        let edges = [0.0, 1e-6, 0.001, 0.5, FRAC_PI_2, PI, 1.0 - 1e-6, 1.0 + 1e-6, 1.0, 2.0, 1e4];
        let said = ["0", "1e-6", "0.001", "0.5", "π/2", "π", "1−1e-6", "1+1e-6", "1", "2", "1e4"];
        assert_eq!(edges.map(edge_name), said);
    }
}
