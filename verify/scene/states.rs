//! Files of states: columns, groups, both formats, bit by bit.

use super::n;
use pintle_scene::{GALLERY, NodeMotion, Rotation, Scene, State, StateFile};
use proptest::prelude::*;

fn scene() -> Scene {
    Scene::parse("deck.inp", "*NODE\n1\n2\n3\n").unwrap()
}

#[test]
fn columns_come_in_any_order_and_default_to_zero() {
    let text = "\u{feff}# written by hand\nvr2, node , time,ur3,state,flow_a\n 1.5,2,0.25,7.5,3,\n,1,0.25,,3,-2e-3\n,1,0.5,,8,\n";
    let file = StateFile::parse_csv("s.csv", text, &scene()).unwrap();
    let [first, second] = file.states.as_slice() else { panic!("{file:?}") };
    assert_eq!((first.time, second.time, first.nodes.len()), (Some(0.25), Some(0.5), 2));
    let moved = NodeMotion {
        rotation: Rotation::Vector([0.0, 0.0, 7.5]),
        angular_velocity: [0.0, 1.5, 0.0],
        ..NodeMotion::default()
    };
    assert_eq!(first.nodes[&n(2)], moved);
    assert_eq!(first.nodes[&n(1)], NodeMotion { flow_acceleration: -2e-3, ..NodeMotion::default() });
    assert_eq!(second.nodes[&n(1)], NodeMotion::default());
}

#[test]
fn without_numbers_of_states_there_is_one() {
    let file = StateFile::parse_csv("s.csv", "node,u1\n1,1\n2,2\n", &scene()).unwrap();
    assert_eq!(file.states.len(), 1);
    assert_eq!(file.states[0].time, None);
}

/// Found by fuzzing: they were taken for rows.
#[test]
fn comments_and_blanks_are_no_rows() {
    for text in ["node,u1\n1,1\n# end", " \nnode,u1\n1,1\n", "node,u1\n  \n1,1\n\t\n"] {
        let file = StateFile::parse_csv("s.csv", text, &scene()).unwrap();
        assert_eq!(file.states[0].nodes.len(), 1, "{text:?}");
    }
}

#[test]
fn json_says_the_same_as_csv() {
    let csv = "state,time,node,u1,u2,q0,q3,v3\n0,0,1,1,2,,,\n0,0,2,,,0.6,0.8,5\n1,1,3,,,,,\n";
    let json = r#"{"states": [
        {"nodes": {"2": {"velocity": [0, 0, 5], "quaternion": [0.6, 0, 0, 0.8]}, "1": {"displacement": [1, 2, 0]}}, "time": 0, "number": 0},
        {"number": 1, "time": 1, "nodes": {"3": {}}}], "schema": "pintle-states/1"}"#;
    let scene = scene();
    assert_eq!(
        StateFile::parse_csv("s.csv", csv, &scene).unwrap(),
        StateFile::parse_json("s.json", json, &scene).unwrap()
    );
}

#[test]
fn the_gallery_survives_json() {
    for example in GALLERY {
        let scene = example.scene().unwrap();
        let states = example.states(&scene).unwrap();
        let json = states.to_json().unwrap();
        assert_eq!(StateFile::parse_json("s.json", &json, &scene).unwrap(), states, "{}", example.name);
    }
}

fn number() -> impl Strategy<Value = f64> {
    any::<f64>().prop_filter("finite", |x| x.is_finite())
}

proptest! {
    #[test]
    fn numbers_survive_both_formats_bit_by_bit(values in prop::collection::vec(number(), 13), theta in prop::array::uniform3(-5e7..5e7_f64)) {
        let three = |from: usize| [values[from], values[from + 1], values[from + 2]];
        let motion = NodeMotion {
            displacement: three(0),
            rotation: Rotation::Vector(theta),
            velocity: three(3),
            angular_velocity: [values[6], 0.0, 0.0],
            acceleration: three(7),
            angular_acceleration: [0.0; 3],
            flow: values[10],
            flow_velocity: values[11],
            flow_acceleration: values[12],
        };
        let file = StateFile { states: vec![State { time: Some(values[0]), nodes: [(n(2), motion)].into(), ..State::default() }] };
        let scene = scene();
        let json = file.to_json().unwrap();
        let back = StateFile::parse_json("s.json", &json, &scene).unwrap();
        prop_assert_eq!(back.to_json().unwrap(), json.clone());
        prop_assert_eq!(&back, &file);
        let m = &motion;
        let row: Vec<String> = [m.displacement, theta, m.velocity, m.acceleration].iter().flatten()
            .chain([&m.angular_velocity[0], &m.flow, &m.flow_velocity, &m.flow_acceleration, &values[0]])
            .map(|x| format!("{x:?}")).collect();
        let csv = format!("node,u1,u2,u3,ur1,ur2,ur3,v1,v2,v3,a1,a2,a3,vr1,flow,flow_v,flow_a,time\n2,{}\n", row.join(","));
        let back = StateFile::parse_csv("s.csv", &csv, &scene).unwrap();
        prop_assert_eq!(back.to_json().unwrap(), json);
    }

    #[test]
    fn any_text_is_read_or_refused(text in "\\PC{0,200}") {
        let scene = scene();
        let _ = StateFile::parse_csv("s.csv", &text, &scene);
        let _ = StateFile::parse_json("s.json", &text, &scene);
        let _ = StateFile::parse_csv("s.csv", &format!("node,u1,time\n{text}\n"), &scene);
        let _ = StateFile::parse_json("s.json", &format!("{{\"schema\": \"pintle-states/1\", \"states\": [{text}"), &scene);
    }
}
