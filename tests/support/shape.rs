//! What serde says of a type's make: fields and variants with their names, types and order, which
//! is all that postcard's encoding depends on.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::value::U32Deserializer;
use serde::de::{
    self, DeserializeOwned, DeserializeSeed, Deserializer, EnumAccess, IntoDeserializer, SeqAccess,
    VariantAccess, Visitor,
};

/// How a struct or an enum is made.
#[derive(Debug, PartialEq, Eq)]
pub enum Shape {
    /// Names and types of the fields.
    Struct(Vec<(String, String)>),
    /// Names and contents of the variants.
    Enum(Vec<(String, String)>),
}

/// All structs and enums that types contain, by name.
#[derive(Debug, Default)]
pub struct Shapes {
    pub found: BTreeMap<String, Shape>,
    /// How often each enum was met.
    met: BTreeMap<String, usize>,
}

/// What stands for a variant's contents before it was looked at.
const UNSEEN: &str = "?";

impl Shapes {
    /// Adds a type and all that it contains.
    pub fn add<T: DeserializeOwned>(&mut self) {
        // A value shows one variant of each enum in it: one value after another, until all are seen.
        for _ in 0..100_000 {
            T::deserialize(self.tracer(&mut String::new(), None)).expect("zeros are a value");
            let unseen = |shape: &Shape| match shape {
                Shape::Enum(variants) => variants.iter().any(|(_, contents)| contents == UNSEEN),
                Shape::Struct(_) => false,
            };
            if !self.found.values().any(unseen) {
                return;
            }
        }
        panic!("some variant is never reached: {self:?}");
    }

    fn tracer<'a>(&'a mut self, name: &'a mut String, variant: Option<u32>) -> Tracer<'a> {
        Tracer {
            shapes: self,
            name,
            variant,
        }
    }

    /// The variant to look at now: one that was not seen yet, or else one after another.
    fn choose(&mut self, name: &str, variants: &[&str]) -> usize {
        let unseen = variants
            .iter()
            .map(|&v| (v.into(), UNSEEN.into()))
            .collect();
        let shape = self.found.entry(name.into());
        let Shape::Enum(known) = shape.or_insert(Shape::Enum(unseen)) else {
            panic!("{name} is a struct and an enum");
        };
        let unseen = known.iter().position(|(_, contents)| contents == UNSEEN);
        let met = self.met.entry(name.into()).or_default();
        *met += 1;
        unseen.unwrap_or(*met % variants.len())
    }
}

/// The variant of an enum with this number, all else in it zero, empty or the first of its kind.
pub fn sample<T: DeserializeOwned>(variant: u32) -> T {
    T::deserialize(Shapes::default().tracer(&mut String::new(), Some(variant)))
        .expect("there is such a variant")
}

/// Reads zeros, and writes down as what.
struct Tracer<'a> {
    shapes: &'a mut Shapes,
    /// The type's name.
    name: &'a mut String,
    /// The variant to choose if this is an enum.
    variant: Option<u32>,
}

impl Tracer<'_> {
    /// Reads a part of the type, and gives the part's name with it.
    fn part<'de, S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<(S::Value, String), Error> {
        let mut name = String::new();
        let value = seed.deserialize(self.shapes.tracer(&mut name, None))?;
        Ok((value, name))
    }

    fn parts<'de, V: Visitor<'de>>(
        &mut self,
        count: usize,
        visitor: V,
    ) -> Result<(V::Value, Vec<String>), Error> {
        let mut names = Vec::new();
        let parts = Parts {
            tracer: self,
            left: count,
            names: &mut names,
        };
        Ok((visitor.visit_seq(parts)?, names))
    }
}

macro_rules! plain {
    ($($method:ident $visit:ident $name:literal $zero:expr;)*) => {$(
        fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
            *self.name = $name.into();
            visitor.$visit($zero)
        }
    )*};
}

impl<'de> Deserializer<'de> for Tracer<'_> {
    type Error = Error;

    plain! {
        deserialize_bool visit_bool "bool" false;
        deserialize_i32 visit_i32 "i32" 0;
        deserialize_u8 visit_u8 "u8" 0;
        deserialize_u16 visit_u16 "u16" 0;
        deserialize_u32 visit_u32 "u32" 0;
        deserialize_u64 visit_u64 "u64" 0;
        deserialize_str visit_str "String" "";
        deserialize_string visit_str "String" "";
    }

    fn deserialize_unit<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        *self.name = "()".into();
        visitor.visit_unit()
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let mut inner = String::new();
        let value = visitor.visit_some(self.shapes.tracer(&mut inner, None))?;
        *self.name = format!("Option<{inner}>");
        Ok(value)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(mut self, visitor: V) -> Result<V::Value, Error> {
        let (value, parts) = self.parts(1, visitor)?;
        *self.name = format!("Vec<{}>", parts.concat());
        Ok(value)
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        mut self,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Error> {
        let (value, parts) = self.parts(length, visitor)?;
        let alike = parts.iter().all(|part| *part == parts[0]);
        *self.name = match parts.first() {
            Some(part) if alike => format!("[{part}; {length}]"),
            _ => format!("({})", parts.join(", ")),
        };
        Ok(value)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        mut self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        let (value, types) = self.parts(fields.len(), visitor)?;
        let fields = fields.iter().map(|&field| field.into()).zip(types);
        let shape = Shape::Struct(fields.collect());
        self.shapes.found.insert(name.into(), shape);
        *self.name = name.into();
        Ok(value)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        let chosen = self.shapes.choose(name, variants);
        let chosen = self.variant.map_or(chosen, |variant| variant as usize);
        let mut contents = "-".to_string();
        let value = visitor.visit_enum(Chosen {
            tracer: self.shapes.tracer(&mut contents, None),
            index: chosen as u32,
        })?;
        if let Some(Shape::Enum(known)) = self.shapes.found.get_mut(name) {
            known[chosen].1 = contents;
        }
        *self.name = name.into();
        Ok(value)
    }

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Error> {
        Err(de::Error::custom("no type of the contract needs this"))
    }

    serde::forward_to_deserialize_any! {
        i8 i16 i64 f32 f64 char bytes byte_buf unit_struct tuple_struct map identifier ignored_any
    }
}

/// Parts of a type, one after the other.
struct Parts<'p, 'a> {
    tracer: &'p mut Tracer<'a>,
    left: usize,
    names: &'p mut Vec<String>,
}

impl<'de> SeqAccess<'de> for Parts<'_, '_> {
    type Error = Error;

    fn next_element_seed<S: DeserializeSeed<'de>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, Error> {
        if self.left == 0 {
            return Ok(None);
        }
        self.left -= 1;
        let (value, name) = self.tracer.part(seed)?;
        self.names.push(name);
        Ok(Some(value))
    }
}

/// The variant that was chosen.
struct Chosen<'a> {
    tracer: Tracer<'a>,
    index: u32,
}

impl<'de> EnumAccess<'de> for Chosen<'_> {
    type Error = Error;
    type Variant = Self;

    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Self), Error> {
        let index: U32Deserializer<Error> = self.index.into_deserializer();
        Ok((seed.deserialize(index)?, self))
    }
}

impl<'de> VariantAccess<'de> for Chosen<'_> {
    type Error = Error;

    fn unit_variant(self) -> Result<(), Error> {
        Ok(())
    }

    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value, Error> {
        seed.deserialize(self.tracer)
    }

    fn tuple_variant<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Error> {
        self.tracer.deserialize_tuple(length, visitor)
    }

    fn struct_variant<V: Visitor<'de>>(
        mut self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        let (value, types) = self.tracer.parts(fields.len(), visitor)?;
        let fields = fields.iter().zip(types);
        let fields: Vec<_> = fields.map(|(field, of)| format!("{field}: {of}")).collect();
        *self.tracer.name = fields.join(", ");
        Ok(value)
    }
}

/// Why a type cannot be looked at.
#[derive(Debug)]
pub struct Error(String);

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Error {}

impl de::Error for Error {
    fn custom<T: fmt::Display>(text: T) -> Self {
        Self(text.to_string())
    }
}
