# docker build -t crosscut . && docker run --rm -v "$PWD:/flights" crosscut run FLIGHT.bag -o FLIGHT.jsonl
FROM rust:1.95-bookworm AS build
WORKDIR /crosscut
COPY . .
RUN cargo build --profile dist --locked -p crosscut

FROM debian:bookworm-slim
COPY --from=build /crosscut/target/dist/crosscut /usr/local/bin/
RUN ln -s crosscut /usr/local/bin/rerun-importer-crosscut
WORKDIR /flights
ENTRYPOINT ["crosscut"]
