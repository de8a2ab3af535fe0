//! Spill: how much of the beads lies past the boundary.
//!
//! From the curve, rays run over the surface to both sides, half the width long. What is left of a ray at the boundary
//! is spilled. Along a straight piece rays stand a step apart and count their length; around turns and ends they fan out
//! and count sectors, and what a turn covers twice on its inside is taken off. Each bead is counted by itself, so where
//! two beads spill over the same place both do.

use super::curve::{Fan, Piece};
use super::sheet::Sheet;
use nalgebra::Vector2;

/// Angle between the rays of a fan, at most: 64 around a circle.
const FAN: f64 = std::f64::consts::PI / 32.0;

/// A ray crosses each triangle once; around a vertex rounding could turn it in circles. More triangles than this within
/// half a width count as not leaving the surface.
const MAX_TRIANGLES: usize = 10_000;

/// The length of a ray up to the boundary, at most `length`.
fn ray(sheet: &Sheet, mut triangle: u32, mut from: Vector2<f64>, mut direction: Vector2<f64>, length: f64) -> f64 {
    let mut gone = 0.0;
    let mut entry = 3;
    for _ in 0..MAX_TRIANGLES {
        let at = &sheet.flats[triangle as usize].at;
        let mut out: Option<(f64, usize)> = None;
        for k in (0..3).filter(|&k| k != entry) {
            let edge = at[(k + 1) % 3] - at[k];
            let outwards = direction.perp(&edge); // above zero where the ray goes to the right of the edge
            if outwards > 0.0 {
                let t = ((at[k] - from).perp(&edge) / outwards).max(0.0);
                if out.is_none_or(|(best, _)| t < best) {
                    out = Some((t, k));
                }
            }
        }
        let Some((t, k)) = out else { return length };
        if gone + t >= length {
            return length;
        }
        gone += t;
        let Some(across) = &sheet.across[triangle as usize][k] else { return gone };
        from = across.point(from + direction * t);
        direction = across.direction(direction);
        (triangle, entry) = (across.triangle, across.edge as usize);
    }
    length
}

/// Area past the boundary on both sides of a piece.
pub(super) fn beside(sheet: &Sheet, piece: &Piece, step: f64) -> f64 {
    let [p, q] = piece.ends;
    let length = (q - p).norm();
    let Some(unit) = (q - p).try_normalize(0.0) else { return 0.0 };
    let normal = Vector2::new(-unit.y, unit.x);
    let rays = (length / step).ceil().max(1.0) as usize;
    let mut area = 0.0;
    for k in 0..rays {
        let t = (k as f64 + 0.5) / rays as f64;
        let radius = piece.radii[0] + (piece.radii[1] - piece.radii[0]) * t;
        for direction in [normal, -normal] {
            area += radius - ray(sheet, piece.triangle, p + (q - p) * t, direction, radius);
        }
    }
    area * length / rays as f64
}

/// Area past the boundary in a fan; less what a turn has twice.
pub(super) fn around(sheet: &Sheet, fan: &Fan) -> f64 {
    let rays = (fan.sweep / FAN).ceil().max(1.0) as usize;
    let mut area = 0.0;
    for k in 0..rays {
        let (sin, cos) = (fan.sweep * (k as f64 + 0.5) / rays as f64).sin_cos();
        let direction = fan.first * cos + Vector2::new(-fan.first.y, fan.first.x) * sin;
        let sector = |d: Vector2<f64>| {
            let inside = ray(sheet, fan.triangle, fan.centre, d, fan.radius);
            (fan.radius * fan.radius - inside * inside) / 2.0
        };
        area += sector(direction);
        if fan.is_turn {
            area -= sector(-direction);
        }
    }
    area * fan.sweep / rays as f64
}
