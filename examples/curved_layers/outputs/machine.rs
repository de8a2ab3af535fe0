//! Of the machine file: `toolpath.gcode`, figures, and how one path turns.

use super::axes;
use super::files::Files;
use super::pictures;
use super::shown::{borrowed, seconds};
use crate::args::{Args, Extra, failure};
use crate::field::FieldRun;
use crate::job::Job;
use crate::machine::{MachineRun, to_lay_mm3};
use crate::paths::PathsRun;
use crate::surfaces::SurfacesRun;
use curvlay_examples::args::Failure;
use curvlay_examples::count::counted;
use curvlay_examples::findings::percent;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::plot::Plot;
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use curvlay_kinematics::workcell::NozzleModel;
use curvlay_toolpath::cam::{AptOptions, CamError, write_apt, write_csv};
use curvlay_toolpath::gcode::flavour::{Flavour, FlavourWritten, ProgramOptions, write_flavour};
use curvlay_toolpath::gcode::{WriteOptions, Written, write_gcode};
use curvlay_toolpath::gouging::{Obstacle, ResolvedPaths};
use curvlay_toolpath::orientation::ToolPath;
use curvlay_toolpath::shell::ShellGap;
use curvlay_toolpath::support::UnsupportedPiece;
use curvlay_toolpath::vtp::write_paths_vtp;
use serde_json::Value;
use std::io;
use std::path::Path;

const MACHINE_FILE: &str = "toolpath.gcode";

/// Writes the tool paths and the machine files; that of a machine with rotary axes only where these reach all directions.
pub fn products(
    args: &Args,
    name: &str,
    run: &MachineRun,
    (files, folder): (&mut Files, &OutputFolder),
) -> Result<(), Failure> {
    axes::check(args, run)?;
    let templates = args.settings.templates();
    let options = args.settings.write_options(&templates);
    folder.write_with("paths.vtp", |out| write_paths_vtp(&run.resolved.paths, &run.deposition.moves, out))?;
    let program = program_name(name);
    let of_program = args.settings.program_options(&program, &templates);
    files.gcode = Some(match &args.loaded_flavour {
        Some(flavour) => write_in(run, flavour, &of_program, folder)?,
        None => write(run, &options, MACHINE_FILE, folder)?,
    });
    files.axes = args.printer.as_ref().map(|printer| axes::write(run, printer, &of_program, folder)).transpose()?;
    let failed = |error: CamError| match error {
        CamError::Io(error) => error,
        error => io::Error::new(io::ErrorKind::InvalidData, error.to_string()),
    };
    let name = AptOptions { name, ..AptOptions::default() };
    folder.write_list("toolpath.apt", args.writes(Extra::Apt), |out| {
        write_apt(run.moves(), &name, out).map(|_| ()).map_err(failed)
    })?;
    folder.write_list("toolpath.csv", args.writes(Extra::Csv), |out| {
        write_csv(run.moves(), out).map(|_| ()).map_err(failed)
    })?;
    folder.write_list("gouging.csv", !run.resolved.left.is_empty(), |out| gouging(run, out))?;
    folder.write_list("left_out.csv", !run.resolved.left_out.is_empty(), |out| left_out(run, out))?;
    folder.write_list("turns.csv", !(run.resolved.cut_turns.is_empty() && run.resolved.sharp.is_empty()), |out| {
        turns(run, out)
    })?;
    folder.write_list("blocked_travels.csv", !run.travels.blocked.is_empty(), |out| blocked_travels(run, out))?;
    for (name, list) in [("unsupported.csv", &run.support.unsupported), ("spans.csv", &run.support.spans)] {
        folder.write_list(name, !list.is_empty(), |out| pieces(run, list, out))?;
    }
    Ok(())
}

/// Pieces of beads.
fn pieces(run: &MachineRun, list: &[UnsupportedPiece], out: &mut dyn io::Write) -> io::Result<()> {
    writeln!(out, "layer,path,from_mm,to_mm,length_mm,x,y,z")?;
    list.iter().try_for_each(|piece| {
        let (layer, [from, to], tip) = (run.resolved.paths[piece.path].layer + 1, piece.arcs, piece.tip);
        write!(out, "{layer},{},{from:.3},{to:.3},{:.3},", piece.path, piece.length())?;
        writeln!(out, "{:.3},{:.3},{:.3}", tip.x, tip.y, tip.z)
    })
}

fn blocked_travels(run: &MachineRun, out: &mut dyn io::Write) -> io::Result<()> {
    writeln!(out, "path,obstacle,x,y,z")?;
    run.travels.blocked.iter().try_for_each(|travel| {
        let (obstacle, tip) = (travel.obstacle, travel.tip);
        writeln!(out, "{},{obstacle},{:.4},{:.4},{:.4}", travel.path, tip.x, tip.y, tip.z)
    })
}

/// Layers count from 1, paths (in the order in which they are printed) and waypoints from 0.
fn place(run: &MachineRun, path: usize, waypoint: usize) -> String {
    let (path_of, tip) = (&run.resolved.paths[path], run.resolved.paths[path].waypoints[waypoint].position);
    format!("{},{path},{waypoint},{:.3},{:.3},{:.3}", path_of.layer + 1, tip.x, tip.y, tip.z)
}

/// Waypoints that gouge.
fn gouging(run: &MachineRun, out: &mut dyn io::Write) -> io::Result<()> {
    writeln!(out, "layer,path,waypoint,x,y,z,obstacle,depth_mm,nozzle_part,why")?;
    run.resolved.left.iter().try_for_each(|gouge| {
        let why = match gouge.obstacle {
            Obstacle::Layer(_) if gouge.own_layer => "no tilt frees it of beads of its own layer",
            Obstacle::Layer(_) => "no tilt frees it of earlier layers",
            _ => "too near to the plate",
        };
        let (place, part) = (place(run, gouge.path, gouge.waypoint), gouge.part);
        writeln!(out, "{place},{},{:.4},{part},{why}", gouge.obstacle, gouge.depth)
    })
}

/// Pieces of curves that are not printed.
fn left_out(run: &MachineRun, out: &mut dyn io::Write) -> io::Result<()> {
    writeln!(out, "layer,curve,from_mm,to_mm,x,y,z,obstacle,depth_mm,nozzle_part")?;
    run.resolved.left_out.iter().try_for_each(|piece| {
        let ([from, to], tip) = (piece.arcs, piece.tip);
        write!(out, "{},{},{from:.3},{to:.3},{:.3},{:.3},{:.3},", piece.layer + 1, piece.curve, tip.x, tip.y, tip.z)?;
        writeln!(out, "{},{:.4},{}", piece.obstacle, piece.depth, piece.part)
    })
}

/// Where the nozzle turns too far for its way: paths are cut there, or it turns slowly.
fn turns(run: &MachineRun, out: &mut dyn io::Write) -> io::Result<()> {
    writeln!(out, "layer,path,waypoint,x,y,z,turn_deg,how")?;
    let cut = run.resolved.cut_turns.iter().map(|turn| (turn, "cut"));
    cut.chain(run.resolved.sharp.iter().map(|turn| (turn, "slow"))).try_for_each(|(turn, how)| {
        writeln!(out, "{},{:.2},{how}", place(run, turn.path, turn.waypoint), turn.angle.to_degrees())
    })
}

fn write(run: &MachineRun, options: &WriteOptions, name: &str, folder: &OutputFolder) -> Result<Written, Failure> {
    let mut written = Ok(Written::default());
    folder
        .write_with(name, |out| {
            written = write_gcode(run.moves(), options, out);
            // The findings below say what is wrong.
            written.as_ref().map(|_| ()).map_err(|_| io::ErrorKind::InvalidData.into())
        })
        .or_else(|error| if written.is_ok() { Err(error) } else { Ok(()) })?;
    written.map_err(|error| failure(format!("{name}: {error}")))
}

/// The same in a flavour, with the flavour beside it, to copy from.
fn write_in(
    run: &MachineRun,
    flavour: &Flavour,
    options: &ProgramOptions,
    folder: &OutputFolder,
) -> Result<Written, Failure> {
    let mut written = Ok(FlavourWritten::default());
    folder
        .write_with(MACHINE_FILE, |out| {
            written = write_flavour(run.moves(), flavour, options, out);
            written.as_ref().map(|_| ()).map_err(|_| io::ErrorKind::InvalidData.into())
        })
        .or_else(|error| if written.is_ok() { Err(error) } else { Ok(()) })?;
    folder.write("flavour.json", serde_json::to_string_pretty(flavour).map_err(failure)? + "\n")?;
    written.map(|all| all.written).map_err(|error| failure(format!("{MACHINE_FILE}: {error}")))
}

/// A name that controllers take, from that of the part, without the ending of its file.
fn program_name(name: &str) -> String {
    let stem = Path::new(name).file_stem().map_or_else(|| name.into(), |stem| stem.to_string_lossy());
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
    let name: String = stem.chars().map(plain).take(32).collect();
    if name.is_empty() { "part".to_owned() } else { name }
}

/// The share of the part that is laid, and of how much, in words.
pub fn filled(field: &FieldRun, paths: &PathsRun, run: &MachineRun) -> String {
    let (laid, hollow) = (run.deposition.extruded_mm3, paths.hollow_mm3());
    let part = to_lay_mm3(field, paths);
    let but = if hollow > 0.0 { format!(", {hollow:.1} mm3 stay hollow") } else { String::new() };
    format!("{:.1} %, {laid:.1} of {part:.1} mm3{but}", 100.0 * laid / part)
}

pub fn summary(
    job: &Job,
    field: &FieldRun,
    paths: &PathsRun,
    run: &MachineRun,
    written: &Written,
    summary: &mut Summary,
) -> Result<(), Failure> {
    of_orientation(job, field, paths, run, summary)?;
    if let Some(skin) = run.skin {
        summary
            .set("skin_gap_mean_mm", skin.mean_mm)?
            .set("skin_gap_p50_mm", skin.p50_mm)?
            .set("skin_gap_p95_mm", skin.p95_mm)?
            .set("skin_bare_share", skin.bare_share)?;
    }
    of_deposition(job, run, summary)?;
    of_support(job, run, summary)?;
    summary.set("gcode_bytes", written.bytes)?;
    Ok(())
}

/// How the nozzle is oriented, what it collides with, and what is left out for that.
fn of_orientation(
    job: &Job,
    field: &FieldRun,
    paths: &PathsRun,
    run: &MachineRun,
    summary: &mut Summary,
) -> Result<(), Failure> {
    let (resolved, times) = (&run.resolved, &run.times);
    let NozzleModel { tip_flat_mm, cone_half_angle_deg, cone_height_mm, block_diameter_mm, .. } =
        job.setup.cell.equipment().model().nozzle;
    let nozzle = [tip_flat_mm, cone_half_angle_deg, cone_height_mm, block_diameter_mm];
    summary
        .set("filled_share", run.filled_shares(field, paths)[0])?
        .set("nozzle", nozzle.map(|number| number.to_string()).join(","))?
        .set("waypoints", run.waypoints())?
        .set_seconds("orientation_s", times.orientation)?
        .set_seconds("gouging_s", times.gouging)?
        .set("raw_mean_turn_deg", run.before.mean.to_degrees())?
        .set("raw_max_turn_deg", run.before.largest.to_degrees())?
        .set("mean_turn_deg", resolved.turns.mean.to_degrees())?
        .set("max_turn_deg", resolved.turns.largest.to_degrees())?
        .set("sharpest_turn_deg_mm", resolved.turns.max_per_mm.to_degrees())?
        .set("cut_turns", resolved.cut_turns.len())?
        .set("slow_turns", resolved.sharp.len())?
        .set("turn_gaps_mm", resolved.gaps)?
        .set("gouging_before", resolved.gouging_before)?
        .set("gouging_waypoints", resolved.left.len())?
        .set("gouging_of_own_layer", resolved.left.iter().filter(|gouge| gouge.own_layer).count())?
        .set("gouging_max_depth_mm", resolved.left.iter().map(|gouge| gouge.depth).fold(0.0, f64::max))?
        .set("paths_reversed", resolved.reversed.len())?
        .set("paths_laid_first", resolved.laid_first.len())?
        .set("left_out_pieces", resolved.left_out.len())?
        .set("left_out_mm", run.lengths_mm()[1])?
        .set("max_tilt_deg", resolved.max_tilt.to_degrees())?
        .set("raised_waypoints", resolved.lifted)?
        .set("max_raise_mm", resolved.max_lift)?
        .set("extruded_mm3", run.deposition.extruded_mm3)?;
    if let Some(covered_mm3) = run.covered_mm3 {
        summary.set("covered_mm3", covered_mm3)?;
    }
    Ok(())
}

/// The filament, the time and what limits the feed, and the travels.
fn of_deposition(job: &Job, run: &MachineRun, summary: &mut Summary) -> Result<(), Failure> {
    let (deposition, times) = (&run.deposition, &run.times);
    let (grams, cost) = job.args.settings.mass_and_cost(deposition.extruded_mm3);
    let [at_flow, at_max_feed, at_min_feed, turning] = deposition.limits.shares();
    summary
        .set("filament_mm", deposition.filament_mm)?
        .set("filament_g", grams.map_or_else(|| "none".into(), Value::from))?
        .set("filament_cost", cost.map_or_else(|| "none".into(), Value::from))?
        .set("print_time_s", deposition.total_s)?
        .set("flow_limit_share", at_flow)?
        .set("max_feed_share", at_max_feed)?
        .set("min_feed_share", at_min_feed)?
        .set("turn_limit_share", turning)?
        .set("travel_mm", deposition.travel_mm)?
        .set("lifted_travels", run.travels.lifted)?
        .set("blocked_travels", run.travels.blocked.len())?
        .set("max_lift_mm", run.travels.max_lift)?
        .set_seconds("travels_s", times.travels)?
        .set("retractions", deposition.retractions)?;
    Ok(())
}

/// What is under the beads.
fn of_support(job: &Job, run: &MachineRun, summary: &mut Summary) -> Result<(), Failure> {
    summary
        .set("support_distance", job.args.support_distance_heights)?
        .set("unsupported_mm", run.support.unsupported_mm())?
        .set("unsupported_share", run.support.unsupported_share())?
        .set("unsupported_pieces", run.support.unsupported.len())?
        .set("unsupported_longest_mm", run.support.longest_mm())?
        .set("span_mm", run.support.span_mm())?
        .set("spans", run.support.spans.len())?
        .set("span_longest_mm", run.support.longest_span_mm())?
        .set_seconds("support_s", run.times.support)?;
    Ok(())
}

pub fn rows(field: &FieldRun, paths: &PathsRun, run: &MachineRun, written: &Written, table: &mut Table) {
    let (resolved, deposition, times) = (&run.resolved, &run.deposition, &run.times);
    let turns = |turns: &curvlay_toolpath::orientation::Turns| {
        format!("{:.2} degrees, at most {:.1}", turns.mean.to_degrees(), turns.largest.to_degrees())
    };
    let on = run.covered_mm3.map_or(String::new(), |covered_mm3| format!(" on {covered_mm3:.1} mm3"));
    let extruded = format!("{:.1} mm3{on}", deposition.extruded_mm3);
    table
        .row(["filled".to_owned(), filled(field, paths, run)])
        .row(["waypoints".to_owned(), run.waypoints().to_string()])
        .row(["turns, raw".to_owned(), turns(&run.before)])
        .row(["turns".to_owned(), turns(&resolved.turns)])
        .row(["gouging".to_owned(), gouging_row(resolved)])
        .row([
            "tilted".to_owned(),
            format!("{}, by at most {:.1} degrees", resolved.tilted, resolved.max_tilt.to_degrees()),
        ])
        .row(["extruded".to_owned(), extruded])
        .row(["filament".to_owned(), format!("{:.2} m", deposition.filament_mm / 1000.0)])
        .row(["print time".to_owned(), format!("{:.1} min", deposition.total_s / 60.0)])
        .row(["speed limited by".to_owned(), limits(run)])
        .row(["travels".to_owned(), travels(run)])
        .row(["unsupported".to_owned(), on_nothing(run)])
        .row(["skin".to_owned(), skin(run)])
        .row([
            "machine file".to_owned(),
            format!("{}, {:.1} MB", counted(written.lines, "line"), written.bytes as f64 / 1e6),
        ])
        .row([
            "time".to_owned(),
            format!(
                "orientation {}, of which gouging {}; travels {}",
                seconds(times.orientation),
                seconds(times.gouging),
                seconds(times.travels)
            ),
        ]);
}

/// How far the skin is from the beads, in words.
fn skin(run: &MachineRun) -> String {
    let of = |skin: ShellGap| {
        let bare = percent(skin.bare_share);
        format!("95 % within {:.3} mm of the beads, half within {:.3}; {bare} bare", skin.p95_mm, skin.p50_mm)
    };
    run.skin.map_or_else(|| "not measured: see --statistics".to_owned(), of)
}

/// Which limit of the feed holds for how much of the time of printing.
fn limits(run: &MachineRun) -> String {
    let names = ["flow", "maximum feed", "minimum feed", "turns of the nozzle"];
    let of = |(name, share): (&str, f64)| format!("{name} {}", percent(share));
    names.into_iter().zip(run.deposition.limits.shares()).map(of).collect::<Vec<_>>().join(", ")
}

fn gouging_row(resolved: &ResolvedPaths) -> String {
    let (before, after) = (resolved.gouging_before, resolved.left.len());
    let mut row = format!("{} before, {after} after", counted(before, "waypoint"));
    if !resolved.left_out.is_empty() {
        row += &format!("; pieces of paths left out: {}", resolved.left_out.len());
    }
    row
}

fn on_nothing(run: &MachineRun) -> String {
    let support = &run.support;
    format!(
        "{:.1} mm of bead, {}, in {} of at most {:.1} mm; {:.1} mm in {} of at most {:.1} mm",
        support.unsupported_mm(),
        percent(support.unsupported_share()),
        counted(support.unsupported.len(), "piece"),
        support.longest_mm(),
        support.span_mm(),
        counted(support.spans.len(), "span"),
        support.longest_span_mm()
    )
}

fn travels(run: &MachineRun) -> String {
    let travels = &run.travels;
    format!(
        "{:.1} m, {} of {} higher than the least, by at most {:.1} mm; {} blocked",
        run.deposition.travel_mm / 1000.0,
        travels.lifted,
        travels.ways.iter().filter(|way| !way.is_empty()).count(),
        travels.max_lift,
        travels.blocked.len()
    )
}

pub fn report(surfaces: &SurfacesRun, paths: &PathsRun, run: &MachineRun, report: &mut Report) {
    if let Some(picture) = pictures::unsupported(surfaces, paths, run) {
        report.heading("Unsupported beads").pictures(&borrowed(&[picture]));
    }
    let Some(printed) = run.longest() else { return };
    let turns = |path: &ToolPath| -> Vec<[f64; 2]> {
        let pairs = path.waypoints.windows(2);
        pairs.map(|pair| [pair[1].arc, pair[0].axis.angle(&pair[1].axis).to_degrees()]).collect()
    };
    let tilts = |path: &ToolPath| -> Vec<[f64; 2]> {
        path.waypoints.iter().map(|w| [w.arc, w.axis.z.clamp(-1.0, 1.0).acos().to_degrees()]).collect()
    };
    let plot = |y: &str, of: &dyn Fn(&ToolPath) -> Vec<[f64; 2]>| {
        let mut plot = Plot::new("along the path, mm", y);
        if let Some(unfiltered) = &run.unfiltered {
            plot.line("away from the closest point", pictures::PLAIN, of(unfiltered));
        }
        plot.line("as printed", pictures::EVEN, of(printed));
        plot
    };
    report
        .heading("How the nozzle stands along one path")
        .plot(&format!("layer {}, turn from waypoint to waypoint", printed.layer + 1), &plot("degrees", &turns))
        .plot(&format!("layer {}, lean from the vertical", printed.layer + 1), &plot("degrees", &tilts));
}
