//! The output folder: checked before the work begins, written file by file, each whole or not at all.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicBool, Ordering};

/// The file that says what the others are: it goes first and comes last.
pub const SUMMARY: &str = "summary.json";

/// A folder that can be written. Folders that were made for it and stayed empty go away with it.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    /// Folders that were not there before, outermost first.
    made: Vec<PathBuf>,
    written: AtomicBool,
}

/// Why there is no output.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// Something else has the name of the folder, or of one above it.
    #[error("{}: is a file, so it cannot be the output folder", .path.display())]
    NotAFolder {
        /// What is in the way.
        path: PathBuf,
    },
    /// The folder is not there and cannot be made.
    #[error("{}: the output folder cannot be made: {source}", .path.display())]
    Make {
        /// The folder.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The folder, or a file in it, cannot be written.
    #[error("{}: cannot be written: {source}", .path.display())]
    Write {
        /// The folder or file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
}

impl OutputFolder {
    /// Makes the folder if it is not there, and tries a file in it.
    ///
    /// # Errors
    /// [`OutputError`] when the folder cannot be used; nothing is left behind then.
    pub fn create(path: &Path) -> Result<Self, OutputError> {
        let in_the_way = path.ancestors().find(|above| above.exists()).filter(|above| !above.is_dir());
        if let Some(file) = in_the_way {
            return Err(OutputError::NotAFolder { path: file.to_owned() });
        }
        let missing = |above: &&Path| !above.as_os_str().is_empty() && !above.exists();
        let mut made: Vec<PathBuf> = path.ancestors().take_while(missing).map(Path::to_owned).collect();
        made.reverse();
        // From here on dropping the folder clears up.
        let folder = OutputFolder { path: path.to_owned(), made, written: AtomicBool::new(false) };
        fs::create_dir_all(path).map_err(|source| OutputError::Make { path: path.to_owned(), source })?;
        let trial = folder.temporary("trial");
        File::create(&trial)
            .and_then(|_| fs::remove_file(&trial))
            .map_err(|source| OutputError::Write { path: path.to_owned(), source })?;
        Ok(folder)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Takes away what an earlier run has left: the summary first, so that none stands beside files of another run, then all
    /// files whose name `is_ours`, begun ones included. Folders and all other files stay.
    ///
    /// # Errors
    /// [`OutputError`] when a file cannot be removed or the folder not be read.
    pub fn clear(&self, is_ours: impl Fn(&str) -> bool) -> Result<(), OutputError> {
        self.write_list(SUMMARY, false, |_| Ok(()))?;
        let unread = |source| OutputError::Write { path: self.path.clone(), source };
        for entry in fs::read_dir(&self.path).map_err(unread)? {
            let entry = entry.map_err(unread)?;
            let name = entry.file_name().to_string_lossy().into_owned();
            let begun = || name.strip_prefix('.')?.strip_suffix(".part")?.rsplit_once('.').map(|(name, _)| name);
            if (is_ours(&name) || begun().is_some_and(&is_ours)) && entry.file_type().is_ok_and(|kind| !kind.is_dir()) {
                self.write_list(&name, false, |_| Ok(()))?;
            }
        }
        Ok(())
    }

    /// Writes a file at once.
    ///
    /// # Errors
    /// As [`OutputFolder::write_with`].
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> Result<(), OutputError> {
        self.write_with(name, |file| file.write_all(bytes.as_ref()))
    }

    /// Writes a file bit by bit: under a temporary name in the folder, renamed when `fill` is done.
    ///
    /// # Errors
    /// [`OutputError::Write`] when `fill` or the system says no; an earlier file of that name then stays as it was.
    pub fn write_with(
        &self,
        name: &str,
        fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        let begun = self.begin(name).and_then(|(unfinished, file)| {
            let mut file = BufWriter::new(file);
            fill(&mut file)?;
            file.into_inner().map_err(io::IntoInnerError::into_error)?;
            Ok(unfinished)
        });
        match begun {
            Ok(unfinished) => unfinished.finish().map(|_| ()),
            Err(source) => Err(OutputError::Write { path: self.path.join(name), source }),
        }
    }

    /// Writes a list if there is anything `to_list`; if not, takes away the one of an earlier run.
    ///
    /// # Errors
    /// As [`OutputFolder::write_with`].
    pub fn write_list(
        &self,
        name: &str,
        to_list: bool,
        fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        if to_list {
            return self.write_with(name, fill);
        }
        let path = self.path.join(name);
        match std::fs::remove_file(&path) {
            Err(source) if source.kind() != io::ErrorKind::NotFound => Err(OutputError::Write { path, source }),
            _ => Ok(()),
        }
    }

    /// Begins a file under a temporary name, for files that belong together: begin all of them, fill them, finish them.
    ///
    /// # Errors
    /// What the system says.
    pub fn begin(&self, name: &str) -> io::Result<(Unfinished<'_>, File)> {
        let unfinished = Unfinished { folder: self, temporary: self.temporary(name), target: self.path.join(name) };
        let file = File::create(&unfinished.temporary)?;
        Ok((unfinished, file))
    }

    /// A name that no other run uses at the same time.
    fn temporary(&self, name: &str) -> PathBuf {
        self.path.join(format!(".{name}.{}.part", process::id()))
    }
}

/// A file under its temporary name. Dropped, it goes away.
#[derive(Debug)]
#[must_use]
pub struct Unfinished<'a> {
    folder: &'a OutputFolder,
    temporary: PathBuf,
    target: PathBuf,
}

impl Unfinished<'_> {
    /// Gives the file its name; to be called when all of it is written. Returns how many bytes it has.
    ///
    /// # Errors
    /// [`OutputError::Write`] when the system says no; an earlier file of that name then stays as it was.
    pub fn finish(self) -> Result<u64, OutputError> {
        let named = fs::metadata(&self.temporary).and_then(|file| {
            fs::rename(&self.temporary, &self.target)?;
            Ok(file.len())
        });
        let bytes = named.map_err(|source| OutputError::Write { path: self.target.clone(), source })?;
        self.folder.written.store(true, Ordering::Relaxed);
        Ok(bytes)
    }
}

impl Drop for Unfinished<'_> {
    fn drop(&mut self) {
        // Finished, it has another name.
        let _ = fs::remove_file(&self.temporary);
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        if !self.written.load(Ordering::Relaxed) {
            for folder in self.made.iter().rev() {
                // Only an empty folder can be removed, so nobody's files are at risk.
                let _ = fs::remove_dir(folder);
            }
        }
    }
}
