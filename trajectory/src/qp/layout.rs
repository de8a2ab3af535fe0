//! Where the unknowns of a quadratic program lie: stage by stage its variables, and behind them the multipliers of the
//! equations of that stage.

use super::problem::BandedQp;

pub(super) struct Layout {
    /// Unknown of each variable before the border.
    pub unknown: Vec<u32>,
    /// Equations: the row and the unknown of its multiplier.
    pub equations: Vec<(u32, u32)>,
    /// Unknowns of each stage.
    pub sizes: Vec<usize>,
    /// The sign of the pivot of each unknown.
    pub signs: Vec<f64>,
}

impl Layout {
    /// A problem of border variables alone has one stage, for their multipliers.
    pub fn of(qp: &BandedQp) -> Self {
        let mut homes: Vec<(usize, u32)> = (0..qp.rows.len())
            .filter(|&row| qp.rows[row].is_equation())
            .map(|row| (qp.home(row).unwrap_or(0), row as u32))
            .collect();
        homes.sort_unstable();
        let stages = (qp.first.len() - 1).max(1);
        let mut layout = Layout { unknown: vec![], equations: vec![], sizes: vec![], signs: vec![] };
        let mut next = homes.iter().peekable();
        for stage in 0..stages {
            let before = layout.signs.len();
            let variables = qp.first.get(stage + 1).map_or(0..0, |&end| qp.first[stage]..end);
            layout.unknown.extend((before..before + variables.len()).map(|at| at as u32));
            layout.signs.extend_from_slice(&qp.signs[variables]);
            while let Some(&(_, row)) = next.next_if(|home| home.0 == stage) {
                layout.equations.push((row, layout.signs.len() as u32));
                layout.signs.push(-1.0);
            }
            layout.sizes.push(layout.signs.len() - before);
        }
        layout
    }

    /// The unknown of a variable; those of the border follow on all others.
    pub fn of_variable(&self, variable: u32) -> usize {
        let border = || self.signs.len() + variable as usize - self.unknown.len();
        self.unknown.get(variable as usize).map_or_else(border, |&at| at as usize)
    }
}
