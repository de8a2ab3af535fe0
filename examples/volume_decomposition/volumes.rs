//! The parts to divide, and what becomes of them.

use super::{Args, Shape};
use clap::ValueEnum;
use curvlay_examples::args::{Failure, Part, typed_name};
use curvlay_examples::bars::Bars;
use curvlay_examples::findings::{Findings, Severity};
use curvlay_examples::mesh::Mesh;
use curvlay_examples::shapes;
use curvlay_layers::Progress;
use curvlay_layers::planar::{
    AuditOptions, Solid, StuckReason, VolumeAudit, VolumeDecomposition, audit_volumes, decompose_volume,
};
use std::time::{Duration, Instant};

/// A part, its volumes, and what the audit says.
pub struct Divided {
    pub name: String,
    pub solid: Solid,
    pub result: VolumeDecomposition,
    pub audit: VolumeAudit,
    pub decompose_time: Duration,
    pub audit_time: Duration,
    /// What there is to say about the mesh.
    pub of_mesh: Findings,
}

/// What a part of the user is called in files and keys.
pub const PART: &str = "part";

/// Divides the file, or every shape.
pub fn divide(args: &Args, bars: &Bars) -> Result<Vec<Divided>, Failure> {
    if args.mesh.path().is_some() {
        let part = args.mesh.load(PART, Mesh::default)?;
        return Ok(vec![divide_one(PART, &part, args, bars)?]);
    }
    let shapes = Shape::value_variants().iter();
    shapes
        .map(|&shape| {
            let made = || match shape {
                Shape::Curved => shapes::bend(),
                Shape::Ell => shapes::ell(),
                Shape::Tee => shapes::tee(),
                Shape::Mushroom => shapes::mushroom(),
            };
            let part = args.mesh.load(&typed_name(shape), made)?;
            divide_one(&typed_name(shape), &part, args, bars)
        })
        .collect()
}

fn divide_one(name: &str, part: &Part, args: &Args, bars: &Bars) -> Result<Divided, Failure> {
    let mut of_mesh = Findings::default();
    part.find(&mut of_mesh);
    let solid = Solid::new(&part.mesh.vertices, &part.mesh.triangles)
        .map_err(|error| Failure::new(format!("{name}: {error}")))?;
    let options = args.options();
    let start = Instant::now();
    let show = |at: Progress| bars.show(at.stage, at.done, at.total);
    let result = decompose_volume(&solid, &options, &show).map_err(|error| Failure::new(format!("{name}: {error}")))?;
    let decompose_time = start.elapsed();
    let start = Instant::now();
    let audit = audit_volumes(&solid, &result.parts, &options, &AuditOptions::default());
    Ok(Divided { name: name.to_owned(), solid, result, audit, decompose_time, audit_time: start.elapsed(), of_mesh })
}

impl Divided {
    /// Volume of overhang that is left in the parts.
    pub fn overhang_after_mm3(&self) -> f64 {
        self.result.parts.iter().map(|part| part.overhang_mm3).sum()
    }

    /// Layers of all parts.
    pub fn layers(&self) -> usize {
        self.result.parts.iter().map(|part| part.layer_tops_mm.len()).sum()
    }

    /// Area of the layers under which the audit finds nothing.
    pub fn unsupported_mm2(&self) -> f64 {
        self.audit.unsupported_mm2.iter().sum()
    }

    /// What is wrong.
    pub fn find(&self, findings: &mut Findings) {
        let Divided { name, result, audit, .. } = self;
        for stuck in &result.stuck {
            let why = match stuck.reason {
                StuckReason::TooManyParts => "there would be more parts than --max-parts",
                _ => "no wall takes it off",
            };
            let left = format!("{:.1} mm3", result.parts[stuck.part].overhang_mm3);
            let place = format!("{name}, part {}: {why}", stuck.part + 1);
            findings.add(Severity::Failed, "a part keeps its overhang", left, place);
        }
        if audit.volume_error > 1e-9 {
            findings.add(Severity::Failed, "volumes do not add up", format!("{:.1e}", audit.volume_error), name);
        }
        let allowed = AuditOptions::default().allowed_share;
        for (what, share) in [
            ("parts are missing from the solid", audit.missing_share),
            ("parts overlap or leave the solid", audit.doubled_share),
        ] {
            if share > allowed {
                findings.add(Severity::Failed, what, format!("{share:.1e} of the solid"), name);
            }
        }
        // Of a part that is stuck it is known.
        let stuck = |part: usize| result.stuck.iter().any(|stuck| stuck.part == part);
        for (part, &area) in
            audit.unsupported_mm2.iter().enumerate().filter(|&(part, &area)| area > 0.0 && !stuck(part))
        {
            findings.add(
                Severity::Failed,
                "layers lie on nothing",
                format!("{area:.1} mm2"),
                format!("{name}, part {}", part + 1),
            );
        }
    }
}
