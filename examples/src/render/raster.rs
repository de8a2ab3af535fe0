//! Triangles onto pixels, the nearest in front.

use super::colours::{INK, Rgb};
use super::image::Image;

/// Samples a pixel along each axis: two by two smooth the edges at four times the work.
const SAMPLES: usize = 2;

/// A light and its distance, pixel by pixel. Depth grows towards the viewer.
#[derive(Clone)]
pub(super) struct Canvas {
    width: usize,
    height: usize,
    colour: Vec<[f32; 3]>,
    depth: Vec<f32>,
}

/// A point on the canvas: x to the right and y down in samples, then depth.
pub(super) type Spot = [f64; 3];

impl Canvas {
    /// A white canvas for a picture of this size.
    pub(super) fn new(width: u32, height: u32) -> Self {
        let [width, height] = [width, height].map(|side| side as usize * SAMPLES);
        let len = width * height;
        Canvas { width, height, colour: vec![[1.0; 3]; len], depth: vec![f32::NEG_INFINITY; len] }
    }

    /// Width and height in samples.
    pub(super) fn size(&self) -> [f64; 2] {
        [self.width as f64, self.height as f64]
    }

    /// Draws a triangle that faces either way; `colour` gets the weights of the three corners.
    pub(super) fn triangle(&mut self, corners: [Spot; 3], colour: impl Fn([f64; 3]) -> [f32; 3]) {
        let [a, b, c] = corners;
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if !area.is_finite() || area.abs() < f64::MIN_POSITIVE {
            return;
        }
        let range = |axis: usize, side: usize| {
            let low = a[axis].min(b[axis]).min(c[axis]) - 0.5;
            let high = a[axis].max(b[axis]).max(c[axis]) - 0.5;
            low.ceil().max(0.0) as usize..((high.floor() + 1.0).max(0.0) as usize).min(side)
        };
        let facing = area.signum();
        let columns = range(0, self.width);
        for y in range(1, self.height) {
            let sample_y = y as f64 + 0.5;
            for x in columns.clone() {
                let sample_x = x as f64 + 0.5;
                // By the area: most samples of a small triangle's box lie outside of it, so the division waits.
                let part = |p: Spot, q: Spot| (q[0] - p[0]) * (sample_y - p[1]) - (q[1] - p[1]) * (sample_x - p[0]);
                let parts = [part(b, c), part(c, a), part(a, b)];
                if parts.iter().any(|&part| part * facing < 0.0) {
                    continue;
                }
                let weights = parts.map(|part| part / area);
                let depth = (weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2]) as f32;
                let at = x + self.width * y;
                if depth > self.depth[at] {
                    self.depth[at] = depth;
                    self.colour[at] = colour(weights);
                }
            }
        }
    }

    /// Darkens the samples beside which the scene falls back by more than `step`: outlines of what stands in front.
    pub(super) fn outline(&mut self, step: f32) {
        const STRENGTH: f32 = 0.55;
        let ink = INK.map(|c| f32::from(c) / 255.0);
        let falls = |at: usize, other: usize| self.depth[at] - self.depth[other] > step;
        let mut marked = Vec::new();
        for y in 0..self.height {
            for x in 0..self.width {
                let at = x + self.width * y;
                if self.depth[at].is_finite()
                    && ((x >= SAMPLES && falls(at, at - SAMPLES))
                        || (x + SAMPLES < self.width && falls(at, at + SAMPLES))
                        || (y >= SAMPLES && falls(at, at - SAMPLES * self.width))
                        || (y + SAMPLES < self.height && falls(at, at + SAMPLES * self.width)))
                {
                    marked.push(at);
                }
            }
        }
        for at in marked {
            for (c, ink) in self.colour[at].iter_mut().zip(ink) {
                *c += (ink - *c) * STRENGTH;
            }
        }
    }

    /// The picture: the mean of the samples of each pixel.
    pub(super) fn picture(&self) -> Image {
        let [width, height] = [self.width, self.height].map(|side| (side / SAMPLES) as u32);
        let mut image = Image::new(width, height, [255; 3]);
        for y in 0..height {
            for x in 0..width {
                let mut sum = [0.0; 3];
                for sample in 0..SAMPLES * SAMPLES {
                    let column = x as usize * SAMPLES + sample % SAMPLES;
                    let row = y as usize * SAMPLES + sample / SAMPLES;
                    for (sum, c) in sum.iter_mut().zip(self.colour[column + self.width * row]) {
                        *sum += c;
                    }
                }
                image.set(x, y, to_rgb(sum.map(|c| c / (SAMPLES * SAMPLES) as f32)));
            }
        }
        image
    }
}

pub(super) fn to_rgb(colour: [f32; 3]) -> Rgb {
    colour.map(|c| (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8) // to the nearest: `round` is a call
}

pub(super) fn from_rgb(colour: Rgb) -> [f32; 3] {
    colour.map(|c| f32::from(c) / 255.0)
}
