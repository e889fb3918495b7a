//! Entry points on doubles and on 237-bit numbers, compiled with this crate, and not again with every crate that calls them.

/// The entry points, as methods of [`crate::scalar::Differentiable`]: `inline` as they are for any number, `inline(never)` for those
/// numbers of which this crate holds the code.
macro_rules! entry_points {
    ($($inline:tt)+) => {
        #[$($inline)+]
        #[doc(hidden)]
        fn make(definition: &crate::connector::Definition) -> crate::connector::Connector<Self> {
            crate::connector::Connector::make(definition)
        }

        #[$($inline)+]
        #[doc(hidden)]
        fn follow(
            connector: &crate::connector::Connector<Self>,
            state: &crate::connector::State<Self>,
            increment: &crate::connector::Increment<Self>,
            branch: &crate::connector::Branch<Self>,
            wanted: crate::connector::Mask,
            tally: &mut crate::connector::Tally,
        ) -> crate::connector::Branch<Self> {
            connector.follower().follow(state, increment, branch, wanted, tally)
        }

        #[$($inline)+]
        #[doc(hidden)]
        fn evaluate(
            connector: &crate::connector::Connector<Self>,
            evaluation: &mut crate::connector::Evaluation<Self>,
            state: &crate::connector::State<Self>,
            request: &crate::connector::Request,
            tally: &mut crate::connector::Tally,
        ) {
            connector.add_any(evaluation, state, request, tally);
        }

        #[$($inline)+]
        #[doc(hidden)]
        fn linearize(
            connector: &crate::connector::Connector<Self>,
            pair: &crate::node::Pair<Self>,
            branch: &crate::connector::Branch<Self>,
            wanted: crate::connector::Mask,
            out: &mut [crate::connector::Linear<Self>; 6],
        ) -> usize {
            connector.linearize_any(pair, branch, wanted, out)
        }

        #[$($inline)+]
        #[doc(hidden)]
        fn values(
            connector: &crate::connector::Connector<Self>,
            pair: &crate::node::Pair<Self>,
            branch: &crate::connector::Branch<Self>,
            wanted: crate::connector::Mask,
        ) -> crate::connector::Components<Self> {
            connector.values_any(pair, branch, wanted)
        }

        #[$($inline)+]
        #[doc(hidden)]
        fn compact_rows(
            connector: &crate::connector::Connector<Self>,
            state: &crate::connector::State<Self>,
            branch: &crate::connector::Branch<Self>,
            wanted: crate::connector::Mask,
            tally: &mut crate::connector::Tally,
        ) -> [Option<crate::connector::CompactRow<Self>>; 6] {
            connector.compact_rows_any(state, branch, wanted, tally)
        }

        #[$($inline)+]
        #[doc(hidden)]
        fn force_rows(
            connector: &crate::connector::Connector<Self>,
            state: &crate::connector::State<Self>,
            branch: &crate::connector::Branch<Self>,
            components: crate::connector::Mask,
            want: crate::force::Want,
            evaluation: Option<&crate::connector::Evaluation<Self>>,
            tally: &mut crate::connector::Tally,
        ) -> crate::force::ForceRows<Self> {
            connector.force_rows_any(state, branch, components, want, evaluation, tally)
        }

        #[$($inline)+]
        #[doc(hidden)]
        fn constrain(
            constraint: &crate::mpc::Constraint<Self>,
            state: &crate::mpc::State<Self>,
            previous: &[crate::connector::Turns<Self>; 2],
            turning: &crate::mpc::Turning<Self>,
            request: &crate::connector::Request,
            tally: &mut crate::connector::Tally,
        ) -> crate::mpc::Evaluation<Self> {
            constraint.evaluate_any(state, previous, turning, request, tally)
        }
    };
}
pub(crate) use entry_points;
