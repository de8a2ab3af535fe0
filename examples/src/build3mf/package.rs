//! The container: a ZIP archive by the Open Packaging Conventions (ECMA-376, part 2).

use super::WriteBuildError;
use super::names::{
    CONTENT_TYPES, LAYER_RELATIONSHIP, MODEL_PART, MODEL_RELATIONSHIP, RELATIONSHIPS, layer_part, relationships_of,
};
use std::io::{self, BufWriter, IntoInnerError, Seek, SeekFrom, Write};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// A package under way: a writer into the part that was begun last. It holds names of parts, and no part.
pub(super) struct Package<W: Write + Seek> {
    archive: BufWriter<ZipWriter<UntilFault<W>>>,
}

impl<W: Write + Seek> Package<W> {
    /// Begins a package with what names its parts. The number of layers is known before the layers are.
    pub(super) fn begin(out: W, layers: usize) -> Result<Self, WriteBuildError> {
        let mut package = Package { archive: BufWriter::new(ZipWriter::new(UntilFault::new(out))) };
        package.part("[Content_Types].xml")?;
        writeln!(package, "{HEAD}\n<Types xmlns=\"{CONTENT_TYPES}\">")?;
        for (end, kind) in [
            ("rels", "application/vnd.openxmlformats-package.relationships+xml"),
            ("model", "application/vnd.ms-package.3dmanufacturing-3dmodel+xml"),
            ("xml", "application/xml"),
        ] {
            writeln!(package, "<Default Extension=\"{end}\" ContentType=\"{kind}\"/>")?;
        }
        writeln!(package, "</Types>")?;
        package.part("_rels/.rels")?;
        package.relationships(MODEL_RELATIONSHIP, [MODEL_PART.to_owned()].into_iter())?;
        package.part(&relationships_of(MODEL_PART))?;
        package.relationships(LAYER_RELATIONSHIP, (0..layers).map(layer_part))?;
        Ok(package)
    }

    /// Begins a part; what is written from now on is in it.
    pub(super) fn part(&mut self, name: &str) -> Result<(), WriteBuildError> {
        self.archive.flush()?;
        self.archive.get_mut().start_file(name.trim_start_matches('/'), SimpleFileOptions::default())?;
        Ok(())
    }

    fn relationships(&mut self, kind: &str, targets: impl Iterator<Item = String>) -> Result<(), WriteBuildError> {
        writeln!(self, "{HEAD}\n<Relationships xmlns=\"{RELATIONSHIPS}\">")?;
        for (number, target) in targets.enumerate() {
            writeln!(self, "<Relationship Id=\"rel{number}\" Type=\"{kind}\" Target=\"{target}\"/>")?;
        }
        writeln!(self, "</Relationships>")?;
        Ok(())
    }

    /// Ends the package.
    pub(super) fn finish(self) -> Result<(), WriteBuildError> {
        let archive = self.archive.into_inner().map_err(IntoInnerError::into_error)?;
        archive.finish()?.flush()?;
        Ok(())
    }
}

impl<W: Write + Seek> Write for Package<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.archive.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.archive.flush()
    }
}

/// The first line of a part.
pub(super) const HEAD: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>";

/// Output that only pretends once it has failed: the archive, when it is dropped, ends itself, and would print that it cannot. It counts on a place no
/// farther back than where its last part begins, also where it was about to change what is before: so the place is then the end.
struct UntilFault<W> {
    out: W,
    has_failed: bool,
    /// Where the next byte goes, and where the last one is.
    at: u64,
    end: u64,
}

impl<W> UntilFault<W> {
    fn new(out: W) -> Self {
        UntilFault { out, has_failed: false, at: 0, end: 0 }
    }

    fn note<T>(&mut self, result: io::Result<T>) -> io::Result<T> {
        self.has_failed |= result.as_ref().is_err_and(|error| error.kind() != io::ErrorKind::Interrupted);
        result
    }

    fn go_to(&mut self, at: u64) {
        self.at = at;
        self.end = self.end.max(at);
    }
}

impl<W: Write> Write for UntilFault<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = if self.has_failed {
            bytes.len()
        } else {
            let result = self.out.write(bytes);
            self.note(result)?
        };
        self.go_to(self.at + count as u64);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.has_failed {
            return Ok(());
        }
        let result = self.out.flush();
        self.note(result)
    }
}

impl<W: Seek> Seek for UntilFault<W> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let at = if self.has_failed {
            match to {
                SeekFrom::Start(at) => at,
                SeekFrom::Current(_) | SeekFrom::End(_) => self.end,
            }
        } else {
            let result = self.out.seek(to);
            self.note(result)?
        };
        self.go_to(at);
        Ok(at)
    }
}
