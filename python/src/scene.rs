//! A scene: read, evaluated into arrays, audited.

use crate::report::Report;
use crate::work;
use numpy::ndarray::{Array3, Array4, Array5, ArrayViewMut, Axis, Dimension, RemoveAxis};
use numpy::{IntoPyArray, PyArray1};
use pintle::audit::{Settings, audit_scenes};
use pintle::connector::Output;
use pintle::node::DOFS;
use pintle::scene::{Scene as Read, State, StateFile};
use pintle_audit::Target;
use pintle_audit::model::{Levels, audit_model};
use pintle_model::behavior::state::Velocities;
use pintle_model::evaluate::{Item, Model, Plan, Selection, Sequence, request};
use pintle_report::Block;
use pintle_scene::Format;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::fmt::Display;

/// A model of connectors and constraints, with its states.
#[pyclass(frozen, module = "pintle._pintle")]
pub(crate) struct Scene {
    scene: Read,
    model: Model,
}

fn refused(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

impl Scene {
    fn of(scene: Read) -> PyResult<Self> {
        let model = Model::compile(&scene).map_err(refused)?;
        Ok(Self { scene, model })
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
}

/// The part of an array that belongs to state `s` and connector `c`.
fn part<D>(
    array: &mut numpy::ndarray::Array<f64, D>,
    s: usize,
    c: usize,
) -> ArrayViewMut<'_, f64, <D::Smaller as Dimension>::Smaller>
where
    D: RemoveAxis,
    D::Smaller: RemoveAxis,
{
    array.index_axis_mut(Axis(0), s).index_axis_move(Axis(0), c)
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
    fn evaluate<'py>(
        &self,
        py: Python<'py>,
        path: Option<&str>,
        document: Option<&str>,
        outputs: Vec<String>,
        order: u8,
    ) -> PyResult<Bound<'py, PyDict>> {
        if order > 2 {
            return Err(PyValueError::new_err(format!(
                "order is {order}: 0 none, 1 Jacobian, 2 also second derivatives"
            )));
        }
        let mut states = self.states(path, document)?;
        if states.is_empty() {
            states.push(State::default());
        }
        self.model.check_forces(&states, 0, &self.scene.name).map_err(refused)?;
        let request = request(outputs.iter().map(String::as_str), order).map_err(refused)?;
        let outputs: Vec<Output> = request.outputs().collect();
        if let Some(output) = outputs.iter().find(|one| one.is_nodal() || **one == Output::TANGENT) {
            let name = output.name();
            return Err(PyValueError::new_err(format!(
                "{name} is no number of a component, and not among the arrays: pintle eval --format json has it"
            )));
        }
        let plan = Plan::compile(&self.model, &Selection::All, request.clone()).map_err(refused)?;
        let (count, connectors) = (states.len(), self.model.connectors.len());
        let place = |index: usize| plan.connectors.iter().position(|one| *one == index);
        let places: Vec<Option<usize>> = (0..connectors).map(place).collect();
        let (values, jacobian, hessian) = work::apart(py, || {
            let nan = f64::NAN;
            let mut values = vec![Array3::from_elem((count, connectors, 6), nan); outputs.len()];
            let size = |least: u8| if order >= least { (count, connectors, 6, DOFS) } else { (0, 0, 0, 0) };
            let mut jacobian = Array4::from_elem(size(1), nan);
            let (n, m, k, j) = size(2);
            let mut hessian = Array5::from_elem((n, m, k, j, j), nan);
            let mut sequence = Sequence::new(&self.model, &plan);
            if !states.iter().any(pintle::scene::has_rates) {
                sequence.set_velocities(Velocities::Increments);
            }
            for (s, state) in states.iter().enumerate() {
                let seen: Result<(), std::convert::Infallible> = sequence.visit(state, |item| {
                    let Item::Connector(result) = item else { return Ok(()) };
                    let Some(c) = places.get(result.index).copied().flatten() else { return Ok(()) };
                    let block = Block::of_connector(&self.model, &request, result);
                    for row in &block.rows {
                        let Some(k) = pintle::catalog::COMPONENT.iter().position(|name| *name == row.name)
                        else {
                            continue;
                        };
                        for (array, output) in values.iter_mut().zip(&outputs) {
                            let at = Output::ALL.iter().position(|one| one == output);
                            let value = at.and_then(|at| row.values.get(at).copied().flatten());
                            part(array, s, c)[k] = value.map_or(nan, |value| value.number());
                        }
                    }
                    for k in 0..6 {
                        if let (Some(row), 1..) = (&result.evaluation.jacobian[k], order) {
                            (0..DOFS).for_each(|j| part(&mut jacobian, s, c)[[k, j]] = row[j]);
                        }
                        if let (Some(matrix), 2..) = (&result.evaluation.hessian[k], order) {
                            let mut to = part(&mut hessian, s, c);
                            (0..DOFS).for_each(|i| (0..DOFS).for_each(|j| to[[k, i, j]] = matrix[i][j]));
                        }
                    }
                    Ok(())
                });
                let Ok(()) = seen;
            }
            (values, jacobian, hessian)
        })?;
        let arrays = PyDict::new(py);
        let times: Vec<f64> = states.iter().map(|state| state.time.unwrap_or(f64::NAN)).collect();
        arrays.set_item("time", PyArray1::from_vec(py, times))?;
        for (output, array) in outputs.iter().zip(values) {
            arrays.set_item(output.name(), array.into_pyarray(py))?;
        }
        if order > 0 {
            arrays.set_item("jacobian", jacobian.into_pyarray(py))?;
        }
        if order > 1 {
            arrays.set_item("hessian", hessian.into_pyarray(py))?;
        }
        Ok(arrays)
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
        let plan = Plan::compile(&self.model, &Selection::All, pintle::connector::Request::nothing(0))
            .map_err(refused)?;
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
