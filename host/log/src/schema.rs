//! JSON Schemas of messages, from their types: descriptions are the types' own comments.

use schemars::generate::SchemaSettings;
use schemars::transform::{Transform, transform_subschemas};
use schemars::{JsonSchema, Schema};
use serde_json::Value;

/// The schema of messages of type `T`, which is named `title`.
pub(crate) fn of<T: JsonSchema>(title: &str) -> Schema {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    let settings = settings.with(|settings| settings.inline_subschemas = true);
    let mut schema = settings
        .with_transform(Exact)
        .into_generator()
        .into_root_schema_for::<T>();
    schema.insert("title".into(), title.into());
    schema
}

/// Says of each part of a schema all that is known of its type: how large integers get, that objects
/// have no other fields, units; and words descriptions for readers of JSON.
#[derive(Clone)]
struct Exact;

impl Transform for Exact {
    fn transform(&mut self, schema: &mut Schema) {
        transform_subschemas(self, schema);
        let Some(fields) = schema.as_object_mut() else {
            return;
        };
        let largest = match fields.get("format").and_then(Value::as_str) {
            Some("uint32") => Some(u32::MAX.into()),
            Some("uint64") => Some(u64::MAX),
            _ => None,
        };
        if let Some(largest) = largest {
            fields.entry("maximum").or_insert(largest.into());
        }
        if fields.contains_key("properties") {
            fields.entry("additionalProperties").or_insert(false.into());
        }
        let unit = fields.remove("unit");
        if let Some(Value::String(text)) = fields.get_mut("description") {
            *text = worded(text);
            if let Some(unit) = unit.as_ref().and_then(Value::as_str)
                && !text.contains(unit)
            {
                *text = format!("{}, {unit}.", text.trim_end_matches('.'));
            }
        }
    }
}

/// The first paragraph of a comment, its links as plain text, `None` as JSON has it.
fn worded(comment: &str) -> String {
    let first = comment.split("\n\n").next().unwrap_or_default();
    let first = first.replace('\n', " ").replace("`None`", "null");
    let mut pieces = first.split("[`");
    let mut text = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let (name, after) = piece.split_once("`]").unwrap_or((piece, ""));
        let target = after
            .strip_prefix('(')
            .and_then(|rest| rest.split_once(')'));
        text = text + "`" + name + "`" + target.map_or(after, |(_, after)| after);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_are_worded_for_readers_of_json() {
        let comment = "See [`A::b`](super::A) and\n[`C`]; `None` without.\n\nMore.";
        assert_eq!(worded(comment), "See `A::b` and `C`; null without.");
    }

    #[test]
    fn ranges_and_units_are_those_of_the_types() {
        let schema = of::<crate::message::Step>("Step");
        let at = |path: &str| schema.as_value().pointer(path).cloned().unwrap();
        let front = at("/properties/sample/properties/front_um");
        assert_eq!(front["maximum"], u32::MAX);
        assert!(
            front["description"]
                .as_str()
                .unwrap()
                .ends_with(", micrometres.")
        );
        assert_eq!(at("/additionalProperties"), false);
        let percept = at("/properties/record/properties/sensed/properties/percept_ppm");
        assert_eq!(
            (&percept["maxItems"], &percept["items"]["minimum"]),
            (&4.into(), &(-1_000_000).into())
        );
    }
}
