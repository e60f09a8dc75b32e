//! The notice that a provider is going to take the machine away (EC2 spot instances).
//!
//! The address of the instance metadata service is that of `AWS_EC2_METADATA_SERVICE_ENDPOINT`, as in AWS's own programs,
//! so that a mock can stand in. Without that variable nothing is looked for: elsewhere than at AWS the address belongs
//! to nothing, or to something else. The image for AWS sets it.

use std::io::{self, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::thread;
use std::time::Duration;

/// AWS looks for notices every 5 s, and so do we (Spot Instance interruption notices).
const EVERY: Duration = Duration::from_secs(5);

/// How long an answer may take; the service is on the machine's own link.
const PATIENCE: Duration = Duration::from_secs(2);

/// A notice of interruption.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Notice {
    /// The machine may be taken away some time: a checkpoint is worth while.
    Rebalance,
    /// The machine will be taken away in two minutes.
    Spot,
}

/// Looks for notices in a thread of its own.
pub(crate) struct Notices(Arc<AtomicU8>);

impl Notices {
    pub(crate) fn begin() -> Self {
        let seen = Arc::new(AtomicU8::new(0));
        if let Ok(endpoint) = std::env::var("AWS_EC2_METADATA_SERVICE_ENDPOINT") {
            let seen = Arc::clone(&seen);
            thread::spawn(move || {
                loop {
                    // No answer is no notice; the next look is soon.
                    if let Ok(Some(notice)) = look(&endpoint) {
                        seen.fetch_max(
                            if notice == Notice::Spot { 2 } else { 1 },
                            Ordering::Relaxed,
                        );
                    }
                    thread::sleep(EVERY);
                }
            });
        }
        Self(seen)
    }

    /// The most urgent notice so far.
    pub(crate) fn newest(&self) -> Option<Notice> {
        match self.0.load(Ordering::Relaxed) {
            0 => None,
            1 => Some(Notice::Rebalance),
            _ => Some(Notice::Spot),
        }
    }
}

fn look(endpoint: &str) -> io::Result<Option<Notice>> {
    let token = match request(
        endpoint,
        "PUT",
        "/latest/api/token",
        "X-aws-ec2-metadata-token-ttl-seconds: 60",
    )? {
        (200, token) => token,
        _ => return Ok(None),
    };
    let header = format!("X-aws-ec2-metadata-token: {}", token.trim());
    if request(
        endpoint,
        "GET",
        "/latest/meta-data/spot/instance-action",
        &header,
    )?
    .0 == 200
    {
        return Ok(Some(Notice::Spot));
    }
    let rebalance = request(
        endpoint,
        "GET",
        "/latest/meta-data/events/recommendations/rebalance",
        &header,
    )?;
    Ok((rebalance.0 == 200).then_some(Notice::Rebalance))
}

/// A request without a body, by HTTP/1.0, which needs no chunks. Returns status and body.
fn request(endpoint: &str, method: &str, path: &str, header: &str) -> io::Result<(u16, String)> {
    let host = endpoint.trim_start_matches("http://").trim_end_matches('/');
    let named = if host.contains(':') {
        host.to_owned()
    } else {
        format!("{host}:80")
    };
    let address = named
        .to_socket_addrs()?
        .next()
        .ok_or(io::ErrorKind::NotFound)?;
    let mut stream = TcpStream::connect_timeout(&address, PATIENCE)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    // In one piece: a request that comes in several is more than some small servers read.
    let request = format!(
        "{method} {path} HTTP/1.0\r\nHost: {host}\r\n{header}\r\nContent-Length: 0\r\n\r\n"
    );
    stream.write_all(request.as_bytes())?;
    let mut answer = String::new();
    stream.take(1 << 16).read_to_string(&mut answer)?;
    let status = answer
        .split_whitespace()
        .nth(1)
        .and_then(|word| word.parse().ok());
    let body = answer.split_once("\r\n\r\n").map_or("", |(_, body)| body);
    Ok((status.ok_or(io::ErrorKind::InvalidData)?, body.to_owned()))
}

#[cfg(test)]
mod tests {
    use std::net::TcpListener;

    use super::*;

    /// A service that knows the token and answers the action with `status`.
    fn service(action: u16, rebalance: u16) -> String {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let endpoint = format!("http://{}", listener.local_addr().unwrap());
        thread::spawn(move || {
            for stream in listener.incoming() {
                let mut stream = stream.unwrap();
                let mut bytes = [0; 1024];
                let n = stream.read(&mut bytes).unwrap();
                let text = String::from_utf8_lossy(&bytes[..n]).into_owned();
                let (status, body) = match &text {
                    t if t.starts_with("PUT /latest/api/token") => (200, "secret"),
                    t if !t.contains("X-aws-ec2-metadata-token: secret") => (401, ""),
                    t if t.contains("instance-action") => (action, "{\"action\": \"terminate\"}"),
                    t if t.contains("rebalance") => (rebalance, "{}"),
                    _ => (404, ""),
                };
                write!(stream, "HTTP/1.0 {status} X\r\n\r\n{body}").unwrap();
            }
        });
        endpoint
    }

    #[test]
    fn notices_are_read() {
        assert_eq!(look(&service(404, 404)).unwrap(), None);
        assert_eq!(look(&service(404, 200)).unwrap(), Some(Notice::Rebalance));
        assert_eq!(look(&service(200, 200)).unwrap(), Some(Notice::Spot));
        assert!(look("http://127.0.0.1:1").is_err());
    }
}
