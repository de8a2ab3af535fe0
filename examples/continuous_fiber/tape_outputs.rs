//! What both kinds of runs write of their tapes.

use super::layer::LoadedLayer;
use super::{Args, drawing};
use curvlay_examples::args::{Failure, typed_name};
use curvlay_examples::summary::Summary;
use curvlay_toolpath::fiber::tapes::{Tape, TapePlan};
use std::io::{self, Write};

/// Steering radii from here on are written as this: JSON has no infinity, and so straight is straight.
pub const STRAIGHT_MM: f64 = 1e6;

/// The first line of `tapes.csv`.
pub fn tape_header(out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "part,layer,tape,x_mm,y_mm,z_mm,nx,ny,nz,radius_mm")
}

/// A line for each point of each tape of a layer, which is counted from 0.
pub fn tape_lines(out: &mut dyn Write, part: &str, layer: u32, plan: &TapePlan) -> io::Result<()> {
    for (number, (tape, radii)) in plan.tapes.iter().zip(&plan.radii).enumerate() {
        for ((p, n), radius) in tape.points.iter().zip(&tape.normals).zip(radii) {
            let numbers = [layer + 1, number as u32 + 1].map(|number| number.to_string()).join(",");
            write!(out, "{part},{numbers},{:.4},{:.4},{:.4},{:.6},{:.6},{:.6}", p.x, p.y, p.z, n.x, n.y, n.z)?;
            writeln!(out, ",{:.3}", radius.min(STRAIGHT_MM))?;
        }
    }
    Ok(())
}

/// A steering radius in words.
pub fn radius(mm: f64) -> String {
    if mm < STRAIGHT_MM { format!("{mm:.1}") } else { "straight".to_owned() }
}

/// Stresses of a layer, and its tapes: names, captions and bytes.
pub fn layer_pictures(layer: &LoadedLayer, wires: &[Tape], min_radius_mm: f64) -> Vec<(String, String, Vec<u8>)> {
    let caption = format!("{}: greatest principal stress in the layer, {}", layer.name, layer.source);
    let stress = ("layer_stress.png".to_owned(), caption, drawing::stress(layer));
    let caption = format!("{}: tapes by steering radius", layer.name);
    vec![stress, ("layer.png".to_owned(), caption, drawing::tapes(layer, wires, min_radius_mm))]
}

/// The options of a run.
pub fn options(args: &Args, summary: &mut Summary) -> Result<(), Failure> {
    let mesh = args.mesh.path().and_then(|path| path.file_name()).map(|name| name.to_string_lossy().into_owned());
    summary
        .set("version", env!("CARGO_PKG_VERSION"))?
        .set("mesh", mesh.unwrap_or_else(|| "arc".to_owned()))?
        .set("stage", typed_name(args.stage))?
        .set("tape_width_mm", args.tape_width_mm)?
        .set("tape_spacing_mm", args.tape_options().spacing)?
        .set("tape_thickness_mm", args.tape_thickness_mm)?
        .set("allowed_radius_mm", args.min_radius_mm)?
        .set("min_length_mm", args.min_length_mm)?
        .set("max_overlap", args.max_overlap)?
        .set("smoothing_mm", args.smoothing_mm())?
        .set("compensate", args.compensate)?
        .set("press_n", args.press_n)?
        .set("heat_celsius", args.celsius)?
        .set("threads", args.common.threads)?;
    Ok(())
}
