//! Exact squared distances of lattice nodes from marked ones, axis by axis.

/// Larger than any square of a distance, and twice it still fits.
pub(super) const FAR: i32 = 1 << 29;

/// Of each node 0 where it is a corner of a solid cell, and where it is one of an empty cell; else `FAR`.
pub(super) fn mark(dims: [u32; 3], rows: &[u64], margin: usize, size: &[usize; 3]) -> (Vec<i32>, Vec<i32>) {
    let [nx, ny, nz] = dims.map(|n| n as usize);
    let words = nx.div_ceil(64);
    let [sx, sy, sz] = *size;
    let is_solid = |x: usize, y: usize, z: usize| rows[words * (y + ny * z) + x / 64] >> (x % 64) & 1 == 1;
    let mut solid = vec![FAR; sx * sy * sz];
    let mut empty = vec![FAR; sx * sy * sz];
    for (z, y) in (0..sz).flat_map(|z| (0..sy).map(move |y| (z, y))) {
        for x in 0..sx {
            let node = x + sx * (y + sy * z);
            let within = |at: usize, n: usize| (margin..=margin + n).contains(&at);
            if !(within(x, nx) && within(y, ny) && within(z, nz)) {
                empty[node] = 0;
                continue;
            }
            // The up to eight cells around it; beyond the grid they are empty.
            let mut filled = 0;
            for around in 0..8 {
                let cell = |at: usize, bit: usize, n: usize| (at + bit).checked_sub(margin + 1).filter(|&k| k < n);
                let [x, y, z] = [cell(x, around & 1, nx), cell(y, around >> 1 & 1, ny), cell(z, around >> 2, nz)];
                if let (Some(x), Some(y), Some(z)) = (x, y, z) {
                    filled += usize::from(is_solid(x, y, z));
                }
            }
            if filled > 0 {
                solid[node] = 0;
            }
            if filled < 8 {
                empty[node] = 0;
            }
        }
    }
    (solid, empty)
}

/// From marks to squared distances of the nearest mark, in steps, at the places that each axis has: the nodes' own, or
/// some within and beyond them.
pub(super) fn transform(marks: &[i32], size: &[usize; 3], places: [&[i32]; 3]) -> Vec<i32> {
    let [sx, sy, sz] = *size;
    let [px, py, _] = places.map(<[i32]>::len);
    let x = along(marks, (1, sx, sy * sz), places[0]);
    let y = along(&x, (px, sy, sz), places[1]);
    along(&y, (px * py, sz, 1), places[2])
}

/// The transform along one axis: `inner` values run faster than it, `outer` slower.
fn along(field: &[i32], (inner, count, outer): (usize, usize, usize), places: &[i32]) -> Vec<i32> {
    let mut result = vec![0; inner * places.len() * outer];
    let (mut line, mut hulls) = (vec![0; count], vec![(0i32, 0i32); count]);
    for (slow, fast) in (0..outer).flat_map(|slow| (0..inner).map(move |fast| (slow, fast))) {
        for (k, value) in line.iter_mut().enumerate() {
            *value = field[fast + inner * (k + count * slow)];
        }
        envelope(&line, &mut hulls, places, |k, value| result[fast + inner * (k + places.len() * slow)] = value);
    }
    result
}

/// `min over i of (p - i)^2 + line[i]` for each place `p`, which ascend: the lower envelope of parabolas, which take
/// over from each other at whole numbers.
fn envelope(line: &[i32], hulls: &mut [(i32, i32)], places: &[i32], mut put: impl FnMut(usize, i32)) {
    let (Some(&low), Some(&high)) = (places.first(), places.last()) else { return };
    // The parabola of `i` lies lowest from `start` on.
    let mut last = 0;
    hulls[0] = (0, low);
    let value = |i: i32, at: i32| (at - i) * (at - i) + line[i as usize];
    for i in 1..line.len() as i32 {
        loop {
            let (before, start) = hulls[last];
            if value(before, start) > value(i, start) {
                if last == 0 {
                    hulls[0] = (i, low);
                    break;
                }
                last -= 1;
                continue;
            }
            // The first whole number at which i is lower.
            let from =
                (i * i - before * before + line[i as usize] - line[before as usize]).div_euclid(2 * (i - before)) + 1;
            if from <= high {
                last += 1;
                hulls[last] = (i, from);
            }
            break;
        }
    }
    for (k, &place) in places.iter().enumerate().rev() {
        while last > 0 && place < hulls[last].1 {
            last -= 1;
        }
        put(k, value(hulls[last].0, place).min(FAR));
    }
}
