//! Which half-edges leave each vertex of the refined mesh.

use super::field::LevelField;
use crate::mesh::previous;

/// Half-edges out of each vertex.
pub(crate) struct Around {
    half_edges: Vec<u32>,
    starts: Vec<u32>,
}

impl Around {
    pub fn new(field: &LevelField) -> Self {
        let mut starts = vec![0; field.points.len() + 1];
        (0..field.half_edges()).for_each(|h| starts[field.tail(h) as usize + 1] += 1);
        (1..starts.len()).for_each(|v| starts[v] += starts[v - 1]);
        let (mut filled, mut half_edges) = (starts.clone(), vec![0; field.half_edges() as usize]);
        for h in 0..field.half_edges() {
            let at = &mut filled[field.tail(h) as usize];
            half_edges[*at as usize] = h;
            *at += 1;
        }
        Around { half_edges, starts }
    }

    /// Half-edges out of a vertex, by number; none for a vertex that no triangle has.
    pub fn of(&self, vertex: u32) -> &[u32] {
        let [from, to] = [0, 1].map(|k| self.starts[vertex as usize + k] as usize);
        &self.half_edges[from..to]
    }

    /// The vertices that edges join with a vertex of the field, those inside twice.
    pub fn neighbours<'a>(&'a self, field: &'a LevelField, vertex: u32) -> impl Iterator<Item = u32> + 'a {
        self.of(vertex).iter().flat_map(|&h| [field.head(h), field.tail(previous(h))])
    }
}
