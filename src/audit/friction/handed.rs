//! Counter-examples of frictions in other forms: where a number stands, which type's friction it is, the deck that leads to it.

use super::criterion::PARTS;
use super::increment::{input_names, output, partials, result_name, results};
use super::{BeltCase, FrictionCase, belt};
use crate::audit::quantity::Quantity;
use crate::behavior::friction::{Branch, Coefficient, Criterion, Flag, StickStiffness};
use crate::catalog::{ConnectionType, Contact, FORCE, Load, Orientation, PLANE, SPATIAL, TABLE};
use crate::scene::{ElementForces, Label, NodeMotion, Rotation, State, StateFile};
use crate::so3;
use crate::vector::{Matrix, column, identity, product, transpose};
use serde_json::Value;

/// The number of a friction: of its criterion or of an increment, which output, and by which inputs it is differentiated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::audit) struct Place {
    /// Whether it is of P, F_C, F_N or Φ.
    pub(in crate::audit) is_of_criterion: bool,
    /// The place among P, F_C, F_N, Φ; or among the forces, Δγ, F_N, the limit and CASU.
    pub(in crate::audit) output: usize,
    /// The places among the forces, or T1, T2, α; or among the inputs of an increment.
    pub(in crate::audit) inputs: Vec<usize>,
}

/// The places of all numbers of a kind, by name. `parts`, `results` and so on are the names in their order.
struct Names<'a> {
    parts: &'a [String],
    forces: &'a [&'a str],
    slopes: &'a [String],
    inputs: &'a [String],
    results: &'a [(String, usize)],
}

impl Names<'_> {
    fn place(&self, quantity: Quantity, entry: &str) -> Option<Place> {
        let of = |is_of_criterion: bool, output: usize, inputs: Vec<usize>| {
            Some(Place { is_of_criterion, output, inputs })
        };
        let by_one = |outputs: &[String], inputs: &[&str]| {
            let all =
                (0..outputs.len()).flat_map(|output| (0..inputs.len()).map(move |input| (output, input)));
            all.into_iter().find(|(i, j)| format!("∂{}/∂{}", outputs[*i], inputs[*j]) == entry)
        };
        match quantity {
            Quantity::FrictionCriterion => {
                of(true, self.parts.iter().position(|part| part == entry)?, Vec::new())
            }
            Quantity::FrictionGradient => {
                let (output, input) = by_one(self.parts, self.forces)?;
                of(true, output, vec![input])
            }
            Quantity::FrictionHessian => {
                let (n, parts) = (self.forces.len(), self.parts.len());
                let all = (0..parts).flat_map(|p| (0..n * n).map(move |at| (p, at / n, at % n)));
                let is_it = |(p, k, j): &(usize, usize, usize)| {
                    format!("∂²{}/∂{}∂{}", self.parts[*p], self.forces[*k], self.forces[*j]) == entry
                };
                let (output, k, j) = all.into_iter().find(is_it)?;
                of(true, output, vec![k, j])
            }
            Quantity::FrictionTangent => {
                let inputs: Vec<&str> = self.inputs.iter().map(String::as_str).collect();
                let (output, input) = by_one(self.slopes, &inputs)?;
                of(false, output, vec![input])
            }
            Quantity::FrictionForce => {
                of(false, self.results.iter().find(|(name, _)| name == entry)?.1, Vec::new())
            }
            _ => None,
        }
    }
}

/// A predefined friction of a type, as a deck has it.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::audit) struct Predefined {
    /// The type.
    pub(in crate::audit) connection: &'static ConnectionType,
    /// Which of its criteria (from 0).
    pub(in crate::audit) place: usize,
    /// The numbers of the data line; those on which this criterion does not depend are 1, or 0 where they may be left out.
    pub(in crate::audit) parameters: Vec<f64>,
    /// Whether it is of a plane connector.
    pub(in crate::audit) is_planar: bool,
}

impl Predefined {
    /// Whether a contact force is formed along axes that turn.
    fn has_cross(&self) -> bool {
        let terms = |contact: Contact| match contact {
            Contact::Sum { terms, .. } => terms,
            Contact::Belt => &[],
        };
        let criteria = self.connection.friction.into_iter().flat_map(|friction| friction.criteria);
        let mut loads = criteria.flat_map(|criterion| terms(criterion.contact)).map(|term| term.load);
        loads.any(|load| !matches!(load, Load::Norm(_)))
    }

    /// The components that the connector has.
    pub(in crate::audit) const fn present(&self) -> [bool; 6] {
        if self.is_planar { PLANE } else { SPATIAL }
    }
}

/// Numbers that stand for parameters while it is looked for which they are: no formula has them.
fn stand_in(parameter: usize) -> f64 {
    (parameter as f64).mul_add(0.125, 1.0 + 1.0 / 64.0)
}

/// Whether two values are one, but for numbers that stand for parameters: these are told.
fn is_alike(with: &Value, other: &Value, found: &mut [Option<f64>]) -> bool {
    match (with, other) {
        (Value::Number(x), Value::Number(y)) => {
            let (Some(x), Some(y)) = (x.as_f64(), y.as_f64()) else { return false };
            match (0..found.len()).find(|parameter| stand_in(*parameter) == x) {
                Some(parameter) => found[parameter].replace(y).is_none_or(|before| before == y),
                None => x == y,
            }
        }
        (Value::Array(x), Value::Array(y)) => {
            x.len() == y.len() && x.iter().zip(y).all(|(x, y)| is_alike(x, y, found))
        }
        (Value::Object(x), Value::Object(y)) => {
            x.len() == y.len() && x.iter().all(|(name, x)| y.get(name).is_some_and(|y| is_alike(x, y, found)))
        }
        (x, y) => x == y,
    }
}

/// The friction that decks call this one, if its numbers are those of a type: every optional parameter is tried with and without.
fn predefined(criterion: &Criterion) -> Option<Predefined> {
    let value = serde_json::to_value(criterion).ok()?;
    let types = TABLE.iter().filter_map(|connection| Some((connection, connection.friction?)));
    for (connection, friction) in types {
        if friction.criteria.iter().any(|criterion| criterion.contact == Contact::Belt) {
            continue;
        }
        let count = friction.parameters.len();
        let optional: Vec<usize> = (0..count).filter(|i| !friction.parameters[*i].required).collect();
        for (left_out, is_planar) in
            (0..1_usize << optional.len()).flat_map(|mask| [(mask, false), (mask, true)])
        {
            let is_out =
                |i: usize| optional.iter().position(|o| *o == i).is_some_and(|bit| left_out >> bit & 1 == 1);
            let tried: Vec<Option<f64>> =
                (0..count).map(|i| Some(if is_out(i) { 0.0 } else { stand_in(i) })).collect();
            let Ok(all) = Criterion::predefined(&friction, &tried, &[], is_planar) else { continue };
            for (place, other) in all.iter().enumerate() {
                let mut found = vec![None; count];
                let is_it =
                    serde_json::to_value(other).is_ok_and(|other| is_alike(&other, &value, &mut found));
                if !is_it {
                    continue;
                }
                let of =
                    |i: usize| found[i].unwrap_or(if friction.parameters[i].required { 1.0 } else { 0.0 });
                let parameters: Vec<f64> = (0..count).map(of).collect();
                let given: Vec<Option<f64>> = parameters.iter().copied().map(Some).collect();
                let again = Criterion::predefined(&friction, &given, &[], is_planar).ok();
                let again = again.and_then(|all| serde_json::to_value(all.get(place)?).ok());
                if again.as_ref() == Some(&value) {
                    return Some(Predefined { connection, place, parameters, is_planar });
                }
            }
        }
    }
    None
}

/// A model and its states, and why there are none.
pub(in crate::audit) type Stated = Result<(String, String), String>;

impl FrictionCase {
    /// Where the number of that name stands.
    pub(in crate::audit) fn place(&self, quantity: Quantity, entry: &str) -> Option<Place> {
        let title = &self.title;
        let slopes: Vec<String> = (0..9).map(|k| format!("{}{title}", result_name(k))).collect();
        let mut results: Vec<(String, usize)> =
            (0..6).map(|k| (format!("{}{title}", output(k)), k)).collect();
        results.extend((0..9).map(|k| (slopes[k].clone(), k)));
        results.extend([("CNF", 7), ("CASU", 9)].map(|(name, k)| (format!("{name}{title}"), k)));
        let names = Names {
            parts: &PARTS.map(|part| format!("{part}{title}")),
            forces: &FORCE,
            slopes: &slopes,
            inputs: &input_names(),
            results: &results,
        };
        names.place(quantity, entry)
    }

    /// The type whose predefined friction it is, if there is one.
    pub(in crate::audit) fn predefined(&self) -> Option<Predefined> {
        predefined(&self.friction.criterion)
    }

    /// Whether the traction was returned along itself, because its return against the gradient of the potential has no solution that is
    /// found.
    pub(in crate::audit) fn is_returned_along(&self) -> bool {
        let (outcome, _) = self.friction.tangent(&self.before, &self.input(0, 0.0), Branch::Decided);
        outcome.flags.contains(&Flag::ReturnedAlongTraction)
    }

    /// Every number of the increment, or of the criterion, by kind: of Φ, or of P, F_C and F_N, which μ does not change.
    pub(in crate::audit) fn numbers(&self, place: &Place) -> Vec<(Quantity, Vec<f64>)> {
        if place.is_of_criterion {
            let all = self.derivatives(&self.friction.criterion, &self.point);
            let is_asked = |part: usize| (part == parts_of_phi()) == (place.output == parts_of_phi());
            let all: Vec<_> = (0..all.len()).filter(|part| is_asked(*part)).map(|part| all[part]).collect();
            return vec![
                (Quantity::FrictionCriterion, all.iter().map(|part| part.value).collect()),
                (Quantity::FrictionGradient, all.iter().flat_map(|part| part.gradient).collect()),
                (
                    Quantity::FrictionHessian,
                    all.iter().flat_map(|part| part.hessian.as_flattened().to_vec()).collect(),
                ),
            ];
        }
        let (outcome, tangent) = self.friction.tangent(&self.before, &self.input(0, 0.0), Branch::Decided);
        let mut forces = results(&outcome).to_vec();
        forces.push(outcome.accumulated_slip);
        vec![(Quantity::FrictionForce, forces), (Quantity::FrictionTangent, partials(&tangent).concat())]
    }

    /// The same friction of a connector with some others, of the same sliding components.
    pub(in crate::audit) fn is_of(&self, other: &Self) -> bool {
        let sliding = |case: &Self| case.friction.criterion.tangential.components();
        sliding(self) == sliding(other)
    }

    /// A model and states that lead to the increment, or to the forces at which its criterion is judged: its type's nodes lie together, or as
    /// far as it is turned; forces that press are given.
    pub(in crate::audit) fn stated(&self, place: &Place) -> Stated {
        let Some(of) = self.predefined() else {
            return Err("it is not the predefined friction of a type: a scene with its springs, tables and potentials is needed, and that is \
                        written where it was found at a state given, under forces given"
                .to_string());
        };
        if self.before.force != [0.0; 6]
            || self.before.accumulated_slip != 0.0
            || (self.before.stick_stiffness.is_some()
                && matches!(self.friction.stick_stiffness, StickStiffness::ElasticSlip(_)))
        {
            return Err("it starts from a friction force, a slip or a stick stiffness that earlier increments left, and a deck has no history \
                        but its states"
                .to_string());
        }
        let moved = if place.is_of_criterion { self.held(place)? } else { self.increment()? };
        Ok((self.model(&of, &moved), self.states(&of, &moved)?))
    }

    /// The increment itself.
    fn increment(&self) -> Result<Moved, String> {
        let coefficient = match &self.friction.coefficient {
            Coefficient::Constant(mu) => format!("*FRICTION{}\n{mu:?}\n", self.options()),
            Coefficient::Exponential { at_rest, kinetic, decay } => format!(
                "*FRICTION, EXPONENTIAL DECAY{}\n{at_rest:?}, {kinetic:?}, {decay:?}\n",
                self.options()
            ),
            Coefficient::Table(_) => {
                return Err("its friction coefficient is a table of a scene that is not known".to_string());
            }
        };
        let stick = match self.friction.stick_stiffness {
            StickStiffness::Given(stiffness) => format!(", STICK STIFFNESS={stiffness:?}"),
            StickStiffness::ElasticSlip(_) => String::new(),
        };
        Ok(Moved {
            displacement: self.of_sliding(&self.displacement),
            pressing: self.forces,
            tractions: self.friction.tangent(&self.before, &self.input(0, 0.0), Branch::Decided).0.force,
            coefficient,
            stick,
            duration: self.duration,
        })
    }

    /// The numbers of the components that slide: no others matter to the increment.
    fn of_sliding(&self, all: &[f64; 6]) -> [f64; 6] {
        let sliding = self.friction.criterion.tangential.components();
        std::array::from_fn(|k| if sliding.contains(&k) { all[k] } else { 0.0 })
    }

    fn options(&self) -> String {
        let elastic = match self.friction.stick_stiffness {
            StickStiffness::Given(_) => String::new(),
            StickStiffness::ElasticSlip(slip) => format!(", ELASTIC SLIP={slip:?}"),
        };
        let most = self.friction.maximum.map_or_else(String::new, |most| format!(", TAUMAX={most:?}"));
        format!("{elastic}{most}")
    }

    /// An increment in stick that leads to the tractions at which the criterion is judged, by a stick stiffness that is a power of two. Where
    /// they are beyond the limit, that is another one, on which P, F_C and F_N do not depend; Φ does.
    fn held(&self, place: &Place) -> Result<Moved, String> {
        let [tangential, _, normal, criterion] = self.part_values();
        let is_of_phi = place.output == parts_of_phi();
        let (mu, options) = if criterion <= 0.0 {
            let most = self.friction.maximum.map_or_else(String::new, |most| format!(", TAUMAX={most:?}"));
            (self.coefficient, most)
        } else if is_of_phi {
            return Err(format!(
                "its tractions are beyond the limit, Φ = {criterion:e} > 0, to which no increment leads"
            ));
        } else {
            ((2.0 * tangential / normal).log2().ceil().exp2(), String::new())
        };
        if !(mu > 0.0 && mu.is_finite()) && tangential != 0.0 {
            return Err(
                "nothing presses, so that no traction can be held, and no increment leads to one".to_string()
            );
        }
        let radii = self.friction.radii();
        let mut displacement = [0.0; 6];
        for (k, radius) in &radii {
            displacement[*k] = self.point[*k] / (radius * radius);
        }
        let largest = displacement.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let stiffness = if largest > 0.0 { largest.log2().ceil().exp2() } else { 1.0 };
        Ok(Moved {
            displacement: displacement.map(|x| x / stiffness),
            pressing: self.point,
            tractions: self.of_sliding(&self.point),
            coefficient: format!("*FRICTION{options}\n{mu:?}\n"),
            stick: format!(", STICK STIFFNESS={stiffness:?}"),
            duration: None,
        })
    }

    /// The nodes, the connector and its friction.
    fn model(&self, of: &Predefined, moved: &Moved) -> String {
        let items = |all: &[f64]| all.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(", ");
        let mut text = "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n".to_string();
        let triads = [identity(), self.initial(of, moved)];
        let has = |end: usize| of.connection.orientation[end].orientation != Orientation::Ignored;
        for (end, name) in ["OA", "OB"].into_iter().enumerate().filter(|(end, _)| has(*end)) {
            let (e1, e2) = (column(&triads[end], 0), column(&triads[end], 1));
            text.push_str(&format!("*ORIENTATION, NAME={name}\n{}, {}\n", items(&e1), items(&e2)));
        }
        let named = |end: usize| ["OA", "OB"].into_iter().nth(end).filter(|_| has(end)).unwrap_or_default();
        let element = if of.is_planar { "CONN2D2" } else { "CONN3D2" };
        text.push_str(&format!(
            "*ELEMENT, TYPE={element}, ELSET=CONNECTOR\n1, 1, 2\n*CONNECTOR SECTION, ELSET=CONNECTOR, BEHAVIOR=FRICTION\n{}\n{}, {}\n\
             *CONNECTOR BEHAVIOR, NAME=FRICTION\n*CONNECTOR FRICTION, PREDEFINED{}\n{}\n{}\
             ** Nodes that turn, whatever the connector needs\n*ELEMENT, TYPE=ROTARYI, ELSET=TURNING\n11, 1\n12, 2\n\
             *ROTARY INERTIA, ELSET=TURNING\n1., 1., 1.\n",
            of.connection.name,
            named(0),
            named(1),
            moved.stick,
            items(&of.parameters),
            moved.coefficient
        ));
        text
    }

    /// The triad of b before the increment: with the angles, about the axes of the cross, from which it leads to those given. Of other
    /// types nothing depends on them.
    fn initial(&self, of: &Predefined, moved: &Moved) -> Matrix<f64> {
        let mut angles = self.angles(of, moved);
        (3..6).for_each(|k| angles[k - 3] -= moved.displacement[k]);
        turned(angles)
    }

    /// The angles at the end.
    fn angles(&self, of: &Predefined, moved: &Moved) -> [f64; 3] {
        if of.has_cross() {
            let [_, _, _, alpha, beta, gamma] = self.position;
            return [alpha, beta, gamma];
        }
        let [_, _, _, alpha, beta, gamma] = moved.displacement;
        [alpha, beta, gamma]
    }

    /// At rest, then after the increment under what presses.
    fn states(&self, of: &Predefined, moved: &Moved) -> Result<String, String> {
        let before = self.initial(of, moved);
        let after = turned(self.angles(of, moved));
        let total = product(&after, &transpose(&before));
        let [u1, u2, u3, alpha, beta, gamma] = moved.displacement;
        let rotation = if [alpha, beta, gamma] == [0.0; 3] {
            Rotation::default()
        } else if [beta, gamma] == [0.0; 2] && before == identity::<f64>() {
            Rotation::Vector([alpha, 0.0, 0.0])
        } else {
            Rotation::Quaternion(so3::normalize(so3::quaternion(&total)))
        };
        let motion = NodeMotion { displacement: [u1, u2, u3], rotation, ..NodeMotion::default() };
        let presses = self.friction.criterion.pressing_components();
        let slots = &of.connection.slots;
        let has = |k: usize| of.present()[k] && (slots[k].is_available() || slots[k].is_constrained());
        // Of what slides the friction force is all there is; of what neither slides nor presses nothing matters.
        let under = |share: f64, tractions: &[f64; 6]| ElementForces {
            total: std::array::from_fn(|k| {
                has(k).then_some(if presses[k] { share * moved.pressing[k] } else { tractions[k] })
            }),
            ..ElementForces::default()
        };
        let of_element = |forces: ElementForces| [(Label::from(1), forces)].into();
        // The first state under pressure makes the stick stiffness, where none is given: that is to be the second.
        let is_given = !moved.stick.is_empty();
        let start = State {
            time: moved.duration.map(|_| 0.0),
            forces: of_element(under(if is_given { 1.0 } else { 0.0 }, &[0.0; 6])),
            ..State::default()
        };
        let end = State {
            time: moved.duration,
            nodes: [(Label::from(2), motion)].into(),
            forces: of_element(under(1.0, &moved.tractions)),
            ..State::default()
        };
        StateFile { states: vec![start, end] }.to_json().map_err(|error| error.to_string())
    }
}

/// Φ among the parts of a criterion.
const fn parts_of_phi() -> usize {
    PARTS.len() - 1
}

/// Where an increment leads, and under what.
struct Moved {
    /// Δu.
    displacement: [f64; 6],
    /// What presses.
    pressing: [f64; 6],
    /// The friction forces at the end.
    tractions: [f64; 6],
    /// `*FRICTION`.
    coefficient: String,
    /// The option of the stick stiffness.
    stick: String,
    duration: Option<f64>,
}

/// The triad after Cardan angles: R1(α) R2(β) R3(γ).
fn turned([alpha, beta, gamma]: [f64; 3]) -> Matrix<f64> {
    let about = |axis: usize, angle: f64| {
        let mut vector = [0.0; 3];
        vector[axis] = angle;
        so3::matrix(so3::exp(vector))
    };
    product(&product(&about(0, alpha), &about(1, beta)), &about(2, gamma))
}

impl BeltCase {
    /// Where the number of that name stands.
    pub(in crate::audit) fn place(&self, quantity: Quantity, entry: &str) -> Option<Place> {
        let results: Vec<(String, usize)> =
            belt::RESULTS.iter().enumerate().map(|(k, name)| (name.to_string(), k)).collect();
        let names = Names {
            parts: &PARTS.map(String::from),
            forces: &belt::POINT,
            slopes: &[belt::RESULTS[0].to_string()],
            inputs: &belt::INPUTS.map(String::from),
            results: &results,
        };
        names.place(quantity, entry)
    }
}
