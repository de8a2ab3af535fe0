//! A stream to the stand-in of a controller, in memory: sender and robot take turns, a cycle at a time.

use super::sockets::StreamError;
use super::stand_in::StandIn;
use curvlay_examples::bars::Bars;
use curvlay_examples::count::counted;
use curvlay_kinematics::program::ur_stream::{
    UrState, UrStreamError, UrStreamJob, UrStreamOptions, UrStreamSender, UrTick,
};
use std::fmt;
use std::time::Duration;

/// What the stand-in did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DryRun {
    /// Ticks run.
    pub ticks: u32,
    /// Cycles in which it moved, in seconds.
    pub seconds: f64,
    /// Cycles in which it stood between the first tick and the last.
    pub stood: u32,
    /// The fastest joint, in rad/s, moves by joints left out.
    pub fastest_rad_s: f64,
    /// Filament laid, in mm.
    pub filament_mm: f64,
}

impl fmt::Display for DryRun {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let DryRun { ticks, seconds, stood, fastest_rad_s, filament_mm } = self;
        let (degrees, stood) = (fastest_rad_s.to_degrees(), counted(*stood as usize, "cycle"));
        write!(
            f,
            "the stand-in ran {ticks} ticks in {seconds:.1} s, stood for {stood}, turned joints by at most {degrees:.1} degrees/s and laid \
             {filament_mm:.1} mm of filament"
        )
    }
}

/// Cycles between two replies, as on a robot: every 0.04 s.
const TELL_S: f64 = 0.04;

/// Streams a print to a stand-in whose arm is where the print begins.
pub fn dry_run(
    (ticks, job): (impl Iterator<Item = Result<UrTick, UrStreamError>>, UrStreamJob),
    options: &UrStreamOptions,
    begin: [f64; 6],
    bars: &Bars,
) -> Result<DryRun, StreamError> {
    let mut sender = UrStreamSender::new(ticks, job, options.sender())?;
    let mut robot = StandIn::new(options, begin);
    let period_s = options.rate.seconds();
    let tell = (TELL_S / period_s).round() as u64;
    let mut found = DryRun::default();
    let mut last = begin;
    let mut stood = 0;
    sender.connected(Duration::ZERO)?;
    for cycle in 0u64.. {
        let now = Duration::from_secs_f64(cycle as f64 * period_s);
        if cycle.is_multiple_of(tell) {
            sender.receive(&robot.reply().to_string(), now)?;
            let progress = sender.progress();
            bars.update("stream", u64::from(progress.run), u64::from(progress.total));
            if progress.over {
                break;
            }
        }
        while let Some(frame) = sender.next_frame(now)? {
            robot.take(&frame);
        }
        let moves = robot.reply().state == UrState::Runs;
        match robot.cycle() {
            Some(ran) => {
                found.stood += std::mem::take(&mut stood);
                found.seconds += period_s;
                found.filament_mm += ran.filament_mm_s.unwrap_or(0.0) * period_s;
                let turn = (0..6).map(|k| (ran.joints[k] - last[k]).abs()).fold(0.0, f64::max);
                // The robot rests behind a move.
                if robot.reply().state == UrState::Runs {
                    found.fastest_rad_s = found.fastest_rad_s.max(turn / period_s);
                }
                last = ran.joints;
            }
            None if moves || found.seconds > 0.0 => stood += 1,
            None => {}
        }
    }
    found.ticks = sender.progress().run;
    Ok(found)
}
