//! Forces and energies of bridges: values of the specification's table of cases, which were computed by other programs, and closed
//! forms.

use std::sync::{Arc, LazyLock};

use proptest::prelude::*;

use super::*;
use crate::contact::adhesion::young_laplace::Branch;
use crate::lanes::Lanes;

const MM: f64 = 1e-3;

/// Exact bridges at 20 degrees.
static TABLES: LazyLock<Tables> = LazyLock::new(|| {
    let table = Table::new(20f64.to_radians(), (1e-4, 0.1), (0.0, 1.0), 1e-3).unwrap();
    let mut tables = Tables::default();
    tables.add(&Arc::new(table));
    tables
});

fn law(fit: Fit, surface_tension: f64, degrees: f64) -> Liquid {
    Liquid {
        fit,
        surface_tension,
        contact_angle: degrees.to_radians(),
        max_volume: 1.0,
        rupture: Rupture::Willett,
        ..Liquid::NONE
    }
}

fn bridge(liquid: &Liquid, volume: f64, radii: [f64; 2]) -> Bridge {
    let none = Tables::default();
    let tables = match liquid.fit {
        Fit::YoungLaplace => &*TABLES,
        _ => &none,
    };
    liquid.fill(&Bridge::default(), volume, radii, tables)
}

fn close(found: f64, expected: f64, relative: f64) {
    assert!(
        (found - expected).abs() <= relative * expected.abs(),
        "{found:e}, not {expected:e}"
    );
}

/// A pole is reported where the denominator, looked at gap by gap, comes to 0, or where the touch is stronger than any bridge, and nowhere
/// else: then every force is a number. Thresholds of equal spheres are roots of the denominator at the end of the gap.
#[test]
fn poles_are_found_where_the_denominator_vanishes() {
    let none = Tables::default();
    let (mut poles, mut whole) = (0, 0);
    for fit in [Fit::Bagheri, Fit::LianSeville, Fit::Willett] {
        for degrees in (0..=90).step_by(5) {
            let liquid = Liquid {
                rupture: Rupture::Radii,
                ..law(fit, 0.07, f64::from(degrees))
            };
            for radii in [[MM; 2], [MM, 3.0 * MM], [MM, f64::INFINITY]] {
                for k in 0..60 {
                    let diameter = reduced_diameter(radii);
                    let volume =
                        libm::exp10(-5.0 + 0.09 * f64::from(k)) * diameter * diameter * diameter;
                    let bridge = liquid.fill(&Bridge::default(), volume, radii, &none);
                    let [touch, _, p, q, _] = bridge.resized::<SHORT>().curve;
                    let gaps = (0..=2000).map(|k| f64::from(k) / 2000.0 * bridge.end);
                    let least = gaps
                        .map(|s| 1.0 + s * (p + q * s))
                        .fold(f64::INFINITY, f64::min);
                    let unit = 2.0 * PI * 0.07 * diameter;
                    let place = format!(
                        "{fit:?} {degrees} degrees, {radii:?}, {volume:e} m3: {least}, {touch}"
                    );
                    if liquid.has_pole(volume, radii, &none) {
                        poles += 1;
                        // Between two of the gaps it is lower by less than the square of their distance.
                        assert!(least < 1e-5 || touch.abs() > unit, "{place}");
                    } else {
                        whole += 1;
                        assert!(least > 0.0 && touch.abs() <= 1.01 * unit, "{place}");
                    }
                }
            }
        }
    }
    assert!(poles > 300 && whole > 3000, "{poles} {whole}");
    for (degrees, root) in [
        (50.0, 0.635_282),
        (60.0, 0.276_924),
        (70.0, 0.085_678),
        (80.0, 0.021_475),
    ] {
        let liquid = law(Fit::Bagheri, 0.07, degrees);
        let is_pole = |share: f64| liquid.has_pole(share * root * MM * MM * MM, [MM; 2], &none);
        assert!(!is_pole(0.9999) && is_pole(1.0001), "{degrees} degrees");
    }
}

/// Case T19: digits as printed.
#[test]
fn short_willett_has_its_printed_values() {
    let mut liquid = law(Fit::Willett, 0.0728, 20.0);
    liquid.rupture = Rupture::Lian;
    let pair = bridge(&liquid, 1e-11, [MM; 2]);
    close(pair.end, 2.530454478634e-4, 1e-12);
    for (gap, force) in [
        (0.0, 4.298303368040e-4),
        (1e-6, 4.252588046540e-4),
        (1e-5, 3.803808290301e-4),
        (5e-5, 1.999210868856e-4),
        (1e-4, 9.446820589099e-5),
        (2e-4, 3.281147609191e-5),
        (2.530454478634e-4, 2.185765788413e-5),
    ] {
        close(liquid.pull(&pair, gap), force, 1e-11);
    }
    close(-liquid.energy_of(&pair), 2.93382511304e-8, 1e-11);
    // Unequal radii, and a wall.
    let wetting = law(Fit::Willett, 0.07, 0.0);
    let unequal = bridge(&wetting, 1e-11, [0.5 * MM, 1.2 * MM]);
    close(wetting.pull(&unequal, 0.0), 3.104632740e-4, 1e-9);
    let at_wall = bridge(&wetting, 1e-11, [1.2 * MM, f64::INFINITY]);
    close(wetting.pull(&at_wall, 0.0), 1.0555751316e-3, 1e-10);
    close(
        liquid.end(1e-11, [MM; 2], &Tables::default()) / (1.0 + 0.5 * liquid.contact_angle),
        libm::cbrt(1e-11),
        1e-14,
    );
}

/// Case T20.
#[test]
fn classical_willett_and_bagheri_have_their_printed_values() {
    let liquid = law(Fit::WillettClassical, 0.0728, 20.0);
    let pair = bridge(&liquid, 1e-11, [MM; 2]);
    for (gap, force) in [
        (0.0, 3.673570620546e-4),
        (1e-6, 3.670602504436e-4),
        (1e-5, 3.432702339759e-4),
        (5e-5, 2.030042065283e-4),
        (2e-4, 4.576941668278e-5),
    ] {
        close(liquid.pull(&pair, gap), force, 1e-11);
    }
    let shipped = law(Fit::WillettClassical, 0.07, 0.0);
    let at_wall = bridge(&shipped, 8e-11, [1.2 * MM, f64::INFINITY]);
    close(
        shipped.pull(&at_wall, 2.87913965626699e-5),
        8.04681515933928e-4,
        1e-12,
    );
    // R_D = 1 m and gamma = 1 N/m.
    for (degrees, gap, force) in [
        (0.0, 0.0, 5.553082251009),
        (0.0, 0.0220085, 4.341327596771),
        (10.0, 0.05, 2.934346842525),
    ] {
        let liquid = law(Fit::Bagheri, 1.0, degrees);
        close(
            liquid.pull(&bridge(&liquid, 0.01, [1.0; 2]), gap),
            force,
            1e-6,
        );
    }
}

/// Section 3.5 of the specification: stored energies up to the end of the stable branch, for the input of T19.
#[test]
fn energies_have_their_printed_values() {
    for (fit, at_touch, apart) in [
        (Fit::Bagheri, -3.121637337e-8, Some(-1.693522229e-8)),
        (Fit::LianSeville, -3.110171124e-8, Some(-1.676947323e-8)),
        (Fit::WillettClassical, -3.12564937e-8, None),
    ] {
        let liquid = law(fit, 0.0728, 20.0);
        let mut pair = bridge(&liquid, 1e-11, [MM; 2]);
        close(liquid.energy_of(&pair), at_touch, 1e-9);
        if let Some(expected) = apart {
            pair.gap = 5e-5;
            close(liquid.energy_of(&pair), expected, 1e-9);
        }
        // Beyond the end nothing is stored.
        pair.gap = 1.01 * pair.end;
        assert_eq!(liquid.energy_of(&pair), 0.0);
    }
}

/// Case T22, with V/R_D^3 and, as MercuryDPM has it, with V in m^3.
#[test]
fn lian_and_seville_has_its_printed_values() {
    let right = law(Fit::LianSeville, 0.07, 10.0);
    let pair = bridge(&right, 1e-11, [MM; 2]);
    close(pair.end, 2.392911023053e-4, 1e-11);
    for (gap, force) in [
        (0.0, 3.802091487019e-4),
        (1e-6, 3.767932371162e-4),
        (1e-5, 3.443031196430e-4),
        (5e-5, 2.084149485976e-4),
        (1e-4, 1.116382293211e-4),
        (2e-4, 4.300989875117e-5),
    ] {
        close(right.pull(&pair, gap), force, 1e-11);
    }
    close(-right.energy_of(&pair), 3.06758009e-8, 1e-8);

    let as_mercury = Liquid {
        lian_seville_volume: LianSevilleVolume::CubicMetres,
        rupture: Rupture::Radii,
        ..right
    };
    let pair = bridge(&as_mercury, 1e-11, [MM; 2]);
    close(pair.end, 2.342495050772e-4, 1e-11);
    for (gap, force) in [
        (0.0, 4.327877408048e-4),
        (1e-6, 2.293427250873e-4),
        (1e-5, 8.953975070493e-6),
        (1e-4, 1.001652138372e-7),
    ] {
        close(as_mercury.pull(&pair, gap), force, 1e-11);
    }
}

/// Section 3.6 of the specification.
#[test]
fn bridges_end_where_the_fit_says() {
    let liquid = Liquid {
        rupture: Rupture::Radii,
        ..law(Fit::Bagheri, 0.07, 20.0)
    };
    // R_D = 1 mm: the smaller radius is (1 + ratio)/2 mm, the larger one 1/ratio times that.
    let radii = |ratio: f64| {
        let smaller = 0.5 * MM * (1.0 + ratio);
        [smaller, smaller / ratio]
    };
    for (volume, ratio, end) in [
        (0.01, 1.0, 2.5849715e-4),
        (0.01, 0.5, 2.3718212e-4),
        (0.01, 0.2, 2.243931e-4),
        (0.01, 0.0, 2.1586709e-4),
        (0.05, 1.0, 4.4864249e-4),
        (0.05, 0.5, 3.9760086e-4),
        (0.05, 0.2, 3.6697587e-4),
        (0.05, 0.0, 3.4655922e-4),
    ] {
        close(
            liquid.end(volume * 1e-9, radii(ratio), &Tables::default()),
            end,
            1e-7,
        );
        // The list reaches at least that far.
        let planned = Liquid {
            max_volume: volume * 1e-9,
            ..liquid
        };
        let smallest = radii(ratio)[0];
        assert!(
            planned.reaching(smallest, &Tables::default()).range
                >= planned.end(volume * 1e-9, radii(ratio), &Tables::default())
        );
    }
}

/// Exact solutions of the Young-Laplace equation (T21), and how far each law may be from them by the specification.
#[test]
fn laws_are_as_close_to_the_exact_force_as_claimed() {
    let exact = [
        (
            0.0,
            0.001,
            [5.8820021, 3.8634989, 1.9379071, 0.7948671, 0.4248681],
        ),
        (
            0.0,
            0.01,
            [5.5568523, 4.3189436, 2.7780303, 1.4125256, 0.8215396],
        ),
        (
            0.0,
            0.05,
            [5.1746235, 4.3965049, 3.2650436, 1.9606015, 1.2428148],
        ),
        (
            0.0,
            0.1,
            [4.9490799, 4.3525773, 3.4180598, 2.2086268, 1.4641865],
        ),
        (
            10.0,
            0.01,
            [5.4514747, 4.1433109, 2.5695320, 1.2681384, 0.7288167],
        ),
        (
            30.0,
            0.01,
            [4.6531753, 3.4286910, 2.0281658, 0.9940369, 0.5955822],
        ),
        (
            30.0,
            0.05,
            [4.2411531, 3.5281835, 2.4961029, 1.4484995, 0.9373207],
        ),
    ];
    // Per cent, for contact angles of 0 to 30 degrees and V* of 1e-3 to 0.1, at these gaps over the end (section 3.5 of the
    // specification), rounded outwards by 0.5.
    let gaps = [0.0, 0.1, 0.25, 0.5, 0.75];
    let claimed = [
        (
            Fit::Bagheri,
            [
                (-0.2, 0.6),
                (-0.6, 1.0),
                (-0.4, 1.7),
                (-1.4, 1.0),
                (-6.9, 2.5),
            ],
        ),
        (
            Fit::WillettClassical,
            [
                (-2.9, -0.3),
                (-0.2, 0.8),
                (-0.6, 0.7),
                (-0.3, 1.0),
                (-1.1, 0.7),
            ],
        ),
        (
            Fit::LianSeville,
            [
                (-0.5, 0.1),
                (-3.0, 4.0),
                (-6.0, 9.0),
                (-11.0, 6.0),
                (-17.0, 5.0),
            ],
        ),
        (
            Fit::Willett,
            [
                (7.0, 36.0),
                (1.0, 20.0),
                (-10.0, 4.0),
                (-25.0, -13.0),
                (-38.0, -17.0),
            ],
        ),
    ];
    for (degrees, volume, forces) in exact {
        for (fit, bounds) in claimed {
            let liquid = law(fit, 1.0, degrees);
            let pair = bridge(&liquid, volume, [1.0; 2]);
            for ((gap, expected), (low, high)) in gaps.into_iter().zip(forces).zip(bounds) {
                let found = liquid.pull(&pair, gap * pair.end);
                let percent = 100.0 * (found / expected - 1.0);
                assert!(
                    low - 0.5 <= percent && percent <= high + 0.5,
                    "{fit:?} at {degrees} degrees, V* {volume}, {gap}: {percent} %"
                );
            }
        }
    }
}

/// Case T23: forces of a film.
#[test]
fn viscous_forces_have_their_printed_values() {
    let liquid = Liquid {
        viscosity: 1e-3,
        roughness: Some(1e-6),
        ..law(Fit::Bagheri, 0.0, 10.0)
    };
    for (radii, normal, tangential) in [
        ([MM; 2], 4.712388980385e-5, 1.435022474201e-6),
        ([MM, f64::INFINITY], 1.884955592154e-4, 3.218458722852e-6),
    ] {
        for sign in [1.0, -1.0] {
            let mut pair = bridge(&liquid, 1e-11, radii);
            let contact = contact(radii, -1e-5, 0.1 * sign, 0.05 * sign);
            let force = liquid.act(&contact, &mut pair);
            close(-sign * force.normal.viscous, normal, 1e-12);
            close(-sign * force.tangential.y, tangential, 1e-11);
            assert_eq!(force.normal.elastic, 0.0);
        }
    }
}

/// Two that approach (u < 0) or part along x and slide along y.
fn contact(radii: [f64; 2], overlap: f64, normal: f64, sliding: f64) -> Contact {
    let effective_radius = 0.5 * reduced_diameter(radii);
    Contact {
        normal: Vector::X,
        distance: radii[0] - overlap,
        overlap,
        effective_radius,
        effective_mass: 1.0,
        normal_velocity: normal,
        tangential_velocity: Vector::new(0.0, sliding, 0.0),
        sliding_normal: Vector::X,
        sliding_distance: radii[0] - overlap,
        centre_velocity: Vector::ZERO,
        spin: Vector::ZERO,
    }
}

#[test]
fn a_cut_film_is_silent_below_its_limit() {
    let cut = Liquid {
        viscosity: 1e-3,
        lubrication: Lubrication::Cut,
        ..law(Fit::LianSeville, 0.0, 10.0)
    };
    let mut pair = bridge(&cut, 1e-11, [MM; 2]);
    let limit = 0.25 * pair.end;
    for (gap, acts) in [
        (0.99 * limit, false),
        (1.01 * limit, true),
        (1.01 * pair.end, false),
    ] {
        let force = cut.act(&contact([MM; 2], -gap, 0.1, 0.05), &mut pair);
        assert_eq!(force.normal.viscous != 0.0, acts, "{gap}");
        assert_eq!(force.tangential.y != 0.0, acts, "{gap}");
    }
    // The others are cut at R*/100.
    let cut = Liquid {
        fit: Fit::Willett,
        ..cut
    };
    let mut pair = bridge(&cut, 1e-11, [MM; 2]);
    for (gap, acts) in [(4.9e-6, false), (5.1e-6, true)] {
        let force = cut.act(&contact([MM; 2], -gap, 0.1, 0.05), &mut pair);
        assert_eq!(force.normal.viscous != 0.0, acts, "{gap}");
    }
    // In contact the normal term goes on at the roughness, if this is selected.
    for (goes_on, expected) in [
        (false, 0.0),
        (true, -6.0 * PI * 1e-3 * 0.5 * MM * 100.0 * 0.1),
    ] {
        let clamped = Liquid {
            lubrication: Lubrication::Clamped,
            lubrication_in_contact: goes_on,
            ..cut
        };
        let force = clamped.act(&contact([MM; 2], 1e-6, 0.1, 0.05), &mut pair);
        assert!((force.normal.viscous - expected).abs() <= 1e-15 * expected.abs());
        assert_eq!(force.tangential.y, 0.0);
    }
}

/// All laws.
const FITS: [Fit; 5] = [
    Fit::Bagheri,
    Fit::WillettClassical,
    Fit::LianSeville,
    Fit::Willett,
    Fit::YoungLaplace,
];

/// The law has the force of the exact solution in SI units, for pairs and at walls, and its end; a bridge outside of the table is seen.
#[test]
fn young_laplace_has_the_exact_force() {
    let liquid = Liquid {
        rupture: Rupture::Table,
        ..law(Fit::YoungLaplace, 0.07, 20.0)
    };
    for (volume, radii) in [
        (1e-11, [MM; 2]),
        (5e-12, [0.7 * MM, 2.1 * MM]),
        (3e-11, [MM, f64::INFINITY]),
    ] {
        let diameter = reduced_diameter(radii);
        let relative = volume / (diameter * diameter * diameter);
        let ratio = ratio_of(radii);
        let branch = Branch::new(liquid.contact_angle, relative, ratio).unwrap();
        let pair = bridge(&liquid, volume, radii);
        close(pair.end, branch.end() * diameter, 1e-3);
        close(liquid.end(volume, radii, &TABLES), pair.end, 1e-14);
        for share in [0.0, 0.1, 0.5, 0.9] {
            let gap = share * branch.end();
            let exact = 0.07 * diameter * branch.at(gap).unwrap().force;
            close(liquid.pull(&pair, gap * diameter), exact, 1e-3);
        }
        assert!(liquid.reaching(0.5 * MM, &TABLES).range > 0.0);
        assert!(!liquid.is_clamped(volume, radii, &TABLES));
    }
    assert!(liquid.is_clamped(1e-15, [MM; 2], &TABLES));
    // Contacts with little room do not take it.
    let any = crate::contact::AnyAdhesion::Liquid(liquid);
    assert!(<LiquidLaw<SHORT> as crate::contact::OneOf<_>>::of(any).is_none());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// The force is minus the slope of the energy. Central differences over 2h err by h^2 F''/6, of which 1e-6 (h/s)^2 is less, and by
    /// the round-off of the energy, 1e-15 U/h.
    #[test]
    fn forces_are_slopes_of_energies(
        which in 0..5_usize,
        degrees in 0.0..50.0,
        volume in prop::sample::select(vec![1e-4, 1e-3, 1e-2, 0.1]),
        ratio in 0.05..1.0_f64,
        place in 0.05..0.95_f64,
    ) {
        let fit = FITS[which];
        let degrees = if fit == Fit::YoungLaplace { 20.0 } else { degrees };
        let liquid = Liquid { rupture: Rupture::Radii, ..law(fit, 0.07, degrees) };
        let radii = [MM * (1.0 + ratio) / 2.0, MM * (1.0 + ratio) / 2.0 / ratio];
        let pair = bridge(&liquid, volume * 1e-9, radii);
        let (s, h) = (place * pair.end, 1e-4 * pair.end);
        let energy = |gap: f64| {
            let mut there = pair;
            there.gap = gap;
            liquid.energy_of(&there)
        };
        let slope = (energy(s + h) - energy(s - h)) / (2.0 * h);
        let force = liquid.pull(&pair, s);
        let tolerance = 1e-6 * liquid.pull(&pair, 0.0) + 1e-14 * energy(0.0).abs() / h;
        prop_assert!((slope - force).abs() < tolerance, "{slope} {force}");
    }

    /// Several contacts side by side have the bits of each alone.
    #[test]
    fn lanes_have_the_bits_of_single_contacts(
        which in 0..5_usize,
        gaps in prop::array::uniform4(-1e-5..3e-4_f64),
        volumes in prop::array::uniform4(prop::sample::select(vec![0.0, 1e-12, 1e-11])),
        speed in -0.1..0.1_f64,
    ) {
        let fit = FITS[which];
        let liquid = Liquid { viscosity: 1e-3, ..law(fit, 0.07, 20.0) };
        let contacts = gaps.map(|gap| contact([MM; 2], -gap, speed, 0.3 * speed));
        let bridges = volumes.map(|volume| bridge(&liquid, volume, [MM; 2]));
        let all = Contact::<Lanes<4>> {
            normal: Vector::X,
            distance: Lanes::from_lanes(|k| contacts[k].distance),
            overlap: Lanes::from_lanes(|k| contacts[k].overlap),
            effective_radius: Lanes::splat(0.5 * MM),
            effective_mass: Lanes::ONE,
            normal_velocity: Lanes::splat(speed),
            tangential_velocity: Vector::gather(|k| contacts[k].tangential_velocity),
            sliding_normal: Vector::X,
            sliding_distance: Lanes::from_lanes(|k| contacts[k].sliding_distance),
            centre_velocity: Vector::ZERO,
            spin: Vector::ZERO,
        };
        let mut together = Bridge::<Lanes<4>>::gather(|k| bridges[k]);
        let force = liquid.act(&all, &mut together);
        let events = liquid.has_event(&all, &together).bits();
        for k in 0..4 {
            let mut alone = bridges[k];
            let expected = liquid.act(&contacts[k], &mut alone);
            prop_assert_eq!(force.lane(k), expected);
            prop_assert_eq!(together.lane(k), alone);
            prop_assert_eq!(events >> k & 1 == 1, liquid.has_event(&contacts[k], &alone));
        }
    }
}

#[test]
fn numbers_of_a_bridge_are_written_and_read_back() {
    let liquid = law(Fit::WillettClassical, 0.07, 20.0);
    let one = Bridge {
        gap: 1e-5,
        force: -1e-4,
        ..bridge(&liquid, 1e-11, [MM; 2])
    };
    let mut numbers = Vec::new();
    one.write(&mut numbers);
    assert_eq!(numbers.len(), <Bridge as History>::LENGTH);
    assert_eq!(<Bridge as History>::read(&numbers), one);
}
