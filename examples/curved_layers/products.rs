//! The files that other programs take: the surfaces as OBJ and VTK, the field as VTK and to go on from.

use crate::surfaces::SurfacesRun;
use curvlay_examples::args::Failure;
use curvlay_examples::output::OutputFolder;
use curvlay_layers::curved::surface::{write_field_vtk, write_surfaces_vtk};
use std::io::{self, Write};

pub fn write(run: &SurfacesRun, folder: &OutputFolder) -> Result<(), Failure> {
    folder.write_with("layers.obj", |out| write_obj(run, out))?;
    folder.write_with("layers.vtk", |out| write_surfaces_vtk(out, &run.slices(), Some(&run.spacing)))?;
    folder.write_with("field.vtk", |out| write_field_vtk(out, &run.field, run.saved.cell_mm, run.saved.origin))?;
    folder.write_with("field.txt", |out| run.saved.write(out))?;
    Ok(())
}

/// A group for each layer, in millimetres; the plate is the plane z = 0.
fn write_obj(run: &SurfacesRun, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "# curved layers, in millimetres, {} mm apart; a group a layer, first to last", run.height_mm)?;
    let mut first = 1;
    for (number, sheet) in (1..).zip(&run.sheets) {
        writeln!(out, "g layer_{number}")?;
        for vertex in &sheet.vertices {
            writeln!(out, "v {:.6} {:.6} {:.6}", vertex.x, vertex.y, vertex.z)?;
        }
        for corners in &sheet.triangles {
            let [a, b, c] = corners.map(|corner| first + corner);
            writeln!(out, "f {a} {b} {c}")?;
        }
        first += sheet.vertices.len() as u32;
    }
    Ok(())
}
