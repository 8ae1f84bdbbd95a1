//! Dotted paths: `agents.2.position`, also written `agents[2].position`, and `variants."slow and steady".dt`.

use toml::de::DeValue;

/// Appends a key or an element number to a path.
pub(super) fn join(path: &str, segment: &str) -> String {
    match path {
        "" => key_text(segment),
        _ => format!("{path}.{}", key_text(segment)),
    }
}

/// A key as TOML and paths write it: quoted if it must be.
pub(super) fn key_text(key: &str) -> String {
    let bare = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_' || byte == b'-';
    if !key.is_empty() && key.bytes().all(bare) { key.into() } else { quote(key) }
}

/// Text as a TOML string on one line.
pub(super) fn quote(text: &str) -> String {
    let mut quoted = String::with_capacity(text.len() + 2);
    quoted.push('"');
    for character in text.chars() {
        match character {
            '"' => quoted.push_str("\\\""),
            '\\' => quoted.push_str("\\\\"),
            '\n' => quoted.push_str("\\n"),
            '\t' => quoted.push_str("\\t"),
            '\r' => quoted.push_str("\\r"),
            control if control.is_control() => quoted.push_str(&format!("\\u{:04X}", control as u32)),
            other => quoted.push(other),
        }
    }
    quoted.push('"');
    quoted
}

/// The segments of a path.
///
/// # Errors
/// A message if the path is malformed.
pub(super) fn split(path: &str) -> Result<Vec<String>, String> {
    let mut segments = Vec::new();
    let mut rest = path;
    loop {
        let (segment, after) = first_segment(rest).ok_or_else(|| format!("{path:?} is not a field"))?;
        segments.push(segment);
        rest = match after.strip_prefix('.') {
            Some(after) => after,
            None if after.is_empty() => return Ok(segments),
            None if after.starts_with('[') => after,
            None => return Err(format!("{path:?} is not a field")),
        };
    }
}

/// The first segment and what follows it.
fn first_segment(path: &str) -> Option<(String, &str)> {
    if let Some(inside) = path.strip_prefix('[') {
        let (number, after) = inside.split_once(']')?;
        return (!number.is_empty()).then(|| (number.into(), after));
    }
    if path.starts_with('"') {
        let mut escaped = true; // so that the opening quote is passed over
        let end = path.find(|character| {
            let closing = character == '"' && !escaped;
            escaped = character == '\\' && !escaped;
            closing
        })?;
        let (quoted, after) = path.split_at(end + 1);
        return Some((DeValue::parse(quoted).ok()?.get_ref().as_str()?.to_string(), after));
    }
    let end = path.find(['.', '[']).unwrap_or(path.len());
    (end > 0).then(|| (path[..end].into(), &path[end..]))
}
