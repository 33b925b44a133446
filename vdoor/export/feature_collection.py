"""GeoJSON text: a feature a line."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

CRS = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::3857"}}
"""What Nav2's own files say, so that map programs take the numbers as metres and not as degrees."""


def feature(kind: str, coordinates: Any, properties: Mapping[str, Any], **more: Any) -> dict[str, Any]:
    """One feature with a geometry of that kind."""
    geometry = {"type": kind, "coordinates": coordinates}
    return {"type": "Feature", **more, "properties": properties, "geometry": geometry}


def to_text(name: str, features: Iterable[Mapping[str, Any]]) -> str:
    """A collection of features as JSON, one a line."""
    head = json.dumps({"type": "FeatureCollection", "name": name, "crs": CRS})[:-1]
    lines = ",\n".join(json.dumps(item, allow_nan=False) for item in features)
    return f'{head}, "features": [\n{lines}\n]}}\n'
