//! Every public function takes any input: not finite, far out, none, mismatched. `fed.txt` lists what these tests feed; the tests of `examples` compare it with
//! the sources.
#![cfg(all(feature = "serde", feature = "urdf"))] // the cells and machines are read from the files of the examples

mod arms;
mod calibrations;
mod cells;
mod found;
mod machines;
mod numbers;
mod placements;
mod platforms;
mod prints;
mod programs;
mod readers;
mod scenes;
mod setups;
mod streams;
