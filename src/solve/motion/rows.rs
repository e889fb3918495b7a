//! Equations as rows, and what is known of an instant before accelerations are.

use crate::motion::plan::Plan;
use crate::motion::state::{DOFS, Pose, State, WORKS};
use crate::number::Number;
use pintle_kinematics::connector::Branch;
use pintle_kinematics::node::DOFS as PAIR;
use pintle_kinematics::vector::{Matrix, Vector, add, cross, dot};
use serde::{Deserialize, Serialize};

/// What an equation belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Owner {
    /// A component of a connector (both from 0).
    Joint(usize, usize),
    Mpc(usize, usize),
    Relation(usize, usize),
    Bound(usize),
    /// A belt that slips over its ring: the friction.
    Ring(usize),
    /// A velocity given at the beginning.
    Given(usize),
}

/// A node that moves with another one as part of the same body, at one instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Carried<R> {
    /// The other.
    pub(crate) by: usize,
    /// r, from the other to it.
    pub(crate) arm: Vector<R>,
    /// Whether it turns with the other.
    pub(crate) turns: bool,
    /// ω × (ω × r).
    pub(crate) swept: Vector<R>,
}

impl<R: Number> Carried<R> {
    /// Its acceleration, from that of the other.
    pub(crate) fn acceleration(&self, of: &[R; DOFS], own: &[R; DOFS]) -> [R; DOFS] {
        let turning = [of[3], of[4], of[5]];
        let [x, y, z] = add(add([of[0], of[1], of[2]], cross(turning, self.arm)), self.swept);
        let [i, j, k] = if self.turns { turning } else { [own[3], own[4], own[5]] };
        [x, y, z, i, j, k, own[6]]
    }

    /// An entry x for its degree of freedom k, as entries for the other: e_k · (θ × r) = (r × e_k) · θ.
    fn spread(&self, k: usize, x: R) -> impl Iterator<Item = (usize, R)> {
        let (start, i, j) = (DOFS * self.by, (k + 1) % 3, (k + 2) % 3);
        let turning = [(start + 3 + i, x * self.arm[j]), (start + 3 + j, -(x * self.arm[i]))];
        std::iter::once((start + k, x)).chain(turning.into_iter().filter(move |_| k < 3))
    }
}

/// The entries of rows and columns of one instant, one after the other. Those of nodes that are carried are entries of the nodes that carry them.
#[derive(Clone, Debug)]
pub(crate) struct Lines<R> {
    /// By degree of freedom, 7 for each node.
    entries: Vec<(usize, R)>,
    /// By node.
    carried: Vec<Option<Carried<R>>>,
}

/// Some of them: a row, or a column.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Line {
    from: usize,
    to: usize,
}

impl<R: Number> Lines<R> {
    /// None yet, and room for so many.
    pub(crate) fn with_capacity(count: usize, carried: Vec<Option<Carried<R>>>) -> Self {
        Self { entries: Vec::with_capacity(count), carried }
    }

    /// One more.
    pub(crate) fn add(&mut self, entries: impl IntoIterator<Item = (usize, R)>) -> Line {
        self.add_row(entries).0
    }

    /// The same, and what it gives with the part of the accelerations of nodes that no acceleration of those that carry them enters.
    pub(crate) fn add_row(&mut self, entries: impl IntoIterator<Item = (usize, R)>) -> (Line, R) {
        let from = self.entries.len();
        self.entries.extend(entries);
        let to = self.entries.len();
        let mut swept = R::ZERO;
        let carried = |carried: &[Option<Carried<R>>], dof: usize| {
            carried.get(dof / DOFS).copied().flatten().filter(|_| dof % DOFS < 6)
        };
        if !(from..to).any(|at| carried(&self.carried, self.entries[at].0).is_some()) {
            return (Line { from, to }, swept);
        }
        for (dof, x) in self.entries.split_off(from) {
            let k = dof % DOFS;
            let Some(of) = carried(&self.carried, dof) else {
                self.put(from, dof, x);
                continue;
            };
            of.spread(k, x).for_each(|(dof, x)| self.put(from, dof, x));
            swept = swept + if k < 3 { x * of.swept[k] } else { R::ZERO };
        }
        (Line { from, to: self.entries.len() }, swept)
    }

    /// The same of the two nodes of a connector; one that is none is the ground.
    pub(crate) fn add_pair(&mut self, ends: [Option<usize>; 2], row: &[R; PAIR]) -> (Line, R) {
        let from = self.entries.len();
        let mut swept = R::ZERO;
        let roots = ends.map(|end| end.map(|node| self.carried(node).map_or(node, |of| of.by)));
        if roots[0].is_some() && roots[0] == roots[1] {
            let entries = row.iter().enumerate().filter(|(_, entry)| !entry.is_nothing());
            return self.add_row(entries.filter_map(|(j, x)| Some((DOFS * ends[j / DOFS]? + j % DOFS, *x))));
        }
        for (end, root) in roots.into_iter().enumerate() {
            let (Some(node), Some(root)) = (ends[end], root) else { continue };
            let mut of: [R; DOFS] = std::array::from_fn(|k| row[DOFS * end + k]);
            if let Some(carried) = self.carried(node) {
                let force = [of[0], of[1], of[2]];
                swept = swept + dot(force, carried.swept);
                // f · (θ × r) = (r × f) · θ.
                let moment = cross(carried.arm, force);
                for (k, moment) in moment.into_iter().enumerate() {
                    let sum = of[3 + k] + moment;
                    of[3 + k] = if is_rounding(moment, sum) { R::ZERO } else { sum };
                }
            }
            for (k, entry) in of.into_iter().enumerate() {
                if !entry.is_nothing() {
                    self.entries.push((DOFS * root + k, entry));
                }
            }
        }
        (Line { from, to: self.entries.len() }, swept)
    }

    /// Adds to the entry of a degree of freedom in the line that begins there. What cancels but for rounding is nothing.
    fn put(&mut self, from: usize, dof: usize, x: R) {
        let Some(at) = (from..self.entries.len()).find(|at| self.entries[*at].0 == dof) else {
            if !x.is_nothing() {
                self.entries.push((dof, x));
            }
            return;
        };
        let sum = self.entries[at].1 + x;
        if is_rounding(x, sum) {
            self.entries.remove(at);
        } else {
            self.entries[at].1 = sum;
        }
    }

    /// The node that carries one, as it does now.
    pub(crate) fn carried(&self, node: usize) -> Option<Carried<R>> {
        self.carried.get(node).copied().flatten()
    }

    /// The entries of one.
    pub(crate) fn of(&self, line: Line) -> &[(usize, R)] {
        self.entries.get(line.from..line.to).unwrap_or_default()
    }

    /// The entries of all.
    pub(crate) fn all(&self) -> &[(usize, R)] {
        &self.entries
    }
}

/// Whether a sum cancels the part x but for rounding.
fn is_rounding<R: Number>(x: R, sum: R) -> bool {
    !(x.magnitude() * R::from_f64(8.0 * R::ROUNDING)).less(sum.magnitude())
}

/// One equation.
#[derive(Clone, Debug)]
pub(crate) struct Row<R> {
    pub(crate) owner: Owner,
    pub(crate) coefficients: Line,
    /// The nodal forces of a unit of its force, where they are not the coefficients.
    pub(crate) force: Option<Line>,
    /// What must be zero, unless only rates are prescribed.
    pub(crate) residual: Option<R>,
    /// Its rate, unless only accelerations are.
    pub(crate) rate: Option<R>,
    /// The part of its acceleration that accelerations do not enter.
    pub(crate) bias: R,
    /// The rate that is prescribed, by which its force does work.
    pub(crate) driven: R,
}

impl<R> Row<R> {
    /// The nodal forces of a unit of its force.
    pub(crate) fn force(&self) -> Line {
        self.force.unwrap_or(self.coefficients)
    }
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
    /// The forces of frictions that springs hold.
    pub(crate) held: [R; 6],
    /// The nodal forces of a unit of each component's force.
    pub(crate) columns: [Line; 6],
    /// The derivatives of each position.
    pub(crate) rows: [Line; 6],
    pub(crate) branch: Branch<R>,
}

/// All that is known of one instant before accelerations are.
#[derive(Clone, Debug)]
pub(crate) struct Assembled<R> {
    pub(crate) lines: Lines<R>,
    pub(crate) rows: Vec<Row<R>>,
    pub(crate) joints: Vec<Now<R>>,
    pub(crate) masses: Vec<R>,
    pub(crate) inertias: Vec<Matrix<R>>,
    /// The inertia of flows: none, but for paths of equilibria.
    pub(crate) flows: Vec<R>,
    /// −h: loads less what springs and rotation take.
    pub(crate) applied: Vec<R>,
    /// The power of loads, of dampers, into springs.
    pub(crate) powers: [R; WORKS],
    pub(crate) rates: Vec<[R; DOFS]>,
    /// The slip of each friction, then R_k v_k of those whose slip begins.
    pub(crate) slips: Vec<R>,
    /// The stretch of each spring or dashpot, and its rate.
    pub(crate) springs: Vec<[R; 2]>,
}

impl<R: Number> Assembled<R> {
    /// A force in a degree of freedom; that on a node that is carried acts on the one that carries it.
    pub(crate) fn act(&mut self, dof: usize, force: R) {
        let Some(of) = self.lines.carried(dof / DOFS).filter(|_| dof % DOFS < 6) else {
            self.applied[dof] = self.applied[dof] + force;
            return;
        };
        for (dof, force) in of.spread(dof % DOFS, force) {
            self.applied[dof] = self.applied[dof] + force;
        }
    }
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
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Beginnings {
    pub(crate) joints: Vec<Vec<[f64; 6]>>,
    pub(crate) nodes: Vec<Vec<[f64; 6]>>,
}

impl Beginnings {
    pub(crate) fn joint(&self, joint: usize, k: usize) -> impl Fn(usize) -> Option<f64> + '_ {
        move |step| self.joints.get(step)?.get(joint).map(|all| all[k])
    }

    pub(crate) fn node(&self, node: usize, k: usize) -> impl Fn(usize) -> Option<f64> + '_ {
        move |step| self.nodes.get(step)?.get(node).map(|all| all[k])
    }
}

/// Which degrees of freedom are unknowns, which equations count, and what stands still.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Layout {
    /// The unknowns, as degrees of freedom.
    pub(crate) columns: Vec<usize>,
    /// The unknown of each degree of freedom.
    pub(crate) place: Vec<Option<usize>>,
    /// Degrees of freedom without inertia on which nothing acts yet, and something may.
    #[serde(default)]
    pub(crate) idle: Vec<usize>,
    /// The equations that count: the others follow from them.
    pub(crate) kept: Vec<usize>,
    /// The equations whose forces are not determined: they repeat each other.
    pub(crate) open: Vec<usize>,
    /// Components that friction would hold, and others prescribe: connector and component. Of a static step.
    #[serde(default)]
    pub(crate) carried: Vec<(usize, usize)>,
    /// Sets of unknowns that equations alone determine, each with these equations.
    pub(crate) determined: Vec<(Vec<usize>, Vec<usize>)>,
    /// The equation that is nearest to a combination of those before it, and the part of it that is not.
    #[serde(skip)]
    pub(crate) nearest: Option<(f64, Owner)>,
    /// The order in which unknowns and forces of equations are eliminated; empty until it is known.
    #[serde(default)]
    pub(crate) order: Vec<usize>,
    /// What is known of the elimination in that order.
    #[serde(default)]
    pub(crate) plan: Plan,
    /// The most entries that equations have had.
    #[serde(default)]
    pub(crate) filled: usize,
}
