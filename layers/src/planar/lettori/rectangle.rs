//! The largest axis-aligned rectangle inside a region, holes included.
//!
//! Lettori et al. 2022, Fig. 4b, after Z. Marzeh, M. Tahmasbi and N. Mirehi, "Algorithm for finding the largest inscribed
//! rectangle in polygon", J. Algorithms and Computation 51(1), 2019. Here a grid finds the rectangle to a cell (largest rectangle
//! of free cells by rows of heights), and a search with ever smaller steps moves its sides from there; every rectangle is
//! tested against the edges of the region, so the result is inside, and no move of a side by the last step, nor of one side
//! against another, makes it larger.

use crate::planar::Region;
use nalgebra::{Point2, Vector2};

/// Cells of the grid along each side. A region that is narrower than the cells of its bounds may be missed.
const CELLS: usize = 96;
/// The last step, as a share of the region's size.
const LAST_STEP: f64 = 1e-7;

/// Two opposite corners of the largest axis-aligned rectangle in a region, low and high; `None` for an empty region or one
/// too thin for the grid.
///
/// # Cost
/// Some thousand tests against the edges of the region.
///
/// # Example
/// ```
/// use curvlay_layers::nalgebra::Point2;
/// use curvlay_layers::planar::{Region, SectionPolygon, largest_rectangle};
/// let triangle = [[0.0, 0.0], [8.0, 0.0], [0.0, 4.0]].map(Point2::from).to_vec();
/// let region = Region::new(&[SectionPolygon { outer: triangle, holes: Vec::new() }])?;
/// let [low, high] = largest_rectangle(&region).unwrap();
/// assert!((low - Point2::origin()).norm() < 1e-4 && (high - Point2::new(4.0, 2.0)).norm() < 1e-2); // half of its area
/// # Ok::<(), curvlay_layers::planar::RegionError>(())
/// ```
pub fn largest_rectangle(region: &Region) -> Option<[Point2<f64>; 2]> {
    let [low, high] = region.bounds()?;
    let edges: Vec<[Point2<f64>; 2]> = region.edges().collect();
    let size = (high - low).amax();
    let start = of_cells(&edges, low, (high - low) / CELLS as f64)?;
    Some(refined(region, &edges, start, size))
}

/// The largest rectangle of cells that no edge touches.
fn of_cells(edges: &[[Point2<f64>; 2]], low: Point2<f64>, cell: Vector2<f64>) -> Option<[Point2<f64>; 2]> {
    let mut free = vec![false; CELLS * CELLS];
    for row in 0..CELLS {
        let y = low.y + (row as f64 + 0.5) * cell.y;
        let mut crossings: Vec<f64> = edges
            .iter()
            .filter(|[a, b]| (a.y > y) != (b.y > y))
            .map(|[a, b]| a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)))
            .collect();
        crossings.sort_by(f64::total_cmp);
        for pair in crossings.chunks_exact(2) {
            let first = ((pair[0] - low.x) / cell.x).floor().max(0.0) as usize;
            let last = ((pair[1] - low.x) / cell.x).ceil().max(0.0) as usize;
            for column in first.min(CELLS)..last.min(CELLS) {
                let x = low.x + (column as f64 + 0.5) * cell.x;
                free[row * CELLS + column] |= x > pair[0] && x < pair[1];
            }
        }
        // Cells of the row that an edge runs through.
        let [bottom, top] = [low.y + row as f64 * cell.y, low.y + (row as f64 + 1.0) * cell.y];
        for [a, b] in edges {
            let (a, b) = if a.y <= b.y { (a, b) } else { (b, a) };
            if b.y < bottom || a.y > top {
                continue;
            }
            let at =
                |y: f64| if b.y > a.y { a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)).clamp(0.0, 1.0) } else { a.x };
            let ends = if b.y > a.y { [at(bottom.max(a.y)), at(top.min(b.y))] } else { [a.x, b.x] };
            // An edge that only touches the border of a cell does not run through it.
            let slack = 1e-9 * cell.x;
            if (b.y - bottom).abs() < 1e-9 * cell.y || (a.y - top).abs() < 1e-9 * cell.y {
                continue;
            }
            let first = ((ends[0].min(ends[1]) - low.x + slack) / cell.x).floor().max(0.0) as usize;
            let last = ((ends[0].max(ends[1]) - low.x - slack) / cell.x).ceil().max(0.0) as usize;
            let row_of = &mut free[row * CELLS..(row + 1) * CELLS];
            row_of[first.min(CELLS)..last.max(first).min(CELLS)].fill(false);
        }
    }
    let (mut best, mut best_area) = (None, 0);
    let mut heights = vec![0_usize; CELLS + 1];
    for row in 0..CELLS {
        for column in 0..CELLS {
            heights[column] = if free[row * CELLS + column] { heights[column] + 1 } else { 0 };
        }
        let mut open: Vec<usize> = Vec::new();
        for column in 0..=CELLS {
            while let Some(&top) = open.last().filter(|&&top| heights[top] >= heights[column]) {
                open.pop();
                let left = open.last().map_or(0, |&before| before + 1);
                let area = heights[top] * (column - left);
                if area > best_area {
                    (best_area, best) = (area, Some([left, row + 1 - heights[top], column, row + 1]));
                }
            }
            open.push(column);
        }
    }
    best.map(|[x0, y0, x1, y1]| {
        let corner = |x: usize, y: usize| low + Vector2::new(x as f64 * cell.x, y as f64 * cell.y);
        [corner(x0, y0), corner(x1, y1)]
    })
}

/// Whether no edge meets the open rectangle, given as `x0, y0, x1, y1`.
fn is_clear(edges: &[[Point2<f64>; 2]], [x0, y0, x1, y1]: [f64; 4]) -> bool {
    edges.iter().all(|[a, b]| {
        // The part of the edge inside the rectangle, from `first` to `last` (Liang and Barsky).
        let (mut first, mut last) = (0.0_f64, 1.0_f64);
        for (from, to, low, high) in [(a.x, b.x, x0, x1), (a.y, b.y, y0, y1)] {
            let along = to - from;
            if along == 0.0 {
                if from <= low || from >= high {
                    return true;
                }
                continue;
            }
            let [enter, leave] = [(low - from) / along, (high - from) / along];
            (first, last) = (first.max(enter.min(leave)), last.min(enter.max(leave)));
        }
        first >= last
    })
}

fn refined(region: &Region, edges: &[[Point2<f64>; 2]], [low, high]: [Point2<f64>; 2], size: f64) -> [Point2<f64>; 2] {
    let area = |r: &[f64; 4]| (r[2] - r[0]) * (r[3] - r[1]);
    let fits = |r: &[f64; 4]| {
        let middle = Point2::new((r[0] + r[2]) / 2.0, (r[1] + r[3]) / 2.0);
        r[2] > r[0] && r[3] > r[1] && is_clear(edges, *r) && region.contains(&middle)
    };
    let outward = |mut r: [f64; 4], side: usize, by: f64| {
        r[side] += if side < 2 { -by } else { by };
        r
    };
    let mut best = [low.x, low.y, high.x, high.y];
    let mut step = size / CELLS as f64;
    while step > LAST_STEP * size {
        let mut improved = false;
        for side in 0..4 {
            let grown = outward(best, side, step);
            if fits(&grown) {
                (best, improved) = (grown, true);
                continue;
            }
            // One side in, another one out by as much as that frees.
            for other in (0..4).filter(|&other| other != side) {
                let mut traded = outward(best, side, -step);
                let mut by = 8.0 * step;
                while by >= step / 8.0 {
                    let grown = outward(traded, other, by);
                    if fits(&grown) {
                        traded = grown;
                    } else {
                        by /= 2.0;
                    }
                }
                if fits(&traded) && area(&traded) > area(&best) * (1.0 + 1e-12) {
                    (best, improved) = (traded, true);
                }
            }
        }
        if !improved {
            step /= 2.0;
        }
    }
    [Point2::new(best[0], best[1]), Point2::new(best[2], best[3])]
}
