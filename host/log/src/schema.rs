//! JSON Schemas of messages, from their types: descriptions are the types' own comments.

use schemars::generate::SchemaSettings;
use schemars::transform::{Transform, transform_subschemas};
use schemars::{JsonSchema, Schema};
use serde_json::{Value, json};

/// The schema of messages of type `T`, which is named `title`.
pub(crate) fn of<T: JsonSchema>(title: &str) -> Schema {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    let settings = settings.with(|settings| settings.inline_subschemas = true);
    let mut schema = settings.with_transform(Exact).into_generator().into_root_schema_for::<T>();
    schema.insert("title".into(), title.into());
    schema
}

/// Says of a schema all that is known of the type: how large integers get, that objects have no
/// other fields.
#[derive(Clone)]
struct Exact;

impl Transform for Exact {
    fn transform(&mut self, schema: &mut Schema) {
        transform_subschemas(self, schema);
        let largest = match schema.get("format").and_then(Value::as_str) {
            Some("uint32") => Some(json!(u32::MAX)),
            Some("uint64") => Some(json!(u64::MAX)),
            _ => None,
        };
        if let Some(fields) = schema.as_object_mut() {
            if let Some(largest) = largest {
                fields.entry("maximum").or_insert(largest);
            }
            if fields.contains_key("properties") {
                fields.entry("additionalProperties").or_insert(false.into());
            }
        }
    }
}
