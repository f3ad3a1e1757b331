"""TensorFlow's records without TensorFlow: tf.train.Example messages and the TFRecord framing."""

from __future__ import annotations

import os
import struct
from collections.abc import Mapping, Sequence

import google_crc32c
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

_Field = descriptor_pb2.FieldDescriptorProto


def _make_example_class():
    """The message classes, from the field numbers of tensorflow/core/example/*.proto.

    They get a package of their own, so that they can live beside TensorFlow in one process.
    """
    package = "engram.tf_example"
    file = descriptor_pb2.FileDescriptorProto(
        name="engram/tf_example.proto", package=package, syntax="proto3"
    )

    def add_message(name):
        return file.message_type.add(name=name)

    def add_field(message, name, number, kind, label=_Field.LABEL_OPTIONAL, type_name=None, **more):
        message.field.add(
            name=name,
            number=number,
            type=kind,
            label=label,
            type_name=type_name and f".{package}.{type_name}",
            **more,
        )

    for name, kind in (
        ("BytesList", _Field.TYPE_BYTES),
        ("FloatList", _Field.TYPE_FLOAT),
        ("Int64List", _Field.TYPE_INT64),
    ):
        add_field(add_message(name), "value", 1, kind, _Field.LABEL_REPEATED)
    feature = add_message("Feature")
    feature.oneof_decl.add(name="kind")
    for number, (name, type_name) in enumerate(
        (("bytes_list", "BytesList"), ("float_list", "FloatList"), ("int64_list", "Int64List")), 1
    ):
        add_field(feature, name, number, _Field.TYPE_MESSAGE, type_name=type_name, oneof_index=0)
    features = add_message("Features")
    entry = features.nested_type.add(name="FeatureEntry")
    entry.options.map_entry = True
    add_field(entry, "key", 1, _Field.TYPE_STRING)
    add_field(entry, "value", 2, _Field.TYPE_MESSAGE, type_name="Feature")
    add_field(
        features,
        "feature",
        1,
        _Field.TYPE_MESSAGE,
        _Field.LABEL_REPEATED,
        type_name="Features.FeatureEntry",
    )
    add_field(add_message("Example"), "features", 1, _Field.TYPE_MESSAGE, type_name="Features")

    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName(f"{package}.Example"))


_Example = _make_example_class()


def serialize_example(values: Mapping[str, Sequence]) -> bytes:
    """An Example with these features: lists of bytes, of floats, or of integers and booleans."""
    example = _Example()
    for name, items in values.items():
        feature = example.features.feature[name]
        if isinstance(items[0], bytes):
            feature.bytes_list.value.extend(items)
        elif isinstance(items[0], float):
            feature.float_list.value.extend(items)
        else:
            feature.int64_list.value.extend(items)
    serialized: bytes = example.SerializeToString(deterministic=True)
    return serialized


def parse_example(data: bytes) -> dict[str, list]:
    """The features of a serialized Example."""
    features = _Example.FromString(data).features.feature
    return {
        name: list(getattr(feature, feature.WhichOneof("kind")).value)
        for name, feature in features.items()
        if feature.WhichOneof("kind")
    }


def _masked_checksum(data: bytes) -> bytes:
    checksum = google_crc32c.value(data)
    rotated = (checksum >> 15 | checksum << 17) & 0xFFFFFFFF
    return struct.pack("<I", (rotated + 0xA282EAD8) & 0xFFFFFFFF)


def write_record(file, data: bytes) -> None:
    """Appends one record to a TFRecord file: length, its checksum, data, their checksum."""
    length = struct.pack("<Q", len(data))
    file.write(length + _masked_checksum(length) + data + _masked_checksum(data))


def read_records(file):
    """The records of a TFRecord file; raises ValueError if one is damaged."""
    while head := file.read(12):
        length = head[:8]
        if head[8:] != _masked_checksum(length):
            raise ValueError("damaged length of a record")
        (size,) = struct.unpack("<Q", length)
        if size > os.fstat(file.fileno()).st_size:
            raise ValueError("a record that is longer than its file")
        data = file.read(size)
        if file.read(4) != _masked_checksum(data):
            raise ValueError("damaged record")
        yield data
