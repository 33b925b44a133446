# vdoor as a command: docker build -t vdoor . && docker run --rm -v "$PWD:/maps" vdoor run map.yaml --out result/
FROM python:3.11-slim AS wheel
WORKDIR /source
COPY pyproject.toml README.md LICENSE ./
COPY vdoor ./vdoor
RUN pip wheel --no-cache-dir --no-deps --wheel-dir /wheels .

FROM python:3.11-slim
COPY --from=wheel /wheels /wheels
RUN pip install --no-cache-dir /wheels/*.whl && rm -r /wheels && useradd --uid 1000 --create-home vdoor
USER 1000
WORKDIR /maps
ENTRYPOINT ["vdoor"]
CMD ["--help"]
