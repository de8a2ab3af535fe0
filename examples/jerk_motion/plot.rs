//! Curves over time, a panel a joint.

use curvlay_examples::render::{INK, Image, Rgb};
use curvlay_trajectory::Trajectory;

const WIDTH: u32 = 900;
const PANEL: u32 = 88;
const LEFT: u32 = 96;
const GAP: u32 = 12;
const FRAME: Rgb = [215, 219, 224];
/// Of the motion before and of that after.
const COLOURS: [Rgb; 2] = [[140, 150, 165], [232, 98, 20]];

/// What is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Curve {
    Angle,
    Jerk,
}

/// Motions before and after on top of one another; the second is drawn over the first.
pub fn draw<const N: usize>(before: &[Trajectory<N>], after: &[Trajectory<N>], curve: Curve) -> Vec<u8> {
    let height = N as u32 * (PANEL + GAP) + GAP;
    let mut image = Image::new(WIDTH, height, [255; 3]);
    let columns = (WIDTH - LEFT - GAP) as usize;
    for joint in 0..N {
        let top = GAP + joint as u32 * (PANEL + GAP);
        let spans = [before, after].map(|motion| ranges(motion, joint, curve, columns));
        let all = || spans.iter().flatten().flatten();
        let least = all().map(|range| range[0]).fold(f64::INFINITY, f64::min);
        let most = all().map(|range| range[1]).fold(f64::NEG_INFINITY, f64::max);
        // A flat curve lies in the middle.
        let (least, most) = if most - least > 1e-9 { (least, most) } else { (least - 1.0, most + 1.0) };
        image.fill([LEFT, top], [columns as u32, PANEL], FRAME);
        image.fill([LEFT + 1, top + 1], [columns as u32 - 2, PANEL - 2], [255; 3]);
        image.write([4, top + PANEL / 2 - 7], &format!("q{}", joint + 1), INK);
        image.write([34, top], &short(most), INK);
        image.write([34, top + PANEL - 14], &short(least), INK);
        let row = |value: f64| ((most - value) / (most - least) * f64::from(PANEL - 3)).round() as u32 + 1;
        for (span, colour) in spans.iter().zip(COLOURS) {
            for (column, range) in span.iter().enumerate() {
                let Some([low, high]) = *range else { continue };
                let (first, last) = (row(high), row(low));
                image.fill([LEFT + column as u32, top + first], [1, (last - first).max(1)], colour);
            }
        }
    }
    image.to_png()
}

/// Least and greatest value in each column of time; `None` where no motion is.
fn ranges<const N: usize>(
    motion: &[Trajectory<N>],
    joint: usize,
    curve: Curve,
    columns: usize,
) -> Vec<Option<[f64; 2]>> {
    /// Looks within a column.
    const LOOKS: usize = 12;
    let whole: f64 = motion.iter().map(|t| t.span().1 - t.span().0).sum();
    let mut found = vec![None; columns];
    let mut start = 0.0;
    for trajectory in motion {
        let (from, to) = trajectory.span();
        let looks = ((to - from) / whole * (columns * LOOKS) as f64).ceil() as usize;
        for k in 0..=looks {
            let time = from + (to - from) * k as f64 / looks.max(1) as f64;
            let state = trajectory.at(time);
            let value = if curve == Curve::Angle { state.position[joint] } else { state.jerk[joint] };
            let column = (((start + time - from) / whole * columns as f64) as usize).min(columns - 1);
            let [low, high] = found[column].unwrap_or([value; 2]);
            found[column] = Some([f64::min(low, value), f64::max(high, value)]);
        }
        start += to - from;
    }
    found
}

/// Few digits, so that it fits.
fn short(value: f64) -> String {
    match value.abs() {
        size if size >= 100.0 => format!("{value:.0}"),
        size if size >= 10.0 => format!("{value:.1}"),
        _ => format!("{value:.2}"),
    }
}
