//! The twelve parts of the gallery (`docs/gallery.md`) as STL files, with the commands that plan them.
//!
//! ```sh
//! cargo run --release --example gallery                # all parts, into target/gallery
//! cargo run --release --example gallery -- boat tee    # these
//! ```

use clap::Parser;
use curvlay_examples::args::{Failure, Outcome, run_with_args};
use curvlay_examples::gallery::{GalleryPart, PARTS};
use curvlay_examples::mesh::Mesh;
use curvlay_examples::output::OutputFolder;
use std::path::PathBuf;
use std::process::ExitCode;

/// Write the parts of the gallery as STL files.
#[derive(Parser, Debug)]
struct Args {
    /// Parts to write; all if none is named
    #[arg(value_parser = clap::builder::PossibleValuesParser::new(PARTS.map(|part| part.name)))]
    parts: Vec<String>,
    /// Folder of the files
    #[arg(long, default_value = "target/gallery", value_name = "DIR")]
    out: PathBuf,
}

fn main() -> ExitCode {
    run_with_args(|args: Args| {
        let folder = OutputFolder::create(&args.out)?;
        let wanted = |part: &&GalleryPart| args.parts.is_empty() || args.parts.iter().any(|name| name == part.name);
        for part in PARTS.iter().filter(wanted) {
            write(&folder, &format!("{}.stl", part.name), &part.mesh())?;
            if let Some(base) = part.base {
                write(&folder, &format!("{}-base.stl", part.name), &base.mesh())?;
            }
            println!("  {}\n  {}", part.about, part.command());
        }
        Ok(Outcome::Done)
    })
}

/// Writes a mesh and says what it is.
fn write(folder: &OutputFolder, name: &str, mesh: &Mesh) -> Result<(), Failure> {
    let mut bytes = Vec::new();
    mesh.write_stl(&mut bytes)?;
    folder.write(name, bytes)?;
    println!("{name}: {} triangles, {:.0} mm3", mesh.triangles.len(), mesh.volume());
    Ok(())
}
