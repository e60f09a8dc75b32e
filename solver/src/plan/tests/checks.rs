//! Refusals before a run, word for word.

use crate::plan::parse_scene;
use mercury_common::scene::Files;

use super::*;

#[test]
fn particles_outside_the_domain_are_named() {
    let scene = BALL.to_owned()
        + &particle("ball", 0.1, [0.0, 0.0, 0.5], "")
        + &particle("ball", 0.1, [0.0, 0.0, 1.5], "name = \"high\"")
        + &particle("ball", 0.1, [0.0, -1.0, 0.0], "");
    assert_eq!(
        complaints(&scene),
        [
            "particles.high: particle 1 (particles.high) lies outside the domain: [0, 0, 1.5] is not within [-1, -1, -1] to \
          [1, 1, 1] | move it, or enlarge the domain"
        ]
    );
    // along a periodic axis there is no outside
    let text = format!("{HEAD}{scene}");
    let plan = planned_with(&text, &["domain.periodic=[\"z\"]"]).expect("plans");
    assert_eq!(plan.physics().particles[1].position.z, -0.5);
}

/// A sphere of 1 mm at 1e12 m: neighbouring numbers lie 0.1 mm apart there, and the energy of a contact came out 190 times too large.
#[test]
fn far_from_the_origin_numbers_are_too_coarse_for_overlaps() {
    let at = |x: f64| {
        let scene = BALL.to_owned() + &particle("ball", 1e-3, [x, 0.0, 0.0], "");
        let room = format!("domain.max=[{:?}, 1, 1]", 2.0 * x);
        planned_with(&format!("{HEAD}{scene}"), &[&room, "time.step=1e-6"])
    };
    let refused = at(1e12).expect_err("too coarse");
    assert_eq!(refused.0.len(), 1);
    let expected = "where neighbouring numbers lie 0.000222045 m apart: 0.222045 of the smallest radius, 0.001 m; \
                    overlaps would be lost in round-off";
    let message = &refused.0[0].message;
    assert!(message.contains(expected), "{message}");
    // 1e-3 * 1e-8 / 2.2e-16 = 45 km
    let warned = |x: f64| {
        let plan = at(x).expect("plans");
        let warnings = plan.notes().warnings();
        warnings
            .iter()
            .any(|text| text.contains("lost in round-off"))
    };
    assert!(!warned(4.4e4) && warned(4.6e4));
    assert!(at(4.4e7).is_ok() && at(4.6e7).is_err());
}

#[test]
fn rows_of_tables_are_named_by_their_lines() {
    let folder = tempfile::tempdir().expect("a folder");
    let table = |content: &str| {
        std::fs::write(folder.path().join("beads.csv"), content).expect("writable");
        let text =
            format!("{HEAD}{BALL}[[particles]]\nfile = \"beads.csv\"\nmaterial = \"ball\"\n");
        let path = folder.path().join("test.toml");
        let scene = parse_scene(&path, &text, &[], Files::MustExist).expect("parses");
        plan(&scene)
    };
    let good = table("x,y,z,radius\n0,0,0,0.1\n0.5,0,0,0.1\n").expect("plans");
    assert_eq!(good.physics().particles.len(), 2);
    let path = folder.path().join("beads.csv").display().to_string();
    for (content, message) in [
        (
            "x,y,z,radius\n0,0,0,0.1\n2,0,0,0.1\n0,9,0,0.1\n",
            "particle 1 (particles[0], line 3 of its file) lies outside the domain: [2, 0, 0] is not within [-1, -1, -1] to \
             [1, 1, 1]; 1 more of this entry too"
                .to_owned(),
        ),
        (
            "x,y,z,radius,material\n0,0,0,0.1,glass\n",
            format!("{path}:2: there is no material named `glass`"),
        ),
    ] {
        let errors = table(content).expect_err("wrong");
        assert_eq!(errors.0.len(), 1, "{errors}");
        assert_eq!(errors.0[0].message, message);
    }
    let errors = table("x,y,z,radius\n0,0,0,-1\n").expect_err("wrong");
    assert!(errors.to_string().contains("beads.csv:2:7"), "{errors}");
    // All that is wrong at once: columns, then rows, of which the tenth is the last to be named.
    let errors = table("x,yy,z,radius [kg],spin\n0,0,0,0.1\n").expect_err("wrong");
    let messages: Vec<&str> = errors
        .0
        .iter()
        .map(|error| error.message.as_str())
        .collect();
    assert_eq!(messages.len(), 3, "{errors}");
    for (message, part) in messages.iter().zip([
        ":1:3: unknown column \"yy\"",
        ":1:8: the unit \"kg\" of column radius, expected a length (m, cm, mm, um, nm, km)",
        ":1:20: unknown column \"spin\"",
    ]) {
        assert!(message.contains(part), "{message}");
    }
    let rows: String = (0..15)
        .map(|k| format!("0,0.{0:02},x,0.01\n0,0.{0:02},0,0.01\n", 5 * k))
        .collect();
    let errors = table(&format!("x,y,z,radius\n{rows}")).expect_err("wrong");
    assert_eq!(errors.0.len(), 11, "{errors}");
    assert!(errors.0[1].message.contains(":4:8: \"x\" in column z"));
    assert!(errors.0[10].message.ends_with(": 5 more rows are wrong"));
}

#[test]
fn tables_in_millimetres_are_scaled_and_suspected() {
    let folder = tempfile::tempdir().expect("a folder");
    let table = |content: &str, more: &str| {
        std::fs::write(folder.path().join("beads.csv"), content).expect("writable");
        let text =
            format!("{HEAD}{BALL}[[particles]]\nfile = \"beads.csv\"\nmaterial = \"ball\"\n{more}");
        let path = folder.path().join("test.toml");
        let scene = parse_scene(&path, &text, &[], Files::MustExist)?;
        plan(&scene)
    };
    let rows = "500,0,2.1,100\n-500,0,0,100\n";
    for (head, more) in [
        ("x [mm],y (mm),z[mm],radius [mm]", ""),
        ("x,y,z,radius", "scale = \"1 mm\"\n"),
        ("x,y [mm],z [mm],radius", "scale = 1e-3\n"),
    ] {
        let plan = table(&format!("{head}\n{rows}"), more).expect("plans");
        let first = &plan.physics().particles[0];
        let expected = glam::DVec3::new(0.5, 0.0, 0.0021);
        let away = first.position.distance(expected);
        assert!(away < 1e-15, "{}", first.position);
        assert!((first.radius - 0.1).abs() < 1e-15);
    }
    let help = |content: &str, more: &str| {
        let errors = table(content, more).expect_err("wrong");
        assert_eq!(errors.0.len(), 1, "{errors}");
        errors.0[0].to_string()
    };
    let text = help(&format!("x,y,z,radius\n{rows}"), "");
    assert!(text.contains("if the file is in millimetres"), "{text}");
    // 3000 mm are outside as well.
    for (content, more) in [
        ("x,y,z,radius\n3000,0,0,0.1\n0,0,0,0.1\n", ""),
        ("x,y,z,radius\n3000,0,0,100\n0,0,0,100\n", "scale = 1e-3\n"),
        // 9 mm in a domain of 2 m.
        ("x,y,z,radius\n9,0,0,0.1\n0,0,0,0.1\n", ""),
    ] {
        let text = help(content, more);
        assert!(text.contains("move it, or enlarge the domain"), "{text}");
    }
    let text = help(
        &format!("x [mm],y [mm],z [mm],radius [mm]\n{rows}"),
        "scale = 1e-3\n",
    );
    assert!(text.contains("scale: has nothing to scale"), "{text}");
    let plan = table(
        "x,y,z,radius,vx\n500,0,0,100,2\n-500,0,0,100,2\n",
        "scale = 1e-3\n",
    )
    .expect("plans");
    let said = plan.notes().remarks().join("\n");
    assert!(
        said.contains("velocities are in m/s, as `scale` is for x, y, z and radius"),
        "{said}"
    );
}

#[test]
fn initial_overlaps_are_errors_or_warnings() {
    let at = |x: f64, more: &str| particle("ball", 0.1, [x, 0.0, 0.0], more);
    let deep = BALL.to_owned() + &at(0.0, "") + &at(0.125, "name = \"deep\"");
    assert_eq!(
        complaints(&deep),
        [
            "particles.deep: particle 0 (particles[0]) and particle 1 (particles.deep) overlap by 0.075 m at the start, 0.75 of \
          the smaller radius; the limit is contact.overlap_error = 0.5 | move them apart, or raise the limit if this is meant"
        ]
    );
    let plan =
        planned_with(&format!("{HEAD}{deep}"), &["contact.overlap_error=0.8"]).expect("plans");
    assert_eq!(
        plan.notes().warnings(),
        [
            "particle 0 (particles[0]) and particle 1 (particles.deep) overlap by 0.075 m at the start, 0.75 of the smaller \
          radius (contact.overlap_warning = 0.1)"
        ]
    );
    // a shallow one is no matter, and fixed particles may overlap one another
    assert!(
        planned(&(BALL.to_owned() + &at(0.0, "") + &at(0.195, "")))
            .notes()
            .warnings()
            .is_empty()
    );
    let fixed =
        BALL.to_owned() + &at(0.0, "fixed = true") + &at(0.1, "fixed = true") + &at(0.5, "");
    assert!(planned(&fixed).notes().warnings().is_empty());
    // through a periodic face: -0.95 and 0.95 are 0.1 m apart
    let images = format!("{HEAD}{BALL}{}{}", at(-0.95, ""), at(0.95, ""));
    assert!(planned_with(&images, &[]).is_ok());
    let errors = planned_with(&images, &["domain.periodic=[\"x\"]"]).expect_err("overlap");
    assert!(errors.0[0].message.contains("overlap by 0.1 m"), "{errors}");
}

#[test]
fn overlaps_with_walls_count_too() {
    let floor = "[[walls]]\nname = \"floor\"\nshape = \"plane\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nmaterial = \"ball\"\n";
    let at =
        |z: f64, more: &str| BALL.to_owned() + floor + &particle("ball", 0.1, [0.0, 0.0, z], more);
    assert_eq!(
        complaints(&at(-0.3, "")),
        [
            "particles[0]: particle 0 (particles[0]) overlaps wall `floor` by 0.4 m at the start, 4 of its radius; the limit is \
          contact.overlap_error = 0.5 | move it off the wall (more than 1: its centre is behind it), or raise the limit if this \
          is meant"
        ]
    );
    assert_eq!(
        planned(&at(0.07, "")).notes().warnings(),
        [
            "particle 0 (particles[0]) overlaps wall `floor` by 0.03 m at the start, 0.3 of its radius \
          (contact.overlap_warning = 0.1)"
        ]
    );
    let rough = at(0.0, "fixed = true") + &particle("ball", 0.1, [0.5, 0.0, 0.5], "");
    assert!(planned(&rough).notes().warnings().is_empty());
}

#[test]
fn many_particles_are_checked() {
    let lattice = "[[particles]]\nmaterial = \"ball\"\nradius = 0.01\nlattice = { min = [-0.98, -0.98, -0.98], max = [0.98, 0.98, 0.98], spacing = 0.042 }\n";
    // All pairs would take minutes.
    let plan = planned(&(BALL.to_owned() + lattice));
    assert_eq!(plan.physics().particles.len(), 47usize.pow(3));
}

#[test]
fn periodic_axes_need_room_and_planes_must_not_cut_them() {
    let scene = BALL.to_owned()
        + "[[walls]]\nname = \"ramp\"\nshape = \"plane\"\npoint = [0, 0, -1]\nnormal = [0.6, 0, 0.8]\nmaterial = \"ball\"\n"
        + &particle("ball", 0.5, [0.0, 0.0, 0.9], "");
    assert!(planned_with(&format!("{HEAD}{scene}"), &[]).is_ok());
    let found = complaints_with(&scene, &["domain.periodic=[\"x\"]"]);
    assert_eq!(
        found,
        [
            "domain: the periodic axis x is too short: 2 m, at least 2.1 m are needed for particles of radius 0.5 m | \
             a particle must not touch another one and its image at once; enlarge the domain, or make the axis not periodic",
            "walls.ramp.normal: the plane cuts the periodic axis x: its normal has a component along x | \
             set that component to 0, or make the axis not periodic",
        ]
    );
}

#[test]
fn two_dimensions_are_flat() {
    let one = |z: f64, x: f64, more: &str| particle("ball", 0.1, [x, 0.0, z], more);
    let flat =
        BALL.to_owned() + &one(0.0, 0.0, "angular_velocity = [0, 0, 3]") + &one(0.0, 0.5, "");
    let text = format!("{HEAD}{flat}");
    let plan =
        planned_with(&text, &["domain.dimensions=2"]).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(plan.physics().dimensions, 2);
    // pi R^2 rho, m* = m/2
    let mass = std::f64::consts::PI * 0.01 * 1.909_859_317_102_744;
    let (k, gamma): (f64, f64) = (12496.02677090382, 17.83374719693662);
    let expected = std::f64::consts::PI / (k / (0.5 * mass) - (gamma / mass).powi(2)).sqrt();
    close(
        plan.notes()
            .step()
            .contact
            .as_ref()
            .expect("two discs")
            .time,
        expected,
        1e-12,
    );
    for (scene, overrides, message) in [
        (
            BALL.to_owned() + &one(0.0, 0.0, "") + &one(0.1, 0.5, ""),
            &["domain.dimensions=2"][..],
            "particles[1]: two dimensions: all centres must have the same z, particle 1 (particles[1]) has 0.1, particle 0 has 0",
        ),
        (
            BALL.to_owned() + &one(0.0, 0.0, "angular_velocity = [1, 0, 0]") + &one(0.0, 0.5, ""),
            &["domain.dimensions=2"],
            "particles[0]: two dimensions: particle 0 (particles[0]) moves or turns out of the plane | \
             velocities have x and y, angular velocities only z",
        ),
        (
            flat.clone(),
            &["domain.dimensions=2", "gravity=[0, 0, -9.81]"],
            "gravity: two dimensions: gravity along z must be 0, got -9.81",
        ),
    ] {
        assert_eq!(complaints_with(&scene, overrides), [message]);
    }
}

#[test]
fn fixed_particles_have_no_velocity() {
    let scene = BALL.to_owned()
        + &two("ball", 0.1)
        + &particle(
            "ball",
            0.1,
            [0.0, 0.9, 0.0],
            "fixed = true\nvelocity = [1, 0, 0]",
        );
    assert_eq!(
        complaints(&scene),
        [
            "particles[2].velocity: a fixed particle has a velocity | use `prescribed` instead of `fixed` for particles that move \
          in a given way"
        ]
    );
    let moved = BALL.to_owned()
        + &two("ball", 0.1)
        + &particle(
            "ball",
            0.1,
            [0.0, 0.9, 0.0],
            "prescribed = { velocity = [0.5, \"free\", \"free\"], angular_velocity = [\"free\", \"free\", \"free\"] }",
        );
    let plan = planned(&moved);
    assert_eq!(
        plan.physics().particles[2].prescribed_motion().velocity,
        [Some(0.5), None, None]
    );
    assert_eq!(plan.physics().particles[2].velocity.x, 0.5);
}

#[test]
fn lattices_have_both_ends_and_frozen_jitter() {
    let scene = |jitter: f64| {
        format!(
            "seed = 5\n{HEAD}{BALL}[[particles]]\nmaterial = \"ball\"\nradius = 0.01\n\
             lattice = {{ min = [0.0, 0.0, 0.3], max = [0.2, 0.1, 0.3], spacing = 0.1, jitter = {jitter:?} }}\n"
        )
    };
    let still = planned_with(&scene(0.0), &[]).expect("plans");
    assert_eq!(still.physics().particles.len(), 6);
    assert_eq!(
        still.physics().particles[1].position,
        glam::DVec3::new(0.1, 0.0, 0.3)
    );
    let (a, b) = (
        planned_with(&scene(0.01), &[]),
        planned_with(&scene(0.01), &[]),
    );
    let (a, b) = (a.expect("plans"), b.expect("plans"));
    assert_eq!(&a.physics().particles, &b.physics().particles);
    for (moved, site) in a.physics().particles.iter().zip(&still.physics().particles) {
        let shift = moved.position - site.position;
        assert!(shift.x != 0.0 && shift.y != 0.0 && shift.z == 0.0);
        assert!(shift.abs().max_element() <= 0.01);
    }
    let other = planned_with(&scene(0.01), &["seed=6"]).expect("plans");
    assert_ne!(&a.physics().particles, &other.physics().particles);
}

#[test]
fn a_region_in_which_nothing_can_be_is_an_error() {
    let region = |z: f64| {
        format!(
            "{BALL}[[regions]]\nname = \"top\"\nregion = {{ shape = \"sphere\", origin = [0, 0, {z:?}], radius = 0.5 }}\n"
        ) + &two("ball", 0.5)
    };
    assert_eq!(
        complaints(&region(5.0)),
        [
            "regions.top.region: the region \"top\" has no volume within the domain, so that nothing can ever be counted in it | \
          move it into the box of domain.min and domain.max; lengths are in metres"
        ]
    );
    let plan = planned(&region(0.0));
    assert_eq!(plan.outputs().regions()[0].name, "top");
    assert!((plan.outputs().regions()[0].volume - std::f64::consts::PI / 6.0).abs() < 1e-15);
    // Centred on the top face: half of it.
    let half = planned(&region(1.0)).outputs().regions()[0].volume;
    assert!((half - std::f64::consts::PI / 12.0).abs() < 1e-3 * half);
}

/// An insertion of balls of 0.1 m into a sphere of radius 0.3 m about the origin, and a wall.
fn inserted_beside(wall: &str, more: &str) -> String {
    format!(
        "{BALL}[[walls]]\nname = \"shield\"\nmaterial = \"ball\"\n{wall}\n[[insertions]]\nname = \"rain\"\nmaterial = \"ball\"\n\
         psd = {{ kind = \"monodisperse\", diameter = 0.1 }}\nregion = {{ shape = \"sphere\", origin = [0, 0, 0], radius = 0.3 }}\n\
         total = {{ number = 3 }}\n{more}"
    )
}

#[test]
fn a_region_behind_walls_is_an_error() {
    let refused = [
        "shape = \"sphere\"\norigin = [0, 0, 0]\nradius = 0.5\nside = \"outside\"",
        "shape = \"plane\"\npoint = [0, 0, 0.35]\nnormal = [0, 0, 1]",
        // All but a layer that is thinner than a ball.
        "shape = \"plane\"\npoint = [0, 0, 0.21]\nnormal = [0, 0, 1]",
    ];
    for wall in refused {
        let complaints = complaints(&inserted_beside(wall, ""));
        assert_eq!(
            complaints,
            [
                "insertions.rain.region: the region of \"rain\" lies behind or in walls, most of it `shield`: of 100000 random \
                 places in it none has space for a sphere of 0.1 m | \
                 move the region to the other side, or turn the wall round: a plane's normal points into the space of the \
                 particles, other shapes have a `side`"
            ],
            "{wall}"
        );
    }
    // One with an error of its own in front of it changes nothing of that.
    let broken = inserted_beside(refused[1], "").replace("name = \"rain\"", "name = \"dust\"");
    let broken = broken.replace("radius = 0.3", "radius = 0.01");
    let whole = inserted_beside(refused[1], "");
    let (_, entry) = whole.split_once("[[insertions]]").expect("an insertion");
    let complaints_of_both = complaints(&format!("{broken}[[insertions]]{entry}"));
    let behind = |complaint: &&String| complaint.contains("lies behind or in walls");
    let behind: Vec<&String> = complaints_of_both.iter().filter(behind).collect();
    assert!(
        behind.len() == 1 && behind[0].contains("the region of \"rain\""),
        "{complaints_of_both:?}"
    );
    assert!(complaints_of_both.len() > 1, "{complaints_of_both:?}");
    let taken = [
        // The other side; a cap that holds some; a wall that goes away.
        "shape = \"sphere\"\norigin = [0, 0, 0]\nradius = 0.5\nside = \"inside\"",
        "shape = \"plane\"\npoint = [0, 0, 0.1]\nnormal = [0, 0, 1]",
        "shape = \"plane\"\npoint = [0, 0, 0.35]\nnormal = [0, 0, 1]\nuntil = 0.1",
    ];
    // Centres lie in a ball of 0.25 m; above 0.15 m its cap of height h = 0.1 m is h^2 (0.75 - h) / (4 0.25^3) = 10.4 % of it. The share is right to
    // three standard errors of a thousand tries, 2.9 %.
    for (wall, share) in taken.iter().zip([0.0, 89.6, 0.0]) {
        let plan = planned(&inserted_beside(wall, ""));
        let warnings = plan.notes().warnings().iter();
        let percents = warnings.filter_map(|warning| {
            let rest = warning.strip_prefix("insertion \"rain\": ")?;
            let (percent, rest) = rest.split_once(" % of its region lie behind or in walls")?;
            assert!(rest.starts_with(", most of it `shield`,"), "{warning}");
            percent.parse::<f64>().ok()
        });
        let percent: f64 = percents.sum();
        assert!((percent - share).abs() < 2.9, "{wall}: {percent} %");
    }
}

#[test]
fn shares_that_do_not_sum_to_one_get_a_word() {
    let mixture = |shares: [f64; 2]| {
        let part = |share: f64, diameter: f64| {
            format!(
                "{{ material = \"ball\", psd = {{ kind = \"monodisperse\", diameter = {diameter:?} }}, share = {share:?} }}"
            )
        };
        format!(
            "{BALL}[[insertions]]\nname = \"rain\"\nmixture = [{}, {}]\n\
             region = {{ shape = \"sphere\", origin = [0, 0, 0], radius = 0.5 }}\ntotal = {{ number = 3 }}\n",
            part(shares[0], 0.1),
            part(shares[1], 0.2)
        )
    };
    let words = |shares| -> Vec<String> {
        let plan = planned(&mixture(shares));
        let about = |text: &&String| text.contains("shares");
        plan.notes()
            .warnings()
            .iter()
            .filter(about)
            .cloned()
            .collect()
    };
    assert_eq!(
        words([0.5, 0.4]),
        ["the shares of \"rain\" sum to 0.9, not to 1; they are scaled to 0.555556, 0.444444"]
    );
    assert_eq!(
        words([50.0, 40.0]),
        ["the shares of \"rain\" sum to 90, not to 100; they are scaled to 55.5556, 44.4444"]
    );
    assert!(words([3.0, 1.0]).is_empty());
    assert!(words([0.25, 0.75]).is_empty());
    assert!(words([0.333, 0.666]).is_empty());
}

#[test]
fn the_volume_of_a_region_in_two_dimensions_is_an_area() {
    let body = format!(
        "{BALL}[[regions]]\nname = \"round\"\nregion = {{ shape = \"sphere\", origin = [0, 0, 0.3], radius = 0.5 }}\n"
    ) + &two("ball", 0.5);
    let plan = planned_with(&format!("{HEAD}{body}"), &["domain.dimensions=2"])
        .unwrap_or_else(|errors| panic!("{errors}"));
    // The circle in which the plane z = 0 of the discs cuts the sphere has the radius 0.4 m.
    let area = std::f64::consts::PI * 0.16;
    assert!(
        (plan.outputs().regions()[0].volume / area - 1.0).abs() < 1e-3,
        "{}",
        plan.outputs().regions()[0].volume
    );
}

/// Errors of reader and plan for a scene, without advice; none for one that is right.
fn said_of(body: &str) -> Vec<String> {
    let text = format!("{HEAD}{body}");
    let read = parse_scene(Path::new("test.toml"), &text, &[], Files::MustExist);
    let errors = match read.map(|scene| plan(&scene)) {
        Ok(Ok(_)) => return Vec::new(),
        Ok(Err(errors)) | Err(errors) => errors.0,
    };
    let words =
        |error: &mercury_common::scene::SceneError| format!("{}: {}", error.path(), error.message);
    errors.iter().map(words).collect()
}

#[test]
fn of_the_servos_of_a_wall_one_acts_at_a_time() {
    let servo = "{ kind = \"servo\", axis = [0, 0, 1], force = 1.0, max_speed = 0.1 }";
    let body = format!(
        "{BALL}[[walls]]\nname = \"lid\"\nshape = \"plane\"\npoint = [0, 0, 1]\nnormal = [0, 0, -1]\nmaterial = \"ball\"\nmotion = [{servo}, {servo}]\n"
    ) + &two("ball", 0.5);
    assert_eq!(
        said_of(&body),
        [
            "walls.lid: motion: of the servos of a wall one acts at a time, yet the one from 0 s ends at inf s, after another has begun at 0 s; end it there with `until`, drive the wall by the sum of the forces, or split it"
        ]
    );
    let stages = body.replacen("max_speed = 0.1 }", "max_speed = 0.1, until = 0.5 }", 1);
    let last = stages.rfind("max_speed = 0.1 }").unwrap();
    let (first, second) = stages.split_at(last);
    let second = second.replacen("max_speed = 0.1 }", "max_speed = 0.1, from = 0.5 }", 1);
    assert_eq!(said_of(&format!("{first}{second}")), [""; 0]);
}

/// Targets of servos are given in one way, and a pressure needs an area.
#[test]
fn targets_of_servos_are_judged() {
    let reported = |shape: &str, target: &str| {
        let body = format!(
            "{BALL}[[walls]]\nname = \"lid\"\n{shape}\nmaterial = \"ball\"\nmotion = [{{ kind = \"servo\", axis = [0, 0, -1], {target}, max_speed = 0.1 }}]\n"
        ) + &two("ball", 0.5);
        said_of(&body)
    };
    let plane = "shape = \"plane\"\npoint = [0, 0, 1]\nnormal = [0, 0, -1]";
    for target in [
        "pressure = 1e3",
        "pressure = 1e3, area = 0.5",
        "pressure = [[0, 1e3], [1, 2e3]]",
        "force = [[0.0, 5.0]]",
    ] {
        assert_eq!(reported(plane, target), [""; 0], "{target}");
    }
    let sphere = "shape = \"sphere\"\norigin = [0, 0, 3]\nradius = 1\nside = \"outside\"";
    let key = "walls.lid.motion[0]";
    for (shape, target, expected) in [
        (
            sphere,
            "pressure = 1e3",
            format!(
                "{key}.pressure: needs an `area`: of planes, boxes and discs it follows from the shape, of this wall it does not"
            ),
        ),
        (
            "shape = \"disc\"\naxis = [1, 0, 0]\norigin = [0, 0, 0.9]\nradius = 0.1",
            "pressure = 1e3",
            format!("{key}.pressure: the disc has no area as seen along the axis of the servo"),
        ),
        (
            "shape = \"box\"",
            "pressure = 1e3",
            format!("{key}.pressure: the face -x has no area as seen along the axis of the servo"),
        ),
        (
            plane,
            "force = 1.0, pressure = 1e3",
            format!("{key}.force: cannot be given together with `pressure`: choose one"),
        ),
        (
            plane,
            "force = 1.0, area = 0.5",
            format!("{key}.area: cannot be given together with `force`: choose one"),
        ),
        (
            plane,
            "pressure = 1e3, area = 0.0",
            format!("{key}.area: must be > 0, got 0.0"),
        ),
        (
            plane,
            "force = []",
            format!("{key}.force: needs at least one row [t, load]"),
        ),
        (
            plane,
            "force = [[0, 1], [0, 2]]",
            format!("{key}.force: the times of its rows must increase, got 0 and then 0"),
        ),
        (
            plane,
            "force = [[0, 1, 2]]",
            format!("{key}.force[0]: expected 2 numbers, got 3"),
        ),
        (
            plane,
            "force = { table = \"no-such.csv\" }",
            format!("{key}.force.table: the file does not exist: "),
        ),
    ] {
        let reported = reported(shape, target);
        assert_eq!(reported.len(), 1, "{target}: {reported:?}");
        assert!(reported[0].starts_with(&expected), "{target}: {reported:?}");
    }
}

/// Spheres at one point, which are pairs without end: refused before they are listed, also where any overlap is allowed and where
/// nothing can move. 2,000 of them are 2 million pairs, of which 500 for each are looked at.
#[test]
fn crowds_are_refused_whatever_may_overlap() {
    let crowd = |more: &str, number: usize| {
        let one = particle("ball", 0.1, [0.1, 0.2, 0.3], more);
        one.repeat(number)
    };
    for (overrides, more, limit) in [
        (&[][..], "", "the limit is contact.overlap_error"),
        (
            &["contact.overlap_error=3"],
            "",
            "no more than 500 for each are listed",
        ),
        (
            &["contact.overlap_error=1.99"],
            "",
            "the limit is contact.overlap_error = 1.99",
        ),
        (&[], "fixed = true", "no more than 500 for each are listed"),
    ] {
        let found = complaints_with(&format!("{BALL}{}", crowd(more, 2000)), overrides);
        let is_it =
            |text: &String| text.contains("lie so close to each other") && text.contains(limit);
        assert!(found.iter().any(is_it), "{found:?}");
    }
    // Some hundred fixed ones may be anywhere, and some movable ones where that is meant.
    let few = format!("{BALL}{}{}", crowd("fixed = true", 300), two("ball", 0.2));
    assert!(planned_with(&format!("{HEAD}{few}"), &["contact.overlap_error=3"]).is_ok());
    let few = format!("{BALL}{}", crowd("", 100));
    assert!(planned_with(&format!("{HEAD}{few}"), &["contact.overlap_error=3"]).is_ok());
}

#[test]
fn materials_without_end_are_refused() {
    let materials = |number: usize| -> String {
        let one = |k| BALL.replace("materials.ball", &format!("materials.m{k}"));
        (0..number).map(one).collect::<String>() + &two("m0", 0.2)
    };
    assert!(planned_with(&format!("{HEAD}{}", materials(128)), &[]).is_ok());
    let found = complaints(&materials(5000));
    assert_eq!(
        found,
        [
            "materials.m128: there are 5000 materials | at most 128: one material may have any number of sizes"
        ]
    );
}

/// Insertions of these lines.
fn rain(lines: &str) -> String {
    format!(
        "{BALL}[[insertions]]\nname = \"rain\"\nregion = {{ shape = \"sphere\", origin = [0, 0, 0], radius = 0.5 }}\n{lines}\n"
    )
}

/// A quota rounds: half of a particle of 0.1 m weighs 1.90986 pi/6 1e-3 / 2 = 5e-4 kg; less than that is nothing, and there is a
/// warning.
#[test]
fn requests_that_bring_nothing_are_reported() {
    let about = |lines: &str| -> Vec<String> {
        let plan = planned(&rain(lines));
        let found = plan.notes().warnings().iter();
        found
            .filter(|text| text.contains("\"rain\""))
            .cloned()
            .collect()
    };
    let single = "material = \"ball\"\npsd = { kind = \"monodisperse\", diameter = 0.1 }\n";
    let quota = format!("{single}method = \"quota\"\n");
    assert_eq!(
        about(&format!("{quota}total = {{ mass = 1e-9 }}")),
        [
            "nothing of `ball` will come in \"rain\": of the total it is to have 1e-9 kg, below half of its smallest particle, 0.001 kg"
        ]
    );
    assert_eq!(
        about(&format!("{single}total = {{ mass = 1e-9 }}")),
        [
            "the total of \"rain\", 1e-9 kg, is below half of its smallest particle, 0.001 kg: one particle will come and exceed it"
        ]
    );
    assert!(about(&format!("{quota}total = {{ mass = 5.1e-4 }}")).is_empty());
    assert!(about(&format!("{single}total = {{ mass = 5.1e-4 }}")).is_empty());
    assert_eq!(
        about(&format!("{quota}total = {{ volume = 1e-9 }}")).len(),
        1
    );
    // Never active.
    assert_eq!(
        about(&format!("{single}total = {{ number = 3 }}\nfrom = 5.0")),
        ["\"rain\" inserts nothing: it begins at 5 s, and the run ends at 1 s"]
    );
    assert_eq!(
        about(&format!(
            "{single}total = {{ number = 3 }}\nfrom = 0.5\nuntil = 0.5"
        )),
        ["\"rain\" inserts nothing: it ends at 0.5 s, when it begins"]
    );
    // The rare part of a mixture.
    let mixture = "mixture = [{ material = \"ball\", psd = { kind = \"monodisperse\", diameter = 0.1 }, share = 0.99 },\n\
                   { material = \"ball\", psd = { kind = \"monodisperse\", diameter = 0.2 }, share = 0.01 }]\n\
                   share_by = \"number\"\nmethod = \"quota\"\n";
    assert_eq!(
        about(&format!("{mixture}total = {{ number = 10 }}")),
        ["nothing of `ball` will come in \"rain\": its share of 10 particles is 0.1"]
    );
    assert!(about(&format!("{mixture}total = {{ number = 100 }}")).is_empty());
}

/// Particles that pass the finest sieve have no smallest size: the message names the pan, and gives advice.
#[test]
fn a_distribution_down_to_nothing_is_refused_by_name() {
    let classes = "material = \"ball\"\ntotal = { number = 3 }\n\
                   psd = { kind = \"classes\", diameters = [0, 0.1, 0.2], shares = [1, 3], weighting = \"volume\" }\n";
    let found = complaints(&rain(classes));
    let [message] = &found[..] else {
        panic!("{found:?}")
    };
    assert!(
        message.contains("has no smallest particle, so that no time step is short enough | the class below 0.1 m (the pan, where sieves were used) holds 25 % by volume"),
        "{message}"
    );
    assert!(message.contains("cut = [0.01, 1] in a scene"), "{message}");
    let cut = classes.replace("\"volume\" }", "\"volume\", cut = [0.01, 1] }");
    planned(&rain(&cut));
}
