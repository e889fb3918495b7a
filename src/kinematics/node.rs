//! Two nodes, what a measure sees of them, and how its variations map to nodal degrees of freedom.
//!
//! A connector joins node a (first) and node b (second). Each carries a triad of local directions as the columns of a matrix,
//! A and B. Measures are functions of the *relative* pair
//!
//! > d = Aᵀ(x_b − x_a),  Q = AᵀB, Q_ij = e_i^a · e_j^b,  Ψ_a, Ψ_b,
//!
//! so it is the relative pair that carries derivatives: three translations δ and three rotations ρ *along the global axes*,
//!
//! > d(δ) = Aᵀ(x_b − x_a + δ),  Q(ρ) = Aᵀ exp(ρ^) B,
//!
//! from which nodal rows, second derivatives and rates follow by constant maps ([`Pair::nodal_row`],
//! [`Pair::nodal_hessian`], [`Pair::relative_rates`]).
//!
//! Nodal degrees of freedom are x_a, θ_a, Ψ_a, x_b, θ_b, Ψ_b, in this order ([`DOF`] names them). Rotations vary
//! multiplicatively and spatially: C → exp(δθ^) C, so that θ̇ = ω and θ̈ = α at the state itself.

use crate::scalar::{Real, Scalar, each, unrolled};
use crate::vector;
use crate::vector::{Matrix, Vector, add, column, cross, cross_real, dot, dot_real, scale, skew, sub};
use serde::{Deserialize, Serialize};

/// The number of degrees of freedom of two nodes: translation, rotation and material flow of each.
pub const DOFS: usize = 14;

/// The name of each nodal degree of freedom, in their order: x translation (length), θ rotation (rad), Ψ material flow
/// (degree of freedom 10) (length).
pub const DOF: [&str; DOFS] =
    ["xa1", "xa2", "xa3", "θa1", "θa2", "θa3", "Ψa", "xb1", "xb2", "xb3", "θb1", "θb2", "θb3", "Ψb"];

/// The degree of freedom number of the manual (1 … 6, 10) of each entry of [`DOF`].
pub const DOF_NUMBER: [u8; DOFS] = [1, 2, 3, 4, 5, 6, 10, 1, 2, 3, 4, 5, 6, 10];

/// The size s_j of nodal degree of freedom j, in the order of [`DOF`]: 1 rad, or the connector's length.
pub fn dof_size(j: usize, length: f64) -> f64 {
    if matches!(j % 7, 3..=5) { 1.0 } else { length }
}

/// The first of the translations of node a in the order of [`DOF`].
pub const XA: usize = 0;
/// The first of the rotations of node a.
pub const THETA_A: usize = 3;
/// The material flow Ψa.
pub const PSI_A: usize = 6;
/// The first of the translations of node b.
pub const XB: usize = 7;
/// The first of the rotations of node b.
pub const THETA_B: usize = 10;
/// The material flow Ψb.
pub const PSI_B: usize = 13;

/// One node at one instant.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields, bound(serialize = "S: Serialize", deserialize = "S: Deserialize<'de>"))]
pub struct Node<S: Scalar> {
    /// U, the displacement from the reference position, global components (length).
    pub displacement: Vector<S>,
    /// The local directions e1, e2, e3 as columns, global components: C(φ) times the initial triad.
    pub triad: Matrix<S>,
    /// Ψ, the material flow, degree of freedom 10 (length).
    pub flow: S,
}

/// The two nodes of a connector at one instant, with X_b − X_a kept apart from the displacements, so that a model far from
/// the origin loses nothing.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(
    deny_unknown_fields,
    bound(
        serialize = "S: Serialize, S::Real: Serialize",
        deserialize = "S: Deserialize<'de>, S::Real: Deserialize<'de>"
    )
)]
pub struct Pair<S: Scalar> {
    /// X_b − X_a, global components (length).
    pub reference: Vector<S::Real>,
    /// The first node.
    pub a: Node<S>,
    /// The second node.
    pub b: Node<S>,
}

/// What a measure is a function of.
#[derive(Clone, Copy, Debug)]
pub struct Relative<S: Scalar> {
    /// d = Aᵀ(x_b − x_a): the position of b from a, components along e_i^a (length).
    pub d: Vector<S>,
    /// Q = AᵀB: Q_ij = e_i^a · e_j^b.
    pub q: Matrix<S>,
    /// Ψ_a and Ψ_b (length).
    pub flow: [S; 2],
    /// Aᵀρ, of which Q = exp((Aᵀρ)^) Q₀: the variation of Q as a rotation, components along e_i^a; `None` where it is not known.
    pub spin: Option<Vector<S>>,
}

/// What a measure depends on: the declared sparsity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Dependence {
    /// d.
    pub translation: bool,
    /// Q.
    pub rotation: bool,
    /// Ψ_a, Ψ_b.
    pub flow: bool,
}

impl Dependence {
    /// Whether it is d alone.
    pub(crate) const fn of_position(self) -> bool {
        self.translation && !self.rotation && !self.flow
    }

    /// Whether it is Q alone.
    pub(crate) const fn of_rotation(self) -> bool {
        !self.translation && self.rotation && !self.flow
    }

    /// What either depends on.
    pub const fn or(self, other: Self) -> Self {
        Self {
            translation: self.translation || other.translation,
            rotation: self.rotation || other.rotation,
            flow: self.flow || other.flow,
        }
    }
}

/// The first derivatives of a measure with respect to the relative variations, global components.
#[derive(Clone, Copy, Debug)]
pub struct RelativeGradient<R> {
    /// ∂f/∂δ.
    pub translation: [R; 3],
    /// ∂f/∂ρ.
    pub rotation: [R; 3],
    /// ∂f/∂Ψ_a and ∂f/∂Ψ_b.
    pub flow: [R; 2],
}

/// The time derivatives of the relative variations: δ̇, δ̈, ρ̇, ρ̈ and the flows', global components.
#[derive(Clone, Copy, Debug)]
pub struct RelativeRates<R> {
    /// (δ̇, δ̈) (length/time, length/time²).
    pub translation: [[R; 3]; 2],
    /// (ρ̇, ρ̈) (rad/time, rad/time²).
    pub rotation: [[R; 3]; 2],
    /// The first and second rates of Ψ_a and Ψ_b.
    pub flow: [[R; 2]; 2],
}

/// The rates of the nodal degrees of freedom, in the order of [`DOF`]: velocity v and spatial angular velocity ω, or
/// acceleration and spatial angular acceleration α.
pub type NodalRates<R> = [R; DOFS];

impl<S: Scalar> Pair<S> {
    /// x_b − x_a = (X_b − X_a) + (U_b − U_a), global components.
    #[inline(always)]
    pub fn separation(&self) -> Vector<S> {
        let change = sub(self.b.displacement, self.a.displacement);
        add(vector::constant(self.reference), change)
    }

    /// The relative pair. On dual numbers this differentiates with respect to whatever the nodes were seeded with.
    pub fn relative(&self) -> Relative<S> {
        Relative {
            d: vector::apply_transposed(&self.a.triad, self.separation()),
            q: vector::transposed_product(&self.a.triad, &self.b.triad),
            flow: [self.a.flow, self.b.flow],
            spin: None,
        }
    }
}

impl Pair<f64> {
    /// The same on another real number, exactly.
    pub fn exact<R: Real>(&self) -> Pair<R> {
        let node = |node: &Node<f64>| Node {
            displacement: vector::exact(node.displacement),
            triad: vector::exact_matrix(&node.triad),
            flow: R::from_f64(node.flow),
        };
        Pair { reference: vector::exact(self.reference), a: node(&self.a), b: node(&self.b) }
    }
}

impl<R: Real> Pair<R> {
    /// The relative pair moved by nilpotent variations: d = Aᵀ(x_b − x_a + δ), Q = Aᵀ exp(ρ^) B.
    ///
    /// The exponential is its own Taylor polynomial, exact to the order of `S`. Parts that are not `needed` are zero, and not
    /// computed.
    #[inline(always)]
    pub fn varied<S: Scalar<Real = R>>(
        &self,
        needed: Dependence,
        delta: Vector<S>,
        rho: Vector<S>,
        flow: [S; 2],
    ) -> Relative<S> {
        let (a, b) = (&self.a.triad, &self.b.triad);
        let mut q = [[S::zero(); 3]; 3];
        let mut d = [S::zero(); 3];
        if needed.rotation {
            for j in 0..3 {
                let direction = column(b, j);
                let mut turned = cross_real(rho, direction);
                let mut term = turned;
                for n in 2..=S::ORDER as i32 {
                    term = scale(cross(rho, term), R::ratio(1, n));
                    turned = add(turned, term);
                }
                for i in 0..3 {
                    q[i][j] = S::from_real(dot(column(a, i), direction)) + dot_real(column(a, i), turned);
                }
            }
        }
        if needed.translation {
            let separation = self.separation();
            for i in 0..3 {
                d[i] = S::from_real(dot(column(a, i), separation)) + dot_real(column(a, i), delta);
            }
        }
        let flow = [S::from_real(self.a.flow) + flow[0], S::from_real(self.b.flow) + flow[1]];
        Relative { d, q, flow, spin: Some(vector::apply_real_transposed(a, rho)) }
    }

    /// As [`Pair::varied`], with the variations numbered from `first` to `first` + N in the order δ, ρ, Ψ_a, Ψ_b as the N
    /// directions of the scalar, their derivatives written down rather than computed.
    ///
    /// `∂d_i/∂δ = e_i^a`; `∂Q_ij/∂ρ = e_j^b × e_i^a`; `∂²Q_ij/∂ρ_k∂ρ_l = ½(a_k b_l + a_l b_k) − δ_kl Q_ij` with `a = e_i^a`,
    /// `b = e_j^b`.
    #[inline(always)]
    pub fn seeded<S: crate::scalar::Seeded<N, Real = R>, const N: usize>(
        &self,
        needed: Dependence,
        first: usize,
    ) -> Relative<S> {
        let (a, b) = (&self.a.triad, &self.b.triad);
        let (zero, half) = (R::ZERO, R::ratio(1, 2));
        let none = const { [[R::ZERO; N]; N] };
        let mut d = [S::zero(); 3];
        if needed.translation {
            let separation = self.separation();
            each!(S, i < 3, {
                let direction = column(a, i);
                d[i] = S::assemble(dot(direction, separation), placed(first, 0, direction), none);
            });
        }
        let mut q = [[S::zero(); 3]; 3];
        let mut spin = [S::zero(); 3];
        if needed.rotation {
            each!(S, i < 3, {
                let of_a = column(a, i);
                spin[i] = S::assemble(zero, placed(first, 3, of_a), none);
                each!(S, j < 3, {
                    let of_b = column(b, j);
                    let value = dot(of_a, of_b);
                    let mut second = none;
                    if const { S::ORDER > 1 } {
                        each!(S, k < 3, {
                            each!(S, l < k + 1; 3, {
                                let product = of_a[k] * of_b[l];
                                let entry = if k == l {
                                    product - value
                                } else {
                                    of_a[l].multiply_add(of_b[k], product) * half
                                };
                                if first + N >= 6 && first <= 3 {
                                    second[3 - first + k][3 - first + l] = entry;
                                }
                            })
                        })
                    }
                    q[i][j] = S::assemble(value, placed(first, 3, cross(of_b, of_a)), second);
                })
            });
        }
        let one = R::integer(1);
        let flow = [
            S::assemble(self.a.flow, placed(first, 6, [one, zero, zero]), none),
            S::assemble(self.b.flow, placed(first, 6, [zero, one, zero]), none),
        ];
        Relative { d, q, flow, spin: Some(spin) }
    }

    /// The pair with its nodal degrees of freedom moved by nilpotent amounts: U + δx, exp(δθ^) C, Ψ + δΨ.
    ///
    /// Slower than [`Pair::varied`] by a factor of about 25 for a full Jacobian, and independent of the nodal maps: the
    /// tests' witness for them.
    pub fn moved<S: Scalar<Real = R>>(&self, dofs: &[S; DOFS]) -> Pair<S> {
        let node = |node: &Node<R>, at: usize| {
            let theta = [dofs[at + 3], dofs[at + 4], dofs[at + 5]];
            let turn = crate::so3::matrix(crate::so3::exp_quaternion(theta));
            let initial = [
                vector::constant(node.triad[0]),
                vector::constant(node.triad[1]),
                vector::constant(node.triad[2]),
            ];
            Node {
                displacement: add(
                    vector::constant(node.displacement),
                    [dofs[at], dofs[at + 1], dofs[at + 2]],
                ),
                triad: vector::product(&turn, &initial),
                flow: S::from_real(node.flow) + dofs[at + 6],
            }
        };
        Pair { reference: self.reference, a: node(&self.a, XA), b: node(&self.b, XB) }
    }

    /// The row of nodal first derivatives, in the order of [`DOF`], of a measure with the relative gradient `gradient`.
    ///
    /// From δ = δx_b − δx_a + D × δθ_a, ρ = δθ_b − δθ_a with D = x_b − x_a: [−g, g × D − h, ∂Ψ_a, g, h, ∂Ψ_b].
    #[inline(always)]
    pub fn nodal_row(&self, gradient: &RelativeGradient<R>) -> [R; DOFS] {
        let (g, h) = (gradient.translation, gradient.rotation);
        let arm = self.arm(gradient);
        let mut row = [R::ZERO; DOFS];
        for i in 0..3 {
            row[XA + i] = -g[i];
            row[THETA_A + i] = arm[i];
            row[XB + i] = g[i];
            row[THETA_B + i] = h[i];
        }
        row[PSI_A] = gradient.flow[0];
        row[PSI_B] = gradient.flow[1];
        row
    }

    /// The part of [`Pair::nodal_row`] by the rotation of a.
    #[inline(always)]
    pub(crate) fn arm(&self, gradient: &RelativeGradient<R>) -> Vector<R> {
        arm((gradient.translation, true), (gradient.rotation, true), self.separation())
    }

    /// The nodal second derivatives ∂²f/∂q_j∂q_k of a measure from its relative gradient and relative second derivatives
    /// (order δ, ρ, Ψ_a, Ψ_b).
    ///
    /// Besides Lᵀ H L, the second variations of the map: δ has −θ_a × (x_b − x_a variation) + ½ θ_a × (θ_a × D).
    /// Of ρ it is −½ θ_a × θ_b (Baker, Campbell and Hausdorff).
    ///
    /// Rows and columns of degrees of freedom that are not `active` are zero, and not computed.
    pub fn nodal_hessian(
        &self,
        gradient: &RelativeGradient<R>,
        relative: &[[R; 8]; 8],
        active: &[bool; DOFS],
    ) -> [[R; DOFS]; DOFS] {
        let zero = R::ZERO;
        let separation = self.separation();
        let block = |i: usize, j: usize| {
            let row = |k: usize| [relative[i + k][j], relative[i + k][j + 1], relative[i + k][j + 2]];
            [row(0), row(1), row(2)]
        };
        let (dd, dr, rr) = (block(0, 0), block(0, 3), block(3, 3));
        // θ_a enters δ as D × θ_a and ρ as −θ_a: the columns of H L and of Lᵀ H L that belong to it.
        let lever = skew(separation);
        let d_theta = difference(&vector::product(&dd, &lever), &dr);
        let r_theta = difference(&vector::product(&vector::transpose(&dr), &lever), &rr);
        let theta_theta = difference(&vector::transposed_product(&lever, &d_theta), &r_theta);

        let mut hessian = [[zero; DOFS]; DOFS];
        let mut put = |at: (usize, usize), block: &Matrix<R>, sign: i32| {
            let sign = R::integer(sign);
            for i in 0..3 {
                for j in 0..3 {
                    let entry = sign * block[i][j];
                    let (j, k) = (at.0 + i, at.1 + j);
                    if active[j] && active[k] {
                        hessian[j][k] = entry;
                        hessian[k][j] = entry;
                    }
                }
            }
        };
        put((XB, XB), &dd, 1);
        put((XA, XA), &dd, 1);
        put((XA, XB), &dd, -1);
        put((XB, THETA_B), &dr, 1);
        put((XA, THETA_B), &dr, -1);
        put((XB, THETA_A), &d_theta, 1);
        put((XA, THETA_A), &d_theta, -1);
        put((THETA_B, THETA_B), &rr, 1);
        put((THETA_B, THETA_A), &r_theta, 1);
        put((THETA_A, THETA_A), &theta_theta, 1);
        for (flow, of) in [(PSI_A, 6), (PSI_B, 7)] {
            let (d, r) = ([0, 1, 2].map(|i| relative[i][of]), [3, 4, 5].map(|i| relative[i][of]));
            let theta = sub(vector::apply_transposed(&lever, d), r);
            let mut put = |at: usize, entry: R| {
                if active[at] && active[flow] {
                    hessian[at][flow] = entry;
                    hessian[flow][at] = entry;
                }
            };
            for i in 0..3 {
                put(XA + i, -d[i]);
                put(XB + i, d[i]);
                put(THETA_A + i, theta[i]);
                put(THETA_B + i, r[i]);
            }
            put(PSI_A, relative[6][of]);
            put(PSI_B, relative[7][of]);
        }

        let (g, h) = (gradient.translation, gradient.rotation);
        if !active[THETA_A..PSI_A].contains(&true) {
            return hessian; // the map is linear in the other degrees of freedom
        }
        let mut add_symmetric = |j: usize, k: usize, amount: R| {
            if active[j] && active[k] {
                hessian[j][k] = hessian[j][k] + amount;
                hessian[k][j] = hessian[k][j] + amount;
            }
        };
        let half = R::ratio(1, 2);
        let (spin_g, spin_h) = (skew(g), skew(h));
        let along = dot(g, separation);
        for i in 0..3 {
            for j in 0..3 {
                let lever = spin_g[i][j];
                add_symmetric(THETA_A + i, XB + j, lever);
                add_symmetric(THETA_A + i, XA + j, -lever);
                add_symmetric(THETA_A + i, THETA_B + j, half * spin_h[i][j]);
                // Half of the symmetric entry, since both (i, j) and (j, i) are visited.
                let mut centripetal = half * half * (g[i] * separation[j] + g[j] * separation[i]);
                if i == j {
                    centripetal = centripetal - half * along;
                }
                add_symmetric(THETA_A + i, THETA_A + j, centripetal);
            }
        }
        hessian
    }

    /// The rates of the relative variations from those of the nodes.
    ///
    /// `δ̇ = v_b − v_a − ω_a × D`; `δ̈ = a_b − a_a − α_a × D − 2 ω_a × (v_b − v_a) + ω_a × (ω_a × D)`; `ρ̇ = w = ω_b − ω_a`;
    /// `ρ̈ = α_b − α_a − ω_a × w`. They are formed from differences of nodal rates, so that a common rigid motion cancels.
    pub fn relative_rates(&self, velocity: &NodalRates<R>, acceleration: &NodalRates<R>) -> RelativeRates<R> {
        let part = |rates: &NodalRates<R>, at: usize| [rates[at], rates[at + 1], rates[at + 2]];
        let separation = self.separation();
        let spin_a = part(velocity, THETA_A);
        let v = rate_difference(velocity, XA, XB);
        let w = rate_difference(velocity, THETA_A, THETA_B);
        let carried = cross(spin_a, separation);
        let first = sub(v, carried);
        let second = sub(
            sub(rate_difference(acceleration, XA, XB), cross(part(acceleration, THETA_A), separation)),
            sub(scale(cross(spin_a, v), R::integer(2)), cross(spin_a, carried)),
        );
        let turning = sub(rate_difference(acceleration, THETA_A, THETA_B), cross(spin_a, w));
        RelativeRates {
            translation: [first, second],
            rotation: [w, turning],
            flow: [[velocity[PSI_A], velocity[PSI_B]], [acceleration[PSI_A], acceleration[PSI_B]]],
        }
    }
}

/// Derivatives by N variations from number `first` on, of which three from number `at` on are given and the others zero.
#[inline(always)]
fn placed<R: Real, const N: usize>(first: usize, at: usize, three: Vector<R>) -> [R; N] {
    let mut all = const { [R::ZERO; N] };
    each!(R, i < N, {
        let variation = first + i;
        if variation >= at && variation < at + 3 {
            all[i] = three[variation - at];
        }
    });
    all
}

/// a − b.
fn difference<R: Real>(a: &Matrix<R>, b: &Matrix<R>) -> Matrix<R> {
    [sub(a[0], b[0]), sub(a[1], b[1]), sub(a[2], b[2])]
}

/// g × D − h, the derivatives by the rotation of a of a measure that turns with it, with what the measure has of g and h.
#[inline(always)]
pub(crate) fn arm<S: Scalar>(
    (g, has_g): (Vector<S>, bool),
    (h, has_h): (Vector<S>, bool),
    separation: Vector<S>,
) -> Vector<S> {
    match (has_g, has_h) {
        (true, true) => sub(cross(g, separation), h),
        (true, false) => cross(g, separation),
        (false, true) => [-h[0], -h[1], -h[2]],
        (false, false) => [S::zero(); 3],
    }
}

/// The row of a one-form that acts along a direction e carried by node a, on the rotation of a against that of b, and on the flow
/// at b: `e·(δθ_a − δθ_b) − β_s δΨ_b`. In the order of [`DOF`].
pub(crate) fn flow_conversion_row<S: Scalar>(direction: Vector<S>, scale_factor: S::Real) -> [S; DOFS] {
    let mut row = [S::zero(); DOFS];
    for i in 0..3 {
        row[THETA_A + i] = direction[i];
        row[THETA_B + i] = -direction[i];
    }
    row[PSI_B] = S::from_real(-scale_factor);
    row
}

/// The rotational rates of node a within [`NodalRates`].
pub(crate) fn spin_of_a<R: Real>(rates: &NodalRates<R>) -> Vector<R> {
    [rates[THETA_A], rates[THETA_A + 1], rates[THETA_A + 2]]
}

/// ω_b − ω_a and α_b − α_a.
pub(crate) fn relative_spin<R: Real>(
    velocity: &NodalRates<R>,
    acceleration: &NodalRates<R>,
) -> [Vector<R>; 2] {
    [velocity, acceleration].map(|rates| rate_difference(rates, THETA_A, THETA_B))
}

/// v_b − v_a and a_b − a_a.
pub(crate) fn relative_translation<R: Real>(
    velocity: &NodalRates<R>,
    acceleration: &NodalRates<R>,
) -> [Vector<R>; 2] {
    [velocity, acceleration].map(|rates| rate_difference(rates, XA, XB))
}

/// Three of the rates of b minus those of a.
fn rate_difference<R: Real>(rates: &NodalRates<R>, a: usize, b: usize) -> Vector<R> {
    sub([rates[b], rates[b + 1], rates[b + 2]], [rates[a], rates[a + 1], rates[a + 2]])
}
