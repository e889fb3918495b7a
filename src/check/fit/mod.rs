//! Which convention is it? Every convention under which all entries of given rows are right, found from the numbers alone.
//!
//! | module | question |
//! |---|---|
//! | `space` | which conventions are looked at, and how unusual is each? |
//! | `data` | what is right at the states, in every form that a convention may give it? |
//! | `search` | under which of them is every entry right, or are the fewest wrong? |
//! | `more` | what do second derivatives and nodal forces tell, where rows leave something open? |
//! | `words` | what does a convention say? |
//!
//! An entry is right within the bound of the audit (`pintle_audit::judge::bound`), never within a tolerance of its row. Where states
//! leave several conventions open, all of them are the answer, with a state that tells them apart.

mod data;
mod more;
mod search;
mod space;
#[cfg(test)]
mod tests;
mod words;

pub use search::GivenRows;

use crate::convention::{Axes, Convention, Forces, Positions, Turned};
use data::{Expected, Number};
use more::More;
use pintle_audit::{Candidate, Case, ConstraintCandidate, Domain, MpcCase, Settings};
use pintle_kinematics::connector::{Definition, State};
use pintle_kinematics::mpc::Constraint;
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3;
use search::{Fit, Fits, ODD_FACTOR, Search, Stored, index, is_value};
pub(crate) use space::columns_of;
use space::{Names, Reading};

/// How many conventions of a class are compared in search of a state that tells them apart.
const COMPARED: usize = 60;

/// A wrong entry under a convention.
#[derive(Clone, Debug, PartialEq)]
pub struct WrongEntry {
    /// Its name, with where the routine has it: `∂u2/∂b.ur3 (line 2, column 12)`.
    pub name: String,
    /// The component (0-based).
    pub component: usize,
    /// The column of pintle (0-based), or none of a value.
    pub column: Option<usize>,
    /// The first state at which it is wrong.
    pub state: usize,
    /// What the routine has there.
    pub got: f64,
    /// What that must be, in the routine's conventions.
    pub want: f64,
}

/// What the numbers say of conventions.
#[derive(Clone, Debug)]
pub struct Found {
    /// The simplest convention.
    pub convention: Convention,
    /// What it says on each question, where that is not pintle's own.
    pub departures: Vec<(&'static str, String)>,
    /// The questions that the states leave open, with every answer under which all entries are right.
    pub open: Vec<(&'static str, Vec<String>)>,
    /// How many conventions make every entry right; 0 where none does.
    pub count: usize,
    /// Whether there are more than were counted.
    pub is_cut: bool,
    /// The entries that are wrong under the simplest.
    pub wrong: Vec<WrongEntry>,
    fits: Vec<Fit>,
}

/// Finds the conventions under which given rows are right.
///
/// `states` are those at which `given` was computed, each reached from the initial one by less than half a turn.
///
/// # Errors
/// In words, where the lists are no rows of a connector.
pub fn fit(definition: &Definition, states: &[State<f64>], given: &[GivenRows]) -> Result<Found, String> {
    let length = length(definition);
    let expected = |reading, axes| Expected::of(definition, states, reading, axes, length);
    let more = More { definition, states, given, length };
    find(states.len(), &expected, (Names::of_connector(), Some(&more)), given)
}

/// The same of the rows of a multi-point constraint.
///
/// # Errors
/// In words, where the lists are no rows of a constraint.
pub fn fit_constraint(
    constraint: &Constraint<f64>,
    cases: &[MpcCase],
    given: &[GivenRows],
) -> Result<Found, String> {
    let expected = |reading, axes| Expected::of_constraint(cases, reading, axes);
    find(cases.len(), &expected, (Names::of_constraint(constraint.kind()), None), given)
}

/// What is right at the states, where orientations are read and vectors resolved in one way.
type Expecting<'a> = dyn Fn(Reading, Axes) -> Option<Expected> + 'a;

fn find(
    states: usize,
    expecting: &Expecting<'_>,
    (names, more): (Names, Option<&More<'_>>),
    given: &[GivenRows],
) -> Result<Found, String> {
    if states == 0 || states != given.len() {
        return Err(format!("{states} states, and rows of {}", given.len()));
    }
    let all = Stored::all(given, &names);
    if all.is_empty() {
        return Err(match names.hinges {
            0 => "the rows are no lists of 6, 7, 12 or 14 columns and at most six lines, of one shape at every state".into(),
            hinges => format!("the rows are no lists of {} or {} columns and at most seven lines, of one shape at every state", 12 + hinges, 14 + hinges),
        });
    }
    if all.iter().all(|stored| stored.lines.is_empty()) {
        return Err("every row is zero".into());
    }
    let mut known: Vec<(Reading, Axes, Expected)> = Vec::new();
    for reading in Reading::ALL {
        for axes in Axes::ALL {
            known.extend(expecting(reading, axes).map(|expected| (reading, axes, expected)));
        }
    }
    let mut search = Search { names, given, fits: Fits::default(), most: 0 };
    // What leaves few entries wrong is found at once; what leaves many is looked for where nothing else is found.
    for most in [2, 8, 30] {
        search.most = most;
        for (reading, axes, expected) in &known {
            for stored in all.iter().filter(|stored| !stored.lines.is_empty()) {
                search.add(stored, expected, *reading, *axes);
            }
        }
        if !search.fits.all.is_empty() {
            break;
        }
    }
    let mut fits = search.fits.clone();
    fits.settle();
    let mut seen: Vec<Convention> = Vec::new();
    if fits.all.len() < 2_000 {
        fits.all.retain(|fit| {
            let convention = fit.convention();
            let is_new = !seen.contains(&convention);
            seen.push(convention);
            is_new
        });
    }
    tell_more(&mut fits, more);
    let Some(best) = fits.all.first().cloned() else {
        return Err("under no convention are most entries right: these are other rows".into());
    };
    let expected = expecting(best.reading, best.axes).ok_or("the states leave no connector")?;
    let stored = all
        .iter()
        .find(|stored| {
            stored.storage == best.storage
                && stored.height == best.height
                && stored.width == best.order.places.len()
        })
        .ok_or("the rows have no shape")?;
    let best = with_odd_factors(&best, stored, &expected, &search);
    let right: Vec<Fit> = fits.all.iter().filter(|fit| fit.wrong == 0).cloned().collect();
    let plain = plain(&best);
    let mut departures: Vec<(&'static str, String)> =
        best.answers().into_iter().filter(|answer| !plain.contains(answer)).collect();
    let mut convention = best.convention();
    if let Some(side) = more.and_then(|more| more.side(&best)) {
        convention.forces = side;
        if side == Forces::Body {
            departures.push(("nodal forces", "those on the bodies, minus the residual side".into()));
        }
    }
    let mut open: Vec<(&'static str, Vec<String>)> = Vec::new();
    if right.len() > 1 {
        for fit in &right {
            for (question, answer) in fit.answers() {
                match open.iter_mut().find(|(known, _)| *known == question) {
                    Some((_, answers)) if answers.contains(&answer) => {}
                    Some((_, answers)) => answers.push(answer),
                    None => open.push((question, vec![answer])),
                }
            }
        }
        open.retain(|(_, answers)| answers.len() > 1);
    }
    let wrong = wrong_entries(&best, stored, &expected, given);
    Ok(Found {
        convention,
        departures,
        open,
        count: right.len(),
        is_cut: fits.is_cut,
        wrong,
        fits: if right.is_empty() { vec![best] } else { right },
    })
}

/// Settings that draw so many states, away from singular sets.
fn drawing(seed: &str, states: usize) -> Settings {
    let seed = seed.to_string();
    Settings { states, seed, near_singular_states: 0, atlas: false, ..Settings::default() }
}

/// General states of a connector: both nodes turned, where they turn, and clear of singular sets.
pub fn generic_states(definition: &Definition, seed: &str, count: usize, domain: &Domain) -> Vec<State<f64>> {
    const DRAWN: usize = 12;
    const CLEAR: f64 = 0.1;
    let settings = drawing(seed, DRAWN * (count + 1));
    let candidate = Candidate::new("general states", definition).settings(settings);
    let drawn = candidate.within(domain.clone()).drawn();
    let is_general = |case: &&Case| {
        let turned = case.last().map(|step| Turned::of(definition, &step.state));
        let turns = |end: usize| definition.moves[end] && definition.rotates[end];
        let is_turned = |turned: [Turned; 2]| {
            (0..2).all(|end| !turns(end) || (0.3..2.8).contains(&norm(turned[end].vector)))
        };
        turned.is_some_and(is_turned) && case.is_clear(0.0, CLEAR)
    };
    // Special values tell little, and every fourth state is far from the initial one.
    let mut clear: Vec<&Case> = drawn.iter().filter(is_general).collect();
    if clear.is_empty() {
        clear = drawn.iter().skip(1).collect();
    }
    let least = |case: &&Case| case.last().map_or(0.0, |step| step.state.pair.b.displacement[0].abs());
    clear.retain(|case| !definition.moves[1] || least(case) > 0.0);
    clear.iter().filter_map(|case| case.last()).map(|step| step.state).take(count).collect()
}

/// General states of a constraint: both nodes turned, the constraint violated, and clear of singular sets.
pub fn generic_cases(constraint: &Constraint<f64>, seed: &str, count: usize) -> Vec<MpcCase> {
    const DRAWN: usize = 16;
    let settings = drawing(seed, DRAWN * (count + 1));
    let drawn = ConstraintCandidate::new("general states", constraint).settings(settings).drawn();
    let is_general = |(n, case): &(usize, MpcCase)| {
        let bodies = [&case.state.slave, &case.state.master];
        let is_turned = bodies.iter().all(|body| (0.3..2.8).contains(&norm(so3::log(&body.rotation))));
        // Those at which the constraint holds tell less, and every sixth has right angles.
        n % 2 == 1 && n % 6 != 5 && is_turned
    };
    drawn.into_iter().enumerate().filter(is_general).map(|(_, case)| case).take(count).collect()
}

/// The connector's length.
fn length(definition: &Definition) -> f64 {
    let length = norm(definition.initial.reference);
    if length > 0.0 { length } else { 1.0 }
}

/// Leaves those of the conventions under which all rows are right that second derivatives allow.
fn tell_more(fits: &mut Fits, more: Option<&More<'_>>) {
    /// Of more than so many, rows tell next to nothing.
    const MOST: usize = 200;
    let right = fits.all.iter().filter(|fit| fit.wrong == 0).count();
    let Some(more) =
        more.filter(|more| (2..=MOST).contains(&right) && more.given.iter().any(|of| of.second.is_some()))
    else {
        return;
    };
    let left: Vec<Fit> =
        fits.all.iter().filter(|fit| fit.wrong > 0 || more.bends(fit) != Some(false)).cloned().collect();
    if left.iter().any(|fit| fit.wrong == 0) {
        fits.all = left;
    }
}

/// What pintle's own conventions say on the questions of a fit.
fn plain(best: &Fit) -> Vec<(&'static str, String)> {
    let mut own = best.clone();
    own.reading = Reading::Right;
    own.axes = Axes::A;
    own.storage = crate::convention::Storage::Rows;
    own.frame = crate::convention::Frame::Global;
    own.variations = [crate::convention::Variation::Spatial; 2];
    own.positions = Positions::Displacement;
    own.units = space::Units {
        row_length: 1.0,
        row_angle: crate::convention::Angle::Radian,
        column_length: 1.0,
        column_angle: crate::convention::Angle::Radian,
    };
    own.order.places.sort_unstable();
    own.lines.sort_by_key(|of| of.is.k);
    for (n, of) in own.lines.iter_mut().enumerate() {
        (of.factor, of.is.is_as_angle, of.line) = (1.0, false, n);
    }
    own.answers()
}

/// A line of which most is wrong, and right with another factor.
fn with_odd_factors(best: &Fit, stored: &Stored, expected: &Expected, search: &Search<'_>) -> Fit {
    let mut changed = best.clone();
    for n in 0..best.lines.len() {
        let of = best.lines[n];
        let entries = || {
            best.order.places.iter().enumerate().flat_map(move |(column, place)| {
                expected.at.iter().enumerate().map(move |(state, right)| {
                    let number = best.entry(&right[of.of], *place);
                    (number, best.factor(&of, *place), stored.get(state, of.line, column), column)
                })
            })
        };
        let mut columns: Vec<usize> = entries()
            .filter(|(number, factor, got, _)| !number.is(*got, *factor))
            .map(|entry| entry.3)
            .collect();
        columns.dedup();
        columns.sort_unstable();
        columns.dedup();
        if columns.len() < 2 {
            continue;
        }
        let largest = entries()
            .filter(|(number, ..)| !number.tells_nothing())
            .max_by(|one, other| (one.0.x * one.1).abs().total_cmp(&(other.0.x * other.1).abs()));
        let Some((number, factor, got, _)) = largest else { continue };
        let odd = got / (factor * number.x);
        let odd = if (odd - odd.round()).abs() <= 1e-9 * odd.abs() { odd.round() } else { odd };
        let is = |(number, factor, got, _): (Number, f64, f64, usize)| {
            // The factor itself is known to some roundings.
            let number = Number { off: number.off + 8.0 * f64::EPSILON * number.x.abs(), ..number };
            number.is(got, factor * odd)
        };
        if odd != 0.0 && odd.is_finite() && entries().all(is) {
            changed.lines[n].factor *= odd;
            changed.wrong -= columns.len().min(changed.wrong);
            changed.cost += ODD_FACTOR;
        }
    }
    if changed.total() < best.total() {
        let n = index(&Positions::ALL, changed.positions);
        let values = |fit: &Fit| search.wrong_values(fit, expected, n);
        changed.wrong = (changed.wrong + values(&changed)).saturating_sub(values(best));
        return changed;
    }
    best.clone()
}

/// What is wrong under a fit.
fn wrong_entries(fit: &Fit, stored: &Stored, expected: &Expected, given: &[GivenRows]) -> Vec<WrongEntry> {
    let mut found = Vec::new();
    let mut add = |entry: WrongEntry| {
        let is_known = |known: &WrongEntry| {
            (known.component, known.column, &known.name) == (entry.component, entry.column, &entry.name)
        };
        if !found.iter().any(is_known) {
            found.push(entry);
        }
    };
    for (state, right) in expected.at.iter().enumerate() {
        for of in &fit.lines {
            let k = of.is.k;
            for (column, place) in fit.order.places.iter().enumerate() {
                let (number, factor) = (fit.entry(&right[of.of], *place), fit.factor(of, *place));
                let number = if of.factor.abs() == 1.0 {
                    number
                } else {
                    Number { off: number.off + 8.0 * f64::EPSILON * number.x.abs(), ..number }
                };
                let got = stored.get(state, of.line, column);
                if !number.is(got, factor) {
                    let name = format!(
                        "∂{}/∂{} (line {}, column {})",
                        fit.names.rows[k],
                        fit.names.columns[*place],
                        of.line + 1,
                        column + 1
                    );
                    let want = factor * number.x;
                    add(WrongEntry { name, component: k, column: Some(*place), state, got, want });
                }
            }
            let factor = of.factor * fit.units.of_value(of.is.unit);
            let line = |all: &Option<Vec<Option<f64>>>| all.as_ref()?.get(of.line).copied().flatten();
            let right = &right[of.of];
            let value = (line(&given[state].values), right.values[index(&Positions::ALL, fit.positions)]);
            if let (Some(got), Some(number)) = value
                && !is_value(&number, got, factor, of.is.unit)
            {
                let name = format!("{} (line {})", fit.names.rows[k], of.line + 1);
                add(WrongEntry { name, component: k, column: None, state, got, want: factor * number.x });
            }
            if let (Some(got), Some(number)) = (line(&given[state].rates), right.rate)
                && !number.is(got, factor)
            {
                let name = format!("d{}/dt (line {})", fit.names.rows[k], of.line + 1);
                add(WrongEntry { name, component: k, column: None, state, got, want: factor * number.x });
            }
        }
    }
    found
}

impl Found {
    /// The convention in one sentence.
    pub fn sentence(&self) -> String {
        if self.departures.is_empty() {
            return "The conventions are pintle's own.".to_string();
        }
        let parts: Vec<String> =
            self.departures.iter().map(|(question, answer)| format!("{question}: {answer}")).collect();
        format!("{}.", parts.join("; "))
    }

    /// Whether a convention of the class is this one: under both, every state gives the same numbers in the same places.
    pub fn holds(&self, convention: &Convention) -> bool {
        self.fits.iter().any(|fit| fit.convention() == *convention)
    }

    /// How many groups a state tells the conventions of the class apart into: 1 where it tells nothing.
    pub fn told_apart(&self, definition: &Definition, state: &State<f64>) -> usize {
        let length = length(definition);
        self.groups(&|reading, axes| Expected::of(definition, &[*state], reading, axes, length))
    }

    fn groups(&self, expecting: &Expecting<'_>) -> usize {
        let mut groups: Vec<Vec<Number>> = Vec::new();
        let mut known: Vec<(Reading, Axes, Option<Expected>)> = Vec::new();
        for fit in spread(&self.fits) {
            if !known.iter().any(|(reading, axes, _)| (*reading, *axes) == (fit.reading, fit.axes)) {
                known.push((fit.reading, fit.axes, expecting(fit.reading, fit.axes)));
            }
            let of = known.iter().find(|(reading, axes, _)| (*reading, *axes) == (fit.reading, fit.axes));
            let Some((_, _, Some(expected))) = of else { continue };
            let numbers = predicted(fit, expected);
            let is_same = |other: &Vec<Number>| {
                other.len() == numbers.len()
                    && other.iter().zip(&numbers).all(|(one, other)| {
                        (one.x - other.x).abs() <= one.off + other.off + 1e-12 * one.x.abs()
                    })
            };
            if !groups.iter().any(is_same) {
                groups.push(numbers);
            }
        }
        groups.len()
    }

    /// The state of some that tells most conventions of the class apart; none where there is one convention, or nothing tells.
    pub fn separating(&self, definition: &Definition, states: &[State<f64>]) -> Option<usize> {
        self.best(states.iter().map(|state| self.told_apart(definition, state)))
    }

    /// The same of states of a constraint.
    pub fn separating_case(&self, cases: &[MpcCase]) -> Option<usize> {
        let expecting = |case: &MpcCase, reading, axes| {
            Expected::of_constraint(std::slice::from_ref(case), reading, axes)
        };
        self.best(cases.iter().map(|case| self.groups(&|reading, axes| expecting(case, reading, axes))))
    }

    fn best(&self, told: impl Iterator<Item = usize>) -> Option<usize> {
        if self.fits.len() < 2 {
            return None;
        }
        let best = told.enumerate().max_by(|one, other| one.1.cmp(&other.1).then(other.0.cmp(&one.0)))?;
        (best.1 > 1).then_some(best.0)
    }
}

/// Some of a class, over all of it.
fn spread(fits: &[Fit]) -> impl Iterator<Item = &Fit> {
    fits.iter().step_by((fits.len() / COMPARED).max(1))
}

/// Everything that a fit says of one state, where the routine has it.
fn predicted(fit: &Fit, expected: &Expected) -> Vec<Number> {
    let mut numbers = Vec::new();
    let mut lines = fit.lines.clone();
    lines.sort_by_key(|of| of.line);
    for right in &expected.at {
        for of in &lines {
            let scaled =
                |number: Number, factor: f64| Number { x: number.x * factor, off: number.off * factor.abs() };
            let flat = fit
                .order
                .places
                .iter()
                .map(|place| scaled(fit.entry(&right[of.of], *place), fit.factor(of, *place)));
            numbers.extend(flat);
            let factor = of.factor * fit.units.of_value(of.is.unit);
            let value = right[of.of].values[index(&Positions::ALL, fit.positions)].unwrap_or_default();
            numbers.push(scaled(value, factor));
        }
        if fit.storage == crate::convention::Storage::Columns {
            numbers.push(Number { x: f64::INFINITY, off: 0.0 });
        }
    }
    numbers
}
