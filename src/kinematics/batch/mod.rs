//! Many connectors of one type, or many states of one: four at a time, on the vector unit that the processor has.
//!
//! The measures are those of [`crate::measure`], evaluated on four lanes ([`crate::scalar::lanes`]) with derivatives along the
//! three relative translations or rotations. The loops are compiled for vector units with fused products (AVX2 + FMA on x86-64,
//! NEON on AArch64), which are found at run time ([`vector_unit`]). Without one, elements are taken one after the other. The loops
//! are compiled with this crate, and not again by its callers. Results differ from those of [`crate::connector`] by roundings
//! of the numbers that they are computed from. A value differs by at most 2 of them (beside singular points 3), a row by 2.5, second
//! derivatives by 1.5. That is so for triads that are orthonormal to rounding and lengths between 1e−300 and 1e300. What is no number stays in its lane.
//! A connector takes the rotation that is nearest to its triads; a batch does not. Triads that are off by δ (of single precision,
//! 1e−7) put its rotation vectors off by about 0.4 δ.
//!
//! Whoever has arrays of states takes [`Batch::rows_of_states`], which makes tiles of them and arrays of the rows. So do
//! [`Batch::bias_of_states`] (J̇v) and [`Batch::geometric_stiffness_of_states`] (Σ λ ∂²c), which form no second derivatives of a row.
//!
//! States come in [`Tile`]s: each number of a state as an array of four, one for each lane. Rows go to arrays of the same kind. The
//! loops are made to be optimised: without optimisation they need a stack of more than 8 MB (here a thread that the page hides).
//!
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let thread = std::thread::Builder::new().stack_size(256 << 20);
//! # Ok(thread.spawn(|| example().map_err(|error| error.to_string()))?.join().expect("no panic")?)
//! # }
//! # fn example() -> Result<(), Box<dyn std::error::Error>> {
//! use pintle_kinematics::batch::{Batch, History, Row, Section, Tile};
//! use pintle_kinematics::catalog::ConnectionType;
//! use pintle_kinematics::connector::{Connector, Definition};
//! use pintle_kinematics::node::{Node, Pair};
//! use pintle_kinematics::{so3, vector};
//!
//! // A REVOLUTE at four angles.
//! let node = |triad| Node { displacement: [0.0; 3], triad, flow: 0.0 };
//! let turned = |angle| Pair {
//!     reference: [0.0; 3],
//!     a: node(vector::identity()),
//!     b: node(so3::matrix(so3::exp_quaternion([angle, 0.0, 0.0]))),
//! };
//! let definition = Definition::new(ConnectionType::named("REVOLUTE", None)?, turned(0.0));
//! let connector = Connector::<f64>::new(&definition);
//! let batch = Batch::new(&connector, [true; 6])?;
//! let tile = Tile::new(&[turned(0.0), turned(0.5), turned(1.0), turned(1.5)]);
//! let constants = Section::new(&[&connector; 4]);
//! let history = History::new(&[connector.initial_branch(); 4]);
//! let mut rows = vec![Row::default(); batch.rows()];
//! batch.rows_of(&[tile], &[constants], &[history], &mut rows)?;
//! for (ur1, angle) in rows[0].value.into_iter().zip([0.0, 0.5, 1.0, 1.5]) {
//!     assert!((ur1 - angle).abs() < 4e-16, "{ur1} for {angle}");
//! }
//! assert!(rows[0].columns[9].iter().all(|slope| (slope - 1.0).abs() < 4e-16)); // ∂ur1/∂θb1
//! # Ok(())
//! # }
//! ```

mod care;
mod fours;
mod kernel;
mod layout;
mod rows;
mod second;
mod single;
mod tile;
mod unit;

use crate::connector::{Connector, Mask};
use crate::measure::Measure;
use crate::measure::formula::{Pass, cover};
use crate::node::DOFS;
use layout::Shape;
use pulp::{Arch, Simd, WithSimd};

pub use crate::scalar::lanes::LANES;
pub use care::Watch;
pub use fours::{Fours, Origin};
pub use kernel::Layout;
pub use layout::{CompactRow, HessianRow, Row};
pub use rows::{Array, COMPACT, Columns, Nodes, Orientation, States};
pub use second::{Columns12, Velocities};
pub use tile::{Four, History, Poses, Section, Tile, Triads};

/// Why connectors cannot be evaluated as a batch.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BatchError {
    /// A component has no function of the two nodes, or one that depends on material flow.
    #[error("the row of {0} has columns that a batch does not: evaluate it by itself")]
    NotBatched(&'static str),
    /// A column that a row has not.
    #[error("column {0} is none of the twelve, which are numbered from 0")]
    Column(usize),
    /// The slices do not have one entry for each tile, or for each row of each tile.
    #[error("{what}: {found} where {expected} are needed")]
    Length {
        /// Which slice.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The length needed.
        expected: usize,
    },
}

/// What to compute for connectors that share their measures: the rows of one connection type.
#[derive(Clone, Debug)]
pub struct Batch {
    /// The component (0-based) and measure of each row.
    measures: Vec<(usize, Measure)>,
    /// How each row depends on the nodes.
    shapes: Vec<Shape>,
    passes: Vec<Pass>,
    arch: Arch,
    /// Whether a row is that of a length.
    has_length: bool,
}

impl Batch {
    /// The rows of the components `wanted`: of the residual of a constrained component, of the position of any other.
    ///
    /// Connectors share a batch where [`Connector::differentiated`] agrees in those components.
    ///
    /// # Errors
    /// [`BatchError::NotBatched`] for a component whose row has entries for material flow: SLIPRING, FLOW-CONVERTER.
    pub fn new(connector: &Connector<f64>, wanted: Mask) -> Result<Self, BatchError> {
        let measures: Vec<(usize, Measure)> =
            (0..6).filter(|k| wanted[*k]).filter_map(|k| Some((k, connector.differentiated(k)?))).collect();
        let refused = |row: usize| {
            let component = measures.get(row).and_then(|(k, _)| crate::catalog::COMPONENT.get(*k));
            BatchError::NotBatched(component.copied().unwrap_or_default())
        };
        if let Some(row) = measures.iter().position(|(_, m)| m.dependence().flow || m.is_one_form()) {
            return Err(refused(row));
        }
        let list: Vec<Measure> = measures.iter().map(|(_, measure)| *measure).collect();
        let (passes, left) = cover(&list);
        if let Some(row) = left.first() {
            return Err(refused(*row));
        }
        let is_length =
            |of: &Measure| matches!(of, Measure::Distance | Measure::Strain | Measure::RadialDistance);
        let has_length = list.iter().any(is_length);
        let shapes = list.iter().map(|measure| Shape::of(*measure)).collect();
        Ok(Self { passes, measures, shapes, arch: Arch::new(), has_length })
    }

    /// The same batch in the instructions of every processor that this program runs on, without a vector unit chosen at run
    /// time.
    pub const fn baseline(mut self) -> Self {
        self.arch = Arch::Scalar;
        self
    }

    /// The number of rows of each tile.
    #[inline]
    pub fn rows(&self) -> usize {
        self.measures.len()
    }

    /// The component (0-based) and the measure of each row, in order.
    pub fn measures(&self) -> &[(usize, Measure)] {
        &self.measures
    }
}

/// The degree of freedom of each column of a row, by its place in [`crate::node::DOF`]: all but material flow.
pub const COLUMNS: [usize; DOFS - 2] = [0, 1, 2, 3, 4, 5, 7, 8, 9, 10, 11, 12];

/// The vector unit that batches run on here, chosen at run time: AVX2 with fused products, or NEON.
///
/// `None` where there is none: every lane is computed in the instructions that the program was built for.
pub fn vector_unit() -> Option<&'static str> {
    struct Width;
    impl WithSimd for Width {
        type Output = usize;

        #[cfg_attr(not(debug_assertions), inline(always))]
        fn with_simd<V: Simd>(self, _: V) -> usize {
            V::F64_LANES
        }
    }
    match (std::env::consts::ARCH, Arch::new().dispatch(Width)) {
        (_, 0 | 1) => None,
        ("x86_64", 4) => Some("AVX2/FMA"),
        ("aarch64", _) => Some("NEON"),
        _ => Some("vector unit"),
    }
}

#[inline]
fn same_length(what: &'static str, found: usize, expected: usize) -> Result<(), BatchError> {
    if found == expected { Ok(()) } else { Err(BatchError::Length { what, found, expected }) }
}
