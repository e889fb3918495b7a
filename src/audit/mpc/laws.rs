//! Laws of a multi-point constraint, which need no reference.
//!
//! Everything turned by R about any point, and moved, turns δ of a BEAM and ρ with it. They are global components of vectors that
//! the nodes carry: `δ' = R δ`, `ρ' = R ρ`. δl and δΨ stay what they are. The δ of a PIN and of a TIE is u_S − u_M: what turns is x_S −
//! x_M = δ + X_S − X_M. So nodes which are apart initially violate the constraint where everything turns; that is what it says.
//! With v the vector that turns, and 0 for δl and δΨ:
//!
//! | law | says |
//! |---|---|
//! | rigid modes | J r = 0 for a translation r of everything, J r = e × v for a turn about e: zero where a BEAM, ρ or coincident nodes of a PIN meet the constraint; and the derivative of both along every degree of freedom |
//! | frame | at the state turned by R, moved, and turning at a rate that changes: v' = R v, v̇' = R v̇ + Ω × v', v̈' = R v̈ + 2 Ω × R v̇ + Ω̇ × v' + Ω × (Ω × v'); rows and second derivatives are turned |
//! | power | rates are J q̇, accelerations J q̈ + q̇ᵀ H q̇ |
//! | symmetry | H = Hᵀ |
//!
//! The tolerance of a sum is that of its terms, which follows from the conditioning of the state. Nothing is asked of an equation on its
//! singular set, and nothing is compared with a turned state within 1e-3 of one, or where that state is on the other sheet of ρ.

use crate::case::failing::MpcCase;
use crate::case::quantity::Quantity;
use crate::judge::bound::{C, scales};
use crate::judge::outcome::Check;
use crate::judge::table::{Entry, ResultTable};
use crate::laws::checks::{ByRow, checks_of_tables};
use crate::laws::{Demand, Invariant, Related, Term, about_third, along_plane, along_rows, axis, turning};
use crate::mpc::numbers_of;
use pintle_kinematics::connector::{Request, Tally};
use pintle_kinematics::mpc::{
    Body, DOFS, Dofs, Evaluation, FLOW, RHO, ROWS, State, THETA_M, THETA_S, Translation, XM, XS,
};
use pintle_kinematics::scalar::U;
use pintle_kinematics::so3::exp;
use pintle_kinematics::vector::{
    Matrix, Vector, add, apply, apply_transposed, cross, dot, product, scale, sub,
};

/// In radians or lengths: closer to a singular set nothing is compared with another state.
const AWAY: f64 = 1e-3;

/// Where a vector that turns with everything stands among the degrees of freedom.
const VECTORS: [usize; 4] = [XS, THETA_S, XM, THETA_M];

/// The same constraint seen from elsewhere: turned, moved, and turning.
struct Twin {
    rotation: Matrix<f64>,
    /// Ω.
    spin: Vector<f64>,
    /// Ω̇.
    spin_rate: Vector<f64>,
    numbers: ByRow,
    tolerance: ByRow,
}

/// The numbers of a constraint at a state, with what laws need to know of it.
struct Laws<'a> {
    case: &'a MpcCase,
    tables: &'a [ResultTable],
    /// The equations that the rows of the tables are of.
    equations: Vec<usize>,
    given: ByRow,
    tolerance: ByRow,
    nearness: [f64; ROWS],
    /// The angles of the hinges that the equations are taken at.
    taken: [f64; 2],
    /// x_S − x_M.
    separation: Vector<f64>,
}

/// The places of a vector, or of one number, around a degree of freedom.
fn block(j: usize) -> std::ops::Range<usize> {
    VECTORS.into_iter().map(|at| at..at + 3).find(|block| block.contains(&j)).unwrap_or(j..j + 1)
}

/// The degrees of freedom in turned axes that make up one, each with its factor.
fn turned(rotation: &Matrix<f64>, j: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
    let block = block(j);
    let (start, is_vector) = (block.start, block.len() == 3);
    block.map(move |l| (l, if is_vector { rotation[l - start][j - start] } else { 1.0 }))
}

fn size(v: Vector<f64>) -> f64 {
    v.into_iter().map(f64::abs).sum()
}

fn part(of: &Dofs<f64>, at: usize) -> Vector<f64> {
    [of[at], of[at + 1], of[at + 2]]
}

impl<'a> Laws<'a> {
    fn new(case: &'a MpcCase, tables: &'a [ResultTable]) -> Self {
        let equations = case.equations();
        let got = case.evaluated(&case.state);
        let of_tables = |number: &dyn Fn(&Entry) -> f64| {
            let of = |(place, equation): (usize, &usize)| {
                let of = |quantity| {
                    let table = tables.iter().find(|table| table.quantity == quantity);
                    let entries = table.and_then(|table| {
                        table.entries.get(place * table.width()..(place + 1) * table.width())
                    });
                    entries.into_iter().flatten().map(number).collect()
                };
                (*equation, MpcCase::QUANTITIES.map(of))
            };
            ByRow::of(MpcCase::QUANTITIES, equations.iter().enumerate().map(of))
        };
        let (given, tolerance) = (of_tables(&|entry| entry.got), of_tables(&Entry::tolerance));
        let State { slave, master, .. } = &case.state;
        Self {
            case,
            tables,
            given,
            tolerance,
            nearness: case.nearness(&got),
            taken: got.taken,
            separation: add(case.constraint.arm(), sub(slave.displacement, master.displacement)),
            equations,
        }
    }

    fn demands(&self, law: Invariant) -> Vec<Demand> {
        match law {
            Invariant::RigidModes => self.rigid_modes(),
            Invariant::Frame => self.frame(),
            Invariant::Power => self.power(),
            Invariant::Symmetry => self.symmetry(),
            _ => Vec::new(),
        }
    }

    /// The equations that are on no singular set.
    fn smooth(&self) -> impl Iterator<Item = usize> + '_ {
        self.equations.iter().copied().filter(|row| self.nearness[*row] > 0.0)
    }

    fn name(&self, quantity: Quantity, row: usize, place: usize) -> &str {
        let table = self.tables.iter().find(|table| table.quantity == quantity);
        let at = self.equations.iter().position(|equation| *equation == row);
        let entry = table.zip(at).and_then(|(table, at)| table.entries.get(at * table.width() + place));
        entry.map_or("", |entry| entry.name.as_str())
    }

    fn sum(&self, terms: Vec<Term>, want: f64, what: String) -> Demand {
        Demand::said(terms, want, what, (&self.given, &self.tolerance))
    }

    /// Where the vector begins of which an equation is a global component; none of a scalar one.
    fn vector_of(&self, row: usize) -> Option<usize> {
        match (self.case.constraint.kind().entry().translation, row) {
            (_, FLOW) | (Translation::Distance, 0..RHO) => None,
            (_, RHO..FLOW) => Some(RHO),
            _ => Some(0),
        }
    }

    /// What turns with everything, less the equations that begin there.
    fn offset(&self, start: usize) -> Vector<f64> {
        match self.case.constraint.kind().entry().translation {
            Translation::Equal if start < RHO => self.case.constraint.arm(),
            _ => [0.0; 3],
        }
    }

    fn rigid_modes(&self) -> Vec<Demand> {
        let mut found = Vec::new();
        let is_planar = self.case.constraint.is_planar();
        let columns = self.case.constraint.columns();
        // In the plane two translations, one turn, and the degrees of freedom that there are.
        let by: Vec<Option<usize>> =
            std::iter::once(None).chain((0..DOFS).filter(|j| !is_planar || columns[*j]).map(Some)).collect();
        for row in self.smooth() {
            for (i, j) in (0..3).flat_map(|i| by.iter().map(move |j| (i, *j))) {
                if !is_planar || i < 2 {
                    found.push(self.along_translation(row, j, i));
                }
                if !is_planar || i == 2 {
                    found.push(self.along_turn(row, j, i));
                }
            }
        }
        found.retain(|demand| !demand.terms.is_empty());
        found
    }

    /// A row, or how it changes with degree of freedom j, along a translation of everything.
    fn along_translation(&self, row: usize, j: Option<usize>, i: usize) -> Demand {
        let (quantity, at, name) = self.row_of(row, j);
        let terms = [XS, XM].map(|x| (quantity, row, at + x + i, 1.0)).to_vec();
        self.sum(terms, 0.0, format!("{name} along translation {}", i + 1))
    }

    /// The same along a turn about an axis through M. With r the turn, E v = e × v, and w of degree of freedom j, `J r = E v`. So
    /// `H[w] r + J_x (e × w) = E J_w` for displacements w of either node, and with `½ J_θ (e × w)` for their rotations. For
    /// `exp(t e^) exp(s w^) = exp(t e^ + s w^ + ½ s t (e × w)^ + …)`.
    fn along_turn(&self, row: usize, j: Option<usize>, i: usize) -> Demand {
        let (quantity, at, name) = self.row_of(row, j);
        let arm = cross(axis(i), self.separation);
        let mut terms = [THETA_S, THETA_M].map(|theta| (quantity, row, at + theta + i, 1.0)).to_vec();
        terms.extend((0..3).map(|l| (quantity, row, at + XS + l, arm[l])));
        if let Some(j) = j
            && let (start, 3) = (block(j).start, block(j).len())
        {
            let half = if matches!(start, THETA_S | THETA_M) { 0.5 } else { 1.0 };
            let moved = cross(axis(i), axis(j - start));
            terms.extend((0..3).map(|l| (Quantity::FirstDerivatives, row, start + l, half * moved[l])));
        }
        let mut want = 0.0;
        if let Some(start) = self.vector_of(row) {
            let k = row - start;
            let factor = |m: usize| cross(axis(i), axis(m))[k];
            terms.extend((0..3).map(|m| match j {
                None => (Quantity::Value, start + m, 0, -factor(m)),
                Some(j) => (Quantity::FirstDerivatives, start + m, j, -factor(m)),
            }));
            if j.is_none() {
                want = cross(axis(i), self.offset(start))[k];
            }
        }
        terms.retain(|term| term.3 != 0.0);
        self.sum(terms, want, format!("{name} along turn {}", i + 1))
    }

    /// The kind of numbers of a row or of its derivatives by a degree of freedom, where these begin, and what they are called.
    fn row_of(&self, row: usize, j: Option<usize>) -> (Quantity, usize, String) {
        match j {
            None => {
                let name = format!("∂{}", self.case.constraint.kind().row_name(row));
                (Quantity::FirstDerivatives, 0, name)
            }
            Some(j) => {
                let name = format!("∂({})", self.name(Quantity::FirstDerivatives, row, j));
                (Quantity::SecondDerivatives, j * DOFS, name)
            }
        }
    }

    fn power(&self) -> Vec<Demand> {
        let State { velocity: v, acceleration: a, .. } = &self.case.state;
        let mut found = Vec::new();
        for row in self.smooth() {
            let (rate, acceleration, underflows) = along_rows(row, v, a);
            let what = format!("{} is J q̇", self.name(Quantity::Rate, row, 0));
            found.push(self.sum(rate, 0.0, what));
            let what = format!("{} is J q̈ + q̇ᵀ H q̇", self.name(Quantity::Acceleration, row, 0));
            let mut demand = self.sum(acceleration, 0.0, what);
            if underflows {
                // Squares of the rates are lost: nothing is decided.
                demand.allowed = f64::INFINITY;
            }
            found.push(demand);
        }
        found
    }

    fn symmetry(&self) -> Vec<Demand> {
        let quantity = Quantity::SecondDerivatives;
        let mut found = Vec::new();
        for row in self.smooth() {
            for (j, l) in (0..DOFS).flat_map(|j| (0..j).map(move |l| (j, l))) {
                let [below, above] = [j * DOFS + l, l * DOFS + j];
                let terms = vec![(quantity, row, below, 1.0), (quantity, row, above, -1.0)];
                let what = format!("{} with its columns exchanged", self.name(quantity, row, below));
                found.push(self.sum(terms, 0.0, what));
            }
        }
        found
    }

    /// The state after a rigid motion of everything, which goes on.
    fn twin(&self) -> Twin {
        let MpcCase { state, length, .. } = self.case;
        let sizes = self.case.sizes();
        // As fast as the nodes are, so that neither hides the other.
        let fastest = |rates: &Dofs<f64>| {
            let most = rates.iter().zip(&sizes).fold(0.0_f64, |most, (x, s)| most.max((x / s).abs()));
            if most > 0.0 { most } else { 1.0 }
        };
        let (fast, faster) = (fastest(&state.velocity), fastest(&state.acceleration));
        let is_planar = self.case.constraint.is_planar();
        let rotation = exp(turning(is_planar));
        let [spin, spin_rate] = [scale([0.6, 0.3, -0.5], fast), scale([-0.2, 0.7, 0.4], faster)]
            .map(|rate| about_third(is_planar, rate));
        let [place, velocity, acceleration] = [
            scale([0.3, -0.5, 0.2], *length),
            scale([-0.4, 0.1, 0.6], fast * length),
            scale([0.5, 0.2, -0.3], faster * length),
        ]
        .map(|of| along_plane(is_planar, of));
        let separation = apply(&rotation, self.separation);
        let mut twin = *state;
        twin.angles = self.taken.map(Some);
        twin.master.displacement = place;
        twin.slave.displacement = add(place, sub(separation, self.case.constraint.arm()));
        for body in [&mut twin.slave, &mut twin.master] {
            *body = Body { rotation: product(&rotation, &body.rotation), ..*body };
        }
        // The magnitudes of what is added up, by which sums of it are rounded.
        let [mut reach, mut reach_rate] = [state.velocity, state.acceleration];
        for (x, theta, arm) in [(XS, THETA_S, separation), (XM, THETA_M, [0.0; 3])] {
            let of = |rates: &Dofs<f64>, at: usize| apply(&rotation, part(rates, at));
            let (v, a) = (of(&state.velocity, x), of(&state.acceleration, x));
            let (turning, faster_turning) = (of(&state.velocity, theta), of(&state.acceleration, theta));
            let parts = [velocity, cross(spin, arm), v];
            let angular = [spin, turning];
            let accelerations = [
                acceleration,
                cross(spin_rate, arm),
                cross(spin, cross(spin, arm)),
                cross(scale(spin, 2.0), v),
                a,
            ];
            let angular_rates = [spin_rate, cross(spin, turning), faster_turning];
            let put = |into: &mut Dofs<f64>, sizes: &mut Dofs<f64>, at: usize, parts: &[Vector<f64>]| {
                let sum = parts.iter().fold([0.0; 3], |sum, part| add(sum, *part));
                into[at..at + 3].copy_from_slice(&sum);
                sizes[at..at + 3].fill(parts.iter().map(|part| size(*part)).sum());
            };
            put(&mut twin.velocity, &mut reach, x, &parts);
            put(&mut twin.velocity, &mut reach, theta, &angular);
            put(&mut twin.acceleration, &mut reach_rate, x, &accelerations);
            put(&mut twin.acceleration, &mut reach_rate, theta, &angular_rates);
        }
        let got = self.case.evaluated(&twin);
        let inputs = self.case.inputs(&got.taken);
        let present = (0..ROWS).filter(|row| got.residual[*row].is_some());
        let rows: Vec<_> = present.map(|row| (row, numbers_of(&got, row))).collect();
        let scales = rows.iter().map(|(row, [value, first, second, ..])| {
            let value = value.first().copied().unwrap_or(f64::NAN);
            let near = self.nearness[*row];
            let of_row = scales(value, first, second, (&sizes, &inputs), (&reach, &reach_rate), near);
            (*row, of_row.map(|scales| scales.into_iter().map(|scale| C * U * scale).collect()))
        });
        let tolerance = ByRow::of(MpcCase::QUANTITIES, scales);
        let numbers = ByRow::of(MpcCase::QUANTITIES, rows);
        Twin { rotation, spin, spin_rate, numbers, tolerance }
    }

    fn frame(&self) -> Vec<Demand> {
        let twin = self.twin();
        let mut found = Vec::new();
        for row in self.smooth().filter(|row| self.nearness[*row] > AWAY) {
            if self.vector_of(row) == Some(RHO) && self.is_on_another_sheet(&twin) {
                continue;
            }
            for quantity in MpcCase::QUANTITIES {
                for place in 0..self.given.row(quantity, row).len() {
                    // Second derivatives are symmetric.
                    if quantity == Quantity::SecondDerivatives && place % DOFS > place / DOFS {
                        continue;
                    }
                    let want = self.seen_from(&twin, quantity, row, place);
                    let what = format!("{} in turned axes", self.name(quantity, row, place));
                    let mut demand = self.sum(vec![(quantity, row, place, 1.0)], want, what);
                    // The turned inputs are rounded, three roundings in each direction; a component of a vector is as uncertain as the vector.
                    demand.allowed = demand.allowed.max(self.around(&self.tolerance, quantity, row, place));
                    demand.allowed = 4.0 * (demand.allowed + self.allowed_of(&twin, quantity, row, place));
                    found.push(demand);
                }
            }
        }
        found
    }

    /// Whether ρ of the turned state is near half a turn, and rounding has put it on the other side.
    fn is_on_another_sheet(&self, twin: &Twin) -> bool {
        /// Beyond this no rounding leads from half a turn.
        const NEAR_HALF_A_TURN: f64 = 3.0;
        let rho = |numbers: &ByRow| [0, 1, 2].map(|i| numbers.at(Quantity::Value, RHO + i, 0));
        let (own, other) = (rho(&self.given), apply_transposed(&twin.rotation, rho(&twin.numbers)));
        dot(own, own) > NEAR_HALF_A_TURN * NEAR_HALF_A_TURN && dot(own, other) < 0.0
    }

    /// What a number must be, from those of the turned state.
    fn seen_from(&self, twin: &Twin, quantity: Quantity, row: usize, place: usize) -> f64 {
        let Twin { rotation, spin, spin_rate, numbers, .. } = twin;
        let at = |row: usize, place: usize| numbers.at(quantity, row, place);
        let in_row = |row: usize| -> f64 {
            match quantity {
                Quantity::FirstDerivatives => turned(rotation, place).map(|(l, c)| c * at(row, l)).sum(),
                Quantity::SecondDerivatives => {
                    let lines = turned(rotation, place / DOFS);
                    let both = lines.flat_map(|(j, x)| {
                        turned(rotation, place % DOFS).map(move |(l, y)| (j * DOFS + l, x * y))
                    });
                    both.map(|(place, c)| c * at(row, place)).sum()
                }
                _ => at(row, place),
            }
        };
        let Some(start) = self.vector_of(row) else { return in_row(row) };
        // In the plane, which is turned about 3 alone, the others are zero.
        let there = |m: usize, x: f64| if self.equations.contains(&(start + m)) { x } else { 0.0 };
        let all = [0, 1, 2].map(|m| there(m, in_row(start + m)));
        let of = |quantity: Quantity| [0, 1, 2].map(|m| there(m, numbers.at(quantity, start + m, 0)));
        let carried = || add(of(Quantity::Value), self.offset(start));
        let seen = match quantity {
            Quantity::Value => sub(apply_transposed(rotation, carried()), self.offset(start)),
            Quantity::Rate => apply_transposed(rotation, sub(all, cross(*spin, carried()))),
            Quantity::Acceleration => {
                let relative = sub(all, scale(cross(*spin, of(Quantity::Rate)), 2.0));
                let relative = sub(relative, cross(*spin_rate, carried()));
                apply_transposed(rotation, add(relative, cross(*spin, cross(*spin, carried()))))
            }
            _ => apply_transposed(rotation, all),
        };
        seen[row - start]
    }

    /// What is allowed of the numbers of the turned state from which one is formed.
    fn allowed_of(&self, twin: &Twin, quantity: Quantity, row: usize, place: usize) -> f64 {
        let of = |quantity: Quantity| self.around(&twin.tolerance, quantity, row, place);
        let [spin, spin_rate] = [twin.spin, twin.spin_rate].map(size);
        match quantity {
            Quantity::Rate => of(quantity) + spin * of(Quantity::Value),
            Quantity::Acceleration => {
                of(quantity)
                    + 2.0 * spin * of(Quantity::Rate)
                    + (spin * spin + spin_rate) * of(Quantity::Value)
            }
            _ => of(quantity),
        }
    }

    /// What is allowed of all entries with which one is turned.
    fn around(&self, tolerance: &ByRow, quantity: Quantity, row: usize, place: usize) -> f64 {
        let rows = self.vector_of(row).map_or(row..row + 1, |start| start..start + 3);
        let of_row = |row: usize| -> f64 {
            match quantity {
                Quantity::FirstDerivatives => block(place).map(|l| tolerance.at(quantity, row, l)).sum(),
                Quantity::SecondDerivatives => {
                    let both =
                        block(place / DOFS).flat_map(|j| block(place % DOFS).map(move |l| j * DOFS + l));
                    both.map(|place| tolerance.at(quantity, row, place)).sum()
                }
                _ => tolerance.at(quantity, row, place),
            }
        };
        rows.filter(|row| self.equations.contains(row)).map(of_row).sum()
    }
}

impl MpcCase {
    fn evaluated(&self, state: &State<f64>) -> Evaluation<f64> {
        let (request, tally) = (Request::everything(2), &mut Tally::default());
        self.constraint.evaluate(state, &self.before, &self.turning, &request, tally)
    }

    /// What relates the numbers to each other; with mutants of them where `proves`.
    pub(super) fn laws(&self, tables: &[ResultTable], proves: bool) -> Vec<Check> {
        let laws = Laws::new(self, tables);
        let sizes = self.sizes();
        let size = |quantity: Quantity, place: usize| match quantity {
            Quantity::FirstDerivatives => sizes[place],
            Quantity::SecondDerivatives => sizes[place / DOFS] * sizes[place % DOFS],
            _ => 1.0,
        };
        // Equations that are on no singular set.
        let place = |_, row: usize, place: usize| {
            laws.equations.get(row).filter(|row| laws.nearness[**row] > 0.0).map(|row| (*row, place))
        };
        let (of, how) = ((&laws.given, tables), (self.name.as_str(), proves));
        checks_of_tables(&Self::LAWS, of, how, |law| laws.demands(law), place, size)
    }

    /// The sum that a law demands something of, by the words in which it is told.
    pub(crate) fn sum_of_law(&self, law: Invariant, what: &str) -> Option<f64> {
        let tables = self.judged();
        let laws = Laws::new(self, &tables);
        Demand::sum_of(laws.demands(law), what, &laws.given)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::verdict::Verdict;
    use crate::settings::{Planted, Settings};
    use pintle_kinematics::connector::Turns;
    use pintle_kinematics::draw::Draw;
    use pintle_kinematics::mpc::{Constraint, MpcType, Turning};
    use std::f64::consts::PI;

    /// Regions: anywhere, on another scale, far away, nodes that coincide initially, nodes that nearly meet, a constraint that holds but for
    /// rounding, nearly half a turn of violation, at rest.
    const REGIONS: usize = 8;

    fn drawn(kind: MpcType, region: usize, draw: &mut Draw) -> MpcCase {
        let mut three = |size: f64| [0; 3].map(|_| draw.between(-size, size));
        let length = if region == 1 { 1e-6 } else { 1.0 };
        let arm = if region == 3 { [0.0; 3] } else { three(length) };
        let far = if region == 2 { three(1e6) } else { [0.0; 3] };
        let common = three(2.0);
        let violation = match region {
            5 => [0.0; 3],
            6 => scale([2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0], PI - 1e-9),
            _ => three(1.0),
        };
        let displacement = match region {
            4 => sub(three(1e-4), arm),
            5 => [0.0; 3],
            _ => three(length),
        };
        let mut state = State::at_rest();
        state.master.rotation = exp(common);
        state.slave.rotation = product(&exp(violation), &state.master.rotation);
        state.master.displacement = far;
        state.slave.displacement = add(far, displacement);
        if region == 5 && kind == MpcType::Beam {
            let carried = apply(&state.master.rotation, arm);
            state.slave.displacement = sub(carried, arm);
        }
        if region != 7 {
            let rate = |draw: &mut Draw, j: usize| {
                let size = if block(j).start % 7 == 3 || j > PSI { 1.0 } else { length };
                draw.between(-3.0, 3.0) * size
            };
            state.velocity = std::array::from_fn(|j| rate(draw, j));
            state.acceleration = std::array::from_fn(|j| rate(draw, j));
        }
        if region.is_multiple_of(2) {
            state.angles = [Some(draw.between(-1.0, 1.0)), Some(draw.between(-1.0, 1.0))];
        }
        let axes = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
        MpcCase {
            name: format!("{} in region {region}", kind.name()),
            constraint: Constraint::new(kind, arm, [0.0; 3], axes).with_flow(),
            state,
            turning: Turning::none(),
            before: [Turns { turns: 0.0, principal: 0.0 }; 2],
            length,
        }
    }

    const PSI: usize = pintle_kinematics::mpc::PSI_M;

    /// Every law holds of every kind everywhere, and of the mutants of its numbers that change enough none survives.
    #[test]
    fn laws_hold_and_notice_mutants() {
        for kind in MpcType::ALL {
            let draw = &mut Draw::new(kind.name());
            for region in 0..2 * REGIONS {
                let case = drawn(kind, region % REGIONS, draw);
                let checks = case.laws(&case.tables(), region < REGIONS);
                // So near to its kink a LINK is not compared with itself turned.
                let is_near = kind == MpcType::Link && region % REGIONS == 4;
                assert_eq!(checks.len() + usize::from(is_near), MpcCase::LAWS.len(), "{}", case.name);
                for check in checks {
                    assert_eq!(
                        check.verdict,
                        Verdict::Pass,
                        "{}: {:?} {:?}",
                        case.name,
                        check.against,
                        check.worst
                    );
                    assert_eq!(check.score.survived, 0, "{}: {:?}", case.name, check.score.survivors);
                    let exercised = check.score.killed > 10 || region >= REGIONS - 1;
                    assert!(exercised, "{}: {:?} {}", case.name, check.against, check.score.killed);
                }
            }
        }
    }

    /// Tolerances that are a billion times too wide fail the self-test of the oracles, whatever passes within them.
    #[test]
    fn tolerances_that_are_too_wide_are_noticed() {
        let mut survivors = 0;
        for kind in MpcType::ALL {
            let draw = &mut Draw::new(kind.name());
            // Anywhere.
            let case = drawn(kind, 0, draw);
            for mut table in case.tables() {
                let right = table.check(true, &case.name, None);
                assert_eq!((right.verdict, right.score.survived), (Verdict::Pass, 0), "{}", case.name);
                table.entries.iter_mut().for_each(|entry| entry.scale *= 1e9);
                survivors += usize::from(table.check(true, &case.name, None).score.survived > 0);
            }
        }
        assert!(survivors >= 5 * MpcType::ALL.len() - 6, "{survivors}");
    }

    /// In each kind of number that a law speaks of, the wrong sign of the largest entry breaks it: what is wrong of the product breaks it as a
    /// mutant does.
    #[test]
    fn what_is_wrong_breaks_a_law() {
        let mut broken = 0;
        for kind in MpcType::ALL {
            let case = drawn(kind, 0, &mut Draw::new(kind.name()));
            let right = case.judged();
            for quantity in MpcCase::QUANTITIES {
                let mut tables = right.clone();
                let table = tables.iter_mut().find(|table| table.quantity == quantity).unwrap();
                let all = table.entries.iter_mut();
                let largest = all.max_by(|x, y| x.got.abs().total_cmp(&y.got.abs())).unwrap();
                if largest.got == 0.0 {
                    continue;
                }
                largest.got = -largest.got;
                let found: Vec<Verdict> =
                    case.laws(&tables, false).iter().map(|check| check.verdict).collect();
                assert!(found.contains(&Verdict::Wrong), "{}: {quantity:?} {found:?}", case.name);
                broken += 1;
            }
        }
        assert!(broken >= 26, "{broken}");
    }

    /// A fault planted in a kind of number is called wrong in that, and in no other kind.
    #[test]
    fn planted_faults_are_told() {
        for kind in MpcType::ALL {
            let case = drawn(kind, 0, &mut Draw::new(kind.name()));
            for (planted, quantity) in [
                (Planted::WrongValue, Quantity::Value),
                (Planted::WrongRate, Quantity::Rate),
                (Planted::WrongAcceleration, Quantity::Acceleration),
            ] {
                let settings = Settings { planted: Some(planted), ..Settings::default() };
                for check in case.audit(&settings, false) {
                    let is_wrong = check.verdict.is_mismatch();
                    let is_of_it = check.quantity == Some(quantity);
                    assert!(is_wrong == is_of_it || check.quantity.is_none(), "{}: {check:?}", case.name);
                }
            }
        }
    }

    /// A turn of everything is in the kernel of a BEAM and of ρ where they hold. Of nodes of a PIN that are apart it is not: their displacements are
    /// equal, not their positions.
    #[test]
    fn what_turns_with_everything() {
        let along = |kind: MpcType, region: usize| {
            let case = drawn(kind, region, &mut Draw::new("kernel"));
            let got = case.evaluated(&case.state);
            let State { slave, master, .. } = &case.state;
            let apart = add(case.constraint.arm(), sub(slave.displacement, master.displacement));
            let arm = cross(axis(2), apart);
            let sum = |row: &Dofs<f64>| row[THETA_S + 2] + row[THETA_M + 2] + dot(arm, part(row, XS));
            got.jacobian.iter().flatten().map(sum).fold(0.0_f64, |most, sum| most.max(sum.abs()))
        };
        assert!(
            along(MpcType::Beam, 5) < 1e-14 && along(MpcType::Pin, 5) > 0.1 && along(MpcType::Tie, 5) > 0.1
        );
        // As they do where nodes coincide initially, and the constraint holds.
        let coincident = |kind: MpcType| {
            let mut case = drawn(kind, 3, &mut Draw::new("kernel"));
            case.state.slave = case.state.master;
            let got = case.evaluated(&case.state);
            got.jacobian.iter().flatten().map(|row| (row[XS] + row[XM]).abs()).fold(0.0, f64::max)
        };
        assert!(coincident(MpcType::Pin) == 0.0 && coincident(MpcType::Tie) == 0.0);
        assert!(
            along(MpcType::Beam, 0) > 0.1
                && along(MpcType::Revolute, 0) > 0.1
                && along(MpcType::Link, 0) < 1e-14
        );
    }
}
