//! `*CONNECTOR BEHAVIOR` and its suboptions.

use crate::behavior::{
    Affected, Behavior, Damage, DamageCriterion, DamageEvolution, DamageEvolutionKind, Damping, DampingKind,
    Degradation, DerivedTerm, Elasticity, Failure, Friction, FrictionCoefficient, FrictionKind, FrictionLaw,
    Hardening, HardeningKind, Independent, Law, Limits, Lock, Operator, Plasticity, Potential,
    PotentialFunction, PotentialOperator, PotentialTerm, Softening, Source, Stop, TableOptions, TableRow,
};
use crate::choice::Choice;
use crate::deck::mesh::not_negative;
use crate::deck::table;
use crate::deck::table::{LINE_FOLLOWS, no_rows, raw, records, rows};
use crate::deck::{Deck, Host, misplaced};
use crate::diagnostic::{Code, Diagnostic, Result};
use crate::label::normal;
use crate::lexer::{Data, Item, Keyword};
use crate::span::{Span, Spanned};

pub(super) fn behavior(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let name = keyword.need_name("NAME")?;
    if let Some(first) = deck.scene.behaviors.get(&name.value) {
        return Err(keyword.duplicate(&name, first.span));
    }
    let behavior = Behavior {
        table: table_options(keyword)?,
        integration: keyword.choice("INTEGRATION")?,
        span: keyword.span,
        ..Behavior::default()
    };
    deck.scene.behaviors.insert(name.value, behavior);
    deck.behavior_open = true;
    Ok(())
}

fn table_options(keyword: &Keyword) -> Result<TableOptions> {
    Ok(TableOptions {
        extrapolation: keyword.choice("EXTRAPOLATION")?,
        regularize: keyword.switch("REGULARIZE")?,
        rtol: keyword.number("RTOL")?,
    })
}

pub(super) fn constitutive_reference(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    deck.host = Host::None;
    let Some(line) = deck.lexer.data()? else {
        let columns = ["three lengths", "three angles in degrees"];
        return Err(no_rows((&keyword.name, keyword.span), &columns));
    };
    let mut items = line.items();
    let mut reference = [None; 6];
    for value in &mut reference {
        *value = items.number()?;
    }
    items.end("three lengths and three angles in degrees")?;
    let place = line.span;
    let behavior = deck.behavior(keyword)?;
    if behavior.constitutive_reference != [None; 6] {
        return Err(repeated(keyword, "a second constitutive reference"));
    }
    behavior.constitutive_reference = reference;
    behavior.constitutive_reference_span = place;
    Ok(())
}

/// A suboption that may stand once only.
fn repeated(keyword: &Keyword, what: &str) -> Diagnostic {
    Diagnostic::error(
        Code::RepeatedSuboption,
        keyword.span,
        format!("{what} in one behaviour"),
        "the second one",
    )
    .help("keep one of the two, or define another behaviour")
}

/// A line of component numbers, each at most once.
fn components(line: &Data<'_>) -> Result<Vec<u8>> {
    let mut components = Vec::new();
    for item in line.items().filter(|item| !item.text.is_empty()) {
        let component = item.component()?;
        if components.contains(&component) {
            let message = format!("component {component} is listed twice");
            return Err(Diagnostic::error(Code::BadComponent, item.span, message, "the second time")
                .help("list every component once"));
        }
        components.push(component);
    }
    Ok(components)
}

fn component_line(deck: &mut Deck<'_>, keyword: &Keyword, what: &str) -> Result<Vec<u8>> {
    match deck.lexer.row()? {
        Some(line) => components(&line),
        None => {
            let message = keyword.words().map(|keyword| format!("{keyword} has no {what}"));
            Err(Diagnostic::error(Code::MissingData, keyword.span, message, LINE_FOLLOWS)
                .help(["line", "row"].map(|line| format!("give a {line} with {what}, such as 1, 2"))))
        }
    }
}

fn independent(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<Option<Independent>> {
    let basis = keyword.choice("INDEPENDENT COMPONENTS")?;
    basis
        .map(|basis| {
            let components = component_line(deck, keyword, "independent component numbers")?;
            Ok(Independent { basis, components })
        })
        .transpose()
}

/// Two parameters that exclude each other, in the words of decks and of documents.
fn exclusive(keyword: &Keyword, first: [&str; 2], second: [&str; 2]) -> Diagnostic {
    let all = [0, 1].map(|form| (first[form], second[form]));
    let message = all.map(|(first, second)| format!("{first} and {second} exclude each other"));
    Diagnostic::error(Code::ConflictingParameters, keyword.span, message, "this keyword")
        .help(all.map(|(first, second)| format!("remove {first} or {second}")))
}

/// The law of an elasticity or damping; `coefficient` and `motion` name its columns.
fn law(deck: &mut Deck<'_>, keyword: &Keyword, coefficient: &str, motion: &str) -> Result<Law> {
    let fields = keyword.dependencies()?;
    let component = keyword.component("COMPONENT")?;
    let (nonlinear, rigid) = (keyword.has("NONLINEAR"), keyword.has("RIGID"));
    let (unsymmetric, frequency) = (keyword.has("UNSYMM"), flag(keyword, "FREQUENCY DEPENDENCE")?);
    if nonlinear && rigid {
        return Err(exclusive(keyword, ["NONLINEAR", "nonlinear"], ["RIGID", "rigid"]));
    }
    if unsymmetric && component.is_some() {
        return Err(exclusive(keyword, ["UNSYMM", "unsymmetric"], ["COMPONENT", "component"]));
    }
    let header = (keyword.name.as_str(), keyword.span);
    if rigid {
        let mut listed: Vec<u8> = component.into_iter().collect();
        if component.is_none()
            && let Some(line) = deck.lexer.row()?
        {
            listed = components(&line)?;
        }
        return Ok(Law::Rigid { components: listed });
    }
    if nonlinear {
        let component = keyword.need_component()?;
        let independent = independent(deck, keyword)?;
        // A damping force depends on the velocity of its own component in any case.
        let own = independent.is_none() || keyword.name == "CONNECTOR DAMPING";
        let mut columns = vec!["the force"];
        columns.extend(own.then_some(motion));
        let listed = independent.as_ref().map_or(0, |independent| independent.components.len());
        columns.resize(columns.len() + listed, "the independent component");
        let (first, rows) = spanned_rows(deck, header, &columns, columns.len(), fields)?;
        if independent.is_none() {
            check_order(&rows, 1, motion, &first)?;
        }
        return Ok(Law::Nonlinear { component, independent, rows });
    }
    if let Some(component) = component {
        return Ok(Law::Linear {
            component,
            rows: rows(&mut deck.lexer, header, &[coefficient, "frequency"], 1, fields)?,
        });
    }
    let terms = if unsymmetric { 36 } else { 21 };
    let mut columns = vec!["every term of the matrix"; terms];
    if frequency {
        columns.push("frequency");
    }
    let first = deck.lexer.row()?.map(|line| line.items().count());
    if first.is_some() {
        deck.lexer.again();
    }
    // A number and its temperature are no matrix.
    let is_of_one = first.is_some_and(|count| count <= 2);
    let rows = rows(&mut deck.lexer, header, &columns, terms, fields).map_err(|error| {
        if !is_of_one || error.code() != Code::MissingData {
            return error;
        }
        let what =
            format!("for {coefficient} of one component; the matrix of all has {terms} terms, 8 on a line");
        let [deck, field] = keyword.words();
        let remedy =
            [format!("write {deck}, COMPONENT=… {what}"), format!("write {field}, component {what}")];
        keyword.missing("COMPONENT").help(remedy)
    })?;
    Ok(Law::Coupled { unsymmetric, frequency, rows })
}

fn flag(keyword: &Keyword, parameter: &str) -> Result<bool> {
    Ok(keyword.has(parameter) && keyword.switch(parameter)? != Some(false))
}

/// Rows with the place of each.
fn spanned_rows(
    deck: &mut Deck<'_>,
    keyword: (&str, Span),
    columns: &[&str],
    needed: usize,
    fields: usize,
) -> Result<(Vec<Span>, Vec<TableRow>)> {
    let records = records(&mut deck.lexer, columns.len() + 1 + fields)?;
    if records.is_empty() {
        return Err(no_rows(keyword, columns));
    }
    let mut spans = Vec::with_capacity(records.len());
    for record in &records {
        for (index, what) in columns.iter().enumerate().take(needed) {
            record.need(index, what)?;
        }
        spans.push(record.span);
    }
    Ok((spans, records.into_iter().map(|record| record.row(columns.len())).collect()))
}

/// Column `index` increases from row to row, as long as temperature and fields stay the same.
fn check_order(rows: &[TableRow], index: usize, what: &str, spans: &[Span]) -> Result<()> {
    for (pair, span) in rows.windows(2).zip(spans.iter().skip(1)) {
        let [before, after] = pair else { continue };
        let same = before.temperature == after.temperature && before.fields == after.fields;
        let value = |row: &TableRow| row.values.get(index).copied().flatten();
        if same && value(after) <= value(before) {
            let (from, to) = (value(before).unwrap_or(0.0), value(after).unwrap_or(0.0));
            let message = format!("{what} goes from {from} to {to}");
            return Err(Diagnostic::error(
                Code::TableOrder,
                *span,
                message,
                ["must be larger than on the line before", "must be larger than in the row before"],
            )
            .help(["lines", "rows"].map(|rows| format!("order the {rows} so that {what} increases"))));
        }
    }
    Ok(())
}

pub(super) fn elasticity(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    deck.host = Host::None;
    let law = law(deck, keyword, "the stiffness", "the displacement")?;
    let elasticity = Elasticity { law, table: table_options(keyword)?, span: keyword.span };
    deck.behavior(keyword)?.elasticity.push(elasticity);
    Ok(())
}

pub(super) fn damping(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    deck.host = Host::None;
    let kind = keyword.choice("TYPE")?.unwrap_or(DampingKind::Viscous);
    let law = law(deck, keyword, "the damping coefficient", "the velocity")?;
    if kind == DampingKind::Structural && matches!(law, Law::Nonlinear { .. } | Law::Rigid { .. }) {
        let message = "structural damping is linear";
        return Err(Diagnostic::error(Code::ConflictingParameters, keyword.span, message, "this keyword")
            .help([
                "remove NONLINEAR or RIGID, or TYPE=STRUCTURAL",
                "remove nonlinear or rigid, or type = \"structural\"",
            ]));
    }
    let damping = Damping { kind, law, table: table_options(keyword)?, span: keyword.span };
    deck.behavior(keyword)?.damping.push(damping);
    Ok(())
}

/// A component number or the name of a derived component.
fn source(
    text: &str,
    integer: bool,
    component: Result<u8>,
    name: Result<Spanned<String>>,
    span: Span,
) -> Result<Spanned<Source>> {
    let numeric = integer || crate::lexer::parse_number(text).is_ok();
    let source = if numeric { Source::Component(component?) } else { Source::Derived(name?.value) };
    Ok(Spanned::new(source, span))
}

fn item_source(item: &Item<'_>) -> Result<Spanned<Source>> {
    source(item.text, item.is_integer(), item.component(), item.name(), item.span)
}

pub(super) fn friction(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let predefined = keyword.has("PREDEFINED");
    let component = keyword.component("COMPONENT")?;
    let contact_force = keyword.get("CONTACT FORCE");
    let contact_force = contact_force
        .map(|value| source(value.text(), value.is_integer(), value.component(), value.name(), value.span))
        .transpose()?;
    let kind = if predefined {
        let others = [
            ["COMPONENT", "component"],
            ["CONTACT FORCE", "contact_force"],
            ["INDEPENDENT COMPONENTS", "independent"],
        ];
        if let Some(other) = others.into_iter().find(|[parameter, _]| keyword.has(parameter)) {
            return Err(exclusive(keyword, ["PREDEFINED", "predefined"], other));
        }
        let constants = match deck.lexer.row()? {
            Some(line) => {
                let mut items = line.items();
                let mut constants = Vec::new();
                for item in items.by_ref().take(8) {
                    constants.push(if item.text.is_empty() { None } else { Some(item.number()?) });
                }
                items.end("at most eight constants")?;
                constants
            }
            None => Vec::new(),
        };
        FrictionKind::Predefined { constants }
    } else {
        let fields = keyword.dependencies()?;
        let independent = independent(deck, keyword)?;
        let width = 4 + independent.as_ref().map_or(0, |independent| independent.components.len()) + fields;
        let rows = raw(&mut deck.lexer, width)?;
        if rows.is_empty() && contact_force.is_none() {
            let message = keyword.words().map(|keyword| format!("{keyword} has no normal force"));
            return Err(Diagnostic::error(
                Code::MissingData,
                keyword.span,
                message,
                ["neither data nor CONTACT FORCE", "neither rows nor contact_force"],
            )
            .help([
                "give CONTACT FORCE=…, or a line with the internal contact force, or PREDEFINED",
                "give contact_force, or rows with the internal contact force, or predefined",
            ]));
        }
        FrictionKind::User { component, potential: None, contact_force, independent, rows }
    };
    let friction = Friction {
        stick_stiffness: keyword.number("STICK STIFFNESS")?,
        kind,
        coefficient: None,
        table: table_options(keyword)?,
        span: keyword.span,
    };
    deck.behavior(keyword)?.friction.push(friction);
    deck.host = Host::Friction;
    Ok(())
}

pub(super) fn friction_coefficient(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    if deck.host != Host::Friction {
        return Err(misplaced(keyword, ["*CONNECTOR FRICTION"; 2]));
    }
    let fields = keyword.dependencies()?;
    let (exponential, test) = (keyword.has("EXPONENTIAL DECAY"), keyword.has("TEST DATA"));
    let header = (keyword.name.as_str(), keyword.span);
    let law = if exponential && test {
        FrictionLaw::TestData(raw(&mut deck.lexer, 3)?)
    } else if test {
        let message = "TEST DATA goes with EXPONENTIAL DECAY";
        return Err(Diagnostic::error(
            Code::MissingParameter,
            keyword.span,
            message,
            "EXPONENTIAL DECAY is missing",
        )
        .help("write *FRICTION, EXPONENTIAL DECAY, TEST DATA"));
    } else if exponential {
        let Some(record) = table::record(&mut deck.lexer, 3)? else {
            return Err(no_rows(header, &["the static coefficient", "the kinetic coefficient", "the decay"]));
        };
        let static_coefficient = record.need(0, "the static coefficient")?;
        let kinetic_coefficient = record.need(1, "the kinetic coefficient")?;
        let decay = record.need(2, "the decay")?;
        for (value, what) in [
            (static_coefficient, "the static coefficient"),
            (kinetic_coefficient, "the kinetic coefficient"),
            (decay, "the decay"),
        ] {
            not_negative(value, what, record.span)?;
        }
        FrictionLaw::Exponential { static_coefficient, kinetic_coefficient, decay }
    } else {
        let columns = ["the friction coefficient", "slip rate", "contact force"];
        let (spans, rows) = spanned_rows(deck, header, &columns, 1, fields)?;
        for (row, span) in rows.iter().zip(spans) {
            not_negative(
                row.values.first().copied().flatten().unwrap_or(0.0),
                "the friction coefficient",
                span,
            )?;
        }
        FrictionLaw::Table(rows)
    };
    let maximum = keyword.number("TAUMAX")?;
    not_negative(maximum.unwrap_or(0.0), "TAUMAX", keyword.span)?;
    let slip_tolerance = keyword.number("SLIP TOLERANCE")?;
    let elastic_slip = keyword.number("ELASTIC SLIP")?;
    let coefficient = FrictionCoefficient { law, maximum, slip_tolerance, elastic_slip, span: keyword.span };
    match deck.behavior(keyword)?.friction.last_mut() {
        Some(friction) if friction.coefficient.is_none() => friction.coefficient = Some(coefficient),
        _ => return Err(misplaced(keyword, ["a *CONNECTOR FRICTION of its own"; 2])),
    }
    Ok(())
}

pub(super) fn derived_component(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let name = keyword.need_name("NAME")?;
    let fields = keyword.dependencies()?;
    let components = component_line(deck, keyword, "component numbers")?;
    if components.is_empty() {
        let message = format!("derived component {} has no components", name.value);
        return Err(Diagnostic::error(Code::MissingData, name.span, message, "without components").help(
            ["on the first data line", "in components"]
                .map(|place| format!("list component numbers {place}")),
        ));
    }
    let independent = independent(deck, keyword)?;
    let columns =
        components.len() + independent.as_ref().map_or(0, |independent| independent.components.len());
    let records = records(&mut deck.lexer, columns + 1 + fields)?;
    let term = DerivedTerm {
        operator: keyword.choice("OPERATOR")?.unwrap_or(Operator::Norm),
        sign: if keyword.word("SIGN", &["POSITIVE", "NEGATIVE"])? == Some("NEGATIVE") { -1.0 } else { 1.0 },
        components,
        independent,
        rows: records.into_iter().map(|record| record.row(columns)).collect(),
        table: table_options(keyword)?,
        span: keyword.span,
    };
    deck.behavior(keyword)?.derived_components.entry(name.value).or_default().push(term);
    Ok(())
}

pub(super) fn potential(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let mut terms = Vec::new();
    while let Some(line) = deck.lexer.row()? {
        let mut items = line.items();
        let source = item_source(&items.need("a component or derived component")?)?;
        let scale = items.number()?.unwrap_or(1.0);
        let exponent = items.number()?;
        let function = items.maybe().map(|item| item.choice("H")).transpose()?.flatten();
        let shift = items.number()?.unwrap_or(0.0);
        let sign = match items.maybe() {
            None => 1.0,
            Some(item) => {
                let sign = item.number()?;
                if sign.abs() != 1.0 {
                    let message = format!("the sign of a term cannot be {sign}");
                    return Err(Diagnostic::error(Code::BadValue, item.span, message, "must be 1 or -1")
                        .help("write 1 or -1; factors are given as R"));
                }
                sign
            }
        };
        items.end("a component, R, α, H, shift and sign")?;
        if scale == 0.0 {
            let message = "R = 0 divides by zero";
            return Err(Diagnostic::error(Code::NumberOutOfRange, line.span, message, "R must not be 0")
                .help("leave R empty for 1"));
        }
        let function = function.unwrap_or(PotentialFunction::Abs);
        terms.push(PotentialTerm { source, scale, exponent, function, shift, sign });
    }
    if terms.is_empty() {
        return Err(no_rows((&keyword.name, keyword.span), &["a component or derived component"]));
    }
    let potential = Potential {
        operator: keyword.choice("OPERATOR")?.unwrap_or(PotentialOperator::Sum),
        exponent: keyword.number("EXPONENT")?.unwrap_or(2.0),
        terms,
        span: keyword.span,
    };
    let host = deck.host;
    let behavior = deck.behavior(keyword)?;
    let place = match host {
        Host::Friction => match behavior.friction.last_mut().map(|friction| &mut friction.kind) {
            Some(FrictionKind::User { component: None, potential, .. }) => Some(potential),
            _ => None,
        },
        Host::Plasticity => behavior
            .plasticity
            .last_mut()
            .filter(|plasticity| plasticity.component.is_none())
            .map(|p| &mut p.potential),
        Host::Damage => behavior.damage.last_mut().map(|damage| match &mut damage.evolution {
            Some(evolution) => &mut evolution.potential,
            None => &mut damage.potential,
        }),
        Host::None => None,
    };
    match place {
        Some(place) if place.is_none() => {
            *place = Some(potential);
            Ok(())
        }
        _ => {
            let coupled = [
                "a coupled *CONNECTOR FRICTION, PLASTICITY or DAMAGE (without COMPONENT)",
                "a coupled friction, plasticity or damage (without component)",
            ];
            Err(misplaced(keyword, coupled))
        }
    }
}

pub(super) fn plasticity(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let component = keyword.component("COMPONENT")?;
    let plasticity = Plasticity { component, potential: None, hardening: Vec::new(), span: keyword.span };
    deck.behavior(keyword)?.plasticity.push(plasticity);
    deck.host = Host::Plasticity;
    Ok(())
}

pub(super) fn hardening(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    if deck.host != Host::Plasticity {
        return Err(misplaced(keyword, ["*CONNECTOR PLASTICITY"; 2]));
    }
    let fields = keyword.dependencies()?;
    let kind = keyword.choice("TYPE")?.unwrap_or(HardeningKind::Isotropic);
    let definition = keyword.choice("DEFINITION")?.unwrap_or(kind.definition());
    if definition.kind() != kind {
        let message = format!("{} hardening has no definition {}", kind.spelling(), definition.spelling());
        return Err(Diagnostic::error(Code::ConflictingParameters, keyword.span, message, "TYPE and DEFINITION")
            .help("ISOTROPIC takes TABULAR or EXPONENTIAL LAW, KINEMATIC takes HALF CYCLE, STABILIZED or PARAMETERS"));
    }
    let hardening = Hardening {
        kind,
        definition,
        rate_filter: keyword.number("RATE FILTER FACTOR")?,
        rate_interpolation: keyword.choice("RATE INTERPOLATION")?,
        rows: rows(
            &mut deck.lexer,
            (&keyword.name, keyword.span),
            definition.columns(),
            definition.needed_columns(),
            fields,
        )?,
        table: table_options(keyword)?,
    };
    match deck.behavior(keyword)?.plasticity.last_mut() {
        Some(plasticity) => plasticity.hardening.push(hardening),
        None => return Err(misplaced(keyword, ["*CONNECTOR PLASTICITY"; 2])),
    }
    Ok(())
}

pub(super) fn damage_initiation(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    let fields = keyword.dependencies()?;
    let criterion = keyword.choice("CRITERION")?.unwrap_or(DamageCriterion::Force);
    let records = records(&mut deck.lexer, 4 + fields)?;
    if records.is_empty() {
        return Err(no_rows((&keyword.name, keyword.span), &["lower limit", "upper limit"]));
    }
    if criterion != DamageCriterion::PlasticMotion {
        for record in &records {
            let at = |index: usize| record.values.get(index).copied().flatten();
            check_limits(at(0), at(1), "limit", record.span)?;
        }
    }
    let damage = Damage {
        criterion,
        component: keyword.component("COMPONENT")?,
        potential: None,
        rows: records.into_iter().map(|record| record.values).collect(),
        rate_filter: keyword.number("RATE FILTER FACTOR")?,
        rate_interpolation: keyword.choice("RATE INTERPOLATION")?,
        evolution: None,
        table: table_options(keyword)?,
        span: keyword.span,
    };
    deck.behavior(keyword)?.damage.push(damage);
    deck.host = Host::Damage;
    Ok(())
}

pub(super) fn damage_evolution(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    if deck.host != Host::Damage {
        return Err(misplaced(keyword, ["*CONNECTOR DAMAGE INITIATION"; 2]));
    }
    let fields = keyword.dependencies()?;
    let affected = if keyword.has("AFFECTED COMPONENTS") {
        component_line(deck, keyword, "affected component numbers")?
    } else {
        Vec::new()
    };
    let rows = raw(&mut deck.lexer, 4 + fields)?;
    if rows.is_empty() {
        return Err(no_rows((&keyword.name, keyword.span), &["the motion or energy at failure"]));
    }
    let evolution = DamageEvolution {
        kind: keyword.choice("TYPE")?.unwrap_or(DamageEvolutionKind::Motion),
        softening: keyword.choice("SOFTENING")?.unwrap_or(Softening::Linear),
        degradation: keyword.choice("DEGRADATION")?.unwrap_or(Degradation::Maximum),
        affected,
        potential: None,
        rows,
        table: table_options(keyword)?,
    };
    match deck.behavior(keyword)?.damage.last_mut() {
        Some(damage) if damage.evolution.is_none() => damage.evolution = Some(evolution),
        _ => return Err(misplaced(keyword, ["a *CONNECTOR DAMAGE INITIATION of its own"; 2])),
    }
    Ok(())
}

/// Lower ≤ upper, where both are given.
fn check_limits(lower: Option<f64>, upper: Option<f64>, what: &str, span: Span) -> Result<()> {
    match (lower, upper) {
        (Some(lower), Some(upper)) if lower > upper => {
            let message = format!("the lower {what} {lower} lies above the upper one {upper}");
            Err(Diagnostic::error(Code::LimitsReversed, span, message, "reversed")
                .help("write the lower limit first; leave an item empty for no limit"))
        }
        _ => Ok(()),
    }
}

fn no_limits(keyword: &Keyword, span: Span) -> Diagnostic {
    let message = keyword.words().map(|keyword| format!("this {keyword} never acts: it has no limit"));
    Diagnostic::warning(Code::LimitsMissing, span, message, "no limit given")
        .help("give a lower or an upper limit")
}

pub(super) fn stop(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    deck.host = Host::None;
    let component = keyword.need_component()?;
    let Some(line) = deck.lexer.data()? else {
        return Err(no_rows((&keyword.name, keyword.span), &["lower position", "upper position"]));
    };
    let mut items = line.items();
    let (lower, upper) = (items.number()?, items.number()?);
    items.end("a lower and an upper position")?;
    let span = if line.is_blank() { keyword.span } else { line.span };
    check_limits(lower, upper, "position", span)?;
    if lower.is_none() && upper.is_none() {
        deck.warn(no_limits(keyword, span));
    }
    let behavior = deck.behavior(keyword)?;
    behavior.stops.push(Stop { component, lower, upper, span });
    let left = behavior.limits_of_stops().get(usize::from(component) - 1).copied().flatten();
    if let Some([Some(lower), Some(upper)]) = left
        && lower > upper
    {
        let message = format!("the stops of component {component} leave it no position");
        return Err(Diagnostic::error(Code::RepeatedSuboption, span, message, "the last of them")
            .help("of several stops the tighter limits hold: let them overlap"));
    }
    Ok(())
}

fn limits(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<Vec<Limits>> {
    let fields = keyword.dependencies()?;
    let records = records(&mut deck.lexer, 5 + fields)?;
    let mut limits = Vec::with_capacity(records.len());
    for record in records {
        let at = |index: usize| record.values.get(index).copied().flatten();
        check_limits(at(0), at(1), "position", record.span)?;
        check_limits(at(2), at(3), "force", record.span)?;
        limits.push(Limits {
            lower_position: at(0),
            upper_position: at(1),
            lower_force: at(2),
            upper_force: at(3),
            temperature: at(4),
            fields: record.values.get(5..).unwrap_or_default().to_vec(),
        });
    }
    let none = |limit: &Limits| {
        [limit.lower_position, limit.upper_position, limit.lower_force, limit.upper_force]
            .iter()
            .all(Option::is_none)
    };
    if limits.iter().all(none) {
        deck.warn(no_limits(keyword, keyword.span));
    }
    Ok(limits)
}

fn affected(keyword: &Keyword, parameter: &str) -> Result<Affected> {
    match keyword.get(parameter) {
        None => Ok(Affected::All),
        Some(value) if normal(value.text()) == "ALL" => Ok(Affected::All),
        Some(value) if value.is_integer() => Ok(Affected::Component(value.component()?)),
        Some(value) => {
            let message = format!("{parameter} cannot be `{}`", value.text());
            Err(Diagnostic::error(Code::BadParameterValue, value.span, message, "not one of those allowed")
                .help(format!("{parameter} is ALL or a component, 1 to 6")))
        }
    }
}

pub(super) fn lock(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    deck.host = Host::None;
    let lock = Lock {
        component: keyword.need_component()?,
        locked: affected(keyword, "LOCK")?,
        limits: limits(deck, keyword)?,
        table: table_options(keyword)?,
        span: keyword.span,
    };
    deck.behavior(keyword)?.locks.push(lock);
    Ok(())
}

pub(super) fn failure(deck: &mut Deck<'_>, keyword: &Keyword) -> Result<()> {
    deck.host = Host::None;
    let failure = Failure {
        component: keyword.need_component()?,
        released: affected(keyword, "RELEASE")?,
        limits: limits(deck, keyword)?,
        span: keyword.span,
    };
    deck.behavior(keyword)?.failures.push(failure);
    Ok(())
}
