//! Connector sections and multi-point constraints.

use crate::deck::Deck;
use crate::deck::lookup::target;
use crate::deck::table::LINE_FOLLOWS;
use crate::diagnostic::{Code, Diagnostic, Result, nearest};
use crate::label::normal;
use crate::lexer::{Data, Item, Keyword};
use crate::model::{ConnectorSection, MpcKind, Target};
use crate::span::{Span, Spanned};
use pintle_kinematics::mpc;

pub(super) fn section(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let element_set = keyword.need_name("ELSET")?;
    let behavior = keyword.name_of("BEHAVIOR")?;
    let controls = keyword.name_of("CONTROLS")?;
    let elimination = keyword.word("ELIMINATION", &["NO", "YES"])?.map(|choice| choice == "YES");
    let type_names = match deck.lexer.data()? {
        Some(line) => type_names(&line)?,
        None => {
            let message = keyword.words().map(|keyword| format!("{keyword} has no connection type"));
            return Err(Diagnostic::error(Code::MissingData, keyword.span, message, LINE_FOLLOWS)
                .help("give one or two connection types, such as HINGE or SLOT, REVOLUTE"));
        }
    };
    let [mut orientation_a, mut orientation_b] = [None, None];
    if let Some(line) = deck.lexer.data()? {
        let mut items = line.items();
        orientation_a = items.maybe().map(|item| orientation(&item)).transpose()?;
        orientation_b = items.maybe().map(|item| orientation(&item)).transpose()?;
        items.end("the orientation at the first and at the second node")?;
    }
    let mut section_data = Vec::new();
    if let Some(line) = deck.lexer.data()? {
        let mut items = line.items();
        for item in items.by_ref().take(2) {
            section_data.push(if item.text.is_empty() { None } else { Some(item.number()?) });
        }
        items.end("at most two numbers of section data")?;
    }
    deck.scene.connector_sections.push(ConnectorSection {
        element_set,
        behavior,
        type_names,
        orientation_a,
        orientation_b,
        section_data,
        controls,
        elimination,
        span: keyword.span,
    });
    Ok(())
}

fn type_names(line: &Data<'_>) -> Result<Vec<Spanned<String>>> {
    let mut items = line.items();
    let mut names = vec![items.need("the connection type")?.name()?];
    if let Some(item) = items.maybe() {
        names.push(item.name()?);
    }
    items.end("one connection type, or a translational and a rotational one")?;
    for name in &mut names {
        name.value = normal(&name.value);
    }
    Ok(names)
}

fn orientation(item: &Item<'_>) -> Result<Spanned<String>> {
    if item.looks_numeric() && !item.is_integer() {
        let message = format!("expected an orientation, but found the number {}", item.text);
        return Err(Diagnostic::error(Code::UnknownOrientation, item.span, message, "not a name").help(
            "the second line names orientations; leave it blank when section data follow without orientations",
        ));
    }
    item.name()
}

/// A line of `*MPC`, with sets for nodes.
#[derive(Debug, Clone)]
pub(super) struct RawMpc {
    pub(super) kind: MpcKind,
    pub(super) items: Vec<Spanned<Target>>,
    pub(super) span: Span,
}

/// The longest name that a type may have, in bytes.
const LONGEST_NAME: usize = 80;

/// Types of the documentation that are kept but not evaluated.
const KEPT: &[&str] = &[
    "BILINEAR",
    "C BIQUAD",
    "CYCLSYM",
    "DIST",
    "ELBOW",
    "LINEAR",
    "MEANROT",
    "P BILINEAR",
    "P LINEAR",
    "PLANE",
    "QUADRATIC",
    "SLIDER",
    "SS BILINEAR",
    "SS LINEAR",
    "SSF BILINEAR",
    "STRAIGHT",
    "T BIQUAD",
    "T LINEAR",
    "V LOCAL",
];

pub(super) fn mpc(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let user = keyword.has("USER");
    let mut warnings: Vec<Diagnostic> = Vec::new();
    while let Some(line) = deck.lexer.row()? {
        let mut items = line.items();
        let first = items.need("the type of the constraint")?;
        let mut nodes = Vec::new();
        for item in items.filter(|item| !item.text.is_empty()) {
            nodes.push(target(&item, "the node number")?);
        }
        if first.text == "0" && !user {
            match deck.mpcs.last_mut() {
                Some(mpc) => mpc.items.extend(nodes),
                None => {
                    let message = "a line that continues no constraint";
                    return Err(Diagnostic::error(
                        Code::UnknownMpc,
                        first.span,
                        message,
                        "0 continues the line above",
                    )
                    .help("begin with the type of the constraint, such as PIN or REVOLUTE"));
                }
            }
            continue;
        }
        let name = normal(first.text);
        let known = mpc::MpcType::named(&name).filter(|_| !user);
        let kind = match known {
            Some(kind) => MpcKind::Evaluated(kind),
            None if user => MpcKind::Other(format!("USER {name}")),
            None if KEPT.contains(&name.as_str()) => MpcKind::Other(name),
            None => {
                // What looks like no type of ours is one of another program.
                let names = mpc::TABLE.iter().map(|entry| entry.name).chain(KEPT.iter().copied());
                let is_word = name.starts_with(|letter: char| letter.is_ascii_alphabetic())
                    && name.len() <= LONGEST_NAME;
                match nearest(&name, names) {
                    None if is_word => MpcKind::Other(name),
                    near => {
                        let remedy = near.map_or_else(
                            || format!("types are {}", mpc::TABLE.map(|entry| entry.name).join(", ")),
                            |near| format!("did you mean {near}?"),
                        );
                        let message = format!("there is no constraint type {name}");
                        return Err(Diagnostic::error(Code::UnknownMpc, first.span, message, "not a type")
                            .help(remedy));
                    }
                }
            }
        };
        if let MpcKind::Other(name) = &kind {
            let message = format!("the multi-point constraint {name} is kept but not evaluated");
            warnings.push(
                Diagnostic::warning(Code::MpcNotEvaluated, line.span, message, "not evaluated").help(
                    format!("types that are evaluated: {}", mpc::TABLE.map(|entry| entry.name).join(", ")),
                ),
            );
        }
        deck.mpcs.push(RawMpc { kind, items: nodes, span: line.span });
    }
    warnings.into_iter().for_each(|warning| deck.warn(warning));
    Ok(())
}
