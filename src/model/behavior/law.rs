//! Forces over motions: what elasticity and damping have in common.

use crate::behavior::table::{Kink, Table, Variable};
use crate::behavior::{Conditions, Forces, Motion, Unknown};
use pintle_kinematics::connector::Mask;
use pintle_kinematics::scalar::{Real, Scalar};
use pintle_scene as scene;
use pintle_scene::{Basis, Code, Diagnostic, Extrapolation, Independent, Span, TableOptions, TableRow};

/// What drives a law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(super) enum Driver {
    /// The constitutive displacement.
    Displacement,
    /// The velocity.
    Velocity,
}

impl Driver {
    fn of<S: Scalar>(self, motion: &Motion<S>) -> &[S; 6] {
        match self {
            Self::Displacement => &motion.constitutive,
            Self::Velocity => &motion.velocity,
        }
    }

    const fn names(self) -> [&'static str; 2] {
        match self {
            Self::Displacement => ["the stiffness", "the displacement"],
            Self::Velocity => ["the damping coefficient", "the velocity"],
        }
    }
}

/// What a column of a nonlinear table holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
enum Axis {
    /// The driver of the component itself.
    Own,
    /// The position of a component (0-based).
    Position(usize),
    /// The constitutive displacement of a component (0-based).
    Constitutive(usize),
}

/// One law.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
enum Kind {
    /// F_k = c x_k; column: frequency.
    Linear { component: usize, table: Table },
    /// F_i = Σ c_ij x_j.
    Coupled { table: Table, symmetric: bool },
    /// F_k = f(axes).
    Nonlinear { component: usize, table: Table, axes: Vec<Axis> },
    /// F_k is whatever keeps x_k at zero.
    Rigid { components: Mask },
}

/// A law of elasticity or damping, for one connection type.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "Written")]
pub(super) struct Law {
    kind: Kind,
    driver: Driver,
    available: Mask,
}

/// A law as a file has it, whose matrix may lack entries.
#[derive(serde::Deserialize)]
struct Written {
    kind: Kind,
    driver: Driver,
    available: Mask,
}

impl TryFrom<Written> for Law {
    type Error = String;

    fn try_from(Written { kind, driver, available }: Written) -> Result<Self, String> {
        if let Kind::Coupled { table, symmetric } = &kind {
            let (found, wanted) = (table.outputs(), entries(!symmetric));
            if found != wanted {
                return Err(format!("a coupled law has {found} entries, not {wanted}"));
            }
        }
        Ok(Self { kind, driver, available })
    }
}

/// How many entries a coupled law has.
const fn entries(is_unsymmetric: bool) -> usize {
    if is_unsymmetric { 36 } else { 21 }
}

/// A kink of a law: where the slope of a component's force jumps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceKink<R> {
    /// The component of the force (0-based).
    pub component: usize,
    /// Where, with both slopes.
    pub kink: Kink<R>,
}

impl Law {
    /// The law that a deck gives, for a type with these available components. Entries of coupled laws for other components are
    /// ignored, as documented; a law of one other component, or one that depends on another, is refused.
    pub(super) fn new(
        law: &scene::Law,
        driver: Driver,
        available: Mask,
        options: [&TableOptions; 2],
        span: Span,
    ) -> Result<Self, Diagnostic> {
        let extrapolation = extrapolation(options);
        let [coefficient, variable] = driver.names();
        let own = |component: u8| component_of(component, available, span);
        let kind = match law {
            scene::Law::Linear { component, rows } => {
                let table = Table::new(rows, 1, &["the frequency"], extrapolation)?;
                Kind::Linear { component: own(*component)?, table }
            }
            scene::Law::Coupled { unsymmetric, rows, .. } => {
                let outputs = entries(*unsymmetric);
                let rows = available_entries(rows, outputs, *unsymmetric, available, coefficient)?;
                let table = Table::new(&rows, outputs, &["the frequency"], extrapolation)?;
                Kind::Coupled { table, symmetric: !unsymmetric }
            }
            scene::Law::Nonlinear { component, independent, rows } => {
                let axes = axes(driver, independent.as_ref(), available, span)?;
                let names: Vec<String> = axes.iter().map(|axis| axis.name(variable)).collect();
                let names: Vec<&str> = names.iter().map(String::as_str).collect();
                let table = Table::new(rows, 1, &names, extrapolation)?;
                Kind::Nonlinear { component: own(*component)?, table, axes }
            }
            scene::Law::Rigid { components } if components.is_empty() => {
                Kind::Rigid { components: available }
            }
            scene::Law::Rigid { components } => {
                let mut mask = [false; 6];
                for component in components {
                    mask[own(*component)?] = true;
                }
                Kind::Rigid { components: mask }
            }
        };
        Ok(Self { kind, driver, available })
    }

    /// The components to which the law gives forces, each on its own (0-based); for a coupled law all available ones.
    pub(super) fn components(&self) -> Mask {
        match &self.kind {
            Kind::Linear { component, .. } | Kind::Nonlinear { component, .. } => {
                [0, 1, 2, 3, 4, 5].map(|k| k == *component)
            }
            Kind::Coupled { .. } => self.available,
            Kind::Rigid { components } => *components,
        }
    }

    /// Whether the law is rigid: its components do not move, and what that takes is not known from motions.
    pub(super) const fn is_rigid(&self) -> bool {
        matches!(self.kind, Kind::Rigid { .. })
    }

    /// What is missing to evaluate the law.
    fn unknown(&self, conditions: &Conditions) -> Option<Unknown> {
        let table = match &self.kind {
            Kind::Linear { table, .. } | Kind::Coupled { table, .. } | Kind::Nonlinear { table, .. } => table,
            Kind::Rigid { .. } => return Some(Unknown::Rigid),
        };
        table.depends_on().find_map(|variable| conditions.lacks(variable))
    }

    /// The forces of the law, added to those of others. A sum of which a part is not known is not known.
    pub(super) fn add<S: Scalar>(&self, motion: &Motion<S>, conditions: &Conditions, forces: &mut Forces<S>) {
        let unknown = self.unknown(conditions);
        let mut put = |k: usize, force: S| {
            forces.value[k] = Some(forces.value[k].map_or(force, |others| others + force));
        };
        if unknown.is_none() {
            let x = self.driver.of(motion);
            match &self.kind {
                Kind::Linear { component, table } => {
                    put(*component, x[*component] * table.evaluate(0, |v| conditions.of(v)));
                }
                Kind::Coupled { table, symmetric } => {
                    for i in (0..6).filter(|i| self.available[*i]) {
                        let mut sum = S::zero();
                        for j in (0..6).filter(|j| self.available[*j]) {
                            sum = sum + x[j] * table.evaluate(entry(!symmetric, i, j), |v| conditions.of(v));
                        }
                        put(i, sum);
                    }
                }
                Kind::Nonlinear { component, table, axes } => {
                    let along = |v| argument(v, axes, *component, self.driver, motion, conditions);
                    put(*component, table.evaluate(0, along));
                }
                Kind::Rigid { .. } => {}
            }
        }
        for k in (0..6).filter(|k| self.components()[*k]) {
            forces.unknown[k] = forces.unknown[k].or(unknown);
            if forces.unknown[k].is_some() {
                forces.value[k] = None;
            }
        }
    }

    /// What the rounding of each slope of the forces is measured by, added to what other laws have: by displacements, then by velocities.
    pub(super) fn add_slope_scales(
        &self,
        motion: &Motion<f64>,
        conditions: &Conditions,
        [displacement, velocity]: &mut [[[f64; 6]; 6]; 2],
    ) {
        if self.unknown(conditions).is_some() {
            return;
        }
        let own = if self.driver == Driver::Velocity { &mut *velocity } else { &mut *displacement };
        match &self.kind {
            Kind::Linear { component, table } => {
                own[*component][*component] += table.value_scale(0, |v| conditions.of(v));
            }
            Kind::Coupled { table, symmetric } => {
                for i in (0..6).filter(|i| self.available[*i]) {
                    for j in (0..6).filter(|j| self.available[*j]) {
                        own[i][j] += table.value_scale(entry(!symmetric, i, j), |v| conditions.of(v));
                    }
                }
            }
            Kind::Nonlinear { component, table, axes } => {
                let along = |v| argument(v, axes, *component, self.driver, motion, conditions);
                let of = |column: usize| table.slope_scale(0, along, Variable::Column(column));
                for (column, axis) in axes.iter().enumerate() {
                    match axis {
                        Axis::Own if self.driver == Driver::Velocity => {
                            velocity[*component][*component] += of(column);
                        }
                        Axis::Own => displacement[*component][*component] += of(column),
                        Axis::Position(k) | Axis::Constitutive(k) => {
                            displacement[*component][*k] += of(column)
                        }
                    }
                }
            }
            Kind::Rigid { .. } => {}
        }
    }

    /// The component whose force is a table over its own displacement or velocity alone, with the rows where its slope jumps.
    fn rows(&self) -> Option<(usize, Vec<f64>)> {
        match &self.kind {
            Kind::Nonlinear { component, table, axes } if axes.as_slice() == [Axis::Own] => {
                Some((*component, table.rows(Variable::Column(0))))
            }
            _ => None,
        }
    }

    /// The kinks at which the motion lies.
    pub(super) fn kinks<R: Real>(&self, motion: &Motion<R>, conditions: &Conditions) -> Vec<ForceKink<R>> {
        let Kind::Nonlinear { component, table, axes } = &self.kind else { return Vec::new() };
        if self.unknown(conditions).is_some() {
            return Vec::new();
        }
        let along = |v| argument(v, axes, *component, self.driver, motion, conditions);
        let kinks = table.kinks(0, along).into_iter();
        let moves = |kink: &Kink<R>| matches!(kink.variable, Variable::Column(_));
        kinks.filter(moves).map(|kink| ForceKink { component: *component, kink }).collect()
    }

    /// The work that the law has taken up from x = 0, where it is a function of the motion: W with ∂W/∂x_k = F_k. It is `None` for
    /// unsymmetric matrices, for forces that depend on other components, and where a condition is not known.
    pub(super) fn potential<S: Scalar>(&self, motion: &Motion<S>, conditions: &Conditions) -> Option<S> {
        if self.unknown(conditions).is_some_and(|unknown| unknown != Unknown::Rigid) {
            return None;
        }
        let x = self.driver.of(motion);
        let half = S::Real::ratio(1, 2);
        match &self.kind {
            Kind::Linear { component: k, table } => {
                Some((x[*k] * x[*k] * table.evaluate(0, |v| conditions.of(v))).scale(half))
            }
            Kind::Coupled { symmetric: false, .. } => None,
            Kind::Coupled { .. } => {
                let mut forces = Forces::none();
                self.add(motion, conditions, &mut forces);
                let mut sum = S::zero();
                for (x, force) in x.iter().zip(forces.value) {
                    sum = sum + *x * force.unwrap_or(S::zero());
                }
                Some(sum.scale(half))
            }
            Kind::Nonlinear { component, table, axes } => match axes.as_slice() {
                [Axis::Own] => Some(table.integral(0, x[*component], |v| conditions.of(v))),
                _ => None,
            },
            Kind::Rigid { .. } => Some(S::zero()),
        }
    }
}

impl Axis {
    fn name(self, own: &str) -> String {
        match self {
            Self::Own => own.to_string(),
            Self::Position(k) => format!("the position of component {}", k + 1),
            Self::Constitutive(k) => format!("the constitutive motion of component {}", k + 1),
        }
    }
}

/// The value of a variable of a nonlinear table.
fn argument<S: Scalar>(
    variable: Variable,
    axes: &[Axis],
    component: usize,
    driver: Driver,
    motion: &Motion<S>,
    conditions: &Conditions,
) -> S {
    match variable {
        Variable::Column(column) => match axes.get(column) {
            Some(Axis::Own) => driver.of(motion)[component],
            Some(Axis::Position(k)) => motion.position[*k],
            Some(Axis::Constitutive(k)) => motion.constitutive[*k],
            None => S::zero(),
        },
        other => conditions.of(other),
    }
}

/// The columns of a nonlinear table. A damping force depends on its own velocity first, and on positions or motions besides; an
/// elastic force on its own displacement, or on what is listed.
fn axes(
    driver: Driver,
    independent: Option<&Independent>,
    available: Mask,
    span: Span,
) -> Result<Vec<Axis>, Diagnostic> {
    let Some(independent) = independent else { return Ok(vec![Axis::Own]) };
    let mut axes = if driver == Driver::Velocity { vec![Axis::Own] } else { Vec::new() };
    for component in &independent.components {
        let k = component_of(*component, available, span)?;
        axes.push(match independent.basis {
            Basis::Position => Axis::Position(k),
            Basis::ConstitutiveMotion => Axis::Constitutive(k),
        });
    }
    Ok(axes)
}

/// A component (1-based) that must be available.
pub(super) fn component_of(component: u8, available: Mask, span: Span) -> Result<usize, Diagnostic> {
    let k = usize::from(component).wrapping_sub(1);
    if available.get(k) == Some(&true) {
        return Ok(k);
    }
    let names: Vec<String> = (0..6)
        .filter(|k| available[*k])
        .map(|k| format!("{} ({})", k + 1, pintle_kinematics::catalog::COMPONENT[k]))
        .collect();
    let remedy = if names.is_empty() {
        "the connection type has no available component".to_string()
    } else {
        format!("use one of its available components: {}", names.join(", "))
    };
    let message = format!("component {component} is not available in this connection type");
    Err(Diagnostic::error(Code::ActionNotAvailable, span, message, "a behaviour needs available components")
        .help(remedy))
}

/// Where D_ij (i, j from 0) stands in a row: columns of the upper triangle (D11, D12, D22, D13 …), or the whole
/// matrix column by column (D11, D21 …, our reading).
pub fn entry(unsymmetric: bool, i: usize, j: usize) -> usize {
    let (low, high) = (i.min(j), i.max(j));
    if unsymmetric { 6 * j + i } else { high * (high + 1) / 2 + low }
}

/// Rows with zeros for entries of components that are not available, which may be left open.
fn available_entries(
    rows: &[TableRow],
    outputs: usize,
    unsymmetric: bool,
    available: Mask,
    what: &str,
) -> Result<Vec<TableRow>, Diagnostic> {
    let mut rows = rows.to_vec();
    for row in &mut rows {
        row.values.resize(row.values.len().max(outputs), None);
        for i in 0..6 {
            for j in 0..6 {
                let value = &mut row.values[entry(unsymmetric, i, j)];
                if !(available[i] && available[j]) {
                    *value = Some(0.0);
                } else if value.is_none() {
                    let message = format!("{what} between components {} and {} is missing", i + 1, j + 1);
                    return Err(Diagnostic::error(Code::MissingData, row.span, message, "in this row")
                        .help("give every term of the matrix; 0 where there is none"));
                }
            }
        }
    }
    Ok(rows)
}

/// What holds beyond the ends of a table: as its own keyword says, else as the behaviour says, else constant.
pub(super) fn extrapolation([own, of_behavior]: [&TableOptions; 2]) -> Extrapolation {
    own.extrapolation.or(of_behavior.extrapolation).unwrap_or(Extrapolation::Constant)
}

/// The parts that are present in any of several forces.
pub(super) fn merged(masks: impl Iterator<Item = Mask>) -> Mask {
    masks.fold([false; 6], |sum, mask| [0, 1, 2, 3, 4, 5].map(|k| sum[k] || mask[k]))
}

/// The components whose force is a table over their own motion, each with the rows of all its tables where slopes jump.
pub(super) fn rows(laws: &[Law]) -> Vec<(usize, Vec<f64>)> {
    let mut all: Vec<(usize, Vec<f64>)> = Vec::new();
    for (component, rows) in laws.iter().filter_map(Law::rows) {
        match all.iter_mut().find(|(known, _)| *known == component) {
            Some((_, known)) => known.extend(rows),
            None => all.push((component, rows)),
        }
    }
    for (_, rows) in &mut all {
        rows.sort_by(f64::total_cmp);
        rows.dedup();
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::behavior::state::Behavior;

    const MOTION: Motion<f64> = Motion { position: [0.5; 6], constitutive: [0.25; 6], velocity: [-0.5; 6] };

    fn constants(values: &[f64], temperature: Option<f64>) -> Table {
        let row = TableRow {
            values: values.iter().copied().map(Some).collect(),
            temperature,
            ..TableRow::default()
        };
        Table::new(&[row], values.len(), &[], Extrapolation::Constant).unwrap()
    }

    fn law(kind: Kind, driver: Driver) -> Law {
        Law { kind, driver, available: [true, false, true, true, true, true] }
    }

    /// What a law adds to sizes that are 1.
    fn scales(law: &Law, conditions: &Conditions) -> [[[f64; 6]; 6]; 2] {
        let mut all = [[[1.0; 6]; 6]; 2];
        law.add_slope_scales(&MOTION, conditions, &mut all);
        all
    }

    /// Only these entries are larger than 1, by so much.
    fn only(found: [[[f64; 6]; 6]; 2], larger: &[(usize, usize, usize, f64)]) {
        for (by, matrix) in found.iter().enumerate() {
            for (i, row) in matrix.iter().enumerate() {
                for (j, x) in row.iter().enumerate() {
                    let known = larger.iter().find(|entry| (entry.0, entry.1, entry.2) == (by, i, j));
                    assert_eq!(*x, 1.0 + known.map_or(0.0, |entry| entry.3), "{by} {i} {j}");
                }
            }
        }
    }

    #[test]
    fn slopes_are_measured_where_they_stand() {
        let none = &Conditions::default();
        let linear = |driver| law(Kind::Linear { component: 2, table: constants(&[-250.0], None) }, driver);
        only(scales(&linear(Driver::Displacement), none), &[(0, 2, 2, 250.0)]);
        only(scales(&linear(Driver::Velocity), none), &[(1, 2, 2, 250.0)]);
        // F3 over the velocity, or displacement, and the position of 1: slopes 2 and −3, and 4.
        let data: [&[f64]; 4] = [&[0.0, -1.0, 0.0], &[4.0, 1.0, 0.0], &[-3.0, -1.0, 1.0], &[1.0, 1.0, 1.0]];
        let rows: Vec<TableRow> = data
            .iter()
            .map(|row| TableRow { values: row.iter().copied().map(Some).collect(), ..TableRow::default() })
            .collect();
        let table = Table::new(&rows, 1, &["x", "y"], Extrapolation::Constant).unwrap();
        let axes = vec![Axis::Own, Axis::Position(0)];
        for (driver, at) in [(Driver::Displacement, 0), (Driver::Velocity, 1)] {
            let nonlinear =
                law(Kind::Nonlinear { component: 2, table: table.clone(), axes: axes.clone() }, driver);
            // The rows have slopes 2 both, are 4 and 3 large, and differ by 3.
            only(scales(&nonlinear, none), &[(at, 2, 2, 4.0), (0, 2, 0, 10.0)]);
        }
        only(scales(&law(Kind::Rigid { components: [true; 6] }, Driver::Displacement), none), &[]);
    }

    #[test]
    fn coupled_slopes_are_those_of_available_components() {
        for symmetric in [true, false] {
            let count = entries(!symmetric);
            let values: Vec<f64> = (1..=count).map(|n| -(n as f64)).collect();
            let coupled =
                law(Kind::Coupled { table: constants(&values, None), symmetric }, Driver::Displacement);
            let larger: Vec<(usize, usize, usize, f64)> = (0..36)
                .map(|n| (n / 6, n % 6))
                .filter(|(i, j)| *i != 1 && *j != 1)
                .map(|(i, j)| (0, i, j, 1.0 + entry(!symmetric, i, j) as f64))
                .collect();
            only(scales(&coupled, &Conditions::default()), &larger);
            // Laws go to files and come back; a matrix of another size is refused.
            let mut written = serde_json::to_value(&coupled).unwrap();
            assert!(serde_json::from_value::<Law>(written.clone()).is_ok());
            written["kind"]["Coupled"]["symmetric"] = (!symmetric).into();
            let error = serde_json::from_value::<Law>(written).unwrap_err().to_string();
            assert!(error.contains(&format!("has {count} entries, not {}", 57 - count)), "{error}");
        }
    }

    /// Nothing is known of a law whose temperature is not given; all laws of a behaviour are asked.
    #[test]
    fn laws_are_asked_one_after_the_other() {
        let two = TableRow { values: vec![Some(7.0)], temperature: Some(20.0), ..TableRow::default() };
        let rows =
            [TableRow { values: vec![Some(5.0)], temperature: Some(10.0), ..TableRow::default() }, two];
        let warm = Table::new(&rows, 1, &[], Extrapolation::Constant).unwrap();
        let laws = [
            law(Kind::Linear { component: 0, table: warm }, Driver::Displacement),
            law(Kind::Linear { component: 3, table: constants(&[2.0], None) }, Driver::Displacement),
            law(Kind::Linear { component: 3, table: constants(&[4.0], None) }, Driver::Velocity),
        ];
        only(scales(&laws[0], &Conditions::default()), &[]);
        let json = serde_json::json!({ "laws": laws, "structural": 0 });
        let mut behavior = Behavior::default();
        behavior.elasticity = serde_json::from_value(json.clone()).unwrap();
        behavior.damping = serde_json::from_value(json).unwrap();
        let found = behavior.slope_scales(&MOTION, &Conditions::default());
        only(found.map(|by| by.map(|row| row.map(|x| 1.0 + x))), &[(0, 3, 3, 4.0), (1, 3, 3, 8.0)]);
    }
}
