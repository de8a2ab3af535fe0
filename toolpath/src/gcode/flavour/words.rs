//! Words with numbers, signs and points as a flavour wants them.

use super::data::Flavour;
use crate::gcode::text::Text;

/// Numbers that a word may have: what writers that keep to the ranges of a move can reach.
pub(super) const NUMBER: [f64; 2] = [-1e9, 1e9];

/// A coordinate: ` X+10.5`.
pub(super) fn push(text: &mut Text, word: &str, count: i64, decimals: usize, flavour: &Flavour) {
    text.word(" ").word(word);
    if flavour.numbers.plus && count >= 0 {
        text.word("+");
    }
    digits(text, count, decimals, flavour);
}

/// A number without a sign of its own: ` F1200`.
pub(super) fn push_plain(text: &mut Text, word: &str, count: i64, decimals: usize, flavour: &Flavour) {
    text.word(" ").word(word);
    digits(text, count, decimals, flavour);
}

fn digits(text: &mut Text, count: i64, decimals: usize, flavour: &Flavour) {
    let start = text.0.len();
    text.steps(count, decimals);
    if flavour.numbers.point && !text.0[start..].contains(&b'.') {
        text.word(".");
    }
}
