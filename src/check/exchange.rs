//! Messages with a routine, whatever it is to be: hello, open, evaluate, close.

use crate::convention::{Convention, Own};
use crate::payload;
use crate::process::{Door, Misbehaviour};
use crate::protocol::{self, Answer, Hello, Layout, Offers, PROTOCOL};
use pintle_audit::{Domain, Quantity};
use serde_json::{Map, Value};

/// What a routine is to do with states.
const DUE: &str = "answer";
/// And at its begin.
const OPEN: &str = "open the connector";

/// What a routine says when it is greeted.
fn greeted(door: &mut impl Door) -> Result<Map<String, Value>, Misbehaviour> {
    const DUE: &str = "say hello";
    door.send(&protocol::hello(), &[], DUE)?;
    door.receive(DUE)
}

/// A routine that was greeted.
#[derive(Debug)]
pub(crate) struct Exchange<D> {
    door: D,
    pub(crate) hello: Hello,
    /// Which of the routine's components there are.
    pub(crate) present: Vec<bool>,
    asked: u64,
    /// The first question, and what came: asked again at the end, of a routine without memory.
    first: Option<(Vec<Quantity>, Value, Answer)>,
}

impl<D: Door> Exchange<D> {
    /// Greets a routine. A convention given here stands for that of its hello.
    ///
    /// # Errors
    /// [`Misbehaviour`].
    pub(crate) fn greet(mut door: D, convention: Option<&Convention>) -> Result<Self, Misbehaviour> {
        let mut answer = greeted(&mut door)?;
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
        let mut hello: Hello =
            serde_json::from_value(hello).map_err(|error| Misbehaviour::BadHello(error.to_string()))?;
        if hello.domain.is_everything() {
            hello.domain = hello.convention.domain.clone();
        }
        if let Some(convention) = convention {
            hello.convention = convention.clone();
            // What the user says of it stands before what the routine says.
            if !convention.domain.is_everything() {
                hello.domain = convention.domain.clone();
            }
        }
        Ok(Self { door, hello, present: Vec::new(), asked: 0, first: None })
    }

    /// As something else than a connector, which alone has bytes, steps that are taken back, and a domain.
    #[must_use]
    pub(crate) fn only_asked(mut self) -> Self {
        (self.hello.binary, self.hello.commits, self.hello.domain) = (false, false, Domain::default());
        self
    }

    /// What it offers, of what it may.
    ///
    /// # Errors
    /// [`Misbehaviour`].
    pub(crate) fn offers(&self, known: &Offers) -> Result<Vec<Quantity>, Misbehaviour> {
        let offers = self.hello.offers(known).map_err(Misbehaviour::BadHello)?;
        if offers.is_empty() { Err(Misbehaviour::OffersNothing) } else { Ok(offers) }
    }

    /// Says what the routine is to be.
    ///
    /// # Errors
    /// [`Misbehaviour::Refused`] where it says that it cannot be that, and what else may happen.
    pub(crate) fn open(&mut self, message: &Value) -> Result<(), Misbehaviour> {
        self.done(message, OPEN, "opened", Misbehaviour::Refused)
    }

    /// Opens what was opened before: to refuse it now is a failure.
    ///
    /// # Errors
    /// [`Misbehaviour`].
    pub(crate) fn open_again(&mut self, message: &Value) -> Result<(), Misbehaviour> {
        self.done(message, OPEN, "opened", |why| Misbehaviour::NotDone {
            due: "open the connector again",
            why,
        })
    }

    /// Starts, greets and opens the routine again, where it has ended; whether that can be done.
    ///
    /// # Errors
    /// [`Misbehaviour`].
    pub(crate) fn begin_again(&mut self, opening: &Value) -> Result<bool, Misbehaviour> {
        let Some(door) = self.door.again()? else { return Ok(false) };
        self.door = door;
        greeted(&mut self.door)?;
        self.open_again(opening)?;
        Ok(true)
    }

    /// Tells a routine that what was tried stands (`commit`), or not (`revert`).
    ///
    /// # Errors
    /// [`Misbehaviour`].
    pub(crate) fn tell(&mut self, word: &'static str, done: &'static str) -> Result<(), Misbehaviour> {
        self.done(&protocol::told(word), word, done, |why| Misbehaviour::NotDone { due: word, why })
    }

    /// Sends what is answered by `{done: true}`, or by an error.
    fn done(
        &mut self,
        message: &Value,
        due: &'static str,
        done: &'static str,
        failed: impl FnOnce(String) -> Misbehaviour,
    ) -> Result<(), Misbehaviour> {
        self.door.is_silent()?;
        self.door.send(message, &[], due)?;
        let answer = self.door.receive(due)?;
        if let Some(why) = answer.get("error") {
            return Err(failed(protocol::excerpt(&why.to_string())));
        }
        if answer.get(done) == Some(&Value::Bool(true)) {
            return Ok(());
        }
        let what = protocol::excerpt(&Value::Object(answer).to_string());
        Err(Misbehaviour::NoMessage { due, what: format!("{what} is not {{\"{done}\": true}}") })
    }

    /// How many requests it got.
    pub(crate) const fn asked(&self) -> u64 {
        self.asked
    }

    /// Asks at several states, as messages have them.
    ///
    /// # Errors
    /// [`Misbehaviour`].
    pub(crate) fn evaluate(
        &mut self,
        wants: &[Quantity],
        states: Vec<Value>,
        layout: &dyn Fn(Quantity) -> Layout,
    ) -> Result<Vec<Answer>, Misbehaviour> {
        let count = states.len();
        if self.hello.binary {
            return self.evaluate_bytes(wants, &states, layout);
        }
        let answer = self.request(wants, states)?;
        let id = self.asked;
        protocol::answers(&answer, layout, wants, count).map_err(|what| Misbehaviour::WrongShape { id, what })
    }

    /// The same, with states and answers as bytes.
    fn evaluate_bytes(
        &mut self,
        wants: &[Quantity],
        states: &[Value],
        layout: &dyn Fn(Quantity) -> Layout,
    ) -> Result<Vec<Answer>, Misbehaviour> {
        let (count, bytes) = (states.len(), payload::states(states));
        let of = |id| protocol::evaluate_bytes(id, wants, count, bytes.len());
        let answer = self.exchange(of, &bytes)?;
        let id = self.asked;
        let read = if answer.contains_key("bytes") {
            payload::answers(&self.door.bytes(DUE)?, layout, wants, (count, &self.present))
        } else {
            // What is no plain numbers is told in JSON.
            protocol::answers(&answer, layout, wants, count)
        };
        read.map_err(|what| Misbehaviour::WrongShape { id, what })
    }

    /// A request at several states, and the message with its number that answers it.
    ///
    /// # Errors
    /// [`Misbehaviour`].
    pub(crate) fn request(
        &mut self,
        wants: &[Quantity],
        states: Vec<Value>,
    ) -> Result<Map<String, Value>, Misbehaviour> {
        self.exchange(|id| protocol::evaluate(id, wants, states), &[])
    }

    /// Sends a message of a number, with bytes after it, and takes that which answers it.
    fn exchange(
        &mut self,
        message: impl FnOnce(u64) -> Value,
        bytes: &[u8],
    ) -> Result<Map<String, Value>, Misbehaviour> {
        // What is there before the question is no answer to it.
        self.door.is_silent()?;
        self.asked += 1;
        let id = self.asked;
        self.door.send(&message(id), bytes, DUE)?;
        let answer = self.door.receive(DUE)?;
        match answer.get("id") {
            Some(got) if got.as_u64() == Some(id) => Ok(answer),
            Some(got) if got.as_u64().is_some_and(|got| got < id) => {
                Err(Misbehaviour::Again { got: got.as_u64().unwrap_or_default(), asked: id })
            }
            got => {
                let got = got.map_or_else(|| "none".to_string(), ToString::to_string);
                Err(Misbehaviour::WrongId { got: protocol::excerpt(&got), asked: id })
            }
        }
    }

    /// The same of a routine without a memory, whose answers are what it gives; `None` at a state that it does not cover. The first
    /// state is kept, to be asked again.
    ///
    /// # Errors
    /// [`Misbehaviour`].
    pub(crate) fn answers(
        &mut self,
        wants: &[Quantity],
        states: Vec<Value>,
        layout: &dyn Fn(Quantity) -> Layout,
    ) -> Result<Vec<Option<Own>>, Misbehaviour> {
        let first = states.first().cloned();
        let answers = self.evaluate(wants, states, layout)?;
        if let (Some(state), Some(answer), None) = (first, answers.first(), &self.first) {
            self.first = Some((wants.to_vec(), state, answer.clone()));
        }
        let asked = self.asked;
        let given = answers.into_iter().map(|answer| match answer {
            Answer::Given(own) => Ok(Some(*own)),
            Answer::OutOfDomain(_) => Ok(None),
            Answer::Error(why) => Err(Misbehaviour::Failed { id: asked, why }),
        });
        given.collect()
    }

    /// Asks for the first state once more.
    ///
    /// # Errors
    /// [`Misbehaviour::Changed`], and what else may happen.
    pub(crate) fn ask_again(&mut self, layout: &dyn Fn(Quantity) -> Layout) -> Result<(), Misbehaviour> {
        let Some((wants, state, answer)) = self.first.take() else { return Ok(()) };
        let again = self.evaluate(&wants, vec![state], layout)?;
        let is_same = again.first().is_some_and(|again| again.is_same_as(&answer));
        if is_same { Ok(()) } else { Err(Misbehaviour::Changed) }
    }

    /// Says goodbye.
    ///
    /// # Errors
    /// [`Misbehaviour`].
    pub(crate) fn close(mut self) -> Result<(), Misbehaviour> {
        self.door.send(&protocol::close(), &[], "end")?;
        self.door.close()
    }
}
