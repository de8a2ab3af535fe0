//! Every public function takes any input: not finite, far out, none, mismatched. `fed.txt` lists what these tests feed; the tests of `examples` compare it with
//! the sources.

mod drawings;
mod fibers;
mod found;
mod gcodes;
mod numbers;
mod stacks;
mod surfaces;
