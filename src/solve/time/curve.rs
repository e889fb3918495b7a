//! Slips of several components on a static path.
//!
//! Friction opposes slip: positions change along its force, R_k ẋ_k = γ n_k with Σ n_k² = 1. At each time there is equilibrium with the force
//! μ F_N n, f_k = μ F_N R_k n_k (force, or moment by the radius R_k).
//!
//! A step of length h is collocated at the points c_i of Radau IIA (Hairer, Wanner, Solving Ordinary Differential Equations II, IV.5):
//! R_k (x_i − x_0)_k = h Σ a_ij γ_j n_jk. Newton's method solves for the directions n_i. The x_i are those of the equilibria with these
//! directions. γ may pass zero.

use crate::motion::linear::System;
use crate::motion::mode::{Does, Switch};
use crate::motion::rows::Trouble;
use crate::motion::slide::length;
use crate::motion::state::{DOFS, WORKS};
use crate::number::{Number, is_finite, larger, largest};
use crate::refusal::Refusal;
use crate::time::integrate::{Method, Tableau};
use crate::time::run::Run;
use crate::time::step::along_of;
use crate::time::still::{Curve, Found, Slip};
use crate::time::work::way;
use pintle_kinematics::so3;
use pintle_kinematics::vector::apply;

/// For each slip and each direction across its n: whose, which, and what the ways of all slips change as n turns that way.
type Slopes<R> = Vec<(usize, [R; 6], Vec<[R; 6]>)>;

/// n by slip.
type Directions<R> = Vec<[R; 6]>;

/// The points of a step.
struct Stage<R: Number> {
    /// n of each slip.
    along: Vec<[R; 6]>,
    /// R_k ẋ_k of each slip.
    moving: Vec<[R; 6]>,
    /// How far each has slipped.
    slips: Vec<R>,
    found: Found<R>,
}

/// The most iterations for the directions.
const ITERATIONS: usize = 40;

/// A direction that changes by more than this in an iteration (rad) belongs to another step: this one is too long.
const LARGEST: f64 = 1.0;

impl<R: Number> Run<'_, R> {
    /// The frictions that slip with several components.
    pub(crate) fn curving(&self) -> Vec<usize> {
        let frictions = self.mechanism.sliders.iter().zip(&self.modes.frictions).enumerate();
        let several = frictions.filter(|(_, (slider, mode))| slider.components.len() > 1 && !mode.is_stuck());
        several.map(|(s, _)| s).collect()
    }

    /// The equilibrium at a later time, along the curves of these frictions.
    pub(crate) fn along_curves(&mut self, time: R, curving: &[usize]) -> Result<Found<R>, Refusal> {
        let modes = self.modes.clone();
        let found = self.collocated(time, curving);
        self.modes = modes;
        found
    }

    fn collocated(&mut self, time: R, curving: &[usize]) -> Result<Found<R>, Refusal> {
        let zero = R::ZERO;
        let start = self.state.time;
        let h = time - start;
        // The witness has more points.
        let stages = 5 + self.options.digits / 4 + usize::from(self.options.method == Method::Collocation);
        let tableau = self.radau.get_or_insert_with(|| Tableau::radau(stages)).clone();
        let inverse = inverse(&tableau.matrix);
        let before = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        let places: Vec<[R; 6]> =
            self.mechanism.sliders.iter().map(|slider| before.joints[slider.joint].position).collect();
        let begun: Vec<R> = curving.iter().map(|s| self.state.sums[WORKS + s]).collect();
        let along: Vec<[R; 6]> =
            curving.iter().map(|s| self.modes.frictions[*s].along().copied().unwrap_or([zero; 6])).collect();
        let lost = |run: &Self| {
            Refusal::of(
                "the static path",
                &format!("no direction of slip follows at time {}", run.state.time.to_f64()),
                "load more slowly there, or use *DYNAMIC",
            )
        };
        let mut all: Vec<Stage<R>> = Vec::with_capacity(stages);
        for c in &tableau.points {
            let found = self.stage(start + h * *c, (curving, &along, &begun), None)?;
            all.push(Stage { along: along.clone(), moving: along.clone(), slips: begun.clone(), found });
        }
        let mut slopes: Vec<Slopes<R>> = Vec::new();
        let mut last = f64::INFINITY;
        for iteration in 0.. {
            // R_k ẋ_k, and from it how far each has slipped.
            let ways: Vec<Vec<[R; 6]>> =
                all.iter().map(|stage| self.ways(curving, &places, &stage.found)).collect();
            for (stage, row) in all.iter_mut().zip(&inverse) {
                for q in 0..curving.len() {
                    stage.moving[q] = std::array::from_fn(|k| sum(row, ways.iter().map(|way| way[q][k])) / h);
                }
            }
            let mut slid: f64 = 0.0;
            for i in 0..stages {
                for q in 0..curving.len() {
                    let rates = all.iter().map(|stage| along_of(&stage.along[q], &stage.moving[q]));
                    let slip = begun[q] + h * sum(&tableau.matrix[i], rates);
                    let unit = larger(slip.magnitude(), R::from_f64(self.mechanism.length));
                    slid = slid.max(((slip - all[i].slips[q]).magnitude() / unit).to_f64());
                    all[i].slips[q] = slip;
                }
            }
            if iteration == 0 || slopes.is_empty() {
                slopes = self.slopes(&all, (curving, &places), start, h, &tableau.points)?;
            }
            let turned = self.turned(&all, curving, &slopes, &inverse, h).ok_or_else(|| lost(self))?;
            let mut most: f64 = 0.0;
            for (i, (stage, turned)) in all.iter_mut().zip(turned).enumerate() {
                for (along, by) in stage.along.iter_mut().zip(turned) {
                    most = most.max(length(&by).to_f64());
                    let next: [R; 6] = std::array::from_fn(|k| along[k] + by[k]);
                    let size = length(&next);
                    *along = next.map(|x| x / size);
                }
                let at = start + h * tableau.points[i];
                stage.found = self.stage(at, (curving, &stage.along, &stage.slips), Some(&stage.found))?;
            }
            let now = most.max(slid);
            if !now.is_finite() || most > LARGEST || iteration == ITERATIONS {
                return Err(lost(self));
            }
            // As small as rounding leaves it: that of a way that is short is large.
            let noise = curving.iter().enumerate().map(|(q, s)| {
                let far = largest(all.iter().map(|stage| length(&stage.moving[q]) * h));
                (self.slip_noise(&before, *s) / larger(far, R::from_f64(f64::MIN_POSITIVE))).to_f64()
            });
            let noise = noise.fold(0.0, f64::max).min(1e-3);
            if now < 8.0 * R::ROUNDING || now < (1e5 * R::ROUNDING).max(noise) && now > last * 0.3 {
                break;
            }
            if now > last * 0.1 {
                slopes.clear();
            }
            last = now;
        }
        let works = self.works_along(&all, (&inverse, &tableau.weights), h)?;
        self.ended(all, curving, &tableau, works).ok_or_else(|| lost(self))
    }

    /// The step's end, and what it knows.
    fn ended(
        &self,
        all: Vec<Stage<R>>,
        curving: &[usize],
        tableau: &Tableau<R>,
        works: [R; WORKS],
    ) -> Option<Found<R>> {
        let last = all.first()?;
        let at_start = extrapolation(&tableau.points);
        let slips = curving.iter().enumerate().map(|(q, s)| {
            let rates = all.iter().map(|stage| along_of(&stage.along[q], &stage.moving[q]));
            let first: [R; 6] =
                std::array::from_fn(|k| sum(&at_start, all.iter().map(|stage| stage.along[q][k])));
            let size = length(&first);
            Slip {
                of: *s,
                along: [first.map(|x| x / size), last.along[q]],
                rates: [sum(&at_start, rates), along_of(&last.along[q], &last.moving[q])],
            }
        });
        let slips = slips.collect();
        let mut stages = all.into_iter().zip(&tableau.points);
        let (end, _) = stages.next()?;
        let mut inner: Vec<(f64, Vec<Switch<R>>)> =
            stages.map(|(stage, c)| (c.to_f64(), stage.found.solved.switches)).collect();
        inner.sort_by(|one, two| one.0.total_cmp(&two.0));
        let mut found = end.found;
        found.curve = Some(Curve { slips, inner, works });
        Some(found)
    }

    /// The equilibrium of one point, near one that is known.
    fn stage(
        &mut self,
        time: R,
        (curving, along, slips): (&[usize], &[[R; 6]], &[R]),
        near: Option<&Found<R>>,
    ) -> Result<Found<R>, Refusal> {
        let mut known = Vec::with_capacity(curving.len());
        for ((s, along), slip) in curving.iter().zip(along).zip(slips) {
            self.modes.frictions[*s].does = Does::Slips(*along);
            known.push((*s, *slip));
        }
        self.equilibrium(time, near.map_or(&[], |near| &near.by), &known)
    }

    /// R_k (x − x_0)_k of each slip.
    fn ways(&self, curving: &[usize], places: &[[R; 6]], found: &Found<R>) -> Vec<[R; 6]> {
        let of = curving.iter();
        of.map(|s| self.mechanism.sliders[*s].moved(&places[*s], &found.positions[*s])).collect()
    }

    /// By point.
    fn slopes(
        &mut self,
        all: &[Stage<R>],
        (curving, places): (&[usize], &[[R; 6]]),
        start: R,
        h: R,
        points: &[R],
    ) -> Result<Vec<Slopes<R>>, Refusal> {
        let step = R::from_f64(R::ROUNDING.sqrt());
        let mut slopes = Vec::with_capacity(all.len());
        for (stage, c) in all.iter().zip(points) {
            let here = self.ways(curving, places, &stage.found);
            let mut of = Vec::new();
            for (q, s) in curving.iter().enumerate() {
                for across in across(&stage.along[q], &self.mechanism.sliders[*s].components) {
                    let mut along = stage.along.clone();
                    along[q] = std::array::from_fn(|k| along[q][k] + step * across[k]);
                    let found =
                        self.stage(start + h * *c, (curving, &along, &stage.slips), Some(&stage.found))?;
                    let there = self.ways(curving, places, &found);
                    let change = there
                        .iter()
                        .zip(&here)
                        .map(|(then, now)| std::array::from_fn(|k| (then[k] - now[k]) / step));
                    of.push((q, across, change.collect()));
                }
            }
            slopes.push(of);
        }
        Ok(slopes)
    }

    /// Newton's step: by what each n turns, so that R_k ẋ_k has no part across it. By point and slip.
    fn turned(
        &self,
        all: &[Stage<R>],
        curving: &[usize],
        slopes: &[Slopes<R>],
        inverse: &[Vec<R>],
        h: R,
    ) -> Option<Vec<Directions<R>>> {
        let width = slopes.first().map_or(0, Vec::len);
        let mut system = System::new(all.len() * width, 1);
        for (i, stage) in all.iter().enumerate() {
            // Across n as it is now: those of the slopes are of before.
            let now = curving.iter().enumerate().flat_map(|(q, s)| {
                let all = across(&stage.along[q], &self.mechanism.sliders[*s].components);
                all.into_iter().map(move |across| (q, across))
            });
            for (row, (q, across)) in now.enumerate() {
                let at = i * width + row;
                let lack = along_of(&across, &stage.moving[q]);
                system.add(at, all.len() * width, R::ZERO - lack);
                let rate = along_of(&stage.along[q], &stage.moving[q]);
                system.add(at, at, R::ZERO - rate);
                for (j, of) in slopes.iter().enumerate() {
                    for (column, (_, _, change)) in of.iter().enumerate() {
                        let by = along_of(&across, &change[q]) * inverse[i][j] / h;
                        system.add(at, j * width + column, by);
                    }
                }
            }
        }
        let found = system.solve().ok()?.into_iter().next()?;
        if !found.iter().all(|x| is_finite(*x)) {
            return None;
        }
        let turned = slopes.iter().enumerate().map(|(i, of)| {
            let mut by = vec![[R::ZERO; 6]; curving.len()];
            for (row, (q, across, _)) in of.iter().enumerate() {
                let part = found[i * width + row];
                by[*q] = std::array::from_fn(|k| by[*q][k] + part * across[k]);
            }
            by
        });
        Some(turned.collect())
    }

    /// External work, dissipation and stored energy: powers at the points, with the rates of the polynomials through them.
    fn works_along(
        &self,
        all: &[Stage<R>],
        (inverse, weights): (&[Vec<R>], &[R]),
        h: R,
    ) -> Result<[R; WORKS], Refusal> {
        let zero = R::ZERO;
        let mut works = [zero; WORKS];
        // Since the beginning, by point and node.
        let since = |stage: &Stage<R>| -> Vec<[R; DOFS]> {
            self.state.poses.iter().zip(&stage.found.state.poses).map(|(from, to)| way(from, to)).collect()
        };
        let ways: Vec<Vec<[R; DOFS]>> = all.iter().map(since).collect();
        for (i, stage) in all.iter().enumerate() {
            let rates: Vec<[R; DOFS]> = (0..self.state.poses.len())
                .map(|node| {
                    let [x, y, z, a, b, c, flow]: [R; DOFS] =
                        std::array::from_fn(|k| sum(&inverse[i], ways.iter().map(|way| way[node][k])) / h);
                    let [_, _, _, u, v, w, _] = ways[i][node];
                    let [p, q, r] = apply(&so3::left_jacobian([u, v, w]), [a, b, c]);
                    [x, y, z, p, q, r, flow]
                })
                .collect();
            let powers = self.powers(&stage.found, &rates).map_err(|trouble: Trouble| self.say(trouble))?;
            for (work, power) in works.iter_mut().zip(powers) {
                *work = *work + h * weights[i] * power;
            }
        }
        Ok(works)
    }
}

fn sum<R: Number>(weights: &[R], of: impl Iterator<Item = R>) -> R {
    weights.iter().zip(of).fold(R::ZERO, |sum, (weight, x)| sum + *weight * x)
}

/// Directions across n within some components (Householder).
fn across<R: Number>(n: &[R; 6], components: &[(usize, f64)]) -> Vec<[R; 6]> {
    let Some(((first, _), others)) = components.split_first() else { return Vec::new() };
    let mut v = *n;
    let one = R::integer(1);
    v[*first] = v[*first] + if v[*first].less(R::ZERO) { -one } else { one };
    let square = along_of(&v, &v);
    let reflected = |k: usize| {
        let factor = R::integer(2) * v[k] / square;
        std::array::from_fn(|i| if i == k { one - factor * v[i] } else { R::ZERO - factor * v[i] })
    };
    others.iter().map(|(k, _)| reflected(*k)).collect()
}

/// The weights by which numbers at points c give the one at 0 of the polynomial through them.
fn extrapolation<R: Number>(points: &[R]) -> Vec<R> {
    let weight = |i: usize| {
        let others = points.iter().enumerate().filter(|(j, _)| *j != i);
        others.fold(R::integer(1), |product, (_, c)| product * *c / (*c - points[i]))
    };
    (0..points.len()).map(weight).collect()
}

/// The inverse of a matrix of stages.
fn inverse<R: Number>(matrix: &[Vec<R>]) -> Vec<Vec<R>> {
    let n = matrix.len();
    let mut system = System::new(n, n);
    for (i, row) in matrix.iter().enumerate() {
        for (j, entry) in row.iter().enumerate() {
            system.add(i, j, *entry);
        }
        system.add(i, n + i, R::integer(1));
    }
    let columns = system.solve().unwrap_or_default();
    (0..n).map(|i| columns.iter().map(|column| column[i]).collect()).collect()
}
