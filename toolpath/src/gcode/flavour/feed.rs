//! What a feed per minute is of, and whether it can say how long a move takes.

use super::data::FeedOf;
use crate::gcode::text::steps;

/// How a controller counts an axis for its feed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Class {
    /// X, Y, Z.
    Primary,
    /// Other axes that slide: U, V, W.
    Secondary,
    /// Axes that turn.
    Rotary,
    /// `E`: counts where nothing else moves.
    Extruder,
}

impl Class {
    pub fn of_axis(letter: char, is_rotary: bool) -> Class {
        match letter {
            _ if is_rotary => Class::Rotary,
            'X' | 'Y' | 'Z' => Class::Primary,
            _ => Class::Secondary,
        }
    }

    /// Of an extruder that is an axis with this word. Controllers go by the letter.
    pub fn of_extruder(word: &str) -> Class {
        match word.as_bytes().first().map(u8::to_ascii_uppercase) {
            Some(b'A' | b'B' | b'C') => Class::Rotary,
            Some(b'U' | b'V' | b'W') => Class::Secondary,
            _ => Class::Extruder,
        }
    }
}

/// A way of one axis, in the units of the file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub class: Class,
    pub by: f64,
    pub is_extruder: bool,
}

/// The length of a move as the controller measures it; 0 where its feed says nothing.
pub(super) fn length(of: FeedOf, parts: impl Iterator<Item = Part>) -> f64 {
    let (mut squares, mut largest, mut all) = ([0.0f64; 4], 0.0f64, 0.0f64);
    for part in parts {
        squares[part.class as usize] += part.by * part.by;
        if part.class != Class::Primary {
            largest = largest.max(part.by.abs());
        }
        if !part.is_extruder {
            all += part.by * part.by;
        }
    }
    let [primary, secondary, rotary, extruder] = squares.map(f64::sqrt);
    match of {
        FeedOf::LinearFirst => [primary, secondary, rotary, extruder].into_iter().find(|&way| way > 0.0).unwrap_or(0.0),
        FeedOf::LinearThenLargest if primary > 0.0 => primary,
        FeedOf::LinearThenLargest => largest,
        FeedOf::LinearOnly => primary,
        FeedOf::AllAxes if all > 0.0 => all.sqrt(),
        FeedOf::AllAxes => extruder.max(secondary).max(rotary),
    }
}

/// How far the time of a move may be off because its feed is rounded: as a share.
const ROUNDED: f64 = 1e-3;

/// The feed per minute in steps of its last digit, and whether it says the time of the move: not where it is 0, too large, or has too few digits.
pub(super) fn per_minute(length: f64, seconds: f64, max: f64, decimals: usize) -> (i64, bool) {
    let feed = 60.0 * length / seconds;
    // A feed of 0 would never arrive.
    let written = steps(feed.min(max), decimals).max(1);
    let unit = 10f64.powi(-(decimals as i32));
    let says = feed <= max && (written as f64 * unit - feed).abs() <= ROUNDED * feed;
    (written, says)
}

#[cfg(test)]
mod tests {
    use super::super::data::FeedOf::{AllAxes, LinearFirst, LinearOnly, LinearThenLargest};
    use super::{Class, Part, length, per_minute};

    #[test]
    fn lengths_are_those_of_the_manuals() {
        let part = |class, by| Part { class, by, is_extruder: false };
        let feed = |by| Part { class: Class::Extruder, by, is_extruder: true };
        let all = [part(Class::Primary, 3.0), part(Class::Primary, 4.0), part(Class::Rotary, -12.0), feed(90.0)];
        let turn = [part(Class::Rotary, 6.0), part(Class::Rotary, -8.0), feed(9.0)];
        let slide = [part(Class::Secondary, -2.0), part(Class::Rotary, 6.0), feed(0.5)];
        let cases = [
            (LinearFirst, [5.0, 10.0, 2.0, 9.0]),
            (LinearThenLargest, [5.0, 9.0, 6.0, 9.0]),
            (LinearOnly, [5.0, 0.0, 0.0, 0.0]),
            (AllAxes, [13.0, 10.0, 40f64.sqrt(), 9.0]),
        ];
        for (of, expected) in cases {
            let moves: [&[Part]; 4] = [&all, &turn, &slide, &[feed(-9.0)]];
            for (parts, expected) in moves.into_iter().zip(expected) {
                assert!((length(of, parts.iter().copied()) - expected).abs() < 1e-12, "{of:?} {parts:?}");
            }
        }
        // An extruder by the name of an axis is one.
        let as_axis = |by| Part { class: Class::of_extruder("A"), by, is_extruder: true };
        assert!((length(LinearFirst, [part(Class::Rotary, 3.0), as_axis(4.0)].into_iter()) - 5.0).abs() < 1e-12);
        assert!((length(AllAxes, [part(Class::Rotary, 3.0), as_axis(4.0)].into_iter()) - 3.0).abs() < 1e-12);
        assert_eq!([Class::of_extruder("u=IC("), Class::of_extruder("E")], [Class::Secondary, Class::Extruder]);
    }

    #[test]
    fn feeds_say_the_time_or_that_they_do_not() {
        assert_eq!(per_minute(10.0, 2.0, 1e6, 3), (300_000, true));
        assert_eq!(per_minute(0.0, 2.0, 1e6, 3), (1, false));
        assert_eq!(per_minute(1e-5, 2.0, 1e6, 3), (1, false));
        assert_eq!(per_minute(1.0, 1e-4, 1e5, 0), (100_000, false));
        assert_eq!(per_minute(2.51 / 60.0, 1.0, 1e5, 0), (3, false));
        assert_eq!(per_minute(2500.6 / 60.0, 1.0, 1e5, 0), (2501, true));
    }
}
