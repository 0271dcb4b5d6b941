//! The symbols of the system's OpenBLAS; only their addresses are taken here, so that they are linked.

#[link(name = "openblas")]
unsafe extern "C" {
    pub(crate) fn dgemm_();
    pub(crate) fn dgemv_();
    pub(crate) fn dsymv_();
    pub(crate) fn dsyrk_();
    pub(crate) fn dsyr2k_();
    pub(crate) fn dpotrf_();
    pub(crate) fn dpotrs_();
    pub(crate) fn dgesv_();
    pub(crate) fn dgesdd_();
    pub(crate) fn dgesvd_();
    pub(crate) fn dsyevr_();
}
