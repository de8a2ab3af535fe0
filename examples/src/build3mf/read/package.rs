//! Parts of the package. What is unpacked is limited.

use super::error::ReadBuildError;
use crate::build3mf::names::relationships_of;
use roxmltree::{Document, ParsingOptions};
use std::collections::BTreeSet;
use std::io::{Read, Seek};
use zip::ZipArchive;
use zip::result::ZipError;

/// Bytes of one part.
const MAX_BYTES: u64 = 1 << 28;
const MAX_BYTES_IN_WORDS: &str = "256 MiB";
/// Elements of one part: of a model of 8 million triangles, or of a layer part of our own 80 times.
const MAX_NODES: u32 = 1 << 24;

pub(super) struct Package<R> {
    archive: ZipArchive<R>,
}

impl<R: Read + Seek> Package<R> {
    pub(super) fn open(reader: R) -> Result<Self, ReadBuildError> {
        Ok(Package { archive: ZipArchive::new(reader).map_err(of_archive)? })
    }

    /// The text of a part.
    pub(super) fn text(&mut self, part: &str) -> Result<String, ReadBuildError> {
        let file = match self.archive.by_name(part.trim_start_matches('/')) {
            Ok(file) => file,
            Err(ZipError::FileNotFound) => return Err(ReadBuildError::NoPart { part: part.to_owned() }),
            Err(error) => return Err(of_archive(error)),
        };
        let mut text = Vec::new();
        // The size that the archive states is not believed; damage shows in the checksum at the end.
        let read = file.take(MAX_BYTES + 1).read_to_end(&mut text);
        read.map_err(|error| ReadBuildError::Archive(format!("{part}: {error}")))?;
        if text.len() as u64 > MAX_BYTES {
            return Err(ReadBuildError::TooMuch { part: part.to_owned(), limit: MAX_BYTES_IN_WORDS });
        }
        String::from_utf8(text).map_err(|_| xml(part, "is not UTF-8"))
    }

    /// Targets of the relationships of a type that a part has; of the package for an empty part.
    pub(super) fn targets(&mut self, part: &str, kind: &str) -> Result<BTreeSet<String>, ReadBuildError> {
        let name = if part.is_empty() { "_rels/.rels".to_owned() } else { relationships_of(part) };
        let text = match self.text(&name) {
            Err(ReadBuildError::NoPart { .. }) => return Ok(BTreeSet::new()),
            text => text?,
        };
        let document = parse(&name, &text)?;
        let all = document.descendants().filter(|node| node.attribute("Type") == Some(kind));
        let folder = part.rsplit_once('/').map_or("", |(folder, _)| folder);
        let absolute = |target: &str| match target.starts_with('/') {
            true => target.to_owned(),
            false => format!("{folder}/{target}"),
        };
        Ok(all.filter_map(|node| node.attribute("Target")).map(absolute).collect())
    }
}

/// Parses a part. A document type definition, which could fetch or blow up what it names, is refused.
pub(super) fn parse<'a>(part: &str, text: &'a str) -> Result<Document<'a>, ReadBuildError> {
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).map_err(|error| xml(part, error))
}

fn xml(part: &str, what: impl ToString) -> ReadBuildError {
    ReadBuildError::Xml { part: part.to_owned(), what: what.to_string() }
}

fn of_archive(error: ZipError) -> ReadBuildError {
    match error {
        ZipError::Io(error) if error.kind() != std::io::ErrorKind::UnexpectedEof => ReadBuildError::Io(error),
        other => ReadBuildError::Archive(other.to_string()),
    }
}
