//! The floating-point environment (C11, section 7.6): every call computes in the default environment.
//!
//! An importer may round upwards, trap overflow or division by zero, or flush subnormal numbers. Rust code requires the
//! default environment, and a different rounding of numbers in the resources would change the GUID.

#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
use std::arch::asm;

/// Runs `work` with rounding to nearest, without traps and with subnormal numbers, then restores the environment of the
/// importer.
pub(crate) fn in_default<T>(work: impl FnOnce() -> T) -> T {
    let _restored = Importers::replaced();
    apart(work)
}

/// Runs `work` without inlining, so that none of its arithmetic moves out of the default environment.
#[inline(never)]
fn apart<T>(work: impl FnOnce() -> T) -> T {
    work()
}

/// The environment of the importer, restored on drop.
#[cfg(target_arch = "x86_64")]
struct Importers {
    mxcsr: u32,
    /// Environment of the x87 unit, if its control word is not the default: some C libraries for Windows compute
    /// with it.
    x87: Option<[u32; 7]>,
}

#[cfg(target_arch = "x86_64")]
impl Importers {
    const DEFAULT_MXCSR: u32 = 0x1f80;
    const DEFAULT_X87: u16 = 0x037f;

    fn replaced() -> Self {
        let (mut mxcsr, mut control) = (0_u32, 0_u16);
        // SAFETY: the operands have the sizes that the instructions read and write; the resulting environment is the
        // one that Rust requires.
        unsafe {
            asm!("stmxcsr [{}]", in(reg) &raw mut mxcsr, options(nostack));
            asm!("fnstcw [{}]", in(reg) &raw mut control, options(nostack));
            asm!("ldmxcsr [{}]", in(reg) &Self::DEFAULT_MXCSR, options(nostack));
        }
        let x87 = (control != Self::DEFAULT_X87).then(|| {
            let mut environment = [0; 7];
            // SAFETY: as above; fnstenv writes 28 bytes.
            unsafe {
                asm!("fnstenv [{}]", in(reg) &raw mut environment, options(nostack));
                asm!("fldcw [{}]", in(reg) &Self::DEFAULT_X87, options(nostack));
            }
            environment
        });
        Self { mxcsr, x87 }
    }
}

#[cfg(target_arch = "x86_64")]
impl Drop for Importers {
    fn drop(&mut self) {
        // SAFETY: the importer had this environment when it called; no arithmetic follows before the return to it.
        unsafe {
            if let Some(environment) = &self.x87 {
                asm!("fldenv [{}]", in(reg) environment, options(nostack));
            }
            asm!("ldmxcsr [{}]", in(reg) &raw const self.mxcsr, options(nostack));
        }
    }
}

/// The environment of the importer, restored on drop.
#[cfg(target_arch = "aarch64")]
struct Importers {
    control: u64,
    status: u64,
}

#[cfg(target_arch = "aarch64")]
impl Importers {
    fn replaced() -> Self {
        let (control, status);
        // SAFETY: zero in the control register is the environment that Rust requires.
        unsafe {
            asm!("mrs {}, fpcr", out(reg) control, options(nostack));
            asm!("mrs {}, fpsr", out(reg) status, options(nostack));
            asm!("msr fpcr, xzr", options(nostack));
        }
        Self { control, status }
    }
}

#[cfg(target_arch = "aarch64")]
impl Drop for Importers {
    fn drop(&mut self) {
        // SAFETY: the importer had this environment when it called; no arithmetic follows before the return to it.
        unsafe {
            asm!("msr fpsr, {}", in(reg) self.status, options(nostack));
            asm!("msr fpcr, {}", in(reg) self.control, options(nostack));
        }
    }
}

/// The environment on processors for which no FMUs are built; it is left unchanged.
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
struct Importers;

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
impl Importers {
    fn replaced() -> Self {
        Self
    }
}
