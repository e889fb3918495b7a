//! One-step methods of high order, which witness each other: extrapolation of the midpoint rule (Gragg, Bulirsch, Stoer) and collocation
//! at the points of Gauss. Where motion is stiff, collocation at the points of Radau takes the place of extrapolation, and both solve with a
//! Jacobian ([`crate::time::stiff`]).

use crate::motion::linear::System;
use crate::motion::mode::Switch;
use crate::motion::rows::Trouble;
use crate::motion::tangent::Tangent;
use crate::number::Number;
use crate::time::onset::{Onset, Turns};
use crate::time::stiff::{self, Change, Improvement, Spectrum};
use serde::{Deserialize, Serialize};
use std::cell::OnceCell;
use std::ops::Range;

/// How a solution goes on in time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Extrapolation of the midpoint rule; Radau collocation where motion is stiff.
    #[default]
    Extrapolation,
    /// Gauss collocation.
    Collocation,
}

/// ẏ, and what may end the mode.
#[derive(Clone, Debug)]
pub(crate) struct Slope<R> {
    pub(crate) rates: Vec<R>,
    pub(crate) switches: Vec<Switch<R>>,
}

/// A step that was tried.
#[derive(Clone, Debug)]
pub(crate) struct Tried<R> {
    pub(crate) end: Vec<R>,
    /// In units of what is allowed; above 1 the step is too long.
    pub(crate) error: f64,
    /// By what the length of the next step may be multiplied.
    pub(crate) growth: f64,
    /// Switches within the step, by the part of it that has passed.
    pub(crate) inner: Vec<(f64, Vec<Switch<R>>)>,
    /// Its stages, where there are some.
    pub(crate) stages: Option<Stages<R>>,
}

/// The rates at the stages of a step, which those of another one begin with: polynomials in time.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Stages<R> {
    begin: R,
    length: R,
    rates: Vec<Vec<R>>,
}

/// What is known of a motion q̇ = V(q, v), v̇ = A(t, q, v) besides its flow.
pub(crate) struct Ahead<'a, R> {
    /// How many q there are.
    pub(crate) positions: usize,
    /// V at y = (q, v, …).
    pub(crate) moving: &'a dyn Fn(&[R]) -> Vec<R>,
    pub(crate) tangent: &'a Tangents<'a, R>,
    /// The stages of another step.
    pub(crate) stages: Option<&'a Stages<R>>,
}

/// Where y may go at t, whose numbers have such sizes.
pub(crate) type Tangents<'a, R> = dyn Fn(R, &[R], &[R]) -> Result<Tangent, Trouble> + 'a;

/// ẏ = f(t, y).
pub(crate) type Flow<'a, R> = dyn FnMut(R, &[R]) -> Result<Slope<R>, Trouble> + 'a;

/// What Newton's method solves for in a step.
#[derive(Clone, Debug)]
pub(crate) enum Newton<'a, R> {
    /// Nothing: motion is not stiff.
    None,
    /// All numbers, of such sizes.
    All(Vec<R>),
    /// The velocities of slips that begin.
    Onsets(&'a [Onset<R>]),
}

impl<R: Number> Ahead<'_, R> {
    /// The rates of positions at a stage.
    fn turn(&self, state: &[R], rates: &mut [R]) {
        rates.iter_mut().zip((self.moving)(state)).for_each(|(rate, moves)| *rate = moves);
    }
}

/// A method, and the digits that are wanted.
#[derive(Clone, Debug)]
pub(crate) struct Rule<R> {
    method: Method,
    digits: usize,
    /// Formed where it is used: extrapolation needs none until motion is stiff.
    tableau: OnceCell<Tableau<R>>,
}

/// The points c and the matrix a of stages, the weights, and the weights without the last stage.
#[derive(Clone, Debug)]
pub(crate) struct Tableau<R> {
    pub(crate) points: Vec<R>,
    pub(crate) matrix: Vec<Vec<R>>,
    pub(crate) weights: Vec<R>,
    fewer: Vec<R>,
    /// Of the matrix, for Newton's method.
    spectrum: Option<Spectrum>,
}

/// What grows where a step is much better than it has to be.
const GROWTH: f64 = 2.0;

/// The most columns on doubles: each multiplies rounding, ten of them by a hundred.
const FEW: usize = 7;

impl<R: Number> Rule<R> {
    /// The rule for a method and a number of digits.
    pub(crate) const fn new(method: Method, digits: usize) -> Self {
        Self { method, digits, tableau: OnceCell::new() }
    }

    /// A step of length h from y at t, where the slope is known.
    ///
    /// `allowed` is the largest error of each number. The last of them is the relative error itself.
    pub(crate) fn step(
        &self,
        flow: &mut Flow<'_, R>,
        start: (R, &[R], &Slope<R>),
        h: R,
        allowed: &[R],
        (newton, ahead): (&Newton<'_, R>, Option<&Ahead<'_, R>>),
    ) -> Result<Tried<R>, Trouble> {
        if self.method == Method::Extrapolation && matches!(newton, Newton::None) {
            return self.extrapolated(flow, start, h, allowed);
        }
        let stages = 6 + self.digits / 4;
        let tableau = self.tableau.get_or_init(|| match self.method {
            Method::Extrapolation => Tableau::radau(stages),
            Method::Collocation => Tableau::new(gauss(stages)),
        });
        collocate(flow, start, h, allowed, tableau, (newton, ahead))
    }

    /// The same by extrapolation, whatever the method.
    pub(crate) fn extrapolated(
        &self,
        flow: &mut Flow<'_, R>,
        start: (R, &[R], &Slope<R>),
        h: R,
        allowed: &[R],
    ) -> Result<Tried<R>, Trouble> {
        let most = if R::ROUNDING > f64::EPSILON / 4.0 { FEW } else { usize::MAX };
        extrapolate(flow, start, h, allowed, (7 + self.digits / 4).min(most))
    }
}

fn excess<R: Number>(of: impl Iterator<Item = R>, allowed: &[R]) -> f64 {
    let parts = of.zip(allowed).map(|(x, most)| (x.magnitude() / *most).to_f64());
    parts.fold(0.0, |most, x| if x.is_nan() { f64::INFINITY } else { most.max(x) })
}

/// The limit of numbers for a step h that is halved from each to the next (Richardson, Neville). Their errors are a series in h² where `ratio` is 4,
/// in h where it is 2.
pub(crate) fn at_zero<R: Number>(all: Vec<Vec<R>>, ratio: i32) -> Vec<R> {
    let mut table: Vec<Vec<R>> = Vec::new();
    for mut row in all {
        let mut power = 1;
        for known in &mut table {
            power *= ratio;
            let pairs = row.iter().zip(known.iter());
            let next = pairs.map(|(new, old)| *new + (*new - *old) / R::integer(power - 1)).collect();
            *known = std::mem::replace(&mut row, next);
        }
        table.push(row);
    }
    table.pop().unwrap_or_default()
}

fn extrapolate<R: Number>(
    flow: &mut Flow<'_, R>,
    (t, y, slope): (R, &[R], &Slope<R>),
    h: R,
    allowed: &[R],
    columns: usize,
) -> Result<Tried<R>, Trouble> {
    let mut table: Vec<Vec<R>> = Vec::with_capacity(columns);
    let mut inner = Vec::new();
    let mut error = f64::INFINITY;
    for column in 0..columns {
        let parts = 2 * (column + 1);
        let part = h / R::integer(parts as i32);
        // Increments from y, so that they keep their digits.
        let mut before = vec![R::ZERO; y.len()];
        let mut now: Vec<R> = slope.rates.iter().map(|rate| part * *rate).collect();
        inner.clear();
        for i in 1..parts {
            let at: Vec<R> = y.iter().zip(&now).map(|(y, moved)| *y + *moved).collect();
            let found = flow(t + part * R::integer(i as i32), &at)?;
            let twice = part + part;
            for ((before, now), rate) in before.iter_mut().zip(&mut now).zip(&found.rates) {
                let next = *before + twice * *rate;
                *before = std::mem::replace(now, next);
            }
            inner.push((i as f64 / parts as f64, found.switches));
        }
        // Neville's scheme in h²: T_k from the last row of the table.
        let mut row = now;
        let mut last = Vec::new();
        for (k, known) in table.iter_mut().enumerate() {
            // row is T_(column, k), known T_(column − 1, k).
            let ratio = R::ratio(parts as i32, 2 * (column - k) as i32);
            let divisor = ratio * ratio - R::integer(1);
            let next: Vec<R> =
                row.iter().zip(known.iter()).map(|(new, old)| *new + (*new - *old) / divisor).collect();
            last = std::mem::replace(known, std::mem::replace(&mut row, next));
            last.clone_from(known);
        }
        if column > 0 {
            error = excess(row.iter().zip(&last).map(|(x, y)| *x - *y), allowed);
        }
        table.push(row);
        if error <= 1.0 && column >= 2 {
            let used = column + 1;
            let growth = match error <= 1e-30 {
                true => GROWTH,
                false => 0.9 * error.powf(-1.0 / (2.0 * used as f64 - 1.0)),
            };
            let spare = columns.saturating_sub(used + 1) as f64 / columns as f64;
            let growth = (growth * (1.0 + spare)).clamp(0.5, GROWTH);
            let end = sum(y, table.pop());
            return Ok(Tried { end, error, growth, inner, stages: None });
        }
    }
    let growth = (0.9 * error.powf(-1.0 / (2.0 * columns as f64 - 1.0))).clamp(0.1, 0.8);
    let end = sum(y, table.pop());
    Ok(Tried { end, error, growth, inner, stages: None })
}

fn sum<R: Number>(y: &[R], moved: Option<Vec<R>>) -> Vec<R> {
    y.iter().zip(moved.unwrap_or_default()).map(|(y, moved)| *y + moved).collect()
}

/// The most iterations of the stages.
const ITERATIONS: usize = 150;

/// The power of the difference from one stage less that the error is taken for, where motion is stiff.
const STIFF: f64 = 1.15;

/// Where more iterations than this are to come, what changes within a step is worth its derivatives.
const MANY: f64 = 3.0;

/// What iterations may leave of what is allowed.
const LEFT: f64 = 1e-3;

fn too_long<R: Number>(y: &[R], growth: f64) -> Tried<R> {
    Tried { end: y.to_vec(), error: f64::INFINITY, growth, inner: Vec::new(), stages: None }
}

fn collocate<R: Number>(
    flow: &mut Flow<'_, R>,
    (t, y, slope): (R, &[R], &Slope<R>),
    h: R,
    allowed: &[R],
    tableau: &Tableau<R>,
    (newton, ahead): (&Newton<'_, R>, Option<&Ahead<'_, R>>),
) -> Result<Tried<R>, Trouble> {
    let Tableau { points, matrix, weights, fewer, spectrum } = tableau;
    let count = points.len();
    let mut rates = vec![slope.rates.clone(); count];
    let mut switches = vec![Vec::new(); count];
    let combine = |weights: &[R], rates: &[Vec<R>]| moved(y, h, weights, rates, 0..y.len());
    let shorter = if matches!(newton, Newton::All(_)) { 0.6 } else { 0.4 };
    let (sizes, onsets) = match (newton, spectrum) {
        (Newton::None, _) => (None, None),
        (Newton::Onsets(onsets), _) => (None, Some(Turns::new(onsets, y, matrix))),
        (Newton::All(sizes), Some(spectrum)) => (Some((sizes, spectrum)), None),
        (Newton::All(_), None) => return Ok(too_long(y, shorter)),
    };
    let (is_stiff, is_implicit) = (sizes.is_some(), sizes.is_some() || onsets.is_some());
    let mut all: Option<Improvement<'_>> = None;
    let ahead = ahead.filter(|_| onsets.is_none());
    let known = ahead.and_then(|ahead| ahead.stages?.at(tableau, (t, slope), h, (allowed, ahead.positions)));
    if let Some(known) = known {
        rates = known;
    }
    let places = ahead.map_or(0, |ahead| ahead.positions);
    let fill = |state: &mut [R], weights: &[R], rates: &[Vec<R>], which: Range<usize>| {
        state[which.clone()].clone_from_slice(&moved(y, h, weights, rates, which));
    };
    let mut states: Vec<Vec<R>> = matrix.iter().map(|weights| combine(weights, &rates)).collect();
    // What the last iteration changed, and the one before it.
    let [mut change, mut before, mut least] = [f64::INFINITY; 3];
    let mut iterations = 0.0;
    for iteration in 0.. {
        iterations += 1.0;
        let mut lacks = Vec::with_capacity(count);
        let mut slopes = Vec::with_capacity(count);
        match ahead {
            // Positions follow from rates at once, not an iteration later. Where nothing is known yet of turns, twice.
            Some(ahead) if iteration == 0 => {
                for _ in 0..2 {
                    states.iter().zip(&mut rates).for_each(|(state, rates)| ahead.turn(state, rates));
                    states
                        .iter_mut()
                        .zip(matrix)
                        .for_each(|(of, weights)| fill(of, weights, &rates, 0..places));
                }
            }
            Some(ahead) if !is_implicit => {
                for (state, weights) in states.iter_mut().zip(matrix) {
                    fill(state, weights, &rates, places..y.len());
                }
                states.iter().zip(&mut rates).for_each(|(state, rates)| ahead.turn(state, rates));
            }
            _ if iteration == 0 => {}
            _ => {
                states.iter_mut().zip(matrix).for_each(|(of, weights)| fill(of, weights, &rates, 0..y.len()));
            }
        }
        if let Some((sizes, spectrum)) = sizes {
            let mut changes = |at: &usize| {
                let (time, state) = (t + h * points[*at], &states[*at]);
                let slope = flow(time, state)?;
                let tangent = match ahead {
                    Some(ahead) => (ahead.tangent)(time, state, sizes)?,
                    None => Tangent::whole(sizes, 0),
                };
                let derivatives = stiff::derivatives(flow, (time, state, &slope), &tangent.directions)?;
                Ok(Change { tangent, derivatives })
            };
            // In the middle of the step, for iterations converge by how much it changes. Where that is much, on both sides too.
            let places = [count / 2, count - 1 - count / 6, count / 6];
            let left = (change / LEFT).ln() / (before / change).ln();
            match &mut all {
                None => all = Improvement::new(spectrum, changes(&places[0])?, h.to_f64()),
                Some(all) if iteration >= 2 && all.is_of_one() && !(0.0..MANY).contains(&left) => {
                    let others = places[1..].iter().map(changes).collect::<Result<_, Trouble>>()?;
                    let points: Vec<f64> = points.iter().map(|c| c.to_f64()).collect();
                    all.refine(others, &places, &points);
                }
                Some(_) => {}
            }
        }
        let earlier = before;
        (before, change) = (change, 0.0);
        for i in 0..count {
            let (time, stage) = (t + h * points[i], &mut states[i]);
            if !is_implicit {
                // By what the stages before it have become.
                fill(stage, &matrix[i], &rates, places..y.len());
                if let Some(ahead) = ahead {
                    ahead.turn(stage, &mut rates[i]);
                    fill(stage, &matrix[i], &rates, 0..places);
                }
            }
            if let Some(onsets) = onsets.as_ref().filter(|_| iteration == 0) {
                onsets.rest(stage);
            }
            let mut found = flow(time, stage)?;
            if let Some(onsets) = &onsets {
                if iteration == 0 {
                    onsets.begin(&mut found.rates);
                }
                slopes.push(onsets.slopes(flow, (time, stage, &found.rates))?);
            }
            switches[i] = found.switches;
            let by: Vec<R> = found.rates.iter().zip(&rates[i]).map(|(new, old)| *new - *old).collect();
            if is_implicit {
                lacks.push(by);
                continue;
            }
            change = change.max(excess(by.iter().map(|by| h * *by), allowed));
            rates[i] = found.rates;
        }
        if is_implicit {
            let changes = match (&all, &onsets) {
                (Some(all), _) => all.changes(&lacks),
                (None, Some(onsets)) => onsets.changes(lacks, &slopes, h.to_f64()),
                (None, None) => None,
            };
            let Some(changes) = changes else { return Ok(too_long(y, shorter)) };
            for (rates, changes) in rates.iter_mut().zip(changes) {
                change = change.max(excess(changes.iter().map(|by| h * *by), allowed));
                rates.iter_mut().zip(changes).for_each(|(rate, by)| *rate = *rate + by);
            }
        }
        // What further iterations would change, for each contracts as this one did; or what rounding leaves, below what is allowed.
        let contracts = iteration > 0 && change < before;
        let ahead = if contracts { change * change / (before - change) } else { change };
        let is_slow = change > before * 0.5;
        let most = if is_implicit { 0.5 } else { 0.05 };
        let was_fast = is_stiff && before < 0.3 * earlier;
        least = least.min(change);
        // Rounding may well be more once than it was before. What was fast, and is slow now, is rounding too.
        let is_rounding = is_slow && (least < most || was_fast) && change < 4.0 * most;
        if ahead < LEFT || is_rounding {
            break;
        }
        if iteration > 3 && change > before * 0.8 || iteration > ITERATIONS || !change.is_finite() {
            return Ok(too_long(y, shorter));
        }
    }
    let end = combine(weights, &rates);
    let other = combine(fewer, &rates);
    // The order with all stages is twice that without the last one.
    let tolerance = allowed.last().map_or(1.0, |last| last.to_f64());
    let differences: Vec<R> = end.iter().zip(&other).map(|(x, y)| *x - *y).collect();
    let damped = all
        .as_ref()
        .and_then(|all| all.damped(&differences.iter().map(|x| x.to_f64()).collect::<Vec<f64>>()));
    let part = tolerance
        * match damped {
            Some(damped) => excess(damped.into_iter().map(R::from_f64), allowed),
            None => excess(differences.into_iter(), allowed),
        };
    // Where motion changes within the step that order is not reached: three quarters of it are counted on. Where it is stiff, all stages and all but
    // one differ by two orders or less: that of a stage is the number of stages (Hairer, Wanner, II, IV.15).
    let error = part.powf(if is_stiff { STIFF } else { 1.5 }) / tolerance;
    let growth = match error <= 1e-30 {
        true => GROWTH,
        false => (0.9 * error.powf(-1.0 / (2.0 * count as f64))).clamp(0.1, GROWTH),
    };
    // Longer steps contract less: where an iteration gains less than a digit, they are long enough.
    let growth = growth.min((1.0 - tolerance.log10()) / iterations);
    let inner = points.iter().zip(switches).map(|(c, switches)| (c.to_f64(), switches)).collect();
    let stages = Some(Stages { begin: t, length: h, rates });
    Ok(Tried { end, error, growth, inner, stages })
}

/// Some of the numbers y + h Σ w_j ẏ_j.
fn moved<R: Number>(y: &[R], h: R, weights: &[R], rates: &[Vec<R>], which: Range<usize>) -> Vec<R> {
    let mut sum = vec![R::ZERO; which.len()];
    for (weight, rates) in weights.iter().zip(rates) {
        let factor = h * *weight;
        for (sum, rate) in sum.iter_mut().zip(&rates[which.clone()]) {
            *sum = *sum + factor * *rate;
        }
    }
    y[which].iter().zip(sum).map(|(y, moved)| *y + moved).collect()
}

impl<R: Number> Stages<R> {
    /// The rates at the stages of another step, by polynomials through those of this one that are next to its beginning. What they miss of the
    /// slope there tells how many of them are best. `None` where the slope itself is better. (Hairer, Wanner, II, IV.8: starting values.)
    fn at(
        &self,
        tableau: &Tableau<R>,
        (t, slope): (R, &Slope<R>),
        h: R,
        (allowed, positions): (&[R], usize),
    ) -> Option<Vec<Vec<R>>> {
        /// Of what rates change polynomials miss less than this part.
        const GAIN: f64 = 0.01;
        /// So little rates change by rounding, in units of what is allowed.
        const NOISE: f64 = 1e3;
        let points = &tableau.points;
        if self.rates.len() != points.len() || self.rates.iter().any(|of| of.len() != slope.rates.len()) {
            return None;
        }
        let from = (t - self.begin) / self.length;
        let place = |c: R| from + c * h / self.length;
        // What is known at the beginning itself tells nothing of what polynomials miss there.
        let known: Vec<(R, &Vec<R>)> =
            points.iter().copied().zip(&self.rates).filter(|(c, _)| !(*c - from).is_nothing()).collect();
        let at = |count: usize, x: R| -> Vec<R> {
            let mut sum = vec![R::ZERO; slope.rates.len()];
            for (j, (point, rates)) in known.iter().enumerate().take(count) {
                let others = known.iter().enumerate().take(count).filter(|(i, _)| *i != j);
                let weight = others
                    .fold(R::integer(1), |weight, (_, (other, _))| weight * (x - *other) / (*point - *other));
                sum.iter_mut().zip(*rates).for_each(|(sum, rate)| *sum = *sum + weight * *rate);
            }
            sum
        };
        let beyond = |rates: &[R]| {
            let pairs = rates.iter().zip(&slope.rates).skip(positions);
            excess(pairs.map(|(then, now)| h * (*then - *now)), allowed.get(positions..).unwrap_or_default())
        };
        // What polynomials miss grows as Π (x − c).
        let miss = |count: usize| {
            let parts = known.iter().take(count).map(|(c, _)| (place(R::integer(1)) - *c) / (from - *c));
            beyond(&at(count, from)) * parts.fold(1.0, |growth, part| growth * part.to_f64().abs())
        };
        let counts = (1..=known.len()).rev().step_by(2);
        let (least, count) =
            counts.map(|count| (miss(count), count)).min_by(|one, two| one.0.total_cmp(&two.0))?;
        let found: Vec<Vec<R>> = points.iter().map(|c| at(count, place(*c))).collect();
        let changes = found.iter().map(|rates| beyond(rates)).fold(0.0, f64::max);
        (least < GAIN * changes && changes > NOISE).then_some(found)
    }
}

impl<R: Number> Tableau<R> {
    /// Those of Radau IIA, the end of the step first.
    pub(crate) fn radau(stages: usize) -> Self {
        Self::new(radau(stages))
    }

    /// Collocation at these points of a step (Hairer, Nørsett, Wanner, Solving Ordinary Differential Equations I, II.7).
    fn new(points: Vec<R>) -> Self {
        let one = R::integer(1);
        let integrals = |points: &[R], to: R| -> Vec<R> {
            // Σ w_j c_jᵏ = toᵏ⁺¹/(k + 1)
            let mut system = System::new(points.len(), 1);
            let mut power = vec![one; points.len()];
            let mut right = to;
            for k in 0..points.len() {
                for (j, (power, c)) in power.iter_mut().zip(points).enumerate() {
                    system.add(k, j, *power);
                    *power = *power * *c;
                }
                system.add(k, points.len(), right / R::integer(k as i32 + 1));
                right = right * to;
            }
            system.solve().ok().and_then(|found| found.into_iter().next()).unwrap_or_default()
        };
        let matrix: Vec<Vec<R>> = points.iter().map(|c| integrals(&points, *c)).collect();
        let weights = integrals(&points, one);
        let mut fewer = integrals(points.get(..points.len() - 1).unwrap_or_default(), one);
        fewer.push(R::ZERO);
        let spectrum = Spectrum::of(&matrix);
        Self { points, matrix, weights, fewer, spectrum }
    }
}

/// The points of Gauss, from the last to the first: with s of them the order is 2 s.
fn gauss<R: Number>(stages: usize) -> Vec<R> {
    let guess = |i: usize| (std::f64::consts::PI * (i as f64 + 0.75) / (stages as f64 + 0.5)).cos();
    (0..stages).map(|i| root(guess(i), |x| legendre(stages, x))).collect()
}

/// The points of Radau IIA, the first of them the end of the step. With s of them the order is 2 s − 1, and what is stiff decays at once
/// (Hairer, Wanner, Solving Ordinary Differential Equations II, IV.5).
fn radau<R: Number>(stages: usize) -> Vec<R> {
    let guess = |i: usize| -(std::f64::consts::TAU * i as f64 / (2.0 * stages as f64 - 1.0)).cos();
    let difference = |x: R| {
        let [(value, slope), (other, of_other)] = [stages, stages - 1].map(|n| legendre(n, x));
        (value + other, slope + of_other)
    };
    let mut points: Vec<R> = (1..stages).map(|i| root(guess(i), difference)).collect();
    points.insert(0, R::integer(1));
    points
}

/// (1 − x)/2 of the root x next to a guess.
fn root<R: Number>(guess: f64, of: impl Fn(R) -> (R, R)) -> R {
    let mut x = R::from_f64(guess);
    for _ in 0..8 {
        let (value, slope) = of(x);
        x = x - value / slope;
    }
    (R::integer(1) - x) * R::ratio(1, 2)
}

/// P_n and its derivative.
fn legendre<R: Number>(n: usize, x: R) -> (R, R) {
    let one = R::integer(1);
    let (mut before, mut now) = (one, x);
    for k in 1..n {
        let k = k as i32;
        let next = (R::integer(2 * k + 1) * x * now - R::integer(k) * before) / R::integer(k + 1);
        before = std::mem::replace(&mut now, next);
    }
    let slope = R::integer(n as i32) * (x * now - before) / (x * x - one);
    (now, slope)
}

#[cfg(test)]
mod tests {
    use super::{Ahead, Method, Newton, Rule, Slope, Stages};
    use crate::motion::tangent::Tangent;
    use crate::number::Number;
    use pintle_kinematics::scalar::Wide;

    /// A pendulum's ẏ = (y₂, −sin-free cubic): ÿ = −y − y³, whose energy is kept.
    fn energy_after<R: Number>(method: Method, digits: usize, h: f64, steps: usize) -> f64 {
        let rule: Rule<R> = Rule::new(method, digits);
        let mut flow = |_: R, y: &[R]| {
            let force = R::ZERO - y[0] - y[0] * y[0] * y[0];
            Ok(Slope { rates: vec![y[1], force], switches: Vec::new() })
        };
        let energy = |y: &[R]| {
            let square = y[0] * y[0];
            y[1] * y[1] + square + square * square * R::ratio(1, 2)
        };
        let mut y = vec![R::integer(1), R::ZERO];
        let start = energy(&y);
        let allowed = vec![R::from_f64(10.0_f64.powi(-(digits as i32))); 2];
        for i in 0..steps {
            let t = R::from_f64(h * i as f64);
            let slope = flow(t, &y).unwrap();
            let tried = rule
                .step(&mut flow, (t, &y, &slope), R::from_f64(h), &allowed, (&Newton::None, None))
                .unwrap();
            assert!(tried.error <= 1.0, "{method:?}: {}", tried.error);
            y = tried.end;
        }
        (energy(&y) - start).magnitude().to_f64()
    }

    /// The second of two steps ends where it would, in fewer instants, where it begins with the stages of the first; what jumps between them
    /// begins with its slope.
    #[test]
    fn stages_go_on_from_those_of_the_step_before() {
        for method in [Method::Extrapolation, Method::Collocation] {
            let rule: Rule<f64> = Rule::new(method, 14);
            let newton = match method {
                Method::Extrapolation => Newton::All(vec![1.0; 2]),
                Method::Collocation => Newton::None,
            };
            let (h, allowed) = (0.1, [1e-14; 3]);
            let step = |force: f64, (t, y): (f64, &[f64]), stages: Option<&Stages<f64>>| {
                let mut count = 0;
                let mut flow = |_: f64, y: &[f64]| {
                    count += 1;
                    Ok(Slope { rates: vec![y[1], force - y[0] - y[0].powi(3)], switches: Vec::new() })
                };
                let slope = flow(t, y).unwrap();
                let tangent = |_: f64, _: &[f64], sizes: &[f64]| Ok(Tangent::whole(sizes, 1));
                let ahead =
                    Ahead { positions: 1, moving: &|y: &[f64]| vec![y[1]], tangent: &tangent, stages };
                let tried = rule.step(&mut flow, (t, y, &slope), h, &allowed, (&newton, Some(&ahead)));
                (tried.unwrap(), count)
            };
            let (first, _) = step(0.0, (0.0, &[1.0, 0.5]), None);
            for (force, is_new) in [(0.0, false), (3.0, true)] {
                let next = |stages| step(force, (h, &first.end), stages);
                let ((plain, many), (ahead, few)) = (next(None), next(first.stages.as_ref()));
                let apart =
                    plain.end.iter().zip(&ahead.end).fold(0.0_f64, |most, (x, y)| most.max((x - y).abs()));
                assert!(apart < 1e-14, "{method:?}: {apart:e}");
                assert!(if is_new { few == many } else { few + 9 <= many }, "{method:?}: {few} of {many}");
            }
        }
    }

    #[test]
    fn both_methods_keep_the_energy() {
        for method in [Method::Extrapolation, Method::Collocation] {
            let lost = energy_after::<f64>(method, 14, 0.1, 50);
            assert!(lost < 1e-13, "{method:?} on doubles: {lost:e}");
            let lost = energy_after::<Wide>(method, 36, 0.05, 20);
            assert!(lost < 1e-35, "{method:?} on 237 bits: {lost:e}");
        }
    }
}
