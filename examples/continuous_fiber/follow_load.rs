//! Layers that follow the load: directions of growth for `curved_layers --directions`, and what they gain.

use super::Args;
use super::layer::{PartLayers, WORST};
use curvlay_examples::args::{Failure, Part};
use curvlay_examples::bars::Bars;
use curvlay_examples::nalgebra::{Point3, Vector3};
use curvlay_layers::cells::Cells;
use curvlay_layers::curved::surface::LayerField;
use curvlay_layers::curved::{
    FollowOptions, Guides, LayerOptions, LayersBy, Workpiece, layer_normal, load_angle, load_field,
};
use std::io::{self, Write};

/// Directions of growth across the largest stresses.
pub struct FollowedLoad {
    /// Places and directions, in the numbers of the part's file.
    directions: Vec<([f64; 3], [f64; 3])>,
    /// Angle between layers and the largest stresses where these are worst, in degrees: of directed layers, and of those that follow the directions.
    pub angle_deg: [f64; 2],
    /// Cells that their orders miss.
    pub missed: [usize; 2],
}

impl FollowedLoad {
    /// Finds directions for the part under its load, and orders it by them.
    ///
    /// # Arguments
    /// * `stresses`: of the cells, by rising number.
    pub fn new(
        args: &Args,
        part: &Part,
        layers: &PartLayers,
        stresses: &[[f64; 6]],
        bars: &Bars,
    ) -> Result<Self, Failure> {
        let progress = |p: curvlay_layers::Progress| bars.show(p.stage, p.done, p.total);
        layers.in_workpiece(part, |workpiece| {
            let options = LayerOptions {
                height_mm: args.layer_height_mm,
                layers_by: LayersBy::Directed,
                support: None,
                ..LayerOptions::default()
            };
            let cells = workpiece.cells;
            let ordered = |directions: Option<&[Vector3<f64>]>| -> Result<(LayerField, usize), Failure> {
                let guided = Workpiece { guides: Guides { directions, ..Guides::default() }, ..*workpiece };
                let order = guided.order(&options, &progress)?;
                let missed = order.growth.missed.len();
                Ok((order.field.ok_or_else(|| Failure::new("a directed order has no field"))?, missed))
            };
            let (directed, missed) = ordered(None)?;
            let wanted = wanted(&cells, stresses, &directed, bars)?;
            let (followed, missed_by_followed) = ordered(Some(&wanted))?;
            let degrees = |field: &LayerField| -> Result<f64, Failure> {
                Ok(load_angle(&cells, stresses, field, WORST)?.mean.to_degrees())
            };
            let placement = args.mesh.placement();
            let directions = cells.iter().map(|cell| {
                let at = cells.position(cell).map(|k| (f64::from(k) + 0.5) * workpiece.cell_mm);
                let place: Point3<f64> = workpiece.origin + Vector3::from(at) - layers.solid.shift;
                (placement.of_file(place), placement.up.back(wanted[cell as usize].into()))
            });
            Ok(FollowedLoad {
                directions: directions.collect(),
                angle_deg: [degrees(&directed)?, degrees(&followed)?],
                missed: [missed, missed_by_followed],
            })
        })
    }

    /// The file of `curved_layers --directions`.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "x,y,z,i,j,k")?;
        self.directions
            .iter()
            .try_for_each(|([x, y, z], [i, j, k])| writeln!(out, "{x:.6},{y:.6},{z:.6},{i:.6},{j:.6},{k:.6}"))
    }
}

/// For each cell of the grid the way in which a field rises that follows the load from another one on; of length 0 where it is level.
fn wanted(cells: &Cells, stresses: &[[f64; 6]], base: &LayerField, bars: &Bars) -> Result<Vec<Vector3<f64>>, Failure> {
    let progress = |p: curvlay_layers::Progress| bars.show(p.stage, p.done, p.total);
    let field = load_field(cells, stresses, base, &FollowOptions::default(), &progress)?;
    let least = field.values.iter().copied().fold(f64::INFINITY, f64::min);
    let field = LayerField::new(cells, field.values.iter().map(|value| value - least).collect(), 1.0)?;
    let in_grid = base.values().len() as u32;
    Ok((0..in_grid).map(|cell| layer_normal(cells, &field, cell).unwrap_or_else(Vector3::zeros)).collect())
}
