//! Writer for the wire format of Protocol Buffers, as far as ONNX files need it.

/// Types that are written as a message.
pub trait Encode {
    /// Appends the fields to `message`.
    fn encode(&self, message: &mut Message);

    /// Encodes the fields as bytes.
    fn to_bytes(&self) -> Vec<u8> {
        let mut message = Message::default();
        self.encode(&mut message);
        message.bytes
    }
}

/// Bytes of a message, field after field.
#[derive(Debug, Default)]
pub struct Message {
    bytes: Vec<u8>,
}

/// Wire type: encoding of the value of a field.
#[derive(Debug, Clone, Copy)]
enum WireType {
    Varint = 0,
    LengthDelimited = 2,
}

impl Message {
    /// Writes an int32, int64 or enum field. Negative numbers take two's complement of 64 bits.
    pub fn integer(&mut self, field: u32, value: i64) {
        self.tag(field, WireType::Varint);
        self.varint(value.cast_unsigned());
    }

    /// Writes a bytes field.
    pub fn bytes(&mut self, field: u32, value: &[u8]) {
        self.tag(field, WireType::LengthDelimited);
        self.varint(value.len() as u64);
        self.bytes.extend_from_slice(value);
    }

    /// Writes a string field.
    pub fn string(&mut self, field: u32, value: &str) {
        self.bytes(field, value.as_bytes());
    }

    /// Writes a field that is itself a message.
    pub fn message(&mut self, field: u32, value: &impl Encode) {
        self.bytes(field, &value.to_bytes());
    }

    /// Writes a repeated field: each of `values` under the same field number.
    pub fn messages(&mut self, field: u32, values: &[impl Encode]) {
        values.iter().for_each(|value| self.message(field, value));
    }

    fn tag(&mut self, field: u32, wire_type: WireType) {
        self.varint(u64::from(field) << 3 | wire_type as u64);
    }

    /// Writes a varint: seven bits a byte, lowest first. The top bit says that more bytes follow.
    fn varint(&mut self, mut value: u64) {
        while value >= 0x80 {
            self.bytes.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.bytes.push(value as u8);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(write: impl FnOnce(&mut Message)) -> Vec<u8> {
        let mut message = Message::default();
        write(&mut message);
        message.bytes
    }

    /// Tests the examples in the encoding guide of Protocol Buffers.
    #[test]
    fn bytes_are_those_of_the_encoding_guide() {
        struct Test1;
        impl Encode for Test1 {
            fn encode(&self, message: &mut Message) {
                message.integer(1, 150);
            }
        }
        assert_eq!(Test1.to_bytes(), [0x08, 0x96, 0x01]);
        let testing = [0x12, 0x07, 0x74, 0x65, 0x73, 0x74, 0x69, 0x6E, 0x67];
        assert_eq!(written(|m| m.string(2, "testing")), testing);
        assert_eq!(written(|m| m.message(3, &Test1)), [0x1A, 0x03, 0x08, 0x96, 0x01]);
        assert_eq!(written(|m| m.messages(3, &[Test1, Test1]))[5..], [0x1A, 0x03, 0x08, 0x96, 0x01]);
    }

    #[test]
    fn varints_grow_every_seven_bits() {
        let varint = |value| written(|m| m.varint(value));
        assert_eq!(varint(0), [0x00]);
        assert_eq!(varint(127), [0x7F]);
        assert_eq!(varint(128), [0x80, 0x01]);
        assert_eq!(varint(16_383), [0xFF, 0x7F]);
        assert_eq!(varint(16_384), [0x80, 0x80, 0x01]);
        let most = [0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x01];
        assert_eq!(varint(u64::MAX), most);
        assert_eq!(written(|m| m.integer(1, -1)), [&[0x08], &most[..]].concat());
    }

    #[test]
    fn long_fields_and_high_numbers_have_long_lengths_and_tags() {
        let long = written(|m| m.bytes(9, &[7; 300]));
        assert_eq!((&long[..3], long.len()), (&[0x4A, 0xAC, 0x02][..], 303));
        assert_eq!(written(|m| m.integer(20, 7)), [0xA0, 0x01, 0x07]);
        assert_eq!(written(|m| m.bytes(2, &[])), [0x12, 0x00]);
    }
}
