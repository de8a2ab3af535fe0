//! Layer by layer: what of each section the layers below carry.
//!
//! Lettori et al. 2022, "Main idea" and Fig. 1 and 2. The layer `l_i` carries what its supported area, offset by the layer height
//! over the tangent of the overhang angle, covers of `l_{i+1}`; that part of `l_{i+1}` is offset for the next layer, and so on to the
//! last one.
//! Departures: sections lie in the middle of layers, and the offset is that of the distance between two of them; parts that are
//! printed before carry as well.

use super::features::{Feature, close_small};
use super::options::VolumeOptions;
use crate::planar::{CutPlane, PlaneFrame, Region, Solid, slice};
use nalgebra::{Point2, Point3, Vector3};

/// A layer of a part.
#[derive(Clone, Debug)]
pub(super) struct Layer {
    /// Where it begins and ends, along the direction.
    pub low: f64,
    pub high: f64,
    pub section: Region,
    /// What of the section is carried.
    pub supported: Region,
    /// What is not.
    pub overhang: Region,
    /// What carries this layer: the supported area below, grown.
    pub carrier: Region,
}

impl Layer {
    pub fn middle(&self) -> f64 {
        (self.low + self.high) / 2.0
    }
}

/// A part in layers along its direction.
#[derive(Clone, Debug)]
pub(super) struct Layered {
    pub direction: Vector3<f64>,
    pub frame: PlaneFrame,
    pub layers: Vec<Layer>,
    pub features: Vec<Feature>,
}

/// Where a part stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stand {
    pub direction: Vector3<f64>,
    /// The base plane, along the direction.
    pub base: f64,
    /// On the plate, which carries all of the first layer; else on parts that are printed before.
    pub on_plate: bool,
}

impl Layered {
    /// A point of a section, in space.
    pub fn place(&self, p: &Point2<f64>, height: f64) -> Point3<f64> {
        let flat = self.frame.place(p);
        flat + self.direction * (height - flat.coords.dot(&self.direction))
    }

    /// The volume that nothing carries.
    pub fn overhang_mm3(&self) -> f64 {
        self.layers
            .iter()
            .map(|layer| layer.overhang.area() * (layer.high - layer.low))
            .fold(0.0, |sum, volume| sum + volume)
    }
}

/// Slices a part and finds what of each layer is carried.
pub(super) fn analyse(solid: &Solid, stand: &Stand, earlier: &[&Solid], options: &VolumeOptions) -> Layered {
    let direction = stand.direction;
    let base = CutPlane::through(&Point3::from(direction * stand.base), &direction)
        .unwrap_or_else(|error| unreachable!("the direction of a part has a length: {error}"));
    let frame = PlaneFrame::of(&base);
    let cut = |solid: &Solid, height: f64| slice(solid, &base.moved(height - base.offset()), &frame);
    let before = |height: f64| {
        let is_there = |other: &&&Solid| {
            let [low, high] = other.extent(&direction);
            low <= height && height <= high
        };
        Region::of(&earlier.iter().filter(is_there).flat_map(|other| cut(other, height)).collect::<Vec<_>>())
    };
    let [_, top] = solid.extent(&direction);
    let mut layers: Vec<Layer> = Vec::new();
    let mut features = Vec::new();
    let mut low = stand.base;
    // What is left above the last layer is no layer if it is only as high as rounding.
    while top - low > 1e-6 * options.layer_mm {
        let height = layer_height(|height| Region::of(&cut(solid, height)).area(), low, top, options);
        let high = low + height;
        let middle = (low + high) / 2.0;
        let mut section = Region::of(&cut(solid, middle));
        if options.min_feature_mm > 0.0 {
            section = close_small(&section, options.min_feature_mm, [low, high], &mut features);
        }
        let (below, distance) = match layers.last() {
            Some(last) => (last.supported.union(&before(last.middle())), middle - last.middle()),
            None if stand.on_plate => (section.clone(), height),
            None => (before(stand.base - height / 2.0), height),
        };
        let below = below.simplified(options.tolerance_mm / 20.0);
        let reach = distance / options.angle.tan();
        let carrier = below.grown(reach + options.tolerance_mm);
        let speck = options.tolerance_mm * options.tolerance_mm;
        let overhang = section.difference(&carrier).without_specks(speck);
        let supported = section.intersection(&below.grown(reach));
        layers.push(Layer { low, high, section, supported, overhang, carrier });
        low = high;
    }
    Layered { direction, frame, layers, features }
}

/// The height of the layer that begins at `low`: halved from the greatest one while the area changes too much.
fn layer_height(area: impl Fn(f64) -> f64, low: f64, top: f64, options: &VolumeOptions) -> f64 {
    let mut height = options.layer_mm.min(top - low);
    while height / 2.0 >= options.min_layer_mm {
        let [bottom, upper] = [0.02, 0.98].map(|share| area(low + share * height));
        if (bottom - upper).abs() <= options.area_change * bottom.max(upper) {
            break;
        }
        height /= 2.0;
    }
    height
}
