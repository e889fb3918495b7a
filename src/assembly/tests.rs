//! Eliminated against dense singular values, on random sparse matrices whose rank is known.

use crate::facts::{Assembly, Holds, Position};
use crate::found::{Found, look};
use crate::given::along;
use crate::matrix::budget::Budget;
use crate::matrix::contract::Contracted;
use crate::matrix::dense::{least, made_of, singular_values};
use crate::matrix::echelon;
use crate::matrix::eliminate::{Eliminated, Most, Task, eliminate};
use crate::matrix::naming::named;
use crate::matrix::order::minimum_degree;
use crate::matrix::sparse::{Sparse, largest};
use crate::moving::only_here;
use crate::prescribed::Prescribed;
use crate::redundant::judge;
use crate::system::{System, request};
use pintle_kinematics::draw::Draw;
use pintle_model::evaluate::{Fixed, Jacobian, Model, Plan, Sequence};
use pintle_scene::{Scene, State};

/// Rows over two or three groups of three columns each; of the last `dependent` rows each is a sum of multiples of three others that
/// share their groups.
fn random(groups: usize, independent: usize, dependent: usize, draw: &mut Draw) -> Sparse {
    let mut matrix = Sparse { offsets: vec![0], ..Sparse::default() };
    matrix.groups = (0..=groups as u32).map(|group| 3 * group).collect();
    let mut rows: Vec<Vec<(u32, f64)>> = Vec::new();
    for i in 0..independent {
        // Neighbours share groups, so that some rows touch the same columns.
        let (first, second) = (i % groups, (i + 1 + draw.below(2)) % groups);
        let columns = [first, second].map(|group| (0..3).map(move |k| (3 * group + k) as u32));
        rows.push(columns.into_iter().flatten().map(|column| (column, draw.between(-1.0, 1.0))).collect());
    }
    for _ in 0..dependent {
        let mut sum = vec![0.0; 3 * groups];
        for _ in 0..3 {
            let (of, times) = (draw.below(independent), draw.between(0.5, 2.0));
            rows[of].iter().for_each(|(column, value)| sum[*column as usize] += times * value);
        }
        let entries = sum.iter().enumerate().filter(|(_, value)| **value != 0.0);
        rows.push(entries.map(|(column, value)| (column as u32, *value)).collect());
    }
    for row in rows {
        let mut row: Vec<(u32, f64)> = row;
        row.sort_by_key(|(column, _)| *column);
        row.dedup_by_key(|(column, _)| *column);
        for (column, value) in row {
            matrix.columns.push(column);
            matrix.values.push(value);
        }
        matrix.offsets.push(matrix.columns.len());
    }
    matrix
}

/// A deck, with all that is analysed of it.
struct Read {
    model: Model,
    plan: Plan,
    prescribed: Prescribed,
}

impl Read {
    fn of(text: &str) -> Self {
        let scene = Scene::parse("scene.inp", text).unwrap();
        let model = Model::compile(&scene).unwrap();
        let prescribed = Prescribed::of(&scene, 1).unwrap();
        Self { plan: Plan::everything(&model, request()), model, prescribed }
    }

    fn system(&self) -> System<'_> {
        System::new(&self.model, &self.plan, &self.prescribed)
    }

    /// What is found of the first connected component where everything is as it was given.
    fn found(&self, system: &System<'_>) -> Found {
        let mut values = Vec::new();
        let mut sequence = Sequence::new(&self.model, &self.plan);
        sequence.assemble(&State::default(), &system.jacobian, &mut values).unwrap();
        look(system, (&State::default(), &values), (&[], &[]), true).swap_remove(0).unwrap()
    }
}

fn unlimited() -> Budget {
    Budget::new(u64::MAX)
}

/// The rows that depend on those before them in an order, ascending: by what of each is orthogonal to these.
pub(crate) fn reference(matrix: &Sparse, order: &[u32]) -> Vec<u32> {
    /// What is left of a row of length one.
    const ZERO: f64 = 1e-9;
    let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
    let (mut basis, mut dependent): (Vec<Vec<f64>>, Vec<u32>) = (Vec::new(), Vec::new());
    for name in order.iter().copied() {
        let mut rest = vec![0.0; matrix.width()];
        matrix.range(name as usize).for_each(|at| rest[matrix.columns[at] as usize] = matrix.values[at]);
        let whole = dot(&rest, &rest).sqrt();
        for other in basis.iter().chain(&basis) {
            let along = dot(other, &rest);
            rest.iter_mut().zip(other).for_each(|(x, y)| *x -= along * y);
        }
        let left = dot(&rest, &rest).sqrt();
        if left > ZERO * whole {
            basis.push(rest.iter().map(|x| x / left).collect());
        } else {
            dependent.push(name);
        }
    }
    dependent.sort_unstable();
    dependent
}

/// The rows in the order in which they are taken to hold: those that make bodies first.
fn in_order(contracted: &Contracted, rows: usize) -> Vec<u32> {
    let others = (0..rows as u32).filter(|row| !contracted.made_by.contains(row));
    contracted.made_by.iter().copied().chain(others).collect()
}

/// What is found of a system where everything is as it was given.
fn analysed(system: &System<'_>) -> Assembly {
    let mut assembly = Assembly::none(1);
    crate::of_system(system, &[], &|_| true, &mut assembly);
    assembly
}

fn order(matrix: &Sparse) -> Vec<u32> {
    minimum_degree(&vec![1; matrix.groups.len() - 1], &cliques(matrix), usize::MAX).unwrap_or_default()
}

fn cliques(matrix: &Sparse) -> Vec<Vec<u32>> {
    let of: Vec<u32> = matrix
        .groups
        .windows(2)
        .zip(0..)
        .flat_map(|(ends, group)| (ends[0]..ends[1]).map(move |_| group))
        .collect();
    let clique = |row: usize| -> Vec<u32> {
        let mut groups: Vec<u32> =
            matrix.columns[matrix.range(row)].iter().map(|column| of[*column as usize]).collect();
        groups.dedup();
        groups
    };
    (0..matrix.rows()).map(clique).collect()
}

/// J q, without cancellation errors that matter.
fn largest_product(matrix: &Sparse, vector: &[f64]) -> f64 {
    let row = |row: usize| {
        matrix.range(row).map(|at| matrix.values[at] * vector[matrix.columns[at] as usize]).sum::<f64>().abs()
    };
    (0..matrix.rows()).map(row).fold(0.0, f64::max)
}

#[test]
fn rank_is_that_of_singular_values() {
    let mut draw = Draw::new("assembly");
    for case in 0..200 {
        let groups = 3 + draw.below(20);
        let independent = 1 + draw.below(3 * groups + 4);
        let dependent = draw.below(6);
        let matrix = random(groups, independent, dependent, &mut draw);
        let outcome = eliminate(&matrix, &order(&matrix), Task { keep: true, ..Task::default() });
        let values = singular_values(&matrix);
        let largest = values.first().copied().unwrap_or_default();
        let rank = values.iter().filter(|value| **value > 1e-12 * largest).count();
        assert_eq!(outcome.rank, rank, "case {case}: {values:?} {:?} {:?}", outcome.gap, outcome.doubtful);
        assert_eq!(outcome.dependent.len(), matrix.rows() - rank, "case {case}");
        assert_eq!(outcome.free.len(), matrix.width() - rank, "case {case}");
        // The pivots leave null vectors that are.
        for column in &outcome.free {
            let vector = outcome.solve(matrix.width(), |other| f64::from(u8::from(other == *column)), true);
            let size = vector.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
            assert!(largest_product(&matrix, &vector) < 1e-10 * size, "case {case}");
        }
        // And each dependent row is made of others.
        let of_all = made_of(&matrix, &outcome.dependent);
        assert_eq!(of_all.len(), outcome.dependent.len(), "case {case}");
        for (row, made) in outcome.dependent.iter().zip(of_all) {
            assert!(!made.is_empty() && !made.contains(row), "case {case}");
        }
    }
}

/// Without the rows that are named the rank is the same: always where elimination says so. Where it does not, as here of a tenth of the cases,
/// and always otherwise, those are named that depend on rows before them.
#[test]
fn what_is_named_can_be_left_out() {
    let mut draw = Draw::new("names");
    let mut misnamed = 0;
    for case in 0..200 {
        let groups = 3 + draw.below(8);
        let matrix = random(groups, 2 * groups + draw.below(2 * groups), 1 + draw.below(9), &mut draw);
        let order = order(&matrix);
        let rank_without = |dependent: &[u32]| {
            let rest = (0..matrix.rows()).filter(|row| !dependent.contains(&(*row as u32)));
            let mut some = Sparse { groups: matrix.groups.clone(), offsets: vec![0], ..Sparse::default() };
            for row in rest {
                some.columns.extend_from_slice(&matrix.columns[matrix.range(row)]);
                some.values.extend_from_slice(&matrix.values[matrix.range(row)]);
                some.offsets.push(some.columns.len());
            }
            let values = singular_values(&some);
            values.iter().filter(|value| **value > 1e-11 * values[0]).count()
        };
        let outcome = eliminate(&matrix, &order, Task::default());
        let is_right = rank_without(&outcome.dependent) == outcome.rank;
        assert!(is_right || outcome.misnames, "case {case}");
        misnamed += usize::from(!is_right);
        let last = reference(&matrix, &(0..matrix.rows() as u32).collect::<Vec<_>>());
        let in_echelon = echelon::dependent(&matrix, (&order, &[]), last.len(), &unlimited());
        assert_eq!(in_echelon.as_ref(), Some(&last), "case {case}");
        assert_eq!(
            (last.len(), rank_without(&last)),
            (matrix.rows() - outcome.rank, outcome.rank),
            "case {case}"
        );
    }
    assert!(misnamed > 0);
}

/// The order does not matter to what is found, but for which rows and columns are named.
#[test]
fn every_order_finds_the_same_rank() {
    let mut draw = Draw::new("orders");
    for case in 0..40 {
        let groups = 3 + draw.below(60);
        let matrix = random(groups, 1 + draw.below(3 * groups + 4), draw.below(6), &mut draw);
        let orders = [order(&matrix), (0..groups as u32).collect()];
        let found = orders.map(|order| eliminate(&matrix, &order, Task::default()));
        assert_eq!(found[0].rank, found[1].rank, "case {case}");
        assert_eq!(found.map(|found| found.is_decided()), [true; 2], "case {case}");
    }
}

/// What would cost more than it may is given up, and decides nothing.
#[test]
fn what_costs_too_much_is_given_up() {
    let matrix = grid(10, 0.0);
    let order = order(&matrix);
    let all = eliminate(&matrix, &order, Task::default());
    assert!(!all.exhausted && all.is_decided());
    for most in [Most { entries: 100, ..Most::default() }, Most { work: 1000, ..Most::default() }] {
        let some = eliminate(&matrix, &order, Task { most, ..Task::default() });
        assert!(some.exhausted && !some.is_decided() && some.front > 0, "{most:?}");
    }
}

/// Neither equations without columns, nor columns without equations, nor nothing at all have singular values.
#[test]
fn an_empty_matrix_has_no_singular_values() {
    for (groups, rows) in [(0, 0), (0, 2), (2, 0)] {
        let matrix = Sparse {
            groups: (0..=groups).map(|group| 3 * group).collect(),
            offsets: vec![0; rows + 1],
            ..Sparse::default()
        };
        assert_eq!((matrix.rows(), matrix.width()), (rows, 3 * groups as usize));
        assert!(singular_values(&matrix).is_empty());
        let solution = least(&matrix, &vec![0.0; rows]);
        assert_eq!(solution, Some(vec![0.0; matrix.width()]));
        for row in 0..rows as u32 {
            assert!(made_of(&matrix, &[row]).concat().is_empty());
        }
        let outcome = eliminate(&matrix, &order(&matrix), Task { keep: true, ..Task::default() });
        assert_eq!((outcome.rank, outcome.free.len()), (0, matrix.width()));
        assert_eq!(outcome.dependent.len(), rows);
    }
}

/// What is no finite number, or too large to tell its uncertainty, leaves the rank undecided; large and small numbers by themselves do
/// not: only ratios count.
#[test]
fn what_is_not_finite_decides_nothing() {
    let rank_of = |values: Vec<f64>| {
        let matrix = Sparse {
            groups: vec![0, 2],
            offsets: vec![0, 2, 4],
            columns: vec![0, 1, 0, 1],
            values,
            ..Sparse::default()
        };
        let outcome = eliminate(&matrix, &order(&matrix), Task::default());
        (outcome.rank, outcome.is_decided())
    };
    let rank = |entry: f64| rank_of(vec![entry, 2.0 * entry, entry, -entry]);
    for entry in [f64::NAN, f64::INFINITY, 1e300] {
        assert!(!rank(entry).1, "{entry}");
    }
    for entry in [1.0, 1e25, 1e-25] {
        assert_eq!(rank(entry), (2, true), "{entry}");
    }
    // Of rounding a pivot is not made, however small the entries.
    assert_eq!(rank_of(vec![0.3e-30, 0.1e-30, 0.9e-30, (0.1e-30 * 3.0) * (1.0 + 1e-15)]).0, 1);
}

/// A residual that is no number is the worst of all.
#[test]
fn the_largest_keeps_what_is_no_number() {
    assert_eq!(largest(&[1.0, -3.0, 2.0]), 3.0);
    assert!(largest(&[1.0, f64::NAN, 2.0]).is_nan());
    assert!(largest(&[f64::NAN, 1.0]).is_nan());
}

/// A connected component that is too dear has no ranks; the other connected components have theirs, and what can be counted is counted.
#[test]
fn what_is_too_large_is_undecided_and_nothing_else_is() {
    let text = "*NODE\n1, 0., 0., 0.\n2, 1., 0.5, 0.\n3, 2., 0., 0.25\n4, 5., 0., 0.\n5, 5., 1., 0.\n\
                *ELEMENT, TYPE=CONN3D2, ELSET=L\n1, 1, 2\n2, 2, 3\n5, 1, 3\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n3, 4, 5\n4, 4, 5\n\
                *CONNECTOR SECTION, ELSET=L\nLINK\n*CONNECTOR SECTION, ELSET=C\nBEAM\n*BOUNDARY\n4, 1, 6\n";
    let read = Read::of(text);
    let system = read.system();
    assert_eq!(system.components.len(), 2);
    let analysed = |system: &System<'_>| {
        let mut assembly = Assembly::none(1);
        crate::of_system(system, &[State::default()], &|_| true, &mut assembly);
        assembly
    };
    let whole = analysed(&system);
    assert_eq!((whole.positions[0].rank, whole.is_decided()), (Some(9), true));
    let mut system = read.system();
    system.components[0].most.work = 100;
    let component = analysed(&system);
    let counted = |of: &Assembly| {
        (of.degrees_of_freedom, of.held, of.constraints, of.drives, of.gruebler, of.connected_components)
    };
    assert_eq!(counted(&component), (21, 6, 15, 0, 0, 2));
    assert_eq!(counted(&component), counted(&whole));
    assert_eq!((component.redundant.len(), component.redundant == whole.redundant), (6, true));
    assert!(component.modes.is_empty() && !component.is_decided());
    assert_eq!(component.positions.len(), 2);
    for position in &component.positions {
        let Position { rank, mobility, undriven, redundant, overdriven, .. } = position;
        assert_eq!([rank, mobility, undriven, redundant, overdriven], [&None; 5]);
    }
    assert_eq!((component.skipped.len(), component.skipped[0].connectors), (1, 3));
}

/// What was not looked at is not decided.
#[test]
fn nothing_decides_nothing() {
    assert!(!Assembly::none(1).is_decided());
}

/// The constraints of a sheared n by n grid of four-bars: bars of length one between crossings, each with both of its ends, hinged to the next end at
/// the crossing; the first end is held. Coordinates are rounded, so that the meshes are parallelograms to rounding only, and the more so the farther
/// the origin.
fn grid(n: usize, origin: f64) -> Sparse {
    let at = |i: usize, j: usize| [origin + i as f64 + 0.2 * j as f64, origin + j as f64];
    let mut nodes: Vec<[f64; 2]> = Vec::new();
    let (mut bars, mut hinges) = (Vec::new(), Vec::new());
    let mut ends = vec![Vec::new(); n * n];
    for (i, j) in (0..n * n).map(|place| (place / n, place % n)) {
        for (k, l) in [(i + 1, j), (i, j + 1)].into_iter().filter(|(k, l)| *k < n && *l < n) {
            bars.push([nodes.len(), nodes.len() + 1]);
            ends[i * n + j].push(nodes.len());
            ends[k * n + l].push(nodes.len() + 1);
            nodes.extend([at(i, j), at(k, l)]);
        }
    }
    for ends in &ends {
        hinges.extend(ends.windows(2).map(|pair| [pair[0], pair[1]]));
    }
    let mut matrix = Sparse { offsets: vec![0], ..Sparse::default() };
    // The first node is held: it has no columns.
    matrix.groups = (0..nodes.len() as u32).map(|group| 6 * group).collect();
    let mut put = |[a, b]: [usize; 2], k: usize, levers: &[(usize, f64)]| {
        let of_a = levers.iter().copied().chain([(k, -1.0)]).map(|(k, value)| (a, k, value));
        let mut row: Vec<(usize, usize, f64)> =
            of_a.chain([(b, k, 1.0)]).filter(|(node, ..)| *node > 0).collect();
        row.sort_by_key(|(node, k, _)| (*node, *k));
        for (node, k, value) in row {
            matrix.columns.push((6 * (node - 1) + k) as u32);
            matrix.values.push(value);
        }
        matrix.offsets.push(matrix.columns.len());
    };
    for bar in bars {
        let [x, y] = [0, 1].map(|k| nodes[bar[1]][k] - nodes[bar[0]][k]);
        put(bar, 0, &[(5, y)]);
        put(bar, 1, &[(5, -x)]);
        put(bar, 2, &[(3, -y), (4, x)]);
        (3..6).for_each(|k| put(bar, k, &[]));
    }
    for hinge in hinges {
        (0..5).for_each(|k| put(hinge, k, &[]));
    }
    matrix.rough = vec![2.0 * (origin + n as f64) as f32; matrix.rows()];
    matrix
}

/// Every row and every column of meshes can be sheared, 2 n − 3 ways in all. What is zero is so to rounding, and what is not is far from it,
/// though one pivot comes after the other across the grid.
#[test]
fn sheared_grids_are_decided() {
    for n in [3, 24, 26] {
        let matrix = grid(n, 0.0);
        let outcome = eliminate(&matrix, &order(&matrix), Task::default());
        assert_eq!(outcome.free.len(), 2 * n - 3);
        assert_eq!(outcome.dependent.len(), matrix.rows() + 2 * n - 3 - matrix.width());
        assert!(outcome.is_decided());
        // All are named.
        let contracted = Contracted::of(&matrix, 0.0);
        let order = minimum_degree(&contracted.widths(), &contracted.cliques(), usize::MAX).unwrap();
        let all = named(&matrix, &contracted, &order, Task::default(), &unlimited());
        assert_eq!((all.rank, all.dependent.len()), (outcome.rank, outcome.dependent.len()));
        assert!(outcome.gap[0] < 1e-13 && outcome.gap[1] > 1e-4, "{n}: {:?}", outcome.gap);
        // Rows stay as sparse as they are.
        assert!(outcome.fill < 3 * matrix.rows(), "{n}: {} of {}", outcome.fill, matrix.rows());
    }
}

/// Far from the origin the rounding of coordinates is no less than that of the elimination: where it is known the rank is certain, and where
/// it is not, what it leaves of redundant rows looks like more than rounding.
#[test]
fn rounded_coordinates_are_uncertain() {
    for origin in [12_345.678, 1e6] {
        let mut matrix = grid(10, origin);
        let known = eliminate(&matrix, &order(&matrix), Task::default());
        assert_eq!((known.free.len(), known.is_decided()), (17, true), "{origin}: {:?}", known.gap);
        matrix.rough.clear();
        assert!(!eliminate(&matrix, &order(&matrix), Task::default()).is_decided(), "{origin}");
    }
}

/// As many redundancies hold here only as there are fewer elsewhere, whichever are named there.
#[test]
fn as_many_hold_here_as_are_gone_elsewhere() {
    assert_eq!(only_here(&[1, 4, 7, 9], &[1, 4, 9]), [7]);
    assert_eq!(only_here(&[1, 4, 7, 9], &[1, 4, 8]), [9]);
    assert!(only_here(&[1, 4], &[2, 3]).is_empty());
    assert_eq!(only_here(&[1, 4], &[]), [4, 1]);
}

/// What cannot be assembled is told, and so is what comes first.
#[test]
fn what_is_not_assembled_is_told() {
    let text = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 2., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n1, 1, 2\n2, 2, 3\n\
                *CONNECTOR SECTION, ELSET=C\nBEAM\n";
    let read = Read::of(text);
    let mut system = read.system();
    let told = |system: &System<'_>| {
        let mut assembly = Assembly::none(1);
        along(
            system,
            (&[State { number: Some(7), ..State::default() }, State::default()], &|_| true),
            &[],
            0,
            &mut assembly,
        );
        (assembly.positions.len(), assembly.not_assembled.and_then(|at| at.state))
    };
    assert_eq!(told(&system), (2, None));
    // The pattern of another plan.
    let first = Plan { connectors: vec![0], ..read.plan.clone() };
    system.jacobian = Jacobian::new(&read.model, &first, &Fixed::none(), |_, _| true);
    assert_eq!(told(&system), (0, Some(7)));
}

/// The deck of rigid bars and of hinges about z between pairs of nodes, in the plane of x and y; one node is grounded.
fn linkage(nodes: &str, bars: &[[usize; 2]], hinges: &[[usize; 2]], grounded: usize) -> String {
    let lines = |all: &[[usize; 2]], first: usize| -> String {
        all.iter().enumerate().map(|(n, [a, b])| format!("{}, {a}, {b}\n", n + first)).collect()
    };
    format!(
        "*NODE\n{nodes}*ELEMENT, TYPE=CONN3D2, ELSET=L\n{}*ELEMENT, TYPE=CONN3D2, ELSET=H\n{}*ORIENTATION, NAME=Z\n0., 0., 1., 1., 0., 0.\n\
         *CONNECTOR SECTION, ELSET=H\nHINGE\nZ,\n*CONNECTOR SECTION, ELSET=L\nBEAM\n*BOUNDARY\n{grounded}, 1, 6\n",
        lines(bars, 1),
        lines(hinges, bars.len() + 1)
    )
}

/// A chain of planar four-bars with bars between them, hinged about z, the first bar on the ground; those whose number is in `flat` are
/// parallelograms folded flat, where there is one motion more.
fn four_bars(count: usize, flat: &[usize]) -> String {
    let (mut nodes, mut bars, mut hinges) = (Vec::<[f64; 2]>::new(), Vec::new(), Vec::new());
    let mut last = None;
    for n in 0..count {
        let x = 5.0 * n as f64;
        let at = if flat.contains(&n) {
            [[0.0, 0.0], [1.0, 0.0], [3.0, 0.0], [2.0, 0.0]]
        } else {
            [[0.0, 0.0], [0.125, 1.0], [1.5, 1.25], [2.0, 0.0]]
        };
        let mut ends: Vec<Vec<usize>> = vec![Vec::new(); 4];
        let mut bar = |from: [f64; 2], to: [f64; 2]| {
            bars.push([nodes.len() + 1, nodes.len() + 2]);
            nodes.extend([from, to]);
            [nodes.len() - 1, nodes.len()]
        };
        let point = |k: usize| [at[k][0] + x, at[k][1]];
        for k in 0..4 {
            let [from, to] = bar(point(k), point((k + 1) % 4));
            ends[k].push(from);
            ends[(k + 1) % 4].push(to);
        }
        ends[0].extend(last);
        let [from, to] = bar(point(3), [x + 5.0, 0.0]);
        ends[3].push(from);
        last = Some(to);
        hinges.extend(
            ends.iter().flat_map(|of| of.windows(2).map(|pair| [pair[0], pair[1]]).collect::<Vec<_>>()),
        );
    }
    let nodes: String =
        nodes.iter().enumerate().map(|(n, [x, y])| format!("{}, {x:?}, {y:?}, 0.\n", n + 1)).collect();
    linkage(&nodes, &bars, &hinges, 1)
}

/// Of a chain of four-bars one that is folded flat has a redundancy of this position alone; all others hold throughout.
#[test]
fn what_is_flat_holds_here_alone() {
    for (flat, here) in [(&[][..], 0), (&[1][..], 1)] {
        let read = Read::of(&four_bars(4, flat));
        let system = read.system();
        let holds = judge(&system, &system.components[0], &read.found(&system), &unlimited());
        let count = |of: Holds| holds.iter().filter(|holds| **holds == of).count();
        assert_eq!((count(Holds::Here), count(Holds::Throughout)), (here, holds.len() - here), "{holds:?}");
        assert_eq!(holds.len(), 4 * 3 + here);
    }
}

/// A cubic lattice of n³ nodes moved off it, with LINKs between neighbours and, `besides`, some between next neighbours; the first node is held.
fn lattice(n: usize, besides: &[[usize; 2]]) -> String {
    let at = |i: usize, j: usize, k: usize| (i * n + j) * n + k + 1;
    let mut draw = Draw::new("lattice");
    let (mut nodes, mut links) = (String::new(), Vec::new());
    for (i, j, k) in (0..n * n * n).map(|v| (v / n / n, v / n % n, v % n)) {
        let [x, y, z] = [i, j, k].map(|x| x as f64 + draw.between(-0.1, 0.1));
        nodes += &format!("{}, {x:?}, {y:?}, {z:?}\n", at(i, j, k));
        for (p, q, r) in [(i + 1, j, k), (i, j + 1, k), (i, j, k + 1)] {
            if p.max(q).max(r) < n {
                links.push([at(i, j, k), at(p, q, r)]);
            }
        }
    }
    links.extend(besides);
    let links: String =
        links.iter().enumerate().map(|(m, [a, b])| format!("{}, {a}, {b}\n", m + 1)).collect();
    format!(
        "*NODE\n{nodes}*ELEMENT, TYPE=CONN3D2, ELSET=L\n{links}*CONNECTOR SECTION, ELSET=L\nLINK\n*BOUNDARY\n1, 1, 3\n"
    )
}

/// A lattice with all three diagonals of faces at every corner: more than rigid.
fn braced() -> String {
    let n = 3;
    let at = |i: usize, j: usize, k: usize| (i * n + j) * n + k + 1;
    let mut braces = Vec::new();
    for (i, j, k) in (0..n * n * n).map(|v| (v / n / n, v / n % n, v % n)) {
        for (p, q, r) in [(i + 1, j + 1, k), (i + 1, j, k + 1), (i, j + 1, k + 1)] {
            if p.max(q).max(r) < n {
                braces.push([at(i, j, k), at(p, q, r)]);
            }
        }
    }
    lattice(n, &braces)
}

/// A deck of nodes at random, or at random in a plane or on a grid. Connectors between near ones are BEAMs, and what leaves
/// something free. Some nodes are held, or some of their degrees of freedom, and of some the axes are turned.
fn assembled(draw: &mut Draw) -> String {
    let (count, is_planar, far) =
        (4 + draw.below(7), draw.below(3) == 0, [0.0, 0.0, 1234.567][draw.below(3)]);
    let is_grid = draw.below(3) == 0;
    let mut place = |axis: usize| match (axis, is_planar) {
        (2, true) => 0.0,
        _ if is_grid => draw.below(3) as f64,
        _ => far + draw.between(-2.0, 2.0),
    };
    let nodes: String =
        (1..=count).map(|node| format!("{node}, {:?}, {:?}, {:?}\n", place(0), place(1), place(2))).collect();
    let kinds = ["BEAM", "BEAM", "WELD", "HINGE", "JOIN", "LINK", "ALIGN", "UNIVERSAL"];
    let mut elements = String::new();
    for element in 1..=count + draw.below(2 * count) {
        let [a, b] = [1 + draw.below(count), 1 + draw.below(count)];
        if a != b {
            let kind = kinds[draw.below(kinds.len())];
            elements += &format!(
                "*ELEMENT, TYPE=CONN3D2, ELSET=E{element}\n{element}, {a}, {b}\n*CONNECTOR SECTION, ELSET=E{element}\n{kind}\n{}\n",
                if ["BEAM", "LINK"].contains(&kind) { "" } else { "Z," }
            );
        }
    }
    for mpc in ["BEAM", "TIE", "PIN", "LINK"] {
        if draw.below(3) == 0 {
            elements += &format!(
                "*MPC\n{mpc}, {}, {}\n",
                2 * draw.below(count / 2) + 1,
                2 * draw.below(count / 2) + 2
            );
        }
    }
    let held = match draw.below(4) {
        0 => String::new(),
        1 => "*BOUNDARY\n1, 1, 6\n".into(),
        2 => "*BOUNDARY\n1, 1, 6\n2, 1, 3\n".into(),
        _ => "*TRANSFORM, NSET=T\n0.6, 0.8, 0., -0.8, 0.6, 0.\n*BOUNDARY\n1, 1, 2\n2, 2, 2\n".into(),
    };
    format!(
        "*NODE\n{nodes}*NSET, NSET=T\n1, 2\n*ORIENTATION, NAME=Z\n0., 0., 1., 1., 0., 0.\n{}{held}",
        elements
    )
}

/// What is put together to bodies has the rank, the motions and as many redundant constraints as what is eliminated node by node.
/// Its solutions are solutions. What is named can be left out, in whichever way it was found.
#[test]
fn bodies_have_what_their_nodes_have() {
    let mut draw = Draw::new("bodies");
    let (mut together, mut looked_at) = (0, 0);
    for case in 0..400 {
        let text = assembled(&mut draw);
        let Ok(scene) = Scene::parse("scene.inp", &text) else { continue };
        let Ok(model) = Model::compile(&scene) else { continue };
        let prescribed = Prescribed::of(&scene, 1).unwrap();
        let plan = Plan::everything(&model, request());
        let system = System::new(&model, &plan, &prescribed);
        let mut values = Vec::new();
        let state = State::default();
        Sequence::new(&model, &plan).assemble(&state, &system.jacobian, &mut values).unwrap();
        for component in &system.components {
            let (_, matrix) = system.matrix(component, (&state, &values), |_| true);
            let wanted: Vec<f64> = (0..matrix.width()).map(|_| draw.between(-1.0, 1.0)).collect();
            let product = |row: usize| {
                matrix
                    .range(row)
                    .map(|at| matrix.values[at] * wanted[matrix.columns[at] as usize])
                    .sum::<f64>()
            };
            let right: Vec<f64> = (0..matrix.rows()).map(product).collect();
            let task = Task { keep: true, right: Some(&right), ..Task::default() };
            let by_nodes = eliminate(&matrix, &order(&matrix), task);
            let contracted = Contracted::of(&matrix, 0.0);
            let order_of_bodies = component.order(&contracted).unwrap();
            let by_bodies = contracted.eliminate(&matrix, &order_of_bodies, task);
            if !(by_nodes.is_decided() && by_bodies.is_decided()) {
                continue;
            }
            looked_at += 1;
            together += contracted.made_by.len();
            let numbers =
                |of: &Eliminated| (of.rank, of.redundant(), of.mobility(), of.dependent.len(), of.free.len());
            assert_eq!(numbers(&by_bodies), numbers(&by_nodes), "case {case}\n{text}");
            for column in &by_bodies.free {
                let vector =
                    by_bodies.solve(matrix.width(), |other| f64::from(u8::from(other == *column)), true);
                let size = vector.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
                assert!(largest_product(&matrix, &vector) < 1e-9 * size, "case {case}\n{text}");
            }
            let free = |column: u32| wanted[column as usize];
            let solution = by_bodies.solve(matrix.width(), free, false);
            let off: Vec<f64> = solution.iter().zip(&wanted).map(|(x, y)| x - y).collect();
            let size = solution.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
            assert!(largest_product(&matrix, &off) < 1e-9 * size, "case {case}\n{text}");
            // Rows are named by dense matrices, and alike by those of bodies.
            let last = reference(&matrix, &in_order(&contracted, matrix.rows()));
            assert_eq!(last.len(), by_bodies.redundant(), "case {case}\n{text}");
            let of_rest = last.len() - contracted.dependent.len();
            let free: Vec<u32> =
                by_bodies.free.iter().map(|column| contracted.column(*column).unwrap()).collect();
            let found =
                echelon::dependent(&contracted.rest, (&order_of_bodies, &free), of_rest, &unlimited())
                    .unwrap();
            let mut found: Vec<u32> = found.iter().map(|row| contracted.names[*row as usize]).collect();
            found.extend(&contracted.dependent);
            found.sort_unstable();
            assert_eq!(found, last, "case {case}\n{text}");
        }
    }
    assert!(together > 1000 && looked_at > 200, "{together} {looked_at}");
}

/// n by n pairs of bars that cross in the middle, hinged there and to the next at their ends, about z.
fn scissors(n: usize) -> String {
    let (mut nodes, mut bars, mut pins) = (String::new(), Vec::new(), Vec::new());
    let mut ends: Vec<Vec<usize>> = vec![Vec::new(); (n + 1) * (n + 1)];
    let mut count = 0;
    for (i, j) in (0..n * n).map(|cell| (cell / n, cell % n)) {
        let pin = [[(i, j), (i + 1, j + 1)], [(i + 1, j), (i, j + 1)]].map(|corners| {
            nodes += &format!("{}, {i}.5, {j}.5, 0.\n", count + 1);
            let crossing = count + 1;
            count += 1;
            for (k, l) in corners {
                nodes += &format!("{}, {k}., {l}., 0.\n", count + 1);
                count += 1;
                bars.push([count, crossing]);
                ends[k * (n + 1) + l].push(count);
            }
            crossing
        });
        pins.push(pin);
    }
    pins.extend(ends.iter().flat_map(|ends| ends.windows(2).map(|pair| [pair[0], pair[1]])));
    linkage(&nodes, &bars, &pins, 2)
}

/// In a grid of scissors rows that do not depend on those before them nearly do so: what is named leaves rows that are independent, and well so.
#[test]
fn what_is_left_of_a_grid_is_well_independent() {
    let n = 14;
    let read = Read::of(&scissors(n));
    let system = read.system();
    let found = read.found(&system);
    let outcome = &found.constraints;
    assert!(outcome.is_decided() && outcome.names_all() && outcome.mobility() == 1);
    let mut values = Vec::new();
    let state = State::default();
    Sequence::new(&read.model, &read.plan).assemble(&state, &system.jacobian, &mut values).unwrap();
    let (rows, matrix) = system.matrix(&system.components[0], (&state, &values), |_| true);
    // Hinges are named, not the rigid bars.
    let bars = 4 * n * n;
    let number = |row: &u32| match crate::found::constraint(&system, rows[*row as usize]).element {
        Some(element) => element.to_string().parse::<usize>().unwrap(),
        None => 0,
    };
    assert!(outcome.dependent.iter().all(|row| number(row) > bars));
    let is_left = |row: &u32| outcome.dependent.binary_search(row).is_err();
    let left: Vec<u32> = (0..matrix.rows() as u32).filter(is_left).collect();
    let some = matrix.with_rows(&left);
    let alone = eliminate(&some, &order(&some), Task::default());
    assert_eq!((alone.rank, alone.dependent.len()), (outcome.rank, 0));
    assert!(alone.is_decided() && alone.gap[1] > 1e-4 * outcome.gap[1], "{:?} {:?}", alone.gap, outcome.gap);
    // Moved, it tells that all hold throughout.
    let holds = judge(&system, &system.components[0], &found, &unlimited());
    assert!(holds.iter().all(|holds| *holds == Holds::Throughout));
}

/// A lattice of BEAMs is one body: nothing is left to be eliminated, and the last ones are named, whole; free, it moves as that body.
#[test]
fn a_lattice_of_beams_is_one_body() {
    let n = 6;
    for (held, mobility) in [("*BOUNDARY\n1, 1, 6\n", 0), ("", 6)] {
        let text = lattice(n, &[]);
        let (text, _) = text.split_once("*BOUNDARY").unwrap();
        let text = text.replace("LINK\n", "BEAM\n") + held;
        let read = Read::of(&text);
        let system = read.system();
        let assembly = analysed(&system);
        let position = &assembly.positions[0];
        let redundant = 6 * (3 * n * n * (n - 1) + 1 - n * n * n);
        assert_eq!(
            (position.decided, position.mobility, position.redundant),
            (true, Some(mobility), Some(redundant))
        );
        assert_eq!((assembly.redundant.len(), assembly.largest_front), (redundant, 12));
        let throughout = |one: &crate::Redundant| one.holds.is_throughout();
        assert!(assembly.redundant.iter().all(throughout), "{:?}", assembly.redundant[0]);
        for six in assembly.redundant.chunks(6) {
            assert!(six.iter().all(|one| one.constraint.element == six[0].constraint.element));
        }
        assert!(assembly.modes.len() == mobility && assembly.modes.iter().all(|mode| mode.moving.is_some()));
    }
}

/// A grid of n by n nodes one apart, joined along x by universal joints and along y by hinges about z: free, and singular where it lies.
fn frame(n: usize) -> String {
    let at = |i: usize, j: usize| i * n + j + 1;
    let nodes: String =
        (0..n * n).map(|v| format!("{}, {}, {}, 0\n", at(v / n, v % n), v / n, v % n)).collect();
    let cells = || (0..n * n).map(|v| (v / n, v % n));
    let along = cells().filter(|(i, _)| i + 1 < n).map(|(i, j)| [at(i, j), at(i + 1, j)]);
    let across = cells().filter(|(_, j)| j + 1 < n).map(|(i, j)| [at(i, j), at(i, j + 1)]);
    let lines = |all: &mut dyn Iterator<Item = [usize; 2]>, first: usize| -> String {
        all.enumerate().map(|(k, [a, b])| format!("{}, {a}, {b}\n", k + first)).collect()
    };
    let [universal, hinges] = [lines(&mut along.into_iter(), 1), lines(&mut across.into_iter(), n * n)];
    format!(
        "*NODE\n{nodes}*ORIENTATION, NAME=Z\n0., 0., 1., 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=U\n{universal}\
         *CONNECTOR SECTION, ELSET=U\nUJOINT\nZ,\n*ELEMENT, TYPE=CONN3D2, ELSET=H\n{hinges}*CONNECTOR SECTION, ELSET=H\nHINGE\nZ,\n"
    )
}

/// The operations that were spent on where redundancies hold, and what is told of them.
fn judged(system: &System<'_>, found: &[Option<Found>], most: u64) -> (u64, Vec<Holds>) {
    let budget = Budget::new(most);
    let redundant = crate::redundant::redundant(system, found, &[], &budget);
    (budget.spent(), redundant.into_iter().map(|one| one.holds).collect())
}

/// What is too dear to be judged is told to be so, after as many operations as may be spent, and by any number of threads the same; what is not is judged.
#[test]
fn what_follows_the_rank_ends() {
    const MOST: u64 = 15_000_000;
    for (n, is_judged) in [(3, true), (5, false)] {
        let read = Read::of(&frame(n));
        let system = read.system();
        let found = [Some(read.found(&system))];
        let count = found.iter().flatten().map(|found| found.constraints.redundant()).sum();
        let by = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| judged(&system, &found, MOST))
        };
        let (spent, holds) = by(1);
        assert_eq!((holds.len(), by(3)), (count, (spent, holds.clone())), "{n}");
        assert!(count > 0 && spent < 2 * MOST, "{n}: {spent}");
        assert_eq!(holds.iter().all(|holds| *holds != Holds::Spent), is_judged, "{n}: {spent} {holds:?}");
        assert!(!holds.contains(&Holds::Unjudged), "{n}");
        assert_eq!(spent >= MOST, !is_judged, "{n}: {spent}");
    }
}

/// Of connected components that are judged at once each has its own, so that one that is dear leaves what the others need.
#[test]
fn shares_are_known_before() {
    let budget = Budget::new(1_000_000_000);
    let [large, small] = [budget.share([900, 1000], 100_000_000), budget.share([1, 1000], 100_000_000)];
    assert_eq!((large.left(), small.left()), (900_000_000, 100_000_000));
    assert!(!large.spend(2_000_000_000) && large.is_spent() && large.left() == 0);
    assert!(small.spend(40_000_000) && small.left() == 60_000_000);
    budget.count(&small);
    assert_eq!((budget.left(), budget.share([1, 2], 0).left()), (960_000_000, 480_000_000));
    budget.count(&large);
    assert!(budget.is_spent() && budget.share([1, 1], 7).is_spent());
}

/// What is not enough for names leaves the rank, and the number of what is redundant.
#[test]
fn names_that_are_too_dear_are_not_sought() {
    let read = Read::of(&braced());
    let system = read.system();
    let mut values = Vec::new();
    let state = State::default();
    Sequence::new(&read.model, &read.plan).assemble(&state, &system.jacobian, &mut values).unwrap();
    let (_, matrix) = system.matrix(&system.components[0], (&state, &values), |_| true);
    let contracted = Contracted::of(&matrix, 0.0);
    let order = system.components[0].order(&contracted).unwrap();
    let by = |most: u64| named(&matrix, &contracted, &order, Task::default(), &Budget::new(most));
    let (all, none) = (by(u64::MAX), by(1));
    assert!(all.names_all() && all.dependent.len() > 8 && all.misnames);
    assert_eq!((none.rank, none.redundant(), none.is_decided()), (all.rank, all.redundant(), true));
    assert!(none.dependent.is_empty());
}
