"""Our end of the wire: the real robot behind the ports of every station."""
