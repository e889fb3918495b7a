//! What programs call and their languages have not: written out only where it is called.

use std::collections::BTreeSet;

/// The functions of a language, by the name under which [`super::called`] has them; each needs none of the others.
type Runtime = &'static [(&'static str, &'static str)];

/// The functions called, in order.
pub(crate) fn text(runtime: Runtime, called: &BTreeSet<&'static str>) -> String {
    let wanted = runtime.iter().filter(|(name, _)| called.contains(name));
    wanted.map(|(_, text)| *text).collect::<Vec<_>>().join("\n")
}

pub(crate) const C: Runtime = &[
    ("reciprocal", include_str!("runtime/reciprocal.c")),
    ("sign", include_str!("runtime/sign.c")),
    ("norm", include_str!("runtime/norm.c")),
    ("quaternion", include_str!("runtime/quaternion.c")),
    ("log_coefficient", include_str!("runtime/log_coefficient.c")),
    ("root_coefficient", include_str!("runtime/root_coefficient.c")),
];

pub(crate) const RUST: Runtime = &[
    ("reciprocal", include_str!("runtime/reciprocal.rs")),
    ("sign", include_str!("runtime/sign.rs")),
    ("select", include_str!("runtime/select.rs")),
    ("norm", include_str!("runtime/norm.rs")),
    ("quaternion", include_str!("runtime/quaternion.rs")),
    ("log_coefficient", include_str!("runtime/log_coefficient.rs")),
    ("root_coefficient", include_str!("runtime/root_coefficient.rs")),
];

pub(crate) const JAX: Runtime = &[
    ("reciprocal", include_str!("runtime/reciprocal_jax.py")),
    ("norm", include_str!("runtime/norm_jax.py")),
    ("quaternion", include_str!("runtime/quaternion_jax.py")),
    ("log_coefficient", include_str!("runtime/log_coefficient_jax.py")),
    ("root_coefficient", include_str!("runtime/root_coefficient_jax.py")),
    ("nearest_integer", include_str!("runtime/nearest_integer_jax.py")),
    ("unsigned", include_str!("runtime/unsigned_jax.py")),
];

pub(crate) const SYMPY: Runtime = &[
    ("reciprocal", include_str!("runtime/reciprocal_sympy.py")),
    ("norm", include_str!("runtime/norm_sympy.py")),
    ("quaternion", include_str!("runtime/quaternion_sympy.py")),
    ("log_coefficient", include_str!("runtime/log_coefficient_sympy.py")),
    ("root_coefficient", include_str!("runtime/root_coefficient_sympy.py")),
    ("nearest_integer", include_str!("runtime/nearest_integer_sympy.py")),
    ("select", include_str!("runtime/select_sympy.py")),
];
