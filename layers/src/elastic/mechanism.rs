//! Whether the supports hold all of the part.

use super::ElasticError;
use super::conditions::Places;
use nalgebra::{Matrix6, Point3, SymmetricEigen, Vector3, Vector6};

/// Rigid motions with less than this share of the largest eigenvalue are free: lengths are measured in the size of the piece, so a
/// support that holds them by a hundred thousandth of that size counts as none.
const FREE: f64 = 1e-10;

/// How the supports hold a piece.
#[derive(Clone, Copy, Debug)]
pub(super) struct HeldPiece {
    pub(super) cells: usize,
    /// Nodes with a fixed component, as often as cells have them.
    fixed: usize,
    low: Point3<f64>,
    high: Point3<f64>,
    gram: Matrix6<f64>,
}

impl HeldPiece {
    /// Motions of 6 that nothing holds.
    pub(super) fn free_motions(&self) -> usize {
        let eigenvalues = SymmetricEigen::new(self.gram).eigenvalues;
        eigenvalues.iter().filter(|&&value| value <= FREE * eigenvalues.amax()).count()
    }
}

/// The pieces of the part with what holds them.
pub(super) fn pieces_held(places: &Places, fixed: &[u8]) -> (Vec<u32>, Vec<HeldPiece>) {
    let (piece_of, count) = places.pieces();
    let nowhere = Point3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY);
    let nothing = HeldPiece { cells: 0, fixed: 0, low: nowhere, high: -nowhere, gram: Matrix6::zeros() };
    let mut pieces = vec![nothing; count];
    for (cell, &piece) in piece_of.iter().enumerate() {
        let piece = &mut pieces[piece as usize];
        piece.cells += 1;
        for point in places.nodes_of(cell).map(|node| places.node(node)) {
            (piece.low, piece.high) = (piece.low.inf(&point), piece.high.sup(&point));
        }
    }
    for (cell, &piece) in piece_of.iter().enumerate() {
        let piece = &mut pieces[piece as usize];
        let (middle, size) = (nalgebra::center(&piece.low, &piece.high), (piece.high - piece.low).norm());
        for node in places.nodes_of(cell).into_iter().filter(|&node| fixed[node] != 0) {
            piece.fixed += 1;
            let arm = (places.node(node) - middle) / size;
            for axis in (0..3).filter(|&axis| fixed[node] >> axis & 1 == 1) {
                let along = Vector3::ith(axis, 1.0);
                let turn = arm.cross(&along);
                let row = Vector6::new(along.x, along.y, along.z, turn.x, turn.y, turn.z);
                piece.gram += row * row.transpose();
            }
        }
    }
    (piece_of, pieces)
}

/// That every piece is held.
pub(super) fn check(places: &Places, fixed: &[u8]) -> Result<(), ElasticError> {
    let (_, pieces) = pieces_held(places, fixed);
    let adrift: usize = pieces.iter().filter(|piece| piece.fixed == 0).map(|piece| piece.cells).sum();
    if adrift > 0 {
        return Err(ElasticError::NotConnected { cells: adrift, of: places.cells.len() });
    }
    match pieces.iter().map(|piece| (piece.free_motions(), piece.cells)).find(|&(free, _)| free > 0) {
        Some((free, cells)) => Err(ElasticError::Loose { free, cells }),
        None => Ok(()),
    }
}

impl HeldPiece {
    /// Whether it has a supported node.
    pub(super) fn is_supported(&self) -> bool {
        self.fixed > 0
    }
}
