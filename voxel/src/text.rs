//! Grids drawn as text: H. Boge, *Robotic additive manufacturing* (MSc thesis, NTNU 2019), chapter 4.
//!
//! `1` is a cell of the object, `-` one of the platform, `0` an empty one; characters run along x.
//! * Two-dimensional: one block of lines. The first line is the top row, the last line is the platform.
//! * Three-dimensional: blocks with an empty line between them. The first block is the platform, the next ones go
//!   upwards; the lines of a block run along y from 0.
//!
//! The platform is not part of the grid: the row or block next to it has z = 0.

use crate::grid::{GridError, VoxelGrid, set_bits};
use std::io::{self, BufRead, Read, Write};
use std::ops::Range;

/// An object and the platform that it stands on.
#[derive(Clone, Debug, PartialEq)]
pub struct TextGrid {
    /// The cells of the object; one cell deep in y if the object is flat. Cells are 1 mm wide.
    pub grid: VoxelGrid,
    /// The cells `[x, y]` of the platform under it, by rising y, then x.
    pub platform: Vec<[u32; 2]>,
    /// Whether the object is two-dimensional.
    pub flat: bool,
}

/// Why text is not a grid. Lines and columns are counted from 1.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TextGridError {
    /// The text cannot be read.
    #[error("line {line} cannot be read: {source}")]
    Read {
        /// The line.
        line: usize,
        /// What the source of the text says.
        source: io::Error,
    },
    /// There is nothing but empty lines.
    #[error("the text contains no grid")]
    Empty,
    /// Something else than `0`, `1` or `-`.
    #[error("line {line}, column {column}: unexpected character {character:?}: expected `0`, `1` or `-`")]
    Character {
        /// The line.
        line: usize,
        /// The column.
        column: usize,
        /// What stands there.
        character: char,
    },
    /// A line is not as long as the first one.
    #[error("line {line} has {found} cells, the lines above have {expected}")]
    Ragged {
        /// The line.
        line: usize,
        /// Its cells.
        found: usize,
        /// Cells of the first line.
        expected: usize,
    },
    /// A block has not as many lines as the first one.
    #[error("the block that ends in line {line} has {found} lines, the first block has {expected}")]
    BlockSize {
        /// The last line of the block.
        line: usize,
        /// Its lines.
        found: usize,
        /// Lines of the first block.
        expected: usize,
    },
    /// The last row of a flat object, or the first block of another, has no `-`.
    #[error("there is no platform: line {line} should hold a `-`, or another line of its block")]
    NoPlatform {
        /// The (first) line where the platform should be.
        line: usize,
    },
    /// A `-` outside the last row of a flat object, or outside the first block of another.
    #[error("line {line}, column {column}: a `-` outside the platform (blocks need an empty line between them)")]
    StrayPlatform {
        /// The line.
        line: usize,
        /// The column.
        column: usize,
    },
    /// A `1` in the row or block of the platform.
    #[error("line {line}, column {column}: the object reaches into the platform")]
    ObjectInPlatform {
        /// The line.
        line: usize,
        /// The column.
        column: usize,
    },
    /// There is a platform, but no `1`.
    #[error("there is no object: no `1` beside the platform")]
    NoObject,
    /// More cells along an axis than a grid may have, or more in all.
    #[error("line {line}: the grid is larger than {} cells along an axis, or than fits", VoxelGrid::MAX_SIDE)]
    TooLarge {
        /// The line where reading stopped.
        line: usize,
    },
}

/// Why a grid cannot be written as text.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteTextGridError {
    /// The text cannot be written.
    #[error("the text cannot be written: {0}")]
    Write(#[from] io::Error),
    /// A flat object that is more than one cell deep.
    #[error("a flat object must be one cell deep in y, this one is {ny} deep")]
    NotFlat {
        /// Cells along y.
        ny: u32,
    },
    /// The platform has no cell.
    #[error("the platform has no cell")]
    NoPlatform,
    /// The platform has a cell outside the grid.
    #[error("the cell {cell:?} of the platform lies outside a grid of {nx} x {ny} cells")]
    PlatformOutside {
        /// The cell, `[x, y]`.
        cell: [u32; 2],
        /// Cells of the grid along x.
        nx: u32,
        /// Cells of the grid along y.
        ny: u32,
    },
    /// The object has no cell.
    #[error("the object has no cell")]
    NoObject,
}

/// Reads a grid.
///
/// Lines may end in blanks, and any number of empty lines may stand between blocks, before and after.
///
/// # Errors
/// [`TextGridError`] names line and column.
///
/// # Cost
/// `O(n)` time for `n` characters, and some bits of memory for each; a line longer than a grid may be is not read to
/// its end.
///
/// # Example
/// ```
/// let drawn = curvlay_voxel::read_text_grid("110\n010\n---\n".as_bytes())?;
/// assert_eq!(drawn.grid.dims(), [3, 1, 2]);
/// assert!(drawn.grid.contains([1, 0, 0]) && !drawn.grid.contains([0, 0, 0]));
/// assert_eq!((drawn.flat, drawn.platform), (true, vec![[0, 0], [1, 0], [2, 0]]));
/// # Ok::<(), curvlay_voxel::TextGridError>(())
/// ```
pub fn read_text_grid(text: impl BufRead) -> Result<TextGrid, TextGridError> {
    Drawing::read(text)?.finish()
}

/// The characters as they stand, line after line without the empty ones.
struct Drawing {
    width: usize,
    /// Bits of the `1` and of the `-`, each line padded to whole words.
    object: Vec<u64>,
    platform: Vec<u64>,
    /// Number in the text, from 1, of each line that is not empty.
    numbers: Vec<usize>,
    /// Where each block ends in `numbers`.
    ends: Vec<usize>,
}

impl Drawing {
    fn read(mut text: impl BufRead) -> Result<Self, TextGridError> {
        let mut drawing =
            Drawing { width: 0, object: Vec::new(), platform: Vec::new(), numbers: Vec::new(), ends: Vec::new() };
        let mut bytes = Vec::new();
        for line in 1.. {
            bytes.clear();
            // Room for blanks at the end; longer lines are too long whatever they hold.
            let limit = 2 * u64::from(VoxelGrid::MAX_SIDE);
            let read = text.by_ref().take(limit).read_until(b'\n', &mut bytes);
            let length = read.map_err(|source| TextGridError::Read { line, source })?;
            let cells = bytes.trim_ascii_end();
            if length as u64 == limit || cells.len() > VoxelGrid::MAX_SIDE as usize {
                return Err(TextGridError::TooLarge { line });
            }
            if cells.is_empty() {
                drawing.end_block()?;
            } else {
                drawing.push(line, cells)?;
            }
            if length == 0 {
                break;
            }
        }
        if drawing.ends.is_empty() { Err(TextGridError::Empty) } else { Ok(drawing) }
    }

    fn words(&self) -> usize {
        self.width.div_ceil(64)
    }

    fn push(&mut self, line: usize, cells: &[u8]) -> Result<(), TextGridError> {
        if self.numbers.is_empty() {
            self.width = cells.len();
        }
        let first = self.object.len();
        // The platform's row or block comes on top of the grid.
        let block_start = self.ends.last().copied().unwrap_or(0);
        let most = VoxelGrid::MAX_SIDE as usize + 1;
        if self.numbers.len() - block_start >= most
            || self.ends.len() >= most
            || first as u64 >= VoxelGrid::MAX_BYTES / 8
        {
            return Err(TextGridError::TooLarge { line });
        }
        self.object.resize(first + self.words(), 0);
        self.platform.resize(first + self.words(), 0);
        for (x, &cell) in cells.iter().enumerate() {
            let bits = match cell {
                b'0' => continue,
                b'1' => &mut self.object,
                b'-' => &mut self.platform,
                _ => {
                    let character = String::from_utf8_lossy(&cells[x..]).chars().next().unwrap_or_default();
                    return Err(TextGridError::Character { line, column: x + 1, character });
                }
            };
            if let Some(word) = bits.get_mut(first + x / 64) {
                *word |= 1 << (x % 64);
            }
        }
        if cells.len() != self.width {
            return Err(TextGridError::Ragged { line, found: cells.len(), expected: self.width });
        }
        self.numbers.push(line);
        Ok(())
    }

    fn end_block(&mut self) -> Result<(), TextGridError> {
        let start = self.ends.last().copied().unwrap_or(0);
        let found = self.numbers.len() - start;
        if found == 0 {
            return Ok(());
        }
        match self.ends.first() {
            Some(&expected) if found != expected => {
                Err(TextGridError::BlockSize { line: self.numbers[self.numbers.len() - 1], found, expected })
            }
            _ => {
                self.ends.push(self.numbers.len());
                Ok(())
            }
        }
    }

    /// Line and column, from 0, of the bits that are set in some of the lines.
    fn set_in<'a>(&self, bits: &'a [u64], lines: Range<usize>) -> impl Iterator<Item = [usize; 2]> + use<'a> {
        let words = self.words();
        let chosen = bits[lines.start * words..lines.end * words].iter().enumerate();
        chosen.flat_map(move |(at, &word)| {
            set_bits(word).map(move |bit| [lines.start + at / words, at % words * 64 + bit as usize])
        })
    }

    /// Separates platform and object.
    fn finish(self) -> Result<TextGrid, TextGridError> {
        let (flat, words, lines) = (self.ends.len() == 1, self.words(), self.numbers.len());
        let (on_platform, on_object, ny) = match self.ends[0] {
            _ if flat => (lines - 1..lines, 0..lines - 1, 1),
            block => (0..block, block..lines, block),
        };
        if let Some([at, x]) = self.set_in(&self.platform, on_object.clone()).next() {
            return Err(TextGridError::StrayPlatform { line: self.numbers[at], column: x + 1 });
        }
        if let Some([at, x]) = self.set_in(&self.object, on_platform.clone()).next() {
            return Err(TextGridError::ObjectInPlatform { line: self.numbers[at], column: x + 1 });
        }
        let first = on_platform.start;
        let platform: Vec<[u32; 2]> =
            self.set_in(&self.platform, on_platform).map(|[at, x]| [x as u32, (at - first) as u32]).collect();
        if platform.is_empty() {
            return Err(TextGridError::NoPlatform { line: self.numbers[first] });
        }
        if self.set_in(&self.object, on_object.clone()).next().is_none() {
            return Err(TextGridError::NoObject);
        }
        let dims = [self.width, ny, on_object.len() / ny].map(|side| side as u32);
        let drawn = &self.object[on_object.start * words..on_object.end * words];
        let rows = if flat { drawn.chunks(words).rev().flatten().copied().collect() } else { drawn.to_vec() };
        let too_large = |_| TextGridError::TooLarge { line: self.numbers[lines - 1] };
        Ok(TextGrid { grid: VoxelGrid::from_rows(dims, rows).map_err(too_large)?, platform, flat })
    }
}

/// Writes a grid; [`read_text_grid`] gives it back (with cells of 1 mm, and the platform sorted).
///
/// # Errors
/// [`WriteTextGridError`]; but for a failing `out`, nothing is written then.
///
/// # Cost
/// `O(n)` for `n` cells.
///
/// # Example
/// ```
/// use curvlay_voxel::{TextGrid, VoxelGrid, write_text_grid};
/// let grid = VoxelGrid::from_cells([3, 1, 2], [[1, 0, 0], [1, 0, 1], [2, 0, 1]])?;
/// let mut text = Vec::new();
/// write_text_grid(&TextGrid { grid, platform: vec![[1, 0]], flat: true }, &mut text)?;
/// assert_eq!(text, b"011\n010\n0-0\n");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_text_grid(drawn: &TextGrid, mut out: impl Write) -> Result<(), WriteTextGridError> {
    let [nx, ny, nz] = drawn.grid.dims();
    if drawn.flat && ny != 1 {
        return Err(WriteTextGridError::NotFlat { ny });
    }
    if drawn.grid.is_empty() {
        return Err(WriteTextGridError::NoObject);
    }
    let cells = drawn.platform.iter().map(|&[x, y]| [x, y, 0]);
    let platform = VoxelGrid::from_cells([nx, ny, 1], cells).map_err(|error| match error {
        GridError::Outside { cell: [x, y, _], .. } => WriteTextGridError::PlatformOutside { cell: [x, y], nx, ny },
        _ => WriteTextGridError::NoPlatform,
    })?;
    if platform.is_empty() {
        return Err(WriteTextGridError::NoPlatform);
    }
    let mut line = Vec::with_capacity(nx as usize + 1);
    let mut write_row = |of: &VoxelGrid, mark: u8, y: u32, z: u32, out: &mut dyn Write| {
        line.clear();
        line.extend((0..nx).map(|x| if of.contains([x, y, z]) { mark } else { b'0' }));
        line.push(b'\n');
        out.write_all(&line)
    };
    if drawn.flat {
        (0..nz).rev().try_for_each(|z| write_row(&drawn.grid, b'1', 0, z, &mut out))?;
        write_row(&platform, b'-', 0, 0, &mut out)?;
        return Ok(());
    }
    (0..ny).try_for_each(|y| write_row(&platform, b'-', y, 0, &mut out))?;
    for z in 0..nz {
        out.write_all(b"\n")?;
        (0..ny).try_for_each(|y| write_row(&drawn.grid, b'1', y, z, &mut out))?;
    }
    Ok(())
}
