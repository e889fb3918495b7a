//! Slopes of a function of a few numbers, judged by every oracle that can answer: differences on 237 bits, the product's dual
//! numbers there, differences on doubles.

use crate::case::quantity::Quantity;
use crate::judge::bound::C;
use crate::judge::table::{Entry, ResultTable};
use crate::judge::verdict::Verdict;
use crate::mutants::mutant::{Mistake, Mutant};
use crate::oracles::oracle::Oracle;
use crate::settings::Settings;
use crate::singular::sides::Sides;
use pintle_kinematics::scalar::{Scalar, U, Wide};

/// Where one of its inputs has moved by some amount, what a function gives there.
type At<'a, T, V> = Box<dyn Fn(usize, T) -> V + 'a>;

/// A function with the slopes that are given for it. Slopes are by outputs, then by inputs.
pub(crate) struct Slopes<'a> {
    pub(crate) quantity: Quantity,
    /// What the slopes are of: `∂{output}/∂{input}`.
    pub(crate) outputs: Vec<Output>,
    /// What they are by.
    pub(crate) inputs: Vec<Argument>,
    /// Where the outputs are slopes themselves, `²{function}/∂{input}`, the matrices that they make, as sentences name them: `∂²{function}`.
    pub(crate) matrices: Option<Vec<String>>,
    /// Which slopes must show a relative error of a billionth, whatever is allowed; none where that is not known.
    pub(crate) demanded: Vec<Vec<bool>>,
    /// The class of each slope.
    pub(crate) class: &'a dyn Fn(usize, usize) -> (usize, usize, usize),
    /// The slopes given.
    pub(crate) got: Vec<Vec<f64>>,
    /// The step of differences on 237 bits, in sizes.
    pub(crate) step: f64,
    /// The function on 237 bits.
    pub(crate) wide: At<'a, Wide, Vec<Wide>>,
    /// The function on doubles.
    pub(crate) narrow: At<'a, f64, Vec<f64>>,
    /// The slopes on doubles.
    pub(crate) slopes: At<'a, f64, Vec<Vec<f64>>>,
    /// The slopes by dual numbers on 237 bits.
    pub(crate) dual: Box<dyn Fn() -> Vec<Vec<Wide>> + 'a>,
    /// The same slopes with a mistake in them: computed with the mistake, not made of the slopes given.
    pub(crate) mistaken: Vec<(Mistake, Vec<Vec<f64>>)>,
    /// The same function where what presses is held, of a friction.
    pub(crate) held: Option<Held<'a>>,
}

/// What a function gives.
pub(crate) struct Output {
    pub(crate) name: String,
    /// The magnitude of what it is formed from.
    pub(crate) magnitude: f64,
    /// Outputs with the same number share what they are computed from: each is as uncertain as the largest of them.
    pub(crate) kind: usize,
}

/// What a function depends on.
#[derive(Clone)]
pub(crate) struct Argument {
    pub(crate) name: String,
    /// What it is measured by, positive.
    pub(crate) size: f64,
    /// How far it may go while the function bends little: steps on doubles are parts of it.
    pub(crate) reach: f64,
    /// What it is rounded by, in units of rounding: the number itself where it is given, its size where it is formed of others; and more
    /// where it is combined with what is larger than it is.
    pub(crate) rounded: f64,
}

impl Output {
    /// Outputs of those names, each formed of what has that magnitude and is of that kind.
    pub(crate) fn list(of: impl IntoIterator<Item = (impl Into<String>, f64, usize)>) -> Vec<Self> {
        of.into_iter().map(|(name, magnitude, kind)| Self { name: name.into(), magnitude, kind }).collect()
    }
}

impl Argument {
    /// Inputs of those names, sizes and reaches, rounded as their sizes are, and by what they are combined with besides.
    pub(crate) fn list<N: AsRef<str>>(
        names: &[N],
        sizes: &[f64],
        reach: &[f64],
        beside: impl Fn(usize) -> f64,
    ) -> Vec<Self> {
        let of = |(j, ((name, size), reach)): (usize, ((&N, &f64), &f64))| Self {
            name: name.as_ref().to_string(),
            size: *size,
            reach: *reach,
            rounded: size + beside(j),
        };
        names.iter().zip(sizes).zip(reach).enumerate().map(of).collect()
    }
}

/// A function of which some inputs only press, while that is held: the mistake of a tangent without the coupling to what presses.
pub(crate) struct Held<'a> {
    /// The slope by an input that only presses: 0, or 1 of a reaction by itself. Nothing of other inputs.
    pub(crate) known: Box<dyn Fn(usize, usize) -> Option<f64> + 'a>,
    /// The function on 237 bits, where other inputs press too; without it, slopes by them are as they are.
    pub(crate) wide: Option<At<'a, Wide, Vec<Wide>>>,
}

/// What differences on 237 bits say.
struct WideSlopes {
    slopes: Vec<Vec<Wide>>,
    sides: Vec<Vec<Option<Sides>>>,
}

impl Slopes<'_> {
    /// The tables of the oracles that are asked, each with the mistakes to be tried on it; on doubles only unless `wide`.
    pub(crate) fn tables(&self, settings: &Settings, wide: bool) -> Vec<(Oracle, ResultTable)> {
        let asked = |oracle: Oracle| settings.oracles.contains(&oracle);
        let scales = self.scales();
        let mut found = Vec::new();
        let truth = (wide && [Oracle::WideDifferences, Oracle::WideDual].into_iter().any(asked))
            .then(|| self.truth(&scales));
        if let Some(truth) = truth {
            let held = self.held_slopes();
            let held = Some(held.as_slice()).filter(|held| !held.is_empty());
            if asked(Oracle::WideDual) {
                let dual = (self.dual)();
                let at = |i: usize, j: usize| (value(&dual, i, j), 0.0, truth.sides[i][j]);
                found.push(self.table(Oracle::WideDual, &scales, held, at));
            }
            if asked(Oracle::WideDifferences) {
                let at = |i: usize, j: usize| (truth.slopes[i][j], 0.0, truth.sides[i][j]);
                found.push(self.table(Oracle::WideDifferences, &scales, held, at));
            }
        }
        if asked(Oracle::Differences) {
            let estimates = self.differences(&scales);
            let at = |i: usize, j: usize| {
                let (slope, error) = estimates[i][j];
                (Wide::from_f64(slope), error, None)
            };
            let table = self.table(Oracle::Differences, &scales, None, at);
            // What differences on doubles call wrong is put before those on 237 bits.
            if !wide && asked(Oracle::WideDifferences) && table.1.judge().verdict == Verdict::Wrong {
                let truth = self.truth(&scales);
                let at = |i: usize, j: usize| (truth.slopes[i][j], 0.0, truth.sides[i][j]);
                found.push(self.table(Oracle::WideDifferences, &scales, None, at));
            }
            found.push(table);
        }
        found
    }

    fn table(
        &self,
        oracle: Oracle,
        scales: &Scales,
        held: Option<&[Vec<Wide>]>,
        at: impl Fn(usize, usize) -> (Wide, f64, Option<Sides>),
    ) -> (Oracle, ResultTable) {
        let mut entries = Vec::new();
        for (i, output) in self.outputs.iter().enumerate() {
            for (j, input) in self.inputs.iter().enumerate() {
                let (want, error, sides) = at(i, j);
                let over = if self.matrices.is_some() { "" } else { "/" };
                let name = format!("∂{}{over}∂{}", output.name, input.name);
                let (got, scale) = (self.got[i][j], scales.entries[i][j]);
                let class = (self.class)(i, j);
                let is_demanded = self.demanded.get(i).and_then(|row| row.get(j)) == Some(&true);
                entries.push(Entry {
                    error,
                    sides,
                    is_demanded,
                    ..Entry::new(name, got, want, scale, class)
                });
            }
        }
        let mut table = ResultTable::new(self.quantity);
        table.entries = entries;
        match &self.matrices {
            Some(matrices) => table.rows.clone_from(matrices),
            None => {
                table.rows = self.outputs.iter().map(|output| format!("∂{}", output.name)).collect();
                table.columns = self.inputs.iter().map(|input| input.name.clone()).collect();
            }
        }
        let is_kink = |place: &usize| table.entries.get(*place).is_some_and(|entry| entry.sides.is_some());
        let width = table.width();
        let made = |mistake: Mistake, changes: &mut dyn Iterator<Item = (usize, f64)>| {
            Mutant::many(mistake, changes.map(|(place, x)| (place / width, place % width, x)))
        };
        let of = |(mistake, wrong): &(Mistake, Vec<Vec<f64>>)| {
            let all = wrong.iter().flatten().copied().enumerate();
            made(*mistake, &mut all.filter(|(place, _)| !is_kink(place)))
        };
        let mut mistakes: Vec<Mutant> = self.mistaken.iter().map(of).collect();
        let uncoupled = self.uncoupled(&table.entries, held);
        mistakes.extend(uncoupled.map(|all| made(Mistake::CouplingMissing, &mut all.into_iter())));
        table.mistakes = mistakes;
        (oracle, table)
    }

    /// What the right slopes are while what presses is held, where that changes them; nothing where it changes none.
    fn uncoupled(&self, entries: &[Entry], held: Option<&[Vec<Wide>]>) -> Option<Vec<(usize, f64)>> {
        let known = &self.held.as_ref()?.known;
        let n = self.inputs.len();
        let of = |(place, entry): (usize, &Entry)| {
            let (i, j) = (place / n, place % n);
            let slope = known(i, j).or_else(|| Some(held?.get(i)?.get(j)?.to_f64()))?;
            let differs = entry.sides.is_none() && (slope - entry.want.to_f64()).abs() > entry.tolerance();
            differs.then_some((place, slope))
        };
        let changes: Vec<(usize, f64)> = entries.iter().enumerate().filter_map(of).collect();
        (!changes.is_empty()).then_some(changes)
    }

    /// The slopes while what presses is held, by differences on 237 bits; none where they are known without.
    fn held_slopes(&self) -> Vec<Vec<Wide>> {
        let Some(Held { known, wide: Some(held) }) = &self.held else { return Vec::new() };
        let (m, n) = (self.outputs.len(), self.inputs.len());
        let mut slopes = vec![vec![Wide::zero(); n]; m];
        for j in (0..n).filter(|j| (0..m).any(|i| known(i, *j).is_none())) {
            let h = Wide::from_f64(self.step * self.inputs[j].size);
            let (plus, minus) = (held(j, h), held(j, -h));
            for i in 0..m {
                slopes[i][j] = (plus[i] - minus[i]) / (h + h);
            }
        }
        slopes
    }

    /// The slopes along an input by differences with a step, in its size, and both sides.
    fn along(&self, still: &[Wide], j: usize, step: f64) -> Vec<(Wide, Sides)> {
        let h = Wide::from_f64(step * self.inputs[j].size);
        let (plus, minus) = ((self.wide)(j, h), (self.wide)(j, -h));
        let sides = |i: usize| Sides::known([(still[i] - minus[i]) / h, (plus[i] - still[i]) / h]);
        (0..self.outputs.len()).map(|i| ((plus[i] - minus[i]) / (h + h), sides(i))).collect()
    }

    /// The slopes along an input, which of them have two sides, and which have none. Two sides are apart by more than `least`, and
    /// do not come nearer to each other as the step shrinks, as they do wherever the function is smooth. A slope has none where it
    /// is not the one given and grows as the step shrinks, as that of |f|^(3/2) where f = 0 does to second order.
    fn kinked(&self, still: &[Wide], j: usize, least: &dyn Fn(usize) -> f64) -> Vec<(Wide, Option<Sides>)> {
        /// A shorter step.
        const SHORTER: f64 = 1e-3;
        /// By how much more a slope without end grows over a thousandth of the step: a power of it, 1/70 and more.
        const GROWS: f64 = 1.1;
        let found = self.along(still, j, self.step);
        let is_apart = |i: usize, sides: &Sides| sides.gap() > least(i);
        let is_other = |i: usize, slope: Wide| {
            let got = self.got.get(i).and_then(|row| row.get(j)).copied().unwrap_or(0.0);
            (slope - Wide::from_f64(got)).abs() > Wide::from_f64(least(i))
        };
        let needs = found.iter().enumerate().any(|(i, (_, sides))| is_apart(i, sides));
        let needs_longer = found.iter().enumerate().any(|(i, (slope, _))| is_other(i, *slope));
        let longer = if needs_longer { self.along(still, j, self.step / SHORTER) } else { Vec::new() };
        let shorter = if needs { self.along(still, j, SHORTER * self.step) } else { Vec::new() };
        let with = |(i, (slope, sides)): (usize, (Wide, Sides))| {
            let stays = shorter.get(i).is_some_and(|(_, shorter)| shorter.gap() > 0.5 * sides.gap());
            // What is differenced may be a difference itself, with a step that does not shrink: it is lengthened.
            let grows = longer.get(i).is_some_and(|(longer, _)| {
                slope.abs() > longer.abs() * Wide::from_f64(GROWS)
                    && (slope - *longer).abs() > Wide::from_f64(least(i))
            });
            if is_other(i, slope) && grows {
                return (slope, Some(sides.unsettled()));
            }
            (slope, Some(sides).filter(|sides| is_apart(i, sides) && stays))
        };
        found.into_iter().enumerate().map(with).collect()
    }

    fn truth(&self, scales: &Scales) -> WideSlopes {
        let still = (self.wide)(0, Wide::zero());
        let (m, n) = (self.outputs.len(), self.inputs.len());
        let mut truth = WideSlopes { slopes: vec![vec![Wide::zero(); n]; m], sides: vec![vec![None; n]; m] };
        for j in 0..n {
            // What is less than a tolerance apart is one slope.
            let found = self.kinked(&still, j, &|i| C * U * scales.entries[i][j]);
            for (i, (slope, sides)) in found.into_iter().enumerate() {
                (truth.slopes[i][j], truth.sides[i][j]) = (slope, sides);
            }
        }
        truth
    }

    /// The conditioned scales of slopes and values, from the slopes given and how they change: good enough for a bound, and
    /// the same for every oracle.
    fn scales(&self) -> Scales {
        const STEP: f64 = 1e-5;
        let (m, n) = (self.outputs.len(), self.inputs.len());
        let own = |i: usize| {
            let slopes = self.got[i].iter().zip(&self.inputs).map(|(slope, input)| slope.abs() * input.size);
            self.outputs[i].magnitude + slopes.sum::<f64>()
        };
        let own: Vec<f64> = (0..m).map(own).collect();
        let of_kind = |i: usize| {
            let alike = (0..m).filter(|other| self.outputs[*other].kind == self.outputs[i].kind);
            alike.map(|other| own[other]).fold(0.0, f64::max)
        };
        let values: Vec<f64> = (0..m).map(of_kind).collect();
        let mut entries: Vec<Vec<f64>> =
            values.iter().map(|f| self.inputs.iter().map(|input| f / input.size).collect()).collect();
        for l in 0..n {
            let Argument { rounded, reach, .. } = self.inputs[l];
            if rounded == 0.0 {
                continue;
            }
            let h = STEP * reach;
            let (plus, minus) = ((self.slopes)(l, h), (self.slopes)(l, -h));
            for i in 0..m {
                for j in 0..n {
                    let bent = (value(&plus, i, j) - value(&minus, i, j)).abs() / (2.0 * h);
                    if bent.is_finite() {
                        entries[i][j] += bent * rounded;
                    }
                }
            }
        }
        Scales { values, entries }
    }

    /// Central differences on doubles: the best of a ladder of steps, with an estimate of its own error.
    fn differences(&self, scales: &Scales) -> Vec<Vec<(f64, f64)>> {
        const LADDER: [f64; 4] = [1e-3, 1e-4, 1e-5, 1e-6];
        let still = (self.narrow)(0, 0.0);
        let (m, n) = (self.outputs.len(), self.inputs.len());
        let mut found = vec![vec![(f64::NAN, f64::INFINITY); n]; m];
        for j in 0..n {
            let sides = LADDER.map(|h| {
                let h = h * self.inputs[j].reach;
                ((self.narrow)(j, h), (self.narrow)(j, -h), h)
            });
            for i in 0..m {
                let estimates = sides.each_ref().map(|(plus, minus, h)| {
                    let jump = ((plus[i] - still[i]) - (still[i] - minus[i])).abs() / h;
                    ((plus[i] - minus[i]) / (2.0 * h), jump, 16.0 * U * scales.values[i] / h)
                });
                for pair in estimates.windows(2) {
                    let [(coarse, wider, _), (fine, jump, rounding)] = pair else { continue };
                    let mut error = (coarse - fine).abs() + rounding;
                    // Sides that do not come together as steps shrink have a kink between them.
                    if *jump > 0.5 * wider + 2.0 * rounding {
                        error += jump;
                    }
                    if error < found[i][j].1 {
                        found[i][j] = (*fine, error);
                    }
                }
            }
        }
        found
    }
}

/// Conditioned scales.
pub(crate) struct Scales {
    /// Of the outputs.
    pub(crate) values: Vec<f64>,
    /// Of the slopes.
    pub(crate) entries: Vec<Vec<f64>>,
}

impl Slopes<'_> {
    /// The conditioned scales of the outputs.
    pub(crate) fn value_scales(&self) -> Vec<f64> {
        self.scales().values
    }

    /// Which of the outputs have no kink along any input, whatever oracles are asked: none at all, however small.
    pub(crate) fn are_smooth(&self) -> Vec<bool> {
        /// A hundred thousand roundings of 237 bits.
        const NOISE: f64 = 1e-66;
        let values = self.value_scales();
        let still = (self.wide)(0, Wide::zero());
        let mut smooth = vec![true; self.outputs.len()];
        for j in 0..self.inputs.len() {
            let noise = |i: usize| NOISE * values[i] / (self.step * self.inputs[j].size);
            for (smooth, (_, sides)) in smooth.iter_mut().zip(self.kinked(&still, j, &noise)) {
                *smooth &= sides.is_none();
            }
        }
        smooth
    }
}

fn value<T: Copy>(of: &[Vec<T>], i: usize, j: usize) -> T {
    of[i][j]
}
