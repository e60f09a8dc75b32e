//! The order of places along a Hilbert curve.

/// Most bits of each coordinate, so that an index fits into 64 bits.
pub(super) const MOST_BITS: u32 = 21;

/// The number of a cube along the Hilbert curve through a grid of cubes with `bits` bits of each coordinate.
///
/// Cubes that follow one another share a face. The eight cubes into which a cube is divided follow one another in place of it, so the index of a cube
/// is that of each of them without its last three bits. Source: J. Skilling, "Programming the Hilbert curve", AIP Conference Proceedings 707 (2004) 381:
/// the transpose form, from the highest bit to the lowest.
pub(super) fn index(mut at: [u32; 3], bits: u32) -> u64 {
    // Undoes the reflections and exchanges of axes of the cubes in which the place lies.
    for bit in (1..bits).rev() {
        let lower = (1 << bit) - 1;
        for axis in 0..3 {
            if at[axis] >> bit & 1 == 1 {
                at[0] ^= lower;
            } else {
                let differ = (at[0] ^ at[axis]) & lower;
                at[0] ^= differ;
                at[axis] ^= differ;
            }
        }
    }
    // From the Gray code of the octants to their number.
    at[1] ^= at[0];
    at[2] ^= at[1];
    let mut turned = 0;
    for bit in (1..bits).rev() {
        if at[2] >> bit & 1 == 1 {
            turned ^= (1 << bit) - 1;
        }
    }
    let mut number = 0;
    for bit in (0..bits).rev() {
        for coordinate in at {
            number = number << 1 | u64::from((coordinate ^ turned) >> bit & 1);
        }
    }
    number
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cubes(bits: u32) -> impl Iterator<Item = [u32; 3]> {
        let edge = 1 << bits;
        (0..edge * edge * edge).map(move |k: u32| [k % edge, k / edge % edge, k / edge / edge])
    }

    #[test]
    fn the_curve_visits_all_cubes_and_each_shares_a_face_with_the_next() {
        for bits in 1..=5 {
            let mut along: Vec<([u32; 3], u64)> =
                cubes(bits).map(|at| (at, index(at, bits))).collect();
            along.sort_by_key(|&(_, number)| number);
            assert!((0..).zip(&along).all(|(k, &(_, number))| number == k));
            for two in along.windows(2) {
                let apart: u32 = (0..3)
                    .map(|axis| two[0].0[axis].abs_diff(two[1].0[axis]))
                    .sum();
                assert_eq!(apart, 1);
            }
        }
    }

    #[test]
    fn finer_cubes_keep_the_order_of_coarser_ones() {
        for bits in 2..=5 {
            for at in cubes(bits) {
                assert_eq!(index(at, bits) >> 3, index(at.map(|x| x >> 1), bits - 1));
            }
        }
        let far = [(1 << MOST_BITS) - 1; 3];
        assert!(index(far, MOST_BITS) < 1 << (3 * MOST_BITS));
    }
}
