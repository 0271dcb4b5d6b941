//! The resource location, a file URI (RFC 8089), in the variants used by importers.

use std::path::PathBuf;

/// Reason for which a resource location cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum UriError {
    /// A URI without the scheme `file:`.
    #[error("the resource location '{uri}' is not a file URI such as file:///path/resources")]
    NotFile { uri: String },
    /// A remote host.
    #[error("the resource location '{uri}' has the host '{host}'; only local files can be read")]
    Remote { uri: String, host: String },
    /// A `%` that is not followed by two hexadecimal digits, or bytes that are not UTF-8, in a path that does not exist
    /// without decoding.
    #[error("the resource location '{uri}' has an invalid percent-encoding")]
    BadEncoding { uri: String },
}

/// Returns the path of a file URI: `file:/p`, `file:///p`, `file:////p`, `file://localhost/p`, with or without a
/// trailing slash, with a drive letter on Windows after two or three slashes.
///
/// The path is percent-decoded. Some importers do not encode it (FMI.jl, fmi4c): if only the undecoded path exists, it
/// is returned.
///
/// # Errors
/// Returns a [`UriError`] if the URI is not that of a local file.
pub fn path_of(uri: &str) -> Result<PathBuf, UriError> {
    let scheme_end = "file:".len();
    let is_file = uri.get(..scheme_end).is_some_and(|scheme| scheme.eq_ignore_ascii_case("file:"));
    if !is_file {
        return Err(UriError::NotFile { uri: uri.to_owned() });
    }
    let rest = &uri[scheme_end..];
    let path = match rest.strip_prefix("//") {
        // Some importers write two slashes before a drive letter, which is not a host.
        Some(authority) if !authority.starts_with('/') && !begins_with_drive(authority) => {
            let (host, path) = authority.split_at(authority.find('/').unwrap_or(authority.len()));
            if !host.eq_ignore_ascii_case("localhost") {
                return Err(UriError::Remote { uri: uri.to_owned(), host: host.to_owned() });
            }
            path
        }
        Some(path) => path,
        None => rest,
    };
    if !path.starts_with('/') && !begins_with_drive(path) {
        return Err(UriError::NotFile { uri: uri.to_owned() });
    }
    let path = path.trim_start_matches('/').trim_end_matches('/');
    let written = absolute(path);
    match decode(path).map(|path| absolute(&path)) {
        Some(decoded) if decoded.exists() || !written.exists() => Ok(decoded),
        None if !written.exists() => Err(UriError::BadEncoding { uri: uri.to_owned() }),
        _ => Ok(written),
    }
}

fn absolute(path: &str) -> PathBuf {
    if begins_with_drive(path) { PathBuf::from(path) } else { PathBuf::from(format!("/{path}")) }
}

fn begins_with_drive(path: &str) -> bool {
    matches!(path.as_bytes(), [letter, b':', ..] if letter.is_ascii_alphabetic())
}

/// Decodes percent-encoding, such as `%41` for `A`.
fn decode(text: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&first, tail)) = rest.split_first() {
        if first == b'%' {
            let digits = std::str::from_utf8(tail.get(..2)?).ok()?;
            if !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
                return None;
            }
            bytes.push(u8::from_str_radix(digits, 16).ok()?);
            rest = &tail[2..];
        } else {
            bytes.push(first);
            rest = tail;
        }
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parses_all_uri_variants_of_importers() {
        for (uri, path) in [
            ("file:///opt/fmu/resources", "/opt/fmu/resources"),
            ("file:////opt/fmu/resources/", "/opt/fmu/resources"),
            ("file:/opt/fmu/resources/", "/opt/fmu/resources"),
            ("FILE://localhost/opt/r", "/opt/r"),
            ("file:///opt/a%20b/%C3%A4", "/opt/a b/ä"),
            ("file:///C:/Users/me/r", "C:/Users/me/r"),
            ("file:/c%3A/r", "c:/r"),
            ("file://C:/Users/me/r/", "C:/Users/me/r"),
            (r"file:///C:\Users\me\r", r"C:\Users\me\r"),
            ("file:///opt/ä b", "/opt/ä b"),
        ] {
            assert_eq!(path_of(uri), Ok(PathBuf::from(path)), "{uri}");
        }
    }

    #[test]
    fn returns_the_undecoded_path_if_only_that_exists() {
        let folder = tempfile::tempdir().unwrap();
        let found = |name: &str| path_of(&format!("file://{}/{name}", folder.path().display()));
        for name in ["100%", "a%20b", "%zz", "%ff"] {
            std::fs::create_dir(folder.path().join(name)).unwrap();
            assert_eq!(found(name), Ok(folder.path().join(name)), "{name}");
        }
        std::fs::create_dir(folder.path().join("a b")).unwrap();
        assert_eq!(found("a%20b"), Ok(folder.path().join("a b")), "a decoded path comes first");
        assert_eq!(found("no%20file"), Ok(folder.path().join("no file")));
    }

    #[test]
    fn refuses_uris_of_no_local_file() {
        assert!(matches!(path_of("http://a/b"), Err(UriError::NotFile { .. })));
        assert!(matches!(path_of("/opt/r"), Err(UriError::NotFile { .. })));
        assert!(matches!(path_of("file:r"), Err(UriError::NotFile { .. })));
        assert!(matches!(path_of(""), Err(UriError::NotFile { .. })));
        assert!(matches!(path_of("file://server/r"), Err(UriError::Remote { .. })));
        for broken in ["file:///%4", "file:///%zz", "file:///%ff", "file:///%+1"] {
            assert!(matches!(path_of(broken), Err(UriError::BadEncoding { .. })), "{broken}");
        }
    }
}
