//! Convex pieces of a mesh: the hull of each connected piece.

use nalgebra::Point3;
use parry3d_f64::math::Vector;
use parry3d_f64::transformation::try_convex_hull;
use std::collections::BTreeMap;

/// A mesh of more connected pieces than this becomes one hull: screws and labels would cost more than they are worth.
const MAX_PIECES: usize = 32;

/// A computed hull may lack so much of its points, as a share of its size; if it lacks more, all points are kept.
const LACK: f64 = 1e-9;

/// Corners of convex hulls that contain the triangles: one for each piece that hangs together by corners at the same place, or
/// one for all of them where there are more than 32.
///
/// # Errors
/// In words: no triangle, or a corner that is no point.
pub(crate) fn convex_pieces(points: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<Vec<Vec<Point3<f64>>>, String> {
    if triangles.is_empty() {
        return Err("there is no triangle".into());
    }
    let places = same_places(points);
    let mut parent: Vec<usize> = (0..points.len()).collect();
    for (index, triangle) in triangles.iter().enumerate() {
        let mut roots = [0; 3];
        for (root, &corner) in roots.iter_mut().zip(triangle) {
            let place = places.get(corner as usize);
            let place =
                place.ok_or_else(|| format!("triangle {index} has corner {corner} of {} points", points.len()))?;
            *root = find(&mut parent, *place);
        }
        for pair in roots.windows(2) {
            let (a, b) = (find(&mut parent, pair[0]), find(&mut parent, pair[1]));
            parent[a.max(b)] = a.min(b);
        }
    }
    // By the first place of each piece, so that the order does not depend on anything else.
    let mut pieces: BTreeMap<usize, Vec<Point3<f64>>> = BTreeMap::new();
    let mut corners: Vec<usize> = triangles.as_flattened().iter().map(|&corner| places[corner as usize]).collect();
    corners.sort_unstable();
    corners.dedup();
    for corner in corners {
        pieces.entry(find(&mut parent, corner)).or_default().push(points[corner]);
    }
    let pieces: Vec<Vec<Point3<f64>>> = pieces.into_values().collect();
    let pieces = if pieces.len() > MAX_PIECES { vec![pieces.concat()] } else { pieces };
    Ok(pieces.into_iter().map(hull).collect())
}

/// For each point the first one at the same place.
fn same_places(points: &[Point3<f64>]) -> Vec<usize> {
    // Adding zero makes one of both zeros.
    let key = |point: &Point3<f64>| [0, 1, 2].map(|axis| (point[axis] + 0.0).to_bits());
    let mut first = BTreeMap::new();
    points.iter().enumerate().map(|(k, point)| *first.entry(key(point)).or_insert(k)).collect()
}

fn find(parent: &mut [usize], mut at: usize) -> usize {
    while parent[at] != at {
        parent[at] = parent[parent[at]];
        at = parent[at];
    }
    at
}

/// The corners of the hull of points; all points where no hull can be made of them or it does not contain them.
fn hull(points: Vec<Point3<f64>>) -> Vec<Point3<f64>> {
    let cloud: Vec<Vector> = points.iter().map(|p| Vector::new(p.x, p.y, p.z)).collect();
    let Ok((corners, faces)) = try_convex_hull(&cloud) else { return points };
    let corners: Vec<Point3<f64>> = corners.iter().map(|p| Point3::new(p.x, p.y, p.z)).collect();
    let size = points.iter().map(|point| (point - points[0]).norm()).fold(0.0, f64::max);
    let contains = faces.iter().all(|face| {
        let [a, b, c] = face.map(|k| corners[k as usize]);
        let Some(normal) = (b - a).cross(&(c - a)).try_normalize(f64::MIN_POSITIVE) else { return true };
        points.iter().all(|point| normal.dot(&(point - a)) <= LACK * size)
    });
    if contains { corners } else { points }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A block as six squares of two triangles, each with corners of its own as STL has them.
    fn block(low: [f64; 3], high: [f64; 3], points: &mut Vec<Point3<f64>>, triangles: &mut Vec<[u32; 3]>) {
        let corner =
            |k: usize| Point3::from([0, 1, 2].map(|axis| if k >> axis & 1 == 1 { high[axis] } else { low[axis] }));
        for [a, b, c, d] in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
            for triangle in [[a, b, c], [a, c, d]] {
                let first = points.len() as u32;
                points.extend(triangle.map(corner));
                triangles.push([first, first + 1, first + 2]);
            }
        }
    }

    #[test]
    fn each_connected_piece_becomes_its_hull() {
        let (mut points, mut triangles) = (vec![], vec![]);
        block([0.0; 3], [1.0, 2.0, 3.0], &mut points, &mut triangles);
        block([5.0, 0.0, 0.0], [6.0, 1.0, 1.0], &mut points, &mut triangles);
        let pieces = convex_pieces(&points, &triangles).unwrap();
        assert_eq!(pieces.iter().map(Vec::len).collect::<Vec<_>>(), [8, 8]);
        assert!(pieces[0].iter().all(|p| p.x <= 1.0) && pieces[1].iter().all(|p| p.x >= 5.0));
    }

    #[test]
    fn many_pieces_are_one_and_flat_ones_keep_their_points() {
        let (mut points, mut triangles) = (vec![], vec![]);
        for k in 0..40 {
            block([f64::from(k), 0.0, 0.0], [f64::from(k) + 0.5, 1.0, 1.0], &mut points, &mut triangles);
        }
        assert_eq!(convex_pieces(&points, &triangles).unwrap().len(), 1);
        let flat = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Point3::from);
        let pieces = convex_pieces(&flat, &[[0, 1, 2]]).unwrap();
        assert!(pieces.len() == 1 && pieces[0].len() == 3 && flat.iter().all(|point| pieces[0].contains(point)));
        assert!(convex_pieces(&flat, &[]).is_err());
        assert_eq!(convex_pieces(&flat, &[[0, 1, 3]]).unwrap_err(), "triangle 0 has corner 3 of 3 points");
    }
}
