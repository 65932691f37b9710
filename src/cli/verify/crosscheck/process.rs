//! A process that is watched: it is this program again, and says lines of JSON.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::gpu::check::conform::Conformance;
use crate::gpu::check::crosscheck::{Agreement, Status};
use crate::gpu::check::stress::Stressed;

/// What a worker says.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Line {
    /// The device is open.
    Opened,
    /// It cannot be opened.
    Refused(String),
    /// Submissions come back.
    Alive,
    /// A row is finished.
    Row(Box<Agreement>),
    /// The litmus pixels of a method are finished.
    Litmus(Box<Litmus>),
}

/// What `--litmus` prints.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Litmus {
    pub(super) conformance: Vec<Conformance>,
    pub(super) stress: Vec<Stressed>,
}

/// Why there is nothing more.
pub(super) type Silence = (Status, String);

/// It.
pub(super) struct Process {
    child: Child,
    lines: Receiver<Line>,
    complaints: Option<JoinHandle<Option<String>>>,
}

impl Process {
    /// Start one with these arguments.
    ///
    /// # Errors
    /// It cannot be started.
    pub(super) fn start(arguments: &[String]) -> Result<Self> {
        let problem = |error: std::io::Error| {
            let help = "--in-process does without processes of their own";
            Error::new("fragloom", format!("cannot be started again: {error}; {help}"))
        };
        let program = std::env::current_exe().map_err(problem)?;
        let mut child = Command::new(program)
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(problem)?;
        let (said, lines) = channel();
        let (out, err) = (child.stdout.take(), child.stderr.take());
        let complaints = thread::spawn(move || {
            // Drivers say much that is of no interest, unless it was their last word.
            let lines = err.into_iter().flat_map(|err| BufReader::new(err).lines());
            lines.map_while(std::result::Result::ok).filter(|line| !line.trim().is_empty()).last()
        });
        thread::spawn(move || {
            let Some(out) = out else { return };
            let lines = BufReader::new(out).lines().map_while(std::result::Result::ok);
            // What is no line of ours is a driver's.
            let lines = lines.filter_map(|line| serde_json::from_str(&line).ok());
            for line in lines {
                if said.send(line).is_err() {
                    return;
                }
            }
        });
        Ok(Self { child, lines, complaints: Some(complaints) })
    }

    /// What it says next; how it ended, if it does not say anything for so long.
    pub(super) fn next(&mut self, silence: Duration) -> std::result::Result<Line, Silence> {
        self.lines.recv_timeout(silence).map_err(|error| match error {
            RecvTimeoutError::Timeout => {
                let seconds = silence.as_secs();
                let why = format!("no sign of life for {seconds} s; its process was ended");
                (Status::Hung, why)
            }
            RecvTimeoutError::Disconnected => {
                (Status::Failed, format!("its process ended early: {}", self.end()))
            }
        })
    }

    /// How it ended, in words, with the last that it complained of.
    fn end(&mut self) -> String {
        for _ in 0..20 {
            if let Ok(Some(status)) = self.child.try_wait() {
                let last = self.complaints.take().and_then(|told| told.join().ok().flatten());
                return match last {
                    Some(last) => format!("{status}: {last}"),
                    None => status.to_string(),
                };
            }
            thread::sleep(Duration::from_millis(100));
        }
        "it is still there".to_owned()
    }
}

impl Drop for Process {
    /// A process that a driver holds may not even be killed: it is not waited for.
    fn drop(&mut self) {
        if let Ok(None) = self.child.try_wait() {
            let _ = self.child.kill();
            self.end();
        }
    }
}
