//! What exists on a singular set: difference quotients from both sides, at steps that shrink, of all that is judged there.
//!
//! First derivatives, nodal forces and rates have a quotient from each side. Second derivatives, their likes of nodal forces and
//! accelerations have one second difference. It settles where they exist and grows as 1/h where first derivatives jump. It is
//! judged where it settles, and on the same number in other directions, unless a first derivative that it is formed of has two
//! sides.

use crate::case::quantity::{Entries, Numbers, Quantity};
use crate::judge::bound::Bound;
use crate::oracles::differences::{Directions, FIRST_STEP, SECOND_STEP};
use crate::oracles::truth::{Displaced, Truth};
use crate::singular::sides::Sides;
use pintle_kinematics::connector::Components;
use pintle_kinematics::measure::Unit;
use pintle_kinematics::node::{DOFS, dof_size};
use pintle_kinematics::scalar::{Scalar, Wide};

/// Steps that shrink, of second differences: half a fine one, that, and a coarse one.
const SECOND: [f64; 3] = [SECOND_STEP / 2.0, SECOND_STEP, Sides::COARSE];

/// The values behind and ahead, at three steps.
type Moved = [[Components<Wide>; 2]; 3];

impl Truth {
    /// Both sides of everything that is judged of the components on their singular sets.
    pub fn sides(&self, bound: &Bound) -> Numbers<Sides> {
        let is_singular = self.nearness_of_components().map(|near| near == 0.0);
        let mut found = Numbers::default();
        let mut set = |quantity: Quantity, mut sides: Entries<Sides>| {
            for (row, is_singular) in sides.0.iter_mut().zip(is_singular) {
                *row = row.take().filter(|_| is_singular);
            }
            found.set(quantity, sides);
        };
        let [mut first, forces] = self.both();
        self.share(&mut first);
        let [second, stiffness] = self.settled(bound, [&first, &forces]);
        let [rate, acceleration] = self.in_time(bound, &first, &second);
        for (quantity, sides) in [
            (Quantity::FirstDerivatives, first),
            (Quantity::NodalForces, forces),
            (Quantity::SecondDerivatives, second),
            (Quantity::GeometricStiffness, stiffness),
            (Quantity::Rate, rate),
            (Quantity::Acceleration, acceleration),
        ] {
            set(quantity, sides);
        }
        found
    }

    /// The size of what a component measures.
    fn extent(&self, k: usize) -> f64 {
        match self.connector().differentiated(k).map(|measure| measure.unit()) {
            Some(Unit::Length) => self.length(),
            _ => 1.0,
        }
    }

    /// First derivatives of what is measured, and of what forces are conjugate to, from both sides.
    fn both(&self) -> [Entries<Sides>; 2] {
        let functions = |at: &Displaced| {
            let values = self.values(at);
            [values, self.conjugates(at, &values)]
        };
        let still = functions(self.at_rest());
        let flat = Sides::known([Wide::zero(); 2]);
        let mut found = still.map(|values| Entries(values.map(|value| value.map(|_| vec![flat; DOFS]))));
        let columns: [Vec<usize>; 2] = [self.active().collect(), self.reach().collect()];
        for j in (0..DOFS).filter(|j| columns.iter().any(|columns| columns.contains(j))) {
            let steps = [FIRST_STEP / 2.0, FIRST_STEP, Sides::COARSE].map(|step| self.sized(j, step));
            let moved = steps.map(|h| [-h, h].map(|h| functions(&self.place(Self::along(j, h)))));
            for (n, entries) in found.iter_mut().enumerate().filter(|(n, _)| columns[*n].contains(&j)) {
                let moved: Moved = moved.map(|both| both.map(|functions| functions[n]));
                for (k, entries) in entries.0.iter_mut().enumerate() {
                    let (Some(entries), Some(still)) = (entries, still[n][k]) else { continue };
                    let scale = self.extent(k) / dof_size(j, self.length());
                    entries[j] = Sides::along(still, &of_component(&moved, k), &steps, scale).unwrap_or(flat);
                }
            }
        }
        found
    }

    /// Second derivatives where they settle; `first` are the sides of what they are formed of.
    fn settled(&self, bound: &Bound, first: [&Entries<Sides>; 2]) -> [Entries<Sides>; 2] {
        if first.into_iter().all(has_none) {
            let known = |of: &Entries<Wide>| of.map(|_, _, quotient| Sides::known([quotient; 2]).of_none());
            return self.second_on_a_set().each_ref().map(known);
        }
        let [half, coarse] =
            [SECOND[0], SECOND[2]].map(|step| self.second_at(true, (step, Directions::Together)));
        let quotients = [&half, self.second_on_a_set(), &coarse];
        let against = self.second_at(true, (SECOND_STEP, Directions::Against));
        let quantities = [Quantity::SecondDerivatives, Quantity::GeometricStiffness];
        [0, 1].map(|n| {
            let quantity = quantities[n];
            let [half, fine, coarse] = quotients.map(|of| &of[n]);
            half.map(|k, i, half| {
                let at = |of: &Entries<Wide>| of.get(k, i).unwrap_or_default();
                let scale = self.extent(k) / quantity.entry_size(i, self.length());
                let settles = Sides::of([half, at(fine), at(coarse)].map(|x| [x; 2]), scale);
                let of = if n == 0 { Quantity::FirstDerivatives } else { Quantity::NodalForces };
                let jumps = |j: usize| jumps(first[n], bound, (of, k, j));
                if jumps(i / DOFS) || jumps(i % DOFS) || has_none(first[n]) {
                    settles.of_none()
                } else {
                    settles.in_other_directions(at(&against[n]), scale)
                }
            })
        })
    }

    /// Rates from both sides along the motion, and accelerations where they settle and `second` derivatives are there to form them.
    fn in_time(&self, bound: &Bound, first: &Entries<Sides>, second: &Entries<Sides>) -> [Entries<Sides>; 2] {
        let speed = self.speed();
        let time = |step: f64| Wide::from_f64(if speed > 0.0 { step / speed } else { step });
        let still = self.values(self.at_rest());
        let moved = |steps: &[Wide; 3]| -> Moved {
            steps.map(|t| [-t, t].map(|t| self.values(&self.place(self.carried_on(t)))))
        };
        let steps = [FIRST_STEP / 2.0, FIRST_STEP, Sides::COARSE].map(time);
        let near = moved(&steps);
        let long = SECOND.map(time);
        let far = moved(&long);
        let (mut rate, mut acceleration) = (Entries::default(), Entries::default());
        for k in 0..6 {
            let has_function = self.connector().differentiated(k).is_some_and(|m| !m.has_nodal_rates());
            let Some(still) = still[k].filter(|_| has_function) else { continue };
            // Second derivatives are no measure here, as they would be in a bound.
            let scale = |order: i32| self.extent(k) * speed.powi(order);
            rate.0[k] = Sides::along(still, &of_component(&near, k), &steps, scale(1)).map(|s| vec![s]);
            let quotient = |n: usize| -> Option<Wide> {
                let [behind, ahead] = far[n];
                Some(((ahead[k]? - still) - (still - behind[k]?)) / (long[n] * long[n]))
            };
            let (Some(half), Some(fine), Some(coarse)) = (quotient(0), quotient(1), quotient(2)) else {
                continue;
            };
            let settles = Sides::of([half, fine, coarse].map(|x| [x; 2]), scale(2));
            let moves = |j: usize| {
                [&self.state().velocity, &self.state().acceleration]
                    .iter()
                    .any(|rates| rates[j] != Wide::zero())
            };
            let of = Quantity::FirstDerivatives;
            let jumps = (0..DOFS).any(|j| moves(j) && jumps(first, bound, (of, k, j)));
            let lacks = |i: usize| second.get(k, i).is_some_and(|sides| sides.exist != [true; 2]);
            let jumps = jumps || (0..DOFS * DOFS).any(|i| moves(i / DOFS) && moves(i % DOFS) && lacks(i));
            acceleration.0[k] =
                Some(vec![if jumps || has_none(first) { settles.of_none() } else { settles }]);
        }
        self.share(&mut rate);
        [rate, acceleration]
    }

    /// The components of a rotation vector jump together: on a side where one has no derivative, quotients of the others are of the opposite.
    fn share(&self, sides: &mut Entries<Sides>) {
        let Some(places) = self.misaligned() else { return };
        let count = sides.0[places[0]].as_ref().map_or(0, Vec::len);
        for i in 0..count {
            let of =
                |side: usize| places.iter().all(|k| sides.get(*k, i).is_none_or(|sides| sides.exist[side]));
            let exist = [of(0), of(1)];
            for k in places {
                if let Some(sides) = sides.0[k].as_mut().and_then(|entries| entries.get_mut(i)) {
                    sides.exist = exist;
                }
            }
        }
    }
}

/// Whether a first derivative has two sides.
fn jumps(first: &Entries<Sides>, bound: &Bound, (of, k, j): (Quantity, usize, usize)) -> bool {
    first.get(k, j).is_some_and(|sides| sides.differ(bound.tolerance(of, k, j)))
}

/// Whether a side of a first derivative lacks a derivative: then there is no gradient whose derivatives could be, of no component that shares
/// the set.
fn has_none(first: &Entries<Sides>) -> bool {
    first.iter().any(|(_, _, sides)| sides.exist != [true; 2])
}

/// The values of one component.
fn of_component(moved: &Moved, k: usize) -> [[Option<Wide>; 2]; 3] {
    moved.each_ref().map(|both| both.each_ref().map(|values| values[k]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::components::{Surroundings, judge};
    use crate::judge::verdict::Verdict;
    use crate::oracles::force::product_with_forces;
    use crate::oracles::oracle::{Oracle, WideAnswers};
    use crate::singular::atlas;
    use pintle_kinematics::catalog::ConnectionType;
    use pintle_kinematics::draw::Draw;
    use pintle_kinematics::measure::Measure;

    /// Coincident nodes of an AXIAL: its row, its nodal force and its rate have two sides. What lies between them may stand there, what
    /// lies outside is wrong; second derivatives do not exist.
    #[test]
    fn both_sides_decide_on_a_kink() {
        let axial = ConnectionType::named("AXIAL", None).unwrap();
        let mut case =
            atlas::near(&axial, Measure::Distance, 0.5, 0.0, &mut Draw::new("coincident")).unwrap();
        let step = case.path.last_mut().unwrap();
        let pair = &mut step.state.pair;
        pair.b.displacement = [0, 1, 2].map(|i| pair.a.displacement[i] - pair.reference[i]);
        let state = step.state;
        let numbers = product_with_forces(&case).unwrap();
        let truth = Truth::of(&case).unwrap();
        let answers = WideAnswers::of(&truth);
        let nearness = truth.nearness_of_components();
        assert_eq!(nearness[0], 0.0);
        let trusted = answers.trusted(&nearness.map(|near| near > 0.0));
        let bound = Bound::of_components(&trusted, &state, case.length, &nearness);
        let sides = truth.sides(&bound);
        let around = Surroundings::of(&case, &truth, &bound, Some(&sides));
        let verdict = |quantity: Quantity, spoil: &dyn Fn(f64) -> f64| {
            let got = numbers.entries(quantity).map(|_, _, x| spoil(x));
            let answer = answers.answer(Oracle::WideDifferences, quantity).unwrap();
            judge(quantity, &got, &answer, &around).verdict
        };
        let [first, forces, rate] = [Quantity::FirstDerivatives, Quantity::NodalForces, Quantity::Rate];
        for quantity in [first, forces, rate] {
            assert_eq!(verdict(quantity, &|x| x), Verdict::Kink, "{quantity:?}");
            assert_eq!(verdict(quantity, &|x| x + 7.0), Verdict::Wrong, "{quantity:?}");
        }
        for quantity in [Quantity::SecondDerivatives, Quantity::GeometricStiffness, Quantity::Acceleration] {
            assert_eq!(verdict(quantity, &|x| x), Verdict::Singular, "{quantity:?}");
        }
    }
}
