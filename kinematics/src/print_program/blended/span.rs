//! How far a move may go.

/// The ends of moves through `0..count` samples: each move goes from its start to the farthest sample that was found to fit; to the next one in any case.
///
/// The first try goes one sample on, each next one twice as far; then the span between the last that fits and the first that does not is halved. What is
/// taken has been tried itself, whether or not all that is nearer fits.
///
/// # Cost
/// `O(log n)` tries a move.
pub(super) fn spans(count: usize, fits: impl Fn(usize, usize) -> bool) -> Vec<usize> {
    let mut ends: Vec<usize> = (count > 0).then_some(0).into_iter().collect();
    let mut from = 0;
    while from + 1 < count {
        from = farthest(from, count - 1, &fits);
        ends.push(from);
    }
    ends
}

fn farthest(from: usize, last: usize, fits: &impl Fn(usize, usize) -> bool) -> usize {
    let (mut good, mut step) = (from + 1, 2);
    let mut bad = loop {
        if good == last {
            return last;
        }
        let next = (from + step).min(last);
        if !fits(from, next) {
            break next;
        }
        (good, step) = (next, step * 2);
    };
    while good + 1 < bad {
        let middle = good + (bad - good) / 2;
        if fits(from, middle) {
            good = middle;
        } else {
            bad = middle;
        }
    }
    good
}

#[cfg(test)]
mod tests {
    use super::spans;

    /// Where all that is nearer fits as well, the farthest is found, as by trying all.
    #[test]
    fn finds_the_farthest() {
        for most in 1..9 {
            for count in 0..40 {
                let found = spans(count, |from, to| to - from <= most);
                let slow: Vec<usize> =
                    (0..count).step_by(most).chain((count > 1 && (count - 1) % most > 0).then(|| count - 1)).collect();
                assert_eq!(found, slow, "{most} {count}");
            }
        }
        assert_eq!(spans(4, |_, _| false), [0, 1, 2, 3]);
    }
}
