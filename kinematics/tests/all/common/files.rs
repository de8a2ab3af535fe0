//! RAPID programs written to files in memory.

use curvlay_kinematics::program::{RapidOptions, RapidWritten, Step, WriteError, write_rapid};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io;

/// Files by name.
pub type Files = BTreeMap<String, Vec<u8>>;

/// A place in a map of files.
struct Place<'a>(&'a RefCell<Files>, String);

impl io::Write for Place<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().entry(self.1.clone()).or_default().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

pub fn to_rapid(
    steps: impl IntoIterator<Item = Step>,
    options: &RapidOptions,
) -> Result<(Files, RapidWritten), WriteError> {
    let files = RefCell::new(Files::new());
    let written = write_rapid(steps, options, |name| Ok(Place(&files, name.to_owned())))?;
    Ok((files.into_inner(), written))
}
