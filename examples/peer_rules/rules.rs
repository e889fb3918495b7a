//! The default rules of the other checkers, each from its source: whether it calls a Jacobian wrong.
//!
//! All of them see a function of one vector of parameters, its values, and the Jacobian that somebody wrote beside it.

/// A function at a point.
pub(crate) struct Problem<'a> {
    /// The parameters where it is checked.
    pub(crate) at: Vec<f64>,
    /// All values by all parameters.
    pub(crate) values: &'a dyn Fn(&[f64]) -> Vec<f64>,
}

/// A row for each value, a column for each parameter.
pub(crate) type Jacobian = Vec<Vec<f64>>;

/// Whether an error is beyond what is allowed, or not a number.
pub(crate) fn exceeds(error: f64, allowed: f64) -> bool {
    error.is_nan() || error > allowed
}

fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

fn difference(x: &[f64], y: &[f64]) -> Vec<f64> {
    x.iter().zip(y).map(|(x, y)| x - y).collect()
}

impl Problem<'_> {
    /// (f(x + h v) − f(x − h v)) / 2h.
    fn central(&self, v: &[f64], h: f64) -> Vec<f64> {
        let at = |h: f64| {
            let x: Vec<f64> = self.at.iter().zip(v).map(|(x, v)| x + h * v).collect();
            (self.values)(&x)
        };
        at(h).iter().zip(&at(-h)).map(|(plus, minus)| (plus - minus) / (2.0 * h)).collect()
    }

    /// A Jacobian from the derivatives of all values by each parameter.
    fn jacobian(&self, column: impl Fn(usize, &[f64]) -> Vec<f64>) -> Jacobian {
        let columns: Vec<Vec<f64>> = (0..self.at.len())
            .map(|j| {
                let axis: Vec<f64> = (0..self.at.len()).map(|i| f64::from(u8::from(i == j))).collect();
                column(j, &axis)
            })
            .collect();
        let values = columns.first().map_or(0, Vec::len);
        (0..values).map(|k| columns.iter().map(|column| column[k]).collect()).collect()
    }

    /// Ridders' differences of all values by parameter j: central ones with steps that halve, extrapolated by Richardson until two
    /// neighbours in the tableau agree to 1e-12, until it worsens twofold, or ten times. From 32 × 1e-2 max(1, |x|).
    fn ridders(&self, j: usize, axis: &[f64]) -> Vec<f64> {
        const START: f64 = 1e-2;
        const SHRINK: f64 = 2.0;
        const ENOUGH: f64 = 1e-12;
        const MOST: i32 = 10;
        let first = START.max(START * self.at[j].abs()) * SHRINK.powi(MOST / 2);
        let mut tableau: Vec<Vec<Vec<f64>>> = Vec::new();
        let (mut found, mut least) = (Vec::new(), f64::MAX);
        for i in 0..MOST {
            let mut row = vec![self.central(axis, first / SHRINK.powi(i))];
            if i == 0 {
                found.clone_from(&row[0]);
            }
            if let Some(before) = tableau.last() {
                for (k, (coarse, factor)) in before.iter().zip((1..).map(|k| SHRINK.powi(2 * k))).enumerate()
                {
                    let pairs = row[k].iter().zip(coarse);
                    let next: Vec<f64> =
                        pairs.map(|(fine, coarse)| (factor * fine - coarse) / (factor - 1.0)).collect();
                    let error = norm(&difference(&next, &row[k])).max(norm(&difference(&next, coarse)));
                    if error <= least {
                        least = error;
                        found.clone_from(&next);
                    }
                    row.push(next);
                    if least < ENOUGH {
                        return found;
                    }
                }
                let [end, end_before] = [&row[row.len() - 1], &before[before.len() - 1]];
                if norm(&difference(end, end_before)) >= 2.0 * least {
                    return found;
                }
            }
            tableau.push(row);
        }
        found
    }
}

/// The names of the rules, in the order of [`Peers::wrong`].
pub(crate) const NAMES: [&str; 5] =
    ["gradcheck, slow", "gradcheck, fast", "Ceres", "DifferentiationInterfaceTest", "JAX check_grads"];

/// What the rules compute before they see a Jacobian.
#[derive(Default)]
pub(crate) struct Peers {
    slow: Jacobian,
    fast: Vec<f64>,
    ridders: Jacobian,
    jax: Vec<f64>,
}

/// Computes what one rule needs.
pub(crate) type Prepare = fn(&mut Peers, &Problem);

/// What a fresh `torch.Generator()` gives to `torch.rand`: the numbers m · 2⁻²⁴ on single precision. They are always the same, for it starts
/// from the default seed 67280421310721 (c10/core/GeneratorImpl.h; a Mersenne twister seeded with its lower 32 bits).
const RAND: [u32; 20] = [
    4484470, 14638596, 5625213, 6761484, 13205677, 7677331, 1206898, 16298478, 11989963, 7171481, 1418518,
    8228157, 2789127, 2580282, 6103388, 8631631, 11948430, 14742583, 14144298, 16574150,
];

/// `numpy.random.RandomState(0).randn(20)`.
const RANDN: [f64; 20] = [
    1.764052345967664,
    0.4001572083672233,
    0.9787379841057392,
    2.240893199201458,
    1.8675579901499675,
    -0.977277879876411,
    0.9500884175255894,
    -0.1513572082976979,
    -0.10321885179355784,
    0.41059850193837233,
    0.144043571160878,
    1.454273506962975,
    0.7610377251469934,
    0.12167501649282841,
    0.44386323274542566,
    0.33367432737426683,
    1.4940790731576061,
    -0.20515826376580087,
    0.31306770165090136,
    -0.8540957393017248,
];

/// torch/autograd/gradcheck.py, `_vec_from_tensor`: uniform in [0, 1), divided by the norm.
fn unit(draws: &[u32]) -> Vec<f64> {
    let drawn: Vec<f64> = draws.iter().map(|m| f64::from(*m) / f64::from(1 << 24)).collect();
    let norm = norm(&drawn);
    drawn.iter().map(|x| x / norm).collect()
}

/// Of the draws, as many as there are parameters, and as many as there are values after them.
fn split<T>(draws: &[T], parameters: usize, values: usize) -> (&[T], &[T]) {
    let (first, rest) = draws.split_at(parameters);
    (first, &rest[..values])
}

fn times(jacobian: &Jacobian, v: &[f64]) -> Vec<f64> {
    jacobian.iter().map(|row| dot(row, v)).collect()
}

impl Peers {
    /// Step of `gradcheck`, and of `check_grads`.
    const STEPS: [f64; 2] = [1e-6, 1e-4];

    /// What all rules compute.
    pub(crate) fn of(problem: &Problem) -> Self {
        let mut found = Self::default();
        Self::PREPARED.iter().for_each(|(_, prepare)| prepare(&mut found, problem));
        found
    }

    /// What each rule computes by itself, by its place among the names. DifferentiationInterfaceTest computes nothing.
    pub(crate) const PREPARED: [(usize, Prepare); 4] = [
        (0, |found, problem| found.slow = problem.jacobian(|_, axis| problem.central(axis, Self::STEPS[0]))),
        (1, |found, problem| found.fast = problem.central(&unit(&RAND[..problem.at.len()]), Self::STEPS[0])),
        (2, |found, problem| found.ridders = problem.jacobian(|j, axis| problem.ridders(j, axis))),
        (4, |found, problem| found.jax = problem.central(&RANDN[..problem.at.len()], Self::STEPS[1])),
    ];

    /// Whether a rule calls the Jacobian wrong, by its place among the names.
    pub(crate) fn is_wrong(&self, rule: usize, found: &Jacobian, right: &Jacobian) -> bool {
        match rule {
            0 => self.slow(found),
            1 => self.fast(found),
            2 => self.ceres(found),
            3 => interface(found, right),
            _ => self.jax(found),
        }
    }

    /// Whether each rule calls the Jacobian wrong; `right` is what DifferentiationInterfaceTest is given to compare with.
    pub(crate) fn wrong(&self, found: &Jacobian, right: &Jacobian) -> [bool; 5] {
        std::array::from_fn(|rule| self.is_wrong(rule, found, right))
    }

    /// torch/autograd/gradcheck.py, `gradcheck`: eps 1e-6, and |a − n| ≤ atol + rtol |n| entry by entry, atol 1e-5, rtol 1e-3.
    fn slow(&self, found: &Jacobian) -> bool {
        let entries = found.iter().flatten().zip(self.slow.iter().flatten());
        entries.into_iter().any(|(a, n)| exceeds((a - n).abs(), 1e-5 + 1e-3 * n.abs()))
    }

    /// The same with `fast_mode=True`: vᵀ J u of one u and one v, J u by one difference along u. atol is multiplied by Σ u · Σ v
    /// (`_adjusted_atol`).
    fn fast(&self, found: &Jacobian) -> bool {
        let (u, v) = split(&RAND, found.first().map_or(0, Vec::len), found.len());
        let (u, v) = (unit(u), unit(v));
        let [a, n] = [dot(&v, &times(found, &u)), dot(&v, &self.fast)];
        let atol = 1e-5 * u.iter().sum::<f64>() * v.iter().sum::<f64>();
        exceeds((a - n).abs(), atol + 1e-3 * n.abs())
    }

    /// internal/ceres/gradient_checker.cc: `NumericDiffCostFunction` by `RIDDERS` with the defaults of
    /// include/ceres/numeric_diff_options.h. Of `check_gradients`, only the step of other methods comes from the solver's options.
    ///
    /// internal/ceres/is_close.cc compares to the solver's `gradient_check_relative_precision`, 1e-8: relative to the larger of the
    /// two, absolute where one of them is exactly zero.
    fn ceres(&self, found: &Jacobian) -> bool {
        let entries = found.iter().flatten().zip(self.ridders.iter().flatten());
        entries.into_iter().any(|(x, y)| !is_close(*x, *y, 1e-8))
    }

    /// jax/_src/public_test_util.py, `check_grads` of order 1, on doubles with tolerances 1e-5: `check_jvp` compares J u, and
    /// `check_vjp` (wᵀ J) · u with w · (J u), differences with eps 1e-4 along u. Both draw from `RandomState(0)`; the tolerances are
    /// multiplied by the number of entries compared.
    fn jax(&self, found: &Jacobian) -> bool {
        let (u, w) = split(&RANDN, found.first().map_or(0, Vec::len), found.len());
        let along = times(found, u);
        let allowed = |size: usize, n: f64| 1e-5 * size as f64 * (1.0 + n.abs());
        let forward =
            along.iter().zip(&self.jax).any(|(a, n)| exceeds((a - n).abs(), allowed(found.len(), *n)));
        let [a, n] = [dot(w, &along), dot(w, &self.jax)];
        forward || exceeds((a - n).abs(), allowed(1, n))
    }
}

fn is_close(x: f64, y: f64, precision: f64) -> bool {
    let error = (x - y).abs();
    let relative = if x == 0.0 || y == 0.0 { error } else { error / x.abs().max(y.abs()) };
    relative < precision
}

/// DifferentiationInterfaceTest/src/test_differentiation.jl: Julia's `isapprox(J, reference; atol = 0, rtol = 1e-3)`, in the Frobenius
/// norm relative to the larger of the two. The reference comes with the scenario; here it is the right one.
fn interface(found: &Jacobian, right: &Jacobian) -> bool {
    let flat = |jacobian: &Jacobian| jacobian.concat();
    let [found, right] = [flat(found), flat(right)];
    exceeds(norm(&difference(&found, &right)), 1e-3 * norm(&found).max(norm(&right)))
}

/// The rules themselves, where the answer is known.
pub(crate) fn tried() {
    let values = |x: &[f64]| vec![x[0].exp() + x[1].sin(), 1e3 * x[0] * x[1]];
    let problem = Problem { at: vec![0.3, 2.0], values: &values };
    let right = vec![vec![0.3_f64.exp(), 2_f64.cos()], vec![2e3, 300.0]];
    let peers = Peers::of(&problem);
    for (found, right) in peers.ridders.iter().flatten().zip(right.iter().flatten()) {
        assert!((found - right).abs() <= 1e-9 * right.abs(), "Ridders' differences: {found}, {right}");
    }
    assert_eq!(peers.wrong(&right, &right), [false; 5]);
    let by = |k: usize, j: usize, factor: f64| {
        let mut wrong = right.clone();
        wrong[k][j] *= factor;
        peers.wrong(&wrong, &right)
    };
    assert_eq!(by(1, 0, -1.0), [true; 5]);
    assert_eq!(by(0, 0, 1.0 + 1e-7), [false, false, true, false, false]);
    assert_eq!(by(0, 0, 1.01), [true, false, true, false, true]);
    assert!(is_close(0.0, 9e-9, 1e-8) && !is_close(1e-9, 9e-9, 1e-8) && !is_close(f64::NAN, 0.0, 1e-8));
}
