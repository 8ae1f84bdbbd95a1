//! Parses and checks the head of a request.

use super::limits::{MAX_HEAD_BYTES, MAX_HEADERS};

/// What there is of a request so far.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Parsed {
    /// The head is not complete yet.
    Partial,
    /// A request for a page of this server.
    Request(Target),
    /// Anything else, with the answer.
    Refused(Status, &'static str),
}

/// The pages of this server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Target {
    /// The page of the run.
    Page,
    /// The frames of the run, one event each.
    Events,
}

/// Status of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Status {
    Ok,
    BadRequest,
    Forbidden,
    NotFound,
    MethodNotAllowed,
    BodyRefused,
    HeadTooLarge,
    Busy,
}

impl Status {
    /// Its number and its words.
    pub(super) fn line(self) -> &'static str {
        match self {
            Self::Ok => "200 OK",
            Self::BadRequest => "400 Bad Request",
            Self::Forbidden => "403 Forbidden",
            Self::NotFound => "404 Not Found",
            Self::MethodNotAllowed => "405 Method Not Allowed\r\nAllow: GET",
            Self::BodyRefused => "413 Content Too Large",
            Self::HeadTooLarge => "431 Request Header Fields Too Large",
            Self::Busy => "503 Service Unavailable\r\nRetry-After: 5",
        }
    }
}

/// Parses the head of a request. `hosts` are the values of `Host` that name this server.
pub(super) fn parse(bytes: &[u8], hosts: &[String]) -> Parsed {
    let mut headers = [httparse::EMPTY_HEADER; MAX_HEADERS];
    let mut request = httparse::Request::new(&mut headers);
    match request.parse(bytes) {
        Ok(httparse::Status::Complete(_)) => judge(&request, hosts),
        Ok(httparse::Status::Partial) if bytes.len() < MAX_HEAD_BYTES => Parsed::Partial,
        Ok(httparse::Status::Partial) | Err(httparse::Error::TooManyHeaders) => {
            Parsed::Refused(Status::HeadTooLarge, "The head of a request may have 8 KiB and 64 fields.\n")
        }
        Err(_) => Parsed::Refused(Status::BadRequest, "This is not a request of HTTP/1.1.\n"),
    }
}

fn judge(request: &httparse::Request, hosts: &[String]) -> Parsed {
    let find = |name: &str| request.headers.iter().find(|header| header.name.eq_ignore_ascii_case(name));
    let is_ours = |value: &[u8]| hosts.iter().any(|host| value == host.as_bytes());
    // DNS rebinding: another site whose name points to this address must not read the page.
    if !find("Host").is_some_and(|host| is_ours(host.value)) {
        return Parsed::Refused(Status::Forbidden, "This page is for browsers on this machine.\n");
    }
    if find("Origin").is_some_and(|origin| !origin.value.strip_prefix(b"http://").is_some_and(is_ours)) {
        return Parsed::Refused(Status::Forbidden, "This page is not for pages of other sites.\n");
    }
    let has_body =
        find("Transfer-Encoding").is_some() || find("Content-Length").is_some_and(|length| length.value != b"0");
    match (has_body, request.method, request.path) {
        (true, ..) => Parsed::Refused(Status::BodyRefused, "A request has no body here.\n"),
        (_, Some("GET"), Some("/")) => Parsed::Request(Target::Page),
        (_, Some("GET"), Some("/events")) => Parsed::Request(Target::Events),
        (_, Some("GET"), _) => Parsed::Refused(Status::NotFound, "There is only one page, /.\n"),
        _ => Parsed::Refused(Status::MethodNotAllowed, "The page can only be read: use GET.\n"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(head: &str) -> Parsed {
        parse(head.as_bytes(), &["127.0.0.1:8467".into(), "localhost:8467".into()])
    }

    fn refusal(head: &str) -> Option<Status> {
        match parsed(head) {
            Parsed::Refused(status, _) => Some(status),
            _ => None,
        }
    }

    #[test]
    fn both_pages_are_found_under_both_names_of_the_server() {
        assert_eq!(parsed("GET / HTTP/1.1\r\nhost: localhost:8467\r\n\r\n"), Parsed::Request(Target::Page));
        let head = "GET /events HTTP/1.0\r\nHost: 127.0.0.1:8467\r\nOrigin: http://127.0.0.1:8467\r\n\r\n";
        assert_eq!(parsed(head), Parsed::Request(Target::Events));
        (1..head.len()).for_each(|end| assert_eq!(parsed(&head[..end]), Parsed::Partial, "{}", &head[..end]));
    }

    #[test]
    fn everything_else_is_refused_with_its_reason() {
        let with = |line: &str, fields: &str| refusal(&format!("{line}\r\nHost: localhost:8467\r\n{fields}\r\n"));
        assert_eq!(refusal("GET / HTTP/1.1\r\n\r\n"), Some(Status::Forbidden));
        assert_eq!(refusal("GET / HTTP/1.1\r\nHost: elsewhere.example\r\n\r\n"), Some(Status::Forbidden));
        for origin in ["http://elsewhere.example", "null", "https://localhost:8467"] {
            assert_eq!(with("GET / HTTP/1.1", &format!("Origin: {origin}\r\n")), Some(Status::Forbidden), "{origin}");
        }
        assert_eq!(with("GET /other HTTP/1.1", ""), Some(Status::NotFound));
        assert_eq!(with("DELETE / HTTP/1.1", ""), Some(Status::MethodNotAllowed));
        assert_eq!(with("POST / HTTP/1.1", "Content-Length: 5\r\n"), Some(Status::BodyRefused));
        assert_eq!(with("GET / HTTP/1.1", "Transfer-Encoding: chunked\r\n"), Some(Status::BodyRefused));
        assert_eq!(refusal("\u{16}\u{3}\u{1} TLS"), Some(Status::BadRequest));
        let endless: String =
            (0..300).map(|number| format!("X-{number}: and so on and so forth and so on\r\n")).collect();
        assert_eq!(refusal(&format!("GET / HTTP/1.1\r\n{endless}")), Some(Status::HeadTooLarge));
        assert_eq!(
            refusal(&format!("GET / HTTP/1.1\r\nX: {}", "y".repeat(MAX_HEAD_BYTES))),
            Some(Status::HeadTooLarge)
        );
    }
}
