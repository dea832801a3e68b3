"""Where maps start: Eqs. 16-17, path lengths, rigid motions."""
