//! Derived components and potentials: how forces are combined.

use crate::behavior::friction::flags::{Flag, Flags};
use crate::behavior::friction::{Context, MOST_CONTRIBUTIONS, Ordered, is_zero, larger, length};
use crate::behavior::table::{Table, Variable};
use pintle_kinematics::scalar::elementary::{abs, power, recip};
use pintle_kinematics::scalar::{Real, Scalar};
use pintle_scene::{Basis, Operator, PotentialFunction, PotentialOperator};

/// A derived component: a sum of terms, each a combination of forces with scale factors.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Derived {
    /// The terms.
    pub parts: Vec<DerivedPart>,
}

/// One term of a derived component, s · op(α_1 f_1, α_2 f_2 …).
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "WrittenPart")]
pub struct DerivedPart {
    /// √(Σ x²), Σ x or Σ ⟨x⟩ with ⟨x⟩ = max(x, 0), of x_i = α_i f_i.
    pub operator: Operator,
    /// s, +1 or −1.
    pub sign: f64,
    /// The components (from 0).
    pub components: Vec<usize>,
    /// α, one output for each component; none is 1. Column j is the j-th independent component.
    pub scale: Option<Table>,
    /// On what of the independent components α depends, and which they are (from 0).
    pub independent: Option<(Basis, Vec<usize>)>,
}

/// A term as a file has it, whose factors may be too few.
#[derive(serde::Deserialize)]
struct WrittenPart {
    operator: Operator,
    #[serde(deserialize_with = "crate::behavior::friction::read::sign")]
    sign: f64,
    components: Vec<usize>,
    scale: Option<Table>,
    independent: Option<(Basis, Vec<usize>)>,
}

impl TryFrom<WrittenPart> for DerivedPart {
    type Error = String;

    fn try_from(written: WrittenPart) -> Result<Self, String> {
        let WrittenPart { operator, sign, components, scale, independent } = written;
        let count = components.len();
        if count > MOST_CONTRIBUTIONS {
            return Err(format!(
                "a derived component takes at most {MOST_CONTRIBUTIONS} components, not {count}"
            ));
        }
        match scale.as_ref().map(Table::outputs) {
            Some(factors) if factors < count => {
                Err(format!("a derived component of {count} components has {factors} scale factors"))
            }
            _ => Ok(Self { operator, sign, components, scale, independent }),
        }
    }
}

impl Derived {
    /// The value at given forces.
    pub(super) fn evaluate<S>(&self, f: &[S; 6], context: &Context<'_, S>, flags: &mut Flags) -> S
    where
        S: Scalar,
        S::Real: Ordered,
    {
        let parts = self.parts.iter().enumerate();
        parts.fold(S::zero(), |sum, (i, part)| sum + part.evaluate(i + 1, f, context, flags))
    }

    pub(super) fn components(&self) -> impl Iterator<Item = usize> + '_ {
        self.parts.iter().flat_map(|part| part.components.iter().copied())
    }
}

impl DerivedPart {
    /// α_i f_i.
    pub(super) fn scaled<S>(&self, f: &[S; 6], context: &Context<'_, S>, flags: &mut Flags) -> Vec<S>
    where
        S: Scalar,
        S::Real: Ordered,
    {
        let motions = self.independent.as_ref().map(|(basis, components)| (context.of(*basis), components));
        let argument = |variable| match (variable, &motions) {
            (Variable::Column(j), Some((motions, components))) => {
                components.get(j).map_or_else(S::zero, |component| motions[*component])
            }
            (other, _) => context.conditions.of(other),
        };
        let mut scaled = Vec::with_capacity(self.components.len());
        for (i, component) in self.components.iter().enumerate() {
            scaled.push(match &self.scale {
                Some(table) => {
                    flags.rows("scale factor", table, context.conditions, i, |variable| {
                        argument(variable).real()
                    });
                    table.evaluate(i, argument) * f[*component]
                }
                None => f[*component],
            });
        }
        scaled
    }

    fn evaluate<S>(&self, term: usize, f: &[S; 6], context: &Context<'_, S>, flags: &mut Flags) -> S
    where
        S: Scalar,
        S::Real: Ordered,
    {
        let scaled = self.scaled(f, context, flags);
        let combined = match self.operator {
            Operator::Norm => {
                let norm = length(&scaled);
                if is_zero(norm.real()) {
                    flags.add(Flag::ContributionAtZero { term });
                }
                norm
            }
            Operator::Sum => scaled.into_iter().fold(S::zero(), |sum, x| sum + x),
            Operator::MacauleySum => {
                scaled.into_iter().fold(S::zero(), |sum, x| sum + macauley(x, term, flags))
            }
        };
        combined.scale(S::Real::from_f64(self.sign))
    }
}

/// ⟨x⟩ = max(x, 0).
fn macauley<S>(x: S, term: usize, flags: &mut Flags) -> S
where
    S: Scalar,
    S::Real: Ordered,
{
    if S::Real::ZERO.less(x.real()) {
        return x;
    }
    if is_zero(x.real()) {
        flags.add(Flag::MacauleyAtZero { term });
    }
    S::zero()
}

/// What a contribution to a potential is formed from.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Form {
    /// The force in a component (from 0).
    Component(usize),
    /// A derived component.
    Derived(Derived),
}

/// A contribution s · H(X/R − a) to a potential.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Contribution {
    /// X.
    pub of: Form,
    /// R.
    pub scale: f64,
    /// α.
    pub exponent: f64,
    /// H.
    pub function: PotentialFunction,
    /// a.
    pub shift: f64,
    /// s, +1 or −1.
    #[serde(deserialize_with = "crate::behavior::friction::read::sign")]
    pub sign: f64,
}

/// A potential: P = (Σ s_i P_i^α_i)^(1/β), or max s_i P_i.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "WrittenPotential")]
pub struct Potential {
    operator: PotentialOperator,
    exponent: f64,
    contributions: Vec<Contribution>,
}

/// A potential as a file has it, which may be none.
#[derive(serde::Deserialize)]
struct WrittenPotential {
    operator: PotentialOperator,
    exponent: f64,
    contributions: Vec<Contribution>,
}

impl TryFrom<WrittenPotential> for Potential {
    type Error = PotentialError;

    fn try_from(written: WrittenPotential) -> Result<Self, PotentialError> {
        let WrittenPotential { operator, exponent, contributions } = written;
        Self::new(operator, exponent, contributions)
    }
}

/// Why there is no such potential.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PotentialError {
    /// An exponent is not a positive number.
    #[error("the exponent {0} of a potential must be positive")]
    Exponent(f64),
    /// The scale factor R is zero or not finite, or the shift is not.
    #[error(
        "the scale factor {scale} of term {term} must be a number other than zero, and the shift {shift} a number"
    )]
    Scale {
        /// The term, from 1.
        term: usize,
        /// R.
        scale: f64,
        /// a.
        shift: f64,
    },
    /// More squares than the sum has places for.
    #[error(
        "a potential takes at most {MOST_CONTRIBUTIONS} contributions, counting every component of a NORM"
    )]
    Contributions,
    /// `NONE` may be negative, which has no power.
    #[error("term {0} has H = NONE, which needs the exponents α = β = 1 (or OPERATOR=MAX)")]
    SignedPower(usize),
}

impl Potential {
    /// A potential with β = `exponent`.
    ///
    /// # Errors
    /// [`PotentialError`]: exponents that are not positive, a scale factor of zero, H = NONE with a power.
    pub fn new(
        operator: PotentialOperator,
        exponent: f64,
        contributions: Vec<Contribution>,
    ) -> Result<Self, PotentialError> {
        let is_exponent = |x: f64| x > 0.0 && x.is_finite();
        if !is_exponent(exponent) {
            return Err(PotentialError::Exponent(exponent));
        }
        for (i, contribution) in contributions.iter().enumerate() {
            let Contribution { scale, exponent: own, function, shift, .. } = *contribution;
            if !is_exponent(own) {
                return Err(PotentialError::Exponent(own));
            }
            if scale == 0.0 || !scale.is_finite() || !scale.recip().is_finite() || !shift.is_finite() {
                return Err(PotentialError::Scale { term: i + 1, scale, shift });
            }
            let is_linear = own == 1.0 && exponent == 1.0;
            if function == PotentialFunction::None && operator == PotentialOperator::Sum && !is_linear {
                return Err(PotentialError::SignedPower(i + 1));
            }
        }
        let potential = Self { operator, exponent, contributions };
        let squares: usize =
            potential.contributions.iter().map(|c| c.norm().map_or(1, |n| n.components.len())).sum();
        if squares > MOST_CONTRIBUTIONS {
            return Err(PotentialError::Contributions);
        }
        Ok(potential)
    }

    /// Whether P changes with positions or motions.
    pub(super) fn moves(&self) -> bool {
        self.contributions.iter().any(|contribution| match &contribution.of {
            Form::Component(_) => false,
            Form::Derived(derived) => derived.parts.iter().any(|part| part.independent.is_some()),
        })
    }

    /// Σ |a_i|: P is formed from numbers as large as that, however small the forces are.
    pub fn shift(&self) -> f64 {
        self.contributions.iter().map(|contribution| contribution.shift.abs()).sum()
    }

    /// The components (from 0) with their R, where P is √(Σ (f_k/R_k)²) of single components.
    pub fn norm(&self) -> Option<Vec<(usize, f64)>> {
        if self.operator != PotentialOperator::Sum || self.exponent != 2.0 {
            return None;
        }
        let parts: Option<Vec<(usize, f64)>> = self
            .contributions
            .iter()
            .map(|of| match of.of {
                Form::Component(k) if of.is_plain_square() => Some((k, of.scale.abs())),
                Form::Component(_) | Form::Derived(_) => None,
            })
            .collect();
        parts.filter(|parts| parts.len() == self.components().len())
    }

    /// The components (from 0) that contribute, each once, in order.
    pub fn components(&self) -> Vec<usize> {
        let mut components: Vec<usize> = self
            .contributions
            .iter()
            .flat_map(|contribution| match &contribution.of {
                Form::Component(component) => vec![*component],
                Form::Derived(derived) => derived.components().collect(),
            })
            .collect();
        components.sort_unstable();
        components.dedup();
        components
    }

    /// P(K t)/K for t = f/K, with K = `unit`: P as the springs of stick see it. K enters where P is not homogeneous, as a/K and as
    /// K^(α_i − β), and nowhere else: what P does not feel of K leaves no rounding.
    ///
    /// The largest P_i^(α_i/β) is taken out of the sum as a real factor, so that no power overflows or vanishes.
    pub(super) fn evaluate<S>(&self, t: &[S; 6], unit: S, context: &Context<'_, S>, flags: &mut Flags) -> S
    where
        S: Scalar,
        S::Real: Ordered,
    {
        let is_quadratic = self.exponent == 2.0 && self.contributions.iter().all(|c| c.exponent == 2.0);
        if self.operator == PotentialOperator::Sum && is_quadratic {
            return self.root_of_squares(t, unit, context, flags);
        }
        let mut values = Vec::with_capacity(self.contributions.len());
        for (i, contribution) in self.contributions.iter().enumerate() {
            values.push(contribution.evaluate(i + 1, t, unit, context, flags));
        }
        match self.operator {
            PotentialOperator::Max => self.maximum(&values, flags),
            PotentialOperator::Sum => self.sum(&values, (t, unit), context, flags),
        }
    }

    /// √(Σ s_i P_i²): of squares, so that it is smooth where one of them is zero.
    fn root_of_squares<S>(&self, t: &[S; 6], unit: S, context: &Context<'_, S>, flags: &mut Flags) -> S
    where
        S: Scalar,
        S::Real: Ordered,
    {
        let mut squares = Vec::new();
        let mut signs = Vec::new();
        for (i, contribution) in self.contributions.iter().enumerate() {
            contribution.roots(i + 1, (t, unit), context, flags, &mut squares);
            signs.resize(squares.len(), contribution.sign);
        }
        if signs.iter().all(|sign| *sign > 0.0) {
            return length(&squares);
        }
        let signs: Vec<S::Real> = signs.into_iter().map(S::Real::from_f64).collect();
        combined(&squares, &signs, 2.0, &[], flags)
    }

    fn maximum<S>(&self, values: &[S], flags: &mut Flags) -> S
    where
        S: Scalar,
        S::Real: Ordered,
    {
        let mut most: Option<(usize, S)> = None;
        for (i, (value, contribution)) in values.iter().zip(&self.contributions).enumerate() {
            let signed = value.scale(S::Real::from_f64(contribution.sign));
            match most {
                Some((first, so_far)) if !so_far.real().less(signed.real()) => {
                    if !signed.real().less(so_far.real()) {
                        flags.add(Flag::TiedMaximum { terms: [first + 1, i + 1] });
                    }
                }
                _ => most = Some((i, signed)),
            }
        }
        let most = most.map_or_else(S::zero, |(_, value)| value);
        self.non_negative(most, flags).unwrap_or_else(S::zero)
    }

    /// A potential is a magnitude.
    fn non_negative<S>(&self, value: S, flags: &mut Flags) -> Option<S>
    where
        S: Scalar,
        S::Real: Ordered,
    {
        if value.real().less(S::Real::ZERO) {
            flags.add(Flag::NegativePotential);
            return None;
        }
        Some(value)
    }

    fn sum<S>(&self, values: &[S], (t, unit): (&[S; 6], S), context: &Context<'_, S>, flags: &mut Flags) -> S
    where
        S: Scalar,
        S::Real: Ordered,
    {
        let signs = || self.contributions.iter().map(|contribution| S::Real::from_f64(contribution.sign));
        let exponents = || self.contributions.iter().map(|contribution| contribution.exponent);
        if self.exponent == 1.0 && exponents().all(|own| own == 1.0) {
            let sum =
                values.iter().zip(signs()).fold(S::zero(), |sum, (value, sign)| sum + value.scale(sign));
            return self.non_negative(sum, flags).unwrap_or_else(S::zero);
        }
        let beta = S::Real::from_f64(self.exponent);
        let roots: Vec<S> = values
            .iter()
            .zip(exponents())
            .map(|(value, own)| {
                if own == self.exponent {
                    return *value;
                }
                let of = S::Real::from_f64(own) / beta;
                power(*value, of) * power(unit, of - S::Real::integer(1))
            })
            .collect();
        // Where the root of a square is zero, so are its derivatives; those of the square are not.
        let mut squares = Vec::new();
        if S::ORDER > 1 {
            for (i, (contribution, root)) in self.contributions.iter().zip(&roots).enumerate() {
                if !is_zero(root.real()) {
                    continue;
                }
                if contribution.exponent == 2.0 {
                    let mut own = Vec::new();
                    contribution.roots(i + 1, (t, unit), context, &mut Flags::default(), &mut own);
                    let factor = unit.real().power(S::Real::integer(1) - beta * S::Real::ratio(1, 2));
                    let sign = S::Real::from_f64(contribution.sign);
                    squares.extend(own.into_iter().map(|x| (x.scale(factor), sign)));
                } else if contribution.exponent < 2.0 && contribution.exponent != 1.0 {
                    flags.add(Flag::InfiniteCurvature { term: i + 1 });
                }
            }
        }
        combined(&roots, &signs().collect::<Vec<_>>(), self.exponent, &squares, flags)
    }

    /// The components k whose only contribution is `|f_k/R|^α` with 1 < α < 2, each with α and a factor. It is that of
    /// `|t_k|^(α − 1) sign t_k` in ∂P/∂f_k, `(α/β) p^(1 − β) K^(α − β)/|R|^α`, times a size of t to the power of α − 1. Of the
    /// arguments `p` is P/K and `unit` is K.
    pub(super) fn bent<R: Ordered>(&self, p: R, size: R, unit: R) -> Vec<(usize, f64, R)> {
        if self.operator == PotentialOperator::Max {
            return Vec::new();
        }
        let is_alone = |k: usize| {
            let of = self.contributions.iter().filter(|contribution| contribution.contains(k));
            of.count() == 1
        };
        let is_bent = |contribution: &&Contribution| {
            let Contribution { exponent, function, shift, sign, .. } = **contribution;
            1.0 < exponent
                && exponent < 2.0
                && function == PotentialFunction::Abs
                && shift == 0.0
                && sign > 0.0
        };
        let of = |contribution: &Contribution| match contribution.of {
            Form::Component(k) if is_alone(k) => {
                let own = contribution.exponent;
                let (alpha, beta, one) = (R::from_f64(own), R::from_f64(self.exponent), R::integer(1));
                let radius = R::from_f64(contribution.scale).magnitude();
                let raised = if own == self.exponent {
                    (size / radius / p).power(alpha - one)
                } else {
                    (size / radius).power(alpha - one) * p.power(one - beta) * unit.power(alpha - beta)
                };
                Some((k, own, alpha / beta * raised / radius))
            }
            _ => None,
        };
        self.contributions.iter().filter(is_bent).filter_map(of).collect()
    }

    /// The terms (from 1) with 1 < α < 2 whose curvature at zero is infinite, that are zero at f = K t and are not among
    /// [`Self::bent`].
    pub(super) fn infinitely_curved<R: Ordered>(
        &self,
        t: &[R; 6],
        unit: R,
        context: &Context<'_, R>,
    ) -> Vec<usize> {
        let one = R::integer(1);
        let known: Vec<usize> = self.bent(one, one, one).into_iter().map(|(k, ..)| k).collect();
        let is_known =
            |contribution: &Contribution| matches!(contribution.of, Form::Component(k) if known.contains(&k));
        let is_met = |(i, contribution): &(usize, &Contribution)| {
            1.0 < contribution.exponent
                && contribution.exponent < 2.0
                && self.operator == PotentialOperator::Sum
                && !is_known(contribution)
                && is_zero(contribution.evaluate(i + 1, t, unit, context, &mut Flags::default()))
        };
        self.contributions.iter().enumerate().filter(is_met).map(|(i, _)| i + 1).collect()
    }
}

/// (Σ s_i q_i^β)^(1/β) for q_i ≥ 0, or of any sign where β = 2; zero where the sum is not positive.
///
/// With y_i = q_i/M, M the largest: no power overflows or vanishes. Lifted to second order in the nilpotent parts e_i it is
/// `P + Σ g_i e_i + ½ (Σ a_i e_i (e_i/M) + b (Σ g_i e_i)²/M)`, so that 1/M is never squared. The `squares` are terms s x² of the
/// same sum at x = 0.
fn combined<S>(
    values: &[S],
    signs: &[S::Real],
    exponent: f64,
    squares: &[(S, S::Real)],
    flags: &mut Flags,
) -> S
where
    S: Scalar,
    S::Real: Ordered,
{
    const { assert!(S::ORDER <= 2, "potentials are lifted to second order") }
    let (zero, one, beta) = (S::Real::ZERO, S::Real::integer(1), S::Real::from_f64(exponent));
    let most = values.iter().fold(zero, |most, q| larger(most, q.real().magnitude()));
    if is_zero(most) {
        return S::zero();
    }
    // y^(β − k), zero where it would be infinite.
    let raised = |y: S::Real, k: i32| match exponent - f64::from(k) {
        0.0 => one,
        1.0 => y,
        2.0 => y * y,
        left if left < 0.0 && is_zero(y) => zero,
        _ => y.power(beta - S::Real::integer(k)),
    };
    let scaled: Vec<S::Real> = values.iter().map(|q| q.real() / most).collect();
    let bracket = scaled.iter().zip(signs).fold(zero, |sum, (y, sign)| sum + *sign * raised(*y, 0));
    if bracket.less(zero) {
        flags.add(Flag::NegativePotential);
    }
    if !zero.less(bracket) {
        return S::zero();
    }
    let root = if exponent == 2.0 { bracket.square_root() } else { bracket.power(one / beta) };
    let value = S::from_real(root * most);
    if S::ORDER == 0 {
        return value;
    }
    let inverse = one / most;
    let slope = root / bracket; // β dP/dΣ over M
    let (mut first, mut second) = (S::zero(), S::zero());
    for ((q, y), sign) in values.iter().zip(&scaled).zip(signs) {
        let e = q.nilpotent();
        first = first + e.scale(*sign * slope * raised(*y, 1));
        if S::ORDER > 1 && exponent != 1.0 {
            let bend = *sign * slope * (beta - one) * raised(*y, 2);
            second = second + (e * e.scale(inverse)).scale(bend);
        }
    }
    if S::ORDER > 1 {
        second = second + (first * first.scale(inverse)).scale((one - beta) / root);
        for (x, sign) in squares {
            let e = x.nilpotent();
            let bend = *sign * slope * S::Real::integer(2) / beta * most.power(one - beta);
            second = second + (e * e).scale(bend);
        }
    }
    value + first + second.scale(S::Real::ratio(1, 2))
}

impl Contribution {
    /// Whether its square is (X/R)².
    fn is_plain_square(&self) -> bool {
        let is_magnitude = self.function == PotentialFunction::Abs && self.shift == 0.0;
        is_magnitude && self.exponent == 2.0 && self.sign > 0.0
    }

    /// The NORM that |X| is, if it is one without a shift.
    fn norm(&self) -> Option<&DerivedPart> {
        match (&self.of, self.function, self.shift) {
            (Form::Derived(derived), PotentialFunction::Abs, 0.0) => match derived.parts.as_slice() {
                [part] if part.operator == Operator::Norm => Some(part),
                _ => None,
            },
            _ => None,
        }
    }

    /// Whether a component (from 0) takes part.
    fn contains(&self, component: usize) -> bool {
        match &self.of {
            Form::Component(k) => *k == component,
            Form::Derived(derived) => derived.components().any(|k| k == component),
        }
    }

    /// X/R − a over K.
    fn argument<S: Scalar>(&self, value: S, unit: S) -> S {
        let scaled = value.scale(S::Real::integer(1) / S::Real::from_f64(self.scale));
        if self.shift == 0.0 { scaled } else { scaled - recip(unit).scale(S::Real::from_f64(self.shift)) }
    }

    /// Numbers whose squares make H(X/R − a)² over K².
    fn roots<S>(
        &self,
        term: usize,
        (t, unit): (&[S; 6], S),
        context: &Context<'_, S>,
        flags: &mut Flags,
        squares: &mut Vec<S>,
    ) where
        S: Scalar,
        S::Real: Ordered,
    {
        if let Some(part) = self.norm() {
            squares.extend(part.scaled(t, context, flags).into_iter().map(|x| self.argument(x, unit)));
            return;
        }
        let argument = self.argument(self.value(t, context, flags), unit);
        squares.push(match self.function {
            PotentialFunction::Macauley => macauley(argument, term, flags),
            PotentialFunction::Abs | PotentialFunction::None => argument,
        });
    }

    fn value<S>(&self, f: &[S; 6], context: &Context<'_, S>, flags: &mut Flags) -> S
    where
        S: Scalar,
        S::Real: Ordered,
    {
        match &self.of {
            Form::Component(component) => f[*component],
            Form::Derived(derived) => derived.evaluate(f, context, flags),
        }
    }

    /// H(X/R − a) over K.
    fn evaluate<S>(&self, term: usize, t: &[S; 6], unit: S, context: &Context<'_, S>, flags: &mut Flags) -> S
    where
        S: Scalar,
        S::Real: Ordered,
    {
        let argument = self.argument(self.value(t, context, flags), unit);
        match self.function {
            PotentialFunction::Abs => {
                if is_zero(argument.real()) {
                    flags.add(Flag::ContributionAtZero { term });
                }
                abs(argument)
            }
            PotentialFunction::Macauley => macauley(argument, term, flags),
            PotentialFunction::None => argument,
        }
    }
}
