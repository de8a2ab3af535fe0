//! Each patch against what is laid before it.

use super::super::args::{Args, LayerSide};
use super::patches::{Balls, Patch};
use super::stack::Stack;
use curvlay_examples::laid::Nozzle;
use rayon::prelude::*;

/// What is known of the bead of which nothing is said: it is so many heights wide.
const WIDE: f64 = 2.0;

/// What was found at a patch.
#[derive(Clone, Copy, Debug, Default)]
pub struct Judged {
    /// Nothing near enough carries it.
    pub is_unsupported: bool,
    /// Nothing at all is near it.
    pub is_in_air: bool,
    /// How deep the nozzle is; 0 where it leans too far only.
    pub depth: Option<f64>,
    /// How much of a height lies in an earlier layer, as a share, where that is too much.
    pub twice: Option<f64>,
}

/// The rules, in millimetres.
pub struct Judge<'a> {
    stack: &'a Stack,
    balls: Balls<'a>,
    nozzle: &'a Nozzle,
    height: f64,
    /// How far the middle of a layer may be from what carries it, and how much lower that is at least.
    support: [f64; 2],
    air: f64,
    contact: f64,
    /// Nearer layers are laid twice.
    thin: f64,
    /// Cosine of the greatest lean.
    upright: f64,
    /// The middle of a layer is so far below its surface.
    core: f64,
}

impl<'a> Judge<'a> {
    /// Those of the options.
    pub fn new(stack: &'a Stack, patches: &'a [Patch], nozzle: &'a Nozzle, args: &Args, height: f64) -> Self {
        let rule = &args.bead;
        Judge {
            stack,
            balls: Balls::new(patches),
            nozzle,
            height,
            support: [rule.support_distance * height, rule.support_drop * height],
            air: rule.air_reach * rule.width_mm.unwrap_or(WIDE * height),
            contact: rule.contact * height,
            thin: (1.0 - rule.overlap) * height,
            upright: args.max_tilt_deg.to_radians().cos(),
            core: if args.sheet.side == LayerSide::Top { 0.5 * height } else { 0.0 },
        }
    }

    /// All patches.
    pub fn all(&self, patches: &[Patch]) -> Vec<Judged> {
        patches.par_iter().map(|patch| self.one(patch)).collect()
    }

    fn one(&self, patch: &Patch) -> Judged {
        let pose = patch.pose();
        let sunk = -self.nozzle.lowest(&pose);
        let in_plate = Some(sunk).filter(|depth| *depth > self.contact);
        let in_layers = self.balls.depth(self.nozzle, pose, patch.rank, self.contact);
        let leans = (patch.normal.z < self.upright - ROUNDING).then_some(0.0);
        let depth = [in_plate, in_layers, leans].into_iter().flatten().reduce(f64::max);
        if patch.is_support {
            return Judged { depth, ..Judged::default() };
        }
        let is_unsupported = !self.is_supported(patch);
        let is_in_air = is_unsupported && self.is_in_air(patch);
        Judged { is_unsupported, is_in_air, depth, twice: self.twice(patch) }
    }

    fn is_supported(&self, patch: &Patch) -> bool {
        let [reach, drop] = self.support;
        let at = patch.middle();
        let is_lower = |point: &nalgebra::Point3<f64>| (at - point).dot(&patch.normal) >= drop;
        at.z - self.core <= reach || self.stack.nearest(at, 0..patch.rank, reach, is_lower).is_some()
    }

    fn is_in_air(&self, patch: &Patch) -> bool {
        let at = patch.middle();
        at.z - self.core > self.air && self.stack.nearest(at, 0..patch.rank, self.air, |_| true).is_none()
    }

    /// Along the normal to both sides: what lies beside a layer is not in it.
    fn twice(&self, patch: &Patch) -> Option<f64> {
        let to = |way| self.stack.along(patch.middle(), way, 0..patch.rank, self.thin);
        let nearest = [to(-patch.normal), to(patch.normal)].into_iter().flatten().reduce(f64::min)?;
        Some(1.0 - nearest / self.height)
    }
}

/// Rounding of cosines.
const ROUNDING: f64 = 1e-9;
