"""What a batch wrote without how long its cases took, by which two runs of the same may differ."""

import re


def untimed(content):
    """Neither the seconds of a record and its checksum nor the times of a report."""
    return re.sub(rb' time="[0-9.]+"|"seconds": [^,]+,|(?<="sha256": )"[0-9a-f]{64}"(?=\n\}\n$)', b"", content)
