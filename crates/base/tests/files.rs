//! Reading of files, and atomic writing of a set.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

use squid_base::files::{Error, Files, check_directory, read};
use std::io::ErrorKind;
use std::path::Path;

/// Each message names the file and the remedy; none reports a line 0.
#[test]
fn rejects_files_without_utf8_text() {
    let folder = tempfile::tempdir().unwrap();
    let to = |name: &str| folder.path().join(name);
    std::fs::create_dir_all(to("folder")).unwrap();
    let utf16: Vec<u8> = "\u{feff}[vehicle]".encode_utf16().flat_map(u16::to_le_bytes).collect();
    std::fs::write(to("utf16"), utf16).unwrap();
    std::fs::write(to("latin1"), b"[vehicle]\nname = \"caf\xe9\"\n").unwrap();
    std::fs::File::create(to("large")).unwrap().set_len(1 << 40).unwrap();
    std::fs::write(to("marked"), "\u{feff}text").unwrap();
    assert_eq!(read(&to("marked")).unwrap(), "text");
    let mut cases = vec![
        ("none", "not_found"),
        ("folder", "folder"),
        ("utf16", "encoding"),
        ("latin1", "encoding"),
        ("large", "large"),
    ];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("loop", to("loop")).unwrap();
        std::os::unix::fs::symlink("/dev/zero", to("device")).unwrap();
        assert!(std::process::Command::new("mkfifo").arg(to("pipe")).status().unwrap().success());
        cases.extend([("loop", "link"), ("device", "special"), ("pipe", "special")]);
    }
    let mut messages = vec![];
    for (name, kind) in cases {
        let error = read(&to(name)).unwrap_err();
        assert_eq!(<&str>::from(&error), kind, "{error}");
        let message = error.to_string();
        messages.push(message.strip_prefix(folder.path().to_str().unwrap()).unwrap()[1..].to_owned());
    }
    #[cfg(unix)]
    insta::assert_snapshot!(messages.join("\n"));
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
        let error = check_directory(&path).unwrap_err();
        let Error::Unwritable { path, reason } = &error else { panic!("{error}") };
        assert_eq!((Path::new(path), reason.kind()), (file.as_path(), ErrorKind::NotADirectory));
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
    let error = set("1").save(folder.path()).unwrap_err();
    assert!(
        matches!(&error, Error::Unwritable { reason, .. } if reason.kind() == ErrorKind::IsADirectory),
        "{error}"
    );
    assert_eq!((read(&to("a")).unwrap().as_str(), read(&to("b")).unwrap().as_str()), ("0", "0"));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3, "a, b and c");
    std::fs::remove_dir(to("c/d")).unwrap();
    set("1").save(folder.path()).unwrap();
    assert_eq!((read(&to("a")).unwrap().as_str(), read(&to("c/d")).unwrap().as_str()), ("1", "2"));
    assert!(!to("b").exists());
}

/// A set that cannot be written leaves neither folders nor a lock, but an earlier lock stays: others may wait for it.
#[test]
fn leaves_nothing_of_a_set_that_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let to = |name: &str| folder.path().join(name);
    std::fs::create_dir(to("blocked")).unwrap();
    let set = |first: &str, last: &str| {
        let mut files = Files::default();
        files.add(to(first), "1");
        files.add(to(last), "2");
        files
    };
    for directory in ["new", "new/deeper"] {
        set("new/deeper/still/a", "blocked").save(&to(directory)).unwrap_err();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "only the folder `blocked`");
    }
    set("there/a", "there/b").save(&to("there")).unwrap();
    set("there/a", "blocked").save(&to("there")).unwrap_err();
    let mut left: Vec<_> =
        std::fs::read_dir(to("there")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    left.sort();
    assert_eq!(left, [".squid-lock", "a", "b"]);
}

/// Writers that wait for a lock that is removed meanwhile still exclude one another.
#[cfg(unix)]
#[test]
fn writers_exclude_one_another_while_sets_fail() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("shared");
    std::fs::create_dir(folder.path().join("blocked")).unwrap();
    let write = |writer: usize| {
        for round in 0..40 {
            let text = format!("{writer} {round}");
            let mut files = Files::default();
            files.add(directory.join("a"), text.clone());
            if (writer + round).is_multiple_of(2) {
                files.add(folder.path().join("blocked"), "never");
                files.save(&directory).unwrap_err();
            } else {
                files.add(directory.join("b"), text);
                files.save(&directory).unwrap();
                let _lock = squid_base::files::reading(&directory.join("b"));
                assert_eq!(read(&directory.join("a")).unwrap(), read(&directory.join("b")).unwrap());
            }
        }
    };
    std::thread::scope(|scope| (0..4).for_each(|writer| _ = scope.spawn(move || write(writer))));
}
