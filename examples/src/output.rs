//! The output folder: checked before the work begins, written file by file, each whole or not at all. What was given as input is never
//! removed nor written over.

use crate::input::Inputs;
use crate::signals;
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
    inputs: Inputs,
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
    /// A file that the run would remove or write over was given to it as input, under this name or another.
    #[error("{}: is an input of this run, which would write over it; take another folder with --out", .path.display())]
    IsInput {
        /// The file in the folder.
        path: PathBuf,
    },
}

/// Whether `name` is `prefix`, a number from 1, `suffix`, the number as `{:0min_digits}` writes it.
/// ```
/// use curvlay_examples::output::is_numbered;
/// assert!(is_numbered("part_01.stl", "part_", 2, ".stl") && is_numbered("part_123.stl", "part_", 2, ".stl"));
/// assert!(!["part_1.stl", "part_012.stl", "part_00.stl", "part_a1.stl", "part_.stl"].iter().any(|name| is_numbered(name, "part_", 2, ".stl")));
/// ```
pub fn is_numbered(name: &str, prefix: &str, min_digits: usize, suffix: &str) -> bool {
    let digits = name.strip_prefix(prefix).and_then(|rest| rest.strip_suffix(suffix));
    digits.is_some_and(|digits| {
        let number = digits.bytes().all(|digit| digit.is_ascii_digit()).then(|| digits.parse::<u64>().ok()).flatten();
        number.is_some_and(|number| number > 0 && format!("{number:0min_digits$}") == digits)
    })
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
        let folder =
            OutputFolder { path: path.to_owned(), made, written: AtomicBool::new(false), inputs: Inputs::default() };
        fs::create_dir_all(path).map_err(|source| OutputError::Make { path: path.to_owned(), source })?;
        let trial = folder.temporary("trial");
        signals::briefly(|| File::create(&trial).and_then(|_| fs::remove_file(&trial)))
            .map_err(|source| OutputError::Write { path: path.to_owned(), source })?;
        Ok(folder)
    }

    /// The same for a run that reads `inputs` and writes files whose name `is_ours`.
    ///
    /// # Errors
    /// [`OutputError::IsInput`] when one of the two is the other, links included; nothing is removed or written then.
    pub fn guarding(mut self, inputs: Inputs, is_ours: impl Fn(&str) -> bool) -> Result<Self, OutputError> {
        self.inputs = inputs;
        self.ours(is_ours)?;
        Ok(self)
    }

    /// Names of the files in the folder that a run would remove or write over, the summary among them.
    fn ours(&self, is_ours: impl Fn(&str) -> bool) -> Result<Vec<String>, OutputError> {
        let unread = |source| OutputError::Write { path: self.path.clone(), source };
        let mut names = Vec::new();
        for entry in fs::read_dir(&self.path).map_err(unread)? {
            let entry = entry.map_err(unread)?;
            // We write no name that is not Unicode.
            let Ok(name) = entry.file_name().into_string() else { continue };
            let written = begun(&name).unwrap_or(&name);
            let is_ours = is_ours(written) || written == SUMMARY;
            if is_ours && entry.file_type().is_ok_and(|kind| !kind.is_dir()) {
                self.spare_input(&name)?;
                names.push(name);
            }
        }
        Ok(names)
    }

    /// An error if a file of the folder is an input.
    fn spare_input(&self, name: &str) -> Result<(), OutputError> {
        let path = self.path.join(name);
        if self.inputs.contains(&path) { Err(OutputError::IsInput { path }) } else { Ok(()) }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Takes away what an earlier run has left: the summary first, so that none stands beside files of another run, then all
    /// files whose name `is_ours`, begun ones included. Folders and all other files stay. To be called once all input is read.
    ///
    /// # Errors
    /// [`OutputError`] when a file is an input (none is removed then), when it cannot be removed, or the folder not be read.
    pub fn clear(&self, is_ours: impl Fn(&str) -> bool) -> Result<(), OutputError> {
        let names = self.ours(is_ours)?;
        self.remove(SUMMARY)?;
        names.iter().try_for_each(|name| self.remove(name))
    }

    /// Removes a file of the folder if it is there.
    fn remove(&self, name: &str) -> Result<(), OutputError> {
        self.spare_input(name)?;
        let path = self.path.join(name);
        match fs::remove_file(&path) {
            Err(source) if source.kind() != io::ErrorKind::NotFound => Err(OutputError::Write { path, source }),
            _ => Ok(()),
        }
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
        self.remove(name)
    }

    /// Begins a file under a temporary name, for files that belong together: begin all of them, fill them, finish them.
    ///
    /// # Errors
    /// What the system says.
    pub fn begin(&self, name: &str) -> io::Result<(Unfinished<'_>, File)> {
        let unfinished = Unfinished { folder: self, temporary: self.temporary(name), target: self.path.join(name) };
        let file = signals::begin(&unfinished.temporary, || File::create(&unfinished.temporary))?;
        Ok((unfinished, file))
    }

    /// A name that no other run uses at the same time.
    fn temporary(&self, name: &str) -> PathBuf {
        self.path.join(format!(".{name}.{}.part", process::id()))
    }
}

/// The name that a file under a temporary name is to have.
fn begun(name: &str) -> Option<&str> {
    let (name, process) = name.strip_prefix('.')?.strip_suffix(".part")?.rsplit_once('.')?;
    process.parse::<u32>().is_ok().then_some(name)
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
    /// [`OutputError`] when the system says no or the file of that name is an input; it then stays as it was.
    pub fn finish(self) -> Result<u64, OutputError> {
        if self.folder.inputs.contains(&self.target) {
            return Err(OutputError::IsInput { path: self.target.clone() });
        }
        let named = fs::metadata(&self.temporary).and_then(|file| {
            signals::end(&self.temporary, || fs::rename(&self.temporary, &self.target))?;
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
        let _ = signals::end(&self.temporary, || fs::remove_file(&self.temporary));
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
