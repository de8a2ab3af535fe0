//! Solids in parts with directions of their own.
//!
//! * `lettori`: the bent bar of the example `volume_decomposition` in volumes.
//! * `robofdm`: the shape of the example `robofdm`, from its mesh to tuned parts: skeleton, segments, sequence, tuning. With the head against
//!   what stands, and with base planes that look up.
//! * `beam`: the same solid by a beam search. Baseline: one of width 1, which is greedy.
//! * `audit`: the check of the parts.
//!
//! All results are audited before they are timed.
#![allow(missing_docs)] // of what criterion's macros make

use criterion::{Criterion, criterion_group, criterion_main};
use curvlay_examples::shapes;
use curvlay_layers::Progress;
use curvlay_layers::nalgebra::Vector3;
use curvlay_layers::planar::robofdm::{
    AuditOptions, BeamOptions, Decomposition, Head, SegmentOptions, SequenceOptions, TuningOptions, audit_parts,
    beam_search, plan_sequence, segment, tune,
};
use curvlay_layers::planar::{Solid, VolumeOptions, decompose_volume};
use std::ops::ControlFlow;

fn go(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn audited(solid: &Solid, parts: &Decomposition, head: Option<Head>) -> usize {
    let audited: Vec<_> = parts.parts.iter().map(|part| part.audited()).collect();
    let audit = audit_parts(solid, &audited, &AuditOptions { head, ..AuditOptions::default() }, &go).expect("options");
    assert!(audit.misplaced_points == 0 && audit.volume_error.abs() < 1e-9);
    assert!(audit.head_contacts.iter().all(|&contacts| contacts == 0));
    audit.layers.iter().sum()
}

fn decompositions(c: &mut Criterion) {
    let mut group = c.benchmark_group("decomposition");
    group.sample_size(10);
    let bend = shapes::bend();
    let bend = Solid::new(&bend.vertices, &bend.triangles).expect("a solid");
    let volumes = || decompose_volume(&bend, &VolumeOptions::default(), &go).expect("volumes");
    assert!(volumes().stuck.is_empty());
    group.bench_function("lettori", |b| b.iter(volumes));

    let mesh = shapes::branches();
    let solid = Solid::new(&mesh.vertices, &mesh.triangles).expect("a solid");
    let whole = |head: Option<Head>| {
        let segments = segment(&mesh.vertices, &mesh.triangles, &SegmentOptions::default()).expect("segments");
        let upright = SequenceOptions { direction: Some(Vector3::z()), ..SequenceOptions::default() };
        let sequence = plan_sequence(&mesh.vertices, &mesh.triangles, &segments, &upright).expect("a sequence");
        tune(&solid, &sequence, &TuningOptions { head, ..TuningOptions::default() }, &go).expect("parts")
    };
    let head = Some(Head::default());
    for (name, head) in [("robofdm/head", head), ("robofdm/planes", None)] {
        audited(&solid, &whole(head), head);
        group.bench_function(name, |b| b.iter(|| whole(head)));
    }
    for width in [10, 1] {
        let tuning = TuningOptions { head, ..TuningOptions::default() };
        let options = BeamOptions { tuning, width, ..BeamOptions::default() };
        let search = || beam_search(&solid, None, &options, &go).expect("parts");
        audited(&solid, &search(), head);
        group.bench_function(format!("beam/{width}"), |b| b.iter(search));
    }
    let parts = whole(head);
    group.bench_function("audit", |b| b.iter(|| audited(&solid, &parts, head)));
    group.finish();
}

criterion_group!(benches, decompositions);
criterion_main!(benches);
