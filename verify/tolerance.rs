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
    law("value", 16.0),
    law("first derivatives", 16.0),
    law("second derivatives", 16.0),
];
