//! One cube of the lattice: which of its crossed edges belong to the same piece of the surface.
//!
//! Corners of a cube are numbered by the bits x, y, z. Edge `4 a + j` runs along axis `a`; with `b` and `c` the
//! axes after `a` in turn, bit 0 of `j` is the side along `b`, bit 1 the side along `c`. Face `2 a + s` lies across
//! axis `a` on side `s`.
//!
//! A line of the surface crosses a face of the cube from one crossed edge to another. The rule for which two is
//! decided in the face alone, so the cubes on both sides of it agree, and an edge has at most one partner in a face.
//! So the crossed edges of a cube form chains and rings, and each of these is a *piece* of the surface with a vertex
//! of its own (Nielson, "Dual marching cubes", IEEE Visualization 2004, for whole cubes).

/// Lower corner of each edge.
pub(super) const LOW_CORNER: [usize; 12] = low_corners();

/// The four edges of each face in turn around it, and the corner before each.
const FACES: [[(usize, usize); 4]; 6] = faces();

const fn low_corners() -> [usize; 12] {
    let mut corners = [0; 12];
    let mut edge = 0;
    while edge < 12 {
        let [b, c] = after(edge / 4);
        corners[edge] = (edge & 1) << b | (edge >> 1 & 1) << c;
        edge += 1;
    }
    corners
}

const fn faces() -> [[(usize, usize); 4]; 6] {
    let mut faces = [[(0, 0); 4]; 6];
    let mut face = 0;
    while face < 6 {
        let (axis, side) = (face / 2, face % 2);
        let [b, c] = after(axis);
        let base = side << axis;
        let around = [(base, b), (base | 1 << b, c), (base | 1 << c, b), (base, c)];
        let corner = [base, base | 1 << b, base | 1 << b | 1 << c, base | 1 << c];
        let mut k = 0;
        while k < 4 {
            faces[face][k] = (edge_at(around[k].0, around[k].1), corner[k]);
            k += 1;
        }
        face += 1;
    }
    faces
}

/// The edge along `axis` that begins at `corner`.
const fn edge_at(corner: usize, axis: usize) -> usize {
    let [b, c] = after(axis);
    4 * axis + (corner >> b & 1) + 2 * (corner >> c & 1)
}

/// The other two axes in turn.
pub(super) const fn after(axis: usize) -> [usize; 2] {
    [(axis + 1) % 3, (axis + 2) % 3]
}

/// The pieces of the surface in a cube.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Pieces {
    /// The piece of each crossed edge.
    pub(super) of: [u8; 12],
    pub(super) count: u8,
    /// Bit `f`: two lines of one piece cross or reach face `f`.
    pub(super) doubled: u8,
}

impl Pieces {
    /// # Arguments
    /// * `above`: bit `k`: corner `k` has reached the level.
    /// * `joined`: bit `e`: the ends of edge `e` are joined. The surface crosses no other edge.
    pub(super) fn new(above: u8, joined: u16) -> Self {
        let is_above = |corner: usize| above >> corner & 1 == 1;
        let crossed = crossed(above, joined);
        let mut group: [u8; 12] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11];
        let mut links = [[None; 2]; 6];
        for (face, edges) in FACES.iter().enumerate() {
            links[face] = links_of(edges, crossed, joined, is_above);
            for (one, other) in links[face].into_iter().flatten() {
                let [kept, gone] = [group[one], group[other]];
                group.iter_mut().filter(|g| **g == gone).for_each(|g| *g = kept);
            }
        }
        let mut pieces = Pieces { of: [u8::MAX; 12], count: 0, doubled: 0 };
        for edge in 0..12 {
            if crossed >> edge & 1 == 1 && pieces.of[edge] == u8::MAX {
                for other in edge..12 {
                    if crossed >> other & 1 == 1 && group[other] == group[edge] {
                        pieces.of[other] = pieces.count;
                    }
                }
                pieces.count += 1;
            }
        }
        for (face, edges) in FACES.iter().enumerate() {
            // Lines across the face: those that join two edges, and those that end at a cut.
            let linked = |edge: usize| links[face].iter().flatten().any(|&(_, other)| other == edge);
            let lines = edges.iter().map(|&(edge, _)| edge).filter(|&edge| crossed >> edge & 1 == 1 && !linked(edge));
            let mut seen = [false; 12];
            for line in lines {
                let piece = usize::from(pieces.of[line]);
                pieces.doubled |= u8::from(seen[piece]) << face;
                seen[piece] = true;
            }
        }
        pieces
    }
}

/// Bit `e`: edge `e` is joined and its ends lie on both sides of the level.
fn crossed(above: u8, joined: u16) -> u16 {
    (0..12).fold(0, |bits, edge| {
        let low = LOW_CORNER[edge];
        let differ = (above >> low ^ above >> (low | 1 << (edge / 4))) & 1 == 1;
        bits | u16::from(differ && joined >> edge & 1 == 1) << edge
    })
}

/// Whose ends a line across a face joins: at most two pairs of crossed edges.
fn links_of(
    edges: &[(usize, usize); 4],
    crossed: u16,
    joined: u16,
    is_above: impl Fn(usize) -> bool,
) -> [Option<(usize, usize)>; 2] {
    let is_crossed = |k: usize| crossed >> edges[k % 4].0 & 1 == 1;
    let is_whole = |k: usize| joined >> edges[k % 4].0 & 1 == 1 && !is_crossed(k);
    let pair = |one: usize, other: usize| Some((edges[one % 4].0, edges[other % 4].0));
    match (0..4).filter(|&k| is_crossed(k)).count() {
        2 => {
            for k in 0..4 {
                if is_crossed(k) && is_crossed(k + 1) {
                    return [pair(k, k + 1), None];
                }
            }
            // Opposite edges: the line runs beside an edge that is not crossed, unless both of those are cut.
            let k = usize::from(!is_crossed(0));
            if is_whole(k + 1) || is_whole(k + 3) { [pair(k, k + 2), None] } else { [None, None] }
        }
        3 | 4 => {
            // What has reached the level is kept apart: lines run around the corners above.
            let mut links = [None; 2];
            let mut found = 0;
            for (k, &(_, corner)) in edges.iter().enumerate() {
                // Corner k lies between edge k - 1 and edge k.
                if is_above(corner) && is_crossed(k) && is_crossed(k + 3) {
                    links[found] = pair(k + 3, k);
                    found += 1;
                }
            }
            links
        }
        _ => [None, None],
    }
}

/// The edge with which `edge` is linked across `face`.
pub(super) fn partner(face: usize, edge: usize, above: u8, joined: u16) -> Option<usize> {
    let is_above = |corner: usize| above >> corner & 1 == 1;
    links_of(&FACES[face], crossed(above, joined), joined, is_above).into_iter().flatten().find_map(|(one, other)| {
        if one == edge {
            Some(other)
        } else if other == edge {
            Some(one)
        } else {
            None
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL_JOINED: u16 = 0xfff;

    #[test]
    fn edges_and_faces_are_numbered_as_said() {
        for (edge, &corner) in LOW_CORNER.iter().enumerate() {
            assert_eq!(edge_at(corner, edge / 4), edge);
        }
        for (face, edges) in FACES.iter().enumerate() {
            for k in 0..4 {
                let (edge, corner) = edges[k];
                let next = edges[(k + 1) % 4].1;
                assert_eq!(corner >> (face / 2) & 1, face % 2);
                let ends = [LOW_CORNER[edge], LOW_CORNER[edge] | 1 << (edge / 4)];
                assert!(ends == [corner, next] || ends == [next, corner], "face {face} edge {k}");
            }
        }
    }

    #[test]
    fn in_a_whole_cube_every_crossed_edge_has_a_partner_in_both_faces() {
        for above in 0..=255 {
            let pieces = Pieces::new(above, ALL_JOINED);
            for edge in (0..12).filter(|&edge| pieces.of[edge] != u8::MAX) {
                let partners = (0..6).filter(|&face| partner(face, edge, above, ALL_JOINED).is_some()).count();
                assert_eq!(partners, 2, "{above:08b} edge {edge}");
            }
            assert!(pieces.count <= 4);
        }
    }

    #[test]
    fn corners_that_have_reached_the_level_alone_are_kept_apart() {
        assert_eq!(Pieces::new(0b0000_0001, ALL_JOINED).count, 1);
        assert_eq!(Pieces::new(0b0100_0001 | 0b1000, ALL_JOINED).count, 3);
        assert_eq!(Pieces::new(0b0110_1001, ALL_JOINED).count, 4);
        assert_eq!(Pieces::new(0b0000_1111, ALL_JOINED).count, 1);
    }

    #[test]
    fn two_columns_with_a_cut_between_them_are_two_pieces() {
        // The surface goes through the four upright edges; those along x, 0 to 3, are cut.
        let cut = ALL_JOINED & !0b1111;
        let pieces = Pieces::new(0b1111_0000, cut);
        assert_eq!(pieces.count, 2);
        let upright = [8, 9, 10, 11].map(|edge| pieces.of[edge]);
        assert_eq!(upright, [0, 1, 0, 1]);
    }

    #[test]
    fn no_edge_has_two_partners_in_a_face_whatever_is_cut() {
        for above in 0..=255 {
            for joined in 0..=ALL_JOINED {
                for (face, edges) in FACES.iter().enumerate().step_by(2) {
                    let partner = |edge| partner(face, edge, above, joined);
                    for (edge, _) in edges {
                        assert!(partner(*edge).is_none_or(|other| partner(other) == Some(*edge)));
                    }
                }
            }
        }
    }
}
