//! What a door costs: the time of a state between question and answer, of a routine that does next to nothing.
//!
//! It counts all that is not judging: messages made, sent, read and answered. Routines are right, and their numbers are compared.

#![expect(clippy::expect_used, reason = "a benchmark fails by panicking")]

use pintle_audit::{Question, Step};
use pintle_check::{Patience, Process, Session, python_command};
use pintle_kinematics::catalog::ConnectionType;
use pintle_kinematics::connector::Definition;
use pintle_kinematics::node::{Node, Pair};
use pintle_kinematics::so3::exp;
use pintle_kinematics::vector::identity;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

const STATES: usize = 32;
const ROUNDS: usize = 60;

const PYTHON: &str = "
nothing = [None] * 5
def axial(state, connector):
    d = state['b']['x'] - state['a']['x']
    length = float(d @ d) ** 0.5
    q = d / length
    return [length - 2.0, *nothing], [[*-q, 0, 0, 0, 0, *q, 0, 0, 0, 0], *nothing]
";

const C: &str = "
#include \"pintle_element.h\"
#include <math.h>
const unsigned pintle_offers = PINTLE_VALUES | PINTLE_ROWS;
#ifdef TEXT
const int pintle_svars = 1;
#endif
int pintle_element(const pintle_connector *connector, const pintle_state *state, unsigned want, double *svars,
                   pintle_numbers *numbers) {
    double d[3], length = 0, *row = numbers->rows[0];
    for (int i = 0; i < 3; i++) { d[i] = state->b.x[i] - state->a.x[i]; length += d[i] * d[i]; }
    length = sqrt(length);
    numbers->values[0] = length - 2;
    for (int j = 0; j < 14; j++) row[j] = 0;
    for (int i = 0; i < 3; i++) { row[i] = -d[i] / length; row[7 + i] = d[i] / length; }
    return 0;
}
";

/// The time of a state (µs), the shortest of the rounds and their median.
fn cost(command: &str, definition: &Definition) -> Result<[f64; 2], String> {
    let in_words = |error: pintle_check::Misbehaviour| error.to_string();
    let process = Process::start(command, Patience::default()).map_err(in_words)?;
    let mut session = Session::open(process, definition, None, &[None; 6]).map_err(in_words)?;
    let states: Vec<Step> = (0..STATES)
        .map(|n| {
            let b = Node { displacement: [0.1 * n as f64, 0.2, 0.0], ..definition.initial.b };
            let a = Node { triad: exp([0.01 * n as f64, 0.1, 0.0]), ..definition.initial.a };
            Step::between(&definition.initial, Pair { a, b, ..definition.initial })
        })
        .collect();
    let wants = session.offers().to_vec();
    let mut times = Vec::new();
    for _ in 0..ROUNDS {
        let questions: Vec<Question<'_>> = states
            .iter()
            .enumerate()
            .map(|(number, step)| Question {
                number,
                step,
                path: &[],
                values_before: [Some(0.0), None, None, None, None, None],
                wants: &wants,
                is_drawn: false,
            })
            .collect();
        let start = Instant::now();
        let given = session.ask(&questions).map_err(in_words)?;
        times.push(start.elapsed().as_secs_f64() * 1e6 / STATES as f64);
        assert_eq!(given.iter().flatten().count(), STATES);
    }
    session.close().map_err(in_words)?;
    times.sort_by(f64::total_cmp);
    Ok([times[0], times[ROUNDS / 2]])
}

fn main() {
    let folder = std::env::temp_dir().join(format!("pintle-door-{}", std::process::id()));
    fs::create_dir_all(&folder).expect("a folder");
    fs::write(folder.join("mine.py"), PYTHON).expect("a routine");
    fs::write(folder.join("remembers.py"), format!("MEMORY = True\n{PYTHON}")).expect("a routine");
    fs::write(folder.join("mine.c"), C).expect("a routine");
    fs::write(folder.join("pintle_element.h"), pintle_element::HEADER).expect("the header");
    std::env::set_current_dir(&folder).expect("the folder");
    let node = Node { displacement: [0.0; 3], triad: identity(), flow: 0.0 };
    let axial = ConnectionType::named("AXIAL", None).expect("a type");
    let definition = Definition::new(axial, Pair { reference: [2.0, 0.0, 0.0], a: node, b: node });
    let program = Path::new(env!("CARGO_BIN_EXE_pintle")).display().to_string();
    let library = |name: &str, more: &[&str]| {
        let built = Command::new("cc")
            .args(["-shared", "-fPIC", "-O2", "-o", name, "mine.c", "-lm"])
            .args(more)
            .status();
        assert!(built.is_ok_and(|status| status.success()), "cc builds {name}");
        format!("exec {program} element ./{name}")
    };
    let doors = [
        ("Python, bytes", python_command("python3", "mine:axial").expect("a name")),
        ("Python, text (with a memory)", python_command("python3", "remembers:axial").expect("a name")),
        ("C, bytes", library("bytes.so", &[])),
        ("C, text (with svars)", library("text.so", &["-DTEXT"])),
    ];
    println!("µs a state of {STATES}, {ROUNDS} rounds      shortest  median");
    for (name, command) in doors {
        match cost(&command, &definition) {
            Ok([shortest, median]) => println!("{name:<32} {shortest:>10.1}  {median:>6.1}"),
            Err(why) => println!("{name:<32} {why}"),
        }
    }
    fs::remove_dir_all(&folder).ok();
}
