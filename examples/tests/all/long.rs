//! Every example that computes gives the same files on 1, 2, 5 and 16 threads.

use crate::common::{example, place, summary};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// What each runs on: small, and as many stages as there are.
const RUNS: [(&str, &str); 16] = [
    ("curved_layers", "--voxels 20000 --stage field --strategy unbuild"),
    ("curved_layers", "--voxels 20000 --stage field --strategy governed"),
    ("curved_layers", "--voxels 6000 --layers-by directed --density 30 --also gltf"),
    ("curved_layers", "--voxels 6000 --layers-by distance --support auto --also 3mf"),
    ("curved_layers", "--voxels 6000 --layers-by hull --coherent --pattern zigzag"),
    ("curved_layers", "--stage preview --layer-height 1 --bead 1.5"),
    ("curved_layers", "--voxels 3000 --orient best --orient-directions 60"),
    ("curved_layers", "--voxels 3000 --stage motion --workcell cells/ur10.json"),
    ("curved_layers", "--voxels 3000 --machine machines/bc-table-tcp.json"),
    ("best_orientation", "--orient-directions 60 --orient-voxels 5000"),
    ("volume_decomposition", "--shape ell --rapid --bead 12"),
    ("robofdm", "--layer-height 3 --cell 4"),
    ("continuous_fiber", ""),
    ("dome_drawing", ""),
    ("stewart_table", ""),
    ("jerk_motion", "--count 300 --noise 60 --robots ur3"),
];

/// Whether a figure tells how long something took here.
fn is_time(name: &str) -> bool {
    ["plan_s", "transfers_s", "seconds"].contains(&name) || name.starts_with("realtime_factor") || name.ends_with("_us")
}

/// A table without the columns that tell times; anything else as it is.
fn without_times(bytes: Vec<u8>) -> Vec<u8> {
    let text = String::from_utf8_lossy(&bytes);
    let header: Vec<&str> = text.lines().next().unwrap_or("").split(',').collect();
    if !header.iter().any(|name| is_time(name)) {
        return bytes;
    }
    let kept = |line: &str| {
        let cells = line.split(',').zip(&header).filter(|(_, name)| !is_time(name));
        cells.map(|(cell, _)| cell).collect::<Vec<_>>().join(",")
    };
    text.lines().map(kept).collect::<Vec<_>>().join("\n").into_bytes()
}

/// Files by name, but for the report; of the summary and of tables all that is no time.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let bytes = match name.as_str() {
            "report.html" => continue,
            "summary.json" => {
                let is_other = |key: &str| key.ends_with("_s") || key == "threads" || is_time(key);
                let all = summary(folder).into_iter().filter(|(key, _)| !is_other(key));
                serde_json::to_vec(&all.collect::<BTreeMap<_, _>>()).unwrap()
            }
            _ if path.is_dir() => continue,
            _ => without_times(fs::read(&path).unwrap()),
        };
        files.insert(name, bytes);
    }
    files
}

#[test]
#[ignore = "long: 64 runs, minutes"]
fn files_do_not_depend_on_the_threads() {
    for (number, (name, args)) in RUNS.into_iter().enumerate() {
        let on = |threads: &str| {
            let out = place("long", &format!("{number}-{name}-{threads}"));
            let mut command = example(name);
            command.args(args.split_whitespace()).args(["--quiet", "--threads", threads, "--out"]).arg(&out);
            let output = command.env("RAYON_NUM_THREADS", threads).output().unwrap();
            // 3 is a finding of a check, which is a result like any other.
            let text = String::from_utf8_lossy(&output.stderr);
            assert!(matches!(output.status.code(), Some(0 | 3)), "{name} {args}: {text}");
            files(&out)
        };
        let one = on("1");
        assert!(one.contains_key("summary.json"), "{name} {args}");
        for threads in ["2", "5", "16"] {
            let other = on(threads);
            assert!(one.keys().eq(other.keys()), "{name} {args} --threads {threads}");
            for (file, bytes) in &one {
                assert!(other[file] == *bytes, "{name} {args} --threads {threads}: {file}");
            }
        }
    }
}
