//! Audit of beads: what a program lays, bead by bead in its order, whoever wrote it.

mod drawn;
mod laid;
pub mod nozzle;
mod runs;
mod shape;
mod volume;

use super::args::Args;
use super::figures::{Audited, Check, Found, Laid, Place, Verdict};
use super::part::{NO_PART, Volume};
use super::programs::Program;
use super::slip;
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::mesh::Mesh;
use curvlay_toolpath::orientation::{ToolPath, Waypoint};
use curvlay_toolpath::support::{BeadSupport, SupportOptions, check_support};
use nalgebra::Point3;
use shape::{length, section_mm2};

/// Corners of the box of the beads of the part; of all, if none is of the part. Skirts and support may reach farther on one side.
pub fn part_bounds(paths: &[ToolPath]) -> [Point3<f64>; 2] {
    match paths.iter().any(volume::is_of_part) {
        true => bounds(paths.iter().filter(|path| volume::is_of_part(path))),
        false => bounds(paths),
    }
}

/// Corners of the box of beads.
fn bounds<'a>(paths: impl IntoIterator<Item = &'a ToolPath>) -> [Point3<f64>; 2] {
    let start = [Point3::from([f64::INFINITY; 3]), Point3::from([f64::NEG_INFINITY; 3])];
    paths.into_iter().flat_map(|path| &path.waypoints).fold(start, |[low, high], at| {
        let half = nalgebra::Vector3::repeat(at.width.max(at.height));
        [low.inf(&(at.position - half)), high.sup(&(at.position + half))]
    })
}

/// Median of the heights by length.
fn median_height(paths: &[ToolPath]) -> f64 {
    let pairs = paths.iter().flat_map(|path| path.waypoints.windows(2));
    let mut all: Vec<(f64, f64)> = pairs.map(|pair| (pair[1].height, pair[1].arc - pair[0].arc)).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * all.iter().map(|(_, length)| length).sum::<f64>();
    let mut sum = 0.0;
    all.iter()
        .find(|(_, length)| {
            sum += length;
            sum >= half
        })
        .map_or(1.0, |(height, _)| *height)
}

/// Audits beads.
///
/// # Errors
/// Options that cannot be, volumes that take too much memory.
pub fn audit(program: &Program, args: &Args, part: Option<&Mesh>, bars: &Bars) -> Result<Audited, Failure> {
    let paths = &program.paths;
    let height = args.bead.height_mm.unwrap_or_else(|| median_height(paths));
    let all: f64 = paths.iter().map(length).sum();
    let mut audited = Audited { meant: program.meant.clone(), laid: Laid::Beads, ..Audited::default() };
    audited.about = about(program, args, all, height);
    audited.absent(
        Check::Shadowed,
        "beads have the direction in which they are laid: what the nozzle cuts there is gouged",
    );
    if let Some(slip) = slip::sizes("beads", height, bounds(paths), part) {
        audited.slips.push(slip);
        let why = "the sizes are not those of a print: see the finding";
        Check::ALL.into_iter().filter(|check| *check != Check::Shadowed).for_each(|check| audited.absent(check, why));
        return Ok(audited);
    }
    let rule = &args.bead;
    let options = SupportOptions {
        max_distance: rule.support_distance,
        min_drop: rule.support_drop,
        ..SupportOptions::default()
    };
    let progress = |p: curvlay_toolpath::Progress| bars.show(p.stage, p.done, p.total);
    let support = check_support(paths, height, &options, &progress)
        .map_err(|error| Failure::new(format!("{}: {error}", args.input.display())))?;
    let (laid, gouged) =
        rayon::join(|| laid::walk(paths, &support, rule), || nozzle::gouged(paths, args, !program.is_alone, bars));
    if program.is_alone {
        let why = "a layer alone: what it is laid on is not in the file";
        [Check::Unsupported, Check::InAir].into_iter().for_each(|check| audited.absent(check, why));
    } else {
        audited.set(Check::Unsupported, Verdict::Found(unsupported(paths, &support)));
    }
    let share = |amount: f64| (all > 0.0).then(|| amount / all);
    let found = |places: Vec<Place>, amount: f64, note: String| {
        Found { amount, unit: "mm", share: share(amount), note, ..Found::default() }.with_places(places)
    };
    let note = format!("neither plate nor bead within {} bead widths", rule.air_reach);
    if !program.is_alone {
        audited.set(Check::InAir, Verdict::Found(found(laid.in_air.places, laid.in_air.amount, note)));
    }
    let gouged = gouged?;
    let mut deep = found(gouged.places, gouged.amount, format!("deeper than {} of a bead's height", rule.contact));
    deep.more.push(("gouged_depth_mm", deep.places.first().map_or(0.0, |place| place.size)));
    audited.set(Check::Gouged, Verdict::Found(deep));
    let note = format!("more than {} of the section is in that of an earlier bead", rule.overlap);
    let mut twice = found(laid.twice.places, laid.twice.amount, note);
    twice.more.push(("laid_twice_mm3", laid.twice_mm3));
    audited.set(Check::LaidTwice, Verdict::Found(twice));
    coverage(paths, args, height, part, &mut audited)?;
    audited.pictures = drawn::pictures(paths, &audited);
    Ok(audited)
}

fn about(program: &Program, args: &Args, all: f64, height: f64) -> Vec<(&'static str, f64)> {
    let paths = &program.paths;
    let beads: usize = paths.iter().map(|path| path.waypoints.len() - 1).sum();
    let area = |at: &Waypoint| section_mm2(at.width, at.height);
    let pairs = || paths.iter().flat_map(|path| path.waypoints.windows(2));
    let volume: f64 = pairs().map(|pair| area(&pair[1]) * (pair[1].arc - pair[0].arc)).sum();
    let tilt = pairs().map(|pair| pair[1].axis.z.clamp(-1.0, 1.0).acos()).fold(0.0, f64::max);
    let mut about =
        vec![("beads", beads as f64), ("bead_length_mm", all), ("bead_volume_mm3", volume), ("height_mm", height)];
    about.push(("max_tilt_of_beads_deg", tilt.to_degrees()));
    about.extend(program.layers.map(|layers| ("layers", f64::from(layers))));
    about.extend(program.filament_mm.map(|filament| ("filament_mm", filament)));
    about.push(("starts", f64::from(program.starts)));
    about.push(("sharp_turns", sharp_turns(paths, args.bead.sharp_deg) as f64));
    about
}

/// Places at which a path turns by more than an angle.
fn sharp_turns(paths: &[ToolPath], angle_deg: f64) -> usize {
    let limit = angle_deg.to_radians();
    let turns = |path: &ToolPath| {
        let ways: Vec<_> = path
            .waypoints
            .windows(2)
            .filter_map(|pair| (pair[1].position - pair[0].position).try_normalize(1e-9))
            .collect();
        ways.windows(2).filter(|pair| pair[0].cross(&pair[1]).norm().atan2(pair[0].dot(&pair[1])) > limit).count()
    };
    paths.iter().map(turns).sum()
}

fn unsupported(paths: &[ToolPath], support: &BeadSupport) -> Found {
    let place = |piece: &curvlay_toolpath::support::UnsupportedPiece| Place {
        at: piece.tip,
        layer: Some(paths[piece.path].layer + 1),
        size: piece.length(),
    };
    let places = support.unsupported.iter().map(place).collect();
    let share = (support.bead_mm > 0.0).then(|| support.unsupported_share());
    let note = format!("beside {:.1} mm of spans between two held ends", support.span_mm());
    let more = vec![("spans_mm", support.span_mm()), ("longest_unsupported_mm", support.longest_mm())];
    Found { amount: support.unsupported_mm(), unit: "mm", share, more, places: Vec::new(), note }.with_places(places)
}

/// Against the part.
fn coverage(
    paths: &[ToolPath],
    args: &Args,
    height: f64,
    part: Option<&Mesh>,
    audited: &mut Audited,
) -> Result<(), Failure> {
    let Some(mesh) = part else {
        [Check::Uncovered, Check::Outside].into_iter().for_each(|check| audited.absent(check, NO_PART));
        return Ok(());
    };
    let step = args.step_mm.unwrap_or(height);
    let mut volume = Volume::of(mesh, bounds(paths), step, args.max_cells)?;
    volume::cover(&mut volume, paths, args.bead.slack);
    volume.judge(audited);
    let outside = volume::outside(&volume, paths, step);
    let all: f64 = paths.iter().filter(|path| volume::is_of_part(path)).map(length).sum();
    let (amount, share) = (outside.amount, (all > 0.0).then(|| outside.amount / all));
    let note = "no point of the part is in the bead or beside it".to_owned();
    let found = Found { amount, unit: "mm", share, note, ..Found::default() }.with_places(outside.places);
    audited.set(Check::Outside, Verdict::Found(found));
    Ok(())
}
