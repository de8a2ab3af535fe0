//! Numbers and words on their way into a file: one buffer, no allocation a number.

/// A number as a count of `10^-decimals`, the nearest one. What reaches this has passed the checks: it is finite and
/// its count has less than 18 digits.
pub(super) fn steps(value: f64, decimals: usize) -> i64 {
    const POWERS: [f64; 9] = [1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8];
    (value * POWERS[decimals]).round() as i64
}

/// Lines that are not yet written.
#[derive(Debug, Default)]
pub(super) struct Text(pub Vec<u8>);

impl Text {
    pub fn word(&mut self, word: &str) -> &mut Self {
        self.0.extend_from_slice(word.as_bytes());
        self
    }

    /// A word and its number, to the nearest multiple of `10^-decimals`.
    pub fn number(&mut self, word: &str, value: f64, decimals: usize) -> &mut Self {
        self.word(word).steps(steps(value, decimals), decimals)
    }

    /// A word and a whole number.
    pub fn steps_of(&mut self, word: &str, count: i64) -> &mut Self {
        self.word(word).steps(count, 0)
    }

    /// A count of `10^-decimals`, without zeros at its end.
    pub fn steps(&mut self, count: i64, decimals: usize) -> &mut Self {
        let (mut rest, mut left) = (count.unsigned_abs(), decimals);
        while left > 0 && rest.is_multiple_of(10) {
            (rest, left) = (rest / 10, left - 1);
        }
        // From the last digit to the first: 20 of a u64, point and sign.
        let mut digits = [b'0'; 22];
        let mut at = digits.len();
        let mut put = |byte: u8| {
            at -= 1;
            digits[at] = byte;
        };
        if left > 0 {
            for _ in 0..left {
                put(b'0' + (rest % 10) as u8);
                rest /= 10;
            }
            put(b'.');
        }
        loop {
            put(b'0' + (rest % 10) as u8);
            rest /= 10;
            if rest == 0 {
                break;
            }
        }
        if count < 0 {
            put(b'-');
        }
        self.0.extend_from_slice(&digits[at..]);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::Text;

    #[test]
    fn numbers_are_those_of_the_standard_library() {
        for value in [0.0, -0.0, 1.0, -1.0, 12.5, -0.00004, 0.000051, 999_999.999_96, -123.456_789, 1e-9, 90.0, 1e6] {
            for decimals in 0..=6 {
                let mut text = Text::default();
                text.number("", value, decimals);
                let ours = String::from_utf8(text.0).unwrap();
                let mut theirs = format!("{value:.decimals$}");
                if theirs.contains('.') {
                    theirs.truncate(theirs.trim_end_matches('0').trim_end_matches('.').len());
                }
                let theirs = if theirs == "-0" { "0".to_owned() } else { theirs };
                // A tie may go either way.
                let tie = (value * 10f64.powi(decimals as i32)).abs().fract();
                assert!(ours == theirs || (tie - 0.5).abs() < 1e-9, "{value}: {ours} {theirs}");
            }
        }
        let mut text = Text::default();
        text.steps(i64::MIN, 6).word(" ").steps(-5, 1).word(" ").steps(1200, 2);
        assert_eq!(text.0, b"-9223372036854.775808 -0.5 12");
    }
}
