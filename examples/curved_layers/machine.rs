//! Stage `gcode`: waypoints along the paths, a nozzle that gouges nothing, and what it lays down how fast.

use crate::args::Args;
use crate::field::FieldRun;
use crate::paths::PathsRun;
use crate::surfaces::SurfacesRun;
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::clock::StageClock;
use curvlay_examples::mesh::Mesh;
use curvlay_toolpath::deposit::Deposition;
use curvlay_toolpath::gcode::{Move, marked_moves};
use curvlay_toolpath::gouging::{Nozzle, ResolvedPaths};
use curvlay_toolpath::layer::LayerStack;
use curvlay_toolpath::orientation::{OrientOptions, ToolPath, Turns};
use curvlay_toolpath::plan::PrintPlan;
use curvlay_toolpath::shell::{ShellGap, ShellOptions, shell_gap};
use curvlay_toolpath::support::{BeadSupport, check_support, check_support_on_mould};
use curvlay_toolpath::travel::Travels;
use nalgebra::{Point3, Vector3};
use std::f64::consts::PI;
use std::time::Duration;

/// What came of the stage.
pub struct MachineRun {
    /// Turns between neighbours when every nozzle points away from the closest point below.
    pub before: Turns,
    /// The paths with the directions that they are printed with.
    pub resolved: ResolvedPaths,
    /// How the nozzle gets from path to path.
    pub travels: Travels,
    pub deposition: Deposition,
    /// Diameter of the flat tip of the nozzle.
    pub tip_mm: f64,
    /// The maximum print speed that was asked for, in millimetres a second.
    pub max_feed: f64,
    /// Unsupported beads.
    pub support: BeadSupport,
    /// Area that beads cover by the thickness of the layer there, if that is measured.
    pub covered_mm3: Option<f64>,
    /// How far the skin of the part is from its beads, if that is measured.
    pub skin: Option<ShellGap>,
    /// The longest path as the closest points have it, unfiltered, to compare with.
    pub unfiltered: Option<ToolPath>,
    pub times: Times,
}

/// How long the steps took, on the clock.
#[derive(Clone, Copy, Default)]
pub struct Times {
    /// Waypoints and their directions, gouging included.
    pub orientation: Duration,
    pub gouging: Duration,
    pub travels: Duration,
    pub support: Duration,
}

impl MachineRun {
    pub fn waypoints(&self) -> usize {
        self.resolved.paths.iter().map(|path| path.waypoints.len()).sum()
    }

    /// Measures how far the skin of the part is from its beads.
    pub fn measure_skin(&mut self, mesh: &Mesh, shift: Vector3<f64>, bars: &Bars) -> Result<(), Failure> {
        let vertices: Vec<Point3<f64>> = mesh.vertices.iter().map(|vertex| vertex + shift).collect();
        let progress = |p: curvlay_toolpath::Progress| bars.show(p.stage, p.done, p.total);
        let options = ShellOptions::default();
        self.skin = Some(shell_gap(&self.resolved.paths, &vertices, &mesh.triangles, &options, &progress)?);
        Ok(())
    }

    /// The moves of the machine file, with marks of layers and beads among them.
    pub fn moves(&self) -> impl Iterator<Item = Move> {
        marked_moves(&self.deposition.moves, &self.resolved.paths)
    }

    /// Length of the paths, and of what is left out because the nozzle would run into what is built, or turn too sharply.
    pub fn lengths_mm(&self) -> [f64; 2] {
        let left_out = self.resolved.left_out.iter().map(|piece| piece.arcs[1] - piece.arcs[0]);
        [self.deposition.bead_mm, left_out.fold(self.resolved.gaps, |sum, length| sum + length)]
    }

    /// Share of the waypoints at which the nozzle collides.
    pub fn gouging_share(&self) -> f64 {
        share(self.resolved.left.len() as f64, self.waypoints() as f64)
    }

    /// Share of the length of the paths that is left out.
    pub fn left_out_share(&self) -> f64 {
        let [laid, left_out] = self.lengths_mm();
        share(left_out, laid + left_out)
    }

    /// What is laid as a share of what there is to lay: the part and its support, without what sparse infill leaves empty; and of that without missed
    /// cells.
    pub fn filled_shares(&self, field: &FieldRun, paths: &PathsRun) -> [f64; 2] {
        let to_lay = to_lay_mm3(field, paths);
        [to_lay, to_lay - field.missed_mm3].map(|mm3| self.deposition.extruded_mm3 / mm3)
    }

    /// How far what is laid is off what there is to lay, as a share: the larger of both.
    pub fn volume_off(&self, field: &FieldRun, paths: &PathsRun) -> f64 {
        self.filled_shares(field, paths).into_iter().map(|share| (share - 1.0).abs()).fold(0.0, f64::max)
    }

    /// The path with the most waypoints.
    pub fn longest(&self) -> Option<&ToolPath> {
        longest(&self.resolved.paths)
    }
}

fn longest(paths: &[ToolPath]) -> Option<&ToolPath> {
    paths.iter().max_by_key(|path| path.waypoints.len())
}

/// Volume of the part and its support, without what sparse infill leaves empty.
pub fn to_lay_mm3(field: &FieldRun, paths: &PathsRun) -> f64 {
    field.part_mm3 + field.support_mm3() - paths.hollow_mm3()
}

/// A share of nothing is nothing.
fn share(of: f64, all: f64) -> f64 {
    if of > 0.0 { of / all } else { 0.0 }
}

/// Orients, frees and deposits; to compare with, the directions of the longest path without any filter.
pub fn run(
    nozzle: &Nozzle,
    args: &Args,
    field: &FieldRun,
    surfaces: &SurfacesRun,
    paths: &PathsRun,
    bars: &Bars,
) -> Result<MachineRun, Failure> {
    let clock = StageClock::default();
    let progress = |p: curvlay_toolpath::Progress| {
        clock.note(p.stage, p.done);
        bars.show(p.stage, p.done, p.total)
    };
    clock.note("orient", 0);
    let layers = surfaces.surfaces();
    let (options, support) = (args.print_options(), args.support_options());
    let stack = paths.stack(&layers, field.mould.as_ref(), surfaces.height_mm)?.with_hints(surfaces.hints()?);
    let PrintPlan { before, resolved, travels, deposition } = stack.plan(nozzle, &options, &progress)?;
    clock.stop();
    let unfiltered = args.compare.then(|| unfiltered(&stack, &resolved.paths, &options.orient, bars)).transpose()?;
    // It takes as much memory as all waypoints, and so does the check of support.
    drop(stack);
    clock.note("support", 0);
    let (laid, height_mm) = (&resolved.paths, surfaces.height_mm);
    let support = match &field.mould {
        Some(mould) => check_support_on_mould(laid, &mould.surface(height_mm), height_mm, &support, &progress)?,
        None => check_support(laid, height_mm, &support, &progress)?,
    };
    clock.stop();
    let gouging = clock.on_the_clock(&["gouging", "built"]);
    let orientation = gouging + clock.on_the_clock(&["orient", "share"]);
    let times = Times {
        orientation,
        gouging,
        travels: clock.on_the_clock(&["travel"]),
        support: clock.on_the_clock(&["support"]),
    };
    let covered_mm3 = args.has_statistics().then(|| paths.filled.covered_mm3(&layers));
    let (tip_mm, max_feed) = (2.0 * nozzle.tip_radius(), options.deposition.max_feed);
    Ok(MachineRun {
        before,
        resolved,
        travels,
        deposition,
        tip_mm,
        max_feed,
        support,
        covered_mm3,
        skin: None,
        unfiltered: unfiltered.flatten(),
        times,
    })
}

/// The longest path with directions as they are found.
fn unfiltered(
    stack: &LayerStack,
    paths: &[ToolPath],
    options: &OrientOptions,
    bars: &Bars,
) -> Result<Option<ToolPath>, Failure> {
    let Some(longest) = longest(paths) else { return Ok(None) };
    let options = OrientOptions { wave: 0.0, max_turn: PI, low_pass_rounds: 0, ..*options };
    let unfiltered = stack.orient(&options, &|p| bars.show(p.stage, p.done, p.total))?;
    // Paths may have been cut.
    let of_curve = |other: &ToolPath| (other.layer, other.curve) == (longest.layer, longest.curve);
    Ok(unfiltered.paths.into_iter().find(of_curve))
}
