//! Whole numbers in sentences.

use std::fmt::Display;

/// A whole number with its thousands apart, such as `95,905`.
pub fn grouped(number: impl Display) -> String {
    let digits = number.to_string();
    let comma = |(at, digit): (usize, char)| {
        let before = (at > 0 && (digits.len() - at).is_multiple_of(3)).then_some(',');
        before.into_iter().chain([digit])
    };
    digits.chars().enumerate().flat_map(comma).collect()
}

/// A whole number of things whose plural ends in an `s`: `1 piece`, `2 pieces`, `0 pieces`.
pub fn counted(number: impl Display, what: &str) -> String {
    let number = grouped(number);
    let end = if number == "1" { "" } else { "s" };
    format!("{number} {what}{end}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_thing_has_no_plural() {
        assert_eq!(
            [0, 1, 2, 11].map(|number| counted(number, "piece")),
            ["0 pieces", "1 piece", "2 pieces", "11 pieces"]
        );
    }

    /// The slow way: by division.
    #[test]
    fn thousands_are_apart() {
        let slow = |number: u64| match (number / 1_000_000, number / 1000 % 1000, number % 1000) {
            (0, 0, ones) => ones.to_string(),
            (0, thousands, ones) => format!("{thousands},{ones:03}"),
            (millions, thousands, ones) => format!("{millions},{thousands:03},{ones:03}"),
        };
        for number in (0..2_000_000).step_by(37).chain([999, 1000, 999_999, 1_000_000, 999_999_999]) {
            assert_eq!(grouped(number), slow(number));
        }
    }
}
