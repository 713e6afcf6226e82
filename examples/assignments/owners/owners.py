"""Who owns which body at the begin of a tick?   owners.py EVENTS.csv TICK

EVENTS.csv is what `padr-capture timeline` writes: time_s,tick,peer,event,entity,other,detail. Rows stand in the order in which
the capture saw them. Prints a line BODY PEER for each body that is owned.
"""

import csv
import sys


def owners(events, tick):
    """The owners of bodies, from the events before the tick. It is wrong: find out what is missing."""
    owner = {}
    for event in events:
        if int(event["tick"] or 0) < tick and event["event"] == "claim":
            owner[event["entity"]] = event["peer"]
    return owner


with open(sys.argv[1], newline="", encoding="utf-8") as file:
    for body, peer in owners(list(csv.DictReader(file)), int(sys.argv[2])).items():
        print(body, peer)
