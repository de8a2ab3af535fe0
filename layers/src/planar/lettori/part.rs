//! A part and its layers: what the audit looks at is what is printed.

use super::layers::{Layered, Stand};
use crate::planar::flat::{FlatLayers, of_sections};
use crate::planar::{CutPlane, MAX_LENGTH_MM, PlaneError, PlaneFrame, Region, Solid, slice};
use nalgebra::{Point3, Vector3};

/// A flat layer of a part.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeLayer {
    /// Where it begins, along the direction of its part.
    pub low_mm: f64,
    /// Where it ends.
    pub high_mm: f64,
    /// What is printed: the section in its middle, without features that are left out, in [`VolumePart::frame`].
    pub section: Region,
}

/// A part that is printed in flat layers.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumePart {
    /// Its mesh, in the place where it belongs.
    pub solid: Solid,
    /// The direction in which its layers are stacked, of length 1.
    pub direction: Vector3<f64>,
    /// Its base plane: the distance from the origin along the direction.
    pub base_mm: f64,
    /// The separation that made it, by number in [`super::VolumeDecomposition::separations`]; `None` for the part on the plate.
    pub separation: Option<usize>,
    /// The frame of its sections, in its base plane.
    pub frame: PlaneFrame,
    /// Its layers, from the base plane up.
    pub layers: Vec<VolumeLayer>,
    /// Volume of its layers that nothing carries: 0 unless the decomposition is [`super::Stuck`].
    pub overhang_mm3: f64,
}

impl VolumePart {
    /// A part sliced at given heights, with nothing known about its overhang.
    ///
    /// # Arguments
    /// * `direction`: of any length.
    /// * `tops_mm`: where layers end, along the direction, rising from `base_mm` on.
    ///
    /// # Errors
    /// [`PlaneError`] for a direction without length, or a base that is not finite.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::nalgebra::Vector3;
    /// use curvlay_layers::planar::{Solid, VolumePart};
    /// let corners = [[0.0, 0.0, 0.0], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0], [0.0, 0.0, 6.0]].map(Into::into);
    /// let solid = Solid::new(&corners, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])?;
    /// let part = VolumePart::sliced(solid, &Vector3::z(), 0.0, &[2.0, 6.0])?;
    /// // Sections in the middle of layers, 1 mm and 4 mm up.
    /// let areas: Vec<f64> = part.layers.iter().map(|layer| layer.section.area()).collect();
    /// assert!((areas[0] - 12.5).abs() < 1e-6 && (areas[1] - 2.0).abs() < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn sliced(solid: Solid, direction: &Vector3<f64>, base_mm: f64, tops_mm: &[f64]) -> Result<Self, PlaneError> {
        let direction = CutPlane::through(&Point3::origin(), direction)?.normal();
        let base = CutPlane::through(&Point3::from(direction * base_mm), &direction)?;
        let is_near = |height: &f64| height.abs() <= MAX_LENGTH_MM;
        if let Some(&offset) = std::iter::once(&base_mm).chain(tops_mm).find(|height| !is_near(height)) {
            return Err(PlaneError::Unusable { normal: direction.into(), offset });
        }
        let frame = PlaneFrame::of(&base);
        let mut low_mm = base_mm;
        let layer = |&high_mm: &f64| {
            let plane = base.moved((low_mm + high_mm) / 2.0 - base.offset());
            let layer = VolumeLayer { low_mm, high_mm, section: Region::of(&slice(&solid, &plane, &frame)) };
            low_mm = high_mm;
            layer
        };
        let layers = tops_mm.iter().map(layer).collect();
        Ok(VolumePart { solid, direction, base_mm, separation: None, frame, layers, overhang_mm3: 0.0 })
    }

    /// The part with the layers that it was analysed by.
    pub(super) fn of(solid: Solid, layered: Layered, stand: Stand, separation: Option<usize>) -> Self {
        let overhang_mm3 = layered.overhang_mm3();
        let layers = layered.layers.into_iter();
        VolumePart {
            solid,
            direction: stand.direction,
            base_mm: stand.base,
            separation,
            frame: layered.frame,
            layers: layers.map(|of| VolumeLayer { low_mm: of.low, high_mm: of.high, section: of.section }).collect(),
            overhang_mm3,
        }
    }

    /// Its layers as surfaces.
    ///
    /// # Cost
    /// The square of the corners of the section, for each layer.
    pub fn flat_layers(&self) -> FlatLayers {
        let sections = self.layers.iter().map(|layer| ([layer.low_mm, layer.high_mm], layer.section.clone()));
        of_sections(self.direction, self.frame, sections)
    }
}
