//! Readers of files.

use crate::Entry;
use curvlay_examples::build3mf::BuildReader;
use curvlay_examples::five_axis::FiveAxisPrinter;
use curvlay_examples::mesh::{mesh_findings, read_mesh_file};
use curvlay_examples::motion::{workcell_model, workcell_of};
use curvlay_examples::settings::{Profile, named_flavour};
use curvlay_examples::waypoints::read_waypoints;
use curvlay_kinematics::urdf::{LinkNames, UrdfArm};
use curvlay_kinematics::workcell::{AnyWorkcell, WorkcellModel};
use curvlay_kinematics::{ArmDeviation, Measurements, robots};
use curvlay_layers::curved::surface::SavedField;
use curvlay_toolpath::drawing::{SvgOptions, load_drawing, read_dxf, read_svg, save_drawing};
use curvlay_toolpath::fiber::stress_files::{read_stress_csv, read_stress_frd, read_stress_vtk};
use curvlay_voxel::read_text_grid;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

#[path = "../../../examples/audit/orders/mod.rs"]
#[allow(dead_code)]
mod orders;
#[path = "../../../examples/curved_layers/ranges.rs"]
#[allow(dead_code)]
pub mod ranges;
#[path = "../../../examples/stewart_table/layer.rs"]
#[allow(dead_code)]
mod stewart;
#[path = "../../../examples/continuous_fiber/wires.rs"]
#[allow(dead_code)]
mod wires;

pub const ENTRIES: &[Entry] = &[
    ("stl", |data| mesh(data, "input.stl")),
    ("obj", |data| mesh(data, "input.obj")),
    ("ply", |data| mesh(data, "input.ply")),
    ("3mf", |data| mesh(data, "input.3mf")),
    ("build3mf", build),
    ("dxf", |data| {
        if let Ok(drawing) = read_dxf(data) {
            let _ = save_drawing(&mut std::io::sink(), &drawing);
        }
    }),
    ("svg", |data| {
        let _ = read_svg(data, SvgOptions::default());
    }),
    ("drawing", |data| {
        let _ = load_drawing(data);
    }),
    ("field", field),
    ("order", order),
    ("grid", |data| {
        let _ = read_text_grid(data);
    }),
    ("paths", paths),
    ("wires", |data| {
        let _ = wires::read(&file("input.txt", data));
    }),
    ("waypoints", |data| {
        let path = file("input.txt", data);
        let _ = (read_waypoints(&path), stewart::read(&path));
    }),
    ("stress_csv", |data| {
        let _ = read_stress_csv(data);
    }),
    ("stress_vtk", |data| {
        let _ = read_stress_vtk(data, None);
    }),
    ("stress_frd", |data| {
        let _ = read_stress_frd(data);
    }),
    ("profile", |data| {
        let _ = Profile::load(&file("input.json", data));
    }),
    ("flavour", |data| {
        let path = file("input.json", data);
        let _ = named_flavour("input.json", path.parent().unwrap_or(Path::new("")));
    }),
    ("machine", |data| {
        let _ = FiveAxisPrinter::load(&file("input.json", data));
    }),
    ("workcell", |data| {
        if let Ok(model) = WorkcellModel::from_json(data) {
            let _ = AnyWorkcell::new(model);
        }
    }),
    ("workcell_file", |data| {
        if let Ok(model) = workcell_model(&file("input.json", data)) {
            let _ = workcell_of(model, None);
        }
    }),
    ("urdf", |data| {
        let _ = UrdfArm::read(&String::from_utf8_lossy(data), &LinkNames::default());
    }),
    ("ur_calibration", |data| {
        let Some(arm) = robots::find("UR10e") else { return };
        let _ = ArmDeviation::from_ur_calibration(&String::from_utf8_lossy(data), &arm.model);
    }),
    ("measurements", |data| {
        let _ = (Measurements::from_csv(data), Measurements::from_json(data));
    }),
];

/// A file with this content, for readers that take a path: in memory where the system has such a folder.
pub fn file(name: &str, data: &[u8]) -> PathBuf {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let memory = Path::new("/dev/shm");
        let base = if memory.is_dir() { memory.to_owned() } else { std::env::temp_dir() };
        let folder = base.join(format!("curvlay-fuzz-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder for inputs");
        folder
    });
    let path = folder.join(name);
    std::fs::write(&path, data).expect("an input is written");
    path
}

fn mesh(data: &[u8], name: &str) {
    let Ok(read) = read_mesh_file(&file(name, data)) else { return };
    let (vertices, triangles) = (&read.mesh.vertices, &read.mesh.triangles);
    assert!(vertices.iter().all(|vertex| vertex.coords.iter().all(|x| x.is_finite())));
    assert!(triangles.iter().flatten().all(|&corner| (corner as usize) < vertices.len()));
    // Looking for faults is meant for any mesh, but takes long on those of many crossings.
    if triangles.len() <= 64 {
        let _ = mesh_findings;
    }
}

fn build(data: &[u8]) {
    let Ok(mut reader) = BuildReader::open(Cursor::new(data)) else { return };
    for layer in 0..reader.layers().len().min(8) {
        let _ = reader.read_layer(layer);
    }
}

fn field(data: &[u8]) {
    if let Ok(saved) = SavedField::read_within(1_000_000, data) {
        let mut text = Vec::new();
        saved.write(&mut text).expect("what is read is written");
    }
}

fn order(data: &[u8]) {
    for (first_layer, field_step, cell_mm) in [(1, None, None), (0, Some(0.5), Some(1.0))] {
        let options = orders::OrderOptions { cell_mm, first_layer, field_step, max_cells: 1_000_000 };
        let _ = orders::read(&file("input.csv", data), &options);
    }
}

/// What the surfaces are made of, as the seed says: nothing in particular.
pub const MADE_OF: u64 = 1;

/// Paths of two triangles, as the seed has them.
fn paths(data: &[u8]) {
    let files = [file("input.jsonl", data)];
    let _ = ranges::check(&files);
    let (surfaces, fill) = crate::geometry::small_layers();
    let _ = ranges::read(&files, &surfaces, MADE_OF, &fill);
}
