//! Whether the source of the bytes opens.

use std::{fs, os::unix::fs::FileTypeExt, path::Path};

use rustix::fs::{Access, access};

use super::findings::Findings;
use crate::{Settings, source::Reading};

const CHECK: &str = "port";

/// Opens the source; what keeps it from being opened is found.
pub(super) fn open(settings: &Settings, findings: &mut Findings) -> Option<Box<dyn Reading>> {
    let source = match settings.source() {
        Ok(source) => source,
        Err(error) => {
            let cure = format!("--port DEVICE, --i2c BUS or --stdin. {}", ports_here());
            findings.failed(CHECK, error.to_string(), cure);
            return None;
        }
    };
    let (device, group) = match (&settings.port, &settings.i2c) {
        (Some(port), _) => (Some(Path::new(port)), "dialout"),
        (None, Some(bus)) => (Some(bus.as_path()), "i2c"),
        (None, None) => (None, ""),
    };
    if let Some(device) = device
        && let Err((found, cure)) = usable(device, group)
    {
        findings.failed(CHECK, found, cure);
        return None;
    }
    match source.open() {
        Ok(open) => {
            findings.ok(CHECK, format!("{source} opens"));
            Some(open)
        }
        Err(reason) => {
            findings.failed(CHECK, reason, cure(settings));
            None
        }
    }
}

/// Whether there is such a device and this user may use it; or what is wrong, and its cure.
fn usable(device: &Path, group: &str) -> Result<(), (String, String)> {
    let shown = device.display();
    let kind = match fs::metadata(device) {
        Ok(metadata) => metadata.file_type(),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            let cure = format!("plug it in, or name another one. {}", ports_here());
            return Err((format!("{shown} does not exist"), cure));
        }
        Err(error) => {
            let cure = format!("ls -l {shown} tells what it is");
            return Err((format!("{shown}: {error}"), cure));
        }
    };
    if !kind.is_char_device() {
        return Err((format!("{shown} is no device"), ports_here()));
    }
    access(device, Access::READ_OK | Access::WRITE_OK).map_err(|_| {
        let cure = format!(
            "sudo usermod -aG {group} $USER, log out and in again (ls -l {shown} shows the group)"
        );
        (
            format!("{shown}: this user may not read and write it"),
            cure,
        )
    })
}

/// What to do about a device that is there, may be used, and does not open.
fn cure(settings: &Settings) -> String {
    match (&settings.port, &settings.i2c) {
        (Some(port), _) => format!(
            "sudo fuser -v {port} shows which program holds it: sudo systemctl stop mlrd ends the \
             service, sudo systemctl disable --now nvgetty the serial console"
        ),
        (None, Some(bus)) => {
            let number = bus.display().to_string();
            let number = number.rsplit('-').next().unwrap_or("1").to_owned();
            format!(
                "sudo i2cdetect -y {number} must show 68: check VCC, GND, SDA, SCL, and that AD0 is low; \
                 UU there means that another driver holds the chip"
            )
        }
        (None, None) => "hand samples on: DRIVER | mlrd check --stdin".into(),
    }
}

/// The serial ports and I²C buses of this computer, in words.
fn ports_here() -> String {
    const KINDS: [&str; 5] = ["ttyTHS", "ttyUSB", "ttyACM", "ttyAMA", "i2c-"];
    let entries = fs::read_dir("/dev").into_iter().flatten().flatten();
    let mut here: Vec<String> = entries
        .filter_map(|entry| entry.file_name().into_string().ok())
        .filter(|name| KINDS.iter().any(|kind| name.starts_with(kind)))
        .map(|name| format!("/dev/{name}"))
        .collect();
    here.sort();
    match here.is_empty() {
        true => "This computer has none now: dmesg | tail tells whether one was plugged in".into(),
        false => format!("This computer has {}", here.join(", ")),
    }
}
