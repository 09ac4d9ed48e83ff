//! Requests to web servers.

use std::time::Duration;
use ureq::Agent;

/// Creates an HTTP agent that gives up after `patience`.
///
/// The limit applies to the connection, to the whole header of the response and to each read of its body. Without it, a
/// server that sends the header byte by byte would block for ever.
pub fn agent(patience: Duration) -> Agent {
    Agent::config_builder()
        .http_status_as_error(false)
        .user_agent(concat!("fovolnet/", env!("CARGO_PKG_VERSION")))
        // Compressed on the way, positions in the file would mean nothing.
        .accept_encoding("identity")
        .timeout_connect(Some(patience))
        .timeout_recv_response(Some(patience))
        .timeout_per_read(Some(patience))
        .build()
        .into()
}
