//! A process that answers: started, asked with a time limit, and ended whatever it does.

use crate::kin::Kin;
use crate::protocol::{self, PROTOCOL};
use serde_json::{Map, Value};
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

/// What carries messages to a routine and back: nothing of the protocol is known to it.
pub trait Door {
    /// Sends one message, and bytes after it. `due` says what for, in a sentence: "the process ended when it was to …".
    ///
    /// # Errors
    /// [`Misbehaviour`].
    fn send(&mut self, message: &Value, bytes: &[u8], due: &'static str) -> Result<(), Misbehaviour>;

    /// The next message.
    ///
    /// # Errors
    /// [`Misbehaviour`].
    fn receive(&mut self, due: &'static str) -> Result<Map<String, Value>, Misbehaviour>;

    /// The bytes that the message received announced.
    ///
    /// # Errors
    /// [`Misbehaviour`].
    fn bytes(&mut self, due: &'static str) -> Result<Vec<u8>, Misbehaviour>;

    /// That nothing came which was not asked for.
    ///
    /// # Errors
    /// [`Misbehaviour::Unasked`].
    fn is_silent(&mut self) -> Result<(), Misbehaviour> {
        Ok(())
    }

    /// Another one like it, where this one has ended; `None` where there is none.
    ///
    /// # Errors
    /// [`Misbehaviour::NotStarted`].
    fn again(&self) -> Result<Option<Self>, Misbehaviour>
    where
        Self: Sized,
    {
        Ok(None)
    }

    /// After the last message.
    ///
    /// # Errors
    /// [`Misbehaviour`].
    fn close(self) -> Result<(), Misbehaviour>;
}

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

/// The longest line that is read: second derivatives at 32 states take a megabyte or two.
const LONGEST: u64 = 1 << 24;

/// Lines that may wait to be read: one answer, and what must not be there.
const WAITING: usize = 16;

/// What a process did that the protocol does not allow.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
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
    /// The same at a state.
    #[error("{why}, at state {number}")]
    AtState {
        /// The state.
        number: usize,
        /// What it did.
        why: Box<Self>,
    },
    /// The same, or no answer in time, at one of several states.
    #[error("{why}, at one of the states {first} to {last}")]
    Among {
        /// The first of them.
        first: usize,
        /// The last.
        last: usize,
        /// What it did.
        why: Box<Self>,
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
    #[error("the process wrote a line longer than 16 MB when it was to {0}")]
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
    /// Its numbers are those of no convention.
    #[error("no convention was found: {0}")]
    NoConvention(String),
    /// It offers nothing.
    #[error("the process offers nothing: \"offers\" is to name values, rows or more")]
    OffersNothing,
    /// It did not open the connector.
    #[error("the process cannot be this connector: {0}")]
    Refused(String),
    /// It failed at what it was told besides states.
    #[error("the process did not {due}: {why}")]
    NotDone {
        /// What it was told.
        due: &'static str,
        /// What it said.
        why: String,
    },
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
    /// A step that was taken back leaves something behind.
    #[error(
        "at state {number}, step {step} of its history, the process gave another answer when the step was taken back and taken again, \
         with other steps tried and taken back in between: what is tried and reverted must not change its memory"
    )]
    NotReverted {
        /// The state.
        number: usize,
        /// The step that leads to it, from 1 on.
        step: usize,
    },
    /// It goes on after the end.
    #[error("the process did not end within {0:?} after it was closed, and was ended")]
    StayedOn(Duration),
    /// It ends with an error.
    #[error("the process ended with {0} after it was closed")]
    BadEnd(String),
}

impl Misbehaviour {
    /// Whether the process has ended.
    pub(crate) const fn is_an_end(&self) -> bool {
        matches!(self, Self::Died { .. } | Self::HalfALine(_))
    }

    /// The same, at states of these numbers where it is about any.
    pub(crate) fn at(self, first: usize, last: usize) -> Self {
        match self {
            Self::Died { .. } | Self::HalfALine(_) | Self::Silent { .. } => {
                let why = Box::new(self);
                if first == last {
                    Self::AtState { number: first, why }
                } else {
                    Self::Among { first, last, why }
                }
            }
            other => other,
        }
    }
}

/// What comes from the process.
enum Line {
    Text(String),
    Bytes(Vec<u8>),
    Flood,
    NotText,
    Half,
}

/// A process that was started. Dropped, it is ended with all that it started.
#[derive(Debug)]
pub struct Process {
    command: String,
    child: Child,
    input: Option<ChildStdin>,
    lines: Receiver<LineOrEnd>,
    patience: Patience,
    kin: Kin,
}

type LineOrEnd = Option<Line>;

impl std::fmt::Debug for Line {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Text(text) => text,
            Self::Bytes(_) => "bytes",
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
        let follow = match &found {
            Some(Line::Text(line)) => protocol::bytes_after(line),
            _ => None,
        };
        if to.send(found).is_err() || is_last {
            return;
        }
        let Some(count) = follow else { continue };
        let mut bytes = Vec::new();
        let taken = reader.by_ref().take(count.min(LONGEST)).read_to_end(&mut bytes);
        let found = match taken {
            Ok(taken) if taken as u64 == count => Line::Bytes(bytes),
            Ok(taken) if taken as u64 == LONGEST => Line::Flood,
            _ => Line::Half,
        };
        let is_last = !matches!(found, Line::Bytes(_));
        if to.send(Some(found)).is_err() || is_last {
            return;
        }
    }
}

fn in_words(status: Option<ExitStatus>) -> String {
    status.map_or_else(|| "of what, is not known".to_string(), |status| status.to_string())
}

impl Process {
    /// Starts a command in a shell.
    ///
    /// # Errors
    /// [`Misbehaviour::NotStarted`].
    pub fn start(command: &str, patience: Patience) -> Result<Self, Misbehaviour> {
        let mut shell = Command::new("sh");
        shell.arg("-c").arg(command).stdin(Stdio::piped()).stdout(Stdio::piped());
        // In a group of its own, so that all that it starts can be ended with it.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut shell, 0);
        let mut kin = Kin::mark(&mut shell);
        let mut child = shell.spawn().map_err(|error| Misbehaviour::NotStarted(error.to_string()))?;
        let (to, lines) = sync_channel(WAITING);
        if let Some(output) = child.stdout.take() {
            #[cfg(unix)]
            kin.write_to(std::os::fd::AsRawFd::as_raw_fd(&output), child.id());
            thread::spawn(move || read(output, &to));
        }
        let input = child.stdin.take();
        Ok(Self { command: command.to_string(), child, input, lines, patience, kin })
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

    /// What it wrote, of that kind.
    fn next<T>(
        &mut self,
        due: &'static str,
        take: impl FnOnce(Line) -> Result<T, Misbehaviour>,
    ) -> Result<T, Misbehaviour> {
        match self.lines.recv_timeout(self.patience.answer) {
            Ok(Some(Line::Flood)) => Err(Misbehaviour::Flood(due)),
            Ok(Some(Line::NotText)) => Err(Misbehaviour::NotText(due)),
            Ok(Some(Line::Half)) => Err(Misbehaviour::HalfALine(due)),
            Ok(Some(line)) => take(line),
            Ok(None) | Err(RecvTimeoutError::Disconnected) => {
                Err(self.ended(due).unwrap_or(Misbehaviour::ClosedOutput(due)))
            }
            Err(RecvTimeoutError::Timeout) if self.kin.is_mute() => Err(Misbehaviour::ClosedOutput(due)),
            Err(RecvTimeoutError::Timeout) => Err(Misbehaviour::Silent { due, limit: self.patience.answer }),
        }
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
}

impl Door for Process {
    fn send(&mut self, message: &Value, bytes: &[u8], due: &'static str) -> Result<(), Misbehaviour> {
        let mut line = message.to_string().into_bytes();
        line.push(b'\n');
        line.extend_from_slice(bytes);
        let sent = self.input.as_mut().map(|input| input.write_all(&line).and_then(|()| input.flush()));
        match sent {
            Some(Ok(())) => Ok(()),
            _ => Err(self.ended(due).unwrap_or(Misbehaviour::ClosedInput(due))),
        }
    }

    fn receive(&mut self, due: &'static str) -> Result<Map<String, Value>, Misbehaviour> {
        self.next(due, |line| match line {
            Line::Text(line) => protocol::object(&line).map_err(|what| Misbehaviour::NoMessage { due, what }),
            _ => Err(Misbehaviour::NoMessage { due, what: "bytes".into() }),
        })
    }

    fn bytes(&mut self, due: &'static str) -> Result<Vec<u8>, Misbehaviour> {
        self.next(due, |line| match line {
            Line::Bytes(bytes) => Ok(bytes),
            _ => Err(Misbehaviour::HalfALine(due)),
        })
    }

    fn is_silent(&mut self) -> Result<(), Misbehaviour> {
        match self.lines.try_recv() {
            Ok(Some(Line::Text(line))) => {
                Err(Misbehaviour::Unasked { what: format!("{:?}", protocol::excerpt(&line)) })
            }
            Ok(Some(Line::Flood)) => Err(Misbehaviour::Flood("answer")),
            _ => Ok(()),
        }
    }

    fn again(&self) -> Result<Option<Self>, Misbehaviour> {
        Self::start(&self.command, self.patience).map(Some)
    }

    fn close(mut self) -> Result<(), Misbehaviour> {
        self.input = None;
        let limit = self.patience.close;
        let Some(status) = self.wait(limit) else { return Err(Misbehaviour::StayedOn(limit)) };
        if let Ok(Some(Line::Text(line))) = self.lines.try_recv() {
            return Err(Misbehaviour::Unasked { what: format!("{:?}", protocol::excerpt(&line)) });
        }
        if status.success() { Ok(()) } else { Err(Misbehaviour::BadEnd(in_words(Some(status)))) }
    }
}

impl Drop for Process {
    /// Ends the process and all that it started.
    fn drop(&mut self) {
        self.input = None;
        #[cfg(unix)]
        let _ = Command::new("kill")
            .args(["-KILL", "--", &format!("-{}", self.child.id())])
            .stderr(Stdio::null())
            .status();
        self.kin.end();
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
