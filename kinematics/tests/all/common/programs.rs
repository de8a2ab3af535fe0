//! Programs of several files in memory, and poses that came back.

use curvlay_kinematics::nalgebra::{Isometry3, Vector3};
use curvlay_kinematics::program::WriteError;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::rc::Rc;

/// Files by name.
pub type Files = BTreeMap<String, String>;

/// A file that a writer fills while it is elsewhere.
#[derive(Clone, Default)]
pub struct Shared(Rc<RefCell<Vec<u8>>>);

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The files that a writer opens, and what it returns.
pub fn written_files<T>(
    write: impl FnOnce(&mut dyn FnMut(&str) -> io::Result<Shared>) -> Result<T, WriteError>,
) -> Result<(Files, T), WriteError> {
    let mut files: Vec<(String, Shared)> = Vec::new();
    let written = write(&mut |name| {
        let file = Shared::default();
        files.push((name.to_owned(), file.clone()));
        Ok(file)
    })?;
    let text = |file: Shared| String::from_utf8(file.0.take()).unwrap();
    Ok((files.into_iter().map(|(name, file)| (name, text(file))).collect(), written))
}

/// Within a micrometre and a microradian.
pub fn same_pose(a: &Isometry3<f64>, b: &Isometry3<f64>) -> bool {
    let turned = |axis: Vector3<f64>| (a.rotation * axis - b.rotation * axis).norm();
    (a.translation.vector - b.translation.vector).norm() < 1e-3 && turned(Vector3::x()).max(turned(Vector3::y())) < 1e-6
}
