//! What the example leaves behind: the table on stdout, meshes of the parts, `parts.csv`, `separations.csv`, `features.csv`,
//! `report.html` and `summary.json`.

use super::volumes::{Divided, PART};
use super::{Args, Shape, drawing};
use clap::ValueEnum;
use curvlay_examples::args::{Failure, typed_name};
use curvlay_examples::count::counted;
use curvlay_examples::findings::{Findings, percent};
use curvlay_examples::mesh::Mesh;
use curvlay_examples::motion::{Printed, is_program};
use curvlay_examples::output::{OutputFolder, is_numbered};
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::{Table, direction};
use curvlay_layers::planar::{FeatureKind, Scenario, Separation, Solid};
use curvlay_trajectory::print::FaultKind;
use std::io::{self, Write};
use std::time::Instant;

pub fn write(
    args: &Args,
    (divided, printed): (&[Divided], Option<&Printed>),
    findings: &Findings,
    folder: &OutputFolder,
    start: Instant,
) -> Result<(), Failure> {
    folder.clear(is_ours)?;
    for of in divided {
        for (k, part) in of.result.parts.iter().enumerate() {
            folder
                .write_with(&format!("{}_part_{:02}.stl", of.name, k + 1), |out| mesh_of(&part.solid).write_stl(out))?;
        }
    }
    folder.write_with("parts.csv", |out| write_parts(divided, out))?;
    folder.write_with("layers.csv", |out| write_layers(divided, out))?;
    folder.write_with("separations.csv", |out| write_separations(divided, out))?;
    let has_features = divided.iter().any(|of| !of.result.features.is_empty());
    folder.write_list("features.csv", has_features, |out| write_features(divided, out))?;
    if let Some(moved) = printed.and_then(|printed| printed.moved.as_ref()) {
        for (name, bytes) in &moved.files {
            folder.write(name, bytes)?;
        }
    }
    folder.write("report.html", report(args, divided, findings).to_html())?;
    // The summary comes last: where it is, all is there.
    summary(args, (divided, printed), findings, start)?.write(folder)?;
    Ok(())
}

/// Files that an earlier run may have left.
pub fn is_ours(name: &str) -> bool {
    let shapes = Shape::value_variants().iter().map(|&shape| typed_name(shape));
    let mut stems = shapes.chain([PART.to_owned()]);
    stems.any(|stem| is_numbered(name, &format!("{stem}_part_"), 2, ".stl"))
        || is_program(name)
        || ["parts.csv", "layers.csv", "separations.csv", "features.csv", "report.html"].contains(&name)
}

fn mesh_of(solid: &Solid) -> Mesh {
    Mesh { vertices: solid.vertices().to_vec(), triangles: solid.triangles().to_vec() }
}

fn write_parts(divided: &[Divided], out: &mut dyn Write) -> io::Result<()> {
    writeln!(
        out,
        "shape,part,dx,dy,dz,base_mm,volume_mm3,layers,separation,overhang_mm3,unsupported_mm2,layered_mm3,unlayered_mm3,\
         sections_mm3,thin_mm3,left_out_mm3,added_mm3,layers_mm2,blocked_mm2"
    )?;
    for of in divided {
        for (k, part) in of.result.parts.iter().enumerate() {
            let d = part.direction;
            let separation = part.separation.map_or_else(String::new, |k| (k + 1).to_string());
            let found = &of.audit.parts[k];
            write!(
                out,
                "{},{},{:.9},{:.9},{:.9},{:.6},{:.6},{},{separation},{:.6},{:.6}",
                of.name,
                k + 1,
                d.x,
                d.y,
                d.z,
                part.base_mm,
                part.solid.volume(),
                part.layers.len(),
                part.overhang_mm3,
                found.unsupported_mm2
            )?;
            let volumes = [found.layered_mm3, found.unlayered_mm3, found.sections_mm3, found.thin_mm3];
            let features = [found.left_out_mm3, found.added_mm3];
            for figure in volumes.into_iter().chain(features).chain([found.layers_mm2, found.blocked_mm2]) {
                write!(out, ",{figure:.6}")?;
            }
            writeln!(out)?;
        }
    }
    Ok(())
}

/// The layers that are audited and printed.
fn write_layers(divided: &[Divided], out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "shape,part,layer,low_mm,high_mm,area_mm2")?;
    for of in divided {
        for (k, part) in of.result.parts.iter().enumerate() {
            for (number, layer) in part.layers.iter().enumerate() {
                let (low, high, area) = (layer.low_mm, layer.high_mm, layer.section.area());
                writeln!(out, "{},{},{},{low:.6},{high:.6},{area:.6}", of.name, k + 1, number + 1)?;
            }
        }
    }
    Ok(())
}

fn scenario(separation: &Separation) -> &'static str {
    match separation.scenario {
        Scenario::Crossing => "crossing",
        Scenario::Enclosing => "enclosing",
    }
}

fn write_separations(divided: &[Divided], out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "shape,separation,scenario,height_mm,points,walls,overhang_mm3,taken_mm3")?;
    for of in divided {
        for (k, step) in of.result.separations.iter().enumerate() {
            let (kind, walls) = (scenario(step), step.walls.len());
            write!(out, "{},{},{kind},{:.6},{},{walls}", of.name, k + 1, step.height_mm, step.points.len())?;
            writeln!(out, ",{:.6},{:.6}", step.overhang_mm3, step.taken_mm3)?;
        }
    }
    Ok(())
}

fn write_features(divided: &[Divided], out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "shape,kind,from_mm,to_mm,u_mm,v_mm,size_mm,volume_mm3")?;
    for of in divided {
        for feature in &of.result.features {
            let kind = if feature.kind == FeatureKind::Hole { "hole" } else { "island" };
            write!(out, "{},{kind},{:.4},{:.4}", of.name, feature.from_mm, feature.to_mm)?;
            let (middle, size) = (feature.middle, feature.size_mm);
            writeln!(out, ",{:.4},{:.4},{size:.4},{:.4}", middle.x, middle.y, feature.volume_mm3)?;
        }
    }
    Ok(())
}

/// A line for each part of each shape.
pub fn table(divided: &[Divided]) -> Table {
    let heads = [
        "shape",
        "part",
        "direction",
        "volume mm3",
        "layers",
        "overhang before mm3",
        "after mm3",
        "torch blocked",
        "audit",
        "time s",
    ];
    let mut table = Table::new(heads);
    for of in divided {
        for (k, part) in of.result.parts.iter().enumerate() {
            let first = |text: String| if k == 0 { text } else { String::new() };
            table.row([
                first(of.name.clone()),
                (k + 1).to_string(),
                direction(&part.direction),
                format!("{:.0}", part.solid.volume()),
                part.layers.len().to_string(),
                first(format!("{:.0}", of.result.overhang_before_mm3)),
                format!("{:.0}", part.overhang_mm3),
                percent(of.audit.parts[k].blocked_mm2 / of.audit.parts[k].layers_mm2.max(f64::MIN_POSITIVE)),
                first(if of.audit.is_ok { "ok".to_owned() } else { "failed".to_owned() }),
                first(format!("{:.3}", of.decompose_time.as_secs_f64())),
            ]);
        }
    }
    table
}

fn summary(
    args: &Args,
    (divided, printed): (&[Divided], Option<&Printed>),
    findings: &Findings,
    start: Instant,
) -> Result<Summary, Failure> {
    let mut summary = Summary::new();
    let file = args.mesh.path().and_then(|path| path.file_name()).map(|name| name.to_string_lossy().into_owned());
    summary
        .set("version", env!("CARGO_PKG_VERSION"))?
        .set("mesh", file.unwrap_or_else(|| typed_name(args.shape)))?
        .set("layer_mm", args.layer_mm)?
        .set("least_layer_mm", args.options().min_layer_mm)?
        .set("angle_deg", args.angle_deg)?
        .set("torch_mm", args.torch_mm)?
        .set("stand_off_mm", args.stand_off_mm)?
        .set("feature_mm", args.feature_mm)?
        .set("base", typed_name(args.base))?
        .set("allow_blocked", args.allow_blocked)?
        .set("threads", args.common.threads)?;
    let plain = typed_name(args.shape);
    for of in divided {
        let prefixes = if args.mesh.path().is_some() {
            vec![String::new()]
        } else if of.name == plain {
            vec![String::new(), format!("{}_", of.name)]
        } else {
            vec![format!("{}_", of.name)]
        };
        for prefix in prefixes {
            of_division(of, &prefix, &mut summary)?;
        }
    }
    if let Some(printed) = printed {
        of_print(printed, &mut summary)?;
    }
    findings.summary(&mut summary)?;
    summary.set_seconds("total_s", start.elapsed())?;
    Ok(summary)
}

/// The figures of a shape, each key with a prefix.
fn of_division(of: &Divided, prefix: &str, summary: &mut Summary) -> Result<(), Failure> {
    let key = |name: &str| format!("{prefix}{name}");
    summary
        .set(&key("facets"), of.solid.triangles().len())?
        .set(&key("volume_mm3"), of.solid.volume())?
        .set(&key("parts"), of.result.parts.len())?
        .set(&key("separations"), of.result.separations.len())?
        .set(&key("features"), of.result.features.len())?
        .set(&key("layers"), of.layers())?
        .set(&key("overhang_before_mm3"), of.result.overhang_before_mm3)?
        .set(&key("overhang_after_mm3"), of.overhang_after_mm3())?
        .set(&key("stuck_parts"), of.result.stuck.len())?
        .set(&key("audit_ok"), of.audit.is_ok)?
        .set(&key("volume_error"), of.audit.volume_error)?
        .set(&key("missing_share"), of.audit.missing_share)?
        .set(&key("doubled_share"), of.audit.doubled_share)?
        .set(&key("unsupported_mm2"), of.unsupported_mm2())?
        .set(&key("unlayered_mm3"), of.audit.sum(|part| part.unlayered_mm3))?
        .set(&key("thin_mm3"), of.audit.sum(|part| part.thin_mm3))?
        .set(&key("left_out_mm3"), of.audit.sum(|part| part.left_out_mm3))?
        .set(&key("added_mm3"), of.audit.sum(|part| part.added_mm3))?
        .set(&key("blocked_share"), of.blocked_share())?
        .set_seconds(&key("decompose_s"), of.decompose_time)?
        .set_seconds(&key("audit_s"), of.audit_time)?;
    Ok(())
}

/// The print, if its motion was planned.
fn of_print(printed: &Printed, summary: &mut Summary) -> Result<(), Failure> {
    let Some(moved) = &printed.moved else { return Ok(()) };
    summary
        .set("cell", moved.cell.as_str())?
        .set("paths", printed.plan.resolved.paths.len())?
        .set("path_mm", printed.path_mm())?
        .set("left_out_mm", printed.left_out_mm())?
        .set("transfers", moved.transfers)?
        .set("missing_transfers", moved.missing)?
        .set("unreachable_waypoints", moved.count(FaultKind::Unreachable))?
        .set("motion_faults", moved.faults.len())?
        .set("robot_min", moved.robot_s / 60.0)?
        .set("program_files", moved.files.len())?;
    Ok(())
}

/// The most steps and parts that the report shows of one shape.
const SHOWN: usize = 12;

fn report(args: &Args, divided: &[Divided], findings: &Findings) -> Report {
    let mut report = Report::new("Volumes along several directions");
    findings.report(&mut report);
    report.paragraph(&format!(
        "Layers of {} mm; a side that slopes less than {} degrees over the level needs support. What a layer carries is green, what \
         hangs over is red, intersection points are black. Walls are blue, and grey where they are tilted for a \
         torch of {} mm at a stand-off of {} mm: a cone to its mouth and a cylinder behind it, checked at every layer against the parts \
         that are printed before and the plate. Arrows are the printing directions.",
        args.layer_mm, args.angle_deg, args.torch_mm, args.stand_off_mm
    ));
    report.table("All parts", &table(divided));
    for of in divided {
        report.heading(&of.name);
        let steps = of.result.separations.iter().take(SHOWN).enumerate();
        let drawn: Vec<(String, Vec<u8>)> = steps
            .map(|(k, step)| {
                let caption = format!("separation {}: {}, {:.0} mm3 taken off", k + 1, scenario(step), step.taken_mm3);
                (caption, drawing::step(step))
            })
            .collect();
        let all = of.result.parts.len();
        let counts = (1..=all).filter(|&count| count == all || count < SHOWN);
        let built: Vec<(String, Vec<u8>)> = counts
            .map(|count| (format!("{count} of {} printed", counted(all, "part")), drawing::parts(of, count)))
            .collect();
        let printed = vec![(format!("{}, as audited and printed", counted(of.layers(), "layer")), drawing::layers(of))];
        for pictures in [drawn, built, printed] {
            let pairs: Vec<(&str, &[u8])> =
                pictures.iter().map(|(caption, png)| (caption.as_str(), png.as_slice())).collect();
            if !pairs.is_empty() {
                report.pictures(&pairs);
            }
        }
    }
    report
}
