//! The platforms that an FMU may carry a binary for, and where cargo puts each.

use crate::error::Error;
use crate::kind::Kind;
use std::env::consts::{ARCH, DLL_PREFIX, DLL_SUFFIX, OS};
use std::path::{Path, PathBuf};

/// A platform of FMI 2.0.4 (section 2.3): the folder below `binaries/`, and its name in Rust.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Platform {
    /// Name of the folder in the FMU.
    pub folder: &'static str,
    /// Target triple; of the platform of this program itself, none: cargo then names no folder after it.
    pub triple: Option<&'static str>,
    prefix: &'static str,
    suffix: &'static str,
}

/// The platforms of `--platforms all`.
const ALL: [Platform; 4] = [
    Platform { folder: "linux64", triple: Some("x86_64-unknown-linux-gnu"), prefix: "lib", suffix: ".so" },
    Platform { folder: "win64", triple: Some("x86_64-pc-windows-gnu"), prefix: "", suffix: ".dll" },
    // A separate folder: a tool on x86-64 loads whatever is in linux64.
    Platform {
        folder: "aarch64-linux",
        triple: Some("aarch64-unknown-linux-gnu"),
        prefix: "lib",
        suffix: ".so",
    },
    // One library with both processors in it: tools on both look in this folder. The name is cargo-zigbuild's.
    Platform { folder: "darwin64", triple: Some("universal2-apple-darwin"), prefix: "lib", suffix: ".dylib" },
];

impl Platform {
    /// The platforms that a command line names: `host`, `all`, or folder names of FMI, each once.
    ///
    /// # Errors
    /// [`Error::Platform`] when FMI has no name for this program's own platform, [`Error::UnknownPlatform`].
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

    /// Every platform, this program's own first.
    pub fn every() -> Vec<Self> {
        let named = |names: &[&str]| Self::named(&names.iter().map(|&name| name.into()).collect::<Vec<_>>());
        named(&["host", "all"]).unwrap_or_else(|_| ALL.to_vec())
    }

    /// The platform that this program was built for.
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

    /// Path of the binary inside the FMU.
    pub fn entry(self, identifier: &str) -> String {
        format!("binaries/{}/{identifier}{}", self.folder, self.suffix)
    }

    /// Looks for the shared library in `binaries`; or beside this program as cargo lays it out, and then in `target` of
    /// the working directory, for a program that is installed elsewhere. That of this program's own platform may have
    /// been built with the name of the platform or without it; the newest is taken.
    ///
    /// For another platform than this program's, it is in a folder named for the platform below `binaries`.
    ///
    /// # Errors
    /// [`Error::NoBinary`].
    pub fn find(self, kind: Kind, binaries: Option<&Path>) -> Result<PathBuf, Error> {
        let library = format!("{}{}{}", self.prefix, kind.library().replace('-', "_"), self.suffix);
        let beside = std::env::current_exe().ok().and_then(|exe| Some(exe.parent()?.to_path_buf()));
        let targets = beside.iter().map(|beside| beside.join("..")).chain([PathBuf::from("target")]);
        let places: Vec<PathBuf> = match (binaries, self.triple) {
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
        newest(&places, &library).ok_or_else(|| Error::NoBinary {
            places: places.iter().map(|p| p.display().to_string()).collect::<Vec<_>>().join(", "),
            how: self.how(kind),
            library,
        })
    }

    /// The command that builds the shared library.
    fn how(self, kind: Kind) -> String {
        let words = format!("build --profile fmu -p {}", kind.library());
        match self.triple {
            None => format!("cargo {words}"),
            Some(triple) => format!("cargo-zigbuild {words} --target {triple}"),
        }
    }
}

/// The file of this name in these places that was written last.
fn newest(places: &[PathBuf], name: &str) -> Option<PathBuf> {
    let there = places.iter().map(|place| place.join(name)).filter(|path| path.is_file());
    there.max_by_key(|path| path.metadata().and_then(|found| found.modified()).ok())
}

fn unknown(name: &str) -> Error {
    let folders: Vec<&str> = ALL.iter().map(|p| p.folder).collect();
    Error::UnknownPlatform {
        found: format!("'{name}'"),
        allowed: format!("host, all, or some of {}", folders.join(", ")),
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
    fn each_platform_is_taken_once() {
        assert_eq!(folders(&["all"]), ["linux64", "win64", "aarch64-linux", "darwin64"]);
        assert_eq!(folders(&["win64", "all"]), ["win64", "linux64", "aarch64-linux", "darwin64"]);
        assert_eq!(folders(&["host"]).len(), 1);
    }

    #[test]
    fn an_unknown_platform_is_told_what_is_known() {
        let message = Platform::named(&["linux".into()]).unwrap_err().to_string();
        assert_eq!(
            message,
            "the platform is 'linux'; it must be host, all, or some of linux64, win64, aarch64-linux, darwin64"
        );
    }

    #[test]
    fn of_two_builds_the_newest_is_packed() {
        let folder = tempfile::tempdir().unwrap();
        let places =
            ["fmu", "x86_64-unknown-linux-gnu/fmu", "nowhere"].map(|place| folder.path().join(place));
        let name = "libsquid_fmu_plant_library.so";
        let [one, other] = [&places[0], &places[1]].map(|place| {
            std::fs::create_dir_all(place).unwrap();
            std::fs::File::create(place.join(name)).unwrap()
        });
        let now = std::time::SystemTime::now();
        let earlier = now - std::time::Duration::from_secs(60);
        for (first, second, expected) in [(now, earlier, &places[0]), (earlier, now, &places[1])] {
            one.set_modified(first).unwrap();
            other.set_modified(second).unwrap();
            assert_eq!(newest(&places, name), Some(expected.join(name)));
        }
        assert_eq!(newest(&places, "libsquid_fmu_loop_library.so"), None);
    }

    #[test]
    fn a_missing_binary_says_how_to_build_it() {
        let empty = tempfile::tempdir().unwrap();
        let [.., arm, _] = ALL;
        let message = arm.find(Kind::Squid, Some(empty.path())).unwrap_err().to_string();
        assert!(message.contains("libsquid_fmu_loop_library.so is not in"), "{message}");
        assert!(
            message.contains("-p squid-fmu-loop-library --target aarch64-unknown-linux-gnu"),
            "{message}"
        );
    }
}
