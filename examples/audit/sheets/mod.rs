//! Audit of layer meshes: surfaces, one or several a layer, that a nozzle follows along their normals. In patches, each against what is laid before it.

mod boxes;
mod drawn;
mod files;
mod judge;
mod patches;
mod regions;
mod sheet;
mod slabs;
mod stack;
mod turned;
mod volume;

use super::args::Args;
use super::beads::nozzle;
use super::figures::{Audited, Check, Found, Laid, Verdict};
use super::part::{NO_PART, Volume};
use super::slip;
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::count::counted;
use curvlay_examples::findings::{Finding, Severity};
use curvlay_examples::mesh::Mesh;
pub use files::{has_layers, is_mesh};
use judge::{Judge, Judged};
use nalgebra::Point3;
use patches::Patch;
use regions::Regions;
pub use sheet::{Sheets, read};
use slabs::Heights;
use stack::Stack;
use turned::Turned;

/// Edges of patches are no longer than so many layer heights: balls in their middles, as thick as the layer, then leave no gaps.
const EDGE_HEIGHTS: f64 = 2.0;

/// Corners of the box of the layers of the part; of all, if all are support.
pub fn part_bounds(sheets: &Sheets) -> [Point3<f64>; 2] {
    let is_support = sheets.sheets.iter().all(|sheet| sheet.is_support);
    let start = [Point3::from([f64::INFINITY; 3]), Point3::from([f64::NEG_INFINITY; 3])];
    let of_part = sheets.sheets.iter().filter(|sheet| sheet.is_support == is_support);
    of_part.flat_map(|sheet| &sheet.vertices).fold(start, |[low, high], at| [low.inf(at), high.sup(at)])
}

/// Audits layers.
///
/// # Errors
/// Options that cannot be, layers of which no height is known, patches or volumes that take too much memory.
pub fn audit(mut sheets: Sheets, args: &Args, part: Option<&Mesh>, bars: &Bars) -> Result<Audited, Failure> {
    let side = args.sheet.side;
    bars.update("surfaces", 0, 3);
    let stack = Stack::new(&sheets.sheets);
    let turned = turned::turn(&mut sheets.sheets, &stack, slabs::from_plate(side), args.bead.height_mm);
    let height = turned.height.ok_or_else(|| {
        let input = args.input.display();
        Failure::new(format!("{input}: no layer lies above another or above the plate: give --layer-height"))
    })?;
    let mut audited = Audited { meant: sheets.meant.clone(), laid: Laid::Layers, ..Audited::default() };
    audited.notes = notes(&mut sheets, &turned, height);
    audited.absent(
        Check::Shadowed,
        "layers have the direction in which they are laid, their normal: what the nozzle cuts there is gouged",
    );
    if let Some(slip) = slip::sizes("layers", height, part_bounds(&sheets), part) {
        audited.slips.push(slip);
        let why = "the sizes are not those of a print: see the finding";
        Check::ALL.into_iter().filter(|check| *check != Check::Shadowed).for_each(|check| audited.absent(check, why));
        return Ok(audited);
    }
    bars.update("surfaces", 1, 3);
    let edge = args.sheet.patch_mm.unwrap_or(EDGE_HEIGHTS * height);
    let mut patches = patches::cut(&sheets.sheets, edge, args.max_cells)?;
    if patches.is_empty() {
        return Err(Failure::new(format!("{}: no triangle of the layers has an area", args.input.display())));
    }
    let reach = args.bead.support_distance;
    let gaps = slabs::set(&mut patches, &stack, side, height, reach);
    bars.update("surfaces", 2, 3);
    audited.about = about(&sheets, &patches, &slabs::heights(&patches, &gaps, height, reach), &turned);
    bars.update("nozzle", 0, 1);
    let nozzle = nozzle::nozzle(args)?;
    let judged = Judge::new(&stack, &patches, &nozzle, args, height).all(&patches);
    verdicts(&patches, &judged, args, height, &mut audited);
    coverage((&patches, part_bounds(&sheets)), args, height, part, &mut audited)?;
    let slab = slabs::nominal(side, height);
    audited.pictures = drawn::pictures(&sheets.sheets, sheets.layers, slab, &audited);
    Ok(audited)
}

/// What was decided, and what is odd.
fn notes(sheets: &mut Sheets, turned: &Turned, height: f64) -> Vec<Finding> {
    let mut notes = std::mem::take(&mut sheets.notes);
    if turned.layers > 0 {
        let what = "layers whose triangles look down, or at what was laid before, were turned over";
        notes.push(Finding::new(Severity::Note, what, format!("{} of {}", turned.layers, sheets.layers), ""));
    }
    if turned.triangles > 0 {
        let what = "triangles that look another way than their neighbours were turned";
        notes.push(Finding::new(Severity::Warning, what, counted(turned.triangles, "triangle"), ""));
    }
    if turned.closed > 0 {
        let what = "surfaces have no border: a body, such as the part, is no layer";
        notes.push(Finding::new(Severity::Warning, what, format!("{} of {}", turned.closed, sheets.sheets.len()), ""));
    }
    let [low, _] = part_bounds(sheets);
    let lowest = sheets.sheets.iter().flat_map(|sheet| &sheet.vertices).map(|at| at.z).fold(low.z, f64::min);
    if !(-height..=FAR_HEIGHTS * height).contains(&lowest) {
        let what = "the lowest place of all layers is not on the plate, the plane z = 0";
        let mut finding = Finding::new(Severity::Warning, what, format!("z = {lowest:.2} mm"), "");
        finding.try_to("--plate with the height of the plate, --up with the axis that points up");
        notes.push(finding);
    }
    notes
}

/// The lowest place of all layers is no farther from the plate, in heights.
const FAR_HEIGHTS: f64 = 1.5;

/// The share of the area that leans no more than the greatest tilt: what leans more are slivers.
const STEEPEST: f64 = 0.999;

fn about(sheets: &Sheets, patches: &[Patch], heights: &Heights, turned: &Turned) -> Vec<(&'static str, f64)> {
    let of_part = || patches.iter().filter(|patch| !patch.is_support);
    let area = |of: &Patch| of.area;
    let tilts: Vec<(f64, f64)> =
        patches.iter().map(|patch| (patch.normal.z.clamp(-1.0, 1.0).acos().to_degrees(), patch.area)).collect();
    let [steep, steepest] = slabs::percentiles(tilts, [0.95, STEEPEST]).unwrap_or_default();
    let support: f64 = patches.iter().filter(|patch| patch.is_support).map(area).sum();
    let mut about = vec![
        ("layers", f64::from(sheets.layers)),
        ("layer_area_mm2", of_part().map(area).sum()),
        ("layer_volume_mm3", of_part().map(|patch| patch.area * patch.thickness()).sum()),
    ];
    about.extend((support > 0.0).then_some(("support_area_mm2", support)));
    about.extend([
        ("height_mm", heights.height),
        ("height_p05_mm", heights.percentiles[0]),
        ("height_median_mm", heights.percentiles[1]),
        ("height_p95_mm", heights.percentiles[2]),
        ("tilt_p95_deg", steep),
        ("max_tilt_of_layers_deg", steepest),
        ("pieces", turned.pieces as f64),
        ("most_pieces", turned.most_pieces as f64),
        ("turned_layers", turned.layers as f64),
        ("patches", patches.len() as f64),
    ]);
    about
}

/// What was found patch by patch.
fn verdicts(patches: &[Patch], judged: &[Judged], args: &Args, height: f64, audited: &mut Audited) {
    let rule = &args.bead;
    let all: f64 = patches.iter().map(|patch| patch.area).sum();
    let of_part: f64 = patches.iter().filter(|patch| !patch.is_support).map(|patch| patch.area).sum();
    let pairs = || patches.iter().zip(judged);
    let area = |patch: &Patch, is_wrong: bool| is_wrong.then_some(patch.area);
    let unsupported = Regions::of(pairs().map(|(patch, of)| (patch, area(patch, of.is_unsupported))), true);
    let note = format!("no earlier layer and no plate within {} heights", rule.support_distance);
    audited.set(Check::Unsupported, Verdict::Found(found(unsupported, of_part, note)));
    let in_air = Regions::of(pairs().map(|(patch, of)| (patch, area(patch, of.is_in_air))), true);
    let note = format!("neither plate nor layer within {} bead widths", rule.air_reach);
    audited.set(Check::InAir, Verdict::Found(found(in_air, of_part, note)));
    let gouged = Regions::of(pairs().map(|(patch, of)| (patch, of.depth)), false);
    let note = format!("deeper than {} of a height, or leaning more than {} degrees", rule.contact, args.max_tilt_deg);
    let mut deep = found(gouged, all, note);
    deep.more.push(("gouged_depth_mm", deep.places.first().map_or(0.0, |place| place.size)));
    audited.set(Check::Gouged, Verdict::Found(deep));
    let twice = Regions::of(pairs().map(|(patch, of)| (patch, area(patch, of.twice.is_some()))), true);
    let mut twice = found(twice, of_part, format!("more than {} of a height is in an earlier layer", rule.overlap));
    let volume = pairs().map(|(patch, of)| of.twice.unwrap_or(0.0) * height * patch.area).sum();
    twice.more.push(("laid_twice_mm3", volume));
    audited.set(Check::LaidTwice, Verdict::Found(twice));
}

fn found(regions: Regions, of: f64, note: String) -> Found {
    let (amount, share) = (regions.area, (of > 0.0).then(|| regions.area / of));
    Found { amount, unit: "mm2", share, note, ..Found::default() }.with_places(regions.places())
}

/// Against the part; `bounds` are those of the layers.
fn coverage(
    (patches, bounds): (&[Patch], [Point3<f64>; 2]),
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
    let mut volume = Volume::of(mesh, bounds, step, args.max_cells)?;
    volume::cover(&mut volume, patches, args.bead.slack * height);
    volume.judge(audited);
    let area = |patch: &Patch| volume::is_outside(&volume, patch, step).then_some(patch.area);
    let outside = Regions::of(patches.iter().map(|patch| (patch, area(patch))), true);
    let of_part = patches.iter().filter(|patch| !patch.is_support).map(|patch| patch.area).sum();
    let note = "no point of the part is in the layer or beside it".to_owned();
    audited.set(Check::Outside, Verdict::Found(found(outside, of_part, note)));
    Ok(())
}
