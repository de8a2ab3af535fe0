//! Reads a build: the model at once, layers one by one.

mod attributes;
mod data;
mod error;
mod layer;
mod model;
mod package;

pub use data::{LayerPart, ReadSegment};
pub use error::ReadBuildError;

use super::names::{LAYER_RELATIONSHIP, MODEL_RELATIONSHIP};
use super::profile::Profile;
use model::Model;
use package::Package;
use std::io::{Read, Seek};

/// A build that is open: toolpaths of six axes (`polyline6d`), with modifiers of width, height and speed that are constant or linear.
///
/// It refuses what the extension has a consumer refuse: extensions that are required and not known here, modifiers that it cannot follow,
/// segments of another type, names that lead nowhere. A quaternion is refused from a length of 1e-3 beside 1 on.
pub struct BuildReader<R> {
    package: Package<R>,
    model: Model,
}

impl<R: Read + Seek> BuildReader<R> {
    /// Opens a package and reads its model.
    ///
    /// # Errors
    /// [`ReadBuildError`]. Never panics; a part of more than 256 MiB or 16,777,216 elements is refused.
    ///
    /// # Cost
    /// Linear in the size of the model.
    pub fn open(reader: R) -> Result<Self, ReadBuildError> {
        let mut package = Package::open(reader)?;
        let models = package.targets("", MODEL_RELATIONSHIP)?;
        let none = || ReadBuildError::NoRelationship {
            from: "the package".to_owned(),
            kind: MODEL_RELATIONSHIP,
            target: "a model".to_owned(),
        };
        let part = models.into_iter().next().ok_or_else(none)?;
        let model = model::read(&part, &package.text(&part)?)?;
        let bound = package.targets(&part, LAYER_RELATIONSHIP)?;
        if let Some(layer) = model.layers.iter().find(|layer| !bound.contains(&layer.path)) {
            let target = layer.path.clone();
            return Err(ReadBuildError::NoRelationship { from: part, kind: LAYER_RELATIONSHIP, target });
        }
        Ok(BuildReader { package, model })
    }

    /// The profiles of its segments.
    pub fn profiles(&self) -> &[Profile] {
        &self.model.profiles
    }

    /// Its layers, in the order of the print.
    pub fn layers(&self) -> &[LayerPart] {
        &self.model.layers
    }

    /// Reads the layer of [`BuildReader::layers`] at this place; none behind the last.
    ///
    /// # Errors
    /// [`ReadBuildError`].
    ///
    /// # Cost
    /// Linear in the size of the part.
    pub fn read_layer(&mut self, index: usize) -> Result<Option<Vec<ReadSegment>>, ReadBuildError> {
        let Some(part) = self.model.layers.get(index) else { return Ok(None) };
        let text = self.package.text(&part.path)?;
        layer::read(&part.path, &text, &self.model).map(Some)
    }
}
