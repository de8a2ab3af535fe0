//! Bodies of the IRB 1200-7/0.7: an estimate, since no mesh of it was at hand.
//!
//! The shoulder is 5 mm and more beyond a part of the vertices of ROS-Industrial's mesh (`abb_irb1200_support`, `link_1`: turntable of
//! radius 123, cheeks of radius 79 about axis 2, from 122.5 to one side to 119 to the other, 179 down to the foot). The foot is 210 wide
//! on the maker's data sheet; its plugs reach back to 245 at most. The others follow the collision mesh of the next arm of the same
//! maker (IRB 140 of 6 kg, `abb_irb140_support`), link by link, with lengths of the IRB 1200 and an allowance of 10 to 25 mm: an arm
//! whose links are thicker than these at any place is not covered.
//! Millimetres, in the frames of [`Arm::frames`](crate::Arm::frames).

use super::prism::Axis::{Y, Z};
use super::prism::{Prism, prism};

/// Pieces of the links, base to flange.
pub(super) const IRB1200: [&[Prism]; 7] = [
    // base
    &[prism(Z, [0.0, 222.0], &[-250.0, -130.0, 130.0, -130.0, 130.0, 130.0, -250.0, 130.0])],
    // shoulder
    &[
        prism(
            Z,
            [-180.0, -60.0],
            &[
                132.5, 0.0, 114.8, 66.3, 66.3, 114.8, 0.0, 132.5, -66.3, 114.8, -114.8, 66.3, -132.5, 0.0, -114.8,
                -66.3, -66.3, -114.8, 0.0, -132.5, 66.3, -114.8, 114.8, -66.3,
            ],
        ),
        prism(
            Y,
            [-128.0, 128.0],
            &[
                -180.0, 110.0, -180.0, -110.0, 0.0, -110.0, 46.6, -80.7, 80.7, -46.6, 93.2, 0.0, 80.7, 46.6, 46.6,
                80.7, 0.0, 110.0,
            ],
        ),
    ],
    // upper arm
    &[prism(
        Y,
        [-190.0, 190.0],
        &[
            -54.4, -94.1, 0.0, -108.7, 350.0, -108.7, 404.4, -94.1, 444.1, -54.4, 458.7, 0.0, 444.1, 54.4, 404.4, 94.1,
            350.0, 108.7, 0.0, 108.7, -54.4, 94.1, -94.1, 54.4, -108.7, 0.0, -94.1, -54.4,
        ],
    )],
    // forearm
    &[prism(
        Y,
        [-105.0, 105.0],
        &[-130.0, -132.0, 200.0, -132.0, 200.0, 48.0, 59.5, 103.1, 0.0, 119.1, -59.5, 103.1, -130.0, 48.0],
    )],
    // wrist 1
    &[
        prism(
            Z,
            [-215.0, -84.0],
            &[
                82.8, 0.0, 71.7, 41.4, 41.4, 71.7, 0.0, 82.8, -41.4, 71.7, -71.7, 41.4, -82.8, 0.0, -71.7, -41.4,
                -41.4, -71.7, 0.0, -82.8, 41.4, -71.7, 71.7, -41.4,
            ],
        ),
        prism(
            Y,
            [-80.0, -50.0],
            &[
                -85.0, 62.0, -85.0, -62.0, 0.0, -64.2, 32.1, -55.6, 55.6, -32.1, 64.2, 0.0, 55.6, 32.1, 32.1, 55.6,
                0.0, 64.2,
            ],
        ),
        prism(
            Y,
            [50.0, 80.0],
            &[
                -85.0, 62.0, -85.0, -62.0, 0.0, -64.2, 32.1, -55.6, 55.6, -32.1, 64.2, 0.0, 55.6, 32.1, 32.1, 55.6,
                0.0, 64.2,
            ],
        ),
    ],
    // wrist 2
    &[prism(
        Z,
        [-52.0, 52.0],
        &[
            53.8, 0.0, 46.6, 26.9, 26.9, 46.6, 0.0, 53.8, -26.9, 46.6, -46.6, 26.9, -53.8, 0.0, -46.6, -26.9, -26.9,
            -46.6, 0.0, -53.8, 26.9, -46.6, 46.6, -26.9,
        ],
    )],
    // flange
    &[prism(
        Z,
        [-20.0, 0.0],
        &[
            35.2, 0.0, 30.5, 17.6, 17.6, 30.5, 0.0, 35.2, -17.6, 30.5, -30.5, 17.6, -35.2, 0.0, -30.5, -17.6, -17.6,
            -30.5, 0.0, -35.2, 17.6, -30.5, 30.5, -17.6,
        ],
    )],
];
