//! Of the surfaces: the files that other programs take (OBJ, VTK, the field to go on from), figures and pictures.

use super::pictures;
use super::shown::{borrowed, seconds};
use crate::args::{Args, Extra};
use crate::field::FieldRun;
use crate::surfaces::SurfacesRun;
use curvlay_examples::args::Failure;
use curvlay_examples::count::counted;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use curvlay_layers::curved::surface::{SavedField, write_field_vtk, write_surfaces_vtk};
use std::io::{self, Write};

pub fn products(args: &Args, run: &SurfacesRun, folder: &OutputFolder) -> Result<(), Failure> {
    let SavedField { field, cell_mm, origin, .. } = &run.saved;
    let writes = |extra| args.writes(extra);
    folder.write_list("layers.obj", writes(Extra::LayersObj), |out| write_obj(run, out))?;
    let vtk = |out: &mut dyn Write| write_surfaces_vtk(out, &run.slices(), Some(&run.spacing));
    folder.write_list("layers.vtk", writes(Extra::LayersVtk), vtk)?;
    folder.write_list("field.vtk", writes(Extra::FieldVtk), |out| write_field_vtk(out, field, *cell_mm, *origin))?;
    write_saved(run, folder)
}

/// The field that other runs go on from.
pub fn write_saved(run: &SurfacesRun, folder: &OutputFolder) -> Result<(), Failure> {
    Ok(folder.write_with("field.txt", |out| run.saved.write(out))?)
}

/// A group for each layer, in millimetres; the plate is the plane z = 0.
fn write_obj(run: &SurfacesRun, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "# curved layers, in millimetres, {} mm apart; a group a layer, first to last", run.height_mm)?;
    let mut first = 1;
    for (number, sheet) in (1usize..).zip(&run.sheets) {
        writeln!(out, "g layer_{number}")?;
        for vertex in &sheet.vertices {
            writeln!(out, "v {:.6} {:.6} {:.6}", vertex.x, vertex.y, vertex.z)?;
        }
        for corners in &sheet.triangles {
            let [a, b, c] = corners.map(|corner| first + corner);
            writeln!(out, "f {a} {b} {c}")?;
        }
        first += sheet.vertices.len() as u32;
        // The support of the layer, as a group of its own.
        let support = run.support.as_ref().and_then(|support| support.surfaces.sheets.get(number - 1));
        let Some(sheet) = support.filter(|sheet| !sheet.triangles.is_empty()) else { continue };
        writeln!(out, "g support_{number}")?;
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

pub fn summary(run: &SurfacesRun, summary: &mut Summary) -> Result<(), Failure> {
    let (spacing, boundary, times) = (&run.spacing, &run.boundary, &run.times);
    summary
        .set("layer_height_mm", run.height_mm)?
        .set("even_method", run.method.as_str())?
        .set("waits", run.waits)?
        .set("torn_share", run.saved.field.torn_share(2.0))?
        .set("torn_share_3", run.saved.field.torn_share(3.0))?
        .set_seconds("surfaces_s", times.even + times.contour)?
        .set_seconds("even_s", times.even)?
        .set_seconds("contour_s", times.contour)?
        .set_seconds("trim_s", times.trim)?
        .set_seconds("spacing_s", times.spacing)?
        .set("surfaces", run.sheets.len())?
        .set("half_layers", run.half_layers())?
        .set("surface_triangles", run.triangles())?
        .set("boundary_error_mm", boundary.error_mm)?
        .set("boundary_at_missed_mm", boundary.at_missed_mm)?
        .set("boundary_at_waits_mm", boundary.at_waits_mm)?
        .set("boundary_at_holes_mm", boundary.at_holes_mm)?
        .set("border_turning_deg_per_mm", border_turning(run))?
        .set("slivers", run.sheets.iter().map(|sheet| sheet.slivers).sum::<usize>())?
        .set("surface_crossings_found", run.clipped.found.crossing)?
        .set("surface_crossings", run.clipped.left.crossing)?
        .set("clipped_surfaces", run.clipped.surfaces)?
        .set("clipped_mm2", run.clipped.area_mm2)?
        .set("layer_volume_mm3", spacing.volume_mm3)?
        .set("support_volume_mm3", run.support_mm3())?
        .set("spacing_mean_mm", spacing.mean_mm)?
        .set("spacing_std_mm", spacing.std_mm)?
        .set("spacing_p05_mm", spacing.p05_mm)?
        .set("spacing_p95_mm", spacing.p95_mm)?
        .set("squeezed_share", spacing.squeezed_share)?
        .set("thickness_share", run.thickness_share())?;
    if let Some(plain) = &run.plain_spacing {
        summary.set("plain_spacing_mean_mm", plain.mean_mm)?.set("plain_spacing_std_mm", plain.std_mm)?;
    }
    Ok(())
}

/// How much surfaces turn where they end inside the part, in degrees a millimetre; 0 where none does.
fn border_turning(run: &SurfacesRun) -> f64 {
    let turning: f64 = run.sheets.iter().map(|sheet| sheet.border_turning()).sum();
    let length: f64 = run.sheets.iter().map(|sheet| sheet.border_mm).sum();
    if length > 0.0 { turning.to_degrees() / length } else { 0.0 }
}

pub fn rows(run: &SurfacesRun, table: &mut Table) {
    let (spacing, boundary, times) = (&run.spacing, &run.boundary, &run.times);
    let spread = |std: f64, mean: f64| format!("{mean:.4} mm, deviation {std:.4} mm");
    table
        .row(["surfaces".to_owned(), format!("{}, {}", run.sheets.len(), counted(run.triangles(), "triangle"))])
        .row(["layer height".to_owned(), format!("{:.4} mm", run.height_mm)])
        .row(["even layers by".to_owned(), format!("{}; {}", run.method, counted(run.waits, "wait"))])
        .row(["spacing".to_owned(), spread(spacing.std_mm, spacing.mean_mm)]);
    if let Some(plain) = &run.plain_spacing {
        table.row(["spacing, hop counts".to_owned(), spread(plain.std_mm, plain.mean_mm)]);
    }
    table
        .row([
            "0.5 to 1.5 layer heights thick".to_owned(),
            format!("{:.2} % of the area", 100.0 * run.thickness_share()),
        ])
        .row(["off the mesh".to_owned(), format!("{:.1e} mm at most", boundary.error_mm)])
        .row([
            "ends inside".to_owned(),
            format!("{:.1} mm at missed cells, {:.1} mm at waits", boundary.at_missed_mm, boundary.at_waits_mm),
        ])
        .row(["layer volume".to_owned(), format!("{:.1} mm3", spacing.volume_mm3)])
        .row([
            "time".to_owned(),
            format!(
                "even layers {}, contouring {}, trimming {}, spacing {}",
                seconds(times.even),
                seconds(times.contour),
                seconds(times.trim),
                seconds(times.spacing)
            ),
        ]);
}

pub fn report(field: &FieldRun, run: &SurfacesRun, report: &mut Report) {
    let support = if run.support.is_some() { ", its support orange" } else { "" };
    report.heading(&format!("The part while it is built{support}")).slider(&borrowed(&pictures::frames(field, run)));
    report.heading("Single surfaces").pictures(&borrowed(&pictures::singles(field, run)));
    report.heading("How far apart the surfaces lie").pictures(&borrowed(&[pictures::histogram(run)]));
}
