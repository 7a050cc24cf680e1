#!/usr/bin/env python3
"""Prints the figures of bench_detection as a table: `bench_detection --benchmark_format=json | tests/bench/table.py`."""
import json
import sys

times = {}
for run in json.load(sys.stdin)["benchmarks"]:
    scene, triangles, picture, how = run["name"].split("/")[:4]
    times.setdefault((scene, int(triangles), picture), {})[how] = run["real_time"]


def cell(value, form="{:.1f}"):
    return form.format(value) if value is not None else "-"


print("| scene | triangles | picture | detail | exact | CPU reference | Embree | its rays alone | Embree / detail | exact / detail |")
print("|---|---|---|---|---|---|---|---|---|---|")
for (scene, triangles, picture), by in times.items():
    detail = by.get("detail")
    ratios = [by[how] / detail if how in by and detail else None for how in ("embree", "exact")]
    figures = [cell(by.get(how)) for how in ("detail", "exact", "cpu", "embree", "embree_rays_alone")]
    print(f"| {scene} | {triangles:,} | {picture} | " + " | ".join(figures + [cell(r, "{:.2f}") for r in ratios]) + " |")
