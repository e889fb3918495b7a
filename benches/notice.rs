//! The smallest relative error of one entry of a Jacobian that a check notices, against the time that the check takes: the oracles of the audit,
//! and the default rules of other checkers (`examples/peer_rules`).
//!
//! All judge the same states: a smooth set, and one near singular sets. Entries × (1 + δ) are tried, δ from 0.1 down to 1e-14 by tens. What counts
//! is the smallest δ from which on each significant entry is noticed. Before anything is timed, the right Jacobian goes through every check:
//! of the audit none may call it wrong. Times are the least of rounds that take turns, on one core.
//!
//! `python3 scripts/measure.py notice` writes the tables and the picture into docs/explanation.

#[path = "hand/commit.rs"]
mod commit;
#[path = "hand/picture_file.rs"]
mod picture_file;
#[path = "../examples/peer_rules/rules.rs"]
mod rules;
#[path = "../examples/peer_rules/subject.rs"]
mod subject;

use pintle_audit::judge::judged::{SIGNIFICANT, Trials};
use pintle_audit::mutants::mutant::{Mistake, Mutant, Scene, mutants};
use pintle_audit::oracles::oracle::{Answer, Narrow};
use pintle_audit::oracles::truth::Truth;
use pintle_audit::sampling::{Region, draw_case};
use pintle_audit::singular::atlas;
use pintle_audit::{Bound, Case, Entries, Oracle, Quantity, product};
use pintle_bench::Environment;
use pintle_kinematics::catalog::ConnectionType;
use pintle_kinematics::draw::Draw;
use pintle_kinematics::node::dof_size;
use plotters::prelude::*;
use rules::{Jacobian, NAMES, Peers, Problem, exceeds};
use std::error::Error;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;
use subject::{Subject, functions};

type Result<T> = std::result::Result<T, Box<dyn Error + Send + Sync>>;

const FIRST: Quantity = Quantity::FirstDerivatives;
const ROUNDS: usize = 5;
/// States of each type.
const EACH: usize = 3;

/// A state with what checks are given.
struct Given {
    case: Case,
    rows: Entries<f64>,
    bound: Bound,
    narrow: Narrow,
    subject: Subject,
    /// What DifferentiationInterfaceTest is given as the right Jacobian.
    right: Jacobian,
    /// Entries × (1 + δ), and whether they are significant.
    tried: Vec<(f64, bool, Mutant)>,
}

/// Whether a check calls rows wrong.
type Judge<'a> = Box<dyn Fn(&Entries<f64>) -> bool + 'a>;

/// What a check computes of a state before it sees a Jacobian.
type Prepare = Box<dyn for<'a> Fn(&'a Given) -> Option<Judge<'a>>>;

/// A check.
struct Way {
    name: String,
    prepare: Prepare,
    is_ours: bool,
}

/// What was found of a check at a set of states.
#[derive(Clone)]
struct Found {
    seconds: f64,
    /// The smallest δ at each state without a false alarm, sorted.
    noticed: Vec<f64>,
    false_alarms: usize,
}

impl Given {
    fn of(case: Case) -> Option<Self> {
        let (numbers, narrow, state) = (product(&case)?, Narrow::of(&case)?, case.last()?.state);
        let rows = numbers.entries(FIRST).clone();
        let subject = Subject::of(&case, &rows)?;
        let bound = Bound::new(&numbers, &state, case.length, narrow.nearness());
        let truth = Truth::of(&case)?.first();
        let right = subject.jacobian(|k, j| truth.get(k, j).map(|x| x.to_f64()));
        let scale = |k: usize, i: usize| bound.scale(FIRST, k, i);
        let units = std::array::from_fn(|k| subject.connector.differentiated(k).map(|m| m.unit()));
        let all =
            mutants(FIRST, &Scene { numbers: &numbers, case: &case, units, turns: [0.0; 6], scale: &scale });
        let size = |k: usize, i: usize| rows.get(k, i).map_or(0.0, |x| x.abs() * dof_size(i, case.length));
        let largest = |k: usize| (0..14).map(|i| size(k, i)).fold(0.0, f64::max);
        let scaled = all.into_iter().filter_map(|mutant| {
            let Mistake::Scaled(delta) = mutant.mistake else { return None };
            let &(k, i, _) = mutant.changes.iter().next()?;
            Some((delta, size(k, i) >= SIGNIFICANT * largest(k), mutant))
        });
        let tried = scaled.collect();
        Some(Self { rows, bound, narrow, subject, right, tried, case })
    }

    fn judge(&self, answer: Answer) -> Judge<'_> {
        Box::new(move |rows| {
            rows.iter().any(|(k, i, x)| {
                let want = answer.numbers.get(k, i);
                want.is_some_and(|want| exceeds(want.error(x), answer.allowed(&self.bound, FIRST, k, i)))
            })
        })
    }

    fn answer(&self, oracle: Oracle) -> Option<Answer> {
        let (narrow, bound) = (&self.narrow, &self.bound);
        let truth = || Truth::of(&self.case);
        Some(match oracle {
            Oracle::WideDifferences => Answer::sharp(oracle, &truth()?.first()),
            Oracle::WideSymbolic => Answer::sharp(oracle, truth()?.symbolic().entries(FIRST)),
            Oracle::WideDual => Answer::sharp(oracle, truth()?.dual().entries(FIRST)),
            Oracle::NodalDual => narrow.nodal_dual(bound),
            Oracle::Symbolic => {
                let found = narrow.symbolic();
                Answer::traced(FIRST, found.entries(FIRST), bound, &narrow.nearness_of_components())
            }
            Oracle::Differences => narrow.differences(bound),
            _ => return None,
        })
    }
}

/// The oracles of the audit that judge first derivatives entry by entry, then the rules of others.
fn ways() -> Vec<Way> {
    let ours = [
        Oracle::WideDifferences,
        Oracle::WideSymbolic,
        Oracle::WideDual,
        Oracle::NodalDual,
        Oracle::Symbolic,
        Oracle::Differences,
    ];
    let of_ours = ours.into_iter().map(|oracle| Way {
        name: format!("pintle, {}", oracle.name()),
        prepare: Box::new(move |given| Some(given.judge(given.answer(oracle)?))),
        is_ours: true,
    });
    let of_others = Peers::PREPARED.into_iter().map(|(rule, prepare)| Way {
        name: NAMES[rule].to_owned(),
        prepare: Box::new(move |given| {
            let values = |x: &[f64]| given.subject.values(x);
            let mut peers = Peers::default();
            prepare(&mut peers, &Problem { at: given.subject.parameters(), values: &values });
            Some(Box::new(move |rows: &Entries<f64>| {
                peers.is_wrong(rule, &given.subject.jacobian(|k, j| rows.get(k, j)), &given.right)
            }) as Judge<'_>)
        }),
        is_ours: false,
    });
    of_ours.chain(of_others).collect()
}

/// What each check finds at the states, and how long it takes.
fn measured(ways: &[Way], states: &[Given]) -> Result<Vec<Found>> {
    let mut all = Vec::with_capacity(ways.len());
    for way in ways {
        let mut found = Found { seconds: f64::INFINITY, noticed: Vec::new(), false_alarms: 0 };
        for given in states {
            let judge = (way.prepare)(given).ok_or_else(|| format!("{} gives nothing", way.name))?;
            if judge(&given.rows) {
                found.false_alarms += 1;
                continue;
            }
            let mut trials = Trials::default();
            for (delta, is_significant, mutant) in &given.tried {
                trials.see(*delta, judge(&mutant.applied(&given.rows)), *is_significant);
            }
            found.noticed.extend(trials.score().detectable_at);
        }
        if way.is_ours && found.false_alarms > 0 {
            return Err(format!("{}: {} false alarms", way.name, found.false_alarms).into());
        }
        found.noticed.sort_by(f64::total_cmp);
        all.push(found);
    }
    for _ in 0..ROUNDS {
        for (way, found) in ways.iter().zip(&mut all) {
            let start = Instant::now();
            for given in states {
                let judge = (way.prepare)(given).ok_or("nothing")?;
                black_box(judge(&given.rows));
            }
            found.seconds = found.seconds.min(start.elapsed().as_secs_f64() / states.len() as f64);
        }
    }
    Ok(all)
}

fn time(seconds: f64) -> String {
    match seconds * 1e6 {
        us if us < 10.0 => format!("{us:.1} µs"),
        us if us < 1e3 => format!("{us:.0} µs"),
        us => format!("{:.1} ms", us / 1e3),
    }
}

/// At the middle state and the worst one, of those without a false alarm; 1 where an entry of 0.1 too much passes.
fn noticed(found: &Found) -> [Option<f64>; 2] {
    [found.noticed.get(found.noticed.len() / 2).copied(), found.noticed.last().copied()]
}

fn print(title: &str, ways: &[Way], all: &[Found], states: usize) {
    println!("{title}, {states} states");
    println!("{:32}{:>10}{:>14}{:>10}{:>18}", "", "a state", "δ noticed", "at worst", "false alarms");
    for (way, found) in ways.iter().zip(all) {
        let [middle, worst] =
            noticed(found).map(|delta| delta.map_or_else(|| "–".into(), |x| format!("{x:.0e}")));
        let alarms = format!("{} of {states}", found.false_alarms);
        println!("{:32}{:>10}{middle:>14}{worst:>10}{alarms:>18}", way.name, time(found.seconds));
    }
}

const OURS: RGBColor = RGBColor(0, 70, 200);
const OTHERS: RGBColor = RGBColor(205, 40, 40);
const WIDTH: u32 = 620;
const HEIGHT: u32 = 460;

/// A panel for each set of states: time across, the noticed δ upwards. A check with false alarms is drawn hollow.
fn draw(panels: &[(&str, usize, Vec<Found>)], ways: &[Way], told: &str, path: &Path) -> Result<()> {
    let whole = SVGBackend::new(path, (WIDTH * panels.len() as u32, HEIGHT + 30)).into_drawing_area();
    whole.fill(&WHITE)?;
    let (area, below) = whole.split_vertically(HEIGHT);
    below.draw(&Text::new(told, (14, 6), ("sans-serif", 13)))?;
    for ((title, states, all), area) in panels.iter().zip(area.split_evenly((1, panels.len()))) {
        let mut chart = ChartBuilder::on(&area)
            .caption(*title, ("sans-serif", 17))
            .margin(14)
            .x_label_area_size(44)
            .y_label_area_size(70)
            .build_cartesian_2d(-6.5..-2.0, -15.0..0.8)?;
        let power = |x: &f64| if x.fract() == 0.0 { format!("1e{x:.0}") } else { String::new() };
        chart
            .configure_mesh()
            .x_desc("seconds for the Jacobian of one state")
            .y_desc("smallest relative error of an entry that is noticed")
            .axis_desc_style(("sans-serif", 14))
            .label_style(("sans-serif", 13))
            .y_labels(16)
            .x_max_light_lines(0)
            .y_max_light_lines(0)
            .x_label_formatter(&power)
            .y_label_formatter(&power)
            .bold_line_style(RGBColor(225, 225, 225))
            .draw()?;
        let points = ways.iter().zip(all).map(|(way, found)| {
            let [middle, _] = noticed(found);
            (way, found, (found.seconds.log10(), middle.map_or(0.0, f64::log10)))
        });
        let mut labels: Vec<(f64, f64)> = Vec::new();
        for (way, found, (x, y)) in points {
            let colour = if way.is_ours { OURS } else { OTHERS };
            let style = if found.false_alarms == 0 { colour.filled() } else { colour.stroke_width(2) };
            // A label goes up until it covers no other.
            let mut height = y;
            while labels.iter().any(|(at, up)| (at - x).abs() < 1.9 && (up - height).abs() < 0.55) {
                height += 0.55;
            }
            labels.push((x, height));
            let alarms = match found.false_alarms {
                0 => String::new(),
                some => format!(" ({some} of {states} false)"),
            };
            chart.draw_series([Circle::new((x, y), 4, style)])?;
            let label = format!("{}{alarms}", way.name.trim_start_matches("pintle, "));
            let place = chart.backend_coord(&(x, height));
            area.draw(&Text::new(
                label,
                (place.0 - area.get_base_pixel().0 + 8, place.1 - area.get_base_pixel().1 - 7),
                ("sans-serif", 12).into_font().color(&colour),
            ))?;
        }
    }
    whole.present()?;
    Ok(())
}

fn main() -> Result<()> {
    if commit::is_told() {
        return Ok(());
    }
    let picture = picture_file::picture_file("notice.svg")?;
    rules::tried();
    let ways = ways();
    let drawn = |seed: &str, draw_one: &dyn Fn(&'static ConnectionType, &mut Draw) -> Option<Case>| {
        let draw = &mut Draw::new(seed);
        let cases: Vec<Case> =
            functions().flat_map(|of| [of; EACH]).filter_map(|of| draw_one(of, draw)).collect();
        cases.into_iter().filter_map(Given::of).collect::<Vec<_>>()
    };
    let far = drawn("notice", &|of, draw| draw_case(of, Region::Aligned, draw));
    let near = drawn("notice, near", &atlas::random_near);
    let mut panels = Vec::new();
    for (title, states) in [("both nodes turned and moved", far), ("1e-1 to 1e-12 from a singular set", near)]
    {
        assert!(states.len() > 2 * EACH, "{title}: {} states", states.len());
        let all = measured(&ways, &states)?;
        print(title, &ways, &all, states.len());
        println!();
        panels.push((title, states.len(), all));
    }
    draw(&panels, &ways, &Environment::here().short(), &picture)?;
    eprintln!("drawn into {}", picture.display());
    Ok(())
}
