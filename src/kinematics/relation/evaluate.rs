//! What one relation gives at one state.

use crate::catalog::in_plane;
use crate::connector::{Output, Request, Tally};
use crate::mpc::turned;
use crate::relation::{Form, Point, Quantity, Relation, Share, Term, place_of};
use crate::scalar::elementary::norm;
use crate::scalar::{Duals, Scalar, Seeded};
use crate::so3;
use crate::vector;
use crate::vector::{
    Matrix, Vector, add, apply, apply_transposed, constant, cross, cross_real, dot_real, scale, sub,
};
use std::f64::consts::PI;

/// One equation at one state. What was not asked for is not there.
#[derive(Clone, Debug)]
pub struct ConstraintRow<R> {
    /// What must vanish.
    pub residual: R,
    /// Its rate.
    pub rate: Option<R>,
    /// The part of its acceleration that is quadratic in the rates.
    pub bias: Option<R>,
    /// Its acceleration.
    pub acceleration: Option<R>,
    /// Its derivatives by [`Relation::columns`]; empty where none were asked for.
    pub gradient: Vec<R>,
}

/// What moves a node: x, θ, Ψ, nilpotent.
type Moved<S> = [S; 7];

fn part<S: Copy>(of: &Moved<S>, at: usize) -> Vector<S> {
    [of[at], of[at + 1], of[at + 2]]
}

/// Σ f(n) over a range, by halves, so that rounding grows with the logarithm of the number.
fn total<S: Scalar>(range: std::ops::Range<usize>, f: &impl Fn(usize) -> Vector<S>) -> Vector<S> {
    const FEW: usize = 8;
    if range.len() <= FEW {
        return range.fold([S::zero(); 3], |sum, n| add(sum, f(n)));
    }
    let middle = range.start + range.len() / 2;
    add(total(range.start..middle, f), total(middle..range.end, f))
}

/// The rotations of S against M that are fixed, ρ by component; zero of those that are free.
fn rho<S: Scalar>(axes: &Matrix<S::Real>, fixed: &[bool; 6], q: &Matrix<S>) -> Vector<S> {
    let along = |i: usize, v: Vector<S>| dot_real(axes[i], v);
    let turned = |k: usize| apply(q, constant(axes[k]));
    let count = fixed[3..].iter().filter(|fixed| **fixed).count();
    let at = |wanted: bool| (0..3).find(|i| fixed[3 + i] == wanted).unwrap_or_default();
    match count {
        0 => [S::zero(); 3],
        1 => {
            let i = at(true);
            let [j, k] = [[1, 2], [0, 2], [0, 1]][i];
            let cosine = along(j, turned(k));
            let mut rho = [S::zero(); 3];
            rho[i] = if i == 1 { cosine } else { -cosine };
            rho
        }
        2 => {
            let k = at(false);
            // a × b = −(b × a), with the constant as the second factor.
            let across = cross_real(turned(k), axes[k]).map(|x| -x);
            [0, 1, 2].map(|i| if i == k { S::zero() } else { along(i, across) })
        }
        _ => {
            let log = so3::log(q);
            [0, 1, 2].map(|i| along(i, log))
        }
    }
}

impl<R: Duals> Relation<R> {
    /// q of a term, of a node that is moved.
    fn quantity<S: Scalar<Real = R>>(term: &Term<R>, node: &Point<R>, moved: &Moved<S>) -> S {
        match term.quantity {
            Quantity::Displacement => dot_real(term.axis, add(constant(node.displacement), part(moved, 0))),
            Quantity::Rotation => {
                let rotation = turned(&node.rotation, part(moved, 3));
                dot_real(term.axis, so3::continuous_log(&rotation, node.vector).phi)
            }
            Quantity::Angle => S::from_real(node.vector[term.component]) + moved[3 + term.component],
            Quantity::Flow => S::from_real(node.flow) + moved[6],
        }
    }

    /// What must vanish, for nodes moved by nilpotent amounts.
    fn residual<S: Scalar<Real = R>>(
        &self,
        nodes: &[Point<R>],
        moved: &impl Fn(usize) -> Moved<S>,
    ) -> Vec<S> {
        match &self.form {
            Form::Linear(terms) => {
                let sum = terms.iter().filter_map(|term| {
                    let q = Self::quantity(term, nodes.get(term.place)?, &moved(term.place));
                    Some(q.scale(term.factor))
                });
                vec![sum.fold(S::zero(), |sum, q| sum + q)]
            }
            Form::Carried { arm, axes, fixed } => {
                let [Some(slave), Some(master)] = [nodes.first(), nodes.get(1)] else { return Vec::new() };
                let [of_slave, of_master] = [moved(0), moved(1)];
                let body = turned(&master.rotation, part(&of_master, 3));
                let slip = sub(slave.displacement, master.displacement);
                let apart = add(constant(add(*arm, slip)), sub(part(&of_slave, 0), part(&of_master, 0)));
                let delta = sub(apply_transposed(&body, apart), constant(*arm));
                let rotation = turned(&slave.rotation, part(&of_slave, 3));
                let rho = rho(axes, fixed, &vector::transposed_product(&body, &rotation));
                let delta = [0, 1, 2].map(|i| dot_real(axes[i], delta));
                self.carried_rows().map(|i| if i < 3 { delta[i] } else { rho[i - 3] }).collect()
            }
            Form::Mean { lever, shares, axes, turns } => {
                let Some((master, others)) = nodes.split_first() else { return Vec::new() };
                let count = others.len().min(shares.len());
                let of_master = moved(0);
                let body = turned(&master.rotation, part(&of_master, 3));
                let at = |n: usize| add(constant(others[n].displacement), part(&moved(1 + n), 0));
                let mean = total(0..count, &|n| scale(at(n), shares[n].weight));
                let slip = sub(add(constant(master.displacement), part(&of_master, 0)), mean);
                let delta = sub(apply_transposed(&body, add(constant(*lever), slip)), constant(*lever));
                let lag = total(0..if turns.is_empty() { 0 } else { count }, &|n| {
                    let Share { weight, arm } = shares[n];
                    let seen = apply_transposed(&body, sub(add(constant(arm), at(n)), mean));
                    scale(cross_real(seen, arm), weight)
                });
                let equation = |i: usize| match axes.get(i) {
                    Some(axis) => dot_real(*axis, delta),
                    None => dot_real(turns[i - 3], lag),
                };
                self.mean_rows().map(equation).collect()
            }
        }
    }

    pub(crate) fn evaluate_any(
        &self,
        nodes: &[Point<R>],
        request: &Request,
        tally: &mut Tally,
    ) -> Vec<ConstraintRow<R>> {
        let zero = R::ZERO;
        let along = |accelerates: bool| {
            move |place: usize| -> Moved<R::Time> {
                std::array::from_fn(|j| {
                    let node = &nodes[place];
                    R::moving(zero, node.velocity[j], if accelerates { node.acceleration[j] } else { zero })
                })
            }
        };
        let wants = |wanted: &[Output]| request.outputs().any(|output| wanted.contains(&output));
        let mut rows: Vec<ConstraintRow<R>> = self
            .residual(nodes, &|_| [zero; 7])
            .into_iter()
            .map(|residual| ConstraintRow {
                residual,
                rate: None,
                bias: None,
                acceleration: None,
                gradient: Vec::new(),
            })
            .collect();
        tally.values += rows.len() as u64;
        if wants(&[Output::RESV, Output::RESA]) {
            tally.rates += rows.len() as u64;
            for (row, moving) in rows.iter_mut().zip(self.residual(nodes, &along(true))) {
                let (rate, acceleration) = R::rates(moving);
                (row.rate, row.acceleration) = (Some(rate), Some(acceleration));
            }
        }
        if wants(&[Output::RESB]) {
            tally.rates += rows.len() as u64;
            for (row, moving) in rows.iter_mut().zip(self.residual(nodes, &along(false))) {
                row.bias = Some(R::rates(moving).1);
            }
        }
        if request.order > 0 {
            tally.gradients += rows.len() as u64;
            self.differentiate(nodes, &mut rows);
        }
        rows
    }

    /// The derivatives of the residual by the degrees of freedom of two nodes, 0 and 1 of what is carried.
    fn by_two(&self, nodes: &[Point<R>]) -> Vec<[R; 12]> {
        type Seeds<R> = <R as Duals>::Gradient<12>;
        let seeded = |place: usize| -> Moved<Seeds<R>> {
            std::array::from_fn(|j| match j {
                0..6 if place < 2 => Seeds::<R>::seed(R::ZERO, 6 * place + j),
                _ => Seeds::<R>::zero(),
            })
        };
        self.residual(nodes, &seeded).into_iter().map(Seeded::gradient).collect()
    }

    /// The same by a rotation of one node.
    fn by_turn(&self, nodes: &[Point<R>], of: usize) -> Vec<Vector<R>> {
        type Seeds<R> = <R as Duals>::Gradient<3>;
        let seeded = |place: usize| -> Moved<Seeds<R>> {
            std::array::from_fn(|j| match j {
                3..6 if place == of => Seeds::<R>::seed(R::ZERO, j - 3),
                _ => Seeds::<R>::zero(),
            })
        };
        self.residual(nodes, &seeded).into_iter().map(Seeded::gradient).collect()
    }

    fn differentiate(&self, nodes: &[Point<R>], rows: &mut [ConstraintRow<R>]) {
        let zero = R::ZERO;
        match &self.form {
            Form::Linear(terms) => {
                let Some(row) = rows.first_mut() else { return };
                row.gradient = vec![zero; self.columns.len()];
                for term in terms {
                    let Some(node) = nodes.get(term.place) else { continue };
                    let (from, along) = match term.quantity {
                        Quantity::Displacement => (1, scale(term.axis, term.factor)),
                        Quantity::Rotation => (4, Self::of_rotation(term, node)),
                        Quantity::Angle => {
                            let own = |i| if i == term.component { term.factor } else { zero };
                            (4, [0, 1, 2].map(own))
                        }
                        Quantity::Flow => (10, [term.factor, zero, zero]),
                    };
                    for (i, entry) in (0_u8..).zip(along) {
                        if let Ok(at) = self.columns.binary_search(&(term.place, from + i)) {
                            row.gradient[at] = row.gradient[at] + entry;
                        }
                    }
                }
            }
            Form::Carried { .. } => {
                for (row, by) in rows.iter_mut().zip(self.by_two(nodes)) {
                    row.gradient = self
                        .columns
                        .iter()
                        .map(|(place, number)| by[6 * place + place_of(*number)])
                        .collect();
                }
            }
            Form::Mean { shares, axes, turns, .. } => {
                let Some(master) = nodes.first() else { return };
                let by_turn = self.by_turn(nodes, 0);
                for (i, (row, theta)) in self.mean_rows().zip(rows.iter_mut().zip(by_turn)) {
                    let mut gradient = Vec::with_capacity(self.columns.len());
                    let carried = |v: Vector<R>| apply(&master.rotation, v);
                    match turns.get(i.wrapping_sub(3)) {
                        Some(turn) => {
                            gradient.extend([zero; 3].into_iter().chain(theta));
                            for Share { weight, arm } in shares {
                                gradient.extend(scale(carried(cross(*arm, *turn)), *weight));
                            }
                        }
                        None => {
                            let axis = carried(axes[i.min(2)]);
                            gradient.extend(axis.into_iter().chain(theta));
                            for Share { weight, .. } in shares {
                                gradient.extend(scale(axis, -*weight));
                            }
                        }
                    }
                    if self.planar {
                        let all = (1..=6).chain((0..shares.len()).flat_map(|_| 1..=3));
                        let kept = gradient.into_iter().zip(all).filter(|(_, number)| in_plane(*number));
                        gradient = kept.map(|(entry, _)| entry).collect();
                    }
                    row.gradient = gradient;
                }
            }
        }
    }

    /// The derivatives of a term by the rotation of its node.
    fn of_rotation(term: &Term<R>, node: &Point<R>) -> Vector<R> {
        let zero = R::ZERO;
        type Seeds<R> = <R as Duals>::Gradient<3>;
        let seeded: Moved<Seeds<R>> = std::array::from_fn(|j| match j {
            3..6 => Seeds::<R>::seed(zero, j - 3),
            _ => Seeds::<R>::zero(),
        });
        scale(Self::quantity(term, node, &seeded).gradient(), term.factor)
    }
}

impl Relation<f64> {
    /// The size of what each residual is formed from: rounding of the nodes makes some part of it.
    ///
    /// - Of a length it is the largest of the lengths.
    /// - Of an angle it is 1 rad; of a mean rotation more where displacements exceed the arms.
    /// - Of an equation it is Σ |A q| with q of the whole node.
    pub fn sizes(&self, nodes: &[Point<f64>]) -> Vec<f64> {
        let largest = |of: &[f64]| of.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let moved = nodes.iter().fold(0.0, |most, node| largest(&node.displacement).max(most));
        match &self.form {
            Form::Linear(terms) => {
                let size = |term: &Term<f64>| {
                    let node = nodes.get(term.place)?;
                    let of_node = match term.quantity {
                        Quantity::Displacement => largest(&node.displacement),
                        Quantity::Rotation | Quantity::Angle => largest(&node.vector).max(1.0),
                        Quantity::Flow => node.flow.abs(),
                    };
                    Some(term.factor.abs() * of_node)
                };
                vec![terms.iter().filter_map(size).sum()]
            }
            Form::Carried { arm, .. } => {
                let of = |i: usize| if i < 3 { moved.max(largest(arm)) } else { 1.0 };
                self.carried_rows().map(of).collect()
            }
            Form::Mean { lever, shares, turns, .. } => {
                let arms = shares.iter().fold(largest(lever), |most, share| most.max(largest(&share.arm)));
                let turned = |turn: &Vector<f64>| {
                    let each = shares.iter().map(|share| share.weight * norm(cross(share.arm, *turn)));
                    (moved * each.sum::<f64>()).max(1.0)
                };
                self.mean_rows()
                    .map(|i| turns.get(i.wrapping_sub(3)).map_or(moved.max(arms), turned))
                    .collect()
            }
        }
    }

    /// How far the rotation of S against M is from half a turn (rad), where all of it is fixed: there ρ jumps.
    pub fn to_half_turn(&self, nodes: &[Point<f64>]) -> Option<f64> {
        let Form::Carried { fixed: [.., true, true, true], .. } = self.form else { return None };
        let [slave, master] = [nodes.first()?, nodes.get(1)?];
        let log = so3::log(&vector::transposed_product(&master.rotation, &slave.rotation));
        Some(PI - norm(log))
    }
}
