//! Particles of a run against the distributions of its plan.

use super::*;

/// A run folder as the solver leaves it: spheres and clumps by random sizes, one sphere that was there at the start, one fixed.
fn run_folder(at: &Path, spheres: &SizeDistribution, rods: &SizeDistribution) {
    std::fs::create_dir(at).expect("a folder");
    let header = FramesHeader {
        materials: vec!["grain".into(), "sand".into()],
        ..FramesHeader::default()
    };
    let columns = ParticleColumns::default();
    let mut writer =
        ParticleWriter::create(at.join("x.particles.arrow"), &header, &columns).expect("a file");
    let sizes = draw(spheres, 2000, Method::Random, 7);
    for (step, number) in [(0_u32, 1200), (1, 2000)] {
        // Those that come first leave first: the check must see all.
        let from = if step == 1 { 300 } else { 0 };
        let mut frame = ParticleFrame {
            time: f64::from(step),
            step: step.into(),
            ..ParticleFrame::default()
        };
        let mut push = |id: u32, diameter: f64, flags: u8| {
            let volume = std::f64::consts::PI / 6.0 * diameter.powi(3);
            frame.id.push(id);
            frame.material.push(0);
            frame.flags.push(flags);
            frame.mass.push(1400.0 * volume);
            frame.volume.push(volume);
            frame.radius.push(0.5 * diameter);
            // Large ones lie below.
            frame.position.push(DVec3::new(0.0, 0.0, -diameter));
            frame.velocity.push(DVec3::ZERO);
        };
        push(0, 1.0, 0);
        push(1, 1.0, FLAG_FIXED);
        for (i, d) in sizes[from..number].iter().enumerate() {
            push((2 + from + i) as u32, *d, 0);
        }
        writer.append(frame).expect("written");
    }
    let kinds = vec![ClumpKind {
        name: "rod".into(),
        surface: None,
    }];
    let mut writer =
        BodyWriter::create(at.join("x.bodies.arrow"), &header, &kinds).expect("a file");
    let volumes: Vec<f64> = draw(rods, 1000, Method::Random, 8)
        .iter()
        .map(|d| std::f64::consts::PI / 6.0 * d.powi(3))
        .collect();
    let n = volumes.len();
    writer
        .append(BodyFrame {
            time: 1.0,
            step: 1,
            id: (0..n as u32).collect(),
            clump: vec![0; n],
            material: vec![1; n],
            flags: vec![0; n],
            mass: volumes.iter().map(|v| 2600.0 * v).collect(),
            volume: volumes,
            scale: vec![1.0; n],
            radius: vec![1.0; n],
            position: vec![DVec3::ZERO; n],
            velocity: vec![DVec3::ZERO; n],
            orientation: vec![glam::DQuat::IDENTITY; n],
            angular_velocity: vec![DVec3::ZERO; n],
            principal_moments: vec![DVec3::ONE; n],
            force: vec![DVec3::ZERO; n],
            torque: vec![DVec3::ZERO; n],
        })
        .expect("written");
    drop(writer);
    let part = |name: &str, clump: &str, sizes: &SizeDistribution, share: f64| {
        let psd: String = sizes
            .statement()
            .to_string()
            .lines()
            .map(|line| format!("{line}\n"))
            .collect();
        format!(
            "[[insertions.mixture]]\nmaterial = \"{name}\"\n{clump}number_share = {share:?}\n[insertions.mixture.psd]\n{psd}"
        )
    };
    let plan = format!(
        "[particles]\nat_start = 2\n[[materials]]\nname = \"grain\"\ndensity = 1400.0\n[[materials]]\nname = \"sand\"\ndensity = 2600.0\n\
         [[insertions]]\nname = \"feed\"\n[insertions.total]\nnumber = 3000.0\n{}{}",
        part("grain", "", spheres, 2.0 / 3.0),
        part("sand", "clump = \"rod\"\n", rods, 1.0 / 3.0),
    );
    std::fs::write(at.join("plan.toml"), plan).expect("written");
}

fn law(text: &str) -> SizeDistribution {
    SizeDistribution::from_scene(&parse_psd("law", text, None).expect("a law")).expect("sizes")
}

#[test]
fn runs_are_checked_against_their_plan() {
    let folder = folder();
    let at = folder.path();
    let spheres =
        law("kind = \"uniform\"\nmin_diameter = 1e-3\nmax_diameter = 2e-3\nweighting = \"volume\"");
    let rods =
        law("kind = \"lognormal\"\nmedian_diameter = 3e-3\nsigma = 0.2\nweighting = \"volume\"");
    run_folder(&at.join("x"), &spheres, &rods);
    let value = json(at, &["check", "x", "--json"]);
    assert_eq!(value["passed"], true);
    assert_eq!(value["kinds"]["grain"]["number"], 2000);
    assert_eq!(value["kinds"]["rod"]["number"], 1000);
    // 2000 of 2000 grains: their mass is that of the request up to the spread of 2000 random ones (some per cent).
    let masses = ["mass", "requested_mass"]
        .map(|key| value["kinds"]["grain"][key].as_f64().expect("a mass"));
    assert!((masses[0] / masses[1] - 1.0).abs() < 0.1, "{masses:?}");
    let report = done(at, &["check", "x"]);
    assert!(report.contains("expected for the total"), "{report}");
    // At the end 300 have left; above 1.5 mm deep lie the large ones.
    let value = json(at, &["check", "x", "--of", "grain", "--at", "1", "--json"]);
    assert_eq!(value["kinds"]["grain"]["number"], 1700);
    let split = [
        "check",
        "x",
        "--of",
        "grain",
        "--where",
        "z<-1.5e-3",
        "--versus-where",
        "z>=-1.5e-3",
    ];
    let output = psd(at, &split);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("the two differ"));
    let report = done(at, &words("check x --of grain --at 0 --versus-at 1"));
    assert!(report.contains("1200 against 1700 particles"), "{report}");
    // Against a wrong target.
    let output = psd(
        at,
        &["check", "x", "--of", "rod", "--target", "grain.psd.csv"],
    );
    assert_eq!(output.status.code(), Some(1));
    done(at, &["stats", "x"]);
    for (arguments, message) in [
        (
            &["check", "x", "--of", "glass"][..],
            "no particles of \"glass\"",
        ),
        (
            &["check", "x", "--target", "grain.psd.csv"],
            "choose one with --of",
        ),
        (
            &["check", "x", "--at", "7"],
            "no frame at 7 s: the run goes from 0 to 1 s",
        ),
        (&["check", "x", "--where", "r<1"], "is no condition"),
        (
            &["check", "."],
            "no run: there is no file *.particles.arrow",
        ),
        (&["check", "missing"], "cannot be read"),
        (&["convert", "x"], "several kinds of particles"),
    ] {
        let found = refused(at, arguments);
        assert!(found.contains(message), "{arguments:?}: {found}");
    }
    std::fs::remove_file(at.join("x/plan.toml")).expect("removed");
    let message = refused(at, &["check", "x", "--of", "grain"]);
    assert!(message.contains("no single distribution"), "{message}");
}
