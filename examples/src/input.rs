//! Input files: regular files of a stated size only, and how to know one of them again under another name.

use crate::count::counted;
use same_file::Handle;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Largest file of settings or of a workcell, in bytes: ours have less than 20,000. A device would never end.
pub const MAX_SETTINGS_BYTES: u64 = 1 << 20;
/// Largest file of points, of a grid or of a drawing, in bytes: a million lines of sixty characters.
pub const MAX_TEXT_BYTES: u64 = 64 << 20;
/// Largest file of stresses, of a field or of paths, in bytes: ten million lines of two hundred characters.
pub const MAX_DATA_BYTES: u64 = 2 << 30;

/// Why an input file is not read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InputError {
    /// The system does not open or read it.
    #[error("{}: cannot be read: {source}", .path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A folder, a device or a pipe.
    #[error("{}: is not a regular file", .path.display())]
    NotAFile {
        /// What it names.
        path: PathBuf,
    },
    /// More bytes than files of its kind have.
    #[error("{}: has {}, the limit is {}; is it the right file?", .path.display(), size(*.bytes), size(*.max_bytes))]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its size.
        bytes: u64,
        /// The limit.
        max_bytes: u64,
    },
    /// A text in another encoding, or no text.
    #[error("{}: byte {at} is not UTF-8: is it a text file?", .path.display())]
    NotText {
        /// The file.
        path: PathBuf,
        /// The first byte that does not belong into a text, from 0.
        at: usize,
    },
}

/// A size as people write it.
fn size(bytes: u64) -> String {
    match bytes {
        0..1_000_000 => counted(bytes, "byte"),
        1_000_000..1_000_000_000 => format!("{:.1} MB", bytes as f64 / 1e6),
        _ => format!("{:.1} GB", bytes as f64 / 1e9),
    }
}

/// Opens a regular file of at most `max_bytes`; what is behind them is not read, even if the file grows meanwhile.
///
/// # Errors
/// [`InputError`] when there is none, it is a folder or a device, or it is larger.
pub fn open(path: &Path, max_bytes: u64) -> Result<io::Take<File>, InputError> {
    let unreadable = |source| InputError::Unreadable { path: path.to_owned(), source };
    // Before it is opened: opening a pipe waits for who writes into it.
    let about = path.metadata().map_err(unreadable)?;
    if !about.is_file() {
        return Err(InputError::NotAFile { path: path.to_owned() });
    }
    if about.len() > max_bytes {
        return Err(InputError::TooLarge { path: path.to_owned(), bytes: about.len(), max_bytes });
    }
    Ok(File::open(path).map_err(unreadable)?.take(max_bytes))
}

/// Reads such a file whole.
///
/// # Errors
/// As [`open`].
pub fn read(path: &Path, max_bytes: u64) -> Result<Vec<u8>, InputError> {
    let mut bytes = Vec::new();
    open(path, max_bytes)?
        .read_to_end(&mut bytes)
        .map_err(|source| InputError::Unreadable { path: path.to_owned(), source })?;
    Ok(bytes)
}

/// Reads such a file whole, as text.
///
/// # Errors
/// As [`open`], and [`InputError::NotText`].
pub fn read_text(path: &Path, max_bytes: u64) -> Result<String, InputError> {
    String::from_utf8(read(path, max_bytes)?)
        .map_err(|error| InputError::NotText { path: path.to_owned(), at: error.utf8_error().valid_up_to() })
}

/// Files of the user, known again through links and under other names. They are held open, so the system gives their identity to no
/// other file.
#[derive(Debug, Default)]
pub struct Inputs(Vec<(PathBuf, Handle)>);

impl Inputs {
    /// Those of the paths that are regular files; the reader says what is wrong with the others.
    pub fn new<'a>(paths: impl IntoIterator<Item = &'a Path>) -> Self {
        let known = paths.into_iter().filter_map(|path| Some((path.to_owned(), handle(path)?)));
        Inputs(known.collect())
    }

    /// The path, if it does not lead to one of them: to be written to.
    ///
    /// # Errors
    /// With the path, if it does.
    pub fn spare(&self, path: PathBuf) -> io::Result<PathBuf> {
        if self.contains(&path) {
            return Err(io::Error::other(format!("{}: is an input, which would be written over", path.display())));
        }
        Ok(path)
    }

    /// Makes a file and the folders above it, unless the path leads to one of them.
    ///
    /// # Errors
    /// As [`Inputs::spare`], and what the system says.
    pub fn create(&self, path: &Path) -> io::Result<File> {
        let path = self.spare(path.to_owned())?;
        path.parent().map_or(Ok(()), fs::create_dir_all)?;
        File::create(path)
    }

    /// Whether the path leads to one of them.
    pub fn contains(&self, path: &Path) -> bool {
        !self.0.is_empty() && handle(path).is_some_and(|file| self.0.iter().any(|(_, input)| *input == file))
    }
}

/// The identity of a regular file.
fn handle(path: &Path) -> Option<Handle> {
    path.metadata().ok().filter(fs::Metadata::is_file)?;
    Handle::from_path(path).ok()
}
