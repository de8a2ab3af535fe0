//! Speeds where pieces meet, over the moves that the controller knows ahead: it must be able to stop at the last of them.
//!
//! Backwards, the speed at the begin of a piece is what still gets down to that at its end; forwards, it is what the piece before reaches. The second pass is
//! made when a piece leaves, so each piece costs as many steps as speeds change behind it.

use super::law::Law;
use std::collections::VecDeque;

/// How fast a piece may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Its way, in seconds at programmed speeds.
    pub way: f64,
    /// Greatest speed, as a share of the programmed one.
    pub top: f64,
    /// Greatest change of it in a second.
    pub rate: f64,
}

#[derive(Debug)]
struct Planned<T> {
    pace: Pace,
    /// Square of the greatest speed at its begin that still stops in time.
    entry: f64,
    piece: T,
}

/// The pieces that are planned and not yet begun.
#[derive(Debug)]
pub struct Window<T> {
    pieces: VecDeque<Planned<T>>,
    /// Square of the speed at which the first of them begins.
    begin: f64,
    most: usize,
}

/// Speeds as good as equal: a relative change that ends the pass backwards.
const SAME: f64 = 1e-12;

impl<T> Window<T> {
    /// Nothing, at rest; `most` pieces are known ahead.
    pub fn new(most: usize) -> Self {
        Window { pieces: VecDeque::new(), begin: 0.0, most: most.max(1) }
    }

    /// Adds a piece, and gives those to `leave` that have to begin now.
    pub fn push(&mut self, pace: Pace, piece: T, leave: &mut impl FnMut(Law, T)) {
        let before = self.pieces.back().map_or(pace.top, |last| last.pace.top);
        let entry = (2.0 * pace.rate * pace.way).min(pace.top.min(before).powi(2));
        self.pieces.push_back(Planned { pace, entry, piece });
        for k in (0..self.pieces.len() - 1).rev() {
            let after = self.pieces[k + 1].entry;
            let before = k.checked_sub(1).map_or(f64::INFINITY, |k| self.pieces[k].pace.top);
            let Planned { pace, entry, .. } = &mut self.pieces[k];
            let found = (after + 2.0 * pace.rate * pace.way).min(pace.top.min(before).powi(2));
            if (found - *entry).abs() <= SAME * found {
                break;
            }
            *entry = found;
        }
        while self.pieces.len() > self.most {
            self.leave(leave);
        }
    }

    /// Comes to rest at the end of the last piece.
    pub fn stop(&mut self, leave: &mut impl FnMut(Law, T)) {
        while !self.pieces.is_empty() {
            self.leave(leave);
        }
        self.begin = 0.0;
    }

    fn leave(&mut self, leave: &mut impl FnMut(Law, T)) {
        let Some(Planned { pace, piece, .. }) = self.pieces.pop_front() else { return };
        let planned = self.pieces.front().map_or(0.0, |next| next.entry.min(pace.top.powi(2)));
        let end = planned.min(self.begin + 2.0 * pace.rate * pace.way);
        let law = Law::new(pace.way, [self.begin.sqrt(), end.sqrt()], pace.top, pace.rate);
        self.begin = end;
        leave(law, piece);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn run(paces: &[Pace], most: usize) -> Vec<(Law, usize)> {
        let mut laws = Vec::new();
        let mut window = Window::new(most);
        for (k, pace) in paces.iter().enumerate() {
            window.push(*pace, k, &mut |law, k| laws.push((law, k)));
        }
        window.stop(&mut |law, k| laws.push((law, k)));
        laws
    }

    /// Total time with all pieces known: speeds at joints are lowered until none breaks a rule.
    fn slow_seconds(paces: &[Pace]) -> f64 {
        let n = paces.len();
        let mut joints = vec![0.0f64; n + 1];
        for k in 1..n {
            joints[k] = paces[k - 1].top.min(paces[k].top);
        }
        for _ in 0..2 * n {
            for k in 0..n {
                let gain = 2.0 * paces[k].rate * paces[k].way;
                joints[k + 1] = joints[k + 1].min((joints[k].powi(2) + gain).sqrt());
                joints[k] = joints[k].min((joints[k + 1].powi(2) + gain).sqrt());
            }
        }
        paces
            .iter()
            .enumerate()
            .map(|(k, p)| Law::new(p.way, [joints[k], joints[k + 1]], p.top, p.rate).seconds())
            .sum()
    }

    fn paces() -> impl Strategy<Value = Vec<Pace>> {
        let pace = (0.001f64..2.0, 0.05f64..1.0, 0.1f64..20.0).prop_map(|(way, top, rate)| Pace { way, top, rate });
        prop::collection::vec(pace, 1..30)
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(47), ..ProptestConfig::with_cases(256) })]

        #[test]
        fn agrees_with_the_slow_twin(paces in paces()) {
            let fast: f64 = run(&paces, usize::MAX).iter().map(|(law, _)| law.seconds()).sum();
            let slow = slow_seconds(&paces);
            prop_assert!((fast - slow).abs() < 1e-6 * slow, "{fast} {slow}");
        }

        #[test]
        fn less_look_ahead_is_never_faster_and_keeps_the_order(paces in paces(), most in 1usize..6) {
            let short = run(&paces, most);
            prop_assert!(short.iter().enumerate().all(|(at, (_, k))| at == *k) && short.len() == paces.len());
            let time = |laws: &[(Law, usize)]| laws.iter().map(|(law, _)| law.seconds()).sum::<f64>();
            prop_assert!(time(&short) >= time(&run(&paces, usize::MAX)) - 1e-9);
        }
    }
}
