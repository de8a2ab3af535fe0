//! Layers as they are read: a surface or several each.

use super::super::args::Args;
use super::files;
use curvlay_examples::args::{Failure, printable};
use curvlay_examples::count::counted;
use curvlay_examples::findings::{Finding, Severity};
use curvlay_examples::mesh::{Mesh, Surfaces, read_surfaces};
use nalgebra::{Point3, Vector3};
use std::path::Path;

/// A surface of a layer.
#[derive(Clone, Debug, Default)]
pub struct Sheet {
    /// Which layer it is of, from 0 in the order of the build.
    pub rank: u32,
    /// The number of that layer in its name; its place from 1 where names have none.
    pub number: u32,
    /// Whether it is support of the part.
    pub is_support: bool,
    /// Corners, z up, the plate at z = 0.
    pub vertices: Vec<Point3<f64>>,
    /// Triangles, counter-clockwise seen from the nozzle once they are turned.
    pub triangles: Vec<[u32; 3]>,
    /// Unit normals of the corners, by the area around them.
    pub normals: Vec<Vector3<f64>>,
}

impl Sheet {
    /// Corners of a triangle.
    pub fn corners(&self, triangle: &[u32; 3]) -> [Point3<f64>; 3] {
        triangle.map(|corner| self.vertices[corner as usize])
    }

    /// Computes the normals.
    pub fn set_normals(&mut self) {
        let mut normals = vec![Vector3::zeros(); self.vertices.len()];
        for triangle in &self.triangles {
            let [a, b, c] = self.corners(triangle);
            let normal = (b - a).cross(&(c - a));
            triangle.iter().for_each(|&corner| normals[corner as usize] += normal);
        }
        self.normals = normals.iter().map(|normal| normal.try_normalize(0.0).unwrap_or_default()).collect();
    }
}

/// Edges of triangles, sorted, each with its triangle and whether that runs along it from the lower number to the higher.
pub fn edges(triangles: &[[u32; 3]]) -> Vec<([u32; 2], u32, bool)> {
    let mut edges = Vec::with_capacity(3 * triangles.len());
    for (triangle, corners) in (0..).zip(triangles) {
        for k in 0..3 {
            let [a, b] = [corners[k], corners[(k + 1) % 3]];
            edges.push(([a.min(b), a.max(b)], triangle, a < b));
        }
    }
    edges.sort_unstable();
    edges
}

/// All layers.
pub struct Sheets {
    /// By rising rank.
    pub sheets: Vec<Sheet>,
    /// How many layers there are.
    pub layers: u32,
    /// How the input was understood, in words.
    pub meant: String,
    /// What was decided on the way.
    pub notes: Vec<Finding>,
}

/// Reads the layers of the input.
///
/// # Errors
/// A line for a file that cannot be used, and for names without numbers where the order depends on them.
pub fn read(args: &Args) -> Result<Sheets, Failure> {
    let found = files::of(args)?;
    let (mut named, mut notes) = (Vec::new(), Notes::default());
    for (path, name) in &found.files {
        let Surfaces { surfaces, findings } = read_surfaces(path)?;
        findings.into_iter().for_each(|finding| notes.add(finding, path));
        // A single file has a layer in each group.
        let name_of = |group: &str| if found.files.len() == 1 { files::named(group) } else { name.clone() };
        named.extend(surfaces.into_iter().map(|(group, mesh)| (name_of(&group), mesh)));
    }
    let is_numbered = named.iter().all(|(name, _)| name.number.is_some());
    if !is_numbered && found.files.len() > 1 {
        let nameless = found.files.iter().find(|(_, name)| name.number.is_none());
        let path = nameless.map_or_else(|| args.input.display().to_string(), |(path, _)| path.display().to_string());
        return Err(Failure::new(format!(
            "{path}: no number in its name: which layer is it? call files layer_1, layer_2, ..."
        )));
    }
    let mut sheets: Vec<Sheet> = Vec::new();
    for ((name, mesh), place) in named.into_iter().zip(1..) {
        let number = name.number.filter(|_| is_numbered).unwrap_or(place);
        sheets.push(placed(mesh, args, Sheet { number, is_support: name.is_support, ..Sheet::default() })?);
    }
    sheets.sort_by_key(|sheet| sheet.number);
    let mut layers = 0;
    for at in 0..sheets.len() {
        layers += u32::from(at == 0 || sheets[at].number > sheets[at - 1].number);
        sheets[at].rank = layers - 1;
    }
    if let ([(path, _), _, _, ..], 1) = (&found.files[..], layers) {
        let (path, number) = (path.display(), sheets[0].number);
        return Err(Failure::new(format!(
            "{path}: in the names of all {} files the last number is {number}: it must be that of the layer",
            found.files.len()
        )));
    }
    let (files, surfaces) = (counted(found.files.len(), "file"), counted(sheets.len(), "surface"));
    let meant = format!("layer meshes: {}, {surfaces} in {files}", counted(layers, "layer"));
    let mut notes = notes.findings();
    if !found.passed_over.is_empty() {
        let what = "meshes whose names are not those of layers were passed over";
        let names = found.passed_over.iter().take(3).cloned().collect::<Vec<_>>().join(", ");
        notes.push(Finding::new(Severity::Warning, what, found.passed_over.len().to_string(), names));
    }
    Ok(Sheets { sheets, layers, meant, notes })
}

/// What was decided as files were read, once for all files.
#[derive(Default)]
struct Notes {
    /// Each with the number of files.
    found: Vec<(Finding, usize)>,
}

impl Notes {
    fn add(&mut self, finding: Finding, path: &Path) {
        match self.found.iter_mut().find(|(known, _)| known.what == finding.what) {
            Some((_, files)) => *files += 1,
            None => {
                let places = [printable(&path.display().to_string()), finding.place];
                let place = places.into_iter().filter(|place| !place.is_empty()).collect::<Vec<_>>().join(", ");
                self.found.push((Finding { place, ..finding }, 1));
            }
        }
    }

    fn findings(self) -> Vec<Finding> {
        let gathered = |(finding, files): (Finding, usize)| match files {
            1 => finding,
            _ => Finding { amount: format!("in {}", counted(files, "file")), ..finding },
        };
        self.found.into_iter().map(gathered).collect()
    }
}

/// A mesh in millimetres, z up, the plate at z = 0.
fn placed(mesh: Mesh, args: &Args, sheet: Sheet) -> Result<Sheet, Failure> {
    let (up, plate) = (args.sheet.layers_up, args.sheet.plate_mm);
    let placed = |at: Point3<f64>| {
        Point3::from(up.turned([at.x, at.y, at.z])) * args.input_scale - Vector3::new(0.0, 0.0, plate)
    };
    let vertices: Vec<Point3<f64>> = mesh.vertices.into_iter().map(placed).collect();
    if vertices.iter().flat_map(Point3::iter).any(|c| c.abs() > MAX_MM || c.is_nan()) {
        let input = args.input.display();
        return Err(Failure::new(format!(
            "{input}: layer {} has a coordinate beyond {MAX_MM:.0} mm: is --scale right?",
            sheet.number
        )));
    }
    Ok(Sheet { vertices, triangles: mesh.triangles, ..sheet })
}

/// Coordinates beyond this are no print's, in millimetres: squares of them stay exact enough.
const MAX_MM: f64 = 1e7;
