//! Outputs by name, as decks and the command line write them.
//!
//! CP, CU, CCU, CV, CA and CASU name all components; with R (CPR, CUR …) the rotations; with a digit 1 to 3 one of them (CU1 is u1,
//! CUR1 is ur1). CTF, CEF, CVF, CSF, CRF, CCF and CNF name all components; CTF1 to CTF3 are forces, CTM the moments, CTM1 to CTM3 one of
//! them. CSLST, CIVC, SLIP, CFAILST, DRIVEN, TANGENT, RES, RESV, RESB, RESA, TURNS, MARGIN, PM, LM, NF, KG, DNF, KT, CT and KR name all components, with a digit 1 to 6 one: NF4 is the nodal forces of m1. ALL
//! is every output, NONE is no output (derivatives only).

use pintle_kinematics::connector::{Mask, Output, Request};

/// A name that is no output.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OutputError {
    /// A known output of connectors that rests on behaviour.
    #[error(
        "{name} is a force, or follows from behaviour, which is not evaluated yet; evaluated are {known}"
    )]
    NotEvaluated {
        /// What was asked for.
        name: String,
        /// What there is.
        known: String,
    },
    /// A component that the output does not have.
    #[error("there is no {name}; {remedy}")]
    Component {
        /// What was asked for.
        name: String,
        /// What to write instead.
        remedy: String,
    },
    /// Anything else.
    #[error("there is no output {name:?}; {remedy}")]
    Unknown {
        /// What was asked for.
        name: String,
        /// What to write instead.
        remedy: String,
    },
}

/// The outputs of the manual that need forces or behaviour.
const OF_BEHAVIOR: [&str; 9] = ["CUF", "CUM", "CUE", "CUP", "CALPHA", "CDMG", "CDIF", "CDIM", "CDIP"];

/// The outputs of a list of names, with derivatives up to `order`.
///
/// ```
/// use pintle_kinematics::connector::Output;
/// use pintle_model::evaluate::request;
/// let request = request(["cu1", "CPR", "CSLST4"], 0).unwrap();
/// assert!(request.wants(Output::CU, 0) && !request.wants(Output::CU, 3));
/// assert!(request.wants(Output::CP, 3) && !request.wants(Output::CP, 0));
/// assert!(request.wants(Output::CSLST, 3));
/// ```
///
/// # Errors
/// The first name that is no output, with a remedy.
pub fn request<'a>(names: impl IntoIterator<Item = &'a str>, order: u8) -> Result<Request, OutputError> {
    let mut request = Request::nothing(order);
    for name in names {
        let upper = name.trim().to_ascii_uppercase();
        match upper.as_str() {
            "ALL" => request = Request::everything(order),
            "NONE" => request.add_rows([true; 6]),
            _ => {
                let (output, components) = one(&upper)?;
                request.add(output, components);
            }
        }
    }
    Ok(request)
}

fn one(name: &str) -> Result<(Output, Mask), OutputError> {
    let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let digits = &name[stem.len()..];
    let exact = Output::ALL.into_iter().find(|output| output.name() == stem);
    let rotational = stem.strip_suffix('R').and_then(|stem| {
        Output::ALL.into_iter().find(|output| output.name() == stem && output.is_kinematic())
    });
    let moment = stem.strip_suffix('M').and_then(|stem| {
        Output::ALL
            .into_iter()
            .find(|output| output.is_force() && output.name().strip_suffix('F') == Some(stem))
    });
    let component = |remedy: String| OutputError::Component { name: name.to_string(), remedy };
    let one_of = |range: std::ops::Range<usize>, remedy: &dyn Fn() -> String| match digits.parse::<usize>() {
        _ if digits.is_empty() => Ok([0, 1, 2, 3, 4, 5].map(|k| range.contains(&k))),
        Ok(digit @ 1..) if range.start + digit <= range.end => {
            Ok([0, 1, 2, 3, 4, 5].map(|k| k == range.start + digit - 1))
        }
        _ => Err(component(remedy())),
    };
    match (exact, rotational) {
        (Some(output), _) if output.is_kinematic() && !digits.is_empty() => {
            let remedy = || format!("{stem}1 to {stem}3 are translations, {stem}R1 to {stem}R3 rotations");
            Ok((output, one_of(0..3, &remedy)?))
        }
        (Some(output), _) if output.is_force() && !digits.is_empty() => {
            let moments = output.name().replace('F', "M");
            let remedy = || format!("{stem}1 to {stem}3 are forces, {moments}1 to {moments}3 moments");
            Ok((output, one_of(0..3, &remedy)?))
        }
        (Some(output), _) => {
            Ok((output, one_of(0..6, &|| format!("{stem}1 to {stem}6 are the components"))?))
        }
        (None, Some(output)) => {
            Ok((output, one_of(3..6, &|| format!("{stem}1 to {stem}3 are the rotations"))?))
        }
        (None, None) => match moment {
            Some(output) => Ok((output, one_of(3..6, &|| format!("{stem}1 to {stem}3 are the moments"))?)),
            None => Err(unknown(name)),
        },
    }
}

fn unknown(name: &str) -> OutputError {
    let names: Vec<&str> = Output::ALL.iter().map(|output| output.name()).collect();
    let known = names.join(", ");
    let name = name.to_string();
    if OF_BEHAVIOR.iter().any(|stem| name.starts_with(stem)) {
        return OutputError::NotEvaluated { name, known };
    }
    let near = names
        .iter()
        .map(|known| (strsim::damerau_levenshtein(known, &name), known))
        .filter(|(distance, known)| *distance == 1 || *distance < known.len() / 2)
        .min_by_key(|(distance, _)| *distance);
    let remedy = match near {
        Some((_, near)) if !name.is_empty() => format!("did you mean {near}?"),
        _ => format!("outputs are {known}, ALL, NONE"),
    };
    OutputError::Unknown { name, remedy }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mask(name: &str) -> String {
        let (_, mask) = one(name).unwrap();
        mask.map(|wanted| if wanted { '1' } else { '0' }).into_iter().collect()
    }

    #[test]
    fn names_select_components() {
        for (name, expected) in [
            ("CU", "111111"),
            ("CUR", "000111"),
            ("CU1", "100000"),
            ("CUR3", "000001"),
            ("CAR2", "000010"),
            ("CCU3", "001000"),
            ("RES", "111111"),
            ("RES6", "000001"),
            ("CSLST4", "000100"),
            ("CTF", "111111"),
            ("CTF2", "010000"),
            ("CTM", "000111"),
            ("CRM3", "000001"),
            ("CFAILST6", "000001"),
            ("NF4", "000100"),
            ("PM", "111111"),
        ] {
            assert_eq!(mask(name), expected, "{name}");
        }
    }

    #[test]
    fn what_is_no_output_says_what_is() {
        for (name, part) in [
            ("CU4", "CUR1 to CUR3 rotations"),
            ("CUR0", "CUR1 to CUR3 are the rotations"),
            ("CSLST7", "CSLST1 to CSLST6"),
            ("CUF1", "not evaluated yet"),
            ("CTF4", "CTM1 to CTM3 moments"),
            ("CEM0", "CEM1 to CEM3 are the moments"),
            ("CUEL", "not evaluated yet"),
            ("TRUNS", "did you mean TURNS?"),
            ("CX", "did you mean C"),
            ("", "outputs are CP"),
            ("RESR", "did you mean RES"),
        ] {
            let message = one(name).unwrap_err().to_string();
            assert!(message.contains(part), "{name}: {message}");
        }
    }
}
