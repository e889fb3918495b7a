//! A routine that is to be a friction.

use pintle_audit::Quantity;

/// What may be offered.
pub(crate) const OFFERS: [(&str, Quantity); 4] = [
    ("criterion", Quantity::FrictionCriterion),
    ("gradients", Quantity::FrictionGradient),
    ("friction_forces", Quantity::FrictionForce),
    ("friction_tangent", Quantity::FrictionTangent),
];
