//! A routine that was greeted and opened: asked through a door, its answers read in pintle's conventions.

use crate::convention::{Convention, Turns};
use crate::fit::GivenRows;
use crate::process::Misbehaviour;
use crate::protocol::{self, Answer, Hello, PROTOCOL};
use pintle_audit::{Given, Quantity, Question, Step, Tangent};
use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::connector::{Components, Connector, Definition};
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// What carries messages to a routine and back: nothing of the protocol is known to it.
pub trait Door {
    /// Sends one message. `due` says what for, in a sentence: "the process ended when it was to …".
    ///
    /// # Errors
    /// [`Misbehaviour`].
    fn send(&mut self, message: &Value, due: &'static str) -> Result<(), Misbehaviour>;

    /// The next message.
    ///
    /// # Errors
    /// [`Misbehaviour`].
    fn receive(&mut self, due: &'static str) -> Result<Map<String, Value>, Misbehaviour>;

    /// That nothing came which was not asked for.
    ///
    /// # Errors
    /// [`Misbehaviour::Unasked`].
    fn is_silent(&mut self) -> Result<(), Misbehaviour> {
        Ok(())
    }

    /// After the last message.
    ///
    /// # Errors
    /// [`Misbehaviour`].
    fn close(self) -> Result<(), Misbehaviour>;
}

/// A routine that was greeted and opened.
#[derive(Debug)]
pub struct Session<'a, D> {
    door: D,
    definition: &'a Definition,
    connector: Connector<f64>,
    hello: Hello,
    offers: Vec<Quantity>,
    places: Vec<usize>,
    asked: u64,
    first: Option<First>,
    /// What the routine kept at the states before those that are asked for, by their numbers.
    memories: BTreeMap<usize, Value>,
}

/// The first question, and what came.
#[derive(Debug)]
struct First {
    number: usize,
    path: Vec<Step>,
    values_before: Components<f64>,
    answer: Answer,
}

impl<'a, D: Door> Session<'a, D> {
    /// Greets a routine and opens the connector. A convention given here stands for that of the greeting.
    ///
    /// # Errors
    /// [`Misbehaviour`].
    pub fn open(
        mut door: D,
        definition: &'a Definition,
        convention: Option<&Convention>,
        springs: &Components<f64>,
    ) -> Result<Self, Misbehaviour> {
        const DUE: &str = "say hello";
        const OPEN: &str = "open the connector";
        door.send(&protocol::hello(), DUE)?;
        let mut answer = door.receive(DUE)?;
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
        if let Some(convention) = convention {
            hello.convention = convention.clone();
        }
        let places = hello.convention.places().map_err(Misbehaviour::BadConvention)?;
        let unknown = |name: &&String| !COMPONENT.contains(&name.as_str());
        if let Some(name) = hello.components.iter().flatten().find(unknown) {
            let names = COMPONENT.join(", ");
            return Err(Misbehaviour::BadHello(format!("its components name {name:?}; there are {names}")));
        }
        let offers = hello.offers().map_err(Misbehaviour::BadHello)?;
        if offers.is_empty() {
            return Err(Misbehaviour::OffersNothing);
        }
        hello.convention.covers(&offers).map_err(Misbehaviour::BadConvention)?;
        door.send(&protocol::open(definition, &hello.convention, springs), OPEN)?;
        let answer = door.receive(OPEN)?;
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
        let connector = Connector::new(definition);
        Ok(Self {
            door,
            definition,
            connector,
            hello,
            offers,
            places,
            asked: 0,
            first: None,
            memories: BTreeMap::new(),
        })
    }

    /// The name that the routine gave itself.
    pub fn name(&self) -> &str {
        &self.hello.name
    }

    /// What it offers.
    pub fn offers(&self) -> &[Quantity] {
        &self.offers
    }

    /// Of which components.
    pub fn components(&self) -> [bool; 6] {
        let has = |name: &str| {
            self.hello.components.as_ref().is_none_or(|names| names.iter().any(|known| known == name))
        };
        COMPONENT.map(has)
    }

    /// Whether its angles are principal.
    pub fn is_principal(&self) -> bool {
        self.hello.convention.turns == Turns::Principal
    }

    /// What its stiffness is.
    pub fn tangent(&self) -> Tangent {
        self.hello.convention.stiffness.tangent()
    }

    /// What the connector has and the routine does not offer.
    pub fn not_offered(&self) -> Vec<&'static str> {
        let components = self.components();
        // An element of springs is another thing than a connector.
        let is_lacking = |(_, of): &&(_, Quantity)| !self.offers.contains(of) && Quantity::ALL.contains(of);
        let quantities = protocol::OFFERS.iter().filter(is_lacking);
        let has = |k: &usize| self.connector.differentiated(*k).is_some() && !components[*k];
        quantities.map(|(name, _)| *name).chain((0..6).filter(has).map(|k| COMPONENT[k])).collect()
    }

    /// How many requests it got.
    pub const fn asked(&self) -> u64 {
        self.asked
    }

    /// Asks for several states, all for the same quantities.
    ///
    /// # Errors
    /// [`Misbehaviour`].
    pub fn ask(&mut self, asked: &[Question<'_>]) -> Result<Vec<Option<Given>>, Misbehaviour> {
        if self.hello.memory && asked.iter().any(|asked| asked.is_drawn) {
            self.memories.clear();
            for asked in asked {
                self.follow(asked)?;
            }
        }
        let answers = self.answers(asked)?;
        if let (Some(first), Some(answer), None) = (asked.first(), answers.first(), &self.first)
            && first.is_drawn
        {
            let path = first.path.iter().chain([first.step]).copied().collect();
            let (number, values_before) = (first.number, first.values_before);
            self.first = Some(First { number, path, values_before, answer: answer.clone() });
        }
        let components = self.components();
        let mut given = Vec::with_capacity(asked.len());
        for (asked, answer) in asked.iter().zip(answers) {
            given.push(match answer {
                Answer::OutOfDomain(_) => None,
                Answer::Error(why) => return Err(Misbehaviour::Failed { id: self.asked, why }),
                Answer::Given(own) => {
                    let of = (self.definition, &self.connector);
                    let read = own.read(&self.hello.convention, &self.places, of, asked.state());
                    Some(read.only(asked.wants, components))
                }
            });
        }
        Ok(given)
    }

    /// Leads a routine with a memory along the path to a state.
    fn follow(&mut self, asked: &Question<'_>) -> Result<(), Misbehaviour> {
        self.memories.remove(&asked.number);
        for (i, step) in asked.path.iter().enumerate() {
            let on_the_way = Question { step, path: &asked.path[..i], values_before: [None; 6], ..*asked };
            match self.answers(&[on_the_way])?.pop() {
                Some(Answer::Given(own)) => {
                    self.memories.extend(own.memory.map(|memory| (asked.number, memory)));
                }
                Some(Answer::Error(why)) => return Err(Misbehaviour::Failed { id: self.asked, why }),
                _ => {}
            }
        }
        Ok(())
    }

    fn answers(&mut self, asked: &[Question<'_>]) -> Result<Vec<Answer>, Misbehaviour> {
        let Some(first) = asked.first() else { return Ok(Vec::new()) };
        let answer = self.exchange(asked, first.wants)?;
        let id = self.asked;
        protocol::answers(&answer, &self.hello.convention, first.wants, asked.len())
            .map_err(|what| Misbehaviour::WrongShape { id, what })
    }

    /// Asks for several states, and takes the lists as they come: of any shape, in whatever convention.
    ///
    /// # Errors
    /// [`Misbehaviour`].
    pub fn ask_as_it_is(&mut self, asked: &[Question<'_>]) -> Result<Vec<GivenRows>, Misbehaviour> {
        let Some(first) = asked.first() else { return Ok(Vec::new()) };
        let answer = self.exchange(asked, first.wants)?;
        let id = self.asked;
        protocol::as_it_is(answer.get("answers"), asked.len())
            .map_err(|what| Misbehaviour::WrongShape { id, what })
    }

    /// A request, and the answer with its number.
    fn exchange(
        &mut self,
        asked: &[Question<'_>],
        wants: &[Quantity],
    ) -> Result<Map<String, Value>, Misbehaviour> {
        const DUE: &str = "answer";
        // What is there before the question is no answer to it.
        self.door.is_silent()?;
        self.asked += 1;
        let id = self.asked;
        let of = (self.definition, &self.connector);
        let state = |asked: &Question<'_>| {
            protocol::state(asked, of, &self.hello.convention, self.memories.get(&asked.number))
        };
        let states = asked.iter().map(state).collect();
        self.door.send(&protocol::evaluate(id, wants, states), DUE)?;
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

    /// Asks for the first state once more: a routine has no memory but what it is given.
    ///
    /// # Errors
    /// [`Misbehaviour::Changed`], and what else may happen.
    pub fn ask_again(&mut self) -> Result<(), Misbehaviour> {
        let Some(First { number, path, values_before, answer }) = self.first.take() else { return Ok(()) };
        let Some((step, before)) = path.split_last() else { return Ok(()) };
        let offers = self.offers.clone();
        let asked = Question { number, step, path: before, values_before, wants: &offers, is_drawn: true };
        if self.hello.memory {
            self.follow(&asked)?;
        }
        let again = self.answers(&[asked])?;
        // Bit for bit, NaN included.
        if format!("{:?}", again.first()) == format!("{:?}", Some(&answer)) {
            Ok(())
        } else {
            Err(Misbehaviour::Changed)
        }
    }

    /// Says goodbye.
    ///
    /// # Errors
    /// [`Misbehaviour`].
    pub fn close(mut self) -> Result<(), Misbehaviour> {
        self.door.send(&protocol::close(), "end")?;
        self.door.close()
    }
}
