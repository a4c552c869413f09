"""Results as an MCAP, by the schema library of Foxglove, Python's MCAP readers and a validator of JSON Schema."""

import json
import math

import jsonschema
import numpy as np
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory as Protobuf
from mcap_ros2.decoder import DecoderFactory as Ros2

from flights import Flights
from program import lines
from verdicts import Verdicts

# Drawings are compared with the scans for every so many of them.
EVERY = 8


def check(flights: Flights, verdicts: Verdicts):
    for flight in [flights.shipped()[0], *flights.real()[:1]]:
        out = flights.work / f"{flight.name}-answers.mcap"
        expected = lines(flights.crosscut("run", flight.path, "--out", "-", "--quiet").stdout)
        flights.crosscut("run", flight.path, "--out", out, "--quiet").expect(0)
        found: dict[str, list] = {}
        validator = None
        with out.open("rb") as file:
            for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages():
                if channel.message_encoding == "protobuf":
                    scene = SceneUpdate.FromString(message.data)
                    decoded = Protobuf().decoder_for(channel.message_encoding, schema)(message.data)
                    value = (scene, decoded, not unknown_fields(scene))
                elif channel.message_encoding == "json":
                    value = json.loads(message.data)
                    validator = validator or jsonschema.Draft202012Validator(json.loads(schema.data))
                    validator.validate(value)
                else:
                    value = Ros2().decoder_for(channel.message_encoding, schema)(message.data)
                found.setdefault(channel.topic, []).append(value)
        what = f"results as an MCAP, {flight.name}"
        verdicts.that(found["/crosscut/results"] == expected, f"{what}: lines", f"{len(expected)} equal, valid by their schema")
        scans = found["/scan"]
        verdicts.that(len(scans) == len(expected), f"{what}: scans", f"{len(scans)}")
        scenes = found["/crosscut/scene"]
        same = all(str(scene) == str(decoded) and known for scene, decoded, known in scenes)
        verdicts.that(same, f"{what}: drawings", f"{len(scenes)} read alike by Foxglove's schemas and by the file's own")
        verdicts.that(len(scenes) == len(expected), f"{what}: number of drawings", f"{len(scenes)} for {len(expected)} lines")
        some = list(zip(scenes, expected, scans))[::EVERY]
        wrong = sum(not fits(scene, line, scan) for (scene, *_), line, scan in some)
        verdicts.that(wrong == 0, f"{what}: drawn walls and openings", f"{wrong} of {len(some)} differ from the line and the scan")


def unknown_fields(message) -> bool:
    from google.protobuf.unknown_fields import UnknownFieldSet

    return len(UnknownFieldSet(message)) > 0 or any(
        unknown_fields(part)
        for field, value in message.ListFields()
        if field.message_type
        for part in (value if field.is_repeated else [value])
    )


def fits(scene, line: dict, scan) -> bool:
    """An arrow along each opening, and every corner of a line on a return of the scan."""
    (entity,) = scene.entities
    bearings = sorted(2 * math.atan2(arrow.pose.orientation.z, arrow.pose.orientation.w) for arrow in entity.arrows)
    openings = sorted(opening["bearing_rad"] for opening in line["openings"])
    if not np.allclose(bearings, openings, atol=1e-9):
        return False
    angles = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    places = np.c_[scan.ranges * np.cos(angles), scan.ranges * np.sin(angles)]
    places = places[np.array(line["labels"]) >= 0]
    corners = np.array([(point.x, point.y) for drawn in entity.lines for point in drawn.points])
    off_m = [np.min(np.hypot(*(places - corner).T)) for corner in corners[::7]]
    return max(off_m, default=0.0) < 1e-3 and entity.texts[0].text.startswith(f"{line['junctions']} wall")
