//! Which topic is read, and its messages.

use std::{
    collections::{BTreeMap, HashMap},
    sync::Arc,
};

use super::{
    super::{
        LogLimits, LogProblem, Place, Position,
        excerpt::{listed, shortened},
    },
    imu_message::{Encoding, ImuMessage},
    input::damaged,
};

/// Topics that a file may have.
const MAX_TOPICS: usize = 10_000;
/// Bytes of the name of a topic or type.
const MAX_NAME_BYTES: usize = 4096;
/// What ROS 1 and ROS 2 call the type.
const IMU_TYPES: [&str; 2] = ["sensor_msgs/Imu", "sensor_msgs/msg/Imu"];

/// The topics of a file, and the messages of the one that is wanted.
pub(super) struct Topics<'a> {
    wanted: Option<&'a str>,
    limits: LogLimits,
    topics: BTreeMap<Arc<str>, Topic>,
    /// Which topic a connection (ROS 1) or a channel (MCAP) belongs to.
    connections: HashMap<u32, Arc<str>>,
    chosen: Option<Arc<str>>,
    messages: Vec<Recorded>,
    notes: Vec<String>,
}

struct Topic {
    kind: Kind,
    in_body_axes: bool,
    messages: u64,
}

/// What a topic carries.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Kind {
    Imu(Encoding),
    /// The right type in an encoding that is not read.
    EncodedOtherwise(String),
    /// Another type.
    Other(String),
}

/// A message, and when it was recorded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Recorded {
    /// Since 1970.
    pub(super) at_ns: i64,
    pub(super) message: ImuMessage,
}

/// The messages of a topic.
pub(super) struct Chosen {
    pub(super) topic: Arc<str>,
    pub(super) messages: Vec<Recorded>,
    /// Whether the file says so.
    pub(super) in_body_axes: bool,
    /// How many messages there are on other topics.
    pub(super) others: u64,
    pub(super) notes: Vec<String>,
}

impl Kind {
    /// What messages of a type in an encoding are.
    pub(super) fn of(type_name: &str, encoding: &str) -> Self {
        if !IMU_TYPES.contains(&type_name) {
            return Self::Other(type_name.into());
        }
        match encoding {
            "ros1" => Self::Imu(Encoding::Ros1),
            "cdr" => Self::Imu(Encoding::Cdr),
            other => Self::EncodedOtherwise(other.into()),
        }
    }

    fn name(&self) -> String {
        match self {
            Self::Imu(_) => IMU_TYPES[0].into(),
            Self::EncodedOtherwise(encoding) => {
                format!("{} as {encoding:?}, expected cdr or ros1", IMU_TYPES[0])
            }
            Self::Other(name) => name.clone(),
        }
    }
}

impl<'a> Topics<'a> {
    pub(super) fn new(wanted: Option<&'a str>, limits: LogLimits) -> Self {
        Self {
            wanted,
            limits,
            topics: BTreeMap::new(),
            connections: HashMap::new(),
            chosen: None,
            messages: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// Bytes that a chunk may contain.
    pub(super) fn max_chunk_bytes(&self) -> u64 {
        self.limits.max_bytes
    }

    /// Makes a connection known. `Err` says what is wrong with it.
    pub(super) fn declare(
        &mut self,
        connection: u32,
        topic: &str,
        kind: &Kind,
        in_body_axes: bool,
    ) -> Result<(), String> {
        if topic.len() > MAX_NAME_BYTES {
            return Err(format!("a topic's name of {} bytes", topic.len()));
        }
        let known = self.topics.get_key_value(topic);
        let name = known.map_or_else(|| Arc::from(topic), |(name, _)| Arc::clone(name));
        if self.connections.len() >= MAX_TOPICS && !self.connections.contains_key(&connection) {
            return Err(format!("more than {MAX_TOPICS} topics"));
        }
        if self.chosen.is_none() && is_wanted(self.wanted, topic) {
            self.chosen = Some(Arc::clone(&name));
        }
        let topic = self.topics.entry(Arc::clone(&name));
        let topic = topic.or_insert_with(|| Topic {
            kind: kind.clone(),
            in_body_axes,
            messages: 0,
        });
        let is_imu = |kind: &Kind| matches!(kind, Kind::Imu(_));
        if topic.kind != *kind && (is_imu(&topic.kind) || is_imu(kind)) {
            let (before, now) = (topic.kind.name(), kind.name());
            return Err(format!(
                "{}: declared as {} and as {}",
                shortened(&name),
                shortened(&before),
                shortened(&now)
            ));
        }
        self.connections.insert(connection, name);
        Ok(())
    }

    /// Counts a message of a connection, and says how it is to be read if it is wanted. `Err`
    /// where the connection is not known.
    pub(super) fn count(&mut self, connection: u32) -> Result<Option<Encoding>, String> {
        let name = self.connections.get(&connection);
        let name = name
            .ok_or_else(|| format!("a message of connection {connection}, which is not known"))?;
        let Some(topic) = self.topics.get_mut(name) else {
            return Ok(None);
        };
        topic.messages += 1;
        let Kind::Imu(encoding) = topic.kind else {
            return Ok(None);
        };
        if self.chosen.is_none() && self.wanted.is_none() {
            self.chosen = Some(Arc::clone(name));
        }
        Ok((self.chosen.as_ref() == Some(name)).then_some(encoding))
    }

    /// Takes a message that is wanted, recorded at a time and found at a position.
    ///
    /// # Errors
    /// [`LogProblem::TooManyRows`], or what is wrong with the message.
    pub(super) fn take(
        &mut self,
        at_ns: i64,
        bytes: &[u8],
        encoding: Encoding,
        position: Position,
    ) -> Result<(), LogProblem> {
        let number = self.messages.len() as u64 + 1;
        let topic = self.chosen.clone().unwrap_or_default();
        let place = Place::Message(topic, number);
        if number > self.limits.max_rows {
            return Err(LogProblem::TooManyRows {
                place,
                max_rows: self.limits.max_rows,
            });
        }
        let message = ImuMessage::read(bytes, encoding)
            .map_err(|what| damaged(position, format!("{place} {what}")))?;
        self.messages.push(Recorded { at_ns, message });
        Ok(())
    }

    /// Tells something that a person should know.
    pub(super) fn note(&mut self, note: String) {
        self.notes.push(note);
    }

    /// The messages of the topic that was asked for, or of the only one.
    pub(super) fn finish(self) -> Result<Chosen, LogProblem> {
        let of_imu = || {
            self.topics
                .iter()
                .filter(|(_, topic)| matches!(topic.kind, Kind::Imu(_)))
        };
        let with_counts: Vec<String> = of_imu()
            .map(|(name, topic)| format!("{} ({} messages)", shortened(name), topic.messages))
            .collect();
        let found = match with_counts.is_empty() {
            true => "none".into(),
            false => listed(with_counts.iter().map(String::as_str)),
        };
        if let Some(wanted) = self.wanted {
            let what = match self.chosen.as_ref().and_then(|name| self.topics.get(name)) {
                None => Some("is not there".into()),
                Some(Topic { messages: 0, .. }) => Some("has no messages".into()),
                Some(Topic {
                    kind: Kind::Imu(_), ..
                }) => None,
                Some(Topic { kind, .. }) => Some(format!("is of {}", shortened(&kind.name()))),
            };
            if let Some(what) = what {
                let topic = shortened(wanted);
                return Err(LogProblem::Topic { topic, what, found });
            }
        } else if of_imu().filter(|(_, topic)| topic.messages > 0).count() > 1 {
            return Err(LogProblem::SeveralTopics { found });
        }
        let Some(topic) = self.chosen.clone().filter(|_| !self.messages.is_empty()) else {
            let all: Vec<String> = self
                .topics
                .iter()
                .map(|(name, topic)| {
                    format!("{} ({})", shortened(name), shortened(&topic.kind.name()))
                })
                .collect();
            return Err(LogProblem::NoImuTopic {
                found: match all.is_empty() {
                    true => "no topics".into(),
                    false => listed(all.iter().map(String::as_str)),
                },
            });
        };
        let all: u64 = self.topics.values().map(|topic| topic.messages).sum();
        Ok(Chosen {
            others: all.saturating_sub(self.messages.len() as u64),
            in_body_axes: self
                .topics
                .get(&topic)
                .is_some_and(|topic| topic.in_body_axes),
            topic,
            messages: self.messages,
            notes: self.notes,
        })
    }
}

/// Whether a topic is the one asked for, with its slash or without.
fn is_wanted(wanted: Option<&str>, topic: &str) -> bool {
    wanted.is_some_and(|wanted| wanted.trim_start_matches('/') == topic.trim_start_matches('/'))
}
