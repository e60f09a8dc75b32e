//! Equal results of operations on a folder and on a bucket.
//!
//! The bucket is that of MERCURY_TEST_S3 (s3://BUCKET/PREFIX, with AWS_ENDPOINT_URL and credentials); without that variable
//! the folder is tested alone. `tests/ci.sh` starts servers for it.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::thread;

use cloud_store::{Store, StoreError, sha256};

/// Every store there is, with a prefix that nothing else uses.
fn stores(name: &str) -> (tempfile::TempDir, Vec<Box<dyn Store>>) {
    let folder = tempfile::tempdir().unwrap();
    let mut stores = vec![cloud_store::create(folder.path().to_str().unwrap()).unwrap()];
    if let Ok(url) = std::env::var("MERCURY_TEST_S3") {
        let url = format!("{url}/{name}-{}", std::process::id());
        stores.push(cloud_store::create(&url).unwrap());
    }
    (folder, stores)
}

#[test]
fn contents_come_back() {
    let (_folder, stores) = stores("contents");
    for store in &stores {
        assert_eq!(store.get("a/b").unwrap(), None);
        assert_eq!(store.bytes("a/b").unwrap(), None);
        store.put("a/b", b"hello").unwrap();
        store.put("a/c/d", b"!").unwrap();
        store.put("ab/c", b"no part of a/").unwrap();
        store.put("a/empty", b"").unwrap();
        assert_eq!(store.get("a/b").unwrap().as_deref(), Some(&b"hello"[..]));
        assert_eq!(store.get("a/empty").unwrap().as_deref(), Some(&b""[..]));
        assert_eq!(store.bytes("a/b").unwrap(), Some(5));
        // Ranges that reach behind the end have what there is.
        for (range, there) in [
            (1..3, &b"el"[..]),
            (3..99, b"lo"),
            (5..9, b""),
            (7..9, b""),
            (2..2, b""),
        ] {
            assert_eq!(
                store.get_range("a/b", range.clone()).unwrap(),
                there,
                "{range:?}"
            );
        }
        let keys: Vec<_> = store
            .list("a/")
            .unwrap()
            .into_iter()
            .map(|e| (e.key, e.bytes))
            .collect();
        let expected =
            [("a/b", 5), ("a/c/d", 1), ("a/empty", 0)].map(|(key, bytes)| (key.to_owned(), bytes));
        assert_eq!(keys, expected);
        store.delete("a/b").unwrap();
        store.delete("a/b").unwrap();
        store.delete_all("a/").unwrap();
        assert_eq!(store.list("a/").unwrap(), []);
        assert!(matches!(
            store.get_range("a/b", 0..1),
            Err(StoreError::Missing(_))
        ));
        let mut file = tempfile::tempfile().unwrap();
        assert!(matches!(
            store.get_into("a/b", &mut file),
            Err(StoreError::Missing(_))
        ));
        assert_eq!(store.get("ab/c").unwrap().unwrap(), b"no part of a/");
        store.delete_all("ab/").unwrap();
    }
}

#[test]
fn keys_cannot_lead_outside() {
    let (_folder, stores) = stores("keys");
    let is_refused = |error: Option<StoreError>| matches!(error, Some(StoreError::Key(_)));
    for store in &stores {
        for key in [
            "",
            "/etc/passwd",
            "a/../b",
            "a/../../b",
            "..",
            "a//b",
            ".swap/00",
            "a/.x",
            "a\0b",
            "a b",
            "ü",
        ] {
            assert!(is_refused(store.put(key, b"").err()), "{key:?}");
            assert!(is_refused(store.get(key).err()), "{key:?}");
            assert!(is_refused(store.delete_all(key).err()), "{key:?}");
        }
    }
}

/// Long contents go in parts. 40 MiB are three parts of an upload to S3, the last of them shorter.
#[test]
fn files_come_back() {
    let (_folder, stores) = stores("files");
    let content: Vec<u8> = (0..40_u32 << 18)
        .flat_map(|k| k.wrapping_mul(2_654_435_761).to_le_bytes())
        .collect();
    let mut file = tempfile::tempfile().unwrap();
    file.write_all(&content).unwrap();
    for store in &stores {
        for range in [0..content.len() as u64, 1_000..1_017, 3..17 << 20, 7..7] {
            let part = &content[range.start as usize..range.end as usize];
            let sent = store.put_file("file", &mut file, range).unwrap();
            assert_eq!(sent, sha256(part));
            assert_eq!(store.bytes("file").unwrap(), Some(part.len() as u64));
            let mut back: File = tempfile::tempfile().unwrap();
            back.write_all(b"before").unwrap();
            assert_eq!(store.get_into("file", &mut back).unwrap(), sent);
            let mut bytes = Vec::new();
            back.seek(SeekFrom::Start(0)).unwrap();
            back.read_to_end(&mut bytes).unwrap();
            assert!(bytes[..6] == *b"before" && bytes[6..] == *part);
        }
        store.delete("file").unwrap();
    }
}

#[test]
fn a_swap_needs_the_version_that_was_read() {
    let (_folder, stores) = stores("swap");
    for store in &stores {
        let first = store.swap("head", None, b"1").unwrap().unwrap();
        assert_eq!(store.swap("head", None, b"2").unwrap(), None);
        let second = store.swap("head", Some(&first), b"2").unwrap().unwrap();
        assert_eq!(store.swap("head", Some(&first), b"3").unwrap(), None);
        assert_eq!(
            store.get_versioned("head").unwrap(),
            Some((b"2".to_vec(), second.clone()))
        );
        store.delete("head").unwrap();
        assert_eq!(store.swap("head", Some(&second), b"3").unwrap(), None);
        assert_eq!(store.get("head").unwrap(), None);
    }
}

/// Each of several threads adds 1 to a number by swaps, several times; none may be lost.
#[test]
fn no_swap_is_lost_between_threads() {
    let (_folder, stores) = stores("threads");
    // A bucket needs some milliseconds for each request.
    for (store, (threads, times)) in stores.iter().zip([(8, 50), (4, 10)]) {
        store.put("n", b"0").unwrap();
        thread::scope(|scope| {
            for _ in 0..threads {
                scope.spawn(|| {
                    for _ in 0..times {
                        loop {
                            let (bytes, version) = store.get_versioned("n").unwrap().unwrap();
                            let n: u32 = String::from_utf8(bytes).unwrap().parse().unwrap();
                            let new = (n + 1).to_string();
                            if store
                                .swap("n", Some(&version), new.as_bytes())
                                .unwrap()
                                .is_some()
                            {
                                break;
                            }
                        }
                    }
                });
            }
        });
        let expected = (threads * times).to_string();
        assert_eq!(store.get("n").unwrap().unwrap(), expected.as_bytes());
        store.delete("n").unwrap();
    }
}

#[test]
fn wrong_addresses_are_refused() {
    for url in [
        "s3://",
        "s3:///prefix",
        "s3://bucket/../x",
        "s3://bucket/a b",
    ] {
        let refused = cloud_store::open(url);
        assert!(matches!(refused, Err(StoreError::Url { .. })), "{url}");
    }
}
