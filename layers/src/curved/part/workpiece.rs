//! A part to be layered, and how much of it lies in some of its cells.
//!
//! # Volume of cells
//! Many missed cells are at the skin, so their cubes are more than the part. They are cut by level sheets, [`CUTS`] in a cell,
//! trimmed to the mesh: area times distance is the volume, exactly for cells inside.

use super::error::{LayersError, begin};
use super::guides::Guides;
use crate::ProgressFn;
use crate::cells::Cells;
use crate::curved::buildable::platform::Platform;
use crate::curved::buildable::rules::Rules;
use crate::trim::{MeshParts, TrimError, Trimmer};
use nalgebra::{Point3, Vector3};

/// Level sheets in a cell. One misjudges cells that the skin cuts by up to half, more than four cost time for digits.
const CUTS: u32 = 4;

/// A part to be layered: its mesh, the cells made of it, and what it stands on.
#[derive(Clone, Copy, Debug)]
pub struct Workpiece<'a> {
    /// Vertices of the mesh in millimetres, in the frame of the cells: the plate is the plane z = 0.
    pub vertices: &'a [Point3<f64>],
    /// Triangles of the mesh.
    pub triangles: &'a [[u32; 3]],
    /// The cells that the mesh touches or encloses.
    pub cells: Cells<'a>,
    /// Edge of a cell in millimetres.
    pub cell_mm: f64,
    /// Low corner of the grid in millimetres.
    pub origin: Point3<f64>,
    /// What it is built on.
    pub platform: &'a Platform,
    /// What supports a cell, and from which depth on it cannot be reached.
    pub rules: Rules,
    /// Volume of the part in cubic millimetres, by which the best strategy is chosen. [`Workpiece::new`] computes it.
    pub volume_mm3: f64,
    /// What guides its order besides its shape.
    pub guides: Guides<'a>,
}

impl<'a> Workpiece<'a> {
    /// A part on a platform, by the default [`Rules`], without guides.
    ///
    /// The volume is that of the mesh where it closes, and goes round the centre of each cell once or not at all. It is that of
    /// the [cells](Workpiece::volume_of), where overlaps count once, for any other mesh.
    ///
    /// # Arguments
    /// * `mesh`: vertices in millimetres, in the frame of the cells, and triangles.
    /// * `cells`: those that the mesh touches or encloses.
    /// * `cell_mm`, `origin`: edge of a cell and low corner of the grid, in millimetres.
    /// * `progress`: called with the stage `volume`; may cancel.
    ///
    /// # Errors
    /// [`LayersError::Trim`] for a damaged mesh, [`LayersError::Volume`] for one without volume.
    ///
    /// # Cost
    /// A winding number for each cell, some microseconds; that of [`Workpiece::volume_of`] all cells where the mesh does not close or overlaps.
    ///
    /// # Example
    /// See [`Workpiece::layers`].
    pub fn new(
        mesh: MeshParts<'a>,
        cells: Cells<'a>,
        cell_mm: f64,
        origin: Point3<f64>,
        platform: &'a Platform,
        progress: ProgressFn,
    ) -> Result<Self, LayersError> {
        let ((vertices, triangles), rules, guides) = (mesh, Rules::default(), Guides::default());
        let mut part =
            Workpiece { vertices, triangles, cells, cell_mm, origin, platform, rules, volume_mm3: 0.0, guides };
        begin("volume", progress)?;
        let all: Vec<u32> = cells.iter().collect();
        let centre = |cell: u32| origin + cells.centre(cell).coords * cell_mm;
        let trimmer = Trimmer::new(vertices, triangles)?;
        part.volume_mm3 = match trimmer.volume_if_simple(all.len(), |k| centre(all[k])) {
            Some(volume_mm3) => volume_mm3,
            None => part.volume_in(&all, &trimmer, progress)?,
        };
        part.check_volume()?;
        Ok(part)
    }
}

impl Workpiece<'_> {
    pub(crate) fn check_volume(&self) -> Result<(), LayersError> {
        match self.volume_mm3 {
            volume_mm3 if volume_mm3 > 0.0 && volume_mm3.is_finite() => Ok(()),
            volume_mm3 => Err(LayersError::Volume { volume_mm3 }),
        }
    }

    /// Volume of the part in some of its cells, in cubic millimetres: exact for cells inside, a hundredth or so of what lies in
    /// cells at the skin. Where parts of the mesh overlap it counts once.
    ///
    /// # Arguments
    /// * `cells`: numbers of cells, each once.
    /// * `progress`: called with the stages of trimming; may cancel.
    ///
    /// # Errors
    /// [`LayersError::Trim`], e.g. for a mesh that cannot be trimmed to.
    ///
    /// # Cost
    /// That of trimming four squares a cell: some seconds for 100,000 cells.
    pub fn volume_of(&self, cells: &[u32], progress: ProgressFn) -> Result<f64, LayersError> {
        if cells.is_empty() {
            return Ok(0.0);
        }
        let trimmer = Trimmer::new(self.vertices, self.triangles)?;
        Ok(self.volume_in(cells, &trimmer, progress)?)
    }

    /// Volume of the part in these cells.
    pub(super) fn volume_in(&self, cells: &[u32], trimmer: &Trimmer, progress: ProgressFn) -> Result<f64, TrimError> {
        let mut cells: Vec<[u32; 3]> = cells.iter().map(|&cell| self.cells.position(cell)).collect();
        cells.sort_unstable_by_key(|&[x, y, z]| [z, y, x]);
        let mut area = 0.0;
        for level in cells.chunk_by(|a, b| a[2] == b[2]) {
            for cut in 0..CUTS {
                let (points, triangles) = self.squares(level, (f64::from(cut) + 0.5) / f64::from(CUTS));
                area += trimmer.trim(&points, &triangles, progress)?.area();
            }
        }
        Ok(area * self.cell_mm / f64::from(CUTS))
    }

    /// Level squares through cells, at a share of their height: points and two triangles for each.
    pub(crate) fn squares(&self, cells: &[[u32; 3]], share: f64) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
        let square = |&[x, y, z]: &[u32; 3]| [[x, y, z], [x + 1, y, z], [x + 1, y + 1, z], [x, y + 1, z]];
        let point = |[x, y, z]: [u32; 3]| {
            self.origin + Vector3::new(f64::from(x), f64::from(y), f64::from(z) + share) * self.cell_mm
        };
        let two = |k: u32| [[0, 1, 2], [0, 2, 3]].map(|corners| corners.map(|corner| 4 * k + corner));
        (cells.iter().flat_map(square).map(point).collect(), (0..cells.len() as u32).flat_map(two).collect())
    }
}
