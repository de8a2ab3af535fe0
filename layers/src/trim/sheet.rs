//! The sheet to be trimmed: checked, its edges numbered.

use super::edges::Edges;
use super::error::{Input, TrimError, check};
use super::patch::NONE;
use nalgebra::Point3;

pub(super) struct Sheet<'a> {
    pub(super) points: &'a [Point3<f64>],
    pub(super) triangles: &'a [[u32; 3]],
    pub(super) edges: Edges,
}

impl<'a> Sheet<'a> {
    pub(super) fn new(points: &'a [Point3<f64>], triangles: &'a [[u32; 3]]) -> Result<Sheet<'a>, TrimError> {
        check(Input::Sheet, points, triangles)?;
        let repeated = |[a, b, c]: &[u32; 3]| a == b || b == c || c == a;
        if let Some(triangle) = triangles.iter().position(repeated) {
            return Err(TrimError::RepeatedCorner { triangle });
        }
        let edges = Edges::new(triangles);
        // Each edge may be run along once each way.
        let mut run = vec![[false; 2]; edges.ends.len()];
        for (triangle, (corners, sides)) in triangles.iter().zip(&edges.sides).enumerate() {
            for k in 0..3 {
                let edge = [corners[k], corners[(k + 1) % 3]];
                if std::mem::replace(&mut run[sides[k] as usize][usize::from(edge[0] > edge[1])], true) {
                    return Err(TrimError::NotManifold { triangle, edge });
                }
            }
        }
        Ok(Sheet { points, triangles, edges })
    }

    /// Refuses triangles with the same three corners: their parts would have corners in common that do not tell which of them meet.
    pub(super) fn check_corners(&self) -> Result<(), TrimError> {
        let mut first = vec![NONE; self.edges.ends.len()];
        for (triangle, sides) in self.edges.sides.iter().enumerate() {
            let others = sides.map(|side| std::mem::replace(&mut first[side as usize], triangle as u32));
            if others[0] != NONE && others == [others[0]; 3] {
                return Err(TrimError::SameCorners { triangle, other: others[0] as usize });
            }
        }
        Ok(())
    }

    pub(super) fn corners(&self, triangle: usize) -> [&Point3<f64>; 3] {
        self.triangles[triangle].map(|corner| &self.points[corner as usize])
    }

    /// Whether a triangle runs along its side `k` from the higher vertex to the lower one.
    pub(super) fn runs_down(&self, triangle: usize, k: usize) -> bool {
        self.triangles[triangle][k] > self.triangles[triangle][(k + 1) % 3]
    }
}
