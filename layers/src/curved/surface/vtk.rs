//! Fields and surfaces as legacy VTK files, which ParaView opens.
//!
//! W. Schroeder, K. Martin, B. Lorensen, *The VTK User's Guide*, "VTK File Formats": version 3.0, ASCII.

use super::field::LayerField;
use super::spacing::Spacing;
use crate::trim::SurfaceSlices;
use nalgebra::Point3;
use std::io::{self, Write};

/// What stands for a cell without a value.
const NONE: f64 = -1.0;

/// Writes a field as structured points with its value for each cell, `field`, -1 for none: ParaView shows them as boxes, and its
/// filter *Threshold* takes away the empty ones.
///
/// # Arguments
/// * `cell_mm`, `origin`: the edge of a cell and the low corner of the grid, in millimetres.
///
/// # Errors
/// Those of `out`.
///
/// # Example
/// ```
/// use curvlay_layers::cells::Cells;
/// use curvlay_layers::curved::surface::{LayerField, write_field_vtk};
/// let cells = Cells::new([2, 1, 1], &[0b01])?;
/// let field = LayerField::new(&cells, vec![0.5, f64::NAN], 1.0)?;
/// let mut file = Vec::new();
/// write_field_vtk(&mut file, &field, 0.8, [0.0; 3].into())?;
/// assert!(String::from_utf8(file)?.ends_with("CELL_DATA 2\nSCALARS field double 1\nLOOKUP_TABLE default\n0.5\n-1\n"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_field_vtk(mut out: impl Write, field: &LayerField, cell_mm: f64, origin: Point3<f64>) -> io::Result<()> {
    let [nx, ny, nz] = field.dims();
    writeln!(out, "# vtk DataFile Version 3.0\nField of the cells of a part, in millimetres\nASCII")?;
    writeln!(out, "DATASET STRUCTURED_POINTS\nDIMENSIONS {} {} {}", nx + 1, ny + 1, nz + 1)?;
    writeln!(out, "ORIGIN {} {} {}\nSPACING {cell_mm} {cell_mm} {cell_mm}", origin.x, origin.y, origin.z)?;
    writeln!(out, "CELL_DATA {}\nSCALARS field double 1\nLOOKUP_TABLE default", field.values().len())?;
    for value in field.values() {
        writeln!(out, "{}", if value.is_nan() { NONE } else { *value })?;
    }
    Ok(())
}

/// Writes surfaces as polygons, each with the number of its surface from 1, and its spacing if that was measured (-1
/// where no neighbour is in reach).
///
/// # Errors
/// Those of `out`; [`io::ErrorKind::InvalidInput`] for a spacing that belongs to other surfaces.
///
/// # Example
/// ```
/// use curvlay_layers::{curved::surface::write_surfaces_vtk, nalgebra::Point3};
/// let points = [[0.0, 0.0, 0.5], [1.0, 0.0, 0.5], [0.0, 1.0, 0.5]].map(Point3::from);
/// let mut file = Vec::new();
/// write_surfaces_vtk(&mut file, &[(&points, &[[0, 1, 2]])], None)?;
/// assert!(String::from_utf8(file)?.contains("POINTS 3 double\n0 0 0.5\n1 0 0.5\n0 1 0.5\nPOLYGONS 1 4\n3 0 1 2\n"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_surfaces_vtk(
    mut out: impl Write,
    surfaces: &[SurfaceSlices],
    spacing: Option<&Spacing>,
) -> io::Result<()> {
    let fits = |spacing: &Spacing| {
        spacing.values_mm.len() == surfaces.len()
            && spacing.values_mm.iter().zip(surfaces).all(|(values, (_, triangles))| values.len() == triangles.len())
    };
    if spacing.is_some_and(|spacing| !fits(spacing)) {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "the spacing was measured on other surfaces"));
    }
    let points = surfaces.iter().map(|(points, _)| points.len()).sum::<usize>();
    let triangles = surfaces.iter().map(|(_, triangles)| triangles.len()).sum::<usize>();
    writeln!(out, "# vtk DataFile Version 3.0\nWorking surfaces of a part, in millimetres\nASCII")?;
    writeln!(out, "DATASET POLYDATA\nPOINTS {points} double")?;
    for point in surfaces.iter().flat_map(|(points, _)| *points) {
        writeln!(out, "{} {} {}", point.x, point.y, point.z)?;
    }
    writeln!(out, "POLYGONS {triangles} {}", 4 * triangles)?;
    let mut first = 0;
    for (points, triangles) in surfaces {
        for [a, b, c] in triangles.iter().map(|t| t.map(|v| first + v as usize)) {
            writeln!(out, "3 {a} {b} {c}")?;
        }
        first += points.len();
    }
    writeln!(out, "CELL_DATA {triangles}\nSCALARS layer int 1\nLOOKUP_TABLE default")?;
    for (number, (_, triangles)) in (1..).zip(surfaces) {
        for _ in *triangles {
            writeln!(out, "{number}")?;
        }
    }
    if let Some(spacing) = spacing {
        writeln!(out, "SCALARS spacing_mm double 1\nLOOKUP_TABLE default")?;
        for value in spacing.values_mm.iter().flatten() {
            writeln!(out, "{}", value.unwrap_or(NONE))?;
        }
    }
    Ok(())
}
