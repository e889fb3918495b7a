//! Choices: parameters and items that take one of a few words.

/// A closed set of words, with the spelling of each in a deck.
pub trait Choice: Copy + PartialEq + 'static {
    /// Every value, in the order of [`SPELLINGS`](Self::SPELLINGS).
    const ALL: &'static [Self];
    /// The spellings, in upper case, words separated by one blank.
    const SPELLINGS: &'static [&'static str];

    /// How a deck spells it.
    fn spelling(self) -> &'static str {
        let place = Self::ALL.iter().position(|choice| *choice == self);
        place.and_then(|place| Self::SPELLINGS.get(place)).copied().unwrap_or_default()
    }

    /// The value of that spelling, in upper case.
    fn of_spelling(spelling: &str) -> Option<Self> {
        let place = Self::SPELLINGS.iter().position(|known| *known == spelling)?;
        Self::ALL.get(place).copied()
    }
}

/// Enumerations of words: each variant stands beside its spelling in a deck, and serialises in lower case with
/// underscores.
macro_rules! choices {
    ($(
        $(#[$meta:meta])*
        pub enum $name:ident { $($(#[$variant_meta:meta])* $variant:ident = $spelling:literal,)+ }
    )+) => {$(
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[serde(rename_all = "snake_case")]
        pub enum $name {
            $($(#[$variant_meta])* #[doc = concat!(" A deck says `", $spelling, "`.")] $variant,)+
        }

        impl $crate::choice::Choice for $name {
            const ALL: &'static [Self] = &[$(Self::$variant),+];
            const SPELLINGS: &'static [&'static str] = &[$($spelling),+];
        }
    )+};
}

pub(crate) use choices;

#[cfg(test)]
mod tests {
    use super::Choice;
    use crate::{AmplitudeDefinition, HardeningDefinition, Operator};
    use std::collections::BTreeSet;

    fn distinct<C: Choice + std::fmt::Debug>() {
        assert_eq!(C::ALL.len(), C::SPELLINGS.iter().collect::<BTreeSet<_>>().len());
        for choice in C::ALL {
            assert_eq!(C::of_spelling(choice.spelling()), Some(*choice));
        }
        assert_eq!(C::of_spelling("no such word"), None);
    }

    #[test]
    fn spellings_lead_back() {
        distinct::<AmplitudeDefinition>();
        distinct::<HardeningDefinition>();
        distinct::<Operator>();
    }
}
