//! What is asked of an element, compiled with this crate on doubles and on 237-bit numbers, and not again with every crate that asks.

use crate::connector::{
    Branch, CompactRow, Components, Connector, Definition, Evaluation, Increment, Linear, Mask, Request,
    State, Tally, Turns,
};
use crate::force::{ForceRows, Want};
use crate::mpc::{self, Constraint, Turning};
use crate::node::Pair;
use crate::relation::{ConstraintRow, Point, Relation};
use crate::scalar::lanes::Lanes;
use crate::scalar::{Duals, Wide};

/// The entry points, as methods of [`Differentiable`]: `inline` as they are for any number, `inline(never)` for those
/// numbers of which this crate holds the code.
macro_rules! entry_points {
    ($($inline:tt)+) => {
        #[$($inline)+]
        #[doc(hidden)]
        fn make(definition: &Definition) -> Connector<Self> {
            Connector::make(definition)
        }

        #[$($inline)+]
        #[doc(hidden)]
        fn follow(
            connector: &Connector<Self>,
            state: &State<Self>,
            increment: &Increment<Self>,
            branch: &Branch<Self>,
            wanted: Mask,
            tally: &mut Tally,
        ) -> Branch<Self> {
            connector.follower().follow(&state.pair, increment, branch, wanted, tally)
        }

        #[$($inline)+]
        #[doc(hidden)]
        fn evaluate(
            connector: &Connector<Self>,
            evaluation: &mut Evaluation<Self>,
            state: &State<Self>,
            request: &Request,
            tally: &mut Tally,
        ) {
            connector.add_any(evaluation, state, request, tally);
        }

        #[$($inline)+]
        #[doc(hidden)]
        fn linearize(
            connector: &Connector<Self>,
            pair: &Pair<Self>,
            branch: &Branch<Self>,
            wanted: Mask,
            out: &mut [Linear<Self>; 6],
        ) -> usize {
            connector.linearize_any(pair, branch, wanted, out)
        }

        #[$($inline)+]
        #[doc(hidden)]
        fn values(
            connector: &Connector<Self>,
            pair: &Pair<Self>,
            branch: &Branch<Self>,
            wanted: Mask,
        ) -> Components<Self> {
            connector.values_any(pair, branch, wanted)
        }

        #[$($inline)+]
        #[doc(hidden)]
        fn compact_rows(
            connector: &Connector<Self>,
            state: &State<Self>,
            branch: &Branch<Self>,
            wanted: Mask,
            tally: &mut Tally,
        ) -> [Option<CompactRow<Self>>; 6] {
            connector.compact_rows_any(state, branch, wanted, tally)
        }

        #[$($inline)+]
        #[doc(hidden)]
        fn force_rows(
            connector: &Connector<Self>,
            state: &State<Self>,
            branch: &Branch<Self>,
            components: Mask,
            want: Want,
            evaluation: Option<&Evaluation<Self>>,
            tally: &mut Tally,
        ) -> ForceRows<Self> {
            connector.force_rows_any(state, branch, components, want, evaluation, tally)
        }

        #[$($inline)+]
        #[doc(hidden)]
        fn constrain(
            constraint: &Constraint<Self>,
            state: &mpc::State<Self>,
            previous: &[Turns<Self>; 2],
            turning: &Turning<Self>,
            request: &Request,
            tally: &mut Tally,
        ) -> mpc::Evaluation<Self> {
            constraint.evaluate_any(state, previous, turning, request, tally)
        }

        #[$($inline)+]
        #[doc(hidden)]
        fn relate(
            relation: &Relation<Self>,
            nodes: &[Point<Self>],
            request: &Request,
            tally: &mut Tally,
        ) -> Vec<ConstraintRow<Self>> {
            relation.evaluate_any(nodes, request, tally)
        }
    };
}

/// A real number on which elements are evaluated: one with dual numbers, and with the code of what is asked.
pub trait Differentiable: Duals {
    entry_points!(inline);
}

impl Differentiable for f64 {
    entry_points!(inline(never));
}

impl Differentiable for Wide {
    entry_points!(inline(never));
}

impl<const FUSED: bool> Differentiable for Lanes<FUSED> {}

impl<R: Differentiable> Connector<R> {
    /// A connector from its definition. Angles of the initial state are principal.
    pub fn new(definition: &Definition) -> Self {
        R::make(definition)
    }

    /// The branch after `state`, which follows by `increment` the state that left `branch`.
    ///
    /// Turns are counted to the nearest, from where the whole turns of the nodes' own increments would have taken the angle. An
    /// increment of exactly half a turn goes the way the nodes turned, or to the principal angle where that is not said.
    pub fn advance(&self, state: &State<R>, increment: &Increment<R>, branch: &Branch<R>) -> Branch<R> {
        self.follow(state, increment, branch, [true; 6], &mut Tally::default())
    }

    /// The same for the components in `wanted` only; what belongs to others stays as it was. Angles of one set of Cardan or
    /// Euler angles are followed together. `tally` counts the work.
    pub fn follow(
        &self,
        state: &State<R>,
        increment: &Increment<R>,
        branch: &Branch<R>,
        wanted: Mask,
        tally: &mut Tally,
    ) -> Branch<R> {
        R::follow(self, state, increment, branch, wanted, tally)
    }

    /// Evaluates what `request` names at `state`, which follows by `increment` the state that left `branch`; `tally` counts the
    /// work.
    pub fn evaluate(
        &self,
        state: &State<R>,
        increment: &Increment<R>,
        branch: &Branch<R>,
        request: &Request,
        tally: &mut Tally,
    ) -> Evaluation<R> {
        let next = self.advance(state, increment, branch);
        self.evaluate_on(state, next, request, tally)
    }

    /// The same with the branch of the state itself, as [`Connector::follow`] gives it for the components of the request.
    pub fn evaluate_on(
        &self,
        state: &State<R>,
        next: Branch<R>,
        request: &Request,
        tally: &mut Tally,
    ) -> Evaluation<R> {
        let mut evaluation = Evaluation::empty(next);
        R::evaluate(self, &mut evaluation, state, request, tally);
        evaluation
    }

    /// The same, written over another evaluation.
    pub fn evaluate_into(
        &self,
        evaluation: &mut Evaluation<R>,
        state: &State<R>,
        next: Branch<R>,
        request: &Request,
        tally: &mut Tally,
    ) {
        evaluation.clear();
        evaluation.branch = next;
        R::evaluate(self, evaluation, state, request, tally);
    }

    /// Values and rows of the components in `wanted` that there are, in their order: of the residual of a constrained component, of
    /// the position of any other. They are at the nodes `pair` on the sheets of `branch`, which must be that of the state
    /// ([`Connector::advance`]). They go to the front of `out`, whose rest stays as it is; gives their number.
    ///
    /// Several times as fast as [`Connector::evaluate`], for there is no history, no request and no output that may be absent; the
    /// numbers are the same. Offsets, turns and references are the caller's.
    ///
    /// ```
    /// use pintle_kinematics::catalog::ConnectionType;
    /// use pintle_kinematics::connector::{Connector, Definition, Linear};
    /// use pintle_kinematics::node::{Node, Pair};
    /// use pintle_kinematics::{so3, vector};
    ///
    /// let node = |triad| Node { displacement: [0.0; 3], triad, flow: 0.0 };
    /// let turned = |angle| Pair {
    ///     reference: [0.0; 3],
    ///     a: node(vector::identity()),
    ///     b: node(so3::matrix(so3::exp_quaternion([angle, 0.0, 0.0]))),
    /// };
    /// let definition = Definition::new(ConnectionType::named("REVOLUTE", None)?, turned(0.0));
    /// let connector = Connector::<f64>::new(&definition);
    /// let mut rows = [Linear::default(); 6];
    /// let count = connector.linearize(&turned(0.3), &connector.initial_branch(), [true; 6], &mut rows);
    /// assert_eq!(count, 3);
    /// assert_eq!((rows[0].component, rows[0].value), (3, 0.3)); // ur1
    /// assert_eq!(rows[0].row[10..13], [1.0, 0.0, 0.0]); // ∂ur1/∂θb1, ∂ur1/∂θb2, ∂ur1/∂θb3
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn linearize(
        &self,
        pair: &Pair<R>,
        branch: &Branch<R>,
        wanted: Mask,
        out: &mut [Linear<R>; 6],
    ) -> usize {
        R::linearize(self, pair, branch, wanted, out)
    }

    /// The values of [`Connector::linearize`] alone, by component.
    pub fn values(&self, pair: &Pair<R>, branch: &Branch<R>, wanted: Mask) -> Components<R> {
        R::values(self, pair, branch, wanted)
    }

    /// The rows of the components in `wanted`, in their order, of the residual of a constrained component and of the displacement
    /// of any other. They are at `state` on the sheets of `branch`, which must be that of the state ([`Connector::advance`]). They
    /// hold the entries of [`crate::connector::Evaluation::jacobian`] without the array of fourteen. Entries of degrees of freedom
    /// beyond [`Connector::row_pattern`] have no meaning.
    pub fn compact_rows(
        &self,
        state: &State<R>,
        branch: &Branch<R>,
        wanted: Mask,
        tally: &mut Tally,
    ) -> [Option<CompactRow<R>>; 6] {
        R::compact_rows(self, state, branch, wanted, tally)
    }

    /// The rows of virtual work of the components wanted, at a state and the branch that it left; `tally` counts the work.
    ///
    /// Rows hold the nodal forces of both ends, also of a ground node: those are the reactions of the ground. Degrees of freedom that a
    /// two-dimensional connector does not have are zero.
    ///
    /// At singular points ([`Measure::singular_set`](crate::measure::Measure::singular_set), which [`Connector::margins`] finds) rows are those of the minimal-norm
    /// derivatives, or zero: finite, and flagged.
    pub fn force_rows(
        &self,
        state: &State<R>,
        branch: &Branch<R>,
        components: Mask,
        want: Want,
        tally: &mut Tally,
    ) -> ForceRows<R> {
        self.force_rows_after(state, branch, components, want, None, tally)
    }

    /// The same beside an evaluation of the same state: what that has differentiated is taken over.
    pub fn force_rows_after(
        &self,
        state: &State<R>,
        branch: &Branch<R>,
        components: Mask,
        want: Want,
        evaluation: Option<&Evaluation<R>>,
        tally: &mut Tally,
    ) -> ForceRows<R> {
        R::force_rows(self, state, branch, components, want, evaluation, tally)
    }
}

impl<R: Differentiable> Constraint<R> {
    /// Evaluates the constraint. The turns of an angle are counted to the nearest of `previous`, from where the whole turns of S
    /// against M since then would have taken it. An increment of exactly half a turn goes the way S turned, or to the principal
    /// angle where that is not said.
    pub fn evaluate(
        &self,
        state: &mpc::State<R>,
        previous: &[Turns<R>; 2],
        turning: &Turning<R>,
        request: &Request,
        tally: &mut Tally,
    ) -> mpc::Evaluation<R> {
        R::constrain(self, state, previous, turning, request, tally)
    }
}

impl<R: Differentiable> Relation<R> {
    /// Evaluates the relation with its nodes, in their order.
    pub fn evaluate(
        &self,
        nodes: &[Point<R>],
        request: &Request,
        tally: &mut Tally,
    ) -> Vec<ConstraintRow<R>> {
        R::relate(self, nodes, request, tally)
    }
}
