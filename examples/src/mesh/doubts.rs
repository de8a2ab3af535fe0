//! What the orientation of a mesh leaves to say: one policy for all examples.

use crate::count::counted;
use crate::finding::{Finding, Severity};
use curvlay_voxel::OrientReport;

/// Share of the volume from which on a reading of the mesh that differs is a doubt.
pub const UNCERTAIN_SHARE: f64 = 1e-3;

/// What was turned and closed, and where the mesh may be another part than its author's: that fails unless guesses are allowed.
///
/// # Example
/// ```
/// use curvlay_examples::findings::Severity;
/// use curvlay_examples::mesh::mesh_findings;
/// let mut open = curvlay_examples::shapes::jug();
/// let bottom = |mesh: &curvlay_examples::mesh::Mesh, t: &[u32; 3]| t.iter().all(|&corner| mesh.vertices[corner as usize].z < 0.1);
/// let kept: Vec<_> = open.triangles.iter().copied().filter(|t| !bottom(&open, t)).collect();
/// open.triangles = kept;
/// let report = open.orient()?;
/// assert!(mesh_findings(&report, false).iter().any(|finding| finding.severity == Severity::Failed));
/// assert!(mesh_findings(&report, true).iter().all(|finding| finding.severity != Severity::Failed));
/// # Ok::<(), curvlay_examples::mesh::MeshFault>(())
/// ```
pub fn mesh_findings(report: &OrientReport, allow_guesses: bool) -> Vec<Finding> {
    let mut findings = Vec::new();
    if report.turned_triangles > 0 {
        findings.push(Finding::new(Severity::Note, report.to_string(), "", ""));
    }
    let doubts = report.doubts(UNCERTAIN_SHARE);
    let severity = if allow_guesses { Severity::Warning } else { Severity::Failed };
    for doubt in &doubts {
        let mut finding = Finding::new(severity, doubt.to_string(), "", "");
        finding.try_to("mend the mesh in the program that made it").allow("--allow-guesses");
        findings.push(finding);
    }
    if report.holes > 0 && report.holes_mm3 <= UNCERTAIN_SHARE * report.volume_mm3 {
        let what = format!(
            "closed {}: at most {:.2} of {:.1} mm3 depends on how",
            counted(report.holes, "hole"),
            report.holes_mm3,
            report.volume_mm3
        );
        findings.push(Finding::new(Severity::Note, what, "", ""));
    }
    findings
}
