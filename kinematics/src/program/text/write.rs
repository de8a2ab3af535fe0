//! Numbers and words on their way into a file: one buffer, no allocation a number.

/// Powers of ten up to the most decimals that a format here writes.
const POWERS: [f64; 10] = [1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9];

/// A line, or a few, not yet written.
#[derive(Debug, Default)]
pub(crate) struct Text(pub Vec<u8>);

impl Text {
    pub fn word(&mut self, word: &str) -> &mut Self {
        self.0.extend_from_slice(word.as_bytes());
        self
    }

    /// A number to the nearest multiple of `10^-decimals`, without zeros at its end. What reaches this has passed the
    /// checks, so it is finite and below 1e8, and its multiple has less than 18 digits.
    pub fn fixed(&mut self, value: f64, decimals: usize) -> &mut Self {
        let scaled = (value * POWERS[decimals]).round() as i64;
        if scaled < 0 {
            self.0.push(b'-');
        }
        let (mut rest, mut left) = (scaled.unsigned_abs(), decimals);
        while left > 0 && rest.is_multiple_of(10) {
            (rest, left) = (rest / 10, left - 1);
        }
        // From the last digit to the first.
        let mut digits = [b'0'; 24];
        let mut at = digits.len();
        let mut put = |digit: u8| {
            at -= 1;
            digits[at] = digit;
        };
        for _ in 0..left {
            put(b'0' + (rest % 10) as u8);
            rest /= 10;
        }
        if left > 0 {
            put(b'.');
        }
        loop {
            put(b'0' + (rest % 10) as u8);
            rest /= 10;
            if rest == 0 {
                break;
            }
        }
        self.0.extend_from_slice(&digits[at..]);
        self
    }

    /// `[a,b,c]`.
    pub fn list(&mut self, values: &[f64], decimals: usize) -> &mut Self {
        for (k, &value) in values.iter().enumerate() {
            self.0.push(if k == 0 { b'[' } else { b',' });
            self.fixed(value, decimals);
        }
        self.0.push(b']');
        self
    }
}

#[cfg(test)]
mod tests {
    use super::Text;

    #[test]
    fn fixed_numbers_are_those_of_the_standard_library() {
        for value in [0.0, -0.0, 1.0, -1.0, 12.5, -0.00004, 0.00005, 999_999.999_95, -123.456_789, 1e-9, 90.0, 100.0] {
            for decimals in 0..=9 {
                let mut text = Text::default();
                text.fixed(value, decimals);
                let ours: f64 = std::str::from_utf8(&text.0).unwrap().parse().unwrap();
                let theirs: f64 = format!("{value:.decimals$}").parse().unwrap();
                // A tie may go either way.
                let step = 10f64.powi(-(decimals as i32));
                assert!((ours - theirs).abs() < 1.01 * step && (ours - value).abs() <= 0.5001 * step, "{value}");
                assert!(!text.0.ends_with(b".") && (!text.0.contains(&b'.') || !text.0.ends_with(b"0")), "{value}");
            }
        }
        let mut text = Text::default();
        text.list(&[-0.00004, 100.0, 0.05, -7.25], 4);
        assert_eq!(text.0, b"[0,100,0.05,-7.25]");
    }
}
