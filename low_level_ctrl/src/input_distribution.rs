//! The control input distribution algorithm (CIDA) of section 5.3: how much of the consensus part of an input fits beside the
//! part that keeps an agent on its reference.

use formation::nalgebra::SVector;

/// ξ̄, the largest share in [0, 1] of `consensus` with which `maintenance + share * consensus` stays within `[-limit, limit]`.
///
/// The share is one for all channels, so the consensus part keeps its direction, which clipping each channel would turn.
/// `maintenance` itself has to be within the limit.
pub fn consensus_share<const D: usize>(maintenance: &SVector<f64, D>, consensus: &SVector<f64, D>, limit: f64) -> f64 {
    let mut share: f64 = 1.0;
    let saturated = (maintenance + consensus).iter().any(|input| input.abs() > limit);
    if !saturated {
        return share;
    }
    for (keep, ask) in maintenance.iter().zip(consensus.iter()) {
        if *ask > 0.0 {
            share = share.min((limit - keep) / ask);
        } else if *ask < 0.0 {
            share = share.min((-limit - keep) / ask);
        }
    }
    share
}

#[cfg(test)]
mod tests {
    use super::*;
    use formation::nalgebra::Vector3;
    use proptest::prelude::*;

    fn vector(range: f64) -> impl Strategy<Value = Vector3<f64>> {
        proptest::array::uniform3(-range..range).prop_map(Vector3::from)
    }

    proptest! {
        #[test]
        fn the_input_stays_within_the_limit(keep in vector(0.23), ask in vector(20.0)) {
            let share = consensus_share(&keep, &ask, 0.25);
            prop_assert!((0.0..=1.0).contains(&share));
            prop_assert!((keep + share * ask).amax() <= 0.25 + 1e-12);
        }

        #[test]
        fn a_larger_share_would_not_fit(keep in vector(0.23), ask in vector(20.0)) {
            let share = consensus_share(&keep, &ask, 0.25);
            prop_assert!(share == 1.0 || (keep + (share + 1e-6) * ask).amax() > 0.25);
        }

        #[test]
        fn what_fits_is_left_alone(keep in vector(0.1), ask in vector(0.1)) {
            prop_assert_eq!(consensus_share(&keep, &ask, 0.25), 1.0);
        }
    }
}
