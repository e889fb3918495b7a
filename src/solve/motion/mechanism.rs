//! A scene as the bodies, joints, constraints and loads of a mechanism, on any number.

use crate::motion::mode::{Does, Modes, Side, Touch};
use crate::motion::rows::{Assembled, Owner};
use crate::motion::slide::length;
use crate::motion::state::{DOFS, Pose};
use crate::number::Number;
use crate::refusal::Refusal;
use pintle_kinematics::catalog::{COMPONENT, PLANE, component_index};
use pintle_kinematics::connector::{Connector, Mask};
use pintle_kinematics::mpc::{Constraint, MpcType};
use pintle_kinematics::node::Pair;
use pintle_kinematics::relation::{Form, Quantity, Relation};
use pintle_kinematics::vector;
use pintle_kinematics::vector::{Matrix, Vector, add, apply, cross, sub};
use pintle_model::behavior::Conditions;
use pintle_model::behavior::drive::{Drive, Schedule, gravity, on_nodes};
use pintle_model::behavior::friction::{Belt, Coefficient, Criterion, FLOW, Friction, Tangential};
use pintle_model::behavior::ground::Ground;
use pintle_model::evaluate::{ElementBehavior, Model};
use pintle_scene::{Label, NodeFreedom, PointKind, Scene, Target};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

/// A node.
#[derive(Clone, Debug)]
pub(crate) struct Body<R> {
    pub(crate) label: Label,
    /// X.
    pub(crate) position: Vector<R>,
    pub(crate) mass: R,
    /// About the node, in its initial orientation, along the global axes.
    pub(crate) inertia: Matrix<R>,
    /// The part of gravity that acts on it: the index of each gravity, with the mass.
    pub(crate) weights: Vec<(usize, R)>,
    /// Loads on its degrees of freedom 1 to 6, along its axes.
    pub(crate) loads: Vec<(usize, Drive)>,
    /// Its axes, as rows.
    pub(crate) axes: [Vector<R>; 3],
}

/// A connector.
#[derive(Clone, Debug)]
pub(crate) struct Joint<R: Number> {
    pub(crate) label: Label,
    pub(crate) title: String,
    pub(crate) connector: Connector<R>,
    /// The places of its nodes; none is the ground.
    pub(crate) ends: [Option<usize>; 2],
    pub(crate) initial: Pair<R>,
    pub(crate) behavior: Arc<ElementBehavior>,
    /// The components that the connection type constrains.
    pub(crate) constrained: Mask,
    /// The components whose motion or force matters.
    pub(crate) wanted: Mask,
    /// Those that move freely: nothing depends on them, but they are outputs.
    pub(crate) free: Mask,
    /// The components that elasticity keeps at their reference.
    pub(crate) rigid: Mask,
}

/// A friction of a connector: |f_k / R_k| ≤ μ F_N.
#[derive(Clone, Debug)]
pub(crate) struct Slider {
    /// The connector.
    pub(crate) joint: usize,
    /// The friction among those of its behaviour.
    pub(crate) index: usize,
    /// Its components (from 0), with R_k.
    pub(crate) components: Vec<(usize, f64)>,
    /// Of a belt that runs over a ring: the connector in which it goes on, and the angle of wrap (rad).
    pub(crate) ring: Option<(usize, f64)>,
}

/// A stop of a connector: the range of the position of a component.
#[derive(Clone, Debug)]
pub(crate) struct Stop<R> {
    pub(crate) joint: usize,
    /// From 0.
    pub(crate) component: usize,
    /// Lower and upper.
    pub(crate) limits: [Option<R>; 2],
}

impl<R: Number> Stop<R> {
    /// The limit at an end.
    pub(crate) fn limit(&self, side: Side) -> Option<R> {
        self.limits[usize::from(side == Side::Upper)]
    }

    /// How far a position is from the limit at an end; negative beyond it.
    pub(crate) fn gap(&self, side: Side, position: R) -> Option<R> {
        Some(side.sign::<R>() * (self.limit(side)? - position))
    }
}

/// A lock or a failure of a connector.
#[derive(Clone, Debug)]
pub(crate) struct Threshold<R> {
    pub(crate) joint: usize,
    /// Whose position or force decides (from 0).
    pub(crate) component: usize,
    /// What is locked, or released.
    pub(crate) affected: Mask,
    pub(crate) is_failure: bool,
    /// Of its position, then of its total force, each lower and upper.
    pub(crate) limits: [Option<R>; 4],
}

impl<R: Number> Threshold<R> {
    /// Whether there is still something to lock, or to release.
    pub(crate) fn waits(&self, modes: &Modes<R>) -> bool {
        (0..6).any(|k| {
            let is_held = !self.is_failure && modes.locked_at(self.joint, k).is_some();
            self.affected[k] && !is_held && !modes.has_failed(self.joint, k)
        })
    }
}

/// A force that is a table over one motion.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    pub(crate) of: TableOf,
    /// Over the velocity.
    pub(crate) is_rate: bool,
    /// Where its slope jumps, in increasing order.
    pub(crate) rows: Vec<f64>,
}

/// Whose force a table is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TableOf {
    /// A component of a connector (both from 0).
    Joint(usize, usize),
    /// A spring or dashpot.
    Spring(usize),
    /// The coefficient of a friction, over its slip rate.
    Slip(usize),
}

impl Table {
    /// That of a coefficient of friction whose slope jumps at slip rates: they begin at zero.
    fn of_slip(slider: usize, coefficient: &Coefficient) -> Option<Self> {
        let rates = coefficient.rows();
        let rows = std::iter::once(0.0).chain(rates.iter().copied()).collect();
        (!rates.is_empty()).then_some(Self { of: TableOf::Slip(slider), is_rate: true, rows })
    }

    /// The row at an end of a span.
    pub(crate) fn end(&self, span: usize, side: Side) -> Option<f64> {
        let row = if side == Side::Lower { span.checked_sub(1)? } else { span };
        self.rows.get(row).copied()
    }

    /// A point within a span; none where x is within it.
    pub(crate) fn inside<R: Number>(&self, span: usize, x: R) -> Option<R> {
        let [low, high] = Side::BOTH.map(|side| self.end(span, side).map(R::from_f64));
        let is_within = !low.is_some_and(|low| x.less(low)) && !high.is_some_and(|high| high.less(x));
        if is_within {
            return None;
        }
        let width = self.rows.last().zip(self.rows.first()).map_or(1.0, |(last, first)| last - first);
        Some(match (low, high) {
            (Some(low), Some(high)) => (low + high) * R::ratio(1, 2),
            (Some(low), None) => low + R::from_f64(width),
            (None, Some(high)) => high - R::from_f64(width),
            (None, None) => x,
        })
    }
}

/// What holds a component, besides what its type constrains and what is prescribed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Hold<R> {
    /// Nothing.
    Nothing,
    /// It has failed: nothing of it acts.
    Failed,
    /// A lock holds it here.
    Locked(R),
    /// A stop holds it here.
    Stopped(R),
    /// Friction holds it here.
    Stuck(R),
}

/// A degree of freedom that a boundary condition prescribes along an axis of its node.
#[derive(Clone, Debug)]
pub(crate) struct Bound<R> {
    pub(crate) node: usize,
    /// 0 to 5.
    pub(crate) number: usize,
    /// One equation of one term.
    pub(crate) relation: Relation<R>,
    pub(crate) drive: Drive,
}

/// SPRING or DASHPOT elements between degrees of freedom, or along the line of two nodes.
#[derive(Clone, Debug)]
pub(crate) struct Spring<R> {
    pub(crate) law: Ground,
    /// Terms (node, axis, whether of rotation, factor) whose sum is the elongation; empty along a line.
    pub(crate) terms: Vec<(usize, Vector<R>, bool, R)>,
    /// The nodes of a line.
    pub(crate) line: Option<[usize; 2]>,
}

/// What carries a node without mass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Carry<R> {
    /// The node that is carried by none.
    pub(crate) by: usize,
    /// From that node, at the beginning.
    pub(crate) arm: Vector<R>,
    /// Whether it has rotations: those of the other.
    pub(crate) turns: bool,
}

/// A scene, ready to be solved.
#[derive(Clone, Debug)]
pub(crate) struct Mechanism<R: Number> {
    pub(crate) bodies: Vec<Body<R>>,
    pub(crate) joints: Vec<Joint<R>>,
    pub(crate) sliders: Vec<Slider>,
    /// K of each friction, where stick is elastic.
    pub(crate) stiffness: Vec<R>,
    pub(crate) stops: Vec<Stop<R>>,
    pub(crate) criteria: Vec<Threshold<R>>,
    pub(crate) tables: Vec<Table>,
    pub(crate) mpcs: Vec<(String, Constraint<R>, Vec<usize>)>,
    pub(crate) relations: Vec<(String, Relation<R>, Vec<usize>)>,
    pub(crate) bounds: Vec<Bound<R>>,
    pub(crate) springs: Vec<Spring<R>>,
    pub(crate) gravities: Vec<Vec<(usize, Drive)>>,
    /// The nodes that are made parts of other bodies.
    pub(crate) carried: Vec<Option<Carry<R>>>,
    /// Velocities at the beginning: node, degree of freedom (from 0) along its axes, amount.
    pub(crate) velocities: Vec<(usize, usize, R)>,
    pub(crate) schedule: Schedule,
    /// Degrees of freedom, 7 for each node, that boundary conditions keep at zero.
    pub(crate) held: Vec<bool>,
    /// Whether the step is static.
    pub(crate) is_still: bool,
    /// The size of lengths.
    pub(crate) length: f64,
}

/// Whether the degree of freedom k (from 0) of a node leads out of the plane of a scene in two dimensions.
fn is_out(scene: &Scene, k: usize) -> bool {
    scene.two_dimensional && PLANE.get(k).is_some_and(|is| !is)
}

impl<R: Number> Mechanism<R> {
    /// The mechanism of a scene in a step, counted from 0.
    pub(crate) fn new(scene: &Scene, model: &Model, step: usize) -> Result<Self, Refusal> {
        let mut places = Places::default();
        for element in &model.connectors {
            element.nodes.iter().flatten().for_each(|node| places.add(*node));
        }
        model.mpcs.iter().for_each(|mpc| mpc.nodes.iter().for_each(|node| places.add(*node)));
        model.relations.iter().for_each(|one| one.nodes.iter().for_each(|node| places.add(*node)));
        for element in scene.point_elements.values() {
            [Some(element.node), element.second].into_iter().flatten().for_each(|node| places.add(node));
        }
        let schedule = model.schedule.clone();
        let labels = |target: &Target| -> Vec<Label> {
            match target {
                Target::Label(label) => vec![*label],
                Target::Set(name) => scene.node_sets.get(name).map_or(Vec::new(), |set| set.labels.clone()),
            }
        };
        let on_nodes = on_nodes(scene, &schedule, labels)?;
        let zero = R::ZERO;
        let bodies = places.labels.iter().map(|label| {
            let axes = scene.nodal_axes(*label)?.map(vector::exact);
            let loads = on_nodes.get(label).map_or(Vec::new(), |drives| {
                let loads = drives.loads.iter().enumerate();
                loads.filter_map(|(k, load)| Some((k, load.clone()?))).collect()
            });
            Ok(Body {
                label: *label,
                position: vector::exact(scene.nodes.get(label).map_or([0.0; 3], |node| node.coordinates)),
                mass: zero,
                inertia: [[zero; 3]; 3],
                weights: Vec::new(),
                loads,
                axes,
            })
        });
        let bodies = bodies.collect::<Result<Vec<_>, Refusal>>()?;
        let mut mechanism = Self {
            held: (0..DOFS * bodies.len()).map(|dof| is_out(scene, dof % DOFS)).collect(),
            is_still: schedule.span(step).is_some_and(|(_, is_dynamic)| !is_dynamic),
            bodies,
            joints: Vec::new(),
            sliders: Vec::new(),
            stiffness: Vec::new(),
            stops: Vec::new(),
            criteria: Vec::new(),
            tables: Vec::new(),
            mpcs: Vec::new(),
            relations: Vec::new(),
            bounds: Vec::new(),
            springs: Vec::new(),
            carried: Vec::new(),
            gravities: Vec::new(),
            velocities: Vec::new(),
            schedule,
            length: model.length,
        };
        for given in &scene.initial_velocities {
            let nodes = labels(&given.target.value);
            let Some(k) = component_index(given.degree_of_freedom) else { continue };
            let places = nodes.into_iter().filter_map(|node| places.of(node));
            mechanism.velocities.extend(places.map(|node| (node, k, R::from_f64(given.magnitude))));
        }
        mechanism.weigh(scene, &places)?;
        mechanism.join(model, &places)?;
        mechanism.bind(scene, &on_nodes, &places, step);
        mechanism.hold_flows(scene, &labels, &places, step)?;
        mechanism.spring(scene, &places)?;
        mechanism.carry(scene);
        Ok(mechanism)
    }

    /// Finds the nodes that beams, rigid bodies and couplings make parts of other bodies: those that nothing holds or prescribes, without mass
    /// and inertia. They are no unknowns, and what ties them is no equation: it is left out.
    fn carry(&mut self, scene: &Scene) {
        let freedom = NodeFreedom::of(scene);
        let (bodies, velocities) = (&self.bodies, &self.velocities);
        let turns = |node: usize| {
            let is_loaded = bodies[node].loads.iter().any(|(k, _)| *k >= 3);
            let has_spin = velocities.iter().any(|(of, k, _)| *of == node && *k >= 3);
            freedom.rotates(bodies[node].label) || is_loaded || has_spin
        };
        let is_bare: Vec<bool> = (0..bodies.len())
            .map(|node| {
                let body = &bodies[node];
                // In two dimensions all are held out of the plane, and so are those that carry them.
                let is_held = |k: usize| self.held[DOFS * node + k] && !is_out(scene, k);
                body.mass.is_nothing()
                    && body.weights.is_empty()
                    && body.inertia.iter().flatten().all(|x| x.is_nothing())
                    && !(0..6).any(is_held)
                    && !self.bounds.iter().any(|bound| bound.node == node)
            })
            .collect();
        let mut found: Vec<Option<Carry<R>>> = vec![None; bodies.len()];
        // Of two nodes that turn alike either may carry the other. A pin holds its own node, not what carries that.
        let mut is_within = |slave: usize, master: usize, turns: bool| {
            let root = |node: usize| found[node].map_or(node, |carry: Carry<R>| carry.by);
            let is_own = root(slave) == slave;
            let (slave, master) = (root(slave), root(master));
            if slave == master {
                return true;
            }
            let (from, by) = match (is_bare[slave], is_bare[master]) {
                (true, _) if turns || is_own => (slave, master),
                (false, true) if turns => (master, slave),
                _ => return false,
            };
            let between = sub(bodies[from].position, bodies[by].position);
            for carry in found.iter_mut().flatten().filter(|carry| carry.by == from) {
                (carry.by, carry.arm) = (by, add(carry.arm, between));
            }
            found[from] = Some(Carry { by, arm: between, turns });
            true
        };
        self.mpcs.retain(|(_, constraint, nodes)| match (constraint.kind(), nodes.as_slice()) {
            (MpcType::Beam, [slave, master, ..]) => !is_within(*slave, *master, true),
            _ => true,
        });
        self.relations.retain(|(_, relation, nodes)| match (relation.follows(), nodes.as_slice()) {
            ([true, true], [slave, master]) => !is_within(*slave, *master, true),
            // A pin of a node that has no rotations.
            ([true, false], [slave, master]) if !turns(*slave) => !is_within(*slave, *master, false),
            _ => true,
        });
        self.carried = found;
    }

    /// The node that carries one, or itself.
    pub(crate) fn root(&self, node: usize) -> usize {
        self.carried.get(node).copied().flatten().map_or(node, |carry| carry.by)
    }

    /// Brings nodes that are carried to where those are that carry them, with their rates.
    pub(crate) fn bring(&self, poses: &mut [Pose<R>], rates: &mut [[R; DOFS]]) {
        for (node, carry) in self.carried.iter().enumerate() {
            let Some(Carry { by, arm, turns }) = *carry else { continue };
            let (of, moving) = (poses[by], rates[by]);
            let now = apply(&of.rotation, arm);
            let spin = [moving[3], moving[4], moving[5]];
            let displacement = add(of.displacement, sub(now, arm));
            let velocity = add([moving[0], moving[1], moving[2]], cross(spin, now));
            poses[node].displacement = displacement;
            rates[node][..3].copy_from_slice(&velocity);
            if turns {
                poses[node] = Pose { displacement, flow: poses[node].flow, ..of };
                rates[node][3..6].copy_from_slice(&spin);
            }
        }
    }

    /// The largest radius of gyration √(I/m) of a body.
    pub(crate) fn gyration(&self) -> f64 {
        let all = self.bodies.iter().filter(|body| R::ZERO.less(body.mass)).map(|body| {
            let most = (0..3).map(|k| body.inertia[k][k].to_f64()).fold(0.0, f64::max);
            (most / body.mass.to_f64()).sqrt()
        });
        all.filter(|x| x.is_finite()).fold(0.0, f64::max)
    }

    /// Masses, inertias and gravity.
    fn weigh(&mut self, scene: &Scene, places: &Places) -> Result<(), Refusal> {
        let members = |set: &str| {
            let labels = scene.element_sets.get(set).map_or(&[][..], |set| set.labels.as_slice());
            labels.iter().filter_map(|label| Some((*label, scene.point_elements.get(label)?)))
        };
        let gravities = gravity(scene, &self.schedule)?;
        for mass in &scene.masses {
            for (label, element) in members(&mass.element_set.value) {
                let Some(body) = places.of(element.node).and_then(|place| self.bodies.get_mut(place)) else {
                    continue;
                };
                let amount = R::from_f64(mass.mass);
                body.mass = body.mass + amount;
                for (index, (target, _)) in gravities.iter().enumerate() {
                    let acts = match target {
                        None => true,
                        Some(Target::Label(one)) => *one == label,
                        Some(Target::Set(name)) => {
                            scene.element_sets.get(name).is_some_and(|set| set.contains(label))
                        }
                    };
                    if acts {
                        body.weights.push((index, amount));
                    }
                }
            }
        }
        for inertia in &scene.rotary_inertias {
            for (_, element) in members(&inertia.element_set.value) {
                let place = places.of(element.node);
                let point = scene.nodes.get(&element.node).map_or([0.0; 3], |node| node.coordinates);
                let named = inertia.orientation.as_ref();
                let named = named.and_then(|name| Some((&name.value, scene.orientations.get(&name.value)?)));
                let axes = match named {
                    Some((name, orientation)) => orientation.triad(name, scene, point, &[point])?,
                    None => pintle_scene::GLOBAL,
                };
                let Some(body) = place.and_then(|place| self.bodies.get_mut(place)) else { continue };
                let [i11, i22, i33, i12, i13, i23] = inertia.inertia.map(R::from_f64);
                let local = [[i11, i12, i13], [i12, i22, i23], [i13, i23, i33]];
                let axes: Matrix<R> = axes.map(vector::exact);
                let global = vector::product(&vector::transpose(&axes), &vector::product(&local, &axes));
                for (row, more) in body.inertia.iter_mut().zip(global) {
                    *row = add(*row, more);
                }
            }
        }
        self.gravities = gravities
            .into_iter()
            .map(|(_, drives)| {
                let loads = drives.loads.into_iter().enumerate();
                loads.filter_map(|(k, drive)| Some((k, drive?))).collect()
            })
            .collect();
        Ok(())
    }

    /// Connectors and constraints.
    fn join(&mut self, model: &Model, places: &Places) -> Result<(), Refusal> {
        for (number, element) in model.connectors.iter().enumerate() {
            let behavior = &element.behavior.behavior;
            let title = element.title();
            let refused = |what: &str, remedy: &str| Err(Refusal::of(&title, what, remedy));
            let joint = self.joints.len();
            if let Some(k) = (0..6).find(|k| behavior.inelastic()[*k]) {
                return refused(
                    &format!(
                        "plasticity, damage or a uniaxial behaviour acts on {}, and is not solved",
                        COMPONENT[k]
                    ),
                    "take it out of the behaviour",
                );
            }
            // Where no belt goes on, nothing rubs.
            if let (Some(belt), Some(ring)) = (&behavior.friction.belt, model.rings.get(&number)) {
                let Some(next) = ring.next else {
                    return refused("it ends where another belt ends", "exchange the nodes of one of them");
                };
                let Some(angle) = ring.angle else {
                    let why = "an angle of wrap that follows the nodes is not solved";
                    return refused(why, "give the contact angle in the data of its section");
                };
                if [element, &model.connectors[next]]
                    .iter()
                    .any(|of| of.behavior.behavior.elasticity.rigid()[0])
                {
                    return refused("a rigid belt with friction is not solved", "give it an elasticity");
                }
                self.tables.extend(Table::of_slip(self.sliders.len(), &belt.coefficient));
                let components = vec![(FLOW, 1.0)];
                self.sliders.push(Slider { joint, index: usize::MAX, components, ring: Some((next, angle)) });
            }
            let limit = |limit: Option<f64>| limit.map(R::from_f64);
            for (component, stop) in behavior.stops().iter().enumerate() {
                let Some(stop) = stop else { continue };
                let limits = [stop.lower, stop.upper].map(limit);
                self.stops.push(Stop { joint, component, limits });
            }
            let locks = behavior.locks.iter().map(|lock| (lock, false));
            for (given, is_failure) in locks.chain(behavior.failures.iter().map(|failure| (failure, true))) {
                let limits = match given.limits(&Conditions::default()) {
                    Ok(limits) => limits.map(limit),
                    Err(why) => return refused(why.in_words(), "give numbers for its locks and failures"),
                };
                let (component, affected) = (given.component, given.affected);
                self.criteria.push(Threshold { joint, component, affected, is_failure, limits });
            }
            let tables = behavior.elasticity.rows().into_iter().map(|rows| (rows, false));
            let of_rates = behavior.damping.rows().into_iter().map(|rows| (rows, true));
            for ((component, rows), is_rate) in tables.chain(of_rates) {
                self.tables.push(Table { of: TableOf::Joint(joint, component), is_rate, rows });
            }
            for (index, friction) in behavior.friction.frictions.iter().enumerate() {
                let components = match &friction.criterion.tangential {
                    Tangential::Norm(components) => Some(components.clone()),
                    Tangential::Potential(potential) => potential.norm().filter(|components| {
                        let turns = components.iter().filter(|(k, _)| *k >= 3).count();
                        turns == 0 || turns == components.len()
                    }),
                };
                let Some(components) = components else {
                    return refused(
                        "friction with a *CONNECTOR POTENTIAL that is no root of squares of forces, or of moments, is not solved",
                        "give the exponent 2 and single components, COMPONENT= or PREDEFINED",
                    );
                };
                let partly = behavior.failures.iter().any(|failure| {
                    let mut failed = components.iter().map(|(k, _)| failure.affected[*k]);
                    failed.clone().any(|is| is) && !failed.all(|is| is)
                });
                if partly {
                    return refused(
                        "a failure releases a part of the components of a friction",
                        "release all of them, or none",
                    );
                }
                self.tables.extend(Table::of_slip(self.sliders.len(), &friction.coefficient));
                self.sliders.push(Slider { joint, index, components, ring: None });
            }
            let definition = element.definition();
            let moves = |k: usize| {
                let measure = element.connector.position_measure(k);
                measure.is_some_and(|measure| !measure.is_one_form())
            };
            let constrained = behavior.constrained();
            let drives = &element.behavior.drives;
            let acting = [behavior.elasticity.components(), behavior.damping.components()];
            let driven = |k: usize| drives.motions[k].is_some() || drives.loads[k].is_some();
            let slides = |k: usize| {
                let mut frictions = behavior.friction.frictions.iter();
                frictions.any(|friction| depends_on(friction, k))
            };
            let limited = behavior.limited();
            let wanted = [0, 1, 2, 3, 4, 5].map(|k| {
                let is_there = element.connector.position_measure(k).is_some();
                let acts = acting.iter().any(|mask| mask[k]) || driven(k) || slides(k) || limited[k];
                let flows = k == FLOW && behavior.friction.belt.is_some();
                is_there && (constrained[k] || acts || flows)
            });
            let initial = &definition.initial;
            let exact = |node: &pintle_kinematics::node::Node<f64>| pintle_kinematics::node::Node {
                displacement: vector::exact(node.displacement),
                triad: vector::exact_matrix(&node.triad),
                flow: R::from_f64(node.flow),
            };
            self.joints.push(Joint {
                label: element.label,
                connector: Connector::new(&definition),
                ends: element.nodes.map(|node| places.of(node?)),
                initial: Pair {
                    reference: vector::exact(initial.reference),
                    a: exact(&initial.a),
                    b: exact(&initial.b),
                },
                rigid: behavior.elasticity.rigid(),
                behavior: Arc::clone(&element.behavior),
                constrained,
                free: [0, 1, 2, 3, 4, 5].map(|k| moves(k) && !wanted[k] && !constrained[k]),
                wanted,
                title,
            });
        }
        for mpc in &model.mpcs {
            let nodes = mpc.nodes.iter().filter_map(|node| places.of(*node)).collect();
            self.mpcs.push((mpc.title(), mpc.constraint.exact(), nodes));
        }
        for one in &model.relations {
            let nodes = one.nodes.iter().filter_map(|node| places.of(*node)).collect();
            self.relations.push((one.title(), one.relation.exact(), nodes));
        }
        Ok(())
    }

    /// Boundary conditions of material flow (degree of freedom 10): it is held, or refused.
    fn hold_flows(
        &mut self,
        scene: &Scene,
        labels: &dyn Fn(&Target) -> Vec<Label>,
        places: &Places,
        step: usize,
    ) -> Result<(), Refusal> {
        /// The number of material flow.
        const NUMBER: u8 = 10;
        let steps = scene.steps.iter().take(step + 1).flat_map(|step| &step.boundaries);
        for boundary in scene.boundaries.iter().chain(steps) {
            if !boundary.degrees_of_freedom.contains(&NUMBER) {
                continue;
            }
            for label in labels(&boundary.target.value) {
                let Some(node) = places.of(label) else { continue };
                if boundary.magnitude != 0.0 {
                    return Err(Refusal::of(
                        &format!("node {label}"),
                        "a material flow other than zero is prescribed",
                        "hold it, and move the node",
                    ));
                }
                self.held[DOFS * node + DOFS - 1] = true;
            }
        }
        Ok(())
    }

    /// Boundary conditions in a step: what stays zero along global axes is no unknown, all else is an equation.
    fn bind(
        &mut self,
        scene: &Scene,
        on_nodes: &BTreeMap<Label, pintle_model::behavior::drive::Drives>,
        places: &Places,
        step: usize,
    ) {
        let global = pintle_scene::GLOBAL;
        for (label, drives) in on_nodes {
            let Some(node) = places.of(*label) else { continue };
            let axes = scene.nodal_axes(*label).unwrap_or(global);
            let rests =
                |k: usize| drives.motions[k].as_ref().is_some_and(|drive| drive.rests(&self.schedule, step));
            // A node whose rotations about two axes stay zero turns about the third alone.
            let turns_held = (3..6).filter(|k| rests(*k)).count();
            let is_hinge = self.mpcs.iter().any(|(_, constraint, nodes)| {
                constraint.kind() != MpcType::Beam && nodes.iter().skip(2).any(|other| *other == node)
            });
            for k in 0..6 {
                let Some(drive) =
                    drives.motions[k].as_ref().filter(|drive| drive.acts_in(&self.schedule, step))
                else {
                    continue;
                };
                if rests(k) && axes == global && (k < 3 || turns_held >= 2 || is_hinge) {
                    self.held[DOFS * node + k] = true;
                    continue;
                }
                let relation = Relation::<f64>::linear(&[(0, axes[k % 3], k, 1.0)]);
                let others_rest = k >= 3 && (3..6).all(|j| j == k || rests(j)) && axes == global;
                let relation = relation.with_angles(|_| !(others_rest || is_hinge));
                self.bounds.push(Bound { node, number: k, relation: relation.exact(), drive: drive.clone() });
            }
        }
    }

    /// Springs and dashpots.
    fn spring(&mut self, scene: &Scene, places: &Places) -> Result<(), Refusal> {
        for (discrete, is_spring) in
            scene.springs.iter().map(|one| (one, true)).chain(scene.dashpots.iter().map(|one| (one, false)))
        {
            let Some(set) = scene.element_sets.get(&discrete.element_set.value) else { continue };
            for label in &set.labels {
                let Some(element) = scene.point_elements.get(label) else { continue };
                let mut law = Ground::default();
                if is_spring {
                    law.add_spring(discrete)?
                } else {
                    law.add_dashpot(discrete)?
                };
                let Some(first) = places.of(element.node) else { continue };
                let second = element.second.and_then(|node| places.of(node));
                let is_line = matches!(element.kind, PointKind::Springa | PointKind::Dashpota);
                let line = is_line.then_some(()).and_then(|()| Some([first, second?]));
                let mut terms = Vec::new();
                if line.is_none() {
                    let axes = match &discrete.orientation {
                        None => pintle_scene::GLOBAL,
                        Some(name) => match scene.orientations.get(&name.value) {
                            None => pintle_scene::GLOBAL,
                            Some(orientation) => {
                                let at = scene.nodes.get(&element.node);
                                let at = at.map_or([0.0; 3], |node| node.coordinates);
                                orientation.triad(&name.value, scene, at, &[at])?
                            }
                        },
                    };
                    let ends = [(Some(first), 1), (second, -1)];
                    let numbers = &discrete.degrees_of_freedom;
                    for (i, (node, factor)) in ends.into_iter().enumerate() {
                        let number = numbers.get(i).or_else(|| numbers.first()).copied().unwrap_or(1);
                        let Some(node) = node else { continue };
                        if !(1..=6).contains(&number) {
                            return Err(Refusal::of(
                                &format!("element {label}"),
                                "a spring in a degree of freedom beyond 6 is not solved",
                                "take it out",
                            ));
                        }
                        let k = usize::from(number) - 1;
                        terms.push((node, vector::exact(axes[k % 3]), k >= 3, R::integer(factor)));
                    }
                }
                let of = TableOf::Spring(self.springs.len());
                for (rows, is_rate) in law.rows().into_iter().zip([false, true]) {
                    if !rows.is_empty() {
                        self.tables.push(Table { of, is_rate, rows });
                    }
                }
                self.springs.push(Spring { law, terms, line });
            }
        }
        Ok(())
    }

    /// What holds component k of a connector.
    pub(crate) fn hold(&self, modes: &Modes<R>, joint: usize, k: usize) -> Hold<R> {
        if modes.has_failed(joint, k) {
            return Hold::Failed;
        }
        if let Some(at) = modes.locked_at(joint, k) {
            return Hold::Locked(at);
        }
        let mut stops = self.stops.iter().zip(&modes.stops);
        let closed = stops.find_map(|(stop, touch)| match touch {
            Touch::Closed(side) if stop.joint == joint && stop.component == k => stop.limit(*side),
            _ => None,
        });
        if let Some(at) = closed {
            return Hold::Stopped(at);
        }
        let mut sliders = self.sliders.iter().zip(&modes.frictions);
        let stuck = sliders.find_map(|(slider, mode)| match &mode.does {
            Does::Sticks(position) if slider.joint == joint => {
                slider.components.iter().any(|(of, _)| *of == k).then(|| position[k])
            }
            _ => None,
        });
        stuck.map_or(Hold::Nothing, Hold::Stuck)
    }

    /// Whether friction holds component k of a connector.
    pub(crate) fn is_stuck(&self, modes: &Modes<R>, joint: usize, k: usize) -> bool {
        matches!(self.hold(modes, joint, k), Hold::Stuck(_))
    }

    /// Whether a friction has nothing to do: all its components have failed, or are locked.
    pub(crate) fn is_idle(&self, modes: &Modes<R>, slider: &Slider) -> bool {
        let holds = |k: usize| self.hold(modes, slider.joint, k);
        slider.components.iter().all(|(k, _)| matches!(holds(*k), Hold::Failed | Hold::Locked(_)))
    }

    /// Whether a friction is gone for good: what it acted on has failed.
    pub(crate) fn is_gone(&self, modes: &Modes<R>, slider: &Slider) -> bool {
        slider.components.iter().any(|(k, _)| modes.has_failed(slider.joint, *k))
    }

    /// The frictions of several components, each with the places of its R_k v_k after the slips of all.
    pub(crate) fn turning(&self) -> impl Iterator<Item = (usize, Range<usize>)> + '_ {
        let several = self.sliders.iter().enumerate().filter(|(_, slider)| slider.components.len() > 1);
        several.scan(self.sliders.len(), |from, (s, slider)| {
            let places = *from..*from + slider.components.len();
            *from = places.end;
            Some((s, places))
        })
    }

    /// Whether a motion is prescribed for component k of a connector, or a rigid elasticity keeps it.
    pub(crate) fn is_given(&self, joint: usize, k: usize, step: usize) -> bool {
        let Some(joint) = self.joints.get(joint) else { return false };
        let drive = joint.behavior.drives.motions[k].as_ref();
        joint.rigid[k] || drive.is_some_and(|drive| drive.acts_in(&self.schedule, step))
    }

    /// The motion that a table is over.
    pub(crate) fn argument(&self, table: &Table, found: &Assembled<R>) -> R {
        let zero = R::ZERO;
        match table.of {
            TableOf::Joint(joint, k) => found.joints.get(joint).map_or(zero, |now| match table.is_rate {
                true => now.velocity[k],
                false => now.motion[k],
            }),
            TableOf::Spring(spring) => {
                found.springs.get(spring).map_or(zero, |at| at[usize::from(table.is_rate)])
            }
            TableOf::Slip(s) => {
                let slider =
                    self.sliders.get(s).and_then(|slider| Some((slider, found.joints.get(slider.joint)?)));
                slider.map_or(zero, |(slider, now)| length(&slider.rates(&now.velocity)))
            }
        }
    }

    /// Whether rotation vectors matter, with their turns.
    pub(crate) fn needs_vectors(&self) -> bool {
        let turns = |relation: &Relation<R>| match relation.form() {
            Form::Linear(terms) => terms.iter().any(|term| term.quantity == Quantity::Rotation),
            Form::Carried { .. } | Form::Mean { .. } => false,
        };
        self.relations.iter().any(|(_, relation, _)| turns(relation))
            || self.bounds.iter().any(|bound| turns(&bound.relation))
            || self
                .springs
                .iter()
                .any(|spring| spring.terms.iter().any(|(_, _, is_rotation, _)| *is_rotation))
    }

    /// What an equation belongs to, in words: `HINGE 101 ur2`.
    pub(crate) fn named(&self, owner: Owner) -> String {
        match owner {
            Owner::Joint(joint, k) => {
                let title = self.joints.get(joint).map_or("", |joint| joint.title.as_str());
                format!("{title} {}", COMPONENT[k])
            }
            Owner::Mpc(index, _) => {
                self.mpcs.get(index).map_or_else(String::new, |(title, ..)| title.clone())
            }
            Owner::Relation(index, _) => {
                self.relations.get(index).map_or_else(String::new, |(title, ..)| title.clone())
            }
            Owner::Given(index) => self.velocities.get(index).map_or_else(String::new, |(node, k, _)| {
                format!("initial velocity of node {} in {}", self.bodies[*node].label, k + 1)
            }),
            Owner::Ring(slider) => {
                let joint = self.sliders.get(slider).and_then(|of| self.joints.get(of.joint));
                joint.map_or_else(String::new, |joint| format!("{} at its ring", joint.title))
            }
            Owner::Bound(index) => self.bounds.get(index).map_or_else(String::new, |bound| {
                format!(
                    "boundary condition of node {} in {}",
                    self.bodies[bound.node].label,
                    bound.number + 1
                )
            }),
        }
    }

    /// The nodes that an equation joins; for those that are carried, the ones that carry them.
    pub(crate) fn nodes_of(&self, owner: Owner) -> Vec<usize> {
        let all = self.nodes_named(owner);
        all.into_iter().map(|node| self.root(node)).collect()
    }

    /// Whether an equation joins a node that is carried.
    pub(crate) fn has_carried(&self, owner: Owner) -> bool {
        self.nodes_named(owner).into_iter().any(|node| self.root(node) != node)
    }

    fn nodes_named(&self, owner: Owner) -> Vec<usize> {
        match owner {
            Owner::Joint(joint, _) => {
                self.joints.get(joint).map_or(Vec::new(), |joint| joint.ends.into_iter().flatten().collect())
            }
            Owner::Mpc(index, _) => self.mpcs.get(index).map_or(Vec::new(), |(.., nodes)| nodes.clone()),
            Owner::Relation(index, _) => {
                self.relations.get(index).map_or(Vec::new(), |(.., nodes)| nodes.clone())
            }
            Owner::Ring(slider) => self.sliders.get(slider).map_or(Vec::new(), |of| {
                let next = of.ring.map(|(next, _)| next);
                let joints =
                    [Some(of.joint), next].into_iter().flatten().filter_map(|of| self.joints.get(of));
                joints.flat_map(|joint| joint.ends.into_iter().flatten()).collect()
            }),
            Owner::Bound(index) => self.bounds.get(index).map_or(Vec::new(), |bound| vec![bound.node]),
            Owner::Given(index) => self.velocities.get(index).map_or(Vec::new(), |(node, ..)| vec![*node]),
        }
    }

    /// A degree of freedom in words: `ur3 of node 5`.
    pub(crate) fn freedom(&self, dof: usize) -> String {
        const NAMES: [&str; DOFS] = ["u1", "u2", "u3", "ur1", "ur2", "ur3", "flow"];
        let label = self.bodies.get(dof / DOFS).map(|body| body.label.to_string()).unwrap_or_default();
        format!("{} of node {label}", NAMES[dof % DOFS])
    }

    /// The friction of a slider that is a belt.
    pub(crate) fn belt(&self, slider: &Slider) -> Option<&Belt> {
        self.joints.get(slider.joint)?.behavior.behavior.friction.belt.as_ref()
    }

    /// The friction of a slider.
    pub(crate) fn friction(&self, slider: &Slider) -> Option<&Friction> {
        let behavior = &self.joints.get(slider.joint)?.behavior.behavior;
        behavior.friction.frictions.get(slider.index)
    }
}

/// Whether the force or motion of component k enters a friction.
fn depends_on(friction: &Friction, k: usize) -> bool {
    let Criterion { tangential, .. } = &friction.criterion;
    tangential.components().contains(&k) || friction.criterion.pressing_components()[k]
}

/// The places of nodes.
#[derive(Default)]
struct Places {
    labels: Vec<Label>,
    of: BTreeMap<Label, usize>,
}

impl Places {
    fn add(&mut self, label: Label) {
        if !self.of.contains_key(&label) {
            self.of.insert(label, self.labels.len());
            self.labels.push(label);
        }
    }

    fn of(&self, label: Label) -> Option<usize> {
        self.of.get(&label).copied()
    }
}
