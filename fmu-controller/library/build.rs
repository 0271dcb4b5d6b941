//! Sets the install name of the library, which macOS requires.

fn main() {
    squid_library_name::set_install_name();
}
