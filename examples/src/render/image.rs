//! A picture in memory: rectangles, letters, legend, PNG.

use super::colours::{INK, MISSED, Rgb, layer_colour};
use super::glyphs;

/// A picture; the pixel (0, 0) is at the top left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    width: u32,
    height: u32,
    pixels: Vec<Rgb>,
}

/// Pixels a dot of a letter takes.
const DOT: u32 = 2;

impl Image {
    /// Longest side, in pixels: what is longer is cut to this.
    pub const MAX_SIDE: u32 = 8192;

    /// A picture of one colour, at least one pixel wide and high.
    pub fn new(width: u32, height: u32, colour: Rgb) -> Self {
        let [width, height] = [width, height].map(|side| side.clamp(1, Self::MAX_SIDE));
        Image { width, height, pixels: vec![colour; width as usize * height as usize] }
    }

    /// Width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The colour of a pixel; `None` outside.
    pub fn get(&self, x: u32, y: u32) -> Option<Rgb> {
        (x < self.width && y < self.height).then(|| self.pixels[(x + self.width * y) as usize])
    }

    /// Colours a pixel; outside nothing happens.
    pub fn set(&mut self, x: u32, y: u32, colour: Rgb) {
        if x < self.width && y < self.height {
            self.pixels[(x + self.width * y) as usize] = colour;
        }
    }

    /// Fills a rectangle, or what of it lies inside.
    pub fn fill(&mut self, [x, y]: [u32; 2], [width, height]: [u32; 2], colour: Rgb) {
        for row in y..y.saturating_add(height).min(self.height) {
            for column in x..x.saturating_add(width).min(self.width) {
                self.set(column, row, colour);
            }
        }
    }

    /// Copies `other` with its top left corner at `[x, y]`, or what of it lies inside.
    pub fn paste(&mut self, [x, y]: [u32; 2], other: &Image) {
        for row in 0..other.height {
            for column in 0..other.width {
                self.set(x + column, y + row, other.pixels[(column + other.width * row) as usize]);
            }
        }
    }

    /// Writes small letters (digits, a to z and `.,:-=/%`) with their top left corner at `[x, y]`.
    pub fn write(&mut self, [x, y]: [u32; 2], text: &str, colour: Rgb) {
        for (i, letter) in text.chars().enumerate() {
            let left = x + i as u32 * (glyphs::WIDTH + 1) * DOT;
            for (row, dots) in glyphs::glyph(letter).into_iter().enumerate() {
                for column in (0..glyphs::WIDTH).filter(|column| dots >> (glyphs::WIDTH - 1 - column) & 1 == 1) {
                    self.fill([left + column * DOT, y + row as u32 * DOT], [DOT, DOT], colour);
                }
            }
        }
    }

    /// Width and height of `text` in pixels.
    pub fn text_size(text: &str) -> [u32; 2] {
        let letters = text.chars().count() as u32;
        [(letters * (glyphs::WIDTH + 1)).saturating_sub(1) * DOT, glyphs::HEIGHT * DOT]
    }

    /// The same picture with a bar of the layer colours on its right, and a swatch for missed cells if there are any.
    pub fn with_legend(&self, layers: u32, missed: usize) -> Image {
        const BAR: u32 = 18;
        const GAP: u32 = 8;
        let tick_width = Self::text_size(&layers.to_string())[0];
        let missed_text = format!("missed {missed}");
        let wide = if missed > 0 { BAR + GAP + Self::text_size(&missed_text)[0] } else { 0 };
        let legend = wide.max(BAR + 2 * GAP + tick_width).max(Self::text_size("layer")[0]) + 2 * GAP;
        let mut image = Image::new(self.width + legend, self.height, [255; 3]);
        image.paste([0, 0], self);

        let text_height = Self::text_size("")[1];
        let left = self.width + GAP;
        let top = 2 * GAP + text_height + GAP;
        let foot = if missed > 0 { BAR + 2 * GAP } else { 0 };
        let Some(height) = self.height.checked_sub(top + foot + 2 * GAP).filter(|&height| height > text_height) else {
            return image;
        };
        image.write([left, GAP + text_height / 2], "layer", INK);
        if layers > 0 {
            let row_of = |layer: u32| (u64::from(layers - layer) * u64::from(height) / u64::from(layers)) as u32;
            for row in 0..height {
                let layer = match height.checked_sub(layers) {
                    Some(_) => layers - (u64::from(row) * u64::from(layers) / u64::from(height)) as u32,
                    // More layers than rows: the first and the last are there all the same.
                    None => layers - (u64::from(row) * u64::from(layers - 1) / u64::from(height - 1)) as u32,
                };
                image.fill([left, top + row], [BAR, 1], layer_colour(layer, layers));
            }
            let room = (height / (3 * text_height)).max(1);
            let mut above = u32::MAX;
            for layer in ticks(layers, room) {
                let row = top + (row_of(layer) + row_of(layer - 1)) / 2;
                let text_top = row.saturating_sub(text_height / 2);
                if text_top + text_height + GAP < above {
                    image.fill([left + BAR, row], [GAP / 2, 2], INK);
                    image.write([left + BAR + GAP, text_top], &layer.to_string(), INK);
                    above = text_top;
                }
            }
        }
        if missed > 0 {
            let y = top + height + 2 * GAP;
            image.fill([left, y], [BAR, BAR], MISSED);
            image.write([left + BAR + GAP, y + (BAR - text_height) / 2], &missed_text, INK);
        }
        image
    }

    /// The picture as a PNG file.
    pub fn to_png(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder
            .write_header()
            .and_then(|mut writer| writer.write_image_data(self.pixels.as_flattened()))
            .expect("a picture of at least a pixel goes into memory");
        bytes
    }
}

/// The first layer, the last one, and round numbers between them: at most about `room` in all.
fn ticks(layers: u32, room: u32) -> Vec<u32> {
    let least = layers.div_ceil(room);
    let decade = |n: u32| 10_u32.pow(n.max(1).ilog10());
    let step = [1, 2, 5, 10].map(|k| k * decade(least)).into_iter().find(|&step| step >= least).unwrap_or(layers);
    let round = (1..=layers / step).map(|k| k * step);
    // The last layer is always there, so a round number close under it would be written over.
    let between = round.filter(|&layer| layer > 1 + step / 3 && layer + step / 2 < layers);
    let mut ticks = vec![1];
    ticks.extend(between);
    if layers > 1 {
        ticks.push(layers);
    }
    ticks
}
