//! Plane layers of solids: sections, parts, overhang, decomposition.
// Numbers that are exact: whole ones, and what is written in one place and read in another.
#![allow(clippy::float_cmp)]

mod cells;
mod flat;
mod lettori;
mod overhang;
mod region;
mod section;
mod shapes;
