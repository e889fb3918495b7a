//! `*CONNECTOR LOCK` and `*CONNECTOR FAILURE`: limits whose passing changes a connector for good.
//!
//! Four limits, of position (CP) and of total force (CTF) of one component; beyond any of them the criterion is met. A lock then keeps
//! one available component, or all, where they are. A failure releases one component, or all: what the connector does in it
//! vanishes, from that state on. The force of a constrained component is its reaction, which has to be given.
//!
//! *Standard and Explicit.* A failure in Standard is triggered by, and releases, available components only; `RELEASE=ALL` releases those.
//! In Explicit constrained components may trigger it and are released too. A scene without steps counts as Standard.

use crate::behavior::law::extrapolation;
use crate::behavior::table::Table;
use crate::behavior::{Conditions, Unknown};
use pintle_kinematics::catalog::component_index;
use pintle_kinematics::connector::{Components, Mask};
use pintle_scene as scene;
use pintle_scene::{Affected, Code, Diagnostic, Span, TableOptions, TableRow};
use serde::Serialize;

/// Which limit was passed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Passed {
    /// The lower position.
    LowerPosition,
    /// The upper position.
    UpperPosition,
    /// The lower force.
    LowerForce,
    /// The upper force.
    UpperForce,
}

impl Passed {
    /// The limit, in words.
    pub const fn in_words(self) -> &'static str {
        match self {
            Self::LowerPosition => "lower position",
            Self::UpperPosition => "upper position",
            Self::LowerForce => "lower force",
            Self::UpperForce => "upper force",
        }
    }
}

/// Whether a criterion is met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It is, by this limit.
    Met(Passed),
    /// It is not.
    NotMet,
    /// It has a limit that cannot be checked.
    Undecided(Unknown),
}

/// Limits of one component, and what happens beyond them.
#[derive(Clone, Debug)]
pub struct Criterion {
    /// The component (0-based).
    pub component: usize,
    /// What is locked or released.
    pub affected: Mask,
    limits: [Option<Table>; 4],
}

/// The limits in the order of a data line.
const LIMITS: [Passed; 4] =
    [Passed::LowerPosition, Passed::UpperPosition, Passed::LowerForce, Passed::UpperForce];

impl Criterion {
    fn new(
        component: u8,
        affected: Mask,
        limits: &[scene::Limits],
        options: [&TableOptions; 2],
        span: Span,
    ) -> Result<Self, Diagnostic> {
        let of = |limit: &scene::Limits, passed: Passed| match passed {
            Passed::LowerPosition => limit.lower_position,
            Passed::UpperPosition => limit.upper_position,
            Passed::LowerForce => limit.lower_force,
            Passed::UpperForce => limit.upper_force,
        };
        let mut tables = [const { None }; 4];
        for (table, passed) in tables.iter_mut().zip(LIMITS) {
            if limits.iter().all(|limit| of(limit, passed).is_none()) {
                continue;
            }
            let rows: Vec<TableRow> = limits
                .iter()
                .map(|limit| TableRow {
                    values: vec![of(limit, passed)],
                    temperature: limit.temperature,
                    fields: limit.fields.clone(),
                    span,
                })
                .collect();
            *table = Some(Table::new(&rows, 1, &[], extrapolation(options))?);
        }
        let Some(component) = component_index(component) else {
            let message = format!("there is no component {component}");
            return Err(Diagnostic::error(Code::BadComponent, span, message, "give a component from 1 to 6"));
        };
        Ok(Self { component, affected, limits: tables })
    }

    /// A lock, for a type with these available components.
    ///
    /// # Errors
    /// Limits out of order, or incomplete.
    pub fn lock(given: &scene::Lock, available: Mask, defaults: &TableOptions) -> Result<Self, Diagnostic> {
        let affected = affected(given.locked, available);
        Self::new(given.component, affected, &given.limits, [&given.table, defaults], given.span)
    }

    /// A failure, for a type with these available and constrained components.
    ///
    /// # Errors
    /// Limits out of order, or incomplete.
    pub fn failure(
        given: &scene::Failure,
        [available, constrained]: [Mask; 2],
        is_explicit: bool,
        defaults: &TableOptions,
    ) -> Result<Self, Diagnostic> {
        let reach = [0, 1, 2, 3, 4, 5].map(|k| available[k] || (is_explicit && constrained[k]));
        let affected = affected(given.released, reach);
        let options = TableOptions::default();
        Self::new(given.component, affected, &given.limits, [&options, defaults], given.span)
    }

    /// Whether any limit refers to the force.
    pub fn needs_force(&self) -> bool {
        self.limits[2].is_some() || self.limits[3].is_some()
    }

    /// The limits in the order of a data line: positions, then forces, each lower and upper.
    ///
    /// # Errors
    /// One depends on a temperature or field variable that is not given.
    pub fn limits(&self, conditions: &Conditions) -> Result<[Option<f64>; 4], Unknown> {
        let mut found = [None; 4];
        for (limit, table) in found.iter_mut().zip(&self.limits) {
            let Some(table) = table else { continue };
            if let Some(unknown) = table.depends_on().find_map(|variable| conditions.lacks(variable)) {
                return Err(unknown);
            }
            *limit = Some(table.evaluate(0, |variable| conditions.of(variable)));
        }
        Ok(found)
    }

    /// Whether a position and a force lie beyond a limit. A force that is not known leaves limits of force undecided.
    pub fn check(
        &self,
        position: &Components<f64>,
        force: &Components<f64>,
        conditions: &Conditions,
    ) -> Verdict {
        let mut undecided = None;
        for (table, passed) in self.limits.iter().zip(LIMITS) {
            let Some(table) = table else { continue };
            if let Some(unknown) = table.depends_on().find_map(|variable| conditions.lacks(variable)) {
                undecided = undecided.or(Some(unknown));
                continue;
            }
            let limit: f64 = table.evaluate(0, |variable| conditions.of(variable));
            let value = match passed {
                Passed::LowerPosition | Passed::UpperPosition => position[self.component],
                Passed::LowerForce | Passed::UpperForce => force[self.component],
            };
            let Some(value) = value else {
                undecided = undecided.or(Some(Unknown::Reaction));
                continue;
            };
            let is_beyond = match passed {
                Passed::LowerPosition | Passed::LowerForce => value < limit,
                Passed::UpperPosition | Passed::UpperForce => value > limit,
            };
            if is_beyond {
                return Verdict::Met(passed);
            }
        }
        undecided.map_or(Verdict::NotMet, Verdict::Undecided)
    }
}

/// The components that a criterion can act on, of those named: the rules of the catalogue warn of the others.
fn affected(named: Affected, reach: Mask) -> Mask {
    match named {
        Affected::All => reach,
        Affected::Component(component) => {
            [0, 1, 2, 3, 4, 5].map(|k| reach[k] && k + 1 == usize::from(component))
        }
    }
}
