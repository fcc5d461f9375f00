//! PLY, ascii and binary.

use std::path::Path;

use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType,
    ScalarType,
};

use super::columns::{self, Numbers, Stated};
use super::error::{CloudError, shortened};
use crate::stereo::Cloud;

const VERTEX: &str = "vertex";

/// The vertices; other elements, other properties and lists are skipped.
pub(super) fn parse(bytes: &[u8], path: &Path) -> Result<Cloud, CloudError> {
    let mut reader = Reader::new(bytes);
    let parser = Parser::<Numbers>::new();
    let header = parser.read_header(&mut reader);
    let header = header.map_err(|source| CloudError::Header {
        path: path.into(),
        line: source.line().unwrap_or(1),
        source,
    })?;

    let mut body = Body { path, bytes, rest: reader.into_inner() };

    for element in header.elements.values() {
        body.check_promise(element, &header)?;
        if element.name == VERTEX {
            let stated = stated(element, path)?;
            let mut points = Vec::new();
            body.each(element, &header, |numbers| {
                points.push(stated.point(&numbers));
            })?;
            return Ok(Cloud::from_points(points));
        }
        body.each(element, &header, |_| ())?;
    }

    Err(CloudError::NoVertices {
        path: path.into(),
        found: header.elements.keys().cloned().collect(),
    })
}

fn stated(vertex: &ElementDef, path: &Path) -> Result<Stated, CloudError> {
    let is_scalar = |(name, property): (_, &ply_rs_bw::ply::PropertyDef)| match property.data_type {
        PropertyType::Scalar(_) => Some(name),
        PropertyType::List(..) => None,
    };
    let scalars = vertex.properties.iter().filter_map(is_scalar);
    Stated::by(scalars.map(String::as_str)).ok_or_else(|| CloudError::Columns {
        path: path.into(),
        expected: columns::EXPECTED,
        found: vertex.properties.keys().cloned().collect(),
    })
}

/// What follows the header.
struct Body<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    rest: &'a [u8],
}

impl Body<'_> {
    /// Refuses an element with more items than the rest of the file can hold, before anything is allocated.
    fn check_promise(&self, element: &ElementDef, header: &Header) -> Result<(), CloudError> {
        let least_bytes = match header.encoding {
            Encoding::Ascii => element.properties.len(),
            _ => {
                let sizes = element.properties.values();
                sizes.map(|p| least_bytes(&p.data_type)).sum::<usize>()
            }
        };
        // an element without properties has no bytes, and would never end
        let room = self.rest.len() / least_bytes.max(1);
        if element.count > room {
            return Err(CloudError::Promise {
                path: self.path.into(),
                element: element.name.clone(),
                promised: element.count,
                room,
            });
        }
        Ok(())
    }

    fn each(
        &mut self,
        element: &ElementDef,
        header: &Header,
        mut take: impl FnMut(Numbers),
    ) -> Result<(), CloudError> {
        let parser = Parser::<Numbers>::new();
        for index in 1..=element.count {
            let byte = self.bytes.len() - self.rest.len();
            let numbers = match header.encoding {
                Encoding::Ascii => {
                    take(self.ascii(element)?);
                    continue;
                }
                Encoding::BinaryBigEndian => {
                    parser.read_big_endian_element(&mut self.rest, element)
                }
                Encoding::BinaryLittleEndian => {
                    parser.read_little_endian_element(&mut self.rest, element)
                }
            };

            take(numbers.map_err(|source| CloudError::Element {
                path: self.path.into(),
                byte,
                element: element.name.clone(),
                index,
                count: element.count,
                source,
            })?);
        }
        Ok(())
    }

    /// The next line that is not blank. The parser of the crate does not know `nan` and `inf`.
    fn ascii(&mut self, element: &ElementDef) -> Result<Numbers, CloudError> {
        let (line, text) = loop {
            let end = self.rest.iter().position(|byte| *byte == b'\n');
            let end = end.map_or(self.rest.len(), |end| end + 1);
            let (line, rest) = self.rest.split_at(end);
            self.rest = rest;
            if rest.is_empty() || !line.trim_ascii().is_empty() {
                break (line, String::from_utf8_lossy(line));
            }
        };

        ascii_numbers(&text, element).ok_or_else(|| {
            let read = &self.bytes[..self.bytes.len() - self.rest.len()];
            let ends = read.iter().filter(|byte| **byte == b'\n').count();
            let is_last_unfinished = !line.ends_with(b"\n");
            CloudError::Line {
                path: self.path.into(),
                line: (ends + usize::from(is_last_unfinished)) as u64,
                expected: "a number for each property of the element",
                found: shortened(text.trim()),
            }
        })
    }
}

fn ascii_numbers(line: &str, element: &ElementDef) -> Option<Numbers> {
    let mut words = line.split_whitespace();
    let mut numbers = Numbers::default();
    for (name, property) in &element.properties {
        let word = words.next()?;
        if let PropertyType::List(..) = property.data_type {
            for _ in 0..word.parse::<u64>().ok()? {
                words.next()?;
            }
            continue;
        }
        let value: f64 = word.parse().ok()?;
        if let Some(slot) = columns::slot(name) {
            numbers.0[slot] = value;
        }
    }
    Some(numbers)
}

fn least_bytes(property: &PropertyType) -> usize {
    let (PropertyType::Scalar(scalar) | PropertyType::List(scalar, _)) = property;
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

impl PropertyAccess for Numbers {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let value = match property {
            Property::Char(value) => value.into(),
            Property::UChar(value) => value.into(),
            Property::Short(value) => value.into(),
            Property::UShort(value) => value.into(),
            Property::Int(value) => value.into(),
            Property::UInt(value) => value.into(),
            Property::Float(value) => value.into(),
            Property::Double(value) => value,
            _ => return PropertyAccessResult::Ignored,
        };

        match columns::slot(name) {
            Some(slot) => {
                self.0[slot] = value;
                PropertyAccessResult::Set
            }
            None => PropertyAccessResult::Ignored,
        }
    }
}
