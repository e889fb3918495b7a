//! From `*CONNECTOR FRICTION` of a behaviour to frictions that can be evaluated.

use crate::behavior::friction::belt::Belt;
use crate::behavior::friction::coefficient::Coefficient;
use crate::behavior::friction::criterion::{
    Criterion, Internal, ParameterError, Pressing, Tangential, output_of,
};
use crate::behavior::friction::derived::{Contribution, Derived, DerivedPart, Form, Potential};
use crate::behavior::friction::is_divisor;
use crate::behavior::friction::stick::{ELASTIC_SLIP, StickStiffness};
use crate::behavior::friction::update::Friction;
use crate::behavior::law;
use crate::behavior::table::Table;
use pintle_kinematics::catalog::{COMPONENT, ConnectionType, Contact};
use pintle_scene as scene;
use pintle_scene::{
    Behavior, Code, Diagnostic, Extrapolation, FrictionCoefficient, FrictionKind, FrictionLaw, Independent,
    Source, Span, TableOptions, TableRow,
};

/// The frictions of a connector.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frictions {
    /// Those with Φ = P − μ F_N, each with sliding components of its own.
    pub frictions: Vec<Friction>,
    /// That of a belt around a ring (SLIPRING).
    pub belt: Option<Belt>,
}

/// The frictions that a behaviour gives to a connector of a type. The characteristic length is that of the default stick
/// stiffness (the initial length of the connector, or a typical element's); it is used only where the slip is a length and
/// `STICK STIFFNESS` is not given.
///
/// # Errors
/// A [`Diagnostic`] at the friction: predefined friction of a type that has none ([`Code::FrictionNotPredefined`]), numbers
/// that make no friction ([`Code::FrictionParameters`], [`Code::NumberOutOfRange`]), components that are not available
/// ([`Code::ActionNotAvailable`]), a component that slides twice ([`Code::RepeatedSuboption`]), tables out of order.
pub fn of_behavior(
    behavior: &Behavior,
    connection: &ConnectionType,
    is_planar: bool,
    characteristic_length: f64,
) -> Result<Frictions, Diagnostic> {
    let (mut all, mut spans) = (Frictions::default(), Vec::new());
    for friction in &behavior.friction {
        let builder = Builder { behavior, connection, friction, is_planar, characteristic_length };
        builder.add(&mut all)?;
        // A predefined one makes one or two.
        spans.resize(all.frictions.len(), friction.span);
    }
    let mut owners = [None::<Span>; 6];
    for (friction, span) in all.frictions.iter().zip(spans) {
        for k in friction.criterion.tangential.components() {
            if owners[k].replace(span).is_some() {
                let message = format!("component {} slides in two frictions", k + 1);
                return Err(Diagnostic::error(Code::RepeatedSuboption, span, message, "the second one")
                    .help("keep one friction for each component"));
            }
        }
    }
    Ok(all)
}

struct Builder<'a> {
    behavior: &'a Behavior,
    connection: &'a ConnectionType,
    friction: &'a scene::Friction,
    is_planar: bool,
    characteristic_length: f64,
}

/// What `*FRICTION` says.
struct Law {
    coefficient: Coefficient,
    maximum: Option<f64>,
    /// As a part of the characteristic length.
    tolerance: f64,
    /// As given, in the unit of the slip.
    elastic_slip: Option<f64>,
}

impl Builder<'_> {
    fn error(&self, code: Code, message: impl Into<String>, remedy: impl Into<String>) -> Diagnostic {
        Diagnostic::error(code, self.friction.span, message.into(), "this friction").help(remedy.into())
    }

    fn add(&self, all: &mut Frictions) -> Result<(), Diagnostic> {
        let law = match &self.friction.coefficient {
            Some(coefficient) => self.law(coefficient)?,
            None => {
                return Err(self.error(
                    Code::MissingFriction,
                    "there is no friction coefficient",
                    "add *FRICTION",
                ));
            }
        };
        match &self.friction.kind {
            FrictionKind::Predefined { constants } => self.predefined(constants, law, all),
            FrictionKind::User { component, potential, contact_force, independent, rows } => {
                let mut radius = 1.0;
                let (tangential, mixes) = match (component, potential) {
                    (Some(component), _) => {
                        (Tangential::Norm(vec![(self.available(*component)?, 1.0)]), false)
                    }
                    (None, Some(potential)) => {
                        let potential = self.potential(potential)?;
                        let components = potential.components();
                        let mixes = components.iter().any(|k| *k < 3) && components.iter().any(|k| *k >= 3);
                        (Tangential::Potential(potential), mixes)
                    }
                    (None, None) => {
                        let message = "this friction has no direction of slip";
                        let remedy = "give COMPONENT=…, or *CONNECTOR POTENTIAL below, or PREDEFINED";
                        return Err(self.error(Code::MissingParameter, message, remedy));
                    }
                };
                let pressing = match contact_force.as_ref().map(|source| &source.value) {
                    None => Pressing::Nothing,
                    Some(Source::Component(component)) => Pressing::Component(index(*component)),
                    Some(Source::Derived(name)) => Pressing::Derived(self.derived(name)?),
                };
                let mut rows = rows.clone();
                let given = self.effective_radius(&mut rows)?;
                if mixes {
                    radius = self.needed_radius(given)?;
                } else if let Some(given) = given {
                    let message = format!(
                        "the first item, {given}, would be an effective radius, and nothing here mixes forces and moments"
                    );
                    let remedy = "leave the first item of the data line empty; the internal contact force is the second";
                    return Err(self.error(Code::BadValue, message, remedy));
                }
                let internal = self.internal(&rows, independent.as_ref(), pressing != Pressing::Nothing)?;
                let output = output_of(&tangential.components());
                let criterion = Criterion { tangential, pressing, internal, output };
                all.frictions.push(self.finish(criterion, law, radius)?);
                Ok(())
            }
        }
    }

    fn predefined(&self, constants: &[Option<f64>], law: Law, all: &mut Frictions) -> Result<(), Diagnostic> {
        let name = &self.connection.name;
        let Some(friction) = &self.connection.friction else {
            let message = format!("{name} has no predefined friction");
            let remedy = "define the friction with COMPONENT= or *CONNECTOR POTENTIAL, or remove PREDEFINED";
            return Err(self.error(Code::FrictionNotPredefined, message, remedy));
        };
        let numbers = |error: ParameterError| {
            let symbols: Vec<&str> = friction.parameters.iter().map(|parameter| parameter.symbol).collect();
            let remedy = format!("the numbers are, in this order, {}", symbols.join(", "));
            self.error(Code::FrictionParameters, format!("{name}: {error}"), remedy)
        };
        if friction.criteria.iter().any(|criterion| criterion.contact == Contact::Belt) {
            if constants.iter().any(Option::is_some) {
                let message = format!("predefined friction of {name} takes no numbers");
                let remedy = "remove the data line; the angle of wrap stands in the section data";
                return Err(self.error(Code::FrictionParameters, message, remedy));
            }
            if all.belt.is_some() {
                let message = "a second predefined friction in one behaviour";
                return Err(self.error(Code::RepeatedSuboption, message, "keep one of the two"));
            }
            let stick_stiffness = self.stick_stiffness(&law, false)?;
            all.belt = Some(Belt { coefficient: law.coefficient, maximum: law.maximum, stick_stiffness });
            return Ok(());
        }
        let criteria = Criterion::predefined(friction, constants, &[], self.is_planar).map_err(numbers)?;
        for criterion in criteria {
            let law = Law { coefficient: law.coefficient.clone(), ..law };
            all.frictions.push(self.finish(criterion, law, 1.0)?);
        }
        Ok(())
    }

    fn finish(&self, criterion: Criterion, law: Law, radius: f64) -> Result<Friction, Diagnostic> {
        let stick_stiffness = self.stick_stiffness(&law, criterion.tangential.is_rotational())?;
        let Law { coefficient, maximum, .. } = law;
        Ok(Friction { criterion, coefficient, maximum, stick_stiffness, radius })
    }

    fn stick_stiffness(&self, law: &Law, is_rotational: bool) -> Result<StickStiffness, Diagnostic> {
        match self.friction.stick_stiffness {
            Some(stiffness) if is_divisor(stiffness) => Ok(StickStiffness::Given(stiffness)),
            Some(stiffness) => {
                let message = format!("STICK STIFFNESS={stiffness} is not positive");
                Err(self.error(Code::NumberOutOfRange, message, "give a positive stiffness, or none"))
            }
            None => {
                let length = if is_rotational { 1.0 } else { self.characteristic_length };
                let slip = law.elastic_slip.unwrap_or(law.tolerance * length);
                if is_divisor(slip) {
                    return Ok(StickStiffness::ElasticSlip(slip));
                }
                let message = match law.elastic_slip {
                    Some(slip) => format!("ELASTIC SLIP={slip} is not positive"),
                    None => {
                        let tolerance = law.tolerance;
                        format!("no elastic slip can be formed of {tolerance} times the length {length}")
                    }
                };
                Err(self.error(
                    Code::NumberOutOfRange,
                    message,
                    "give STICK STIFFNESS, or a positive ELASTIC SLIP or SLIP TOLERANCE",
                ))
            }
        }
    }

    fn law(&self, given: &FrictionCoefficient) -> Result<Law, Diagnostic> {
        let coefficient = match &given.law {
            FrictionLaw::Exponential { static_coefficient, kinetic_coefficient, decay } => {
                Coefficient::Exponential {
                    at_rest: *static_coefficient,
                    kinetic: *kinetic_coefficient,
                    decay: *decay,
                }
            }
            FrictionLaw::Table(rows) => {
                let columns = ["the slip rate", "the contact force"];
                let table = Table::new(rows, 1, &columns, Extrapolation::Constant)?;
                match rows.as_slice() {
                    [only] => Coefficient::Constant(only.values.first().copied().flatten().unwrap_or(0.0)),
                    _ => Coefficient::Table(table),
                }
            }
            FrictionLaw::TestData(rows) => self.test_data(rows)?,
        };
        Ok(Law {
            coefficient,
            maximum: given.maximum,
            tolerance: given.slip_tolerance.unwrap_or(ELASTIC_SLIP),
            elastic_slip: given.elastic_slip,
        })
    }

    fn test_data(&self, rows: &[Vec<Option<f64>>]) -> Result<Coefficient, Diagnostic> {
        let item =
            |row: usize, column: usize| rows.get(row).and_then(|row| row.get(column)).copied().flatten();
        let (Some(first), Some(second), Some(rate)) = (item(0, 0), item(1, 0), item(1, 1)) else {
            let message = "TEST DATA needs a coefficient at rest, and another with its slip rate";
            let remedy = "give a line with μ1, a line with μ2 and its slip rate, and if known a line with μ∞";
            return Err(self.error(Code::MissingData, message, remedy));
        };
        Coefficient::test_data(first, (second, rate), item(2, 0)).map_err(|error| {
            self.error(
                Code::NumberOutOfRange,
                error.to_string(),
                "give coefficients that fall with the slip rate",
            )
        })
    }

    /// A component (from 1) that may slide, from 0.
    fn available(&self, component: u8) -> Result<usize, Diagnostic> {
        let k = index(component);
        let in_plane = !self.is_planar || pintle_kinematics::catalog::PLANE[k];
        if self.connection.slots[k].is_available() && in_plane {
            return Ok(k);
        }
        let message = format!("{} is not an available component of {}", COMPONENT[k], self.connection.name);
        let available = self.connection.component_list(pintle_kinematics::catalog::Slot::is_available);
        Err(self.error(Code::ActionNotAvailable, message, format!("available are: {available}")))
    }

    fn options(&self, own: &TableOptions) -> Extrapolation {
        law::extrapolation([own, &self.behavior.table])
    }

    fn derived(&self, name: &str) -> Result<Derived, Diagnostic> {
        let Some(terms) = self.behavior.derived_components.get(name) else {
            let message = format!("there is no derived component {name}");
            let remedy = format!("define it by *CONNECTOR DERIVED COMPONENT, NAME={name}");
            return Err(self.error(Code::UnknownDerivedComponent, message, remedy));
        };
        let parts = terms.iter().map(|term| {
            let components: Vec<usize> = term.components.iter().map(|component| index(*component)).collect();
            let columns = term.independent.as_ref().map_or(0, |independent| independent.components.len());
            let names = vec!["an independent component"; columns];
            let scale = if term.rows.is_empty() {
                None
            } else {
                Some(Table::new(&term.rows, components.len(), &names, self.options(&term.table))?)
            };
            let independent = term.independent.as_ref().map(|independent| {
                (
                    independent.basis,
                    independent.components.iter().map(|component| index(*component)).collect(),
                )
            });
            Ok(DerivedPart { operator: term.operator, sign: term.sign, components, scale, independent })
        });
        Ok(Derived { parts: parts.collect::<Result<_, Diagnostic>>()? })
    }

    fn potential(&self, potential: &scene::Potential) -> Result<Potential, Diagnostic> {
        let mut contributions = Vec::with_capacity(potential.terms.len());
        for term in &potential.terms {
            let of = match &term.source.value {
                Source::Component(component) => Form::Component(self.available(*component)?),
                Source::Derived(name) => {
                    let derived = self.derived(name)?;
                    for part in &derived.parts {
                        for component in &part.components {
                            self.available(*component as u8 + 1)?;
                        }
                    }
                    Form::Derived(derived)
                }
            };
            contributions.push(Contribution {
                of,
                scale: term.scale,
                exponent: term.exponent.unwrap_or(potential.exponent),
                function: term.function,
                shift: term.shift,
                sign: term.sign,
            });
        }
        Potential::new(potential.operator, potential.exponent, contributions).map_err(|error| {
            Diagnostic::error(Code::NumberOutOfRange, potential.span, error.to_string(), "this potential")
                .help("give positive exponents, and α = β = 1 with H = NONE")
        })
    }

    /// The first column of the data, the effective radius; it is taken out.
    fn effective_radius(&self, rows: &mut [Vec<Option<f64>>]) -> Result<Option<f64>, Diagnostic> {
        let mut radius = None;
        for row in rows {
            let own = if row.is_empty() { None } else { row.remove(0) };
            match (radius, own) {
                (Some(first), Some(other)) if first != other => {
                    let message =
                        format!("the effective radius is {first} in one row and {other} in another");
                    return Err(self.error(Code::BadValue, message, "give one radius"));
                }
                (_, own) => radius = radius.or(own),
            }
        }
        Ok(radius)
    }

    /// The effective radius of a potential that mixes translations and rotations.
    fn needed_radius(&self, radius: Option<f64>) -> Result<f64, Diagnostic> {
        match radius {
            Some(radius) if radius > 0.0 && radius.is_finite() => Ok(radius),
            Some(radius) => {
                let message = format!("the effective radius {radius} is not positive");
                Err(self.error(Code::NumberOutOfRange, message, "give a positive length"))
            }
            None => {
                let message = "a potential of forces and moments needs an effective radius";
                Err(self.error(Code::MissingData, message, "give it as the first item of the data line"))
            }
        }
    }

    /// The internal contact force, over independent components and accumulated slip.
    fn internal(
        &self,
        rows: &[Vec<Option<f64>>],
        independent: Option<&Independent>,
        is_pressed: bool,
    ) -> Result<Internal, Diagnostic> {
        if rows.is_empty() {
            return Ok(Internal::Constant(0.0));
        }
        let components: Vec<usize> = independent
            .map(|independent| independent.components.iter().map(|component| index(*component)).collect())
            .unwrap_or_default();
        let columns = 1 + components.len() + 1;
        let rows: Vec<TableRow> = rows
            .iter()
            .map(|items| {
                let mut values = items.clone();
                let mut rest = values.split_off(columns.min(values.len())).into_iter();
                values.resize(columns, None);
                if is_pressed && values[0].is_none() {
                    values[0] = Some(0.0);
                }
                let temperature = rest.next().flatten();
                TableRow { values, temperature, fields: rest.collect(), span: self.friction.span }
            })
            .collect();
        let mut names = vec!["an independent component"; components.len()];
        names.push("the accumulated slip");
        let table = Table::new(&rows, 1, &names, self.options(&self.friction.table))?;
        if table.depends_on().next().is_none() {
            let force = rows.first().and_then(|row| row.values.first().copied().flatten()).unwrap_or(0.0);
            return Ok(Internal::Constant(force));
        }
        let basis = independent.map_or(scene::Basis::Position, |independent| independent.basis);
        Ok(Internal::Table { table, basis, components })
    }
}

/// A component number from 1 as an index.
fn index(component: u8) -> usize {
    usize::from(component.clamp(1, 6) - 1)
}
