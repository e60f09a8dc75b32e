//! Requests to the server, by its API alone.

use std::io::Read;
use std::path::Path;

use anyhow::{Context, Result, anyhow, bail};
use cloud_api::Problem;
use serde_json::Value;
use ureq::tls::{RootCerts, TlsConfig};
use ureq::typestate::WithBody;
use ureq::{Agent, Body, RequestBuilder, http::Response};

use crate::commands::{Usage, data_folder};

/// A server, and what lets us in.
pub(crate) struct Client {
    agent: Agent,
    base: String,
    cookie: String,
}

impl Client {
    /// The server of a link: what is given, `MERCURY_CLOUD_LINK`, or what `serve` has left in its data folder.
    pub(crate) fn connect(link: Option<&str>) -> Result<Self> {
        let link = match link
            .map(str::to_owned)
            .or_else(|| std::env::var("MERCURY_CLOUD_LINK").ok())
        {
            Some(link) => link,
            None => {
                let path = data_folder()?.join("link");
                std::fs::read_to_string(&path).map_err(|_| {
                    anyhow!(Usage("no server is known: start `mercury-cloud serve`, or give its link by --link".into()))
                })?
            }
        };
        let link = link.trim();
        let (base, token) = link
            .split_once("/#token=")
            .unwrap_or((link.trim_end_matches('/'), ""));
        let tls = TlsConfig::builder()
            .root_certs(RootCerts::PlatformVerifier)
            .build();
        let agent: Agent = Agent::config_builder()
            .http_status_as_error(false)
            .tls_config(tls)
            .build()
            .into();
        let mut client = Self {
            agent,
            base: base.to_owned(),
            cookie: String::new(),
        };
        if token.starts_with("mc_") {
            client.cookie = format!("Bearer {token}");
        } else if !token.is_empty() {
            let body = serde_json::json!({"token": token});
            let url = client.url("/session");
            let answer = client
                .agent
                .post(&url)
                .header("origin", base)
                .send_json(&body);
            let answer = answer.with_context(|| format!("{base} does not respond"))?;
            let cookie = answer
                .headers()
                .get("set-cookie")
                .and_then(|value| value.to_str().ok());
            client.cookie = cookie
                .and_then(|cookie| cookie.split(';').next())
                .unwrap_or_default()
                .to_owned();
            checked(answer)?;
        }
        Ok(client)
    }

    fn url(&self, path: &str) -> String {
        format!("{}/api/v1{path}", self.base)
    }

    /// A link of this server that logs in with a secret.
    pub(crate) fn link(&self, secret: &str) -> String {
        format!("{}/#token={secret}", self.base)
    }

    fn secret(&self) -> (&'static str, &str) {
        if self.cookie.starts_with("Bearer ") {
            ("authorization", &self.cookie)
        } else {
            ("cookie", &self.cookie)
        }
    }

    pub(crate) fn get(&self, path: &str) -> Result<Response<Body>> {
        let (name, secret) = self.secret();
        let answer = self.agent.get(self.url(path)).header(name, secret).call();
        checked(answer.with_context(|| format!("{} does not respond", self.base))?)
    }

    pub(crate) fn json(&self, path: &str) -> Result<Value> {
        Ok(self.get(path)?.body_mut().read_json()?)
    }

    pub(crate) fn post(&self, path: &str, body: &Value) -> Result<Value> {
        self.send(self.agent.post(self.url(path)), body)
    }

    pub(crate) fn put(&self, path: &str, body: &Value) -> Result<Value> {
        self.send(self.agent.put(self.url(path)), body)
    }

    /// The answer to a body; without an answer in JSON it is null.
    fn send(&self, request: RequestBuilder<WithBody>, body: &Value) -> Result<Value> {
        let (name, secret) = self.secret();
        let answer = request
            .header(name, secret)
            .header("origin", &self.base)
            .send_json(body)
            .with_context(|| format!("{} does not respond", self.base))?;
        let text = checked(answer)?
            .body_mut()
            .with_config()
            .limit(256 << 20)
            .read_to_string()?;
        Ok(serde_json::from_str(&text).unwrap_or(Value::Null))
    }

    /// Submits a run.
    pub(crate) fn submit(&self, body: &Value, key: Option<&str>) -> Result<Value> {
        let (name, secret) = self.secret();
        let request = self
            .agent
            .post(self.url("/runs"))
            .header(name, secret)
            .header("origin", &self.base);
        let request = match key {
            Some(key) => request.header("idempotency-key", key),
            None => request,
        };
        let answer = request
            .send_json(body)
            .with_context(|| format!("{} does not respond", self.base))?;
        Ok(checked(answer)?
            .body_mut()
            .with_config()
            .limit(16 << 20)
            .read_json()?)
    }

    pub(crate) fn delete(&self, path: &str) -> Result<()> {
        let (name, secret) = self.secret();
        let request = self
            .agent
            .delete(self.url(path))
            .header(name, secret)
            .header("origin", &self.base);
        checked(
            request
                .call()
                .with_context(|| format!("{} does not respond", self.base))?,
        )?;
        Ok(())
    }

    /// Sends a file as an input.
    pub(crate) fn upload(&self, path: &Path, sha256: &str) -> Result<()> {
        let file = std::fs::File::open(path).with_context(|| format!("{}", path.display()))?;
        let (name, secret) = self.secret();
        let request = self
            .agent
            .put(self.url(&format!("/inputs/{sha256}")))
            .header(name, secret);
        let request = request
            .header("origin", &self.base)
            .content_type("application/octet-stream");
        checked(
            request
                .send(&file)
                .with_context(|| format!("{} does not respond", self.base))?,
        )?;
        Ok(())
    }

    /// The whole id of a run that is named by its first digits.
    pub(crate) fn id(&self, named: &str) -> Result<String> {
        if named.len() == 32 {
            return Ok(named.to_owned());
        }
        let mut found = Vec::new();
        let mut after = String::new();
        loop {
            let page = self.json(&format!("/runs{after}"))?;
            let ids = page["runs"]
                .as_array()
                .into_iter()
                .flatten()
                .filter_map(|run| run["id"].as_str());
            found.extend(ids.filter(|id| id.starts_with(named)).map(str::to_owned));
            match page["after"].as_str() {
                Some(next) => after = format!("?after={next}"),
                None => break,
            }
        }
        match &found[..] {
            [id] => Ok(id.clone()),
            [] => bail!("no run of yours begins with {named}"),
            _ => bail!("{} runs begin with {named}", found.len()),
        }
    }
}

/// An answer that is no error.
fn checked(mut answer: Response<Body>) -> Result<Response<Body>> {
    if answer.status().is_success() {
        return Ok(answer);
    }
    let status = answer.status();
    let mut text = String::new();
    answer
        .body_mut()
        .as_reader()
        .take(1 << 20)
        .read_to_string(&mut text)?;
    let Ok(problem) = serde_json::from_str::<Problem>(&text) else {
        bail!("the server answers {status}")
    };
    let mut message = format!("{}. {}", problem.title, problem.detail);
    for found in &problem.problems {
        let place = [
            found.file.clone(),
            found.line.map(|line| line.to_string()),
            found.column.map(|c| c.to_string()),
        ];
        let place: Vec<String> = place.into_iter().flatten().collect();
        let key = found
            .key
            .as_ref()
            .map(|key| format!("{key}: "))
            .unwrap_or_default();
        message += &format!("\n{}: {key}{}", place.join(":"), found.message);
        message.extend(found.help.iter().map(|help| format!("\n    {help}")));
    }
    if status.as_u16() == 422 || status.as_u16() == 400 {
        Err(anyhow!(Usage(message)))
    } else {
        bail!(message)
    }
}
