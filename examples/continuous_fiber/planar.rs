//! The arc in planar layers, as a printer without a robot makes it (figure 5.3(b) of the dissertation): thermoplastic alone.
//!
//! A tape of 68 mm fits into none of these layers: they are cut off by the arc's own sides. How long one could be is found by laying tapes on each; the test of
//! the arcs compares them with tapes that follow the arc.

use super::specimens::Specimen;
use super::tapes::BEAD_MM;
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::mesh::Mesh;
use curvlay_examples::nalgebra::{UnitVector3, Vector3};
use curvlay_toolpath::fiber::direction::DirectionField;
use curvlay_toolpath::fiber::tapes::{Tape, TapeOptions, lay_tapes};
use curvlay_toolpath::fill::fill_layers;
use curvlay_toolpath::gcode::{Move, marked_moves};
use curvlay_toolpath::gouging::Nozzle;
use curvlay_toolpath::layer::LayerSurface;
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::path::PathOptions;
use curvlay_toolpath::plan::PrintOptions;

/// The arc in planar layers.
pub struct Planar {
    /// Its layers.
    pub layers: usize,
    /// The moves of its print; none if they were not asked for.
    pub moves: Vec<Move>,
    /// The longest tape along it that a layer has room for, in millimetres; 0 for none.
    pub longest_tape_mm: f64,
    /// Tapes along it on the top of each layer, as long as a head can cut them.
    pub tapes: Vec<Tape>,
}

/// Cuts the arc, which stands on its ends, and plans its print.
///
/// # Arguments
/// * `blade_mm`: the shortest tape of the head.
pub fn plan(specimen: &Specimen, blade_mm: f64, nozzle: Option<&Nozzle>, bars: &Bars) -> Result<Planar, Failure> {
    let standing = specimen.standing_mm();
    let count = (standing / specimen.layer_mm).round().max(1.0);
    let height = standing / count;
    let layers: Vec<Mesh> = (0..count as u32).map(|k| specimen.section_at((f64::from(k) + 0.5) * height)).collect();
    let progress = |p: curvlay_toolpath::Progress| bars.show(p.stage, p.done, p.total);
    // Any tape that fits, however short.
    let [_, width] = specimen.tape_mm;
    let options = TapeOptions { width, spacing: width, min_length: width, ..TapeOptions::default() };
    let (mut longest_tape_mm, mut tapes): (f64, Vec<Tape>) = (0.0, Vec::new());
    for strip in (0..count as u32).map(|k| specimen.strip_at((f64::from(k) + 0.5) * height)) {
        let surface = SurfaceMesh::new(strip.vertices, strip.triangles)?;
        let field = DirectionField::from_fn(&surface, |_| Vector3::x())?;
        let plan = lay_tapes(&field, &options, &progress)?;
        longest_tape_mm = plan.tapes.iter().map(Tape::length).fold(longest_tape_mm, f64::max);
        let on_top = |tape: &Tape| {
            let points = tape.points.iter().map(|point| point + Vector3::z() * (height / 2.0)).collect();
            Tape { points, ..tape.clone() }
        };
        tapes.extend(plan.tapes.iter().filter(|tape| tape.length() >= blade_mm).map(on_top));
    }
    let moves = nozzle.map(|nozzle| moves(&layers, height, nozzle, bars)).transpose()?.unwrap_or_default();
    Ok(Planar { layers: layers.len(), moves, longest_tape_mm, tapes })
}

fn moves(layers: &[Mesh], height: f64, nozzle: &Nozzle, bars: &Bars) -> Result<Vec<Move>, Failure> {
    let progress = |p: curvlay_toolpath::Progress| bars.show(p.stage, p.done, p.total);
    let thickness: Vec<Vec<f64>> = layers.iter().map(|layer| vec![height; layer.triangles.len()]).collect();
    let surfaces: Vec<LayerSurface> = layers
        .iter()
        .zip(&thickness)
        .map(|(layer, thickness)| (&layer.vertices[..], &layer.triangles[..], &thickness[..]).into())
        .collect();
    let options = PathOptions { bead: BEAD_MM, coverage: false, ..PathOptions::default() };
    let filled = fill_layers(&surfaces, &options, &progress)?;
    let up: Vec<UnitVector3<f64>> = vec![Vector3::z_axis(); surfaces.len()];
    let plan = filled.stack(&surfaces)?.plan_along(&up, nozzle, &PrintOptions::default(), &progress)?;
    Ok(marked_moves(&plan.deposition.moves, &plan.resolved.paths).collect())
}
