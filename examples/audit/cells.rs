//! Audit of an order of cells: by the audit of `curvlay_layers`, which knows nothing of how an order was made.

use super::args::Args;
use super::figures::{Audited, Check, Found, Place, Verdict};
use super::orders::CellOrder;
use super::part::{NO_PART, Volume};
use super::reach::Reach;
use super::slip;
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::count::counted;
use curvlay_examples::mesh::Mesh;
use curvlay_layers::cells::{Cells, LayerOrder};
use curvlay_layers::curved::{Fault, JudgedByNozzle, NozzleCell, NozzleRule, Platform, Rules, audit_listing};
use nalgebra::{Point3, Vector3};
use std::collections::{BTreeMap, BTreeSet};

/// An order as the audit takes it.
struct Ordered<'a> {
    order: &'a CellOrder,
    rows: Vec<u64>,
    layers: LayerOrder,
    /// The number in the file of each layer.
    numbers: Vec<u32>,
    /// Cells of the solid that no layer builds.
    missed: Vec<u32>,
    /// Whether the file lists such cells.
    lists_missed: bool,
    /// Directions that the file has.
    given: Vec<NozzleCell>,
}

/// A cell that is in the air has nothing earlier within so many cells: its own, and a bead's width.
const IN_AIR_CELLS: f64 = 2.0;

impl<'a> Ordered<'a> {
    fn new(order: &'a CellOrder) -> Self {
        let [nx, ny, nz] = order.dims.map(|side| side as usize);
        let words = nx.div_ceil(64);
        let mut rows = vec![0; words * ny * nz];
        let mut layers: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        let mut directions = BTreeMap::new();
        for entry in &order.entries {
            let [x, y, z] = entry.cell.map(|at| at as usize);
            rows[words * (y + ny * z) + x / 64] |= 1 << (x % 64);
            let id = id(order.dims, entry.cell);
            layers.entry(entry.layer).or_default().push(id);
            if let (Some(direction), true) = (entry.direction, entry.layer > 0) {
                directions.entry(id).or_insert(direction);
            }
        }
        let lists_missed = layers.contains_key(&0);
        let built: BTreeSet<u32> =
            layers.iter().filter(|(layer, _)| **layer > 0).flat_map(|(_, all)| all).copied().collect();
        let missed: BTreeSet<u32> = layers.remove(&0).unwrap_or_default().into_iter().collect();
        let missed = missed.difference(&built).copied().collect();
        let (numbers, mut ordered) = (layers.keys().copied().collect(), LayerOrder::new());
        layers.into_values().for_each(|cells| ordered.push(cells));
        let given = directions.into_iter().map(|(cell, direction)| NozzleCell { cell, direction }).collect();
        Ordered { order, rows, layers: ordered, numbers, missed, lists_missed, given }
    }

    fn place(&self, cell: u32, layer: u32, size: f64) -> Place {
        let number = (layer as usize).checked_sub(1).and_then(|at| self.numbers.get(at).copied());
        Place { at: centre(self.order, position(self.order.dims, cell)), layer: number, size }
    }
}

fn id([nx, ny, _]: [u32; 3], [x, y, z]: [u32; 3]) -> u32 {
    x + nx * (y + ny * z)
}

fn position([nx, ny, _]: [u32; 3], id: u32) -> [u32; 3] {
    [id % nx, id / nx % ny, id / nx / ny]
}

fn centre(order: &CellOrder, cell: [u32; 3]) -> Point3<f64> {
    order.origin + Vector3::from(cell.map(|at| f64::from(at) + 0.5)) * order.cell_mm
}

/// The corner of the grid across from its origin.
pub fn far(order: &CellOrder) -> Point3<f64> {
    order.origin + Vector3::from(order.dims.map(f64::from)) * order.cell_mm
}

/// The nozzle of the options.
fn rule(args: &Args) -> NozzleRule {
    let [tip_flat_mm, angle, cone_height_mm, block_mm] = args.nozzle_sizes();
    NozzleRule {
        tip_flat_mm,
        half_angle: angle.to_radians(),
        cone_height_mm,
        block_mm,
        max_tilt: args.max_tilt_deg.to_radians(),
        margin: args.clearance_cells,
    }
}

/// Audits an order.
///
/// # Errors
/// A nozzle or rules that cannot be, volumes that take too much memory.
pub fn audit(order: &CellOrder, args: &Args, part: Option<&Mesh>, bars: &Bars) -> Result<Audited, Failure> {
    let ordered = Ordered::new(order);
    let faults = Faults::find(&ordered, args, bars)?;
    let built = ordered.layers.cells().len();
    let mut audited = Audited { meant: order.meant.clone(), ..Audited::default() };
    audited.about = vec![
        ("cells", built as f64),
        ("layers", ordered.numbers.len() as f64),
        ("cell_mm", order.cell_mm),
        ("nx", f64::from(order.dims[0])),
        ("ny", f64::from(order.dims[1])),
        ("nz", f64::from(order.dims[2])),
    ];
    audited.slips.extend(slip::sizes("cells", order.cell_mm, [order.origin, far(order)], part));
    let found = |places: Vec<Place>, note: String| {
        let (amount, share) = (places.len() as f64, (built > 0).then(|| places.len() as f64 / built as f64));
        Found { amount, unit: "cells", share, note, ..Found::default() }.with_places(places)
    };
    let note = format!("the hull of what is built before holds {}", counted(faults.inside, "cell"));
    let mut shadowed = found(faults.shadowed, note);
    shadowed.more.push(("inside_hull_cells", faults.inside as f64));
    audited.set(Check::Shadowed, Verdict::Found(shadowed));
    audited.set(
        Check::Unsupported,
        Verdict::Found(found(faults.unsupported, "no earlier cell shares a face or an edge".into())),
    );
    audited.set(Check::InAir, Verdict::Found(found(faults.in_air, "no earlier cell within two cells".into())));
    if ordered.given.is_empty() {
        audited.absent(Check::Gouged, "the order says no directions of the nozzle (columns nx,ny,nz)");
    } else {
        let note = format!("of {} cells with a direction", ordered.given.len());
        audited.set(Check::Gouged, Verdict::Found(found(faults.gouged, note)));
    }
    audited.set(Check::LaidTwice, Verdict::Found(found(faults.twice, "cells that are in a layer already".into())));
    coverage(&ordered, args, part, &mut audited)?;
    audited.pictures = super::drawn_cells::pictures(order, &ordered.rows, &audited)?;
    Ok(audited)
}

/// What of the part is covered: against a mesh, else against the cells that the order lists as missed.
fn coverage(ordered: &Ordered, args: &Args, part: Option<&Mesh>, audited: &mut Audited) -> Result<(), Failure> {
    let order = ordered.order;
    let Some(mesh) = part else {
        audited.absent(Check::Outside, NO_PART);
        if ordered.lists_missed {
            let places: Vec<Place> = ordered.missed.iter().map(|&cell| ordered.place(cell, 0, 1.0)).collect();
            let all = places.len() + ordered.layers.cells().len();
            let (amount, share) = (places.len() as f64, Some(places.len() as f64 / all as f64));
            let note = "cells that the order lists as not built".to_owned();
            let found = Found { amount, unit: "cells", share, note, ..Found::default() }.with_places(places);
            audited.set(Check::Uncovered, Verdict::Found(found));
        } else {
            audited.absent(Check::Uncovered, NO_PART);
        }
        return Ok(());
    };
    let step = args.step_mm.unwrap_or(0.5 * order.cell_mm);
    let mut volume = Volume::of(mesh, [order.origin, far(order)], step, args.max_cells)?;
    for &cell in ordered.layers.cells() {
        volume.cover(grown(order, cell, 0.0));
    }
    volume.judge(audited);
    let mut places = Vec::new();
    for (layer, cells) in (1..).zip(ordered.layers.iter()) {
        // Cells of a part stick out of it.
        let is_outside = |&&cell: &&u32| !volume.has_part(grown(order, cell, step));
        places.extend(cells.iter().filter(is_outside).map(|&cell| ordered.place(cell, layer, 0.0)));
    }
    let (amount, built) = (places.len() as f64, ordered.layers.cells().len());
    let share = (built > 0).then(|| amount / built as f64);
    let note = "no point of the part is in the cell or beside it".to_owned();
    let found = Found { amount, unit: "cells", share, note, ..Found::default() }.with_places(places);
    audited.set(Check::Outside, Verdict::Found(found));
    Ok(())
}

/// A cell as a box, larger by so much to all sides.
fn grown(order: &CellOrder, cell: u32, by: f64) -> [Point3<f64>; 2] {
    let low = order.origin + Vector3::from(position(order.dims, cell).map(f64::from)) * order.cell_mm;
    [low - Vector3::repeat(by), low + Vector3::repeat(order.cell_mm + by)]
}

/// Cells with faults.
#[derive(Default)]
struct Faults {
    inside: usize,
    shadowed: Vec<Place>,
    unsupported: Vec<Place>,
    in_air: Vec<Place>,
    gouged: Vec<Place>,
    twice: Vec<Place>,
}

impl Faults {
    fn find(ordered: &Ordered, args: &Args, bars: &Bars) -> Result<Faults, Failure> {
        let order = ordered.order;
        let cells = Cells::new(order.dims, &ordered.rows)?;
        let platform = Platform::under(&cells, 0.5 * args.platform_mm / order.cell_mm)?;
        let rules =
            Rules { inside_depth_cells: args.eps_cells, boundary_is_inside: !args.beyond_eps, ..Rules::default() };
        let (rule, built) = (rule(args), (&ordered.layers, ordered.missed.as_slice()));
        let run = |with: &[NozzleCell]| {
            let judged =
                JudgedByNozzle { rule, cell_mm: order.cell_mm, steps: args.layers_as_one.unwrap_or(1), cells: with };
            let progress = |p: curvlay_layers::Progress| bars.show(p.stage, p.done, p.total);
            audit_listing(&cells, &platform, &rules, &judged, built, usize::MAX, &progress)
        };
        let first = run(&ordered.given)?;
        let mut faults = Faults::default();
        let (mut air, mut wanted) = (Vec::new(), BTreeMap::new());
        for fault in &first.faults {
            match *fault {
                Fault::Unsupported { cell, layer } => {
                    faults.unsupported.push(ordered.place(cell, layer, 0.0));
                    air.push((cell, layer));
                }
                Fault::Inside { cell, layer, depth } => {
                    faults.inside += 1;
                    wanted.insert(cell, (layer, depth));
                }
                Fault::NozzleMeets { cell, layer, .. }
                | Fault::NozzleMeetsPlate { cell, layer }
                | Fault::NozzleLeans { cell, layer } => {
                    faults.gouged.push(ordered.place(cell, layer, 0.0));
                    wanted.insert(cell, (layer, 0.0));
                }
                Fault::Repeated { cell, layer } => faults.twice.push(ordered.place(cell, layer, 0.0)),
                _ => {}
            }
        }
        let reached = reached(ordered, rule, &wanted, &air, &mut faults, bars);
        // The library has the last word on directions that were found here.
        let mut all: BTreeMap<u32, NozzleCell> = ordered.given.iter().map(|given| (given.cell, *given)).collect();
        reached.iter().for_each(|found| _ = all.insert(found.cell, *found));
        let mut open: BTreeSet<u32> = wanted.keys().copied().collect();
        reached.iter().for_each(|found| _ = open.remove(&found.cell));
        if !reached.is_empty() {
            let second = run(&all.into_values().collect::<Vec<_>>())?;
            open.extend(second.faults.iter().filter_map(|fault| match *fault {
                Fault::NozzleMeets { cell, .. }
                | Fault::NozzleMeetsPlate { cell, .. }
                | Fault::NozzleLeans { cell, .. } => Some(cell).filter(|cell| wanted.contains_key(cell)),
                _ => None,
            }));
        }
        faults.shadowed = open.iter().map(|cell| ordered.place(*cell, wanted[cell].0, wanted[cell].1)).collect();
        faults.shadowed.sort_by_key(|place| place.layer);
        Ok(faults)
    }
}

/// Goes through the layers: directions for the cells that want one, and which of the unsupported cells are in the air.
fn reached(
    ordered: &Ordered,
    rule: NozzleRule,
    wanted: &BTreeMap<u32, (u32, f64)>,
    air: &[(u32, u32)],
    faults: &mut Faults,
    bars: &Bars,
) -> Vec<NozzleCell> {
    if wanted.is_empty() && air.is_empty() {
        return Vec::new();
    }
    let dims = ordered.order.dims;
    let mut reach = Reach::new(rule, ordered.order.cell_mm, dims);
    let mut built = BTreeSet::new();
    let mut found = Vec::new();
    for (at, of_layer) in ordered.layers.iter().enumerate() {
        bars.update("reach", at as u64, ordered.layers.len() as u64);
        let layer = at as u32 + 1;
        let wants = |cell: &&u32| wanted.get(cell).is_some_and(|(wanted, _)| *wanted == layer);
        for &cell in of_layer.iter().filter(wants) {
            found.extend(reach.direction(position(dims, cell)).map(|direction| NozzleCell { cell, direction }));
        }
        for &(cell, _) in air.iter().filter(|(_, of)| *of == layer) {
            if !has_near(dims, &built, cell) {
                faults.in_air.push(ordered.place(cell, layer, 0.0));
            }
        }
        for &cell in of_layer {
            if built.insert(cell) {
                reach.add(position(dims, cell));
            }
        }
    }
    found.dedup_by_key(|found| found.cell);
    found
}

/// Whether an earlier cell is near.
fn has_near(dims: [u32; 3], built: &BTreeSet<u32>, cell: u32) -> bool {
    let at = position(dims, cell).map(i64::from);
    let reach = IN_AIR_CELLS as i64;
    let steps = || -reach..=reach;
    let mut all = steps().flat_map(|x| steps().flat_map(move |y| steps().map(move |z| [x, y, z])));
    all.any(|step| {
        let norm = step.iter().map(|k| k * k).sum::<i64>() as f64;
        let place = [0, 1, 2].map(|axis| at[axis] + step[axis]);
        let is_inside = place.iter().zip(dims).all(|(&k, side)| (0..i64::from(side)).contains(&k));
        norm <= IN_AIR_CELLS * IN_AIR_CELLS && is_inside && built.contains(&id(dims, place.map(|k| k as u32)))
    })
}
