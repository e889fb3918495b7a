//! All that is wrong with a deck. An error that follows from one told before is not told: what uses a node whose line is faulty, say.

use crate::diagnostic::{Code, Diagnostic};
use crate::label::Label;
use std::collections::HashSet;

/// The errors so far, and what follows from them.
#[derive(Debug, Default)]
pub(super) struct Errors {
    found: Option<Diagnostic>,
    spoiled: HashSet<Code>,
    /// Nodes whose lines are faulty: what uses them says nothing new.
    lost: HashSet<Label>,
    /// Any node may be missing.
    any_node: bool,
    /// So much is missing that no reference can be judged.
    is_torn: bool,
}

impl Errors {
    /// Adds an error, and those that it carries, unless they follow from others or were told.
    pub(super) fn add(&mut self, error: Diagnostic) {
        let (errors, unsaid) = error.apart();
        for error in errors {
            if !self.spoiled.contains(&error.code()) {
                self.tell(error);
            }
        }
        self.found = self.found.take().map(|first| first.with_unsaid(unsaid));
    }

    /// Adds an error that follows from no other, unless it was told.
    pub(super) fn tell(&mut self, error: Diagnostic) {
        let is_told = |told: &Diagnostic| (told.code(), told.span()) == (error.code(), error.span());
        let mut told = self.found.iter().flat_map(|first| std::iter::once(first).chain(first.further()));
        if told.any(is_told) {
            return;
        }
        self.spoiled.extend(implied(error.code()));
        self.is_torn |= tears(error.code());
        self.found = Diagnostic::joined(self.found.take().into_iter().chain([error]));
    }

    /// The value, or nothing where there is an error instead, which is added.
    pub(super) fn value<T>(&mut self, result: Result<T, Diagnostic>) -> Option<T> {
        result.map_err(|error| self.add(error)).ok()
    }

    /// What a keyword defines is not complete.
    pub(super) fn spoil(&mut self, keyword: &str) {
        self.any_node |= defined(keyword).contains(&Code::UnknownNode);
        self.spoiled.extend(defined(keyword));
    }

    /// The line of a node is faulty.
    pub(super) fn lose(&mut self, node: Label) {
        self.lost.insert(node);
        self.spoiled.extend(defined("NODE"));
    }

    /// Adds that a node is not known, unless its own line is faulty or any node may be missing.
    pub(super) fn misses(&mut self, node: Label, error: Diagnostic) {
        if !self.any_node && !self.lost.contains(&node) {
            self.tell(error);
        }
    }

    /// Whether references can be judged.
    pub(super) fn leaves_references(&self) -> bool {
        !self.is_torn
    }

    /// Whether a deck that has nothing to evaluate may have these errors: nothing of it is in a file that is not there, or not begun.
    pub(super) fn are_excusable(&self) -> bool {
        let mut all = self.found.iter().flat_map(|first| std::iter::once(first).chain(first.further()));
        all.all(|error| !hides(error.code()))
    }

    /// All as one, in the order of their places.
    pub(super) fn into_first(self) -> Option<Diagnostic> {
        let (mut all, unsaid) = self.found?.apart();
        all.sort_by_key(|error| (error.span().file(), error.span().line()));
        Diagnostic::joined(all).map(|first| first.with_unsaid(unsaid))
    }
}

/// Reading cannot go on.
pub(super) fn is_fatal(code: Code) -> bool {
    matches!(code, Code::Unreadable | Code::LineTooLong | Code::IncludeLimit)
}

/// Whether a connector or a constraint may be in what is missing.
fn hides(code: Code) -> bool {
    use Code::*;
    let is_absent =
        matches!(code, IncludeUnreadable | IncludeCycle | UnknownPart | MissingKeywords | UnsupportedKeyword);
    is_fatal(code) || is_absent || matches!(code, NotUtf8 | UnclosedQuote | EmptyKeyword)
}

/// Whether lines of any kind are missing after such an error.
fn tears(code: Code) -> bool {
    is_fatal(code)
        || matches!(
            code,
            Code::IncludeUnreadable
                | Code::IncludeCycle
                | Code::StrayData
                | Code::EmptyKeyword
                | Code::DanglingContinuation
                | Code::UnfinishedBlock
                | Code::UnknownPart
                | Code::UnsupportedKeyword
        )
}

/// The errors of which one is the cause.
fn implied(code: Code) -> &'static [Code] {
    use Code::*;
    match code {
        UnknownElement | UnknownElementSet | DuplicateElement => {
            &[MissingSection, EmptySet, WrongElementType, NodesOfSkipped]
        }
        UnknownNode | UnknownNodeSet => &[EmptySet, BadConnectivity],
        SetCycle => &[MissingSection, EmptySet, WrongElementType, BadConnectivity, UnknownNode],
        WrongElementType | EmptySet => &[MissingSection],
        // The data lines are those of another keyword, and the steps those that did not begin.
        DanglingContinuation => {
            &[MalformedInteger, MalformedNumber, MissingData, SurplusData, UnexpectedData]
        }
        HistoryOutsideStep => &[HistoryOutsideStep],
        _ => &[],
    }
}

/// The errors that show where what a keyword defines is not complete.
fn defined(keyword: &str) -> &'static [Code] {
    use Code::*;
    match keyword {
        "NODE" | "NGEN" | "NFILL" | "NCOPY" | "SYSTEM" => {
            &[UnknownNode, UnknownNodeSet, EmptySet, BadConnectivity]
        }
        "NSET" => &[UnknownNodeSet, EmptySet, BadConnectivity],
        "ELSET" => &[UnknownElementSet, MissingSection, EmptySet],
        "ELGEN" | "ELCOPY" => {
            &[UnknownElement, UnknownElementSet, MissingSection, EmptySet, WrongElementType, UnknownNode]
        }
        "ELEMENT" => &[UnknownElement, UnknownElementSet, MissingSection, EmptySet, WrongElementType],
        "ORIENTATION" => &[UnknownOrientation],
        "AMPLITUDE" => &[UnknownAmplitude],
        "CONNECTOR SECTION" => &[MissingSection],
        "STEP" | "END STEP" => {
            &[HistoryOutsideStep, UnfinishedStep, TwoProcedures, ModelDataInStep, MisplacedKeyword]
        }
        "PART" | "END PART" | "ASSEMBLY" | "END ASSEMBLY" | "INSTANCE" | "END INSTANCE" => &[
            MisplacedKeyword,
            UnfinishedBlock,
            MissingAssembly,
            UnknownPart,
            UnknownInstance,
            UnknownNode,
            UnknownNodeSet,
            UnknownElement,
            UnknownElementSet,
            UnknownOrientation,
            MissingSection,
            EmptySet,
            WrongElementType,
            DuplicateNode,
            DuplicateElement,
        ],
        "FRICTION" => &[MissingFriction],
        "CONNECTOR BEHAVIOR" => {
            &[UnknownBehavior, UnknownDerivedComponent, MissingFriction, MisplacedKeyword, MissingParameter]
        }
        name if name.starts_with("CONNECTOR ") && name != "CONNECTOR MOTION" && name != "CONNECTOR LOAD" => {
            &[UnknownDerivedComponent, MissingFriction, MisplacedKeyword, MissingParameter]
        }
        _ => &[],
    }
}
