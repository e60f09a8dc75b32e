use glam::DVec3;

use super::*;

const BOX: (DVec3, DVec3) = (DVec3::new(-1.0, 0.0, 2.0), DVec3::new(3.0, 2.0, 4.0));

#[test]
fn the_view_is_that_of_mercury_dpm() {
    // Largest of 4 along x and 2 along z; offsets int(500 (0 - min)/(max - min)): 125 along x, -500 along z.
    let script = Script::for_domain("run.data".into(), 3, BOX);
    assert_eq!(
        script.to_text(),
        "#!/bin/bash\n\
         cd \"$(dirname \"$0\")\" || exit 1\n\
         \"${XBALLS:-xballs}\" -format 14 -f 'run.data' -s 0.3 -cmode 8 -cmax -sort -oh 125 -mo 500 \"$@\"\n"
    );
    // In two dimensions y is up: 1/4, and no offset along y.
    let script = Script::for_domain("it's.data".into(), 2, BOX);
    let expected =
        "-format 8 -f 'it'\\''s.data' -s 0.25 -cmode 8 -cmax -sort -oh 125 -o 0 \"$@\"\n";
    assert!(script.to_text().ends_with(expected), "{}", script.to_text());
    let flat = Script::for_domain("a".into(), 3, (DVec3::ONE, DVec3::ONE));
    assert_eq!((flat.scale, flat.offset), (1.0, [0, 0]));
}

#[test]
fn scripts_read_back() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["run.data", "it's a \"run\".data"] {
        let path = folder.path().join("run.disp");
        let script = Script::for_domain(name.into(), 3, BOX);
        std::fs::write(&path, script.to_text()).unwrap();
        let expected = Script {
            data: folder.path().join(name),
            ..script
        };
        assert_eq!(Script::read(&path), Ok(expected));
    }
}

#[test]
fn a_script_of_an_old_mercury_is_understood() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hopper.disp");
    // The form of scripts of about 2010, with options that only the viewer knows.
    let text = "#!/bin/bash\nx=$(echo $0 | cut -c2-)\nfile=$PWD$x\ncd $dirname\n\
        ../xballs -format 14 -f hopper.data -s 0.02 -cmode 4 -cmax -scala 4 -sort -solidf -moh 200 -p 20 $*\n";
    std::fs::write(&path, text).unwrap();
    let expected = Script {
        data: folder.path().join("hopper.data"),
        format: 14,
        scale: 0.02,
        offset: [-200, 0],
        colour_mode: 4,
    };
    assert_eq!(Script::read(&path), Ok(expected));
    for (text, message) in [
        (
            "xballs -f\n",
            "hopper.disp:1: -f without a file behind it, expected FILE.data",
        ),
        (
            "xballs -f a.data -s big\n",
            "hopper.disp:1: big behind -s, expected a number",
        ),
        ("# xballs -f a.data\n", "hopper.disp: no command for XBalls"),
    ] {
        std::fs::write(&path, text).unwrap();
        let error = Script::read(&path).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
}
