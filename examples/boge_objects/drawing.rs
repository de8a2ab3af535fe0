//! The worked example of chapter 4 as pictures: what is built after each layer, and its hull.

use super::growing::{Case, Run};
use curvlay_examples::args::Failure;
use curvlay_examples::count::counted;
use curvlay_examples::render::layer_colour;
use curvlay_hull::{ConvexHull2, Depth, Location2};
use std::fmt::Write;

/// Edge of a cell, and of the free space around a panel, in units of the drawing.
const CELL: f64 = 11.0;
const GAP: f64 = 16.0;
/// Panels beside each other.
const COLUMNS: usize = 5;

/// Figures 4.10 to 4.24: a panel for each layer of a flat object. Squares are cells, those of a layer in its colour; the line is the hull of the
/// centres of all that is built and of the platform; a cross is a cell that is not built and lies in it. Our hull is that of the growth: exact, and what
/// lies on it is in it.
pub fn worked_example(case: &Case, run: &Run) -> Result<String, Failure> {
    let grid = &case.drawn.grid;
    let [nx, _, nz] = grid.dims();
    let layers: Vec<&[u32]> = run.growth.order.iter().collect();
    let place = |cell: u32| {
        let [x, _, z] = grid.position(cell);
        // The row of the platform counts as well, as in the thesis.
        [x as i32, z as i32 + 1]
    };
    let mut hull = ConvexHull2::new(Depth::SURFACE);
    let platform: Vec<[i32; 2]> = case.drawn.platform.iter().map(|at| [at[0] as i32, 0]).collect();
    hull.insert(&platform)?;
    let (wide, high) = (f64::from(nx) * CELL, f64::from(nz + 1) * CELL);
    let rows = layers.len().div_ceil(COLUMNS);
    let size = [COLUMNS as f64 * (wide + GAP), rows as f64 * (high + 2.0 * GAP)];
    let mut svg = format!("<svg viewBox=\"0 0 {} {}\" role=\"img\">", size[0], size[1]);
    for (at, layer) in layers.iter().enumerate() {
        let points: Vec<[i32; 2]> = layer.iter().map(|&cell| place(cell)).collect();
        hull.insert(&points)?;
        let left = (at % COLUMNS) as f64 * (wide + GAP) + GAP / 2.0;
        let top = (at / COLUMNS) as f64 * (high + 2.0 * GAP) + GAP * 1.4;
        let corner = |[x, z]: [i32; 2]| [left + f64::from(x) * CELL, top + high - f64::from(z + 1) * CELL];
        let middle = |p: [i32; 2]| corner(p).map(|at| at + CELL / 2.0);
        platform.iter().for_each(|&p| square(&mut svg, corner(p), [150, 156, 164]));
        grid.iter().for_each(|cell| square(&mut svg, corner(place(cell)), [255, 255, 255]));
        for (number, built) in layers.iter().enumerate().take(at + 1) {
            let colour = layer_colour(number as u32 + 1, layers.len() as u32);
            built.iter().for_each(|&cell| square(&mut svg, corner(place(cell)), colour));
        }
        let built: Vec<u32> = layers[..=at].iter().flat_map(|layer| layer.iter().copied()).collect();
        let is_shadowed = |cell: &u32| !built.contains(cell) && hull.locate(place(*cell)) != Location2::Outside;
        let shadowed: Vec<u32> = grid.iter().filter(is_shadowed).collect();
        shadowed.iter().for_each(|&cell| cross(&mut svg, middle(place(cell))));
        let outline: Vec<String> =
            hull.corners().iter().map(|&p| middle(p)).map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
        let _ = write!(
            svg,
            "<polygon points=\"{}\" fill=\"none\" stroke=\"#0b7a75\" stroke-width=\"1.5\" stroke-dasharray=\"4 2\"/>\
             <text class=\"x\" x=\"{:.1}\" y=\"{:.1}\" style=\"font-size:9px\">layer {}: {}, {} in the hull</text>",
            outline.join(" "),
            left + wide / 2.0,
            top - 4.0,
            at + 1,
            counted(layer.len(), "cell"),
            shadowed.len()
        );
    }
    Ok(svg + "</svg>")
}

/// A cell with its upper left corner there.
fn square(svg: &mut String, [x, y]: [f64; 2], [r, g, b]: [u8; 3]) {
    let _ = write!(
        svg,
        "\n<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{CELL}\" height=\"{CELL}\" fill=\"#{r:02x}{g:02x}{b:02x}\" stroke=\"#8a94a1\" stroke-width=\"0.5\"/>"
    );
}

/// A cross about a point.
fn cross(svg: &mut String, [x, y]: [f64; 2]) {
    let arm = CELL * 0.3;
    let wide = 2.0 * arm;
    let _ = write!(
        svg,
        "<path d=\"M{:.1} {:.1}l{wide} {wide}M{:.1} {:.1}l{wide} -{wide}\" stroke=\"#c62f22\" stroke-width=\"1.6\"/>",
        x - arm,
        y - arm,
        x - arm,
        y + arm
    );
}
