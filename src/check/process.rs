//! A process that answers: started, asked with a time limit, and ended whatever it does.

use crate::protocol::{self, Answer, Hello, Offer, PROTOCOL};
use pintle_audit::{Given, Question};
use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::connector::{Connector, Definition, State};
use serde_json::{Map, Value};
use std::fmt::Write as _;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

/// How long a process may take.
#[derive(Clone, Copy, Debug)]
pub struct Patience {
    /// For one answer.
    pub answer: Duration,
    /// To end after it was asked to.
    pub close: Duration,
}

impl Default for Patience {
    fn default() -> Self {
        Self { answer: Duration::from_secs(10), close: Duration::from_secs(2) }
    }
}

/// The longest line that is read: an answer has some kilobytes.
const LONGEST: u64 = 1 << 20;

/// Lines that may wait to be read: one answer, and what must not be there.
const WAITING: usize = 16;

/// What a process did that the protocol does not allow.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Misbehaviour {
    /// There is no such program.
    #[error("the command cannot be started: {0}")]
    NotStarted(String),
    /// It ended before it was asked to.
    #[error("the process ended ({how}) when it was to {due}")]
    Died {
        /// Its exit code or signal.
        how: String,
        /// What it was asked for.
        due: &'static str,
    },
    /// It did not answer in time.
    #[error("the process did not {due} within {limit:?}; --timeout allows more")]
    Silent {
        /// What it was asked for.
        due: &'static str,
        /// The limit.
        limit: Duration,
    },
    /// It closed its output and went on.
    #[error("the process closed its standard output when it was to {0}, and did not end")]
    ClosedOutput(&'static str),
    /// It no longer reads.
    #[error("the process closed its standard input before it was asked to {0}")]
    ClosedInput(&'static str),
    /// A line without end.
    #[error("the process wrote a line longer than 1 MB when it was to {0}")]
    Flood(&'static str),
    /// Bytes that are no text.
    #[error("the process wrote a line that is no UTF-8 when it was to {0}")]
    NotText(&'static str),
    /// The last line has no end.
    #[error("the process ended in the middle of a line when it was to {0}")]
    HalfALine(&'static str),
    /// A line that is no message: whatever else it prints belongs on standard error.
    #[error(
        "the process wrote a line that is no message when it was to {due}: {what}; what it prints besides belongs on stderr"
    )]
    NoMessage {
        /// What it was asked for.
        due: &'static str,
        /// What it wrote.
        what: String,
    },
    /// A greeting of another protocol, or with keys that it has not.
    #[error("the hello of the process is none of {PROTOCOL}: {0}")]
    BadHello(String),
    /// A convention that is none.
    #[error("the hello of the process has no valid convention: {0}")]
    BadConvention(String),
    /// It offers nothing.
    #[error("the process offers nothing: \"offers\" is to name values, rows or both")]
    OffersNothing,
    /// It did not open the connector.
    #[error("the process cannot be this connector: {0}")]
    Refused(String),
    /// An answer to another question.
    #[error("the process answered id {got}, and was asked id {asked}")]
    WrongId {
        /// What it answered.
        got: String,
        /// What it was asked.
        asked: u64,
    },
    /// A second answer to an earlier question.
    #[error("the process answered id {got} a second time, or late, when it was asked id {asked}")]
    Again {
        /// What it answered.
        got: u64,
        /// What it was asked.
        asked: u64,
    },
    /// An answer too many.
    #[error(
        "the process wrote {what} though nothing was asked: a second answer, or a line that belongs on stderr"
    )]
    Unasked {
        /// What it wrote.
        what: String,
    },
    /// An answer of the wrong shape.
    #[error("the answer to id {id} has the wrong shape: {what}")]
    WrongShape {
        /// What it was asked.
        id: u64,
        /// What is wrong with it.
        what: String,
    },
    /// The routine failed at a state.
    #[error(
        "the routine failed at a state (id {id}): {why}; a state that it does not cover is to be answered by out_of_domain"
    )]
    Failed {
        /// What it was asked.
        id: u64,
        /// What it said.
        why: String,
    },
    /// It gives another answer to the same question.
    #[error(
        "asked for the first state again, the process gave another answer: it keeps something from state to state"
    )]
    Changed,
    /// It goes on after the end.
    #[error("the process did not end within {0:?} after it was closed, and was ended")]
    StayedOn(Duration),
    /// It ends with an error.
    #[error("the process ended with {0} after it was closed")]
    BadEnd(String),
}

/// What comes from the process.
enum Line {
    Text(String),
    Flood,
    NotText,
    Half,
}

/// A process that was greeted and opened. Dropped, it is ended with all that it started.
#[derive(Debug)]
pub struct Session<'a> {
    definition: &'a Definition,
    connector: Connector<f64>,
    child: Child,
    input: Option<ChildStdin>,
    lines: Receiver<LineOrEnd>,
    patience: Patience,
    hello: Hello,
    places: Vec<usize>,
    asked: u64,
    first: Option<(State<f64>, Option<State<f64>>, Answer)>,
}

type LineOrEnd = Option<Line>;

impl std::fmt::Debug for Line {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Text(text) => text,
            Self::Flood => "a flood",
            Self::NotText => "no text",
            Self::Half => "half a line",
        })
    }
}

/// Reads lines until the end, none of them without limit.
fn read(output: impl Read, to: &SyncSender<LineOrEnd>) {
    let mut reader = BufReader::new(output);
    loop {
        let mut line = Vec::new();
        let count = reader.by_ref().take(LONGEST).read_until(b'\n', &mut line);
        let found = match count {
            Err(_) | Ok(0) => None,
            Ok(_) if line.last() == Some(&b'\n') => Some(
                String::from_utf8(line).map_or(Line::NotText, |text| Line::Text(text.trim_end().to_string())),
            ),
            Ok(count) if count as u64 == LONGEST => Some(Line::Flood),
            Ok(_) => Some(Line::Half),
        };
        let is_last = !matches!(found, Some(Line::Text(_) | Line::NotText));
        if to.send(found).is_err() || is_last {
            return;
        }
    }
}

fn in_words(status: Option<ExitStatus>) -> String {
    status.map_or_else(|| "of what, is not known".to_string(), |status| status.to_string())
}

impl<'a> Session<'a> {
    /// Starts a command in a shell, greets it, and opens the connector.
    ///
    /// # Errors
    /// [`Misbehaviour`].
    pub fn start(
        command: &str,
        definition: &'a Definition,
        patience: Patience,
    ) -> Result<Self, Misbehaviour> {
        let mut shell = Command::new("sh");
        shell.arg("-c").arg(command).stdin(Stdio::piped()).stdout(Stdio::piped());
        // In a group of its own, so that all that it starts can be ended with it.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut shell, 0);
        let mut child = shell.spawn().map_err(|error| Misbehaviour::NotStarted(error.to_string()))?;
        let (to, lines) = sync_channel(WAITING);
        if let Some(output) = child.stdout.take() {
            thread::spawn(move || read(output, &to));
        }
        let input = child.stdin.take();
        let mut session = Self {
            definition,
            connector: Connector::new(definition),
            child,
            input,
            lines,
            patience,
            hello: Hello::default(),
            places: Vec::new(),
            asked: 0,
            first: None,
        };
        session.greet()?;
        Ok(session)
    }

    /// The name that the routine gave itself.
    pub fn name(&self) -> &str {
        &self.hello.name
    }

    /// Whether it offers values, and rows, and which components.
    pub fn offers(&self) -> (bool, bool, [bool; 6]) {
        let offers = |what| self.hello.offers.contains(&what);
        let has = |name: &str| {
            self.hello.components.as_ref().is_none_or(|names| names.iter().any(|known| known == name))
        };
        (offers(Offer::Values), offers(Offer::Rows), COMPONENT.map(has))
    }

    /// What the connector has and the routine does not offer.
    pub fn not_offered(&self) -> Vec<&'static str> {
        let (values, rows, components) = self.offers();
        let mut names = Vec::new();
        names.extend((!values).then_some("values"));
        names.extend((!rows).then_some("rows"));
        let has = |k: &usize| self.connector.differentiated(*k).is_some() && !components[*k];
        names.extend((0..6).filter(has).map(|k| COMPONENT[k]));
        names
    }

    /// How often it was asked.
    pub const fn asked(&self) -> u64 {
        self.asked
    }

    fn greet(&mut self) -> Result<(), Misbehaviour> {
        const DUE: &str = "say hello";
        const OPEN: &str = "open the connector";
        self.send(&protocol::hello(), DUE)?;
        let mut answer = self.receive(DUE)?;
        let hello = answer.remove("hello").ok_or_else(|| {
            Misbehaviour::BadHello(format!(
                "it has no \"hello\", but {}",
                protocol::excerpt(&Value::Object(answer).to_string())
            ))
        })?;
        let spoken = hello.get("protocol").and_then(Value::as_str).unwrap_or("none");
        if spoken != PROTOCOL {
            return Err(Misbehaviour::BadHello(format!("its protocol is {spoken:?}")));
        }
        self.hello =
            serde_json::from_value(hello).map_err(|error| Misbehaviour::BadHello(error.to_string()))?;
        self.places = self.hello.convention.places().map_err(Misbehaviour::BadConvention)?;
        let unknown = |name: &&String| !COMPONENT.contains(&name.as_str());
        if let Some(name) = self.hello.components.iter().flatten().find(unknown) {
            let names = COMPONENT.join(", ");
            return Err(Misbehaviour::BadHello(format!("its components name {name:?}; there are {names}")));
        }
        if self.hello.offers.is_empty() {
            return Err(Misbehaviour::OffersNothing);
        }
        self.send(&protocol::open(self.definition, &self.hello.convention), OPEN)?;
        let answer = self.receive(OPEN)?;
        if let Some(why) = answer.get("error") {
            return Err(Misbehaviour::Refused(protocol::excerpt(&why.to_string())));
        }
        if answer.get("opened") != Some(&Value::Bool(true)) {
            let what = protocol::excerpt(&Value::Object(answer).to_string());
            return Err(Misbehaviour::NoMessage {
                due: OPEN,
                what: format!("{what} is not {{\"opened\": true}}"),
            });
        }
        Ok(())
    }

    fn send(&mut self, message: &Value, due: &'static str) -> Result<(), Misbehaviour> {
        let mut line = message.to_string();
        line.push('\n');
        let sent =
            self.input.as_mut().map(|input| input.write_all(line.as_bytes()).and_then(|()| input.flush()));
        match sent {
            Some(Ok(())) => Ok(()),
            _ => Err(self.ended(due).unwrap_or(Misbehaviour::ClosedInput(due))),
        }
    }

    /// That the process has ended, if it does so now.
    fn ended(&mut self, due: &'static str) -> Option<Misbehaviour> {
        let how = self.wait(Duration::from_millis(200))?;
        // A shell that finds no program says so by this code.
        if how.code() == Some(127) {
            return Some(Misbehaviour::NotStarted(
                "the shell finds no such program (exit code 127)".to_string(),
            ));
        }
        Some(Misbehaviour::Died { how: in_words(Some(how)), due })
    }

    fn wait(&mut self, limit: Duration) -> Option<ExitStatus> {
        let until = Instant::now() + limit;
        loop {
            match self.child.try_wait() {
                Ok(Some(status)) => return Some(status),
                Ok(None) if Instant::now() < until => thread::sleep(Duration::from_millis(2)),
                _ => return None,
            }
        }
    }

    fn receive(&mut self, due: &'static str) -> Result<Map<String, Value>, Misbehaviour> {
        match self.lines.recv_timeout(self.patience.answer) {
            Ok(Some(Line::Text(line))) => {
                protocol::object(&line).map_err(|what| Misbehaviour::NoMessage { due, what })
            }
            Ok(Some(Line::Flood)) => Err(Misbehaviour::Flood(due)),
            Ok(Some(Line::NotText)) => Err(Misbehaviour::NotText(due)),
            Ok(Some(Line::Half)) => Err(Misbehaviour::HalfALine(due)),
            Ok(None) | Err(RecvTimeoutError::Disconnected) => {
                Err(self.ended(due).unwrap_or(Misbehaviour::ClosedOutput(due)))
            }
            Err(RecvTimeoutError::Timeout) => Err(Misbehaviour::Silent { due, limit: self.patience.answer }),
        }
    }

    /// Asks for one state.
    ///
    /// # Errors
    /// [`Misbehaviour`].
    pub fn ask(&mut self, asked: &Question<'_>) -> Result<Option<Given>, Misbehaviour> {
        let answer = self.answer(asked)?;
        if self.first.is_none() && asked.is_drawn {
            self.first = Some((*asked.state, asked.before.copied(), answer.clone()));
        }
        match answer {
            Answer::OutOfDomain(_) => Ok(None),
            Answer::Error(why) => Err(Misbehaviour::Failed { id: self.asked, why }),
            Answer::Given(own) => {
                let of = (self.definition, &self.connector);
                let (mut values, mut rows) = own.read(&self.hello.convention, &self.places, of, asked.state);
                let offered = self.offers();
                for k in 0..6 {
                    values[k] = values[k].filter(|_| offered.0 && offered.2[k]);
                    rows[k] = rows[k].filter(|_| offered.1 && offered.2[k]);
                }
                Ok(Some((values, rows)))
            }
        }
    }

    fn answer(&mut self, asked: &Question<'_>) -> Result<Answer, Misbehaviour> {
        const DUE: &str = "answer";
        // What is there before the question is no answer to it.
        match self.lines.try_recv() {
            Ok(Some(Line::Text(line))) => {
                return Err(Misbehaviour::Unasked { what: format!("{:?}", protocol::excerpt(&line)) });
            }
            Ok(Some(Line::Flood)) => return Err(Misbehaviour::Flood(DUE)),
            _ => {}
        }
        self.asked += 1;
        let id = self.asked;
        let wants_rows = asked.wants_rows && self.hello.offers.contains(&Offer::Rows);
        let asked = Question { wants_rows, ..*asked };
        self.send(&protocol::evaluate(id, &asked, self.definition, &self.hello.convention), DUE)?;
        let answer = self.receive(DUE)?;
        match answer.get("id") {
            Some(got) if got.as_u64() == Some(id) => {}
            Some(got) if got.as_u64().is_some_and(|got| got < id) => {
                return Err(Misbehaviour::Again { got: got.as_u64().unwrap_or_default(), asked: id });
            }
            got => {
                let got = got.map_or_else(|| "none".to_string(), ToString::to_string);
                return Err(Misbehaviour::WrongId { got: protocol::excerpt(&got), asked: id });
            }
        }
        protocol::answer(&answer, &self.hello.convention, wants_rows)
            .map_err(|what| Misbehaviour::WrongShape { id, what })
    }

    /// Asks for the first state once more: a routine has no memory but what it is given.
    ///
    /// # Errors
    /// [`Misbehaviour::Changed`], and what else may happen.
    pub fn ask_again(&mut self) -> Result<(), Misbehaviour> {
        let Some((state, before, first)) = self.first.take() else { return Ok(()) };
        let again = self.answer(&Question {
            state: &state,
            before: before.as_ref(),
            wants_rows: true,
            is_drawn: false,
        })?;
        // Bit for bit, NaN included.
        let text = |answer: &Answer| {
            let mut text = String::new();
            let _ = write!(text, "{answer:?}");
            text
        };
        if text(&first) == text(&again) { Ok(()) } else { Err(Misbehaviour::Changed) }
    }

    /// Says goodbye and waits for the end.
    ///
    /// # Errors
    /// [`Misbehaviour`].
    pub fn close(mut self) -> Result<(), Misbehaviour> {
        const DUE: &str = "end";
        self.send(&protocol::close(), DUE)?;
        self.input = None;
        let limit = self.patience.close;
        let Some(status) = self.wait(limit) else { return Err(Misbehaviour::StayedOn(limit)) };
        if let Ok(Some(Line::Text(line))) = self.lines.try_recv() {
            return Err(Misbehaviour::Unasked { what: format!("{:?}", protocol::excerpt(&line)) });
        }
        if status.success() { Ok(()) } else { Err(Misbehaviour::BadEnd(in_words(Some(status)))) }
    }
}

impl Drop for Session<'_> {
    /// Ends the process and all that it started.
    fn drop(&mut self) {
        self.input = None;
        #[cfg(unix)]
        let _ = Command::new("kill")
            .args(["-KILL", "--", &format!("-{}", self.child.id())])
            .stderr(Stdio::null())
            .status();
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
