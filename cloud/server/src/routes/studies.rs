//! Routes of studies: checks, submission, lists and tables.

use axum::Json;
use axum::extract::{Path, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use cloud_api::answers::{StudyChecked, StudyList, StudySubmitted, StudyTable};
use cloud_api::requests::{Role, Study};
use serde::Deserialize;

use super::runs::key_of;
use super::{Answer, JsonBody, QueryParams, Shared};
use crate::access::{Anyone, ApiError, LoggedIn};
use crate::runs::blocking;
use crate::secrets::Caller;
use crate::{means, projects, studies};

/// Runs that a study would have, or its problems.
#[utoipa::path(post, path = "/api/v1/studies/check", request_body = Study, responses((status = 200, body = StudyChecked)))]
pub(crate) async fn study_check(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    JsonBody(body): JsonBody<Study>,
) -> Answer<StudyChecked> {
    Ok(Json(studies::check(&app, &user, body).await?))
}

/// Submits a study: all of its runs, or none.
#[utoipa::path(post, path = "/api/v1/studies", request_body = Study,
    params(("Idempotency-Key" = Option<String>, Header)), responses((status = 201, body = StudySubmitted)))]
pub(crate) async fn study_submit(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    headers: HeaderMap,
    JsonBody(body): JsonBody<Study>,
) -> Result<Response, ApiError> {
    let submitted = studies::submit(&app, &user, body, key_of(&headers)?).await?;
    Ok((StatusCode::CREATED, Json(submitted)).into_response())
}

#[derive(Deserialize)]
pub(crate) struct StudiesQuery {
    project: Option<String>,
    after: Option<String>,
}

/// A page of studies, newest first.
#[utoipa::path(get, path = "/api/v1/studies", params(("project" = Option<String>, Query), ("after" = Option<String>, Query)),
    responses((status = 200, body = StudyList)))]
pub(crate) async fn study_list(
    State(app): Shared,
    Anyone(caller): Anyone,
    QueryParams(query): QueryParams<StudiesQuery>,
) -> Answer<StudyList> {
    let Caller::User(user) = caller else {
        return Ok(Json(StudyList {
            studies: Vec::new(),
            after: None,
        }));
    };
    blocking(move || {
        let project = query.project.as_deref();
        if let Some(project) = project {
            projects::need(&app, &user, project, Role::Viewer)?;
        }
        let of = projects::of(project, &user);
        Ok(Json(studies::list(&app, of, query.after.as_deref())?))
    })
    .await
}

/// The table of a study: values of its keys, and results of its runs.
#[utoipa::path(get, path = "/api/v1/studies/{study}", params(("study" = String, Path)), responses((status = 200, body = StudyTable)))]
pub(crate) async fn study_table(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(study): Path<String>,
) -> Answer<StudyTable> {
    blocking(move || Ok(Json(studies::table(&app, &user, &study)?))).await
}

/// The table of a study as comma-separated values.
#[utoipa::path(get, path = "/api/v1/studies/{study}/table.csv", params(("study" = String, Path)), responses((status = 200, content_type = "text/csv")))]
pub(crate) async fn study_csv(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(study): Path<String>,
) -> Result<Response, ApiError> {
    let table = blocking(move || studies::table(&app, &user, &study)).await?;
    Ok(saved("study.csv", studies::csv(&table)))
}

/// The means of a study over its seeds as comma-separated values, as the solver's `study.means.csv`.
#[utoipa::path(get, path = "/api/v1/studies/{study}/means.csv", params(("study" = String, Path)), responses((status = 200, content_type = "text/csv")))]
pub(crate) async fn study_means(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(study): Path<String>,
) -> Result<Response, ApiError> {
    let table = blocking(move || studies::table(&app, &user, &study)).await?;
    Ok(saved("study.means.csv", means::csv(&table)))
}

/// The differences of a study's points from the first one as comma-separated values, as the solver's `study.differences.csv`.
#[utoipa::path(get, path = "/api/v1/studies/{study}/differences.csv", params(("study" = String, Path)), responses((status = 200, content_type = "text/csv")))]
pub(crate) async fn study_differences(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(study): Path<String>,
) -> Result<Response, ApiError> {
    let table = blocking(move || studies::table(&app, &user, &study)).await?;
    Ok(saved("study.differences.csv", means::differences(&table)))
}

/// A table that browsers save under a name.
fn saved(name: &str, text: String) -> Response {
    let disposition = format!("attachment; filename=\"{name}\"");
    let head = [
        (header::CONTENT_TYPE, "text/csv; charset=utf-8".to_owned()),
        (header::CONTENT_DISPOSITION, disposition),
    ];
    (head, text).into_response()
}
