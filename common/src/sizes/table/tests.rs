//! Tables in every form that the grammar allows, and bad ones of every kind with their messages.

use std::path::Path;

use super::*;
use crate::reference_data::shared;
use crate::scene::Weighting::{Area, Length, Number, Volume};
use proptest::prelude::*;

fn read_with(text: &str, options: &Options) -> Result<Content, String> {
    parse(Path::new("t.csv"), text, options).map_err(|error| error.to_string())
}

fn table(text: &str) -> SizeTable {
    match read_with(text, &Options::default()) {
        Ok(Content::Table(table)) => table,
        other => panic!("{text:?}: {other:?}"),
    }
}

fn error(text: &str) -> String {
    read_with(text, &Options::default()).expect_err(text)
}

#[test]
fn the_forms_of_a_table() {
    let expected = ([1e-3, 2e-3, 4e-3], [0.25, 0.75]);
    for text in [
        "diameter [mm],cumulative volume [%]\n1,0\n2,25\n4,100\n",
        "\u{feff}# by laser\n\ndiameter [mm] ; Cumulative Volume [%]\r\n1,0;0\r\n2,0;25,0\r\n4;100\r\n",
        "diameter (mm)\tvolume fraction\n1\t0\n2\t0.25\n4\t0.75\n",
        "radius [mm],Q3 [-]\n0.5,0\n1,0.25\n2,1\n",
        "radius [um],cumulative_volume\n500,0\n1000,0.25 # the median\n2000,1\n",
        "Sieve [mm],retained [g]\n4,0\n2,30\n1,10\n",
        "sieve [mm],retained mass [%]\n1,25\n2,75\n4,0\n",
        "sieve [cm],passing [%]\n0.4,100\n0.2,25\n0.1,0\n",
        "cumulative volume [%],diameter [m]\n0,0.001\n25,0.002\n100,0.004\n",
        "diameter [mm],mass fraction [kg]\n1,0\n2,1\n4,3\n",
        "diameter [mm],cumulative mass fraction\n1,0\n2,0.25\n4,1\n",
        "sieve [mm],cumulative retained [g]\n4,0\n2,30\n1,40\n",
        "sieve diameter [mm],Cum. retained mass fraction\n4,0\n2,0.75\n1,1\n",
        "sieve [mm],Cumulative % Retained\n1,100\n2,75\n4,0\n",
        "sieve [mm],oversize weight [%]\n4,0\n2,75\n1,100\n",
        "sieve [mm],retained fraction [%]\n4,0\n2,75\n1,25\n",
        "sieve [mm],% passing\n4,100\n2,25\n1,0\n",
    ] {
        let table = table(text);
        assert_eq!(table.edges, expected.0, "{text}");
        assert_eq!(table.shares, expected.1, "{text}");
        assert_eq!(table.weighting, Volume, "{text}");
        assert_eq!(table.classes.model(), ClassModel::default());
        assert!(table.notes.is_empty());
    }
    for (word, weighting) in [("number", Number), ("length", Length), ("surface", Area)] {
        let text = format!("diameter [mm],cumulative {word}\n1,0\n2,1\n");
        assert_eq!(table(&text).weighting, weighting);
    }
    assert_eq!(
        table("diameter [mm],fraction number [count]\n1,0\n2,30\n3,70\n").counted,
        Some(100.0)
    );
}

/// 12.5 + 20 = 32.5 % of the mass is above 1 mm and 72.5 % above 0.5 mm: 0.5625 of that class is finer than the median. A class of
/// constant number density has the mass of d^4 in it: d50^4 = 0.5^4 + 0.5625 (1 - 0.5^4) mm^4.
#[test]
fn lab_sheets_of_one_sieving_have_one_median() {
    let median = 1e-3 * (0.0625_f64 + 0.5625 * (1.0 - 0.0625)).powf(0.25);
    for text in [
        "Sieve [mm],cumulative retained mass [g]\n4.75,0\n2.00,12.5\n1.00,32.5\n0.50,72.5\n0.25,92.5\n0.125,97.5\npan,100\n",
        "Sieve [mm],cumulative retained weight [kg]\n4.75,0\n2.00,0.125\n1.00,0.325\n0.50,0.725\n0.25,0.925\n0.125,1.0\n",
        "Sieve [mm],retained fraction [%]\n4.75,0\n2.00,12.5\n1.00,20\n0.50,40\n0.25,20\n0.125,7.5\n0.063,0\n",
    ] {
        let table = table(text);
        let sizes = crate::sizes::SizeDistribution::from_classes(table.classes, table.weighting);
        let found = sizes.quantile(0.5);
        assert!((found / median - 1.0).abs() < 1e-12, "{text}: {found}");
    }
    // The pan takes what the finest sieve lets through.
    let pan = table("sieve [mm],cumulative retained [%]\n2,0\n1,30\npan,100\n");
    assert_eq!(
        (pan.edges, pan.shares),
        (vec![0.0, 1e-3, 2e-3], vec![0.7, 0.3])
    );
}

#[test]
fn what_is_repaired_or_left_out_is_said() {
    let scaled = table("diameter [mm],fraction volume [%]\n1,0\n2,49\n3,50.5\n");
    assert_eq!(
        scaled.notes,
        ["shares are divided by 99.5, so that they sum to 1"]
    );
    let extra = table("diameter [mm],remark,cumulative volume\n1,fine,0\n2,,1\n");
    assert_eq!(extra.notes, ["the column \"remark\" is not read"]);
    let model = table("# in-class: volume-log-uniform\ndiameter [mm],Q3\n1,0\n2,1\n");
    assert_eq!(model.classes.model(), ClassModel::LogUniform(Volume));
    // A class that begins with 0 stays: the pan of a sieving.
    let pan = table("sieve [mm],retained [g]\n2,0\n1,30\npan,10\n");
    assert_eq!(pan.edges, [0.0, 1e-3, 2e-3]);
}

fn list_of(diameters: &[f64], by_quota: bool) -> Content {
    Content::Sizes(SizeList {
        diameters: diameters.to_vec(),
        by_quota,
    })
}

#[test]
fn options_speak_for_files_without_header() {
    let options = Options {
        size: Some(SizeKind::Radius),
        per_metre: Some(1.0),
        values: parse_type("cumulative-number").ok(),
        model: Some(Model::LogUniformInMeasured),
        mercury: false,
    };
    let Ok(Content::Table(table)) = read_with("0.001, 0.0\n0.002, 1\n", &options) else {
        panic!("no table")
    };
    assert_eq!(table.edges, [0.002, 0.004]);
    assert_eq!(table.classes.model(), ClassModel::LogUniform(Number));
    // Options win over a header, even over one that contradicts itself.
    let options = Options {
        values: parse_type("cumulative-retained-mass").ok(),
        ..Options::default()
    };
    let Ok(Content::Table(table)) = read_with("sieve [mm],passing retained\n2,0\n1,1\n", &options)
    else {
        panic!("no table")
    };
    assert_eq!(table.shares, [1.0]);
    for (word, message) in [
        (
            "passing-retained-mass",
            "the words \"passing\" and \"retained\", which contradict",
        ),
        (
            "number-mass-fraction",
            "the words \"number\" and \"mass\", which contradict",
        ),
        ("cumulative", "expected for example cumulative-number"),
    ] {
        let found = parse_type(word).expect_err(word);
        assert!(found.contains(message), "{found}");
    }
    let options = Options {
        per_metre: Some(1e3),
        ..Options::default()
    };
    let Ok(Content::Table(table)) = read_with("diameter,cumulative number\n1,0\n2,1\n", &options)
    else {
        panic!("no table")
    };
    assert_eq!(table.edges, [1e-3, 2e-3]);
    let list = Options {
        size: Some(SizeKind::Radius),
        per_metre: Some(1e3),
        ..Options::default()
    };
    assert_eq!(
        read_with("1\n2\n", &list),
        Ok(list_of(&[2e-3, 4e-3], false))
    );
    assert_eq!(
        read_with("diameter [mm]\n1.5\n2\n", &Options::default()),
        Ok(list_of(&[1.5e-3, 2e-3], false))
    );
    // The comment of a list that is no random sample; other words are comments.
    for (comment, by_quota) in [
        ("#sampling:quota", true),
        ("#  sampling : quota ", true),
        ("# sampling: by hand, from the belt", false),
        ("# quota", false),
    ] {
        let text = format!("{comment}\ndiameter [mm]\n1.5\n2\n");
        assert_eq!(
            read_with(&text, &Options::default()),
            Ok(list_of(&[1.5e-3, 2e-3], by_quota))
        );
    }
}

#[test]
fn mercury_repairs_are_made_and_said_only_on_request() {
    let options = Options {
        mercury: true,
        ..Options::default()
    };
    let text = "radius [m],cumulative number\n2,-1\n3,10\n4,40\n";
    let Ok(Content::Table(table)) = read_with(text, &options) else {
        panic!("no table")
    };
    assert_eq!(table.edges, [4.0, 6.0, 8.0]);
    assert_eq!(table.shares, [0.25, 0.75]);
    assert_eq!(
        table.notes,
        [
            "1 negative shares count as 0",
            "shares are divided by 40, so that they sum to 1"
        ]
    );
    let text = "radius [m],cumulative number\n2,10\n3,40\n";
    let Ok(Content::Table(table)) = read_with(text, &options) else {
        panic!("no table")
    };
    // In front: the larger of 0.001 r0 and 2 r0 - r1.
    assert_eq!(table.edges, [2.0, 4.0, 6.0]);
}

#[test]
fn bad_tables_say_where_and_what() {
    for (text, message) in [
        (
            "",
            "t.csv: the table is empty, expected a header such as: diameter [mm],cumulative volume [%]",
        ),
        (
            "# only a comment\n",
            "t.csv: the table is empty, expected a header such as: diameter [mm],cumulative volume [%]",
        ),
        (
            "1,0\n2,1\n",
            "t.csv:1:1: no header, expected a header such as: diameter [mm],cumulative volume [%]",
        ),
        (
            "diameter,cumulative volume\n1,0\n",
            "t.csv:1:1: sizes without a unit, expected for example diameter [mm]",
        ),
        (
            "diameter [inch],cumulative volume\n1,0\n",
            "t.csv:1:1: the unit \"inch\" of the sizes, expected m, cm, mm, um or nm",
        ),
        (
            "size [mm],cumulative volume\n1,0\n",
            "t.csv:1:1: a header without a column of sizes",
        ),
        (
            "diameter [mm],radius [mm],cumulative volume\n",
            "t.csv:1:15: \"radius [mm]\", a second column of sizes, expected one",
        ),
        (
            "diameter [mm],Q3,Q0\n1,0,0\n",
            "t.csv:1:18: \"Q0\", a second column of shares, expected one",
        ),
        (
            "diameter [mm],cumulative\n1,0\n",
            "t.csv:1:15: \"cumulative\", which does not say of what",
        ),
        (
            "diameter [mm],density volume\n1,0\n",
            "t.csv:1:15: the column \"density volume\", expected cumulative, fraction",
        ),
        (
            "diameter [mm],q3\n1,0\n",
            "t.csv:1:15: the column \"q3\", expected cumulative, fraction",
        ),
        (
            "diameter [mm],cumulative volume [furlong]\n1,0\n",
            "t.csv:1:15: the unit \"furlong\" of the shares",
        ),
        (
            "sieve [mm],passing retained [%]\n2,0\n1,100\n",
            "t.csv:1:12: \"passing retained [%]\" with the words \"passing\" and \"retained\", which contradict each other",
        ),
        (
            "sieve [mm],Q3 oversize [%]\n2,0\n1,100\n",
            "the words \"Q3\" and \"oversize\", which contradict each other",
        ),
        (
            "diameter [mm],cumulative number by volume\n1,0\n2,1\n",
            "the words \"number\" and \"volume\", which contradict each other",
        ),
        (
            "sieve radius [mm],Q3\n1,0\n2,1\n",
            "t.csv:1:1: \"sieve radius [mm]\" with the words \"sieve\" and \"radius\", which contradict each other",
        ),
        (
            "sieve [mm],% retained [g]\n2,0\n1,100\n",
            "t.csv:1:12: the unit \"g\" of the shares",
        ),
        (
            "sieve [mm],cumulative retained [%]\n2,0\n1,30\n0.5,97.5\n",
            "t.csv:4: the cumulative retained share 97.5 at 0.5, the finest sieve, expected 100 there",
        ),
        (
            "sieve [mm],cumulative retained [g]\n4,3\n2,33\n1,43\n",
            "t.csv:2: 3 on the largest sieve, 4, expected 0 there",
        ),
        (
            "sieve [mm],cumulative retained [g]\n4,0\n2,33\n1,13\n",
            "t.csv:3: the share 33 above 13, of a finer size, expected cumulative retained shares that do not grow",
        ),
        (
            "sieve [mm],cumulative retained [%]\n4,0\n2,33\npan,90\n",
            "t.csv: the cumulative shares end at 90, expected 100 %",
        ),
        (
            "# in-class: flat\ndiameter [mm],Q3\n1,0\n",
            "t.csv:1:1: \"flat\" for the model inside a class, expected one of number-uniform",
        ),
        (
            "diameter [mm],Q3\n",
            "t.csv: no rows below the header, expected at least two",
        ),
        (
            "diameter [mm],Q3\n1,0\n",
            "t.csv:2: one row, expected at least two",
        ),
        (
            "diameter [mm],Q3\n1,0\n2,x\n",
            "t.csv:3:3: \"x\" for the share, expected a number",
        ),
        (
            "diameter [mm],Q3\n1,0\n2\n",
            "t.csv:3:2: no share in this row, expected a number",
        ),
        (
            "diameter [mm],Q3\n1,0\n,1\n",
            "t.csv:3:1: no size in this row, expected a number",
        ),
        (
            "diameter [mm],Q3\n1,0\n2,nan\n",
            "t.csv:3:3: \"nan\" for the share, expected a finite number",
        ),
        (
            "diameter [mm],Q3\n1,0\ninf,1\n",
            "t.csv:3:1: \"inf\" for the size, expected a finite number",
        ),
        (
            "diameter [mm],Q3\n-1,0\n2,1\n",
            "t.csv:2: the size -1, expected a size above 0",
        ),
        (
            "diameter [mm],Q3\n2,0\n1,1\n",
            "t.csv:3: the size 1 below 2, the row before, expected ascending sizes",
        ),
        (
            "diameter [mm],Q3\n1,0\n1,1\n",
            "t.csv:3: the size 1 for the second time, expected each size once",
        ),
        (
            "sieve [mm],Q3\n1,0\n3,1\n2,1\n",
            "t.csv:4: the size 2 out of order, expected sieves in ascending or descending order",
        ),
        (
            "diameter [mm],Q3 [%]\n1,0\n2,60\n3,50\n4,100\n",
            "t.csv:4: the share 50 below 60, of a finer size, expected cumulative shares that do not decrease",
        ),
        (
            "diameter [mm],Q3\n1,0\n2,-0.1\n",
            "t.csv:3: the share -0.1, expected a share >= 0",
        ),
        (
            "diameter [mm],Q3\n1,0.1\n2,1\n",
            "t.csv:2: the share 0.1 below 1, the smallest size, expected a first row with the share 0",
        ),
        (
            "diameter [mm],volume fraction\n1,0.1\n2,0.9\n",
            "t.csv:2: the share 0.1 in the class that ends at 1",
        ),
        (
            "sieve [mm],retained [g]\n4,3\n2,30\n1,10\n",
            "t.csv:2: 3 on the largest sieve, 4, expected 0 there",
        ),
        (
            "diameter [mm],Q3 [%]\n1,0\n2,87.3\n",
            "t.csv: the cumulative shares end at 87.3, expected 100 %",
        ),
        (
            "diameter [mm],volume fraction [-]\n1,0\n2,0.5\n3,0.3\n",
            "t.csv: the shares sum to 0.8, expected 1",
        ),
        (
            "diameter [mm],Q3 [-]\n1,0\n2,100\n",
            "help: these are percent: write [%] behind the name of the column",
        ),
        ("diameter [mm],Q3\n1,0\n2,0\n", "t.csv: all shares are 0"),
        (
            "diameter [mm],Q3\n1.0,0\n2,0,5\n",
            "t.csv:3:5: \"5\", one value too many, expected 2 per row\nhelp: write a decimal point",
        ),
        (
            "# in-class: volume-uniform\ndiameter [mm],Q3\n0,0\n2,1\n",
            "t.csv:3: the finest class reaches down to diameter 0",
        ),
        (
            "diameter [mm]\n1\n0\n",
            "t.csv:3: the size 0, expected a size above 0",
        ),
        (
            "diameter [mm]\n1 2\n",
            "t.csv:2:3: \"2\", one value too many, expected 1 per row",
        ),
        ("diameter [mm]\n", "t.csv: no sizes below the header"),
    ] {
        let found = error(text);
        assert!(found.contains(message), "{text:?}:\n{found}\n{message}");
    }
}

#[test]
fn bytes_that_are_not_text_and_files_that_are_not_there() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("x.csv");
    let missing = super::read(&path).expect_err("no file").to_string();
    assert!(missing.contains("the file cannot be read"), "{missing}");
    std::fs::write(&path, b"diameter [mm],Q3\n1,0\n2,\xff\n").expect("written");
    let bytes = super::read(&path).expect_err("no text").to_string();
    assert!(bytes.contains(":3: bytes that are not text"), "{bytes}");
    std::fs::write(&path, "diameter [mm]\n1\n2\n").expect("written");
    let list = super::read(&path).expect_err("a list").to_string();
    assert!(
        list.contains("a list of sizes, expected a second column"),
        "{list}"
    );
}

#[test]
fn the_table_of_the_hopper_scene() {
    let Some(path) = shared("scenes/grain.psd.csv") else {
        return;
    };
    let table = super::read(&path).expect("a table");
    assert_eq!(table.weighting, Volume);
    assert_eq!(table.edges.len(), 6);
    // 8 % below 3.5 mm, 31 % below 4 mm, 63 % below 4.5 mm.
    let cumulative = table.classes.cumulative(Volume);
    for (share, expected) in cumulative.iter().zip([0.0, 0.08, 0.31, 0.63, 0.88, 1.0]) {
        assert!((share - expected).abs() < 1e-15 * 4.0);
    }
}

proptest! {
    /// No text makes the reader panic, and what it takes is a distribution.
    #[test]
    fn garbage_is_refused_or_read(text in "(diameter|radius|sieve) \\[(mm|m)\\][,;](Q3|retained|number fraction)( \\[[%g-]\\])?\n([0-9.,;#-]{0,12}\n){0,6}") {
        if let Ok(Content::Table(table)) = read_with(&text, &Options::default()) {
            let sum: f64 = table.shares.iter().sum();
            prop_assert!((sum - 1.0).abs() < 1e-12);
            prop_assert!(table.edges.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }

    #[test]
    fn any_text_is_refused_or_read(text in "\\PC{0,80}") {
        let _ = read_with(&text, &Options::default());
    }
}
