"""What a command that was interrupted ends with."""

INTERRUPTED = 130  # as shells have it for Ctrl-C
