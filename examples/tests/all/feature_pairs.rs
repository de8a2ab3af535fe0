//! Features of `curved_layers` that are on by default, or that users combine, run together in pairs on one small part.

use crate::common;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

/// A hook of 192 cells: a post, an arm, and a tip that hangs down from its end and needs support.
const HOOK: [[[i32; 3]; 2]; 3] = [[[0, 0, 0], [8, 8, 12]], [[8, 0, 8], [24, 8, 12]], [[16, 0, 4], [24, 8, 8]]];

/// What every run shares. By hulls the tip of the hook needs support; that the best order is taken is tested elsewhere.
const COMMON: [&str; 6] = ["--cell", "2", "--layer-height", "3", "--layers-by", "hull"];

/// What may be wrong: layers of such a part are torn at the support.
const ALLOWED: [&str; 6] = ["--allow-volume", "1", "--allow-left-out", "1", "--allow-missed", "1"];

/// A feature, and the options that ask for it. `FIELD` and `RANGES` stand for files of a run before.
const FEATURES: [(&str, &[&str]); 6] = [
    ("support", &["--support", "auto"]),
    ("infill", &["--density", "40", "--walls", "1", "--skin", "1"]),
    ("resume", &["--resume", "FIELD"]),
    ("ranges", &["--resume", "FIELD", "--merge", "RANGES"]),
    ("orient", &["--orient", "best", "--orient-directions", "6", "--orient-voxels", "200", "--refine", "1"]),
    ("motion", &["--stage", "motion"]),
];

/// Runs the example.
fn run(args: &[String]) -> Output {
    common::example("curved_layers").args(args).arg("--quiet").output().unwrap()
}

/// The options of some features, each option once, since several features may ask for the same.
fn options(features: &[usize]) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for &feature in features {
        for option in FEATURES[feature].1.chunks(2) {
            if !all.iter().any(|known| known == option[0]) {
                all.extend(option.iter().map(|text| (*text).to_owned()));
            }
        }
    }
    all
}

/// What runs of one pair share: the folder, the mesh, the cell.
struct Place {
    folder: PathBuf,
    shared: Vec<String>,
}

impl Place {
    fn path(&self, name: &str) -> String {
        self.folder.join(name).display().to_string()
    }

    /// A run into a folder of its own; its status must be 0, or 3 for findings.
    fn run(&self, name: &str, more: &[String]) {
        let out = ["--out".to_owned(), self.path(name)];
        // A saved field has its cells, their order and its support.
        let resumes = more.iter().any(|option| option == "--resume");
        let grown = |option: &[String]| resumes && ["--cell", "--layers-by", "--support"].contains(&&option[0][..]);
        let shared = self.shared.chunks(2).filter(|option| !grown(option)).flatten();
        let more: Vec<String> = match more.iter().position(|option| option == "--support") {
            Some(at) if resumes => [&more[..at], &more[at + 2..]].concat(),
            _ => more.to_vec(),
        };
        let all: Vec<String> = shared.chain(&out).chain(&more).cloned().collect();
        let output = run(&all);
        let lines = String::from_utf8_lossy(&output.stderr);
        assert!(matches!(output.status.code(), Some(0 | 3)), "{} {name} {more:?}: {lines}", self.folder.display());
    }

    /// The options with the files of a run before in place of `FIELD` and `RANGES`, which is made here.
    fn with_files(&self, features: &[usize]) -> Vec<String> {
        let wanted = options(features);
        if !wanted.iter().any(|option| option == "FIELD") {
            return wanted;
        }
        let kept: Vec<usize> =
            features.iter().copied().filter(|&k| !["resume", "ranges"].contains(&FEATURES[k].0)).collect();
        let before: Vec<String> =
            options(&kept).chunks(2).filter(|option| option[0] != "--stage").flatten().cloned().collect();
        let field = self.path("before/field.txt");
        self.run("before", &[&before[..], &ALLOWED.map(str::to_owned)].concat());
        let mut files = Vec::new();
        if wanted.iter().any(|option| option == "RANGES") {
            for (name, layers) in [("low", "1/2"), ("high", "2/2")] {
                let of_range = ["--resume", &field, "--layers", layers].map(str::to_owned);
                self.run(name, &[&before[..], &of_range].concat());
                files.push(self.path(&format!("{name}/paths.jsonl")));
            }
        }
        let put = |option: String| match &option[..] {
            "FIELD" => vec![field.clone()],
            "RANGES" => files.clone(),
            _ => vec![option],
        };
        wanted.into_iter().flat_map(put).collect()
    }
}

/// Bug: `--stage motion` of every part with support ended with "layer 26 has cell 19988, which is no cell of the part".
#[test]
fn every_pair_with_motion_runs_together() {
    pairs(true);
}

#[test]
fn every_pair_without_motion_runs_together() {
    pairs(false);
}

fn pairs(moving: bool) {
    for a in 0..FEATURES.len() {
        for b in a + 1..FEATURES.len() {
            // A saved field says how the part lies: clap refuses to turn it.
            let has = |name: &str| [a, b].iter().any(|&k| FEATURES[k].0 == name);
            if has("orient") && (has("resume") || has("ranges")) {
                continue;
            }
            if has("motion") != moving {
                continue;
            }
            pair([a, b], "part-in-hand", None);
            if moving {
                pair([a, b], "table", Some("--cell8"));
            }
        }
    }
}

fn pair(features: [usize; 2], cell: &str, of_cell: Option<&str>) {
    let [a, b] = features.map(|feature| FEATURES[feature].0);
    let folder = common::place("pairs", &format!("{a}-{b}-{cell}"));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let mesh = folder.join("hook.obj");
    fs::write(&mesh, common::boxes_as_obj(&HOOK)).unwrap();
    let shared: Vec<String> =
        ["--mesh", &mesh.display().to_string()].into_iter().chain(COMMON).map(str::to_owned).collect();
    let place = Place { folder, shared };
    let options = place.with_files(&features);
    let of_cell: Vec<String> = of_cell.map(str::to_owned).into_iter().collect();
    place.run("out", &[options, ALLOWED.map(str::to_owned).to_vec(), of_cell].concat());
    let figures = common::summary(&place.folder.join("out"));
    let has = |feature: &str| [a, b].contains(&feature);
    if has("support") && !has("orient") {
        assert!(figures["support_cells"].as_u64().unwrap() > 0, "{a} {b}");
    }
    let done = if has("motion") { "motion" } else { "gcode" };
    assert_eq!(figures["stage_done"], done, "{a} {b}");
    if has("motion") {
        assert!(figures["motions"].as_u64().unwrap() > 0, "{a} {b} {cell}");
        assert_eq!(figures["collisions"], 0, "{a} {b} {cell}");
    }
    assert!(Path::new(&place.path("out")).join("toolpath.gcode").exists());
}
