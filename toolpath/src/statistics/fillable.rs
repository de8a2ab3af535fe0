//! What no bead can cover: the part of the surface outside of every disc of the least width that has room on it.
//!
//! A bead is a union of discs, none narrower than the least width. So without reaching over the boundary beads cover at
//! most the *opening* of the surface by such a disc (Serra, "Image Analysis and Mathematical Morphology", 1982, chapter
//! II): the union of all discs of at least that width that the boundary does not cut. On the raster, walks from the
//! boundary measure how far from it samples are; the discs around those that are just far enough, up to the boundary, show
//! what can be covered. Farther in each sample is in a disc of its own.
//!
//! The beads that were laid have no part in it.

use super::error::StatisticsError;
use super::gap::rim;
use super::raster::Raster;
use super::walk::{Image, Visit, Walker, to_segment};
use nalgebra::Vector2;
use std::ops::ControlFlow;

/// Centres lie between the samples. So samples count that are this much nearer to the boundary, in steps.
const SLACK: f64 = 0.25;
/// Discs matter up to this much farther from the boundary than the least, in steps: what is in a disc farther in is in
/// one of these too.
const NEXT: f64 = 1.5;

/// For each sample whether no disc with room on the surface covers it that has at least a radius.
pub(super) fn out_of_reach(
    raster: &Raster,
    walker: &mut Walker,
    [radius, step]: [f64; 2],
    tick: &mut dyn FnMut(usize, usize) -> ControlFlow<()>,
) -> Result<Vec<bool>, StatisticsError> {
    let [least, most] = [radius - SLACK * step, radius + NEXT * step];
    let rims = rim(raster);
    let mut near = Near { raster, most, distance: vec![f64::INFINITY; raster.samples()] };
    for (done, piece) in rims.iter().enumerate() {
        if tick(done, rims.len()).is_break() {
            return Err(StatisticsError::Cancelled);
        }
        walker.walk(Image { triangle: piece.triangle, ends: piece.ends }, &mut near);
    }
    let distance = near.distance;
    let triangles = raster.sheet.flats.len() as u32;
    let mut open = Open { waiting: Vec::with_capacity(triangles as usize), radius: 0.0 };
    for triangle in 0..triangles {
        let waits = raster.of_triangle(triangle).filter(|&(sample, _)| distance[sample] < least);
        open.waiting.push(waits.collect());
    }
    for triangle in 0..triangles {
        if tick(triangle as usize, triangles as usize).is_break() {
            return Err(StatisticsError::Cancelled);
        }
        for (sample, place) in raster.of_triangle(triangle) {
            if (least..most).contains(&distance[sample]) {
                open.radius = distance[sample];
                walker.walk(Image { triangle, ends: [place; 2] }, &mut open);
            }
        }
    }
    let mut out = vec![false; raster.samples()];
    open.waiting.iter().flatten().for_each(|&(sample, _)| out[sample] = true);
    Ok(out)
}

/// Walks from the boundary.
struct Near<'r, 's> {
    raster: &'r Raster<'s>,
    most: f64,
    distance: Vec<f64>,
}

impl Visit for Near<'_, '_> {
    fn reach(&self) -> f64 {
        self.most
    }

    fn crosses(&mut self, _: f64, _: Option<u32>) -> bool {
        true
    }

    fn enter(&mut self, image: &Image) {
        for (sample, place) in self.raster.of_triangle(image.triangle) {
            let known = &mut self.distance[sample];
            *known = known.min(to_segment(place, image.ends[0], image.ends[1]));
        }
    }
}

/// Samples of each triangle that no disc has covered yet; and a disc.
struct Open {
    waiting: Vec<Vec<(usize, Vector2<f64>)>>,
    radius: f64,
}

impl Visit for Open {
    fn reach(&self) -> f64 {
        self.radius
    }

    fn crosses(&mut self, _: f64, _: Option<u32>) -> bool {
        true
    }

    fn enter(&mut self, image: &Image) {
        let [centre, _] = image.ends;
        let radius = self.radius;
        self.waiting[image.triangle as usize].retain(|(_, place)| (place - centre).norm() > radius);
    }
}
