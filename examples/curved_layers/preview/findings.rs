//! What a preview finds beyond the findings of the field.

use super::estimated::PreviewRun;
use crate::field::FieldRun;
use crate::job::Job;
use crate::surfaces::SurfacesRun;
use curvlay_examples::count::grouped;
use curvlay_examples::findings::Severity::{Failed, Warning};
use curvlay_examples::findings::{Findings, percent};
use curvlay_kinematics::machine::Reach;
use curvlay_toolpath::layer::LayerSurface;
use nalgebra::{Point3, UnitVector3, Vector3};

/// Area shares above which a finding is reported, as for full runs.
const NOTABLE_SHARE: f64 = 0.01;

/// Adds what is known of the print: places too narrow for a bead, a part too large for what prints it.
pub fn find(job: &Job, field: &FieldRun, surfaces: &SurfacesRun, preview: &PreviewRun, findings: &mut Findings) {
    let share = preview.too_narrow_share();
    if share > NOTABLE_SHARE {
        let what = format!("no bead of {:.3} mm fits into a part of the layers", preview.bead_mm);
        let amount = format!("about {} of their area, {:.1} mm3", percent(share), preview.print.too_narrow_mm3);
        findings.add(Warning, what, amount, "--bead");
    }
    of_machine(job, surfaces, findings);
    of_plate(job, field, findings);
}

/// Of a five-axis machine that does not reach the layers, with the nozzle across them.
fn of_machine(job: &Job, surfaces: &SurfacesRun, findings: &mut Findings) {
    let Some(printer) = &job.args.printer else { return };
    let layers = surfaces.surfaces();
    let Reach { places, unreachable, worst: Some(worst), .. } = printer.machine.reach(layers.iter().flat_map(poses))
    else {
        return;
    };
    let at = worst.tip;
    let amount = format!("{} of {} places", grouped(unreachable), grouped(places));
    let place = format!("the farthest at {:.1} {:.1} {:.1}: {}", at.x, at.y, at.z, worst.reason);
    let finding = findings.explain(
        Failed,
        "the part is out of the machine's reach, with the nozzle across the layers",
        amount,
        place,
    );
    finding.try_to("another --orient").try_to("gentler layers (--max-layer-tilt)").try_to("another part_origin_mm");
}

/// The vertices of a layer, with the nozzle across it.
fn poses(surface: &LayerSurface) -> Vec<(Point3<f64>, UnitVector3<f64>)> {
    let mut normals = vec![Vector3::zeros(); surface.vertices.len()];
    for corners in surface.triangles {
        let [a, b, c] = corners.map(|v| surface.vertices[v as usize]);
        corners.iter().for_each(|&v| normals[v as usize] += (b - a).cross(&(c - a)));
    }
    let pose = |(vertex, normal): (&Point3<f64>, &Vector3<f64>)| Some((*vertex, UnitVector3::try_new(*normal, 0.0)?));
    surface.vertices.iter().zip(&normals).filter_map(pose).collect()
}

/// Of a part that is wider than the plate of the workcell.
fn of_plate(job: &Job, field: &FieldRun, findings: &mut Findings) {
    let bounds = job.part.mesh.bounds().filter(|_| job.args.motion.workcell.is_some());
    let (plate, Some([low, high])) = (&job.setup.cell.equipment().model().plate, bounds) else { return };
    let [x, y, _]: [f64; 3] = (high - low).into();
    let slack = field.solid.grid.cell_mm();
    let (is_wider, plate) = match (plate.size_mm, plate.diameter_mm) {
        (Some([wide, deep]), _) => (x > wide + slack || y > deep + slack, format!("{wide} x {deep} mm")),
        (None, Some(diameter)) => (x.max(y) > diameter + slack, format!("{diameter} mm across")),
        (None, None) => return,
    };
    if is_wider {
        findings.add(Warning, "the part is wider than the plate of the workcell", format!("{x:.1} x {y:.1} mm"), plate);
    }
}
