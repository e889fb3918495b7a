//! How many digits have the numbers that a scene gives?
//!
//! A number stands for all that round to it: half a unit of its last decimal to either side. Formats with a set number of decimals, or of digits,
//! leave none of the zeros at the end, and of a number that ends in such it is not seen which it was: so a number has no fewer decimals,
//! or no fewer digits, than half of the numbers of its kind (coordinates, or points of orientations), whichever is less exact.
//!
//! A number whose last decimal is no finer than [`NOMINAL`] of the length that it counts for is taken for what it says: nobody rounds so far, but many give
//! positions on a grid.

use crate::scene::{Definition, Label, Scene};
use std::collections::HashMap;

/// The part of a length that a unit of the last decimal is at most where a number was rounded.
const NOMINAL: f64 = 2e-3;
/// Digits of a double beyond which a number is no less exact than its rounding.
const ALL: i32 = 15;

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

/// What half of the numbers have.
#[derive(Clone, Copy, Debug)]
struct Usual([i32; 2]);

impl Usual {
    /// Of those that have decimals.
    fn of(numbers: impl Iterator<Item = f64>) -> Self {
        let all: Vec<[i32; 2]> = numbers.filter_map(digits).filter(|[decimals, _]| *decimals > 0).collect();
        let median = |k: usize| {
            let mut of: Vec<i32> = all.iter().map(|digits| digits[k]).collect();
            of.sort_unstable();
            of.get(of.len() / 2).copied().unwrap_or_default()
        };
        Self([median(0), median(1)])
    }

    /// The unit of the last decimal of a number; 0 where its rounding is no less.
    fn unit(self, number: f64) -> f64 {
        let Self([usual_decimals, usual_digits]) = self;
        if usual_decimals <= 0 {
            // Whole numbers alone are what they say.
            return 0.0;
        }
        let unit = |decimals: i32| 10.0_f64.powi(-decimals);
        let Some([decimals, significant]) = digits(number) else { return unit(usual_decimals) };
        if significant >= ALL {
            return 0.0;
        }
        // The decimals that so many significant digits make.
        let by_digits = decimals + usual_digits - significant;
        unit(decimals.max(usual_decimals.min(by_digits)))
    }
}

/// How exact the numbers of a scene are.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::audit) struct Digits {
    /// The units of the last decimals of the coordinates of nodes.
    nodes: HashMap<Label, [f64; 3]>,
    /// By how much the directions of a connector are uncertain (rad).
    directions: HashMap<Label, f64>,
}

/// Half of the largest unit of numbers that count for such a length.
fn uncertain(units: [f64; 3], length: f64) -> f64 {
    units.into_iter().filter(|unit| *unit <= NOMINAL * length).fold(0.0, f64::max) / 2.0
}

impl Digits {
    pub(in crate::audit) fn of(scene: &Scene) -> Self {
        let coordinates = || scene.nodes.values().flat_map(|node| node.coordinates);
        let usual = Usual::of(coordinates());
        let units = |point: [f64; 3], usual: Usual| {
            Some(point.map(|x| usual.unit(x))).filter(|units| *units != [0.0; 3])
        };
        let nodes =
            scene.nodes.iter().filter_map(|(label, node)| Some((*label, units(node.coordinates, usual)?)));
        let nodes = nodes.collect();
        let points = |name: &str| match &scene.orientations.get(name)?.definition {
            Definition::Coordinates { a, b, c } => Some([*a, *b, *c]),
            _ => None,
        };
        let all = scene.orientations.keys().filter_map(|name| points(name)).flatten().flatten();
        let usual = Usual::of(all);
        let of_orientation = |name: &str| -> f64 {
            let Some([a, b, c]) = points(name) else { return 0.0 };
            let of = |point: [f64; 3]| {
                let length = (0..3).map(|i| (point[i] - c[i]).powi(2)).sum::<f64>().sqrt();
                let of_both = [point, c].map(|point| uncertain(point.map(|x| usual.unit(x)), length));
                if length > 0.0 { (of_both[0] + of_both[1]) / length } else { 0.0 }
            };
            of(a).max(of(b))
        };
        let of_section: Vec<f64> = scene
            .connector_sections
            .iter()
            .map(|section| {
                let names = [&section.orientation_a, &section.orientation_b];
                names.into_iter().flatten().map(|name| of_orientation(&name.value)).sum()
            })
            .collect();
        let of_connector = |section: usize| of_section.get(section).copied().filter(|angle| *angle > 0.0);
        let directions = scene
            .connectors
            .iter()
            .filter_map(|(label, connector)| Some((*label, of_connector(connector.section)?)))
            .collect();
        Self { nodes, directions }
    }

    /// The same of some nodes and elements alone.
    pub(super) fn restricted<'a>(&self, nodes: impl Iterator<Item = &'a Label>, elements: &[Label]) -> Self {
        Self {
            nodes: nodes.filter_map(|node| Some((*node, *self.nodes.get(node)?))).collect(),
            directions: elements
                .iter()
                .filter_map(|label| Some((*label, *self.directions.get(label)?)))
                .collect(),
        }
    }

    /// By how much a node's position is uncertain, where such a length counts.
    pub(in crate::audit) fn of_node(&self, node: &Label, length: f64) -> f64 {
        self.nodes.get(node).map_or(0.0, |units| uncertain(*units, length))
    }

    /// By how much the directions of a connector are (rad).
    pub(in crate::audit) fn of_directions(&self, element: &Label) -> f64 {
        self.directions.get(element).copied().unwrap_or_default()
    }

    /// By how much a number that stands by itself is uncertain.
    pub(in crate::audit) fn of_number(number: f64) -> f64 {
        uncertain([Usual::of(std::iter::once(number)).unit(number); 3], number.abs())
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
        let unit = |all: &[f64], x: f64| Usual::of(all.iter().copied()).unit(x);
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
}
