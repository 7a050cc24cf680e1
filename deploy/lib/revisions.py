#!/usr/bin/env python3
"""Prints three revisions of a station's run, a line each: the first, the last before the pause in the middle of the
recording (the box was moved in it), and the last. Without a pause the second is the last."""
import json
import sys

PAUSE_S = 1.0

with open(sys.argv[1]) as file:
    events = [json.loads(line) for line in file]
first = next(e["revision"] for e in events if e["event"] == "serving")
present, before_pause, last_time = first, None, None
for event in events:
    if event["event"] == "frame":
        if last_time is not None and event["timestamp"] - last_time > PAUSE_S and before_pause is None:
            before_pause = present
        last_time = event["timestamp"]
    elif event["event"] == "revision":
        present = event["revision"]
print(first, present if before_pause is None else before_pause, present, sep="\n")
