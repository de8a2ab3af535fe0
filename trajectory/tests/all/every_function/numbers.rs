//! Numbers of every kind, and what is made of them.

use curvlay_trajectory::Bounds;
use proptest::prelude::*;

/// Not finite, none, or far out.
pub fn bad() -> impl Strategy<Value = f64> {
    let infinite = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    let finite = [0.0, -0.0, 1e308, -1e308, f64::MAX, 5e-324, -5e-324, 1e15, -1e9, 1e-9, -1.0];
    prop::sample::select([&infinite[..], &finite].concat())
}

/// Sound for the most part.
pub fn number() -> impl Strategy<Value = f64> {
    prop_oneof![5 => (-3..=3i32).prop_map(f64::from), 5 => -3.0..3.0f64, 2 => bad()]
}

/// A number of things: few, none, more than there is memory for.
pub fn count() -> impl Strategy<Value = usize> {
    prop::sample::select(vec![0, 1, 2, 3, 7, 40, usize::MAX / 2, usize::MAX])
}

/// Times that rise, with a bad one now and then; or any numbers.
pub fn times() -> impl Strategy<Value = Vec<f64>> {
    let rising = |steps: Vec<f64>| {
        steps.iter().scan(0.0, |time, step| Some(*time + std::mem::replace(time, *time + step))).collect()
    };
    let steps = prop::collection::vec(0.01..0.5f64, 0..14).prop_map(rising);
    let spoilt =
        (prop::collection::vec(0.01..0.5f64, 1..14), 0..14usize, bad()).prop_map(move |(mut steps, at, bad)| {
            let at = at % steps.len();
            steps[at] = bad;
            rising(steps)
        });
    prop_oneof![3 => steps, 2 => spoilt, 1 => prop::collection::vec(number(), 0..9)]
}

pub fn joints<const N: usize>() -> impl Strategy<Value = [f64; N]> {
    prop_oneof![4 => prop::array::uniform(-2.0..2.0f64), 1 => prop::array::uniform(number())]
}

/// Bounds with at most one field spoilt.
pub fn bounds<const N: usize>() -> impl Strategy<Value = Bounds<N>> {
    (0..12usize, 0..N, bad()).prop_map(|(field, joint, bad)| {
        let mut bounds =
            Bounds { lower: [-3.0; N], upper: [3.0; N], velocity: [4.0; N], acceleration: [30.0; N], jerk: [300.0; N] };
        match field {
            0 => bounds.lower[joint] = bad,
            1 => bounds.upper[joint] = bad,
            2 => bounds.velocity[joint] = bad,
            3 => bounds.acceleration[joint] = bad,
            4 => bounds.jerk[joint] = bad,
            5 => bounds = Bounds { lower: [-1e308; N], upper: [1e308; N], ..bounds },
            6 => bounds = Bounds::NONE,
            _ => {}
        }
        bounds
    })
}

/// As many as wanted, by repeating what there is.
pub fn fit<T: Clone>(list: &[T], count: usize) -> Vec<T> {
    list.iter().cycle().take(count).cloned().collect()
}

/// The options as they are, and with each field in turn set to a number.
pub fn each_spoilt<T: Clone, V: Copy>(sound: &T, fields: &[fn(&mut T, V)], value: V) -> Vec<T> {
    let spoilt = fields.iter().map(|set| {
        let mut options = sound.clone();
        set(&mut options, value);
        options
    });
    std::iter::once(sound.clone()).chain(spoilt).collect()
}
