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
    use crate::number::Number;
    use pintle_kinematics::scalar::Wide;

    /// How many exact values of 1 − x − x³ lead to its zero, from rough ones that are off by 1e-5.
    fn values_to_zero<R: Number>(error: f64) -> usize {
        let rough = (0..=8).map(|i| {
            let x = 0.125 * f64::from(i);
            (x, 1.0 - x - x.powi(3) + 1e-5 * f64::from(i % 3 - 1))
        });
        let mut zero: Zero<R> = Zero::near(rough.collect());
        for count in 1..20 {
            let x = zero.time().unwrap();
            let value = R::integer(1) - x - x * x * x;
            if value.magnitude().to_f64() < error {
                return count;
            }
            zero.put(x, value);
        }
        20
    }

    #[test]
    fn few_values_find_a_zero() {
        let (doubles, wide) = (values_to_zero::<f64>(1e-15), values_to_zero::<Wide>(1e-60));
        assert!(doubles <= 5 && wide <= 7, "{doubles} {wide}");
    }

    #[test]
    fn what_does_not_vanish_has_no_time() {
        let none: Zero<f64> = Zero::near(vec![(0.0, 1.0), (1.0, 2.0)]);
        assert_eq!(none.time(), None);
        let mut flat: Zero<f64> = Zero::near(vec![(0.0, 1.0), (1.0, -1.0)]);
        flat.put(0.5, 0.25);
        flat.put(0.6, 0.25);
        assert_eq!(flat.time(), None);
    }
}
