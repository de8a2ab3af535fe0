//! Brooks' extruder as a simulated device behind its serial protocol: section 3.3.8. A main loop of commands, speed from the counts of
//! an encoder, and a PID controller with the gains 2, 0.5 and 2, as the Arduino library has it: output 0 to 255, every 100 ms, the
//! derivative that of the measurement, the integral kept within the output.
//!
//! The motor is of the first order. The thesis says its full speed, 11 turns a minute; its time constant, the encoder and the gear are
//! ours. Time is that of the simulation.

/// Seconds a step.
const STEP: f64 = 1e-3;
/// The speed is computed, and the controller runs, at these times, in steps.
const SPEED_EVERY: u64 = 200;
const PID_EVERY: u64 = 100;
const GAINS: [f64; 3] = [2.0, 0.5, 2.0];
const FULL_OUTPUT: f64 = 255.0;
const FULL_RPM: f64 = 11.0;
const TIME_CONSTANT: f64 = 0.15;
const COUNTS_PER_REVOLUTION: f64 = 16.0;
const GEAR_RATIO: f64 = 270.0;

#[derive(Clone, Debug, Default)]
pub struct Extruder {
    pub on: bool,
    pub backwards: bool,
    pub set_rpm: f64,
    /// What the encoder says.
    pub measured_rpm: f64,
    /// What the shaft does, backwards below 0, and how far it is, in turns.
    pub shaft_rpm: f64,
    pub turns: f64,
    /// How far it has turned backwards, in turns.
    pub backed: f64,
    pulse_left: u64,
    steps: u64,
    counts: f64,
    counted: f64,
    integral: f64,
    last_input: f64,
    output: f64,
}

impl Extruder {
    /// A line of the protocol, by its words alone.
    pub fn line(&mut self, line: &str) {
        match line.split_once(',') {
            Some(("RPM", x)) => self.set_rpm = x.parse().unwrap(),
            Some(("PULSEREV", x)) => self.pulse_left = x.parse().unwrap(),
            None if line == "FORWARDS" => self.backwards = false,
            None if line == "REVERSE" => self.backwards = true,
            None if line == "START" => self.on = true,
            None if line == "STOP" => self.on = false,
            _ => panic!("{line}"),
        }
    }

    pub fn run(&mut self, seconds: f64) {
        for _ in 0..(seconds / STEP).round() as u64 {
            self.step();
        }
    }

    fn step(&mut self) {
        self.steps += 1;
        if self.steps.is_multiple_of(SPEED_EVERY) {
            // Whole pulses since the last time.
            let time = SPEED_EVERY as f64;
            let count = self.counts.floor() - self.counted;
            self.measured_rpm = count * 1000.0 * 60.0 / (COUNTS_PER_REVOLUTION * GEAR_RATIO * time);
            self.counted = self.counts.floor();
        }
        if self.steps.is_multiple_of(PID_EVERY) {
            let [p, i, d] = GAINS;
            let seconds = PID_EVERY as f64 * STEP;
            let error = if self.on { self.set_rpm - self.measured_rpm } else { 0.0 };
            self.integral = (self.integral + i * seconds * error).clamp(0.0, FULL_OUTPUT);
            let change = self.measured_rpm - self.last_input;
            self.last_input = self.measured_rpm;
            self.output = (p * error + self.integral - d / seconds * change).clamp(0.0, FULL_OUTPUT);
        }
        let wanted = if self.pulse_left > 0 {
            self.pulse_left -= 1;
            -FULL_RPM
        } else if self.on {
            FULL_RPM * self.output / FULL_OUTPUT * if self.backwards { -1.0 } else { 1.0 }
        } else {
            0.0
        };
        self.shaft_rpm += (wanted - self.shaft_rpm) * STEP / TIME_CONSTANT;
        let turned = self.shaft_rpm / 60.0 * STEP;
        self.turns += turned;
        self.backed += (-turned).max(0.0);
        self.counts += turned.abs() * COUNTS_PER_REVOLUTION * GEAR_RATIO;
    }
}
