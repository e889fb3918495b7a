//! Files of other programs, frame by frame: tables in CSV, records in JSON, what Abaqus and CalculiX print (`.dat`), arrays of NumPy.

use crate::column::{Column, Map, Motion, Nodal, Rotations};
use crate::matrix;
use crate::motion::Between;
use crate::numpy::{self, Array};
use crate::printed::{Printed, Writing};
use pintle_kinematics::connector::Output;
use serde_json::value::RawValue;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// So many lines show with how many digits a column is written.
const SCANNED: usize = 2_000;

/// The longest line that is read.
const LONGEST: usize = 1 << 20;

/// All that files say of one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// The time, where the file has it.
    pub time: Option<f64>,
    /// The number of the state, where the file has it.
    pub number: Option<u64>,
    /// By node.
    pub nodes: BTreeMap<String, Vec<(Motion, Printed)>>,
    /// By element.
    pub elements: BTreeMap<String, Vec<(Output, usize, Printed)>>,
    /// Forces and moments at nodes.
    pub forces: BTreeMap<String, Vec<(Nodal, usize, Printed)>>,
    /// Whether the files tell a motion at all: that of nodes that are left out is zero.
    pub moves: bool,
    /// Whether the motion is taken between two states of the files.
    pub is_between: bool,
}

impl Frame {
    /// The same numbers where they went through single precision.
    pub(crate) fn single(&self) -> Self {
        let mut found = self.clone();
        let motions = found.nodes.values_mut().flatten().map(|(_, number)| number);
        let outputs = found.elements.values_mut().flatten().map(|(.., number)| number);
        let forces = found.forces.values_mut().flatten().map(|(.., number)| number);
        for number in motions.chain(outputs).chain(forces) {
            *number = number.single();
        }
        found
    }

    /// Whether it holds something to be compared.
    pub fn tells(&self) -> bool {
        !self.elements.is_empty() || !self.forces.is_empty()
    }
}

/// The files of one run, read as often as needed, a frame at a time.
#[derive(Clone, Debug)]
pub struct Results {
    files: Vec<PathBuf>,
    /// What is not standard in them.
    pub map: Map,
    /// Whether states without a motion get one between those of the files.
    pub interpolates: bool,
}

/// One line of any of the formats.
#[derive(Debug, Default)]
struct Row {
    time: Option<f64>,
    number: Option<u64>,
    node: Option<String>,
    element: Option<String>,
    motions: Vec<(Motion, Printed)>,
    outputs: Vec<(Output, usize, Printed)>,
    forces: Vec<(Nodal, usize, Printed)>,
    /// Whether it begins a table of motions, which leaves out nodes at rest.
    begins_motion: bool,
    /// Its numbers as they are written, with their headings.
    written: Vec<(String, String)>,
    /// Where it stands, in words.
    place: String,
}

type Rows = Box<dyn Iterator<Item = Result<Row, String>>>;

impl Results {
    /// Of these files.
    pub const fn new(files: Vec<PathBuf>, map: Map) -> Self {
        Self { files, map, interpolates: false }
    }

    /// The files that hold matrices.
    pub(crate) fn matrices(&self) -> Vec<PathBuf> {
        self.files.iter().filter(|file| self.is_matrix(file)).cloned().collect()
    }

    fn is_matrix(&self, file: &Path) -> bool {
        match extension(file).as_str() {
            "mtx" => true,
            "npy" | "npz" => {
                let is_known = |name: &str| is_known(&self.map, name);
                numpy::arrays(file).is_ok_and(|(all, _)| matrix::is_matrix(&all, is_known))
            }
            _ => false,
        }
    }

    /// The headings of tables that have no known meaning, by file.
    pub(crate) fn unread(&self) -> Vec<(String, Vec<String>)> {
        let mut found = Vec::new();
        for file in self.files.iter().filter(|file| extension(file) == "csv") {
            let Ok(opened) = File::open(file) else { continue };
            let Ok(mut reader) = table(BufReader::new(opened)) else { continue };
            let Ok(headings) = reader.headers() else { continue };
            let is_meant = |heading: &str| {
                self.map.columns.keys().any(|known| known.trim().eq_ignore_ascii_case(heading.trim()))
            };
            let is_unknown = |heading: &&str| self.map.column(heading) == Column::Other && !is_meant(heading);
            let unknown: Vec<String> = headings.iter().filter(is_unknown).map(str::to_string).collect();
            if !unknown.is_empty() {
                found.push((file.display().to_string(), unknown));
            }
        }
        found
    }

    /// Hands on every frame, in the order of times. Files of one run are joined by time, or by number where there are no times.
    ///
    /// # Errors
    /// What cannot be read, with file and line; or the first of `take`.
    pub fn each(&self, mut take: impl FnMut(&Frame) -> Result<(), String>) -> Result<(), String> {
        self.each_until(|frame| take(frame).map(ControlFlow::Continue))
    }

    /// The same, until `take` has seen enough.
    pub(crate) fn each_until(
        &self,
        mut take: impl FnMut(&Frame) -> Result<ControlFlow<()>, String>,
    ) -> Result<(), String> {
        if !self.interpolates {
            return self.each_as_it_is(|frame| take(&frame)).map(|_| ());
        }
        if self.map.rotations == Rotations::Incremental {
            return Err("rotations since the state before are not interpolated: give total ones".into());
        }
        let mut between = Between::default();
        let mut all = |frames: &[Frame]| {
            for frame in frames {
                if take(frame)?.is_break() {
                    return Ok(ControlFlow::Break(()));
                }
            }
            Ok(ControlFlow::Continue(()))
        };
        let flow = self.each_as_it_is(|frame| all(&between.push(frame)))?;
        if flow.is_continue() { all(&between.rest()).map(|_| ()) } else { Ok(()) }
    }

    fn each_as_it_is(
        &self,
        mut take: impl FnMut(Frame) -> Result<ControlFlow<()>, String>,
    ) -> Result<ControlFlow<()>, String> {
        let mut streams = Vec::new();
        for file in self.files.iter().filter(|file| !self.is_matrix(file)) {
            streams.push(Frames::open(file, &self.map)?);
        }
        let mut heads: Vec<Option<Frame>> = Vec::new();
        for stream in &mut streams {
            heads.push(stream.next().transpose()?);
        }
        let first = || heads.iter().zip(&streams).filter_map(|(head, of)| Some((head.as_ref()?, &of.file)));
        let by_time = first().all(|(frame, _)| frame.time.is_some());
        if let Some((_, file)) = first().find(|(frame, _)| !by_time && frame.number.is_none()) {
            let other = first().find(|(frame, _)| frame.time.is_none()).map_or("", |(_, file)| file);
            return Err(format!(
                "{file} has times, and {other} has none: their lines cannot be joined; give both times, or both numbers of states"
            ));
        }
        let key = |frame: &Frame| if by_time { frame.time } else { frame.number.map(|n| n as f64) };
        let key = |frame: &Frame| key(frame).unwrap_or(0.0);
        loop {
            let earliest = heads.iter().flatten().map(key).fold(f64::INFINITY, f64::min);
            if earliest.is_infinite() {
                return Ok(ControlFlow::Continue(()));
            }
            let mut joined = Frame::default();
            for (head, stream) in heads.iter_mut().zip(&mut streams) {
                let is_now = |frame: &mut Frame| (key(frame) - earliest).abs() <= 1e-9 * earliest.abs();
                if let Some(frame) = head.take_if(is_now) {
                    joined.time = joined.time.or(frame.time);
                    joined.number = joined.number.or(frame.number);
                    joined.moves |= frame.moves;
                    for (node, motions) in frame.nodes {
                        joined.nodes.entry(node).or_default().extend(motions);
                    }
                    for (element, outputs) in frame.elements {
                        joined.elements.entry(element).or_default().extend(outputs);
                    }
                    for (node, forces) in frame.forces {
                        joined.forces.entry(node).or_default().extend(forces);
                    }
                    *head = stream.next().transpose()?;
                    if let Some(next) = head
                        && key(next) < earliest
                    {
                        let at = key(next);
                        return Err(format!(
                            "{}: {at} comes after {earliest}: times must not go back",
                            stream.file
                        ));
                    }
                }
            }
            if take(joined)?.is_break() {
                return Ok(ControlFlow::Break(()));
            }
        }
    }
}

/// The ending of a file's name.
fn extension(path: &Path) -> String {
    path.extension().map(|x| x.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

/// Whether an array of this name is one column, or several.
fn is_known(map: &Map, name: &str) -> bool {
    [name.to_string(), format!("{name}1")].iter().any(|name| map.column(name) != Column::Other)
}

/// The frames of one file.
struct Frames {
    file: String,
    rows: Rows,
    next: Option<Row>,
    counted: u64,
    map: Map,
}

impl Frames {
    fn open(path: &Path, map: &Map) -> Result<Self, String> {
        let mut map = map.clone();
        let kind = extension(path);
        if matches!(kind.as_str(), "csv" | "json" | "jsonl" | "ndjson") {
            let written: Vec<_> =
                Self::rows(path, &map)?.take(SCANNED).flatten().flat_map(|row| row.written).collect();
            map.writing = Writing::of(written.iter(), kind != "csv");
        }
        let rows = Self::rows(path, &map)?;
        Ok(Self { file: path.display().to_string(), rows, next: None, counted: 0, map })
    }

    fn rows(path: &Path, map: &Map) -> Result<Rows, String> {
        let file = path.display().to_string();
        let named = |error: std::io::Error| format!("cannot read {file}: {error}");
        let opened = || File::open(path).map(BufReader::new).map_err(named);
        let rows: Rows = match extension(path).as_str() {
            "csv" => csv_rows(file.clone(), opened()?, map.clone())?,
            "jsonl" | "ndjson" => json_lines(file.clone(), opened()?, map.clone()),
            "json" => json_rows(file.clone(), opened()?, map.clone()),
            "npy" | "npz" => array_rows(file.clone(), numpy::arrays(path)?.0, map.clone())?,
            "dat" => printed_rows(file.clone(), opened()?, map.clone()),
            other => {
                return Err(format!(
                    "{file}: there is no reader for .{other}; there are .csv, .json, .jsonl, .dat, .npy, .npz and .mtx"
                ));
            }
        };
        Ok(rows)
    }

    fn next(&mut self) -> Option<Result<Frame, String>> {
        let mut frame: Option<Frame> = None;
        loop {
            let row = match self.next.take() {
                Some(row) => row,
                None => match self.rows.next() {
                    Some(Ok(row)) => row,
                    Some(Err(error)) => return Some(Err(error)),
                    None => return frame.map(Ok),
                },
            };
            let node = row.node.clone().or_else(|| self.map.node.clone());
            let element = row.element.clone().or_else(|| self.map.element.clone());
            if let Some(known) = &frame {
                let is_same = match (row.time, row.number) {
                    (Some(time), _) => known.time == Some(time),
                    (None, Some(number)) => known.number == Some(number),
                    // What names neither begins anew where a label comes again.
                    (None, None) => {
                        let is_new = |label: &Option<String>, known: &dyn Fn(&String) -> bool| {
                            label.as_ref().is_none_or(|label| !known(label))
                        };
                        let again = |label: &String| {
                            known.nodes.contains_key(label) && !row.motions.is_empty()
                                || known.forces.contains_key(label) && !row.forces.is_empty()
                        };
                        is_new(&node, &again)
                            && is_new(&element, &|label| {
                                known.elements.contains_key(label) && !row.outputs.is_empty()
                            })
                            && (node.is_some() || element.is_some())
                    }
                };
                if !is_same {
                    self.next = Some(row);
                    return frame.map(Ok);
                }
            }
            let counted = &mut self.counted;
            let of = frame.get_or_insert_with(|| {
                let number = row.number.or((row.time.is_none()).then_some(*counted));
                *counted += 1;
                Frame { time: row.time, number, ..Frame::default() }
            });
            of.moves |= row.begins_motion || !row.motions.is_empty();
            if !row.motions.is_empty() || !row.forces.is_empty() {
                let Some(node) = node else {
                    return Some(Err(format!(
                        "{}: a motion or force of no node: name a column node, or node in the map",
                        row.place
                    )));
                };
                if !row.motions.is_empty() {
                    of.nodes.entry(node.clone()).or_default().extend(row.motions);
                }
                if !row.forces.is_empty() {
                    of.forces.entry(node).or_default().extend(row.forces);
                }
            }
            if !row.outputs.is_empty() {
                let Some(element) = element else {
                    return Some(Err(format!(
                        "{}: an output of no element: name a column element, or element in the map",
                        row.place
                    )));
                };
                of.elements.entry(element).or_default().extend(row.outputs);
            }
        }
    }
}

impl Row {
    /// Takes a cell.
    fn put(&mut self, column: Column, heading: &str, text: &str, map: &Map) -> Result<(), String> {
        let text = text.trim();
        if text.is_empty() || column == Column::Other {
            return Ok(());
        }
        match column {
            Column::Node => self.node = Some(label(text)),
            Column::Element => self.element = Some(label(text)),
            _ => {
                let number = Printed::parse(text).ok_or_else(|| {
                    format!("{}: {heading} is {:?}, not a number", self.place, excerpt(text))
                })?;
                if map.writing == Writing::default() && !matches!(column, Column::Time | Column::State) {
                    self.written.push((heading.to_string(), text.to_string()));
                }
                self.put_number(column, heading, map.writing.known(heading, number), map)?;
            }
        }
        Ok(())
    }

    /// Takes a number.
    fn put_number(
        &mut self,
        column: Column,
        heading: &str,
        number: Printed,
        map: &Map,
    ) -> Result<(), String> {
        let known = if map.single { number.single() } else { number };
        match column {
            Column::Node => self.node = Some(number.x.to_string()),
            Column::Element => self.element = Some(number.x.to_string()),
            Column::State if number.x < 0.0 || number.x.fract() != 0.0 => {
                return Err(format!(
                    "{}: {heading} is {}, not the whole number of a state; where it is a time, a map says so: [columns] \"{heading}\" = \"Time\"",
                    self.place, number.x
                ));
            }
            Column::State => self.number = Some(number.x as u64),
            Column::Time => self.time = Some(number.x),
            Column::Motion(motion) => self.motions.push((motion, known.times(map.of_motion(motion)))),
            Column::Output(output, k) => self.outputs.push((output, k, known)),
            Column::Nodal(nodal, i) => {
                let unit = if i < 3 { map.force } else { map.force * map.length };
                self.forces.push((nodal, i, known.times(unit)));
            }
            Column::Other => {}
        }
        Ok(())
    }
}

/// `12.` and `12` are one label.
fn label(text: &str) -> String {
    text.trim_matches('"').trim_end_matches('.').to_ascii_uppercase()
}

fn excerpt(text: &str) -> String {
    const SHOWN: usize = 60;
    let shown: String = text.chars().take(SHOWN).collect();
    if shown.len() < text.len() { format!("{shown}…") } else { shown }
}

/// Refuses a table of which no heading has a meaning.
fn told(file: &str, columns: &[(Column, String)]) -> Result<(), String> {
    let is_told = |(column, _): &(Column, String)| {
        matches!(column, Column::Motion(_) | Column::Output(..) | Column::Nodal(..))
    };
    if columns.iter().any(is_told) {
        return Ok(());
    }
    let found: Vec<&str> = columns.iter().take(20).map(|(_, heading)| heading.as_str()).collect();
    Err(format!(
        "{file}: no heading is a motion of nodes (U1, UR1, q0 …), a force at nodes (RF1 …) or an output of connectors (CU1, CTF1 …); \
         they are {}; a map says what they mean: [columns] \"{}\" = \"CU1\"",
        found.join(", "),
        found.first().unwrap_or(&"")
    ))
}

fn csv_rows(file: String, from: impl BufRead + 'static, map: Map) -> Result<Rows, String> {
    let mut reader = table(from).map_err(|error| format!("cannot read {file}: {error}"))?;
    let headings = reader.headers().map_err(|error| format!("{file}: {error}"))?.clone();
    let columns: Vec<(Column, String)> =
        headings.iter().map(|heading| (map.column(heading), heading.to_string())).collect();
    told(&file, &columns)?;
    Ok(Box::new(reader.into_records().map(move |record| {
        let record = record.map_err(|error| format!("{file}: {error}"))?;
        let line = record.position().map_or(0, csv::Position::line);
        let mut row = Row { place: format!("{file}:{line}"), ..Row::default() };
        if record.len() != columns.len() {
            return Err(format!("{}: {} cells, and {} headings", row.place, record.len(), columns.len()));
        }
        for ((column, heading), text) in columns.iter().zip(&record) {
            row.put(*column, heading, text, &map)?;
        }
        Ok(row)
    })))
}

/// A table whose columns are apart by commas, or where its headings have none by semicolons or tabulators.
fn table<R: BufRead>(mut from: R) -> std::io::Result<csv::Reader<R>> {
    let mut lines = from.fill_buf()?.split(|byte| *byte == b'\n');
    let headings = lines.find(|line| !line.starts_with(b"#")).unwrap_or_default();
    let between = [b',', b';', b'\t'].into_iter().find(|byte| headings.contains(byte));
    let mut builder = csv::ReaderBuilder::new();
    builder.comment(Some(b'#')).delimiter(between.unwrap_or(b',')).flexible(true).trim(csv::Trim::All);
    Ok(builder.from_reader(from))
}

/// A record as an object.
fn of_object(place: String, text: &str, map: &Map) -> Result<Row, String> {
    let object: BTreeMap<String, Box<RawValue>> =
        serde_json::from_str(text).map_err(|error| format!("{place}: {error}"))?;
    let mut row = Row { place, ..Row::default() };
    for (key, value) in object {
        let column = map.column(&key);
        let text = value.get();
        let text = if text == "null" { "" } else { text.trim_matches('"') };
        row.put(column, &key, text, map)?;
    }
    Ok(row)
}

fn json_lines(file: String, from: impl BufRead + 'static, map: Map) -> Rows {
    let lines = lines(file.clone(), from)
        .filter(|line| line.as_ref().is_ok_and(|(_, line)| !line.trim().is_empty()) || line.is_err());
    Box::new(lines.map(move |line| {
        let (number, line) = line?;
        of_object(format!("{file}:{number}"), &line, &map)
    }))
}

/// The records of a list, each as long as it is: the list itself is never held.
fn json_rows(file: String, from: impl BufRead + 'static, map: Map) -> Rows {
    let mut bytes = from.bytes();
    let (mut counted, mut is_in_list, mut is_done) = (0, false, false);
    Box::new(std::iter::from_fn(move || {
        if is_done {
            return None;
        }
        let place = format!("{file}, record {}", counted + 1);
        let mut fail = |why: &str| {
            is_done = true;
            let remedy = "it is to be a list of records {\"time\": …, \"node\": …, \"U1\": …}";
            Some(Err(format!("{place}: {why}; {remedy}")))
        };
        let (mut text, mut depth, mut is_text, mut is_escaped) = (Vec::new(), 0_usize, false, false);
        for byte in bytes.by_ref() {
            let Ok(byte) = byte else { return fail("it cannot be read") };
            if depth == 0 {
                match byte {
                    b'[' if !is_in_list => is_in_list = true,
                    b']' if is_in_list => {
                        is_done = true;
                        return None;
                    }
                    b'{' if is_in_list => (depth, text) = (1, vec![byte]),
                    b',' if is_in_list => {}
                    _ if byte.is_ascii_whitespace() => {}
                    _ => return fail("what stands there is no record"),
                }
                continue;
            }
            text.push(byte);
            if text.len() > LONGEST {
                return fail("it is too long");
            }
            match byte {
                _ if is_escaped => is_escaped = false,
                b'\\' if is_text => is_escaped = true,
                b'"' => is_text = !is_text,
                b'{' | b'[' if !is_text => depth += 1,
                b'}' | b']' if !is_text => depth -= 1,
                _ => {}
            }
            if depth == 0 {
                counted += 1;
                return Some(of_object(place, &String::from_utf8_lossy(&text), &map));
            }
        }
        fail("the list ends in the middle")
    }))
}

/// The records of arrays: a column for each field or array, several for one of two dimensions.
fn array_rows(file: String, all: Vec<Array>, map: Map) -> Result<Rows, String> {
    if all.iter().any(|array| array.shape.len() == 3) && all.iter().any(|array| array.name == "node") {
        return state_rows(file, all, map);
    }
    table_rows(file, all, map)
}

/// What `pintle solve` writes into its arrays besides the motions of nodes.
const OF_SOLUTIONS: [&str; 10] =
    ["element", "CU", "CV", "CTF", "CSF", "sticks", "energies", "event_time", "event", "event_element"];

/// The motions of nodes that `pintle states --format npz` and `pintle solve` write: by state, node and component, with the labels of the
/// nodes.
fn state_rows(file: String, all: Vec<Array>, map: Map) -> Result<Rows, String> {
    let (mut labels, mut by_state, mut by_node) = (Vec::new(), Vec::new(), Vec::new());
    let mut sizes: Option<(usize, usize)> = None;
    let is_solution = all.iter().any(|array| array.name == "energies");
    for mut array in all.into_iter().filter(|of| !(is_solution && OF_SOLUTIONS.contains(&of.name.as_str()))) {
        if array.name == "node" {
            labels = array.labels().map_err(|why| format!("{file}: node: {why}"))?;
            continue;
        }
        let name = array.name.clone();
        let columns: Vec<Column> = match name.as_str() {
            "state" => vec![Column::State],
            "time" => vec![Column::Time],
            "flow" => vec![Column::Motion(Motion::Flow)],
            "u" | "U" => (0..3).map(|i| Column::Motion(Motion::Displacement(i))).collect(),
            "quaternion" => (0..4).map(|i| Column::Motion(Motion::Quaternion(i))).collect(),
            "rotation_vector" | "UR" => (0..3).map(|i| Column::Motion(Motion::Rotation(i))).collect(),
            "velocity" | "V" => (0..3).map(|i| Column::Motion(Motion::Velocity(i))).collect(),
            "angular_velocity" | "VR" => (0..3).map(|i| Column::Motion(Motion::AngularVelocity(i))).collect(),
            "acceleration" | "A" => (0..3).map(|i| Column::Motion(Motion::Acceleration(i))).collect(),
            "angular_acceleration" | "AR" => {
                (0..3).map(|i| Column::Motion(Motion::AngularAcceleration(i))).collect()
            }
            "flow_velocity" => vec![Column::Motion(Motion::FlowVelocity)],
            "flow_acceleration" => vec![Column::Motion(Motion::FlowAcceleration)],
            other => {
                return Err(format!(
                    "{file}: there is no array {other} of states by node; there are state, time, node, u, quaternion or \
                     rotation_vector, flow, and their velocity and acceleration"
                ));
            }
        };
        let (is_by_state, wanted) = match columns.first() {
            Some(Column::State | Column::Time) => (true, 1),
            _ => (false, if columns.len() == 1 { 2 } else { 3 }),
        };
        let shape = array.shape.clone();
        let is_right = shape.len() == wanted
            && !array.is_fortran
            && !array.is_text()
            && array.fields.len() == 1
            && (wanted < 3 || shape[2] == columns.len());
        if !is_right {
            return Err(format!(
                "{file}: {name} has the shape {shape:?}; it is to be by state, node, component"
            ));
        }
        if is_by_state {
            by_state.push((array, columns));
        } else {
            let found = (shape[0], shape[1]);
            if sizes.is_some_and(|sizes| sizes != found) {
                return Err(format!("{file}: {name} has {found:?} states and nodes, and others {sizes:?}"));
            }
            sizes = Some(found);
            by_node.push((array, columns));
        }
    }
    let (states, nodes) = sizes.ok_or_else(|| format!("{file}: no array has motions by state and node"))?;
    if labels.len() != nodes {
        return Err(format!("{file}: {} labels in node, and motions of {nodes} nodes", labels.len()));
    }
    let mut seen = BTreeSet::new();
    if let Some(twice) = labels.iter().find(|label| !seen.insert(label.to_ascii_uppercase())) {
        return Err(format!("{file}: node has {twice} twice"));
    }
    if let Some((array, _)) = by_state.iter().find(|(array, _): &&(Array, _)| array.shape != [states]) {
        return Err(format!("{file}: {} has {:?} states, and others {states}", array.name, array.shape));
    }
    let count = states
        .checked_mul(nodes)
        .ok_or_else(|| format!("{file}: {states} states of {nodes} nodes are too many"))?;
    let (mut read, mut number, mut time) = (0, None, None);
    Ok(Box::new(std::iter::from_fn(move || {
        if read == count {
            return None;
        }
        let (state, node) = (read / nodes, read % nodes);
        read += 1;
        let place = format!("{file}, state {state}, node {}", labels[node]);
        let mut row = Row { place, node: Some(label(&labels[node])), ..Row::default() };
        let all = |arrays: &mut Vec<(Array, Vec<Column>)>, row: &mut Row| -> Result<(), String> {
            for (array, columns) in arrays {
                let numbers = array
                    .take(columns.len())
                    .map_err(|why| format!("{}: {}: {why}", row.place, array.name))?;
                for (number, column) in numbers.into_iter().zip(columns) {
                    if !number.x.is_finite() {
                        return Err(format!("{}: {} is not finite", row.place, array.name));
                    }
                    row.put_number(*column, &array.name, number, &map)?;
                }
            }
            Ok(())
        };
        if node == 0 {
            if let Err(why) = all(&mut by_state, &mut row) {
                return Some(Err(why));
            }
            (number, time) = (row.number, row.time);
        }
        (row.number, row.time) = (number, time);
        Some(all(&mut by_node, &mut row).map(|()| row))
    })))
}

/// A line for each state.
fn table_rows(file: String, mut all: Vec<Array>, map: Map) -> Result<Rows, String> {
    let mut columns: Vec<(Column, String)> = Vec::new();
    let mut count = None;
    for array in &all {
        let (rows, width) = match array.shape.as_slice() {
            [rows] => (*rows, 1),
            [rows, width] if !array.is_fortran && array.fields.len() == 1 => (*rows, *width),
            shape => {
                let name = &array.name;
                return Err(format!(
                    "{file}: {name} has the shape {shape:?}; it is to have a line for each state"
                ));
            }
        };
        if count.is_some_and(|count| count != rows) {
            return Err(format!(
                "{file}: {} has {rows} lines, and others {}",
                array.name,
                count.unwrap_or(0)
            ));
        }
        count = Some(rows);
        let first = usize::from(!array.name.eq_ignore_ascii_case("q"));
        for field in &array.fields {
            let name = if field.is_empty() { &array.name } else { field };
            let names =
                (0..width).map(|n| if width == 1 { name.clone() } else { format!("{name}{}", n + first) });
            columns.extend(names.map(|name| (map.column(&name), name)));
        }
    }
    told(&file, &columns)?;
    let mut read = 0;
    Ok(Box::new(std::iter::from_fn(move || {
        if Some(read) == count {
            return None;
        }
        read += 1;
        let mut row = Row { place: format!("{file}, line {read}"), ..Row::default() };
        let mut columns = columns.iter();
        for array in &mut all {
            let width = array.shape.get(1).copied().unwrap_or(1);
            let numbers = if array.fields.len() > 1 || !array.fields[0].is_empty() {
                array
                    .next()
                    .and_then(|record| record.ok_or_else(|| "it ends before its last line".to_string()))
            } else {
                array.take(width)
            };
            let numbers = match numbers {
                Ok(numbers) => numbers,
                Err(why) => return Some(Err(format!("{}: {}: {why}", row.place, array.name))),
            };
            for (number, (column, heading)) in numbers.into_iter().zip(&mut columns) {
                // NaN stands for what is not there.
                if number.x.is_finite() {
                    if let Err(why) = row.put_number(*column, heading, number, &map) {
                        return Some(Err(why));
                    }
                } else if number.x.is_infinite() {
                    return Some(Err(format!("{}: {heading} is infinite", row.place)));
                }
            }
        }
        Some(Ok(row))
    })))
}

/// Lines with their numbers.
fn lines(
    file: String,
    mut from: impl BufRead + 'static,
) -> impl Iterator<Item = Result<(usize, String), String>> {
    let mut number = 0;
    std::iter::from_fn(move || {
        let mut bytes = Vec::new();
        let taken = from.by_ref().take(LONGEST as u64).read_until(b'\n', &mut bytes);
        number += 1;
        match taken {
            Err(error) => Some(Err(format!("cannot read {file}: {error}"))),
            Ok(0) => None,
            Ok(LONGEST) => Some(Err(format!("{file}:{number}: the line is longer than {LONGEST} bytes"))),
            Ok(_) => Some(Ok((number, String::from_utf8_lossy(&bytes).trim_end().to_string()))),
        }
    })
}

/// What a table of a `.dat` file holds.
enum Table {
    /// Of nodes or elements, by columns.
    Of {
        is_node: bool,
        columns: Vec<(Column, String)>,
    },
    None,
}

/// The tables that Abaqus prints for `*NODE PRINT` and `*EL PRINT`, and CalculiX for `*NODE PRINT`.
fn printed_rows(file: String, from: impl BufRead + 'static, map: Map) -> Rows {
    let (mut table, mut time) = (Table::None, None);
    Box::new(lines(file.clone(), from).filter_map(move |line| {
        let (number, line) = match line {
            Ok(line) => line,
            Err(error) => return Some(Err(error)),
        };
        let place = format!("{file}:{number}");
        let words = Printed::words(&line);
        let upper = line.to_ascii_uppercase();
        if let Some(at) = upper.find("TOTAL TIME COMPLETED") {
            let told = line[at + "TOTAL TIME COMPLETED".len()..].split(',').next().unwrap_or_default();
            time = Printed::parse(told).map(|time| time.x);
            table = Table::None;
            return time.is_none().then(|| Err(format!("{place}: {:?} is no time", excerpt(told.trim()))));
        }
        // CalculiX: «displacements (vx,vy,vz) for set ALL and time  0.1000000E+01».
        if let Some((_, told)) = upper.split_once(" AND TIME ") {
            time = Printed::parse(told).map(|time| time.x);
            let head = upper.trim_start();
            let begins_motion = head.starts_with("DISPLACEMENTS");
            let of = |letter: &str, column: fn(usize) -> Column| Table::Of {
                is_node: true,
                columns: (0..3).map(|i| (column(i), format!("{letter}{}", ["x", "y", "z"][i]))).collect(),
            };
            table = if head.starts_with("DISPLACEMENTS") {
                of("v", |i| Column::Motion(Motion::Displacement(i)))
            } else if head.starts_with("FORCES") {
                of("f", |i| Column::Nodal(Nodal::Reaction, i))
            } else {
                Table::None
            };
            return begins_motion.then(|| Ok(Row { place, time, begins_motion, ..Row::default() }));
        }
        let heads = |kind: &str| words.first().is_some_and(|word| word.eq_ignore_ascii_case(kind));
        let is_node = heads("NODE");
        if (is_node || heads("ELEMENT")) && upper.contains("FOOT-") {
            let after = words.iter().skip_while(|word| !word.eq_ignore_ascii_case("FOOT-")).skip(1);
            let columns: Vec<(Column, String)> =
                after.map(|heading| (map.column(heading), (*heading).to_string())).collect();
            let begins_motion =
                is_node && columns.iter().any(|(column, _)| matches!(column, Column::Motion(_)));
            table = Table::Of { is_node, columns };
            return begins_motion.then(|| Ok(Row { place, time, begins_motion, ..Row::default() }));
        }
        let Table::Of { is_node, columns } = &table else { return None };
        let label_of = words.first().filter(|word| word.parse::<u64>().is_ok())?;
        let numbers = words.len().checked_sub(columns.len()).filter(|first| (1..=2).contains(first));
        let Some(first) = numbers else {
            return Some(Err(format!("{place}: {} numbers, and {} columns", words.len() - 1, columns.len())));
        };
        let mut row = Row { place, time, ..Row::default() };
        let owner = Some(label(label_of));
        if *is_node {
            row.node = owner
        } else {
            row.element = owner
        }
        for ((column, heading), text) in columns.iter().zip(&words[first..]) {
            // Such a table has significant digits, and prints what is zero as 0.000.
            let is_zero = Printed::parse(text).is_some_and(|number| number.x == 0.0);
            let text = if is_zero { &"0" } else { text };
            if let Err(error) = row.put(*column, heading, text, &map) {
                return Some(Err(error));
            }
        }
        Some(Ok(row))
    }))
}
