//! Part of a request is part of the whole, bit for bit, and the counter proves that nothing else was computed. An assembly is
//! its halves. What is declared not to matter does not.

use super::{assert_bits, functions};
use crate::states::{Case, Draw, Ends, Extent, cases, definition, exp, extent, moved, pair, types};
use pintle_kinematics::catalog::{Availability, ConnectionType, TABLE};
use pintle_kinematics::connector::{
    Components, Connector, Definition, Evaluation, Mask, Output, Request, Tally,
};
use pintle_kinematics::measure::{Measure, Unit};
use pintle_kinematics::node::{DOF_NUMBER, DOFS};
use pintle_kinematics::vector;

/// The values of an output.
fn values(evaluation: &Evaluation<f64>, output: Output) -> Components<f64> {
    match output {
        Output::CP => evaluation.position,
        Output::CU => evaluation.displacement,
        Output::CCU => evaluation.constitutive,
        Output::CV => evaluation.velocity,
        Output::CA => evaluation.acceleration,
        Output::RES => evaluation.residual,
        Output::RESV => evaluation.residual_rate,
        Output::RESB => evaluation.residual_bias,
        Output::RESA => evaluation.residual_acceleration,
        Output::TURNS => evaluation.turns.map(|turns| turns.map(|turns| turns.turns)),
        // Judged by `Connector::stop_status` and `Connector::margins`, from the position and the state.
        Output::CSLST | Output::MARGIN => [None; 6],
        // Of forces that are given from outside: `laws::forces` and `forces`.
        of_forces if of_forces.is_of_forces() && !of_forces.is_of_behavior() => [None; 6],
        // Not of a connector alone: verify/behavior.rs judges them.
        of_behavior => {
            assert!(of_behavior.is_of_behavior());
            [None; 6]
        }
    }
}

/// The derivatives of component c are the same, bit for bit but for the sign of a zero, which a sum of more zeros may turn.
fn assert_same_derivatives(place: &str, got: &Evaluation<f64>, want: &Evaluation<f64>, c: usize, order: u8) {
    match (order, got.jacobian[c], want.jacobian[c]) {
        (0, None, _) | (_, None, None) => {}
        (1.., Some(got), Some(want)) => {
            for j in 0..DOFS {
                assert_bits(format!("{place}, ∂{j}"), got[j] + 0.0, want[j] + 0.0);
            }
        }
        (_, got, _) => {
            panic!("{place}: a row is {}", if got.is_some() { "not asked for" } else { "missing" })
        }
    }
    match (order, &got.hessian[c], &want.hessian[c]) {
        (0 | 1, None, _) | (_, None, None) => {}
        (2.., Some(got), Some(want)) => {
            for j in 0..DOFS {
                for k in 0..DOFS {
                    assert_bits(format!("{place}, ∂{j}∂{k}"), got[j][k] + 0.0, want[j][k] + 0.0);
                }
            }
        }
        _ => panic!("{place}: second derivatives missing, or not asked for"),
    }
}

/// Component c alone.
const fn only(c: usize) -> Mask {
    let mut mask = [false; 6];
    mask[c] = true;
    mask
}

/// What a request must cost, counted from what it names: measures of the components asked for, each once.
fn cost(connector: &Connector<f64>, case: &Case, request: &Request) -> Tally {
    let mut tally = Tally::default();
    for c in (0..6).filter(|c| request.components()[*c]) {
        let asks = |outputs: &[Output]| outputs.iter().any(|output| request.wants(*output, c));
        let slot = case.definition.connection.slots[c];
        let Some(position) = slot.position() else { continue };
        let differentiated = connector.differentiated(c).expect("a component has a measure");
        // The principal value of an angle that winds, and what a one-form accumulates, are part of the branch.
        let free = |measure: Measure| measure.winds() || measure.is_one_form();
        let own = asks(&[Output::CP, Output::CU, Output::CCU, Output::CSLST]);
        tally.values += u64::from(own && !free(position));
        let shared = own && differentiated == position;
        let residual = slot.is_constrained() && asks(&[Output::RES]);
        tally.values += u64::from(residual && !shared && !free(differentiated));
        let moving = asks(&[Output::CV, Output::CA]);
        tally.rates += u64::from(moving);
        let shared = moving && differentiated == position;
        tally.rates += u64::from(slot.is_constrained() && asks(&[Output::RESV, Output::RESA]) && !shared);
        tally.rates += u64::from(slot.is_constrained() && asks(&[Output::RESB]));
        match request.order {
            0 => {}
            1 => tally.gradients += 1,
            // The row of a one-form is not part of its second derivatives.
            _ => {
                tally.hessians += 1;
                tally.gradients += u64::from(differentiated.is_one_form());
            }
        }
    }
    tally
}

/// Each output alone, each component alone, each order alone: the same bits as in the whole, and no work but their own.
#[test]
fn a_part_is_part_of_the_whole() {
    for connection in types() {
        for case in cases(&connection, extent(&connection)) {
            let connector = case.connector();
            let (whole, _) = case.evaluate(&Request::everything(2));
            let mut requests =
                vec![Request::nothing(2), Request::everything(2), Request::new(&[], [true; 6], 0)];
            // Another output of each component.
            for shift in 0..Output::ALL.len() {
                let mut mixed = Request::nothing((shift % 3) as u8);
                for c in 0..6 {
                    mixed.add(Output::ALL[(shift + 5 * c) % Output::ALL.len()], only(c));
                }
                requests.push(mixed);
            }
            for c in 0..6 {
                for output in Output::ALL {
                    requests.push(Request::new(&[output], only(c), 0));
                    requests.push(Request::new(&[output], [true; 6], 0));
                }
                for order in 0..=2 {
                    requests.push(Request::new(&[], only(c), order));
                    requests.push(Request::new(&Output::ALL, only(c), order));
                    requests.push(Request::new(&[], [true; 6], order));
                }
            }
            for request in requests {
                let (part, tally) = case.evaluate(&request);
                assert_eq!(tally, cost(&connector, &case, &request), "{}: work for {request:?}", case.name);
                assert_eq!(part.branch, whole.branch, "{}: the branch depends on the request", case.name);
                for c in 0..6 {
                    let place = format!("{}, component {}", case.name, c + 1);
                    for output in Output::ALL {
                        // Stops are judged by the position.
                        let stops = output == Output::CP && request.wants(Output::CSLST, c);
                        let asked = request.wants(output, c) || stops;
                        match (asked, values(&part, output)[c], values(&whole, output)[c]) {
                            (false, None, _) | (true, None, None) => {}
                            (true, Some(got), Some(want)) => {
                                assert_bits(format!("{place}, {output:?}"), got, want)
                            }
                            (_, got, _) => panic!("{place}, {output:?}: asked {asked}, got {got:?}"),
                        }
                    }
                    if request.components()[c] {
                        assert_same_derivatives(&place, &part, &whole, c, request.order);
                    } else {
                        assert!(
                            part.jacobian[c].is_none() && part.hessian[c].is_none(),
                            "{place}: not asked for"
                        );
                    }
                }
            }
        }
    }
}

/// Every assembled type and every pair is its translational half beside its rotational half, bit for bit.
#[test]
fn an_assembly_is_its_halves() {
    let request = Request::everything(2);
    let mut count = 0;
    for connection in types() {
        let [Some(translational), Some(rotational)] = connection.halves else { continue };
        count += 1;
        for case in cases(&connection, extent(&connection)) {
            let (whole, _) = case.evaluate(&request);
            for (half, components) in [(translational, 0..3), (rotational, 3..6)] {
                let mut alone = case.clone();
                alone.definition.connection = ConnectionType::basic(half).into();
                let (part, _) = alone.evaluate(&request);
                for c in components {
                    let place = format!("{}, component {} of {}", case.name, c + 1, half.name);
                    for output in Output::ALL {
                        match (values(&part, output)[c], values(&whole, output)[c]) {
                            (None, None) => {}
                            (Some(got), Some(want)) => assert_bits(format!("{place}, {output:?}"), got, want),
                            _ => panic!("{place}, {output:?}: in one only"),
                        }
                    }
                    assert_same_derivatives(&place, &part, &whole, c, 2);
                }
            }
        }
    }
    assert!(count > 40, "only {count} assemblies and pairs");
}

/// A measure depends on what it declares, and on all of it: moving the rest changes no bit of its value, and its derivatives
/// along the rest are exactly zero.
#[test]
fn declared_dependence_is_true() {
    for connection in types() {
        // [translation, rotation, flow] seen to matter, for each component
        let mut seen = [[false; 3]; 6];
        let extent = extent(&connection);
        for case in cases(&connection, extent) {
            let connector = case.connector();
            let (whole, _) = case.evaluate(&Request::everything(2));
            let draw = &mut Draw::new(&format!("dependence {}", case.name));
            for c in 0..6 {
                let Some(measure) = connector.differentiated(c) else { continue };
                let place = format!("{}, component {}", case.name, c + 1);
                let dependence = measure.dependence();
                let declared = [dependence.translation, dependence.rotation, dependence.flow];
                let row = whole.jacobian[c].unwrap();
                let hessian = whole.hessian[c].as_ref().unwrap();
                for j in 0..DOFS {
                    let kind = [0, 0, 0, 1, 1, 1, 2][j % 7];
                    seen[c][kind] |= row[j] != 0.0;
                    // The directions of a turn what is measured in them.
                    let carried = measure.turns_with_a() && (3..6).contains(&j);
                    let matters = (declared[kind] || carried) && connector.active()[j];
                    assert!(matters || row[j] == 0.0, "{place}: ∂{j} = {}, though undeclared", row[j]);
                    for k in 0..DOFS {
                        let zero = hessian[j][k] == 0.0 && hessian[k][j] == 0.0;
                        assert!(matters || zero, "{place}: ∂{j}∂{k} is not zero, though undeclared");
                    }
                }
                if measure.is_one_form() {
                    continue;
                }
                let mut by = [0.0; DOFS];
                for (j, entry) in by.iter_mut().enumerate() {
                    let kind = [0, 0, 0, 1, 1, 1, 2][j % 7];
                    // (|d| is formed in the frame of a, and turning that rounds it.)
                    if !(declared[kind] || dependence.translation && (3..6).contains(&j)) {
                        *entry = draw.between(-0.1, 0.1) * case.length;
                    }
                }
                let mut state = case.end().state;
                state.pair = moved(&state.pair, &by);
                let got = connector.evaluate(
                    &state,
                    &case.end().increment,
                    &case.branch_before(&connector),
                    &Request::new(&[Output::CU, Output::RES], [true; 6], 0),
                    &mut Tally::default(),
                );
                let [is, was] = [&got, &whole].map(|e| functions(e)[c].unwrap());
                assert_bits(format!("{place}, undeclared moves"), is, was);
            }
        }
        for case in cases(&connection, Extent::Brief).iter().take(1) {
            let connector = case.connector();
            for c in 0..6 {
                let Some(measure) = connector.differentiated(c) else { continue };
                let d = measure.dependence();
                for (kind, declared) in [d.translation, d.rotation, d.flow].into_iter().enumerate() {
                    let what = ["translation", "rotation", "flow"][kind];
                    assert!(
                        !declared || seen[c][kind],
                        "{}: {what} never mattered to {measure:?}",
                        case.name
                    );
                }
            }
        }
    }
}

/// A ground node has no columns; the other node's are the same bit for bit.
#[test]
fn a_ground_node_has_no_columns() {
    let mut compared = 0;
    for connection in types() {
        for case in cases(&connection, Extent::Brief) {
            let (free, _) = case.evaluate(&Request::everything(2));
            for moves in [[false, true], [true, false], [false, false]] {
                let mut grounded = case.clone();
                grounded.definition.moves = moves;
                let (got, _) = grounded.evaluate(&Request::everything(2));
                for c in 0..6 {
                    let Some(row) = got.jacobian[c] else { continue };
                    let hessian = got.hessian[c].as_ref().unwrap();
                    let (all, all_second) = (free.jacobian[c].unwrap(), free.hessian[c].as_ref().unwrap());
                    let place = format!("{}, component {}, moves {moves:?}", case.name, c + 1);
                    let live = |j: usize| moves[j / 7];
                    for j in 0..DOFS {
                        assert_bits(&place, row[j], if live(j) { all[j] } else { 0.0 });
                        for k in 0..DOFS {
                            let want = if live(j) && live(k) { all_second[j][k] } else { 0.0 };
                            assert!(hessian[j][k] == want, "{place}: ∂{j}∂{k}");
                            compared += usize::from(want != 0.0);
                        }
                    }
                }
            }
        }
    }
    assert!(compared > 20_000, "{compared}");
}

/// In two dimensions components u1, u2, ur3 and degrees of freedom 1, 2, 6, 10 remain, and are those of three dimensions.
#[test]
fn two_dimensions_are_part_of_three() {
    let request = Request::everything(2);
    let mut count = 0;
    for connection in types().into_iter().filter(|entry| entry.planar != Availability::Never) {
        let draw = &mut Draw::new(&format!("plane {}", connection.name));
        for _ in 0..4 {
            count += 1;
            let flat = |v: [f64; 3]| [v[0], v[1], 0.0];
            let about_3 = |angle: f64| exp([0.0, 0.0, angle]);
            let (initial, swing) = (about_3(draw.between(-3.0, 3.0)), draw.between(-1.0, 1.0));
            let start = pair(flat(draw.direction()), initial, &vector::identity());
            let space = definition(&connection, start, 1.0);
            let mut after = start;
            after.a.displacement = flat(draw.vector(0.3));
            after.b.displacement = flat(draw.vector(0.3));
            after.a.triad = vector::product(&about_3(0.4), &start.a.triad);
            after.b.triad = vector::product(&about_3(0.4 + swing), &start.b.triad);
            after.b.flow = 0.1;
            let mut step = crate::states::Step::between(&start, after);
            step.state.velocity = std::array::from_fn(|j| {
                if matches!(DOF_NUMBER[j], 1 | 2 | 6 | 10) { draw.between(-1.0, 1.0) } else { 0.0 }
            });
            let evaluate = |definition: &Definition| {
                let connector = Connector::<f64>::new(definition);
                let branch = connector.initial_branch();
                let tally = &mut Tally::default();
                connector.evaluate(&step.state, &step.increment, &branch, &request, tally)
            };
            let in_space = evaluate(&space);
            let in_plane = evaluate(&Definition { planar: true, ..space.clone() });
            for c in 0..6 {
                let place = format!("{}, component {}", connection.name, c + 1);
                let kept = matches!(c, 0 | 1 | 5);
                for output in Output::ALL {
                    let want = if kept { values(&in_space, output)[c] } else { None };
                    match (values(&in_plane, output)[c], want) {
                        (None, None) => {}
                        (Some(got), Some(want)) => assert_bits(format!("{place}, {output:?}"), got, want),
                        (got, want) => panic!("{place}, {output:?}: {got:?}, not {want:?}"),
                    }
                }
                let (row, all) = (in_plane.jacobian[c], in_space.jacobian[c].filter(|_| kept));
                assert_eq!(row.is_some(), all.is_some(), "{place}");
                let (Some(row), Some(all)) = (row, all) else { continue };
                for j in 0..DOFS {
                    let remains = matches!(DOF_NUMBER[j], 1 | 2 | 6 | 10);
                    assert_bits(format!("{place}, ∂{j}"), row[j], if remains { all[j] } else { 0.0 });
                    // A measure in the plane does not feel what leads out of it.
                    assert!(remains || all[j] == 0.0, "{place}: ∂{j} = {} in three dimensions", all[j]);
                }
            }
        }
    }
    assert!(count > 30, "only {count} planar states");
}

/// Names are unique, in upper case, and found; every type has a source; every measure has a unit that fits its component.
#[test]
fn the_table_is_well_formed() {
    for (i, entry) in TABLE.iter().enumerate() {
        let name = &entry.name;
        assert!(
            name.chars().all(|c| c.is_ascii_uppercase() || c == '-' || c == ' '),
            "{name}: not an upper-case name"
        );
        let twin = TABLE[..i].iter().find(|other| other.name.eq_ignore_ascii_case(name));
        assert!(twin.is_none(), "{name} is in the table twice");
        assert_eq!(ConnectionType::named(name, None).as_ref(), Ok(entry), "{name} is not found by its name");
        assert!(!entry.source[0].is_empty(), "{name} has no source");
        for c in 0..6 {
            let Some(measure) = entry.slots[c].position() else { continue };
            let fits = match measure.unit() {
                Unit::Angle => c >= 3,
                Unit::Length | Unit::None => c < 3,
            };
            assert!(fits, "{name}: {measure:?} as component {}", c + 1);
        }
    }
    let mut names: Vec<String> = types().iter().map(|entry| entry.name.to_string()).collect();
    let count = names.len();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), count, "two types or pairs share a name");
}

/// Either order of a pair's names is the same type; a pair that equals an assembled type is that type.
#[test]
fn pairs_are_named_in_either_order() {
    let mut pairs = 0;
    for connection in types() {
        let [Some(t), Some(r)] = connection.halves else { continue };
        let [one, other] = [(t.name, r.name), (r.name, t.name)]
            .map(|(x, y)| ConnectionType::named(x, Some(y)).expect("halves pair"));
        assert_eq!(one, other, "{} + {}", t.name, r.name);
        assert_eq!(one.slots, connection.slots, "{} + {}", t.name, r.name);
        pairs += 1;
    }
    assert!(pairs > 90, "{pairs}");
}
