//! pintle for C and Fortran: a connector's values, rows, rates and second derivatives, through `pintle.h` and `pintle.f90`.
//!
//! Each function checks its pointers for null. What they point to is trusted to be as the header declares it.

use pintle::check::Subject;
use pintle_audit::Step;
use pintle_kinematics::connector::{
    Branch, Connector, Definition, Evaluation, Output, Request, State, Tally,
};
use pintle_kinematics::node::{DOFS, Node, Pair};
use pintle_kinematics::vector::{add, sub, transpose};
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char, c_int};

const COMPONENTS: usize = 6;

/// A connector, with the history that was committed.
#[derive(Debug)]
pub struct Handle {
    definition: Definition,
    connector: Connector<f64>,
    branch: Branch<f64>,
    before: Pair<f64>,
}

/// Two nodes, as `pintle_pair`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct PairOfC {
    /// Positions.
    pub x: [[f64; 3]; 2],
    /// e1, e2, e3 of each node.
    pub triad: [[[f64; 3]; 3]; 2],
    /// Material flow.
    pub flow: [f64; 2],
    /// By columns.
    pub velocity: [f64; DOFS],
    /// By columns.
    pub acceleration: [f64; DOFS],
}

thread_local! {
    static ERROR: RefCell<CString> = RefCell::default();
}

fn fail(why: String) {
    let why = CString::new(why.replace('\0', " ")).unwrap_or_default();
    ERROR.with(|error| *error.borrow_mut() = why);
}

/// 0, or 1 with what is wrong.
fn code(done: Result<(), String>) -> c_int {
    match done {
        Ok(()) => 0,
        Err(why) => {
            fail(why);
            1
        }
    }
}

impl Handle {
    fn open(name: &str) -> Result<Self, String> {
        let Subject::Connector(definition, _) = pintle::check::subject(name, None)? else {
            return Err(format!("{name} is no connector"));
        };
        let connector = Connector::new(&definition);
        let branch = connector.initial_branch();
        Ok(Self { before: definition.initial, definition: *definition, connector, branch })
    }

    fn pair(&self, of: &PairOfC) -> Result<(Pair<f64>, State<f64>), String> {
        let numbers = of.x.iter().chain(of.triad.iter().flatten()).flatten().chain(&of.flow);
        if let Some(x) = numbers.chain(&of.velocity).chain(&of.acceleration).find(|x| !x.is_finite()) {
            return Err(format!("{x} is among the numbers of the pair"));
        }
        // A scene's node a may stand anywhere: only x_b − x_a counts, and the initial place of a is the origin.
        let initial = &self.definition.initial;
        let node = |end: usize, displacement| Node {
            displacement,
            triad: transpose(&of.triad[end]),
            flow: of.flow[end],
        };
        let [a, b] = of.x;
        let pair =
            Pair { reference: initial.reference, a: node(0, a), b: node(1, sub(b, initial.reference)) };
        Ok((pair, State { pair, velocity: of.velocity, acceleration: of.acceleration }))
    }

    fn evaluation(&self, of: &PairOfC, request: &Request) -> Result<Evaluation<f64>, String> {
        let (pair, state) = self.pair(of)?;
        let increment = Step::between(&self.before, pair).increment;
        Ok(self.connector.evaluate(&state, &increment, &self.branch, request, &mut Tally::default()))
    }
}

fn values(found: &Evaluation<f64>) -> [f64; COMPONENTS] {
    std::array::from_fn(|k| found.residual[k].or(found.displacement[k]).unwrap_or(f64::NAN))
}

/// The text of a C string.
///
/// # Safety
/// `text` is null or a string that ends in zero.
#[expect(unsafe_code, reason = "a string of the caller's")]
unsafe fn text<'a>(text: *const c_char) -> Result<&'a str, String> {
    if text.is_null() {
        return Err("the name is NULL".into());
    }
    // SAFETY: it is not null, and the caller says that it ends in zero.
    unsafe { CStr::from_ptr(text) }.to_str().map_err(|_| "the name is no UTF-8".to_string())
}

/// What a pointer of the caller's points to.
///
/// # Safety
/// It is null, or points to a live value that nobody writes to.
#[expect(unsafe_code, reason = "a pointer of the caller's")]
unsafe fn read<'a, T>(pointer: *const T, name: &str) -> Result<&'a T, String> {
    // SAFETY: the caller says that it is null or valid.
    unsafe { pointer.as_ref() }.ok_or_else(|| format!("{name} is NULL"))
}

/// The same, to be written to.
///
/// # Safety
/// It is null, or points to a live value that nobody else reads or writes.
#[expect(unsafe_code, reason = "a pointer of the caller's")]
unsafe fn write<'a, T>(pointer: *mut T, name: &str) -> Result<&'a mut T, String> {
    // SAFETY: the caller says that it is null or valid.
    unsafe { pointer.as_mut() }.ok_or_else(|| format!("{name} is NULL"))
}

/// The version.
#[expect(unsafe_code, reason = "the symbol is called from C")]
#[unsafe(no_mangle)]
pub const extern "C" fn pintle_version() -> *const c_char {
    const VERSION: &[u8] = concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes();
    VERSION.as_ptr().cast()
}

/// What was wrong in the last call of this thread that failed.
#[expect(unsafe_code, reason = "the symbol is called from C")]
#[unsafe(no_mangle)]
pub extern "C" fn pintle_error() -> *const c_char {
    ERROR.with(|error| error.borrow().as_ptr())
}

/// Opens a connector; null where there is none.
///
/// # Safety
/// `name` is null or a string that ends in zero.
#[expect(unsafe_code, reason = "the symbol is called from C, with a string")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pintle_open(name: *const c_char) -> *mut Handle {
    // SAFETY: as declared.
    match unsafe { text(name) }.and_then(Handle::open) {
        Ok(handle) => Box::into_raw(Box::new(handle)),
        Err(why) => {
            fail(why);
            std::ptr::null_mut()
        }
    }
}

/// Ends what was opened.
///
/// # Safety
/// `connector` is null, or from [`pintle_open`] and not closed before.
#[expect(unsafe_code, reason = "the symbol is called from C, with a handle")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pintle_close(connector: *mut Handle) {
    if !connector.is_null() {
        // SAFETY: it is from Box::into_raw in pintle_open, and is given back once.
        drop(unsafe { Box::from_raw(connector) });
    }
}

/// The initial state.
///
/// # Safety
/// Pointers are null, or valid as the header declares them.
#[expect(unsafe_code, reason = "the symbol is called from C, with pointers")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pintle_initial(connector: *const Handle, pair: *mut PairOfC) -> c_int {
    // SAFETY: as declared.
    let (connector, pair) = unsafe { (read(connector, "the connector"), write(pair, "pair")) };
    code(connector.and_then(|of| {
        let initial = &of.definition.initial;
        *pair? = PairOfC {
            x: [initial.a.displacement, add(initial.reference, initial.b.displacement)],
            triad: [transpose(&initial.a.triad), transpose(&initial.b.triad)],
            flow: [initial.a.flow, initial.b.flow],
            velocity: [0.0; DOFS],
            acceleration: [0.0; DOFS],
        };
        Ok(())
    }))
}

/// Of each component: 1 constrained, 0 free, −1 none.
///
/// # Safety
/// Pointers are null, or valid as the header declares them.
#[expect(unsafe_code, reason = "the symbol is called from C, with pointers")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pintle_kinds(connector: *const Handle, kinds: *mut [c_int; COMPONENTS]) -> c_int {
    // SAFETY: as declared.
    let (connector, kinds) = unsafe { (read(connector, "the connector"), write(kinds, "kinds")) };
    code(connector.and_then(|of| {
        let kind = |k: usize| match of.connector.differentiated(k) {
            Some(_) => c_int::from(of.connector.is_constrained(k)),
            None => -1,
        };
        *kinds? = std::array::from_fn(kind);
        Ok(())
    }))
}

/// Values and rows.
///
/// # Safety
/// Pointers are null, or valid as the header declares them.
#[expect(unsafe_code, reason = "the symbol is called from C, with pointers")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pintle_evaluate(
    connector: *const Handle,
    pair: *const PairOfC,
    into: *mut [f64; COMPONENTS],
    rows: *mut [[f64; DOFS]; COMPONENTS],
) -> c_int {
    // SAFETY: as declared.
    let (connector, pair, into, rows) = unsafe {
        (read(connector, "the connector"), read(pair, "pair"), write(into, "values"), rows.as_mut())
    };
    code(connector.and_then(|of| {
        let request = Request::new(&[Output::CU, Output::RES], [true; 6], u8::from(rows.is_some()));
        let found = of.evaluation(pair?, &request)?;
        *into? = values(&found);
        if let Some(rows) = rows {
            *rows = std::array::from_fn(|k| found.jacobian[k].unwrap_or([f64::NAN; DOFS]));
        }
        Ok(())
    }))
}

/// First and second time derivatives.
///
/// # Safety
/// Pointers are null, or valid as the header declares them.
#[expect(unsafe_code, reason = "the symbol is called from C, with pointers")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pintle_rates(
    connector: *const Handle,
    pair: *const PairOfC,
    rates: *mut [f64; COMPONENTS],
    accelerations: *mut [f64; COMPONENTS],
) -> c_int {
    // SAFETY: as declared.
    let (connector, pair, rates, accelerations) = unsafe {
        (
            read(connector, "the connector"),
            read(pair, "pair"),
            write(rates, "rates"),
            write(accelerations, "accelerations"),
        )
    };
    code(connector.and_then(|of| {
        let outputs = [Output::CV, Output::CA, Output::RESV, Output::RESA];
        let found = of.evaluation(pair?, &Request::new(&outputs, [true; 6], 0))?;
        let all = |residual: &[Option<f64>; COMPONENTS], free: &[Option<f64>; COMPONENTS]| {
            std::array::from_fn(|k| residual[k].or(free[k]).unwrap_or(f64::NAN))
        };
        *rates? = all(&found.residual_rate, &found.velocity);
        *accelerations? = all(&found.residual_acceleration, &found.acceleration);
        Ok(())
    }))
}

/// Second derivatives.
///
/// # Safety
/// Pointers are null, or valid as the header declares them.
#[expect(unsafe_code, reason = "the symbol is called from C, with pointers")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pintle_second_derivatives(
    connector: *const Handle,
    pair: *const PairOfC,
    second: *mut [[[f64; DOFS]; DOFS]; COMPONENTS],
) -> c_int {
    // SAFETY: as declared.
    let (connector, pair, second) =
        unsafe { (read(connector, "the connector"), read(pair, "pair"), write(second, "second")) };
    code(connector.and_then(|of| {
        let found = of.evaluation(pair?, &Request::nothing(2))?;
        let second = second?;
        for (into, found) in second.iter_mut().zip(&found.hessian) {
            *into = found.as_deref().copied().unwrap_or([[f64::NAN; DOFS]; DOFS]);
        }
        Ok(())
    }))
}

/// Commits a state.
///
/// # Safety
/// Pointers are null, or valid as the header declares them.
#[expect(unsafe_code, reason = "the symbol is called from C, with pointers")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pintle_commit(connector: *mut Handle, pair: *const PairOfC) -> c_int {
    // SAFETY: as declared.
    let (connector, pair) = unsafe { (write(connector, "the connector"), read(pair, "pair")) };
    code(connector.and_then(|of| {
        let (pair, state) = of.pair(pair?)?;
        let increment = Step::between(&of.before, pair).increment;
        of.branch = of.connector.advance(&state, &increment, &of.branch);
        of.before = pair;
        Ok(())
    }))
}

/// Back to the initial state.
///
/// # Safety
/// `connector` is null or a handle.
#[expect(unsafe_code, reason = "the symbol is called from C, with a handle")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pintle_reset(connector: *mut Handle) -> c_int {
    // SAFETY: as declared.
    let connector = unsafe { write(connector, "the connector") };
    code(connector.map(|of| {
        of.branch = of.connector.initial_branch();
        of.before = of.definition.initial;
    }))
}
