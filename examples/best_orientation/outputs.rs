//! What the example leaves behind: the table on stdout, `poses.csv`, the part in the best pose, `summary.json` and `report.html`.

use super::args::{Args, Run};
use super::drawing;
use curvlay_examples::args::{Failure, typed_name};
use curvlay_examples::count::counted;
use curvlay_examples::orienting::{COMMENT, Search, laid};
use curvlay_examples::output::OutputFolder;
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use curvlay_layers::curved::orient::{JudgedPose, PoseKind};
use std::io::{self, Write};
use std::time::Instant;

/// Poses in the table and as pictures.
const SHOWN: usize = 5;

const FILES: [&str; 5] = ["poses.csv", "best_pose.stl", "best_pose.obj", "summary.json", "report.html"];

/// Whether a file is one of those that this example writes.
pub fn is_ours(name: &str) -> bool {
    FILES.contains(&name)
}

pub fn write(args: &Args, run: &Run, folder: &OutputFolder, start: Instant) -> Result<(), Failure> {
    let best = laid(&run.part.mesh, &run.search.best().pose);
    folder.write_with("poses.csv", |out| write_poses(&run.search, out))?;
    folder.write_with("best_pose.stl", |out| best.write_stl(out))?;
    folder.write_with("best_pose.obj", |out| best.write_obj(COMMENT, out))?;
    folder.write("report.html", report(args, run).to_html())?;
    // The summary comes last: where it is, all is there.
    summary(args, run, start)?.write(folder)?;
    Ok(())
}

fn kind(judged: &JudgedPose) -> &'static str {
    match judged.pose.kind {
        PoseKind::Given => "given",
        PoseKind::Resting => "resting",
        PoseKind::Sampled => "sampled",
    }
}

/// A line for each pose that was tried again with small cells, and one for each with large ones.
fn write_poses(search: &Search, out: &mut dyn Write) -> io::Result<()> {
    write!(
        out,
        "rank,cell_mm,kind,up_x,up_y,up_z,tipping_deg,stands,strategy,cells,missed_cells,missed_mm3,support_mm3,"
    )?;
    writeln!(out, "layers,height_mm,base_mm2")?;
    for (poses, cell_mm) in [&search.fine, &search.coarse].into_iter().zip([search.cell_mm[1], search.cell_mm[0]]) {
        for (rank, judged) in (1..).zip(poses) {
            let (up, tipping) = (judged.pose.up, judged.pose.tipping.to_degrees());
            write!(out, "{rank},{cell_mm:.6},{},{:.9},{:.9},{:.9},{tipping:.3}", kind(judged), up.x, up.y, up.z)?;
            write!(out, ",{},{},{},{}", u8::from(judged.stands), judged.strategy, judged.cells, judged.missed_cells)?;
            write!(out, ",{:.4},{:.4},{}", judged.missed_mm3, judged.support_mm3, judged.layers)?;
            writeln!(out, ",{:.4},{:.4}", judged.height_mm, judged.base_mm2)?;
        }
    }
    Ok(())
}

/// The best poses and the given one.
fn shown(search: &Search) -> Vec<(String, &JudgedPose)> {
    let ranked = search.ranked();
    let numbered = ranked.iter().enumerate().map(|(at, judged)| ((at + 1).to_string(), judged));
    numbered
        .enumerate()
        .filter(|(at, (_, judged))| *at < SHOWN || judged.pose.kind == PoseKind::Given)
        .map(|(_, row)| row)
        .collect()
}

pub fn table(search: &Search) -> Table {
    let heads = ["rank", "pose", "up", "tips at", "missed cells", "support mm3", "layers", "height mm", "base mm2"];
    let mut table = Table::new(heads);
    for (rank, judged) in shown(search) {
        let up = judged.pose.up;
        table.row([
            rank,
            kind(judged).to_owned(),
            format!("{:.3} {:.3} {:.3}", up.x, up.y, up.z),
            if judged.pose.tipping > 0.0 {
                format!("{:.1} deg", judged.pose.tipping.to_degrees())
            } else {
                "falls".to_owned()
            },
            format!("{} of {}", judged.missed_cells, judged.cells),
            format!("{:.0}", judged.support_mm3),
            judged.layers.to_string(),
            format!("{:.1}", judged.height_mm),
            format!("{:.0}", judged.base_mm2),
        ]);
    }
    table
}

fn summary(args: &Args, run: &Run, start: Instant) -> Result<Summary, Failure> {
    let (orient, search) = (&args.orient, &run.search);
    let resting = search.coarse.iter().filter(|judged| judged.pose.kind == PoseKind::Resting).count();
    let whole = search.coarse.iter().filter(|judged| judged.missed_cells == 0).count();
    let mut summary = Summary::new();
    summary
        .set("version", env!("CARGO_PKG_VERSION"))?
        .set("mesh", run.part.name.as_str())?
        .set("unit", typed_name(args.mesh.unit))?
        .set("scale", args.mesh.scale)?
        .set("up", typed_name(args.mesh.up))?
        .set("directions", orient.orient_directions)?
        .set("orient_voxels", orient.orient_voxels)?
        .set("refine", orient.refine)?
        .set("least_tipping_deg", orient.min_tipping_deg)?
        .set("standing_first", orient.standing_first)?
        .set("eps_cells", args.eps_cells)?
        .set("beyond_eps", args.beyond_eps)?
        .set("platform_diameter_mm", args.platform_diameter_mm)?
        .set("threads", args.common.threads)?
        .set("poses", search.coarse.len())?
        .set("poses_refined", search.fine.len())?
        .set("resting_poses", resting)?
        .set("whole_poses", whole)?
        .set("coarse_cell_mm", search.cell_mm[0])?
        .set("cell_mm", search.cell_mm[1])?;
    for (prefix, judged) in [("best", Some(search.best())), ("given", search.given())] {
        let Some(judged) = judged else { continue };
        let up = judged.pose.up;
        summary
            .set(&format!("{prefix}_kind"), kind(judged))?
            .set(&format!("{prefix}_up_x"), up.x)?
            .set(&format!("{prefix}_up_y"), up.y)?
            .set(&format!("{prefix}_up_z"), up.z)?
            .set(&format!("{prefix}_tipping_deg"), judged.pose.tipping.to_degrees())?
            .set(&format!("{prefix}_stands"), judged.stands)?
            .set(&format!("{prefix}_strategy"), judged.strategy.name())?
            .set(&format!("{prefix}_cells"), judged.cells)?
            .set(&format!("{prefix}_missed_cells"), judged.missed_cells)?
            .set(&format!("{prefix}_missed_share"), judged.missed_share())?
            .set(&format!("{prefix}_missed_mm3"), judged.missed_mm3)?
            .set(&format!("{prefix}_support_mm3"), judged.support_mm3)?
            .set(&format!("{prefix}_layers"), judged.layers)?
            .set(&format!("{prefix}_height_mm"), judged.height_mm)?
            .set(&format!("{prefix}_base_mm2"), judged.base_mm2)?;
    }
    run.findings.summary(&mut summary)?;
    summary.set_seconds("search_s", run.search_time)?.set_seconds("total_s", start.elapsed())?;
    Ok(summary)
}

fn report(args: &Args, run: &Run) -> Report {
    let search = &run.search;
    let mut report = Report::new("How the part should lie");
    run.findings.report(&mut report);
    let again = match search.fine.len() {
        0 => String::new(),
        count => format!(
            " The best of them, and the given one, {count} in all, were tried again with cells of {:.3} mm.",
            search.cell_mm[1]
        ),
    };
    let [first, then] = match args.orient.standing_first {
        true => ["whether the part stands by itself", "missed cells"],
        false => ["missed cells", "whether the part stands by itself"],
    };
    report.paragraph(&format!(
        "{} poses of {}, with cells of {:.3} mm.{again} Ranked by {first}, then {then}, then by straight \
         support under the missed cells, layers, height and base. A pose is the direction of the mesh that points up.",
        search.coarse.len(),
        run.part.name,
        search.cell_mm[0],
    ));
    report.table("The best poses, and the given one", &table(search));
    report.heading("The part in these poses");
    let pictures: Vec<(String, Vec<u8>)> = shown(search)
        .iter()
        .map(|(rank, judged)| {
            let caption = format!(
                "{rank}: {}, {} missed, {}",
                kind(judged),
                counted(judged.missed_cells, "cell"),
                counted(judged.layers, "layer")
            );
            (caption, drawing::part(&run.part.mesh, judged, args.platform_diameter_mm))
        })
        .collect();
    report.pictures(&pictures.iter().map(|(caption, png)| (caption.as_str(), png.as_slice())).collect::<Vec<_>>());
    report.heading("All directions").picture(
        "The directions that may point up: those of the upper half of the sphere on the left, of the lower half on the right, in discs of equal \
         area; x points right on the left disc and left on the right one, y up. Each place has the colour of the nearest pose.",
        &drawing::sphere(&search.coarse, search.best()),
    );
    report
}
