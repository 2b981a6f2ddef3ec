# Everything from the lock, with the CPU build of torch. `make setup` passes in a bare folder; building the image is untried.
#   docker build -t snowsim . && docker run --rm -v "$PWD/results:/snowsim/results" snowsim make run
FROM python:3.11-slim
RUN apt-get update && apt-get install --yes --no-install-recommends gcc g++ git make && rm -rf /var/lib/apt/lists/*
WORKDIR /snowsim
COPY . .
RUN make setup && mkdir -p results logs && chmod a+rwx . results logs
# For `docker run --user`, whose user has no home and may not write to the environment.
ENV HOME=/tmp
ENV PATH=/snowsim/.venv/bin:$PATH
CMD ["snowsim", "--help"]
