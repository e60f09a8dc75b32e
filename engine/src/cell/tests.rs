//! The cell agrees with brute force over images.

use mercury_common::random::Stream;
use proptest::prelude::*;

use super::*;
use crate::state::whole;

/// A cell, and coordinates at random, on its faces, next to them, in its middle, and up to a million periods outside.
fn cell_and_places() -> impl Strategy<Value = (Cell, DVec3, DVec3)> {
    let corner = prop::array::uniform3(-2.0..2.0f64);
    let size = prop::array::uniform3(0.1..3.0f64);
    (corner, size, any::<[bool; 3]>(), any::<u64>()).prop_map(|(low, size, periodic, seed)| {
        let low = DVec3::from(low);
        let cell = Cell::new(low, low + DVec3::from(size), periodic);
        let mut stream = Stream::new(seed, "places in a cell", 0);
        let mut place = || {
            let mut place = DVec3::ZERO;
            for axis in 0..3 {
                let (low, size) = (cell.low()[axis], cell.size()[axis]);
                let (_, high) = cell.faces();
                let far = stream.uniform_in(-1e6, 1e6);
                place[axis] = match stream.uniform_in(0.0, 8.0) as u32 {
                    0 => low,
                    1 => high[axis],
                    2 => high[axis].next_down(),
                    3 => low.next_down(),
                    4 => low + 0.5 * size,
                    5 => low + far.round() * size,
                    6 => low + far * size,
                    _ => stream.uniform_in(low, high[axis]),
                };
            }
            place
        };
        let places = (place(), place());
        (cell, places.0, places.1)
    })
}

/// Bound of the rounding errors of a few operations on numbers as large as these places, m.
fn round_off(cell: &Cell, places: &[DVec3]) -> f64 {
    let largest = |place: &DVec3| place.abs().max_element();
    let most = places.iter().map(largest).fold(0.0, f64::max);
    16.0 * f64::EPSILON * (most + cell.low().abs().max_element() + cell.size().max_element())
}

proptest! {
    #[test]
    fn wrapping_changes_whole_periods_only((cell, place, _) in cell_and_places()) {
        let wrapped = cell.wrap(place);
        let (low, high) = cell.faces();
        let fraction = cell.fractional(wrapped);
        for axis in 0..3 {
            if cell.is_periodic(axis) {
                prop_assert!(low[axis] <= wrapped[axis] && wrapped[axis] < high[axis], "{wrapped}");
                prop_assert!((0.0..=1.0).contains(&fraction[axis]), "{fraction}");
                let way = place[axis] - wrapped[axis];
                let rest = way - cell.whole_periods(axis, way) * cell.size()[axis];
                prop_assert!(rest.abs() <= round_off(&cell, &[place]), "{place} -> {wrapped}");
            } else {
                prop_assert_eq!(place[axis], wrapped[axis]);
            }
        }
        prop_assert_eq!(cell.wrap(wrapped), wrapped, "what is inside stays where it is");
        let back = low + fraction * cell.size();
        prop_assert!((back - wrapped).abs().max_element() <= round_off(&cell, &[wrapped]));
    }

    /// The fractional parts of a place and of its wrapped image are the same, on a circle of one period.
    #[test]
    fn fractional_coordinates_of_images_differ_by_whole_numbers((cell, place, _) in cell_and_places()) {
        let apart = cell.fractional(place) - cell.fractional(cell.wrap(place));
        for axis in 0..3 {
            let rest = (apart[axis] - apart[axis].round()).abs();
            let most = round_off(&cell, &[place]) / cell.size()[axis];
            let most = if cell.is_periodic(axis) { most } else { 0.0 };
            prop_assert!(rest <= most, "{rest}");
        }
    }

    #[test]
    fn no_image_is_nearer_than_the_minimum_image((cell, a, b) in cell_and_places()) {
        let velocity = DVec3::new(1.0, -2.0, 3.0);
        let (branch, of_image) = cell.min_image(b - a, velocity);
        prop_assert_eq!(of_image, velocity, "the cell is at rest");
        // Both inside the periodic faces, all images that may be nearest are neighbours.
        let between = cell.wrap(b) - cell.wrap(a);
        let images = std::iter::once(NO_SHIFT).chain(cell.images());
        let all: Vec<DVec3> = images.map(|code| between + cell.shift(code)).collect();
        let nearest = all.iter().map(|branch| branch.length()).fold(f64::INFINITY, f64::min);
        let most = 4.0 * round_off(&cell, &[a, b]);
        prop_assert!((branch.length() - nearest).abs() <= most, "{branch}: {nearest}");
        let is_image = |image: &DVec3| (*image - branch).abs().max_element() <= most;
        prop_assert!(all.iter().any(is_image), "{branch} is none of the images");
    }

    #[test]
    fn faces_close_the_axes_that_are_not_periodic((cell, place, _) in cell_and_places()) {
        let ((low, high), most) = (cell.corners(), round_off(&cell, &[place]));
        // How far it is beyond the faces of the closed axes, m.
        let beyond = (low - place).max(place - high);
        let closed = (0..3).filter(|&axis| !cell.is_periodic(axis));
        let farthest = closed.map(|axis| beyond[axis]).fold(f64::NEG_INFINITY, f64::max);
        // On a face, round-off decides.
        if farthest.abs() > most {
            prop_assert_eq!(cell.holds(place), farthest < 0.0, "{}", farthest);
        }
        prop_assert!(cell.holds(low), "a face belongs to the cell");
        let all_closed = cell.with_periodic([false; 3]);
        prop_assert_eq!(cell.distance_to_faces(place) >= 0.0, all_closed.holds(place));
    }

    #[test]
    fn bytes_bring_a_cell_back((cell, ..) in cell_and_places()) {
        let mut bytes = Vec::new();
        cell.put(&mut bytes);
        prop_assert_eq!(whole(&bytes, Cell::take), Ok(cell));
    }
}

#[test]
fn the_upper_face_is_the_lower_one() {
    let (low, high) = (DVec3::new(-1.0, 0.1, 0.0), DVec3::new(2.0, 0.3, 1e-3));
    let cell = Cell::new(low, high, [true; 3]);
    assert_eq!(cell.wrap(cell.faces().1), low);
    assert_eq!(cell.wrap(low), low);
    // Closer to the lower face than the last digit of the size: the sum is the upper face.
    let x = -1.0 - 1e-300;
    assert_eq!(cell.wrap(DVec3::new(x, 0.1, -1e-300)), low);
    assert_eq!(cell.wrap(DVec3::new(5.5, 0.1, 0.0)).x, -0.5);
    assert_eq!(cell.wrap(DVec3::new(-7.25, 0.1, 0.0)).x, 1.75);
}

#[test]
fn shifts_are_whole_periods_of_periodic_axes() {
    let cell = Cell::new(DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0), [true, false, true]);
    assert_eq!(cell.shift(NO_SHIFT), DVec3::ZERO);
    assert_eq!(cell.images().count(), 8);
    assert!(cell.images().all(|code| cell.shift(code).y == 0.0));
    for code in 0..image::NEIGHBOURS {
        assert_eq!(cell.shift(opposite(code)), -cell.shift(code));
        assert_eq!(cell.any_shift(code), cell.shift(code));
    }
    let far = image::code([-7, 1, 511]);
    assert_eq!(cell.any_shift(far), DVec3::new(-7.0, 2.0, 1533.0));
}

#[test]
fn numbers_that_are_not_finite_stay_so() {
    let cell = Cell::new(DVec3::ZERO, DVec3::ONE, [true; 3]);
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let place = DVec3::new(x, 0.5, 7.25);
        assert!(!cell.wrap(place).x.is_finite());
        assert_eq!(cell.wrap(place).z, 0.25);
        assert!(!cell.fractional(place).x.is_finite());
        assert!(!cell.min_image(place, DVec3::ZERO).0.x.is_finite());
        assert!(!cell.with_periodic([false; 3]).holds(place));
    }
}
