//! Numbers of every kind, and what is made of them.

use curvlay_toolpath::nalgebra::{Point2, Point3, Unit, UnitVector3, Vector3};
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

pub fn flat() -> impl Strategy<Value = Point2<f64>> {
    prop_oneof![6 => [-9.0..9.0f64, -9.0..9.0f64].prop_map(Point2::from), 1 => [number(), number()].prop_map(Point2::from)]
}

pub fn point() -> impl Strategy<Value = Point3<f64>> {
    prop_oneof![
        8 => [-3..=3i32, -3..=3i32, 0..=3i32].prop_map(|at| Point3::from(at.map(f64::from))),
        1 => [number(), number(), number()].prop_map(Point3::from),
    ]
}

pub fn vector() -> impl Strategy<Value = Vector3<f64>> {
    [number(), number(), number()].prop_map(Vector3::from)
}

/// Upright for the most part; else of any length.
pub fn unit() -> impl Strategy<Value = UnitVector3<f64>> {
    prop_oneof![4 => Just(Vector3::z_axis()), 1 => Just(-Vector3::z_axis()), 1 => vector().prop_map(Unit::new_unchecked)]
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

/// As many as wanted, by repeating what there is.
pub fn fit<T: Clone>(list: &[T], count: usize) -> Vec<T> {
    list.iter().cycle().take(count).cloned().collect()
}

pub type Mesh = (Vec<Point3<f64>>, Vec<[u32; 3]>);

/// A square of two triangles, at a height.
pub fn square(side: f64, z: f64) -> Mesh {
    let corners = [[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]].map(|[x, y]| Point3::new(x, y, z));
    (corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])
}

/// Any triangles, or a square with corners moved.
pub fn mesh() -> impl Strategy<Value = Mesh> {
    let any = (prop::collection::vec(point(), 0..7), prop::collection::vec([0..8u32, 0..8u32, 0..8u32], 0..9));
    let sheet = (0..4usize, point()).prop_map(|(corner, to)| {
        let (mut points, triangles) = square(6.0, 0.8);
        points[corner] = to;
        (points, triangles)
    });
    prop_oneof![1 => any, 1 => Just(square(6.0, 0.8)), 1 => sheet]
}
