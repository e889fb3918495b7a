//! Degrees of freedom of nodes, and which of them boundary conditions prescribe.

use pintle_kinematics::so3;
use pintle_kinematics::vector::Matrix;
use pintle_scene::{
    AmplitudeValue, Application, Boundary, ConditionKind, Diagnostic, Label, LabelMap, MotionType,
    NodeMotion, Rotation, Scene, Solver, Target,
};
use std::collections::{HashMap, HashSet};

/// The numbers of the degrees of freedom of a node, in the order of its columns.
pub(crate) const NUMBERS: [u8; 7] = [1, 2, 3, 4, 5, 6, 10];

/// A column: a degree of freedom of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize)]
pub struct Freedom {
    /// The node.
    pub node: Label,
    /// 1 to 3 displacements, 4 to 6 rotations, 10 material flow.
    pub number: u8,
}

/// Degrees of freedom that are no unknowns, and the axes of nodes in which that is said.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fixed {
    freedoms: HashSet<Freedom>,
    /// e_1, e_2, e_3 as rows.
    axes: LabelMap<Matrix<f64>>,
}

impl FromIterator<Freedom> for Fixed {
    fn from_iter<I: IntoIterator<Item = Freedom>>(freedoms: I) -> Self {
        Self { freedoms: freedoms.into_iter().collect(), axes: LabelMap::default() }
    }
}

impl Fixed {
    /// None.
    pub fn none() -> Self {
        Self::default()
    }

    /// Those that boundary conditions prescribe at the beginning of the analysis: those given before the first step, and in it. A
    /// degree of freedom whose value is given is no unknown, whatever the value.
    ///
    /// # Errors
    /// As [`Fixed::in_step`].
    pub fn of(scene: &Scene) -> Result<Self, Diagnostic> {
        Self::in_step(scene, 1)
    }

    /// Those that boundary conditions prescribe in a step, counted from 1; 0 is before the first. `OP=NEW` takes away those before.
    ///
    /// # Errors
    /// The points of a `*TRANSFORM` that define no directions.
    pub fn in_step(scene: &Scene, step: usize) -> Result<Self, Diagnostic> {
        Self::prescribed(scene, step, |_| true, |_, _| true)
    }

    /// Those of [`Fixed::in_step`] that are held: displacements and rotations prescribed as zero that no earlier step prescribed otherwise.
    /// What was, returns or stays where it is: it is driven.
    ///
    /// A boundary condition holds with the magnitude zero, whatever its amplitude, unless that is absolute, and with `FIXED`. In
    /// Explicit it also holds with a velocity of zero, and with an acceleration of zero unless the scene has initial conditions.
    /// What `USER`, `IMAGINARY` and `LOAD CASE` hold is not known.
    ///
    /// # Errors
    /// As [`Fixed::in_step`].
    pub fn held_in_step(scene: &Scene, step: usize) -> Result<Self, Diagnostic> {
        Self::prescribed(scene, step, |boundary| holds(scene, boundary), |_, earlier| !earlier.moves)
    }

    /// Those of [`Fixed::held_in_step`] that are known to be zero throughout the step, being held in all steps before it too. What was
    /// free is somewhere else when the step begins, and need not be zero before it ends.
    ///
    /// # Errors
    /// As [`Fixed::in_step`].
    pub fn resting_in_step(scene: &Scene, step: usize) -> Result<Self, Diagnostic> {
        let stays = |step, earlier: Earlier| step <= 1 || earlier.is_removed;
        Self::prescribed(scene, step, |boundary| holds(scene, boundary), stays)
    }

    /// Those whose last boundary condition is `wanted`, where `joins` allows it, from the step of that and what earlier steps said.
    fn prescribed(
        scene: &Scene,
        step: usize,
        wanted: impl Fn(&Boundary) -> bool,
        joins: impl Fn(usize, Earlier) -> bool,
    ) -> Result<Self, Diagnostic> {
        let mut fixed = Self::default();
        let mut named = HashSet::new();
        // The first step in which something else was prescribed.
        let mut moved: HashMap<Freedom, usize> = HashMap::new();
        let mut put = |freedoms: &mut HashSet<Freedom>,
                       boundary: &Boundary,
                       (removed, step): (&HashSet<Freedom>, usize)| {
            let nodes: &[Label] = match &boundary.target.value {
                Target::Label(label) => std::slice::from_ref(label),
                Target::Set(name) => {
                    scene.node_sets.get(name.as_str()).map_or(&[], |set| set.labels.as_slice())
                }
            };
            named.extend(nodes);
            let is_wanted = wanted(boundary);
            for node in nodes {
                for freedom in
                    boundary.degrees_of_freedom.iter().map(|number| Freedom { node: *node, number: *number })
                {
                    if !is_wanted {
                        freedoms.remove(&freedom);
                        moved.entry(freedom).or_insert(step);
                        continue;
                    }
                    let moves = moved.get(&freedom).is_some_and(|first| *first < step);
                    if joins(step, Earlier { moves, is_removed: removed.contains(&freedom) }) {
                        freedoms.insert(freedom);
                    }
                }
            }
        };
        let none = HashSet::new();
        for boundary in &scene.boundaries {
            put(&mut fixed.freedoms, boundary, (&none, 0));
        }
        for (number, step) in (1..).zip(scene.steps.iter().take(step)) {
            let is_renewed = step.removes(ConditionKind::Boundary);
            let removed = if is_renewed { std::mem::take(&mut fixed.freedoms) } else { HashSet::new() };
            for boundary in &step.boundaries {
                put(&mut fixed.freedoms, boundary, (&removed, number));
            }
        }
        if !scene.transforms.is_empty() {
            for node in named {
                fixed.axes.insert(node, scene.nodal_axes(node)?);
            }
        }
        Ok(fixed)
    }

    /// The degrees of freedom.
    pub fn iter(&self) -> impl Iterator<Item = Freedom> + '_ {
        self.freedoms.iter().copied()
    }

    /// Whether a degree of freedom is fixed.
    pub fn contains(&self, freedom: Freedom) -> bool {
        self.freedoms.contains(&freedom)
    }

    /// By how much a motion of a node moves what is fixed of it: the number of the degree of freedom, and an angle (rad) or a length.
    ///
    /// Of a rotation of which one component alone is fixed, that component is not zero by what turns about the others: it is left out, unless
    /// the node turns about the axis of that component alone, as in the plane.
    pub fn moved_by(&self, node: Label, motion: &NodeMotion) -> impl Iterator<Item = (u8, f64)> {
        let along = |vector: [f64; 3]| {
            self.axes(node).map_or(vector, |axes| pintle_kinematics::vector::apply(axes, vector))
        };
        let is_fixed = move |number: u8| self.contains(Freedom { node, number });
        let rotation = match motion.rotation {
            Rotation::Vector(vector) => vector,
            Rotation::Quaternion(q) => so3::log_quaternion(q),
        };
        let turned = along(rotation);
        let fixed = [4, 5, 6].map(is_fixed);
        let is_alone =
            |i: usize| fixed[i] && (0..3).all(|j| j == i || is_nothing_beside(turned[j], turned[i]));
        let is_told = fixed.iter().filter(|is| **is).count() > 1 || (0..3).any(is_alone);
        let turns = if is_told { turned } else { [0.0; 3] };
        let amounts = along(motion.displacement).into_iter().chain(turns).chain([motion.flow]);
        NUMBERS.into_iter().zip(amounts).filter(move |(number, _)| is_fixed(*number))
    }

    /// The axes along which the columns of a node are, as rows, where they are not the global ones.
    pub fn axes(&self, node: Label) -> Option<&Matrix<f64>> {
        self.axes.get(&node)
    }
}

/// What steps before one say of a degree of freedom.
#[derive(Clone, Copy)]
struct Earlier {
    /// It was prescribed otherwise.
    moves: bool,
    /// It was among those sought, until the step removed its boundary condition.
    is_removed: bool,
}

/// Whether a component of a rotation vector is what the digits of states leave of zero, beside another one.
fn is_nothing_beside(component: f64, other: f64) -> bool {
    const DIGITS: f64 = 1e-6;
    component.abs() <= DIGITS * other.abs()
}

/// Whether what is at zero stays there under a boundary condition.
fn holds(scene: &Scene, Boundary { applied, magnitude, kind, .. }: &Boundary) -> bool {
    keeps_zero(scene, (*kind, *magnitude), applied)
}

/// Whether what is at zero stays there where that is prescribed.
pub fn keeps_zero(scene: &Scene, (kind, magnitude): (MotionType, f64), applied: &Application) -> bool {
    if applied.user || applied.imaginary || applied.load_case.is_some() {
        return false;
    }
    let is_explicit = scene.solver == Some(Solver::Explicit);
    let stays = match kind {
        MotionType::Displacement => true,
        MotionType::Velocity => is_explicit,
        // At the velocity that there is.
        MotionType::Acceleration => {
            let others = scene.skipped.keywords.contains_key("INITIAL CONDITIONS");
            is_explicit && !others && scene.initial_velocities.is_empty()
        }
    };
    applied.fixed || (stays && magnitude == 0.0 && is_factor(scene, applied))
}

/// Whether what changes in time multiplies the magnitude: there is no amplitude, or a relative one.
fn is_factor(scene: &Scene, applied: &Application) -> bool {
    applied.amplitude.as_ref().is_none_or(|name| {
        let amplitude = scene.amplitudes.get(name.value.as_str());
        amplitude.is_some_and(|amplitude| amplitude.value != Some(AmplitudeValue::Absolute))
    })
}
