//! The extension `pintle._native`: what the package needs of the library. Arrays are made of bytes by the package itself.

use pintle_audit::{Report, Settings, Target};
use pintle_check::{Asked, Convention, Door, Misbehaviour, check};
use pintle_kinematics::catalog::Slot;
use pintle_kinematics::connector::{Output, Request};
use pintle_model::evaluate::{Model, Plan, Selection, Sequence, request};
use pintle_scene::{Diagnostic, Scene, State, StateFile};
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use serde_json::{Map, Value};
use std::ffi::OsString;

/// Runs the command line, and gives its exit code.
#[pyfunction]
fn main(py: Python<'_>, arguments: Vec<String>) -> u8 {
    py.detach(|| {
        let code = pintle::command::main(arguments.into_iter().map(OsString::from));
        // An exit code shows its number in no other way.
        let text = format!("{code:?}");
        text.chars().filter(char::is_ascii_digit).collect::<String>().parse().unwrap_or(1)
    })
}

/// A Python function that answers messages as text.
struct Callable {
    answer: Py<PyAny>,
    reply: Option<String>,
}

impl Door for Callable {
    fn send(&mut self, message: &Value, due: &'static str) -> Result<(), Misbehaviour> {
        let reply = Python::attach(|py| self.answer.call1(py, (message.to_string(),))?.extract(py));
        self.reply =
            reply.map_err(|error: PyErr| Misbehaviour::NoMessage { due, what: error.to_string() })?;
        Ok(())
    }

    fn receive(&mut self, due: &'static str) -> Result<Map<String, Value>, Misbehaviour> {
        let reply = self.reply.take().unwrap_or_default();
        match serde_json::from_str(&reply) {
            Ok(Value::Object(object)) => Ok(object),
            _ => Err(Misbehaviour::NoMessage { due, what: reply }),
        }
    }

    fn close(self) -> Result<(), Misbehaviour> {
        Ok(())
    }
}

fn wrong(diagnostic: &Diagnostic) -> PyErr {
    PyValueError::new_err(format!("{}: {diagnostic}", diagnostic.file()))
}

/// A report: whether it is right, as JSON, as text, as one screen, as a page.
fn told<'py>(
    py: Python<'py>,
    report: &Report,
    short: Option<(&str, &[String])>,
) -> PyResult<Bound<'py, PyDict>> {
    let mut written: [Vec<u8>; 4] = Default::default();
    let [json, text, brief, html] = &mut written;
    let width = 100;
    pintle_report::audit::json(json, report)
        .and_then(|()| pintle_report::audit::human(text, report, width, false))
        .and_then(|()| match short {
            Some((of, notes)) => pintle_report::audit::checked(brief, report, of, notes, width),
            None => pintle_report::audit::human(brief, report, width, false),
        })
        .and_then(|()| pintle_report::audit::html(html, report, &pintle_report::audit::Supplement::default()))
        .map_err(|error| PyOSError::new_err(error.to_string()))?;
    let found = PyDict::new(py);
    for (key, bytes) in ["json", "text", "brief", "html"].into_iter().zip(&written) {
        found.set_item(key, String::from_utf8_lossy(bytes).into_owned())?;
    }
    found.set_item("ok", report.mismatches() == 0 && report.survivors() == 0 && !report.is_open())?;
    Ok(found)
}

/// Checks a routine: `answer` gives the answers to messages of the protocol.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "keywords of Python, all given by the package")]
fn check_routine<'py>(
    py: Python<'py>,
    answer: Py<PyAny>,
    of: &str,
    states: usize,
    near_singular_states: usize,
    wide_states: usize,
    histories: usize,
    springs: [Option<f64>; 6],
    seed: String,
) -> PyResult<Bound<'py, PyDict>> {
    let definition = pintle::command::connector(of).map_err(PyValueError::new_err)?;
    let settings =
        Settings { states, near_singular_states, wide_states, seed, atlas: false, ..Settings::default() };
    let asked = Asked { settings, histories, convention: None::<Convention>, springs };
    let door = Callable { answer, reply: None };
    let checked = py.detach(|| check(door, &definition, asked));
    let checked = checked.map_err(|misbehaviour| PyValueError::new_err(misbehaviour.to_string()))?;
    told(py, &checked.report, Some((&definition.connection.name, &checked.notes())))
}

/// Audits a scene at its states, as `pintle audit` does.
#[pyfunction]
fn audit_scene<'py>(py: Python<'py>, scene: &Loaded, settings: &str) -> PyResult<Bound<'py, PyDict>> {
    let settings = Settings { seed: settings.to_string(), atlas: false, ..Settings::default() };
    let (name, states) = (scene.scene.name.clone(), &scene.scene.states);
    let model = &scene.model;
    let report = py.detach(|| {
        let plan = Plan::compile(model, &Selection::All, Request::everything(2))
            .map_err(|error| error.to_string())?;
        let target = Target { name: &name, model, plan: &plan, states };
        Ok::<_, String>(pintle_audit::audit_scenes(&settings, &[target], &|_| ()))
    });
    told(py, &report.map_err(PyValueError::new_err)?, None)
}

/// A scene, with what it is made of resolved.
#[pyclass(frozen)]
struct Loaded {
    scene: Scene,
    model: Model,
}

#[pymethods]
impl Loaded {
    #[new]
    fn new(py: Python<'_>, path: &str) -> PyResult<Self> {
        py.detach(|| {
            let scene = pintle::command::scene(path).map_err(PyValueError::new_err)?;
            let model = Model::compile(&scene).map_err(|error| wrong(&error))?;
            Ok(Self { scene, model })
        })
    }

    /// Element number, connection type, components that exist.
    fn connectors(&self) -> Vec<(String, String, Vec<bool>)> {
        let of = |element: &pintle_model::evaluate::ConnectorElement| {
            let has = |k: usize| element.connector.differentiated(k).is_some();
            let name = element.connector.connection().name.to_string();
            (element.label.to_string(), name, (0..6).map(has).collect())
        };
        self.model.connectors.iter().map(of).collect()
    }

    /// How many states the scene has of its own.
    fn states(&self) -> usize {
        self.scene.states.len()
    }

    /// Outputs at states: bytes of doubles by name, (state, connector, component) and for `jacobian` and `hessian` the degrees of freedom
    /// after that. What a connector has not is NaN.
    fn evaluate<'py>(
        &self,
        py: Python<'py>,
        states: Option<&str>,
        outputs: Vec<String>,
        order: u8,
        independent: bool,
    ) -> PyResult<(usize, Bound<'py, PyDict>)> {
        let found = py.detach(|| self.evaluated(states, &outputs, order, independent));
        let (count, arrays) = found.map_err(PyValueError::new_err)?;
        let given = PyDict::new(py);
        for (name, numbers) in arrays {
            let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_ne_bytes()).collect();
            given.set_item(name, PyBytes::new(py, &bytes))?;
        }
        Ok((count, given))
    }
}

/// The name of an array, and its numbers.
type Numbers = (String, Vec<f64>);

impl Loaded {
    fn evaluated(
        &self,
        states: Option<&str>,
        outputs: &[String],
        order: u8,
        independent: bool,
    ) -> Result<(usize, Vec<Numbers>), String> {
        let read = states.map(|file| StateFile::read(file, &self.scene)).transpose();
        let read = read.map_err(|error| wrong(&error).to_string())?;
        let own =
            || if self.scene.states.is_empty() { vec![State::default()] } else { self.scene.states.clone() };
        let states = read.map_or_else(own, |file| file.states);
        let request =
            request(outputs.iter().map(String::as_str), order).map_err(|error| error.to_string())?;
        let plan = Plan::compile(&self.model, &Selection::All, request.clone())
            .map_err(|error| error.to_string())?;
        let named = Output::ALL.into_iter().filter(|output| (0..6).any(|k| request.wants(*output, k)));
        let named: Vec<Output> =
            named.filter(|output| output.is_kinematic() || is_residual(*output)).collect();
        let mut arrays: Vec<Numbers> =
            named.iter().map(|output| (output.name().to_string(), Vec::new())).collect();
        let (mut jacobian, mut hessian) = (Vec::new(), Vec::new());
        let mut sequence = Sequence::new(&self.model, &plan);
        let start = independent.then(|| sequence.clone());
        for state in &states {
            if let Some(start) = &start {
                sequence.clone_from(start);
            }
            for result in sequence.step(state).connectors {
                let evaluation = &result.evaluation;
                for (output, (_, numbers)) in named.iter().zip(&mut arrays) {
                    let of = match output {
                        Output::CP => &evaluation.position,
                        Output::CU => &evaluation.displacement,
                        Output::CV => &evaluation.velocity,
                        Output::CA => &evaluation.acceleration,
                        Output::RES => &evaluation.residual,
                        Output::RESV => &evaluation.residual_rate,
                        _ => &evaluation.residual_acceleration,
                    };
                    numbers.extend(of.iter().map(|x| x.unwrap_or(f64::NAN)));
                }
                if order > 0 {
                    jacobian.extend(evaluation.jacobian.iter().flat_map(|row| row.unwrap_or([f64::NAN; 14])));
                }
                if order > 1 {
                    for matrix in &evaluation.hessian {
                        match matrix {
                            Some(matrix) => hessian.extend(matrix.as_flattened()),
                            None => hessian.extend([f64::NAN; 196]),
                        }
                    }
                }
            }
        }
        if order > 0 {
            arrays.push(("jacobian".to_string(), jacobian));
        }
        if order > 1 {
            arrays.push(("hessian".to_string(), hessian));
        }
        Ok((states.len(), arrays))
    }
}

const fn is_residual(output: Output) -> bool {
    matches!(output, Output::RES | Output::RESV | Output::RESA)
}

/// The connection types: name, and of each component `constrained`, `available` or none.
#[pyfunction]
fn types() -> Vec<(String, Vec<Option<String>>)> {
    let of = |connection: &pintle_kinematics::catalog::ConnectionType| {
        let role = |k: usize| match connection.slots[k] {
            Slot::Absent => None,
            Slot::Available(_) => Some("available".to_string()),
            Slot::Constrained(..) => Some("constrained".to_string()),
            Slot::Measured(_) => Some("measured".to_string()),
        };
        (connection.name.to_string(), (0..6).map(role).collect())
    };
    pintle_kinematics::catalog::TABLE.iter().map(of).collect()
}

/// The extension.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("VERSION", pintle::VERSION)?;
    module.add("DRIVER", pintle_check::DRIVER)?;
    module.add_class::<Loaded>()?;
    module.add_function(wrap_pyfunction!(main, module)?)?;
    module.add_function(wrap_pyfunction!(check_routine, module)?)?;
    module.add_function(wrap_pyfunction!(audit_scene, module)?)?;
    module.add_function(wrap_pyfunction!(types, module)?)?;
    Ok(())
}
