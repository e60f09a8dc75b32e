//! Web hooks: messages to a URL of the user at the end of each run.
//!
//! A message is written in the transaction that ends the run, so each end has one, also where the server is killed. It is sent until it is
//! answered by a 2xx: one that was sent and not recorded is sent again, with the same number.

mod send;

use std::sync::{Arc, mpsc};
use std::thread;
use std::time::Duration;

use anyhow::{Context, Result};
use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use cloud_api::answers::{Hook, HookSecret};
use cloud_api::requests::NewHook;
use serde_json::Value;
use ureq::Agent;

use crate::access::{ApiError, LoggedIn};
use crate::db::{Due, Tried, now};
use crate::routes::{Answer, JsonBody, Shared};
use crate::runs::blocking;
use crate::secrets;
use crate::state::App;

/// How many messages are sent at once, one for each user.
const AT_ONCE: usize = 8;

/// How often a message is sent.
const MOST_TRIES: u32 = 6;

/// Growth of the wait from one try to the next: 10 s, 1 min, 6 min, 36 min, 3.6 h with the default of `--retry-wait`.
const GROWTH: u32 = 6;

/// Seconds from one look for messages to the next, at most and at least; the latter also where the database fails.
const LOOKS: [f64; 2] = [0.05, 60.0];

/// News for the thread that sends.
pub(crate) enum News {
    /// A message was added.
    Added,
    /// Nothing of this user is on its way any more.
    Over(i64),
}

/// Starts the thread that sends. Returns where its news go.
pub(crate) fn begin(app: &Arc<App>) -> Result<mpsc::Sender<News>> {
    let (send, receive) = mpsc::channel();
    let (app, news) = (Arc::clone(app), send.clone());
    let work = move || {
        // Made with the first message: it reads the certificates of the machine.
        let mut client = None;
        let mut busy = Vec::new();
        loop {
            let wait = match look(&app, &news, &mut client, &mut busy) {
                Ok(wait) => wait.unwrap_or(LOOKS[1]).clamp(LOOKS[0], LOOKS[1]),
                Err(error) => {
                    eprintln!("web hooks: {error:#}");
                    LOOKS[1]
                }
            };
            match receive.recv_timeout(Duration::from_secs_f64(wait)) {
                Ok(News::Over(user)) => busy.retain(|one| *one != user),
                Ok(News::Added) | Err(mpsc::RecvTimeoutError::Timeout) => {}
                Err(mpsc::RecvTimeoutError::Disconnected) => return,
            }
        }
    };
    thread::Builder::new().name("hooks".into()).spawn(work)?;
    Ok(send)
}

/// Begins to send what is due. Returns the seconds until something else is.
fn look(
    app: &Arc<App>,
    news: &mpsc::Sender<News>,
    client: &mut Option<Agent>,
    busy: &mut Vec<i64>,
) -> Result<Option<f64>> {
    while busy.len() < AT_ONCE {
        let Some(due) = app.db.begin_delivery(busy)? else {
            return Ok(app.db.next_delivery(busy)?);
        };
        let client = client.get_or_insert_with(|| send::client(app.options.hooks_to.clone()));
        let (app, news, client) = (Arc::clone(app), news.clone(), client.clone());
        let user = due.user;
        let deliver = move || {
            if let Err(error) = deliver(&app, &client, &due) {
                eprintln!("web hook, message {}: {error:#}", due.id);
                // It is still due, and its receiver must not get it again and again.
                thread::sleep(Duration::from_secs_f64(LOOKS[1]));
            }
            // The thread ends with the program.
            let _ = news.send(News::Over(due.user));
        };
        thread::Builder::new().name("hook".into()).spawn(deliver)?;
        busy.push(user);
    }
    Ok(None)
}

/// Sends a message, and records the outcome.
fn deliver(app: &App, client: &Agent, due: &Due) -> Result<()> {
    let mut body: Value = serde_json::from_str(&due.body).context("its body")?;
    body["delivery"] = due.id.into();
    if let Some(run) = body["run"].as_str() {
        body["link"] = format!("{}runs/{run}", app.address()).into();
    }
    let to = (due.url.as_str(), due.secret.as_str());
    let (status, why) = send::send(client, to, due.id, now() as u64, &body.to_string());
    let again = why.is_some() && due.tries + 1 < MOST_TRIES;
    let tried = Tried {
        status,
        wait: again.then(|| app.options.first_wait * f64::from(GROWTH.pow(due.tries))),
        message: why.unwrap_or_default(),
    };
    Ok(app.db.end_delivery(due, &tried)?)
}

/// The web hook of this user, with its last deliveries.
#[utoipa::path(get, path = "/api/v1/hook", responses((status = 200, body = Hook)))]
pub(crate) async fn hook_get(State(app): Shared, LoggedIn(user): LoggedIn) -> Answer<Hook> {
    blocking(move || hook_of(&app, user.id)).await
}

fn hook_of(app: &App, user: i64) -> Answer<Hook> {
    Ok(Json(Hook {
        url: app.db.hook(user)?,
        deliveries: app.db.deliveries(user)?,
    }))
}

/// Sets the web hook of this user. Its secret is in this answer alone, and is another one each time.
#[utoipa::path(put, path = "/api/v1/hook", request_body = NewHook, responses((status = 200, body = HookSecret)))]
pub(crate) async fn hook_set(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    JsonBody(body): JsonBody<NewHook>,
) -> Answer<HookSecret> {
    send::check(&body.url, &app.options.hooks_to)
        .map_err(|why| ApiError::bad_request("not a URL of a web hook", why))?;
    blocking(move || {
        let secret = secrets::random()?;
        app.db.set_hook(user.id, &body.url, &secret)?;
        Ok(Json(HookSecret { secret }))
    })
    .await
}

/// Removes the web hook of this user, with its deliveries.
#[utoipa::path(delete, path = "/api/v1/hook", responses((status = 204)))]
pub(crate) async fn hook_remove(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
) -> Result<StatusCode, ApiError> {
    blocking(move || match app.db.remove_hook(user.id)? {
        true => Ok(StatusCode::NO_CONTENT),
        false => Err(no_hook()),
    })
    .await
}

/// Sends a test to the web hook of this user. The answer has its delivery, which waits.
#[utoipa::path(post, path = "/api/v1/hook/test", responses((status = 200, body = Hook)))]
pub(crate) async fn hook_test(State(app): Shared, LoggedIn(user): LoggedIn) -> Answer<Hook> {
    blocking(move || {
        if app.db.hook(user.id)?.is_none() {
            return Err(no_hook());
        }
        if !app.db.test_hook(user.id)? {
            let detail = "A test is on its way. See its delivery.";
            return Err(ApiError::new(StatusCode::CONFLICT, "not sent", detail));
        }
        app.tell_hooks();
        hook_of(&app, user.id)
    })
    .await
}

fn no_hook() -> ApiError {
    let detail = "You have no web hook. `PUT /hook`, the page of your account or `mercury-cloud hook set URL` sets one.";
    ApiError::new(StatusCode::NOT_FOUND, "no web hook", detail)
}
