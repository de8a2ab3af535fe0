//! A mesh that was looked through, the cells that it gives for one size and place of the grid, and what was found on the way.

use crate::boundary::{Cap, OpenEdge, caps, open_edges, sides, welded};
use crate::grid::zeroed;
use crate::interior::{self, Capped, Inside, Surface};
use crate::lattice::{Lattice, TooFineOr};
use crate::orient::{OrientReport, Oriented, orient_welded};
use crate::surface::{Bits, Painter, Walls};
use crate::winding::Winding;
use crate::{GridError, Progress, ProgressFn, VoxelError, VoxelGrid};
use nalgebra::{Point3, Vector3};

/// The cells of a solid.
#[derive(Clone, Debug, PartialEq)]
pub struct Voxelisation {
    /// The cells. The plane `z = 0` is the plate; it is where the grid begins, unless something else stands on the plate ([`Voxelisation::beside`]).
    pub grid: VoxelGrid,
    /// What to add to the vertices, in millimetres, so that the mesh stands in `grid`. Along z alone.
    pub shift: Vector3<f64>,
    /// What was found on the way.
    pub report: VoxelReport,
}

impl Voxelisation {
    /// The same cells in a larger grid that holds something else as well, such as a mould on which the part is built. If that reaches lower than the mesh, it
    /// stands on the plate in its place, and the mesh is higher.
    ///
    /// # Arguments
    /// * `low`, `high`: corners of the box around it, where the vertices of the mesh are. Along x and y the grid goes on a cell beyond it, and the corner of the grid
    ///   along z is less than a cell below the plate.
    /// * `max_bytes`: most bytes that the bits may take.
    ///
    /// # Errors
    /// [`GridError`] for a grid that is too large, or a box that is not finite.
    ///
    /// # Cost
    /// A pass over the rows of both grids.
    ///
    /// # Example
    /// ```
    /// use curvlay_voxel::{Resolution, VoxelOptions, nalgebra::Point3, voxelise};
    /// use std::ops::ControlFlow;
    /// // A tetrahedron at a height of 5 mm, over a table of 10 x 10 mm, 5 mm high.
    /// let vertices = [[0.0, 0.0, 5.0], [3.0, 0.0, 5.0], [0.0, 3.0, 5.0], [0.0, 0.0, 8.0]].map(Point3::from);
    /// let triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    /// let options = VoxelOptions { resolution: Resolution::Cell(1.0), ..VoxelOptions::default() };
    /// let solid = voxelise(&vertices, &triangles, &options, &|_| ControlFlow::Continue(()))?;
    /// let table = [[-5.0, -5.0, 0.0], [5.0, 5.0, 5.0]].map(Point3::from);
    /// let both = solid.clone().beside(table, options.max_bytes)?;
    /// assert_eq!((solid.shift.z, both.shift.z, both.grid.count()), (-5.0, 0.0, solid.grid.count()));
    /// assert_eq!((both.grid.origin(), both.grid.dims()), (Point3::new(-6.0, -6.0, 0.0), [12, 12, 8]));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn beside(self, [low, high]: [Point3<f64>; 2], max_bytes: u64) -> Result<Self, GridError> {
        if let Some(corner) = [low, high].into_iter().find(|corner| corner.iter().any(|at| !at.is_finite())) {
            return Err(GridError::Origin { origin: corner.into() });
        }
        let raised = (-(low.z + self.shift.z)).max(0.0);
        let up = Vector3::z() * raised;
        let (origin, cell_mm) = (self.grid.origin() + up, self.grid.cell_mm());
        let [low, high] = [low, high].map(|corner| corner + self.shift + up);
        let room = Vector3::new(cell_mm, cell_mm, 0.0);
        let far = origin + Vector3::from(self.grid.dims().map(f64::from)) * cell_mm;
        let cells = |length: f64| (length / cell_mm - SPARE).ceil().max(0.0) as u64;
        let before = [0, 1, 2].map(|axis| cells((origin - (low - room))[axis]));
        let after = [0, 1, 2].map(|axis| cells((high + room - far)[axis]));
        let grid = self.grid.with_room(before, after, max_bytes)?;
        let corner = origin - Vector3::from(before.map(|cells| cells as f64)) * cell_mm;
        Ok(Voxelisation { grid: grid.placed(cell_mm, corner)?, shift: self.shift + up, ..self })
    }
}

/// What reaches beyond a grid by less than this share of a cell is rounding.
const SPARE: f64 = 1e-6;

/// What [`voxelise`](crate::voxelise) found on the way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct VoxelReport {
    /// Triangles that count: those with an area.
    pub triangles: usize,
    /// Triangles without area, left out: corners on a line within the rounding of `f64`, or, for triangles that share
    /// no edge with another, within that of the `f32` of STL files.
    pub dropped_triangles: usize,
    /// Edges that the triangles do not pass through equally often in both directions; none if the mesh is closed.
    /// A seam where triangles meet without sharing corners counts as open too, but leaks nothing.
    pub open_edges: usize,
    /// Cells that the surface touches.
    pub surface_cells: u64,
    /// Cells inside that the surface does not touch.
    pub interior_cells: u64,
    /// Connected pieces of what the surface does not touch, for which a winding number was asked.
    pub pieces: usize,
    /// Faces at which a cell inside and one outside meet without any surface between: the mouths of holes wider than a
    /// cell, through which a flood fill would have lost the inside. Here the winding number bounds it.
    pub leak_faces: u64,
    /// Cells near holes that were decided one by one.
    pub cells_asked_singly: u64,
    /// Triangles that looked inwards, or the other way than their neighbours, and were turned first: see
    /// [`orient`](crate::orient).
    pub turned_triangles: usize,
    /// Edges of two triangles that disagreed about inside and outside, before those were turned.
    pub disagreeing_edges: usize,
    /// The triangles were turned inwards, all or for the most part; the inside was taken all the same.
    pub inside_out: bool,
    /// Cells inside that the surface does not touch, and round which it still looks inwards once that is done: where
    /// triangles that share no corners look inwards.
    pub turned_cells: u64,
    /// Grids that were tried to come near a wanted number of cells; one for a given size.
    pub trials: usize,
}

/// The corner of a grid is taken to this part of a cell: far finer than the places that a search tries, far coarser than
/// the rounding of coordinates.
const PLACE_STEPS: u32 = 1 << 20;

/// Largest absolute coordinate: squares and cubes of it, and of its ratio to the smallest, stay finite.
const MAX_COORDINATE: f64 = 1e100;

/// A mesh that was looked through, ready to be voxelised at any size.
pub(crate) struct Solid<'a> {
    vertices: &'a [Point3<f64>],
    triangles: Vec<[u32; 3]>,
    dropped: usize,
    orientation: OrientReport,
    open_edges: usize,
    surface: Surface,
    high: Point3<f64>,
    max_bytes: u64,
    progress: ProgressFn<'a>,
    points: Vec<[i64; 3]>,
    /// Volume (positive if the triangles are turned outwards) and area, with the longest side of the box as unit.
    pub(crate) volume: f64,
    pub(crate) area: f64,
}

/// The cells for one size and place of the grid.
pub(crate) struct Trial {
    lattice: Lattice,
    cells: Bits,
    pub(crate) surface_cells: u64,
    inside: Inside,
}

impl Trial {
    pub(crate) fn count(&self) -> u64 {
        self.surface_cells + self.inside.cells
    }
}

/// Whether there are triangles, and vertices for them that a grid can hold.
fn check(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<(), VoxelError> {
    if triangles.is_empty() {
        return Err(VoxelError::NoTriangle);
    }
    let usable = |at: &Point3<f64>| at.iter().all(|c| c.abs() <= MAX_COORDINATE);
    if let Some(vertex) = vertices.iter().position(|at| !usable(at)) {
        return Err(VoxelError::BadVertex { vertex, position: vertices[vertex].into() });
    }
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&index) = corners.iter().find(|&&corner| corner as usize >= vertices.len()) {
            return Err(VoxelError::BadIndex { triangle, index, vertices: vertices.len() });
        }
    }
    Ok(())
}

/// The triangles of a mesh that count, and the edges where they are open.
struct Sound {
    triangles: Vec<[u32; 3]>,
    open: Vec<OpenEdge>,
}

impl Sound {
    /// Leaves out triangles without area, and those that are so narrow that single precision makes nothing of them, if they hang on no other.
    fn of(vertices: &[Point3<f64>], triangles: &[[u32; 3]], welded: &[u32]) -> Self {
        let corners = |triangle: &[u32; 3]| triangle.map(|corner| vertices[corner as usize]);
        let mut sound: Vec<_> =
            triangles.iter().copied().filter(|triangle| has_area(&corners(triangle), f64::EPSILON)).collect();
        let mut open = open_edges(welded, sound.iter().copied());
        if open.is_empty() {
            return Sound { triangles: sound, open };
        }
        let rising = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
        let is_open = |ends: [u32; 2]| open.binary_search_by_key(&rising(ends), |edge| rising(edge.ends)).is_ok();
        let loose =
            |triangle: &[u32; 3]| sides(triangle.map(|corner| welded[corner as usize])).into_iter().all(is_open);
        sound.retain(|triangle| has_area(&corners(triangle), f64::from(f32::EPSILON)) || !loose(triangle));
        open = open_edges(welded, sound.iter().copied());
        if !open.is_empty() && open_edges(welded, triangles.iter().copied()).is_empty() {
            // A triangle without area stands between two that do not share their corners.
            open.clear();
        }
        Sound { triangles: sound, open }
    }
}

/// Low and high corner of the box around points.
fn bounds(points: impl Iterator<Item = Point3<f64>>) -> [Point3<f64>; 2] {
    let none = Vector3::repeat(f64::INFINITY);
    let (low, high) = points.fold((none, -none), |(low, high), at| (low.inf(&at.coords), high.sup(&at.coords)));
    [low, high].map(Point3::from)
}

/// Volume of closed triangles, by pyramids whose apex is the middle of the unit box, and their area.
fn volume_and_area(triangles: &[[Point3<f64>; 3]]) -> [f64; 2] {
    let (mut volume, mut area) = (0.0, 0.0);
    for [a, b, c] in triangles {
        let normal = (b - a).cross(&(c - a));
        let from = a - Point3::new(0.5, 0.5, 0.5);
        volume += from.dot(&normal) / 6.0;
        area += normal.norm() / 2.0;
    }
    [volume, area]
}

/// The triangles of caps: from the apex of each to its edges.
fn fans(caps: &[Cap], vertices: &[Point3<f64>]) -> Vec<[Point3<f64>; 3]> {
    let fan = |cap: &Cap| {
        let apex = cap.apex;
        cap.edges.iter().map(move |&[a, b]| [apex, vertices[a as usize], vertices[b as usize]]).collect::<Vec<_>>()
    };
    caps.iter().flat_map(fan).collect()
}

impl<'a> Solid<'a> {
    /// Looks a mesh through: turns its triangles outwards, leaves out those without area, and closes its holes by caps.
    pub(crate) fn new(
        vertices: &'a [Point3<f64>],
        triangles: &[[u32; 3]],
        max_bytes: u64,
        progress: ProgressFn<'a>,
    ) -> Result<Self, VoxelError> {
        check(vertices, triangles)?;
        let welded = welded(vertices);
        let Oriented { triangles, report: orientation } = orient_welded(vertices, triangles, &welded)?;
        let Sound { triangles: sound, open } = Sound::of(vertices, &triangles, &welded);
        let dropped = triangles.len() - sound.len();
        if sound.is_empty() {
            return Err(VoxelError::NoArea { dropped });
        }
        let corners = |triangle: &[u32; 3]| triangle.map(|corner| vertices[corner as usize]);
        let [low, high] = bounds(sound.iter().flat_map(corners));
        let size = (high - low).max();
        let in_box = |at: Point3<f64>| Point3::from((at - low) / size);
        let boxed: Vec<_> = sound.iter().map(|triangle| corners(triangle).map(in_box)).collect();
        let [volume, area] = volume_and_area(&boxed);
        // Only caps need the vertices, and only an open surface has any.
        let ends: Vec<_> = if open.is_empty() { Vec::new() } else { vertices.iter().map(|at| in_box(*at)).collect() };
        let caps = caps(&ends, &open);
        let caps_winding = Winding::new(fans(&caps, &ends));
        Ok(Solid {
            vertices,
            triangles: sound,
            dropped,
            orientation,
            open_edges: open.len(),
            surface: Surface { winding: Winding::new(boxed), caps_winding, caps, low, size },
            high,
            max_bytes,
            progress,
            points: Vec::new(),
            volume,
            area,
        })
    }

    /// Whether the mesh lies within a plane of every grid: that on which the part stands.
    pub(crate) fn is_on_the_plate(&self) -> bool {
        self.high.z <= self.surface.low.z
    }

    /// Longest side of the bounding box, in millimetres.
    pub(crate) fn size(&self) -> f64 {
        self.surface.size
    }

    /// How many cells before the part a grid begins whose low corner is given.
    pub(crate) fn place_before(&self, corner: [f64; 2], cell_mm: f64) -> Result<[f64; 2], VoxelError> {
        let steps = f64::from(PLACE_STEPS);
        let place = [0, 1].map(|axis| ((self.surface.low[axis] - corner[axis]) / cell_mm * steps).round() / steps);
        if place.iter().all(|place| (0.0..=1.0).contains(place)) {
            Ok(place)
        } else {
            Err(VoxelError::Corner { corner, part: [self.surface.low.x, self.surface.low.y] })
        }
    }

    /// Reports progress under the name of a stage.
    pub(crate) fn go_on(&self, stage: &'static str) -> impl Fn(u64, u64) -> Option<()> + use<'a> {
        let progress = self.progress;
        move |done, total| progress(Progress { stage, done, total }).is_continue().then_some(())
    }

    /// The cells of edge `cell`, the grid beginning `phase` cells before the part in x and y.
    pub(crate) fn trial(
        &mut self,
        cell: f64,
        phase: [f64; 2],
        go_on: &dyn Fn(u64, u64) -> Option<()>,
    ) -> Result<Trial, VoxelError> {
        if !(cell > 0.0 && cell.is_finite()) {
            return Err(GridError::CellSize { cell_mm: cell }.into());
        }
        let bounds = [self.surface.low, self.high];
        let lattice = Lattice::or_what_fits(bounds, cell, phase, self.max_bytes).map_err(|refused| match refused {
            TooFineOr::TooFine(too_fine) => VoxelError::TooFine(too_fine),
            TooFineOr::Grid(cause) => VoxelError::Grid(cause),
        })?;
        let words = VoxelGrid::check(lattice.dims.map(u64::from), self.max_bytes)?;
        let mut cells = Bits::new(lattice.dims, zeroed(words, lattice.dims)?);
        self.points.clear();
        self.points.extend(self.vertices.iter().map(|at| lattice.point(at)));
        let (mut painter, mut walls) = (Painter::new(), Walls::default());
        let total = self.triangles.len() as u64;
        let mut painted = 0;
        for (done, triangle) in self.triangles.iter().enumerate() {
            // Rows count, not triangles, so that a stop is heard within milliseconds.
            if painted > 1 << 16 || done % 4096 == 0 {
                painted = 0;
                go_on(done as u64 / 2, total).ok_or(VoxelError::Cancelled)?;
            }
            let corners = triangle.map(|corner| self.points[corner as usize]);
            painted += painter.paint(&corners, &mut cells, &mut walls)?;
        }
        let surface_cells = cells.rows.iter().map(|word| u64::from(word.count_ones())).sum();
        let capped = if self.surface.caps.is_empty() { None } else { Some(self.capped(&lattice, &cells, &walls)?) };
        let filled = |done: u64, of: u64| go_on(total / 2 + done * (total - total / 2) / of.max(1), total);
        let inside = interior::fill(&mut cells, &walls, capped.as_ref(), &lattice, &mut self.surface, &filled);
        Ok(Trial { lattice, cells, surface_cells, inside: inside.ok_or(VoxelError::Cancelled)? })
    }

    /// Number of cells of that size, by a model: see `search`.
    pub(crate) fn model(&self, size: f64) -> f64 {
        let cells = self.size() / size;
        self.volume.abs() * cells.powi(3) + 0.75 * self.area * cells.powi(2) + cells + 1.0
    }

    /// What the surface and its caps touch together.
    fn capped(&self, lattice: &Lattice, cells: &Bits, walls: &Walls) -> Result<Capped, VoxelError> {
        let [touched, both] = [cells.copy()?, cells.copy()?];
        let mut capped = Capped { touched, cells: both, walls: walls.copy()?, ends: Default::default() };
        let mut painter = Painter::new();
        for cap in &self.surface.caps {
            let apex = lattice.point(&(self.surface.low + cap.apex.coords * self.surface.size));
            for &[a, b] in &cap.edges {
                let corners = [apex, self.points[a as usize], self.points[b as usize]];
                painter.paint(&corners, &mut capped.cells, &mut capped.walls)?;
            }
        }
        for triangle in &self.triangles {
            painter.paint_ends(&triangle.map(|corner| self.points[corner as usize]), &mut capped.ends, cells)?;
        }
        Ok(capped)
    }

    pub(crate) fn finish(self, trial: Trial, trials: usize) -> Result<Voxelisation, VoxelError> {
        let Trial { lattice, cells, surface_cells, inside } = trial;
        if surface_cells + inside.cells == 0 {
            return Err(VoxelError::Nothing { cell_mm: lattice.cell });
        }
        let mut origin = lattice.origin();
        let shift = Vector3::new(0.0, 0.0, -origin.z);
        origin.z = 0.0;
        let grid = VoxelGrid::from_rows(lattice.dims, cells.rows)?.placed(lattice.cell, origin)?;
        let still_inwards = if inside.cells > 0 { inside.turned * 2 > inside.cells } else { self.volume < 0.0 };
        let report = VoxelReport {
            triangles: self.triangles.len(),
            dropped_triangles: self.dropped,
            open_edges: self.open_edges,
            surface_cells,
            interior_cells: inside.cells,
            pieces: inside.pieces,
            leak_faces: inside.leak_faces,
            cells_asked_singly: inside.asked_singly,
            turned_triangles: self.orientation.turned_triangles,
            disagreeing_edges: self.orientation.disagreeing_edges,
            inside_out: self.orientation.inside_out || still_inwards,
            turned_cells: inside.turned,
            trials,
        };
        Ok(Voxelisation { grid, shift, report })
    }
}

/// Whether a triangle has an area that the rounding of its coordinates, by `epsilon` of themselves, cannot have made.
fn has_area([a, b, c]: &[Point3<f64>; 3], epsilon: f64) -> bool {
    let (ab, ac) = (b - a, c - a);
    let largest = a.coords.abs().sup(&b.coords.abs()).sup(&c.coords.abs());
    let longest = ab.abs().sup(&ac.abs());
    let normal = ab.cross(&ac);
    // Each coordinate is off by half a unit in its last place at most, so each difference by one; twice that for the
    // products of the computation itself.
    let [x, y, z] = [(1, 2), (2, 0), (0, 1)].map(|(u, v)| largest[u] * longest[v] + largest[v] * longest[u]);
    normal.abs().zip_fold(&Vector3::new(x, y, z), false, |any, normal, error| any || normal > 2.0 * epsilon * error)
}
