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

/// A time as one says it: `34 min`, `2 h 05 min`.
pub fn duration(seconds: f64) -> String {
    let minutes = (seconds / 60.0).round() as u64;
    match (seconds, minutes / 60) {
        (seconds, 0) if seconds < 60.0 => format!("{seconds:.0} s"),
        (_, 0) => format!("{minutes} min"),
        (_, hours) => format!("{hours} h {:02} min", minutes % 60),
    }
}
