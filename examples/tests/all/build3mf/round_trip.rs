//! What is written is read again, to the resolution that the format states.

use super::{direction, print, read, travel, wall, written};
use curvlay_examples::build3mf::{MAX_LINES, Segment, SegmentKind, UNIT_FACTOR_MM, direction_of, frame_at};
use curvlay_toolpath::nalgebra::{Isometry3, Point3, Quaternion, Unit, UnitVector3, Vector3};
use proptest::prelude::*;
use std::io::Cursor;

/// Least and greatest of something over all lines of a kind.
fn range(segments: &[Segment], kind: SegmentKind, of: impl Fn(&super::Line) -> Vec<f64>) -> [f64; 2] {
    let all = segments.iter().filter(|segment| segment.kind == kind).flat_map(|segment| &segment.lines).flat_map(of);
    all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
}

fn near_pose(found: &Isometry3<f64>, wanted: &Isometry3<f64>) -> Result<(), TestCaseError> {
    let off = (found.translation.vector - wanted.translation.vector).amax();
    prop_assert!(off <= UNIT_FACTOR_MM / 2.0 + 1e-9, "off by {off}");
    let turned = found.rotation.angle_to(&wanted.rotation);
    prop_assert!(turned < 5e-9, "turned by {turned}");
    Ok(())
}

fn near_segment(found: &Segment, wanted: &Segment, all: &[Segment]) -> Result<(), TestCaseError> {
    prop_assert_eq!((found.layer, found.path, found.kind), (wanted.layer, wanted.path, wanted.kind));
    let amounts = |s: &Segment| [s.filament_mm, s.prime_mm, s.retract_mm];
    for (found, wanted) in amounts(found).into_iter().zip(amounts(wanted)) {
        prop_assert!((found - wanted).abs() <= 5.1e-7, "{found} {wanted}");
    }
    near_pose(&found.start, &wanted.start)?;
    prop_assert_eq!(found.lines.len(), wanted.lines.len());
    let sizes = |line: &super::Line| {
        line.bead.map_or([[f64::NAN; 2]; 2], |ends| [ends.map(|end| end.width_mm), ends.map(|end| end.height_mm)])
    };
    let ranges = [0, 1].map(|which| range(all, wanted.kind, |line| sizes(line)[which].to_vec()));
    let [slow, fast] = range(all, wanted.kind, |line| line.speed_mm_s.into_iter().collect());
    for (found, wanted) in found.lines.iter().zip(&wanted.lines) {
        near_pose(&found.end, &wanted.end)?;
        prop_assert_eq!(found.bead.is_some(), wanted.bead.is_some());
        for which in [0, 1] {
            let (found, wanted, [low, high]) = (sizes(found)[which], sizes(wanted)[which], ranges[which]);
            for (found, wanted) in found.iter().zip(wanted).filter(|(_, wanted)| !wanted.is_nan()) {
                prop_assert!((found - wanted).abs() <= 5.1e-7 * (high - low) + 1e-12, "{found} {wanted}");
            }
        }
        prop_assert_eq!(found.speed_mm_s.is_some(), wanted.speed_mm_s.is_some());
        match (found.speed_mm_s, wanted.speed_mm_s) {
            (Some(found), Some(wanted)) => {
                prop_assert!((found - wanted).abs() <= 5.1e-7 * (fast - slow) + 1e-12, "{found} {wanted}");
            }
            _ => prop_assert!((found.seconds - wanted.seconds).abs() <= 5.1e-7),
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn segments_come_back(segments in print(), travels in any::<bool>()) {
        let kept: Vec<Segment> =
            segments.iter().filter(|segment| travels || segment.kind != SegmentKind::Travel).cloned().collect();
        prop_assume!(!kept.is_empty());
        let (_, found) = read(&written(&segments, travels)).unwrap();
        prop_assert_eq!(found.len(), kept.len());
        for (found, wanted) in found.iter().zip(&kept) {
            near_segment(found, wanted, &kept)?;
        }
    }

    /// What is read and written again is the same file: nothing drifts.
    #[test]
    fn what_was_read_is_written_alike(segments in print()) {
        let first = written(&segments, true);
        let (profiles, found) = read(&first).unwrap();
        let (again, twice) = read(&written(&found, true)).unwrap();
        for (one, other) in profiles.iter().zip(&again) {
            prop_assert_eq!((&one.name, one.kind), (&other.name, other.kind));
        }
        for (one, other) in found.iter().zip(&twice) {
            near_segment(other, one, &found)?;
        }
    }

    /// The quaternion takes z to the direction and turns about no other axis than it must.
    #[test]
    fn frames_have_the_direction(direction in direction()) {
        let frame = frame_at(Point3::origin(), direction);
        prop_assert!((direction_of(&frame).into_inner() - direction.into_inner()).norm() < 1e-12);
        prop_assert!(frame.rotation.k.abs() <= 0.0 && (frame.rotation.norm() - 1.0).abs() < 1e-12);
    }

    /// Halfway by the specification's nlerp is near halfway on the great circle, for directions up to a right angle from z.
    #[test]
    fn interpolated_directions_are_near_the_great_circle(
        lean in 0.0..90_f64, around in 0.0..360_f64, to_side in 0.0..360_f64, step in 0.0..2_f64
    ) {
        let spherical = |lean: f64, around: f64| {
            let (lean, around) = (lean.to_radians(), around.to_radians());
            Vector3::new(lean.sin() * around.cos(), lean.sin() * around.sin(), lean.cos())
        };
        let a = Unit::new_normalize(spherical(lean, around));
        let across = [a.cross(&Vector3::x()), a.cross(&Vector3::y())].into_iter().max_by(|p, q| p.norm().total_cmp(&q.norm()));
        let (u, side) = (across.unwrap().normalize(), to_side.to_radians());
        let way = u * side.cos() + a.cross(&u) * side.sin();
        let b = Unit::new_normalize(a.into_inner() * step.to_radians().cos() + way * step.to_radians().sin());
        prop_assume!(b.z >= 0.0);
        let [p, q] = [a, b].map(|direction| *frame_at(Point3::origin(), direction).rotation.quaternion());
        let q = if p.dot(&q) < 0.0 { -q } else { q };
        let halfway: Quaternion<f64> = (p + q) * 0.5;
        let found = Unit::new_normalize(halfway) * Vector3::z();
        let wanted = UnitVector3::new_normalize(a.into_inner() + b.into_inner());
        prop_assert!(found.angle(&wanted).to_degrees() < 0.01, "{}", found.angle(&wanted).to_degrees());
    }
}

/// The values of a small file, written out by hand.
#[test]
fn a_small_file_says_what_it_should() {
    let bytes = written(&[wall(), travel()], true);
    let parts = super::parts(&bytes);
    let names: Vec<&str> = parts.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(
        names,
        [
            "[Content_Types].xml",
            "_rels/.rels",
            "3D/_rels/3dmodel.model.rels",
            "3D/3dmodel.model",
            "Toolpath/Layers/layer00001.xml",
            "Toolpath/Layers/layer00002.xml"
        ]
    );
    let model = &parts[3].1;
    for words in [
        "requiredextensions=\"p tp n\"",
        "unitfactor=\"0.0001\" toolpathtype=\"6axis\"",
        "name=\"wall\" n:kind=\"wall\" beadwidth=\"0.5\" beadheight=\"0.3\" depositionspeed=\"20\"",
        "<tp:modifier attribute=\"beadwidth\" type=\"linear\" factor=\"e\" minvalue=\"0.4\" maxvalue=\"0.5\"/>",
        "<tp:modifier attribute=\"depositionspeed\" type=\"constant\" factor=\"g\" minvalue=\"10\" maxvalue=\"20\"/>",
        "name=\"travel\" n:kind=\"travel\" jumpspeed=\"80\"",
        "path=\"/Toolpath/Layers/layer00002.xml\" n:layer=\"2\"",
        "name=\"a &lt;part&gt; &amp; &quot;more&quot;\"",
        "tp:toolpathid=\"1\"",
    ] {
        assert!(model.contains(words), "{words}: {model}");
    }
    let wall = &parts[4].1;
    for words in [
        "type=\"polyline6d\" profileid=\"1\" partid=\"1\" tag=\"0\" timeprediction=\"150000\" n:prime=\"1\" n:retract=\"2\" n:filament=\"0.1\"",
        "<point6d x=\"0\" y=\"20000\" z=\"3000\" i=\"-0.098537618\"",
        " e1=\"0\" e2=\"1\" g=\"0\"/>",
        " e=\"1\" g=\"1\"/>",
    ] {
        assert!(wall.contains(words), "{words}: {wall}");
    }
    assert!(parts[5].1.contains(" n:seconds=\"0.25\"/>"), "{}", parts[5].1);
}

/// Without travels the file needs no words of ours, and says how long the way to a bead takes.
#[test]
fn beads_alone_have_the_time_of_their_travels() {
    let behind = super::Segment { layer: 1, path: 1, ..wall() };
    let bytes = written(&[wall(), travel(), behind], false);
    let parts = super::parts(&bytes);
    assert!(parts[3].1.contains("requiredextensions=\"p tp\"") && !parts[3].1.contains("travel"));
    let last = &parts[5].1;
    assert!(last.contains("jumpprediction=\"308750\"") && !parts[4].1.contains("jumpprediction"), "{last}");
}

/// The same build has the same bytes; another one has other UUIDs.
#[test]
fn the_bytes_follow_from_the_build() {
    assert_eq!(written(&[wall(), travel()], true), written(&[wall(), travel()], true));
    let other = super::Segment { filament_mm: 0.2, ..wall() };
    let [one, two] = [wall(), other].map(|wall| read(&written(&[wall, travel()], true)).unwrap().0);
    assert!(one.iter().zip(&two).all(|(a, b)| a.name == b.name && a.uuid != b.uuid));
}

/// A layer of many lines has several parts, all of the same layer.
#[test]
fn large_layers_are_cut_into_parts() {
    let line = wall().lines[0];
    let third = super::Segment { lines: vec![line; MAX_LINES / 3], ..wall() };
    let bytes = written(&vec![third; 7], true);
    let mut reader = super::BuildReader::open(Cursor::new(&bytes)).unwrap();
    let layers: Vec<Option<u32>> = reader.layers().iter().map(|part| part.layer).collect();
    assert_eq!(layers, [Some(0); 3]);
    let counts = [0, 1, 2].map(|part| reader.read_layer(part).unwrap().unwrap().len());
    assert_eq!(counts, [3, 3, 1]);
}
