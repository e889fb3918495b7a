//! In which order, unit and frame a routine answers, and how that is undone.

use pintle_audit::{Given, Quantity, Tangent};
use pintle_kinematics::connector::{Connector, Definition, NodalMatrix, NodalRow, State};
use pintle_kinematics::measure::Unit;
use pintle_kinematics::node::DOFS;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Matrix, Vector, apply, apply_transposed, product, transpose};
use serde::Deserialize;

/// The columns of a row, as the protocol names them.
pub(crate) const COLUMNS: [&str; DOFS] = [
    "a.u1", "a.u2", "a.u3", "a.ur1", "a.ur2", "a.ur3", "a.flow", "b.u1", "b.u2", "b.u3", "b.ur1", "b.ur2",
    "b.ur3", "b.flow",
];

/// Which variation of a rotation the columns of a row belong to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Variation {
    /// δC = δθ^ C, along global axes.
    #[default]
    Spatial,
    /// δC = C δΘ^, along the axes of the node.
    Body,
    /// δφ of the total rotation vector, C = exp(φ^).
    TotalVector,
}

/// The unit of an angle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum Angle {
    /// Radians.
    #[default]
    #[serde(rename = "rad")]
    Radian,
    /// Degrees.
    #[serde(rename = "deg")]
    Degree,
}

impl Angle {
    /// One of these, in radians.
    fn size(self) -> f64 {
        match self {
            Self::Radian => 1.0,
            Self::Degree => std::f64::consts::PI / 180.0,
        }
    }
}

/// How rows are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Storage {
    /// A list of components, each a list of columns.
    #[default]
    Rows,
    /// A list of columns, each a list of components: transposed.
    Columns,
}

/// Along which axes a row differentiates by displacements.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Frame {
    /// Along global axes.
    #[default]
    Global,
    /// Along the axes of node a.
    A,
    /// Along the axes of node b.
    B,
}

/// Whether angles go on through half a turn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Turns {
    /// They go on from the values before.
    #[default]
    Continued,
    /// They are principal, from −π to π: only states without whole turns are judged.
    Principal,
}

/// What the stiffness of an element of springs is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Stiffness {
    /// The derivatives of its forces along spatial rotations.
    #[default]
    Forces,
    /// The symmetric second derivatives of its energy along exp(δθ^) C.
    Energy,
}

impl Stiffness {
    pub(crate) const fn tangent(self) -> Tangent {
        match self {
            Self::Forces => Tangent::OfForces,
            Self::Energy => Tangent::OfEnergy,
        }
    }
}

/// The conventions of a routine. Those left out are pintle's own.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Convention {
    /// The columns of a row, in the routine's order; those left out are zero.
    pub columns: Vec<String>,
    /// The variation of rotations.
    pub rotations: Variation,
    /// The axes of displacements.
    pub displacements: Frame,
    /// Whether angles go on through half a turn.
    pub turns: Turns,
    /// What the stiffness of an element of springs is.
    pub stiffness: Stiffness,
    /// The unit of components that are angles, in values and rows.
    pub angles: Angle,
    /// The unit of the rotations by which rows differentiate.
    pub column_angles: Angle,
    /// The routine's unit of length, in units of the scene: 0.001 for a routine in mm of a scene in m.
    pub length: f64,
    /// The routine's component over pintle's: −1 where it has the opposite sign.
    pub factors: [f64; 6],
    /// How rows are stored.
    pub storage: Storage,
}

impl Default for Convention {
    fn default() -> Self {
        Self {
            columns: COLUMNS.map(String::from).to_vec(),
            rotations: Variation::default(),
            displacements: Frame::default(),
            turns: Turns::default(),
            stiffness: Stiffness::default(),
            angles: Angle::default(),
            column_angles: Angle::default(),
            length: 1.0,
            factors: [1.0; 6],
            storage: Storage::default(),
        }
    }
}

impl Convention {
    /// Those that a TOML document declares.
    ///
    /// # Errors
    /// In words, what is no convention, and where.
    pub fn from_toml(text: &str) -> Result<Self, String> {
        toml::from_str(text).map_err(|error| error.to_string())
    }

    /// The place of each of the routine's columns among pintle's.
    ///
    /// # Errors
    /// In words, what is no convention.
    pub(crate) fn places(&self) -> Result<Vec<usize>, String> {
        self.places_among(&COLUMNS)
    }

    /// The same of a routine whose columns have these names.
    ///
    /// # Errors
    /// In words, what is no convention.
    pub(crate) fn places_among(&self, known: &[&str]) -> Result<Vec<usize>, String> {
        let mut places = Vec::new();
        for name in &self.columns {
            let place = known.iter().position(|known| known == name);
            match place {
                None => {
                    return Err(format!(
                        "convention.columns names {name:?}; the columns are {}",
                        known.join(", ")
                    ));
                }
                Some(place) if places.contains(&place) => {
                    return Err(format!("convention.columns names {name} twice"));
                }
                Some(place) => places.push(place),
            }
        }
        if !(self.length > 0.0 && self.length.is_finite()) {
            return Err(format!("convention.length is {}, not a positive number", self.length));
        }
        if let Some(k) = (0..6).find(|k| !(self.factors[*k] != 0.0 && self.factors[*k].is_finite())) {
            return Err(format!(
                "convention.factors[{k}] is {}, not a finite number other than 0",
                self.factors[k]
            ));
        }
        Ok(places)
    }

    /// The unit of an angle in values, in radians.
    pub(crate) fn angle(&self) -> f64 {
        self.angles.size()
    }

    /// The unit of the rotations by which rows differentiate, in radians.
    pub(crate) fn column_angle(&self) -> f64 {
        self.column_angles.size()
    }

    /// A component of the routine, by the unit of pintle's: what a number of it is to be multiplied with.
    pub(crate) fn unit(&self, k: usize, connector: &Connector<f64>) -> f64 {
        let of_unit = match connector.differentiated(k).map(|measure| measure.unit()) {
            Some(Unit::Angle) => self.angles.size(),
            Some(Unit::Length) => self.length,
            _ => 1.0,
        };
        of_unit / self.factors[k]
    }

    /// What a convention cannot say of the quantities offered.
    ///
    /// # Errors
    /// In words, which of them have no rule.
    pub(crate) fn covers(&self, offers: &[Quantity]) -> Result<(), String> {
        let second = offers.contains(&Quantity::SecondDerivatives);
        let of_element = offers.contains(&Quantity::ElementStiffness);
        let changes = offers.contains(&Quantity::GeometricStiffness)
            || of_element && self.stiffness == Stiffness::Forces;
        let second = second || of_element;
        if self.rotations == Variation::TotalVector && (second || changes) {
            return Err("second derivatives and stiffness are read by spatial or body variations, not by total-vector".into());
        }
        let turns = self.rotations == Variation::Body || self.displacements != Frame::Global;
        if changes && turns {
            return Err(
                "geometric_stiffness is read by spatial variations and global displacements alone".into()
            );
        }
        if second && self.displacements != Frame::Global {
            return Err("second derivatives and stiffness are read by global displacements alone".into());
        }
        Ok(())
    }

    /// Derivatives by the routine's columns as derivatives by pintle's.
    pub(crate) fn line(&self, of_routine: &[f64], places: &[usize], turned: &[Turned; 2]) -> NodalRow<f64> {
        let mut row = [0.0; DOFS];
        for (entry, place) in of_routine.iter().zip(places) {
            let is_rotation = matches!(place % 7, 3..=5);
            let column = if is_rotation { self.column_angles.size() } else { self.length };
            row[*place] = entry / column;
        }
        let block = |row: &NodalRow<f64>, at: usize| [row[at], row[at + 1], row[at + 2]];
        for (end, own) in turned.iter().enumerate() {
            let axes = match self.displacements {
                Frame::Global => None,
                Frame::A => Some(&turned[0].triad),
                Frame::B => Some(&turned[1].triad),
            };
            if let Some(axes) = axes {
                // δx = T δx_local.
                let global = apply(axes, block(&row, 7 * end));
                row[7 * end..7 * end + 3].copy_from_slice(&global);
            }
            let at = 7 * end + 3;
            let spatial = match self.rotations {
                Variation::Spatial => continue,
                // δΘ = Cᵀ δθ.
                Variation::Body => apply(&own.rotation, block(&row, at)),
                // δφ = J_l(φ)⁻¹ δθ.
                Variation::TotalVector => {
                    apply_transposed(&so3::inverse_left_jacobian(own.vector), block(&row, at))
                }
            };
            row[at..at + 3].copy_from_slice(&spatial);
        }
        row
    }

    /// A row of the routine in pintle's conventions: columns in place, by unit columns, for spatial variations.
    fn row(&self, of_routine: &[f64], places: &[usize], unit: f64, turned: &[Turned; 2]) -> NodalRow<f64> {
        self.line(of_routine, places, turned).map(|x| x * unit)
    }

    /// A matrix of second derivatives, row by row, in pintle's conventions.
    fn matrix(
        &self,
        of_routine: &[f64],
        places: &[usize],
        unit: f64,
        turned: &[Turned; 2],
    ) -> NodalMatrix<f64> {
        let lines: Vec<NodalRow<f64>> =
            of_routine.chunks(places.len().max(1)).map(|line| self.line(line, places, turned)).collect();
        let mut matrix = Box::new([[0.0; DOFS]; DOFS]);
        for j in 0..DOFS {
            let column: Vec<f64> = lines.iter().map(|line| line[j]).collect();
            for (entry, x) in matrix.iter_mut().zip(self.row(&column, places, unit, turned)) {
                entry[j] = x;
            }
        }
        matrix
    }
}

/// How a node is turned from its initial orientation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turned {
    pub(crate) triad: Matrix<f64>,
    pub(crate) rotation: Matrix<f64>,
    /// The principal rotation vector.
    pub(crate) vector: Vector<f64>,
}

impl Turned {
    /// Of both nodes at a state: C = A A₀ᵀ.
    pub(crate) fn of(definition: &Definition, state: &State<f64>) -> [Self; 2] {
        let initial = &definition.initial;
        [(&state.pair.a, &initial.a), (&state.pair.b, &initial.b)].map(|(now, first)| {
            let rotation = product(&now.triad, &transpose(&first.triad));
            Self { triad: now.triad, rotation, vector: so3::log(&rotation) }
        })
    }
}

/// What a routine answered, in its own conventions.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Own {
    /// Of each quantity that was wanted, the numbers of each component; matrices row by row.
    pub(crate) given: Vec<(Quantity, Vec<Option<Vec<f64>>>)>,
    /// What it keeps for the next state.
    pub(crate) memory: Option<serde_json::Value>,
}

impl Own {
    /// In pintle's conventions.
    pub(crate) fn read(
        &self,
        convention: &Convention,
        places: &[usize],
        (definition, connector): (&Definition, &Connector<f64>),
        state: &State<f64>,
    ) -> Given {
        let turned = Turned::of(definition, state);
        let unit = |k: usize| convention.unit(k, connector);
        let mut given = Given::default();
        // E in the routine's unit of length is E over that unit.
        let energy = convention.length;
        for (quantity, of) in &self.given {
            match (quantity, &of[0]) {
                (Quantity::ElementForces, Some(of)) => {
                    given = given.element_forces(convention.row(of, places, energy, &turned));
                    continue;
                }
                (Quantity::ElementStiffness, Some(of)) => {
                    given = given.element_stiffness(convention.matrix(of, places, energy, &turned));
                    continue;
                }
                _ => {}
            }
            let scalars = || std::array::from_fn(|k| Some(of[k].as_ref()?.first()? * unit(k)));
            let rows =
                || std::array::from_fn(|k| Some(convention.row(of[k].as_ref()?, places, unit(k), &turned)));
            let matrices = || {
                std::array::from_fn(|k| Some(convention.matrix(of[k].as_ref()?, places, unit(k), &turned)))
            };
            given = match quantity {
                Quantity::Value => given.values(scalars()),
                Quantity::Rate => given.rates(scalars()),
                Quantity::Acceleration => given.accelerations(scalars()),
                Quantity::FirstDerivatives => given.rows(rows()),
                Quantity::NodalForces => given.nodal_forces(rows()),
                Quantity::SecondDerivatives => given.second_derivatives(matrices()),
                Quantity::GeometricStiffness => given.geometric_stiffness(matrices()),
                _ => given,
            };
        }
        given
    }
}
