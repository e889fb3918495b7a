//! A routine that was greeted and opened: asked through a door, its answers read in pintle's conventions.

use crate::convention::{Convention, Turns};
use crate::exchange::Exchange;
use crate::fit::GivenRows;
use crate::process::{Door, Misbehaviour};
use crate::protocol::{self, Answer, Layout};
use pintle_audit::{Domain, Given, Quantity, Question, Step, Tangent};
use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::connector::{Components, Connector, Definition};
use pintle_kinematics::scalar::elementary::norm;
use serde_json::Value;
use std::collections::BTreeMap;

/// A routine that was greeted and opened.
#[derive(Debug)]
pub struct Session<'a, D> {
    exchange: Exchange<D>,
    definition: &'a Definition,
    connector: Connector<f64>,
    offers: Vec<Quantity>,
    places: Vec<usize>,
    first: Option<First>,
    /// What the routine kept at the states before those that are asked for, by their numbers.
    memories: BTreeMap<usize, Value>,
    /// The message that opens the connector.
    opening: Value,
    /// To the state before which number a routine was led that commits.
    led: Option<usize>,
    /// Whether it ever gave numbers; at how many states it failed, and the first of these, in words.
    gave: bool,
    failures: u64,
    failed: Option<(usize, String)>,
    lacks_springs: bool,
    /// How many states may end it before that is an error, and how many have.
    may_end: usize,
    ended: usize,
}

/// The first question, and what came.
#[derive(Debug)]
struct First {
    number: usize,
    path: Vec<Step>,
    values_before: Components<f64>,
    wants: Vec<Quantity>,
    answer: Answer,
}

impl<'a, D: Door> Session<'a, D> {
    /// Greets a routine and opens the connector. A convention given here stands for that of the greeting.
    ///
    /// # Errors
    /// [`Misbehaviour`].
    pub fn open(
        door: D,
        definition: &'a Definition,
        convention: Option<&Convention>,
        springs: &Components<f64>,
    ) -> Result<Self, Misbehaviour> {
        let mut exchange = Exchange::greet(door, convention)?;
        let hello = &exchange.hello;
        let name = &*definition.connection.name;
        if let Some(types) = &hello.types
            && !types.iter().any(|known| known.eq_ignore_ascii_case(name))
        {
            return Err(Misbehaviour::Refused(format!(
                "it covers {}, and {name} is another",
                types.join(", ")
            )));
        }
        if hello.commits && hello.memory {
            let what = "a routine that commits has its memory itself: it cannot announce memory, too".into();
            return Err(Misbehaviour::BadHello(what));
        }
        let places = hello.convention.places().map_err(Misbehaviour::BadConvention)?;
        hello.names_among(&COMPONENT).map_err(Misbehaviour::BadHello)?;
        let mut offers = exchange.offers(&protocol::OFFERS)?;
        // Without springs there is nothing to be wrong.
        let is_of_springs =
            |of: &Quantity| matches!(of, Quantity::ElementForces | Quantity::ElementStiffness);
        let lacks_springs = springs.iter().all(Option::is_none) && offers.iter().any(is_of_springs);
        if lacks_springs {
            offers.retain(|of| !is_of_springs(of));
        }
        if offers.is_empty() {
            let what = "it gives the forces of an element of springs: say their stiffness, --springs D1,…,D6";
            return Err(Misbehaviour::Refused(what.into()));
        }
        hello.convention.covers(&offers).map_err(Misbehaviour::BadConvention)?;
        let opening = protocol::open(definition, &exchange.hello.convention, springs);
        exchange.open(&opening)?;
        let connector = Connector::new(definition);
        if exchange.hello.binary && exchange.hello.memory {
            let what = "a routine with a memory has it in its messages: it cannot announce binary".into();
            return Err(Misbehaviour::BadHello(what));
        }
        let lines = exchange.hello.convention.lines();
        exchange.present = lines.iter().map(|k| connector.differentiated(*k).is_some()).collect();
        let memories = BTreeMap::new();
        Ok(Self {
            exchange,
            definition,
            connector,
            offers,
            places,
            first: None,
            memories,
            opening,
            led: None,
            gave: false,
            failures: 0,
            failed: None,
            lacks_springs,
            may_end: 0,
            ended: 0,
        })
    }

    /// Starts a process again that ends at a state, up to so many times: it has no numbers there.
    #[must_use]
    pub fn starting_again(mut self, times: usize) -> Self {
        self.may_end = times;
        self
    }

    /// The name that the routine gave itself.
    pub fn name(&self) -> &str {
        &self.exchange.hello.name
    }

    /// What it offers.
    pub fn offers(&self) -> &[Quantity] {
        &self.offers
    }

    /// Whether it gives forces of springs, and none were given.
    pub const fn lacks_springs(&self) -> bool {
        self.lacks_springs
    }

    /// Of which components.
    pub fn components(&self) -> [bool; 6] {
        COMPONENT.map(|name| self.exchange.hello.has(name))
    }

    /// Whether it keeps something from state to state.
    pub fn has_memory(&self) -> bool {
        self.exchange.hello.memory || self.exchange.hello.commits
    }

    /// Where it is to be asked.
    pub fn domain(&self) -> &Domain {
        &self.exchange.hello.domain
    }

    /// Whether its angles are principal.
    pub fn is_principal(&self) -> bool {
        self.exchange.hello.convention.turns == Turns::Principal
    }

    /// What its stiffness is.
    pub fn tangent(&self) -> Tangent {
        self.exchange.hello.convention.stiffness.tangent()
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

    /// At how many states it failed, and the number of the first of them with what it said.
    pub fn failures(&self) -> (u64, Option<(usize, &str)>) {
        (self.failures, self.failed.as_ref().map(|(number, why)| (*number, why.as_str())))
    }

    /// How many requests it got.
    pub const fn asked(&self) -> u64 {
        self.exchange.asked()
    }

    /// Asks for several states, all for the same quantities.
    ///
    /// # Errors
    /// [`Misbehaviour`].
    pub fn ask(&mut self, asked: &[Question<'_>]) -> Result<Vec<Option<Given>>, Misbehaviour> {
        if self.exchange.hello.memory && asked.iter().any(|asked| asked.is_drawn) {
            self.memories.clear();
            for asked in asked {
                self.lead(asked)?;
            }
        }
        let answers = self.answers(asked)?;
        if let (Some(first), Some(answer), None) = (asked.first(), answers.first(), &self.first)
            && first.is_drawn
        {
            let path = first.path.iter().chain([first.step]).copied().collect();
            let Question { number, values_before, wants, .. } = *first;
            let wants = wants.to_vec();
            self.first = Some(First { number, path, values_before, wants, answer: answer.clone() });
        }
        let components = self.components();
        let mut given = Vec::with_capacity(asked.len());
        self.gave |= answers.iter().any(|answer| matches!(answer, Answer::Given(_)));
        for (asked, answer) in asked.iter().zip(answers) {
            given.push(match answer {
                Answer::OutOfDomain(_) => None,
                // A routine that works elsewhere has no numbers there.
                Answer::Error(why) if self.gave && !self.has_memory() => {
                    self.failures += u64::from(asked.is_drawn);
                    self.failed.get_or_insert((asked.number, why));
                    let has = |k: usize| components[k] && self.connector.differentiated(k).is_some();
                    Some(Given::nothing(asked.wants, std::array::from_fn(has)))
                }
                Answer::Error(why) => return Err(Misbehaviour::Failed { id: self.exchange.asked(), why }),
                Answer::Given(own) => {
                    let of = (self.definition, &self.connector);
                    let read = own.read(&self.exchange.hello.convention, &self.places, of, asked.state());
                    Some(read.only(asked.wants, components))
                }
            });
        }
        Ok(given)
    }

    /// Leads a routine that keeps something from the initial state along the path to a state.
    fn lead(&mut self, asked: &Question<'_>) -> Result<(), Misbehaviour> {
        let commits = self.exchange.hello.commits;
        self.memories.remove(&asked.number);
        self.led = None;
        if commits {
            self.exchange.open_again(&self.opening)?;
        }
        for (i, step) in asked.path.iter().enumerate() {
            let on_the_way = Question { step, path: &asked.path[..i], values_before: [None; 6], ..*asked };
            match self.evaluated(&[on_the_way])?.pop() {
                Some(Answer::Given(own)) => {
                    self.memories.extend(own.memory.map(|memory| (asked.number, memory)));
                }
                Some(Answer::Error(why)) => {
                    return Err(Misbehaviour::Failed { id: self.exchange.asked(), why });
                }
                _ => {}
            }
            if commits {
                self.exchange.tell("commit", "committed")?;
            }
        }
        self.led = Some(asked.number);
        Ok(())
    }

    fn answers(&mut self, asked: &[Question<'_>]) -> Result<Vec<Answer>, Misbehaviour> {
        if !self.exchange.hello.commits {
            return self.evaluated(asked);
        }
        let mut answers = Vec::with_capacity(asked.len());
        for (place, one) in asked.iter().enumerate() {
            if one.is_drawn || self.led != Some(one.number) {
                self.lead(one)?;
            }
            let answer = self.tried(one)?;
            if one.is_drawn {
                // Elsewhere it may fail: whatever it answers there is taken back.
                for step in elsewhere(asked, place) {
                    let before = one.before().map_or(self.definition.initial, |before| before.pair);
                    let moved = Step::between(&before, step.state.pair);
                    let step = Step { state: step.state, ..moved };
                    self.tried(&Question { step: &step, ..*one })?;
                }
                if !self.tried(one)?.is_same_as(&answer) {
                    return Err(Misbehaviour::NotReverted { number: one.number, step: one.path.len() + 1 });
                }
            }
            answers.push(answer);
        }
        Ok(answers)
    }

    /// The answer at a state, which is then taken back.
    fn tried(&mut self, asked: &Question<'_>) -> Result<Answer, Misbehaviour> {
        let answer = self.evaluated(std::slice::from_ref(asked))?.pop();
        self.exchange.tell("revert", "reverted")?;
        answer.ok_or(Misbehaviour::Changed)
    }

    fn evaluated(&mut self, asked: &[Question<'_>]) -> Result<Vec<Answer>, Misbehaviour> {
        let (Some(first), Some(last)) = (asked.first(), asked.last()) else { return Ok(Vec::new()) };
        match self.at_once(asked) {
            Err(why) if why.is_an_end() && !self.has_memory() => self.one_by_one(asked, why),
            found => found.map_err(|why| why.at(first.number, last.number)),
        }
    }

    /// Asks a process that has ended once more, state by state, which of them it was.
    fn one_by_one(&mut self, asked: &[Question<'_>], why: Misbehaviour) -> Result<Vec<Answer>, Misbehaviour> {
        let (mut answers, ended) = (Vec::with_capacity(asked.len()), self.ended);
        let mut is_there = self.exchange.begin_again(&self.opening)?;
        for one in asked {
            if !is_there {
                break;
            }
            match self.at_once(std::slice::from_ref(one)) {
                Err(why) if why.is_an_end() && self.ended < self.may_end => {
                    self.ended += 1;
                    answers.push(Answer::Error(why.to_string()));
                    is_there = self.exchange.begin_again(&self.opening)?;
                }
                found => answers.extend(found.map_err(|why| why.at(one.number, one.number))?),
            }
        }
        // It ends at none of them alone: what the order of questions changes is no number of a state.
        match (asked.first(), asked.last()) {
            (Some(first), Some(last)) if ended == self.ended || answers.len() < asked.len() => {
                Err(why.at(first.number, last.number))
            }
            _ => Ok(answers),
        }
    }

    fn at_once(&mut self, asked: &[Question<'_>]) -> Result<Vec<Answer>, Misbehaviour> {
        let Some(first) = asked.first() else { return Ok(Vec::new()) };
        let of = (self.definition, &self.connector);
        let convention = &self.exchange.hello.convention;
        let state =
            |asked: &Question<'_>| protocol::state(asked, of, convention, self.memories.get(&asked.number));
        let states = asked.iter().map(state).collect();
        let lines = convention.lines();
        let layout = Layout::of(convention, lines.len(), convention.columns.len());
        let mut answers = self.exchange.evaluate(first.wants, states, &|_| layout)?;
        for answer in &mut answers {
            if let Answer::Given(own) = answer {
                own.put_in_order(&lines);
            }
        }
        Ok(answers)
    }

    /// Asks for several states, and takes the lists as they come: of any shape, in whatever convention.
    ///
    /// # Errors
    /// [`Misbehaviour`].
    pub fn ask_as_it_is(&mut self, asked: &[Question<'_>]) -> Result<Vec<GivenRows>, Misbehaviour> {
        let Some(first) = asked.first() else { return Ok(Vec::new()) };
        let of = (self.definition, &self.connector);
        let convention = &self.exchange.hello.convention;
        let states: Vec<Value> =
            asked.iter().map(|asked| protocol::state(asked, of, convention, None)).collect();
        if self.exchange.hello.commits && states.len() > 1 {
            let mut found = Vec::with_capacity(states.len());
            for asked in asked {
                found.extend(self.ask_as_it_is(std::slice::from_ref(asked))?);
            }
            return Ok(found);
        }
        let answer = self.exchange.request(first.wants, states)?;
        if self.exchange.hello.commits {
            self.exchange.tell("revert", "reverted")?;
        }
        let id = self.exchange.asked();
        protocol::as_it_is(answer.get("answers"), asked.len())
            .map_err(|what| Misbehaviour::WrongShape { id, what })
    }

    /// Asks for the first state once more: a routine has no memory but what it is given.
    ///
    /// # Errors
    /// [`Misbehaviour::Changed`], and what else may happen.
    pub fn ask_again(&mut self) -> Result<(), Misbehaviour> {
        let Some(First { number, path, values_before, wants, answer }) = self.first.take() else {
            return Ok(());
        };
        let Some((step, before)) = path.split_last() else { return Ok(()) };
        let asked = Question { number, step, path: before, values_before, wants: &wants, is_drawn: true };
        if self.exchange.hello.memory {
            self.lead(&asked)?;
        }
        let again = self.answers(&[asked])?;
        if again.first().is_some_and(|again| again.is_same_as(&answer)) {
            Ok(())
        } else {
            Err(Misbehaviour::Changed)
        }
    }

    /// Says goodbye.
    ///
    /// # Errors
    /// [`Misbehaviour`].
    pub fn close(self) -> Result<(), Misbehaviour> {
        self.exchange.close()
    }
}

/// Steps that are tried and taken back between a step and the same step once more. Of a history they walk back to its begin, each within a
/// radian where its increments are: what takes a trial for its memory has lost the turns on the way. One state alone has others beside it.
fn elsewhere<'a>(asked: &[Question<'a>], place: usize) -> Vec<&'a Step> {
    /// Three may go around a turn.
    const BESIDE: usize = 3;
    const WITHIN: f64 = 1.0;
    let one = &asked[place];
    if one.path.is_empty() {
        let others = asked[place + 1..].iter().chain(&asked[..place]);
        return others.filter(|other| other.is_drawn).map(|other| other.step).take(BESIDE).collect();
    }
    let turn = |step: &Step| step.increment.rotation.map(norm).iter().sum::<f64>();
    let mut found = Vec::new();
    let mut turned = turn(one.step);
    for (i, step) in one.path.iter().enumerate().rev() {
        if i == 0 || turned + turn(step) > WITHIN {
            found.push(step);
            turned = 0.0;
        }
        turned += turn(step);
    }
    found
}
