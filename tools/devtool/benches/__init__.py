"""The measurements. Each module has ABOUT (one line), measure(quick) -> list[Result], and may have PROGRAMS and PAGE. support/ has
what they are built from."""
