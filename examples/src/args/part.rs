//! Which part, and how it is meant.

use super::rules::above_zero;
use super::typed::typed_name;
use crate::findings::{Finding, Findings, Severity};
use crate::mesh::{Mesh, MeshError, MeshFault, MeshFile, Placement, Unit, Up, mesh_findings, read_mesh_file};
use crate::terminal::printable;
use clap::Args;
use curvlay_voxel::OrientReport;
use std::path::{Path, PathBuf};

/// Which part, and how it is meant.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Part")]
pub struct MeshArgs {
    /// STL, 3MF, OBJ or PLY file [default: a jug made in code, 41 mm tall; with --voxels or --cell 93 mm]
    #[arg(value_name = "MESH", help_heading = "Part")]
    pub file: Option<PathBuf>,
    /// Mesh file (same as the positional MESH)
    #[arg(long, value_name = "FILE", conflicts_with = "file")]
    pub mesh: Option<PathBuf>,
    /// Unit of the numbers in the file
    #[arg(long, default_value = "mm")]
    pub unit: Unit,
    /// Factor by which the part is enlarged
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = above_zero, allow_negative_numbers = true)]
    pub scale: f64,
    /// Axis of the file that points up
    #[arg(long, default_value = "z", allow_hyphen_values = true)]
    pub up: Up,
    /// Accepts a part larger than 10 m
    #[arg(long)]
    pub allow_large: bool,
    /// Accepts an ambiguous mesh (open, or with shells or sheets of unclear meaning); otherwise the exit status is 3
    #[arg(long)]
    pub allow_guesses: bool,
}

/// A part as it was read, in millimetres with z up.
#[derive(Clone, Debug)]
pub struct Part {
    /// The file without its folder, or the name of the shape.
    pub name: String,
    /// The part.
    pub mesh: Mesh,
    /// What the user should look at, a line each: doubts about its size.
    pub warnings: Vec<String>,
    /// What the reader decided, what was done to the mesh, and in what it may be another part than its author's.
    pub findings: Vec<Finding>,
    /// How its triangles were turned, with the volume that they bound.
    pub orientation: OrientReport,
    /// How fine its coordinates are if they are of single precision.
    pub spacing_mm: Option<f64>,
}

/// Share of a cell above which the spacing of single-precision coordinates is reported: half of it is how far a corner may
/// be off, and below some hundredths no cell is another.
const COARSE: f64 = 0.05;

impl Part {
    /// Adds all that there is to say about the mesh.
    pub fn find(&self, findings: &mut Findings) {
        self.warnings.iter().for_each(|warning| findings.add(Severity::Warning, warning, "", ""));
        self.findings.iter().for_each(|finding| findings.push(finding.clone()));
    }

    /// The same with its name before each: for one that is not the part itself.
    pub fn find_named(&self, findings: &mut Findings) {
        let named = |what: &str| format!("{}: {what}", self.name);
        self.warnings.iter().for_each(|warning| findings.add(Severity::Warning, named(warning), "", ""));
        self.findings
            .iter()
            .for_each(|finding| findings.push(Finding { what: named(&finding.what), ..finding.clone() }));
    }

    /// A warning if the coordinates are too coarse for cells of that size.
    pub fn coarse_for(&self, cell_mm: f64) -> Option<String> {
        let spacing_mm = self.spacing_mm.filter(|&spacing_mm| spacing_mm > COARSE * cell_mm)?;
        Some(format!(
            "the numbers in the file are of single precision and lie {spacing_mm:.3} mm apart so far from its origin, {:.0} % \
             of a cell: the part is distorted; export it nearer to the origin",
            100.0 * spacing_mm / cell_mm
        ))
    }
}

impl MeshArgs {
    /// Unit, scale, axis, and whether it may be large.
    pub fn placement(&self) -> Placement {
        Placement { unit: self.unit, scale: self.scale, up: self.up, allow_large: self.allow_large }
    }

    /// The file, however it was given.
    pub fn path(&self) -> Option<&Path> {
        self.file.as_deref().or(self.mesh.as_deref())
    }

    /// Reads the file, or makes `shape` when there is none; unit, scale and axis apply to both. Triangles that look the
    /// wrong way are turned; what was guessed or left out is among the findings.
    ///
    /// # Errors
    /// [`MeshError`] when the file cannot be used.
    pub fn load(&self, shape_name: &str, shape: impl FnOnce() -> Mesh) -> Result<Part, MeshError> {
        match self.path() {
            Some(path) => self.load_file(path),
            None => {
                let (path, file) = (PathBuf::from(shape_name), MeshFile::of(shape()));
                self.prepare(shape_name.to_owned(), file).map_err(|fault| MeshError { path, fault })
            }
        }
    }

    /// Reads another file with the same unit, scale and axis.
    ///
    /// # Errors
    /// [`MeshError`] when the file cannot be used.
    pub fn load_file(&self, path: &Path) -> Result<Part, MeshError> {
        let file = read_mesh_file(path)?;
        let name = path.file_name().map_or_else(String::new, |name| printable(&name.to_string_lossy()));
        self.prepare(name, file).map_err(|fault| MeshError { path: path.to_owned(), fault })
    }

    /// Reads a surface with the same unit, scale and axis: its triangles stay as they are.
    ///
    /// # Errors
    /// [`MeshError`] when the file cannot be used.
    pub fn load_surface(&self, path: &Path) -> Result<Mesh, MeshError> {
        let MeshFile { mut mesh, states_unit, .. } = read_mesh_file(path)?;
        let mut placement = self.placement();
        placement.unit = if states_unit { Unit::Mm } else { placement.unit };
        placement.apply(&mut mesh).map_err(|fault| MeshError { path: path.to_owned(), fault })?;
        Ok(mesh)
    }

    /// Places and orients a mesh.
    fn prepare(&self, name: String, file: MeshFile) -> Result<Part, MeshFault> {
        let MeshFile { mut mesh, mut findings, states_unit } = file;
        let mut placement = self.placement();
        let mut warnings = Vec::new();
        if states_unit && placement.unit != Unit::Mm {
            warnings.push(format!("the file states its unit: --unit {} was not used", typed_name(placement.unit)));
            placement.unit = Unit::Mm;
        }
        let spacing_mm = mesh.float32_spacing().map(|spacing| spacing * placement.unit.millimetres() * placement.scale);
        warnings.extend(placement.apply(&mut mesh)?);
        let orientation = mesh.orient()?;
        findings.extend(mesh_findings(&orientation, self.allow_guesses));
        if orientation.volume_mm3 <= 0.0 {
            return Err(MeshFault::NoVolume { triangles: mesh.triangles.len() });
        }
        Ok(Part { name, mesh, warnings, findings, orientation, spacing_mm })
    }
}
