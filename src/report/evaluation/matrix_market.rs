//! A sparse matrix as a Matrix Market file, as `scipy.io.mmread`, MATLAB, Octave and Julia read it.
//!
//! Comments name what the rows and columns are. Numbers read back to the same double.

use pintle_model::evaluate::{Freedom, Jacobian, Model};
use std::io::{self, Write};

/// Writes the entries of a sparse Jacobian, rows after rows; `of` says what it is of.
///
/// # Errors
/// Those of the stream.
pub fn write(
    out: &mut dyn Write,
    of: &str,
    model: &Model,
    jacobian: &Jacobian,
    values: &[f64],
) -> io::Result<()> {
    writeln!(out, "%%MatrixMarket matrix coordinate real general")?;
    writeln!(
        out,
        "% pintle {}: constraint Jacobian of {}",
        pintle_kinematics::VERSION,
        of.replace(['\n', '\r'], " ")
    )?;
    writeln!(
        out,
        "% rotations vary spatially, C -> exp(dtheta^) C; columns are nodes with degrees of freedom 1-6, 10"
    )?;
    for (row, equation) in (1..).zip(jacobian.equations()) {
        writeln!(out, "% row {row}: {}", equation.title(model))?;
    }
    for (column, Freedom { node, number }) in (1..).zip(jacobian.freedoms()) {
        writeln!(out, "% column {column}: {node} {number}")?;
    }
    writeln!(out, "{} {} {}", jacobian.rows(), jacobian.columns(), jacobian.entries())?;
    for row in 0..jacobian.rows() {
        let values = values.get(jacobian.range(row).unwrap_or_default()).unwrap_or_default();
        for (column, value) in jacobian.row(row).iter().zip(values) {
            writeln!(out, "{} {} {value:?}", row + 1, column + 1)?;
        }
    }
    out.flush()
}
