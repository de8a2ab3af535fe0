//! Moves become paths of beads: where they begin, which layer they are of, how wide and high they are.

use super::program::{Given, Program};
use curvlay_toolpath::orientation::{ToolPath, Waypoint};
use curvlay_toolpath::path::BeadKind;
use nalgebra::{Point3, UnitVector3, Vector3};
use std::f64::consts::PI;

/// Heights of tips that differ by less are one: digits of files, in millimetres.
const SAME_Z_MM: f64 = 1e-3;
/// A nozzle that leans by less stands upright: the sine of the angle.
const UPRIGHT: f64 = 1e-3;
/// Most waypoints of a program: some hundred bytes each.
const MAX_WAYPOINTS: usize = 20_000_000;

/// What comments say of the beads that follow.
#[derive(Clone, Copy, Debug, Default)]
pub struct Said {
    /// Width, or 0.
    pub width_mm: f64,
    /// Height, or 0.
    pub height_mm: f64,
    /// What they are for.
    pub kind: BeadKind,
    /// The layer from 0, where layers are marked.
    pub layer: Option<u32>,
}

/// A straight move that lays a bead.
#[derive(Clone, Copy, Debug)]
pub struct Laid {
    /// Its ends.
    pub tips: [Point3<f64>; 2],
    /// Directions of the nozzle there.
    pub axes: [UnitVector3<f64>; 2],
    /// Filament for it, in millimetres; none where beads have given sizes.
    pub filament_mm: Option<f64>,
}

/// Paths so far.
pub struct Builder {
    given: Given,
    filament_mm2: f64,
    program: Program,
    is_open: bool,
    /// Distinct heights of tips of upright beads, rising.
    heights: Vec<f64>,
    /// The layer by height, where none are marked.
    layer: Option<(u32, f64)>,
    has_tilted: bool,
    waypoints: usize,
    filament_sum: f64,
}

impl Builder {
    /// Nothing is laid.
    pub fn new(given: Given, filament_diameter_mm: f64) -> Self {
        Builder {
            given,
            filament_mm2: 0.25 * PI * filament_diameter_mm * filament_diameter_mm,
            program: Program::default(),
            is_open: false,
            heights: Vec::new(),
            layer: None,
            has_tilted: false,
            waypoints: 0,
            filament_sum: 0.0,
        }
    }

    /// The path ends: a travel.
    pub fn end(&mut self) {
        self.is_open = false;
    }

    /// A bead.
    ///
    /// # Errors
    /// Sizes that cannot be had, too many beads.
    pub fn lay(&mut self, laid: &Laid, said: &Said) -> Result<(), String> {
        let [from, to] = laid.tips;
        let length = (to - from).norm();
        let is_upright = laid.axes.iter().all(|axis| axis.x.hypot(axis.y) <= UPRIGHT && axis.z > 0.0);
        let step = is_upright.then(|| self.step(to.z));
        let [width, height] = self.size(laid, said, length, step)?;
        let layer = said.layer.unwrap_or_else(|| self.layer_of(is_upright.then_some(to.z), height));
        self.has_tilted |= !is_upright;
        self.filament_sum += laid.filament_mm.unwrap_or(0.0);
        self.waypoints += 1;
        if self.waypoints > MAX_WAYPOINTS {
            return Err(format!("more than {MAX_WAYPOINTS} beads are not audited: cut the program into parts"));
        }
        let at = |k: usize, arc: f64| Waypoint {
            position: laid.tips[k],
            axis: laid.axes[k],
            width,
            height,
            arc,
            added: false,
            lift: Vector3::zeros(),
            kind: said.kind,
        };
        let open = self.program.paths.last_mut().filter(|path| self.is_open && path.layer == layer);
        if let Some(path) = open {
            let arc = path.waypoints.last().map_or(0.0, |last| last.arc);
            path.waypoints.push(at(1, arc + length));
        } else {
            self.program.starts += u32::from(!self.is_open);
            let curve = self.program.starts - 1;
            let waypoints = vec![at(0, 0.0), at(1, length)];
            self.program.paths.push(ToolPath { layer, curve, closed: false, waypoints });
        }
        self.is_open = true;
        Ok(())
    }

    /// Width and height: what comments say, then options, then the step of the heights, then a square; what is left is by the volume of a bead with round rims.
    fn size(&self, laid: &Laid, said: &Said, length: f64, step: Option<f64>) -> Result<[f64; 2], String> {
        let Given { width_mm, height_mm, .. } = self.given;
        let is_said = |size: f64| Some(size).filter(|size| *size > 0.0);
        let area = laid.filament_mm.map(|filament| filament * self.filament_mm2 / length);
        let height = is_said(said.height_mm).or(height_mm).or(step).or(area.map(f64::sqrt));
        let width = is_said(said.width_mm).or(width_mm);
        let Some(height) = height else {
            return Err("the height of beads is not known: give --layer-height".to_owned());
        };
        let by_volume = || {
            area.map(|area| {
                if area > 0.25 * PI * height * height {
                    area / height + height * (1.0 - 0.25 * PI)
                } else {
                    area / height
                }
            })
        };
        let Some(width) = width.or_else(by_volume) else {
            return Err("the width of beads is not known: give --bead".to_owned());
        };
        Ok([width, height])
    }

    /// How far the next lower tip of upright beads is below a height; the plate, if there is none.
    fn step(&mut self, z: f64) -> f64 {
        let at = self.heights.partition_point(|known| *known < z - SAME_Z_MM);
        if self.heights.get(at).is_none_or(|known| *known > z + SAME_Z_MM) {
            self.heights.insert(at, z);
        }
        let below = at.checked_sub(1).map_or(0.0, |below| self.heights[below]);
        (z - below).max(SAME_Z_MM)
    }

    /// Layers by height: another one begins where the tip has left it by a quarter of a bead. Tilted beads have a layer for each path.
    fn layer_of(&mut self, z: Option<f64>, height: f64) -> u32 {
        let starts = self.program.starts;
        let Some(z) = z else { return if self.is_open { starts.saturating_sub(1) } else { starts } };
        let next = match self.layer {
            Some((layer, at)) if (z - at).abs() <= 0.25 * height => (layer, at),
            Some((layer, _)) => (layer + 1, z),
            None => (0, z),
        };
        self.layer = Some(next);
        next.0
    }

    /// All of it.
    pub fn finish(self, meant: String, marked: bool, has_filament: bool) -> Program {
        let mut program = self.program;
        let mut layers: Vec<u32> = program.paths.iter().map(|path| path.layer).collect();
        layers.sort_unstable();
        layers.dedup();
        program.layers = (marked || !self.has_tilted).then_some(layers.len() as u32);
        program.filament_mm = has_filament.then_some(self.filament_sum);
        program.meant = meant;
        program
    }
}
