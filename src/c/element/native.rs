//! A routine of `pintle_element.h`.

use crate::Options;
use crate::message::{
    Answer, Asked, OFFERS, names, number, numbers, out_of_domain, wants as wants_of, written,
};
use libloading::Library;
use serde_json::{Value, json};
use std::ffi::{CStr, CString, c_char, c_int, c_uint};

const COMPONENTS: usize = 6;
const DOFS: usize = 14;

/// What was not written: a NaN of a pattern that no computation makes.
pub(crate) const NONE: f64 = f64::from_bits(0x7ff8_7069_6e74_6c65);

#[repr(C)]
pub(crate) struct Node {
    x: [f64; 3],
    u: [f64; 3],
    triad: [f64; 9],
    quaternion: [f64; 4],
    rotation_vector: [f64; 3],
    flow: f64,
    increment: [f64; 3],
    velocity: [f64; 7],
    acceleration: [f64; 7],
}

impl Node {
    /// How many numbers it has.
    const SIZE: usize = size_of::<Self>() / size_of::<f64>();

    /// That of as many numbers as it has.
    fn of_numbers(numbers: &[f64]) -> Self {
        let mut rest = numbers.iter().copied();
        fn take<const N: usize>(rest: &mut impl Iterator<Item = f64>) -> [f64; N] {
            std::array::from_fn(|_| rest.next().unwrap_or(0.0))
        }
        let rest = &mut rest;
        // In the order of the header.
        Self {
            x: take(rest),
            u: take(rest),
            triad: take(rest),
            quaternion: take(rest),
            rotation_vector: take(rest),
            flow: take::<1>(rest)[0],
            increment: take(rest),
            velocity: take(rest),
            acceleration: take(rest),
        }
    }

    /// That of a message.
    pub(crate) fn of(of: Option<&Value>) -> Self {
        let key = |key: &str| of.and_then(|of| of.get(key));
        let rates = |kind: &str| {
            let [x, y, z] = numbers(key(kind));
            let [p, q, r] = numbers(key(&format!("angular_{kind}")));
            [x, y, z, p, q, r, number(key(&format!("flow_{kind}")))]
        };
        Self {
            x: numbers(key("x")),
            u: numbers(key("u")),
            triad: numbers(key("triad")),
            quaternion: numbers(key("quaternion")),
            rotation_vector: numbers(key("rotation_vector")),
            flow: number(key("flow")),
            increment: numbers(key("increment")),
            velocity: rates("velocity"),
            acceleration: rates("acceleration"),
        }
    }
}

/// A number that a routine was to write.
pub(crate) fn scalar(x: &f64) -> Value {
    if is_none(x) { Value::Null } else { written(*x) }
}

/// Numbers that a routine was to write; null where it wrote none of them.
pub(crate) fn row(row: &[f64]) -> Value {
    if row.iter().all(is_none) { Value::Null } else { row.iter().map(|x| written(*x)).collect() }
}

/// Numbers one by one.
fn put_all(numbers: &[f64], put: &mut impl FnMut(&[f64])) {
    numbers.iter().for_each(|x| put(std::slice::from_ref(x)));
}

const fn is_none(x: &f64) -> bool {
    x.to_bits() == NONE.to_bits()
}

#[repr(C)]
struct Connector {
    r#type: *const c_char,
    x: [[f64; 3]; 2],
    triad: [[f64; 9]; 2],
    kind: [c_int; COMPONENTS],
    springs: [f64; COMPONENTS],
    flow_scale: f64,
    planar: c_int,
}

#[repr(C)]
struct State {
    now: [Node; 2],
    before: [Node; 2],
    values_before: [f64; COMPONENTS],
}

type Row = [f64; DOFS];
type Matrix = [Row; DOFS];

#[repr(C)]
struct Numbers {
    values: [f64; COMPONENTS],
    rows: [Row; COMPONENTS],
    second_derivatives: [Matrix; COMPONENTS],
    rates: [f64; COMPONENTS],
    accelerations: [f64; COMPONENTS],
    nodal_forces: [Row; COMPONENTS],
    geometric_stiffness: [Matrix; COMPONENTS],
    element_forces: Row,
    element_stiffness: Matrix,
}

impl State {
    /// How many numbers it has.
    const SIZE: usize = 4 * Node::SIZE + COMPONENTS;

    /// That of as many numbers as it has.
    fn of_numbers(numbers: &[f64]) -> Self {
        let node = |n: usize| Node::of_numbers(numbers.get(n * Node::SIZE..).unwrap_or_default());
        let value =
            |k: usize| numbers.get(4 * Node::SIZE + k).copied().filter(|x| !x.is_nan()).unwrap_or(0.0);
        Self {
            now: [node(0), node(1)],
            before: [node(2), node(3)],
            values_before: std::array::from_fn(value),
        }
    }
}

impl Numbers {
    /// Nothing written yet.
    const fn none() -> Self {
        Self {
            values: [NONE; COMPONENTS],
            rows: [[NONE; DOFS]; COMPONENTS],
            second_derivatives: [[[NONE; DOFS]; DOFS]; COMPONENTS],
            rates: [NONE; COMPONENTS],
            accelerations: [NONE; COMPONENTS],
            nodal_forces: [[NONE; DOFS]; COMPONENTS],
            geometric_stiffness: [[[NONE; DOFS]; DOFS]; COMPONENTS],
            element_forces: [NONE; DOFS],
            element_stiffness: [[NONE; DOFS]; DOFS],
        }
    }
}

type Element = unsafe extern "C" fn(*const Connector, *const State, c_uint, *mut f64, *mut Numbers) -> c_int;

/// The variables of a library of `pintle_element.h`.
pub(crate) struct Declared {
    pub(crate) offers: u32,
    pub(crate) svars: usize,
    pub(crate) convention: Value,
}

impl Declared {
    /// Those of a library.
    ///
    /// # Errors
    /// In words, what it lacks.
    pub(crate) fn of(library: &Library) -> Result<Self, String> {
        #[expect(unsafe_code, reason = "three variables of the user's library")]
        // SAFETY: their types are those that the header declares; the library is never unloaded.
        let (offers, svars, convention) = unsafe {
            let offers = library.get::<*const c_uint>(b"pintle_offers\0");
            let offers = offers.map_err(|_| "the library does not define pintle_offers".to_string())?;
            let svars = library.get::<*const c_int>(b"pintle_svars\0").map_or(0, |count| **count);
            let convention = library.get::<*const *const c_char>(b"pintle_convention\0").ok();
            let convention = convention.filter(|text| !(**text).is_null() && !(***text).is_null());
            let convention = convention.map(|text| CStr::from_ptr(**text).to_string_lossy().into_owned());
            (**offers, svars, convention)
        };
        let convention = convention.map_or(Ok(json!({})), |text| serde_json::from_str(&text));
        let convention: Value = convention.map_err(|error| format!("pintle_convention: {error}"))?;
        let svars = usize::try_from(svars).map_err(|_| format!("pintle_svars is {svars}"))?;
        Ok(Self { offers, svars, convention })
    }
}

/// A routine of `pintle_element.h`, and the connector that it is.
pub(crate) struct Native {
    element: Element,
    offers: u32,
    svars: usize,
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
    pub(crate) fn of(library: &Library, options: &Options) -> Result<Option<Self>, String> {
        #[expect(unsafe_code, reason = "a function of the user's library")]
        // SAFETY: its type is that which the header declares; the library is never unloaded.
        let element = unsafe { library.get::<Element>(b"pintle_element\0").ok().map(|element| *element) };
        let Some(element) = element else { return Ok(None) };
        let Declared { offers, svars, convention } = Declared::of(library)?;
        let own = || convention.get("columns").and_then(Value::as_array).map_or(DOFS, Vec::len);
        let width = if options.columns.is_empty() { own() } else { options.columns.len() };
        Ok(Some(Self {
            element,
            offers,
            svars,
            convention,
            width: width.min(DOFS),
            name: CString::default(),
            definition: Value::Null,
        }))
    }

    pub(crate) fn hello(&self) -> Value {
        let (offers, memory) = (names(self.offers), self.svars > 0);
        json!({
            "protocol": "pintle-candidate/1", "name": "pintle_element", "offers": offers,
            "convention": self.convention, "memory": memory, "binary": !memory,
        })
    }

    pub(crate) fn open(&mut self, open: &Value) -> Result<(), String> {
        let name = open.get("type").and_then(Value::as_str).unwrap_or_default();
        self.name = CString::new(name).map_err(|error| error.to_string())?;
        self.definition = open.clone();
        Ok(())
    }

    fn connector(&self) -> Connector {
        let open = &self.definition;
        let of = |node: &str, key: &str| open.pointer(&format!("/initial/{node}/{key}"));
        let kind = |k: usize| match open.pointer(&format!("/components/{k}/kind")).and_then(Value::as_str) {
            Some("constrained") => 1,
            Some(_) => 0,
            None => -1,
        };
        Connector {
            r#type: self.name.as_ptr(),
            x: ["a", "b"].map(|node| numbers(of(node, "x"))),
            triad: ["a", "b"].map(|node| numbers(of(node, "triad"))),
            kind: std::array::from_fn(kind),
            springs: numbers(open.get("springs")),
            flow_scale: number(open.get("flow_scale")),
            planar: c_int::from(open.get("planar") == Some(&Value::Bool(true))),
        }
    }

    pub(crate) fn evaluate(&self, asked: &Asked<'_>) -> Answer {
        let before = asked.state.get("previous");
        let state = State {
            now: ["a", "b"].map(|name| Node::of(asked.state.get(name))),
            before: ["a", "b"].map(|name| Node::of(before.and_then(|before| before.get(name)))),
            values_before: numbers(before.and_then(|before| before.get("values"))),
        };
        let kept = before.and_then(|before| before.get("memory")).and_then(Value::as_array);
        let mut svars: Vec<f64> =
            (0..self.svars).map(|i| number(kept.and_then(|kept| kept.get(i)))).collect();
        let mut found = Box::new(Numbers::none());
        let code = self.call(&self.connector(), &state, asked.wants, &mut svars, &mut found);
        let mut answer = self.told(code, asked.wants, &found);
        if code == 0 && self.svars > 0 {
            answer.insert("memory".to_string(), svars.into_iter().map(written).collect());
        }
        answer
    }

    /// Answers to states as bytes, as bytes; in words where one of them is no plain numbers.
    ///
    /// # Errors
    /// The answers in words.
    pub(crate) fn answer(&self, wants: Option<&Value>, bytes: &[u8]) -> Result<Vec<u8>, Vec<Answer>> {
        let names: Vec<&str> =
            wants.and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str).collect();
        let (bits, connector) = (wants_of(wants), self.connector());
        let doubles = bytes.as_chunks().0.iter().map(|eight| f64::from_le_bytes(*eight));
        let states: Vec<f64> = doubles.collect();
        let (mut plain, mut answers) = (Some(Vec::new()), Vec::new());
        let mut found = Box::new(Numbers::none());
        for state in states.chunks_exact(State::SIZE) {
            *found = Numbers::none();
            let code = self.call(&connector, &State::of_numbers(state), bits, &mut [], &mut found);
            let append = |all: &mut Vec<f64>| {
                code == 0 && names.iter().all(|name| self.append(name, &found, &connector.kind, all))
            };
            if plain.as_mut().is_some_and(|all| !append(all)) {
                plain = None;
            }
            answers.push(plain.is_none().then(|| self.told(code, bits, &found)));
        }
        if let Some(all) = plain {
            return Ok(all.iter().flat_map(|x| x.to_le_bytes()).collect());
        }
        // Those before the first that is told in words are asked for once more.
        let told = answers.into_iter().zip(states.chunks_exact(State::SIZE)).map(|(answer, state)| {
            answer.unwrap_or_else(|| {
                *found = Numbers::none();
                let code = self.call(&connector, &State::of_numbers(state), bits, &mut [], &mut found);
                self.told(code, bits, &found)
            })
        });
        Err(told.collect())
    }

    /// An answer in words.
    fn told(&self, code: c_int, wants: u32, found: &Numbers) -> Answer {
        if code != 0 {
            return out_of_domain(format!("pintle_element returned {code}"));
        }
        let wanted = OFFERS.iter().filter(|(_, bit)| wants & bit != 0);
        wanted.map(|(name, _)| ((*name).to_string(), self.written(name, found))).collect()
    }

    /// Calls the routine; what it returns.
    fn call(
        &self,
        connector: &Connector,
        state: &State,
        wants: u32,
        svars: &mut [f64],
        found: &mut Numbers,
    ) -> c_int {
        #[expect(unsafe_code, reason = "the user's routine is called")]
        // SAFETY: the pointers are to live values of the types that the header declares, and the routine may write to svars (as many as it
        // said) and to the numbers alone. What it does besides ends this process, and no other.
        unsafe {
            (self.element)(connector, state, wants, svars.as_mut_ptr(), found)
        }
    }

    /// Appends what was written of a name. False where that is not all of the components that there are, or not finite.
    fn append(&self, name: &str, of: &Numbers, kind: &[c_int], all: &mut Vec<f64>) -> bool {
        let from = all.len();
        let (width, mut whole) = (self.width, false);
        let each = match name {
            "values" | "rates" | "accelerations" => 1,
            "rows" | "nodal_forces" | "element_forces" => width,
            _ => width * width,
        };
        let mut put = |row: &[f64]| all.extend_from_slice(row.get(..width.min(row.len())).unwrap_or(row));
        match name {
            "values" => put_all(&of.values, &mut put),
            "rates" => put_all(&of.rates, &mut put),
            "accelerations" => put_all(&of.accelerations, &mut put),
            "rows" => of.rows.iter().for_each(|row| put(row)),
            "nodal_forces" => of.nodal_forces.iter().for_each(|row| put(row)),
            "second_derivatives" => {
                of.second_derivatives
                    .iter()
                    .for_each(|matrix| matrix.iter().take(width).for_each(|row| put(row)));
            }
            "geometric_stiffness" => {
                of.geometric_stiffness
                    .iter()
                    .for_each(|matrix| matrix.iter().take(width).for_each(|row| put(row)));
            }
            "element_forces" => {
                whole = true;
                put(&of.element_forces);
            }
            _ => {
                whole = true;
                of.element_stiffness.iter().take(width).for_each(|row| put(row));
            }
        }
        let is_plain = |(k, line): (usize, &[f64])| {
            let is_there = whole || kind.get(k).is_some_and(|kind| *kind >= 0);
            line.iter().all(|x| if is_there { x.is_finite() } else { is_none(x) })
        };
        all.get(from..).is_some_and(|put| put.chunks(each.max(1)).enumerate().all(is_plain))
    }

    fn written(&self, name: &str, of: &Numbers) -> Value {
        let row = |of: &Row| row(of.get(..self.width).unwrap_or(of));
        let matrix = |matrix: &Matrix| {
            let lines = matrix.get(..self.width).unwrap_or(matrix);
            let lines: Vec<Value> = lines.iter().map(row).collect();
            if lines.iter().all(Value::is_null) { Value::Null } else { lines.into() }
        };
        match name {
            "values" => of.values.iter().map(scalar).collect(),
            "rates" => of.rates.iter().map(scalar).collect(),
            "accelerations" => of.accelerations.iter().map(scalar).collect(),
            "rows" => of.rows.iter().map(row).collect(),
            "nodal_forces" => of.nodal_forces.iter().map(row).collect(),
            "second_derivatives" => of.second_derivatives.iter().map(matrix).collect(),
            "geometric_stiffness" => of.geometric_stiffness.iter().map(matrix).collect(),
            "element_forces" => row(&of.element_forces),
            _ => matrix(&of.element_stiffness),
        }
    }
}
