//! What programs call and their languages have not: written out only where it is called.

use std::collections::BTreeSet;

/// The functions of a language, by the name under which [`crate::print::called`] has them; each needs none of the others.
type Runtime = &'static [(&'static str, &'static str)];

/// The functions called, in order.
pub fn text(runtime: Runtime, called: &BTreeSet<&'static str>) -> String {
    let wanted = runtime.iter().filter(|(name, _)| called.contains(name));
    wanted.map(|(_, text)| *text).collect::<Vec<_>>().join("\n")
}

/// The functions in C99.
pub const C: Runtime = &[
    ("reciprocal", include_str!("runtime/c/reciprocal.c")),
    ("sign", include_str!("runtime/c/sign.c")),
    ("norm", include_str!("runtime/c/norm.c")),
    ("quaternion", include_str!("runtime/c/quaternion.c")),
    ("log_coefficient", include_str!("runtime/c/log_coefficient.c")),
    ("root_coefficient", include_str!("runtime/c/root_coefficient.c")),
];

/// The functions in Rust.
pub const RUST: Runtime = &[
    ("reciprocal", include_str!("runtime/rust/reciprocal.rs")),
    ("sign", include_str!("runtime/rust/sign.rs")),
    ("select", include_str!("runtime/rust/select.rs")),
    ("norm", include_str!("runtime/rust/norm.rs")),
    ("quaternion", include_str!("runtime/rust/quaternion.rs")),
    ("log_coefficient", include_str!("runtime/rust/log_coefficient.rs")),
    ("root_coefficient", include_str!("runtime/rust/root_coefficient.rs")),
];

/// The functions in Python on JAX arrays.
pub const JAX: Runtime = &[
    ("reciprocal", include_str!("runtime/jax/reciprocal.py")),
    ("norm", include_str!("runtime/jax/norm.py")),
    ("quaternion", include_str!("runtime/jax/quaternion.py")),
    ("log_coefficient", include_str!("runtime/jax/log_coefficient.py")),
    ("root_coefficient", include_str!("runtime/jax/root_coefficient.py")),
    ("nearest_integer", include_str!("runtime/jax/nearest_integer.py")),
    ("unsigned", include_str!("runtime/jax/unsigned.py")),
];

/// The functions in Python on SymPy expressions.
pub const SYMPY: Runtime = &[
    ("reciprocal", include_str!("runtime/sympy/reciprocal.py")),
    ("norm", include_str!("runtime/sympy/norm.py")),
    ("quaternion", include_str!("runtime/sympy/quaternion.py")),
    ("log_coefficient", include_str!("runtime/sympy/log_coefficient.py")),
    ("root_coefficient", include_str!("runtime/sympy/root_coefficient.py")),
    ("nearest_integer", include_str!("runtime/sympy/nearest_integer.py")),
    ("select", include_str!("runtime/sympy/select.py")),
];
