//! One message to a web hook: where it may go, its signature, and the meaning of the answer.
//!
//! Users choose the URL, so the server would make requests into its own network for them. Addresses are judged when the connection is made,
//! after the name is resolved: a name that leads to another address later is judged anew.

use std::net::IpAddr;
use std::time::Duration;

use axum::http::Uri;
use cloud_store::hex;
use hmac::{Hmac, KeyInit, Mac};
use sha2::Sha256;
use ureq::config::Config;
use ureq::tls::{RootCerts, TlsConfig};
use ureq::unversioned::resolver::{DefaultResolver, ResolvedSocketAddrs, Resolver};
use ureq::unversioned::transport::{DefaultConnector, NextTimeout};
use ureq::{Agent, Error};

/// How long a message may take, from the look-up of the name to the head of the answer.
const PATIENCE: Duration = Duration::from_secs(10);

/// The longest URL, in bytes.
const LONGEST_URL: usize = 2000;

/// The longest head of an answer that is read, in bytes. Of the body nothing is read.
const LONGEST_HEAD: usize = 16 << 10;

/// Whether an address is one of the public internet: neither of this machine nor of a network of a house, nor with a special meaning
/// (IANA's registries of special-purpose addresses).
fn is_public(address: IpAddr) -> bool {
    match address.to_canonical() {
        IpAddr::V4(v4) => {
            let [a, b, c, _] = v4.octets();
            let special = matches!(
                (a, b, c),
                (0 | 10 | 127 | 224.., ..)
                    | (100, 64..=127, _)
                    | (169, 254, _)
                    | (172, 16..=31, _)
                    | (192, 168, _)
                    | (192, 0, 0 | 2)
                    | (192, 88, 99)
                    | (198, 18 | 19, _)
                    | (198, 51, 100)
                    | (203, 0, 113)
            );
            !special
        }
        // Global unicast is 2000::/3. Within it are protocols (2001::/23), documentation (2001:db8::/32, 3fff::/20), and 2002::/16, which
        // holds addresses of version 4.
        IpAddr::V6(v6) => match v6.segments() {
            [0x2001, 0..=0x1ff | 0xdb8, ..] | [0x2002, ..] | [0x3fff, 0..=0xfff, ..] => false,
            [first, ..] => first >> 13 == 1,
        },
    }
}

/// Whether a host is one that the administrator allows.
fn is_allowed(host: &str, hosts: &[String]) -> bool {
    let plain = |name: &str| {
        let name = name.trim_start_matches('[').trim_end_matches([']', '.']);
        name.to_ascii_lowercase()
    };
    hosts.iter().any(|allowed| plain(allowed) == plain(host))
}

/// Reason for which a URL cannot be a hook. `hosts`: those of `--hooks-to`.
pub(super) fn check(url: &str, hosts: &[String]) -> Result<(), String> {
    if url.len() > LONGEST_URL {
        return Err(format!("The URL is longer than {LONGEST_URL} bytes."));
    }
    let example = "It must be such as https://example.org/path.";
    let uri: Uri = (url.parse()).map_err(|error| format!("It is no URL: {error}. {example}"))?;
    let (Some(scheme), Some(authority)) = (uri.scheme_str(), uri.authority()) else {
        return Err(format!("It has no scheme or no host. {example}"));
    };
    let host = authority.host();
    if authority.as_str().contains('@') {
        return Err("It has a name or a password in front of the host. Put a secret into the path; messages have a signature.".into());
    }
    let allowed = is_allowed(host, hosts);
    match scheme {
        "https" => {}
        "http" if allowed => {}
        "http" => {
            return Err(format!(
                "Messages go by https. The administrator may allow http to {host} by `serve --hooks-to {host}`."
            ));
        }
        _ => return Err(format!("Its scheme is {scheme}. {example}")),
    }
    let literal: Result<IpAddr, _> = host.trim_matches(['[', ']']).parse();
    match literal {
        Ok(address) if !allowed && !is_public(address) => Err(inside(host)),
        _ => Ok(()),
    }
}

fn inside(host: &str) -> String {
    format!(
        "{host} has no public address. The administrator may allow it by `serve --hooks-to {host}`."
    )
}

/// Resolves names to public addresses, and those of allowed hosts to any.
#[derive(Debug)]
struct Outside {
    hosts: Vec<String>,
    names: DefaultResolver,
}

impl Resolver for Outside {
    fn resolve(
        &self,
        uri: &Uri,
        config: &Config,
        timeout: NextTimeout,
    ) -> Result<ResolvedSocketAddrs, Error> {
        let found = self.names.resolve(uri, config, timeout)?;
        let host = uri.host().unwrap_or_default();
        if is_allowed(host, &self.hosts) {
            return Ok(found);
        }
        let mut public = self.empty();
        for address in found.iter().filter(|address| is_public(address.ip())) {
            public.push(*address);
        }
        if public.is_empty() {
            return Err(Error::Other(inside(host).into()));
        }
        Ok(public)
    }
}

/// Client for messages. It follows no redirection, uses no proxy and keeps no connection.
pub(super) fn client(hosts: Vec<String>) -> Agent {
    let tls = TlsConfig::builder()
        .root_certs(RootCerts::PlatformVerifier)
        .build();
    let config = Agent::config_builder()
        .http_status_as_error(false)
        .tls_config(tls)
        .proxy(None)
        .max_redirects(0)
        .timeout_global(Some(PATIENCE))
        .max_response_header_size(LONGEST_HEAD)
        .max_idle_connections(0)
        .user_agent(concat!("mercury-cloud/", env!("CARGO_PKG_VERSION")))
        .build();
    let names = DefaultResolver::default();
    Agent::with_parts(
        config,
        DefaultConnector::default(),
        Outside { hosts, names },
    )
}

/// Signature of a message: HMAC-SHA256 (RFC 2104) of the time, a full stop and the body.
fn signature(secret: &str, time: u64, body: &str) -> String {
    // HMAC takes keys of any length.
    let Ok(mac) = Hmac::<Sha256>::new_from_slice(secret.as_bytes()) else {
        return String::new();
    };
    let mac = mac.chain_update(format!("{time}.{body}"));
    format!("sha256={}", hex(&mac.finalize().into_bytes()))
}

/// Sends a message. Returns the status of the answer, and the reason for which the message is not delivered.
pub(super) fn send(
    client: &Agent,
    (url, secret): (&str, &str),
    id: i64,
    time: u64,
    body: &str,
) -> (Option<u16>, Option<String>) {
    let answer = client
        .post(url)
        .header("content-type", "application/json")
        .header("mercury-delivery", id.to_string())
        .header("mercury-time", time.to_string())
        .header("mercury-signature", signature(secret, time, body))
        .send(body);
    match answer {
        Ok(answer) => {
            let status = answer.status();
            let why = match status.as_u16() {
                200..=299 => None,
                300..=399 => Some(format!(
                    "The answer is {status}. Redirections are not followed: give the URL to which this one leads."
                )),
                _ => Some(format!("The answer is {status}.")),
            };
            (Some(status.as_u16()), why)
        }
        Err(error) => {
            let why = match error {
                Error::HostNotFound => "The name of the host has no address.".to_owned(),
                Error::Timeout(_) => format!("No answer within {} s.", PATIENCE.as_secs()),
                Error::Other(inside) => inside.to_string(),
                other => format!("No connection, or no answer: {other}."),
            };
            (None, Some(why))
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::{Read, Write};
    use std::net::TcpListener;
    use std::thread;

    use super::*;

    #[test]
    fn addresses_of_machines_and_houses_are_not_public() {
        let is = |text: &str| is_public(text.parse().unwrap());
        for address in [
            "0.0.0.0",
            "10.1.2.3",
            "100.64.0.1",
            "127.0.0.1",
            "127.1.2.3",
            "169.254.169.254",
            "172.16.0.1",
            "172.31.255.255",
            "192.0.0.8",
            "192.168.1.1",
            "198.18.0.1",
            "224.0.0.1",
            "255.255.255.255",
            "::",
            "::1",
            "::ffff:127.0.0.1",
            "::127.0.0.1",
            "64:ff9b::a9fe:a9fe",
            "fc00::1",
            "fd00:ec2::254",
            "fe80::1",
            "fec0::1",
            "ff02::1",
            "2001::1",
            "2001:db8::1",
            "2002:7f00:1::",
        ] {
            assert!(!is(address), "{address}");
        }
        for address in [
            "1.1.1.1",
            "100.63.0.1",
            "172.32.0.1",
            "192.167.1.1",
            "198.20.0.1",
            "2001:200::1",
            "2606:4700::1",
            "2a00:1450::1",
            "::ffff:1.1.1.1",
        ] {
            assert!(is(address), "{address}");
        }
    }

    #[test]
    fn urls_are_judged_before_they_are_kept() {
        let hosts = ["Chat.House".to_owned(), "::1".to_owned()];
        for good in [
            "https://example.org/a?b=c",
            "https://example.org:8443",
            "http://chat.house./x",
            "http://[::1]:80/",
            "https://1.1.1.1/",
        ] {
            assert_eq!(check(good, &hosts), Ok(()), "{good}");
        }
        let long = format!("https://example.org/{}", "x".repeat(LONGEST_URL));
        for (bad, why) in [
            ("example.org", "no scheme"),
            ("/path", "no scheme"),
            ("ftp://example.org/", "scheme is ftp"),
            ("http://example.org/", "--hooks-to example.org"),
            ("https://a:b@example.org/", "password"),
            ("https://chat.house@example.org/", "password"),
            ("https://127.0.0.1/", "no public address"),
            ("https://[fe80::1]:443/", "no public address"),
            ("https://example.org/\r\nx: y", "no URL"),
            ("https:// /", "no URL"),
            (&long, "longer"),
        ] {
            let said = check(bad, &hosts).unwrap_err();
            assert!(said.contains(why), "{bad}: {said}");
        }
    }

    /// RFC 4231, test case 2, whose message is cut at a full stop here: key `Jefe`, `what do ya want for nothing?`.
    #[test]
    fn signatures_are_those_of_the_standard() {
        let mac = Hmac::<Sha256>::new_from_slice(b"Jefe").unwrap();
        let mac = mac.chain_update("what do ya want for nothing?").finalize();
        let expected = "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843";
        assert_eq!(hex(&mac.into_bytes()), expected);
        let parts = Hmac::<Sha256>::new_from_slice(b"Jefe").unwrap();
        let parts = parts.chain_update("12.").chain_update("{}").finalize();
        let expected = format!("sha256={}", hex(&parts.into_bytes()));
        assert_eq!(signature("Jefe", 12, "{}"), expected);
    }

    /// A server that answers each request with the same text. Returns its port.
    fn answering(text: &'static str) -> u16 {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        thread::spawn(move || {
            for near in listener.incoming() {
                let mut near = near.unwrap();
                let mut buffer = [0; 4096];
                let _ = near.read(&mut buffer);
                let _ = near.write_all(text.as_bytes());
            }
        });
        port
    }

    fn sent(hosts: &[&str], url: &str) -> (Option<u16>, Option<String>) {
        let client = client(hosts.iter().map(|host| (*host).to_owned()).collect());
        send(&client, (url, "secret"), 1, 1, "{}")
    }

    #[test]
    fn answers_say_whether_a_message_is_delivered() {
        let at = |text| format!("http://127.0.0.1:{}/", answering(text));
        let here = &["127.0.0.1"];
        let url = at("HTTP/1.1 204 No Content\r\n\r\n");
        assert_eq!(sent(here, &url), (Some(204), None));
        let url = at("HTTP/1.1 302 Found\r\nLocation: /again\r\nContent-Length: 0\r\n\r\n");
        let (status, why) = sent(here, &url);
        assert!(status == Some(302) && why.unwrap().contains("not followed"));
        let url = at("HTTP/1.1 500 No\r\nContent-Length: 0\r\n\r\n");
        let (status, why) = sent(here, &url);
        assert!(status == Some(500) && why.unwrap().contains("500"));
    }

    /// Also by a name, which is resolved after the URL was judged.
    #[test]
    fn connections_into_this_network_are_refused() {
        let port = answering("HTTP/1.1 204 No Content\r\n\r\n");
        for host in [
            "127.0.0.1",
            "localhost",
            "2130706433",
            "0",
            "[::ffff:127.0.0.1]",
        ] {
            let (status, why) = sent(&["elsewhere"], &format!("http://{host}:{port}/"));
            let why = why.unwrap();
            assert!(
                status.is_none() && why.contains("--hooks-to"),
                "{host}: {why}"
            );
        }
    }
}
