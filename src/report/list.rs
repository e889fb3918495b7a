//! `pintle list`: the table of connection types, and that of multi-point constraints.

use crate::layout;
use crate::mpc::Listed;
use crate::words;
use pintle_kinematics::catalog::{
    Availability, COMPONENT, Class, ConnectionType, Evidence, OrientationRule, Slot, TABLE,
};
use serde::Serialize;
use std::io::{self, Write};

/// The version of the JSON form.
pub const SCHEMA: &str = "pintle-list/1";

/// One connection type in the JSON form.
#[derive(Debug, Serialize)]
struct Entry<'a> {
    name: &'a str,
    class: Class,
    made_of: Vec<&'static str>,
    constrained: Vec<&'static str>,
    available: Vec<&'static str>,
    output_only: Vec<&'static str>,
    orientation_at_a: OrientationRule,
    orientation_at_b: OrientationRule,
    two_dimensional: Availability,
    /// Components of the two-dimensional form, where there is one.
    in_plane: Option<InPlane>,
    three_dimensional: Availability,
}

/// The components of a two-dimensional form.
#[derive(Debug, Serialize)]
struct InPlane {
    constrained: Vec<&'static str>,
    available: Vec<&'static str>,
}

#[derive(Debug, Serialize)]
struct Document<'a> {
    schema: &'static str,
    version: &'static str,
    types: Vec<Entry<'a>>,
    mpcs: Vec<Listed>,
}

pub(super) fn names(connection: &ConnectionType, condition: impl Fn(Slot) -> bool) -> Vec<&'static str> {
    connection.components(condition).map(|k| COMPONENT[k]).collect()
}

pub(super) const fn is_measured(slot: Slot) -> bool {
    matches!(slot, Slot::Measured(_))
}

fn entry(connection: &ConnectionType) -> Entry<'_> {
    let [at_a, at_b] = connection.orientation;
    Entry {
        name: &connection.name,
        class: connection.class,
        made_of: words::made_of(connection),
        constrained: names(connection, Slot::is_constrained),
        available: names(connection, Slot::is_available),
        output_only: names(connection, is_measured),
        orientation_at_a: at_a,
        orientation_at_b: at_b,
        two_dimensional: connection.planar,
        in_plane: (connection.planar != Availability::Never).then(|| {
            let form = connection.in_plane();
            InPlane {
                constrained: names(&form, Slot::is_constrained),
                available: names(&form, Slot::is_available),
            }
        }),
        three_dimensional: connection.availability,
    }
}

/// Writes the catalogue as JSON.
///
/// # Errors
/// Those of the stream.
pub fn json(out: &mut dyn Write) -> io::Result<()> {
    let types = TABLE.iter().map(entry).collect();
    let document =
        Document { schema: SCHEMA, version: pintle_kinematics::VERSION, types, mpcs: Listed::all() };
    serde_json::to_writer_pretty(&mut *out, &document)?;
    writeln!(out)
}

/// Writes the catalogue as a table.
///
/// # Errors
/// Those of the stream.
pub fn human(out: &mut dyn Write, width: usize) -> io::Result<()> {
    let heading = ["type", "class", "constrained", "available", "or. a/b", "2D", "3D"];
    let rows: Vec<Vec<String>> = TABLE
        .iter()
        .map(|connection| {
            let Entry { constrained, available, output_only, .. } = entry(connection);
            let dash = |list: Vec<&str>| if list.is_empty() { "–".to_string() } else { list.join(" ") };
            let free = match (available.is_empty(), output_only.is_empty()) {
                (_, true) => dash(available),
                (true, false) => format!("({})", output_only.join(" ")),
                (false, false) => format!("{} ({})", available.join(" "), output_only.join(" ")),
            };
            let rules =
                connection.orientation.map(|rule| words::orientation_letter(rule.orientation)).join("/");
            let ours = connection.orientation.map(|rule| rule.evidence).into_iter();
            let ours = ours.filter(|evidence| matches!(evidence, Evidence::P | Evidence::R)).max();
            let rules = ours.map_or_else(|| rules.clone(), |evidence| format!("{rules} [{evidence:?}]"));
            vec![
                connection.name.to_string(),
                words::short_class(connection.class).to_string(),
                dash(constrained),
                free,
                rules,
                words::availability(connection.planar).to_string(),
                words::availability(connection.availability).to_string(),
            ]
        })
        .collect();
    write!(out, "{}", layout::table(&heading, &rows))?;
    let legend = "or. a/b: orientation at the nodes a and b, R required, O optional, I ignored, [P] read in part · (…): output only · \
                  2D, 3D: solvers for CONN2D2, of which only u1, u2 and ur3 remain, and CONN3D2 · any basic translational type pairs with any basic or \
                  specialised rotational type · `pintle explain TYPE` says more";
    writeln!(out)?;
    layout::paragraph(out, layout::DIM, 0, legend, width)?;
    write!(out, "\n{}", Listed::table())?;
    let legend = "MPC: multi-point constraints, S dependent, M independent, J nodes of hinges · `pintle explain MPC TYPE` says more";
    writeln!(out)?;
    layout::paragraph(out, layout::DIM, 0, legend, width)?;
    Ok(())
}
