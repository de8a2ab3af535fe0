//! Filament along a path, by the planned time: it goes with the motion, however slow that is.

use crate::machine::MachineRun;
use curvlay_toolpath::surface::MoveKind;

/// How a path is laid at the planned feed.
pub struct Flow {
    /// Seconds since the path began and millimetres of filament, at each waypoint.
    times: Vec<f64>,
    filament: Vec<f64>,
}

impl Flow {
    /// For each path, as the plan of the deposition has it.
    pub fn of_paths(machine: &MachineRun) -> Vec<Flow> {
        let mut flows: Vec<Flow> =
            machine.freed.paths.iter().map(|_| Flow { times: vec![0.0], filament: vec![0.0] }).collect();
        for step in machine.deposition.moves.iter().filter(|step| step.kind == MoveKind::Print) {
            let Flow { times, filament } = &mut flows[step.path];
            times.push(times[times.len() - 1] + step.seconds);
            filament.push(filament[filament.len() - 1] + step.filament);
        }
        flows
    }

    /// When each waypoint is passed.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Filament that is laid by a planned time.
    pub fn filament(&self, time: f64) -> f64 {
        let after = self.times.partition_point(|known| *known <= time).clamp(1, self.times.len() - 1);
        let [a, b] = [self.times[after - 1], self.times[after]];
        let share = if b > a { ((time - a) / (b - a)).clamp(0.0, 1.0) } else { 1.0 };
        self.filament[after - 1] + (self.filament[after] - self.filament[after - 1]) * share
    }
}
