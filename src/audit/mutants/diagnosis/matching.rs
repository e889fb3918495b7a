//! Wrong numbers beside what mistakes would make of the right ones: which mistakes are believed, wherever the numbers come from.

use crate::judge::bound::C;
use crate::mutants::diagnosis::cells::{Cell, Cells};
use crate::mutants::diagnosis::seen::Seen;
use crate::mutants::diagnosis::{Cause, Diagnosis, Explained};
use crate::mutants::mutant::{Changes, NOTHING};
use pintle_kinematics::scalar::U;
use pintle_scene::Code;
use pintle_scene::grammar::number as short;
use std::collections::{BTreeMap, BTreeSet};

/// Numbers of one class have one unit.
pub(super) type Class = (usize, usize, usize);

/// A number that may be wrong.
pub(super) struct Datum {
    /// What was given; none where nothing was.
    pub(super) got: Option<f64>,
    pub(super) want: f64,
    pub(super) tolerance: f64,
    /// The largest tolerance of its class.
    of_class: f64,
}

/// What a mistake, or another convention than expected, would make of the numbers.
#[derive(Clone, Debug)]
pub struct Hypothesis {
    /// The cause that it is.
    pub cause: Cause,
    /// The numbers.
    pub changes: Changes,
    /// What the numbers equal, where the cause leaves it open.
    pub relation: Option<String>,
    /// Whether it was found among many others, so that one that was thought of says more.
    pub(super) is_searched: bool,
}

impl Hypothesis {
    pub(crate) const fn new(cause: Cause, changes: Changes) -> Self {
        Self { cause, changes, relation: None, is_searched: false }
    }

    pub(super) const fn one(cause: Cause, (k, i): Cell, x: f64) -> Self {
        Self::new(cause, Changes::One([(k, i, x)]))
    }

    /// Changes of row k: place, number.
    pub(crate) fn of_row(cause: Cause, k: usize, changes: impl IntoIterator<Item = (usize, f64)>) -> Self {
        Self::many(cause, changes.into_iter().map(|(i, x)| (k, i, x)).collect())
    }

    pub(crate) const fn many(cause: Cause, changes: Vec<(usize, usize, f64)>) -> Self {
        Self::new(cause, Changes::Many(changes))
    }

    pub(crate) fn related(self, relation: impl Into<String>) -> Self {
        self.related_if(Some(relation))
    }

    /// The same where its cause leaves it open what the numbers equal.
    pub(crate) fn related_if(self, relation: Option<impl Into<String>>) -> Self {
        Self { relation: relation.map(Into::into), ..self }
    }
}

/// Where mistakes are gathered.
pub(crate) trait Gather: Extend<Hypothesis> {
    /// Changes of row k, and what they equal.
    fn row(
        &mut self,
        cause: Cause,
        k: usize,
        changes: impl IntoIterator<Item = (usize, f64)>,
        relation: impl Into<String>,
    ) {
        self.extend([Hypothesis::of_row(cause, k, changes).related(relation)]);
    }
}

impl Gather for Vec<Hypothesis> {}

/// How numbers are called in sentences.
pub(super) trait Words {
    /// One of them.
    fn entry(&self, place: Cell) -> String;
    /// Some of them: `∂ur1/∂θa1..3`.
    fn region(&self, places: &BTreeSet<Cell>) -> String;
    /// The symbols, in a sentence, of the triads of the first and the second node.
    fn triads(&self) -> [&'static str; 2];
    /// What a cause means.
    fn meaning(&self, cause: Cause) -> &'static str {
        cause.meaning()
    }
    /// Whether any of the places is a rotation of the first, and of the second node.
    fn rotations(&self, places: &BTreeSet<Cell>) -> [bool; 2];
}

/// Numbers at one state, and mistakes that may explain them.
pub(super) struct AtState {
    data: Cells<Datum>,
    /// The largest error of a number.
    error: f64,
    hypotheses: Vec<Hypothesis>,
    /// How many more were tried, and were not met.
    tried: usize,
}

/// Numbers at states at which some are wrong, and mistakes that may explain them.
pub(super) struct Matching<'a> {
    pub(super) states: Vec<AtState>,
    /// Cells that one constant may put off, as those of a row: by a factor.
    pub(super) regions: Vec<Vec<Cell>>,
    /// Whether a constant may be added to each cell, too.
    pub(super) has_offsets: bool,
    /// Whether a number may stop at a bound: derivatives are the same constant at many states.
    pub(super) has_bounds: bool,
    /// What was seen of all states, right ones too.
    pub(super) seen: Option<&'a Seen>,
    pub(super) words: &'a dyn Words,
}

/// Chance may not do it more often than once in so many.
const CHANCE: f64 = 1000.0;

/// How much wider tolerances are tried for numbers that have lost digits.
const LOST: [f64; 4] = [1.0, 1e2, 1e4, 1e6];

/// What a mistake leaves of the errors that it explains: more than this part is no explanation, for what loses digits comes near to many
/// things.
const LEFT: f64 = 1e-2;

/// Changes that are smaller than this part of the largest error need not be seen.
const SEEN: f64 = 1e-3;

/// Single entries without structure that are named one by one.
const SINGLE: usize = 2;

/// The share of the states at which a cause must explain all that is wrong, to be preferred to one that explains entries one by one.
const NEARLY_ALL: f64 = 0.8;

/// Where no more than one of so many states is wrong, that is told.
const RARE: usize = 20;

/// The share of the states at which a cause must explain something.
const RARELY: f64 = 0.4;

/// What numbers equal, where the cause leaves it open.
type Relation = Option<String>;

/// Whether it was searched for, the cause, and what numbers equal.
type Key = (bool, Cause, Relation);

/// What a cause explains at a state.
#[derive(Default)]
struct Explains {
    /// What it explains, and the bits that each is worth.
    entries: Wrongs,
    region: BTreeSet<Cell>,
    times: usize,
}

/// What a cause explains at each state, by the place of the state.
type ByState = BTreeMap<usize, Explains>;

/// Wrong entries of a state, with the bits that each is worth.
type Wrongs = Cells<f64>;

impl AtState {
    /// Numbers, each with what was given, what is wanted, its tolerance and its class; and the mistakes that may explain them, of which so many more
    /// were tried. Added is what every number can suffer by itself: that it is missing, that it has the wrong sign.
    pub(super) fn new(
        given: impl IntoIterator<Item = (Cell, (Option<f64>, f64, f64, Class))>,
        hypotheses: Vec<Hypothesis>,
        tried: usize,
    ) -> Self {
        let mut largest: BTreeMap<Class, f64> = BTreeMap::new();
        let mut state = Self { data: Cells::default(), error: 0.0, hypotheses, tried };
        let given: Vec<_> = given.into_iter().collect();
        for (_, (.., tolerance, class)) in &given {
            let most = largest.entry(*class).or_default();
            *most = most.max(*tolerance);
        }
        for (place, (got, want, tolerance, class)) in given {
            state.error = state.error.max(got.map_or(0.0, |got| (got - want).abs()));
            if want != 0.0 {
                state.hypotheses.push(Hypothesis::one(Cause::Dropped, place, 0.0));
                state.hypotheses.push(Hypothesis::one(Cause::Sign, place, -want));
            }
            let of_class = largest.get(&class).copied().unwrap_or_default();
            state.data.insert(place, Datum { got, want, tolerance, of_class });
        }
        state
    }

    fn wrong(&self, wider: f64) -> Wrongs {
        let of = |(place, datum): (Cell, &Datum)| {
            let error = (datum.got? - datum.want).abs();
            let tolerance = wider * datum.tolerance;
            let bits = (error / tolerance).log2().clamp(0.0, f64::from(f64::MANTISSA_DIGITS));
            (error.is_nan() || error > tolerance).then_some((place, bits))
        };
        self.data.iter().filter_map(of).collect()
    }

    /// Where numbers are those that a hypothesis makes: what of them was wrong, with the bits that each is worth.
    fn explained(
        &self,
        (changes, cause): (&[(usize, usize, f64)], Cause),
        wider: f64,
        wrong: &Wrongs,
    ) -> Option<Wrongs> {
        let mut sizes = [0.0_f64; 2];
        let mut worst = [0.0_f64; 2];
        for (k, i, x) in changes {
            let datum = self.data.get((*k, *i))?;
            let got = datum.got?;
            let off = |from: f64| if got == from { 0.0 } else { (got - from).abs() };
            sizes = [sizes[0].max(x.abs()), sizes[1].max(datum.want.abs())];
            worst = [worst[0].max(off(datum.want)), worst[1].max(off(*x))];
            // No error here is larger.
            if worst[1] > LEFT * self.error {
                return None;
            }
        }
        let [error, left] = worst;
        if !(error > 0.0 && left <= LEFT * error) {
            return None;
        }
        // What is given has the rounding of the right numbers once more, for it is compared with rounded ones; and what is multiplied, that of the
        // product.
        let grown = if sizes[1] > 0.0 { (sizes[0] / sizes[1]).clamp(1.0, 1e6) } else { 1.0 };
        let mut explained = Wrongs::default();
        for (k, i, x) in changes {
            let datum = self.data.get((*k, *i))?;
            let got = datum.got?;
            let allowed = 2.0 * wider * cause.gain().max(grown) * datum.of_class;
            // Wide tolerances confirm nothing: what a mistake changes visibly must be seen to have changed.
            let change = (x - datum.want).abs();
            let is_seen = change <= SEEN * error || (got - x).abs() <= change / 2.0;
            if got != *x && !((got - x).abs() <= allowed && is_seen) {
                return None;
            }
            if let Some(bits) = wrong.get((*k, *i)) {
                // Of what is so much wider than the tolerance chance meets more.
                let met = (allowed / (2.0 * wider * datum.tolerance)).log2().max(0.0);
                explained.insert((*k, *i), if met.is_finite() { (bits - met).max(0.0) } else { 0.0 });
            }
        }
        Some(explained)
    }
}

impl Matching<'_> {
    /// Why numbers are wrong; `None` where none is.
    pub(super) fn diagnosis(&self) -> Option<Diagnosis> {
        let first = self.explain(LOST[0])?;
        if first.unexplained == 0 {
            return Some(first);
        }
        let wider = LOST[1..].iter().filter_map(|wider| self.explain(*wider));
        let whole = wider.into_iter().find(|found| found.is_whole());
        Some(whole.unwrap_or(first))
    }

    /// The mistakes that explain what is wrong, with tolerances `wider` times as wide; `None` where nothing is wrong.
    fn explain(&self, wider: f64) -> Option<Diagnosis> {
        let mut wrong: Vec<Wrongs> = self.states.iter().map(|state| state.wrong(wider)).collect();
        if wrong.iter().all(Wrongs::is_empty) {
            return None;
        }
        let all = wrong.iter().map(Wrongs::len).max().unwrap_or(0);
        let mut found: BTreeMap<Key, ByState> = BTreeMap::new();
        for (n, state) in self.states.iter().enumerate() {
            let touches = |hypothesis: &&Hypothesis| {
                hypothesis.changes.iter().any(|(k, i, _)| wrong[n].contains((*k, *i)))
            };
            let mut touching: Vec<&Hypothesis> = state.hypotheses.iter().filter(touches).collect();
            // What changes least comes first: another that explains no more adds nothing.
            touching.sort_by_key(|hypothesis| hypothesis.changes.len());
            for Hypothesis { cause, changes, relation, is_searched } in touching {
                let Some(of) = state.explained((changes, *cause), wider, &wrong[n]) else {
                    continue;
                };
                let explains =
                    found.entry((*is_searched, *cause, relation.clone())).or_default().entry(n).or_default();
                if of.cells().all(|place| explains.entries.contains(place)) {
                    continue;
                }
                explains.times += 1;
                explains.entries.extend(of.iter().map(|(place, bits)| (place, *bits)));
                explains.region.extend(changes.iter().map(|(k, i, _)| (*k, *i)));
            }
        }
        self.add_constants(wider, &wrong, &mut found);
        let most = self.states.iter().map(|state| state.hypotheses.len() + state.tried).max().unwrap_or(0);
        let enough = (CHANCE * (most + self.regions.len()).max(1) as f64).log2();
        let mut diagnosis = Diagnosis::default();
        while let Some(explained) = self.best(&found, &mut wrong, enough) {
            diagnosis.causes.push(explained);
        }
        // What stands out of tolerances that were widened is the largest of the digits lost.
        if wider <= LOST[0] {
            diagnosis.causes.extend(self.singles(&mut wrong));
        }
        diagnosis.unexplained = wrong.iter().map(Wrongs::len).max().unwrap_or(0);
        // That some entries of several states are zero, say, explains nothing where others are wrong besides.
        if self.states.len() > 1
            && diagnosis.unexplained > 0
            && diagnosis.causes.iter().all(|one| one.cause.is_of_an_entry())
        {
            diagnosis.causes.clear();
            diagnosis.unexplained = all;
        }
        Some(diagnosis)
    }

    /// Adds what one number makes of others, the same at every state, which one entry tells and the others confirm.
    fn add_constants(&self, wider: f64, wrong: &[Wrongs], found: &mut BTreeMap<Key, ByState>) {
        let singles: BTreeSet<Cell> = wrong.iter().flat_map(Wrongs::cells).collect();
        let of_cells = singles.into_iter().map(|place| (vec![place], true));
        let regions = self.regions.iter().map(|region| (region.clone(), false)).chain(of_cells);
        for (region, is_entry) in regions {
            let least = if is_entry { 1 } else { 2 };
            let wrongs = self.wrongs(&region, wrong);
            if wrongs.len() < least {
                continue;
            }
            let mut constants = self.constants(region.len(), is_entry, &wrongs);
            if let (Some(place), true) = (region.first(), is_entry && self.has_bounds) {
                constants.extend(smooth_constants(&wrongs));
                constants.extend(self.bounds(*place, wrong).map(limited));
            }
            for Constant { cause, relation, make } in constants {
                let mut by_state = ByState::new();
                for (n, wrong) in wrong.iter().enumerate() {
                    let data = &self.states[n].data;
                    if !region.iter().any(|place| wrong.contains(*place)) {
                        continue;
                    }
                    let told = region.iter().filter_map(|place| Some((place, data.get(*place)?)));
                    let whole = told.clone().all(|(_, datum)| datum.got.is_some_and(f64::is_finite));
                    let changes: Vec<_> = told.map(|((k, i), datum)| (*k, *i, make(datum.want))).collect();
                    let of = self.states[n].explained((&changes, cause), wider, wrong);
                    if let Some(entries) = of.filter(|_| whole) {
                        let region = region.iter().copied().collect();
                        by_state.insert(n, Explains { entries, region, times: 1 });
                    }
                }
                if by_state.values().map(|explains| explains.entries.len()).sum::<usize>() < least {
                    continue;
                }
                let all = found.entry((false, cause, Some(relation))).or_default();
                for (n, explains) in by_state {
                    let known = all.entry(n).or_default();
                    known.entries.extend(explains.entries.iter().map(|(place, bits)| (place, *bits)));
                    known.region.extend(explains.region);
                    known.times += 1;
                }
            }
        }
    }

    /// The wrong numbers of a region, at whatever state.
    fn wrongs(&self, region: &[Cell], wrong: &[Wrongs]) -> Vec<Off> {
        let of = |(state, wrong): (&AtState, &Wrongs)| {
            let data = region.iter().filter(|place| wrong.contains(**place)).filter_map(|place| {
                let Datum { got, want, tolerance, .. } = state.data.get(*place)?;
                let got = got.filter(|got| got.is_finite())?;
                Some(Off { got, want: *want, tolerance: *tolerance })
            });
            data.collect::<Vec<_>>()
        };
        self.states.iter().zip(wrong).flat_map(of).collect()
    }

    /// A factor and an offset.
    fn constants(&self, size: usize, is_entry: bool, wrongs: &[Off]) -> Vec<Constant> {
        let mut found = Vec::new();
        let digits = |off: &Off| off.want.abs() / off.tolerance;
        let clear = wrongs.iter().filter(|off| off.want != 0.0 && digits(off).is_finite());
        let best = clear.max_by(|x, y| digits(x).total_cmp(&digits(y)));
        // What must be zero has no factor. Nothing, and the opposite, are causes of their own; and what is off in the last digits is off by no
        // constant.
        let factor = best.map_or(f64::NAN, |best| best.got / best.want);
        if factor.is_finite() && factor.abs() > 1e-12 && (factor.abs() - 1.0).abs() > 1e-12 {
            let cause = if is_entry { Cause::Scaled } else { Cause::Factor };
            let relation = format!("{} × expected", factor_in_words(factor));
            found.push(Constant::new(cause, relation, move |want| factor * want));
        }
        let is_offset = size == 1 && if is_entry { best.is_none() } else { self.has_offsets };
        let sharpest = wrongs.iter().min_by(|x, y| x.tolerance.total_cmp(&y.tolerance));
        if let Some(offset) = sharpest.map(|off| off.got - off.want).filter(|_| is_offset) {
            let relation = format!("what is expected {} {}", sign_of(offset), short(offset.abs(), 6));
            found.push(Constant::new(Cause::Offset, relation, move |want| want + offset));
        }
        found
    }

    /// The bounds at which a number stops, the lower and the upper one. On each side all that is wrong is one number, nearer to zero than what
    /// is expected, whatever that is; and nothing is right beyond it. Zero is a bound where the other side is right: else nothing was computed.
    fn bounds(&self, place: Cell, wrong: &[Wrongs]) -> Option<[Option<f64>; 2]> {
        /// At so many states one bound is no chance; nor zero.
        const SEVERAL: [usize; 2] = [2, 6];
        #[derive(Default)]
        struct Side {
            bound: Option<f64>,
            /// How many are wrong, and from what size to what.
            wrong: usize,
            expected: Option<[f64; 2]>,
            /// How many are right, and up to what size.
            right: usize,
            largest: f64,
        }
        let right = |is_above| self.seen.map_or((0, 0.0), |seen| seen.right(place.0, is_above));
        let mut sides = [false, true].map(|is_above| {
            let (right, largest) = right(is_above);
            Side { right, largest, ..Side::default() }
        });
        for (state, wrong) in self.states.iter().zip(wrong) {
            let Some((datum, got)) = state.data.get(place).and_then(|datum| Some((datum, datum.got?))) else {
                continue;
            };
            let (side, size) = (&mut sides[usize::from(datum.want > 0.0)], datum.want.abs());
            if !wrong.contains(place) {
                side.right += usize::from(size > datum.tolerance);
                side.largest = side.largest.max(size - datum.tolerance);
                continue;
            }
            let is_between = got.abs() < size && (got == 0.0 || (got > 0.0) == (datum.want > 0.0));
            if !is_between || side.bound.replace(got).is_some_and(|known| known != got) {
                return None;
            }
            side.wrong += 1;
            let [least, most] = side.expected.unwrap_or([size; 2]);
            side.expected = Some([least.min(size), most.max(size)]);
        }
        let of = |side: usize| {
            let Side { bound: Some(bound), expected: Some([least, most]), largest, .. } = sides[side] else {
                return Some(());
            };
            // What varies by rounding alone does not vary.
            let varies = most - least > NOTHING * most;
            let is_bound = bound != 0.0 || sides[1 - side].right >= SEVERAL[0];
            (varies && is_bound && largest <= bound.abs()).then_some(())
        };
        of(0)?;
        of(1)?;
        let is_zero = sides.iter().any(|side| side.bound == Some(0.0));
        let count = sides.iter().map(|side| side.wrong).sum::<usize>();
        (count >= SEVERAL[usize::from(is_zero)]).then(|| sides.map(|side| side.bound))
    }

    /// The mistake that explains most of what is wrong, which is then explained.
    fn best(&self, found: &BTreeMap<Key, ByState>, wrong: &mut [Wrongs], enough: f64) -> Option<Explained> {
        struct Rank<'a> {
            is_searched: bool,
            cause: Cause,
            relation: &'a Relation,
            by_state: &'a ByState,
            bits: f64,
            /// At how many states it explains something, and all.
            states: [usize; 2],
            times: usize,
        }
        let open = wrong.iter().filter(|wrong| !wrong.is_empty()).count();
        let rank = |cause: Cause, by_state: &ByState| {
            let (mut bits, mut states, mut times, mut most) = (0.0, [0; 2], 0, 0.0_f64);
            for (n, explains) in by_state {
                let left = explains.entries.iter().filter(|(place, _)| wrong[*n].contains(*place));
                let of: Vec<f64> = left.map(|(_, bits)| *bits).collect();
                if of.is_empty() {
                    continue;
                }
                most = of.iter().copied().fold(most, f64::max);
                bits += of.iter().sum::<f64>();
                states[0] += 1;
                states[1] += usize::from(of.len() == wrong[*n].len());
                times = times.max(explains.times);
            }
            // What a constant is, one entry told.
            if cause.is_constant() {
                bits -= most;
            }
            (bits, states, times)
        };
        let mut ranks: Vec<Rank<'_>> = Vec::new();
        for ((is_searched, cause, relation), by_state) in found {
            let (is_searched, cause) = (*is_searched, *cause);
            let (bits, states, times) = rank(cause, by_state);
            // A constant is none that holds at a few of many states; and what stands at a has its opposite at b.
            let is_constant = cause.is_constant();
            let least = if is_constant { NEARLY_ALL } else { RARELY };
            if bits >= enough && (self.states.len() == 1 || states[0] as f64 >= least * open as f64) {
                ranks.push(Rank { is_searched, cause, relation, by_state, bits, states, times });
            }
        }
        let most = ranks.iter().map(|rank| rank.bits).fold(0.0, f64::max);
        let margin = CHANCE.log2();
        let is_as_good = |rank: &&Rank<'_>| {
            rank.bits > most - margin
                || !rank.cause.says_little() && rank.states[1] as f64 >= NEARLY_ALL * open as f64
        };
        let mut contenders: Vec<&Rank<'_>> = ranks.iter().filter(is_as_good).collect();
        contenders.sort_by(|x, y| {
            let order = |rank: &Rank<'_>| {
                (
                    rank.cause.is_of_an_entry(),
                    rank.cause.says_little(),
                    std::cmp::Reverse(rank.states[1]),
                    rank.is_searched,
                    rank.times,
                    rank.cause,
                    // Of formulas that were searched for, the shortest.
                    rank.relation.as_ref().map_or(0, String::len),
                )
            };
            order(x).cmp(&order(y))
        });
        let chosen = *contenders.first()?;
        let cause = chosen.cause;
        let as_much = contenders.iter().skip(1).filter(|rank| rank.bits > chosen.bits - margin);
        let mut also: Vec<Code> =
            as_much.map(|rank| rank.cause.code()).filter(|code| *code != cause.code()).collect();
        also.dedup();
        let (mut entries, mut region) = (BTreeSet::new(), BTreeSet::new());
        for (n, explains) in chosen.by_state {
            if explains.entries.cells().any(|place| wrong[*n].contains(place)) {
                entries.extend(explains.entries.cells());
                region.extend(explains.region.iter().copied());
            }
        }
        let shown = if cause.is_of_an_entry() { &entries } else { &region };
        let place = match shown.first() {
            Some(only) if shown.len() == 1 => self.words.entry(*only),
            _ => self.words.region(shown),
        };
        for (n, explains) in chosen.by_state {
            wrong[*n].without(&explains.entries);
        }
        let mut relation = chosen.relation.clone().unwrap_or_else(|| self.relation(cause, &region));
        let mut at = self.at(chosen.states[0], open);
        // What is right elsewhere, and not zero there, is not zero throughout.
        let whole = |(k, _): &Cell| self.seen.map_or(0, |seen| seen.whole(*k));
        let elsewhere = region.iter().map(whole).min().filter(|_| cause == Cause::ComponentZero).unwrap_or(0);
        if elsewhere > 0 {
            relation = "zero".into();
            at = format!("{}, and right at {elsewhere}", Self::at_states(chosen.states[0], open));
        }
        // A formula that was searched for says all but that it is another.
        let meaning = match cause {
            Cause::OtherLength if chosen.is_searched => "another length",
            Cause::OtherParameters if chosen.is_searched => "another number of the rotation",
            _ if elsewhere > 0 => "not computed there",
            _ => self.words.meaning(cause),
        };
        let sentence = equation(&place, &relation, meaning, &at);
        Some(Explained { cause, code: cause.code(), sentence, also })
    }

    /// At how many of the wrong states, in words, where there is more than one; and that hardly any state is wrong.
    pub(super) fn at(&self, states: usize, open: usize) -> String {
        let of_wrong = if self.states.len() > 1 { Self::at_states(states, open) } else { String::new() };
        let rare = self.seen.filter(|seen| match seen.wrong() {
            0 => false,
            1 => seen.states() > 1,
            wrong => RARE * wrong <= seen.states(),
        });
        let told = rare.map(|seen| {
            format!("; nothing is wrong at {} of {} states", seen.states() - seen.wrong(), seen.states())
        });
        of_wrong + &told.unwrap_or_default()
    }

    /// At so many of the states, in words.
    pub(super) fn at_states(states: usize, open: usize) -> String {
        format!(", at {states} of {open} {}", if open == 1 { "state" } else { "states" })
    }

    /// What the numbers equal, with the triads in question.
    fn relation(&self, cause: Cause, region: &BTreeSet<Cell>) -> String {
        let [a, b] = self.words.triads();
        match (cause, self.words.rotations(region)) {
            (Cause::RotationTakenAsLocal, [true, true]) => format!("{a}ᵀ and {b}ᵀ × expected"),
            (Cause::RotationTurnedTwice, [true, true]) => format!("{a} and {b} × expected"),
            (Cause::RotationTakenAsLocal | Cause::RotationTurnedTwice, [is_of_a, _]) => {
                cause.relation().replace('R', if is_of_a { a } else { b })
            }
            _ => cause.relation().to_string(),
        }
    }

    /// Entries that are wrong by themselves: at one state a few, at several none that must not be zero at each, for there no factor is
    /// constant.
    fn singles(&self, wrong: &mut [Wrongs]) -> Vec<Explained> {
        let open: Vec<usize> = (0..wrong.len()).filter(|n| !wrong[*n].is_empty()).collect();
        let Some(first) = open.first() else { return Vec::new() };
        if open.iter().any(|n| wrong[*n].len() > SINGLE) {
            return Vec::new();
        }
        let is_told = |n: &usize| {
            let mut of_state = wrong[*n].cells().map(|place| self.single(*n, place));
            of_state.any(|found| found.cause != Cause::Spurious)
        };
        if open.len() > 1 && open.iter().any(is_told) {
            return Vec::new();
        }
        let places: Vec<Cell> = wrong[*first].cells().collect();
        let mut found: Vec<Explained> = places.into_iter().map(|place| self.single(*first, place)).collect();
        let at = self.at(open.len(), open.len());
        found.iter_mut().for_each(|found| found.sentence += &at);
        wrong.iter_mut().for_each(Wrongs::clear);
        found
    }

    /// An entry that is wrong by itself, at a state.
    fn single(&self, n: usize, place: Cell) -> Explained {
        let name = self.words.entry(place);
        let datum = self.states[n].data.get(place);
        let of = |f: fn(&Datum) -> Option<f64>| datum.and_then(f).unwrap_or(f64::NAN);
        let (got, want) = (of(|datum| datum.got), of(|datum| Some(datum.want)));
        // What is left of a cancellation has no relative error of its own.
        let is_nothing =
            datum.is_some_and(|datum| datum.want.abs() <= datum.tolerance * (NOTHING / (C * U)).max(1.0));
        let is_zero = datum.is_some_and(|datum| datum.want.abs() <= datum.tolerance);
        let cause = if is_nothing { Cause::Spurious } else { Cause::Scaled };
        let sentence = match cause {
            Cause::Spurious if is_zero => {
                format!("{name} equals {got}, and must be zero", got = short(got, 4))
            }
            Cause::Spurious => {
                format!(
                    "{name} equals {got}, and must be {want}, which is next to nothing",
                    got = short(got, 4),
                    want = short(want, 2)
                )
            }
            _ => format!("{name} equals {} × expected: {}", factor_in_words(got / want), cause.meaning()),
        };
        Explained { cause, code: cause.code(), sentence, also: Vec::new() }
    }
}

/// What numbers equal, and what that means.
pub(super) fn equation(place: &str, relation: &str, meaning: &str, at: &str) -> String {
    let equals = if place.contains(", ") { "equal" } else { "equals" };
    format!("{place} {equals} {relation}: {meaning}{at}")
}

/// A factor; what is next to ±1 by how much it is off.
fn factor_in_words(factor: f64) -> String {
    let off = factor.abs() - 1.0;
    let (sign, off_by) = (if off < 0.0 { '−' } else { '+' }, short(off.abs(), 3));
    match off.abs() < 1e-4 {
        true if factor < 0.0 => format!("−(1 {sign} {off_by})"),
        true => format!("(1 {sign} {off_by})"),
        false => short(factor, 6),
    }
}

/// A wrong number.
struct Off {
    got: f64,
    want: f64,
    tolerance: f64,
}

/// What one number makes of those that are expected.
struct Constant {
    cause: Cause,
    relation: String,
    make: Box<dyn Fn(f64) -> f64>,
}

impl Constant {
    fn new(cause: Cause, relation: String, make: impl Fn(f64) -> f64 + 'static) -> Self {
        Self { cause, relation, make: Box::new(make) }
    }
}

/// A regularised norm, and a term in the square: for numbers whose expected sizes differ, else any constant fits.
fn smooth_constants(wrongs: &[Off]) -> Vec<Constant> {
    const APART: f64 = 1.1;
    let sizes = wrongs.iter().map(|off| off.want.abs());
    let [least, most] = sizes.fold([f64::INFINITY, 0.0], |[least, most], x| [x.min(least), x.max(most)]);
    let seen = |off: &Off| (off.got - off.want).abs() / off.tolerance;
    let Some(Off { got, want, .. }) = wrongs.iter().max_by(|x, y| seen(x).total_cmp(&seen(y))) else {
        return Vec::new();
    };
    let (squares, times) = (got * got - want * want, (got - want) / (want * want));
    let mut found = Vec::new();
    if most > APART * least && squares > 0.0 {
        let relation = format!("√(x² + ε²) of what is expected, x, with ε = {}", short(squares.sqrt(), 3));
        let make = move |want: f64| (want * want + squares).sqrt().copysign(want);
        found.push(Constant::new(Cause::Regularised, relation, make));
    }
    if most > APART * least && times.is_finite() && times != 0.0 {
        let relation = format!("x {} {} x² of what is expected, x", sign_of(times), short(times.abs(), 3));
        found.push(Constant::new(Cause::Quadratic, relation, move |want| want + times * want * want));
    }
    found
}

/// Numbers that stop at bounds.
fn limited(bounds: [Option<f64>; 2]) -> Constant {
    let relation = format!("{}, {}", Cause::Limited.relation(), bounds_in_words(bounds));
    Constant::new(Cause::Limited, relation, move |want| {
        let bound = bounds[usize::from(want > 0.0)].filter(|bound| bound.abs() < want.abs());
        bound.unwrap_or(want)
    })
}

const fn sign_of(x: f64) -> char {
    if x < 0.0 { '−' } else { '+' }
}

/// A lower and an upper bound, of which one may lack: `±0.8`.
fn bounds_in_words(bounds: [Option<f64>; 2]) -> String {
    match bounds {
        [Some(lower), Some(upper)] if lower == -upper && upper > 0.0 => format!("±{}", short(upper, 6)),
        _ => {
            let sign = |bound: f64| if bound < 0.0 { "−" } else { "" };
            let each = bounds.into_iter().flatten();
            each.map(|bound| format!("{}{}", sign(bound), short(bound.abs(), 6)))
                .collect::<Vec<_>>()
                .join(" and ")
        }
    }
}

/// Columns in words, runs of one name with increasing numbers together: `θa1..3`, `xb2`.
pub(super) fn ranges(columns: &BTreeSet<usize>, name: &dyn Fn(usize) -> String) -> Vec<String> {
    let numbered = |name: &str| {
        let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
        Some((stem.to_string(), name.strip_prefix(stem)?.parse::<usize>().ok()?))
    };
    let mut found = Vec::new();
    let mut columns = columns.iter().copied().peekable();
    while let Some(first) = columns.next() {
        let start = name(first);
        let mut last = numbered(&start);
        let mut length = 1;
        while let (Some((stem, number)), Some(next)) = (&last, columns.peek()) {
            let next = numbered(&name(*next)).filter(|(other, n)| other == stem && *n == number + 1);
            if next.is_none() {
                break;
            }
            (last, length) = (next, length + 1);
            columns.next();
        }
        found.push(match last {
            Some((_, number)) if length > 1 => format!("{start}..{number}"),
            _ => start,
        });
    }
    found
}

#[cfg(test)]
mod tests {
    use super::{AtState, Cell, Matching, Words, bounds_in_words, ranges};
    use std::collections::BTreeSet;

    struct Plain;

    impl Words for Plain {
        fn entry(&self, _: Cell) -> String {
            "u1".into()
        }
        fn region(&self, _: &BTreeSet<Cell>) -> String {
            "u1".into()
        }
        fn triads(&self) -> [&'static str; 2] {
            ["A", "B"]
        }
        fn rotations(&self, _: &BTreeSet<Cell>) -> [bool; 2] {
            [false; 2]
        }
    }

    /// What is given where other numbers are expected, one state each: the bounds.
    fn bounds(numbers: &[(f64, f64)]) -> Option<String> {
        let state = |(got, want): &(f64, f64)| {
            AtState::new([((0, 0), (Some(*got), *want, 1e-14, (0, 0, 0)))], Vec::new(), 0)
        };
        let states: Vec<AtState> = numbers.iter().map(state).collect();
        let wrong: Vec<_> = states.iter().map(|state| state.wrong(1.0)).collect();
        let matching = Matching {
            states,
            regions: Vec::new(),
            has_offsets: false,
            has_bounds: true,
            seen: None,
            words: &Plain,
        };
        matching.bounds((0, 0), &wrong).map(bounds_in_words)
    }

    #[test]
    fn bounds_are_told_where_numbers_stop() {
        let of = |f: fn(f64) -> f64, wants: &[f64]| {
            bounds(&wants.iter().map(|want| (f(*want), *want)).collect::<Vec<_>>())
        };
        let both = [0.1, 0.9, -1.2, 2.0, -0.3, -0.5, 1.5, -0.7, 3.0];
        assert_eq!(of(|x| x.clamp(-0.4, 0.8), &both).unwrap(), "−0.4 and 0.8");
        assert_eq!(of(|x| x.clamp(-0.6, 0.6), &both).unwrap(), "±0.6");
        assert_eq!(of(|x| x.min(0.8), &both).unwrap(), "0.8");
        assert_eq!(of(|x| x.min(0.0), &[0.1, 0.2, 0.3, 0.4, 0.5, 0.6, -1.0, -2.0]).unwrap(), "0");
        // Never computed; one number for one number; bounded at some states only; not all of a side one number.
        assert_eq!(of(|_| 0.0, &[0.1, 0.2, 0.3, 0.4, 0.5, 0.6]), None);
        assert_eq!(of(|_| 0.0, &both), None);
        assert_eq!(of(|_| 0.5, &[1.0; 8]), None);
        assert_eq!(bounds(&[(0.8, 0.9), (0.8, 1.1), (1.2, 1.2)]), None);
        assert_eq!(bounds(&[(0.8, 0.9), (0.7, 1.1)]), None);
        assert_eq!(bounds(&[(0.8, 0.9), (0.8, 0.5)]), None);
    }

    #[test]
    fn runs_of_columns_are_named_together() {
        let names = ["xa1", "xa2", "xa3", "θa1", "Ψa", "xb1", "xb2"];
        let of = |columns: &[usize]| {
            ranges(&columns.iter().copied().collect(), &|j| names[j].to_string()).join(" ")
        };
        assert_eq!(of(&[0, 1, 2]), "xa1..3");
        assert_eq!(of(&[0, 2, 3, 4, 5, 6]), "xa1 xa3 θa1 Ψa xb1..2");
        assert_eq!(of(&[]), "");
    }
}
