//! Decks, TOML and JSON say the same: what is read from one is written to another and read again, without loss.

use pintle_scene::{Format, GALLERY, Scene, StateFile};
use proptest::prelude::*;
use serde_json::{Value, json};

const FORMATS: [Format; 3] = [Format::Deck, Format::Toml, Format::Json];

fn read(format: Format, text: &str) -> Scene {
    let scene = match format {
        Format::Deck => Scene::parse("scene", text),
        Format::Toml => Scene::parse_toml("scene", text),
        Format::Json => Scene::parse_json("scene", text),
    };
    scene.unwrap_or_else(|error| panic!("{}\n{text}", error.render(110, false)))
}

/// What a scene is, without what was passed over in its file.
fn content(scene: &Scene) -> Value {
    let mut scene = scene.clone();
    scene.name = String::new();
    scene.skipped = pintle_scene::Skipped::default();
    for set in scene.node_sets.values_mut().chain(scene.element_sets.values_mut()) {
        set.unmodelled = 0;
    }
    serde_json::to_value(&scene).unwrap()
}

/// Equal, and in the same order.
fn same(a: &Value, b: &Value) -> bool {
    format!("{a}") == format!("{b}")
}

fn write(scene: &Scene, format: Format) -> String {
    scene.write(format).unwrap().text
}

/// The parts that differ, for the message.
fn difference(a: &Value, b: &Value) -> String {
    let parts = a.as_object().unwrap().iter().filter(|(key, value)| !same(value, &b[key.as_str()]));
    parts.map(|(key, value)| format!("{key}:\n{value}\n{}\n", b[key.as_str()])).collect()
}

/// What a deck cannot say.
fn as_deck(scene: &mut Value) {
    scene["states"] = json!([]);
    scene.as_object_mut().unwrap().shift_remove("rotating_nodes");
    scene["axisymmetric"] = json!(false);
}

/// Every way from the scene through two formats leads back to it.
fn survives(scene: &Scene) {
    let original = content(scene);
    for first in FORMATS {
        let text = write(scene, first);
        let once = read(first, &text);
        let mut expected = original.clone();
        if first == Format::Deck {
            as_deck(&mut expected);
        }
        assert!(
            same(&content(&once), &expected),
            "{first:?}:\n{text}\n{}",
            difference(&content(&once), &expected)
        );
        assert_eq!(write(&once, first), text, "{first:?}");
        for second in FORMATS {
            let text = write(&once, second);
            let twice = read(second, &text);
            let mut expected = expected.clone();
            if second == Format::Deck {
                as_deck(&mut expected);
            }
            assert!(
                same(&content(&twice), &expected),
                "{first:?} → {second:?}:\n{text}\n{}",
                difference(&content(&twice), &expected)
            );
        }
    }
}

#[test]
fn the_gallery_survives() {
    for example in GALLERY {
        let mut scene = example.scene().unwrap();
        survives(&scene);
        scene.states = example.states(&scene).unwrap().states;
        survives(&scene);
        let toml = read(Format::Toml, &write(&scene, Format::Toml));
        assert_eq!(StateFile { states: toml.states }, example.states(&scene).unwrap(), "{}", example.name);
    }
}

/// A keyword that says OP=NEW and has no data lines is how a deck removes all of a kind.
#[test]
fn what_a_step_removes_survives() {
    use pintle_scene::{Choice, ConditionKind};
    let line = |kind: ConditionKind| match kind {
        ConditionKind::Boundary => "1, 1",
        ConditionKind::ConnectorMotion => "101, 4, 1.",
        ConditionKind::ConnectorLoad | ConditionKind::ConcentratedLoad => "101, 1, 1.",
        ConditionKind::DistributedLoad => "101, GRAV, 9.81, 0., 0., -1.",
    };
    for kind in ConditionKind::ALL {
        let keyword = format!("*{}", kind.spelling());
        let given = line(*kind).replace("101", if keyword == "*CLOAD" { "1" } else { "101" });
        let deck = format!(
            "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=E\n101, 1, 2\n*CONNECTOR SECTION, ELSET=E\nCARTESIAN, CARDAN\n\
             *STEP\n*STATIC\n{keyword}\n{given}\n*END STEP\n*STEP\n*STATIC\n{keyword}, OP=NEW\n*END STEP\n\
             *STEP\n*STATIC\n{keyword}, OP=NEW\n{given}\n*END STEP\n"
        );
        let scene = read(Format::Deck, &deck);
        let removed = |scene: &Scene| -> Vec<Vec<ConditionKind>> {
            scene.steps.iter().map(|step| step.removed.iter().copied().collect()).collect()
        };
        assert_eq!(removed(&scene), [vec![], vec![*kind], vec![*kind]], "{deck}");
        survives(&scene);
    }
}

/// Bytes that decide; when they run out, the first choice is taken.
struct Choices<'a>(std::slice::Iter<'a, u8>);

impl Choices<'_> {
    fn below(&mut self, count: usize) -> usize {
        usize::from(self.0.next().copied().unwrap_or(0)) % count
    }
    fn yes(&mut self) -> bool {
        self.below(2) == 1
    }
    fn one<T: Clone>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())].clone()
    }
    /// A number of any size and sign; both zeros among them.
    fn number(&mut self) -> Value {
        let awkward =
            [0.0, -0.0, 1.0, -1.0, 0.1, 1e-300, 5e-324, 1.7976931348623157e308, 1e16, 123456789.0, 1.0 / 3.0];
        let value = match self.below(3) {
            0 => self.one(&awkward),
            1 => f64::from_bits((0..8).fold(0, |bits, _| bits << 8 | self.below(256) as u64)),
            _ => self.below(200) as f64 / 8.0 - 10.0,
        };
        Value::from(if value.is_finite() { value } else { 2.5 })
    }
    fn item(&mut self) -> Value {
        if self.below(4) == 0 { Value::Null } else { self.number() }
    }
    fn numbers(&mut self, count: usize) -> Value {
        (0..count).map(|_| self.number()).collect()
    }
    fn positive(&mut self) -> Value {
        Value::from(self.number().as_f64().unwrap().abs())
    }
    fn rows(&mut self, columns: usize, filled: usize) -> Value {
        let (count, fields) = (1 + self.below(2), self.below(3) * self.below(5));
        let row = |choices: &mut Self| {
            let values: Value = (0..columns)
                .map(|place| if place < filled { choices.positive() } else { choices.item() })
                .collect();
            if fields == 0 && choices.yes() {
                return values;
            }
            let fields: Value = (0..fields).map(|_| choices.item()).collect();
            json!({"values": values, "temperature": choices.item(), "fields": fields})
        };
        (0..count).map(|_| row(self)).collect()
    }
    fn options(&mut self, of: &mut Value) {
        if self.yes() {
            of["extrapolation"] = self.one(&["constant", "linear"]).into();
            of["regularize"] = self.yes().into();
            of["rtol"] = self.number();
        }
    }
    fn independent(&mut self) -> Value {
        let components = self.one(&[vec![1], vec![2, 4], vec![6, 5, 3]]);
        json!({"basis": self.one(&["position", "constitutive_motion"]), "components": components})
    }
    fn source(&mut self) -> Value {
        self.one(&[json!(1), json!(6), json!("NORMAL"), json!("two words, and a comma")])
    }
    fn potential(&mut self) -> Value {
        let term = |choices: &mut Self| {
            let scale = choices.one(&[json!(2.0), json!(-1e-300), json!(1.0)]);
            json!({"of": choices.source(), "scale": scale, "exponent": choices.item(), "shift": choices.number(),
                   "function": choices.one(&["abs", "macauley", "none"]), "sign": choices.one(&[1.0, -1.0])})
        };
        let terms: Value = (0..1 + self.below(3)).map(|_| term(self)).collect();
        json!({"operator": self.one(&["sum", "max"]), "exponent": self.number(), "terms": terms})
    }
    fn law(&mut self, own: usize) -> Value {
        let mut law = match self.below(5) {
            0 => json!({"component": 4, "rows": self.rows(2, 1)}),
            1 => json!({"rows": self.rows(21, 21)}),
            2 => json!({"unsymmetric": true, "frequency_dependence": true, "rows": self.rows(37, 36)}),
            3 => {
                let independent = self.independent();
                let columns = 1 + own + independent["components"].as_array().unwrap().len();
                json!({"component": 1, "nonlinear": true, "rows": self.rows(columns, columns), "independent": independent})
            }
            _ => {
                json!({"component": 2, "nonlinear": true, "rows": [[self.number(), -1.0], [self.number(), 0.5]]})
            }
        };
        self.options(&mut law);
        law
    }
    fn raw(&mut self, width: usize, of: &mut Value) {
        let fields = self.below(3);
        let rows: Value = (0..1 + self.below(2))
            .map(|_| (0..width + fields).map(|_| self.item()).collect::<Value>())
            .collect();
        of["rows"] = rows;
        if fields > 0 {
            of["dependencies"] = fields.into();
        }
    }
    fn behavior(&mut self) -> Value {
        let mut behavior = json!({
            "integration": self.one(&["implicit", "explicit"]),
            "derived_components": {"NORMAL": [
                {"operator": self.one(&["norm", "sum", "macauley_sum"]), "components": [1, 2], "negative": self.yes(),
                 "rows": self.rows(2, 2)}
            ], "two words, and a comma": [{"components": [4, 6]}, {"components": [3], "independent": self.independent()}]},
            "elasticity": [self.law(0), {"rigid": true, "components": [5, 6]}, {"rigid": true}],
            "damping": [self.law(1)],
            "stops": [{"component": 4, "lower": -1.0, "upper": self.one(&[json!(null), json!(2.0)])}],
            "locks": [{"component": 1, "limits": [{"lower_force": self.number()}, {"temperature": self.number(),
                       "fields": [self.item(), self.item()]}]}],
            "failures": [{"component": 2, "affected": 3, "limits": [{"upper_position": self.number()}]}],
        });
        if self.yes() {
            behavior["constitutive_reference"] = json!({"1": self.number(), "6": self.number()});
            // Structural damping is linear.
            if behavior["damping"][0]["nonlinear"] != json!(true) {
                behavior["damping"][0]["type"] = "structural".into();
            }
        }
        self.options(&mut behavior);
        let coefficients = [
            json!({"rows": self.rows(3, 1), "maximum": self.positive(), "slip_tolerance": self.number(), "elastic_slip": self.number()}),
            json!({"exponential": [self.positive(), self.positive(), self.positive()]}),
            json!({"test_data": [[0.3], [0.2, 1.0], [self.item(), 0.25, 3.0]]}),
        ];
        let coefficient = self.one(&coefficients);
        let mut friction = match self.below(3) {
            0 => json!({"predefined": [self.number(), self.item(), self.item()]}),
            1 => {
                let mut friction = json!({"component": 1, "contact_force": self.source()});
                self.raw(4, &mut friction);
                friction
            }
            _ => json!({"potential": self.potential(), "contact_force": self.source()}),
        };
        friction["coefficient"] = coefficient;
        friction["stick_stiffness"] = self.number();
        self.options(&mut friction);
        behavior["friction"] = json!([friction]);
        behavior["plasticity"] = json!([{"potential": self.potential(), "hardening": [
            {"type": "isotropic", "definition": "exponential_law", "rows": self.rows(3, 3)},
            {"type": "kinematic", "definition": self.one(&["half_cycle", "stabilized", "parameters"]),
             "rows": self.rows(2, 2), "rate_filter": self.number(), "rate_interpolation": "logarithmic"},
        ]}]);
        let mut damage = json!({"criterion": "plastic_motion", "potential": self.potential()});
        self.raw(4, &mut damage);
        if self.yes() {
            let mut evolution = json!({"type": self.one(&["motion", "energy"]), "affected": [1, 2],
                "softening": self.one(&["linear", "exponential", "tabular"]), "degradation": "multiplicative"});
            self.raw(4, &mut evolution);
            if self.yes() {
                evolution["potential"] = self.potential();
            }
            damage["evolution"] = evolution;
        }
        behavior["damage"] = json!([damage]);
        behavior
    }
    fn acting(&mut self, of: &mut Value) {
        if self.yes() {
            of["amplitude"] = "A mixed Case".into();
            of["operation"] = "new".into();
            of["load_case"] = 2.into();
        }
    }
    fn boundary(&mut self) -> Value {
        let freedoms = [vec![1, 2, 3], vec![6, 10], vec![10], vec![1, 5, 6], vec![2]];
        let mut boundary = json!({"target": self.one(&[json!(1), json!("ALL"), json!("own name")]),
            "degrees_of_freedom": self.one(&freedoms), "fixed": self.yes(), "user": self.yes()});
        if self.yes() {
            boundary["degrees_of_freedom"] = json!([3, 4]);
            boundary["magnitude"] = self.number();
            boundary["type"] = self.one(&["velocity", "acceleration"]).into();
        }
        self.acting(&mut boundary);
        boundary
    }
    fn step(&mut self) -> Value {
        let mut motion =
            json!({"target": self.one(&[json!(101), json!("C")]), "component": 4, "magnitude": self.item()});
        let mut load =
            json!({"target": 101, "component": 1, "magnitude": self.number(), "imaginary": self.yes()});
        let mut force = json!({"target": "ALL", "degree_of_freedom": 10, "magnitude": self.number(), "follower": self.yes()});
        let mut gravity = json!({"label": "GRAV", "values": self.numbers(4), "target": self.one(&[json!(null), json!("C"), json!(201)])});
        for acting in [&mut motion, &mut load, &mut force, &mut gravity] {
            self.acting(acting);
        }
        json!({
            "name": self.one(&["S", "the step"]), "nlgeom": self.yes(), "perturbation": self.yes(), "increments": 7,
            "default_amplitude": self.one(&["ramp", "step"]),
            "procedure": self.one(&["static", "dynamic"]),
            "times": {"initial": self.positive(), "maximum": self.positive()},
            "removed": self.one(&[json!([]), json!(["boundary"]), json!(["connector_motion", "connector_load"]),
                                  json!(["concentrated_load", "distributed_load"])]),
            "boundaries": [self.boundary()], "connector_motions": [motion], "connector_loads": [load],
            "concentrated_loads": [force], "distributed_loads": [gravity],
            "outputs": [{"keyword": "OUTPUT", "parameters": {"HISTORY": true, "FREQUENCY": "1"}},
                        {"keyword": "ELEMENT OUTPUT", "element_set": "C", "variables": ["CU", "CTF"]}],
        })
    }
    fn scene(&mut self) -> Value {
        let orientations = json!({
            "R": {"a": [0.0, 0.0, 1.0], "b": [1.0, 0.0, 0.0], "c": self.one(&[json!(null), json!([0.0, -0.0, 0.0])])},
            "z in words": {"system": "z_rectangular", "a": [0.0, 0.0, 3.0], "b": [1.0, 0.5, 0.0], "axis": 3, "angle": self.number()},
            "N": {"definition": "nodes", "a": 2, "b": 3, "c": 1},
            "O": {"definition": "offset_to_nodes", "a": 2, "b": 1},
            "C": {"system": "cylindrical", "a": [9.0, 9.0, 9.0], "b": [9.0, 9.0, 10.0], "axis": 2, "angle": -0.0},
            "U": {"system": "user"},
        });
        let sets = [json!([3, 1]), json!(["ALL", 3]), json!([{"first": 1, "last": 5, "step": 2}]), json!([])];
        json!({
            "schema": "pintle-scene/1",
            "heading": self.one(&["", "one", "one\n\nthree, with \"quotes\" and = signs"]),
            "nodes": {"3": [0.0, 1.0, 0.0], "1": [0.0, 0.0, 0.0], "2": [1.0, 0.0], "9007199254740992": self.numbers(3)},
            "node_sets": {"ALL": [1, 2, 3], "own name": self.one(&sets)},
            "connectors": {"101": {"a": 1, "b": 2}, "7": {"a": 3}, "8": {"b": 2, "dimension": "CONN2D2"}},
            "point_elements": {"201": {"kind": "MASS", "nodes": [1]}, "202": {"kind": "SPRING2", "nodes": [1, 2]},
                               "203": {"kind": "DASHPOTA", "nodes": [3, 1]}, "204": {"kind": "ROTARYI", "nodes": [2]}},
            "element_sets": {"C": [101], "G": [7, 8], "M": [201], "K": [202], "D": [203], "I": [204], "X": ["G", 201, "C"]},
            "orientations": orientations,
            "connector_sections": [
                {"element_set": "C", "type": self.one(&[json!("HINGE"), json!(["CARTESIAN", "CARDAN"])]), "behavior": "B",
                 "orientation_a": self.one(&["R", "N"]), "orientation_b": self.one(&[json!(null), json!("z in words")]),
                 "data": self.one(&[json!([]), json!([""]), json!([null, 2.5])]), "elimination": self.yes()},
                {"element_set": "G", "type": "JOIN", "controls": "c 1"},
            ],
            "behaviors": {"B": self.behavior(), "plain": {}},
            "mpcs": [{"type": "PIN", "nodes": [1, 2]}, {"type": "MINE", "user": true, "nodes": [3, 1, 2]},
                     {"type": "SLIDER", "nodes": [1, 2, 3]}],
            "masses": [{"element_set": "M", "mass": self.positive()}],
            "rotary_inertias": [{"element_set": "I", "inertia": [1.0, 2.0, 3.0, -0.5, self.number(), 0.0], "orientation": "R"}],
            "initial_velocities": [{"target": 1, "degree_of_freedom": self.one(&[1, 6]), "magnitude": self.number()}],
            "springs": [{"element_set": "K", "degrees_of_freedom": [1, 6], "complex": self.yes(), "rows": [[self.number(), self.item()]]}],
            "dashpots": [{"element_set": "D", "nonlinear": true, "dependencies": 7,
                          "rows": [[self.number(), 0.0, null, 1.0, self.item(), 2.0, 3.0, 4.0, self.item(), 5.0]]}],
            "transforms": [{"node_set": "ALL", "kind": self.one(&["rectangular", "cylindrical", "spherical"]),
                            "a": [1.0, 0.1, 1e-300], "b": [-0.0, 2.0, 1e-3]}],
            "amplitudes": {"A mixed Case": {"pairs": [[-1.0, self.number()], [0.0, self.number()]], "time": "total_time"},
                           "P": {"definition": "periodic", "data": self.numbers(11), "value": "absolute", "begin": self.number()}},
            "boundaries": [self.boundary(), self.boundary()],
            "connector_motions": [{"target": 101, "component": 4}],
            "steps": [self.step(), {"procedure": "FREQUENCY"}, {}],
            "rotating_nodes": [2],
            "axisymmetric": self.yes(),
            "states": [{"nodes": {}}, {"time": self.number(), "nodes": {"2": {
                "displacement": self.numbers(3), "rotation": [0.0, -0.0, 7.5], "flow": self.number()}}}],
        })
    }
}

/// Without nulls in tables, where they mean what a field that is not there means.
fn without_nulls(value: &mut Value) {
    match value {
        Value::Object(fields) => {
            fields.retain(|_, value| !value.is_null());
            fields.values_mut().for_each(without_nulls);
        }
        Value::Array(items) => items.iter_mut().for_each(without_nulls),
        _ => {}
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_scene_survives(bytes in prop::collection::vec(any::<u8>(), 0..1200)) {
        let mut document = Choices(bytes.iter()).scene();
        without_nulls(&mut document);
        // In three dimensions the node of CONN2D2 8 would leave the plane.
        if let Some(state) = document["states"][1]["nodes"]["2"].as_object_mut() {
            state["displacement"][2] = 0.0.into();
        }
        prop_assert!(schema().is_valid(&document), "{document}");
        survives(&read(Format::Json, &document.to_string()));
    }

    #[test]
    fn any_text_is_read_or_refused(text in "(\\PC|\n){0,120}") {
        for result in [Scene::parse_toml("any", &text), Scene::parse_json("any", &text)] {
            if let Err(error) = result {
                prop_assert!(!error.remedy().is_empty());
                prop_assert!(!error.render(80, false).is_empty());
            }
        }
    }
}

fn schema() -> jsonschema::Validator {
    jsonschema::validator_for(&serde_json::from_str(pintle_scene::SCHEMA_TEXT).unwrap()).unwrap()
}

/// The copy in the repository, which the program prints.
#[cfg(feature = "schema")]
#[test]
fn the_schema_is_that_of_the_types() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/schema/pintle-scene-1.json");
    let types = format!("{:#}\n", pintle_scene::schema());
    if std::env::var_os("PINTLE_UPDATE").is_some() {
        std::fs::write(path, &types).unwrap();
    }
    let copy = std::fs::read_to_string(path).unwrap();
    assert!(copy == types, "{path} is not what the types give; run the test with PINTLE_UPDATE=1");
}

#[test]
fn the_schema_accepts_what_is_written_and_refuses_what_is_not_read() {
    let schema = schema();
    for example in GALLERY {
        let mut scene = example.scene().unwrap();
        scene.states = example.states(&scene).unwrap().states;
        let json: Value = serde_json::from_str(&write(&scene, Format::Json)).unwrap();
        let errors: Vec<String> = schema.iter_errors(&json).map(|error| error.to_string()).collect();
        assert!(errors.is_empty(), "{}: {errors:?}", example.name);
        let mut wrong = json.clone();
        wrong["connector_sections"][0]["colour"] = "red".into();
        assert!(!schema.is_valid(&wrong));
        let mut wrong = json;
        wrong["nodes"]["1"] = "origin".into();
        assert!(!schema.is_valid(&wrong));
    }
}

/// Places in TOML and JSON reach the diagnostics of what is wrong with the model: lines, and the marked text.
#[test]
fn diagnostics_mark_the_value() {
    let toml = "nodes = { 1 = [0, 0, 0], 2 = [1, 0, 0] }\n[connectors]\n101 = { a = 1, b = 2 }\n[element_sets]\nE = [101,\n  102]\n\
        [[connector_sections]]\nelement_set = \"E\"\ntype = \"BEAM\"\n";
    let error = Scene::parse_toml("scene.toml", toml).unwrap_err();
    assert_eq!(
        (error.line(), &toml[error.span().start() as usize..error.span().end() as usize]),
        (Some(6), "102")
    );
    let json = "\u{feff}{\"nodes\": {\"1\": [0, 0],\n \"2\": [1, \"x\"]}}";
    let error = Scene::parse_json("scene.json", json).unwrap_err();
    assert_eq!(
        (error.line(), &json[error.span().start() as usize..error.span().end() as usize]),
        (Some(2), "\"x\"")
    );
}

#[test]
fn depth_is_bounded() {
    for (open, close) in [("[", "]"), ("{\"a\":", "}")] {
        let text = format!("{{\"nodes\": {}1{}}}", open.repeat(50_000), close.repeat(50_000));
        assert_eq!(Scene::parse_json("deep", &text).unwrap_err().code(), pintle_scene::Code::SceneTooDeep);
    }
    let text = format!("nodes = {}1{}", "[".repeat(50_000), "]".repeat(50_000));
    assert_eq!(Scene::parse_toml("deep", &text).unwrap_err().code(), pintle_scene::Code::SceneTooDeep);
    let text = format!("nodes.{} = 1", "a.".repeat(50_000) + "a");
    assert_eq!(Scene::parse_toml("deep", &text).unwrap_err().code(), pintle_scene::Code::SceneTooDeep);
}
