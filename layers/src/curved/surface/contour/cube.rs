//! One cube of the lattice: which of its crossed edges belong to the same piece of the surface.
//!
//! Corners of a cube are numbered by the bits x, y, z. Edge `4 a + j` runs along axis `a`; with `b` and `c` the
//! axes after `a` in turn, bit 0 of `j` is the side along `b`, bit 1 the side along `c`. Face `2 a + s` lies across
//! axis `a` on side `s`.
//!
//! The surface crosses a joined edge once, in *slot* `e` for edge `e`. Along an edge that is cut each end may be left on its
//! own half: slot `e` is the half at the lower corner, slot `12 + e` the half at the other one.
//!
//! A line of the surface crosses a face of the cube from one crossed slot to another. The rule for which two is
//! decided in the face alone, so the cubes on both sides of it agree, and a slot has at most one partner in a face.
//! So the crossed slots of a cube form chains and rings, and each of these is a *piece* of the surface with a vertex
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

/// Slots of a cube.
pub(super) const SLOTS: usize = 24;

/// How the surface meets a cube.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Crossed {
    /// Bit `k`: corner `k` has reached the level.
    pub(super) above: u8,
    /// Bit `e`: the ends of edge `e` are joined.
    pub(super) joined: u16,
    /// Bit `s`: the surface crosses slot `s`.
    pub(super) slots: u32,
}

/// The pieces of the surface in a cube.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Pieces {
    /// The piece of each crossed slot.
    pub(super) of: [u8; SLOTS],
    pub(super) count: u8,
    /// Bit `f`: two lines of one piece cross or reach face `f`.
    pub(super) doubled: u8,
}

impl Crossed {
    /// # Arguments
    /// * `halves`: the slots along cut edges that are crossed.
    pub(super) fn new(above: u8, joined: u16, halves: u32) -> Self {
        let whole = (0..12).fold(0, |bits, edge| {
            let low = LOW_CORNER[edge];
            let differ = (above >> low ^ above >> (low | 1 << (edge / 4))) & 1 == 1;
            bits | u32::from(differ && joined >> edge & 1 == 1) << edge
        });
        Crossed { above, joined, slots: whole | halves }
    }

    fn is_above(&self, corner: usize) -> bool {
        self.above >> corner & 1 == 1
    }

    fn is_joined(&self, edge: usize) -> bool {
        self.joined >> edge & 1 == 1
    }

    /// Whether the surface crosses the slot.
    pub(super) fn has(&self, slot: usize) -> bool {
        self.slots >> slot & 1 == 1
    }

    /// The pieces that the surface falls into.
    pub(super) fn pieces(&self) -> Pieces {
        // Slots beyond the edges are rare.
        let slots = if self.slots >> 12 == 0 { 12 } else { SLOTS };
        let mut group: [u8; SLOTS] = std::array::from_fn(|slot| slot as u8);
        let links: [Links; 6] = std::array::from_fn(|face| self.links(face));
        // Each link makes one group of two.
        for (one, other) in links.iter().flat_map(Links::pairs) {
            let [kept, gone] = [group[one], group[other]];
            group[..slots].iter_mut().filter(|g| **g == gone).for_each(|g| *g = kept);
        }
        let mut pieces = Pieces { of: [u8::MAX; SLOTS], count: 0, doubled: 0 };
        for slot in 0..slots {
            if self.has(slot) && pieces.of[slot] == u8::MAX {
                for other in slot..slots {
                    if self.has(other) && group[other] == group[slot] {
                        pieces.of[other] = pieces.count;
                    }
                }
                pieces.count += 1;
            }
        }
        for (face, edges) in FACES.iter().enumerate() {
            // Lines across the face: those that join two slots, and those that end at a cut.
            let linked = |slot: usize| links[face].pairs().any(|(_, other)| other == slot);
            let lines = edges.iter().flat_map(|&(edge, _)| [edge, edge + 12]);
            let mut seen = [false; SLOTS];
            for line in lines.filter(|&slot| self.has(slot) && !linked(slot)) {
                let piece = usize::from(pieces.of[line]);
                pieces.doubled |= u8::from(seen[piece]) << face;
                seen[piece] = true;
            }
        }
        pieces
    }

    /// The slot with which `slot` is linked across `face`.
    pub(super) fn partner(&self, face: usize, slot: usize) -> Option<usize> {
        self.links(face).pairs().find_map(|(one, other)| match slot {
            _ if slot == one => Some(other),
            _ if slot == other => Some(one),
            _ => None,
        })
    }

    /// The axes along which the piece comes to an end: where a line of it ends in a face, all corners that hang together
    /// there are on one side; of two such axes the one along which the `slope` is less.
    pub(super) fn ends(&self, pieces: &Pieces, piece: u8, slope: [f64; 3]) -> [bool; 3] {
        let mut ends = [false; 3];
        for (face, edges) in FACES.iter().enumerate() {
            for &(edge, _) in edges {
                for slot in [edge, edge + 12] {
                    if pieces.of[slot] == piece && self.partner(face, slot).is_none() {
                        let corners = self.chain_of(face, slot);
                        let is_end = |axis: &usize| corners.iter().all(|c| (c ^ corners[0]) >> axis & 1 == 0);
                        let flatter = |a: &usize, b: &usize| slope[*a].abs().total_cmp(&slope[*b].abs());
                        if let Some(axis) = after(face / 2).into_iter().filter(is_end).min_by(flatter) {
                            ends[axis] = true;
                        }
                    }
                }
            }
        }
        ends
    }

    /// The corners of a face that hang together with a slot, some of them more than once.
    fn chain_of(&self, face: usize, slot: usize) -> [usize; 4] {
        let edge = slot % 12;
        let near = if slot < 12 { LOW_CORNER[edge] } else { LOW_CORNER[edge] | 1 << (edge / 4) };
        let edges = &FACES[face];
        let at = edges.iter().position(|&(_, corner)| corner == near).unwrap_or(0);
        let mut chain = [near; 4];
        let mut len = 1;
        for k in (at..at + 3).map(|k| k % 4).take_while(|&k| self.is_joined(edges[k].0)) {
            chain[len] = edges[(k + 1) % 4].1;
            len += 1;
        }
        for k in (at + 1..at + 4).rev().map(|k| k % 4).take_while(|&k| self.is_joined(edges[k].0)) {
            if len == 4 {
                break;
            }
            chain[len] = edges[k].1;
            len += 1;
        }
        chain
    }

    /// Whose ends the lines across a face join.
    ///
    /// Around the face the corners form a ring, or chains that end at the cut edges. Along each of these lines run
    /// around what is above; a line that is left over ends at the cut.
    fn links(&self, face: usize) -> Links {
        let edges = &FACES[face];
        let mut links = Links::default();
        // From behind a cut on, so that each chain is walked from its start to its end; without a cut the corners are a ring.
        let after_cut = (0..4).find(|&k| !self.is_joined(edges[(k + 3) % 4].0));
        let mut chain = Chain::default();
        for k in (0..4).map(|i| (after_cut.unwrap_or(0) + i) % 4) {
            // Corner k lies between edge k - 1 and edge k.
            let ((before, _), (edge, corner)) = (edges[(k + 3) % 4], edges[k]);
            if !self.is_joined(before) {
                links.take(&chain, false);
                chain = Chain::default();
                self.cross(half(before, corner), corner, &mut chain);
            }
            if self.is_joined(edge) {
                self.cross(edge, edges[(k + 1) % 4].1, &mut chain);
            } else {
                self.cross(half(edge, corner), corner, &mut chain);
            }
        }
        links.take(&chain, after_cut.is_none());
        links
    }

    /// Adds the slot to the chain if it is crossed; then comes `next`.
    fn cross(&self, slot: usize, next: usize, chain: &mut Chain) {
        if self.has(slot) {
            chain.slots[chain.len] = (slot, self.is_above(next));
            chain.len += 1;
        }
    }
}

/// The half of a cut edge at one of its corners.
fn half(edge: usize, corner: usize) -> usize {
    if LOW_CORNER[edge] == corner { edge } else { 12 + edge }
}

/// Crossed slots in turn, and whether the corner after each is above.
#[derive(Default)]
struct Chain {
    slots: [(usize, bool); 5],
    len: usize,
}

/// Pairs of slots that a line joins.
#[derive(Clone, Copy, Default)]
struct Links {
    of: [(usize, usize); 4],
    len: usize,
}

impl Links {
    fn pairs(&self) -> impl Iterator<Item = (usize, usize)> {
        self.of[..self.len].iter().copied()
    }

    /// Links the slots of a chain, or of a ring.
    fn take(&mut self, chain: &Chain, is_ring: bool) {
        let slots = &chain.slots[..chain.len];
        let mut push = |one: usize, other: usize| {
            self.of[self.len] = (one, other);
            self.len += 1;
        };
        if let [(one, _), (other, _)] = *slots {
            push(one, other);
            return;
        }
        // With more than two, the corner between two of them decides: those around what is above belong together.
        for pair in slots.windows(2) {
            if pair[0].1 {
                push(pair[0].0, pair[1].0);
            }
        }
        if let (true, [(first, _), .., (last, true)]) = (is_ring, slots) {
            push(*last, *first);
        }
    }
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

    fn whole(above: u8) -> Crossed {
        Crossed::new(above, ALL_JOINED, 0)
    }

    #[test]
    fn in_a_whole_cube_every_crossed_edge_has_a_partner_in_both_faces() {
        for above in 0..=255 {
            let (crossed, pieces) = (whole(above), whole(above).pieces());
            for edge in (0..12).filter(|&edge| pieces.of[edge] != u8::MAX) {
                let partners = (0..6).filter(|&face| crossed.partner(face, edge).is_some()).count();
                assert_eq!(partners, 2, "{above:08b} edge {edge}");
            }
            assert!(pieces.count <= 4);
        }
    }

    #[test]
    fn corners_that_have_reached_the_level_alone_are_kept_apart() {
        assert_eq!(whole(0b0000_0001).pieces().count, 1);
        assert_eq!(whole(0b0100_0001 | 0b1000).pieces().count, 3);
        assert_eq!(whole(0b0110_1001).pieces().count, 4);
        assert_eq!(whole(0b0000_1111).pieces().count, 1);
    }

    #[test]
    fn two_columns_with_a_cut_between_them_are_two_pieces() {
        // The surface goes through the four upright edges; those along x, 0 to 3, are cut.
        let cut = ALL_JOINED & !0b1111;
        let pieces = Crossed::new(0b1111_0000, cut, 0).pieces();
        assert_eq!(pieces.count, 2);
        let upright = [8, 9, 10, 11].map(|edge| pieces.of[edge]);
        assert_eq!(upright, [0, 1, 0, 1]);
    }

    #[test]
    fn sheets_with_a_cut_between_them_are_two_pieces() {
        // The upright edges, 8 to 11, are cut; both sheets end on their halves of them.
        let pieces = Crossed::new(0, ALL_JOINED & !0xf00, 0xf00 | 0xf00 << 12).pieces();
        assert_eq!(pieces.count, 2);
        for edge in 8..12 {
            assert_eq!([pieces.of[edge], pieces.of[12 + edge]], [0, 1]);
        }
        assert_eq!(pieces.doubled, 0);
    }

    #[test]
    fn a_corner_that_is_cut_off_is_a_piece_of_its_own() {
        // Corner 7 ends edges 3, 7 and 11, all cut; it has a surface above it, and so have the others.
        let cut = ALL_JOINED & !(1 << 3 | 1 << 7 | 1 << 11);
        let crossed = Crossed::new(0b0000_1111, cut, 1 << (12 + 11));
        let pieces = crossed.pieces();
        assert_eq!(pieces.count, 2);
        assert_eq!([8, 9, 10].map(|edge| pieces.of[edge]), [0; 3]);
        assert!((0..6).all(|face| crossed.partner(face, 12 + 11).is_none()));
    }

    #[test]
    fn no_slot_has_two_partners_in_a_face_whatever_is_cut() {
        for face in (0..6).step_by(2) {
            let edges = FACES[face].map(|(edge, _)| edge);
            for above in 0..=255 {
                for cut in 0..16 {
                    let cut = edges.iter().enumerate().filter(|(k, _)| cut >> k & 1 == 1).map(|(_, &edge)| edge);
                    let cut: Vec<usize> = cut.collect();
                    let joined = cut.iter().fold(ALL_JOINED, |joined, edge| joined & !(1 << edge));
                    for halves in 0..1 << (2 * cut.len()) {
                        let half = |(k, &edge): (usize, &usize)| {
                            (halves >> (2 * k) & 1) << edge | (halves >> (2 * k + 1) & 1) << (12 + edge)
                        };
                        let crossed = Crossed::new(above, joined, cut.iter().enumerate().map(half).sum());
                        for slot in edges.iter().flat_map(|&edge| [edge, edge + 12]) {
                            let Some(other) = crossed.partner(face, slot) else { continue };
                            assert!(crossed.has(slot) && crossed.has(other) && slot != other);
                            assert_eq!(crossed.partner(face, other), Some(slot));
                        }
                    }
                }
            }
        }
    }
}
