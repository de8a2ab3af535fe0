//! Numbers of every kind, small parts, and what is made of them.

use curvlay_layers::cells::{Cells, LayerOrder};
use curvlay_layers::curved::{Neighbours, NozzleRule, Platform, Rules};
use curvlay_layers::nalgebra::{Point3, Vector3};
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

pub fn point() -> impl Strategy<Value = Point3<f64>> {
    prop_oneof![
        8 => [-3..=3i32, -3..=3i32, 0..=3i32].prop_map(|at| Point3::from(at.map(f64::from))),
        1 => [number(), number(), number()].prop_map(Point3::from),
    ]
}

pub fn vector() -> impl Strategy<Value = Vector3<f64>> {
    [number(), number(), number()].prop_map(Vector3::from)
}

/// Numbers of cells of a small grid, and some beyond it.
pub fn ids() -> impl Strategy<Value = Vec<u32>> {
    let far = prop::sample::select(vec![60, 1 << 20, u32::MAX]);
    prop::collection::vec(prop_oneof![12 => 0..60u32, 1 => far], 0..9)
}

pub fn order() -> impl Strategy<Value = LayerOrder> {
    prop::collection::vec(ids(), 0..5).prop_map(|layers| {
        let mut order = LayerOrder::new();
        layers.into_iter().for_each(|layer| order.push(layer));
        order
    })
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

/// Any mesh, or four points closed to a tetrahedron.
pub fn mesh() -> impl Strategy<Value = (Vec<Point3<f64>>, Vec<[u32; 3]>)> {
    let any = (prop::collection::vec(point(), 0..7), prop::collection::vec([0..8u32, 0..8u32, 0..8u32], 0..9));
    let tetrahedron =
        prop::collection::vec(point(), 4).prop_map(|points| (points, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]));
    prop_oneof![1 => any, 2 => tetrahedron]
}

/// A box from the origin, closed.
pub fn box_of(sides: [f64; 3]) -> Vec<Point3<f64>> {
    (0..8).map(|k| Point3::from([0, 1, 2].map(|axis| if k >> axis & 1 == 1 { sides[axis] } else { 0.0 }))).collect()
}

/// Solid cells of a grid of 5 x 4 x 3, and a plate that carries some.
#[derive(Clone, Debug)]
pub struct Small {
    pub rows: Vec<u64>,
    pub platform: Platform,
    pub rules: Rules,
}

pub const DIMS: [u32; 3] = [5, 4, 3];

impl Small {
    pub fn cells(&self) -> Cells<'_> {
        Cells::new(DIMS, &self.rows).unwrap()
    }
}

pub fn rules() -> impl Strategy<Value = Rules> {
    let depth = prop_oneof![4 => Just(Rules::default().inside_depth_cells), 1 => number(), 1 => 0.0..2.0f64];
    (depth, any::<bool>(), any::<bool>(), prop::bool::weighted(0.1)).prop_map(|(depth, inside, all, flat)| Rules {
        inside_depth_cells: depth,
        boundary_is_inside: inside,
        neighbours: if all { Neighbours::OneNorm } else { Neighbours::FaceOrEdge },
        flat,
    })
}

pub fn small() -> impl Strategy<Value = Small> {
    let rows = prop_oneof![
        1 => Just(vec![31; 12]),
        1 => prop::collection::vec(0..32u64, 12),
        1 => Just([[31; 4], [3; 4], [31; 4]].concat()),
        1 => Just(vec![0; 12]),
    ];
    (rows, rules(), prop::sample::select(vec![9.0, 3.0, 1.0])).prop_map(|(rows, rules, size)| {
        let platform = Platform::polygon(&[[-1.0, -1.0], [size, -1.0], [size, size], [-1.0, size]]).unwrap();
        Small { rows, platform, rules }
    })
}

const NOZZLE: [fn(&mut NozzleRule, f64); 6] = [
    |rule, value| rule.tip_flat_mm = value,
    |rule, value| rule.half_angle = value,
    |rule, value| rule.cone_height_mm = value,
    |rule, value| rule.block_mm = value,
    |rule, value| rule.max_tilt = value,
    |rule, value| rule.margin = value,
];

/// The rule, and with each number in turn spoilt.
pub fn nozzles(value: f64) -> Vec<NozzleRule> {
    each_spoilt(&NozzleRule::default(), &NOZZLE, value)
}
