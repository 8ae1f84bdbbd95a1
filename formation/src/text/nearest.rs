//! The name that was probably meant.

/// The candidate nearest to `name`, if any is near enough to be a slip of the pen: about one letter in three may be
/// wrong, missing, superfluous or swapped with its neighbour. Case, and `-` for `_`, do not count.
///
/// ```
/// use formation::config::nearest;
/// assert_eq!(nearest("c_q", ["lam_p", "c_p", "k_p"]), Some("c_p"));
/// assert_eq!(nearest("mass", ["lam_p", "c_p", "k_p"]), None);
/// ```
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // Longer than any name; the distance takes time with the square of the length.
    const LONGEST: usize = 64;
    let normal = |text: &str| text.replace('-', "_").to_ascii_lowercase();
    if name.len() > LONGEST {
        return None;
    }
    let wanted = normal(name);
    let near = candidates.into_iter().filter(|candidate| candidate.len() <= LONGEST).filter_map(|candidate| {
        let candidate_name = normal(candidate);
        let length = wanted.chars().count().max(candidate_name.chars().count());
        let distance = strsim::osa_distance(&wanted, &candidate_name);
        (distance <= (length / 3).max(1) && distance < length).then_some((distance, candidate))
    });
    near.min_by_key(|&(distance, _)| distance).map(|(_, candidate)| candidate)
}

/// The end of a message about an unknown name: `` "; did you mean `c_p`?" ``, or nothing if no candidate is near.
///
/// ```
/// use formation::config::did_you_mean;
/// assert_eq!(did_you_mean("c_q", ["lam_p", "c_p", "k_p"]), "; did you mean `c_p`?");
/// assert_eq!(did_you_mean("mass", ["lam_p", "c_p", "k_p"]), "");
/// ```
pub fn did_you_mean<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    suggestion(nearest(name, candidates))
}

/// The same for a name that was found already.
pub(crate) fn suggestion(near: Option<&str>) -> String {
    near.map_or_else(String::new, |near| format!("; did you mean `{near}`?"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_near_names_are_proposed() {
        // Swapped, missing and wrong letters.
        for slip in ["posiiton", "psoition", "postion", "posidion"] {
            assert_eq!(nearest(slip, ["velocity", "position"]), Some("position"), "{slip}");
        }
        assert_eq!(nearest("UAV-1", ["uav_2", "uav_1"]), Some("uav_1"));
        assert_eq!(nearest("a", ["b"]), None);
        assert_eq!(nearest("", ["b"]), None);
        assert_eq!(nearest(&"a".repeat(100_000), ["b"]), None);
    }

    #[test]
    fn a_third_of_the_letters_may_be_wrong_and_no_more() {
        assert_eq!(nearest("gumme", ["gamma"]), None);
        assert_eq!(nearest("limbeo", ["lambda"]), None);
        assert_eq!(nearest("limbdo", ["lambdo", "lambda"]), Some("lambdo"));
        assert_eq!(nearest("limbda", ["lambda"]), Some("lambda"));
        assert_eq!(nearest("limbdo", ["lambda"]), Some("lambda"));
    }
}
