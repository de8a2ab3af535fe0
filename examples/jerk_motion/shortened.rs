//! Long lists, cut short for the report.

/// The list of what is wrong with the path.
pub const FAULTS: &str = "path-faults.txt";

/// Lines of a list that the report shows.
pub const MAX_LINES: usize = 12;

/// The first lines of what is wrong with the path, and the file that has the rest.
pub fn shortened(mut faults: Vec<String>) -> Vec<String> {
    let more = faults.len().saturating_sub(MAX_LINES);
    faults.truncate(MAX_LINES);
    faults.extend((more > 0).then(|| format!("{more} more like these in {FAULTS}")));
    faults
}
