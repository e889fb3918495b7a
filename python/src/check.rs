//! A Python callable behind the protocol: its questions are asked in the thread of the caller, while another judges.

use crate::report::Report;
use crate::work;
use pintle::audit::Settings;
use pintle::check::{Asked, At, Door, Misbehaviour};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pythonize::{depythonize, pythonize};
use serde_json::{Map, Value};
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

/// How often a signal, such as that of Ctrl-C, is looked for while nothing is asked.
const LOOK: Duration = Duration::from_millis(100);

/// The end of the judge: messages go to the thread of the caller, and come back.
struct Messages {
    to: Sender<Value>,
    from: Receiver<Value>,
}

impl Door for Messages {
    fn send(&mut self, message: &Value, _: &[u8], due: &'static str) -> Result<(), Misbehaviour> {
        self.to.send(message.clone()).map_err(|_| Misbehaviour::ClosedInput(due))
    }

    fn receive(&mut self, due: &'static str) -> Result<Map<String, Value>, Misbehaviour> {
        match self.from.recv() {
            Ok(Value::Object(answer)) => Ok(answer),
            Ok(other) => Err(Misbehaviour::NoMessage { due, what: other.to_string() }),
            Err(_) => Err(Misbehaviour::ClosedOutput(due)),
        }
    }

    fn bytes(&mut self, due: &'static str) -> Result<Vec<u8>, Misbehaviour> {
        Err(Misbehaviour::NoMessage { due, what: "bytes".into() })
    }

    fn close(self) -> Result<(), Misbehaviour> {
        Ok(())
    }
}

/// Asks `reply`, which answers the messages of pintle-candidate/1, to be what `of` names, and judges its answers.
///
/// # Errors
/// ValueError in words, where the connector is none or the answers are not those of the protocol; what `reply` raises.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "keywords of Python")]
#[pyo3(signature = (reply, of, *, states, near_singular_states, wide_states, histories, springs=[None; 6], seed, at=None, independent=false))]
pub(crate) fn ask(
    reply: &Bound<'_, PyAny>,
    of: &str,
    states: usize,
    near_singular_states: usize,
    wide_states: usize,
    histories: usize,
    springs: [Option<f64>; 6],
    seed: String,
    at: Option<PathBuf>,
    independent: bool,
) -> PyResult<Report> {
    let py = reply.py();
    let at = at.as_deref().map(|file| At { file, independent });
    let subject = pintle::check::subject(of, at).map_err(PyValueError::new_err)?;
    let settings =
        Settings { states, near_singular_states, wide_states, seed, atlas: false, ..Settings::default() };
    let (to, mut asked) = channel();
    let (answers, from) = channel();
    let asked_of =
        Asked { settings, histories, convention: None, springs, domain: None, simplest: true, among: None };
    let judge = || pintle::check::check(Messages { to, from }, &subject, asked_of);
    let answer = move || loop {
        let questions = &mut asked;
        match py.detach(move || questions.recv_timeout(LOOK)) {
            Ok(question) => {
                let answer = reply.call1((pythonize(py, &question)?,))?;
                if !answer.is_none() && answers.send(depythonize(&answer)?).is_err() {
                    return Ok(());
                }
            }
            Err(RecvTimeoutError::Timeout) => py.check_signals()?,
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
    };
    match work::beside(py, judge, answer)? {
        Ok(checked) => Ok(Report::of_check(checked)),
        Err(misbehaviour) => {
            Err(PyValueError::new_err(misbehaviour.to_string().replace("the process", "the routine")))
        }
    }
}
