//! Rows derived by hand, for the types whose formulas the manual prints.
//!
//! With d = x_b − x_a, w = δθ_b − δθ_a and spatial variations δe_i = δθ × e_i:
//!
//! - δ(e_i^a·d) = e_i^a·(δx_b − δx_a) + δθ_a·(e_i^a × d), since (δθ_a × e)·d = δθ_a·(e × d);
//! - δ(e_i^a·e_j^b) = w·(e_j^b × e_i^a), since (δθ_a × e_i^a)·e_j^b = −δθ_a·(e_j^b × e_i^a);
//! - an angle with the gradient g, δ(angle) = g·w, has the row [0, −g, 0 | 0, g, 0].

mod decks; // known answers of decks that need forces
mod forces; // forces and moments as the manual prints them

use crate::laws::{Check, Scales, functions};
use crate::states::{Case, Ends, Extent, cases};
use pintle_kinematics::catalog::{ConnectionType, TABLE};
use pintle_kinematics::connector::{Components, NodalRow, Request, Turns};
use pintle_kinematics::node::DOFS;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{
    Matrix, Vector, add, apply, column, cross, dot, product, scale, sub, transpose,
};

fn entry(name: &str) -> &'static ConnectionType {
    TABLE.iter().find(|entry| entry.name == name).expect(name)
}

/// Everything a row is made of.
struct Pose {
    a: [Vector<f64>; 3],
    b: [Vector<f64>; 3],
    triad_a: Matrix<f64>,
    q: Matrix<f64>,
    d: Vector<f64>,
    /// Whether the printed constraints hold initially.
    aligned: bool,
    q0: Matrix<f64>,
    flow: [f64; 2],
    initial_length: f64,
    flow_scale: f64,
}

impl Pose {
    fn of(case: &Case) -> Self {
        let pair = &case.end().state.pair;
        let triad = |m: &Matrix<f64>| [0, 1, 2].map(|j| column(m, j));
        let initial = &case.definition.initial;
        let q0 = product(&transpose(&initial.a.triad), &initial.b.triad);
        let (_, initial_length) =
            <f64 as pintle_kinematics::scalar::Real>::direction_and_norm(initial.reference);
        Self {
            a: triad(&pair.a.triad),
            b: triad(&pair.b.triad),
            triad_a: pair.a.triad,
            q: product(&transpose(&pair.a.triad), &pair.b.triad),
            d: pair.separation(),
            aligned: q0[0][1].abs() < 1e-12 && q0[0][2].abs() < 1e-12,
            q0,
            flow: [pair.a.flow, pair.b.flow],
            initial_length,
            flow_scale: case.definition.flow_scale,
        }
    }

    /// δ(e_i^a·d), i from 1: [−e, e × d, 0 | e, 0, 0].
    fn coordinate(&self, i: usize) -> NodalRow<f64> {
        let e = self.a[i - 1];
        row(scale(e, -1.0), cross(e, self.d), e, [0.0; 3])
    }

    /// δ(e_i^a·e_j^b) = w·(e_j^b × e_i^a); for j = 2 and e1a = e1b this is −e3b·w, for j = 3 it is e2b·w.
    fn cosine(&self, i: usize, j: usize) -> NodalRow<f64> {
        angle(cross(self.b[j - 1], self.a[i - 1]))
    }

    /// The dual basis of the axes e1a, e2' = cos α e2a + sin α e3a, e3b of the successive rotations:
    /// α: (e1a − sin β e3b)/cos²β, β: e2', γ: (e3b − sin β e1a)/cos²β.
    fn cardan(&self) -> [NodalRow<f64>; 3] {
        let (first, last) = (self.a[0], self.b[2]);
        let sine = dot(first, last);
        let square = self.q[1][2] * self.q[1][2] + self.q[2][2] * self.q[2][2];
        let cosine = square.sqrt();
        let (cos, sin) = (self.q[2][2] / cosine, -self.q[1][2] / cosine);
        let second = add(scale(self.a[1], cos), scale(self.a[2], sin));
        [
            angle(scale(sub(first, scale(last, sine)), 1.0 / square)),
            angle(second),
            angle(scale(sub(last, scale(first, sine)), 1.0 / square)),
        ]
    }

    /// As `cardan`, of the axes e3a, e1' = cos α e1a + sin α e2a, e3b, s the sign of sin β:
    /// α: (e3a − cos β e3b)/sin²β, β: e1', γ: (e3b − cos β e3a)/sin²β.
    fn euler(&self, s: f64) -> [NodalRow<f64>; 3] {
        let (first, last) = (self.a[2], self.b[2]);
        let cosine = dot(first, last);
        let square = self.q[0][2] * self.q[0][2] + self.q[1][2] * self.q[1][2];
        let sine = s * square.sqrt();
        let (sin, cos) = (self.q[0][2] / sine, -self.q[1][2] / sine);
        let second = add(scale(self.a[0], cos), scale(self.a[1], sin));
        [
            angle(scale(sub(first, scale(last, cosine)), 1.0 / square)),
            angle(second),
            angle(scale(sub(last, scale(first, cosine)), 1.0 / square)),
        ]
    }

    /// The frame midway between a and b for a torsion β: with c = e3a·e3b, e3 = (e3a + e3b)/|e3a + e3b|,
    /// a1 = e1a − (e1a·e3)/(1 + e3a·e3)(e3a + e3) and e1 = cos(β/2) a1 + sin(β/2) e3 × a1.
    fn middle(&self, torsion: Turns<f64>) -> Middle {
        let unit = |v: Vector<f64>| scale(v, 1.0 / dot(v, v).sqrt());
        let (first, shaft_a, shaft_b) = (self.a[0], self.a[2], self.b[2]);
        let (sum, difference) = (add(shaft_a, shaft_b), sub(shaft_a, shaft_b));
        let e3 = unit(sum);
        let a1 = sub(first, scale(add(shaft_a, e3), dot(first, e3) / (1.0 + dot(shaft_a, e3))));
        let (sin, cos) = (0.5 * torsion.principal).sin_cos();
        let e1 = scale(
            add(scale(a1, cos), scale(cross(e3, a1), sin)),
            if torsion.turns % 2.0 == 0.0 { 1.0 } else { -1.0 },
        );
        let half = dot(difference, difference).sqrt().atan2(dot(sum, sum).sqrt()); // α/2
        let p = if half == 0.0 { [0.0; 3] } else { unit(difference) };
        Middle { e: [e1, cross(e3, e1), e3], p, half }
    }

    /// β: (e3a + e3b)/(1 + c).
    fn torsion(&self) -> NodalRow<f64> {
        let sum = add(self.a[2], self.b[2]);
        angle(scale(sum, 2.0 / dot(sum, sum)))
    }

    /// δφ = H⁻¹(φ) Aᵀw for a rotation vector φ along e_i^a, with R = exp(φ^) → exp((Aᵀw)^) R and, t = |φ|,
    /// H⁻¹ = I − ½ φ^ + c φ^², c = 1/t² − (1 + cos t)/(2 t sin t) (c → 1/12 + t²/720).
    fn rotation_vector(&self, phi: Vector<f64>) -> [NodalRow<f64>; 3] {
        let t = dot(phi, phi).sqrt();
        // (1 + cos t)/sin t = cot(t/2); the closed form loses digits like u/t² towards zero, where the series takes over.
        let c = if t < 0.1 {
            let s = t * t;
            1.0 / 12.0 + s / 720.0 + s * s / 30_240.0 + s * s * s / 1_209_600.0 + s * s * s * s / 47_900_160.0
        } else {
            (1.0 - 0.5 * t / (0.5 * t).tan()) / (t * t)
        };
        [0, 1, 2].map(|i| {
            // The row i of H⁻¹ is (H⁻¹)ᵀ e_i = e_i + ½ φ × e_i + c φ × (φ × e_i).
            let mut e = [0.0; 3];
            e[i] = 1.0;
            let (once, twice) = (cross(phi, e), cross(phi, cross(phi, e)));
            angle(apply(&self.triad_a, add(add(e, scale(once, 0.5)), scale(twice, c))))
        })
    }
}

fn row(xa: Vector<f64>, theta_a: Vector<f64>, xb: Vector<f64>, theta_b: Vector<f64>) -> NodalRow<f64> {
    let mut row = [0.0; DOFS];
    for (at, part) in [(0, xa), (3, theta_a), (7, xb), (10, theta_b)] {
        row[at..at + 3].copy_from_slice(&part);
    }
    row
}

/// [0, −g, 0 | 0, g, 0].
fn angle(g: Vector<f64>) -> NodalRow<f64> {
    row([0.0; 3], scale(g, -1.0), [0.0; 3], g)
}

/// The directions midway between a and b, p = (e3a − e3b)/|e3a − e3b|, and α/2.
struct Middle {
    e: [Vector<f64>; 3],
    p: Vector<f64>,
    half: f64,
}

impl Middle {
    /// δ(e_i·d) = e_i·(δx_b − δx_a) + δθ_mid·(e_i × d), δθ_mid = δθ_a + T w, so that with N = e_i × d the moments are TᵀN on b and
    /// N − TᵀN on a: T = I/2 + ½ tan(α/2) p e3ᵀ − ½ tan(α/4) e3 pᵀ.
    fn coordinate(&self, i: usize, d: Vector<f64>) -> NodalRow<f64> {
        let (e, e3) = (self.e[i - 1], self.e[2]);
        let n = cross(e, d);
        let bend = scale(e3, 0.5 * self.half.tan() * dot(self.p, n));
        let twist = scale(self.p, 0.5 * (0.5 * self.half).tan() * dot(e3, n));
        let on_b = sub(add(scale(n, 0.5), bend), twist);
        row(scale(e, -1.0), sub(n, on_b), e, on_b)
    }

    /// α_1: −sin χ q − κ cos χ p and α_2: cos χ q − κ sin χ p, with p = −(cos χ e1 + sin χ e2), q = −sin χ e1 + cos χ e2 and
    /// κ = (α/2)/sin(α/2); that is, e_i + (κ − 1)(p·e_i) p, which does not need p without flexion.
    fn flexions(&self) -> [NodalRow<f64>; 2] {
        let excess = if self.half == 0.0 { 0.0 } else { self.half / self.half.sin() - 1.0 };
        [0, 1].map(|i| angle(add(self.e[i], scale(self.p, excess * dot(self.p, self.e[i])))))
    }
}

/// The torsion with its turns, as the branch has it.
fn torsion_of(case: &Case) -> Turns<f64> {
    let connector = case.connector();
    let end = case.end();
    connector.advance(&end.state, &end.increment, &case.branch_before(&connector)).torsion
}

/// Compares every row of a type, at every state, with the rows given; `None` where no component is.
fn judge(name: &str, rows: impl Fn(&Case, &Pose) -> Components<NodalRow<f64>>) {
    let mut check = Check::of("rows by hand");
    for case in cases(entry(name), Extent::Full) {
        let (got, _) = case.evaluate(&Request::everything(2));
        let expected = rows(&case, &Pose::of(&case));
        let functions = functions(&got);
        for c in 0..6 {
            assert_eq!(
                got.jacobian[c].is_some(),
                expected[c].is_some(),
                "{}, component {}",
                case.name,
                c + 1
            );
            let (Some(row), Some(expected)) = (got.jacobian[c], expected[c]) else { continue };
            let hessian = got.hessian[c].as_ref().expect("second derivatives");
            let scales = Scales::new(functions[c].expect("a value"), &row, hessian, case.length);
            for j in 0..DOFS {
                let place = || format!("{}, component {}, ∂{j}", case.name, c + 1);
                check.against(place, row[j], expected[j], scales.first[j]);
            }
        }
    }
    check.finish();
}

/// e1a·d held, e2a·d and e3a·d free.
#[test]
fn slide_plane() {
    judge("SLIDE-PLANE", |_, pose| {
        [Some(pose.coordinate(1)), Some(pose.coordinate(2)), Some(pose.coordinate(3)), None, None, None]
    });
}

/// α free; e1a·e3b = 0 and e1a·e2b = 0, or with misaligned axes β = β₀ and γ = γ₀.
#[test]
fn revolute() {
    judge("REVOLUTE", |_, pose| {
        let [alpha, beta, gamma] = pose.cardan();
        let (second, third) =
            if pose.aligned { (pose.cosine(1, 3), pose.cosine(1, 2)) } else { (beta, gamma) };
        [None, None, None, Some(alpha), Some(second), Some(third)]
    });
}

/// α, β, γ free.
#[test]
fn cardan() {
    judge("CARDAN", |_, pose| {
        let [alpha, beta, gamma] = pose.cardan();
        [None, None, None, Some(alpha), Some(beta), Some(gamma)]
    });
}

/// α, β, γ free, on either sheet of sin β.
#[test]
fn euler() {
    judge("EULER", |case, pose| {
        let connector = case.connector();
        let end = case.end();
        let branch = connector.advance(&end.state, &end.increment, &case.branch_before(&connector));
        let [alpha, beta, gamma] = pose.euler(branch.euler_sign);
        [None, None, None, Some(alpha), Some(beta), Some(gamma)]
    });
}

/// φ1, φ2, φ3 free, through several turns: φ is taken as the connector reports it, and must be a rotation vector of Q.
#[test]
fn rotation() {
    judge("ROTATION", |case, pose| {
        let phi = case.evaluate(&Request::everything(0)).0.position;
        let phi = [3, 4, 5].map(|c| phi[c].expect("an angle"));
        let turned = so3::matrix(so3::exp_quaternion(phi));
        for i in 0..3 {
            for j in 0..3 {
                let gap = (turned[i][j] - pose.q[i][j]).abs();
                assert!(gap < 1e-14, "{}: exp(φ^) is not Q by {gap:e}", case.name);
            }
        }
        let [x, y, z] = pose.rotation_vector(phi);
        [None, None, None, Some(x), Some(y), Some(z)]
    });
}

/// e1a·d free, e2a·d and e3a·d held; log(Q Q₀ᵀ) = 0.
#[test]
fn translator() {
    judge("TRANSLATOR", |_, pose| {
        let rho = so3::log(&product(&pose.q, &transpose(&pose.q0)));
        let [x, y, z] = pose.rotation_vector(rho);
        let [first, second, third] = [1, 2, 3].map(|i| Some(pose.coordinate(i)));
        [first, second, third, Some(x), Some(y), Some(z)]
    });
}

/// e_i^a·d held; the one-form e3a·(δθ_a − δθ_b) − β_s δΨ_b.
#[test]
fn retractor() {
    judge("RETRACTOR", |_, pose| {
        let e3 = pose.a[2];
        let mut drum = angle(scale(e3, -1.0));
        drum[13] = -pose.flow_scale;
        let [first, second, third] = [1, 2, 3].map(|i| Some(pose.coordinate(i)));
        [first, second, third, None, None, Some(drum)]
    });
}

/// λ − 1 with λ = |d|/m, m = l₀ + Ψ_a − Ψ_b: δλ = q·(δx_b − δx_a)/m − λ (δΨ_a − δΨ_b)/m; then Ψ_b and Ψ_a themselves.
#[test]
fn slipring() {
    judge("SLIPRING", |_, pose| {
        let [psi_a, psi_b] = pose.flow;
        let material = pose.initial_length + psi_a - psi_b;
        let length = dot(pose.d, pose.d).sqrt();
        let direction = scale(pose.d, 1.0 / (length * material));
        let mut strain = row(scale(direction, -1.0), [0.0; 3], direction, [0.0; 3]);
        let change = length / (material * material);
        strain[6] = -change;
        strain[13] = change;
        let unit = |j: usize| std::array::from_fn(|k| if k == j { 1.0 } else { 0.0 });
        [Some(strain), Some(unit(13)), Some(unit(6)), None, None, None]
    });
}

/// |d|: [−q, 0, 0 | q, 0, 0] with q = d/|d|.
#[test]
fn link() {
    judge("LINK", |_, pose| {
        let q = scale(pose.d, 1.0 / dot(pose.d, pose.d).sqrt());
        [Some(row(scale(q, -1.0), [0.0; 3], q, [0.0; 3])), None, None, None, None, None]
    });
}

/// r: [−e_r, e_r × d, 0 | e_r, 0, 0], e_r = ((e1a·d) e1a + (e2a·d) e2a)/r; then e3a·d.
#[test]
fn radial_thrust() {
    judge("RADIAL-THRUST", |_, pose| {
        let (x, y) = (dot(pose.a[0], pose.d), dot(pose.a[1], pose.d));
        let outward = scale(add(scale(pose.a[0], x), scale(pose.a[1], y)), 1.0 / (x * x + y * y).sqrt());
        let radial = row(scale(outward, -1.0), cross(outward, pose.d), outward, [0.0; 3]);
        [Some(radial), None, Some(pose.coordinate(3)), None, None, None]
    });
}

/// e_i^a·d, as CARTESIAN.
#[test]
fn accelerometer() {
    judge("ACCELEROMETER", |_, pose| {
        let [x, y, z] = [1, 2, 3].map(|i| Some(pose.coordinate(i)));
        [x, y, z, None, None, None]
    });
}

/// e_i^a·d held; β held.
#[test]
fn constant_velocity_joint() {
    judge("CVJOINT", |_, pose| {
        let [x, y, z] = [1, 2, 3].map(|i| Some(pose.coordinate(i)));
        [x, y, z, None, Some(pose.torsion()), None]
    });
}

/// α: q = e3a × e3b/|e3a × e3b|; β: (e3a + e3b)/(1 + c); θ: (e3a − c e3b)/sin²α.
#[test]
fn flexion_torsion() {
    judge("FLEXION-TORSION", |_, pose| {
        let (shaft_a, shaft_b) = (pose.a[2], pose.b[2]);
        let across = cross(shaft_a, shaft_b);
        let square = dot(across, across);
        let q = scale(across, 1.0 / square.sqrt());
        let sweep = scale(sub(shaft_a, scale(shaft_b, dot(shaft_a, shaft_b))), 1.0 / square);
        [None, None, None, Some(angle(q)), Some(pose.torsion()), Some(angle(sweep))]
    });
}

/// α_1, α_2 and β, through several turns of β.
#[test]
fn projection_flexion_torsion() {
    judge("PROJECTION FLEXION-TORSION", |case, pose| {
        let [first, second] = pose.middle(torsion_of(case)).flexions();
        [None, None, None, Some(first), Some(second), Some(pose.torsion())]
    });
}

/// The coordinates of b in the frame midway, which loads the rotations of both nodes; then α_1, α_2, β.
#[test]
fn bushing() {
    judge("BUSHING", |case, pose| {
        let middle = pose.middle(torsion_of(case));
        let [x, y, z] = [1, 2, 3].map(|i| Some(middle.coordinate(i, pose.d)));
        let [first, second] = middle.flexions();
        [x, y, z, Some(first), Some(second), Some(pose.torsion())]
    });
}
