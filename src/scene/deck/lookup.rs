//! What a deck names: nodes, sets, orientations, looked up where they are used.

use crate::deck::sets::{Kind, unknown_set};
use crate::diagnostic::{Code, Diagnostic, Result, suggest_scoped};
use crate::label::Label;
use crate::lexer::Item;
use crate::model::{Scene, Set, Target};
use crate::span::{Span, Spanned};
use crate::wording::definition;

/// A number or a set.
pub(super) fn target(item: &Item<'_>, what: &str) -> Result<Spanned<Target>> {
    let target =
        if item.is_label() { Target::Label(item.label(what)?) } else { Target::Set(item.name()?.value) };
    Ok(Spanned::new(target, item.span))
}

pub(super) fn element_set<'a>(scene: &'a Scene, name: &Spanned<String>) -> Result<&'a Set> {
    let names = || scene.element_sets.keys().map(String::as_str);
    scene.element_sets.get(&name.value).ok_or_else(|| unknown_set(Kind::Element, name, names()))
}

pub(super) fn check_name<T>(
    name: Option<&Spanned<String>>,
    known: &indexmap::IndexMap<String, T>,
    what: &str,
    keyword: &str,
    code: Code,
) -> Result<()> {
    let Some(name) = name.filter(|name| !known.contains_key(&name.value)) else { return Ok(()) };
    let message = format!("there is no {what} {}", name.value);
    let remedy = suggest_scoped(&name.value, known.keys().map(String::as_str), || {
        definition(keyword, "NAME", &name.value)
    });
    Err(Diagnostic::error(code, name.span, message, "not defined").help(remedy))
}

pub(super) fn check_orientation(scene: &Scene, name: Option<&Spanned<String>>) -> Result<()> {
    check_name(name, &scene.orientations, "orientation", "ORIENTATION", Code::UnknownOrientation)
}

pub(super) fn node_set<'a>(scene: &'a Scene, name: &Spanned<String>) -> Result<&'a Set> {
    let names = || scene.node_sets.keys().map(String::as_str);
    scene.node_sets.get(&name.value).ok_or_else(|| unknown_set(Kind::Node, name, names()))
}

pub(super) fn node_target(scene: &Scene, target: &Spanned<Target>) -> Result<Vec<Label>> {
    match &target.value {
        Target::Label(label) if scene.nodes.contains_key(label) => Ok(vec![*label]),
        Target::Label(label) => Err(unknown(Kind::Node, *label, target.span)),
        Target::Set(name) => {
            Ok(complete_node_set(scene, &Spanned::new(name.clone(), target.span))?.labels.clone())
        }
    }
}

pub(super) fn unknown(kind: Kind, label: Label, span: Span) -> Diagnostic {
    let name = kind.name();
    let message = format!("there is no {name} {label}");
    Diagnostic::error(kind.unknown(), span, message, "not defined").help(kind.undefined())
}

/// A node set that may lack nothing.
pub(super) fn complete_node_set<'a>(scene: &'a Scene, name: &Spanned<String>) -> Result<&'a Set> {
    let set = node_set(scene, name)?;
    if set.unmodelled == 0 {
        return Ok(set);
    }
    let message = format!(
        "set {} lacks the nodes of {} elements of types that are not read",
        name.value, set.unmodelled
    );
    Err(Diagnostic::error(Code::NodesOfSkipped, name.span, message, "must be complete")
        .help("give the set its nodes by *NSET, instead of by ELSET"))
}
