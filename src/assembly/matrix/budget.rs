//! How much is spent on what follows the rank: on names, and on where redundancies hold.
//!
//! Operations are counted, not time, so that the same is told of a model on every machine and by any number of threads. One is what elimination does with
//! one entry of a row, some 10 ns; others count as so many as take as long. What runs at once has budgets of its own, which are known before it begins.
//! Where one is spent, what was found is told, and of the rest that it was not looked for.

use crate::facts::Spent;
use std::sync::atomic::{AtomicU64, Ordering};

/// Operations for any assembly, those for each of its degrees of freedom besides, and the most.
const ANY: u64 = 300_000_000;
const EACH: u64 = 50_000;
const MOST: u64 = 3_000_000_000;
/// To evaluate a connector or multi-point constraint with its derivatives.
pub(crate) const EVALUATION: usize = 200;
/// To put a row into a matrix, and that together to bodies.
pub(crate) const ROW: usize = 100;
/// A product of dense matrices takes this part of an operation, and so does one of a sparse matrix with a vector.
pub(crate) const PRODUCTS: usize = 8;
/// A decomposition of a dense matrix takes so many, times the square of the smaller side, times the larger.
const DECOMPOSITION: usize = 1;

/// What may be spent.
#[derive(Debug)]
pub(crate) struct Budget {
    most: u64,
    spent: AtomicU64,
}

impl Budget {
    pub(crate) const fn new(most: u64) -> Self {
        Self { most, spent: AtomicU64::new(0) }
    }

    /// That of an assembly, or of the names of a connected component, of so many degrees of freedom.
    pub(crate) fn of(freedoms: usize) -> Self {
        Self::new((ANY + EACH * freedoms as u64).min(MOST))
    }

    pub(crate) fn spent(&self) -> u64 {
        self.spent.load(Ordering::Relaxed)
    }

    pub(crate) fn left(&self) -> u64 {
        self.most.saturating_sub(self.spent())
    }

    /// What was spent of what may be.
    pub(crate) fn told(&self) -> Spent {
        Spent { operations: self.spent(), most: self.most }
    }

    pub(crate) fn is_spent(&self) -> bool {
        self.left() == 0
    }

    /// Counts operations; `false` where no more may be spent.
    pub(crate) fn spend(&self, operations: usize) -> bool {
        let before = self.spent.fetch_add(operations as u64, Ordering::Relaxed);
        before.saturating_add(operations as u64) < self.most
    }

    /// Counts a decomposition of a dense matrix, or what takes as long.
    pub(crate) fn decompose(&self, rows: usize, columns: usize) -> bool {
        self.spend(DECOMPOSITION * rows.min(columns).pow(2) * rows.max(columns))
    }

    /// What one of several that run at once may spend of what is left: by its weight among all that are still to come, or `least`.
    pub(crate) fn share(&self, [weight, all]: [usize; 2], least: u64) -> Self {
        let left = self.left();
        let of_weight = u128::from(left) * weight as u128 / all.max(1) as u128;
        Self::new((of_weight as u64).max(least.min(left)))
    }

    /// Counts what another spent that was given of this one.
    pub(crate) fn count(&self, other: &Self) {
        self.spend(other.spent() as usize);
    }
}
