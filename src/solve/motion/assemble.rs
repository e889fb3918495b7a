//! What holds at an instant: inertia, loads, the forces that follow from motions, and every equation.

use crate::fault::{Fault, has};
use crate::motion::mechanism::{Carry, Hold, Mechanism, TableOf};
use crate::motion::mode::{Does, Modes};
use crate::motion::rows::{Assembled, Beginnings, Carried, Instant, Line, Lines, Now, Owner, Row, Trouble};
use crate::motion::state::{DOFS, Pose, WORKS};
use crate::number::Number;
use pintle_kinematics::connector::{Branch, Increment, Output, Request, State as PairState, Tally, Turns};
use pintle_kinematics::force::Want;
use pintle_kinematics::mpc;
use pintle_kinematics::node::{DOFS as PAIR, Node, Pair};
use pintle_kinematics::relation::{Point, place_of};
use pintle_kinematics::scalar::elementary::{exp_m1, norm};
use pintle_kinematics::scalar::{Scalar, Seeded};
use pintle_kinematics::so3;
use pintle_kinematics::vector;
use pintle_kinematics::vector::{Vector, add, apply, cross, dot, sub};
use pintle_model::behavior::drive::{Drive, Prescribed};
use pintle_model::behavior::friction::FLOW;
use pintle_model::behavior::{Conditions, Motion, Unknown};

fn unknown(what: &str, why: Unknown) -> Trouble {
    Trouble::Unknown(what.to_string(), why.in_words().to_string())
}

impl<R: Number> Mechanism<R> {
    /// Value, rate and acceleration of what is prescribed: those that are.
    fn prescribed(
        &self,
        drive: &Drive,
        (step, time): (usize, R),
        beginning: impl Fn(usize) -> Option<f64>,
        what: impl Fn() -> String,
    ) -> Result<Option<[Option<R>; 3]>, Trouble> {
        let (zero, one) = (R::ZERO, R::integer(1));
        let moving = R::moving(time, one, zero);
        let real = |x: R::Time| Scalar::real(x);
        Ok(match drive.within(&self.schedule, step, moving, beginning) {
            None => None,
            Some(Prescribed::Displacement(x)) => {
                let (first, second) = R::rates(x);
                Some([Some(real(x)), Some(first), Some(second)])
            }
            Some(Prescribed::Velocity(x)) => Some([None, Some(real(x)), Some(R::rates(x).0)]),
            Some(Prescribed::Acceleration(x)) => Some([None, None, Some(real(x))]),
            Some(Prescribed::Unknown(_, why)) => return Err(unknown(&what(), why)),
        })
    }

    fn load(&self, drive: &Drive, (step, time): (usize, R), what: impl Fn() -> String) -> Result<R, Trouble> {
        match drive.within(&self.schedule, step, time, |_| None) {
            None => Ok(R::ZERO),
            Some(Prescribed::Displacement(load)) => Ok(load),
            Some(Prescribed::Unknown(_, why)) => Err(unknown(&what(), why)),
            Some(Prescribed::Velocity(_) | Prescribed::Acceleration(_)) => {
                Err(unknown(&what(), Unknown::External))
            }
        }
    }

    /// What holds at an instant, with the equations of the modes.
    pub(crate) fn assemble(
        &self,
        at: &Instant<'_, R>,
        modes: &Modes<R>,
        beginnings: &Beginnings,
    ) -> Result<Assembled<R>, Trouble> {
        let mut all = self.loaded(at)?;
        for index in 0..self.joints.len() {
            self.joint(index, at, modes, beginnings, &mut all)?;
        }
        self.rings(modes, &mut all)?;
        self.constraints(at, &mut all);
        self.bounds(at, beginnings, &mut all)?;
        self.springs(at, modes, &mut all)?;
        Ok(all)
    }

    /// Bodies and their loads alone.
    pub(crate) fn loaded(&self, at: &Instant<'_, R>) -> Result<Assembled<R>, Trouble> {
        let zero = R::ZERO;
        let count = self.bodies.len();
        let mut all = Assembled {
            lines: Lines::with_capacity(
                4 * PAIR * (self.joints.len() + self.mpcs.len()),
                self.carried_at(at),
            ),
            rows: Vec::with_capacity(6 * (self.joints.len() + self.mpcs.len())),
            joints: Vec::with_capacity(self.joints.len()),
            masses: self.bodies.iter().map(|body| body.mass).collect(),
            inertias: Vec::with_capacity(count),
            flows: vec![zero; count],
            applied: vec![zero; DOFS * count],
            powers: [zero; WORKS],
            rates: at.rates.to_vec(),
            springs: Vec::with_capacity(self.springs.len()),
            slips: at.sums.iter().skip(WORKS).copied().collect(),
        };
        self.loads(at, &mut all)?;
        Ok(all)
    }

    /// The nodes that are carried, as they are now.
    fn carried_at(&self, at: &Instant<'_, R>) -> Vec<Option<Carried<R>>> {
        let now = |carry: &Option<Carry<R>>| {
            let Carry { by, arm, turns } = (*carry)?;
            let rates = at.rates[by];
            let (arm, spin) = (apply(&at.poses[by].rotation, arm), [rates[3], rates[4], rates[5]]);
            Some(Carried { by, arm, turns, swept: cross(spin, cross(spin, arm)) })
        };
        self.carried.iter().map(now).collect()
    }

    /// Inertia and loads.
    fn loads(&self, at: &Instant<'_, R>, all: &mut Assembled<R>) -> Result<(), Trouble> {
        let zero = R::ZERO;
        let when = (at.step, at.time);
        let mut fields = Vec::with_capacity(self.gravities.len());
        for gravity in &self.gravities {
            let mut field = [zero; 3];
            for (k, drive) in gravity {
                if let Some(entry) = field.get_mut(*k) {
                    *entry = self.load(drive, when, || "gravity".to_string())?;
                }
            }
            fields.push(field);
        }
        for (n, (body, (pose, rates))) in self.bodies.iter().zip(at.poses.iter().zip(at.rates)).enumerate() {
            let inertia = vector::product(
                &vector::product(&pose.rotation, &body.inertia),
                &vector::transpose(&pose.rotation),
            );
            let spin = [rates[3], rates[4], rates[5]];
            let gyroscopic = cross(spin, apply(&inertia, spin));
            let gyroscopic = if has(Fault::GyroscopicLeftOut) { [zero; 3] } else { gyroscopic };
            let mut force = [zero; 6];
            for (k, drive) in &body.loads {
                let load = self.load(drive, when, || format!("load on node {}", body.label))?;
                let axis = body.axes[k % 3];
                for i in 0..3 {
                    force[k / 3 * 3 + i] = force[k / 3 * 3 + i] + load * axis[i];
                }
            }
            for (index, mass) in &body.weights {
                for i in 0..3 {
                    force[i] = force[i] + *mass * fields[*index][i];
                }
            }
            for (k, force) in force.into_iter().enumerate() {
                all.powers[0] = all.powers[0] + force * rates[k];
                all.act(DOFS * n + k, force - if k < 3 { zero } else { gyroscopic[k - 3] });
            }
            all.inertias.push(inertia);
        }
        Ok(())
    }

    /// The nodes of a connector with their velocities.
    pub(crate) fn pair_state(&self, index: usize, at: &Instant<'_, R>) -> PairState<R> {
        let zero = R::ZERO;
        let joint = &self.joints[index];
        let still = [zero; DOFS];
        let node = |end: usize, initial: &Node<R>| match joint.ends[end].and_then(|n| at.poses.get(n)) {
            None => *initial,
            Some(pose) => Node {
                displacement: pose.displacement,
                triad: vector::product(&pose.rotation, &initial.triad),
                flow: pose.flow,
            },
        };
        let rate = |end: usize| joint.ends[end].and_then(|n| at.rates.get(n)).copied().unwrap_or(still);
        let mut velocity = [zero; PAIR];
        velocity[..DOFS].copy_from_slice(&rate(0));
        velocity[DOFS..].copy_from_slice(&rate(1));
        PairState {
            pair: Pair {
                reference: joint.initial.reference,
                a: node(0, &joint.initial.a),
                b: node(1, &joint.initial.b),
            },
            velocity,
            acceleration: [zero; PAIR],
        }
    }

    /// CP, CU and CV of the components of a connector that move freely.
    pub(crate) fn free_motion(&self, index: usize, at: &Instant<'_, R>, branch: Branch<R>) -> [[R; 6]; 3] {
        let joint = &self.joints[index];
        let mut request = Request::nothing(1);
        for output in [Output::CP, Output::CU, Output::CV] {
            request.add(output, joint.free);
        }
        let state = self.pair_state(index, at);
        let found = joint.connector.evaluate_on(&state, branch, &request, &mut Tally::default());
        [found.position, found.displacement, found.velocity].map(|of| of.map(|x| x.unwrap_or(R::ZERO)))
    }

    /// A connector: its equations, and the forces that follow from its motion.
    fn joint(
        &self,
        index: usize,
        at: &Instant<'_, R>,
        modes: &Modes<R>,
        beginnings: &Beginnings,
        all: &mut Assembled<R>,
    ) -> Result<(), Trouble> {
        let zero = R::ZERO;
        let joint = &self.joints[index];
        let state = self.pair_state(index, at);
        let turned =
            |end: usize| joint.ends[end].and_then(|n| at.turned.get(n)).copied().unwrap_or([zero; 3]);
        let rotation = [0, 1].map(turned);
        let increment = Increment { rotation, whole_turns: whole_turns(rotation), flow: [zero; 2] };
        let mut tally = Tally::default();
        let followed = [0, 1, 2, 3, 4, 5].map(|k| joint.wanted[k] || joint.free[k]);
        let branch = joint.connector.follow(&state, &increment, &at.branches[index], followed, &mut tally);
        let mut request = Request::nothing(1);
        let free = [0, 1, 2, 3, 4, 5].map(|k| joint.wanted[k] && !joint.constrained[k]);
        let held = [0, 1, 2, 3, 4, 5].map(|k| joint.wanted[k] && joint.constrained[k]);
        for output in [Output::CP, Output::CU, Output::CCU, Output::CV, Output::CA] {
            request.add(output, free);
        }
        for output in [Output::RES, Output::RESV, Output::RESA, Output::CP] {
            request.add(output, held);
        }
        let evaluation = joint.connector.evaluate_on(&state, branch, &request, &mut tally);
        let forces = joint.connector.force_rows_after(
            &state,
            &branch,
            joint.wanted,
            Want::default(),
            Some(&evaluation),
            &mut tally,
        );
        let lines = &mut all.lines;
        let (mut rows, mut columns) = ([Line::default(); 6], [Line::default(); 6]);
        let mut swept = [zero; 6];
        for k in (0..6).filter(|k| joint.wanted[*k]) {
            let mut unit = [None; 6];
            unit[k] = Some(R::integer(1));
            columns[k] = lines.add_pair(joint.ends, &forces.nodal(&unit)).0;
            if let Some(row) = &evaluation.jacobian[k] {
                (rows[k], swept[k]) = lines.add_pair(joint.ends, row);
            }
        }
        let value = |of: [Option<R>; 6]| of.map(|x| x.unwrap_or(zero));
        let mut now = Now {
            position: value(evaluation.position),
            displacement: value(evaluation.displacement),
            motion: value(evaluation.constitutive),
            velocity: value(evaluation.velocity),
            bias: std::array::from_fn(|k| evaluation.acceleration[k].unwrap_or(zero) + swept[k]),
            elastic: [zero; 6],
            viscous: [zero; 6],
            load: [zero; 6],
            held: [zero; 6],
            columns,
            rows,
            branch,
        };
        let behavior = &joint.behavior.behavior;
        let motion = Motion { position: now.position, constitutive: now.motion, velocity: now.velocity };
        let conditions = Conditions::default();
        let mut elastic = behavior.elasticity.forces(&motion, &conditions);
        let mut viscous = behavior.damping.forces(&motion, &conditions);
        for (table, span) in self.tables.iter().zip(&modes.spans) {
            let TableOf::Joint(of, k) = table.of else { continue };
            let x = if table.is_rate { now.velocity[k] } else { now.motion[k] };
            let Some(inside) = table.inside(*span, x).filter(|_| of == index) else { continue };
            // Beyond its span a table goes on along it, to the end of the step.
            let mut moved = Motion {
                position: motion.position.map(R::Gradient::<1>::from_real),
                constitutive: motion.constitutive.map(R::Gradient::<1>::from_real),
                velocity: motion.velocity.map(R::Gradient::<1>::from_real),
            };
            let seeded = R::Gradient::<1>::seed(inside, 0);
            let forces = if table.is_rate {
                moved.velocity[k] = seeded;
                behavior.damping.forces(&moved, &conditions)
            } else {
                moved.constitutive[k] = seeded;
                behavior.elasticity.forces(&moved, &conditions)
            };
            let line = forces.value[k].map(|force| force.real() + force.gradient()[0] * (x - inside));
            if table.is_rate { viscous.value[k] = line } else { elastic.value[k] = line }
        }
        for (s, (slider, mode)) in self.sliders.iter().zip(&modes.frictions).enumerate() {
            let (Does::Stretches(slack), Some(stiffness)) = (&mode.does, self.stiffness.get(s)) else {
                continue;
            };
            let acts = |k: usize| slider.joint == index && !modes.has_failed(index, k);
            for (k, radius) in slider.components.iter().filter(|(k, _)| acts(*k)) {
                let radius = R::from_f64(*radius);
                now.held[*k] = now.held[*k] + *stiffness * radius * radius * (now.position[*k] - slack[*k]);
            }
        }
        let when = (at.step, at.time);
        let is_belt = joint.connector.connection().is_belt();
        for k in (0..6).filter(|k| !modes.has_failed(index, *k)) {
            let why = elastic.unknown[k].filter(|_| !joint.rigid[k]).or(viscous.unknown[k]);
            if let Some(why) = why {
                return Err(unknown(&joint.title, why));
            }
            now.elastic[k] = elastic.value[k].unwrap_or(zero);
            now.viscous[k] = viscous.value[k].unwrap_or(zero);
            if let Some(drive) = &joint.behavior.drives.loads[k] {
                now.load[k] = self.load(drive, when, || joint.title.clone())?;
            }
            let known = now.elastic[k] + now.viscous[k] + now.held[k] - now.load[k];
            for (dof, entry) in all.lines.of(now.columns[k]) {
                all.applied[*dof] = all.applied[*dof] - known * *entry;
            }
            all.powers[0] = all.powers[0] + now.load[k] * now.velocity[k];
            all.powers[1] = all.powers[1] + now.viscous[k] * now.velocity[k];
            // The force of a belt on its flow is not that of a potential: what it takes counts as stored.
            let rate = match is_belt {
                true => all
                    .lines
                    .of(now.columns[k])
                    .iter()
                    .fold(zero, |sum, (dof, entry)| sum + *entry * at.rates[dof / DOFS][dof % DOFS]),
                false => now.velocity[k],
            };
            all.powers[2] = all.powers[2] + (now.elastic[k] + now.held[k]) * rate;
        }
        for k in (0..6).filter(|k| joint.wanted[*k]) {
            let hold = self.hold(modes, index, k);
            if matches!(hold, Hold::Failed) {
                continue;
            }
            let owner = Owner::Joint(index, k);
            let (force, coefficients) = (now.columns[k], now.rows[k]);
            // A one-form is known by its rate: steps are too long for sums along them.
            let is_one_form = joint.connector.position_measure(k).is_some_and(|of| of.is_one_form());
            if joint.constrained[k] {
                all.rows.push(Row {
                    owner,
                    coefficients,
                    force: Some(force),
                    residual: Some(evaluation.residual[k].unwrap_or(zero)).filter(|_| !is_one_form),
                    rate: Some(evaluation.residual_rate[k].unwrap_or(zero)),
                    bias: evaluation.residual_acceleration[k].unwrap_or(zero) + swept[k],
                    driven: zero,
                });
                continue;
            }
            let given = match &joint.behavior.drives.motions[k] {
                Some(drive) if !matches!(hold, Hold::Locked(_)) => {
                    self.prescribed(drive, when, beginnings.joint(index, k), || joint.title.clone())?
                }
                _ => None,
            };
            let [position, rate, acceleration] = match (given, hold) {
                (Some([position, rate, acceleration]), _) => {
                    [position.map(|p| now.displacement[k] - p), rate, acceleration]
                }
                (None, Hold::Locked(at)) => [Some(now.position[k] - at), Some(zero), Some(zero)],
                (None, _) if joint.rigid[k] => [Some(now.motion[k]), Some(zero), Some(zero)],
                (None, Hold::Stopped(at) | Hold::Stuck(at)) => {
                    [Some(now.position[k] - at), Some(zero), Some(zero)]
                }
                (None, Hold::Nothing | Hold::Failed) => continue,
            };
            all.rows.push(Row {
                owner,
                coefficients,
                force: Some(force),
                residual: position.filter(|_| !is_one_form),
                rate: rate.map(|rate| now.velocity[k] - rate),
                bias: now.bias[k] - acceleration.unwrap_or(zero),
                driven: rate.unwrap_or(now.velocity[k]),
            });
        }
        all.joints.push(now);
        Ok(())
    }

    /// Belts that slip over their rings: what has no inertia goes on so that the tensions keep their ratio, max(T1, T2) = min(T1, T2) exp(μ α).
    fn rings(&self, modes: &Modes<R>, all: &mut Assembled<R>) -> Result<(), Trouble> {
        let (zero, one) = (R::ZERO, R::integer(1));
        if self.is_still {
            return Ok(());
        }
        for (s, (slider, mode)) in self.sliders.iter().zip(&modes.frictions).enumerate() {
            let (Some((next, angle)), Does::Slips(along)) = (slider.ring, &mode.does) else { continue };
            let joint = &self.joints[slider.joint];
            let (Some(belt), Some(ring)) = (self.belt(slider), joint.ends[1]) else { continue };
            let flow = DOFS * ring + DOFS - 1;
            let refused = |why: &str| Err(Trouble::Unknown(joint.title.clone(), why.to_string()));
            let tables = self
                .tables
                .iter()
                .any(|table| matches!(table.of, TableOf::Joint(of, 0) if of == slider.joint || of == next));
            let damps = |of: usize| self.joints[of].behavior.behavior.damping.components()[0];
            if tables || damps(slider.joint) || damps(next) {
                return refused(
                    "a belt with damping or a table of forces that slips over a ring is not solved in a dynamic step",
                );
            }
            let tension = |of: usize| all.joints[of].elastic[0];
            let least = if tension(next).less(tension(slider.joint)) { next } else { slider.joint };
            let seeds = [R::Gradient::<2>::seed(zero, 0), R::Gradient::<2>::seed(tension(least), 1)];
            let mu = belt.coefficient.at(seeds[0], seeds[1], &Conditions::default());
            if belt.maximum.is_some() || mu.gradient().iter().any(|slope| !slope.is_nothing()) {
                return refused(
                    "a belt whose friction has a largest force, or depends on slip or tension, is not solved in a dynamic step",
                );
            }
            let entry = |of: Line| {
                let mut entries = all.lines.of(of).iter();
                entries.find(|(dof, _)| *dof == flow).map_or(zero, |(_, x)| *x)
            };
            // Which of the two pulls: the flow is in balance, T1 e1 + T2 e2 + n T_f e = 0 with e2 = −e1.
            let now = &all.joints[slider.joint];
            let along = if has(Fault::CapstanTurned) { -along[FLOW] } else { along[FLOW] };
            let pulls = along * entry(now.columns[FLOW]) * entry(now.columns[0]);
            let ratio = one + exp_m1(mu.real() * R::from_f64(angle));
            let (first, second) = if zero.less(pulls) { (-ratio, one) } else { (one, -ratio) };
            let mut row = Row {
                owner: Owner::Ring(s),
                coefficients: Line::default(),
                force: None,
                residual: Some(zero),
                rate: Some(zero),
                bias: zero,
                driven: zero,
            };
            let mut coefficients: Vec<(usize, R)> = Vec::new();
            let mut stiffness = zero;
            for (of, weight) in [(slider.joint, first), (next, second)] {
                let Some([value, rate, bias, slope]) = self.tension(of, all) else { continue };
                let plus = |sum: Option<R>, x: R| sum.map(|sum| sum + weight * x);
                (row.residual, row.rate) = (plus(row.residual, value), plus(row.rate, rate));
                row.bias = row.bias + weight * bias;
                let along = all.joints[of].rows[0];
                coefficients.extend(all.lines.of(along).iter().map(|(dof, x)| (*dof, weight * slope * *x)));
                stiffness = stiffness + (slope * entry(along)).magnitude();
            }
            // As a length of belt.
            let scale = stiffness.reciprocal_or_zero();
            row.coefficients = all.lines.add(coefficients.into_iter().map(|(dof, x)| (dof, x * scale)));
            row.force = Some(all.lines.add([(flow, one)]));
            (row.residual, row.rate) = (row.residual.map(|x| x * scale), row.rate.map(|x| x * scale));
            row.bias = row.bias * scale;
            all.rows.push(row);
        }
        Ok(())
    }

    /// The tension of a belt, its rate, the part of its second rate that accelerations do not enter, and its slope over the elongation.
    fn tension(&self, joint: usize, all: &Assembled<R>) -> Option<[R; 4]> {
        let now = &all.joints[joint];
        let elasticity = &self.joints[joint].behavior.behavior.elasticity;
        let conditions = Conditions::default();
        let moving = |x: &[R; 6]| -> [R::Time; 6] {
            std::array::from_fn(|k| R::moving(x[k], now.velocity[k], now.bias[k]))
        };
        let velocity = std::array::from_fn(|k| R::moving(now.velocity[k], now.bias[k], R::ZERO));
        let motion = Motion { position: moving(&now.position), constitutive: moving(&now.motion), velocity };
        let force = elasticity.forces(&motion, &conditions).value[0]?;
        let (rate, bias) = R::rates(force);
        let constant = |x: &[R; 6]| x.map(R::Gradient::<1>::from_real);
        let mut constitutive = constant(&now.motion);
        constitutive[0] = R::Gradient::<1>::seed(now.motion[0], 0);
        let motion =
            Motion { position: constant(&now.position), constitutive, velocity: constant(&now.velocity) };
        let slope = elasticity.forces(&motion, &conditions).value[0]?.gradient()[0];
        Some([Scalar::real(force), rate, bias, slope])
    }

    /// Multi-point constraints and relations.
    fn constraints(&self, at: &Instant<'_, R>, all: &mut Assembled<R>) {
        let zero = R::ZERO;
        let mut tally = Tally::default();
        let mut request = Request::nothing(1);
        for output in [Output::RES, Output::RESV, Output::RESA] {
            request.add(output, [true; 6]);
        }
        let none = Turns { turns: zero, principal: zero };
        for (index, (_, constraint, nodes)) in self.mpcs.iter().enumerate() {
            let pose = |place: usize| nodes.get(place).and_then(|n| at.poses.get(*n)).copied();
            let rate = |place: usize| nodes.get(place).and_then(|n| at.rates.get(*n)).copied();
            let body = |place: usize| {
                let pose = pose(place).unwrap_or_else(Pose::at_rest);
                mpc::Body { displacement: pose.displacement, rotation: pose.rotation, flow: pose.flow }
            };
            let mut velocity = [zero; mpc::DOFS];
            let mut angles = [None; 2];
            for (j, entry) in velocity.iter_mut().enumerate() {
                let (place, number) = mpc::MpcType::column_dof(j);
                *entry = rate(place).map_or(zero, |rates| rates[place_of(number)]);
            }
            for (i, angle) in angles.iter_mut().enumerate() {
                *angle = pose(2 + i).map(|pose| pose.vector[2]);
            }
            if constraint.kind() == mpc::MpcType::Beam {
                self.beam(index, (body(0), body(1)), &velocity, all);
                continue;
            }
            let state = mpc::State {
                slave: body(0),
                master: body(1),
                angles,
                velocity,
                acceleration: [zero; mpc::DOFS],
            };
            let found = constraint.evaluate(&state, &[none; 2], &mpc::Turning::none(), &request, &mut tally);
            let is_there = constraint.rows();
            for row in (0..is_there.len()).filter(|row| is_there[*row]) {
                let Some(gradient) = &found.jacobian[row] else { continue };
                let entries = gradient.iter().enumerate().filter(|(_, entry)| zero.less(entry.magnitude()));
                let (coefficients, swept) = all.lines.add_row(entries.filter_map(|(j, entry)| {
                    let (place, number) = mpc::MpcType::column_dof(j);
                    Some((DOFS * nodes.get(place)? + place_of(number), *entry))
                }));
                all.rows.push(Row {
                    owner: Owner::Mpc(index, row),
                    force: None,
                    coefficients,
                    residual: found.residual[row],
                    rate: found.residual_rate[row],
                    bias: found.residual_acceleration[row].unwrap_or(zero) + swept,
                    driven: zero,
                });
            }
        }
        for (index, (_, relation, nodes)) in self.relations.iter().enumerate() {
            let points: Vec<Point<R>> = nodes.iter().map(|n| point(at, *n)).collect();
            for (number, row) in relation.evaluate(&points, &request, &mut tally).into_iter().enumerate() {
                let (coefficients, swept) =
                    all.lines.add_row(spread(relation.columns(), &row.gradient, nodes));
                all.rows.push(Row {
                    owner: Owner::Relation(index, number),
                    force: None,
                    coefficients,
                    residual: Some(row.residual),
                    rate: row.rate,
                    bias: row.acceleration.unwrap_or(zero) + swept,
                    driven: zero,
                });
            }
        }
    }

    /// A beam: S is carried by M. Its rotations are equal throughout where they begin so, and so are their rates. The rows of a constraint
    /// of any kind ([`mpc::Constraint::evaluate`]) are right here too, and dear: Bricard's mechanism then takes 1.6 times as long.
    fn beam(
        &self,
        index: usize,
        (slave, master): (mpc::Body<R>, mpc::Body<R>),
        velocity: &mpc::Dofs<R>,
        all: &mut Assembled<R>,
    ) {
        let (zero, one) = (R::ZERO, R::integer(1));
        let (_, constraint, nodes) = &self.mpcs[index];
        let [Some(s), Some(m)] = [nodes.first(), nodes.get(1)] else { return };
        let part = |at: usize| [velocity[at], velocity[at + 1], velocity[at + 2]];
        let (spin, of_slave) = (part(mpc::THETA_M), part(mpc::THETA_S));
        let arm = apply(&master.rotation, constraint.arm());
        let swept = cross(spin, arm);
        let apart = sub(slave.displacement, master.displacement);
        let residual = sub(add(constraint.arm(), apart), arm);
        let rate = sub(sub(part(mpc::XS), part(mpc::XM)), swept);
        let toward = cross(spin, swept);
        let turned = vector::product(&slave.rotation, &vector::transpose(&master.rotation));
        let rho = so3::log(&turned);
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            // −(θ × r)_i = r_j θ_k − r_k θ_j.
            let entries = [
                (DOFS * s + i, one),
                (DOFS * m + i, -one),
                (DOFS * m + 3 + k, arm[j]),
                (DOFS * m + 3 + j, -arm[k]),
            ];
            let entries = entries.into_iter().filter(|(_, entry)| zero.less(entry.magnitude()));
            let (coefficients, swept) = all.lines.add_row(entries);
            all.rows.push(Row {
                owner: Owner::Mpc(index, i),
                force: None,
                coefficients,
                residual: Some(residual[i]),
                rate: Some(rate[i]),
                bias: swept - toward[i],
                driven: zero,
            });
        }
        for i in 0..3 {
            let coefficients = all.lines.add([(DOFS * s + 3 + i, one), (DOFS * m + 3 + i, -one)]);
            all.rows.push(Row {
                owner: Owner::Mpc(index, 3 + i),
                force: None,
                coefficients,
                residual: Some(rho[i]),
                rate: Some(of_slave[i] - spin[i]),
                bias: zero,
                driven: zero,
            });
        }
    }

    /// Boundary conditions that move, or stand across the axes.
    fn bounds(
        &self,
        at: &Instant<'_, R>,
        beginnings: &Beginnings,
        all: &mut Assembled<R>,
    ) -> Result<(), Trouble> {
        let zero = R::ZERO;
        let mut request = Request::nothing(1);
        for output in [Output::RES, Output::RESV, Output::RESA] {
            request.add(output, [true; 6]);
        }
        for (index, bound) in self.bounds.iter().enumerate() {
            let what = || format!("boundary condition of node {}", self.bodies[bound.node].label);
            let beginning = beginnings.node(bound.node, bound.number);
            let Some([position, rate, acceleration]) =
                self.prescribed(&bound.drive, (at.step, at.time), beginning, what)?
            else {
                continue;
            };
            let points = [point(at, bound.node)];
            let found = bound.relation.evaluate(&points, &request, &mut Tally::default());
            let Some(row) = found.into_iter().next() else { continue };
            let coefficients = all.lines.add(spread(bound.relation.columns(), &row.gradient, &[bound.node]));
            all.rows.push(Row {
                owner: Owner::Bound(index),
                force: None,
                coefficients,
                residual: position.map(|position| row.residual - position),
                rate: rate.map(|rate| row.rate.unwrap_or(zero) - rate),
                bias: row.acceleration.unwrap_or(zero) - acceleration.unwrap_or(zero),
                driven: rate.unwrap_or(row.rate.unwrap_or(zero)),
            });
        }
        Ok(())
    }

    /// Spring and dashpot elements.
    fn springs(&self, at: &Instant<'_, R>, modes: &Modes<R>, all: &mut Assembled<R>) -> Result<(), Trouble> {
        let zero = R::ZERO;
        let conditions = Conditions::default();
        for (index, spring) in self.springs.iter().enumerate() {
            let mut row: Vec<(usize, R)> = Vec::new();
            let (mut stretch, mut rate) = (zero, zero);
            if let Some([i, j]) = spring.line {
                let initial = sub(self.bodies[j].position, self.bodies[i].position);
                let now = add(initial, sub(at.poses[j].displacement, at.poses[i].displacement));
                let (unit, now) = R::direction_and_norm(now);
                stretch = now - R::direction_and_norm(initial).1;
                for k in 0..3 {
                    row.push((DOFS * i + k, -unit[k]));
                    row.push((DOFS * j + k, unit[k]));
                }
            }
            for (node, axis, is_rotation, factor) in &spring.terms {
                let pose = &at.poses[*node];
                let (moved, first) = if *is_rotation { (pose.vector, 3) } else { (pose.displacement, 0) };
                stretch = stretch + *factor * dot(*axis, moved);
                let derivative = if *is_rotation {
                    vector::apply_transposed(&so3::inverse_left_jacobian(pose.vector), *axis)
                } else {
                    *axis
                };
                for k in 0..3 {
                    row.push((DOFS * node + first + k, *factor * derivative[k]));
                }
            }
            for (dof, entry) in &row {
                rate = rate + *entry * at.rates[dof / DOFS][dof % DOFS];
            }
            let named = |why: Unknown| unknown("a spring", why);
            let inside = |is_rate: bool, x: R| {
                let mut tables = self.tables.iter().zip(&modes.spans);
                let (table, span) = tables
                    .find(|(table, _)| table.of == TableOf::Spring(index) && table.is_rate == is_rate)?;
                table.inside(*span, x)
            };
            let elastic = match inside(false, stretch) {
                None => spring.law.spring(stretch, &conditions).map_err(named)?,
                Some(inside) => {
                    let line = spring.law.spring(R::Gradient::<1>::seed(inside, 0), &conditions);
                    line.map(|line| line.real() + line.gradient()[0] * (stretch - inside)).map_err(named)?
                }
            };
            let viscous = match inside(true, rate) {
                None => spring.law.dashpot(rate, &conditions).map_err(named)?,
                Some(inside) => {
                    let line = spring.law.dashpot(R::Gradient::<1>::seed(inside, 0), &conditions);
                    line.map(|line| line.real() + line.gradient()[0] * (rate - inside)).map_err(named)?
                }
            };
            all.springs.push([stretch, rate]);
            for (dof, entry) in row {
                all.act(dof, -((elastic + viscous) * entry));
            }
            all.powers[1] = all.powers[1] + viscous * rate;
            all.powers[2] = all.powers[2] + elastic * rate;
        }
        Ok(())
    }
}

/// The whole turns in the increments of two nodes. About one axis less than half a turn is left of one against the other: each by itself may
/// leave as much, to opposite sides.
fn whole_turns<R: Number>([a, b]: [Vector<R>; 2]) -> [Vector<R>; 2] {
    let first = whole(a);
    if are_parallel([a, b]) && !has(Fault::TurnsApart) {
        [first, add(first, whole(sub(b, a)))]
    } else {
        [first, whole(b)]
    }
}

/// Whether two nodes turn about one axis, or one of them not at all.
pub(crate) fn are_parallel<R: Number>([a, b]: [Vector<R>; 2]) -> bool {
    /// The sine of an angle between axes that is rounding.
    const ROUNDED: f64 = 1e-9;
    !(norm(a) * norm(b) * R::from_f64(ROUNDED)).less(norm(cross(a, b)))
}

/// The whole turns in a rotation vector: less than half a turn is left.
fn whole<R: Number>(turned: Vector<R>) -> Vector<R> {
    let turn = R::pi() + R::pi();
    let count = (norm(turned) / turn).to_f64().round();
    if count == 0.0 || has(Fault::TurnLost) {
        return [R::ZERO; 3];
    }
    let (unit, _) = R::direction_and_norm(turned);
    vector::scale(unit, turn * R::from_f64(count))
}

fn point<R: Number>(at: &Instant<'_, R>, node: usize) -> Point<R> {
    let pose = at.poses.get(node).copied().unwrap_or_else(Pose::at_rest);
    Point {
        displacement: pose.displacement,
        rotation: pose.rotation,
        vector: pose.vector,
        flow: pose.flow,
        velocity: at.rates.get(node).copied().unwrap_or([R::ZERO; DOFS]),
        acceleration: [R::ZERO; DOFS],
    }
}

fn spread<'a, R: Number>(
    columns: &'a [(usize, u8)],
    gradient: &'a [R],
    nodes: &'a [usize],
) -> impl Iterator<Item = (usize, R)> + 'a {
    let all = columns.iter().zip(gradient).filter(|(_, entry)| R::ZERO.less(entry.magnitude()));
    all.filter_map(|((place, number), entry)| Some((DOFS * nodes.get(*place)? + place_of(*number), *entry)))
}
