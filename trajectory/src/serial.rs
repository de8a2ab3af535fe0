//! Arrays and limits in files. An array is a list of its length, and `null` stands for no limit.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Lists of `N`.
pub(crate) mod array {
    use super::{Deserialize, Deserializer, Error, Serialize, Serializer};

    pub(crate) fn serialize<T: Serialize, S: Serializer, const N: usize>(
        list: &[T; N],
        to: S,
    ) -> Result<S::Ok, S::Error> {
        list.as_slice().serialize(to)
    }

    pub(crate) fn deserialize<'de, T: Deserialize<'de>, D: Deserializer<'de>, const N: usize>(
        from: D,
    ) -> Result<[T; N], D::Error> {
        of_list(Vec::deserialize(from)?)
    }

    pub(crate) fn of_list<T, E: Error, const N: usize>(list: Vec<T>) -> Result<[T; N], E> {
        let count = list.len();
        list.try_into().map_err(|_| E::custom(format_args!("a list of {count}, but {N} belong here")))
    }
}

/// Lists of `N`, or none.
pub(crate) mod optional_array {
    use super::{Deserialize, Deserializer, Serialize, Serializer, array};

    pub(crate) fn serialize<S: Serializer, const N: usize>(list: &Option<[f64; N]>, to: S) -> Result<S::Ok, S::Error> {
        list.as_ref().map(|list| list.as_slice()).serialize(to)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>, const N: usize>(
        from: D,
    ) -> Result<Option<[f64; N]>, D::Error> {
        Option::<Vec<f64>>::deserialize(from)?.map(array::of_list).transpose()
    }
}

/// Any number of lists of `N`.
pub(crate) mod arrays {
    use super::{Deserialize, Deserializer, Serializer, array};

    pub(crate) fn serialize<S: Serializer, const N: usize>(lists: &[[f64; N]], to: S) -> Result<S::Ok, S::Error> {
        to.collect_seq(lists.iter().map(|list| list.as_slice()))
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>, const N: usize>(from: D) -> Result<Vec<[f64; N]>, D::Error> {
        Vec::<Vec<f64>>::deserialize(from)?.into_iter().map(array::of_list).collect()
    }
}

/// A number that may be infinite.
pub(crate) mod limit {
    use super::{Deserialize, Deserializer, Serialize, Serializer};

    pub(crate) fn serialize<S: Serializer>(value: &f64, to: S) -> Result<S::Ok, S::Error> {
        Some(*value).filter(|value| *value < f64::INFINITY).serialize(to)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
        Ok(Option::deserialize(from)?.unwrap_or(f64::INFINITY))
    }
}

/// `N` of them.
pub(crate) mod limits {
    use super::{Deserialize, Deserializer, Serializer, array};

    pub(crate) fn serialize<S: Serializer, const N: usize>(limits: &[f64; N], to: S) -> Result<S::Ok, S::Error> {
        to.collect_seq(limits.iter().map(|limit| Some(limit).filter(|limit| limit.is_finite())))
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>, const N: usize>(from: D) -> Result<[f64; N], D::Error> {
        read(from, f64::INFINITY)
    }

    pub(super) fn read<'de, D: Deserializer<'de>, const N: usize>(from: D, none: f64) -> Result<[f64; N], D::Error> {
        let limits = Vec::<Option<f64>>::deserialize(from)?;
        array::of_list(limits.into_iter().map(|limit| limit.unwrap_or(none)).collect())
    }
}

/// `N` of them, below.
pub(crate) mod lower_limits {
    use super::{Deserializer, limits};

    pub(crate) use super::limits::serialize;

    pub(crate) fn deserialize<'de, D: Deserializer<'de>, const N: usize>(from: D) -> Result<[f64; N], D::Error> {
        limits::read(from, f64::NEG_INFINITY)
    }
}
