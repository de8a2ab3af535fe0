//! The drawing: the arm among its obstacles, and what was learned against the truth.

use super::arm::{DISCS, GIRTH, PATH, collides, corners};
use curvlay_trajectory::indicator::Sample;
use std::f64::consts::{PI, TAU};
use std::fmt::Write;

/// Side of a panel, the room around it, and the height of its title, in pixels.
const SIDE: f64 = 270.0;
const ROOM: f64 = 26.0;
const TITLE: f64 = 20.0;
/// Cells along the side of a map.
const CELLS: usize = 135;

const FREE: &str = "#a9cde8";
const BLOCKED: &str = "#b9bcc2";
const WRONG: &str = "#e0523f";

/// Panels, three in a row.
#[derive(Default)]
pub struct Drawing {
    body: String,
    panels: usize,
}

/// What is drawn over a map of two coordinates.
pub struct Map<'a> {
    pub title: String,
    /// What goes along and up, and from where to where.
    pub axes: [&'static str; 2],
    pub range: [f64; 2],
    /// The joints at two coordinates; none where nothing can be reached.
    pub joints: &'a dyn Fn([f64; 2]) -> Option<[f64; 3]>,
    pub predicts: &'a dyn Fn(&[f64; 3]) -> bool,
    /// Samples by their coordinates, and whether they collide.
    pub dots: Vec<([f64; 2], bool)>,
}

impl Drawing {
    /// Begins a panel; all in it is measured from its lower left corner, in pixels.
    fn begin(&mut self, title: &str) -> [f64; 2] {
        let (column, row) = (self.panels % 3, self.panels / 3);
        self.panels += 1;
        let left = ROOM + column as f64 * (SIDE + ROOM);
        let low = (row + 1) as f64 * (SIDE + ROOM + TITLE);
        let _ = write!(self.body, "\n<text x=\"{left}\" y=\"{}\">{title}</text>", low - SIDE - 6.0);
        [left, low]
    }

    /// The arm at some postures among path and discs.
    pub fn scene(&mut self, title: &str, postures: &[[f64; 3]]) {
        let [left, low] = self.begin(title);
        // From -250 to 650 across, from -280 up.
        let scale = SIDE / 900.0;
        let at = |p: [f64; 2]| [left + (p[0] + 250.0) * scale, low - (p[1] + 280.0) * scale];
        let circle = |center: [f64; 2], radius: f64, style: &str| {
            let [x, y] = at(center);
            format!("\n<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{:.1}\" {style}/>", radius * scale)
        };
        for (center, radius) in DISCS {
            self.body += &circle(center, radius, &format!("fill=\"{WRONG}\""));
        }
        self.body += &circle(PATH.0, PATH.1, "fill=\"none\" stroke=\"#3c9a4e\" stroke-width=\"2\"");
        for q in postures {
            let colour = if collides(q) { "#5b6675" } else { "#2f75b5" };
            let line: Vec<String> = corners(q).iter().map(|&p| at(p)).map(|[x, y]| format!("{x:.1} {y:.1}")).collect();
            let _ = write!(
                self.body,
                "\n<path fill=\"none\" stroke=\"{colour}\" stroke-width=\"{:.1}\" stroke-linecap=\"round\" \
                 stroke-linejoin=\"round\" stroke-opacity=\"0.75\" d=\"M{}\"/>",
                2.0 * GIRTH * scale,
                line.join("L")
            );
        }
    }

    /// Free in blue, colliding in grey, where the prediction is wrong in red, its boundary in black. Returns the share
    /// of reachable cells on which it is wrong.
    pub fn map(&mut self, map: &Map) -> f64 {
        let [left, low] = self.begin(&map.title);
        let coordinate = |k: usize| map.range[0] + (map.range[1] - map.range[0]) * (k as f64 + 0.5) / CELLS as f64;
        // Of each cell what is so and what is predicted; nothing where it cannot be reached.
        let known: Vec<Option<[bool; 2]>> = (0..CELLS * CELLS)
            .map(|k| {
                let joints = (map.joints)([coordinate(k % CELLS), coordinate(k / CELLS)])?;
                Some([collides(&joints), (map.predicts)(&joints)])
            })
            .collect();
        self.cells(&known, [left, low]);
        self.boundary(&known, [left, low]);
        let share = |x: f64| (x - map.range[0]) / (map.range[1] - map.range[0]);
        for (at, hits) in map.dots.iter().filter(|(at, _)| at.iter().all(|&x| (0.0..=1.0).contains(&share(x)))) {
            let (x, y) = (left + share(at[0]) * SIDE, low - share(at[1]) * SIDE);
            let colour = if *hits { "#30343b" } else { "#114b86" };
            let _ = write!(self.body, "\n<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"1.3\" fill=\"{colour}\"/>");
        }
        let [along, up] = map.axes;
        let _ = write!(
            self.body,
            "\n<rect x=\"{left}\" y=\"{}\" width=\"{SIDE}\" height=\"{SIDE}\" fill=\"none\" stroke=\"#9aa5b3\"/>\
             <text text-anchor=\"middle\" x=\"{}\" y=\"{}\">{along}</text>\
             <text text-anchor=\"middle\" transform=\"translate({} {}) rotate(-90)\">{up}</text>",
            low - SIDE,
            left + SIDE / 2.0,
            low + 14.0,
            left - 7.0,
            low - SIDE / 2.0
        );
        let reached: Vec<[bool; 2]> = known.into_iter().flatten().collect();
        reached.iter().filter(|[truth, said]| truth != said).count() as f64 / reached.len().max(1) as f64
    }

    /// Cells of a map in their colours, equal ones of a row as one rectangle.
    fn cells(&mut self, known: &[Option<[bool; 2]>], at: [f64; 2]) {
        for (y, row) in known.chunks(CELLS).enumerate() {
            let mut x = 0;
            for same in row.chunk_by(|a, b| a == b) {
                let colour = match same[0] {
                    None => None,
                    Some([truth, said]) if truth != said => Some(WRONG),
                    Some([truth, _]) => Some(if truth { BLOCKED } else { FREE }),
                };
                if let Some(colour) = colour {
                    let [left, top] = corner(at, x, y + 1);
                    let wide = same.len() as f64 * CELL;
                    let _ = write!(
                        self.body,
                        "\n<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{wide:.1}\" height=\"{:.1}\" fill=\"{colour}\"/>",
                        CELL + 0.1
                    );
                }
                x += same.len();
            }
        }
    }

    /// The boundary of what is predicted: between cells with different predictions.
    fn boundary(&mut self, known: &[Option<[bool; 2]>], at: [f64; 2]) {
        let said = |x: usize, y: usize| known[x + CELLS * y].map(|[_, said]| said);
        let part = |a: Option<bool>, b: Option<bool>| matches!((a, b), (Some(a), Some(b)) if a != b);
        let mut edges = String::new();
        for (x, y) in (0..CELLS).flat_map(|y| (0..CELLS).map(move |x| (x, y))) {
            if x + 1 < CELLS && part(said(x, y), said(x + 1, y)) {
                let [right, from] = corner(at, x + 1, y);
                let _ = write!(edges, "M{right:.1} {from:.1}v{:.1}", -CELL);
            }
            if y + 1 < CELLS && part(said(x, y), said(x, y + 1)) {
                let [from, top] = corner(at, x, y + 1);
                let _ = write!(edges, "M{from:.1} {top:.1}h{CELL:.1}");
            }
        }
        let _ = write!(self.body, "\n<path fill=\"none\" stroke=\"#111111\" d=\"{edges}\"/>");
    }

    /// The `svg` element.
    pub fn to_svg(&self) -> String {
        let rows = self.panels.div_ceil(3) as f64;
        let (width, height) = (3.0 * (SIDE + ROOM) + ROOM, rows * (SIDE + ROOM + TITLE) + ROOM);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" role=\"img\" \
             font-family=\"sans-serif\" font-size=\"12\">{}\n</svg>",
            self.body
        )
    }
}

/// The range of an angle along the path, and of a joint.
pub const ALONG: [f64; 2] = [0.0, TAU];
pub const JOINT: [f64; 2] = [-PI, PI];

/// Where on the path the tip is, and where the last link points, both in `[0, 2 pi)`.
pub fn unrolled(q: &[f64; 3]) -> [f64; 2] {
    let tip = corners(q)[3];
    let along = (tip[1] - PATH.0[1]).atan2(tip[0] - PATH.0[0]);
    [along.rem_euclid(TAU), (q[0] + q[1] + q[2]).rem_euclid(TAU)]
}

/// Samples on contact with the elbow on one side, by place on the path and direction of the last link.
pub fn dots(samples: &[Sample<3>], on_contact: &[bool]) -> Vec<([f64; 2], bool)> {
    samples
        .iter()
        .zip(on_contact)
        .filter(|(sample, on)| **on && sample.joints[1] > 0.0)
        .map(|(sample, _)| (unrolled(&sample.joints), sample.collides))
        .collect()
}

/// Edge of a cell of a map.
const CELL: f64 = SIDE / CELLS as f64;

/// The lower left corner of a cell of a map, whose own is at `left` and `low`.
fn corner([left, low]: [f64; 2], x: usize, y: usize) -> [f64; 2] {
    [left + x as f64 * CELL, low - y as f64 * CELL]
}
