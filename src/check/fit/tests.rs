use super::search::GivenRows;
use super::space::{LENGTHS, Names, Order};
use super::{Found, fit, fit_constraint, generic_cases, generic_states};
use crate::convention::{
    Angle, Axes, Convention, Forces, Frame, Positions, Quaternions, Sense, Storage, Triads, Turned,
    Variation, Variations, is_vector,
};
use pintle_audit::sampling::{aligned, definition, pair};
use pintle_audit::{Case, Domain, MpcCase, Quantity, Right, Step};
use pintle_kinematics::catalog::{COMPONENT, ConnectionType, TABLE};
use pintle_kinematics::connector::{Connector, Definition, Request, State, Tally};
use pintle_kinematics::draw::Draw;
use pintle_kinematics::measure::{Measure, Unit};
use pintle_kinematics::mpc::{Constraint, MpcType};
use pintle_kinematics::so3;
use pintle_kinematics::vector::{product, transpose};

fn of_type(connection: &ConnectionType) -> Definition {
    let draw = &mut Draw::new("the connector of a fit");
    let a = so3::exp([0.4, -0.3, 0.7]);
    let relative = aligned(connection, draw);
    definition(connection, pair([0.7, -0.4, 0.9], a, &relative), 1.2)
}

fn often(draw: &mut Draw) -> bool {
    draw.unit() < 0.5
}

fn shuffled(mut rows: Vec<String>, draw: &mut Draw) -> Vec<String> {
    for n in (1..rows.len()).rev() {
        rows.swap(n, draw.below(n + 1));
    }
    rows
}

/// What the columns of rows vary.
fn draw_columns(convention: &mut Convention, draw: &mut Draw) {
    let variation = |draw: &mut Draw| Variation::ALL[draw.below(Variation::ALL.len())];
    let [a, b] = [variation(draw), variation(draw)];
    convention.rotations = if a == b { Variations::Both(a) } else { Variations::Each([a, b]) };
    convention.displacements = Frame::ALL[draw.below(4)];
}

/// How numbers are stored, in which units, with which signs.
fn draw_units(convention: &mut Convention, draw: &mut Draw) {
    convention.storage = if often(draw) { Storage::Rows } else { Storage::Columns };
    convention.angles = Angle::ALL[draw.below(3)];
    convention.column_angles = Angle::ALL[draw.below(3)];
    convention.row_length = LENGTHS[draw.below(LENGTHS.len())];
    convention.column_length = LENGTHS[draw.below(LENGTHS.len())];
    for factor in &mut convention.factors {
        *factor = if often(draw) { 1.0 } else { -1.0 };
    }
}

/// A convention, and how many columns its rows have.
fn drawn(definition: &Definition, draw: &mut Draw) -> Convention {
    let connector = Connector::<f64>::new(definition);
    let mut convention = Convention::default();
    let width = if often(draw) { 14 } else { 12 };
    let orders = Order::all(width, 0);
    convention.columns = orders[draw.below(orders.len())].names(&Names::of_connector());
    let components: Vec<usize> = (0..6).filter(|k| connector.differentiated(*k).is_some()).collect();
    if often(draw) {
        let rows: Vec<String> = components.iter().map(|k| COMPONENT[*k].to_string()).collect();
        convention.rows = shuffled(rows, draw);
    }
    draw_columns(&mut convention, draw);
    if is_vector(&connector, 0) || is_vector(&connector, 3) {
        convention.axes = Axes::ALL[draw.below(3)];
    }
    draw_units(&mut convention, draw);
    let is_transposed = draw.below(8) == 0;
    if convention.axes == Axes::A {
        // Where triads are read transposed, REVOLUTE is not aligned, and constrains angles.
        for k in components.iter().filter(|_| !is_transposed) {
            if matches!(connector.differentiated(*k), Some(Measure::Cosine(..))) && often(draw) {
                convention.as_angle.push(COMPONENT[*k].to_string());
            }
        }
        convention.positions = Positions::ALL[draw.below(2)];
    }
    match draw.below(8) {
        _ if is_transposed => convention.triads = Triads::Matrix,
        1 => convention.quaternion = Quaternions::Xyzw,
        2 => convention.sense = Sense::Inverse,
        _ => {}
    }
    convention
}

/// What a routine with a convention gives at a state that is sent in pintle's own: written apart from what the fit expects.
fn given(definition: &Definition, state: &State<f64>, convention: &Convention) -> GivenRows {
    let (mut definition, mut state) = (definition.clone(), *state);
    // As it reads the orientations.
    let initial = [definition.initial.a.triad, definition.initial.b.triad];
    for (n, node) in [&mut state.pair.a, &mut state.pair.b].into_iter().enumerate() {
        let rotation = product(&node.triad, &transpose(&initial[n]));
        if convention.triads == Triads::Matrix {
            node.triad = transpose(&node.triad);
        }
        if convention.sense == Sense::Inverse {
            node.triad = product(&transpose(&rotation), &initial[n]);
        }
        if convention.quaternion == Quaternions::Xyzw {
            let [w, x, y, z] = so3::quaternion(&rotation);
            // It takes what came first for x.
            node.triad = product(&so3::matrix([z, w, x, y]), &initial[n]);
        }
    }
    if convention.triads == Triads::Matrix {
        definition.initial.a.triad = transpose(&initial[0]);
        definition.initial.b.triad = transpose(&initial[1]);
    }
    let step = Step::between(&definition.initial, state.pair);
    let name = "given".to_string();
    let case = Case { name, definition: definition.clone(), start: None, path: vec![step], length: 1.0 };
    let right = Right::of(&case).unwrap();
    let connector = case.connector();
    let turned = Turned::of(&definition, &state);
    let rows = right.numbers.entries(Quantity::FirstDerivatives);
    let values = right.numbers.entries(Quantity::Value);
    let of = |k: usize| values.get(k, 0);
    let along = convention.axes.out_of_a(&turned);
    let resolve = |k: usize, get: &dyn Fn(usize) -> f64| {
        let first = 3 * (k / 3);
        if convention.axes == Axes::A || !is_vector(&connector, first) {
            return get(k);
        }
        (0..3).map(|m| along[k - first][m] * get(first + m)).sum()
    };
    let lines = if convention.rows.is_empty() { (0..6).collect() } else { convention.lines() };
    let mut table: Vec<Option<Vec<f64>>> = Vec::new();
    let mut numbers: Vec<Option<f64>> = Vec::new();
    for k in lines {
        let Some(measure) = connector.differentiated(k) else {
            table.push(None);
            numbers.push(None);
            continue;
        };
        let as_angle = convention.is_as_angle(k);
        let cosine = of(k).unwrap();
        let slope = if as_angle { 1.0 / (1.0 - cosine * cosine).sqrt() } else { 1.0 };
        let unit = match measure.unit() {
            Unit::Length => convention.row_length,
            Unit::Angle => convention.angles.size(),
            Unit::None if as_angle => convention.angles.size(),
            Unit::None => 1.0,
        };
        let factor = slope * convention.factors[k] / unit;
        let line = convention.columns.iter().map(|name| {
            let place = crate::convention::COLUMNS.iter().position(|known| known == name).unwrap();
            let (end, dof) = (place / 7, place % 7);
            let entry = |j: usize| resolve(k, &|k| rows.get(k, j).unwrap_or(0.0));
            match dof {
                0..=2 => {
                    let axes = convention.displacements.axes(end, &turned);
                    let sum: f64 = (0..3).map(|i| axes[i][dof] * entry(7 * end + i)).sum();
                    factor * sum * convention.column_length
                }
                3..=5 => {
                    let j = convention.rotations.of(end).jacobian(&turned[end]);
                    let sum: f64 = (0..3).map(|i| j[i][dof - 3] * entry(7 * end + 3 + i)).sum();
                    factor * sum * convention.column_angles.size()
                }
                _ => factor * entry(place) * convention.column_length,
            }
        });
        table.push(Some(line.collect()));
        let value = resolve(k, &|k| of(k).unwrap_or(0.0));
        let offset = convention.positions.offsets(&definition, &connector)[k].unwrap_or(0.0);
        let value = if as_angle { value.asin() } else { value + offset };
        numbers.push((!measure.is_one_form()).then_some(value * convention.factors[k] / unit));
    }
    GivenRows { rows: stored(table, convention), values: Some(numbers), ..GivenRows::default() }
}

/// Rows as the convention stores them.
fn stored(table: Vec<Option<Vec<f64>>>, convention: &Convention) -> Vec<Option<Vec<f64>>> {
    if convention.storage == Storage::Rows {
        return table;
    }
    let entry = |i: usize, j: usize| table[i].as_ref().map_or(0.0, |line| line[j]);
    let line = |j: usize| Some((0..table.len()).map(|i| entry(i, j)).collect());
    (0..convention.columns.len()).map(line).collect()
}

/// Whether rows are the same to 1e-9; one that is not there is zero.
fn are_same(one: &GivenRows, other: &GivenRows) -> bool {
    let same = |x: &f64, y: &f64| (x - y).abs() <= 1e-9 * (1e-3 + x.abs().max(y.abs()));
    one.rows.len() == other.rows.len()
        && one.rows.iter().zip(&other.rows).all(|(x, y)| match (x, y) {
            (Some(x), Some(y)) => x.len() == y.len() && x.iter().zip(y).all(|(x, y)| same(x, y)),
            (Some(x), None) | (None, Some(x)) => x.iter().all(|x| *x == 0.0),
            (None, None) => true,
        })
}

/// The place of an entry that matters, the same one at every state.
fn entry_that_matters(all: &[GivenRows], draw: &mut Draw) -> (usize, usize) {
    let places: Vec<(usize, usize)> = all[0]
        .rows
        .iter()
        .enumerate()
        .flat_map(|(i, line)| (0..line.as_ref().map_or(0, Vec::len)).map(move |j| (i, j)))
        .filter(|(i, j)| all.iter().all(|of| of.rows[*i].as_ref().unwrap()[*j].abs() > 1e-9))
        .collect();
    places[draw.below(places.len())]
}

/// An entry of what was given, as a fit names it.
fn place_of((i, j): (usize, usize), convention: &Convention) -> String {
    match convention.storage {
        Storage::Rows => format!("(line {}, column {})", i + 1, j + 1),
        Storage::Columns => format!("(line {}, column {})", j + 1, i + 1),
    }
}

fn found(definition: &Definition, states: &[State<f64>], convention: &Convention) -> Found {
    let all: Vec<GivenRows> = states.iter().map(|state| given(definition, state, convention)).collect();
    fit(definition, states, &all).unwrap()
}

/// Whether a convention is of the class: it gives what the simplest gives at states that the fit has not seen.
fn says_the_same(
    definition: &Definition,
    one: &Convention,
    other: &Convention,
    states: &[State<f64>],
) -> bool {
    states.iter().all(|state| are_same(&given(definition, state, one), &given(definition, state, other)))
}

/// The types to be tried: from number PINTLE_FROM of the catalogue on, all of them without it.
fn types() -> &'static [ConnectionType] {
    let from: usize = std::env::var("PINTLE_FROM").ok().and_then(|n| n.parse().ok()).unwrap_or(0);
    TABLE.get(from..).expect("there is no type from PINTLE_FROM on")
}

/// Of every type, conventions drawn from the declared space are found at general states; what is told says the same at states that were
/// not seen.
#[test]
fn drawn_conventions_are_found() {
    let per_type: u32 = std::env::var("PINTLE_CONVENTIONS").ok().and_then(|n| n.parse().ok()).unwrap_or(12);
    // One general state identifies what two do.
    for states in [1, 2] {
        conventions_are_found(per_type, states);
    }
}

fn conventions_are_found(per_type: u32, count: usize) {
    let (mut tried, mut unique, mut slowest) = (0, 0, 0.0_f64);
    for connection in types() {
        let definition = of_type(connection);
        let states = generic_states(&definition, "seen", count, &Domain::default());
        let others = generic_states(&definition, "unseen", 2, &Domain::default());
        let mut draw = Draw::new(&format!("conventions of {}", connection.name));
        let (mut of_type, mut spent, mut longest) = (0, 0.0, 0.0_f64);
        for _ in 0..per_type {
            let convention = drawn(&definition, &mut draw);
            let begun = std::time::Instant::now();
            let found = found(&definition, &states, &convention);
            let took = begun.elapsed().as_secs_f64();
            (spent, longest) = (spent + took, longest.max(took));
            let name = &connection.name;
            assert!(found.wrong.is_empty(), "{name}: {}\n{:#?}", convention.to_toml(), found.wrong);
            assert!(
                says_the_same(&definition, &convention, &found.convention, &others),
                "{name}:\n{}\nfound:\n{}{:?}",
                convention.to_toml(),
                found.convention.to_toml(),
                found.open
            );
            tried += 1;
            of_type += usize::from(found.count == 1);
        }
        let mean = 1e3 * spent / f64::from(per_type);
        println!(
            "{}: {per_type} found at {count} states, {of_type} of them the only one, in {mean:.0} ms, {longest:.2} s at most",
            connection.name
        );
        unique += of_type;
        slowest = slowest.max(longest);
    }
    println!("{tried} conventions, {unique} of them the only one, the slowest in {slowest:.2} s");
    assert_eq!(tried, types().len() as u32 * per_type);
}

/// One entry that is wrong by 1e-6 to 1 of itself: convention and entry are both named, and nothing false is.
#[test]
fn a_wrong_entry_is_named_under_the_right_convention() {
    let per_type = std::env::var("PINTLE_CONVENTIONS").ok().and_then(|n| n.parse().ok()).unwrap_or(8);
    let (mut tried, mut named, mut missed) = (0, 0, Vec::new());
    for connection in types() {
        let definition = of_type(connection);
        let states = generic_states(&definition, "seen", 2, &Domain::default());
        let others = generic_states(&definition, "unseen", 2, &Domain::default());
        let mut draw = Draw::new(&format!("wrong entries of {}", connection.name));
        let before = named;
        for _ in 0..per_type {
            let convention = drawn(&definition, &mut draw);
            let mut all: Vec<GivenRows> =
                states.iter().map(|state| given(&definition, state, &convention)).collect();
            let (i, j) = entry_that_matters(&all, &mut draw);
            let factor =
                1.0 + 10.0_f64.powf(-draw.between(0.0, 6.0)) * if draw.unit() < 0.5 { 1.0 } else { -1.0 };
            for of in &mut all {
                of.rows[i].as_mut().unwrap()[j] *= factor;
            }
            let found = fit(&definition, &states, &all).unwrap();
            tried += 1;
            let place = place_of((i, j), &convention);
            let is_entry = found.wrong.len() == 1 && found.wrong[0].name.ends_with(&place);
            if is_entry && says_the_same(&definition, &convention, &found.convention, &others) {
                named += 1;
            } else {
                let wrong: Vec<&String> = found.wrong.iter().map(|wrong| &wrong.name).collect();
                missed.push(format!(
                    "{} × {factor} at {place}: {wrong:?}\n{}found\n{}",
                    connection.name,
                    convention.to_toml(),
                    found.convention.to_toml()
                ));
            }
        }
        println!("{}: {} of {per_type} wrong entries named", connection.name, named - before);
    }
    println!("{}\n{named} of {tried} wrong entries named", missed.join("\n"));
    assert_eq!(tried, types().len() * per_type);
    assert!(100 * named >= 99 * tried, "{named} of {tried}\n{}", missed.join("\n"));
}

/// Where nodes have not turned, the class is exactly the conventions that give the same numbers: by trying all of a small space.
#[test]
fn the_class_is_exact_where_nodes_have_not_turned() {
    let (mut tried, mut open) = (0, 0);
    for name in ["TRANSLATOR", "BUSHING", "HINGE", "CVJOINT"] {
        let definition = of_type(&ConnectionType::named(name, None).unwrap());
        for turned in [[false, false], [true, false], [false, true]] {
            let mut states = generic_states(&definition, "seen", 2, &Domain::default());
            for state in &mut states {
                let initial = &definition.initial;
                for (node, first, is_turned) in
                    [(&mut state.pair.a, &initial.a, turned[0]), (&mut state.pair.b, &initial.b, turned[1])]
                {
                    if !is_turned {
                        node.triad = first.triad;
                    }
                }
            }
            let mut draw = Draw::new(name);
            let plain = Convention::default();
            let truth = Convention {
                rotations: Variations::Both(Variation::Body),
                displacements: Frame::ALL[draw.below(4)],
                ..plain.clone()
            };
            let all: Vec<GivenRows> = states.iter().map(|state| given(&definition, state, &truth)).collect();
            let found = fit(&definition, &states, &all).unwrap();
            assert!(found.holds(&truth), "{name} {turned:?}");
            let mut columns = plain.columns.clone();
            columns.rotate_left(7);
            for order in [plain.columns.clone(), columns] {
                for a in Variation::ALL {
                    for b in Variation::ALL {
                        for displacements in Frame::ALL {
                            for sense in [Sense::Forward, Sense::Inverse] {
                                let rotations =
                                    if a == b { Variations::Both(a) } else { Variations::Each([a, b]) };
                                let one = Convention {
                                    columns: order.clone(),
                                    rotations,
                                    displacements,
                                    sense,
                                    ..plain.clone()
                                };
                                let is_same = says_the_same(&definition, &truth, &one, &states);
                                assert_eq!(
                                    found.holds(&one),
                                    is_same,
                                    "{name} {turned:?}\n{}",
                                    one.to_toml()
                                );
                                tried += 1;
                                open += usize::from(is_same);
                            }
                        }
                    }
                }
            }
            // A general state tells some of them apart.
            let others = generic_states(&definition, "unseen", 3, &Domain::default());
            assert!(found.separating(&definition, &others).is_some(), "{name} {turned:?}");
        }
    }
    println!("{tried} conventions tried, {open} left open");
    assert!(open > 100 && tried > 10 * open);
}

/// The variations of rotations are those of what they are named after: by turning a little.
#[test]
fn variations_are_derivatives() {
    let step = 1e-6;
    let compose = |sequence: [usize; 3], angles: [f64; 3]| {
        let turn = |n: usize| {
            let mut axis = [0.0; 3];
            axis[sequence[n]] = angles[n];
            so3::exp(axis)
        };
        product(&product(&turn(0), &turn(1)), &turn(2))
    };
    let mut compared = 0;
    for (variation, sequence) in [
        (Variation::Angles123, [0, 1, 2]),
        (Variation::Angles321, [2, 1, 0]),
        (Variation::Angles313, [2, 0, 2]),
    ] {
        for angles in [[0.4, 0.7, -0.3], [-1.9, 1.1, 2.4], [2.8, 0.3, -0.9]] {
            let rotation = compose(sequence, angles);
            let turned = Turned { triad: rotation, rotation, vector: so3::log(&rotation) };
            let jacobian = variation.jacobian(&turned);
            for n in 0..3 {
                let mut moved = [angles; 2];
                moved[0][n] += step;
                moved[1][n] -= step;
                let [ahead, behind] = moved.map(|angles| compose(sequence, angles));
                let spin = so3::log(&product(&ahead, &transpose(&behind)));
                for i in 0..3 {
                    let want = spin[i] / (2.0 * step);
                    assert!((jacobian[i][n] - want).abs() < 1e-8, "{variation:?} {angles:?}: {i} {n}");
                    compared += 1;
                }
            }
        }
    }
    assert_eq!(compared, 81);
}

/// A constraint of a kind whose nodes are apart, along no global axis.
fn of_kind(kind: MpcType) -> Constraint<f64> {
    Constraint::new(kind, [0.7, -0.4, 0.9], [0.0; 3], [[1.0, -2.0, 2.0], [2.0, 2.0, 1.0]])
}

/// A convention of a constraint.
fn drawn_of(constraint: &Constraint<f64>, draw: &mut Draw) -> Convention {
    let kind = constraint.kind();
    let names = Names::of_constraint(kind);
    let mut convention = Convention::default();
    let orders = Order::all(if often(draw) { 14 } else { 12 } + names.hinges, names.hinges);
    convention.columns = orders[draw.below(orders.len())].names(&names);
    let has = constraint.rows();
    if often(draw) {
        let rows: Vec<String> = (0..7).filter(|k| has[*k]).map(|k| kind.row_name(k).to_string()).collect();
        convention.rows = shuffled(rows, draw);
    }
    draw_columns(&mut convention, draw);
    draw_units(&mut convention, draw);
    match draw.below(8) {
        0 => convention.sense = Sense::Inverse,
        1 => convention.quaternion = Quaternions::Xyzw,
        _ => {}
    }
    convention
}

/// What a routine with a convention gives of a constraint: the product's own numbers, put into the convention apart from the fit.
fn given_of(case: &MpcCase, convention: &Convention) -> GivenRows {
    let mut case = case.clone();
    for body in [&mut case.state.slave, &mut case.state.master] {
        if convention.sense == Sense::Inverse {
            body.rotation = transpose(&body.rotation);
        }
        if convention.quaternion == Quaternions::Xyzw {
            let [w, x, y, z] = so3::quaternion(&body.rotation);
            body.rotation = so3::matrix([z, w, x, y]);
        }
    }
    let kind = case.constraint.kind();
    let names = Names::of_constraint(kind);
    let turned = Turned::of_bodies(&case.state);
    let asked = Request::everything(1);
    let found =
        case.constraint.evaluate(&case.state, &case.before, &case.turning, &asked, &mut Tally::default());
    let all: Vec<&str> = names.rows.to_vec();
    let lines = convention.lines_among(&all);
    let (mut table, mut values) = (Vec::new(), Vec::new());
    for k in lines {
        let Some(row) = found.jacobian[k] else {
            table.push(None);
            values.push(None);
            continue;
        };
        let unit = match MpcType::row_unit(k) {
            Unit::Angle => convention.angles.size(),
            _ => convention.row_length,
        };
        let factor = convention.factors.get(k).copied().unwrap_or(1.0) / unit;
        let line = convention.columns.iter().map(|name| {
            let place = names.columns.iter().position(|known| known == name).unwrap();
            if place >= 14 {
                return factor * row[place] * convention.column_angles.size();
            }
            let (end, dof) = (place / 7, place % 7);
            let sum = |m: &pintle_kinematics::vector::Matrix<f64>, first: usize, of: usize| {
                (0..3).map(|i| m[i][of] * row[7 * end + first + i]).sum::<f64>()
            };
            factor
                * match dof {
                    0..=2 => {
                        let axes = convention.displacements.axes(end, &turned);
                        sum(&axes, 0, dof) * convention.column_length
                    }
                    3..=5 => {
                        let jacobian = convention.rotations.of(end).jacobian(&turned[end]);
                        sum(&jacobian, 3, dof - 3) * convention.column_angles.size()
                    }
                    _ => row[place] * convention.column_length,
                }
        });
        table.push(Some(line.collect::<Vec<f64>>()));
        values.push(found.residual[k].map(|x| x * factor));
    }
    GivenRows { rows: stored(table, convention), values: Some(values), ..GivenRows::default() }
}

/// Whether two conventions of a constraint give the same numbers at states that the fit has not seen.
fn say_the_same(one: &Convention, other: &Convention, cases: &[MpcCase]) -> bool {
    cases.iter().all(|case| are_same(&given_of(case, one), &given_of(case, other)))
}

/// Of each of the six constraints, drawn conventions are found; and one that has a wrong entry is found with that entry.
#[test]
fn drawn_conventions_of_constraints_are_found() {
    let per_kind = std::env::var("PINTLE_CONVENTIONS").ok().and_then(|n| n.parse().ok()).unwrap_or(12);
    let (mut tried, mut unique, mut named, mut missed, mut slowest) = (0, 0, 0, Vec::new(), 0.0_f64);
    for kind in MpcType::ALL {
        let constraint = of_kind(kind);
        let cases = generic_cases(&constraint, "seen", 2);
        let others = generic_cases(&constraint, "unseen", 2);
        assert_eq!((cases.len(), others.len()), (2, 2), "{kind:?}");
        let mut draw = Draw::new(&format!("conventions of MPC {}", kind.name()));
        for _ in 0..per_kind {
            let convention = drawn_of(&constraint, &mut draw);
            let of = |convention: &Convention| -> Vec<GivenRows> {
                cases.iter().map(|case| given_of(case, convention)).collect()
            };
            // As a file holds it: names that are left out are those of pintle.
            let whole = |found: &Convention| {
                let mut found = found.clone();
                if found.columns == Convention::default().columns {
                    let names = Names::of_constraint(kind).columns;
                    found.columns =
                        names.iter().filter(|name| !name.is_empty()).map(|name| (*name).into()).collect();
                }
                found
            };
            let mut all = of(&convention);
            let begun = std::time::Instant::now();
            let found = fit_constraint(&constraint, &cases, &all).unwrap();
            slowest = slowest.max(begun.elapsed().as_secs_f64());
            assert!(found.wrong.is_empty(), "{kind:?}:\n{}{:#?}", convention.to_toml(), found.wrong);
            let simplest = whole(&found.convention);
            assert!(
                say_the_same(&convention, &simplest, &others),
                "{kind:?}:\n{}\nfound:\n{}{:?}",
                convention.to_toml(),
                simplest.to_toml(),
                found.open
            );
            tried += 1;
            unique += usize::from(found.count == 1);
            let (i, j) = entry_that_matters(&all, &mut draw);
            let factor = 1.0 + 10.0_f64.powf(-draw.between(0.0, 6.0));
            for of in &mut all {
                of.rows[i].as_mut().unwrap()[j] *= factor;
            }
            let found = fit_constraint(&constraint, &cases, &all).unwrap();
            let place = place_of((i, j), &convention);
            let is_entry = found.wrong.len() == 1 && found.wrong[0].name.ends_with(&place);
            if is_entry && say_the_same(&convention, &whole(&found.convention), &others) {
                named += 1;
            } else {
                let wrong: Vec<&String> = found.wrong.iter().map(|wrong| &wrong.name).collect();
                missed.push(format!(
                    "{kind:?} × {factor} at {place}: {wrong:?}\n{}found\n{}",
                    convention.to_toml(),
                    found.convention.to_toml()
                ));
            }
        }
    }
    println!(
        "{tried} conventions of constraints, {unique} of them the only one, {named} wrong entries named, {slowest:.2} s"
    );
    assert!(tried >= 6 * per_kind);
    assert!(100 * named >= 99 * tried, "{named} of {tried}\n{}", missed.join("\n"));
}

/// The numbers of a quantity by columns, as a routine of a convention gives them: rows, or nodal forces on a side.
fn by_columns(
    definition: &Definition,
    state: &State<f64>,
    convention: &Convention,
    quantity: Quantity,
) -> Vec<Option<Vec<f64>>> {
    let step = Step::between(&definition.initial, state.pair);
    let name = "by columns".to_string();
    let case = Case { name, definition: definition.clone(), start: None, path: vec![step], length: 1.0 };
    let right = Right::of(&case).unwrap();
    let (connector, turned) = (case.connector(), Turned::of(definition, state));
    let line = |k: usize| -> Option<Vec<f64>> {
        connector.differentiated(k)?;
        let entry = |j: usize| right.numbers.entries(quantity).get(k, j).unwrap_or(0.0);
        let factor = 1.0 / convention.unit(k, &connector);
        let column = |name: &String| {
            let place = crate::convention::COLUMNS.iter().position(|known| known == name).unwrap();
            let (end, dof) = (place / 7, place % 7);
            let sum = |m: &pintle_kinematics::vector::Matrix<f64>, first: usize| {
                (0..3).map(|i| m[i][dof - first] * entry(7 * end + first + i)).sum::<f64>()
            };
            factor
                * match dof {
                    0..=2 => sum(&convention.displacements.axes(end, &turned), 0) * convention.column_length,
                    3..=5 => {
                        let jacobian = convention.rotations.of(end).jacobian(&turned[end]);
                        sum(&jacobian, 3) * convention.column_angles.size()
                    }
                    _ => entry(place) * convention.column_length,
                }
        };
        Some(convention.columns.iter().map(column).collect())
    };
    let lines = if convention.rows.is_empty() { (0..6).collect() } else { convention.lines() };
    lines.into_iter().map(line).collect()
}

/// Nodal forces that are given besides tell on which side they are, under drawn conventions.
#[test]
fn nodal_forces_tell_their_side() {
    let mut tried = 0;
    for name in ["BUSHING", "CARTESIAN", "HINGE", "AXIAL", "TRANSLATOR"] {
        let definition = of_type(&ConnectionType::named(name, None).unwrap());
        let states = generic_states(&definition, "seen", 2, &Domain::default());
        let mut draw = Draw::new(&format!("sides of {name}"));
        for n in 0..6 {
            let plain = Convention::default();
            let convention = Convention {
                axes: plain.axes,
                as_angle: Vec::new(),
                positions: plain.positions,
                triads: plain.triads,
                quaternion: plain.quaternion,
                sense: plain.sense,
                storage: Storage::Rows,
                ..drawn(&definition, &mut draw)
            };
            let sign = if n % 2 == 0 { 1.0 } else { -1.0 };
            let of = |state: &State<f64>| {
                let mut nodal = by_columns(&definition, state, &convention, Quantity::NodalForces);
                nodal.iter_mut().flatten().flatten().for_each(|x| *x *= sign);
                let rows = by_columns(&definition, state, &convention, Quantity::FirstDerivatives);
                GivenRows { rows, nodal: Some(nodal), ..GivenRows::default() }
            };
            let all: Vec<GivenRows> = states.iter().map(of).collect();
            let found = fit(&definition, &states, &all).unwrap();
            // Without values nothing tells the sign of rows from that of forces but the two together.
            let minus = |convention: &Convention| convention.forces == Forces::Body;
            assert_eq!(
                minus(&found.convention),
                n % 2 == 1,
                "{name}:\n{}\n{}",
                convention.to_toml(),
                found.convention.to_toml()
            );
            tried += 1;
        }
    }
    assert_eq!(tried, 30);
}

/// Rows of a length by lengths are the same in any unit; second derivatives tell it.
#[test]
fn second_derivatives_tell_what_rows_leave_open() {
    let definition = of_type(&ConnectionType::named("AXIAL", None).unwrap());
    let states = generic_states(&definition, "seen", 2, &Domain::default());
    for length in [1e-3, 0.0254, 1.0] {
        let truth = Convention { row_length: length, column_length: length, ..Convention::default() };
        let of = |state: &State<f64>, is_told: bool| {
            let connector = Connector::<f64>::new(&definition);
            let asked = Request::everything(2);
            let branch = connector.initial_branch();
            let step = Step::between(&definition.initial, state.pair);
            let found =
                connector.evaluate(&step.state, &step.increment, &branch, &asked, &mut Tally::default());
            let second = found
                .hessian
                .map(|of| of.map(|of| of.as_flattened().iter().map(|x| x * length).collect::<Vec<f64>>()));
            GivenRows {
                rows: by_columns(&definition, state, &truth, Quantity::FirstDerivatives),
                second: is_told.then(|| second.to_vec()),
                ..GivenRows::default()
            }
        };
        let [open, told] = [false, true].map(|is_told| {
            let all: Vec<GivenRows> = states.iter().map(|state| of(state, is_told)).collect();
            fit(&definition, &states, &all).unwrap()
        });
        assert!(open.count >= 9 && open.holds(&truth), "{}", open.count);
        assert!(told.count < open.count && told.holds(&truth), "{length}: {} of {}", told.count, open.count);
        assert_eq!(told.convention.row_length, length);
    }
}
