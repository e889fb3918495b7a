//! States from arrays of any form, rows into arrays of any form: the numbers of tiles.

use pintle_kinematics::batch::{
    Array, Batch, BatchError, COMPACT, Columns, Columns12, Four, HessianRow, History, LANES, Nodes,
    Orientation, Row, Section, States, Tile, Velocities,
};
use pintle_kinematics::catalog::{ConnectionType, TABLE};
use pintle_kinematics::connector::{Connector, Definition};
use pintle_kinematics::draw::Draw;
use pintle_kinematics::node::{Node, Pair};
use pintle_kinematics::{so3, vector};

/// A value and twelve columns.
type Found = (f64, [f64; 12]);

struct Case {
    batch: Batch,
    sections: [Section; 1],
    histories: [History; 1],
    initial: [[[f64; 3]; 3]; 2],
    /// Rotation vectors of a and b, shorter than π.
    turns: Vec<[[f64; 3]; 2]>,
    pairs: Vec<Pair<f64>>,
}

fn case(connection: &ConnectionType, draw: &mut Draw, count: usize) -> Option<Case> {
    let initial = [draw.triad(), draw.triad()];
    let node = |triad| Node { displacement: [0.0; 3], triad, flow: 0.0 };
    let first = Pair { reference: [0.4, -0.2, 0.7], a: node(initial[0]), b: node(initial[1]) };
    let connector = Connector::<f64>::new(&Definition::new(connection.clone(), first));
    let turns: Vec<[[f64; 3]; 2]> = (0..count).map(|_| [draw.vector(1.5), draw.vector(1.5)]).collect();
    let pairs = turns
        .iter()
        .map(|turn| {
            let node = |end: usize, displacement| Node {
                displacement,
                triad: vector::product(&so3::exp(turn[end]), &initial[end]),
                flow: 0.0,
            };
            Pair { reference: first.reference, a: node(0, draw.vector(1.0)), b: node(1, draw.vector(1.0)) }
        })
        .collect();
    Some(Case {
        batch: Batch::new(&connector, [true; 6]).ok()?,
        sections: [Section::new(&[&connector; LANES])],
        histories: [History::new(&[connector.initial_branch(); LANES])],
        initial,
        turns,
        pairs,
    })
}

impl Case {
    /// The states by fours; beyond the last stands the last again.
    fn tiles(&self) -> Vec<Tile> {
        let count = self.pairs.len();
        let at = |s: usize| self.pairs[s.min(count - 1)];
        (0..count.div_ceil(4))
            .map(|t| Tile::new(&[at(4 * t), at(4 * t + 1), at(4 * t + 2), at(4 * t + 3)]))
            .collect()
    }

    /// The rows of tiles.
    fn expected(&self) -> Vec<Vec<Found>> {
        let (count, tiles) = (self.pairs.len(), self.tiles());
        let (sections, histories) =
            (vec![self.sections[0]; tiles.len()], vec![self.histories[0]; tiles.len()]);
        let each = self.batch.rows();
        let mut rows = vec![Row::default(); tiles.len() * each];
        self.batch.rows_of(&tiles, &sections, &histories, &mut rows).unwrap();
        let of = |s: usize, r: usize| {
            let row = &rows[s / 4 * each + r];
            (row.value[s % 4], row.columns.map(|four| four[s % 4]))
        };
        (0..count).map(|s| (0..each).map(|r| of(s, r)).collect()).collect()
    }

    fn flat<const N: usize>(&self, of: impl Fn(usize) -> [f64; N]) -> Vec<f64> {
        (0..self.pairs.len()).flat_map(of).collect()
    }
}

fn nine(m: &[[f64; 3]; 3]) -> [f64; 9] {
    std::array::from_fn(|k| m[k / 3][k % 3])
}

fn is_near(found: f64, expected: f64, tolerance: f64) -> bool {
    (found - expected).abs() <= tolerance * expected.abs().max(1.0).powi(2)
}

/// Compares numbers with those expected, and counts them.
fn compare(what: &str, batch: &Batch, states: &States<'_>, expected: &[Vec<Found>], tolerance: f64) -> usize {
    let each = batch.rows();
    let pattern = batch.pattern();
    let chosen = [11, 0, 4];
    let mut compared = 0;
    for columns in [
        Columns::Twelve,
        Columns::Fourteen,
        Columns::Sparse,
        Columns::Chosen(&COMPACT),
        Columns::Chosen(&chosen),
        Columns::Chosen(&[]),
    ] {
        let width = batch.width(columns);
        let mut values = vec![f64::NAN; states.count * each];
        let mut rows = vec![f64::NAN; states.count * width];
        batch.rows_of_states(states, columns, &mut values, &mut rows).unwrap();
        for (s, truth) in expected.iter().enumerate() {
            let mut wanted = Vec::new();
            for (r, (value, row)) in truth.iter().enumerate() {
                let found = values[s * each + r];
                assert!(is_near(found, *value, tolerance), "{what}, {columns:?}: {found} for {value}");
                match columns {
                    Columns::Twelve => wanted.extend_from_slice(row),
                    Columns::Fourteen => {
                        wanted.extend_from_slice(&row[..6]);
                        wanted.push(0.0);
                        wanted.extend_from_slice(&row[6..]);
                        wanted.push(0.0);
                    }
                    Columns::Sparse => {
                        for (j, x) in row.iter().enumerate() {
                            if pattern[r].contains(&j) {
                                wanted.push(*x);
                            } else {
                                assert_eq!(*x, 0.0, "{what}: column {j} is not in the pattern");
                            }
                        }
                    }
                    Columns::Chosen(places) => wanted.extend(places.iter().map(|j| row[*j])),
                }
            }
            for (found, wanted) in rows[s * width..][..width].iter().zip(&wanted) {
                assert!(is_near(*found, *wanted, tolerance), "{what}, {columns:?}: {found} for {wanted}");
                assert!(
                    tolerance > 0.0 || found.to_bits() != (-0.0_f64).to_bits(),
                    "{what}: a negative zero"
                );
            }
            assert_eq!(wanted.len(), width);
            compared += each + width;
        }
    }
    compared
}

#[test]
fn rows_of_arrays_are_those_of_tiles() {
    let draw = &mut Draw::new("rows");
    let (mut types, mut compared) = (0, 0);
    for connection in TABLE {
        for count in [1, 3, 4, 63, 64, 131] {
            let Some(case) = case(connection, draw, count) else { continue };
            types += usize::from(count == 1);
            let expected = case.expected();
            let reference = case.pairs[0].reference;
            let x =
                [case.flat(|s| case.pairs[s].a.displacement), case.flat(|s| case.pairs[s].b.displacement)];
            let triad =
                [case.flat(|s| nine(&case.pairs[s].a.triad)), case.flat(|s| nine(&case.pairs[s].b.triad))];
            let directions = [
                case.flat(|s| nine(&vector::transpose(&case.pairs[s].a.triad))),
                case.flat(|s| nine(&vector::transpose(&case.pairs[s].b.triad))),
            ];
            let turns = [case.flat(|s| case.turns[s][0]), case.flat(|s| case.turns[s][1])];
            let quaternions = [0, 1].map(|end: usize| {
                case.flat(|s| so3::exp_quaternion(case.turns[s][end]).map(|part| -3.0 * part))
            });
            let all = |of: [Orientation<'_>; 2]| -> usize {
                let node = |end: usize| Nodes { displacement: Array::new(&x[end], 3), orientation: of[end] };
                let states = States {
                    count,
                    reference: Array::shared(&reference),
                    nodes: [node(0), node(1)],
                    sections: &case.sections,
                    histories: &case.histories,
                };
                let tolerance = match of[0] {
                    Orientation::Triad(_) | Orientation::Directions(_) => 0.0,
                    _ => crate::tolerance::ROWS_OF_TURNS,
                };
                let what = format!("{}, {count} states", connection.name);
                // Nothing is fused there.
                let near = tolerance.max(crate::tolerance::ROWS_OF_TURNS);
                compare(&what, &case.batch, &states, &expected, tolerance)
                    + compare(&what, &case.batch.clone().baseline(), &states, &expected, near)
            };
            compared += all([0, 1].map(|end: usize| Orientation::Triad(Array::new(&triad[end], 9))));
            compared +=
                all([0, 1].map(|end: usize| Orientation::Directions(Array::new(&directions[end], 9))));
            compared += all([0, 1].map(|end: usize| {
                Orientation::RotationVector(Array::new(&turns[end], 3), case.initial[end])
            }));
            compared += all([0, 1].map(|end: usize| {
                Orientation::Quaternion(Array::new(&quaternions[end], 4), case.initial[end])
            }));
        }
    }
    println!("{compared} numbers of {types} types");
    assert!(types >= 25 && compared > 1_000_000, "{compared} numbers of {types} types");
}

/// So many states that longer parts are computed at a time.
#[test]
fn very_many_states_are_many() {
    let draw = &mut Draw::new("rows, many");
    let connection = ConnectionType::named("UJOINT", None).unwrap();
    let case = case(&connection, draw, 16_386).unwrap();
    let expected = case.expected();
    let x = [case.flat(|s| case.pairs[s].a.displacement), case.flat(|s| case.pairs[s].b.displacement)];
    let triad = [case.flat(|s| nine(&case.pairs[s].a.triad)), case.flat(|s| nine(&case.pairs[s].b.triad))];
    let node = |end: usize| Nodes {
        displacement: Array::new(&x[end], 3),
        orientation: Orientation::Triad(Array::new(&triad[end], 9)),
    };
    let states = States {
        count: case.pairs.len(),
        reference: Array::shared(&case.pairs[0].reference),
        nodes: [node(0), node(1)],
        sections: &case.sections,
        histories: &case.histories,
    };
    assert!(compare("many", &case.batch, &states, &expected, 0.0) > 1_000_000);
}

/// One array of 27 numbers a state, one node for all, and a section for each tile.
#[test]
fn arrays_lie_as_they_do() {
    let draw = &mut Draw::new("rows, strides");
    let connection = ConnectionType::named("CARTESIAN", Some("CARDAN")).unwrap();
    let mut case = case(&connection, draw, 70).unwrap();
    let fixed = case.pairs[0].a;
    case.pairs.iter_mut().for_each(|pair| pair.a = fixed);
    let expected = case.expected();
    let all: Vec<f64> = case
        .pairs
        .iter()
        .flat_map(|pair| {
            let mut numbers = pair.b.displacement.to_vec();
            numbers.extend(nine(&pair.b.triad));
            numbers.push(f64::NAN);
            numbers
        })
        .collect();
    let triad = nine(&fixed.triad);
    let (sections, histories) = (vec![case.sections[0]; 18], vec![case.histories[0]; 18]);
    for (sections, histories) in [(&case.sections[..], &histories[..]), (&sections[..], &case.histories[..])]
    {
        let states = States {
            count: 70,
            reference: Array::shared(&case.pairs[0].reference),
            nodes: [
                Nodes {
                    displacement: Array::shared(&fixed.displacement),
                    orientation: Orientation::Triad(Array::shared(&triad)),
                },
                Nodes {
                    displacement: Array::new(&all, 13),
                    orientation: Orientation::Triad(Array::new(&all[3..], 13)),
                },
            ],
            sections,
            histories,
        };
        assert!(compare("strides", &case.batch, &states, &expected, 0.0) > 10_000);
        let (mut values, mut rows) = (vec![0.0; 70 * 6], vec![0.0; 70 * 72]);
        let refused = |states: &States<'_>, values: &mut [f64], rows: &mut [f64]| {
            case.batch.rows_of_states(states, Columns::Twelve, values, rows).unwrap_err().to_string()
        };
        assert_eq!(refused(&states, &mut values, &mut rows[1..]), "rows: 5039 where 5040 are needed");
        assert_eq!(refused(&states, &mut values[1..], &mut rows), "values: 419 where 420 are needed");
        let few = States { sections: &[], ..states };
        assert_eq!(refused(&few, &mut values, &mut rows), "sections: 0 where 18 are needed");
        let mut short = states;
        short.nodes[1].displacement = Array::new(&all[..899], 13);
        assert_eq!(
            refused(&short, &mut values, &mut rows),
            "numbers of displacements: 899 where 900 are needed"
        );
        let none = States { count: 0, sections: &case.sections, histories: &case.histories, ..states };
        assert_eq!(case.batch.rows_of_states(&none, Columns::Sparse, &mut [], &mut []), Ok(()));
        assert_eq!(
            case.batch.rows_of_states(&states, Columns::Chosen(&[3, 12]), &mut values, &mut rows),
            Err(BatchError::Column(12))
        );
    }
}

/// What turns a node in one state changes no bit of others in its tile, and [`States::pair`] has the bits of the rows.
///
/// - quaternions of any length, and of zero, which is no turn
/// - rotation vectors that are huge or no numbers
#[test]
fn turns_stay_in_their_states() {
    let draw = &mut Draw::new("rows, turns");
    let connection = ConnectionType::named("CARTESIAN", Some("CARDAN")).unwrap();
    let case = case(&connection, draw, 32).unwrap();
    let expected = case.expected();
    let (each, width) = (case.batch.rows(), case.batch.width(Columns::Twelve));
    let triads = case.flat(|s| nine(&case.pairs[s].a.triad));
    let places =
        [0, 1].map(|end: usize| case.flat(|s| [&case.pairs[s].a, &case.pairs[s].b][end].displacement));
    let rows_of = |what: &str, orientation: Orientation<'_>| {
        let node = |end: usize, orientation| Nodes { displacement: Array::new(&places[end], 3), orientation };
        let states = States {
            count: 32,
            reference: Array::shared(&case.pairs[0].reference),
            nodes: [node(0, Orientation::Triad(Array::new(&triads, 9))), node(1, orientation)],
            sections: &case.sections,
            histories: &case.histories,
        };
        let (mut values, mut rows) = (vec![0.0; 32 * each], vec![0.0; 32 * width]);
        case.batch.rows_of_states(&states, Columns::Twelve, &mut values, &mut rows).unwrap();
        // The same by the nodes of each state.
        for s in 0..32 {
            let triad = states.pair(s).b.triad;
            let alone = Orientation::Triad(Array::shared(triad.as_flattened()));
            let mut one = States { count: 1, ..states };
            one.nodes[0] = Nodes {
                displacement: Array::new(&places[0][3 * s..], 3),
                orientation: Orientation::Triad(Array::new(&triads[9 * s..], 9)),
            };
            one.nodes[1] = Nodes { displacement: Array::new(&places[1][3 * s..], 3), orientation: alone };
            let (mut own_values, mut own_rows) = (vec![0.0; each], vec![0.0; width]);
            case.batch.rows_of_states(&one, Columns::Twelve, &mut own_values, &mut own_rows).unwrap();
            let is_nan = own_values.iter().any(|x| x.is_nan());
            let found = &rows[s * width..(s + 1) * width];
            let apart = own_rows.iter().zip(found).position(|(own, found)| own != found);
            assert!(
                is_nan || apart.is_none(),
                "{what}, state {s}: {apart:?} {:?}",
                apart.map(|k| (own_rows[k], found[k]))
            );
        }
        (values, rows)
    };
    let quaternion = |s: usize| so3::exp_quaternion(case.turns[s][1]);
    let usual = rows_of(
        "quaternions",
        Orientation::Quaternion(Array::new(&case.flat(quaternion), 4), case.initial[1]),
    );
    // In each tile another lane is not usual.
    let odd = |s: usize| s % 4 == s / 4 % 4;
    let mut compared = 0;
    for length in [-3.0, 1e-170, 1e-300, 1e200, 1e300, 0.0] {
        let scaled = case.flat(|s| quaternion(s).map(|part| if odd(s) { length * part } else { part }));
        let (values, rows) = rows_of(
            &format!("length {length}"),
            Orientation::Quaternion(Array::new(&scaled, 4), case.initial[1]),
        );
        for s in 0..32 {
            let numbers = s * width..(s + 1) * width;
            if !odd(s) {
                assert_eq!(rows[numbers.clone()], usual.1[numbers], "state {s}, beside length {length}");
            } else if length == 0.0 {
                let values = &values[s * each..(s + 1) * each];
                assert!(values[3..].iter().all(|angle| angle.is_nan()), "state {s}: {values:?}");
            } else {
                let pairs = rows[numbers].chunks(12).zip(&expected[s]);
                pairs.flat_map(|(row, of)| row.iter().zip(of.1)).for_each(|(found, expected)| {
                    assert!(is_near(*found, expected, 1e-13), "state {s}, length {length}");
                });
            }
            compared += 1;
        }
    }
    let vectors = case.flat(|s| case.turns[s][1]);
    let usual = rows_of("vectors", Orientation::RotationVector(Array::new(&vectors, 3), case.initial[1]));
    for strange in [0.0, 3e5, 1e17, f64::NAN, f64::INFINITY] {
        let some = case.flat(|s| if odd(s) { [strange, 0.0, 0.0] } else { case.turns[s][1] });
        let (_, rows) = rows_of(
            &format!("vectors, {strange}"),
            Orientation::RotationVector(Array::new(&some, 3), case.initial[1]),
        );
        for s in (0..32).filter(|s| !odd(*s)) {
            let numbers = s * width..(s + 1) * width;
            assert_eq!(rows[numbers.clone()], usual.1[numbers], "state {s}, beside {strange}");
            compared += 1;
        }
    }
    assert_eq!(compared, 6 * 32 + 5 * 24);
}

/// The sum of no rows is zero, whatever was there.
#[test]
fn no_rows_have_no_stiffness() {
    let draw = &mut Draw::new("rows, none");
    let case = case(&ConnectionType::named("LINK", None).unwrap(), draw, 5).unwrap();
    let still = Node { displacement: [0.0; 3], triad: vector::identity(), flow: 0.0 };
    let pair = Pair { reference: [1.0, 0.0, 0.0], a: still, b: still };
    let link = Connector::<f64>::new(&Definition::new(ConnectionType::named("LINK", None).unwrap(), pair));
    let none = Batch::new(&link, [false; 6]).unwrap();
    let tiles = case.tiles();
    let (sections, histories) = (vec![case.sections[0]; tiles.len()], vec![case.histories[0]; tiles.len()]);
    let mut found = vec![[[[f64::NAN; 4]; 12]; 12]; tiles.len()];
    none.geometric_stiffness_of(&tiles, &sections, &histories, &[], &mut found).unwrap();
    assert!(!found.is_empty());
    assert_eq!(found, vec![[[[0.0; 4]; 12]; 12]; tiles.len()]);
    let shared = [0.0; 9];
    let node = Nodes {
        displacement: Array::shared(&shared),
        orientation: Orientation::Triad(Array::shared(&shared)),
    };
    let states = States {
        count: 5,
        reference: Array::shared(&shared),
        nodes: [node; 2],
        sections: &case.sections,
        histories: &case.histories,
    };
    let still = Velocities { velocity: Array::shared(&shared), angular_velocity: Array::shared(&shared) };
    let mut changes = vec![f64::NAN; 60];
    none.geometric_stiffness_along_of_states(&states, &[], [still; 2], &mut changes).unwrap();
    assert_eq!(changes, vec![0.0; 60]);
}

/// J̇v and Σ λ ∂²c of every type, from tiles and from arrays: the second derivatives of its rows, contracted.
#[test]
fn products_are_those_of_second_derivatives() {
    const COUNT: usize = 45;
    let draw = &mut Draw::new("rows, products");
    let mut compared = 0;
    for connection in TABLE {
        let Some(case) = case(connection, draw, COUNT) else { continue };
        for batch in [case.batch.clone(), case.batch.clone().baseline()] {
            let (each, tiles) = (batch.rows(), case.tiles());
            let (sections, histories) =
                (vec![case.sections[0]; tiles.len()], vec![case.histories[0]; tiles.len()]);
            let mut second = vec![HessianRow::default(); tiles.len() * each];
            batch.rows_of(&tiles, &sections, &histories, &mut second).unwrap();
            let mut velocities = vec![[[0.0; 4]; 12]; tiles.len()];
            velocities.as_flattened_mut().as_flattened_mut().fill_with(|| draw.vector(2.0)[0]);
            let mut multipliers = vec![[0.0; 4]; tiles.len() * each];
            multipliers.as_flattened_mut().fill_with(|| draw.vector(2.0)[0]);
            let mut bias = vec![[f64::NAN; 4]; tiles.len() * each];
            batch.bias_of(&tiles, &sections, &histories, &velocities, &mut bias).unwrap();
            let mut stiffness = vec![[[[f64::NAN; 4]; 12]; 12]; tiles.len()];
            batch
                .geometric_stiffness_of(&tiles, &sections, &histories, &multipliers, &mut stiffness)
                .unwrap();
            let mut along = vec![[[f64::NAN; 4]; 12]; tiles.len()];
            batch
                .geometric_stiffness_along(
                    (&tiles, &sections, &histories),
                    &multipliers,
                    &velocities,
                    &mut along,
                )
                .unwrap();
            let is_near = |found: f64, terms: &[f64], what: &str| {
                let (sum, size): (f64, f64) = (terms.iter().sum(), terms.iter().map(|x| x.abs()).sum());
                let is_near = (found - sum).abs() <= 1e-13 * size.max(1.0);
                assert!(is_near, "{}, {what}: {found} for {sum}", connection.name);
            };
            for t in 0..tiles.len() {
                for lane in 0..4 {
                    let entry = |r: usize, i: usize, j: usize| second[t * each + r].hessian[i][j][lane];
                    let v = velocities[t].map(|of| of[lane]);
                    for r in 0..each {
                        let terms: Vec<f64> =
                            (0..144).map(|k| entry(r, k / 12, k % 12) * v[k / 12] * v[k % 12]).collect();
                        is_near(bias[t * each + r][lane], &terms, "bias");
                    }
                    for i in 0..12 {
                        let of = |at: usize| {
                            let (r, j) = (at / 12, at % 12);
                            multipliers[t * each + r][lane] * entry(r, i, j) * v[j]
                        };
                        let terms: Vec<f64> = (0..12 * each).map(of).collect();
                        is_near(along[t][i][lane], &terms, "stiffness along");
                        compared += 1;
                    }
                    for k in 0..144 {
                        let (i, j) = (k / 12, k % 12);
                        let of = |r: usize| multipliers[t * each + r][lane] * entry(r, i, j);
                        is_near(
                            stiffness[t][i][j][lane],
                            &(0..each).map(of).collect::<Vec<f64>>(),
                            "stiffness",
                        );
                        compared += 1;
                    }
                }
            }
            compared +=
                case.products_of_arrays(&batch, &velocities, &multipliers, (&bias, &stiffness, &along));
        }
    }
    assert!(compared > 500_000, "{compared}");
}

impl Case {
    /// The same from arrays, bit by bit.
    fn products_of_arrays(
        &self,
        batch: &Batch,
        velocities: &[[Four; 12]],
        multipliers: &[Four],
        (bias, stiffness, along): (&[Four], &[[Columns12; 12]], &[Columns12]),
    ) -> usize {
        let (count, each) = (self.pairs.len(), batch.rows());
        let reference = self.flat(|s| self.pairs[s].reference);
        let displacement =
            [self.flat(|s| self.pairs[s].a.displacement), self.flat(|s| self.pairs[s].b.displacement)];
        let triad =
            [self.flat(|s| nine(&self.pairs[s].a.triad)), self.flat(|s| nine(&self.pairs[s].b.triad))];
        let node = |end: usize| Nodes {
            displacement: Array::new(&displacement[end], 3),
            orientation: Orientation::Triad(Array::new(&triad[end], 9)),
        };
        let states = States {
            count,
            reference: Array::new(&reference, 3),
            nodes: [node(0), node(1)],
            sections: &self.sections,
            histories: &self.histories,
        };
        let moving: Vec<f64> = self.flat(|s| velocities[s / 4].map(|of| of[s % 4]));
        let of = |first: usize| Velocities {
            velocity: Array::new(&moving[first..], 12),
            angular_velocity: Array::new(&moving[first + 3..], 12),
        };
        let loads: Vec<f64> = (0..count * each)
            .map(|at| multipliers[at / each / 4 * each + at % each][at / each % 4])
            .collect();
        let (mut rates, mut matrices) = (vec![f64::NAN; count * each], vec![f64::NAN; count * 144]);
        batch.bias_of_states(&states, [of(0), of(6)], &mut rates).unwrap();
        batch.geometric_stiffness_of_states(&states, &loads, &mut matrices).unwrap();
        for s in 0..count {
            for r in 0..each {
                assert_eq!(rates[s * each + r], bias[s / 4 * each + r][s % 4]);
            }
            for k in 0..144 {
                assert_eq!(matrices[s * 144 + k], stiffness[s / 4][k / 12][k % 12][s % 4]);
            }
        }
        let mut changes = vec![f64::NAN; count * 12];
        batch.geometric_stiffness_along_of_states(&states, &loads, [of(0), of(6)], &mut changes).unwrap();
        for (at, change) in changes.iter().enumerate() {
            let (s, i) = (at / 12, at % 12);
            assert_eq!(*change, along[s / 4][i][s % 4]);
        }
        let refused = batch.bias_of_states(&states, [of(0), of(6)], &mut rates[1..]).unwrap_err();
        assert!(matches!(refused, BatchError::Length { what: "numbers", .. }));
        let refused = batch.geometric_stiffness_of_states(&states, &loads[1..], &mut matrices).unwrap_err();
        assert!(matches!(refused, BatchError::Length { what: "multipliers", .. }));
        rates.len() + matrices.len() + changes.len()
    }
}
