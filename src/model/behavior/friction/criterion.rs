//! The criterion Φ = P(f) − μ F_N ≤ 0 with F_N = |F_C + F_C^int|: P and F_C of any friction, and their derivatives.

use crate::behavior::friction::derived::{Derived, DerivedPart, Potential};
use crate::behavior::friction::flags::{Flag, Flags};
use crate::behavior::friction::{Context, Ordered, is_divisor, is_zero};
use crate::behavior::table::{Table, Variable};
use pintle_kinematics::Differentiable;
use pintle_kinematics::catalog::{
    Contact, CrossAxis, FORCE, Factor, Friction as Catalogued, FrictionCriterion, Load, PLANE, Quantity,
    SPATIAL,
};
use pintle_kinematics::scalar::elementary::{abs, norm, sin_cos};
use pintle_kinematics::scalar::{Real, Scalar, Seeded};
use pintle_kinematics::vector::{cross, dot};
use pintle_scene::{Basis, Operator};

/// What slides: P(f), the magnitude of the tangential tractions.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Tangential {
    /// √(Σ (f_k/R_k)²), R_k = 1 where there is none: the components (from 0) and their radii.
    Norm(#[serde(deserialize_with = "crate::behavior::friction::read::radii")] Vec<(usize, f64)>),
    /// A `*CONNECTOR POTENTIAL`.
    Potential(Potential),
}

/// What presses: F_C.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Pressing {
    /// Nothing: an internal contact force alone.
    Nothing,
    /// The terms of a predefined friction.
    Terms(Vec<Term>),
    /// The force in a component (from 0), with its sign.
    Component(usize),
    /// A derived component.
    Derived(Derived),
}

/// One term of a predefined contact force: number · Π times / over · magnitude.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Term {
    number: i32,
    times: Vec<f64>,
    #[serde(deserialize_with = "crate::behavior::friction::read::maybe_radius")]
    over: Option<f64>,
    #[serde(with = "catalogued")]
    load: Load,
    present: [bool; 6],
}

/// A load in a file: that of the catalogue which reads the same.
mod catalogued {
    use pintle_kinematics::catalog::{Contact, Load, TABLE};
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<S: Serializer>(load: &Load, serializer: S) -> Result<S::Ok, S::Error> {
        name(load).serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Load, D::Error> {
        let wanted = String::deserialize(deserializer)?;
        let criteria = TABLE.iter().filter_map(|connection| connection.friction).flat_map(|f| f.criteria);
        let terms = criteria.flat_map(|criterion| match criterion.contact {
            Contact::Sum { terms, .. } => terms,
            Contact::Belt => &[],
        });
        let mut loads = terms.map(|term| term.load);
        let found = loads.find(|load| name(load) == wanted);
        found.ok_or_else(|| D::Error::custom(format!("no friction of the catalogue has the load {wanted:?}")))
    }

    fn name(load: &Load) -> String {
        match load {
            Load::Norm(components) => format!("norm of components {components:?} (from 0)"),
            Load::Along(axis) => format!("along {}", axis.name()),
            Load::Across(axis) => format!("across {}", axis.name()),
        }
    }
}

/// F_C^int, the internal contact force, positive or negative.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Internal {
    /// A number.
    Constant(f64),
    /// A table over the positions or constitutive motions of components (from 0), then the accumulated slip.
    Table {
        /// The table; column j is component j of the list, the next one the accumulated slip.
        table: Table,
        /// Whether positions or constitutive motions.
        basis: Basis,
        /// The components.
        components: Vec<usize>,
    },
}

/// A friction criterion, ready to be evaluated on any scalar.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Criterion {
    /// P.
    pub tangential: Tangential,
    /// F_C.
    pub pressing: Pressing,
    /// F_C^int.
    pub internal: Internal,
    /// The output in which the friction force appears: CSF1 … CSM3 of one component, else CSFC.
    #[serde(skip)]
    pub output: &'static str,
}

/// A mistake that is made in the factors of predefined friction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FactorMistake {
    /// 1/L for 2/L.
    NumberLeftOut,
    /// Times R_r instead of divided by it.
    Multiplied,
}

/// A mistake that is made in the terms of predefined friction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TermMistake {
    /// One parameter for another.
    Parameter,
    /// A factor or a divisor left out.
    LeftOut,
    /// A sum for a norm, or one norm for two.
    Norm,
    /// Another axis.
    Axis,
}

/// Φ and what it is formed from, for a given coefficient.
#[derive(Clone, Debug, PartialEq)]
pub struct Point<S> {
    /// P(f).
    pub tangential: S,
    /// F_C, or M_C.
    pub contact: S,
    /// F_N = |F_C + F_C^int|, or M_N (output CNF).
    pub normal: S,
    /// Φ = P − min(μ F_N, τ_max).
    pub criterion: S,
}

/// F_C + F_C^int = `linear`·f + Σ factor |A f| + `internal`, the magnitudes by themselves: each has a kink of its own where A f = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactParts<R> {
    /// What of F_C is linear in f1 … m3.
    pub linear: [R; 6],
    /// The factor and the rows A of each magnitude.
    pub magnitudes: Vec<(R, Vec<[R; 6]>)>,
    /// F_C^int.
    pub internal: R,
}

/// Values and exact derivatives with respect to f1, f2, f3, m1, m2, m3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Derivatives<R> {
    /// The value.
    pub value: R,
    /// First derivatives.
    pub gradient: [R; 6],
    /// Second derivatives.
    pub hessian: [[R; 6]; 6],
}

impl Term {
    /// The catalogue's term with its numbers; `None` where it drops out.
    fn new(
        factor: &Factor,
        load: Load,
        present: [bool; 6],
        numbers: &impl Fn(Quantity) -> f64,
    ) -> Option<Self> {
        let over = factor.over.map(|parameter| numbers(Quantity::Parameter(parameter)));
        let times: Vec<f64> = factor.times.iter().map(|quantity| numbers(*quantity)).collect();
        let vanishes = over == Some(0.0) || times.contains(&0.0) || load.formula(present).is_none();
        (!vanishes).then_some(Self { number: factor.number, times, over, load, present })
    }

    fn evaluate<S>(&self, f: &[S; 6], context: &Context<'_, S>, flags: &mut Flags) -> S
    where
        S: Scalar,
        S::Real: Ordered,
    {
        let force = [f[0], f[1], f[2]];
        let magnitude = match self.load {
            Load::Norm(components) => {
                let mut listed = [S::zero(); 6];
                for k in components.iter().filter(|k| self.present[**k]) {
                    listed[*k] = f[*k];
                }
                norm(listed)
            }
            Load::Along(axis) => abs(dot(force, direction(axis, context))),
            Load::Across(axis) => norm(cross(force, direction(axis, context))),
        };
        if is_zero(magnitude.real()) {
            flags.add(Flag::LoadAtZero { load: self.load.formula(self.present).unwrap_or_default() });
        }
        magnitude.scale(self.factor())
    }

    fn factor<R: Real>(&self) -> R {
        let mut factor = R::integer(self.number);
        for number in &self.times {
            factor = factor * R::from_f64(*number);
        }
        if let Some(over) = self.over {
            // A length of zero drops the term, in traced formulas too.
            factor = factor * R::from_f64(over).reciprocal_or_zero();
        }
        factor
    }

    /// The rows A of the magnitude |A f|.
    fn rows<R: Ordered>(&self, context: &Context<'_, R>, unit: impl Fn(usize) -> [R; 6]) -> Vec<[R; 6]> {
        let spread = |v: [R; 3]| [v[0], v[1], v[2], R::ZERO, R::ZERO, R::ZERO];
        match self.load {
            Load::Norm(components) => {
                components.iter().filter(|k| self.present[**k]).map(|k| unit(*k)).collect()
            }
            Load::Along(axis) => vec![spread(direction(axis, context))],
            Load::Across(axis) => {
                let axis = direction(axis, context);
                let along = |i: usize| {
                    let mut e = [R::ZERO; 3];
                    e[i] = R::integer(1);
                    // (f × axis)_i = f · (axis × e_i)
                    spread(cross(axis, e))
                };
                (0..3).map(along).collect()
            }
        }
    }
}

/// An axis of the cross, along e1a, e2a, e3a. With the Cardan angles α, β, γ of a universal joint, e3b = (sin β, −sin α cos β,
/// cos α cos β).
fn direction<S: Scalar>(axis: CrossAxis, context: &Context<'_, S>) -> [S; 3] {
    match axis {
        CrossAxis::OfA => [S::one(), S::zero(), S::zero()],
        CrossAxis::OfB => {
            let ((sin_alpha, cos_alpha), (sin_beta, cos_beta)) =
                (sin_cos(context.position[3]), sin_cos(context.position[4]));
            [sin_beta, -(sin_alpha * cos_beta), cos_alpha * cos_beta]
        }
    }
}

impl Internal {
    pub(super) fn evaluate<S>(&self, context: &Context<'_, S>, flags: &mut Flags) -> S
    where
        S: Scalar,
        S::Real: Ordered,
    {
        match self {
            Self::Constant(force) => S::from_real(S::Real::from_f64(*force)),
            Self::Table { table, basis, components } => {
                let motions = context.of(*basis);
                let argument = |variable| match variable {
                    Variable::Column(j) => {
                        components.get(j).map_or(context.accumulated_slip, |component| motions[*component])
                    }
                    other => context.conditions.of(other),
                };
                flags.rows("internal contact force", table, context.conditions, 0, |variable| {
                    argument(variable).real()
                });
                table.evaluate(0, argument)
            }
        }
    }

    /// Whether F_C^int changes with the accumulated slip, and in which column it stands.
    pub(super) fn slip_column(&self) -> Option<(&Table, usize)> {
        match self {
            Self::Constant(_) => None,
            Self::Table { table, components, .. } => {
                let column = Variable::Column(components.len());
                table.depends_on().any(|variable| variable == column).then_some((table, components.len()))
            }
        }
    }
}

impl Tangential {
    /// The components (from 0) that slide.
    pub fn components(&self) -> Vec<usize> {
        match self {
            Self::Norm(components) => components.iter().map(|(component, _)| *component).collect(),
            Self::Potential(potential) => potential.components(),
        }
    }

    /// Whether the slip is an angle, so that P and F_N are moments.
    pub fn is_rotational(&self) -> bool {
        match self {
            Self::Norm(components) => components.iter().all(|(k, radius)| *k >= 3 && *radius == 1.0),
            Self::Potential(potential) => potential.components().iter().all(|k| *k >= 3),
        }
    }

    pub(super) fn evaluate<S>(&self, f: &[S; 6], context: &Context<'_, S>, flags: &mut Flags) -> S
    where
        S: Scalar,
        S::Real: Ordered,
    {
        let magnitude = match self {
            Self::Norm(components) => {
                let mut listed = [S::zero(); 6];
                for (component, radius) in components {
                    listed[*component] = f[*component].scale(S::Real::from_f64(*radius).reciprocal_or_zero());
                }
                norm(listed)
            }
            Self::Potential(potential) => potential.evaluate(f, S::one(), context, flags),
        };
        if is_zero(magnitude.real()) {
            flags.add(Flag::NoTraction);
        }
        magnitude
    }
}

impl Pressing {
    pub(super) fn evaluate<S>(&self, f: &[S; 6], context: &Context<'_, S>, flags: &mut Flags) -> S
    where
        S: Scalar,
        S::Real: Ordered,
    {
        match self {
            Self::Nothing => S::zero(),
            Self::Terms(terms) => {
                terms.iter().fold(S::zero(), |sum, term| sum + term.evaluate(f, context, flags))
            }
            Self::Component(component) => f[*component],
            Self::Derived(derived) => derived.evaluate(f, context, flags),
        }
    }
}

/// Why a predefined friction cannot be formed from its numbers.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ParameterError {
    /// Too many or too few.
    #[error("predefined friction takes {least} to {most} numbers, not {given}")]
    Count {
        /// Required.
        least: usize,
        /// Required and optional.
        most: usize,
        /// Given.
        given: usize,
    },
    /// A length or an arm is negative or not finite, or a required one is missing or zero.
    #[error("{symbol} = {value:?}: a length must be positive{}", if *.may_be_zero { ", or zero to leave its term out" } else { "" })]
    Length {
        /// The parameter.
        symbol: &'static str,
        /// Its value.
        value: f64,
        /// Whether zero is allowed.
        may_be_zero: bool,
    },
    /// The type has no Φ = P − μ F_N: a belt around a ring has its own law ([`crate::behavior::friction::Belt`]).
    #[error("a belt around a ring has its own friction law")]
    Belt,
}

impl Criterion {
    /// The criteria of predefined friction, with the numbers of the data line in the catalogue's order. Numbers left out are
    /// zero; `constants` replaces those of [`Catalogued::constants`] in order, as far as it goes.
    ///
    /// # Errors
    /// [`ParameterError`]: too many or too few numbers, a length that is negative, not finite or a divisor so small that its
    /// reciprocal is infinite, a required one that is zero.
    ///
    /// ```
    /// use pintle_model::behavior::friction::{Context, Criterion};
    /// use pintle_kinematics::catalog::ConnectionType;
    /// let translator = ConnectionType::named("TRANSLATOR", None)?.friction.ok_or("no friction")?;
    /// let criteria = Criterion::predefined(&translator, &[Some(0.05), Some(0.1), Some(10.0)], &[], false)?;
    /// let forces = [3.0, 3.0, 4.0, 0.5, 0.3, 0.4];
    /// let (point, _) = criteria[0].at(&forces, 0.1, None, &Context::default());
    /// assert_eq!(point.tangential, 3.0);
    /// assert_eq!(point.contact, 0.5 / 0.05 + 5.0 + 2.0 * 0.5 / 0.1);
    /// assert_eq!(point.criterion, 3.0 - 0.1 * 35.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn predefined(
        friction: &Catalogued,
        parameters: &[Option<f64>],
        constants: &[f64],
        is_planar: bool,
    ) -> Result<Vec<Self>, ParameterError> {
        let least = friction.parameters.iter().filter(|parameter| parameter.required).count();
        let given = parameters.iter().rposition(Option::is_some).map_or(0, |last| last + 1);
        if given < least || given > friction.parameters.len() {
            return Err(ParameterError::Count { least, most: friction.parameters.len(), given });
        }
        let number = |quantity: Quantity| match quantity {
            Quantity::Parameter(i) => parameters.get(i).copied().flatten().unwrap_or(0.0),
            Quantity::Constant(i) => {
                let catalogued = friction.constants.get(i).map_or(0.0, |constant| constant.value);
                constants.get(i).copied().unwrap_or(catalogued)
            }
        };
        for (i, parameter) in friction.parameters.iter().enumerate() {
            let is_internal = friction.criteria.iter().any(|criterion| criterion.internal == Some(i));
            let value = number(Quantity::Parameter(i));
            let is_length = is_divisor(value);
            let may_be_zero = !parameter.required;
            let is_left_out = may_be_zero && value == 0.0;
            if !(is_internal || is_length || is_left_out) {
                return Err(ParameterError::Length { symbol: parameter.symbol, value, may_be_zero });
            }
        }
        let present = if is_planar { PLANE } else { SPATIAL };
        friction.criteria.iter().map(|criterion| Self::catalogued(criterion, &number, present)).collect()
    }

    fn catalogued(
        criterion: &FrictionCriterion,
        number: &impl Fn(Quantity) -> f64,
        present: [bool; 6],
    ) -> Result<Self, ParameterError> {
        let Contact::Sum { arm, terms } = criterion.contact else { return Err(ParameterError::Belt) };
        let terms = terms
            .iter()
            .filter_map(|term| Term::new(&term.factor, term.load, present, number))
            .filter_map(|mut term| {
                let arms: Vec<f64> = arm.iter().map(|quantity| number(*quantity)).collect();
                let vanishes = arms.contains(&0.0);
                term.times.extend(arms);
                (!vanishes).then_some(term)
            });
        let radius = |parameter: Option<usize>| parameter.map_or(1.0, |i| number(Quantity::Parameter(i)));
        let tractions = criterion.traction.iter().filter(|traction| present[traction.component]);
        Ok(Self {
            pressing: Pressing::Terms(terms.collect()),
            tangential: Tangential::Norm(
                tractions.map(|traction| (traction.component, radius(traction.radius))).collect(),
            ),
            internal: Internal::Constant(criterion.internal.map_or(0.0, |i| number(Quantity::Parameter(i)))),
            output: criterion.output,
        })
    }

    /// The same with one mistake in a factor, for every factor in which it can be made: a check of the criterion must notice.
    pub fn factor_mistakes(&self) -> Vec<(FactorMistake, Self)> {
        let mut found = Vec::new();
        if let Pressing::Terms(terms) = &self.pressing {
            for (i, term) in terms.iter().enumerate() {
                let mut with = |mistake, changed: Term| {
                    let mut terms = terms.clone();
                    terms[i] = changed;
                    found.push((mistake, Self { pressing: Pressing::Terms(terms), ..self.clone() }));
                };
                if term.number != 1 {
                    with(FactorMistake::NumberLeftOut, Term { number: 1, ..term.clone() });
                }
                if let Some(over) = term.over {
                    with(FactorMistake::Multiplied, Term { over: Some(1.0 / over), ..term.clone() });
                }
            }
        }
        if let Tangential::Norm(components) = &self.tangential {
            for (i, (component, radius)) in components.iter().enumerate().filter(|(_, (_, r))| *r != 1.0) {
                let mut components = components.clone();
                components[i] = (*component, 1.0 / radius);
                let wrong = Self { tangential: Tangential::Norm(components), ..self.clone() };
                found.push((FactorMistake::Multiplied, wrong));
            }
        }
        found
    }

    /// The criterion without one of several terms in F_C, and without one of several tractions in P, each with what is left out, in words.
    pub fn with_parts_left_out(&self) -> Vec<(String, Self)> {
        let mut found = Vec::new();
        if let Pressing::Terms(terms) = &self.pressing {
            for i in (0..terms.len()).filter(|_| terms.len() > 1) {
                let mut rest = terms.clone();
                let term = rest.remove(i);
                let name = term.load.formula(term.present).unwrap_or_default();
                found.push((
                    format!("{name} in F_C"),
                    Self { pressing: Pressing::Terms(rest), ..self.clone() },
                ));
            }
            for (i, term) in terms.iter().enumerate() {
                let Load::Norm(components) = term.load else { continue };
                let listed: Vec<usize> = components.iter().copied().filter(|k| term.present[*k]).collect();
                for k in listed.iter().copied().filter(|_| listed.len() > 1) {
                    let mut all = terms.clone();
                    all[i].present[k] = false;
                    let name = format!("{} in F_C", FORCE[k]);
                    found.push((name, Self { pressing: Pressing::Terms(all), ..self.clone() }));
                }
            }
        }
        if let Tangential::Norm(components) = &self.tangential {
            for i in (0..components.len()).filter(|_| components.len() > 1) {
                let mut rest = components.clone();
                let (k, _) = rest.remove(i);
                let without = Self { tangential: Tangential::Norm(rest), ..self.clone() };
                found.push((format!("{} in P", FORCE[k]), without));
            }
        }
        found
    }

    /// The criterion with one mistake that needs no parameters, in words:
    ///
    /// - a term of a derived component without its scale factors, with another operator, or of the other sign;
    /// - another component in P.
    pub fn with_components_mistaken(&self) -> Vec<(TermMistake, String, Self)> {
        let mut found = Vec::new();
        if let Pressing::Derived(derived) = &self.pressing {
            for (i, part) in derived.parts.iter().enumerate() {
                let mut add = |mistake: TermMistake, words: &str, change: &dyn Fn(&mut DerivedPart)| {
                    let mut other = derived.clone();
                    change(&mut other.parts[i]);
                    let words = format!("{words} term {} of F_C", i + 1);
                    found.push((mistake, words, Self { pressing: Pressing::Derived(other), ..self.clone() }));
                };
                if part.scale.is_some() {
                    add(TermMistake::LeftOut, "no scale factors in", &|part| {
                        (part.scale, part.independent) = (None, None);
                    });
                }
                for (operator, words) in [
                    (Operator::Norm, "the norm for the sum in"),
                    (Operator::Sum, "the sum for the norm in"),
                    (Operator::MacauleySum, "the sum of positive parts alone in"),
                ] {
                    if operator != part.operator {
                        add(TermMistake::Norm, words, &|part| part.operator = operator);
                    }
                }
                add(TermMistake::LeftOut, "the other sign of", &|part| part.sign = -part.sign);
            }
        }
        if let Tangential::Norm(components) = &self.tangential {
            for (i, (k, _)) in components.iter().enumerate() {
                let is_near = |l: &usize| *l / 3 == k / 3 && components.iter().all(|(known, _)| known != l);
                for l in (0..6).filter(is_near) {
                    let mut others = components.clone();
                    others[i].0 = l;
                    let words = format!("{} for {} in P", FORCE[l], FORCE[*k]);
                    found.push((
                        TermMistake::Axis,
                        words,
                        Self { tangential: Tangential::Norm(others), ..self.clone() },
                    ));
                }
            }
        }
        found
    }

    /// The criterion with one mistake in the terms of F_C, in words, by the symbols and values of its parameters:
    ///
    /// - one parameter for another, or both exchanged, in one term or in several;
    /// - a term without a factor, or without its divisor;
    /// - a sum of magnitudes for a norm, a norm of two terms with the factor of one;
    /// - an axis of the node for one that moves, all of a force for its part across.
    pub fn with_terms_mistaken(
        &self,
        parameters: &[(&'static str, f64)],
    ) -> Vec<(TermMistake, String, Self)> {
        const ONE: [&[usize]; 6] = [&[0], &[1], &[2], &[3], &[4], &[5]];
        const ACROSS: [&[usize]; 3] = [&[1, 2], &[0, 2], &[0, 1]];
        const ALL: [&[usize]; 2] = [&[0, 1, 2], &[3, 4, 5]];
        let Pressing::Terms(terms) = &self.pressing else { return Vec::new() };
        let name = |term: &Term| term.load.formula(term.present).unwrap_or_default();
        let mut found: Vec<(TermMistake, String, Self)> = Vec::new();
        let mut add = |mistake: TermMistake, words: String, terms: Vec<Term>| {
            let made = Self { pressing: Pressing::Terms(terms), ..self.clone() };
            // What was made before says it in fewer words.
            if made != *self && found.iter().all(|(.., known)| *known != made) {
                found.push((mistake, words, made));
            }
        };
        let changed = |of: &[usize], change: &dyn Fn(&Term) -> Term| -> Option<Vec<Term>> {
            let mut all = terms.clone();
            of.iter().for_each(|i| all[*i] = change(&terms[*i]));
            of.iter().all(|i| all[*i] != terms[*i]).then_some(all)
        };
        let exchanged = |term: &Term, of: &dyn Fn(f64) -> f64| Term {
            times: term.times.iter().map(|x| of(*x)).collect(),
            over: term.over.map(of),
            ..term.clone()
        };
        // Terms by themselves, and together.
        let sets: Vec<Vec<usize>> = (1..1_usize << terms.len().min(4))
            .map(|set| (0..terms.len()).filter(|i| set >> i & 1 == 1).collect())
            .collect();
        for set in &sets {
            let named: Vec<String> = set.iter().map(|i| name(&terms[*i])).collect();
            let of = named.join(", ");
            let bare = |term: &Term| Term { times: Vec::new(), over: None, ..term.clone() };
            if let Some(terms) = changed(set, &bare) {
                add(TermMistake::LeftOut, format!("no parameters in the terms of {of}"), terms);
            }
            let unmultiplied = |term: &Term| Term { times: Vec::new(), ..term.clone() };
            if let Some(terms) = changed(set, &unmultiplied) {
                add(TermMistake::LeftOut, format!("no factors in the terms of {of}"), terms);
            }
            let twice = |term: &Term| Term { number: 2 * term.number, ..term.clone() };
            if let Some(terms) = changed(set, &twice) {
                add(TermMistake::LeftOut, format!("twice the terms of {of}"), terms);
            }
            for (n, (p, x)) in parameters.iter().enumerate() {
                for (q, y) in parameters.iter().enumerate().filter(|(m, _)| *m != n).map(|(_, other)| other) {
                    let for_another = |term: &Term| exchanged(term, &|z| if z == *x { *y } else { z });
                    if let Some(terms) = changed(set, &for_another) {
                        add(TermMistake::Parameter, format!("{q} for {p} in the term of {of}"), terms);
                    }
                }
                for (q, y) in &parameters[..n] {
                    let both = |term: &Term| {
                        exchanged(term, &|z| {
                            if z == *x {
                                *y
                            } else if z == *y {
                                *x
                            } else {
                                z
                            }
                        })
                    };
                    if let Some(terms) = changed(set, &both) {
                        add(
                            TermMistake::Parameter,
                            format!("{q} and {p} exchanged in the terms of {of}"),
                            terms,
                        );
                    }
                }
                let without = |term: &Term| Term {
                    times: term.times.iter().copied().filter(|z| z != x).collect(),
                    over: term.over.filter(|z| z != x),
                    ..term.clone()
                };
                if let Some(terms) = changed(set, &without) {
                    add(TermMistake::LeftOut, format!("no {p} in the term of {of}"), terms);
                }
            }
        }
        for (i, term) in terms.iter().enumerate() {
            let mut rest = terms.clone();
            rest.remove(i);
            let with = |more: Vec<Term>| [rest.clone(), more].concat();
            match term.load {
                Load::Norm(components) => {
                    // All of a force or moment for its part across.
                    let whole = ALL.into_iter().find(|all| all.contains(&components[0]));
                    if let Some(whole) = whole.filter(|whole| components.len() == 2 && whole.len() == 3) {
                        let load = Term { load: Load::Norm(whole), present: [true; 6], ..term.clone() };
                        let words =
                            format!("all of {} … {} for {}", FORCE[whole[0]], FORCE[whole[2]], name(term));
                        add(TermMistake::Axis, words, with(vec![load]));
                    }
                    let single = |k: &usize| Term { load: Load::Norm(ONE[*k]), ..term.clone() };
                    let sum = components.iter().map(single).collect();
                    add(
                        TermMistake::Norm,
                        format!("a sum of magnitudes for the norm {}", name(term)),
                        with(sum),
                    );
                    let other = terms.iter().enumerate().filter(|(j, _)| *j != i);
                    for (j, of) in other {
                        let Load::Norm(others) = of.load else { continue };
                        let unions = ALL.into_iter().chain(ACROSS).filter(|all| {
                            components.iter().chain(others).all(|k| all.contains(k))
                                && all.len() == components.len() + others.len()
                        });
                        for load in unions {
                            let mut merged = terms.clone();
                            merged[i].load = Load::Norm(load);
                            merged.remove(j);
                            add(
                                TermMistake::Norm,
                                format!("one norm for {} and {}", name(term), name(of)),
                                merged,
                            );
                        }
                    }
                }
                Load::Across(_) => {
                    let whole = Term { load: Load::Norm(ALL[0]), ..term.clone() };
                    add(TermMistake::Axis, "all of the force for its part across".into(), with(vec![whole]));
                }
                Load::Along(_) => {}
            }
        }
        for (k, across) in ACROSS.into_iter().enumerate() {
            let held = |term: &Term| Term {
                load: match term.load {
                    Load::Along(_) => Load::Norm(ONE[k]),
                    Load::Across(_) => Load::Norm(across),
                    norm @ Load::Norm(_) => norm,
                },
                ..term.clone()
            };
            add(TermMistake::Axis, format!("e{}a for the axis", k + 1), terms.iter().map(held).collect());
        }
        found
    }

    /// P, F_C, F_N and Φ at given forces f1, f2, f3, m1, m2, m3 and a given coefficient, and what needs care there.
    ///
    /// In P the forces of the sliding components are the friction tractions; in F_C those of constrained components are
    /// constraint forces. At most second derivatives.
    pub fn at<S>(
        &self,
        forces: &[S; 6],
        coefficient: S,
        maximum: Option<f64>,
        context: &Context<'_, S>,
    ) -> (Point<S>, Vec<Flag>)
    where
        S: Scalar,
        S::Real: Ordered,
    {
        let mut flags = Flags::default();
        let tangential = self.tangential.evaluate(forces, context, &mut flags);
        let contact = self.pressing.evaluate(forces, context, &mut flags);
        let normal = self.normal(contact, context, &mut flags);
        let limit = crate::behavior::friction::capped(coefficient * normal, maximum, &mut flags);
        (Point { tangential, contact, normal, criterion: tangential - limit }, flags.into_vec())
    }

    /// The components (from 0) of whose forces F_C is formed.
    pub fn pressing_components(&self) -> [bool; 6] {
        let mut mask = [false; 6];
        match &self.pressing {
            Pressing::Nothing => {}
            Pressing::Component(k) => mask[*k] = true,
            Pressing::Derived(derived) => derived.components().for_each(|k| mask[k] = true),
            Pressing::Terms(terms) => {
                for term in terms {
                    let of: &[usize] = match term.load {
                        Load::Norm(components) => components,
                        Load::Along(_) | Load::Across(_) => &[0, 1, 2],
                    };
                    of.iter().filter(|k| term.present[**k]).for_each(|k| mask[*k] = true);
                }
            }
        }
        mask
    }

    /// F_C and F_C^int in parts, with the context's positions; `None` where F_C is a derived component.
    pub fn contact_parts<R: Ordered>(&self, context: &Context<'_, R>) -> Option<ContactParts<R>> {
        let (zero, one) = (R::ZERO, R::integer(1));
        let unit = |k: usize| {
            let mut row = [zero; 6];
            row[k] = one;
            row
        };
        let mut parts = ContactParts {
            linear: [zero; 6],
            magnitudes: Vec::new(),
            internal: self.internal_force(context),
        };
        match &self.pressing {
            Pressing::Nothing => {}
            Pressing::Component(k) => parts.linear[*k] = one,
            Pressing::Derived(_) => return None,
            Pressing::Terms(terms) => {
                parts.magnitudes =
                    terms.iter().map(|term| (term.factor(), term.rows(context, unit))).collect();
            }
        }
        Some(parts)
    }

    /// F_C^int, with the context's positions.
    pub fn internal_force<R: Ordered>(&self, context: &Context<'_, R>) -> R {
        self.internal.evaluate(context, &mut Flags::default())
    }

    /// Whether F_C^int changes with the accumulated slip.
    pub fn depends_on_slip(&self) -> bool {
        self.internal.slip_column().is_some()
    }

    /// F_C as a sum of norms, with the context's positions: the factor and the rows A of each |A f|. Of derived components where these are norms;
    /// empty where F_C is something else.
    pub fn contact_norms<R: Ordered>(&self, context: &Context<'_, R>) -> Vec<(R, Vec<[R; 6]>)> {
        let Pressing::Derived(derived) = &self.pressing else {
            return self.contact_parts(context).map_or_else(Vec::new, |parts| parts.magnitudes);
        };
        let is_norm = |part: &DerivedPart| part.operator == Operator::Norm && part.sign > 0.0;
        if !derived.parts.iter().all(is_norm) {
            return Vec::new();
        }
        let rows = |part: &DerivedPart| {
            let factors = part.scaled(&[R::integer(1); 6], context, &mut Flags::default());
            let row = |(k, factor): (&usize, R)| {
                let mut row = [R::ZERO; 6];
                row[*k] = factor;
                row
            };
            (R::integer(1), part.components.iter().zip(factors).map(row).collect())
        };
        derived.parts.iter().map(rows).collect()
    }

    /// F_N = |F_C + F_C^int|.
    pub(super) fn normal<S>(&self, contact: S, context: &Context<'_, S>, flags: &mut Flags) -> S
    where
        S: Scalar,
        S::Real: Ordered,
    {
        let signed = contact + self.internal.evaluate(context, flags);
        if is_zero(signed.real()) {
            flags.add(Flag::NoContactForce);
        }
        abs(signed)
    }

    pub(super) fn derivatives_any<R: Ordered + Differentiable>(
        &self,
        forces: &[R; 6],
        coefficient: R,
        maximum: Option<f64>,
        context: &Context<'_, R>,
    ) -> (Point<Derivatives<R>>, Vec<Flag>) {
        let seeded = [0, 1, 2, 3, 4, 5].map(|k| R::Hessian::<6>::seed(forces[k], k));
        let constant = R::Hessian::<6>::from_real;
        let (point, flags) = self.at(&seeded, constant(coefficient), maximum, &context.map(constant));
        (parts::<R>(point), flags)
    }
}

/// Values, gradients and Hessians.
pub(super) fn parts<R: Differentiable>(point: Point<R::Hessian<6>>) -> Point<Derivatives<R>> {
    let of = |x: R::Hessian<6>| Derivatives { value: x.real(), gradient: x.gradient(), hessian: x.hessian() };
    let Point { tangential, contact, normal, criterion } = point;
    Point { tangential: of(tangential), contact: of(contact), normal: of(normal), criterion: of(criterion) }
}

/// The names of components (from 0) as the outputs number them: CSF1 … CSM3, or CSFC for several.
pub(super) fn output_of(components: &[usize]) -> &'static str {
    const OUTPUT: [&str; FORCE.len()] = ["CSF1", "CSF2", "CSF3", "CSM1", "CSM2", "CSM3"];
    match components {
        [one] => OUTPUT[*one],
        _ => "CSFC",
    }
}
