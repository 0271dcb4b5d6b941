//! Platforms for which an FMU may contain a binary, and the directories in which cargo writes it.

use crate::error::Error;
use crate::kind::Kind;
use std::env::consts::{ARCH, DLL_PREFIX, DLL_SUFFIX, OS};
use std::path::{Path, PathBuf};

/// A platform of FMI 2.0.4 (section 2.3): the folder below `binaries/`, and its name in Rust.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Platform {
    /// Name of the folder in the FMU.
    pub folder: &'static str,
    /// Target triple; `None` for the platform of this program, for which cargo uses no folder of that name.
    pub triple: Option<&'static str>,
    prefix: &'static str,
    suffix: &'static str,
}

/// Platforms of `--platforms all`.
const ALL: [Platform; 4] = [
    Platform { folder: "linux64", triple: Some("x86_64-unknown-linux-gnu"), prefix: "lib", suffix: ".so" },
    Platform { folder: "win64", triple: Some("x86_64-pc-windows-gnu"), prefix: "", suffix: ".dll" },
    // A separate folder, because a tool on x86-64 loads whatever is in linux64.
    Platform {
        folder: "aarch64-linux",
        triple: Some("aarch64-unknown-linux-gnu"),
        prefix: "lib",
        suffix: ".so",
    },
    // One universal library for both processors, whose tools look in the same folder. The name is cargo-zigbuild's.
    Platform { folder: "darwin64", triple: Some("universal2-apple-darwin"), prefix: "lib", suffix: ".dylib" },
];

impl Platform {
    /// Returns the platforms named on a command line: `host`, `all`, or folder names of FMI, without duplicates.
    ///
    /// # Errors
    /// [`Error::Platform`] if FMI has no name for the platform of this program, [`Error::UnknownPlatform`].
    pub fn named(names: &[String]) -> Result<Vec<Self>, Error> {
        let mut platforms: Vec<Self> = Vec::new();
        for name in names {
            let more = match name.as_str() {
                "host" => vec![Self::host()?],
                "all" => ALL.to_vec(),
                other => vec![*ALL.iter().find(|p| p.folder == other).ok_or_else(|| unknown(other))?],
            };
            for platform in more {
                if !platforms.iter().any(|one| one.folder == platform.folder) {
                    platforms.push(platform);
                }
            }
        }
        Ok(platforms)
    }

    /// Returns all platforms, that of this program first.
    pub fn every() -> Vec<Self> {
        let named = |names: &[&str]| Self::named(&names.iter().map(|&name| name.into()).collect::<Vec<_>>());
        named(&["host", "all"]).unwrap_or_else(|_| ALL.to_vec())
    }

    /// Returns the platform of this program.
    fn host() -> Result<Self, Error> {
        let folder = match (OS, ARCH) {
            ("linux", "x86_64") => "linux64",
            ("linux", "aarch64") => "aarch64-linux",
            ("windows", "x86_64") => "win64",
            ("macos", "x86_64") => "darwin64",
            ("macos", "aarch64") => "aarch64-darwin",
            _ => return Err(Error::Platform { os: OS, arch: ARCH }),
        };
        Ok(Self { folder, triple: None, prefix: DLL_PREFIX, suffix: DLL_SUFFIX })
    }

    /// Returns the path of the binary inside the FMU.
    pub fn entry(self, identifier: &str) -> String {
        format!("binaries/{}/{identifier}{}", self.folder, self.suffix)
    }

    /// Finds the shared library in `binaries`, or by default in cargo's layout relative to this program, then in
    /// `target` of the working directory (for an installed program). For the platform of this program, a build with or
    /// without the target triple is accepted; the newest is used.
    ///
    /// For another platform, the library is in a folder named for the platform below `binaries`.
    ///
    /// # Errors
    /// [`Error::NoBinary`].
    pub fn find(self, kind: Kind, binaries: Option<&Path>) -> Result<PathBuf, Error> {
        let library = format!("{}{}{}", self.prefix, kind.library().replace('-', "_"), self.suffix);
        let beside = std::env::current_exe().ok().and_then(|exe| Some(exe.parent()?.to_path_buf()));
        let targets = beside.iter().map(|beside| beside.join("..")).chain([PathBuf::from("target")]);
        let directories: Vec<PathBuf> = match (binaries, self.triple) {
            (Some(directory), None) => vec![directory.to_path_buf()],
            (Some(directory), Some(_)) => vec![directory.join(self.folder)],
            (None, None) => {
                let unpacked = beside.iter().map(|beside| beside.join("fmu"));
                let own = ALL.iter().find(|one| one.folder == self.folder).and_then(|one| one.triple);
                let built = targets.flat_map(|target| {
                    let named = own.map(|triple| target.join(triple).join("fmu"));
                    named.into_iter().chain([target.join("fmu")])
                });
                unpacked.chain(built).collect()
            }
            (None, Some(triple)) => targets.map(|target| target.join(triple).join("fmu")).collect(),
        };
        newest(&directories, &library).ok_or_else(|| Error::NoBinary {
            places: directories.iter().map(|p| p.display().to_string()).collect::<Vec<_>>().join(", "),
            how: self.how(kind),
            library,
        })
    }

    /// Returns the command that builds the shared library.
    fn how(self, kind: Kind) -> String {
        let arguments = format!("build --profile fmu -p {}", kind.library());
        match self.triple {
            None => format!("cargo {arguments}"),
            Some(triple) => format!("cargo-zigbuild {arguments} --target {triple}"),
        }
    }
}

/// Returns the newest file of this name in the given directories.
fn newest(directories: &[PathBuf], name: &str) -> Option<PathBuf> {
    let found = directories.iter().map(|directory| directory.join(name)).filter(|path| path.is_file());
    found.max_by_key(|path| path.metadata().and_then(|metadata| metadata.modified()).ok())
}

fn unknown(name: &str) -> Error {
    let folders: Vec<&str> = ALL.iter().map(|p| p.folder).collect();
    Error::UnknownPlatform {
        found: format!("'{name}'"),
        allowed: format!("host, all, or a list of {}", folders.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folders(names: &[&str]) -> Vec<&'static str> {
        let names: Vec<String> = names.iter().map(|&name| name.to_owned()).collect();
        Platform::named(&names).unwrap().iter().map(|p| p.folder).collect()
    }

    #[test]
    fn removes_duplicate_platforms() {
        assert_eq!(folders(&["all"]), ["linux64", "win64", "aarch64-linux", "darwin64"]);
        assert_eq!(folders(&["win64", "all"]), ["win64", "linux64", "aarch64-linux", "darwin64"]);
        assert_eq!(folders(&["host"]).len(), 1);
    }

    #[test]
    fn message_lists_known_platforms() {
        let error = Platform::named(&["linux".into()]).unwrap_err();
        assert!(matches!(&error, Error::UnknownPlatform { found, .. } if found == "'linux'"), "{error}");
        insta::assert_snapshot!(error);
    }

    #[test]
    fn finds_newest_of_two_builds() {
        let folder = tempfile::tempdir().unwrap();
        let directories =
            ["fmu", "x86_64-unknown-linux-gnu/fmu", "nowhere"].map(|directory| folder.path().join(directory));
        let name = "libsquid_fmu_plant_library.so";
        let [one, other] = [&directories[0], &directories[1]].map(|directory| {
            std::fs::create_dir_all(directory).unwrap();
            std::fs::File::create(directory.join(name)).unwrap()
        });
        let now = std::time::SystemTime::now();
        let earlier = now - std::time::Duration::from_secs(60);
        for (first, second, expected) in [(now, earlier, &directories[0]), (earlier, now, &directories[1])] {
            one.set_modified(first).unwrap();
            other.set_modified(second).unwrap();
            assert_eq!(newest(&directories, name), Some(expected.join(name)));
        }
        assert_eq!(newest(&directories, "libsquid_fmu_loop_library.so"), None);
    }

    #[test]
    fn message_says_how_to_build_missing_binary() {
        let empty = tempfile::tempdir().unwrap();
        let [.., arm, _] = ALL;
        let error = arm.find(Kind::Squid, Some(empty.path())).unwrap_err();
        let Error::NoBinary { library, how, places } = &error else { panic!("{error}") };
        assert_eq!(library, "libsquid_fmu_loop_library.so");
        assert_eq!(Path::new(places), empty.path().join("aarch64-linux"));
        assert!(how.ends_with("-p squid-fmu-loop-library --target aarch64-unknown-linux-gnu"), "{how}");
    }
}
