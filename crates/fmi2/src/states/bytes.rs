//! Serialisation of the state of an instance, for `fmi2SerializeFMUstate`.
//!
//! ```text
//! "squidFMU"  version u32  SHA-256 of the GUID  length u64  content  SHA-256 of all preceding bytes
//! ```
//!
//! Numbers are little-endian, so that states are portable between platforms.

use sha2::{Digest, Sha256};

const MAGIC: &[u8; 8] = b"squidFMU";
/// Version of the layout; other versions are refused.
const VERSION: u32 = 2;
const HASH: usize = 32;
const HEAD: usize = MAGIC.len() + 4 + HASH + 8;

/// SHA-256 of the GUID, which identifies the FMU of a state.
pub(crate) type Identity = [u8; HASH];

/// Returns the identity of the FMU with the given GUID.
pub(crate) fn identity(guid: &str) -> Identity {
    Sha256::digest(guid.as_bytes()).into()
}

/// Reason for which bytes are not a state of this FMU.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum StateError {
    /// A number of bytes other than the length in the state.
    #[error("the state has {found} bytes; it must have {expected}")]
    Length { found: usize, expected: u64 },
    /// First bytes other than those of a state of this library.
    #[error("the bytes are not a state written by this FMU")]
    NotAState,
    /// Another version of the layout.
    #[error("the state has version {found}; only version {VERSION} is supported")]
    Version { found: u32 },
    /// The state of another FMU.
    #[error("the state belongs to an FMU with another GUID")]
    OtherFmu,
    /// Bytes that have changed since the state was written.
    #[error("the state is corrupt: its checksum does not match")]
    Damaged,
    /// An undamaged state with inconsistent content.
    #[error("the state is inconsistent: {what}")]
    Inconsistent { what: String },
}

impl StateError {
    /// Creates a [`StateError::Inconsistent`].
    pub fn inconsistent(what: impl std::fmt::Display) -> Self {
        Self::Inconsistent { what: what.to_string() }
    }
}

/// A saved state that is written or read sequentially; the same list of values is used for both.
///
/// # Errors
/// All functions return a [`StateError`] if a state that is read is too short or has an invalid value.
#[allow(clippy::missing_errors_doc, reason = "the same for all")]
pub trait SavedState {
    /// Returns `true` if values are read into the arguments, `false` if the arguments are written.
    fn is_read(&self) -> bool;

    /// Passes a number, bit by bit; a number that is read must be finite.
    fn real(&mut self, value: &mut f64) -> Result<(), StateError>;

    /// Passes an integer.
    fn integer(&mut self, value: &mut u64) -> Result<(), StateError>;

    /// Passes a Boolean.
    fn boolean(&mut self, value: &mut bool) -> Result<(), StateError>;

    /// Passes a text.
    fn text(&mut self, value: &mut String) -> Result<(), StateError>;

    /// Passes numbers; their count is not stored in the state.
    fn reals(&mut self, values: &mut [f64]) -> Result<(), StateError> {
        values.iter_mut().try_for_each(|value| self.real(value))
    }

    /// Passes numbers that are not contiguous.
    fn each(&mut self, values: &mut [&mut f64]) -> Result<(), StateError> {
        values.iter_mut().try_for_each(|value| self.real(value))
    }
}

/// Writer of the values of a state.
#[derive(Debug, Default)]
pub(crate) struct StateWriter {
    bytes: Vec<u8>,
}

impl SavedState for StateWriter {
    fn is_read(&self) -> bool {
        false
    }

    fn real(&mut self, value: &mut f64) -> Result<(), StateError> {
        self.bytes.extend(value.to_le_bytes());
        Ok(())
    }

    fn integer(&mut self, value: &mut u64) -> Result<(), StateError> {
        self.bytes.extend(value.to_le_bytes());
        Ok(())
    }

    fn boolean(&mut self, value: &mut bool) -> Result<(), StateError> {
        self.bytes.push(u8::from(*value));
        Ok(())
    }

    fn text(&mut self, value: &mut String) -> Result<(), StateError> {
        self.integer(&mut (value.len() as u64))?;
        self.bytes.extend(value.as_bytes());
        Ok(())
    }
}

impl StateWriter {
    /// Returns the bytes of a state of the FMU with the given identity.
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

/// Reader of the values of a state, in the order of writing.
#[derive(Debug)]
pub(crate) struct StateReader<'a> {
    rest: &'a [u8],
}

impl<'a> StateReader<'a> {
    /// Checks length, version, identity and checksum of a state, and creates a reader.
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
        let total = content.saturating_add((HEAD + HASH) as u64);
        if total != bytes.len() as u64 {
            return Err(length(total));
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

    /// Checks that all bytes were read.
    pub(crate) fn finish(self) -> Result<(), StateError> {
        match self.rest.len() {
            0 => Ok(()),
            left => Err(StateError::inconsistent(format_args!("it has {left} surplus bytes"))),
        }
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], StateError> {
        let taken = self.take(N)?;
        taken.try_into().map_err(StateError::inconsistent)
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], StateError> {
        let Some((taken, rest)) = self.rest.split_at_checked(count) else {
            return Err(StateError::inconsistent(format_args!("it ends {count} bytes too early")));
        };
        self.rest = rest;
        Ok(taken)
    }
}

impl SavedState for StateReader<'_> {
    fn is_read(&self) -> bool {
        true
    }

    fn real(&mut self, value: &mut f64) -> Result<(), StateError> {
        *value = f64::from_le_bytes(self.array()?);
        if value.is_finite() {
            return Ok(());
        }
        Err(StateError::inconsistent(format_args!("it contains the number {value}")))
    }

    fn integer(&mut self, value: &mut u64) -> Result<(), StateError> {
        *value = u64::from_le_bytes(self.array()?);
        Ok(())
    }

    fn boolean(&mut self, value: &mut bool) -> Result<(), StateError> {
        *value = match self.array()? {
            [0] => false,
            [1] => true,
            [other] => return Err(StateError::inconsistent(format_args!("the boolean {other}"))),
        };
        Ok(())
    }

    fn text(&mut self, value: &mut String) -> Result<(), StateError> {
        let mut length = 0;
        self.integer(&mut length)?;
        let bytes = self.take(usize::try_from(length).unwrap_or(usize::MAX))?.to_vec();
        *value = String::from_utf8(bytes).map_err(StateError::inconsistent)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sealed() -> Vec<u8> {
        let mut writer = StateWriter::default();
        pass(&mut writer, &mut (-0.0, 7, true, "Äther".to_owned())).unwrap();
        writer.sealed(&identity("{a}"))
    }

    type Values = (f64, u64, bool, String);

    fn pass(state: &mut dyn SavedState, values: &mut Values) -> Result<(), StateError> {
        state.real(&mut values.0)?;
        state.integer(&mut values.1)?;
        state.boolean(&mut values.2)?;
        state.text(&mut values.3)
    }

    #[test]
    fn reads_the_values_that_were_written() {
        let bytes = sealed();
        let mut reader = StateReader::unsealed(&bytes, &identity("{a}")).unwrap();
        let mut values = Values::default();
        pass(&mut reader, &mut values).unwrap();
        assert_eq!(values.0.to_bits(), (-0.0f64).to_bits());
        assert_eq!((values.1, values.2, values.3.as_str()), (7, true, "Äther"));
        reader.finish().unwrap();
    }

    #[test]
    fn refuses_every_changed_bit_and_every_truncation() {
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
    fn reports_missing_and_remaining_bytes() {
        let bytes = StateWriter::default().sealed(&identity(""));
        let mut reader = StateReader::unsealed(&bytes, &identity("")).unwrap();
        let missing = reader.real(&mut 0.0).unwrap_err();
        let mut writer = StateWriter::default();
        writer.integer(&mut u64::MAX.clone()).unwrap();
        let bytes = writer.sealed(&identity(""));
        assert!(StateReader::unsealed(&bytes, &identity("")).unwrap().text(&mut String::new()).is_err());
        let left = StateReader::unsealed(&bytes, &identity("")).unwrap().finish().unwrap_err();
        for error in [&missing, &left] {
            assert!(matches!(error, StateError::Inconsistent { .. }), "{error}");
        }
        insta::assert_snapshot!(format!("{missing}\n{left}"));
    }
}
