//! What messages call things: decks by keywords and parameters, documents by fields.

/// A text in the words of decks and, where they differ, in those of documents. Two texts are these two.
#[derive(Debug, Clone, Default)]
pub struct Words {
    pub(crate) text: String,
    document: Option<String>,
}

impl Words {
    /// The same, changed in both.
    pub(crate) fn each(mut self, change: impl Fn(&mut String)) -> Self {
        change(&mut self.text);
        self.document.iter_mut().for_each(change);
        self
    }

    /// Those of documents alone.
    pub(crate) fn of_document(self) -> Self {
        self.document.unwrap_or(self.text).into()
    }
}

impl From<String> for Words {
    fn from(text: String) -> Self {
        Self { text, document: None }
    }
}

impl From<&str> for Words {
    fn from(text: &str) -> Self {
        text.to_owned().into()
    }
}

impl<T: Into<String>> From<[T; 2]> for Words {
    fn from([deck, document]: [T; 2]) -> Self {
        Self { text: deck.into(), document: Some(document.into()) }
    }
}

/// Keywords, and the fields that stand for them.
const FIELDS: [(&str, &str); 35] = [
    ("AMPLITUDE", "amplitudes"),
    ("BOUNDARY", "boundaries"),
    ("CLOAD", "concentrated_loads"),
    ("CONNECTOR BEHAVIOR", "behaviors"),
    ("CONNECTOR CONSTITUTIVE REFERENCE", "constitutive_reference"),
    ("CONNECTOR DAMAGE EVOLUTION", "evolution"),
    ("CONNECTOR DAMAGE INITIATION", "damage"),
    ("CONNECTOR DAMPING", "damping"),
    ("CONNECTOR DERIVED COMPONENT", "derived_components"),
    ("CONNECTOR ELASTICITY", "elasticity"),
    ("CONNECTOR FAILURE", "failures"),
    ("CONNECTOR FRICTION", "friction"),
    ("CONNECTOR HARDENING", "hardening"),
    ("CONNECTOR LOAD", "connector_loads"),
    ("CONNECTOR LOCK", "locks"),
    ("CONNECTOR MOTION", "connector_motions"),
    ("CONNECTOR PLASTICITY", "plasticity"),
    ("CONNECTOR POTENTIAL", "potential"),
    ("CONNECTOR SECTION", "connector_sections"),
    ("CONNECTOR STOP", "stops"),
    ("DASHPOT", "dashpots"),
    ("DLOAD", "distributed_loads"),
    ("ELEMENT", "connectors or point_elements"),
    ("ELSET", "element_sets"),
    ("FRICTION", "coefficient"),
    ("INITIAL CONDITIONS", "initial_velocities"),
    ("MASS", "masses"),
    ("MPC", "mpcs"),
    ("NODE", "nodes"),
    ("NSET", "node_sets"),
    ("ORIENTATION", "orientations"),
    ("ROTARY INERTIA", "rotary_inertias"),
    ("SPRING", "springs"),
    ("STEP", "steps"),
    ("TRANSFORM", "transforms"),
];

/// A keyword as decks write it, and its field.
pub(crate) fn keyword(name: &str) -> [String; 2] {
    let deck = format!("*{name}");
    let field = FIELDS.iter().find(|(keyword, _)| *keyword == name);
    [deck.clone(), field.map_or(deck, |(_, field)| (*field).to_owned())]
}

/// How to define what a keyword defines by a parameter with that name.
pub(crate) fn definition(of: &str, parameter: &str, name: &str) -> Words {
    let [keyword, field] = keyword(of);
    [format!("define it by {keyword}, {parameter}={name}"), format!("define it by {field}.{name}")].into()
}

#[cfg(test)]
mod tests {
    use crate::{Format, Scene};
    use serde_json::{Value, json};

    /// Where every value within a value stands.
    fn places(value: &Value) -> Vec<String> {
        let within: Vec<(String, &Value)> = match value {
            Value::Object(fields) => fields.iter().map(|(name, value)| (name.clone(), value)).collect(),
            Value::Array(items) => items.iter().enumerate().map(|(at, it)| (at.to_string(), it)).collect(),
            _ => Vec::new(),
        };
        let deeper = within.iter().flat_map(|(name, value)| {
            std::iter::once(String::new()).chain(places(value)).map(move |rest| format!("/{name}{rest}"))
        });
        deeper.collect()
    }

    /// Whichever value of a document is another one, no message names a keyword, a parameter or a data line.
    #[test]
    fn documents_are_told_of_in_their_own_words() {
        let seed = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/seeds/toml_scene/every_field.toml");
        let text = Scene::read(seed).unwrap().write(Format::Json).unwrap().text;
        let whole: Value = serde_json::from_str(&text).unwrap();
        let others =
            [json!(true), json!(-1), json!(0), json!(7), json!(0.5), json!(""), json!("X"), json!([])];
        let mut told = 0;
        for (place, other) in places(&whole).iter().flat_map(|place| others.iter().map(move |it| (place, it)))
        {
            let mut changed = whole.clone();
            *changed.pointer_mut(place).unwrap() = other.clone();
            let read = Scene::parse_json("scene.json", &changed.to_string());
            let (warnings, error) = read.map_or_else(|it| (Vec::new(), Some(it)), |it| (it.warnings, None));
            let errors = error.iter().flat_map(|first| std::iter::once(first).chain(first.further()));
            for said in warnings.iter().chain(errors) {
                told += 1;
                for text in [said.message(), said.label(), said.remedy()] {
                    let is_name = |at: usize| text[at + 1..].starts_with(|c: char| c.is_ascii_uppercase());
                    let is_of_decks = text.match_indices('*').any(|(at, _)| is_name(at))
                        || ["=…", "data line"].iter().any(|words| text.contains(words));
                    assert!(!is_of_decks, "{place} = {other}: {text}");
                }
            }
        }
        assert!(told > 1000, "{told}");
    }
}
