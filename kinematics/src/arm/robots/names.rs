//! Names of arms: found whatever their case and punctuation, and the nearest ones where a name is unknown.

use super::catalogue::CATALOGUE;
use super::entry::CatalogueArm;

/// Names are near up to a third of their letters, and so many at least.
const MIN_EDITS: usize = 2;

/// More near names than these help nobody.
const MAX_NEAR: usize = 4;

/// No robot has a longer name; what is longer is not compared.
const MAX_NAME: usize = 40;

/// The arm of this name, or of one of its other names. Case, spaces and punctuation do not count.
/// ```
/// use curvlay_kinematics::robots;
/// assert_eq!(robots::find("ur10e").map(|arm| arm.name), Some("UR10e"));
/// assert_eq!(robots::find("IRB 1200-5/0.9").map(|arm| arm.name), Some("IRB1200_5_90"));
/// assert_eq!(robots::find("UR11"), None);
/// ```
pub fn find(name: &str) -> Option<&'static CatalogueArm> {
    let wanted = letters(name);
    let same = |known: &str| letters(known) == wanted;
    CATALOGUE.iter().find(|arm| same(arm.name) || arm.aliases.iter().any(|alias| same(alias)))
}

/// Names of arms that are written almost like this one, the nearest first: by edit distance (V. Levenshtein, 1966), at most four.
/// ```
/// use curvlay_kinematics::robots;
/// assert_eq!(robots::near("UR10f")[..2], ["UR10", "UR10e"]);
/// assert!(robots::near("a kitchen mixer").is_empty());
/// ```
pub fn near(name: &str) -> Vec<&'static str> {
    let wanted = letters(name);
    if wanted.len() > MAX_NAME {
        return vec![];
    }
    let max = MIN_EDITS.max(wanted.len() / 3).min(wanted.len().saturating_sub(1));
    let mut near: Vec<(usize, &str)> = CATALOGUE
        .iter()
        .filter_map(|arm| {
            let names = arm.aliases.iter().chain([&arm.name]);
            let least = names.map(|known| edits(&letters(known), &wanted)).min()?;
            (least <= max).then_some((least, arm.name))
        })
        .collect();
    // Stable: equally near ones in the order of the catalogue.
    near.sort_by_key(|(edits, _)| *edits);
    near.into_iter().take(MAX_NEAR).map(|(_, name)| name).collect()
}

/// What of a name counts.
fn letters(name: &str) -> Vec<char> {
    name.chars().filter(|letter| letter.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// The least number of letters that are to be put in, left out or replaced.
fn edits(a: &[char], b: &[char]) -> usize {
    // `row[j]` is the distance of what of `a` is read from the first `j` letters of `b`.
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut before = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replaced = before + usize::from(x != y);
            before = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(before + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By the definition.
    fn slow_edits(a: &[char], b: &[char]) -> usize {
        match (a, b) {
            ([], rest) | (rest, []) => rest.len(),
            ([x, a_rest @ ..], [y, b_rest @ ..]) => (slow_edits(a_rest, b_rest) + usize::from(x != y))
                .min(slow_edits(a_rest, b) + 1)
                .min(slow_edits(a, b_rest) + 1),
        }
    }

    #[test]
    fn distances_are_those_of_the_definition() {
        let words: Vec<Vec<char>> =
            ["", "a", "ur3", "ur3e", "ru3", "irb12", "rib2", "gp7", "kr6"].map(letters).to_vec();
        for a in &words {
            for b in &words {
                assert_eq!(edits(a, b), slow_edits(a, b), "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn every_name_finds_its_own_arm_alone() {
        let mut seen = std::collections::BTreeSet::new();
        for arm in &CATALOGUE {
            let own: std::collections::BTreeSet<Vec<char>> =
                arm.aliases.iter().chain([&arm.name, &arm.title]).map(|name| letters(name)).collect();
            for name in own {
                assert!(seen.insert(name.clone()), "{name:?}");
            }
            for name in arm.aliases.iter().chain([&arm.name]) {
                assert_eq!(find(name).map(|found| found.name), Some(arm.name));
            }
        }
    }
}
