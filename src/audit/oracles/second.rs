//! Second derivatives as differences of values on 237-bit numbers: of what the components measure, and of what their forces are
//! conjugate to.
//!
//! With h_j = s_j h, e_j + e_k a turn of a node by exp((h_j e_j + h_k e_k)^), and δ the distance to the nearest singular set where that is
//! less than 1,
//!
//! > ∂²f/∂q_j∂q_k = (f(h_j + h_k) − f(h_j) − f(h_k) + f(0))/(h_j h_k), h = 1e-21 δ,
//!
//! and the usual quotient where j = k (`differences::second_error` is what is left). On a singular set, where δ < 0.01, and far from the origin,
//!
//! > ∂²f/∂q_j∂q_k = (f(h_j + h_k) + f(−h_j − h_k) − f(h_j) − f(−h_j) − f(h_k) − f(−h_k) + 2 f(0))/(2 h_j h_k), h = 1e-18 √δ,
//!
//! with relative errors of about (h/δ)² = 1e-36/δ, and of rounding 1e-71/h² = 1e-35/δ. What has no function has a row, itself a difference
//! of what it accumulates: that row is differenced once more.

use crate::case::moved;
use crate::case::quantity::Entries;
use crate::oracles::differences::{self, Directions, SECOND_STEP};
use crate::oracles::truth::Truth;
use pintle_kinematics::catalog::Loading;
use pintle_kinematics::connector::{Branch, Components, Mask, NodalRow};
use pintle_kinematics::measure::Measure;
use pintle_kinematics::node::{self, DOFS, Node, Pair};
use pintle_kinematics::scalar::{Real, Scalar, Wide};
use pintle_kinematics::vector::{add, apply, dot, sub};

/// What is differenced at one place of the nodes.
struct Sample {
    pair: Pair<Wide>,
    branch: Branch<Wide>,
    value: Components<Wide>,
    conjugate: Components<Wide>,
}

impl Directions {
    /// The step of a degree of freedom, in parts of the common one.
    fn part(self, j: usize) -> Wide {
        match self {
            Self::Ahead | Self::Together => Wide::integer(1),
            Self::Against => Wide::ratio((DOFS + j) as i32, DOFS as i32),
        }
    }

    /// Which way the second of two moves where the first moves ahead.
    const fn second(self) -> i32 {
        match self {
            Self::Ahead | Self::Together => 1,
            Self::Against => -1,
        }
    }
}

/// How second differences are taken on a singular set.
const ON_A_SET: (f64, Directions) = (SECOND_STEP, Directions::Together);

/// Σ factor·sample, divided by `width`.
fn combined(terms: &[(i32, &Sample)], width: Wide) -> [Components<Wide>; 2] {
    let of = |part: fn(&Sample) -> &Components<Wide>| {
        std::array::from_fn(|k| {
            let mut sum = Wide::zero();
            for (factor, sample) in terms {
                sum += Wide::integer(*factor) * part(sample)[k]?;
            }
            Some(sum / width)
        })
    };
    [of(|sample| &sample.value), of(|sample| &sample.conjugate)]
}

/// Whether a degree of freedom turns its node.
const fn turns(j: usize) -> bool {
    matches!(j % 7, 3..=5)
}

/// The nodes moved along two degrees of freedom, from where each of them alone has led: a turn is computed again only where both turn
/// one node. With that of the samples whose nodes are turned as they are, where there is one.
fn together<'a>(
    still: &'a Sample,
    by: &NodalRow<Wide>,
    [(j, first), (l, second)]: [(usize, &'a Sample); 2],
) -> (Pair<Wide>, Option<&'a Sample>) {
    if j / 7 == l / 7 && turns(j) && turns(l) {
        return (moved(&still.pair, by), None);
    }
    let turned_alike = match (turns(j), turns(l)) {
        (true, true) => None,
        (true, false) => Some(first),
        (false, true) => Some(second),
        (false, false) => Some(still),
    };
    let still = &still.pair;
    let node = |of: fn(&Pair<Wide>) -> &Node<Wide>, start: usize| {
        let [here, one, other] = [of(still), of(&first.pair), of(&second.pair)];
        let is_turned = |i: usize| turns(i) && i / 7 == start / 7;
        let triad = if is_turned(j) {
            one.triad
        } else if is_turned(l) {
            other.triad
        } else {
            here.triad
        };
        let displacement = add(here.displacement, [by[start], by[start + 1], by[start + 2]]);
        Node { displacement, triad, flow: here.flow + by[start + 6] }
    };
    (
        Pair { reference: still.reference, a: node(|pair| &pair.a, 0), b: node(|pair| &pair.b, 7) },
        turned_alike,
    )
}

impl Truth {
    /// Second derivatives of what is measured, and, where forces are asked for, how the rows of virtual work change.
    pub fn second(&self, forces: bool) -> [Entries<Wide>; 2] {
        let way = differences::second(self.nearness(), self.far());
        if forces && way == ON_A_SET { self.second_on_a_set().clone() } else { self.second_at(forces, way) }
    }

    /// The same, forces and all, as they are taken on a singular set; computed once.
    pub fn second_on_a_set(&self) -> &[Entries<Wide>; 2] {
        self.on_a_set.get_or_init(|| self.second_at(true, ON_A_SET))
    }

    /// The same with a step, in sizes of the degrees of freedom.
    pub fn second_at(&self, forces: bool, (step, directions): (f64, Directions)) -> [Entries<Wide>; 2] {
        let connector = self.connector();
        let mut matrices: [Components<Vec<Wide>>; 2] = [
            self.empty(DOFS * DOFS),
            std::array::from_fn(|k| {
                (forces && connector.has_force(k)).then(|| vec![Wide::zero(); DOFS * DOFS])
            }),
        ];
        self.second_of_functions(forces, (step, directions), &mut matrices);
        for k in 0..6 {
            let is_form = connector.differentiated(k).is_some_and(|m| m.is_one_form());
            if let Some(matrix) = matrices[0][k].as_mut().filter(|_| is_form) {
                let columns: Vec<usize> = self.active().collect();
                self.change_of_row(
                    &columns,
                    (step, directions),
                    &|from, by| self.accumulated_from(from, by),
                    matrix,
                );
            }
            let Some(matrix) = matrices[1][k].as_mut() else { continue };
            let columns: Vec<usize> = self.reach().collect();
            match connector.connection().loading(k) {
                Some(Loading::AlongA(_) | Loading::FrozenAxis(_)) => {
                    // Moved nodes that have not turned have done no work on such a moment; what turns them is θ_b − θ_a.
                    let turns: Vec<usize> = columns.into_iter().filter(|j| turns(*j)).collect();
                    let work = |from: &Pair<Wide>, by: &NodalRow<Wide>| {
                        self.moment_axes[k].map_or_else(Wide::zero, |axis| {
                            let turned = |at: usize| [by[at], by[at + 1], by[at + 2]];
                            let more = sub(turned(node::THETA_B), turned(node::THETA_A));
                            dot(apply(&from.a.triad, axis), more)
                        })
                    };
                    self.change_of_row(&turns, (step, directions), &work, matrix);
                }
                Some(Loading::Conjugate)
                    if connector.position_measure(k).is_some_and(|m| m.is_one_form()) =>
                {
                    self.change_of_row(
                        &columns,
                        (step, directions),
                        &|from, by| self.accumulated_from(from, by),
                        matrix,
                    );
                }
                _ => {}
            }
        }
        matrices.map(Entries)
    }

    /// What is differenced where the nodes have moved. Of a sample whose nodes are turned alike the branch is the same, and so are the values
    /// that depend on turns alone.
    fn sample(
        &self,
        by: NodalRow<Wide>,
        pair: Pair<Wide>,
        turned_alike: Option<&Sample>,
        forces: bool,
    ) -> Sample {
        let Some(alike) = turned_alike.filter(|_| !self.is_reversible()) else {
            let at = self.place_anew(by, pair);
            let value = self.values_of(&at, self.functions());
            let conjugate = if forces { self.conjugates(&at, &value) } else { [None; 6] };
            return Sample { pair, branch: at.branch, value, conjugate };
        };
        let at = self.place_on(by, pair, alike.branch);
        let depends = self.depends_on_places();
        let functions = self.functions();
        let mut value = self.values_of(&at, [0, 1, 2, 3, 4, 5].map(|k| depends[k] && functions[k]));
        for (k, value) in value.iter_mut().enumerate().filter(|(k, _)| !depends[*k]) {
            *value = alike.value[k];
        }
        let conjugate = if forces { self.conjugates(&at, &value) } else { [None; 6] };
        Sample { pair, branch: at.branch, value, conjugate }
    }

    /// The components that measure a function: of any other the row is differenced, not the value.
    fn functions(&self) -> Mask {
        let connector = self.connector();
        [0, 1, 2, 3, 4, 5].map(|k| !connector.differentiated(k).is_some_and(Measure::is_one_form))
    }

    fn second_of_functions(
        &self,
        forces: bool,
        (step, directions): (f64, Directions),
        matrices: &mut [Components<Vec<Wide>>; 2],
    ) {
        let step = |j: usize| self.sized(j, step) * directions.part(j);
        let along = |j: usize, times: i32| Self::along(j, step(j) * Wide::integer(times));
        let both = |j: usize, l: usize, sign: i32| -> NodalRow<Wide> {
            let mut by = along(j, sign);
            by[l] = step(l) * Wide::integer(sign * directions.second());
            by
        };
        let pair = &self.state().pair;
        let still = self.sample([Wide::zero(); DOFS], *pair, None, forces);
        let sample_along = |j: usize, times: i32| {
            let by = along(j, times);
            self.sample(by, moved(pair, &by), (!turns(j)).then_some(&still), forces)
        };
        let alone = |j: usize| [1, -1].map(|sign| sample_along(j, sign));
        let active: Vec<usize> = self.active().collect();
        let reach: Vec<usize> = if forces { self.reach().collect() } else { Vec::new() };
        let columns: Vec<usize> = (0..DOFS).filter(|j| active.contains(j) || reach.contains(j)).collect();
        let mut put = |j: usize, l: usize, quotients: [Components<Wide>; 2]| {
            let parts = [&active, &reach].into_iter().zip(quotients).zip(matrices.iter_mut());
            for ((columns, entries), matrices) in parts {
                let has_both = columns.contains(&j) && columns.contains(&l);
                for (matrix, entry) in matrices.iter_mut().zip(entries).filter(|_| has_both) {
                    if let (Some(matrix), Some(entry)) = (matrix, entry) {
                        (matrix[j * DOFS + l], matrix[l * DOFS + j]) = (entry, entry);
                    }
                }
            }
        };
        let alone: Vec<(usize, [Sample; 2])> = columns.iter().map(|j| (*j, alone(*j))).collect();
        for (n, (j, [ahead, behind])) in alone.iter().enumerate() {
            let terms = match directions {
                Directions::Ahead | Directions::Together => [(1, ahead), (-2, &still), (1, behind)],
                Directions::Against => [(1, &sample_along(*j, 2)), (-2, ahead), (1, &still)],
            };
            put(*j, *j, combined(&terms, step(*j) * step(*j)));
            for (l, others) in alone.iter().skip(n + 1) {
                // Where the second one is as the first moves ahead, and as that moves back.
                let [other, other_behind] = match directions {
                    Directions::Ahead | Directions::Together => others.each_ref(),
                    Directions::Against => [&others[1], &others[0]],
                };
                let sample = |sign: i32, first: &Sample, second: &Sample| {
                    let by = both(*j, *l, sign);
                    let (pair, alike) = together(&still, &by, [(*j, first), (*l, second)]);
                    self.sample(by, pair, alike, forces)
                };
                let both_ahead = sample(1, ahead, other);
                let area = step(*j) * step(*l);
                if directions == Directions::Ahead {
                    let terms = [(1, &both_ahead), (-1, ahead), (-1, other), (1, &still)];
                    put(*j, *l, combined(&terms, area));
                    continue;
                }
                let terms = [
                    (1, &both_ahead),
                    (1, &sample(-1, behind, other_behind)),
                    (-1, ahead),
                    (-1, behind),
                    (-1, other),
                    (-1, other_behind),
                    (2, &still),
                ];
                put(*j, *l, combined(&terms, Wide::integer(2 * directions.second()) * area));
            }
        }
    }

    /// How the row of what is accumulated from a place on changes with the place: ∂ω_j/∂q_l in row j.
    fn change_of_row(
        &self,
        columns: &[usize],
        (step, directions): (f64, Directions),
        accumulated: &dyn Fn(&Pair<Wide>, &NodalRow<Wide>) -> Wide,
        matrix: &mut [Wide],
    ) {
        let step = |j: usize| self.sized(j, step);
        let pair = &self.state().pair;
        // What is accumulated along a degree of freedom, over the step in which that is.
        let rows = |from: &Pair<Wide>| -> Vec<Wide> {
            let along = |j: usize, h: Wide| accumulated(from, &Self::along(j, h));
            let of = |j: &usize| match directions {
                Directions::Ahead => along(*j, step(*j)) / step(*j),
                _ => (along(*j, step(*j)) - along(*j, -step(*j))) / (step(*j) + step(*j)),
            };
            columns.iter().map(of).collect()
        };
        let still = (directions == Directions::Ahead).then(|| rows(pair));
        for l in columns.iter().copied() {
            let at = |h: Wide| rows(&moved(pair, &Self::along(l, h)));
            let plus = at(step(l));
            let (minus, width) = match &still {
                Some(still) => (still.clone(), step(l)),
                None => (at(-step(l)), step(l) + step(l)),
            };
            for ((j, plus), minus) in columns.iter().zip(plus).zip(minus) {
                if let Some(entry) = matrix.get_mut(j * DOFS + l) {
                    *entry = (plus - minus) / width;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Extent, cases_drawn};
    use pintle_kinematics::catalog::TABLE;
    use pintle_kinematics::draw::Draw;

    /// What is taken from a sample whose nodes are turned alike is what is computed there, to the last bit.
    #[test]
    fn samples_turned_alike_share_what_depends_on_turns() {
        let mut shared = 0;
        for connection in TABLE.iter() {
            let cases =
                cases_drawn(connection, Extent::Full, &mut Draw::new(&format!("alike {}", connection.name)));
            for truth in cases.iter().step_by(3).filter_map(Truth::of) {
                let pair = &truth.state().pair;
                let of = |j: usize| {
                    let by = Truth::along(j, truth.sized(j, SECOND_STEP));
                    (by, truth.sample(by, moved(pair, &by), None, true))
                };
                let still = truth.sample([Wide::zero(); DOFS], *pair, None, true);
                let mut same = |by: NodalRow<Wide>, pair: Pair<Wide>, alike: &Sample| {
                    let (anew, found) =
                        (truth.sample(by, pair, None, true), truth.sample(by, pair, Some(alike), true));
                    assert_eq!(anew.branch, found.branch, "{}", connection.name);
                    assert_eq!(anew.value, found.value, "{}", connection.name);
                    assert_eq!(anew.conjugate, found.conjugate, "{}", connection.name);
                    shared += 1;
                };
                let (place, turn) = (of(8), of(4));
                same(place.0, place.1.pair, &still);
                let mut by = place.0;
                by[4] = turn.0[4];
                let (pair, alike) = together(&still, &by, [(8, &place.1), (4, &turn.1)]);
                assert!(alike.is_some_and(|alike| alike.pair.a.triad == turn.1.pair.a.triad));
                same(by, pair, &turn.1);
            }
        }
        assert!(shared > 300, "{shared}");
    }
}
