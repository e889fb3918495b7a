//! What was written where the coordinates of a scene are computed: of nodes in cylindrical coordinates, and of the nodes and orientations of instances.
//!
//! Of generated nodes that is not known: they count as written with the digits that their doubles have.

use crate::label::Label;
use crate::label::labelled::LabelMap;
use crate::orientation::{Definition, minus, sin_cos_degrees};
use std::collections::HashMap;

/// A translation, and after it a rotation about an axis that stays where it is given.
#[derive(Debug, Clone, Copy)]
pub struct Placement {
    pub(crate) translation: [f64; 3],
    /// The rotation matrix, by rows, and a point of the axis.
    pub(crate) rotation: Option<([[f64; 3]; 3], [f64; 3])>,
}

/// The numbers of a node, and the place of its placement plus 1; 0 is none.
#[derive(Debug, Clone, Copy)]
struct Numbers {
    numbers: [f64; 3],
    placement: u32,
    is_cylindrical: bool,
}

/// What was written, of those nodes and orientations that the scene has otherwise.
#[derive(Debug, Clone, Default)]
pub struct Written {
    nodes: LabelMap<Numbers>,
    placements: Vec<Placement>,
    orientations: HashMap<String, Definition>,
}

/// The coordinates of a node as they are written.
#[derive(Debug, Clone, Copy)]
pub struct WrittenNode<'a> {
    /// x, y, z, or r, θ (degrees), z.
    pub(crate) numbers: [f64; 3],
    pub(crate) is_cylindrical: bool,
    /// What moves it from there.
    pub(crate) placement: Option<&'a Placement>,
}

fn length(v: [f64; 3]) -> f64 {
    v[0].hypot(v[1]).hypot(v[2])
}

impl WrittenNode<'_> {
    /// Where it is before it is moved: x, y, z.
    pub(crate) fn before(&self) -> [f64; 3] {
        let [r, angle, z] = self.numbers;
        if !self.is_cylindrical {
            return self.numbers;
        }
        let (sine, cosine) = sin_cos_degrees(angle);
        [r * cosine, r * sine, z]
    }

    /// Lengths, for each coordinate: times the rounding unit u they bound what reading and computing it leaves open, beside u times
    /// its own size. Of r cos θ that is r (5 + |θ|): of r, of θ itself, of its conversion to rad and of the cosine. Of a rotation
    /// `R (x − a) + a` it is the same for all three. It is the length of what x is known to, of x and twice of a, and 32 times that
    /// of the arm x − a. The 32 are for entries of R of 16 u and sums of three.
    pub fn sizes(&self) -> [f64; 3] {
        /// Of a sine or cosine, beside the angle.
        const TURN: f64 = 5.0;
        /// Of a product with a rotation matrix.
        const ROTATION: f64 = 32.0;
        let at = self.before();
        let mut sizes = at.map(f64::abs);
        if self.is_cylindrical {
            let [r, angle, _] = self.numbers;
            let arc = r.abs() * (TURN + angle.to_radians().abs());
            (sizes[0], sizes[1]) = (arc, arc);
        }
        let Some(Placement { translation, rotation }) = self.placement else { return sizes };
        let moved: [f64; 3] = std::array::from_fn(|i| at[i] + translation[i]);
        for (size, by) in sizes.iter_mut().zip(translation) {
            *size += by.abs();
        }
        let Some((_, on_axis)) = rotation else { return sizes };
        let arm = length(minus(moved, *on_axis));
        [length(sizes) + length(moved) + 2.0 * length(*on_axis) + ROTATION * arm; 3]
    }
}

impl Written {
    /// A node, if its coordinates are not those that are written.
    pub fn node(&self, label: &Label) -> Option<WrittenNode<'_>> {
        let Numbers { numbers, placement, is_cylindrical } = *self.nodes.get(label)?;
        let place = usize::try_from(placement).ok()?.checked_sub(1);
        Some(WrittenNode { numbers, is_cylindrical, placement: place.and_then(|at| self.placements.get(at)) })
    }

    /// The points of an orientation, in the axes of its part, if they are not those of the scene.
    pub(crate) fn orientation(&self, name: &str) -> Option<&Definition> {
        self.orientations.get(name)
    }

    pub(super) fn add_cylindrical(&mut self, label: Label, numbers: [f64; 3]) {
        self.nodes.insert(label, Numbers { numbers, placement: 0, is_cylindrical: true });
    }

    pub(super) fn add_orientation(&mut self, name: String, definition: Definition) {
        self.orientations.insert(name, definition);
    }

    /// Remembers a placement for nodes of an instance, and gives its place plus 1; 0 where it moves nothing.
    pub(super) fn add_placement(&mut self, placement: &Placement) -> u32 {
        if placement.rotation.is_none() && placement.translation == [0.0; 3] {
            return 0;
        }
        self.placements.push(*placement);
        u32::try_from(self.placements.len()).unwrap_or(0)
    }

    /// A node of an instance: `label` in the part, where it is at `at`; `placed` in the assembly.
    pub(super) fn place(
        &mut self,
        part: &Self,
        (label, at): (Label, [f64; 3]),
        placed: Label,
        placement: u32,
    ) {
        let known = part.nodes.get(&label).copied();
        if known.is_none() && placement == 0 {
            return;
        }
        let written = known.unwrap_or(Numbers { numbers: at, placement: 0, is_cylindrical: false });
        self.nodes.insert(placed, Numbers { placement, ..written });
    }
}
