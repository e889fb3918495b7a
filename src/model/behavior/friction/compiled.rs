//! What is asked of frictions, compiled with this crate on doubles and on 237-bit numbers, and not again with every crate that asks.

use crate::behavior::friction::belt::{Belt, BeltInput, BeltTangent};
use crate::behavior::friction::criterion::{Criterion, Derivatives};
use crate::behavior::friction::update::{Branch, Friction, FrictionOutcome, Input, State, Tangent};
use crate::behavior::friction::{Context, Flag, Ordered, Point};
use pintle_kinematics::Differentiable;
use pintle_kinematics::scalar::Wide;

/// The methods of [`Frictional`], declared or with their code.
macro_rules! entry_points {
    ($($code:ident)?) => {
        entry_points! { $($code)?
            fn updated(friction: &Friction, state: &State<Self>, input: &Input<'_, Self>, branch: Branch) -> FrictionOutcome<Self>
                = friction.advance(state, input, branch);
            fn tangent(
                friction: &Friction, state: &State<Self>, input: &Input<'_, Self>, branch: Branch, failed: [bool; 6]
            ) -> (FrictionOutcome<Self>, Tangent<Self>) = friction.tangent_any(state, input, branch, failed);
            fn limit(friction: &Friction, state: &State<Self>, input: &Input<'_, Self>, increment: Self) -> [Self; 2]
                = friction.limit_any(state, input, increment);
            fn derivatives(
                criterion: &Criterion, forces: &[Self; 6], coefficient: Self, maximum: Option<f64>, context: &Context<'_, Self>
            ) -> (Point<Derivatives<Self>>, Vec<Flag>) = criterion.derivatives_any(forces, coefficient, maximum, context);
            fn belt(belt: &Belt, tension: [Self; 2], angle: Self, coefficient: Self) -> (Point<Derivatives<Self>>, Vec<Flag>)
                = belt.derivatives_any(tension, angle, coefficient);
            fn belt_updated(belt: &Belt, state: &State<Self>, input: &BeltInput<'_, Self>, branch: Branch) -> FrictionOutcome<Self>
                = belt.advance(state, input, branch);
            fn belt_tangent(
                belt: &Belt, state: &State<Self>, input: &BeltInput<'_, Self>, branch: Branch
            ) -> (FrictionOutcome<Self>, BeltTangent<Self>) = belt.tangent_any(state, input, branch);
        }
    };
    ($(fn $name:ident($($argument:ident: $type:ty),*) -> $result:ty = $body:expr;)+) => { $(
        #[doc(hidden)]
        fn $name($($argument: $type),*) -> $result;
    )+ };
    (code $(fn $name:ident($($argument:ident: $type:ty),*) -> $result:ty = $body:expr;)+) => { $(
        #[inline(never)]
        fn $name($($argument: $type),*) -> $result {
            $body
        }
    )+ };
}

/// The numbers of which this crate holds the code of frictions.
pub trait Frictional: Ordered + Differentiable {
    entry_points!();
}

impl Frictional for f64 {
    entry_points!(code);
}

impl Frictional for Wide {
    entry_points!(code);
}

impl Friction {
    /// The increment from a state.
    pub fn update<R: Frictional>(
        &self,
        state: &State<R>,
        input: &Input<'_, R>,
        branch: Branch,
    ) -> FrictionOutcome<R> {
        R::updated(self, state, input, branch)
    }

    /// The increment from a state with its exact consistent tangent.
    ///
    /// ```
    /// use pintle_model::behavior::friction::{Branch, Coefficient, Context, Criterion, Friction, Input, State, Status, StickStiffness};
    /// use pintle_kinematics::catalog::ConnectionType;
    /// let slot = ConnectionType::named("SLOT", None)?.friction.ok_or("no friction")?;
    /// let criterion = Criterion::predefined(&slot, &[], &[], false)?.remove(0);
    /// let stick_stiffness = StickStiffness::Given(1e4);
    /// let friction =
    ///     Friction { criterion, coefficient: Coefficient::Constant(0.5), maximum: None, stick_stiffness, radius: 1.0 };
    /// let input = Input {
    ///     displacement: [0.1, 0.0, 0.0, 0.0, 0.0, 0.0],
    ///     forces: [0.0, 3.0, 4.0, 0.0, 0.0, 0.0],
    ///     duration: None,
    ///     context: Context::default(),
    /// };
    /// let (outcome, tangent) = friction.tangent(&State::default(), &input, Branch::Decided);
    /// assert_eq!((outcome.status, outcome.force[0]), (Status::Slip, 2.5)); // μ F_N = 0.5 · 5
    /// assert_eq!(tangent.force[0].displacement[0], 0.0);
    /// assert_eq!(tangent.force[0].forces[1..3], [0.3, 0.4]); // μ ∂F_N/∂λ
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn tangent<R: Frictional>(
        &self,
        state: &State<R>,
        input: &Input<'_, R>,
        branch: Branch,
    ) -> (FrictionOutcome<R>, Tangent<R>) {
        self.tangent_while(state, input, branch, [false; 6])
    }

    /// The same where some components slide no more: their positions and motions move, and no slip follows.
    pub fn tangent_while<R: Frictional>(
        &self,
        state: &State<R>,
        input: &Input<'_, R>,
        branch: Branch,
        failed: [bool; 6],
    ) -> (FrictionOutcome<R>, Tangent<R>) {
        R::tangent(self, state, input, branch, failed)
    }

    /// F_N and the limit after the slip Δγ, at the contact force of an increment.
    pub fn limit_after<R: Frictional>(&self, state: &State<R>, input: &Input<'_, R>, increment: R) -> [R; 2] {
        R::limit(self, state, input, increment)
    }
}

impl Criterion {
    /// P, F_C, F_N and Φ with exact first and second derivatives with respect to the forces.
    pub fn derivatives<R: Frictional>(
        &self,
        forces: &[R; 6],
        coefficient: R,
        maximum: Option<f64>,
        context: &Context<'_, R>,
    ) -> (Point<Derivatives<R>>, Vec<Flag>) {
        R::derivatives(self, forces, coefficient, maximum, context)
    }
}

impl Belt {
    /// P, the limit and Φ, as [`Belt::at`] gives them, with exact first and second derivatives with respect to T1, T2 and α, in this order; the others are zero.
    pub fn derivatives<R: Frictional>(
        &self,
        tension: [R; 2],
        angle: R,
        coefficient: R,
    ) -> (Point<Derivatives<R>>, Vec<Flag>) {
        R::belt(self, tension, angle, coefficient)
    }

    /// The increment from a state.
    pub fn update<R: Frictional>(
        &self,
        state: &State<R>,
        input: &BeltInput<'_, R>,
        branch: Branch,
    ) -> FrictionOutcome<R> {
        R::belt_updated(self, state, input, branch)
    }

    /// The increment from a state with its exact consistent tangent.
    pub fn tangent<R: Frictional>(
        &self,
        state: &State<R>,
        input: &BeltInput<'_, R>,
        branch: Branch,
    ) -> (FrictionOutcome<R>, BeltTangent<R>) {
        R::belt_tangent(self, state, input, branch)
    }
}
