//! A Jacobian beside what it must be, for looking at.

use crate::case::quantity::Entries;
use crate::judge::verdict::Wanted;
use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::node::{DOF, DOFS};

/// An entry of a Jacobian beside what it must be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compared {
    /// What was given.
    pub got: f64,
    /// What it must be, rounded to a double.
    pub want: f64,
    /// How far apart they may be.
    pub tolerance: f64,
    /// |got − want| in units of the tolerance; infinite where it is not a number.
    pub units: f64,
}

impl Compared {
    /// Whether it is zero to rounding, as what is zero by its formula is, whatever digits rounding left of it on either side.
    pub fn is_zero(&self) -> bool {
        self.units <= 1.0 && self.got.abs().max(self.want.abs()) <= self.tolerance
    }
}

/// A Jacobian beside what it must be.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// Nodal degrees of freedom: of a connector [`DOF`], of a constraint those of its nodes and the angles of its hinges.
    pub columns: Vec<String>,
    /// Components of a connector, or equations of a constraint, each with its row.
    pub rows: Vec<(String, Vec<Compared>)>,
}

impl Comparison {
    /// The columns in blocks, three displacements or three rotations of a node; flows and angles of hinges only where something depends on
    /// them.
    pub fn blocks(&self) -> Vec<Vec<usize>> {
        let kind = |name: &str| name.trim_end_matches(|letter: char| letter.is_ascii_digit()).to_string();
        let depends = |j: usize| {
            let mut entries = self.rows.iter().filter_map(|(_, row)| row.get(j));
            entries.any(|entry| entry.got != 0.0 || entry.want != 0.0)
        };
        let shown = self.columns.iter().enumerate();
        let shown = shown.filter(|(j, name)| name.starts_with(['x', 'θ']) || depends(*j));
        let mut blocks: Vec<(String, Vec<usize>)> = Vec::new();
        for (j, name) in shown {
            match blocks.last_mut().filter(|(of, _)| *of == kind(name)) {
                Some((_, block)) => block.push(j),
                None => blocks.push((kind(name), vec![j])),
            }
        }
        blocks.into_iter().map(|(_, block)| block).collect()
    }

    /// Of rows given, in units of the tolerance of each entry, by component and column.
    pub fn new(got: &Entries<f64>, want: &Entries<Wanted>, tolerance: impl Fn(usize, usize) -> f64) -> Self {
        let row = |k: usize| {
            got.0[k].as_ref().zip(want.0[k].as_ref())?;
            let of = |j: usize| {
                let missing = f64::NAN;
                let given = got.get(k, j).unwrap_or(missing);
                let want = want.get(k, j).unwrap_or(Wanted::exactly(missing));
                let tolerance = tolerance(k, j);
                Compared { got: given, want: want.to_f64(), tolerance, units: want.units(given, tolerance) }
            };
            Some((COMPONENT[k].to_string(), (0..DOFS).map(of).collect()))
        };
        Self { columns: DOF.map(String::from).to_vec(), rows: (0..COMPONENT.len()).filter_map(row).collect() }
    }

    /// The largest error in units of its tolerance.
    pub fn worst(&self) -> f64 {
        self.rows.iter().flat_map(|(_, row)| row).fold(0.0_f64, |most, entry| most.max(entry.units))
    }
}
