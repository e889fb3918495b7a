//! What the catalogue's terms are called in reports.

use pintle_kinematics::catalog::{Availability, Class, ConnectionType, Orientation, Slot};
use pintle_kinematics::measure::{SingularClass, Unit};
use std::borrow::Cow;

/// Signs of reported forces, moments and nodal vectors: one paragraph for every page and every JSON header.
pub const SIGNS: &str = "Forces and moments of components are internal: a positive one resists growth of its component \
     (tension for AXIAL), so that CTF = CEF + CVF + CSF + CRF − CCF adds up. Nodal force vectors are residual-side: the \
     transposed gradient of the component times its force, and of a held rotation the moment as printed. The force on the body is minus that. Displacements are \
     positions minus initial positions; rotations are positive counter-clockwise about their axis, from a to b.";

/// What rows of derivatives are, and with respect to what.
pub const ROWS: &str = "A row is the gradient of the component: of the residual for a constrained component, of the \
     displacement for any other. Columns are the nodal degrees of freedom x, θ, Ψ (1–3, 4–6, 10) of a and then of b, \
     global components. Rotations vary spatially, C → exp(δθ^) C, so that θ̇ is the angular velocity.";

/// The symbols in formulas.
pub const NOTATION: &str = "d = xb − xa; e1a … e3b: the directions carried by a and b; Q = AᵀB, Qij = eia·ejb; a final 0 \
     marks the initial value.";

/// The class as a word for a narrow column.
pub(crate) const fn short_class(class: Class) -> &'static str {
    match class {
        Class::BasicTranslational => "translational",
        Class::BasicRotational => "rotational",
        Class::SpecialisedRotational => "specialised rot.",
        Class::Assembled => "assembled",
        Class::Complex => "complex",
    }
}

/// The class as the summary table prints it.
pub(crate) const fn class(connection: &ConnectionType) -> &'static str {
    if matches!(connection.name, Cow::Owned(_)) {
        return "two basic types, freely paired";
    }
    match connection.class {
        Class::BasicTranslational => "basic (translational)",
        Class::BasicRotational => "basic (rotational)",
        Class::SpecialisedRotational => "basic (specialised rotational)",
        Class::Assembled => "assembled",
        Class::Complex => "complex",
    }
}

/// The names of the halves of an assembled type.
pub(crate) fn made_of(connection: &ConnectionType) -> Vec<&'static str> {
    match connection.halves {
        [Some(translational), Some(rotational)] => vec![translational.name, rotational.name],
        _ => Vec::new(),
    }
}

pub(crate) const fn orientation_letter(orientation: Orientation) -> &'static str {
    match orientation {
        Orientation::Ignored => "I",
        Orientation::Optional => "O",
        Orientation::Required => "R",
    }
}

pub(crate) const fn orientation(orientation: Orientation) -> &'static str {
    match orientation {
        Orientation::Ignored => "ignored",
        Orientation::Optional => "optional",
        Orientation::Required => "required",
    }
}

/// Where a type can be used.
pub(crate) const fn availability(availability: Availability) -> &'static str {
    match availability {
        Availability::Always => "both",
        Availability::ExplicitOnly => "Explicit",
        Availability::Never => "–",
        Availability::StandardOnly => "Standard",
    }
}

/// The role of a component.
pub(crate) const fn role(slot: Slot) -> &'static str {
    match slot {
        Slot::Absent => "absent",
        Slot::Available(_) => "available",
        Slot::Constrained(..) => "constrained",
        Slot::Measured(_) => "measured",
    }
}

/// A unit in words; a scene brings its own length.
pub(crate) const fn unit(unit: Unit) -> &'static str {
    match unit {
        Unit::Length => "length",
        Unit::Angle => "rad",
        Unit::None => "1",
    }
}

/// The class of a singular set, and what happens there.
pub(crate) const fn singular_class(class: SingularClass) -> (&'static str, &'static str) {
    match class {
        SingularClass::Kink => ("kink", "the value continues, first derivatives depend on the approach"),
        SingularClass::TrueSingularity => ("true singularity", "derivatives grow without bound on approach"),
        SingularClass::BranchCut => {
            ("branch cut", "the principal value jumps by a period, the continued one does not")
        }
        SingularClass::Reversal => {
            ("reversal", "the value jumps to its opposite, first derivatives depend on the approach")
        }
        SingularClass::Removable => ("removable", "value and derivatives continue, nothing is lost"),
    }
}

/// The status of a friction.
pub(super) const fn slip(status: pintle_model::behavior::friction::Status) -> &'static str {
    use pintle_model::behavior::friction::Status;
    match status {
        Status::Stick => "stick",
        Status::Slip => "slip",
        Status::Free => "free",
    }
}
