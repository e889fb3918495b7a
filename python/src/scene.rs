//! A scene: read, evaluated into arrays, audited.

use crate::arrays::{Moved, Taking};
use crate::report::Report;
use crate::work;
use numpy::{Element, PyArray1};
use pintle::audit::{Settings, audit_scenes};
use pintle::connector::{Output, Request};
use pintle::node::DOFS;
use pintle::scene::{Scene as Read, State, StateFile};
use pintle_audit::Target;
use pintle_audit::model::{Levels, audit_model};
use pintle_model::behavior::Conditions;
use pintle_model::evaluate::{
    Fixed, ForeignPattern, Jacobian, Model, Motions, NodeArrays, Numbers, Plan, Selection, Sequence, request,
};
use pintle_report::{flag_in_words, into_arrays};
use pintle_scene::{Format, NodeFreedom};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::borrow::Cow;
use std::fmt::Display;
use std::sync::OnceLock;

/// An array of counts, which fit.
fn integers<'py, T: Element + TryFrom<usize>>(
    py: Python<'py>,
    counts: impl Iterator<Item = usize>,
) -> Bound<'py, PyAny> {
    PyArray1::from_vec(py, counts.filter_map(|count| T::try_from(count).ok()).collect()).into_any()
}

/// A node and its degree of freedom.
type Column = (String, u8);

/// A model of connectors and constraints, with its states.
#[pyclass(frozen, module = "pintle._pintle")]
pub(crate) struct Scene {
    scene: Read,
    freedom: NodeFreedom,
    model: Model,
    pattern: OnceLock<(Plan, Jacobian)>,
}

fn refused(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

impl Scene {
    fn of(scene: Read) -> PyResult<Self> {
        let model = Model::compile(&scene).map_err(refused)?;
        let freedom = NodeFreedom::of(&scene);
        Ok(Self { scene, freedom, model, pattern: OnceLock::new() })
    }

    /// The states of a file or a document in JSON; without one, those of the scene.
    fn states(&self, path: Option<&str>, document: Option<&str>) -> PyResult<Vec<State>> {
        let found = match (path, document) {
            (Some(path), _) => StateFile::read(path, &self.scene),
            (_, Some(text)) => StateFile::parse_json("states", text, &self.scene),
            (None, None) => return Ok(self.scene.states.clone()),
        };
        Ok(found.map_err(refused)?.states)
    }

    /// The same, or the initial state; none beside arrays, which are checked then.
    fn given(
        &self,
        path: Option<&str>,
        document: Option<&str>,
        arrays: Option<&NodeArrays<'_>>,
    ) -> PyResult<Vec<State>> {
        if let Some(arrays) = arrays {
            arrays.check(&self.scene, &self.freedom).map_err(|wrong| {
                let all: Vec<String> = wrong.iter().map(ToString::to_string).collect();
                PyValueError::new_err(all.join("\n"))
            })?;
            return Ok(Vec::new());
        }
        let mut states = self.states(path, document)?;
        if states.is_empty() {
            states.push(State::default());
        }
        self.model.check_forces(&states, 0, &self.scene.name).map_err(refused)?;
        Ok(states)
    }

    /// The pattern of its Jacobian, made once.
    fn pattern(&self) -> PyResult<&(Plan, Jacobian)> {
        if let Some(known) = self.pattern.get() {
            return Ok(known);
        }
        let plan = Plan::compile(&self.model, &Selection::All, Request::nothing(0)).map_err(refused)?;
        let fixed = Fixed::of(&self.scene).map_err(refused)?;
        let jacobian = Jacobian::of_constraints(&self.model, &plan, &fixed);
        Ok(self.pattern.get_or_init(|| (plan, jacobian)))
    }
}

#[pymethods]
impl Scene {
    /// Opens a file, or `gallery:NAME`.
    #[staticmethod]
    fn open(name: &str) -> PyResult<Self> {
        let (mut scene, states) = pintle::scene::open(name).map_err(refused)?;
        scene.states = states;
        Self::of(scene)
    }

    /// Reads a text in the form `inp`, `toml` or `json`; `name` stands for the file in messages.
    #[staticmethod]
    fn parse(name: &str, text: &str, form: &str) -> PyResult<Self> {
        let scene = match form {
            "json" => Read::parse_json(name, text),
            "toml" => Read::parse_toml(name, text),
            _ => Read::parse(name, text),
        };
        Self::of(scene.map_err(refused)?)
    }

    /// Its name and itself as JSON, from which `parse` makes the same scene to the last bit.
    fn written(&self) -> PyResult<(String, String)> {
        Ok((self.scene.name.clone(), self.scene.write(Format::Json).map_err(refused)?.text))
    }

    /// Of each connector: its element, its type, its nodes.
    fn connectors(&self) -> Vec<(String, String, [Option<String>; 2])> {
        let of = |one: &pintle_model::evaluate::ConnectorElement| {
            let name = one.connector.connection().name.to_string();
            (one.label.to_string(), name, one.nodes.map(|node| node.map(|node| node.to_string())))
        };
        self.model.connectors.iter().map(of).collect()
    }

    /// Arrays by the names of the outputs, states × connectors × 6, with `jacobian` and `hessian`; NaN where there is none.
    #[expect(clippy::too_many_arguments, reason = "states come in three forms")]
    fn evaluate<'py>(
        &self,
        py: Python<'py>,
        path: Option<&str>,
        document: Option<&str>,
        arrays: Option<Bound<'py, PyDict>>,
        outputs: Vec<String>,
        order: u8,
        out: Option<Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        if order > 2 {
            return Err(PyValueError::new_err(format!(
                "order is {order}: 0 none, 1 Jacobian, 2 also second derivatives"
            )));
        }
        let moved = arrays.as_ref().map(Moved::new).transpose()?;
        let arrays = moved.as_ref().map(Moved::arrays).transpose()?;
        let states = self.given(path, document, arrays.as_ref())?;
        let motions = arrays.as_ref().map_or(Motions::States(&states), Motions::Arrays);
        let request = request(outputs.iter().map(String::as_str), order).map_err(refused)?;
        let outputs: Vec<Output> = request.outputs().collect();
        if let Some(output) = outputs.iter().find(|one| one.is_nodal() || **one == Output::TANGENT) {
            let name = output.name();
            return Err(PyValueError::new_err(format!(
                "{name} is no number of a component, and not among the arrays: pintle eval --format json has it"
            )));
        }
        let plan = Plan::compile(&self.model, &Selection::All, request).map_err(refused)?;
        let shape = [motions.count(), self.model.connectors.len(), 6, DOFS, DOFS];
        let mut taking = Taking::new(out);
        for output in &outputs {
            taking.add(py, output.name(), &shape[..3])?;
        }
        for (least, name) in [(1, "jacobian"), (2, "hessian")] {
            if order >= least {
                taking.add(py, name, &shape[..3 + usize::from(least)])?;
            }
        }
        taking.check()?;
        let mut writable = taking.writable()?;
        let mut slices = Vec::with_capacity(writable.len());
        for array in &mut writable {
            slices.push(array.as_slice_mut().map_err(refused)?);
        }
        let mut slices = slices.into_iter();
        let values = outputs.iter().copied().zip(slices.by_ref()).collect();
        let numbers = Numbers {
            values,
            jacobian: if order > 0 { slices.next() } else { None },
            hessian: if order > 1 { slices.next() } else { None },
        };
        work::apart(py, || into_arrays(&self.model, &plan, motions, &Conditions::default(), numbers))?
            .map_err(refused)?;
        drop(writable);
        let times: Vec<f64> = match motions {
            Motions::Arrays(arrays) => {
                arrays.times.map_or_else(|| vec![f64::NAN; arrays.count], <[f64]>::to_vec)
            }
            Motions::States(states) => states.iter().map(|state| state.time.unwrap_or(f64::NAN)).collect(),
        };
        let found = PyDict::new(py);
        found.set_item("time", PyArray1::from_vec(py, times))?;
        for (name, array) in taking.into_named() {
            found.set_item(name, array)?;
        }
        Ok(found)
    }

    /// The pattern of the sparse Jacobian in compressed rows: `indptr`, `indices` and the number of columns.
    fn jacobian_pattern<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>, usize)> {
        let (_, jacobian) = self.pattern()?;
        let indices = (0..jacobian.rows()).flat_map(|row| jacobian.row(row)).map(|column| *column as usize);
        let ends = jacobian.offsets().iter().copied();
        // As SciPy chooses: both of 32 bits where these count all entries.
        let [ends, indices] = if i32::try_from(jacobian.entries()).is_ok() {
            [integers::<i32>(py, ends), integers::<i32>(py, indices)]
        } else {
            [integers::<i64>(py, ends), integers::<i64>(py, indices)]
        };
        Ok((ends, indices, jacobian.columns()))
    }

    /// What the rows and the columns of the sparse Jacobian are: names, and nodes with numbers.
    fn jacobian_names(&self) -> PyResult<(Vec<String>, Vec<Column>)> {
        let (_, jacobian) = self.pattern()?;
        let rows = jacobian.equations().iter().map(|equation| equation.title(&self.model));
        let columns = jacobian.freedoms().iter().map(|freedom| (freedom.node.to_string(), freedom.number));
        Ok((rows.collect(), columns.collect()))
    }

    /// The entries of the sparse Jacobian (states, entries), in the order of its pattern; how many values need care, and the first.
    fn jacobian<'py>(
        &self,
        py: Python<'py>,
        path: Option<&str>,
        document: Option<&str>,
        arrays: Option<Bound<'py, PyDict>>,
        out: Option<Bound<'py, PyDict>>,
    ) -> PyResult<(Bound<'py, PyAny>, usize, Option<String>)> {
        let moved = arrays.as_ref().map(Moved::new).transpose()?;
        let arrays = moved.as_ref().map(Moved::arrays).transpose()?;
        let states = self.given(path, document, arrays.as_ref())?;
        let (plan, jacobian) = self.pattern()?;
        let count = arrays.as_ref().map_or(states.len(), |arrays| arrays.count);
        let mut taking = Taking::new(out);
        taking.add(py, "data", &[count, jacobian.entries()])?;
        taking.check()?;
        let mut writable = taking.writable()?;
        let [data] = writable.as_mut_slice() else { return Err(PyValueError::new_err("no array")) };
        let data = data.as_slice_mut().map_err(refused)?;
        let (care, first) = work::apart(py, || {
            let (mut sequence, mut values) = (Sequence::new(&self.model, plan), Vec::new());
            let (mut care, mut first) = (0, None);
            for s in 0..count {
                let state = match &arrays {
                    Some(arrays) => Cow::Owned(arrays.state(s)),
                    None => Cow::Borrowed(&states[s]),
                };
                let flags = sequence.assemble(&state, jacobian, &mut values)?;
                let place = s * values.len();
                if let Some(to) = data.get_mut(place..place + values.len()) {
                    to.copy_from_slice(&values);
                }
                care += flags.len();
                if let (None, Some((title, flag))) = (&first, flags.first()) {
                    first = Some(format!("state {s}, {title}: {}", flag_in_words(flag)));
                }
            }
            Ok::<_, ForeignPattern>((care, first))
        })?
        .map_err(refused)?;
        drop(writable);
        let array = taking.into_named().pop().map(|(_, array)| array.into_any());
        Ok((array.ok_or_else(|| PyValueError::new_err("no array"))?, care, first))
    }

    /// The audit of the model, and of every number at its states.
    fn audit(
        &self,
        py: Python<'_>,
        path: Option<&str>,
        document: Option<&str>,
        model_only: bool,
        seed: String,
    ) -> PyResult<Report> {
        let states = self.states(path, document)?;
        self.model.check_forces(&states, 0, &self.scene.name).map_err(refused)?;
        let settings = Settings { seed, ..Settings::default() };
        let plan = Plan::compile(&self.model, &Selection::All, Request::nothing(0)).map_err(refused)?;
        let name = self.scene.name.as_str();
        let report = work::apart(py, || {
            let target = Target { name, model: &self.model, plan: &plan, states: &states };
            let targets = if model_only { Vec::new() } else { vec![target] };
            let mut report = audit_scenes(&settings, &targets, &|_| {});
            report.models = vec![audit_model(&self.scene, &states, &Levels::default())];
            report
        })?;
        Ok(Report::of_audit(report))
    }
}
