use mercury_common::formats::data::DataReader;
use proptest::prelude::*;

use super::*;
use crate::{FrameChoice, Source};

fn finite() -> impl Strategy<Value = f64> {
    any::<u64>()
        .prop_map(f64::from_bits)
        .prop_filter("finite", |v| v.is_finite())
}

fn vector() -> impl Strategy<Value = DVec3> {
    [finite(), finite(), finite()].prop_map(DVec3::from_array)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// `.data`, read as a source and written again, is the same text.
    #[test]
    fn data_goes_round_exactly(
        rows in proptest::collection::vec((vector(), vector(), finite(), vector(), vector(), finite()), 0..6),
        corners in (vector(), vector()),
        time in finite(),
        flat: bool,
    ) {
        let frame = DataFrame {
            time,
            dimensions: if flat { 2 } else { 3 },
            min: corners.0,
            max: corners.1,
            particles: rows
                .into_iter()
                .map(|(position, velocity, radius, angles, angular_velocity, info)| DataRow {
                    position, velocity, radius, angles, angular_velocity, info,
                })
                .collect(),
        };
        let mut text = Vec::new();
        write_frame(&frame, NumberStyle::Shortest, &mut text);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.data");
        std::fs::write(&path, &text).unwrap();
        let source = Source::open(&path).unwrap();
        let snapshot = source.frames(FrameChoice::Last).next().unwrap().unwrap();
        let again = data_frame(&snapshot, snapshot.dimensions(), &Info::Material).unwrap();
        let mut found = Vec::new();
        write_frame(&again, NumberStyle::Shortest, &mut found);
        prop_assert_eq!(String::from_utf8(found), String::from_utf8(text));
    }
}

#[test]
fn info_can_be_any_column() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.data");
    std::fs::write(&path, "1 0 0 0 0 1 1 1 \n0 0 0 3 0 4 0.5 0 0 0 0 0 0 7\n").unwrap();
    let source = Source::open(&path).unwrap();
    let snapshot = source.frames(FrameChoice::All).next().unwrap().unwrap();
    let info = |info| data_frame(&snapshot, 3, &info).map(|frame| frame.particles[0].info);
    assert_eq!(info(Info::Material).unwrap(), 7.0);
    assert_eq!(info(Info::Speed).unwrap(), 5.0);
    assert_eq!(info(Info::Column("radius".to_owned())).unwrap(), 0.5);
    let error = info(Info::Column("heat".to_owned()))
        .unwrap_err()
        .to_string();
    assert_eq!(
        error,
        format!("{}: no column `heat` of numbers", path.display())
    );
    // Its own reader accepts the file: additions of the source do not get into the way.
    assert_eq!(DataReader::open(&path).unwrap().count(), 1);
}
