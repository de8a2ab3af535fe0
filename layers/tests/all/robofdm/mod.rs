//! RoboFDM: skeletons, mixtures, cuts, segments and sequences.

mod heads;
mod parts;
mod pedestals;
mod segments;
mod sequences;
mod shapes;
mod skeletons;
