//! What requests and answers have in common.

/// Largest head, bytes.
pub(super) const HEAD_BYTES: usize = 16 << 10;
/// Most fields of a head.
pub(super) const MOST_FIELDS: usize = 64;
/// Largest body, bytes.
pub(super) const BODY_BYTES: usize = 16 << 20;

/// How long a body is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Length {
    /// The head does not say it.
    Unsaid,
    /// Bytes.
    Bytes(usize),
    /// More than is read.
    TooLong,
    /// No number.
    Unreadable,
}

/// The values of a field, in lower case.
pub(super) fn values(fields: &[httparse::Header<'_>], name: &str) -> Vec<String> {
    let named = fields.iter().filter(|field| field.name.eq_ignore_ascii_case(name));
    named.map(|field| String::from_utf8_lossy(field.value).trim().to_ascii_lowercase()).collect()
}

/// The length of the body that a head says.
pub(super) fn length(fields: &[httparse::Header<'_>]) -> Length {
    match values(fields, "content-length").as_slice() {
        [] => Length::Unsaid,
        [length] if !length.is_empty() && length.bytes().all(|digit| digit.is_ascii_digit()) => {
            let bytes = length.parse::<usize>().ok().filter(|length| *length <= BODY_BYTES);
            bytes.map_or(Length::TooLong, Length::Bytes)
        }
        _ => Length::Unreadable,
    }
}
