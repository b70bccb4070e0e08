"""One agent: events in, effects out. No socket, clock or file is touched here."""
