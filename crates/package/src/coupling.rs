//! What turns couple of two axes that fly one vehicle: proved before they are packed, and again of an FMU.

use crate::axes::{Axes, Designs};
use crate::error::Error;
use certificate::Certificate;
use fmi2::Resources;
use proof::claim::{controller_rows, first_difference, parse, text};
use proof::error::ProofError;
use scheduled::ControllerDesign;
use squid_design::certify::controller_of;
use squid_design::check::coupled::gain::{CERTIFICATES, coupling, share_of, together, up_to};
use squid_design::check::coupled::turn::Turning;
use squid_design::inputs::Inputs;
use squid_design::store::StoredCoupling;
use std::path::Path;

/// Bounds what turns couple of two designs, and proves it; nothing of one design, or if no bound below 1 is found.
///
/// # Errors
/// Those of the designs.
pub fn coupled(designs: Designs<'_>) -> Result<Option<[StoredCoupling; 2]>, Error> {
    let Some((_, heading)) = designs.heading else { return Ok(None) };
    let (inputs, level) = designs.first;
    let controllers = [&level.controller, &heading.controller];
    let Some(found) = coupling(&Turning::of(inputs, controllers))? else { return Ok(None) };
    let names = controllers.map(ControllerDesign::steered);
    let words = found.words(names.each_ref().map(String::as_str));
    let [one, other] = [0, 1].map(|axis| {
        let certificate = text(&found.axes[axis].certificate, Path::new(CERTIFICATES[axis]))?;
        Ok::<_, Error>(StoredCoupling { certificate, words: words.clone() })
    });
    Ok(Some([one?, other?]))
}

/// Proves again what an FMU has of two axes, and computes again up to which rate of turn if their files are given.
/// Nothing of an FMU that has none.
///
/// # Errors
/// [`ProofError`] of a certificate that proves nothing, or is not of the controllers of the FMU.
pub fn verify(
    path: &Path,
    resources: &Resources,
    controllers: Axes<&ControllerDesign>,
    inputs: Option<Axes<&Inputs>>,
) -> Result<Option<String>, Error> {
    let both = [controllers.first, controllers.heading.unwrap_or(controllers.first)];
    let found = CERTIFICATES.map(|name| resources.text(name).ok());
    let [Some(one), Some(other)] = found else {
        return match CERTIFICATES.iter().zip(found).find(|(_, text)| text.is_some()) {
            Some((name, _)) => {
                Err(ProofError::Mismatch { what: format!("resources/{name}, which stands alone") }.into())
            }
            None => Ok(None),
        };
    };
    let proved = |axis: usize, text: &str| -> Result<(Certificate, f64), Error> {
        let file = format!("{}, resources/{}", path.display(), CERTIFICATES[axis]);
        let certificate = parse(text, &file)?;
        let wrong = |what: String| Error::from(ProofError::Mismatch { what: format!("{file}: {what}") });
        let own = controller_rows(&controller_of(&both[axis].lft)?);
        if let Some(name) = first_difference(&own.named(), &certificate.controller.named()) {
            return Err(wrong(format!("the controller's matrix {name}")));
        }
        let gamma = certificate.prove()?.gamma.filter(|gamma| *gamma < 1.0);
        Ok((certificate, gamma.ok_or_else(|| wrong("the gain, which is not proved to be below 1".into()))?))
    };
    let [(one, first), (other, second)] = [proved(0, one)?, proved(1, other)?];
    let names = both.map(ControllerDesign::steered);
    let what = together(names.each_ref().map(String::as_str), [first, second]);
    let Some(inputs) = inputs else {
        let whose = "that these are turns of the vehicle, and how fast, --vehicle computes again";
        return Ok(Some(format!("in turns {what}; {whose}")));
    };
    let turning = Turning::of(inputs.first, both);
    let share = share_of(&turning, [&one, &other])?;
    Ok(Some(format!("in turns of up to {} {what}", up_to(turning.speeds(), turning.rates(share)?, share))))
}
