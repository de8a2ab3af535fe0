//! Triangles without height are taken out.
//!
//! A cut that passes a vertex or an edge closely leaves triangles of which one altitude is almost nothing.
//! * Where a side is that short too, it is contracted.
//! * Else a corner lies near the longest side. That side is turned to the other diagonal. If two such corners face each
//!   other across it, the diagonal is short and contracted.
//! * Else, on the boundary, the triangle is dropped, and the boundary runs along its other sides.
//!
//! Nothing is done that would leave a surface that is not a manifold, turn a triangle over, or move the boundary off the
//! mesh: new boundary vertices and midpoints are held against the mesh. So some slivers stay, and are counted: where
//! the solid itself is that thin, for one. Those without any height are cut out in the end ([`FLAT`]): no direction and no distance can be
//! measured on them. The surface then ends on both sides of a slit without width.

use super::solid::Solid;
use super::surface::{Across, Surface, next, previous};
use super::triangle::{MIN_ALTITUDE_MM, altitude};
use super::trimmed::BoundaryKind;
use nalgebra::{Point3, Vector3};

/// How far from the mesh a boundary may come to lie, mm: half of what is promised.
const ON_MESH_MM: f64 = 5e-7;

/// A side this long is contracted, mm. A triangle with longer sides and no height has its corner beside a side.
const SHORT_MM: f64 = 2.0 * MIN_ALTITUDE_MM;

/// How far a boundary may leave the mesh where its edges are put together, as a share of their length. Less keeps the edges of narrow
/// facets, more rounds off what a bead can still show.
const THIN: f64 = 0.02;

/// How far a corner may move where edges of the boundary are put together, in lengths of these. One edge after the other would lead any distance away.
pub(crate) const MOVED: f64 = 2.0;

/// Altitude of a triangle without height, as a share of its longest side: far above what rounding makes of 0, far below what a
/// computation on the surface can use.
const FLAT: f64 = 1e-9;

/// Rounds over all slivers. Two are usual: what one leaves the next takes.
const ROUNDS: usize = 8;

/// Takes slivers out where that can be done.
pub(super) fn remove_slivers(surface: &mut Surface, solid: &Solid) {
    let mut cleaner = Cleaner { surface, solid, on_mesh_mm: ON_MESH_MM, moved: None, fans: Default::default() };
    for _ in 0..ROUNDS {
        let is_sliver = |triangle: &usize| altitude(&cleaner.surface.corners(*triangle)) < MIN_ALTITUDE_MM;
        let slivers: Vec<_> = cleaner.surface.present().filter(is_sliver).collect();
        let mut changed = false;
        for sliver in slivers {
            changed |= cleaner.remove(sliver);
        }
        if !changed {
            break;
        }
    }
    let flat: Vec<_> = cleaner.surface.present().filter(|&triangle| cleaner.is_flat(triangle)).collect();
    flat.into_iter().for_each(|triangle| cleaner.cut_out(triangle));
}

/// Puts edges of the boundary on the mesh together that are shorter than a length, where the boundary then keeps within
/// a share of it, [`THIN`], to the mesh. No corner moves by more than [`MOVED`] times that length.
///
/// A mesh of very many narrow facets gives each of them an edge, which costs time wherever the boundary is looked at and says
/// nothing that a bead could show.
pub(super) fn thin_boundary(surface: &mut Surface, solid: &Solid, length_mm: f64) {
    let moved = Some(Moved { so_far: vec![0.0; surface.points.len()], most_mm: MOVED * length_mm });
    let mut cleaner = Cleaner { surface, solid, on_mesh_mm: THIN * length_mm, moved, fans: Default::default() };
    for half in 0..3 * cleaner.surface.triangles.len() as u32 {
        let is_on_mesh = cleaner.surface.across(half) == Across::End(BoundaryKind::Mesh);
        if is_on_mesh && !cleaner.surface.gone[half as usize / 3] && cleaner.length(half) < length_mm {
            cleaner.contract(half);
        }
    }
}

struct Cleaner<'a> {
    surface: &'a mut Surface,
    solid: &'a Solid,
    /// How far from the mesh a boundary may come to lie, mm.
    on_mesh_mm: f64,
    /// How far corners have moved, if that is bounded.
    moved: Option<Moved>,
    fans: [Vec<u32>; 2],
}

/// How far the corners of triangles have moved from vertex to vertex.
struct Moved {
    /// For each vertex the longest way of a corner that has come there, mm.
    so_far: Vec<f64>,
    most_mm: f64,
}

impl Moved {
    /// How far corners at a vertex will have moved when they go on to another one; `None` if that is too far.
    fn onward(&self, lost: u32, way_mm: f64) -> Option<f64> {
        Some(self.so_far[lost as usize] + way_mm).filter(|&moved| moved <= self.most_mm)
    }
}

impl Cleaner<'_> {
    fn remove(&mut self, triangle: usize) -> bool {
        // An earlier step may have taken or mended it.
        if self.surface.gone[triangle] || altitude(&self.surface.corners(triangle)) >= MIN_ALTITUDE_MM {
            return false;
        }
        let mut sides = [0, 1, 2].map(|k| {
            let half = 3 * triangle as u32 + k;
            (self.length(half), half)
        });
        sides.sort_by(|a, b| a.0.total_cmp(&b.0));
        let [(shortest, short), _, (_, long)] = sides;
        if shortest < SHORT_MM && self.contract(short) {
            return true;
        }
        let turned = matches!(self.surface.across(long), Across::Half(back) if self.turn(long, back));
        turned || self.drop(sides.map(|(_, half)| half))
    }

    fn length(&self, half: u32) -> f64 {
        (self.surface.place(next(half)) - self.surface.place(half)).norm()
    }

    /// Contracts an edge to one of its ends. An edge of the boundary rather to the end that leaves the boundary nearer to where it was: a corner
    /// beside a short edge stays.
    fn contract(&mut self, half: u32) -> bool {
        let [mut near, mut far] = std::mem::take(&mut self.fans);
        // Half-edges from both ends, in the triangle.
        let other = next(half);
        self.surface.fan(half, &mut near);
        self.surface.fan(other, &mut far);
        let ends = [(half, &near), (other, &far)];
        let off = |kept: usize| self.cut_off(half, ends[1 - kept].1, ends[kept].0);
        let first = usize::from(off(0) > off(1));
        let done = [first, 1 - first].into_iter().any(|kept| {
            let [(kept, kept_fan), (lost, lost_fan)] = [ends[kept], ends[1 - kept]];
            self.contract_to(kept, kept_fan, lost, lost_fan)
        });
        self.fans = [near, far];
        done
    }

    /// How far from the boundary the end of an edge would be that moves to where `kept` starts, mm; 0 for an edge inside.
    fn cut_off(&self, edge: u32, lost_fan: &[u32], kept: u32) -> f64 {
        let Across::End(_) = self.surface.across(edge) else { return 0.0 };
        let [lost, end, goal] =
            [self.surface.place(lost_fan[0]), self.beyond(edge, lost_fan), self.surface.place(kept)];
        let along = goal - end;
        let share = (lost - end).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
        (lost - end - along * share.clamp(0.0, 1.0)).norm()
    }

    /// The other neighbour on the boundary of the vertex of a fan, from which an edge of the boundary leads.
    fn beyond(&self, edge: u32, fan: &[u32]) -> &Point3<f64> {
        if fan[0] == edge { self.surface.place(previous(fan[fan.len() - 1])) } else { self.surface.place(next(fan[0])) }
    }

    /// Moves the end of an edge where `lost` starts to that where `kept` starts, if that may be.
    fn contract_to(&mut self, kept: u32, kept_fan: &[u32], lost: u32, lost_fan: &[u32]) -> bool {
        let surface = &*self.surface;
        let edge = if next(kept) == lost { kept } else { lost };
        let on_boundary = |fan: &[u32]| matches!(surface.across(fan[0]), Across::End(_));
        let inside = matches!(surface.across(edge), Across::Half(_));
        // The boundary stays where it is, and two boundaries stay apart.
        if on_boundary(lost_fan) && (inside || !on_boundary(kept_fan)) {
            return false;
        }
        let (keeper, loser) = (surface.from(kept), surface.from(lost));
        // All neighbours but those that face the edge must differ.
        let facing = if inside { 2 } else { 1 };
        let kept_ring = self.ring(kept_fan);
        if self.ring(lost_fan).iter().filter(|vertex| kept_ring.contains(vertex)).count() != facing {
            return false;
        }
        let goal = surface.points[keeper as usize];
        for &half in lost_fan {
            let triangle = half as usize / 3;
            if surface.triangles[triangle].contains(&keeper) {
                continue;
            }
            let before = surface.corners(triangle);
            let mut after = before;
            after[half as usize % 3] = goal;
            if !keeps_shape(&before, &after) {
                return false;
            }
        }
        if on_boundary(lost_fan) {
            // The two boundary edges of the lost end; the one that is not contracted moves.
            let last = previous(lost_fan[lost_fan.len() - 1]);
            let (Across::End(first_kind), Across::End(last_kind)) = (surface.across(lost_fan[0]), surface.across(last))
            else {
                return false;
            };
            let end = self.beyond(edge, lost_fan);
            let mesh = first_kind == BoundaryKind::Mesh;
            if first_kind != last_kind || (mesh && !self.on_mesh(&nalgebra::center(end, &goal))) {
                return false;
            }
        }
        if let Some(moved) = &mut self.moved {
            let way_mm = (goal - surface.points[loser as usize]).norm();
            let Some(onward) = moved.onward(loser, way_mm) else { return false };
            let so_far = &mut moved.so_far[keeper as usize];
            *so_far = so_far.max(onward);
        }
        for &half in lost_fan {
            self.surface.triangles[half as usize / 3][half as usize % 3] = keeper;
        }
        debug_assert_ne!(keeper, loser);
        let back = self.surface.across(edge);
        self.close_up(edge);
        if let Across::Half(back) = back {
            self.close_up(back);
        }
        true
    }

    /// Takes out the triangle of an edge that has no length any more, and joins its other two sides.
    fn close_up(&mut self, edge: u32) {
        let [a, b] = [next(edge), previous(edge)].map(|half| self.surface.across(half));
        self.surface.gone[edge as usize / 3] = true;
        self.join(a, b);
        self.join(b, a);
    }

    fn join(&mut self, at: Across, to: Across) {
        if let Across::Half(half) = at {
            self.surface.across[half as usize / 3][half as usize % 3] = to;
        }
    }

    /// The vertices around the one where a fan starts.
    fn ring(&self, fan: &[u32]) -> Vec<u32> {
        let mut ring: Vec<_> = fan.iter().map(|&half| self.surface.from(next(half))).collect();
        let last = previous(fan[fan.len() - 1]);
        if let Across::End(_) = self.surface.across(last) {
            ring.push(self.surface.from(last));
        }
        ring
    }

    /// Turns an edge inside to the other diagonal of its two triangles.
    fn turn(&mut self, half: u32, back: u32) -> bool {
        let surface = &*self.surface;
        let [a, b, c, d] = [half, next(half), previous(half), previous(back)].map(|half| surface.from(half));
        let mut fan = Vec::new();
        surface.fan(previous(half), &mut fan);
        if c == d || self.ring(&fan).contains(&d) {
            return false;
        }
        let [t, other] = [half, back].map(|half| half as usize / 3);
        let at = |corners: [u32; 3]| corners.map(|corner| surface.points[corner as usize]);
        let after = [[d, b, c], [c, a, d]];
        // The sliver has no side that it shows; its neighbour has.
        let front = normal(&surface.corners(other));
        let [thin, beside] = [t, other].map(|triangle| altitude(&surface.corners(triangle)));
        let better = after.iter().all(|corners| {
            let corners = at(*corners);
            altitude(&corners) > thin.min(beside) && normal(&corners).dot(&front) > 0.0
        });
        // Two slivers with their corners at the same place of the edge: those are made one.
        let apexes = surface.points[d as usize] - surface.points[c as usize];
        let opposite = beside < MIN_ALTITUDE_MM && apexes.norm() < SHORT_MM;
        if !better && !opposite {
            return false;
        }
        let [bc, ca, ad, db] = [next(half), previous(half), next(back), previous(back)].map(|h| surface.across(h));
        let (t32, other32) = (t as u32, other as u32);
        let surface = &mut *self.surface;
        surface.triangles[t] = after[0];
        surface.triangles[other] = after[1];
        surface.across[t] = [db, bc, Across::Half(3 * other32 + 2)];
        surface.across[other] = [ca, ad, Across::Half(3 * t32 + 2)];
        surface.sources[t] = surface.sources[other];
        for (outer, home) in [(db, 3 * t32), (bc, 3 * t32 + 1), (ca, 3 * other32), (ad, 3 * other32 + 1)] {
            self.join(outer, Across::Half(home));
        }
        better || self.contract(3 * t32 + 2)
    }

    /// Drops a triangle on the boundary. Its other sides become boundary of the kind that its longest side there
    /// had. Sides come shortest first.
    fn drop(&mut self, sides: [u32; 3]) -> bool {
        let surface = &*self.surface;
        let kinds = sides.map(|half| match surface.across(half) {
            Across::End(kind) => Some(kind),
            Across::Half(_) => None,
        });
        let Some(kind) = kinds.into_iter().rev().flatten().next() else { return false };
        let inside: Vec<_> =
            sides.into_iter().filter(|&half| matches!(surface.across(half), Across::Half(_))).collect();
        if let [first, second] = inside[..] {
            // The boundary must not meet itself at the corner between them.
            let mut fan = Vec::new();
            surface.fan(if next(first) == second { second } else { first }, &mut fan);
            if let Across::End(_) = surface.across(fan[0]) {
                return false;
            }
        }
        if kind == BoundaryKind::Mesh && !inside.iter().all(|&half| self.is_side_on_mesh(half)) {
            return false;
        }
        self.surface.gone[sides[0] as usize / 3] = true;
        for half in inside {
            self.join(self.surface.across(half), Across::End(kind));
        }
        true
    }

    fn is_flat(&self, triangle: usize) -> bool {
        let longest = (0..3).map(|k| self.length(3 * triangle as u32 + k)).fold(0.0, f64::max);
        altitude(&self.surface.corners(triangle)) <= FLAT * longest
    }

    /// Takes out a triangle, whatever is around it. A corner at which two fans are left becomes two vertices.
    fn cut_out(&mut self, triangle: usize) {
        let sides = [0, 1, 2].map(|k| 3 * triangle as u32 + k);
        let across = sides.map(|half| self.surface.across(half));
        let kind = across.iter().find_map(|across| match across {
            Across::End(kind) => Some(*kind),
            Across::Half(_) => None,
        });
        self.surface.gone[triangle] = true;
        for (half, across) in sides.into_iter().zip(across) {
            // A side may reach beyond the one that is on the mesh.
            let kind = kind.filter(|kind| *kind != BoundaryKind::Mesh || self.is_side_on_mesh(half));
            self.join(across, Across::End(kind.unwrap_or(BoundaryKind::Border)));
        }
        let (mut first, mut second) = (Vec::new(), Vec::new());
        for k in 0..3 {
            let (Across::Half(after), Across::Half(before)) = (across[k], across[(k + 2) % 3]) else { continue };
            self.surface.fan(before, &mut first);
            self.surface.fan(next(after), &mut second);
            if first[0] != second[0] {
                let point = self.surface.points.len() as u32;
                self.surface.points.push(*self.surface.place(second[0]));
                second.iter().for_each(|&half| self.surface.triangles[half as usize / 3][half as usize % 3] = point);
            }
        }
    }

    /// Whether the ends and the middle of a side lie on the mesh.
    fn is_side_on_mesh(&self, half: u32) -> bool {
        let [a, b] = [self.surface.place(half), self.surface.place(next(half))];
        [*a, *b, nalgebra::center(a, b)].iter().all(|p| self.on_mesh(p))
    }

    fn on_mesh(&self, p: &Point3<f64>) -> bool {
        self.solid.distance_within(p, self.on_mesh_mm).is_some()
    }
}

fn normal([a, b, c]: &[Point3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}

/// Whether a triangle that is moved stays as good as it was, or good, and is not turned over.
fn keeps_shape(before: &[Point3<f64>; 3], after: &[Point3<f64>; 3]) -> bool {
    let (was, is) = (altitude(before), altitude(after));
    is >= was.min(MIN_ALTITUDE_MM) && (was < MIN_ALTITUDE_MM || normal(before).dot(&normal(after)) > 0.0)
}
