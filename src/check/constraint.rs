//! A routine that is to be a multi-point constraint.

use crate::convention::{COLUMNS, Convention, Own, Sense, Triads, Turned};
use crate::exchange::Exchange;
use crate::fit::{self, Found};
use crate::process::{Door, Misbehaviour};
use crate::protocol::{self, Layout};
use crate::{Asked, Checked};
use pintle_audit::{ConstraintCandidate, ConstraintNumbers, MpcCase, Quantity, initial_places};
use pintle_kinematics::measure::Unit;
use pintle_kinematics::mpc::{Body, Constraint, DOFS, Dofs, MpcType, PHI, ROWS, Rows};
use pintle_kinematics::vector::{add, transpose};
use serde_json::{Value, json};

/// What may be offered.
const OFFERED: [Quantity; 5] = [
    Quantity::Value,
    Quantity::FirstDerivatives,
    Quantity::SecondDerivatives,
    Quantity::Rate,
    Quantity::Acceleration,
];

/// How a routine's numbers of a constraint are read.
struct Reader {
    constraint: Constraint<f64>,
    convention: Convention,
    /// The place of each of the routine's columns.
    places: Vec<usize>,
    /// The equation of each of its lines.
    lines: Vec<usize>,
}

impl Reader {
    fn new(constraint: &Constraint<f64>, mut convention: Convention) -> Result<Self, Misbehaviour> {
        let kind = constraint.kind();
        let known: Vec<&str> = fit::columns_of(kind).into_iter().filter(|name| !name.is_empty()).collect();
        if convention.columns == COLUMNS {
            convention.columns = known.iter().map(|name| (*name).to_string()).collect();
        }
        if !convention.is_of_equations() {
            let what =
                "a constraint is read with its axes and positions as pintle has them, and angles as they are";
            return Err(Misbehaviour::BadConvention(what.into()));
        }
        let names: Vec<&str> = (0..ROWS).map(|row| kind.row_name(row)).collect();
        let places = convention.places_among(&known, &names).map_err(Misbehaviour::BadConvention)?;
        let lines = convention.lines_among(&names);
        Ok(Self { constraint: *constraint, convention, places, lines })
    }

    fn layout(&self) -> Layout {
        Layout::of(&self.convention, self.lines.len(), self.places.len())
    }

    /// What a number of an equation is to be multiplied with. Factors are those of the first six.
    fn unit(&self, row: usize) -> f64 {
        let of_unit = match MpcType::row_unit(row) {
            Unit::Angle => self.convention.angle(),
            _ => self.convention.length * self.convention.row_length,
        };
        of_unit / self.convention.factors.get(row).copied().unwrap_or(1.0)
    }

    /// Derivatives by the routine's columns as derivatives by pintle's.
    fn line(&self, of_routine: &[f64], turned: &[Turned; 2]) -> Dofs<f64> {
        let both = || of_routine.iter().zip(&self.places);
        let nodal: (Vec<f64>, Vec<usize>) =
            both().filter(|(_, place)| **place < PHI).map(|(x, place)| (*x, *place)).unzip();
        let mut found = [0.0; DOFS];
        found[..PHI].copy_from_slice(&self.convention.line(&nodal.0, &nodal.1, turned));
        for (x, place) in both().filter(|(_, place)| **place >= PHI) {
            found[*place] = x / self.convention.column_angle();
        }
        found
    }

    fn matrix(&self, of_routine: &[f64], unit: f64, turned: &[Turned; 2]) -> Box<[Dofs<f64>; DOFS]> {
        let lines: Vec<Dofs<f64>> =
            of_routine.chunks(self.places.len().max(1)).map(|line| self.line(line, turned)).collect();
        let mut matrix = Box::new([[0.0; DOFS]; DOFS]);
        for j in 0..DOFS {
            let column: Vec<f64> = lines.iter().map(|line| line[j]).collect();
            for (entry, x) in matrix.iter_mut().zip(self.line(&column, turned)) {
                entry[j] = unit * x;
            }
        }
        matrix
    }

    fn read(&self, own: &Own, case: &MpcCase) -> ConstraintNumbers {
        let turned = Turned::of_bodies(&case.state);
        let mut given = ConstraintNumbers::default();
        for (quantity, of) in &own.given {
            let row_of = |row: usize| of.get(self.lines.iter().position(|line| *line == row)?)?.as_ref();
            let scalars =
                || -> Rows<f64> { std::array::from_fn(|row| Some(row_of(row)?.first()? * self.unit(row))) };
            given = match quantity {
                Quantity::Value => given.values(scalars()),
                Quantity::Rate => given.rates(scalars()),
                Quantity::Acceleration => given.accelerations(scalars()),
                Quantity::FirstDerivatives => given.rows(std::array::from_fn(|row| {
                    Some(self.line(row_of(row)?, &turned).map(|x| self.unit(row) * x))
                })),
                Quantity::SecondDerivatives => given.second_derivatives(std::array::from_fn(|row| {
                    Some(self.matrix(row_of(row)?, self.unit(row), &turned))
                })),
                _ => given,
            };
        }
        given
    }

    fn open(&self) -> Value {
        let kind = self.constraint.kind();
        let rows = self.constraint.rows();
        let equation = |row: usize| {
            let unit = format!("{:?}", MpcType::row_unit(row)).to_lowercase();
            if rows[row] { json!({ "name": kind.row_name(row), "unit": unit }) } else { Value::Null }
        };
        let length = self.convention.length;
        let [master, slave] = initial_places(self.constraint.arm(), false);
        let axes: Vec<_> = self.constraint.initial_axes().into_iter().flatten().collect();
        json!({ "open": {
            "type": format!("MPC {}", kind.name()),
            "equations": (0..ROWS).map(equation).collect::<Vec<Value>>(),
            "initial": {
                "S": { "x": slave.map(|x| x / length) },
                "M": { "x": master.map(|x| x / length) },
            },
            "axes": axes,
        } })
    }

    fn state(&self, case: &MpcCase, has_rates: bool) -> Value {
        let length = self.convention.length;
        let hinges = self.constraint.kind().entry().angles.len();
        let state = &case.state;
        let node = |body: &Body<f64>, at: [f64; 3], from: usize| {
            let place = add(at, body.displacement);
            let convention = &self.convention;
            let backwards = convention.sense == Sense::Inverse;
            let rotation = if backwards { transpose(&body.rotation) } else { body.rotation };
            let triad = if convention.triads == Triads::Matrix { rotation } else { transpose(&rotation) };
            let mut node =
                protocol::node_of(place, body.displacement, triad, &rotation, body.flow, convention);
            if has_rates {
                for (kind, of) in [("velocity", &state.velocity), ("acceleration", &state.acceleration)] {
                    protocol::add_rates(&mut node, kind, &of[from..from + 7], length);
                }
            }
            node
        };
        let [master, slave] = initial_places(self.constraint.arm(), false);
        let angles: Vec<f64> = state.angles.iter().take(hinges).map(|angle| angle.unwrap_or(0.0)).collect();
        let mut one = json!({
            "S": node(&state.slave, slave, 0),
            "M": node(&state.master, master, 7),
            "angles": angles,
        });
        if let (Some(one), true) = (one.as_object_mut(), has_rates) {
            one.insert("angle_velocities".into(), json!(state.velocity[PHI..PHI + hinges]));
            one.insert("angle_accelerations".into(), json!(state.acceleration[PHI..PHI + hinges]));
        }
        one
    }
}

/// Asks a routine behind a door for rows at general states, and finds the conventions under which they are right.
///
/// # Errors
/// [`Misbehaviour`]; what it gives may be no rows at all.
pub(crate) fn fit_convention<D: Door>(
    door: D,
    constraint: &Constraint<f64>,
    seed: &str,
) -> Result<Found, Misbehaviour> {
    const STATES: usize = 3;
    let plain = Convention::default();
    let mut exchange = Exchange::greet(door, Some(&plain))?;
    let reader = Reader::new(constraint, plain)?;
    let known: Vec<_> = protocol::OFFERS.into_iter().filter(|(_, of)| OFFERED.contains(of)).collect();
    let offers = exchange.offers(&known)?;
    if !offers.contains(&Quantity::FirstDerivatives) {
        return Err(Misbehaviour::BadHello("it offers no rows, by which conventions are found".into()));
    }
    let wants: Vec<Quantity> = [Quantity::Value, Quantity::FirstDerivatives, Quantity::Rate]
        .into_iter()
        .filter(|quantity| offers.contains(quantity))
        .collect();
    exchange.open(&reader.open())?;
    let has_rates = wants.contains(&Quantity::Rate);
    let mut ask = |cases: &[MpcCase]| {
        let messages = cases.iter().map(|case| reader.state(case, has_rates)).collect();
        let answer = exchange.request(&wants, messages)?;
        let id = exchange.asked();
        protocol::as_it_is(answer.get("answers"), cases.len())
            .map_err(|what| Misbehaviour::WrongShape { id, what })
    };
    let mut cases = fit::generic_cases(constraint, seed, STATES);
    let mut given = ask(&cases)?;
    let mut found = fit::fit_constraint(constraint, &cases, &given).map_err(Misbehaviour::NoConvention)?;
    let others = fit::generic_cases(constraint, &format!("{seed}, others"), STATES);
    if let Some(n) = found.separating_case(&others) {
        given.extend(ask(&others[n..=n])?);
        cases.push(others[n].clone());
        found = fit::fit_constraint(constraint, &cases, &given).map_err(Misbehaviour::NoConvention)?;
    }
    exchange.close()?;
    Ok(found)
}

/// Asks a routine behind a door to be a constraint, and checks what it answers.
///
/// # Errors
/// [`Misbehaviour`].
pub(crate) fn check<D: Door>(
    door: D,
    constraint: &Constraint<f64>,
    at: &[MpcCase],
    asked: Asked,
) -> Result<Checked, Misbehaviour> {
    let mut exchange = Exchange::greet(door, asked.convention.as_ref())?.only_asked();
    let kind = constraint.kind();
    let reader = Reader::new(constraint, exchange.hello.convention.clone())?;
    let known: Vec<_> = protocol::OFFERS.into_iter().filter(|(_, of)| OFFERED.contains(of)).collect();
    let offers = exchange.offers(&known)?;
    reader.convention.covers(&offers).map_err(Misbehaviour::BadConvention)?;
    let rows = constraint.rows();
    let names: Vec<&str> = (0..ROWS).filter(|row| rows[*row]).map(|row| kind.row_name(row)).collect();
    exchange.hello.names_among(&names).map_err(Misbehaviour::BadHello)?;
    exchange.open(&reader.open())?;
    let offered: [bool; ROWS] =
        std::array::from_fn(|row| rows[row] && exchange.hello.has(kind.row_name(row)));
    let name = asked.title(&exchange.hello.name);
    let candidate = ConstraintCandidate::new(&name, constraint)
        .settings(asked.settings)
        .offers(&offers)
        .of_equations(offered);
    let candidate = if at.is_empty() { candidate } else { candidate.at(at) };
    let has_rates = offers.iter().any(|of| matches!(of, Quantity::Rate | Quantity::Acceleration));
    let layout = reader.layout();
    let (mut states, mut outside) = (0, 0);
    let report = candidate.try_check(|cases| {
        let messages = cases.iter().map(|case| reader.state(case, has_rates)).collect();
        let given = exchange.answers(&offers, messages, &|_| layout)?;
        let read = cases.iter().zip(given).map(|(case, own)| own.map(|own| reader.read(&own, case)));
        let read: Vec<_> = read.collect();
        states += read.len() as u64;
        outside += read.iter().filter(|given| given.is_none()).count() as u64;
        Ok::<_, Misbehaviour>(read)
    })?;
    let lacking = known.iter().filter(|(_, of)| !offers.contains(of)).map(|(name, _)| *name);
    let lacking_rows = (0..ROWS).filter(|row| rows[*row] && !offered[*row]).map(|row| kind.row_name(row));
    let not_offered = lacking.chain(lacking_rows).collect();
    exchange.ask_again(&|_| layout)?;
    let requests = exchange.asked();
    exchange.close()?;
    Ok(Checked::without_history(report, (states, outside), not_offered, requests))
}
