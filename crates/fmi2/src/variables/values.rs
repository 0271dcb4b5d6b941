//! The four value types of the C functions.

use crate::variables::role::{Get, Set};
use crate::variables::variable::Access;
use crate::{Function, Refusal};

/// A type that `fmi2GetXXX` and `fmi2SetXXX` exchange.
pub trait Value: Sized {
    /// Name in the standard.
    const NAME: &'static str;
    /// Function that reads values of the type.
    const GET: Function;
    /// Function that writes values of the type.
    const SET: Function;

    /// Returns getter and setter, if the variable is of this type.
    #[doc(hidden)]
    #[allow(clippy::type_complexity)]
    fn reach<M>(access: &Access<M>) -> Option<(&Get<M, Self>, Option<&Set<M, Self>>)>;

    /// Returns the value, if it is a number that is not finite.
    #[doc(hidden)]
    fn undefined(&self) -> Option<f64> {
        None
    }

    /// Checks that the variable can have the value.
    #[doc(hidden)]
    fn check<M>(&self, _name: &str, _access: &Access<M>) -> Result<(), Refusal> {
        Ok(())
    }
}

impl Value for f64 {
    const NAME: &'static str = "Real";
    const GET: Function = Function::GetReal;
    const SET: Function = Function::SetReal;

    fn reach<M>(access: &Access<M>) -> Option<(&Get<M, Self>, Option<&Set<M, Self>>)> {
        match access {
            Access::Real(get, set) => Some((get, set.as_ref())),
            _ => None,
        }
    }

    fn undefined(&self) -> Option<f64> {
        (!self.is_finite()).then_some(*self)
    }

    fn check<M>(&self, name: &str, _: &Access<M>) -> Result<(), Refusal> {
        match self.undefined() {
            Some(value) => Err(Refusal::NotFinite { name: name.to_owned(), value }),
            None => Ok(()),
        }
    }
}

impl Value for i32 {
    const NAME: &'static str = "Integer";
    const GET: Function = Function::GetInteger;
    const SET: Function = Function::SetInteger;

    fn reach<M>(access: &Access<M>) -> Option<(&Get<M, Self>, Option<&Set<M, Self>>)> {
        match access {
            Access::Integer(get, set) | Access::Enumeration(get, set, _) => Some((get, set.as_ref())),
            _ => None,
        }
    }

    fn check<M>(&self, name: &str, access: &Access<M>) -> Result<(), Refusal> {
        match access {
            Access::Enumeration(_, _, last) if !(1..=*last).contains(self) => {
                Err(Refusal::NoSuchItem { name: name.to_owned(), value: *self, last: *last })
            }
            _ => Ok(()),
        }
    }
}

impl Value for bool {
    const NAME: &'static str = "Boolean";
    const GET: Function = Function::GetBoolean;
    const SET: Function = Function::SetBoolean;

    fn reach<M>(access: &Access<M>) -> Option<(&Get<M, Self>, Option<&Set<M, Self>>)> {
        match access {
            Access::Boolean(get, set) => Some((get, set.as_ref())),
            _ => None,
        }
    }
}

impl Value for String {
    const NAME: &'static str = "String";
    const GET: Function = Function::GetString;
    const SET: Function = Function::SetString;

    fn reach<M>(access: &Access<M>) -> Option<(&Get<M, Self>, Option<&Set<M, Self>>)> {
        match access {
            Access::String(get, set) => Some((get, set.as_ref())),
            _ => None,
        }
    }
}
