//! Wrong routines as engineers write them, each with its cause: the check finds all of them, and says the cause in words.
//!
//! A routine starts from the right numbers of a state, and changes them, or computes them anew from positions and triads in the wrong way.

mod forces;
mod other;
mod outsiders;
mod rates;
mod rows;
mod second;
mod special;
mod strangers;
mod third;
mod values;

use pintle_audit::oracles::oracle::Narrow;
use pintle_audit::sampling::definition;
use pintle_audit::{Candidate, Case, Given, Numbers, Quantity, Question, Report, Settings, Step, product};
use pintle_kinematics::catalog::TABLE;
use pintle_kinematics::connector::{Components, Definition, State};
use pintle_kinematics::draw::Draw;
use pintle_kinematics::measure::{Measure, Unit};
use pintle_kinematics::node::{Node, Pair, THETA_A, THETA_B};
use pintle_kinematics::so3::{self, exp};
use pintle_kinematics::vector::{self, Matrix, Vector, cross, scale, sub};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

pub(crate) const F: Quantity = Quantity::Value;
pub(crate) const DF: Quantity = Quantity::FirstDerivatives;
pub(crate) const DDF: Quantity = Quantity::SecondDerivatives;
pub(crate) const RATE: Quantity = Quantity::Rate;
pub(crate) const ACC: Quantity = Quantity::Acceleration;
pub(crate) const FORCE: Quantity = Quantity::NodalForces;
pub(crate) const STIFF: Quantity = Quantity::GeometricStiffness;

/// A wrong routine.
pub(crate) struct Wrong {
    /// What is wrong, in the words of who wrote it.
    pub(crate) name: &'static str,
    /// The connection type.
    pub(crate) connection: &'static str,
    /// What the routine gives.
    pub(crate) offers: &'static [Quantity],
    /// Makes the right numbers wrong.
    pub(crate) spoil: fn(&Right<'_>, &mut Numbers<f64>),
    /// The codes of its cause; several where numbers cannot separate them.
    pub(crate) causes: &'static [&'static str],
    /// What the sentence of the cause must contain besides: the component or entries.
    pub(crate) place: &'static str,
}

impl Wrong {
    /// The same in one line.
    pub(crate) const fn new(
        (connection, name): (&'static str, &'static str),
        offers: &'static [Quantity],
        spoil: fn(&Right<'_>, &mut Numbers<f64>),
        (causes, place): (&'static [&'static str], &'static str),
    ) -> Self {
        Self { name, connection, offers, spoil, causes, place }
    }
}

/// What a routine may know at a state.
pub(crate) struct Right<'a> {
    /// The connector: initial pair, β_s.
    pub(crate) definition: &'a Definition,
    /// The whole of it, as the audit has it.
    pub(crate) case: &'a Case,
    /// The state.
    pub(crate) state: &'a State<f64>,
    /// The states before it, with the increments.
    pub(crate) path: &'a [Step],
    /// The right numbers of the state.
    pub(crate) numbers: &'a Numbers<f64>,
    /// The right values of the state before.
    pub(crate) values_before: Components<f64>,
    /// The measures of the components; `None` where there is no such component.
    pub(crate) measures: [Option<Measure>; 6],
    /// Whether the state was drawn, not one beside it.
    pub(crate) is_drawn: bool,
    /// The right numbers at other nodes, after the same path: to be differenced, or with a and b exchanged.
    pub(crate) at: &'a dyn Fn(&State<f64>) -> Numbers<f64>,
}

impl Right<'_> {
    pub(crate) fn pair(&self) -> &Pair<f64> {
        &self.state.pair
    }

    pub(crate) fn initial(&self) -> &Pair<f64> {
        &self.definition.initial
    }

    /// x_b − x_a, global components.
    pub(crate) fn d(&self) -> Vector<f64> {
        self.pair().separation()
    }

    /// e_i^a, i from 0.
    pub(crate) fn a(&self, i: usize) -> Vector<f64> {
        vector::column(&self.pair().a.triad, i)
    }

    /// e_i^b, i from 0.
    pub(crate) fn b(&self, i: usize) -> Vector<f64> {
        vector::column(&self.pair().b.triad, i)
    }

    /// Q = AᵀB.
    pub(crate) fn q(&self) -> Matrix<f64> {
        relative(self.pair())
    }

    /// Whether component k is an angle.
    pub(crate) fn is_angle(&self, k: usize) -> bool {
        self.measures[k].is_some_and(|measure| measure.unit() == Unit::Angle)
    }

    /// A right entry; 0 where there is none.
    pub(crate) fn of(&self, quantity: Quantity, k: usize, i: usize) -> f64 {
        self.numbers.entries(quantity).get(k, i).unwrap_or(0.0)
    }

    /// Number j of the rates, and of the accelerations, of the degrees of freedom.
    pub(crate) fn rates(&self) -> [[f64; 14]; 2] {
        [self.state.velocity, self.state.acceleration]
    }
}

/// Q = AᵀB of a pair.
pub(crate) fn relative(pair: &Pair<f64>) -> Matrix<f64> {
    vector::transposed_product(&pair.a.triad, &pair.b.triad)
}

/// An angle on the sheet of the right one.
pub(crate) fn continued(mine: f64, right: f64) -> f64 {
    mine + TAU * ((right - mine) / TAU).round()
}

/// Changes every entry of a quantity: component, place, number.
pub(crate) fn each(
    numbers: &mut Numbers<f64>,
    quantity: Quantity,
    change: impl FnMut(usize, usize, f64) -> f64,
) {
    let changed = numbers.entries(quantity).map(change);
    numbers.set(quantity, changed);
}

/// Changes the entries of one component.
pub(crate) fn row(numbers: &mut Numbers<f64>, quantity: Quantity, k: usize, change: impl FnOnce(&mut [f64])) {
    if let Some(row) = numbers.entries_mut(quantity).0[k].as_mut() {
        change(row);
    }
}

/// Changes one number.
pub(crate) fn one(
    numbers: &mut Numbers<f64>,
    quantity: Quantity,
    (k, i): (usize, usize),
    change: impl FnOnce(f64) -> f64,
) {
    row(numbers, quantity, k, |row| row[i] = change(row[i]));
}

/// A connector in general position: its nodes apart, their triads turned against each other and against the global axes.
pub(crate) fn general(name: &str) -> Definition {
    let connection = super::named(name);
    let node = |triad| Node { displacement: [0.0; 3], triad, flow: 0.0 };
    let a = exp([0.4, -0.7, 0.5]);
    let b = vector::product(&a, &exp([0.31, 0.23, -0.17]));
    definition(connection, Pair { reference: [0.7, -0.4, 0.9], a: node(a), b: node(b) }, 1.2)
}

/// The states of a check: about the initial one, at ends of histories, near singular sets.
pub(crate) fn settings() -> Settings {
    Settings { states: 48, wide_states: 6, near_singular_states: 8, atlas: false, ..Settings::default() }
}

/// All of them.
pub(crate) fn all() -> impl Iterator<Item = &'static Wrong> {
    let parts = [SEEN, &[strangers::ALL, outsiders::ALL, third::ALL]].concat();
    parts.into_iter().flatten()
}

/// Those that the catalogue of causes was written with.
const SEEN: &[&[Wrong]] =
    &[values::ALL, rows::ALL, rates::ALL, second::ALL, forces::ALL, special::ALL, other::ALL];

/// The report of a routine that gives what `answer` makes of the right numbers.
pub(crate) fn checked(
    (name, definition, offers): (&str, &Definition, &[Quantity]),
    answer: impl Fn(&Right<'_>, &mut Numbers<f64>),
) -> Report {
    let candidate = Candidate::new(name, definition).settings(settings()).histories(8);
    heard(&candidate.offers(offers, [true; 6]), definition, answer, |_, _| ())
}

/// The same of a candidate with settings of its own; `hear` gets each question with its answer.
pub(crate) fn heard(
    candidate: &Candidate<'_>,
    definition: &Definition,
    answer: impl Fn(&Right<'_>, &mut Numbers<f64>),
    mut hear: impl FnMut(&Question<'_>, &Numbers<f64>),
) -> Report {
    let connector = pintle_kinematics::connector::Connector::<f64>::new(definition);
    let measures = std::array::from_fn(|k| connector.differentiated(k));
    let answers = |asked: &[Question<'_>]| {
        let mut of = |asked: &Question<'_>| {
            let case = |state: &State<f64>| {
                let mut path = asked.path.to_vec();
                path.push(Step { state: *state, increment: asked.step.increment });
                Case { name: String::new(), definition: definition.clone(), start: None, path, length: 1.2 }
            };
            let at = |state: &State<f64>| product(&case(state)).unwrap();
            let right = at(asked.state());
            let mut numbers = right.clone();
            let case = case(asked.state());
            let state = Right {
                definition,
                case: &case,
                state: asked.state(),
                path: asked.path,
                numbers: &right,
                values_before: asked.values_before,
                measures,
                is_drawn: asked.is_drawn,
                at: &at,
            };
            answer(&state, &mut numbers);
            hear(asked, &numbers);
            Some(Given::from(numbers))
        };
        Ok::<_, std::convert::Infallible>(asked.iter().map(&mut of).collect())
    };
    let Ok(report) = candidate.try_check(answers);
    report
}

/// What the check of a wrong routine says: whether it is wrong, and the first line of each diagnosis with its code.
pub(crate) fn told(wrong: &Wrong) -> (bool, Vec<(String, String)>) {
    let report = checked((wrong.name, &general(wrong.connection), wrong.offers), wrong.spoil);
    let checks = report.subjects.iter().flat_map(|subject| &subject.checks);
    let diagnoses =
        checks.filter(|check| check.verdict.is_mismatch()).filter_map(|check| check.diagnosis.as_ref());
    let lines = diagnoses.filter_map(|diagnosis| diagnosis.lines().into_iter().next());
    (report.mismatches() > 0, lines.map(|(line, code)| (line, code.as_str().to_string())).collect())
}

/// Whether every line is a cause that is meant, and says where.
pub(crate) fn is_named(wrong: &Wrong, lines: &[(String, String)]) -> bool {
    let is_it =
        |(line, code): &(String, String)| wrong.causes.contains(&code.as_str()) && line.contains(wrong.place);
    !lines.is_empty() && lines.iter().all(is_it)
}

/// Asserts that all of them are found, and so many of a hundred named; prints which are not.
pub(crate) fn assert_named(title: &str, corpus: &[&[Wrong]], percent: usize) {
    use std::sync::Mutex;
    let all: Vec<&Wrong> = corpus.iter().flat_map(|part| part.iter()).collect();
    let next = std::sync::atomic::AtomicUsize::new(0);
    let found = Mutex::new(BTreeMap::new());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some(wrong) = all.get(next.fetch_add(1, std::sync::atomic::Ordering::Relaxed)) {
                    let said = told(wrong);
                    found
                        .lock()
                        .unwrap()
                        .insert(format!("{}: {}", wrong.connection, wrong.name), (*wrong, said));
                }
            });
        }
    });
    let found = found.into_inner().unwrap();
    assert_eq!(found.len(), all.len(), "two routines have one name");
    let mut named = 0;
    let mut table = String::new();
    for (name, (wrong, (is_found, lines))) in &found {
        let is_named = is_named(wrong, lines);
        named += usize::from(is_named);
        if !is_found || !is_named {
            let said: Vec<String> = lines.iter().map(|(line, code)| format!("    {line} [{code}]")).collect();
            let missed = if *is_found { "not named" } else { "NOT FOUND" };
            table += &format!("{missed}: {name}: {:?} {}\n{}\n", wrong.causes, wrong.place, said.join("\n"));
        }
    }
    let wrong = found.values().filter(|(_, (is_found, _))| *is_found).count();
    println!("{table}{title}: {} routines, {wrong} found, {named} named", all.len());
    assert_eq!(wrong, all.len(), "{table}");
    assert!(named * 100 >= percent * all.len(), "{named} of {} named\n{table}", all.len());
}

/// Three entries of a row, from a place on.
pub(crate) fn part(row: &[f64], at: usize) -> Vector<f64> {
    [row[at], row[at + 1], row[at + 2]]
}

/// Replaces three entries of a row.
pub(crate) fn put(row: &mut [f64], at: usize, by: Vector<f64>) {
    row[at..at + 3].copy_from_slice(&by);
}

#[test]
fn causes_of_the_corpus_are_named() {
    assert_named("seen", SEEN, 95);
}

#[test]
fn causes_of_strangers_are_named() {
    assert_named("strangers", &[strangers::ALL], 90);
}

#[test]
fn causes_of_outsiders_are_named() {
    assert_named("outsiders", &[outsiders::ALL], 90);
}

#[test]
fn causes_of_a_third_outsider_are_named() {
    assert_named("third", &[third::ALL], 100);
}

/// Right routines: the product's numbers, and numbers by other formulas. Nothing is wrong of any type, in any quantity, at any state.
#[test]
fn right_routines_are_not_called_wrong() {
    let mut compared = 0;
    for connection in TABLE {
        let definition = general(&connection.name);
        let product = checked(("product", &definition, &Quantity::ALL[..7]), |_, _| ());
        let by = |of: fn(&Narrow) -> Numbers<f64>| {
            checked(("formulas", &definition, &Quantity::ALL[..7]), |right, numbers| {
                // Beside a state values alone are differenced.
                if !right.is_drawn {
                    return;
                }
                let found = of(&Narrow::of(right.case).unwrap());
                for quantity in Quantity::ALL {
                    each(numbers, quantity, |k, i, x| found.entries(quantity).get(k, i).unwrap_or(x));
                }
            })
        };
        for report in [&product, &by(Narrow::symbolic), &by(Narrow::nested_dual)] {
            let wrong = report.subjects[0].checks.iter().find(|check| check.verdict.is_mismatch());
            let worst = wrong.map(|check| (check.quantity, check.worst.as_ref()));
            assert_eq!(report.mismatches(), 0, "{}: {worst:?}", connection.name);
            compared += report.compared();
        }
    }
    assert!(compared > 1_000_000, "{compared}");
}

/// Rows as the formulas are printed, cancellation and all: near their singular points they lose more digits than ours, and are right. With
/// tolerances by entries, not by blocks, both are called wrong.
#[test]
fn rows_as_printed_raise_no_alarm() {
    // e1′ = (e1a − sβ e3b)/cβ² and e3′ = (e3b − sβ e1a)/cβ², the duals of the axes of Cardan angles.
    fn cardan(right: &Right<'_>) -> [Option<Vector<f64>>; 3] {
        let q = right.q();
        let (sine, squared) = (q[0][2], q[1][2] * q[1][2] + q[2][2] * q[2][2]);
        let dual = |e: Vector<f64>, other: Vector<f64>| scale(sub(e, scale(other, sine)), 1.0 / squared);
        let (e1, e3) = (right.a(0), right.b(2));
        [Some(dual(e1, e3)), None, Some(dual(e3, e1))]
    }
    // The direction of a flexion, e3a × e3b/|e3a × e3b|.
    fn flexion(right: &Right<'_>) -> [Option<Vector<f64>>; 3] {
        let q = right.q();
        let across = cross(right.a(2), right.b(2));
        [Some(scale(across, 1.0 / (q[0][2] * q[0][2] + q[1][2] * q[1][2]).sqrt())), None, None]
    }
    type Printed = fn(&Right<'_>) -> [Option<Vector<f64>>; 3];
    let mut compared = 0;
    for (name, printed) in [("CARDAN", cardan as Printed), ("FLEXION-TORSION", flexion)] {
        let definition = general(name);
        for seed in 0..4 {
            let settings = Settings {
                states: 60,
                near_singular_states: 60,
                seed: format!("printed {seed}"),
                ..settings()
            };
            let candidate = Candidate::new(name, &definition).settings(settings);
            let report = heard(
                &candidate,
                &definition,
                |right, numbers| {
                    for (k, gradient) in printed(right).into_iter().enumerate() {
                        let Some(gradient) = gradient else { continue };
                        row(numbers, DF, 3 + k, |row| {
                            put(row, THETA_A, scale(gradient, -1.0));
                            put(row, THETA_B, gradient);
                        });
                    }
                },
                |_, _| (),
            );
            assert_eq!(report.mismatches(), 0, "{name}, seed {seed}:\n{:#?}", report.subjects);
            compared += report.compared();
        }
    }
    assert!(compared > 20_000, "{compared}");
}

/// Values of triads that a routine composes anew, of total rotation vectors and initial triads: rotations to several roundings only.
#[test]
fn composed_triads_raise_no_alarm() {
    let mut compared = 0;
    for connection in TABLE {
        let definition = general(&connection.name);
        let report = checked(("composed", &definition, &[F]), |right, numbers| {
            let initial = right.initial();
            let mut state = *right.state;
            for (node, first) in [(&mut state.pair.a, &initial.a), (&mut state.pair.b, &initial.b)] {
                let back = vector::transpose(&first.triad);
                let phi = so3::log(&vector::product(&node.triad, &back));
                // Three turns for one.
                let third = exp(phi.map(|x| x / 3.0));
                let whole = vector::product(&third, &vector::product(&third, &third));
                node.triad = vector::product(&whole, &first.triad);
            }
            *numbers = (right.at)(&state);
        });
        let worst: Vec<_> =
            report.subjects[0].checks.iter().map(|check| (check.largest, &check.worst)).collect();
        assert_eq!(report.mismatches(), 0, "{}: {worst:?}", connection.name);
        compared += report.compared();
    }
    assert!(compared > 5_000, "{compared}");
}

/// Numbers that are nothing: no cause is told of them.
#[test]
fn nothing_explains_noise() {
    let mut tried = 0;
    for connection in TABLE {
        let definition = general(&connection.name);
        for quantity in Quantity::ALL.into_iter().take(7) {
            let report = checked(("noise", &definition, &[quantity]), |right, numbers| {
                let pair = right.pair();
                let seed = format!("{:?} {:?}", pair.a.displacement, pair.b.triad);
                let draw = &mut Draw::new(&seed);
                each(numbers, quantity, |_, _, x| x + draw.between(-1.0, 1.0));
            });
            let checks = report.subjects.iter().flat_map(|subject| &subject.checks);
            for diagnosis in checks.filter_map(|check| check.diagnosis.as_ref()) {
                tried += 1;
                let lines = diagnosis.lines();
                let is_unknown = diagnosis.causes.is_empty() && diagnosis.unexplained > 0;
                assert!(is_unknown, "{} {}: {lines:?}", connection.name, quantity.name());
            }
        }
    }
    assert!(tried > 250, "{tried}");
}
