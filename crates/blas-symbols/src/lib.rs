//! The BLAS and LAPACK symbols that clarabel's PSD cone asks for, in pure Rust on faer
