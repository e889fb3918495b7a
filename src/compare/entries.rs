//! Matrices of another program, entry by entry: constraint Jacobians and tangents of nodal forces.

use crate::column::{Map, MatrixKind, Motion};
use crate::evaluate::Evaluator;
use crate::judge::{Point, ROUNDINGS, Series};
use crate::matrix::{self, Entries};
use crate::motion::{Motions, shift};
use crate::read::{Frame, Results};
use pintle_check::{Angle, Variation};
use pintle_kinematics::connector::Output;
use pintle_kinematics::measure::Unit;
use pintle_kinematics::mpc::MpcType;
use pintle_kinematics::vector::Matrix;
use pintle_model::behavior::state::Velocities;
use pintle_model::evaluate::{Fixed, Freedom, Item, Jacobian, Model, Plan, Selection, Sequence, Source};
use pintle_scene::{ElementForces, Label, Scene, State};
use std::collections::BTreeMap;
use std::convert::Infallible;
use std::path::PathBuf;

/// So many entries are compared as they are alone.
const LARGE: usize = 100_000;

/// A wrong entry costs as much as five departures from pintle's conventions.
const WRONG: usize = 5;

/// An entry that is right, and by how much the digits of the motion leave it open.
#[derive(Clone, Copy, Debug, Default)]
struct Number {
    x: f64,
    off: f64,
}

/// What a matrix must be at one state.
struct Right {
    kind: MatrixKind,
    /// Of each row its name and unit; of each column its degree of freedom.
    rows: Vec<(String, Unit)>,
    columns: Vec<Freedom>,
    at: BTreeMap<(usize, usize), Number>,
}

/// How a matrix departs from pintle's.
#[derive(Clone, Copy, Debug)]
struct Departure {
    is_transposed: bool,
    order: Order,
    variation: Variation,
    /// Displacements of each node along its own axes.
    is_own: bool,
    sign: f64,
    /// Lengths of rows and of columns, angles of rows and of columns: the factors of entries.
    factors: [f64; 4],
    cost: usize,
}

/// In which order the columns are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Order {
    Node,
    Kind,
    Freedom,
}

impl Order {
    const ALL: [(Self, &'static str); 3] = [
        (Self::Node, ""),
        (Self::Kind, "columns are displacements of all nodes first, then rotations"),
        (Self::Freedom, "columns are degree of freedom 1 of all nodes first, then 2 …"),
    ];

    /// The place of each of pintle's columns.
    fn places(self, columns: &[Freedom]) -> Vec<usize> {
        let mut order: Vec<usize> = (0..columns.len()).collect();
        let key = |n: &usize| {
            let Freedom { node, number } = columns[*n];
            match self {
                Self::Node => (0, node, number),
                Self::Kind => (number.saturating_sub(1) / 3, node, number),
                Self::Freedom => (number, node, number),
            }
        };
        order.sort_by_key(key);
        let mut places = vec![0; columns.len()];
        for (place, n) in order.into_iter().enumerate() {
            places[n] = place;
        }
        places
    }
}

/// Each of some departures with each choice.
fn spread<T: Copy>(found: &mut Vec<Departure>, choices: &[T], set: impl Fn(&mut Departure, T)) {
    let with = |one: &Departure, choice: T| {
        let mut one = *one;
        set(&mut one, choice);
        one
    };
    *found = found.iter().flat_map(|one| choices.iter().map(|choice| with(one, *choice))).collect();
}

const LENGTHS: [(f64, &str); 3] = [(1.0, ""), (1e3, "mm of a scene in m"), (1e-3, "m of a scene in mm")];

impl Departure {
    /// All, the simplest first.
    fn all(kind: MatrixKind) -> Vec<Self> {
        let degree = Angle::Degree.size();
        let is_jacobian = kind == MatrixKind::Jacobian;
        let only = |count: usize| if is_jacobian { count } else { 1 };
        let none = Self {
            is_transposed: false,
            order: Order::Node,
            variation: Variation::Spatial,
            is_own: false,
            sign: 1.0,
            factors: [1.0; 4],
            cost: 0,
        };
        let lengths = LENGTHS.map(|(factor, _)| factor);
        let mut found = vec![none];
        spread(&mut found, &[false, true], |one, is| one.is_transposed = is);
        spread(&mut found, &Order::ALL.map(|(order, _)| order), |one, order| one.order = order);
        spread(&mut found, &Variation::ALL[..only(Variation::ALL.len())], |one, of| one.variation = of);
        spread(&mut found, &[false, true][..only(2)], |one, is| one.is_own = is);
        spread(&mut found, &[1.0, -1.0], |one, sign| one.sign = sign);
        spread(&mut found, &lengths, |one, row| one.factors[0] = row);
        spread(&mut found, &lengths, |one, column| one.factors[1] = 1.0 / column);
        spread(&mut found, &[1.0, 1.0 / degree], |one, angle| one.factors[2] = angle);
        spread(&mut found, &[1.0, degree], |one, by| one.factors[3] = by);
        for one in &mut found {
            let order = Order::ALL.iter().position(|(order, _)| *order == one.order).unwrap_or(0);
            let variation = Variation::ALL.iter().position(|of| *of == one.variation).unwrap_or(0);
            let [row, column, ..] = one.factors;
            let changed = [one.is_transposed, one.is_own, one.sign < 0.0, row * column != 1.0];
            let changed = changed.into_iter().chain(one.factors.map(|factor| factor != 1.0));
            one.cost = order + variation.min(2) + changed.filter(|is| *is).count();
        }
        found.sort_by_key(|one| one.cost);
        found
    }

    fn words(&self) -> String {
        let mut words: Vec<String> = Vec::new();
        if self.is_transposed {
            words.push("the matrix is transposed".into());
        }
        words.extend(
            Order::ALL
                .iter()
                .filter(|(order, text)| *order == self.order && !text.is_empty())
                .map(|(_, text)| (*text).to_string()),
        );
        match self.variation {
            Variation::Spatial => {}
            Variation::Body => words.push("rotations vary about the axes of each node (body)".into()),
            Variation::TotalVector => words.push("rotations are varied as total rotation vectors".into()),
            other => words.push(format!("rotations are varied as {}", other.name())),
        }
        if self.is_own {
            words.push("displacements are along the axes of each node".into());
        }
        if self.sign < 0.0 {
            words.push("every sign is the opposite".into());
        }
        let [row, column, angle, by] = self.factors;
        let length = |x: f64| LENGTHS.iter().find(|(factor, _)| *factor == x).map_or("", |(_, words)| *words);
        if row != 1.0 {
            words.push(format!("lengths of rows are in {}", length(row)));
        }
        if column != 1.0 {
            words.push(format!("lengths of columns are in {}", length(1.0 / column)));
        }
        if angle != 1.0 {
            words.push("angles of rows are in degrees".into());
        }
        if by != 1.0 {
            words.push("it is by rotations in degrees".into());
        }
        words.join("; ")
    }
}

/// How nodes are turned.
type Turned = BTreeMap<Label, Matrix<f64>>;

impl Right {
    /// In the conventions of a departure.
    fn departed(&self, by: &Departure, turned: &Turned) -> BTreeMap<(usize, usize), Number> {
        let mut at = self.at.clone();
        if by.variation != Variation::Spatial {
            self.vary(&mut at, (by.variation, 4), turned);
        }
        if by.is_own {
            self.vary(&mut at, (Variation::Body, 1), turned);
        }
        let places = by.order.places(&self.columns);
        let [row, column, angle, turn] = by.factors;
        let of_column = |j: usize| if matches!(self.columns[j].number, 4..=6) { turn } else { column };
        at.into_iter()
            .map(|((i, j), number)| {
                let of_row = match self.rows[i].1 {
                    Unit::Length => row,
                    Unit::Angle => angle,
                    Unit::None => 1.0,
                };
                let factor = by.sign * of_row * of_column(j);
                let place = match self.kind {
                    MatrixKind::Jacobian => (i, places[j]),
                    MatrixKind::Stiffness => (places[i], places[j]),
                };
                let place = if by.is_transposed { (place.1, place.0) } else { place };
                (place, Number { x: factor * number.x, off: factor.abs() * number.off })
            })
            .collect()
    }

    /// Derivatives by other variations of rotations, or by displacements along other axes: of three degrees of freedom from a number on.
    fn vary(
        &self,
        at: &mut BTreeMap<(usize, usize), Number>,
        (variation, number): (Variation, usize),
        turned: &Turned,
    ) {
        let first = |n: &usize| {
            let is = |i: usize| {
                self.columns.get(n + i).is_some_and(|of| {
                    of.node == self.columns[*n].node && usize::from(of.number) == number + i
                })
            };
            is(0) && is(1) && is(2)
        };
        let blocks: Vec<(usize, Matrix<f64>)> = (0..self.columns.len())
            .filter(first)
            .filter_map(|n| Some((n, variation.of_rotation(turned.get(&self.columns[n].node)?))))
            .collect();
        for i in 0..self.rows.len() {
            for (n, jacobian) in &blocks {
                let given = [0, 1, 2].map(|m| at.get(&(i, n + m)).copied().unwrap_or_default());
                if given.iter().all(|number| number.x == 0.0 && number.off == 0.0) {
                    continue;
                }
                for m in 0..3 {
                    let x = (0..3).map(|l| jacobian[l][m] * given[l].x).sum();
                    let off = (0..3)
                        .map(|l| jacobian[l][m].abs() * (given[l].off + f64::EPSILON * given[l].x.abs()))
                        .sum();
                    at.insert((i, n + m), Number { x, off });
                }
            }
        }
    }

    fn name(&self, (i, j): (usize, usize), by: &Departure) -> String {
        let (i, j) = if by.is_transposed { (j, i) } else { (i, j) };
        let places = by.order.places(&self.columns);
        let back = |place: usize| places.iter().position(|of| *of == place).unwrap_or(0);
        let freedom = |n: usize| {
            let Freedom { node, number } = self.columns[n];
            match number {
                1..=3 => format!("{node}.u{number}"),
                4..=6 => format!("{node}.ur{}", number - 3),
                _ => format!("{node}.flow"),
            }
        };
        let row = match self.kind {
            MatrixKind::Jacobian => self.rows[i].0.clone(),
            MatrixKind::Stiffness => format!("force at {}", freedom(back(i))),
        };
        format!("∂{row}/∂{}", freedom(back(j)))
    }
}

/// The entries that are wrong, were the matrix one of this departure; no more than so many are looked for.
fn wrong(
    given: &Entries,
    right: &BTreeMap<(usize, usize), Number>,
    most: usize,
) -> Vec<((usize, usize), Point)> {
    let mut scale = vec![0.0_f64; given.rows];
    for ((i, _), number) in right {
        if let Some(scale) = scale.get_mut(*i) {
            *scale = scale.max(number.x.abs());
        }
    }
    let mut found = Vec::new();
    let beside = given.at.keys().filter(|at| !right.contains_key(at)).map(|at| (at, Number::default()));
    for (at, number) in right.iter().map(|(at, number)| (at, *number)).chain(beside) {
        if found.len() > most {
            break;
        }
        let got = given.at.get(at).copied().unwrap_or_default();
        let allowed = got.half + number.off + ROUNDINGS * scale.get(at.0).copied().unwrap_or(0.0).max(1e-3);
        let point = Point { at: 0.0, got: got.x, want: number.x, allowed };
        if point.is_wrong() {
            found.push((*at, point));
        }
    }
    found
}

/// What matrices are compared with.
struct Comparing<'a> {
    scene: &'a Scene,
    evaluator: Evaluator<'a>,
    plan: &'a Plan,
    /// Nodes that share no element.
    classes: Vec<Vec<Label>>,
}

impl Comparing<'_> {
    /// The Jacobian or stiffness at a state, without the digits of the motion.
    fn at(
        &self,
        before: &Sequence<'_>,
        state: &State,
        (kind, fixed): (MatrixKind, &Fixed),
    ) -> Result<Right, String> {
        let (model, plan) = (self.evaluator.model, self.plan);
        let jacobian = Jacobian::of_constraints(model, plan, fixed);
        let columns = jacobian.freedoms().to_vec();
        let mut at = BTreeMap::new();
        if kind == MatrixKind::Jacobian {
            let mut values = Vec::new();
            before.clone().assemble(state, &jacobian, &mut values).map_err(|error| error.to_string())?;
            let unit = |source: Source, k: usize| match source {
                Source::Connector(n) => {
                    model.connectors[n].connector.differentiated(k).map_or(Unit::None, |of| of.unit())
                }
                Source::Mpc(_) => MpcType::row_unit(k),
                Source::Relation(_) => Unit::None,
            };
            let rows = jacobian.equations().iter().map(|of| (of.title(model), unit(of.source, of.component)));
            for i in 0..jacobian.rows() {
                let entries = jacobian.range(i).unwrap_or_default();
                for (j, x) in jacobian.row(i).iter().zip(&values[entries]) {
                    at.insert((i, *j as usize), Number { x: *x, off: 0.0 });
                }
            }
            return Ok(Right { kind, rows: rows.collect(), columns, at });
        }
        let place: BTreeMap<Freedom, usize> = columns.iter().enumerate().map(|(n, of)| (*of, n)).collect();
        let mut lacking = None;
        let Ok(()) = before.clone().visit(state, |item| -> Result<(), Infallible> {
            let Item::Connector(result) = item else { return Ok(()) };
            let element = &model.connectors[result.index];
            let Some(tangent) = result.forces.as_ref().and_then(|forces| forces.tangent.as_ref()) else {
                if (0..6).any(|k| element.connector.has_force(k)) {
                    lacking.get_or_insert_with(|| element.title());
                }
                return Ok(());
            };
            let freedom = |j: usize| {
                const NUMBERS: [u8; 7] = [1, 2, 3, 4, 5, 6, 10];
                let node = element.nodes[j / 7]?;
                place.get(&Freedom { node, number: NUMBERS[j % 7] }).copied()
            };
            for (i, line) in tangent.iter().enumerate().filter_map(|(i, line)| Some((freedom(i)?, line))) {
                for (j, x) in line.iter().enumerate().filter_map(|(j, x)| Some((freedom(j)?, x))) {
                    at.entry((i, j)).or_insert_with(Number::default).x += x;
                }
            }
            Ok(())
        });
        if let Some(title) = lacking {
            return Err(format!(
                "the tangent of {title} needs the forces of all its components: add CTF to *EL PRINT"
            ));
        }
        let unit = |of: &Freedom| if matches!(of.number, 4..=6) { Unit::None } else { Unit::Length };
        // A moment by a length, a force by one: the unit of a row is that of its work.
        let rows = columns.iter().map(|of| (String::new(), unit(of))).collect();
        Ok(Right { kind, rows, columns, at })
    }

    /// The same with the digits of the motion.
    fn with_digits(
        &self,
        before: &Sequence<'_>,
        (state, frame, motions): (&State, &Frame, &Motions),
        of: (MatrixKind, &Fixed),
    ) -> Result<Right, String> {
        let mut right = self.at(before, state, of)?;
        let digits: BTreeMap<Label, Vec<(Motion, f64)>> = frame
            .nodes
            .iter()
            .filter_map(|(node, all)| {
                let known = all.iter().filter(|(_, of)| of.half > 0.0).map(|(motion, of)| (*motion, of.half));
                Some((*motions.labels.get(node)?, known.collect()))
            })
            .collect();
        let most = digits.values().map(Vec::len).max().unwrap_or(0);
        for class in &self.classes {
            for n in 0..most {
                let mut moved = state.clone();
                let mut any = false;
                for label in class {
                    let digit = digits.get(label).and_then(|all| all.get(n));
                    if let (Some((motion, half)), Some(node)) = (digit, moved.nodes.get_mut(label)) {
                        shift(node, *motion, *half);
                        any = true;
                    }
                }
                if !any {
                    continue;
                }
                let other = self.at(before, &moved, of)?;
                for (at, number) in &mut right.at {
                    let x = other.at.get(at).map_or(0.0, |number| number.x);
                    number.off += (x - number.x).abs();
                }
            }
        }
        Ok(right)
    }

    /// The matrix of a file beside what it must be.
    fn judge(
        &self,
        (file, given): (&str, &Entries),
        before: &Sequence<'_>,
        (state, frame, motions): (&State, &Frame, &Motions),
    ) -> Result<Series, String> {
        let all = [Fixed::of(self.scene).map_err(|error| error.to_string())?, Fixed::none()];
        let map = self.evaluator.map;
        let kinds = [MatrixKind::Jacobian, MatrixKind::Stiffness];
        let mut shapes: Vec<String> = Vec::new();
        let mut right = None;
        for kind in kinds.into_iter().filter(|kind| map.matrix.is_none_or(|wanted| wanted == *kind)) {
            for fixed in &all {
                let pattern = Jacobian::of_constraints(self.evaluator.model, self.plan, fixed);
                let shape = match kind {
                    MatrixKind::Jacobian => [pattern.rows(), pattern.columns()],
                    MatrixKind::Stiffness => [pattern.columns(); 2],
                };
                let is = [given.rows, given.columns] == shape || [given.columns, given.rows] == shape;
                if is && shape[0] > 0 && right.is_none() {
                    right = Some(
                        self.with_digits(before, (state, frame, motions), (kind, fixed))
                            .map_err(|why| format!("{file}: {why}"))?,
                    );
                }
                let what = match kind {
                    MatrixKind::Jacobian => "the constraint Jacobian",
                    MatrixKind::Stiffness => "the stiffness",
                };
                let line = format!("{what} {} × {}", shape[0], shape[1]);
                if !shapes.contains(&line) {
                    shapes.push(line);
                }
            }
        }
        let Some(right) = right else {
            return Err(format!(
                "{file}: a matrix of {} × {}, and the scene has: {}, held degrees of freedom left out or not",
                given.rows,
                given.columns,
                shapes.join(", ")
            ));
        };
        Ok(series(file, given, &right, &turned(state)))
    }
}

/// How nodes are turned at a state.
fn turned(state: &State) -> Turned {
    state.nodes.iter().map(|(label, motion)| (*label, motion.rotation.matrix())).collect()
}

/// What is wrong in a matrix, and why.
fn series(file: &str, given: &Entries, right: &Right, turned: &Turned) -> Series {
    let type_name = match right.kind {
        MatrixKind::Jacobian => "Jacobian",
        MatrixKind::Stiffness => "stiffness",
    };
    let mut found = Series::of_matrix(file.to_string(), type_name.to_string(), "entries".to_string());
    let is_of_shape = |by: &Departure| {
        let shape = [right.rows.len(), right.columns.len()];
        let shape = if by.is_transposed { [shape[1], shape[0]] } else { shape };
        [given.rows, given.columns] == shape
    };
    let all: Vec<Departure> = Departure::all(right.kind).into_iter().filter(is_of_shape).collect();
    let Some(plain) = all.first() else { return found };
    let told = right.departed(plain, turned);
    let bad = wrong(given, &told, usize::MAX);
    found.compared = told.keys().chain(given.at.keys().filter(|at| !told.contains_key(at))).count() as u64;
    found.wrong = bad.len() as u64;
    let worst = |all: &[((usize, usize), Point)]| {
        all.iter().max_by(|one, other| one.1.units().total_cmp(&other.1.units())).copied()
    };
    let mut best = (plain, bad.clone());
    if !bad.is_empty() || plain.cost > 0 {
        // Of a large matrix, every departure would take minutes.
        let tried = if right.at.len() > LARGE { 1 } else { all.len() };
        for by in &all[..tried] {
            let total = best.0.cost + WRONG * best.1.len();
            let Some(left) = total.checked_sub(by.cost + 1) else { break };
            let bad = wrong(given, &right.departed(by, turned), left / WRONG);
            if by.cost + WRONG * bad.len() < total {
                best = (by, bad);
            }
        }
    }
    let (by, left) = best;
    if by.cost > 0 {
        // What departs is wrong as it stands, whatever shape it has.
        found.wrong = found.wrong.max(u64::from(plain.cost > 0));
        found.cause = Some(by.words());
    }
    if let Some((at, point)) = worst(&left).or_else(|| worst(&bad)) {
        let of = if left.is_empty() { plain } else { by };
        let name = right.name(at, of);
        let (first, worst) = (Point { at: 0.0, ..point }, point);
        found.first = Some(first);
        found.worst = Some(worst);
        found.entry = Some(format!("{name} (line {}, column {})", at.0 + 1, at.1 + 1));
        if let (Some(cause), false) = (&mut found.cause, left.is_empty()) {
            let count = left.len();
            cause.push_str(&format!(
                "; {count} {} wrong even so",
                if count == 1 { "entry is" } else { "entries are" }
            ));
        }
    }
    found
}

/// Compares the matrices of files, each at its state.
///
/// # Errors
/// What is no matrix of the scene, with its file.
pub(crate) fn compare_matrices(
    scene: &Scene,
    model: &Model,
    results: &Results,
    files: &[PathBuf],
    has_rates: bool,
) -> Result<Vec<Series>, String> {
    let mut count = 0_u64;
    results.each(|frame| {
        count += u64::from(frame.moves);
        Ok(())
    })?;
    let map: &Map = &results.map;
    let mut wanted: BTreeMap<u64, Vec<(String, Entries)>> = BTreeMap::new();
    for file in files {
        let all = matrix::read(file)?;
        let is_one = all.len() == 1;
        for (n, entries) in all.into_iter().enumerate() {
            let state = if is_one { map.matrix_state.unwrap_or(count.saturating_sub(1)) } else { n as u64 };
            if state >= count {
                return Err(format!(
                    "{}: a matrix of state {state}, and the files have {count} with a motion",
                    file.display()
                ));
            }
            let name = if is_one { file.display().to_string() } else { format!("{}[{n}]", file.display()) };
            wanted.entry(state).or_default().push((name, entries));
        }
    }
    let evaluator = Evaluator::new(scene, model, map)?;
    let mut request = evaluator.request();
    request.add(Output::KT, [true; 6]);
    let plan = Plan::compile(model, &Selection::All, request).map_err(|error| error.to_string())?;
    let comparing = Comparing { scene, evaluator, plan: &plan, classes: classes(model) };
    let mut sequence = Sequence::new(model, &plan);
    sequence.follow_everything();
    if !has_rates {
        sequence.set_velocities(Velocities::Increments);
    }
    let mut motions = Motions::new(scene, map);
    let (mut at, mut found) = (0, Vec::new());
    results.each(|frame| {
        if !frame.moves {
            return Ok(());
        }
        let before = sequence.clone();
        let mut state = motions.state(frame)?;
        let known = comparing.evaluator.at(&mut sequence, &state, (frame, false));
        if let Some(all) = wanted.remove(&at) {
            let mut again = before.clone();
            let Ok(()) = again.visit(&state.clone(), |item| -> Result<(), Infallible> {
                if let Item::Connector(result) = item {
                    let element = &model.connectors[result.index];
                    let label = element.label.to_string().to_ascii_uppercase();
                    let numbers = known.elements.get(&label);
                    let forces = numbers.and_then(|numbers| {
                        comparing.evaluator.component_forces(result, (&label, numbers), frame).ok()
                    });
                    if let Some(forces) = forces {
                        let total = forces.map(|force| force.map(|force| force.x));
                        state
                            .forces
                            .insert(element.label, ElementForces { total, ..ElementForces::default() });
                    }
                }
                Ok(())
            });
            for (name, entries) in all {
                found.push(comparing.judge((&name, &entries), &before, (&state, frame, &motions))?);
            }
        }
        at += 1;
        Ok(())
    })?;
    Ok(found)
}

/// The nodes in classes of which no two share an element.
fn classes(model: &Model) -> Vec<Vec<Label>> {
    let connectors =
        model.connectors.iter().map(|of| of.nodes.iter().flatten().copied().collect::<Vec<Label>>());
    let mpcs = model.mpcs.iter().map(|of| of.nodes.clone());
    let relations = model.relations.iter().map(|of| of.nodes.clone());
    let mut beside: BTreeMap<Label, Vec<Label>> = BTreeMap::new();
    for nodes in connectors.chain(mpcs).chain(relations) {
        for node in &nodes {
            beside.entry(*node).or_default().extend(nodes.iter().filter(|other| *other != node));
        }
    }
    let mut class: BTreeMap<Label, usize> = BTreeMap::new();
    let mut found: Vec<Vec<Label>> = Vec::new();
    for (node, others) in &beside {
        let taken: Vec<usize> = others.iter().filter_map(|other| class.get(other).copied()).collect();
        let free = (0..).find(|n| !taken.contains(n)).unwrap_or(0);
        class.insert(*node, free);
        if free == found.len() {
            found.push(Vec::new());
        }
        found[free].push(*node);
    }
    found
}
