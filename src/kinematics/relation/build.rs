//! Relations from what a deck says.

use crate::catalog::in_plane;
use crate::relation::{Form, Quantity, Relation, Share, Term};
use crate::scalar::Real;
use crate::vector;
use crate::vector::{Vector, cross, dot, scale, sub};

/// Below this part of their spread squared, coupling nodes lie on one line.
const ON_A_LINE: f64 = 1e-12;

impl<R: Real> Relation<R> {
    /// A relation of this form.
    fn of(form: Form<R>) -> Self {
        let all =
            |place: usize, numbers: std::ops::RangeInclusive<u8>| numbers.map(move |number| (place, number));
        let columns = match &form {
            Form::Linear(terms) => {
                let zero = R::ZERO;
                let mut found = Vec::new();
                for term in terms {
                    let along = |from: u8| {
                        let is_along = |i: &u8| R::holds(zero.less(term.axis[usize::from(*i)].magnitude()));
                        (0..3).filter(is_along).map(move |i| (term.place, from + i))
                    };
                    match term.quantity {
                        Quantity::Displacement => found.extend(along(1)),
                        Quantity::Rotation => found.extend(all(term.place, 4..=6)),
                        Quantity::Angle => found.push((term.place, 4 + term.component as u8)),
                        Quantity::Flow => found.push((term.place, 10)),
                    }
                }
                found.sort_unstable();
                found.dedup();
                found
            }
            Form::Carried { fixed, .. } => {
                let turns = fixed[3..].contains(&true);
                let moves = fixed[..3].contains(&true);
                let slave = if moves { 1 } else { 4 }..=if turns { 6 } else { 3 };
                let master = if moves { 1 } else { 4 }..=6;
                all(0, slave).chain(all(1, master)).collect()
            }
            Form::Mean { shares, .. } => {
                all(0, 1..=6).chain((1..=shares.len()).flat_map(|place| all(place, 1..=3))).collect()
            }
        };
        Self { form, planar: false, columns }
    }

    /// The same in a two-dimensional model, whose nodes have the degrees of freedom 1, 2, 6 and 10: without δ3, ρ1 and ρ2, and the columns by
    /// x3, θ1 and θ2. Where the rotation about 3 is fixed, ρ3 is the angle θ_S − θ_M (rad, positive from 1 to 2). Of a mean
    /// ρ3 = Σ ŵ_n ((C_Mᵀ r_n) × R_n)_3 / Σ ŵ_n |R_n|², so that nodes on one line fix it, too.
    ///
    /// ```
    /// use pintle_kinematics::relation::Relation;
    /// let mean = Relation::<f64>::mean([0.0; 3], &[(1.0, [0.0; 3]), (1.0, [1.0, 0.0, 0.0])]).in_plane();
    /// assert_eq!(mean.rows().iter().map(|(name, _)| *name).collect::<Vec<_>>(), ["δ1", "δ2", "ρ3"]);
    /// assert_eq!(mean.columns(), [(0, 1), (0, 2), (0, 6), (1, 1), (1, 2), (2, 1), (2, 2)]);
    /// ```
    #[must_use]
    pub fn in_plane(self) -> Self {
        let mut form = self.form;
        match &mut form {
            Form::Linear(_) => {}
            Form::Carried { fixed, .. } => {
                let turns = fixed[5];
                fixed[3..].fill(turns);
            }
            Form::Mean { shares, turns, .. } => {
                let square = |share: &Share<R>| share.weight * dot(share.arm, share.arm);
                let about = shares.iter().map(square).fold(R::ZERO, |sum, part| sum + part);
                let z = [R::ZERO, R::ZERO, about.reciprocal_or_zero()];
                *turns = if turns.is_empty() { Vec::new() } else { vec![z] };
            }
        }
        let mut planar = Self { planar: true, ..Self::of(form) };
        planar.columns.retain(|(_, number)| in_plane(*number));
        planar
    }

    /// Σ A q = 0, of terms (place of the node, direction, degree of freedom from 0, A): 0 to 2 are displacements, 3 to 5 rotations, 6 flow.
    pub fn linear(terms: &[(usize, Vector<f64>, usize, f64)]) -> Self {
        let term = |(place, axis, at, factor): &(usize, Vector<f64>, usize, f64)| {
            let quantity = match at {
                0..3 => Quantity::Displacement,
                3..6 => Quantity::Rotation,
                _ => Quantity::Flow,
            };
            let axis = vector::exact(*axis);
            Term { place: *place, quantity, component: at % 3, axis, factor: R::from_f64(*factor) }
        };
        Self::of(Form::Linear(terms.iter().map(term).collect()))
    }

    /// The same, where rotations of nodes whose place is no member of `turning` are angles of their own.
    #[must_use]
    pub fn with_angles(self, turning: impl Fn(usize) -> bool) -> Self {
        let Form::Linear(mut terms) = self.form else { return self };
        for term in &mut terms {
            if term.quantity == Quantity::Rotation && !turning(term.place) {
                term.quantity = Quantity::Angle;
            }
        }
        Self::of(Form::Linear(terms))
    }

    /// S carried by M in the degrees of freedom that are fixed, along axes (rows) that are given initially.
    pub fn carried(
        slave: Vector<f64>,
        master: Vector<f64>,
        axes: [Vector<f64>; 3],
        fixed: [bool; 6],
    ) -> Self {
        let arm = sub(vector::exact::<R>(slave), vector::exact(master));
        Self::of(Form::Carried { arm, axes: axes.map(vector::exact), fixed })
    }

    /// M that moves with the weighted mean of nodes (weight, position). Weights count relative to each other; those of a cloud without weight
    /// are taken for equal.
    ///
    /// ```
    /// use pintle_kinematics::relation::Relation;
    /// let rows = |nodes: &[(f64, [f64; 3])]| Relation::<f64>::mean([0.0, 0.0, 1.0], nodes).rows().len();
    /// assert_eq!(rows(&[(1.0, [0.0; 3])]), 3);
    /// assert_eq!(rows(&[(1.0, [0.0; 3]), (1.0, [1.0, 0.0, 0.0])]), 5);
    /// assert_eq!(rows(&[(1.0, [0.0; 3]), (1.0, [1.0, 0.0, 0.0]), (2.0, [0.0, 1.0, 0.0])]), 6);
    /// ```
    pub fn mean(master: Vector<f64>, nodes: &[(f64, Vector<f64>)]) -> Self {
        let sum: f64 = nodes.iter().map(|(weight, _)| weight).sum();
        let weight = |given: f64| if sum > 0.0 { given / sum } else { 1.0 / nodes.len() as f64 };
        let centre = |from: Vector<f64>| {
            let arm = |i: usize| nodes.iter().map(|(w, x)| weight(*w) * (x[i] - from[i])).sum::<f64>();
            [from[0] + arm(0), from[1] + arm(1), from[2] + arm(2)]
        };
        // From near the nodes, so that far coordinates lose nothing.
        let first = nodes.first().map_or(master, |(_, x)| *x);
        let middle = centre(centre(first));
        let shares: Vec<Share<f64>> =
            nodes.iter().map(|(w, x)| Share { weight: weight(*w), arm: sub(*x, middle) }).collect();
        let turns = turns(&shares);
        let form = Form::Mean { lever: sub(master, middle), shares, axes: vector::identity(), turns };
        Relation { form, planar: false, columns: Vec::new() }.exact()
    }

    /// The same on another real number; exactly so from doubles.
    pub fn exact<S: Real>(&self) -> Relation<S>
    where
        R: Into<f64>,
    {
        let number = |x: R| S::from_f64(x.into());
        let exact = |v: Vector<R>| v.map(number);
        let exact = Relation::of(match &self.form {
            Form::Linear(terms) => {
                let term = |Term { place, quantity, component, axis, factor }: &Term<R>| Term {
                    place: *place,
                    quantity: *quantity,
                    component: *component,
                    axis: exact(*axis),
                    factor: number(*factor),
                };
                Form::Linear(terms.iter().map(term).collect())
            }
            Form::Carried { arm, axes, fixed } => {
                Form::Carried { arm: exact(*arm), axes: axes.map(exact), fixed: *fixed }
            }
            Form::Mean { lever, shares, axes, turns } => Form::Mean {
                lever: exact(*lever),
                shares: shares
                    .iter()
                    .map(|share| Share { weight: number(share.weight), arm: exact(share.arm) })
                    .collect(),
                axes: axes.map(exact),
                turns: turns.iter().map(|turn| exact(*turn)).collect(),
            },
        });
        if self.planar { exact.in_plane() } else { exact }
    }
}

/// T⁻¹ e for the axes e: the global ones, two across the line on which all nodes lie, or none where they coincide.
fn turns(shares: &[Share<f64>]) -> Vec<Vector<f64>> {
    let size = shares.iter().flat_map(|share| share.arm).fold(0.0_f64, |most, x| most.max(x.abs()));
    if size <= 0.0 {
        return Vec::new();
    }
    // Without dimension, so that nothing under- or overflows.
    let mut inertia = [[0.0; 3]; 3];
    for Share { weight, arm } in shares {
        let r = scale(*arm, 1.0 / size);
        let square = dot(r, r);
        for (i, row) in inertia.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry += weight * (if i == j { square } else { 0.0 } - r[i] * r[j]);
            }
        }
    }
    let trace = inertia[0][0] + inertia[1][1] + inertia[2][2];
    let [a, b, c] = inertia;
    let adjugate = [cross(b, c), cross(c, a), cross(a, b)];
    let determinant = dot(a, adjugate[0]);
    if determinant > ON_A_LINE * trace * trace * trace {
        // T is symmetric: its adjugate is so too.
        return adjugate.map(|column| scale(column, 1.0 / determinant / size / size)).to_vec();
    }
    let farthest =
        shares.iter().max_by(|one, other| dot(one.arm, one.arm).total_cmp(&dot(other.arm, other.arm)));
    let Some(line) = farthest.map(|share| scale(share.arm, 1.0 / size)) else { return Vec::new() };
    let least = (0..3).min_by(|i, j| line[*i].abs().total_cmp(&line[*j].abs())).unwrap_or_default();
    let mut unit = [0.0; 3];
    unit[least] = 1.0;
    let normal = |v: Vector<f64>| scale(v, 1.0 / dot(v, v).sqrt());
    let first = normal(cross(line, unit));
    let second = normal(cross(line, first));
    // Across the line T is half its trace.
    [first, second].map(|e| scale(e, 2.0 / trace / size / size)).to_vec()
}
