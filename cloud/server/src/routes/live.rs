//! Routes that follow what happens: live events, and counts for Prometheus.

use std::collections::BTreeSet;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::sse::{Event as Sse, KeepAlive};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use tokio_stream::wrappers::ReceiverStream;

use super::{QueryParams, Shared};
use crate::access::{Admin, Anyone, ApiError};
use crate::db::MOST_ROWS;
use crate::downloads;
use crate::runs::blocking;
use crate::secrets::Caller;
use crate::state::App;

/// How often a stream of events without any says that it lives.
const KEEP_ALIVE: Duration = Duration::from_secs(15);

#[derive(Deserialize)]
pub(crate) struct EventsQuery {
    #[serde(default)]
    runs: String,
    after: Option<i64>,
}

/// How often the right to a stream of events is looked at again.
const RECHECK: Duration = Duration::from_secs(5);

/// Whether a user or guest may see all of these runs, and the secret of the stream is good. An answer that does not come is a no.
async fn may(app: &Arc<App>, caller: &Arc<Caller>, runs: &Arc<BTreeSet<String>>) -> bool {
    let (app, caller, runs) = (Arc::clone(app), Arc::clone(caller), Arc::clone(runs));
    let may = blocking(move || Ok(app.db.may_see(&caller, &runs)?)).await;
    may.unwrap_or(false)
}

/// Live events: first what happened since `Last-Event-ID`, then what happens.
#[utoipa::path(get, path = "/api/v1/events", params(("runs" = Option<String>, Query), ("after" = Option<i64>, Query), ("Last-Event-ID" = Option<String>, Header)),
    responses((status = 200, content_type = "text/event-stream")))]
pub(crate) async fn events(
    State(app): Shared,
    Anyone(caller): Anyone,
    QueryParams(query): QueryParams<EventsQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let mut wanted: BTreeSet<String> = query
        .runs
        .split(',')
        .filter(|run| !run.is_empty())
        .map(str::to_owned)
        .collect();
    if wanted.len() > MOST_ROWS {
        return Err(ApiError::bad_request(
            "too many runs",
            "At most 200 at once; none: all of yours.",
        ));
    }
    // All of a user, without any other.
    let mut of = None;
    match &caller {
        _ if !wanted.is_empty() => {}
        Caller::User(user) => of = Some(user.id),
        Caller::Guest(guest) => wanted.extend([guest.run.clone()]),
    }
    let (caller, wanted) = (Arc::new(caller), Arc::new(wanted));
    if !may(&app, &caller, &wanted).await {
        return Err(ApiError::not_found());
    }
    let turn = downloads::turn(&app.streams, &caller).await?;
    // Heard from now on, so that nothing falls between the replay and the news.
    let mut news = app.news.subscribe();
    let last = headers
        .get("last-event-id")
        .and_then(|id| id.to_str().ok()?.parse::<i64>().ok())
        .or(query.after);
    let shared = Arc::clone(&app);
    let newest = blocking(move || Ok(shared.db.newest_event()?)).await?;
    let (send, receive) = tokio::sync::mpsc::channel::<Result<Sse, Infallible>>(64);
    let mut closing = app.closing();
    tokio::spawn(async move {
        let _turn = turn;
        let hears = |run: &String| of.is_some() || wanted.contains(run);
        // So that a listener that comes back later knows from where on.
        let mut at = last.unwrap_or(newest).min(newest);
        let hello = Sse::default().event("hello").id(at.to_string()).data("{}");
        if send.send(Ok(hello)).await.is_err() {
            return;
        }
        loop {
            let shared = Arc::clone(&app);
            let rows = blocking(move || Ok(shared.db.events(of, None, at)?)).await;
            // The log has the error.
            let Ok(rows) = rows else { return };
            let Some(end) = rows.last().map(|row| row.id) else {
                break;
            };
            for row in rows.iter().filter(|row| hears(&row.run)) {
                let text = serde_json::to_string(row).unwrap_or_default();
                if send
                    .send(Ok(Sse::default().id(row.id.to_string()).data(text)))
                    .await
                    .is_err()
                {
                    return;
                }
            }
            at = end;
        }
        let mut again = tokio::time::interval(RECHECK);
        loop {
            let message = tokio::select! {
                message = news.recv() => message,
                _ = again.tick() => match may(&app, &caller, &wanted).await {
                    true => continue,
                    false => return,
                },
                () = send.closed() => return,
                _ = closing.changed() => return,
            };
            let event = match message {
                Ok(message)
                    if !of.map_or_else(
                        || wanted.contains(&message.run),
                        |user| message.audience.contains(&user),
                    ) =>
                {
                    continue;
                }
                Ok(message) => match message.id {
                    // Part of the replay already.
                    Some(id) if id <= at => continue,
                    Some(id) => Sse::default().id(id.to_string()).data(&message.text),
                    None => Sse::default().data(&message.text),
                },
                Err(tokio::sync::broadcast::error::RecvError::Lagged(_)) => {
                    Sse::default().event("lagged").data("{}")
                }
                Err(tokio::sync::broadcast::error::RecvError::Closed) => return,
            };
            // A listener that does not read is not waited for: it misses some, and hears so.
            match send.try_send(Ok(event)) {
                Ok(()) => {}
                Err(tokio::sync::mpsc::error::TrySendError::Closed(_)) => return,
                Err(tokio::sync::mpsc::error::TrySendError::Full(_)) => {
                    let lagged = Sse::default().event("lagged").data("{}");
                    tokio::select! {
                        sent = send.send(Ok(lagged)) => if sent.is_err() { return },
                        _ = closing.changed() => return,
                    }
                }
            }
        }
    });
    let sse = axum::response::Sse::new(ReceiverStream::new(receive))
        .keep_alive(KeepAlive::new().interval(KEEP_ALIVE));
    Ok(([("x-accel-buffering", "no")], sse).into_response())
}

/// Counts for Prometheus. No names of runs or users.
pub(super) async fn metrics(State(app): Shared, Admin(_): Admin) -> Result<String, ApiError> {
    let connection = app.db.lock();
    let mut query = connection.prepare("SELECT state, count(*) FROM runs GROUP BY state")?;
    let rows = query.query_map([], |row| {
        Ok((row.get::<_, String>(0)?, row.get::<_, i64>(1)?))
    })?;
    let mut text = String::from("# TYPE mercury_runs gauge\n");
    for row in rows {
        let (state, count) = row?;
        text += &format!("mercury_runs{{state=\"{state}\"}} {count}\n");
    }
    text += &format!(
        "# TYPE mercury_listeners gauge\nmercury_listeners {}\n",
        app.news.receiver_count()
    );
    Ok(text)
}
