//! The end of `result.json`: sums by which a reader knows that it is whole, and which `joints.trc` belongs to it.

/// What stands before and after the two sums.
const JOINTS: &str = ",\n  \"joints_blake3\": \"";
const CHECKSUM: &str = ",\n  \"checksum\": \"";
const END: &str = "\"\n}\n";

/// Adds the sums to the text of an object: the BLAKE3 of `joints.trc`, and last that of all bytes before it.
pub(super) fn seal(object: &[u8], joints: &[u8]) -> Vec<u8> {
    let open = object.strip_suffix(b"\n}").unwrap_or(object);
    let mut text = [open, JOINTS.as_bytes()].concat();
    text.extend_from_slice(blake3::hash(joints).to_string().as_bytes());
    text.push(b'"');

    let checksum = blake3::hash(&text).to_string();
    for part in [CHECKSUM, &checksum, END] {
        text.extend_from_slice(part.as_bytes());
    }
    text
}

/// Whether a text ends with the sum of all bytes before it.
pub(super) fn is_whole(text: &[u8]) -> bool {
    let sum_at = |end: &[u8]| end.len().checked_sub(blake3::OUT_LEN * 2);
    let split = text.strip_suffix(END.as_bytes()).and_then(|t| t.split_at_checked(sum_at(t)?));
    split.is_some_and(|(before, sum)| {
        let before = before.strip_suffix(CHECKSUM.as_bytes());
        before.is_some_and(|before| blake3::hash(before).to_string().as_bytes() == sum)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sealed_text_is_json_and_any_other_byte_in_it_is_found() {
        let sealed = seal(b"{\n  \"a\": 1.5\n}", b"points");
        let value: serde_json::Value = serde_json::from_slice(&sealed).unwrap();
        assert_eq!(value["a"], 1.5);
        assert_eq!(value["joints_blake3"], blake3::hash(b"points").to_string());
        assert!(is_whole(&sealed));
        for i in 0..sealed.len() {
            let mut changed = sealed.clone();
            changed[i] ^= 1;
            assert!(!is_whole(&changed), "byte {i}");
            assert!(!is_whole(&sealed[..i]), "cut at {i}");
        }
    }
}
