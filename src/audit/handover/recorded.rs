//! Counter-examples of what is no connector in another form.

use super::deck::Deck;
use super::rust::literal;
use super::{ExportError, comment, constraint, friction};
use crate::audit::failing::{Example, Failing};
use crate::audit::quantity::Quantity;
use crate::audit::recorded::{FoundIn, Recorded};

impl Recorded {
    /// What it is of, in words.
    pub(super) fn heading(&self) -> String {
        self.failing().map_or_else(|_| self.kind.name().to_string(), |failing| failing.title())
    }

    /// What was given, what it must be, and its tolerance.
    pub(super) fn numbers(&self) -> String {
        format!("given {}, must be {}, tolerance {}", self.got, self.want, self.tolerance)
    }

    /// The number in question, as this version of the program gives it from the recorded values.
    ///
    /// # Errors
    /// Another schema, values that make no such thing or are not finite; an entry that they do not give.
    pub fn number(&self) -> Result<f64, ExportError> {
        let failing = self.failing()?;
        let found = match (&failing, self.quantity) {
            (Failing::Mpc(case), _) => constraint::got(self, case),
            (other, Some(quantity)) => {
                let sheets = other.sheets();
                let entries =
                    sheets.iter().filter(|sheet| sheet.quantity == quantity).flat_map(|sheet| &sheet.entries);
                let found = entries.into_iter().find(|entry| entry.name == self.entry).map(|entry| entry.got);
                found.or_else(|| match other {
                    Failing::Friction(case) if quantity == Quantity::FrictionForce => {
                        case.result(&self.entry)
                    }
                    _ => None,
                })
            }
            _ => None,
        };
        found.ok_or_else(|| self.unknown())
    }

    /// A test in Rust that needs this crate and nothing else: of a constraint, what it is and its state, typed out; of a law of one, and of a
    /// friction, a belt, springs and dampers, whose tables may be long, the counter-example itself. The number in question is compared with what it must be.
    ///
    /// # Errors
    /// What cannot be replayed; a mismatch of what is no number of it.
    pub fn rust(&self) -> Result<String, ExportError> {
        self.number()?;
        let (imports, before, statements) = match self.failing()? {
            Failing::Mpc(case) if constraint::law(self).is_none() => {
                let Some(place) = constraint::place(self, &case) else { return Err(self.unknown()) };
                (constraint::IMPORTS.to_string(), String::new(), constraint::rust(&case, place))
            }
            _ => {
                let statements = "    let example = match Example::read(COUNTER_EXAMPLE).unwrap() {\n        Example::Other(example) => example,\n        \
                     Example::Connector(_) => unreachable!(\"it is of no connector\"),\n    };\n    let got: f64 = example.number().unwrap();\n";
                ("use pintle::audit::Example;\n".to_string(), super::embedded(self)?, statements.to_string())
            }
        };
        Ok(format!(
            "// {}\n{imports}\n{before}#[test]\nfn counter_example() {{\n{statements}    let want: f64 = {};\n    \
             let tolerance: f64 = {};\n    \
             assert!((got - want).abs() <= tolerance, \"{{got:e}}, must be {{want:e}} within {{tolerance:e}}\");\n}}\n",
            comment(&super::about(&self.heading(), self)),
            literal(self.want.0),
            literal(self.tolerance.0)
        ))
    }

    /// A script for Python with JAX and NumPy, and nothing else: of a constraint, a friction, a belt, formulas that share nothing with this
    /// crate. Of a friction it solves the equations of stick and slip by itself, and differentiates the solution.
    ///
    /// # Errors
    /// What cannot be replayed; slopes of springs and dampers; an entry that it does not give.
    pub fn jax(&self) -> Result<String, ExportError> {
        match self.failing()? {
            Failing::Mpc(_) if constraint::law(self).is_some() => {
                Err(self.has_no("script for JAX where a law is broken: it relates numbers of this program"))
            }
            Failing::Mpc(case) => {
                let Some(place) = constraint::place(self, &case) else { return Err(self.unknown()) };
                Ok(constraint::jax(self, &case, place))
            }
            Failing::Friction(case) => friction::jax_of_friction(self, &case),
            Failing::Belt(case) => friction::jax_of_belt(self, &case),
            _ => Err(self.has_no("script for JAX: the formulas there are of kinematics and friction")),
        }
    }

    /// A deck, and the states that lead to the one in question: of a constraint, with its shrunk values; of a friction, a belt, springs
    /// and dampers, the scene that it was found in, as it was audited. Of the predefined friction of a type at drawn forces, a connector of that
    /// type and an increment under these forces, with its shrunk values.
    ///
    /// # Errors
    /// What cannot be replayed. What was found at drawn states or under drawn forces and is no predefined friction of a type, or starts from
    /// what earlier increments left, or is Φ at tractions beyond the limit.
    pub fn deck(&self) -> Result<Deck, ExportError> {
        let failing = self.failing()?;
        match (failing, &self.found_in) {
            (Failing::Mpc(case), _) => constraint::deck(self, &case),
            (_, Some(FoundIn { state, deck, states })) => {
                let about = super::about(&self.heading(), self);
                let text = format!(
                    "** {about}\n** {}\n** The scene as it was audited; the numbers above are of the counter-example, which was shrunk from its state \
                     {state}.\n** Evaluate it there: pintle eval THIS --states THOSE --show {state} --outputs CU,CEF,CVF,CSF,TANGENT\n{deck}",
                    self.numbers()
                );
                Ok(Deck { text, states: states.clone() + "\n", differences: Vec::new() })
            }
            (Failing::Friction(case), None) => friction::deck(self, &case),
            _ => Err(self
                .has_no("deck: it was found at a drawn state or under drawn forces, which no scene gives")),
        }
    }

    pub(super) fn unknown(&self) -> ExportError {
        ExportError::Lost(format!("{} is no number of its {}", self.entry, self.kind.name()))
    }

    pub(super) fn has_no(&self, form: &str) -> ExportError {
        ExportError::Lost(format!("what is of a {} has no {form}", self.kind.name()))
    }
}

impl Example {
    /// A test in Rust.
    ///
    /// # Errors
    /// What cannot be replayed, and what is no number of one state; it says which other forms there are.
    pub fn rust(&self) -> Result<String, ExportError> {
        self.of_rust().map_err(|error| self.with_forms(error))
    }

    fn of_rust(&self) -> Result<String, ExportError> {
        match self {
            Self::Connector(example) => example.rust(),
            Self::Other(recorded) => recorded.rust(),
        }
    }

    /// A script for Python with JAX.
    ///
    /// # Errors
    /// What cannot be replayed, and what the reference formulas do not have; it says which other forms there are.
    pub fn jax(&self) -> Result<String, ExportError> {
        self.of_jax().map_err(|error| self.with_forms(error))
    }

    fn of_jax(&self) -> Result<String, ExportError> {
        match self {
            Self::Connector(example) => example.jax(),
            Self::Other(recorded) => recorded.jax(),
        }
    }

    /// A deck and its states.
    ///
    /// # Errors
    /// What cannot be replayed, and what a deck cannot say; it says which other forms there are.
    pub fn deck(&self) -> Result<Deck, ExportError> {
        self.of_deck().map_err(|error| self.with_forms(error))
    }

    fn of_deck(&self) -> Result<Deck, ExportError> {
        match self {
            Self::Connector(example) => example.deck(),
            Self::Other(recorded) => recorded.deck(),
        }
    }

    /// A refusal with the forms that are not refused.
    fn with_forms(&self, refused: ExportError) -> ExportError {
        if self.failing().is_err() {
            return refused;
        }
        let forms = [
            ("a Rust test (--export rust)", self.of_rust().is_ok()),
            ("a script for JAX (--export jax)", self.of_jax().is_ok()),
            ("a deck (--export inp)", self.of_deck().is_ok()),
        ];
        let there: Vec<&str> = forms.into_iter().filter(|(_, is)| *is).map(|(form, _)| form).collect();
        let there = if there.is_empty() {
            "`pintle replay` judges it".to_string()
        } else {
            format!("it can be exported as {}", there.join(" or "))
        };
        ExportError::Lost(format!("{refused}; {there}"))
    }
}
