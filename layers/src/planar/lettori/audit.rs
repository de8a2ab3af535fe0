//! An audit of parts: they are the solid, they do not overlap, and each layer lies on the one below.
//!
//! It shares no code with the decomposition: no sections, polygons or cells, only lines through triangles. Along a grid of
//! lines the pieces of the solid and those of the parts must agree; and across each layer, on a grid, every point must have something
//! below it within the reach of the overhang angle: of the same part, or of one that is printed before.

use super::{VolumeOptions, VolumePart};
use crate::planar::Solid;
use nalgebra::{Point3, Vector3};

/// How closely is looked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AuditOptions {
    /// Lines along each side of the solid for union and overlap (default 60).
    pub lines: usize,
    /// Most points across a side of a part for support; fewer if a quarter of a layer's height is wider (default 160).
    pub points: usize,
    /// Share of the length of the lines on which parts may be missing or doubled (default 1e-6: rounding).
    pub allowed_share: f64,
}

impl Default for AuditOptions {
    fn default() -> Self {
        AuditOptions { lines: 60, points: 160, allowed_share: 1e-6 }
    }
}

/// What an audit found.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeAudit {
    /// How far the volumes of the parts are off that of the solid, as a share of it.
    pub volume_error: f64,
    /// Share of the solid, along the lines, that no part has.
    pub missing_share: f64,
    /// Share of the solid, along the lines, where a part is that should not be: outside the solid, or inside another part.
    pub doubled_share: f64,
    /// For each part the area of its layers under which nothing is within reach.
    pub unsupported_mm2: Vec<f64>,
    /// Whether all is well.
    pub is_ok: bool,
}

/// Volumes add up to this share, whatever the number of parts.
const VOLUME: f64 = 1e-9;

/// Crossings of a bundle of parallel lines with a mesh.
struct Lines {
    direction: Vector3<f64>,
    u: Vector3<f64>,
    v: Vector3<f64>,
    low: [f64; 2],
    step: f64,
    counts: [usize; 2],
}

impl Lines {
    /// Lines across the box of `solids`, off the lattice that vertices like to lie on.
    fn new(direction: Vector3<f64>, solids: &[&Solid], step: impl Fn(f64) -> f64) -> Self {
        let least = direction.iamin();
        let mut axis = Vector3::zeros();
        axis[least] = 1.0;
        let u = direction.cross(&axis).normalize();
        let v = direction.cross(&u);
        let range = |along: &Vector3<f64>| {
            solids
                .iter()
                .flat_map(|solid| solid.vertices())
                .map(|p| p.coords.dot(along))
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)])
        };
        let [a, b] = [range(&u), range(&v)];
        let step = step((a[1] - a[0]).max(b[1] - b[0]));
        let count = |[low, high]: [f64; 2]| (((high - low) / step).ceil() as usize).max(1) + 1;
        // Parts of a step that are no simple fraction.
        Lines {
            direction,
            u,
            v,
            low: [a[0] - 0.4142 * step, b[0] - 0.2718 * step],
            step,
            counts: [count(a) + 1, count(b) + 1],
        }
    }

    /// The heights at which each line passes through the mesh, from below.
    fn crossings(&self, solid: &Solid) -> Vec<Vec<f64>> {
        let mut all = vec![Vec::new(); self.counts[0] * self.counts[1]];
        let flat: Vec<[f64; 3]> = solid
            .vertices()
            .iter()
            .map(|p| [p.coords.dot(&self.u), p.coords.dot(&self.v), p.coords.dot(&self.direction)])
            .collect();
        for corners in solid.triangles() {
            let p = corners.map(|c| flat[c as usize]);
            let range = |axis: usize| {
                let low = p.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min);
                let high = p.iter().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max);
                let first = ((low - self.low[axis]) / self.step).ceil().max(0.0) as usize;
                let last = ((high - self.low[axis]) / self.step).floor().max(-1.0) + 1.0;
                first..(last as usize).min(self.counts[axis])
            };
            for j in range(1) {
                for i in range(0) {
                    let at = [self.low[0] + i as f64 * self.step, self.low[1] + j as f64 * self.step];
                    // The same number, but for the sign, from both faces of an edge: a line passes one of them.
                    let side = |a: u32, b: u32| {
                        let (from, to) = if a < b { (a, b) } else { (b, a) };
                        let [f, t] = [flat[from as usize], flat[to as usize]];
                        let cross = (t[0] - f[0]) * (at[1] - f[1]) - (t[1] - f[1]) * (at[0] - f[0]);
                        if a < b { cross } else { -cross }
                    };
                    let [a, b, c] = *corners;
                    let w = [side(b, c), side(c, a), side(a, b)];
                    if w.iter().all(|&w| w > 0.0) || w.iter().all(|&w| w < 0.0) {
                        let sum: f64 = w.iter().sum();
                        let height = (w[0] * p[0][2] + w[1] * p[1][2] + w[2] * p[2][2]) / sum;
                        all[j * self.counts[0] + i].push(height);
                    }
                }
            }
        }
        all.iter_mut().for_each(|heights| heights.sort_by(f64::total_cmp));
        all
    }
}

/// Whether a height is inside: an odd number of crossings is below it.
fn is_inside(crossings: &[f64], height: f64) -> bool {
    crossings.partition_point(|&crossing| crossing <= height) % 2 == 1
}

/// Audits parts of a solid, in the order in which they are printed.
///
/// # Arguments
/// * `options`: those of the decomposition; its angle and tolerance hold here as well. Heights of layers are those of the parts.
///
/// # Cost
/// `O(lines^2)` columns and `O(layers * points^2)` samples for each part.
///
/// # Example
/// ```
/// use curvlay_layers::nalgebra::Vector3;
/// use curvlay_layers::planar::{AuditOptions, Solid, VolumeOptions, VolumePart, audit_volumes};
/// let corners = [[0.0, 0.0, 0.0], [60.0, 0.0, 0.0], [0.0, 60.0, 0.0], [0.0, 0.0, 60.0]].map(Into::into);
/// let solid = Solid::new(&corners, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])?;
/// let (direction, layer_tops_mm) = (Vector3::z(), (1..=20).map(|k| 3.0 * f64::from(k)).collect());
/// let part = VolumePart { solid: solid.clone(), direction, base_mm: 0.0, separation: None, layer_tops_mm, overhang_mm3: 0.0 };
/// let audit = |parts: &[VolumePart]| audit_volumes(&solid, parts, &VolumeOptions::default(), &AuditOptions::default());
/// assert!(audit(&[part.clone()]).is_ok);
/// assert!(!audit(&[part.clone(), part]).is_ok); // twice is once too often
/// # Ok::<(), curvlay_layers::planar::SolidError>(())
/// ```
pub fn audit_volumes(
    solid: &Solid,
    parts: &[VolumePart],
    options: &VolumeOptions,
    audit: &AuditOptions,
) -> VolumeAudit {
    let sum: f64 = parts.iter().map(|part| volume(&part.solid)).sum();
    let whole = volume(solid);
    let volume_error = (sum - whole).abs() / whole;
    let [missing_share, doubled_share] = coverage(solid, parts, audit);
    let unsupported_mm2: Vec<f64> = (0..parts.len()).map(|k| unsupported(parts, k, options, audit)).collect();
    let is_ok = volume_error <= VOLUME
        && missing_share <= audit.allowed_share
        && doubled_share <= audit.allowed_share
        && unsupported_mm2.iter().all(|&area| area <= 0.0);
    VolumeAudit { volume_error, missing_share, doubled_share, unsupported_mm2, is_ok }
}

/// The volume under the triangles, above the plane z = 0.
fn volume(solid: &Solid) -> f64 {
    let prism = |corners: &[u32; 3]| {
        let [a, b, c]: [Point3<f64>; 3] = corners.map(|v| solid.vertices()[v as usize]);
        let flat = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        flat / 2.0 * (a.z + b.z + c.z) / 3.0
    };
    solid.triangles().iter().map(prism).sum()
}

/// Shares of the solid's length on lines that are missing, and that are doubled or outside.
fn coverage(solid: &Solid, parts: &[VolumePart], audit: &AuditOptions) -> [f64; 2] {
    // A direction that no face of a part is likely to lie along.
    let direction = Vector3::new(0.0173, 0.0291, 1.0).normalize();
    let lines = Lines::new(direction, &[solid], |side| side / audit.lines.max(1) as f64);
    let of_solid = lines.crossings(solid);
    let of_parts: Vec<Vec<Vec<f64>>> = parts.iter().map(|part| lines.crossings(&part.solid)).collect();
    let [mut length, mut missing, mut doubled] = [0.0; 3];
    for (line, own) in of_solid.iter().enumerate() {
        let mut heights = own.clone();
        of_parts.iter().for_each(|part| heights.extend(&part[line]));
        heights.sort_by(f64::total_cmp);
        for pair in heights.windows(2) {
            let (middle, long) = ((pair[0] + pair[1]) / 2.0, pair[1] - pair[0]);
            let inside = is_inside(own, middle);
            let count = of_parts.iter().filter(|part| is_inside(&part[line], middle)).count();
            let wanted = usize::from(inside);
            length += if inside { long } else { 0.0 };
            missing += if count < wanted { long } else { 0.0 };
            doubled += if count > wanted { long } else { 0.0 };
        }
    }
    [missing, doubled].map(|share| if length > 0.0 { share / length } else { 1.0 })
}

/// Area of the layers of a part, in squares of the grid, with nothing below in reach.
fn unsupported(parts: &[VolumePart], k: usize, options: &VolumeOptions, audit: &AuditOptions) -> f64 {
    let part = &parts[k];
    if part.layer_tops_mm.is_empty() {
        return 0.0;
    }
    let least = layers(part).map(|[low, high]| high - low).fold(f64::INFINITY, f64::min);
    let lines = Lines::new(part.direction, &[&part.solid], |side| (least / 4.0).max(side / audit.points.max(1) as f64));
    let own = lines.crossings(&part.solid);
    let before: Vec<Vec<Vec<f64>>> = parts[..k].iter().map(|earlier| lines.crossings(&earlier.solid)).collect();
    let is_there = |line: usize, height: f64| {
        is_inside(&own[line], height) || before.iter().any(|earlier| is_inside(&earlier[line], height))
    };
    let mut unsupported = 0;
    let mut below: Option<f64> = None;
    for [low, high] in layers(part) {
        let middle = (low + high) / 2.0;
        let height = high - low;
        // The first layer lies on the plate, or on what stands half a layer behind the base.
        let (under, distance) = match below {
            Some(under) => (under, middle - under),
            None => (part.base_mm - height / 2.0, height),
        };
        let on_plate = below.is_none() && part.separation.is_none();
        below = Some(middle);
        if on_plate {
            continue;
        }
        // Between the lines may be what they miss: a step of the grid is allowed for it.
        let reach = distance / options.angle.tan() + options.tolerance_mm + lines.step;
        let around = (reach / lines.step).floor() as isize;
        let [nx, ny] = lines.counts.map(|count| count as isize);
        for j in 0..ny {
            for i in 0..nx {
                let at = |i: isize, j: isize| (j * nx + i) as usize;
                if !is_inside(&own[at(i, j)], middle) || is_there(at(i, j), under) {
                    continue;
                }
                let carried = (-around..=around).any(|dj| {
                    (-around..=around).any(|di| {
                        let far = ((di * di + dj * dj) as f64).sqrt() * lines.step;
                        let inside = (0..nx).contains(&(i + di)) && (0..ny).contains(&(j + dj));
                        far <= reach && inside && is_there(at(i + di, j + dj), under)
                    })
                });
                unsupported += usize::from(!carried);
            }
        }
    }
    unsupported as f64 * lines.step * lines.step
}

/// Bottom and top of each layer.
fn layers(part: &VolumePart) -> impl Iterator<Item = [f64; 2]> + '_ {
    let bottoms = std::iter::once(part.base_mm).chain(part.layer_tops_mm.iter().copied());
    bottoms.zip(&part.layer_tops_mm).map(|(low, &high)| [low, high])
}
