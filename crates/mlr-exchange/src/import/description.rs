//! The description in TOML.

use mlr_model::{ContactShape, JointAxis, Servo};
use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, Value, value};

use super::leg::{ImportedLeg, ImportedLink};

/// Everything that a description says.
pub(super) struct Description<'a> {
    pub(super) name: &'a str,
    pub(super) size_m: [f64; 3],
    pub(super) mass_kg: f64,
    pub(super) center_of_mass_m: [f64; 3],
    pub(super) inertia_kg_m2: [f64; 3],
    pub(super) servo: Servo,
    pub(super) legs: &'a [ImportedLeg],
    /// Of each leg, each joint.
    pub(super) postures_rad: Vec<Vec<f64>>,
    pub(super) nominal_feet_m: Vec<[f64; 2]>,
    pub(super) clock: f64,
    pub(super) mounting_deg: [f64; 3],
    pub(super) gyro_scale: f64,
    /// Lines of the comment at the top.
    pub(super) comment: Vec<String>,
}

impl Description<'_> {
    pub(super) fn to_toml(&self) -> String {
        let mut file = DocumentMut::new();
        file["name"] = value(self.name);
        let mut body = Table::new();
        body["size_m"] = numbers(&self.size_m);
        body["mass_kg"] = number(self.mass_kg);
        body["center_of_mass_m"] = numbers(&self.center_of_mass_m);
        body["inertia_kg_m2"] = numbers(&self.inertia_kg_m2);
        file["body"] = Item::Table(body);
        file["servo"] = Item::Table(servo(&self.servo));
        let mut tables: Vec<LinkTable> = Vec::new();
        let mut legs = ArrayOfTables::new();
        for (index, leg) in self.legs.iter().enumerate() {
            legs.push(self.leg(index, leg, &mut tables));
        }
        let mut links = Table::new();
        links.set_implicit(true);
        for LinkTable { name, table, .. } in tables {
            links[&name] = Item::Table(table);
        }
        file["links"] = Item::Table(links);
        file["legs"] = Item::ArrayOfTables(legs);
        if self.mounting_deg != [0.0; 3] || self.gyro_scale != 1.0 {
            let mut imu = Table::new();
            imu["mounting_deg"] = numbers(&self.mounting_deg);
            imu["gyro_scale"] = number(self.gyro_scale);
            file["imu"] = Item::Table(imu);
        }
        if self.clock != 1.0 {
            let mut controller = Table::new();
            controller["clock"] = number(self.clock);
            file["controller"] = Item::Table(controller);
        }
        let comment = self.comment.iter().map(|line| match line.is_empty() {
            true => "#\n".to_string(),
            false => format!("# {}\n", line.replace(|c: char| c.is_control(), " ")),
        });
        format!("{}\n{file}", comment.collect::<String>())
    }

    fn leg(&self, index: usize, leg: &ImportedLeg, tables: &mut Vec<LinkTable>) -> Table {
        let mut names = Array::new();
        for (number, link) in leg.links.iter().enumerate() {
            let table = self.link(index, number, leg, link);
            let text = table.to_string();
            // Links of the same name and numbers are one table.
            let plain = leg.plain_name(link);
            let same = |other: &&LinkTable| other.plain == plain && other.text == text;
            let known = tables.iter().find(same).map(|known| known.name.clone());
            let name = known.unwrap_or_else(|| {
                let taken = |name: &str| tables.iter().any(|other| other.name == name);
                let mut name = plain.clone();
                let mut count = index + 1;
                while taken(&name) {
                    name = format!("{plain}_leg{count}");
                    count += self.legs.len();
                }
                tables.push(LinkTable {
                    name: name.clone(),
                    plain,
                    text,
                    table,
                });
                name
            });
            names.push(name);
        }
        let mut table = Table::new();
        table["name"] = value(leg.name.as_str());
        table["hip_m"] = numbers(leg.chain.hip_m.coords.as_slice());
        table["hip_yaw_deg"] = number(leg.chain.hip_yaw_rad.to_degrees());
        table["nominal_foot_m"] = numbers(&self.nominal_feet_m[index]);
        table["links"] = value(names);
        let zeros = leg
            .links
            .iter()
            .map(|link| link.own.map_or(0.0, |(_, _, zero)| zero));
        let zeros: Vec<f64> = zeros.collect();
        if zeros.iter().any(|zero| *zero != 0.0) {
            table["joint_zeros_rad"] = numbers(&zeros);
        }
        table
    }

    fn link(
        &self,
        leg_index: usize,
        index: usize,
        leg: &ImportedLeg,
        link: &ImportedLink,
    ) -> Table {
        let fitted = &leg.chain.links[index];
        let lifts = leg.chain.links[..=index].iter();
        let lifts = lifts.filter(|one| one.axis == JointAxis::Lift).count();
        let is_first_lift = lifts == 1 && fitted.axis == JointAxis::Lift;
        let locked_deg = match link.own {
            Some((_, locked_deg, _)) => locked_deg,
            None if is_first_lift => CLEAR_DEG,
            None => 0.0,
        };
        let mut table = Table::new();
        table["joint"] = value(match fitted.axis {
            JointAxis::Yaw => "yaw",
            JointAxis::Lift => "lift",
        });
        table["length_m"] = number(fitted.length_m);
        table["mass_kg"] = number(link.mass_kg);
        table["center_of_mass_m"] = number(link.center_of_mass_m);
        table["inertia_kg_m2"] = numbers(&link.inertia_kg_m2);
        table["posture_deg"] = number(self.postures_rad[leg_index][index].to_degrees());
        table["locked_deg"] = number(locked_deg);
        let shape = link.contact.map(|contact| match contact {
            ContactShape::Capsule { radius_m } => ("capsule", radius_m),
            ContactShape::Foot { radius_m } => ("foot", radius_m),
        });
        if let Some((shape, radius_m)) = shape {
            let mut contact = InlineTable::new();
            contact.insert("shape", shape.into());
            contact.insert("radius_m", rounded(radius_m).into());
            table["contact"] = value(contact);
        }
        table
    }
}

/// A section of links that are the same.
struct LinkTable {
    name: String,
    /// The name without what makes it the only one.
    plain: String,
    text: String,
    table: Table,
}

/// Where the first link that can be lifted is locked, clear of the ground: the JetHexa's.
const CLEAR_DEG: f64 = 75.0;

fn servo(servo: &Servo) -> Table {
    let mut table = Table::new();
    let fields = serde_json::to_value(servo).unwrap_or_default();
    let scalar = |item: &serde_json::Value| match item {
        serde_json::Value::Bool(flag) => Some(value(*flag)),
        other => other.as_f64().map(number),
    };
    for (key, field) in fields.as_object().into_iter().flatten() {
        if let Some(item) = scalar(field) {
            table[key] = item;
        }
    }
    if servo.drive != Default::default() {
        let mut drive = Table::new();
        for (key, field) in fields["drive"].as_object().into_iter().flatten() {
            if let Some(item) = scalar(field) {
                drive[key] = item;
            }
        }
        table["drive"] = Item::Table(drive);
    }
    table
}

fn number(number: f64) -> Item {
    value(rounded(number))
}

fn numbers(numbers: &[f64]) -> Item {
    let numbers = numbers.iter().map(|number| Value::from(rounded(*number)));
    value(numbers.collect::<Array>())
}

/// Ten digits: more than anybody knows of a robot, and none of what rounding left.
fn rounded(number: f64) -> f64 {
    if number.abs() < 1e-12 {
        return 0.0;
    }
    format!("{number:.9e}").parse().unwrap_or(number)
}
