//! Pages of documentation: every link to a file leads to one.

use std::fs;
use std::path::{Path, PathBuf};

/// All pages below a folder, without those of build folders.
fn pages(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        let name = entry.file_name().unwrap().to_string_lossy().into_owned();
        if entry.is_dir() && name != "target" && !name.starts_with('.') {
            pages(&entry, found);
        } else if name.ends_with(".md") {
            found.push(entry);
        }
    }
}

/// Targets of the links of a page that are files: behind `](`, up to `)` or the name of a section. Code is passed over.
fn links(text: &str) -> Vec<String> {
    let without_listings: String = text.split("```").step_by(2).collect();
    let prose = without_listings.lines().map(|line| line.split('`').step_by(2).collect::<Vec<_>>().join("x"));
    let prose = prose.collect::<Vec<_>>().join("\n");
    let targets = prose.split("](").skip(1).filter_map(|rest| rest.split([')', '#', ' ']).next());
    targets.filter(|target| !target.is_empty() && !target.contains("://")).map(str::to_owned).collect()
}

#[test]
fn links_are_found_in_prose() {
    let text = "[a](b/c.md), [d](e.md#f), [g](#h), [i](https://j.k/l.md), `[m](n.md)`, [`o`](p.rs)\n```\n[q](r.md)\n```\n[s](t.png)";
    assert_eq!(links(text), ["b/c.md", "e.md", "p.rs", "t.png"]);
}

#[test]
fn links_lead_to_files() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut found = Vec::new();
    pages(&root, &mut found);
    assert!(found.len() > 30, "only {} pages", found.len());
    let mut dead = Vec::new();
    let mut count = 0;
    for page in found {
        for target in links(&fs::read_to_string(&page).unwrap()) {
            count += 1;
            if !page.parent().unwrap().join(&target).exists() {
                dead.push(format!("{}: {target}", page.display()));
            }
        }
    }
    assert!(count > 100, "only {count} links");
    assert!(dead.is_empty(), "links without a file:\n{}", dead.join("\n"));
}
