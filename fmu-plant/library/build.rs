//! Names the library as macOS asks for.

fn main() {
    squid_library_name::set_install_name();
}
