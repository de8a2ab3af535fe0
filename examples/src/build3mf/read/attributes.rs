//! Attributes of elements, by the types of the schema.

use super::error::ReadBuildError;
use roxmltree::Node;

/// An element of a part, and how a reader finds it.
pub(super) struct Element<'p, 'a, 'i> {
    pub(super) part: &'p str,
    pub(super) node: Node<'a, 'i>,
    /// Where it is, such as `segment 3, point 2`.
    pub(super) place: &'p dyn Fn() -> String,
}

impl<'a> Element<'_, 'a, '_> {
    pub(super) fn wrong(&self, attribute: &str, found: Option<&str>, wanted: &'static str) -> ReadBuildError {
        let found = found.map_or_else(|| "missing".to_owned(), |text| format!("`{}`", shortened(text)));
        let (part, place) = (self.part.to_owned(), (self.place)());
        ReadBuildError::Attribute { part, place, attribute: attribute.to_owned(), found, wanted }
    }

    pub(super) fn text(&self, name: &str) -> Result<&'a str, ReadBuildError> {
        self.node.attribute(name).ok_or_else(|| self.wrong(name, None, "there"))
    }

    /// A number that may be missing. Those of the schema have no infinity and no NaN.
    pub(super) fn optional<'n>(
        &self,
        name: impl Into<roxmltree::ExpandedName<'n, 'n>> + Copy,
        wanted: &'static str,
        is_valid: impl Fn(f64) -> bool,
    ) -> Result<Option<f64>, ReadBuildError> {
        let name = name.into();
        let Some(text) = self.node.attribute(name) else { return Ok(None) };
        let value = text.trim().parse().ok().filter(|value: &f64| value.is_finite() && is_valid(*value));
        value.map(Some).ok_or_else(|| self.wrong(name.name(), Some(text), wanted))
    }

    pub(super) fn number(&self, name: &str, wanted: &'static str) -> Result<f64, ReadBuildError> {
        self.optional(name, wanted, |_| true)?.ok_or_else(|| self.wrong(name, None, wanted))
    }

    /// A coordinate: an integer of 32 bits.
    pub(super) fn integer(&self, name: &str) -> Result<i32, ReadBuildError> {
        const WANTED: &str = "an integer of 32 bits";
        let text = self.node.attribute(name).ok_or_else(|| self.wrong(name, None, WANTED))?;
        text.trim().parse().map_err(|_| self.wrong(name, Some(text), WANTED))
    }

    /// A number of a thing: an integer from 1 to 2^31 - 1.
    pub(super) fn id(&self, name: &str) -> Result<u32, ReadBuildError> {
        const WANTED: &str = "an integer above 0";
        let text = self.node.attribute(name).ok_or_else(|| self.wrong(name, None, WANTED))?;
        let id = text.trim().parse().ok().filter(|id| (1..=i32::MAX as u32).contains(id));
        id.ok_or_else(|| self.wrong(name, Some(text), WANTED))
    }
}

/// The first characters of a text, for people.
fn shortened(text: &str) -> String {
    text.chars().take(40).flat_map(char::escape_default).collect()
}
