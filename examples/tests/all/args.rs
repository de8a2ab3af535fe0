//! The command line: defaults, refusals, exit status.

use clap::{ArgMatches, CommandFactory, Parser};
use curvlay_examples::args::{
    Common, Failure, GrowArgs, MeshArgs, Outcome, Prevention, Strategy, VoxelArgs, is_typed, one_line, run,
    run_command, typed_name,
};
use curvlay_examples::mesh::{Unit, Up};
use curvlay_examples::nalgebra::Point3;
use curvlay_examples::settings::Settings;
use curvlay_examples::shapes::jug;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Parser, Debug)]
struct Args {
    #[command(flatten)]
    mesh: MeshArgs,
    #[command(flatten)]
    voxels: VoxelArgs,
    #[command(flatten)]
    grow: GrowArgs,
    #[command(flatten)]
    settings: Settings,
    #[command(flatten)]
    common: Common,
}

fn parse(words: &str) -> Result<Args, clap::Error> {
    Args::try_parse_from(["name"].into_iter().chain(words.split_whitespace()))
}

fn run_on(words: &str, main: impl FnOnce(Args, &ArgMatches) -> Result<Outcome, Failure>) -> ExitCode {
    run_command(Args::command(), words.split(' '), main)
}

#[test]
fn everything_has_a_default() {
    let args = parse("").unwrap();
    assert_eq!((args.mesh.mesh, args.mesh.unit, args.mesh.scale, args.mesh.up), (None, Unit::Mm, 1.0, Up::Z));
    assert_eq!((args.voxels.voxels, args.voxels.cell), (None, None));
    assert_eq!((args.grow.eps_cells, args.settings), (1.0, Settings::default()));
    assert_eq!((args.grow.strategy, args.grow.prevention), (Strategy::Best, Prevention::Adaptive));
    assert!(args.common.threads >= 1 && !args.common.quiet && args.common.out.is_none());
}

#[test]
fn everything_can_be_set() {
    let words = "--mesh a.stl --unit in --scale 2.5 --up y --voxels 100000 --eps 0 --platform-diameter 90 \
                 --strategy greedy --prevention incremental --out here --threads 3 --quiet";
    let args = parse(words).unwrap();
    assert_eq!((args.mesh.mesh, args.mesh.unit), (Some(PathBuf::from("a.stl")), Unit::In));
    assert_eq!((args.mesh.scale, args.mesh.up, args.voxels.voxels), (2.5, Up::Y, Some(100_000)));
    assert_eq!((args.grow.eps_cells, args.settings.platform_diameter_mm), (0.0, 90.0));
    assert_eq!(
        (typed_name(args.grow.strategy), typed_name(args.grow.prevention)),
        ("greedy".into(), "incremental".into())
    );
    assert_eq!((args.common.out, args.common.threads, args.common.quiet), (Some(PathBuf::from("here")), 3, true));
}

#[test]
fn the_part_is_a_word_of_its_own_or_an_option() {
    for words in ["part.stl --up -z", "--up -z part.stl", "--mesh part.stl --up=-z", "--unit cm --up -z -- part.stl"] {
        let mesh = parse(words).unwrap().mesh;
        assert_eq!((mesh.path(), mesh.up), (Some(Path::new("part.stl")), Up::NegZ), "{words}");
    }
    assert_eq!(parse("").unwrap().mesh.path(), None);
}

#[test]
fn what_is_out_of_range_is_refused_in_one_line() {
    let refused = [
        ("--voxels 0", "--voxels"),
        ("--voxels -5", "--voxels"),
        ("--voxels 1e5", "--voxels"),
        ("--voxels 99999999999999999999", "--voxels"),
        ("--cell 0", "--cell"),
        ("--cell -0.8", "--cell"),
        ("--cell nan", "--cell"),
        ("--cell inf", "--cell"),
        ("--cell 0.8 --voxels 10", "cannot be used with"),
        ("--eps -0.5", "--eps"),
        ("--eps 16.5", "--eps"),
        ("--eps NaN", "--eps"),
        ("--scale 0", "--scale"),
        ("--scale -1", "--scale"),
        ("--scale x", "--scale"),
        ("--platform-diameter 0", "--platform-diameter"),
        ("--threads 0", "--threads"),
        ("--threads 100000", "--threads"),
        ("--unit km", "--unit"),
        ("--up w", "--up"),
        ("--strategy none", "--strategy"),
        ("--prevention none", "--prevention"),
        ("--mesh", "--mesh"),
        ("--colour red", "--colour"),
        ("part.stl other.stl", "other.stl"),
        ("part.stl --mesh other.stl", "--mesh"),
        ("--up -w", "--up"),
    ];
    for (words, named) in refused {
        let line = one_line(&parse(words).unwrap_err());
        assert!(line.starts_with("error: ") && line.contains(named) && !line.contains('\n'), "{words}: {line}");
        let status = run_on(&format!("name {words}"), |_, _| panic!("{words} was taken"));
        assert_eq!(status, ExitCode::from(2), "{words}");
    }
    let line = one_line(&parse("--eps 17").unwrap_err());
    assert_eq!(line, "error: invalid value '17' for '--eps <CELLS>': must be from 0 to 16");
}

#[test]
fn the_exit_status_says_how_it_ended() {
    assert_eq!(run(|| Ok(Outcome::Done)), ExitCode::from(0));
    assert_eq!(run(|| Err(Failure::new("no ink"))), ExitCode::from(1));
    assert_eq!(run(|| Ok(Outcome::ChecksFailed(vec!["ink".to_owned()]))), ExitCode::from(3));
    assert_eq!(run_on("name --help", |_, _| panic!("help does no work")), ExitCode::from(0));
    let of_args =
        |args: Args, _: &ArgMatches| Ok(Outcome::of(if args.common.quiet { vec![] } else { vec!["noise".to_owned()] }));
    assert_eq!(run_on("name", of_args), ExitCode::from(3));
    assert_eq!(run_on("name --quiet", of_args), ExitCode::from(0));
}

#[test]
fn arguments_that_do_not_go_together_exit_with_2() {
    assert_eq!(run(|| Err(Failure::of_arguments("not both"))), ExitCode::from(2));
    let checked = |_: Args, matches: &ArgMatches| match is_typed(matches, "eps_cells") {
        true => Err(Failure::of_arguments("--eps does nothing here")),
        false => Ok(Outcome::Done),
    };
    assert_eq!(run_on("name --eps 1", checked), ExitCode::from(2));
    assert_eq!(run_on("name", checked), ExitCode::from(0));
    // What was reported already is not reported again.
    assert_eq!(run(|| Ok(Outcome::ChecksFailed(Vec::new()))), ExitCode::from(3));
}

#[test]
fn failures_are_one_line() {
    assert_eq!(Failure::new("first\n  second\tthird").message(), "first second third");
    let from_error = |path: &str| -> Result<(), Failure> {
        let mesh = parse(&format!("--mesh {path}")).unwrap().mesh;
        mesh.load("jug", jug)?;
        Ok(())
    };
    let failure = from_error("no/such/file.stl").unwrap_err();
    assert!(failure.message().starts_with("no/such/file.stl: cannot be read: "), "{}", failure.message());
}

#[test]
fn without_a_file_the_shape_is_loaded() {
    let part = parse("--scale 0.01").unwrap().mesh.load("jug", jug).unwrap();
    assert_eq!(part.name, "jug");
    assert_eq!(part.mesh.triangles, jug().triangles);
    assert!(part.warnings[0].contains("--unit cm, m or in"));
    assert!(parse("--scale 1e308").unwrap().mesh.load("jug", jug).is_err());
}

#[test]
fn coordinates_that_are_too_coarse_for_the_cells_are_reported() {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("far.obj");
    fs::write(
        &path,
        "v 100000000 0 0\nv 100000040 0 0\nv 100000000 40 0\nv 100000000 0 40\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n",
    )
    .unwrap();
    let part = parse(&format!("--mesh {}", path.display())).unwrap().mesh.load("jug", jug).unwrap();
    assert_eq!(part.spacing_mm, Some(8.0));
    assert_eq!(part.mesh.bounds().unwrap()[1], Point3::new(20.0, 20.0, 40.0), "{:?}", part.warnings);
    let reported = part.coarse_for(0.8).unwrap();
    assert!(reported.contains("8.000 mm apart") && reported.contains("1000 % of a cell"), "{reported}");
    assert_eq!(part.coarse_for(161.0), None);
    assert!(parse("").unwrap().mesh.load("jug", jug).unwrap().coarse_for(0.01).is_none());
}

#[test]
fn facets_that_look_the_wrong_way_are_reported() {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mixed.obj");
    fs::write(&path, "v 0 0 0\nv 40 0 0\nv 0 40 0\nv 0 0 40\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 4 3\n").unwrap();
    let part = parse(&format!("--mesh {}", path.display())).unwrap().mesh.load("jug", jug).unwrap();
    let reported = "the triangles disagreed about inside and outside at 3 edges: 1 of 4 were turned";
    let found: Vec<String> = part.findings.iter().map(ToString::to_string).collect();
    assert_eq!((part.mesh.triangles[3], &found[..]), ([1, 2, 3], &[reported.to_owned()][..]));
}

#[test]
fn the_folder_is_named_after_the_example() {
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("args-out");
    let common = parse(&format!("--out {}", out.display())).unwrap().common;
    assert_eq!(common.folder("curved_layers", [], |_| false).unwrap().path(), out);
    let here = std::env::current_dir().unwrap();
    let default = parse("").unwrap().common.folder("a_test", [], |_| false).unwrap();
    assert_eq!(default.path(), Path::new("target/out/a_test"));
    drop(default);
    assert!(!here.join("target/out/a_test").exists());
}
