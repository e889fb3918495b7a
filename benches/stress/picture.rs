//! Curves of errors, and their picture.

use pintle_bench::worse;
use plotters::prelude::*;
use std::error::Error;
use std::path::Path;

/// What was swept, and the errors found.
pub(crate) struct Curve {
    pub(crate) of: &'static str,
    pub(crate) points: Vec<(f64, f64)>,
}

impl Curve {
    pub(crate) const fn new(of: &'static str) -> Self {
        Self { of, points: Vec::new() }
    }

    pub(crate) fn add(&mut self, swept: f64, error: f64) {
        self.points.push((swept, error));
    }

    pub(crate) fn worst(&self) -> f64 {
        self.points.iter().fold(0.0, |worst, (_, error)| worse(worst, *error))
    }
}

/// A picture: what is swept, the errors of ours and of others, and what no double can be better than.
pub(crate) struct Panel {
    pub(crate) title: &'static str,
    pub(crate) swept: &'static str,
    pub(crate) unit: &'static str,
    pub(crate) ours: Vec<Curve>,
    pub(crate) others: Vec<Curve>,
    pub(crate) limit: Option<Curve>,
}

/// The common logarithm at which no error is drawn.
const EXACT: f64 = -18.0;

/// Beyond this, errors are not told apart, and what is no number is drawn here.
const HOPELESS: f64 = 3.0;

fn logarithm(error: f64) -> f64 {
    if error.is_nan() { HOPELESS } else { error.log10().clamp(EXACT, HOPELESS) }
}

/// 10 to a whole power; nothing for what is none.
fn power_of_ten(exponent: f64) -> String {
    if exponent.fract() != 0.0 {
        return String::new();
    }
    let digit = |c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4'..='9' | '0' => char::from_u32(0x2070 + c as u32 - '0' as u32).unwrap_or(c),
        other => other,
    };
    format!("10{}", format!("{exponent:.0}").chars().map(digit).collect::<String>())
}

const OF_OURS: [RGBColor; 2] = [RGBColor(0, 70, 200), RGBColor(0, 150, 130)];
const OF_OTHERS: [RGBColor; 2] = [RGBColor(205, 40, 40), RGBColor(235, 150, 40)];
const OF_LIMIT: RGBColor = RGBColor(140, 140, 140);

/// The height of a panel, and of the line below them.
const PANEL: u32 = 380;
const LINE: u32 = 30;

/// Panels, and below them on what machine, when and of which commit they were drawn.
pub(crate) fn draw(panels: &[Panel], told: &str, path: &Path) -> Result<(), Box<dyn Error + Send + Sync>> {
    let lines = panels.len().div_ceil(2);
    let height = PANEL * lines as u32;
    let whole = SVGBackend::new(path, (1240, height + LINE)).into_drawing_area();
    whole.fill(&WHITE)?;
    let (area, below) = whole.split_vertically(height);
    below.draw(&Text::new(told, (14, 6), ("sans-serif", 14)))?;
    for (panel, area) in panels.iter().zip(area.split_evenly((lines, 2))) {
        let curves = || panel.limit.iter().chain(&panel.ours).chain(&panel.others);
        let swept = || curves().flat_map(|curve| &curve.points).map(|(x, _)| *x);
        let [low, high] = [swept().fold(f64::INFINITY, f64::min), swept().fold(0.0, f64::max)];
        // A part of one is swept evenly.
        let is_even = low > 1e-3 && high < 1.0 && panel.ours.len() > 1;
        let across = |x: f64| if is_even { x } else { x.log10() };
        let top = curves().fold(EXACT, |top, curve| top.max(logarithm(curve.worst()))).ceil();
        let mut builder = ChartBuilder::on(&area);
        builder
            .caption(panel.title, ("sans-serif", 17))
            .margin(14)
            .x_label_area_size(44)
            .y_label_area_size(70);
        // The legend is below the largest errors where these are at the left, else above what leads to them: there is room for it.
        let points = || curves().flat_map(|curve| &curve.points).map(|(x, y)| (across(*x), logarithm(*y)));
        let largest =
            points().fold((0.0, EXACT), |worst, point| if point.1 > worst.1 { point } else { worst });
        let room = 0.2 * (top - EXACT);
        let from = if is_even { 0.0 } else { across(low) };
        let to = if is_even { 1.0 } else { across(high) };
        let mut chart = builder.build_cartesian_2d(from..to, EXACT..top + room)?;
        chart
            .configure_mesh()
            .x_desc(panel.swept)
            .y_desc(format!("error ({})", panel.unit))
            .axis_desc_style(("sans-serif", 14))
            .label_style(("sans-serif", 13))
            .x_labels(11)
            .y_labels(12)
            .x_label_formatter(&|x| if is_even { format!("{x:.1}") } else { power_of_ten(*x) })
            .y_label_formatter(&|y| if *y == EXACT { "0".to_string() } else { power_of_ten(*y) })
            .light_line_style(WHITE)
            .bold_line_style(RGBColor(225, 225, 225))
            .draw()?;
        // The limit first, so that what reaches it is seen on it.
        let colours = panel.limit.iter().zip([OF_LIMIT]);
        let colours = colours.chain(panel.others.iter().zip(OF_OTHERS)).chain(panel.ours.iter().zip(OF_OURS));
        for (Curve { of, points }, colour) in colours {
            let points: Vec<_> = points.iter().map(|(x, y)| (across(*x), logarithm(*y))).collect();
            chart
                .draw_series(LineSeries::new(points, colour.stroke_width(2)))?
                .label(*of)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2)));
        }
        chart
            .configure_series_labels()
            .position(if largest.0 < 0.5 * (from + to) {
                SeriesLabelPosition::LowerLeft
            } else {
                SeriesLabelPosition::UpperLeft
            })
            .label_font(("sans-serif", 13))
            .background_style(WHITE.mix(0.9))
            .border_style(RGBColor(150, 150, 150))
            .draw()?;
    }
    whole.present()?;
    Ok(())
}
