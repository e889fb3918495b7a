//! Derivatives on a singular set: from below and from above.
//!
//! Where the two exist and differ, whatever lies between them may stand for the derivative there: of the elements of the
//! subdifferential the product reports the one of least norm. What lies outside matches neither side, and is wrong.

use pintle_kinematics::scalar::Wide;

/// What is formed of derivatives that do not exist.
const HIGHER: &str =
    "first derivatives have two sides there, or none: what is formed of them is judged by nobody";

/// Why a second difference is no second derivative, though it settles.
const BENT: &str =
    "second differences settle, and on another number in other directions: there is no second derivative";

/// Why a derivative of one sheet is none of the function.
const JUMPS: &str =
    "a derivative on one side only: beyond half a turn the rotation vector jumps to its opposite";

/// Quotients agree where they differ by less than this part of themselves or of their scale.
const AGREES: f64 = 1e-3;

/// Whether two quotients agree.
fn agree(x: Wide, y: Wide, scale: f64) -> bool {
    let size = x.abs().to_f64().max(y.abs().to_f64()).max(scale);
    (x - y).abs().to_f64() <= AGREES * size
}

/// Why quotients that settle are no derivatives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lacking {
    /// The state is off a singular set by rounding alone, where derivatives at fine steps are not those beyond.
    Beside,
    /// It is formed of derivatives that have two sides, or none.
    FormedOfNone,
    /// A second difference that depends on the directions of its steps.
    Bent,
    /// It is of one of two sheets, between which the function jumps.
    Jumps,
}

/// What both sides say of one derivative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sides {
    /// The difference quotients from below and from above.
    pub quotients: [Wide; 2],
    /// Whether they are derivatives: those of a jump, or of a root, grow without end as the step shrinks.
    pub exist: [bool; 2],
    /// Why those that settle are no derivatives.
    pub lacking: Option<Lacking>,
}

impl Sides {
    /// Two quotients that are derivatives.
    pub const fn known(quotients: [Wide; 2]) -> Self {
        Self { quotients, exist: [true; 2], lacking: None }
    }

    /// A derivative of the sheet that a value is on, at a state where rounding decides which one that is: what it must be, and no
    /// derivative of a function that jumps there.
    pub const fn of_sheet(derivative: Wide) -> Self {
        Self { exist: [true, false], lacking: Some(Lacking::Jumps), ..Self::known([derivative; 2]) }
    }

    /// From difference quotients from below and above: at half a fine step, at that step, and at a coarse one, far above the rounding of
    /// the state. They agree where they differ by less than thousandths of themselves or of `scale`. That of a jump or a root grows as
    /// the step shrinks, and is no derivative. A state that rounding alone holds off a singular set has one derivative at fine steps and
    /// another one beyond: which of them is meant nobody can say.
    pub fn of([half, fine, coarse]: [[Wide; 2]; 3], scale: f64) -> Self {
        let agree = |side: usize, other: &[Wide; 2]| agree(half[side], other[side], scale);
        let mut exist = [0, 1].map(|side| agree(side, &fine));
        let is_one = exist == [true; 2] && agree(0, &[half[1]; 2]);
        let is_beside = is_one && !(agree(0, &coarse) && agree(1, &coarse));
        if is_beside {
            exist = [false; 2];
        }
        Self { quotients: half, exist, lacking: is_beside.then_some(Lacking::Beside) }
    }

    /// Of a second difference, where one in other directions is known: the two of what has a second derivative agree.
    pub(super) fn in_other_directions(self, other: Wide, scale: f64) -> Self {
        if self.exist != [true; 2] || agree(self.quotients[0], other, scale) {
            return self;
        }
        Self { exist: [false; 2], lacking: Some(Lacking::Bent), ..self }
    }

    /// Of what is formed of derivatives that do not exist.
    pub const fn of_none(self) -> Self {
        Self { exist: [false; 2], lacking: Some(Lacking::FormedOfNone), ..self }
    }

    /// Of quotients that grow as steps shrink.
    pub const fn unsettled(self) -> Self {
        Self { exist: [false; 2], ..self }
    }

    /// The coarse step, in sizes of a degree of freedom.
    pub const COARSE: f64 = 1e-10;

    /// The same from a function, its value in place, and the size of what it moves along.
    pub fn along(still: Wide, moved: &[[Option<Wide>; 2]; 3], steps: &[Wide; 3], scale: f64) -> Option<Self> {
        let quotients = |n: usize| {
            let [behind, ahead] = moved[n];
            Some([(still - behind?) / steps[n], (ahead? - still) / steps[n]])
        };
        Some(Self::of([quotients(0)?, quotients(1)?, quotients(2)?], scale))
    }

    /// Whether there is no derivative, because the sides are further apart than twice a tolerance, or one has none.
    pub fn differ(&self, tolerance: f64) -> bool {
        self.exist != [true; 2] || self.gap() > 2.0 * tolerance
    }

    /// How far apart the quotients are.
    pub fn gap(&self) -> f64 {
        let [below, above] = self.quotients;
        (above - below).abs().to_f64()
    }

    /// Of what may stand for the derivative, what is nearest to a number: the interval between both sides, or the only one that
    /// has a derivative; the number itself where neither has.
    pub fn nearest(&self, got: f64) -> Wide {
        let [below, above] = self.quotients;
        let got = Wide::from_f64(got);
        match self.exist {
            [true, true] => {
                let (low, high) = if below < above { (below, above) } else { (above, below) };
                if got < low {
                    low
                } else if got > high {
                    high
                } else {
                    got
                }
            }
            [true, false] => below,
            [false, true] => above,
            [false, false] => got,
        }
    }

    /// The largest of a number and of the derivatives that there are on the sides, by magnitude.
    pub fn steepest(&self, number: f64) -> f64 {
        let there = self.quotients.iter().zip(self.exist).filter(|(_, exists)| *exists);
        there
            .map(|(quotient, _)| quotient.to_f64())
            .fold(number, |most, x| if x.abs() > most.abs() { x } else { most })
    }

    /// Why there are not two derivatives, one from each side; `None` where there are.
    pub const fn lack(&self) -> Option<&'static str> {
        match self.exist {
            [true, true] => None,
            _ if matches!(self.lacking, Some(Lacking::Jumps)) => Some(JUMPS),
            [true, false] => Some(
                "a derivative from below only: from above, difference quotients do not settle as steps shrink",
            ),
            [false, true] => Some(
                "a derivative from above only: from below, difference quotients do not settle as steps shrink",
            ),
            [false, false] => Some(match self.lacking {
                Some(Lacking::FormedOfNone) => HIGHER,
                Some(Lacking::Bent) => BENT,
                Some(Lacking::Beside) => {
                    "rounding alone holds the state off a singular set: the derivatives there and beyond differ"
                }
                _ => "no derivative from either side: difference quotients do not settle as steps shrink",
            }),
        }
    }

    /// The derivatives as doubles, not a number from a side that has none; `None` where neither has.
    pub fn to_f64(&self) -> Option<[f64; 2]> {
        let of = |side: usize| if self.exist[side] { self.quotients[side].to_f64() } else { f64::NAN };
        self.exist.contains(&true).then(|| [of(0), of(1)])
    }

    /// The smaller of the derivatives in magnitude, for the scale of rounding; 0 where there is none.
    pub fn least(&self) -> Wide {
        let of = [0, 1].map(|side| self.exist[side].then_some(self.quotients[side]));
        match of {
            [Some(below), Some(above)] if above.abs() < below.abs() => above,
            [Some(below), _] => below,
            [None, Some(above)] => above,
            [None, None] => Wide::from_f64(0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Lacking, Sides};
    use pintle_kinematics::scalar::Wide;

    fn wide(x: [f64; 2]) -> [Wide; 2] {
        x.map(Wide::from_f64)
    }

    #[test]
    fn what_lies_between_the_sides_may_stand() {
        let of = |half, fine, coarse, scale| Sides::of([half, fine, coarse].map(wide), scale);
        let kink = of([-1.0, 2.0], [-1.0, 2.0], [-1.0, 2.0], 0.0);
        assert!(kink.differ(1e-9) && kink.exist == [true; 2]);
        assert_eq!((kink.lack(), kink.to_f64()), (None, Some([-1.0, 2.0])));
        for (got, nearest) in [(-3.0, -1.0), (-1.0, -1.0), (0.5, 0.5), (2.0, 2.0), (2.5, 2.0)] {
            assert_eq!(kink.nearest(got).to_f64(), nearest, "{got}");
        }
        let smooth = of([2.0, 2.0 + 1e-12], [2.0, 2.0], [2.0, 2.0 + 1e-10], 0.0);
        assert!(!smooth.differ(1e-12) && smooth.differ(1e-13));
        // What bends has a coarse quotient of its own, far below its scale.
        assert!(!of([0.0, 0.0], [0.0, 0.0], [-1e-10, 1e-10], 1.0).differ(1e-12));
        // A jump above: the derivative from below is the only one.
        let jump = of([0.5, 2e25], [0.5, 1e25], [0.5, 1e10], 1.0);
        assert_eq!((jump.exist, jump.differ(1.0), jump.least().to_f64()), ([true, false], true, 0.5));
        assert_eq!([jump.nearest(7.0).to_f64(), jump.nearest(-7.0).to_f64()], [0.5, 0.5]);
        let [below, above] = jump.to_f64().unwrap_or([0.0; 2]);
        assert!(
            below == 0.5
                && above.is_nan()
                && jump.lack().is_some_and(|lack| lack.contains("from below only"))
        );
        let root = of([1.4e12, 1.4e12], [1e12, 1e12], [1e5, 1e5], 1.0);
        assert_eq!((root.exist, root.nearest(7.0).to_f64()), ([false; 2], 7.0));
        assert!(root.to_f64().is_none() && root.lack().is_some_and(|lack| lack.contains("either side")));
        // |x y| at the origin: 1 along x = y, −1 along x = −y.
        let settles = of([1.0, 1.0], [1.0, 1.0], [1.0, 1.0], 1.0);
        let bent = settles.in_other_directions(Wide::from_f64(-1.0), 1.0);
        assert_eq!(
            (bent.exist, bent.lacking, bent.nearest(0.0).to_f64()),
            ([false; 2], Some(Lacking::Bent), 0.0)
        );
        assert_eq!(settles.in_other_directions(Wide::from_f64(1.0 + 1e-15), 1.0), settles);
        // Off a kink by rounding: the same derivative on both sides, another one farther below.
        let near = of([1.0, 1.0], [1.0, 1.0], [-1.0, 1.0], 0.0);
        assert_eq!((near.exist, near.nearest(0.0).to_f64()), ([false; 2], 0.0));
        assert!(
            near.lacking == Some(Lacking::Beside)
                && near.lack().is_some_and(|lack| lack.contains("rounding"))
        );
    }
}
