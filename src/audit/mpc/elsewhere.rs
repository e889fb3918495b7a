//! The same constraint by another formula than the one that is meant: at other nodes, with other angles, along other axes, with other
//! parameters of the rotation. Each with the cause that it is.

use crate::case::failing::MpcCase;
use crate::case::quantity::Quantity;
use crate::mpc::numbers_of;
use crate::mutants::diagnosis::{Cause, Hypothesis, MULTIPLES, PARAMETERS};
use pintle_kinematics::mpc::{
    Constraint, DOFS, Dofs, Evaluation, FLOW, MpcType, PHI, RHO, ROWS, Rows, State, THETA_M, THETA_S,
    Translation, XM,
};
use pintle_kinematics::so3;
use pintle_kinematics::vector::{
    Matrix, Vector, add, apply, apply_transposed, cross, dot, identity, product, scale, skew, sub, transpose,
};

/// Numbers of another formula.
pub(super) struct Elsewhere {
    cause: Cause,
    relation: String,
    numbers: [Vec<Vec<f64>>; MpcCase::QUANTITIES.len()],
}

impl Elsewhere {
    /// One that says something of these kinds of numbers.
    fn new(cause: Cause, relation: &str, got: &Evaluation<f64>, of: &[Quantity]) -> Self {
        let mut numbers: [Vec<Vec<f64>>; MpcCase::QUANTITIES.len()] = Default::default();
        for row in 0..ROWS {
            for ((quantity, into), numbers) in
                MpcCase::QUANTITIES.iter().zip(&mut numbers).zip(numbers_of(got, row))
            {
                into.push(if of.contains(quantity) { numbers } else { Vec::new() });
            }
        }
        Self { cause, relation: relation.to_string(), numbers }
    }

    /// What it makes of a quantity of these equations, of all and of those of one vector; what is none of it changes nothing.
    pub(super) fn of<'a>(
        &'a self,
        quantity: Quantity,
        equations: &'a [usize],
    ) -> impl Iterator<Item = Hypothesis> + 'a {
        [0..ROWS, 0..RHO, RHO..FLOW].into_iter().map(move |range| {
            let at = MpcCase::QUANTITIES.iter().position(|known| *known == quantity);
            let mut changes = Vec::new();
            for (place, equation) in equations.iter().enumerate().filter(|(_, row)| range.contains(row)) {
                let numbers = at.and_then(|at| self.numbers[at].get(*equation));
                let finite = numbers.into_iter().flatten().enumerate().filter(|(_, x)| x.is_finite());
                changes.extend(finite.map(|(i, x)| (place, i, *x)));
            }
            Hypothesis::many(self.cause, changes).related(self.relation.clone())
        })
    }
}

const VALUES: [Quantity; 1] = [Quantity::Value];
const ROWS_ALONE: [Quantity; 1] = [Quantity::FirstDerivatives];
const FIRST: [Quantity; 3] = [Quantity::Value, Quantity::FirstDerivatives, Quantity::Rate];
const BUT_SECOND: [Quantity; 4] =
    [Quantity::Value, Quantity::FirstDerivatives, Quantity::Rate, Quantity::Acceleration];
const RATES: [Quantity; 2] = [Quantity::Rate, Quantity::Acceleration];

/// The equations of a vector: δ where there are three, ρ.
fn vectors(got: &Evaluation<f64>) -> impl Iterator<Item = usize> {
    let has = |start: &usize| got.residual[*start..start + 3].iter().all(Option::is_some);
    [0, RHO].into_iter().filter(has).collect::<Vec<_>>().into_iter()
}

fn vector(of: &Rows<f64>, start: usize) -> Vector<f64> {
    [0, 1, 2].map(|i| of[start + i].unwrap_or(f64::NAN))
}

fn put(into: &mut Rows<f64>, start: usize, v: Vector<f64>) {
    into[start..start + 3].iter_mut().zip(v).for_each(|(entry, x)| *entry = Some(x));
}

/// The column of a vector's rows by a degree of freedom.
fn column(of: &Rows<Dofs<f64>>, start: usize, j: usize) -> Vector<f64> {
    [0, 1, 2].map(|i| of[start + i].map_or(f64::NAN, |row| row[j]))
}

fn put_column(into: &mut Rows<Dofs<f64>>, start: usize, j: usize, v: Vector<f64>) {
    for (row, x) in into[start..start + 3].iter_mut().zip(v) {
        if let Some(row) = row {
            row[j] = x;
        }
    }
}

/// The numbers of ρ alone.
fn of_rotations(got: &Evaluation<f64>) -> Evaluation<f64> {
    let mut alone = got.clone();
    for k in (0..RHO).chain([FLOW]) {
        (alone.residual[k], alone.jacobian[k], alone.residual_rate[k]) = (None, None, None);
    }
    alone
}

fn part(of: &Dofs<f64>, at: usize) -> Vector<f64> {
    [of[at], of[at + 1], of[at + 2]]
}

impl MpcCase {
    /// The same state and constraint, changed.
    fn changed(&self, change: impl FnOnce(&mut State<f64>, &mut Constraint<f64>)) -> Evaluation<f64> {
        let mut other = self.clone();
        change(&mut other.state, &mut other.constraint);
        other.said()
    }

    /// Other formulas, each with its numbers.
    pub(super) fn elsewhere(&self) -> Vec<Elsewhere> {
        let got = self.said();
        let mut found = self.other_states(&got);
        found.extend(self.other_axes(&got));
        found.extend(self.other_measures(&got));
        found.extend(self.other_rates(&got));
        found
    }

    /// At other nodes, or other angles of the hinges.
    fn other_states(&self, got: &Evaluation<f64>) -> Vec<Elsewhere> {
        let mut found = Vec::new();
        let with_kind = |kind: MpcType| {
            let axes = self.constraint.initial_axes().map(|axis| axis.unwrap_or([0.0, 0.0, 1.0]));
            Constraint::with_axes(kind, self.constraint.arm(), axes)
        };
        let all = MpcCase::QUANTITIES;
        let mut swapped = self.changed(|state, constraint| {
            std::mem::swap(&mut state.slave, &mut state.master);
            state.velocity[..PHI].rotate_left(XM);
            state.acceleration[..PHI].rotate_left(XM);
            let axes = constraint.initial_axes().map(|axis| axis.unwrap_or([0.0, 0.0, 1.0]));
            let other = Constraint::with_axes(constraint.kind(), scale(constraint.arm(), -1.0), axes);
            *constraint = if constraint.rows()[FLOW] { other.with_flow() } else { other };
        });
        swapped.jacobian.iter_mut().flatten().for_each(|row| row[..PHI].rotate_left(XM));
        let relation = "what is expected with S and M exchanged";
        found.push(Elsewhere::new(Cause::NodesSwapped, relation, &swapped, &BUT_SECOND));
        let hinges = self.constraint.kind().entry().angles.len();
        if hinges > 0 {
            for (cause, factor, relation) in [
                (Cause::Reversed, -1.0, "what is expected with −φ for φ"),
                (Cause::DegreesForRadians, 180.0 / std::f64::consts::PI, "what is expected with φ × 180/π"),
                (Cause::DegreesForRadians, std::f64::consts::PI / 180.0, "what is expected with φ × π/180"),
                (Cause::MotionIgnored, 0.0, "what is expected with φ left out"),
                (Cause::RotationHalved, 0.5, "what is expected with φ/2 for φ"),
                (Cause::RotationDoubled, 2.0, "what is expected with 2 φ for φ"),
            ] {
                let mut other = self.changed(|state, _| {
                    state.angles = got.taken.map(|angle| Some(factor * angle));
                    for of in [&mut state.velocity, &mut state.acceleration] {
                        of[PHI..].iter_mut().for_each(|x| *x *= factor);
                    }
                });
                other
                    .jacobian
                    .iter_mut()
                    .flatten()
                    .for_each(|row| row[PHI..].iter_mut().for_each(|x| *x *= factor));
                found.push(Elsewhere::new(cause, relation, &other, &BUT_SECOND));
                if factor != 0.0 {
                    // In the rotation alone.
                    let other =
                        self.changed(|state, _| state.angles = got.taken.map(|angle| Some(factor * angle)));
                    let relation = format!("{relation} in the rotation of the hinge, and nowhere else");
                    let of = [Quantity::FirstDerivatives, Quantity::Rate, Quantity::Acceleration];
                    found.push(Elsewhere::new(cause, &relation, &other, &of));
                }
            }
        }
        // One of two hinges alone.
        for (h, name) in ["φ1", "φ2"].into_iter().enumerate().take(if hinges == 2 { 2 } else { 0 }) {
            for (cause, factor, how) in [
                (Cause::MotionIgnored, 0.0, "left out"),
                (Cause::Reversed, -1.0, "of the other sign"),
                (Cause::RotationHalved, 0.5, "halved"),
            ] {
                let mut other = self.changed(|state, _| {
                    state.angles = got.taken.map(Some);
                    state.angles[h] = Some(factor * got.taken[h]);
                    for of in [&mut state.velocity, &mut state.acceleration] {
                        of[PHI + h] *= factor;
                    }
                });
                other.jacobian.iter_mut().flatten().for_each(|row| row[PHI + h] *= factor);
                let relation = format!("what is expected with {name} {how}");
                found.push(Elsewhere::new(cause, &relation, &other, &all));
            }
        }
        // An equation copied into the place of another.
        for start in vectors(got) {
            for (i, j) in [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)] {
                let mut other = got.clone();
                other.residual[start + i] = got.residual[start + j];
                other.jacobian[start + i] = got.jacobian[start + j];
                other.residual_rate[start + i] = got.residual_rate[start + j];
                other.residual_acceleration[start + i] = got.residual_acceleration[start + j];
                let name = if start == 0 { "δ" } else { "ρ" };
                let relation =
                    format!("what is expected with {name}{} in the place of {name}{}", j + 1, i + 1);
                found.push(Elsewhere::new(Cause::RowsSwapped, &relation, &other, &BUT_SECOND));
            }
        }
        for (name, is_master) in [("S", false), ("M", true)] {
            let other = self.changed(|state, _| {
                let body = if is_master { &mut state.master } else { &mut state.slave };
                body.rotation = identity();
            });
            let relation = format!("what is expected with the rotation of {name} left out");
            found.push(Elsewhere::new(Cause::MotionIgnored, &relation, &other, &VALUES));
        }
        // Of two hinges the angles, the axes, or both.
        let exchanged = [
            (
                Cause::OtherOrder,
                [true, true],
                "what is expected with C(φ1 a1) C(φ2 a2) for C(φ2 a2) C(φ1 a1)",
            ),
            (Cause::ParametersSwapped, [true, false], "what is expected with φ1 and φ2 exchanged"),
            (
                Cause::ParametersSwapped,
                [false, true],
                "what is expected with the axes of the hinges exchanged",
            ),
        ];
        for (cause, [angles, axes], relation) in exchanged.into_iter().filter(|_| hinges == 2) {
            let mut other = self.changed(|state, constraint| {
                if axes {
                    let [first, second] = constraint.initial_axes().map(|axis| axis.unwrap_or([0.0; 3]));
                    *constraint = Constraint::with_axes(constraint.kind(), constraint.arm(), [second, first]);
                }
                if angles {
                    state.angles = [got.taken[1], got.taken[0]].map(Some);
                    state.velocity.swap(PHI, PHI + 1);
                    state.acceleration.swap(PHI, PHI + 1);
                }
            });
            let mut of: &[Quantity] = &all;
            if angles {
                other.jacobian.iter_mut().flatten().for_each(|row| row.swap(PHI, PHI + 1));
                of = &BUT_SECOND;
            }
            found.push(Elsewhere::new(cause, relation, &other, of));
        }
        match self.constraint.kind().entry().translation {
            Translation::Carried => {
                let other = self.changed(|_, constraint| *constraint = with_kind(MpcType::Tie));
                let relation = "u_S − u_M: the arm X_S − X_M does not turn with M";
                // Of rows that is what is expected without the term of the arm.
                let others: Vec<Quantity> =
                    all.into_iter().filter(|of| *of != Quantity::FirstDerivatives).collect();
                found.push(Elsewhere::new(Cause::MotionIgnored, relation, &other, &others));
                found.extend(self.other_arms(got));
            }
            Translation::Equal => {
                let other = self.changed(|_, constraint| *constraint = with_kind(MpcType::Beam));
                let relation = "x_S − x_M − C_M (X_S − X_M): the initial separation turned with M";
                let mut other = other;
                // Of a PIN the rotations are none.
                if self.constraint.kind().entry().hinges.is_none() {
                    other.residual[RHO..].fill(None);
                }
                found.push(Elsewhere::new(Cause::InitialTurned, relation, &other, &all));
                let arm = self.constraint.arm();
                let moved = sub(self.state.slave.displacement, self.state.master.displacement);
                for (arm, relation) in [
                    (arm, "the row of a beam, with the term of the arm X_S − X_M as at first"),
                    (add(arm, moved), "the row of a beam, with the term of the arm x_S − x_M"),
                ] {
                    let mut other = got.clone();
                    for (row, axis) in other.jacobian[..RHO].iter_mut().zip(identity::<f64>()) {
                        if let Some(row) = row {
                            row[THETA_M..THETA_M + 3].copy_from_slice(&cross(axis, arm));
                        }
                    }
                    found.push(Elsewhere::new(Cause::InitialTurned, relation, &other, &ROWS_ALONE));
                }
            }
            _ => {}
        }
        found
    }

    /// The arm of a rigid beam, carried by the other node, with the other sign, or not carried in the rows.
    fn other_arms(&self, got: &Evaluation<f64>) -> [Elsewhere; 7] {
        const OF: [Quantity; 2] = [Quantity::Value, Quantity::FirstDerivatives];
        let only_moved = |mut other: Evaluation<f64>| {
            other.residual[RHO..].fill(None);
            other.jacobian[RHO..].fill(None);
            other.residual_rate[RHO..].fill(None);
            other
        };
        let transposed =
            only_moved(self.changed(|state, _| state.master.rotation = transpose(&state.master.rotation)));
        let mut by_slave = self.changed(|state, _| state.master.rotation = state.slave.rotation);
        for row in by_slave.jacobian[..RHO].iter_mut().flatten() {
            let of_master = part(row, THETA_M);
            row[THETA_S..THETA_S + 3].copy_from_slice(&of_master);
            row[THETA_M..THETA_M + 3].fill(0.0);
        }
        let by_slave = only_moved(by_slave);
        let mut reversed = got.clone();
        let carried = apply(&self.state.master.rotation, self.constraint.arm());
        put(&mut reversed.residual, 0, add(vector(&got.residual, 0), scale(carried, 2.0)));
        for row in reversed.jacobian[..RHO].iter_mut().flatten() {
            row[THETA_M..THETA_M + 3].iter_mut().for_each(|x| *x = -*x);
        }
        let mut at_first = self.changed(|state, _| state.master.rotation = identity());
        at_first.jacobian[RHO..].fill(None);
        let arm = self.constraint.arm();
        let State { slave, master, .. } = &self.state;
        let moved = sub(slave.displacement, master.displacement);
        // The arm is what the nodes are apart where the constraint holds, and there alone.
        let of_distance = "the row with x_S − x_M for the arm C_M (X_S − X_M)";
        let mut distance = got.clone();
        distance.jacobian[RHO..].fill(None);
        for (row, axis) in distance.jacobian[..RHO].iter_mut().zip(identity::<f64>()) {
            if let Some(row) = row {
                row[THETA_M..THETA_M + 3].copy_from_slice(&cross(axis, add(arm, moved)));
            }
        }
        let mut linearised = got.clone();
        linearised.residual[RHO..].fill(None);
        put(&mut linearised.residual, 0, sub(moved, cross(so3::log(&master.rotation), arm)));
        let of_first = "the row with the arm at first, X_S − X_M in place of C_M (X_S − X_M)";
        let relation = "x_S − x_M − C_S (X_S − X_M): the arm turns with S";
        let backwards = "x_S − x_M − C_Mᵀ (X_S − X_M): the arm turns the other way round";
        let spin = part(&self.state.velocity, THETA_M);
        let rate = sub(part(&self.state.velocity, 0), part(&self.state.velocity, XM));
        let mut of_rates = only_moved(got.clone());
        put(&mut of_rates.residual_rate, 0, sub(rate, cross(spin, add(arm, moved))));
        let of_distances = "ẋ_S − ẋ_M − ω_M × (x_S − x_M): the distance for the arm C_M (X_S − X_M)";
        [
            Elsewhere::new(Cause::TriadsTransposed, backwards, &transposed, &OF[..1]),
            Elsewhere::new(Cause::OtherLength, of_distances, &of_rates, &RATES[..1]),
            Elsewhere::new(Cause::InitialAxes, of_first, &at_first, &OF[1..]),
            Elsewhere::new(Cause::OtherLength, of_distance, &distance, &OF[1..]),
            Elsewhere::new(Cause::Linearised, "u_S − u_M − φ_M × (X_S − X_M)", &linearised, &OF[..1]),
            Elsewhere::new(Cause::LeverAtB, relation, &by_slave, &OF),
            Elsewhere::new(Cause::LeverReversed, "x_S − x_M + C_M (X_S − X_M)", &reversed, &OF),
        ]
    }

    /// Vectors along other axes, and axes of hinges that do not turn with M.
    fn other_axes(&self, got: &Evaluation<f64>) -> Vec<Elsewhere> {
        let mut found = Vec::new();
        let State { slave, master, velocity, acceleration, .. } = &self.state;
        for (cause, relation, body, theta) in [
            (Cause::AxesOfB, "what is expected along the axes of M", master, THETA_M),
            (Cause::AxesOfA, "what is expected along the axes of S", slave, THETA_S),
        ] {
            let mut other = got.clone();
            let local = |v: Vector<f64>| apply_transposed(&body.rotation, v);
            let (spin, spin_rate) = (part(velocity, theta), part(acceleration, theta));
            for start in vectors(got) {
                let v = vector(&got.residual, start);
                put(&mut other.residual, start, local(v));
                for j in 0..DOFS {
                    let axis = |i: usize| if j == theta + i { 1.0 } else { 0.0 };
                    let turned = cross([0, 1, 2].map(axis), v);
                    let along = sub(column(&got.jacobian, start, j), turned);
                    put_column(&mut other.jacobian, start, j, local(along));
                }
                let (rate, second) =
                    (vector(&got.residual_rate, start), vector(&got.residual_acceleration, start));
                put(&mut other.residual_rate, start, local(sub(rate, cross(spin, v))));
                let coriolis = add(scale(cross(spin, rate), 2.0), cross(spin_rate, v));
                let seen = add(sub(second, coriolis), cross(spin, cross(spin, v)));
                put(&mut other.residual_acceleration, start, local(seen));
            }
            other.hessian = Default::default();
            found.push(Elsewhere::new(cause, relation, &other, &MpcCase::QUANTITIES));
        }
        if !self.constraint.kind().entry().angles.is_empty() {
            // C_S [C(φ a0) C_M]ᵀ is what C_S C_Mᵀ violates at a master that does not turn.
            let relative = product(&slave.rotation, &transpose(&master.rotation));
            let mut other = self.changed(|state, _| {
                (state.slave.rotation, state.master.rotation) = (relative, identity());
                let of_master = apply(&relative, part(velocity, THETA_M));
                let spin = sub(part(velocity, THETA_S), of_master);
                state.velocity[THETA_S..THETA_S + 3].copy_from_slice(&spin);
                state.velocity[THETA_M..THETA_M + 3].fill(0.0);
            });
            for row in other.jacobian.iter_mut().flatten() {
                let of_master = scale(apply_transposed(&relative, part(row, THETA_S)), -1.0);
                row[THETA_M..THETA_M + 3].copy_from_slice(&of_master);
            }
            let relation = "what is expected with the initial axes of the hinges";
            found.push(Elsewhere::new(Cause::InitialAxes, relation, &other, &FIRST));
        }
        found
    }

    /// Another measure of a length or a rotation, and rows of other Jacobians.
    fn other_measures(&self, got: &Evaluation<f64>) -> Vec<Elsewhere> {
        let mut found = Vec::new();
        let arm = self.constraint.arm();
        let State { slave, master, .. } = &self.state;
        let moved = sub(slave.displacement, master.displacement);
        let apart = add(arm, moved);
        match self.constraint.kind().entry().translation {
            Translation::Distance => {
                let (l, first) = (dot(apart, apart).sqrt(), dot(arm, arm).sqrt());
                let of = |value: f64, slope: f64| {
                    let mut other = got.clone();
                    other.residual[0] = Some(value);
                    other.jacobian[0] = got.jacobian[0].map(|row| row.map(|x| slope * x));
                    other.residual_rate[0] = got.residual_rate[0].map(|x| slope * x);
                    other
                };
                let (squares, along) = (l * l - first * first, dot(moved, arm) / first);
                let (other, none) = (Cause::OtherLength, f64::NAN);
                for (cause, relation, value, slope) in [
                    (Cause::InitialKept, "|x_S − x_M|", l, 1.0),
                    (other, "|u_S − u_M|", dot(moved, moved).sqrt(), none),
                    (Cause::Linearised, "(u_S − u_M)·(X_S − X_M)/|X_S − X_M|", along, none),
                    (other, "(|x_S − x_M|² − |X_S − X_M|²) / 2", squares / 2.0, l),
                    (other, "|x_S − x_M|² − |X_S − X_M|²", squares, 2.0 * l),
                    (
                        other,
                        "(|x_S − x_M|² − |X_S − X_M|²) / (2 |X_S − X_M|)",
                        squares / (2.0 * first),
                        l / first,
                    ),
                    (other, "ln (|x_S − x_M| / |X_S − X_M|)", (l / first).ln(), 1.0 / l),
                    (other, "|x_S − x_M| / |X_S − X_M| − 1", l / first - 1.0, 1.0 / first),
                ] {
                    found.push(Elsewhere::new(cause, relation, &of(value, slope), &FIRST));
                }
                let mut still = got.clone();
                still.jacobian[0] = got.jacobian[0].map(|_| {
                    let mut row = [0.0; DOFS];
                    for (i, x) in arm.into_iter().enumerate() {
                        (row[i], row[XM + i]) = (x / first, -x / first);
                    }
                    row
                });
                let relation = "the row along the link at first, (X_S − X_M)/|X_S − X_M|";
                found.push(Elsewhere::new(Cause::Linearised, relation, &still, &ROWS_ALONE));
            }
            Translation::Carried | Translation::Equal => {
                let mut other = got.clone();
                put(&mut other.residual, 0, apart);
                found.push(Elsewhere::new(Cause::InitialKept, "x_S − x_M", &other, &VALUES));
            }
            Translation::Free => {}
        }
        if self.constraint.kind().entry().hinges.is_some() {
            found.extend(self.other_rotations(got));
        }
        found
    }

    /// Another vector of the rotation whose vector is ρ, and rows that belong to other Jacobians of it.
    fn other_rotations(&self, got: &Evaluation<f64>) -> Vec<Elsewhere> {
        let mut found = self.other_hinges(got);
        let rho = vector(&got.residual, RHO);
        let angle = dot(rho, rho).sqrt();
        let mut add_mapped = |cause: Cause, relation: &str, value: Option<f64>, map: &Matrix<f64>| {
            let mut other = of_rotations(got);
            if let Some(factor) = value {
                put(&mut other.residual, RHO, scale(rho, factor));
                put(&mut other.residual_rate, RHO, apply(map, vector(&got.residual_rate, RHO)));
            }
            for j in 0..DOFS {
                put_column(&mut other.jacobian, RHO, j, apply(map, column(&got.jacobian, RHO, j)));
            }
            let of: &[Quantity] = if value.is_some() { &FIRST } else { &ROWS_ALONE };
            found.push(Elsewhere::new(cause, relation, &other, of));
        };
        if angle > 1e-3 {
            for (relation, length) in PARAMETERS {
                let [f, slope, _] = length(angle);
                let n = scale(rho, 1.0 / angle);
                let across = f / angle;
                let map = [0, 1, 2].map(|i| {
                    [0, 1, 2].map(|j| {
                        let along = n[i] * n[j];
                        (slope - across) * along + if i == j { across } else { 0.0 }
                    })
                });
                add_mapped(Cause::OtherParameters, relation, Some(across), &map);
            }
        }
        let left = so3::left_jacobian(rho);
        let inverse = so3::inverse_left_jacobian(rho);
        for (relation, map) in [
            ("δθS − δθM − a δφ, the row where the constraint holds", left),
            ("the row of the right inverse Jacobian of ρ", product(&transpose(&inverse), &left)),
            ("the row of the inverse Jacobian of ρ to first order, 1 − ρ^/2", {
                let hat = skew(rho);
                let one: Matrix<f64> = identity();
                product(&[0, 1, 2].map(|i| sub(one[i], scale(hat[i], 0.5))), &left)
            }),
            ("the row of the Jacobian of ρ, not inverted", product(&left, &left)),
            ("the row of the transposed Jacobian of ρ, not inverted", product(&transpose(&left), &left)),
        ] {
            add_mapped(Cause::OtherJacobian, relation, None, &map);
        }
        let [of_s, of_m] = [&self.state.slave, &self.state.master].map(|body| so3::log(&body.rotation));
        let apart = sub(of_s, of_m);
        let turns = |axes: [Option<Vector<f64>>; 2]| {
            let along = axes.into_iter().zip(got.taken);
            along.fold([0.0; 3], |sum, (axis, angle)| add(sum, scale(axis.unwrap_or([0.0; 3]), angle)))
        };
        let initial = self.constraint.initial_axes();
        let carried = initial.map(|axis| axis.map(|axis| apply(&self.state.master.rotation, axis)));
        let has_angles = !self.constraint.kind().entry().angles.is_empty();
        let differences = [
            ("φ_S − φ_M, the difference of rotation vectors", apart),
            ("φ_S − φ_M − Σ φ a: rotation vectors added", sub(apart, turns(initial))),
            ("φ_S − φ_M − Σ φ C_M a: rotation vectors added", sub(apart, turns(carried))),
        ];
        for (relation, value) in differences.into_iter().take(if has_angles { 3 } else { 1 }) {
            let mut other = got.clone();
            put(&mut other.residual, RHO, value);
            found.push(Elsewhere::new(Cause::OtherParameters, relation, &other, &VALUES));
        }
        let axes = [got.axes, initial];
        for axes in axes.into_iter().take(if has_angles { 2 } else { 1 }) {
            let mut other = got.clone();
            for (i, row) in other.jacobian[RHO..FLOW].iter_mut().enumerate() {
                let mut small = [0.0; DOFS];
                (small[THETA_S + i], small[THETA_M + i]) = (1.0, -1.0);
                for (h, axis) in axes.into_iter().enumerate() {
                    small[PHI + h] = axis.map_or(0.0, |axis| -axis[i]);
                }
                *row = row.map(|_| small);
            }
            let relation = match has_angles {
                true => "δθS − δθM − Σ a δφ, the rows of small rotations",
                false => "δθS − δθM, the rows of small rotations",
            };
            found.push(Elsewhere::new(Cause::Linearised, relation, &other, &ROWS_ALONE));
        }
        found
    }

    /// Columns of the hinges by axes that are turned by less than they should be, or by the other node.
    fn other_hinges(&self, got: &Evaluation<f64>) -> Vec<Elsewhere> {
        let State { slave, master, .. } = &self.state;
        // ρ is of C_S [C_2 C_1 C_M]ᵀ: a spin of M along an axis changes it as a hinge about that axis does.
        let spun: Matrix<f64> = transpose(&[0, 1, 2].map(|i| column(&got.jacobian, RHO, THETA_M + i)));
        let hinges: Vec<Vector<f64>> = self.constraint.initial_axes().into_iter().flatten().collect();
        let mut found = Vec::new();
        // The column through the Jacobian of ρ, or without it.
        let mut add = |relation: &str,
                       cause: Cause,
                       through: Option<&Matrix<f64>>,
                       turned: &dyn Fn(Vector<f64>) -> Vector<f64>| {
            let mut other = of_rotations(got);
            for (h, axis) in hinges.iter().enumerate() {
                let axis = turned(*axis);
                let column = through.map_or_else(|| scale(axis, -1.0), |through| apply(through, axis));
                put_column(&mut other.jacobian, RHO, PHI + h, column);
            }
            found.push(Elsewhere::new(cause, relation, &other, &ROWS_ALONE));
        };
        let carried = |axis| apply(&master.rotation, axis);
        if !hinges.is_empty() {
            let relation = "the row with −a, as at the initial state, in the columns of the hinges";
            add(relation, Cause::Linearised, None, &|axis| axis);
            let relation = "the row with −C_M a, without the Jacobian of ρ, in the columns of the hinges";
            add(relation, Cause::OtherJacobian, None, &carried);
            let relation = "the row with the initial axes of the hinges in their columns";
            add(relation, Cause::InitialAxes, Some(&spun), &|axis| axis);
            let relation = "the row with axes of the hinges that turn with S in their columns";
            add(relation, Cause::AxesOfA, Some(&spun), &|axis| apply(&slave.rotation, axis));
        }
        if hinges.len() == 2 {
            let relation = "the row with the second hinge's axis not turned by the first in its column";
            add(relation, Cause::MotionIgnored, Some(&spun), &carried);
        }
        if hinges.len() == 2 {
            let mut swapped = of_rotations(got);
            swapped.jacobian.iter_mut().flatten().for_each(|row| row.swap(PHI, PHI + 1));
            let relation = "what is expected of each other in the columns of φ1 and φ2";
            found.push(Elsewhere::new(Cause::ColumnsSwapped, relation, &swapped, &ROWS_ALONE));
            let mut summed = of_rotations(got);
            for row in summed.jacobian.iter_mut().flatten() {
                (row[PHI], row[PHI + 1]) = (row[PHI] + row[PHI + 1], 0.0);
            }
            let relation = "what is expected of φ1 and φ2 together, in the column of φ1";
            found.push(Elsewhere::new(Cause::ColumnsSwapped, relation, &summed, &ROWS_ALONE));
        }
        found
    }

    /// J̇q̇ by parts: S turns against what M and the hinges carry, all turns with these, a length changes.
    fn quadratic_parts(&self, got: &Evaluation<f64>) -> Vec<(&'static str, Rows<f64>)> {
        let velocity = self.state.velocity;
        let bias = |velocity: Dofs<f64>| self.changed(|state, _| state.velocity = velocity).residual_bias;
        let rho = vector(&got.residual, RHO);
        let hinges = got.axes.into_iter().zip(&velocity[PHI..]);
        let carried = hinges.fold(part(&velocity, THETA_M), |spin, (axis, rate)| {
            add(spin, scale(axis.unwrap_or([0.0; 3]), *rate))
        });
        let with = apply(&so3::exp(rho), carried);
        let mut relative = [0.0; DOFS];
        relative[THETA_S..THETA_S + 3].copy_from_slice(&sub(part(&velocity, THETA_S), with));
        let together: Dofs<f64> = std::array::from_fn(|j| velocity[j] - relative[j]);
        let (of_relative, of_both) = (bias(relative), bias(together));
        let product =
            std::array::from_fn(|row| Some(got.residual_bias[row]? - of_relative[row]? - of_both[row]?));
        let mut found = vec![
            (
                "the part quadratic in the spin of S against what carries it: the rate of the Jacobian of ρ",
                of_relative,
            ),
            ("the part quadratic in what carries S: the axes of hinges turn, the arm of M does", of_both),
            ("the product of both: what carries S is seen from S", product),
        ];
        // S follows what carries it, and parts of that move.
        let following = |of_master: f64, rates: [f64; 2]| {
            let mut moved = [0.0; DOFS];
            for i in THETA_M..THETA_M + 3 {
                moved[i] = of_master * velocity[i];
            }
            let hinges = got.axes.into_iter().zip(&velocity[PHI..]).zip(rates);
            let spin = hinges
                .fold(scale(part(&velocity, THETA_M), of_master), |spin, ((axis, rate), times)| {
                    add(spin, scale(axis.unwrap_or([0.0; 3]), times * rate))
                });
            moved[THETA_S..THETA_S + 3].copy_from_slice(&apply(&so3::exp(rho), spin));
            for (i, times) in rates.into_iter().enumerate() {
                moved[PHI + i] = times * velocity[PHI + i];
            }
            bias(moved)
        };
        if got.axes[0].is_some() {
            let less = |x: &Rows<f64>, y: &Rows<f64>, z: &Rows<f64>| -> Rows<f64> {
                std::array::from_fn(|row| Some(x[row]? - y[row]? - z[row]?))
            };
            let (of_m, of_hinges) = (following(1.0, [0.0; 2]), following(0.0, [1.0; 2]));
            let mixed = less(&following(1.0, [1.0; 2]), &of_m, &of_hinges);
            found.push(("the product of the spin of M and the rates of the hinges", mixed));
            let [one, two] = [following(0.0, [1.0, 0.0]), following(0.0, [0.0, 1.0])];
            found.push((
                "the product of the rates of the two hinges, φ̇1 φ̇2 a1 × a2",
                less(&of_hinges, &one, &two),
            ));
        }
        if self.constraint.kind().entry().translation == Translation::Distance {
            let arm = self.constraint.arm();
            let apart = add(arm, sub(self.state.slave.displacement, self.state.master.displacement));
            let (length, first) = (dot(apart, apart).sqrt(), dot(arm, arm).sqrt());
            let of_first = |x: Option<f64>| x.map(|x| x - x * length / first);
            let mut only = |words: &'static str, x: Option<f64>| {
                let mut rows = Rows::default();
                rows[0] = x;
                found.push((words, rows));
            };
            let own = got.residual_rate[0].map(|rate| -rate * rate / length);
            let all = got.residual_bias[0];
            only("−l̇²/l", own);
            only("|v|²/l", all.zip(own).map(|(all, own)| all - own));
            only(
                "the current length, not the initial one, in the part quadratic in the rates",
                of_first(all),
            );
        }
        found
    }

    /// Rates of other velocities, and accelerations with another part quadratic in them.
    fn other_rates(&self, got: &Evaluation<f64>) -> Vec<Elsewhere> {
        let mut found = Vec::new();
        let along = |rates: &Dofs<f64>| -> Rows<f64> {
            got.jacobian.map(|row| row.map(|row| row.iter().zip(rates).map(|(x, rate)| x * rate).sum()))
        };
        let (linear, crossed) = (along(&self.state.acceleration), along(&self.state.velocity));
        let bias: Rows<f64> = std::array::from_fn(|row| Some(got.residual_acceleration[row]? - linear[row]?));
        let combined = |part: f64, of_bias: f64| {
            let mut other = got.clone();
            other.residual_acceleration =
                std::array::from_fn(|row| Some(part * linear[row]? + of_bias * bias[row]?));
            other
        };
        let of = &[Quantity::Acceleration];
        let cause = Cause::LinearPartMissing;
        found.push(Elsewhere::new(cause, cause.relation(), &combined(0.0, 1.0), of));
        for factor in [2.0, 0.5, -1.0] {
            let cause = Cause::QuadraticPartDoubled;
            let relation = format!("what is expected with {factor} × the part quadratic in the rates");
            found.push(Elsewhere::new(cause, &relation.replace('-', "−"), &combined(1.0, factor), of));
        }
        for (words, part) in self.quadratic_parts(got) {
            for (times, what) in MULTIPLES {
                let mut other = got.clone();
                for (row, part) in other.residual_acceleration.iter_mut().zip(&part) {
                    *row =
                        row.zip(*part).filter(|(_, part)| *part != 0.0).map(|(all, part)| all + times * part);
                }
                let relation = format!("what is expected {what} {words}");
                found.push(Elsewhere::new(Cause::Coriolis, &relation, &other, of));
            }
        }
        let mut other = got.clone();
        (other.residual_rate, other.residual_acceleration) = (linear, crossed);
        let cause = Cause::RateForAcceleration;
        found.push(Elsewhere::new(cause, cause.relation(), &other, &RATES));
        if !self.constraint.kind().entry().angles.is_empty() {
            let other = self.changed(|state, _| {
                state.velocity[PHI..].fill(0.0);
                state.acceleration[PHI..].fill(0.0);
            });
            let relation = "what is expected without the rates of φ";
            found.push(Elsewhere::new(Cause::MotionIgnored, relation, &other, &RATES));
        }
        for forth in [false, true] {
            let other = self.changed(|state, _| {
                for (body, theta) in [(state.slave, THETA_S), (state.master, THETA_M)] {
                    for of in [&mut state.velocity, &mut state.acceleration] {
                        let spin = part(of, theta);
                        let turned = if forth {
                            apply(&body.rotation, spin)
                        } else {
                            apply_transposed(&body.rotation, spin)
                        };
                        of[theta..theta + 3].copy_from_slice(&turned);
                    }
                }
            });
            let cause = Cause::BodyRates;
            found.push(Elsewhere::new(cause, cause.relation(), &other, &RATES));
        }
        found
    }
}
