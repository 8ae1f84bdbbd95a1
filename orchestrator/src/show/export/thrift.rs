//! As much of Thrift's compact protocol as the heads of a Parquet file take.

/// What a field holds.
pub(super) enum Value {
    I32(i32),
    I64(i64),
    Text(String),
    Struct(Struct),
    /// Values of one kind.
    List(Vec<Value>),
}

/// Fields by their numbers, ascending.
pub(super) struct Struct(pub(super) Vec<(u8, Value)>);

impl Value {
    /// Number of its type in the protocol.
    fn kind(&self) -> u8 {
        match self {
            Value::I32(_) => 5,
            Value::I64(_) => 6,
            Value::Text(_) => 8,
            Value::List(_) => 9,
            Value::Struct(_) => 12,
        }
    }

    fn write(&self, out: &mut Vec<u8>) {
        match self {
            Value::I32(value) => varint(zigzag(i64::from(*value)), out),
            Value::I64(value) => varint(zigzag(*value), out),
            Value::Text(text) => {
                varint(text.len() as u64, out);
                out.extend(text.as_bytes());
            }
            Value::Struct(fields) => fields.write(out),
            Value::List(values) => {
                const LONG: usize = 15;
                let kind = values.first().map_or(0, Value::kind);
                if values.len() < LONG {
                    out.push((values.len() as u8) << 4 | kind);
                } else {
                    out.push(0xf0 | kind);
                    varint(values.len() as u64, out);
                }
                values.iter().for_each(|value| value.write(out));
            }
        }
    }
}

impl Struct {
    pub(super) fn bytes(&self) -> Vec<u8> {
        let mut out = Vec::new();
        self.write(&mut out);
        out
    }

    fn write(&self, out: &mut Vec<u8>) {
        let mut before = 0;
        for (number, value) in &self.0 {
            // Our structures have no gaps of more than 15 fields.
            out.push((number - before) << 4 | value.kind());
            value.write(out);
            before = *number;
        }
        out.push(0);
    }
}

/// Small numbers of both signs as small numbers.
fn zigzag(value: i64) -> u64 {
    ((value << 1) ^ (value >> 63)) as u64
}

/// Seven bits a byte, the lowest ones first.
fn varint(mut value: u64, out: &mut Vec<u8>) {
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_texts_and_lists_have_their_bytes() {
        let list = Value::List(vec![Value::I32(-1), Value::I32(300)]);
        let value = Struct(vec![(1, Value::I32(1)), (4, Value::Text("ab".into())), (5, list)]);
        assert_eq!(value.bytes(), [0x15, 2, 0x38, 2, b'a', b'b', 0x19, 0x25, 1, 0xd8, 4, 0]);
        let long = Struct(vec![(1, Value::List((0..20).map(Value::I64).collect()))]).bytes();
        assert_eq!((&long[..3], long.len()), (&[0x19, 0xf6, 20][..], 3 + 20 + 1));
    }
}
