//! A tree of boxes over triangles, halved at the median of the longest axis.

use super::bounds::Aabb;
use super::rounding::BOX_MM;
use nalgebra::Point3;

#[derive(Clone, Copy, Debug)]
struct MeshNode {
    bounds: Aabb,
    /// The first of two neighbouring children, or the triangle of a leaf.
    link: u32,
    leaf: bool,
}

/// Triangles with a tree over them.
#[derive(Clone, Debug)]
pub(super) struct MeshTree {
    nodes: Vec<MeshNode>,
    triangles: Vec<[Point3<f64>; 3]>,
}

impl MeshTree {
    /// At least one triangle. `O(n log n)`.
    pub fn new(triangles: Vec<[Point3<f64>; 3]>) -> Self {
        let boxes: Vec<Aabb> = triangles.iter().map(|corners| Aabb::of(corners)).collect();
        let around = |some: &[u32]| {
            let (mut low, mut high) = (Point3::from([f64::INFINITY; 3]), Point3::from([f64::NEG_INFINITY; 3]));
            for &k in some {
                low = low.inf(&(boxes[k as usize].center - boxes[k as usize].half));
                high = high.sup(&(boxes[k as usize].center + boxes[k as usize].half));
            }
            // Rounding of centre and half must not cut anything off.
            let mut bounds = Aabb::between(&low, &high);
            bounds.half.add_scalar_mut(BOX_MM);
            bounds
        };
        let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
        let mut nodes = vec![MeshNode { bounds: around(&order), link: 0, leaf: true }];
        let mut open = vec![(0usize, 0usize, order.len())];
        while let Some((node, from, to)) = open.pop() {
            if to - from == 1 {
                nodes[node].link = order[from];
                continue;
            }
            let axis = nodes[node].bounds.half.imax();
            let middle = (from + to) / 2;
            order[from..to].select_nth_unstable_by(middle - from, |&a, &b| {
                let at = |k: u32| boxes[k as usize].center[axis];
                at(a).total_cmp(&at(b)).then(a.cmp(&b))
            });
            let link = nodes.len();
            (nodes[node].link, nodes[node].leaf) = (link as u32, false);
            for (child, from, to) in [(link, from, middle), (link + 1, middle, to)] {
                nodes.push(MeshNode { bounds: around(&order[from..to]), link: 0, leaf: true });
                open.push((child, from, to));
            }
        }
        MeshTree { nodes, triangles }
    }

    pub fn triangles(&self) -> &[[Point3<f64>; 3]] {
        &self.triangles
    }

    pub fn bounds(&self, node: u32) -> Aabb {
        self.nodes[node as usize].bounds
    }

    pub fn children(&self, node: u32) -> Option<[u32; 2]> {
        let node = &self.nodes[node as usize];
        (!node.leaf).then_some([node.link, node.link + 1])
    }

    /// The triangle of a leaf.
    pub fn corners(&self, leaf: u32) -> &[Point3<f64>; 3] {
        &self.triangles[self.nodes[leaf as usize].link as usize]
    }
}
