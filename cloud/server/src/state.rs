//! State that all requests share.

use std::collections::HashMap;
use std::fs::{self, File, OpenOptions};
use std::net::{IpAddr, SocketAddr};
use std::os::unix::fs::{OpenOptionsExt, PermissionsExt};
use std::path::PathBuf;
use std::process::Command;
use std::sync::atomic::{AtomicU16, Ordering};
use std::sync::{Arc, Mutex, OnceLock, mpsc};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use cloud_api::answers::{EventRow, Template};
use cloud_api::lifecycle::Policy;
use cloud_api::{Head, RunId};
use cloud_engine::{Engine, Local, Slurm};
use cloud_store::Store;
use tokio::sync::{broadcast, watch};

use crate::attempts::Attempts;
use crate::db::Db;
use crate::frames::Cache;
use crate::sums::Sums;
use crate::tries::Tries;
use crate::turns::Turns;
use crate::{
    EngineChoice, Options, at_end, downloads, hooks, inputs, secrets, templates, users, verify,
};

/// How many messages a slow listener may be behind before it gets a notice that it missed some.
const BACKLOG: usize = 1024;

/// Seconds between two signs of life with object storage, where each request costs money.
const REMOTE_BEAT: f64 = 15.0;

/// How many scenes are checked at once, one for each user.
const CHECKS: usize = 2;

/// How many walls and previews are read at once.
const VIEWS: usize = 4;

/// How many passwords are hashed at once, one for each address.
const HASHES: usize = 2;

/// How many more requests of an address wait until their passwords are hashed.
const HASHES_WAITING: usize = 16;

/// The most streams of events at once.
const STREAMS: usize = 4096;

/// The most streams of a user at once, and of all links to runs of that user.
const STREAMS_EACH: usize = 256;

/// A message to listeners of `GET /events`.
#[derive(Clone, Debug)]
pub(crate) struct Message {
    /// Users who may see the run.
    pub(crate) audience: Vec<i64>,
    /// Number of it, where it is kept and can be replayed.
    pub(crate) id: Option<i64>,
    pub(crate) run: String,
    /// As it is sent.
    pub(crate) text: String,
}

/// Addresses of a server.
#[derive(Clone, Debug)]
pub struct Links {
    /// The page.
    pub address: String,
    /// A link that logs in the user of this machine: a secret, good once, within a day.
    pub once: String,
}

/// The server's state.
pub(crate) struct App {
    /// Address of the page, once it is known.
    address: Mutex<String>,
    /// Port of the page, likewise.
    pub(crate) port: AtomicU16,
    pub(crate) options: Options,
    pub(crate) db: Db,
    pub(crate) store: Box<dyn Store>,
    /// URL of the store as workers get it.
    pub(crate) store_url: String,
    pub(crate) engine: Box<dyn Engine>,
    pub(crate) version: String,
    /// This program.
    pub(crate) program: PathBuf,
    pub(crate) templates: Vec<Template>,
    /// JSON schema of scenes.
    pub(crate) schema: String,
    pub(crate) attempts: Attempts,
    pub(crate) cache: Cache,
    pub(crate) tries: Tries,
    pub(crate) checks: Turns,
    /// Turns of programs that read walls and previews.
    pub(crate) views: Turns,
    pub(crate) inputs: inputs::Busy,
    /// Held while a run gets a further revision.
    pub(crate) extensions: Mutex<()>,
    pub(crate) downloads: Turns,
    pub(crate) verifying: verify::Verifying,
    /// Checksums for archives.
    pub(crate) sums: Sums,
    /// Turns of streams of events.
    pub(crate) streams: Turns,
    /// Turns of frames and walls, until they are read.
    pub(crate) frames: Turns,
    /// Turns of hashing a password, which takes 19 MB.
    pub(crate) hashes: Turns<IpAddr>,
    pub(crate) news: broadcast::Sender<Arc<Message>>,
    /// Where the ids of runs go that have ended, if there is a command for that.
    pub(crate) ended: OnceLock<mpsc::Sender<String>>,
    /// The thread that sends to web hooks.
    pub(crate) hooks: OnceLock<mpsc::Sender<hooks::News>>,
    pub(crate) wake: std::sync::mpsc::SyncSender<()>,
    pub(crate) woken: Mutex<Option<std::sync::mpsc::Receiver<()>>>,
    closed: watch::Sender<bool>,
    /// Held for as long as the server attempts: a second one on the same data is refused.
    _lock: File,
}

impl App {
    pub(crate) fn open(mut options: Options) -> Result<Arc<Self>> {
        fs::create_dir_all(&options.data).with_context(|| format!("{}", options.data.display()))?;
        options.data = options.data.canonicalize()?;
        // Also a folder that was there before: it holds hashes of secrets and runs of all users.
        fs::set_permissions(&options.data, fs::Permissions::from_mode(0o700))?;
        let data = options.data.clone();
        let lock = OpenOptions::new()
            .create(true)
            .truncate(false)
            .write(true)
            .mode(0o600)
            .open(data.join("lock"))
            .with_context(|| format!("{}", data.join("lock").display()))?;
        if rustix::fs::flock(&lock, rustix::fs::FlockOperation::NonBlockingLockExclusive).is_err() {
            bail!("another server serves {}", data.display());
        }
        for folder in ["scratch", "checks", "cache", "log"] {
            fs::create_dir_all(data.join(folder))?;
        }
        // What checks and viewers of a server that was killed have left.
        for folder in ["checks", "cache"] {
            for entry in fs::read_dir(data.join(folder))? {
                fs::remove_dir_all(entry?.path())?;
            }
        }
        let store_url = match &options.store {
            Some(url) => url.clone(),
            None => data.join("store").display().to_string(),
        };
        let store = cloud_store::create(&store_url)?;
        let (version, has_mpi) = version(&options.solver)?;
        let engine: Box<dyn Engine> = match options.engine.clone() {
            EngineChoice::Local => {
                Box::new(Local::new(options.cores, &store_url, data.join("workers")))
            }
            EngineChoice::Slurm(site) => Box::new(Slurm::new(site, data.join("arrays"))),
            #[cfg(feature = "aws")]
            EngineChoice::Aws(account) => Box::new(cloud_engine::Batch::new(account)?),
        };
        if engine.abilities().ranks > 1 && !has_mpi {
            bail!(
                "the site file offers ranks, and {} was built without MPI: build it with `cargo build --release --features mpi --bin mercury-solve`, \
                 or take [ranks] out of the site file",
                options.solver.display()
            );
        }
        let beat = options.beat.unwrap_or_else(|| {
            let least = if cloud_store::is_remote(&store_url) {
                REMOTE_BEAT
            } else {
                0.0
            };
            engine.abilities().beat.max(least)
        });
        let policy = Policy {
            beat,
            first_wait: options.first_wait,
            ..Policy::default()
        };
        let db = Db::open(&data.join("db.sqlite"), policy, options.prices.clone())?;
        users::first_user(&db)?;
        let templates = templates::all(&options.solver, &data.join("checks"), store.as_ref(), &db)?;
        let schema = templates::schema(&options.solver)?;
        let (wake, woken) = std::sync::mpsc::sync_channel(1);
        Ok(Arc::new(Self {
            address: Mutex::default(),
            port: AtomicU16::default(),
            cache: Cache::new(data.join("cache")),
            options,
            db,
            store,
            store_url,
            engine,
            version,
            program: std::env::current_exe().context("the path of mercury-cloud")?,
            templates,
            schema,
            attempts: Attempts::default(),
            tries: Tries::default(),
            checks: Turns::new(CHECKS, 1),
            views: Turns::new(VIEWS, 2),
            inputs: inputs::Busy::default(),
            extensions: Mutex::new(()),
            downloads: Turns::new(downloads::ALL, downloads::EACH),
            verifying: verify::Verifying::default(),
            sums: Sums::default(),
            streams: Turns::new(STREAMS, STREAMS_EACH).with_waiting(0),
            frames: Turns::new(downloads::ALL_FRAMES, downloads::EACH_FRAMES),
            hashes: Turns::new(HASHES, 1).with_waiting(HASHES_WAITING),
            news: broadcast::channel(BACKLOG).0,
            ended: OnceLock::new(),
            hooks: OnceLock::new(),
            wake,
            woken: Mutex::new(Some(woken)),
            closed: watch::channel(false).0,
            _lock: lock,
        }))
    }

    /// Address of the page, with `/` at its end.
    pub(crate) fn address(&self) -> String {
        self.address
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner())
            .clone()
    }

    /// Writes the link of the command line into the data folder, and returns the address and a link that logs in once.
    pub(crate) fn links(&self, address: SocketAddr) -> Result<Links> {
        self.port.store(address.port(), Ordering::Relaxed);
        let host = self
            .options
            .hosts
            .first()
            .map_or_else(|| address.to_string(), Clone::clone);
        let scheme = if self.options.behind_proxy {
            "https"
        } else {
            "http"
        };
        let address = format!("{scheme}://{host}/");
        *self
            .address
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner()) = address.clone();
        if self.options.no_auth {
            secrets::write_secret(&self.options.data.join("link"), &address)?;
            return Ok(Links {
                once: address.clone(),
                address,
            });
        }
        self.write_link(None)?;
        let link = secrets::link(&self.db, secrets::Right::Server, None)?
            .context("the user of this machine is not in the database")?;
        Ok(Links {
            once: format!("{address}#token={}", link.secret),
            address,
        })
    }

    fn write_link(&self, rotate: Option<secrets::Right>) -> Result<Option<secrets::Issued>> {
        let data = &self.options.data;
        let Some(token) = secrets::machine_token(&self.db, data, rotate)? else {
            return Ok(None);
        };
        let address = self.address();
        let link = format!("{address}#token={}", token.secret);
        secrets::write_secret(&data.join("link"), &link)?;
        Ok(Some(token))
    }

    /// Makes the secrets of the machine anew, and ends the sessions of its user. Returns the new token; `None` where what allowed the
    /// request does not hold any more.
    pub(crate) fn rotate(&self, right: secrets::Right) -> Result<Option<secrets::Issued>> {
        self.write_link(Some(right))
    }

    /// Ends all streams of events.
    pub(crate) fn close(&self) {
        self.closed.send_replace(true);
    }

    /// Resolves when the server ends.
    pub(crate) fn closing(&self) -> watch::Receiver<bool> {
        self.closed.subscribe()
    }

    /// Has the reconciler look at once.
    pub(crate) fn wake_reconciler(&self) {
        // One that is pending already is enough.
        let _ = self.wake.try_send(());
    }

    /// Has what is to be sent to web hooks sent at once.
    pub(crate) fn tell_hooks(&self) {
        if let Some(hooks) = self.hooks.get() {
            // The thread ends with the program.
            let _ = hooks.send(hooks::News::Added);
        }
    }

    /// Sends listeners the events of runs that are in the database.
    pub(crate) fn publish(&self, events: Vec<EventRow>) {
        for event in events {
            if let Some(run) = at_end::ended(&event) {
                self.tell_hooks();
                if let Some(ended) = self.ended.get() {
                    // The thread ends with the program.
                    let _ = ended.send(run);
                }
            }
            let audience = self.db.audience(&event.run).unwrap_or_default();
            let text = serde_json::to_string(&event).unwrap_or_default();
            // Without listeners there is no error.
            let _ = self.news.send(Arc::new(Message {
                audience,
                id: Some(event.id),
                run: event.run,
                text,
            }));
        }
    }

    /// The head of a run, or `None` where the store has none.
    pub(crate) fn head(&self, run: &RunId) -> cloud_store::Result<Option<Head>> {
        let text = self.store.get(&format!("runs/{run}/head.json"))?;
        Ok(text.and_then(|text| serde_json::from_slice(&text).ok()))
    }

    /// Where workers make their folders.
    pub(crate) fn scratch(&self) -> PathBuf {
        self.options
            .scratch
            .clone()
            .unwrap_or_else(|| self.options.data.join("scratch"))
    }
}

/// Caches by run, each with the instant of its last use.
pub(crate) type ByRun<T> = Mutex<HashMap<String, (Instant, T)>>;

/// Version of the solver, and whether it can make a run on several ranks.
fn version(solver: &std::path::Path) -> Result<(String, bool)> {
    let output = Command::new(solver)
        .arg("--version")
        .output()
        .with_context(|| {
            format!(
                "the solver {} cannot be started; give its path by --solver",
                solver.display()
            )
        })?;
    let text = String::from_utf8_lossy(&output.stdout);
    let mut lines = text.lines();
    let version = lines.next().and_then(|line| line.split_whitespace().last());
    let version = version.unwrap_or_default();
    if !output.status.success() || version.is_empty() {
        bail!("{} --version prints no version", solver.display());
    }
    Ok((version.to_owned(), lines.any(|line| line == "with MPI")))
}
