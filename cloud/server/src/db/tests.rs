//! Tests of the database.

use cloud_api::Head;
use cloud_api::head::{Cause, Ending};
use cloud_api::lifecycle::RunEvent;
use cloud_engine::Local;
use rusqlite::params;

use crate::secrets::Caller;

use super::contents::INPUTS;
use super::*;

fn db() -> (tempfile::TempDir, Db) {
    let folder = tempfile::tempdir().unwrap();
    let db = Db::open(&folder.path().join("db"), Policy::default(), None).unwrap();
    let add = "INSERT INTO users(id, name, admin) VALUES (1, 'ada', 0), (2, 'bob', 0)";
    db.lock().execute(add, []).unwrap();
    (folder, db)
}

fn new<'a>(id: &'a str, key: Option<(&'a str, &'a str)>) -> NewRun<'a> {
    NewRun {
        id,
        owner: 1,
        key,
        title: "t",
        label: "",
        spec: "{}",
        threads: 1,
        ranks: 1,
        memory: 1,
        of_steps: None,
        study: None,
        project: None,
        reserved: 0,
        time_limit: None,
    }
}

/// A run has its limit of time anew when it is resumed; a user has core hours for all runs, also those that were removed.
#[test]
fn runs_stop_at_their_time_and_at_the_core_hours_of_their_user() {
    let (_folder, db) = db();
    let engine = Local::new(1, "", "");
    let limited = NewRun {
        threads: 2,
        ranks: 2,
        time_limit: Some(5.0),
        ..new("a", None)
    };
    let other = NewRun {
        owner: 2,
        ..new("c", None)
    };
    db.insert(&[limited, new("b", None), other], None).unwrap();
    let done = |id: &str, event: &RunEvent, head: Option<&Head>| {
        let applied = db.apply(id, event, head, &engine).unwrap();
        assert!(matches!(applied, Applied::Done(..)), "{event:?}");
    };
    let head = |epoch, core_seconds| Head {
        epoch,
        core_seconds,
        ..Head::default()
    };
    let spent = |epoch, seconds| db.set_progress("a", epoch, &head(epoch, seconds)).unwrap();
    let out = || -> Vec<String> {
        let out = db.out_of_time().unwrap();
        out.into_iter().map(|(id, _)| id).collect()
    };
    let ended = |cause| {
        let (code, message) = (None, String::new());
        RunEvent::Ended(
            Ending {
                cause,
                code,
                message,
            },
            5,
        )
    };
    done("a", &RunEvent::Launched, None);
    // Two ranks of two threads spend 20 core seconds in 5 s.
    spent(1, 19.9);
    assert!(out().is_empty());
    // Another attempt goes on where the lost one was.
    done("a", &ended(Cause::Lost), Some(&head(1, 19.9)));
    db.lock()
        .execute("UPDATE runs SET not_before = 0", [])
        .unwrap();
    done("a", &RunEvent::Launched, None);
    spent(2, 0.1);
    assert_eq!(out(), ["a"]);
    let (_, why) = &db.out_of_time().unwrap()[0];
    assert!(why.contains("limit of 0.0014 h"), "{why}");
    db.stop_for("a", why, &engine).unwrap();
    assert!(out().is_empty(), "it was stopped already");
    done("a", &ended(Cause::User), Some(&head(2, 0.1)));
    let (.., row, _) = db.run("a").unwrap().unwrap();
    assert_eq!((&row.message, row.core_seconds), (why, 20.0));
    // Resumed, it has as long again.
    done("a", &RunEvent::Resume, None);
    assert_eq!(db.run("a").unwrap().unwrap().2.message, "");
    done("a", &RunEvent::Launched, None);
    spent(3, 19.9);
    assert!(out().is_empty());
    // The user has 39.9 core seconds; what waits does not begin.
    let grant = |seconds: f64| {
        let set = "UPDATE users SET core_seconds = ?1 WHERE id = 1";
        db.lock().execute(set, [seconds]).unwrap();
    };
    grant(40.0);
    assert!(out().is_empty());
    grant(39.9);
    assert_eq!(out(), ["a", "b"]);
    db.stop_for("b", "hours", &engine).unwrap();
    assert_eq!(db.run("b").unwrap().unwrap().2.message, "hours");
    done("a", &RunEvent::Stop, None);
    done("a", &ended(Cause::User), Some(&head(3, 19.9)));
    let before = db.usage(1).unwrap();
    assert!((before.core_seconds - 39.9).abs() < 1e-9 && before.most_core_seconds == Some(39.9));
    assert!(matches!(db.delete("a").unwrap(), Deleted::Done(_)));
    assert!((db.usage(1).unwrap().core_seconds - 39.9).abs() < 1e-9);
    assert_eq!(db.usage(2).unwrap().core_seconds, 0.0);
}

/// A user with 100 bytes: runs and uploads reserve what they are expected to take, and what does not fit changes nothing.
#[test]
fn what_is_reserved_never_exceeds_a_limit() {
    let (_folder, db) = db();
    let limit = "UPDATE users SET disk = 100 WHERE id = 1";
    db.lock().execute(limit, []).unwrap();
    let run = |id, reserved| NewRun {
        reserved,
        ..new(id, None)
    };
    let fits = |run: NewRun| matches!(db.insert(&[run], None).unwrap(), Reserved::Done(_));
    let upload = |bytes| matches!(db.reserve_upload(1, bytes).unwrap(), Reserved::Done(()));
    assert!(fits(run("a", 60)));
    assert!(!fits(run("b", 60)));
    assert!(db.run("b").unwrap().is_none());
    assert!(upload(30));
    assert!(!upload(30));
    assert_eq!(db.usage(1).unwrap().disk, 90);
    assert_eq!(db.left_for("a").unwrap(), Some(70));
    db.end_upload(1, 30, Some(("0", 20))).unwrap();
    assert_eq!(db.usage(1).unwrap().disk, 80);
    // The run takes more than was expected.
    assert!(db.over_limit().unwrap().is_empty());
    let grown = "UPDATE runs SET bytes = 81 WHERE id = 'a'";
    db.lock().execute(grown, []).unwrap();
    assert_eq!(db.over_limit().unwrap(), [1]);
}

/// Of a database from before secrets had parents, tokens stay and sessions go.
#[test]
fn sessions_without_a_known_parent_end() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("db");
    let old = Connection::open(&path).unwrap();
    old.execute_batch(SCHEMA).unwrap();
    let add = "INSERT INTO secrets VALUES (1, 'a', 'session', 1, '', NULL, 1e12, 0), (2, 'b', 'token', 1, '', NULL, 1e12, 0)";
    old.execute(add, []).unwrap();
    for _ in 0..2 {
        let db = Db::open(&path, Policy::default(), None).unwrap();
        let ids: String = (db.lock())
            .query_row("SELECT group_concat(id) FROM secrets", [], |row| row.get(0))
            .unwrap();
        assert_eq!(ids, "2");
    }
}

/// Nothing is made for a user that is removed, and no other user gets the number.
#[test]
fn a_user_who_is_gone_gets_no_run_and_no_upload() {
    let (_folder, db) = db();
    let gone = NewRun {
        owner: 3,
        ..new("a", None)
    };
    assert!(matches!(
        db.insert(&[gone], None).unwrap(),
        Reserved::NoUser
    ));
    assert!(db.run("a").unwrap().is_none());
    assert!(matches!(db.reserve_upload(3, 1).unwrap(), Reserved::NoUser));
    let next = || {
        let mut connection = db.lock();
        let transaction = connection.transaction().unwrap();
        let id = next_id(&transaction, "users").unwrap();
        transaction.commit().unwrap();
        id
    };
    assert_eq!(next(), 3);
    let remove = "DELETE FROM users WHERE id = 2";
    db.lock().execute(remove, []).unwrap();
    assert_eq!(next(), 4);
}

/// An input goes with the last run of its owner that names it; its content when no user has it any more.
#[test]
fn an_input_goes_with_the_last_run_that_names_it() {
    let (_folder, db) = db();
    let spec =
        r#"{"files":{"a.stl":{"sha256":"abc","bytes":3},"b.stl":{"sha256":"abc","bytes":3}}}"#;
    let run = |id, owner| NewRun {
        owner,
        spec,
        ..new(id, None)
    };
    let add = |id, owner| db.insert(&[run(id, owner)], None).unwrap();
    assert!(matches!(add("a", 1), Reserved::NoInput));
    assert!(db.run("a").unwrap().is_none());
    db.add_input("abc", 1, 3).unwrap();
    assert!(matches!(add("c", 2), Reserved::NoInput));
    db.add_input("abc", 2, 3).unwrap();
    for (id, owner) in [("a", 1), ("b", 1), ("c", 2)] {
        assert!(matches!(add(id, owner), Reserved::Done(_)));
    }
    assert_eq!(db.inputs(1).unwrap()[0].runs, 2);
    assert_eq!(db.remove_input("abc", 1).unwrap(), Forgotten::Named);
    assert_eq!(db.delete("a").unwrap(), Deleted::Live);
    assert_eq!(db.inputs(1).unwrap()[0].runs, 2);
    let over = "UPDATE runs SET state = 'finished'";
    db.lock().execute(over, []).unwrap();
    assert_eq!(db.delete("a").unwrap(), Deleted::Done(Vec::new()));
    assert_eq!(db.delete("a").unwrap(), Deleted::Missing);
    assert_eq!(db.inputs(1).unwrap()[0].runs, 1);
    let forgotten = Deleted::Done(vec!["abc".to_owned()]);
    assert_eq!(db.delete("b").unwrap(), forgotten);
    assert!(db.inputs(1).unwrap().is_empty());
    assert!(db.is_needed("abc").unwrap());
    assert_eq!(db.delete("c").unwrap(), forgotten);
    assert!(!db.is_needed("abc").unwrap());
    assert_eq!(db.remove_input("abc", 2).unwrap(), Forgotten::Missing);
    db.add_input("abc", 1, 3).unwrap();
    assert_eq!(db.remove_input("abc", 1).unwrap(), Forgotten::Done);
}

/// A list of inputs reads no row of a run, whose specs are long.
#[test]
fn a_list_of_inputs_looks_runs_up_by_an_index() {
    let (_folder, db) = db();
    let connection = db.lock();
    let explain = format!("EXPLAIN QUERY PLAN {INPUTS}");
    let mut query = connection.prepare(&explain).unwrap();
    let steps = query.query_map(params![1, 10], |row| row.get("detail"));
    let steps: Vec<String> = steps.unwrap().map(Result::unwrap).collect();
    let by = "SEARCH n USING COVERING INDEX run_inputs_content (sha256=? AND owner=?)";
    assert!(steps.iter().any(|step| step == by), "{steps:?}");
}

/// Runs of a database from before this table name their contents, too.
#[test]
fn contents_of_earlier_runs_are_named() {
    let (folder, db) = db();
    db.add_input("abc", 1, 3).unwrap();
    let spec = r#"{"files":{"a.stl":{"sha256":"abc","bytes":3}}}"#;
    let run = NewRun {
        spec,
        ..new("a", None)
    };
    db.insert(&[run], None).unwrap();
    db.lock().execute("DROP TABLE run_inputs", []).unwrap();
    drop(db);
    for _ in 0..2 {
        let db = Db::open(&folder.path().join("db"), Policy::default(), None).unwrap();
        assert_eq!(db.remove_input("abc", 1).unwrap(), Forgotten::Named);
    }
}

/// A content is within the limit of its user, whatever brought it.
#[test]
fn contents_keep_the_limit() {
    let (_folder, db) = db();
    let limit = "UPDATE users SET disk = 100 WHERE id = 1";
    db.lock().execute(limit, []).unwrap();
    let add = |sha256, bytes| db.add_input(sha256, 1, bytes).unwrap();
    assert!(matches!(add("a", 60), Reserved::Done(())));
    assert!(matches!(add("b", 60), Reserved::Full(_)));
    assert!(matches!(add("a", 60), Reserved::Done(())));
    assert_eq!(db.usage(1).unwrap().disk, 60);
    let gone = db.add_input("a", 3, 1).unwrap();
    assert!(matches!(gone, Reserved::NoUser));
}

/// Runs of others are seen by members of their project, a link sees its own run, and a secret that is gone sees nothing.
#[test]
fn one_query_finds_whether_runs_may_be_seen() {
    let (_folder, db) = db();
    let shared = NewRun {
        owner: 2,
        project: Some("p"),
        ..new("c", None)
    };
    db.insert(&[new("a", None), new("b", None), shared], None)
        .unwrap();
    let user = |secret| {
        Caller::User(crate::secrets::User {
            secret,
            ..crate::secrets::local()
        })
    };
    let ada = user(None);
    let may = |caller: &Caller, runs: &[&str]| {
        let runs = runs.iter().map(|run| (*run).to_owned()).collect();
        db.may_see(caller, &runs).unwrap()
    };
    assert!(may(&ada, &[]));
    assert!(may(&ada, &["a", "b", "a"]));
    assert!(!may(&ada, &["a", "c"]));
    assert!(!may(&ada, &["a", "unknown"]));
    let join = "INSERT INTO members VALUES ('p', 1, 'viewer')";
    db.lock().execute(join, []).unwrap();
    assert!(may(&ada, &["a", "c"]));
    let add = "INSERT INTO secrets VALUES (5, 'h', 'session', 1, '', 'b', 1e12, 1, NULL, 1)";
    db.lock().execute(add, []).unwrap();
    let guest = Caller::Guest(crate::secrets::Guest {
        run: "b".to_owned(),
        owner: 1,
        secret: 5,
        root: None,
    });
    assert!(may(&guest, &["b"]));
    assert!(!may(&guest, &["a"]));
    assert!(!may(&user(Some(7)), &["a"]));
}

/// Of two extensions of one revision the second one changes nothing.
#[test]
fn an_extension_follows_the_revision_that_it_was_made_for() {
    let (_folder, db) = db();
    let engine = Local::new(1, "", "");
    db.insert(&[new("a", None)], None).unwrap();
    let set = "UPDATE runs SET state = 'finished'";
    db.lock().execute(set, []).unwrap();
    let extend = |spec| {
        let extension = Extension {
            after: 1,
            spec,
            of_steps: None,
            reserved: 0,
        };
        db.extend("a", &extension, &engine).unwrap()
    };
    let first = extend("{\"first\":1}");
    assert!(matches!(first, Reserved::Done(Some(Applied::Done(..)))));
    db.lock().execute(set, []).unwrap();
    assert!(matches!(extend("{}"), Reserved::Done(None)));
    let (_, run, _, spec) = db.run("a").unwrap().unwrap();
    assert_eq!((run.revision, spec.as_str()), (2, "{\"first\":1}"));
}

#[test]
fn lists_are_pages_without_gaps_or_repetitions() {
    let (_folder, db) = db();
    let ids: Vec<String> = (0..450).map(|k| format!("{k:032x}")).collect();
    let runs: Vec<NewRun> = ids.iter().map(|id| new(id, None)).collect();
    db.insert(&runs, None).unwrap();
    let mut seen = Vec::new();
    let mut after: Option<String> = None;
    loop {
        let mut page = db
            .list(ListScope::Owner(1), None, None, None, after.as_deref())
            .unwrap();
        let more = page.len() > MOST_ROWS;
        page.truncate(MOST_ROWS);
        seen.extend(page.iter().map(|row| row.id.clone()));
        after = seen.last().cloned();
        if !more {
            break;
        }
    }
    seen.reverse();
    assert_eq!(seen, ids);
    assert!(
        db.list(ListScope::Owner(2), None, None, None, None)
            .unwrap()
            .is_empty()
    );
}

#[test]
fn a_key_belongs_to_one_run_of_a_user() {
    let (_folder, db) = db();
    db.insert(&[new("a", Some(("k", "body")))], None).unwrap();
    assert!(db.insert(&[new("b", Some(("k", "other")))], None).is_err());
    assert_eq!(
        db.by_key("runs", 1, "k").unwrap(),
        Some(("a".to_owned(), "body".to_owned()))
    );
    assert_eq!(db.by_key("runs", 2, "k").unwrap(), None);
}

#[test]
fn what_is_illegal_leaves_neither_a_change_nor_an_event() {
    let (_folder, db) = db();
    db.insert(&[new("a", None)], None).unwrap();
    let before = db.newest_event().unwrap();
    assert!(matches!(
        db.apply("a", &RunEvent::Resume, None, &Local::new(1, "", ""))
            .unwrap(),
        Applied::Illegal(_)
    ));
    assert!(matches!(
        db.apply("b", &RunEvent::Stop, None, &Local::new(1, "", ""))
            .unwrap(),
        Applied::Missing
    ));
    assert_eq!(db.newest_event().unwrap(), before);
    assert!(matches!(
        db.apply("a", &RunEvent::Launched, None, &Local::new(1, "", ""))
            .unwrap(),
        Applied::Done(..)
    ));
    assert_eq!(db.attempts("a").unwrap().len(), 1);
    assert_eq!(db.live().unwrap()[0].run.epoch, 1);
}
