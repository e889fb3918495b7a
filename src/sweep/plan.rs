//! What is swept, as a text: connectors with all that defines them, a seed, and the share that is judged.

use crate::SweepError;
use crate::generator::Generator;
use crate::summary::hex;
use pintle_audit::sampling::{aligned, definition, pair};
use pintle_kinematics::VERSION;
use pintle_kinematics::catalog::{ConnectionType, TABLE};
use pintle_kinematics::connector::Definition;
use pintle_kinematics::draw::Draw;
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3::exp;
use pintle_kinematics::vector::product;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// The form of the text, and of everything that decides which state an index has.
pub const SCHEMA: &str = "pintle-sweep-plan/3";

/// How many connectors of a type are swept: initial orientations that satisfy what the type constrains, and others.
const OF_A_TYPE: usize = 8;

/// What is swept.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// [`SCHEMA`].
    pub schema: String,
    /// The version of the program, by which types are drawn.
    pub version: String,
    /// By what the states are drawn.
    pub generator: Generator,
    /// What the states are drawn from.
    pub seed: String,
    /// The share of the states that is judged on 237 bits.
    pub share: f64,
    /// The SHA-256 of all that defines the connectors: those of types are drawn by sines, cosines and powers, which a machine may round otherwise.
    pub definitions: String,
    /// Whose numbers are swept: a routine, in a text by which workers start it; none for pintle's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub routine: Option<String>,
    /// What is summed up by itself.
    pub subjects: Vec<Subject>,
}

/// A connection type, or a connector of a scene.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Subject {
    /// Its name.
    pub name: String,
    /// The name of a connection type, or of the two of a pair, whose connectors are drawn by the worker.
    #[serde(default, rename = "type", skip_serializing_if = "Vec::is_empty")]
    pub of_type: Vec<String>,
    /// Connectors that are given.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub definitions: Vec<Definition>,
}

impl Subject {
    /// A connection type, as connectors that are drawn.
    pub fn of_type(connection: &ConnectionType) -> Self {
        let of_type = match connection.halves {
            [Some(t), Some(r)] => vec![t.name.to_string(), r.name.to_string()],
            _ => vec![connection.name.to_string()],
        };
        Self { name: connection.name.to_string(), of_type, definitions: Vec::new() }
    }

    /// A connector.
    pub fn of(name: String, definition: Definition) -> Self {
        Self { name, of_type: Vec::new(), definitions: vec![definition] }
    }

    /// Its connectors, those that are drawn and those that are given. Where `all` are wanted, some begin at orientations that the type forbids: their
    /// rows are not those that the manual prints.
    ///
    /// # Errors
    /// A type that there is not.
    pub fn connectors(&self, all: bool) -> Result<Vec<Definition>, SweepError> {
        let found = match self.of_type.as_slice() {
            [] => return Ok(self.definitions.clone()),
            [one, rest @ ..] => ConnectionType::named(one, rest.first().map(String::as_str)),
        };
        let connection = found.map_err(|error| SweepError::Plan(error.to_string()))?;
        let made = |i: usize| {
            let draw = &mut Draw::new(&format!("sweep {} {i}", connection.name));
            let mut q0 = aligned(&connection, draw);
            if i % 4 == 3 {
                q0 = product(&exp(draw.rotation(0.2, 0.4)), &q0);
            }
            let reference = draw.direction();
            definition(&connection, pair(reference, draw.triad(), &q0), 1.0)
        };
        let drawn = (0..OF_A_TYPE).filter(|i| all || i % 4 != 3);
        Ok(drawn.map(made).chain(self.definitions.iter().cloned()).collect())
    }

    /// Every type of the catalogue.
    pub fn catalogue() -> Vec<Self> {
        TABLE.iter().map(Self::of_type).collect()
    }
}

impl Plan {
    /// Of such subjects, and of somebody's routine where one is named.
    ///
    /// # Errors
    /// A type that there is not.
    pub fn new(
        generator: Generator,
        seed: &str,
        share: f64,
        subjects: Vec<Subject>,
        routine: Option<String>,
    ) -> Result<Self, SweepError> {
        let mut plan = Self {
            schema: SCHEMA.into(),
            version: VERSION.into(),
            generator,
            seed: seed.into(),
            share,
            definitions: String::new(),
            routine,
            subjects,
        };
        (_, plan.definitions) = plan.connectors()?;
        Ok(plan)
    }

    /// The connectors by subject, and the SHA-256 of all that defines them.
    ///
    /// # Errors
    /// A type that there is not.
    pub fn connectors(&self) -> Result<(Vec<Vec<Definition>>, String), SweepError> {
        let all: Vec<Vec<Definition>> =
            self.subjects.iter().map(|of| of.connectors(self.routine.is_none())).collect::<Result<_, _>>()?;
        let text = serde_json::to_string(&all).map_err(|error| SweepError::Plan(error.to_string()))?;
        Ok((all, sha256(&text)))
    }

    /// In words, in what another plan differs from this one; `None` where it does not.
    pub fn differs(&self, other: &Self) -> Option<String> {
        let mut found = Vec::new();
        if self.version != other.version {
            found.push(format!("pintle {} in place of {}", other.version, self.version));
        }
        if self.generator != other.generator {
            found.push(format!(
                "the generator {} in place of {}",
                other.generator.name(),
                self.generator.name()
            ));
        }
        if self.seed != other.seed {
            found.push(format!("the seed {:?} in place of {:?}", other.seed, self.seed));
        }
        if self.routine != other.routine {
            found.push("the numbers of another routine".into());
        }
        if self.share.to_bits() != other.share.to_bits() {
            found.push(format!("the share {} in place of {}", other.share, self.share));
        }
        let names = |of: &Self| of.subjects.iter().map(|subject| subject.name.clone()).collect::<Vec<_>>();
        if names(self) != names(other) {
            found.push("other connectors".into());
        } else if self.definitions != other.definitions {
            found.push("connectors of the same names that are defined otherwise".into());
        }
        (!found.is_empty()).then(|| found.join(", "))
    }

    /// As the text that every worker gets: equal plans have equal texts.
    ///
    /// # Errors
    /// Where a number of it is not finite.
    pub fn text(&self) -> Result<String, SweepError> {
        serde_json::to_string(self).map_err(|error| SweepError::Plan(error.to_string()))
    }

    /// From its text, whatever its version.
    pub(crate) fn parse_any(text: &str) -> Option<Self> {
        serde_json::from_str(text).ok()
    }

    /// From its text.
    ///
    /// # Errors
    /// A text that is none.
    pub fn parse(text: &str) -> Result<Self, SweepError> {
        #[derive(Deserialize)]
        struct Header {
            schema: String,
        }
        let refused = |what: String| Err(SweepError::Plan(what));
        let Header { schema } =
            serde_json::from_str(text).map_err(|error| SweepError::Plan(error.to_string()))?;
        if schema != SCHEMA {
            return refused(format!("its schema is {schema}, not {SCHEMA}"));
        }
        let plan: Self = serde_json::from_str(text).map_err(|error| SweepError::Plan(error.to_string()))?;
        if !(0.0..=1.0).contains(&plan.share) {
            return refused(format!("its share {} is not between 0 and 1", plan.share));
        }
        if plan.version != VERSION {
            return refused(format!("it is of pintle {}, and this is {VERSION}", plan.version));
        }
        Ok(plan)
    }
}

/// The SHA-256 of a text, in 64 hexadecimal digits.
pub fn sha256(text: &str) -> String {
    hex(&Sha256::digest(text.as_bytes()))
}

/// The length of a connector at rest.
pub fn length_of(definition: &Definition) -> f64 {
    let length = norm(definition.initial.reference);
    if length > 0.0 { length } else { 1.0 }
}
