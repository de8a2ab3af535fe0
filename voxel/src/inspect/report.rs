//! What an inspection found, for programs and in words.

use nalgebra::Point3;
use std::fmt;

/// Places that a [`Finding`] keeps: enough to look at, few enough to print.
const PLACES: usize = 8;

/// How often a fault was found, and where first.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Finding {
    /// How often.
    pub count: usize,
    /// The first places, at most eight, by rising numbers of the triangles.
    pub first: Vec<Place>,
}

/// Where something was found. Triangles are counted from 0 in the order of the input.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Place {
    /// The triangle, or the first of those concerned.
    pub triangle: u32,
    /// A second triangle concerned.
    pub other: Option<u32>,
    /// A point there, in millimetres: the middle of the edge, or the centre of `triangle`.
    pub at: Point3<f64>,
}

/// A hole: open edges that hang together.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Hole {
    /// Number of edges round it.
    pub edges: usize,
    /// Their length.
    pub length_mm: f64,
    /// One of its corners.
    pub at: Point3<f64>,
}

/// Which way the faces of a mesh look. The solid is where the winding number is above zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Orientation {
    /// Outwards: no winding number is below zero (the skin of a cavity rightly looks into the cavity).
    Outward,
    /// Inwards: no winding number is above zero; the mesh as it stands encloses nothing.
    Inward,
    /// Some faces outwards, some inwards: neighbours that disagree, or whole parts.
    Mixed,
    /// No part encloses a volume.
    Undecided,
}

/// The state of a triangle mesh, made by [`inspect`](super::inspect).
///
/// Corners at equal positions are one vertex. All but the first three findings are about the mesh without what these
/// three find useless: triangles without area (but for those that fill the slit between an edge and a corner on it) and
/// repeats.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct MeshReport {
    /// Triangles of the input.
    pub triangles: usize,
    /// Corners of the mesh, each position once.
    pub vertices: usize,
    /// Triangles whose corners lie on a line or at one place: exactly, or but for what rounding to single precision
    /// (as in STL files) makes of such corners.
    pub zero_area: Finding,
    /// Triangles on the same corners as an earlier one, the same way round.
    pub repeated: Finding,
    /// Pairs of triangles on the same corners, back to back.
    pub opposed: Finding,
    /// Edges with one triangle.
    pub open_edges: Finding,
    /// Holes: groups of open edges that share corners (two holes that meet in a corner count as one).
    pub holes: usize,
    /// Length of all open edges.
    pub open_length_mm: f64,
    /// The hole with the longest rim.
    pub largest_hole: Option<Hole>,
    /// Edges with more than two triangles.
    pub non_manifold_edges: Finding,
    /// Edges with an even number of triangles, not half of which run along it either way.
    pub inconsistent_edges: Finding,
    /// Pairs of triangles that pass through each other: they meet beyond the corners that they share, and each
    /// reaches to both sides of the other's plane. Decided exactly.
    pub crossings: Finding,
    /// Pairs of triangles that meet beyond the corners that they share, but do not pass through each other: a corner
    /// on a face or on an edge, faces laid on one another. Decided exactly.
    pub touching: Finding,
    /// Whether all pairs were looked at: in a heap of very many triangles the search is cut short, and there may be
    /// more `crossings` and `touching` than were counted.
    pub contacts_complete: bool,
    /// Whether an even number of triangles meets at each edge, so that the surface has no rim.
    pub watertight: bool,
    /// Which way the faces look.
    pub orientation: Orientation,
    /// Parts that hang together by edges.
    pub components: usize,
    /// Skins that look inwards, rightly, in the solid of another part.
    pub cavities: usize,
    /// Euler number: corners - edges + triangles.
    pub euler: i64,
    /// Volume, negative if the faces look inwards; cavities are taken off, overlaps count twice. Each part with
    /// holes is closed by cones over its rims with their tips in the mean of all rim corners.
    pub signed_volume_mm3: f64,
    /// Area of the surface.
    pub area_mm2: f64,
    /// Least and greatest coordinates.
    pub bounds: [Point3<f64>; 2],
}

impl Finding {
    /// Counts one, found in the order of the triangles.
    pub(super) fn add(&mut self, place: impl FnOnce() -> Place) {
        self.count += 1;
        if self.first.len() < PLACES {
            self.first.push(place());
        }
    }

    /// Counts one, found in any order: those with the least numbers stay.
    pub(super) fn add_sorted(&mut self, place: Place) {
        self.count += 1;
        let key = |place: &Place| (place.triangle, place.other);
        let at = self.first.partition_point(|other| key(other) < key(&place));
        if at < PLACES {
            self.first.truncate(PLACES - 1);
            self.first.insert(at, place);
        }
    }
}

impl MeshReport {
    /// The volume without its sign.
    pub fn volume_mm3(&self) -> f64 {
        self.signed_volume_mm3.abs()
    }

    /// Extent of the mesh along x, y and z.
    pub fn size_mm(&self) -> [f64; 3] {
        let [low, high] = self.bounds;
        (high - low).into()
    }

    /// Whether the mesh is the skin of a solid without any repair: closed, consistent, outward, free of triangles that
    /// are useless or pass through each other. (Touching parts and edges that several parts share are no fault here.)
    pub fn is_sound(&self) -> bool {
        let faults = [&self.zero_area, &self.repeated, &self.opposed, &self.inconsistent_edges, &self.crossings];
        self.watertight
            && self.contacts_complete
            && self.orientation == Orientation::Outward
            && faults.iter().all(|finding| finding.count == 0)
    }
}

/// A length, area or volume with about five digits.
struct Short(f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let magnitude = self.0.abs().log10().floor();
        match magnitude {
            _ if self.0 == 0.0 => f.write_str("0"),
            -4.0..=8.0 => write!(f, "{:.*}", (4.0 - magnitude).clamp(0.0, 6.0) as usize, self.0),
            _ => write!(f, "{:.4e}", self.0),
        }
    }
}

fn number_of(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

impl Finding {
    /// " (first: triangle 3 near [1, 2, 3])".
    fn first_place(&self) -> String {
        let Some(Place { triangle, other, at }) = self.first.first() else {
            return String::new();
        };
        let [x, y, z] = [at.x, at.y, at.z].map(Short);
        match other {
            Some(other) => format!(" (first: triangles {triangle} and {other} near [{x}, {y}, {z}])"),
            None => format!(" (first: triangle {triangle} near [{x}, {y}, {z}])"),
        }
    }
}

/// A line on what the mesh is, and a line for each thing that is wrong with it.
impl fmt::Display for MeshReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.size_mm().map(Short);
        write!(
            f,
            "{}, {}, {x} x {y} x {z} mm, volume {} mm3, area {} mm2",
            number_of(self.triangles, "triangle", "triangles"),
            number_of(self.components, "part", "parts"),
            Short(self.volume_mm3()),
            Short(self.area_mm2),
        )?;
        if self.cavities > 0 {
            write!(f, ", {}", number_of(self.cavities, "cavity", "cavities"))?;
        }
        if self.is_sound() {
            write!(f, "\nsound: closed, faces outwards, no crossings")?;
        }
        if let Some(hole) = &self.largest_hole {
            let [x, y, z] = [hole.at.x, hole.at.y, hole.at.z].map(Short);
            write!(
                f,
                "\nnot closed: {} round {}, {} mm in all; the largest is {} mm round, at [{x}, {y}, {z}]",
                number_of(self.open_edges.count, "open edge", "open edges"),
                number_of(self.holes, "hole", "holes"),
                Short(self.open_length_mm),
                Short(hole.length_mm),
            )?;
        }
        match self.orientation {
            Orientation::Inward => write!(f, "\ninside out: all faces look inwards")?,
            Orientation::Mixed => write!(f, "\nmixed: some faces look outwards, some inwards")?,
            Orientation::Undecided => write!(f, "\nno part encloses a volume")?,
            Orientation::Outward => {}
        }
        let at_least = if self.contacts_complete { "" } else { "at least " };
        let lines = [
            (&self.inconsistent_edges, "", "edge whose triangles disagree", "edges whose triangles disagree"),
            (&self.non_manifold_edges, "", "edge of more than two triangles", "edges of more than two triangles"),
            (&self.crossings, at_least, "pair of triangles that cross", "pairs of triangles that cross"),
            (&self.touching, at_least, "pair of triangles that touch", "pairs of triangles that touch"),
            (&self.zero_area, "", "triangle without area", "triangles without area"),
            (&self.repeated, "", "repeated triangle", "repeated triangles"),
            (&self.opposed, "", "pair of triangles back to back", "pairs of triangles back to back"),
        ];
        for (finding, prefix, one, many) in lines.into_iter().filter(|(finding, ..)| finding.count > 0) {
            write!(f, "\n{prefix}{}{}", number_of(finding.count, one, many), finding.first_place())?;
        }
        if !self.contacts_complete {
            write!(f, "\ntoo many triangles lie across each other: the search for crossings was cut short")?;
        }
        Ok(())
    }
}
