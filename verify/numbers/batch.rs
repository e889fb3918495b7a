//! Four lanes against one connector at a time: every type that batches take, in every region of the sampler, with elements of
//! different regions, and so of different branches, in one tile.

use crate::states::{Case, Draw, Ends, cases, dof_size};
use crate::tolerance;
use pintle_audit::singular::atlas::random_near;
use pintle_kinematics::batch::{
    Batch, BatchError, CompactRow, Fours, HessianRow, History, Poses, Row, Section, Tile, Triads, Watch,
};
use pintle_kinematics::catalog::{ConnectionType, TABLE};
use pintle_kinematics::connector::{Branch, Connector, Evaluation, Flag, Increment, Request, State, Tally};
use pintle_kinematics::measure::Measure;
use pintle_kinematics::node::{DOFS, Node, Pair};
use pintle_kinematics::so3;
use pintle_kinematics::vector::{apply, dot, identity, product, scale};
use std::collections::BTreeSet;
use std::f64::consts::PI;

const U: f64 = f64::EPSILON / 2.0;

/// A case with its connector and what one connector at a time gives.
struct One {
    case: Case,
    connector: Connector<f64>,
    before: Branch<f64>,
    found: Evaluation<f64>,
}

impl One {
    fn new(case: Case) -> Self {
        let connector = case.connector();
        let before = case.branch_before(&connector);
        let (found, _) = case.evaluate(&Request::everything(2));
        Self { case, connector, before, found }
    }

    fn state(&self) -> &State<f64> {
        &self.case.end().state
    }

    /// The principal value of what is differentiated.
    fn value(&self, k: usize, measure: Measure) -> f64 {
        if self.connector.is_printed_constraint(k) {
            return self.found.residual[k].unwrap();
        }
        if measure.winds() { self.found.turns[k].unwrap().principal } else { self.found.position[k].unwrap() }
    }
}

/// The rotations and translations of a row of fourteen.
fn twelve(row: &[f64; DOFS]) -> [f64; 12] {
    std::array::from_fn(|j| row[if j < 6 { j } else { j + 1 }])
}

fn four<T>(of: impl Fn(usize) -> T) -> [T; 4] {
    std::array::from_fn(of)
}

/// The cases of a type in groups that share their measures.
fn groups(connection: &ConnectionType, extent: crate::states::Extent) -> Vec<Vec<One>> {
    sharing(cases(connection, extent))
}

/// Cases in groups that share their measures.
fn sharing(cases: impl IntoIterator<Item = Case>) -> Vec<Vec<One>> {
    let mut groups: Vec<(Vec<Option<Measure>>, Vec<One>)> = Vec::new();
    for case in cases {
        let one = One::new(case);
        let measures: Vec<Option<Measure>> = (0..6).map(|k| one.connector.differentiated(k)).collect();
        match groups.iter_mut().find(|(key, _)| *key == measures) {
            Some((_, group)) => group.push(one),
            None => groups.push((measures, vec![one])),
        }
    }
    groups.into_iter().map(|(_, group)| group).collect()
}

/// Errors of value, row and second derivatives in units of their tolerances' scale, as the largest of each.
#[derive(Default, Debug)]
struct Worst([f64; 3]);

impl Worst {
    fn note(&mut self, order: usize, difference: f64, scale: f64) {
        let units = if difference == 0.0 { 0.0 } else { difference.abs() / (U * scale) };
        assert!(units.is_finite(), "order {order}: {difference:e} over {scale:e}");
        self.0[order] = self.0[order].max(units);
    }
}

fn compare(one: &One, (k, measure): (usize, Measure), lane: usize, found: &HessianRow, worst: &mut Worst) {
    let size: [f64; 12] = std::array::from_fn(|j| dof_size(if j < 6 { j } else { j + 1 }, one.case.length));
    let row = twelve(&one.found.jacobian[k].unwrap());
    let second = one.found.hessian[k].as_ref().unwrap();
    let hessian: [[f64; 12]; 12] = std::array::from_fn(|j| twelve(&second[if j < 6 { j } else { j + 1 }]));
    let value = one.value(k, measure);
    let mut change = found.row.value[lane] - value;
    if measure.winds() && change.abs() > PI {
        change -= change.signum() * 2.0 * PI;
    }
    let first: f64 = (0..12).map(|j| row[j].abs() * size[j]).sum();
    let scale = value.abs() + first;
    worst.note(0, change, scale);
    let curvature: f64 =
        (0..12).map(|j| (0..12).map(|l| hessian[j][l].abs() * size[j] * size[l]).sum::<f64>()).sum();
    for j in 0..12 {
        let own: f64 = (0..12).map(|l| hessian[j][l].abs() * size[l]).sum();
        worst.note(1, found.row.columns[j][lane] - row[j], scale / size[j] + own);
        for l in 0..12 {
            // Third derivatives are of the order of H²/g. Squares of lengths need not be doubles.
            let bound = (scale + curvature) * (1.0 + curvature / scale);
            worst.note(2, (found.hessian[j][l][lane] - hessian[j][l]) * size[j] * size[l], bound);
        }
    }
}

fn greatest_common_divisor(a: usize, b: usize) -> usize {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

fn check(group: &[One], name: &str, tolerance: [f64; 3], worst: &mut Worst) {
    let Some(batch) = batched(&group[0].connector, name) else { return };
    // A stride without a common factor with the number of cases: neighbours come from different regions, and every case comes.
    let count = group.len();
    let stride = (8..).find(|&stride| greatest_common_divisor(stride, count) == 1).unwrap();
    let order: Vec<&One> = (0..count.next_multiple_of(4)).map(|i| &group[i * stride % count]).collect();
    assert!(
        group.iter().all(|one| order.iter().any(|&of| std::ptr::eq(of, one))),
        "{name}: a case is left out"
    );
    let tiles: Vec<Tile> =
        order.chunks_exact(4).map(|ones| Tile::new(&four(|i| ones[i].state().pair))).collect();
    let sections: Vec<Section> =
        order.chunks_exact(4).map(|ones| Section::new(&four(|i| &ones[i].connector))).collect();
    let histories: Vec<History> =
        order.chunks_exact(4).map(|ones| History::new(&four(|i| ones[i].found.branch))).collect();
    for (batch, unit) in [(batch.clone(), "vector unit"), (batch.baseline(), "baseline")] {
        let count = tiles.len() * batch.rows();
        let mut rows = vec![Row::default(); count];
        let mut compact = vec![CompactRow::default(); count];
        let mut hessians = vec![HessianRow::default(); count];
        batch.rows_of(&tiles, &sections, &histories, &mut rows).unwrap();
        batch.rows_of(&tiles, &sections, &histories, &mut compact).unwrap();
        batch.rows_of(&tiles, &sections, &histories, &mut hessians).unwrap();
        for (i, one) in order.iter().enumerate() {
            for (r, of) in batch.measures().iter().enumerate() {
                let (at, lane) = (i / 4 * batch.rows() + r, i % 4);
                let mut own = Worst::default();
                compare(one, *of, lane, &hessians[at], &mut own);
                for order in 0..3 {
                    let limit = tolerance[order];
                    let found = own.0[order];
                    assert!(
                        found <= limit,
                        "{}, {unit}, {of:?}: order {order} differs by {found:.1} > {limit} units",
                        one.case.name
                    );
                    worst.0[order] = worst.0[order].max(found);
                }
                // The layouts hold the same numbers, but for the fused products of another loop.
                let mut first = Worst::default();
                let row = HessianRow { row: rows[at], hessian: hessians[at].hessian };
                compare(one, *of, lane, &row, &mut first);
                for order in 0..2 {
                    let found = first.0[order];
                    assert!(found <= tolerance[order], "{}: rows differ by {first:?}", one.case.name);
                }
                let CompactRow { value, turning_a, moving_b, turning_b } = compact[at];
                assert_eq!(rows[at].value[lane], value[lane]);
                for j in 0..3 {
                    assert_eq!(rows[at].columns[j][lane], -moving_b[j][lane]);
                    assert_eq!(rows[at].columns[3 + j][lane], turning_a[j][lane]);
                    assert_eq!(rows[at].columns[6 + j][lane], moving_b[j][lane]);
                    assert_eq!(rows[at].columns[9 + j][lane], turning_b[j][lane]);
                }
            }
        }
    }
}

#[test]
fn lanes_equal_one_at_a_time() {
    let mut checked = 0;
    for connection in TABLE {
        let mut worst = Worst::default();
        for group in groups(connection, crate::states::extent(connection)) {
            check(&group, &connection.name, tolerance::BATCH, &mut worst);
        }
        checked += usize::from(worst.0[1] > 0.0);
        println!("{}: {:.1?} units", connection.name, worst.0);
    }
    // SLIPRING and what has a FLOW-CONVERTER are not batched.
    assert!(checked >= TABLE.len() - 5, "only {checked} types differ at all");
}

/// Beside singular points, where measures take other branches than elsewhere, of all types in one test.
#[test]
fn lanes_equal_one_at_a_time_beside_singular_points() {
    let mut checked = 0;
    for connection in TABLE {
        let draw = &mut Draw::new("batch, near");
        let mut worst = Worst::default();
        for group in sharing((0..60).filter_map(|_| random_near(connection, draw))) {
            check(&group, &connection.name, tolerance::BATCH_NEAR, &mut worst);
        }
        checked += usize::from(worst.0[1] > 0.0);
        println!("{}: {:.1?} units", connection.name, worst.0);
    }
    assert!(checked > 20, "only {checked} types differ at all");
}

/// The same connector in another unit of length, 2^k of the old one.
fn in_units(mut case: Case, power: i32) -> Case {
    let unit = 2.0_f64.powi(power);
    let pair = |pair: &mut Pair<f64>| {
        let lengths =
            pair.reference.iter_mut().chain(&mut pair.a.displacement).chain(&mut pair.b.displacement);
        lengths.for_each(|x| *x *= unit);
    };
    pair(&mut case.definition.initial);
    case.path.iter_mut().for_each(|step| pair(&mut step.state.pair));
    case.length *= unit;
    case
}

/// In units of length from 1e−300 to 1e300.
#[test]
fn lanes_equal_one_at_a_time_at_every_scale() {
    let mut checked = 0;
    for connection in TABLE {
        for power in [-990, -500, 500, 990] {
            let mut worst = Worst::default();
            let cases = cases(connection, crate::states::Extent::Full).into_iter().step_by(3);
            for group in sharing(cases.filter(|case| case.length == 1.0).map(|case| in_units(case, power))) {
                check(&group, &connection.name, tolerance::BATCH, &mut worst);
            }
            checked += usize::from(worst.0[1] > 0.0);
            println!("{} in units of 2^{power}: {:.1?} units", connection.name, worst.0);
        }
    }
    assert!(checked > 100, "only {checked} types and units differ at all");
}

/// The batch of a connector; none where it has material flow, and no other failure.
fn batched(connector: &Connector<f64>, name: &str) -> Option<Batch> {
    match Batch::new(connector, [true; 6]) {
        Ok(batch) => Some(batch),
        Err(BatchError::NotBatched(_)) => None,
        Err(error) => panic!("{name}: {error}"),
    }
}

/// A state that is no number stays in its lane.
#[test]
fn what_is_no_number_stays_in_its_lane() {
    let mut compared = 0;
    for connection in TABLE {
        for group in groups(connection, crate::states::extent(connection)) {
            let Some(batch) = batched(&group[0].connector, &connection.name) else { continue };
            for ones in group.chunks_exact(4) {
                let sections = [Section::new(&four(|i| &ones[i].connector))];
                let histories = [History::new(&four(|i| ones[i].found.branch))];
                let rows = |pairs: [Pair<f64>; 4]| {
                    let mut rows = vec![HessianRow::default(); batch.rows()];
                    batch.rows_of(&[Tile::new(&pairs)], &sections, &histories, &mut rows).unwrap();
                    rows
                };
                let pairs = four(|i| ones[i].state().pair);
                let sound = rows(pairs);
                for (spoiled, with) in [(1, f64::NAN), (2, f64::INFINITY)] {
                    let mut spoiling = pairs;
                    spoiling[spoiled].b.displacement = [with; 3];
                    spoiling[spoiled].b.triad = [[with; 3]; 3];
                    for (row, known) in rows(spoiling).iter().zip(&sound) {
                        let name = &ones[spoiled].case.name;
                        assert!(!row.row.value[spoiled].is_finite(), "{name}: {}", row.row.value[spoiled]);
                        for lane in (0..4).filter(|lane| *lane != spoiled) {
                            let numbers = |of: &HessianRow| {
                                let HessianRow { row, hessian } = of;
                                let first = [row.value].into_iter().chain(row.columns);
                                first
                                    .chain(hessian.as_flattened().iter().copied())
                                    .map(|four| four[lane])
                                    .collect::<Vec<f64>>()
                            };
                            assert_eq!(numbers(row), numbers(known), "{name}: lane {lane} beside {with}");
                            compared += 1;
                        }
                    }
                }
            }
        }
    }
    assert!(compared > 5_000, "{compared}");
}

/// A tile by poses from initial triads that are the global axes: the one that the pairs make.
fn placed(pairs: &[Pair<f64>; 4]) -> Tile {
    let axes = identity();
    let initial = Triads::new(&[[&axes; 2]; 4]);
    let ends = pairs.each_ref().map(|pair| [&pair.a, &pair.b]);
    let poses = Poses {
        displacement: [0, 1].map(|end| ends.map(|ends| &ends[end].displacement)),
        rotation: [0, 1].map(|end| ends.map(|ends| &ends[end].triad)),
    };
    let mut tile = Tile::initial(Tile::references(&pairs.map(|pair| pair.reference)), &initial);
    tile.place(&initial, &poses);
    let known = Tile::new(pairs);
    assert_eq!((tile.displacement, tile.triad), (known.displacement, known.triad));
    tile
}

/// Branches from lanes: turns are the same integers, principal angles the same to rounding.
#[test]
fn turns_are_counted_by_the_same_rule() {
    let mut turned = 0;
    for connection in TABLE {
        for group in groups(connection, crate::states::extent(connection)) {
            for ones in group.chunks(4) {
                let at = |i: usize| &ones[i % ones.len()];
                let increments: [Increment<f64>; 4] = four(|i| at(i).case.end().increment);
                let pairs = four(|i| at(i).state().pair);
                let connectors = four(|i| &at(i).connector);
                let mut fours = Fours::new(&connectors).resumed(&four(|i| at(i).before));
                let tile = placed(&pairs);
                let at_state = (&tile, &Section::new(&connectors));
                fours.follow(&ones[0].connector, at_state, &increments, [true; 6], &mut Tally::default());
                for i in 0..4 {
                    let (one, single, after) = (at(i), &at(i).found.branch, fours.branch(i));
                    for (k, turns) in after.turns.iter().enumerate() {
                        let name = &one.case.name;
                        let known = single.turns[k];
                        let whole =
                            |t: pintle_kinematics::connector::Turns<f64>| t.principal + 2.0 * PI * t.turns;
                        assert!(
                            (whole(*turns) - whole(known)).abs() < 1e-12 * (1.0 + whole(known).abs()),
                            "{name} component {k}: {turns:?} where one at a time gives {known:?}"
                        );
                        turned += usize::from(known.turns != 0.0);
                    }
                    assert_eq!(after.euler_sign, single.euler_sign, "{}", one.case.name);
                    let [x, y] = [&after, single].map(|of| of.accumulated + of.accumulated_rest);
                    assert!((x - y).abs() < 1e-12 * (1.0 + y.abs()), "{}: {x} {y}", one.case.name);
                    for j in 0..3 {
                        let (x, y) = (after.rotation_vector[j], single.rotation_vector[j]);
                        assert!((x - y).abs() < 1e-12 * (1.0 + y.abs()), "{}: {x} {y}", one.case.name);
                    }
                }
            }
        }
    }
    assert!(turned > 60, "{turned}");
}

/// Rows of some components are those that all of them have, whichever formula they share.
#[test]
fn some_rows_are_rows_of_all() {
    let mut compared = 0;
    for connection in TABLE {
        let group = groups(connection, crate::states::Extent::Brief).into_iter().next();
        let group = group.unwrap_or_else(|| panic!("{} has no states", connection.name));
        let one = &group[0];
        let Some(whole) = batched(&one.connector, &connection.name) else { continue };
        let input = (
            [Tile::new(&[one.state().pair; 4])],
            [Section::new(&[&one.connector; 4])],
            [History::new(&[one.found.branch; 4])],
        );
        let rows = |batch: &Batch| {
            let mut rows = vec![Row::default(); batch.rows()];
            batch.rows_of(&input.0, &input.1, &input.2, &mut rows).unwrap();
            rows
        };
        let all = rows(&whole);
        for mask in 1..64_u32 {
            let batch = Batch::new(&one.connector, std::array::from_fn(|k| mask >> k & 1 == 1)).unwrap();
            for (row, of) in rows(&batch).iter().zip(batch.measures()) {
                let same = whole.measures().iter().position(|one| one == of).unwrap();
                assert_eq!(*row, all[same], "{}: {of:?} of {mask:b}", connection.name);
                compared += 1;
            }
        }
    }
    assert!(compared > 3_000, "{compared}");
}

/// Of many tiles each gets the rows that it has by itself, though passes go over some of them before the next.
#[test]
fn many_tiles_are_tiles() {
    const TILES: usize = 1000;
    for name in ["TRANSLATOR", "BEAM", "CARDAN"] {
        let connection = ConnectionType::named(name, None).unwrap();
        let group = groups(&connection, crate::states::Extent::Brief).into_iter().next().unwrap();
        let batch = Batch::new(&group[0].connector, [true; 6]).unwrap();
        let all: Vec<[&One; 4]> =
            (0..TILES).map(|tile| four(|lane| &group[(4 * tile + lane) % group.len()])).collect();
        let tiles: Vec<Tile> = all.iter().map(|ones| Tile::new(&ones.map(|one| one.state().pair))).collect();
        let sections: Vec<Section> =
            all.iter().map(|ones| Section::new(&ones.map(|one| &one.connector))).collect();
        let histories: Vec<History> =
            all.iter().map(|ones| History::new(&ones.map(|one| one.found.branch))).collect();
        let rows = |from: usize, count: usize| {
            let mut rows = vec![Row::default(); count * batch.rows()];
            let of = from..from + count;
            let (sections, histories) = (&sections[of.clone()], &histories[of.clone()]);
            batch.rows_of(&tiles[of], sections, histories, &mut rows).unwrap();
            rows
        };
        let together = rows(0, TILES);
        for (tile, own) in together.chunks_exact(batch.rows()).enumerate() {
            assert_eq!(own, rows(tile, 1), "{name}: tile {tile}");
        }
    }
}

/// What has no lanes says so.
#[test]
fn material_flow_is_refused() {
    let initial = Pair::<f64> {
        reference: [1.0, 0.0, 0.0],
        a: Node { displacement: [0.0; 3], triad: identity(), flow: 0.0 },
        b: Node { displacement: [0.0; 3], triad: identity(), flow: 0.0 },
    };
    for name in ["SLIPRING", "RETRACTOR"] {
        let definition = pintle_kinematics::connector::Definition::new(
            ConnectionType::named(name, None).unwrap(),
            initial,
        );
        let connector = Connector::<f64>::new(&definition);
        assert!(matches!(Batch::new(&connector, [true; 6]), Err(BatchError::NotBatched(_))));
    }
}

/// What a [`Watch`] leaves out has no flag: states at every distance from where axes meet, turn away, or nodes coincide.
#[test]
fn what_is_watched_is_flagged() {
    let (mut flagged, mut left_out, mut sets) = (0, 0, BTreeSet::new());
    let mut seed = 1_u64;
    let mut number = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    for connection in TABLE {
        for group in groups(connection, crate::states::extent(connection)) {
            let connector = &group[0].connector;
            if batched(connector, &connection.name).is_none() {
                continue;
            }
            let watch = Watch::new(connector, [true; 6]);
            let section = Section::new(&[connector; 4]);
            let branch = connector.initial_branch();
            let vector = branch.rotation_vector;
            if watch.turns() && dot(vector, vector) > 9.0 {
                continue;
            }
            for (angle, exponent) in [0.0, 0.5 * PI, PI, 2.0]
                .into_iter()
                .flat_map(|angle| [0, 3, 6, 7, 8, 9, 12, 15, 17, 400].map(|exponent| (angle, exponent)))
            {
                let away = 10.0_f64.powi(-exponent);
                let pairs: [Pair<f64>; 4] = std::array::from_fn(|lane| {
                    let unit = |axis: usize| [0, 1, 2].map(|i| if i == axis { 1.0 } else { 0.0 });
                    let mut random = || [number(), number(), number()];
                    let turn = |by: f64, about| so3::matrix(so3::exp_quaternion(scale(about, by)));
                    let a = turn(1.0, random());
                    let relative = product(&turn(angle, unit(lane % 3)), &turn(away, random()));
                    let mut apart = scale(random(), away);
                    apart[2] += if lane == 3 { 1.0 } else { 0.0 };
                    let b = if lane == 3 { apply(&a, apart) } else { apart };
                    let node = |displacement, triad| Node { displacement, triad, flow: 0.0 };
                    Pair { reference: [0.0; 3], a: node([0.0; 3], a), b: node(b, product(&a, &relative)) }
                });
                let beside = watch.beside(&Tile::new(&pairs), &section);
                for (pair, beside) in pairs.iter().zip(beside) {
                    let state = State { pair: *pair, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
                    let margins = connector.margins(&state, &branch, [true; 6]);
                    let still = Increment::none();
                    let flags = connector.flags_of([false; 6], &margins, &still, &state, [&branch; 2]);
                    let is_of_state =
                        |flag: &&Flag| matches!(flag, Flag::Singular { .. } | Flag::IllConditioned { .. });
                    let flag = flags.iter().find(is_of_state);
                    assert!(beside || flag.is_none(), "{} {angle} {exponent}: {flag:?}", connection.name);
                    if let Some(Flag::Singular { at, .. } | Flag::IllConditioned { at, .. }) = flag {
                        sets.insert(*at);
                        flagged += 1;
                    }
                    left_out += usize::from(!beside);
                }
            }
        }
    }
    assert!(flagged > 400 && left_out > 5000, "{flagged} flagged, {left_out} left out");
    assert_eq!(sets.len(), 7, "{sets:?}");
}
