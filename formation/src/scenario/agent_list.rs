//! Agents by number, as names of participants and lists of signals write them: `1,3-6`.

/// The agents (from 1) that `1,3-6` names, ascending, each once; `None` if it is no such list, or names an agent 0.
///
/// ```
/// use formation::scenario::agents_in;
///
/// assert_eq!(agents_in("1,3-6"), Some(vec![1, 3, 4, 5, 6]));
/// assert_eq!(agents_in("2"), Some(vec![2]));
/// assert_eq!(agents_in("6-3"), None);
/// ```
pub fn agents_in(text: &str) -> Option<Vec<usize>> {
    let mut agents = Vec::new();
    for part in text.split(',') {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        let (first, last) = (number(first)?, number(last)?);
        if first == 0 || first > last || last > MOST {
            return None;
        }
        agents.extend(first..=last);
    }
    agents.sort_unstable();
    agents.dedup();
    Some(agents)
}

/// No scenario has more agents than these.
const MOST: usize = 1_000_000;

fn number(text: &str) -> Option<usize> {
    let text = text.trim();
    text.bytes().all(|byte| byte.is_ascii_digit()).then(|| text.parse().ok()).flatten()
}

/// The shortest list that names these agents (from 1, ascending).
pub(crate) fn list_of(agents: &[usize]) -> String {
    let mut parts: Vec<(usize, usize)> = Vec::new();
    for &agent in agents {
        match parts.last_mut() {
            Some((_, last)) if *last + 1 == agent => *last = agent,
            _ => parts.push((agent, agent)),
        }
    }
    let text = |(first, last): &(usize, usize)| match last - first {
        0 => first.to_string(),
        1 => format!("{first},{last}"),
        _ => format!("{first}-{last}"),
    };
    parts.iter().map(text).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_and_its_shortest_form() {
        for (text, agents, short) in
            [("3", vec![3], "3"), ("6,1,4-5,5", vec![1, 4, 5, 6], "1,4-6"), (" 1 , 2 ", vec![1, 2], "1,2")]
        {
            assert_eq!(agents_in(text), Some(agents.clone()), "{text}");
            assert_eq!(list_of(&agents), short);
        }
        for wrong in ["", "0", "1,", "3-1", "a", "1-2-3", "-1", "+1", "1-9999999999"] {
            assert_eq!(agents_in(wrong), None, "{wrong}");
        }
    }
}
