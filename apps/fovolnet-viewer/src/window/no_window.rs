//! Messages for a window that cannot be opened.

/// Error message with advice for `error`, which prevented the window.
pub fn explained(error: &eframe::Error) -> String {
    match error {
        eframe::Error::AppCreation(cause) => cause.to_string(),
        eframe::Error::WinitEventLoop(cause) => without_display(&cause.to_string()),
        other => without_driver(&other.to_string()),
    }
}

fn without_display(cause: &str) -> String {
    format!(
        "no window can be opened, there is no display ({}); without one, `xvfb-run -a fovolnet-viewer …` gives it one (Debian: \
         apt install xvfb xauth), and `fovolnet render` needs none",
        reason(cause)
    )
}

fn without_driver(cause: &str) -> String {
    format!(
        "no window can be opened ({}); install a Vulkan, Metal or DirectX 12 driver (Debian: apt install mesa-vulkan-drivers \
         libxkbcommon-x11-0), or use `fovolnet render`, which needs none",
        reason(cause)
    )
}

/// Removes a library's source position from the beginning of `cause`.
fn reason(cause: &str) -> &str {
    let place = cause.strip_prefix("os error at ").and_then(|rest| rest.split_once(".rs:"));
    let said = place.and_then(|(_, line)| line.split_once(": ")).map_or(cause, |(_, said)| said);
    said.trim().trim_end_matches('.')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_in_libraries_are_left_out() {
        let cause = "os error at /home/somebody/winit-0.30/src/mod.rs:765: neither A nor B is set.";
        assert_eq!(reason(cause), "neither A nor B is set");
        assert_eq!(reason("not supported"), "not supported");
        assert!(without_display(cause).contains("(neither A nor B is set)"));
    }
}
