"""A stand-in of an Omron base's ARCL server, as a process.

    python arcl_server.py PORT PASSWORD

It speaks as the reference guide and recorded sessions have it. A line on stdin
is what `queryMotors` is answered from then on; `garbage`, `mute` and `hang up`
make it misbehave.
"""

import contextlib
import os
import socket
import sys
import threading

STATUS = (
    "ExtendedStatusForHumans: Stopped",
    "Status: Stopped",
    "DockingState: Undocked",
    "StateOfCharge: 86.0",
    "Location: 36467 13659 93",
    "LocalizationScore: 0.371681",
    "Temperature: 40",
)

state = {"answer": "Motors enabled", "connections": []}


def main() -> None:
    port, password = int(sys.argv[1]), sys.argv[2]
    server = socket.create_server(("127.0.0.1", port))
    print("ready", flush=True)
    threading.Thread(target=listen, daemon=True).start()
    while True:
        connection, _ = server.accept()
        state["connections"].append(connection)
        with contextlib.suppress(OSError), connection:
            serve(connection, password)


def listen() -> None:
    for line in sys.stdin:
        if line.strip() == "hang up":
            for connection in state["connections"]:
                with contextlib.suppress(OSError):
                    connection.shutdown(socket.SHUT_RDWR)
            state["connections"].clear()
        else:
            state["answer"] = line.strip()


def serve(connection: socket.socket, password: str) -> None:
    connection.sendall(b"Enter password:\r\n")
    lines = connection.makefile("r", newline="\n")
    if lines.readline().strip() != password:
        connection.sendall(b"Incorrect password\r\n")
        return
    connection.sendall(b"Welcome to the server.\r\nCommands:\r\n")
    connection.sendall(b"queryMotors queries the motors\r\nEnd of commands\r\n")
    for line in lines:
        command = line.strip().lower()
        if state["answer"] == "mute":
            continue
        if state["answer"] == "garbage":
            connection.sendall(os.urandom(5000).replace(b"\n", b"") + b"\r\n")
        elif command == "querymotors":
            connection.sendall(f"{state['answer']}\r\n".encode())
        elif command == "status":
            # It need not come in one piece.
            for text in STATUS:
                half = len(text) // 2
                connection.sendall(text[:half].encode())
                connection.sendall(f"{text[half:]}\r\n".encode())
        else:
            connection.sendall(f"Unknown command {command}\r\n".encode())


if __name__ == "__main__":
    main()
