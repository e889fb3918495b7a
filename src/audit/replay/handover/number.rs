//! The number that a counter-example is about, as this version of the program gives it; and the forms that the counter-example has.

use crate::case::Case;
use crate::case::failing::Failing;
use crate::case::quantity::Quantity;
use crate::judge::table::ResultTable;
use crate::replay::counterexample::CounterExample;
use crate::replay::handover::deck::Deck;
use crate::replay::handover::rust::literal;
use crate::replay::handover::{ExportError, about, embedded};

/// The number of that name in the table of a quantity.
fn found(tables: &[ResultTable], quantity: Quantity, name: &str) -> Option<f64> {
    let mut entries =
        tables.iter().filter(|table| table.quantity == quantity).flat_map(|table| &table.entries);
    entries.find(|entry| entry.name == name).map(|entry| entry.got)
}

impl CounterExample {
    /// The number in question of what is no connector, as this version of the program gives it from the values.
    ///
    /// # Errors
    /// Another schema, values that make no such thing or are not finite; an entry that they do not give.
    pub fn number(&self) -> Result<f64, ExportError> {
        let failing = self.failing()?;
        let found = match (&failing, self.quantity) {
            (Failing::Mpc(case), None) => self.law.and_then(|law| case.sum_of_law(law.name, &self.entry)),
            (Failing::Relation(case), None) => {
                self.law.and_then(|law| case.sum_of_law(law.name, &self.entry))
            }
            (Failing::Mpc(case), Some(quantity)) => found(&case.tables(), quantity, &self.entry),
            (other, Some(quantity)) => {
                found(&other.tables(), quantity, &self.entry).or_else(|| match other {
                    Failing::Friction(case) if quantity == Quantity::FrictionForce => {
                        case.result(&self.entry)
                    }
                    _ => None,
                })
            }
            _ => None,
        };
        found.ok_or_else(|| {
            ExportError::Lost(format!("{} is no number of its {}", self.entry, self.kind.name()))
        })
    }

    /// A test in Rust that compares the number in question of what is no connector with what it must be.
    fn test_of_number(&self) -> Result<String, ExportError> {
        self.number()?;
        let title = self.failing()?.title();
        Ok(format!(
            "// {}\nuse pintle::audit::CounterExample;\n\n{}#[test]\nfn counter_example() {{\n    \
             let got: f64 = CounterExample::read(COUNTER_EXAMPLE).unwrap().number().unwrap();\n    \
             let want: f64 = {};\n    let tolerance: f64 = {};\n    \
             assert!((got - want).abs() <= tolerance, \"{{got:e}}, must be {{want:e}} within {{tolerance:e}}\");\n}}\n",
            about(&title, self),
            embedded(self)?,
            literal(self.want.0),
            literal(self.tolerance.0)
        ))
    }

    /// A test in Rust that needs this crate and nothing else.
    ///
    /// # Errors
    /// What cannot be replayed, and what is no number of one state; it says which other forms there are.
    pub fn rust(&self) -> Result<String, ExportError> {
        self.of_rust().map_err(|error| self.with_forms(error))
    }

    fn of_rust(&self) -> Result<String, ExportError> {
        match self.failing()? {
            Failing::Connector(case) => self.test_of_connector(&case),
            _ => self.test_of_number(),
        }
    }

    /// A script of a connector for Python with JAX.
    ///
    /// # Errors
    /// What cannot be replayed, what is of no connector, and what the reference formulas do not have; it says which other forms there are.
    pub fn jax(&self) -> Result<String, ExportError> {
        self.of_jax().map_err(|error| self.with_forms(error))
    }

    fn of_jax(&self) -> Result<String, ExportError> {
        self.of_connector(|case| self.script(case))
    }

    /// A deck of a connector and its states.
    ///
    /// # Errors
    /// What cannot be replayed, what is of no connector, and what a deck cannot say; it says which other forms there are.
    pub fn deck(&self) -> Result<Deck, ExportError> {
        self.of_deck().map_err(|error| self.with_forms(error))
    }

    fn of_deck(&self) -> Result<Deck, ExportError> {
        self.of_connector(|case| self.deck_of_connector(case))
    }

    fn of_connector<T>(&self, make: impl Fn(&Case) -> Result<T, ExportError>) -> Result<T, ExportError> {
        match self.failing()? {
            Failing::Connector(case) => make(&case),
            _ => Err(ExportError::Lost(format!(
                "scripts and decks are of connectors, and this is of a {}",
                self.kind.name()
            ))),
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
