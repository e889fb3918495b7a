//! Somebody else's routine: a function from a state to values and a Jacobian, checked like the product's own.
//!
//! ```
//! use pintle_audit::Candidate;
//! use pintle_kinematics::catalog::ConnectionType;
//! use pintle_kinematics::connector::Definition;
//! use pintle_kinematics::node::{Node, Pair};
//! use pintle_kinematics::vector::identity;
//!
//! let node = Node { displacement: [0.0; 3], triad: identity(), flow: 0.0 };
//! let axial = Definition::new(ConnectionType::named("AXIAL", None)?, Pair { reference: [2.0, 0.0, 0.0], a: node, b: node });
//!
//! // u1 = |d| − |d₀|, and its row: −q on x_a, q on x_b.
//! let report = Candidate::new("my AXIAL", &axial).check(|state| {
//!     let d = state.pair.separation();
//!     let length = d.iter().map(|x| x * x).sum::<f64>().sqrt();
//!     let mut row = [0.0; 14];
//!     for i in 0..3 {
//!         row[i] = -d[i] / length;
//!         row[7 + i] = d[i] / length;
//!     }
//!     ([Some(length - 2.0), None, None, None, None, None], [Some(row), None, None, None, None, None])
//! });
//! assert_eq!(report.mismatches(), 0); // in a test: `report.assert_ok()`, of the trait `AssertOk`
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod constraint;
mod domain;
mod element;
mod friction;
mod given;
mod right;
mod sheet;
mod simplest;
mod tables;

pub use constraint::ConstraintCandidate;
pub use domain::Domain;
pub use friction::FrictionCandidate;
pub use given::{Given, Question, Tangent};
pub use right::Right;

use crate::case::quantity::{Entries, Quantity};
use crate::case::{Case, Step, moved};
use crate::engine::checks_of;
use crate::judge::bound::OF_OTHERS;
use crate::judge::components::{Surroundings, judge};
use crate::judge::examined::{Examined, Trusted};
use crate::judge::outcome::{Against, Check, Expected, OVERFLOW, Report, Subject};
use crate::judge::table::ResultTable;
use crate::judge::verdict::{Score, Verdict};
use crate::model::{Finding, ModelReport};
use crate::oracles::certificate::certificate;
use crate::oracles::force::product_at;
use crate::oracles::oracle::{Answer, Narrow, Oracle, WideAnswers, central_differences};
use crate::oracles::referee::Referee;
use crate::oracles::truth::Truth;
use crate::sampling::coverage::{Coverage, Lack};
use crate::sampling::{SPECIAL, about_initial_by, along_initial, beside_half_turn, special_initial};
use crate::settings::Settings;
use crate::share::spread;
use crate::singular::near::{has_sites, near_initial};
use pintle_kinematics::connector::{Components, Connector, Definition, State};
use pintle_kinematics::draw::Draw;
use pintle_kinematics::measure::Unit;
use pintle_kinematics::node::{DOFS, dof_size};
use pintle_kinematics::scalar::elementary::norm;
use pintle_scene::{Diagnostic, Span};
use std::cell::LazyCell;
use std::collections::BTreeSet;
use std::convert::Infallible;
use std::f64::consts::TAU;

/// A routine to be checked against one connector.
#[derive(Clone, Debug)]
pub struct Candidate<'a> {
    name: &'a str,
    definition: &'a Definition,
    settings: Settings,
    histories: usize,
    is_principal: bool,
    offers: Vec<Quantity>,
    components: [bool; 6],
    springs: [Option<f64>; 6],
    tangent: Tangent,
    at: Option<&'a [Case]>,
    domain: Domain,
}

/// How many states are asked for at once.
pub(in crate::candidate) const AT_ONCE: usize = 32;

/// How far the ends of every other history are from half a turn of an angle (rad): their number and that of three angles have no divisor.
const BESIDE_HALF_TURNS: [f64; 10] = [3e-3, -1e-4, 1e-6, -3e-3, 1e-2, -1e-8, 1e-5, -8e-3, 1e-3, -1e-6];

/// Of how many states wrong tables are kept, to say why they are.
pub(in crate::candidate) const KEPT: usize = 16;

/// So many times as far as usual nodes move at some states.
pub(in crate::candidate) const FARTHEST: f64 = 50.0;

/// By how much nodes move farther than usual, or less far, at a state. Every fifth goes through orders of magnitude. These fall on any
/// place of a cycle of four.
pub(in crate::candidate) fn reach(i: usize, farthest: f64) -> f64 {
    if i % 5 == 2 { [farthest, 1e-2, farthest.sqrt(), 1e-4][(i / 5 + i / 20) % 4] } else { 1.0 }
}

/// A table that is wrong, and against whom.
type WrongTable = (Against, ResultTable);

/// A state that is asked for.
struct Asked {
    number: usize,
    case: Case,
    values_before: Components<f64>,
}

impl<'a> Candidate<'a> {
    /// A routine of that name, for this connector; 200 states, 30 of them on 237 bits. States near singular sets are for routines that
    /// follow into them: [`Settings::near_singular_states`] asks for them.
    pub fn new(name: &'a str, definition: &'a Definition) -> Self {
        let settings = Settings { states: 200, near_singular_states: 0, atlas: false, ..Settings::default() };
        Self {
            name,
            definition,
            settings,
            histories: 0,
            is_principal: false,
            offers: vec![Quantity::Value, Quantity::FirstDerivatives],
            components: [true; 6],
            springs: [None; 6],
            tangent: Tangent::default(),
            at: None,
            domain: Domain::default(),
        }
    }

    /// Draws within a domain. The initial state is asked for where it lies there; differences reach a little beyond.
    #[must_use]
    pub fn within(mut self, domain: Domain) -> Self {
        self.domain = domain;
        self
    }

    /// Another number of states, oracles or seed.
    #[must_use]
    pub fn settings(mut self, settings: Settings) -> Self {
        self.settings = settings;
        self
    }

    /// What the routine gives, of which components; values and rows of all without this. What it does not offer is not judged.
    #[must_use]
    pub fn offers(mut self, quantities: &[Quantity], components: [bool; 6]) -> Self {
        let all = Quantity::ALL.into_iter().chain([Quantity::ElementForces, Quantity::ElementStiffness]);
        self.offers = all.filter(|quantity| quantities.contains(quantity)).collect();
        self.components = components;
        self
    }

    /// So many of the states end a history of small increments, through half a turn and whole ones: for routines that go on from the
    /// values before. Without it each state follows the initial one.
    #[must_use]
    pub const fn histories(mut self, count: usize) -> Self {
        self.histories = count;
        self
    }

    /// Angles are principal, from −π to π: whole turns between them and the continued ones are no error.
    #[must_use]
    pub const fn principal_angles(mut self, is_principal: bool) -> Self {
        self.is_principal = is_principal;
        self
    }

    /// The stiffness of each component of an element of springs: energy over the square of the component's unit, E = ½ Σ D_k c_k².
    /// [`Quantity::ElementForces`] and [`Quantity::ElementStiffness`] are judged by them.
    #[must_use]
    pub const fn springs(mut self, springs: [Option<f64>; 6], tangent: Tangent) -> Self {
        (self.springs, self.tangent) = (springs, tangent);
        self
    }

    /// The states at which the routine is asked, in place of drawn ones: of the same connector.
    #[must_use]
    pub const fn at(mut self, cases: &'a [Case]) -> Self {
        (self.settings.states, self.settings.near_singular_states) = (cases.len(), 0);
        self.at = Some(cases);
        self
    }

    /// Which region of configuration space the states exercise at which the routine is checked.
    pub fn coverage(&self) -> Coverage {
        let mut coverage = Coverage::default();
        for case in self.drawn() {
            if let Some(step) = case.last() {
                coverage.add(self.definition, &step.state, case.length);
            }
        }
        coverage
    }

    /// The states at which the routine is asked, each with the path that leads there: the initial one, motions about it, and special
    /// values, as right angles. One motion in five is far larger or smaller than usual.
    pub fn drawn(&self) -> Vec<Case> {
        self.cases().into_iter().map(|(_, case)| case).collect()
    }

    /// One history of so many small increments, through half a turn and whole ones. `None` where an end of the connector does not turn,
    /// or does not turn within the domain.
    pub fn history(&self, states: usize) -> Option<Case> {
        let mut draw =
            Draw::new(&format!("{} {} history", self.settings.seed, self.definition.connection.name));
        let case = along_initial(self.definition, self.length(), self.name, Some(states), &mut draw)?;
        self.domain.brought(case, false)
    }

    fn length(&self) -> f64 {
        let length = norm(self.definition.initial.reference);
        if length > 0.0 { length } else { 1.0 }
    }

    /// By how much nodes move farther than usual, or less far, at a state, within the reach of the domain.
    fn reach(&self, i: usize) -> f64 {
        // Places are drawn up to 0.4 lengths apart.
        let domain = self.domain.reach().map_or(0.0, |reach| 5.0 * reach / self.length());
        reach(i, domain.max(FARTHEST))
    }

    /// How many states lie near singular sets.
    fn near_singular_states(&self) -> usize {
        if has_sites(self.definition) { self.settings.near_singular_states } else { 0 }
    }

    /// How many of the drawn states cannot be brought into the domain, or stay where they are drawn, outside of it.
    pub fn left_out(&self) -> usize {
        if self.at.is_some() || self.domain.is_everything() {
            return 0;
        }
        self.drawn_anywhere().filter(|(_, case)| case.is_none()).count()
    }

    /// The states, with their places.
    fn cases(&self) -> Vec<(usize, Case)> {
        match self.at {
            Some(cases) => cases.iter().cloned().enumerate().collect(),
            None => self.drawn_anywhere().filter_map(|(place, case)| Some((place, case?))).collect(),
        }
    }

    /// Drawn states, with their places: those about the initial one, then those near singular sets; `None` for what the domain leaves out.
    fn drawn_anywhere(&self) -> impl Iterator<Item = (usize, Option<Case>)> {
        let mut draw = Draw::new(&format!("{} {}", self.settings.seed, self.definition.connection.name));
        let mut near = Draw::new(&format!("{} {} near", self.settings.seed, self.definition.connection.name));
        let length = self.length();
        let regular = self.settings.states;
        let of_history = spread(regular, self.histories.min(regular));
        // A sixth of the states has special values, from the second on.
        let special: Vec<usize> =
            spread(regular, SPECIAL.min(regular / 6)).into_iter().map(|i| i + 1).collect();
        (0..regular + self.near_singular_states()).filter_map(move |i| {
            let name = format!("{} state {i}", self.name);
            // The first is the initial state.
            let case = if i >= regular {
                near_initial(self.definition, length, &name, &mut near)
            } else if let Some(n) = of_history.iter().position(|of| i > 0 && *of == i) {
                let case = along_initial(self.definition, length, &name, None, &mut draw);
                let landed = |case: &Case| {
                    let distance = *BESIDE_HALF_TURNS.get(n / 2 % BESIDE_HALF_TURNS.len())?;
                    beside_half_turn(case, n / 2, distance).filter(|_| n % 2 == 1)
                };
                case.map(|case| landed(&case).unwrap_or(case))
            } else if let Some(n) = special.iter().position(|of_special| *of_special == i) {
                special_initial(self.definition, n, length, &name, &mut draw)
            } else {
                None
            };
            let case = match case {
                None if i < regular => {
                    let mut about = |times: f64| {
                        about_initial_by(self.definition, i, (length, times), name.clone(), &mut draw)
                    };
                    // Where the initial state is on a singular set, small motions do not leave it.
                    about(self.reach(i)).or_else(|| about(1.0))
                }
                drawn => drawn,
            };
            // Near singular sets is where they are.
            Some((i, self.domain.brought(case?, i >= regular)))
        })
    }

    /// Draws states and checks what the routine gives there. The states are about the initial one, and 1e-1 to 1e-12 from the
    /// singular sets of this connector, as many as [`Settings::near_singular_states`] says. Those near a set need nodes that can be
    /// brought there, and a connector without history.
    ///
    /// The checks are:
    /// - values against the connector's formulas on 237 bits;
    /// - the Jacobian against differences on 237 bits, and against differences of the routine's own values: the two tell a wrong
    ///   derivative from another formula;
    /// - at the states not chosen for differences, the Jacobian against the connector's dual numbers.
    ///
    /// Dual numbers prove nothing by themselves. A derivative that they call wrong is put before differences on 237 bits, where
    /// these were asked for. Without an oracle on 237 bits among those asked, formula and derivative are undecided. The row of a
    /// one-form is the derivative of no value. It is compared with those differences and dual numbers alone, and its value where
    /// one is given. What the routine gives of a component that the connector has not is wrong, as what it lacks of one is. Where
    /// the states leave out a region of configuration space, a finding of the report says so.
    ///
    /// A FLOW-CONVERTER, dur3 = e3a·(dθ_a − dθ_b) − β_s dΨ_b, by its row alone:
    ///
    /// ```
    /// # use pintle_audit::Candidate;
    /// # use pintle_kinematics::catalog::ConnectionType;
    /// # use pintle_kinematics::connector::Definition;
    /// # use pintle_kinematics::node::{Node, Pair};
    /// # use pintle_kinematics::vector::identity;
    /// let node = Node { displacement: [0.0; 3], triad: identity(), flow: 0.0 };
    /// let pair = Pair { reference: [1.0, 0.0, 0.0], a: node, b: node };
    /// let converter = ConnectionType::named("FLOW-CONVERTER", None)?;
    /// let converter = Definition { flow_scale: 0.4, ..Definition::new(converter, pair) };
    /// let report = Candidate::new("my FLOW-CONVERTER", &converter).check(|state| {
    ///     let mut row = [0.0; 14];
    ///     for i in 0..3 {
    ///         row[3 + i] = state.pair.a.triad[i][2];
    ///         row[10 + i] = -state.pair.a.triad[i][2];
    ///     }
    ///     row[13] = -0.4;
    ///     let mut rows = [None; 6];
    ///     rows[5] = Some(row);
    ///     ([None; 6], rows)
    /// });
    /// assert_eq!(report.mismatches(), 0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn check<G: Into<Given>>(&self, routine: impl Fn(&State<f64>) -> G) -> Report {
        let answers = |asked: &[Question<'_>]| {
            let answers = asked.iter().map(|asked| Some(routine(asked.state()).into()));
            Ok::<_, Infallible>(answers.collect())
        };
        let Ok(report) = self.try_check(answers);
        report
    }

    /// The same of a routine that is asked for several states at once, that may fail, and that gives nothing at a state which it does not
    /// cover. It gives one answer for each question, in their order; questions without an answer count as not covered.
    ///
    /// # Errors
    /// The first of the routine.
    pub fn try_check<E>(
        &self,
        routine: impl FnMut(&[Question<'_>]) -> Result<Vec<Option<Given>>, E>,
    ) -> Result<Report, E> {
        Ok(self.try_check_on_sheets(routine)?.0)
    }

    /// The same, with the number of states at which it continued angles on another sheet: they are not judged.
    ///
    /// # Errors
    /// The first of the routine.
    pub fn try_check_on_sheets<E>(
        &self,
        mut routine: impl FnMut(&[Question<'_>]) -> Result<Vec<Option<Given>>, E>,
    ) -> Result<(Report, usize), E> {
        let mut elsewhere = 0;
        let mut found: Vec<Check> = Vec::new();
        let mut of_element = Vec::new();
        let mut coverage = Coverage::default();
        let near = self.near_singular_states();
        let near_wide = if near > 0 { self.settings.wide_states / 4 } else { 0 };
        let mut wide = spread(self.settings.states, self.settings.wide_states - near_wide);
        wide.extend(spread(near, near_wide).into_iter().map(|i| self.settings.states + i));
        let all: Vec<Asked> =
            self.cases().into_iter().map(|(number, case)| Asked::new(number, case)).collect();
        let cases = all.len();
        for asked in all.chunks(AT_ONCE) {
            let questions: Vec<Question<'_>> =
                asked.iter().filter_map(|asked| asked.question(&self.offers)).collect();
            let mut answers = routine(&questions)?.into_iter();
            for asked in asked {
                if let Some(step) = asked.case.last() {
                    coverage.add(self.definition, &step.state, asked.case.length);
                }
                let Some(given) = answers.next().flatten() else { continue };
                let is_wide = wide.contains(&asked.number);
                let judged =
                    self.judge_on_sheet((asked, given), &self.offers, &mut routine, is_wide, &mut of_element);
                match judged? {
                    Some(checks) => checks_of(&mut found, checks),
                    None => elsewhere += 1,
                }
            }
        }
        element::explain(&mut found, &of_element);
        without_differences_of_wrong_values(&mut found);
        let connection = &self.definition.connection;
        let connector = Connector::<f64>::new(self.definition);
        let is_one_form = |k: &usize| connector.differentiated(*k).map(|measure| measure.is_one_form());
        // What a one-form sums up is no function of the state: its formula is that of its row.
        let offers = |quantity| self.offers.contains(&quantity);
        let is_judged_by_row = !offers(Quantity::Value) || (0..6).any(|k| is_one_form(&k) == Some(true));
        let has_values = (0..6).any(|k| is_one_form(&k) == Some(false));
        let is_expected =
            |of: &Quantity| Quantity::ALL.contains(of) && (*of != Quantity::Value || has_values);
        let expected: Vec<Quantity> = self.offers.iter().copied().filter(is_expected).collect();
        let expected = Expected::numbers(&expected);
        let mut subject =
            Subject::new(self.name.to_string(), certificate(connection), cases as u64, found, &expected);
        // A candidate's formula is judged state by state, by a witness that shares no elementary function with it or with us.
        let is_witness = |against| matches!(against, Against::Oracle(oracle) if oracle.is_independent());
        let is_formula = |check: &&Check| match check.quantity {
            Some(Quantity::Value) => true,
            Some(Quantity::FirstDerivatives) => is_judged_by_row,
            Some(Quantity::ElementForces) => true,
            Some(Quantity::ElementStiffness) => !offers(Quantity::ElementForces),
            _ => false,
        };
        let compared = || subject.checks.iter().filter(|check| check.compared > 0);
        let formulas = [
            Quantity::Value,
            Quantity::FirstDerivatives,
            Quantity::ElementForces,
            Quantity::ElementStiffness,
        ];
        let verdict = match formulas.into_iter().any(offers) {
            true => {
                let values = compared().filter(is_formula).filter(|check| is_witness(check.against));
                values.map(|check| check.verdict).max()
            }
            // Of one that offers none of these the formula is that of what it offers.
            false => compared().map(|check| check.verdict).max(),
        };
        subject.formula = verdict.unwrap_or(Verdict::Undecided);
        let report = Report {
            version: pintle_kinematics::VERSION,
            settings: self.settings.clone(),
            constant: crate::C * OF_OTHERS,
            subjects: vec![subject],
            sampled: Vec::new(),
            atlas: Vec::new(),
            models: self.lacks(coverage).into_iter().collect(),
        };
        Ok((report, elsewhere))
    }

    /// What the states leave out, if anything.
    fn lacks(&self, coverage: Coverage) -> Option<ModelReport> {
        let gaps = coverage.gaps();
        if gaps.is_empty() {
            return None;
        }
        // What states drawn everywhere have is missing by the domain alone.
        let everywhere = || self.clone().within(Domain::default()).coverage().gaps();
        let open = if self.domain.is_everything() { None } else { Some(everywhere()) };
        let is_by_domain =
            |lack: &Lack| open.as_ref().is_some_and(|all| all.iter().all(|one| one.code != lack.code));
        let domain = format!("the domain {}", self.domain);
        let finding = |lack: Lack| {
            let (reason, remedy) = match (self.at, is_by_domain(&lack)) {
                (Some(_), _) => ("the states given", lack.remedy),
                (None, true) => (
                    domain.as_str(),
                    "nothing, if the domain leaves it out on purpose; a wider one has such states",
                ),
                (None, false) => ("the states drawn about the initial one", lack.remedy),
            };
            let found = Diagnostic::finding(lack.code, Span::default(), lack.message, reason);
            Finding::from(found.help(remedy).in_file(self.name))
        };
        Some(ModelReport {
            scene: self.name.to_string(),
            states: usize::try_from(coverage.exercise.samples).unwrap_or(usize::MAX),
            assembly: None,
            later_steps: Vec::new(),
            coverage,
            drawn: self.at.is_none(),
            nearest: None,
            findings: gaps.into_iter().map(finding).collect(),
        })
    }

    /// What was asked of what was given, principal angles on the sheet of the right ones.
    fn read(&self, given: Given, wants: &[Quantity], asked: &Asked) -> Given {
        let mut given = given.only(wants, [true; 6]);
        given.without_ground(self.definition.moves);
        if self.is_principal {
            given.continue_angles(&asked.case);
        }
        given
    }

    /// Quantities that the routine gives at a state, judged; `None` where it continues angles on another sheet.
    fn judge_on_sheet<E>(
        &self,
        (asked, given): (&Asked, Given),
        quantities: &[Quantity],
        routine: &mut impl FnMut(&[Question<'_>]) -> Result<Vec<Option<Given>>, E>,
        is_wide: bool,
        of_element: &mut Vec<WrongTable>,
    ) -> Result<Option<Vec<Check>>, E> {
        let given = self.read(given, &self.offers, asked);
        // Principal angles may be far from those before.
        let before = (!self.is_principal).then_some(&asked.values_before);
        if sheet::is_another(&asked.case, &given, before) {
            return Ok(None);
        }
        let (given, quantities) = match sheet::mostly_another(&asked.case, &given, before) {
            Some(values) => (values, &[Quantity::Value][..]),
            None => (given.only(quantities, [true; 6]), quantities),
        };
        self.judge((asked, &given), quantities, routine, is_wide, of_element).map(Some)
    }

    fn judge<E>(
        &self,
        (asked, given): (&Asked, &Given),
        quantities: &[Quantity],
        routine: &mut impl FnMut(&[Question<'_>]) -> Result<Vec<Option<Given>>, E>,
        wide: bool,
        of_element: &mut Vec<WrongTable>,
    ) -> Result<Vec<Check>, E> {
        let mut checks = Vec::new();
        let Asked { case, number, values_before } = asked;
        let Given(numbers, element) = given;
        let Some(end) = case.at_end() else { return Ok(checks) };
        let (step, narrow, truth) = (end.step, Narrow::at(&end), Truth::at(&end));
        let asks = |oracle: Oracle| self.settings.oracles.contains(&oracle);
        let offers = |quantity: Quantity| quantities.contains(&quantity);
        let nearness = truth.nearness();
        // On a singular set only the wide differences tell its two sides.
        let answers = (wide || nearness == 0.0).then(|| {
            let has_forces = offers(Quantity::NodalForces) || offers(Quantity::GeometricStiffness);
            if has_forces { WideAnswers::of(&truth) } else { WideAnswers::of_kinematics(&truth) }
        });
        let of_components = truth.nearness_of_components();
        let trusted = match &answers {
            Some(answers) => Trusted::Wide(answers.trusted(&of_components.map(|near| near > 0.0))),
            None => Trusted::Others(product_at(&end)),
        };
        let examined = Examined::new(&end, numbers, trusted, &of_components);
        let (examined, sides) = examined.on_sets(Some(&truth));
        let examined = examined.of_others();
        let (bound, units) = (&examined.bound, &examined.units);
        let connection = &self.definition.connection.name;
        let is_one_form = std::array::from_fn::<bool, 6, _>(|k| {
            end.connector.differentiated(k).is_some_and(|measure| measure.is_one_form())
        });
        let referee = Referee::new(&end, &self.settings, Some(&truth));
        let around = Surroundings::of(case, &truth, bound, sides.as_ref());
        let mut compare = |quantity: Quantity, answer: &Answer| {
            // Mutants of the routine's numbers, at the states on 237 bits.
            let mut check = examined.check(quantity, answer, &around, (Some(&referee), wide));
            let may_lack = |k: usize| !self.components[k] || quantity == Quantity::Value && is_one_form[k];
            examined.add_missing(&mut check, quantity, answer, may_lack);
            let misplaced = numbers.entries(quantity).iter().find(|(k, ..)| units[*k].is_none());
            if let Some((k, i, x)) = misplaced {
                let name = quantity.entry_name(k, i);
                let told = format!("{name} is given, and {connection} has no such component");
                check.misplaced(told, x, case);
            }
            checks.push(check);
        };
        let values = |k: usize| numbers.entries(Quantity::Value).get(k, 0);
        let is_due = |k: usize| self.components[k] && units[k].is_some();
        let has_value = |k: usize| values(k).is_some() || is_due(k) && !is_one_form[k];
        // The same numbers by dual numbers, where differences are not asked for.
        let others: LazyCell<_, _> = LazyCell::new(|| truth.dual());
        for quantity in quantities.iter().copied().filter(|of| Quantity::ALL.contains(of)) {
            if !asks(Oracle::WideDifferences) {
                if quantity == Quantity::FirstDerivatives && asks(Oracle::NodalDual) && nearness > 0.0 {
                    compare(quantity, &narrow.nodal_dual(bound));
                }
                continue;
            }
            match (&answers, quantity) {
                (_, Quantity::Value) => {
                    if (0..6).any(has_value) {
                        compare(quantity, &Answer::sharp(Oracle::WideDifferences, &truth.value()));
                    }
                }
                (Some(answers), _) => {
                    let answer = answers.answer(Oracle::WideDifferences, quantity);
                    if let Some(answer) = answer.filter(|answer| !answer.numbers.is_empty()) {
                        let error = match quantity {
                            Quantity::FirstDerivatives => Entries::default(),
                            _ => truth.own_error(quantity, bound),
                        };
                        compare(quantity, &Answer { error, ..answer });
                    }
                }
                (None, Quantity::FirstDerivatives) => {
                    if asks(Oracle::NodalDual) && nearness > 0.0 {
                        compare(quantity, &narrow.nodal_dual(bound));
                    }
                }
                (None, _) => {
                    let of = others.entries(quantity);
                    if asks(Oracle::WideDual) && !of.is_empty() {
                        compare(quantity, &Answer::sharp(Oracle::WideDual, of));
                    }
                }
            }
        }
        let bears = |k: usize| self.springs[k].is_none() || examined.is_smooth[k];
        if (0..6).all(bears) {
            let right = answers.as_ref().map(|answers| &answers.differences);
            let by = if right.is_some() { Oracle::WideDifferences } else { Oracle::WideDual };
            let right = right.unwrap_or_else(|| &others);
            let first = case.at_rest().positions();
            for table in element::tables(element, (&self.springs, self.tangent), right, &first, bound) {
                let mut check = table.check_against(by, wide, &case.name, Some(case));
                // It is told when every state was seen.
                if check.diagnosis.take().is_some() {
                    of_element.push((check.against, table));
                }
                checks.push(check);
            }
            for (quantity, is_given) in [
                (Quantity::ElementForces, element.forces.is_some()),
                (Quantity::ElementStiffness, element.stiffness.is_some()),
            ] {
                if offers(quantity) && !is_given {
                    let mut check = Check::new(Some(quantity), Against::Oracle(by));
                    check.misplaced(format!("{} is missing", quantity.name()), f64::NAN, case);
                    checks.push(check);
                }
            }
        }
        // A component on its singular set has no step for differences of its values, and a one-form no value.
        let near = of_components.into_iter().filter(|near| *near > 0.0).fold(1.0, f64::min);
        let rows = numbers.entries(Quantity::FirstDerivatives);
        // Values that are wrong are no witness against a row that is right.
        let agrees = |k: usize, quantity: Quantity, answer: &Answer| {
            let mut one = Entries::default();
            one.0[k] = numbers.entries(quantity).0[k].clone();
            !judge(quantity, &one, answer, &around).verdict.is_mismatch()
        };
        let right_values = LazyCell::new(|| Answer::sharp(Oracle::WideDifferences, &truth.value()));
        let right_rows = LazyCell::new(|| narrow.nodal_dual(bound));
        let is_witness = |k: usize| {
            agrees(k, Quantity::Value, &right_values) || !agrees(k, Quantity::FirstDerivatives, &right_rows)
        };
        let is_differenced: [bool; 6] = std::array::from_fn(|k| {
            offers(Quantity::FirstDerivatives)
                && values(k).is_some()
                && rows.0[k].is_some()
                && examined.is_smooth[k]
                && !is_one_form[k]
                && is_witness(k)
        });
        if !is_differenced.contains(&true) {
            return Ok(checks);
        }
        let before = case.path.iter().rev().nth(1).map_or(self.definition.initial, |step| step.state.pair);
        let (_, path) = case.path.split_last().unwrap_or((step, &[]));
        let wants = &[Quantity::Value];
        let own = central_differences(
            |all: &[[f64; DOFS]]| {
                let beside = |by: &[f64; DOFS]| {
                    let moved = Step::between(&before, moved(&step.state.pair, by));
                    Step { state: State { pair: moved.state.pair, ..step.state }, ..moved }
                };
                let beside: Vec<Step> = all.iter().map(beside).collect();
                let questions = beside.iter().map(|step| Question {
                    number: *number,
                    step,
                    path,
                    values_before: *values_before,
                    wants,
                    is_drawn: false,
                });
                let answers = routine(&questions.collect::<Vec<_>>())?;
                let values_of = |given: Option<Given>| {
                    let given = given.map(|given| self.read(given, wants, asked)).unwrap_or_default();
                    let value = |k: usize| {
                        let x = given.0.entries(Quantity::Value).get(k, 0)?;
                        // Beside half a turn an angle may go on on its other side: no derivative of it is a jump.
                        let winds = end.connector.differentiated(k).is_some_and(|measure| measure.winds());
                        let turns = values(k).filter(|_| winds).map_or(0.0, |at| ((at - x) / TAU).round());
                        Some(x + TAU * turns)
                    };
                    std::array::from_fn(value)
                };
                Ok(answers.into_iter().map(values_of).collect())
            },
            is_differenced,
            &|j| dof_size(j, case.length) * near,
            narrow.active(),
            bound,
        )?;
        let mut check = Check::new(Some(Quantity::FirstDerivatives), Against::Own);
        let around = Surroundings { sides: None, ..around };
        let judgement = judge(Quantity::FirstDerivatives, rows, &own, &around);
        let proves = wide && !judgement.verdict.is_mismatch();
        let score = if proves { examined.score(Quantity::FirstDerivatives, &own) } else { Score::default() };
        check.add(judgement, score, case);
        checks.push(check);
        Ok(checks)
    }
}

/// Rows that are right are not judged by values that are wrong.
fn without_differences_of_wrong_values(found: &mut Vec<Check>) {
    let is_wrong = |quantity: Quantity| {
        let of = |check: &Check| check.quantity == Some(quantity) && check.against != Against::Own;
        found.iter().any(|check| of(check) && check.verdict.is_mismatch())
    };
    if is_wrong(Quantity::Value) && !is_wrong(Quantity::FirstDerivatives) {
        found.retain(|check| check.against != Against::Own);
    }
}

impl Asked {
    /// With what is right at the state before its end.
    fn new(number: usize, case: Case) -> Self {
        let values_before = crate::case::values_before(&case);
        Self { number, case, values_before }
    }

    fn question<'a>(&'a self, wants: &'a [Quantity]) -> Option<Question<'a>> {
        let (step, path) = self.case.path.split_last()?;
        let Self { number, values_before, .. } = *self;
        Some(Question { number, step, path, values_before, wants, is_drawn: true })
    }
}

impl Given {
    /// Angles by whole turns to those that are nearest to the right ones. Components of a rotation vector do not turn each by itself.
    fn continue_angles(&mut self, case: &Case) {
        let connector = case.connector();
        let right = case.values();
        for (k, value) in self.0.entries_mut(Quantity::Value).0.iter_mut().enumerate() {
            let is_angle = connector
                .differentiated(k)
                .is_some_and(|measure| measure.unit() == Unit::Angle && !sheet::is_of_vector(&measure));
            if let (Some(value), Some(right), true) =
                (value.as_mut().and_then(|x| x.first_mut()), right[k], is_angle)
            {
                *value += TAU * ((right - *value) / TAU).round();
            }
        }
    }
}

impl Report {
    /// What was not decided of the numbers of each subject, and how to get a decision.
    pub fn open_claims(&self) -> Vec<String> {
        // An independent oracle answered, and nothing could be decided.
        let is_beyond_range = |check: &Check| {
            matches!(check.against, Against::Oracle(oracle) if oracle.is_independent())
                && check.undecided.contains_key(OVERFLOW)
        };
        let mut found = Vec::new();
        for subject in &self.subjects {
            let mut tell = |claim: &str, why: String| {
                found.push(format!("\nundecided: the {claim} of {}: {why}\n", subject.title()));
            };
            if subject.derivative == Verdict::Undecided {
                let lacking = subject.lacking_a_witness();
                let reasons = subject.checks.iter().filter(|check| check.claim() == Verdict::Undecided);
                let reasons: BTreeSet<&str> =
                    reasons.flat_map(|check| check.undecided.keys().map(String::as_str)).collect();
                tell(
                    "derivative",
                    if !lacking.is_empty() && subject.checks.iter().any(is_beyond_range) {
                        OVERFLOW.to_string()
                    } else if !lacking.is_empty() {
                        format!(
                            "no independent oracle judged its {}; put wide-differences among Settings::oracles, and let \
                             Settings::wide_states be 1 or more",
                            lacking.join(", ")
                        )
                    } else {
                        Vec::from_iter(reasons).join("; ")
                    },
                );
            }
            if subject.formula == Verdict::Undecided {
                let of_routine = "no independent oracle judged its values, or had a finite tolerance; a routine's are judged by wide-differences: put \
                     them among Settings::oracles. A connector's rest on certificates, and what they do not cover is judged by tests of your own";
                tell("formula", of_routine.to_string());
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::Step;
    use crate::oracles::referee::OVERRULED;
    use pintle_kinematics::catalog::ConnectionType;
    use pintle_kinematics::node::{Node, Pair};
    use pintle_kinematics::so3::exp;
    use pintle_kinematics::vector::{Matrix, Vector, column, identity};
    use std::f64::consts::TAU;

    /// Q = AᵀB, by the columns of both. The third of b is made orthogonal to its first two, and these to each other, half of what they
    /// lack each: Newton's step towards the nearest rotation, twice.
    fn relative(pair: &Pair<f64>) -> Matrix<f64> {
        let dot = |v: Vector<f64>, w: Vector<f64>| v[0] * w[0] + v[1] * w[1] + v[2] * w[2];
        let mut b = [0, 1, 2].map(|j| column(&pair.b.triad, j));
        for _ in 0..2 {
            let lacks: Matrix<f64> =
                [0, 1, 2].map(|i| [0, 1, 2].map(|j| (f64::from(i == j) - dot(b[i], b[j])) / 2.0));
            b = [0, 1, 2].map(|j| {
                [0, 1, 2].map(|x| {
                    b[j][x] + (b[0][x] * lacks[0][j] + b[1][x] * lacks[1][j] + b[2][x] * lacks[2][j])
                })
            });
        }
        [0, 1, 2].map(|i| b.map(|b| dot(column(&pair.a.triad, i), b)))
    }

    /// The rotation vector of ROTATION and its rows within half a turn of 2π, by formulas of their own. The angle is 2π − δ about n
    /// with `2 sin δ n = −(R₃₂ − R₂₃, …)`. The rows are those of `n nᵀ − (θ/2) cot(δ/2) (1 − n nᵀ) − (θ/2) n^`, the inverse of the
    /// left Jacobian, along a's axes.
    fn almost_a_turn(state: &State<f64>) -> Given {
        let r = relative(&state.pair);
        let axial = [r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]];
        let twice_sine = axial.iter().map(|x| x * x).sum::<f64>().sqrt();
        let delta = twice_sine.atan2(r[0][0] + r[1][1] + r[2][2] - 1.0);
        let angle = TAU - delta;
        let n: Vector<f64> = axial.map(|x| -x / twice_sine);
        let across = -angle / 2.0 / (delta / 2.0).tan();
        let hat = [[0.0, -n[2], n[1]], [n[2], 0.0, -n[0]], [-n[1], n[0], 0.0]];
        let (mut values, mut rows) = ([None; 6], [None; 6]);
        for i in 0..3 {
            let mut row = [0.0; DOFS];
            for j in 0..3 {
                let entry =
                    n[i] * n[j] + across * (f64::from(i == j) - n[i] * n[j]) - angle / 2.0 * hat[i][j];
                for (x, part) in column(&state.pair.a.triad, j).into_iter().enumerate() {
                    row[3 + x] -= entry * part;
                    row[10 + x] += entry * part;
                }
            }
            (values[3 + i], rows[3 + i]) = (Some(angle * n[i]), Some(row));
        }
        (values, rows).into()
    }

    /// Triads that are rotations to eleven digits, next to a whole turn. Dual numbers in the degrees of freedom of the nodes take
    /// the derivatives of these triads. The routine takes those of the nearest rotation, as 237 bits do. It is not called wrong,
    /// whether or not the state was chosen for them. What is wrong is, by these too, and by dual numbers where nobody else was
    /// asked.
    #[test]
    fn dual_numbers_do_not_decide_about_a_routine() {
        let node = |triad| Node { displacement: [0.0; 3], triad, flow: 0.0 };
        let at = |angle: f64| {
            let mut b = node(exp([0.6 * angle, 0.0, 0.8 * angle]));
            b.triad[0][0] += 3e-11;
            b.triad[1][2] -= 2e-11;
            Pair { reference: [1.0, 0.0, 0.0], a: node(identity()), b }
        };
        let rotation = ConnectionType::named("ROTATION", None).unwrap();
        let definition = Definition::new(rotation, Pair { b: node(identity()), ..at(0.0) });
        let angles = [0.0, 0.25 * TAU, 0.4997 * TAU, 0.75 * TAU, TAU - 0.02];
        let path = angles.windows(2).map(|pair| Step::between(&at(pair[0]), at(pair[1]))).collect();
        let name = "close to a whole turn".to_string();
        let case = Case { name, definition: definition.clone(), start: None, path, length: 1.0 };
        let spoilt = |state: &State<f64>| {
            let mut given = almost_a_turn(state);
            let rows = given.0.entries_mut(Quantity::FirstDerivatives);
            rows.0[4].as_mut().unwrap()[11] *= 1.0 + 1e-9;
            given
        };
        let checks = |oracles: &[Oracle], wide: bool, routine: &dyn Fn(&State<f64>) -> Given| {
            let settings = Settings { oracles: oracles.iter().copied().collect(), ..Settings::default() };
            let mut answers = |asked: &[Question<'_>]| {
                Ok::<_, Infallible>(asked.iter().map(|asked| Some(routine(asked.state()))).collect())
            };
            let asked = Asked::new(0, case.clone());
            let given = routine(&case.last().unwrap().state);
            let candidate = Candidate::new("mine", &definition).settings(settings);
            let at_state = (&asked, &given);
            let Ok(checks) =
                candidate.judge(at_state, &candidate.offers, &mut answers, wide, &mut Vec::new());
            checks
        };
        let of = |checks: &[Check], oracle: Oracle| {
            let is_it = |check: &&Check| {
                check.quantity == Some(Quantity::FirstDerivatives) && check.against == Against::Oracle(oracle)
            };
            checks.iter().find(is_it).cloned().unwrap()
        };
        let both = [Oracle::WideDifferences, Oracle::NodalDual];
        let chosen = checks(&both, true, &almost_a_turn);
        assert_eq!(of(&chosen, Oracle::WideDifferences).verdict, Verdict::Pass);
        let other = checks(&both, false, &almost_a_turn);
        for check in chosen.iter().chain(&other) {
            assert!(!check.verdict.is_mismatch(), "{check:?}");
        }
        let told = of(&other, Oracle::NodalDual);
        assert_eq!((told.verdict, told.undecided.get(OVERRULED)), (Verdict::Undecided, Some(&1)));
        // On its own it has called the routine wrong.
        assert!(told.worst.is_some_and(|worst| worst.units > 1.0));
        for (oracles, oracle, wide) in [
            (&both[..], Oracle::WideDifferences, true),
            (&both[..], Oracle::NodalDual, false),
            (&both[1..], Oracle::NodalDual, false),
        ] {
            let found = of(&checks(oracles, wide, &spoilt), oracle);
            assert_eq!(found.verdict, Verdict::Wrong, "{found:?}");
        }
    }
}
