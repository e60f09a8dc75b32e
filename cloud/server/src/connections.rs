//! Connections: how many there may be, and how long a client may take.

use std::collections::HashMap;
use std::future::Future;
use std::net::IpAddr;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use anyhow::Result;
use axum::Router;
use axum::extract::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::GracefulShutdown;
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use tokio::net::TcpListener;
use tokio_io_timeout::TimeoutStream;
use tower::ServiceExt;

/// How long the head of a request may take.
const HEAD: Duration = Duration::from_secs(20);

/// How long a client may read nothing of an answer.
const UNREAD: Duration = Duration::from_secs(60);

/// Wait after a connection could not be accepted, because there are too many open files.
const PAUSE: Duration = Duration::from_millis(200);

/// How long answers may take to end when the server ends.
const END: Duration = Duration::from_secs(10);

/// The most connections, whatever the limit of open files.
const MOST: u64 = 8192;

/// Address of the client of a request, in its extensions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Peer(pub(crate) IpAddr);

/// The most connections at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Limits {
    all: usize,
    /// Of one address.
    each: usize,
}

impl Limits {
    /// Half of the open files that this process may have, after it has raised that limit as far as it may. The other half is for files of
    /// the store, the database and programs. One address gets half of the connections, unless it is that of a proxy.
    pub(crate) fn raise(behind_proxy: bool) -> Result<Self> {
        let hard = getrlimit(Resource::Nofile).maximum;
        setrlimit(
            Resource::Nofile,
            Rlimit {
                current: hard,
                maximum: hard,
            },
        )?;
        Ok(Self::of(hard.unwrap_or(u64::MAX), behind_proxy))
    }

    fn of(files: u64, behind_proxy: bool) -> Self {
        let all = (files / 2).min(MOST) as usize;
        let each = if behind_proxy { all } else { all / 2 };
        Self { all, each }
    }
}

/// Connections that there are, by address.
#[derive(Default)]
struct Counts(Mutex<HashMap<IpAddr, usize>>);

/// A connection that is counted until it ends.
struct Counted(Arc<Counts>, IpAddr);

impl Counts {
    fn lock(&self) -> std::sync::MutexGuard<'_, HashMap<IpAddr, usize>> {
        self.0
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// Counts one more, if that is within the limits.
    fn add(self: &Arc<Self>, address: IpAddr, limits: Limits) -> Option<Counted> {
        let mut counts = self.lock();
        let own = counts.get(&address).copied().unwrap_or(0);
        if own >= limits.each || counts.values().sum::<usize>() >= limits.all {
            return None;
        }
        counts.insert(address, own + 1);
        Some(Counted(Arc::clone(self), address))
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        let mut counts = self.0.lock();
        if let Some(own) = counts.get_mut(&self.1) {
            *own -= 1;
            if *own == 0 {
                counts.remove(&self.1);
            }
        }
    }
}

/// Serves until `stop` resolves, and then what has begun.
pub(crate) async fn serve(
    listener: TcpListener,
    router: Router,
    limits: Limits,
    stop: impl Future<Output = ()>,
) {
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(HEAD);
    let (graceful, counts) = (GracefulShutdown::new(), Arc::new(Counts::default()));
    let mut stop = std::pin::pin!(stop);
    loop {
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            () = &mut stop => break,
        };
        let (stream, address) = match accepted {
            Ok((stream, address)) => (stream, address.ip().to_canonical()),
            Err(error) => {
                eprintln!("a connection was not accepted: {error}");
                tokio::time::sleep(PAUSE).await;
                continue;
            }
        };
        // One too many is closed at once.
        let Some(counted) = counts.add(address, limits) else {
            continue;
        };
        let mut stream = TimeoutStream::new(stream);
        stream.set_write_timeout(Some(UNREAD));
        let router = router.clone();
        let service = service_fn(move |mut request: Request<Incoming>| {
            request.extensions_mut().insert(Peer(address));
            router.clone().oneshot(request)
        });
        let connection = http.serve_connection(TokioIo::new(Box::pin(stream)), service);
        let connection = graceful.watch(connection);
        tokio::spawn(async move {
            let _counted = counted;
            // Connections that are cut are not errors of the server.
            let _ = connection.await;
        });
    }
    drop(listener);
    if tokio::time::timeout(END, graceful.shutdown())
        .await
        .is_err()
    {
        eprintln!("answers that take longer than {} s are cut", END.as_secs());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn connections_are_counted_by_address() {
        let limits = Limits { all: 3, each: 2 };
        let counts = Arc::new(Counts::default());
        let (a, b) = (IpAddr::from([127, 0, 0, 1]), IpAddr::from([127, 0, 0, 2]));
        let first = counts.add(a, limits).unwrap();
        let second = counts.add(a, limits).unwrap();
        assert!(counts.add(a, limits).is_none(), "the third of one address");
        let third = counts.add(b, limits).unwrap();
        assert!(counts.add(b, limits).is_none(), "the fourth of all");
        drop(first);
        assert!(counts.add(b, limits).is_some());
        drop((second, third));
        assert!(counts.lock().is_empty());
    }

    #[test]
    fn limits_follow_from_open_files() {
        assert_eq!(
            Limits::of(1024, false),
            Limits {
                all: 512,
                each: 256
            }
        );
        assert_eq!(
            Limits::of(1024, true),
            Limits {
                all: 512,
                each: 512
            }
        );
        let most = MOST as usize;
        let expected = Limits {
            all: most,
            each: most / 2,
        };
        assert_eq!(Limits::of(u64::MAX, false), expected);
    }
}
