"""How long a tick, a query and a look ahead take on this machine."""
