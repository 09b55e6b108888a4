# A controller, its drivers and the stand-in, on a bare Debian with Python.
#
# Its steps, and those of compose.yaml, were run in a Debian root of debootstrap
# with its Python 3.11. The image itself was not built.
#
#   docker build -t remosplat .
#   docker compose up            # the stand-in, and a controller that rehearses
#   docker compose exec run remosplat arm --rehearsal
#
# DDS and LCM are multicast: containers share the host's network. Real-time
# priorities need --ulimit rtprio=99; compose.yaml has both.
FROM python:3.11-slim-bookworm

# Drake's VTK and rendered cameras load these.
RUN apt-get update \
 && apt-get install -y --no-install-recommends libegl1 libglib2.0-0 iproute2 \
 && rm -rf /var/lib/apt/lists/*

WORKDIR /opt/remosplat
COPY pyproject.toml README.md LICENSE ./
COPY remosplat_drake remosplat_drake
COPY models models
COPY scenarios scenarios
RUN pip install --no-cache-dir '.[ros2,ur,record,live,cockpit,robots]'

# Kernels are compiled once, here, and not when a robot waits. Where the
# simulated robot does not reach its target, the image is not built.
ENV HOME=/home/remosplat
RUN useradd --create-home remosplat && mkdir -p /work \
 && chown remosplat /work
USER remosplat
RUN remosplat run TableReach --headless
WORKDIR /work
ENTRYPOINT ["remosplat"]
CMD ["--help"]
