//! Rows of one connection type, many states at a time.

use crate::work;
use numpy::ndarray::{ArrayView, ArrayViewMut2, ArrayViewMut3, Ix2, Ix3};
use numpy::{
    PyArray, PyArray2, PyArray3, PyArrayDescrMethods, PyArrayMethods, PyReadonlyArray, PyUntypedArray,
    PyUntypedArrayMethods,
};
use pintle::batch::{Batch, History, Row, Section, Tile, advance};
use pintle::connector::{Connector, Increment, State};
use pintle::node::{Node, Pair};
use pintle_kinematics::batch::{COLUMNS, LANES};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// States that are computed at a time: what they need stays in the second cache, whatever the number of states.
const AT_ONCE: usize = 128;

/// A connection type at an initial state, for rows in batches.
#[pyclass(frozen, module = "pintle._pintle")]
pub(crate) struct Rows {
    connector: Connector<f64>,
    batch: Batch,
    /// The initial state, of which components of lengths are not less: x_b, and the triads of a and b, a direction a row.
    #[pyo3(get)]
    initial: ([f64; 3], [[f64; 3]; 3], [[f64; 3]; 3]),
}

/// An array of doubles with so many dimensions, the last of which are `shape`.
fn doubles<'py, D: numpy::ndarray::Dimension + 'py>(
    name: &str,
    given: &Bound<'py, PyAny>,
    shape: &[usize],
) -> PyResult<PyReadonlyArray<'py, f64, D>> {
    let array = given.cast::<PyUntypedArray>().map_err(|_| {
        PyTypeError::new_err(format!(
            "{name} is no NumPy array: numpy.asarray({name}, dtype=float) makes one"
        ))
    })?;
    let dtype = array.dtype();
    if !dtype.is_equiv_to(&numpy::dtype::<f64>(given.py())) {
        return Err(PyTypeError::new_err(format!(
            "{name} has dtype {dtype}, and float64 is needed: {name}.astype(numpy.float64) converts it"
        )));
    }
    let found = array.shape();
    if found.len() != shape.len() + 1 || found.get(1..) != Some(shape) {
        let wanted: Vec<String> = shape.iter().map(ToString::to_string).collect();
        return Err(PyValueError::new_err(format!(
            "{name} has shape {found:?}, not (n, {})",
            wanted.join(", ")
        )));
    }
    let array = given.cast::<PyArray<f64, D>>()?;
    array.try_readonly().map_err(|error| PyValueError::new_err(format!("{name} cannot be read: {error}")))
}

/// The arrays of states, as they lie.
struct States<'a> {
    x: [ArrayView<'a, f64, Ix2>; 2],
    triad: [ArrayView<'a, f64, Ix3>; 2],
}

impl States<'_> {
    fn pair(&self, s: usize) -> Pair<f64> {
        let node = |end: usize| Node {
            displacement: [0, 1, 2].map(|i| self.x[end][[s, i]]),
            // The directions are the columns.
            triad: [0, 1, 2].map(|i| [0, 1, 2].map(|j| self.triad[end][[s, j, i]])),
            flow: 0.0,
        };
        Pair { reference: [0.0; 3], a: node(0), b: node(1) }
    }
}

impl Rows {
    fn fill(
        &self,
        states: &States<'_>,
        mut values: ArrayViewMut2<'_, f64>,
        mut rows: ArrayViewMut3<'_, f64>,
    ) -> Result<(), String> {
        let (connectors, count) = ([&self.connector; LANES], values.nrows());
        let section = Section::new(&connectors);
        let each = self.batch.rows();
        values.fill(f64::NAN);
        rows.fill(f64::NAN);
        let mut found = vec![Row::default(); each * AT_ONCE / LANES];
        for first in (0..count).step_by(AT_ONCE) {
            let here = (count - first).min(AT_ONCE);
            let (mut tiles, mut histories) = (Vec::new(), Vec::new());
            for start in (first..first + here).step_by(LANES) {
                // Beyond the last state stands the last one again.
                let pairs: [Pair<f64>; LANES] =
                    std::array::from_fn(|i| states.pair((start + i).min(count - 1)));
                let at = pairs.map(|pair| State { pair, velocity: [0.0; 14], acceleration: [0.0; 14] });
                let branches = advance(
                    &connectors,
                    &at,
                    &[Increment::none(); LANES],
                    &[self.connector.initial_branch(); LANES],
                );
                tiles.push(Tile::new(&pairs));
                histories.push(History::new(&branches));
            }
            let sections = vec![section; tiles.len()];
            let Some(found) = found.get_mut(..each * tiles.len()) else { continue };
            self.batch.rows_of(&tiles, &sections, &histories, found).map_err(|error| error.to_string())?;
            for (n, row) in found.iter().enumerate() {
                let (tile, (k, _)) = (n / each, self.batch.measures()[n % each]);
                for lane in 0..LANES.min(here - tile * LANES) {
                    let s = first + tile * LANES + lane;
                    values[[s, k]] = row.value[lane];
                    (rows[[s, k, 6]], rows[[s, k, 13]]) = (0.0, 0.0);
                    for (j, column) in COLUMNS.into_iter().zip(&row.columns) {
                        rows[[s, k, j]] = column[lane];
                    }
                }
            }
        }
        Ok(())
    }
}

#[pymethods]
impl Rows {
    #[new]
    fn new(of: &str) -> PyResult<Self> {
        let subject = pintle::check::subject(of, None).map_err(PyValueError::new_err)?;
        let pintle::check::Subject::Connector(definition, _) = subject else {
            return Err(PyValueError::new_err(format!("{of} is no connector: rows are those of one")));
        };
        let connector = Connector::new(&definition);
        let batch =
            Batch::new(&connector, [true; 6]).map_err(|error| PyValueError::new_err(error.to_string()))?;
        let initial = &definition.initial;
        let directions = |triad: &[[f64; 3]; 3]| [0, 1, 2].map(|i| [0, 1, 2].map(|j| triad[j][i]));
        let initial = (initial.reference, directions(&initial.a.triad), directions(&initial.b.triad));
        Ok(Self { connector, batch, initial })
    }

    /// The components that the type has, by their places, 0 to 5.
    #[getter]
    fn components(&self) -> Vec<usize> {
        self.batch.measures().iter().map(|(k, _)| *k).collect()
    }

    /// Writes values (n, 6) and rows (n, 6, 14) of n states into arrays.
    #[expect(clippy::too_many_arguments, reason = "an array each")]
    fn fill_into(
        &self,
        py: Python<'_>,
        x_a: &Bound<'_, PyAny>,
        triad_a: &Bound<'_, PyAny>,
        x_b: &Bound<'_, PyAny>,
        triad_b: &Bound<'_, PyAny>,
        values: &Bound<'_, PyArray2<f64>>,
        rows: &Bound<'_, PyArray3<f64>>,
    ) -> PyResult<()> {
        let x = [doubles::<Ix2>("x_a", x_a, &[3])?, doubles::<Ix2>("x_b", x_b, &[3])?];
        let triad =
            [doubles::<Ix3>("triad_a", triad_a, &[3, 3])?, doubles::<Ix3>("triad_b", triad_b, &[3, 3])?];
        let states = States {
            x: [x[0].as_array(), x[1].as_array()],
            triad: [triad[0].as_array(), triad[1].as_array()],
        };
        let refused = |error| PyValueError::new_err(format!("out cannot be written: {error}"));
        let mut values = values.try_readwrite().map_err(refused)?;
        let mut rows = rows.try_readwrite().map_err(refused)?;
        let (values, rows) = (values.as_array_mut(), rows.as_array_mut());
        let count = states.x[0].nrows();
        let counts = [states.x[1].nrows(), states.triad[0].shape()[0], states.triad[1].shape()[0]];
        if counts != [count; 3] {
            return Err(PyValueError::new_err(format!(
                "x_a has {count} states, x_b, triad_a and triad_b have {counts:?}"
            )));
        }
        if values.shape() != [count, 6] || rows.shape() != [count, 6, 14] {
            let (v, r) = (values.shape(), rows.shape());
            return Err(PyValueError::new_err(format!(
                "out has shapes {v:?} and {r:?}, not [{count}, 6] and [{count}, 6, 14]"
            )));
        }
        // Loops that are not optimised need more of a stack than the caller may have.
        let work = || self.fill(&states, values, rows);
        let done = if cfg!(debug_assertions) { work::apart(py, work)? } else { py.detach(work) };
        done.map_err(PyValueError::new_err)
    }
}
