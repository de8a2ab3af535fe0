//! The nodes of one waypoint: sampled free parameters, the solutions there, and their images.

use crate::Bounds;
use crate::angle::wrapped;
use crate::bounds::images;
use crate::robot::{FreeRange, Robot};
use std::f64::consts::{PI, TAU};

/// Images of one angle, at most.
const MAX_IMAGES: f64 = (1 << 22) as f64;

/// How angles of one joint are compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    /// Angles a whole turn apart are one: no stop, or stops that have not mattered yet.
    Circular,
    /// Less than a turn between the stops: one image at most.
    Single { lower: f64, upper: f64 },
    /// A turn or more between the stops: each image is a node of its own.
    Images { lower: f64, upper: f64 },
    /// The angle as the robot gives it, whole turns included: the robot has chosen the image.
    AsGiven,
}

impl Kind {
    /// Joints with a range of a turn or more begin as circular; those in `imaged` have turned out to meet a stop.
    pub fn of<const N: usize>(bounds: &Bounds<N>, imaged: &[bool; N]) -> [Kind; N] {
        std::array::from_fn(|joint| {
            let (lower, upper) = (bounds.lower[joint], bounds.upper[joint]);
            match imaged[joint] {
                _ if bounds.is_endless(joint) => Kind::Circular,
                _ if upper - lower < TAU => Kind::Single { lower, upper },
                true => Kind::Images { lower, upper },
                false => Kind::Circular,
            }
        })
    }

    /// After how much the distance of two angles begins anew.
    pub fn period(self) -> f64 {
        if self == Kind::Circular { TAU } else { f64::INFINITY }
    }

    /// The least image within, and how many more there are; `None` if there is none.
    fn images(self, angle: f64) -> Option<(f64, u32)> {
        let (lower, upper) = match self {
            Kind::Circular => return Some((wrapped(angle), 0)),
            Kind::AsGiven => return Some((angle, 0)),
            Kind::Single { lower, upper } | Kind::Images { lower, upper } => (lower, upper),
        };
        // A cap for stops that are absurdly far apart; `TooLarge` will say so.
        images(lower, upper, angle).map(|(least, more)| (least, more.min(MAX_IMAGES) as u32))
    }
}

/// Calls `each` with every combination of images of `joints`, the first joint changing fastest, until it says false.
pub(super) fn each_image<const N: usize>(joints: &[f64; N], kinds: &[Kind; N], each: &mut dyn FnMut([f64; N]) -> bool) {
    let mut first = *joints;
    let mut more = [0; N];
    for joint in 0..N {
        // The inverse of a robot may say what it likes; what is no angle is no node.
        let Some(found) = joints[joint].is_finite().then(|| kinds[joint].images(joints[joint])).flatten() else {
            return;
        };
        (first[joint], more[joint]) = found;
    }
    if more == [0; N] {
        each(first);
        return;
    }
    let mut turns = [0u32; N];
    loop {
        let image = std::array::from_fn(|joint| {
            let turned = first[joint] + TAU * f64::from(turns[joint]);
            if let Kind::Images { upper, .. } = kinds[joint] { turned.min(upper) } else { turned }
        });
        if !each(image) {
            return;
        }
        let Some(next) = (0..N).find(|&joint| turns[joint] < more[joint]) else { return };
        turns[..next].fill(0);
        turns[next] += 1;
    }
}

/// Which samples of the free parameters are looked at, at one waypoint: `counts` on the whole range, of which `length`
/// from `start` on, beginning anew where the range is a turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Window<const F: usize> {
    pub counts: [u32; F],
    pub start: [u32; F],
    pub length: [u32; F],
}

impl<const F: usize> Window<F> {
    pub fn whole(counts: [u32; F]) -> Self {
        Window { counts, start: [0; F], length: counts }
    }

    /// Samples within; the first parameter changes fastest.
    pub fn len(&self) -> u32 {
        self.length.iter().product()
    }

    /// The free parameters of a sample.
    pub fn free(&self, range: &[FreeRange; F], sample: u32) -> [f64; F] {
        let mut rest = sample;
        std::array::from_fn(|f| {
            let at = (self.start[f] + rest % self.length[f]) % self.counts[f];
            rest /= self.length[f];
            value(range[f], self.counts[f], at)
        })
    }
}

/// Value `at` of `count` on the range.
fn value(range: FreeRange, count: u32, at: u32) -> f64 {
    match range {
        FreeRange::Turn => TAU * (f64::from(at) / f64::from(count)) - PI,
        FreeRange::Within(from, to) if count > 1 => from + (to - from) * (f64::from(at) / f64::from(count - 1)),
        FreeRange::Within(from, to) => 0.5 * (from + to),
    }
}

/// Which of `count` values is nearest to `free`.
pub(super) fn nearest(range: FreeRange, count: u32, free: f64) -> u32 {
    let turn = f64::from(count);
    match range {
        FreeRange::Turn => ((free + PI) / TAU * turn).round().rem_euclid(turn) as u32,
        FreeRange::Within(from, to) if count > 1 && to > from => {
            ((free - from) / (to - from) * (turn - 1.0)).round().clamp(0.0, turn - 1.0) as u32
        }
        FreeRange::Within(..) => 0,
    }
}

/// The nodes of a waypoint.
#[derive(Clone, Debug, Default)]
pub(super) struct Nodes<const N: usize> {
    pub joints: Vec<[f64; N]>,
    /// Node at which each sample begins, and the number of all nodes.
    pub starts: Vec<u32>,
}

impl<const N: usize> Nodes<N> {
    /// Fills in the nodes of a waypoint; at most `most`.
    pub fn fill<const F: usize>(
        &mut self,
        robot: &dyn Robot<N, F>,
        waypoint: usize,
        window: &Window<F>,
        kinds: &[Kind; N],
        most: usize,
    ) {
        self.joints.clear();
        self.starts.clear();
        let range = robot.free();
        for sample in 0..window.len() {
            self.starts.push(self.joints.len() as u32);
            robot.solutions(waypoint, &window.free(&range, sample), &mut |_, joints| {
                each_image(&joints, kinds, &mut |image| {
                    if self.joints.len() < most {
                        self.joints.push(image);
                    }
                    self.joints.len() < most
                });
            });
        }
        self.starts.push(self.joints.len() as u32);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_are_all_within() {
        let kinds =
            [Kind::Images { lower: -TAU, upper: TAU }, Kind::Single { lower: -1.0, upper: 2.0 }, Kind::Circular];
        let mut found = Vec::new();
        each_image(&[0.5, 0.5 + TAU, 4.0], &kinds, &mut |image| {
            found.push(image);
            true
        });
        assert_eq!(found.len(), 2);
        assert!((found[0][0] - (0.5 - TAU)).abs() < 1e-15 && (found[1][0] - 0.5).abs() < 1e-15);
        assert!(found.iter().all(|image| (image[1] - 0.5).abs() < 1e-15 && (image[2] - (4.0 - TAU)).abs() < 1e-15));
        each_image(&[0.5, 2.1, 0.0], &kinds, &mut |_| unreachable!());
        each_image(&[f64::NAN, 0.0, 0.0], &kinds, &mut |_| unreachable!());
        // On the stop, a hair beyond.
        let mut on_stop = Vec::new();
        each_image(&[TAU + 1e-12, 2.0 + 1e-12, 0.0], &kinds, &mut |image| {
            on_stop.push(image);
            true
        });
        assert_eq!(on_stop.iter().map(|image| image[0]).collect::<Vec<_>>().len(), 3);
        assert!(on_stop.iter().all(|image| image[0].abs() <= TAU && image[1] <= 2.0));
    }

    #[test]
    fn windows_begin_anew_where_the_range_is_a_turn() {
        let range = [FreeRange::Turn, FreeRange::Within(0.0, 3.0)];
        let window = Window { counts: [4, 4], start: [3, 1], length: [2, 2] };
        let found: Vec<_> = (0..window.len()).map(|sample| window.free(&range, sample)).collect();
        let half = PI / 2.0;
        let expected = [[half, 1.0], [-PI, 1.0], [half, 2.0], [-PI, 2.0]];
        assert!(found.iter().flatten().zip(expected.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-15));
        assert_eq!((nearest(range[0], 4, PI - 0.1), nearest(range[0], 4, 1.4), nearest(range[1], 4, 2.2)), (0, 3, 2));
        assert!((Window::whole([1]).free(&[FreeRange::Within(1.0, 3.0)], 0)[0] - 2.0).abs() < 1e-15);
    }
}
