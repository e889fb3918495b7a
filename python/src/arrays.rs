//! Motions of nodes from arrays, and arrays that take the numbers of connectors.

use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyReadwriteArrayDyn, PyUntypedArrayMethods};
use pintle_model::evaluate::{ByNode, NodeArrays, Rotations};
use pintle_scene::Label;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;

/// Arrays by state and node, as `pintle states --format npz` names them.
pub(crate) struct Moved<'py> {
    nodes: Vec<Label>,
    count: usize,
    arrays: BTreeMap<String, PyReadonlyArrayDyn<'py, f64>>,
}

fn refused(what: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(what.to_string())
}

impl<'py> Moved<'py> {
    /// From arrays in C order, and `node`.
    pub(crate) fn new(given: &Bound<'py, PyDict>) -> PyResult<Self> {
        let mut found = Self { nodes: Vec::new(), count: 0, arrays: BTreeMap::new() };
        if let Some(nodes) = given.get_item("node")? {
            let labels: Vec<String> = nodes.extract()?;
            let label = |text: &String| {
                text.parse().map_err(|error| refused(format!("node: {text:?} names no node: {error}")))
            };
            found.nodes = labels.iter().map(label).collect::<PyResult<_>>()?;
        }
        let mut states: Option<(String, usize)> = None;
        for (name, array) in given.iter() {
            let name: String = name.extract()?;
            if name == "node" {
                continue;
            }
            let each = match name.as_str() {
                "time" => None,
                "flow" | "flow_velocity" | "flow_acceleration" => Some(1),
                "quaternion" => Some(4),
                "u"
                | "rotation_vector"
                | "velocity"
                | "angular_velocity"
                | "acceleration"
                | "angular_acceleration" => Some(3),
                other => {
                    return Err(refused(format!(
                        "there is no array {other} of states; there are node, time, u, rotation_vector or quaternion, velocity, \
                         angular_velocity, acceleration, angular_acceleration, flow, flow_velocity, flow_acceleration"
                    )));
                }
            };
            let array = array.cast::<PyArrayDyn<f64>>()?;
            let array =
                array.try_readonly().map_err(|error| refused(format!("{name} cannot be read: {error}")))?;
            let shape = array.shape().to_vec();
            let Some(count) = shape.first().copied() else {
                return Err(refused(format!("{name} has no states: its shape is ()")));
            };
            let wanted = match each {
                None => vec![count],
                Some(1) => vec![count, found.nodes.len()],
                Some(each) => vec![count, found.nodes.len(), each],
            };
            if shape != wanted {
                return Err(refused(format!(
                    "{name} has shape {shape:?}, not {wanted:?}: states, nodes, components"
                )));
            }
            match &states {
                Some((other, known)) if *known != count => {
                    return Err(refused(format!("{name} has {count} states, and {other} has {known}")));
                }
                _ => states = Some((name.clone(), count)),
            }
            found.arrays.insert(name, array);
        }
        if found.arrays.contains_key("quaternion") && found.arrays.contains_key("rotation_vector") {
            return Err(refused("there are both rotation_vector and quaternion: give one of them"));
        }
        found.count = states.map_or(0, |(_, count)| count);
        Ok(found)
    }

    /// What they hold.
    pub(crate) fn arrays(&self) -> PyResult<NodeArrays<'_>> {
        let nodes = self.nodes.len();
        let slice = |name: &str| -> PyResult<Option<&[f64]>> {
            let array = self.arrays.get(name).map(|array| array.as_slice());
            array.transpose().map_err(|error| refused(format!("{name} cannot be read: {error}")))
        };
        let by = |name: &str, each: usize| -> PyResult<Option<ByNode<'_>>> {
            Ok(slice(name)?.map(|numbers| ByNode::new(numbers, nodes * each, each)))
        };
        let vectors = by("rotation_vector", 3)?.map(Rotations::Vectors);
        let quaternions = by("quaternion", 4)?.map(Rotations::Quaternions);
        Ok(NodeArrays {
            count: self.count,
            nodes: &self.nodes,
            times: slice("time")?,
            displacement: by("u", 3)?,
            rotation: vectors.or(quaternions),
            velocity: by("velocity", 3)?,
            angular_velocity: by("angular_velocity", 3)?,
            acceleration: by("acceleration", 3)?,
            angular_acceleration: by("angular_acceleration", 3)?,
            flow: [by("flow", 1)?, by("flow_velocity", 1)?, by("flow_acceleration", 1)?],
        })
    }
}

/// Arrays that take numbers: those that are given, and new ones.
pub(crate) struct Taking<'py> {
    given: Option<Bound<'py, PyDict>>,
    named: Vec<(String, Bound<'py, PyArrayDyn<f64>>)>,
}

impl<'py> Taking<'py> {
    pub(crate) const fn new(given: Option<Bound<'py, PyDict>>) -> Self {
        Self { given, named: Vec::new() }
    }

    /// Adds an array of that shape.
    pub(crate) fn add(&mut self, py: Python<'py>, name: &str, shape: &[usize]) -> PyResult<()> {
        let given = self.given.as_ref().map(|given| given.get_item(name)).transpose()?.flatten();
        let array = match given {
            None => PyArrayDyn::zeros(py, shape, false),
            Some(given) => {
                let array = given.cast_into::<PyArrayDyn<f64>>().map_err(|_| {
                    refused(format!(
                        "out[{name:?}] is no NumPy array of float64: numpy.empty({shape:?}) makes one"
                    ))
                })?;
                if array.shape() != shape || !array.is_c_contiguous() {
                    let found = array.shape();
                    return Err(refused(format!(
                        "out[{name:?}] has shape {found:?}, not {shape:?} in C order"
                    )));
                }
                array
            }
        };
        self.named.push((name.to_string(), array));
        Ok(())
    }

    /// Whether all that is given is asked for.
    pub(crate) fn check(&self) -> PyResult<()> {
        for name in self.given.iter().flat_map(|given| given.keys()) {
            let name: String = name.extract()?;
            if !self.named.iter().any(|(known, _)| *known == name) {
                let known: Vec<&str> = self.named.iter().map(|(known, _)| known.as_str()).collect();
                return Err(refused(format!(
                    "out has {name:?}, which is not asked for; asked for are {}",
                    known.join(", ")
                )));
            }
        }
        Ok(())
    }

    /// The arrays, to be written.
    pub(crate) fn writable(&self) -> PyResult<Vec<PyReadwriteArrayDyn<'py, f64>>> {
        let writable = |(name, array): &(String, Bound<'py, PyArrayDyn<f64>>)| {
            array
                .try_readwrite()
                .map_err(|error| refused(format!("out[{name:?}] cannot be written: {error}")))
        };
        self.named.iter().map(writable).collect()
    }

    /// The arrays by name.
    pub(crate) fn into_named(self) -> Vec<(String, Bound<'py, PyArrayDyn<f64>>)> {
        self.named
    }
}
