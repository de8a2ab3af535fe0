//! The largest disc that no bead touches.
//!
//! Its centre is the bare sample farthest from all beads and from the boundary. From each piece of bead, and from each
//! edge of the boundary, a walk goes through triangles as long as it brings bare samples nearer to something.

use super::curve::Piece;
use super::error::StatisticsError;
use super::figures::Gap;
use super::raster::{Arc, Raster};
use super::walk::{Image, Visit, Walker};
use nalgebra::Point3;
use std::ops::ControlFlow;

/// Bare samples, by triangle, and how far each is from what is known so far.
struct Bare<'r, 's> {
    raster: &'r Raster<'s>,
    /// Bare samples of triangle `t`: `first[t]..first[t + 1]`.
    first: Vec<u32>,
    samples: Vec<(nalgebra::Vector2<f64>, f64)>,
    /// The largest distance in each triangle; negative where all is covered.
    worst: Vec<f64>,
}

struct Approach<'b, 'r, 's> {
    bare: &'b mut Bare<'r, 's>,
    piece: &'b Piece,
    radius: f64,
}

impl Visit for Approach<'_, '_, '_> {
    fn reach(&self) -> f64 {
        f64::INFINITY
    }

    fn crosses(&mut self, distance: f64, to: Option<u32>) -> bool {
        // Within the bead the way is free: what is bare may begin behind it.
        to.is_some_and(|t| distance <= self.radius || self.bare.worst[t as usize] > distance - self.radius)
    }

    fn enter(&mut self, image: &Image) {
        let t = image.triangle as usize;
        if self.bare.worst[t] < 0.0 {
            return;
        }
        let arc = Arc::new(self.piece, image.ends);
        let mut worst = 0.0f64;
        for (place, distance) in &mut self.bare.samples[self.bare.first[t] as usize..self.bare.first[t + 1] as usize] {
            *distance = distance.min(arc.clearance(*place).max(0.0));
            worst = worst.max(*distance);
        }
        self.bare.worst[t] = worst;
    }
}

/// Sources are taken in strides, so that the first ones soon bring bounds to everywhere.
fn strided(count: usize) -> impl Iterator<Item = usize> {
    let stride = ((count as f64).sqrt() as usize).max(1);
    (0..stride).flat_map(move |from| (from..count).step_by(stride))
}

/// The largest gap; `None` where all samples are covered.
pub(super) fn largest(
    raster: &Raster,
    walker: &mut Walker,
    pieces: &[Piece],
    tick: &mut dyn FnMut(usize, usize) -> ControlFlow<()>,
) -> Result<Option<Gap>, StatisticsError> {
    let sheet = raster.sheet;
    let mut bare = Bare { raster, first: vec![0], samples: Vec::new(), worst: Vec::new() };
    for t in 0..sheet.flats.len() as u32 {
        let open = bare.raster.of_triangle(t).filter(|&(sample, _)| raster.is_bare(sample));
        bare.samples.extend(open.map(|(_, place)| (place, f64::INFINITY)));
        let some = bare.samples.len() as u32 > bare.first[t as usize];
        bare.worst.push(if some { f64::INFINITY } else { -1.0 });
        bare.first.push(bare.samples.len() as u32);
    }
    if bare.samples.is_empty() {
        return Ok(None);
    }
    let rims: Vec<Piece> = rim(raster);
    let all: Vec<&Piece> = rims.iter().chain(pieces).collect();
    for (done, k) in strided(all.len()).enumerate() {
        if tick(done, all.len()).is_break() {
            return Err(StatisticsError::Cancelled);
        }
        let piece = all[k];
        let radius = piece.radii[0].max(piece.radii[1]);
        walker.walk(
            Image { triangle: piece.triangle, ends: piece.ends },
            &mut Approach { bare: &mut bare, piece, radius },
        );
    }
    let mut best: Option<(f64, usize, usize)> = None;
    for t in 0..sheet.flats.len() {
        for k in bare.first[t] as usize..bare.first[t + 1] as usize {
            let distance = bare.samples[k].1;
            if best.is_none_or(|b| distance > b.0) {
                best = Some((distance, t, k));
            }
        }
    }
    Ok(best.map(|(radius_mm, t, k)| {
        let at = Point3::from(raster.place(t as u32, bare.samples[k].0));
        Gap { radius_mm, at }
    }))
}

/// The boundary as beads without width.
pub(super) fn rim(raster: &Raster) -> Vec<Piece> {
    let sheet = raster.sheet;
    let mut rims = Vec::new();
    for (t, across) in sheet.across.iter().enumerate() {
        for k in (0..3).filter(|&k| across[k].is_none()) {
            let at = &sheet.flats[t].at;
            rims.push(Piece {
                curve: 0,
                triangle: t as u32,
                weights: [[0; 3]; 2],
                ends: [at[k], at[(k + 1) % 3]],
                radii: [0.0; 2],
                along: [0.0; 2],
            });
        }
    }
    rims
}
