# docker build -t crosscut . && docker run --rm -v "$PWD:/flights" crosscut run FLIGHT.bag -o FLIGHT.jsonl
FROM rust:1.95-bookworm AS build
WORKDIR /crosscut
COPY . .
RUN cargo build --profile dist --locked -p crosscut

FROM debian:bookworm-slim
COPY --from=build /crosscut/target/dist/crosscut /crosscut/target/dist/rerun-importer-crosscut /usr/local/bin/
WORKDIR /flights
ENTRYPOINT ["crosscut"]
