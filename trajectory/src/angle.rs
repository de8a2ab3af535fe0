//! Angles and their images: the same direction, whole turns apart.

use std::f64::consts::{PI, TAU};

/// The image in `(-pi, pi]`.
pub(crate) fn wrapped(angle: f64) -> f64 {
    if angle > -PI && angle <= PI {
        return angle;
    }
    let near = angle - TAU * (angle / TAU).round();
    if near <= -PI { near + TAU } else { near }
}

/// The short way of a turn: the image within half a turn of zero. Half a turn exactly becomes its opposite.
pub(crate) fn short_way(by: f64) -> f64 {
    by - TAU * (by / TAU).round()
}

/// The image of an angle that is nearest to another one. Where two are equally near it is either of them.
pub(crate) fn nearest_image(angle: f64, near: f64) -> f64 {
    angle + TAU * ((near - angle) / TAU).round()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_are_whole_turns_away_and_near() {
        for k in -100..=100 {
            let angle = 0.37 * f64::from(k);
            for (image, near) in [
                (wrapped(angle), 0.0),
                (short_way(angle), 0.0),
                (nearest_image(angle, 0.0), 0.0),
                (nearest_image(angle, 20.0), 20.0),
                (nearest_image(angle, -3.0), -3.0),
            ] {
                let turns = (image - angle) / TAU;
                assert!((turns - turns.round()).abs() < 1e-14, "{angle} {image}");
                assert!((image - near).abs() <= PI + 1e-14, "{angle} {image} {near}");
            }
        }
        assert_eq!([wrapped(PI), wrapped(-PI), wrapped(3.0 * PI)], [PI; 3]);
        assert_eq!([short_way(PI), short_way(-PI)], [-PI, PI]);
    }
}
