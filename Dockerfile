# The environment of requirements.lock as a container, from a clone:
#   docker build --tag foggy-synscapes .
#   docker run --rm --volume "$PWD:/work" foggy-synscapes foggy --help
#   docker run --rm --volume "$PWD:/work" foggy-synscapes snakemake --cores 2
# Not built so far: it was checked by hadolint alone.
FROM python:3.11-slim-bookworm

# A C compiler, for packages without a wheel; git, which DVC calls. Versions are those of the release that the image is of.
# hadolint ignore=DL3008
RUN apt-get update \
    && apt-get install --no-install-recommends --yes gcc libc6-dev git make \
    && rm -rf /var/lib/apt/lists/*

WORKDIR /opt/foggy-synscapes
COPY requirements.lock requirements-hashes.lock ./
# The build of PyTorch for CPUs; for CUDA: docker build --build-arg TORCH_INDEX=https://download.pytorch.org/whl/cu130 ...
ARG TORCH_INDEX=https://download.pytorch.org/whl/cpu
RUN pip install --no-cache-dir --no-deps --require-hashes -r requirements-hashes.lock \
    && pip install --no-cache-dir --extra-index-url "$TORCH_INDEX" -r requirements.lock
COPY pyproject.toml LICENSE README.md ./
COPY src src
RUN pip install --no-cache-dir --no-deps . \
    && useradd --create-home --uid 1000 foggy

# The folder with params.yaml, Snakefile and results is the clone that is given by --volume.
USER 1000
WORKDIR /work
CMD ["foggy", "--help"]
