//! Everything built so far, reduced to what can bound its convex hull.
//!
//! On each level of the lattice only the corners of the convex outline of the level's cells can be corners of the
//! hull, and for these only the two ends of each row count. So a body of `n` cells is kept as the two ends of each
//! row and a short outline for each level, and the offset of its hull in a direction is found by looking at the
//! outlines, level by level, where a box around the level does not rule it out.

use super::vec3::Vec3;
use super::wrap::outline;

/// The convex outline of what lies on one level.
struct Level {
    z: i64,
    corners: Vec<[i64; 2]>,
    low: [i64; 2],
    high: [i64; 2],
}

impl Level {
    fn new(z: i64) -> Self {
        Level { z, corners: Vec::new(), low: [0; 2], high: [0; 2] }
    }

    fn set(&mut self, mut points: Vec<[i64; 2]>) {
        self.corners = outline(&mut points, |point| point);
        let along = |axis: usize| self.corners.iter().map(move |corner| corner[axis]);
        self.low = [0, 1].map(|axis| along(axis).min().unwrap_or(0));
        self.high = [0, 1].map(|axis| along(axis).max().unwrap_or(0));
    }

    /// Raises `best` to the largest `n.p` on this level if that is larger, and returns its place.
    fn raise(&self, n: Vec3, best: &mut i64) -> Option<Vec3> {
        // The box bounds what the outline can reach: most levels are passed over by it.
        let side = |axis: usize| n[axis] * if n[axis] > 0 { self.high[axis] } else { self.low[axis] };
        let base = n[2] * self.z;
        if self.corners.is_empty() || base + side(0) + side(1) <= *best {
            return None;
        }
        let mut found = None;
        for &[x, y] in &self.corners {
            let offset = base + n[0] * x + n[1] * y;
            if offset > *best {
                *best = offset;
                found = Some([x, y, self.z]);
            }
        }
        found
    }
}

/// The platform and the cells of all earlier layers.
pub(super) struct Body {
    platform: Level,
    levels: Vec<Level>,
    rows_per_level: usize,
    /// First and last cell of each row `y + ny * z`; first > last for an empty row.
    ends: Vec<[u16; 2]>,
    /// Levels whose ends moved since the last [`Body::settle`].
    moved: Vec<usize>,
    has_moved: Vec<bool>,
}

impl Body {
    pub(super) fn new([_, ny, nz]: [u32; 3], corners: &[[i32; 2]], top: i32) -> Self {
        let mut platform = Level::new(i64::from(top));
        platform.set(corners.iter().map(|corner| corner.map(i64::from)).collect());
        Body {
            platform,
            levels: (0..nz).map(|z| Level::new(2 * i64::from(z) + 1)).collect(),
            rows_per_level: ny as usize,
            ends: vec![[u16::MAX, 0]; ny as usize * nz as usize],
            moved: Vec::new(),
            has_moved: vec![false; nz as usize],
        }
    }

    /// Three corners of the platform that are not on a line.
    pub(super) fn platform_triangle(&self) -> [Vec3; 3] {
        let corners = &self.platform.corners;
        [0, 1, 2].map(|k| {
            let [x, y] = corners[k * corners.len() / 3];
            [x, y, self.platform.z]
        })
    }

    /// Adds a cell. It counts from the next [`Body::settle`] on.
    pub(super) fn add(&mut self, [x, y, z]: [u32; 3]) {
        let (x, y, z) = (x as u16, y as usize, z as usize);
        let ends = &mut self.ends[y + self.rows_per_level * z];
        // A cell between the ends of its row lies in their hull.
        if x < ends[0] || x > ends[1] {
            *ends = [ends[0].min(x), ends[1].max(x)];
            if !self.has_moved[z] {
                self.has_moved[z] = true;
                self.moved.push(z);
            }
        }
    }

    /// Takes the cells added since the last call into the body; returns the levels that changed.
    pub(super) fn settle(&mut self) -> Vec<usize> {
        let moved = std::mem::take(&mut self.moved);
        for &z in &moved {
            self.has_moved[z] = false;
            let rows = &self.ends[self.rows_per_level * z..][..self.rows_per_level];
            let filled = rows.iter().enumerate().filter(|(_, [first, last])| first <= last);
            let ends = filled.flat_map(|(y, ends)| ends.map(|x| [2 * i64::from(x) + 1, 2 * y as i64 + 1]));
            self.levels[z].set(ends.collect());
        }
        moved
    }

    /// The largest `n.p` over the body, and a point where it is reached.
    pub(super) fn support(&self, n: Vec3) -> (i64, Vec3) {
        let mut best = i64::MIN;
        let mut point = self.platform.raise(n, &mut best).unwrap_or_default();
        // `raise` returns nothing for a level that reaches no farther: the point stays with the offset.
        for level in &self.levels {
            point = level.raise(n, &mut best).unwrap_or(point);
        }
        (best, point)
    }

    /// The larger of `offset` and the largest `n.p` on the given levels.
    pub(super) fn raised(&self, n: Vec3, offset: i64, levels: &[usize]) -> i64 {
        let mut best = offset;
        for &z in levels {
            self.levels[z].raise(n, &mut best);
        }
        best
    }
}
