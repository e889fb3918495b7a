//! `*AMPLITUDE`: how what is prescribed changes in time, with exact derivatives.
//!
//! Tabular and equally spaced values are linear between the points, and constant before the first and after the last.
//! SMOOTH STEP goes between points by A + ΔA ξ³(10 − 15ξ + 6ξ²). PERIODIC is A0 + Σ A_n cos nω(t − t0) + B_n sin nω(t − t0).
//! MODULATED is A0 + A sin ω1(t − t0) sin ω2(t − t0), and DECAY A0 + A exp(−(t − t0)/t_d). Each is A0 before t0. Other
//! definitions are no functions of time that a deck gives.
//!
//! *Smoothing.* Time derivatives of a prescribed displacement or velocity count in direct-integration dynamics. There a parabola
//! that meets both lines tangentially replaces a fraction of the shorter interval on each side of a point of a tabular or equally
//! spaced amplitude. The fraction is `SMOOTH`, by default 1/4 in Standard and 0 in Explicit. For loads and in statics there is
//! none.
//!
//! *Corners.* Where two lines meet, the derivative is that of the line before: a state is the end of an increment. At the first point
//! it is that of the first line. Where two points have the same time the value jumps to the second.

use pintle_kinematics::scalar::{Real, Scalar, elementary};
use pintle_scene as scene;
use pintle_scene::{AmplitudeDefinition, AmplitudeTime, AmplitudeValue, Code, Diagnostic, Span};

/// What an amplitude is a function of.
#[derive(Clone, Debug, PartialEq)]
enum Curve {
    /// Points, linear between them.
    Lines(Vec<[f64; 2]>),
    /// Points, with polynomials of fifth degree between them.
    SmoothStep(Vec<[f64; 2]>),
    /// ω, t0, A0, and (A_n, B_n) for n = 1 …
    Periodic { frequency: f64, start: f64, mean: f64, terms: Vec<[f64; 2]> },
    /// A0, A, t0, ω1, ω2.
    Modulated { mean: f64, factor: f64, start: f64, frequencies: [f64; 2] },
    /// A0, A, t0, t_d.
    Decay { mean: f64, factor: f64, start: f64, time: f64 },
    /// Not a function of time.
    Undetermined,
}

/// An amplitude.
#[derive(Clone, Debug, PartialEq)]
pub struct Amplitude {
    curve: Curve,
    /// `VALUE=ABSOLUTE`: the value stands for the magnitude instead of multiplying it.
    pub is_absolute: bool,
    /// `TIME=TOTAL TIME`: it counts the time of the analysis, not of the step.
    pub is_total_time: bool,
    smooth: Option<f64>,
}

impl Amplitude {
    /// The amplitude that a deck gives.
    ///
    /// # Errors
    /// [`Code::MissingData`], [`Code::SurplusData`] and [`Code::NumberOutOfRange`] for data that the definition cannot be read from.
    pub fn new(name: &str, given: &scene::Amplitude) -> Result<Self, Diagnostic> {
        let fail = |code, message: String, remedy: &str| {
            Diagnostic::error(code, given.span, format!("amplitude {name}: {message}"), "this amplitude")
                .help(remedy)
        };
        let items = |count: usize, names: &str| -> Result<Vec<f64>, Diagnostic> {
            if given.data.len() > count {
                let message = format!("{} items instead of {count}", given.data.len());
                return Err(fail(Code::SurplusData, message, &format!("give {names}")));
            }
            let mut numbers: Vec<f64> = given.data.iter().map(|item| item.unwrap_or(0.0)).collect();
            numbers.resize(count, 0.0);
            Ok(numbers)
        };
        let curve = match given.definition {
            AmplitudeDefinition::Tabular => Curve::Lines(points(&given.data)),
            AmplitudeDefinition::SmoothStep => Curve::SmoothStep(points(&given.data)),
            AmplitudeDefinition::EquallySpaced => {
                let interval = given.fixed_interval.filter(|interval| *interval > 0.0);
                let remedy = "give FIXED INTERVAL= a positive time";
                let message = "no positive FIXED INTERVAL".to_string();
                let interval = interval.ok_or_else(|| fail(Code::MissingParameter, message, remedy))?;
                let begin = given.begin.unwrap_or(0.0);
                let at =
                    |(i, value): (usize, &Option<f64>)| [begin + i as f64 * interval, value.unwrap_or(0.0)];
                Curve::Lines(given.data.iter().enumerate().map(at).collect())
            }
            AmplitudeDefinition::Periodic => {
                let names = "N, ω, t0, A0 on the first line, then A1, B1, A2, B2 …";
                let at = |i: usize| given.data.get(i).copied().flatten().unwrap_or(0.0);
                let count = at(0);
                let given_terms = given.data.len().saturating_sub(4);
                if !(count >= 0.0 && count.fract() == 0.0 && 2.0 * count == given_terms as f64) {
                    let message =
                        format!("N = {count} needs {} coefficients, and {given_terms} follow", 2.0 * count);
                    return Err(fail(Code::MissingData, message, &format!("give {names}")));
                }
                let terms = (0..given_terms / 2).map(|n| [at(4 + 2 * n), at(5 + 2 * n)]).collect();
                Curve::Periodic { frequency: at(1), start: at(2), mean: at(3), terms }
            }
            AmplitudeDefinition::Modulated => {
                let [mean, factor, start, first, second] = fixed(&items(5, "A0, A, t0, ω1, ω2")?);
                Curve::Modulated { mean, factor, start, frequencies: [first, second] }
            }
            AmplitudeDefinition::Decay => {
                let [mean, factor, start, time] = fixed(&items(4, "A0, A, t0, t_d")?);
                if !(time > 0.0 && time.recip().is_finite()) {
                    let message = format!("the time t_d of decay is {time}");
                    return Err(fail(Code::NumberOutOfRange, message, "give A0, A, t0, t_d with t_d > 0"));
                }
                Curve::Decay { mean, factor, start, time }
            }
            AmplitudeDefinition::SolutionDependent
            | AmplitudeDefinition::Actuator
            | AmplitudeDefinition::Bubble
            | AmplitudeDefinition::Spectrum
            | AmplitudeDefinition::PsdDefinition
            | AmplitudeDefinition::User => Curve::Undetermined,
        };
        if let Curve::Lines(points) | Curve::SmoothStep(points) = &curve {
            if points.is_empty() {
                return Err(fail(
                    Code::MissingData,
                    "no points".to_string(),
                    "give values on the lines below",
                ));
            }
            check(points, name, given.span)?;
        }
        if let Some(smooth) = given.smooth.filter(|smooth| !(0.0..=0.5).contains(smooth)) {
            let message = format!("SMOOTH is {smooth}");
            return Err(fail(Code::NumberOutOfRange, message, "give a fraction between 0 and 0.5"));
        }
        Ok(Self {
            curve,
            is_absolute: given.value == Some(AmplitudeValue::Absolute),
            is_total_time: given.time == Some(AmplitudeTime::TotalTime),
            smooth: given.smooth,
        })
    }

    /// The fraction of intervals that is smoothed where time derivatives count.
    pub fn smoothing(&self, is_explicit: bool) -> f64 {
        self.smooth.unwrap_or(if is_explicit { 0.0 } else { 0.25 })
    }

    /// a(t), with all time derivatives that t carries; `smoothing` is the fraction of intervals smoothed, 0 for none. `None` where
    /// the amplitude is no function of time.
    pub fn evaluate<S: Scalar>(&self, t: S, smoothing: f64) -> Option<S> {
        let number = |x: f64| S::Real::from_f64(x);
        let constant = |x: f64| S::from_real(number(x));
        let since = |start: f64| t - constant(start);
        let is_before = |start: f64| less(t.real(), number(start));
        let sine = |frequency: f64, start: f64| elementary::sin_cos(since(start).scale(number(frequency)));
        Some(match &self.curve {
            Curve::Lines(points) => lines(points, t, smoothing),
            Curve::SmoothStep(points) => smooth_step(points, t),
            Curve::Periodic { start, mean, .. } if is_before(*start) => constant(*mean),
            Curve::Periodic { frequency, start, mean, terms } => {
                let mut sum = constant(*mean);
                for (i, [cosine, sines]) in terms.iter().enumerate() {
                    let n = S::Real::from_f64((i + 1) as f64);
                    let (s, c) = elementary::sin_cos(since(*start).scale(number(*frequency) * n));
                    sum = sum + c.scale(number(*cosine)) + s.scale(number(*sines));
                }
                sum
            }
            Curve::Modulated { start, mean, .. } | Curve::Decay { start, mean, .. } if is_before(*start) => {
                constant(*mean)
            }
            Curve::Modulated { mean, factor, start, frequencies: [first, second] } => {
                let product = sine(*first, *start).0 * sine(*second, *start).0;
                constant(*mean) + product.scale(number(*factor))
            }
            Curve::Decay { mean, factor, start, time } => {
                let rate = S::Real::integer(-1) / number(*time);
                constant(*mean) + elementary::exp(since(*start).scale(rate)).scale(number(*factor))
            }
            Curve::Undetermined => return None,
        })
    }

    /// The times at which it is not smooth: points of lines, and where their parabolas begin and end.
    pub fn breaks(&self, smoothing: f64) -> Vec<f64> {
        match &self.curve {
            Curve::Lines(points) => {
                let mut found: Vec<f64> = points.iter().map(|[time, _]| *time).collect();
                for three in points.windows(3) {
                    let [before, at, after] = [three[0][0], three[1][0], three[2][0]];
                    let half = smoothing * (at - before).min(after - at);
                    if half > 0.0 {
                        found.extend([at - half, at + half]);
                    }
                }
                found
            }
            Curve::SmoothStep(points) => points.iter().map(|[time, _]| *time).collect(),
            Curve::Periodic { start, .. } | Curve::Modulated { start, .. } | Curve::Decay { start, .. } => {
                vec![*start]
            }
            Curve::Undetermined => Vec::new(),
        }
    }
}

/// Pairs of time and value.
fn points(data: &[Option<f64>]) -> Vec<[f64; 2]> {
    let at = |item: Option<&Option<f64>>| item.copied().flatten().unwrap_or(0.0);
    data.chunks(2).map(|pair| [at(pair.first()), at(pair.get(1))]).collect()
}

fn fixed<const N: usize>(items: &[f64]) -> [f64; N] {
    let mut numbers = [0.0; N];
    numbers.iter_mut().zip(items).for_each(|(number, item)| *number = *item);
    numbers
}

/// Times that do not decrease, and slopes that are doubles.
fn check(points: &[[f64; 2]], name: &str, span: Span) -> Result<(), Diagnostic> {
    for pair in points.windows(2) {
        let [[from, low], [to, high]] = [pair[0], pair[1]];
        if to < from {
            let message = format!("amplitude {name}: time goes back from {from} to {to}");
            return Err(Diagnostic::error(Code::TableOrder, span, message, "this amplitude")
                .help("order the pairs so that time increases"));
        }
        let is_a_slope = (high - low).is_finite() && ((high - low) / (to - from)).is_finite();
        if to > from && !(is_a_slope && (to - from).recip().is_finite()) {
            let message =
                format!("amplitude {name}: the slope between times {from:e} and {to:e} is no double");
            return Err(Diagnostic::error(Code::NumberOutOfRange, span, message, "this amplitude")
                .help("use points that lie farther apart, or other units"));
        }
    }
    Ok(())
}

/// The number of points whose time has passed: those before t, and the first one and the later ones of a jump at t.
fn passed<R: Real>(points: &[[f64; 2]], t: R) -> usize {
    let before = points.partition_point(|[time, _]| less(R::from_f64(*time), t));
    let until = points.partition_point(|[time, _]| !less(t, R::from_f64(*time)));
    if before == 0 || until > before + 1 { until } else { before }
}

/// Linear between points; corners smoothed.
fn lines<S: Scalar>(points: &[[f64; 2]], t: S, smoothing: f64) -> S {
    let real = |x: f64| S::Real::from_f64(x);
    let i = passed(points, t.real());
    let (Some(from), Some(to)) = (i.checked_sub(1).and_then(|before| points.get(before)), points.get(i))
    else {
        let end = if i == 0 { points.first() } else { points.last() };
        return S::from_real(real(end.map_or(0.0, |[_, value]| *value)));
    };
    let slope = slope::<S::Real>(from, to);
    let is_nearer = less(t.real() - real(from[0]), real(to[0]) - t.real());
    let [time, value] = if is_nearer { *from } else { *to };
    let line = S::from_real(real(value)) + (t - S::from_real(real(time))).scale(slope);
    if smoothing == 0.0 {
        return line;
    }
    // The corner at either end of this line, if it is near enough.
    let corner = |before: Option<&[f64; 2]>, at: &[f64; 2], after: Option<&[f64; 2]>, has_passed: bool| {
        let (before, after) = (before?, after?);
        let shorter = (at[0] - before[0]).min(after[0] - at[0]);
        let half = real(smoothing) * real(shorter);
        let from_corner = t.real() - real(at[0]);
        if shorter <= 0.0 || !less(from_corner.magnitude(), half) {
            return None;
        }
        let change = self::slope::<S::Real>(at, after) - self::slope::<S::Real>(before, at);
        // Up to the corner the line before is known, after it the line after: what is added is Δs (δ ∓ (t − t_i))²/(4δ).
        let reach = if has_passed {
            S::from_real(real(at[0]) + half) - t
        } else {
            t - S::from_real(real(at[0]) - half)
        };
        Some((reach * reach).scale(change / (half * S::Real::integer(4))))
    };
    let at_from = corner(i.checked_sub(2).and_then(|before| points.get(before)), from, Some(to), true);
    let at_to = || corner(Some(from), to, points.get(i + 1), false);
    at_from.or_else(at_to).map_or(line, |added| line + added)
}

fn slope<R: Real>(from: &[f64; 2], to: &[f64; 2]) -> R {
    (R::from_f64(to[1]) - R::from_f64(from[1])) / (R::from_f64(to[0]) - R::from_f64(from[0]))
}

/// A + ΔA ξ³(10 − 15ξ + 6ξ²) between points.
fn smooth_step<S: Scalar>(points: &[[f64; 2]], t: S) -> S {
    let real = |x: f64| S::Real::from_f64(x);
    let constant = |x: f64| S::from_real(real(x));
    let i = passed(points, t.real());
    let (Some(from), Some(to)) = (i.checked_sub(1).and_then(|before| points.get(before)), points.get(i))
    else {
        let end = if i == 0 { points.first() } else { points.last() };
        return constant(end.map_or(0.0, |[_, value]| *value));
    };
    // From the nearer point, so that the points are met exactly: the polynomial p has p(ξ) + p(1 − ξ) = 1.
    let is_nearer = less(t.real() - real(from[0]), real(to[0]) - t.real());
    let length = real(to[0]) - real(from[0]);
    let (near, far) = if is_nearer { (from, to) } else { (to, from) };
    let sign = S::Real::integer(if is_nearer { 1 } else { -1 });
    let x = (t - constant(near[0])).real();
    let zero = S::Real::ZERO;
    let xi = t.lift(&[sign * x / length, sign / length, zero, zero, zero]);
    let integer = |n: i32| S::from_real(S::Real::integer(n));
    let rise = xi * xi * xi * (integer(10) + xi * (xi * integer(6) - integer(15)));
    constant(near[1]) + rise.scale(real(far[1]) - real(near[1]))
}

fn less<R: Real>(a: R, b: R) -> bool {
    R::holds(a.less(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_dual::Dual2_64;
    use pintle_kinematics::scalar::Wide;

    fn amplitude(definition: &str, data: &[f64]) -> Amplitude {
        let keyword = format!("*AMPLITUDE, NAME=A, DEFINITION={definition}");
        let lines: Vec<String> = data
            .chunks(if definition.starts_with("PERIODIC") { 4 } else { 8 })
            .map(|line| line.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(", "))
            .collect();
        let deck = format!("*NODE\n1, 0., 0., 0.\n{keyword}\n{}\n", lines.join("\n"));
        let scene = scene::Scene::parse("deck.inp", &deck).unwrap();
        Amplitude::new("A", &scene.amplitudes["A"]).unwrap()
    }

    /// Value, first and second derivative.
    fn at(amplitude: &Amplitude, t: f64, smoothing: f64) -> [f64; 3] {
        let value = amplitude.evaluate(Dual2_64::new(t, 1.0, 0.0), smoothing).unwrap();
        [value.re, value.v1, value.v2]
    }

    #[test]
    fn lines_are_met_exactly_and_constant_beyond() {
        let table = amplitude("TABULAR", &[0.5, 0.1, 1.5, 2.1, 1.5, 3.0, 2.0, 1.0]);
        for (t, expected) in [
            (0.0, [0.1, 0.0, 0.0]),
            (0.5, [0.1, 2.0, 0.0]),
            (1.0, [1.1, 2.0, 0.0]),
            (1.5, [3.0, -4.0, 0.0]),
            (1.75, [2.0, -4.0, 0.0]),
            (2.0, [1.0, -4.0, 0.0]),
            (9.0, [1.0, 0.0, 0.0]),
        ] {
            assert_eq!(at(&table, t, 0.0), expected, "{t}");
        }
        let equal = amplitude("EQUALLY SPACED, FIXED INTERVAL=0.5, BEGIN=1.", &[0.0, 1.0, 4.0]);
        assert_eq!(at(&equal, 1.75, 0.0), [2.5, 6.0, 0.0]);
    }

    /// A smoothed corner has the value and slope of both lines where it meets them, and the parabola between.
    #[test]
    fn corners_are_smoothed_by_parabolas() {
        let table = amplitude("TABULAR, SMOOTH=0.2", &[0.0, 0.0, 1.0, 2.0, 5.0, -6.0]);
        assert_eq!(table.smoothing(false), 0.2);
        assert_eq!(amplitude("TABULAR", &[0.0, 0.0, 1.0, 2.0]).smoothing(false), 0.25);
        assert_eq!(amplitude("TABULAR", &[0.0, 0.0, 1.0, 2.0]).smoothing(true), 0.0);
        // Slopes 2 and -2, the shorter interval 1: half width 0.2, second derivative -4/0.4.
        let near = |t: f64, expected: [f64; 3]| {
            for (got, expected) in at(&table, t, 0.2).into_iter().zip(expected) {
                assert!((got - expected).abs() < 1e-13, "{t}: {got} {expected}");
            }
        };
        near(0.75, [1.5, 2.0, 0.0]);
        near(0.8 + 1e-15, [1.6, 2.0, -10.0]);
        near(0.9, [1.8 - 0.05, 1.0, -10.0]);
        near(1.0, [1.8, 0.0, -10.0]);
        near(1.1, [1.75, -1.0, -10.0]);
        near(1.25, [1.5, -2.0, 0.0]);
    }

    /// Corners at distances from their neighbours that differ on both sides, and from time 0: the reach is a fraction of the shorter.
    #[test]
    fn corners_reach_a_fraction_of_the_shorter_interval() {
        // Slopes 2, -2, -1, 1: the shorter intervals are 2, after the first corner and before the second, and 4.
        let table = amplitude("TABULAR", &[10.0, 0.0, 14.0, 8.0, 16.0, 4.0, 22.0, -2.0, 26.0, 2.0]);
        for (t, expected) in [
            (13.25, [6.5, 2.0, 0.0]),
            (13.75, [7.375, 1.0, -4.0]),
            (14.0, [7.5, 0.0, -4.0]),
            (14.75, [6.5, -2.0, 0.0]),
            (15.25, [5.5, -2.0, 0.0]),
            (16.0, [4.125, -1.5, 1.0]),
            (16.75, [3.25, -1.0, 0.0]),
            (20.75, [-0.75, -1.0, 0.0]),
            (22.0, [-1.5, 0.0, 1.0]),
            (23.25, [-0.75, 1.0, 0.0]),
        ] {
            // The reach is 0.5 at the first two corners, 1 at the third; second derivative Δs/(2 reach).
            let found = at(&table, t, 0.25);
            for (found, expected) in found.into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-13, "{t}: {found} {expected}");
            }
        }
    }

    /// Points are met bit for bit, whatever the rounding of slopes, and half way a smooth step has half its rise, at 15/8 of the
    /// mean slope.
    #[test]
    fn points_are_met_bit_for_bit() {
        let mut x = 0.1;
        let mut data = Vec::new();
        for i in 0..40 {
            x = 3.9 * x * (1.0 - x);
            data.extend([f64::from(i) / 3.0 + x / 7.0 - 4.0, x * 11.0 - 3.0]);
        }
        let [lines, step] = ["TABULAR", "SMOOTH STEP"].map(|definition| amplitude(definition, &data));
        for point in data.chunks(2) {
            assert_eq!((at(&lines, point[0], 0.0)[0], at(&step, point[0], 0.0)[0]), (point[1], point[1]));
        }
        for pair in data.chunks(2).collect::<Vec<_>>().windows(2) {
            let (length, rise) = (pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]);
            let [value, slope, _] = at(&step, pair[0][0] + length / 2.0, 0.0);
            assert!((value - (pair[0][1] + rise / 2.0)).abs() < 1e-13, "{value}");
            assert!((slope * length - rise * 15.0 / 8.0).abs() < 1e-12, "{slope}");
        }
    }

    /// Every definition against wide central differences, and against its formula at one time.
    #[test]
    fn derivatives_are_exact() {
        let step = amplitude("SMOOTH STEP", &[0.0, 0.5, 2.0, -1.5, 3.0, 4.0]);
        let periodic = amplitude("PERIODIC", &[2.0, 3.0, 0.25, 0.125, 1.0, -2.0, 0.5, 0.75]);
        let modulated = amplitude("MODULATED", &[1.0, 2.0, 0.1, 10.0, 1.5]);
        let decay = amplitude("DECAY", &[-1.0, 5.0, 0.3, 0.7]);
        for t in [-0.2, 0.2, 0.9, 1.1, 1.9, 2.0, 2.75, 3.5] {
            for (amplitude, formula) in [
                (&step, None),
                (
                    &periodic,
                    (t >= 0.25).then(|| {
                        let x: f64 = 3.0 * (t - 0.25);
                        0.125 + x.cos() - 2.0 * x.sin() + 0.5 * (2.0 * x).cos() + 0.75 * (2.0 * x).sin()
                    }),
                ),
                (
                    &modulated,
                    (t >= 0.1).then(|| 1.0 + 2.0 * (10.0 * (t - 0.1)).sin() * (1.5 * (t - 0.1)).sin()),
                ),
                (&decay, (t >= 0.3).then(|| -1.0 + 5.0 * (-(t - 0.3) / 0.7).exp())),
            ] {
                let [value, first, second] = at(amplitude, t, 0.0);
                let h = Wide::from_f64(1e-20);
                let wide = |shift: Wide| amplitude.evaluate(Wide::from_f64(t) + shift, 0.0).unwrap();
                let (below, here, above) = (wide(-h), wide(Wide::ZERO), wide(h));
                let slope = ((above - below) / (h + h)).to_f64();
                let bend = ((above - here - (here - below)) / (h * h)).to_f64();
                let near = |a: f64, b: f64, what| {
                    assert!((a - b).abs() <= 4e-14 * (1.0 + b.abs()), "{amplitude:?} at {t}: {what} {a} {b}");
                };
                near(value, here.to_f64(), "value");
                near(first, slope, "slope");
                near(second, bend, "second derivative");
                if let Some(formula) = formula {
                    near(value, formula, "formula");
                }
            }
        }
        assert_eq!(at(&step, 0.0, 0.0), [0.5, 0.0, 0.0]);
        assert_eq!(at(&step, 2.0, 0.0), [-1.5, 0.0, 0.0]);
        assert_eq!(at(&step, 1.0, 0.0)[0], -0.5);
        assert_eq!(at(&step, 7.0, 0.0), [4.0, 0.0, 0.0]);
    }

    /// Before t0 the value is A0.
    #[test]
    fn values_before_the_start() {
        let periodic = amplitude("PERIODIC", &[1.0, 3.0, 0.25, 0.125, 0.0, 0.5]);
        let modulated = amplitude("MODULATED", &[1.5, 2.0, 0.25, 10.0, 1.5]);
        let decay = amplitude("DECAY", &[-1.0, 5.0, 0.25, 0.5]);
        assert_eq!(at(&periodic, 0.0, 0.0), [0.125, 0.0, 0.0]);
        assert_eq!(at(&modulated, 0.0, 0.0), [1.5, 0.0, 0.0]);
        assert_eq!(at(&decay, 0.0, 0.0), [-1.0, 0.0, 0.0]);
    }

    #[test]
    fn points_in_order_with_slopes_that_are_doubles() {
        let span = Span::default();
        let code = |points: &[[f64; 2]]| check(points, "A", span).err().map(|fault| fault.code());
        assert_eq!(code(&[[0.0, 1.0], [1.0, 3.0], [1.0, 5.0], [2.0, -1e300]]), None);
        // Large values, and times on both sides of 0, as long as the differences are doubles.
        assert_eq!(code(&[[0.0, 1e308], [1.0, 1.5e308]]), None);
        assert_eq!(code(&[[0.0, 1e300], [1e-9, 1e300]]), None);
        assert_eq!(code(&[[-1.0, 0.0], [1.0, 5.0]]), None);
        assert_eq!(code(&[[1.0, 1.0], [0.5, 3.0]]), Some(Code::TableOrder));
        assert_eq!(
            code(&[[0.0, -1e308], [1.0, 1e308]]),
            Some(Code::NumberOutOfRange),
            "a rise that is no double"
        );
        assert_eq!(code(&[[0.0, 0.0], [1e-300, 1e10]]), Some(Code::NumberOutOfRange), "a slope that is none");
        assert_eq!(
            code(&[[0.0, 0.0], [1e-310, 0.0]]),
            Some(Code::NumberOutOfRange),
            "an interval without inverse"
        );
    }

    #[test]
    fn what_is_no_function_of_time_is_said() {
        let user = amplitude("USER", &[1.0]);
        assert!(user.evaluate(0.5, 0.0).is_none());
    }
}
