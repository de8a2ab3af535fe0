//! The figures of the thesis.
//!
//! H. Boge, *Robotic additive manufacturing* (MSc thesis, NTNU 2019), sections 5.2.3, 6.2.4, 6.3 and 6.4.

use super::rating::Rating;

/// What the thesis calls greedy convex front advancing, and the same with incremental shadow prevention.
pub const METHODS: [&str; 2] = ["GCFA", "GCFA-ISP"];

/// Table 5.1, missed voxels. A line for each object; in it the platforms S, M and L, and for each platform GCFA and
/// GCFA-ISP.
pub const MISSED: [[[usize; 2]; 3]; 6] = [
    [[0, 0], [9, 3], [16, 10]],
    [[0, 0], [0, 0], [3, 0]],
    [[0, 0], [0, 0], [6, 0]],
    [[0, 0], [0, 0], [0, 0]],
    [[9, 15], [9, 15], [9, 17]],
    [[0, 0], [0, 0], [168, 185]],
];

/// Table 5.2, manufacturing layers, laid out like [`MISSED`].
pub const LAYERS: [[[usize; 2]; 3]; 6] = [
    [[14, 14], [14, 14], [12, 15]],
    [[12, 12], [12, 12], [12, 13]],
    [[10, 10], [10, 10], [10, 11]],
    [[11, 11], [11, 11], [11, 11]],
    [[11, 21], [11, 21], [11, 19]],
    [[12, 12], [12, 12], [12, 16]],
];

/// Table 6.6, missed voxels of uniform slicing. The thesis slices no object in space.
pub const UNIFORM: [Option<usize>; 6] = [Some(29), Some(18), Some(32), Some(14), Some(29), None];

/// Table 6.4, how good each field is, laid out like [`MISSED`].
pub const RATINGS: [[[Rating; 2]; 3]; 6] = {
    use Rating::{Good, Ok, Poor};
    [
        [[Good, Good], [Poor, Ok], [Poor, Poor]],
        [[Good, Good], [Good, Good], [Poor, Good]],
        [[Good, Good], [Good, Good], [Poor, Good]],
        [[Good, Good], [Good, Good], [Good, Good]],
        [[Poor, Poor], [Poor, Poor], [Poor, Poor]],
        [[Good, Good], [Good, Good], [Poor, Poor]],
    ]
};

/// Table 6.7: the properties of hardware, and whether platform in the hand, platform on the floor and elevated platform have
/// them. As printed; by sections 6.4.2 and 6.4.3 a small platform goes with the elevated one and not with the floor.
pub const HARDWARE: [(&str, [bool; 3]); 3] = [
    ("large parts", [false, true, true]),
    ("small platform", [true, true, false]),
    ("gravity helps", [true, false, false]),
];
