//! Coupling of two axes of one vehicle in turns: proved before packing, and verified for an FMU.

use crate::axes::{Designs, inputs};
use crate::error::Error;
use squid_certificate::Certificate;
use squid_design::axis::several::level_and_heading;
use squid_design::certify::verify::same_controller;
use squid_design::check::coupled::gain::{CERTIFICATES, claim, coupling, share_of};
use squid_design::check::coupled::turn::Turning;
use squid_design::inputs::Inputs;
use squid_design::store::StoredCoupling;
use squid_fmi2::Resources;
use squid_proof::claim::{parse, text};
use squid_proof::error::ProofError;
use squid_scheduled::ControllerDesign;
use std::path::Path;

/// Bounds the coupling in turns of two certified designs, of pitch or depth and of heading, and proves the bound.
/// Returns `None` for other designs, or if no proof is found.
///
/// # Errors
/// Errors of the designs.
pub fn coupled(designs: Designs<'_>) -> Result<Option<[StoredCoupling; 2]>, Error> {
    let (Some(_), [(inputs, level), (_, heading)]) = (level_and_heading(&inputs(designs)), designs) else {
        return Ok(None);
    };
    let controllers = [&level.controller, &heading.controller];
    if !controllers.iter().all(|one| one.gamma.certified) {
        return Ok(None);
    }
    let turning = Turning::new(&inputs.six_dof, inputs.design.level(), controllers)?;
    let Some(found) = coupling(&turning)? else { return Ok(None) };
    let names = controllers.map(ControllerDesign::steered_signal);
    let claim = found.claim(names.each_ref().map(String::as_str));
    let [first, second] = [0, 1].map(|axis| {
        let certificate = text(&found.axes[axis].certificate, Path::new(CERTIFICATES[axis]))?;
        Ok::<_, Error>(StoredCoupling { certificate, claim: claim.clone() })
    });
    Ok(Some([first?, second?]))
}

/// Verifies the proof of both axes in an FMU, which may have none. With the files of the axes, recomputes that the
/// plants are those of turns of the vehicle, and the rates of these turns, and returns the claim as the first text.
/// Without the files nothing is claimed of the vehicle; the second text says so.
///
/// # Errors
/// [`ProofError`] if a certificate proves nothing, or does not belong to the controllers of the FMU.
pub fn verify(
    path: &Path,
    resources: &Resources,
    controllers: &[&ControllerDesign],
    inputs: Option<&[&Inputs]>,
) -> Result<(Option<String>, Option<String>), Error> {
    let found = CERTIFICATES.map(|name| resources.text(name).ok());
    let wrong = |what: String| Error::from(ProofError::Mismatch { what });
    let ([first, second], [Some(one), Some(other)]) = (controllers, found) else {
        return match CERTIFICATES.iter().zip(found).find(|(_, text)| text.is_some()) {
            Some((name, _)) => Err(wrong(format!("resources/{name}, without its counterpart,"))),
            None => Ok((None, None)),
        };
    };
    let both = [*first, *second];
    let proved = |axis: usize, text: &str| -> Result<(Certificate, f64), Error> {
        let file = format!("{}, resources/{}", path.display(), CERTIFICATES[axis]);
        let certificate = parse(text, &file)?;
        // The controller does not depend on the rate of turn.
        let mut lft = both[axis].lft.clone();
        lft.blocks.resize(certificate.blocks.len().max(lft.blocks.len()), 0);
        same_controller(&lft, &certificate)?;
        let gamma = certificate.prove()?.gamma.filter(|gamma| *gamma < 1.0);
        Ok((
            certificate,
            gamma.ok_or_else(|| wrong(format!("{file}: the gain, which is not proved to be below 1,")))?,
        ))
    };
    let [(one, first), (other, second)] = [proved(0, one)?, proved(1, other)?];
    let names = both.map(ControllerDesign::steered_signal);
    let (names, gains) = (names.each_ref().map(String::as_str), [first, second]);
    let Some([inputs, ..]) = inputs else {
        let unknown = format!(
            "nothing is claimed about both axes in turns without --vehicle, because the turns to which the plants of \
             {} belong, and their rates, are computed from the files of the vehicle",
            CERTIFICATES.join(" and ")
        );
        return Ok((None, Some(unknown)));
    };
    let turning = Turning::new(&inputs.six_dof, inputs.design.level(), both)?;
    let (share, taken) = share_of(&turning, [&one, &other], gains)?;
    Ok((Some(claim(turning.rates(share), (share, taken), names, gains)), None))
}
