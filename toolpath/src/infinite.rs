//! Numbers in files that may be infinite: `null` stands for no limit.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

pub(crate) fn serialize<S: Serializer>(value: &f64, to: S) -> Result<S::Ok, S::Error> {
    Some(*value).filter(|value| *value < f64::INFINITY).serialize(to)
}

pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::INFINITY))
}

/// Two of them.
pub(crate) mod pair {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(crate) fn serialize<S: Serializer>(value: &[f64; 2], to: S) -> Result<S::Ok, S::Error> {
        value.map(|value| Some(value).filter(|value| *value < f64::INFINITY)).serialize(to)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<[f64; 2], D::Error> {
        let pair = <[Option<f64>; 2]>::deserialize(from)?;
        Ok(pair.map(|value| value.unwrap_or(f64::INFINITY)))
    }
}
