//! What the outputs of all stages show in the same way.

use std::time::Duration;

/// A picture and the line under it.
pub type Picture = (String, Vec<u8>);

/// A time in words.
pub fn seconds(time: Duration) -> String {
    format!("{:.3} s", time.as_secs_f64())
}

/// Pictures as a report takes them.
pub fn borrowed(pictures: &[Picture]) -> Vec<(&str, &[u8])> {
    pictures.iter().map(|(caption, png)| (caption.as_str(), png.as_slice())).collect()
}
