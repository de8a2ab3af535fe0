//! Damaged files and impossible builds: a typed error each, never a panic.

use super::{mesh, package_of, parts, print, read, travel, wall, written};
use curvlay_examples::build3mf::{
    BuildOptions, Line, ReadBuildError, Section, Segment, SegmentKind, WriteBuildError, write_build,
};
use curvlay_examples::mesh::Mesh;
use curvlay_toolpath::nalgebra::{Isometry3, Quaternion, Translation3, Unit};
use proptest::prelude::*;
use std::cell::Cell;
use std::io::{self, Cursor, Seek, SeekFrom, Write};

const MODEL: &str = "3D/3dmodel.model";
const LAYER: &str = "Toolpath/Layers/layer00001.xml";

/// What the reader says of a file in which a text of a part is another.
fn of(part: &str, from: &str, to: &str) -> ReadBuildError {
    let mut all = parts(&written(&[wall(), travel()], true));
    let text = &mut all.iter_mut().find(|(name, _)| name == part).unwrap().1;
    assert!(text.contains(from), "{from}: {text}");
    *text = text.replacen(from, to, 1);
    read(&package_of(&all)).unwrap_err()
}

#[test]
fn faults_of_a_layer_have_names() {
    use ReadBuildError as E;
    let x = of(LAYER, "profileid=\"1\"", "profileid=\"9\"");
    assert!(matches!(x, E::UnknownProfile { segment: 1, id: 9, .. }), "{x}");
    let x = of(LAYER, "partid=\"1\"", "partid=\"2\"");
    assert!(matches!(x, E::UnknownPart { segment: 1, id: 2, .. }), "{x}");
    let x = of(LAYER, " k=\"0\"", " k=\"0.5\"");
    assert!(matches!(x, E::Quaternion { segment: 1, point: 1, length, .. } if (length - 1.118).abs() < 1e-3), "{x}");
    let x = of(LAYER, "type=\"polyline6d\"", "type=\"loop\"");
    assert!(matches!(&x, E::Unsupported { what, .. } if what.contains("loop")), "{x}");
    let x = of(LAYER, "y=\"20000\"", "y=\"2e4\"");
    assert!(matches!(&x, E::Attribute { attribute, .. } if attribute == "y"), "{x}");
    let x = of(LAYER, "y=\"20000\"", "");
    assert!(x.to_string().contains("segment 1, point 1: `y` is missing"), "{x}");
    let x = of(LAYER, "e1=\"0\"", "e1=\"1.5\"");
    assert!(matches!(&x, E::Attribute { attribute, wanted: "from 0 to 1", .. } if attribute == "e1"), "{x}");
    let x = of(LAYER, " g=\"0\"", " g1=\"0\" g2=\"1\"");
    assert!(matches!(&x, E::Attribute { attribute, .. } if attribute == "g1"), "{x}");
    let x = of(LAYER, "e1=\"0\"", "e=\"0\" e1=\"0\"");
    assert!(matches!(x, E::Attribute { .. }), "{x}");
    let x = of(LAYER, "<part id=\"1\" uuid=\"", "<part id=\"1\" uuid=\"0");
    assert!(matches!(x, E::UnknownUuid { what: "build item", .. }), "{x}");
    let x = of(LAYER, "<profile id=\"1\" uuid=\"", "<profile id=\"1\" uuid=\"0");
    assert!(matches!(x, E::UnknownUuid { what: "profile", .. }), "{x}");
    let x = of(LAYER, "<profile id=\"2\"", "<profile id=\"1\"");
    assert!(matches!(&x, E::Attribute { attribute, .. } if attribute == "id"), "{x}");
    let x = of(LAYER, "</layer>", "");
    assert!(matches!(x, E::Xml { .. }), "{x}");
    let x = of(LAYER, "<layer ", "<!DOCTYPE layer [<!ENTITY a \"b\">]><layer ");
    assert!(matches!(x, E::Xml { .. }), "{x}");
    let x = of(LAYER, "toolpath/2026/03\"", "toolpath/2019/05\"");
    assert!(matches!(x, E::Unsupported { .. }), "{x}");
}

#[test]
fn faults_of_a_model_have_names() {
    use ReadBuildError as E;
    let x = of(MODEL, "requiredextensions=\"p tp n\"", "requiredextensions=\"p tp n xml\"");
    assert!(matches!(&x, E::Extension { namespace, .. } if namespace == "xml"), "{x}");
    let x = of(MODEL, "toolpathtype=\"6axis\"", "toolpathtype=\"planar\"");
    assert!(matches!(x, E::Unsupported { .. }), "{x}");
    let x = of(MODEL, "unitfactor=\"0.0001\"", "unitfactor=\"0\"");
    assert!(matches!(&x, E::Attribute { attribute, .. } if attribute == "unitfactor"), "{x}");
    let x = of(MODEL, "tp:toolpathid=\"1\"", "tp:toolpathid=\"7\"");
    assert!(matches!(x, E::NoToolpath { .. }), "{x}");
    let x = of(MODEL, "type=\"linear\"", "type=\"nonlinear\"");
    assert!(matches!(x, E::Unsupported { .. }), "{x}");
    let x = of(MODEL, "attribute=\"beadwidth\"", "attribute=\"laserpower\"");
    assert!(matches!(x, E::Unsupported { .. }), "{x}");
    let x = of(MODEL, "minvalue=\"0.4\"", "minvalue=\"0.6\"");
    assert!(matches!(&x, E::Attribute { attribute, .. } if attribute == "maxvalue"), "{x}");
    let x = of(MODEL, "minvalue=\"0.4\"", "minvalue=\"-0.4\"");
    assert!(matches!(&x, E::Attribute { attribute, .. } if attribute == "minvalue"), "{x}");
    let x = of(MODEL, "factor=\"g\"", "factor=\"e\"");
    assert!(matches!(&x, E::Attribute { attribute, .. } if attribute == "factor"), "{x}");
    let x = of(MODEL, "unit=\"millimeter\"", "unit=\"cubit\"");
    assert!(matches!(&x, E::Attribute { attribute, .. } if attribute == "unit"), "{x}");
    let x = of(MODEL, "n:layer=\"2\"", "n:layer=\"1.5\"");
    assert!(matches!(&x, E::Attribute { attribute, .. } if attribute == "layer"), "{x}");
    let x = of(MODEL, "/Toolpath/Layers/layer00002.xml", "/Toolpath/Layers/other.xml");
    assert!(matches!(&x, E::NoRelationship { target, .. } if target.contains("other")), "{x}");
}

#[test]
fn faults_of_the_package_have_names() {
    use ReadBuildError as E;
    let relations = "3D/_rels/3dmodel.model.rels";
    let x = of(relations, "2026/03/layer", "2019/05/layer");
    assert!(matches!(&x, E::NoRelationship { target, .. } if target.contains("layer00001")), "{x}");
    let x = of("_rels/.rels", "2013/01/3dmodel", "2013/01/other");
    assert!(matches!(x, E::NoRelationship { .. }), "{x}");
    let all = parts(&written(&[wall(), travel()], true));
    let without = |name: &str| {
        let kept: Vec<_> = all.iter().filter(|(other, _)| other != name).cloned().collect();
        read(&package_of(&kept)).unwrap_err()
    };
    assert!(matches!(without(LAYER), E::NoPart { part } if part.contains("layer00001")));
    assert!(matches!(without(MODEL), E::NoPart { .. }));
    assert!(matches!(without(relations), E::NoRelationship { .. }));
    assert!(matches!(without("_rels/.rels"), E::NoRelationship { .. }));
    assert!(matches!(read(b"solid part"), Err(E::Archive(_))));
}

/// The central directory is at the end: whatever is cut off, the archive is none.
#[test]
fn a_truncated_file_is_refused() {
    let bytes = written(&[wall(), travel()], true);
    for length in (0..bytes.len()).step_by(7) {
        let error = read(&bytes[..length]).unwrap_err();
        assert!(matches!(error, ReadBuildError::Archive(_)), "{length}: {error}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    /// Whatever a few bytes are, there is an error or a build, and no panic.
    #[test]
    fn damaged_files_do_no_harm(segments in print(), changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6)) {
        let mut bytes = written(&segments, true);
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Ok((_, found)) = read(&bytes) {
            prop_assert!(found.len() <= segments.len());
        }
    }

    /// The same within the text of a layer, which a checksum would otherwise guard.
    #[test]
    fn damaged_layers_do_no_harm(changes in prop::collection::vec((any::<prop::sample::Index>(), b' '..b'~'), 1..4)) {
        let mut all = parts(&written(&[wall(), travel()], true));
        let mut text = all[4].1.clone().into_bytes();
        for (at, value) in changes {
            let at = at.index(text.len());
            text[at] = value;
        }
        all[4].1 = String::from_utf8(text).unwrap();
        if let Ok((_, found)) = read(&package_of(&all)) {
            prop_assert!(found.iter().flat_map(|segment| &segment.lines).all(|line| line.end.translation.vector.iter().all(|n| n.is_finite())));
        }
    }
}

fn refused(mesh: &Mesh, segments: &[Segment], travels: bool) -> WriteBuildError {
    let options = BuildOptions { name: "part", travels };
    write_build(mesh, || segments.iter().cloned(), &options, Cursor::new(Vec::new())).unwrap_err()
}

fn with(change: impl FnOnce(&mut Segment)) -> WriteBuildError {
    let mut segment = wall();
    change(&mut segment);
    refused(&mesh(), &[travel(), segment], true)
}

#[test]
fn impossible_builds_are_refused() {
    use WriteBuildError as E;
    assert!(matches!(refused(&Mesh::default(), &[wall()], true), E::NoMesh));
    assert!(matches!(refused(&mesh(), &[], true), E::NoSegments));
    assert!(matches!(refused(&mesh(), &[travel()], false), E::NoSegments));
    let section = Section { width_mm: 0.0, height_mm: 0.3 };
    assert!(matches!(
        with(|s| s.lines[1].bead = Some([section; 2])),
        E::Number { segment: 1, line: 1, what: "width_mm", .. }
    ));
    assert!(matches!(with(|s| s.lines[0].bead = None), E::Segment { segment: 1, .. }));
    assert!(matches!(with(|s| s.kind = SegmentKind::Travel), E::Segment { segment: 1, .. }));
    assert!(matches!(with(|s| s.lines.clear()), E::Segment { segment: 1, .. }));
    assert!(matches!(with(|s| s.lines[0].speed_mm_s = Some(f64::NAN)), E::Number { what: "speed_mm_s", .. }));
    assert!(matches!(with(|s| s.lines[0].seconds = -1.0), E::Number { what: "seconds", .. }));
    assert!(matches!(with(|s| s.filament_mm = f64::INFINITY), E::Number { what: "filament_mm", .. }));
    let moved = |x| move |s: &mut Segment| s.lines[1].end.translation = Translation3::new(x, 0.0, 0.0);
    assert!(matches!(with(moved(f64::NAN)), E::Number { segment: 1, line: 1, what: "x", .. }));
    // 214,748.3647 mm is the last place that an integer of 32 bits reaches.
    assert!(matches!(with(moved(214_748.364_8)), E::Number { what: "x", .. }));
    let stretched = Unit::new_unchecked(Quaternion::new(1.1, 0.0, 0.0, 0.0));
    let turned = move |s: &mut Segment| s.start = Isometry3::from_parts(s.start.translation, stretched);
    assert!(matches!(with(turned), E::Number { what: "length of the quaternion", .. }));
}

#[test]
fn the_farthest_places_are_written() {
    for x in [214_748.364_7, -214_748.364_7] {
        let mut segment = wall();
        segment.start.translation = Translation3::new(x, 0.0, 0.0);
        let (_, found) = read(&written(&[segment], true)).unwrap();
        assert!((found[0].start.translation.x - x).abs() < 1e-6);
    }
}

/// Segments that are others the second time would not fit the profiles.
#[test]
fn segments_that_change_are_found() {
    let round = Cell::new(0);
    let segments = || {
        round.set(round.get() + 1);
        let width_mm = if round.get() == 1 { 0.5 } else { 0.6 };
        let mut segment = wall();
        segment.lines[1].bead = Some([Section { width_mm, height_mm: 0.3 }; 2]);
        [segment].into_iter()
    };
    let options = BuildOptions { name: "part", travels: true };
    let error = write_build(&mesh(), segments, &options, Cursor::new(Vec::new())).unwrap_err();
    assert!(matches!(error, WriteBuildError::Changed { .. }), "{error}");
}

/// Output that is full after some bytes.
struct Full {
    inner: Cursor<Vec<u8>>,
    left: usize,
}

impl Write for Full {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.left = self.left.checked_sub(bytes.len()).ok_or(io::ErrorKind::StorageFull)?;
        self.inner.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Full {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.inner.seek(to)
    }
}

#[test]
fn a_full_disk_is_an_error_wherever_it_is_full() {
    let whole = written(&[wall(), travel()], true).len();
    for left in (0..whole).step_by(101) {
        let out = Full { inner: Cursor::new(Vec::new()), left };
        let options = BuildOptions { name: "a <part> & \"more\"", travels: true };
        let error = write_build(&mesh(), || [wall(), travel()].into_iter(), &options, out).unwrap_err();
        assert!(
            matches!(&error, WriteBuildError::Io(error) if error.kind() == io::ErrorKind::StorageFull),
            "{left}: {error}"
        );
    }
}

/// A line that says nothing of its bead has that of the profile.
#[test]
fn numbers_of_the_profile_hold_where_a_line_has_none() {
    let mut all = parts(&written(&[wall()], true));
    all[4].1 = all[4].1.replace(" e1=\"0\" e2=\"1\" g=\"0\"", "");
    let (_, found) = read(&package_of(&all)).unwrap();
    let Line { bead, speed_mm_s, .. } = found[0].lines[0];
    assert_eq!((bead, speed_mm_s), (Some([Section { width_mm: 0.5, height_mm: 0.3 }; 2]), Some(20.0)));
}
