//! How far a series of numbers is from what it must be, in units of what the file can tell.

use crate::evaluate::{Key, Of, Why};
use serde::Serialize;

/// Roundings that a program may spend on a number: relative to the largest of its kind at the state, of a matrix to that of its row.
pub(crate) const ROUNDINGS: f64 = 1e-13;

/// One number of the file beside what it must be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Point {
    /// The time, or the number of the state.
    pub at: f64,
    /// What the file has.
    pub got: f64,
    /// What the connector gives.
    pub want: f64,
    /// How far the two may be apart: the digits of the number and of the motion.
    pub allowed: f64,
}

impl Point {
    /// The difference in units of what is allowed.
    pub fn units(&self) -> f64 {
        let apart = (self.got - self.want).abs();
        if apart == 0.0 { 0.0 } else { apart / self.allowed }
    }

    /// Whether the difference is one.
    pub fn is_wrong(&self) -> bool {
        // What is no number is wrong.
        self.units() > 1.0 || self.units().is_nan()
    }
}

/// One output of one connector or node along a run, or the entries of one matrix.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Series {
    /// The element or node; of a matrix its file.
    pub element: String,
    /// Its type.
    pub type_name: String,
    /// The output as headings name it: CU1, CUR3, CTM2, RF1.
    pub name: String,
    /// What that is; of a matrix none.
    #[serde(skip)]
    pub(crate) of: Option<Of>,
    /// How many numbers were compared.
    pub compared: u64,
    /// How many are apart by more than is allowed.
    pub wrong: u64,
    /// How many there are from the first of those on.
    #[serde(skip)]
    pub(crate) since: u64,
    /// The first that is.
    pub first: Option<Point>,
    /// Of a matrix, the entry of that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub entry: Option<String>,
    /// The worst of all, in units of what is allowed.
    pub worst: Option<Point>,
    /// That of the largest number: what is allowed there says how much an error must be to be seen.
    #[serde(skip)]
    pub(crate) largest: Option<Point>,
    /// Why, where that is known.
    pub cause: Option<String>,
    /// Some of the points, one after the other: all, or those about the first that is wrong.
    #[serde(skip)]
    pub points: Vec<Point>,
}

impl Series {
    pub(crate) fn new((element, of): &Key, type_name: String) -> Self {
        Self { of: Some(*of), ..Self::of_matrix(element.clone(), type_name, of.name()) }
    }

    pub(crate) const fn of_matrix(element: String, type_name: String, name: String) -> Self {
        Self {
            element,
            type_name,
            name,
            of: None,
            compared: 0,
            wrong: 0,
            since: 0,
            largest: None,
            first: None,
            entry: None,
            worst: None,
            cause: None,
            points: Vec::new(),
        }
    }

    /// Takes a point; of all, so many are kept.
    pub(crate) fn add(&mut self, point: Point, kept: usize) {
        self.compared += 1;
        keep(&mut self.points, point, (kept, self.wrong > 0));
        if point.is_wrong() {
            self.wrong += 1;
            self.first.get_or_insert(point);
        }
        self.since += u64::from(self.first.is_some());
        if self.largest.is_none_or(|largest| point.want.abs() > largest.want.abs()) {
            self.largest = Some(point);
        }
        if self.worst.is_none_or(|worst| point.units() > worst.units()) {
            self.worst = Some(point);
        }
    }

    /// Whether it is an angle.
    pub(crate) fn is_angle(&self) -> bool {
        self.of.is_some_and(Of::is_angle)
    }

    /// The part of the largest number by which it may be wrong unseen.
    pub(crate) fn unseen(&self) -> f64 {
        self.largest.filter(|of| of.want != 0.0).map_or(0.0, |of| of.allowed / of.want.abs())
    }
}

/// Keeps an item: until something is wrong the last ones, and from then on those that follow.
fn keep<T>(all: &mut Vec<T>, item: T, (kept, is_wrong): (usize, bool)) {
    if !is_wrong && all.len() >= kept / 2 {
        all.drain(..kept.div_ceil(4));
    }
    if all.len() < kept {
        all.push(item);
    }
}

/// An output of the file that is not compared.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Unjudged {
    /// The element or node.
    pub element: String,
    /// The output.
    pub name: String,
    /// How many numbers.
    pub count: u64,
    /// Why.
    pub why: Why,
}

/// What a file cannot tell.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Gap {
    /// In words.
    pub what: String,
    /// The lines of a deck for Abaqus that close it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub request: Vec<String>,
}

/// What a comparison found.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Comparison {
    /// How many frames were read.
    pub frames: u64,
    /// How many of them had a motion.
    pub moved: u64,
    /// How many got a motion between those of the files.
    pub between: u64,
    /// By element and output.
    pub series: Vec<Series>,
    /// What was not compared.
    pub unjudged: Vec<Unjudged>,
    /// One convention that explains everything that is wrong, and the line of the map that declares it.
    pub cause: Option<String>,
    /// What the file cannot tell, and what to print to close the gap.
    pub gaps: Vec<Gap>,
    /// The headings of no known meaning.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unread: Vec<String>,
}

impl Comparison {
    /// How many numbers were compared.
    pub fn compared(&self) -> u64 {
        self.series.iter().map(|series| series.compared).sum()
    }

    /// How many of them are wrong.
    pub fn wrong(&self) -> u64 {
        self.series.iter().map(|series| series.wrong).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_holds_the_first_that_is_wrong() {
        for wrong in [0, 3, 700, 9_999] {
            let mut series = Series::of_matrix(String::new(), String::new(), String::new());
            for n in 0..10_000 {
                let at = f64::from(n);
                series.add(Point { at, got: f64::from(u8::from(n >= wrong)), want: 0.0, allowed: 0.5 }, 100);
            }
            assert!(
                series.points.len() <= 100 && series.points.iter().any(|point| point.at == f64::from(wrong))
            );
            assert!(series.points.windows(2).all(|pair| pair[1].at == pair[0].at + 1.0));
            assert_eq!((series.compared, series.wrong), (10_000, 10_000 - u64::from(wrong as u32)));
        }
    }
}
