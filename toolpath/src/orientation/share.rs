//! How wide beads are where they share the surface.
//!
//! Beads of even width overlap where they bend sharply, meet or turn round at a ridge, by a sixth of the surface on thin
//! shells. To lay the full section there twice would make the layer swell. So each bit of the surface within half a
//! width of a bead goes to the nearest one, and a bead is as wide as what it gets, by its length: the volume of all beads is then
//! that of the layer where it is covered.
//!
//! What counts are the curves as they are given, not the straight ways between waypoints: these cut off what is outside of
//! a bend. Through ribs of three millimetres steps of one would leave a twelfth of the layer bare, though it is covered.
//!
//! Triangles are divided into like parts no longer than a quarter of the widest bead, and each part goes by its middle.

use super::resample::Line;
use super::tool_path::ToolPath;
use crate::layer::{LayerStack, of_layer};
use nalgebra::{Point3, Vector3};

/// Parts of a triangle are no longer than this share of the widest bead. A sixth instead changes the volume of a part by a
/// thousandth, and takes twice as long.
const PART: f64 = 0.25;

/// A side of a triangle is divided into no more parts than this: surfaces of layers have triangles like beads.
const MAX_PARTS: usize = 64;

/// No bead gets narrower than this share of its width: it must still be one.
const MIN_WIDTH_SHARE: f64 = 0.05;

/// Nor wider than this: the round end of a bead reaches beyond its last point, and is laid before it.
const MAX_WIDTH_SHARE: f64 = 2.0;

/// Points of a curve that are this near to the straight line between others, in widths of the bead, make no difference.
/// Twice as much leaves a hundredth of a thin rib bare; less takes longer.
const STRAIGHT: f64 = 0.01;

/// Pieces longer than this, in widths, would concern triangles that are far from them.
const LONGEST: f64 = 1.5;

/// Parts of a triangle along each side of a block, which looks once for the pieces that may be nearest to any of them. Of triangles as long as
/// beads are wide 4 makes one block, 1 looks at each part on its own; between 2 and 3 there is little difference.
const BLOCK: usize = 3;

/// Distances to what is left out of a block are this much larger, as a share: far above rounding.
const ROUNDING: f64 = 1e-9;

/// A straight piece of a curve, with the bead on it.
struct Piece {
    path: usize,
    from: Point3<f64>,
    /// From there to its end.
    way: Vector3<f64>,
    /// The square of its length.
    square: f64,
    widths: [f64; 2],
    arcs: [f64; 2],
}

impl Piece {
    fn new(path: usize, [from, to]: [Point3<f64>; 2], widths: [f64; 2], arcs: [f64; 2]) -> Piece {
        let way = to - from;
        Piece { path, from, way, square: way.norm_squared(), widths, arcs }
    }

    /// Square of the distance from a place, and how far along the closest point is, as a share.
    fn closest(&self, place: Point3<f64>) -> (f64, f64) {
        let share =
            if self.square > 0.0 { ((place - self.from).dot(&self.way) / self.square).clamp(0.0, 1.0) } else { 0.0 };
        ((self.from + self.way * share - place).norm_squared(), share)
    }
}

/// The width of each waypoint of all paths of a layer, in millimetres.
pub(super) fn widths(stack: &LayerStack, paths: &[ToolPath]) -> Vec<f64> {
    let mut pieces = Vec::new();
    for (path, of_path) in paths.iter().enumerate() {
        let line = stack.line(of_path.layer as usize, of_path.curve as usize);
        let mut from = 0;
        while from + 1 < line.points.len() {
            let to = straight_to(&line, from);
            let ends = [from, to];
            let (widths, arcs) = (ends.map(|k| line.widths[k]), ends.map(|k| line.arcs[k]));
            pieces.push(Piece::new(path, ends.map(|k| line.points[k]), widths, arcs));
            from = to;
        }
    }
    let mut areas: Vec<Vec<f64>> = paths.iter().map(|path| vec![0.0; path.waypoints.len() - 1]).collect();
    // Places come triangle by triangle: most lie between the same waypoints as the one before.
    let mut last = (usize::MAX, 0);
    share_out(stack, paths.first().map_or(0, |path| path.layer), &pieces, |path, arc, area| {
        let waypoints = &paths[path].waypoints;
        // Between which waypoints the place is: how many come before it.
        let is_between = |after: usize| {
            let begun = after == 0 || waypoints[after - 1].arc <= arc;
            begun && waypoints.get(after).is_none_or(|next| next.arc > arc)
        };
        if last.0 != path || !is_between(last.1) {
            last = (path, waypoints.partition_point(|waypoint| waypoint.arc <= arc));
        }
        let steps = areas[path].len();
        areas[path][last.1.clamp(1, steps) - 1] += area;
    });
    let mut widths = Vec::new();
    for (waypoints, areas) in paths.iter().map(|path| &path.waypoints).zip(&areas) {
        for (k, waypoint) in waypoints.iter().enumerate() {
            let (start, end) = (k.saturating_sub(1), (k + 1).min(areas.len()));
            let length = waypoints[end].arc - waypoints[start].arc;
            let width = if length > 0.0 { areas[start..end].iter().sum::<f64>() / length } else { waypoint.width };
            widths.push(width.clamp(MIN_WIDTH_SHARE * waypoint.width, MAX_WIDTH_SHARE * waypoint.width));
        }
    }
    widths
}

/// The last point of a curve up to which it is straight from another.
fn straight_to(line: &Line, from: usize) -> usize {
    let straight = |to: usize| {
        let width = line.widths[from].min(line.widths[to]);
        let near =
            |k: usize| to_segment(line.points[k], line.points[from], line.points[to]).0 <= (STRAIGHT * width).powi(2);
        line.arcs[to] - line.arcs[from] <= LONGEST * width && (from + 1..to).all(near)
    };
    (from + 2..line.points.len()).take_while(|&to| straight(to)).last().unwrap_or(from + 1)
}

/// Hands over each bit of the surface of a layer that is covered: the path that gets it, how far along, and its area.
fn share_out(stack: &LayerStack, layer: u32, pieces: &[Piece], mut each: impl FnMut(usize, f64, f64)) {
    // Which pieces may get parts of which triangle.
    let mut pairs: Vec<(u32, u32)> = Vec::new();
    let mut widest: f64 = 0.0;
    for (number, Piece { from, way, square, widths, .. }) in (0..).zip(pieces) {
        let width = widths[0].max(widths[1]);
        widest = widest.max(width);
        let (middle, reach) = (from + way * 0.5, (square.sqrt() + width) / 2.0);
        stack.tree.within(&stack.keys, middle, of_layer(layer), reach, |t| pairs.push((t as u32, number)));
    }
    pairs.sort_unstable();
    let (mut of_block, mut parts_of_block) = (Vec::new(), Parts::new());
    for pairs in pairs.chunk_by(|a, b| a.0 == b.0) {
        let triangle = &stack.tree.triangles()[pairs[0].0 as usize];
        let [a, b, c] = triangle.corners;
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        let parts = ((longest / (PART * widest)).ceil().max(1.0) as usize).min(MAX_PARTS);
        let area = triangle.normal().norm() / 2.0 / (parts * parts) as f64;
        let of_triangle = || pairs.iter().map(|&(_, number)| &pieces[number as usize]);
        // All parts of a triangle are as large, so their order makes no difference to what a bead gets.
        for block in Block::of([a, b, c], parts) {
            block.concerned(of_triangle(), &mut of_block);
            parts_of_block.fill(&block);
            of_block.iter().enumerate().for_each(|(number, candidate)| parts_of_block.offer(number, candidate.piece));
            for (number, share) in parts_of_block.taken() {
                let Piece { path, arcs, .. } = of_block[number].piece;
                each(*path, arcs[0] + (arcs[1] - arcs[0]) * share, area);
            }
        }
    }
}

/// Most parts of a block.
const MAX_BLOCK: usize = 2 * BLOCK * BLOCK;

/// The parts of a block, and the first of the nearest pieces whose bead reaches the middle of each. Coordinate by coordinate, so that a piece is
/// measured from several middles at once.
struct Parts {
    count: usize,
    middles: [[f64; MAX_BLOCK]; 3],
    /// Square of the distance of the piece that has each part; infinite where none has.
    squares: [f64; MAX_BLOCK],
    pieces: [u64; MAX_BLOCK],
    /// How far along its piece the closest point is.
    shares: [f64; MAX_BLOCK],
}

impl Parts {
    fn new() -> Parts {
        let zeros = [0.0; MAX_BLOCK];
        Parts { count: 0, middles: [zeros; 3], squares: zeros, pieces: [0; MAX_BLOCK], shares: zeros }
    }

    /// Makes these the parts of a block, which no piece has yet.
    fn fill(&mut self, block: &Block) {
        self.count = 0;
        for middle in block.middles() {
            (0..3).for_each(|k| self.middles[k][self.count] = middle[k]);
            self.count += 1;
        }
        self.squares = [f64::INFINITY; MAX_BLOCK];
    }

    /// Gives a piece the parts that its bead reaches and to which it is nearer than those before.
    fn offer(&mut self, number: usize, piece: &Piece) {
        let Piece { from, way, square, widths: [one, other], .. } = piece;
        // A piece without length has its start everywhere.
        let square = if *square > 0.0 { *square } else { f64::INFINITY };
        let [xs, ys, zs] = &self.middles;
        for k in 0..self.count.min(MAX_BLOCK) {
            let along = (xs[k] - from.x) * way.x + (ys[k] - from.y) * way.y + (zs[k] - from.z) * way.z;
            let share = (along / square).clamp(0.0, 1.0);
            let x = from.x + way.x * share - xs[k];
            let y = from.y + way.y * share - ys[k];
            let z = from.z + way.z * share - zs[k];
            let distance = x * x + y * y + z * z;
            let half = (one + (other - one) * share) / 2.0;
            let takes = (distance < self.squares[k]) & (distance <= half * half);
            self.squares[k] = if takes { distance } else { self.squares[k] };
            self.pieces[k] = if takes { number as u64 } else { self.pieces[k] };
            self.shares[k] = if takes { share } else { self.shares[k] };
        }
    }

    /// The number of the piece that has each part that has one, and the share along it.
    fn taken(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let has = |&k: &usize| self.squares[k] < f64::INFINITY;
        (0..self.count).filter(has).map(|k| (self.pieces[k] as usize, self.shares[k]))
    }
}

/// A piece that may get a part of a block, and the least distance at which it may be.
struct Candidate<'p> {
    piece: &'p Piece,
    least: f64,
}

/// Some of the like parts of a triangle with `parts` along each side: from places (`i`, `j`) along its sides on, [`BLOCK`] each way.
struct Block {
    corner: Point3<f64>,
    sides: [Vector3<f64>; 2],
    parts: usize,
    from: [usize; 2],
}

impl Block {
    fn of([a, b, c]: [Point3<f64>; 3], parts: usize) -> impl Iterator<Item = Block> {
        let sides = [b - a, c - a].map(|side| side / parts as f64);
        let from = (0..parts).step_by(BLOCK).flat_map(move |i| (0..parts - i).step_by(BLOCK).map(move |j| [i, j]));
        from.map(move |from| Block { corner: a, sides, parts, from })
    }

    /// Of some pieces those that may get a part of the block, in their order. A piece gets none where another is nearer all over the block
    /// and reaches all of it.
    fn concerned<'p>(&self, among: impl Iterator<Item = &'p Piece>, concerned: &mut Vec<Candidate<'p>>) {
        let [u, v] = self.sides;
        let half = BLOCK as f64 / 2.0;
        let middle = self.corner + u * (self.from[0] as f64 + half) + v * (self.from[1] as f64 + half);
        let radius = (u + v).norm().max((u - v).norm()) * half * (1.0 + ROUNDING);
        concerned.clear();
        let mut farthest = f64::INFINITY;
        for piece in among {
            let [one, other] = piece.widths;
            let distance = piece.closest(middle).0.sqrt();
            let least = distance - radius;
            if distance + radius < one.min(other) / 2.0 {
                farthest = farthest.min(distance + radius);
            }
            if least <= one.max(other) / 2.0 * (1.0 + ROUNDING) {
                concerned.push(Candidate { piece, least });
            }
        }
        concerned.retain(|candidate| candidate.least <= farthest);
    }

    /// The middles of its parts.
    fn middles(&self) -> impl Iterator<Item = Point3<f64>> {
        let ([u, v], [from, along]) = (self.sides, self.from);
        let (corner, parts) = (self.corner, self.parts);
        let upright = move |i: usize, j: usize| corner + u * (i as f64 + 1.0 / 3.0) + v * (j as f64 + 1.0 / 3.0);
        let turned = move |i: usize, j: usize| corner + u * (i as f64 + 2.0 / 3.0) + v * (j as f64 + 2.0 / 3.0);
        (from..(from + BLOCK).min(parts)).flat_map(move |i| {
            let rest = parts - i;
            let one = (along..(along + BLOCK).min(rest)).map(move |j| upright(i, j));
            one.chain((along..(along + BLOCK).min(rest - 1)).map(move |j| turned(i, j)))
        })
    }
}

/// Square of the distance to a segment, and how far along it the closest point is.
fn to_segment(p: Point3<f64>, from: Point3<f64>, to: Point3<f64>) -> (f64, f64) {
    let along = to - from;
    let square = along.norm_squared();
    let share = if square > 0.0 { ((p - from).dot(&along) / square).clamp(0.0, 1.0) } else { 0.0 };
    ((from + along * share - p).norm_squared(), share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Where a piece begins, the way to its end, and its widths there.
    type Line = ([f64; 3], [f64; 3], f64, f64);

    /// The first of the nearest pieces whose bead reaches a place: its path, and the share along it.
    fn nearest(pieces: &[Piece], place: Point3<f64>) -> Option<(usize, f64)> {
        let mut best = (f64::INFINITY, None);
        for piece in pieces {
            let (square, share) = piece.closest(place);
            let [one, other] = piece.widths;
            if square < best.0 && square <= ((one + (other - one) * share) / 2.0).powi(2) {
                best = (square, Some((piece.path, share)));
            }
        }
        best.1
    }

    proptest! {
        /// Slow twin: each part of a triangle asks all pieces.
        #[test]
        fn a_block_leaves_out_no_piece_that_gets_a_part_of_it(
            corners in prop::array::uniform3(prop::array::uniform3(-1.0_f64..1.0)),
            parts in 1_usize..9,
            ends in prop::collection::vec((prop::array::uniform3(-1.2_f64..1.2), prop::array::uniform3(-0.8_f64..0.8), 0.05_f64..1.5, 0.05_f64..1.5), 0..24),
        ) {
            let piece = |(path, (from, way, one, other)): (usize, &Line)| {
                let from = Point3::from(*from);
                Piece::new(path, [from, from + Vector3::from(*way)], [*one, *other], [0.0, 1.0])
            };
            let pieces: Vec<Piece> = ends.iter().enumerate().map(piece).collect();
            let (mut concerned, mut parts_of_block, mut count) = (Vec::new(), Parts::new(), 0);
            for block in Block::of(corners.map(Point3::from), parts) {
                block.concerned(pieces.iter(), &mut concerned);
                parts_of_block.fill(&block);
                concerned.iter().enumerate().for_each(|(k, candidate)| parts_of_block.offer(k, candidate.piece));
                let taken: Vec<_> = parts_of_block.taken().map(|(k, share)| (concerned[k].piece.path, share)).collect();
                let wanted: Vec<_> = block.middles().filter_map(|middle| nearest(&pieces, middle)).collect();
                prop_assert_eq!(taken, wanted);
                count += block.middles().count();
            }
            prop_assert_eq!(count, parts * parts);
        }
    }
}
