//! The bound: how far two right answers may be apart, from the conditioning of the state and nothing else.
//!
//! With s_j the size of degree of freedom j (1 rad, or the connector's length), u = 2⁻⁵³, f a function with rows ∂f and second
//! derivatives ∂²f,
//!
//! > F = |f| + Σ_k |∂f/∂q_k| s_k,  F₂ = F + Σ_jk |∂²f/∂q_j∂q_k| s_j s_k,
//!
//! | of | tolerance |
//! |---|---|
//! | a value | C u F |
//! | a first derivative | C u (F/s_j + Σ_k abs(∂²f/∂q_j∂q_k) s_k) + (C u/δ)² abs(∂f/∂q_j) |
//! | a second derivative | C u F₂/(s_j s_k) · max(1, 1/δ) |
//! | a rate | Σ_j tol_j abs(q̇_j) |
//! | nodal forces of a unit force, their derivatives | as a first and a second derivative; without the value in F where the force is not conjugate to the component |
//! | an acceleration | Σ_j tol_j abs(q̈_j) + C u F₂ max(1, 1/δ) max_j (q̇_j/s_j)² |
//!
//! Of somebody else's routine:
//!
//! - all of them are three times as large (`OF_OTHERS`);
//! - the entries of a row by the three displacements, or rotations, of a node have the tolerance of the largest (`in_blocks`).
//!
//! Third derivatives are not computed. Within the distance δ of a singular set, in radians or lengths, they are at most the second ones divided by
//! δ: Cauchy's estimate. Where C u is no small part of δ, rounding may bring the
//! state that much closer. A derivative that grows like 1/δ grows by `1/(1 − C u/δ)` more than its slope says. So do the tolerances
//! of all derivatives, by 2 at most. Beside a set rows are directions that a rounding turns by u/δ. At a symmetric state an entry
//! is an extremum, which changes by the square of that alone. On a set ∂f is the steepest of the derivatives on its sides, along
//! which rounding moves the value. Lengths enter only relative to s, so the verdict is the same in millimetres and metres and far
//! from the origin.

use crate::case::quantity::{Entries, Numbers, Quantity};
use pintle_kinematics::connector::State;
use pintle_kinematics::node::{DOFS, PSI_A, THETA_A, XB, dof_size};
use pintle_kinematics::scalar::U;
use pintle_kinematics::vector::{Matrix, transposed_product};

/// C, stated in every report: how many roundings of the conditioned scale are allowed. The worst ever measured over the
/// catalogue is in `verify/audit/mod.rs`.
pub const C: f64 = 4.0;

/// By how much larger the scales of somebody else's routine are. C u of F is what our formulas need on the triads given. Others form triads
/// themselves, of quaternions, vectors or products. Each of the two is a rotation to C u only. Its lengths enter a number as the rounding of that
/// does: e1a·e2b = −1 comes out as −1 + 9 u, and no turn moves it there.
pub(crate) const OF_OTHERS: f64 = 3.0;

/// The largest scale of a block for each of its entries. The entries of a row by the displacements, or rotations, of a node are one vector. Our
/// formulas form it along the axes in which it stands. Others form it elsewhere and turn it, so that its largest component rounds all three:
/// e3a × e3b/sin α is off by u/α along e3a, too, where no motion of the nodes moves it.
pub(crate) fn in_blocks(row: &mut [f64]) {
    for node in row.chunks_mut(XB) {
        for block in node.chunks_mut(THETA_A) {
            let is_known = block.iter().all(|x| !x.is_nan());
            let largest = block.iter().copied().fold(0.0, f64::max);
            block.fill(if is_known { largest } else { f64::NAN });
        }
    }
}

/// The conditioned scales of a function of n degrees of freedom: of its value, first and second derivatives (row by row), rate and
/// acceleration.
///
/// - `size` holds s_j;
/// - `input` holds the magnitudes of the numbers that are rounded, s_j but where a number is larger than that, as an angle of many
///   turns is;
/// - `rates` holds the velocities and accelerations;
/// - `nearness` is δ, 0 on a singular set.
pub fn scales(
    value: f64,
    first: &[f64],
    second: &[f64],
    (size, input): (&[f64], &[f64]),
    (velocity, acceleration): (&[f64], &[f64]),
    nearness: f64,
) -> [Vec<f64>; 5] {
    let n = size.len();
    let times = |row: &[f64], by: &[f64]| row.iter().zip(by).map(|(x, s)| x.abs() * s.abs()).sum::<f64>();
    let f = value.abs() + times(first, input);
    let bent: Vec<f64> = second.chunks(n.max(1)).map(|row| times(row, input)).collect();
    let f2 = f + times(&bent, input);
    let near = if nearness > 0.0 { (1.0 / nearness).max(1.0) } else { 1.0 };
    let closer = if nearness > 0.0 { 1.0 / (1.0 - (C * U / nearness).min(0.5)) } else { 1.0 };
    // Of a direction near a set, an extremum at a symmetric state, a rounding changes nothing to first order: to second, (C u/δ)² of it.
    let turned = if nearness > 0.0 { (C * U / nearness).min(0.5).powi(2) / (C * U) } else { 0.0 };
    let row: Vec<f64> = size
        .iter()
        .zip(&bent)
        .zip(first)
        .map(|((s, bent), first)| closer * (f / s + bent) + turned * first.abs())
        .collect();
    let near = closer * near;
    let matrix: Vec<f64> = size.iter().flat_map(|s| size.iter().map(move |t| near * f2 / s / t)).collect();
    let fastest = velocity.iter().zip(size).fold(0.0_f64, |most, (v, s)| most.max(v.abs() / s));
    let rate = times(&row, velocity);
    let faster = times(&row, acceleration) + near * f2 * fastest * fastest;
    [vec![f], row, matrix, vec![rate], vec![faster]]
}

/// How far a triad is from the nearest rotation (rad): half the largest sum of a row of |AᵀA − 1|. A routine may work on that one.
fn defect(triad: &Matrix<f64>) -> f64 {
    /// What is farther from a rotation was not rounded.
    const ROUNDED: f64 = 8.0 * U;
    let square = transposed_product(triad, triad);
    let row = |i: usize| (0..3).map(|j| (square[i][j] - f64::from(u8::from(i == j))).abs()).sum::<f64>();
    ((0..3).map(row).fold(0.0, f64::max) / 2.0).min(ROUNDED)
}

/// The scales of everything that is judged at one state. Tolerances are C u times them.
#[derive(Clone, Debug, Default)]
pub struct Bound {
    scale: Numbers<f64>,
    /// Whether it rests on numbers of 237 bits, which do not overflow.
    is_of_wide: bool,
    /// The size of lengths.
    length: f64,
}

impl Bound {
    /// From derivatives that are trusted: the wide oracle's, where it was asked.
    pub fn new(truth: &Numbers<f64>, state: &State<f64>, length: f64, nearness: f64) -> Self {
        Self::of_components(truth, state, length, &[nearness; 6])
    }

    /// The same with the nearness of each component to its own singular sets.
    pub fn of_components(truth: &Numbers<f64>, state: &State<f64>, length: f64, nearness: &[f64; 6]) -> Self {
        let size: [f64; DOFS] = std::array::from_fn(|j| dof_size(j, length));
        let skewed = [&state.pair.a.triad, &state.pair.b.triad].map(|triad| defect(triad) / (C * U));
        let input: [f64; DOFS] = std::array::from_fn(|j| {
            if (THETA_A..PSI_A).contains(&(j % XB)) { size[j] * (1.0 + skewed[j / XB]) } else { size[j] }
        });
        let (velocity, acceleration) = (&state.velocity, &state.acceleration);
        let mut of = Self { length, ..Self::default() };
        let mut scales: [Entries<f64>; Quantity::ALL.len()] = Default::default();
        for k in 0..6 {
            let Some(value) = truth.entries(Quantity::Value).get(k, 0) else { continue };
            let value = value * (1.0 + skewed[0] + skewed[1]);
            let of = |quantity: Quantity| -> Vec<f64> {
                (0..quantity.entries()).map(|i| truth.entries(quantity).get(k, i).unwrap_or(0.0)).collect()
            };
            let (first, second) = (of(Quantity::FirstDerivatives), of(Quantity::SecondDerivatives));
            let found =
                self::scales(value, &first, &second, (&size, &input), (velocity, acceleration), nearness[k]);
            for (scale, entries) in scales.iter_mut().zip(found) {
                scale.0[k] = Some(entries);
            }
        }
        for k in 0..6 {
            let of = |quantity: Quantity| truth.entries(quantity).0[k].as_deref();
            let Some(rows) = of(Quantity::NodalForces) else { continue };
            let changes = of(Quantity::GeometricStiffness).unwrap_or_default();
            // Where they are the rows of the component they round as those do: by its value too, which of an angle of many turns is all of them.
            let is_own = of(Quantity::FirstDerivatives) == Some(rows);
            let value = truth.entries(Quantity::Value).get(k, 0).filter(|_| is_own).unwrap_or(0.0);
            let still = ([0.0; DOFS], [0.0; DOFS]);
            let [_, row, matrix, ..] =
                self::scales(value, rows, changes, (&size, &input), (&still.0, &still.1), nearness[k]);
            scales[Quantity::NodalForces as usize].0[k] = Some(row);
            scales[Quantity::GeometricStiffness as usize].0[k] = Some(matrix);
        }
        for (quantity, scale) in Quantity::ALL.into_iter().zip(scales) {
            of.scale.set(quantity, scale);
        }
        of
    }

    /// The same for numbers of somebody else's routine: [`OF_OTHERS`] times as large, and of blocks ([`in_blocks`]).
    #[must_use]
    pub(crate) fn of_others(mut self, state: &State<f64>) -> Self {
        let rows = self.scale.entries(Quantity::FirstDerivatives).clone();
        for quantity in Quantity::ALL {
            let rates = match quantity {
                Quantity::Rate => Some(&state.velocity),
                Quantity::Acceleration => Some(&state.acceleration),
                _ => None,
            };
            let mut scales = self.scale.entries(quantity).clone();
            for (k, of) in scales.0.iter_mut().enumerate() {
                let Some(of) = of else { continue };
                if matches!(quantity, Quantity::FirstDerivatives | Quantity::NodalForces) {
                    in_blocks(of);
                }
                if let (Some(rates), Some(row)) = (rates, &rows.0[k]) {
                    // What the row has more, along the motion.
                    let mut blocks = row.clone();
                    in_blocks(&mut blocks);
                    let more = blocks.iter().zip(row).zip(rates).map(|((x, y), rate)| (x - y) * rate.abs());
                    let more: f64 = more.filter(|x| x.is_finite()).sum();
                    of.iter_mut().for_each(|x| *x += more);
                }
                of.iter_mut().for_each(|x| *x *= OF_OTHERS);
            }
            self.scale.set(quantity, scales);
        }
        self
    }

    /// The same from numbers of 237 bits, if so: what has no finite scale then is formed of numbers beyond the range of doubles.
    #[must_use]
    pub(super) fn of_wide(self, is_of_wide: bool) -> Self {
        Self { is_of_wide, ..self }
    }

    /// An entry times the sizes of the degrees of freedom by which it is a derivative: as large in millimetres as in metres.
    pub(super) fn sized(&self, quantity: Quantity, i: usize, entry: f64) -> f64 {
        entry * quantity.entry_size(i, self.length)
    }

    /// Whether an entry, which must be `want`, lies or is formed of numbers beyond the range of doubles.
    pub(super) fn overflows(&self, quantity: Quantity, k: usize, i: usize, want: f64) -> bool {
        self.is_of_wide && (want.is_infinite() || !self.scale(quantity, k, i).is_finite())
    }

    /// How far an entry may be from the truth, where that is known. Products of small numbers are rounded to multiples of 2⁻¹⁰⁷⁴.
    pub fn known(&self, quantity: Quantity, k: usize, i: usize) -> Option<f64> {
        /// 32 such roundings.
        const LEAST: f64 = f64::from_bits(32);
        let tolerance = C * U * self.scale.entries(quantity).get(k, i)?;
        Some(if tolerance < LEAST { LEAST } else { tolerance })
    }

    /// How far an entry may be from the truth.
    pub fn tolerance(&self, quantity: Quantity, k: usize, i: usize) -> f64 {
        self.known(quantity, k, i).unwrap_or(0.0)
    }

    /// The conditioned scale of an entry: the tolerance is C u times it.
    pub fn scale(&self, quantity: Quantity, k: usize, i: usize) -> f64 {
        self.scale.entries(quantity).get(k, i).unwrap_or(0.0)
    }
}
