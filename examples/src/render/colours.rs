//! Colours: a ramp whose lightness rises evenly to the eye, and its bands for layers.
//!
//! The ramp is a straight line in lightness and hue of Oklab (B. Ottosson, "A perceptual color space for image
//! processing", 2020), so a picture of it in grey still shows the order.

/// Red, green and blue, 0 to 255 (sRGB).
pub type Rgb = [u8; 3];

/// Cells without a layer: a colour that the ramp does not come near.
pub const MISSED: Rgb = [232, 0, 150];
/// Outlines and letters.
pub const INK: Rgb = [38, 44, 52];
/// The platform.
pub const PLATFORM: Rgb = [233, 236, 240];

/// Lightness and hue (degrees) at both ends, and chroma: from deep violet through blue and green to yellow.
const LIGHTNESS: [f64; 2] = [0.40, 0.91];
const HUE: [f64; 2] = [292.0, 96.0];
const CHROMA: f64 = 0.135;

/// Bands that the eye can still distinguish on a picture of a thousand pixels.
const BANDS: u32 = 48;
/// How much darker every other band is, in lightness. Half of it drowns in the shading, twice of it hides the ramp.
const BAND_STEP: f64 = 0.075;

/// The colour of `t`, from dark (0) to light (1); anything outside is taken for the nearer end.
///
/// # Example
/// ```
/// use curvlay_examples::render::ramp;
/// let light = |t: f64| ramp(t).iter().map(|&c| u32::from(c)).sum::<u32>();
/// assert!((0..10).all(|i| light(f64::from(i) / 10.0) < light(f64::from(i + 1) / 10.0)));
/// ```
pub fn ramp(t: f64) -> Rgb {
    shifted_ramp(t, 0.0)
}

/// The colour of a layer, counted from 1, out of `layers`; layer 0 is [`MISSED`]. Every other layer is darker, or
/// every other group of layers where there are too many of them.
pub fn layer_colour(layer: u32, layers: u32) -> Rgb {
    if layer == 0 {
        return MISSED;
    }
    let t = f64::from(layer - 1) / f64::from(layers.max(2) - 1);
    let band = (layer - 1) / layers.div_ceil(BANDS).max(1);
    shifted_ramp(t, if band.is_multiple_of(2) { 0.0 } else { -BAND_STEP })
}

fn shifted_ramp(t: f64, lightness: f64) -> Rgb {
    let t = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) };
    let between = |[a, b]: [f64; 2]| a + (b - a) * t;
    let hue = between(HUE).to_radians();
    from_oklab([between(LIGHTNESS) + lightness, CHROMA * hue.cos(), CHROMA * hue.sin()])
}

/// From Oklab to sRGB; colours that a screen cannot show are cut off at what it can.
fn from_oklab([l, a, b]: [f64; 3]) -> Rgb {
    let cones = [
        l + 0.396_337_777_4 * a + 0.215_803_757_3 * b,
        l - 0.105_561_345_8 * a - 0.063_854_172_8 * b,
        l - 0.089_484_177_5 * a - 1.291_485_548_0 * b,
    ]
    .map(|c| c * c * c);
    let [long, medium, short] = cones;
    [
        4.076_741_662_1 * long - 3.307_711_591_3 * medium + 0.230_969_929_2 * short,
        -1.268_438_004_6 * long + 2.609_757_401_1 * medium - 0.341_319_396_5 * short,
        -0.004_196_086_3 * long - 0.703_418_614_7 * medium + 1.707_614_701_0 * short,
    ]
    .map(|c| {
        let c = c.clamp(0.0, 1.0);
        let encoded = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
        (encoded * 255.0).round() as u8
    })
}
