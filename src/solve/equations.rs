//! The equations of motion at one instant: M a + Σ f G + h = 0, J a + b = 0, and the limit of each friction that slips.

use crate::dense::{Dense, NoPivot};
use crate::mechanism::Mechanism;
use crate::mode::{Cause, Does, Mode, Switch};
use crate::number::{Number, larger, largest};
use crate::slide::{Limit, length, limit};
use crate::state::{DOFS, Pose, State, WORKS};
use pintle_kinematics::connector::{Branch, Increment, Output, Request, State as PairState, Tally, Turns};
use pintle_kinematics::force::Want;
use pintle_kinematics::mpc;
use pintle_kinematics::node::{DOFS as PAIR, Node, Pair};
use pintle_kinematics::relation::{Point, place_of};
use pintle_kinematics::so3;
use pintle_kinematics::vector;
use pintle_kinematics::vector::{Matrix, Vector, add, apply, cross, dot, sub};
use pintle_model::behavior::drive::{Drive, Prescribed};
use pintle_model::behavior::{Conditions, Motion, Unknown};

/// What an equation belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Owner {
    /// A component of a connector (both from 0).
    Joint(usize, usize),
    Mpc(usize, usize),
    Relation(usize, usize),
    Bound(usize),
}

/// One equation.
#[derive(Clone, Debug)]
pub(crate) struct Row<R> {
    pub(crate) owner: Owner,
    /// By degree of freedom, 7 for each node.
    pub(crate) coefficients: Vec<(usize, R)>,
    /// The nodal forces of a unit of its force.
    pub(crate) force: Vec<(usize, R)>,
    /// What must be zero, unless only rates are prescribed.
    pub(crate) residual: Option<R>,
    /// Its rate, unless only accelerations are.
    pub(crate) rate: Option<R>,
    /// The part of its acceleration that accelerations do not enter.
    pub(crate) bias: R,
    /// The rate that is prescribed, by which its force does work.
    pub(crate) driven: R,
}

/// A connector at one instant.
#[derive(Clone, Debug)]
pub(crate) struct Now<R> {
    pub(crate) position: [R; 6],
    pub(crate) displacement: [R; 6],
    pub(crate) motion: [R; 6],
    pub(crate) velocity: [R; 6],
    /// J̇ q̇ of each position.
    pub(crate) bias: [R; 6],
    pub(crate) elastic: [R; 6],
    pub(crate) viscous: [R; 6],
    pub(crate) load: [R; 6],
    /// The nodal forces of a unit of each component's force.
    pub(crate) columns: [Vec<(usize, R)>; 6],
    /// The derivatives of each position.
    pub(crate) rows: [Vec<(usize, R)>; 6],
    pub(crate) branch: Branch<R>,
}

/// All that is known of one instant before accelerations are.
#[derive(Clone, Debug)]
pub(crate) struct Assembled<R> {
    pub(crate) rows: Vec<Row<R>>,
    pub(crate) joints: Vec<Now<R>>,
    masses: Vec<R>,
    inertias: Vec<Matrix<R>>,
    /// −h: loads less what springs and rotation take.
    applied: Vec<R>,
    /// The power of loads, of dampers, into springs.
    powers: [R; WORKS],
    rates: Vec<[R; DOFS]>,
    slips: Vec<R>,
}

/// Accelerations and forces.
#[derive(Clone, Debug)]
pub(crate) struct Solved<R> {
    /// By node.
    pub(crate) accelerations: Vec<[R; DOFS]>,
    /// The force of each row.
    pub(crate) forces: Vec<R>,
    /// CTF of each connector.
    pub(crate) total: Vec<[R; 6]>,
    /// CSF of each connector.
    pub(crate) friction: Vec<[R; 6]>,
    /// The limit of each friction.
    pub(crate) limits: Vec<Limit<R>>,
    /// P of each friction.
    pub(crate) tangential: Vec<R>,
    /// Σ R_k n_k v_k of each friction that slips.
    pub(crate) slip_rates: Vec<R>,
    pub(crate) switches: Vec<Switch<R>>,
    /// The rates of [`State::sums`].
    pub(crate) sums: Vec<R>,
}

/// Why an instant has no solution.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum Trouble {
    /// Nothing determines an acceleration or force.
    #[error("singular")]
    Singular(NoPivotAt),
    /// The friction forces were not found.
    #[error("the friction forces were not found")]
    NotFound,
    /// Something that acts is not known.
    #[error("{0}: {1}")]
    Unknown(String, String),
    /// A number overflows.
    #[error("a number is not finite")]
    NotFinite,
}

/// What has no pivot: a degree of freedom, or an equation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoPivotAt {
    Freedom(usize),
    Row(usize),
    Slider(usize),
}

/// An instant that is asked about.
#[derive(Clone, Copy)]
pub(crate) struct Instant<'a, R> {
    pub(crate) time: R,
    pub(crate) step: usize,
    pub(crate) poses: &'a [Pose<R>],
    pub(crate) rates: &'a [[R; DOFS]],
    pub(crate) sums: &'a [R],
    /// How far each node has turned since the state of the branches.
    pub(crate) turned: &'a [Vector<R>],
    pub(crate) branches: &'a [Branch<R>],
}

impl<'a, R: Number> Instant<'a, R> {
    /// A state by itself.
    pub(crate) fn of(state: &'a State<R>, step: usize, still: &'a [Vector<R>]) -> Self {
        Self {
            time: state.time,
            step,
            poses: &state.poses,
            rates: &state.rates,
            sums: &state.sums,
            turned: still,
            branches: &state.branches,
        }
    }
}

/// Displacements of components at the beginnings of steps, of connectors and of boundary conditions.
#[derive(Clone, Debug, Default)]
pub(crate) struct Beginnings {
    pub(crate) joints: Vec<Vec<[f64; 6]>>,
    pub(crate) nodes: Vec<Vec<[f64; 6]>>,
}

impl Beginnings {
    fn joint(&self, joint: usize, k: usize) -> impl Fn(usize) -> Option<f64> + '_ {
        move |step| self.joints.get(step)?.get(joint).map(|all| all[k])
    }

    fn node(&self, node: usize, k: usize) -> impl Fn(usize) -> Option<f64> + '_ {
        move |step| self.nodes.get(step)?.get(node).map(|all| all[k])
    }
}

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
        let (zero, one) = (R::integer(0), R::integer(1));
        let moving = R::moving(time, one, zero);
        let real = |x: R::Time| pintle_kinematics::scalar::Scalar::real(x);
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
            None => Ok(R::integer(0)),
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
        modes: &[Mode<R>],
        beginnings: &Beginnings,
    ) -> Result<Assembled<R>, Trouble> {
        let zero = R::integer(0);
        let count = self.bodies.len();
        let mut all = Assembled {
            rows: Vec::new(),
            joints: Vec::with_capacity(self.joints.len()),
            masses: self.bodies.iter().map(|body| body.mass).collect(),
            inertias: Vec::with_capacity(count),
            applied: vec![zero; DOFS * count],
            powers: [zero; WORKS],
            rates: at.rates.to_vec(),
            slips: at.sums.iter().skip(WORKS).copied().collect(),
        };
        self.loads(at, &mut all)?;
        for index in 0..self.joints.len() {
            self.joint(index, at, modes, beginnings, &mut all)?;
        }
        self.constraints(at, &mut all);
        self.bounds(at, beginnings, &mut all)?;
        self.springs(at, &mut all)?;
        Ok(all)
    }

    /// Inertia and loads.
    fn loads(&self, at: &Instant<'_, R>, all: &mut Assembled<R>) -> Result<(), Trouble> {
        let zero = R::integer(0);
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
                all.applied[DOFS * n + k] = force - if k < 3 { zero } else { gyroscopic[k - 3] };
            }
            all.inertias.push(inertia);
        }
        Ok(())
    }

    /// A connector: its equations, and the forces that follow from its motion.
    fn joint(
        &self,
        index: usize,
        at: &Instant<'_, R>,
        modes: &[Mode<R>],
        beginnings: &Beginnings,
        all: &mut Assembled<R>,
    ) -> Result<(), Trouble> {
        let zero = R::integer(0);
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
        let state = PairState {
            pair: Pair {
                reference: joint.initial.reference,
                a: node(0, &joint.initial.a),
                b: node(1, &joint.initial.b),
            },
            velocity,
            acceleration: [zero; PAIR],
        };
        let turned =
            |end: usize| joint.ends[end].and_then(|n| at.turned.get(n)).copied().unwrap_or([zero; 3]);
        let increment =
            Increment { rotation: [turned(0), turned(1)], whole_turns: [[zero; 3]; 2], flow: [zero; 2] };
        let mut tally = Tally::default();
        let branch =
            joint.connector.follow(&state, &increment, &at.branches[index], joint.wanted, &mut tally);
        let mut request = Request::nothing(1);
        let free = [0, 1, 2, 3, 4, 5].map(|k| joint.wanted[k] && !joint.constrained[k]);
        let held = [0, 1, 2, 3, 4, 5].map(|k| joint.wanted[k] && joint.constrained[k]);
        for output in [Output::CP, Output::CU, Output::CCU, Output::CV, Output::CA] {
            request.add(output, free);
        }
        for output in [Output::RES, Output::RESV, Output::RESB, Output::CP] {
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
        let spread = |row: &[R; PAIR]| -> Vec<(usize, R)> {
            let mut found = Vec::with_capacity(PAIR);
            for (j, entry) in row.iter().enumerate() {
                if let Some(n) = joint.ends[j / DOFS].filter(|_| zero.less(entry.magnitude())) {
                    found.push((DOFS * n + j % DOFS, *entry));
                }
            }
            found
        };
        let column = |k: usize| {
            let mut unit = [None; 6];
            unit[k] = Some(R::integer(1));
            if joint.wanted[k] { spread(&forces.nodal(&unit)) } else { Vec::new() }
        };
        let value = |of: [Option<R>; 6]| of.map(|x| x.unwrap_or(zero));
        let rows: [Vec<(usize, R)>; 6] =
            std::array::from_fn(|k| evaluation.jacobian[k].as_ref().map_or(Vec::new(), spread));
        let mut now = Now {
            position: value(evaluation.position),
            displacement: value(evaluation.displacement),
            motion: value(evaluation.constitutive),
            velocity: value(evaluation.velocity),
            bias: value(evaluation.acceleration),
            elastic: [zero; 6],
            viscous: [zero; 6],
            load: [zero; 6],
            columns: std::array::from_fn(column),
            rows,
            branch,
        };
        let behavior = &joint.behavior.behavior;
        let motion = Motion { position: now.position, constitutive: now.motion, velocity: now.velocity };
        let conditions = Conditions::default();
        let elastic = behavior.elasticity.forces(&motion, &conditions);
        let viscous = behavior.damping.forces(&motion, &conditions);
        let when = (at.step, at.time);
        for k in 0..6 {
            let why = elastic.unknown[k].filter(|_| !joint.rigid[k]).or(viscous.unknown[k]);
            if let Some(why) = why {
                return Err(unknown(&joint.title, why));
            }
            now.elastic[k] = elastic.value[k].unwrap_or(zero);
            now.viscous[k] = viscous.value[k].unwrap_or(zero);
            if let Some(drive) = &joint.behavior.drives.loads[k] {
                now.load[k] = self.load(drive, when, || joint.title.clone())?;
            }
            let known = now.elastic[k] + now.viscous[k] - now.load[k];
            for (dof, entry) in &now.columns[k] {
                all.applied[*dof] = all.applied[*dof] - known * *entry;
            }
            all.powers[0] = all.powers[0] + now.load[k] * now.velocity[k];
            all.powers[1] = all.powers[1] + now.viscous[k] * now.velocity[k];
            all.powers[2] = all.powers[2] + now.elastic[k] * now.velocity[k];
        }
        let stuck = |k: usize| {
            let mut sliders = self.sliders.iter().zip(modes);
            sliders.find_map(|(slider, mode)| match &mode.does {
                Does::Sticks(position) if slider.joint == index => {
                    slider.components.iter().any(|(of, _)| *of == k).then(|| position[k])
                }
                _ => None,
            })
        };
        for k in (0..6).filter(|k| joint.wanted[*k]) {
            let owner = Owner::Joint(index, k);
            let force = now.columns[k].clone();
            let coefficients = now.rows[k].clone();
            // A one-form is known by its rate: steps are too long for sums along them.
            let is_one_form = joint.connector.position_measure(k).is_some_and(|of| of.is_one_form());
            if joint.constrained[k] {
                all.rows.push(Row {
                    owner,
                    coefficients,
                    force,
                    residual: Some(evaluation.residual[k].unwrap_or(zero)).filter(|_| !is_one_form),
                    rate: Some(evaluation.residual_rate[k].unwrap_or(zero)),
                    bias: evaluation.residual_bias[k].unwrap_or(zero),
                    driven: zero,
                });
                continue;
            }
            let [position, rate, acceleration] = if let Some(drive) = &joint.behavior.drives.motions[k] {
                let beginning = beginnings.joint(index, k);
                match self.prescribed(drive, when, beginning, || joint.title.clone())? {
                    None => continue,
                    Some([position, rate, acceleration]) => {
                        [position.map(|p| now.displacement[k] - p), rate, acceleration]
                    }
                }
            } else if joint.rigid[k] {
                [Some(now.motion[k]), Some(zero), Some(zero)]
            } else if let Some(at) = stuck(k) {
                [Some(now.position[k] - at), Some(zero), Some(zero)]
            } else {
                continue;
            };
            all.rows.push(Row {
                owner,
                coefficients,
                force,
                residual: position.filter(|_| !is_one_form),
                rate: rate.map(|rate| now.velocity[k] - rate),
                bias: now.bias[k] - acceleration.unwrap_or(zero),
                driven: rate.unwrap_or(now.velocity[k]),
            });
        }
        all.joints.push(now);
        Ok(())
    }

    /// Multi-point constraints and relations.
    fn constraints(&self, at: &Instant<'_, R>, all: &mut Assembled<R>) {
        let zero = R::integer(0);
        let mut tally = Tally::default();
        let mut request = Request::nothing(1);
        for output in [Output::RES, Output::RESV, Output::RESB] {
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
                let (place, number) = mpc::Kind::column_dof(j);
                *entry = rate(place).map_or(zero, |rates| rates[place_of(number)]);
            }
            for (i, angle) in angles.iter_mut().enumerate() {
                *angle = pose(2 + i).map(|pose| pose.vector[2]);
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
                let mut coefficients = Vec::new();
                for (j, entry) in gradient.iter().enumerate() {
                    let (place, number) = mpc::Kind::column_dof(j);
                    if let Some(n) = nodes.get(place).filter(|_| zero.less(entry.magnitude())) {
                        coefficients.push((DOFS * n + place_of(number), *entry));
                    }
                }
                all.rows.push(Row {
                    owner: Owner::Mpc(index, row),
                    force: coefficients.clone(),
                    coefficients,
                    residual: found.residual[row],
                    rate: found.residual_rate[row],
                    bias: found.residual_bias[row].unwrap_or(zero),
                    driven: zero,
                });
            }
        }
        for (index, (_, relation, nodes)) in self.relations.iter().enumerate() {
            let points: Vec<Point<R>> = nodes.iter().map(|n| point(at, *n)).collect();
            for (number, row) in relation.evaluate(&points, &request, &mut tally).into_iter().enumerate() {
                let coefficients = spread(relation.columns(), &row.gradient, nodes);
                all.rows.push(Row {
                    owner: Owner::Relation(index, number),
                    force: coefficients.clone(),
                    coefficients,
                    residual: Some(row.residual),
                    rate: row.rate,
                    bias: row.bias.unwrap_or(zero),
                    driven: zero,
                });
            }
        }
    }

    /// Boundary conditions that move, or stand across the axes.
    fn bounds(
        &self,
        at: &Instant<'_, R>,
        beginnings: &Beginnings,
        all: &mut Assembled<R>,
    ) -> Result<(), Trouble> {
        let zero = R::integer(0);
        let mut request = Request::nothing(1);
        for output in [Output::RES, Output::RESV, Output::RESB] {
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
            let coefficients = spread(bound.relation.columns(), &row.gradient, &[bound.node]);
            all.rows.push(Row {
                owner: Owner::Bound(index),
                force: coefficients.clone(),
                coefficients,
                residual: position.map(|position| row.residual - position),
                rate: rate.map(|rate| row.rate.unwrap_or(zero) - rate),
                bias: row.bias.unwrap_or(zero) - acceleration.unwrap_or(zero),
                driven: rate.unwrap_or(row.rate.unwrap_or(zero)),
            });
        }
        Ok(())
    }

    /// Spring and dashpot elements.
    fn springs(&self, at: &Instant<'_, R>, all: &mut Assembled<R>) -> Result<(), Trouble> {
        let zero = R::integer(0);
        let conditions = Conditions::default();
        for spring in &self.springs {
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
            let elastic = spring.law.spring(stretch, &conditions).map_err(named)?;
            let viscous = spring.law.dashpot(rate, &conditions).map_err(named)?;
            for (dof, entry) in &row {
                all.applied[*dof] = all.applied[*dof] - (elastic + viscous) * *entry;
            }
            all.powers[1] = all.powers[1] + viscous * rate;
            all.powers[2] = all.powers[2] + elastic * rate;
        }
        Ok(())
    }
}

fn point<R: Number>(at: &Instant<'_, R>, node: usize) -> Point<R> {
    let pose = at.poses.get(node).copied().unwrap_or_else(Pose::at_rest);
    Point {
        displacement: pose.displacement,
        rotation: pose.rotation,
        vector: pose.vector,
        flow: pose.flow,
        velocity: at.rates.get(node).copied().unwrap_or([R::integer(0); DOFS]),
        acceleration: [R::integer(0); DOFS],
    }
}

fn spread<R: Number>(columns: &[(usize, u8)], gradient: &[R], nodes: &[usize]) -> Vec<(usize, R)> {
    let zero = R::integer(0);
    let all = columns.iter().zip(gradient).filter(|(_, entry)| zero.less(entry.magnitude()));
    all.filter_map(|((place, number), entry)| Some((DOFS * nodes.get(*place)? + place_of(*number), *entry)))
        .collect()
}

/// Which degrees of freedom are unknowns, which equations count, and what stands still.
#[derive(Clone, Debug, Default)]
pub(crate) struct Layout {
    /// The unknowns, as degrees of freedom.
    pub(crate) columns: Vec<usize>,
    /// The unknown of each degree of freedom.
    pub(crate) place: Vec<Option<usize>>,
    /// The equations that count: the others follow from them.
    pub(crate) kept: Vec<usize>,
    /// Sets of unknowns that equations alone determine, each with these equations.
    pub(crate) determined: Vec<(Vec<usize>, Vec<usize>)>,
}

/// How far Newton's method goes, for friction forces.
const ITERATIONS: usize = 60;

impl<R: Number> Assembled<R> {
    /// The matrix of accelerations and forces of rows, with `more` unknowns after them; right-hand sides are zero.
    fn matrix(&self, layout: &Layout, (more, sides): (usize, usize)) -> Dense<R> {
        let (n, m) = (layout.columns.len(), layout.kept.len());
        let mut matrix = Dense::new(n + m + more, sides);
        for (i, dof) in layout.columns.iter().enumerate() {
            let (node, k) = (dof / DOFS, dof % DOFS);
            match k {
                0..3 => matrix.add(i, i, self.masses[node]),
                3..6 => {
                    for j in 0..3 {
                        if let Some(place) = layout.place[DOFS * node + 3 + j] {
                            matrix.add(i, place, self.inertias[node][k - 3][j]);
                        }
                    }
                }
                _ => {}
            }
        }
        for (r, index) in layout.kept.iter().enumerate() {
            let row = &self.rows[*index];
            for (dof, entry) in &row.force {
                if let Some(place) = layout.place[*dof] {
                    matrix.add(place, n + r, *entry);
                }
            }
            for (dof, entry) in &row.coefficients {
                if let Some(place) = layout.place[*dof] {
                    matrix.add(n + r, place, *entry);
                }
            }
        }
        matrix
    }

    /// The change of the degrees of freedom, of least M-norm, that takes each row by −`gap`.
    pub(crate) fn correction(
        &self,
        layout: &Layout,
        gap: impl Fn(&Row<R>) -> Option<R>,
    ) -> Result<Vec<R>, Trouble> {
        let n = layout.columns.len();
        let mut matrix = self.matrix(layout, (0, 1));
        let side = n + layout.kept.len();
        for (r, index) in layout.kept.iter().enumerate() {
            matrix.add(n + r, side, -gap(&self.rows[*index]).unwrap_or(R::integer(0)));
        }
        let found = matrix.solve().map_err(|error| at(layout, error))?;
        let mut change = vec![R::integer(0); layout.place.len()];
        for (x, dof) in found.into_iter().flatten().zip(&layout.columns) {
            change[*dof] = x;
        }
        Ok(change)
    }

    /// The forces that press in a connector, and those of its friction.
    fn of_joint(
        &self,
        joint: usize,
        forces: &[R],
        layout: &Layout,
        (stuck, slipping): (&dyn Fn(usize) -> bool, &[R; 6]),
    ) -> ([R; 6], [R; 6]) {
        let now = &self.joints[joint];
        let mut pressing: [R; 6] = std::array::from_fn(|k| now.elastic[k] + now.viscous[k] - now.load[k]);
        let mut friction = *slipping;
        for (force, index) in forces.iter().zip(&layout.kept) {
            if let Owner::Joint(of, k) = self.rows[*index].owner
                && of == joint
            {
                if stuck(k) {
                    friction[k] = friction[k] + *force;
                } else {
                    pressing[k] = pressing[k] + *force;
                }
            }
        }
        (pressing, friction)
    }

    /// Accelerations and forces in a mode. Branches of friction that `guess` knows begin from its forces.
    pub(crate) fn solve(
        &self,
        mechanism: &Mechanism<R>,
        layout: &Layout,
        modes: &[Mode<R>],
    ) -> Result<Solved<R>, Trouble> {
        let zero = R::integer(0);
        let (n, m) = (layout.columns.len(), layout.kept.len());
        let slipping: Vec<(usize, [R; 6])> = modes
            .iter()
            .enumerate()
            .filter_map(|(s, mode)| match &mode.does {
                Does::Slips(along) => Some((s, *along)),
                Does::Sticks(_) => None,
            })
            .collect();
        let directions: Vec<[R; 6]> =
            slipping.iter().map(|(s, along)| self.direction(&mechanism.sliders[*s], along)).collect();
        let rate_of = |i: usize| {
            let slider = &mechanism.sliders[slipping[i].0];
            let now = &self.joints[slider.joint];
            slider.components.iter().fold(zero, |sum, (k, radius)| {
                sum + R::from_f64(*radius) * directions[i][*k] * now.velocity[*k]
            })
        };
        let limit_of = |s: usize, pressing: &[R; 6], rate: R, known: bool| {
            let slider = &mechanism.sliders[s];
            let now = &self.joints[slider.joint];
            let friction = mechanism.friction(slider)?;
            let slip = self.slips.get(s).copied().unwrap_or(zero);
            let known = known.then_some(&modes[s].branches);
            let places = (now.position, now.motion, slip);
            Some(limit(friction, pressing, rate, places, &Conditions::default(), known))
        };
        let stuck_of = |s: usize, k: usize| {
            let joint = mechanism.sliders[s].joint;
            let mut others = mechanism.sliders.iter().zip(modes);
            others.any(|(slider, mode)| {
                slider.joint == joint && mode.is_stuck() && slider.components.iter().any(|(of, _)| *of == k)
            })
        };
        let friction_of = |joint: usize, tensions: &[R]| {
            let mut friction = [zero; 6];
            for (i, (s, _)) in slipping.iter().enumerate() {
                let slider = &mechanism.sliders[*s];
                if slider.joint == joint {
                    for (k, radius) in &slider.components {
                        friction[*k] = friction[*k] + tensions[i] * R::from_f64(*radius) * directions[i][*k];
                    }
                }
            }
            friction
        };
        let mut forces = vec![zero; m];
        let mut tensions = vec![zero; slipping.len()];
        let mut accelerations = vec![zero; n];
        let side = n + m + slipping.len();
        for iteration in 0.. {
            let mut matrix = self.matrix(layout, (slipping.len(), 1));
            for (i, dof) in layout.columns.iter().enumerate() {
                matrix.add(i, side, self.applied[*dof]);
            }
            for (r, index) in layout.kept.iter().enumerate() {
                matrix.add(n + r, side, -self.rows[*index].bias);
            }
            for (i, (s, _)) in slipping.iter().enumerate() {
                let slider = &mechanism.sliders[*s];
                let now = &self.joints[slider.joint];
                for (k, radius) in &slider.components {
                    let factor = R::from_f64(*radius) * directions[i][*k];
                    for (dof, entry) in &now.columns[*k] {
                        if let Some(place) = layout.place[*dof] {
                            matrix.add(place, n + m + i, factor * *entry);
                        }
                    }
                }
                let stuck = |k: usize| stuck_of(*s, k);
                let (pressing, _) = self.of_joint(slider.joint, &forces, layout, (&stuck, &[zero; 6]));
                let Some(found) = limit_of(*s, &pressing, rate_of(i), true) else { continue };
                matrix.add(n + m + i, n + m + i, R::integer(1));
                let mut right = found.value;
                for (r, index) in layout.kept.iter().enumerate() {
                    if let Owner::Joint(of, k) = self.rows[*index].owner
                        && of == slider.joint
                        && !stuck(k)
                    {
                        matrix.add(n + m + i, n + r, -found.gradient[k]);
                        right = right - found.gradient[k] * forces[r];
                    }
                }
                matrix.add(n + m + i, side, right);
            }
            let found = matrix.solve().map_err(|error| at(layout, error))?;
            let Some(found) = found.into_iter().next() else { return Err(Trouble::NotFound) };
            if !found.iter().all(|x| crate::number::is_finite(*x)) {
                return Err(Trouble::NotFinite);
            }
            let size = largest(found[n..].iter().copied());
            let change =
                largest(found[n..].iter().zip(forces.iter().chain(&tensions)).map(|(new, old)| *new - *old));
            accelerations.copy_from_slice(&found[..n]);
            forces.copy_from_slice(&found[n..n + m]);
            tensions.copy_from_slice(&found[n + m..]);
            let is_done = !(size * R::from_f64(1e3 * R::ROUNDING)).less(change);
            if slipping.is_empty() || is_done {
                break;
            }
            if iteration >= ITERATIONS {
                return Err(Trouble::NotFound);
            }
        }
        // What equations hold, and nothing drives, rests bit for bit.
        for (unknowns, rows) in &layout.determined {
            if rows.iter().all(|row| !zero.less(self.rows[*row].bias.magnitude())) {
                unknowns.iter().for_each(|i| accelerations[*i] = zero);
            }
        }
        let mut solved = Solved {
            accelerations: vec![[zero; DOFS]; self.masses.len()],
            total: Vec::with_capacity(self.joints.len()),
            friction: Vec::with_capacity(self.joints.len()),
            limits: Vec::with_capacity(modes.len()),
            tangential: Vec::with_capacity(modes.len()),
            slip_rates: Vec::with_capacity(modes.len()),
            switches: Vec::new(),
            sums: self.powers.to_vec(),
            forces,
        };
        for (x, dof) in accelerations.iter().zip(&layout.columns) {
            solved.accelerations[dof / DOFS][dof % DOFS] = *x;
        }
        for (joint, _) in self.joints.iter().enumerate() {
            let slipping_friction = friction_of(joint, &tensions);
            let stuck = |k: usize| {
                let mut others = mechanism.sliders.iter().zip(modes);
                others.any(|(slider, mode)| {
                    slider.joint == joint
                        && mode.is_stuck()
                        && slider.components.iter().any(|(of, _)| *of == k)
                })
            };
            let (pressing, friction) =
                self.of_joint(joint, &solved.forces, layout, (&stuck, &slipping_friction));
            solved.total.push(std::array::from_fn(|k| pressing[k] + friction[k]));
            solved.friction.push(friction);
            let rates = &self.joints[joint].velocity;
            for k in 0..6 {
                solved.sums[1] = solved.sums[1] + slipping_friction[k] * rates[k];
            }
        }
        for (force, index) in solved.forces.iter().zip(&layout.kept) {
            let row = &self.rows[*index];
            solved.sums[0] = solved.sums[0] - *force * row.driven;
        }
        for (s, (slider, mode)) in mechanism.sliders.iter().zip(modes).enumerate() {
            let total = &solved.total[slider.joint];
            let friction = &solved.friction[slider.joint];
            let mut pressing: [R; 6] = std::array::from_fn(|k| total[k] - friction[k]);
            for k in 0..6 {
                if !self.is_available(mechanism, slider.joint, k) {
                    pressing[k] = total[k];
                }
            }
            let of_slip = slipping.iter().position(|(of, _)| *of == s);
            let rate = of_slip.map_or(zero, &rate_of);
            let Some(found) = limit_of(s, &pressing, rate, of_slip.is_some()) else { continue };
            let tractions: Vec<R> = slider
                .components
                .iter()
                .map(|(k, radius)| friction[*k] * R::from_f64(*radius).reciprocal_or_zero())
                .collect();
            let tangential = length(&tractions);
            let mut push = |cause, value, scale| {
                solved.switches.push(Switch { slider: s, cause, value, scale });
            };
            match mode.is_stuck() {
                true => push(Cause::Breaks, found.value - tangential, larger(found.value, tangential)),
                false => {
                    push(Cause::Stops, rate, larger(rate.magnitude(), R::integer(1)));
                    for [value, scale] in &found.turns {
                        push(Cause::Turns, *value, *scale);
                    }
                    if let Some([value, scale]) = found.caps {
                        push(Cause::Caps, value, scale);
                    }
                }
            }
            solved.sums.push(rate);
            solved.slip_rates.push(rate);
            solved.tangential.push(tangential);
            solved.limits.push(found);
        }
        Ok(solved)
    }

    fn is_available(&self, mechanism: &Mechanism<R>, joint: usize, k: usize) -> bool {
        !mechanism.joints[joint].constrained[k]
    }

    /// n of a slipping friction: its velocity's direction of R_k v_k; of one component, and where it is at rest, the one it has.
    fn direction(&self, slider: &crate::mechanism::Slider, along: &[R; 6]) -> [R; 6] {
        if slider.components.len() == 1 {
            return *along;
        }
        let now = &self.joints[slider.joint];
        let moving: Vec<R> =
            slider.components.iter().map(|(k, radius)| R::from_f64(*radius) * now.velocity[*k]).collect();
        let size = length(&moving);
        if !R::from_f64(1e-14).less(size) {
            return *along;
        }
        let mut found = [R::integer(0); 6];
        for ((k, _), x) in slider.components.iter().zip(moving) {
            found[*k] = x / size;
        }
        found
    }

    /// How strongly the limits of frictions may depend on friction: the largest row sum of μ ∂F_N/∂T (κ). Below 1 the friction forces are
    /// the only ones.
    pub(crate) fn lipschitz(
        &self,
        mechanism: &Mechanism<R>,
        layout: &Layout,
        (modes, solved): (&[Mode<R>], &Solved<R>),
    ) -> Result<R, Trouble> {
        let zero = R::integer(0);
        let (n, m) = (layout.columns.len(), layout.kept.len());
        let acting: Vec<usize> = (0..modes.len()).filter(|s| !modes[*s].is_stuck()).collect();
        if acting.is_empty() {
            return Ok(zero);
        }
        let mut matrix = self.matrix(layout, (0, acting.len()));
        for (i, s) in acting.iter().enumerate() {
            let slider = &mechanism.sliders[*s];
            let Does::Slips(along) = &modes[*s].does else { continue };
            let direction = self.direction(slider, along);
            for (k, radius) in &slider.components {
                for (dof, entry) in &self.joints[slider.joint].columns[*k] {
                    if let Some(place) = layout.place[*dof] {
                        let force = R::from_f64(*radius) * direction[*k] * *entry;
                        matrix.add(place, n + m + i, -force);
                    }
                }
            }
        }
        let found = matrix.solve().map_err(|error| at(layout, error))?;
        let mut most = zero;
        for s in &acting {
            let joint = mechanism.sliders[*s].joint;
            let Some(limit) = solved.limits.get(*s) else { continue };
            let mut sum = zero;
            for response in &found {
                let mut change = [zero; 6];
                for (r, index) in layout.kept.iter().enumerate() {
                    if let Owner::Joint(of, k) = self.rows[*index].owner
                        && of == joint
                    {
                        change[k] = change[k] + response[n + r];
                    }
                }
                for (factor, rows) in &limit.reach {
                    let vector: Vec<R> = rows
                        .iter()
                        .map(|row| row.iter().zip(&change).fold(zero, |sum, (x, y)| sum + *x * *y))
                        .collect();
                    sum = sum + *factor * length(&vector);
                }
            }
            most = larger(most, sum);
        }
        Ok(most)
    }

    /// ½ Σ v·M v.
    pub(crate) fn kinetic(&self) -> R {
        let mut twice = R::integer(0);
        for ((mass, inertia), rates) in self.masses.iter().zip(&self.inertias).zip(&self.rates) {
            let (v, w) = ([rates[0], rates[1], rates[2]], [rates[3], rates[4], rates[5]]);
            twice = twice + *mass * dot(v, v) + dot(w, apply(inertia, w));
        }
        twice * R::ratio(1, 2)
    }

    /// Whether a node has mass, or inertia, in a degree of freedom.
    pub(crate) fn has_inertia(&self, dof: usize) -> bool {
        let zero = R::integer(0);
        let (node, k) = (dof / DOFS, dof % DOFS);
        match k {
            0..3 => zero.less(self.masses[node].magnitude()),
            3..6 => self.inertias[node].iter().flatten().any(|x| zero.less(x.magnitude())),
            _ => false,
        }
    }

    /// Whether a load acts in a degree of freedom.
    pub(crate) fn is_loaded(&self, dof: usize) -> bool {
        R::integer(0).less(self.applied[dof].magnitude())
    }
}

fn at(layout: &Layout, NoPivot { column }: NoPivot) -> Trouble {
    let (n, m) = (layout.columns.len(), layout.kept.len());
    Trouble::Singular(match column {
        k if k < n => NoPivotAt::Freedom(layout.columns[k]),
        k if k < n + m => NoPivotAt::Row(layout.kept[k - n]),
        k => NoPivotAt::Slider(k - n - m),
    })
}
