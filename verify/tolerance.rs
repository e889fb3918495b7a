//! Every tolerance of the tests, in one table, with the cause of the odd ones.

/// What a law allows.
pub(crate) struct Law {
    /// Its name.
    pub(crate) name: &'static str,
    /// In units u = 2⁻⁵³ of the scale that the law states.
    pub(crate) units: f64,
}

const fn law(name: &'static str, units: f64) -> Law {
    Law { name, units }
}

/// Laws of the catalogue (`verify/laws.rs`), in roundings of the conditioned scale of what is compared.
pub(crate) const LAWS: &[Law] = &[
    law("value", 4.0),
    law("first derivatives", 4.0),
    law("second derivatives", 4.0),
    law("symmetry", 2.0),
    law("rigid modes", 4.0),
    law("rigid rotations, second order", 4.0),
    law("rigid motion, values", 8.0),
    law("rigid motion, rates", 8.0),
    // The inputs are turned by a rounded matrix: three roundings in each direction of each triad.
    law("frames, values", 16.0),
    law("frames, rows", 16.0),
    law("frames, second derivatives", 16.0),
    law("rates from rows", 4.0),
    law("rates in time", 4.0),
    // B₀ = A₀Q₀ is itself a rounded product, of a rounded A₀.
    law("initial residuals", 8.0),
    law("exchanged nodes, values", 4.0),
    law("exchanged nodes, rows", 4.0),
    law("angles along paths", 8.0),
    law("accumulated turns", 4.0),
];
