//! Codes of periodic images.
//!
//! The code of the cell itself or of one of its 26 neighbours is 9 (z+1) + 3 (y+1) + (x+1), with -1, 0 or +1 periods along x, y, z.
//! Images that are farther away have codes as well: walls may be met by them.

use glam::DVec3;

/// Code of the original among the codes of its images.
pub const NO_SHIFT: u32 = 13;

/// Codes below this are those of the cell and its 26 neighbours.
pub const NEIGHBOURS: u32 = 27;

/// Periods along each axis up to which images have codes.
pub const MOST_PERIODS: i32 = 511;

/// Set in the codes of images that are no neighbours: the periods along x, y, z stand below it, with [`DIGIT`] bits each.
const FAR: u32 = 1 << 30;
const DIGIT: u32 = 10;

/// The code of the image that is this many periods away along each axis; only as far as there are codes.
#[must_use]
pub fn code(periods: [i32; 3]) -> u32 {
    let most = MOST_PERIODS;
    let [x, y, z] = periods.map(|periods| periods.clamp(-most, most));
    if [x, y, z].iter().all(|periods| periods.abs() <= 1) {
        (9 * (z + 1) + 3 * (y + 1) + x + 1) as u32
    } else {
        let digit = |periods: i32, place: u32| ((periods + most) as u32) << place;
        FAR | digit(x, 0) | digit(y, DIGIT) | digit(z, 2 * DIGIT)
    }
}

/// The code of the image that is `further` whole periods along `axis` from that with `code`; as far as there are codes.
#[must_use]
pub fn moved(from: u32, axis: usize, further: f64) -> u32 {
    if further == 0.0 {
        return from;
    }
    let mut periods = periods(from);
    periods[axis] += further;
    code(periods.to_array().map(|periods| periods as i32))
}

/// The code of the image on the opposite side; of neighbours only.
#[must_use]
pub fn opposite(code: u32) -> u32 {
    26 - code
}

/// The whole periods along each axis that a code contains.
pub(super) fn periods(code: u32) -> DVec3 {
    if code & FAR != 0 {
        let digit = |place: u32| f64::from(code >> place & ((1 << DIGIT) - 1));
        let far = DVec3::new(digit(0), digit(DIGIT), digit(2 * DIGIT));
        return far - f64::from(MOST_PERIODS);
    }
    let digit = |place: u32| f64::from(code / place % 3) - 1.0;
    DVec3::new(digit(1), digit(3), digit(9))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_and_periods_agree() {
        assert_eq!(code([0; 3]), NO_SHIFT);
        for code in 0..NEIGHBOURS {
            assert_eq!(periods(opposite(code)), -periods(code));
        }
        assert_eq!(moved(NO_SHIFT, 2, 1.0), 22);
        assert_eq!(moved(22, 0, -1.0), 21);
        assert_eq!(moved(22, 2, -2.0), 4);
        assert_eq!(moved(22, 0, 0.0), 22);
        for steps in [[0, 0, 2], [-7, 1, 511], [-511, 511, -300], [1, -1, 0]] {
            let [x, y, z] = steps.map(f64::from);
            assert_eq!(periods(code(steps)), DVec3::new(x, y, z));
            let moved_along_all = moved(moved(moved(NO_SHIFT, 0, x), 1, y), 2, z);
            assert_eq!(moved_along_all, code(steps), "{steps:?}");
        }
        for expected in 0..NEIGHBOURS {
            let steps = periods(expected).to_array().map(|step| step as i32);
            assert_eq!(code(steps), expected);
        }
        let farthest = [code([0, 9999, 0]), code([0, 511, 0])];
        assert_eq!(farthest[0], farthest[1], "there is no farther image");
    }
}
