//! What a file has that is not drawn: by kind and reason, with the places of the first.

use std::collections::BTreeMap;
use std::fmt;

/// Entities of a file that are not drawn, of one kind and for one reason.
/// ```
/// use curvlay_toolpath::drawing::Skipped;
/// let skipped = Skipped { what: "TEXT".to_owned(), count: 2, places: vec!["line 8".to_owned()] };
/// assert_eq!(skipped.to_string(), "2 TEXT: line 8, ...");
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Skipped {
    /// Their kind and, in brackets, why they are not drawn: `TEXT`, `CIRCLE (its radius is 0)`.
    pub what: String,
    /// How many there are, those of blocks as often as they are inserted.
    pub count: usize,
    /// Where the first of them are: `line 12 (handle 2F)`, `byte 812`, `id rect7`.
    pub places: Vec<String>,
}

/// Places that are kept of one kind.
const MAX_PLACES: usize = 5;

/// Kinds that are kept apart: more are counted as one, so that a message remains one.
const MAX_KINDS: usize = 50;

/// Longest description of a kind, in characters.
const MAX_LENGTH: usize = 120;

/// Counts from here on are those of blocks that insert each other; their digits say nothing.
const MANY: usize = 1_000_000;

impl fmt::Display for Skipped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.count {
            MANY.. => write!(f, "more than {MANY} {}", self.what)?,
            count => write!(f, "{count} {}", self.what)?,
        }
        match self.places.join(", ") {
            places if places.is_empty() => Ok(()),
            places if self.count > self.places.len() => write!(f, ": {places}, ..."),
            places => write!(f, ": {places}"),
        }
    }
}

/// Collects what is not drawn.
#[derive(Clone, Debug, Default)]
pub(super) struct Skips {
    kinds: BTreeMap<String, (usize, Vec<String>)>,
}

impl Skips {
    /// One more of a kind. Bytes that a terminal would obey, and what is too long, are left out of its description.
    pub fn add(&mut self, what: &str, place: String) {
        self.add_all(&printable(what), 1, &[place]);
    }

    /// All of another collection, so many times.
    pub fn add_times(&mut self, other: &Skips, times: usize) {
        for (what, (count, places)) in &other.kinds {
            self.add_all(what, count.saturating_mul(times), places);
        }
    }

    fn add_all(&mut self, what: &str, count: usize, places: &[String]) {
        let what = if self.kinds.contains_key(what) || self.kinds.len() < MAX_KINDS { what } else { "others" };
        let (total, kept) = self.kinds.entry(what.to_owned()).or_default();
        *total = total.saturating_add(count);
        for place in places {
            if kept.len() < MAX_PLACES && !place.is_empty() && !kept.contains(place) {
                kept.push(place.clone());
            }
        }
    }

    pub fn is_empty(&self) -> bool {
        self.kinds.is_empty()
    }

    /// By name.
    pub fn into_list(self) -> Vec<Skipped> {
        let skipped = |(what, (count, places))| Skipped { what, count, places };
        self.kinds.into_iter().filter(|(_, (count, _))| *count > 0).map(skipped).collect()
    }
}

/// A text of a file as a message can hold it.
pub(super) fn printable(text: &str) -> String {
    let mut out: String = text.chars().filter(|c| !c.is_control()).take(MAX_LENGTH).collect();
    if text.chars().nth(MAX_LENGTH).is_some() {
        out += "...";
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_and_places_are_bounded() {
        let mut skips = Skips::default();
        for k in 0..200 {
            skips.add(&format!("KIND{k:03}"), format!("line {k}"));
            skips.add("TEXT\u{1b}[2J", format!("line {k}"));
        }
        let mut twice = Skips::default();
        twice.add_times(&skips, 2);
        let list = twice.into_list();
        assert_eq!(list.len(), MAX_KINDS + 1);
        assert_eq!(list.iter().map(|skipped| skipped.count).sum::<usize>(), 800);
        assert!(list.iter().all(|skipped| skipped.places.len() <= MAX_PLACES));
        assert!(list.iter().any(|skipped| skipped.what == "TEXT[2J" && skipped.count == 400));
    }
}
