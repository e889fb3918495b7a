//! In which order, unit and frame a routine answers, and how that is undone.

use pintle_audit::{Domain, Given, Quantity, Tangent};
use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::connector::{
    Components, Connector, Definition, Increment, NodalMatrix, NodalRow, Output, Request, State, Tally,
};
use pintle_kinematics::measure::{Measure, Unit};
use pintle_kinematics::mpc::{self, Body};
use pintle_kinematics::node::DOFS;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{
    Matrix, Vector, apply, apply_transposed, identity, product, transpose, transposed_product,
};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The columns of a row, as the protocol names them.
pub(crate) const COLUMNS: [&str; DOFS] = [
    "a.u1", "a.u2", "a.u3", "a.ur1", "a.ur2", "a.ur3", "a.flow", "b.u1", "b.u2", "b.u3", "b.ur1", "b.ur2",
    "b.ur3", "b.flow",
];

pintle_kinematics::named! {
    /// Which variation of a rotation the columns of a row belong to.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum Variation {
        /// δC = δθ^ C, along global axes.
        #[default]
        Spatial = "spatial",
        /// δC = C δΘ^, along the axes of the node.
        Body = "body",
        /// δφ of the total rotation vector, C = exp(φ^).
        TotalVector = "total-vector",
        /// The changes of three successive angles, C = R_i(α) R_j(β) R_k(γ) about turned axes: Cardan angles, axes 1, 2, 3.
        #[serde(rename = "angles-123")]
        Angles123 = "angles-123",
        /// Yaw, pitch and roll: axes 3, 2, 1.
        #[serde(rename = "angles-321")]
        Angles321 = "angles-321",
        /// Euler angles: axes 3, 1, 3; about axes 3, 2, 3 the changes are the same.
        #[serde(rename = "angles-313")]
        Angles313 = "angles-313",
    }
}

impl Variation {
    /// J of δθ = J δv, v being what this varies, at a rotation from the initial orientation.
    pub fn of_rotation(self, rotation: &Matrix<f64>) -> Matrix<f64> {
        self.jacobian(&Turned { triad: *rotation, rotation: *rotation, vector: so3::log(rotation) })
    }

    /// J of δθ = J δv, v being what this varies, at a rotation C.
    pub(crate) fn jacobian(self, own: &Turned) -> Matrix<f64> {
        let sequence = match self {
            Self::Spatial => return identity(),
            // δθ = C δΘ.
            Self::Body => return own.rotation,
            // δθ = J_l(φ) δφ.
            Self::TotalVector => return so3::left_jacobian(own.vector),
            Self::Angles123 => [0, 1, 2],
            Self::Angles321 => [2, 1, 0],
            Self::Angles313 => [2, 0, 2],
        };
        let [i, j, _] = sequence;
        let axis = |of: usize| [0, 1, 2].map(|x| f64::from(u8::from(x == of)));
        let [alpha, beta] = successive(&own.rotation, sequence);
        let first = so3::exp(axis(i).map(|x| x * alpha));
        let second = product(&first, &so3::exp(axis(j).map(|x| x * beta)));
        // δθ = e_i δα + R_i e_j δβ + R_i R_j e_k δγ.
        transpose(&[axis(i), apply(&first, axis(j)), apply(&second, axis(sequence[2]))])
    }
}

/// α and β of C = R_i(α) R_j(β) R_k(γ).
fn successive(c: &Matrix<f64>, [i, j, k]: [usize; 3]) -> [f64; 2] {
    if i == k {
        // The third axis, and the sign of the order i, j, third.
        let third = 3 - i - j;
        let sign = if (j + 3 - i) % 3 == 1 { 1.0 } else { -1.0 };
        return [c[j][i].atan2(-sign * c[third][i]), c[j][i].hypot(c[third][i]).atan2(c[i][i])];
    }
    let sign = if (j + 3 - i) % 3 == 1 { 1.0 } else { -1.0 };
    let [x, y] = [c[i][i], c[i][j]];
    [(-sign * c[j][k]).atan2(c[k][k]), (sign * c[i][k]).atan2(x.hypot(y))]
}

/// The variation of both nodes' rotations, or of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Variations {
    /// The same of both.
    Both(Variation),
    /// Of a and of b.
    Each([Variation; 2]),
}

impl Default for Variations {
    fn default() -> Self {
        Self::Both(Variation::default())
    }
}

impl Variations {
    /// Of a (0) or b (1).
    pub fn of(self, end: usize) -> Variation {
        match self {
            Self::Both(one) => one,
            Self::Each(each) => each[end.min(1)],
        }
    }
}

pintle_kinematics::named! {
    /// The unit of an angle.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
    pub enum Angle {
        /// Radians.
        #[default]
        #[serde(rename = "rad")]
        Radian = "rad",
        /// Degrees.
        #[serde(rename = "deg")]
        Degree = "deg",
        /// Whole turns.
        #[serde(rename = "turn")]
        Turn = "turn",
    }
}

impl Angle {
    /// One of these, in radians.
    pub const fn size(self) -> f64 {
        match self {
            Self::Radian => 1.0,
            Self::Degree => std::f64::consts::PI / 180.0,
            Self::Turn => std::f64::consts::TAU,
        }
    }
}

/// How rows are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Storage {
    /// A list of components, each a list of columns.
    #[default]
    Rows,
    /// A list of columns, each a list of components: transposed.
    Columns,
}

/// Along which axes a row differentiates by displacements.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Frame {
    /// Along global axes.
    #[default]
    Global,
    /// Along the axes of node a.
    A,
    /// Along the axes of node b.
    B,
    /// Those of each node along its own axes.
    Own,
}

impl Frame {
    /// All of them.
    pub(crate) const ALL: [Self; 4] = [Self::Global, Self::A, Self::B, Self::Own];

    /// The axes, as columns, along which the displacements of a (0) or b (1) are taken.
    pub(crate) fn axes(self, end: usize, turned: &[Turned; 2]) -> Matrix<f64> {
        match self {
            Self::Global => identity(),
            Self::A => turned[0].triad,
            Self::B => turned[1].triad,
            Self::Own => turned[end.min(1)].triad,
        }
    }
}

/// Along which axes the components of a vector are given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Axes {
    /// Of node a, as the type declares them.
    #[default]
    A,
    /// Global.
    Global,
    /// Of node b.
    B,
}

impl Axes {
    /// All of them.
    pub(crate) const ALL: [Self; 3] = [Self::A, Self::Global, Self::B];

    /// T of v_given = T v_a.
    pub(crate) fn out_of_a(self, turned: &[Turned; 2]) -> Matrix<f64> {
        match self {
            Self::A => identity(),
            Self::Global => turned[0].triad,
            Self::B => transposed_product(&turned[1].triad, &turned[0].triad),
        }
    }
}

/// Whether components 1 to 3 (`first` = 0) or 4 to 6 (`first` = 3) are those of one vector along the axes of a.
pub fn is_vector(connector: &Connector<f64>, first: usize) -> bool {
    let measures = [0, 1, 2].map(|i| connector.differentiated(first + i));
    let all = |of: fn(usize) -> Measure| (0..3).all(|i| measures[i] == Some(of(i + 1)));
    all(Measure::Position) || all(Measure::RotationVector) || all(Measure::Misalignment)
}

/// What a value of a component is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Positions {
    /// CU from the initial state; of what is constrained, its residual.
    #[default]
    Displacement,
    /// CP.
    Position,
    /// CCU from the constitutive reference.
    Constitutive,
}

impl Positions {
    /// All of them.
    pub(crate) const ALL: [Self; 3] = [Self::Displacement, Self::Position, Self::Constitutive];

    /// What a value of pintle is less than this one.
    pub(crate) fn offsets(self, definition: &Definition, connector: &Connector<f64>) -> Components<f64> {
        let output = match self {
            Self::Displacement => return [None; 6],
            Self::Position => Output::CP,
            Self::Constitutive => Output::CCU,
        };
        let rest = State { pair: definition.initial, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
        let asked = Request::new(&[output], [true; 6], 0);
        let branch = connector.initial_branch();
        let first = connector.evaluate(&rest, &Increment::none(), &branch, &asked, &mut Tally::default());
        if self == Self::Position { first.position } else { first.constitutive }
    }
}

/// How the routine reads a triad.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Triads {
    /// A list of e1, e2, e3.
    #[default]
    Axes,
    /// A matrix, row by row, whose columns are e1, e2, e3.
    Matrix,
}

/// The order of a quaternion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Quaternions {
    /// The scalar first.
    #[default]
    Wxyz,
    /// The scalar last.
    Xyzw,
}

/// What a quaternion and a rotation vector turn into what.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Sense {
    /// Initial axes into present ones.
    #[default]
    Forward,
    /// Present axes into initial ones.
    Inverse,
}

/// Whether angles go on through half a turn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Turns {
    /// They go on from the values before.
    #[default]
    Continued,
    /// They are principal, from −π to π: only states without whole turns are judged.
    Principal,
}

/// What the stiffness of an element of springs is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
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

/// On which side nodal forces are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Forces {
    /// The transposed rows times the forces of components.
    #[default]
    Residual,
    /// Those on the bodies: minus that.
    Body,
}

impl Forces {
    const fn sign(self) -> f64 {
        match self {
            Self::Residual => 1.0,
            Self::Body => -1.0,
        }
    }
}

/// The conventions of a routine. Those left out are pintle's own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Convention {
    /// The columns of a row, in the routine's order; those left out are zero.
    pub columns: Vec<String>,
    /// The components in the routine's order, without those that it has not; six, with null, where this is empty.
    pub rows: Vec<String>,
    /// The variation of rotations, of both nodes or of a and b.
    pub rotations: Variations,
    /// The axes of displacements.
    pub displacements: Frame,
    /// The axes of a vector whose components are given.
    pub axes: Axes,
    /// What the values are.
    pub positions: Positions,
    /// Components whose cosine is given as the angle by which the axes miss the right angle, asin of it.
    pub as_angle: Vec<String>,
    /// How triads are read.
    pub triads: Triads,
    /// How quaternions are read.
    pub quaternion: Quaternions,
    /// How rotations are read.
    pub sense: Sense,
    /// Whether angles go on through half a turn.
    pub turns: Turns,
    /// What the stiffness of an element of springs is.
    pub stiffness: Stiffness,
    /// On which side nodal forces are, and their geometric stiffness.
    pub forces: Forces,
    /// The unit of components that are angles, in values and rows.
    pub angles: Angle,
    /// The unit of the rotations by which rows differentiate.
    pub column_angles: Angle,
    /// The routine's unit of length, in units of the scene: 0.001 for a routine in mm of a scene in m.
    pub length: f64,
    /// The unit of components that are lengths, in units of `length`, where it is another.
    pub row_length: f64,
    /// The unit of the displacements by which rows differentiate, in units of `length`, where it is another.
    pub column_length: f64,
    /// The routine's component over pintle's: −1 where it has the opposite sign.
    pub factors: [f64; 6],
    /// How rows are stored.
    pub storage: Storage,
    /// Where states are drawn; lengths in the scene's unit, angles in rad.
    #[serde(skip_serializing)]
    pub domain: Domain,
}

impl Default for Convention {
    fn default() -> Self {
        Self {
            columns: COLUMNS.map(String::from).to_vec(),
            rows: Vec::new(),
            rotations: Variations::default(),
            displacements: Frame::default(),
            axes: Axes::default(),
            positions: Positions::default(),
            as_angle: Vec::new(),
            triads: Triads::default(),
            quaternion: Quaternions::default(),
            sense: Sense::default(),
            turns: Turns::default(),
            stiffness: Stiffness::default(),
            forces: Forces::default(),
            angles: Angle::default(),
            column_angles: Angle::default(),
            length: 1.0,
            row_length: 1.0,
            column_length: 1.0,
            factors: [1.0; 6],
            storage: Storage::default(),
            domain: Domain::default(),
        }
    }
}

impl Convention {
    /// The TOML document that declares them; what is pintle's own is left out.
    pub fn to_toml(&self) -> String {
        let fields = |of: &Self| serde_json::to_value(of).unwrap_or_default();
        let (all, own) = (fields(self), fields(&Self::default()));
        // Words, numbers and lists of them are written alike in JSON and in TOML.
        let written = |value: &Value| match value {
            Value::Array(list) => {
                format!("[{}]", list.iter().map(Value::to_string).collect::<Vec<_>>().join(", "))
            }
            one => one.to_string(),
        };
        let said = all.as_object().into_iter().flatten().filter(|(key, value)| own.get(*key) != Some(*value));
        said.map(|(key, value)| format!("{key} = {}\n", written(value))).collect()
    }

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
        self.places_among(&COLUMNS, &COMPONENT)
    }

    /// The same of a routine whose columns and rows have these names.
    ///
    /// # Errors
    /// In words, what is no convention.
    pub(crate) fn places_among(&self, known: &[&str], known_rows: &[&str]) -> Result<Vec<usize>, String> {
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
        let lengths =
            [("length", self.length), ("row_length", self.row_length), ("column_length", self.column_length)];
        if let Some((name, x)) = lengths.into_iter().find(|(_, x)| !(*x > 0.0 && x.is_finite())) {
            return Err(format!("convention.{name} is {x}, not a positive number"));
        }
        for (list, names) in [("rows", &self.rows), ("as_angle", &self.as_angle)] {
            for (n, name) in names.iter().enumerate() {
                if !known_rows.contains(&name.as_str()) {
                    let known = known_rows.join(", ");
                    return Err(format!("convention.{list} names {name:?}; the components are {known}"));
                }
                if names[..n].contains(name) {
                    return Err(format!("convention.{list} names {name} twice"));
                }
            }
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
            Some(Unit::Length) => self.length * self.row_length,
            _ if self.is_as_angle(k) => self.angles.size(),
            _ => 1.0,
        };
        of_unit / self.factors[k]
    }

    /// Whether what it says of rows, values and what is sent has a meaning for equations of constraints.
    pub(crate) fn is_of_equations(&self) -> bool {
        let own = Self::default();
        self.as_angle.is_empty() && (self.axes, self.positions) == (own.axes, own.positions)
    }

    /// Whether a component that is a cosine is given as an angle.
    pub(crate) fn is_as_angle(&self, k: usize) -> bool {
        self.as_angle.iter().any(|name| name == COMPONENT[k])
    }

    /// Of each component that is given as an angle, the slope of its cosine by that angle: √(1 − c²).
    fn slopes(&self, connector: &Connector<f64>, state: &State<f64>) -> Components<f64> {
        if self.as_angle.is_empty() {
            return [None; 6];
        }
        let asked = Request::new(&[Output::CU, Output::RES], [true; 6], 0);
        let branch = connector.initial_branch();
        let now = connector.evaluate(state, &Increment::none(), &branch, &asked, &mut Tally::default());
        std::array::from_fn(|k| {
            let cosine = now.residual[k].or(now.displacement[k]).filter(|_| self.is_as_angle(k))?;
            Some((1.0 - cosine * cosine).max(0.0).sqrt())
        })
    }

    /// The component of each line of the routine's values and rows.
    pub(crate) fn lines(&self) -> Vec<usize> {
        self.lines_among(&COMPONENT)
    }

    /// The same of rows with these names.
    pub(crate) fn lines_among(&self, names: &[&str]) -> Vec<usize> {
        if self.rows.is_empty() {
            return (0..names.len()).collect();
        }
        let place = |name: &String| names.iter().position(|known| known == name);
        self.rows.iter().filter_map(place).collect()
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
        let both = match self.rotations {
            Variations::Both(both) => Some(both),
            Variations::Each([a, b]) => (a == b).then_some(a),
        };
        let is_plain = matches!(both, Some(Variation::Spatial | Variation::Body));
        if !is_plain && (second || changes) {
            return Err(
                "second derivatives and stiffness are read by spatial or body variations of both nodes alone"
                    .into(),
            );
        }
        let is_resolved = self.axes != Axes::A || !self.as_angle.is_empty();
        if is_resolved && (second || changes || offers.contains(&Quantity::Acceleration)) {
            return Err("second derivatives, stiffness and accelerations are read along the axes of a, of cosines themselves".into());
        }
        let turns = both == Some(Variation::Body) || self.displacements != Frame::Global;
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
            let column =
                if is_rotation { self.column_angles.size() } else { self.length * self.column_length };
            row[*place] = entry / column;
        }
        let block = |row: &NodalRow<f64>, at: usize| [row[at], row[at + 1], row[at + 2]];
        for (end, own) in turned.iter().enumerate() {
            if self.displacements != Frame::Global {
                // δx = T δx_local.
                let global = apply(&self.displacements.axes(end, turned), block(&row, 7 * end));
                row[7 * end..7 * end + 3].copy_from_slice(&global);
            }
            let at = 7 * end + 3;
            let given = block(&row, at);
            let spatial = match self.rotations.of(end) {
                Variation::Spatial => continue,
                Variation::Body => apply(&own.rotation, given),
                Variation::TotalVector => apply_transposed(&so3::inverse_left_jacobian(own.vector), given),
                // Jᵀ times the row along spatial rotations is what is given.
                of_angles => solve(&transpose(&of_angles.jacobian(own)), given),
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

/// Vectors with their components along the axes of a, in place of those along others: what `sum` makes of component i.
fn along_a<T: Copy>(
    mut all: Components<T>,
    blocks: [bool; 2],
    sum: impl Fn(usize, [T; 3]) -> T,
) -> Components<T> {
    for (first, is_vector) in [0, 3].into_iter().zip(blocks) {
        if let (true, [Some(x), Some(y), Some(z)]) = (is_vector, [0, 1, 2].map(|i| all[first + i])) {
            for i in 0..3 {
                all[first + i] = Some(sum(i, [x, y, z]));
            }
        }
    }
    all
}

/// x of M x = y by Cramer's rule: no number where M is singular.
fn solve(m: &Matrix<f64>, y: Vector<f64>) -> Vector<f64> {
    let det = |m: &Matrix<f64>| {
        let minor = |i: usize, j: usize| m[1][i] * m[2][j] - m[1][j] * m[2][i];
        m[0][0] * minor(1, 2) - m[0][1] * minor(0, 2) + m[0][2] * minor(0, 1)
    };
    let whole = det(m);
    [0, 1, 2].map(|column| {
        let replaced = [0, 1, 2].map(|i| [0, 1, 2].map(|j| if j == column { y[i] } else { m[i][j] }));
        det(&replaced) / whole
    })
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

    /// Of S and M at a state of a constraint, whose axes are initially those of the frame.
    pub(crate) fn of_bodies(state: &mpc::State<f64>) -> [Self; 2] {
        [&state.slave, &state.master].map(|Body { rotation, .. }| Self {
            triad: *rotation,
            rotation: *rotation,
            vector: so3::log(rotation),
        })
    }
}

/// What a routine answered, in its own conventions.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Own {
    /// Of each quantity that was wanted, the numbers of each component; matrices row by row.
    pub(crate) given: Vec<(Quantity, Vec<Option<Vec<f64>>>)>,
    /// What it keeps for the next state.
    pub(crate) memory: Option<Value>,
}

impl Own {
    /// Lines in the order of pintle's components, from that of the routine.
    pub(crate) fn put_in_order(&mut self, lines: &[usize]) {
        let is_whole = |of: &Quantity| matches!(of, Quantity::ElementForces | Quantity::ElementStiffness);
        for (_, of) in self.given.iter_mut().filter(|(quantity, _)| !is_whole(quantity)) {
            let mut ordered = vec![None; COMPONENT.len()];
            for (line, numbers) in lines.iter().zip(of.drain(..)) {
                ordered[*line] = numbers;
            }
            *of = ordered;
        }
    }

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
        let offsets = convention.positions.offsets(definition, connector);
        let slopes = convention.slopes(connector, state);
        let axes = convention.axes.out_of_a(&turned);
        let blocks = [0, 3].map(|first| convention.axes != Axes::A && is_vector(connector, first));
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
            let scalars = |is_value: bool| {
                let mut all: Components<f64> =
                    std::array::from_fn(|k| Some(of[k].as_ref()?.first()? * unit(k)));
                all = along_a(all, blocks, |i, of| (0..3).map(|m| axes[m][i] * of[m]).sum());
                std::array::from_fn(|k| {
                    let x = all[k]? - offsets[k].filter(|_| is_value).unwrap_or(0.0);
                    Some(match slopes[k] {
                        Some(_) if is_value => x.sin(),
                        Some(slope) => x * slope,
                        None => x,
                    })
                })
            };
            let rows = || -> Components<NodalRow<f64>> {
                let all =
                    std::array::from_fn(|k| Some(convention.row(of[k].as_ref()?, places, unit(k), &turned)));
                let sum = |i: usize, of: [NodalRow<f64>; 3]| {
                    std::array::from_fn(|j| (0..3).map(|m| axes[m][i] * of[m][j]).sum())
                };
                let all: Components<NodalRow<f64>> = along_a(all, blocks, sum);
                std::array::from_fn(|k| Some(all[k]?.map(|x| x * slopes[k].unwrap_or(1.0))))
            };
            let matrices = || {
                std::array::from_fn(|k| Some(convention.matrix(of[k].as_ref()?, places, unit(k), &turned)))
            };
            given = match quantity {
                Quantity::Value => given.values(scalars(true)),
                Quantity::Rate => given.rates(scalars(false)),
                Quantity::Acceleration => given.accelerations(scalars(false)),
                Quantity::FirstDerivatives => given.rows(rows()),
                Quantity::NodalForces => given
                    .nodal_forces(rows().map(|row| row.map(|row| row.map(|x| x * convention.forces.sign())))),
                Quantity::SecondDerivatives => given.second_derivatives(matrices()),
                Quantity::GeometricStiffness => {
                    let mut all: Components<NodalMatrix<f64>> = matrices();
                    all.iter_mut().flatten().for_each(|matrix| {
                        matrix.iter_mut().flatten().for_each(|x| *x *= convention.forces.sign());
                    });
                    given.geometric_stiffness(all)
                }
                _ => given,
            };
        }
        given
    }
}
