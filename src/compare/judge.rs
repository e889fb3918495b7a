//! How far a series of numbers is from what it must be, in units of what the file can tell.

use serde::Serialize;

/// How many points of a series are kept for the search for a cause, and for pictures.
pub(crate) const KEPT: usize = 4_000;

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

/// One output of one connector along a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Series {
    /// The element.
    pub element: String,
    /// Its type.
    pub type_name: String,
    /// The output as headings name it: CU1, CUR3, CTM2.
    pub name: String,
    /// Its component (0-based).
    #[serde(skip)]
    pub component: usize,
    /// How many numbers were compared.
    pub compared: u64,
    /// How many are apart by more than is allowed.
    pub wrong: u64,
    /// The first that is.
    pub first: Option<Point>,
    /// The worst of all, in units of what is allowed.
    pub worst: Option<Point>,
    /// Why, where that is known.
    pub cause: Option<String>,
    /// The points, as many as are kept.
    #[serde(skip)]
    pub points: Vec<Point>,
}

impl Series {
    pub(crate) const fn new(element: String, type_name: String, name: String, component: usize) -> Self {
        Self {
            element,
            type_name,
            name,
            component,
            compared: 0,
            wrong: 0,
            first: None,
            worst: None,
            cause: None,
            points: Vec::new(),
        }
    }

    pub(crate) fn add(&mut self, point: Point) {
        self.compared += 1;
        if point.is_wrong() {
            self.wrong += 1;
            self.first.get_or_insert(point);
        }
        if self.worst.is_none_or(|worst| point.units() > worst.units()) {
            self.worst = Some(point);
        }
        if self.points.len() < KEPT {
            self.points.push(point);
        }
    }
}

/// An output of the file that is not compared.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Unjudged {
    /// The element.
    pub element: String,
    /// The output.
    pub name: String,
    /// How many numbers.
    pub count: u64,
    /// Why.
    pub why: String,
}

/// What a comparison found.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Comparison {
    /// How many frames were read.
    pub frames: u64,
    /// How many of them had a motion.
    pub moved: u64,
    /// By element and output.
    pub series: Vec<Series>,
    /// What was not compared.
    pub unjudged: Vec<Unjudged>,
    /// One convention that explains everything that is wrong, and the line of the map that declares it.
    pub cause: Option<String>,
    /// What the file cannot tell, and what to print to close the gap.
    pub gaps: Vec<String>,
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
