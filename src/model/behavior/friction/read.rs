//! Numbers of a friction as a file has them, refused where they make none.

use crate::behavior::friction::is_divisor;
use serde::de::Error;
use serde::{Deserialize, Deserializer};

/// s, +1 or −1.
pub(super) fn sign<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    let sign = f64::deserialize(from)?;
    if sign.abs() == 1.0 {
        Ok(sign)
    } else {
        Err(D::Error::custom(format!("a sign is 1 or -1, not {sign:e}")))
    }
}

/// A radius, positive, that can be divided by.
pub(super) fn radius<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    checked(f64::deserialize(from)?).map_err(D::Error::custom)
}

/// The same, or none.
pub(super) fn maybe_radius<'de, D: Deserializer<'de>>(from: D) -> Result<Option<f64>, D::Error> {
    Option::<f64>::deserialize(from)?.map(checked).transpose().map_err(D::Error::custom)
}

/// Components (from 0) with their radii.
pub(super) fn radii<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<(usize, f64)>, D::Error> {
    let all = Vec::<(usize, f64)>::deserialize(from)?;
    for (_, radius) in &all {
        checked(*radius).map_err(D::Error::custom)?;
    }
    Ok(all)
}

fn checked(radius: f64) -> Result<f64, String> {
    if is_divisor(radius) {
        Ok(radius)
    } else {
        Err(format!("a radius is a positive number, not {radius:e}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::behavior::friction::Tangential;

    #[test]
    fn numbers_that_make_no_friction_are_refused() {
        #[derive(Deserialize)]
        struct Written {
            #[serde(deserialize_with = "sign")]
            s: f64,
            #[serde(deserialize_with = "radius")]
            r: f64,
            #[serde(deserialize_with = "maybe_radius")]
            over: Option<f64>,
        }
        let read = |text: &str| serde_json::from_str::<Written>(text).map_err(|error| error.to_string());
        let sound = read(r#"{"s": -1.0, "r": 2.5, "over": null}"#).unwrap();
        assert_eq!((sound.s, sound.r, sound.over), (-1.0, 2.5, None));
        for (text, why) in [
            (r#"{"s": 0.0, "r": 2.5, "over": 1.0}"#, "a sign is 1 or -1, not 0e0"),
            (r#"{"s": 0.5, "r": 2.5, "over": 1.0}"#, "a sign is 1 or -1, not 5e-1"),
            (r#"{"s": 1.0, "r": 0.0, "over": 1.0}"#, "a radius is a positive number, not 0e0"),
            (r#"{"s": 1.0, "r": -2.0, "over": 1.0}"#, "a radius is a positive number, not -2e0"),
            (r#"{"s": 1.0, "r": 1e-320, "over": 1.0}"#, "a radius is a positive number, not 1e-320"),
            (r#"{"s": 1.0, "r": 1.0, "over": 0.0}"#, "a radius is a positive number, not 0e0"),
        ] {
            let error = read(text).err().unwrap();
            assert!(error.starts_with(why), "{text}: {error}");
        }
        let norm =
            |radius: f64| serde_json::from_value::<Tangential>(serde_json::json!({"Norm": [[3, radius]]}));
        assert!(norm(0.5).is_ok() && norm(0.0).is_err());
    }
}
