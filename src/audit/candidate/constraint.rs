//! Somebody else's multi-point constraint: a function from a state to residuals and a Jacobian, judged like the product's own.

use crate::candidate::tables::Tables;
use crate::candidate::{FARTHEST, reach};
use crate::case::failing::MpcCase;
use crate::case::quantity::Quantity;
use crate::judge::outcome::Report;
use crate::mpc::ConstraintNumbers;
use crate::oracles::certificate::certificate_of_mpc;
use crate::sampling::cube_orientations;
use crate::settings::Settings;
use pintle_kinematics::connector::Turns;
use pintle_kinematics::draw::Draw;
use pintle_kinematics::mpc::{
    Body, Constraint, Dofs, PSI_M, PSI_S, ROWS, State, THETA_M, THETA_S, Translation, Turning, XM, XS,
};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3::exp;
use pintle_kinematics::vector::{add, apply, identity, product, scale, sub};
use std::convert::Infallible;
use std::f64::consts::{FRAC_PI_2, PI};

/// A routine to be checked against one multi-point constraint.
///
/// ```
/// use pintle_audit::{ConstraintCandidate, ConstraintNumbers};
/// use pintle_kinematics::mpc::{Constraint, DOFS, MpcType, XM, XS};
///
/// // LINK: δl = |x_S − x_M| − |X_S − X_M|.
/// let link = Constraint::new(MpcType::Link, [2.0, 0.0, 0.0], [0.0; 3], [[0.0; 3]; 2]);
/// let report = ConstraintCandidate::new("my LINK", &link).check(|case| {
///     let (s, m) = (case.state.slave.displacement, case.state.master.displacement);
///     let d = [2.0 + s[0] - m[0], s[1] - m[1], s[2] - m[2]];
///     let length = d.iter().map(|x| x * x).sum::<f64>().sqrt();
///     let mut row = [0.0; DOFS];
///     for i in 0..3 {
///         (row[XS + i], row[XM + i]) = (d[i] / length, -d[i] / length);
///     }
///     let (mut values, mut rows) = ([None; 7], [None; 7]);
///     (values[0], rows[0]) = (Some(length - 2.0), Some(row));
///     ConstraintNumbers::default().values(values).rows(rows)
/// });
/// assert_eq!(report.mismatches(), 0);
/// ```
#[derive(Clone, Debug)]
pub struct ConstraintCandidate<'a> {
    name: &'a str,
    constraint: &'a Constraint<f64>,
    settings: Settings,
    offers: Vec<Quantity>,
    equations: Vec<usize>,
    at: Option<&'a [MpcCase]>,
}

impl<'a> ConstraintCandidate<'a> {
    /// A routine of that name, for this constraint; 200 states.
    pub fn new(name: &'a str, constraint: &'a Constraint<f64>) -> Self {
        let settings = Settings { states: 200, near_singular_states: 0, atlas: false, ..Settings::default() };
        let offers = vec![Quantity::Value, Quantity::FirstDerivatives];
        Self { name, constraint, settings, offers, equations: Vec::new(), at: None }
            .of_equations([true; ROWS])
    }

    /// Another number of states, or seed. Mutants are made of the numbers at [`Settings::wide_states`] of the states; on 237 bits all are
    /// judged.
    #[must_use]
    pub fn settings(mut self, settings: Settings) -> Self {
        self.settings = settings;
        self
    }

    /// What the routine gives; values and rows without this. What it does not offer is not judged.
    #[must_use]
    pub fn offers(mut self, quantities: &[Quantity]) -> Self {
        self.offers = MpcCase::QUANTITIES.into_iter().filter(|of| quantities.contains(of)).collect();
        self
    }

    /// Of which equations; of all of the constraint without this.
    #[must_use]
    pub fn of_equations(mut self, offered: [bool; ROWS]) -> Self {
        let has = self.constraint.rows();
        self.equations = (0..ROWS).filter(|row| has[*row] && offered[*row]).collect();
        self
    }

    /// The states at which the routine is asked, in place of drawn ones: of the same constraint.
    #[must_use]
    pub const fn at(mut self, cases: &'a [MpcCase]) -> Self {
        (self.settings.states, self.settings.near_singular_states) = (cases.len(), 0);
        self.at = Some(cases);
        self
    }

    fn length(&self) -> f64 {
        let length = norm(self.constraint.arm());
        if length > 0.0 { length } else { 1.0 }
    }

    /// The states at which the routine is asked: its own, or else drawn ones.
    ///
    /// - The first is the initial one. At half of the others the constraint holds to rounding, at the others it is violated.
    /// - Every sixth has right angles, and every fifth violates the constraint far more or far less.
    /// - Then follow those 1e-1 to 1e-12 from where an equation has no derivative.
    pub fn drawn(&self) -> Vec<MpcCase> {
        if let Some(cases) = self.at {
            return cases.to_vec();
        }
        let mut draw = Draw::new(&format!("{} {}", self.settings.seed, self.constraint.kind().name()));
        let has_sets = self.equations.iter().any(|row| self.constraint.kind().row_set(*row).is_some());
        let near = if has_sets { self.settings.near_singular_states } else { 0 };
        (0..self.settings.states + near)
            .map(|i| {
                let near = i.checked_sub(self.settings.states);
                let name = format!("{} state {i}", self.name);
                if i == 0 {
                    let state = State { angles: [Some(0.0); 2], ..State::at_rest() };
                    return self.case(name, state);
                }
                self.state(name, i, near, &mut draw)
            })
            .collect()
    }

    fn case(&self, name: String, state: State<f64>) -> MpcCase {
        MpcCase {
            name,
            constraint: *self.constraint,
            state,
            turning: Turning::none(),
            before: [Turns { turns: 0.0, principal: 0.0 }; 2],
            length: self.length(),
        }
    }

    /// A drawn state, near a singular set if `near`.
    fn state(&self, name: String, i: usize, near: Option<usize>, draw: &mut Draw) -> MpcCase {
        let length = self.length();
        // Of one another alone: what both nodes move far is lost by rounding their places.
        let far = length * if near.is_some() { 1.0 } else { reach(i / 2, FARTHEST) };
        let is_held = i.is_multiple_of(2);
        let is_special = near.is_none() && (i + i / 6) % 6 == 5;
        let cubes = cube_orientations();
        let (master, violation, mut angles) = if is_special {
            let violation = if is_held { identity() } else { exp(scale(draw.direction(), FRAC_PI_2)) };
            let quarter = |draw: &mut Draw| FRAC_PI_2 * (draw.below(9) as f64 - 4.0);
            (cubes[draw.below(cubes.len())], violation, [quarter(draw), quarter(draw)])
        } else {
            let most = if i % 4 == 1 { 0.2 } else { 3.0 };
            let size = if is_held { 0.0 } else { draw.between(0.01, most) };
            let violation = exp(scale(draw.direction(), size));
            (draw.triad(), violation, [draw.between(-9.0, 9.0), draw.between(-9.0, 9.0)])
        };
        let violation = match near {
            Some(n) => {
                let distance = 10.0_f64.powf(-1.0 - (n % 12) as f64);
                exp(scale(draw.direction(), PI - distance))
            }
            None => violation,
        };
        let axes = self.constraint.initial_axes();
        let allowed = axes.into_iter().zip(&mut angles).fold(master, |so_far, (axis, angle)| match axis {
            Some(axis) => product(&so_far, &exp(scale(axis, *angle))),
            None => {
                *angle = 0.0;
                so_far
            }
        });
        let arm = self.constraint.arm();
        let of_master = draw.vector(length);
        let violated = if is_held { [0.0; 3] } else { draw.vector(0.5 * far) };
        let apart = match self.constraint.kind().entry().translation {
            Translation::Equal => arm,
            Translation::Carried => apply(&master, arm),
            Translation::Free => draw.vector(length),
            Translation::Distance => {
                // The same length in another direction, or next to none.
                let distance = near.map(|n| length * 10.0_f64.powf(-1.0 - (n % 12) as f64));
                scale(draw.direction(), distance.unwrap_or(norm(arm)))
            }
        };
        let violated = if near.is_some() { [0.0; 3] } else { violated };
        let of_slave = sub(add(add(of_master, apart), violated), arm);
        let flow = draw.between(-length, length);
        let body = |displacement, rotation, flow| Body { displacement, rotation, flow };
        let slave = body(of_slave, product(&violation, &allowed), if is_held { flow } else { -0.5 * flow });
        let rates = |draw: &mut Draw| -> Dofs<f64> {
            std::array::from_fn(|j| {
                let is_length = matches!(j, XS..THETA_S | PSI_S | XM..THETA_M | PSI_M);
                draw.between(-1.0, 1.0) * if is_length { length } else { 1.0 }
            })
        };
        let state = State {
            slave,
            master: body(of_master, master, flow),
            angles: angles.map(Some),
            velocity: rates(draw),
            acceleration: rates(draw),
        };
        self.case(name, state)
    }

    /// Draws states and checks what the routine gives there.
    pub fn check(&self, routine: impl Fn(&MpcCase) -> ConstraintNumbers) -> Report {
        let answers =
            |asked: &[&MpcCase]| Ok::<_, Infallible>(asked.iter().map(|case| Some(routine(case))).collect());
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
        routine: impl FnMut(&[&MpcCase]) -> Result<Vec<Option<ConstraintNumbers>>, E>,
    ) -> Result<Report, E> {
        let cases = self.drawn();
        let tables = Tables::asked(&cases, routine, self.settings.wide_states, |case, given, proves| {
            self.judge(case, given, proves)
        })?;
        let certificate = certificate_of_mpc(self.constraint.kind());
        let formulas = [Quantity::Value, Quantity::FirstDerivatives];
        let about = (&self.settings, cases.len());
        Ok(tables.report(self.name, about, certificate, &self.offers, &formulas))
    }

    /// What a routine gives at a state.
    fn judge(&self, case: &MpcCase, given: ConstraintNumbers, proves: bool) -> Tables {
        let (kind, rows) = (self.constraint.kind(), self.constraint.rows());
        let mut found = Tables::default();
        let has: Vec<(Quantity, [bool; ROWS])> =
            self.offers.iter().map(|quantity| (*quantity, given.has(*quantity))).collect();
        let mut tables = case.tables_given(given, &self.equations, proves);
        for (quantity, has) in has {
            if let Some(row) = self.equations.iter().find(|row| !has[**row]) {
                let entry = format!("{} of {} is missing", quantity.name(), kind.row_name(*row));
                found.misplaced(quantity, entry, &case.name);
                continue;
            }
            if let Some(row) = (0..ROWS).find(|row| has[*row] && !rows[*row]) {
                let name = kind.row_name(row);
                let entry = format!("{name} is given, and MPC {} has no such equation", kind.name());
                found.misplaced(quantity, entry, &case.name);
                continue;
            }
            let Some(at) = tables.iter().position(|table| table.quantity == quantity) else { continue };
            found.see(tables.swap_remove(at), (&case.name, proves), |table| {
                if !proves {
                    case.explain(std::slice::from_mut(table), &self.equations);
                }
            });
        }
        found
    }
}
