"""The hardware station: the real robot behind the ports of every station."""
