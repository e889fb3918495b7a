//! An Abaqus user element of two nodes: RHS = −p, AMATRX = ∂p.

use crate::Options;
use crate::message::{Answer, Asked, number, numbers, out_of_domain, written};
use libloading::Library;
use serde_json::{Value, json};
use std::ffi::c_int;

/// The degrees of freedom of an element that does not say otherwise.
const COLUMNS: [&str; 12] =
    ["a.u1", "a.u2", "a.u3", "a.ur1", "a.ur2", "a.ur3", "b.u1", "b.u2", "b.u3", "b.ur1", "b.ur2", "b.ur3"];

/// SUBROUTINE UEL, by the names of its arguments; scalars by reference.
type Uel = unsafe extern "C" fn(
    rhs: *mut f64,
    amatrx: *mut f64,
    svars: *mut f64,
    energy: *mut f64,
    ndofel: *const c_int,
    nrhs: *const c_int,
    nsvars: *const c_int,
    props: *const f64,
    nprops: *const c_int,
    coords: *const f64,
    mcrd: *const c_int,
    nnode: *const c_int,
    u: *const f64,
    du: *const f64,
    v: *const f64,
    a: *const f64,
    jtype: *const c_int,
    time: *const f64,
    dtime: *const f64,
    kstep: *const c_int,
    kinc: *const c_int,
    jelem: *const c_int,
    params: *const f64,
    ndload: *const c_int,
    jdltyp: *const c_int,
    adlmag: *const f64,
    predef: *const f64,
    npredf: *const c_int,
    lflags: *const c_int,
    mlvarx: *const c_int,
    ddlmag: *const f64,
    mdload: *const c_int,
    pnewdt: *mut f64,
    jprops: *const c_int,
    njprop: *const c_int,
    period: *const f64,
);

/// A user element, and where it begins.
pub(crate) struct UserElement {
    uel: Uel,
    options: Options,
    /// COORDS(3, 2).
    coords: [f64; 6],
}

/// A length as Fortran has it.
fn count(length: usize) -> c_int {
    c_int::try_from(length).unwrap_or(c_int::MAX)
}

impl UserElement {
    /// The user element of a library, if it has one.
    ///
    /// # Errors
    /// In words, why it cannot be called so.
    pub(crate) fn of(library: &Library, options: &Options) -> Result<Option<Self>, String> {
        #[expect(unsafe_code, reason = "a function of the user's library")]
        // SAFETY: SUBROUTINE UEL has these arguments in every version; the library is never unloaded.
        let uel = unsafe { library.get::<Uel>(b"uel_\0").map(|uel| *uel) };
        let Ok(uel) = uel else { return Ok(None) };
        let mut options = options.clone();
        if options.columns.is_empty() {
            options.columns = COLUMNS.map(String::from).to_vec();
        }
        let unknown = |name: &&String| !COLUMNS.contains(&name.as_str());
        if let Some(name) = options.columns.iter().find(unknown) {
            return Err(format!(
                "a user element has no degree of freedom {name:?}; there are {}",
                COLUMNS.join(", ")
            ));
        }
        Ok(Some(Self { uel, options, coords: [0.0; 6] }))
    }

    pub(crate) fn hello(&self) -> Value {
        json!({
            "protocol": "pintle-candidate/1", "name": "UEL", "offers": ["element_forces", "element_stiffness"],
            "convention": { "columns": self.options.columns }, "memory": self.options.svars > 0,
        })
    }

    pub(crate) fn open(&mut self, open: &Value) -> Result<(), String> {
        let [a, b] = ["a", "b"].map(|node| numbers::<3>(open.pointer(&format!("/initial/{node}/x"))));
        self.coords = std::array::from_fn(|i| if i < 3 { a[i] } else { b[i - 3] });
        Ok(())
    }

    /// What a state has of each degree of freedom, translations and rotations by those keys.
    fn by_columns(&self, state: Option<&Value>, keys: [&str; 2]) -> Vec<f64> {
        let of = |name: &String| {
            let (node, dof) = name.split_once('.')?;
            let axis = dof.chars().last()?.to_digit(10)?.checked_sub(1)?;
            let key = if dof.starts_with("ur") { keys[1] } else { keys[0] };
            state?.get(node)?.get(key)?.get(axis as usize)
        };
        self.options.columns.iter().map(|name| number(of(name))).collect()
    }

    pub(crate) fn evaluate(&self, asked: &Asked<'_>) -> Answer {
        const TOTAL: [&str; 2] = ["u", "rotation_vector"];
        let Options { properties, svars, columns, .. } = &self.options;
        let width = columns.len();
        let u = self.by_columns(Some(asked.state), TOTAL);
        let before = asked.state.get("previous");
        let du: Vec<f64> = u.iter().zip(self.by_columns(before, TOTAL)).map(|(u, v)| u - v).collect();
        let v = self.by_columns(Some(asked.state), ["velocity", "angular_velocity"]);
        let a = self.by_columns(Some(asked.state), ["acceleration", "angular_acceleration"]);
        let kept = before.and_then(|before| before.get("memory")).and_then(Value::as_array);
        // Fortran may be given no array of length 0.
        let mut state: Vec<f64> =
            (0..(*svars).max(1)).map(|i| number(kept.and_then(|kept| kept.get(i)))).collect();
        let padded = |x: &[f64]| if x.is_empty() { vec![0.0] } else { x.to_vec() };
        let (props, none) = (padded(properties), [0.0; 8]);
        let (mut rhs, mut amatrx) = (vec![0.0; width], vec![0.0; width * width]);
        let mut energy = [0.0; 8];
        let mut pnewdt = 1.0;
        let [ndofel, nsvars, nprops] = [width, *svars, properties.len()].map(count);
        // Static, large displacements, RHS and AMATRX, no perturbation.
        let lflags: [c_int; 7] = [1, 1, 1, 0, 0, 0, 0];
        let [zero, one, two, three]: [c_int; 4] = [0, 1, 2, 3];
        let (time, dtime, period) = ([1.0, 1.0], 1.0, 1.0);
        #[expect(unsafe_code, reason = "the user's subroutine is called")]
        // SAFETY: every array has the length that its count says, and lives until the call ends; the subroutine may write to RHS, AMATRX, SVARS,
        // ENERGY and PNEWDT. What it does besides ends this process, and no other.
        unsafe {
            (self.uel)(
                rhs.as_mut_ptr(),
                amatrx.as_mut_ptr(),
                state.as_mut_ptr(),
                energy.as_mut_ptr(),
                &raw const ndofel,
                &raw const one,
                &raw const nsvars,
                props.as_ptr(),
                &raw const nprops,
                self.coords.as_ptr(),
                &raw const three,
                &raw const two,
                u.as_ptr(),
                du.as_ptr(),
                v.as_ptr(),
                a.as_ptr(),
                &raw const one,
                time.as_ptr(),
                &raw const dtime,
                &raw const one,
                &raw const one,
                &raw const one,
                none.as_ptr(),
                &raw const zero,
                &raw const zero,
                none.as_ptr(),
                none.as_ptr(),
                &raw const zero,
                lflags.as_ptr(),
                &raw const ndofel,
                none.as_ptr(),
                &raw const zero,
                &raw mut pnewdt,
                &raw const zero,
                &raw const zero,
                &raw const period,
            );
        }
        if pnewdt < 1.0 {
            return out_of_domain(format!("UEL asks for a smaller increment: PNEWDT = {pnewdt}"));
        }
        let forces: Vec<Value> = rhs.iter().map(|x| written(-x)).collect();
        let lines = (0..width).map(|i| (0..width).map(|j| written(amatrx[j * width + i])).collect::<Value>());
        let mut answer: Answer = [
            ("element_forces".to_string(), forces.into()),
            ("element_stiffness".to_string(), lines.collect()),
        ]
        .into_iter()
        .collect();
        if *svars > 0 {
            answer.insert("memory".to_string(), state.into_iter().map(written).collect());
        }
        answer
    }
}
