//! The state of an instance as bytes, for `fmi2SerializeFMUstate`.
//!
//! ```text
//! "squidFMU"  version u32  SHA-256 of the GUID  length u64  content  SHA-256 of all that
//! ```
//!
//! Numbers are little-endian, so that a state is portable between platforms.

use sha2::{Digest, Sha256};

const MAGIC: &[u8; 8] = b"squidFMU";
/// Version of the layout; another one is refused.
const VERSION: u32 = 2;
const HASH: usize = 32;
const HEAD: usize = MAGIC.len() + 4 + HASH + 8;

/// SHA-256 of the GUID: which FMU a state belongs to.
pub(crate) type Identity = [u8; HASH];

/// The identity of the FMU with the given GUID.
pub(crate) fn identity(guid: &str) -> Identity {
    Sha256::digest(guid.as_bytes()).into()
}

/// Why bytes are not a state of this FMU.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum StateError {
    /// Fewer or more bytes than the length in the state.
    #[error("the state has {found} bytes, but should have {expected}")]
    Length { found: usize, expected: u64 },
    /// The first bytes are not those of a state of this library.
    #[error("the bytes are no state that this tool has written")]
    NotAState,
    /// Another version of the layout.
    #[error("the state has version {found}, but only version {VERSION} can be read")]
    Version { found: u32 },
    /// The state of another FMU.
    #[error("the state belongs to an FMU with another GUID")]
    OtherFmu,
    /// Bytes have changed since the state was written.
    #[error("the state is damaged: its checksum does not fit")]
    Damaged,
    /// An intact state whose content is inconsistent.
    #[error("the state is inconsistent: {what}")]
    Inconsistent { what: String },
}

impl StateError {
    /// An [`StateError::Inconsistent`].
    pub fn inconsistent(what: impl std::fmt::Display) -> Self {
        Self::Inconsistent { what: what.to_string() }
    }
}

/// Writes the numbers of a state.
#[derive(Debug, Default)]
pub struct StateWriter {
    bytes: Vec<u8>,
}

impl StateWriter {
    /// Adds a number, bit by bit.
    pub fn real(&mut self, value: f64) {
        self.bytes.extend(value.to_le_bytes());
    }

    /// Adds numbers; their count is not written.
    pub fn reals(&mut self, values: &[f64]) {
        values.iter().for_each(|&value| self.real(value));
    }

    /// Adds a whole number.
    pub fn integer(&mut self, value: u64) {
        self.bytes.extend(value.to_le_bytes());
    }

    /// Adds a truth value.
    pub fn boolean(&mut self, value: bool) {
        self.bytes.push(u8::from(value));
    }

    /// Adds a text.
    pub fn text(&mut self, value: &str) {
        self.integer(value.len() as u64);
        self.bytes.extend(value.as_bytes());
    }

    /// The bytes of a state of the FMU with the given identity.
    pub(crate) fn sealed(self, identity: &Identity) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(HEAD + self.bytes.len() + HASH);
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(identity);
        bytes.extend((self.bytes.len() as u64).to_le_bytes());
        bytes.extend(&self.bytes);
        let checksum: [u8; HASH] = Sha256::digest(&bytes).into();
        bytes.extend(checksum);
        bytes
    }
}

/// Reads the numbers of a state in the order in which they were written.
#[derive(Debug)]
pub struct StateReader<'a> {
    rest: &'a [u8],
}

impl<'a> StateReader<'a> {
    /// Checks length, version, identity and checksum of a state and opens it.
    pub(crate) fn unsealed(bytes: &'a [u8], expected: &Identity) -> Result<Self, StateError> {
        let length = |expected| StateError::Length { found: bytes.len(), expected };
        let Some((head, body)) = bytes.split_at_checked(HEAD) else {
            return Err(length((HEAD + HASH) as u64));
        };
        let mut head = Self { rest: head };
        if head.take(MAGIC.len())? != MAGIC {
            return Err(StateError::NotAState);
        }
        let version = u32::from_le_bytes(head.array()?);
        if version != VERSION {
            return Err(StateError::Version { found: version });
        }
        let identity: Identity = head.array()?;
        let content = u64::from_le_bytes(head.array()?);
        let whole = content.saturating_add((HEAD + HASH) as u64);
        if whole != bytes.len() as u64 {
            return Err(length(whole));
        }
        let (content, checksum) = body.split_at(body.len() - HASH);
        let computed: [u8; HASH] = Sha256::digest(&bytes[..bytes.len() - HASH]).into();
        if computed != *checksum {
            return Err(StateError::Damaged);
        }
        if identity != *expected {
            return Err(StateError::OtherFmu);
        }
        Ok(Self { rest: content })
    }

    /// Reads a number.
    ///
    /// # Errors
    /// [`StateError`]: the state ends here, as for the other functions.
    pub fn real(&mut self) -> Result<f64, StateError> {
        self.array().map(f64::from_le_bytes)
    }

    /// Reads a number that must be finite.
    ///
    /// # Errors
    /// [`StateError::Inconsistent`].
    pub fn finite(&mut self) -> Result<f64, StateError> {
        let value = self.real()?;
        if value.is_finite() {
            return Ok(value);
        }
        Err(StateError::inconsistent(format_args!("it holds the number {value}")))
    }

    /// Reads as many finite numbers as the slice has room for.
    ///
    /// # Errors
    /// [`StateError::Inconsistent`].
    pub fn reals(&mut self, values: &mut [f64]) -> Result<(), StateError> {
        for value in values {
            *value = self.finite()?;
        }
        Ok(())
    }

    /// Reads a whole number.
    ///
    /// # Errors
    /// As [`StateReader::real`].
    pub fn integer(&mut self) -> Result<u64, StateError> {
        self.array().map(u64::from_le_bytes)
    }

    /// Reads a truth value.
    ///
    /// # Errors
    /// [`StateError::Inconsistent`].
    pub fn boolean(&mut self) -> Result<bool, StateError> {
        match self.array()? {
            [0] => Ok(false),
            [1] => Ok(true),
            [other] => Err(StateError::inconsistent(format_args!("the truth value {other}"))),
        }
    }

    /// Reads a text.
    ///
    /// # Errors
    /// [`StateError::Inconsistent`].
    pub fn text(&mut self) -> Result<String, StateError> {
        let length = usize::try_from(self.integer()?).unwrap_or(usize::MAX);
        let bytes = self.take(length)?.to_vec();
        String::from_utf8(bytes).map_err(StateError::inconsistent)
    }

    /// Checks that everything was read.
    pub(crate) fn finish(self) -> Result<(), StateError> {
        match self.rest.len() {
            0 => Ok(()),
            left => Err(StateError::inconsistent(format_args!("{left} bytes are left over"))),
        }
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], StateError> {
        let taken = self.take(N)?;
        taken.try_into().map_err(StateError::inconsistent)
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], StateError> {
        let Some((taken, rest)) = self.rest.split_at_checked(count) else {
            return Err(StateError::inconsistent(format_args!("{count} more bytes are missing")));
        };
        self.rest = rest;
        Ok(taken)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sealed() -> Vec<u8> {
        let mut writer = StateWriter::default();
        writer.real(-0.0);
        writer.integer(7);
        writer.boolean(true);
        writer.text("Äther");
        writer.sealed(&identity("{a}"))
    }

    #[test]
    fn reads_back_what_was_written() {
        let bytes = sealed();
        let mut reader = StateReader::unsealed(&bytes, &identity("{a}")).unwrap();
        assert_eq!(reader.real().unwrap().to_bits(), (-0.0f64).to_bits());
        assert_eq!(reader.integer().unwrap(), 7);
        assert!(reader.boolean().unwrap());
        assert_eq!(reader.text().unwrap(), "Äther");
        reader.finish().unwrap();
    }

    #[test]
    fn refuses_every_changed_bit_and_every_cut() {
        let bytes = sealed();
        for bit in 0..8 * bytes.len() {
            let mut changed = bytes.clone();
            changed[bit / 8] ^= 1 << (bit % 8);
            assert!(StateReader::unsealed(&changed, &identity("{a}")).is_err(), "bit {bit}");
        }
        for length in 0..bytes.len() {
            assert!(StateReader::unsealed(&bytes[..length], &identity("{a}")).is_err(), "{length} bytes");
        }
        let refused = StateReader::unsealed(&bytes, &identity("{b}")).unwrap_err();
        assert_eq!(refused, StateError::OtherFmu);
    }

    #[test]
    fn a_reader_that_asks_for_more_is_told_so() {
        let bytes = StateWriter::default().sealed(&identity(""));
        let mut reader = StateReader::unsealed(&bytes, &identity("")).unwrap();
        assert!(reader.real().unwrap_err().to_string().contains("8 more bytes are missing"));
        let mut writer = StateWriter::default();
        writer.integer(u64::MAX);
        let bytes = writer.sealed(&identity(""));
        assert!(StateReader::unsealed(&bytes, &identity("")).unwrap().text().is_err());
        let left = StateReader::unsealed(&bytes, &identity("")).unwrap().finish().unwrap_err();
        assert!(left.to_string().contains("8 bytes are left over"));
    }
}
