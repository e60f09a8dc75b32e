//! Audit log: changes and logins with user, time and answer. Requests that look are not in it, nor are secrets and bodies.

use std::sync::{Arc, OnceLock};

use axum::Json;
use axum::extract::{Request, State};
use axum::http::Method;
use axum::middleware::Next;
use axum::response::Response;
use cloud_api::answers::AuditRow;
use rusqlite::params;
use serde::Deserialize;

use crate::access::{Admin, client_address};
use crate::db::{Db, MOST_ROWS, Result, now};
use crate::routes::{Answer, QueryParams, Shared};
use crate::runs::blocking;
use crate::state::App;

/// The most rows that are kept; the oldest go first.
const KEPT: i64 = 100_000;

/// Name of the user of a request, from the place that recognises it. A guest of a run has the word `guest`.
#[derive(Clone, Default)]
pub(crate) struct Actor(Arc<OnceLock<String>>);

impl Actor {
    pub(crate) fn set(&self, name: &str) {
        // The first place that recognises the user is right.
        let _ = self.0.set(name.to_owned());
    }
}

/// Paths that take a scene and leave nothing.
const LOOKS: [&str; 3] = ["/api/v1/check", "/api/v1/preview", "/api/v1/studies/check"];

/// Whether requests of this method and path change something.
fn changes(method: &Method, path: &str) -> bool {
    !matches!(*method, Method::GET | Method::HEAD | Method::OPTIONS)
        && path.starts_with("/api/")
        && !LOOKS.contains(&path)
}

/// Records requests that change something, with their answer: those of users, and logins that were not delayed.
pub(crate) async fn record(
    State(app): State<Arc<App>>,
    mut request: Request,
    next: Next,
) -> Response {
    let (method, path) = (request.method().clone(), request.uri().path().to_owned());
    if !changes(&method, &path) {
        return next.run(request).await;
    }
    let actor = Actor::default();
    request.extensions_mut().insert(actor.clone());
    let address = client_address(&app, request.headers(), request.extensions()).to_string();
    let response = next.run(request).await;
    let status = response.status().as_u16();
    // A wrong password has no user.
    let is_try = path == "/api/v1/session" && status == 401 && method == Method::POST;
    let user = match actor.0.get() {
        Some(name) => name.clone(),
        None if is_try => String::new(),
        None => return response,
    };
    let row = AuditRow {
        id: 0,
        time: now(),
        user,
        address,
        method: method.to_string(),
        path: path.trim_start_matches("/api/v1").to_owned(),
        status,
    };
    let written = blocking(move || Ok(app.db.audit(&row)?)).await;
    if let Err(error) = written {
        eprintln!("a request is not in the audit log: {error:?}");
    }
    response
}

impl Db {
    fn audit(&self, row: &AuditRow) -> Result<()> {
        let mut connection = self.lock();
        let transaction = connection.transaction()?;
        transaction.execute(
            "INSERT INTO audit(time, user, address, method, path, status) VALUES (?1, ?2, ?3, ?4, ?5, ?6)",
            params![row.time, row.user, row.address, row.method, row.path, row.status],
        )?;
        let oldest = transaction.last_insert_rowid() - KEPT;
        transaction.execute("DELETE FROM audit WHERE id <= ?1", [oldest])?;
        transaction.commit()
    }

    /// Rows of the audit log, newest first; `before`: older than the one with this number.
    fn audited(&self, before: Option<i64>) -> Result<Vec<AuditRow>> {
        let connection = self.lock();
        let mut query = connection.prepare_cached(
            "SELECT id, time, user, address, method, path, status FROM audit WHERE ?1 IS NULL OR id < ?1 ORDER BY id DESC LIMIT ?2",
        )?;
        let rows = query.query_map(params![before, MOST_ROWS as i64], |row| {
            Ok(AuditRow {
                id: row.get(0)?,
                time: row.get(1)?,
                user: row.get(2)?,
                address: row.get(3)?,
                method: row.get(4)?,
                path: row.get(5)?,
                status: row.get(6)?,
            })
        })?;
        rows.collect()
    }
}

#[derive(Deserialize)]
pub(crate) struct AuditQuery {
    before: Option<i64>,
}

/// Requests that have changed something, newest first; for administrators. At most 200; the newest 100,000 are kept.
#[utoipa::path(get, path = "/api/v1/audit", params(("before" = Option<i64>, Query, description = "older than the row with this number")),
    responses((status = 200, body = Vec<AuditRow>)))]
pub(crate) async fn audit_list(
    State(app): Shared,
    Admin(_): Admin,
    QueryParams(query): QueryParams<AuditQuery>,
) -> Answer<Vec<AuditRow>> {
    blocking(move || Ok(Json(app.db.audited(query.before)?))).await
}

#[cfg(test)]
mod tests {
    use cloud_api::lifecycle::Policy;

    use super::*;

    #[test]
    fn requests_that_look_change_nothing() {
        assert!(changes(&Method::DELETE, "/api/v1/runs/x"));
        assert!(changes(&Method::POST, "/api/v1/runs"));
        assert!(!changes(&Method::GET, "/api/v1/runs"));
        assert!(!changes(&Method::POST, "/api/v1/studies/check"));
        assert!(!changes(&Method::POST, "/"));
        // The end of a path may be a name that a user has chosen.
        assert!(changes(&Method::DELETE, "/api/v1/users/check"));
    }

    #[test]
    fn rows_come_newest_first_and_the_oldest_go() {
        let folder = tempfile::tempdir().unwrap();
        let db = Db::open(&folder.path().join("db"), Policy::default(), None).unwrap();
        let row = |path: &str| AuditRow {
            id: 0,
            time: 1.0,
            user: "ada".to_owned(),
            address: "::1".to_owned(),
            method: "POST".to_owned(),
            path: path.to_owned(),
            status: 201,
        };
        for path in ["/a", "/b", "/c"] {
            db.audit(&row(path)).unwrap();
        }
        let paths = |before| {
            let rows = db.audited(before).unwrap();
            rows.into_iter().map(|row| row.path).collect::<Vec<_>>()
        };
        assert_eq!(paths(None), ["/c", "/b", "/a"]);
        assert_eq!(paths(Some(3)), ["/b", "/a"]);
        let later = "UPDATE sqlite_sequence SET seq = ?1 WHERE name = 'audit'";
        db.lock().execute(later, [KEPT + 1]).unwrap();
        db.audit(&row("/d")).unwrap();
        assert_eq!(paths(None), ["/d", "/c"]);
    }
}
