//! A multi-point constraint at one state: its equations, rows, second derivatives, rates and accelerations against differences
//! on 237-bit numbers, and laws that they meet without any reference (`laws`).
//!
//! Derivatives are those at independent angles of the hinges: where a state does not give them, the angles that the rotations
//! imply are held.

pub(super) mod atlas;
mod cut;
mod elsewhere;
mod given;
mod laws;
mod mistakes;

pub use given::ConstraintNumbers;

use crate::case::failing::{Failing, MpcCase};
use crate::case::is_still;
use crate::case::quantity::Quantity;
use crate::judge::bound::scales;
use crate::judge::conditioned::{CLEAR, Least};
use crate::judge::outcome::Check;
use crate::judge::table::{Entry, ResultTable};
use crate::judge::verdict::Verdict;
use crate::oracles::differences::{self, Directions, FIRST_STEP, NOISE};
use crate::oracles::oracle::nearness;
use crate::oracles::truth::rotation;
use crate::settings::Settings;
use crate::singular::sides::Sides;

use pintle_kinematics::Differentiable;
use pintle_kinematics::connector::{Output, Request, Tally, Turns};
use pintle_kinematics::measure::{SingularClass, Unit};
use pintle_kinematics::mpc::{
    Body, Constraint, DOFS, Dofs, Evaluation, MpcType, PHI, PSI_M, PSI_S, ROWS, Rows, State, THETA_M,
    THETA_S, Turning, XM, XS,
};
use pintle_kinematics::scalar::{Real, Scalar, Wide};
use pintle_kinematics::so3::exp;
use pintle_kinematics::vector::{self, add, product, sub};

/// The constraint and its state on 237-bit numbers.
struct WideConstraint {
    constraint: Constraint<Wide>,
    /// The state as it is given, which values are of.
    given: State<Wide>,
    /// The same with rotations that are such to the last of 237 bits, which derivatives are of.
    state: State<Wide>,
    sizes: Dofs<f64>,
    /// min(1, distance of each equation to where it has no derivative on its sheet), 0 there.
    nearness: [f64; ROWS],
    /// The sheet that ρ is on, where there is another one.
    sheet: Option<cut::Sheet>,
}

/// Difference quotients of the equations on a singular set.
struct BothSides {
    first: [Rows<Sides>; DOFS],
    rate: Rows<Sides>,
}

impl MpcCase {
    /// The sizes of degrees of freedom: the length, 1 rad.
    fn sizes(&self) -> Dofs<f64> {
        std::array::from_fn(|j| {
            let is_length = matches!(j, XS..THETA_S | XM..THETA_M | PSI_S | PSI_M);
            if is_length { self.length } else { 1.0 }
        })
    }

    /// The magnitudes of what is rounded: the sizes, and the angle of a hinge itself where it has made turns.
    fn inputs(&self, angles: &[f64; 2]) -> Dofs<f64> {
        let mut inputs = self.sizes();
        for (input, angle) in inputs[PHI..].iter_mut().zip(angles) {
            *input = angle.abs().max(1.0);
        }
        inputs
    }

    /// All checks at this state, if differences on 237 bits are among the oracles asked; with mutants where `proves`.
    pub fn audit(&self, settings: &Settings, proves: bool) -> Vec<Check> {
        if !settings.asks_for_everything() {
            return Vec::new();
        }
        let mut tables = self.judged();
        if let Some(planted) = settings.planted {
            tables.iter_mut().for_each(|table| planted.spoil_table(table));
        }
        let needs = |table: &ResultTable| proves || table.judge().verdict == Verdict::Wrong;
        if tables.iter().any(needs) {
            self.add_mistakes(&mut tables, &self.equations());
        }
        // Those of one state are formed in their order.
        let is_lost = |table: &&ResultTable| table.entries.iter().any(|entry| !entry.got.is_finite());
        let stage = if self.is_finite() {
            tables.iter().find(is_lost).map(|table| table.quantity.name())
        } else {
            Some("state")
        };
        let mut checks: Vec<Check> =
            tables.iter().map(|table| table.check(proves, &self.name, None)).collect();
        checks.extend(self.laws(&tables, proves));
        for check in &mut checks {
            check.name_stage(|| stage);
            check.fails_at(|| Failing::Mpc(Box::new(self.clone())));
        }
        checks
    }

    fn is_finite(&self) -> bool {
        let State { slave, master, angles, velocity, acceleration } = &self.state;
        let bodies = [slave, master].into_iter().flat_map(|body| {
            body.displacement.iter().chain(body.rotation.as_flattened()).chain([&body.flow])
        });
        let rates = velocity.iter().chain(acceleration);
        bodies.chain(angles.iter().flatten()).chain(rates).all(|x| x.is_finite())
    }

    /// The numbers at this state, and what they must be: equations, their derivatives, rates and accelerations.
    pub fn tables(&self) -> Vec<ResultTable> {
        let mut tables = self.judged();
        self.add_mistakes(&mut tables, &self.equations());
        tables
    }

    /// min(1, distance of each equation to where it has no derivative on its sheet), 0 there.
    fn nearness(&self, got: &Evaluation<f64>) -> [f64; ROWS] {
        self.constraint.margins(&self.state, got).rows.map(|margin| {
            // On its sheet ρ has derivatives at half a turn too.
            let margin = margin.filter(|margin| margin.set.class != SingularClass::BranchCut);
            nearness(margin, self.length).max(0.0)
        })
    }

    /// What the product says.
    fn said(&self) -> Evaluation<f64> {
        let tally = &mut Tally::default();
        self.constraint.evaluate(&self.state, &self.before, &self.turning, &Request::everything(2), tally)
    }

    /// The case on 237 bits, at the angles that the product takes.
    fn truth(&self, got: &Evaluation<f64>) -> WideConstraint {
        let nearness = self.nearness(got);
        let mut state = exact(&self.state);
        state.angles = got.taken.map(|angle| Some(Wide::from_f64(angle)));
        let [slave, master] = [self.state.slave.displacement, self.state.master.displacement];
        if add(self.constraint.arm(), sub(slave, master)) == [0.0; 3] {
            // Nodes that coincide on doubles, and not to their last digits: that they coincide is what is meant.
            state.slave.displacement = sub(state.master.displacement, vector::exact(self.constraint.arm()));
        }
        let given = state;
        for body in [&mut state.slave, &mut state.master] {
            body.rotation = rotation(body.rotation);
        }
        let (constraint, sizes) = (self.constraint.exact(), self.sizes());
        let truth = WideConstraint { constraint, given, state, sizes, nearness, sheet: None };
        truth.on_the_sheet(&got.residual, &self.inputs(&got.taken))
    }

    /// From which sizes on numbers of an equation are significant, where it is well-conditioned.
    fn least(
        &self,
        unit: f64,
        (value, gradient, matrix): (f64, &[f64], &[f64]),
        (sizes, inputs, nearness): (&Dofs<f64>, &Dofs<f64>, f64),
    ) -> Option<Least> {
        let s: f64 = gradient.iter().zip(sizes).map(|(x, size)| x.abs() * size).sum();
        let of = |i: usize| sizes[i / DOFS] * sizes[i % DOFS];
        let s2: f64 = matrix.iter().enumerate().map(|(i, x)| x.abs() * of(i)).sum();
        let fastest = |rates: &Dofs<f64>| {
            rates.iter().zip(sizes).fold(0.0_f64, |most, (rate, size)| most.max(rate.abs() / size))
        };
        let is_plain = inputs.iter().zip(sizes).all(|(input, size)| *input <= 30.0 * size);
        let rates = [fastest(&self.state.velocity), fastest(&self.state.acceleration)];
        (nearness >= CLEAR && is_plain).then(|| Least::of((value, s, s2), unit, rates)).flatten()
    }

    /// The numbers at this state, and what they must be; without mistakes that may explain what is wrong.
    pub fn judged(&self) -> Vec<ResultTable> {
        let got = self.said();
        let mut tables = self.tables_of(&got, &self.truth(&got), &self.equations());
        tables.retain(|table| !table.entries.is_empty());
        tables
    }

    fn tables_of(
        &self,
        got: &Evaluation<f64>,
        truth: &WideConstraint,
        equations: &[usize],
    ) -> Vec<ResultTable> {
        let kind = self.constraint.kind();
        let value = truth.values_of(truth.given);
        let first = truth.first();
        let second = truth.second();
        let [rate, acceleration] = truth.rates();
        let singular = truth.nearness.contains(&0.0).then(|| (truth.sides(), truth.hessian()));
        let mut tables: Vec<ResultTable> = Self::QUANTITIES.map(ResultTable::new).into();
        for row in equations.iter().copied() {
            let name = kind.row_name(row);
            let narrow = |of: &[Wide]| of.iter().map(|x| x.to_f64()).collect::<Vec<f64>>();
            let zero = Wide::zero();
            let value = value[row].unwrap_or(zero);
            let mut gradient: Vec<Wide> = (0..DOFS).map(|j| first[j][row].unwrap_or(zero)).collect();
            // On a singular set differences from both sides are the mean of derivatives, or of a jump.
            let singular = singular.as_ref().filter(|_| truth.nearness[row] == 0.0);
            let sides = singular.map(|(sides, _)| sides);
            if let Some(sides) = sides {
                gradient =
                    sides.first.iter().map(|along| along[row].map_or(zero, |sides| sides.least())).collect();
            }
            let matrix = second[row].clone().unwrap_or_else(|| vec![zero; DOFS * DOFS]);
            // … and differences of those are no second derivatives.
            let bent = match singular {
                Some((_, hessian)) => {
                    hessian[row].as_ref().map_or_else(Vec::new, |h| narrow(h.as_flattened()))
                }
                None => narrow(&matrix),
            };
            let scales = scales(
                value.to_f64(),
                &narrow(&gradient),
                &bent,
                (&truth.sizes, &self.inputs(&got.taken)),
                (&self.state.velocity, &self.state.acceleration),
                truth.nearness[row],
            );
            let least = self.least(
                if matches!(MpcType::row_unit(row), Unit::Length) { self.length } else { 1.0 },
                (value.to_f64(), &narrow(&gradient), &bent),
                (&truth.sizes, &self.inputs(&got.taken), truth.nearness[row]),
            );
            let value_scale = scales[0].first().copied().unwrap_or(0.0);
            let [rate, acceleration] = [&rate, &acceleration].map(|of| vec![of[row].unwrap_or(zero)]);
            let wanted = [vec![value], gradient, matrix, rate, acceleration];
            let numbers = numbers_of(got, row).into_iter().zip(wanted);
            for ((table, scales), (got, want)) in tables.iter_mut().zip(scales).zip(numbers) {
                let column = |j: usize| kind.column_name(j);
                let units = |j: usize| match j {
                    XS..THETA_S | XM..THETA_M => 0,
                    PSI_S | PSI_M => 2,
                    _ => 1,
                };
                table.rows.push(match table.quantity {
                    Quantity::FirstDerivatives => format!("∂{name}"),
                    Quantity::SecondDerivatives => format!("∂²{name}"),
                    Quantity::Rate => format!("d{name}/dt"),
                    Quantity::Acceleration => format!("d²{name}/dt²"),
                    _ => name.to_string(),
                });
                if table.quantity == Quantity::FirstDerivatives {
                    table.columns = (0..DOFS).map(|j| column(j).to_string()).collect();
                }
                for (i, ((got, want), scale)) in got.into_iter().zip(want).zip(scales).enumerate() {
                    let (x, y) = (i / DOFS, i % DOFS);
                    let row_name = table.rows.last().cloned().unwrap_or_default();
                    let (name, class) = match table.quantity {
                        Quantity::FirstDerivatives => (format!("{row_name}/∂{}", column(i)), (units(i), 0)),
                        Quantity::SecondDerivatives => {
                            let [less, more] = [units(x).min(units(y)), units(x).max(units(y))];
                            (format!("{row_name}/∂{}∂{}", column(x), column(y)), (less, more))
                        }
                        _ => (row_name, (0, 0)),
                    };
                    let class = (row / 3, class.0, class.1);
                    let mut entry = Entry::new(name, got, want, scale, class);
                    entry.error = truth.own_error(table.quantity, value_scale, row);
                    let size = match table.quantity {
                        Quantity::FirstDerivatives => truth.sizes[i],
                        Quantity::SecondDerivatives => truth.sizes[x] * truth.sizes[y],
                        _ => 1.0,
                    };
                    entry.is_demanded = least.is_some_and(|least| least.demands(table.quantity, got, size));
                    let of_entry = sides.and_then(|sides| match table.quantity {
                        Quantity::FirstDerivatives => sides.first[i][row],
                        // The equations of one vector share their singular set: none of them has a gradient there.
                        Quantity::SecondDerivatives | Quantity::Acceleration => {
                            Some(Sides::known([zero; 2]).of_none())
                        }
                        Quantity::Rate => sides.rate[row],
                        _ => None,
                    });
                    let angles = match table.quantity {
                        Quantity::FirstDerivatives => units(i) == 1,
                        Quantity::SecondDerivatives => units(x) == 1 && units(y) == 1,
                        Quantity::Rate | Quantity::Acceleration => true,
                        _ => false,
                    };
                    let is_of_sheet = angles && truth.is_undetermined(row);
                    let of_entry = of_entry.or_else(|| is_of_sheet.then(|| Sides::of_sheet(want)));
                    if let Some(sides) = of_entry {
                        entry.want = sides.nearest(got);
                        entry.sides = Some(sides).filter(|sides| sides.differ(entry.tolerance()));
                    }
                    table.entries.push(entry);
                }
            }
        }
        tables
    }
}

/// The numbers of an equation, in the order of [`MpcCase::QUANTITIES`]; what is missing is not a number.
fn numbers_of(got: &Evaluation<f64>, row: usize) -> [Vec<f64>; MpcCase::QUANTITIES.len()] {
    let one = |rows: &Rows<f64>| vec![rows[row].unwrap_or(f64::NAN)];
    let matrix = got.hessian[row].as_ref();
    [
        one(&got.residual),
        got.jacobian[row].map_or_else(|| vec![f64::NAN; DOFS], |row| row.to_vec()),
        matrix.map_or_else(|| vec![f64::NAN; DOFS * DOFS], |h| h.as_flattened().to_vec()),
        one(&got.residual_rate),
        one(&got.residual_acceleration),
    ]
}

/// The same state on 237-bit numbers, from the same doubles.
pub fn exact(state: &State<f64>) -> State<Wide> {
    let body = |body: &Body<f64>| Body {
        displacement: vector::exact(body.displacement),
        rotation: vector::exact_matrix(&body.rotation),
        flow: Wide::from_f64(body.flow),
    };
    State {
        slave: body(&state.slave),
        master: body(&state.master),
        angles: state.angles.map(|angle| angle.map(Wide::from_f64)),
        velocity: state.velocity.map(Wide::from_f64),
        acceleration: state.acceleration.map(Wide::from_f64),
    }
}

/// The state with its degrees of freedom moved by finite amounts: u + δx, exp(δθ^) C, Ψ + δΨ, φ + δφ.
/// Written apart from the product's variations.
pub fn moved<R: Differentiable>(state: &State<R>, by: &Dofs<R>) -> State<R> {
    let body = |body: &Body<R>, at: usize| {
        let turned = [by[at + 3], by[at + 4], by[at + 5]];
        Body {
            displacement: add(body.displacement, [by[at], by[at + 1], by[at + 2]]),
            rotation: if is_still(&turned) { body.rotation } else { product(&exp(turned), &body.rotation) },
            flow: body.flow + by[at + 6],
        }
    };
    State {
        slave: body(&state.slave, XS),
        master: body(&state.master, XM),
        angles: [0, 1].map(|i| state.angles[i].map(|angle| angle + by[PHI + i])),
        ..*state
    }
}

impl WideConstraint {
    fn evaluate(&self, state: &State<Wide>, request: &Request) -> Evaluation<Wide> {
        let zero = Turns { turns: Wide::zero(), principal: Wide::zero() };
        self.constraint.evaluate(state, &[zero; 2], &Turning::none(), request, &mut Tally::default())
    }

    fn values_of(&self, state: State<Wide>) -> Rows<Wide> {
        let rows = self.evaluate(&state, &Request::new(&[Output::RES], [true; 6], 0)).residual;
        self.sheet.map_or(rows, |sheet| sheet.of(rows))
    }

    fn values(&self, by: &Dofs<Wide>) -> Rows<Wide> {
        self.values_of(moved(&self.state, by))
    }

    /// The distance to the nearest of the singular sets that the state is not on.
    fn near(&self) -> f64 {
        self.nearness.into_iter().filter(|near| *near > 0.0).fold(1.0, f64::min)
    }

    /// What exists of the equations on a singular set: derivatives from both sides by each degree of freedom and along the velocities.
    fn sides(&self) -> BothSides {
        let still = self.values(&[Wide::zero(); DOFS]);
        let of = |along: &dyn Fn(Wide) -> Dofs<Wide>, size: f64, scale: &dyn Fn(usize) -> f64| {
            let fine = Wide::from_f64(FIRST_STEP * size);
            let steps = [fine / Wide::integer(2), fine, Wide::from_f64(Sides::COARSE * size)];
            let moved = steps.map(|h| [-h, h].map(|h| self.values(&along(h))));
            std::array::from_fn(|row| {
                let of_row = moved.each_ref().map(|both| both.each_ref().map(|values| values[row]));
                Sides::along(still[row]?, &of_row, &steps, scale(row))
            })
        };
        let extent = |row: usize| match MpcType::row_unit(row) {
            Unit::Length => self.sizes[XS],
            _ => 1.0,
        };
        let first = std::array::from_fn(|j| {
            let along = |h: Wide| {
                let mut by = [Wide::zero(); DOFS];
                by[j] = h;
                by
            };
            of(&along, self.sizes[j], &|row| extent(row) / self.sizes[j])
        });
        let along = |t: Wide| self.state.velocity.map(|velocity| velocity * t);
        let time = self.time();
        BothSides { first, rate: of(&along, time, &|row| extent(row) / time) }
    }

    /// How far differences are off by rounding on 237 bits, of an equation with such a scale: next to nothing but very close to singular
    /// sets, and where a tolerance is zero.
    fn own_error(&self, quantity: Quantity, scale: f64, row: usize) -> f64 {
        let extent = if row < 3 { self.sizes[XS] } else { 1.0 };
        let noise = NOISE * scale.max(extent);
        let [first, second] = self.times();
        match quantity {
            Quantity::Rate => noise / first,
            Quantity::Acceleration => 4.0 * noise / second / second,
            _ => 0.0,
        }
    }

    /// Second derivatives by dual numbers: what the product says on 237 bits.
    fn hessian(&self) -> Rows<Box<[Dofs<Wide>; DOFS]>> {
        self.evaluate(&self.state, &Request::new(&[], [true; 6], 2)).hessian
    }

    fn around(&self, j: usize) -> ([Dofs<Wide>; 2], Wide) {
        let h = Wide::from_f64(FIRST_STEP * self.near() * self.sizes[j]);
        let along = |h: Wide| {
            let mut by = [Wide::zero(); DOFS];
            by[j] = h;
            by
        };
        ([along(h), along(-h)], h + h)
    }

    /// By degree of freedom, the differences of the equations.
    fn first(&self) -> [Rows<Wide>; DOFS] {
        std::array::from_fn(|j| {
            let ([plus, minus], width) = self.around(j);
            let (plus, minus) = (self.values(&plus), self.values(&minus));
            std::array::from_fn(|row| Some((plus[row]? - minus[row]?) / width))
        })
    }

    /// Second differences of the equations, as those of connectors are taken: values alone, two rotations of one node at once as
    /// exp((h_j e_j + h_k e_k)^).
    fn second(&self) -> Rows<Vec<Wide>> {
        let bodies = [&self.state.slave.displacement, &self.state.master.displacement];
        let (step, directions) = differences::second(self.near(), differences::far(bodies, self.sizes[XS]));
        let step = |j: usize| Wide::from_f64(step * self.sizes[j]);
        let values = |j: usize, k: usize, sign: i32| {
            let mut by = [Wide::zero(); DOFS];
            for i in [j, k] {
                by[i] = step(i) * Wide::integer(sign);
            }
            self.values(&by)
        };
        let still = self.values(&[Wide::zero(); DOFS]);
        let alone: [[Rows<Wide>; 2]; DOFS] = std::array::from_fn(|j| [1, -1].map(|sign| values(j, j, sign)));
        let mut found: Rows<Vec<Wide>> = still.map(|row| row.map(|_| vec![Wide::zero(); DOFS * DOFS]));
        for j in 0..DOFS {
            for k in j..DOFS {
                let ahead = if j == k { alone[j][0] } else { values(j, k, 1) };
                let behind = match directions {
                    _ if j == k => Some(alone[j][1]),
                    Directions::Ahead => None,
                    _ => Some(values(j, k, -1)),
                };
                for (row, matrix) in found.iter_mut().enumerate() {
                    let (Some(matrix), Some(f), Some(ahead)) = (matrix, still[row], ahead[row]) else {
                        continue;
                    };
                    // By how much an equation changes ahead, and with what it changes behind where that is taken too.
                    let change = |[ahead, behind]: [Option<Wide>; 2]| {
                        let behind = behind.map_or_else(Wide::zero, |behind| behind - f);
                        Some(ahead? - f + behind)
                    };
                    let change_of = |i: usize| {
                        let [ahead, back] = alone[i].each_ref().map(|rows| rows[row]);
                        change([ahead, back.filter(|_| behind.is_some())])
                    };
                    let both = change([Some(ahead), behind.and_then(|rows| rows[row])]);
                    let (Some(both), Some(x), Some(y)) = (both, change_of(j), change_of(k)) else { continue };
                    let area = step(j) * step(k);
                    let entry = match directions {
                        _ if j == k => both / area,
                        Directions::Ahead => (both - x - y) / area,
                        _ => (both - x - y) / (area + area),
                    };
                    (matrix[j * DOFS + k], matrix[k * DOFS + j]) = (entry, entry);
                }
            }
        }
        found
    }

    /// The values after a time along q(t) = q̇ t + q̈ t²/2.
    fn after(&self, t: Wide) -> Rows<Wide> {
        self.values(&differences::carried_on(&self.state.velocity, &self.state.acceleration, t))
    }

    /// Rates and accelerations, by differences along that.
    fn rates(&self) -> [Rows<Wide>; 2] {
        let [first, second] = self.times();
        let h = Wide::from_f64(first);
        let (near, behind) = (self.after(h), self.after(-h));
        [
            std::array::from_fn(|row| Some((near[row]? - behind[row]?) / (h + h))),
            self.acceleration_at(Wide::from_f64(second)),
        ]
    }

    /// Accelerations with a step in time.
    fn acceleration_at(&self, h: Wide) -> Rows<Wide> {
        let still = self.values(&[Wide::zero(); DOFS]);
        let (ahead, behind) = (self.after(h), self.after(-h));
        std::array::from_fn(|row| {
            Some(differences::acceleration([behind[row]?, still[row]?, ahead[row]?], h))
        })
    }

    /// The time in which the fastest degree of freedom moves by its size.
    fn time(&self) -> f64 {
        let fastest = self.speed();
        if fastest > 0.0 { 1.0 / fastest } else { 1.0 }
    }

    /// The speed of the fastest degree of freedom, in its sizes.
    fn speed(&self) -> f64 {
        differences::speed(&self.state.velocity, &self.state.acceleration, |j| self.sizes[j])
    }

    /// The steps of first and second differences in time.
    fn times(&self) -> [f64; 2] {
        differences::times(self.near(), self.speed())
    }
}
