//! A friction of `pintle_element.h`.

use crate::message::{Answer, Asked, OFFERS, names, number, numbers, out_of_domain};
use crate::native::{Declared, NONE, row, scalar};
use libloading::Library;
use serde_json::{Value, json};
use std::ffi::{CString, c_char, c_int, c_uint};

#[repr(C)]
struct Friction {
    r#type: *const c_char,
    coefficient: f64,
    maximum: f64,
    stick_stiffness: f64,
    parameters: [f64; 8],
}

#[repr(C)]
struct State {
    forces: [f64; 6],
    displacement: [f64; 6],
    pressing: [f64; 6],
    forces_before: [f64; 6],
    slip_before: f64,
    position: [f64; 6],
    motion: [f64; 6],
}

#[repr(C)]
struct Numbers {
    criterion: [f64; 4],
    gradients: [[f64; 6]; 4],
    friction_forces: [f64; 10],
    friction_tangent: [[f64; 12]; 6],
}

type Routine = unsafe extern "C" fn(*const Friction, *const State, c_uint, *mut Numbers) -> c_int;

/// A routine, and the friction that it is.
pub(crate) struct Native {
    routine: Routine,
    offers: u32,
    convention: Value,
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
        let routine = unsafe { library.get::<Routine>(b"pintle_friction\0").ok().map(|routine| *routine) };
        let Some(routine) = routine else { return Ok(None) };
        let Declared { offers, convention, .. } = Declared::of(library)?;
        Ok(Some(Self { routine, offers, convention, name: CString::default(), definition: Value::Null }))
    }

    pub(crate) fn hello(&self) -> Value {
        let offers = names(self.offers);
        json!({
            "protocol": "pintle-candidate/1", "name": "pintle_friction", "offers": offers,
            "convention": self.convention,
        })
    }

    pub(crate) fn open(&mut self, open: &Value) -> Result<(), String> {
        let name = open.get("type").and_then(Value::as_str).unwrap_or_default();
        if !name.starts_with("FRICTION ") {
            return Err(format!("pintle_friction is a friction, and {name} is none"));
        }
        self.name = CString::new(name).map_err(|error| error.to_string())?;
        self.definition = open.clone();
        Ok(())
    }

    pub(crate) fn evaluate(&self, asked: &Asked<'_>) -> Answer {
        let open = &self.definition;
        let or_none = |value: Option<&Value>| value.and_then(Value::as_f64).unwrap_or(-1.0);
        let parameters = open.get("parameters").and_then(Value::as_object);
        let parameters: Vec<f64> =
            parameters.into_iter().flat_map(|all| all.values()).map(|x| number(Some(x))).collect();
        let of = |pointer: &str| asked.state.pointer(pointer);
        let kept = of("/previous/stick_stiffness").and_then(Value::as_f64);
        let friction = Friction {
            r#type: self.name.as_ptr(),
            coefficient: number(open.get("coefficient")),
            maximum: or_none(open.get("maximum")),
            stick_stiffness: kept.unwrap_or_else(|| or_none(open.get("stick_stiffness"))),
            parameters: std::array::from_fn(|i| parameters.get(i).copied().unwrap_or(0.0)),
        };
        let state = State {
            forces: numbers(of("/forces")),
            displacement: numbers(of("/increment/displacement")),
            pressing: numbers(of("/increment/pressing")),
            forces_before: numbers(of("/previous/forces")),
            slip_before: number(of("/previous/accumulated_slip")),
            position: numbers(of("/position")),
            motion: numbers(of("/motion")),
        };
        let mut found = Numbers {
            criterion: [NONE; 4],
            gradients: [[NONE; 6]; 4],
            friction_forces: [NONE; 10],
            friction_tangent: [[NONE; 12]; 6],
        };
        #[expect(unsafe_code, reason = "the user's routine is called")]
        // SAFETY: the pointers are to live values of the types that the header declares, and the routine may write to the numbers alone.
        // What it does besides ends this process, and no other.
        let code =
            unsafe { (self.routine)(&raw const friction, &raw const state, asked.wants, &raw mut found) };
        if code != 0 {
            return out_of_domain(format!("pintle_friction returned {code}"));
        }
        let all = |name: &str| -> Value {
            match name {
                "criterion" => found.criterion.iter().map(scalar).collect(),
                "gradients" => found.gradients.iter().map(|of| row(of)).collect(),
                "friction_forces" => found.friction_forces.iter().map(scalar).collect(),
                "friction_tangent" => found.friction_tangent.iter().map(|of| row(of)).collect(),
                _ => Value::Null,
            }
        };
        let offered = OFFERS.into_iter().filter(|(_, bit)| asked.wants & bit != 0);
        offered.map(|(name, _)| (name.to_string(), all(name))).collect()
    }
}
