//! Predefined friction as data: what presses, what slides, and with which parameters.
//!
//! The evaluation ([`pintle_model::behavior::friction`]) and the printed formulas ([`FrictionCriterion::tangential_formula`],
//! [`FrictionCriterion::contact_formula`]) read the same terms, so that what `pintle explain` shows is what is computed.

use crate::catalog::{Evidence, FORCE};

/// A parameter of predefined friction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrictionParameter {
    /// The manual's symbol: R_r, L, F_C^int.
    pub symbol: &'static str,
    /// Whether it must be given. A parameter that is left out is zero.
    pub required: bool,
}

/// A number in a friction formula that no data line gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionConstant {
    /// Its symbol.
    pub symbol: &'static str,
    /// Its value, unless it is set otherwise.
    pub value: f64,
    /// What it says, and which other values make sense.
    pub meaning: &'static str,
}

/// What a term is multiplied by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The parameter at this place (from 0) of [`Friction::parameters`].
    Parameter(usize),
    /// The constant at this place (from 0) of [`Friction::constants`].
    Constant(usize),
}

/// number · Π times / over. A term divided by a parameter that is zero is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Factor {
    /// The number.
    pub number: i32,
    /// What multiplies it.
    pub times: &'static [Quantity],
    /// The parameter that divides it.
    pub over: Option<usize>,
}

/// An axis of a universal joint's cross.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CrossAxis {
    /// e1a, about which b's yoke turns by ur1.
    OfA,
    /// e3b, about which it turns by ur3.
    OfB,
}

impl CrossAxis {
    /// The direction's name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::OfA => "e1a",
            Self::OfB => "e3b",
        }
    }
}

/// The magnitude of some of the forces f1 … m3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Load {
    /// √(Σ f_k²) over the components listed (from 0); |f_k| for one.
    Norm(&'static [usize]),
    /// |f·t|, the force along an axis.
    Along(CrossAxis),
    /// |f − (f·t) t|, the force across an axis.
    Across(CrossAxis),
}

/// One term of a contact force: factor · magnitude.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ContactTerm {
    /// The factor.
    pub factor: Factor,
    /// The magnitude.
    pub load: Load,
}

/// F_C, what presses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contact {
    /// Π arm · Σ terms.
    Sum {
        /// What multiplies the sum.
        arm: &'static [Quantity],
        /// The terms.
        terms: &'static [ContactTerm],
    },
    /// A belt around a ring: F_C is min(T1, T2), the limit F_C (exp(μ α) − 1), where T1 and T2 are the tensions of the two
    /// segments and α is the angle of wrap.
    Belt,
}

/// A component that slides: its traction f_k, or m_k / radius.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Traction {
    /// The component (from 0).
    pub component: usize,
    /// The parameter that turns a moment into a force.
    pub radius: Option<usize>,
}

/// One criterion of predefined friction, Φ = P(f) − μ F_N ≤ 0 with F_N = |F_C + F_C^int|.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrictionCriterion {
    /// P is the norm of these.
    pub traction: &'static [Traction],
    /// F_C, the contact force (or moment).
    pub contact: Contact,
    /// The parameter F_C^int (or M_C^int).
    pub internal: Option<usize>,
    /// The output in which the friction force appears.
    pub output: &'static str,
}

/// Predefined friction of a type.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// Parameters in the order of the data line of `*CONNECTOR FRICTION, PREDEFINED`.
    pub parameters: &'static [FrictionParameter],
    /// Numbers of ours, which can be set otherwise.
    pub constants: &'static [FrictionConstant],
    /// Its criteria.
    pub criteria: &'static [FrictionCriterion],
    /// How well the formulas are documented.
    pub evidence: Evidence,
}

impl Eq for Friction {}

impl Friction {
    fn symbol(&self, quantity: Quantity) -> &'static str {
        match quantity {
            Quantity::Parameter(i) => self.parameters.get(i).map_or("", |parameter| parameter.symbol),
            Quantity::Constant(i) => self.constants.get(i).map_or("", |constant| constant.symbol),
        }
    }

    /// The symbols of the parameters that no criterion holds: they are read, and nothing depends on them.
    pub fn unused_parameters(&self) -> impl Iterator<Item = &'static str> {
        let holds = |i: usize| {
            let is = |quantity: &Quantity| *quantity == Quantity::Parameter(i);
            self.criteria.iter().any(|criterion| {
                let in_contact = match criterion.contact {
                    Contact::Belt => false,
                    Contact::Sum { arm, terms } => {
                        arm.iter().any(is)
                            || terms
                                .iter()
                                .any(|term| term.factor.over == Some(i) || term.factor.times.iter().any(is))
                    }
                };
                in_contact
                    || criterion.internal == Some(i)
                    || criterion.traction.iter().any(|traction| traction.radius == Some(i))
            })
        };
        let unused: Vec<&'static str> = self
            .parameters
            .iter()
            .enumerate()
            .filter(|(i, _)| !holds(*i))
            .map(|(_, parameter)| parameter.symbol)
            .collect();
        unused.into_iter()
    }

    fn product(&self, quantities: &[Quantity]) -> String {
        quantities.iter().map(|quantity| self.symbol(*quantity)).collect::<Vec<_>>().join(" ")
    }

    /// The factor and the magnitude of a term as one product.
    fn term(&self, factor: &Factor, load: &str) -> String {
        let mut front = self.product(factor.times);
        if factor.number != 1 {
            front = if front.is_empty() {
                factor.number.to_string()
            } else {
                format!("{} {front}", factor.number)
            };
        }
        match factor.over.map(|parameter| self.symbol(Quantity::Parameter(parameter))) {
            Some(over) if front.is_empty() => format!("{load}/{over}"),
            Some(over) => format!("({front}/{over}) {load}"),
            None if front.is_empty() => load.to_string(),
            None => format!("{front} {load}"),
        }
    }
}

/// √(a² + b²), or |a|.
fn norm(of: &[String]) -> String {
    match of {
        [] => "0".to_string(),
        [one] => format!("|{one}|"),
        many => {
            let squares: Vec<String> = many.iter().map(|name| format!("{name}²")).collect();
            format!("√({})", squares.join(" + "))
        }
    }
}

impl Load {
    /// In the forces that are present; `None` where none is.
    pub fn formula(self, present: [bool; 6]) -> Option<String> {
        match self {
            Self::Norm(components) => {
                let names: Vec<String> =
                    components.iter().filter(|k| present[**k]).map(|k| FORCE[*k].to_string()).collect();
                (!names.is_empty()).then(|| norm(&names))
            }
            Self::Along(axis) => Some(format!("|f·{}|", axis.name())),
            Self::Across(axis) => Some(format!("|f − (f·{0}) {0}|", axis.name())),
        }
    }
}

/// The forces f1 … m3 in three dimensions.
pub const SPATIAL: [bool; 6] = [true; 6];

/// The forces f1, f2 and m3 in two-dimensional and axisymmetric analysis (CONN2D2).
pub const PLANE: [bool; 6] = [true, true, false, false, false, true];

/// Whether a degree of freedom, 1 to 6 or 10 (flow), is one of two-dimensional and axisymmetric analysis.
pub const fn in_plane(number: u8) -> bool {
    matches!(number, 1 | 2 | 6 | 10)
}

impl FrictionCriterion {
    /// P as a formula of the forces that are present ([`SPATIAL`], [`PLANE`]): `√(f1² + (m1/R)²)`.
    ///
    /// ```
    /// use pintle_kinematics::catalog::{ConnectionType, PLANE, SPATIAL};
    /// let translator = ConnectionType::named("TRANSLATOR", None).unwrap().friction.unwrap();
    /// let criterion = translator.criteria[0];
    /// assert_eq!(criterion.tangential_formula(&translator, SPATIAL), "|f1|");
    /// assert_eq!(criterion.contact_formula(&translator, SPATIAL), "|m1|/R_r + √(f2² + f3²) + (2/L) √(m2² + m3²)");
    /// assert_eq!(criterion.contact_formula(&translator, PLANE), "|f2| + (2/L) |m3|");
    /// ```
    pub fn tangential_formula(&self, friction: &Friction, present: [bool; 6]) -> String {
        if self.contact == Contact::Belt {
            return "|T2 − T1|".to_string();
        }
        let names: Vec<String> = self
            .traction
            .iter()
            .filter(|traction| present[traction.component])
            .map(|traction| match traction.radius {
                Some(radius) => {
                    format!(
                        "({}/{})",
                        FORCE[traction.component],
                        friction.symbol(Quantity::Parameter(radius))
                    )
                }
                None => FORCE[traction.component].to_string(),
            })
            .collect();
        norm(&names)
    }

    /// F_C as a formula of the forces that are present ([`SPATIAL`], [`PLANE`]). Terms divided by a parameter drop out where
    /// it is zero.
    pub fn contact_formula(&self, friction: &Friction, present: [bool; 6]) -> String {
        let Contact::Sum { arm, terms } = self.contact else {
            return "min(T1, T2)".to_string();
        };
        let mut sum = String::new();
        for term in terms {
            let Some(load) = term.load.formula(present) else { continue };
            let join = if sum.is_empty() { "" } else { " + " };
            sum.push_str(&format!("{join}{}", friction.term(&term.factor, &load)));
        }
        let arm = friction.product(arm);
        if arm.is_empty() { sum } else { format!("{arm} ({sum})") }
    }

    /// The limit of P where it is a law of its own, in place of μ F_N: that of a belt.
    ///
    /// ```
    /// use pintle_kinematics::catalog::{ConnectionType, SPATIAL};
    /// let belt = ConnectionType::named("SLIPRING", None).unwrap().friction.unwrap();
    /// assert_eq!(belt.criteria[0].contact_formula(&belt, SPATIAL), "min(T1, T2)");
    /// assert_eq!(belt.criteria[0].limit_formula(), Some("F_C (exp(μ α) − 1)"));
    /// ```
    pub const fn limit_formula(&self) -> Option<&'static str> {
        match self.contact {
            Contact::Belt => Some("F_C (exp(μ α) − 1)"),
            Contact::Sum { .. } => None,
        }
    }

    /// Whether the slip is an angle, so that P and F_N are moments.
    pub fn is_rotational(&self) -> bool {
        self.traction.iter().all(|traction| traction.component >= 3 && traction.radius.is_none())
    }
}

const fn required(symbol: &'static str) -> FrictionParameter {
    FrictionParameter { symbol, required: true }
}

const fn optional(symbol: &'static str) -> FrictionParameter {
    FrictionParameter { symbol, required: false }
}

const fn factor(number: i32, times: &'static [Quantity], over: Option<usize>) -> Factor {
    Factor { number, times, over }
}

const fn term(factor: Factor, load: Load) -> ContactTerm {
    ContactTerm { factor, load }
}

const fn sum(terms: &'static [ContactTerm]) -> Contact {
    Contact::Sum { arm: &[], terms }
}

const fn along(component: usize) -> Traction {
    Traction { component, radius: None }
}

const ONE: Factor = factor(1, &[], None);

// f1, f2, f3, m1, m2, m3 by their places.
const F1: Load = Load::Norm(&[0]);
const F23: Load = Load::Norm(&[1, 2]);
const M1: Load = Load::Norm(&[3]);
const M2: Load = Load::Norm(&[4]);
const M23: Load = Load::Norm(&[4, 5]);

pub(super) const SLIDE_PLANE: Friction = Friction {
    parameters: &[optional("F_C^int")],
    constants: &[],
    criteria: &[FrictionCriterion {
        traction: &[along(1), along(2)],
        contact: sum(&[term(ONE, F1)]),
        internal: Some(0),
        output: "CSFC",
    }],
    evidence: Evidence::S,
};

pub(super) const SLOT: Friction = Friction {
    parameters: &[optional("F_C^int")],
    constants: &[],
    criteria: &[FrictionCriterion {
        traction: &[along(0)],
        contact: sum(&[term(ONE, F23)]),
        internal: Some(0),
        output: "CSF1",
    }],
    evidence: Evidence::D,
};

pub(super) const TRANSLATOR: Friction = Friction {
    parameters: &[optional("R_r"), optional("L"), optional("F_C^int")],
    constants: &[],
    criteria: &[FrictionCriterion {
        traction: &[along(0)],
        contact: sum(&[
            term(factor(1, &[], Some(0)), M1),
            term(ONE, F23),
            term(factor(2, &[], Some(1)), M23),
        ]),
        internal: Some(2),
        output: "CSF1",
    }],
    evidence: Evidence::S,
};

pub(super) const CYLINDRICAL: Friction = Friction {
    parameters: &[required("R"), optional("L"), optional("F_C^int")],
    constants: &[],
    criteria: &[FrictionCriterion {
        traction: &[along(0), Traction { component: 3, radius: Some(0) }],
        contact: sum(&[term(ONE, F23), term(factor(2, &[], Some(1)), M23)]),
        internal: Some(2),
        output: "CSFC",
    }],
    evidence: Evidence::P,
};

pub(super) const HINGE: Friction = Friction {
    parameters: &[required("R_p"), optional("R_a"), optional("L_s"), optional("M_C^int")],
    constants: &[],
    criteria: &[FrictionCriterion {
        traction: &[along(3)],
        contact: sum(&[
            term(factor(1, &[Quantity::Parameter(1)], None), F1),
            term(factor(1, &[Quantity::Parameter(0)], None), F23),
            term(factor(2, &[Quantity::Parameter(0)], Some(2)), M23),
        ]),
        internal: Some(3),
        output: "CSM1",
    }],
    evidence: Evidence::P,
};

const PUCK: &[ContactTerm] = &[term(ONE, F1), term(factor(1, &[], Some(0)), M23)];

pub(super) const PLANAR: Friction = Friction {
    parameters: &[optional("R"), optional("F_C^int"), optional("M_C^int")],
    constants: &[FrictionConstant {
        symbol: "κ",
        value: 1.0,
        meaning: "arm of the contact force about e1a, in units of R: 1 for contact at the rim of the puck, 2/3 for uniform pressure",
    }],
    criteria: &[
        FrictionCriterion {
            traction: &[along(1), along(2)],
            contact: sum(PUCK),
            internal: Some(1),
            output: "CSFC",
        },
        FrictionCriterion {
            traction: &[along(3)],
            contact: Contact::Sum { arm: &[Quantity::Constant(0), Quantity::Parameter(0)], terms: PUCK },
            internal: Some(2),
            output: "CSM1",
        },
    ],
    evidence: Evidence::R,
};

const fn bearing(axis: CrossAxis) -> [ContactTerm; 3] {
    [
        term(factor(1, &[Quantity::Parameter(2)], None), Load::Along(axis)),
        term(factor(1, &[Quantity::Parameter(0)], None), Load::Across(axis)),
        term(factor(2, &[Quantity::Parameter(0)], Some(1)), M2),
    ]
}

pub(super) const UJOINT: Friction = Friction {
    parameters: &[
        required("R_p"),
        required("L_a"),
        optional("R_a"),
        optional("L_s"),
        optional("M_C1^int"),
        optional("M_C3^int"),
    ],
    constants: &[],
    criteria: &[
        FrictionCriterion {
            traction: &[along(3)],
            contact: sum(const { &bearing(CrossAxis::OfA) }),
            internal: Some(4),
            output: "CSM1",
        },
        FrictionCriterion {
            traction: &[along(5)],
            contact: sum(const { &bearing(CrossAxis::OfB) }),
            internal: Some(5),
            output: "CSM3",
        },
    ],
    evidence: Evidence::R,
};

pub(super) const SLIPRING: Friction = Friction {
    parameters: &[],
    constants: &[],
    criteria: &[FrictionCriterion {
        traction: &[along(1)],
        contact: Contact::Belt,
        internal: None,
        output: "CSF2",
    }],
    evidence: Evidence::P,
};
