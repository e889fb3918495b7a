//! Somebody else's friction: what it gives at a state, and what may explain it.

use crate::case::failing::FrictionCase;
use crate::case::quantity::Quantity;
use crate::friction::by_differences;
use crate::friction::increment::{output, partials, result_name, results};
use crate::judge::table::ResultTable;
use crate::mutants::diagnosis::{Cause, Hypothesis};
use crate::mutants::mutant::Mutant;
use pintle_kinematics::catalog::{ConnectionType, Contact, FORCE};
use pintle_model::behavior::friction::{
    Branch, Coefficient, Criterion, Friction, Internal, Status, StickStiffness, Tangential, TermMistake,
};

/// How forces press together.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Shape {
    /// √(Σ x²).
    Norm,
    /// Σ |x|.
    Sum,
    /// Σ x.
    Signed,
}

/// A part of a contact force: its factor, and the rows A of x = A f.
type Part = (f64, Vec<[f64; 6]>, Shape);

/// A sum of parts at forces f, and its derivatives by them; a norm at zero has the slope zero.
fn pressed(parts: &[Part], f: &[f64; 6]) -> (f64, [f64; 6]) {
    let (mut value, mut slopes) = (0.0, [0.0; 6]);
    for (factor, rows, shape) in parts {
        let along: Vec<f64> =
            rows.iter().map(|row| row.iter().zip(f).map(|(x, force)| x * force).sum()).collect();
        let size = along.iter().map(|x| x * x).sum::<f64>().sqrt();
        let of = |x: f64| match shape {
            Shape::Norm => [x * x / size, x / size],
            Shape::Sum => [x.abs(), if x == 0.0 { 0.0 } else { x.signum() }],
            Shape::Signed => [x, 1.0],
        };
        for (row, x) in rows.iter().zip(&along).filter(|_| size != 0.0 || *shape == Shape::Signed) {
            let [part, slope] = of(*x);
            value += factor * part;
            slopes.iter_mut().zip(row).for_each(|(sum, entry)| *sum += factor * slope * entry);
        }
    }
    (value, slopes)
}

/// The row of one force.
fn unit(k: usize) -> [f64; 6] {
    std::array::from_fn(|j| f64::from(u8::from(j == k)))
}

/// A cause, in words, and the numbers of each name that it would give.
type Known = (Cause, String, Vec<(String, Vec<f64>)>);

/// What a routine gives of a friction at a state; `None` for what it has not.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrictionNumbers {
    /// P, F_C, F_N and Φ at the given forces.
    pub criterion: [Option<f64>; 4],
    /// Their derivatives by the six forces.
    pub gradients: [Option<[f64; 6]>; 4],
    /// After the increment: the friction forces CSF1 … CSM3, then Δγ, F_N, the limit and the accumulated slip.
    pub forces: [Option<f64>; 10],
    /// The derivatives of the friction forces by the six Δu, then by the six forces that press.
    pub tangent: [Option<[f64; 12]>; 6],
}

/// A friction that a routine is to be: one with a coefficient that is a number.
#[derive(Clone, Debug)]
pub struct FrictionSubject {
    /// The connection type, or the connector.
    pub name: String,
    /// The friction.
    pub friction: Friction,
    /// μ.
    pub coefficient: f64,
    /// The parameters of a predefined friction, by the manual's symbols.
    pub parameters: Vec<(&'static str, f64)>,
    /// The size of lengths.
    pub length: f64,
    /// The type.
    pub connection: ConnectionType,
    /// Frictions that are mistaken for it.
    others: Vec<(Cause, String, Friction)>,
}

impl FrictionSubject {
    /// One of a connector, with its characteristic length.
    ///
    /// # Errors
    /// In words, where its coefficient is no number.
    pub fn new(
        name: String,
        connection: ConnectionType,
        friction: Friction,
        length: f64,
    ) -> Result<Self, String> {
        let Coefficient::Constant(coefficient) = friction.coefficient else {
            return Err(format!(
                "the coefficient of the friction of {name} is a table or decays: give a number"
            ));
        };
        let with = |coefficient: f64| Friction {
            coefficient: Coefficient::Constant(coefficient),
            ..friction.clone()
        };
        let mut others = Vec::new();
        let mut add = |cause: Cause, how: &str, other: Friction| {
            others.push((cause, format!("what is expected {how}"), other));
        };
        for (how, coefficient) in [
            ("with −μ for μ", -coefficient),
            ("with μ² for μ", coefficient * coefficient),
            ("without μ", 1.0),
            ("with half of μ", coefficient / 2.0),
            ("with twice μ", 2.0 * coefficient),
        ] {
            add(Cause::OtherCoefficient, how, with(coefficient));
        }
        let mut plain = friction.clone();
        plain.criterion.internal = Internal::Constant(0.0);
        add(Cause::TermLeftOut, "without F_C^int", plain);
        if let Tangential::Norm(components) = &friction.criterion.tangential {
            let mut undivided = friction.clone();
            let ones = components.iter().map(|(k, _)| (*k, 1.0)).collect();
            undivided.criterion.tangential = Tangential::Norm(ones);
            add(Cause::NotNormalised, "without the radius that divides a moment in P", undivided);
        }
        if let Internal::Constant(internal) = friction.criterion.internal {
            let mut against = friction.clone();
            against.criterion.internal = Internal::Constant(-internal);
            add(Cause::Reversed, "with −F_C^int for F_C^int", against);
        }
        if let Some(maximum) = friction.maximum {
            for (cause, how, maximum) in [
                (Cause::TermLeftOut, "without τ_max", None),
                (Cause::OtherCoefficient, "with μ τ_max for τ_max", Some(coefficient * maximum)),
                (Cause::OtherCoefficient, "with τ_max/μ for τ_max", Some(maximum / coefficient)),
            ] {
                add(cause, how, Friction { maximum, ..friction.clone() });
            }
        }
        for (mistake, what, criterion) in friction.criterion.with_components_mistaken() {
            let other = Friction { criterion, ..friction.clone() };
            add(cause_of(mistake), &format!("with {what}"), other);
        }
        for (what, criterion) in friction.criterion.with_parts_left_out() {
            let other = Friction { criterion, ..friction.clone() };
            add(Cause::TermLeftOut, &format!("without {what}"), other);
        }
        others.retain(|(.., other)| *other != friction);
        Ok(Self { name, friction, coefficient, parameters: Vec::new(), length, connection, others })
    }

    /// The predefined friction of a type, of that number (from 0), with parameters and a coefficient of its own. None of a type without; a belt
    /// around a ring has another law.
    pub fn predefined(connection: &ConnectionType, number: usize) -> Option<Self> {
        /// No two are alike, and none is 1.
        const NUMBERS: [f64; 6] = [0.35, 1.7, 0.8, 2.4, 0.55, 1.25];
        let catalogued =
            connection.friction.filter(|f| f.criteria.iter().all(|c| c.contact != Contact::Belt))?;
        let numbers: Vec<f64> = NUMBERS.iter().cycle().take(catalogued.parameters.len()).copied().collect();
        let criterion = |numbers: &[f64]| {
            let numbers: Vec<Option<f64>> = numbers.iter().map(|x| Some(*x)).collect();
            Criterion::predefined(&catalogued, &numbers, &[], false).ok()?.into_iter().nth(number)
        };
        let friction = |criterion: Criterion| Friction {
            criterion,
            coefficient: Coefficient::Constant(0.3),
            maximum: None,
            stick_stiffness: StickStiffness::Given(40.0),
            radius: 1.0,
        };
        let own = friction(criterion(&numbers)?);
        let mut found = Self::new(connection.name.to_string(), connection.clone(), own, 1.0).ok()?;
        let symbol = |i: usize| catalogued.parameters[i].symbol;
        for i in 0..numbers.len() {
            for j in 0..i {
                let mut exchanged = numbers.clone();
                exchanged.swap(i, j);
                let relation = format!("what is expected with {} and {} exchanged", symbol(j), symbol(i));
                let other = criterion(&exchanged).map(friction).filter(|other| *other != found.friction);
                found.others.extend(other.map(|other| (Cause::ParametersSwapped, relation, other)));
            }
        }
        let symbols: Vec<(&'static str, f64)> =
            numbers.iter().enumerate().map(|(i, x)| (symbol(i), *x)).collect();
        for (mistake, what, criterion) in found.friction.criterion.with_terms_mistaken(&symbols) {
            let cause = cause_of(mistake);
            let other = friction(criterion);
            if found.others.iter().all(|(.., known)| *known != other) {
                found.others.push((cause, format!("what is expected with {what}"), other));
            }
        }
        found.parameters = symbols;
        Some(found)
    }
}

const fn cause_of(mistake: TermMistake) -> Cause {
    match mistake {
        TermMistake::Parameter => Cause::ParametersSwapped,
        TermMistake::LeftOut => Cause::NotNormalised,
        TermMistake::Norm => Cause::SumForNorm,
        TermMistake::Axis => Cause::OtherAxis,
    }
}

/// Some rows and columns of a table, with the mistakes in them.
fn selected(table: ResultTable, rows: &[usize], columns: &[usize]) -> ResultTable {
    let width = table.width();
    let places = rows.iter().flat_map(|i| columns.iter().map(move |j| i * width + j));
    let at = |of: &[usize], place: usize| of.iter().position(|known| *known == place);
    let moved = |Mutant { mistake, changes }| {
        let to = |(i, j, x): &(usize, usize, f64)| Some((at(rows, *i)?, at(columns, *j)?, *x));
        Mutant::many(mistake, changes.iter().filter_map(to))
    };
    let names = |of: &[String], chosen: &[usize]| -> Vec<String> {
        chosen.iter().filter_map(|i| of.get(*i).cloned()).collect()
    };
    ResultTable {
        quantity: table.quantity,
        rows: names(&table.rows, rows),
        columns: names(&table.columns, columns),
        entries: places.filter_map(|place| table.entries.get(place).cloned()).collect(),
        mistakes: table.mistakes.into_iter().map(moved).filter(|made| !made.changes.is_empty()).collect(),
        conventions: Vec::new(),
        undecided: table.undecided,
    }
}

/// What a routine is told of a state.
#[derive(Clone, Copy, Debug)]
pub struct Told {
    /// The forces at which the criterion is asked for: tractions in the sliding components, what presses in the others.
    pub forces: [f64; 6],
    /// Δu of the increment; angles in rad.
    pub displacement: [f64; 6],
    /// What presses at its end.
    pub pressing: [f64; 6],
    /// The friction forces before it.
    pub forces_before: [f64; 6],
    /// The slip accumulated before it.
    pub slip_before: f64,
    /// K_s, where the default rule has set it before.
    pub stick_stiffness: Option<f64>,
    /// Positions (CP) at its end.
    pub position: [f64; 6],
    /// Displacements from the constitutive reference (CCU) at its end.
    pub motion: [f64; 6],
}

impl FrictionCase {
    /// What a routine is told of this state.
    pub const fn told(&self) -> Told {
        Told {
            forces: self.point,
            displacement: self.displacement,
            pressing: self.forces,
            forces_before: self.before.force,
            slip_before: self.before.accumulated_slip,
            stick_stiffness: self.before.stick_stiffness,
            position: self.position,
            motion: self.motion,
        }
    }

    /// What the product gives at this state.
    pub fn product(&self) -> FrictionNumbers {
        let parts = self.derivatives(&self.friction.criterion, &self.point);
        let (outcome, tangent) = self.friction.tangent(&self.before, &self.input(0, 0.0), Branch::Decided);
        let [f1, f2, f3, m1, m2, m3] = outcome.force;
        let rest = [outcome.slip_increment, outcome.normal, outcome.limit, outcome.accumulated_slip];
        let [slip, normal, limit, accumulated] = rest;
        let rows = partials(&tangent);
        FrictionNumbers {
            criterion: [0, 1, 2, 3].map(|p| Some(parts[p].value)),
            gradients: [0, 1, 2, 3].map(|p| Some(parts[p].gradient)),
            forces: [f1, f2, f3, m1, m2, m3, slip, normal, limit, accumulated].map(Some),
            tangent: [0, 1, 2, 3, 4, 5].map(|k| Some(std::array::from_fn(|j| rows[k][j]))),
        }
    }

    /// The components that slide (from 0).
    pub(crate) fn sliding(&self) -> Vec<usize> {
        self.friction.criterion.tangential.components()
    }

    /// What must be of these quantities, with the product's own numbers.
    pub(crate) fn tables_of_subject(&self, wants: &[Quantity]) -> Vec<ResultTable> {
        let settings = by_differences();
        let mut judged = Vec::new();
        if wants.iter().any(|of| matches!(of, Quantity::FrictionCriterion | Quantity::FrictionGradient)) {
            judged.extend(self.criterion_tables(&settings, true));
        }
        if wants.iter().any(|of| matches!(of, Quantity::FrictionForce | Quantity::FrictionTangent)) {
            judged.extend(self.increment_tables(&settings, true));
        }
        let sliding = self.sliding();
        let tables = judged.into_iter().map(|(_, table)| table);
        tables
            .filter(|table| wants.contains(&table.quantity))
            .map(|table| match table.quantity {
                Quantity::FrictionTangent => selected(table, &sliding, &(0..12).collect::<Vec<_>>()),
                _ => table,
            })
            .collect()
    }

    /// Puts a routine's numbers into a table of [`FrictionCase::tables_of_subject`]: what it does not give of Δγ, F_N, the limit and the
    /// slip is left out.
    ///
    /// # Errors
    /// The name of what is missing.
    pub(crate) fn put(&self, table: ResultTable, given: &FrictionNumbers) -> Result<ResultTable, String> {
        if table.undecided.is_some() {
            return Ok(table);
        }
        let sliding = self.sliding();
        let numbers: Vec<Vec<Option<f64>>> = match table.quantity {
            Quantity::FrictionCriterion => given.criterion.iter().map(|x| vec![*x]).collect(),
            Quantity::FrictionGradient => {
                given.gradients.iter().map(|row| (0..6).map(|j| Some((*row)?[j])).collect()).collect()
            }
            Quantity::FrictionTangent => {
                sliding.iter().map(|k| (0..12).map(|j| Some(given.tangent[*k]?[j])).collect()).collect()
            }
            _ => sliding.iter().copied().chain(6..10).map(|i| vec![given.forces[i]]).collect(),
        };
        let may_lack = |row: usize| table.quantity == Quantity::FrictionForce && row >= sliding.len();
        let has = |row: &usize| numbers.get(*row).is_some_and(|of| of.iter().all(Option::is_some));
        if let Some(row) = (0..numbers.len()).find(|row| !has(row) && !may_lack(*row)) {
            return Err(table.rows.get(row).cloned().unwrap_or_default());
        }
        let rows: Vec<usize> = (0..numbers.len()).filter(has).collect();
        let columns: Vec<usize> = (0..table.width()).collect();
        let mut table = selected(table, &rows, &columns);
        let given = rows.iter().flat_map(|row| numbers[*row].iter().flatten());
        for (entry, x) in table.entries.iter_mut().zip(given) {
            entry.got = *x;
        }
        Ok(table)
    }

    /// Gives a table of a routine's numbers what may explain them.
    pub(crate) fn explain(&self, table: &mut ResultTable, subject: &FrictionSubject) {
        let sliding = self.sliding();
        let names: Vec<String> = table.rows.clone();
        // The numbers of a mistaken friction, by the names of rows.
        let mut found: Vec<Known> = Vec::new();
        for (cause, relation, friction) in &subject.others {
            let coefficient = match friction.coefficient {
                Coefficient::Constant(coefficient) => coefficient,
                _ => self.coefficient,
            };
            let other = Self { friction: friction.clone(), coefficient, ..self.clone() };
            found.push((*cause, relation.clone(), other.own(table.quantity)));
        }
        found.extend(self.other_norms(table.quantity));
        found.extend(self.other_angles(table.quantity));
        if table.quantity == Quantity::FrictionCriterion && self.internal() != 0.0 {
            let [traction, contact, ..] = self.part_values();
            let excess = vec![(format!("Φ{}", self.title), vec![traction - self.coefficient * contact])];
            found.push((Cause::TermLeftOut, "Φ with F_C for F_N: F_C^int is left out".into(), excess));
        }
        match table.quantity {
            Quantity::FrictionGradient => found.extend(self.other_gradients()),
            Quantity::FrictionForce => found.extend(self.other_increments(&sliding)),
            _ => {}
        }
        if table.quantity == Quantity::FrictionTangent {
            found.extend(self.other_tangents(&sliding));
        }
        let width = table.width();
        for (cause, relation, rows) in found {
            let mut changes = Vec::new();
            for (name, numbers) in rows {
                let Some(at) = names.iter().position(|known| *known == name) else { continue };
                let row = numbers.iter().copied().enumerate().take(width);
                changes.extend(row.map(|(j, x)| (at, j, x)));
            }
            // What it leaves as it is says nothing of it, and a kink has no one number.
            changes.retain(|(at, j, x)| {
                table.entries.get(at * width + j).is_some_and(|entry| {
                    entry.sides.is_none() && (x - entry.want.to_f64()).abs() > entry.tolerance()
                })
            });
            table.conventions.push(Hypothesis::many(cause, changes).related(relation));
        }
    }

    /// The product's numbers of a quantity, by the names of rows.
    fn own(&self, quantity: Quantity) -> Vec<(String, Vec<f64>)> {
        use crate::friction::criterion::PARTS;
        let parts = || self.derivatives(&self.friction.criterion, &self.point);
        let title = |name: &str| format!("{name}{}", self.title);
        let updated = || self.friction.tangent(&self.before, &self.input(0, 0.0), Branch::Decided);
        match quantity {
            Quantity::FrictionCriterion => {
                PARTS.iter().zip(parts()).map(|(name, part)| (title(name), vec![part.value])).collect()
            }
            Quantity::FrictionGradient => PARTS
                .iter()
                .zip(parts())
                .map(|(name, part)| (format!("∂{}", title(name)), part.gradient.to_vec()))
                .collect(),
            Quantity::FrictionForce => {
                let (outcome, _) = updated();
                let mut all: Vec<(String, Vec<f64>)> =
                    (0..6).map(|k| (title(&output(k)), vec![outcome.force[k]])).collect();
                let rest = [
                    ("Δγ", outcome.slip_increment),
                    ("CNF", outcome.normal),
                    ("limit", outcome.limit),
                    ("CASU", outcome.accumulated_slip),
                ];
                all.extend(rest.map(|(name, x)| (title(name), vec![x])));
                all
            }
            _ => {
                let (outcome, tangent) = updated();
                let rows = partials(&tangent).into_iter().take(results(&outcome).len());
                rows.enumerate().map(|(i, row)| (format!("∂{}", title(result_name(i))), row)).collect()
            }
        }
    }

    /// P and F_C with sums of magnitudes for norms; F_C with the sign of a force for its magnitude, with one norm for several terms, with two
    /// forces exchanged.
    fn other_norms(&self, quantity: Quantity) -> Vec<Known> {
        let criterion = &self.friction.criterion;
        let parts = self.derivatives(criterion, &self.point);
        let own = (parts[1].value, parts[1].gradient);
        let mut found = Vec::new();
        let traction = (parts[0].value, parts[0].gradient);
        let internal = self.internal();
        if own.0 != 0.0 && internal != 0.0 {
            let (contact, slopes) = if own.0 > internal { own } else { (internal, [0.0; 6]) };
            let mut rows = self.with_contact(quantity, traction, (contact - internal, slopes));
            // F_C is as it must be.
            if rows.len() > 1 {
                rows.remove(1);
            }
            let relation = "what is expected with the larger of F_C and F_C^int for their sum";
            found.push((Cause::SumForNorm, relation.to_string(), rows));
        }
        let mut add = |cause: Cause, words: String, traction: (f64, [f64; 6]), contact: (f64, [f64; 6])| {
            let relation = format!("what is expected with {words}");
            found.push((cause, relation, self.with_contact(quantity, traction, contact)));
        };
        let of_traction = match &criterion.tangential {
            Tangential::Norm(components) if components.len() > 1 => {
                let of = |(k, radius): &(usize, f64)| (1.0 / radius, vec![unit(*k)], Shape::Sum);
                Some(pressed(&components.iter().map(of).collect::<Vec<_>>(), &self.point))
            }
            Tangential::Norm(_) | Tangential::Potential(_) => None,
        };
        if let Some(sum) = of_traction {
            add(Cause::SumForNorm, "the sum of magnitudes for the norm in P".into(), sum, own);
        }
        let magnitudes = criterion.contact_norms(&self.context());
        let terms: Vec<Part> =
            magnitudes.into_iter().map(|(factor, rows)| (factor, rows, Shape::Norm)).collect();
        let is_of_axes = terms
            .iter()
            .flat_map(|(_, rows, _)| rows)
            .any(|row| row.iter().filter(|x| **x != 0.0).count() > 1);
        if terms.is_empty() || is_of_axes {
            return found;
        }
        if terms.iter().any(|(_, rows, _)| rows.len() > 1) {
            let of = |(factor, rows, _): &Part| (*factor, rows.clone(), Shape::Sum);
            let sums = pressed(&terms.iter().map(of).collect::<Vec<_>>(), &self.point);
            add(Cause::SumForNorm, "the sum of magnitudes for the norm in F_C".into(), traction, sums);
            if let Some(sum) = of_traction {
                add(Cause::SumForNorm, "sums of magnitudes for the norms in P and F_C".into(), sum, sums);
            }
        }
        // A factor before one force of a norm alone.
        for (i, (factor, rows, _)) in terms.iter().enumerate().filter(|(_, (factor, ..))| *factor != 0.0) {
            for n in (0..rows.len()).filter(|_| rows.len() > 1) {
                let mut partial = terms.clone();
                let scaled =
                    |(m, row): (usize, &[f64; 6])| if m == n { *row } else { row.map(|x| x / factor) };
                partial[i].1 = rows.iter().enumerate().map(scaled).collect();
                let force = rows[n].iter().position(|x| *x != 0.0).map_or("", |k| FORCE[k]);
                let words = format!("the factor of a norm at {force} alone in F_C");
                add(Cause::NotNormalised, words, traction, pressed(&partial, &self.point));
            }
        }
        for (i, (_, rows, _)) in terms.iter().enumerate() {
            let [row] = &rows[..] else { continue };
            let mut signed = terms.clone();
            signed[i].2 = Shape::Signed;
            let force = row.iter().position(|x| *x != 0.0).map_or("", |k| FORCE[k]);
            let words = format!("{force} for its magnitude in F_C");
            add(Cause::SignLost, words, traction, pressed(&signed, &self.point));
        }
        let pairs = (0..terms.len()).flat_map(|j| (0..j).map(move |i| vec![i, j]));
        for set in pairs.chain((terms.len() > 2).then(|| (0..terms.len()).collect())) {
            let (joined, mut rest): (Vec<_>, Vec<_>) =
                terms.iter().cloned().enumerate().partition(|(i, _)| set.contains(i));
            let rows = joined
                .iter()
                .flat_map(|(_, (factor, rows, _))| rows.iter().map(move |row| row.map(|x| factor * x)));
            rest.push((0, (1.0, rows.collect(), Shape::Norm)));
            let all: Vec<Part> = rest.into_iter().map(|(_, part)| part).collect();
            let which = if set.len() == terms.len() { "all" } else { "two" };
            let words = format!("one norm of {which} terms in F_C");
            add(Cause::SumForNorm, words, traction, pressed(&all, &self.point));
        }
        for (k, l) in [(0, 1), (1, 2), (0, 2), (3, 4), (4, 5), (3, 5)] {
            let mut point = self.point;
            point.swap(k, l);
            let (value, mut slopes) = pressed(&terms, &point);
            slopes.swap(k, l);
            let words = format!("{} and {} exchanged in F_C", FORCE[k], FORCE[l]);
            add(Cause::ParametersSwapped, words, traction, (value, slopes));
        }
        found
    }

    /// F_C^int.
    fn internal(&self) -> f64 {
        self.friction.criterion.internal_force(&self.context())
    }

    /// P, F_C, F_N and Φ, or their gradients, with another traction and another contact force; nothing of other quantities.
    fn with_contact(
        &self,
        quantity: Quantity,
        (traction, of_traction): (f64, [f64; 6]),
        (contact, of_contact): (f64, [f64; 6]),
    ) -> Vec<(String, Vec<f64>)> {
        use crate::friction::criterion::PARTS;
        let normal = contact + self.internal();
        let sign = if normal == 0.0 { 0.0 } else { normal.signum() };
        let excess = |p: f64, n: f64| p - self.coefficient * n;
        let of_normal = of_contact.map(|x| sign * x);
        let of_excess = std::array::from_fn(|j| excess(of_traction[j], of_normal[j]));
        let (prefix, rows): (&str, Vec<Vec<f64>>) = match quantity {
            Quantity::FrictionCriterion => {
                let all = [traction, contact, normal.abs(), excess(traction, normal.abs())];
                ("", all.map(|x| vec![x]).to_vec())
            }
            Quantity::FrictionGradient => {
                let all: [[f64; 6]; 4] = [of_traction, of_contact, of_normal, of_excess];
                ("∂", all.map(|row| row.to_vec()).to_vec())
            }
            _ => return Vec::new(),
        };
        let is_number = rows.iter().flatten().all(|x| x.is_finite());
        let named = PARTS.iter().zip(rows).filter(|_| is_number);
        named.map(|(name, row)| (format!("{prefix}{name}{}", self.title), row)).collect()
    }

    /// Axes that move with other angles: one that is left out, or has the other sign.
    fn other_angles(&self, quantity: Quantity) -> Vec<Known> {
        let own = self.own(quantity);
        let mut found = Vec::new();
        for k in 3..6 {
            for (what, times) in [("without", 0.0), ("with the other sign of", -1.0)] {
                let mut other = self.clone();
                other.position[k] *= times;
                let numbers = other.own(quantity);
                if numbers != own {
                    let relation = format!("what is expected {what} the angle ur{} in the axis", k - 2);
                    found.push((Cause::AxesOfA, relation, numbers));
                }
            }
        }
        found
    }

    /// Slopes without their signs, and that of Φ with the contact force held.
    fn other_gradients(&self) -> Vec<Known> {
        let own = self.own(Quantity::FrictionGradient);
        let sizes =
            own.iter().map(|(name, row)| (name.clone(), row.iter().map(|x| x.abs()).collect())).collect();
        let of_traction = own.first().map(|(_, row)| row.clone()).unwrap_or_default();
        let held = own.last().map(|(name, _)| vec![(name.clone(), of_traction.clone())]).unwrap_or_default();
        let (lost, missing) = (Cause::SignLost, Cause::CouplingMissing);
        // The gradient of a root without its division by the root.
        let [traction, ..] = self.part_values();
        let undivided = own.iter().zip([1.0, 0.0, 0.0, 1.0]).filter(|(_, has)| *has != 0.0);
        let undivided = undivided.map(|((name, row), _)| {
            let more = row.iter().zip(&of_traction).map(|(x, slope)| x + (traction - 1.0) * slope);
            (name.clone(), more.collect::<Vec<f64>>())
        });
        let relation = "the gradient of P not divided by P".to_string();
        let undivided = (Cause::NotNormalised, relation, undivided.collect());
        vec![
            undivided,
            (lost, lost.relation().to_string(), sizes),
            (missing, missing.relation().to_string(), held),
        ]
    }

    /// Forces without what was stored, slip that is not summed up, all of the motion as slip, each component limited by itself.
    fn other_increments(&self, sliding: &[usize]) -> Vec<Known> {
        let of = Quantity::FrictionForce;
        let mut fresh = self.clone();
        fresh.before.force = [0.0; 6];
        let mut unsummed = self.clone();
        unsummed.before.accumulated_slip = 0.0;
        let mut against = self.clone();
        against.displacement = self.displacement.map(|x| -x);
        let alone = "what the increment alone gives, the forces before it left out";
        let reversed = "what is expected with the increment of the other sign, f − K_s Δu";
        let mut found = vec![
            (Cause::Increment, alone.into(), fresh.own(of)),
            (Cause::Increment, "the slip of the increment, not summed up".into(), unsummed.own(of)),
            (Cause::Reversed, reversed.into(), against.own(of)),
        ];
        found.extend(self.other_stiffnesses(of, sliding));
        let (outcome, _) = self.friction.tangent(&self.before, &self.input(0, 0.0), Branch::Decided);
        let title = |name: &str| format!("{name}{}", self.title);
        let radii = self.friction.radii();
        let whole = radii.iter().map(|(k, r)| (r * self.displacement[*k]).powi(2)).sum::<f64>().sqrt();
        let slipped = |slip: f64| {
            let all = [("Δγ", slip), ("CASU", self.before.accumulated_slip + slip)];
            all.map(|(name, x)| (title(name), vec![x])).to_vec()
        };
        found.push((Cause::StickForSlip, "the whole motion, with what stick stores".into(), slipped(whole)));
        let mut pressed = self.clone();
        pressed.forces = self.point;
        let relation = "what is expected with the contact force of the start of the increment";
        found.push((Cause::StateBefore, relation.into(), pressed.own(of)));
        if let Some(stiffness) = outcome.stick_stiffness.filter(|_| outcome.status == Status::Slip) {
            for (what, slip) in [
                ("not divided by the stick stiffness", stiffness * outcome.slip_increment),
                ("with its sign", -outcome.slip_increment),
            ] {
                found.push((Cause::NotNormalised, format!("the slip {what}"), slipped(slip)));
            }
            for (_, r) in radii.iter().filter(|(_, r)| *r != 1.0) {
                let slip = outcome.slip_increment / (r * r);
                let relation = "the slip divided by the stick stiffness of a moment, K_s R²";
                found.push((Cause::NotNormalised, relation.into(), slipped(slip)));
            }
            let trial: Vec<(String, Vec<f64>)> = radii
                .iter()
                .filter(|(k, _)| sliding.contains(k))
                .map(|(k, r)| {
                    let force = self.before.force[*k] + stiffness * r * r * self.displacement[*k];
                    (title(&output(*k)), vec![force])
                })
                .collect();
            // One of several that is not cut.
            if trial.len() > 1 {
                for one in &trial {
                    let relation = format!("the force of {} that would stick, not cut at the limit", one.0);
                    found.push((Cause::StickForSlip, relation, vec![one.clone()]));
                }
            }
            let relation = "the force that would stick, not cut at the limit";
            found.push((Cause::StickForSlip, relation.into(), trial));
            // At the limit along another direction than that of the force that would stick.
            let along = |of: &dyn Fn(usize, f64) -> f64| {
                let forces: Vec<(usize, f64)> = radii.iter().map(|(k, r)| (*k, of(*k, *r))).collect();
                let size =
                    forces.iter().zip(&radii).map(|((_, x), (_, r))| (x / r).powi(2)).sum::<f64>().sqrt();
                let at_limit = forces.into_iter().filter(|(k, _)| sliding.contains(k));
                at_limit.map(|(k, x)| (title(&output(k)), vec![outcome.limit * x / size])).collect::<Vec<_>>()
            };
            let spring = |k: usize, r: f64| stiffness * r * r * self.displacement[k];
            type Direction<'a> = &'a dyn Fn(usize, f64) -> f64;
            let directions: [(&str, Direction<'_>); 2] = [
                ("along the motion of the increment", &spring),
                ("along the force before it", &|k, _| self.before.force[k]),
            ];
            for (what, direction) in directions {
                let relation = format!("the limit {what}");
                found.push((Cause::OtherParameters, relation, along(direction)));
            }
        }
        if let Some(stiffness) = outcome.stick_stiffness {
            let alone = radii.iter().filter(|(k, _)| sliding.contains(k)).map(|(k, r)| {
                let trial = self.before.force[*k] + stiffness * r * r * self.displacement[*k];
                let most = outcome.limit * r;
                (title(&output(*k)), vec![trial.clamp(-most, most)])
            });
            let relation = "what is expected of each component limited by itself, a box for the circle";
            found.push((Cause::SumForNorm, relation.into(), alone.collect()));
        }
        found
    }

    /// Forces, or the tangent, with K_s or K_s R for the stick stiffness K_s R² of a moment whose radius is R.
    ///
    /// With t_k = f_k + K_k Δu_k and n = √(Σ (t_k/R_k)²) the force is t where n is below the limit L, and L t/n beyond it. There ∂f_k/∂Δu_j =
    /// (L/n) K_j (δ_kj − t_k t_j/(R_j² n²)), and what presses enters by ∂L/∂f_j t_k/n.
    fn other_stiffnesses(&self, quantity: Quantity, sliding: &[usize]) -> Vec<Known> {
        let (outcome, _) = self.friction.tangent(&self.before, &self.input(0, 0.0), Branch::Decided);
        let Some(stiffness) = outcome.stick_stiffness else { return Vec::new() };
        let radii: Vec<(usize, f64)> =
            self.friction.radii().into_iter().filter(|(k, _)| sliding.contains(k)).collect();
        if radii.iter().all(|(_, r)| *r == 1.0) {
            return Vec::new();
        }
        let [_, _, normal, _] = self.derivatives(&self.friction.criterion, &self.forces_at_end());
        let mut found = Vec::new();
        for (power, what) in [(0, "K_s"), (1, "K_s R")] {
            let spring = |r: f64| stiffness * r.powi(power);
            let trial: Vec<f64> = radii
                .iter()
                .map(|(k, r)| self.before.force[*k] + spring(*r) * self.displacement[*k])
                .collect();
            let size = trial.iter().zip(&radii).map(|(x, (_, r))| (x / r).powi(2)).sum::<f64>().sqrt();
            let slips = size > outcome.limit;
            let share = if slips { outcome.limit / size } else { 1.0 };
            let rows = radii.iter().zip(&trial).enumerate().map(|(i, ((k, _), x))| {
                if quantity == Quantity::FrictionForce {
                    return (format!("{}{}", output(*k), self.title), vec![share * x]);
                }
                let mut row = vec![0.0; 12];
                for (j, ((l, r), y)) in radii.iter().zip(&trial).enumerate() {
                    let own = if i == j { share * spring(*r) } else { 0.0 };
                    let turned = share * x * y / (r * r * size * size) * spring(*r);
                    row[*l] = own - if slips { turned } else { 0.0 };
                }
                if slips {
                    for (entry, slope) in row[6..].iter_mut().zip(normal.gradient) {
                        *entry = self.coefficient * slope * x / size;
                    }
                }
                (format!("∂{}{}", result_name(*k), self.title), row)
            });
            let relation =
                format!("what is expected with the stick stiffness {what} of a moment, for K_s R²");
            let mut rows: Vec<(String, Vec<f64>)> = rows.collect();
            if quantity == Quantity::FrictionForce {
                let slip = if slips { (size - outcome.limit) / stiffness } else { 0.0 };
                let all = [("Δγ", slip), ("CASU", self.before.accumulated_slip + slip)];
                rows.extend(all.map(|(name, x)| (format!("{name}{}", self.title), vec![x])));
            }
            found.push((Cause::NotNormalised, relation, rows));
        }
        found
    }

    /// What presses at the end of the increment.
    fn forces_at_end(&self) -> [f64; 6] {
        let sliding = self.sliding();
        std::array::from_fn(|k| if sliding.contains(&k) { self.point[k] } else { self.forces[k] })
    }

    /// The tangent of an increment that goes to zero, that of slip with the slope of the limit left out, and its symmetric part.
    fn other_tangents(&self, sliding: &[usize]) -> Vec<Known> {
        let input = self.input(0, 0.0);
        let (outcome, tangent) = self.friction.tangent(&self.before, &input, Branch::Decided);
        let own = partials(&tangent);
        let name = |k: usize| format!("∂{}{}", result_name(k), self.title);
        let mut found = Vec::new();
        let rows = |of: &dyn Fn(usize, usize) -> f64| -> Vec<(String, Vec<f64>)> {
            sliding.iter().map(|k| (name(*k), (0..12).map(|j| of(*k, j)).collect())).collect()
        };
        let symmetric = rows(&|k, j| if j < 6 { (own[k][j] + own[j][k]) / 2.0 } else { 0.0 });
        // Of a matrix that is symmetric but for what presses, that is what is missing.
        let differs = |k: &usize, j: &usize| (own[*k][*j] - own[*j][*k]).abs() > 1e-9 * own[*k][*j].abs();
        if sliding.iter().any(|k| sliding.iter().any(|j| differs(k, j))) {
            found.push((Cause::Symmetrised, Cause::Symmetrised.relation().to_string(), symmetric));
        }
        found.extend(self.other_stiffnesses(Quantity::FrictionTangent, sliding));
        let zero = Cause::ComponentZero;
        if outcome.status == Status::Stick {
            found.push((zero, "zero, though it sticks".into(), rows(&|_, _| 0.0)));
        }
        let against = rows(&|k, j| if j < 6 { own[k][j] } else { -own[k][j] });
        let relation = "what is expected with the other sign of the slopes by what presses";
        found.push((Cause::Reversed, relation.into(), against));
        if self.friction.maximum.is_some_and(|maximum| outcome.limit >= maximum) {
            let [_, _, normal, _] = self.derivatives(&self.friction.criterion, &self.forces_at_end());
            let coupled = rows(&|k, j| match j {
                0..6 => own[k][j],
                _ => self.coefficient * normal.gradient[j - 6] * outcome.force[k] / outcome.limit,
            });
            let relation = "what is expected with the slope of μ F_N, though τ_max is the limit";
            found.push((Cause::TermLeftOut, relation.into(), coupled));
        }
        let Some(stiffness) = outcome.stick_stiffness.filter(|_| outcome.status == Status::Slip) else {
            return found;
        };
        let mut at_end = self.clone();
        for k in sliding {
            at_end.point[*k] = outcome.force[*k];
        }
        let [parts, ..] = at_end.derivatives(&self.friction.criterion, &at_end.point);
        let mut elastic = [0.0; 6];
        for (k, radius) in self.friction.radii() {
            elastic[k] = stiffness * radius * radius;
        }
        // The size of the traction that stick would give.
        let trial = self
            .friction
            .radii()
            .into_iter()
            .filter(|(k, _)| sliding.contains(k))
            .map(|(k, radius)| (self.before.force[k] + elastic[k] * self.displacement[k]) / radius);
        let share = outcome.limit / trial.map(|x| x * x).sum::<f64>().sqrt();
        let stuck = rows(&|k, j| if j == k { elastic[k] } else { 0.0 });
        found.push((Cause::StickForSlip, "the stick stiffness, though it slips".into(), stuck));
        let beside = rows(&|k, j| match j {
            0..6 if j == k => elastic[k],
            0..6 => 0.0,
            _ => own[k][j],
        });
        let relation = "the stick stiffness, though it slips, beside the right slopes by what presses";
        found.push((Cause::StickForSlip, relation.into(), beside));
        let diagonal = rows(&|k, j| if j == k { share * elastic[k] } else { own[k][j] });
        let relation = "the limit over P of stick, times the stick stiffness, on the diagonal";
        found.push((Cause::SecantForTangent, relation.into(), diagonal));
        let secant =
            rows(&|k, j| if j < 6 { if j == k { share * elastic[k] } else { 0.0 } } else { own[k][j] });
        let relation = "the limit over P of stick, times the stick stiffness";
        found.push((Cause::SecantForTangent, relation.to_string(), secant));
        let g = parts.gradient;
        let square: f64 = sliding.iter().map(|k| elastic[*k] * g[*k] * g[*k]).sum();
        let continuum = |k: usize, j: usize| {
            let own = if k == j { elastic[k] } else { 0.0 };
            own - elastic[k] * g[k] * elastic[j] * g[j] / square
        };
        for coupled in [true, false] {
            let of = |k: usize, j: usize| match j {
                0..6 if sliding.contains(&j) => continuum(k, j),
                6..12 if coupled => own[k][j],
                0..6 if coupled => own[k][j],
                _ => 0.0,
            };
            let cause = Cause::ContinuumForConsistent;
            found.push((cause, cause.relation().to_string(), rows(&of)));
        }
        found
    }
}
