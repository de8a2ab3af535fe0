//! Text: what the formats share. `write` puts numbers and words into a buffer, `tokens` takes them from a file, `names` knows which names a
//! controller takes, `angles` turns rotations into three angles and back.

pub(crate) mod angles;
pub(crate) mod names;
pub(crate) mod tokens;
mod write;

pub(crate) use write::Text;
