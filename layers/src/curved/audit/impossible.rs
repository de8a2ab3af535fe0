//! Whether proofs that cells are impossible hold, from first principles.
//!
//! Each proof is checked against those before it: (1) no chain of neighbours leads from the platform to the cell without one of its
//! forced cells, (2) none without a cell of its wall, (3) each cell of the wall puts the cell inside the hull, with the platform and the
//! forced cells. Impossible cells of earlier proofs are in no chain.

use super::super::impossible::Impossible;
use super::body::Body;
use super::depth::{Depths, Question};
use super::{Bits, stands_on, supporters};
use crate::cells::Cells;
use crate::curved::{Platform, Rules, RulesError};

/// Why a proof does not hold.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ProofError {
    /// The rules are unsound or do not fit the grid.
    #[error(transparent)]
    Rules(#[from] RulesError),
    /// The proof names a number that no cell of the solid has.
    #[error("proof {proof}: there is no cell {cell}")]
    NoCell {
        /// Number of the proof.
        proof: usize,
        /// The number.
        cell: u32,
    },
    /// A chain of neighbours leads to the cell without this forced cell.
    #[error("proof {proof}: a chain of neighbours leads from the platform to the cell without cell {forced}")]
    NotForced {
        /// Number of the proof.
        proof: usize,
        /// The cell that is not forced.
        forced: u32,
    },
    /// A chain of neighbours leads to the cell without a cell of the wall.
    #[error("proof {proof}: a chain of neighbours leads from the platform to the cell and meets no cell of the wall")]
    Open {
        /// Number of the proof.
        proof: usize,
    },
    /// A cell of the wall does not put the cell inside the hull.
    #[error("proof {proof}: with cell {wall} of the wall, the cell stays accessible")]
    Harmless {
        /// Number of the proof.
        proof: usize,
        /// The cell of the wall.
        wall: u32,
    },
}

/// Checks proofs that cells are impossible. It shares no code with [`prove_impossible`](crate::curved::prove_impossible).
///
/// # Errors
/// [`ProofError`]: for the first proof that does not hold, and why.
///
/// # Cost
/// For each proof with a wall or forced cells a pass over all cells, and some 100 us for each cell of a wall.
///
/// # Example
/// As in [`prove_impossible`](crate::curved::prove_impossible).
pub fn check_impossible(
    cells: &Cells,
    platform: &Platform,
    rules: &Rules,
    proofs: &[Impossible],
) -> Result<(), ProofError> {
    rules.check(cells, platform)?;
    let question = Question::of(rules, platform)?;
    let len = cells.dims().iter().product::<u32>();
    let feet = feet(cells, platform, rules, question);
    let mut chains = Chains { cells, rules, feet, impossible: Bits::of(cells) };
    // Cells that a chain reaches without walls, as long as they are up to date.
    let mut open: Option<Bits> = None;
    for (proof, Impossible { cell, forced, wall }) in proofs.iter().enumerate() {
        let mut named = forced.iter().chain(wall).chain([cell]);
        if let Some(&cell) = named.find(|&&cell| cell >= len || !cells.contains(cells.position(cell))) {
            return Err(ProofError::NoCell { proof, cell });
        }
        let place = cells.position(*cell);
        // Forced: without it no chain leads to the cell, so it is built before.
        for &forced in forced {
            if chains.without(&[forced]).contains(place) {
                return Err(ProofError::NotForced { proof, forced });
            }
        }
        let is_open = match wall.is_empty() {
            true => open.get_or_insert_with(|| chains.without(&[])).contains(place),
            false => chains.without(wall).contains(place),
        };
        if is_open {
            return Err(ProofError::Open { proof });
        }
        let centre = |cell: u32| cells.position(cell).map(|k| 2 * i64::from(k) + 1);
        for &wall in wall {
            // Each cell of the wall puts the cell inside, together with what is forced: whichever is crossed first, the cell is lost, and
            // a chain has to cross one.
            let mut body = beginning(cells, platform);
            forced.iter().chain([&wall]).for_each(|&built| body.add(cells.position(built)));
            body.settle();
            if !Depths::new(question, &body).is_inside(&body, centre(*cell)) {
                return Err(ProofError::Harmless { proof, wall });
            }
        }
        // Without a wall the cell was not reached anyway, so what is reached does not change.
        if chains.impossible.insert(place) && !wall.is_empty() {
            open = None;
        }
    }
    Ok(())
}

/// What is there before the part: the platform and its mould.
fn beginning(cells: &Cells, platform: &Platform) -> Body {
    let mut body = Body::new(cells.dims(), platform.corners(), platform.top());
    if let Some(mould) = platform.mould() {
        mould.iter().for_each(|cell| body.add(mould.position(cell)));
    }
    body.settle();
    body
}

/// The cells that can be built first: on the platform, or next to its mould and not inside the hull of both.
fn feet(cells: &Cells, platform: &Platform, rules: &Rules, question: Question) -> Vec<[u32; 3]> {
    let mut on_mould = Bits::of(cells);
    if let Some(mould) = platform.mould() {
        mould.iter().for_each(|cell| _ = on_mould.insert(mould.position(cell)));
    }
    let body = beginning(cells, platform);
    let mut depths = Depths::new(question, &body);
    let faces = [[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1]];
    let is_foot = |&place: &[u32; 3]| {
        let stands = stands_on(platform.corners(), place, rules.flat)
            || faces.iter().any(|&step| on_mould.contains_at(place, step));
        let is_inside = |depths: &mut Depths| depths.is_inside(&body, place.map(|k| 2 * i64::from(k) + 1));
        stands && (platform.mould().is_none() || !is_inside(&mut depths))
    };
    cells.iter().map(|cell| cells.position(cell)).filter(is_foot).collect()
}

struct Chains<'a> {
    cells: &'a Cells<'a>,
    rules: &'a Rules,
    /// Where a chain can begin.
    feet: Vec<[u32; 3]>,
    /// Cells of earlier proofs.
    impossible: Bits,
}

impl Chains<'_> {
    /// The cells to which a chain leads from the platform without these cells and the impossible ones.
    fn without(&self, barred: &[u32]) -> Bits {
        let mut shut = Bits { dims: self.impossible.dims, words: self.impossible.words.clone() };
        barred.iter().for_each(|&cell| _ = shut.insert(self.cells.position(cell)));
        let mut reached = Bits::of(self.cells);
        let mut waiting: Vec<[u32; 3]> = self.feet.iter().copied().filter(|&place| !shut.contains(place)).collect();
        waiting.iter().for_each(|&place| _ = reached.insert(place));
        let steps = supporters(self.rules.neighbours);
        while let Some(place) = waiting.pop() {
            for step in &steps {
                let [x, y, z] = [0, 1, 2].map(|k| i64::from(place[k]) + step[k]);
                let (Ok(x), Ok(y), Ok(z)) = (u32::try_from(x), u32::try_from(y), u32::try_from(z)) else { continue };
                let next = [x, y, z];
                if self.cells.contains(next) && !shut.contains(next) && reached.insert(next) {
                    waiting.push(next);
                }
            }
        }
        reached
    }
}
