//! Where programs of a long print begin and end.

use std::ops::Range;

/// Some motions of a print that make a program.
#[derive(Clone, Debug, PartialEq)]
pub struct PrintPiece {
    /// Which of the motions.
    pub motions: Range<usize>,
    /// Steps; of a stream with fractions, since motions do not end on its ticks.
    pub steps: f64,
    /// Whether it begins where the piece before ends. The robot has to be brought to one that does not; the first does not.
    pub joined: bool,
}

/// Cuts a print into programs: where no way leads on, and before a motion with which a program would have more than
/// `max_steps`. A single motion may have more.
///
/// # Arguments
/// * `motions`: for each its steps, with those of the way on, and whether there is a way on to the next.
///
/// # Example
/// ```
/// use curvlay_kinematics::print_program::print_pieces;
/// let pieces = print_pieces([(4.0, true), (3.5, true), (3.0, false), (1.0, true)], 8);
/// assert_eq!(pieces.iter().map(|piece| (piece.motions.clone(), piece.joined)).collect::<Vec<_>>(), [
///     (0..2, false), (2..3, true), (3..4, false),
/// ]);
/// ```
pub fn print_pieces(motions: impl IntoIterator<Item = (f64, bool)>, max_steps: u64) -> Vec<PrintPiece> {
    let mut pieces: Vec<PrintPiece> = Vec::new();
    let mut joined = false;
    for (number, (steps, leads_on)) in motions.into_iter().enumerate() {
        match pieces.last_mut() {
            Some(last) if joined && last.steps + steps <= max_steps as f64 => {
                last.motions.end = number + 1;
                last.steps += steps;
            }
            _ => pieces.push(PrintPiece { motions: number..number + 1, steps, joined }),
        }
        joined = leads_on;
    }
    pieces
}
