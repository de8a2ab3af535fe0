//! Seeds that only our writers make: `CURVLAY_FUZZ=seeds` writes them into the folder `CURVLAY_FUZZ_SEEDS`.

use crate::geometry::small_layers;
use crate::readers::{MADE_OF, ranges};
use curvlay_examples::output::OutputFolder;
use curvlay_toolpath::fill::fill_range;
use curvlay_toolpath::gcode::flavour::Flavour;
use std::error::Error;
use std::ops::ControlFlow;
use std::path::PathBuf;

pub fn write() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::var("CURVLAY_FUZZ_SEEDS")?);
    let (surfaces, fill) = small_layers();
    let layers = fill_range(&surfaces, 0..surfaces.len(), &fill.part, &|_| ControlFlow::Continue(()))?;
    let paths = OutputFolder::create(&folder.join("paths"))?;
    ranges::write(&surfaces, MADE_OF, &fill, 0..surfaces.len(), &layers, &paths)?;
    let flavours = folder.join("flavour");
    std::fs::create_dir_all(&flavours)?;
    for name in Flavour::names() {
        let flavour = Flavour::built_in(name).ok_or("not built in")?;
        std::fs::write(flavours.join(format!("{name}.json")), serde_json::to_vec(&flavour)?)?;
    }
    Ok(())
}
