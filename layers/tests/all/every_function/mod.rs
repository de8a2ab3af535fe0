//! Every public function takes any input: not finite, far out, none, mismatched. `fed.txt` lists what these tests feed; the tests of `examples` compare it with
//! the sources.

mod elastic;
mod found;
mod growth;
mod numbers;
mod planar;
mod surfaces;
