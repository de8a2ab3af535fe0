//! Line plots as SVG, for the report.

use crate::html::escaped;
use std::fmt::Write;

/// Size of the drawing, and the margins around the plot: left, top, right, bottom.
const SIZE: [f64; 2] = [860.0, 300.0];
const MARGIN: [f64; 4] = [64.0, 14.0, 14.0, 44.0];

/// About so many ticks an axis.
const TICKS: f64 = 6.0;

/// Points of a line beyond this number are drawn as the lowest and the highest of each column of pixels.
const DENSE: usize = 2 * SIZE[0] as usize;

/// Lines over a common axis. Points that are not finite break a line.
#[derive(Clone, Debug, Default)]
pub struct Plot {
    x_label: String,
    y_label: String,
    lines: Vec<Line>,
}

#[derive(Clone, Debug)]
struct Line {
    name: String,
    colour: [u8; 3],
    points: Vec<[f64; 2]>,
}

impl Plot {
    /// A plot without lines, its axes named with their units.
    ///
    /// # Example
    /// ```
    /// use curvlay_examples::plot::Plot;
    /// let mut plot = Plot::new("path in mm", "turn in degrees");
    /// plot.line("before", [150, 150, 150], [[0.0, 1.0], [10.0, 24.0]]);
    /// assert!(plot.to_svg().contains(">turn in degrees</text>"));
    /// ```
    pub fn new(x_label: &str, y_label: &str) -> Self {
        Plot { x_label: x_label.to_owned(), y_label: y_label.to_owned(), lines: Vec::new() }
    }

    /// Adds a line through points of rising x.
    pub fn line(&mut self, name: &str, colour: [u8; 3], points: impl IntoIterator<Item = [f64; 2]>) -> &mut Self {
        self.lines.push(Line { name: name.to_owned(), colour, points: points.into_iter().collect() });
        self
    }

    /// The names of the lines.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.lines.iter().map(|line| line.name.as_str())
    }

    /// The drawing, an `svg` element.
    pub fn to_svg(&self) -> String {
        let [width, height] = SIZE;
        let [left, top, right, bottom] = MARGIN;
        let axes = [0, 1].map(|axis| Axis::over(self.lines.iter().flat_map(|line| &line.points).map(|p| p[axis])));
        let x = |value: f64| left + axes[0].share(value) * (width - left - right);
        let y = |value: f64| height - bottom - axes[1].share(value) * (height - top - bottom);
        let mut svg = format!("<svg viewBox=\"0 0 {width} {height}\" role=\"img\">");
        for tick in axes[0].ticks() {
            let (at, low) = (x(tick), height - bottom);
            let _ = write!(svg, "\n<path class=\"grid\" d=\"M{at:.1} {top}V{low}\"/>");
            let _ =
                write!(svg, "<text class=\"x\" x=\"{at:.1}\" y=\"{}\">{}</text>", low + 18.0, axes[0].written(tick));
        }
        for tick in axes[1].ticks() {
            let at = y(tick);
            let _ = write!(svg, "\n<path class=\"grid\" d=\"M{left} {at:.1}H{}\"/>", width - right);
            let _ = write!(
                svg,
                "<text class=\"y\" x=\"{}\" y=\"{:.1}\">{}</text>",
                left - 7.0,
                at + 4.0,
                axes[1].written(tick)
            );
        }
        for line in &self.lines {
            let [r, g, b] = line.colour;
            let _ = write!(svg, "\n<path class=\"line\" stroke=\"#{r:02x}{g:02x}{b:02x}\" d=\"");
            let mut pen = 'M';
            for [at, value] in line.thinned(&axes[0]) {
                if at.is_finite() && value.is_finite() {
                    let _ = write!(svg, "{pen}{:.1} {:.1}", x(at), y(value));
                    pen = 'L';
                } else {
                    pen = 'M';
                }
            }
            svg += "\"/>";
        }
        let middle = (height + top - bottom) / 2.0;
        let _ = write!(
            svg,
            "\n<text class=\"x\" x=\"{}\" y=\"{}\">{}</text><text class=\"x\" transform=\"translate(14 {middle}) rotate(-90)\">{}</text></svg>",
            (width + left - right) / 2.0,
            height - 6.0,
            escaped(&self.x_label),
            escaped(&self.y_label)
        );
        svg
    }

    /// Which line has which colour, as HTML.
    pub fn legend(&self) -> String {
        let mut html = String::new();
        for Line { name, colour: [r, g, b], .. } in &self.lines {
            let name = escaped(name);
            let _ =
                write!(html, "<span class=\"key\"><i style=\"background:#{r:02x}{g:02x}{b:02x}\"></i>{name}</span> ");
        }
        html
    }
}

impl Line {
    /// The points, or the lowest and the highest of each column of pixels.
    fn thinned(&self, axis: &Axis) -> Vec<[f64; 2]> {
        if self.points.len() <= DENSE {
            return self.points.clone();
        }
        let column = |p: &[f64; 2]| (axis.share(p[0]) * SIZE[0]) as i64;
        let extremes = |points: &[[f64; 2]]| {
            let by_value = |a: &&[f64; 2], b: &&[f64; 2]| a[1].total_cmp(&b[1]);
            let mut pair = [points.iter().min_by(by_value), points.iter().max_by(by_value)];
            pair.sort_by(|a, b| a.map(|p| p[0]).partial_cmp(&b.map(|p| p[0])).unwrap_or(std::cmp::Ordering::Equal));
            pair.into_iter().flatten().copied().collect::<Vec<_>>()
        };
        self.points.chunk_by(|a, b| column(a) == column(b)).flat_map(extremes).collect()
    }
}

/// A range in even, round steps.
struct Axis {
    low: f64,
    high: f64,
    step: f64,
}

impl Axis {
    fn over(values: impl Iterator<Item = f64>) -> Axis {
        let finite = values.filter(|value| value.is_finite());
        let (least, most) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        let (least, most) = if least < most { (least, most) } else { (least.min(0.0), most.max(1.0)) };
        let (least, most) = if least.is_finite() && most.is_finite() { (least, most) } else { (0.0, 1.0) };
        let rough = (most - least) / TICKS;
        let power = 10_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|k| k * power).into_iter().find(|&step| step >= rough).unwrap_or(rough);
        Axis { low: (least / step).floor() * step, high: (most / step).ceil() * step, step }
    }

    /// Where a value lies, 0 at the low end, 1 at the high one.
    fn share(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    fn ticks(&self) -> impl Iterator<Item = f64> {
        let (low, step) = (self.low, self.step);
        let steps = ((self.high - low) / step).round() as u32;
        (0..=steps).map(move |k| low + f64::from(k) * step)
    }

    fn written(&self, tick: f64) -> String {
        let digits = (-self.step.log10().floor()).clamp(0.0, 12.0) as usize;
        // No minus zero.
        let tick = if tick.abs() < self.step / 2.0 { 0.0 } else { tick };
        format!("{tick:.digits$}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_have_round_ticks_around_all_values() {
        for (values, ticks) in [
            (vec![0.3, 17.0], "0 5 10 15 20"),
            (vec![-0.011, 0.02], "-0.02 -0.01 0.00 0.01 0.02"),
            (vec![4.0, 4.0], "0 1 2 3 4"),
            (vec![f64::NAN], "0.0 0.2 0.4 0.6 0.8 1.0"),
            (vec![], "0.0 0.2 0.4 0.6 0.8 1.0"),
        ] {
            let axis = Axis::over(values.iter().copied());
            let written: Vec<String> = axis.ticks().map(|tick| axis.written(tick)).collect();
            assert_eq!(written.join(" "), ticks, "{values:?}");
        }
    }

    #[test]
    fn dense_lines_keep_their_peaks() {
        let peak = |k: u32| if k == 77_777 { 9.0 } else { (f64::from(k) * 0.1).sin() };
        let mut plot = Plot::new("", "");
        plot.line("", [0; 3], (0..100_000).map(|k| [f64::from(k), peak(k)]));
        let axis = Axis::over((0..100_000).map(f64::from));
        let thinned = plot.lines[0].thinned(&axis);
        assert!(thinned.len() <= 2 * SIZE[0] as usize + 2);
        assert!(thinned.contains(&[77_777.0, 9.0]));
        assert!(thinned.windows(2).all(|pair| pair[0][0] <= pair[1][0]));
    }

    #[test]
    fn gaps_break_lines() {
        let mut plot = Plot::new("x", "y");
        plot.line("a", [255, 0, 16], [[0.0, 0.0], [1.0, 1.0], [2.0, f64::NAN], [3.0, 1.0], [4.0, 0.0]]);
        let svg = plot.to_svg();
        let line = svg.split("class=\"line\"").nth(1).unwrap();
        assert_eq!((line.matches('M').count(), line.matches('L').count()), (2, 2));
        assert!(svg.contains("stroke=\"#ff0010\"") && plot.legend().contains("#ff0010") && plot.names().eq(["a"]));
    }
}
