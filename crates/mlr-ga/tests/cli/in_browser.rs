//! Pages as headless Chromium shows them.

use std::{fs, path::Path, process::Command};

use serde::Deserialize;

/// Names under which Chromium is installed.
const NAMES: [&str; 4] = [
    "chromium",
    "chromium-browser",
    "google-chrome-stable",
    "google-chrome",
];

/// A page that opens another in a frame and measures what it sees.
const OUTSIDE: &str = include_str!("in_browser.html");

/// Chromium.
pub(crate) struct Browser {
    program: &'static str,
}

/// Which colours a reader prefers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Screen {
    Light,
    Dark,
}

/// What a page looks like.
#[derive(Debug, Deserialize)]
pub(crate) struct Seen {
    pub(crate) content_width: f64,
    pub(crate) pictures: usize,
    pub(crate) unnamed_pictures: usize,
    pub(crate) texts: usize,
    /// Of text to what is behind it, by WCAG 2.
    pub(crate) least_contrast: f64,
    #[allow(dead_code, reason = "shown where an assertion fails")]
    pub(crate) least_contrast_text: String,
    pub(crate) is_dark: bool,
    /// What the browser complained of.
    #[serde(skip)]
    pub(crate) errors: Vec<String>,
}

impl Browser {
    /// The browser of this computer; without one, says so.
    #[allow(clippy::print_stderr, reason = "a test that looks at nothing says why")]
    pub(crate) fn found() -> Option<Self> {
        let runs = |name: &&str| {
            let version = Command::new(name).arg("--version").output();
            version.is_ok_and(|output| output.status.success())
        };
        let program = NAMES.into_iter().find(runs);
        if program.is_none() {
            eprintln!("skipped: there is no Chromium, so no page was looked at");
        }
        program.map(|program| Self { program })
    }

    /// Opens a page in a window so many pixels wide.
    pub(crate) fn open(&self, page: &str, width: u32, screen: Screen) -> Seen {
        let folder = tempfile::tempdir().unwrap();
        let near = folder.path().join("page.html");
        fs::copy(page, &near).unwrap();
        let outside = folder.path().join("outside.html");
        let text = OUTSIDE.replace("PAGE", "page.html");
        fs::write(&outside, text.replace("WIDTH", &width.to_string())).unwrap();
        let output = self
            .headless(folder.path(), screen)
            .arg("--dump-dom")
            .arg("--allow-file-access-from-files")
            .args(["--enable-logging=stderr", "--virtual-time-budget=10000"])
            .arg(&outside)
            .output()
            .unwrap();
        let dom = String::from_utf8(output.stdout).unwrap();
        let messages = String::from_utf8_lossy(&output.stderr);
        let seen = dom.split("<pre id=\"seen\">").nth(1);
        let seen = seen.and_then(|rest| rest.split("</pre>").next());
        let seen = seen.unwrap_or_default().replace("&amp;", "&");
        let mut seen: Seen = serde_json::from_str(&seen)
            .unwrap_or_else(|error| panic!("{error}: {seen:?}\n{messages}"));
        seen.errors = messages
            .lines()
            .filter(|line| line.contains("CONSOLE"))
            .map(String::from)
            .collect();
        assert_eq!(seen.is_dark, screen == Screen::Dark);
        seen
    }

    /// A screenshot of a page, so many pixels wide and high, as PNG.
    pub(crate) fn screenshot(
        &self,
        page: &str,
        [width, height]: [u32; 2],
        screen: Screen,
    ) -> Vec<u8> {
        let folder = tempfile::tempdir().unwrap();
        fs::copy(page, folder.path().join("page.html")).unwrap();
        // A window cannot be as narrow as a phone, a frame can.
        let frame = folder.path().join("frame.html");
        let style = format!("border:0;width:{width}px;height:{height}px");
        let text = format!(
            "<!DOCTYPE html><body style=\"margin:0\"><iframe src=\"page.html\" style=\"{style}\">"
        );
        fs::write(&frame, text).unwrap();
        let picture = folder.path().join("picture.png");
        let output = self
            .headless(folder.path(), screen)
            .arg(format!("--window-size={width},{height}"))
            .arg(format!("--screenshot={}", picture.display()))
            .arg(&frame)
            .output()
            .unwrap();
        fs::read(&picture)
            .unwrap_or_else(|error| panic!("{error}: {}", String::from_utf8_lossy(&output.stderr)))
    }

    /// The browser without a window, its own files in a folder.
    fn headless(&self, folder: &Path, screen: Screen) -> Command {
        let scheme = match screen {
            Screen::Light => 1,
            Screen::Dark => 0,
        };
        let mut command = Command::new(self.program);
        command
            .args(["--headless", "--disable-gpu", "--hide-scrollbars"])
            // Containers lack what the sandbox needs; the page is our own.
            .args(["--no-sandbox", "--disable-dev-shm-usage"])
            .arg(format!("--blink-settings=preferredColorScheme={scheme}"))
            .arg(format!(
                "--user-data-dir={}",
                folder.join("profile").display()
            ));
        command
    }
}
