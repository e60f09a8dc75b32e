//! Periodic images as integer shifts.

use glam::DVec3;

/// The code of "no shift" among the 27 shifts of -1, 0, +1 periods along x, y, z.
pub const NO_SHIFT: u32 = 13;

/// The periodic axes of a domain and the 27 image shifts, by code 9 (z+1) + 3 (y+1) + (x+1).
#[derive(Debug, Clone, PartialEq)]
pub struct Images {
    /// Lower corner of the domain, m.
    pub min: DVec3,
    /// Edge lengths of the domain, m.
    pub size: DVec3,
    /// Which axes are periodic.
    pub periodic: [bool; 3],
    shifts: [DVec3; 27],
}

impl Images {
    /// Of a domain with the given corners (m).
    #[must_use]
    pub fn new(min: DVec3, max: DVec3, periodic: [bool; 3]) -> Self {
        let size = max - min;
        let mut shifts = [DVec3::ZERO; 27];
        for (code, shift) in shifts.iter_mut().enumerate() {
            *shift = steps(code as u32) * size;
        }
        Self {
            min,
            size,
            periodic,
            shifts,
        }
    }

    /// Whether any axis is periodic.
    #[must_use]
    pub fn any(&self) -> bool {
        self.periodic.contains(&true)
    }

    /// Displacement of the image with this code, m.
    #[inline(always)]
    #[must_use]
    pub fn shift(&self, code: u32) -> DVec3 {
        self.shifts[code as usize]
    }

    /// The same of images that may be farther than neighbours.
    #[inline]
    #[must_use]
    pub fn any_shift(&self, code: u32) -> DVec3 {
        match self.shifts.get(code as usize) {
            Some(&shift) => shift,
            None => steps(code) * self.size,
        }
    }

    /// Codes below this are those of the domain and its 26 neighbours.
    pub const NEIGHBOURS: u32 = 27;

    /// Periods along each axis up to which images have codes.
    pub const MOST_PERIODS: i32 = 511;

    /// The code of the image that is this many periods away along each axis; only as far as there are codes.
    #[must_use]
    pub fn code(periods: [i32; 3]) -> u32 {
        let most = Self::MOST_PERIODS;
        let [x, y, z] = periods.map(|periods| periods.clamp(-most, most));
        if [x, y, z].iter().all(|periods| periods.abs() <= 1) {
            (9 * (z + 1) + 3 * (y + 1) + x + 1) as u32
        } else {
            let digit = |periods: i32, place: u32| ((periods + most) as u32) << place;
            FAR | digit(x, 0) | digit(y, DIGIT) | digit(z, 2 * DIGIT)
        }
    }

    /// The code of the image that is `periods` whole periods along `axis` from that with `code`; as far as there are codes.
    #[must_use]
    pub fn moved(code: u32, axis: usize, periods: f64) -> u32 {
        if periods == 0.0 {
            return code;
        }
        let mut steps = steps(code);
        steps[axis] += periods;
        Self::code(steps.to_array().map(|periods| periods as i32))
    }

    /// The codes of all images other than the original that the periodic axes allow.
    pub fn neighbours(&self) -> impl Iterator<Item = u32> + '_ {
        (0..27).filter(|&code| {
            let steps = steps(code);
            code != NO_SHIFT && (0..3).all(|axis| steps[axis] == 0.0 || self.periodic[axis])
        })
    }

    /// The shortest way (m) between the same two places, by any of their images.
    #[must_use]
    pub fn nearest(&self, mut way: DVec3) -> DVec3 {
        for axis in 0..3 {
            if self.periodic[axis] {
                way[axis] -= (way[axis] / self.size[axis]).round() * self.size[axis];
            }
        }
        way
    }

    /// The position inside the domain that is the same place, m.
    #[must_use]
    pub fn wrap(&self, position: DVec3) -> DVec3 {
        let mut wrapped = position;
        for axis in 0..3 {
            if self.periodic[axis] {
                let (min, size) = (self.min[axis], self.size[axis]);
                let mut x = position[axis];
                if x < min || x >= min + size {
                    x -= ((x - min) / size).floor() * size;
                    // Round-off may leave a position slightly above the upper face, which is the lower one.
                    if x >= min + size || x < min {
                        x = min;
                    }
                }
                wrapped[axis] = x;
            }
        }
        wrapped
    }
}

/// The code of the opposite shift.
#[must_use]
pub fn opposite(code: u32) -> u32 {
    26 - code
}

/// Set in the codes of images that are no neighbours: the periods along x, y, z stand below it, with [`DIGIT`] bits each.
const FAR: u32 = 1 << 30;
const DIGIT: u32 = 10;

/// The whole periods along each axis that a code contains.
fn steps(code: u32) -> DVec3 {
    if code & FAR != 0 {
        let digit = |place: u32| f64::from(code >> place & ((1 << DIGIT) - 1));
        let far = DVec3::new(digit(0), digit(DIGIT), digit(2 * DIGIT));
        return far - f64::from(Images::MOST_PERIODS);
    }
    let digit = |place: u32| f64::from(code / place % 3) - 1.0;
    DVec3::new(digit(1), digit(3), digit(9))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_shifts_and_opposites_agree() {
        let images = Images::new(DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0), [true, false, true]);
        assert_eq!(images.shift(NO_SHIFT), DVec3::ZERO);
        for code in 0..27 {
            assert_eq!(
                images.shift(opposite(code)),
                -images.shift(code),
                "the opposite shift"
            );
        }
        assert_eq!(Images::moved(NO_SHIFT, 2, 1.0), 22);
        assert_eq!(Images::moved(22, 0, -1.0), 21);
        assert_eq!(Images::moved(22, 2, -2.0), 4);
        assert_eq!(Images::moved(22, 0, 0.0), 22);
        for periods in [[0, 0, 2], [-7, 1, 511], [-511, 511, -300], [1, -1, 0]] {
            let code = Images::code(periods);
            let shift = DVec3::from(periods.map(f64::from)) * images.size;
            assert_eq!(images.any_shift(code), shift, "{periods:?}");
            let [x, y, z] = periods.map(f64::from);
            let moved = Images::moved(Images::moved(NO_SHIFT, 0, x), 1, y);
            assert_eq!(Images::moved(moved, 2, z), code, "{periods:?}");
        }
        for code in 0..27 {
            let steps = steps(code).to_array().map(|step| step as i32);
            assert_eq!(Images::code(steps), code);
        }
        let farthest = Images::code([0, 9999, 0]);
        assert_eq!(
            farthest,
            Images::code([0, 511, 0]),
            "there is no farther image"
        );
        assert_eq!(images.neighbours().count(), 8);
        assert!(images.neighbours().all(|code| images.shift(code).y == 0.0));
    }

    #[test]
    fn wrapping_lands_inside_and_changes_whole_periods_only() {
        let images = Images::new(DVec3::splat(-1.0), DVec3::splat(2.0), [true; 3]);
        for x in [
            -1.0,
            2.0,
            -1.0 - 1e-17,
            2.0 - 1e-16,
            5.5,
            -7.25,
            -1.0 - 1e-300,
        ] {
            let wrapped = images.wrap(DVec3::new(x, 0.0, 0.0)).x;
            assert!((-1.0..2.0).contains(&wrapped), "{x} -> {wrapped}");
            let periods = (x - wrapped) / 3.0;
            assert!((periods - periods.round()).abs() < 1e-15);
        }
    }
}
