//! Somebody else's friction: P, F_C, F_N, Φ and their gradients, and what an increment does with its tangent, judged like the product's own.

use crate::candidate::tables::Tables;
use crate::case::failing::FrictionCase;
use crate::case::quantity::Quantity;
use crate::friction::{FrictionNumbers, FrictionSubject};
use crate::judge::outcome::Report;
use crate::oracles::certificate::certificate;
use crate::settings::Settings;
use pintle_kinematics::draw::Draw;
use pintle_model::behavior::Conditions;
use pintle_model::behavior::friction::{State, StickStiffness};
use std::convert::Infallible;

/// A routine to be checked against one friction.
#[derive(Clone, Debug)]
pub struct FrictionCandidate<'a> {
    name: &'a str,
    subject: &'a FrictionSubject,
    settings: Settings,
    offers: Vec<Quantity>,
}

impl<'a> FrictionCandidate<'a> {
    /// What may be offered.
    pub const QUANTITIES: [Quantity; 4] = [
        Quantity::FrictionCriterion,
        Quantity::FrictionGradient,
        Quantity::FrictionForce,
        Quantity::FrictionTangent,
    ];

    /// A routine of that name, for this friction; 200 states.
    pub fn new(name: &'a str, subject: &'a FrictionSubject) -> Self {
        let settings = Settings { states: 200, near_singular_states: 0, atlas: false, ..Settings::default() };
        Self { name, subject, settings, offers: Self::QUANTITIES.to_vec() }
    }

    /// Another number of states, or seed. Mutants are made of the numbers at [`Settings::wide_states`] of the states; on 237 bits all are
    /// judged.
    #[must_use]
    pub fn settings(mut self, settings: Settings) -> Self {
        self.settings = settings;
        self
    }

    /// What the routine gives; all of it without this. What it does not offer is not judged.
    #[must_use]
    pub fn offers(mut self, quantities: &[Quantity]) -> Self {
        self.offers = Self::QUANTITIES.into_iter().filter(|of| quantities.contains(of)).collect();
        self
    }

    /// The states at which the routine is asked: forces, and an increment after a state in which something may be stored. A third of
    /// the increments sticks. Where norms have no derivative is asked, too:
    ///
    /// | state, of twelve | what is zero there |
    /// |---|---|
    /// | 5, 11 | one traction, its increment, and what is stored of it |
    /// | 2, 9 | all of these |
    /// | 4 | all that presses |
    /// | 7, 10 | the forces that press; the moments that press |
    ///
    /// Of every ten, one has forces of a hundredth, and one a hundred times as large, at places as much nearer and farther.
    pub fn drawn(&self) -> Vec<FrictionCase> {
        let FrictionSubject { friction, coefficient, length, .. } = self.subject;
        let mut draw =
            Draw::new(&format!("{} {} friction", self.settings.seed, self.subject.connection.name));
        let radii = friction.radii();
        let unit = |k: usize| if k < 3 { 1.0 } else { *length };
        (0..self.settings.states)
            .map(|i| {
                let mut six = |size: f64| {
                    [0, 1, 2, 3, 4, 5].map(|_| {
                        let x = draw.between(0.1 * size, size);
                        if draw.unit() < 0.5 { -x } else { x }
                    })
                };
                let (mut point, mut forces, mut position) = (six(3.0), six(3.0), six(0.8));
                let mut displacement = six(1.0);
                let mut stored = six(1.0);
                // Places in cycles of ten and twelve, each cycle one further: they meet every place of shorter ones.
                let (of_ten, of_twelve) = ((i + i / 10) % 10, (i + i / 12) % 12);
                let size = [(3, 0.01), (8, 100.0)].into_iter().find(|(place, _)| of_ten == *place);
                let size = size.map_or(1.0, |(_, size)| size);
                for k in 0..6 {
                    point[k] *= unit(k) * size;
                    forces[k] *= size;
                    position[k] *= if k < 3 { size } else { 1.0 };
                }
                let still = match of_twelve {
                    5 | 11 => 1,
                    2 | 9 => radii.len(),
                    _ => 0,
                };
                for (k, _) in radii.iter().take(still) {
                    (point[*k], displacement[*k], stored[*k]) = (0.0, 0.0, 0.0);
                }
                let presses = |k: usize| radii.iter().all(|(of, _)| *of != k);
                let resting = match of_twelve {
                    4 => 0..6,
                    7 => 0..3,
                    10 => 3..6,
                    _ => 0..0,
                };
                for k in resting.filter(|k| presses(*k)) {
                    (point[k], forces[k]) = (0.0, 0.0);
                }
                let accumulated_slip = draw.between(0.0, 2.0) * length;
                let mut case = FrictionCase {
                    name: format!("{} state {i}", self.name),
                    title: String::new(),
                    friction: friction.clone(),
                    coefficient: *coefficient,
                    point,
                    before: State { accumulated_slip, ..State::default() },
                    displacement,
                    forces,
                    position,
                    motion: position,
                    accumulated_slip,
                    duration: None,
                    conditions: Conditions::default(),
                    length: *length,
                };
                let [_, limit] = friction.limit_after(&case.before, &case.input(0, 0.0), 0.0);
                let stiffness = match friction.stick_stiffness {
                    StickStiffness::Given(stiffness) => stiffness,
                    StickStiffness::ElasticSlip(slip) => limit / slip,
                };
                // The springs of stick store a part of the limit, and go a part or a multiple of the way to it.
                let is_free = !(stiffness > 0.0 && limit > 0.0);
                let way = [0.1, 1.5, 30.0][i % 3];
                for k in 0..6 {
                    let radius = radii.iter().find(|(of, _)| *of == k).map(|(_, radius)| *radius);
                    let is_stored = i % 2 == 1 && !is_free;
                    case.before.force[k] = match radius {
                        Some(radius) if is_stored => 0.3 * limit * radius * stored[k],
                        _ => 0.0,
                    };
                    case.displacement[k] = match radius {
                        Some(radius) if !is_free => way * limit / (stiffness * radius) * displacement[k],
                        _ => 0.01 * displacement[k] * if k < 3 { *length } else { 1.0 },
                    };
                }
                if matches!(friction.stick_stiffness, StickStiffness::ElasticSlip(_)) && !is_free {
                    case.before.stick_stiffness = Some(stiffness);
                }
                case
            })
            .collect()
    }

    /// Draws states and checks what the routine gives there.
    pub fn check(&self, routine: impl Fn(&FrictionCase) -> FrictionNumbers) -> Report {
        let answers = |asked: &[&FrictionCase]| {
            Ok::<_, Infallible>(asked.iter().map(|case| Some(routine(case))).collect())
        };
        let Ok(report) = self.try_check(answers);
        report
    }

    /// The same of a routine that is asked for several states at once, that may fail, and that gives nothing at a state which it does not
    /// cover. It gives one answer for each state, in their order.
    ///
    /// # Errors
    /// The first of the routine.
    pub fn try_check<E>(
        &self,
        routine: impl FnMut(&[&FrictionCase]) -> Result<Vec<Option<FrictionNumbers>>, E>,
    ) -> Result<Report, E> {
        let cases = self.drawn();
        let tables = Tables::asked(&cases, routine, self.settings.wide_states, |case, given, proves| {
            self.judge(case, &given, proves)
        })?;
        let formulas = [Quantity::FrictionCriterion, Quantity::FrictionForce, Quantity::FrictionGradient];
        let about = (&self.settings, cases.len());
        let certificate = certificate(&self.subject.connection);
        Ok(tables.report(self.name, about, certificate, &self.offers, &formulas))
    }

    fn judge(&self, case: &FrictionCase, given: &FrictionNumbers, proves: bool) -> Tables {
        let mut found = Tables::default();
        for table in case.tables_of_subject(&self.offers) {
            let quantity = table.quantity;
            match case.put(table, given) {
                Ok(table) => {
                    found.see(table, (case.name(), proves), |table| case.explain(table, self.subject))
                }
                Err(missing) => {
                    found.misplaced(quantity, format!("{missing} is missing"), case.name());
                }
            }
        }
        found
    }
}
