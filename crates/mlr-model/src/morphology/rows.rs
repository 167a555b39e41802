//! Morphologies as JSON holds them: a list of existence numbers per leg.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use super::{LegLayout, Morphology};
use crate::ModelError;

impl Morphology {
    /// Reads one list of existence numbers per leg, whose lengths are the links of the
    /// healthy robot. Link logic is applied.
    fn from_rows(rows: &[Vec<u8>]) -> Result<Self, ModelError> {
        let layout = LegLayout::new(rows.iter().map(Vec::len))?;
        let existence = rows
            .iter()
            .flatten()
            .map(|number| match number {
                0 => Ok(false),
                1 => Ok(true),
                _ => Err(ModelError::Morphology {
                    text: format!("{rows:?}"),
                    reason: format!("{number} is not an existence number, expected 0 or 1"),
                }),
            })
            .collect::<Result<Vec<_>, _>>()?;
        Self::from_existence(&layout, &existence)
    }
}

/// One list per leg: `[[1,1,1],[1,1,0]]`.
impl Serialize for Morphology {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq((0..self.legs()).map(|leg| {
            (0..self.links(leg))
                .map(|link| u8::from(self.exists(leg, link)))
                .collect::<Vec<_>>()
        }))
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for Morphology {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Morphology".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "description": "One list of existence numbers per leg, from the body outward.",
            "type": "array",
            "minItems": 1,
            "items": {"type": "array", "minItems": 1, "items": {"type": "integer", "minimum": 0, "maximum": 1}}
        })
    }
}

/// One list per leg, of as many numbers as the healthy leg has links. Link logic is applied.
impl<'de> Deserialize<'de> for Morphology {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let rows = Vec::<Vec<u8>>::deserialize(deserializer)?;
        Self::from_rows(&rows).map_err(de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn read(json: &str) -> Result<Morphology, serde_json::Error> {
        serde_json::from_str(json)
    }

    #[test]
    fn json_is_one_list_of_existence_numbers_per_leg() {
        let layout = LegLayout::new([3, 2, 1]).unwrap();
        let morphology = Morphology::parse("110 00 1", &layout).unwrap();
        let json = serde_json::to_string(&morphology).unwrap();
        assert_eq!(json, "[[1,1,0],[0,0],[1]]");
    }

    #[test]
    fn link_logic_is_applied_to_what_is_read() {
        let morphology = read("[[1,0,1],[1,1]]").unwrap();
        assert_eq!(morphology.to_string(), "100 11");
    }

    #[test]
    fn what_is_no_morphology_is_refused() {
        for (json, told) in [
            (
                "[[1,1],[1,2]]",
                "2 is not an existence number, expected 0 or 1",
            ),
            ("[]", "at least one leg"),
            ("[[1],[]]", "1 to 255 links"),
            ("[[1],[-1]]", "-1"),
            ("[1,1]", "a sequence"),
        ] {
            let message = read(json).unwrap_err().to_string();
            assert!(message.contains(told), "{json}: {message}");
        }
    }

    proptest! {
        #[test]
        fn writing_and_reading_are_inverse(bits in prop::collection::vec(any::<bool>(), 9)) {
            let layout = LegLayout::new([3, 2, 4]).unwrap();
            let morphology = Morphology::from_existence(&layout, &bits).unwrap();
            let json = serde_json::to_string(&morphology).unwrap();
            prop_assert_eq!(read(&json).unwrap(), morphology);
        }
    }
}
