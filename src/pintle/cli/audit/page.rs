//! The page of `pintle audit --html`, and its figures as files.

use super::{Audit, AuditFormat};
use crate::cli::{Failure, Files};
use pintle_audit::singular::atlas::atlas;
use pintle_audit::{Approach, Illustration, Report, Target, illustrate_catalogue, illustrate_scene};
use pintle_kinematics::catalog::ConnectionType;
use pintle_report::audit as report;
use pintle_report::audit::{Audited, Supplement};
use std::collections::BTreeMap;
use std::io::{self, BufWriter, Write};
use std::sync::Arc;

/// Connectors of a scene whose Jacobians are shown at most, those that did not pass first.
const SHOWN: usize = 48;

/// What the page shows besides the report; `scenes` are all that were asked for, those refused too.
pub(super) fn supplement<'a>(
    found: &Report,
    is_catalogue: bool,
    targets: &[Target<'a>],
    scenes: Vec<Audited<'a>>,
    model_only: bool,
) -> Supplement<'a> {
    let mut illustrations: Vec<Illustration> = Vec::new();
    if is_catalogue {
        illustrations.extend(illustrate_catalogue(found));
    } else if !model_only {
        illustrations.extend(targets.iter().flat_map(|target| illustrate_scene(target, found, SHOWN)));
    }
    let approaches = if is_catalogue { Vec::new() } else { approached(targets) };
    Supplement { catalogue: is_catalogue, scenes, illustrations, approaches, command: command_line() }
}

/// The singular sets of the types of scenes, each type once.
fn approached(targets: &[Target<'_>]) -> Vec<Approach> {
    let mut types: BTreeMap<String, Arc<ConnectionType>> = BTreeMap::new();
    for target in targets {
        for index in &target.plan.connectors {
            let connection = &target.model.connectors[*index].definition().connection;
            types.entry(connection.name.to_string()).or_insert_with(|| Arc::clone(connection));
        }
    }
    types.values().flat_map(|connection| atlas(connection)).collect()
}

/// What was typed, with the name of the program instead of its place.
fn command_line() -> String {
    let arguments = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned());
    std::iter::once("pintle".to_string()).chain(arguments).collect::<Vec<_>>().join(" ")
}

/// Writes the page and the figures that are asked for.
pub(super) fn write(
    arguments: &Audit,
    found: &Report,
    supplement: &Supplement<'_>,
    files: Files,
) -> Result<(), Failure> {
    if matches!(arguments.format, AuditFormat::Html) {
        let mut out = BufWriter::new(io::stdout().lock());
        report::html(&mut out, found, supplement)?;
        out.flush()?;
    }
    if let Some(path) = &arguments.html {
        files.write(path, |out| report::html(out, found, supplement))?;
    }
    if let Some(folder) = &arguments.plots {
        files.folder(folder)?;
        for (name, svg) in report::figures(found, supplement) {
            files.text(&folder.join(name), svg)?;
        }
    }
    Ok(())
}
