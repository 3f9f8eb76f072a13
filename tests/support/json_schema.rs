//! JSON Schema, as far as schemas of messages use it. (`tests/read_log.py` has a whole one, but
//! not everybody has Python.)

use serde_json::Value;

/// Where and why a value is not what a schema says.
///
/// # Panics
/// If the schema has a keyword that is not known here: nothing goes unchecked.
pub fn validate(schema: &Value, value: &Value) -> Result<(), String> {
    let number = |value: &Value| value.as_f64().unwrap();
    for (keyword, rule) in schema.as_object().expect("a schema is an object") {
        let right = match (keyword.as_str(), value) {
            ("$schema" | "title" | "description" | "format", _) => true,
            ("type", _) => match rule {
                Value::Array(types) => types.iter().any(|kind| is(kind, value)),
                kind => is(kind, value),
            },
            ("const", _) => rule == value,
            ("enum", _) => rule.as_array().unwrap().contains(value),
            ("minimum", Value::Number(_)) => number(value) >= number(rule),
            ("maximum", Value::Number(_)) => number(value) <= number(rule),
            ("minItems", Value::Array(items)) => items.len() as f64 >= number(rule),
            ("maxItems", Value::Array(items)) => items.len() as f64 <= number(rule),
            ("items", Value::Array(items)) => {
                for item in items {
                    validate(rule, item)?;
                }
                true
            }
            ("required", Value::Object(fields)) => {
                let mut names = rule.as_array().unwrap().iter();
                names.all(|name| fields.contains_key(name.as_str().unwrap()))
            }
            ("properties", Value::Object(fields)) => {
                for (name, rule) in rule.as_object().unwrap() {
                    if let Some(field) = fields.get(name) {
                        validate(rule, field).map_err(|error| format!("{name}/{error}"))?;
                    }
                }
                true
            }
            ("additionalProperties", Value::Object(fields)) => {
                assert_eq!(rule, false, "no other use of it is known");
                let known = schema["properties"].as_object().unwrap();
                fields.keys().all(|name| known.contains_key(name))
            }
            ("oneOf", _) => count(rule, value) == 1,
            ("anyOf", _) => count(rule, value) > 0,
            // Rules of other kinds of values.
            ("minimum" | "maximum" | "minItems" | "maxItems" | "items", _) => true,
            ("required" | "properties" | "additionalProperties", _) => true,
            (unknown, _) => panic!("keyword {unknown} is not known"),
        };
        if !right {
            return Err(format!("{keyword} of {value} is not {rule}"));
        }
    }
    Ok(())
}

fn count(options: &Value, value: &Value) -> usize {
    let options = options.as_array().unwrap().iter();
    options
        .filter(|option| validate(option, value).is_ok())
        .count()
}

fn is(kind: &Value, value: &Value) -> bool {
    match kind.as_str().unwrap() {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "integer" => value.is_i64() || value.is_u64(),
        "boolean" => value.is_boolean(),
        "null" => value.is_null(),
        other => panic!("type {other} is not known"),
    }
}
