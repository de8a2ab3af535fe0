//! What kind of input it is: by its first bytes, and in a folder of `curved_layers` by its files.

use super::args::Args;
use super::sheets;
use curvlay_examples::args::Failure;
use curvlay_examples::facts::Facts;
use curvlay_examples::input;
use std::io::Read;
use std::path::Path;

/// Kinds of input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// An order of cells.
    Cells,
    /// G-code.
    Gcode,
    /// Waypoints with directions.
    Waypoints,
    /// Surfaces of layers.
    Layers,
}

/// The input, and the options with what the run in its folder says.
pub struct Source {
    /// How it is read.
    pub kind: Kind,
    /// Options; the input is a file.
    pub args: Args,
}

/// Bytes at the start of a file by which its kind is known: slicers begin with long comments.
const HEAD_BYTES: u64 = 1 << 16;
/// What a folder of ours has, in the order in which it is looked for.
const OURS: [&str; 3] = ["toolpath.gcode", "field.csv", SURFACES];
/// The surfaces of the layers of a run of ours.
const SURFACES: &str = "layers.obj";

/// Finds out.
///
/// # Errors
/// A folder without a file that is known, a file that cannot be read, several files that are not layers.
pub fn of(args: &Args) -> Result<Source, Failure> {
    let mut args = args.clone();
    if args.input.is_dir() {
        let folder = args.input.clone();
        match OURS.iter().map(|name| folder.join(name)).find(|path| path.is_file()) {
            Some(ours) if args.more.is_empty() => args.input = ours,
            _ if sheets::has_layers(&folder) => return Ok(Source { kind: Kind::Layers, args }),
            _ => return Err(unknown(&folder)),
        }
        of_run(&mut args, &folder);
    } else if args.input.file_name().is_some_and(|name| name == SURFACES) {
        let folder = args.input.parent().unwrap_or(Path::new("")).to_owned();
        of_run(&mut args, &folder);
    }
    let kind = kind_of(&args.input, &args)?;
    if kind != Kind::Layers && !args.more.is_empty() {
        let name = args.input.display();
        return Err(Failure::of_arguments(format!("{name}: several files are read of layer meshes only")));
    }
    Ok(Source { kind, args })
}

fn unknown(folder: &Path) -> Failure {
    Failure::new(format!(
        "{}: a folder without {}, and without layer meshes (.obj, .stl, .ply with numbers in their names): is it the output of curved_layers?",
        folder.display(),
        OURS.join(" or ")
    ))
}

/// Takes what was not asked for otherwise from the run that left a folder.
fn of_run(args: &mut Args, folder: &Path) {
    let facts = Facts::read(folder);
    args.nozzle = args.nozzle.or(facts.nozzle());
    args.layers_as_one = args.layers_as_one.or(facts.number("steps_per_layer").map(|steps| (steps as u32).max(1)));
    args.bead.filament_mm = args.bead.filament_mm.or(facts.number("filament_diameter_mm"));
    args.bead.height_mm = args.bead.height_mm.or(facts.number("layer_height_mm"));
}

fn kind_of(path: &Path, args: &Args) -> Result<Kind, Failure> {
    let mut head = Vec::new();
    let open = input::open(path, input::MAX_DATA_BYTES)?;
    let read = open.take(HEAD_BYTES).read_to_end(&mut head);
    read.map_err(|error| Failure::new(format!("{}: cannot be read: {error}", path.display())))?;
    let extension = path.extension().and_then(|name| name.to_str()).unwrap_or("").to_ascii_lowercase();
    if sheets::is_mesh(path) {
        return Ok(Kind::Layers);
    }
    if args.machine.is_some()
        || ["gcode", "gco", "g", "nc", "ngc", "cnc", "tap", "bgcode"].contains(&extension.as_str())
    {
        if head.starts_with(b"GCDE") {
            return Err(Failure::new(format!("{}: binary G-code is not read: export it as text", path.display())));
        }
        return Ok(Kind::Gcode);
    }
    let text = String::from_utf8_lossy(&head);
    let first =
        text.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with(['#', ';'])).unwrap_or("");
    let words: Vec<&str> = first.split([' ', '\t']).filter(|word| !word.is_empty()).collect();
    if words.len() == 6 && words.iter().all(|word| word.parse::<f64>().is_ok()) {
        return Ok(Kind::Waypoints);
    }
    let is_word = |word: &&str| word.len() > 1 && word.starts_with(['G', 'M', 'N']) && word[1..].parse::<f64>().is_ok();
    Ok(if words.first().is_some_and(is_word) { Kind::Gcode } else { Kind::Cells })
}
