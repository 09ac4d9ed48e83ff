//! Autosaves: unsaved sessions are kept in files in case the viewer crashes.
//!
//! Each viewer has its own file `unsaved-….toml`, and holds a lock on a file of that name ending in `.lock` while it
//! runs. The system frees the lock however the viewer ends. So a session whose lock is free belongs to a viewer that
//! crashed.

use fovolnet::io::{Error, atomic};
use fovolnet::{Result, Session};
use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

/// Autosaves of all viewers in a folder, and this viewer's own file.
#[derive(Debug)]
pub struct Autosaves {
    folder: Option<PathBuf>,
    own: Option<Place>,
}

/// Session left by a crashed viewer. While this value lives, no other viewer is offered the session.
#[derive(Debug)]
pub struct Crashed {
    session: Session,
    place: Place,
}

/// Result of searching for autosaves.
#[derive(Debug, Default)]
pub struct Found {
    /// Newest session of a crashed viewer.
    pub crashed: Option<Crashed>,
    /// Messages for the user, one line each.
    pub notes: Vec<String>,
}

/// Locked file of a session.
#[derive(Debug)]
struct Place {
    file: PathBuf,
    /// Closing this file frees the lock.
    _lock: File,
}

impl Autosaves {
    /// Keeps autosaves in `folder`; without a folder, keeps nothing.
    pub fn in_folder(folder: Option<PathBuf>) -> Self {
        Self { folder, own: None }
    }

    /// Writes `session` to this viewer's own autosave.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn keep(&mut self, session: &Session) -> Result<()> {
        let Some(folder) = &self.folder else { return Ok(()) };
        let place = match self.own.take() {
            Some(place) => place,
            None => {
                atomic::make_folder(folder)?;
                Place::new(folder)?
            }
        };
        session.write(&self.own.insert(place).file)
    }

    /// Deletes this viewer's autosave, after the session was saved or discarded.
    pub fn forget(&mut self) {
        if let Some(place) = self.own.take() {
            place.remove();
        }
    }

    /// Continues with `crashed`; its file becomes this viewer's own autosave.
    pub fn adopt(&mut self, crashed: Crashed) {
        self.forget();
        self.own = Some(crashed.place);
    }

    /// Finds the newest session of a crashed viewer; others stay for the next start. Unreadable sessions are renamed.
    pub fn find(&self) -> Found {
        let mut found = Found::default();
        let mut others = 0;
        for file in self.files() {
            let place = match Place::of_crashed(&file) {
                Ok(Some(place)) => place,
                Ok(None) => continue,
                Err(error) => {
                    found.notes.push(format!("unsaved work of an earlier run is not offered: {error}"));
                    continue;
                }
            };
            if found.crashed.is_some() {
                others += 1;
                continue;
            }
            match Session::read(&file) {
                Ok(session) => found.crashed = Some(Crashed { session, place }),
                Err(error) => found.notes.push(set_aside(place, &error)),
            }
        }
        if others > 0 {
            found
                .notes
                .push(format!("unsaved work of {others} more that crashed is offered at the next start"));
        }
        found
    }

    /// All autosaves, newest first.
    fn files(&self) -> Vec<PathBuf> {
        let entries = self.folder.iter().filter_map(|folder| fs::read_dir(folder).ok());
        let mut files: Vec<(SystemTime, PathBuf)> = entries
            .flatten()
            .flatten()
            .map(|entry| entry.path())
            .filter(|path| is_unsaved(path))
            .filter_map(|path| Some((path.metadata().ok()?.modified().ok()?, path)))
            .collect();
        files.sort();
        files.into_iter().rev().map(|(_, path)| path).collect()
    }
}

impl Crashed {
    /// The session that was being worked on.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// Deletes the autosave.
    pub fn forget(self) {
        self.place.remove();
    }
}

impl Place {
    /// Creates and locks a new autosave in `folder`.
    fn new(folder: &Path) -> Result<Self> {
        let started = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_nanos();
        let file = folder.join(format!("unsaved-{}-{started}.toml", std::process::id()));
        let path = lock_beside(&file);
        let failed = |e| Error::io("lock", &path, e);
        let lock = File::options().write(true).create_new(true).open(&path).map_err(failed)?;
        // In file systems without locks the session is still kept. Other viewers then report where it lies, but do
        // not offer it.
        let _ = lock.lock();
        Ok(Self { file, _lock: lock })
    }

    /// Locks the autosave `file`; `None` if a running viewer has it.
    fn of_crashed(file: &Path) -> Result<Option<Self>> {
        let path = lock_beside(file);
        let failed = |e| Error::io("lock", &path, e);
        let lock = File::options().write(true).create(true).truncate(false).open(&path).map_err(failed)?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Ok(None),
            Err(TryLockError::Error(error)) => return Err(failed(error).into()),
        }
        let place = Self { file: file.to_owned(), _lock: lock };
        if !file.is_file() {
            // Another viewer restored or deleted it meanwhile.
            place.remove();
            return Ok(None);
        }
        Ok(Some(place))
    }

    /// Deletes the session first and the lock last, since a session without a lock looks like a crash.
    fn remove(self) {
        for path in [&self.file, &lock_beside(&self.file)] {
            // The files may not exist.
            let _ = fs::remove_file(path);
        }
    }
}

fn lock_beside(file: &Path) -> PathBuf {
    file.with_extension("lock")
}

fn is_unsaved(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.starts_with("unsaved") && name.ends_with(".toml")
}

/// Renames the session at `place`, which is unreadable because of `problem`; returns a message for the user.
fn set_aside(place: Place, problem: &fovolnet::Error) -> String {
    let aside = place.file.with_extension("unreadable");
    let moved = fs::read(&place.file)
        .map_err(|e| Error::io("read", &place.file, e))
        .and_then(|bytes| atomic::write_bytes(&aside, &bytes));
    let lies = match moved {
        Ok(()) => {
            place.remove();
            aside
        }
        Err(_) => place.file,
    };
    format!("unsaved work of an earlier run cannot be read: {problem}; it lies in {}", lies.display())
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovolnet::{RenderOverrides, VolumeSettings};
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};
    use std::time::Duration;

    fn session(ambient: f64) -> Session {
        let render = RenderOverrides { ambient: Some(ambient), ..RenderOverrides::default() };
        Session::new("head", VolumeSettings::default(), render).unwrap()
    }

    fn viewer(folder: &Path) -> Autosaves {
        Autosaves::in_folder(Some(folder.to_owned()))
    }

    fn offered(folder: &Path) -> Option<f64> {
        viewer(folder).find().crashed.map(|crashed| crashed.session().render.ambient.unwrap())
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    /// Leaves an autosave like a viewer that was killed `seconds` ago.
    fn crash(folder: &Path, ambient: f64, seconds: u64) {
        let mut autosaves = viewer(folder);
        autosaves.keep(&session(ambient)).unwrap();
        let file = &autosaves.own.as_ref().unwrap().file;
        let then = SystemTime::now() - Duration::from_secs(seconds);
        File::options().write(true).open(file).unwrap().set_modified(then).unwrap();
    }

    #[test]
    fn what_a_living_viewer_keeps_is_offered_to_nobody_until_it_dies() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("new");
        assert!(offered(&folder).is_none());
        let mut living = viewer(&folder);
        living.keep(&session(0.1)).unwrap();
        let mut second = viewer(&folder);
        assert!(second.find().crashed.is_none());
        second.keep(&session(0.2)).unwrap();
        second.forget();
        living.keep(&session(0.3)).unwrap();
        assert!(offered(&folder).is_none());
        drop(living);
        assert_eq!(offered(&folder), Some(0.3));
    }

    #[test]
    fn what_is_forgotten_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let mut autosaves = viewer(folder.path());
        autosaves.keep(&session(0.1)).unwrap();
        autosaves.forget();
        autosaves.forget();
        crash(folder.path(), 0.2, 0);
        viewer(folder.path()).find().crashed.unwrap().forget();
        assert_eq!(names(folder.path()), [""; 0]);
    }

    #[test]
    fn of_several_the_newest_is_offered_first_and_each_to_one_viewer() {
        let folder = tempfile::tempdir().unwrap();
        for (ambient, seconds) in [(0.2, 20), (0.1, 10), (0.3, 30)] {
            crash(folder.path(), ambient, seconds);
        }
        let found = viewer(folder.path()).find();
        assert_eq!(found.crashed.as_ref().unwrap().session(), &session(0.1));
        assert!(found.notes[0].contains("2 more"), "{:?}", found.notes);
        // A viewer that starts while the first session is being offered is offered the second.
        assert_eq!(offered(folder.path()), Some(0.2));
        // The offer was not answered, so it comes again.
        drop(found);
        assert_eq!(offered(folder.path()), Some(0.1));
        for expected in [0.1, 0.2, 0.3] {
            let crashed = viewer(folder.path()).find().crashed.unwrap();
            assert_eq!(crashed.session().render.ambient, Some(expected));
            crashed.forget();
        }
        assert!(offered(folder.path()).is_none());
    }

    #[test]
    fn what_is_gone_on_with_belongs_to_the_viewer_that_does() {
        let folder = tempfile::tempdir().unwrap();
        crash(folder.path(), 0.1, 0);
        let mut second = viewer(folder.path());
        second.keep(&session(0.9)).unwrap();
        let crashed = second.find().crashed.unwrap();
        second.adopt(crashed);
        assert!(offered(folder.path()).is_none());
        second.keep(&session(0.2)).unwrap();
        drop(second);
        assert_eq!(offered(folder.path()), Some(0.2));
        assert_eq!(names(folder.path()).len(), 2, "one session and its lock");
    }

    #[test]
    fn what_cannot_be_read_is_said_and_set_aside() {
        let folder = tempfile::tempdir().unwrap();
        crash(folder.path(), 0.1, 10);
        fs::write(folder.path().join("unsaved.toml"), "volume = [\n").unwrap();
        let found = viewer(folder.path()).find();
        let [note] = &found.notes[..] else { panic!("{:?}", found.notes) };
        assert!(note.contains("line 1") && note.contains("unsaved.unreadable"), "{note}");
        assert!(!note.contains('\n'), "{note}");
        assert_eq!(found.crashed.unwrap().session(), &session(0.1));
        assert_eq!(fs::read(folder.path().join("unsaved.unreadable")).unwrap(), b"volume = [\n");
        assert!(viewer(folder.path()).find().notes.is_empty(), "it is said once");
    }

    const FOLDER: &str = "FOVOLNET_TEST_AUTOSAVES";

    #[test]
    #[ignore = "started by the test below as a process of its own"]
    fn a_viewer_of_its_own() {
        let Some(folder) = std::env::var_os(FOLDER) else { return };
        let mut autosaves = viewer(Path::new(&folder));
        autosaves.keep(&session(0.4)).unwrap();
        println!("kept");
        std::thread::sleep(Duration::from_secs(60));
    }

    #[test]
    fn another_process_keeps_its_work_until_it_is_killed() {
        let folder = tempfile::tempdir().unwrap();
        let mut other = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "session::autosave::tests::a_viewer_of_its_own", "--ignored", "--nocapture"])
            .env(FOLDER, folder.path())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let lines = BufReader::new(other.stdout.take().unwrap()).lines();
        assert!(lines.map_while(|line| line.ok()).any(|line| line.contains("kept")));
        assert!(offered(folder.path()).is_none());
        other.kill().unwrap();
        other.wait().unwrap();
        assert_eq!(offered(folder.path()), Some(0.4));
    }
}
