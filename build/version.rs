//! The build script of both programs: `MLR_VERSION` is the version, with the commit in brackets in a
//! release build from a checkout.
//!
//! A packager who builds elsewhere names the commit with `MLR_COMMIT`. Other builds name none: they
//! would have to be made anew after every commit.

#![allow(
    clippy::print_stdout,
    reason = "a build script speaks to Cargo on stdout"
)]

use std::{env, path::PathBuf, process::Command};

fn main() {
    println!("cargo::rerun-if-changed=../../build/version.rs");
    println!("cargo::rerun-if-env-changed=MLR_COMMIT");
    let version = env::var("CARGO_PKG_VERSION").unwrap_or_default();
    let named = env::var("MLR_COMMIT")
        .ok()
        .filter(|commit| !commit.is_empty());
    let is_release = env::var("PROFILE").is_ok_and(|profile| profile == "release");
    let commit = named.or_else(|| is_release.then(checked_out).flatten());
    match commit {
        Some(commit) => println!("cargo::rustc-env=MLR_VERSION={version} ({commit})"),
        None => println!("cargo::rustc-env=MLR_VERSION={version}"),
    }
}

/// The commit that is checked out. Cargo looks again when another one is.
fn checked_out() -> Option<String> {
    // A checkout of something else that this was unpacked in says nothing about it.
    git(&["ls-files", "--error-unmatch", "Cargo.toml"])?;
    for name in ["HEAD", "logs/HEAD"] {
        let path = PathBuf::from(git(&["rev-parse", "--git-path", name])?);
        if let Ok(path) = path.canonicalize() {
            println!("cargo::rerun-if-changed={}", path.display());
        }
    }
    git(&["rev-parse", "--short=12", "HEAD"])
}

/// One line that git prints; `None` outside a checkout, or without git.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let line = String::from_utf8(output.stdout).ok()?.trim().to_string();
    (output.status.success() && !line.is_empty()).then_some(line)
}
