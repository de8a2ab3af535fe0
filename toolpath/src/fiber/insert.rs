//! A curve over a mesh as a chain of its edges: the triangles that it crosses are cut along it.

use crate::mesh::{MeshError, SurfaceMesh};
use nalgebra::Point3;
use std::collections::BTreeMap;

/// A chain of vertices along a curve.
#[derive(Clone, Debug, Default)]
pub(super) struct Chain {
    pub vertices: Vec<u32>,
    pub closed: bool,
}

impl Chain {
    /// The two ends of each edge.
    pub(super) fn ends(&self) -> impl Iterator<Item = [u32; 2]> {
        let closing = self.vertices.last().zip(self.vertices.first()).filter(|_| self.closed);
        self.vertices.windows(2).map(|pair| [pair[0], pair[1]]).chain(closing.map(|(last, first)| [*last, *first]))
    }
}

/// A crossing nearer to an end of an edge than this, as a share of its length, is at that vertex: no slivers.
const AT_VERTEX: f64 = 1e-6;

/// A mesh, the triangle of the layer of which each of its triangles is a part, and the chain in it.
pub(super) type Inserted = (SurfaceMesh, Vec<u32>, Chain);

/// Cuts triangles along a curve. The outer error is where the curve crosses itself.
pub(super) fn insert(
    mesh: &SurfaceMesh,
    parents: &[u32],
    crossings: &[(u32, Point3<f64>)],
    closed: bool,
) -> Result<Result<Inserted, MeshError>, Point3<f64>> {
    let mut vertices = mesh.vertices().to_vec();
    let mut on_edges: BTreeMap<u32, Vec<(f64, u32)>> = BTreeMap::new();
    let mut chain: Vec<u32> = Vec::new();
    let mut chords: BTreeMap<u32, Vec<[u32; 2]>> = BTreeMap::new();
    let crossings = without_returns(mesh, crossings, closed);
    let mut entered: Option<(u32, u32)> = None; // triangle and vertex
    let mut first: Option<(u32, u32)> = None;
    for &(h, p) in &crossings {
        let vertex = vertex_at(mesh, &mut vertices, &mut on_edges, h, p);
        if let Some((triangle, from)) = entered.filter(|&(triangle, from)| triangle == h / 3 && from != vertex) {
            chords.entry(triangle).or_default().push([from, vertex]);
        }
        first = first.or(Some((h / 3, vertex)));
        if chain.last() != Some(&vertex) {
            chain.push(vertex);
        }
        // A curve that begins at the border has it on its left there, and enters the triangle of the half-edge itself.
        entered = Some((mesh.twin(h).unwrap_or(h) / 3, vertex));
    }
    let mut chain = Chain { vertices: chain, closed: false };
    if let (true, Some((triangle, to)), Some((last, from))) = (closed, first, entered) {
        chain.closed = triangle == last && chain.vertices.len() > 2;
        if chain.closed && from != to {
            chords.entry(triangle).or_default().push([from, to]);
        }
        if from == to && chain.vertices.len() > 1 {
            chain.vertices.pop();
        }
    }
    on_edges.values_mut().for_each(|points| points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))));

    let (mut triangles, mut of) = (Vec::with_capacity(mesh.triangles().len()), Vec::new());
    for (triangle, corners) in mesh.triangles().iter().enumerate() {
        let outline = outline(mesh, &on_edges, triangle as u32);
        if outline.len() == 3 {
            triangles.push(*corners);
            of.push(parents[triangle]);
            continue;
        }
        let mut parts = vec![outline];
        for &chord in chords.get(&(triangle as u32)).into_iter().flatten() {
            split(&mut parts, chord).ok_or(vertices[chord[0] as usize])?;
        }
        for part in parts {
            let before = triangles.len();
            fan(&mut vertices, &mut triangles, &part);
            of.resize(of.len() + triangles.len() - before, parents[triangle]);
        }
    }
    Ok(SurfaceMesh::new(vertices, triangles).map(|mesh| (mesh, of, chain)))
}

/// Crossings without those that come straight back over the same edge.
fn without_returns(mesh: &SurfaceMesh, crossings: &[(u32, Point3<f64>)], closed: bool) -> Vec<(u32, Point3<f64>)> {
    let mut kept: Vec<(u32, Point3<f64>)> = Vec::with_capacity(crossings.len());
    for &(h, p) in crossings {
        match kept.last() {
            Some(&(last, _)) if mesh.twin(last) == Some(h) => {
                kept.pop();
            }
            _ => kept.push((h, p)),
        }
    }
    while closed && kept.len() > 1 && mesh.twin(kept[kept.len() - 1].0) == Some(kept[0].0) {
        kept.pop();
        kept.remove(0);
    }
    kept
}

/// The vertex of a crossing, made if there is none.
fn vertex_at(
    mesh: &SurfaceMesh,
    vertices: &mut Vec<Point3<f64>>,
    on_edges: &mut BTreeMap<u32, Vec<(f64, u32)>>,
    h: u32,
    p: Point3<f64>,
) -> u32 {
    let edge = mesh.edge(h);
    let [tail, head] = [mesh.tail(edge), mesh.head(edge)];
    let [from, to] = [tail, head].map(|v| mesh.vertices()[v as usize]);
    let share = (p - from).dot(&(to - from)) / (to - from).norm_squared();
    if share < AT_VERTEX {
        return tail;
    }
    if share > 1.0 - AT_VERTEX {
        return head;
    }
    let points = on_edges.entry(edge).or_default();
    match points.iter().find(|point| (point.0 - share).abs() < AT_VERTEX) {
        Some(&(_, vertex)) => vertex,
        None => {
            let vertex = vertices.len() as u32;
            vertices.push(from + (to - from) * share);
            points.push((share, vertex));
            vertex
        }
    }
}

/// The corners of a triangle with the points on its edges between them.
fn outline(mesh: &SurfaceMesh, on_edges: &BTreeMap<u32, Vec<(f64, u32)>>, triangle: u32) -> Vec<u32> {
    let mut outline = Vec::with_capacity(3);
    for h in 3 * triangle..3 * triangle + 3 {
        outline.push(mesh.tail(h));
        let edge = mesh.edge(h);
        let points = on_edges.get(&edge).map_or(&[][..], Vec::as_slice).iter().map(|&(_, vertex)| vertex);
        if edge == h { outline.extend(points) } else { outline.extend(points.rev()) }
    }
    outline
}

/// Splits the part that has both ends of a chord; `None` if none has.
fn split(parts: &mut Vec<Vec<u32>>, [from, to]: [u32; 2]) -> Option<()> {
    let place = |part: &Vec<u32>, vertex| part.iter().position(|&v| v == vertex);
    let part = parts.iter().position(|part| place(part, from).is_some() && place(part, to).is_some())?;
    let outline = &parts[part];
    let (a, b) = (place(outline, from)?, place(outline, to)?);
    let (a, b) = (a.min(b), a.max(b));
    if b - a == 1 || b - a == outline.len() - 1 {
        return Some(()); // an edge already
    }
    let one = outline[a..=b].to_vec();
    let other = outline[b..].iter().chain(&outline[..=a]).copied().collect();
    parts[part] = one;
    parts.push(other);
    Some(())
}

/// Cuts a convex part into triangles around its middle. Its corners may lie in a row.
fn fan(vertices: &mut Vec<Point3<f64>>, triangles: &mut Vec<[u32; 3]>, part: &[u32]) {
    if let [a, b, c] = *part {
        triangles.push([a, b, c]);
        return;
    }
    let middle = vertices.len() as u32;
    let sum = part.iter().fold(nalgebra::Vector3::zeros(), |sum, &v| sum + vertices[v as usize].coords);
    vertices.push((sum / part.len() as f64).into());
    (0..part.len()).for_each(|k| triangles.push([part[k], part[(k + 1) % part.len()], middle]));
}

/// All triangles cut into four until no edge is longer than asked for, with the triangle of which each is a part; `None` if that takes more than
/// `most`.
pub(super) fn quartered(mesh: &SurfaceMesh, longest: f64, most: usize) -> Option<(SurfaceMesh, Vec<u32>)> {
    let (mut vertices, mut triangles) = (mesh.vertices().to_vec(), mesh.triangles().to_vec());
    let mut parents: Vec<u32> = (0..triangles.len() as u32).collect();
    let length = |vertices: &[Point3<f64>], a: u32, b: u32| (vertices[a as usize] - vertices[b as usize]).norm();
    let edges = |[a, b, c]: [u32; 3]| [[a, b], [b, c], [c, a]];
    let too_long =
        |v: &[Point3<f64>], t: &[[u32; 3]]| t.iter().any(|t| edges(*t).iter().any(|&[a, b]| length(v, a, b) > longest));
    // Each round halves all edges. What would be refused after many rounds is refused before the first.
    let edge = triangles.iter().flat_map(|&t| edges(t)).map(|[a, b]| length(&vertices, a, b)).fold(0.0, f64::max);
    let rounds = ((edge / longest).log2() - 1e-9).ceil().max(0.0);
    if rounds > 0.0 && triangles.len() as f64 * 4_f64.powf(rounds) > most as f64 {
        return None;
    }
    while too_long(&vertices, &triangles) {
        if triangles.len() > most / 4 {
            return None;
        }
        let mut middles = BTreeMap::new();
        let mut quarters = Vec::with_capacity(4 * triangles.len());
        for &corners in &triangles {
            let [d, e, f] = edges(corners).map(|[from, to]| {
                *middles.entry([from.min(to), from.max(to)]).or_insert_with(|| {
                    vertices.push(nalgebra::center(&vertices[from as usize], &vertices[to as usize]));
                    vertices.len() as u32 - 1
                })
            });
            let [a, b, c] = corners;
            quarters.extend([[a, d, f], [d, b, e], [f, e, c], [d, e, f]]);
        }
        triangles = quarters;
        parents = parents.iter().flat_map(|&parent| [parent; 4]).collect();
    }
    // Parts of sound triangles are sound.
    SurfaceMesh::new(vertices, triangles).ok().map(|fine| (fine, parents))
}
