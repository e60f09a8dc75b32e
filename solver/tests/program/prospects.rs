//! Runs that cannot give a useful result, as can be predicted before they start.

use std::fs;
use std::process::Command;

/// A hundred grains that fall in a domain of 0.1 m.
const SCENE: &str = r#"
gravity = [0, 0, -9.81]
time = { end = 0.5, step = 2e-5 }
domain = { min = [0, 0, 0], max = [0.1, 0.1, 0.1] }
materials.m = { density = 2500.0, normal = { law = "linear", stiffness = 100, restitution = 0.5 } }
output = { interval = 0.5, pictures = false }
[[insertions]]
name = "rain"
region = { shape = "box", min = [0.01, 0.01, 0.05], max = [0.09, 0.09, 0.09] }
material = "m"
psd = { kind = "monodisperse", diameter = 2e-3 }
total = { number = 100 }
"#;

const BOX: &str = "[[walls]]\nname = \"box\"\nshape = \"box\"\nmaterial = \"m\"\n";

/// Warnings of the plan, and those of the run.
fn warnings(text: &str) -> [Vec<String>; 2] {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.toml"), text).unwrap();
    ["--check", "--quiet"].map(|how| {
        let output = Command::new(env!("CARGO_BIN_EXE_mercury-solve"))
            .current_dir(folder.path())
            .args(["a.toml", "--json", how])
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{said}");
        let reported: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        serde_json::from_value(reported["warnings"].clone()).unwrap()
    })
}

/// All of a hundred grains fell out of a domain without walls, and there was no message.
#[test]
fn that_nothing_holds_the_particles_is_said_before_and_after() {
    let [before, after] = warnings(SCENE);
    let reported = "gravity: nothing holds the particles, all of which fall out of the domain through its face -z";
    assert!(
        before.len() == 1 && before[0].starts_with(reported),
        "{before:?}"
    );
    assert_eq!(
        after[0],
        "no particle is left: 100 through the face -z of the domain"
    );
    assert!(after[1].starts_with(reported), "{after:?}");

    // Upwards it is the other face; without an end of the domain, in a box, or for a time in which no particle falls that far, it
    // is none.
    let upwards = SCENE.replace("-9.81", "9.81");
    assert!(warnings(&upwards)[0][0].contains("through its face +z"));
    let periodic = SCENE.replace("domain = {", "domain = { periodic = [\"z\"],");
    let in_a_box = format!("{SCENE}{BOX}");
    // In 0.09 s it is 4 cm.
    let short = SCENE.replace("end = 0.5", "end = 0.09");
    for text in [periodic, in_a_box, short] {
        assert_eq!(warnings(&text), [[""; 0]; 2], "{text}");
    }
}

#[test]
fn an_insertion_into_which_gravity_was_forgotten_is_reported() {
    let without = SCENE.replace("gravity = [0, 0, -9.81]", "");
    let [before, _] = warnings(&format!("{without}{BOX}"));
    let reported = "insertions.rain: without gravity, velocity and moving walls";
    assert!(
        before.len() == 1 && before[0].starts_with(reported),
        "{before:?}"
    );
    let thrown = without.replace("total =", "velocity = { mean = [0, 0, -0.1] }\ntotal =");
    assert_eq!(warnings(&format!("{thrown}{BOX}"))[0], [""; 0]);
    let stirred = BOX.to_owned()
        + "motion = [{ kind = \"rotation\", axis = [0, 0, 1], origin = [0, 0, 0], angular_velocity = 1 }]";
    assert_eq!(warnings(&format!("{without}{stirred}"))[0], [""; 0]);
}

/// A lid whose force has the wrong sign flew out of the domain, and the run reported at its end that the target was not reached.
#[test]
fn a_servo_that_drives_its_wall_away_is_reported() {
    let lid = |servos: &str| {
        format!(
            "{SCENE}{BOX}sides = [\"-x\", \"+x\", \"-y\", \"+y\", \"-z\"]\n[[walls]]\nname = \"lid\"\nshape = \"plane\"\npoint = [0, 0, 0.1]\nnormal = [0, 0, -1]\nmaterial = \"m\"\nmotion = [{servos}]\n"
        )
        .replace("end = 0.5", "end = 1e-3")
    };
    let servo = |axis: &str, load: &str, window: &str| {
        format!("{{ kind = \"servo\", axis = {axis}, {load}, max_speed = 0.01{window} }}")
    };
    let up = "[0, 0, 1]";
    let reported = "walls.lid: its servo has to push along [0, 0, 1], but it can only push along its normal [0, 0, -1]: it will be driven away from the particles at its max_speed; turn the sign of the load, or the axis";
    for wrong in [
        servo(up, "force = 20", ""),
        servo("[0, 0, -2]", "force = -20", ""),
        servo(up, "pressure = \"1 kPa\"", ""),
        servo(up, "force = [[0, 0], [0.1, 20]]", ""),
    ] {
        let [before, _] = warnings(&lid(&wrong));
        assert_eq!(before, [reported], "{wrong}");
    }
    let turned =
        "{ kind = \"rotation\", axis = [1, 0, 0], origin = [0, 0, 0.1], angular_velocity = 1 }";
    let lifted = servo(up, "force = 20", ", from = 0.1");
    for right in [
        servo(up, "force = -20", ""),
        // Held by friction.
        servo("[1, 0, 0]", "force = 1", ""),
        servo("[0.1, 0, 1]", "force = 1", ""),
        // Pressed first, then lifted.
        servo(up, "force = [[0, -20], [0.1, 20]]", ""),
        format!("{}, {lifted}", servo(up, "force = -20", ", until = 0.1")),
        servo(up, "force = 0", ""),
        format!("{turned}, {lifted}"),
    ] {
        let [before, _] = warnings(&lid(&right));
        assert_eq!(before, [""; 0], "{right}");
    }
    // A grain that sticks to the lid can be pulled.
    let plastic = "law = \"plastic\", loading_stiffness = 100, unloading_stiffness = 200, cohesion_stiffness = 50, penetration_depth = 0.1";
    let sticky = lid(&servo(up, "force = 20", "")).replace(
        "law = \"linear\", stiffness = 100, restitution = 0.5",
        plastic,
    );
    assert_eq!(warnings(&sticky)[0], [""; 0]);
    let smooth = sticky.replace("cohesion_stiffness = 50", "cohesion_stiffness = 0");
    assert_eq!(warnings(&smooth)[0], [reported]);
}

/// A lid that acts on both sides and comes down while grains come: some are placed above it. It is named before the run, and they are counted in it.
#[test]
fn a_wall_that_closes_a_region_is_named_and_what_is_behind_it_counted() {
    const SIDES: &str = "sides = [\"-x\", \"+x\", \"-y\", \"+y\", \"-z\"]\n";
    // A hundred grains in 0.1 s; the lid comes from above the region, at 0.09 m, to 0.048 m in this time.
    let slow = SCENE
        .replace("total =", "rate = { number = 1000 }\ntotal =")
        .replace("end = 0.5", "end = 0.12");
    let lid = |shape: &str, motion: &str| {
        format!(
            "{BOX}{SIDES}[[walls]]\nname = \"lid\"\n{shape}\nmaterial = \"m\"\nmotion = [{{ {motion} }}]\n"
        )
    };
    let disc = "shape = \"disc\"\naxis = [0, 0, 1]\norigin = [0.05, 0.05, 0.098]\nradius = 0.08";
    let plane = "shape = \"plane\"\npoint = [0, 0, 0.098]\nnormal = [0, 0, -1]";
    let down = "kind = \"translation\", velocity = [0, 0, -0.5], until = 0.1";
    let named = "walls.lid: it acts on both sides and moves through the region of \"rain\" while that inserts";

    let scene = format!("{slow}{}", lid(disc, down));
    let [before, after] = warnings(&scene);
    assert!(
        before.len() == 1 && before[0].starts_with(named),
        "{before:?}"
    );
    assert!(before[0].contains("use a plane") && before[0].contains("`until`"));
    let counted = after
        .iter()
        .find(|text| text.contains("were placed behind the wall `lid`"));
    let counted = counted.unwrap_or_else(|| panic!("{after:?}"));
    // The region has 0.04 m. At the time t the lid is at 0.098 - 0.5 t, and the share (0.5 t - 0.009)/0.038 of the centres lie above it, up to 1
    // at 0.094 s: 0.5 (0.094 - 0.018)/0.1 of the hundred in the mean and 6 later, 44, with a deviation of 5 at most.
    let number: f64 = counted
        .split(['`', ' '])
        .find_map(|word| word.parse().ok())
        .unwrap();
    assert!((number - 44.0).abs() < 20.0, "{counted}");

    // A servo moves it down as fast as it may.
    let servo = "kind = \"servo\", axis = [0, 0, 1], force = -0.01, max_speed = 0.5";
    assert!(warnings_before(&format!("{slow}{}", lid(disc, servo)))[0].starts_with(named));
    // A plane lets nothing be placed behind it; a paddle has no side from which it came; the lid comes when all have come at once, or when the
    // insertion is over; or it stays above the region.
    let paddle =
        "kind = \"rotation\", axis = [1, 0, 0], origin = [0, 0, 0.07], angular_velocity = 100";
    let early = slow.replace("total =", "until = 0.01\ntotal =");
    let high = "kind = \"translation\", velocity = [0, 0, -0.5], until = 0.005";
    for scene in [
        format!("{slow}{}", lid(plane, down)),
        format!("{slow}{}", lid(disc, paddle)),
        format!("{SCENE}{}", lid(disc, down)),
        format!("{early}{}", lid(disc, down)),
        format!("{slow}{}", lid(disc, high)),
    ] {
        assert_eq!(warnings_before(&scene), [""; 0], "{scene}");
    }
}

/// Warnings of the plan.
fn warnings_before(text: &str) -> Vec<String> {
    reported_before("warnings", text)
}

/// Remarks or warnings of the plan.
fn reported_before(what: &str, text: &str) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.toml"), text).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_mercury-solve"))
        .current_dir(folder.path())
        .args(["a.toml", "--json", "--check"])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    let reported: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    serde_json::from_value(reported[what].clone()).unwrap()
}

/// With a spring against rolling and without a dashpot a grain swings about its rest: it never comes to rest.
#[test]
fn rolling_without_dissipation_is_noted() {
    let with = |rolling: &str| {
        let friction = "tangential = { law = \"linear\", stiffness_ratio = 0.3, friction = 0.5 }";
        let laws = format!("restitution = 0.5 }}, {friction}, {rolling} }}");
        let scene = SCENE.replace("restitution = 0.5 } }", &laws);
        assert_ne!(scene, SCENE);
        reported_before("notes", &format!("{scene}{BOX}"))
    };
    let noted = with("rolling = { law = \"luding\", friction = 0.1 }");
    assert!(
        noted.len() == 1 && noted[0].starts_with("m and m: rolling has no `dissipation`"),
        "{noted:?}"
    );
    assert_eq!(
        with("rolling = { law = \"luding\", friction = 0.1, dissipation = 1e-4 }"),
        [""; 0]
    );
    assert_eq!(
        with("rolling = { law = \"luding\", friction = 0.0 }"),
        [""; 0]
    );
}

/// Grains of 4 m of 2.5 kg/m3 in a box of 60 m ran without a word.
#[test]
fn forgotten_units_are_noted_once() {
    let scene = "time = { end = 1e-3, step = 1e-5 }\ndomain = { min = [0, 0, 0], max = [60, 60, 60] }\n\
        materials.m = { density = 2.5, normal = { law = \"linear\", stiffness = 1e7, restitution = 0.5 } }\n\
        output = { interval = 1e-3 }\n[[particles]]\nmaterial = \"m\"\nradius = 2\nposition = [30, 30, 30]\n";
    let noted = reported_before("notes", scene);
    assert_eq!(noted.len(), 1, "{noted:?}");
    for part in ["4 m in diameter", "2.5 kg/m3", "a domain of 60 m"] {
        assert!(noted[0].contains(part), "{noted:?}");
    }
    let in_si = scene
        .replace("radius = 2", "radius = 2e-3")
        .replace("2.5,", "2500,")
        .replace("60", "0.06")
        .replace("30", "0.03");
    assert_eq!(reported_before("notes", &in_si), [""; 0]);
}

/// 400 bytes a grain, a hundred grains, a frame in each of 2.5e10 steps: a petabyte.
#[test]
fn output_larger_than_the_disk_is_a_warning() {
    let long = SCENE
        .replace("end = 0.5", "end = 5e5")
        .replace("interval = 0.5", "interval = 2e-5");
    let found = warnings_before(&format!("{long}{BOX}"));
    let of_disk = found
        .iter()
        .filter(|text| text.contains("and the disk of a has"));
    assert_eq!(of_disk.count(), 1, "{found:?}");
    let found = warnings_before(&format!("{SCENE}{BOX}"));
    assert_eq!(found, [""; 0]);
}
