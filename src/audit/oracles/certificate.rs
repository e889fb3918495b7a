//! What was proven once per type, outside this program: the formulas by JAX, the declaration by the transcribed manual.
//!
//! The certificates are part of the source (`certificates.json`). The test suite recomputes them: it fails where a type has none,
//! or one that no longer follows from the golden values and the transcribed tables.

use pintle_kinematics::catalog::{ConnectionType, Contact};
use pintle_model::behavior::friction::{Frictions, Pressing};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::LazyLock;

/// What is known of one type.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    /// States at which JAX, with formulas of its own, gives the same values, rates, rows and second derivatives.
    pub jax_states: u64,
    /// The page of the manual whose summary was typed a second time and agrees.
    pub manual_page: String,
    /// What of it could not be read, if anything.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unread: Option<String>,
}

impl Certificate {
    /// Whether all that the declaration says was read in the manual.
    pub fn is_declaration_read(&self) -> bool {
        !self.manual_page.is_empty() && self.unread.is_none()
    }

    /// The page, and what of it could not be read.
    pub fn source(&self) -> String {
        match &self.unread {
            Some(unread) => format!("{}; {unread} unread", self.manual_page),
            None => self.manual_page.clone(),
        }
    }
}

static CERTIFICATES: LazyLock<BTreeMap<String, Certificate>> =
    LazyLock::new(|| serde_json::from_str(include_str!("certificates.json")).unwrap_or_default());

/// All certificates, by type.
pub fn certificates() -> &'static BTreeMap<String, Certificate> {
    &CERTIFICATES
}

/// The certificate of a type; a free pair has what both of its halves have. `None` where a proof is missing.
pub fn certificate(connection: &ConnectionType) -> Option<Certificate> {
    if let Some(own) = CERTIFICATES.get(connection.name.as_ref()) {
        return Some(own.clone());
    }
    let [Some(translational), Some(rotational)] = connection.halves else { return None };
    let (t, r) = (CERTIFICATES.get(translational.name)?, CERTIFICATES.get(rotational.name)?);
    Some(Certificate {
        jax_states: t.jax_states.min(r.jax_states),
        manual_page: format!("{} + {}", t.manual_page, r.manual_page),
        unread: t.unread.iter().chain(&r.unread).cloned().reduce(|one, other| format!("{one}, {other}")),
    })
}

/// Whether JAX, with formulas of its own, gives the same forces and slopes of springs and dampers.
pub fn certifies_springs() -> bool {
    has_states("BEHAVIOR springs and dampers")
}

/// Whether JAX gives the same of every friction of a connector: of predefined ones by type, of those that a user defines by component
/// or potential, of belts. Derived components that press, which JAX has not, are not certified.
pub fn certifies_frictions(connection: &ConnectionType, frictions: &Frictions) -> bool {
    let of_user = || has_states("BEHAVIOR friction by potential");
    let is_certified = |pressing: &Pressing| match pressing {
        Pressing::Terms(_) => certifies_predefined(connection),
        Pressing::Component(_) | Pressing::Nothing => of_user(),
        Pressing::Derived(_) => false,
    };
    frictions.frictions.iter().all(|friction| is_certified(&friction.criterion.pressing))
        && (frictions.belt.is_none() || has_states("BEHAVIOR friction of a belt"))
}

/// Whether JAX gives the same of the predefined friction of a type, or of the half that it is of; `true` where there is none.
pub fn certifies_predefined(connection: &ConnectionType) -> bool {
    let Some(friction) = connection.friction else { return true };
    if friction.criteria.iter().any(|criterion| criterion.contact == Contact::Belt) {
        return has_states("BEHAVIOR friction of a belt");
    }
    let halves = connection.halves.iter().flatten().map(|half| half.name);
    let mut names = std::iter::once(connection.name.as_ref()).chain(halves);
    names.any(|name| has_states(&format!("BEHAVIOR friction of {name}")))
}

fn has_states(name: &str) -> bool {
    CERTIFICATES.get(name).is_some_and(|certificate| certificate.jax_states > 0)
}

/// The certificate of this name: of a relation, what it is of.
pub fn certificate_named(name: &str) -> Option<Certificate> {
    CERTIFICATES.get(name).cloned()
}

/// The certificate of a multi-point constraint, under the name `MPC BEAM`.
pub fn certificate_of_mpc(kind: pintle_kinematics::mpc::MpcType) -> Option<Certificate> {
    CERTIFICATES.get(&format!("MPC {}", kind.name())).cloned()
}
