//! A Python function behind the protocol: a driver that Python runs from its command line.

/// The driver, which imports nothing but the standard library, and NumPy where it is there. As a module it has the class `Routine`.
pub const DRIVER: &str = include_str!("driver.py");

/// The command that asks a function `module:function` by a Python, given as words for a shell, in the current folder.
///
/// # Errors
/// In words, where the name is none.
pub fn command(python: &str, routine: &str) -> Result<String, String> {
    let is_name = |name: &str| {
        !name.is_empty()
            && name
                .split('.')
                .all(|part| !part.is_empty() && part.chars().all(|c| c.is_alphanumeric() || c == '_'))
    };
    match routine.split_once(':') {
        Some((module, function)) if is_name(module) && is_name(function) => {
            Ok(format!("exec {python} -c '{DRIVER}' {module} {function}"))
        }
        _ => Err(format!("{routine:?} is not MODULE:FUNCTION, as my_elements.revolute:evaluate")),
    }
}
