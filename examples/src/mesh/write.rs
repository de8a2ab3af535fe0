//! Meshes written: OBJ with all digits, binary STL.

use super::single::rounded;
use super::triangles::Mesh;
use nalgebra::Vector3;
use std::io::{self, Write};

impl Mesh {
    /// Writes OBJ with all digits: reading it gives the same numbers again.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write_obj(&self, comment: &str, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "# {comment}")?;
        self.vertices.iter().try_for_each(|at| writeln!(out, "v {:?} {:?} {:?}", at.x, at.y, at.z))?;
        self.triangles.iter().try_for_each(|corners| {
            let [a, b, c] = corners.map(|corner| corner + 1);
            writeln!(out, "f {a} {b} {c}")
        })
    }

    /// Writes binary STL: single precision, as most programs take it. Corners that rounding makes equal are one, and no triangle loses its
    /// area to it.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write_stl(&self, out: &mut dyn Write) -> io::Result<()> {
        let single = rounded(&self.vertices, &self.triangles);
        out.write_all(&[b' '; 80])?;
        out.write_all(&(single.triangles.len() as u32).to_le_bytes())?;
        for corners in &single.triangles {
            let places = corners.map(|corner| single.vertices[corner as usize]);
            let [a, b, c] = places.map(|place| Vector3::from(place.map(f64::from)));
            let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default();
            let mut record = [0; 50];
            let numbers = [normal.map(|c| c as f32).into(), places[0], places[1], places[2]];
            for (bytes, number) in record.chunks_exact_mut(4).zip(numbers.as_flattened()) {
                bytes.copy_from_slice(&number.to_le_bytes());
            }
            out.write_all(&record)?;
        }
        Ok(())
    }
}
