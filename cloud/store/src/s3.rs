//! A store in a bucket of S3, or of a server with its interface.
//!
//! `swap` is a conditional write: `If-None-Match: *` where there must be no key, `If-Match` with the entity tag of the
//! content that was read otherwise (Amazon S3, "Conditional writes"). A server that takes no notice of these headers
//! would let two attempts write over each other, so [`S3Store::create`] tries them first and refuses such a server.
//!
//! Address and credentials come from the variables that AWS's own programs read (`AWS_REGION`, `AWS_ENDPOINT_URL`,
//! `AWS_ACCESS_KEY_ID`, ...), from the role of the container, or from that of the machine.

use std::collections::VecDeque;
use std::fs::File;
use std::future::Future;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::sync::{Arc, OnceLock, mpsc};
use std::time::Duration;

use futures_util::{StreamExt, TryStreamExt};
use object_store::aws::{AmazonS3, AmazonS3Builder};
use object_store::path::Path;
use object_store::{
    BackoffConfig, ClientOptions, GetOptions, GetRange, MultipartUpload, ObjectStore,
    ObjectStoreExt, PutMode, PutOptions, PutPayload, RetryConfig, UpdateVersion,
};
use tokio::runtime::Runtime;
use tokio::task::JoinHandle;

use crate::{Entry, Hashing, Result, Store, StoreError, Version, check_key};

/// Contents up to this length go in one request, in bytes.
const ONE_REQUEST: u64 = 16 << 20;

/// The most parts of an upload that S3 takes.
const MOST_PARTS: u64 = 10_000;

/// Parts of one upload that are on their way at once.
const AT_ONCE: usize = 4;

/// How long one request may take. A worker that has to stop has 25 s at AWS Batch, so this is no longer.
const PATIENCE: Duration = Duration::from_secs(20);

/// How long a connection may take.
const CONNECT: Duration = Duration::from_secs(5);

/// A store in a bucket.
pub struct S3Store {
    bucket: Arc<AmazonS3>,
    /// As it was given, for messages.
    url: String,
    prefix: String,
}

impl S3Store {
    /// The store at `s3://BUCKET/PREFIX`.
    pub fn open(url: &str) -> Result<Self> {
        let failed = |text: String| StoreError::Url {
            url: url.to_owned(),
            why: text,
        };
        let rest = url
            .strip_prefix("s3://")
            .ok_or_else(|| failed("it begins with s3://".to_owned()))?;
        let (bucket, prefix) = rest.split_once('/').unwrap_or((rest, ""));
        let prefix = prefix.trim_end_matches('/');
        if bucket.is_empty() {
            return Err(failed(
                "the bucket is missing: s3://BUCKET/PREFIX".to_owned(),
            ));
        }
        if !prefix.is_empty() {
            check_key(prefix).map_err(|error| failed(error.to_string()))?;
        }
        let endpoint = |name: &str| std::env::var(name).is_ok_and(|at| at.starts_with("http://"));
        let plain = ["AWS_ENDPOINT_URL", "AWS_ENDPOINT_URL_S3", "AWS_ENDPOINT"]
            .into_iter()
            .any(endpoint);
        let mut builder = AmazonS3Builder::from_env()
            .with_bucket_name(bucket)
            // Some servers know single removals only.
            .with_disable_bulk_delete(true)
            .with_client_options(
                ClientOptions::new()
                    .with_timeout(PATIENCE)
                    .with_connect_timeout(CONNECT)
                    // The user names such an address, or none.
                    .with_allow_http(plain),
            )
            // Callers try again by themselves, and have other things to do meanwhile.
            .with_retry(RetryConfig {
                backoff: BackoffConfig {
                    init_backoff: Duration::from_millis(100),
                    max_backoff: Duration::from_secs(2),
                    base: 2.0,
                },
                max_retries: 2,
                retry_timeout: PATIENCE,
            });
        if let Ok(service) = std::env::var("AWS_EC2_METADATA_SERVICE_ENDPOINT") {
            builder = builder.with_metadata_endpoint(service.trim_end_matches('/'));
        }
        let bucket = builder.build().map_err(|error| failed(error.to_string()))?;
        Ok(Self {
            bucket: Arc::new(bucket),
            url: url.to_owned(),
            prefix: prefix.to_owned(),
        })
    }

    /// The store at `url`, if it does conditional writes.
    pub fn create(url: &str) -> Result<Self> {
        let store = Self::open(url)?;
        store.probe()?;
        Ok(store)
    }

    /// Tries whether the server takes notice of `If-None-Match` and `If-Match`.
    fn probe(&self) -> Result<()> {
        let key = format!("probe/{}", std::process::id());
        self.delete(&key)?;
        let first = self.swap(&key, None, b"1")?;
        let again = self.swap(&key, None, b"2")?;
        let second = self.swap(&key, first.as_ref(), b"3")?;
        let stale = self.swap(&key, first.as_ref(), b"4")?;
        let kept = self.get(&key)?;
        self.delete(&key)?;
        let good = first.is_some()
            && again.is_none()
            && second.is_some()
            && stale.is_none()
            && kept.as_deref() == Some(b"3");
        if good {
            return Ok(());
        }
        Err(StoreError::Url {
            url: self.url.clone(),
            why: "the server does not do conditional writes (If-None-Match and If-Match of PutObject), so two attempts \
                  at one run could write over each other; use a server that does, or a folder"
                .to_owned(),
        })
    }

    fn path(&self, key: &str) -> Result<Path> {
        check_key(key)?;
        Ok(self.below(key))
    }

    fn below(&self, key: &str) -> Path {
        if self.prefix.is_empty() {
            Path::from(key)
        } else {
            Path::from(format!("{}/{key}", self.prefix))
        }
    }

    /// Reads a content; `None`: there is no such key.
    fn read(&self, key: &str, options: GetOptions) -> Result<Option<(Vec<u8>, Option<String>)>> {
        let (bucket, path) = (Arc::clone(&self.bucket), self.path(key)?);
        let read = wait(async move {
            let got = bucket.get_opts(&path, options).await?;
            let tag = got.meta.e_tag.clone();
            Ok::<_, object_store::Error>((got.bytes().await?.to_vec(), tag))
        });
        match read {
            Ok(read) => Ok(Some(read)),
            Err(object_store::Error::NotFound { .. }) => Ok(None),
            Err(error) => Err(out_of_reach(key, error)),
        }
    }

    fn upload(&self, key: &str, file: &mut File, bytes: u64) -> Result<String> {
        let (bucket, path) = (Arc::clone(&self.bucket), self.path(key)?);
        let begun = wait(async move { bucket.put_multipart(&path).await });
        let mut upload = begun.map_err(|error| out_of_reach(key, error))?;
        match self.parts(key, upload.as_mut(), file, bytes) {
            Ok(sha256) => {
                let done = wait(async move { upload.complete().await });
                done.map_err(|error| out_of_reach(key, error))?;
                Ok(sha256)
            }
            Err(error) => {
                // What cannot be taken back is removed by the bucket's rule for half uploads.
                let _ = wait(async move { upload.abort().await });
                Err(error)
            }
        }
    }

    fn parts(
        &self,
        key: &str,
        upload: &mut dyn MultipartUpload,
        file: &mut File,
        bytes: u64,
    ) -> Result<String> {
        let part = ONE_REQUEST.max(bytes.div_ceil(MOST_PARTS));
        let mut hashing = Hashing::new(io::sink());
        let mut going: VecDeque<JoinHandle<object_store::Result<()>>> = VecDeque::new();
        let mut left = bytes;
        while left > 0 || !going.is_empty() {
            if left == 0 || going.len() >= AT_ONCE {
                let Some(oldest) = going.pop_front() else {
                    break;
                };
                wait(oldest)
                    .map_err(|error| out_of_reach(key, error))?
                    .map_err(|error| out_of_reach(key, error))?;
                continue;
            }
            let piece = read_exactly(file, part.min(left)).map_err(|e| out_of_reach(key, e))?;
            left -= piece.len() as u64;
            hashing
                .write_all(&piece)
                .map_err(|error| out_of_reach(key, error))?;
            going.push_back(runtime().spawn(upload.put_part(PutPayload::from(piece))));
        }
        Ok(hashing.finish().0)
    }
}

fn read_exactly(file: &mut File, bytes: u64) -> io::Result<Vec<u8>> {
    let mut piece = vec![0; bytes as usize];
    file.read_exact(&mut piece)?;
    Ok(piece)
}

fn out_of_reach(key: &str, error: impl std::error::Error + Send + Sync + 'static) -> StoreError {
    StoreError::OutOfReach {
        key: key.to_owned(),
        source: io::Error::other(error),
    }
}

/// Requests run on threads of their own, so that callers may be threads of another runtime.
fn runtime() -> &'static Runtime {
    static RUNTIME: OnceLock<Runtime> = OnceLock::new();
    RUNTIME.get_or_init(|| {
        tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .thread_name("store")
            .enable_all()
            .build()
            .expect("a thread for requests to the store")
    })
}

/// Waits for a request.
fn wait<T: Send + 'static>(work: impl Future<Output = T> + Send + 'static) -> T {
    let (send, receive) = mpsc::sync_channel(1);
    runtime().spawn(async move {
        // The receiver waits below.
        let _ = send.send(work.await);
    });
    receive.recv().expect("a request that ends")
}

impl Store for S3Store {
    fn put(&self, key: &str, bytes: &[u8]) -> Result<()> {
        let (bucket, path) = (Arc::clone(&self.bucket), self.path(key)?);
        let payload = PutPayload::from(bytes.to_vec());
        wait(async move { bucket.put(&path, payload).await })
            .map(|_| ())
            .map_err(|error| out_of_reach(key, error))
    }

    fn put_file(&self, key: &str, file: &mut File, range: Range<u64>) -> Result<String> {
        let bytes = range.end.saturating_sub(range.start);
        file.seek(SeekFrom::Start(range.start))
            .map_err(|error| out_of_reach(key, error))?;
        if bytes > ONE_REQUEST {
            return self.upload(key, file, bytes);
        }
        let content = read_exactly(file, bytes).map_err(|error| out_of_reach(key, error))?;
        self.put(key, &content)?;
        Ok(crate::sha256(&content))
    }

    fn get(&self, key: &str) -> Result<Option<Vec<u8>>> {
        Ok(self
            .read(key, GetOptions::default())?
            .map(|(bytes, _)| bytes))
    }

    fn get_range(&self, key: &str, range: Range<u64>) -> Result<Vec<u8>> {
        // A range behind the end is an error of S3's.
        let Some(bytes) = self.bytes(key)? else {
            return Err(StoreError::Missing(key.to_owned()));
        };
        let range = range.start..range.end.min(bytes);
        if range.start >= range.end {
            return Ok(Vec::new());
        }
        let options = GetOptions {
            range: Some(GetRange::Bounded(range)),
            ..GetOptions::default()
        };
        match self.read(key, options)? {
            Some((bytes, _)) => Ok(bytes),
            None => Err(StoreError::Missing(key.to_owned())),
        }
    }

    fn get_into(&self, key: &str, to: &mut File) -> Result<String> {
        let (bucket, path) = (Arc::clone(&self.bucket), self.path(key)?);
        let (send, receive) = mpsc::sync_channel(4);
        let task = runtime().spawn(async move {
            let mut stream = bucket.get(&path).await?.into_stream();
            while let Some(piece) = stream.next().await {
                let piece = piece?;
                // Taken by a thread that writes; where that is slow, nothing else waits on this one for long.
                if tokio::task::block_in_place(|| send.send(piece)).is_err() {
                    break;
                }
            }
            Ok::<_, object_store::Error>(())
        });
        let mut hashing = Hashing::new(to);
        let mut written = Ok(());
        for piece in receive {
            written = hashing.write_all(&piece);
            if written.is_err() {
                break;
            }
        }
        written.map_err(|error| out_of_reach(key, error))?;
        match wait(task).map_err(|error| out_of_reach(key, error))? {
            Ok(()) => Ok(hashing.finish().0),
            Err(object_store::Error::NotFound { .. }) => Err(StoreError::Missing(key.to_owned())),
            Err(error) => Err(out_of_reach(key, error)),
        }
    }

    fn bytes(&self, key: &str) -> Result<Option<u64>> {
        let (bucket, path) = (Arc::clone(&self.bucket), self.path(key)?);
        match wait(async move { bucket.head(&path).await }) {
            Ok(meta) => Ok(Some(meta.size)),
            Err(object_store::Error::NotFound { .. }) => Ok(None),
            Err(error) => Err(out_of_reach(key, error)),
        }
    }

    fn list(&self, prefix: &str) -> Result<Vec<Entry>> {
        let folder = prefix.trim_end_matches('/');
        let (bucket, path) = (Arc::clone(&self.bucket), self.path(folder)?);
        let all = wait(async move { bucket.list(Some(&path)).try_collect::<Vec<_>>().await });
        let surplus = if self.prefix.is_empty() {
            0
        } else {
            self.prefix.len() + 1
        };
        let mut entries: Vec<Entry> = all
            .map_err(|error| out_of_reach(prefix, error))?
            .into_iter()
            .filter_map(|meta| {
                Some(Entry {
                    key: meta.location.as_ref().get(surplus..)?.to_owned(),
                    bytes: meta.size,
                })
            })
            .collect();
        entries.sort_by(|a, b| a.key.cmp(&b.key));
        Ok(entries)
    }

    fn delete(&self, key: &str) -> Result<()> {
        let (bucket, path) = (Arc::clone(&self.bucket), self.path(key)?);
        match wait(async move { bucket.delete(&path).await }) {
            Ok(()) | Err(object_store::Error::NotFound { .. }) => Ok(()),
            Err(error) => Err(out_of_reach(key, error)),
        }
    }

    fn delete_all(&self, prefix: &str) -> Result<()> {
        let folder = prefix.trim_end_matches('/');
        let (bucket, path) = (Arc::clone(&self.bucket), self.path(folder)?);
        let removed = wait(async move {
            let keys = bucket
                .list(Some(&path))
                .map_ok(|meta| meta.location)
                .boxed();
            bucket.delete_stream(keys).try_collect::<Vec<_>>().await
        });
        match removed {
            Ok(_) | Err(object_store::Error::NotFound { .. }) => Ok(()),
            Err(error) => Err(out_of_reach(prefix, error)),
        }
    }

    fn get_versioned(&self, key: &str) -> Result<Option<(Vec<u8>, Version)>> {
        match self.read(key, GetOptions::default())? {
            Some((bytes, Some(tag))) => Ok(Some((bytes, Version(tag)))),
            Some((_, None)) => Err(no_tag(key)),
            None => Ok(None),
        }
    }

    fn swap(&self, key: &str, expected: Option<&Version>, new: &[u8]) -> Result<Option<Version>> {
        let (bucket, path) = (Arc::clone(&self.bucket), self.path(key)?);
        let mode = match expected {
            None => PutMode::Create,
            Some(version) => PutMode::Update(UpdateVersion {
                e_tag: Some(version.0.clone()),
                version: None,
            }),
        };
        let payload = PutPayload::from(new.to_vec());
        let put = wait(async move {
            bucket
                .put_opts(&path, payload, PutOptions::from(mode))
                .await
        });
        match put {
            Ok(done) => done
                .e_tag
                .map(|tag| Some(Version(tag)))
                .ok_or_else(|| no_tag(key)),
            Err(
                object_store::Error::AlreadyExists { .. }
                | object_store::Error::Precondition { .. },
            ) => Ok(None),
            // The key has gone. Where there must be none, it is the bucket that is missing.
            Err(object_store::Error::NotFound { .. }) if expected.is_some() => Ok(None),
            Err(error) => Err(out_of_reach(key, error)),
        }
    }
}

fn no_tag(key: &str) -> StoreError {
    out_of_reach(key, io::Error::other("its answer has no entity tag (ETag)"))
}
