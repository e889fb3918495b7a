//! How uncertain is a number that came of rounded ones?
//!
//! A number carries, besides its value s, its derivatives along four random directions of what it came of, in units of the relative
//! change. It came of the entries of the matrix, each by as much as it is uncertain, and of every rounding on the way. That is the
//! small-sample estimate of a condition (Kenney and Laub, 1994). By the root mean square n of the four, s changes when all of them
//! change by a relative amount of one. So |s|/n is the relative change that makes s zero. Amounts of u change a number that is zero
//! by u·n times a random number of Student's distribution with four degrees of freedom, which exceeds x with probability 6/x⁴ for
//! large x.
//!
//! Roundings must be told apart, each with directions of its own. Were those of two entries taken for one, they would cancel where the
//! entries are subtracted, and what rounding left would look certain.

use pintle_kinematics::draw::splitmix64;

/// By so many rounding units an entry is off that was computed: directions, levers, and what a deck was written from.
pub(crate) const COMPUTED: f64 = 1e3;
/// By so many rounding units of itself a coordinate is off.
pub(crate) const ROUNDED: f64 = 4.0;

/// The number of random directions.
const PROBES: usize = 4;
/// The number of random directions of roundings that are told apart.
const TABLE: usize = 1024;

/// Derivatives along random directions. They are narrow, for only their size counts.
pub(crate) type Probes = [f32; PROBES];

/// Of a number that is what it is.
pub(crate) const NONE: Probes = [0.0; PROBES];

/// Four random numbers, nearly normal: sums of four uniform ones.
pub(crate) fn random(seed: u64) -> Probes {
    std::array::from_fn(|i| {
        let bits = splitmix64(seed.wrapping_mul(PROBES as u64).wrapping_add(i as u64));
        let sum: i32 = (0..4).map(|part| i32::from((bits >> (16 * part)) as u16)).sum();
        (sum - 2 * 65_535) as f32 * (3.0_f32.sqrt() / 65_536.0)
    })
}

/// The root mean square, in doubles: squares of narrow numbers would overflow or vanish.
pub(crate) fn size(probes: &Probes) -> f64 {
    let sum: f64 = probes.iter().map(|probe| f64::from(*probe) * f64::from(*probe)).sum();
    (sum / PROBES as f64).sqrt()
}

/// Adds a multiple.
pub(crate) fn add(to: &mut Probes, times: f32, probes: &Probes) {
    for (sum, probe) in to.iter_mut().zip(probes) {
        *sum += times * probe;
    }
}

/// The directions of roundings.
pub(crate) struct Roundings {
    table: Vec<Probes>,
}

impl Roundings {
    pub(crate) fn new() -> Self {
        Self { table: (0..TABLE as u64).map(|k| random(splitmix64(k))).collect() }
    }

    /// That of one rounding; those of neighbouring numbers are not the same.
    pub(crate) fn of(&self, number: u64) -> &Probes {
        &self.table[(number % TABLE as u64) as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The directions are not biased, of size one, and those of neighbours not the same.
    #[test]
    fn directions_are_random() {
        let roundings = Roundings::new();
        let all: Vec<f64> = (0..TABLE as u64).flat_map(|k| roundings.of(k).map(f64::from)).collect();
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        let square = all.iter().map(|x| x * x).sum::<f64>() / all.len() as f64;
        let neighbours = all.iter().zip(&all[PROBES..]).map(|(x, y)| x * y).sum::<f64>() / all.len() as f64;
        // Of 4096 numbers: four standard deviations.
        assert!(mean.abs() < 4.0 / 64.0 && neighbours.abs() < 4.0 / 64.0, "{mean} {neighbours}");
        assert!((square - 1.0).abs() < 4.0 * 1.4 / 64.0, "{square}");
    }
}
