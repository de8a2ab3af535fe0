//! Runs of pieces that are as good as straight, as one piece each.
//!
//! Curves have many points where they bend and few bends that a raster sees. Each piece of a bead is laid down by itself, and at least as
//! long as it is wide, so short pieces lay the same samples down again and again.

use super::curve::Piece;

/// Ends of pieces, half their width, and their arc length may be off by this share of the step of the raster, which errs by half of it.
const OFF: f64 = 1.0 / 32.0;

/// Pieces that become one at most: each is compared with all before it.
const MAX_JOINED: usize = 64;

/// The pieces in their order, but for those that go straight on in a triangle: these become one.
pub(super) fn straightened(pieces: &[Piece], step: f64) -> Vec<Piece> {
    let mut straight = Vec::new();
    let mut rest = pieces;
    while let Some(first) = rest.first() {
        let mut count = 1;
        while count < MAX_JOINED
            && rest.get(count).is_some_and(|next| continues(&rest[count - 1], next))
            && is_straight(&rest[..count + 1], OFF * step)
        {
            count += 1;
        }
        straight.push(whole(first, &rest[count - 1]));
        rest = &rest[count..];
    }
    straight
}

fn continues(piece: &Piece, next: &Piece) -> bool {
    (piece.curve, piece.triangle, piece.weights[1]) == (next.curve, next.triangle, next.weights[0])
}

fn whole(first: &Piece, last: &Piece) -> Piece {
    let of = |pair: fn(&Piece) -> [f64; 2]| [pair(first)[0], pair(last)[1]];
    Piece {
        weights: [first.weights[0], last.weights[1]],
        ends: [first.ends[0], last.ends[1]],
        radii: of(|piece| piece.radii),
        along: of(|piece| piece.along),
        ..*first
    }
}

/// Whether one piece from the first end to the last passes all ends in between, and goes on from each to the next.
fn is_straight(pieces: &[Piece], off: f64) -> bool {
    let [first, .., last] = pieces else { return true };
    let Piece { ends: [from, to], radii, along, .. } = whole(first, last);
    let way = to - from;
    let length = way.norm();
    let Some(unit) = way.try_normalize(0.0) else { return false };
    let mut before = 0.0;
    pieces[1..].iter().all(|piece| {
        let at = (piece.ends[0] - from).dot(&unit);
        let share = at / length;
        let between = |[a, b]: [f64; 2]| a + (b - a) * share;
        let goes_on = at >= before && at <= length;
        before = at;
        goes_on
            && (piece.ends[0] - from).perp(&unit).abs() <= off
            && (piece.radii[0] - between(radii)).abs() <= off
            // Arc lengths are in widths.
            && (piece.along[0] - between(along)).abs() * 2.0 * piece.radii[0] <= off
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    /// Pieces from point to point, each with half a width.
    fn pieces(points: &[([f64; 2], f64)]) -> Vec<Piece> {
        let mut along = 0.0;
        let piece = |(k, pair): (usize, &[([f64; 2], f64)])| {
            let ends = [pair[0], pair[1]].map(|(at, _)| Vector2::from(at));
            let radii = [pair[0].1, pair[1].1];
            let from = along;
            along += (ends[1] - ends[0]).norm() / (radii[0] + radii[1]);
            let weights = [k, k + 1].map(|k| [k as i64, 0, 0]);
            Piece { curve: 0, triangle: 0, weights, ends, radii, along: [from, along] }
        };
        points.windows(2).enumerate().map(piece).collect()
    }

    fn count(points: &[([f64; 2], f64)]) -> usize {
        let (all, step) = (pieces(points), 0.08);
        let straight = straightened(&all, step);
        let ends = |pieces: &[Piece]| (pieces[0].ends[0], pieces[pieces.len() - 1].ends[1]);
        assert_eq!(ends(&all), ends(&straight));
        assert!(straight.windows(2).all(|pair| pair[0].ends[1] == pair[1].ends[0]));
        let whole = all[all.len() - 1].along[1];
        assert!((straight[straight.len() - 1].along[1] - whole).abs() < 1e-12);
        straight.len()
    }

    #[test]
    fn what_goes_straight_on_is_one_piece() {
        let straight: Vec<_> = (0..9).map(|k| ([f64::from(k) * 0.1, 0.0], 0.5)).collect();
        assert_eq!(count(&straight), 1);
        let long: Vec<_> = (0..=2 * MAX_JOINED).map(|k| ([k as f64 * 0.1, 0.0], 0.5)).collect();
        assert_eq!(count(&long), 2);
        // A bend that the raster does not see, and one that it does.
        let bent = |height: f64| -> Vec<_> {
            (0..9).map(|k| ([f64::from(k) * 0.1, height * f64::from(4 - (k - 4_i32).abs()) / 4.0], 0.5)).collect()
        };
        assert_eq!((count(&bent(0.002)), count(&bent(0.02))), (1, 2));
        // A curve that turns back, one that grows wide in its middle, and one that grows evenly.
        assert_eq!(count(&[([0.0, 0.0], 0.5), ([1.0, 0.0], 0.5), ([0.4, 0.0], 0.5)]), 2);
        assert_eq!(count(&[([0.0, 0.0], 0.5), ([0.5, 0.0], 0.6), ([1.0, 0.0], 0.5)]), 2);
        assert_eq!(count(&[([0.0, 0.0], 0.500), ([0.5, 0.0], 0.501), ([1.0, 0.0], 0.502)]), 1);
    }

    #[test]
    fn other_curves_and_other_triangles_are_other_pieces() {
        let line: Vec<_> = (0..4).map(|k| ([f64::from(k) * 0.1, 0.0], 0.5)).collect();
        let mut all = pieces(&line);
        all[1].triangle = 1;
        assert_eq!(straightened(&all, 0.08).len(), 3);
        let mut all = pieces(&line);
        all[2].curve = 1;
        assert_eq!(straightened(&all, 0.08).len(), 2);
        assert!(straightened(&[], 0.08).is_empty());
    }
}
