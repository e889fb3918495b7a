//! A solution as one page of HTML: its motion, forces, energies and events. Nothing is loaded from elsewhere.

use crate::audit::html::figure::{Medium, STYLE};
use crate::solve::Facts;
use crate::solve::motion::Motion;
use crate::solve::plot::{self, Curve, Plot};
use askama::Template;
use pintle_kinematics::catalog::COMPONENT;
use pintle_model::evaluate::Model;
use pintle_scene::Scene;
use pintle_solve::{Frame, Number, Solution};
use std::io::{self, Write};

struct Section {
    id: &'static str,
    name: &'static str,
    said: &'static str,
    svg: String,
}

#[derive(Template)]
#[template(path = "motion.html", escape = "html")]
struct Page<'a> {
    scene: &'a str,
    heading: &'a str,
    css: &'static str,
    figure_css: &'static str,
    plot_css: &'static str,
    own_css: &'static str,
    js: &'static str,
    tone: &'static str,
    sign: &'static str,
    sentence: String,
    facts: Vec<(&'static str, String)>,
    sections: Vec<(&'static str, &'static str)>,
    width: f64,
    last: usize,
    motion: Motion,
    plots: Vec<Section>,
    events: Vec<[String; 5]>,
    data: String,
}

/// Relative to the largest of their kind, changes below this are rounding.
const STILL: f64 = 1e-9;

/// What is drawn of a solution.
struct Drawn<'a, R> {
    solution: &'a Solution<R>,
    span: [f64; 2],
}

impl<'a, R: Number> Drawn<'a, R> {
    fn of(solution: &'a Solution<R>) -> Self {
        let time = |frame: Option<&Frame<R>>| frame.map_or(0.0, |frame| frame.time.to_f64());
        Self { solution, span: [time(solution.frames.first()), time(solution.frames.last())] }
    }

    fn curve(&self, name: String, of: impl Fn(&Frame<R>) -> R) -> Curve {
        let points = self.solution.frames.iter().map(|frame| [frame.time.to_f64(), of(frame).to_f64()]);
        Curve { name, points: points.collect(), is_friction: false }
    }

    /// Events, of one connector or of all.
    fn marks(&self, connector: Option<usize>) -> Vec<(f64, String)> {
        let events = self.solution.events.iter();
        let wanted = events.filter(|event| connector.is_none_or(|only| only == event.connector));
        wanted.map(|event| (event.time.to_f64(), event.what.name().to_string())).collect()
    }

    /// While all frictions of a connector stick.
    fn stuck(&self, connector: usize) -> Vec<[f64; 2]> {
        let mut found: Vec<[f64; 2]> = Vec::new();
        for pair in self.solution.frames.windows(2) {
            let sticks = &pair[0].connectors[connector].sticks;
            if sticks.is_empty() || !sticks.iter().all(|sticks| *sticks) {
                continue;
            }
            let [from, to] = [&pair[0], &pair[1]].map(|frame| frame.time.to_f64());
            match found.last_mut() {
                Some(last) if last[1] == from => last[1] = to,
                _ => found.push([from, to]),
            }
        }
        found
    }

    /// The motion of what is free, by connector and unit; of nodes where no connector moves.
    fn motions(&self) -> Vec<Plot> {
        let mut plots = Vec::new();
        for (c, (_, title)) in self.solution.connectors.iter().enumerate() {
            for (range, unit) in [(0..3, "length"), (3..6, "rad")] {
                let curves = range.clone().map(|k| {
                    self.curve(format!("CU {}", COMPONENT[k]), |frame| frame.connectors[c].displacement[k])
                });
                plots.extend(self.plot(format!("{title} ({unit})"), curves, Some(c)));
            }
        }
        if plots.is_empty() {
            for (n, label) in self.solution.nodes.iter().enumerate() {
                let curves =
                    (0..3).map(|k| self.curve(format!("u{}", k + 1), |frame| frame.nodes[n].displacement[k]));
                plots.extend(self.plot(format!("node {label} (length)"), curves, None));
            }
        }
        plots
    }

    /// Forces and friction, by connector and unit.
    fn forces(&self) -> Vec<Plot> {
        let mut plots = Vec::new();
        let frames = &self.solution.frames;
        for (c, (_, title)) in self.solution.connectors.iter().enumerate() {
            for (range, unit) in [(0..3, "force"), (3..6, "moment")] {
                let open = |k: &usize| frames.iter().any(|frame| frame.connectors[c].open[*k]);
                let total = range.clone().filter(|k| !open(k)).map(|k| {
                    self.curve(format!("CTF {}", COMPONENT[k]), |frame| frame.connectors[c].total[k])
                });
                let rubs_open = |k: &usize| frames.iter().any(|frame| frame.connectors[c].open_friction[*k]);
                let friction = range.clone().filter(|k| !rubs_open(k)).map(|k| {
                    let of = |frame: &Frame<R>| frame.connectors[c].friction[k];
                    Curve { is_friction: true, ..self.curve(format!("CSF {}", COMPONENT[k]), of) }
                });
                plots.extend(self.plot(format!("{title} ({unit})"), total.chain(friction), Some(c)));
            }
        }
        plots
    }

    /// A plot of the curves that are not zero.
    fn plot(
        &self,
        y_name: String,
        curves: impl Iterator<Item = Curve>,
        connector: Option<usize>,
    ) -> Option<Plot> {
        let most = |curve: &Curve| {
            curve.points.iter().map(|[_, y]| y.abs()).filter(|y| y.is_finite()).fold(0.0, f64::max)
        };
        let all: Vec<Curve> = curves.collect();
        let largest = all.iter().map(most).fold(0.0, f64::max);
        let shown: Vec<Curve> =
            all.into_iter().filter(|curve| most(curve) > (STILL * largest).max(1e-14)).collect();
        (!shown.is_empty()).then(|| Plot {
            y_name,
            span: self.span,
            curves: shown,
            shaded: connector.map_or(Vec::new(), |connector| self.stuck(connector)),
            marks: self.marks(connector),
        })
    }

    fn energies(&self) -> Vec<Plot> {
        let stored = if self.solution.stored_is_open { "stored since the first state" } else { "stored" };
        let curves = [
            self.curve("kinetic".into(), |frame| frame.energies.kinetic),
            self.curve(stored.into(), |frame| frame.energies.stored),
            self.curve("dissipated".into(), |frame| frame.energies.dissipated),
            self.curve("external work".into(), |frame| frame.energies.external),
        ];
        self.plot("energy".into(), curves.into_iter(), None).into_iter().collect()
    }
}

/// The picture of a solution as a file of its own: a motion, and the force beside it.
///
/// What rubs is shown first, else what moves most.
pub fn picture<R: Number>(solution: &Solution<R>, title: &str) -> String {
    let drawn = Drawn::of(solution);
    let rubs = |plot: &Plot| !plot.shaded.is_empty() || plot.curves.iter().any(|of| of.is_friction);
    let first = |mut plots: Vec<Plot>| {
        plots.sort_by_key(|plot| !rubs(plot));
        plots.into_iter().next()
    };
    let plots: Vec<Plot> = [first(drawn.motions()), first(drawn.forces())].into_iter().flatten().collect();
    let plots = if plots.is_empty() { drawn.energies() } else { plots };
    Plot::svg(&plots, title, Medium::File)
}

/// Writes a solution as one self-contained page.
///
/// # Errors
/// Those of the stream.
pub fn html<R: Number>(
    out: &mut dyn Write,
    solution: &Solution<R>,
    (scene, model): (&Scene, &Model),
    facts: Facts<'_>,
) -> io::Result<()> {
    let drawn = Drawn::of(solution);
    let digits = facts.digits::<R>();
    let motion = Motion::of(scene, model, solution);
    let all = [
        (
            "positions",
            "Positions",
            "Of components that move. Shaded while the friction sticks; dotted lines are events.",
            drawn.motions(),
        ),
        (
            "forces",
            "Forces and friction",
            "CTF is the total force of a component, CSF its friction. Shaded while the friction sticks.",
            drawn.forces(),
        ),
        (
            "energies",
            "Energies",
            "Since the beginning. External work is that of loads, gravity and what is prescribed.",
            drawn.energies(),
        ),
    ];
    let plots: Vec<Section> = all
        .into_iter()
        .filter(|(.., plots)| !plots.is_empty())
        .map(|(id, name, said, plots)| Section { id, name, said, svg: Plot::svg(&plots, name, Medium::Page) })
        .collect();
    let mut sections = vec![("motion", "motion")];
    sections.extend(plots.iter().map(|of| (of.id, of.id)));
    if !solution.events.is_empty() {
        sections.push(("events", "events"));
    }
    let events = solution.events.iter().map(|event| {
        let title = solution.connectors.get(event.connector).map_or("", |(_, title)| title.as_str());
        [
            event.time.digits(digits),
            format!("{title} {}", super::slides(event)),
            event.what.name().to_string(),
            super::margin(event),
            format!("{:.3}", event.lipschitz),
        ]
    });
    let is_unsure = facts.difference.is_some_and(|difference| !difference.same_events);
    let (tone, sign) = match (facts.ended, is_unsure) {
        (Some(_), _) => ("bad", "✗"),
        (None, true) => ("open", "?"),
        (None, false) => ("good", "✓"),
    };
    let sentence = match (facts.ended, facts.difference) {
        (Some(why), _) => format!("Ended early {why}"),
        (None, Some(_)) if is_unsure => format!("No digit is certain: {}.", facts.doubt()),
        (None, Some(difference)) => format!(
            "Solved from {} to {}, with an error of {:.0e} ({}).",
            drawn.span[0],
            drawn.span[1],
            difference.largest(),
            facts.level::<R>()
        ),
        (None, None) => {
            format!("Solved from {} to {} by one method alone.", drawn.span[0], drawn.span[1])
        }
    };
    let balance =
        solution.frames.iter().map(|frame| frame.energies.balance.to_f64().abs()).fold(0.0, f64::max);
    let told = vec![
        ("steps", solution.steps.to_string()),
        ("events", solution.events.len().to_string()),
        ("rows violated by", format!("{:.0e}", solution.violation)),
        ("energy balance", format!("{balance:.0e}")),
        ("κ", format!("{:.3}", solution.lipschitz)),
    ];
    let page = Page {
        scene: facts.scene,
        heading: scene.heading.trim(),
        css: include_str!("../audit/html/templates/page.css"),
        figure_css: STYLE,
        plot_css: plot::STYLE,
        own_css: include_str!("templates/motion.css"),
        js: include_str!("templates/motion.js"),
        tone,
        sign,
        sentence,
        facts: told,
        sections,
        width: Motion::WIDTH,
        last: solution.frames.len().saturating_sub(1),
        data: data(solution, &motion),
        motion,
        plots,
        events: events.collect(),
    };
    out.write_all(page.render().map_err(io::Error::other)?.as_bytes())
}

/// Times, points and what sticks, frame by frame.
fn data<R: Number>(solution: &Solution<R>, motion: &Motion) -> String {
    let times: Vec<f64> = solution.frames.iter().map(|frame| frame.time.to_f64()).collect();
    let sticks = |frame: &Frame<R>| -> Vec<usize> {
        let all = frame.connectors.iter().enumerate();
        all.filter(|(_, of)| !of.sticks.is_empty() && of.sticks.iter().all(|sticks| *sticks))
            .map(|(c, _)| c)
            .collect()
    };
    let points: Vec<Vec<f64>> = motion.frames.iter().map(|all| all.concat()).collect();
    let sticks: Vec<Vec<usize>> = solution.frames.iter().map(sticks).collect();
    serde_json::json!({ "times": times, "across": Plot::ACROSS, "points": points, "sticks": sticks })
        .to_string()
}
