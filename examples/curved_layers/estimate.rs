//! Whether a stage fits into memory, estimated before it begins: a part in another unit, or beads of a micrometre, ask for
//! hundreds of gigabytes.

use crate::args::failure;
use crate::paths::PathsRun;
use crate::surfaces::SurfacesRun;
use curvlay_examples::args::Failure;
use curvlay_toolpath::plan::PrintOptions;
use curvlay_toolpath::statistics::StatisticsOptions;

/// What a thing takes at the peak of its stage, in bytes, as measured and rounded up (docs/decisions/28-command-line.md): a cell of the part in an order by the
/// hull rule alone, in one that the nozzle or support completes, in a saved one, and with its share of the surfaces; a cell of the grid without surfaces and
/// with them; a point of a curve before it is simplified; a waypoint of the machine file, and one of a motion.
const HULL_CELL: f64 = 50.0;
const COMPLETE_CELL: f64 = 800.0;
const SAVED_CELL: f64 = 300.0;
const SURFACE_CELL: f64 = 3000.0;
const FIELD_GRID_CELL: f64 = 30.0;
const SURFACE_GRID_CELL: f64 = 40.0;
const CURVE_POINT: f64 = 500.0;
const WAYPOINT: f64 = 1000.0;
const MOTION_WAYPOINT: f64 = 6000.0;

/// How often a curve crosses an edge of a triangle on the length of a cell.
const CROSSINGS: f64 = 3.0;

/// Samples of a layer by area and bead: beads are up to a quarter narrower than wanted, or wider.
const SAMPLES: f64 = 1.25;

/// What is made of cells before there are paths.
#[derive(Clone, Copy, Debug)]
pub enum Made {
    /// Their order by the hull rule.
    OrderByHulls,
    /// Their order, completed by the nozzle or with support.
    CompleteOrder,
    /// Surfaces: of the layers, or to choose between two orders.
    Surfaces,
    /// Surfaces of this share of the layers of a saved order, and those near them.
    SomeSurfaces(f64),
    /// Their order, completed, and such a share of the surfaces.
    OrderAndSomeSurfaces(f64),
}

/// Memory in gigabytes that a stage may take.
#[derive(Clone, Copy, Debug)]
pub struct Memory(pub f64);

impl Memory {
    /// Refuses what does not fit; `advice` gets the share that does.
    fn holds(self, bytes: f64, of: &str, advice: impl FnOnce(f64) -> String) -> Result<(), Failure> {
        let (needed, Memory(most)) = (bytes / 1e9, self);
        if needed <= most {
            return Ok(());
        }
        let advice = advice(most / needed);
        Err(failure(format!(
            "{of} take some {needed:.1} GB, more than the {most} GB of --max-memory: {advice}, or check --unit and --scale"
        )))
    }

    /// The cells of a part, and what is made of them first.
    pub fn holds_cells(self, dims: [u32; 3], cells: usize, made: Made) -> Result<(), Failure> {
        let grid = dims.iter().map(|&side| f64::from(side)).product::<f64>();
        let (of_part, of_grid) = match made {
            Made::OrderByHulls => (HULL_CELL, FIELD_GRID_CELL),
            Made::CompleteOrder => (COMPLETE_CELL, FIELD_GRID_CELL),
            Made::Surfaces => (SURFACE_CELL, SURFACE_GRID_CELL),
            Made::SomeSurfaces(share) => ((SAVED_CELL + share * SURFACE_CELL).min(SURFACE_CELL), SURFACE_GRID_CELL),
            Made::OrderAndSomeSurfaces(share) => {
                ((COMPLETE_CELL + share * SURFACE_CELL).min(SURFACE_CELL), SURFACE_GRID_CELL)
            }
        };
        let bytes = of_part * cells as f64 + of_grid * grid;
        let advice = |share: f64| format!("--voxels {:.0} would fit", (cells as f64 * share).floor());
        self.holds(bytes, &format!("{cells} cells in a grid of {grid:.0}"), advice)
    }

    /// Curves on the surfaces, and the samples of the largest one, by which coverage is measured.
    pub fn holds_paths(self, bead_mm: f64, cell_mm: f64, surfaces: &SurfacesRun) -> Result<(), Failure> {
        let points = CROSSINGS * surfaces.spacing.area_mm2 / bead_mm / cell_mm;
        let advice = |share: f64| format!("--bead {:.3} would fit", bead_mm / share);
        self.holds(CURVE_POINT * points, &format!("curves of {points:.0} points"), advice)?;
        let StatisticsOptions { samples_per_width, max_samples, .. } = StatisticsOptions::default();
        let largest = surfaces.sheets.iter().map(|sheet| sheet.area()).fold(0.0, f64::max);
        let (samples, most) = (SAMPLES * largest * (samples_per_width / bead_mm).powi(2), max_samples as f64);
        if samples <= most {
            return Ok(());
        }
        let fits = bead_mm * (samples / most).sqrt();
        Err(failure(format!(
            "a layer of {largest:.1} mm2 takes {samples:.0} samples for beads of {bead_mm} mm, more than {most}: --bead \
             {fits:.3} would fit, or check --unit and --scale"
        )))
    }

    /// Waypoints along the curves.
    pub fn holds_waypoints(self, options: &PrintOptions, is_for_robot: bool, paths: &PathsRun) -> Result<(), Failure> {
        let points = paths.totals.path_mm / options.orient.step;
        let advice = |share: f64| format!("--bead {:.3} would fit", paths.bead_mm / share);
        let each = if is_for_robot { MOTION_WAYPOINT } else { WAYPOINT };
        self.holds(each * points, &format!("paths of {points:.0} waypoints"), advice)
    }
}
