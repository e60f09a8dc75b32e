//! Sessions, users, tokens, links to runs, and the link of the machine.

use std::net::IpAddr;
use std::sync::Arc;
use std::time::Duration;

use axum::extract::{Path, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::{Extension, Json};
use cloud_api::answers::{Price, Session, SessionRow, TokenRow, Usage, UserRow};
use cloud_api::lifecycle::RunEvent;
use cloud_api::names::LONGEST_NAME;
use cloud_api::requests::{LogIn, NewLink, NewToken, NewUser};
use rusqlite::OptionalExtension;

use crate::access::{
    Admin, Anyone, ApiError, Client, LoggedIn, cookie, cookie_name, not_logged_in,
};
use crate::audit::Actor;
use crate::db::Applied;
use crate::inputs;
use crate::routes::{Answer, JsonBody, Shared, days};
use crate::runs::{self, blocking};
use crate::secrets::{self, Caller, NewSecret, Right, SecretKind};
use crate::state::App;
use crate::turns::Turn;
use crate::users;

fn session_of(app: &App, caller: &Caller) -> Session {
    let Caller::User(user) = caller else {
        return Session {
            user: String::new(),
            admin: false,
            read_only: true,
            cores: [0, 0],
            ranks: 1,
            solver: app.version.clone(),
            usage: Usage::default(),
            price: None,
        };
    };
    let cores = app.options.cores;
    let busy: u32 = app.db.live().map_or(0, |runs| {
        runs.iter()
            .filter(|live| live.run.state.has_attempt())
            .map(|live| live.cores() as u32)
            .sum()
    });
    Session {
        user: user.name.clone(),
        admin: user.admin,
        read_only: user.read_only,
        cores: [cores.saturating_sub(busy), cores],
        ranks: app.engine.abilities().ranks,
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
pub(crate) async fn session_get(State(app): Shared, Anyone(caller): Anyone) -> Answer<Session> {
    Ok(Json(session_of(&app, &caller)))
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

/// Waits for a turn of an address to hash a password.
async fn hash_turn(app: &App, address: IpAddr) -> Result<Turn, ApiError> {
    match tokio::time::timeout(HASH_TURN, app.hashes.take(address)).await {
        Ok(turn) => turn,
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
    Extension(actor): Extension<Actor>,
    JsonBody(body): JsonBody<LogIn>,
) -> Result<Response, ApiError> {
    let mut turn = None;
    if let (None, Some(name), Some(password)) = (&body.token, &body.name, &body.password) {
        if name.len() > LONGEST_NAME || password.len() > users::LONGEST_PASSWORD {
            return Err(not_known());
        }
        if let Err(seconds) = app.tries.begin(address, name) {
            let detail = format!("Several tries were wrong. Try again in {seconds} s.");
            return Err(ApiError::too_many("too many tries", detail, seconds));
        }
        // Only a try that is allowed waits for its turn; one that gets none was not made.
        let given = hash_turn(&app, address).await;
        if given.is_err() {
            app.tries.take_back(address, name);
        }
        turn = Some(given?);
    }
    let shared = Arc::clone(&app);
    let (caller, secret) = blocking(move || {
        let _turn = turn;
        let hash;
        let found = match (&body.token, &body.name, &body.password) {
            (Some(token), ..) => [SecretKind::Link, SecretKind::Share, SecretKind::Token]
                .into_iter()
                .find_map(|kind| {
                    let caller = secrets::recognise(&shared.db, kind, token).transpose()?;
                    Some(caller.map(|caller| (caller, kind)))
                })
                .transpose()?
                .map(|(caller, kind)| {
                    let right = match (kind, caller.secret()) {
                        // Good once: of two requests at the same time one gets a session.
                        (SecretKind::Link, Some(link)) => Right::Link(link),
                        (_, secret) => secret.map_or(Right::Server, Right::Secret),
                    };
                    (caller, right)
                }),
            (None, Some(name), Some(password)) => {
                let found = users::log_in(&shared.db, name, password)?;
                if found.is_some() {
                    shared.tries.forget(address, name);
                }
                match found {
                    Some((user, found)) => {
                        hash = found;
                        Some((Caller::User(user), Right::Password(&hash)))
                    }
                    None => None,
                }
            }
            _ => {
                return Err(ApiError::bad_request(
                    "invalid body",
                    "It has `token`, or `name` and `password`.",
                ));
            }
        };
        let Some((caller, right)) = found else {
            return Err(not_known());
        };
        let (user, run, root) = match &caller {
            Caller::User(user) => (user.id, None, user.root),
            Caller::Guest(guest) => (guest.owner, Some(guest.run.as_str()), guest.root),
        };
        let session = NewSecret {
            kind: SecretKind::Session,
            user,
            right,
            root,
            name: "",
            run,
            days: 30.0,
            read_only: caller.is_read_only(),
        };
        let issued = secrets::issue(&shared.db, &session)?.ok_or_else(not_known)?;
        actor.set(caller.name());
        Ok((caller, issued.secret))
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
    Ok(([(header::SET_COOKIE, set)], Json(session_of(&app, &caller))).into_response())
}

/// Logs out.
#[utoipa::path(delete, path = "/api/v1/session", responses((status = 204)))]
pub(crate) async fn session_end(
    State(app): Shared,
    Anyone(_): Anyone,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    if let Some(secret) = cookie(&app, &headers) {
        secrets::revoke(&app.db, SecretKind::Session, secret)?;
    }
    let gone = format!("{}=; Path=/; HttpOnly; Max-Age=0", cookie_name(&app));
    Ok((StatusCode::NO_CONTENT, [(header::SET_COOKIE, gone)]).into_response())
}

/// The users and what they take; for administrators.
#[utoipa::path(get, path = "/api/v1/users", responses((status = 200, body = Vec<UserRow>)))]
pub(crate) async fn user_list(State(app): Shared, Admin(_): Admin) -> Answer<Vec<UserRow>> {
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
    Admin(user): Admin,
    Client(address): Client,
    JsonBody(body): JsonBody<NewUser>,
) -> Result<StatusCode, ApiError> {
    cloud_api::names::check_name(&body.name)
        .map_err(|why| ApiError::bad_request("invalid name", why.to_string()))?;
    if body.cores == Some(Some(0))
        || body
            .disk
            .flatten()
            .is_some_and(|bytes| bytes > i64::MAX as u64)
        || (body.core_seconds.flatten()).is_some_and(|most| !most.is_finite() || most < 0.0)
    {
        return Err(ApiError::bad_request(
            "invalid limits",
            "At least 1 core, a length in bytes, and core seconds of 0 or more.",
        ));
    }
    if (body.password.as_ref()).is_some_and(|password| {
        password.chars().count() < 10 || password.len() > users::LONGEST_PASSWORD
    }) {
        return Err(ApiError::bad_request(
            "invalid password",
            "A password has at least 10 characters, and at most 1,000 bytes.",
        ));
    }
    let turn = match &body.password {
        Some(_) => Some(hash_turn(&app, address).await?),
        None => None,
    };
    blocking(move || {
        let _turn = turn;
        users::set_user(&app.db, (user.id, user.right()), &body)?.map_err(refused)?;
        Ok(StatusCode::NO_CONTENT)
    })
    .await
}

fn refused(why: users::BadUser) -> ApiError {
    let status = match why {
        users::BadUser::NotAdmin => StatusCode::FORBIDDEN,
        _ => StatusCode::CONFLICT,
    };
    ApiError::new(status, "the user was not changed", why.to_string())
}

/// Removes a user with all secrets, runs and inputs; for administrators. While the user has live runs they are ended, and the answer is 409.
#[utoipa::path(delete, path = "/api/v1/users/{name}", params(("name" = String, Path)), responses((status = 204)))]
pub(crate) async fn user_remove(
    State(app): Shared,
    Admin(user): Admin,
    Path(name): Path<String>,
) -> Result<StatusCode, ApiError> {
    blocking(move || {
        let id = "SELECT id FROM users WHERE name = ?1";
        let id: Option<i64> = (app.db.lock())
            .query_row(id, [&name], |row| row.get(0))
            .optional()?;
        let id = id.ok_or_else(ApiError::not_found)?;
        // Before runs are ended and removed.
        users::may_be_removed(&app.db.lock(), id)?.map_err(refused)?;
        let runs = app.db.runs_of(id)?;
        let live = runs.iter().filter(|(_, state)| state.is_live()).count();
        for (run, _) in runs.iter().filter(|(_, state)| state.is_live()) {
            if let Applied::Done(_, events) =
                (app.db).apply(run, &RunEvent::Kill, None, app.engine.as_ref())?
            {
                app.publish(events);
            }
        }
        app.wake_reconciler();
        if live > 0 {
            return Err(ApiError::new(
                StatusCode::CONFLICT,
                "the user has live runs",
                format!("{live} runs are being ended. Send the request again in a few seconds."),
            ));
        }
        for (run, _) in &runs {
            runs::forget(&app, run)?;
        }
        let gone = users::remove_user(&app.db, (user.id, user.right()), id)?.map_err(refused)?;
        inputs::remove(&app, &gone)?;
        Ok(StatusCode::NO_CONTENT)
    })
    .await
}

/// The sessions of this user.
#[utoipa::path(get, path = "/api/v1/sessions", responses((status = 200, body = Vec<SessionRow>)))]
pub(crate) async fn session_list(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
) -> Answer<Vec<SessionRow>> {
    let row = |found: secrets::Listed| SessionRow {
        id: found.id,
        token: found.made_with,
        created: found.created,
        expires: found.expires,
        read_only: found.read_only,
        current: user.secret == Some(found.id),
    };
    let found = secrets::list(&app.db, SecretKind::Session, Some(user.id), None)?;
    Ok(Json(found.into_iter().map(row).collect()))
}

/// Ends a session of this user.
#[utoipa::path(delete, path = "/api/v1/sessions/{id}", params(("id" = i64, Path)), responses((status = 204)))]
pub(crate) async fn session_remove(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
) -> Result<StatusCode, ApiError> {
    take_back(&app, &user, SecretKind::Session, &id)
}

/// Logs this user out everywhere.
#[utoipa::path(delete, path = "/api/v1/sessions", responses((status = 204)))]
pub(crate) async fn session_remove_all(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
) -> Result<StatusCode, ApiError> {
    secrets::end_sessions(&app.db, user.id)?;
    Ok(StatusCode::NO_CONTENT)
}

/// Takes a secret of this user back, with all that were made with it.
fn take_back(
    app: &App,
    user: &secrets::User,
    kind: SecretKind,
    id: &str,
) -> Result<StatusCode, ApiError> {
    let id: i64 = id.parse().map_err(|_| ApiError::not_found())?;
    if secrets::take_back(&app.db, kind, user.id, id)? {
        Ok(StatusCode::NO_CONTENT)
    } else {
        Err(ApiError::not_found())
    }
}

fn row_of(found: secrets::Listed) -> TokenRow {
    TokenRow {
        id: found.id,
        name: found.name,
        run: found.run,
        expires: found.expires,
        read_only: found.read_only,
        secret: None,
    }
}

/// The links to runs of this user, without their secrets.
#[utoipa::path(get, path = "/api/v1/shares", responses((status = 200, body = Vec<TokenRow>)))]
pub(crate) async fn share_list(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
) -> Answer<Vec<TokenRow>> {
    let found = secrets::list(&app.db, SecretKind::Share, Some(user.id), None)?;
    Ok(Json(found.into_iter().map(row_of).collect()))
}

/// The links to a run, for users who may change it.
#[utoipa::path(get, path = "/api/v1/runs/{run}/shares", params(("run" = String, Path)), responses((status = 200, body = Vec<TokenRow>)))]
pub(crate) async fn run_shares(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
) -> Answer<Vec<TokenRow>> {
    let run = runs::changeable_run(&app, &user, &id)?;
    let found = secrets::list(&app.db, SecretKind::Share, None, Some(run.id.as_str()))?;
    Ok(Json(found.into_iter().map(row_of).collect()))
}

/// Takes a link to a run back, with its sessions.
#[utoipa::path(delete, path = "/api/v1/shares/{id}", params(("id" = i64, Path)), responses((status = 204)))]
pub(crate) async fn share_remove(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
) -> Result<StatusCode, ApiError> {
    take_back(&app, &user, SecretKind::Share, &id)
}

/// A link that logs in the user of this machine: good once, within a day. For that user.
#[utoipa::path(post, path = "/api/v1/links", request_body = NewLink, responses((status = 201, body = TokenRow)))]
pub(crate) async fn link_add(
    State(app): Shared,
    Admin(user): Admin,
    JsonBody(body): JsonBody<NewLink>,
) -> Result<Response, ApiError> {
    if user.id != secrets::LOCAL_ID {
        let detail = "The user of the machine makes links.";
        return Err(ApiError::new(StatusCode::FORBIDDEN, "not allowed", detail));
    }
    blocking(move || {
        let (right, root) = if body.rotate {
            let token = app.rotate(user.right())?.ok_or_else(not_logged_in)?;
            // The secret of the request may be one of those that have ended: the new one has their place.
            let root = match user.root {
                Some((root, _)) if !secrets::is_good(&app.db, root)? => {
                    Some((token.id, token.expires))
                }
                root => root,
            };
            (Right::Server, root)
        } else {
            (user.right(), user.root)
        };
        let link = secrets::link(&app.db, right, root)?;
        let link = link.ok_or_else(not_logged_in)?;
        let row = TokenRow {
            id: 0,
            name: "link".to_owned(),
            run: None,
            expires: link.expires,
            read_only: false,
            secret: Some(link.secret),
        };
        Ok((StatusCode::CREATED, Json(row)).into_response())
    })
    .await
}

/// The API tokens of this user, without their secrets.
#[utoipa::path(get, path = "/api/v1/tokens", responses((status = 200, body = Vec<TokenRow>)))]
pub(crate) async fn token_list(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
) -> Answer<Vec<TokenRow>> {
    let found = secrets::list(&app.db, SecretKind::Token, Some(user.id), None)?;
    Ok(Json(found.into_iter().map(row_of).collect()))
}

/// Makes an API token; its secret is in this answer alone.
#[utoipa::path(post, path = "/api/v1/tokens", request_body = NewToken, responses((status = 201, body = TokenRow)))]
pub(crate) async fn token_add(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    JsonBody(body): JsonBody<NewToken>,
) -> Result<Response, ApiError> {
    let days = days(body.days)?;
    runs::checked_text("name", &body.name)?;
    blocking(move || {
        let token = NewSecret {
            kind: SecretKind::Token,
            user: user.id,
            right: user.right(),
            root: user.root,
            name: &body.name,
            run: None,
            days,
            read_only: body.read_only,
        };
        let issued = secrets::issue(&app.db, &token)?.ok_or_else(not_logged_in)?;
        let row = TokenRow {
            id: issued.id,
            name: body.name,
            run: None,
            expires: issued.expires,
            read_only: body.read_only,
            secret: Some(issued.secret),
        };
        Ok((StatusCode::CREATED, Json(row)).into_response())
    })
    .await
}

/// Takes an API token back.
#[utoipa::path(delete, path = "/api/v1/tokens/{id}", params(("id" = i64, Path)), responses((status = 204)))]
pub(crate) async fn token_remove(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
) -> Result<StatusCode, ApiError> {
    take_back(&app, &user, SecretKind::Token, &id)
}
