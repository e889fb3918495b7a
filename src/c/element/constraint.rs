//! A multi-point constraint of `pintle_element.h`.

use crate::message::{Answer, Asked, OFFERS, names, numbers, out_of_domain};
use crate::native::{Declared, NONE, Node, row, scalar};
use libloading::Library;
use serde_json::{Value, json};
use std::ffi::{CString, c_char, c_int, c_uint};

const ROWS: usize = 7;
const DOFS: usize = 16;

#[repr(C)]
struct Constraint {
    r#type: *const c_char,
    x: [[f64; 3]; 2],
    axes: [[f64; 3]; 2],
    has: [c_int; ROWS],
}

#[repr(C)]
struct State {
    nodes: [Node; 2],
    angles: [f64; 2],
    angle_velocities: [f64; 2],
    angle_accelerations: [f64; 2],
}

type Row = [f64; DOFS];
type Matrix = [Row; DOFS];

#[repr(C)]
struct Numbers {
    values: [f64; ROWS],
    rows: [Row; ROWS],
    second_derivatives: [Matrix; ROWS],
    rates: [f64; ROWS],
    accelerations: [f64; ROWS],
}

type Mpc = unsafe extern "C" fn(*const Constraint, *const State, c_uint, *mut Numbers) -> c_int;

/// A routine, and the constraint that it is.
pub(crate) struct Native {
    mpc: Mpc,
    offers: u32,
    convention: Value,
    width: usize,
    name: CString,
    definition: Value,
}

impl Native {
    /// The routine of a library, if it has one.
    ///
    /// # Errors
    /// In words, what it lacks.
    pub(crate) fn of(library: &Library) -> Result<Option<Self>, String> {
        #[expect(unsafe_code, reason = "a function of the user's library")]
        // SAFETY: its type is that which the header declares; the library is never unloaded.
        let mpc = unsafe { library.get::<Mpc>(b"pintle_mpc\0").ok().map(|mpc| *mpc) };
        let Some(mpc) = mpc else { return Ok(None) };
        let Declared { offers, convention, .. } = Declared::of(library)?;
        let (name, definition) = (CString::default(), Value::Null);
        Ok(Some(Self { mpc, offers, convention, width: DOFS, name, definition }))
    }

    pub(crate) fn hello(&self) -> Value {
        let offers = names(self.offers);
        json!({
            "protocol": "pintle-candidate/1", "name": "pintle_mpc", "offers": offers, "convention": self.convention,
        })
    }

    pub(crate) fn open(&mut self, open: &Value) -> Result<(), String> {
        let name = open.get("type").and_then(Value::as_str).unwrap_or_default();
        if !name.starts_with("MPC ") {
            return Err(format!("pintle_mpc is a multi-point constraint, and {name} is none"));
        }
        let axes = open.get("axes").and_then(Value::as_array).map_or(0, Vec::len);
        let own = self.convention.get("columns").and_then(Value::as_array).map(Vec::len);
        self.width = own.unwrap_or(14 + axes).min(DOFS);
        self.name = CString::new(name).map_err(|error| error.to_string())?;
        self.definition = open.clone();
        Ok(())
    }

    pub(crate) fn evaluate(&self, asked: &Asked<'_>) -> Answer {
        let open = &self.definition;
        let flat: [f64; 6] = numbers(open.get("axes"));
        let [a, b, c, d, e, f] = flat;
        let has = |k: usize| open.pointer(&format!("/equations/{k}")).is_some_and(|of| !of.is_null());
        let constraint = Constraint {
            r#type: self.name.as_ptr(),
            x: ["S", "M"].map(|node| numbers(open.pointer(&format!("/initial/{node}/x")))),
            axes: [[a, b, c], [d, e, f]],
            has: std::array::from_fn(|k| c_int::from(has(k))),
        };
        let state = State {
            nodes: ["S", "M"].map(|name| Node::of(asked.state.get(name))),
            angles: numbers(asked.state.get("angles")),
            angle_velocities: numbers(asked.state.get("angle_velocities")),
            angle_accelerations: numbers(asked.state.get("angle_accelerations")),
        };
        let mut found = Box::new(Numbers {
            values: [NONE; ROWS],
            rows: [[NONE; DOFS]; ROWS],
            second_derivatives: [[[NONE; DOFS]; DOFS]; ROWS],
            rates: [NONE; ROWS],
            accelerations: [NONE; ROWS],
        });
        #[expect(unsafe_code, reason = "the user's routine is called")]
        // SAFETY: the pointers are to live values of the types that the header declares, and the routine may write to the numbers alone.
        // What it does besides ends this process, and no other.
        let code =
            unsafe { (self.mpc)(&raw const constraint, &raw const state, asked.wants, &raw mut *found) };
        if code != 0 {
            return out_of_domain(format!("pintle_mpc returned {code}"));
        }
        let offered = OFFERS.into_iter().filter(|(_, bit)| asked.wants & bit != 0);
        offered.map(|(name, _)| (name.to_string(), self.written(name, &found))).collect()
    }

    fn written(&self, name: &str, of: &Numbers) -> Value {
        let row = |of: &Row| row(of.get(..self.width).unwrap_or(of));
        match name {
            "values" => of.values.iter().map(scalar).collect(),
            "rates" => of.rates.iter().map(scalar).collect(),
            "accelerations" => of.accelerations.iter().map(scalar).collect(),
            "rows" => of.rows.iter().map(row).collect(),
            "second_derivatives" => {
                let matrix = |matrix: &Matrix| {
                    let lines: Vec<Value> = matrix.iter().take(self.width).map(row).collect();
                    if lines.iter().all(Value::is_null) { Value::Null } else { lines.into() }
                };
                of.second_derivatives.iter().map(matrix).collect()
            }
            _ => Value::Null,
        }
    }
}
