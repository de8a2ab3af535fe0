//! From the mesh to audited parts.

use super::ways::{Found, Ways, sought};
use super::{Args, Avoid, Base, workcell};
use curvlay_examples::args::{Failure, Part};
use curvlay_examples::bars::Bars;
use curvlay_examples::count::counted;
use curvlay_examples::findings::{Findings, Severity, accept, at_most_mm, percent};
use curvlay_examples::mesh::Mesh;
use curvlay_examples::nalgebra::{Isometry3, Rotation3, UnitQuaternion, Vector3};
use curvlay_examples::shapes;
use curvlay_layers::planar::Solid;
use curvlay_layers::planar::robofdm::{
    AuditOptions, BuildSequence, Decomposition, Head, Hold, Left, LeftReason, PartsAudit, Pedestal, RoboFdmError, Root,
    SegmentOptions, Segmentation, SequenceOptions, TuningOptions, WorstLayer, crossing_sections, plan_sequence,
    segment,
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
    /// What the part stands on, if it is not the plate.
    pub pedestal: Option<Pedestal>,
    /// How parts were sought.
    pub ways: Ways,
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
    let options = SegmentOptions { clusters: args.parts.map(|parts| parts as usize), ..SegmentOptions::default() };
    let root = args.root.map_or(Root::Best, Root::Part);
    // What is in the first layer lies on the platform.
    let (max_angle, platform) = (args.angle_deg.to_radians(), args.layer_height);
    let sequenced = SequenceOptions { max_angle, root, platform, ..SequenceOptions::default() };
    bars.update("segments", 0, 1);
    let segmentation = segment(&mesh.vertices, &mesh.triangles, &options)?;
    let (placed, sequence) = placed(args, &mut mesh, &segmentation, &sequenced)?;
    let solid = Solid::new(&mesh.vertices, &mesh.triangles)?;
    let head = if args.avoid == Avoid::Head { Some(workcell::head(args, &mesh)?) } else { None };
    let tuning = tuning(args, head);
    let (Found { parts, head, audit, audit_time }, ways) = sought(args, &solid, &sequence, &tuning, bars)?;
    let pedestal = head.and_then(|head| {
        let first = parts.parts.first()?;
        Pedestal::new(&first.solid, &first.direction, head.layer, head.pedestal)
    });
    let decompose_time = start.elapsed().saturating_sub(audit_time);
    Ok(Divided {
        name,
        mesh,
        solid,
        segmentation,
        placed,
        sequence,
        head,
        pedestal,
        ways,
        crossing: crossing_sections(&parts.parts),
        parts,
        audit,
        decompose_time,
        audit_time,
        of_mesh,
    })
}

/// Puts the mesh on the plate, as it lies or with the best segment at the bottom, and plans the sequence of its segments upright from there.
fn placed(
    args: &Args,
    mesh: &mut Mesh,
    segmentation: &Segmentation,
    sequenced: &SequenceOptions,
) -> Result<(Isometry3<f64>, BuildSequence), Failure> {
    let mut placed = Isometry3::identity();
    let mut upright = SequenceOptions { direction: Some(Vector3::z()), ..*sequenced };
    if args.base == Base::Best {
        let sequence = plan_sequence(&mesh.vertices, &mesh.triangles, segmentation, sequenced).map_err(no_root)?;
        if let Some(first) = sequence.parts.first() {
            let turn = Rotation3::rotation_between(&first.direction, &Vector3::z())
                .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
            mesh.vertices.iter_mut().for_each(|vertex| *vertex = turn * *vertex);
            placed.rotation = UnitQuaternion::from_rotation_matrix(&turn);
            upright.root = Root::Part(first.part);
        }
    }
    placed.translation = onto_plate(mesh).into();
    let sequence = plan_sequence(&mesh.vertices, &mesh.triangles, segmentation, &upright).map_err(no_root)?;
    Ok((placed, sequence))
}

/// How planes are tuned, with a head to be kept out of what stands.
fn tuning(args: &Args, head: Option<Head>) -> TuningOptions {
    TuningOptions {
        max_angle: args.angle_deg.to_radians(),
        // What is in the first layer lies on the platform.
        platform: args.layer_height,
        perturbations: args.perturbations,
        max_offset: args.max_offset_share,
        max_turn: args.max_turn_deg.to_radians(),
        max_section: args.max_section,
        candidates: usize::from(args.candidates),
        normals: usize::from(args.normals),
        spacing: args.spacing_mm,
        halvings: args.halvings,
        keep_sections_apart: args.keep_sections_apart,
        max_parts: usize::from(args.max_parts),
        min_piece: args.min_part_share,
        head,
        strength: args.strength(),
        ..TuningOptions::default()
    }
}

/// Parts whose reason is in the finding; the others are in the table.
const MAX_CAUSES: usize = 5;

/// Why risky area is left in a part, in words without a comma.
pub fn reason(left: &Left) -> String {
    let best = format!("the best plane would save {:.1} mm2 but", left.promise_mm2);
    match left.reason {
        LeftReason::NoPlane => "no plane takes enough of it off".to_owned(),
        LeftReason::NoPiece => "planes take off too small pieces or such that would float".to_owned(),
        LeftReason::MaxParts => format!("{best} there are --max-parts"),
        LeftReason::TooLittle => "what planes take off is hardly less risky".to_owned(),
        LeftReason::Platform => format!("{best} the head would collide with the plate"),
        LeftReason::Part(part) if part == left.part => format!("{best} the head would collide with the rest of it"),
        LeftReason::Part(part) => format!("{best} the head would collide with part {}", part + 1),
        LeftReason::Weak => format!("{best} a seam would be too weak"),
        LeftReason::Unsound => format!("{best} a piece would touch itself along an edge"),
        _ => format!("{best} the search ended before"),
    }
}

/// An invalid root is an invalid argument.
fn no_root(error: RoboFdmError) -> Failure {
    match error {
        RoboFdmError::Root { root, parts } => Failure::of_arguments(format!(
            "--root {root}: the mesh has {}, from 0 to {}; a run without --root draws them with their numbers (segments.png)",
            counted(parts, "segment"),
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

    /// How high the pedestal lifts the part.
    pub fn raised_mm(&self) -> f64 {
        self.pedestal.as_ref().map_or(0.0, Pedestal::height_mm)
    }

    /// What is printed before the parts: the pedestal, if there is one.
    pub fn before_parts(&self) -> usize {
        usize::from(self.pedestal.is_some())
    }

    /// All that is printed, on the plate: the part, on its pedestal.
    pub fn standing(&self) -> Mesh {
        let mut mesh = self.mesh.clone();
        if let Some(pedestal) = &self.pedestal {
            let (vertices, triangles) = pedestal.mesh();
            let first = mesh.vertices.len() as u32;
            mesh.vertices.extend(vertices);
            mesh.triangles.extend(triangles.into_iter().map(|corners| corners.map(|v| v + first)));
            let raised_mm = self.raised_mm();
            mesh.vertices.iter_mut().for_each(|vertex| vertex.z += raised_mm);
        }
        mesh
    }

    /// Why risky area is left in a part, if it was asked.
    pub fn left(&self, part: usize) -> Option<&Left> {
        self.parts.left.iter().find(|left| left.part == part)
    }

    /// How a part is held.
    pub fn hold(&self, part: usize) -> Option<&Hold> {
        self.parts.holds.get(part)
    }

    /// All reasons, the part with the most risky area first.
    fn causes(&self) -> String {
        let mut left: Vec<&Left> = self.parts.left.iter().collect();
        left.sort_by(|a, b| b.risky_mm2.total_cmp(&a.risky_mm2));
        let one = |left: &&Left| format!("part {}, {:.1} mm2: {}", left.part + 1, left.risky_mm2, reason(left));
        let mut causes: Vec<String> = left.iter().take(MAX_CAUSES).map(one).collect();
        if left.len() > MAX_CAUSES {
            causes.push(format!("{} more in parts.csv", left.len() - MAX_CAUSES));
        }
        causes.join("; ")
    }

    /// What is wrong.
    pub fn find(&self, args: &Args, findings: &mut Findings) {
        self.find_in_division(args, findings);
        self.find_in_audit(args, findings);
    }

    /// Risky area, the limit of parts, the pedestal, and how parts hold.
    fn find_in_division(&self, args: &Args, findings: &mut Findings) {
        let (share, goal) = (self.risky_share(), TuningOptions::default().goal);
        let is_full = self.parts.parts.len() >= usize::from(args.max_parts);
        if share > goal.min(args.allow_risky) {
            let amount = format!("{:.1} mm2, {} of the risky area", self.parts.risky_mm2(), percent(share));
            let advice = |holds: bool, what: &'static str| if holds { what } else { "" };
            let has = |of: &dyn Fn(LeftReason) -> bool| self.parts.left.iter().any(|left| of(left.reason));
            let is_in_way = |reason| matches!(reason, LeftReason::Platform | LeftReason::Part(_));
            findings
                .explain(Severity::above(share, args.allow_risky), "sides lean out over nothing", amount, "parts.csv")
                .cause(self.causes())
                .try_to(advice(is_full, "a larger --max-parts"))
                .try_to(advice(args.base != Base::Best, "--base best"))
                .try_to(advice(has(&|reason| reason == LeftReason::NoPiece), "a smaller --min-part"))
                .try_to(advice(has(&is_in_way), "a workcell with a more slender head"))
                .try_to(advice(has(&|reason| reason == LeftReason::Platform), "a higher --pedestal"))
                .try_to(advice(has(&|reason| reason == LeftReason::Weak), "a smaller --safety"))
                .try_to("curved layers, with support where they need it: the example curved_layers")
                .allow(accept("--allow-risky", share));
        }
        if is_full {
            let amount = args.max_parts.to_string();
            findings.add(Severity::Warning, "there are as many parts as may be", amount, "--max-parts");
        }
        if let Some(pedestal) = &self.pedestal {
            let amount = format!("{:.1} mm high, {:.0} mm3", pedestal.height_mm(), pedestal.volume_mm3());
            findings
                .explain(
                    Severity::Warning,
                    "the part stands on a pedestal that is to be cut off",
                    amount,
                    "pedestal.stl",
                )
                .try_to("--pedestal 0, without one");
        }
        for hold in self.parts.holds.iter().filter(|hold| hold.share() > 1.0) {
            let what = if hold.on_platform { "the foot is too small to hold the part" } else { "a seam is too weak" };
            let amount = format!("{:.1} MPa, {:.1} allowed", hold.stress_mpa, hold.allowed_mpa);
            let place = format!("part {}, which carries {:.1} cm3", hold.part + 1, 1e-3 * hold.carried_mm3);
            findings
                .explain(Severity::Warning, what, amount, place)
                .try_to(if hold.on_platform && args.base != Base::Best { "--base best" } else { "" })
                .try_to("a brim, or what is known of the bond: --bond, --plate-bond, --print-force, --safety");
        }
    }

    /// What the audit of the parts says.
    fn find_in_audit(&self, args: &Args, findings: &mut Findings) {
        let audit = &self.audit;
        if audit.volume_error.abs() > AuditOptions::default().max_volume_error {
            findings.add(Severity::Failed, "volumes do not add up", format!("{:.1e}", audit.volume_error), "");
        }
        if audit.misplaced_points > 0 {
            let amount = audit.misplaced_points.to_string();
            findings.add(Severity::Failed, "points are in no part, or in several", amount, "");
        }
        for [a, b] in &self.crossing {
            findings.add(Severity::Warning, "base sections cross", "", format!("parts {} and {}", a + 1, b + 1));
        }
        for (part, &contacts) in audit.head_contacts.iter().enumerate().filter(|(_, contacts)| **contacts > 0) {
            let amount = format!("{}, {}", counted(contacts, "place"), at_most_mm(audit.deepest_contact_mm));
            findings.add(Severity::Failed, "the head is in what stands", amount, format!("part {}", part + 1));
        }
        for &part in audit.looking_down.iter().filter(|_| self.head.is_none()) {
            findings.add(Severity::Failed, "a base plane looks down", "", format!("part {}", part + 1));
        }
        let (hanging, layers) = (audit.hanging_layers.iter().sum::<usize>(), audit.layers.iter().sum::<usize>());
        if let Some(WorstLayer { part, layer, share }) = audit.worst_layer.filter(|_| hanging > 0) {
            let what = format!("layers are unsupported by more than {}", percent(args.allow_unsupported));
            let amount = format!("{hanging} of {layers}, {:.1} mm2 in all", self.unsupported_mm2());
            let place = format!("parts.csv; most, {}, in layer {} of part {}", percent(share), layer + 1, part + 1);
            findings.explain(Severity::Failed, what, amount, place).allow(accept("--allow-unsupported", share));
        }
    }
}
