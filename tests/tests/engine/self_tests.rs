//! MercuryDPM's self tests through our engine, one test for each set-up.

use mercury_tests::selftests::{Data, energy_of_a_packing, run_number};

/// Runs a set-up and asserts that every number agrees.
fn check(number: u32) {
    let Some(data) = Data::find() else {
        assert!(
            std::env::var_os("CI").is_none(),
            "the reference data are missing"
        );
        println!("skipped: the reference data are not installed");
        return;
    };
    let comparison = run_number(&data, number).unwrap();
    println!("{comparison:#?}");
    assert!(comparison.holds(), "{comparison:#?}");
}

macro_rules! set_ups {
    ($($name:ident = $number:literal)*) => {
        $(#[test]
        fn $name() {
            check($number);
        })*
    };
}

set_ups! {
    two_particle_elastic_collision = 1
    free_fall = 2
    newtons_cradle = 3
    square_packing = 4
    plastic_force = 6
    os_hertz = 7
    force_0 = 8
    force_1 = 9
    force_2 = 10
    force_3 = 11
    force_4 = 12
    extreme_overlap = 19
    rolling_friction = 20
    torsion_friction = 21
    oblique_impact = 22
    mindlin_loading = 23
    mindlin_normal_and_tangential_loading = 24
    deletion_boundary = 29
}

#[test]
fn dense_packing() {
    let comparison = energy_of_a_packing().unwrap();
    assert!(comparison.holds(), "{comparison:#?}");
}
