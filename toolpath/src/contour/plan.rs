//! Rings that are cut open, and the bridges between the cuts: from these the curves follow.
//!
//! What is left of a ring between two cuts is an arc. Each end of an arc carries a bridge or is an end of a curve, and a
//! bridge leads to another arc. So nothing needs deciding any more when curves are put together.

use super::curve::Loop;
use crate::mesh::{SurfaceMesh, SurfacePoint};

/// One of the two ends of a cut: where it begins along the ring, or where it ends.
pub(super) type End = (usize, Side);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    From,
    To,
}

#[derive(Clone, Debug)]
pub(super) struct Cut {
    pub ring: u32,
    /// From the first place forward to the other, nothing is left of the ring.
    pub from: f64,
    pub to: f64,
    /// The bridge at each end.
    bridges: [Option<usize>; 2],
}

#[derive(Clone, Debug)]
struct Bridge {
    points: Vec<SurfacePoint>,
    /// The cuts that it joins; none where a curve ends.
    ends: [Option<End>; 2],
}

#[derive(Clone, Debug, Default)]
pub(super) struct Plan {
    cuts: Vec<Cut>,
    bridges: Vec<Bridge>,
    /// Cuts of each ring, in any order.
    of_ring: Vec<Vec<usize>>,
    /// Where curves start, and their regions.
    starts: Vec<(End, u32)>,
}

impl Plan {
    pub fn new(rings: usize) -> Self {
        Plan { of_ring: vec![Vec::new(); rings], ..Plan::default() }
    }

    /// Whether a ring is still whole from one place forward to another.
    pub fn is_free(&self, on: &Loop, ring: u32, from: f64, to: f64) -> bool {
        let length = on.length();
        self.of_ring[ring as usize].iter().all(|&c| {
            let cut = &self.cuts[c];
            let ahead = on.wrapped(cut.from - from);
            // The cut begins behind the stretch, and ends before it comes round to its start.
            ahead > to - from && ahead + (cut.to - cut.from) < length
        })
    }

    /// Whether a ring is not cut at all.
    pub fn is_whole(&self, ring: u32) -> bool {
        self.of_ring[ring as usize].is_empty()
    }

    /// The longest arc that is left of a ring: where it begins, and its length.
    pub fn longest_arc(&self, on: &Loop, ring: u32) -> (f64, f64) {
        let arcs = self.of_ring[ring as usize].iter().map(|&c| {
            let next = self.after((c, Side::To), on);
            let (from, to) = (self.cuts[c].to, self.cuts[next].from);
            (from, if next == c { on.length() - (self.cuts[c].to - self.cuts[c].from) } else { on.wrapped(to - from) })
        });
        arcs.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0.0, on.length()))
    }

    pub fn cut(&mut self, ring: u32, from: f64, to: f64) -> usize {
        self.of_ring[ring as usize].push(self.cuts.len());
        self.cuts.push(Cut { ring, from, to, bridges: [None; 2] });
        self.cuts.len() - 1
    }

    pub fn bridge(&mut self, points: Vec<SurfacePoint>, ends: [Option<End>; 2]) {
        for (cut, side) in ends.into_iter().flatten() {
            self.cuts[cut].bridges[side as usize] = Some(self.bridges.len());
        }
        self.bridges.push(Bridge { points, ends });
    }

    pub fn start(&mut self, at: End, region: u32) {
        self.starts.push((at, region));
    }

    /// The cut that follows along the ring from an end: forward from where a cut ends, back from where it begins.
    fn after(&self, (cut, side): End, on: &Loop) -> usize {
        let here = &self.cuts[cut];
        let way = |&c: &usize| {
            let ahead = match side {
                Side::To => on.wrapped(self.cuts[c].from - here.to),
                Side::From => on.wrapped(here.from - self.cuts[c].to),
            };
            // A ring with one cut leads back to it.
            if c == cut { on.length() } else { ahead }
        };
        let nearest = self.of_ring[here.ring as usize].iter().min_by(|a, b| way(a).total_cmp(&way(b)));
        nearest.copied().unwrap_or(cut)
    }

    /// All curves with their regions, each from its start to its end.
    pub fn curves(&self, mesh: &SurfaceMesh, loops: &[Option<Loop>]) -> Vec<(Vec<SurfacePoint>, u32)> {
        self.starts.iter().map(|&(start, region)| (self.follow(start, mesh, loops), region)).collect()
    }

    fn follow(&self, start: End, mesh: &SurfaceMesh, loops: &[Option<Loop>]) -> Vec<SurfacePoint> {
        let mut points = Vec::new();
        let mut at = start;
        // Each cut is left once at each end; more steps than that would go round in circles.
        for _ in 0..2 * self.cuts.len() {
            let Some(on) = &loops[self.cuts[at.0].ring as usize] else { break };
            let next = self.after(at, on);
            let (here, there) = (&self.cuts[at.0], &self.cuts[next]);
            let arrived = match at.1 {
                Side::To => {
                    points.extend(on.forward(mesh, here.to, there.from));
                    Side::From
                }
                Side::From => {
                    points.extend(on.forward(mesh, there.to, here.from).into_iter().rev());
                    Side::To
                }
            };
            let Some(bridge) = there.bridges[arrived as usize].map(|b| &self.bridges[b]) else { break };
            // A bridge is walked from whichever end the curve comes to.
            let far = if bridge.ends[0] == Some((next, arrived)) {
                points.extend(&bridge.points);
                bridge.ends[1]
            } else {
                points.extend(bridge.points.iter().rev());
                bridge.ends[0]
            };
            match far {
                Some(end) => at = end,
                None => break,
            }
        }
        points
    }
}
