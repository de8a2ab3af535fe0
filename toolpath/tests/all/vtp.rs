//! `.vtp` files, read by the rules of VTK's XML format: the header names arrays, offsets and types, the raw data has them.

use curvlay_toolpath::deposit::{DepositionOptions, deposit};
use curvlay_toolpath::nalgebra::{Point3, Vector3};
use curvlay_toolpath::orientation::{ToolPath, Waypoint};
use curvlay_toolpath::path::BeadKind;
use curvlay_toolpath::vtp::write_paths_vtp;

fn attribute<'a>(tag: &'a str, name: &str) -> &'a str {
    tag.split_once(&format!(" {name}=\"")).unwrap().1.split_once('"').unwrap().0
}

/// The array of a name: its type and its bytes.
fn array<'a>(file: &'a [u8], name: &str) -> (String, &'a [u8]) {
    let marker = b"<AppendedData encoding=\"raw\">\n_";
    let at = file.windows(marker.len()).position(|window| window == marker).unwrap();
    let (header, data) = (std::str::from_utf8(&file[..at]).unwrap(), &file[at + marker.len()..]);
    assert_eq!(attribute(header, "header_type"), "UInt64");
    let tag = header.split('<').find(|tag| tag.starts_with("DataArray") && attribute(tag, "Name") == name).unwrap();
    let offset: usize = attribute(tag, "offset").parse().unwrap();
    let length = u64::from_le_bytes(data[offset..offset + 8].try_into().unwrap()) as usize;
    (attribute(tag, "type").to_owned(), &data[offset + 8..offset + 8 + length])
}

fn floats(file: &[u8], name: &str) -> Vec<f32> {
    let (kind, bytes) = array(file, name);
    assert_eq!(kind, "Float32");
    bytes.chunks(4).map(|chunk| f32::from_le_bytes(chunk.try_into().unwrap())).collect()
}

fn integers(file: &[u8], name: &str) -> Vec<i32> {
    array(file, name).1.chunks(4).map(|chunk| i32::from_le_bytes(chunk.try_into().unwrap())).collect()
}

#[test]
fn arrays_hold_what_is_printed() {
    let at = |x: f64, z: f64, kind| Waypoint {
        position: Point3::new(x, 0.5, z),
        axis: Vector3::z_axis(),
        width: 0.5 + x / 100.0,
        height: 0.25,
        arc: x,
        added: false,
        lift: Vector3::zeros(),
        kind,
    };
    let path = |layer, waypoints| ToolPath { layer, curve: 0, closed: false, waypoints };
    let paths = [
        path(0, vec![at(0.0, 0.25, BeadKind::Wall), at(10.0, 0.25, BeadKind::Wall), at(20.0, 0.25, BeadKind::Skin)]),
        path(1, vec![at(5.0, 0.5, BeadKind::Infill), at(15.0, 0.5, BeadKind::Solid)]),
    ];
    let plan = deposit(&paths, &DepositionOptions::default()).unwrap();
    let mut file = Vec::new();
    write_paths_vtp(&paths, &plan.moves, &mut file).unwrap();
    assert!(file.ends_with(b"\n</AppendedData>\n</VTKFile>\n"));
    let text = String::from_utf8_lossy(&file);
    let piece = text.split('<').find(|tag| tag.starts_with("Piece")).unwrap();
    assert_eq!((attribute(piece, "NumberOfPoints"), attribute(piece, "NumberOfLines")), ("5", "2"));
    for group in ["PointData", "CellData", "Points", "Lines", "Piece", "PolyData", "VTKFile"] {
        assert_eq!(text.matches(&format!("</{group}>")).count(), 1, "{group}");
    }
    assert_eq!(floats(&file, "points")[..6], [0.0, 0.5, 0.25, 10.0, 0.5, 0.25]);
    assert_eq!(floats(&file, "direction")[12..], [0.0, 0.0, 1.0]);
    assert_eq!((floats(&file, "width_mm")[2], floats(&file, "height_mm")[4]), (0.7, 0.25));
    assert_eq!(array(&file, "kind"), ("UInt8".to_owned(), &[0, 0, 2, 3, 1][..]));
    assert_eq!((integers(&file, "layer"), integers(&file, "offsets")), (vec![1, 2], vec![3, 5]));
    assert_eq!(integers(&file, "connectivity"), [0, 1, 2, 3, 4]);
    // Times rise along the paths, by as much as their moves take, and the last bead ends with the plan.
    let times = floats(&file, "time_s");
    assert!(times.windows(2).all(|pair| pair[0] < pair[1]), "{times:?}");
    let schedule = &plan.schedules()[0];
    assert!((f64::from(times[2] - times[0]) - schedule.times()[2]).abs() < 1e-4);
    assert!((f64::from(times[4]) - plan.total_s).abs() < 1e-3, "{times:?} {}", plan.total_s);
}

#[test]
fn no_paths_are_an_empty_file() {
    let mut file = Vec::new();
    write_paths_vtp(&[], &[], &mut file).unwrap();
    assert!(floats(&file, "points").is_empty() && integers(&file, "offsets").is_empty());
}
