//! Of the field: `field.csv`, figures, pictures of the cells, and the paper's figures to compare with.

use super::pictures::PLAIN;
use super::shown::seconds;
use crate::args::{Args, Extra, failure};
use crate::complete::LayersBy;
use crate::field::FieldRun;
use crate::surfaces::SurfacesRun;
use curvlay_examples::args::{Failure, Part, typed_name};
use curvlay_examples::count::counted;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::render::{Camera, LayeredCells, Plane, Scene, draw_cut};
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use curvlay_layers::curved::{Impossible, MissedReason};
use nalgebra::{Point3, Vector3};
use serde_json::Value;
use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::PathBuf;

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

pub fn products(
    args: &Args,
    run: &FieldRun,
    surfaces: Option<&SurfacesRun>,
    folder: &OutputFolder,
) -> Result<(), Failure> {
    let writes = args.writes(Extra::FieldCsv) || !run.growth.missed.is_empty();
    // Without the file these arrays, as large as the grid, are not needed.
    let order = if writes { numbers(run) } else { Vec::new() };
    let mut layers = Vec::new();
    if let Some(surfaces) = surfaces.filter(|_| writes) {
        layers.resize(order.len(), 0);
        let by_surface = surfaces.saved.field.cells_by_surface(&surfaces.heights_mm, run.solid.grid.cell_mm());
        for (layer, cells) in (1u32..).zip(by_surface.map_err(failure)?) {
            cells.into_iter().for_each(|cell| layers[cell as usize] = layer);
        }
    }
    folder.write_list("field.csv", writes, |out| write_field(run, &order, &layers, out))?;
    folder.write_list("impossible.csv", !run.impossible.is_empty(), |out| write_impossible(run, out))?;
    Ok(())
}

/// A line for each cell that no order can build, with its proof: cells are `x y z`, with `;` between them.
fn write_impossible(run: &FieldRun, out: &mut dyn Write) -> io::Result<()> {
    let grid = &run.solid.grid;
    let list = |cells: &[u32]| {
        let places = cells.iter().map(|&cell| grid.position(cell).map(|k| k.to_string()).join(" "));
        places.collect::<Vec<_>>().join(";")
    };
    writeln!(out, "x,y,z,x_mm,y_mm,z_mm,forced,wall")?;
    for Impossible { cell, forced, wall } in &run.impossible {
        let [x, y, z] = grid.position(*cell);
        let centre = grid.centre([x, y, z]);
        let (forced, wall) = (list(forced), list(wall));
        writeln!(out, "{x},{y},{z},{:.4},{:.4},{:.4},{forced},{wall}", centre.x, centre.y, centre.z)?;
    }
    Ok(())
}

/// The layer of every cell of the grid in the order of the growth.
fn numbers(run: &FieldRun) -> Vec<u32> {
    run.growth.order.field(run.solid.grid.dims().iter().map(|&d| d as usize).product())
}

/// A line for each cell: its place in the grid, the centre in millimetres, its layer in the order of the growth (0: missed), and the
/// layer that is printed of which it is a part, if it is: 0 in `layers`, which is empty before there are any, says that it is of none. Last the direction of the
/// nozzle, of cells that were judged by it.
fn write_field(run: &FieldRun, order: &[u32], layers: &[u32], out: &mut dyn Write) -> io::Result<()> {
    let grid = &run.solid.grid;
    // Numbers with four digits take most of the time, and there are only as many as planes of cells.
    let along = |axis: usize| -> Vec<[String; 2]> {
        let text = |at: u32| {
            let mut cell = [0; 3];
            cell[axis] = at;
            [format!("{at},"), format!("{:.4},", grid.centre(cell)[axis])]
        };
        (0..grid.dims()[axis]).map(text).collect()
    };
    let [xs, ys, zs] = [0, 1, 2].map(along);
    writeln!(out, "x,y,z,x_mm,y_mm,z_mm,cell_layer,layer,nx,ny,nz")?;
    let mut directions = run.growth.nozzle.iter().peekable();
    let mut line = String::new();
    for cell in grid.iter() {
        let [x, y, z] = grid.position(cell).map(|at| at as usize);
        line.clear();
        [0, 1].iter().for_each(|&k| line.extend([&xs[x][k], &ys[y][k], &zs[z][k]].map(String::as_str)));
        let _ = write!(line, "{},", order[cell as usize]); // to a string, which takes it
        if let Some(layer) = layers.get(cell as usize).filter(|&&layer| layer > 0) {
            let _ = write!(line, "{layer}");
        }
        // Both lists rise.
        while directions.next_if(|judged| judged.cell < cell).is_some() {}
        match directions.next_if(|judged| judged.cell == cell).map(|judged| judged.direction) {
            Some(at) => _ = write!(line, ",{},{},{}", at.x, at.y, at.z),
            None => line.push_str(",,,"),
        }
        line.push('\n');
        out.write_all(line.as_bytes())?;
    }
    Ok(())
}

/// How many cells were missed for reasons that `is` picks.
fn missed(run: &FieldRun, is: impl Fn(MissedReason) -> bool) -> usize {
    run.growth.missed.iter().filter(|missed| is(missed.reason)).count()
}

pub fn summary(args: &Args, part: &Part, run: &FieldRun, summary: &mut Summary) -> Result<(), Failure> {
    of_part(args, part, run, summary)?;
    of_order_options(args, run, summary)?;
    of_settings(args, summary)?;
    of_times(run, summary)?;
    of_order(run, summary)
}

/// The part and its cells.
fn of_part(args: &Args, part: &Part, run: &FieldRun, summary: &mut Summary) -> Result<(), Failure> {
    let grid = &run.solid.grid;
    let [nx, ny, nz] = grid.dims();
    summary
        .set("version", env!("CARGO_PKG_VERSION"))?
        .set("mesh", part.name.as_str())?
        .set("unit", typed_name(args.mesh.unit))?
        .set("scale", args.mesh.scale)?
        .set("up", typed_name(args.mesh.up))?
        .set("stage", typed_name(args.stage))?
        .set("triangles", part.mesh.triangles.len())?
        .set("volume_mm3", run.mesh.volume_mm3())?
        .set("part_volume_mm3", run.part_mm3)?
        .set("watertight", run.mesh.watertight)?
        .set("thinner_than_cell_share", run.thin.share)?
        .set("cell_mm", grid.cell_mm())?
        .set("nx", nx)?
        .set("ny", ny)?
        .set("nz", nz)?
        .set("cells", grid.count())?;
    Ok(())
}

/// How the order was to be found, and on what.
fn of_order_options(args: &Args, run: &FieldRun, summary: &mut Summary) -> Result<(), Failure> {
    let [nozzle_growth, support] = args.complete.names(args.grow.strategy().is_none());
    let named =
        |path: &Option<PathBuf>| path.as_ref().map_or_else(|| "none".to_owned(), |path| path.display().to_string());
    summary
        .set("coherent", args.coherent)?
        .set("eps_cells", args.grow.eps_cells)?
        .set("beyond_eps", args.grow.beyond_eps)?
        .set("layers_by", typed_name(args.layers_by()))?
        .set("nozzle_growth", nozzle_growth)?
        .set("nozzle_max_tilt_deg", args.complete.max_tilt_deg)?
        .set(
            "max_layer_tilt_deg",
            args.complete.max_layer_tilt_deg.map_or("nozzle".to_owned(), |tilt| tilt.to_string()),
        )?
        .set("nozzle_margin_cells", args.complete.nozzle_margin_cells)?
        .set("support", support)?
        .set("support_width_cells", args.complete.support_width_cells)?
        .set("support_contact_cells", args.complete.support_contact_cells)?
        .set("support_gap_cells", args.complete.support_gap_cells)?
        .set("platform_diameter_mm", run.platform_diameter_mm())?
        .set("base", named(&args.base))?
        .set("directions", named(&args.directions))?
        .set("max_overhang_deg", args.max_overhang_deg.map_or("none".to_owned(), |degrees| degrees.to_string()))?
        .set("on", run.mould.as_ref().map_or("none", |mould| &mould.name))?
        .set("buried_mm3", run.buried_mm3)?
        .set("strategy", typed_name(args.grow.strategy))?
        .set("strategy_used", run.strategy)?
        .set("layers_by_used", run.layers_by.map_or("saved".to_owned(), |by| typed_name(LayersBy::from(by))))?
        .set("prevention", typed_name(args.grow.prevention))?
        .set("threads", args.common.threads)?
        .set("max_memory_gb", args.max_memory_gb)?
        .set_all(&args.allow)?
        .set("profile", named(&args.profile))?
        .set("workcell", named(&args.motion.workcell))?;
    Ok(())
}

/// The settings of a profile.
fn of_settings(args: &Args, summary: &mut Summary) -> Result<(), Failure> {
    // Those with values of the run come with their stage.
    let later = ["workcell", "layer_height_mm", "bead_mm", "nozzle", "platform_diameter_mm"];
    for (name, value) in args.settings.fields().into_iter().filter(|(name, _)| !later.contains(&name.as_str())) {
        let name = if name == "name" { "profile_name".to_owned() } else { name };
        let value = match value {
            Value::Null => "none".into(),
            Value::Array(lines) => lines.iter().filter_map(Value::as_str).collect::<Vec<_>>().join("\n").into(),
            value => value,
        };
        summary.set(&name, value)?;
    }
    Ok(())
}

/// How long the steps took.
fn of_times(run: &FieldRun, summary: &mut Summary) -> Result<(), Failure> {
    let times = &run.times;
    summary
        .set_seconds("inspect_s", times.inspect)?
        .set_seconds("voxelise_s", times.voxelise)?
        .set_seconds("peel_s", times.peel)?
        .set_seconds("grow_s", times.grow)?
        .set_seconds("audit_s", times.audit)?
        .set_seconds("prove_s", times.prove)?
        .set_seconds("check_proofs_s", times.check_proofs)?
        .set_seconds("total_s", times.total)?;
    Ok(())
}

/// The order, what it misses, and what its checks say.
fn of_order(run: &FieldRun, summary: &mut Summary) -> Result<(), Failure> {
    let growth = &run.growth;
    summary
        .set("cell_layers", growth.order.len())?
        .set("steps_per_layer", run.steps_per_layer)?
        .set("missed_cells", growth.missed.len())?
        .set("missed_by_hull_cells", run.missed_by_hull.len())?
        .set("nozzle_cells", growth.nozzle.len())?
        .set("support_cells", run.support.len())?
        .set("support_below_beads_cells", run.below_beads)?
        .set("support_cells_volume_mm3", run.support_mm3())?
        .set("support_straight_cells", run.straight_cells)?
        .set("missed_volume_mm3", run.missed_mm3)?
        .set("missed_share", run.missed_share())?
        .set("missed_shadowed", missed(run, |reason| matches!(reason, MissedReason::Shadowed { .. })))?
        .set("missed_out_of_reach", missed(run, |reason| reason == MissedReason::OutOfReach))?
        .set(
            "missed_unsupported",
            missed(run, |reason| matches!(reason, MissedReason::SupportMissed | MissedReason::NeverAdjacent)),
        )?
        .set("impossible_cells", run.impossible.len())?
        .set("undecided_cells", run.undecided())?
        .set("proofs_ok", run.proofs.is_ok())?
        .set("audit_ok", run.audit.is_ok())?
        .set("small_patch_share", run.quality.small_patch_share)?
        .set("patches_per_layer", run.quality.patches_per_layer)?;
    Ok(())
}

/// What the part stands on, in words.
fn platform_row(run: &FieldRun) -> String {
    let on = run.mould.as_ref().map_or_else(String::new, |mould| format!(", {} on it", mould.name));
    format!("disc of {:.1} mm{on}", run.platform_diameter_mm())
}

/// How much support there is, in words.
fn support_row(run: &FieldRun) -> String {
    match (run.support.len(), run.straight_cells) {
        (0, _) if run.support_mm3() > 0.0 => format!("{:.1} mm3 in cells of the part", run.support_mm3()),
        (0, _) => "none".to_owned(),
        (cells, 0) => format!("{}, {:.1} mm3", counted(cells, "cell"), run.support_mm3()),
        (cells, straight) => {
            let share = 100.0 * cells as f64 / straight as f64;
            format!("{}, {:.1} mm3; {share:.0} % of straight columns", counted(cells, "cell"), run.support_mm3())
        }
    }
}

pub fn rows(args: &Args, part: &Part, run: &FieldRun, table: &mut Table) {
    let (grid, growth, times) = (&run.solid.grid, &run.growth, &run.times);
    let [nx, ny, nz] = grid.dims();
    table
        .row(["part".to_owned(), format!("{}, {}", part.name, counted(part.mesh.triangles.len(), "triangle"))])
        .row(["cells".to_owned(), format!("{} of {:.4} mm, grid {nx} x {ny} x {nz}", grid.count(), grid.cell_mm())])
        .row(["strategy".to_owned(), format!("{}: {}", typed_name(args.grow.strategy), run.strategy)])
        .row(["platform".to_owned(), platform_row(run)])
        .row(["eps".to_owned(), format!("{}, in cells", args.grow.eps_cells)])
        .row(["cell layers".to_owned(), growth.order.len().to_string()])
        .row([
            "missed cells".to_owned(),
            format!(
                "{}, {:.2} % of the volume; by hulls alone {}, {} of them proven impossible, {} undecided",
                growth.missed.len(),
                100.0 * run.missed_share(),
                run.missed_by_hull.len(),
                run.impossible.len(),
                run.undecided()
            ),
        ])
        .row(["by the nozzle".to_owned(), counted(growth.nozzle.len(), "cell")])
        .row(["support".to_owned(), support_row(run)])
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
        .row([
            "time".to_owned(),
            format!(
                "{}: cells {}, growth {} (peeling {}), audit {}",
                seconds(times.total),
                seconds(times.voxelise),
                seconds(times.grow),
                seconds(times.peel),
                seconds(times.audit)
            ),
        ]);
}

/// What the audit of this run says of the order of the cells.
fn reach(args: &Args, run: &FieldRun) -> String {
    if !run.audit.is_ok() {
        return format!("The order of the cells fails its audit: {}.", run.audit);
    }
    let (by_nozzle, built) = (run.growth.nozzle.len(), run.growth.order.cells().len());
    let missed = match run.growth.missed.len() {
        0 => String::new(),
        1 => " One cell is in no layer.".to_owned(),
        missed => format!(" {} are in no layer.", counted(missed, "cell")),
    };
    let depth = if args.grow.beyond_eps { "at most" } else { "less than" };
    let by_hull = format!(
        "the centre lies outside the convex hull of the platform and the centres of all earlier cells, or {depth} {} of a cell deep in it: a \
         nozzle of any size reaches it if it may go as deep into earlier cells",
        args.grow.eps_cells
    );
    let by_shape = "the nozzle of this run, in the direction that was found for it, meets neither the plate nor an earlier cell, taken as a \
                    ball; a larger nozzle may not reach it";
    let reach = match by_nozzle {
        0 => format!("Of each {by_hull}."),
        all if all == built => format!("For each {by_shape}."),
        some => format!("For {some} of them {by_shape}. Of the other {} {by_hull}.", built - some),
    };
    let on = run.mould.as_ref().map_or_else(String::new, |mould| format!(" or on {}", mould.name));
    format!(
        "The audit of this order of {built} cells found no fault.{missed} Each stands on the plate{on} or has a neighbour in an earlier cell layer. {reach}"
    )
}

/// The first chapter: what it is about, and the field.
pub fn report(args: &Args, run: &FieldRun, report: &mut Report) -> Result<(), Failure> {
    let (grid, field) = (&run.solid.grid, numbers(run));
    let layered = LayeredCells::new(grid.dims(), grid.rows(), &field).map_err(failure)?;
    let (layers, missed) = (run.growth.order.len() as u32, run.growth.missed.len());
    let [width, height] = PICTURE;
    let view = |toward: Vector3<f64>| {
        let corners: Vec<[f64; 2]> = run.platform.corners().iter().map(|c| c.map(|c| f64::from(c) / 2.0)).collect();
        let mut scene = Scene::new(Camera::from_direction(toward));
        scene.platform(&corners, 0.0);
        if let Some(mould) = &run.mould {
            let in_cells = |vertex: &Point3<f64>| Point3::from((vertex - grid.origin()) / grid.cell_mm());
            scene.mesh(&mould.vertices.iter().map(in_cells).collect::<Vec<_>>(), &mould.triangles, PLAIN);
        }
        scene.cells(&layered, None);
        scene.draw(width, height).with_legend(layers, missed).to_png()
    };
    let cut = |plane: Plane| draw_cut(&layered, plane, width, height).with_legend(layers, missed).to_png();
    report.paragraph(&reach(args, run));
    report
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
    Ok(())
}

/// The last chapter: this run beside the paper's.
pub fn comparison(part: &Part, run: &FieldRun, report: &mut Report) {
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
    report.heading("For comparison").table("Dai 2020, Table 3.1, on a Xeon E5 1630, and this run", &table);
}
