//! The user of a request, and checks before any handler.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr};
use std::sync::Arc;
use std::sync::atomic::Ordering;

use axum::extract::{FromRequestParts, MatchedPath, Request, State};
use axum::http::header::{self, HeaderMap, HeaderName, HeaderValue};
use axum::http::{Extensions, Method, StatusCode, request::Parts};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use cloud_api::Problem;
use cloud_api::problem::SceneProblem;

use crate::audit::Actor;
use crate::connections::Peer;
use crate::secrets::{self, Caller, SecretKind, User};
use crate::state::App;

/// The cookie of a session. With TLS it has the prefix that binds it to this host; without, browsers send it to all ports of the host,
/// so each server of a machine has its own.
pub(crate) fn cookie_name(app: &App) -> String {
    if app.options.behind_proxy {
        "__Host-mercury".to_owned()
    } else {
        format!("mercury-{}", app.port.load(Ordering::Relaxed))
    }
}

/// An answer that is an error, without details of the server.
#[derive(Debug)]
pub(crate) struct ApiError {
    problem: Box<Problem>,
    /// Seconds after which the request may be sent again.
    retry_after: Option<u64>,
}

impl ApiError {
    pub(crate) fn new(
        status: StatusCode,
        title: impl Into<String>,
        detail: impl Into<String>,
    ) -> Self {
        let (title, detail) = (title.into(), detail.into());
        Self {
            problem: Box::new(Problem {
                title,
                status: status.as_u16(),
                detail,
                problems: Vec::new(),
            }),
            retry_after: None,
        }
    }

    /// Too many requests; the next one is taken after so many seconds.
    pub(crate) fn too_many(title: &str, detail: impl Into<String>, seconds: u64) -> Self {
        Self {
            retry_after: Some(seconds),
            ..Self::new(StatusCode::TOO_MANY_REQUESTS, title, detail)
        }
    }

    pub(crate) fn bad_request(title: impl Into<String>, detail: impl Into<String>) -> Self {
        Self::new(StatusCode::BAD_REQUEST, title, detail)
    }

    /// Also for things of others: an answer must not show whether they exist.
    pub(crate) fn not_found() -> Self {
        Self::new(
            StatusCode::NOT_FOUND,
            "not found",
            "It does not exist, or you have no access to it.",
        )
    }

    pub(crate) fn unrunnable(problems: Vec<SceneProblem>) -> Self {
        let mut error = Self::new(
            StatusCode::UNPROCESSABLE_ENTITY,
            "the scene cannot run",
            "See its problems.",
        );
        error.problem.problems = problems;
        error
    }

    /// An error of the server. Its log has the message.
    pub(crate) fn internal(error: impl std::fmt::Display) -> Self {
        eprintln!("{error:#}");
        Self::new(
            StatusCode::INTERNAL_SERVER_ERROR,
            "the server failed",
            "See the log of the server.",
        )
    }
}

impl IntoResponse for ApiError {
    fn into_response(self) -> Response {
        let status =
            StatusCode::from_u16(self.problem.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let mut response = (status, axum::Json(*self.problem)).into_response();
        let kind = HeaderValue::from_static("application/problem+json");
        response.headers_mut().insert(header::CONTENT_TYPE, kind);
        if let Some(seconds) = self.retry_after {
            let headers = response.headers_mut();
            headers.insert(header::RETRY_AFTER, HeaderValue::from(seconds));
        }
        response
    }
}

impl From<anyhow::Error> for ApiError {
    fn from(error: anyhow::Error) -> Self {
        Self::internal(error)
    }
}

impl From<rusqlite::Error> for ApiError {
    fn from(error: rusqlite::Error) -> Self {
        Self::internal(error)
    }
}

impl From<std::io::Error> for ApiError {
    fn from(error: std::io::Error) -> Self {
        Self::internal(error)
    }
}

impl From<cloud_store::StoreError> for ApiError {
    fn from(error: cloud_store::StoreError) -> Self {
        eprintln!("{error}");
        Self::new(
            StatusCode::SERVICE_UNAVAILABLE,
            "the store does not respond",
            "Try again in a minute.",
        )
    }
}

/// The user or guest of a request; without one the answer is 401.
pub(crate) struct Anyone(pub(crate) Caller);

/// The user of a request. For guests its path is not there.
pub(crate) struct LoggedIn(pub(crate) User);

/// The administrator of a request.
pub(crate) struct Admin(pub(crate) User);

/// Address of the client of a request.
pub(crate) struct Client(pub(crate) IpAddr);

/// Address of the client of a request.
pub(crate) fn client_address(app: &App, headers: &HeaderMap, extensions: &Extensions) -> IpAddr {
    let peer = extensions.get::<Peer>();
    let address = peer.map_or(Ipv4Addr::UNSPECIFIED.into(), |peer| peer.0);
    // The proxy adds the address of its client at the end; what stands before is what that client says.
    let header = headers.get_all("x-forwarded-for").into_iter().next_back();
    let forwarded = header.filter(|_| app.options.behind_proxy).and_then(|all| {
        let last = all.to_str().ok()?.rsplit(',').next()?.trim();
        last.parse::<IpAddr>().ok()
    });
    match forwarded.unwrap_or(address).to_canonical() {
        // A network of IPv6 is one client: it has as many addresses as it wants.
        IpAddr::V6(address) => Ipv6Addr::from(u128::from(address) >> 64 << 64).into(),
        address => address,
    }
}

impl FromRequestParts<Arc<App>> for Client {
    type Rejection = std::convert::Infallible;

    async fn from_request_parts(
        parts: &mut Parts,
        app: &Arc<App>,
    ) -> Result<Self, Self::Rejection> {
        Ok(Self(client_address(app, &parts.headers, &parts.extensions)))
    }
}

/// An answer that a request has no secret that is good.
pub(crate) fn not_logged_in() -> ApiError {
    ApiError::new(
        StatusCode::UNAUTHORIZED,
        "not logged in",
        "Open the link that `mercury-cloud serve` prints, log in, or send a token.",
    )
}

fn bearer(headers: &HeaderMap) -> Option<&str> {
    headers
        .get(header::AUTHORIZATION)?
        .to_str()
        .ok()?
        .strip_prefix("Bearer ")
}

/// The secret of the session, if the request has one.
pub(crate) fn cookie<'a>(app: &App, headers: &'a HeaderMap) -> Option<&'a str> {
    let wanted = cookie_name(app);
    let all = headers
        .get_all(header::COOKIE)
        .into_iter()
        .filter_map(|value| value.to_str().ok());
    all.flat_map(|value| value.split(';'))
        .filter_map(|pair| pair.trim().split_once('='))
        .find_map(|(name, value)| (name == wanted).then_some(value))
}

impl FromRequestParts<Arc<App>> for Anyone {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, app: &Arc<App>) -> Result<Self, ApiError> {
        let caller = if let Some(token) = bearer(&parts.headers) {
            secrets::recognise(&app.db, SecretKind::Token, token)?
        } else if let Some(secret) = cookie(app, &parts.headers) {
            secrets::recognise(&app.db, SecretKind::Session, secret)?
        } else {
            None
        };
        let caller = caller.or_else(|| {
            let local = app.options.no_auth && bearer(&parts.headers).is_none();
            local.then(|| Caller::User(secrets::local()))
        });
        let caller = caller.ok_or_else(not_logged_in)?;
        if let Some(actor) = parts.extensions.get::<Actor>() {
            actor.set(caller.name());
        }
        // By the route that matched: the end of a path may be a name that a user has chosen.
        let route = parts.extensions.get::<MatchedPath>();
        let logs_out = route.is_some_and(|route| route.as_str() == "/api/v1/session");
        if caller.is_read_only() && !is_safe(&parts.method) && !logs_out {
            let detail = "This link or token is for looking only.";
            return Err(ApiError::new(StatusCode::FORBIDDEN, "not allowed", detail));
        }
        Ok(Self(caller))
    }
}

impl FromRequestParts<Arc<App>> for LoggedIn {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, app: &Arc<App>) -> Result<Self, ApiError> {
        match Anyone::from_request_parts(parts, app).await? {
            Anyone(Caller::User(user)) => Ok(Self(user)),
            Anyone(Caller::Guest(_)) => Err(ApiError::not_found()),
        }
    }
}

impl FromRequestParts<Arc<App>> for Admin {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, app: &Arc<App>) -> Result<Self, ApiError> {
        let detail = "Administrators manage users.";
        match Anyone::from_request_parts(parts, app).await? {
            Anyone(Caller::User(user)) if user.admin => Ok(Self(user)),
            _ => Err(ApiError::new(StatusCode::FORBIDDEN, "not allowed", detail)),
        }
    }
}

fn is_safe(method: &Method) -> bool {
    matches!(*method, Method::GET | Method::HEAD | Method::OPTIONS)
}

/// The host without its port.
fn host_of(authority: &str) -> &str {
    match authority.rsplit_once(':') {
        Some((host, port)) if port.bytes().all(|b| b.is_ascii_digit()) => host,
        _ => authority,
    }
}

/// Refuses foreign hosts (DNS rebinding) and foreign pages (cross-site requests), and adds what browsers must know.
pub(crate) async fn guard(State(app): State<Arc<App>>, request: Request, next: Next) -> Response {
    let refused = refuse(&app, &request);
    let page = !request.uri().path().starts_with("/api/");
    let mut response = match refused {
        Some(fail) => fail.into_response(),
        None => next.run(request).await,
    };
    let headers = response.headers_mut();
    for (name, value) in [
        (
            header::CONTENT_SECURITY_POLICY,
            "default-src 'self'; img-src 'self' blob:; frame-ancestors 'none'; base-uri 'none'; form-action 'self'",
        ),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (
            HeaderName::from_static("cross-origin-opener-policy"),
            "same-origin",
        ),
        (
            HeaderName::from_static("cross-origin-resource-policy"),
            "same-origin",
        ),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    if !page && !headers.contains_key(header::CACHE_CONTROL) {
        headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    }
    response
}

fn refuse(app: &App, request: &Request) -> Option<ApiError> {
    let headers = request.headers();
    let text = |name: HeaderName| headers.get(name).and_then(|value| value.to_str().ok());
    let host = text(header::HOST).unwrap_or_default();
    let ours = |authority: &str| {
        let name = host_of(authority);
        matches!(name, "localhost" | "127.0.0.1" | "[::1]")
            || app.options.hosts.iter().any(|ours| host_of(ours) == name)
            || name == app.options.listen.ip().to_string()
                && !app.options.listen.ip().is_unspecified()
    };
    if !ours(host) {
        let detail =
            "The name in the address is not one of this server; `serve --host NAME` adds one.";
        return Some(ApiError::new(
            StatusCode::MISDIRECTED_REQUEST,
            "another host",
            detail,
        ));
    }
    if is_safe(request.method()) || bearer(headers).is_some() {
        return None;
    }
    // A cookie comes along with any request, whichever page made it.
    let site = text(HeaderName::from_static("sec-fetch-site"));
    let origin = text(header::ORIGIN);
    let same_origin = origin.is_none_or(|origin| {
        origin
            .split_once("://")
            .is_some_and(|(_, authority)| authority == host)
    });
    let from_page = site == Some("same-origin") || (site.is_none() && origin.is_some());
    if same_origin && from_page {
        return None;
    }
    let detail =
        "Requests that change something come from this server's own page, or carry a token.";
    Some(ApiError::new(
        StatusCode::FORBIDDEN,
        "from another page",
        detail,
    ))
}
