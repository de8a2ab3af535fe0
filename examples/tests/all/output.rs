//! Output folder, summary, table and report.

use curvlay_examples::args::Outcome;
use curvlay_examples::findings::{Findings, Severity};
use curvlay_examples::output::{OutputError, OutputFolder};
use curvlay_examples::plot::Plot;
use curvlay_examples::render::Image;
use curvlay_examples::report::Report;
use curvlay_examples::summary::{Summary, SummaryError};
use curvlay_examples::table::Table;
use std::fs;
use std::io::{Error, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A place of its own for a test, empty.
fn place(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    match fs::remove_dir_all(&path) {
        Err(error) if path.exists() => panic!("{error}"),
        _ => path,
    }
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn files_are_whole_or_not_there() {
    let path = place("whole/deep/er");
    let folder = OutputFolder::create(&path).unwrap();
    assert!(names(&path).is_empty(), "the trial leaves nothing");
    folder.write("a.txt", "first").unwrap();
    let failed = folder.write_with("a.txt", |file| {
        file.write_all(b"second, but only ha")?;
        Err(Error::other("out of ink"))
    });
    let text = failed.unwrap_err().to_string();
    assert!(text.ends_with("a.txt: cannot be written: out of ink"), "{text}");
    assert_eq!(fs::read_to_string(path.join("a.txt")).unwrap(), "first");
    folder.write("a.txt", "third").unwrap();
    assert_eq!(fs::read_to_string(path.join("a.txt")).unwrap(), "third");
    // Files that belong together: dropped, they were never there.
    let (unfinished, mut file) = folder.begin("c.txt").unwrap();
    file.write_all(b"four").unwrap();
    assert_eq!(names(&path).len(), 2);
    drop(unfinished);
    let (unfinished, mut file) = folder.begin("a.txt").unwrap();
    file.write_all(b"fifth").unwrap();
    assert_eq!(fs::read_to_string(path.join("a.txt")).unwrap(), "third");
    assert_eq!(unfinished.finish().unwrap(), 5);
    assert_eq!(fs::read_to_string(path.join("a.txt")).unwrap(), "fifth");
    fs::create_dir(path.join("b.txt")).unwrap();
    assert!(matches!(folder.write("b.txt", ""), Err(OutputError::Write { .. })));
    drop(folder);
    assert_eq!(names(&path), ["a.txt", "b.txt"]);
}

#[test]
fn a_list_of_nothing_takes_away_that_of_an_earlier_run() {
    let path = place("list");
    let folder = OutputFolder::create(&path).unwrap();
    let faults = |there: bool| folder.write_list("faults.csv", there, |out| out.write_all(b"a fault"));
    faults(false).unwrap();
    assert_eq!(names(&path), [""; 0]);
    faults(true).unwrap();
    assert_eq!(fs::read_to_string(path.join("faults.csv")).unwrap(), "a fault");
    faults(false).unwrap();
    assert_eq!(names(&path), [""; 0]);
    fs::create_dir(path.join("faults.csv")).unwrap();
    assert!(matches!(faults(false), Err(OutputError::Write { .. })));
}

#[test]
fn clearing_takes_away_what_is_ours_alone() {
    let path = place("clear");
    let folder = OutputFolder::create(&path).unwrap();
    let all = ["summary.json", "a.csv", "b.csv", "mine.csv", ".a.csv.17.part", ".mine.csv.17.part", ".a.csv"];
    all.iter().for_each(|name| fs::write(path.join(name), "old").unwrap());
    fs::create_dir(path.join("c.csv")).unwrap();
    folder.clear(|name| ["a.csv", "b.csv", "c.csv"].contains(&name)).unwrap();
    assert_eq!(names(&path), [".a.csv", ".mine.csv.17.part", "c.csv", "mine.csv"]);
    folder.clear(|_| false).unwrap();
    assert_eq!(names(&path).len(), 4);
    // A summary that cannot be removed is named.
    fs::create_dir(path.join("summary.json")).unwrap();
    assert!(folder.clear(|_| false).unwrap_err().to_string().contains("summary.json"));
}

/// One list of findings makes notices, keys of the summary and the exit status.
#[test]
fn findings_are_reported_in_every_place() {
    let mut findings = Findings::default();
    assert!(!findings.has_failed() && findings.outcome() == Outcome::Done);
    findings.add(Severity::above(0.001, 0.001), "walls < a cell", "0.1 %", "near x 1");
    let failed = findings.explain(Severity::above(f64::NAN, 1.0), "no volume", "", "");
    failed.cause("the mesh is <empty>").try_to("another mesh").try_to("").try_to("--scale").allow("--allow-volume 1");
    let lines: Vec<String> = findings.iter().map(ToString::to_string).collect();
    assert_eq!(lines, ["walls < a cell: 0.1 % (near x 1)", "no volume"]);
    assert_eq!((findings.of(Severity::Warning).count(), findings.of(Severity::Failed).count()), (1, 1));
    assert!(findings.has_failed() && findings.outcome() == Outcome::ChecksFailed(Vec::new()));
    let mut summary = Summary::new();
    findings.summary(&mut summary).unwrap();
    assert_eq!((summary.get("findings_failed"), summary.get("findings_warnings")), (Some(&1.into()), Some(&1.into())));
    assert_eq!(summary.get("findings"), Some(&"warning: walls < a cell: 0.1 % (near x 1)\nfailed: no volume\n  cause: the mesh is <empty>\n  try: another mesh; --scale\n  accept: --allow-volume 1".into()));
    let mut report = Report::new("part");
    findings.report(&mut report);
    let html = report.to_html();
    let [failed, reported] =
        ["Check failed: no volume", "walls &lt; a cell: 0.1 %"].map(|text| html.find(text).unwrap());
    assert!(failed < reported, "what failed comes first");
    assert!(html.contains("<p class=\"advice\"><b>cause</b> the mesh is &lt;empty&gt;</p>"), "{html}");
    assert_eq!(
        (html.matches("<div class=\"notice failed\"").count(), html.matches("<div class=\"notice\"").count()),
        (1, 1)
    );
}

#[test]
fn folders_without_files_go_away() {
    let top = place("gone");
    let folder = OutputFolder::create(&top.join("x/y")).unwrap();
    assert!(folder.path().is_dir());
    drop(folder);
    assert!(!top.exists());
    fs::create_dir(&top).unwrap();
    drop(OutputFolder::create(&top).unwrap());
    assert!(top.is_dir(), "a folder that was there before stays");
}

#[test]
fn what_cannot_be_a_folder_is_refused() {
    let top = place("refused");
    fs::create_dir_all(&top).unwrap();
    fs::write(top.join("file"), "mine").unwrap();
    for path in [top.join("file"), top.join("file/below/it")] {
        let error = OutputFolder::create(&path).unwrap_err();
        assert!(matches!(&error, OutputError::NotAFolder { path } if *path == top.join("file")), "{error}");
        assert!(!error.to_string().contains('\n'));
    }
    assert_eq!(fs::read_to_string(top.join("file")).unwrap(), "mine");
}

/// In `/proc` nobody makes a file or a folder, not even who may write read-only folders.
#[test]
#[cfg_attr(not(target_os = "linux"), ignore = "needs /proc")]
fn folders_that_cannot_be_written_are_refused() {
    let locked = Path::new("/proc");
    assert!(matches!(OutputFolder::create(locked), Err(OutputError::Write { path, .. }) if path == locked));
    let inside = locked.join("new");
    assert!(matches!(OutputFolder::create(&inside), Err(OutputError::Make { path, .. }) if path == inside));
}

#[test]
fn the_summary_is_flat_ordered_json() {
    let mut summary = Summary::new();
    summary.set("zeta", "a \"quoted\"\nname").unwrap().set("cells", 97_532_u64).unwrap().set("audit_ok", true).unwrap();
    summary.set("cell_mm", 0.1 + 0.2).unwrap().set_seconds("grow_s", Duration::from_micros(1_234_567)).unwrap();
    let keys: Vec<&str> = summary.iter().map(|(key, _)| key).collect();
    assert_eq!(keys, ["zeta", "cells", "audit_ok", "cell_mm", "grow_s"]);
    let json = summary.to_json();
    assert!(json.find("zeta") < json.find("cells"), "{json}");
    let parsed: serde_json::Map<String, serde_json::Value> = serde_json::from_str(&json).unwrap();
    assert_eq!(parsed.len(), 5);
    assert_eq!(parsed["zeta"], "a \"quoted\"\nname");
    assert_eq!(parsed["cell_mm"], 0.1 + 0.2, "figures come back bit for bit");
    assert_eq!(parsed["grow_s"], 1.2346);
    assert_eq!(serde_json::from_str::<serde_json::Value>(&Summary::new().to_json()).unwrap(), serde_json::json!({}));

    let path = place("summary");
    let folder = OutputFolder::create(&path).unwrap();
    summary.write(&folder).unwrap();
    assert_eq!(fs::read_to_string(path.join("summary.json")).unwrap(), json);
}

#[test]
fn figures_that_json_cannot_hold_are_refused() {
    let mut summary = Summary::new();
    let key = || "a".to_owned();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(summary.set("a", bad), Err(SummaryError::NotFinite { key: key() }));
    }
    assert_eq!(summary.set("a", vec![1, 2]), Err(SummaryError::NotFlat { key: key() }));
    summary.set("a", 1).unwrap();
    assert_eq!(summary.set("a", 2), Err(SummaryError::Repeated { key: key() }));
    for bad in ["", "Cells", "cell-mm", "2nd", "_x", "größe"] {
        assert_eq!(summary.set(bad, 1), Err(SummaryError::Key { key: bad.to_owned() }));
    }
    assert_eq!(summary.to_json(), "{\n  \"a\": 1\n}\n");
}

fn table() -> Table {
    let mut table = Table::new(["object", "ours", "Boge"]);
    table.row(["1 & <b>", "12", "-"]).row(["größer", "1,204.5 mm", "~3"]).row(["short"]);
    table
}

#[test]
fn tables_are_aligned() {
    assert_eq!(
        table().to_string(),
        "object         ours  Boge\n1 & <b>          12     -\ngrößer   1,204.5 mm    ~3\nshort\n"
    );
    assert_eq!(Table::new(["", ""]).row(["layers", "128"]).to_string(), "layers  128\n");
    assert_eq!([0, 1, 2, 9].map(|column| table().is_numeric(column)), [false, true, true, false]);
}

#[test]
fn the_report_is_one_sound_escaped_page() {
    let png = Image::new(3, 2, [200, 10, 10]).to_png();
    let mut report = Report::new("<script>alert('1')</script>");
    report
        .heading("A & B")
        .paragraph("1 < 2 > \"0\"\u{0}")
        .notice("mind the gap")
        .table("Table 5.1 <x>", &table())
        .picture("\"><img src=x>", &png)
        .pictures(&[("front", &png), ("back", &png)])
        .slider(&[("first <", &png), ("last", &png)])
        .slider(&[])
        .plot("turns", Plot::new("mm <", "degrees").line("after <", [1, 2, 3], [[0.0, 1.0], [2.0, 3.0]]));
    let html = report.to_html();
    assert!(!html.contains("<script") && !html.contains("<img src=x") && !html.contains("<b>"), "{html}");
    assert!(html.contains("<title>&lt;script&gt;alert(&#39;1&#39;)&lt;/script&gt;</title>"));
    assert!(html.contains("<p>1 &lt; 2 &gt; &quot;0&quot;\u{fffd}</p>"));
    assert!(html.contains("<td class=\"figure\">1,204.5 mm</td>"));
    assert!(html.contains("1 &amp; &lt;b&gt;</td>") || html.contains("1 &amp; &lt;b&gt;</th>"));
    assert!(!html.contains("http:") && !html.contains("https:") && !html.contains("url("), "nothing from outside");
    assert_eq!(html.matches("src=\"data:image/png;base64,iVBORw0KGgo").count(), 5);
    assert_eq!(html.matches("src=").count() - html.matches("src=x").count(), 5);
    // A slider shows one picture at a time, the last at first.
    assert_eq!((html.matches("<img hidden alt=\"first &lt;\"").count(), html.matches("<input ").count()), (1, 1));
    assert!(html.contains("max=\"1\" value=\"1\"") && html.contains("<figcaption>last</figcaption>"));

    // Every element that is opened is closed, in order.
    let mut open = Vec::new();
    for tag in html.split('<').skip(1).filter_map(|rest| rest.split('>').next()) {
        let name = tag.split_whitespace().next().unwrap();
        match name.strip_prefix('/') {
            Some(closed) => assert_eq!(open.pop(), Some(closed)),
            None if ["!DOCTYPE", "meta", "img", "input", "path"].contains(&name) => {}
            None => open.push(name),
        }
    }
    assert!(open.is_empty(), "{open:?}");
}
