//! Faults planted on purpose, which an audit must tell of.

use super::oracle::{Answer, Oracle};
use super::outcome::{Against, Check};
use super::quantity::{Entries, Numbers, Quantity};
use super::sheet::Sheet;
use serde::Serialize;

/// A fault planted on purpose: whoever doubts that the audit can fail sees it fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Planted {
    /// The largest first derivative of the first component of a connector, of a constraint, of a friction's forces, or the largest slope
    /// of a behaviour is multiplied by 1 + 1e-6.
    WrongEntry,
    /// The same derivative has the wrong sign: a mutant that changes it once more is right.
    WrongSign,
    /// The largest second derivative of the first component of a connector, or of a constraint, and the largest nodal force of that
    /// component are multiplied by 1 + 1e-6.
    WrongSecond,
    /// The largest value of a connector, or of a constraint, is multiplied by 1 + 1e-6.
    WrongValue,
    /// The largest rate is.
    WrongRate,
    /// The largest acceleration is.
    WrongAcceleration,
    /// The largest nodal force of the first component that has any is.
    WrongForce,
    /// The largest slope of a friction force is multiplied by 1 + 1e-6.
    WrongFriction,
    /// The oracles on 237 bits lose the last entry of every row: what nobody compares cannot be noticed.
    LostAnswer,
    /// The oracles on 237 bits lose the last component: numbers that no independent oracle judges are undecided.
    LostWitness,
    /// The last component of the product's numbers is lost.
    LostComponent,
    /// The traced formulas on 237 bits have the wrong sign in the first row: one of two witnesses who contradict each other lies.
    WrongAnswer,
}

/// Loses the numbers of the last component.
fn lose_last<T>(entries: &mut Entries<T>) {
    if let Some(last) = entries.0.iter_mut().rfind(|row| row.is_some()) {
        *last = None;
    }
}

impl Planted {
    /// Where it is planted, in words.
    pub const fn place(self) -> &'static str {
        match self {
            Self::WrongEntry | Self::WrongSign => "a derivative or a slope of a behaviour",
            Self::WrongSecond => "a second derivative or a nodal force",
            Self::WrongValue => "a value",
            Self::WrongRate => "a rate",
            Self::WrongAcceleration => "an acceleration",
            Self::WrongForce => "a nodal force",
            Self::WrongFriction => "a slope of a friction force",
            Self::LostAnswer | Self::LostWitness => "an answer of an oracle on 237 bits",
            Self::LostComponent => "a component",
            Self::WrongAnswer => "an answer of wide-symbolic",
        }
    }

    /// Whether what it takes is no number and no answer that must be compared, but what a claim rests on, which is undecided without.
    pub const fn is_of_a_witness(self) -> bool {
        matches!(self, Self::LostWitness)
    }

    /// Whether a check is of numbers in which it is planted.
    pub(super) fn is_in(self, check: &Check) -> bool {
        let of = |places: &[Quantity]| check.quantity.is_some_and(|quantity| places.contains(&quantity));
        check.compared > 0
            && match self {
                Self::WrongFriction => of(&[Quantity::FrictionTangent]),
                Self::LostAnswer | Self::LostWitness => {
                    matches!(check.against, Against::Oracle(oracle) if oracle.is_wide())
                }
                Self::LostComponent => of(&Quantity::ALL),
                Self::WrongAnswer => check.against == Against::Oracle(Oracle::WideSymbolic),
                _ => of(self.places()),
            }
    }

    /// First derivatives and slopes.
    const FIRST: [Quantity; 3] =
        [Quantity::FirstDerivatives, Quantity::FrictionGradient, Quantity::BehaviorTangent];

    /// Second derivatives, and the forces that follow from the first.
    const SECOND: [Quantity; 2] = [Quantity::SecondDerivatives, Quantity::NodalForces];

    /// In which numbers of an evaluation it is.
    const fn places(self) -> &'static [Quantity] {
        match self {
            Self::WrongEntry | Self::WrongSign => &Self::FIRST,
            Self::WrongSecond => &Self::SECOND,
            Self::WrongValue => &[Quantity::Value],
            Self::WrongRate => &[Quantity::Rate],
            Self::WrongAcceleration => &[Quantity::Acceleration],
            Self::WrongForce => &[Quantity::NodalForces],
            Self::WrongFriction
            | Self::LostAnswer
            | Self::LostWitness
            | Self::LostComponent
            | Self::WrongAnswer => &[],
        }
    }

    /// By what a number is multiplied.
    const fn factor(self) -> Option<f64> {
        match self {
            Self::WrongSign => Some(-1.0),
            _ if self.places().is_empty() => None,
            _ => Some(1.0 + 1e-6),
        }
    }

    /// The numbers with the fault in them.
    pub(super) fn spoil(self, numbers: &mut Numbers<f64>) {
        if self == Self::LostComponent {
            for quantity in Quantity::ALL {
                let mut rows = numbers.entries(quantity).clone();
                lose_last(&mut rows);
                numbers.set(quantity, rows);
            }
        }
        let Some(factor) = self.factor() else { return };
        for quantity in self.places() {
            let mut rows = numbers.entries(*quantity).clone();
            // The first component may have a value of zero, but no row of zeros.
            let count = if quantity.entries() == 1 { rows.0.len() } else { 1 };
            let spoiled = rows.0.iter_mut().flatten().take(count).flatten();
            if let Some(entry) = spoiled.max_by(|x, y| x.abs().total_cmp(&y.abs())) {
                *entry *= factor;
            }
            numbers.set(*quantity, rows);
        }
    }

    /// The slopes of friction with the fault in them.
    pub(super) fn spoil_friction(self, slopes: &mut [Vec<f64>]) {
        let all = slopes.iter_mut().take(6).flatten();
        let largest = all.max_by(|x, y| x.abs().total_cmp(&y.abs()));
        if let Some(entry) = largest.filter(|_| self == Self::WrongFriction) {
            *entry *= 1.0 + 1e-6;
        }
    }

    /// The same of a sheet.
    pub(super) fn spoil_sheet(self, sheet: &mut Sheet) {
        if let Some(factor) = self.factor()
            && self.places().contains(&sheet.quantity)
            && let Some(entry) = sheet.entries.iter_mut().max_by(|x, y| x.got.abs().total_cmp(&y.got.abs()))
        {
            entry.got *= factor;
        }
    }

    /// The answer with the fault in it.
    pub(super) fn blind(self, answer: &mut Answer) {
        if self == Self::LostAnswer {
            answer.numbers.0.iter_mut().flatten().filter(|row| row.len() > 1).for_each(|row| _ = row.pop());
        }
        if self == Self::LostWitness {
            lose_last(&mut answer.numbers);
        }
        if self == Self::WrongAnswer && answer.oracle == Oracle::WideSymbolic {
            let first = answer.numbers.0.iter_mut().flatten().next();
            first.into_iter().flatten().for_each(|wanted| *wanted = wanted.opposite());
        }
    }
}
