//! What all readers fill: a mesh whose corners at one place are one, and what they had to decide.

use super::fault::{MeshFault, Place, syntax};
use super::triangles::Mesh;
use crate::finding::{Finding, Severity};
use curvlay_voxel::{PolygonError, triangulate_polygon};
use nalgebra::Point3;
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// How often something was met in a file, and where first.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    count: usize,
    first: Option<Place>,
}

impl Tally {
    fn add(&mut self, place: Place) {
        self.count += 1;
        self.first = self.first.or(Some(place));
    }

    fn finding(self, severity: Severity, what: &str) -> Option<Finding> {
        let place = self.first.map(|place| format!("first: {place}"))?;
        Some(Finding::new(severity, what, self.count.to_string(), place))
    }
}

/// Collects triangles, giving each place one vertex.
#[derive(Default)]
pub(super) struct Welder {
    pub(super) mesh: Mesh,
    /// The file says in which unit its numbers are, and they were taken to millimetres.
    pub(super) states_unit: bool,
    /// Names of groups, each with the first triangle behind it.
    pub(super) groups: Vec<(String, usize)>,
    vertex_at: HashMap<[u64; 3], u32>,
    findings: Vec<Finding>,
    without_area: Tally,
    repeated_corners: Tally,
    crossing: Tally,
}

impl Welder {
    /// The vertex at `p`, made when it is new.
    pub(super) fn vertex(&mut self, p: [f64; 3]) -> Result<u32, MeshFault> {
        let next = self.mesh.vertices.len();
        // Adding zero makes -0 and 0 one place.
        match self.vertex_at.entry(p.map(|c| (c + 0.0).to_bits())) {
            Entry::Occupied(known) => Ok(*known.get()),
            Entry::Vacant(new) => {
                let id = u32::try_from(next).map_err(|_| syntax(Place::Byte(0), "more than 2^32 vertices"))?;
                self.mesh.vertices.push(Point3::from(p));
                Ok(*new.insert(id))
            }
        }
    }

    /// Adds a polygon, cut into triangles in its own plane. What has no area is left out and counted; one that crosses itself
    /// becomes a fan, whose windings still add up to its own.
    pub(super) fn polygon(&mut self, corners: &[u32], place: Place) {
        let repeats = |at: usize| corners[at] == corners[(at + 1) % corners.len()];
        if corners.len() > 3 && (0..corners.len()).any(repeats) {
            self.repeated_corners.add(place);
        }
        if let [a, b, c] = *corners {
            // Whether three corners on a line are of use is decided once all neighbours are known.
            if a == b || b == c || c == a {
                self.without_area.add(place);
            } else {
                self.mesh.triangles.push([a, b, c]);
            }
            return;
        }
        let places: Vec<_> = corners.iter().map(|&corner| self.mesh.vertices[corner as usize]).collect();
        match triangulate_polygon(&places) {
            Ok(triangles) => self.mesh.triangles.extend(triangles.iter().map(|t| t.map(|at| corners[at]))),
            Err(PolygonError::NoArea) => self.without_area.add(place),
            Err(_) => {
                self.crossing.add(place);
                self.mesh.triangles.extend((2..corners.len()).map(|k| [corners[0], corners[k - 1], corners[k]]));
            }
        }
    }

    /// What follows belongs to a group.
    pub(super) fn group(&mut self, name: &str) {
        self.groups.push((name.to_owned(), self.mesh.triangles.len()));
    }

    /// Adds something that the reader decided.
    pub(super) fn note(&mut self, what: impl Into<String>, amount: impl Into<String>, place: impl Into<String>) {
        self.findings.push(Finding::new(Severity::Note, what, amount, place));
    }

    /// Adds something that the user should look at.
    pub(super) fn warn(&mut self, what: impl Into<String>, amount: impl Into<String>, place: impl Into<String>) {
        self.findings.push(Finding::new(Severity::Warning, what, amount, place));
    }

    /// The mesh, and all that was decided.
    pub(super) fn finish(self) -> (Mesh, Vec<Finding>) {
        let mut findings = self.findings;
        findings.extend(self.without_area.finding(Severity::Note, "faces without area were left out"));
        let repeats = "faces that name a corner twice in a row were read without the repeat";
        findings.extend(self.repeated_corners.finding(Severity::Note, repeats));
        let crossing = "faces cross themselves, and their inside was guessed: export the mesh as triangles";
        findings.extend(self.crossing.finding(Severity::Warning, crossing));
        (self.mesh, findings)
    }
}
