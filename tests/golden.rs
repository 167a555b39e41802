//! Where golden data are and how they are read.

use std::{
    fs::File,
    io::{BufReader, Read},
    path::{Path, PathBuf},
};

use flate2::bufread::GzDecoder;
use mlr_filter::Axes;
use mlr_imu::Columns;

/// A file below the workspace's `data` folder.
pub fn data(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../data")
        .join(path)
}

/// The columns of the sensor on the shaft in `data/real/mpu6050-encoder`.
///
/// # Panics
/// Never: the mappings are valid.
pub fn shaft_sensor_columns() -> Columns {
    let mut columns = Columns::default();
    for axis in ["x", "y", "z"] {
        for mapping in [
            format!("a{axis}=a2{axis}_g,g"),
            format!("g{axis}=g2{axis}_dps,dps"),
        ] {
            columns.rename(&mapping).expect("a valid mapping");
        }
    }
    columns
}

/// The columns `roll_rad`, `pitch_rad`, `yaw_rad` of a golden file.
///
/// # Panics
/// When the file is not there or not of that form.
pub fn angles(path: &str) -> Axes<Vec<f64>> {
    let [roll, pitch, yaw] = columns(path, ["roll_rad", "pitch_rad", "yaw_rad"]);
    Axes { roll, pitch, yaw }
}

/// The columns of these names of a CSV file below the workspace's `data` folder, plain or
/// gzipped.
///
/// # Panics
/// When the file is not there or not of that form.
pub fn columns<const N: usize>(path: &str, names: [&str; N]) -> [Vec<f64>; N] {
    let path = data(path);
    let file = BufReader::new(File::open(&path).expect("the golden file is in the repository"));
    let text: Box<dyn Read> = if path.extension().is_some_and(|e| e == "gz") {
        Box::new(GzDecoder::new(file))
    } else {
        Box::new(file)
    };
    let mut reader = csv::Reader::from_reader(text);
    let header = reader
        .headers()
        .expect("golden files have a header")
        .clone();
    let places = names.map(|name| {
        let place = header.iter().position(|column| column == name);
        place.expect("golden files have the column")
    });
    let mut columns = names.map(|_| Vec::new());
    for row in reader.records() {
        let row = row.expect("golden files are well-formed");
        for (column, place) in columns.iter_mut().zip(places) {
            column.push(row[place].parse().expect("golden files hold numbers"));
        }
    }
    columns
}
