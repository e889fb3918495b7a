//! The mathematics of connectors: numbers that carry derivatives, rotations, measures, the catalogue of connection types, and what one
//! connector, one multi-point constraint, or a batch of them gives at a state.
//!
//! | module | question |
//! |---|---|
//! | [`scalar`] | what is a number, and how do its functions keep their derivatives? |
//! | [`vector`], [`so3`] | how are vectors and rotations handled? |
//! | [`node`] | what does a measure see of two nodes, and how do its derivatives reach their degrees of freedom? |
//! | [`measure`] | what is measured? The mathematics |
//! | [`catalog`] | which connection types are there? The data |
//! | [`connector`] | what does one connector give at one state, after its history? |
//! | [`batch`] | what do many connectors of one type give, four at a time? |
//! | [`force`] | what do the forces of its components do to its nodes? |
//! | [`mpc`] | what does one multi-point constraint give at one state? |
//! | [`relation`] | … and one constraint between any number of nodes? |
//! | [`draw`] | which numbers are drawn, the same on every machine? |

mod compiled;

pub mod batch;
pub mod catalog;
pub mod connector;
pub mod draw;
pub mod force;
pub mod measure;
pub mod mpc;
pub mod node;
pub mod relation;
pub mod scalar;
pub mod so3;
pub mod vector;

pub use compiled::Differentiable;

/// The version of pintle, as every report states it.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// An enumeration, each variant beside its name: `ALL` are the variants in this order, `name` is what one is called.
///
/// ```
/// pintle_kinematics::named! {
///     /// A way.
///     #[derive(Clone, Copy, Debug, PartialEq)]
///     enum Way {
///         /// To and fro.
///         Forth = "back and forth",
///     }
/// }
/// assert_eq!(Way::ALL.map(Way::name), ["back and forth"]);
/// ```
#[macro_export]
macro_rules! named {
    (
        $(#[$meta:meta])*
        $visible:vis enum $name:ident { $($(#[$of:meta])* $variant:ident = $word:literal,)+ }
    ) => {
        $(#[$meta])*
        $visible enum $name { $($(#[$of])* $variant,)+ }

        impl $name {
            /// All of them, in order.
            $visible const ALL: [Self; [$($word),+].len()] = [$(Self::$variant),+];

            /// What it is called.
            $visible const fn name(self) -> &'static str {
                match self { $(Self::$variant => $word),+ }
            }
        }
    };
}
