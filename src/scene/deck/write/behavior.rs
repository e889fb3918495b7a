//! Connector behaviours, one keyword after the other.

use crate::choice::Choice;
use crate::deck::write::{Deck, Name, dependencies, fields, quoted, refuse};
use crate::diagnostic::{Code, Result};
use crate::document::form;
use crate::document::form::{
    Behavior, Damage, Entries, Friction, Hardening, Independent, Law, Lock, Plasticity, Potential, Source,
};
use crate::span::{Span, Spanned};

impl Deck {
    pub(super) fn behavior(&mut self, name: &Name, behavior: &Spanned<Behavior>) -> Result<()> {
        let span = name.span;
        let value = &behavior.value;
        self.keyword("CONNECTOR BEHAVIOR", span);
        self.name("NAME", name)?;
        self.word("INTEGRATION", value.integration, span);
        self.options(value.options(), span);
        self.go();
        self.constitutive_reference(&value.constitutive_reference)?;
        for (name, terms) in &value.derived_components.0 {
            for term in terms {
                self.derived_term(name, term)?;
            }
        }
        for law in &value.elasticity {
            if let Some(span) = law.value.r#type.map(|_| law.span) {
                let message = "an elasticity has no type".to_owned();
                return Err(refuse(
                    Code::SceneUnknownField,
                    span,
                    message,
                    "not a field here",
                    "remove it, or move it to damping",
                ));
            }
            self.law("CONNECTOR ELASTICITY", law)?;
        }
        for law in &value.damping {
            self.law("CONNECTOR DAMPING", law)?;
        }
        for friction in &value.friction {
            self.friction(friction)?;
        }
        for plasticity in &value.plasticity {
            self.plasticity(plasticity)?;
        }
        for damage in &value.damage {
            self.damage(damage)?;
        }
        for stop in &value.stops {
            self.keyword("CONNECTOR STOP", stop.span);
            self.component_of(Some(stop.value.component));
            self.go();
            let at = |value: Option<Spanned<f64>>| {
                (value.map(|value| value.value), value.map_or(stop.span, |value| value.span))
            };
            self.begin(stop.span);
            let limits = [at(stop.value.lower), at(stop.value.upper)];
            for (value, span) in limits {
                self.maybe(value, span);
            }
            self.end(true);
        }
        for (keyword, parameter, list) in
            [("CONNECTOR LOCK", "LOCK", &value.locks), ("CONNECTOR FAILURE", "RELEASE", &value.failures)]
        {
            for lock in list {
                self.lock(keyword, parameter, lock)?;
            }
        }
        Ok(())
    }

    fn constitutive_reference(&mut self, reference: &Entries<Spanned<f64>>) -> Result<()> {
        let Some((first, _)) = reference.0.first() else { return Ok(()) };
        let mut values = [None; 6];
        for (component, value) in &reference.0 {
            let place = component.value.parse::<usize>().ok().and_then(|number| number.checked_sub(1));
            let Some(place) = place.and_then(|place| values.get_mut(place)) else {
                let message = format!("there is no component `{}`", component.value);
                return Err(refuse(
                    Code::BadComponent,
                    component.span,
                    message,
                    "must be 1 to 6",
                    "write for example 1 = 0.5 for a length, 4 = 90 for an angle in degrees",
                ));
            };
            *place = Some(*value);
        }
        self.keyword("CONNECTOR CONSTITUTIVE REFERENCE", first.span);
        self.go();
        self.begin(first.span);
        for value in values {
            self.maybe(value.map(|value| value.value), value.map_or(first.span, |value| value.span));
        }
        self.end(true);
        Ok(())
    }

    fn independent(&mut self, independent: Option<&Independent>, span: Span) {
        if let Some(independent) = independent {
            self.word("INDEPENDENT COMPONENTS", Some(independent.basis), span);
        }
    }

    fn law(&mut self, keyword: &str, law: &Spanned<Law>) -> Result<()> {
        let span = law.span;
        let value = &law.value;
        self.keyword(keyword, span);
        self.component_of(value.component);
        self.word("TYPE", value.r#type, span);
        self.flag("NONLINEAR", value.nonlinear, span);
        self.flag("RIGID", value.rigid, span);
        self.flag("UNSYMM", value.unsymmetric, span);
        self.flag("FREQUENCY DEPENDENCE", value.frequency_dependence, span);
        self.independent(value.independent.as_ref(), span);
        self.dependencies(fields(&value.rows), span);
        self.options(value.options(), span);
        self.go();
        if let Some(component) = value.components.first().filter(|_| !value.rigid) {
            let message = "components are listed for what is not rigid".to_owned();
            let remedy = "write component = …, or rigid = true";
            return Err(refuse(Code::ConflictingParameters, component.span, message, "not used", remedy));
        }
        if !value.components.is_empty() {
            self.components(&value.components, span);
        }
        if let Some(independent) = &value.independent {
            self.components(&independent.components, span);
        }
        let columns = match (value.nonlinear, value.component) {
            (true, _) => {
                let listed = value.independent.as_ref().map_or(0, |independent| independent.components.len());
                let own = value.independent.is_none() || keyword == "CONNECTOR DAMPING";
                1 + usize::from(own) + listed
            }
            (false, Some(_)) => 2,
            (false, None) => {
                let terms = if value.unsymmetric { 36 } else { 21 };
                terms + usize::from(value.frequency_dependence)
            }
        };
        self.rows(&value.rows, columns)
    }

    fn derived_term(&mut self, name: &Name, term: &Spanned<form::DerivedTerm>) -> Result<()> {
        let span = term.span;
        let value = &term.value;
        self.keyword("CONNECTOR DERIVED COMPONENT", span);
        self.name("NAME", name)?;
        self.word("OPERATOR", value.operator, span);
        if value.negative {
            self.parameter("SIGN", "NEGATIVE", span);
        }
        self.independent(value.independent.as_ref(), span);
        self.dependencies(fields(&value.rows), span);
        self.options(value.options(), span);
        self.go();
        self.components(&value.components, span);
        let mut columns = value.components.len();
        if let Some(independent) = &value.independent {
            self.components(&independent.components, span);
            columns += independent.components.len();
        }
        self.rows(&value.rows, columns)
    }

    fn source(source: &Spanned<Source>) -> Result<String> {
        match &source.value {
            Source::Component(component) => Ok(component.to_string()),
            Source::Derived(name) => quoted(&Spanned::new(name.clone(), source.span)),
        }
    }

    fn friction(&mut self, friction: &Spanned<Friction>) -> Result<()> {
        let span = friction.span;
        let value = &friction.value;
        self.keyword("CONNECTOR FRICTION", span);
        self.flag("PREDEFINED", value.predefined.is_some(), span);
        self.component_of(value.component);
        if let Some(force) = &value.contact_force {
            self.parameter("CONTACT FORCE", Self::source(force)?, force.span);
        }
        self.number_of("STICK STIFFNESS", value.stick_stiffness);
        self.independent(value.independent.as_ref(), span);
        self.count_of("DEPENDENCIES", value.dependencies);
        self.options(value.options(), span);
        self.go();
        if let Some(constants) = &value.predefined {
            if !constants.value.is_empty() {
                self.begin(constants.span);
                for item in &constants.value {
                    self.maybe(item.value.0, item.span);
                }
                self.end(true);
            }
            if let Some(row) = value.rows.first() {
                let message = "a predefined friction has no rows".to_owned();
                let remedy = "remove the rows, or `predefined`";
                return Err(refuse(Code::ConflictingParameters, row.span, message, "not used", remedy));
            }
        }
        let mut width = 4 + dependencies(value.dependencies);
        if let Some(independent) = &value.independent {
            self.components(&independent.components, span);
            width += independent.components.len();
        }
        self.raws(&value.rows, width);
        if let Some(potential) = &value.potential {
            self.potential(potential)?;
        }
        value.coefficient.as_ref().map_or(Ok(()), |coefficient| self.coefficient(coefficient))
    }

    fn coefficient(&mut self, coefficient: &Spanned<form::Coefficient>) -> Result<()> {
        let span = coefficient.span;
        let form::Coefficient { rows, exponential, test_data, maximum, slip_tolerance, elastic_slip } =
            &coefficient.value;
        let given = [!rows.is_empty(), exponential.is_some(), !test_data.is_empty()];
        if given.iter().filter(|given| **given).count() != 1 {
            let message = "a friction coefficient is given in one of three ways".to_owned();
            let remedy = "give either rows, or exponential, or test_data";
            return Err(refuse(Code::ConflictingParameters, span, message, "this coefficient", remedy));
        }
        self.keyword("FRICTION", span);
        self.flag("EXPONENTIAL DECAY", exponential.is_some() || !test_data.is_empty(), span);
        self.flag("TEST DATA", !test_data.is_empty(), span);
        self.number_of("TAUMAX", *maximum);
        self.number_of("SLIP TOLERANCE", *slip_tolerance);
        self.number_of("ELASTIC SLIP", *elastic_slip);
        self.dependencies(fields(rows), span);
        self.go();
        if let Some(exponential) = exponential {
            self.begin(exponential.span);
            self.numbers(&exponential.value, exponential.span);
            self.end(false);
        }
        self.raws(test_data, 3);
        self.rows(rows, 3)
    }

    fn potential(&mut self, potential: &Spanned<Potential>) -> Result<()> {
        let Potential { terms, operator, exponent } = &potential.value;
        self.keyword("CONNECTOR POTENTIAL", potential.span);
        self.word("OPERATOR", *operator, potential.span);
        self.number_of("EXPONENT", *exponent);
        self.go();
        for term in terms {
            let span = term.span;
            let form::PotentialTerm { of, scale, exponent, function, shift, sign } = &term.value;
            self.begin(of.span);
            self.item(&Self::source(of)?, of.span);
            let number = |deck: &mut Self, value: &Option<Spanned<f64>>| {
                deck.maybe(value.map(|value| value.value), value.map_or(span, |value| value.span));
            };
            number(self, scale);
            number(self, exponent);
            self.item(function.map_or("", Choice::spelling), span);
            number(self, shift);
            number(self, sign);
            self.end(true);
        }
        Ok(())
    }

    fn plasticity(&mut self, plasticity: &Spanned<Plasticity>) -> Result<()> {
        self.keyword("CONNECTOR PLASTICITY", plasticity.span);
        self.component_of(plasticity.value.component);
        self.go();
        if let Some(potential) = &plasticity.value.potential {
            self.potential(potential)?;
        }
        plasticity.value.hardening.iter().try_for_each(|hardening| self.hardening(hardening))
    }

    fn hardening(&mut self, hardening: &Spanned<Hardening>) -> Result<()> {
        let span = hardening.span;
        let value = &hardening.value;
        self.keyword("CONNECTOR HARDENING", span);
        self.word("TYPE", value.r#type, span);
        self.word("DEFINITION", value.definition, span);
        self.number_of("RATE FILTER FACTOR", value.rate_filter);
        self.word("RATE INTERPOLATION", value.rate_interpolation, span);
        self.dependencies(fields(&value.rows), span);
        self.options(value.options(), span);
        self.go();
        let definition = value.definition.unwrap_or_else(|| value.r#type.unwrap_or_default().definition());
        self.rows(&value.rows, definition.columns().len())
    }

    fn damage(&mut self, damage: &Spanned<Damage>) -> Result<()> {
        let span = damage.span;
        let value = &damage.value;
        self.keyword("CONNECTOR DAMAGE INITIATION", span);
        self.component_of(value.component);
        self.word("CRITERION", value.criterion, span);
        self.number_of("RATE FILTER FACTOR", value.rate_filter);
        self.word("RATE INTERPOLATION", value.rate_interpolation, span);
        self.count_of("DEPENDENCIES", value.dependencies);
        self.options(value.options(), span);
        self.go();
        self.raws(&value.rows, 4 + dependencies(value.dependencies));
        if let Some(potential) = &value.potential {
            self.potential(potential)?;
        }
        let Some(evolution) = &value.evolution else { return Ok(()) };
        let span = evolution.span;
        let value = &evolution.value;
        self.keyword("CONNECTOR DAMAGE EVOLUTION", span);
        self.word("TYPE", value.r#type, span);
        self.word("SOFTENING", value.softening, span);
        self.word("DEGRADATION", value.degradation, span);
        self.flag("AFFECTED COMPONENTS", !value.affected.is_empty(), span);
        self.count_of("DEPENDENCIES", value.dependencies);
        self.options(value.options(), span);
        self.go();
        if !value.affected.is_empty() {
            self.components(&value.affected, span);
        }
        self.raws(&value.rows, 4 + dependencies(value.dependencies));
        value.potential.as_ref().map_or(Ok(()), |potential| self.potential(potential))
    }

    fn lock(&mut self, keyword: &str, parameter: &str, lock: &Spanned<Lock>) -> Result<()> {
        let span = lock.span;
        let value = &lock.value;
        let fields = value.limits.iter().map(|limits| limits.value.fields.len()).max().unwrap_or(0);
        self.keyword(keyword, span);
        self.component_of(Some(value.component));
        if let Some(affected) = value.affected {
            self.parameter(parameter, affected.value.0, affected.span);
        }
        self.dependencies(fields, span);
        self.options(value.options(), span);
        self.go();
        for limits in &value.limits {
            let form::Limits {
                lower_position,
                upper_position,
                lower_force,
                upper_force,
                temperature,
                fields: own,
            } = &limits.value;
            let at = |value: &Option<Spanned<f64>>| {
                (value.map(|value| value.value), value.map_or(limits.span, |value| value.span))
            };
            let mut record = vec![
                at(lower_position),
                at(upper_position),
                at(lower_force),
                at(upper_force),
                at(temperature),
            ];
            record.extend(own.iter().map(|item| (item.value.0, item.span)));
            self.record(&record, 5 + fields, limits.span);
        }
        Ok(())
    }
}
