//! Objects by name in a folder or in an object store (S3, GCS, Azure): the only module that knows the crates `object_store`, `tokio`,
//! `futures-util` and `url`.
//!
//! An object appears as a whole or not at all, and is never replaced: of several writers of one name, the first wins. All calls
//! block: each waits on a runtime that belongs to the store and has no thread of its own.

use std::path::Path as FilePath;
use std::sync::Arc;

use futures_util::StreamExt;
use hysteron_base::BadInput;
use object_store::local::LocalFileSystem;
use object_store::path::Path;
use object_store::{Error, ObjectStore, ObjectStoreExt, PutMode, PutOptions, PutPayload};
use tokio::runtime::Runtime;
use url::Url;

/// Objects that are read at the same time, while the network is waited for.
const READ_AHEAD: usize = 16;

/// A folder or a bucket.
pub struct Store {
    url: String,
    prefix: Path,
    inner: Arc<dyn ObjectStore>,
    runtime: Runtime,
}

/// Whether an object that was put is the first of its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PutOutcome {
    /// It is there now.
    Written,
    /// One of this name was there before, and stays as it is.
    AlreadyThere,
}

/// An object in a list.
#[derive(Debug, Clone, Copy)]
pub struct ObjectEntry<'a> {
    /// Its name within the store.
    pub name: &'a str,
    /// Its size [byte].
    pub bytes: u64,
    /// When it was written, by the clock of the store [s since 1970].
    pub written_s: f64,
}

impl Store {
    /// A store that exists: a folder, `file:///folder`, and with the feature `cloud` `s3://bucket/prefix`, `gs://` or `az://`, with
    /// the credentials of the environment.
    ///
    /// # Errors
    /// `BadInput` for another URL, or a folder that does not exist.
    pub fn open(url: &str) -> anyhow::Result<Self> {
        if let Some(folder) = folder_of(url)?
            && !folder.is_dir()
        {
            let found = if folder.exists() { "a file" } else { "nothing there" };
            return Err(BadInput::new(url, "a folder with a set of shards", found)
                .hint("`hysteron shards plan` makes one")
                .into());
        }
        Self::connected(url)
    }

    /// As [`Store::open`]; a folder is made if it does not exist.
    ///
    /// # Errors
    /// As [`Store::open`].
    pub fn create(url: &str) -> anyhow::Result<Self> {
        if let Some(folder) = folder_of(url)? {
            if folder.exists() && !folder.is_dir() {
                return Err(BadInput::new(url, "a folder", "a file").into());
            }
            std::fs::create_dir_all(&folder).map_err(|error| hysteron_base::Error::io(&folder, error))?;
        }
        Self::connected(url)
    }

    fn connected(url: &str) -> anyhow::Result<Self> {
        let (inner, prefix): (Arc<dyn ObjectStore>, Path) = match folder_of(url)? {
            Some(folder) => {
                let store = LocalFileSystem::new_with_prefix(&folder).map_err(|e| explained(e, url))?;
                (Arc::new(store.with_fsync(true)), Path::default())
            }
            None => remote(url)?,
        };
        // A call to the network needs its clock and its sockets.
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        Ok(Self { url: url.trim_end_matches('/').to_owned(), prefix, inner, runtime })
    }

    /// The place of an object in messages.
    pub fn place(&self, name: &str) -> String {
        format!("{}/{name}", self.url)
    }

    fn path(&self, name: &str) -> Path {
        name.split('/').fold(self.prefix.clone(), |path, part| path.join(part))
    }

    /// Puts an object whose name is new.
    ///
    /// # Errors
    /// `BadInput` for a store that refuses: no such bucket, wrong credentials, a full disk, a wrong clock.
    pub fn put_new(&self, name: &str, bytes: Vec<u8>) -> anyhow::Result<PutOutcome> {
        let options = PutOptions { mode: PutMode::Create, ..PutOptions::default() };
        let path = self.path(name);
        let put = self.inner.put_opts(&path, PutPayload::from(bytes), options);
        match self.runtime.block_on(put) {
            Ok(_) => Ok(PutOutcome::Written),
            Err(Error::AlreadyExists { .. }) => Ok(PutOutcome::AlreadyThere),
            Err(error) => Err(explained(error, &self.place(name))),
        }
    }

    /// The bytes of an object; `None` where there is none of this name.
    ///
    /// # Errors
    /// As [`Store::put_new`].
    pub fn get(&self, name: &str) -> anyhow::Result<Option<Vec<u8>>> {
        let read = self.runtime.block_on(self.read(name));
        absent_is_none(read, &self.place(name))
    }

    async fn read(&self, name: &str) -> Result<Vec<u8>, Error> {
        Ok(self.inner.get(&self.path(name)).await?.bytes().await?.into())
    }

    /// Whether there is an object of this name.
    ///
    /// # Errors
    /// As [`Store::put_new`].
    pub fn has(&self, name: &str) -> anyhow::Result<bool> {
        let found = self.runtime.block_on(self.inner.head(&self.path(name)));
        Ok(absent_is_none(found, &self.place(name))?.is_some())
    }

    /// Hands every object below `folder` to `each`, in no particular order; those that are still being written are not there.
    ///
    /// # Errors
    /// As [`Store::put_new`].
    pub fn list(&self, folder: &str, mut each: impl FnMut(ObjectEntry)) -> anyhow::Result<()> {
        let place = self.place(folder);
        let below = self.path(folder);
        let mut objects = self.inner.list(Some(&below));
        self.runtime.block_on(async {
            while let Some(found) = objects.next().await {
                // What another process takes away meanwhile is not there.
                let Some(found) = absent_is_none(found, &place)? else { continue };
                let Some(parts) = found.location.prefix_match(&self.prefix) else { continue };
                let name = parts.map(|part| part.as_ref().to_owned()).collect::<Vec<_>>().join("/");
                let written_s = 1e-3 * found.last_modified.timestamp_millis() as f64;
                each(ObjectEntry { name: &name, bytes: found.size, written_s });
            }
            Ok(())
        })
    }

    /// Hands the bytes of objects to `each`, in the order of the names; several are read ahead.
    ///
    /// # Errors
    /// As [`Store::put_new`]; `BadInput` for an object that is not there; those of `each`.
    pub fn get_each(
        &self,
        names: impl Iterator<Item = String>,
        mut each: impl FnMut(&str, Vec<u8>) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let read = |name: String| async move {
            let found = self.read(&name).await;
            (name, found)
        };
        let mut objects = futures_util::stream::iter(names).map(read).buffered(READ_AHEAD);
        self.runtime.block_on(async {
            while let Some((name, found)) = objects.next().await {
                let place = self.place(&name);
                let bytes = absent_is_none(found, &place)?;
                let bytes = bytes.ok_or_else(|| BadInput::new(place, "an object", "nothing there"))?;
                each(&name, bytes)?;
            }
            Ok(())
        })
    }
}

/// The folder of a URL, if it is one.
fn folder_of(url: &str) -> Result<Option<std::path::PathBuf>, BadInput> {
    const KINDS: &str = "a folder, or file://, s3://, gs:// or az:// and a place";
    let bad = |found: &str| BadInput::new("URL", KINDS, found);
    if url.is_empty() {
        return Err(bad("nothing"));
    }
    if !url.contains("://") {
        return Ok(Some(FilePath::new(url).to_owned()));
    }
    let parsed = Url::parse(url).map_err(|error| bad(url).hint(error.to_string()))?;
    match parsed.scheme() {
        "file" => {
            let folder = parsed.to_file_path();
            folder.map(Some).map_err(|()| bad(url).hint("file:// and the whole path: file:///data/set"))
        }
        "s3" | "gs" | "az" => Ok(None),
        _ => Err(bad(url)),
    }
}

#[cfg(feature = "cloud")]
fn remote(url: &str) -> anyhow::Result<(Arc<dyn ObjectStore>, Path)> {
    const VARIABLES: [&str; 3] = ["AWS_", "GOOGLE_", "AZURE_"];
    let is_of_store = |name: &str| VARIABLES.iter().any(|start| name.starts_with(start));
    let variables = std::env::vars().filter(|(name, _)| is_of_store(name));
    let variables = variables.map(|(name, value)| (name.to_ascii_lowercase(), value));
    let (store, prefix) =
        object_store::parse_url_opts(&Url::parse(url)?, variables).map_err(|error| explained(error, url))?;
    Ok((Arc::from(store), prefix))
}

#[cfg(not(feature = "cloud"))]
fn remote(url: &str) -> anyhow::Result<(Arc<dyn ObjectStore>, Path)> {
    Err(BadInput::new("URL", "a folder or file://", url)
        .hint("this program was built without object stores: build it with --features cloud")
        .into())
}

/// A result without the error that there is no such object.
fn absent_is_none<T>(found: Result<T, Error>, place: &str) -> anyhow::Result<Option<T>> {
    match found {
        Ok(found) => Ok(Some(found)),
        Err(error) if is_absent_object(&error) => Ok(None),
        Err(error) => Err(explained(error, place)),
    }
}

/// True where the store is there and the object is not.
fn is_absent_object(error: &Error) -> bool {
    matches!(error, Error::NotFound { .. }) && !is_absent_bucket(&text_of(error))
}

fn is_absent_bucket(text: &str) -> bool {
    ["NoSuchBucket", "ContainerNotFound", "bucket does not exist"].iter().any(|word| text.contains(word))
}

/// An error with the texts of its sources, on one line.
fn text_of(error: &dyn std::error::Error) -> String {
    let sources = std::iter::successors(Some(error), |error| error.source());
    let text = sources.map(ToString::to_string).collect::<Vec<_>>().join(": ");
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The refusal of a store, as what the user can change; anything else is a failure.
fn explained(error: Error, place: &str) -> anyhow::Error {
    let text = text_of(&error);
    let mut sources = std::iter::successors(Some(&error as &dyn std::error::Error), |error| error.source());
    let kind = sources.find_map(|source| source.downcast_ref::<std::io::Error>()).map(std::io::Error::kind);
    let is_full = matches!(kind, Some(std::io::ErrorKind::StorageFull | std::io::ErrorKind::QuotaExceeded));
    let says = |words: &[&str]| words.iter().any(|word| text.contains(word));
    // Stores answer in XML; its code says what is wrong, the rest is about the request.
    let code = text.split_once("<Code>").and_then(|(_, rest)| rest.split_once("</Code>"));
    let found = code.map_or_else(|| error.to_string(), |(code, _)| code.to_owned());
    let bad = |expected: &str, hint: &str| BadInput::new(place, expected, &*found).hint(hint).into();
    if is_full {
        let hint =
            "free some, and run the same command again: what is there stays, and nothing is there in part";
        return BadInput::new(place, "room for the object", "a full disk").hint(hint).into();
    }
    if says(&["RequestTimeTooSkewed", "RequestExpired", "Make sure your server has the correct time"]) {
        let hint = "set the clock of this machine, as NTP does; a store refuses requests some minutes off";
        return bad("a request with the time of the store", hint);
    }
    if is_absent_bucket(&text) {
        return bad(
            "a bucket that exists",
            "check its name and region, or make it with the tools of the store",
        );
    }
    if kind == Some(std::io::ErrorKind::PermissionDenied) {
        return bad("a folder that may be written", "check its owner and its mode");
    }
    let is_refused = matches!(error, Error::PermissionDenied { .. } | Error::Unauthenticated { .. });
    if is_refused
        || says(&["InvalidAccessKeyId", "SignatureDoesNotMatch", "169.254.169.254", "latest/api/token"])
    {
        let hint = "check AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY and AWS_REGION; GOOGLE_SERVICE_ACCOUNT; or \
                    AZURE_STORAGE_ACCOUNT_NAME and AZURE_STORAGE_ACCOUNT_KEY";
        return bad("credentials that may read and write here", hint);
    }
    anyhow::Error::new(error).context(place.to_owned())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;
    use crate::WorkflowError;

    fn store() -> (tempfile::TempDir, Store) {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::create(&folder.path().join("set").display().to_string()).unwrap();
        (folder, store)
    }

    #[test]
    fn of_sixteen_writers_of_an_object_one_wins() {
        let (_folder, store) = store();
        let url = store.url.clone();
        for round in 0..20 {
            let name = format!("a/{round}");
            let barrier = std::sync::Barrier::new(16);
            let write = |k: u8| {
                let store = Store::open(&url).unwrap();
                barrier.wait();
                store.put_new(&name, vec![k; 100_000]).unwrap()
            };
            let outcomes: Vec<PutOutcome> = std::thread::scope(|scope| {
                let writers: Vec<_> = (0..16).map(|k| scope.spawn(move || write(k))).collect();
                writers.into_iter().map(|writer| writer.join().unwrap()).collect()
            });
            let winners: Vec<u8> =
                (0..16).filter(|k| outcomes[usize::from(*k)] == PutOutcome::Written).collect();
            assert_eq!(winners.len(), 1);
            assert_eq!(store.get(&name).unwrap().unwrap(), vec![winners[0]; 100_000]);
        }
    }

    #[test]
    fn objects_are_listed_without_those_that_are_being_written() {
        let (folder, store) = store();
        for name in ["a/1", "a/b/2", "c/3"] {
            assert_eq!(store.put_new(name, name.into()).unwrap(), PutOutcome::Written);
        }
        assert_eq!(store.put_new("a/1", b"other".to_vec()).unwrap(), PutOutcome::AlreadyThere);
        std::fs::write(folder.path().join("set/a/4#1"), "half").unwrap();
        let mut found = Vec::new();
        store.list("a", |entry| found.push((entry.name.to_owned(), entry.bytes))).unwrap();
        found.sort();
        assert_eq!(found, [("a/1".to_owned(), 3), ("a/b/2".to_owned(), 5)]);
        assert_eq!((store.has("a/1").unwrap(), store.has("a/4").unwrap()), (true, false));
        assert_eq!(store.get("a/4").unwrap(), None);
        let mut read = Vec::new();
        let names = ["c/3", "a/1"].map(str::to_owned);
        store
            .get_each(names.into_iter(), |name, bytes| {
                read.push((name.to_owned(), bytes));
                Ok(())
            })
            .unwrap();
        assert_eq!(read, [("c/3".to_owned(), b"c/3".to_vec()), ("a/1".to_owned(), b"a/1".to_vec())]);
    }

    #[test]
    fn every_refusal_says_what_to_do() {
        let refused = |text: &str| Error::PermissionDenied { path: "a".into(), source: text.into() };
        let full = std::io::Error::from(std::io::ErrorKind::StorageFull);
        for (error, words) in [
            (refused("<Code>RequestTimeTooSkewed</Code>"), "clock"),
            (refused("<Code>InvalidAccessKeyId</Code>"), "AWS_ACCESS_KEY_ID"),
            (Error::Unauthenticated { path: "a".into(), source: "401".into() }, "credentials"),
            (
                Error::NotFound { path: "a".into(), source: "<Code>NoSuchBucket</Code>".into() },
                "a bucket that exists",
            ),
            (
                Error::Generic { store: "S3", source: "<Code>NoSuchBucket</Code>".into() },
                "a bucket that exists",
            ),
            (Error::Generic { store: "LocalFileSystem", source: Box::new(full) }, "a full disk"),
        ] {
            assert!(!is_absent_object(&error));
            let error = WorkflowError::from(explained(error, "s3://bucket/set/manifest.json"));
            assert!(matches!(error, WorkflowError::BadInput(_)), "{error}");
            assert!(error.to_string().contains(words) && error.to_string().contains("hint: "), "{error}");
        }
        let other = Error::Generic { store: "S3", source: "a broken cable".into() };
        assert!(matches!(WorkflowError::from(explained(other, "s3://bucket")), WorkflowError::Failed(_)));
    }

    #[test]
    fn a_url_is_a_folder_or_a_bucket() {
        let (folder, store) = store();
        store.put_new("a", b"a".to_vec()).unwrap();
        let by_url = Store::open(&format!("file://{}/set", folder.path().display())).unwrap();
        assert_eq!(by_url.get("a").unwrap().unwrap(), b"a");
        let none = folder.path().join("none").display().to_string();
        let file = folder.path().join("set/a").display().to_string();
        for url in ["", "ftp://a/b", "file://a/b", &none, &file] {
            let error = Store::open(url).err().unwrap();
            assert!(crate::is_bad_input(&error), "{url}: {error}");
        }
        #[cfg(not(feature = "cloud"))]
        {
            let error = Store::open("s3://bucket/set").err().unwrap().to_string();
            assert!(error.contains("--features cloud"), "{error}");
        }
    }
}
