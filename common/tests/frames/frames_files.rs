//! The contract of the native frames: exact round trips, whole frames at every instant, honest errors.

use std::fs;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::time::Instant;

use arrow_array::{Array, ArrayRef, Float64Array, RecordBatch, StringArray, UInt32Array};
use arrow_ipc::reader::StreamReader;
use arrow_ipc::writer::StreamWriter;
use arrow_schema::{Field, Schema};
use mercury_common::frames::{
    Column, ColumnKind, ColumnSpec, Frame, FrameReader, FrameSchema, FrameWriteError, FrameWriter,
    ParticleReader, SchemaError,
};
use proptest::collection::vec;
use proptest::prelude::*;

/// One column of each kind.
fn every_kind() -> FrameSchema {
    let columns = vec![
        ColumnSpec::new("x", ColumnKind::F64, "m").described("place"),
        ColumnSpec::new("charge", ColumnKind::I32, "1"),
        ColumnSpec::new("state", ColumnKind::U8, "1"),
        ColumnSpec::new("id", ColumnKind::U32, "1"),
        ColumnSpec::new("body", ColumnKind::OptionalU32, "1"),
        ColumnSpec::new("count", ColumnKind::U64, "1"),
        ColumnSpec::new("name", ColumnKind::Text, "1"),
    ];
    let facts = [("title".to_owned(), "Säule \"1\"\n".to_owned())];
    FrameSchema::new("things", columns)
        .unwrap()
        .with_metadata(facts)
}

fn any_frame() -> impl Strategy<Value = Frame> {
    let number = any::<f64>().prop_filter("bits of NaN are not promised", |x| !x.is_nan());
    let time = any::<f64>().prop_filter("finite", |t| t.is_finite());
    (0..70_usize, time).prop_flat_map(move |(rows, time)| {
        let columns = (
            vec(number.clone(), rows),
            vec(any::<i32>(), rows),
            vec(any::<u8>(), rows),
            vec(any::<u32>(), rows),
            vec(any::<Option<u32>>(), rows),
            vec(any::<u64>(), rows),
            vec(any::<String>(), rows),
        );
        columns.prop_map(move |(a, b, c, d, e, f, g)| Frame {
            time,
            step: 0,
            columns: vec![
                Column::F64(a),
                Column::I32(b),
                Column::U8(c),
                Column::U32(d),
                Column::OptionalU32(e),
                Column::U64(f),
                Column::Text(g),
            ],
        })
    })
}

/// Equality of bits: distinguishes -0 from 0, which `==` does not.
fn same_bits(a: &Frame, b: &Frame) -> bool {
    let bits = |column: &Column| -> Option<Vec<u64>> {
        Some(column.as_f64()?.iter().map(|x| x.to_bits()).collect())
    };
    a == b
        && a.time.to_bits() == b.time.to_bits()
        && a.columns
            .iter()
            .zip(&b.columns)
            .all(|(a, b)| bits(a) == bits(b))
}

fn write(path: &Path, schema: &FrameSchema, frames: &[Frame]) {
    let mut writer = FrameWriter::create(path, schema.clone()).unwrap();
    for frame in frames {
        writer.append(frame).unwrap();
    }
}

fn read(path: &Path) -> Vec<Frame> {
    let reader = FrameReader::open(path).unwrap();
    reader.frames().map(Result::unwrap).collect()
}

/// Whether a column holds these rows of another one, bit for bit.
fn same_rows(column: &Column, rows: Range<usize>, some: &Column) -> bool {
    match (column, some) {
        (Column::F64(all), Column::F64(some)) => {
            let bits = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            bits(&all[rows]) == bits(some)
        }
        (Column::I32(all), Column::I32(some)) => all[rows] == some[..],
        (Column::U8(all), Column::U8(some)) => all[rows] == some[..],
        (Column::U32(all), Column::U32(some)) => all[rows] == some[..],
        (Column::OptionalU32(all), Column::OptionalU32(some)) => all[rows] == some[..],
        (Column::U64(all), Column::U64(some)) => all[rows] == some[..],
        (Column::Text(all), Column::Text(some)) => all[rows] == some[..],
        _ => false,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn frames_come_back_bit_for_bit(mut frames in vec(any_frame(), 0..4)) {
        for (k, frame) in frames.iter_mut().enumerate() {
            frame.step = 10 * k as u64;
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.arrow");
        write(&path, &every_kind(), &frames);
        let back = read(&path);
        prop_assert_eq!(back.len(), frames.len());
        for (frame, back) in frames.iter().zip(&back) {
            prop_assert!(same_bits(frame, back));
        }

        // Some columns only, in another order.
        let reader = FrameReader::open(&path).unwrap();
        prop_assert_eq!(reader.schema(), &every_kind());
        for (k, frame) in frames.iter().enumerate() {
            let some = reader.columns(k, &["name", "charge"]).unwrap();
            prop_assert_eq!(&some, &[frame.columns[6].clone(), frame.columns[1].clone()]);
            // Some rows only: those of a frame that is made of them.
            let rows = frame.rows() / 3..frame.rows() - frame.rows() / 4;
            for (spec, column) in every_kind().columns().iter().zip(&frame.columns) {
                let some = reader.rows(k, &spec.name, rows.clone()).unwrap();
                prop_assert!(same_rows(column, rows.clone(), &some), "{}", spec.name);
            }
            prop_assert!(reader.rows(k, "name", 0..frame.rows() + 1).is_err());
            prop_assert!(reader.rows(k, "none", 0..0).is_err());
        }

        // An independent reader, that of the arrow-ipc crate, finds the same.
        let stream = StreamReader::try_new(fs::File::open(&path).unwrap(), None).unwrap();
        let batches: Vec<RecordBatch> = stream.map(Result::unwrap).collect();
        prop_assert_eq!(batches.len(), frames.len());
        for (frame, batch) in frames.iter().zip(&batches) {
            let f64s = |k: usize| batch.column(k).as_any().downcast_ref::<Float64Array>().unwrap();
            prop_assert_eq!(f64s(0).values().to_vec(), vec![frame.time; frame.rows()]);
            prop_assert_eq!(Some(&f64s(1).values()[..]), frame.columns[0].as_f64());
            let body = batch.column(5).as_any().downcast_ref::<UInt32Array>().unwrap();
            prop_assert_eq!(&Column::OptionalU32(body.iter().collect()), &frame.columns[4]);
            let name = batch.column(7).as_any().downcast_ref::<StringArray>().unwrap();
            let words = name.iter().map(|word| word.unwrap().to_owned()).collect();
            prop_assert_eq!(&Column::Text(words), &frame.columns[6]);
        }
    }

    /// Whatever happens to the bytes: an error or frames, never a panic and never a giant allocation.
    #[test]
    fn changed_bytes_never_panic(
        place in any::<prop::sample::Index>(),
        bytes in vec(any::<u8>(), 1..9),
        frame in any_frame(),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.arrow");
        write(&path, &every_kind(), &[frame]);
        let mut file = fs::read(&path).unwrap();
        let place = place.index(file.len());
        let end = (place + bytes.len()).min(file.len());
        file[place..end].copy_from_slice(&bytes[..end - place]);
        fs::write(&path, &file).unwrap();
        if let Ok(reader) = FrameReader::open(&path) {
            for frame in reader.frames().flatten() {
                prop_assert!(frame.columns.iter().all(|c| c.len() == frame.rows()));
            }
        }
    }
}

fn column_of(values: Vec<f64>) -> Vec<Column> {
    vec![Column::F64(values)]
}

fn one_column() -> FrameSchema {
    FrameSchema::new("points", vec![ColumnSpec::new("x", ColumnKind::F64, "m")]).unwrap()
}

fn point(step: u64, rows: usize) -> Frame {
    Frame {
        time: 1e-3 * step as f64,
        step,
        columns: column_of((0..rows).map(|k| (step * 1000) as f64 + k as f64).collect()),
    }
}

#[test]
fn an_empty_frame_keeps_time_and_step() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.arrow");
    write(
        &path,
        &one_column(),
        &[point(0, 0), point(7, 0), point(9, 2)],
    );
    let reader = FrameReader::open(&path).unwrap();
    let infos: Vec<_> = reader.infos().map(|i| (i.time, i.step, i.rows)).collect();
    assert_eq!(infos, [(0.0, 0, 0), (1e-3 * 7.0, 7, 0), (1e-3 * 9.0, 9, 2)]);
    assert_eq!(reader.frame(1).unwrap(), point(7, 0));
}

/// A file cut anywhere gives its whole frames and one error, unless the cut lies in the schema.
#[test]
fn a_file_cut_anywhere_gives_its_whole_frames_first() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.arrow");
    let frames = [point(1, 3), point(2, 0), point(3, 20)];
    let mut ends = Vec::new();
    let mut writer = FrameWriter::create(&path, one_column()).unwrap();
    for frame in &frames {
        ends.push(fs::metadata(&path).unwrap().len() as usize - 8);
        writer.append(frame).unwrap();
    }
    let bytes = fs::read(&path).unwrap();
    ends.push(bytes.len() - 8);
    let cut = folder.path().join("cut.arrow");
    for length in 0..bytes.len() {
        fs::write(&cut, &bytes[..length]).unwrap();
        if length < ends[0] {
            let error = FrameReader::open(&cut).unwrap_err();
            assert!(
                error.to_string().contains("expected an Arrow IPC stream"),
                "{error}"
            );
            continue;
        }
        let whole = ends[1..].iter().filter(|&&end| end <= length).count();
        let reader = FrameReader::open(&cut).unwrap();
        let items: Vec<_> = reader.frames().collect();
        assert_eq!(items.len(), whole + 1, "cut at {length}");
        for (item, frame) in items.iter().zip(&frames[..whole]) {
            assert_eq!(item.as_ref().unwrap(), frame);
        }
        let error = items[whole].as_ref().unwrap_err().to_string();
        assert!(
            error.contains(&format!("behind {whole} whole frame")),
            "{error}"
        );
        assert!(error.contains("cut.arrow"), "{error}");
    }
}

/// One thread writes 500 frames, another opens the file again and again: it sees whole frames only, in order, and the
/// same holds for a reader that stays open.
#[test]
fn a_reader_beside_the_writer_never_sees_half_a_frame() {
    const FRAMES: u64 = 500;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("live.arrow");
    let rows = |step: u64| (step * 37 % 1500) as usize;
    let mut writer = FrameWriter::create(&path, one_column()).unwrap();
    let done = AtomicBool::new(false);
    let openings = AtomicU32::new(0);
    // Whichever thread is slow: the writer waits now and then until the file was opened once more. Not for ever, as the other
    // thread may have failed.
    let wait = || {
        let (before, begin) = (openings.load(Ordering::Acquire), Instant::now());
        while openings.load(Ordering::Acquire) == before && begin.elapsed().as_secs() < 10 {
            std::thread::yield_now();
        }
    };
    let (opened, partial) = std::thread::scope(|scope| {
        scope.spawn(|| {
            for step in 1..=FRAMES {
                writer.append(&point(step, rows(step))).unwrap();
                if step % 50 == 1 {
                    // The second opening after this began after it.
                    wait();
                    wait();
                }
            }
            done.store(true, Ordering::Release);
        });
        let (mut opened, mut partial) = (0, 0);
        let mut following = FrameReader::open(&path).unwrap();
        loop {
            let last = done.load(Ordering::Acquire);
            let reader = FrameReader::open(&path).unwrap();
            following.refresh();
            for reader in [&reader, &following] {
                assert_eq!(reader.damage(), None);
                // All heads, and the bodies of the newest frames, where a race would show.
                let steps: Vec<u64> = reader.infos().map(|info| info.step).collect();
                assert_eq!(steps, (1..=reader.len() as u64).collect::<Vec<_>>());
                for k in reader.len().saturating_sub(3)..reader.len() {
                    let step = k as u64 + 1;
                    assert_eq!(reader.frame(k).unwrap(), point(step, rows(step)));
                }
            }
            // The reader of the arrow-ipc crate sees a whole stream too.
            let stream = StreamReader::try_new(fs::File::open(&path).unwrap(), None).unwrap();
            let seen = stream.map(Result::unwrap).count();
            assert!(seen >= reader.len());
            opened += 1;
            openings.store(opened, Ordering::Release);
            partial += u32::from(!reader.is_empty() && reader.len() < FRAMES as usize);
            if last {
                assert_eq!(
                    (reader.len(), following.len()),
                    (FRAMES as usize, FRAMES as usize)
                );
                return (opened, partial);
            }
        }
    });
    assert!(
        opened > 1 && partial > 0,
        "{opened} openings, {partial} of a growing file"
    );
}

#[test]
fn a_resumed_file_has_the_bytes_of_one_that_never_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let (straight, resumed) = (folder.path().join("a.arrow"), folder.path().join("b.arrow"));
    let frames: Vec<Frame> = (0..6).map(|k| point(k * 10, 5 * k as usize)).collect();
    write(&straight, &one_column(), &frames);
    for kept in 0..=5 {
        for damage in [false, true] {
            write(&resumed, &one_column(), &frames[..5]);
            if damage {
                // A loss of power may leave half a frame behind the last sync.
                let length = fs::metadata(&resumed).unwrap().len();
                let file = fs::OpenOptions::new().write(true).open(&resumed).unwrap();
                file.set_len(length - 20).unwrap();
            }
            let writer = FrameWriter::resume(&resumed, one_column(), kept);
            if damage && kept == 5 {
                let error = writer.unwrap_err().to_string();
                let expected = "4 whole frames, expected the 5 that the run had written";
                assert!(error.contains(expected), "{error}");
                continue;
            }
            let mut writer = writer.unwrap();
            assert_eq!(writer.len(), kept);
            for frame in &frames[kept..] {
                writer.append(frame).unwrap();
            }
            assert_eq!(fs::read(&resumed).unwrap(), fs::read(&straight).unwrap());
        }
    }
    let other = FrameSchema::new("points", Vec::new()).unwrap();
    let error = FrameWriter::resume(&resumed, other, 1).unwrap_err();
    assert!(error.to_string().contains("another run"), "{error}");
}

#[test]
fn frames_that_do_not_fit_are_refused_and_change_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.arrow");
    let mut writer = FrameWriter::create(&path, every_kind()).unwrap();
    let empty = Frame {
        time: 0.0,
        step: 5,
        columns: vec![
            Column::F64(vec![]),
            Column::I32(vec![]),
            Column::U8(vec![]),
            Column::U32(vec![]),
            Column::OptionalU32(vec![]),
            Column::U64(vec![]),
            Column::Text(vec![]),
        ],
    };
    writer.append(&empty).unwrap();
    let before = fs::read(&path).unwrap();
    let refused = |writer: &mut FrameWriter, change: &dyn Fn(&mut Frame), reason: &str| {
        let mut frame = Frame {
            step: 6,
            ..empty.clone()
        };
        change(&mut frame);
        let error = writer.append(&frame).unwrap_err();
        assert!(matches!(error, FrameWriteError::Frame { .. }));
        assert!(error.to_string().ends_with(reason), "{error}");
        assert_eq!(fs::read(&path).unwrap(), before);
    };
    refused(&mut writer, &|f| f.time = f64::NAN, "the time is NaN");
    refused(
        &mut writer,
        &|f| f.step = 5,
        "the frame before was at step 5",
    );
    refused(
        &mut writer,
        &|f| f.columns.truncate(3),
        "3 columns, expected 7",
    );
    let wrong = |f: &mut Frame| f.columns[1] = Column::U64(vec![]);
    refused(&mut writer, &wrong, "column charge is U64, expected I32");
    let longer = |f: &mut Frame| f.columns[3] = Column::U32(vec![1]);
    refused(&mut writer, &longer, "column id has 1 rows, expected 0");

    let twice = |name: &str| vec![ColumnSpec::new(name, ColumnKind::F64, "m"); 2];
    assert_eq!(
        FrameSchema::new("a", twice("x")).unwrap_err(),
        SchemaError::Duplicate("x".to_owned())
    );
    assert_eq!(
        FrameSchema::new("a", twice("time")).unwrap_err(),
        SchemaError::Reserved
    );
    assert_eq!(
        FrameSchema::new("a", twice("")).unwrap_err(),
        SchemaError::Unnamed
    );
    let nowhere = folder.path().join("no").join("a.arrow");
    let error = FrameWriter::create(nowhere, one_column()).unwrap_err();
    assert!(
        error.to_string().contains("the file cannot be written"),
        "{error}"
    );
}

/// Writes a stream as another program does: nullable columns, no word about Mercury, no time in the messages.
fn foreign(path: &Path, columns: Vec<(&str, ArrayRef)>) {
    let fields: Vec<Field> = columns
        .iter()
        .map(|(name, array)| Field::new(*name, array.data_type().clone(), true))
        .collect();
    let schema = Arc::new(Schema::new(fields));
    let arrays = columns.into_iter().map(|(_, array)| array).collect();
    let batch = RecordBatch::try_new(schema.clone(), arrays).unwrap();
    let mut writer = StreamWriter::try_new(fs::File::create(path).unwrap(), &schema).unwrap();
    writer.write(&batch).unwrap();
    writer.write(&batch).unwrap();
    writer.finish().unwrap();
}

#[test]
fn streams_of_other_programs_are_read_where_they_can_be() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("foreign.arrow");
    let x: ArrayRef = Arc::new(Float64Array::from(vec![1.0, 2.0]));
    let time: ArrayRef = Arc::new(Float64Array::from(vec![0.25, 0.25]));
    foreign(&path, vec![("x", x.clone()), ("time", time.clone())]);
    let frames = read(&path);
    assert_eq!(frames.len(), 2);
    assert_eq!((frames[1].time, frames[1].step), (0.25, 1));
    assert_eq!(frames[1].columns, column_of(vec![1.0, 2.0]));

    let gap: ArrayRef = Arc::new(Float64Array::from(vec![Some(1.0), None]));
    foreign(&path, vec![("time", time.clone()), ("x", gap)]);
    let error = FrameReader::open(&path)
        .unwrap()
        .frame(1)
        .unwrap_err()
        .to_string();
    assert!(
        error.ends_with("frame 1, column x: no value in row 1"),
        "{error}"
    );

    let open = |columns| {
        foreign(&path, columns);
        FrameReader::open(&path).unwrap_err().to_string()
    };
    assert!(open(vec![("x", x.clone())]).contains("no column `time`"));
    let small: ArrayRef = Arc::new(arrow_array::Float32Array::from(vec![1.0_f32, 2.0]));
    let error = open(vec![("time", time.clone()), ("x", small.clone())]);
    assert!(
        error.contains("column `x` of type float32, expected float64"),
        "{error}"
    );
    assert!(open(vec![("time", small)]).contains("column `time` of type float32"));
    assert!(open(vec![("time", time), ("x", x.clone()), ("x", x)]).contains("two columns `x`"));
}

#[test]
fn files_that_are_no_frames_are_named_as_what_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.arrow");
    let open = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        FrameReader::open(&path).unwrap_err().to_string()
    };
    assert!(open(b"ARROW1\0\0 and so on").contains("an Arrow IPC file (Feather)"));
    assert!(open(b"").contains("an empty stream"));
    assert!(open(b"id,x,y,z\n1,2,3,4\n").contains("no Arrow message at byte 0"));
    assert!(open(&[0xFF; 8]).contains("negative length"));
    assert!(open(&[0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x7F]).contains("beyond the end"));
    let absent = FrameReader::open(folder.path().join("none.arrow")).unwrap_err();
    assert!(absent.to_string().contains("the file cannot be opened"));

    let version = [("mercury_frames".to_owned(), "2".to_owned())];
    write(&path, &one_column().with_metadata(version), &[]);
    let error = FrameReader::open(&path).unwrap_err().to_string();
    assert!(
        error.contains("frames of version 2, expected version 1"),
        "{error}"
    );

    write(&path, &one_column(), &[point(1, 1)]);
    let reader = FrameReader::open(&path).unwrap();
    assert!(
        reader
            .frame(1)
            .unwrap_err()
            .to_string()
            .contains("no frame 1: the file has 1")
    );
    assert!(
        reader
            .columns(0, &["y"])
            .unwrap_err()
            .to_string()
            .contains("no column `y`")
    );
    let error = ParticleReader::open(&path).unwrap_err().to_string();
    assert!(
        error.contains("frames of points, expected frames of particles"),
        "{error}"
    );
    assert_eq!(reader.schema().columns()[0].unit, "m");
}
