//! What the history of a connector decides: turn counts, sheets, accumulated one-forms.

use crate::connector::{Components, Connector, Mask, Row, Tally};
use crate::measure::{History, Measure, Section, Shared};
use crate::node;
use crate::node::{DOFS, Dependence, Pair, Relative};
use crate::scalar::{Duals, Real, Select};
use crate::so3;
use crate::vector;
use crate::vector::{Vector, add, dot, scale, sub};
use serde::{Deserialize, Serialize};

/// An angle as whole turns and a principal part: principal + 2π turns. Exact at any number of turns.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Turns<R> {
    /// The number of whole turns, an integer.
    pub turns: R,
    /// The principal angle in (−π, π] (rad).
    pub principal: R,
}

impl<R: Real> Select<R> for Turns<R> {
    #[inline(always)]
    fn pick(mask: R::Mask, yes: Self, no: Self) -> Self {
        Self {
            turns: R::select(mask, yes.turns, no.turns),
            principal: R::select(mask, yes.principal, no.principal),
        }
    }
}

/// What the states up to now decide about the next: committed once per state.
///
/// A `Branch<f64>` survives serialization bit for bit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Branch<R> {
    /// Turn counts of the components that wind; zero for the others.
    pub turns: [Turns<R>; 6],
    /// The last well-conditioned rotation vector of b's directions relative to a's, components along e_i^a (rad).
    pub rotation_vector: [R; 3],
    /// The sign of sin β on the sheet of the Euler angles: ±1.
    pub euler_sign: R,
    /// The torsion between the third directions, with its turns, where the directions midway between a and b depend on it.
    pub torsion: Turns<R>,
    /// What a one-form has accumulated (rad).
    pub accumulated: R,
    /// What the roundings of that sum left out, so that thousands of turns lose nothing: the value is the sum of the two.
    pub accumulated_rest: R,
}

/// What a state does to the nodes since the previous one: increments along which one-forms accumulate and turns are counted.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Increment<R> {
    /// Δθ of a and b, rotation vectors with C(new) = exp(Δθ^) C(old), whole turns included; global components (rad).
    pub rotation: [Vector<R>; 2],
    /// The whole turns in them: Δθ minus its principal part (rad).
    pub whole_turns: [Vector<R>; 2],
    /// ΔΨ of a and b (length).
    pub flow: [R; 2],
}

impl<R: Real> Increment<R> {
    /// No change.
    pub fn none() -> Self {
        let zero = [R::ZERO; 3];
        Self { rotation: [zero; 2], whole_turns: [zero; 2], flow: [R::ZERO; 2] }
    }
}

/// How far the choice between two equally near sheets leans to where the nodes turned. It is enough to outweigh rounding
/// at an increment of half a turn, and no more than to matter within some 3e-6 rad of it.
const LEAN: (i32, i32) = (1, 1_000_000);

impl<R: Duals> Connector<R> {
    /// Whether the history of these components depends on how the nodes turn: else [`Connector::follow`] does not read the increment.
    pub fn history_turns(&self, wanted: Mask) -> bool {
        self.follower().turns(wanted)
    }

    /// The one-form over the increment.
    pub(super) fn accumulation(&self, pair: &Pair<R>, increment: &Increment<R>) -> R {
        self.follower().accumulation(pair, increment)
    }

    pub(crate) fn follower(&self) -> Follower<'_, R> {
        Follower { rows: &self.kind.rows, section: &self.kind.section }
    }
}

/// What histories are decided by: the measures of a connector and what they refer to.
#[derive(Clone, Copy)]
pub(crate) struct Follower<'a, R> {
    pub(crate) rows: &'a Components<Row>,
    pub(crate) section: &'a Section<R>,
}

impl<R: Duals> Follower<'_, R> {
    /// [`Connector::history_turns`].
    fn turns(&self, wanted: Mask) -> bool {
        let rows = self.rows.iter().zip(wanted).filter(|(_, wanted)| *wanted);
        rows.filter_map(|(row, _)| row.as_ref()).any(|row| row.position.has_history())
    }

    /// [`Connector::follow`].
    pub(crate) fn follow(
        &self,
        pair: &Pair<R>,
        increment: &Increment<R>,
        branch: &Branch<R>,
        wanted: Mask,
        tally: &mut Tally,
    ) -> Branch<R> {
        let mut next = *branch;
        if !self.turns(wanted) {
            return next;
        }
        let is_followed = |k: usize| wanted[k] && self.rows[k].is_some();
        let (mut vector, mut euler, mut winds, mut torsion, mut one_form) =
            (false, false, false, false, false);
        for (row, _) in self.rows.iter().zip(wanted).filter(|(_, wanted)| *wanted) {
            let Some(Row { position, .. }) = row else { continue };
            vector |= matches!(position, Measure::RotationVector(_) | Measure::RotationVectorAtB(_));
            euler |= matches!(position, Measure::Euler(_));
            winds |= position.winds();
            torsion |= position.counts_torsion();
            one_form |= position.is_one_form();
        }
        let whole = sub(increment.whole_turns[1], increment.whole_turns[0]);
        let told = sub(sub(increment.rotation[1], increment.rotation[0]), whole);
        let still = [R::ZERO; 3];
        let turned = Dependence { rotation: true, ..Dependence::default() };
        let relative = pair.varied(turned, still, still, [R::ZERO; 2]);
        if vector {
            let carried = add(branch.rotation_vector, vector::apply_transposed(&pair.a.triad, whole));
            let lean = scale(vector::apply_transposed(&pair.a.triad, told), R::ratio(LEAN.0, LEAN.1));
            tally.histories += 1;
            let log = so3::continuous_log(&relative.q, add(carried, lean));
            // Near a whole turn the direction of φ says nothing: that of the history stands, with the angle of φ.
            let held = || {
                let (unit, length) = R::direction_and_norm(carried);
                let (_, angle) = R::direction_and_norm(log.phi);
                let backwards = dot(unit, log.phi).less(R::ZERO);
                let signed = R::choose(backwards, || -angle, || angle);
                R::choose(R::ZERO.less(length), || scale(unit, signed), || carried)
            };
            next.rotation_vector = R::choose(log.is_reference(), || log.phi, held);
        }
        if euler {
            // The sheet is that on which all of them move least.
            let told = [whole, told];
            let (same, distance) =
                self.wind(&relative, pair, told, branch, (branch.euler_sign, [true; 6]), tally);
            let (other, other_distance) =
                self.wind(&relative, pair, told, branch, (-branch.euler_sign, [true; 6]), tally);
            let chosen = R::choose(
                other_distance.less(distance),
                || (other, -branch.euler_sign),
                || (same, branch.euler_sign),
            );
            (next.turns, next.euler_sign) = chosen;
        } else if winds {
            // At a lock the third Cardan angle depends on where the first was before.
            let is_cardan =
                |k: usize| self.rows[k].is_some_and(|row| matches!(row.position, Measure::Cardan(_)));
            let together = (0..6).any(|k| is_followed(k) && is_cardan(k));
            let mask = [0, 1, 2, 3, 4, 5].map(|k| is_followed(k) || (together && is_cardan(k)));
            next.turns =
                self.wind(&relative, pair, [whole, told], branch, (branch.euler_sign, mask), tally).0;
        }
        if torsion {
            tally.histories += 1;
            let principal = so3::torsion(&relative.q);
            let axis = Measure::Torsion.winding_axis(pair);
            let along = |v: Vector<R>| axis.map_or(R::ZERO, |axis| dot(axis, v));
            next.torsion = nearest_turn(principal, &branch.torsion, along(whole), along(told)).0;
        }
        if one_form {
            tally.histories += 1;
            // The sum and its rounding error, exactly (Knuth's two-sum).
            let change = self.accumulation(pair, increment);
            let sum = branch.accumulated + change;
            let added = sum - branch.accumulated;
            let lost = (branch.accumulated - (sum - added)) + (change - added);
            next.accumulated = sum;
            next.accumulated_rest = branch.accumulated_rest + lost;
        }
        next
    }

    /// The turn counts nearest to the previous ones, and how far the angles moved in all.
    fn wind(
        &self,
        relative: &Relative<R>,
        pair: &Pair<R>,
        [whole, told]: [Vector<R>; 2],
        branch: &Branch<R>,
        (euler_sign, wanted): (R, Mask),
        tally: &mut Tally,
    ) -> ([Turns<R>; 6], R) {
        let history = History { euler_sign, ..branch.history() };
        let mut shared = Shared::new(relative, &pair.a.triad, self.section, &history);
        let mut turns = branch.turns;
        let mut moved = R::ZERO;
        for (k, row) in self.rows.iter().enumerate() {
            let Some(row) = row.filter(|row| wanted[k] && row.position.winds()) else { continue };
            tally.histories += 1;
            let evaluated = row.position.evaluate(&mut shared);
            let principal = row.position.unlocked(&relative.q, evaluated, branch.turns[3].principal);
            let previous = branch.turns[k];
            let axis = row.position.winding_axis(pair);
            let along = |v: Vector<R>| axis.map_or(R::ZERO, |axis| dot(axis, v));
            let (counted, change) = nearest_turn(principal, &previous, along(whole), along(told));
            turns[k] = counted;
            moved = moved + change.magnitude();
        }
        (turns, moved)
    }

    /// The one-form over the increment, at the midpoint direction: e3a(mid)·(Δθ_a − Δθ_b) − β_s ΔΨ_b.
    fn accumulation(&self, pair: &Pair<R>, increment: &Increment<R>) -> R {
        let [of_a, of_b] = increment.rotation;
        let back = so3::matrix(so3::exp_quaternion(scale(of_a, R::ratio(-1, 2))));
        let middle = vector::product(&back, &pair.a.triad);
        let form = Measure::FlowConversion.one_form(&middle, self.section);
        let mut change = [R::ZERO; DOFS];
        change[node::THETA_A..node::PSI_A].copy_from_slice(&of_a);
        change[node::THETA_B..node::PSI_B].copy_from_slice(&of_b);
        change[node::PSI_A] = increment.flow[0];
        change[node::PSI_B] = increment.flow[1];
        let mut sum = R::ZERO;
        for (row, change) in form.iter().zip(&change) {
            sum = sum + *row * *change;
        }
        sum
    }
}

impl<R: Real> Branch<R> {
    /// A branch that nothing has left.
    pub fn none() -> Self {
        let zero = R::ZERO;
        let turns = Turns { turns: zero, principal: zero };
        Self {
            turns: [turns; 6],
            rotation_vector: [zero; 3],
            euler_sign: R::integer(1),
            torsion: turns,
            accumulated: zero,
            accumulated_rest: zero,
        }
    }
}

impl<R: Copy> Branch<R> {
    /// What measures need to know of it.
    pub const fn history(&self) -> History<R> {
        History {
            rotation_vector: self.rotation_vector,
            euler_sign: self.euler_sign,
            torsion_turns: self.torsion.turns,
        }
    }
}

/// An angle with the number of turns that brings it nearest to where the previous one is after the `whole` turns of the nodes,
/// and how far it moved besides (rad). Where two numbers of turns are equally near, `told`, how far the nodes turned besides,
/// decides.
pub(crate) fn nearest_turn<R: Real>(principal: R, previous: &Turns<R>, whole: R, told: R) -> (Turns<R>, R) {
    let turn = R::pi() + R::pi();
    let lean = R::ratio(LEAN.0, LEAN.1);
    let change = principal - previous.principal - whole;
    let counted = ((change - (told + change * lean) * lean) / turn).nearest_integer();
    (Turns { turns: previous.turns - counted, principal }, change - counted * turn)
}
