//! What the example leaves behind: the table on stdout, `summary.json`, `field.csv` and `report.html`.

use crate::field::FieldRun;
use crate::surfaces::SurfacesRun;
use crate::{Args, failure, pictures, products};
use curvlay_examples::args::{Failure, Part, typed_name};
use curvlay_examples::output::OutputFolder;
use curvlay_examples::render::{Camera, LayeredCells, Plane, Scene, draw_cut};
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use curvlay_layers::curved::MissedReason;
use nalgebra::Vector3;
use std::io::{self, Write};

/// Pixels of each picture.
const PICTURE: [u32; 2] = [760, 680];

/// Dai 2020, Table 3.1: model, voxels, time of the decomposition in seconds, missed voxels.
const PAPER: [(&str, u32, f64, u32); 6] = [
    ("Bunny", 97_532, 203.90, 0),
    ("Candelabra", 186_735, 233.90, 0),
    ("Armadillo", 540_689, 3_639.21, 0),
    ("Woman-Pully", 185_815, 537.06, 0),
    ("Mech-Part", 186_723, 1_252.43, 0),
    ("Fertility", 77_064, 232.76, 511),
];

pub fn write(
    args: &Args,
    part: &Part,
    run: &FieldRun,
    surfaces: Option<&SurfacesRun>,
    folder: &OutputFolder,
) -> Result<(), Failure> {
    let grid = &run.solid.grid;
    let field = run.growth.order.field(grid.dims().iter().map(|&d| d as usize).product());
    folder.write_with("field.csv", |out| write_field(run, &field, out))?;
    surfaces.map(|surfaces| products::write(surfaces, folder)).transpose()?;
    folder.write("report.html", report(args, part, run, surfaces, &field)?.to_html())?;
    // The summary comes last: where it is, all is there.
    summary(args, part, run, surfaces)?.write(folder)?;
    figures(args, part, run, surfaces).print().map_err(failure)?;
    Ok(())
}

/// A line for each cell: its place in the grid, the centre in millimetres, and its layer (0: missed).
fn write_field(run: &FieldRun, field: &[u32], out: &mut dyn Write) -> io::Result<()> {
    let grid = &run.solid.grid;
    writeln!(out, "x,y,z,x_mm,y_mm,z_mm,layer")?;
    for cell in grid.iter() {
        let [x, y, z] = grid.position(cell);
        let centre = grid.centre([x, y, z]);
        writeln!(out, "{x},{y},{z},{:.4},{:.4},{:.4},{}", centre.x, centre.y, centre.z, field[cell as usize])?;
    }
    Ok(())
}

/// How many cells were missed for reasons that `is` picks.
fn missed(run: &FieldRun, is: impl Fn(MissedReason) -> bool) -> usize {
    run.growth.missed.iter().filter(|missed| is(missed.reason)).count()
}

fn summary(args: &Args, part: &Part, run: &FieldRun, surfaces: Option<&SurfacesRun>) -> Result<Summary, Failure> {
    let (grid, growth, times) = (&run.solid.grid, &run.growth, &run.times);
    let [nx, ny, nz] = grid.dims();
    let mut summary = Summary::new();
    summary
        .set("version", env!("CARGO_PKG_VERSION"))?
        .set("mesh", part.name.as_str())?
        .set("unit", typed_name(args.mesh.unit))?
        .set("scale", args.mesh.scale)?
        .set("up", typed_name(args.mesh.up))?
        .set("stage", typed_name(args.stage))?
        .set("triangles", part.mesh.triangles.len())?
        .set("volume_mm3", run.mesh.volume_mm3())?
        .set("watertight", run.mesh.watertight)?
        .set("thinner_than_cell_share", run.thin.share)?
        .set("cell_mm", grid.cell_mm())?
        .set("nx", nx)?
        .set("ny", ny)?
        .set("nz", nz)?
        .set("cells", grid.count())?
        .set("eps_cells", args.grow.eps)?
        .set("platform_diameter_mm", run.platform_diameter_mm())?
        .set("strategy", typed_name(args.grow.strategy))?
        .set("strategy_used", run.strategy)?
        .set("prevention", typed_name(args.grow.prevention))?
        .set("threads", args.common.threads)?
        .set_seconds("inspect_s", times.inspect)?
        .set_seconds("voxelise_s", times.voxelise)?
        .set_seconds("peel_s", times.peel)?
        .set_seconds("grow_s", times.grow)?
        .set_seconds("audit_s", times.audit)?
        .set_seconds("total_s", times.total)?
        .set("layers", growth.order.len())?
        .set("missed_cells", growth.missed.len())?
        .set("missed_shadowed", missed(run, |reason| matches!(reason, MissedReason::Shadowed { .. })))?
        .set("missed_unsupported", missed(run, |reason| !matches!(reason, MissedReason::Shadowed { .. })))?
        .set("audit_ok", run.audit.is_ok())?
        .set("small_patch_share", run.quality.small_patch_share)?
        .set("patches_per_layer", run.quality.patches_per_layer)?;
    if let Some(run) = surfaces {
        add_surfaces(run, &mut summary)?;
    }
    Ok(summary)
}

fn add_surfaces(run: &SurfacesRun, summary: &mut Summary) -> Result<(), Failure> {
    let (spacing, boundary, times) = (&run.spacing, &run.boundary, &run.times);
    summary
        .set("layer_height_mm", run.height_mm)?
        .set("even_method", run.method.as_str())?
        .set("jumps", run.jumps)?
        .set_seconds("surfaces_s", times.even + times.contour)?
        .set_seconds("even_s", times.even)?
        .set_seconds("contour_s", times.contour)?
        .set_seconds("trim_s", times.trim)?
        .set_seconds("spacing_s", times.spacing)?
        .set("surfaces", run.sheets.len())?
        .set("surface_triangles", run.triangles())?
        .set("boundary_error_mm", boundary.error_mm)?
        .set("boundary_at_missed_mm", boundary.at_missed_mm)?
        .set("boundary_at_waits_mm", boundary.at_waits_mm)?
        .set("boundary_at_holes_mm", boundary.at_holes_mm)?
        .set("slivers", run.sheets.iter().map(|sheet| sheet.slivers).sum::<usize>())?
        .set("layer_volume_mm3", spacing.volume_mm3)?
        .set("missed_volume_mm3", run.missed_mm3)?
        .set("spacing_mean_mm", spacing.mean_mm)?
        .set("spacing_std_mm", spacing.std_mm)?
        .set("spacing_p05_mm", spacing.p05_mm)?
        .set("spacing_p95_mm", spacing.p95_mm)?
        .set("plain_spacing_mean_mm", run.plain_spacing.mean_mm)?
        .set("plain_spacing_std_mm", run.plain_spacing.std_mm)?
        .set("squeezed_share", spacing.squeezed_share)?;
    Ok(())
}

/// The table that stdout and the report show.
fn figures(args: &Args, part: &Part, run: &FieldRun, surfaces: Option<&SurfacesRun>) -> Table {
    let (grid, growth, times) = (&run.solid.grid, &run.growth, &run.times);
    let [nx, ny, nz] = grid.dims();
    let seconds = |time: std::time::Duration| format!("{:.3} s", time.as_secs_f64());
    let mut table = Table::new(["", ""]);
    table
        .row(["part".to_owned(), format!("{}, {} triangles", part.name, part.mesh.triangles.len())])
        .row(["cells".to_owned(), format!("{} of {:.4} mm, grid {nx} x {ny} x {nz}", grid.count(), grid.cell_mm())])
        .row(["strategy".to_owned(), format!("{}: {}", typed_name(args.grow.strategy), run.strategy)])
        .row(["platform".to_owned(), format!("disc of {:.1} mm", run.platform_diameter_mm())])
        .row(["eps".to_owned(), format!("{} cells", args.grow.eps)])
        .row(["layers".to_owned(), growth.order.len().to_string()])
        .row(["missed cells".to_owned(), growth.missed.len().to_string()])
        .row([
            "small patches".to_owned(),
            format!(
                "{:.2} % of the cells, {:.1} patches a layer",
                100.0 * run.quality.small_patch_share,
                run.quality.patches_per_layer
            ),
        ])
        .row([
            "audit".to_owned(),
            if run.audit.is_ok() { "passed".to_owned() } else { format!("FAILED: {}", run.audit) },
        ])
        .row(["voxelise".to_owned(), seconds(times.voxelise)])
        .row(["grow".to_owned(), format!("{}, peeling {}", seconds(times.grow), seconds(times.peel))])
        .row(["audit time".to_owned(), seconds(times.audit)])
        .row(["field in all".to_owned(), seconds(times.total)]);
    if let Some(run) = surfaces {
        let (spacing, plain, boundary) = (&run.spacing, &run.plain_spacing, &run.boundary);
        let spread = |std: f64, mean: f64| format!("{mean:.4} mm, deviation {std:.4} mm");
        table
            .row(["surfaces".to_owned(), format!("{}, {} triangles", run.sheets.len(), run.triangles())])
            .row(["layer height".to_owned(), format!("{:.4} mm", run.height_mm)])
            .row(["even layers by".to_owned(), format!("{}; {} jumps", run.method, run.jumps)])
            .row(["spacing".to_owned(), spread(spacing.std_mm, spacing.mean_mm)])
            .row(["of hop counts".to_owned(), spread(plain.std_mm, plain.mean_mm)])
            .row(["off the mesh".to_owned(), format!("{:.1e} mm at most", boundary.error_mm)])
            .row([
                "ends inside".to_owned(),
                format!("{:.1} mm at missed cells, {:.1} mm at waits", boundary.at_missed_mm, boundary.at_waits_mm),
            ])
            .row(["layer volume".to_owned(), format!("{:.1} mm3", spacing.volume_mm3)])
            .row(["even layers".to_owned(), seconds(run.times.even)])
            .row(["contouring".to_owned(), seconds(run.times.contour)])
            .row(["trimming".to_owned(), seconds(run.times.trim)])
            .row(["measuring".to_owned(), seconds(run.times.spacing)]);
    }
    table
}

fn report(
    args: &Args,
    part: &Part,
    run: &FieldRun,
    surfaces: Option<&SurfacesRun>,
    field: &[u32],
) -> Result<Report, Failure> {
    let grid = &run.solid.grid;
    let layered = LayeredCells::new(grid.dims(), grid.rows(), field).map_err(failure)?;
    let (layers, missed) = (run.growth.order.len() as u32, run.growth.missed.len());
    let [width, height] = PICTURE;
    let view = |toward: Vector3<f64>| {
        let corners: Vec<[f64; 2]> = run.platform.corners().iter().map(|c| c.map(|c| f64::from(c) / 2.0)).collect();
        let mut scene = Scene::new(Camera::from_direction(toward));
        scene.platform(&corners, 0.0).cells(&layered, None);
        scene.draw(width, height).with_legend(layers, missed).to_png()
    };
    let cut = |plane: Plane| draw_cut(&layered, plane, width, height).with_legend(layers, missed).to_png();
    let mut report = Report::new(&format!("Curved layers: {}", part.name));
    report.paragraph(
        "In which order the cells of the part can be built: every cell has support in an earlier layer, and none lies \
         inside the convex hull of the platform and all earlier layers, so a nozzle of any size reaches it.",
    );
    run.findings.iter().for_each(|finding| _ = report.notice(finding));
    if !run.audit.is_ok() {
        report.notice(&format!("The audit failed: {}", run.audit));
    }
    report
        .table("This run", &figures(args, part, run, surfaces))
        .heading("The part, coloured by layer")
        .pictures(&[
            ("from the front", &view(Vector3::new(0.6, -1.0, 0.45))),
            ("from the back", &view(Vector3::new(-0.6, 1.0, 0.45))),
        ])
        .heading("Cuts through the field")
        .pictures(&[
            ("across x", &cut(Plane::middle_x(grid.dims()))),
            ("across y", &cut(Plane::middle_y(grid.dims()))),
        ]);
    if let Some(surfaces) = surfaces {
        let put = |report: &mut Report, pictures: Vec<pictures::Picture>| {
            let borrowed: Vec<_> = pictures.iter().map(|(caption, png)| (caption.as_str(), png.as_slice())).collect();
            report.pictures(&borrowed);
        };
        put(report.heading("The part while it is built"), pictures::frames(run, surfaces));
        put(report.heading("Single surfaces"), pictures::singles(run, surfaces));
        put(report.heading("How far apart the surfaces lie"), vec![pictures::histogram(surfaces)]);
    }
    report
        .heading("For comparison")
        .table("Dai 2020, Table 3.1, on a Xeon E5 1630, and this run", &comparison(part, run));
    Ok(report)
}

fn comparison(part: &Part, run: &FieldRun) -> Table {
    let mut table = Table::new(["model", "voxels", "decomposition", "missed"]);
    for (model, voxels, time_s, missed) in PAPER {
        table.row([model.to_owned(), voxels.to_string(), format!("{time_s:.2} s"), missed.to_string()]);
    }
    table.row([
        format!("this run: {}", part.name),
        run.solid.grid.count().to_string(),
        format!("{:.2} s", run.times.grow.as_secs_f64()),
        run.growth.missed.len().to_string(),
    ]);
    table
}
