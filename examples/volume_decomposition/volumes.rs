//! The parts to divide, and what becomes of them.

use super::{Args, Base, Shape};
use clap::ValueEnum;
use curvlay_examples::args::{Failure, Part, typed_name};
use curvlay_examples::bars::Bars;
use curvlay_examples::findings::{Findings, Severity, accept, percent};
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

/// Share of the volume from which on places that no layer has are a finding: a rounding of layers below.
const THIN: f64 = 0.001;

/// The most parts that a finding names.
const NAMED: usize = 5;

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
        self.result.parts.iter().map(|part| part.layers.len()).sum()
    }

    /// Area of the layers under which the audit finds nothing.
    pub fn unsupported_mm2(&self) -> f64 {
        self.audit.sum(|part| part.unsupported_mm2)
    }

    /// Share of the layer area that the torch cannot lay.
    pub fn blocked_share(&self) -> f64 {
        self.audit.sum(|part| part.blocked_mm2) / self.audit.sum(|part| part.layers_mm2).max(f64::MIN_POSITIVE)
    }

    /// What is wrong.
    pub fn find(&self, args: &Args, findings: &mut Findings) {
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
        let number = |part: usize| format!("{name}, part {}", part + 1);
        for (part, found) in audit.parts.iter().enumerate() {
            if found.unlayered_mm3 > allowed * self.solid.volume() {
                let amount = format!("{:.1} mm3", found.unlayered_mm3);
                let what = "a part is behind its base plane, in no layer";
                findings
                    .explain(Severity::Failed, what, amount, number(part))
                    .try_to("--base best")
                    .try_to("another --layer");
            }
            // Of a part that is stuck it is known.
            let is_stuck = result.stuck.iter().any(|stuck| stuck.part == part);
            if found.unsupported_mm2 > 0.0 && !is_stuck {
                let amount = format!("{:.1} mm2", found.unsupported_mm2);
                findings.add(Severity::Failed, "layers are unsupported", amount, number(part));
            }
            let differ = (found.left_out_mm3 + found.added_mm3) / found.sections_mm3.max(f64::MIN_POSITIVE);
            if args.feature_mm <= 0.0 && differ > AuditOptions::default().allowed_section_share {
                let what = "printed layers are not those of the part";
                findings.add(Severity::Failed, what, percent(differ), number(part));
            }
        }
        self.find_small(args, findings);
        self.find_blocked(args, findings);
    }

    /// What is not printed because it is small.
    fn find_small(&self, args: &Args, findings: &mut Findings) {
        let [thin, left_out, added] = [
            self.audit.sum(|part| part.thin_mm3),
            self.audit.sum(|part| part.left_out_mm3),
            self.audit.sum(|part| part.added_mm3),
        ];
        if thin > THIN * self.solid.volume() {
            let amount = format!("{thin:.1} mm3, {} of the part", percent(thin / self.solid.volume()));
            findings
                .explain(
                    Severity::Warning,
                    "places are thinner than a layer, and no layer has them",
                    amount,
                    &self.name,
                )
                .try_to("a smaller --layer or --least-layer");
        }
        if args.feature_mm > 0.0 && left_out + added > 0.0 {
            let amount = format!("{left_out:.1} mm3 left out, {added:.1} mm3 filled");
            let place = format!("{}, features.csv", self.name);
            findings.add(Severity::Note, "features are machined later", amount, place);
        }
    }

    /// Where the torch does not get to.
    fn find_blocked(&self, args: &Args, findings: &mut Findings) {
        let share = self.blocked_share();
        if share <= 0.0 {
            return;
        }
        let blocked = |part: usize| self.audit.parts[part].blocked_mm2;
        let mut parts: Vec<usize> = (0..self.audit.parts.len()).filter(|&part| blocked(part) > 0.0).collect();
        parts.sort_by(|&a, &b| blocked(b).total_cmp(&blocked(a)));
        let worst = parts.iter().take(NAMED).map(|part| (part + 1).to_string()).collect::<Vec<_>>().join(", ");
        let more = if parts.len() > NAMED { format!(" and {} more", parts.len() - NAMED) } else { String::new() };
        let amount =
            format!("{:.1} mm2, {} of the layer area", self.audit.sum(|part| part.blocked_mm2), percent(share));
        let place = format!("{}, parts {worst}{more}; parts.csv", self.name);
        let severity = Severity::above(share, args.allow_blocked);
        findings
            .explain(severity, "the torch would collide with printed material or the plate", amount, place)
            .try_to("a smaller --torch")
            .try_to("a larger --stand-off")
            .try_to(if args.base == Base::Best { "" } else { "--base best" })
            .allow(accept("--allow-blocked", share));
    }
}
