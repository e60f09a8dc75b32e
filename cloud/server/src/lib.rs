//! The server: page, API, and the loop that brings runs from state to state.

mod access;
mod accounts;
mod archive;
mod at_end;
mod attempts;
mod audit;
mod branch;
mod charts;
mod check;
mod connections;
mod content;
mod db;
mod downloads;
mod earlier;
mod frames;
mod hooks;
mod inputs;
mod means;
mod openapi;
mod prices;
mod projects;
mod reconcile;
mod routes;
mod runs;
mod secrets;
mod state;
mod studies;
mod sums;
mod templates;
mod tries;
mod turns;
mod users;
mod verify;
mod views;
mod web;

use std::net::SocketAddr;
use std::path::PathBuf;

use anyhow::{Context, Result};
use cloud_engine::Site;

pub use openapi::document as openapi;
pub use prices::Prices;
pub use state::Links;
pub use views::view;

/// Where attempts run.
#[derive(Clone, Debug)]
pub enum EngineChoice {
    /// Processes of this machine.
    Local,
    /// Slurm.
    Slurm(Site),
    /// AWS Batch.
    #[cfg(feature = "aws")]
    Aws(cloud_engine::Account),
}

/// How a server is to be.
#[derive(Clone, Debug)]
pub struct Options {
    /// Folder of database, store and scratch.
    pub data: PathBuf,
    /// Where to listen.
    pub listen: SocketAddr,
    /// The store; without it a folder within `data`.
    pub store: Option<String>,
    /// The solver.
    pub solver: PathBuf,
    /// Cores for runs.
    pub cores: u32,
    /// Memory for runs, in bytes.
    pub memory: u64,
    /// The most bytes that one run's files may take.
    pub disk: u64,
    /// Where attempts run.
    pub engine: EngineChoice,
    /// Folder in which workers make theirs; without it one within `data`.
    pub scratch: Option<PathBuf>,
    /// Host names besides loopback under which the server is reached.
    pub hosts: Vec<String>,
    /// Whether a proxy in front does TLS.
    pub behind_proxy: bool,
    /// Whether the solver is confined.
    pub sandbox: bool,
    /// Whether every connection counts as the local user.
    pub no_auth: bool,
    /// The clock's time between two checkpoints.
    pub checkpoint_every: String,
    /// Seconds between two signs of life of a run; without it as engine and store need.
    pub beat: Option<f64>,
    /// Prices of cores; without them costs are core seconds alone.
    pub prices: Option<Prices>,
    /// A command for the shell at the end of each run.
    pub at_end: Option<String>,
    /// Hosts that web hooks of users reach also by http, and at addresses that are not public.
    pub hooks_to: Vec<String>,
    /// Called when the engine has taken a job, before that is recorded. Tests end the server here.
    pub after_submit: fn(),
    /// Wait after the first attempt without progress, in s.
    pub first_wait: f64,
}

/// Serves until SIGTERM or SIGINT. `ready` gets the addresses.
pub async fn serve(options: Options, ready: impl FnOnce(&Links)) -> Result<()> {
    let loopback = options.listen.ip().is_loopback();
    if options.no_auth && !loopback {
        anyhow::bail!(
            "--no-auth is for loopback addresses only: anyone on the network could change all runs"
        );
    }
    if !loopback && !options.behind_proxy {
        anyhow::bail!(
            "listening on {} needs --behind-proxy: a proxy that does TLS",
            options.listen.ip()
        );
    }
    if options.sandbox && !cloud_worker::confine::is_there() {
        anyhow::bail!(
            "the kernel has no Landlock, or no filter of system calls (seccomp), so a scene could read any file of this user. \
             --no-sandbox serves all the same{}",
            if loopback {
                ""
            } else {
                "; do that only where all users may read all of it"
            }
        );
    }
    let app = state::App::open(options)?;
    let listener = tokio::net::TcpListener::bind(app.options.listen)
        .await
        .with_context(|| format!("{} cannot be listened on", app.options.listen))?;
    let address = listener.local_addr()?;
    let links = app.links(address)?;
    if let Some(command) = app.options.at_end.clone() {
        let _ = app.ended.set(at_end::begin(&app, command)?);
    }
    let _ = app.hooks.set(hooks::begin(&app)?);
    reconcile::begin(app.clone())?;
    ready(&links);
    let mut terminate = tokio::signal::unix::signal(tokio::signal::unix::SignalKind::terminate())?;
    let limits = connections::Limits::raise(app.options.behind_proxy)?;
    let stop = app.clone();
    let stopped = async move {
        tokio::select! {
            _ = terminate.recv() => {}
            _ = tokio::signal::ctrl_c() => {}
        }
        // Streams of events never end by themselves.
        stop.close();
    };
    connections::serve(listener, routes::router(app), limits, stopped).await;
    Ok(())
}
