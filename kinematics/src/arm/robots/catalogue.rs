//! All arms, in one table.

use super::entry::CatalogueArm;
use super::{abb, fanuc, kuka, staubli, universal_robots, yaskawa};

const COUNT: usize = universal_robots::ARMS.len()
    + abb::ARMS.len()
    + kuka::ARMS.len()
    + fanuc::ARMS.len()
    + staubli::ARMS.len()
    + yaskawa::ARMS.len();

/// The arms by name, as files of workcells call them: maker by maker.
/// ```
/// use curvlay_kinematics::robots;
/// assert_eq!((robots::CATALOGUE.len(), robots::CATALOGUE[0].model), (34, robots::UR3));
/// ```
pub static CATALOGUE: [CatalogueArm; COUNT] = {
    let makers: [&[CatalogueArm]; 6] =
        [&universal_robots::ARMS, &abb::ARMS, &kuka::ARMS, &fanuc::ARMS, &staubli::ARMS, &yaskawa::ARMS];
    let mut all = [universal_robots::ARMS[0]; COUNT];
    let (mut maker, mut k) = (0, 0);
    while maker < makers.len() {
        let mut arm = 0;
        while arm < makers[maker].len() {
            all[k] = makers[maker][arm];
            (k, arm) = (k + 1, arm + 1);
        }
        maker += 1;
    }
    all
};
