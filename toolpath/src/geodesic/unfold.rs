//! Triangles laid flat: each half-edge along the x axis with its triangle above.

use crate::mesh::{SurfaceMesh, next};

/// A triangle in the frame of one of its half-edges: tail at the origin, head at `(length, 0)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub length: f64,
    /// The third corner; its height is positive.
    pub apex: [f64; 2],
}

/// The frames of all half-edges and the angles around vertices.
#[derive(Clone, Debug)]
pub(super) struct Unfolding {
    frames: Vec<Frame>,
    /// The angle at the tail of each half-edge, in its triangle.
    angles: Vec<f64>,
    /// The sum of the angles around each vertex.
    totals: Vec<f64>,
}

impl Unfolding {
    pub fn new(mesh: &SurfaceMesh) -> Self {
        let mut totals = vec![0.0; mesh.vertices().len()];
        let (frames, angles) = (0..mesh.half_edges())
            .map(|h| {
                let [a, b, c] = [h, next(h), next(next(h))].map(|h| mesh.vertices()[mesh.tail(h) as usize]);
                let (along, up) = (b - a, c - a);
                let length = along.norm();
                let apex = [along.dot(&up) / length, along.cross(&up).norm() / length];
                let angle = apex[1].atan2(apex[0]);
                totals[mesh.tail(h) as usize] += angle;
                (Frame { length, apex }, angle)
            })
            .unzip();
        Unfolding { frames, angles, totals }
    }

    pub fn frame(&self, half_edge: u32) -> Frame {
        self.frames[half_edge as usize]
    }

    pub fn angle(&self, half_edge: u32) -> f64 {
        self.angles[half_edge as usize]
    }

    pub fn total(&self, vertex: u32) -> f64 {
        self.totals[vertex as usize]
    }

    pub fn mean_length(&self) -> f64 {
        self.frames.iter().map(|frame| frame.length).sum::<f64>() / self.frames.len() as f64
    }
}
