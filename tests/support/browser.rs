//! A headless Chromium that a test drives with real clicks and keys, over its debugging pipe: JSON messages that end in a
//! zero byte, on file descriptors 3 and 4.

#![expect(clippy::unwrap_used, reason = "a test whose browser fails, fails")]

use std::env;
use std::io::{BufRead, BufReader, Cursor, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Duration;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use fragloom::image::{Image, png};
use serde_json::{Value, json};
use tempfile::TempDir;

/// The variable with the browser's name: then tests fail without it, and are not skipped.
const VARIABLE: &str = "FRAGLOOM_BROWSER";

/// How long anything may take on a busy machine.
const PATIENCE: Duration = Duration::from_secs(180);

/// Modifiers of keys.
pub(crate) const SHIFT: u32 = 8;

/// A browser with one page.
pub(crate) struct Browser {
    child: Child,
    to: ChildStdin,
    from: Receiver<Value>,
    session: Option<String>,
    calls: u64,
    /// All that was reported, oldest first.
    events: Vec<Value>,
    _profile: TempDir,
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.to.write_all(b"{\"id\":0,\"method\":\"Browser.close\"}\0");
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The browser's command, or `None` where there is none and none is demanded.
fn command() -> Option<String> {
    if let Some(name) = env::var(VARIABLE).ok().filter(|name| !name.is_empty()) {
        return Some(name);
    }
    let paths = env::var_os("PATH")?;
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let there = |name: &&str| env::split_paths(&paths).any(|folder| folder.join(name).is_file());
    names.iter().find(|name| there(name)).map(|name| (*name).to_owned())
}

impl Browser {
    /// Start one, or say that the test is skipped.
    pub(crate) fn start() -> Option<Self> {
        let Some(command) = command() else {
            eprintln!("skipped: no Chromium is in PATH; set {VARIABLE} to its name");
            return None;
        };
        let profile = tempfile::tempdir().unwrap();
        let mut child = Command::new("sh")
            .args(["-c", "exec \"$0\" \"$@\" 3<&0 4>&1 </dev/null >/dev/null", &command])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .args(["--headless=new", "--remote-debugging-pipe", "--no-sandbox", "--disable-gpu"])
            .args(["--disable-dev-shm-usage", "--no-first-run", "--disable-background-networking"])
            .args(["--disable-component-update", "--disable-sync", "--window-size=1400,1000"])
            .args(["--force-device-scale-factor=1", "--hide-scrollbars", "about:blank"])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let to = child.stdin.take().unwrap();
        let mut pipe = BufReader::new(child.stdout.take().unwrap());
        let (sender, from) = channel();
        thread::spawn(move || {
            loop {
                let mut bytes = Vec::new();
                match pipe.read_until(0, &mut bytes) {
                    Ok(n) if n > 0 => bytes.pop(),
                    _ => return,
                };
                let Ok(message) = serde_json::from_slice(&bytes) else { return };
                if sender.send(message).is_err() {
                    return;
                }
            }
        });
        let (session, calls, events) = (None, 0, Vec::new());
        let mut browser = Self { child, to, from, session, calls, events, _profile: profile };
        let target = browser.call("Target.createTarget", &json!({ "url": "about:blank" }));
        let attach = json!({ "targetId": target["targetId"], "flatten": true });
        let session = browser.call("Target.attachToTarget", &attach);
        browser.session = Some(session["sessionId"].as_str().unwrap().to_owned());
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.call(&format!("{domain}.enable"), &json!({}));
        }
        Some(browser)
    }

    /// Call a method of the protocol.
    #[track_caller]
    pub(crate) fn call(&mut self, method: &str, params: &Value) -> Value {
        self.calls += 1;
        let mut message = json!({ "id": self.calls, "method": method, "params": params });
        if let Some(session) = &self.session {
            message["sessionId"] = json!(session);
        }
        let mut bytes = serde_json::to_vec(&message).unwrap();
        bytes.push(0);
        self.to.write_all(&bytes).unwrap();
        loop {
            let answer = self.from.recv_timeout(PATIENCE).expect("the browser answers");
            if answer["id"] != json!(self.calls) {
                self.events.push(answer);
                continue;
            }
            assert!(answer.get("error").is_none(), "{method}: {}", answer["error"]);
            return answer["result"].clone();
        }
    }

    /// Open a file, and wait until it says that it is ready.
    pub(crate) fn open(&mut self, path: &Path) {
        let url = format!("file://{}", path.display());
        let done = self.call("Page.navigate", &json!({ "url": url }));
        assert!(done.get("errorText").is_none(), "{done}");
        self.wait("document.documentElement?.dataset.ready === 'yes'");
    }

    /// The value of an expression in the page.
    #[track_caller]
    pub(crate) fn eval(&mut self, expression: &str) -> Value {
        let params =
            json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let done = self.call("Runtime.evaluate", &params);
        assert!(done.get("exceptionDetails").is_none(), "{expression}: {done}");
        done["result"]["value"].clone()
    }

    /// The text that an element shows.
    #[track_caller]
    pub(crate) fn text(&mut self, selector: &str) -> String {
        let expression = format!("document.querySelector({}).innerText", json!(selector));
        self.eval(&expression).as_str().unwrap().to_owned()
    }

    /// Wait until an expression is true.
    #[track_caller]
    pub(crate) fn wait(&mut self, expression: &str) {
        let tries = PATIENCE.as_millis() / 50;
        for _ in 0..tries {
            if self.eval(expression) == json!(true) {
                return;
            }
            thread::sleep(Duration::from_millis(50));
        }
        panic!("not within {PATIENCE:?}: {expression}");
    }

    /// Where a part of an element is on the screen, after it is scrolled into view; `part` is its share of the width and
    /// height.
    #[track_caller]
    pub(crate) fn place(&mut self, selector: &str, part: [f64; 2]) -> [f64; 2] {
        let expression = format!(
            "(() => {{ const e = document.querySelector({}); e.scrollIntoView({{ block: 'center' }});
             const b = e.getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; }})()",
            json!(selector)
        );
        let found = self.eval(&expression);
        let number = |i: usize| found[i].as_f64().unwrap();
        [number(0) + part[0] * number(2), number(1) + part[1] * number(3)]
    }

    fn mouse(&mut self, kind: &str, [x, y]: [f64; 2], pressed: bool) {
        let buttons = u32::from(pressed);
        let button = if kind == "mouseMoved" && !pressed { "none" } else { "left" };
        let params = json!({
            "type": kind, "x": x, "y": y, "button": button, "buttons": buttons, "clickCount": 1,
        });
        self.call("Input.dispatchMouseEvent", &params);
    }

    /// Click on a part of an element.
    #[track_caller]
    pub(crate) fn click_at(&mut self, selector: &str, part: [f64; 2]) {
        let at = self.place(selector, part);
        self.mouse("mouseMoved", at, false);
        self.mouse("mousePressed", at, true);
        self.mouse("mouseReleased", at, false);
    }

    /// Click in the middle of an element.
    #[track_caller]
    pub(crate) fn click(&mut self, selector: &str) {
        self.click_at(selector, [0.5, 0.5]);
    }

    /// Press on the middle of an element, and move by so many pixels before letting go.
    #[track_caller]
    pub(crate) fn drag(&mut self, selector: &str, by: [f64; 2]) {
        let [x, y] = self.place(selector, [0.5, 0.5]);
        self.mouse("mouseMoved", [x, y], false);
        self.mouse("mousePressed", [x, y], true);
        for step in 1..=4 {
            let part = f64::from(step) / 4.0;
            self.mouse("mouseMoved", [x + by[0] * part, y + by[1] * part], true);
        }
        self.mouse("mouseReleased", [x + by[0], y + by[1]], false);
    }

    /// Press a key: a character, or a name such as `ArrowLeft`.
    pub(crate) fn key(&mut self, key: &str, modifiers: u32) {
        let code = match key {
            "Enter" => 13,
            "Tab" => 9,
            "Escape" => 27,
            " " => 32,
            "End" => 35,
            "Home" => 36,
            "ArrowLeft" => 37,
            "ArrowUp" => 38,
            "ArrowRight" => 39,
            "ArrowDown" => 40,
            _ => 0,
        };
        let mut params = json!({
            "type": "keyDown", "key": key, "windowsVirtualKeyCode": code, "modifiers": modifiers,
        });
        if key.chars().count() == 1 {
            params["text"] = json!(key);
        } else if key == "Enter" {
            params["text"] = json!("\r");
        } else {
            params["code"] = json!(key);
        }
        self.call("Input.dispatchKeyEvent", &params);
        params["type"] = json!("keyUp");
        self.call("Input.dispatchKeyEvent", &params);
    }

    /// Show the page as on `screen` or in `print`, in the `light` or `dark` scheme.
    pub(crate) fn emulate(&mut self, media: &str, scheme: &str) {
        let features = json!([{ "name": "prefers-color-scheme", "value": scheme }]);
        let params = json!({ "media": media, "features": features });
        self.call("Emulation.setEmulatedMedia", &params);
    }

    /// What the window shows.
    pub(crate) fn screenshot(&mut self) -> Image {
        let shot = self.call("Page.captureScreenshot", &json!({ "format": "png" }));
        let bytes = STANDARD.decode(shot["data"].as_str().unwrap()).unwrap();
        png::decode(Cursor::new(bytes), 1 << 14).unwrap()
    }

    /// What went wrong so far: exceptions, messages on the console, and requests to anything but the page's own file and
    /// what it holds itself.
    pub(crate) fn complaints(&mut self) -> Vec<String> {
        self.eval("0");
        let own = |url: &str| {
            ["file://", "data:", "blob:", "about:"].iter().any(|start| url.starts_with(start))
        };
        let wrong = |event: &&Value| match event["method"].as_str().unwrap_or_default() {
            "Runtime.exceptionThrown" | "Runtime.consoleAPICalled" | "Log.entryAdded" => true,
            "Network.requestWillBeSent" => {
                !own(event["params"]["request"]["url"].as_str().unwrap_or_default())
            }
            _ => false,
        };
        self.events.iter().filter(wrong).map(ToString::to_string).collect()
    }
}
