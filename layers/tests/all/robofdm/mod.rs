//! RoboFDM: skeletons, mixtures, cuts, segments and sequences.

mod cuts;
mod heads;
mod mixtures;
mod parts;
mod pedestals;
mod segments;
mod sequences;
mod shapes;
mod skeletons;
