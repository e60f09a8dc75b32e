//! Projects: users who share runs.
//!
//! A run belongs to one user, on whose limits it counts. Where it is in a project, too, the members of the project see it, and do with
//! it what their role allows.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use cloud_api::answers::{MemberRow, ProjectRow};
use cloud_api::requests::{NewMember, NewProject, Role};
use rusqlite::{Connection, OptionalExtension, params};
use serde_json::Value;

use crate::access::{Anyone, ApiError, LoggedIn};
use crate::db::{self, MOST_ROWS, now};
use crate::routes::{Answer, JsonBody, Shared};
use crate::runs::blocking;
use crate::secrets::{self, Caller, User};
use crate::state::App;

/// The longest name of a project, in bytes.
const LONGEST_NAME: usize = 200;

fn role_of(word: String) -> db::Result<Role> {
    serde_json::from_value(Value::String(word.clone())).map_err(|_| db::unknown("role", word))
}

fn word_of(role: Role) -> String {
    serde_json::to_value(role)
        .ok()
        .and_then(|word| word.as_str().map(str::to_owned))
        .unwrap_or_default()
}

fn role_in(connection: &Connection, user: i64, project: &str) -> db::Result<Option<Role>> {
    connection
        .query_row(
            "SELECT role FROM members WHERE project = ?1 AND user = ?2",
            params![project, user],
            |row| row.get(0),
        )
        .optional()?
        .map(role_of)
        .transpose()
}

/// Whether a user is a member of a project, if there is one.
pub(crate) fn is_member(app: &App, user: i64, project: Option<&str>) -> Result<bool, ApiError> {
    let Some(project) = project else {
        return Ok(false);
    };
    Ok(role_in(&app.db.lock(), user, project)?.is_some())
}

/// Role of a user in a project; `None` for others than members.
pub(crate) fn role(app: &App, user: &User, project: &str) -> Result<Option<Role>, ApiError> {
    Ok(role_in(&app.db.lock(), user.id, project)?)
}

/// Refuses what needs a role that the user does not have in a project. A project of others is not there.
pub(crate) fn need(app: &App, user: &User, project: &str, least: Role) -> Result<(), ApiError> {
    enough(role(app, user, project)?, least)
}

fn enough(role: Option<Role>, least: Role) -> Result<(), ApiError> {
    match role {
        None => Err(ApiError::not_found()),
        Some(role) if role >= least => Ok(()),
        Some(role) => Err(ApiError::new(
            StatusCode::FORBIDDEN,
            "not allowed",
            format!(
                "You are a {} of this project; this needs a {}.",
                word_of(role),
                word_of(least)
            ),
        )),
    }
}

/// The projects of this user, with their members.
#[utoipa::path(get, path = "/api/v1/projects", responses((status = 200, body = Vec<ProjectRow>)))]
pub(crate) async fn project_list(
    State(app): Shared,
    Anyone(caller): Anyone,
) -> Answer<Vec<ProjectRow>> {
    let Caller::User(user) = caller else {
        return Ok(Json(Vec::new()));
    };
    blocking(move || Ok(Json(list(&app.db.lock(), user.id)?))).await
}

fn list(connection: &Connection, user: i64) -> db::Result<Vec<ProjectRow>> {
    let mut query = connection.prepare_cached(
        "SELECT p.id, p.name, m.role, (SELECT count(*) FROM runs r WHERE r.project = p.id)
         FROM members m JOIN projects p ON p.id = m.project WHERE m.user = ?1 ORDER BY p.name, p.id LIMIT ?2",
    )?;
    let rows = query.query_map(params![user, MOST_ROWS as i64], |row| {
        Ok(ProjectRow {
            id: row.get(0)?,
            name: row.get(1)?,
            role: role_of(row.get(2)?)?,
            runs: row.get::<_, i64>(3)? as u64,
            members: Vec::new(),
        })
    })?;
    let mut projects = rows.collect::<db::Result<Vec<_>>>()?;
    let mut query = connection.prepare_cached(
        "SELECT u.name, m.role FROM members m JOIN users u ON u.id = m.user WHERE m.project = ?1 ORDER BY u.name",
    )?;
    for project in &mut projects {
        let members = query.query_map([&project.id], |row| {
            Ok(MemberRow {
                name: row.get(0)?,
                role: role_of(row.get(1)?)?,
            })
        })?;
        project.members = members.collect::<db::Result<_>>()?;
    }
    Ok(projects)
}

/// Makes a project; this user is its first manager.
#[utoipa::path(post, path = "/api/v1/projects", request_body = NewProject, responses((status = 201, body = ProjectRow)))]
pub(crate) async fn project_add(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    JsonBody(body): JsonBody<NewProject>,
) -> Result<Response, ApiError> {
    let name = body.name.trim().to_owned();
    if name.is_empty() || name.len() > LONGEST_NAME || name.chars().any(char::is_control) {
        return Err(ApiError::bad_request(
            "invalid name",
            format!("A name has 1 to {LONGEST_NAME} bytes, without control characters."),
        ));
    }
    blocking(move || {
        let id = secrets::run_id()?.to_string();
        let mut connection = app.db.lock();
        let count: i64 = connection.query_row(
            "SELECT count(*) FROM members WHERE user = ?1",
            [user.id],
            |row| row.get(0),
        )?;
        if count >= MOST_ROWS as i64 {
            let detail = format!("A user is in {MOST_ROWS} projects at most.");
            return Err(ApiError::bad_request("too many projects", detail));
        }
        let transaction = connection.transaction()?;
        transaction.execute(
            "INSERT INTO projects VALUES (?1, ?2, ?3)",
            params![id, name, now()],
        )?;
        transaction.execute(
            "INSERT INTO members VALUES (?1, ?2, ?3)",
            params![id, user.id, word_of(Role::Manager)],
        )?;
        transaction.commit()?;
        let row = ProjectRow {
            id,
            name,
            role: Role::Manager,
            runs: 0,
            members: vec![MemberRow {
                name: user.name.clone(),
                role: Role::Manager,
            }],
        };
        Ok((StatusCode::CREATED, Json(row)).into_response())
    })
    .await
}

/// Removes a project, for managers. Its runs stay with their owners.
#[utoipa::path(delete, path = "/api/v1/projects/{project}", params(("project" = String, Path)), responses((status = 204)))]
pub(crate) async fn project_remove(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(project): Path<String>,
) -> Result<StatusCode, ApiError> {
    blocking(move || {
        need(&app, &user, &project, Role::Manager)?;
        let mut connection = app.db.lock();
        let transaction = connection.transaction()?;
        for change in [
            "UPDATE runs SET project = NULL WHERE project = ?1",
            "UPDATE studies SET project = NULL WHERE project = ?1",
            "DELETE FROM members WHERE project = ?1",
            "DELETE FROM projects WHERE id = ?1",
        ] {
            transaction.execute(change, [&project])?;
        }
        transaction.commit()?;
        Ok(StatusCode::NO_CONTENT)
    })
    .await
}

/// Adds a user to a project, or gives a member another role; for managers.
#[utoipa::path(put, path = "/api/v1/projects/{project}/members/{name}", params(("project" = String, Path), ("name" = String, Path)),
    request_body = NewMember, responses((status = 204)))]
pub(crate) async fn member_set(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path((project, name)): Path<(String, String)>,
    JsonBody(body): JsonBody<NewMember>,
) -> Result<StatusCode, ApiError> {
    change_members(app, user, project, name, Some(body.role)).await
}

/// Takes a member out of a project: for managers, and for members themselves.
#[utoipa::path(delete, path = "/api/v1/projects/{project}/members/{name}", params(("project" = String, Path), ("name" = String, Path)),
    responses((status = 204)))]
pub(crate) async fn member_remove(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path((project, name)): Path<(String, String)>,
) -> Result<StatusCode, ApiError> {
    change_members(app, user, project, name, None).await
}

async fn change_members(
    app: Arc<App>,
    user: User,
    project: String,
    name: String,
    role: Option<Role>,
) -> Result<StatusCode, ApiError> {
    blocking(move || {
        let leaves = role.is_none() && name == user.name;
        let least = if leaves { Role::Viewer } else { Role::Manager };
        need(&app, &user, &project, least)?;
        let mut connection = app.db.lock();
        let transaction = connection.transaction()?;
        let member: Option<i64> = transaction
            .query_row("SELECT id FROM users WHERE name = ?1", [&name], |row| row.get(0))
            .optional()?;
        let Some(member) = member else {
            let detail = "This server has no user of this name.";
            return Err(ApiError::new(StatusCode::NOT_FOUND, "no such user", detail));
        };
        let changed = match role {
            Some(role) => transaction.execute(
                "INSERT INTO members VALUES (?1, ?2, ?3) ON CONFLICT(project, user) DO UPDATE SET role = ?3",
                params![project, member, word_of(role)],
            )?,
            None => transaction.execute(
                "DELETE FROM members WHERE project = ?1 AND user = ?2",
                params![project, member],
            )?,
        };
        if changed == 0 {
            return Err(ApiError::not_found());
        }
        let managers: i64 = transaction.query_row(
            "SELECT count(*) FROM members WHERE project = ?1 AND role = ?2",
            params![project, word_of(Role::Manager)],
            |row| row.get(0),
        )?;
        if managers == 0 {
            let detail = "A project has a manager: make another member one first, or remove the project.";
            return Err(ApiError::new(StatusCode::CONFLICT, "the last manager", detail));
        }
        transaction.commit()?;
        Ok(StatusCode::NO_CONTENT)
    })
    .await
}

/// Whose runs a list has: those of a project, or those of the user.
pub(crate) fn of<'a>(project: Option<&'a str>, user: &User) -> db::ListScope<'a> {
    project.map_or(db::ListScope::Owner(user.id), db::ListScope::Project)
}
