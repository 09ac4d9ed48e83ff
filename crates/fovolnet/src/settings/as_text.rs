//! Serialises optional settings as text.

use serde::{Deserialize, Deserializer, Serializer, de::Error};
use std::fmt::Display;
use std::str::FromStr;

pub fn serialize<T: Display, S: Serializer>(value: &Option<T>, to: S) -> Result<S::Ok, S::Error> {
    match value {
        Some(v) => to.collect_str(v),
        None => to.serialize_none(),
    }
}

pub fn deserialize<'de, T: FromStr<Err = String>, D: Deserializer<'de>>(
    from: D,
) -> Result<Option<T>, D::Error> {
    let text = Option::<String>::deserialize(from)?;
    text.map(|t| t.parse().map_err(D::Error::custom)).transpose()
}
