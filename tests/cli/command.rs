//! Running the command in a folder of its own.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;

/// A small specimen that packs in a moment: 40 mm, 6 to 12 mm, 0.3.
pub(crate) const SMALL: &str = "fraction = 0.3\nspecimen = { kind = 'cube', side_mm = 40 }\n\
[grading]\nd_min_mm = 6\nd_max_mm = 12\nclasses_mm = [6, 9, 12]\n";

/// An empty folder, and the command in it.
pub(crate) struct Folder(TempDir);

/// Refuses a page that loads anything or shows a value that is not finite. Pictures and the block to turn are left out: their
/// data may have any letters.
pub(crate) fn assert_whole(page: &str) {
    assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>\n"));
    let words = page.split_inclusive(|c: char| !(c.is_ascii_alphanumeric() || "+/=".contains(c)));
    let text: String = words.filter(|word| word.len() < 100).collect();
    for foreign in ["http", "@import", "<link", "src=\"/", "NaN", "inf\"", "Infinity"] {
        assert!(!text.contains(foreign), "the page has {foreign:?}");
    }
}

/// What a run left behind.
pub(crate) struct Run {
    pub(crate) code: i32,
    pub(crate) stdout: Vec<u8>,
    pub(crate) stderr: String,
}

impl Folder {
    pub(crate) fn new() -> Self {
        Self(TempDir::new().expect("a temporary folder"))
    }

    /// A folder with `small.toml`, and `small.json` packed from it.
    pub(crate) fn with_model() -> Self {
        let folder = Self::with_spec();
        let run = folder.run(&["pack", "small.toml", "-o", "small.json"]);
        assert_eq!(run.code, 0, "{}", run.stderr);
        folder
    }

    /// A folder with `small.toml`.
    pub(crate) fn with_spec() -> Self {
        let folder = Self::new();
        folder.write("small.toml", SMALL);
        folder
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).expect(name);
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// All names in the folder, sorted.
    pub(crate) fn names(&self) -> Vec<String> {
        names_in(self.0.path())
    }

    /// All names in a folder of it, sorted.
    pub(crate) fn names_in(&self, folder: &str) -> Vec<String> {
        names_in(&self.path(folder))
    }

    pub(crate) fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_mesocrete"));
        command.args(args).current_dir(self.0.path()).env("COLUMNS", "100").env_remove("RUST_BACKTRACE");
        command
    }

    pub(crate) fn run(&self, args: &[&str]) -> Run {
        self.run_with_input(args, b"")
    }

    /// Runs the command with `input` on its standard input.
    pub(crate) fn run_with_input(&self, args: &[&str], input: &[u8]) -> Run {
        let mut command = self.command(args);
        let mut child =
            command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
        let mut stdin = child.stdin.take().expect("a pipe");
        let input = input.to_vec();
        // A command that does not read its input closes the pipe.
        let writer = std::thread::spawn(move || drop(stdin.write_all(&input)));
        let output = child.wait_with_output().expect("it ends");
        writer.join().expect("the writer ends");
        Run {
            code: output.status.code().expect("no signal ended it"),
            stdout: output.stdout,
            stderr: String::from_utf8(output.stderr).expect("messages are UTF-8"),
        }
    }
}

impl Run {
    pub(crate) fn stdout(&self) -> &str {
        std::str::from_utf8(&self.stdout).expect("text")
    }
}

fn names_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("the folder");
    let mut names: Vec<String> =
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}
