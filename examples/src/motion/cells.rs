//! The two workcells of the dissertation, as files, and meshes of links.

use crate::mesh::read_mesh;
use curvlay_kinematics::workcell;
use std::path::Path;

/// A UR3 that holds the part under a standing nozzle, and an IRB 1200 with the nozzle in its hand over a table that tilts and
/// turns: workcell files.
pub const UR3_CELL: &str = include_str!("../../cells/ur3.json");

/// See [`UR3_CELL`].
pub const TABLE_CELL: &str = include_str!("../../cells/irb1200-table.json");

/// Points and triangles of a mesh of a link, for [`AnyWorkcell::with_link_meshes`](workcell::AnyWorkcell::with_link_meshes): a file from a folder on.
///
/// # Errors
/// What is wrong with the file, in words.
pub fn link_mesh(folder: &Path, file: &str) -> Result<workcell::LinkMesh, String> {
    let mesh = read_mesh(&folder.join(file)).map_err(|error| error.to_string())?;
    Ok((mesh.vertices, mesh.triangles))
}
