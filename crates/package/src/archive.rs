//! An FMU as a file: its GUID and its files, read so that no importer unpacks anything else.

use crate::error::{ArchiveError, Error};
use quick_xml::Reader;
use quick_xml::events::Event;
use squid_base::files::read_bytes;
use squid_fmi2::Resources;
use std::collections::{BTreeMap, HashSet};
use std::io::{Cursor, Read};
use std::path::Path;
use zip::ZipArchive;

/// Largest unpacked size of all entries in bytes; ten times that of an FMU for all platforms.
const LARGEST: u64 = 128 << 20;

/// Contents of an FMU.
#[derive(Debug)]
pub struct FmuArchive {
    /// GUID in `modelDescription.xml`.
    pub guid: String,
    /// Bytes of `modelDescription.xml`.
    pub description: Vec<u8>,
    /// Files in `resources/`.
    pub resources: Resources,
    /// All other files, by name.
    pub others: BTreeMap<String, Vec<u8>>,
}

impl FmuArchive {
    /// Reads an FMU.
    ///
    /// # Errors
    /// [`Unreadable`](squid_base::files::Error::Unreadable); [`Error::Archive`] if the zip is damaged or ambiguous.
    pub fn read(path: &Path) -> Result<Self, Error> {
        Self::from_bytes(&read_bytes(path)?)
            .map_err(|reason| Error::Archive { path: path.display().to_string(), reason })
    }

    /// Reads an FMU from its bytes.
    ///
    /// # Errors
    /// [`ArchiveError`].
    fn from_bytes(bytes: &[u8]) -> Result<Self, ArchiveError> {
        let mut archive = ZipArchive::new(Cursor::new(bytes))?;
        // Checks, among others, that no name occurs twice, that entries do not overlap, and that local and central
        // headers agree.
        archive.validate_header_consistency()?;
        let (mut files, mut folders) = (HashSet::new(), HashSet::new());
        let (mut description, mut resources, mut others) =
            (Vec::new(), Resources::default(), BTreeMap::new());
        let mut left = LARGEST;
        for index in 0..archive.len() {
            let entry = archive.by_index(index)?;
            let name = entry.name()?.into_owned();
            if !is_plain(&name) || entry.is_symlink() {
                return Err(ArchiveError::Name { name });
            }
            let path = name.to_lowercase();
            if entry.is_dir() {
                folders.insert(path.trim_end_matches('/').to_owned());
            } else if !files.insert(path.clone()) {
                return Err(ArchiveError::Twice { name });
            }
            folders.extend(path.match_indices('/').map(|(end, _)| path[..end].to_owned()));
            if entry.is_dir() {
                continue;
            }
            let bytes = content(entry, &name, left)?;
            left -= bytes.len() as u64;
            if name == DESCRIPTION {
                description = bytes;
            } else if let Some(resource) = name.strip_prefix("resources/") {
                resources.insert(resource, bytes);
            } else {
                others.insert(name, bytes);
            }
        }
        if let Some(name) = files.intersection(&folders).next() {
            return Err(ArchiveError::Twice { name: name.clone() });
        }
        let guid = guid_of(&description).ok_or(ArchiveError::NoGuid)?;
        Ok(Self { guid, description, resources, others })
    }
}

const DESCRIPTION: &str = "modelDescription.xml";

/// Returns `true` if every tool unpacks this name to the same path; a folder may end with `/`.
fn is_plain(name: &str) -> bool {
    let path = name.strip_suffix('/').unwrap_or(name);
    // Windows drops a dot or a space at the end of a name.
    path.split('/')
        .all(|part| !part.is_empty() && !part.ends_with(['.', ' ']) && !part.contains(['\\', ':', '\0']))
}

/// Returns the bytes of an entry, at most `left`.
fn content(entry: impl Read, name: &str, left: u64) -> Result<Vec<u8>, ArchiveError> {
    let mut bytes = Vec::new();
    let read = entry.take(left + 1).read_to_end(&mut bytes);
    match read {
        Err(reason) => Err(ArchiveError::Unreadable { name: name.into(), reason }),
        Ok(_) if bytes.len() as u64 > left => {
            Err(ArchiveError::Large { name: name.into(), most: LARGEST >> 20 })
        }
        Ok(_) => Ok(bytes),
    }
}

/// Returns the attribute `guid` of the root element of a model description.
fn guid_of(xml: &[u8]) -> Option<String> {
    let mut reader = Reader::from_reader(xml);
    loop {
        match reader.read_event().ok()? {
            Event::Start(root) | Event::Empty(root) => {
                let attribute = root.try_get_attribute("guid").ok()??;
                return Some(attribute.value.into_owned());
            }
            Event::Eof => return None,
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;
    use zip::write::SimpleFileOptions;

    fn zipped(entries: &[(&str, &[u8])]) -> Vec<u8> {
        let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
        for (name, bytes) in entries {
            zip.start_file(*name, SimpleFileOptions::default()).unwrap();
            zip.write_all(bytes).unwrap();
        }
        zip.finish().unwrap().into_inner()
    }

    const XML: &[u8] =
        b"<?xml version=\"1.0\"?><!-- guid=\"x\" --><a:b guid=\"{1}\" other=\"2\"><c guid=\"3\"/></a:b>";

    #[test]
    fn reads_guid_of_root_element() {
        let found =
            FmuArchive::from_bytes(&zipped(&[(DESCRIPTION, XML), ("resources/one.json", b"1")])).unwrap();
        assert_eq!(found.guid, "{1}");
        assert_eq!(found.resources.bytes("one.json").unwrap(), b"1");
        for nameless in [&b"<a><b guid=\"1\"/></a>"[..], b"", b"<!-- guid=\"1\" -->"] {
            let refused = FmuArchive::from_bytes(&zipped(&[(DESCRIPTION, nameless)]));
            assert!(matches!(refused, Err(ArchiveError::NoGuid)), "{}", String::from_utf8_lossy(nameless));
        }
    }

    #[test]
    fn rejects_ambiguous_archives() {
        for name in ["./a", "a/../b", "/a", "a//b", "a\\b", "c:a", "..", "resources./a", "a "] {
            let refused = FmuArchive::from_bytes(&zipped(&[(DESCRIPTION, XML), (name, b"")]));
            assert!(
                matches!(&refused, Err(ArchiveError::Name { name: found }) if found == name),
                "{name}: {refused:?}"
            );
        }
        let refused = FmuArchive::from_bytes(&zipped(&[
            (DESCRIPTION, XML),
            ("resources/A", b""),
            ("resources/a", b""),
        ]));
        assert!(matches!(refused, Err(ArchiveError::Twice { .. })));
        let refused =
            FmuArchive::from_bytes(&zipped(&[(DESCRIPTION, XML), ("resources/a", b""), ("Resources", b"")]));
        assert!(matches!(refused, Err(ArchiveError::Twice { .. })), "a file where a folder is");
        let mut zip = zip::ZipWriter::new_append(Cursor::new(zipped(&[(DESCRIPTION, XML)]))).unwrap();
        zip.add_symlink("resources/a", "elsewhere", SimpleFileOptions::default()).unwrap();
        let refused = FmuArchive::from_bytes(&zip.finish().unwrap().into_inner());
        assert!(matches!(refused, Err(ArchiveError::Name { .. })), "a link");
        // Two entries of the same name: the writer refuses this, so the second is renamed in the bytes.
        let mut twice = zipped(&[(DESCRIPTION, XML), ("resources/a.json", b"1"), ("resources/b.json", b"2")]);
        let name = b"resources/b.json";
        while let Some(at) = twice.windows(name.len()).position(|w| w == name) {
            twice[at + "resources/".len()] = b'a';
        }
        assert!(matches!(FmuArchive::from_bytes(&twice), Err(ArchiveError::Zip(_))));
    }

    #[test]
    fn limits_total_unpacked_size() {
        let zeros = vec![0; LARGEST as usize / 4];
        let names = ["binaries/a", "resources/b", "documentation/c", "d"];
        let all: Vec<(&str, &[u8])> = names.iter().map(|name| (*name, &zeros[..])).collect();
        let whole = FmuArchive::from_bytes(&zipped(&[&[(DESCRIPTION, XML)], &all[..3]].concat())).unwrap();
        assert_eq!(whole.others.len(), 2);
        let refused = FmuArchive::from_bytes(&zipped(&[&[(DESCRIPTION, XML)], &all[..]].concat()));
        assert!(matches!(refused, Err(ArchiveError::Large { name, .. }) if name == "d"));
    }
}
