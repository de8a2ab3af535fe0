//! Where the head of a printer is in what stands, by points: the part of the audit that looks at collisions.
//!
//! Tips stand over the layers of each part, along the outlines of the sections and on a grid inside them; what stands is points on the faces
//! of earlier parts and of the platform. Nothing here is shared with the search, which compares maps of heights.

use super::audited::AuditedPart;
use super::head::Head;
use crate::planar::{CutPlane, PlaneFrame, Region, slice};
use nalgebra::{Point2, Point3, Vector3};
use std::collections::HashMap;

/// Distance of points on faces and of tips, in mm.
const STEP: f64 = 1.0;

/// Tips on the grid inside a section are so many times as far apart.
const INNER: f64 = 3.0;

/// Most points along the longest side of a part; larger ones have points farther apart.
const MAX_POINTS: f64 = 150.0;

/// How deep the head may be in what stands, in layers: what a tool path may gouge as well.
const ALLOWED: f64 = 0.25;

/// How many tips of each part have the head in what stands, and how deep the deepest is, in mm.
pub(super) fn contacts(parts: &[AuditedPart], head: &Head) -> (Vec<usize>, f64) {
    let Some(first) = parts.first() else { return (Vec::new(), 0.0) };
    let box_of = parts.iter().map(|part| part.solid.bounds()).reduce(|a, b| [a[0].inf(&b[0]), a[1].sup(&b[1])]);
    let [low, high] = box_of.unwrap_or([Point3::origin(); 2]);
    let step = STEP.max((high - low).max() / MAX_POINTS);
    let mut standing = platform(first, low + (high - low) / 2.0, head, step);
    pedestal(first, head, step, &mut standing);
    let (mut counts, mut deepest) = (Vec::new(), 0.0f64);
    for part in parts {
        let depths = depths(part, &standing, head, step);
        counts.push(depths.len());
        deepest = depths.into_iter().fold(deepest, f64::max);
        for triangle in 0..part.solid.triangles().len() {
            sampled(part.solid.corners(triangle), step, &mut standing);
        }
    }
    (counts, deepest)
}

/// Points of the platform around the middle of the solid's box.
fn platform(first: &AuditedPart, middle: Point3<f64>, head: &Head, step: f64) -> Vec<Point3<f64>> {
    let n = first.direction;
    let [foot, _] = first.solid.extent(&n);
    let centre = middle + n * (foot - head.pedestal - middle.coords.dot(&n));
    let u = if n.x.abs() < 0.6 { n.cross(&Vector3::x()) } else { n.cross(&Vector3::y()) }.normalize();
    let v = n.cross(&u);
    let count = (head.platform_radius / step) as i32;
    let rows = (-count..=count).flat_map(|i| (-count..=count).map(move |j| (f64::from(i) * step, f64::from(j) * step)));
    let within = rows.filter(|(x, y)| x.hypot(*y) <= head.platform_radius && head.platform_radius > 0.0);
    within.map(|(x, y)| centre + u * x + v * y).collect()
}

/// Points on the sides of the pedestal: below the outlines of the first layer of the first part.
fn pedestal(first: &AuditedPart, head: &Head, step: f64, points: &mut Vec<Point3<f64>>) {
    let n = first.direction;
    let [foot, high] = first.solid.extent(&n);
    let Ok(lowest) = CutPlane::through(&Point3::from(n * foot), &n) else { return };
    if head.pedestal <= 0.0 {
        return;
    }
    let frame = PlaneFrame::of(&lowest);
    let middle = lowest.moved(0.5 * head.layer.min(high - foot));
    let levels = (head.pedestal / step).ceil() as usize;
    for [a, b] in Region::of(&slice(first.solid, &middle, &frame)).edges() {
        let count = ((b - a).norm() / step).ceil().max(1.0) as usize;
        for k in 0..count {
            let at = frame.place(&(a + (b - a) * (k as f64 / count as f64)));
            points.extend((0..=levels).map(|level| at - n * (head.pedestal * level as f64 / levels as f64)));
        }
    }
}

/// Points on a triangle, corners and edges included, at most a step apart.
fn sampled([a, b, c]: [Point3<f64>; 3], step: f64, points: &mut Vec<Point3<f64>>) {
    let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
    let count = (longest / step).ceil().max(1.0) as usize;
    for i in 0..=count {
        for j in 0..=count - i {
            let (s, t) = (i as f64 / count as f64, j as f64 / count as f64);
            points.push(a + (b - a) * s + (c - a) * t);
        }
    }
}

/// How deep the head is in what stands, at each tip where it is deeper than it may be.
fn depths(part: &AuditedPart, standing: &[Point3<f64>], head: &Head, step: f64) -> Vec<f64> {
    let [low, high] = part.solid.extent(&part.direction);
    let Ok(lowest) = CutPlane::through(&Point3::from(part.direction * low), &part.direction) else { return Vec::new() };
    let frame = PlaneFrame::of(&lowest);
    // What stands higher than the lowest tip, by squares as wide as the head.
    let widest = head.radius(f64::INFINITY).max(step);
    let square = |p: &Point2<f64>| [p.x, p.y].map(|c| (c / widest).floor() as i64);
    let mut squares: HashMap<[i64; 2], Vec<(Point2<f64>, f64)>> = HashMap::new();
    for p in standing {
        let height = p.coords.dot(&part.direction);
        if height > low + head.layer {
            let flat = frame.flat(p);
            squares.entry(square(&flat)).or_default().push((flat, height));
        }
    }
    let mut depths = Vec::new();
    if squares.is_empty() {
        return depths;
    }
    let every = step.max(head.layer);
    let layers = ((high - low) / every).ceil().max(1.0) as usize;
    for layer in 0..layers {
        let up = ((layer as f64 + 0.5) * every).min((high - low) * 0.999_999);
        let region = Region::of(&slice(part.solid, &lowest.moved(up), &frame));
        let tip = low + up + head.layer;
        for at in tips(&region, step) {
            let [x, y] = square(&at);
            let around = (x - 1..=x + 1).flat_map(|x| (y - 1..=y + 1).map(move |y| [x, y]));
            let near = around.filter_map(|square| squares.get(&square)).flatten();
            let depth = |(p, height): &(Point2<f64>, f64)| {
                let over = height - tip;
                if over > 0.0 { over.min(head.radius(over) - (p - at).norm()) } else { 0.0 }
            };
            let deepest = near.map(depth).fold(0.0, f64::max);
            if deepest > ALLOWED * head.layer {
                depths.push(deepest);
            }
        }
    }
    depths
}

/// Along the outlines of a section, and on a grid inside.
fn tips(region: &Region, step: f64) -> Vec<Point2<f64>> {
    let mut tips = Vec::new();
    for [a, b] in region.edges() {
        let count = ((b - a).norm() / step).ceil().max(1.0) as usize;
        tips.extend((0..count).map(|k| a + (b - a) * (k as f64 / count as f64)));
    }
    let Some([low, high]) = region.bounds() else { return tips };
    let spacing = INNER * step;
    let count = |axis: usize| ((high[axis] - low[axis]) / spacing) as usize + 1;
    for i in 0..count(0) {
        for j in 0..count(1) {
            let p = low + nalgebra::Vector2::new(i as f64 + 0.5, j as f64 + 0.5) * spacing;
            if region.contains(&p) {
                tips.push(p);
            }
        }
    }
    tips
}
