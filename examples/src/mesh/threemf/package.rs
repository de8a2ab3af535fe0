//! The package: a ZIP archive with relationships. What is unpacked is limited.

use super::super::fault::{MeshFault, package_fault};
use std::io::{Cursor, Read};
use zip::ZipArchive;

/// Most bytes that are unpacked from one package.
const MAX_BYTES: u64 = 1 << 28;
/// The same in words.
const MAX_BYTES_IN_WORDS: &str = "256 MiB";
/// Where slicers keep what they know of objects beyond the standard.
const SETTINGS: [&str; 2] = ["Metadata/model_settings.config", "Metadata/Slic3r_PE_model.config"];
/// How they call what is not solid there.
const MODIFIERS: [&str; 6] =
    ["modifier_part", "negative_part", "ParameterModifier", "NegativeVolume", "support_blocker", "support_enforcer"];

pub(super) struct Package<'a> {
    archive: ZipArchive<Cursor<&'a [u8]>>,
    /// Bytes that may still be unpacked.
    left: u64,
}

impl<'a> Package<'a> {
    pub(super) fn open(bytes: &'a [u8]) -> Result<Self, MeshFault> {
        let archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| {
            package_fault(format!("the ZIP archive cannot be read: {error}; fetch or export it anew"))
        })?;
        Ok(Package { archive, left: MAX_BYTES })
    }

    /// The path of the model that the package is about.
    pub(super) fn root(&mut self) -> Result<String, MeshFault> {
        if let Some(text) = self.optional_text("_rels/.rels")? {
            let document =
                roxmltree::Document::parse(&text).map_err(|error| package_fault(format!("_rels/.rels: {error}")))?;
            let target = document.descendants().find_map(|node| {
                let is_model = node.attribute("Type").is_some_and(|kind| kind.ends_with("/3dmodel"));
                node.attribute("Target").filter(|_| is_model)
            });
            if let Some(target) = target {
                return Ok(absolute(target));
            }
        }
        let is_model = |name: &String| name.to_ascii_lowercase().ends_with(".model");
        self.names().filter(is_model).min().map(|name| absolute(&name)).ok_or(MeshFault::OtherFormat {
            what: "a ZIP archive without a 3MF model",
            to_do: "unpack it first, and give the mesh that is in it",
        })
    }

    /// A text file of the package.
    pub(super) fn text(&mut self, path: &str) -> Result<String, MeshFault> {
        self.optional_text(path)?.ok_or_else(|| package_fault(format!("there is no {path}")))
    }

    /// Whether the program that made it marked objects that are not solid.
    pub(super) fn has_modifiers(&mut self) -> bool {
        SETTINGS.iter().any(|path| {
            let text = self.optional_text(path).ok().flatten().unwrap_or_default();
            MODIFIERS.iter().any(|word| text.contains(word))
        })
    }

    /// Names of the files, without those that are no text.
    fn names(&self) -> impl Iterator<Item = String> {
        self.archive.file_names().filter_map(|name| Some(name.ok()?.into_owned()))
    }

    fn optional_text(&mut self, path: &str) -> Result<Option<String>, MeshFault> {
        let name = path.trim_start_matches('/');
        let known = self.names().find(|known| known.eq_ignore_ascii_case(name));
        let Some(known) = known else { return Ok(None) };
        let file = self.archive.by_name(&known).map_err(|error| package_fault(format!("{path}: {error}")))?;
        let mut text = Vec::new();
        // The size that the archive states is not believed.
        file.take(self.left + 1).read_to_end(&mut text).map_err(|error| package_fault(format!("{path}: {error}")))?;
        let taken = text.len() as u64;
        if taken > self.left {
            return Err(MeshFault::TooMuch { what: format!("{path} of the 3MF package"), limit: MAX_BYTES_IN_WORDS });
        }
        self.left -= taken;
        let text = String::from_utf8(text).map_err(|_| package_fault(format!("{path} is not UTF-8")))?;
        Ok(Some(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text)))
    }
}

/// A path from the root of the package on.
pub(super) fn absolute(path: &str) -> String {
    format!("/{}", path.trim_start_matches('/'))
}
