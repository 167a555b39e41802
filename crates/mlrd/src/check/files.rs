//! What the daemon reads and writes on this computer.

use std::{io, path::Path, sync::Arc};

use mlr_ga::atlas::Atlas;
use mlr_model::{Gait, Robot};
use rustix::fs::statvfs;

use super::findings::Findings;
use crate::{
    Settings,
    learning::SavedCalibrations,
    recorder,
    saved_state::{SavedState, StateFile},
};

pub(super) fn model(settings: &Settings, findings: &mut Findings) -> Option<(Arc<Robot>, Gait)> {
    match settings.model() {
        Ok((_, robot, gait)) => {
            let named = |file: &Option<std::path::PathBuf>| match file {
                Some(path) => path.display().to_string(),
                None => "embedded".into(),
            };
            findings.ok(
                "robot, gait",
                format!(
                    "{} with {} legs ({}) walks its gait ({})",
                    robot.name(),
                    robot.layout().legs(),
                    named(&settings.robot),
                    named(&settings.gait)
                ),
            );
            Some((Arc::new(robot), gait))
        }
        Err(error) => {
            let cure = "correct the file, or leave out robot and gait for the embedded JetHexa and \
                        its tripod";
            findings.failed("robot, gait", format!("{error:#}"), cure);
            None
        }
    }
}

pub(super) fn state(settings: &Settings, findings: &mut Findings) {
    const CHECK: &str = "state folder";
    let Some(dir) = &settings.state_dir else {
        let found = "none: nothing is remembered beyond the daemon's end, and no recovery gait is \
                     offered";
        findings.warning(CHECK, found, "--state-dir /var/lib/mlrd");
        return;
    };
    if let Err(error) = writable(dir) {
        let shown = dir.display();
        let cure = format!(
            "sudo chown -R $USER {shown} (the service makes its own folder: where {shown} is the \
             service's, sudo mlrd check looks into it)"
        );
        findings.failed(CHECK, format!("{shown} cannot be written: {error}"), cure);
        return;
    }
    let saved = read::<SavedState>(dir);
    match saved {
        Ok(_) if dir.is_dir() => findings.ok(CHECK, format!("{} can be written", dir.display())),
        Ok(_) => findings.ok(CHECK, format!("{} can be made", dir.display())),
        Err(error) => findings.warning(CHECK, error, SET_ASIDE),
    }
}

const SET_ASIDE: &str = "nothing: mlrd sets the file aside when it starts, and begins anew";

pub(super) fn calibration(settings: &Settings, robot: &Arc<Robot>, findings: &mut Findings) {
    const CHECK: &str = "calibration";
    let Some(dir) = &settings.state_dir else {
        return;
    };
    let calibrations = read::<SavedCalibrations>(dir).and_then(|saved| {
        let calibrations = saved.calibrations(Arc::clone(robot));
        calibrations.map_err(|error| format!("{}: {error}", dir.display()))
    });
    match calibrations.map(|calibrations| calibrations.known()) {
        Ok(Some(known)) => findings.ok(
            CHECK,
            format!("learned of this robot from {} walks, {}", known.walks, known.time),
        ),
        Ok(None) => findings.ok(CHECK, "none yet: the robot is as described"),
        Err(error) => findings.warning(
            CHECK,
            error,
            "start mlrd with the robot's description that it was learned with; otherwise mlrd sets it \
             aside and learns anew",
        ),
    }
}

/// What is kept in a directory.
fn read<T: crate::saved_state::Kept>(dir: &Path) -> Result<T, String> {
    let named = |error: &dyn std::fmt::Display| format!("{}: {error}", dir.join(T::NAME).display());
    let read = StateFile::<T>::at(dir).read();
    read.map_err(|error| named(&error))?
        .map_err(|error| named(&error))
}

pub(super) fn atlas(settings: &Settings, robot: &Robot, gait: &Gait, findings: &mut Findings) {
    const CHECK: &str = "atlas";
    let Some(path) = &settings.atlas else {
        findings.ok(CHECK, "none: every identification simulates its own walks");
        return;
    };
    match Atlas::open(path, robot, gait, &settings.identification) {
        Ok(_) => findings.ok(CHECK, format!("{} fits robot and gait", path.display())),
        Err(error) => {
            let option = |name: &str, file: &Option<std::path::PathBuf>| match file {
                Some(file) => format!(" --{name} {}", file.display()),
                None => String::new(),
            };
            let cure = format!(
                "with this version of mlr, on any computer: mlr-ga atlas build{}{} -o {}; or leave out \
                 atlas",
                option("robot", &settings.robot),
                option("gait", &settings.gait),
                path.display()
            );
            findings.failed(CHECK, format!("{:#}", anyhow::Error::from(error)), cure);
        }
    }
}

pub(super) fn recordings(settings: &Settings, findings: &mut Findings) {
    const CHECK: &str = "recordings";
    let record = &settings.record;
    let Some(dir) = &record.dir else {
        findings.ok(CHECK, "none are made");
        return;
    };
    let shown = dir.display();
    if let Err(error) = writable(dir) {
        let cure = format!("sudo mkdir -p {shown} && sudo chown -R $USER {shown}");
        findings.failed(CHECK, format!("{shown} cannot be written: {error}"), cure);
        return;
    }
    let held = recorder::recordings(dir).unwrap_or_default();
    let held_mb = held.iter().map(|(_, bytes)| *bytes as f64).sum::<f64>() / 1e6;
    let free_mb = match statvfs(nearest(dir)) {
        Ok(disk) => disk.f_bavail as f64 * disk.f_frsize as f64 / 1e6,
        Err(error) => {
            let cure = "use a folder on a disk that tells how much room it has";
            findings.warning(CHECK, format!("{shown}: {error}"), cure);
            return;
        }
    };
    let found = format!(
        "{shown}: {free_mb:.0} MB free, {held_mb:.0} of {:.0} MB recorded",
        record.total_mb
    );
    if free_mb + held_mb >= record.total_mb {
        findings.ok(CHECK, found);
        return;
    }
    // A tenth is left for others.
    let affordable_mb = (0.9 * (free_mb + held_mb)).floor();
    let cure = match affordable_mb >= record.file_mb {
        true => format!("set total_mb = {affordable_mb:.1} in [record], or free the rest"),
        false => "free room on the disk, or record to another one".into(),
    };
    match free_mb < record.file_mb {
        true => findings.failed(CHECK, found, cure),
        false => findings.warning(CHECK, found, cure),
    }
}

/// Whether files can be written to a directory that is made if need be. Nothing is left behind.
fn writable(dir: &Path) -> io::Result<()> {
    if dir.exists() && !dir.is_dir() {
        return Err(io::ErrorKind::NotADirectory.into());
    }
    tempfile::tempfile_in(nearest(dir)).map(drop)
}

/// The directory itself, or the one that it would be made in.
fn nearest(dir: &Path) -> &Path {
    let there = dir.ancestors().find(|ancestor| ancestor.exists());
    there.unwrap_or(Path::new("."))
}
