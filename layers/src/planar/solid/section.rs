//! The section of a solid and a plane, as nested polygons.
//!
//! Vertices on the plane count as above it, as if the plane lay lower by an infinitely small step (simulation of simplicity, H.
//! Edelsbrunner and E. P. Mücke, ACM Trans. Graphics 9(1), 1990). So every triangle has no vertex, or one or two, above; the
//! section crosses it in no line or in one, from edge to edge, and the lines of a closed mesh join to closed loops over its
//! edges: no coordinates are compared. A face in the plane is in the section if the solid is above it.

use super::cells::cut_point;
use super::mesh::Solid;
use super::nest::nest;
use super::plane::{CutPlane, PlaneFrame};
use nalgebra::{Point2, Point3};

/// A piece of a section: an outline, counter-clockwise seen from above the plane, and holes, clockwise.
///
/// Points may repeat where the plane passes through vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SectionPolygon {
    /// The outline.
    pub outer: Vec<Point2<f64>>,
    /// The holes.
    pub holes: Vec<Vec<Point2<f64>>>,
}

impl SectionPolygon {
    /// The area inside, without holes.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::nalgebra::Point2;
    /// use curvlay_layers::planar::SectionPolygon;
    /// let outer = [[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [0.0, 2.0]].map(|[x, y]| Point2::new(x, y)).to_vec();
    /// assert_eq!(SectionPolygon { outer, holes: Vec::new() }.area(), 6.0);
    /// ```
    pub fn area(&self) -> f64 {
        super::nest::area(&self.outer) + self.holes.iter().map(|hole| super::nest::area(hole)).sum::<f64>()
    }
}

/// The section of a solid and a plane, in coordinates of `frame`, which is [`PlaneFrame::of`] the plane or one parallel to it.
///
/// # Returns
/// The pieces of the section, outlines before their holes; none where the plane misses the solid. Vertices on the plane count
/// as above it.
///
/// # Cost
/// `O(n)` for `n` triangles, and the square of the number of loops.
///
/// # Example
/// ```
/// use curvlay_layers::nalgebra::{Point3, Vector3};
/// use curvlay_layers::planar::{CutPlane, PlaneFrame, Solid, slice};
/// let tetrahedron = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]].map(Into::into);
/// let solid = Solid::new(&tetrahedron, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])?;
/// let plane = CutPlane::through(&Point3::new(0.0, 0.0, 1.0), &Vector3::z())?;
/// let section = slice(&solid, &plane, &PlaneFrame::of(&plane));
/// assert_eq!((section.len(), section[0].area()), (1, 0.5));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn slice(solid: &Solid, plane: &CutPlane, frame: &PlaneFrame) -> Vec<SectionPolygon> {
    let above: Vec<bool> = solid.vertices().iter().map(|p| plane.side(p) >= 0).collect();
    let loops: Vec<Vec<Point2<f64>>> =
        loops(solid, plane, &above).iter().map(|points| points.iter().map(|p| frame.flat(p)).collect()).collect();
    nest(&loops)
        .into_iter()
        .map(|nested| SectionPolygon {
            outer: loops[nested.outer].clone(),
            holes: nested.holes.into_iter().map(|hole| loops[hole].clone()).collect(),
        })
        .collect()
}

/// The closed loops between the vertices that are above and the others, with what is below to their left, seen from above.
fn loops(solid: &Solid, plane: &CutPlane, above: &[bool]) -> Vec<Vec<Point3<f64>>> {
    const NONE: u32 = u32::MAX;
    // For each crossed edge the one that follows, and its point.
    let mut next = vec![NONE; solid.edge_count()];
    let mut place = Vec::new();
    let mut place_of = vec![NONE; solid.edge_count()];
    let mut starts = Vec::new();
    for (corners, edges) in solid.triangles().iter().zip(solid.edges()) {
        let up = corners.map(|v| above[v as usize]);
        let Some(lone) = (0..3).find(|&k| up[k] != up[(k + 1) % 3] && up[k] != up[(k + 2) % 3]) else { continue };
        let (leaving, entering) = (edges[lone], edges[(lone + 2) % 3]);
        let (from, to) = if up[lone] { (leaving, entering) } else { (entering, leaving) };
        next[from as usize] = to;
        if place_of[from as usize] == NONE {
            // The edge where the line begins: the lone corner is at one end of it.
            let other = if from == leaving { corners[(lone + 1) % 3] } else { corners[(lone + 2) % 3] };
            let [u, v] = [corners[lone].min(other), corners[lone].max(other)].map(|v| &solid.vertices()[v as usize]);
            place_of[from as usize] = place.len() as u32;
            place.push(cut_point(plane, u, v));
            starts.push(from);
        }
    }
    let mut loops = Vec::new();
    for start in starts {
        let mut points = Vec::new();
        let mut edge = start;
        // A loop that was followed has no successors left.
        while next[edge as usize] != NONE {
            points.push(place[place_of[edge as usize] as usize]);
            edge = std::mem::replace(&mut next[edge as usize], NONE);
        }
        if !points.is_empty() {
            loops.push(points);
        }
    }
    loops
}
