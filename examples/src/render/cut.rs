//! A cut through the layers: the cells on a plane, as squares.

use super::cells::LayeredCells;
use super::colours::{INK, Rgb, layer_colour};
use super::image::Image;
use super::plane::Plane;

/// Free pixels around the cut.
const MARGIN: u32 = 14;
/// Squares smaller than this have no outlines: they would be nothing else.
const OUTLINED: u32 = 4;

/// The cells with the x (or y) of `plane`, z upwards, coloured by layer, with lines between layers, around the part,
/// and for the plate. The squares are as large as `width` and `height` allow, at least a pixel (then large grids are
/// larger than asked for, or cut off at [`Image::MAX_SIDE`]). A plane outside the grid shows nothing.
pub fn draw_cut(cells: &LayeredCells, plane: Plane, width: u32, height: u32) -> Image {
    let across = 1 - plane.axis();
    let [wide, high] = [cells.dims()[across], cells.dims()[2]];
    let room = |side: u32, count: u32| side.saturating_sub(2 * MARGIN) / count;
    let square = room(width, wide).min(room(height, high)).clamp(1, 64);
    let mut image = Image::new(wide * square + 2 * MARGIN, high * square + 2 * MARGIN, [255; 3]);
    let layers = cells.last_layer();
    let layer_at = |u: u32, z: u32| match plane {
        Plane::X(x) => cells.layer([x, u, z]),
        Plane::Y(y) => cells.layer([u, y, z]),
    };
    // Lines go on the low side of the square whose neighbour differs.
    let line = |a: Option<u32>, b: Option<u32>| -> Option<Rgb> {
        match (a, b) {
            (Some(a), Some(b)) if a != b && square >= OUTLINED => Some(darker(layer_colour(a.min(b), layers))),
            (Some(_), None) | (None, Some(_)) => Some(INK),
            _ => None,
        }
    };
    let thick = (square / 8).max(1);
    for z in 0..=high {
        for u in 0..=wide {
            let here = layer_at(u, z);
            let [x, y] = [MARGIN + u * square, MARGIN + (high - z) * square];
            if let Some(layer) = here {
                image.fill([x, y - square], [square, square], layer_colour(layer, layers));
            }
            let left = u.checked_sub(1).and_then(|u| layer_at(u, z));
            if let Some(colour) = line(here, left) {
                image.fill([x, y - square], [thick, square], colour);
            }
            let below = z.checked_sub(1).and_then(|z| layer_at(u, z));
            if let Some(colour) = line(here, below) {
                image.fill([x, y - thick], [square, thick], colour);
            }
        }
    }
    image.fill([0, MARGIN + high * square], [image.width(), 2], INK);
    image
}

fn darker(colour: Rgb) -> Rgb {
    colour.map(|c| (u32::from(c) * 5 / 8) as u8)
}
