//! The plan for people and for programs.

use super::super::{document, passes, report};
use super::*;
use crate::run::memory;
use mercury_engine::boundaries::{Rate, Total};

const SCENE: &str = "title = \"Rain\"\ngravity = [0, 0, -9.81]\n\
    [time]\nend = 0.1\nstep = 1e-6\n[domain]\nmin = [0, 0, 0]\nmax = [0.04, 0.04, 0.12]\n[output]\ninterval = 0.01\ndata = false\nrestart_interval = 0.05\n\
    [materials.glass]\ndensity = 2500.0\n\
    normal = { law = \"hertz\", youngs_modulus = 1e7, poisson_ratio = 0.25, restitution = 0.7 }\n\
    tangential = { law = \"mindlin\", friction = 0.5 }\n\
    [materials.lead]\ndensity = 10000.0\n\
    normal = { law = \"hertz\", youngs_modulus = 1e7, poisson_ratio = 0.25, restitution = 0.7 }\n\
    tangential = { law = \"mindlin\", friction = 0.5 }\n\
    [[walls]]\nname = \"box\"\nshape = \"box\"\nmaterial = \"glass\"\nuntil = 0.05\n\
    [[insertions]]\nname = \"rain\"\nregion = { shape = \"box\", min = [0.01, 0.01, 0.01], max = [0.03, 0.03, 0.1] }\n\
    mixture = [{ material = \"glass\", psd = { kind = \"monodisperse\", diameter = 2e-3 }, share = 0.5 }, \
    { material = \"lead\", psd = { kind = \"monodisperse\", diameter = 1e-3 }, share = 0.5 }]\n\
    share_by = \"mass\"\ntotal = { mass = 0.01 }\nrate = { mass = 1.0 }\n";

#[test]
fn mixtures_by_mass_become_shares_of_number() {
    let plan = planned_with(SCENE, &[]).unwrap_or_else(|errors| panic!("{errors}"));
    let insertion = &plan.physics().insertions[0];
    // Masses per particle 2500 (2 mm)^3 : 10000 (1 mm)^3 = 2 : 1, so half the mass each is 1 : 2 particles.
    close(insertion.mixture[0].share, 1.0 / 3.0, 1e-12);
    close(insertion.mixture[1].share, 2.0 / 3.0, 1e-12);
    assert_eq!(insertion.total, Some(Total::Mass(0.01)));
    assert!(matches!(insertion.rate, Some(Rate::Steady { .. })));
    // by volume 8 : 1
    let plan = planned_with(SCENE, &["insertions.rain.share_by=volume"]).expect("plans");
    close(
        plan.physics().insertions[0].mixture[0].share,
        1.0 / 9.0,
        1e-12,
    );
    let plan = planned_with(SCENE, &["insertions.rain.share_by=number"]).expect("plans");
    close(plan.physics().insertions[0].mixture[0].share, 0.5, 1e-12);
    assert_eq!(
        (
            plan.physics().smallest_radius(),
            plan.physics().largest_radius()
        ),
        (5e-4, 1e-3)
    );
    close(plan.physics().mean_radius(), 7.5e-4, 1e-12);
}

#[test]
fn the_report_says_what_is_done_and_what_is_skipped() {
    let plan = planned_with(SCENE, &[]).unwrap_or_else(|errors| panic!("{errors}"));
    let text = report(&plan, &memory(&plan), None);
    for line in [
        "Rain",
        "  domain                  [0, 0, 0] to [0.04, 0.04, 0.12] m",
        "  box.-x                  glass, until 0.05 s",
        "  glass - lead (particles and walls)",
        "    normal.restitution                  0.7                   mixed",
        "    tangential.static_friction          0.5                   = friction",
        "  contact loop            hertz, mindlin, no rolling (compiled together)",
        "  rolling and torsion     no pair has rolling or torsion resistance",
        "  orientations            nothing writes them",
    ] {
        assert!(
            text.lines().any(|l| l == line),
            "no line {line:?} in\n{text}"
        );
    }
    assert!(!plan.physics().orientations);
    // Done and skipped together are all.
    let (done, skipped): (Vec<_>, Vec<_>) =
        passes(&plan).into_iter().partition(|pass| pass.is_done);
    let place = |heading: &str| text.find(heading).unwrap_or_else(|| panic!("no {heading}"));
    let (first, second) = (
        place("What is done in a step"),
        place("What is skipped, and why"),
    );
    for (list, range) in [(done, first..second), (skipped, second..text.len())] {
        for pass in list {
            assert!(text[range.clone()].contains(pass.name), "{}", pass.name);
        }
    }
}

#[test]
fn the_document_reads_back() {
    let plan = planned_with(SCENE, &["seed=9223372036854775807"])
        .unwrap_or_else(|errors| panic!("{errors}"));
    let text = document(&plan, &memory(&plan)).expect("TOML");
    let read: toml::Table = text.parse().expect("TOML");
    assert_eq!(read["time"]["step"].as_float(), Some(1e-6));
    assert_eq!(read["time"]["steps"].as_integer(), Some(100_000));
    assert_eq!(read["seed"].as_str(), Some("9223372036854775807"));
    let contacts = read["contacts"].as_array().expect("a list");
    assert_eq!(contacts.len(), 3);
    let damping = &contacts[1]["parameters"]["normal.damping"];
    assert_eq!(
        damping["value"].as_float(),
        Some(number(&plan, ["glass", "lead"], "normal.damping"))
    );
    assert_eq!(damping["from"].as_str(), Some("mixed"));
    assert_eq!(read["walls"].as_array().map(Vec::len), Some(6));
    assert_eq!(
        read["insertions"][0]["mixture"][1]["material"].as_str(),
        Some("lead")
    );
}

#[test]
fn keys_that_change_nothing_are_warned_of() {
    let text = SCENE.replace(
        "restart_interval = 0.05\n",
        "restart_interval = 0.05\nene = false\nwalls = false\nrows_interval = 0.01\nvtk_interval = 0.01\nfstat_interval = 0.01\ntrack_interval = 0.01\n",
    );
    let plan = planned_with(&text, &[]).unwrap_or_else(|errors| panic!("{errors}"));
    let expected = [
        "output.fstat_interval: nothing is written at these times, as output.fstat is false; set fstat = true or leave the key out",
        "output.vtk_interval: nothing is written at these times, as output.vtk is false; set vtk = true or leave the key out",
        "output.rows_interval: no table has rows at these times, as output.ene and output.walls are false and the scene has no [[regions]] and [[fluxes]]; set ene = true or leave the key out",
        "output.track_interval: nothing is followed, as output.track is empty; name particles or insertions in it, or leave the key out",
    ];
    let warnings: Vec<&str> = plan.notes().warnings().iter().map(String::as_str).collect();
    assert_eq!(warnings, expected);
    let written = &[
        "output.ene=true",
        "output.vtk=true",
        "output.fstat=true",
        "output.track=[\"rain\"]",
    ];
    let plan = planned_with(&text, written).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(plan.notes().warnings(), [""; 0]);
}

/// Where nothing is there at the start, a width in diameters is one of the grains that come: 1/3 of 2 mm and 2/3 of 1 mm.
#[test]
fn widths_of_fields_are_in_diameters_of_what_comes() {
    let mean = (2e-3 + 2.0 * 1e-3) / 3.0;
    for (width, expected) in [
        ("", mean),
        ("width = \"1.5d\"\n", 1.5 * mean),
        ("width = 0.004\n", 4e-3),
    ] {
        let fields = "[[fields]]\nname = \"profile\"\ncoordinates = \"Z\"\ngrid = [10]\n";
        let plan = planned_with(&format!("{SCENE}{fields}{width}"), &[]);
        let plan = plan.unwrap_or_else(|errors| panic!("{errors}"));
        let kernel = &plan.outputs().files().fields[0].analysis.evaluator.kernel;
        close(kernel.width, expected, 1e-12);
    }
}

/// Bonds of the start and their ends at walls are counted, glue at touches has its time.
#[test]
fn the_report_says_what_is_glued() {
    let text = "time = { end = 0.1, step = 1e-6 }\ndomain = { min = [-1, -1, -1], max = [1, 1, 1] }\noutput = { interval = 0.01 }\n\
        [materials.m]\ndensity = 2500.0\nnormal = { law = \"linear\", stiffness = 1e3, restitution = 0.7 }\n\
        [[walls]]\nname = \"floor\"\nshape = \"plane\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nmaterial = \"m\"\n\
        [[particles]]\nmaterial = \"m\"\nradius = 1e-3\nposition = [0, 0, 1e-3]\n\
        [[particles]]\nmaterial = \"m\"\nradius = 1e-3\nposition = [0, 0, 3e-3]\n\
        [[bonds]]\nlaw = \"beam\"\nyoungs_modulus = 1e7\nwalls = [\"floor\"]\n\
        [[bonds]]\nname = \"later\"\nlaw = \"beam\"\nyoungs_modulus = 1e6\nwhen = \"contact\"\nfrom = 0.05\n";
    let plan = planned_with(text, &[]).unwrap_or_else(|errors| panic!("{errors}"));
    let text = report(&plan, &memory(&plan), None);
    for line in [
        "\nBonds\n",
        "  bond-1                  2 bonds at the start, 1 of them to walls; critical step ",
        "  later                   pairs that touch from 0.05 s; critical step ",
    ] {
        assert!(text.contains(line), "no \"{line}\" in\n{text}");
    }
}
