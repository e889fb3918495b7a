//! The limit of a friction on its own reaction, with the derivatives by which it is solved for.

use crate::motion::mechanism::Slider;
use crate::motion::mode::Branches;
use crate::number::{Number, larger, largest};
use pintle_kinematics::scalar::elementary::{exp_m1, norm};
use pintle_kinematics::scalar::{Scalar, Seeded};
use pintle_model::behavior::Conditions;
use pintle_model::behavior::friction::{Belt, Coefficient, ContactParts, Context, Friction};

/// The limit min(μ F_N, τ_max) at some forces.
#[derive(Clone, Debug)]
pub(crate) struct Limit<R> {
    pub(crate) value: R,
    /// ∂limit/∂f_k.
    pub(crate) gradient: [R; 6],
    /// Where a magnitude passes zero: its part along its branch, and the size of the forces.
    pub(crate) turns: Vec<(Option<usize>, [R; 2])>,
    /// τ_max − μ F_N, of the branch positive, where there is a τ_max.
    pub(crate) caps: Option<[R; 2]>,
    /// The branches at these forces.
    pub(crate) branches: Branches<R>,
    /// μ Σ factor |A| by component: how strongly the limit may depend on each force.
    pub(crate) reach: Vec<(R, Vec<[R; 6]>)>,
}

/// Below this part of the forces a magnitude counts as zero, and one aside of its branch as none.
const SMALL: f64 = 1e-11;

/// μ at a slip rate and a contact force, and its derivative by the force. Beyond the span of its table, of which a point `inside` is given, it
/// goes on along it.
fn coefficient<R: Number>(
    of: &Coefficient,
    (rate, inside): (R, Option<R>),
    normal: R,
    conditions: &Conditions,
) -> [R; 2] {
    let (at, beyond) = inside.map_or((rate, R::ZERO), |inside| (inside, rate - inside));
    let mu = of.at(R::Gradient::<2>::seed(at, 0), R::Gradient::<2>::seed(normal, 1), conditions);
    let [by_rate, by_normal] = mu.gradient();
    let along = if inside.is_some() { by_rate * beyond } else { R::ZERO };
    [mu.real() + along, by_normal]
}

/// What presses in a friction, where its connector is now.
pub(crate) struct Contact<'a, R: Number> {
    friction: &'a Friction,
    context: Context<'a, R>,
    parts: Option<ContactParts<R>>,
    internal: R,
    /// Whether F_C + F_C^int may change its sign: a sum of magnitudes has none to change.
    may_turn: bool,
}

impl<'a, R: Number> Contact<'a, R> {
    /// At positions and a slip.
    pub(crate) fn new(
        friction: &'a Friction,
        (position, motion, slip): ([R; 6], [R; 6], R),
        conditions: &'a Conditions,
    ) -> Self {
        let context = Context { position, motion, accumulated_slip: slip, conditions };
        let parts = friction.criterion.contact_parts(&context);
        let internal = friction.criterion.internal_force(&context);
        let may_turn = internal.less(R::ZERO)
            || match &parts {
                Some(parts) => parts.linear.iter().any(|x| R::ZERO.less(x.magnitude())),
                None => friction.criterion.contact_norms(&context).is_empty(),
            };
        Self { friction, context, parts, internal, may_turn }
    }

    /// The limit at the forces p that press, and a slip rate; branches that are known stay. Of the limit value and gradient alone are found
    /// where `is_whole` is false.
    pub(crate) fn limit(
        &self,
        pressing: &[R; 6],
        (rate, inside): (R, Option<R>),
        known: Option<&Branches<R>>,
        is_whole: bool,
    ) -> Limit<R> {
        let zero = R::ZERO;
        let Self { friction, context, parts, internal, may_turn } = self;
        // Where all that presses passes zero together, what is left of it is rounding of the rest.
        let size = larger(larger(largest(*pressing), internal.magnitude()), R::from_f64(f64::MIN_POSITIVE));
        let small = size * R::from_f64(SMALL * (R::ROUNDING / f64::ROUNDING).sqrt());
        let mut branches = Branches::none();
        let mut turns = Vec::new();
        let (mut contact, mut gradient);
        match parts {
            Some(ContactParts { linear, magnitudes, .. }) => {
                gradient = *linear;
                contact = dot(linear, pressing);
                for (i, (factor, rows)) in magnitudes.iter().enumerate() {
                    let mut places = [zero; 6];
                    places.iter_mut().zip(rows).for_each(|(x, row)| *x = dot(row, pressing));
                    let vector = &places[..rows.len().min(6)];
                    let told = known.and_then(|known| known.magnitudes.get(i));
                    let length = length(vector);
                    let along = |unit: &[R]| vector.iter().zip(unit).fold(zero, |sum, (x, e)| sum + *x * *e);
                    let aside = |unit: &[R]| {
                        let part = along(unit);
                        largest(vector.iter().zip(unit).map(|(x, e)| *x - part * *e))
                    };
                    let is_nothing = !small.less(length);
                    // A vector that keeps to a line goes on through zero along it, to the end of the step.
                    let mut direction = [zero; 6];
                    let value = match told {
                        Some(Some(unit)) if aside(unit).less(small) => {
                            direction.iter_mut().zip(unit).for_each(|(x, e)| *x = *e);
                            along(unit)
                        }
                        Some(None) if known.is_some_and(|known| known.zeros_stay) => zero,
                        _ => {
                            if !is_nothing {
                                direction.iter_mut().zip(vector).for_each(|(e, x)| *e = *x / length);
                            }
                            length
                        }
                    };
                    contact = contact + *factor * value;
                    for (row, e) in rows.iter().zip(&direction) {
                        for (entry, x) in gradient.iter_mut().zip(row) {
                            *entry = *entry + *factor * *x * *e;
                        }
                    }
                    if !is_whole {
                        continue;
                    }
                    if let Some(Some(unit)) = told {
                        turns.push((Some(i), [along(unit), size]));
                    }
                    branches.magnitudes.push(match told {
                        Some(told) if is_nothing => told.clone(),
                        _ if is_nothing => None,
                        _ => Some(vector.iter().map(|x| *x / length).collect()),
                    });
                }
            }
            None => {
                // A derived component: its kinks are not events.
                let seeded: [R::Gradient<6>; 6] =
                    std::array::from_fn(|k| R::Gradient::<6>::seed(pressing[k], k));
                let constant = R::Gradient::<6>::from_real;
                let (point, _) =
                    friction.criterion.at(&seeded, constant(R::integer(1)), None, &context.map(constant));
                contact = point.contact.real();
                gradient = point.contact.gradient();
            }
        }
        let signed = contact + *internal;
        let told = known.and_then(|known| known.normal);
        let now = if *may_turn && signed.less(zero) { R::integer(-1) } else { R::integer(1) };
        branches.normal = small.less(signed.magnitude()).then_some(now);
        let sign = told.unwrap_or(now);
        if told.is_some() && *may_turn && is_whole {
            turns.push((None, [sign * signed, size]));
        }
        let normal = sign * signed;
        let [mu, by_normal] = coefficient(&friction.coefficient, (rate, inside), normal, context.conditions);
        let (value, slope) = (mu * normal, mu + by_normal * normal);
        let mut caps = None;
        if let Some(maximum) = friction.maximum.map(R::from_f64) {
            let below = maximum - value;
            let is_capped = known.and_then(|known| known.is_capped).unwrap_or(below.less(zero));
            caps = Some([if is_capped { -below } else { below }, maximum]);
            branches.is_capped = Some(below.less(zero));
            if is_capped {
                let none = vec![];
                return Limit { value: maximum, gradient: [zero; 6], turns, caps, branches, reach: none };
            }
        }
        let reach = match parts {
            _ if !is_whole => Vec::new(),
            None => vec![(slope.magnitude(), vec![gradient])],
            Some(parts) => {
                let linear = (slope.magnitude(), vec![parts.linear]);
                let others = parts.magnitudes.iter();
                let others = others.map(|(factor, rows)| ((slope * *factor).magnitude(), rows.clone()));
                std::iter::once(linear).chain(others).collect()
            }
        };
        Limit { value, gradient: gradient.map(|entry| sign * slope * entry), turns, caps, branches, reach }
    }
}

/// The limit of a belt at its tensions before and after the ring: min(T1, T2) (exp(μ α) − 1). Tensions follow from where things are, so that
/// no reaction enters it.
pub(crate) fn belt_limit<R: Number>(
    belt: &Belt,
    tensions: [R; 2],
    angle: f64,
    rate: (R, Option<R>),
    conditions: &Conditions,
) -> Limit<R> {
    let [first, second] = tensions;
    let least = larger(if second.less(first) { second } else { first }, R::ZERO);
    let [mu, _] = coefficient(&belt.coefficient, rate, least, conditions);
    let value = least * exp_m1(mu * R::from_f64(angle));
    let value = belt.maximum.map(R::from_f64).filter(|most| most.less(value)).unwrap_or(value);
    Limit {
        value,
        gradient: [R::ZERO; 6],
        turns: Vec::new(),
        caps: None,
        branches: Branches::none(),
        reach: Vec::new(),
    }
}

fn dot<R: Number>(row: &[R; 6], f: &[R; 6]) -> R {
    row.iter().zip(f).fold(R::ZERO, |sum, (x, y)| sum + *x * *y)
}

impl Slider {
    /// The direction in which slip resists friction forces f, n_k ~ f_k/R_k; without forces that of the first component.
    pub(crate) fn against<R: Number>(&self, friction: &[R; 6]) -> [R; 6] {
        let mut along = [R::ZERO; 6];
        for (k, radius) in &self.components {
            along[*k] = friction[*k] * R::from_f64(*radius).reciprocal_or_zero();
        }
        let size = length(&along);
        if R::ZERO.less(size) {
            return along.map(|x| x / size);
        }
        if let Some((k, _)) = self.components.first() {
            along[*k] = R::integer(1);
        }
        along
    }

    /// R_k v_k of each component.
    pub(crate) fn rates<R: Number>(&self, velocity: &[R; 6]) -> [R; 6] {
        let mut along = [R::ZERO; 6];
        for (k, radius) in &self.components {
            along[*k] = R::from_f64(*radius) * velocity[*k];
        }
        along
    }

    /// R_k Δx_k of each component, from one position to another.
    pub(crate) fn moved<R: Number>(&self, from: &[R; 6], to: &[R; 6]) -> [R; 6] {
        self.rates(&std::array::from_fn(|k| to[k] - from[k]))
    }
}

/// The length of at most six numbers.
pub(crate) fn length<R: Number>(of: &[R]) -> R {
    let mut all = [R::ZERO; 6];
    for (place, x) in all.iter_mut().zip(of) {
        *place = *x;
    }
    norm(all)
}
