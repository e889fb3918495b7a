//! Degrees of freedom of nodes, and which of them boundary conditions prescribe.

use crate::scene::{
    Boundary, ConditionKind, Diagnostic, Label, LabelMap, MotionType, NodeMotion, Rotation, Scene, Target,
};
use crate::so3;
use crate::vector::Matrix;
use std::collections::{BTreeSet, HashSet};

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
        Self::prescribed(scene, step, |_| true)
    }

    /// Those of [`Fixed::in_step`] that are held where they are: displacements and rotations prescribed as zero.
    ///
    /// # Errors
    /// As [`Fixed::in_step`].
    pub fn held_in_step(scene: &Scene, step: usize) -> Result<Self, Diagnostic> {
        Self::prescribed(scene, step, |boundary| {
            boundary.kind == MotionType::Displacement && boundary.magnitude == 0.0 && !boundary.applied.user
        })
    }

    fn prescribed(
        scene: &Scene,
        step: usize,
        wanted: impl Fn(&Boundary) -> bool,
    ) -> Result<Self, Diagnostic> {
        let mut fixed = Self::default();
        let mut named = HashSet::new();
        let mut put = |freedoms: &mut HashSet<Freedom>, boundary: &Boundary| {
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
                    if is_wanted {
                        freedoms.insert(freedom);
                    } else {
                        freedoms.remove(&freedom);
                    }
                }
            }
        };
        for boundary in &scene.boundaries {
            put(&mut fixed.freedoms, boundary);
        }
        for step in scene.steps.iter().take(step) {
            if step.removes(ConditionKind::Boundary) {
                fixed.freedoms.clear();
            }
            for boundary in &step.boundaries {
                put(&mut fixed.freedoms, boundary);
            }
        }
        if !scene.transforms.is_empty() {
            for node in named {
                fixed.axes.insert(node, scene.nodal_axes(node)?);
            }
        }
        Ok(fixed)
    }

    /// The same of some nodes alone, and these besides.
    pub(crate) fn restricted(&self, nodes: &BTreeSet<Label>, besides: &[Freedom]) -> Self {
        let all = nodes.iter().flat_map(|node| NUMBERS.map(|number| Freedom { node: *node, number }));
        Self {
            freedoms: all.filter(|freedom| self.contains(*freedom)).chain(besides.iter().copied()).collect(),
            axes: nodes.iter().filter_map(|node| Some((*node, *self.axes.get(node)?))).collect(),
        }
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
    /// Of a rotation of which one component alone is fixed, that component is not zero by what turns about the others: it is left out.
    pub fn moved_by(&self, node: Label, motion: &NodeMotion) -> impl Iterator<Item = (u8, f64)> {
        let along =
            |vector: [f64; 3]| self.axes(node).map_or(vector, |axes| crate::vector::apply(axes, vector));
        let is_fixed = move |number: u8| self.contains(Freedom { node, number });
        let rotation = match motion.rotation {
            Rotation::Vector(vector) => vector,
            Rotation::Quaternion(q) => so3::log_quaternion(q),
        };
        let turns =
            if (4..=6).filter(|number| is_fixed(*number)).count() > 1 { along(rotation) } else { [0.0; 3] };
        let amounts = along(motion.displacement).into_iter().chain(turns).chain([motion.flow]);
        NUMBERS.into_iter().zip(amounts).filter(move |(number, _)| is_fixed(*number))
    }

    /// The axes along which the columns of a node are, as rows, where they are not the global ones.
    pub fn axes(&self, node: Label) -> Option<&Matrix<f64>> {
        self.axes.get(&node)
    }
}
