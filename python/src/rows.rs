//! Rows of one connection type, many states at a time.

use crate::work;
use numpy::ndarray::{ArrayViewD, Axis, Slice};
use numpy::{
    PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyReadonlyArray2, PyReadonlyArrayDyn, PyUntypedArray,
    PyUntypedArrayMethods,
};
use pintle::batch::{
    Array, Batch, BatchError, COMPACT, Columns, Fours, History, Nodes, Orientation, Section, States,
    Velocities,
};
use pintle::catalog::COMPONENT;
use pintle::connector::{Connector, Increment, Tally};
use pintle::node::Pair;
use pintle_kinematics::batch::{LANES, Tile};
use pintle_kinematics::measure::Measure;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use std::ops::Range;

/// States that are computed at a time: what has to be copied for them stays in the second cache.
const AT_ONCE: usize = 1024;

/// A connection type at an initial state, for rows in batches.
#[pyclass(frozen, module = "pintle._pintle")]
pub(crate) struct Rows {
    connector: Connector<f64>,
    batch: Batch,
    /// Four of it before any motion. Numbers of lanes are aligned to 32 bytes, as objects of Python are not.
    fours: Box<Fours>,
    initial: Pair<f64>,
}

/// An array of doubles.
fn doubles<'py>(name: &str, given: &Bound<'py, PyAny>) -> PyResult<PyReadonlyArrayDyn<'py, f64>> {
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
    let array = given.cast::<PyArrayDyn<f64>>()?;
    array.try_readonly().map_err(|error| PyValueError::new_err(format!("{name} cannot be read: {error}")))
}

/// An array of states, or of a single one that holds for all.
struct Given<'a> {
    view: ArrayViewD<'a, f64>,
    /// The shape of a state.
    one: &'static [usize],
    count: usize,
    copied: Vec<f64>,
}

impl<'a> Given<'a> {
    fn new(name: &str, view: ArrayViewD<'a, f64>, forms: &[&'static [usize]]) -> PyResult<Self> {
        let shape = view.shape().to_vec();
        if let [count, rest @ ..] = shape.as_slice()
            && let Some(one) = forms.iter().find(|one| **one == rest)
        {
            return Ok(Self { view, one, count: *count, copied: Vec::new() });
        }
        let told = |one: &&[usize]| {
            let sizes: Vec<String> = one.iter().map(ToString::to_string).collect();
            format!("(n, {})", sizes.join(", "))
        };
        let wanted: Vec<String> = forms.iter().map(told).collect();
        Err(PyValueError::new_err(format!("{name} has shape {shape:?}, not {}", wanted.join(" or "))))
    }

    /// Some states, as they lie in memory or copied.
    fn array(&mut self, range: &Range<usize>) -> Array<'_> {
        let Self { view, one, count, copied } = self;
        let width: usize = one.iter().product();
        let (stride, range) = if *count == 1 { (0, 0..1) } else { (width, range.clone()) };
        if let Some(all) = view.as_slice() {
            return Array::new(all.get(range.start * width..range.end * width).unwrap_or_default(), stride);
        }
        copied.clear();
        copied.extend(view.slice_axis(Axis(0), Slice::from(range)).iter());
        Array::new(copied, stride)
    }

    /// The same as the orientation of a node that has the initial triad T₀.
    fn orientation(&mut self, range: &Range<usize>, initial: [[f64; 3]; 3]) -> Orientation<'_> {
        let one = self.one;
        let array = self.array(range);
        match one {
            [3, 3] => Orientation::Directions(array),
            [4] => Orientation::Quaternion(array, initial),
            _ => Orientation::RotationVector(array, initial),
        }
    }
}

/// The columns asked for.
enum Wanted {
    Fourteen,
    Twelve,
    Sparse,
    Chosen(Vec<usize>),
}

impl Wanted {
    fn new(given: &Bound<'_, PyAny>) -> PyResult<Self> {
        if let Ok(number) = given.extract::<usize>() {
            return match number {
                14 => Ok(Self::Fourteen),
                12 => Ok(Self::Twelve),
                9 => Ok(Self::Chosen(COMPACT.to_vec())),
                other => Err(PyValueError::new_err(format!(
                    "columns are 14, 12, 9, \"sparse\" or places, not {other}"
                ))),
            };
        }
        if let Ok(word) = given.extract::<String>() {
            return if word == "sparse" {
                Ok(Self::Sparse)
            } else {
                Err(PyValueError::new_err(format!(
                    "columns are 14, 12, 9, \"sparse\" or places, not {word:?}"
                )))
            };
        }
        Ok(Self::Chosen(given.extract()?))
    }

    fn columns(&self) -> Columns<'_> {
        match self {
            Self::Fourteen => Columns::Fourteen,
            Self::Twelve => Columns::Twelve,
            Self::Sparse => Columns::Sparse,
            Self::Chosen(places) => Columns::Chosen(places),
        }
    }
}

impl Rows {
    /// Whether the sheet on which a value lies is decided at the state itself: by Euler angles and by turns of torsion.
    fn needs_history(&self) -> bool {
        self.batch.measures().iter().any(|(_, of)| of.counts_torsion() || matches!(of, Measure::Euler(_)))
    }

    /// What the initial state decides at some states.
    fn histories(&self, states: &States<'_>) -> Vec<History> {
        if !self.needs_history() {
            return vec![self.fours.history()];
        }
        let (still, section) = ([Increment::none(); LANES], Section::new(&[&self.connector; LANES]));
        let of = |first: usize| {
            let last = states.count.saturating_sub(1);
            let pairs = std::array::from_fn(|lane| states.pair((first + lane).min(last)));
            let mut fours = Fours::clone(&self.fours);
            let at = (&Tile::new(&pairs), &section);
            fours.follow(&self.connector, at, &still, [true; 6], &mut Tally::default());
            fours.history()
        };
        (0..states.count).step_by(LANES).map(of).collect()
    }

    /// Does something with some states, as a batch takes them.
    fn at(
        &self,
        given: &mut [Given<'_>; 4],
        range: &Range<usize>,
        then: impl FnOnce(&States<'_>) -> Result<(), BatchError>,
    ) -> Result<(), String> {
        let sections = [Section::new(&[&self.connector; LANES])];
        let [x_a, triad_a, x_b, triad_b] = given;
        let initial = &self.initial;
        let mut states = States {
            count: range.len(),
            reference: Array::shared(&[0.0; 3]),
            nodes: [
                Nodes {
                    displacement: x_a.array(range),
                    orientation: triad_a.orientation(range, initial.a.triad),
                },
                Nodes {
                    displacement: x_b.array(range),
                    orientation: triad_b.orientation(range, initial.b.triad),
                },
            ],
            sections: &sections,
            histories: &[],
        };
        let histories = self.histories(&states);
        states.histories = &histories;
        then(&states).map_err(|error| error.to_string())
    }
}

/// Parts of `count` states, each as long as may be computed at a time.
fn parts(count: usize) -> impl Iterator<Item = Range<usize>> {
    (0..count).step_by(AT_ONCE).map(move |first| first..count.min(first + AT_ONCE))
}

/// Those of some states, in an array that has `width` numbers for each.
fn own<'a>(of: &'a mut [f64], range: &Range<usize>, width: usize) -> &'a mut [f64] {
    of.get_mut(range.start * width..range.end * width).unwrap_or_default()
}

/// Work without Python. Loops that are not optimised need more of a stack than the caller may have.
fn detached(py: Python<'_>, work: impl FnOnce() -> Result<(), String> + Send) -> PyResult<()> {
    let done = if cfg!(debug_assertions) { work::apart(py, work)? } else { py.detach(work) };
    done.map_err(PyValueError::new_err)
}

fn unwritable(error: &dyn std::fmt::Display) -> PyErr {
    PyValueError::new_err(format!("out cannot be written: {error}"))
}

/// Which components are wanted: all that there are, or those of the numbers 1 to 6 in ascending order.
fn wanted(of: &str, connector: &Connector<f64>, chosen: Option<Vec<i64>>) -> PyResult<[bool; 6]> {
    let Some(chosen) = chosen else { return Ok([true; 6]) };
    let there = |k: &usize| connector.differentiated(*k).is_some();
    let told = |k: usize| format!("{} ({})", k + 1, COMPONENT.get(k).unwrap_or(&"?"));
    let refused = |what: String| {
        let all: Vec<String> = (0..6).filter(there).map(told).collect();
        Err(PyValueError::new_err(format!("components {chosen:?}: {what}; {of} has {}", all.join(", "))))
    };
    if chosen.is_empty() {
        return refused("none is chosen".into());
    }
    let is_there = |number: &i64| (0..6).filter(there).any(|k| k as i64 + 1 == *number);
    if let Some(number) = chosen.iter().find(|number| !is_there(number)) {
        return refused(format!("there is no {number}"));
    }
    if !chosen.is_sorted_by(|one, next| one < next) {
        return refused("each comes once, in ascending order".into());
    }
    Ok(std::array::from_fn(|k| chosen.contains(&(k as i64 + 1))))
}

#[pymethods]
impl Rows {
    #[new]
    #[pyo3(signature = (of, components=None))]
    fn new(of: &str, components: Option<Vec<i64>>) -> PyResult<Self> {
        let subject = pintle::check::subject(of, None).map_err(PyValueError::new_err)?;
        let pintle::check::Subject::Connector(definition, _) = subject else {
            return Err(PyValueError::new_err(format!("{of} is no connector: rows are those of one")));
        };
        let connector = Connector::new(&definition);
        let wanted = wanted(of, &connector, components)?;
        let batch =
            Batch::new(&connector, wanted).map_err(|error| PyValueError::new_err(error.to_string()))?;
        let fours = Box::new(Fours::new(&[&connector; LANES]));
        Ok(Self { connector, batch, fours, initial: definition.initial })
    }

    /// The initial state, of which components of lengths are not less: x_b, and the triads of a and b, a direction a row.
    #[getter]
    fn initial(&self) -> ([f64; 3], [[f64; 3]; 3], [[f64; 3]; 3]) {
        let directions = |triad: &[[f64; 3]; 3]| [0, 1, 2].map(|i| [0, 1, 2].map(|j| triad[j][i]));
        (self.initial.reference, directions(&self.initial.a.triad), directions(&self.initial.b.triad))
    }

    /// The columns (of twelve) of each row that may differ from zero.
    #[getter]
    fn pattern(&self) -> Vec<Vec<usize>> {
        self.batch.pattern()
    }

    /// The components of the rows, by their places, 0 to 5.
    #[getter]
    fn components(&self) -> Vec<usize> {
        self.batch.measures().iter().map(|(k, _)| *k).collect()
    }

    /// How many numbers the rows of a state have.
    fn width(&self, columns: &Bound<'_, PyAny>) -> PyResult<usize> {
        Ok(self.batch.width(Wanted::new(columns)?.columns()))
    }

    /// How many states arrays hold, and velocities where there are any.
    #[staticmethod]
    #[pyo3(signature = (arrays, velocities=None))]
    fn count(arrays: Vec<Bound<'_, PyAny>>, velocities: Option<Vec<Bound<'_, PyAny>>>) -> PyResult<usize> {
        let read = readonly(&NAMES, &arrays)?;
        let states = given(&read)?;
        let Some(velocities) = velocities else { return count_of(&states) };
        let read = readonly(&VELOCITIES, &velocities)?;
        let moving = of_forms(&VELOCITIES, [VECTOR; 4], &read)?;
        count_of_both(&states, &moving)
    }

    /// Writes values (n, m) and rows (n, width) of n states and m components into arrays in C order.
    fn fill_into(
        &self,
        py: Python<'_>,
        arrays: Vec<Bound<'_, PyAny>>,
        columns: &Bound<'_, PyAny>,
        values: &Bound<'_, PyArrayDyn<f64>>,
        rows: &Bound<'_, PyArrayDyn<f64>>,
    ) -> PyResult<()> {
        let read = readonly(&NAMES, &arrays)?;
        let mut given = given(&read)?;
        let wanted = Wanted::new(columns)?;
        let mut values = values.try_readwrite().map_err(|error| unwritable(&error))?;
        let mut rows = rows.try_readwrite().map_err(|error| unwritable(&error))?;
        let values = values.as_slice_mut().map_err(|error| unwritable(&error))?;
        let rows = rows.as_slice_mut().map_err(|error| unwritable(&error))?;
        let count = count_of(&given)?;
        let (each, width) = (self.batch.rows(), self.batch.width(wanted.columns()));
        if values.len() != count * each || rows.len() != count * width {
            let (v, r) = (values.len(), rows.len());
            return Err(PyValueError::new_err(format!(
                "out has {v} values and {r} numbers of rows, not {count} × {each} and {count} × {width}"
            )));
        }
        detached(py, || {
            for range in parts(count) {
                let (values, rows) = (own(values, &range, each), own(rows, &range, width));
                self.at(&mut given, &range, |states| {
                    self.batch.rows_of_states(states, wanted.columns(), values, rows)
                })?;
            }
            Ok(())
        })
    }

    /// Writes J̇v (n, m) of n states that move with v_a, w_a, v_b, w_b into an array in C order.
    fn bias_into(
        &self,
        py: Python<'_>,
        arrays: Vec<Bound<'_, PyAny>>,
        velocities: Vec<Bound<'_, PyAny>>,
        out: &Bound<'_, PyArrayDyn<f64>>,
    ) -> PyResult<()> {
        let read = readonly(&NAMES, &arrays)?;
        let mut given = given(&read)?;
        let read = readonly(&VELOCITIES, &velocities)?;
        let mut moving = of_forms(&VELOCITIES, [VECTOR; 4], &read)?;
        let (count, each) = (count_of_both(&given, &moving)?, self.batch.rows());
        let mut out = out.try_readwrite().map_err(|error| unwritable(&error))?;
        let out = sized(out.as_slice_mut().map_err(|error| unwritable(&error))?, (count, each))?;
        detached(py, || {
            for range in parts(count) {
                let velocities = at_range(&mut moving, &range);
                let out = own(out, &range, each);
                self.at(&mut given, &range, |states| self.batch.bias_of_states(states, velocities, out))?;
            }
            Ok(())
        })
    }

    /// Writes Σ λ ∂²c (n, 12, 12) of n states with multipliers (n, m) into an array in C order.
    fn geometric_stiffness_into(
        &self,
        py: Python<'_>,
        arrays: Vec<Bound<'_, PyAny>>,
        multipliers: PyReadonlyArray2<'_, f64>,
        out: &Bound<'_, PyArrayDyn<f64>>,
    ) -> PyResult<()> {
        let read = readonly(&NAMES, &arrays)?;
        let mut given = given(&read)?;
        let (count, each) = (count_of(&given)?, self.batch.rows());
        let multipliers = multipliers.as_slice().map_err(|error| PyValueError::new_err(error.to_string()))?;
        let mut out = out.try_readwrite().map_err(|error| unwritable(&error))?;
        let out = sized(out.as_slice_mut().map_err(|error| unwritable(&error))?, (count, 144))?;
        detached(py, || {
            for range in parts(count) {
                let own_multipliers =
                    multipliers.get(range.start * each..range.end * each).unwrap_or_default();
                let out = own(out, &range, 144);
                self.at(&mut given, &range, |states| {
                    self.batch.geometric_stiffness_of_states(states, own_multipliers, out)
                })?;
            }
            Ok(())
        })
    }

    /// Writes (Σ λ ∂²c) v (n, 12) of n states with multipliers (n, m) and variations v into an array in C order.
    fn geometric_stiffness_along_into(
        &self,
        py: Python<'_>,
        arrays: Vec<Bound<'_, PyAny>>,
        multipliers: PyReadonlyArray2<'_, f64>,
        along: Vec<Bound<'_, PyAny>>,
        out: &Bound<'_, PyArrayDyn<f64>>,
    ) -> PyResult<()> {
        let read = readonly(&NAMES, &arrays)?;
        let mut given = given(&read)?;
        let read = readonly(&VELOCITIES, &along)?;
        let mut moving = of_forms(&VELOCITIES, [VECTOR; 4], &read)?;
        let (count, each) = (count_of_both(&given, &moving)?, self.batch.rows());
        let multipliers = multipliers.as_slice().map_err(|error| PyValueError::new_err(error.to_string()))?;
        let mut out = out.try_readwrite().map_err(|error| unwritable(&error))?;
        let out = sized(out.as_slice_mut().map_err(|error| unwritable(&error))?, (count, 12))?;
        detached(py, || {
            for range in parts(count) {
                let own_multipliers =
                    multipliers.get(range.start * each..range.end * each).unwrap_or_default();
                let along = at_range(&mut moving, &range);
                let out = own(out, &range, 12);
                self.at(&mut given, &range, |states| {
                    self.batch.geometric_stiffness_along_of_states(states, own_multipliers, along, out)
                })?;
            }
            Ok(())
        })
    }
}

/// The velocities, or variations, of a and of b at some states.
fn at_range<'a>(moving: &'a mut [Given<'_>; 4], range: &Range<usize>) -> [Velocities<'a>; 2] {
    let [v_a, w_a, v_b, w_b] = moving.each_mut().map(|of| of.array(range));
    [(v_a, w_a), (v_b, w_b)].map(|(velocity, angular_velocity)| Velocities { velocity, angular_velocity })
}

/// An array that takes so many numbers of each state.
fn sized(out: &mut [f64], (count, each): (usize, usize)) -> PyResult<&mut [f64]> {
    if out.len() == count * each {
        return Ok(out);
    }
    Err(PyValueError::new_err(format!("out has {} numbers, not {count} × {each}", out.len())))
}

/// How many states there are.
fn count_of(states: &[Given<'_>; 4]) -> PyResult<usize> {
    count(&NAMES, &states.each_ref().map(|one| one.count))
}

/// How many states there are that move.
fn count_of_both(states: &[Given<'_>; 4], velocities: &[Given<'_>; 4]) -> PyResult<usize> {
    let names: Vec<&str> = NAMES.into_iter().chain(VELOCITIES).collect();
    let of = |given: &[Given<'_>; 4]| given.each_ref().map(|one| one.count);
    count(&names, &[of(states), of(velocities)].concat())
}

/// How many states there are: one of an array holds for all.
fn count(names: &[&str], counts: &[usize]) -> PyResult<usize> {
    let count = counts.iter().copied().find(|count| *count != 1).unwrap_or(1);
    if counts.iter().all(|one| *one == count || *one == 1) {
        return Ok(count);
    }
    let told: Vec<String> = names.iter().zip(counts).map(|(name, count)| format!("{name} {count}")).collect();
    Err(PyValueError::new_err(format!("states: {}; one, or as many in each array", told.join(", "))))
}

const NAMES: [&str; 4] = ["x_a", "triad_a", "x_b", "triad_b"];
const VELOCITIES: [&str; 4] = ["v_a", "w_a", "v_b", "w_b"];

const VECTOR: &[&[usize]] = &[&[3]];

fn readonly<'py>(
    names: &[&str; 4],
    arrays: &[Bound<'py, PyAny>],
) -> PyResult<[PyReadonlyArrayDyn<'py, f64>; 4]> {
    let [one, two, three, four] = arrays else {
        return Err(PyValueError::new_err(format!("{} arrays where 4 are needed", arrays.len())));
    };
    let [p, q, r, s] = names;
    Ok([doubles(p, one)?, doubles(q, two)?, doubles(r, three)?, doubles(s, four)?])
}

/// Four arrays of these forms.
fn of_forms<'a>(
    names: &[&str; 4],
    forms: [&[&'static [usize]]; 4],
    of: &'a [PyReadonlyArrayDyn<'_, f64>; 4],
) -> PyResult<[Given<'a>; 4]> {
    let given = |i: usize| Given::new(names[i], of[i].as_array(), forms[i]);
    Ok([given(0)?, given(1)?, given(2)?, given(3)?])
}

fn given<'a>(of: &'a [PyReadonlyArrayDyn<'_, f64>; 4]) -> PyResult<[Given<'a>; 4]> {
    const TRIAD: &[&[usize]] = &[&[3, 3], &[4], &[3]];
    of_forms(&NAMES, [VECTOR, TRIAD, VECTOR, TRIAD], of)
}
