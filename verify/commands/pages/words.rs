//! Whether every word that a report prints is explained.
//!
//! The commands write styles: what is bold and has three cells is a heading; of a table of `pintle eval` its title is bold and its heading dim.

use crate::commands::check::has_python;
use crate::commands::cli::{folder, pintle, stderr, stdout};
use pintle_audit::laws::Invariant;
use pintle_audit::{Oracle, Quantity, Verdict};
use pintle_kinematics::connector::Output;
use pintle_kinematics::mpc;
use pintle_kinematics::node::DOF;
use pintle_report::glossary;
use pintle_solve::What;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// What two blanks or more keep apart.
fn cells(line: &str) -> impl Iterator<Item = &str> {
    line.split("  ").map(str::trim).filter(|cell| !cell.is_empty())
}

/// A line without the codes of its styles.
fn plain(line: &str) -> String {
    let mut parts = line.split('\u{1b}');
    let first = parts.next().unwrap_or_default().to_string();
    parts.fold(first, |text, part| text + part.split_once('m').map_or("", |(_, rest)| rest))
}

/// What begins with a small letter, and has no number.
fn is_key(text: &str) -> bool {
    text.starts_with(char::is_lowercase)
        && !text.contains("  ")
        && text.chars().all(|c| c.is_alphabetic() || " -/×".contains(c))
}

/// Whether a cell is a word, not a number, an element, a sentence, or what is entered in a matrix.
fn is_word(cell: &str) -> bool {
    let is_element = cell.split(' ').next().is_some_and(|first| {
        first.chars().count() > 1 && first.chars().all(|c| c.is_uppercase() || "-0123456789.".contains(c))
    });
    cell.starts_with(|c: char| c.is_alphabetic() || c == '∂' || c == '[')
        && !is_element
        && !cell.starts_with("node ")
        && !cell.contains(['=', ':', ',', '²', '→'])
        && cell.split(' ').count() < 7
}

/// Headings of tables, words in their cells, and keys, each with the first line in which it stands.
fn words(report: &str) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let mut in_table = false;
    for line in report.lines() {
        let text = plain(line);
        let mut add = |word: &str| {
            if word.trim().starts_with(|c: char| !c.is_numeric()) {
                found.entry(word.trim().to_string()).or_insert_with(|| text.clone());
            }
        };
        let heading = line.strip_prefix("\u{1b}[1m");
        let of_eval = heading.and_then(|line| line.split_once("\u{1b}[2m")).map(|(_, dim)| plain(dim));
        if let Some(heading) = of_eval {
            cells(&heading).for_each(&mut add);
            in_table = true;
            continue;
        }
        if heading.is_some() && cells(&text).count() > 2 {
            cells(&text).for_each(&mut add);
            in_table = true;
            continue;
        }
        in_table &= !text.is_empty();
        // `key: …`, `key  …`, and of energies `key 1, key 2; key 3`.
        for (end, of) in [(": ", text.trim_start()), ("  ", text.trim())] {
            let key = of.split_once(end).map(|(key, _)| key).filter(|key| is_key(key));
            if let Some(component) = key.and_then(|key| key.strip_prefix("margin of ")) {
                [component, "margin of"].into_iter().for_each(&mut add);
            } else {
                key.into_iter().flat_map(|key| key.split(" against ")).for_each(&mut add);
            }
        }
        if let Some((_, list)) = text.split_once("energies: ") {
            list.split([',', ';']).filter_map(|of| of.trim().rsplit_once(' ')).for_each(|(key, _)| add(key));
        }
        if in_table && cells(&text).count() > 1 {
            for cell in cells(&text).filter(|cell| is_word(cell)) {
                // Lists of components, nodes and rules.
                match cell.contains(|c: char| c == '/' || c.is_ascii_digit()) || cell.starts_with("S M") {
                    true => cell.split([' ', '/', '(', ')']).for_each(&mut add),
                    false => add(cell),
                }
            }
        }
    }
    found
}

/// A hinge, how another program moved it, and a turn that this program lost.
const DECK: &str = "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n*ORIENTATION, NAME=OZ\n0., 0., 1.,  1., 0., 0.\n\
                    *ELEMENT, TYPE=CONN3D2, ELSET=PIN\n7, 1, 2\n*CONNECTOR SECTION, ELSET=PIN\nHINGE\nOZ,\n*BOUNDARY\n1, 1, 6\n";
const TURNS: &str = "Time,Node,UR-UR3\n0.0,2,0.0\n0.2,2,1.04\n0.4,2,2.08\n0.6,2,3.12\n0.8,2,4.16\n";
const LOST: &str = "Time,Element,CU-CUR1,CTF-CTM1\n0.0,7,0.0,0.0\n0.2,7,1.04,0.0\n0.4,7,2.08,0.0\n0.6,7,3.12,0.0\n0.8,7,-2.1232,0.0\n";

/// The commands whose reports are read, and at least how many words each has.
fn commands(folder: &Path) -> Vec<(Vec<String>, usize)> {
    let path = |name: &str| folder.join(name).to_str().expect("UTF-8").to_string();
    for (name, text) in [("hinge.inp", DECK), ("turns.csv", TURNS), ("lost.csv", LOST)] {
        fs::write(path(name), text).expect("a file");
    }
    let solved = ["solve", "references/drawer", "--every", "0.5", "-o", &path("run.csv")];
    pintle(&solved).assert().success();
    let owned = |words: &[&str]| words.iter().map(ToString::to_string).collect::<Vec<_>>();
    let mut all = vec![
        (owned(&["list"]), 40),
        (owned(&["sweep", "--states", "500", "--oracle-share", "0.02"]), 9),
        (owned(&["bench", "HINGE", "--rounds", "1", "--states", "2"]), 8),
        (owned(&["audit", "gallery:slider_crank", "--wide-states", "1", "-v"]), 30),
        (owned(&["compare", &path("hinge.inp"), "--against", &path("turns.csv"), &path("lost.csv")]), 7),
        (owned(&["compare", "references/drawer", "--against", &path("run.csv")]), 7),
    ];
    for example in pintle_scene::GALLERY {
        let scene = format!("gallery:{}", example.name);
        all.push((owned(&["eval", &scene, "--order", "2", "--outputs", "ALL"]), 25));
        all.push((owned(&["audit", &scene, "--wide-states", "1"]), 25));
    }
    // Friction that sticks and slips, a stop, a lock, a failure, forces that are open.
    for name in ["drawer", "chain", "stop_friction", "lock", "failure", "double_hinge"] {
        all.push((owned(&["solve", &format!("references/{name}")]), 15));
    }
    if has_python() {
        fs::copy(
            Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/elements/my_elements.py"),
            path("my_elements.py"),
        )
        .expect("a copy");
        let few = ["--states", "6", "--near-singular-states", "0", "--wide-states", "2", "--timeout", "60"];
        let check = ["check", "CARTESIAN", "--python", "my_elements:without_arm"];
        all.push((owned(&[&check[..], &few].concat()), 8));
    }
    all
}

#[test]
fn every_heading_key_and_verdict_of_the_reports_is_explained() {
    let folder = folder("words");
    let (mut all, mut lacking) = (BTreeSet::new(), Vec::new());
    for (command, least) in commands(&folder) {
        let arguments: Vec<&str> = command.iter().map(String::as_str).collect();
        let mut run = pintle(&arguments);
        run.current_dir(&folder).env("CLICOLOR_FORCE", "1").env("COLUMNS", "200");
        let assert = run.assert();
        assert!(matches!(assert.get_output().status.code(), Some(0 | 1)), "{command:?}: {}", stderr(&assert));
        let text = stdout(&assert);
        // The heading of a deck, and the machine of a bench, are no words of a report.
        let is_headed = ["eval", "bench"].contains(&arguments[0]);
        let found =
            words(if is_headed { text.split_once("\n\n").map_or("", |(_, rest)| rest) } else { &text });
        assert!(found.len() >= least, "{command:?} prints {} words: {:?}", found.len(), found.keys());
        let others = found.iter().filter(|(word, _)| !all.contains(*word));
        let is_known = |word: &str| match word.contains(['∂', '[']) {
            true => !glossary::of(word).is_empty(),
            false => !glossary::exactly(word).is_empty(),
        };
        let none = others.filter(|(word, _)| !is_known(word));
        lacking.extend(none.map(|(word, line)| format!("{command:?}: {word:?} of: {line}")));
        all.extend(found.into_keys());
    }
    assert!(
        lacking.is_empty(),
        "words without a meaning in docs/reference (words.md, solution.md):\n{}",
        lacking.join("\n")
    );
    assert!(all.len() > 200, "{} words", all.len());
    let events: Vec<&str> =
        What::ALL.map(What::name).into_iter().filter(|name| !all.contains(*name)).collect();
    assert!(events.is_empty(), "no report has {events:?}");
    // What readers asked for in vain.
    let of_check = has_python().then_some("error/tolerance");
    let others = ["specialised rot.", "or. a/b", "difference/allowed", "δ seen", "digest", "κ", "balance"];
    for word in others.into_iter().chain(of_check) {
        assert!(all.contains(word), "{word} is not printed: {all:?}");
    }
}

/// The lists of the code: what is added to one of them is asked for.
#[test]
fn every_oracle_law_quantity_verdict_event_and_output_is_explained() {
    let quantities = || Quantity::ALL.into_iter().chain(Quantity::OF_BEHAVIOR);
    let mut names: Vec<&str> = Oracle::ALL.map(Oracle::name).to_vec();
    names.extend(Invariant::ALL.map(Invariant::name));
    names.extend(quantities().flat_map(|quantity| [quantity.name(), quantity.symbol()]));
    names.extend(Verdict::ALL.map(Verdict::name));
    names.extend(What::ALL.map(What::name));
    names.extend(Output::ALL.map(Output::name));
    names.extend(DOF);
    for entry in &mpc::TABLE {
        names.extend(entry.angles);
        let rows = entry.kind.rows(true);
        names.extend((0..rows.len()).filter(|row| rows[*row]).map(|row| entry.kind.row_name(row)));
    }
    let lacking: Vec<&&str> = names.iter().filter(|name| glossary::exactly(name).is_empty()).collect();
    assert!(lacking.is_empty(), "without a meaning in the reference pages: {lacking:?}");
    assert!(names.len() > 120, "{}", names.len());
}

/// Where a word has several meanings each is printed, with where it stands; a word of several needs no quotes.
#[test]
fn each_meaning_says_where_it_stands() {
    let places = [
        ("rows", vec!["Solutions", "Evaluation", "JSON and other files: Keys"]),
        ("differs", vec!["Check and compare", "JSON and other files: Keys"]),
        ("error", vec!["Solutions", "Words of the model", "and its JSON: JSON", "answers"]),
        ("tie", vec!["MPC TIE", "Solutions"]),
        ("frame", vec!["many states"]),
    ];
    for (word, places) in places {
        let page = stdout(&pintle(&["explain", word]).assert().success());
        for place in places {
            assert!(page.contains(place), "{word} of {place:?}: {page}");
        }
    }
    let page = stdout(&pintle(&["explain", "assembly", "equals", "its", "halves"]).assert().success());
    assert!(page.contains("two basic types"), "{page}");
    assert!(stdout(&pintle(&["explain", "∂m1/∂ur1"]).assert().success()).contains("the moment of ur1"));
    pintle(&["explain", "no", "such", "word"]).assert().code(2);
}
