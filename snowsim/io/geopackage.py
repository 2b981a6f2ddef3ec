"""Writes tables with lines on a map as GeoPackage."""

import struct

import numpy as np

from snowsim.io.files import written_whole

# Codes of the format well-known binary.
LITTLE_ENDIAN = 1
LINE_STRING = 2


def write_lines(path, rows):
    """Write a table as GeoPackage, whole or not at all.

    Its column `line` becomes the geometry: arrays (point, 2) of longitude and latitude [degrees,
    WGS 84]. Needs pyogrio.
    """
    try:
        from pyogrio import raw
    except ImportError as error:
        msg = "a GeoPackage needs pyogrio: pip install 'snowsim[gis]'"
        raise ValueError(msg) from error
    fields = rows.drop(columns="line")
    with written_whole(path) as aside:
        raw.write(
            aside,
            layer="accumulation",
            geometry=np.array([_well_known_binary(line) for line in rows["line"]], dtype=object),
            field_data=[fields[name].to_numpy() for name in fields],
            fields=np.array(fields.columns, dtype=object),
            geometry_type="LineString",
            crs="EPSG:4326",
            driver="GPKG",
        )


def _well_known_binary(line):
    """Well-known binary of a line (point, 2), longitude and latitude; a single point is doubled."""
    line = np.repeat(line, 2, axis=0) if len(line) == 1 else line
    head = struct.pack("<BII", LITTLE_ENDIAN, LINE_STRING, len(line))
    return head + np.ascontiguousarray(line, dtype="<f8").tobytes()
