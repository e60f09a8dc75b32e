//! Sessions, users and tokens.

use std::sync::Arc;
use std::time::Duration;

use axum::Json;
use axum::extract::{Path, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use cloud_api::answers::{Price, Session, TokenRow, UserRow};
use cloud_api::names::LONGEST_NAME;
use cloud_api::requests::{LogIn, NewToken, NewUser};
use rusqlite::params;
use tokio::sync::OwnedSemaphorePermit;

use crate::access::{ApiError, Client, LoggedIn, cookie, cookie_name};
use crate::routes::{Answer, JsonBody, Shared, days};
use crate::runs::blocking;
use crate::secrets::{self, SecretKind};
use crate::state::App;

fn session_of(app: &App, user: &secrets::User) -> Session {
    let cores = app.options.cores;
    let busy: u32 = app.db.live().map_or(0, |runs| {
        runs.iter()
            .filter(|live| live.run.state.has_attempt())
            .map(|live| live.threads)
            .sum()
    });
    Session {
        user: user.name.clone(),
        admin: user.admin && user.share.is_none(),
        read_only: user.read_only,
        cores: [cores.saturating_sub(busy), cores],
        solver: app.version.clone(),
        usage: app.db.usage(user.id).unwrap_or_default(),
        price: app.db.prices().and_then(|prices| {
            Some(Price {
                currency: prices.currency.clone(),
                core_hour: prices.core_hour(app.engine.queue(0))?,
            })
        }),
    }
}

/// Which user this is, and what is free.
#[utoipa::path(get, path = "/api/v1/session", responses((status = 200, body = Session)))]
pub(crate) async fn session_get(State(app): Shared, LoggedIn(user): LoggedIn) -> Answer<Session> {
    Ok(Json(session_of(&app, &user)))
}

fn not_known() -> ApiError {
    ApiError::new(
        StatusCode::UNAUTHORIZED,
        "not known",
        "The link or the password is wrong or has expired.",
    )
}

/// How long a request waits until its password is hashed.
const HASH_TURN: Duration = Duration::from_secs(10);

/// Waits for a turn to hash a password.
async fn hash_turn(app: &App) -> Result<OwnedSemaphorePermit, ApiError> {
    let turn = Arc::clone(&app.hashes).acquire_owned();
    match tokio::time::timeout(HASH_TURN, turn).await {
        Ok(turn) => turn.map_err(ApiError::internal),
        Err(_) => Err(ApiError::too_many(
            "too many tries",
            "Many users log in at once. Try again.",
            HASH_TURN.as_secs(),
        )),
    }
}

/// Logs in, by the token of a link or by name and password. Sets a cookie.
#[utoipa::path(post, path = "/api/v1/session", request_body = LogIn, responses((status = 200, body = Session)))]
pub(crate) async fn session_begin(
    State(app): Shared,
    Client(address): Client,
    JsonBody(body): JsonBody<LogIn>,
) -> Result<Response, ApiError> {
    let turn = match &body.password {
        Some(_) => Some(hash_turn(&app).await?),
        None => None,
    };
    let shared = Arc::clone(&app);
    let (user, secret) = blocking(move || {
        let _turn = turn;
        let user = match (&body.token, &body.name, &body.password) {
            (Some(token), ..) => [SecretKind::Link, SecretKind::Share, SecretKind::Token]
                .into_iter()
                .find_map(|kind| secrets::recognise(&shared.db, kind, token).transpose())
                .transpose()?,
            (None, Some(name), Some(password)) => {
                let long =
                    name.len() > LONGEST_NAME || password.len() > secrets::LONGEST_PASSWORD;
                if long {
                    return Err(not_known());
                }
                if let Err(seconds) = shared.tries.begin(address, name) {
                    let detail = format!("Several tries were wrong. Try again in {seconds} s.");
                    return Err(ApiError::too_many("too many tries", detail, seconds));
                }
                let user = secrets::log_in(&shared.db, name, password)?;
                if user.is_some() {
                    shared.tries.forget(address, name);
                }
                user
            }
            _ => {
                return Err(ApiError::bad_request(
                    "invalid body",
                    "It has `token`, or `name` and `password`.",
                ));
            }
        };
        let Some(user) = user else {
            return Err(not_known());
        };
        let run = user.share.as_deref();
        let (_, secret, _) = secrets::issue(
            &shared.db,
            SecretKind::Session,
            user.id,
            "",
            run,
            30.0,
            user.read_only,
        )?;
        Ok((user, secret))
    })
    .await?;
    let secure = if app.options.behind_proxy {
        "; Secure"
    } else {
        ""
    };
    let set = format!(
        "{}={secret}; Path=/; HttpOnly; SameSite=Lax; Max-Age=2592000{secure}",
        cookie_name(&app)
    );
    Ok(([(header::SET_COOKIE, set)], Json(session_of(&app, &user))).into_response())
}

/// Logs out.
#[utoipa::path(delete, path = "/api/v1/session", responses((status = 204)))]
pub(crate) async fn session_end(
    State(app): Shared,
    LoggedIn(_): LoggedIn,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    if let Some(secret) = cookie(&app, &headers) {
        secrets::revoke(&app.db, SecretKind::Session, secret)?;
    }
    let gone = format!("{}=; Path=/; HttpOnly; Max-Age=0", cookie_name(&app));
    Ok((StatusCode::NO_CONTENT, [(header::SET_COOKIE, gone)]).into_response())
}

pub(crate) fn admin(user: &secrets::User) -> Result<(), ApiError> {
    if user.admin && user.share.is_none() {
        Ok(())
    } else {
        Err(ApiError::new(
            StatusCode::FORBIDDEN,
            "not allowed",
            "Administrators manage users.",
        ))
    }
}

/// The users and what they take; for administrators.
#[utoipa::path(get, path = "/api/v1/users", responses((status = 200, body = Vec<UserRow>)))]
pub(crate) async fn user_list(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
) -> Answer<Vec<UserRow>> {
    admin(&user)?;
    blocking(move || {
        let users = {
            let connection = app.db.lock();
            let mut query =
                connection.prepare("SELECT id, name, admin FROM users ORDER BY name LIMIT 200")?;
            let rows = query.query_map([], |row| {
                Ok((
                    row.get::<_, i64>(0)?,
                    row.get::<_, String>(1)?,
                    row.get::<_, bool>(2)?,
                ))
            })?;
            rows.collect::<Result<Vec<_>, _>>()?
        };
        let row = |(id, name, admin)| {
            let usage = app.db.usage(id)?;
            Ok(UserRow { name, admin, usage })
        };
        Ok(Json(
            users
                .into_iter()
                .map(row)
                .collect::<Result<_, ApiError>>()?,
        ))
    })
    .await
}

/// Adds a user, or changes password and limits; for administrators.
#[utoipa::path(post, path = "/api/v1/users", request_body = NewUser, responses((status = 204)))]
pub(crate) async fn user_set(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    JsonBody(body): JsonBody<NewUser>,
) -> Result<StatusCode, ApiError> {
    admin(&user)?;
    cloud_api::names::check_name(&body.name)
        .map_err(|why| ApiError::bad_request("invalid name", why.to_string()))?;
    if body.cores == Some(0) || body.disk.is_some_and(|bytes| bytes > i64::MAX as u64) {
        return Err(ApiError::bad_request(
            "invalid limits",
            "At least 1 core, and a length in bytes.",
        ));
    }
    if body.password.chars().count() < 10 || body.password.len() > secrets::LONGEST_PASSWORD {
        return Err(ApiError::bad_request(
            "invalid password",
            "A password has at least 10 characters, and at most 1,000 bytes.",
        ));
    }
    let turn = hash_turn(&app).await?;
    blocking(move || {
        let _turn = turn;
        secrets::set_user(&app.db, &body)?;
        Ok(StatusCode::NO_CONTENT)
    })
    .await
}

/// The API tokens of this user, without their secrets.
#[utoipa::path(get, path = "/api/v1/tokens", responses((status = 200, body = Vec<TokenRow>)))]
pub(crate) async fn token_list(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
) -> Answer<Vec<TokenRow>> {
    if user.share.is_some() {
        return Err(ApiError::not_found());
    }
    let connection = app.db.lock();
    let mut query = connection
        .prepare("SELECT id, name, expires, read_only FROM secrets WHERE user = ?1 AND kind = 'token' ORDER BY id LIMIT 200")?;
    let rows = query.query_map([user.id], |row| {
        Ok(TokenRow {
            id: row.get(0)?,
            name: row.get(1)?,
            expires: row.get(2)?,
            read_only: row.get(3)?,
            secret: None,
        })
    })?;
    Ok(Json(rows.collect::<Result<Vec<_>, _>>()?))
}

/// Makes an API token; its secret is in this answer alone.
#[utoipa::path(post, path = "/api/v1/tokens", request_body = NewToken, responses((status = 201, body = TokenRow)))]
pub(crate) async fn token_add(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    JsonBody(body): JsonBody<NewToken>,
) -> Result<Response, ApiError> {
    let days = days(body.days)?;
    if body.name.len() > 200 {
        return Err(ApiError::bad_request(
            "the name is too long",
            "At most 200 bytes.",
        ));
    }
    let (id, secret, expires) = secrets::issue(
        &app.db,
        SecretKind::Token,
        user.id,
        &body.name,
        None,
        days,
        body.read_only,
    )?;
    let row = TokenRow {
        id,
        name: body.name,
        expires,
        read_only: body.read_only,
        secret: Some(secret),
    };
    Ok((StatusCode::CREATED, Json(row)).into_response())
}

/// Takes an API token back.
#[utoipa::path(delete, path = "/api/v1/tokens/{id}", params(("id" = i64, Path)), responses((status = 204)))]
pub(crate) async fn token_remove(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
) -> Result<StatusCode, ApiError> {
    let id: i64 = id.parse().map_err(|_| ApiError::not_found())?;
    let removed = app.db.lock().execute(
        "DELETE FROM secrets WHERE id = ?1 AND user = ?2 AND kind = 'token'",
        params![id, user.id],
    )?;
    if removed == 1 {
        Ok(StatusCode::NO_CONTENT)
    } else {
        Err(ApiError::not_found())
    }
}
