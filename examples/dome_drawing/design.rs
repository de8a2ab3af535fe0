//! Designs made in code: leaves of two arcs, as in the design of the thesis (Fig. 4-6).

use super::Design;
use curvlay_kinematics::nalgebra::{Point2, Rotation2};
use curvlay_toolpath::drawing::{Curve, Drawing};
use std::f64::consts::TAU;

/// A crown of leaves.
struct Crown {
    layer: &'static str,
    leaves: u32,
    /// From where to where along the radius, and half the width.
    from: f64,
    to: f64,
    half_width: f64,
    /// Where the first leaf points, in leaves.
    turned: f64,
}

pub fn drawing(design: Design) -> Drawing {
    let crown = |layer, leaves, from, to, half_width, turned| Crown { layer, leaves, from, to, half_width, turned };
    let (hub, crowns, stems) = match design {
        Design::Rosette => {
            (24.0, vec![crown("INNER", 8, 20.0, 86.0, 17.0, 0.0), crown("OUTER", 12, 70.0, 138.0, 19.0, 0.5)], 12)
        }
        Design::Large => {
            (12.0, vec![crown("INNER", 30, 11.0, 75.0, 5.6, 0.0), crown("OUTER", 60, 60.0, 148.0, 5.6, 0.5)], 0)
        }
    };
    let mut drawing = Drawing::default();
    drawing.add("HUB", [Curve::circle(Point2::origin(), hub, 0.0, TAU)]);
    for Crown { layer, leaves, from, to, half_width, turned } in crowns {
        for k in 0..leaves {
            let turn = Rotation2::new(TAU * (f64::from(k) + turned) / f64::from(leaves));
            let ends = [Point2::new(from, 0.0), Point2::new(to, 0.0)].map(|end| turn * end);
            let bulge = 2.0 * half_width / (to - from);
            // Two entities: the contour is closed by joining them.
            drawing.add(layer, [Curve::bulge(ends[0], ends[1], bulge)]);
            drawing.add(layer, [Curve::bulge(ends[0], ends[1], -bulge)]);
        }
    }
    for k in 0..stems {
        let turn = Rotation2::new(TAU * f64::from(k) / f64::from(stems));
        let ends = [Point2::new(10.0, 0.0), Point2::new(132.0, 0.0)].map(|end| turn * end);
        drawing.add("STEMS", [Curve::Line { from: ends[0], to: ends[1] }]);
    }
    drawing
}
