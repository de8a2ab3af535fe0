//! The speed between ramps.

/// The speed of a move over `way` that takes `seconds` with so many ramps (0 to 2) of the acceleration `rate`: the slower solution of
/// `way / v + ramps v / (2 rate) = seconds`. Where the ramps leave no time for it, the speed at which the move is all ramps.
pub(super) fn cruise(way: f64, seconds: f64, ramps: u8, rate: f64) -> f64 {
    let ramps = f64::from(ramps);
    let left = seconds * seconds - 2.0 * ramps * way / rate;
    if left <= 0.0 {
        return (2.0 * rate * way / ramps).sqrt();
    }
    // Without a difference of nearly equal numbers.
    2.0 * way / (seconds + left.sqrt())
}

#[cfg(test)]
mod tests {
    use super::cruise;

    /// Seconds of a move, summed up in steps.
    fn seconds(way: f64, speed: f64, ramps: u8, rate: f64) -> f64 {
        let ramp = |whole: f64| (speed / rate, whole * speed * speed / (2.0 * rate));
        let (time, length) = ramp(1.0);
        let (time, length) = (f64::from(ramps) * time, f64::from(ramps) * length);
        time + (way - length) / speed
    }

    #[test]
    fn takes_its_time() {
        for ramps in 0..=2 {
            for (way, time, rate) in [(10.0, 1.0, 1200.0), (0.5, 0.3, 1.4), (1e-3, 0.04, 10.0)] {
                let speed = cruise(way, time, ramps, rate);
                let took = seconds(way, speed, ramps, rate);
                let all_ramps = f64::from(ramps) * 2.0 * way / rate > time * time;
                assert!(all_ramps || (took - time).abs() < 1e-12, "{ramps} {way} {time}: {speed} {took}");
                assert!(!all_ramps || speed * speed <= 2.0 * rate * way);
            }
        }
    }
}
