//! Every public function takes any input: not finite, far out, none, mismatched. `fed.txt` lists what these tests feed; the tests of `examples` compare it with
//! the sources.

mod found;
mod indicators;
mod motions;
mod numbers;
mod planners;
mod prints;
mod robots;
