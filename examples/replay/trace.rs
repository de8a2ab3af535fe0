//! Curves and steps of a run of any length in constant memory: neighbours are joined when there are too many.

/// Most points of a curve; a plot is less than half as wide.
const MAX_POINTS: usize = 4000;
/// Most steps of the viewer: some 8 bytes of the page each.
const MAX_STEPS: usize = 60_000;

/// Values over time.
#[derive(Clone, Debug)]
pub struct Thinned<T> {
    kept: Vec<T>,
    most: usize,
    /// Values that become one.
    stride: u64,
    /// What is being joined, and of how many.
    open: Option<(T, u64)>,
    join: fn(&T, &T) -> T,
}

impl<T: Copy> Thinned<T> {
    /// Nothing yet; `join` makes one of two that follow each other.
    pub fn new(most: usize, join: fn(&T, &T) -> T) -> Self {
        Thinned { kept: Vec::new(), most: most.max(2), stride: 1, open: None, join }
    }

    /// Adds a value.
    pub fn push(&mut self, value: T) {
        let (joined, count) = match &self.open {
            Some((before, count)) => ((self.join)(before, &value), count + 1),
            None => (value, 1),
        };
        if count < self.stride {
            self.open = Some((joined, count));
            return;
        }
        self.open = None;
        self.kept.push(joined);
        if self.kept.len() >= self.most {
            let join = self.join;
            self.kept = self.kept.chunks(2).map(|pair| if let [a, b] = pair { join(a, b) } else { pair[0] }).collect();
            self.stride *= 2;
        }
    }

    /// What is left.
    pub fn finish(mut self) -> Vec<T> {
        self.kept.extend(self.open.take().map(|(value, _)| value));
        self.kept
    }
}

/// A curve of the greatest values over time.
pub fn curve() -> Thinned<[f64; 2]> {
    Thinned::new(MAX_POINTS, |a, b| [b[0], a[1].max(b[1])])
}

/// The steps of the viewer.
pub fn steps() -> Thinned<curvlay_examples::viewer::Step> {
    use curvlay_examples::viewer::Step;
    Thinned::new(MAX_STEPS, |a: &Step, b: &Step| {
        let kind = if b.kind == Step::TRAVEL { b.kind } else { a.kind.min(b.kind) };
        Step { seconds: a.seconds + b.seconds, kind, ..*b }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_greatest_and_the_last_stay() {
        let mut curve = curve();
        for k in 0..100_001u32 {
            let at = f64::from(k);
            curve.push([at, if k == 31_337 { 9.0 } else { 1.0 }]);
        }
        let points = curve.finish();
        assert!(points.len() <= MAX_POINTS && points.iter().filter(|point| point[1] > 8.0).count() == 1);
        assert!((points[points.len() - 1][0] - 100_000.0).abs() < 0.5);
        assert!(points.windows(2).all(|two| two[0][0] < two[1][0]));
    }
}
