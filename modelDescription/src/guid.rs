//! GUID over description and resources, which the binary checks.

use sha2::{Digest, Sha256};

use crate::ModelDescription;

/// Returns the GUID `{8-4-4-4-12}` from SHA-256 over a description, then name and bytes of each resource.
///
/// The hash is computed over `len(text) text`, with the `{:?}` text of the description with all its fields, then over
/// `len(name) name len(bytes) bytes` for each resource, with lengths as 64-bit little-endian numbers; its first 128
/// bits are the GUID. Resources must be sorted by name.
pub fn guid<'a>(
    description: &ModelDescription,
    resources: impl IntoIterator<Item = (&'a str, &'a [u8])>,
) -> String {
    guid_of_text(&format!("{description:?}"), resources)
}

fn guid_of_text<'a>(text: &str, resources: impl IntoIterator<Item = (&'a str, &'a [u8])>) -> String {
    let mut hash = Sha256::new();
    let mut add = |bytes: &[u8]| {
        hash.update((bytes.len() as u64).to_le_bytes());
        hash.update(bytes);
    };
    add(text.as_bytes());
    for (name, bytes) in resources {
        add(name.as_bytes());
        add(bytes);
    }
    let hex: String = hash.finalize().iter().take(16).map(|byte| format!("{byte:02x}")).collect();
    format!("{{{}-{}-{}-{}-{}}}", &hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn has_the_registry_form() {
        let guid = guid_of_text("", []);
        // The expected value is the SHA-256 of eight zero bytes.
        assert_eq!(guid, "{af5570f5-a181-0b7a-f78c-af4bc70a660f}");
    }

    #[test]
    fn changes_with_every_part() {
        let guid_of = |xml, name, bytes: &'static [u8]| guid_of_text(xml, [(name, bytes)]);
        let all = [
            guid_of("x", "n", b"b"),
            guid_of("y", "n", b"b"),
            guid_of("x", "m", b"b"),
            guid_of("x", "n", b"c"),
            guid_of("x", "nb", b""),
        ];
        for (position, one) in all.iter().enumerate() {
            assert!(!all[position + 1..].contains(one));
        }
    }
}
