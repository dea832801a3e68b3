"""One module per command of `medialbench`."""
