//! Workers as jobs of AWS Batch.
//!
//! Three calls of its interface are used: `ListJobs`, `SubmitJob`, `TerminateJob` (AWS Batch API Reference). Requests are
//! signed, and credentials found, by the same crate that speaks to the bucket.
//!
//! Batch never tries again by itself (`attempts: 1`). Two equal submissions would run twice, so a job is looked for by its
//! name before it is submitted; where that has failed, the second worker finds that its epoch is taken, and ends.

use std::collections::HashMap;
use std::future::Future;
use std::sync::{Mutex, mpsc};
use std::time::{Duration, Instant};

use object_store::ClientOptions;
use object_store::aws::{AmazonS3Builder, AwsAuthorizer, AwsCredentialProvider};
use object_store::client::{HttpClient, HttpConnector, HttpRequest, ReqwestConnector};
use serde::Deserialize;
use serde_json::{Value, json};
use tokio::runtime::Runtime;

use crate::{Abilities, Engine, EngineError, ImageLayout, Launch, Observed, Stop};

/// States of jobs that have not ended.
const WAITS: [&str; 4] = ["SUBMITTED", "PENDING", "RUNNABLE", "STARTING"];
const RUNS: &str = "RUNNING";

/// From SIGTERM to SIGKILL, in s; Batch has no setting for it (AWS Batch User Guide, "Job timeouts").
const GRACE: f64 = 30.0;

/// How long a request may take.
const PATIENCE: Duration = Duration::from_secs(20);

/// Settings of an account: `batch.toml`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Account {
    /// Queues. The first is tried first; the next ones after `losses` attempts in a row without progress each.
    pub queues: Vec<String>,
    /// Definition of the job: image, roles, log.
    pub definition: String,
    /// Attempts in a row without progress before the next queue is taken.
    #[serde(default = "two")]
    pub losses: u32,
    /// Least seconds between two looks at all jobs.
    #[serde(default = "ten")]
    pub poll: f64,
    /// Where the programs are in the image.
    #[serde(flatten)]
    pub image: ImageLayout,
}

fn two() -> u32 {
    2
}

fn ten() -> f64 {
    10.0
}

/// Jobs that have not ended, by name: id, and what is known of them.
type Jobs = HashMap<String, (String, Observed)>;

/// Jobs of AWS Batch.
pub struct Batch {
    account: Account,
    endpoint: String,
    region: String,
    credentials: AwsCredentialProvider,
    client: HttpClient,
    runtime: Runtime,
    seen: Mutex<Option<(Instant, Jobs)>>,
}

impl Batch {
    /// With the credentials and the region of the environment, the container or the machine.
    pub fn new(account: Account) -> Result<Self, EngineError> {
        if account.queues.is_empty() {
            return Err(refused("batch.toml", "`queues` names no queue"));
        }
        let variable = |name: &str| std::env::var(name).ok().filter(|value| !value.is_empty());
        let region = ["AWS_REGION", "AWS_DEFAULT_REGION"]
            .into_iter()
            .find_map(variable);
        let region = region.ok_or_else(|| refused("AWS Batch", "AWS_REGION names no region"))?;
        let endpoint = ["AWS_ENDPOINT_URL_BATCH", "AWS_ENDPOINT_URL"]
            .into_iter()
            .find_map(variable)
            .unwrap_or_else(|| format!("https://batch.{region}.amazonaws.com"));
        let failed = |error: object_store::Error| refused("AWS Batch", error);
        // The name of the bucket is never used: what is wanted are the credentials.
        let mut finder = AmazonS3Builder::from_env().with_bucket_name("credentials");
        if let Some(service) = variable("AWS_EC2_METADATA_SERVICE_ENDPOINT") {
            finder = finder.with_metadata_endpoint(service.trim_end_matches('/'));
        }
        let credentials = finder.build().map_err(failed)?.credentials().clone();
        let options = ClientOptions::new()
            .with_timeout(PATIENCE)
            .with_allow_http(endpoint.starts_with("http://"));
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .thread_name("batch")
            .enable_all()
            .build()
            .map_err(|error| refused("AWS Batch", error))?;
        let client = {
            let _within = runtime.enter();
            ReqwestConnector::default()
                .connect(&options)
                .map_err(failed)?
        };
        Ok(Self {
            account,
            endpoint: endpoint.trim_end_matches('/').to_owned(),
            region,
            credentials,
            client,
            runtime,
            seen: Mutex::new(None),
        })
    }

    /// Waits for a request on a thread of its own, so that callers may be threads of another runtime.
    fn wait<T: Send + 'static>(
        &self,
        work: impl Future<Output = T> + Send + 'static,
    ) -> Result<T, EngineError> {
        let (send, receive) = mpsc::sync_channel(1);
        self.runtime.spawn(async move {
            // The receiver waits below.
            let _ = send.send(work.await);
        });
        receive.recv().map_err(|error| refused("AWS Batch", error))
    }

    /// A call: `POST /v1/NAME` with a body of JSON.
    fn call(&self, name: &str, body: &Value) -> Result<Value, EngineError> {
        let failed = |error: &dyn std::fmt::Display| refused(&format!("AWS Batch, {name}"), error);
        let request = http::Request::post(format!("{}/v1/{name}", self.endpoint))
            .header("content-type", "application/json")
            .body(body.to_string().into());
        let mut request: HttpRequest = request.map_err(|error| failed(&error))?;
        let (credentials, client) = (self.credentials.clone(), self.client.clone());
        let region = self.region.clone();
        let answered = self.wait(async move {
            let credential = credentials
                .get_credential()
                .await
                .map_err(|e| e.to_string())?;
            AwsAuthorizer::new(&credential, "batch", &region)
                .try_authorize(&mut request, None)
                .map_err(|error| error.to_string())?;
            let answer = client.execute(request).await.map_err(|e| e.to_string())?;
            let status = answer.status();
            let body = answer
                .into_body()
                .bytes()
                .await
                .map_err(|e| e.to_string())?;
            let value = serde_json::from_slice::<Value>(&body).unwrap_or(Value::Null);
            if status.is_success() {
                return Ok(value);
            }
            let said = ["message", "Message"]
                .into_iter()
                .find_map(|name| value[name].as_str());
            Err(format!(
                "{status}: {}",
                said.unwrap_or("no reason is given")
            ))
        })?;
        answered.map_err(|error| failed(&error))
    }

    /// All jobs of a queue that a request names, page by page.
    fn list(&self, mut body: Value) -> Result<Vec<Value>, EngineError> {
        let mut jobs = Vec::new();
        loop {
            let mut page = self.call("listjobs", &body)?;
            if let Some(more) = page["jobSummaryList"].as_array_mut() {
                jobs.append(more);
            }
            match page["nextToken"].as_str() {
                Some(token) => body["nextToken"] = json!(token),
                None => return Ok(jobs),
            }
        }
    }

    fn jobs(&self) -> Result<Jobs, EngineError> {
        let mut seen = self
            .seen
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner());
        if let Some((at, jobs)) = &*seen
            && at.elapsed() < Duration::from_secs_f64(self.account.poll)
        {
            return Ok(jobs.clone());
        }
        let mut jobs = Jobs::new();
        for queue in &self.account.queues {
            for status in WAITS.into_iter().chain([RUNS]) {
                let found = self.list(json!({"jobQueue": queue, "jobStatus": status}))?;
                jobs.extend(found.iter().filter_map(|job| summary(job, status)));
            }
        }
        *seen = Some((Instant::now(), jobs.clone()));
        Ok(jobs)
    }

    /// Whether there is a job of this name, ended or not.
    fn exists(&self, name: &str) -> Result<bool, EngineError> {
        for queue in &self.account.queues {
            let filter = json!([{"name": "JOB_NAME", "values": [name]}]);
            let found = self.list(json!({"jobQueue": queue, "filters": filter}))?;
            // Names are compared without regard to case by the filter.
            if found.iter().any(|job| job["jobName"] == name) {
                return Ok(true);
            }
        }
        Ok(false)
    }
}

fn refused(program: &str, message: impl std::fmt::Display) -> EngineError {
    EngineError::Refused {
        program: program.to_owned(),
        message: message.to_string(),
    }
}

/// A job of a list: name, id, and what is known of it.
fn summary(job: &Value, status: &str) -> Option<(String, (String, Observed))> {
    let name = job["jobName"]
        .as_str()
        .filter(|name| name.starts_with("mc-"))?;
    let reason = job["statusReason"].as_str().unwrap_or(status);
    let observed = match job["status"].as_str().unwrap_or(status) {
        RUNS => Observed::Running("AWS Batch".to_owned()),
        status if WAITS.contains(&status) => Observed::Pending(reason.to_owned()),
        _ => return None,
    };
    Some((
        name.to_owned(),
        (job["jobId"].as_str()?.to_owned(), observed),
    ))
}

/// The body of `SubmitJob`.
fn submission(launch: &Launch, queue: &str, definition: &str) -> Value {
    let command: Vec<_> = launch
        .command
        .iter()
        .map(|word| word.to_string_lossy())
        .collect();
    let memory = launch.memory.div_ceil(1 << 20).max(4);
    json!({
        "jobName": launch.job,
        "jobQueue": queue,
        "jobDefinition": definition,
        "containerOverrides": {
            "command": command,
            "resourceRequirements": [
                {"type": "VCPU", "value": launch.threads.to_string()},
                {"type": "MEMORY", "value": memory.to_string()},
            ],
        },
        // The server makes attempts, and nothing else.
        "retryStrategy": {"attempts": 1},
        "tags": {"mercury-job": launch.job},
        "propagateTags": true,
    })
}

impl Engine for Batch {
    fn name(&self) -> &'static str {
        "aws"
    }

    fn queue(&self, barren: u32) -> &str {
        let nth = (barren / self.account.losses.max(1)) as usize;
        &self.account.queues[nth.min(self.account.queues.len() - 1)]
    }

    fn submit(&self, launch: &Launch) -> Result<(), EngineError> {
        if self.exists(&launch.job)? {
            return Ok(());
        }
        let queue = self.queue(launch.barren);
        let submitted = self.call(
            "submitjob",
            &submission(launch, queue, &self.account.definition),
        );
        let mut seen = self
            .seen
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner());
        match (&submitted, seen.as_mut()) {
            (Ok(answer), Some((_, jobs))) => {
                let id = answer["jobId"].as_str().unwrap_or_default().to_owned();
                let observed = Observed::Pending("submitted".to_owned());
                jobs.insert(launch.job.clone(), (id, observed));
            }
            _ => *seen = None,
        }
        submitted.map(|_| ())
    }

    fn observe(&self) -> Result<HashMap<String, Observed>, EngineError> {
        let jobs = self.jobs()?;
        Ok(jobs
            .into_iter()
            .map(|(name, (_, observed))| (name, observed))
            .collect())
    }

    fn stop(&self, job: &str, _: Stop) -> Result<(), EngineError> {
        // SIGTERM, SIGKILL after 30 s; a job that waits never begins. There is no harder way.
        if let Some((id, _)) = self.jobs()?.get(job) {
            self.call(
                "terminatejob",
                &json!({"jobId": id, "reason": "ended by Mercury Cloud"}),
            )?;
        }
        Ok(())
    }

    fn abilities(&self) -> Abilities {
        Abilities {
            grace: GRACE,
            beat: 15.0,
            cores: None,
            ranks: 1,
        }
    }

    fn image(&self) -> Option<&ImageLayout> {
        Some(&self.account.image)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jobs_of_a_list_are_read() {
        let job =
            |name: &str, status: &str| json!({"jobName": name, "jobId": "1-2", "status": status});
        let (name, (id, observed)) = summary(&job("mc-ab-2", "RUNNING"), "RUNNING").unwrap();
        assert_eq!((name.as_str(), id.as_str()), ("mc-ab-2", "1-2"));
        assert!(matches!(observed, Observed::Running(_)));
        let mut waiting = job("mc-ab-3", "RUNNABLE");
        waiting["statusReason"] = json!("MISCONFIGURATION:JOB_RESOURCE_REQUIREMENT");
        let (_, (_, observed)) = summary(&waiting, "RUNNABLE").unwrap();
        assert_eq!(
            observed,
            Observed::Pending("MISCONFIGURATION:JOB_RESOURCE_REQUIREMENT".into())
        );
        for status in ["SUCCEEDED", "FAILED"] {
            assert!(summary(&job("mc-ab-4", status), status).is_none());
        }
        assert!(summary(&job("another", "RUNNING"), "RUNNING").is_none());
        assert!(summary(&json!({}), "RUNNING").is_none());
    }

    #[test]
    fn a_submission_never_tries_again() {
        let launch = Launch {
            job: "mc-ab-1".into(),
            command: vec!["mercury-cloud".into(), "worker".into()],
            ranks: 1,
            threads: 4,
            memory: (3 << 30) + 1,
            log: "log".into(),
            barren: 0,
        };
        let body = submission(&launch, "spot", "mercury");
        assert_eq!(body["retryStrategy"]["attempts"], 1);
        assert_eq!(
            body["containerOverrides"]["resourceRequirements"][1]["value"],
            "3073"
        );
        assert_eq!(
            body["containerOverrides"]["resourceRequirements"][0]["value"],
            "4"
        );
    }
}
