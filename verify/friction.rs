//! Friction: criteria against the manual's formulas typed a second time, derivatives against differences on 237 bits, the laws
//! that stick and slip obey, and what JAX computes.

mod coefficients; // coefficients, and where a limit is met first
mod criteria; // P, F_C, F_N, Φ and their derivatives
pub(crate) mod golden; // what JAX computes
mod histories; // stick and slip along states
mod laws; // stick, slip, energy, thresholds, range
mod potentials; // potentials against their formulas
mod powers; // exponents below 2 at zero
mod tangents; // consistent tangents against differences
mod users; // frictions that a deck defines

use crate::states::Draw;
use pintle_kinematics::catalog::{Contact, TABLE};
use pintle_kinematics::scalar::{Real, Wide};
use pintle_model::behavior::friction::Context;
use pintle_model::behavior::friction::{
    Coefficient, Contribution, Criterion, Derived, DerivedPart, Form, Friction, Input, Internal, Potential,
    Pressing, State, StickStiffness, Tangential,
};
use pintle_model::behavior::table::Table;
use pintle_scene::{Basis, Extrapolation, Operator, PotentialFunction, PotentialOperator};

/// u = 2⁻⁵³.
pub(crate) const U: f64 = f64::EPSILON / 2.0;

/// A predefined friction of the catalogue with numbers: the type, the criterion's place, and the criterion.
pub(crate) fn predefined(draw: &mut Draw, planar: bool) -> Vec<(String, usize, Vec<Option<f64>>, Criterion)> {
    let mut all = Vec::new();
    for entry in TABLE {
        let Some(friction) = entry.friction.filter(|f| f.criteria.iter().all(|c| c.contact != Contact::Belt))
        else {
            continue;
        };
        for variant in 0..4 {
            let numbers: Vec<Option<f64>> = friction
                .parameters
                .iter()
                .enumerate()
                .map(|(i, parameter)| match (variant, parameter.required) {
                    (0, false) => None,
                    (1, false) if i % 2 == 0 => Some(0.0),
                    _ => Some(draw.between(0.2, 2.0)),
                })
                .collect();
            let criteria = Criterion::predefined(&friction, &numbers, &[], planar).unwrap();
            for (i, criterion) in criteria.into_iter().enumerate() {
                all.push((entry.name.to_string(), i, numbers.clone(), criterion));
            }
        }
    }
    all
}

pub(crate) fn component(k: usize, exponent: f64, function: PotentialFunction) -> Contribution {
    Contribution { of: Form::Component(k), scale: 1.5, exponent, function, shift: 0.0, sign: 1.0 }
}

fn criterion(tangential: Tangential, pressing: Pressing, internal: Internal) -> Criterion {
    Criterion { tangential, pressing, internal, output: "CSFC" }
}

/// α = 1 + 0.3 u1 − 0.2 u2 as a table for two components, the second with twice the factors.
fn scales() -> Table {
    let row = |x: f64, y: f64| {
        let factor = 1.0 + 0.3 * x - 0.2 * y;
        pintle_scene::TableRow {
            values: [factor, 2.0 * factor, x, y].map(Some).to_vec(),
            ..Default::default()
        }
    };
    let grid = [-1.0, 0.2, 1.1].iter().flat_map(|y| [-1.0, 0.4, 1.2].map(|x| row(x, *y)));
    Table::new(&grid.collect::<Vec<_>>(), 2, &["u1", "u2"], Extrapolation::Linear).unwrap()
}

/// Criteria that a user may define, by name.
pub(crate) fn users() -> Vec<(&'static str, Criterion)> {
    use PotentialFunction::{Abs, Macauley, None as Plain};
    let part = |operator, components: &[usize], sign| DerivedPart {
        operator,
        sign,
        components: components.to_vec(),
        scale: None,
        independent: None,
    };
    let derived = |parts| Derived { parts };
    let moving = DerivedPart {
        scale: Some(scales()),
        independent: Some((Basis::Position, vec![0, 1])),
        ..part(Operator::Norm, &[3, 4], 1.0)
    };
    let sum =
        |beta, terms| Tangential::Potential(Potential::new(PotentialOperator::Sum, beta, terms).unwrap());
    let internal = Internal::Table {
        table: Table::curve(&[(0.0, 0.4), (0.02, 0.9), (0.05, 1.3), (2.0, 1.1)], Extrapolation::Constant)
            .unwrap(),
        basis: Basis::Position,
        components: vec![],
    };
    vec![
        (
            "component",
            criterion(Tangential::Norm(vec![(1, 1.0)]), Pressing::Component(4), Internal::Constant(0.3)),
        ),
        (
            "internal force over accumulated slip",
            criterion(Tangential::Norm(vec![(0, 1.0), (2, 1.0)]), Pressing::Component(4), internal),
        ),
        (
            "derived sum",
            criterion(
                Tangential::Norm(vec![(0, 1.0)]),
                Pressing::Derived(derived(vec![
                    part(Operator::Norm, &[1, 2], 1.0),
                    part(Operator::Sum, &[3, 4], -1.0),
                    part(Operator::MacauleySum, &[2, 5], 1.0),
                ])),
                Internal::Constant(-0.2),
            ),
        ),
        (
            "scaled by position",
            criterion(
                Tangential::Norm(vec![(0, 1.0)]),
                Pressing::Derived(derived(vec![moving.clone()])),
                Internal::Constant(0.1),
            ),
        ),
        (
            "ellipsoid",
            criterion(
                sum(
                    2.0,
                    vec![
                        component(0, 2.0, Abs),
                        Contribution { scale: 0.7, ..component(1, 2.0, Abs) },
                        Contribution { scale: 0.4, ..component(3, 2.0, Abs) },
                    ],
                ),
                Pressing::Component(4),
                Internal::Constant(0.0),
            ),
        ),
        (
            "cubic",
            criterion(
                sum(3.0, vec![component(0, 3.0, Abs), Contribution { scale: 0.6, ..component(2, 3.0, Abs) }]),
                Pressing::Derived(derived(vec![part(Operator::Norm, &[4, 5], 1.0)])),
                Internal::Constant(0.0),
            ),
        ),
        (
            "mixed exponents",
            criterion(
                sum(
                    2.0,
                    vec![
                        component(0, 2.0, Abs),
                        Contribution { scale: 0.8, ..component(1, 2.5, Macauley) },
                        component(2, 2.0, Abs),
                    ],
                ),
                Pressing::Component(4),
                Internal::Constant(0.5),
            ),
        ),
        (
            "shifted",
            criterion(
                sum(
                    2.0,
                    vec![Contribution { shift: 0.05, ..component(0, 2.0, Abs) }, component(1, 2.0, Abs)],
                ),
                Pressing::Component(4),
                Internal::Constant(0.5),
            ),
        ),
        (
            "linear",
            criterion(
                sum(
                    1.0,
                    vec![component(0, 1.0, Abs), Contribution { scale: 0.8, ..component(1, 1.0, Plain) }],
                ),
                Pressing::Component(4),
                Internal::Constant(0.0),
            ),
        ),
        (
            "norm scaled by position",
            criterion(
                sum(
                    2.0,
                    vec![
                        component(0, 2.0, Abs),
                        Contribution { of: Form::Derived(derived(vec![moving])), ..component(3, 2.0, Abs) },
                    ],
                ),
                Pressing::Component(5),
                Internal::Constant(0.2),
            ),
        ),
        (
            "maximum",
            criterion(
                Tangential::Potential(
                    Potential::new(
                        PotentialOperator::Max,
                        2.0,
                        vec![component(0, 2.0, Abs), Contribution { scale: 0.3, ..component(1, 2.0, Abs) }],
                    )
                    .unwrap(),
                ),
                Pressing::Component(4),
                Internal::Constant(0.0),
            ),
        ),
    ]
}

/// Coefficients of every kind, by name.
pub(crate) fn coefficients() -> Vec<(&'static str, Coefficient)> {
    let row = |mu: f64, rate: f64, force: f64| pintle_scene::TableRow {
        values: [mu, rate, force].map(Some).to_vec(),
        ..Default::default()
    };
    let rows = [
        row(0.4, 0.0, 0.0),
        row(0.3, 0.5, 0.0),
        row(0.25, 2.0, 0.0),
        row(0.35, 0.0, 5.0),
        row(0.28, 0.4, 5.0),
        row(0.2, 3.0, 5.0),
    ];
    let table = Table::new(&rows, 1, &["rate", "force"], Extrapolation::Constant).unwrap();
    vec![
        ("constant", Coefficient::Constant(0.3)),
        ("decay", Coefficient::Exponential { at_rest: 0.45, kinetic: 0.25, decay: 0.8 }),
        ("hardening", Coefficient::Exponential { at_rest: 0.2, kinetic: 0.35, decay: 0.6 }),
        ("table", Coefficient::Table(table)),
    ]
}

/// A friction with these.
pub(crate) fn friction(
    criterion: &Criterion,
    coefficient: &Coefficient,
    stick_stiffness: StickStiffness,
) -> Friction {
    Friction {
        criterion: criterion.clone(),
        coefficient: coefficient.clone(),
        maximum: None,
        stick_stiffness,
        radius: 0.8,
    }
}

/// The numbers of an increment, on any real number.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Numbers {
    pub(crate) displacement: [f64; 6],
    pub(crate) forces: [f64; 6],
    pub(crate) duration: Option<f64>,
    pub(crate) position: [f64; 6],
}

impl Numbers {
    pub(crate) fn drawn(draw: &mut Draw, step: f64) -> Self {
        let mut six = |size: f64| {
            let away = |x: f64| if x < 0.0 { x - 0.1 * size } else { x + 0.1 * size };
            [0; 6].map(|_| away(draw.between(-size, size)))
        };
        let (displacement, forces, position) = (six(step), six(3.0), six(0.8));
        Self { displacement, forces, duration: Some(draw.between(0.01, 0.2)), position }
    }

    pub(crate) fn input<R: Real>(&self) -> Input<'static, R> {
        let wide = |x: [f64; 6]| x.map(R::from_f64);
        Input {
            displacement: wide(self.displacement),
            forces: wide(self.forces),
            duration: self.duration.map(R::from_f64),
            context: Context {
                position: wide(self.position),
                motion: wide(self.position),
                ..Context::default()
            },
        }
    }
}

pub(crate) fn widened(state: &State<f64>) -> State<Wide> {
    State {
        force: state.force.map(Wide::from_f64),
        accumulated_slip: Wide::from_f64(state.accumulated_slip),
        stick_stiffness: state.stick_stiffness.map(Wide::from_f64),
    }
}
