//! From the mesh to audited parts.

use super::{Args, Avoid, Base, Method, print};
use curvlay_examples::args::{Failure, Part};
use curvlay_examples::bars::Bars;
use curvlay_examples::findings::{Findings, Severity, accept, percent};
use curvlay_examples::mesh::Mesh;
use curvlay_examples::nalgebra::{Isometry3, Rotation3, UnitQuaternion, Vector3};
use curvlay_examples::shapes;
use curvlay_layers::Progress;
use curvlay_layers::planar::Solid;
use curvlay_layers::planar::robofdm::{
    AuditOptions, AuditedPart, BeamOptions, BuildSequence, Decomposition, Head, PartsAudit, RoboFdmError, Root,
    SegmentOptions, Segmentation, SequenceOptions, TuningOptions, WorstLayer, audit_parts, beam_search,
    crossing_sections, plan_sequence, segment, tune,
};
use std::time::{Duration, Instant};

/// A solid in parts.
pub struct Divided {
    pub name: String,
    /// Upright on the plate.
    pub mesh: Mesh,
    pub solid: Solid,
    pub segmentation: Segmentation,
    /// What brought the file to where the part stands.
    pub placed: Isometry3<f64>,
    pub sequence: BuildSequence,
    /// What must meet nothing that stands, if that is what counts.
    pub head: Option<Head>,
    pub parts: Decomposition,
    pub audit: PartsAudit,
    /// Parts whose base sections cross.
    pub crossing: Vec<[usize; 2]>,
    pub decompose_time: Duration,
    pub audit_time: Duration,
    /// What there is to say about the mesh.
    pub of_mesh: Findings,
}

/// Divides the file, or the shape made in code.
pub fn divide(args: &Args, bars: &Bars) -> Result<Divided, Failure> {
    let part = args.mesh.load("branches", shapes::branches)?;
    let mut of_mesh = Findings::default();
    part.find(&mut of_mesh);
    of_mesh.say();
    let Part { name, mut mesh, .. } = part;
    let start = Instant::now();
    let max_angle = args.angle_deg.to_radians();
    let options = SegmentOptions { clusters: args.parts.map(|parts| parts as usize), ..SegmentOptions::default() };
    let root = args.root.map_or(Root::Best, Root::Part);
    // What is in the first layer lies on the platform.
    let platform = args.layer_height;
    let sequenced = SequenceOptions { max_angle, root, platform, ..SequenceOptions::default() };
    bars.update("segments", 0, 1);
    let segmentation = segment(&mesh.vertices, &mesh.triangles, &options)?;
    let mut placed = Isometry3::identity();
    let mut upright = SequenceOptions { direction: Some(Vector3::z()), ..sequenced };
    if args.base == Base::Best {
        let sequence = plan_sequence(&mesh.vertices, &mesh.triangles, &segmentation, &sequenced).map_err(no_root)?;
        if let Some(first) = sequence.parts.first() {
            let turn = Rotation3::rotation_between(&first.direction, &Vector3::z())
                .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
            mesh.vertices.iter_mut().for_each(|vertex| *vertex = turn * *vertex);
            placed.rotation = UnitQuaternion::from_rotation_matrix(&turn);
            upright.root = Root::Part(first.part);
        }
    }
    placed.translation = onto_plate(&mut mesh).into();
    let sequence = plan_sequence(&mesh.vertices, &mesh.triangles, &segmentation, &upright).map_err(no_root)?;
    let solid = Solid::new(&mesh.vertices, &mesh.triangles)?;
    let show = |at: Progress| bars.show(at.stage, at.done, at.total);
    let head = if args.avoid == Avoid::Head { Some(print::head(args, &mesh)?) } else { None };
    let tuning = TuningOptions {
        max_angle,
        platform,
        perturbations: args.perturbations,
        max_offset: args.max_offset,
        max_turn: args.max_turn_deg.to_radians(),
        max_section: args.max_section,
        candidates: usize::from(args.candidates),
        normals: usize::from(args.normals),
        spacing: args.spacing_mm,
        halvings: args.halvings,
        keep_sections_apart: args.keep_sections_apart,
        max_parts: usize::from(args.max_parts),
        min_piece: args.min_part,
        head,
        ..TuningOptions::default()
    };
    let parts = match args.method {
        Method::Robofdm => tune(&solid, &sequence, &tuning, &show)?,
        Method::Beam => {
            let options = BeamOptions { tuning, width: usize::from(args.width), ..BeamOptions::default() };
            beam_search(&solid, Some(&sequence), &options, &show)?
        }
    };
    let decompose_time = start.elapsed();

    let start = Instant::now();
    let audited: Vec<AuditedPart> = parts.parts.iter().map(|part| part.audited()).collect();
    let options = AuditOptions { max_angle, head, max_unsupported: args.allow_unsupported, ..AuditOptions::default() };
    let audit = audit_parts(&solid, &audited, &options, &show)?;
    Ok(Divided {
        name,
        mesh,
        solid,
        segmentation,
        placed,
        sequence,
        head,
        crossing: crossing_sections(&parts.parts),
        parts,
        audit,
        decompose_time,
        audit_time: start.elapsed(),
        of_mesh,
    })
}

/// A root that is none is an argument of the user's.
fn no_root(error: RoboFdmError) -> Failure {
    match error {
        RoboFdmError::Root { root, parts } => Failure::of_arguments(format!(
            "--root {root}: there are {parts} segments, from 0 to {}; a run without --root draws them with their numbers (segments.png)",
            parts.saturating_sub(1)
        )),
        other => other.into(),
    }
}

/// Moves a mesh to the plane z = 0, its box in the middle; the shift.
fn onto_plate(mesh: &mut Mesh) -> Vector3<f64> {
    let Some([low, high]) = mesh.bounds() else { return Vector3::zeros() };
    let middle = low + (high - low) / 2.0;
    let shift = Vector3::new(-middle.x, -middle.y, -low.z);
    mesh.vertices.iter_mut().for_each(|vertex| *vertex += shift);
    shift
}

impl Divided {
    /// Area of the layers that the audit finds on nothing.
    pub fn unsupported_mm2(&self) -> f64 {
        self.audit.unsupported_mm2.iter().sum()
    }

    /// Share of the risky area that is left.
    pub fn risky_share(&self) -> f64 {
        self.parts.risky_mm2() / self.parts.risky_before_mm2.max(f64::MIN_POSITIVE)
    }

    /// What is wrong.
    pub fn find(&self, args: &Args, findings: &mut Findings) {
        let (share, goal) = (self.risky_share(), TuningOptions::default().goal);
        let is_full = self.parts.parts.len() >= usize::from(args.max_parts);
        if share > goal.min(args.allow_risky) {
            let amount = format!("{:.1} mm2, {} of the risky area", self.parts.risky_mm2(), percent(share));
            let advice = |holds: bool, what: &'static str| if holds { what } else { "" };
            findings
                .explain(Severity::above(share, args.allow_risky), "sides lean out over nothing", amount, "parts.csv")
                .try_to(advice(is_full, "a larger --max-parts"))
                .try_to(advice(args.base != Base::Best, "--base best"))
                .try_to("a smaller --min-part")
                .try_to(advice(self.head.is_some(), "a workcell with a more slender head"))
                .try_to("curved layers, with support where they need it: the example curved_layers")
                .allow(accept("--allow-risky", share));
        }
        if is_full {
            let amount = args.max_parts.to_string();
            findings.add(Severity::Told, "there are as many parts as may be", amount, "--max-parts");
        }
        let audit = &self.audit;
        if audit.volume_error.abs() > AuditOptions::default().max_volume_error {
            findings.add(Severity::Failed, "volumes do not add up", format!("{:.1e}", audit.volume_error), "");
        }
        if audit.misplaced_points > 0 {
            let amount = audit.misplaced_points.to_string();
            findings.add(Severity::Failed, "points are in no part, or in several", amount, "");
        }
        for [a, b] in &self.crossing {
            findings.add(Severity::Told, "base sections cross", "", format!("parts {} and {}", a + 1, b + 1));
        }
        for (part, &contacts) in audit.head_contacts.iter().enumerate().filter(|(_, contacts)| **contacts > 0) {
            let amount = format!("{contacts} places, {:.2} mm at most", audit.deepest_contact_mm);
            findings.add(Severity::Failed, "the head is in what stands", amount, format!("part {}", part + 1));
        }
        for &part in audit.looking_down.iter().filter(|_| self.head.is_none()) {
            findings.add(Severity::Failed, "a base plane looks down", "", format!("part {}", part + 1));
        }
        let (hanging, layers) = (audit.hanging_layers.iter().sum::<usize>(), audit.layers.iter().sum::<usize>());
        if let Some(WorstLayer { part, layer, share }) = audit.worst_layer.filter(|_| hanging > 0) {
            let what = format!("layers lie on nothing by more than {}", percent(args.allow_unsupported));
            let amount = format!("{hanging} of {layers}, {:.1} mm2 in all", self.unsupported_mm2());
            let place = format!("parts.csv; most, {}, in layer {} of part {}", percent(share), layer + 1, part + 1);
            findings.explain(Severity::Failed, what, amount, place).allow(accept("--allow-unsupported", share));
        }
    }
}
