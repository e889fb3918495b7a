//! What a solution consists of.

use crate::number::Number;
use crate::time::integrate::Method;
use pintle_kinematics::connector::{Components, Mask, StopStatus};
use pintle_kinematics::so3;
use pintle_kinematics::vector::{product, transpose};
use pintle_scene::Label;
use serde::{Deserialize, Serialize};

/// A node at one time.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct NodeFrame<R> {
    /// u, global components (length).
    pub displacement: [R; 3],
    /// The rotation vector from the initial orientation, with its turns (rad).
    pub rotation: [R; 3],
    /// v and ω, global components.
    pub velocity: [R; 6],
    /// Their time derivatives.
    pub acceleration: [R; 6],
    /// The material flow Ψ with its two time derivatives (length).
    pub flow: [R; 3],
    /// RF and RM: what supports exert on it, global components; 0 where none holds it.
    pub reaction: [R; 6],
    /// Which degrees of freedom are held, with a reaction that is the only one.
    pub held: Mask,
}

/// A connector at one time, of components u1 … ur3; 0 where there is none.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ConnectorFrame<R> {
    /// CP of the components that are free or slide.
    pub position: [R; 6],
    /// CU, with turns.
    pub displacement: [R; 6],
    /// CV.
    pub velocity: [R; 6],
    /// CTF: internal forces and moments, positive resisting growth of their component.
    pub total: [R; 6],
    /// Whose CTF is one of many: constraints repeat each other.
    #[serde(default)]
    pub open: Mask,
    /// CSF.
    pub friction: [R; 6],
    /// Whose CSF is one of many: more frictions stand than hold.
    #[serde(default)]
    pub open_friction: Mask,
    /// Which components have a motion or force that matters to the solution.
    pub wanted: [bool; 6],
    /// Which others have a motion, but nothing that depends on it.
    #[serde(default)]
    pub free: Mask,
    /// Whether each of its frictions sticks.
    pub sticks: Vec<bool>,
    /// P and its limit μ F_N of each of its frictions.
    pub limits: Vec<[R; 2]>,
    /// CSLST: a stop that holds, or a lock.
    pub held: Components<StopStatus>,
    /// CFAILST.
    pub failed: Mask,
}

/// Energies since the beginning.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Energies<R> {
    /// ½ Σ v·M v.
    pub kinetic: R,
    /// Work of loads, gravity and what is prescribed, since the state that the run begins with.
    pub external: R,
    /// What friction, dampers and impacts took, since then.
    pub dissipated: R,
    /// What springs hold, more than in the initial state of the scene.
    pub stored: R,
    /// kinetic + stored + dissipated − external, less what it is as the run begins: zero but for the error.
    pub balance: R,
}

/// A mechanism at one time.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Frame<R> {
    /// The time.
    pub time: R,
    /// Nodes, in the order of [`Solution::nodes`].
    pub nodes: Vec<NodeFrame<R>>,
    /// Connectors, in the order of [`Solution::connectors`].
    pub connectors: Vec<ConnectorFrame<R>>,
    /// Energies.
    pub energies: Energies<R>,
    /// Whether an event is at this time.
    pub is_event: bool,
}

pintle_kinematics::named! {
    /// What happened to a connector.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum What {
        /// Stick ended: slip begins.
        Slips = "slips",
        /// Slip ended: stick begins.
        Sticks = "sticks",
        /// Slip turned to the other direction at once.
        Reverses = "reverses",
        /// A stop is reached: what runs into it loses its velocity there.
        Closes = "stop closes",
        /// A stop is left.
        Opens = "stop opens",
        /// A lock holds.
        Locks = "locks",
        /// A failure releases.
        Fails = "fails",
    }
}

/// An event.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Event<R> {
    /// When.
    pub time: R,
    /// The place of the connector in [`Solution::connectors`].
    pub connector: usize,
    /// The components (from 0) that slide, or that of the stop, lock or failure.
    pub components: Vec<usize>,
    /// What.
    pub what: What,
    /// How sure: of stick (μ F_N − P)/μ F_N, of reversal (P − μ F_N)/P, where the friction alone would stick; of a stop its push or its gap's
    /// growth. 0 is a tie. None where what is prescribed decides or what moves with it, or where nothing presses yet.
    ///
    /// An onset of slip, a stop, a lock, a failure are met where a quantity passes zero. Their margin is its rate, in its size per duration of
    /// the run. A limit that is off by a part ε moves the event by ε/margin of the duration. Sizes: of a friction its limit, of a length that
    /// of the model, of an angle 1 rad, of a force the largest.
    pub margin: Option<f64>,
    /// κ after it: below 1 the friction forces are the only ones.
    pub lipschitz: f64,
}

/// A solution on numbers of type R.
#[derive(Clone, Debug)]
pub struct Solution<R> {
    /// Nodes.
    pub nodes: Vec<Label>,
    /// Connectors: label and title (`HINGE 101`).
    pub connectors: Vec<(Label, String)>,
    /// Times asked for, and events.
    pub frames: Vec<Frame<R>>,
    /// Events in order.
    pub events: Vec<Event<R>>,
    /// Ties: times at which both stick and slip fit, and the place of the connector. It sticks.
    pub ties: Vec<(f64, usize)>,
    /// The largest κ: below 1 the solution is the only one.
    pub lipschitz: f64,
    /// The method.
    pub method: Method,
    /// Steps taken.
    pub steps: usize,
    /// How often the equations of motion were solved.
    pub evaluations: usize,
    /// The most that equations were violated by at any frame: lengths by the size of the model, angles (rad).
    pub violation: f64,
    /// By what velocities that are given were changed to fit the constraints, of the largest: 0 where they fit.
    pub changed: f64,
    /// Whether what springs hold is counted from the state that is gone on from: one of them has no potential.
    pub stored_is_open: bool,
    /// The largest kinetic energy on the way.
    pub liveliest: f64,
    /// How far a node goes on the way, along an axis.
    pub farthest: f64,
    /// The size of lengths: that of the model; where all its nodes coincide, how far one goes, and no less than the largest radius of gyration.
    pub length: f64,
}

/// How far two solutions of one mechanism are apart.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Difference {
    /// Of displacements, relative to the size of the model.
    pub displacement: f64,
    /// Of rotations (rad).
    pub rotation: f64,
    /// Of velocities, relative to the largest.
    pub velocity: f64,
    /// Of component forces and reactions, relative to the largest of their kind.
    pub force: f64,
    /// Of energies and works, relative to the largest on the way.
    pub energy: f64,
    /// Of event times, relative to the duration.
    pub event: f64,
    /// Whether both have the same events in the same order.
    pub same_events: bool,
    /// From when on the events are others.
    pub others_from: Option<f64>,
    /// How many numbers were compared.
    pub compared: usize,
    /// How many runs there are: two methods, or four runs where rounding grows.
    pub runs: usize,
}

impl Difference {
    /// The largest of them.
    pub fn largest(&self) -> f64 {
        let all = [self.displacement, self.rotation, self.velocity, self.force, self.energy, self.event];
        if self.same_events { all.into_iter().fold(0.0, f64::max) } else { f64::INFINITY }
    }
}

/// How far two rotations are apart (rad): their vectors, or the rotation between them, for the whole turns of a body that turns about axes
/// that turn depend on the way.
fn apart<R: Number>(one: &[R; 3], two: &[R; 3]) -> f64 {
    let of_vectors = one.iter().zip(two).map(|(x, y)| (*x - *y).to_f64().abs()).fold(0.0, f64::max);
    if of_vectors < 1.0 {
        return of_vectors;
    }
    let between = product(&transpose(&so3::turn(*one)), &so3::turn(*two));
    so3::log(&between).iter().map(|x| x.to_f64().abs()).fold(0.0, f64::max)
}

/// The largest numbers of each kind: what errors are relative to.
#[derive(Clone, Copy, Debug)]
pub struct Scales {
    /// Of translations, and of rotations.
    pub velocity: [f64; 2],
    /// Forces, and moments.
    pub force: [f64; 2],
    /// Energies and works.
    pub energy: f64,
}

impl<R: Number> Energies<R> {
    /// Kinetic energy, external work, dissipation, stored energy.
    fn works(&self) -> [R; 4] {
        [self.kinetic, self.external, self.dissipated, self.stored]
    }
}

impl<R: Number> Solution<R> {
    /// The largest numbers of each kind. A force counts as a moment too, at an arm as long as the model, and the other way round. What is far
    /// slower than once through the model in the whole time is at rest, and its energies are next to the work of the forces.
    pub fn scales(&self) -> Scales {
        let length = self.length;
        /// A kind that is less than this part of what it could be is rounding.
        const LEAST: f64 = 1e-3;
        let largest = |of: &dyn Fn(&Frame<R>) -> Vec<R>| {
            let all = self.frames.iter().flat_map(of).map(|x| x.to_f64().abs());
            all.fold(f64::MIN_POSITIVE, f64::max)
        };
        let speed = |from: usize| {
            largest(&|frame| {
                frame.nodes.iter().flat_map(|node| node.velocity[from..from + 3].to_vec()).collect()
            })
        };
        let force = |from: usize| {
            largest(&|frame| {
                let of_connectors =
                    frame.connectors.iter().flat_map(|one| one.total[from..from + 3].to_vec());
                let of_nodes = frame.nodes.iter().flat_map(|one| one.reaction[from..from + 3].to_vec());
                of_connectors.chain(of_nodes).collect()
            })
        };
        let (forces, moments) = (force(0), force(3));
        let forces = forces.max(moments / length);
        let times =
            [self.frames.first(), self.frames.last()].map(|frame| frame.map_or(0.0, |of| of.time.to_f64()));
        let slowest = LEAST / (times[1] - times[0]).max(f64::MIN_POSITIVE);
        Scales {
            velocity: [speed(0).max(slowest * length), speed(3).max(slowest)],
            force: [forces, moments.max(forces * length)],
            energy: largest(&|frame| frame.energies.works().to_vec())
                .max(self.liveliest)
                .max(LEAST * forces * length),
        }
    }

    /// How far another solution with the same frames is from this one.
    pub fn difference(&self, other: &Self) -> Difference {
        let length = self.length;
        let mut found = Difference { same_events: true, runs: 2, ..Difference::default() };
        // What ends as it begins may have events beyond its last frame.
        let ends = |of: &Self| {
            let frame = of.frames.last().map_or(0.0, |frame| frame.time.to_f64());
            of.events.last().map_or(frame, |event| frame.max(event.time.to_f64()))
        };
        let duration = Some(ends(self).max(ends(other))).filter(|end| *end > 0.0).unwrap_or(1.0);
        found.same_events =
            self.events.len() == other.events.len() && self.frames.len() == other.frames.len();
        for (one, two) in self.events.iter().zip(&other.events) {
            let is_same = one.connector == two.connector && one.what == two.what;
            if !is_same {
                let when = one.time.lesser(two.time).to_f64();
                found.others_from = found.others_from.or(Some(when));
            }
            found.same_events &= is_same;
            found.event = found.event.max((one.time - two.time).to_f64().abs() / duration);
            found.compared += 1;
        }
        let common = self.events.len().min(other.events.len());
        let more = self.events.get(common).or(other.events.get(common));
        found.others_from = found.others_from.or(more.map(|event| event.time.to_f64()));
        let Scales { velocity: speeds, force: forces, energy } = self.scales();
        let compare = |into: &mut f64, count: &mut usize, one: &[R], two: &[R], scale: f64| {
            for (x, y) in one.iter().zip(two) {
                *into = into.max((*x - *y).to_f64().abs() / scale);
                *count += 1;
            }
        };
        let smooth = |frames: &[Frame<R>]| -> Vec<usize> {
            (0..frames.len()).filter(|i| !frames[*i].is_event).collect()
        };
        // Frames at events differ in their times; those asked for do not.
        for (i, j) in smooth(&self.frames).into_iter().zip(smooth(&other.frames)) {
            let (one, two) = (&self.frames[i], &other.frames[j]);
            compare(
                &mut found.energy,
                &mut found.compared,
                &one.energies.works(),
                &two.energies.works(),
                energy,
            );
            for (one, two) in one.nodes.iter().zip(&two.nodes) {
                let count = &mut found.compared;
                compare(&mut found.displacement, count, &one.displacement, &two.displacement, length);
                found.rotation = found.rotation.max(apart(&one.rotation, &two.rotation));
                *count += 3;
                compare(&mut found.velocity, count, &one.velocity[..3], &two.velocity[..3], speeds[0]);
                compare(&mut found.velocity, count, &one.velocity[3..], &two.velocity[3..], speeds[1]);
                for k in (0..6).filter(|k| one.held[*k]) {
                    let scale = forces[k / 3];
                    compare(&mut found.force, count, &one.reaction[k..=k], &two.reaction[k..=k], scale);
                }
            }
            for (one, two) in one.connectors.iter().zip(&two.connectors) {
                let count = &mut found.compared;
                for k in (0..6).filter(|k| !one.open[*k]) {
                    compare(&mut found.force, count, &one.total[k..=k], &two.total[k..=k], forces[k / 3]);
                }
            }
        }
        found
    }
}
