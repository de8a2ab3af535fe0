//! Rows that end on rims, joined into curves that go to and fro.
//!
//! Two ends that follow each other on a rim and belong to neighbouring rows are joined by the rim between them. A curve takes one row
//! after the other, always to the next higher one, as long as there is such a join; where ends of curves follow each other on a rim, in
//! neighbouring rows or in parts of the same, these curves become one at last. Each piece of a rim joins two ends next to it, so
//! curves do not cross if rows do not.

use super::curve::Loop;
use crate::mesh::{SurfaceMesh, SurfacePoint};
use crate::union_find::{join, root};

/// A curve, whether it is closed, and its region.
pub(crate) type RowCurve = (Vec<SurfacePoint>, bool, u32);

/// What rows end at: a ring half a bead from the boundary, and the region inside of it.
pub(crate) struct Rim<'a> {
    pub on: &'a Loop,
    pub region: u32,
}

/// A row or a part of one.
pub(crate) struct Row {
    /// Its number, counted from the lowest one up; the cut is between -1 and 0.
    pub number: i64,
    pub points: Vec<SurfacePoint>,
    pub closed: bool,
    /// Rim and place of both ends.
    pub ends: [Option<(usize, f64)>; 2],
}

/// Where an end of a row is joined to: the row and its end, and the rim in between.
#[derive(Clone, Copy)]
struct Join {
    row: usize,
    end: usize,
    rim: usize,
    /// Places on the rim, forward.
    from: f64,
    to: f64,
    length: f64,
    /// Whether it is walked forward.
    forward: bool,
}

/// Curves through all rows.
///
/// # Arguments
/// * `mesh`: that of the points of rows and rims.
/// * `longest`: longer pieces of a rim join nothing, in millimetres.
pub(crate) fn joined(mesh: &SurfaceMesh, rows: &[Row], rims: &[Rim], longest: f64) -> Vec<RowCurve> {
    let joins = joins(rows, rims, longest);
    let mut used = vec![false; rows.len()];
    let mut order: Vec<usize> = (0..rows.len()).collect();
    order.sort_by_key(|&row| (rows[row].number, row));
    let mut links: Links = vec![[None; 2]; rows.len()];
    let mut parents: Vec<u32> = (0..rows.len() as u32).collect();
    for &first in &order {
        if used[first] {
            continue;
        }
        // Upwards from either end: the longer chain makes the longer curve.
        let [one, other] = [0, 1].map(|entry| chain(rows, &joins, &used, first, entry));
        used[first] = true;
        for (row, end, there) in if other.len() > one.len() { other } else { one } {
            used[there.row] = true;
            link(&mut links, &mut parents, row, end, there);
        }
    }
    let mut left: Vec<(usize, usize, Join)> = Vec::new();
    for (row, ends) in joins.iter().enumerate() {
        left.extend(ends.iter().enumerate().flat_map(|(end, all)| all.iter().map(move |&there| (row, end, there))));
    }
    // What is left over is joined shortest first, as long as no curve becomes a ring.
    left.sort_by(|a, b| a.2.length.total_cmp(&b.2.length).then((a.0, a.1).cmp(&(b.0, b.1))));
    for (row, end, there) in left {
        let free = links[row][end].is_none() && links[there.row][there.end].is_none();
        if free && root(&mut parents, row as u32) != root(&mut parents, there.row as u32) {
            link(&mut links, &mut parents, row, end, there);
        }
    }
    let mut curves = Vec::new();
    let mut done = vec![false; rows.len()];
    for &first in &order {
        let Some(entry) = (0..2).find(|&end| links[first][end].is_none()).filter(|_| !done[first]) else {
            continue;
        };
        let region = rows[first].ends.iter().flatten().next().map(|end| rims[end.0].region);
        // Closed ones touch no rim; the nearest one gives the region.
        let region = region.unwrap_or_else(|| nearest_region(rims, &rows[first]));
        let mut points = Vec::new();
        let (mut row, mut entry) = (first, entry);
        loop {
            done[row] = true;
            if entry == 0 {
                points.extend(&rows[row].points);
            } else {
                points.extend(rows[row].points.iter().rev());
            }
            let Some(there) = links[row][1 - entry] else {
                break;
            };
            points.extend(there.points(mesh, rims));
            (row, entry) = (there.row, there.end);
        }
        curves.push((points, rows[first].closed, region));
    }
    curves
}

/// For each end of each row what it is joined to, if anything.
type Links = Vec<[Option<Join>; 2]>;

fn link(links: &mut Links, parents: &mut [u32], row: usize, end: usize, there: Join) {
    links[row][end] = Some(there);
    links[there.row][there.end] = Some(Join { row, end, forward: !there.forward, ..there });
    join(parents, row as u32, there.row as u32);
}

/// The rim and the place on it at which a row ends.
pub(crate) fn end(rims: &[Rim], p: &SurfacePoint, near: f64) -> Option<(usize, f64)> {
    let mut best: Option<(usize, f64, f64)> = None;
    for (rim, Rim { on, .. }) in rims.iter().enumerate() {
        let most = best.map_or(near, |best| best.2);
        best = on.nearer(p.position, most).map(|(place, distance)| (rim, place, distance)).or(best);
    }
    best.map(|(rim, place, _)| (rim, place))
}

fn nearest_region(rims: &[Rim], row: &Row) -> u32 {
    let apart = |rim: &Rim| row.points.first().map_or(f64::INFINITY, |p| rim.on.nearest(p.position).1);
    rims.iter().min_by(|a, b| apart(a).total_cmp(&apart(b))).map_or(0, |rim| rim.region)
}

/// For each end of each row what it may be joined to.
fn joins(rows: &[Row], rims: &[Rim], longest: f64) -> Vec<[Vec<Join>; 2]> {
    let mut along: Vec<Vec<(f64, usize, usize)>> = vec![Vec::new(); rims.len()];
    for (row, Row { ends, .. }) in rows.iter().enumerate() {
        for (end, place) in ends.iter().enumerate() {
            place.iter().for_each(|&(rim, place)| along[rim].push((place, row, end)));
        }
    }
    let mut joins: Vec<[Vec<Join>; 2]> = rows.iter().map(|_| [Vec::new(), Vec::new()]).collect();
    for (rim, ends) in along.iter_mut().enumerate() {
        ends.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        for k in 0..ends.len() {
            let ((from, row, end), (to, other, other_end)) = (ends[k], ends[(k + 1) % ends.len()]);
            let length = rims[rim].on.wrapped(to - from);
            if rows[row].number.abs_diff(rows[other].number) > 1 || length > longest {
                continue;
            }
            let join = Join { row: other, end: other_end, rim, from, to, length, forward: true };
            joins[row][end].push(join);
            joins[other][other_end].push(Join { row, end, forward: false, ..join });
        }
    }
    joins
}

/// Joins from one row on, each with the row and the end from which it leads.
fn chain(
    rows: &[Row],
    joins: &[[Vec<Join>; 2]],
    used: &[bool],
    first: usize,
    entry: usize,
) -> Vec<(usize, usize, Join)> {
    let mut chain = Vec::new();
    let (mut row, mut entry) = (first, entry);
    // Numbers rise, so no row comes twice.
    loop {
        let up = |join: &&Join| rows[join.row].number == rows[row].number + 1 && !used[join.row];
        let best = joins[row][1 - entry].iter().filter(up).min_by(|a, b| a.length.total_cmp(&b.length));
        let Some(&there) = best else {
            return chain;
        };
        chain.push((row, 1 - entry, there));
        (row, entry) = (there.row, there.end);
    }
}

impl Join {
    /// The points of the rim in between.
    fn points(&self, mesh: &SurfaceMesh, rims: &[Rim]) -> Vec<SurfacePoint> {
        let mut points = rims[self.rim].on.forward(mesh, self.from, self.to);
        if !self.forward {
            points.reverse();
        }
        points
    }
}
