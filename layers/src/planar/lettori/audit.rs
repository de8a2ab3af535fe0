//! An audit of parts: they are the solid, they do not overlap, all of each is in its layers, each layer lies on the one below, and where the
//! torch is blocked.
//!
//! It shares no code with the decomposition: no slicing, booleans or cells, only lines through triangles and through the outlines of the layers
//! that are printed. Along a grid of lines the pieces of the solid and those of the parts must agree. What of a part is behind its base plane
//! or above its last layer is in no layer; its volume is that of the clipped triangles, exact but for rounding. Across each layer, on a
//! grid, every point of its section must have something below it within the reach of the overhang angle, of the same part or of one that is
//! printed before, and the section must be that of the part's mesh, but for features that are left out.
//!
//! The torch is a cone from what it lays to its mouth, and from there on a cylinder without end; the plate has no edge.

use super::{VolumeLayer, VolumeOptions, VolumePart};
use crate::planar::{PlaneFrame, Region, Solid};
use nalgebra::{Point3, Vector3};

/// How closely is looked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AuditOptions {
    /// Lines along each side of the solid for union and overlap (default 60).
    pub lines: usize,
    /// Most points across a side of a part for support; fewer if a quarter of a layer's height is wider (default 160).
    pub points: usize,
    /// Most points across a side of a part, with the torch around it, for the torch (default 80).
    pub torch_points: usize,
    /// Share of the solid that may be in no part, in two parts, or in no layer (default 1e-6: rounding).
    pub allowed_share: f64,
    /// Share of the area of a part's layers by which printed sections may differ from those of its mesh where no features are left
    /// out (default 1e-3: points of the grid that lie on an outline).
    pub allowed_section_share: f64,
}

impl Default for AuditOptions {
    fn default() -> Self {
        AuditOptions { lines: 60, points: 160, torch_points: 80, allowed_share: 1e-6, allowed_section_share: 1e-3 }
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
    /// What was found of each part.
    pub parts: Vec<PartAudit>,
    /// Whether all is well. Where the torch is blocked is for the caller to judge.
    pub is_ok: bool,
}

/// What an audit found of a part.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PartAudit {
    /// Volume of the part between its base plane and the top of its last layer. With `unlayered_mm3` it is the volume of the part.
    pub layered_mm3: f64,
    /// Volume of the part behind its base plane or above its last layer: in no layer.
    pub unlayered_mm3: f64,
    /// Volume of the printed sections, each times the height of its layer: `layered_mm3` but for the rounding to layers.
    pub sections_mm3: f64,
    /// Volume of places thinner than a layer that no section is near.
    pub thin_mm3: f64,
    /// Volume of what sections leave out of the part's mesh: features, or an error.
    pub left_out_mm3: f64,
    /// Volume of what sections add to it.
    pub added_mm3: f64,
    /// Area of its layers.
    pub layers_mm2: f64,
    /// Area of its layers under which nothing is within reach.
    pub unsupported_mm2: f64,
    /// Area of its layers that the torch cannot lay, since it would be in a part that is printed before, or in the plate.
    pub blocked_mm2: f64,
}

impl VolumeAudit {
    /// The sum of a figure over all parts.
    pub fn sum(&self, of: impl Fn(&PartAudit) -> f64) -> f64 {
        self.parts.iter().map(of).fold(0.0, |sum, figure| sum + figure)
    }
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
    /// Lines across the box of a solid and a margin around it, off the lattice that vertices like to lie on.
    fn new(direction: Vector3<f64>, solid: &Solid, margin: f64, step: impl Fn(f64) -> f64) -> Self {
        let least = direction.iamin();
        let mut axis = Vector3::zeros();
        axis[least] = 1.0;
        let u = direction.cross(&axis).normalize();
        let v = direction.cross(&u);
        let range = |along: &Vector3<f64>| {
            let at = solid.vertices().iter().map(|p| p.coords.dot(along));
            let [low, high] =
                at.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)]);
            [low - margin, high + margin]
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

    /// Which lines pass through a section: those with an odd number of its edges on one side, in their row.
    fn inside(&self, section: &Region, frame: &PlaneFrame) -> Vec<bool> {
        let [nx, ny] = self.counts;
        let mut crossed: Vec<Vec<f64>> = vec![Vec::new(); ny];
        for edge in section.edges() {
            let [[x0, y0], [x1, y1]] = edge.map(|p| {
                let at = (frame.origin + frame.u * p.x + frame.v * p.y).coords;
                [(at.dot(&self.u) - self.low[0]) / self.step, (at.dot(&self.v) - self.low[1]) / self.step]
            });
            // Half-open, so that a row through a corner meets one of its edges.
            let [first, last] = [y0.min(y1).ceil().max(0.0) as usize, (y0.max(y1).ceil().max(0.0) as usize).min(ny)];
            for (row, crossed) in crossed.iter_mut().enumerate().take(last).skip(first) {
                crossed.push(x0 + (x1 - x0) * (row as f64 - y0) / (y1 - y0));
            }
        }
        let mut inside = vec![false; nx * ny];
        for (row, mut crossed) in crossed.into_iter().enumerate() {
            crossed.sort_by(f64::total_cmp);
            for pair in crossed.chunks_exact(2) {
                let [first, last] = [pair[0], pair[1]].map(|x| (x.ceil().max(0.0) as usize).min(nx));
                inside[row * nx + first..row * nx + last].fill(true);
            }
        }
        inside
    }

    /// Whether something holds on a line within reach of another one.
    fn within(&self, line: usize, reach: f64, holds: impl Fn(usize) -> bool) -> bool {
        let around = (reach / self.step).floor() as usize;
        let [nx, ny] = self.counts;
        let [i, j] = [line % nx, line / nx];
        let rows = j.saturating_sub(around)..(j + around + 1).min(ny);
        rows.into_iter().any(|y| {
            (i.saturating_sub(around)..(i + around + 1).min(nx)).any(|x| {
                let far = (x.abs_diff(i) as f64).hypot(y.abs_diff(j) as f64) * self.step;
                far <= reach && holds(y * nx + x)
            })
        })
    }
}

/// Whether a height is inside: an odd number of crossings is below it.
fn is_inside(crossings: &[f64], height: f64) -> bool {
    crossings.partition_point(|&crossing| crossing <= height) % 2 == 1
}

/// Audits parts of a solid, in the order in which they are printed.
///
/// # Arguments
/// * `parts`: with their layers; those without a separation stand on the plate, which lies across the direction of the first one.
/// * `options`: those of the decomposition; its angle, tolerance and torch hold here as well.
///
/// # Cost
/// `O(lines^2)` columns and `O(layers * points^2)` samples for each part, and for the torch the square of its diameter, in points, for
/// each of `torch_points^2` columns.
///
/// # Example
/// ```
/// use curvlay_layers::nalgebra::Vector3;
/// use curvlay_layers::planar::{AuditOptions, Solid, VolumeOptions, VolumePart, audit_volumes};
/// let corners = [[0.0, 0.0, 0.0], [60.0, 0.0, 0.0], [0.0, 60.0, 0.0], [0.0, 0.0, 60.0]].map(Into::into);
/// let solid = Solid::new(&corners, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])?;
/// let tops: Vec<f64> = (1..=20).map(|k| 3.0 * f64::from(k)).collect();
/// let part = |tops: &[f64]| VolumePart::sliced(solid.clone(), &Vector3::z(), 0.0, tops);
/// let audit = |parts: &[VolumePart]| audit_volumes(&solid, parts, &VolumeOptions::default(), &AuditOptions::default());
/// assert!(audit(&[part(&tops)?]).is_ok);
/// // Half of the layers are not all of the part.
/// let found = audit(&[part(&tops[..10])?]);
/// assert!(!found.is_ok && (found.parts[0].unlayered_mm3 - solid.volume() / 8.0).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
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
    let parts: Vec<PartAudit> = (0..parts.len()).map(|k| of_part(parts, k, options, audit)).collect();
    let is_sound = |part: &PartAudit| {
        let differs = (part.left_out_mm3 + part.added_mm3) / part.sections_mm3.max(f64::MIN_POSITIVE);
        part.unsupported_mm2 <= 0.0
            && part.unlayered_mm3 <= audit.allowed_share * whole
            && (options.min_feature_mm > 0.0 || differs <= audit.allowed_section_share)
    };
    let is_ok = volume_error <= VOLUME
        && missing_share <= audit.allowed_share
        && doubled_share <= audit.allowed_share
        && parts.iter().all(is_sound);
    VolumeAudit { volume_error, missing_share, doubled_share, parts, is_ok }
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

/// The volume of a solid above a plane: between its triangles, clipped to what is above, and the plane.
fn volume_above(solid: &Solid, direction: &Vector3<f64>, offset: f64) -> f64 {
    let mut sum = 0.0;
    for corners in solid.triangles() {
        let p = corners.map(|v| solid.vertices()[v as usize].coords);
        let height = p.map(|p| p.dot(direction) - offset);
        let mut above: Vec<(Vector3<f64>, f64)> = Vec::with_capacity(4);
        for k in 0..3 {
            let next = (k + 1) % 3;
            if height[k] > 0.0 {
                above.push((p[k], height[k]));
            }
            if (height[k] > 0.0) != (height[next] > 0.0) {
                let share = height[k] / (height[k] - height[next]);
                above.push((p[k] + (p[next] - p[k]) * share, 0.0));
            }
        }
        for k in 2..above.len() {
            let [(a, ha), (b, hb), (c, hc)] = [above[0], above[k - 1], above[k]];
            sum += (b - a).cross(&(c - a)).dot(direction) / 2.0 * (ha + hb + hc) / 3.0;
        }
    }
    sum
}

/// Shares of the solid's length on lines that are missing, and that are doubled or outside.
fn coverage(solid: &Solid, parts: &[VolumePart], audit: &AuditOptions) -> [f64; 2] {
    // A direction that no face of a part is likely to lie along.
    let direction = Vector3::new(0.0173, 0.0291, 1.0).normalize();
    let lines = Lines::new(direction, solid, 0.0, |side| side / audit.lines.max(1) as f64);
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

/// What there is to find of a part.
fn of_part(parts: &[VolumePart], k: usize, options: &VolumeOptions, audit: &AuditOptions) -> PartAudit {
    let part = &parts[k];
    let whole = volume(&part.solid);
    let Some(last) = part.layers.last() else { return PartAudit { unlayered_mm3: whole, ..PartAudit::default() } };
    let [above_base, above_last] =
        [part.base_mm, last.high_mm].map(|height| volume_above(&part.solid, &part.direction, height));
    let area = |layer: &VolumeLayer| layer.section.edges().map(|[a, b]| (a.x * b.y - b.x * a.y) / 2.0).sum::<f64>();
    let mut found = PartAudit {
        layered_mm3: above_base - above_last,
        // Not by difference: a rounding of the whole may be more than what is behind.
        unlayered_mm3: volume_above(&part.solid, &-part.direction, -part.base_mm).max(0.0) + above_last.max(0.0),
        sections_mm3: part.layers.iter().map(|layer| area(layer) * (layer.high_mm - layer.low_mm)).sum(),
        layers_mm2: part.layers.iter().map(area).sum(),
        ..PartAudit::default()
    };
    let least = part.layers.iter().map(|layer| layer.high_mm - layer.low_mm).fold(f64::INFINITY, f64::min);
    let step = |side: f64| (least / 4.0).max(side / audit.points.max(1) as f64);
    // What carries the first layer may be beside the part.
    let highest = part.layers.iter().map(|layer| layer.high_mm - layer.low_mm).fold(0.0, f64::max);
    let [low, high] = part.solid.bounds();
    let margin = (highest / options.angle.tan() + options.tolerance_mm).min((high - low).amax());
    // What carries may be narrower than a step of the grid: what is found to hang is looked at again on finer ones, unless that is known.
    for finer in [1.0, 2.0, 4.0] {
        let lines = Lines::new(part.direction, &part.solid, margin, |side| step(side) / finer);
        let before: Vec<Vec<Vec<f64>>> = parts[..k].iter().map(|earlier| lines.crossings(&earlier.solid)).collect();
        let sections: Vec<Vec<bool>> =
            part.layers.iter().map(|layer| lines.inside(&layer.section, &part.frame)).collect();
        if finer <= 1.0 {
            compare(part, (&lines, &lines.crossings(&part.solid), &sections), options, &mut found);
        }
        found.unsupported_mm2 = unsupported(part, &lines, (&before, &sections), options);
        if found.unsupported_mm2 <= 0.0 || part.overhang_mm3 > 0.0 {
            break;
        }
    }
    found.blocked_mm2 = blocked(parts, k, options, audit);
    found
}

/// Where sections are not those of the mesh, and what of the mesh no section is near.
fn compare(
    part: &VolumePart,
    (lines, own, sections): (&Lines, &[Vec<f64>], &[Vec<bool>]),
    options: &VolumeOptions,
    found: &mut PartAudit,
) {
    let square = lines.step * lines.step;
    for (layer, section) in part.layers.iter().zip(sections) {
        let middle = (layer.low_mm + layer.high_mm) / 2.0;
        let volume = (layer.high_mm - layer.low_mm) * square;
        for (crossings, &printed) in own.iter().zip(section) {
            match (is_inside(crossings, middle), printed) {
                (true, false) => found.left_out_mm3 += volume,
                (false, true) => found.added_mm3 += volume,
                _ => {}
            }
        }
    }
    let middle = |layer: &VolumeLayer| (layer.low_mm + layer.high_mm) / 2.0;
    for (line, crossings) in own.iter().enumerate() {
        for piece in crossings.chunks_exact(2) {
            let first = part.layers.partition_point(|layer| middle(layer) < piece[0]);
            if part.layers.get(first).is_some_and(|layer| middle(layer) <= piece[1]) {
                continue;
            }
            // Between two middles: in the layer above the lower one, or in the one below the upper one.
            let near = part.layers.iter().zip(sections).take(first + 1).skip(first.saturating_sub(1));
            for (&VolumeLayer { low_mm, high_mm, .. }, section) in near {
                let long = piece[1].min(high_mm) - piece[0].max(low_mm);
                let reach = (high_mm - low_mm) / options.angle.tan() + options.tolerance_mm + lines.step;
                if long > 0.0 && !lines.within(line, reach, |other| section[other]) {
                    found.thin_mm3 += long * square;
                }
            }
        }
    }
}

/// Area of the layers of a part, in squares of the grid, with nothing below in reach.
fn unsupported(
    part: &VolumePart,
    lines: &Lines,
    (before, sections): (&[Vec<Vec<f64>>], &[Vec<bool>]),
    options: &VolumeOptions,
) -> f64 {
    let mut unsupported = 0;
    for (k, layer) in part.layers.iter().enumerate() {
        let middle = (layer.low_mm + layer.high_mm) / 2.0;
        let height = layer.high_mm - layer.low_mm;
        // The first layer lies on the plate, or on what stands half a layer behind the base.
        let below = k.checked_sub(1).map(|below| &part.layers[below]);
        let (under, distance) = match below {
            Some(below) => ((below.low_mm + below.high_mm) / 2.0, middle - (below.low_mm + below.high_mm) / 2.0),
            None => (part.base_mm - height / 2.0, height),
        };
        if below.is_none() && part.separation.is_none() {
            continue;
        }
        let is_there = |line: usize| {
            k.checked_sub(1).is_some_and(|below| sections[below][line])
                || before.iter().any(|earlier| is_inside(&earlier[line], under))
        };
        // Between the lines may be what they miss: a step of the grid is allowed for it.
        let reach = distance / options.angle.tan() + options.tolerance_mm + lines.step;
        let is_hanging = |line: &usize| sections[k][*line] && !is_there(*line) && !lines.within(*line, reach, is_there);
        unsupported += (0..sections[k].len()).filter(is_hanging).count();
    }
    unsupported as f64 * lines.step * lines.step
}

/// Area of the layers of a part, in squares of a grid, over which the torch is in an earlier part or in the plate.
fn blocked(parts: &[VolumePart], k: usize, options: &VolumeOptions, audit: &AuditOptions) -> f64 {
    let part = &parts[k];
    let radius = options.torch_diameter_mm / 2.0;
    let lines = Lines::new(part.direction, &part.solid, radius, |side| side / audit.torch_points.max(1) as f64);
    // The torch goes on upwards without end, so that of what stands the top alone counts.
    let mut tops = vec![f64::NEG_INFINITY; lines.counts[0] * lines.counts[1]];
    for earlier in &parts[..k] {
        for (top, crossings) in tops.iter_mut().zip(lines.crossings(&earlier.solid)) {
            *top = crossings.last().map_or(*top, |last| top.max(*last));
        }
    }
    let [nx, ny] = lines.counts;
    let around = (radius / lines.step).floor() as usize;
    // The height over which the torch is free, by line: from its cone to what stands.
    let free_from = |line: usize| {
        let [i, j] = [line % nx, line / nx];
        let mut least = f64::NEG_INFINITY;
        for y in j.saturating_sub(around)..(j + around + 1).min(ny) {
            for x in i.saturating_sub(around)..(i + around + 1).min(nx) {
                let top = tops[y * nx + x];
                if top > least {
                    let far = (x.abs_diff(i) as f64).hypot(y.abs_diff(j) as f64) * lines.step;
                    let height = top - far / radius * options.standoff_mm;
                    least = if far <= radius { least.max(height) } else { least };
                }
            }
        }
        least
    };
    let mut known: Vec<Option<f64>> = vec![None; nx * ny];
    let in_plate = in_plate(parts, &part.direction, options);
    let mut blocked = 0;
    for layer in &part.layers {
        for (line, _) in lines.inside(&layer.section, &part.frame).iter().enumerate().filter(|(_, inside)| **inside) {
            let [x, y] = [line % nx, line / nx].map(|at| at as f64 * lines.step);
            let tip = part.direction * layer.high_mm + lines.u * (lines.low[0] + x) + lines.v * (lines.low[1] + y);
            let mut in_parts =
                || *known[line].get_or_insert_with(|| free_from(line)) > layer.high_mm + options.tolerance_mm;
            blocked += usize::from(in_plate(tip) || in_parts());
        }
    }
    blocked as f64 * lines.step * lines.step
}

/// Whether the torch is in the plate, by the place of what it lays; never where no part stands on the plate.
fn in_plate<'a>(
    parts: &'a [VolumePart],
    direction: &Vector3<f64>,
    options: &VolumeOptions,
) -> impl Fn(Vector3<f64>) -> bool + 'a {
    let plate = parts.iter().find(|part| part.separation.is_none());
    let level = plate.map_or(1.0, |plate| direction.dot(&plate.direction));
    // How far the torch reaches down to the plate from what it lays: with the rim of its mouth, or not at all.
    let sine = plate.map_or(0.0, |plate| direction.cross(&plate.direction).norm());
    let down = (options.torch_diameter_mm / 2.0 * sine - options.standoff_mm * level).max(0.0);
    let least = down - options.tolerance_mm;
    // What looks down at the plate comes through it.
    move |tip| plate.is_some_and(|plate| level < -1e-9 || tip.dot(&plate.direction) - plate.base_mm < least)
}
