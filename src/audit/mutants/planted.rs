//! Faults planted on purpose, which an audit must tell of.

use crate::case::quantity::{Entries, Numbers, Quantity};
use crate::judge::outcome::{Against, Check};
use crate::judge::table::ResultTable;
use crate::oracles::oracle::{Answer, Oracle};
use crate::settings::Planted;

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
    pub fn is_in(self, check: &Check) -> bool {
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
    pub fn spoil(self, numbers: &mut Numbers<f64>) {
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
    pub fn spoil_friction(self, slopes: &mut [Vec<f64>]) {
        let all = slopes.iter_mut().take(6).flatten();
        let largest = all.max_by(|x, y| x.abs().total_cmp(&y.abs()));
        if let Some(entry) = largest.filter(|_| self == Self::WrongFriction) {
            *entry *= 1.0 + 1e-6;
        }
    }

    /// The same of a table.
    pub fn spoil_table(self, table: &mut ResultTable) {
        if let Some(factor) = self.factor()
            && self.places().contains(&table.quantity)
            && let Some(entry) = table.entries.iter_mut().max_by(|x, y| x.got.abs().total_cmp(&y.got.abs()))
        {
            entry.got *= factor;
        }
    }

    /// The answer with the fault in it.
    pub fn blind(self, answer: &mut Answer) {
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
