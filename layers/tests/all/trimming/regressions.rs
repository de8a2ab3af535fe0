//! A test for each fault that was found.

use super::helpers::*;

fn sheet(vertices: &[[i32; 3]], triangles: &[[u32; 3]]) -> Mesh {
    let vertices = vertices.iter().map(|p| P::from(p.map(f64::from))).collect();
    Mesh { vertices, triangles: triangles.to_vec() }
}

/// A corner of the sheet that touches a face from below is inside by the infinitely small step. Its winding number was
/// taken for that of the pieces around it, which are outside.
#[test]
fn a_corner_that_touches_says_nothing_of_its_pieces() {
    let mesh = cuboid([1.0, 2.0, 2.0], [4.0, 4.0, 3.0]);
    let sheet = sheet(&[[3, 3, 2], [5, 3, 0], [3, 5, 0], [5, 5, 0]], &[[0, 1, 3], [0, 3, 2]]);
    assert!(trim(&mesh, &sheet).triangles.is_empty());
}

/// A mesh edge that passes through an edge of the sheet made a sliver on either side of it, one within the other's
/// longest side, of which neither could be turned.
#[test]
fn slivers_that_face_each_other_inside_are_made_one() {
    let mesh = cuboid([0.0, 0.0, 1.0], [4.0, 3.0, 3.0]).and(&cuboid([4.0, 0.0, 1.0], [5.0, 3.0, 3.0]));
    let sheet = sheet(
        &[[2, 0, 2], [4, 2, 2], [2, 4, 2], [2, 0, 4], [4, 2, 4], [2, 4, 4]],
        &[[0, 1, 3], [1, 4, 3], [1, 2, 5], [1, 5, 4]],
    );
    let trimmed = trim(&mesh, &sheet);
    check_inside(&mesh, &sheet, &trimmed);
    assert_eq!(trimmed.slivers, 0);
}

/// The same on the boundary: two slivers, one behind the other.
#[test]
fn slivers_on_the_boundary_are_dropped_one_after_the_other() {
    let mesh = cuboid([1.0, 0.0, 3.0], [3.0, 2.0, 4.0]).and(&cuboid([0.0, 1.0, 2.0], [4.0, 2.0, 4.0]));
    let sheet = sheet(
        &[[1, 0, 3], [1, 0, 5], [3, 1, 3], [3, 1, 5], [5, 0, 3], [5, 0, 5]],
        &[[0, 1, 2], [1, 3, 2], [2, 3, 5], [2, 5, 4]],
    );
    let trimmed = trim(&mesh, &sheet);
    check_inside(&mesh, &sheet, &trimmed);
    assert_eq!(trimmed.slivers, 0);
}

/// A segment along an edge that happened to be there passed by a point within rounding of it, which the segment of the
/// other face went through: a crack along the seam of two boxes.
#[test]
fn a_segment_goes_through_near_points_even_along_an_edge() {
    let lower = cuboid([0.0, 0.0, -3.0], [4.0, 4.0, 2.0]);
    let lid = grid([3, 3], [false; 2], |u, v| P::new(4.0 * u, 4.0 * v, 2.0)).turned();
    let top = lid.vertices.len() as u32;
    let mut upper = lid;
    upper.vertices.push(P::new(2.0, 2.0, 9.0));
    let rim = [0, 1, 2, 3, 7, 11, 15, 14, 13, 12, 8, 4];
    upper.triangles.extend((0..12).map(|k| [rim[k], rim[(k + 1) % 12], top]));
    let mesh = lower.and(&upper);
    let sheet = field(9.0, 23, |x, y| 2.0 + 0.37 * (x - 2.1) + 0.1 * y);
    let trimmed = trim(&mesh, &sheet);
    check_inside(&mesh, &sheet, &trimmed);
    // One outline: each vertex of the boundary has one edge that starts there.
    let mut next = std::collections::BTreeMap::new();
    trimmed.boundary.iter().for_each(|edge| assert_eq!(next.insert(edge.ends[0], edge.ends[1]), None));
    let (mut at, mut count) = (trimmed.boundary[0].ends[0], 0);
    loop {
        (at, count) = (next[&at], count + 1);
        if at == trimmed.boundary[0].ends[0] {
            break;
        }
    }
    assert_eq!(count, trimmed.boundary.len());
}

/// A triangle without height whose corner beside its longest side is on the boundary too: nothing could be turned, contracted or
/// dropped there, and surfaces with such a triangle have no geodesics. The two sides of it fall apart.
#[test]
fn a_triangle_without_height_between_two_boundaries_is_cut_out() {
    let mesh = cuboid([-1.0; 3], [5.0; 3]);
    let sheet = sheet(&[[0, 0, 0], [4, 0, 0], [2, 0, 0], [1, 2, 0], [3, 2, 0]], &[[0, 1, 2], [0, 2, 3], [2, 1, 4]]);
    let trimmed = trim(&mesh, &sheet);
    check(&sheet, &trimmed);
    assert_eq!((trimmed.slivers, trimmed.sources, trimmed.vertices.len()), (0, vec![1, 2], 6));
}

/// The same between four triangles: the slit that is left has no width, and both of its ends are single vertices.
#[test]
fn a_triangle_without_height_inside_leaves_a_slit() {
    let mesh = cuboid([-3.0; 3], [5.0; 3]);
    // Across the longest side lies a triangle without height as well, with its corner in another place.
    let sheet = sheet(
        &[[0, 0, 0], [4, 0, 0], [1, 0, 0], [3, 0, 0], [2, 2, 0], [2, -2, 0]],
        &[[0, 1, 2], [1, 0, 3], [0, 2, 4], [2, 1, 4], [0, 5, 3], [3, 5, 1]],
    );
    let trimmed = trim(&mesh, &sheet);
    check(&sheet, &trimmed);
    assert_eq!(trimmed.slivers, 0);
    assert!((trimmed.area() - 8.0).abs() < 1e-12);
}

/// A triangle without height on the boundary was cut out, and all its sides counted as ends on the mesh: one reached beyond the one that is.
#[test]
fn what_a_flat_triangle_leaves_is_on_the_mesh_or_a_border() {
    let mesh = sheet(&[[0, 0, 0], [4, 0, 2], [4, 3, 0], [4, 4, 1]], &[[0, 2, 1], [2, 3, 1], [0, 3, 1]]);
    let mut sheet = field(4.0, 4, |_, _| 0.0);
    let heights = |k: usize| [(12, 4.0), (18, 3.0)].iter().find(|at| at.0 == k).map_or(0.0, |at| at.1);
    sheet.vertices = (0..).zip(&sheet.vertices).map(|(k, p)| P::new(p.x + 2.0, p.y + 2.0, heights(k))).collect();
    check(&sheet, &trim(&mesh, &sheet));
}
