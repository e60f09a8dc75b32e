//! Reads back what was written, with a parser of its own: XML by roxmltree, blocks by inflate.

use std::collections::BTreeMap;
use std::io::Read as _;

use flate2::read::ZlibDecoder;
use glam::{DQuat, DVec3};
use proptest::prelude::*;

use super::*;
use crate::formats::test_support::{any_number, any_vector};

const APPENDED: &str = "<AppendedData encoding=\"raw\">\n_";

/// An array as the file has it.
#[derive(Debug, Clone, PartialEq)]
struct Found {
    kind: String,
    components: usize,
    bytes: Vec<u8>,
}

impl Found {
    fn f64(&self) -> Vec<f64> {
        assert_eq!(self.kind, "Float64");
        let (numbers, rest) = self.bytes.as_chunks();
        assert!(rest.is_empty());
        numbers.iter().map(|&b| f64::from_le_bytes(b)).collect()
    }

    fn i32(&self) -> Vec<i32> {
        assert_eq!(self.kind, "Int32");
        let (numbers, _) = self.bytes.as_chunks();
        numbers.iter().map(|&b| i32::from_le_bytes(b)).collect()
    }
}

/// A file as read back.
#[derive(Debug, PartialEq)]
struct Parsed {
    points: usize,
    cells: usize,
    time: Option<f64>,
    /// Arrays by element (`PointData`, ...) and name.
    arrays: BTreeMap<(String, String), Found>,
}

fn number(data: &[u8], place: &mut usize) -> usize {
    let bytes = data[*place..*place + 8].try_into().unwrap();
    *place += 8;
    usize::try_from(u64::from_le_bytes(bytes)).unwrap()
}

fn payload(data: &[u8], offset: usize, compressed: bool) -> (Vec<u8>, usize) {
    let mut place = offset;
    if !compressed {
        let length = number(data, &mut place);
        return (data[place..place + length].to_vec(), place + length);
    }
    let blocks = number(data, &mut place);
    let whole = number(data, &mut place);
    let last = number(data, &mut place);
    let sizes: Vec<usize> = (0..blocks).map(|_| number(data, &mut place)).collect();
    let mut bytes = Vec::new();
    for (k, size) in sizes.iter().enumerate() {
        let before = bytes.len();
        let mut decoder = ZlibDecoder::new(&data[place..place + size]);
        decoder.read_to_end(&mut bytes).unwrap();
        assert_eq!(decoder.total_in(), *size as u64);
        let expected = if k + 1 == blocks && last > 0 {
            last
        } else {
            whole
        };
        assert_eq!(bytes.len() - before, expected);
        place += size;
    }
    (bytes, place)
}

fn parse(file: &[u8]) -> Parsed {
    let marker = APPENDED.as_bytes();
    let cut = file
        .windows(marker.len())
        .position(|w| w == marker)
        .unwrap()
        + marker.len();
    let head = std::str::from_utf8(&file[..cut]).unwrap();
    let xml = format!("{head}</AppendedData></VTKFile>");
    let data = &file[cut..];
    let tree = roxmltree::Document::parse(&xml).unwrap();
    let root = tree.root_element();
    assert_eq!(root.attribute("header_type"), Some("UInt64"));
    assert_eq!(root.attribute("byte_order"), Some("LittleEndian"));
    let compressed = root.attribute("compressor").is_some();
    let piece = tree
        .descendants()
        .find(|n| n.has_tag_name("Piece"))
        .unwrap();
    let count = |name| piece.attribute(name).unwrap().parse().unwrap();
    let mut arrays = BTreeMap::new();
    let mut end = 0;
    for element in piece.children().filter(roxmltree::Node::is_element) {
        for array in element.children().filter(roxmltree::Node::is_element) {
            let get = |name| array.attribute(name).unwrap().to_owned();
            let offset: usize = get("offset").parse().unwrap();
            assert_eq!(offset, end, "arrays lie behind each other");
            let (bytes, next) = payload(data, offset, compressed);
            end = next;
            let found = Found {
                kind: get("type"),
                components: array
                    .attribute("NumberOfComponents")
                    .map_or(1, |n| n.parse().unwrap()),
                bytes,
            };
            let key = (element.tag_name().name().to_owned(), get("Name"));
            assert!(arrays.insert(key, found).is_none());
        }
    }
    assert_eq!(&data[end..], b"\n  </AppendedData>\n</VTKFile>\n");
    let time = tree
        .descendants()
        .find(|n| n.attribute("Name") == Some("TimeValue"));
    Parsed {
        points: count("NumberOfPoints"),
        cells: count("NumberOfCells"),
        time: time.map(|n| n.text().unwrap().parse().unwrap()),
        arrays,
    }
}

fn encoded(grid: &VtuGrid, options: VtuOptions) -> Vec<u8> {
    encode_vtu(grid, options).unwrap().concat()
}

fn with(compression: VtuCompression) -> VtuOptions {
    VtuOptions {
        compression,
        ..VtuOptions::default()
    }
}

const COMPRESSIONS: [VtuCompression; 4] = [
    VtuCompression::None,
    VtuCompression::Adaptive,
    VtuCompression::Level(1),
    VtuCompression::Level(9),
];

fn bits(values: impl IntoIterator<Item = f64>) -> Vec<u64> {
    values.into_iter().map(f64::to_bits).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_type_reads_back_exactly(
        rows in proptest::collection::vec(
            (any_vector(), any_number(), any::<(u8, i32, u32, i64, u64)>()), 0..40),
        time in any_number().prop_filter("finite", |t| t.is_finite()),
        name in "[a-z<>&\"' ]{1,8}",
        which in 0..COMPRESSIONS.len(),
    ) {
        let points: Vec<DVec3> = rows.iter().map(|r| r.0).collect();
        let numbers: Vec<f64> = rows.iter().map(|r| r.1).collect();
        let turns: Vec<DQuat> = rows.iter().map(|r| DQuat::from_xyzw(r.0.x, r.0.y, r.0.z, r.1)).collect();
        let grid = VtuGrid {
            time: Some(time),
            points: points.as_slice().into(),
            cells: VtuCells::Vertices,
            point_data: vec![
                VtuArray::new(name.as_str(), &numbers),
                VtuArray::new("V", &points),
                VtuArray::new("Q", &turns),
                VtuArray::new("A", rows.iter().map(|r| r.2.0).collect::<Vec<_>>()),
                VtuArray::new("B", rows.iter().map(|r| r.2.1).collect::<Vec<_>>()),
                VtuArray::new("C", rows.iter().map(|r| r.2.2).collect::<Vec<_>>()),
                VtuArray::new("D", rows.iter().map(|r| r.2.3).collect::<Vec<_>>()),
                VtuArray::new("E", rows.iter().map(|r| r.2.4).collect::<Vec<_>>()),
            ],
            cell_data: vec![VtuArray::new("on cells", &numbers)],
        };
        let found = parse(&encoded(&grid, with(COMPRESSIONS[which])));
        prop_assert_eq!((found.points, found.cells), (rows.len(), rows.len()));
        prop_assert_eq!(found.time.map(f64::to_bits), Some(time.to_bits()));
        let get = |element: &str, name: &str| &found.arrays[&(element.to_owned(), name.to_owned())];
        let flat = |vectors: &[DVec3]| bits(vectors.iter().flat_map(|v| v.to_array()));
        prop_assert_eq!(bits(get("Points", "Points").f64()), flat(&points));
        prop_assert_eq!(bits(get("PointData", "V").f64()), flat(&points));
        prop_assert_eq!(bits(get("PointData", &name).f64()), bits(numbers.iter().copied()));
        prop_assert_eq!(bits(get("CellData", "on cells").f64()), bits(numbers.iter().copied()));
        let wxyz = turns.iter().flat_map(|q| [q.w, q.x, q.y, q.z]);
        prop_assert_eq!(bits(get("PointData", "Q").f64()), bits(wxyz));
        prop_assert_eq!(get("PointData", "Q").components, 4);
        let bytes = |k: &str| get("PointData", k).bytes.clone();
        prop_assert_eq!(bytes("A"), rows.iter().map(|r| r.2.0).collect::<Vec<_>>());
        prop_assert_eq!(bytes("B"), rows.iter().flat_map(|r| r.2.1.to_le_bytes()).collect::<Vec<_>>());
        prop_assert_eq!(bytes("C"), rows.iter().flat_map(|r| r.2.2.to_le_bytes()).collect::<Vec<_>>());
        prop_assert_eq!(bytes("D"), rows.iter().flat_map(|r| r.2.3.to_le_bytes()).collect::<Vec<_>>());
        prop_assert_eq!(bytes("E"), rows.iter().flat_map(|r| r.2.4.to_le_bytes()).collect::<Vec<_>>());
        let count = 0..rows.len() as i32;
        prop_assert_eq!(get("Cells", "connectivity").i32(), count.clone().collect::<Vec<_>>());
        prop_assert_eq!(get("Cells", "offsets").i32(), count.map(|k| k + 1).collect::<Vec<_>>());
        prop_assert_eq!(&get("Cells", "types").bytes, &vec![1; rows.len()]);
    }
}

/// Several blocks with a short last one: numbers that shrink, numbers that don't, and vectors on the border of a block.
fn large() -> (Vec<DVec3>, Vec<f64>) {
    let count = 3 * blocks::BLOCK / 24 + 5;
    let noise = |k: usize| {
        let bits = (k as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        (bits >> 11) as f64 / (1u64 << 53) as f64
    };
    let points = (0..count).map(|k| DVec3::new(noise(3 * k), noise(3 * k + 1), noise(3 * k + 2)));
    (
        points.collect(),
        (0..count).map(|k| (k / 100) as f64).collect(),
    )
}

#[test]
fn blocks_join_without_a_gap_and_in_the_same_bytes_on_any_threads() {
    let (points, steps) = large();
    let grid = VtuGrid {
        points: points.as_slice().into(),
        point_data: vec![VtuArray::new("steps", &steps)],
        ..VtuGrid::default()
    };
    for compression in COMPRESSIONS {
        let parallel = encoded(&grid, with(compression));
        let serial = VtuOptions {
            parallel: false,
            ..with(compression)
        };
        assert!(parallel == encoded(&grid, serial), "{compression:?}");
        let found = parse(&parallel);
        let get =
            |element: &str, name: &str| found.arrays[&(element.to_owned(), name.to_owned())].f64();
        let expected: Vec<f64> = points.iter().flat_map(|v| v.to_array()).collect();
        assert!(get("Points", "Points") == expected, "{compression:?}");
        assert!(get("PointData", "steps") == steps, "{compression:?}");
    }
}

#[test]
fn adaptive_shrinks_what_shrinks_and_leaves_noise_alone() {
    let (points, steps) = large();
    let size = |values: VtuValues, compression| {
        let parts = blocks::encode(&values, with(compression));
        parts.iter().map(Vec::len).sum::<usize>()
    };
    let raw = 8 * steps.len();
    assert!(size((&steps).into(), VtuCompression::Adaptive) * 20 < raw);
    let noise = size((&points).into(), VtuCompression::Adaptive);
    // Stored: 5 bytes for each 65535 at most, and the numbers in front.
    assert!(
        (24 * points.len()..24 * points.len() + 400).contains(&noise),
        "{noise}"
    );
}

#[test]
fn single_precision_rounds_to_nearest_in_half_the_space() {
    let values = [1.0 / 3.0, -1e-3, 12345.678, 0.0];
    let points = [DVec3::new(0.1, 0.2, 0.3); 4];
    let grid = VtuGrid {
        points: points.as_slice().into(),
        point_data: vec![VtuArray::new("v", values.as_slice())],
        ..VtuGrid::default()
    };
    let options = VtuOptions {
        precision: VtuPrecision::Single,
        ..VtuOptions::default()
    };
    let found = parse(&encoded(&grid, options));
    let array = &found.arrays[&("PointData".to_owned(), "v".to_owned())];
    assert_eq!(array.kind, "Float32");
    let expected: Vec<u8> = values
        .iter()
        .flat_map(|&v| (v as f32).to_le_bytes())
        .collect();
    assert_eq!(array.bytes, expected);
    let points = &found.arrays[&("Points".to_owned(), "Points".to_owned())];
    assert_eq!(
        points.bytes,
        [0.1f32, 0.2, 0.3].map(f32::to_le_bytes).concat().repeat(4)
    );
}

#[test]
fn lines_and_triangles_say_what_they_join() {
    let points = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    for (cells, kind, connectivity, offsets) in [
        (
            VtuCells::Lines(vec![[0, 1], [3, 2]].into()),
            3,
            vec![0, 1, 3, 2],
            vec![2, 4],
        ),
        (
            VtuCells::Triangles(vec![[0, 1, 2], [3, 2, 1]].into()),
            5,
            vec![0, 1, 2, 3, 2, 1],
            vec![3, 6],
        ),
    ] {
        let grid = VtuGrid {
            points: points.as_slice().into(),
            cells,
            ..VtuGrid::default()
        };
        let found = parse(&encoded(&grid, VtuOptions::default()));
        let get = |name: &str| &found.arrays[&("Cells".to_owned(), name.to_owned())];
        assert_eq!((found.points, found.cells), (4, 2));
        assert_eq!(get("connectivity").i32(), connectivity);
        assert_eq!(get("offsets").i32(), offsets);
        assert_eq!(get("types").bytes, [kind, kind]);
    }
}

#[test]
fn what_does_not_fit_together_is_refused_and_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bad.vtu");
    let points = [DVec3::ZERO, DVec3::X];
    let numbers = [1.0, 2.0, 3.0];
    let grid = |cells, point_data| VtuGrid {
        points: points.as_slice().into(),
        cells,
        point_data,
        ..VtuGrid::default()
    };
    let short = || VtuArray::new("speed", &numbers[..2]);
    for (grid, message) in [
        (
            grid(
                VtuCells::Vertices,
                vec![VtuArray::new("speed", numbers.as_slice())],
            ),
            "array speed has 3 entries for 2 points",
        ),
        (
            grid(VtuCells::Vertices, vec![short(), short()]),
            "two arrays speed on points",
        ),
        (
            grid(VtuCells::Lines(vec![[0, 2]].into()), vec![]),
            "a cell uses point 2 of 2",
        ),
    ] {
        let error = write_vtu(&path, &grid, VtuOptions::default()).unwrap_err();
        assert_eq!(error.to_string(), format!("{}: {message}", path.display()));
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_folder_that_is_not_there_is_named() {
    let path = Path::new("no/such/folder/a.vtu");
    let error = write_vtu(path, &VtuGrid::default(), VtuOptions::default()).unwrap_err();
    let text = error.to_string();
    assert!(
        text.starts_with("no/such/folder/a.vtu: the file cannot be written: "),
        "{text}"
    );
}

fn entry(k: usize) -> PvdEntry {
    PvdEntry {
        time: 0.1 * k as f64,
        file: format!("a&b.{k:04}.vtu"),
    }
}

fn listed(path: &Path) -> Vec<PvdEntry> {
    let text = std::fs::read_to_string(path).unwrap();
    let tree = roxmltree::Document::parse(&text).unwrap();
    let sets = tree.descendants().filter(|n| n.has_tag_name("DataSet"));
    sets.map(|n| PvdEntry {
        time: n.attribute("timestep").unwrap().parse().unwrap(),
        file: n.attribute("file").unwrap().to_owned(),
    })
    .collect()
}

#[test]
fn a_growing_list_is_whole_after_every_entry_and_can_be_continued() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.pvd");
    let mut list = PvdWriter::create(&path).unwrap();
    assert_eq!(listed(&path), []);
    for k in 0..5 {
        list.append(&entry(k)).unwrap();
        assert_eq!(listed(&path), (0..=k).map(entry).collect::<Vec<_>>());
    }
    let all: Vec<_> = (0..5).map(entry).collect();
    assert_eq!(std::fs::read_to_string(&path).unwrap(), pvd_text(&all));
    // A reader makes a blank of a tab or line feed that is not written as a reference (XML 1.0, 3.3.3).
    let odd = PvdEntry {
        time: 0.0,
        file: "a\tb\nc\r<&\"\u{85}.vtu".to_owned(),
    };
    std::fs::write(&path, pvd_text(std::slice::from_ref(&odd))).unwrap();
    assert_eq!(listed(&path), [odd]);
    std::fs::write(&path, pvd_text(&all)).unwrap();

    drop(list);
    let mut list = PvdWriter::resume(&path, 2).unwrap();
    assert_eq!(listed(&path), [entry(0), entry(1)]);
    list.append(&entry(7)).unwrap();
    assert_eq!(listed(&path), [entry(0), entry(1), entry(7)]);

    let error = PvdWriter::resume(&path, 4).unwrap_err().to_string();
    let expected = "a list of 3 files, expected at least 4";
    assert_eq!(error, format!("{}: {expected}", path.display()));
    std::fs::write(&path, "<VTKFile/>").unwrap();
    let error = PvdWriter::resume(&path, 0).unwrap_err().to_string();
    let expected = "another XML file, expected a list that Mercury wrote";
    assert_eq!(error, format!("{}: {expected}", path.display()));
}
