//! Plane layers of solids: sections, parts, overhang, decomposition.

mod cells;
mod overhang;
mod region;
mod section;
mod shapes;
