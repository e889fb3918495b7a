//! Where a quantity vanishes that decreases along a motion: from a few values that are exact, and more that are rough.

use crate::number::Number;

/// How many rough values on either side of the zero a polynomial goes through.
const SIDE: usize = 4;

/// How many exact values inverse interpolation goes through.
const FEW: usize = 4;

/// The part of the way to the zero of rough values that is gone first: from just before it steps are short, and cost little.
const FIRST: f64 = 0.99;

/// Values over time.
#[derive(Clone, Debug)]
pub(crate) struct Zero<R> {
    rough: Vec<(f64, f64)>,
    exact: Vec<(R, R)>,
}

impl<R: Number> Zero<R> {
    /// From rough values, in order of time. Those next to where they become negative are kept.
    pub(crate) fn near(mut rough: Vec<(f64, f64)>) -> Self {
        let after = rough.iter().position(|(_, value)| *value < 0.0).unwrap_or(0);
        rough.truncate(after + SIDE);
        rough.drain(..after.saturating_sub(SIDE));
        Self { rough, exact: Vec::new() }
    }

    /// Takes a value that is exact.
    pub(crate) fn put(&mut self, time: R, value: R) {
        self.exact.push((time, value));
    }

    /// When the quantity vanishes, as far as it is known. `None` where values tell nothing.
    pub(crate) fn time(&self) -> Option<R> {
        match self.exact.as_slice() {
            [] => Some(R::from_f64(FIRST * self.crossing()?)),
            [(time, value)] => {
                let (slope, value) = (self.slope(time.to_f64())?, value.to_f64());
                let rough = time.to_f64() - value / slope;
                // The slope on the way.
                let slope = self.slope((time.to_f64() + rough) / 2.0)?;
                Some(*time - R::from_f64(value / slope))
            }
            all => inverse(all.get(all.len().saturating_sub(FEW)..)?),
        }
    }

    /// Neville's polynomial through the rough values.
    fn value(&self, time: f64) -> f64 {
        let mut row: Vec<f64> = self.rough.iter().map(|(_, value)| *value).collect();
        for width in 1..row.len() {
            for i in 0..row.len() - width {
                let (from, to) = (self.rough[i].0, self.rough[i + width].0);
                row[i] = ((to - time) * row[i] + (time - from) * row[i + 1]) / (to - from);
            }
        }
        row.first().copied().unwrap_or(f64::NAN)
    }

    fn slope(&self, time: f64) -> Option<f64> {
        let by = 1e-3 * (self.rough.last()?.0 - self.rough.first()?.0);
        let slope = (self.value(time + by) - self.value(time - by)) / (2.0 * by);
        (slope < 0.0).then_some(slope)
    }

    /// Where the polynomial crosses zero, by halving.
    fn crossing(&self) -> Option<f64> {
        let after = self.rough.iter().position(|(_, value)| *value < 0.0)?;
        let (mut low, mut high) = (self.rough.get(after.checked_sub(1)?)?.0, self.rough[after].0);
        for _ in 0..40 {
            let middle = (low + high) / 2.0;
            if self.value(middle) < 0.0 { high = middle } else { low = middle }
        }
        Some(low)
    }
}

/// The time at value zero of the polynomial of times over values, by Neville. `None` where two values are the same.
fn inverse<R: Number>(all: &[(R, R)]) -> Option<R> {
    let mut row: Vec<R> = all.iter().map(|(time, _)| *time).collect();
    for width in 1..row.len() {
        for i in 0..row.len() - width {
            let (from, to) = (all[i].1, all[i + width].1);
            if (to - from).is_nothing() {
                return None;
            }
            row[i] = (to * row[i] - from * row[i + 1]) / (to - from);
        }
    }
    row.first().copied()
}

#[cfg(test)]
mod tests {
    use super::Zero;
    use crate::number::{Number, is_finite};
    use pintle_kinematics::scalar::{Real, Wide};

    /// cos t vanishes at π/2: from values that are off by 1e-5, in how many exact ones, on doubles and on 237 bits.
    fn found<R: Number + Real>(cosine: impl Fn(R) -> R, half: R, error: f64) -> usize {
        let rough =
            (0..=8).map(|i| (0.25 * f64::from(i), (0.25 * f64::from(i)).cos() + 1e-5 * f64::from(i % 3 - 1)));
        let mut zero: Zero<R> = Zero::near(rough.collect());
        for count in 0..12 {
            let time = zero.time().unwrap();
            assert!(is_finite(time));
            if (time - half).magnitude().to_f64() < error {
                return count;
            }
            zero.put(time, cosine(time));
        }
        12
    }

    #[test]
    fn few_values_find_a_zero() {
        let half = |pi: f64| pi / 2.0;
        assert!(found::<f64>(f64::cos, half(std::f64::consts::PI), 1e-15) <= 4);
        let wide = Wide::pi() / Wide::from_f64(2.0);
        assert!(found::<Wide>(|x| x.cos(), wide, 1e-60) <= 6);
    }
}
