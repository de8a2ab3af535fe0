//! What is there before the part (`--on`): a mould, or a part that exists already. It stands on the plate where its file has it beside the part.

use crate::failure;
use curvlay_examples::args::{Failure, Part};
use curvlay_layers::cells::Cells;
use curvlay_layers::curved::Platform;
use curvlay_toolpath::layer;
use curvlay_voxel::{VoxelGrid, VoxelOptions, Voxelisation};
use nalgebra::{Point3, Vector3};

/// A mould in the frame of the layers: the plate is the plane z = 0.
#[derive(Clone, Debug)]
pub struct Mould {
    /// The name of its file.
    pub name: String,
    /// Its vertices, in millimetres.
    pub vertices: Vec<Point3<f64>>,
    /// Its triangles.
    pub triangles: Vec<[u32; 3]>,
}

/// A part with what it is built on.
pub struct Standing {
    pub mould: Mould,
    pub platform: Platform,
    /// The cells of the part without those whose centre lies in the mould.
    pub solid: Voxelisation,
    /// Cells of the part that lie more than a cell deep in the mould, by rising number: they are not printed.
    pub buried: Vec<u32>,
}

impl Mould {
    /// Puts a mould beside the cells of a part.
    pub fn stand(mould: &Part, solid: Voxelisation, platform_mm: f64) -> Result<Standing, Failure> {
        let of_mould = |error: &dyn std::fmt::Display| failure(format!("{}: {error}", mould.name));
        let bounds = mould.mesh.bounds().ok_or_else(|| of_mould(&"the file holds no triangles"))?;
        let solid = solid.beside(bounds, VoxelOptions::default().max_bytes).map_err(|error| of_mould(&error))?;
        let vertices: Vec<Point3<f64>> = mould.mesh.vertices.iter().map(|vertex| vertex + solid.shift).collect();
        let (name, triangles) = (mould.name.clone(), mould.mesh.triangles.clone());
        let grid = &solid.grid;
        let (dims, cell_mm, origin) = (grid.dims(), grid.cell_mm(), grid.origin());
        let all = Cells::new(dims, grid.rows())?;
        let platform = disc(&all, cell_mm, origin, &vertices, platform_mm)?;
        let platform = platform.on_mould_mesh(dims, cell_mm, origin, &vertices, &triangles).map_err(failure)?;
        let rows = platform.outside_mould(&all)?;
        let outside = Cells::new(dims, &rows)?;
        if outside.count() == 0 {
            return Err(of_mould(&"the part lies inside it: both files must have the same origin"));
        }
        let buried = buried(&all, &outside);
        let grid = VoxelGrid::from_rows(dims, rows)?.placed(cell_mm, origin)?;
        let mould = Mould { name, vertices, triangles };
        Ok(Standing { mould, platform, solid: Voxelisation { grid, ..solid }, buried })
    }

    /// As the nozzle must keep clear of it.
    pub fn surface(&self, layer_mm: f64) -> layer::Mould<'_> {
        layer::Mould { vertices: &self.vertices, triangles: &self.triangles, thickness: layer_mm }
    }

    /// Where it stands, along x and y of the machine file.
    pub fn place(&self) -> String {
        let [x, y] = [0, 1].map(|axis| {
            let along = || self.vertices.iter().map(|vertex| vertex[axis]);
            let [low, high] = [along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max)];
            format!("{low:.2} to {high:.2}")
        });
        format!("x {x}, y {y} of the machine file")
    }
}

/// A disc of the given diameter under the part and the mould, or the least one that holds both.
fn disc(
    cells: &Cells,
    cell_mm: f64,
    origin: Point3<f64>,
    mould: &[Point3<f64>],
    platform_mm: f64,
) -> Result<Platform, Failure> {
    let of_part = cells.iter().map(|cell| Point3::from(cells.position(cell).map(|k| f64::from(k) + 0.5)));
    let places: Vec<Vector3<f64>> =
        mould.iter().map(|vertex| (vertex - origin) / cell_mm).chain(of_part.map(|centre| centre.coords)).collect();
    let centre = [0, 1].map(|axis| {
        let along = || places.iter().map(|place| place[axis]);
        (along().fold(f64::INFINITY, f64::min) + along().fold(f64::NEG_INFINITY, f64::max)) / 2.0
    });
    let reach = |place: &Vector3<f64>| (place.x - centre[0]).hypot(place.y - centre[1]) + 1.0;
    let farthest = places.iter().map(reach).fold(0.0, f64::max);
    Ok(Platform::disc(centre, farthest.max(platform_mm / 2.0 / cell_mm))?)
}

/// The cells that are not outside, nor beside one that is.
fn buried(all: &Cells, outside: &Cells) -> Vec<u32> {
    let is_deep = |&cell: &u32| {
        let at = all.position(cell);
        let beside = (0..6).map(|face| {
            let mut beside = at;
            beside[face / 2] = if face % 2 == 0 { at[face / 2].wrapping_sub(1) } else { at[face / 2] + 1 };
            beside
        });
        !outside.contains(at) && !beside.into_iter().any(|beside| outside.contains(beside))
    };
    all.iter().filter(is_deep).collect()
}
