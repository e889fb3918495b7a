//! First derivatives are differences of values, second derivatives differences of first, on 237-bit numbers: the values are
//! moved along finite rotations exp(δθ^) C by a step so small that nothing is left to tune.

use super::{Check, Scales, functions};
use crate::states::{Case, Ends, cases, dof_size, exact_branch, exact_state, extent, moved, types};
use pintle_kinematics::connector::{
    Branch, Components, Connector, Evaluation, Increment, NodalRow, Output, Request, State, Tally,
};
use pintle_kinematics::node::DOFS;
use pintle_kinematics::scalar::{Real, Scalar, Wide};
use pintle_kinematics::vector::{Vector, cross, dot};

/// The step, in units of the degree of freedom: the error of a central difference is about 1e-50, its rounding 1e-45.
const STEP: f64 = 1e-25;

/// A case on 237-bit numbers, from the same doubles.
pub(crate) struct Truth {
    pub(crate) connector: Connector<Wide>,
    pub(crate) state: State<Wide>,
    /// The branch that the end of the case leaves: what moves from there stays on its sheet, even at an exact half turn, which
    /// is equally far from two sheets of the state before.
    branch: Branch<Wide>,
    length: f64,
}

pub(crate) fn values() -> Request {
    Request::new(&[Output::CU, Output::RES], [true; 6], 0)
}

pub(crate) fn rows() -> Request {
    Request::new(&[], [true; 6], 1)
}

impl Truth {
    pub(crate) fn of(case: &Case) -> Self {
        let narrow = case.connector();
        let end = case.end();
        let after = narrow.advance(&end.state, &end.increment, &case.branch_before(&narrow));
        Self {
            connector: Connector::new(&case.definition),
            state: exact_state(&end.state),
            branch: exact_branch(&after),
            length: case.length,
        }
    }

    pub(crate) fn step(&self, j: usize) -> Wide {
        Wide::from_f64(STEP * dof_size(j, self.length))
    }

    pub(crate) fn evaluate(&self, by: &NodalRow<Wide>, request: &Request) -> Evaluation<Wide> {
        let mut state = self.state;
        state.pair = moved(&self.state.pair, by);
        self.connector.evaluate(&state, &Increment::none(), &self.branch, request, &mut Tally::default())
    }

    /// The value of a one-form from the end of the case on, along an increment.
    pub(crate) fn accumulated(&self, by: &NodalRow<Wide>) -> Wide {
        let mut state = self.state;
        state.pair = moved(&self.state.pair, by);
        let increment = Increment {
            rotation: [[by[3], by[4], by[5]], [by[10], by[11], by[12]]],
            whole_turns: [[Wide::zero(); 3]; 2],
            flow: [by[6], by[13]],
        };
        let after = self.connector.advance(&state, &increment, &self.branch);
        after.accumulated + after.accumulated_rest
    }

    fn along(&self, j: usize, h: Wide) -> NodalRow<Wide> {
        let mut by = [Wide::zero(); DOFS];
        by[j] = h;
        by
    }

    /// ∂f/∂q_j by central differences, for every component.
    pub(crate) fn first(&self, j: usize) -> Components<Wide> {
        let h = self.step(j);
        let (plus, minus) = (self.along(j, h), self.along(j, -h));
        let twice = h + h;
        let values = [&plus, &minus].map(|by| functions(&self.evaluate(by, &values())));
        [0, 1, 2, 3, 4, 5].map(|k| {
            if self.connector.differentiated(k)?.is_one_form() {
                return Some((self.accumulated(&plus) - self.accumulated(&minus)) / twice);
            }
            Some((values[0][k]? - values[1][k]?) / twice)
        })
    }

    /// The rows at q ± h along q_k, differenced: ∂(∂f/∂q_j)/∂q_k.
    pub(crate) fn change_of_rows(&self, k: usize) -> Components<NodalRow<Wide>> {
        let h = self.step(k);
        let at = [h, -h].map(|h| self.evaluate(&self.along(k, h), &rows()).jacobian);
        [0, 1, 2, 3, 4, 5].map(|c| {
            let (plus, minus) = (at[0][c]?, at[1][c]?);
            Some(std::array::from_fn(|j| (plus[j] - minus[j]) / (h + h)))
        })
    }
}

/// The rotational derivatives of one node within a row.
fn rotational<R: Real>(row: &NodalRow<R>, at: usize) -> Vector<R> {
    [row[at], row[at + 1], row[at + 2]]
}

/// Values, rows and second derivatives of every type at every state.
#[test]
fn derivatives_are_differences() {
    let mut value = Check::of("value");
    let mut first = Check::of("first derivatives");
    let mut second = Check::of("second derivatives");
    for connection in types() {
        for case in cases(&connection, extent(&connection)) {
            judge(&case, &mut value, &mut first, &mut second);
        }
    }
    value.finish();
    first.finish();
    second.finish();
}

fn judge(case: &Case, value: &mut Check, first: &mut Check, second: &mut Check) {
    let connector = case.connector();
    let (got, _) = case.evaluate(&Request::everything(2));
    let truth = Truth::of(case);
    let still = functions(&truth.evaluate(&[Wide::zero(); DOFS], &values()));
    let rows: [Components<Wide>; DOFS] = std::array::from_fn(|j| truth.first(j));
    let at_rest = truth.evaluate(&[Wide::zero(); DOFS], &self::rows()).jacobian;
    let changes: [Components<NodalRow<Wide>>; DOFS] = std::array::from_fn(|k| truth.change_of_rows(k));
    let functions = functions(&got);
    for c in 0..6 {
        let Some(function) = functions[c] else { continue };
        let place = |what: String| move || format!("{}, component {}, {what}", case.name, c + 1);
        let row = got.jacobian[c].expect("a component has a row");
        let hessian = got.hessian[c].as_ref().expect("a component has second derivatives");
        let scales = Scales::new(function, &row, hessian, case.length);
        let one_form = connector.differentiated(c).is_some_and(|m| m.is_one_form());
        value.compare(place("value".into()), function, still[c].expect("a value"), scales.value);
        for j in 0..DOFS {
            let mut want = rows[j][c].expect("a difference");
            if !connector.active()[j] {
                want = Wide::zero();
            }
            first.compare(place(format!("∂{j}")), row[j], want, scales.first[j]);
            for k in 0..DOFS {
                // The rotation exp(ε e_j) exp(h e_k) = exp(ε e_j + h e_k + ½ εh e_j × e_k): the change of the row is the
                // second derivative plus half the derivative along e_j × e_k. The row of a one-form has no such term.
                let mut want = changes[k][c].expect("a difference")[j];
                let node = 7 * (j / 7) + 3;
                if !one_form && j / 7 == k / 7 && j % 7 >= 3 && j % 7 < 6 && k % 7 >= 3 && k % 7 < 6 {
                    let mut axes = [[Wide::zero(); 3]; 2];
                    axes[0][j % 7 - 3] = Wide::integer(1);
                    axes[1][k % 7 - 3] = Wide::integer(1);
                    let bracket = cross(axes[0], axes[1]);
                    let gradient = rotational(&at_rest[c].expect("a row"), node);
                    want -= dot(bracket, gradient) / Wide::integer(2);
                }
                if !(connector.active()[j] && connector.active()[k]) {
                    want = Wide::zero();
                }
                second.compare(place(format!("∂{j}∂{k}")), hessian[j][k], want, scales.second(j, k));
            }
        }
    }
}
