//! `fmi2GetFMUstate` to `fmi2DeSerializeFMUstate` (section 2.1.8).

use crate::{Function, Instance, Model, Refusal, Snapshot};

impl<M: Model> Instance<M> {
    /// `fmi2GetFMUstate`.
    ///
    /// # Errors
    /// [`Refusal::IllegalCall`].
    pub fn snapshot(&self) -> Result<Snapshot<M>, Refusal> {
        self.allows(Function::GetFmuState)?;
        Ok(self.now.clone())
    }

    /// `fmi2SetFMUstate`.
    ///
    /// # Errors
    /// [`Refusal::IllegalCall`], [`Refusal::ForeignState`], [`Refusal::OtherInterfaceState`].
    pub fn restore(&mut self, snapshot: &Snapshot<M>) -> Result<(), Refusal> {
        self.allows(Function::SetFmuState)?;
        self.accepts(snapshot)?;
        self.now = snapshot.clone();
        Ok(())
    }

    /// `fmi2SerializeFMUstate`.
    ///
    /// # Errors
    /// [`Refusal::IllegalCall`], [`Refusal::ForeignState`].
    pub fn serialise(&self, snapshot: &Snapshot<M>) -> Result<Vec<u8>, Refusal> {
        self.allows(Function::SerializeFmuState)?;
        self.accepts(snapshot)?;
        Ok(snapshot.save()?)
    }

    /// `fmi2DeSerializeFMUstate`.
    ///
    /// # Errors
    /// [`Refusal::IllegalCall`], [`Refusal::BadState`], [`Refusal::OtherInterfaceState`].
    pub fn deserialise(&self, bytes: &[u8]) -> Result<Snapshot<M>, Refusal> {
        self.allows(Function::DeserializeFmuState)?;
        let snapshot = Snapshot::restore(bytes, &self.fresh, &self.now.identity)?;
        self.accepts(&snapshot)?;
        Ok(snapshot)
    }

    /// Checks that a state belongs to an instance of this FMU and interface.
    fn accepts(&self, snapshot: &Snapshot<M>) -> Result<(), Refusal> {
        if snapshot.identity != self.now.identity {
            return Err(Refusal::ForeignState);
        }
        let (found, interface) = (snapshot.interface, self.now.interface);
        if found != interface {
            return Err(Refusal::OtherInterfaceState { found: found.name(), interface: interface.name() });
        }
        Ok(())
    }
}
