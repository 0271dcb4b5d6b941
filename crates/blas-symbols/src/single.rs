//! Symbols in single precision, which Clarabel also references: linkers for Windows reject undefined symbols.

macro_rules! never_called {
    ($($name:ident)*) => {$(
        #[unsafe(no_mangle)]
        extern "C" fn $name() -> ! {
            unreachable!("Clarabel is called in double precision alone")
        }
    )*};
}

never_called! {
    sgemm_ sgemv_ ssymv_ ssyrk_ ssyr2k_ spotrf_ spotrs_ sgesv_ sgesdd_ sgesvd_ ssyevr_
}
