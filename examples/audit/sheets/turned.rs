//! Which side of a layer the nozzle is on. Triangles of a piece are turned alike, as most of them look. Then a level surface looks up; a steep one, as layers
//! around a core are, looks away from what is beside it and was laid before. Its pieces are turned together: what grows downwards in one place looks down there.

use super::sheet::{Sheet, edges};
use super::slabs::percentiles;
use super::stack::Stack;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Triangles of a piece that are asked, about.
const ASKED: usize = 60;
/// Surfaces whose mean normal leans less than this (the cosine) are level: a nozzle comes from above. On others it may come from below.
const LEVEL: f64 = 0.5;
/// What is farther than so many heights is not beside a surface.
const NEAR_HEIGHTS: f64 = 1.5;

/// What was turned, and what was found on the way.
#[derive(Default)]
pub struct Turned {
    /// Pieces: triangles that are joined by edges.
    pub pieces: usize,
    /// Pieces of the layer that has most.
    pub most_pieces: usize,
    /// Layers of which a surface was turned over.
    pub layers: usize,
    /// Triangles that were turned unlike their neighbours.
    pub triangles: usize,
    /// Surfaces without a border.
    pub closed: usize,
    /// How high layers are in the rules, if that is known.
    pub height: Option<f64>,
}

/// A triangle that stands for some of a piece.
struct Asked {
    up: Vector3<f64>,
    area: f64,
    /// How far it is to what was laid before, against `up` and along it.
    gaps: [Option<f64>; 2],
}

/// A surface in pieces: triangles, each with whether it is turned against most of its piece.
struct Pieces {
    all: Vec<Vec<(u32, bool)>>,
    is_closed: bool,
    asked: Vec<Asked>,
}

/// Turns all sheets, and sets their normals.
///
/// # Arguments
/// * `from_plate`: how high the first layer is if its surface is a millimetre above the plate.
/// * `height`: of layers, where it is given.
pub fn turn(sheets: &mut [Sheet], stack: &Stack, from_plate: f64, height: Option<f64>) -> Turned {
    let of_sheet = |sheet: &Sheet| {
        let (all, is_closed) = pieces(&sheet.triangles);
        let asked = all.iter().flat_map(|piece| ask(sheet, piece, stack, from_plate)).collect();
        Pieces { all, is_closed, asked }
    };
    let pieces: Vec<Pieces> = sheets.par_iter().map(of_sheet).collect();
    let asked = pieces.iter().flat_map(|pieces| &pieces.asked);
    let nearest = asked.filter_map(|asked| Some((asked.gaps.into_iter().flatten().reduce(f64::min)?, asked.area)));
    let measured = percentiles(nearest.collect(), [0.5]).map(|[median]| median);
    let mut turned = Turned { height: height.or(measured), ..Turned::default() };
    let near = NEAR_HEIGHTS * turned.height.unwrap_or(f64::INFINITY);
    let mut in_layer = (None, 0, false);
    for (sheet, pieces) in sheets.iter_mut().zip(&pieces) {
        if in_layer.0 != Some(sheet.rank) {
            in_layer = (Some(sheet.rank), 0, false);
        }
        in_layer.1 += pieces.all.len();
        turned.pieces += pieces.all.len();
        turned.closed += usize::from(pieces.is_closed);
        turned.most_pieces = turned.most_pieces.max(in_layer.1);
        let is_over = is_over(&pieces.asked, near);
        if is_over && !std::mem::replace(&mut in_layer.2, true) {
            turned.layers += 1;
        }
        for &(triangle, is_against) in pieces.all.iter().flatten() {
            turned.triangles += usize::from(is_against);
            if is_against != is_over {
                sheet.triangles[triangle as usize].swap(1, 2);
            }
        }
        sheet.set_normals();
    }
    turned
}

/// Whether a surface looks the wrong way.
fn is_over(asked: &[Asked], near: f64) -> bool {
    let area: f64 = asked.iter().map(|asked| asked.area).sum();
    let up: f64 = asked.iter().map(|asked| asked.up.z * asked.area).sum();
    if up.abs() >= LEVEL * area {
        return up < 0.0;
    }
    let vote = |asked: &Asked| {
        let is_up = match asked.gaps.map(|gap| gap.filter(|gap| *gap <= near)) {
            [Some(below), Some(above)] => below <= above,
            [None, None] => asked.up.z >= 0.0,
            [below, _] => below.is_some(),
        };
        if is_up { asked.area } else { -asked.area }
    };
    asked.iter().map(vote).sum::<f64>() < 0.0
}

/// Asks some triangles of a piece.
fn ask(sheet: &Sheet, piece: &[(u32, bool)], stack: &Stack, from_plate: f64) -> Vec<Asked> {
    let step = piece.len().div_ceil(ASKED);
    let one = |&(triangle, is_against): &(u32, bool)| {
        let [a, b, c] = sheet.corners(&sheet.triangles[triangle as usize]);
        let normal = (b - a).cross(&(c - a)) * if is_against { -0.5 } else { 0.5 };
        let up = normal.try_normalize(0.0)?;
        let middle = Point3::from((a.coords + b.coords + c.coords) / 3.0);
        let gaps = [up, -up].map(|up| stack.below(middle, up, sheet.rank, from_plate));
        Some(Asked { up, area: normal.norm() * step as f64, gaps })
    };
    piece.iter().step_by(step).filter_map(one).collect()
}

/// Triangles that are joined by edges of two triangles, each with whether it is turned against most of its piece; of equally many, against the first. And
/// whether no edge is of one triangle alone.
fn pieces(triangles: &[[u32; 3]]) -> (Vec<Vec<(u32, bool)>>, bool) {
    let edges = edges(triangles);
    let is_closed = edges.chunk_by(|a, b| a.0 == b.0).all(|shared| shared.len() > 1);
    let mut beside = vec![Vec::new(); triangles.len()];
    for shared in edges.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, one, forth), (_, two, also)] = *shared {
            beside[one as usize].push((two, forth == also));
            beside[two as usize].push((one, forth == also));
        }
    }
    let mut is_known = vec![false; triangles.len()];
    let mut pieces = Vec::new();
    for first in 0..triangles.len() as u32 {
        if std::mem::replace(&mut is_known[first as usize], true) {
            continue;
        }
        let mut piece = vec![(first, false)];
        let mut next = 0;
        while let Some(&(triangle, is_against)) = piece.get(next) {
            next += 1;
            for &(other, differs) in &beside[triangle as usize] {
                if !std::mem::replace(&mut is_known[other as usize], true) {
                    piece.push((other, is_against ^ differs));
                }
            }
        }
        let against = piece.iter().filter(|(_, is_against)| *is_against).count();
        if 2 * against > piece.len() {
            piece.iter_mut().for_each(|(_, is_against)| *is_against = !*is_against);
        }
        pieces.push(piece);
    }
    (pieces, is_closed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_of_a_piece_look_one_way() {
        // A square whose second half is turned, and a triangle beside it that shares a corner only.
        let found = pieces(&[[0, 1, 2], [0, 3, 2], [2, 4, 5]]);
        assert_eq!(found, (vec![vec![(0, false), (1, true)], vec![(2, false)]], false));
        assert_eq!(pieces(&[[0, 1, 2], [0, 2, 3]]).0, vec![vec![(0, false), (1, false)]]);
        // Most of a strip decide.
        assert_eq!(pieces(&[[0, 2, 1], [0, 2, 3], [0, 3, 4]]).0, vec![vec![(0, true), (1, false), (2, false)]]);
        assert!(pieces(&[[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]).1);
    }
}
