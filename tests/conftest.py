"""What holds for all tests."""

import signal


def pytest_configure():
    """Take Ctrl-C even where the suite was started in the background, by a shell that ignores it there."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
