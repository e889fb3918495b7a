//! How many digits have the numbers that a scene gives?
//!
//! A number stands for all that round to it: half a unit of its last decimal to either side. Formats with a set number of decimals,
//! or of digits, may leave out the zeros at the end, and a number without them does not show which it was. So a number has no fewer
//! decimals, or no fewer digits, than half of the numbers of its kind (coordinates, or points of orientations), whichever is less
//! exact.
//!
//! A number whose last decimal is no finer than [`NOMINAL`] of the length that it counts for is taken for what it says: nobody rounds so far, but many give
//! positions on a grid.
//!
//! Numbers are those that were written:
//! - of nodes in cylindrical coordinates r, θ and z;
//! - of those of an instance the ones in its part, with as many decimals as its translation has if these are more;
//! - of orientations by nodes those of the nodes.
//!
//! The placement of an instance is exact otherwise. Of generated nodes the numbers that they come of are not known: their
//! coordinates count.

use crate::{
    ConnectorElement, Definition, Label, NodeMotion, Placement, Rotation, Scene, State, WrittenNode,
};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::vector::sub;
use std::collections::HashMap;

/// The part of a length that a unit of the last decimal is at most where a number was rounded.
const NOMINAL: f64 = 2e-3;
/// Digits of a double beyond which a number is no less exact than its rounding.
const ALL: i32 = 15;
/// The digits beyond which single precision does not have them all: the last one is uncertain by a unit.
const SINGLE: f64 = 1e6;

/// Of a number that is not zero: the decimals, and the significant digits, of the shortest one that stands for the same double.
fn digits(number: f64) -> Option<[i32; 2]> {
    if number == 0.0 || !number.is_finite() {
        return None;
    }
    let text = format!("{number:e}");
    let (mantissa, exponent) = text.split_once('e')?;
    let significant = mantissa.bytes().filter(u8::is_ascii_digit).count() as i32;
    Some([significant - 1 - exponent.parse::<i32>().ok()?, significant])
}

/// Those of the sum of two numbers, which has the decimals of either.
fn digits_of_sum(x: f64, y: f64) -> Option<[i32; 2]> {
    let (Some(of_x), Some(of_y)) = (digits(x), digits(y)) else { return digits(x).or_else(|| digits(y)) };
    let [decimals, significant] = digits(x + y)?;
    let all = of_x[1].max(of_y[1]);
    let more = of_x[0].max(of_y[0]);
    Some([more, if all >= ALL { all } else { significant + more - decimals }])
}

/// What half of the numbers have.
#[derive(Clone, Copy, Debug)]
struct Usual([i32; 2]);

impl Usual {
    /// Of those that have decimals.
    fn of(numbers: impl Iterator<Item = Option<[i32; 2]>>) -> Self {
        let all: Vec<[i32; 2]> = numbers.flatten().filter(|[decimals, _]| *decimals > 0).collect();
        let median = |k: usize| {
            let mut of: Vec<i32> = all.iter().map(|digits| digits[k]).collect();
            of.sort_unstable();
            of.get(of.len() / 2).copied().unwrap_or_default()
        };
        Self([median(0), median(1)])
    }

    /// The unit of the last decimal of a number with such digits, none of which is zero; 0 where its rounding is no less.
    fn unit(self, digits: Option<[i32; 2]>) -> f64 {
        let Self([usual_decimals, usual_digits]) = self;
        if usual_decimals <= 0 {
            // Whole numbers alone are what they say.
            return 0.0;
        }
        let unit = |decimals: i32| 10.0_f64.powi(-decimals);
        let Some([decimals, significant]) = digits else { return unit(usual_decimals) };
        if significant >= ALL {
            return 0.0;
        }
        // The decimals that so many significant digits make.
        let by_digits = decimals + usual_digits - significant;
        unit(decimals.max(usual_decimals.min(by_digits)))
    }
}

/// The digits of the numbers of a node.
struct OfNode {
    /// Of x, y, z, or of r, θ (degrees), z.
    digits: [Option<[i32; 2]>; 3],
    /// r, where they are cylindrical.
    radius: Option<f64>,
    is_turned: bool,
}

impl OfNode {
    fn of(scene: &Scene, label: &Label, coordinates: [f64; 3]) -> Self {
        let Some(WrittenNode { numbers, is_cylindrical, placement }) = scene.written.node(label) else {
            return Self { digits: coordinates.map(digits), radius: None, is_turned: false };
        };
        let translation = placement.map_or([0.0; 3], |placement| placement.translation);
        let is_moved = |i: usize| i == 2 || !is_cylindrical;
        let of = |i: usize| digits_of_sum(numbers[i], if is_moved(i) { translation[i] } else { 0.0 });
        let is_turned = placement.is_some_and(|Placement { rotation, .. }| rotation.is_some());
        let radius = is_cylindrical.then_some(numbers[0].abs());
        Self { digits: std::array::from_fn(of), radius, is_turned }
    }

    /// The units of its numbers, as lengths.
    fn units(&self, lengths: Usual, angles: Usual) -> Units {
        let mut units = self.digits.map(|digits| lengths.unit(digits));
        if let Some(radius) = self.radius {
            units[1] = radius * angles.unit(self.digits[1]).to_radians();
        }
        Units { units, is_mixed: self.is_turned || self.radius.is_some() }
    }
}

/// The units of the last decimals of the numbers that a position comes of, as lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Units {
    units: [f64; 3],
    /// Whether each coordinate comes of all of them.
    is_mixed: bool,
}

impl Units {
    /// Half of those that count for such a length: what the position is known to, along axes that may be others than the coordinates'.
    fn halves(&self, length: f64) -> [f64; 3] {
        self.units.map(|unit| if unit <= NOMINAL * length { unit / 2.0 } else { 0.0 })
    }

    /// By how much a coordinate is uncertain at most: where it comes of all numbers, by the Euclidean length of their halves.
    fn uncertain(&self, length: f64) -> f64 {
        let halves = self.halves(length);
        if self.is_mixed { norm(halves) } else { halves.into_iter().fold(0.0, f64::max) }
    }
}

/// How exact the numbers of a scene are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Digits {
    nodes: HashMap<Label, Units>,
    /// By how much the directions of a connector are uncertain (rad).
    directions: HashMap<Label, f64>,
}

/// Half of the largest unit of numbers that count for such a length.
fn uncertain(units: [f64; 3], length: f64) -> f64 {
    Units { units, is_mixed: false }.uncertain(length)
}

/// The orientations of a scene, as they are written.
struct Orientations<'a> {
    scene: &'a Scene,
    nodes: &'a HashMap<Label, Units>,
    usual: Usual,
}

impl<'a> Orientations<'a> {
    fn new(scene: &'a Scene, nodes: &'a HashMap<Label, Units>) -> Self {
        let points = |name: &String| match definition(scene, name)? {
            Definition::Coordinates { a, b, c } => Some([*a, *b, *c]),
            _ => None,
        };
        let all = scene.orientations.keys().filter_map(points).flatten().flatten();
        Self { scene, nodes, usual: Usual::of(all.map(digits)) }
    }

    /// By how much a point is uncertain that counts for a direction of such a length.
    fn of_node(&self, node: Label, length: f64) -> f64 {
        self.nodes.get(&node).map_or(0.0, |units| units.uncertain(length))
    }

    /// By how much the direction from node c, or from the origin of its part, to another is uncertain (rad).
    fn along_nodes(&self, node: Label, c: Option<Label>) -> f64 {
        let at = |label: Label| self.scene.nodes.get(&label).map(|node| node.coordinates);
        let from_origin = || self.scene.written.node(&node).map(|node| node.before()).or_else(|| at(node));
        let arm = match c {
            None => from_origin(),
            Some(c) => at(node).zip(at(c)).map(|(a, c)| sub(a, c)),
        };
        let length = norm(arm.unwrap_or_default());
        let of_both = self.of_node(node, length) + c.map_or(0.0, |c| self.of_node(c, length));
        if length > 0.0 { of_both / length } else { 0.0 }
    }

    /// The same from point c, given by coordinates.
    fn along_points(&self, point: [f64; 3], c: [f64; 3]) -> f64 {
        let length = norm(sub(point, c));
        let of_both = [point, c].map(|point| uncertain(point.map(|x| self.usual.unit(digits(x))), length));
        if length > 0.0 { (of_both[0] + of_both[1]) / length } else { 0.0 }
    }

    /// By how much an orientation is uncertain for an element (rad): by its points, and by half the last decimal of its additional rotation.
    fn uncertain(&self, name: &str, element: &ConnectorElement) -> f64 {
        let Some(definition) = definition(self.scene, name) else { return 0.0 };
        let of_points = match definition {
            Definition::Coordinates { a, b, c } => self.along_points(*a, *c).max(self.along_points(*b, *c)),
            Definition::Nodes { a, b, c } => self.along_nodes(*a, *c).max(self.along_nodes(*b, *c)),
            Definition::OffsetToNodes { a, b, c } => {
                let nodes: Vec<Label> = [element.a, element.b].into_iter().flatten().collect();
                let node = |number: u64| nodes.get(usize::try_from(number).ok()?.checked_sub(1)?).copied();
                let c = node(c.unwrap_or(1));
                let of = |number: u64| node(number).map_or(0.0, |node| self.along_nodes(node, c));
                of(*a).max(of(*b))
            }
            Definition::None => 0.0,
        };
        let angle = self.scene.orientations.get(name).map_or(0.0, |orientation| orientation.angle);
        of_points + Digits::of_number(angle).to_radians()
    }
}

/// The points of an orientation as they are written.
fn definition<'a>(scene: &'a Scene, name: &str) -> Option<&'a Definition> {
    scene.written.orientation(name).or_else(|| Some(&scene.orientations.get(name)?.definition))
}

/// Whether an orientation is another for each element.
fn is_of_element(scene: &Scene, name: &str) -> bool {
    matches!(definition(scene, name), Some(Definition::OffsetToNodes { .. }))
}

impl Digits {
    /// The digits that a scene has its numbers with.
    pub fn of(scene: &Scene) -> Self {
        let of_nodes =
            || scene.nodes.iter().map(|(label, node)| (*label, OfNode::of(scene, label, node.coordinates)));
        let is_angle = |node: &OfNode, i: usize| i == 1 && node.radius.is_some();
        let numbers = |angles: bool| {
            let of = move |(_, node): (Label, OfNode)| {
                std::array::from_fn(|i| node.digits[i].filter(|_| is_angle(&node, i) == angles))
            };
            Usual::of(of_nodes().flat_map::<[Option<[i32; 2]>; 3], _>(of))
        };
        let (lengths, angles) = (numbers(false), numbers(true));
        let units = |(label, node): (Label, OfNode)| {
            Some((label, node.units(lengths, angles))).filter(|(_, units)| units.units != [0.0; 3])
        };
        let nodes: HashMap<Label, Units> = of_nodes().filter_map(units).collect();
        let orientations = Orientations::new(scene, &nodes);
        let mut of_section: HashMap<usize, f64> = HashMap::new();
        let mut directions = HashMap::new();
        for (label, element) in &scene.connectors {
            let Some(section) = scene.section(element) else { continue };
            let names = || {
                let both = [&section.orientation_a, &section.orientation_b].into_iter().flatten();
                both.map(|name| name.value.as_str())
            };
            let sum = || names().map(|name| orientations.uncertain(name, element)).sum::<f64>();
            let angle = if names().any(|name| is_of_element(scene, name)) {
                sum()
            } else {
                *of_section.entry(element.section).or_insert_with(sum)
            };
            if angle > 0.0 {
                directions.insert(*label, angle);
            }
        }
        Self { nodes, directions }
    }

    /// By how much a coordinate of a node is uncertain at most, where such a length counts.
    pub fn of_node(&self, node: &Label, length: f64) -> f64 {
        self.nodes.get(node).map_or(0.0, |units| units.uncertain(length))
    }

    /// By how much what has such derivatives by the coordinates of a node is.
    pub fn of_position(&self, node: &Label, length: f64, row: [f64; 3]) -> f64 {
        let Some(units) = self.nodes.get(node) else { return 0.0 };
        // |∂p/∂x · δ| ≤ |∂p/∂x| |δ|, whatever the axes of δ are.
        let size = if units.is_mixed { norm(row) } else { row.iter().map(|x| x.abs()).sum() };
        size * units.uncertain(length)
    }

    /// By how much the directions of a connector are (rad).
    pub fn of_directions(&self, element: &Label) -> f64 {
        self.directions.get(element).copied().unwrap_or_default()
    }

    /// By how much a number that stands by itself is uncertain.
    pub fn of_number(number: f64) -> f64 {
        let given = digits(number);
        uncertain([Usual::of(std::iter::once(given)).unit(given); 3], number.abs())
    }
}

/// How exact the numbers of a state are that is given. They are results, of single precision as a rule. Where that has not all of
/// the digits that a number is written with, its last decimal is uncertain by a unit, and not by half of one.
#[derive(Clone, Copy, Debug)]
pub struct DigitsOfState {
    displacement: Usual,
    vector: Usual,
    quaternion: Usual,
}

impl DigitsOfState {
    /// The digits that a state has its numbers with.
    pub fn of(state: &State) -> Self {
        let motions = || state.nodes.values();
        let displacement = motions().flat_map(|motion| motion.displacement);
        let vector = motions().filter_map(|motion| match motion.rotation {
            Rotation::Vector(vector) => Some(vector),
            Rotation::Quaternion(_) => None,
        });
        let quaternion = motions().filter_map(|motion| match motion.rotation {
            Rotation::Vector(_) => None,
            Rotation::Quaternion(quaternion) => Some(quaternion),
        });
        Self {
            displacement: Usual::of(displacement.map(digits)),
            vector: Usual::of(vector.flatten().map(digits)),
            quaternion: Usual::of(quaternion.flatten().map(digits)),
        }
    }

    /// By how much numbers of a size, together, are uncertain.
    fn each<const N: usize>(usual: Usual, numbers: [f64; N], size: f64) -> [f64; N] {
        numbers.map(|number| {
            let unit = usual.unit(digits(number));
            let is_single = (SINGLE..10.0 * SINGLE).contains(&(number.abs() / unit).round());
            let counts = unit <= NOMINAL * size;
            if !counts {
                0.0
            } else if is_single {
                unit
            } else {
                unit / 2.0
            }
        })
    }

    /// By how much a displacement is uncertain along each axis, and a rotation in all (rad).
    pub fn of_motion(&self, motion: &NodeMotion) -> ([f64; 3], f64) {
        let displacement = Self::each(self.displacement, motion.displacement, norm(motion.displacement));
        let angle = match motion.rotation {
            Rotation::Vector(vector) => norm(Self::each(self.vector, vector, norm(vector))),
            // Of a quaternion the half angle.
            Rotation::Quaternion(quaternion) => 2.0 * norm(Self::each(self.quaternion, quaternion, 1.0)),
        };
        (displacement, angle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_and_digits_are_counted() {
        assert_eq!(digits(0.0), None);
        assert_eq!(digits(1500.0), Some([-2, 2]));
        assert_eq!(digits(-0.03672), Some([5, 4]));
        assert_eq!(digits(12.5), Some([1, 3]));
        assert_eq!(digits(0.1 + 0.2), Some([17, 17]));
    }

    /// By decimals, by digits, all of them, and on a grid.
    #[test]
    fn a_number_is_as_exact_as_those_of_its_kind() {
        let unit = |all: &[f64], x: f64| Usual::of(all.iter().copied().map(digits)).unit(digits(x));
        let decimals = [0.12345, 12.34567, 3.45678, 0.5];
        assert_eq!([0.12345, 0.5, 3.45678].map(|x| unit(&decimals, x)), [1e-5; 3]);
        assert_eq!(unit(&decimals, 0.0), 1e-5);
        let digits = [123.456, 0.00123457, 1.23457, 0.123457];
        assert_eq!([123.456, 0.00123457, 0.12].map(|x| unit(&digits, x)), [1e-3, 1e-8, 1e-6]);
        assert_eq!(unit(&[0.1 + 0.2, 1.0 / 3.0, 0.7], 1.0 / 3.0), 0.0);
        let grid = [0.25, 0.5, 12.25];
        assert_eq!(uncertain(grid.map(|x| unit(&grid, x)), 0.25), 0.0);
        assert_eq!(uncertain([1e-5; 3], 1.0), 0.5e-5);
        assert_eq!([0.25, 2.0, 1.2345].map(Digits::of_number), [0.0, 0.0, 0.5e-4]);
    }

    /// A sum has the decimals of its terms, however many its double has.
    #[test]
    fn sums_have_the_decimals_of_their_terms() {
        assert_eq!(digits_of_sum(1001.1, -1000.0), Some([1, 2]));
        assert_eq!(digits_of_sum(0.1, 0.2), Some([1, 1]));
        assert_eq!(digits_of_sum(0.1234, 12.5), Some([4, 6]));
        assert_eq!(digits_of_sum(0.0, -0.25), Some([2, 2]));
        assert_eq!(digits_of_sum(0.5, -0.5), None);
        assert_eq!(digits_of_sum(1.0 / 3.0, 2.0).map(|[_, digits]| digits >= ALL), Some(true));
    }
}
