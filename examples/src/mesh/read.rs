//! Files of any format, read.

use super::fault::{MeshError, MeshFault};
use super::formats::{Format, recognise};
use super::triangles::Mesh;
use super::weld::Welder;
use super::{obj, ply, stl, threemf};
use crate::finding::{Finding, Severity};
use curvlay_voxel::OrientError;
use curvlay_voxel::inspect::without_area;
use std::collections::HashMap;
use std::fs;
use std::path::Path;

/// A mesh as it was read, and what was decided on the way.
#[derive(Clone, Debug)]
pub struct MeshFile {
    /// The mesh.
    pub mesh: Mesh,
    /// What the reader decided, guessed or left out.
    pub findings: Vec<Finding>,
    /// The file states its unit (3MF), and the mesh is in millimetres.
    pub states_unit: bool,
}

impl MeshFile {
    /// A mesh about which there is nothing to say.
    pub fn of(mesh: Mesh) -> Self {
        MeshFile { mesh, findings: Vec::new(), states_unit: false }
    }
}

/// Reads a mesh; its content decides the format, otherwise the ending of its name (any case). Polygons are cut into
/// triangles in their own plane.
///
/// # Errors
/// [`MeshError`] names the file, the place in it and the fault, in one line.
///
/// # Cost
/// Linear in the size of the file, which is read whole. Nothing is set aside by a count that the file states.
pub fn read_mesh_file(path: &Path) -> Result<MeshFile, MeshError> {
    read(path).map_err(|fault| MeshError { path: path.to_owned(), fault })
}

/// The mesh of [`read_mesh_file`] without its findings.
///
/// # Errors
/// As [`read_mesh_file`].
pub fn read_mesh(path: &Path) -> Result<Mesh, MeshError> {
    Ok(read_mesh_file(path)?.mesh)
}

/// Surfaces of a file.
#[derive(Clone, Debug)]
pub struct Surfaces {
    /// Each that has triangles, with its name: that of the last `g` or `o` before it, or an empty one. Vertices without triangles are left out.
    pub surfaces: Vec<(String, Mesh)>,
    /// What the reader decided.
    pub findings: Vec<Finding>,
}

/// Reads open surfaces: those of groups and objects of an OBJ file one by one, in the order of the file; of other formats one.
///
/// # Errors
/// As [`read_mesh_file`].
///
/// # Example
/// ```
/// use curvlay_examples::mesh::{Surfaces, read_surfaces};
/// let path = std::env::temp_dir().join(format!("curvlay-surfaces-{}.obj", std::process::id()));
/// std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 9 9 9\ng first\nf 1 2 3\ng empty\ng second\nf 3 2 1\n")?;
/// let Surfaces { surfaces, findings } = read_surfaces(&path)?;
/// std::fs::remove_file(&path)?;
/// let names: Vec<&str> = surfaces.iter().map(|(name, _)| name.as_str()).collect();
/// assert_eq!((names, surfaces[1].1.vertices.len()), (vec!["first", "second"], 3));
/// assert!(findings.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_surfaces(path: &Path) -> Result<Surfaces, MeshError> {
    let failed = |fault| MeshError { path: path.to_owned(), fault };
    let mut welder = welded(path).map_err(failed)?;
    let groups = std::mem::take(&mut welder.groups);
    let (mesh, findings) = welder.finish();
    let begins = [(String::new(), 0)].into_iter().chain(groups);
    let ends: Vec<usize> = begins.clone().skip(1).map(|(_, first)| first).chain([mesh.triangles.len()]).collect();
    let surfaces: Vec<(String, Mesh)> = begins
        .zip(ends)
        .filter(|((_, first), end)| first < end)
        .map(|((name, first), end)| (name, part_of(&mesh, &mesh.triangles[first..end])))
        .collect();
    if surfaces.is_empty() { Err(failed(MeshFault::NoTriangles)) } else { Ok(Surfaces { surfaces, findings }) }
}

/// Some triangles of a mesh, with the vertices that they have.
fn part_of(mesh: &Mesh, triangles: &[[u32; 3]]) -> Mesh {
    let mut numbers = HashMap::new();
    let mut part = Mesh::default();
    for corners in triangles {
        let corners = corners.map(|corner| {
            *numbers.entry(corner).or_insert_with(|| {
                part.vertices.push(mesh.vertices[corner as usize]);
                part.vertices.len() as u32 - 1
            })
        });
        part.triangles.push(corners);
    }
    part
}

fn read(path: &Path) -> Result<MeshFile, MeshFault> {
    let welder = welded(path)?;
    let states_unit = welder.states_unit;
    let (mut mesh, mut findings) = welder.finish();
    findings.extend(leave_out(&mut mesh)?);
    if mesh.triangles.is_empty() { Err(MeshFault::NoTriangles) } else { Ok(MeshFile { mesh, findings, states_unit }) }
}

/// Parses a file.
fn welded(path: &Path) -> Result<Welder, MeshFault> {
    if !fs::metadata(path).map_err(MeshFault::Unreadable)?.is_file() {
        return Err(MeshFault::NotAFile);
    }
    let bytes = fs::read(path).map_err(MeshFault::Unreadable)?;
    if bytes.is_empty() {
        return Err(MeshFault::Empty);
    }
    let ending = path.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase);
    match recognise(&bytes, ending.as_deref())? {
        Format::Stl => stl::parse(&bytes),
        Format::Obj => obj::parse(&bytes),
        Format::Ply => ply::parse(&bytes),
        Format::ThreeMf => threemf::parse(&bytes),
    }
}

/// Leaves out the triangles without area that no neighbour needs.
fn leave_out(mesh: &mut Mesh) -> Result<Option<Finding>, MeshFault> {
    if mesh.triangles.is_empty() {
        return Ok(None);
    }
    let useless = without_area(&mesh.vertices, &mesh.triangles).map_err(OrientError::from)?;
    let Some(first) = useless.first() else { return Ok(None) };
    let (what, amount) = ("triangles without area were left out".to_owned(), useless.len().to_string());
    let place = format!("first: triangle {} of the mesh", first + 1);
    let mut numbers = 0..;
    mesh.triangles.retain(|_| numbers.next().is_some_and(|number: u32| useless.binary_search(&number).is_err()));
    Ok(Some(Finding::new(Severity::Note, what, amount, place)))
}
