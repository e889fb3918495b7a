//! A relation at one state: its equations, rows, rates and accelerations against differences on 237-bit numbers, and laws that they meet
//! without any reference.
//!
//! The components of a carried node and of a mean are along axes that the reference node carries, so that no rigid motion of everything
//! changes them:
//!
//! | law | says |
//! |---|---|
//! | rigid modes | J r = 0 for every rigid motion r |
//! | frame | at the state turned, moved and turning, values, rates and accelerations are the same, and rows are turned |
//! | power | rates are J q̇ |
//!
//! An equation meets the last alone. Of a mean of many nodes the rows of some are differentiated again, evenly chosen; the laws see all.

use crate::case::failing::{Failing, RelationCase};
use crate::case::quantity::Quantity;
use crate::judge::bound::C;
use crate::judge::conditioned::{CLEAR, Least};
use crate::judge::outcome::Check;
use crate::judge::table::{Entry, ResultTable};
use crate::laws::checks::{ByRow, checks_of_tables};
use crate::laws::{Demand, Invariant, Term, about_third, axis, turning};
use crate::mutants::mutant::{Mistake, Mutant, of_angle, of_rate};
use crate::oracles::differences::{self, FIRST_STEP};
use crate::oracles::truth::rotation;
use crate::settings::Settings;
use pintle_kinematics::Differentiable;
use pintle_kinematics::connector::{Request, Tally};
use pintle_kinematics::measure::Unit;
use pintle_kinematics::relation::{ConstraintRow, Form, Point, Quantity as Of, Relation, place_of};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::scalar::{Scalar, U, Wide};
use pintle_kinematics::so3::exp;
use pintle_kinematics::vector::{Matrix, Vector, add, apply, cross, product, scale, sub};

/// Nodes besides the reference node whose columns are differentiated again.
const SAMPLED: usize = 8;

/// Of how many of a relation's nodes the columns are differentiated again.
pub(crate) fn differentiated(nodes: usize) -> usize {
    let others = nodes.saturating_sub(1);
    nodes.min(1 + others.div_ceil(others.div_ceil(SAMPLED).max(1)))
}

/// Closer to half a turn, or to whole turns of a node of an equation, (rad) nobody can say on which side a number is.
const UNDETERMINED: f64 = 1e-9;

/// A point whose degree of freedom is moved by a finite amount. Written apart from the product's variations.
fn moved<R: Differentiable>(point: &Point<R>, by: &[R; 7]) -> Point<R> {
    let turned = [by[3], by[4], by[5]];
    let is_still = turned.iter().all(|x| R::holds(x.magnitude().less(R::from_f64(f64::MIN_POSITIVE))));
    Point {
        displacement: add(point.displacement, [by[0], by[1], by[2]]),
        rotation: if is_still { point.rotation } else { product(&exp(turned), &point.rotation) },
        vector: add(point.vector, turned),
        flow: point.flow + by[6],
        ..*point
    }
}

fn evaluated<R: Differentiable>(
    relation: &Relation<R>,
    points: &[Point<R>],
    request: &Request,
) -> Vec<ConstraintRow<R>> {
    relation.evaluate(points, request, &mut Tally::default())
}

fn values(relation: &Relation<Wide>, points: &[Point<Wide>]) -> Vec<Wide> {
    evaluated(relation, points, &Request::nothing(0)).into_iter().map(|row| row.residual).collect()
}

impl RelationCase {
    /// The size of a degree of freedom.
    fn size(&self, number: u8) -> f64 {
        if (4..=6).contains(&number) { 1.0 } else { self.length }
    }

    /// The magnitude of what is rounded.
    fn input(&self, (place, number): (usize, u8)) -> f64 {
        let Some(point) = self.nodes.get(place) else { return 0.0 };
        match (self.relation.form(), number) {
            (Form::Linear(_), 4..=6) => norm(point.vector).max(1.0),
            (_, 1..=3) => self.length.max(point.displacement[usize::from(number) - 1].abs()),
            (_, 4..=6) => 1.0,
            _ => self.length.max(point.flow.abs()),
        }
    }

    /// min(1, the distance to where a rotation vector has no derivatives).
    fn nearness(&self) -> f64 {
        let Form::Linear(terms) = self.relation.form() else { return 1.0 };
        let turning = terms.iter().filter(|term| term.quantity == Of::Rotation);
        let angles = turning.filter_map(|term| Some(norm(self.nodes.get(term.place)?.vector)));
        let far = angles.filter(|angle| *angle > 3.0);
        far.map(|angle| 2.0 * (angle / 2.0).sin().abs() / angle).fold(1.0, f64::min)
    }

    fn said(&self) -> Vec<ConstraintRow<f64>> {
        evaluated(&self.relation, &self.nodes, &Request::everything(1))
    }

    /// The conditioned scale of a row: its value, and what the rounding of every input makes of it.
    fn scale(&self, row: &ConstraintRow<f64>) -> f64 {
        let of = self.relation.columns().iter().zip(&row.gradient);
        let sum: f64 = of.map(|(column, slope)| slope.abs() * self.input(*column)).sum();
        (row.residual.abs() + sum) / self.nearness().max(UNDETERMINED)
    }

    /// The scales of the numbers of a row, by quantity, as in the bound of connectors. A second derivative of an equation by a rotation is no larger
    /// than the derivatives that are turned.
    fn scales(&self, row: &ConstraintRow<f64>) -> [Vec<f64>; RelationCase::QUANTITIES.len()] {
        let f = self.scale(row);
        let columns = self.relation.columns();
        let first: Vec<f64> = columns.iter().map(|(_, number)| 2.0 * f / self.size(*number)).collect();
        let rates = |of: fn(&Point<f64>) -> &[f64; 7]| {
            let rate = |(place, number): &(usize, u8)| of(&self.nodes[*place])[place_of(*number)].abs();
            columns.iter().map(rate).collect::<Vec<f64>>()
        };
        let (velocity, acceleration) = (rates(|point| &point.velocity), rates(|point| &point.acceleration));
        let along = |rates: &[f64]| first.iter().zip(rates).map(|(x, rate)| x * rate).sum::<f64>();
        let sizes = columns.iter().map(|(_, number)| self.size(*number));
        let fastest = velocity.iter().zip(sizes).fold(0.0_f64, |most, (v, size)| most.max(v / size));
        let faster = along(&acceleration) + 8.0 * f * fastest * fastest;
        let rate = along(&velocity);
        [vec![f], first, vec![rate], vec![faster]]
    }

    /// From which sizes on numbers of a row are significant, in units of S, where it is well-conditioned: an equation has any unit. Second
    /// derivatives are no larger than what is turned.
    fn least(&self, row: &ConstraintRow<f64>) -> Option<Least> {
        let columns = self.relation.columns();
        let sized = |of: &dyn Fn((usize, u8)) -> f64| -> f64 {
            columns.iter().zip(&row.gradient).map(|(column, slope)| slope.abs() * of(*column)).sum()
        };
        let (s, inputs) = (sized(&|(_, number)| self.size(number)), sized(&|column| self.input(column)));
        let fastest = |of: fn(&Point<f64>) -> &[f64; 7]| {
            let rate = |(place, number): &(usize, u8)| {
                of(&self.nodes[*place])[place_of(*number)].abs() / self.size(*number)
            };
            columns.iter().map(rate).fold(0.0, f64::max)
        };
        let rates = [fastest(|point| &point.velocity), fastest(|point| &point.acceleration)];
        let is_plain = s > 0.0 && inputs <= 30.0 * s && self.nearness() >= CLEAR;
        is_plain.then(|| Least::of((row.residual, s, s), s, rates)).flatten()
    }

    /// Why nobody can say what the numbers must be, at some states.
    fn undetermined(&self) -> Option<&'static str> {
        if self.relation.to_half_turn(&self.nodes).is_some_and(|distance| distance < UNDETERMINED) {
            return Some(
                "S is turned by half a turn from where the constraint has it: rounding decides the sign of ρ",
            );
        }
        (self.nearness() < UNDETERMINED).then_some(
            "a node of the equation is turned by whole turns: its rotation vector has no derivatives there",
        )
    }

    /// The columns that are differentiated again.
    fn sampled(&self) -> Vec<usize> {
        let columns = self.relation.columns();
        let others = self.nodes.len().saturating_sub(1);
        let step = others.div_ceil(SAMPLED).max(1);
        let is_taken = |place: usize| place == 0 || (place - 1).is_multiple_of(step);
        (0..columns.len()).filter(|at| is_taken(columns[*at].0)).collect()
    }

    /// The numbers at this state, and what they must be.
    pub fn tables(&self) -> Vec<ResultTable> {
        if let Some(why) = self.undetermined() {
            return Self::QUANTITIES.map(|quantity| ResultTable::unanswered(quantity, why)).into();
        }
        let got = self.said();
        let relation: Relation<Wide> = self.relation.exact();
        let given: Vec<Point<Wide>> = self.nodes.iter().map(Point::exact).collect();
        let mut points = given.clone();
        points.iter_mut().for_each(|point| point.rotation = rotation(point.rotation));
        let still = values(&relation, &points);
        let columns = self.relation.columns();
        let sampled = self.sampled();
        let near = self.nearness();
        let first: Vec<Vec<Wide>> = sampled
            .iter()
            .map(|at| {
                let (place, number) = columns[*at];
                let h = Wide::from_f64(FIRST_STEP * near * self.size(number));
                let mut side = |h: Wide| {
                    let mut by = [Wide::zero(); 7];
                    by[place_of(number)] = h;
                    let before = points[place];
                    points[place] = moved(&before, &by);
                    let found = values(&relation, &points);
                    points[place] = before;
                    found
                };
                let (ahead, behind) = (side(h), side(-h));
                ahead.into_iter().zip(behind).map(|(ahead, behind)| (ahead - behind) / (h + h)).collect()
            })
            .collect();
        let [rates, accelerations] = self.along(&relation, &points, &still);
        let value = values(&relation, &given);
        let mut tables: Vec<ResultTable> = Self::QUANTITIES.map(ResultTable::new).into();
        for (k, ((name, unit), row)) in self.relation.rows().into_iter().zip(&got).enumerate() {
            let of = |of: &[Wide]| vec![of.get(k).copied().unwrap_or_else(Wide::zero)];
            let wanted = [
                of(&value),
                first.iter().map(|by| by.get(k).copied().unwrap_or_else(Wide::zero)).collect(),
                of(&rates),
                of(&accelerations),
            ];
            let numbers = [
                vec![row.residual],
                sampled.iter().map(|at| row.gradient.get(*at).copied().unwrap_or(f64::NAN)).collect(),
                vec![row.rate.unwrap_or(f64::NAN)],
                vec![row.acceleration.unwrap_or(f64::NAN)],
            ];
            let (scales, least) = (self.scales(row), self.least(row));
            for (((table, scales), got), wanted) in tables.iter_mut().zip(scales).zip(numbers).zip(wanted) {
                let row_name = match table.quantity {
                    Quantity::FirstDerivatives => format!("∂{name}"),
                    Quantity::Rate => format!("d{name}/dt"),
                    Quantity::Acceleration => format!("d²{name}/dt²"),
                    _ => name.to_string(),
                };
                for (i, (got, want)) in got.into_iter().zip(wanted).enumerate() {
                    let (entry_name, scale, class) = match table.quantity {
                        Quantity::FirstDerivatives => {
                            let (place, number) = columns[sampled[i]];
                            let column = self.column(place, number);
                            let scale = scales.get(sampled[i]).copied().unwrap_or_default();
                            (format!("{row_name}/∂{column}"), scale, usize::from((4..=6).contains(&number)))
                        }
                        _ => (row_name.clone(), scales.first().copied().unwrap_or_default(), 0),
                    };
                    let class = (usize::from(unit == Unit::Angle), class, 0);
                    let size = match table.quantity {
                        Quantity::FirstDerivatives => self.size(columns[sampled[i]].1),
                        _ => 1.0,
                    };
                    let is_demanded = least.is_some_and(|least| least.demands(table.quantity, got, size));
                    table
                        .entries
                        .push(Entry { is_demanded, ..Entry::new(entry_name, got, want, scale, class) });
                }
                table.rows.push(row_name);
            }
        }
        for table in &mut tables {
            if table.quantity == Quantity::FirstDerivatives {
                let name = |at: &usize| self.column(columns[*at].0, columns[*at].1);
                table.columns = sampled.iter().map(name).collect();
            }
            table.mistakes = self.mistakes(table, &got);
        }
        tables
    }

    /// The name of a column; of several nodes alike, with the place of the node.
    fn column(&self, place: usize, number: u8) -> String {
        let name = self.relation.column_name(place, number);
        if matches!(self.relation.role(place), "S" | "M") {
            name.to_string()
        } else {
            format!("{name}({place})")
        }
    }

    /// Rates and accelerations by differences along q(t) = q̇ t + q̈ t²/2.
    fn along(&self, relation: &Relation<Wide>, points: &[Point<Wide>], still: &[Wide]) -> [Vec<Wide>; 2] {
        let speed = |point: &Point<Wide>| {
            differences::speed(&point.velocity, &point.acceleration, |j| {
                if (3..6).contains(&j) { 1.0 } else { self.length }
            })
        };
        let [first, second] =
            differences::times(self.nearness(), points.iter().map(speed).fold(0.0, f64::max))
                .map(Wide::from_f64);
        let after = |t: Wide| {
            let carried = |point: &Point<Wide>| {
                moved(point, &differences::carried_on(&point.velocity, &point.acceleration, t))
            };
            values(relation, &points.iter().map(carried).collect::<Vec<_>>())
        };
        let both = |h: Wide| after(-h).into_iter().zip(after(h));
        let rates = both(first).map(|(behind, ahead)| (ahead - behind) / (first + first)).collect();
        let accelerations = both(second)
            .zip(still)
            .map(|((behind, ahead), still)| differences::acceleration([behind, *still, ahead], second))
            .collect();
        [rates, accelerations]
    }

    /// Mistakes in more than a single entry.
    fn mistakes(&self, table: &ResultTable, got: &[ConstraintRow<f64>]) -> Vec<Mutant> {
        let width = table.width();
        let rows = self.relation.rows();
        let mut found = Vec::new();
        let mut add = |mistake: Mistake, changes: Vec<(usize, usize, f64)>| {
            found.push(Mutant::many(mistake, changes));
        };
        for (k, ((_, unit), row)) in rows.iter().zip(got).enumerate() {
            let is_angle = *unit == Unit::Angle;
            let want = |i: usize| table.want(k, i);
            let along = |of: fn(&Point<f64>) -> &[f64; 7]| -> Vec<f64> {
                let rate = |(place, number): &(usize, u8)| of(&self.nodes[*place])[place_of(*number)];
                self.relation.columns().iter().map(rate).collect()
            };
            match table.quantity {
                Quantity::Value if is_angle => {
                    of_angle(want(0), 0.0).for_each(|(mistake, x)| add(mistake, vec![(k, 0, x)]));
                }
                Quantity::FirstDerivatives => {
                    for i in (0..width.saturating_sub(1)).filter(|i| i % 3 < 2) {
                        add(Mistake::ColumnsSwapped, vec![(k, i, want(i + 1)), (k, i + 1, want(i))]);
                    }
                }
                Quantity::Rate | Quantity::Acceleration => {
                    let is_acceleration = table.quantity == Quantity::Acceleration;
                    let rates =
                        if is_acceleration { along(|p| &p.acceleration) } else { along(|p| &p.velocity) };
                    of_rate(want(0), (&row.gradient, &rates), (is_angle, is_acceleration))
                        .for_each(|(mistake, x)| add(mistake, vec![(k, 0, x)]));
                }
                _ => {}
            }
            for other in (0..k).filter(|other| rows[*other].1 == *unit) {
                let of = |to: usize, from: usize| {
                    (0..width).map(move |i| (to, i, table.want(from, i))).collect::<Vec<_>>()
                };
                add(Mistake::RowsSwapped, [of(k, other), of(other, k)].concat());
            }
        }
        found
    }

    /// All checks at this state, if differences on 237 bits are among the oracles asked; with mutants where `proves`.
    pub fn audit(&self, settings: &Settings, proves: bool) -> Vec<Check> {
        if !settings.asks_for_everything() {
            return Vec::new();
        }
        let mut tables = self.tables();
        if let Some(planted) = settings.planted {
            tables.iter_mut().for_each(|table| planted.spoil_table(table));
        }
        let mut checks: Vec<Check> =
            tables.iter().map(|table| table.check(proves, &self.name, None)).collect();
        checks.extend(self.laws(&tables, proves));
        for check in &mut checks {
            check.fails_at(|| Failing::Relation(Box::new(self.clone())));
        }
        checks
    }

    /// Where a node is, from an origin that moves with nothing.
    fn positions(&self) -> Vec<Vector<f64>> {
        let initial = |place: usize| match (self.relation.form(), place) {
            (Form::Carried { arm, .. }, 0) => *arm,
            (Form::Mean { lever, .. }, 0) => *lever,
            (Form::Mean { shares, .. }, place) => shares.get(place - 1).map_or([0.0; 3], |share| share.arm),
            _ => [0.0; 3],
        };
        let at = |(place, point): (usize, &Point<f64>)| add(initial(place), point.displacement);
        self.nodes.iter().enumerate().map(at).collect()
    }

    fn is_invariant(&self) -> bool {
        !matches!(self.relation.form(), Form::Linear(_))
    }

    /// J r = 0 for the translations and the turns about a point among the nodes.
    fn rigid_modes(&self, numbers: &ByRow, tolerance: &ByRow) -> Vec<Demand> {
        let positions = self.positions();
        let from = positions.get(1).copied().unwrap_or_default();
        let mut found = Vec::new();
        for (k, (name, _)) in self.relation.rows().into_iter().enumerate() {
            for i in 0..3 {
                let mut translation: Vec<Term> = Vec::new();
                let mut rotation: Vec<Term> = Vec::new();
                for (at, (place, number)) in self.relation.columns().iter().enumerate() {
                    let j = place_of(*number) % 3;
                    if (1..=3).contains(number) {
                        let lever = cross(axis(i), sub(positions[*place], from))[j];
                        translation.extend((i == j).then_some((Quantity::FirstDerivatives, k, at, 1.0)));
                        rotation.push((Quantity::FirstDerivatives, k, at, lever));
                    } else if i == j {
                        rotation.push((Quantity::FirstDerivatives, k, at, 1.0));
                    }
                }
                rotation.retain(|term| term.3 != 0.0);
                for (terms, what) in [(translation, "translation"), (rotation, "turn")] {
                    if !terms.is_empty() {
                        let what = format!("∂{name} along {what} {}", i + 1);
                        found.push(Demand::said(terms, 0.0, what, (numbers, tolerance)));
                    }
                }
            }
        }
        found
    }

    /// The state turned and moved, which goes on turning.
    fn twin(&self) -> (Self, Matrix<f64>) {
        let is_planar = self.relation.is_planar();
        let matrix = exp(turning(is_planar));
        let speed = |of: fn(&Point<f64>) -> &[f64; 7]| {
            let largest = self.nodes.iter().flat_map(of).fold(0.0_f64, |most, x| most.max(x.abs()));
            if largest > 0.0 { largest.min(1.0) } else { 1.0 }
        };
        let spin = about_third(is_planar, scale([0.6, 0.3, -0.5], speed(|point| &point.velocity)));
        let spin_rate = about_third(is_planar, scale([-0.2, 0.7, 0.4], speed(|point| &point.acceleration)));
        let positions = self.positions();
        let from = positions.get(1).copied().unwrap_or_default();
        let mut twin = self.clone();
        for (point, at) in twin.nodes.iter_mut().zip(&positions) {
            let old = *point;
            let turned = |v: Vector<f64>| apply(&matrix, v);
            let three = |of: &[f64; 7], at: usize| [of[at], of[at + 1], of[at + 2]];
            let (initial, arm) = (sub(*at, old.displacement), turned(sub(*at, from)));
            point.displacement = sub(add(from, arm), initial);
            point.rotation = product(&matrix, &old.rotation);
            let (v, omega) = (turned(three(&old.velocity, 0)), turned(three(&old.velocity, 3)));
            let (a, alpha) = (turned(three(&old.acceleration, 0)), turned(three(&old.acceleration, 3)));
            let velocity = [add(v, cross(spin, arm)), add(omega, spin)];
            let swung = add(cross(spin_rate, arm), cross(spin, cross(spin, arm)));
            let acceleration = [
                add(add(a, scale(cross(spin, v), 2.0)), swung),
                add(add(alpha, spin_rate), cross(spin, omega)),
            ];
            for (i, (v, a)) in
                velocity.into_iter().flatten().zip(acceleration.into_iter().flatten()).enumerate()
            {
                (point.velocity[i], point.acceleration[i]) = (v, a);
            }
        }
        (twin, matrix)
    }

    fn frame(&self, numbers: &ByRow, tolerance: &ByRow) -> Vec<Demand> {
        let (twin, matrix) = self.twin();
        if twin.undetermined().is_some()
            || twin.relation.to_half_turn(&twin.nodes).is_some_and(|far| far < 1e-3)
        {
            return Vec::new();
        }
        let rows = twin.said();
        let columns = self.relation.columns();
        let mut found = Vec::new();
        for (k, ((name, _), row)) in self.relation.rows().into_iter().zip(&rows).enumerate() {
            let scales = twin.scales(row);
            let mut demand = |quantity: Quantity, at: usize, want: f64, scale: f64, what: String| {
                let mut demand = Demand::said(vec![(quantity, k, at, 1.0)], want, what, (numbers, tolerance));
                // The turned inputs are rounded, three roundings in each direction.
                demand.allowed = 4.0 * (demand.allowed + 3.0 * C * U * scale);
                found.push(demand);
            };
            let one = |scales: &[f64]| scales.first().copied().unwrap_or(f64::INFINITY);
            let alone = [
                (Quantity::Value, Some(row.residual), one(&scales[0]), format!("{name} in turned axes")),
                (Quantity::Rate, row.rate, one(&scales[2]), format!("d{name}/dt in turned axes")),
                (
                    Quantity::Acceleration,
                    row.acceleration,
                    one(&scales[3]),
                    format!("d²{name}/dt² in turned axes"),
                ),
            ];
            for (quantity, want, scale, what) in alone {
                demand(quantity, 0, want.unwrap_or(f64::NAN), scale, what);
            }
            for (at, (place, number)) in columns.iter().enumerate().filter(|(_, (_, number))| *number <= 6) {
                let j = place_of(*number) % 3;
                let first = *number - j as u8;
                let entry = |i: usize| {
                    let found = columns.binary_search(&(*place, first + i as u8)).ok();
                    found.and_then(|at| row.gradient.get(at)).copied().unwrap_or_default()
                };
                let want = (0..3).map(|i| matrix[i][j] * entry(i)).sum();
                let what = format!("∂{name}/∂{} in turned axes", self.column(*place, *number));
                demand(Quantity::FirstDerivatives, at, want, scales[1][at], what);
            }
        }
        found
    }

    fn power(&self, numbers: &ByRow, tolerance: &ByRow) -> Vec<Demand> {
        let mut found = Vec::new();
        for (k, (name, _)) in self.relation.rows().into_iter().enumerate() {
            let mut terms: Vec<Term> = vec![(Quantity::Rate, k, 0, -1.0)];
            for (at, (place, number)) in self.relation.columns().iter().enumerate() {
                let rate = self.nodes[*place].velocity[place_of(*number)];
                terms.push((Quantity::FirstDerivatives, k, at, rate));
            }
            found.push(Demand::said(terms, 0.0, format!("d{name}/dt is J q̇"), (numbers, tolerance)));
        }
        found
    }

    fn demands(&self, law: Invariant, numbers: &ByRow, tolerance: &ByRow) -> Vec<Demand> {
        match law {
            Invariant::RigidModes if self.is_invariant() => self.rigid_modes(numbers, tolerance),
            Invariant::Frame if self.is_invariant() => self.frame(numbers, tolerance),
            Invariant::Power => self.power(numbers, tolerance),
            _ => Vec::new(),
        }
    }

    /// The numbers that laws relate, those of the tables where they have them, and how far each may be off.
    fn related(&self, tables: &[ResultTable]) -> (ByRow, ByRow) {
        let got = self.said();
        let one = |x: Option<f64>| vec![x.unwrap_or(f64::NAN)];
        let of = |row: &ConstraintRow<f64>| {
            [vec![row.residual], row.gradient.clone(), one(row.rate), one(row.acceleration)]
        };
        let allowed = |row: &ConstraintRow<f64>| {
            self.scales(row).map(|scales| scales.into_iter().map(|scale| C * U * scale).collect())
        };
        let mut numbers = ByRow::of(Self::QUANTITIES, got.iter().map(of).enumerate());
        let sampled = self.sampled();
        for table in tables {
            for (i, entry) in table.entries.iter().enumerate() {
                let place = placed(&sampled, table.quantity, i % table.width()).unwrap_or_default();
                numbers.put(table.quantity, i / table.width(), place, entry.got);
            }
        }
        (numbers, ByRow::of(Self::QUANTITIES, got.iter().map(allowed).enumerate()))
    }

    /// What relates the numbers to each other; with mutants of them where `proves`.
    fn laws(&self, tables: &[ResultTable], proves: bool) -> Vec<Check> {
        if self.undetermined().is_some() {
            return Vec::new();
        }
        let (numbers, tolerance) = self.related(tables);
        let sampled = self.sampled();
        let place = |quantity, row: usize, i: usize| Some((row, placed(&sampled, quantity, i)?));
        let size = |quantity: Quantity, at: usize| match (quantity, self.relation.columns().get(at)) {
            (Quantity::FirstDerivatives, Some((_, number))) => self.size(*number),
            _ => 1.0,
        };
        let (of, how) = ((&numbers, tables), (self.name.as_str(), proves));
        let demands = |law| self.demands(law, &numbers, &tolerance);
        checks_of_tables(&Self::LAWS, of, how, demands, place, size)
    }

    /// The sum that a law demands something of, by the words in which it is told.
    pub(crate) fn sum_of_law(&self, law: Invariant, what: &str) -> Option<f64> {
        let (numbers, tolerance) = self.related(&self.tables());
        Demand::sum_of(self.demands(law, &numbers, &tolerance), what, &numbers)
    }
}

/// Where in a row a number stands that a table has: the columns that are differentiated again are some of all.
fn placed(sampled: &[usize], quantity: Quantity, i: usize) -> Option<usize> {
    if quantity == Quantity::FirstDerivatives { sampled.get(i).copied() } else { Some(i) }
}
