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
    let normal = |text: &str| -> Vec<char> {
        text.chars().map(|character| if character == '-' { '_' } else { character.to_ascii_lowercase() }).collect()
    };
    if name.len() > LONGEST {
        return None;
    }
    let wanted = normal(name);
    let near = candidates.into_iter().filter(|candidate| candidate.len() <= LONGEST).filter_map(|candidate| {
        let letters = normal(candidate);
        let length = wanted.len().max(letters.len());
        let distance = distance(&wanted, &letters);
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
    nearest(name, candidates).map_or_else(String::new, |near| format!("; did you mean `{near}`?"))
}

/// Damerau-Levenshtein distance where no part is edited twice (optimal string alignment).
fn distance(a: &[char], b: &[char]) -> usize {
    let mut before_last: Vec<usize> = Vec::new();
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut current = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let replace = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            current[j] = replace.min(last[j] + 1).min(current[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                current[j] = current[j].min(before_last[j - 2] + 1);
            }
        }
        before_last = std::mem::replace(&mut last, current);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn between(a: &str, b: &str) -> usize {
        distance(&a.chars().collect::<Vec<_>>(), &b.chars().collect::<Vec<_>>())
    }

    #[test]
    fn distance_counts_edits_and_swaps() {
        assert_eq!(between("", "abc"), 3);
        assert_eq!(between("abc", ""), 3);
        assert_eq!(between("kitten", "sitting"), 3);
        assert_eq!(between("postion", "position"), 1);
        assert_eq!(between("psoition", "position"), 1);
    }

    #[test]
    fn only_near_names_are_proposed() {
        assert_eq!(nearest("posiiton", ["velocity", "position"]), Some("position"));
        assert_eq!(nearest("UAV-1", ["uav_2", "uav_1"]), Some("uav_1"));
        assert_eq!(nearest("a", ["b"]), None);
        assert_eq!(nearest("", ["b"]), None);
        assert_eq!(nearest(&"a".repeat(100_000), ["b"]), None);
    }
}
