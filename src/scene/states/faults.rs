//! All that is wrong with a file of states or forces, in one run.

use crate::diagnostic::{Code, Diagnostic, MAX_ERRORS, Result};
use crate::freedom::NodeFreedom;
use crate::model::Scene;
use crate::span::Span;
use crate::states::source::{Source, unreadable};
use crate::states::{Fault, check_number};
use serde::de::{DeserializeOwned, DeserializeSeed, Error as _, IgnoredAny, MapAccess};
use serde_json::value::RawValue;
use std::cell::{Cell, RefCell};
use std::collections::HashSet;
use std::io;
use std::io::{BufRead, Read};

/// Whether an error is about the scene, and so the same in every state: it is told once.
const fn is_of_scene(code: Code) -> bool {
    matches!(code, Code::StatesUnknownNode | Code::StatesNoRotation | Code::StatesOutOfPlane)
}

/// The errors of a file so far.
#[derive(Debug, Default)]
pub(crate) struct Faults {
    found: Option<Diagnostic>,
    told: HashSet<String>,
}

impl Faults {
    /// Adds an error, and those that it carries.
    pub(crate) fn add(&mut self, error: Diagnostic) {
        let (errors, unsaid) = error.apart();
        for error in errors {
            if is_of_scene(error.code()) && !self.told.insert(error.message().to_owned()) {
                continue;
            }
            self.found = Diagnostic::joined(self.found.take().into_iter().chain([error]));
        }
        self.found = self.found.take().map(|first| first.with_unsaid(unsaid));
    }

    /// Whether nothing is wrong so far.
    pub(crate) const fn is_empty(&self) -> bool {
        self.found.is_none()
    }

    /// Nothing, or the first error with the others.
    pub(crate) fn end(self) -> Result<()> {
        self.found.map_or(Ok(()), Err)
    }
}

/// The reading of a JSON file, which is read again after each fault of our own, to find the next: its place is known only where the
/// reading stops.
pub(crate) struct Documents<'a> {
    scene: &'a Scene,
    freedom: NodeFreedom,
    fault: Cell<Option<Fault>>,
    /// What was told of the scene, and how many other faults were.
    told: RefCell<HashSet<String>>,
    passed: Cell<usize>,
    /// Whether nothing after the last fault can be read.
    ends: Cell<bool>,
    /// Whether something of another form was met: each value is read by itself from then on, so that what follows is read, too.
    by_value: Cell<bool>,
    /// An example of the form, for remedies.
    form: RefCell<String>,
    /// How many of the latter were met in this reading.
    met: Cell<usize>,
    /// The number of the last state, if there was one.
    last: Cell<Option<Option<u64>>>,
    /// How far this reading has come.
    passed_over: PassedOver,
}

/// The line ends and bytes that were read.
#[derive(Debug, Default)]
struct PassedOver {
    lines: Cell<u32>,
    bytes: Cell<u64>,
}

/// What is read, counted.
struct Counted<'a> {
    inner: Box<dyn BufRead + 'a>,
    count: &'a PassedOver,
}

impl Read for Counted<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let length = self.inner.read(buffer)?;
        let ends = buffer.iter().take(length).filter(|byte| **byte == b'\n').count();
        self.count.lines.set(self.count.lines.get().saturating_add(u32::try_from(ends).unwrap_or(u32::MAX)));
        self.count.bytes.set(self.count.bytes.get() + length as u64);
        Ok(length)
    }
}

impl<'a> Documents<'a> {
    pub(crate) fn new(scene: &'a Scene) -> Self {
        Self {
            scene,
            freedom: NodeFreedom::of(scene),
            fault: Cell::default(),
            told: RefCell::default(),
            passed: Cell::default(),
            ends: Cell::default(),
            by_value: Cell::default(),
            form: RefCell::default(),
            met: Cell::default(),
            last: Cell::default(),
            passed_over: PassedOver::default(),
        }
    }

    /// Whether this is the first reading, whose states are taken.
    pub(crate) fn is_clean(&self) -> bool {
        self.passed.get() == 0 && self.told.borrow().is_empty() && !self.by_value.get()
    }

    pub(crate) const fn context(&self) -> Context<'_> {
        Context { scene: self.scene, reading: self }
    }

    /// Reads a document; `form` shows an example in the remedy.
    pub(super) fn read<S>(&self, source: Source<'_>, form: &str, seed: impl Fn() -> S) -> Result<()>
    where
        S: for<'de> DeserializeSeed<'de, Value = ()>,
    {
        form.clone_into(&mut self.form.borrow_mut());
        let (mut faults, mut of_form) = (Faults::default(), None);
        for _ in 0..=MAX_ERRORS {
            self.met.set(0);
            self.last.set(None);
            self.passed_over.lines.set(0);
            self.passed_over.bytes.set(0);
            let inner = source.reader(0).map_err(|error| unreadable(&error))?;
            let counted = Counted { inner, count: &self.passed_over };
            let Err(error) = through(seed(), &mut serde_json::Deserializer::from_reader(counted)) else {
                break;
            };
            let span = json_place(source, error.line(), error.column());
            let Some(fault) = self.fault.take() else {
                if error.is_data() && source.is_repeatable() && !self.by_value.replace(true) {
                    of_form = Some(broken(error, span, form));
                    continue;
                }
                faults.add(broken(error, span, form));
                break;
            };
            if is_of_scene(fault.code) {
                self.told.borrow_mut().insert(fault.message.clone());
            } else {
                self.passed.set(self.passed.get() + 1);
            }
            faults.add(fault.at(span, "ends here"));
            if self.ends.get() || !source.is_repeatable() {
                break;
            }
        }
        if let (true, Some(error)) = (faults.is_empty(), of_form) {
            faults.add(error);
        }
        faults.end()
    }
}

fn through<'de, R, S>(seed: S, reader: &mut serde_json::Deserializer<R>) -> Result<(), serde_json::Error>
where
    R: serde_json::de::Read<'de>,
    S: DeserializeSeed<'de, Value = ()>,
{
    seed.deserialize(&mut *reader)?;
    reader.end()
}

/// What is no JSON, or of another form.
fn broken(error: serde_json::Error, span: Span, form: &str) -> Diagnostic {
    if error.is_io() {
        return unreadable(&io::Error::from(error));
    }
    let message = error.to_string();
    let message = message.split(" at line ").next().unwrap_or_default().to_owned();
    Diagnostic::error(Code::StatesMalformed, span, message, "here").help(format!("the form is {form}"))
}

/// The byte at 1-based `line` and `column` (in bytes).
fn json_place(source: Source<'_>, line: usize, column: usize) -> Span {
    let before = source.length_of_lines(line.saturating_sub(1));
    let start = (before + column.saturating_sub(1) as u64).min(source.length());
    Span::new(0, u32::try_from(line.max(1)).unwrap_or(u32::MAX), start, 1)
}

/// Carries the scene, and the fault of our own that stopped the reading, through serde.
#[derive(Clone, Copy)]
pub(crate) struct Context<'a> {
    pub(crate) scene: &'a Scene,
    reading: &'a Documents<'a>,
}

impl<'a> Context<'a> {
    pub(super) const fn freedom(self) -> &'a NodeFreedom {
        &self.reading.freedom
    }

    /// The place of the name that was just read.
    pub(crate) fn place(self, name: &str) -> Span {
        let PassedOver { lines, bytes } = &self.reading.passed_over;
        // A quotation mark follows it.
        let start = bytes.get().saturating_sub(name.len() as u64 + 1);
        Span::new(0, lines.get().saturating_add(1), start, name.len())
    }

    /// Ends the reading, for good.
    pub(crate) fn stop<E: serde::de::Error>(self, fault: Fault) -> E {
        self.reading.ends.set(true);
        self.halt(fault)
    }

    /// Ends this reading.
    fn halt<E: serde::de::Error>(self, fault: Fault) -> E {
        let error = E::custom(&fault.message);
        self.reading.fault.set(Some(fault));
        error
    }

    /// Ends the reading at a fault that was not told before; else there is no value.
    pub(crate) fn value<T, E: serde::de::Error>(self, value: Result<T, Fault>) -> Result<Option<T>, E> {
        let fault = match value {
            Ok(value) => return Ok(Some(value)),
            Err(fault) => fault,
        };
        let Documents { told, passed, met, .. } = self.reading;
        if is_of_scene(fault.code) {
            if told.borrow().contains(&fault.message) {
                return Ok(None);
            }
        } else {
            met.set(met.get() + 1);
            if met.get() <= passed.get() {
                return Ok(None);
            }
        }
        Err(self.halt(fault))
    }

    /// The value of a key. One of another form is a fault like others, once that was met: none is had of it.
    pub(crate) fn value_of<'de, T, A>(self, map: &mut A, whose: &str) -> Result<Option<T>, A::Error>
    where
        T: DeserializeOwned,
        A: MapAccess<'de>,
    {
        if !self.reading.by_value.get() {
            return map.next_value().map(Some);
        }
        let written: Box<RawValue> = map.next_value()?;
        let read = serde_json::from_str(written.get()).map_err(|error| {
            let message = error.to_string();
            let message = message.split(" at line ").next().unwrap_or_default();
            self.malformed(format!("{whose}: {message}"))
        });
        self.value(read)
    }

    fn malformed(self, message: String) -> Fault {
        Fault::new(Code::StatesMalformed, message, format!("the form is {}", self.reading.form.borrow()))
    }

    /// Passes over a key that there is not.
    pub(crate) fn unknown<'de, A: MapAccess<'de>>(
        self,
        map: &mut A,
        key: &str,
        known: &'static [&'static str],
    ) -> Result<(), A::Error> {
        if !self.reading.by_value.get() {
            return Err(A::Error::unknown_field(key, known));
        }
        let message = format!("unknown field `{key}`, expected one of `{}`", known.join("`, `"));
        self.value::<(), A::Error>(Err(self.malformed(message)))?;
        map.next_value::<IgnoredAny>().map(drop)
    }

    /// States are numbered upwards, or not at all.
    pub(super) fn count<E: serde::de::Error>(self, number: Option<u64>) -> Result<(), E> {
        let last = self.reading.last.replace(Some(number));
        self.value(check_number(last, number)).map(drop)
    }
}

#[cfg(test)]
mod tests {
    use crate::{Diagnostic, ForceFile, ForceSign, Scene, State, StateFile};

    const DECK: &str = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n9, 1, 2\n*CONNECTOR SECTION, ELSET=C\nLINK\n";

    /// An unknown node is told once, however often it comes, and what else is wrong beside it.
    #[test]
    fn every_fault_of_a_file_is_told_in_one_run() {
        let scene = Scene::parse("deck.inp", DECK).unwrap();
        let csv = "state,node,u1\n0,1,0\n0,7,0\n1,1,abc\n1,7,0\n2,2,xyz\n";
        let first = StateFile::parse_csv("s.csv", csv, &scene).unwrap_err();
        let all = 1 + first.further().len();
        assert_eq!(all, 3, "{first:?}");
        let json = r#"{"schema": "pintle-states/1", "states": [
            {"nodes": {"1": {"quaternion": [2, 0, 0, 0]}}},
            {"nodes": {"7": {}}},
            {"nodes": {"2": {"quaternion": [3, 0, 0, 0]}}}]}"#;
        let first = StateFile::parse_json("s.json", json, &scene).unwrap_err();
        assert_eq!(1 + first.further().len(), 3, "{first:?}");
        let other =
            StateFile::parse_json("s.json", r#"{"schema": "other/1", "states": []}"#, &scene).unwrap_err();
        assert_eq!(other.further().len(), 0, "{other:?}");
    }

    /// What has another form is told like what has another meaning: all of it, each in its line.
    #[test]
    fn every_value_of_another_form_is_told_in_one_run() {
        let scene = Scene::parse("deck.inp", DECK).unwrap();
        let json = "{\"schema\": \"pintle-states/1\", \"states\": [\n\
            {\"nodes\": {\"1\": {\"displacment\": [0, 0, 0]}}},\n\
            {\"nodes\": {\"2\": {\"displacement\": [0, 0]}}},\n\
            {\"tim\": 1, \"nodes\": {\"7\": {}}},\n\
            {\"time\": \"1\", \"nodes\": {\"2\": {\"quaternion\": [2, 0, 0, 0]}}}]}";
        let first = StateFile::parse_json("s.json", json, &scene).unwrap_err();
        let lines: Vec<u32> =
            [&first].into_iter().chain(first.further()).map(|error| error.span().line()).collect();
        assert_eq!(lines, [2, 3, 4, 4, 5, 5], "{first:?}");
        assert!(first.message().contains("node 1: unknown field `displacment`"), "{first:?}");
    }

    /// What is wrong with a file of forces, read and then given to two states: each message with its line.
    fn wrong(read: crate::diagnostic::Result<ForceFile>) -> Vec<(u32, String)> {
        let mut states = vec![State::default(), State::default()];
        let Err(first) = read.and_then(|file| file.attach(&mut states, 0)) else { return Vec::new() };
        let line = |error: &Diagnostic| (error.span().line(), error.message().to_owned());
        [&first].into_iter().chain(first.further()).map(line).collect()
    }

    /// Several faults of files of forces: of what is written, and of states that there are not. Each has its line.
    #[test]
    fn every_fault_of_a_file_of_forces_is_told_in_one_run() {
        let scene = Scene::parse("deck.inp", DECK).unwrap();
        let csv = |text: &str| wrong(ForceFile::parse_csv("f.csv", text, &scene, ForceSign::Internal));
        let json = |text: &str| wrong(ForceFile::parse_json("f.json", text, &scene, ForceSign::Internal));
        let lines = |told: Vec<(u32, String)>| told.into_iter().map(|(line, _)| line).collect::<Vec<u32>>();
        assert_eq!(csv("state,element,f1\n0,9,1\n1,9,2\n"), []);
        assert_eq!(lines(csv("state,element,f1\n0,7,1\n0,9,abc\n1,8,2\n")), [2, 3, 4]);
        assert_eq!(lines(csv("state,element,f1\n0,9,1\n5,9,2\n7,9,3\n")), [3, 4]);
        let document =
            |states: &str| format!("{{\"schema\": \"pintle-forces/1\", \"states\": [\n{states}]}}");
        let sound = document("{\"state\": 0, \"forces\": {\"9\": {\"f1\": 1}}}");
        assert_eq!(json(&sound), []);
        let told = json(&document(
            "{\"state\": 0, \"forces\": {\"7\": {\"f1\": 1},\n\"9\": {\"q\": 1}}},\n{\"state\": 1, \"forces\": {\"8\": {}}}",
        ));
        assert_eq!(lines(told), [2, 3, 4]);
        let told = json(&document(
            "{\"state\": 0, \"forces\": {\"9\": {\"f1\": 1}}},\n{\"state\": 5, \"forces\": {\"9\": {\"f1\": 2}}},\n\
             {\"forces\": {\"9\": {\"f1\": 3}}, \"state\": 7}",
        ));
        assert_eq!(lines(told), [3, 4]);
    }
}
