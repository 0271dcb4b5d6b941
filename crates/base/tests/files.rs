//! Reading of files, and atomic writing of a set.
#![allow(clippy::unwrap_used, missing_docs)]

use squid_base::files::{Files, check_directory, read};
use std::path::Path;

/// Each message names the file and the remedy; none reports a line 0.
#[test]
fn rejects_files_without_utf8_text() {
    let folder = tempfile::tempdir().unwrap();
    let to = |name: &str| folder.path().join(name);
    std::fs::create_dir_all(to("folder")).unwrap();
    let message = |name: &str| {
        let text = read(&to(name)).unwrap_err().to_string();
        text.strip_prefix(folder.path().to_str().unwrap()).unwrap()[1..].to_owned()
    };
    assert_eq!(message("none"), "none: there is no such file");
    assert_eq!(message("folder"), "folder: this is a folder; it must be a file");
    let utf16: Vec<u8> = "\u{feff}[vehicle]".encode_utf16().flat_map(u16::to_le_bytes).collect();
    std::fs::write(to("utf16"), utf16).unwrap();
    assert_eq!(
        message("utf16"),
        "utf16: the text is not UTF-8 but UTF-16, or no text at all; save the file as UTF-8"
    );
    std::fs::write(to("latin1"), b"[vehicle]\nname = \"caf\xe9\"\n").unwrap();
    assert!(
        message("latin1")
            .starts_with("latin1:2: the text is not UTF-8 but Latin-1 or the like (it holds the byte 0xE9)")
    );
    std::fs::File::create(to("large")).unwrap().set_len(1 << 40).unwrap();
    assert_eq!(message("large"), "large: it has more than 256 MB, the most that is read");
    std::fs::write(to("marked"), "\u{feff}text").unwrap();
    assert_eq!(read(&to("marked")).unwrap(), "text");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("loop", to("loop")).unwrap();
        assert!(
            message("loop").starts_with("loop: this is a link that leads to no file, or back to itself;")
        );
        std::os::unix::fs::symlink("/dev/zero", to("device")).unwrap();
        assert_eq!(message("device"), "device: this is a pipe or a device; it must be a file");
        assert!(std::process::Command::new("mkfifo").arg(to("pipe")).status().unwrap().success());
        assert_eq!(message("pipe"), "pipe: this is a pipe or a device; it must be a file");
    }
}

#[test]
fn checks_a_directory_without_creating_it() {
    let folder = tempfile::tempdir().unwrap();
    let (file, deep) = (folder.path().join("file"), folder.path().join("a").join("b"));
    std::fs::write(&file, "mine").unwrap();
    check_directory(&deep).unwrap();
    check_directory(Path::new("")).unwrap();
    assert!(!deep.parent().unwrap().exists());
    for path in [file.clone(), file.join("deeper")] {
        let message = check_directory(&path).unwrap_err().to_string();
        assert_eq!(
            message,
            format!("{}: cannot be written: it is a file, and a directory is needed here", file.display())
        );
    }
}

#[test]
fn writes_a_set_completely_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let to = |name: &str| folder.path().join(name);
    let set = |first: &str| {
        let mut files = Files::default();
        files.add(to("a"), first);
        files.remove(to("b"));
        files.add(to("c/d"), "2");
        files
    };
    std::fs::write(to("a"), "0").unwrap();
    std::fs::write(to("b"), "0").unwrap();
    std::fs::create_dir_all(to("c/d")).unwrap();
    let message = set("1").save(folder.path()).unwrap_err().to_string();
    assert!(message.contains("it is a directory, and a file is needed here"), "{message}");
    assert_eq!((read(&to("a")).unwrap().as_str(), read(&to("b")).unwrap().as_str()), ("0", "0"));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 4, "a, b, c and the lock");
    std::fs::remove_dir(to("c/d")).unwrap();
    set("1").save(folder.path()).unwrap();
    assert_eq!((read(&to("a")).unwrap().as_str(), read(&to("c/d")).unwrap().as_str()), ("1", "2"));
    assert!(!to("b").exists());
}
