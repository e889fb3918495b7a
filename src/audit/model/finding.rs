//! What is found in a model: code, severity, place, what it is about, and what to do.

use pintle_scene::{Code, Diagnostic, Label, Scene, Severity, Span, Words};
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};

/// What a finding is about.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct About {
    /// Connector elements, the one at the place of the finding first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub elements: Vec<Label>,
    /// Multi-point constraints, by kind and nodes: `MPC BEAM 10-20`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub mpcs: Vec<String>,
    /// Nodes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub nodes: Vec<Label>,
    /// Components of relative motion, `u1` … `ur3`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub components: Vec<String>,
    /// The number of the state, where it is about one that was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub state: Option<u64>,
    /// A number that says how much: an angle (rad), a distance, a ratio; the message says which.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// The same of each of [`About::elements`], in their order, where there are several: of each the worst.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub values: Vec<Option<f64>>,
}

/// One finding. It serialises with the code, severity, file, line, message, reason, remedy, and what it is about.
#[derive(Clone, Debug)]
pub struct Finding {
    diagnostic: Diagnostic,
    /// What it is about.
    pub about: About,
}

impl Finding {
    /// A finding at a place of a scene, as bad as its code says. `reason` says by what rule, or on what ground.
    pub fn new(
        scene: &Scene,
        code: Code,
        place: Span,
        message: impl Into<Words>,
        reason: impl Into<Words>,
        remedy: impl Into<Words>,
    ) -> Self {
        let diagnostic = Diagnostic::finding(code, place, message, reason).help(remedy);
        diagnostic.in_scene(scene).into()
    }

    /// The same, about these.
    #[must_use]
    pub fn about(mut self, about: About) -> Self {
        self.about = about;
        self
    }

    /// The same, as bad as that.
    #[must_use]
    pub fn of_severity(mut self, severity: Severity) -> Self {
        self.diagnostic = self.diagnostic.of_severity(severity);
        self
    }

    /// The same, with more words at the end of the message.
    #[must_use]
    pub(crate) fn add(mut self, words: &str) -> Self {
        self.diagnostic = self.diagnostic.with_more(words);
        self
    }

    /// The same, with words before the message.
    #[must_use]
    pub(crate) fn begin(mut self, words: &str) -> Self {
        self.diagnostic = self.diagnostic.with_words_before(words);
        self
    }

    /// The stable code.
    pub fn code(&self) -> Code {
        self.diagnostic.code()
    }

    /// How bad it is.
    pub fn severity(&self) -> Severity {
        self.diagnostic.severity()
    }

    /// The file.
    pub fn file(&self) -> &str {
        self.diagnostic.file()
    }

    /// The line in it, where there is one.
    pub fn line(&self) -> Option<u32> {
        self.diagnostic.line()
    }

    /// What is found, in a sentence.
    pub fn message(&self) -> &str {
        self.diagnostic.message()
    }

    /// By what rule, or on what ground.
    pub fn reason(&self) -> &str {
        self.diagnostic.label()
    }

    /// What to do about it.
    pub fn remedy(&self) -> &str {
        self.diagnostic.remedy()
    }

    /// The diagnostic that it is, which can show the line of the file.
    pub fn diagnostic(&self) -> &Diagnostic {
        &self.diagnostic
    }
}

impl From<Diagnostic> for Finding {
    fn from(diagnostic: Diagnostic) -> Self {
        Self { diagnostic, about: About::default() }
    }
}

impl Serialize for Finding {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("Finding", 8)?;
        fields.serialize_field("code", self.code().as_str())?;
        fields.serialize_field("severity", &self.severity())?;
        fields.serialize_field("file", self.file())?;
        fields.serialize_field("line", &self.line())?;
        fields.serialize_field("message", self.message())?;
        fields.serialize_field("reason", self.reason())?;
        fields.serialize_field("remedy", self.remedy())?;
        fields.serialize_field("about", &self.about)?;
        fields.end()
    }
}
