"""Reads a log with the MCAP project's own library, and checks every message against its schema.

Prints what it found as JSON; exits with 1 and a sentence if something is wrong.
Needs the packages mcap and jsonschema from PyPI. Called by tests/independent_reader.rs.
"""

import json
import sys

import jsonschema
from mcap.reader import make_reader


def main(path):
    topics, units = {}, []
    validators = {}
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        for schema, channel, message in reader.iter_messages():
            if schema.encoding != "jsonschema" or channel.message_encoding != "json":
                sys.exit(f"{channel.topic}: expected JSON with a JSON Schema")
            if schema.id not in validators:
                parsed = json.loads(schema.data)
                jsonschema.Draft202012Validator.check_schema(parsed)
                validators[schema.id] = jsonschema.Draft202012Validator(parsed)
            content = json.loads(message.data)
            for error in validators[schema.id].iter_errors(content):
                where = "/".join(str(part) for part in error.absolute_path)
                sys.exit(f"{channel.topic}, message {message.sequence}, {where}: {error.message}")
            entry = topics.setdefault(channel.topic, {"schema": schema.name, "messages": 0})
            entry["messages"] += 1
        attachments = [
            {"name": attachment.name, "bytes": len(attachment.data)}
            for attachment in reader.iter_attachments()
        ]
        metadata = {record.name: dict(record.metadata) for record in reader.iter_metadata()}
    counted = {}
    for channel_id, count in summary.statistics.channel_message_counts.items():
        counted[summary.channels[channel_id].topic] = count
    print(json.dumps({
        "topics": topics, "counted": counted, "attachments": attachments, "metadata": metadata,
    }))


main(sys.argv[1])
