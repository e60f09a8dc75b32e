//! Workers as Jobs of Kubernetes, by `kubectl`. Experimental: no cluster ever ran it.
//!
//! `kubectl` knows how to reach and to be let into a cluster, of whatever provider, so nothing of that is here. It is given
//! paths of the API as they are (`--raw`). A Job never tries again by itself (`backoffLimit: 0`), and its name is that of
//! the attempt, so a second one is refused by the cluster.

use std::collections::{BTreeMap, HashMap};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use serde::Deserialize;
use serde_json::{Value, json};

use crate::program::call;
use crate::{Abilities, Engine, EngineError, Launch, Observed, Place, Stop};

/// What differs from cluster to cluster: `kubernetes.toml`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cluster {
    /// Namespace of the Jobs.
    #[serde(default = "default")]
    pub namespace: String,
    /// Image with the programs.
    pub image: String,
    /// Service account with the right to the bucket.
    pub service_account: Option<String>,
    /// Secret whose keys become variables of the environment (AWS_ACCESS_KEY_ID, ...).
    pub secret: Option<String>,
    /// Variables of the environment (AWS_REGION, AWS_ENDPOINT_URL, ...).
    #[serde(default)]
    pub environment: BTreeMap<String, String>,
    /// Claim of a volume that all nodes see, at `/store`, for a store that is a folder.
    pub claim: Option<String>,
    /// Queue of Kueue.
    pub queue: Option<String>,
    /// Labels of the nodes to be used.
    #[serde(default)]
    pub nodes: BTreeMap<String, String>,
    /// Seconds from SIGTERM to SIGKILL; spot nodes of AWS and Google give 120 and 30.
    #[serde(default = "grace")]
    pub grace: u32,
    /// Least seconds between two looks at all Jobs.
    #[serde(default = "ten")]
    pub poll: f64,
    /// Where the programs are in the image.
    #[serde(flatten)]
    pub place: Place,
}

fn default() -> String {
    "default".to_owned()
}

fn grace() -> u32 {
    110
}

fn ten() -> f64 {
    10.0
}

/// The label of all Jobs and pods.
const LABEL: &str = "app.kubernetes.io/name=mercury-worker";

/// Jobs of Kubernetes.
pub struct Kubernetes {
    cluster: Cluster,
    seen: Mutex<Option<(Instant, HashMap<String, Observed>)>>,
}

impl Kubernetes {
    /// On the cluster that `kubectl` speaks to.
    pub fn new(cluster: Cluster) -> Self {
        Self {
            cluster,
            seen: Mutex::new(None),
        }
    }

    fn jobs_path(&self) -> String {
        format!("/apis/batch/v1/namespaces/{}/jobs", self.cluster.namespace)
    }

    /// The Job of an attempt.
    pub fn job(&self, launch: &Launch) -> Value {
        let cluster = &self.cluster;
        let (name, value) = LABEL.split_once('=').unwrap_or((LABEL, ""));
        let mut labels = json!({name: value});
        let pod_labels = labels.clone();
        if let Some(queue) = &cluster.queue {
            labels["kueue.x-k8s.io/queue-name"] = json!(queue);
        }
        let command: Vec<_> = launch
            .command
            .iter()
            .map(|word| word.to_string_lossy())
            .collect();
        let variables: Vec<Value> = (cluster.environment.iter())
            .map(|(name, value)| json!({"name": name, "value": value}))
            .collect();
        let resources = json!({
            "cpu": launch.threads.to_string(),
            "memory": format!("{}Mi", launch.memory.div_ceil(1 << 20)),
        });
        let mut mounts = vec![json!({"name": "scratch", "mountPath": cluster.place.scratch})];
        let mut volumes = vec![json!({"name": "scratch", "emptyDir": {}})];
        if let Some(claim) = &cluster.claim {
            mounts.push(json!({"name": "store", "mountPath": "/store"}));
            let source = json!({"claimName": claim});
            volumes.push(json!({"name": "store", "persistentVolumeClaim": source}));
        }
        let mut container = json!({
            "name": "worker",
            "image": cluster.image,
            "command": command,
            "env": variables,
            "resources": {"requests": resources, "limits": resources},
            "volumeMounts": mounts,
            "securityContext": {
                "allowPrivilegeEscalation": false,
                "capabilities": {"drop": ["ALL"]},
            },
        });
        if let Some(secret) = &cluster.secret {
            container["envFrom"] = json!([{"secretRef": {"name": secret}}]);
        }
        let mut pod = json!({
            "restartPolicy": "Never",
            "terminationGracePeriodSeconds": cluster.grace,
            "automountServiceAccountToken": false,
            "securityContext": {"runAsNonRoot": true, "runAsUser": 1000, "fsGroup": 1000},
            "containers": [container],
            "volumes": volumes,
        });
        if let Some(account) = &cluster.service_account {
            pod["serviceAccountName"] = json!(account);
        }
        if !cluster.nodes.is_empty() {
            pod["nodeSelector"] = json!(cluster.nodes);
        }
        // A pod that the cluster takes away ends the Job: the server makes attempts, and nothing else.
        let disrupted = json!({
            "action": "FailJob",
            "onPodConditions": [{"type": "DisruptionTarget", "status": "True"}],
        });
        json!({
            "apiVersion": "batch/v1",
            "kind": "Job",
            "metadata": {"name": launch.job, "namespace": cluster.namespace, "labels": labels},
            "spec": {
                "backoffLimit": 0,
                "completions": 1,
                "parallelism": 1,
                // Ended Jobs stay for a while, to be looked at.
                "ttlSecondsAfterFinished": 3600,
                "podFailurePolicy": {"rules": [disrupted]},
                "template": {"metadata": {"labels": pod_labels}, "spec": pod},
            },
        })
    }

    fn delete(&self, path: &str) -> Result<(), EngineError> {
        match call("kubectl", ["delete", "--raw", path], None) {
            Ok(_) => Ok(()),
            Err(EngineError::Refused { message, .. }) if message.contains("NotFound") => Ok(()),
            Err(error) => Err(error),
        }
    }
}

/// Name of a Job and what is known of it, unless it has ended.
fn observed(job: &Value) -> Option<(String, Observed)> {
    let name = job["metadata"]["name"]
        .as_str()
        .filter(|name| name.starts_with("mc-"))?;
    let status = &job["status"];
    let ended = status["conditions"]
        .as_array()
        .into_iter()
        .flatten()
        .any(|condition| {
            condition["status"] == "True"
                && (condition["type"] == "Complete" || condition["type"] == "Failed")
        });
    if ended {
        return None;
    }
    let count = |what: &str| status[what].as_u64().unwrap_or(0);
    let observed = if job["spec"]["suspend"] == true {
        Observed::Pending("suspended, by a queue".to_owned())
    } else if count("ready") > 0 {
        Observed::Running("Kubernetes".to_owned())
    } else {
        Observed::Pending("waits for a pod".to_owned())
    };
    Some((name.to_owned(), observed))
}

impl Engine for Kubernetes {
    fn name(&self) -> &'static str {
        "kubernetes"
    }

    fn submit(&self, launch: &Launch) -> Result<(), EngineError> {
        let path = self.jobs_path();
        let created = call(
            "kubectl",
            ["create", "--raw", &path, "-f", "-"],
            Some(&self.job(launch).to_string()),
        );
        let mut seen = self
            .seen
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner());
        *seen = None;
        match created {
            Ok(_) => Ok(()),
            // A submission without an answer has gone through.
            Err(EngineError::Refused { message, .. }) if message.contains("AlreadyExists") => {
                Ok(())
            }
            Err(error) => Err(error),
        }
    }

    fn observe(&self) -> Result<HashMap<String, Observed>, EngineError> {
        let mut seen = self
            .seen
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner());
        if let Some((at, jobs)) = &*seen
            && at.elapsed() < Duration::from_secs_f64(self.cluster.poll)
        {
            return Ok(jobs.clone());
        }
        let label = LABEL.replace('/', "%2F").replace('=', "%3D");
        let path = format!("{}?labelSelector={label}", self.jobs_path());
        let text = call("kubectl", ["get", "--raw", &path], None)?;
        let list: Value = serde_json::from_str(&text).map_err(|error| EngineError::Refused {
            program: "kubectl".to_owned(),
            message: format!("its answer is no JSON: {error}"),
        })?;
        let items = list["items"].as_array().into_iter().flatten();
        let jobs: HashMap<_, _> = items.filter_map(observed).collect();
        *seen = Some((Instant::now(), jobs.clone()));
        Ok(jobs)
    }

    fn stop(&self, job: &str, how: Stop) -> Result<(), EngineError> {
        if how == Stop::Hard {
            let pods = format!(
                "/api/v1/namespaces/{}/pods?labelSelector=job-name%3D{job}&gracePeriodSeconds=0",
                self.cluster.namespace
            );
            self.delete(&pods)?;
        }
        // The pod goes with the Job: SIGTERM, and SIGKILL after its grace.
        self.delete(&format!(
            "{}/{job}?propagationPolicy=Background",
            self.jobs_path()
        ))
    }

    fn abilities(&self) -> Abilities {
        Abilities {
            grace: f64::from(self.cluster.grace),
            beat: 15.0,
            cores: None,
        }
    }

    fn place(&self) -> Option<&Place> {
        Some(&self.cluster.place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn launch() -> Launch {
        Launch {
            job: "mc-0123456789abcdef0123456789abcdef-1".into(),
            command: vec![
                "mercury-cloud".into(),
                "worker".into(),
                "--epoch".into(),
                "1".into(),
            ],
            threads: 2,
            memory: 1 << 30,
            log: "log".into(),
            barren: 0,
        }
    }

    #[test]
    fn states_of_jobs_are_read() {
        let job = |status: Value| json!({"metadata": {"name": "mc-ab-1"}, "status": status});
        let state = |status: Value| observed(&job(status)).map(|(_, observed)| observed);
        assert!(matches!(
            state(json!({"active": 1, "ready": 1})),
            Some(Observed::Running(_))
        ));
        assert!(matches!(
            state(json!({"active": 1, "ready": 0})),
            Some(Observed::Pending(_))
        ));
        assert!(matches!(state(json!({})), Some(Observed::Pending(_))));
        for kind in ["Complete", "Failed"] {
            assert_eq!(
                state(json!({"conditions": [{"type": kind, "status": "True"}]})),
                None
            );
        }
        let going =
            json!({"conditions": [{"type": "FailureTarget", "status": "True"}], "ready": 1});
        assert!(matches!(state(going), Some(Observed::Running(_))));
        assert!(observed(&json!({"metadata": {"name": "another"}})).is_none());
    }

    #[test]
    fn settings_that_nothing_knows_are_refused() {
        let place: Cluster = toml::from_str("image = \"i\"\nscratch = \"/tmp\"").unwrap();
        assert_eq!(place.place.scratch, std::path::Path::new("/tmp"));
        assert!(toml::from_str::<Cluster>("image = \"i\"\nscracth = \"/tmp\"").is_err());
        assert!(toml::from_str::<Cluster>("").is_err());
    }

    /// The objects that the deployment's checks hold against the schemas are the ones that are sent.
    #[test]
    fn the_jobs_of_the_examples_are_the_ones_that_are_sent() {
        let least: Cluster = toml::from_str("image = \"mercury:1\"").unwrap();
        let most: Cluster = toml::from_str(
            "image = \"mercury:1\"\nnamespace = \"sim\"\nservice_account = \"mercury\"\nsecret = \"keys\"\nclaim = \"store\"\n\
             queue = \"spot\"\ngrace = 25\nnodes = { \"node.kubernetes.io/instance-type\" = \"c7i.large\" }\n\
             environment = { AWS_REGION = \"eu-central-1\" }",
        )
        .unwrap();
        let both: Vec<Value> = [least, most]
            .map(|cluster| Kubernetes::new(cluster).job(&launch()))
            .into();
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/kubernetes-jobs.json");
        let text = format!("{:#}\n", Value::Array(both));
        if std::env::var_os("MERCURY_BLESS").is_some() {
            std::fs::write(path, &text).unwrap();
        }
        assert_eq!(text, std::fs::read_to_string(path).unwrap_or_default());
    }
}
